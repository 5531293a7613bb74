// SPDX-License-Identifier: Apache-2.0
/* The layer as it is defined, sample by sample, in double. */
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sphere.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct exact {
    const struct gp_sky *sky;
    const struct gp_sources *src;
    double *layer;
};

/* Pixels around one within two of its longest sides, the longest pixel that levels
 * serve being 16 times as long as wide. */
enum { NEAR = 34, SIDE = 2 * NEAR + 1 };

/* What pixels around one get, from the first of them on that is asked for. */
struct rings {
    bool known;
    double near[SIDE * SIDE];
};

static double share_of(const struct gp_sky *s, const double at[2],
                       const double from[2], const struct gp_sky_ellipse *o,
                       struct rings *rings)
{
    const int rx = gp_min((int) ceil(2.0 * o->most * o->x) + 1, NEAR);
    const int ry = gp_min((int) ceil(2.0 * o->most * o->y) + 1, NEAR);
    const int dx = (int) (at[0] - from[0]), dy = (int) (at[1] - from[1]);
    const bool close = abs(dx) <= rx && abs(dy) <= ry;
    if (close && !rings->known) {
        memset(rings->near, 0, sizeof rings->near);
        gp_sky_rings(&s->light, &s->p.projection, at, rx, ry, rings->near);
        rings->known = true;
    }
    return gp_sky_pixel(s, at, from, o->most,
                        close ? rings->near[(dy + ry) * (2 * rx + 1) + dx + rx]
                              : 0.0);
}

double gp_sky_share(const struct gp_sky *s, const double at[2],
                    const double from[2])
{
    const struct gp_sky_ellipse o =
        gp_sky_ellipse_at(&s->p.projection, at[0], at[1]);
    struct rings rings;
    rings.known = false;
    return share_of(s, at, from, &o, &rings);
}

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
    const struct gp_sky_ellipse o = gp_sky_ellipse_at(p, x, y);
    struct rings rings;
    rings.known = false;
    for (int sy = 0; sy < src->h; sy++) {
        int span[2];
        gp_projection_span(p, 0.0, sy, src->w, span);
        for (uint32_t i = src->row[sy]; i < src->row[sy + 1]; i++) {
            const double from[2] = {src->x[i], sy};
            if (src->x[i] < span[0] || src->x[i] >= span[1])
                continue;
            double share = share_of(s, at, from, &o, &rings);
            if (src->x[i] == x && sy == y)
                share += s->light.stays - s->given;
            for (size_t k = 0; k < 3; k++)
                sum[k] += share * (double) src->rgb[k][i];
        }
    }
}

static void exact_row(void *ctx, int y, int thread)
{
    const struct exact *const e = ctx;
    const struct gp_sources *const src = e->src;
    const size_t w = (size_t) src->w, plane = w * (size_t) src->h;
    int span[2];
    (void) thread;
    gp_projection_span(&e->sky->p.projection, 0.0, y, src->w, span);
    for (int x = 0; x < src->w; x++) {
        const size_t i = (size_t) y * w + (size_t) x;
        const bool seen = x >= span[0] && x < span[1];
        double sum[3] = {0};
        if (isnan(e->layer[i]))
            continue;
        if (seen)
            (e->sky->sphere ? sum_sphere : sum_pixel)(e->sky, src, x, y, sum);
        for (size_t k = 0; k < 3; k++) {
            double *const to = &e->layer[k * plane + i];
            *to = seen ? *to + sum[k] : 0.0;
        }
    }
}

void gp_sky_exact(const struct gp_sky *sky, const struct gp_sources *src,
                  double *layer)
{
    struct exact e = {sky, src, layer};
    gp_parallel_do(src->h, exact_row, &e);
}
