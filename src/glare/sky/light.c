// SPDX-License-Identifier: Apache-2.0
/* Light by the chord, and its means over pixels. */
#include "core/maths.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <string.h>

static const double LAST = 100.0; // degrees

/* Light per steradian of channel c of model i. No formula reaches farther than 100 degrees: light
 * from behind is as from there. */
static double light_of(const struct gp_sky_params *p, int c, int i,
                       double chord2)
{
    const double t =
        2.0 * gp_asin(0.5 * sqrt(fmin(chord2, 4.0))) * (180.0 / M_PI);
    return p->part[i].light(&p->part[i], c, fmin(t, LAST));
}

/* The light of model i over the sphere: d Omega = pi d(chord^2), by octaves. */
static double sphere_of(const struct gp_sky_params *p, int c, int i)
{
    enum { OCTAVES = 64 };
    const struct gp_gauss *const g = gp_gauss_rule(12);
    const double last = 2.0 - 2.0 * gp_cos(LAST * M_PI / 180.0);
    double sum = M_PI * (4.0 - last) * light_of(p, c, i, 4.0); // from behind
    for (int k = 0; k < OCTAVES; k++) {
        const double to = ldexp(last, -k),
                     from = k < OCTAVES - 1 ? 0.5 * to : 0.0;
        for (int q = 0; q < g->n; q++)
            sum +=
                g->weight[q] * (to - from) * M_PI *
                light_of(p, c, i, 0.5 * (from + to) + (to - from) * g->node[q]);
    }
    return sum;
}

