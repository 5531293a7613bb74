/* Integrals over pixels of what falls off around a point. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>

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

// -- shapes by tables ---------------------------------------------------------

/* By the square s of the distance, at 64 even steps an octave, with slopes,
 * between which a cubic keeps about 1e-8 of what powers give. */
enum { STEPS_LOG2 = 6, STEPS = 1 << STEPS_LOG2 };

struct table {
    uint64_t first;  // bits of the least square / (2^52 / STEPS)
    int n;           // steps
    double *value;   // [n + 1][channels][2]: value, slope times the step
};

/* The profile p(t), and disc(r), the integral of p(t) t from 0 to r: 1 / (2 pi)
 * of the light within r. */
struct radial_table {
    struct gp_field f;
    int channels;
    int bends;       // longer sides within which 4 nodes are the fewest
    struct table profile, disc;
};

static double of_bits(uint64_t bits)
{
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static uint64_t bits_of(double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits;
}

/* Adds weight times the value at the squared distance s; nothing past the
 * table's end. */
static inline void add_table(const struct table *t, int channels, double s,
                             double weight, double sum[3])
{
    const uint64_t bits = bits_of(s);
    const int64_t i = (int64_t) (bits >> (52 - STEPS_LOG2)) -
                      (int64_t) t->first;
    if (i < 0 || i >= t->n)
        return;
    // the mantissa's rest is the place between two steps
    const uint64_t rest = bits << (12 + STEPS_LOG2) >> 12;
    const double x = of_bits(rest | 0x3ff0000000000000u) - 1.0, y = 1.0 - x;
    for (int c = 0; c < channels; c++) {
        const double *const a =
            t->value + 2 * ((size_t) i * (size_t) channels + (size_t) c);
        const double *const b = a + 2 * channels;
        // the slope of the step after an octave's last is by its own width
        const double next = i % STEPS == STEPS - 1 ? 0.5 * b[1] : b[1];
        sum[c] += weight * (y * y * ((1.0 + 2.0 * x) * a[0] + x * a[1]) +
                            x * x * ((1.0 + 2.0 * y) * b[0] - y * next));
    }
}

/* Adds `sign` times the integral over the triangle from the light to the edge
 * of points from..to on a line `d` away: disc(r) over its angles. With the
 * place on the edge d sinh(q) the angle is d q / cosh(q), r = d cosh(q). */
static void add_edge(const struct radial_table *t, double d, double from,
                     double to, double sign, double sum[3])
{
    const double sum_sign = d < 0.0 ? -sign : sign, a = fabs(d);
    if (a < 1e-9 * t->f.degrees)
        return; // seen end on
    const double low = asinh(from / a), high = asinh(to / a);
    const int panels = (int) ceil((high - low) / 1.5);
    const struct gp_gauss *const g = &rules[8];
    const double width = (high - low) / panels;
    for (int k = 0; k < panels * g->n; k++) {
        const double q =
            low + width * (k / g->n + 0.5 + g->node[k % g->n]);
        const double grow = cosh(q);
        add_table(&t->disc, t->channels, a * a * grow * grow,
                  sum_sign * width * g->weight[k % g->n] / grow, sum);
    }
}

/* The light's own pixel and those near it: from places spread over the light's
 * pixel to all of the other, edge by edge. */
static void near_pixel(const struct radial_table *t, int x, int y,
                       double sum[3])
{
    const struct gp_gauss *const g = &rules[8];
    const double b = t->f.degrees, a = b * t->f.aspect;
    for (int j = 0; j < g->n; j++) {
        for (int i = 0; i < g->n; i++) {
            const double weight = g->weight[i] * g->weight[j];
            const double u = a * (x - g->node[i]), v = b * (y - g->node[j]);
            const double u0 = u - 0.5 * a, u1 = u + 0.5 * a;
            const double v0 = v - 0.5 * b, v1 = v + 0.5 * b;
            add_edge(t, u1, v0, v1, weight, sum);
            add_edge(t, u0, v0, v1, -weight, sum);
            add_edge(t, v1, u0, u1, weight, sum);
            add_edge(t, v0, u0, u1, -weight, sum);
        }
    }
}

static void radial_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    static const struct {
        int from, order; // longer sides from the light; nodes that keep 1e-8
    } orders[] = {{40, 2}, {16, 3}, {8, 4}, {4, 6}, {2, 10}};
    const struct radial_table *const t = state;
    const double b = t->f.degrees, a = b * t->f.aspect, side = fmax(a, b);
    for (int i = 0; i < n; i++) {
        const int px = abs(x + i), py = abs(y);
        const int far = (int) (fmax(a * px, b * py) / side + 1e-9);
        double sum[3] = {0};
        if (far < 2) {
            near_pixel(t, px, py, sum);
        } else {
            int k = far < t->bends ? 2 : 0;
            while (far < orders[k].from)
                k++;
            const struct gp_gauss *const g = &tents[orders[k].order];
            for (int q = 0; q < g->n; q++) {
                const double v = b * (py + g->node[q]);
                for (int p = 0; p < g->n; p++) {
                    const double u = a * (px + g->node[p]);
                    add_table(&t->profile, t->channels, u * u + v * v,
                              a * b * g->weight[p] * g->weight[q], sum);
                }
            }
        }
        for (int c = 0; c < t->channels; c++)
            out[c][i] = fmax(sum[c], 0.0);
    }
}

