/* Builtin kernels: the point-spread functions of the eye and of lenses. */
#include "core/colour.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define PI 3.14159265358979323846

// -- the eye ------------------------------------------------------------------

/* builtin:eye, the point-spread function of the human eye in daylight.
 *
 *   P(t) = 0.384 f0 + 0.478 f1 + 0.138 f2        t: degrees from the source
 *   f0   = 2.61e6 exp(-(t / 0.02)^2)             unscattered light
 *   f1   = 20.91 / (t + 0.02)^3                  ciliary corona
 *   f2   = 72.37 / (t + 0.02)^2                  ciliary corona, far out
 *
 * Spencer, Shirley, Zimmerman, Greenberg: Physically-Based Glare Effects for
 * Digital Images, SIGGRAPH 95, the photopic function, eq. 5, per steradian.
 * (The lenticular halo belongs to the mesopic and scotopic functions.) Each
 * f is normalised: its integral over the hemisphere is 1, to the digits of
 * its constants.
 *
 * A size x size kernel of the shares of its pixels, three equal planes, not
 * normalised: its sum is the share of the light that stays inside, 0.9548 at
 * size 511 (tests/unit/glare/kernel_builtin.c). */
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
struct gauss_rule {
    int n;
    double node[MAX_ORDER], weight[MAX_ORDER];
};

struct eye_tables {
    struct gauss_rule rule[ORDERS];
    double centre;        // f1 and f2 in the centre's pixel
    double f0[F0_REACH];  // one axis of f0; f0(x, y) = f0[x] * f0[y]
};

/* Newton's method on the Legendre polynomial; Abramowitz and Stegun 25.4.29 */
static void make_gauss_rule(int n, struct gauss_rule *rule)
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

/* The centre's square, of half width h degrees, is where f1 and f2 have a
 * cusp: eight triangles 0 < phi < pi/4, each ray from 0 to R = h / cos(phi) in
 * closed form,
 *   integral of t / (t + A)^3 = R^2 / (2 A (R + A)^2)
 *   integral of t / (t + A)^2 = log(1 + R / A) - R / (R + A)
 * and a smooth function of phi is left. */
static void make_eye_tables(struct eye_tables *t)
{
    for (int i = 0; i < ORDERS; i++)
        make_gauss_rule(orders[i].n, &t->rule[i]);
    const struct gauss_rule *const rule = &t->rule[0];
    double sum = 0.0;
    for (int i = 0; i < rule->n; i++) {
        double phi = PI / 4.0 * (0.5 + rule->node[i]);
        double r = 0.5 * PITCH / cos(phi), s = r + A;
        sum += rule->weight[i] * (C1 * r * r / (2.0 * A * s * s) +
                                  C2 * (log1p(r / A) - r / s));
    }
    t->centre = 2.0 * PI * sum;
    double axis = sqrt(C0 * PI) * A / 2.0;
    for (int x = 0; x < F0_REACH; x++)
        t->f0[x] = axis * (erf((x + 0.5) * PITCH / A) -
                           erf((x - 0.5) * PITCH / A));
}

/* Adds f1 and f2 of the pixels (x, y), (x + 1, y), ... to sum[n]. */
GP_CLONES static void corona(const struct gauss_rule *rule, int x, int y, int n,
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
static void share_strip(const struct eye_tables *t, int x, int y, int n,
    double *share)
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
    struct eye_tables t;
    double share;
    x = abs(x);
    y = abs(y);
    make_eye_tables(&t);
    share_strip(&t, x > y ? x : y, x > y ? y : x, 1, &share);
    return share;
}

struct eye {
    struct eye_tables tables;
    int size, reach;       // reach = size / 2: the centre's row and column
    float *quadrant;       // (reach + 1)^2 shares, row y, column x
    struct gp_planes *k;
};

/* One row of the octant x >= y, and its mirror image, a column. */
static void make_octant_row(void *ctx, int y, int thread)
{
    const struct eye *m = ctx;
    const size_t w = (size_t) m->reach + 1;
    double share[STRIP];
    (void) thread;
    for (int x = y; x <= m->reach; x += STRIP) {
        int n = m->reach + 1 - x < STRIP ? m->reach + 1 - x : STRIP;
        share_strip(&m->tables, x, y, n, share);
        for (int k = 0; k < n; k++) {
            float value = (float) share[k];
            m->quadrant[(size_t) y * w + (size_t) (x + k)] = value;
            m->quadrant[(size_t) (x + k) * w + (size_t) y] = value;
        }
    }
}

