// SPDX-License-Identifier: Apache-2.0
/* One weight a node, for tolerances from 5e-3 on: the pyramid that games blur with
 * (Kawase 2003; Jimenez 2014), of cubic B-splines, fitted to the light at each place.
 *
 * A level of light w per steradian lights a pixel d pixels from its source by
 * w A(dx) A(dy), in the mean over all places of the grid, where with a step of h pixels
 *
 *   A(d) = (1 / h) sum over x of B(x / h) B((x - d) / h)
 *
 * Weights, none of them negative, are those of least squares over all offsets but the
 * NEAR ones, which level 0 makes right; offsets count by their length, as all rings have
 * about as much light, and so does what all miss together, which light that is even
 * meets. The last level is as ever: its term is right far out, in every direction.
 *
 * Errors: what the fit misses, and how much the same weight differs from place to place
 * of a grid. In the light of a lamp that is a norm; light that is even but for one
 * frequency meets the side that any frequency has of what is missed, and of a level's
 * images sinc^8(1/2), where these are worst. */
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky_priv.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    NEAR = GP_SKY_SINGLE_NEAR,
    RING = 4,     // steps of a ring of samples, from 4 to 8 away
    MOST = 4096,  // samples
    SWEEPS = 400, // of a fit
};

static const double EVEN = 0.25; // weight of the sum of what is missed

struct sample {
    short x, y, step;
    double area;              // pixels that it stands for
    double counts;            // in a fit
    double at[GP_SKY_LEVELS]; // A A of each level
};

struct gp_sky_single {
    int levels, samples;
    double *overlap[GP_SKY_LEVELS]; // A at 0 .. 4 h, in `room`
    double gram[GP_SKY_LEVELS][GP_SKY_LEVELS], sum[GP_SKY_LEVELS];
    double differs[GP_SKY_LEVELS]; // norm over all pixels, of weight 1
    struct sample sample[MOST];
    double room[];
};

/* B at x steps from its middle. */
static double spline_at(double x)
{
    double b[GP_FAR_TAPS];
    x = fabs(x);
    if (x >= 2.0)
        return 0.0;
    gp_far_spline(x - floor(x), b);
    return b[x >= 1.0 ? 0 : 1];
}

/* A of a step of h pixels. */
static double overlap(int h, int d)
{
    double sum = 0.0;
    for (int x = d - 2 * h; x <= 2 * h; x++)
        sum += spline_at((double) x / h) * spline_at((double) (x - d) / h);
    return sum / h;
}

/* The norm by which pixels differ from their mean over the places of a grid. */
static double differs(const double *overlap, int h)
{
    double nodes = 0.0, pixels = 0.0;
    for (int d = 0; d <= 4 * h; d++) {
        const double square = (d ? 2.0 : 1.0) * overlap[d] * overlap[d];
        pixels += square;
        nodes += d % h == 0 ? h * square : 0.0;
    }
    return sqrt(fmax(nodes * nodes - pixels * pixels, 0.0));
}

/* A A of a level at an offset. */
static double weight_at(const struct gp_sky_single *s, int l, int x, int y)
{
    const int end = 4 << l;
    return abs(x) > end || abs(y) > end
               ? 0.0
               : s->overlap[l][abs(x)] * s->overlap[l][abs(y)];
}

/* Adds a ring of samples `step` pixels apart; a share of each lies within it. */
static void add_ring(struct gp_sky_single *s, int step)
{
    for (int y = -2 * RING; y <= 2 * RING; y++) {
        for (int x = -2 * RING; x <= 2 * RING; x++) {
            const int away = gp_max(abs(x), abs(y));
            struct sample *const at = &s->sample[s->samples];
            if ((step > 1 && away < RING) || (step == 1 && away <= NEAR) ||
                s->samples == MOST)
                continue;
            const bool rim = away == 2 * RING || (step > 1 && away == RING);
            *at = (struct sample) {
                .x = (short) (x * step),
                .y = (short) (y * step),
                .step = (short) step,
                .area = (rim ? 0.5 : 1.0) * step * step,
            };
            at->counts = at->area * gp_hypot(at->x, at->y);
            for (int l = 1; l < s->levels - 1; l++)
                at->at[l] = weight_at(s, l, x * step, y * step);
            s->samples++;
        }
    }
}

