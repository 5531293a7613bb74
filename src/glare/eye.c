#include "glare/eye.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846
#define PITCH GP_EYE_DEGREES_PER_PIXEL

/* A = 0.02 degrees is in all three terms; per square degree, the weights in. */
#define A 0.02
#define PER_DEGREE2 (PI / 180.0 * (PI / 180.0))
#define C0 (0.384 * 2.61e6 * PER_DEGREE2)
#define C1 (0.478 * 20.91 * PER_DEGREE2)
#define C2 (0.138 * 72.37 * PER_DEGREE2)

enum {
    MAX_ORDER = 16,  // of Gauss-Legendre quadrature
    STRIP = 256,     // pixels integrated at a time, scratch on the stack
    F0_REACH = 16,   // pixels: beyond, f0 is under 1e-100 of its centre
};

/* The corona bends on the scale of its distance, so the order falls with the
 * distance x = max(|x|, |y|) >= 1, in pixels; each keeps 1e-10. */
static const struct order {
    int x, n;
} orders[] = {{1, MAX_ORDER}, {2, 10}, {5, 6}, {12, 4}, {24, 3}};
enum { ORDERS = sizeof orders / sizeof *orders };

/* Nodes in pixels from the pixel's centre, in (-0.5, 0.5); weights sum to 1. */
struct rule {
    int n;
    double node[MAX_ORDER], weight[MAX_ORDER];
};

struct tables {
    struct rule rule[ORDERS];
    double centre;        // f1 and f2 in the centre's pixel
    double f0[F0_REACH];  // one axis of f0; f0(x, y) = f0[x] * f0[y]
};

