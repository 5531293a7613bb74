/* Recipes: MODEL:key=value,key=value and the names that stand for some. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const struct gp_model *const gp_models[] = {
    &gp_model_spencer, &gp_model_cie, &gp_model_aperture,
    &gp_model_temporal,
    &gp_model_star, &gp_model_cross, &gp_model_streak, &gp_model_ring,
    &gp_model_circle, &gp_model_gaussian, &gp_model_moffat, NULL,
};

const struct gp_model_preset gp_model_presets[] = {
    {"eye", "spencer", "the human eye in daylight (Spencer et al. 1995)"},
    {"eye-night", "spencer:light=scotopic", "the same at night, with its halo"},
    {"eye-old", "cie:age=70", "the eye of a 70-year-old (CIE 135/1)"},
    {"star", "star", "six rays of a stop with six blades, redder far out"},
    {"cross", "cross", "four rays of a cross screen filter"},
    {"streak", "streak", "the blue horizontal streak of an anamorphic lens"},
    {"ring", "ring", "a corona of small drops: an aureole and rings"},
    {"circle", "circle", "a point out of focus: a disc with a rim"},
    {0},
};

const char *gp_model_name(const struct gp_model *m)
{
    return m->name;
}

const char *gp_model_text(const struct gp_model *m)
{
    return m->text;
}

const char *gp_model_source(const struct gp_model *m)
{
    return m->source;
}

const struct gp_model_key *gp_model_keys(const struct gp_model *m)
{
    return m->keys;
}

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
           find_model(text, end) || (!*end && find_preset(text, end));
}

/* Steps of one letter between two words (Levenshtein), for "did you mean". */
static int distance(const char *a, const char *b, const char *b_end)
{
    enum { MOST = 32 };
    int row[MOST + 1];
    const int n = (int) (b_end - b);
    if (n > MOST)
        return MOST;
    for (int j = 0; j <= n; j++)
        row[j] = j;
    for (int i = 1; a[i - 1]; i++) {
        int before = row[0];
        row[0] = i;
        for (int j = 1; j <= n; j++) {
            const int keep = before + (a[i - 1] != b[j - 1]);
            before = row[j];
            row[j] = 1 + (row[j] < row[j - 1] ? row[j] : row[j - 1]);
            row[j] = row[j] < keep ? row[j] : keep;
        }
    }
    return row[n];
}

struct names {
    char list[1024];
    const char *nearest;
    int steps;
};

static void add_name(struct names *n, const char *name, const char *found,
                     const char *end)
{
    const size_t used = strlen(n->list);
    const int steps = distance(name, found, end);
    snprintf(n->list + used, sizeof n->list - used, "%s%s", used ? ", " : "",
             name);
    if (!n->nearest || steps < n->steps) {
        n->nearest = name;
        n->steps = steps;
    }
}

/* What it could have been, for the end of a line. */
static gp_status no_such(const struct gp_log *log, const char *text,
    const char *what, const char *found, const char *end, struct names *n)
{
    char near[80] = "";
    if (n->steps <= 2)
        snprintf(near, sizeof near, "did you mean %s? ", n->nearest);
    return gp_fail(log, GP_ERR_USAGE, "%s: no %s has the name \"%.*s\"; %sgive "
                   "one of %s", text, what, (int) (end - found), found, near,
                   n->list);
}

static gp_status read_value(const struct gp_log *log, const char *text,
    const struct gp_model_key *key, const char *from, const char *end,
    double *out)
{
    const int length = (int) (end - from);
    if (key->words) {
        struct names n = {.steps = 0};
        for (int i = 0; key->words[i]; i++) {
            if (is_name(key->words[i], from, end)) {
                *out = i;
                return GP_OK;
            }
            add_name(&n, key->words[i], from, end);
        }
        return no_such(log, text, key->name, from, end, &n);
    }
    char *stop = NULL;
    *out = length ? strtod(from, &stop) : NAN;
    if (!length || strchr(" \t\n\v\f\r", *from) || stop != end)
        return gp_fail(log, GP_ERR_USAGE, "%s: %s is no number (found "
                       "\"%.*s\"); give %g to %g", text, key->name, length,
                       from, key->lo, key->hi);
    if (!(*out >= key->lo && *out <= key->hi))
        return gp_fail(log, GP_ERR_USAGE, "%s: %s is out of range (found "
                       "%.*s); give %g to %g", text, key->name, length, from,
                       key->lo, key->hi);
    return GP_OK;
}

