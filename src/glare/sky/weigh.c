// SPDX-License-Identifier: Apache-2.0
/* Weights at a place. */
#include "core/minmax.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <string.h>

double gp_sky_scale(const struct gp_sky *s, int l, double side)
{
    const double a = s->ratio * ldexp(side, l);
    return a * a;
}

double gp_sky_soft_term(const struct gp_sky *s, int l, double side, double c)
{
    return gp_sky_soft(&s->light, gp_sky_scale(s, l, side), c) -
           gp_sky_soft(&s->light, gp_sky_scale(s, l + 1, side), c);
}

double gp_sky_term(const struct gp_sky *s, int l, bool last, const double at[2],
                   const double from[2], double side)
{
    const struct gp_projection *const p = &s->p.projection;
    const int order = l <= 3 ? 2 : 1; // 64 pixels away means are within 2e-4
    const double end = last ? 0.0 : gp_sky_scale(s, l + 1, side);
    if (!last) { // beyond it by more than both pixels no point is within
        const double c =
            gp_projection_chord2(p, at[0], at[1], from[0], from[1]);
        if (c > end * (1.0 + 2.0 / s->ratio))
            return 0.0;
    }
    return gp_sky_mean(&s->light, p, gp_sky_scale(s, l, side), end, order, at,
                       from);
}

/* Returns under which share of the level's light a weight is negligible: a term fades
 * out where the next one takes over, and divided splines ring beyond. Where light is
 * even a term is but little of it anywhere, and so is what counts. */
static double negligible_at(const struct gp_sky *s, int l, double side)
{
    const double a = gp_sky_scale(s, gp_max(l, 1), side),
                 c = l ? 0.0 : side * side;
    const double whole = gp_sky_soft(&s->light, l ? a : 0.0, c);
    const double next =
        gp_sky_soft(&s->light, l ? gp_sky_scale(s, l + 1, side) : a, c);
    return s->negligible * fabs(whole - next) / whole;
}

static bool is_negligible(const struct gp_sky *s, int l, const double at[2],
                          const double from[2], double side, double share,
                          double weight)
{
    const double c =
        gp_projection_chord2(&s->p.projection, at[0], at[1], from[0], from[1]);
    return fabs(weight) <
           share *
               gp_sky_soft(&s->light, gp_sky_scale(s, gp_max(l, 1), side), c);
}

void gp_sky_weigh_level(const struct gp_sky *s, int l, const double at[2],
                        double side, double *v, float *out)
{
    const struct gp_sky_level *const g = &s->level[l];
    const int w = 2 * g->rx + 1, h = 2 * g->ry + 1;
    const double share = negligible_at(s, l, side);
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < w * h; i++) {
            const int x = i % w, y = i / w;
            const double from[2] = {at[0] - (x - g->rx) * g->step,
                                    at[1] - (y - g->ry) * g->step};
            if (pass == 0)
                v[i] = gp_sky_term(s, l, false, at, from, side);
            else
                out[(size_t) y * g->pitch + (size_t) x] =
                    is_negligible(s, l, at, from, side, share, v[i])
                        ? 0.0f
                        : (float) v[i];
        }
        if (pass == 0) // the term ends: nothing is beyond
            gp_far_divide(v, w, h, 1);
    }
}

double gp_sky_pixel(const struct gp_sky *s, const double at[2],
                    const double from[2], double most)
{
    const struct gp_projection *const p = &s->p.projection;
    const double away =
        sqrt(gp_projection_chord2(p, at[0], at[1], from[0], from[1])) / most;
    return gp_projection_solid(p, from[0], from[1]) *
           (away >= 2.0 ? gp_sky_mean(&s->light, p, 0.0, 0.0,
                                      gp_sky_order(away), at, from)
                        : gp_sky_close_mean(&s->light, p, at, from));
}

double gp_sky_weigh_pixels(const struct gp_sky *s, const double at[2],
                           double side, double *v, float *out)
{
    const struct gp_sky_level *const g = &s->level[0];
    const struct gp_projection *const p = &s->p.projection;
    const int w = 2 * g->rx + 1, h = 2 * g->ry + 1;
    const double most = gp_sky_ellipse_at(p, at[0], at[1]).most;
    const double a = gp_sky_scale(s, 1, side),
                 share = negligible_at(s, 0, side);
    for (int i = 0; i < w * h; i++) {
        const int x = i % w - g->rx, y = i / w - g->ry;
        const double from[2] = {at[0] - x, at[1] - y};
        const double c =
            gp_projection_chord2(p, at[0], at[1], from[0], from[1]);
        const double solid = gp_projection_solid(p, from[0], from[1]);
        v[i] = c > a * (1.0 + 2.0 / s->ratio) ? 0.0 // soft light is as it is
                                              : gp_sky_pixel(s, at, from, most);
        if (v[i] != 0.0) // the soft part as its own level has it
            v[i] -= solid * gp_sky_mean(&s->light, p, a, 0.0, 2, at, from);
        const bool none = (!x && !y) || is_negligible(s, 0, at, from, side,
                                                      share, v[i] / solid);
        out[(size_t) (i / w) * g->pitch + (size_t) (i % w)] =
            none ? 0.0f : (float) v[i];
    }
    return v[g->ry * w + g->rx] + s->light.stays;
}
