// SPDX-License-Identifier: Apache-2.0
/* The layer as it is defined, sample by sample, in double. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <stdlib.h>

struct exact {
    const struct gp_sky *sky;
    const struct gp_sources *src;
    double *layer;
};

/* The share of the light of a source that pixel `at` gets, other than its own. */
static double share_of(const struct gp_sky *s, const double at[2],
                       const double from[2], double most)
{
    const struct gp_projection *const p = &s->p.projection;
    const double c = gp_projection_chord2(p, at[0], at[1], from[0], from[1]);
    return gp_projection_solid(p, from[0], from[1]) *
           gp_sky_mean(&s->light, p, 0.0, 0.0, gp_sky_order(sqrt(c) / most), at,
                       from);
}

static void exact_row(void *ctx, int y, int thread)
{
    const struct exact *const e = ctx;
    const struct gp_sources *const src = e->src;
    const struct gp_projection *const p = &e->sky->p.projection;
    const size_t w = (size_t) src->w, plane = w * (size_t) src->h;
    (void) thread;
    for (int x = 0; x < src->w; x++) {
        const double at[2] = {x, y};
        const struct gp_sky_ellipse o = gp_sky_ellipse_at(p, x, y);
        const int rx = (int) ceil(2.0 * o.most * o.x) + 1;
        const int ry = (int) ceil(2.0 * o.most * o.y) + 1;
        double *near = NULL, sum[3] = {0};
        if (isnan(e->layer[(size_t) y * w + (size_t) x]))
            continue;
        for (int sy = 0; sy < src->h; sy++) {
            for (uint32_t i = src->row[sy]; i < src->row[sy + 1]; i++) {
                const double from[2] = {src->x[i], sy};
                const int dx = x - src->x[i], dy = y - sy;
                const double c = gp_projection_chord2(p, x, y, from[0], sy);
                double share;
                if (c >= 4.0 * o.most * o.most) {
                    share = share_of(e->sky, at, from, o.most);
                } else {
                    const size_t n =
                        (2 * (size_t) rx + 1) * (2 * (size_t) ry + 1);
                    if (!near &&
                        gp_alloc_zero(NULL, "exact", n, sizeof *near, &near))
                        abort();
                    if (near[0] == 0.0 && near[n / 2] == 0.0)
                        gp_sky_rings(&e->sky->light, p, at, rx, ry, near);
                    share = near[(dy + ry) * (2 * rx + 1) + dx + rx];
                    if (!dx && !dy)
                        share += e->sky->light.stays - e->sky->given;
                }
                for (size_t k = 0; k < 3; k++)
                    sum[k] += share * (double) src->rgb[k][i];
            }
        }
        gp_free(near);
        for (size_t k = 0; k < 3; k++)
            e->layer[k * plane + (size_t) y * w + (size_t) x] += sum[k];
    }
}

void gp_sky_exact(const struct gp_sky *sky, const struct gp_sources *src,
                  double *layer)
{
    struct exact e = {sky, src, layer};
    gp_parallel_do(src->h, exact_row, &e);
}

void gp_sky_sample(const struct gp_sources *src, double *layer)
{
    static const double MOST = 4e8; // pairs of a source and a pixel
    static const double PIXELS = 3e5;
    const size_t n = (size_t) src->w * (size_t) src->h;
    const double each =
        ceil(fmax((double) src->n * (double) n / MOST, (double) n / PIXELS));
    for (size_t i = 0; i < n; i++) {
        const uint64_t hash = (i + 1) * 0x9e3779b97f4a7c15u;
        if (fmod((double) (hash >> 40), fmax(each, 1.0)) >= 1.0)
            layer[i] = layer[n + i] = layer[2 * n + i] = (double) NAN;
    }
}
