/* Reads flare elements from JSON. */
#include "sun/flare.h"

#include "core/bridge.h"
#include "core/json.h"
#include "core/memory.h"
#include "sun/flare_priv.h"

#include <dirent.h>
#include <limits.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_ELEMENTS = 1024, MOST_RAYS = 512 };

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

static const struct key {
    const char *name;
    unsigned of;
} keys[] = {
    {"shape", ANY},         {"source", ANY},
    {"position", ANY},      {"size", ANY},
    {"color", ANY},         {"rotation", ANY},
    {"scale", ANY},         {"flicker", ANY},
    {"seed", ANY},          {"by_place", ANY},
    {"profile", FORMED},    {"softness", FORMED},
    {"rim", FORMED},        {"dispersion", FORMED},
    {"aspect", FORMED},     {"width", RAYS | BIT(RING)},
    {"completion", BIT(RING)},
    {"feather", BIT(RING)}, {"sides", BIT(POLYGON)},
    {"round", BIT(POLYGON)},
    {"falloff", BIT(GLOW) | BIT(DIRT)},
    {"random", RAYS},       {"image", BIT(IMAGE) | BIT(DIRT)},
    {"count", ANY & ~BIT(DIRT)},
    {"spread", ANY & ~(BIT(DIRT) | BIT(SPIKES))},
    {"turn", ANY | LISTED}, {"offset", ANY | LISTED},
    {"cut", FORMED | LISTED},
    {"shrink", ANY | LISTED},
    {"only", ANY | LISTED}, {NULL, 0},
};

enum { KEYS = sizeof keys / sizeof *keys };

/* Refuses keys that the element has no use for. */
static gp_status check_keys(const struct gp_json_place *p, json_t *o,
                            const struct gp_flare_element *e)
{
    const char *of_shape[KEYS], *allowed[KEYS];
    int n = 0, m = 0;
    for (const struct key *k = keys; k->name; k++) {
        if (!(k->of & 1u << e->shape))
            continue;
        of_shape[n++] = k->name;
        if (e->source == GP_FLARE_LIGHTS || !(k->of & LISTED))
            allowed[m++] = k->name;
    }
    of_shape[n] = allowed[m] = NULL;
    gp_status st = gp_json_keys(p, o, of_shape);
    return st ? st : gp_json_keys(p, o, allowed);
}

// -- values ------------------------------------------------------------------

static gp_status read_floats(const struct gp_json_place *p, json_t *o,
    const char *key, bool grey, double lo, double hi, float out[3])
{
    double v[3] = {(double) out[0], (double) out[1], (double) out[2]};
    const gp_status st = gp_json_numbers(p, o, key, grey ? -3 : 3, lo, hi, v,
                                         NULL);
    for (int c = 0; c < 3; c++)
        out[c] = (float) v[c];
    return st;
}

static gp_status read_source(const struct gp_json_place *p, json_t *o,
                             enum gp_flare_source *out)
{
    static const char *const names[] = {"lights", "bright", NULL};
    int source = (int) *out;
    const gp_status st = gp_json_choice(p, o, "source", names, &source, NULL);
    *out = (enum gp_flare_source) source;
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
    const gp_status st = gp_json_numbers(p, o, "profile", n, 0.0, 1e3, v,
                                         NULL);
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
    static const char *const of_lights[] = {"from", "size", "brightness",
                                            "color", NULL};
    static const char *const of_bright[] = {"from", "brightness", "color",
                                            NULL};
    static const char *const from[] = {"centre", "edge", NULL};
    struct gp_flare_by_place *const b = &e->by_place;
    json_t *const own = json_object_get(o, "by_place");
    double bright[2] = {1.0, 1.0};
    int edge = 0;
    gp_status st = GP_OK;
    *b = (struct gp_flare_by_place) {.size = {1.0, 1.0}};
    if (own) {
        json_t *const colours = json_object_get(own, "color");
        b->given = true;
        GP_TRY(gp_json_keys(p, own, e->source == GP_FLARE_BRIGHT ? of_bright
                                                                 : of_lights));
        GP_TRY(gp_json_choice(p, own, "from", from, &edge, NULL));
        GP_TRY(gp_json_numbers(p, own, "size", 2, 0.0, 100.0, b->size,
                               NULL));
        GP_TRY(gp_json_numbers(p, own, "brightness", 2, 0.0, 1e3, bright,
                               NULL));
        if (colours && json_array_size(colours) != 2)
            GP_TRY(gp_json_fail(p, "\"color\" of \"by_place\" is not two "
                                "colours; give [[r, g, b], [r, g, b]]"));
        for (int i = 0; i < 2; i++) {
            float rgb[3] = {1.0f, 1.0f, 1.0f};
            if (colours) { // one of the two, under the key's name
                json_t *const one = json_object();
                json_object_set(one, "color", json_array_get(colours,
                                                             (size_t) i));
                st = read_floats(p, one, "color", true, 0.0, 1e3, rgb);
                json_decref(one);
                GP_TRY(st);
            }
            for (int c = 0; c < 3; c++)
                b->colour[i][c] = (double) rgb[c] * bright[i];
        }
        b->edge = edge == 1;
    }
out:
    return st;
}

