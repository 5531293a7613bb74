// SPDX-License-Identifier: Apache-2.0
/* Recipes: MODEL:key=value,key=value and the names of some. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const struct gp_model *const gp_models[] = {
    &gp_model_spencer, &gp_model_cie, &gp_model_aperture,
    &gp_model_temporal,
    &gp_model_star, &gp_model_cross, &gp_model_streak, &gp_model_ring,
    &gp_model_circle, &gp_model_gaussian, &gp_model_moffat,
    &gp_model_halation, &gp_model_image,
    NULL,
};

const struct gp_model_preset gp_model_presets[] = {
    {"eye", "spencer", "the human eye in daylight (Spencer et al. 1995)"},
    {"eye-night", "spencer:light=mesopic,needles=200", "the eye at night, with "
     "its halo and the needles of its corona"},
    {"eye-old", "cie:age=70", "the eye of a 70-year-old (CIE 135/1)"},
    {"star", "star", "six rays of a stop with six blades, redder far out"},
    {"cross", "cross", "four rays of a cross screen filter"},
    {"streak", "streak", "the blue horizontal streak of an anamorphic lens"},
    {"ring", "ring", "a corona of small drops: an aureole and rings"},
    {"circle", "circle", "a lamp and a faint disc around it, as out of focus"},
    {0},
};

/* Text up to `end` equals a whole name. */
static bool is_name(const char *name, const char *text, const char *end)
{
    return strlen(name) == (size_t) (end - text) &&
           memcmp(name, text, strlen(name)) == 0;
}

static const struct gp_model *find_model(const char *text, const char *end)
{
    for (int i = 0; gp_models[i]; i++) {
        if (is_name(gp_models[i]->name, text, end))
            return gp_models[i];
    }
    return NULL;
}

static const struct gp_model_preset *find_preset(const char *text,
                                                 const char *end)
{
    for (int i = 0; gp_model_presets[i].name; i++) {
        if (is_name(gp_model_presets[i].name, text, end))
            return &gp_model_presets[i];
    }
    return NULL;
}

static const char builtin[] = "builtin:";

bool gp_recipe_is(const char *text)
{
    const char *const end = text + strcspn(text, ":");
    return strncmp(text, builtin, strlen(builtin)) == 0 ||
           find_model(text, end) || find_preset(text, end);
}

// -- messages -----------------------------------------------------------------

enum { SHOWN = 72 }; // bytes of a text, which may be long

/* A text of a recipe for messages, cut where it is long. */
struct shown {
    char text[SHOWN + 8];
};

static struct shown show(const char *text, size_t length)
{
    struct shown s;
    size_t n = 0;
    while (n < length && text[n] && n + 4 <= SHOWN) {
        const size_t bytes = gp_utf8_bytes(text + n);
        n += bytes ? bytes : 1;
    }
    n = n < length ? n : length;
    snprintf(s.text, sizeof s.text, "%.*s%s", (int) n, text,
             n < length && text[n] ? "..." : "");
    return s;
}

/* Names that there are, and the nearest to the one that was found. */
struct names {
    char list[1024];
    struct gp_nearest near;
};

static struct names names_for(const char *found, const char *end)
{
    return (struct names) {
        .near = gp_nearest_to(found, (size_t) (end - found), 2),
    };
}

static void add_name(struct names *n, const char *name)
{
    const size_t used = strlen(n->list);
    snprintf(n->list + used, sizeof n->list - used, "%s%s", used ? ", " : "",
             name);
    gp_nearest_try(&n->near, name);
}

static gp_status no_such(const struct gp_log *log, const char *text,
                         const char *what, const struct names *n)
{
    char near[80] = "";
    if (n->near.name)
        snprintf(near, sizeof near, "did you mean %s? ", n->near.name);
    return gp_fail(log, GP_ERR_USAGE, "%s: no %s has the name \"%s\"; %sgive "
                   "one of %s", show(text, SIZE_MAX).text, what,
                   show(n->near.word, n->near.length).text, near, n->list);
}

// -- parsing ------------------------------------------------------------------

static gp_status read_value(const struct gp_log *log, const char *text,
    const struct gp_model_key *key, const char *from, const char *end,
    double *out)
{
    const size_t length = (size_t) (end - from);
    if (key->words) {
        struct names n = names_for(from, end);
        for (int i = 0; key->words[i]; i++) {
            if (is_name(key->words[i], from, end)) {
                *out = i;
                return GP_OK;
            }
            add_name(&n, key->words[i]);
        }
        return no_such(log, text, key->name, &n);
    }
    char *stop = NULL;
    *out = length ? strtod(from, &stop) : NAN;
    if (length && !strchr(" \t\n\v\f\r", *from) && stop == end &&
        *out >= key->lo && *out <= key->hi)
        return GP_OK;
    return gp_fail(log, GP_ERR_USAGE, "%s: %s is no number from %g to %g (found "
                   "\"%s\"); give one", show(text, SIZE_MAX).text, key->name,
                   key->lo, key->hi, show(from, length).text);
}

