// SPDX-License-Identifier: Apache-2.0
/* Shapes of profiles: integrals over pixels of light around a point. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/curve.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* The profile p(t) of pixels away from the light; its own and those near it,
 * where p is steep, by rings. */
struct radial_table {
    struct gp_field f;
    int channels;
    int bends;       // longer sides within which 4 nodes are the fewest
    struct gp_curve profile;
    struct gp_curve far; // square pixels from FAR sides on: their means
    struct gp_deposit near;
};

/* From so many sides of square pixels on, the mean over tents is
 *   p + side^2 / 12 laplace p,
 * whose next terms are under 1 / FAR^4 of powers of the distance: 6e-8. */
enum { FAR = 64 };

/* Adds the mean over the pixel (px, py), `far` longer sides from the light. */
static inline void add_nodes(const struct radial_table *t, int far, int px,
                             int py, double sum[3])
{
    static const struct {
        int from, order; // longer sides from the light; nodes that keep 1e-8
    } orders[] = {{40, 2}, {16, 3}, {8, 4}, {4, 6}, {2, 10}};
    const double b = t->f.degrees, a = b * t->f.aspect;
    int k = far < t->bends ? 2 : 0;
    while (far < orders[k].from)
        k++;
    const struct gp_gauss *const g = gp_tent_rule(orders[k].order);
    for (int q = 0; q < g->n; q++) {
        const double v = b * (py + g->node[q]);
        for (int p = 0; p < g->n; p++) {
            const double u = a * (px + g->node[p]);
            gp_curve_add(&t->profile, u * u + v * v,
                         a * b * g->weight[p] * g->weight[q], sum);
        }
    }
}

static void radial_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct radial_table *const t = state;
    const double b = t->f.degrees, a = b * t->f.aspect, side = fmax(a, b);
    for (int i = 0; i < n; i++) {
        const int px = abs(x + i), py = abs(y);
        const int far = (int) (gp_maxd(a * px, b * py) / side + 1e-9);
        double sum[3] = {0};
        if (px <= t->near.rx && py <= t->near.ry) {
            double *to[3] = {&sum[0], &sum[1], &sum[2]};
            gp_deposit_row(&t->near, px, py, 1, to);
        } else if (t->far.value && far >= FAR && far >= t->bends) {
            const double u = a * px, v = a * py;
            gp_curve_add(&t->far, u * u + v * v, a * a, sum);
        } else {
            add_nodes(t, far, px, py, sum);
        }
        for (int c = 0; c < t->channels; c++)
            out[c][i] = gp_maxd(sum[c], 0.0);
    }
}

static void free_radial(void *state)
{
    struct radial_table *const t = state;
    gp_free(t->near.v[0]);
    gp_free(t->profile.value);
    gp_free(t->far.value);
    gp_free(t);
}

// -- rings --------------------------------------------------------------------

/* Adds the first quarter of the circle of radii (u, v) pixels about the light:
 * arcs between the places where it passes from pixel to pixel, on which tents
 * are straight. */
static void add_circle(const struct gp_deposit *d, double u, double v,
                       const double light[3])
{
    const int columns = (int) fmin(u, d->rx + 1.0);
    const int rows = (int) fmin(v, d->ry + 1.0);
    // angles that grow: columns from the last, rows from the first
    int column = columns, row = 1;
    double from = 0.0;
    for (;;) {
        const double by_column =
            column > 0 ? gp_acos(fmin(column / u, 1.0)) : 0.5 * M_PI;
        const double by_row =
            row <= rows ? gp_asin(fmin(row / v, 1.0)) : 0.5 * M_PI;
        const double to = fmin(by_column, by_row);
        const struct gp_gauss *const g = gp_gauss_rule(to - from > 0.5 ? 7 : 4);
        for (int k = 0; k < g->n && to > from; k++) {
            const double angle =
                0.5 * (from + to) + (to - from) * g->node[k];
            const double share = (to - from) * g->weight[k] / (2.0 * M_PI);
            const double arc[3] = {share * light[0], share * light[1],
                                   share * light[2]};
            gp_deposit_add(d, u * gp_cos(angle), v * gp_sin(angle), arc);
        }
        if (column <= 0 && row > rows)
            return;
        from = fmax(from, to);
        if (column > 0 && by_column <= by_row)
            column--;
        else
            row++;
    }
}

/* Adds the rings of a profile from `from` to `to` degrees, on which it bends
 * little. */
static void add_rings(const struct gp_deposit *d, gp_profile p,
    const void *ctx, const struct gp_field *f, double from, double to)
{
    const struct gp_gauss *const g = gp_gauss_rule(6);
    const double b = f->degrees, a = b * f->aspect;
    while (from < to) {
        // to where circles begin to reach another column or row
        const double next = fmin(a * floor(from / a * (1.0 + 1e-12) + 1.0),
                                 b * floor(from / b * (1.0 + 1e-12) + 1.0));
        const double end = next < to ? next : to;
        for (int k = 0; k < g->n; k++) {
            // a circle's part beyond a line grows with the root of the distance
            const double root = 0.5 + g->node[k];
            const double t = from + (end - from) * root * root;
            const double ring = 2.0 * M_PI * t * (end - from) * 2.0 * root *
                                g->weight[k];
            double v[3] = {0};
            p(ctx, t, v);
            for (int c = 0; c < 3; c++)
                v[c] *= ring;
            add_circle(d, t / a, t / b, v);
        }
        from = end;
    }
}

