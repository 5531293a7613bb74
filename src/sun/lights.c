// SPDX-License-Identifier: Apache-2.0
#include "sun/lights.h"

#include "core/memory.h"
#include "core/json.h"
#include "core/maths.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// 32 lights in 10,000 frames; 5000 cameras and more, a number a line
enum { MOST_BYTES = 8 << 20 };
static const double MOST_FLUX = 1e12, MOST_COLOUR = 1e6;
static const double MOST_RADIUS = 1e6; // pixels
static const double MOST_PIXEL = 1e9, MOST_WORLD = 1e15, MOST_DEPTH = 1e30;
static const double SUN_DEGREES = 0.533; // mean angular diameter of the sun

static const char *const keys[] = {
    "pixel", "world", "direction", "found", "radius", "degrees",
    "depth", "bias",  "flux",      "color", "name",   NULL,
};

/* Places that a light may have; in the order of enum glarepp_place. */
static const struct {
    const char *key;
    int count;
    double most;
} places[] = {
    [GLAREPP_PIXEL] = {"pixel", 2, MOST_PIXEL},
    [GLAREPP_WORLD] = {"world", 3, MOST_WORLD},
    [GLAREPP_DIRECTION] = {"direction", 3, MOST_WORLD},
    [GLAREPP_FOUND] = {"found", 2, MOST_PIXEL},
};
enum { PLACES = sizeof places / sizeof *places };

static gp_status read_light(const struct gp_json_place *p, json_t *o,
                            struct glarepp_light *out)
{
    static const struct gp_light plain = GP_LIGHT_DEFAULTS;
    double flux[3] = {0.0, 0.0, 0.0}, colour[3] = {1.0, 1.0, 1.0};
    const bool pixels = json_object_get(o, "radius");
    const bool angle = json_object_get(o, "degrees");
    int n = 0; // places
    const char *name = NULL;
    gp_status st;
    *out = (struct glarepp_light) {
        .radius = plain.radius,
        .degrees = SUN_DEGREES,
        .depth = NAN,
        .bias = plain.bias,
    };
    GP_TRY(gp_json_keys(p, o, keys));
    for (int i = 0; i < PLACES; i++) {
        const double most = places[i].most;
        const bool given = json_object_get(o, places[i].key);
        GP_TRY(gp_json_numbers(p, o, places[i].key, places[i].count,
                               -most, most, out->at));
        out->place = given ? (enum glarepp_place) i : out->place;
        n += given;
    }
    const double *const at = out->at;
    if (n != 1)
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d needs one place (found %d); give \"pixel\", "
                       "\"world\", \"direction\" or \"found\"",
                       p->path, p->what, p->index, n);
    if (out->place == GLAREPP_DIRECTION && at[0] == 0.0 && at[1] == 0.0 &&
        at[2] == 0.0)
        return gp_json_fail(p, "\"direction\" is 0, 0, 0; give a vector that "
                            "is not zero");
    // a direction's disc is seen under an angle, unless pixels are given
    GP_TRY(gp_json_number(p, o, "radius", 0.0, MOST_RADIUS, &out->radius));
    GP_TRY(gp_json_number(p, o, "degrees", 0.0, 90.0, &out->degrees));
    if (angle && (pixels || out->place != GLAREPP_DIRECTION))
        return gp_json_fail(p, "\"degrees\" is for a \"direction\" without "
                            "\"radius\" (found it with \"%s\"); give only "
                            "\"radius\"",
                            pixels ? "radius" : places[out->place].key);
    if (out->place == GLAREPP_DIRECTION && !pixels)
        out->radius = -1.0;
    GP_TRY(gp_json_number(p, o, "depth", 0.0, MOST_DEPTH, &out->depth));
    GP_TRY(gp_json_number(p, o, "bias", 0.0, 1.0, &out->bias));
    GP_TRY(gp_json_numbers(p, o, "flux", -3, 0.0, MOST_FLUX, flux));
    GP_TRY(gp_json_numbers(p, o, "color", 3, 0.0, MOST_COLOUR, colour));
    // of one to be found the colour is for what the frame has of it
    const bool found = out->place == GLAREPP_FOUND;
    for (int c = 0; c < 3; c++) {
        out->flux[c] = (float) (flux[c] * (found ? 1.0 : colour[c]));
        out->gain[c] = (float) (found ? colour[c] : 1.0);
    }
    GP_TRY(gp_json_text(p, o, "name", &name));
    snprintf(out->name, sizeof out->name, "%s", name ? name : "");
    if (found && !out->name[0])
        return gp_json_fail(p, "\"found\" without \"name\"; give one");
    if (found &&
        (pixels || json_object_get(o, "depth") || json_object_get(o, "bias")))
        return gp_json_fail(p, "a light that is \"found\" has the frame's own "
                               "radius and depth; leave \"radius\", \"depth\" "
                               "and \"bias\" out");
