// SPDX-License-Identifier: Apache-2.0
/* The torus: places on it, and what transforms of it leave. */
#include "core/luminance.h"
#include "core/maths.h"
#include "core/minmax.h"
#include "glare/fft/fft.h"

#include <limits.h>

// -- places on the torus ------------------------------------------------------

struct axis {
    int out0, out1, tap0, tap1;
    int period; // the least
};

/* One axis: sources [in0, in1), kernel offsets [-c, w - 1 - c], frame [0, n). */
static struct axis place_axis(int in0, int in1, int c, int w, int n)
{
    struct axis a = {gp_max(0, in0 - c), gp_min(n, in1 + w - 1 - c), 0, 0, 0};
    if (a.out1 <= a.out0) // nothing of the kernel reaches the frame
        a.out1 = a.out0 = 0;
    a.tap0 = gp_max(-c, a.out0 - (in1 - 1));
    a.tap1 = gp_min(w - c, a.out1 - in0);
    const int right = in1 - 1 + a.tap1 - 1 - a.out0; // wraps to the left end
    const int left = a.out1 - 1 - (in0 + a.tap0);
    a.period =
        gp_max(gp_max(right, left) + 1, gp_max(in1 - in0, a.tap1 - a.tap0));
    return a;
}

struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k)
{
    struct gp_fft_placing p = {.in = s->box};
    const struct axis x = place_axis(p.in.x0, p.in.x1, k->cx, k->w, s->w);
    const struct axis y = place_axis(p.in.y0, p.in.y1, k->cy, k->h, s->h);
    p.out = (struct gp_rect) {x.out0, y.out0, x.out1, y.out1};
    p.taps = (struct gp_rect) {x.tap0, y.tap0, x.tap1, y.tap1};
    if (!gp_rect_empty(p.out)) {
        p.nx = gp_fft_length(x.period);
        p.ny = gp_fft_length(y.period);
    }
    return p;
}

/* Adds squares and samples of w samples to those of the quarters left and right of
 * the centre, cx, as far as `reach`. */
static void add_sides(const float *row, int w, int cx, int reach,
                      double square[2], double sum[2])
{
    for (int i = 0; i < 2; i++) {
        const int from = gp_max(i ? cx : cx - reach, 0);
        const int last = gp_min(i ? cx + reach : cx, w - 1);
        double side[2] = {0};
        gp_samples_add(row + from, last + 1 - from, &side[0], &side[1]);
        square[i] += side[0];
        sum[i] += side[1];
    }
}

static double least_of(double v[2][2])
{
    return fmin(fmin(v[0][0], v[0][1]), fmin(v[1][0], v[1][1]));
}

void gp_fft_find_quarters(const struct gp_kernel *k, int w, int h,
                          struct gp_fft_quarters *out)
{
    // distance from the centre that a source in the frame surely sees, to one
    // side at least: everything, where the kernel has no more samples than that
    const int reach_x = k->w - 1 <= w ? INT_MAX / 2 : w / 2;
    const int reach_y = k->h - 1 <= h ? INT_MAX / 2 : h / 2;
    *out = (struct gp_fft_quarters) {0};
    for (int c = 0; c < 3 && !k->negative; c++) {
        double square[2][2] = {{0}}, sum[2][2] = {{0}}; // above, below
        for (int y = 0; y < k->h; y++) {
            const float *const row = gp_row(k->k.c[c], k->w, y);
            if (y <= k->cy && y >= k->cy - reach_y)
                add_sides(row, k->w, k->cx, reach_x, square[0], sum[0]);
            if (y >= k->cy && y <= k->cy + reach_y)
                add_sides(row, k->w, k->cx, reach_x, square[1], sum[1]);
        }
        out->square[c] = least_of(square);
        out->sum[c] = least_of(sum);
    }
}

double gp_fft_least(const struct gp_sources *s, const struct gp_fft_quarters *q)
{
    double all = 0.0;
    for (int c = 0; c < 3; c++) {
        const double flux = s->flux[c] * q->sum[c];
        all += fmax(s->energy[c] * q->square[c],
                    flux * flux / ((double) s->w * s->h));
    }
    return sqrt(all);
}

// -- noise --------------------------------------------------------------------

/* Roundings' deviations in units of 2^-24 of what is rounded: fft.h. */
static const double STAGE = 0.75, ADDING = 0.45;

double gp_fft_rounding(bool in_double)
{
    return in_double ? 0x1p-53 : 0x1p-24;
}

double gp_fft_bound(const struct gp_sources *s, const struct gp_fft_norms *k,
                    double least, const struct gp_fft_placing *p)
{
    double noise = 0.0, layer = 0.0; // squares
    for (int c = 0; c < 3; c++) {
        const double norm = sqrt(s->energy[c]);
        const double young = fmin(norm * k->sum[c], s->flux[c] * k->norm[c]);
        noise += norm * norm * k->norm[c] * k->norm[c];
        layer += young * young;
    }
    if (!(least > 0.0))
        return INFINITY;
    return sqrt(gp_log((double) p->nx * p->ny) / M_LN2) *
           (2.0 * STAGE * sqrt(noise) + (STAGE + 2.0 * ADDING) * sqrt(layer)) /
           least;
}

double gp_fft_pixel_error(const struct gp_fft_placing *p,
                          const struct gp_sources *s,
                          const struct gp_fft_norms *k, int c)
{
    static const double T = 7.0;
    const double points = (double) p->nx * p->ny, light = sqrt(s->energy[c]);
    const double pair = (double) s->brightest * k->most[c];
    const double norm = fmin(light * k->sum[c], s->flux[c] * k->norm[c]);
    const double most =
        fmin(fmin((double) s->brightest * k->sum[c], s->flux[c] * k->most[c]),
             light * k->norm[c]);
    double sum = 0.0;
    for (double n = 1.0; n <= points; n *= 2.0) {
        const double mean = fmin(most * most, norm * norm / n);
        sum += mean + 2.0 * fmin(mean, n * pair * most);
    }
    return T * STAGE * sqrt(sum);
}

double gp_fft_noise(const struct gp_fft_placing *p, const struct gp_sources *s,
                    const struct gp_fft_norms *k, int c, bool most)
{
    static const double THERE = 18.0, BACK = 9.0; // deviations
    const double points = (double) p->nx * p->ny, light = sqrt(s->energy[c]);
    const double forward = (most ? THERE * STAGE : STAGE) * light * k->norm[c];
    const double layer = (most ? BACK * ADDING : STAGE) *
                         fmin(light * k->sum[c], s->flux[c] * k->norm[c]);
    return sqrt(gp_log(points) / (M_LN2 * points) *
                (2.0 * forward * forward + layer * layer));
}
