// SPDX-License-Identifier: Apache-2.0
/* Integrals of profiles over the plane. */
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

/* exp(-z^2 / 2) u^2 P(2 u - 1), u = 1 / (1 + z / 4): P meets the rest at the
 * roots of Chebyshev's polynomial. */
double gp_normal_twice(double z)
{
    static const double P[] = {
        0.0851988607739187, 0.12437925532171,   0.107561111057434,
        0.0617296090612081, 0.0212302373236186, 1.52267423887e-3,
        -2.23583394040e-3,  -7.4866086953e-4,   2.0491972817e-4,
        1.4298381355e-4,    -2.523969745e-5,    -2.532331479e-5,
        4.96602803e-6,      4.07749127e-6,      -1.07481319e-6,
        -4.2180509e-7,      1.4000339e-7,
    };
    const double u = 1.0 / (1.0 + 0.25 * fabs(z)), x = 2.0 * u - 1.0;
    double sum = 0.0;
    for (int i = (int) (sizeof P / sizeof *P) - 1; i >= 0; i--)
        sum = sum * x + P[i];
    return gp_exp(-0.5 * z * z) * u * u * sum - fmin(z, 0.0);
}

double gp_plane_factor(double t)
{
    const double radians = t * (M_PI / 180.0), degree = M_PI / 180.0;
    if (!(t < 90.0))
        return 0.0;
    return degree * degree * (radians > 1e-4 ? gp_sin(radians) / radians : 1.0);
}

void gp_profile_integral(gp_profile p, const void *ctx, int channels,
                         double from, double end, double sum[3])
{
    enum { STEPS = 512 };
    const struct gp_gauss *const g = gp_gauss_rule(8);
    const double least = fmax(from, 1e-6), growth = end / least;
    sum[0] = sum[1] = sum[2] = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        const double low =
            i > 0 ? least * gp_pow(growth, (i - 1.0) / STEPS) : from;
        const double high = least * gp_pow(growth, (double) i / STEPS);
        for (int k = 0; k < g->n && high > low; k++) {
            const double t = 0.5 * (low + high) + (high - low) * g->node[k];
            double v[3];
            p(ctx, t, v);
            for (int c = 0; c < channels; c++)
                sum[c] += (high - low) * g->weight[k] * 2.0 * M_PI * t * v[c];
        }
    }
}

// -- samples ------------------------------------------------------------------

static void samples_free(void *state)
{
    struct gp_samples *const s = state;
    gp_planes_free(&s->k);
    gp_free(s);
}

static void samples_row(const void *state, int x, int y, int n,
                        double *const out[3])
{
    const struct gp_samples *const s = state;
    for (int c = 0; c < s->channels; c++) {
        for (int i = 0; i < n; i++)
            out[c][i] =
                s->scale[c] * (double) gp_planes_at(&s->k, c, s->w, s->h,
                                                    x + i + s->cx, y + s->cy);
    }
}

gp_status gp_samples_shape(const struct gp_log *log, int w, int h, int cx,
                           int cy, int channels, struct gp_planes *k,
                           struct gp_shape *out)
{
    struct gp_samples *s;
    gp_status st = gp_alloc(log, "kernel", 1, sizeof *s, &s);
    if (st) {
        gp_planes_free(k);
        return st;
    }
    *s = (struct gp_samples) {w, h, cx, cy, channels, *k, {1.0, 1.0, 1.0}};
    *out = (struct gp_shape) {
        .state = s,
        .free = samples_free,
        .row = samples_row,
        .grey = channels == 1,
        .smooth = INFINITY,
        .reach = gp_max(gp_max(abs(cx), abs(w - 1 - cx)),
                        gp_max(abs(cy), abs(h - 1 - cy))),
    };
    return GP_OK;
}

