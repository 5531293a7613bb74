// SPDX-License-Identifier: Apache-2.0
/* Reads flare elements from JSON. */
#include "sun/flare.h"

#include "core/bridge.h"
#include "core/json.h"
#include "core/memory.h"
#include "sun/flare_priv.h"

#include <glob.h>
#include <limits.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

enum { MOST_ELEMENTS = 1024, MOST_RAYS = 512 };

static const char *const sources[] = {"lights", "bright", NULL};

// -- keys --------------------------------------------------------------------

/* Elements that a key is for: bits of shapes, and of a source. */
#define BIT(shape) (1u << GP_FLARE_##shape)
enum {
    RAYS = BIT(STREAK) | BIT(SPIKES),
    FORMED = BIT(DISC) | BIT(RING) | BIT(POLYGON) | BIT(GLOW) | BIT(CAUSTIC) |
             RAYS,
    ANY = FORMED | BIT(IMAGE) | BIT(DIRT),
    LISTED = 1 << 30, // of lights only
};

/* A number's range, and its place in an element; 0: no number. */
#define TO(field) offsetof(struct gp_flare_element, field)
static const struct key {
    const char *name;
    unsigned of;
    double lo, hi;
    size_t to;
} keys[] = {
    {"shape", ANY, 0, 0, 0},
    {"source", ANY, 0, 0, 0},
    {"position", ANY, -10, 10, TO(at)},
    {"size", ANY, 0, 10, TO(size)},
    {"color", ANY, 0, 0, 0},
    {"rotation", ANY, -36000, 36000, TO(rotation)},
    {"scale", ANY, 0, 0, 0},
    {"flicker", ANY, 0, 1, TO(flicker)},
    {"seed", ANY, 0, 0, 0},
    {"by_place", ANY, 0, 0, 0},
    {"profile", FORMED, 0, 0, 0},
    {"softness", FORMED, 0, 1, TO(softness)},
    {"rim", FORMED, 0, 100, TO(rim)},
    {"dispersion", FORMED, -1, 1, TO(dispersion)},
    {"aspect", FORMED, 0.05, 20, TO(aspect)},
    {"width", RAYS | BIT(RING), 1e-6, 1, TO(width)},
    {"completion", BIT(RING), 0.001, 1, TO(completion)},
    {"feather", BIT(RING), 0, 1, TO(feather)},
    {"sides", BIT(POLYGON), 0, 0, 0},
    {"round", BIT(POLYGON), 0, 1, TO(round)},
    {"falloff", BIT(GLOW) | BIT(DIRT), 0.1, 100, TO(falloff)},
    {"random", RAYS, 0, 1, TO(random)},
    {"image", BIT(IMAGE) | BIT(DIRT), 0, 0, 0},
    {"count", ANY & ~BIT(DIRT), 0, 0, 0},
    {"spread", BIT(STREAK), 0, 360, TO(spread)},
    {"spread", ANY & ~(BIT(DIRT) | RAYS), 0, 10, TO(spread)},
    {"turn", ANY | LISTED, 0, 0, 0},
    {"offset", ANY | LISTED, -10, 10, TO(offset)},
    {"cut", FORMED | LISTED, 0, 1, TO(cut)},
    {"shrink", ANY | LISTED, 0, 1, TO(shrink)},
    {"only", ANY | LISTED, 0, 0, 0},
};
enum { KEYS = sizeof keys / sizeof *keys };

/* Refuses keys that the element has no use for, and reads its numbers. */
static gp_status read_keys(const struct gp_json_place *p, json_t *o,
                           struct gp_flare_element *e)
{
    const char *allowed[KEYS + 1];
    gp_status st = GP_OK;
    int n = 0;
    for (int i = 0; i < KEYS; i++) {
        const bool listed = e->source == GP_FLARE_LIGHTS ||
                            !(keys[i].of & LISTED);
        if (keys[i].of & 1u << e->shape && listed)
            allowed[n++] = keys[i].name;
    }
    allowed[n] = NULL;
    GP_TRY(gp_json_keys(p, o, allowed));
    for (int i = 0; i < KEYS; i++) {
        if (keys[i].of & 1u << e->shape && keys[i].to)
            GP_TRY(gp_json_number(p, o, keys[i].name, keys[i].lo, keys[i].hi,
                                  (double *) ((char *) e + keys[i].to)));
    }
out:
    return st;
}