/* Length of a file's name up to the next comma without a backslash. */
static size_t name_length(const char *s)
{
    size_t n = 0;
    while (s[n] && s[n] != ',')
        n += s[n] == '\\' && s[n + 1] ? 2 : 1;
    return n;
}

/* Reads a file's name; a backslash stands before a comma or backslash of it. */
static gp_status read_name(const struct gp_log *log, const char *from,
                           size_t length, char **out)
{
    char *name;
    gp_status st = gp_alloc_zero(log, "recipe", length + 1, 1, &name);
    if (st)
        return st;
    for (size_t i = 0, n = 0; i < length; i++) {
        if (from[i] == '\\' && i + 1 < length)
            i++;
        name[n++] = from[i];
    }
    gp_free(*out);
    *out = name;
    return GP_OK;
}

/* Reads "key=value,key=value" over what `r` has; `text` is for messages. */
static gp_status read_keys(const struct gp_log *log, const char *text,
                           const char *keys, struct gp_recipe *r)
{
    bool given[GP_MODEL_KEYS] = {false};
    while (*keys) {
        const char *end = keys + strcspn(keys, ",");
        const char *const name_end = keys + strcspn(keys, "=,");
        struct names n = names_for(keys, name_end);
        int i = 0;
        while (r->model->keys[i].name &&
               !is_name(r->model->keys[i].name, keys, name_end))
            add_name(&n, r->model->keys[i++].name);
        const struct gp_model_key *const key = &r->model->keys[i];
        if (!key->name)
            return no_such(log, text, "key of the model", &n);
        if (*name_end != '=')
            return gp_fail(log, GP_ERR_USAGE, "%s: %s has no value; write "
                           "%s=VALUE", show(text, SIZE_MAX).text, key->name,
                           key->name);
        if (given[i])
            return gp_fail(log, GP_ERR_USAGE, "%s: %s is given twice; keep one",
                           show(text, SIZE_MAX).text, key->name);
        given[i] = true;
        r->written[i] = true;
        const char *const value = name_end + 1;
        if (gp_model_key_is_file(key)) {
            end = value + name_length(value);
            gp_status st = read_name(log, value, (size_t) (end - value),
                                     &r->file[i]);
            if (st)
                return st;
        } else {
            gp_status st = read_value(log, text, key, value, end,
                                      &r->value[i]);
            if (st)
                return st;
        }
        keys = *end ? end + 1 : end;
    }
    return GP_OK;
}

/* A recipe that says nothing but its model, or NULL. */
static struct gp_recipe usual_recipe(const struct gp_model *m)
{
    struct gp_recipe r = {.model = m};
    for (int i = 0; m && m->keys[i].name; i++)
        r.value[i] = m->keys[i].preset;
    return r;
}

gp_status gp_recipe_parse(const struct gp_log *log, const char *text,
                          struct gp_recipe *out)
{
    const bool prefixed = strncmp(text, builtin, strlen(builtin)) == 0;
    const char *const name = prefixed ? text + strlen(builtin) : text;
    const char *const end = name + strcspn(name, ":");
    const struct gp_model_preset *const preset = find_preset(name, end);
    const char *const recipe = preset ? preset->recipe : name;
    const char *const recipe_end = recipe + strcspn(recipe, ":");
    struct gp_recipe r = usual_recipe(find_model(recipe, recipe_end));
    if (!r.model) {
        struct names n = names_for(name, end);
        for (int i = 0; gp_models[i]; i++)
            add_name(&n, gp_models[i]->name);
        for (const struct gp_model_preset *p = gp_model_presets; p->name; p++) {
            if (!find_model(p->name, p->name + strlen(p->name)))
                add_name(&n, p->name);
        }
        return no_such(log, text, "model of glare", &n);
    }
    gp_status st = GP_OK;
    if (*recipe_end && preset)
        st = read_keys(log, text, recipe_end + 1, &r);
    if (!st && *end)
        st = read_keys(log, text, end + 1, &r);
    for (int i = 0; r.model->keys[i].name && !st; i++) {
        const struct gp_model_key *const key = &r.model->keys[i];
        if (gp_model_key_is_file(key) &&
            (r.file[i] ? !*r.file[i] : key->preset > 0.0))
            st = gp_fail(log, GP_ERR_USAGE, "%s: has no %s; write %s:%s=PATH",
                         show(text, SIZE_MAX).text, key->name, r.model->name,
                         key->name);
    }
    if (st)
        gp_recipe_free(&r);
    else
        *out = r;
    return st;
}

