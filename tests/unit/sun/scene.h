// SPDX-License-Identifier: Apache-2.0
/* Planes, lights, frames of random depth and coverage, and contexts, for tests
 * of the lights' shares; elements and pictures for those of flare. */
#ifndef GP_TESTS_SUN_SCENE_H
#define GP_TESTS_SUN_SCENE_H

#include "unit.h"

#include "core/memory.h"
#include "kept_log.h"
#include "sun/flare_priv.h"
#include "sun/stage.h"

enum { MODES = 4 }; // of enum glarepp_outside

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
    l.outside = 0.25;
    l.visibility = -1.0; // must be written
    return l;
}

static inline double visibility(const struct gp_occluders *o, int outside,
                                struct gp_light l)
{
    l.visibility = -1.0;
    gp_sun_exact(o, (enum glarepp_outside) outside, &l, 1);
    return l.visibility;
}

static inline struct gp_plane plane_of(struct gp_rect window)
{
    struct gp_plane p = {.window = window};
    void *v;
    assert_ok(gp_alloc_zero(&kept_log, "test", (size_t) gp_rect_w(window) *
                            (size_t) gp_rect_h(window), sizeof *p.v, &v));
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
    struct gp_sun_map map;
} machines[2] __attribute__((unused));
static int machine_count __attribute__((unused));

static inline int open_machines(void **state)
{
    static const enum gp_gl_api apis[2] = {GP_GL_OSMESA, GP_GL_EGL};
    machine_count = 0;
    for (int i = 0; i < 2; i++) {
        if (gp_gl_open(&kept_log, apis[i], &machines[machine_count].gl))
            print_message("no context: %s\n", kept_line);
        else
            machine_count++;
    }
    return 0;
}

static inline int close_machines(void **state)
{
    for (int i = 0; i < machine_count; i++) {
        assert_ok(gp_gl_use(&kept_log, machines[i].gl));
        gp_sun_map_close(machines[i].gl, &machines[i].map);
        gp_sun_map_close(machines[i].gl, &machines[i].map);
        gp_gl_close(&machines[i].gl);
    }
    return 0;
}

/* Makes the i-th current; skips the test where there is none at all. */
static inline struct machine *machine_at(int i)
{
    if (!machine_count)
        skip_for("no GL");
    assert_ok(gp_gl_use(&kept_log, machines[i].gl));
    return &machines[i];
}

/* The shares of n lights by the sun map, or by readback, into l. */
static inline void measure(struct machine *m, const struct gp_occluders *o,
    const struct glarepp_light_params *p, bool readback, struct gp_light *l, int n)
{
    struct glarepp_light_params own = *p;
    own.method = readback ? GLAREPP_READBACK : GLAREPP_MASK;
    assert_ok(gp_sun_by_gl(&kept_log, m->gl, o, &own, l, n, &m->map));
}

// -- pictures ----------------------------------------------------------------

struct picture {
    struct gp_rect frame, display;
    struct gp_planes layer;
};

static inline struct picture picture_make(struct gp_rect frame,
                                          struct gp_rect display)
{
    struct picture p = {.frame = frame, .display = display};
    const size_t n = (size_t) gp_rect_w(frame) * (size_t) gp_rect_h(frame);
    assert_ok(gp_planes_make(&kept_log, "test", n, &p.layer));
    for (int c = 0; c < 3; c++)
        memset(p.layer.c[c], 0, n * sizeof(float));
    return p;
}

/* One that shows all of its display window. */
static inline struct picture picture_of(int w, int h)
{
    const struct gp_rect r = {0, 0, w, h};
    return picture_make(r, r);
}

static inline void picture_free(struct picture *p)
{
    gp_planes_free(&p->layer);
}

static inline size_t picture_pixels(const struct picture *p)
{
    return (size_t) gp_rect_w(p->frame) * (size_t) gp_rect_h(p->frame);
}

static inline double total(const struct picture *p, int c)
{
    double sum = 0.0;
    for (size_t i = 0; i < picture_pixels(p); i++)
        sum += (double) p->layer.c[c][i];
    return sum;
}

static inline void add(struct picture *p, const struct gp_flare *f,
                       const struct gp_light *light, int n)
{
    assert_ok(gp_flare_add(&kept_log, f, light, n, p->frame,
                                  p->display, &p->layer));
}