/* Reads the path of an image: beside the JSON file, unless it is absolute. */
static gp_status read_path(const struct gp_json_place *p, json_t *o,
                           struct gp_flare_element *e)
{
    const char *name = NULL;
    bool found = false;
    gp_status st;
    GP_TRY(gp_json_text(p, o, "image", &name, &found));
    if (!found || !*name)
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
    enum gp_flare_source source, struct gp_flare_element *e)
{
    static const char *const shapes[] = {"disc", "ring", "polygon", "streak",
                                         "image", "glow", "spikes", "caustic",
                                         "dirt", NULL};
    static const char *const turns[] = {"fixed", "axis", NULL};
    const char *names[KEYS], *only = NULL;
    int shape = 0, turn = 0;
    bool found = false;
    gp_status st;
    *e = (struct gp_flare_element) GP_FLARE_DEFAULTS;
    e->source = source;
    for (int i = 0; i < KEYS; i++)
        names[i] = keys[i].name;
    GP_TRY(gp_json_keys(p, o, names));
    GP_TRY(gp_json_choice(p, o, "shape", shapes, &shape, &found));
    if (!found)
        GP_TRY(gp_json_fail(p, "no shape; add \"shape\": disc, ring, polygon, "
                            "streak, image, glow, spikes, caustic or dirt"));
    e->shape = (enum gp_flare_shape) shape;
    const bool rays = RAYS >> shape & 1u;
    e->width = rays ? 0.01 : e->width;
    e->count = e->shape == GP_FLARE_SPIKES ? 8 : 1;
    GP_TRY(read_source(p, o, &e->source));
    if (e->shape == GP_FLARE_DIRT && e->source == GP_FLARE_BRIGHT)
        GP_TRY(gp_json_fail(p, "dirt is lit by lights (found \"source\": "
                            "\"bright\"); use \"lights\""));
    GP_TRY(check_keys(p, o, e));
    const struct {
        const char *key;
        double lo, hi, *out;
    } numbers[] = {
        {"position", -10.0, 10.0, &e->at},
        {"size", 0.0, 10.0, &e->size},
        {"rotation", -36000.0, 36000.0, &e->rotation},
        {"width", 1e-6, 1.0, &e->width},
        {"softness", 0.0, 1.0, &e->softness},
        {"rim", 0.0, 100.0, &e->rim},
        {"dispersion", -1.0, 1.0, &e->dispersion},
        {"aspect", 0.05, 20.0, &e->aspect},
        {"completion", 0.001, 1.0, &e->completion},
        {"feather", 0.0, 1.0, &e->feather},
        {"round", 0.0, 1.0, &e->round},
        {"falloff", 0.1, 100.0, &e->falloff},
        {"random", 0.0, 1.0, &e->random},
        {"spread", 0.0, rays ? 360.0 : 10.0, &e->spread},
        {"offset", -10.0, 10.0, &e->offset},
        {"cut", 0.0, 1.0, &e->cut},
        {"shrink", 0.0, 1.0, &e->shrink},
        {"flicker", 0.0, 1.0, &e->flicker},
    };
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        GP_TRY(gp_json_number(p, o, numbers[i].key, numbers[i].lo,
                              numbers[i].hi, numbers[i].out, NULL));
    GP_TRY(gp_json_int(p, o, "sides", 3, GP_FLARE_SIDES, &e->sides, NULL));
    GP_TRY(gp_json_int(p, o, "count", 1, rays ? MOST_RAYS : MOST_ELEMENTS,
                       &e->count, NULL));
    GP_TRY(gp_json_int(p, o, "seed", 0, 1 << 24, &e->seed, NULL));
    GP_TRY(gp_json_choice(p, o, "turn", turns, &turn, NULL));
    e->axis = turn == 1;
    GP_TRY(read_floats(p, o, "color", true, 0.0, 1e6, e->colour));
    GP_TRY(read_floats(p, o, "scale", false, 0.01, 100.0, e->scale));
    GP_TRY(read_profile(p, o, e));
    GP_TRY(read_by_place(p, o, e));
    GP_TRY(gp_json_text(p, o, "only", &only, NULL));
    if (only && !(e->only = gp_strdup(only)))
        GP_TRY(gp_no_memory(p->log, p->path));
    if (e->shape == GP_FLARE_IMAGE || e->shape == GP_FLARE_DIRT)
        GP_TRY(read_path(p, o, e));
out:
    return st;
}

