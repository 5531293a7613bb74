#include "glare/bound/rings.h"

#include "core/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A polygon's light lies within a square of twice its block's side, on the
 * lattice of blocks: so at most four of one size share a pixel, and the norm
 * of their sum is at most twice the root of their squares' sum. */
static const double SHARED = 2.0;

static int clamp(int v, int low, int high)
{
    return v < low ? low : v > high ? high : v;
}

static int max(int a, int b)
{
    return a > b ? a : b;
}

// -- the kernel ---------------------------------------------------------------

/* Sample (x, y), 0 outside and in the core. */
static double sample(const struct gp_kernel *k, bool tail, int c, int x, int y)
{
    if (x < 0 || x >= k->w || y < 0 || y >= k->h)
        return 0.0;
    if (tail && abs(x - k->cx) <= GP_CORE_RADIUS &&
        abs(y - k->cy) <= GP_CORE_RADIUS)
        return 0.0;
    return (double) k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x];
}

static double slopes(const struct gp_kernel *k, bool tail, int c,
                     struct gp_rect part)
{
    double sum = 0.0;
    for (int y = part.y0 - 1; y < part.y1; y++) {
        for (int x = part.x0 - 1; x < part.x1; x++) {
            const double v = sample(k, tail, c, x, y);
            sum += fabs(sample(k, tail, c, x + 1, y) - v) +
                   fabs(sample(k, tail, c, x, y + 1) - v);
        }
    }
    return sum;
}

/* Sums by ring, then of each ring and those beyond. */
static void fill(const struct gp_kernel *k, bool tail, int c,
                 struct gp_rect part, int n, double *beyond)
{
    for (int y = part.y0; y < part.y1; y++) {
        for (int x = part.x0; x < part.x1; x++)
            beyond[max(abs(x - k->cx), abs(y - k->cy))] +=
                sample(k, tail, c, x, y);
    }
    for (int i = n - 1; i >= 0; i--)
        beyond[i] += beyond[i + 1];
}

gp_status gp_bound_rings_make(const struct gp_log *log,
                              const struct gp_kernel *k, bool tail, int w,
                              int h, struct gp_bound_rings *out)
{
    gp_status st = GP_OK;
    void *v;
    struct gp_bound_rings r = {0};
    const struct gp_rect part = {
        clamp(k->cx - w, 0, k->w), clamp(k->cy - h, 0, k->h),
        clamp(k->cx + w + 1, 0, k->w), clamp(k->cy + h + 1, 0, k->h),
    };
    r.n = gp_rect_empty(part) ? 0 : max(w, h) + 1;
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc_zero(log, "bound", (size_t) r.n + 1, sizeof(double),
                             &v));
        r.beyond[c] = v;
        if (c > 0 && k->grey) {
            memcpy(r.beyond[c], r.beyond[0],
                   ((size_t) r.n + 1) * sizeof(double));
            r.slope[c] = r.slope[0];
        } else if (r.n) {
            fill(k, tail, c, part, r.n, r.beyond[c]);
            r.slope[c] = slopes(k, tail, c, part);
        }
    }
    *out = r;
    r = (struct gp_bound_rings) {0};
out:
    gp_bound_rings_free(&r);
    return st;
}

void gp_bound_rings_free(struct gp_bound_rings *r)
{
    for (int c = 0; c < 3; c++)
        gp_free(r->beyond[c]);
    *r = (struct gp_bound_rings) {0};
}

// -- the polygons -------------------------------------------------------------

/* Sum of squares of a polygon's bilinear and box weights on one axis. */
static double spread_square(const struct gp_polygon *p, float at)
{
    const int m = gp_blur_box[p->blur];
    const double start = (double) at - (m - 1) / 2.0;
    const double f = start - floor(start);
    return ((1.0 - f) * (1.0 - f) + f * f + (m - 1)) / ((double) m * m);
}

/* The light of one size of polygons by the first ring that they leave out. */
struct left {
    double *square; // of their light's norm: n
    double *sum;    // of their light: n
};

static void add_polygon(const struct gp_bound_rings *r,
                        const struct gp_polygon *p, int reach, int c,
                        const struct left *l)
{
    // half a box and a pixel between pixels carry light that far
    const int ring = reach - gp_blur_box[p->blur] / 2;
    const int at = ring > 0 ? ring : 0;
    const double light = (double) p->rgb[c];
    if (at >= r->n)
        return;
    l->sum[at] += light;
    l->square[at] += light * light * spread_square(p, p->x) *
                     spread_square(p, p->y);
}

/* Adds up one size of polygons; `l` is cleared. */
static void add_size(const struct gp_bound_rings *r, int c,
                     const struct left *l, double *sum, double *norm)
{
    double square = 0.0;
    for (int i = 0; i < r->n; i++) {
        square += l->square[i]; // all that leave ring i out
        *sum += l->sum[i] * r->beyond[c][i];
        *norm += (r->beyond[c][i] - r->beyond[c][i + 1]) * SHARED *
                 sqrt(square);
    }
    memset(l->square, 0, (size_t) r->n * sizeof(double));
    memset(l->sum, 0, (size_t) r->n * sizeof(double));
}

gp_status gp_bound_rings_left(const struct gp_log *log,
                              const struct gp_bound_rings *r,
                              const struct gp_polygons *polygons,
                              const struct gp_shrink *shrink, double sum[3],
                              double norm[3])
{
    void *v;
    gp_status st = gp_alloc_zero(log, "bound", 2 * (size_t) r->n,
                                 sizeof(double), &v);
    if (st)
        return st;
    const struct left l = {v, (double *) v + r->n};
    for (int c = 0; c < 3; c++) {
        sum[c] = norm[c] = 0.0;
        for (size_t i = 0; i < polygons->n; i++) {
            const struct gp_polygon *const p = &polygons->at[i];
            if (i == polygons->clusters)
                add_size(r, c, &l, &sum[c], &norm[c]);
            add_polygon(r, p, shrink->reach[gp_source_bin(p->light)], c, &l);
        }
        add_size(r, c, &l, &sum[c], &norm[c]);
    }
    gp_free(v);
    return GP_OK;
}

void gp_bound_rings_sampled(const struct gp_bound_rings *r,
                            const struct gp_polygons *polygons, double place,
                            double norm[3])
{
    for (int c = 0; c < 3; c++) {
        double square[2] = {0}; // clusters, groups
        for (size_t i = 0; i < polygons->n; i++) {
            const struct gp_polygon *const p = &polygons->at[i];
            const int m = gp_blur_box[p->blur];
            if (m == 1 && p->x == floorf(p->x) && p->y == floorf(p->y))
                continue; // fetched, not sampled
            // a slope is the box's of whole pixels on its axis
            const double v = (double) p->rgb[c] / m;
            square[i >= polygons->clusters] += v * v;
        }
        norm[c] = place * r->slope[c] * SHARED *
                  (sqrt(square[0]) + sqrt(square[1]));
    }
}
