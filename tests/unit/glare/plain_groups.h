// SPDX-License-Identifier: Apache-2.0
/* The layer of polygons in double: the plain form of every way to draw them,
 * and the CPU twin of the splat engine's shaders. */
#ifndef GP_TESTS_PLAIN_GROUPS_H
#define GP_TESTS_PLAIN_GROUPS_H

#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/splat/polygons.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct plain_drawing {
    const struct gp_sources *src;
    const struct gp_kernel *kernel;
    const struct gp_polygons *polygons;
    const struct gp_shrink *shrink;
    struct gp_blur blur[GP_BLURS]; // those in use
    bool middle;
    double *layer;
};

/* Pixels of [0, size) within `reach` of `at` that samples [-1, n - 1] of a
 * kernel meet, the sample at pixel 0 being `base`. */
static inline void plain_reached(float at, int reach, int base, int n, int size, int *from,
                    int *to)
{
    const double low = ceil((double) at - reach);
    const double high = floor((double) at + reach) + 1.0;
    *from = (int) fmax(fmax(low, 0.0), -1.0 - base);
    *to = (int) fmin(fmin(high, size), (double) n - base);
}

/* Adds the kernel's middle of the sources of row `sy` to row y. */
static inline void plain_middles(const struct plain_drawing *d, int sy, int y)
{
    const struct gp_kernel *const k = d->kernel;
    const size_t plane = (size_t) d->src->w * (size_t) d->src->h;
    const int ky = y - sy + k->cy;
    if (sy < 0 || sy >= d->src->h || ky < 0 || ky >= k->h)
        return;
    for (int c = 0; c < 3; c++) {
        const float *const row = k->k.c[c] + (size_t) ky * (size_t) k->w;
        double *const out =
            d->layer + (size_t) c * plane + (size_t) y * (size_t) d->src->w;
        for (uint32_t i = d->src->row[sy]; i < d->src->row[sy + 1]; i++) {
            for (int dx = -GP_MIDDLE_RADIUS; dx <= GP_MIDDLE_RADIUS; dx++) {
                const int x = d->src->x[i] + dx, kx = k->cx + dx;
                if (x >= 0 && x < d->src->w && kx >= 0 && kx < k->w)
                    out[x] += (double) d->src->rgb[c][i] * (double) row[kx];
            }
        }
    }
}

static inline void plain_groups_row(void *ctx, int y, int thread)
{
    const struct plain_drawing *const d = ctx;
    const size_t w = (size_t) d->src->w, plane = w * (size_t) d->src->h;
    (void) thread;
    for (size_t c = 0; c < 3; c++)
        memset(d->layer + c * plane + (size_t) y * w, 0, w * sizeof(double));
    for (size_t j = 0; j < d->polygons->n; j++) {
        // row y of the polygon's blurred kernel, mixed from four samples
        const struct gp_polygon *const p = &d->polygons->at[j];
        const struct gp_blur *const b = &d->blur[p->blur];
        const int reach = d->shrink->reach[gp_source_bin(p->light)];
        const double u = (double) b->cx - (double) p->x;
        const double v = (double) b->cy - (double) p->y;
        const int left = (int) floor(u), above = (int) floor(v);
        int x0, x1, y0, y1;
        plain_reached(p->x, reach, left, b->w, d->src->w, &x0, &x1);
        plain_reached(p->y, reach, above, b->h, d->src->h, &y0, &y1);
        for (int i = 0; i < 12 && y >= y0 && y < y1; i++) {
            const int c = i / 4, down = i / 2 % 2, right = i % 2;
            const int ky = y + above + down;
            const double share = (down ? v - above : 1.0 - (v - above)) *
                                 (right ? u - left : 1.0 - (u - left));
            const int first = gp_max(x0, -left - right);
            const int end = gp_min(x1, b->w - left - right);
            if (ky < 0 || ky >= b->h || share == 0.0)
                continue;
            const float *const row = b->k.c[c] + (size_t) ky * (size_t) b->w;
            double *const out = d->layer + (size_t) c * plane + (size_t) y * w;
            for (int x = first; x < end; x++)
                out[x] += (double) p->rgb[c] * share *
                          (double) row[x + left + right];
        }
    }
    for (int sy = y - GP_MIDDLE_RADIUS;
         d->middle && sy <= y + GP_MIDDLE_RADIUS; sy++)
        plain_middles(d, sy, y);
}

/* Writes 3 * w * h doubles, the layer of the polygons as they are meant to be
 * drawn: each adds light * blurred kernel, sampled bilinearly at pixel - P0, cut
 * to |dx|, |dy| <= reach of the shrink; unless sources are single, each adds its
 * middle. Slow. */
static inline void plain_groups(const struct gp_sources *src,
                                const struct gp_kernel *kernel,
                                const struct gp_splat_params *p,
                                const struct gp_polygons *polygons,
                                const struct gp_shrink *shrink, double *layer)
{
    struct plain_drawing d = {
        .src = src, .kernel = kernel, .polygons = polygons, .shrink = shrink,
        .middle = !gp_splat_single(p), .layer = layer,
    };
    const struct gp_rect whole = {0, 0, kernel->w, kernel->h};
    bool used[GP_BLURS] = {0};
    for (size_t i = 0; i < polygons->n; i++)
        used[polygons->at[i].blur] = true;
    for (int i = 0; i < GP_BLURS; i++) {
        if (used[i] && gp_blur_make(NULL, kernel, whole, d.middle,
                                    gp_blur_box[i], &d.blur[i]))
            abort();
    }
    gp_parallel_do(src->h, plain_groups_row, &d);
    for (int i = 0; i < GP_BLURS; i++)
        gp_planes_free(&d.blur[i].k);
}

#endif