// -- values ------------------------------------------------------------------

static gp_status read_floats(const struct gp_json_place *p, json_t *o,
    const char *key, bool grey, double lo, double hi, float out[3])
{
    double v[3] = {(double) out[0], (double) out[1], (double) out[2]};
    const gp_status st = gp_json_numbers(p, o, key, grey ? -3 : 3, lo, hi, v);
    for (int c = 0; c < 3; c++)
        out[c] = (float) v[c];
    return st;
}

static gp_status read_profile(const struct gp_json_place *p, json_t *o,
                              struct gp_flare_element *e)
{
    double v[GP_FLARE_PROFILE];
    const json_t *const list = json_object_get(o, "profile");
    const int n = (int) json_array_size(list); // 0 of no array
    if (!list)
        return GP_OK;
    if (n < 2 || n > GP_FLARE_PROFILE)
        return gp_json_fail(p, "\"profile\" is not an array of 2 to %d "
                            "numbers; give brightness from middle to rim, e.g. "
                            "[1, 0.5, 0]", GP_FLARE_PROFILE);
    const gp_status st = gp_json_numbers(p, o, "profile", n, 0.0, 1e3, v);
    bool black = true;
    for (int i = 0; i < n && !st; i++) {
        e->profile[i] = (float) v[i];
        black = black && !(v[i] > 0.0);
    }
    if (!st && black)
        return gp_json_fail(p, "\"profile\" is all 0; give a number over 0");
    e->profiles = n;
    return st;
}

static gp_status read_by_place(const struct gp_json_place *p, json_t *o,
                               struct gp_flare_element *e)
{
    static const char *const names[] = {"from", "brightness", "color", NULL};
    static const char *const sized[] = {"from", "size", "brightness", "color",
                                        NULL};
    static const char *const from[] = {"centre", "edge", NULL};
    struct gp_flare_by_place *const b = &e->by_place;
    json_t *const own = json_object_get(o, "by_place");
    json_t *const colours = json_object_get(own, "color");
    double bright[2] = {1.0, 1.0};
    int edge = 0;
    gp_status st = GP_OK;
    *b = (struct gp_flare_by_place) {.given = own, .size = {1.0, 1.0}};
    if (!own)
        return GP_OK;
    GP_TRY(gp_json_keys(p, own, e->source == GP_FLARE_BRIGHT ? names : sized));
    GP_TRY(gp_json_choice(p, own, "from", from, &edge));
    GP_TRY(gp_json_numbers(p, own, "size", 2, 0.0, 100.0, b->size));
    GP_TRY(gp_json_numbers(p, own, "brightness", 2, 0.0, 1e3, bright));
    if (colours && json_array_size(colours) != 2)
        GP_TRY(gp_json_fail(p, "\"color\" of \"by_place\" is not two colours; "
                            "give [[r, g, b], [r, g, b]]"));
    for (int i = 0; i < 2; i++) {
        float rgb[3] = {1.0f, 1.0f, 1.0f};
        if (colours) { // one of the two, under the key's name
            json_t *const one = json_object();
            json_object_set(one, "color", json_array_get(colours, (size_t) i));
            st = read_floats(p, one, "color", true, 0.0, 1e3, rgb);
            json_decref(one);
            GP_TRY(st);
        }
        for (int c = 0; c < 3; c++)
            b->colour[i][c] = (double) rgb[c] * bright[i];
    }
    b->edge = edge == 1;
out:
    return st;
}

/* Reads the path of an image: beside the JSON file, unless it is absolute. */
static gp_status read_path(const struct gp_json_place *p, json_t *o,
                           struct gp_flare_element *e)
{
    const char *name = "";
    gp_status st;
    GP_TRY(gp_json_text(p, o, "image", &name));
    if (!*name)
        GP_TRY(gp_json_fail(p, "no image; add \"image\": its file"));
    const char *const slash = strrchr(p->path, '/');
    const size_t folder = name[0] != '/' && slash
                              ? (size_t) (slash - p->path) + 1 : 0;
    const size_t bytes = folder + strlen(name) + 1;
    GP_TRY(gp_alloc(p->log, "a flare image's path", bytes, 1, &e->path));
    memcpy(e->path, p->path, folder);
    memcpy(e->path + folder, name, bytes - folder);
out:
    return st;
}