out:
    return st;
}

/* The array of places of a light that moves; NULL: it has one, or none. */
static json_t *track_of(json_t *o)
{
    json_t *const found = json_object_get(o, "found");
    return json_is_array(json_array_get(found, 0)) ? found : NULL;
}

/* Reads a light: one, or one for each place of a track. */
static gp_status read_places(const struct gp_json_place *p, json_t *o,
                             struct glarepp_light *out, int *n)
{
    json_t *const track = track_of(o), *const one = json_copy(o), *item;
    size_t i;
    gp_status st = GP_OK;
    if (!track)
        st = read_light(p, o, &out[(*n)++]);
    json_array_foreach(track, i, item)
    {
        double at[3];
        json_object_set(one, "found", item);
        GP_TRY(
            gp_json_numbers(p, one, "found", 3, -MOST_PIXEL, MOST_PIXEL, at));
        if (i && !(at[0] > out[*n - 1].at[2]))
            GP_TRY(gp_json_fail(p,
                                "frames of \"found\" must rise (found %g after "
                                "%g); give them in order",
                                at[0], out[*n - 1].at[2]));
        json_object_set_new(one, "found", json_pack("[ff]", at[1], at[2]));
        GP_TRY(read_light(p, one, &out[*n]));
        out[(*n)++].at[2] = at[0];
    }
out:
    json_decref(one);
    return st;
}

/* Checks that no two lights to be found have one name. */
static gp_status check_names(const struct gp_json_place *p, json_t *array)
{
    gp_status st;
    json_t *const seen = json_object(), *item;
    size_t i;
    json_array_foreach(array, i, item)
    {
        json_t *const name = json_object_get(item, "name");
        if (!json_object_get(item, "found"))
            continue;
        if (json_object_get(seen, json_string_value(name)))
            GP_TRY(gp_fail(p->log, GP_ERR_DATA,
                           "%s: light %zu: a name that one "
                           "before has (found \"%s\"); give each its own",
                           p->path, i + 1, json_string_value(name)));
        json_object_set(seen, json_string_value(name), name);
    }
    st = GP_OK;
out:
    json_decref(seen);
    return st;
}

gp_status gp_lights_read(const struct gp_log *log, const char *path,
                         struct glarepp_light **out, int *n)
{
    static const char *const whole[] = {"lights", NULL};
    gp_status st;
    json_t *root = NULL, *array, *item;
    struct glarepp_light *spec = NULL;
    struct gp_json_place place = {.log = log, .path = path, .what = "light"};
    GP_TRY(gp_json_read(log, path, MOST_BYTES, &root));
    if (json_is_object(root))
        GP_TRY(gp_json_keys(&place, root, whole));
    GP_TRY(gp_json_array(&place, root, "lights", GP_LIGHTS_MAX, &array));
    size_t room = 0, i;
    int count = 0;
    json_array_foreach(array, i, item) room +=
        track_of(item) ? json_array_size(track_of(item)) : 1;
    GP_TRY(gp_alloc_zero(log, path, room, sizeof *spec, &spec));
    json_array_foreach(array, i, item)
    {
        place.index = (int) i + 1;
        GP_TRY(read_places(&place, item, spec, &count));
    }
    GP_TRY(check_names(&place, array));
    *out = spec;
    *n = count;
    spec = NULL; // the caller's
out:
    gp_free(spec);
    json_decref(root);
    return st;
}

/* Finds the disc that the camera sees of a light in its place: of the world's
 * size where that is known, else of l->radius pixels. */