/* Reads "key=value,key=value" over what `r` has; `text` is for messages. */
static gp_status read_keys(const struct gp_log *log, const char *text,
                           const char *keys, struct gp_recipe *r)
{
    unsigned given = 0;
    while (*keys) {
        const char *const end = keys + strcspn(keys, ",");
        const char *const name_end = keys + strcspn(keys, "=,");
        struct names n = {.steps = 0};
        int i = 0;
        while (r->model->keys[i].name &&
               !is_name(r->model->keys[i].name, keys, name_end)) {
            add_name(&n, r->model->keys[i].name, keys, name_end);
            i++;
        }
        const struct gp_model_key *const key = &r->model->keys[i];
        if (!key->name)
            return no_such(log, text, "key of the model", keys, name_end, &n);
        if (*name_end != '=')
            return gp_fail(log, GP_ERR_USAGE, "%s: %s has no value; write "
                           "%s=VALUE", text, key->name, key->name);
        if (given >> i & 1)
            return gp_fail(log, GP_ERR_USAGE, "%s: %s is given twice; keep one",
                           text, key->name);
        given |= 1u << i;
        const char *const value = name_end + 1;
        if (key->file) {
            const size_t length = (size_t) (end - value);
            GP_FREE(r->file[i]);
            gp_status st = gp_alloc_zero(log, "recipe", length + 1, 1,
                                         &r->file[i]);
            if (st)
                return st;
            memcpy(r->file[i], value, length);
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

gp_status gp_recipe_parse(const struct gp_log *log, const char *text,
                          struct gp_recipe *out)
{
    const bool prefixed = strncmp(text, builtin, strlen(builtin)) == 0;
    const char *const name = prefixed ? text + strlen(builtin) : text;
    const char *const end = name + strcspn(name, ":");
    const struct gp_model_preset *const preset = find_preset(name, end);
    const char *const recipe = preset ? preset->recipe : name;
    const char *const recipe_end = recipe + strcspn(recipe, ":");
    struct gp_recipe r = {.model = find_model(recipe, recipe_end)};
    if (!r.model) {
        struct names n = {.steps = 0};
        for (int i = 0; gp_models[i]; i++)
            add_name(&n, gp_models[i]->name, name, end);
        for (int i = 0; gp_model_presets[i].name; i++)
            add_name(&n, gp_model_presets[i].name, name, end);
        return no_such(log, text, "model of glare", name, end, &n);
    }
    for (int i = 0; r.model->keys[i].name; i++)
        r.value[i] = r.model->keys[i].preset;
    gp_status st = GP_OK;
    if (*recipe_end && preset)
        st = read_keys(log, text, recipe_end + 1, &r);
    if (!st && *end)
        st = read_keys(log, text, end + 1, &r);
    if (st)
        gp_recipe_free(&r);
    else
        *out = r;
    return st;
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
                (r->file[i] ? strlen(r->file[i]) : 0);
    if (gp_alloc(NULL, "recipe", room, 1, &text))
        return NULL;
    int used = snprintf(text, room, "%s", r->model->name);
    char between = ':';
    for (int i = 0; keys[i].name; i++) {
        char number[40];
        const char *value = number;
        if (keys[i].file ? !r->file[i] : r->value[i] == keys[i].preset)
            continue;
        if (keys[i].file) {
            value = r->file[i];
        } else if (keys[i].words) {
            value = keys[i].words[(int) r->value[i]];
        } else {
            for (int digits = 1; digits <= 17; digits++) {
                snprintf(number, sizeof number, "%.*g", digits, r->value[i]);
                if (strtod(number, NULL) == r->value[i])
                    break;
            }
        }
        used += snprintf(text + used, room - (size_t) used, "%c%s=%s", between,
                         keys[i].name, value);
        between = ',';
    }
    return text;
}

bool gp_recipe_moves(const struct gp_recipe *r)
{
    return r->model->moves;
}

const char *gp_recipe_file(const struct gp_recipe *r)
{
    for (int i = 0; r->model->keys[i].name; i++) {
        if (r->file[i])
            return r->file[i];
    }
    return NULL;
}
