// SPDX-License-Identifier: Apache-2.0
/* The layer as it is defined, sample by sample, in double. */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/sky/sphere.h"

#include <math.h>

struct exact {
    const struct gp_sky *sky;
    const struct gp_sources *src;
    double *layer;
};

/* The sums of a pixel of a sphere. */
static void sum_sphere(const struct gp_sky *s, const struct gp_sources *src,
                       int x, int y, double sum[3])
{
    const struct gp_sky_sphere *const o = s->sphere;
    const double at[2] = {x, y + o->y0};
    for (int sy = 0; sy < src->h; sy++) {
        const double solid =
            gp_projection_solid(&s->p.projection, 0.0, sy + o->y0);
        for (uint32_t i = src->row[sy]; i < src->row[sy + 1]; i++) {
            // the shorter way around
            const int dx = src->x[i] - x, most = o->w / 2;
            const double from[2] = {x + (dx > most    ? dx - o->w
                                         : dx < -most ? dx + o->w
                                                      : dx),
                                    sy + o->y0};
            double share = solid * gp_sky_sphere_mean(s, at, from);
            if (!dx && sy == y)
                share += o->own[sy + o->y0];
            for (size_t k = 0; k < 3; k++)
                sum[k] += share * (double) src->rgb[k][i];
        }
    }
}

static void sum_pixel(const struct gp_sky *s, const struct gp_sources *src,
                      int x, int y, double sum[3])
{
    const struct gp_projection *const p = &s->p.projection;
    const double at[2] = {x, y};
    const double most = gp_sky_ellipse_at(p, x, y).most;
    for (int sy = 0; sy < src->h; sy++) {
        int span[2];
        gp_projection_span(p, 0.0, sy, src->w, span);
        for (uint32_t i = src->row[sy]; i < src->row[sy + 1]; i++) {
            const double from[2] = {src->x[i], sy};
            if (src->x[i] < span[0] || src->x[i] >= span[1])
                continue;
            double share = gp_sky_pixel(s, at, from, most);
            if (src->x[i] == x && sy == y)
                share += s->light.stays - s->facts.given;
            for (size_t k = 0; k < 3; k++)
                sum[k] += share * (double) src->rgb[k][i];
        }
    }
}

static void exact_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct exact *const e = ctx;
    const struct gp_sources *const src = e->src;
    const size_t w = (size_t) src->w, plane = w * (size_t) src->h;
    int span[2];
    gp_projection_span(&e->sky->p.projection, 0.0, y, src->w, span);
    for (int x = 0; x < src->w; x++) {
        const size_t i = (size_t) y * w + (size_t) x;
        const bool seen = x >= span[0] && x < span[1];
        double sum[3] = {0};
        if (isnan(e->layer[i]))
            continue;
        if (seen)
            (e->sky->sphere ? sum_sphere : sum_pixel)(e->sky, src, x, y, sum);
        for (int k = e->sky->from; k < e->sky->to; k++) {
            double *const to = &e->layer[(size_t) k * plane + i];
            *to = seen ? *to + sum[k] : 0.0;
        }
    }
}

gp_status gp_sky_exact(const struct gp_log *log, const struct gp_sky *sky,
                       const struct gp_sources *src, double *layer)
{
    struct exact e = {sky, src, layer};
    struct gp_source *list = NULL;
    gp_status st = GP_OK;
    for (; e.sky && sky->p.n; e.sky = e.sky->next)
        gp_parallel_do(src->h, exact_row, &e);
    if (sky->p.cosines && src->n) {
        GP_TRY(gp_sources_list(log, src, &list));
        GP_TRY(gp_cosines_exact(log, sky->p.cosines, list, src->n, layer));
    }
out:
    gp_free(list);
    return st;
}