// -- elements ----------------------------------------------------------------

static gp_status read_element(const struct gp_json_place *p, json_t *o,
                              int source, struct gp_flare_element *e)
{
    static const char *const shapes[] = {"disc", "ring", "polygon", "streak",
                                         "image", "glow", "spikes", "caustic",
                                         "dirt", NULL};
    static const char *const turns[] = {"fixed", "axis", NULL};
    const char *only = NULL;
    int shape = -1, turn = 0;
    gp_status st = GP_OK;
    *e = (struct gp_flare_element) GP_FLARE_DEFAULTS;
    if (json_is_object(o))
        GP_TRY(gp_json_choice(p, o, "shape", shapes, &shape));
    if (shape < 0)
        GP_TRY(gp_json_fail(p, "no shape; add \"shape\": disc, ring, polygon, "
                            "streak, image, glow, spikes, caustic or dirt"));
    e->shape = (enum gp_flare_shape) shape;
    const bool rays = RAYS >> shape & 1u;
    e->width = rays ? 0.01 : e->width;
    e->count = e->shape == GP_FLARE_SPIKES ? 8 : 1;
    GP_TRY(gp_json_choice(p, o, "source", sources, &source));
    e->source = (enum gp_flare_source) source;
    if (e->shape == GP_FLARE_DIRT && e->source == GP_FLARE_BRIGHT)
        GP_TRY(gp_json_fail(p, "dirt is lit by lights (found \"source\": "
                            "\"bright\"); use \"lights\""));
    GP_TRY(read_keys(p, o, e));
    GP_TRY(gp_json_int(p, o, "sides", 3, GP_FLARE_SIDES, &e->sides));
    GP_TRY(gp_json_int(p, o, "count", 1, rays ? MOST_RAYS : MOST_ELEMENTS,
                       &e->count));
    GP_TRY(gp_json_int(p, o, "seed", 0, 1 << 24, &e->seed));
    GP_TRY(gp_json_choice(p, o, "turn", turns, &turn));
    e->axis = turn == 1;
    GP_TRY(read_floats(p, o, "color", true, 0.0, 1e6, e->colour));
    GP_TRY(read_floats(p, o, "scale", false, 0.01, 100.0, e->scale));
    GP_TRY(read_profile(p, o, e));
    GP_TRY(read_by_place(p, o, e));
    GP_TRY(gp_json_text(p, o, "only", &only));
    if (only && !(e->only = gp_strdup(only)))
        GP_TRY(gp_no_memory(p->log, p->path));
    if (e->shape == GP_FLARE_IMAGE || e->shape == GP_FLARE_DIRT)
        GP_TRY(read_path(p, o, e));
out:
    return st;
}

/* Makes copies of the last element. Each is of half to all of the size, and has
 * its share of the light. */
static gp_status copy_element(const struct gp_json_place *p, struct gp_flare *f)
{
    const struct gp_flare_element e = f->element[f->n - 1];
    const int copies = RAYS >> e.shape & 1u ? 1 : e.count;
    double weights = 0.0; // of the light, in 0.5 to 1.5 each
    if (f->n - 1 + copies > MOST_ELEMENTS)
        return gp_json_fail(p, "too many elements, with copies (found %d); "
                            "give at most %d", f->n - 1 + copies,
                            MOST_ELEMENTS);
    for (int i = 0; i < copies; i++)
        weights += 0.5 + gp_flare_random(e.seed, 3 * i + 2);
    for (int i = 0; i < copies && copies > 1; i++) {
        struct gp_flare_element *const to = &f->element[f->n - 1 + (i > 0)];
        if (i > 0) {
            *to = e;
            to->only = e.only ? gp_strdup(e.only) : NULL;
            to->path = e.path ? gp_strdup(e.path) : NULL;
            f->n++;
        }
        if ((e.only && !to->only) || (e.path && !to->path))
            return gp_no_memory(p->log, p->path);
        to->at += e.spread * (2.0 * gp_flare_random(e.seed, 3 * i) - 1.0);
        to->size *= 0.5 + 0.5 * gp_flare_random(e.seed, 3 * i + 1);
        const double share =
            (0.5 + gp_flare_random(e.seed, 3 * i + 2)) / weights;
        for (int c = 0; c < 3; c++)
            to->colour[c] = (float) ((double) e.colour[c] * share);
    }
    return GP_OK;
}