/* One element of one light. */
static inline void add_one(struct picture *p, struct gp_flare_element e,
                           struct gp_light l)
{
    add(p, &(struct gp_flare) {.element = &e, .n = 1}, &l, 1);
}

static inline struct gp_light lamp_at(double x, double y)
{
    struct gp_light l = GP_LIGHT_DEFAULTS;
    l.x = x;
    l.y = y;
    l.flux[0] = 100.0f;
    l.flux[1] = 80.0f;
    l.flux[2] = 60.0f;
    return l;
}

/* With what is not given (0) as it is by default, and a colour. */
static inline struct gp_flare_element whole(struct gp_flare_element e)
{
    static const float colour[3] = {0.5f, 0.25f, 0.125f};
    e.width = e.width > 0.0 ? e.width : 0.1;
    e.sides = e.sides ? e.sides : 6;
    e.count = e.count ? e.count : 1;
    e.aspect = e.aspect > 0.0 ? e.aspect : 1.0;
    e.completion = e.completion > 0.0 ? e.completion : 1.0;
    e.falloff = e.falloff > 0.0 ? e.falloff : 6.0;
    memcpy(e.colour, colour, sizeof colour);
    for (int c = 0; c < 3; c++)
        e.scale[c] = e.scale[c] > 0.0f ? e.scale[c] : 1.0f;
    return e;
}
#define ELEMENT(...) whole((struct gp_flare_element) {__VA_ARGS__})

/* Sizes are fractions of a display 300 high. */
static const struct gp_flare_element laws[] = {
    {.shape = GP_FLARE_DISC, .size = 0.001},
    {.shape = GP_FLARE_DISC, .size = 0.0},
    {.shape = GP_FLARE_DISC, .size = 0.01},
    {.shape = GP_FLARE_DISC, .size = 0.1, .scale = {0.5f, 1, 2}},
    {.shape = GP_FLARE_DISC, .size = 0.33},
    {.shape = GP_FLARE_DISC, .size = 0.7, .scale = {0.01f, 1, 1.2f}},
    {.shape = GP_FLARE_RING, .size = 0.001},
    {.shape = GP_FLARE_RING, .size = 0.01, .width = 1e-6},
    {.shape = GP_FLARE_RING, .size = 0.33, .width = 0.01},
    {.shape = GP_FLARE_RING, .size = 0.33, .width = 1e-6},
    {.shape = GP_FLARE_RING, .size = 0.33, .width = 1.0},
    {.shape = GP_FLARE_RING, .size = 0.7, .scale = {0.9f, 1, 1.1f}},
    {.shape = GP_FLARE_POLYGON, .size = 0.001, .sides = 3},
    {.shape = GP_FLARE_POLYGON, .size = 0.0, .sides = 64},
    {.shape = GP_FLARE_POLYGON, .size = 0.33, .sides = 3},
    {.shape = GP_FLARE_POLYGON, .size = 0.33, .sides = 4},
    {.shape = GP_FLARE_POLYGON, .size = 0.4, .rotation = 15.0,
            .scale = {1.3f, 1, 0.7f}},
    {.shape = GP_FLARE_POLYGON, .size = 0.4, .sides = 64},
    {.shape = GP_FLARE_STREAK, .size = 0.001},
    {.shape = GP_FLARE_STREAK, .size = 0.02, .width = 1.0},
    {.shape = GP_FLARE_STREAK, .size = 0.34, .width = 1e-6},
    {.shape = GP_FLARE_STREAK, .size = 0.7, .rotation = 45.0},
    {.shape = GP_FLARE_STREAK, .size = 0.7, .rotation = -77.0,
            .width = 0.1, .scale = {1, 0.5f, 1.1f}},
};

static inline struct gp_flare_image image_make(int w, int h, double cx,
                                               double cy, bool hot)
{
    struct gp_flare_image m = {.w = w, .h = h, .cx = cx, .cy = cy};
    assert_ok(gp_planes_make(&kept_log, "test",
                                    (size_t) w * (size_t) h, &m.rgb));
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < w * h; i++) {
            const double x = (i % w + 0.5) / w - 0.5;
            const double y = (i / w + 0.5) / h - 0.5;
            m.rgb.c[c][i] = (float) ((c + 1) * exp(-18.0 * (x * x + y * y)));
            if (hot && i != w * (h / 2) + w / 2)
                m.rgb.c[c][i] *= 1e-3f;
        }
    }
    return m;
}

#endif