static void see(const struct glarepp_light *spec, const struct gp_camera *c,
                struct gp_rect display, struct gp_light *l)
{
    const bool lamp = spec->place == GLAREPP_WORLD;
    const bool ball = lamp && spec->radius < 0.0 && spec->ball > 0.0;
    const bool sized = ball || (spec->place == GLAREPP_DIRECTION &&
                                spec->radius < 0.0);
    struct gp_v3 to = {spec->at[0], spec->at[1], spec->at[2]};
    if (spec->place == GLAREPP_PIXEL)
        to = gp_camera_ray(c, display, l->x, l->y);
    l->sight = (struct gp_light_sight) {.known = true, .lamp = lamp,
                                        .at = {to.x, to.y, to.z}};
    if (lamp)
        to = gp_v3_sub(to, gp_camera_eye(c));
    const double along[3] = {to.x, to.y, to.z};
    const double distance = lamp ? gp_v3_length(to) : INFINITY;
    double degrees = spec->degrees;
    if (ball)
        degrees = 360.0 / M_PI * gp_asin(fmin(spec->ball / distance, 1.0));
    else if (!sized)
        degrees = distance > 0.0
                      ? gp_camera_disc_degrees(c, display, along, l->radius)
                      : 0.0;
    l->sight.half = degrees * (M_PI / 360.0);
    if (sized)
        l->radius = gp_camera_disc(c, display, along, degrees);
    l->wide = gp_camera_disc_wide(c, l->y, degrees);
}

gp_status gp_light_place_in(const struct gp_log *log, const char *path,
                            const struct glarepp_light *spec,
                            const struct gp_camera *c, enum glarepp_depth type,
                            struct gp_rect display, struct gp_light *out)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    struct gp_projected at = {.x = spec->at[0], .y = spec->at[1]};
    if (spec->place != GLAREPP_PIXEL) {
        if (!c)
            return gp_fail_at(log, GP_ERR_USAGE, "lights.cameras",
                              "%s: a light's \"%s\" needs a camera (the frame "
                              "has no worldToNDC); give the light's pixel",
                              path, places[spec->place].key);
        at = gp_camera_project(c, display, spec->at,
                               spec->place == GLAREPP_WORLD ? 1.0 : 0.0);
    }
    l.x = at.x;
    l.y = at.y;
    l.behind = at.behind;
    l.bias = spec->bias;
    if (spec->radius >= 0.0)
        l.radius = spec->radius;
    if (c)
        see(spec, c, display, &l);
    const bool own = isnan(spec->depth) && spec->place == GLAREPP_WORLD;
    if (own && type == GLAREPP_NORMALIZED)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: in normalized depth a light needs a \"depth\" "
                       "(found \"world\" without one); give it, 0 near to 1 "
                       "far", path);
    if (own) { // its distance, counted as the frame's depth channel counts
        l.depth = type == GLAREPP_RAY ? at.ray : at.z;
        if (spec->ball > 0.0 && l.depth > 0.0)
            l.bias = fmin(l.bias + spec->ball / l.depth, 1.0);
    }
    else if (!isnan(spec->depth))
        l.depth = spec->depth;
    memcpy(l.flux, spec->flux, sizeof l.flux);
    memcpy(l.name, spec->name, sizeof l.name);
    *out = l;
    return GP_OK;
}

// -- cameras -----------------------------------------------------------------

enum { MOST_FRAMES = 1 << 20 };

static const double MOST_FRAME = 9007199254740992.0; // 2^53: exact in double
static const double MOST_VALUE = 1e300;

static gp_status read_frame(const struct gp_json_place *p, json_t *o,
                            struct gp_camera_frame *out)
{
    gp_status st;
    char frame[2048]; // "cameras.json: frame 1001"
    struct gp_json_place at = *p;
    double number = 0.0, camera[16], ndc[16], columns[16];
    const bool found = json_object_get(o, "frame");
    const bool spec = json_object_get(o, "worldToNDC_rowmajor");
    const bool clip = json_object_get(o, "worldToNDC_blender_colvec");
    const bool has_camera = json_object_get(o, "worldToCamera_rowmajor");
    if (!json_is_object(o))
        return gp_fail(p->log, GP_ERR_DATA,
            "%s: %s %d in order is not an object; give {\"frame\": ..., "
            "\"worldToNDC_rowmajor\": [...]}", p->path, p->what, p->index);
    // from here messages name the frame by its number
    GP_TRY(gp_json_number(p, o, "frame", -MOST_FRAME, MOST_FRAME, &number));
    if (!found || number != floor(number))
        return gp_fail(p->log, GP_ERR_DATA,
                       "%s: %s %d in order has no frame number (found %s); "
                       "give \"frame\" an integer", p->path, p->what, p->index,
                       found ? "a fraction" : "no \"frame\"");
    out->frame = (long long) number;
    snprintf(frame, sizeof frame, "%s: frame %lld", p->path, out->frame);
    at.path = frame;
    at.index = 0;

