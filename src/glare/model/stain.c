/* Stains on a lens or in an eye: dust, scratches, lashes. */
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <math.h>

#define PI 3.14159265358979323846

/* The share of a cell within `radius` of a line `away` from its middle, all in
 * cells. */
static double cell_share(double radius, double away)
{
    const double to = fmin(fmax(0.5 + radius - away, 0.0), 1.0);
    const double from = fmin(fmax(0.5 - radius - away, 0.0), 1.0);
    return to - from;
}

void gp_stain_row(const struct gp_stain *s, int n, const struct gp_pupil *p,
                  int y)
{
    const double middle = 0.5 * p->n, cell = p->cell;
    const double v = (y + 0.5 - middle) * cell;
    float *const row = p->t + (size_t) y * (size_t) p->n;
    for (int k = 0; k < n; k++) {
        const struct gp_stain *const one = &s[k];
        const double side = fmax(one->radius[0], one->radius[1]) + cell;
        if (v < fmin(one->y[0], one->y[1]) - side ||
            v > fmax(one->y[0], one->y[1]) + side)
            continue;
        const double low = fmin(one->x[0], one->x[1]) - side;
        const double high = fmax(one->x[0], one->x[1]) + side;
        const int from = (int) fmax(floor(low / cell + middle), 0.0);
        const int to = (int) fmin(ceil(high / cell + middle), p->n);
        const double dx = one->x[1] - one->x[0], dy = one->y[1] - one->y[0];
        const double square = dx * dx + dy * dy;
        for (int x = from; x < to; x++) {
            const double a = (x + 0.5 - middle) * cell - one->x[0];
            const double b = v - one->y[0];
            double at = square > 0.0 ? (a * dx + b * dy) / square : 0.0;
            at = fmin(fmax(at, 0.0), 1.0);
            const double away = hypot(a - at * dx, b - at * dy);
            const double radius = one->radius[0] +
                                  at * (one->radius[1] - one->radius[0]);
            const double covered = cell_share(radius / cell, away / cell);
            row[x] *= (float) (1.0 - one->hides * covered);
        }
    }
}

void gp_stain_lashes(int n, double radius, double turn, uint64_t seed,
                     struct gp_stain *out)
{
    const double cosine = cos(turn), sine = sin(turn);
    for (int k = 0; k < n; k++) {
        const uint64_t key = 8 * (uint64_t) k;
        // from the lid's edge, an arc above, downwards and outwards
        const double from = 2.0 * ((k + gp_model_random(seed, key)) / n) - 1.0;
        const double length = 0.7 + 0.7 * gp_model_random(seed, key + 1);
        const double lean = 0.5 * from +
                            0.3 * (gp_model_random(seed, key + 2) - 0.5);
        const double curl = 0.9 * (gp_model_random(seed, key + 3) - 0.5);
        const double thick = 0.012 + 0.012 * gp_model_random(seed, key + 4);
        double x = 1.05 * from, y = -1.1 + 0.25 * from * from;
        for (int i = 0; i < GP_LASH_PARTS; i++) {
            struct gp_stain *const s = &out[k * GP_LASH_PARTS + i];
            const double at = (double) i / GP_LASH_PARTS;
            const double angle = lean + curl * at;
            const double end[2] = {x + length / GP_LASH_PARTS * sin(angle),
                                   y + length / GP_LASH_PARTS * cos(angle)};
            const double px[2] = {x, end[0]}, py[2] = {y, end[1]};
            for (int e = 0; e < 2; e++) {
                s->x[e] = radius * (cosine * px[e] + sine * py[e]);
                s->y[e] = radius * (cosine * py[e] - sine * px[e]);
                s->radius[e] = radius * thick *
                               (1.0 - (at + (double) e / GP_LASH_PARTS));
            }
            s->hides = 1.0;
            x = end[0];
            y = end[1];
        }
    }
}