/* Newton's method on the Legendre polynomial; Abramowitz and Stegun 25.4.29 */
static void make_rule(int n, struct rule *rule)
{
    rule->n = n;
    for (int i = 0; i < n; i++) {
        double x = cos(PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
        for (int step = 0; step < 8; step++) { // quadratic: 5 are enough
            double p0 = 1.0, p1 = x;
            for (int k = 2; k <= n; k++) {
                double p2 = ((2 * k - 1) * x * p1 - (k - 1) * p0) / k;
                p0 = p1;
                p1 = p2;
            }
            slope = n * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        rule->node[i] = 0.5 * x;
        rule->weight[i] = 1.0 / ((1.0 - x * x) * slope * slope);
    }
}

/* f1 and f2 over the square of half width `h` degrees around the source,
 * where they have a cusp: eight triangles 0 < phi < pi/4, each ray from 0 to
 * R = h / cos(phi) in closed form,
 *   integral of t / (t + A)^3 = R^2 / (2 A (R + A)^2)
 *   integral of t / (t + A)^2 = log(1 + R / A) - R / (R + A)
 * and a smooth function of phi is left. */
static double centre_square(double h, const struct rule *rule)
{
    double sum = 0.0;
    for (int i = 0; i < rule->n; i++) {
        double phi = PI / 4.0 * (0.5 + rule->node[i]);
        double r = h / cos(phi), s = r + A;
        sum += rule->weight[i] * (C1 * r * r / (2.0 * A * s * s) +
                                  C2 * (log1p(r / A) - r / s));
    }
    return 2.0 * PI * sum;
}

static void make_tables(struct tables *t)
{
    for (int i = 0; i < ORDERS; i++)
        make_rule(orders[i].n, &t->rule[i]);
    t->centre = centre_square(0.5 * PITCH, &t->rule[0]);
    double axis = sqrt(C0 * PI) * A / 2.0;
    for (int x = 0; x < F0_REACH; x++)
        t->f0[x] = axis * (erf((x + 0.5) * PITCH / A) -
                           erf((x - 0.5) * PITCH / A));
}

/* Adds f1 and f2 of the pixels (x, y), (x + 1, y), ... to sum[n]. */
GP_CLONES static void corona(const struct rule *rule, int x, int y, int n,
                             double *restrict sum)
{
    for (int j = 0; j < rule->n; j++) {
        double v = (y + rule->node[j]) * PITCH;
        for (int i = 0; i < rule->n; i++) {
            double w = rule->weight[i] * rule->weight[j] * PITCH * PITCH;
            double first = x + rule->node[i];
            for (int k = 0; k < n; k++) {
                double u = (first + k) * PITCH;
                double s = sqrt(u * u + v * v) + A;
                sum[k] += w * (C1 + C2 * s) / (s * s * s);
            }
        }
    }
}

/* The shares of the pixels (x, y) to (x + n - 1, y); 0 <= y <= x. */
static void strip(const struct tables *t, int x, int y, int n, double *share)
{
    memset(share, 0, (size_t) n * sizeof *share);
    if (x == 0)
        share[0] = t->centre;
    for (int i = 0; i < ORDERS; i++) {
        int from = orders[i].x > x ? orders[i].x : x;
        int to = i + 1 < ORDERS && orders[i + 1].x < x + n ? orders[i + 1].x
                                                           : x + n;
        if (from < to)
            corona(&t->rule[i], from, y, to - from, share + (from - x));
    }
    for (int k = 0; k < n && x + k < F0_REACH; k++)
        share[k] += t->f0[x + k] * t->f0[y];
}

double gp_eye_share(int x, int y)
{
    struct tables t;
    double share;
    x = abs(x);
    y = abs(y);
    make_tables(&t);
    strip(&t, x > y ? x : y, x > y ? y : x, 1, &share);
    return share;
}

// -- the whole kernel ---------------------------------------------------------

struct making {
    struct tables tables;
    int size, reach;       // reach = size / 2: the centre's row and column
    float *quadrant;       // (reach + 1)^2 shares, row y, column x
    struct gp_planes *k;
};

/* One row of the octant x >= y, and its mirror image, a column. */
static void make_octant_row(void *ctx, int y, int thread)
{
    const struct making *m = ctx;
    const size_t w = (size_t) m->reach + 1;
    double share[STRIP];
    (void) thread;
    for (int x = y; x <= m->reach; x += STRIP) {
        int n = m->reach + 1 - x < STRIP ? m->reach + 1 - x : STRIP;
        strip(&m->tables, x, y, n, share);
        for (int k = 0; k < n; k++) {
            float value = (float) share[k];
            m->quadrant[(size_t) y * w + (size_t) (x + k)] = value;
            m->quadrant[(size_t) (x + k) * w + (size_t) y] = value;
        }
    }
}

static void unfold_row(void *ctx, int y, int thread)
{
    const struct making *m = ctx;
    const size_t at = (size_t) y * (size_t) m->size;
    const float *row =
        m->quadrant + (size_t) abs(y - m->reach) * ((size_t) m->reach + 1);
    float *out = m->k->c[0] + at;
    (void) thread;
    for (int x = 0; x < m->size; x++)
        out[x] = row[abs(x - m->reach)];
    for (int c = 1; c < 3; c++)
        memcpy(m->k->c[c] + at, out, (size_t) m->size * sizeof *out);
}

gp_status gp_eye_make(const struct gp_log *log, int size, struct gp_planes *k)
{
    gp_status st;
    struct making m = {.size = size, .reach = size / 2, .k = k};
    const size_t w = (size_t) m.reach + 1;
    void *quadrant = NULL;

    *k = (struct gp_planes) {0};
    GP_TRY(gp_alloc(log, "eye kernel", w * w, sizeof(float), &quadrant));
    GP_TRY(gp_planes_make(log, "eye kernel", (size_t) size * (size_t) size, k));
    m.quadrant = quadrant;
    make_tables(&m.tables);
    gp_parallel_do((int) w, make_octant_row, &m);
    gp_parallel_do(size, unfold_row, &m);
out:
    GP_FREE(quadrant);
    return st;
}
