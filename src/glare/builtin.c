#include "glare/builtin.h"

#include "core/parallel.h"
#include "glare/eye.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double PI = 3.14159265358979323846;

/* A kernel's value in each channel, `dx`, `dy` pixels from its centre; `r` is
 * half its width. */
typedef void (*formula)(double dx, double dy, double r, double v[3]);

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

// -- the formulas -------------------------------------------------------------

/* The horizontal streak of an anamorphic lens, blue and bluer to its ends:
 *   v_c = a_c exp(-|dx| / (l_c R)) across(dy)
 *   a = 0.4, 0.6, 1     l = 0.15, 0.2, 0.3 */
static void streak(double dx, double dy, double r, double v[3])
{
    static const double a[3] = {0.4, 0.6, 1.0}, l[3] = {0.15, 0.2, 0.3};
    for (int c = 0; c < 3; c++)
        v[c] = a[c] * exp(-fabs(dx) / (l[c] * r)) * across(dy, r);
}

/* What a stop of six blades makes of a point: each pair of parallel edges
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

// -- sampling them ------------------------------------------------------------

struct filling {
    formula f;
    int size;
    struct gp_planes *k;
};

static void fill_row(void *ctx, int y, int thread)
{
    const struct filling *const s = ctx;
    const size_t at = (size_t) y * (size_t) s->size;
    (void) thread;
    for (int x = 0; x < s->size; x++) {
        double v[3];
        s->f(x - s->size / 2, y - s->size / 2, s->size / 2.0, v);
        for (int c = 0; c < 3; c++)
            s->k->c[c][at + (size_t) x] = (float) v[c];
    }
}

static gp_status fill(const struct gp_log *log, int size, formula f,
                      struct gp_planes *k)
{
    gp_status st = gp_planes_make(log, "builtin kernel",
                                  (size_t) size * (size_t) size, k);
    struct filling s = {f, size, k};
    if (!st)
        gp_parallel_do(size, fill_row, &s);
    return st;
}

#define MAKER(name)                                                           \
    static gp_status make_##name(const struct gp_log *log, int size,          \
                                 struct gp_planes *k)                         \
    {                                                                         \
        return fill(log, size, name, k);                                      \
    }
MAKER(streak)
MAKER(star)
MAKER(cross)
MAKER(circle)
MAKER(ring)

const struct gp_builtin_kernel gp_builtin_kernels[] = {
    {"eye", "the human eye in daylight (Spencer et al. 1995)", gp_eye_make},
    {"streak", "the blue horizontal streak of an anamorphic lens",
     make_streak},
    {"star", "six rays of a stop with six blades, redder outside", make_star},
    {"cross", "four rays of a cross screen filter", make_cross},
    {"circle", "an even disc with a soft rim: a point out of focus",
     make_circle},
    {"ring", "a halo, red outside and blue inside", make_ring},
    {0},
};

// -- by name, and the rim -----------------------------------------------------

const struct gp_builtin_kernel *gp_builtin_find(const char *name)
{
    static const char prefix[] = "builtin:";
    if (strncmp(name, prefix, strlen(prefix)) == 0)
        name += strlen(prefix);
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        if (strcmp(b->name, name) == 0)
            return b;
    }
    return NULL;
}

gp_status gp_builtin_unknown(const struct gp_log *log, const char *name)
{
    char names[256] = "";
    for (const struct gp_builtin_kernel *b = gp_builtin_kernels; b->name; b++) {
        size_t used = strlen(names);
        snprintf(names + used, sizeof names - used, "%sbuiltin:%s",
                 used ? ", " : "", b->name);
    }
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: no builtin kernel has this name; use one of %s, or a "
                   "file", name, names);
}

enum { LEAST_FADED = 65 }; // smaller ones have no room to fade in

struct fading {
    int size;
    struct gp_planes *k;
};

static void fade_row(void *ctx, int y, int thread)
{
    const struct fading *const f = ctx;
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

void gp_builtin_fade(int size, struct gp_planes *k)
{
    struct fading f = {size, k};
    if (size >= LEAST_FADED)
        gp_parallel_do(size, fade_row, &f);
}
