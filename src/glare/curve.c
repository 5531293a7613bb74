// SPDX-License-Identifier: Apache-2.0
#include "glare/curve.h"

#include "core/maths.h"
#include "core/memory.h"

#include <math.h>
#include <pthread.h>

// -- curves --------------------------------------------------------------------

gp_status gp_curve_make(const struct gp_log *log, int channels, double least,
                        double most, struct gp_curve *out)
{
    const uint64_t shift = 52 - GP_CURVE_LOG2;
    const uint64_t last = gp_bits_of_double(most * most) >> shift;
    struct gp_curve t = {
        .first = gp_bits_of_double(least * least) >> (shift + GP_CURVE_LOG2)
                                                         << GP_CURVE_LOG2,
        .channels = channels,
    };
    t.n = last > t.first ? (int) (last - t.first) : 0;
    gp_status st = gp_alloc(log, "kernel", 2 * (size_t) channels,
                            ((size_t) t.n + 1) * sizeof *t.value, &t.value);
    if (!st)
        *out = t;
    return st;
}

double gp_curve_square(const struct gp_curve *t, int i, double *step)
{
    static const uint64_t one = 1ull << (52 - GP_CURVE_LOG2);
    const uint64_t bits = (t->first + (uint64_t) i) * one;
    const double s = gp_double_with_bits(bits);
    *step = gp_double_with_bits(bits + one) - s;
    return s;
}

// -- rules ---------------------------------------------------------------------

enum { MOST_NODES = 16, MOST_TENT = 10 };

static struct gp_gauss rules[MOST_NODES + 1], tents[MOST_TENT + 1];

/* Newton's method on the Legendre polynomials; Abramowitz and Stegun 25.4.29 */
static void make_rules(void)
{
    for (int n = 1; n <= MOST_NODES; n++) {
        rules[n].n = n;
        for (int i = 0; i < n; i++) {
            double x = gp_cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
            for (int step = 0; step < 8; step++) { // quadratic: 5 are enough
                double p0 = 1.0, p1 = x;
                for (int k = 2; k <= n; k++) {
                    const double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                    p0 = p1;
                    p1 = p2;
                }
                slope = n * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            rules[n].node[i] = 0.5 * x;
            rules[n].weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
        }
    }
}

/* Orthogonal polynomials under the tent 1 - |x|, which is even: p(k + 1) = x
 * p(k) - b(k) p(k - 1). Returns p(n) at x, and p(n - 1) and its slope. */
static double tent_polynomial(const double *b, int n, double x, double *before,
                              double *slope)
{
    double p0 = 0.0, p1 = 1.0, s0 = 0.0, s1 = 0.0;
    for (int k = 0; k < n; k++) {
        const double p2 = x * p1 - b[k] * p0, s2 = p1 + x * s1 - b[k] * s0;
        p0 = p1, p1 = p2, s0 = s1, s1 = s2;
    }
    *before = p0;
    *slope = s1;
    return p1;
}

/* Gauss rules for the tent, by Stieltjes' way: Gautschi 2004, section 2.2. Between
 * each two roots of the polynomial before is one, and beyond both ends. */
static void make_tents(void)
{
    const struct gp_gauss *const g = &rules[MOST_NODES];
    double b[MOST_TENT + 1] = {0}, norm[MOST_TENT + 1], p, slope;
    for (int k = 0; k <= MOST_TENT; k++) {
        norm[k] = 0.0;
        for (int i = 0; i < g->n; i++) { // the right half, twice
            const double x = 0.5 + g->node[i];
            const double v = tent_polynomial(b, k, x, &p, &slope);
            norm[k] += 2.0 * g->weight[i] * (1.0 - x) * v * v;
        }
        b[k] = k > 0 ? norm[k] / norm[k - 1] : 0.0;
    }
    for (int n = 1; n <= MOST_TENT; n++) {
        tents[n].n = n;
        for (int i = 0; i < n; i++) {
            double low = i > 0 ? tents[n - 1].node[i - 1] : -1.0;
            double high = i < n - 1 ? tents[n - 1].node[i] : 1.0;
            const double at = tent_polynomial(b, n, low, &p, &slope);
            for (int step = 0; step < 100; step++) {
                const double mid = 0.5 * (low + high);
                if ((tent_polynomial(b, n, mid, &p, &slope) > 0.0) ==
                    (at > 0.0))
                    low = mid;
                else
                    high = mid;
            }
            const double x = 0.5 * (low + high);
            tent_polynomial(b, n, x, &p, &slope);
            tents[n].node[i] = x;
            tents[n].weight[i] = norm[n - 1] / (slope * p);
        }
    }
}

static void make_all(void)
{
    make_rules();
    make_tents();
}

static pthread_once_t once = PTHREAD_ONCE_INIT;

const struct gp_gauss *gp_gauss_rule(int n)
{
    pthread_once(&once, make_all);
    return &rules[n];
}

const struct gp_gauss *gp_tent_rule(int n)
{
    pthread_once(&once, make_all);
    return &tents[n];
}
