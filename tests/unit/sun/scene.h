/* Planes, lights, frames of random depth and coverage, and contexts, for tests
 * of the lights' shares. */
#ifndef GP_TESTS_SUN_SCENE_H
#define GP_TESTS_SUN_SCENE_H

#include "unit.h"

#include "core/memory.h"
#include "said.h"
#include "sun/sun_priv.h"

enum { MODES = 3 }; // of enum gp_sun_outside

static inline void assert_near(double got, double want, double bar,
                               const char *what, double detail)
{
    if (!(fabs(got - want) <= bar))
        fail_msg("%s, %g: %.17g, not %.17g: %g over %g", what, detail, got,
                 want, fabs(got - want), bar);
}

static uint32_t seed __attribute__((unused)) = 1;

/* In [0, 1). */
static inline double uniform01(void)
{
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    return seed / 4294967296.0;
}

// -- lights and planes -------------------------------------------------------

static inline struct gp_light light_at(double x, double y, double radius)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    l.x = x;
    l.y = y;
    l.radius = radius;
    l.visibility = -1.0; // must be written
    return l;
}

static inline double visibility(const struct gp_occluders *o, int outside,
                                struct gp_light l)
{
    l.visibility = -1.0;
    gp_sun_exact(o, (enum gp_sun_outside) outside, &l, 1);
    return l.visibility;
}

static inline struct gp_plane plane_of(struct gp_rect window)
{
    struct gp_plane p = {.window = window};
    void *v;
    assert_ok(gp_alloc_zero(&said_log, "test",
              (size_t) gp_rect_w(window) * (size_t) gp_rect_h(window),
              sizeof *p.v, &v));
    p.v = v;
    return p;
}

static inline struct gp_occluders occluders(const struct gp_plane *depth,
    const struct gp_plane *mask, struct gp_rect frame)
{
    struct gp_occluders o = {.depth = depth, .mask = mask, .frame = frame};
    gp_occluders_count(&o);
    return o;
}

// -- random frames -----------------------------------------------------------

struct sun_frame {
    struct gp_plane depth, mask;
    struct gp_occluders o;
};

enum { WITH_DEPTH = 1, WITH_MASK = 2 };

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
    const int w = gp_rect_w(frame), h = gp_rect_h(frame);
    struct gp_rect inner = frame;
    inner.x0 += w > 8 ? 2 : 0;
    inner.y1 -= h > 8 ? 1 : 0;
    *f = (struct sun_frame) {.depth = plane_of(frame), .mask = plane_of(inner)};
    for (int i = 0; i < w * h; i++) {
        const int x = i % w, y = i / w;
        f->depth.v[i] = x % size   ? f->depth.v[i - 1]
                        : y % size ? f->depth.v[i - w]
                                   : some_depth();
    }
    for (int i = 0; i < gp_rect_w(inner) * gp_rect_h(inner); i++)
        f->mask.v[i] = some_mask();
    f->o = occluders(planes & WITH_DEPTH ? &f->depth : NULL,
                     planes & WITH_MASK ? &f->mask : NULL, frame);
}

static inline void free_frame(struct sun_frame *f)
{
    gp_plane_free(&f->depth);
    gp_plane_free(&f->mask);
}

// -- contexts ----------------------------------------------------------------

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
    machine_count = 0;
    for (int i = 0; i < 2; i++) {
        if (gp_gl_open(&said_log, apis[i], &machines[machine_count].gl))
            print_message("no context: %s\n", said_line);
        else
            machine_count++;
    }
    return 0;
}

static inline int close_machines(void **state)
{
    for (int i = 0; i < machine_count; i++) {
        assert_ok(gp_gl_use(&said_log, machines[i].gl));
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
    assert_ok(gp_gl_use(&said_log, machines[i].gl));
    return &machines[i];
}

/* The shares of n lights by the sun map, or by readback, into l. */
static inline void measure(struct machine *m, const struct gp_occluders *o,
    const struct gp_map_params *p, bool readback, struct gp_light *l, int n)
{
    assert_ok(readback ? gp_sun_readback(&said_log, m->gl, o, p, l, n, &m->map)
                       : gp_sun_map_draw(&said_log, m->gl, o, p, l, n,
                                         &m->map));
    assert_ok(gp_sun_map_read(&said_log, m->gl, m->map, l, n));
}

#endif