gp_status gp_sky_single_make(const struct gp_log *log, struct gp_sky *sky)
{
    struct gp_sky_single *s;
    const size_t room = (size_t) 5 << sky->levels;
    gp_status st =
        gp_alloc_zero(log, "kernel", 1, sizeof *s + room * sizeof *s->room, &s);
    if (st)
        return st;
    sky->single = s;
    s->levels = sky->levels;
    s->overlap[0] = s->room;
    for (int l = 1; l < s->levels - 1; l++) {
        s->overlap[l] = s->overlap[l - 1] + (l > 1 ? (4 << (l - 1)) + 1 : 0);
        for (int d = 0; d <= 4 << l; d++)
            s->overlap[l][d] = overlap(1 << l, d);
        s->differs[l] = differs(s->overlap[l], 1 << l);
    }
    const double reach = fmax(sky->ratio, 2.0) * ldexp(1.0, s->levels - 1);
    for (int step = 1; step == 1 || RING * step < reach; step *= 2)
        add_ring(s, step);
    for (int l = 1; l < s->levels - 1; l++) {
        for (int i = 0; i < s->samples; i++)
            s->sum[l] += s->sample[i].area * s->sample[i].at[l];
        for (int k = 1; k <= l; k++) {
            for (int i = 0; i < s->samples; i++)
                s->gram[l][k] += s->sample[i].counts * s->sample[i].at[l] *
                                 s->sample[i].at[k];
            s->gram[k][l] = s->gram[l][k];
        }
    }
    return GP_OK;
}

/* The light per steradian at an offset from a place, less what the last level has. */
static double light_at(const struct gp_sky *s, const double at[2], double side,
                       int x, int y)
{
    const double from[2] = {at[0] - x, at[1] - y};
    const struct gp_projection *const p = &s->p.projection;
    const double c = gp_projection_chord2(p, at[0], at[1], from[0], from[1]);
    const double last = gp_sky_scale(s, s->levels - 1, side);
    const double away = sqrt(c) / side;
    const double all =
        away < 2.0 * RING
            ? gp_sky_mean(&s->light, p, 0.0, 0.0, gp_sky_order(away), at, from)
            : gp_sky_soft(&s->light, 0.0, c);
    return c < last ? all - gp_sky_soft(&s->light, last, c) : 0.0;
}

void gp_sky_single_fit(const struct gp_sky *sky, const double at[2],
                       double side, double weight[GP_SKY_LEVELS])
{
    const struct gp_sky_single *const s = sky->single;
    double by[GP_SKY_LEVELS] = {0}, all = 0.0;
    for (int i = 0; i < s->samples; i++) {
        const struct sample *const v = &s->sample[i];
        const double light = light_at(sky, at, side, v->x, v->y);
        all += v->area * light;
        for (int l = 1; l < s->levels - 1; l++)
            by[l] += v->counts * light * v->at[l];
    }
    memset(weight, 0, GP_SKY_LEVELS * sizeof *weight);
    // one weight after the other: the sum of squares never grows
    for (int sweep = 0; sweep < SWEEPS; sweep++) {
        for (int l = 1; l < s->levels - 1; l++) {
            double rest = by[l] + EVEN * all * s->sum[l];
            for (int k = 1; k < s->levels - 1; k++)
                rest -= k == l ? 0.0
                               : weight[k] * (s->gram[l][k] +
                                              EVEN * s->sum[l] * s->sum[k]);
            weight[l] = fmax(
                rest / (s->gram[l][l] + EVEN * s->sum[l] * s->sum[l]), 0.0);
        }
    }
}

