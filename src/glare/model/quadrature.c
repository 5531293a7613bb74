/* Integrals over pixels of what falls off around a point. */
#include "glare/model/model_priv.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

enum { MOST_NODES = 16 };

static struct gp_gauss rules[MOST_NODES + 1];

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

const struct gp_gauss *gp_gauss_rule(int n)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, make_rules);
    return &rules[n];
}

/* A box around (u, v) degrees from the light, a by b degrees wide. */
static void add_box(gp_profile p, const void *ctx, int channels, int order,
                    double u, double v, double a, double b, double sum[3])
{
    const struct gp_gauss *const g = gp_gauss_rule(order);
    for (int j = 0; j < g->n; j++) {
        for (int i = 0; i < g->n; i++) {
            double value[3];
            p(ctx, hypot(u + a * g->node[i], v + b * g->node[j]), value);
            const double weight = a * b * g->weight[i] * g->weight[j];
            for (int c = 0; c < channels; c++)
                sum[c] += weight * value[c];
        }
    }
}

/* The eighth of the light's pixel between a ray to the middle of an edge, `to`
 * degrees away, and one to its corner, `half` along the edge: rays of angle
 * phi, each from 0 to r = to / cos phi in steps that halve towards 0, where a
 * profile may be steep; what is left there is as wide as 2^-40 of r. */
static void add_eighth(gp_profile p, const void *ctx, int channels, double to,
                       double half, double sum[3])
{
    enum { STEPS = 40 };
    const struct gp_gauss *const across = gp_gauss_rule(12);
    const struct gp_gauss *const along = gp_gauss_rule(8);
    const double corner = atan2(half, to);
    for (int j = 0; j < across->n; j++) {
        const double phi = corner * (0.5 + across->node[j]);
        double r = to / cos(phi);
        for (int step = 0; step < STEPS; step++, r *= 0.5) {
            const double low = step + 1 < STEPS ? 0.5 * r : 0.0;
            for (int i = 0; i < along->n; i++) {
                const double t =
                    0.5 * (r + low) + (r - low) * along->node[i];
                const double weight = corner * across->weight[j] * t *
                                      (r - low) * along->weight[i];
                double value[3];
                p(ctx, t, value);
                for (int c = 0; c < channels; c++)
                    sum[c] += weight * value[c];
            }
        }
    }
}

void gp_pixel_integral(gp_profile p, const void *ctx, int channels,
    double scale, const struct gp_field *f, int x, int y, double out[3])
{
    enum { MOST_PARTS = 64, FAR = 24 };
    const double b = f->degrees, a = b * f->aspect; // the pixel's sides
    out[0] = out[1] = out[2] = 0.0;
    if (x == 0 && y == 0) {
        double eighths[3] = {0};
        add_eighth(p, ctx, channels, 0.5 * a, 0.5 * b, eighths);
        add_eighth(p, ctx, channels, 0.5 * b, 0.5 * a, eighths);
        for (int c = 0; c < channels; c++)
            out[c] = 4.0 * eighths[c];
        return;
    }
    // the distance of its nearest point says how it bends
    const double u = a * abs(x), v = b * abs(y);
    const double near = hypot(fmax(u - 0.5 * a, 0.0), fmax(v - 0.5 * b, 0.0));
    const double bend = fmax(near, scale);
    const int nx = (int) fmin(ceil(a / bend), MOST_PARTS);
    const int ny = (int) fmin(ceil(b / bend), MOST_PARTS);
    const double widest = fmax(a / nx, b / ny) / bend;
    const int order = widest > 0.5 ? 16 : widest > 0.2 ? 10
                    : widest > 0.08 ? 6 : widest > 1.0 / FAR ? 4 : 3;
    for (int j = 0; j < ny; j++) {
        for (int i = 0; i < nx; i++)
            add_box(p, ctx, channels, order, u + a * ((i + 0.5) / nx - 0.5),
                    v + b * ((j + 0.5) / ny - 0.5), a / nx, b / ny, out);
    }
}
