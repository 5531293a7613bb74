#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/splat/blur.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct drawing {
    const struct gp_sources *src;
    const struct gp_kernel *kernel;
    const struct gp_polygons *polygons;
    const struct gp_shrink *shrink;
    struct gp_blur blur[GP_BLURS]; // those in use
    bool core;
    double *layer;
};

/* out[x] += light * bilinear(a, b)[x], x in [0, n). */
GP_CLONES static void add_row(double *restrict out, const double *restrict at,
                              int n, double f, double light)
{
    for (int x = 0; x < n; x++)
        out[x] += light * ((1.0 - f) * at[x] + f * at[x + 1]);
}

/* Row y of the polygon's blurred kernel between its rows, from sample x0 on,
 * n samples; 0 outside. */
static void blend_rows(const struct gp_blur *b, int c, int y, double f, int x0,
                       int n, double *out)
{
    for (int i = 0; i < n; i++)
        out[i] = 0.0;
    for (int k = 0; k < 2; k++) {
        const double part = k ? f : 1.0 - f;
        if (y + k < 0 || y + k >= b->h || part == 0.0)
            continue;
        const float *const row =
            b->k.c[c] + (size_t) (y + k) * (size_t) b->w;
        const int first = x0 < 0 ? -x0 : 0;
        const int end = x0 + n > b->w ? b->w - x0 : n;
        for (int i = first; i < end; i++)
            out[i] += part * (double) row[x0 + i];
    }
}

/* Pixels of [0, size) within `reach` of `at` that samples [-1, n - 1] of a
 * kernel meet, the sample at pixel 0 being `base`. */
static void span(float at, int reach, int base, int n, int size, int *from,
                 int *to)
{
    const double low = ceil((double) at - reach);
    const double high = floor((double) at + reach) + 1.0;
    *from = (int) fmax(fmax(low, 0.0), -1.0 - base);
    *to = (int) fmin(fmin(high, size), (double) n - base);
}

static void draw_polygon(const struct drawing *d, const struct gp_polygon *p,
                         int y, double *line)
{
    const struct gp_blur *const b = &d->blur[p->blur];
    const int reach = d->shrink->reach[gp_source_bin(p->light)];
    const size_t plane = (size_t) d->src->w * (size_t) d->src->h;
    const double u = (double) b->cx - (double) p->x;
    const double v = (double) b->cy - (double) p->y;
    int x0, x1, y0, y1;
    span(p->x, reach, (int) floor(u), b->w, d->src->w, &x0, &x1);
    span(p->y, reach, (int) floor(v), b->h, d->src->h, &y0, &y1);
    if (y < y0 || y >= y1 || x0 >= x1)
        return;
    for (int c = 0; c < 3; c++) {
        blend_rows(b, c, y + (int) floor(v), v - floor(v),
                   x0 + (int) floor(u), x1 - x0 + 1, line);
        add_row(d->layer + (size_t) c * plane +
                    (size_t) y * (size_t) d->src->w + x0,
                line, x1 - x0, u - floor(u), (double) p->rgb[c]);
    }
}

/* What the sources of row `sy` add to row y by the kernel's core. */
static void draw_cores(const struct drawing *d, int sy, int y)
{
    const struct gp_kernel *const k = d->kernel;
    const size_t plane = (size_t) d->src->w * (size_t) d->src->h;
    const int ky = y - sy + k->cy;
    if (ky < 0 || ky >= k->h)
        return;
    for (int c = 0; c < 3; c++) {
        const float *const row = k->k.c[c] + (size_t) ky * (size_t) k->w;
        double *const out =
            d->layer + (size_t) c * plane + (size_t) y * (size_t) d->src->w;
        for (uint32_t i = d->src->row[sy]; i < d->src->row[sy + 1]; i++) {
            for (int dx = -GP_CORE_RADIUS; dx <= GP_CORE_RADIUS; dx++) {
                const int x = d->src->x[i] + dx, kx = k->cx + dx;
                if (x >= 0 && x < d->src->w && kx >= 0 && kx < k->w)
                    out[x] += (double) d->src->rgb[c][i] * (double) row[kx];
            }
        }
    }
}

static gp_status draw_row(void *ctx, int y, int thread)
{
    const struct drawing *const d = ctx;
    const size_t w = (size_t) d->src->w, plane = w * (size_t) d->src->h;
    void *line;
    (void) thread;
    const gp_status st = gp_alloc(NULL, "", w + 1, sizeof(double), &line);
    if (st)
        return st;
    for (size_t c = 0; c < 3; c++)
        memset(d->layer + c * plane + (size_t) y * w, 0, w * sizeof(double));
    for (size_t i = 0; i < d->polygons->n; i++)
        draw_polygon(d, &d->polygons->at[i], y, line);
    for (int sy = y - GP_CORE_RADIUS; d->core && sy <= y + GP_CORE_RADIUS;
         sy++) {
        if (sy >= 0 && sy < d->src->h)
            draw_cores(d, sy, y);
    }
    gp_free(line);
    return GP_OK;
}

static gp_status make_blurs(const struct gp_log *log, struct drawing *d)
{
    bool used[GP_BLURS] = {0};
    const struct gp_rect whole = {0, 0, d->kernel->w, d->kernel->h};
    gp_status st = GP_OK;
    for (size_t i = 0; i < d->polygons->n; i++)
        used[d->polygons->at[i].blur] = true;
    for (int i = 0; i < GP_BLURS && !st; i++) {
        if (used[i])
            st = gp_blur_make(log, d->kernel, whole, d->core, gp_blur_box[i],
                              &d->blur[i]);
    }
    return st;
}

gp_status gp_group_reference(const struct gp_log *log,
                             const struct gp_sources *src,
                             const struct gp_kernel *kernel,
                             const struct gp_splat_params *p,
                             const struct gp_polygons *polygons,
                             const struct gp_shrink *shrink, double *layer)
{
    struct drawing d = {
        .src = src, .kernel = kernel, .polygons = polygons, .shrink = shrink,
        .core = p->method == GP_GROUP_CORE, .layer = layer,
    };
    gp_status st = make_blurs(log, &d);
    if (!st && gp_parallel(src->h, draw_row, &d, NULL))
        st = gp_fail_bare(log, GP_ERR_BUG,
                          "reference: out of memory (%d bytes); verify a "
                          "smaller frame", 8 * src->w);
    for (int i = 0; i < GP_BLURS; i++)
        gp_blur_free(&d.blur[i]);
    return st;
}
