// SPDX-License-Identifier: Apache-2.0
/* The nodes of direction cosines, and the light of their kernel that leaves the
 * frame. */
#include "glare/sky/cosines.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/cosines_priv.h"

#include <math.h>

// -- nodes ---------------------------------------------------------------------

struct gp_cosine_box gp_cosine_box_of(const struct gp_projection *p,
                                      const double from[2], const double to[2])
{
    struct gp_cosine_box b = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    // a cosine grows along its axis, and is largest where the other's place is
    // nearest to the pupil's normal, or farthest
    const double x[3] = {from[0], to[0], fmin(fmax(p->x0, from[0]), to[0])};
    const double y[3] = {from[1], to[1], fmin(fmax(p->y0, from[1]), to[1])};
    for (int i = 0; i < 9; i++) {
        const struct gp_v3 d = gp_projection_direction(p, x[i % 3], y[i / 3]);
        b.low[0] = fmin(b.low[0], d.x);
        b.low[1] = fmin(b.low[1], d.y);
        b.high[0] = fmax(b.high[0], d.x);
        b.high[1] = fmax(b.high[1], d.y);
    }
    return b;
}

bool gp_cosine_grid_lay(const struct gp_projection *p, int w, int h,
                        double finest, struct gp_cosine_grid *out)
{
    // of splines' error: see `wrong`; and of periods that are finest
    static const double DENSE = 2.75, LOOSE = 1.25, PERIOD = 2.3;
    static const double MOST = 8.0 * M_PI / 180.0;
    const double from[2] = {-0.5, -0.5}, to[2] = {w - 0.5, h - 0.5};
    const double pixel = fmax(p->dx, p->dy);
    if (p->kind != GP_PERSPECTIVE || !(pixel <= MOST))
        return false;
    const struct gp_cosine_box b = gp_cosine_box_of(p, from, to);
    *out = (struct gp_cosine_grid) {
        .projection = *p,
        .w = w,
        .h = h,
        .nodes = fmin(fmax(PERIOD * finest * pixel, LOOSE), DENSE),
    };
    for (int i = 0; i < 2; i++) {
        out->step[i] = (i ? p->dy : p->dx) / out->nodes;
        out->size[i] = gp_cosine_span(b.low[i], b.high[i], out->step[i]).n;
    }
    return true;
}

// -- their kernel --------------------------------------------------------------------

void gp_cosines_at(const struct gp_kernel *k, double u, double v, double d[3])
{
    enum { MID = GP_COSINE_TAPS / 2 - 1, WIDE = 4 * MID + 2 };
    const int x = (int) floor(u) + k->cx, y = (int) floor(v) + k->cy;
    double own[GP_COSINE_TAPS], at[2][GP_COSINE_TAPS], both[2][WIDE] = {{0}};
    gp_cosine_spline(0.0, own);
    gp_cosine_spline(u - floor(u), at[0]);
    gp_cosine_spline(v - floor(v), at[1]);
    for (int i = 0; i < 2 * GP_COSINE_TAPS * (2 * MID + 1); i++) {
        const int a = i / 2 % GP_COSINE_TAPS, b = i / 2 / GP_COSINE_TAPS;
        both[i % 2][a + b] += at[i % 2][a] * own[b];
    }
    for (int c = 0; c < 3; c++) {
        d[c] = 0.0;
        for (int i = 0; i < WIDE * WIDE; i++)
            d[c] += both[0][i % WIDE] * both[1][i / WIDE] *
                    (double) gp_planes_at(&k->k, c, k->w, k->h,
                                          x - 2 * MID + i % WIDE,
                                          y - 2 * MID + i / WIDE);
    }
}

void gp_cosines_free(struct gp_cosines **c)
{
    if (*c) {
        gp_far_free(
            (*c)->nodes.far); // it has no more: of samples, not of a model
        gp_planes_free(&(*c)->nodes.k);
        gp_free((*c)->sums);
    }
    GP_FREE(*c);
}

// -- light that leaves the frame -------------------------------------------------

/* The core's light in its row y between two places on it, in samples. */
static double between(const struct gp_cosines *c, int y, double from, double to)
{
    const int w = c->w;
    const double *const row = c->sums + (size_t) y * ((size_t) w + 1);
    double at[2] = {from, to};
    for (int i = 0; i < 2; i++) {
        const double t = fmin(fmax(at[i], 0.0), w);
        const int k = (int) fmin(floor(t), w - 1);
        at[i] = row[k] + (t - k) * (row[k + 1] - row[k]);
    }
    return fmax(at[1] - at[0], 0.0);
}

/* With X = x / z of a place, and Y: where y is b, Y is at most Y1 where z is at least
 * b / Y1, which is |x| at most this; 0 where no z is. */
static double half_of(double b, double side)
{
    const double z = b / side;
    return side > 0.0 ? sqrt(fmax(1.0 - b * b - z * z, 0.0)) : 0.0;
}

double gp_cosines_outside(const struct gp_cosines *c, double x, double y)
{
    const struct gp_cosine_grid *const g = &c->grid;
    const struct gp_projection *const p = &g->projection;
    const struct gp_v3 at = gp_projection_direction(p, x, y);
    const double left = (-0.5 - p->x0) * p->dx;
    const double right = (g->w - 0.5 - p->x0) * p->dx;
    const double top = (-0.5 - p->y0) * p->dy;
    const double bottom = (g->h - 0.5 - p->y0) * p->dy;
    double inside = 0.0;
    for (int j = 0; j < c->h; j++) {
        const double b = at.y + (j - c->h / 2) * g->step[1];
        if (fabs(b) >= 1.0)
            continue;
        const double q = sqrt(1.0 - b * b), size = fabs(b);
        // b / z is between both sides: |x| between `near` and `far`
        const double far = half_of(size, b < 0.0 ? -top : bottom);
        const double near = half_of(size, b < 0.0 ? -bottom : top);
        const double from = left * q / sqrt(1.0 + left * left);
        const double to = right * q / sqrt(1.0 + right * right);
        const double ends[2][2] = {{fmax(from, -far), fmin(to, far)},
                                   {fmax(from, -near), fmin(to, near)}};
        for (int i = 0; i < (near > 0.0 ? 2 : 1); i++) {
            const double first = 0.5 + c->w / 2 - at.x / g->step[0];
            const double light = between(c, j, first + ends[i][0] / g->step[0],
                                         first + ends[i][1] / g->step[0]);
            inside += i ? -light : light;
        }
    }
    // what no node has is outside
    return fmax(c->all - inside, 0.0);
}
