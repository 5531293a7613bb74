// SPDX-License-Identifier: Apache-2.0
/* Parameters as a caller gives them: of whatever version, each in its range. */
#include "api/api.h"

#include "sun/found.h"

#include <float.h>
#include <limits.h>
#include <string.h>

/* A field that may be wrong. LIST: a pointer that is not NULL where the int at
 * `count` is not 0; PRESENT: one that is never NULL. Enums are ints. */
struct range {
    const char *field; // "layer.gain", as messages name it
    enum { INT, FLOAT, DOUBLE, LIST, PRESENT } kind;
    size_t at, count;
    double least, most; // NaN is in no range
};

#define FIELD(type, name, m) name "." #m, _Generic(((struct type *) 0)->m,    \
    float: FLOAT, double: DOUBLE, default: INT), offsetof(struct type, m), 0
#define IN(type, name, m, least, most) {FIELD(type, name, m), least, most}
#define LISTED(type, name, m, n)                                              \
    {name "." #m, LIST, offsetof(struct type, m), offsetof(struct type, n), 0, 0}
#define NEVER_NULL(type, name, m)                                             \
    {name "." #m, PRESENT, offsetof(struct type, m), 0, 0, 0}

#define SENSE(...) IN(glarepp_sense_params, "sense", __VA_ARGS__)
#define LAYER(...) IN(glarepp_layer_params, "layer", __VA_ARGS__)
#define LIGHT(...) IN(glarepp_light, "light", __VA_ARGS__)
#define LIGHTS(...) IN(glarepp_light_params, "lights", __VA_ARGS__)
#define LENS(...) IN(glarepp_lens_params, "lens", __VA_ARGS__)
#define SCENE(...) IN(glarepp_scene_params, "scene", __VA_ARGS__)
#define TONE(...) IN(glarepp_tone_params, "tone", __VA_ARGS__)
#define SETS(...) IN(glarepp_sets_params, "sets", __VA_ARGS__)
#define DRAWN(...) IN(glarepp_field, "field", __VA_ARGS__)

// clang-format off
static const struct range ranges[] = {
    IN(glarepp_params, "params", threads, 0, 1024),
    IN(glarepp_params, "params", level, GLAREPP_ERROR, GLAREPP_NOTE),
    IN(glarepp_params, "params", gl_size, 0, INT_MAX),
    SENSE(threshold, -FLT_MAX, FLT_MAX), SENSE(unit, 0, GLAREPP_EV),
    SENSE(knee, 0, 1), SENSE(max_value, 0, FLT_MAX),
    NEVER_NULL(glarepp_layer_params, "layer", engine),
    LAYER(tolerance, 0, 1), LAYER(tolerance_pixel, 0, 1),
    LAYER(gain, 0, 1e6), LAYER(mix, 0, GLAREPP_SCATTER),
    LAYER(edges, 0, GLAREPP_MIRROR), LAYER(gl, 0, GLAREPP_EGL),
    LAYER(group, 1, 64), LAYER(cluster, 0, 64),
    LAYER(cluster_fill, FLT_MIN, 1), LAYER(shrink, 0, 0.99),
    LAYER(tint[0], 0, 1e6), LAYER(tint[1], 0, 1e6), LAYER(tint[2], 0, 1e6),
    LAYER(saturation, 0, 10),
    LIGHT(place, 0, GLAREPP_FOUND), LIGHT(at[0], -1e15, 1e15),
    LIGHT(at[1], -1e15, 1e15), LIGHT(at[2], -1e15, 1e15),
    LIGHT(radius, -1e9, 1e9), LIGHT(degrees, 0, 90), LIGHT(ball, 0, 1e15),
    LIGHT(bias, 0, 1), LIGHT(flux[0], 0, 1e30), LIGHT(flux[1], 0, 1e30),
    LIGHT(flux[2], 0, 1e30),
    LIGHTS(lights, 0, GP_LIGHTS_MAX),
    LISTED(glarepp_light_params, "lights", light, lights),
    LIGHTS(degrees, 0, 90), LIGHTS(method, 0, GLAREPP_READBACK),
    LIGHTS(outside, 0, GLAREPP_BY_SCENE), LIGHTS(depth, 0, GLAREPP_NORMALIZED),
    LIGHTS(ndc, 0, GLAREPP_NDC_CLIP), LIGHTS(adapt, 0, 1), LIGHTS(side, 2, 256),
    LIGHTS(found, 0, GP_FOUND_MOST),
    LIGHTS(share_by, 0, GLAREPP_SHARES_SCENE), LIGHTS(flare_gain, 0, 1e9),
    LENS(sensor, 0, 1e4), LENS(distance, 0, 1e9), LENS(f_number, 0, 1e4),
    LENS(detail, 0, 3), LENS(gain, 0, 1e9),
    SCENE(up, 0, GLAREPP_UP_Z), SCENE(start, -1e9, 1e9),
    SCENE(light_scale, 0, 1e12), SCENE(lamp_size, 0, 1e9),
    SCENE(relights, 0, INT_MAX),
    LISTED(glarepp_scene_params, "scene", relight, relights),
    NEVER_NULL(glarepp_tone_params, "tone", curve), TONE(exposure, -1e3, 1e3),
    TONE(key, FLT_MIN, 1), TONE(white, 0, FLT_MAX), TONE(contexts, 0, INT_MAX),
    LISTED(glarepp_tone_params, "tone", context, contexts),
    IN(glarepp_plan_params, "plan", fov, 0, 360),
    IN(glarepp_plan_params, "plan", projection, 0, GLAREPP_OF_FRAME),
    IN(glarepp_plan_params, "plan", rotate, -1e6, 1e6),
    IN(glarepp_plan_params, "plan", mores, 0, 1024),
    LISTED(glarepp_plan_params, "plan", more, mores),
    IN(glarepp_group, "group", kernel, 0, 1024),
    IN(glarepp_group, "group", gain, 0, 1e6),
    IN(glarepp_frame_params, "frame", groups, 0, INT_MAX),
    IN(glarepp_frame_params, "frame", noise, 0, 1),
    IN(glarepp_frame_params, "frame", projection, 0, GLAREPP_OF_FRAME),
    LISTED(glarepp_frame_params, "frame", group, groups),
    IN(glarepp_kernel_params, "kernel", words, 0, 8),
    LISTED(glarepp_kernel_params, "kernel", word, words),
    DRAWN(w, 1, 1 << 20), DRAWN(h, 1, 1 << 20), DRAWN(fov, 0, 180),
    DRAWN(aspect, 0, 1e6), DRAWN(rotate, -1e6, 1e6), DRAWN(radius, 0, 1 << 20),
    NEVER_NULL(glarepp_sets_params, "sets", path), SETS(up, 0, GLAREPP_UP_Z),
    SETS(w, 1, 16384), SETS(h, 1, 16384), SETS(map, 8, 4096),
    SETS(runs, 1, 1000), SETS(occluders, 0, 1000000), SETS(near, 1e-30, 1e15),
    SETS(light_scale, 0, 1e12), SETS(ambient, 0, 1e12), SETS(gl, 0, GLAREPP_EGL),
    IN(glarepp_stored, "stored", channels, 0, INT_MAX),
    LISTED(glarepp_stored, "stored", channel, channels),
};
// clang-format on

/* The value of a number; of a pointer 1 where it may stand so, else 0. */
static double value_of(const struct range *r, const char *from)
{
    const void *const at = from + r->at;
    const void *pointer;
    int count = 1;
    switch (r->kind) {
    case INT: return *(const int *) at;
    case FLOAT: return (double) *(const float *) at;
    case DOUBLE: return *(const double *) at;
    case LIST: memcpy(&count, from + r->count, sizeof count); break;
    case PRESENT: break;
    }
    memcpy(&pointer, at, sizeof pointer);
    return pointer || !count ? 1.0 : 0.0;
}

const char *gp_api_about(const char *parameter)
{
    static _Thread_local const char *about = "";
    about = parameter ? parameter : about;
    return about;
}

gp_status gp_api_check(const struct gp_log *log, const char *name,
                       const void *params)
{
    const size_t length = strlen(name);
    for (size_t i = 0; i < sizeof ranges / sizeof *ranges; i++) {
        const struct range *const r = &ranges[i];
        if (strncmp(r->field, name, length) != 0 || r->field[length] != '.')
            continue;
        const double v = value_of(r, params);
        const bool pointer = r->kind >= LIST;
        if (pointer && v == 0.0)
            return gp_fail_at(log, GP_ERR_USAGE, r->field, "%s: it is missing "
                              "(found NULL)", r->field);
        if (!pointer && !(v >= r->least && v <= r->most))
            return gp_fail_at(log, GP_ERR_USAGE, r->field, "%s: not from %g to "
                              "%g (found %g)", r->field, r->least, r->most, v);
    }
    return GP_OK;
}

gp_status gp_api_params(const struct gp_log *log, const char *name, void *to,
                        size_t size, const void *from)
{
    size_t given = size;
    gp_api_about(name);
    if (!from)
        return GP_OK;
    memcpy(&given, from, sizeof given);
    if (given < sizeof given || given > size)
        return gp_fail_at(log, GP_ERR_USAGE, name, "%s: its size is that of no "
                          "version up to " GP_VERSION " (found %zu)", name,
                          given);
    memcpy(to, from, given);
    memcpy(to, &size, sizeof size);
    return gp_api_check(log, name, to);
}
