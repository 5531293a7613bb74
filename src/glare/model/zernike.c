/* Zernike's polynomials over the unit disc, as Noll numbers them: Zernike
 * polynomials and atmospheric turbulence, JOSA 66 (1976), table I.
 *
 *   Z(r, a) = N R(r) cos(m a), or sin(m a),
 *   N = sqrt(n + 1) where m is 0, else sqrt(2 n + 2)
 *
 * so that each has a mean square of 1 over the disc, and no two have a mean
 * product. */
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

/* R(r) = r^m (c0 + c1 r^2 + c2 r^4) */
struct term {
    int n, m;       // degree; turns, negative: a sine
    double c[3];
};

static const struct term terms[GP_ZERNIKE_LAST + 1] = {
    [2] = {1, 1, {1}},         [3] = {1, -1, {1}},
    [4] = {2, 0, {-1, 2}},
    [5] = {2, -2, {1}},        [6] = {2, 2, {1}},
    [7] = {3, -1, {-2, 3}},    [8] = {3, 1, {-2, 3}},
    [9] = {3, -3, {1}},        [10] = {3, 3, {1}},
    [11] = {4, 0, {1, -6, 6}},
    [12] = {4, 2, {-3, 4}},    [13] = {4, -2, {-3, 4}},
    [14] = {4, 4, {1}},        [15] = {4, -4, {1}},
};

static double norm(const struct term *t)
{
    return sqrt((t->m ? 2.0 : 1.0) * (t->n + 1));
}

double gp_zernike(int j, double x, double y)
{
    const struct term *const t = &terms[j];
    const double r2 = x * x + y * y;
    double cosine = 1.0, sine = 0.0; // of m a, times r^m
    for (int i = 0; i < abs(t->m); i++) {
        const double next = cosine * x - sine * y;
        sine = cosine * y + sine * x;
        cosine = next;
    }
    return norm(t) * (t->c[0] + r2 * (t->c[1] + r2 * t->c[2])) *
           (t->m < 0 ? sine : cosine);
}

double gp_zernike_slope(int j)
{
    const struct term *const t = &terms[j];
    return norm(t) * 0.5 * (t->n * (t->n + 2) - t->m * t->m);
}
