/* Integrals over pixels of what falls off around a point. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <stdint.h>
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

// -- tables -------------------------------------------------------------------

/* A profile and its slope by the square of the distance, at 64 even steps an
 * octave, between which a cubic keeps both: about 1e-8 of a power's value. */
enum { STEPS_LOG2 = 6, STEPS = 1 << STEPS_LOG2 };

struct radial_table {
    struct gp_field f;
    gp_profile profile;
    void *ctx;
    double scale;
    int channels;
    uint64_t first;  // bits of the least square / (2^52 / STEPS)
    int n;           // steps
    double *value;   // [n + 1][channels][2]: value, slope times the step
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

/* Adds weight times the profile at the squared distance s. */
static inline void add_table(const struct radial_table *t, double s,
                             double weight, double sum[3])
{
    const uint64_t bits = bits_of(s);
    const int64_t i = (int64_t) (bits >> (52 - STEPS_LOG2)) -
                      (int64_t) t->first;
    if (i >= t->n)
        return;
    // the mantissa's rest is the place between two steps
    const uint64_t rest = bits << (12 + STEPS_LOG2) >> 12;
    const double x = of_bits(rest | 0x3ff0000000000000u) - 1.0, y = 1.0 - x;
    for (int c = 0; c < t->channels; c++) {
        const double *const a = t->value + 2 * ((size_t) i *
            (size_t) t->channels + (size_t) c);
        const double *const b = a + 2 * t->channels;
        // the slope of the step after an octave's last is by its own width
        const double next = i % STEPS == STEPS - 1 ? 0.5 * b[1] : b[1];
        sum[c] += weight * (y * y * ((1.0 + 2.0 * x) * a[0] + x * a[1]) +
                            x * x * ((1.0 + 2.0 * y) * b[0] - y * next));
    }
}

static void radial_table_row(const void *state, int x, int y, int n,
                             double *const out[3])
{
    static const struct {
        int from, order; // longer sides from the light; nodes that keep 1e-8
    } orders[] = {{32, 2}, {12, 3}, {6, 4}, {3, 6}, {2, 10}};
    const struct radial_table *const t = state;
    const double b = t->f.degrees, a = b * t->f.aspect, side = fmax(a, b);
    for (int i = 0; i < n; i++) {
        const int far = (int) (fmax(a * abs(x + i), b * abs(y)) / side + 1e-9);
        double sum[3] = {0};
        if (far <= 1) {
            gp_pixel_integral(t->profile, t->ctx, t->channels, t->scale, &t->f,
                              x + i, y, sum);
        } else {
            int k = 0;
            while (far < orders[k].from)
                k++;
            const struct gp_gauss *const g = &rules[orders[k].order];
            for (int q = 0; q < g->n; q++) {
                const double v = b * (abs(y) + g->node[q]);
                for (int p = 0; p < g->n; p++) {
                    const double u = a * (abs(x + i) + g->node[p]);
                    add_table(t, u * u + v * v,
                              a * b * g->weight[p] * g->weight[q], sum);
                }
            }
        }
        for (int c = 0; c < t->channels; c++)
            out[c][i] = sum[c];
    }
}

static void free_table(void *state)
{
    struct radial_table *const t = state;
    gp_free(t->value);
    gp_free(t->ctx);
    gp_free(t);
}

gp_status gp_radial_shape(const struct gp_log *log, gp_profile p,
    const void *ctx, size_t size, int channels, double scale,
    const struct gp_field *f, struct gp_shape *out)
{
    struct radial_table *t;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *t, &t);
    if (st)
        return st;
    *t = (struct radial_table) {
        .f = *f, .profile = p, .scale = scale, .channels = channels,
    };
    // from inside the pixels next to the light's neighbours to 90 degrees
    const double least = f->degrees * fmin(f->aspect, 1.0);
    const uint64_t shift = 52 - STEPS_LOG2;
    t->first = bits_of(least * least) >> (shift + STEPS_LOG2) << STEPS_LOG2;
    const uint64_t last = bits_of(90.0 * 90.0) >> shift;
    t->n = last > t->first ? (int) (last - t->first) : 0;
    st = gp_alloc(log, "kernel", size, 1, &t->ctx);
    if (!st)
        st = gp_alloc(log, "kernel", 2 * (size_t) channels,
                      ((size_t) t->n + 1) * sizeof *t->value, &t->value);
    if (st) {
        free_table(t);
        return st;
    }
    memcpy(t->ctx, ctx, size);
    gp_gauss_rule(1); // the rules
    for (int i = 0; i <= t->n; i++) {
        const uint64_t bits = (t->first + (uint64_t) i) << shift;
        const double s = of_bits(bits), step = of_bits(bits + (1ull << shift)) -
                                               s;
        double at[3], low[3], high[3];
        const double h = 1e-3;
        p(t->ctx, sqrt(s), at);
        p(t->ctx, sqrt(s * (1.0 - h)), low);
        p(t->ctx, sqrt(s * (1.0 + h)), high);
        for (int c = 0; c < channels; c++) {
            double *const v = t->value + 2 * (i * channels + c);
            v[0] = at[c];
            v[1] = (high[c] - low[c]) / (2.0 * h * s) * step;
        }
    }
    *out = (struct gp_shape) {
        .state = t, .free = free_table, .row = radial_table_row,
        .grey = channels == 1, .even = true, .reach = INT_MAX,
        .smooth = scale / least,
    };
    return GP_OK;
}