// -- files -------------------------------------------------------------------

/* Finds the file of "preset:NAME"; others are files themselves. Lists presets
 * where it is none of them. */
static gp_status find_file(const struct gp_log *log, const char *word,
                           char found[PATH_MAX], const char **path)
{
    static const char prefix[] = "preset:";
    const char *const name = word + sizeof prefix - 1;
    char file[NAME_MAX], list[512] = "";
    glob_t all = {0};
    size_t used = 0;
    *path = word;
    if (strncmp(word, prefix, sizeof prefix - 1) != 0)
        return GP_OK;
    *path = found;
    const int n = snprintf(file, sizeof file, "flares/%s.json", name);
    if (*name && !strchr(name, '/') && (size_t) n < sizeof file &&
        gp_example_find(file, found, PATH_MAX))
        return GP_OK;
    if (gp_example_find("flares", found, PATH_MAX - 8))
        (void) glob(strcat(found, "/*.json"), 0, NULL, &all);
    for (size_t i = 0; i < all.gl_pathc && used < sizeof list; i++) {
        const char *const one = strrchr(all.gl_pathv[i], '/') + 1;
        used += (size_t) snprintf(list + used, sizeof list - used, "%s%.*s",
                                  i ? ", " : "", (int) strlen(one) - 5, one);
    }
    globfree(&all);
    return used ? gp_fail(log, GP_ERR_USAGE, "preset:%s: no installed flare has "
                          "this name; use one of %s, or give a file", name, list)
                : gp_fail(log, GP_ERR_IO, "preset:%s: no flares beside the "
                          "program; install it whole, or name their folder's "
                          "parent in GLAREPP_EXAMPLES", name);
}

gp_status gp_flare_read(const struct gp_log *log, const char *word,
                        struct gp_flare *out)
{
    static const char *const whole[] = {"elements", "source", NULL};
    char found[PATH_MAX];
    const char *path;
    gp_status st = find_file(log, word, found, &path);
    if (st)
        return st;
    struct gp_json_place place = {log, path, "element", 0};
    int source = GP_FLARE_LIGHTS;
    struct gp_flare f = {0};
    json_t *root = NULL, *array = NULL;
    GP_TRY(gp_json_read(log, path, GP_JSON_SMALL, &root));
    GP_TRY(gp_json_array(&place, root, "elements", MOST_ELEMENTS, &array));
    if (json_is_object(root)) {
        GP_TRY(gp_json_keys(&place, root, whole));
        GP_TRY(gp_json_choice(&place, root, "source", sources, &source));
    }
    f.path = gp_strdup(path);
    if (!f.path)
        GP_TRY(gp_no_memory(log, path));
    GP_TRY(gp_alloc_zero(log, "flare elements", MOST_ELEMENTS + 1,
                         sizeof *f.element, &f.element));
    const int n = (int) json_array_size(array);
    for (place.index = 1; place.index <= n; place.index++) {
        GP_TRY(read_element(&place,
                            json_array_get(array, (size_t) place.index - 1),
                            source, &f.element[f.n++]));
        GP_TRY(copy_element(&place, &f));
    }
    *out = f;
    f = (struct gp_flare) {0};
out:
    json_decref(root);
    gp_flare_free(&f);
    return st;
}

bool gp_flare_has(const struct gp_flare *f, enum gp_flare_source source)
{
    for (int i = 0; i < f->n; i++) {
        if (f->element[i].source == source)
            return true;
    }
    return false;
}

void gp_flare_free(struct gp_flare *f)
{
    for (int i = 0; i < f->n; i++) {
        gp_free(f->element[i].only);
        gp_free(f->element[i].path);
        gp_planes_free(&f->element[i].image.rgb);
    }
    gp_free(f->element);
    gp_free(f->path);
    *f = (struct gp_flare) {0};
}
