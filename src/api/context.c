// SPDX-License-Identifier: Apache-2.0
#include "api/api.h"

#include "core/bridge.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/engine.h"
#include "glare/model/model.h"
#include "tone/tone.h"

#include <dirent.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *glarepp_version(void)
{
    return GP_VERSION;
}

// -- messages -----------------------------------------------------------------

/* The last error of a thread. */
struct last {
    char parameter[64], text[GP_LINE_BYTES];
    int status;
};
static _Thread_local struct last last;

const struct glarepp_message *glarepp_error(void)
{
    static _Thread_local struct glarepp_message m;
    m = (struct glarepp_message) {
        .level = GLAREPP_ERROR, .status = last.status,
        .parameter = last.parameter, .text = last.text,
    };
    return &m;
}

void gp_api_note(gp_status status, const char *parameter, const char *text)
{
    last.status = (int) status;
    snprintf(last.parameter, sizeof last.parameter, "%s", parameter);
    snprintf(last.text, sizeof last.text, "%s", text);
}

static void receive(void *user, const struct gp_line *line)
{
    const struct gp_api_sink *const sink = user;
    const struct glarepp_params *const p = &sink->gp->params;
    const bool bare = line->level == GP_LEVEL_BARE;
    char named[GP_LINE_BYTES];
    struct glarepp_message m = {
        .level = bare ? GLAREPP_ERROR : (enum glarepp_level) line->level,
        .status = (int) line->status, .parameter = line->parameter,
        .text = line->text, .bare = bare && !sink->name,
        .user = sink->user,
    };
    if (bare && sink->name) {
        snprintf(named, sizeof named, "%s: %s", sink->name, line->text);
        gp_make_printable(named);
        m.text = named;
    }
    if (m.level == GLAREPP_ERROR && !*m.parameter)
        m.parameter = gp_api_about(NULL);
    if (m.level == GLAREPP_ERROR)
        gp_api_note(line->status, m.parameter, m.text);
    if (p->message)
        p->message(p->user, &m);
}

struct gp_log gp_api_log(struct gp_api_sink *sink)
{
    return (struct gp_log) {
        receive, sink, (enum gp_level) sink->gp->params.level};
}

// -- calls --------------------------------------------------------------------

/* Contexts that this thread has entered, the last one first: only calls of
 * another context within a callback make it more than one. */
static _Thread_local struct glarepp *inside;

struct glarepp *gp_api_begin(struct glarepp *gp)
{
    struct glarepp *const outer = inside;
    gp_api_about("");
    gp_env_use(&gp->env);
    if (outer != gp)
        gp_parallel_enter();
    inside = gp;
    return outer;
}

int gp_api_end(struct glarepp *outer, gp_status st)
{
    if (outer != inside)
        gp_parallel_leave();
    inside = outer;
    gp_env_use(outer ? &outer->env : NULL);
    return (int) st;
}

void glarepp_leave(const struct glarepp *gp)
{
    if (inside == gp)
        (void) gp_api_end(NULL, GP_OK);
}

void glarepp_enter(struct glarepp *gp)
{
    if (inside != gp)
        glarepp_leave(inside);
    (void) gp_api_begin(gp);
}

// -- contexts -----------------------------------------------------------------

/* Replaces strings of the parameters by copies that the context owns. */
static gp_status keep_texts(const struct gp_log *log, struct glarepp *gp)
{
    struct glarepp_params *const p = &gp->params;
    const char **const text[] = {&p->data, &p->bridges, &p->osmesa, &p->egl};
    for (int i = 0; i < 4; i++) {
        if (!*text[i])
            continue;
        *text[i] = gp->text[i] = gp_strdup(*text[i]);
        if (!gp->text[i])
            return gp_no_memory_bare(log, "context");
    }
    return GP_OK;
}

int glarepp_open(const struct glarepp_params *p, struct glarepp **out)
{
    struct glarepp_params own = GLAREPP_PARAMS;
    struct glarepp *gp = NULL, first = {.params = own, .sink.gp = &first};
    gp_status st;
    *out = NULL;
    first.log = gp_api_log(&first.sink);
    GP_TRY(gp_api_params(&first.log, "params", &own, sizeof own, p));
    first.params = own;
    first.log = gp_api_log(&first.sink);
    GP_TRY(gp_alloc_zero(&first.log, "context", 1, sizeof *gp, &gp));
    gp->sink.gp = gp;
    gp->params = own;
    gp->log = gp_api_log(&gp->sink);
    if (own.keep_memory)
        gp_keep_memory(true);
    GP_TRY(keep_texts(&gp->log, gp));
    gp->env = (struct gp_env) {
        .bridges = gp->params.bridges, .data = gp->params.data,
        .osmesa = gp->params.osmesa, .egl = gp->params.egl,
        .gl_size = own.gl_size,
        .locale = newlocale(LC_ALL_MASK, "C", (locale_t) 0),
    };
    if (!gp->env.locale)
        GP_TRY(gp_no_memory_bare(&gp->log, "context"));
    GP_TRY(gp_pool_make(&gp->log, own.threads, &gp->env.pool));
    *out = gp;
    gp = NULL;
out:
    glarepp_close(&gp);
    return (int) st;
}

