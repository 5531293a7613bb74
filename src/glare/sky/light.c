// SPDX-License-Identifier: Apache-2.0
/* Light by the chord, and its means over pixels. */
#include "core/maths.h"
#include "core/memory.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <string.h>

/* Light per steradian of model i. No formula reaches farther than 100 degrees: light
 * from behind is as from there. */
static double light_of(const struct gp_sky_params *p, int i, double chord2)
{
    static const double LAST = 100.0;
    const double t =
        2.0 * gp_asin(0.5 * sqrt(fmin(chord2, 4.0))) * (180.0 / M_PI);
    return p->part[i].light(&p->part[i], fmin(t, LAST));
}

/* The light of model i over the sphere: d Omega = pi d(chord^2), by octaves. */
static double sphere_of(const struct gp_sky_params *p, int i)
{
    enum { OCTAVES = 64 };
    const struct gp_gauss *const g = gp_gauss_rule(12);
    double sum = 0.0;
    for (int k = 0; k < OCTAVES; k++) {
        const double to = ldexp(4.0, -k),
                     from = k < OCTAVES - 1 ? 0.5 * to : 0.0;
        for (int q = 0; q < g->n; q++)
            sum += g->weight[q] * (to - from) * M_PI *
                   light_of(p, i, 0.5 * (from + to) + (to - from) * g->node[q]);
    }
    return sum;
}

gp_status gp_sky_light_make(const struct gp_log *log,
                            const struct gp_sky_params *p,
                            struct gp_sky_light *out)
{
    static const double H = 1e-3;       // of chord^2, for slopes
    static const double NEAREST = 1e-3; // of a pixel: nearer light is even
    struct gp_sky_light l = {.nearest = INFINITY};
    for (int i = 0; i < 5; i++) { // corners, and the axis
        const double x = i < 4 ? (i & 1) * (p->w - 1.0) : p->projection.x0;
        const double y = i < 4 ? (i >> 1) * (p->h - 1.0) : p->projection.y0;
        l.nearest = fmin(
            l.nearest, NEAREST * gp_sky_ellipse_at(&p->projection, x, y).most);
    }
    gp_status st = gp_curve_make(log, 1, l.nearest, 2.1, &l.curve);
    if (st)
        return st;
    memset(l.curve.value, 0, 2 * ((size_t) l.curve.n + 1) * sizeof(double));
    for (int k = 0; k < p->n; k++) {
        // all but what stays, over the sphere
        const double share = p->share[k] * (1.0 - p->part[k].stays);
        const double by = share / sphere_of(p, k);
        l.stays += p->share[k] - share;
        for (int i = 0; i <= l.curve.n; i++) {
            double step, *const v = l.curve.value + 2 * i;
            const double c = gp_curve_square(&l.curve, i, &step);
            v[0] += by * light_of(p, k, c);
            v[1] +=
                by * step / (2.0 * H * c) *
                (light_of(p, k, c * (1.0 + H)) - light_of(p, k, c * (1.0 - H)));
        }
    }
    *out = l;
    return GP_OK;
}

// -- means --------------------------------------------------------------------

int gp_sky_order(double away)
{
    return away >= 24.0   ? 2
           : away >= 10.0 ? 3
           : away >= 5.0  ? 4
           : away >= 3.0  ? 6
                          : 8;
}

double gp_sky_mean(const struct gp_sky_light *l, const struct gp_projection *p,
                   double a, double less, int order, const double at[2],
                   const double from[2])
{
    const struct gp_gauss *const g = gp_tent_rule(order);
    double sum = 0.0;
    for (int j = 0; j < g->n; j++) {
        const double v = 0.5 * g->node[j];
        for (int i = 0; i < g->n; i++) {
            const double u = 0.5 * g->node[i];
            const double c = gp_projection_chord2(p, at[0] + u, at[1] + v,
                                                  from[0] - u, from[1] - v);
            if (less > 0.0 && c >= less)
                continue; // both are P
            const double w = g->weight[i] * g->weight[j];
            sum += w * gp_sky_soft(l, a, c);
            if (less > 0.0)
                sum -= w * gp_sky_soft(l, less, c);
        }
    }
    return sum;
}

