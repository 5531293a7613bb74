/* Rules of quadrature, and integrals of profiles over the plane. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

enum { MOST_NODES = 16, MOST_TENT = 10 };

static struct gp_gauss rules[MOST_NODES + 1], tents[MOST_TENT + 1];

/* Newton's method on the Legendre polynomials; Abramowitz and Stegun 25.4.29 */
static void make_rules(void)
{
    for (int n = 1; n <= MOST_NODES; n++) {
        rules[n].n = n;
        for (int i = 0; i < n; i++) {
            double x = cos(M_PI * (i + 0.75) / (n + 0.5)), slope = 1.0;
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

double gp_plane_factor(double t)
{
    const double radians = t * (M_PI / 180.0), degree = M_PI / 180.0;
    if (!(t < 90.0))
        return 0.0;
    return degree * degree * (radians > 1e-4 ? sin(radians) / radians : 1.0);
}

void gp_profile_integral(gp_profile p, const void *ctx, int channels,
                         double from, double end, double sum[3])
{
    enum { STEPS = 512 };
    const struct gp_gauss *const g = gp_gauss_rule(8);
    const double least = fmax(from, 1e-6), growth = end / least;
    sum[0] = sum[1] = sum[2] = 0.0;
    for (int i = 0; i <= STEPS; i++) {
        const double low =
            i > 0 ? least * pow(growth, (i - 1.0) / STEPS) : from;
        const double high = least * pow(growth, (double) i / STEPS);
        for (int k = 0; k < g->n && high > low; k++) {
            const double t = 0.5 * (low + high) + (high - low) * g->node[k];
            double v[3];
            p(ctx, t, v);
            for (int c = 0; c < channels; c++)
                sum[c] += (high - low) * g->weight[k] * 2.0 * M_PI * t * v[c];
        }
    }
}

// -- light of shapes finer than a pixel, shared out by where it falls ---------

gp_status gp_deposit_make(const struct gp_log *log, int rx, int ry,
                          struct gp_deposit *out)
{
    const size_t n = (2 * (size_t) rx + 1) * (2 * (size_t) ry + 1);
    struct gp_deposit d = {.rx = rx, .ry = ry};
    gp_status st = gp_alloc_zero(log, "kernel", 3 * n, sizeof(double), &d.v[0]);
    if (st)
        return st;
    d.v[1] = d.v[0] + n;
    d.v[2] = d.v[1] + n;
    *out = d;
    return GP_OK;
}

void gp_deposit_free(struct gp_deposit *d)
{
    gp_free(d->v[0]);
    *d = (struct gp_deposit) {0};
}

void gp_deposit_add(const struct gp_deposit *d, double u, double v,
                    const double light[3])
{
    if (!(fabs(u) < d->rx + 1.0 && fabs(v) < d->ry + 1.0))
        return;
    const int x0 = (int) floor(u), y0 = (int) floor(v);
    const double right = u - x0, low = v - y0;
    for (int k = 0; k < 4; k++) {
        const int x = x0 + k % 2, y = y0 + k / 2;
        const double share = (k % 2 ? right : 1.0 - right) *
                             (k / 2 ? low : 1.0 - low);
        if (abs(x) > d->rx || abs(y) > d->ry)
            continue;
        const size_t at = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1) +
                          (size_t) (x + d->rx);
        for (int c = 0; c < 3; c++)
            d->v[c][at] += share * light[c];
    }
}

void gp_deposit_row(const struct gp_deposit *d, int channels, int x, int y,
                    int n, double *const out[3])
{
    const size_t row = (size_t) (y + d->ry) * (2 * (size_t) d->rx + 1);
    for (int i = 0; i < n; i++) {
        const bool inside = abs(y) <= d->ry && abs(x + i) <= d->rx;
        for (int c = 0; c < channels; c++)
            out[c][i] = inside ? d->v[c][row + (size_t) (x + i + d->rx)] : 0.0;
    }
}

// -- rings --------------------------------------------------------------------

/* Adds the circle of radii (u, v) pixels about the light: arcs between the
 * places where it passes from pixel to pixel, on which tents are straight. */
static void add_circle(const struct gp_deposit *d, double u, double v,
                       const double light[3])
{
    const int columns = (int) fmin(u, d->rx + 1.0);
    const int rows = (int) fmin(v, d->ry + 1.0);
    // angles that grow: columns from the last, rows from the first
    int column = columns, row = 1;
    double from = 0.0;
    for (;;) {
        const double by_column =
            column > 0 ? acos(fmin(column / u, 1.0)) : 0.5 * M_PI;
        const double by_row = row <= rows ? asin(fmin(row / v, 1.0))
                                          : 0.5 * M_PI;
        const double to = fmin(by_column, by_row);
        const struct gp_gauss *const g = gp_gauss_rule(to - from > 0.5 ? 7 : 4);
        for (int k = 0; k < g->n && to > from; k++) {
            const double angle =
                0.5 * (from + to) + (to - from) * g->node[k];
            const double share = (to - from) * g->weight[k] / (2.0 * M_PI);
            const double quarter[3] = {share * light[0], share * light[1],
                                    share * light[2]};
            const double x = u * cos(angle), y = v * sin(angle);
            gp_deposit_add(d, x, y, quarter);
            gp_deposit_add(d, -x, y, quarter);
            gp_deposit_add(d, x, -y, quarter);
            gp_deposit_add(d, -x, -y, quarter);
        }
        if (column <= 0 && row > rows)
            return;
        from = fmax(from, to);
        if (column > 0 && by_column <= by_row)
            column--;
        else
            row++;
    }
}

void gp_deposit_rings(const struct gp_deposit *d, gp_profile p,
    const void *ctx, const struct gp_field *f, double from, double to,
    double light[3])
{
    const struct gp_gauss *const g = gp_gauss_rule(6);
    const double b = f->degrees, a = b * f->aspect;
    while (from < to) {
        // to where circles begin to reach another column or row
        const double next = fmin(a * floor(from / a * (1.0 + 1e-12) + 1.0),
                                 b * floor(from / b * (1.0 + 1e-12) + 1.0));
        const double end = next < to ? next : to;
        for (int k = 0; k < g->n; k++) {
            // a circle's part beyond a line grows with the root of the distance
            const double root = 0.5 + g->node[k];
            const double t = from + (end - from) * root * root;
            const double ring = 2.0 * M_PI * t * (end - from) * 2.0 * root *
                                g->weight[k];
            double v[3] = {0};
            p(ctx, t, v);
            for (int c = 0; c < 3; c++) {
                v[c] *= ring;
                light[c] += v[c];
            }
            add_circle(d, t / a, t / b, v);
        }
        from = end;
    }
}