/* The number of a model's key; that of the list's end where it has none. */
static int key_of(const struct gp_recipe *r, const char *key)
{
    int i = 0;
    while (r->model->keys[i].name && strcmp(r->model->keys[i].name, key) != 0)
        i++;
    return i;
}

void gp_recipe_preset(struct gp_recipe *r, const char *key, double value)
{
    const int i = key_of(r, key);
    const struct gp_model_key *const k = &r->model->keys[i];
    if (k->name && !r->written[i])
        r->value[i] = fmin(fmax(value, k->lo), k->hi);
}

gp_status gp_recipe_of_image(const struct gp_log *log, const char *path,
    double degrees, double percent, struct gp_recipe *out)
{
    struct gp_recipe r = usual_recipe(&gp_model_image);
    gp_recipe_preset(&r, "size", degrees);
    gp_recipe_preset(&r, "percent", percent);
    const int i = key_of(&r, "file");
    r.file[i] = gp_strdup(path);
    if (!r.file[i])
        return gp_no_memory(log, path);
    *out = r;
    return GP_OK;
}

void gp_recipe_free(struct gp_recipe *r)
{
    for (int i = 0; i < GP_MODEL_KEYS; i++)
        gp_free(r->file[i]);
    *r = (struct gp_recipe) {0};
}

char *gp_recipe_text(const struct gp_recipe *r)
{
    const struct gp_model_key *const keys = r->model->keys;
    size_t room = strlen(r->model->name) + 1;
    char *text;
    for (int i = 0; keys[i].name; i++)
        room += strlen(keys[i].name) + 40 +
                (r->file[i] ? 2 * strlen(r->file[i]) : 0);
    if (gp_alloc(NULL, "recipe", room, 1, &text))
        return NULL;
    int used = snprintf(text, room, "%s", r->model->name);
    char between = ':';
    for (int i = 0; keys[i].name; i++) {
        char number[40] = "";
        const char *value = number;
        const char *const file = r->file[i] ? r->file[i] : "";
        const bool is_file = gp_model_key_is_file(&keys[i]);
        if (is_file ? !*file : r->value[i] == keys[i].preset)
            continue;
        if (keys[i].words && !is_file)
            value = keys[i].words[(int) r->value[i]];
        for (int digits = 1; !keys[i].words && digits <= 17; digits++) {
            snprintf(number, sizeof number, "%.*g", digits, r->value[i]);
            if (strtod(number, NULL) == r->value[i] &&
                (digits > 10 || !strchr(number, 'e')))
                break; // 70, not 7e+01
        }
        used += snprintf(text + used, room - (size_t) used, "%c%s=%s", between,
                         keys[i].name, value);
        for (const char *c = file; *c; c++) {
            if (*c == ',' || *c == '\\')
                text[used++] = '\\';
            text[used++] = *c;
        }
        text[used] = '\0';
        between = ',';
    }
    return text;
}

double gp_recipe_pupil(const struct gp_recipe *r, const struct gp_field *f)
{
    return r->model->pupil ? r->model->pupil(r, f) : 0.0;
}

// -- adaptation ---------------------------------------------------------------

bool gp_recipe_adapts(const struct gp_recipe *r)
{
    return r->model->adapts && r->model->adapts(r) &&
           gp_recipe_value(r, "adaptation") == 0.0;
}

void gp_recipe_adapt(struct gp_recipe *r, double mean, double white)
{
    if (!gp_recipe_adapts(r))
        return;
    const double own = gp_recipe_value(r, "white");
    const int i = key_of(r, "adaptation");
    // the dark is 1e-6 cd/m2, under which no eye sees
    r->value[i] = fmin(fmax(mean * (own > 0.0 ? own : white), 1e-6),
                       r->model->keys[i].hi);
}

double gp_recipe_key(const struct gp_recipe *r, const char *key,
                     double otherwise)
{
    const int i = key_of(r, key);
    return r->model->keys[i].name ? r->value[i] : otherwise;
}

const char *gp_recipe_file(const struct gp_recipe *r)
{
    for (int i = 0; i < GP_MODEL_KEYS; i++) {
        if (r->file[i])
            return r->file[i];
    }
    return NULL;
}

char *gp_kernel_path(const char *word)
{
    struct gp_recipe r = {0};
    const char *file = word;
    if (gp_recipe_is(word))
        file = gp_recipe_parse(NULL, word, &r) ? NULL : gp_recipe_file(&r);
    char *const path = file ? gp_strdup(file) : NULL;
    gp_recipe_free(&r);
    return path;
}