gp_status gp_samples_make(const struct gp_log *log, int channels, int rx,
                          int ry, struct gp_shape *out)
{
    const int w = 2 * rx + 1, h = 2 * ry + 1;
    struct gp_planes k;
    gp_status st = gp_planes_make(log, "kernel", (size_t) w * (size_t) h, &k);
    return st ? st : gp_samples_shape(log, w, h, rx, ry, channels, &k, out);
}

// -- light of shapes finer than a pixel, shared out by where it falls ---------

gp_status gp_deposit_make(const struct gp_log *log, int channels, int rx,
                          int ry, struct gp_deposit *out)
{
    const size_t n = (2 * (size_t) rx + 1) * (2 * (size_t) ry + 1);
    struct gp_deposit d = {.channels = channels, .rx = rx, .ry = ry};
    gp_status st = gp_alloc_zero(log, "kernel", 3 * n, sizeof(double), &d.v[0]);
    if (st)
        return st;
    d.v[1] = d.v[0] + n;
    d.v[2] = d.v[1] + n;
    *out = d;
    return GP_OK;
}

void gp_deposit_add(const struct gp_deposit *d, double u, double v,
                    const double light[3])
{
    if (!(fabs(u) < d->rx + 1.0 && fabs(v) < d->ry + 1.0))
        return;
    const int x0 = (int) floor(u), y0 = (int) floor(v);
    const double right = u - x0, low = v - y0;
    for (int k = 0; k < 4; k++) {
        const int x = x0 + k % 2, y = y0 + k / 2;
        const double share = (k % 2 ? right : 1.0 - right) *
                             (k / 2 ? low : 1.0 - low);
        if (abs(x) > d->rx || abs(y) > d->ry)
            continue;
        const size_t at = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1) +
                          (size_t) (x + d->rx);
        for (int c = 0; c < d->channels; c++)
            d->v[c][at] += share * light[c];
    }
}

void gp_deposit_row(const void *deposit, int x, int y, int n,
                    double *const out[3])
{
    const struct gp_deposit *const d = deposit;
    const size_t row = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1);
    for (int i = 0; i < n; i++) {
        const bool inside = abs(y) <= d->ry && abs(x + i) <= d->rx;
        for (int c = 0; c < d->channels; c++)
            out[c][i] = inside ? d->v[c][row + (size_t) (x + i + d->rx)] : 0.0;
    }
}

static void free_deposit(void *state)
{
    gp_free(((struct gp_deposit *) state)->v[0]);
    gp_free(state);
}

gp_status gp_slices_join(const struct gp_log *log, const int slices[2],
    int rx, int ry, const struct gp_field *f, struct gp_shape *shape)
{
    struct gp_deposit *d;
    double strip[3];
    double *const out[3] = {&strip[0], &strip[1], &strip[2]};
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *d, &d);
    if (!st)
        st = gp_deposit_make(log, shape->grey ? 1 : 3,
                             gp_min((rx - 1) / slices[0] + 1, f->w - 1),
                             gp_min((ry - 1) / slices[1] + 1, f->h - 1), d);
    for (int y = -ry; y <= ry && !st; y++) {
        for (int x = -rx; x <= rx; x++) {
            shape->row(shape->state, x, y, 1, out);
            gp_deposit_add(d, (double) x / slices[0], (double) y / slices[1],
                           strip);
        }
    }
    shape->free(shape->state);
    if (st) {
        gp_free(d);
        return st;
    }
    const size_t n = (2 * (size_t) d->rx + 1) * (2 * (size_t) d->ry + 1);
    for (int c = 0; c < (shape->grey ? 1 : 3); c++) {
        for (size_t i = 0; i < n; i++) // (of all light, as where diffraction ends)
            d->v[c][i] = d->v[c][i] < 1e-20 ? 0.0 : d->v[c][i];
    }
    shape->state = d;
    shape->free = free_deposit;
    shape->row = gp_deposit_row;
    shape->reach = gp_max(d->rx, d->ry);
    return GP_OK;
}
