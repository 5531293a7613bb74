/* Frames of random depth and coverage, lights over them, and contexts, for
 * tests of sun/map. */
#ifndef GP_TESTS_SUN_MAPS_H
#define GP_TESTS_SUN_MAPS_H

#include "gl/gl.h"
#include "sun/map.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char last_line[4096];

static inline void keep(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(last_line, sizeof last_line, "%s", line);
}

static const struct gp_log log_kept = {keep, NULL, GP_LEVEL_INFO};

static inline void assert_ok(gp_status st)
{
    if (st)
        fail_msg("%s", last_line);
}

/* The contexts of this machine; tests loop over them, and over the sun map
 * that each keeps from one draw to the next. */
static struct machine {
    struct gp_gl *gl;
    struct gp_sun_map *map;
} machines[2] __attribute__((unused));
static int machine_count __attribute__((unused));

static inline int open_machines(void **state)
{
    static const enum gp_gl_api apis[2] = {GP_GL_OSMESA, GP_GL_EGL};
    (void) state;
    machine_count = 0;
    for (int i = 0; i < 2; i++) {
        struct machine *const m = &machines[machine_count];
        if (gp_gl_open(&log_kept, apis[i], &m->gl))
            print_message("no context: %s\n", last_line);
        else
            machine_count++;
    }
    return 0;
}

static inline int close_machines(void **state)
{
    (void) state;
    for (int i = 0; i < machine_count; i++) {
        assert_ok(gp_gl_use(&log_kept, machines[i].gl));
        gp_sun_map_close(machines[i].gl, &machines[i].map);
        assert_null(machines[i].map);
        gp_sun_map_close(machines[i].gl, &machines[i].map);
        gp_gl_close(&machines[i].gl);
    }
    return 0;
}

/* Makes the i-th current; skips the test where there is none at all. */
static inline struct machine *machine_at(int i)
{
    if (!machine_count)
        skip();
    assert_ok(gp_gl_use(&log_kept, machines[i].gl));
    return &machines[i];
}

/* -- frames -----------------------------------------------------------------*/

static uint32_t seed = 1;

static inline double uniform01(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed / 4294967296.0;
}

struct sun_frame {
    struct gp_plane depth, mask;
    struct gp_occluders o;
};

enum { WITH_DEPTH = 1, WITH_MASK = 2 };

static inline struct gp_plane plane_of(struct gp_rect window)
{
    struct gp_plane p = {.window = window};
    const size_t n = (size_t) gp_rect_w(window) * (size_t) gp_rect_h(window);
    p.v = malloc(n * sizeof *p.v);
    assert_non_null(p.v);
    return p;
}

/* One of what depth channels hold; hard ones among them. */
static inline float some_depth(void)
{
    const double u = uniform01();
    return u < 0.4 ? (float) (5.0 + 20.0 * uniform01())
           : u < 0.8 ? 1e10f : u < 0.85 ? INFINITY : u < 0.9 ? NAN
           : u < 0.95 ? 0.0f : 12.0f;
}

static inline float some_mask(void)
{
    const double u = uniform01();
    return u < 0.3 ? 0.0f : u < 0.6 ? 1.0f : u < 0.63 ? NAN : u < 0.66 ? -1.0f
           : u < 0.69 ? 3.0f : (float) uniform01();
}

/* Blobs of `size` pixels; f must stay where it is. The planes' windows differ
 * from the frame's. Freed by free_frame(). */
static inline void make_frame(struct sun_frame *f, struct gp_rect frame,
                              int planes, int size)
{
    struct gp_rect inner = frame;
    inner.x0 += gp_rect_w(frame) > 8 ? 2 : 0;
    inner.y1 -= gp_rect_h(frame) > 8 ? 1 : 0;
    *f = (struct sun_frame) {0};
    f->depth = plane_of(frame);
    f->mask = plane_of(inner);
    const int w = gp_rect_w(frame), h = gp_rect_h(frame);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++) {
            float *const at = &f->depth.v[(size_t) y * (size_t) w + (size_t) x];
            *at = x % size ? at[-1] : y % size ? *(at - w) : some_depth();
        }
    const size_t n = (size_t) gp_rect_w(inner) * (size_t) gp_rect_h(inner);
    for (size_t i = 0; i < n; i++)
        f->mask.v[i] = some_mask();
    f->o = (struct gp_occluders) {
        .depth = planes & WITH_DEPTH ? &f->depth : NULL,
        .mask = planes & WITH_MASK ? &f->mask : NULL, .frame = frame,
    };
    gp_occluders_count(&f->o);
}

static inline void free_frame(struct sun_frame *f)
{
    free(f->depth.v);
    free(f->mask.v);
}

static inline struct gp_light light_at(double x, double y, double radius)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    l.x = x;
    l.y = y;
    l.radius = radius;
    l.visibility = -1.0;
    return l;
}

#endif