struct gp_sky_ellipse gp_sky_ellipse_at(const struct gp_projection *p, double x,
                                        double y)
{
    const struct gp_metric g = gp_projection_metric(p, x, y);
    const double mid = 0.5 * (g.xx + g.yy), half = 0.5 * (g.xx - g.yy);
    const double det = g.xx * g.yy - g.xy * g.xy;
    const double most = mid + gp_hypot(half, g.xy);
    return (struct gp_sky_ellipse) {
        sqrt(most),
        sqrt(fmax(det, 0.0) / most),
        sqrt(g.yy / det),
        sqrt(g.xx / det),
        sqrt(most) * sqrt(sqrt(fmin(sqrt(fmax(det, 0.0)) / most, 1.0))),
    };
}

// -- rings --------------------------------------------------------------------

/* Adds light at (u, v) pixels by the tents of both pixels. */
static void deposit(double u, double v, double light, int rx, int ry,
                    double *out)
{
    const double x = floor(u), y = floor(v), a = u - x, b = v - y;
    const int i = (int) x, j = (int) y;
    for (int k = 0; k < 4; k++) {
        const int px = i + (k & 1), py = j + (k >> 1);
        if (px < -rx || px > rx || py < -ry || py > ry)
            continue;
        out[(py + ry) * (2 * rx + 1) + px + rx] +=
            light * (k & 1 ? a : 1.0 - a) * (k >> 1 ? b : 1.0 - b);
    }
}

void gp_sky_rings(const struct gp_sky_light *l, const struct gp_projection *p,
                  const double at[2], int rx, int ry, double *out)
{
    enum { TURNS = 192 };
    static const double FIRST = 0.01, RATIO = 1.3, LAST = 3.5; // longest sides
    const struct gp_gauss *const g = gp_gauss_rule(5);
    const struct gp_metric m = gp_projection_metric(p, at[0], at[1]);
    const double side = gp_sky_ellipse_at(p, at[0], at[1]).most;
    // a step of length 1 by the metric: L^-T of its Cholesky factors
    const double l0 = sqrt(m.xx), l1 = m.xy / l0;
    const double l2 = sqrt(m.yy - l1 * l1);
    double turn[TURNS][2];
    for (int i = 0; i < TURNS; i++) {
        const double t = 2.0 * M_PI * (i + 0.5) / TURNS;
        turn[i][1] = gp_sin(t) / l2;
        turn[i][0] = (gp_cos(t) - l1 * turn[i][1]) / l0;
    }
    // light within the first ring, by octaves of its radius
    double inner = 0.0;
    for (double to = FIRST * side, from; to > l->nearest; to = from) {
        from = 0.5 * to > l->nearest ? 0.5 * to : 0.0;
        for (int k = 0; k < g->n; k++) {
            const double r = 0.5 * (from + to) + (to - from) * g->node[k];
            inner += g->weight[k] * (to - from) * 2.0 * M_PI * r *
                     gp_sky_soft(l, 0.0, fmax(r * r, l->nearest * l->nearest));
        }
    }
    deposit(0.0, 0.0, inner, rx, ry, out);
    for (double from = FIRST * side; from < LAST * side; from *= RATIO) {
        const double wide = from * (RATIO - 1.0);
        for (int k = 0; k < g->n; k++) {
            const double r = from + wide * (0.5 + g->node[k]);
            // d Omega = pi d(chord^2)
            const double light = g->weight[k] * wide * 2.0 * M_PI * r *
                                 gp_sky_soft(l, 0.0, r * r) / TURNS;
            for (int i = 0; i < TURNS; i++)
                deposit(r * turn[i][0], r * turn[i][1], light, rx, ry, out);
        }
    }
    // rings are the metric's; from place to place it changes
    const double own = gp_projection_solid(p, at[0], at[1]);
    for (int y = -ry; y <= ry; y++) {
        for (int x = -rx; x <= rx; x++) {
            const double from[2] = {at[0] - x, at[1] - y};
            const double flat =
                m.xx * x * x + 2.0 * m.xy * x * y + m.yy * y * y;
            if (flat > 0.0 && flat < LAST * LAST * side * side)
                out[(y + ry) * (2 * rx + 1) + x + rx] *=
                    gp_projection_solid(p, from[0], from[1]) / own *
                    gp_sky_soft(l, 0.0,
                                gp_projection_chord2(p, at[0], at[1], from[0],
                                                     from[1])) /
                    gp_sky_soft(l, 0.0, flat);
        }
    }
}