void glarepp_close(struct glarepp **context)
{
    struct glarepp *const gp = *context;
    if (!gp)
        return;
    gp_pool_free(&gp->env.pool);
    if (gp->env.locale)
        freelocale(gp->env.locale);
    for (int i = 0; i < 4; i++)
        free(gp->text[i]);
    for (int i = 0; i < 2; i++) {
        for (int k = 0; k < gp->names[i]; k++)
            free(gp->list[i][k]);
        free(gp->list[i]);
    }
    if (gp->params.keep_memory)
        gp_keep_memory(false);
    GP_FREE(*context);
}

// -- lists --------------------------------------------------------------------

static int is_json(const struct dirent *d)
{
    const char *const end = strrchr(d->d_name, '.');
    return d->d_name[0] != '.' && end && strcmp(end, ".json") == 0;
}

/* Returns the i-th file of an installed folder, without its ending; the context
 * keeps the list. */
static const char *installed(struct glarepp *gp, const char *name, int which,
                             int i)
{
    struct dirent ***const list = &gp->list[which];
    char folder[PATH_MAX];
    if (!*list) {
        const struct gp_env *const before = gp_env_use(&gp->env);
        gp->names[which] = gp_example_find(name, folder, sizeof folder)
                               ? scandir(folder, list, is_json, alphasort)
                               : 0;
        gp_env_use(before);
        for (int k = 0; k < gp->names[which]; k++)
            *strrchr((*list)[k]->d_name, '.') = '\0';
    }
    return i < gp->names[which] ? (*list)[gp_max(i, 0)]->d_name : NULL;
}

const char *glarepp_name(struct glarepp *gp, enum glarepp_list list, int i,
                         const char **text)
{
    const char *name = NULL, *line = NULL;
    int n = 0;
    switch (list) {
    case GLAREPP_ENGINES:
        while (n < i && gp_engines[n])
            n++;
        name = gp_engines[n] ? gp_engines[n]->name : NULL;
        line = name ? gp_engines[n]->text : NULL;
        break;
    case GLAREPP_CURVES:
        while (n < i && gp_tone_curves[n])
            n++;
        name = gp_tone_curves[n] ? gp_tone_curves[n]->name : NULL;
        line = name ? gp_tone_curves[n]->text : NULL;
        break;
    case GLAREPP_MODELS:
    case GLAREPP_MODEL_SOURCES:
        while (n < i && gp_models[n])
            n++;
        name = gp_models[n] ? gp_models[n]->name : NULL;
        if (name)
            line = list == GLAREPP_MODELS ? gp_models[n]->text
                                          : gp_models[n]->source;
        break;
    case GLAREPP_PRESETS:
    case GLAREPP_PRESET_RECIPES:
        while (n < i && gp_model_presets[n].name)
            n++;
        name = gp_model_presets[n].name;
        if (name)
            line = list == GLAREPP_PRESETS ? gp_model_presets[n].text
                                           : gp_model_presets[n].recipe;
        break;
    case GLAREPP_FLARES:
        name = gp ? installed(gp, "flares", 0, i) : NULL;
        break;
    case GLAREPP_LENSES:
        name = gp ? installed(gp, "lenses", 1, i) : NULL;
        break;
    }
    if (text)
        *text = line;
    return name;
}

bool glarepp_key(int model, int k, struct glarepp_key *out)
{
    int n = 0;
    while (n < model && gp_models[n])
        n++;
    if (model < 0 || !gp_models[n])
        return false;
    const struct gp_model_key *key = gp_models[n]->keys;
    for (; k > 0 && key->name; k--)
        key++;
    const bool file = gp_model_key_is_file(key);
    *out = (struct glarepp_key) {
        .name = key->name, .text = key->text, .preset = key->preset,
        .lo = key->lo, .hi = key->hi, .words = file ? NULL : key->words,
        .file = file,
    };
    return key->name != NULL;
}