double gp_sky_single_pixels(const struct gp_sky *s, const double at[2],
                            const double weight[GP_SKY_LEVELS], double side,
                            double *v, float *out)
{
    const struct gp_sky_level *const g = &s->level[0];
    const struct gp_projection *const p = &s->p.projection;
    const int w = 2 * g->rx + 1, h = 2 * g->ry + 1;
    const double most = gp_sky_ellipse_at(p, at[0], at[1]).most;
    for (int i = 0; i < w * h; i++) {
        const int x = i % w - g->rx, y = i / w - g->ry;
        const double from[2] = {at[0] - x, at[1] - y};
        const double c =
            gp_projection_chord2(p, at[0], at[1], from[0], from[1]);
        const double solid = gp_projection_solid(p, from[0], from[1]);
        v[i] = gp_sky_pixel(s, at, from, most) -
               solid * gp_sky_soft(&s->light,
                                   gp_sky_scale(s, s->levels - 1, side), c);
        for (int l = 1; l < s->levels - 1; l++)
            v[i] -= solid * weight[l] * weight_at(s->single, l, x, y);
        out[(size_t) (i / w) * g->pitch + (size_t) (i % w)] =
            !x && !y ? 0.0f : (float) v[i];
    }
    return v[g->ry * w + g->rx] + s->light.stays;
}

/* The largest frequency of what the fit misses, by samples: rings on which it would
 * turn between two of these have next to nothing of it. */
static double most_of(const struct gp_sky_single *s, const double missed[MOST])
{
    enum { TURNS = 4, HALVES = 20 };
    double most = 0.0;
    for (int k = 0; k < TURNS * HALVES; k++) {
        const double f = 0.5 * gp_exp2(-0.5 * (k / TURNS));
        const double turn = M_PI * (k % TURNS) / TURNS;
        const double u = 2.0 * M_PI * f * gp_cos(turn);
        const double v = 2.0 * M_PI * f * gp_sin(turn);
        double sum = 0.0;
        for (int i = 0; i < s->samples; i++) {
            const struct sample *const at = &s->sample[i];
            if (2.0 * f * at->step <= 1.0)
                sum += at->area * missed[i] * gp_cos(u * at->x + v * at->y);
        }
        most = fmax(most, fabs(sum));
    }
    return most;
}

double gp_sky_single_error(const struct gp_sky *sky, const double at[2],
                           double side, const double weight[GP_SKY_LEVELS],
                           const double *near)
{
    enum { SIDE = 2 * NEAR + 1 };
    static const double IMAGES = 0.02698; // sinc^8(1/2)
    const struct gp_sky_single *const s = sky->single;
    const double solid = gp_projection_solid(&sky->p.projection, at[0], at[1]);
    double missed[MOST], square = 0.0, all = 0.0, images = 0.0;
    for (int i = 0; i < s->samples; i++) {
        const struct sample *const v = &s->sample[i];
        const double light = light_at(sky, at, side, v->x, v->y);
        double e = light;
        for (int l = 1; l < s->levels - 1; l++)
            e -= weight[l] * v->at[l];
        missed[i] = e;
        square += v->area * e * e;
        all += v->area * light * light;
    }
    for (int l = 1; l < s->levels - 1; l++) {
        const double light = weight[l] * ldexp(1.0, 2 * l);
        square += weight[l] * weight[l] * s->differs[l] * s->differs[l];
        images += light * light;
    }
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int x = i % SIDE - NEAR, y = i / SIDE - NEAR;
        const double last = gp_sky_scale(sky, s->levels - 1, side);
        double v =
            near[i] / solid +
            gp_sky_soft(&sky->light, last,
                        gp_projection_chord2(&sky->p.projection, at[0], at[1],
                                             at[0] - x, at[1] - y));
        for (int l = 1; l < s->levels - 1; l++)
            v += weight[l] * weight_at(s, l, x, y);
        all += v * v;
    }
    return fmax(solid * (most_of(s, missed) + IMAGES * sqrt(images)) /
                    (sky->spread + sky->light.stays + sky->p.stays),
                sqrt(square / all));
}