gp_status gp_sky_light_make(const struct gp_log *log,
                            const struct gp_sky_params *p, int channel,
                            struct gp_sky_light *out)
{
    static const double H = 1e-3;       // of chord^2, for slopes
    static const double NEAREST = 1e-3; // of a pixel: nearer light is even
    static const double NARROW = 3e-6;  // radians: no peak notices
    struct gp_sky_light l = {.nearest = NARROW};
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
        const double by = share / sphere_of(p, channel, k);
        l.stays += p->share[k] - share;
        for (int i = 0; i <= l.curve.n; i++) {
            double step, *const v = l.curve.value + 2 * i;
            const double c = gp_curve_square(&l.curve, i, &step);
            v[0] += by * light_of(p, channel, k, c);
            v[1] += by * step / (2.0 * H * c) *
                    (light_of(p, channel, k, c * (1.0 + H)) -
                     light_of(p, channel, k, c * (1.0 - H)));
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

/* Tests whether the metric changes within pixels by more than the light's error may be:
 * by up to a quarter of a side's square. */
static bool is_large(const struct gp_projection *p)
{
    static const double LARGE = 3e-6;
    const double k = fmax(p->dx, p->dy);
    return p->kind != GP_LATLONG && 0.25 * k * k > LARGE;
}

/* How much more light there is between points a step apart where their middle is anywhere
 * in so many pixels around `mid`: by two places along each axis. */
static double more_around(const struct gp_sky_light *l,
                          const struct gp_projection *p, const double mid[2],
                          const double step[2], const double within[2])
{
    static const double ROOT = 0.2886751345948129; // of 1/12
    const double least = l->nearest * l->nearest;
    double sum = 0.0;
    for (int k = 0; k < 5; k++) {
        const double x = k ? within[0] * ROOT * (k & 1 ? 1.0 : -1.0) : 0.0;
        const double y = k ? within[1] * ROOT * (k & 2 ? 1.0 : -1.0) : 0.0;
        const double c = gp_projection_chord2(
            p, mid[0] + x + 0.5 * step[0], mid[1] + y + 0.5 * step[1],
            mid[0] + x - 0.5 * step[0], mid[1] + y - 0.5 * step[1]);
        sum += (k ? 0.25 : -1.0) * gp_sky_soft(l, 0.0, fmax(c, least));
    }
    return sum;
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
    if (a == 0.0 && is_large(p)) { // (soft light is but a share of it)
        static const double WITHIN[2] = {M_SQRT1_2, M_SQRT1_2}; // of steps
        const double mid[2] = {0.5 * (at[0] + from[0]),
                               0.5 * (at[1] + from[1])};
        const double step[2] = {at[0] - from[0], at[1] - from[1]};
        sum += more_around(l, p, mid, step, WITHIN);
    }
    return sum;
}

/* A box of offsets between points of both pixels. */
struct box {
    double x, y, w, h;
};

static double nearest_of(double from, double size)
{
    return from > 0.0 ? from : fmin(from + size, 0.0);
}

/* The sum of more_around() over a box, of pixels so far apart: so little that two steps
 * along each axis do. */
static double more_in(const struct gp_sky_light *l,
                      const struct gp_projection *p, const double mid[2],
                      const double apart[2], const struct box *b)
{
    const struct gp_gauss *const g = gp_gauss_rule(2);
    double sum = 0.0;
    for (int k = 0; k < 4; k++) {
        const double step[2] = {b->x + b->w * (0.5 + g->node[k & 1]),
                                b->y + b->h * (0.5 + g->node[k >> 1])};
        const double tent[2] = {1.0 - fabs(step[0] - apart[0]),
                                1.0 - fabs(step[1] - apart[1])};
        sum += 0.25 * b->w * b->h * tent[0] * tent[1] *
               more_around(l, p, mid, step, tent);
    }
    return sum;
}

double gp_sky_close_mean(const struct gp_sky_light *l,
                         const struct gp_projection *p, const double at[2],
                         const double from[2])
{
    enum { MOST = 64 };
    const struct gp_gauss *const g = gp_gauss_rule(5);
    const double apart[2] = {at[0] - from[0], at[1] - from[1]};
    const double mid[2] = {at[0] - 0.5 * apart[0], at[1] - 0.5 * apart[1]};
    const struct gp_metric m = gp_projection_metric(p, mid[0], mid[1]);
    const double least = l->nearest * l->nearest;
    // where both points move together distances change little, but at a pole
    const bool pole = p->kind == GP_LATLONG &&
                      0.5 * M_PI - fabs(mid[1] - p->y0) * p->dy < 4.0 * p->dy;
    const int moves = pole ? g->n : 1;
    const bool large = is_large(p);
    const double solid = gp_projection_solid(p, at[0], at[1]) *
                         gp_projection_solid(p, from[0], from[1]);
    struct box todo[MOST];
    double sum = 0.0;
    int n = 0;
    for (int i = 0; i < 4; i++) // a tent's straight parts
        todo[n++] =
            (struct box) {apart[0] - (i & 1), apart[1] - (i >> 1), 1, 1};
    while (n > 0) {
        struct box b = todo[--n];
        const double x = nearest_of(b.x, b.w), y = nearest_of(b.y, b.h);
        const double away = m.xx * x * x + 2.0 * m.xy * x * y + m.yy * y * y;
        const double wide = m.xx * b.w * b.w, high = m.yy * b.h * b.h;
        if (fmax(wide, high) > fmax(away, least) && n + 2 <= MOST) {
            struct box other = b;
            if (wide > high) {
                b.w = other.w *= 0.5;
                other.x += b.w;
            } else {
                b.h = other.h *= 0.5;
                other.y += b.h;
            }
            todo[n++] = b;
            todo[n++] = other;
            continue;
        }
        sum += large ? more_in(l, p, mid, apart, &b) : 0.0;
        for (int j = 0; j < g->n * moves; j++) {
            const double v = b.y + b.h * (0.5 + g->node[j % g->n]);
            const double tent = 1.0 - fabs(v - apart[1]);
            double by = g->weight[j % g->n] * b.w * b.h * tent;
            double y0 = mid[1] + 0.5 * v, y1 = mid[1] - 0.5 * v;
            if (moves > 1) {
                const double move = tent * g->node[j / g->n];
                y0 += move;
                y1 += move;
                by *= g->weight[j / g->n] * gp_projection_solid(p, at[0], y0) *
                      gp_projection_solid(p, from[0], y1) / solid;
            }
            for (int i = 0; i < g->n; i++) {
                const double u = b.x + b.w * (0.5 + g->node[i]);
                const double c = gp_projection_chord2(p, mid[0] + 0.5 * u, y0,
                                                      mid[0] - 0.5 * u, y1);
                sum += by * g->weight[i] * (1.0 - fabs(u - apart[0])) *
                       gp_sky_soft(l, 0.0, fmax(c, least));
            }
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
    const double least = sqrt(fmax(det, 0.0) / most);
    // (beyond a fisheye's rim pixels are too long for that)
    const double wide =
        p->kind == GP_PERSPECTIVE ? sqrt(fmin(least / sqrt(most), 1.0)) : 1.0;
    return (struct gp_sky_ellipse) {
        sqrt(most),        least, sqrt(g.yy / det), sqrt(g.xx / det),
        sqrt(most * wide),
    };
}
