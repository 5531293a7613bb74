/* Rules of quadrature, and integrals of profiles over the plane. */
#include "glare/model/model_priv.h"

#include <math.h>
#include <pthread.h>

#define PI 3.14159265358979323846

enum { MOST_NODES = 16, MOST_TENT = 10 };

static struct gp_gauss rules[MOST_NODES + 1], tents[MOST_TENT + 1];

/* Newton's method on the Legendre polynomials; Abramowitz and Stegun 25.4.29 */
static void make_rules(void)
{
    for (int n = 1; n <= MOST_NODES; n++) {
        rules[n].n = n;
        for (int i = 0; i < n; i++) {
            double x = cos(PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
            for (int step = 0; step < 8; step++) { // quadratic: 5 are enough
                double p0 = 1.0, p1 = x;
                for (int k = 2; k <= n; k++) {
                    const double p2 =
                        ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
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

/* Gauss rules for the tent, by Stieltjes' way: Gautschi 2004, section 2.2. */
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
        enum { GRID = 4001 }; // an odd number: 0 is no end of a step
        tents[n].n = 0;
        for (int i = 0; i < GRID; i++) {
            double low = -1.0 + 2.0 * i / GRID, high = low + 2.0 / GRID;
            const double at = tent_polynomial(b, n, low, &p, &slope);
            if ((at > 0.0) == (tent_polynomial(b, n, high, &p, &slope) > 0.0))
                continue;
            for (int step = 0; step < 60; step++) {
                const double mid = 0.5 * (low + high);
                if ((tent_polynomial(b, n, mid, &p, &slope) > 0.0) ==
                    (at > 0.0))
                    low = mid;
                else
                    high = mid;
            }
            const double x = 0.5 * (low + high);
            tent_polynomial(b, n, x, &p, &slope);
            tents[n].node[tents[n].n] = x;
            tents[n].weight[tents[n].n++] = norm[n - 1] / (slope * p);
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

double gp_plane_factor(double t)
{
    const double radians = t * (PI / 180.0), degree = PI / 180.0;
    if (!(t < 90.0))
        return 0.0;
    return degree * degree * (radians > 1e-4 ? sin(radians) / radians : 1.0);
}

void gp_profile_integral(gp_profile p, const void *ctx, int channels,
                         double from, double end, double sum[3])
{
    enum { STEPS_OUT = 512 };
    const struct gp_gauss *const g = gp_gauss_rule(8);
    const double least = fmax(from, 1e-6);
    for (int c = 0; c < 3; c++)
        sum[c] = 0.0;
    for (int i = 0; i <= STEPS_OUT; i++) {
        const double low = i > 0 ? least * pow(end / least, (i - 1.0) / STEPS_OUT)
                                 : from;
        const double high = least * pow(end / least, (double) i / STEPS_OUT);
        for (int k = 0; k < g->n && high > low; k++) {
            const double t = 0.5 * (low + high) + (high - low) * g->node[k];
            double v[3];
            p(ctx, t, v);
            for (int c = 0; c < channels; c++)
                sum[c] += (high - low) * g->weight[k] * 2.0 * PI * t * v[c];
        }
    }
}
