// SPDX-License-Identifier: Apache-2.0
#include "scene/relight_priv.h"
#include "core/maths.h"

#include <math.h>

/* Returns the place of a share of Blender's pixel filter: Blackman and Harris's
 * window of four terms, 3 pixels wide, whose integral it is. */
static double place_of(double share)
{
    double lo = -0.5, hi = 0.5; // of the width
    for (int i = 0; i < 40; i++) {
        const double v = 0.5 * (lo + hi), turn = 2.0 * M_PI * (v + 0.5);
        const double sum =
            v + 0.5 -
            (0.48829 * gp_sin(turn) - 0.14128 / 2.0 * gp_sin(2.0 * turn) +
             0.01168 / 3.0 * gp_sin(3.0 * turn)) /
                (2.0 * M_PI * 0.35875);
        *(sum < share ? &lo : &hi) = v;
    }
    return 3.0 * lo;
}

void gp_places_set(double place[GP_PLACES][2])
{
    for (unsigned i = 0; i < GP_PLACES; i++) {
        unsigned turned = 0;
        for (int bit = 0; bit < GP_PLACES_BITS; bit++)
            turned |= (i >> bit & 1) << (GP_PLACES_BITS - 1 - bit);
        place[i][0] = place_of((i + 0.5) / GP_PLACES);
        place[i][1] = place_of((turned + 0.5) / GP_PLACES);
    }
}

/* Solves a x = b in place of b; a is symmetric and positive, and is lost
 * (Cholesky). */
static void solve(double a[GP_MEANS][GP_MEANS], double b[GP_MEANS])
{
    for (int i = 0; i < GP_MEANS; i++) {
        for (int j = 0; j <= i; j++) {
            for (int k = 0; k < j; k++)
                a[i][j] -= a[i][k] * a[j][k];
            a[i][j] = i == j ? sqrt(a[i][i]) : a[i][j] / a[j][j];
        }
        for (int k = 0; k < i; k++)
            b[i] -= a[i][k] * b[k];
        b[i] /= a[i][i];
    }
    for (int i = GP_MEANS - 1; i >= 0; i--) {
        for (int k = i + 1; k < GP_MEANS; k++)
            b[i] -= a[k][i] * b[k];
        b[i] /= a[i][i];
    }
}

void gp_places_weigh(const double of[GP_PLACES][GP_MEANS],
                     const double frame[GP_MEANS], double weight[GP_PLACES])
{
    static const double RIDGE = 1e-3; // variances under it count as noise
    double a[GP_MEANS][GP_MEANS] = {0}, move[GP_MEANS], mean[GP_MEANS] = {0};
    for (int i = 0; i < GP_PLACES; i++) {
        for (int k = 0; k < GP_MEANS; k++)
            mean[k] += 1.0 / GP_PLACES * of[i][k];
    }
    for (int i = 0; i < GP_MEANS; i++) {
        move[i] = frame[i] - mean[i];
        a[i][i] = RIDGE;
    }
    for (int i = 0; i < GP_PLACES; i++) {
        const double *const own = of[i];
        for (int j = 0; j < GP_MEANS; j++) {
            for (int k = 0; k <= j; k++)
                a[j][k] +=
                    1.0 / GP_PLACES * (own[j] - mean[j]) * (own[k] - mean[k]);
        }
    }
    solve(a, move);
    for (int i = 0; i < GP_PLACES; i++) {
        const double *const own = of[i];
        double more = 1.0;
        for (int j = 0; j < GP_MEANS; j++)
            more += move[j] * (own[j] - mean[j]);
        weight[i] = 1.0 / GP_PLACES * fmax(more, 0.0);
    }
}