    GP_TRY(gp_json_numbers(&at, o, "worldToCamera_rowmajor", 16,
                           -MOST_VALUE, MOST_VALUE, camera));
    GP_TRY(gp_json_numbers(&at, o, "worldToNDC_rowmajor", 16,
                           -MOST_VALUE, MOST_VALUE, ndc));
    GP_TRY(gp_json_numbers(&at, o, "worldToNDC_blender_colvec", 16,
                           -MOST_VALUE, MOST_VALUE, columns));
    if (!spec && !clip)
        return gp_json_fail(&at,
                            "no projection (found neither "
                            "\"worldToNDC_rowmajor\" nor "
                            "\"worldToNDC_blender_colvec\"); give one of them");
    for (int i = 0; !spec && i < 16; i++)
        ndc[i] = columns[i % 4 * 4 + i / 4];
    GP_TRY(gp_camera_make(p->log, frame, has_camera ? camera : NULL, ndc,
                          spec ? GLAREPP_NDC_SPEC : GLAREPP_NDC_CLIP,
                          &out->camera));

    out->has_sun = json_object_get(o, "sun_dir_world");
    GP_TRY(gp_json_numbers(&at, o, "sun_dir_world", 3, -MOST_VALUE, MOST_VALUE,
                           out->sun_dir));
    GP_TRY(gp_json_number(&at, o, "sun_radius_px", 0.0, 1e6, &out->sun_radius));
    const double *const d = out->sun_dir;
    if (out->has_sun && d[0] == 0.0 && d[1] == 0.0 && d[2] == 0.0)
        return gp_json_fail(&at, "\"sun_dir_world\" is 0, 0, 0; give a vector "
                                 "that is not zero, or leave it out");
out:
    return st;
}

static int by_number(const void *a, const void *b)
{
    const struct gp_camera_frame *x = a, *y = b;
    return (x->frame > y->frame) - (x->frame < y->frame);
}

gp_status gp_camera_read(const struct gp_log *log, const char *path,
                         struct gp_camera_file *out)
{
    gp_status st;
    json_t *root = NULL, *frames;
    struct gp_camera_file f = {0};
    struct gp_json_place place = {.log = log, .path = path, .what = "frame"};
    GP_TRY(gp_json_read(log, path, MOST_BYTES, &root));
    GP_TRY(gp_json_array(&place, root, "frames", MOST_FRAMES, &frames));
    f.n = (int) json_array_size(frames);
    if (f.n == 0)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: no frames (\"frames\" is empty); give each "
                       "frame's matrices", path));
    GP_TRY(gp_alloc_zero(log, path, (size_t) f.n, sizeof *f.at, &f.at));
    for (int i = 0; i < f.n; i++) {
        place.index = i + 1;
        GP_TRY(read_frame(&place, json_array_get(frames, (size_t) i),
                          &f.at[i]));
    }
    qsort(f.at, (size_t) f.n, sizeof *f.at, by_number);
    for (int i = 1; i < f.n; i++) {
        if (f.at[i].frame == f.at[i - 1].frame)
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: frame %lld is listed twice; remove one", path,
                           f.at[i].frame));
    }
    place.index = 0;
    if (json_is_object(root))
        GP_TRY(gp_json_number(&place, root, "width", 1.0, 1e9, &f.width));
    *out = f;
    f = (struct gp_camera_file) {0}; // the caller's
out:
    gp_camera_file_free(&f);
    json_decref(root);
    return st;
}

void gp_camera_file_free(struct gp_camera_file *f)
{
    GP_FREE(f->at);
    f->n = 0;
}

const struct gp_camera_frame *
gp_camera_frame_find(const struct gp_camera_file *f, long long number)
{
    for (int i = 0; i < f->n; i++) {
        if (f->n == 1 || f->at[i].frame == number)
            return &f->at[i];
    }
    return NULL;
}