static void free_radial(void *state)
{
    struct radial_table *const t = state;
    gp_free(t->profile.value);
    gp_free(t->disc.value);
    gp_free(t);
}

/* Allocates entries for squares of distances from `least` to `most`. */
static gp_status make_table(const struct gp_log *log, int channels,
                            double least, double most, struct table *out)
{
    const uint64_t shift = 52 - STEPS_LOG2;
    const uint64_t last = bits_of(most * most) >> shift;
    struct table t = {
        .first = bits_of(least * least) >> (shift + STEPS_LOG2) << STEPS_LOG2,
    };
    t.n = last > t.first ? (int) (last - t.first) : 0;
    gp_status st = gp_alloc(log, "kernel", 2 * (size_t) channels,
                            ((size_t) t.n + 1) * sizeof *t.value, &t.value);
    if (!st)
        *out = t;
    return st;
}

gp_status gp_radial_shape(const struct gp_log *log, gp_profile p,
    const void *ctx, int channels, double bends, const struct gp_field *f,
    struct gp_shape *out)
{
    static const uint64_t one = 1ull << (52 - STEPS_LOG2);
    const double least = f->degrees * fmin(f->aspect, 1.0);
    const double most = f->degrees * fmax(f->aspect, 1.0);
    const struct gp_gauss *const g = gp_gauss_rule(6);
    struct radial_table *t;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *t, &t);
    if (st)
        return st;
    t->f = *f;
    t->channels = channels;
    t->bends = (int) fmin(bends / most + 1.0, INT_MAX / 2);
    // near pixels reach 1 of the longer sides and two halves more
    st = make_table(log, channels, 1e-3 * least, 4.0 * most, &t->disc);
    if (!st)
        st = make_table(log, channels, least, 90.0, &t->profile);
    if (st) {
        free_radial(t);
        return st;
    }
    for (int i = 0; i <= t->profile.n; i++) {
        const uint64_t bits = (t->profile.first + (uint64_t) i) * one;
        const double s = of_bits(bits), step = of_bits(bits + one) - s;
        const double h = 1e-3;
        double at[3], low[3], high[3];
        p(ctx, sqrt(s), at);
        p(ctx, sqrt(s * (1.0 - h)), low);
        p(ctx, sqrt(s * (1.0 + h)), high);
        for (int c = 0; c < channels; c++) {
            double *const v = t->profile.value + 2 * (i * channels + c);
            v[0] = at[c];
            v[1] = (high[c] - low[c]) / (2.0 * h * s) * step;
        }
    }
    double disc[3] = {0}, before = 0.0, sum[3];
    for (int i = 0; i <= t->disc.n; i++) {
        const uint64_t bits = (t->disc.first + (uint64_t) i) * one;
        const double s = of_bits(bits), step = of_bits(bits + one) - s;
        const double r = sqrt(s);
        double at[3];
        if (i == 0) { // within the first: steps that grow with the distance
            gp_profile_integral(p, ctx, channels, 0.0, r, sum);
            for (int c = 0; c < channels; c++)
                disc[c] = sum[c] / (2.0 * PI);
        }
        for (int k = 0; k < g->n && i > 0; k++) {
            const double at_r = 0.5 * (before + r) + (r - before) * g->node[k];
            p(ctx, at_r, at);
            for (int c = 0; c < channels; c++)
                disc[c] += (r - before) * g->weight[k] * at_r * at[c];
        }
        before = r;
        p(ctx, r, at);
        for (int c = 0; c < channels; c++) {
            double *const v = t->disc.value + 2 * (i * channels + c);
            v[0] = disc[c];
            v[1] = 0.5 * at[c] * step;
        }
    }
    *out = (struct gp_shape) {
        .state = t, .free = free_radial, .row = radial_row,
        .grey = channels == 1, .even = true, .reach = INT_MAX,
    };
    return GP_OK;
}
