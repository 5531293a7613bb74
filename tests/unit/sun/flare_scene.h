/* Elements, lights and pictures for the tests of flare. */
#ifndef GP_TESTS_FLARE_SCENE_H
#define GP_TESTS_FLARE_SCENE_H

#include "unit.h"

#include "said.h"
#include "sun/sun_priv.h"

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
    assert_int_equal(gp_planes_make(&said_log, "test", n, &p.layer), GP_OK);
    for (int c = 0; c < 3; c++)
        memset(p.layer.c[c], 0, n * sizeof(float));
    return p;
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
    assert_int_equal(gp_flare_add(&said_log, f, light, n, p->frame,
                                  p->display, &p->layer), GP_OK);
}

static inline struct gp_light light_at(double x, double y)
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
    {.shape = GP_FLARE_RING, .size = 0.5, .width = 1e-6},
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
    static unsigned long serial;
    struct gp_flare_image m = {.w = w, .h = h, .cx = cx, .cy = cy,
                               .serial = ++serial};
    assert_int_equal(gp_planes_make(&said_log, "test",
                                    (size_t) w * (size_t) h, &m.rgb), GP_OK);
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

static inline struct gp_flare all_shapes(struct gp_flare_element *out)
{
    int n = 0;
    for (; n < (int) COUNT(laws); n++) {
        out[n] = whole(laws[n]);
        out[n].at = 0.2 * n - 1.0;
    }
    for (int i = 0; i < 4; i++, n++) {
        out[n] = ELEMENT(.shape = GP_FLARE_IMAGE, .plain = i == 0,
            .at = 0.7 * i, .rotation = 20.0 * i, .size = 0.3 / (1 + i));
        out[n].image = image_make(80 + i, 40 + 9 * i, 40.0, 20.0, i > 1);
        out[n].scale[2] = i == 3 ? 1.25f : 1.0f;
    }
    return (struct gp_flare) {out, n};
}

static inline void free_images(struct gp_flare_element *e, int n)
{
    for (int i = 0; i < n; i++)
        gp_planes_free(&e[i].image.rgb);
}

#endif
