// SPDX-License-Identifier: Apache-2.0
/* Places at which weights are known, and what is between them. */
#include "core/maths.h"
#include "core/memory.h"
#include "glare/sky/sphere.h"

#include <math.h>
#include <string.h>

static double scale_of(const struct gp_projection *p, int axis)
{
    return axis ? p->dy : p->dx;
}

/* The place coordinate of a pixel along an axis, times its step. Of a
 * PERSPECTIVE it is asinh u: towards the border the metric changes by as much for each
 * step of it. */
static double angle_of(const struct gp_projection *p, int axis, double at)
{
    const double u = (at - (axis ? p->y0 : p->x0)) * scale_of(p, axis);
    if (p->kind != GP_PERSPECTIVE)
        return u;
    const double root = sqrt(1.0 + u * u);
    return u < 0.0 ? -gp_log(root - u) : gp_log(root + u);
}

double gp_sky_place_of(const struct gp_sky *s, int axis, double x)
{
    return (angle_of(&s->p.projection, axis, x) - s->places.first[axis]) /
           s->places.step[axis];
}

void gp_sky_place_at(const struct gp_sky *s, int i, double at[2])
{
    static const double BEYOND = 0.3; // cubics need two places
    const struct gp_projection *const p = &s->p.projection;
    const int index[2] = {i % s->places.n[0], i / s->places.n[0]};
    for (int axis = 0; axis < 2; axis++) {
        const double t =
            s->places.first[axis] + index[axis] * s->places.step[axis];
        const double u =
            p->kind == GP_PERSPECTIVE ? 0.5 * (gp_exp(t) - gp_exp(-t)) : t;
        at[axis] = (axis ? p->y0 : p->x0) + u / scale_of(p, axis);
    }
    gp_projection_pull(p, BEYOND, at);
}

int gp_sky_cubic(double t, int n, double w[4])
{
    const int cell = (int) fmin(fmax(floor(t), 1.0), n - 3.0);
    const double x = t - cell;
    // Lagrange's, at -1, 0, 1, 2
    w[0] = -x * (x - 1.0) * (x - 2.0) / 6.0;
    w[1] = (x + 1.0) * (x - 1.0) * (x - 2.0) / 2.0;
    w[2] = -(x + 1.0) * x * (x - 2.0) / 2.0;
    w[3] = (x + 1.0) * x * (x - 1.0) / 6.0;
    return cell - 1;
}

void gp_sky_lay_places(struct gp_sky *s)
{
    static const double APART = 0.125; // radians: cubics keep 1e-4 of weights
    for (int axis = 0; axis < 2; axis++) {
        const int n = axis ? s->p.h : s->p.w;
        const double beyond = s->levels > 2 ? ldexp(1.0, s->levels - 2) : 0.0;
        const double from = angle_of(&s->p.projection, axis, -2.0 * beyond);
        const double to =
            angle_of(&s->p.projection, axis, n - 1.0 + 2.0 * beyond);
        const int cells = (int) ceil((to - from) / APART) + 1;
        s->places.step[axis] = fmax((to - from) / cells, 1e-9);
        s->places.first[axis] = from - s->places.step[axis];
        s->places.n[axis] = cells + 3;
    }
}

gp_status gp_sky_columns(const struct gp_log *log, const struct gp_sky *s,
                         int n, double first, double step,
                         struct gp_sky_column **out)
{
    gp_status st = gp_alloc(log, "kernel", (size_t) n, sizeof **out, out);
    for (int i = 0; i < n && !st; i++) {
        struct gp_sky_column *const b = &(*out)[i];
        double at[4];
        const double t = gp_sky_place_of(s, 0, first + i * step);
        b->place = gp_sky_cubic(t, s->places.n[0], at);
        for (int k = 0; k < 4; k++)
            b->at[k] = (float) at[k];
    }
    return st;
}

void gp_sky_own(const struct gp_sky *s, int w, int h, int y, const int32_t *x,
                size_t n, float *own)
{
    if (s->sphere) {
        for (size_t i = 0; i < n; i++)
            own[i] = (float) s->sphere->own[y + s->sphere->y0];
        return;
    }
    if (!s->p.n) {
        memset(own, 0, n * sizeof *own);
        return;
    }
    const struct gp_sky_column *const column = s->column + (s->p.w - w) / 2;
    const double t = gp_sky_place_of(s, 1, y + (s->p.h - h) / 2);
    double at[4], line[4] = {0};
    const int down = gp_sky_cubic(t, s->places.n[1], at);
    int known = -1;
    for (size_t i = 0; i < n; i++) {
        const struct gp_sky_column *const b = &column[x[i]];
        for (int k = 0; k < 4 && b->place != known; k++) {
            line[k] = 0.0;
            for (int j = 0; j < 4; j++)
                line[k] +=
                    at[j] * s->own[(down + j) * s->places.n[0] + b->place + k];
        }
        known = b->place;
        own[i] =
            (float) (line[0] * (double) b->at[0] + line[1] * (double) b->at[1] +
                     line[2] * (double) b->at[2] + line[3] * (double) b->at[3]);
    }
}