static void unfold_row(void *ctx, int y, int thread)
{
    const struct eye *m = ctx;
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

// -- lenses -------------------------------------------------------------------

/* Each is a formula of dx, dy, pixels from the centre's pixel, and of R = size
 * / 2 (255.5 for 511 pixels), sampled at pixel centres. All are >= 0. */

/* Nearly exp(-z^2 / 2), but 0 from 4 on, with seven smooth derivatives. */
static double bump(double z)
{
    const double t = 1.0 - z * z / 16.0;
    const double t2 = t * t, t4 = t2 * t2;
    return t > 0.0 ? t4 * t4 : 0.0;
}

/* Across a ray: a line about as wide as 1/200 of the half width, never so
 * thin that it would fall between the samples. */
static double across(double v, double r)
{
    return bump(v / fmax(r / 200.0, 0.7));
}

/* The horizontal streak of an anamorphic lens, blue and bluer to its ends:
 *   v_c = a_c exp(-|dx| / (l_c R)) across(dy)
 *   a = 0.4, 0.6, 1     l = 0.15, 0.2, 0.3 */
static void streak(double dx, double dy, double r, double v[3])
{
    static const double a[3] = {0.4, 0.6, 1.0}, l[3] = {0.15, 0.2, 0.3};
    for (int c = 0; c < 3; c++)
        v[c] = a[c] * exp(-fabs(dx) / (l[c] * r)) * across(dy, r);
}

/* The diffraction of a stop of six blades: each pair of parallel edges
 * diffracts into two opposite rays at right angles to them, which fall off
 * with the square of the distance and are as long as the light's waves:
 *   v_c = sum over i = 0, 1, 2 of across(q_i) / (1 + (p_i / (w_c R / 40))^2)
 *   p_i, q_i  along and across the ray at 90, 30 and 150 degrees
 *   w         610, 550, 465 nm over 550 nm */
static void star(double dx, double dy, double r, double v[3])
{
    static const double w[3] = {610.0 / 550.0, 1.0, 465.0 / 550.0};
    v[0] = v[1] = v[2] = 0.0;
    for (int i = 0; i < 3; i++) {
        const double angle = PI / 2.0 + i * PI / 3.0;
        const double p = dx * cos(angle) + dy * sin(angle);
        const double q = dy * cos(angle) - dx * sin(angle);
        for (int c = 0; c < 3; c++) {
            const double t = p / (w[c] * r / 40.0);
            v[c] += across(q, r) / (1.0 + t * t);
        }
    }
}

/* The cross screen filter of photographers: two streaks at right angles,
 *   v = exp(-|dx| / (0.2 R)) across(dy) + exp(-|dy| / (0.2 R)) across(dx) */
static void cross(double dx, double dy, double r, double v[3])
{
    v[0] = v[1] = v[2] = exp(-fabs(dx) / (0.2 * r)) * across(dy, r) +
                         exp(-fabs(dy) / (0.2 * r)) * across(dx, r);
}

/* A point out of focus: a disc of radius R / 2 whose rim, R / 16 wide, falls
 * by a smoothstep s:
 *   v = s((R / 2 - |d|) / (R / 16)) */
static void circle(double dx, double dy, double r, double v[3])
{
    const double d = sqrt(dx * dx + dy * dy);
    const double t = fmin(fmax((r / 2.0 - d) / (r / 16.0), 0.0), 1.0);
    v[0] = v[1] = v[2] = t * t * (3.0 - 2.0 * t);
}

/* A halo by diffraction, red outside and blue inside:
 *   v_c = bump((|d| - 0.4 w_c R) / max(R / 50, 1))     w as for the star */
static void ring(double dx, double dy, double r, double v[3])
{
    static const double w[3] = {610.0 / 550.0, 1.0, 465.0 / 550.0};
    const double d = sqrt(dx * dx + dy * dy);
    for (int c = 0; c < 3; c++)
        v[c] = bump((d - 0.4 * w[c] * r) / fmax(r / 50.0, 1.0));
}

struct sampling {
    void (*formula)(double dx, double dy, double r, double v[3]);
    const double *mix; // BT.709 to the frame's primaries; NULL: as they are
    int size;
    struct gp_planes *k;
};

static void sample_row(void *ctx, int y, int thread)
{
    const struct sampling *const s = ctx;
    const size_t at = (size_t) y * (size_t) s->size;
    (void) thread;
    for (int x = 0; x < s->size; x++) {
        double v[3];
        s->formula(x - s->size / 2, y - s->size / 2, s->size / 2.0, v);
        for (int c = 0; c < 3; c++) {
            const double *const m = s->mix ? s->mix + 3 * c : NULL;
            // clamp: the primaries may not span the colour
            const double mixed =
                m ? fmax(m[0] * v[0] + m[1] * v[1] + m[2] * v[2], 0.0) : v[c];
            s->k->c[c][at + (size_t) x] = (float) mixed;
        }
    }
}

const struct gp_builtin_kernel gp_builtin_kernels[] = {
    {"eye", "the human eye in daylight (Spencer et al. 1995)", NULL, false},
    {"streak", "the blue horizontal streak of an anamorphic lens", streak,
     true},
    {"star", "six rays of a stop with six blades, redder outside", star, true},
    {"cross", "four rays of a cross screen filter", cross, false},
    {"circle", "an even disc with a soft rim: a point out of focus", circle,
     false},
    {"ring", "a halo, red outside and blue inside", ring, true},
    {0},
};

// -- by name ------------------------------------------------------------------

/* Fades a kernel to 0 at its edge, from half the radius on, by a smoothstep of
 * the distance from the centre: a sudden end shows as a square around every
 * lamp at night. */
static void fade_row(void *ctx, int y, int thread)
{
    const struct sampling *const f = ctx;
    const double reach = f->size / 2.0, start = reach / 2.0;
    const double dy = y - f->size / 2;
    (void) thread;
    for (int x = 0; x < f->size; x++) {
        const double dx = x - f->size / 2;
        const double r = sqrt(dx * dx + dy * dy);
        if (r <= start)
            continue;
        const double t = fmin((r - start) / (reach - start), 1.0);
        const double keep = 1.0 - t * t * (3.0 - 2.0 * t);
        for (int c = 0; c < 3; c++) {
            float *const v = f->k->c[c] + (size_t) y * (size_t) f->size;
            v[x] = (float) ((double) v[x] * keep);
        }
    }
}

gp_status gp_builtin_make(const struct gp_log *log,
    const struct gp_kernel_params *p, struct gp_planes *out, bool *coloured)
{
    enum {
        MOST = 16383,     // pixels wide; 3 GiB
        LEAST_FADED = 65, // smaller ones have no room to fade in
    };
    static const char prefix[] = "builtin:";
    const char *const name = p->source;
    const int size = p->builtin_size;
    const size_t skipped =
        strncmp(name, prefix, strlen(prefix)) == 0 ? strlen(prefix) : 0;
    const struct gp_builtin_kernel *b = gp_builtin_kernels;
    char names[256] = "";
    while (b->name && strcmp(b->name, name + skipped) != 0) {
        const size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%sbuiltin:%s",
                 used ? ", " : "", b->name);
        b++;
    }
    if (!b->name)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no builtin kernel of this name; use %s, or an "
                       "image file", name, names);
    if (size < 1 || size > MOST || size % 2 == 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: a builtin kernel of %d pixels is not possible; use "
                       "an odd width from 1 to %d", name, size, MOST);
    double mix[9];
    struct sampling s = {b->formula, NULL, size, out};
    *coloured = b->coloured;
    if (b->coloured && p->frame &&
        memcmp(p->frame->chromaticities, gp_rec709_chromaticities,
               sizeof gp_rec709_chromaticities) != 0 &&
        gp_rgb_to_rgb(gp_rec709_chromaticities, p->frame->chromaticities, mix)) {
        s.mix = mix;
        for (int c = 0; c < 3; c++) { // white scatters as it is, in XYZ too
            double *const m = mix + 3 * c;
            const double white = m[0] + m[1] + m[2];
            for (int i = 0; i < 3; i++)
                m[i] /= white;
        }
    }
    gp_status st = gp_planes_make(log, "builtin kernel",
                                  (size_t) size * (size_t) size, out);
    if (st)
        return st;
    if (b->formula) {
        gp_parallel_do(size, sample_row, &s);
    } else {
        struct eye m = {.size = size, .reach = size / 2, .k = out};
        const size_t w = (size_t) m.reach + 1;
        st = gp_alloc(log, "eye kernel", w * w, sizeof(float), &m.quadrant);
        if (st) {
            gp_planes_free(out);
            return st;
        }
        make_eye_tables(&m.tables);
        gp_parallel_do((int) w, make_octant_row, &m);
        gp_parallel_do(size, unfold_row, &m);
        gp_free(m.quadrant);
    }
    if (size >= LEAST_FADED)
        gp_parallel_do(size, fade_row, &s);
    return GP_OK;
}