/* Appends e, or its copies, and takes it. */
static gp_status add_element(const struct gp_json_place *p,
                             struct gp_flare_element *e, struct gp_flare *f)
{
    const int copies = RAYS >> e->shape & 1u ? 1 : e->count;
    void *block = f->element;
    gp_status st = GP_OK;
    if (f->n + copies > MOST_ELEMENTS)
        GP_TRY(gp_json_fail(p, "too many elements, with copies (found %d); "
                            "give at most %d", f->n + copies, MOST_ELEMENTS));
    GP_TRY(gp_resize(p->log, "flare elements", (size_t) (f->n + copies) *
                     sizeof *f->element, &block));
    f->element = block;
    double weights = 0.0; // of the light, in 0.5 to 1.5 each
    for (int i = 0; i < copies; i++)
        weights += 0.5 + gp_flare_random(e->seed, 3 * i + 2);
    for (int i = 0; i < copies; i++) {
        struct gp_flare_element *const to = &f->element[f->n];
        *to = *e;
        to->only = e->only ? gp_strdup(e->only) : NULL;
        to->path = e->path ? gp_strdup(e->path) : NULL;
        f->n++;
        if ((e->only && !to->only) || (e->path && !to->path))
            GP_TRY(gp_no_memory(p->log, p->path));
        if (copies == 1)
            break;
        // each is of half to all of the size, and has its share of the light
        to->at += e->spread * (2.0 * gp_flare_random(e->seed, 3 * i) - 1.0);
        to->size *= 0.5 + 0.5 * gp_flare_random(e->seed, 3 * i + 1);
        const double share =
            (0.5 + gp_flare_random(e->seed, 3 * i + 2)) / weights;
        for (int c = 0; c < 3; c++)
            to->colour[c] = (float) ((double) e->colour[c] * share);
    }
out:
    gp_free(e->only);
    gp_free(e->path);
    *e = (struct gp_flare_element) {0};
    return st;
}

// -- presets -----------------------------------------------------------------

static int is_preset(const struct dirent *d)
{
    const char *const end = strrchr(d->d_name, '.');
    return d->d_name[0] != '.' && end && strcmp(end, ".json") == 0;
}

/* Writes the names of the installed flares, in order and with `between` after each
 * but the last; a list of more than `size` bytes is cut off. */
static gp_status list_presets(const struct gp_log *log, const char *name,
                           const char *between, char *list, size_t size)
{
    char folder[PATH_MAX];
    struct dirent **entry = NULL;
    int n = 0;
    size_t used = 0;
    if (gp_example_find("flares", folder, sizeof folder))
        n = scandir(folder, &entry, is_preset, alphasort);
    if (n <= 0)
        return gp_fail(log, GP_ERR_IO, "preset:%s: no flares beside the "
                       "program; install it whole, or name their folder's "
                       "parent in GLAREPP_EXAMPLES", name);
    for (int i = 0; i < n; i++) {
        const char *const word = entry[i]->d_name;
        const int bytes = (int) (strrchr(word, '.') - word);
        const int more = snprintf(list + used, size - used, "%s%.*s",
                                  i ? between : "", bytes, word);
        used = used + (size_t) more < size ? used + (size_t) more : size - 1;
        free(entry[i]);
    }
    free(entry);
    return GP_OK;
}

/* Refuses a preset that is not installed, and lists those that are. */
static gp_status refuse_preset(const struct gp_log *log, const char *name)
{
    char list[512] = "";
    const gp_status st = list_presets(log, name, ", ", list, sizeof list);
    return st ? st
              : gp_fail(log, GP_ERR_USAGE, "preset:%s: no installed flare has "
                        "this name; use one of %s, or give a file", name, list);
}

/* Finds the file of "preset:NAME"; others are files themselves. */
static gp_status find_file(const struct gp_log *log, const char *word,
                           char found[PATH_MAX], const char **path)
{
    static const char prefix[] = "preset:";
    const char *const name = word + sizeof prefix - 1;
    char file[NAME_MAX];
    *path = word;
    if (strncmp(word, prefix, sizeof prefix - 1) != 0)
        return GP_OK;
    const int n = snprintf(file, sizeof file, "flares/%s.json", name);
    if (!*name || strchr(name, '/') || (size_t) n >= sizeof file ||
        !gp_example_find(file, found, PATH_MAX))
        return refuse_preset(log, name);
    *path = found;
    return GP_OK;
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
    enum gp_flare_source source = GP_FLARE_LIGHTS;
    struct gp_flare_element e = {0};
    struct gp_flare f = {0};
    json_t *root = NULL, *array = NULL;
    GP_TRY(gp_json_read(log, path, GP_JSON_SMALL, &root));
    GP_TRY(gp_json_array(&place, root, "elements", MOST_ELEMENTS, &array));
    if (json_is_object(root)) {
        GP_TRY(gp_json_keys(&place, root, whole));
        GP_TRY(read_source(&place, root, &source));
    }
    f.path = gp_strdup(path);
    if (!f.path)
        GP_TRY(gp_no_memory(log, path));
    const int n = (int) json_array_size(array);
    for (place.index = 1; place.index <= n; place.index++) {
        json_t *const o = json_array_get(array, (size_t) place.index - 1);
        GP_TRY(read_element(&place, o, source, &e));
        GP_TRY(add_element(&place, &e, &f));
    }
    *out = f;
    f = (struct gp_flare) {0};
out:
    gp_free(e.only);
    gp_free(e.path);
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
