/* Polygons and kernels made up for the gathering per tile, and their layer. */
#ifndef GP_TESTS_TILE_SCENE_H
#define GP_TESTS_TILE_SCENE_H

#include "gl_open.h"
#include "glare/splat/splat_priv.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* -- scenes ---------------------------------------------------------------- */

static uint32_t seed;

static inline float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float) (seed >> 8) * 0x1p-24f;
}

enum shape { GREY, COLOUR, LOBES, BOX };

static inline struct gp_kernel make_kernel(int w, int h, int cx, int cy,
                                           enum shape shape)
{
    static unsigned long serial;
    struct gp_kernel k = {.w = w, .h = h, .cx = cx, .cy = cy,
                          .grey = shape != COLOUR, .serial = ++serial};
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &k.k))
        abort();
    for (int i = 0; i < w * h; i++) {
        double dx = i % w - w / 2, dy = i / w - h / 2;
        for (int c = 0; c < 3; c++) {
            double fall = shape == COLOUR ? 0.1 * (c + 1) : 0.2;
            double v = 1.0 / (1.0 + fall * (dx * dx + dy * dy));
            k.k.c[c][i] = (float) (shape == BOX ? 0.1 : shape == LOBES
                                   ? v * cos(0.7 * dx) * cos(0.4 * dy) : v);
        }
    }
    return k;
}

enum where { WHOLE, BETWEEN, MIXED }; // on pixels, between them, both

struct row {
    int w, h, n;
    enum where where;
    int blurs;  // polygons take blurs 0 to blurs - 1
    int reach;  // by bins from this one on; 0 draws all
    int kw, kh, cx, cy;
    enum shape shape;
    struct gp_rect crop; // of the kernel; empty: all
    bool tail;
};

struct scene {
    int w, h;
    struct gp_kernel kernel;
    struct gp_rect crop;
    bool tail;
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    struct gp_planes layer;
};

static inline float place(enum where where, int i, int size)
{
    float at = uniform() * (float) (size - 1);
    return where == WHOLE || (where == MIXED && i % 2) ? floorf(at) : at;
}

static inline struct scene make_scene(const struct row *r)
{
    struct scene s = {.w = r->w, .h = r->h, .crop = r->crop, .tail = r->tail};
    s.kernel = make_kernel(r->kw, r->kh, r->cx, r->cy, r->shape);
    if (gp_rect_empty(s.crop))
        s.crop = (struct gp_rect) {0, 0, r->kw, r->kh};
    s.polygons.n = (size_t) r->n;
    s.polygons.at = calloc((size_t) r->n + 1, sizeof *s.polygons.at);
    for (int i = 0; i < r->n; i++) {
        struct gp_polygon *g = &s.polygons.at[i];
        g->x = place(r->where, i, r->w);
        g->y = place(r->where, i, r->h);
        g->blur = (uint8_t) (i % r->blurs);
        for (int c = 0; c < 3; c++)
            g->rgb[c] = i % 11 == c ? 0.0f : i % 5 == 0
                        ? 65504.0f * uniform() : 1.0f + uniform();
        g->light = (g->rgb[0] + g->rgb[1] + g->rgb[2]) / 3.0f;
    }
    for (int b = 0; b < GP_SOURCE_BINS; b++) // up to 50 pixels for 65504
        s.shrink.reach[b] = r->reach ? (b > r->reach ? b - r->reach : 0)
                                     : INT_MAX / 2;
    size_t samples = (size_t) r->w * (size_t) r->h;
    if (gp_planes_make(NULL, "layer", samples, &s.layer))
        abort();
    for (int c = 0; c < 3; c++) // every sample must be written
        memset(s.layer.c[c], 0xff, samples * sizeof(float));
    return s;
}

static inline void free_scene(struct scene *s)
{
    gp_planes_free(&s->kernel.k);
    gp_planes_free(&s->layer);
    free(s->polygons.at);
}

static inline gp_status draw(struct gp_gl *gl, struct scene *s,
                             struct gp_tiles **state, double *roundings)
{
    return gp_tiles_draw(&log_kept, gl, &s->kernel, s->crop, s->tail,
                         &s->polygons, &s->shrink, s->w, s->h, &s->layer,
                         state, roundings);
}

#endif
