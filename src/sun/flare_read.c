#include "core/memory.h"
#include "sun/flare.h"
#include "sun/json.h"

#include <stdio.h>
#include <string.h>

enum { MOST_ELEMENTS = 1024 };

static const char *const shapes[] = {"disc", "ring", "polygon", "streak",
                                     "image", NULL};

#define COMMON_KEYS "shape", "position", "size", "color", "rotation", "scale"
static const char *const all_keys[] = {COMMON_KEYS, "width", "sides", "image",
                                       NULL};
static const char *const disc_keys[] = {COMMON_KEYS, NULL};
static const char *const width_keys[] = {COMMON_KEYS, "width", NULL};
static const char *const polygon_keys[] = {COMMON_KEYS, "sides", NULL};
static const char *const image_keys[] = {COMMON_KEYS, "image", NULL};

/* By shape: a key that a shape does not use is an error, not ignored. */
static const char *const *const keys_of[] = {
    [GP_FLARE_DISC] = disc_keys,       [GP_FLARE_RING] = width_keys,
    [GP_FLARE_POLYGON] = polygon_keys, [GP_FLARE_STREAK] = width_keys,
    [GP_FLARE_IMAGE] = image_keys,
};

/* -- one element ----------------------------------------------------------- */

/* The shape, and that no key is unknown, or of another shape. */
static gp_status read_shape(const struct gp_json_place *p, json_t *o,
                            enum gp_flare_shape *out)
{
    int shape = 0;
    bool found = false;
    gp_status st = gp_json_keys(p, o, all_keys);
    if (!st)
        st = gp_json_choice(p, o, "shape", shapes, &shape, &found);
    if (!st && !found)
        st = gp_fail(p->log, GP_ERR_DATA,
                     "%s: %s %d: no shape; add \"shape\": disc, ring, polygon, "
                     "streak or image", p->path, p->what, p->index);
    *out = (enum gp_flare_shape) shape;
    return st ? st : gp_json_keys(p, o, keys_of[shape]);
}

static gp_status read_floats(const struct gp_json_place *p, json_t *o,
                             const char *key, bool grey, double lo, double hi,
                             float out[3])
{
    double v[3] = {(double) out[0], (double) out[1], (double) out[2]};
    const gp_status st = gp_json_numbers(p, o, key, 3, grey, lo, hi, v, NULL);
    for (int c = 0; c < 3; c++)
        out[c] = (float) v[c];
    return st;
}

/* A name beside the JSON file, unless it is absolute. */
static gp_status resolve(const struct gp_json_place *p, const char *name,
                         char **out)
{
    const char *const slash = strrchr(p->path, '/');
    const size_t folder = name[0] != '/' && slash
                              ? (size_t) (slash - p->path) + 1 : 0;
    const size_t bytes = folder + strlen(name) + 1;
    void *path;
    const gp_status st = gp_alloc(p->log, "a flare image's path", bytes, 1,
                                  &path);
    if (st)
        return st;
    memcpy(path, p->path, folder);
    memcpy((char *) path + folder, name, bytes - folder);
    *out = path;
    return GP_OK;
}

static gp_status read_image(const struct gp_json_place *p, json_t *o,
                            char **out)
{
    const char *name = NULL;
    bool found = false;
    const gp_status st = gp_json_text(p, o, "image", &name, &found);
    if (st)
        return st;
    if (!found || !*name)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d: no image; add \"image\": its file",
                       p->path, p->what, p->index);
    return resolve(p, name, out);
}

static gp_status read_element(const struct gp_json_place *p, json_t *o,
                              struct gp_flare_element *e)
{
    *e = (struct gp_flare_element) {
        .size = 0.1, .width = 0.1, .sides = 6,
        .colour = {0.01f, 0.01f, 0.01f}, .scale = {1.0f, 1.0f, 1.0f},
    };
    gp_status st;
    GP_TRY(read_shape(p, o, &e->shape));
    if (e->shape == GP_FLARE_STREAK)
        e->width = 0.01;
    GP_TRY(gp_json_number(p, o, "position", -10.0, 10.0, &e->at, NULL));
    GP_TRY(gp_json_number(p, o, "size", 0.0, 10.0, &e->size, NULL));
    GP_TRY(gp_json_number(p, o, "rotation", -36000.0, 36000.0, &e->rotation,
                          NULL));
    GP_TRY(gp_json_number(p, o, "width", 1e-6, 1.0, &e->width, NULL));
    GP_TRY(gp_json_int(p, o, "sides", 3, 64, &e->sides, NULL));
    GP_TRY(read_floats(p, o, "color", true, 0.0, 1e6, e->colour));
    GP_TRY(read_floats(p, o, "scale", false, 0.01, 100.0, e->scale));
    if (e->shape == GP_FLARE_IMAGE)
        GP_TRY(read_image(p, o, &e->path));
out:
    return st;
}

/* -- the file -------------------------------------------------------------- */

gp_status gp_flare_read(const struct gp_log *log, const char *path,
                        struct gp_flare *out)
{
    struct gp_json_place place = {log, path, "element", 0};
    struct gp_flare f = {0};
    json_t *root = NULL, *array = NULL;
    void *elements = NULL;
    gp_status st;
    GP_TRY(gp_json_read(log, path, &root));
    GP_TRY(gp_json_array(&place, root, "elements", MOST_ELEMENTS, &array));
    const int n = (int) json_array_size(array);
    GP_TRY(gp_alloc_zero(log, "flare elements", n ? (size_t) n : 1,
                         sizeof *f.element, &elements));
    f.element = elements;
    while (f.n < n) {
        json_t *const o = json_array_get(array, (size_t) f.n);
        place.index = ++f.n;
        GP_TRY(read_element(&place, o, &f.element[place.index - 1]));
    }
    *out = f;
    f = (struct gp_flare) {0};
out:
    json_decref(root);
    gp_flare_free(&f);
    return st;
}

void gp_flare_free(struct gp_flare *f)
{
    for (int i = 0; i < f->n; i++) {
        gp_free(f->element[i].path);
        gp_planes_free(&f->element[i].image.rgb);
    }
    GP_FREE(f->element);
    *f = (struct gp_flare) {0};
}