/* Returns the start of ring i: each is a tenth wider than the one before. */
static double ring_from(int i)
{
    static const double LEAST = 1e-6, RATIO = 1.1;
    return i > 0 ? LEAST * gp_pow(RATIO, i - 1.0) : 0.0;
}

/* Fills pixels under two of the longer sides from the light; where pixels are
 * wide, those within which the sky's profiles bend. */
static gp_status make_near(const struct gp_log *log, gp_profile p,
                           const void *ctx, struct radial_table *t)
{
    static const double BENDS = 180.0, WIDE = 4.0;
    const double b = t->f.degrees, a = b * t->f.aspect;
    const double sides = 2.0 * fmax(a, b) * (1.0 - 1e-9);
    const double reach = fmin(a, b) > WIDE ? fmax(BENDS, sides) : sides;
    const int rx = (int) ceil(reach / a) - 1;
    const int ry = (int) ceil(reach / b) - 1;
    const size_t w = 2 * (size_t) rx + 1, n = w * (2 * (size_t) ry + 1);
    const double end = gp_hypot(a * (rx + 1), b * (ry + 1));
    gp_status st = gp_deposit_make(log, t->channels, rx, ry, &t->near);
    if (st)
        return st;
    for (int i = 0; ring_from(i) < end; i++)
        add_rings(&t->near, p, ctx, &t->f, ring_from(i),
                  fmin(ring_from(i + 1), end));
    for (size_t k = 0; k < 3 * n; k++) { // both sides of the axes
        t->near.v[0][k] *= (k % w == (size_t) rx ? 2.0 : 1.0) *
                           (k % n / w == (size_t) ry ? 2.0 : 1.0);
    }
    return GP_OK;
}

/* Fills entry i of the profile's table, and the far one's value. */
static void fill_entry(struct radial_table *t, gp_profile p, const void *ctx,
                       int i)
{
    static const double h = 1e-3; // of s, for slopes
    const double twelfth = t->f.degrees * t->f.degrees / 12.0;
    const int far = i - (int) (t->far.first - t->profile.first);
    double step, at[3], low[3], high[3];
    const double s = gp_curve_square(&t->profile, i, &step);
    p(ctx, sqrt(s), at);
    p(ctx, sqrt(s * (1.0 - h)), low);
    p(ctx, sqrt(s * (1.0 + h)), high);
    for (int c = 0; c < t->channels; c++) {
        const double slope = (high[c] - low[c]) / (2.0 * h * s);
        const double bend = (high[c] - 2.0 * at[c] + low[c]) / (h * h * s * s);
        double *const v = t->profile.value + 2 * (i * t->channels + c);
        v[0] = at[c];
        v[1] = slope * step;
        if (t->far.value && far >= 0)
            t->far.value[2 * (far * t->channels + c)] =
                at[c] + twelfth * 4.0 * (s * bend + slope);
    }
}

/* Fills the far table's slopes: the profile's, and what neighbours differ from
 * it by, which is little. */
static void fill_far_slopes(struct radial_table *t)
{
    const struct gp_curve *const far = &t->far;
    const int channels = t->channels, first = (int) (far->first -
                                                     t->profile.first);
    for (int i = 0; i < channels * (far->n + 1); i++) {
        const int at = i / channels, c = i % channels;
        const int ends[2] = {at > 0 ? at - 1 : 0, at < far->n ? at + 1 : at};
        double step, s[2], more[2];
        for (int k = 0; k < 2; k++) {
            const int of = ends[k] * channels + c;
            s[k] = gp_curve_square(far, ends[k], &step);
            more[k] = far->value[2 * of] -
                      t->profile.value[2 * (first * channels + of)];
        }
        gp_curve_square(far, at, &step);
        far->value[2 * i + 1] =
            t->profile.value[2 * (first * channels + i) + 1] +
            step * (more[1] - more[0]) / (s[1] - s[0]);
    }
}

gp_status gp_radial_shape(const struct gp_log *log, gp_profile p,
    const void *ctx, int channels, double bends, const struct gp_field *f,
    struct gp_shape *out)
{
    static const double END = 1e6; // degrees: over 5000 frames of 180
    const double least = f->degrees * fmin(f->aspect, 1.0);
    const double most = f->degrees * fmax(f->aspect, 1.0);
    struct radial_table *t;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *t, &t);
    if (st)
        return st;
    t->f = *f;
    t->channels = channels;
    t->bends = (int) fmin(bends / most + 1.0, INT_MAX / 2);
    st = make_near(log, p, ctx, t);
    if (!st)
        st = gp_curve_make(log, channels, least, END, &t->profile);
    if (!st && f->aspect == 1.0)
        st = gp_curve_make(log, channels, FAR * least, END, &t->far);
    if (st) {
        free_radial(t);
        return st;
    }
    for (int i = 0; i <= t->profile.n; i++)
        fill_entry(t, p, ctx, i);
    if (t->far.value)
        fill_far_slopes(t);
    *out = (struct gp_shape) {
        .state = t, .free = free_radial, .row = radial_row,
        .grey = channels == 1, .even = true, .reach = INT_MAX,
    };
    return GP_OK;
}
