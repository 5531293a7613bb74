/* Models by plain formulas: blurs of every kind. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdlib.h>

#define PI 3.14159265358979323846

static gp_status make_state(const struct gp_log *log, const void *state,
                            size_t size, struct gp_shape *out)
{
    gp_status st = gp_alloc(log, "kernel", 1, size, &out->state);
    if (!st) {
        memcpy(out->state, state, size);
        out->free = gp_free;
    }
    return st;
}

// -- gaussian -----------------------------------------------------------------

/* exp(-t^2 / (2 sigma^2)) / (2 pi sigma^2) in the plane: a product of one curve
 * a direction, whose integral over a pixel is a difference of error
 * functions. */
struct gaussian {
    double sigma_x, sigma_y; // pixels
};

static double normal_share(double x, double sigma)
{
    const double a = (x - 0.5) / (sqrt(2.0) * sigma);
    const double b = (x + 0.5) / (sqrt(2.0) * sigma);
    // far out by the complement, which keeps its digits
    return a > 0.0 ? 0.5 * (erfc(a) - erfc(b)) : 0.5 * (erf(b) - erf(a));
}

static void gaussian_row(const void *state, int x, int y, int n,
                         double *const out[3])
{
    const struct gaussian *const g = state;
    const double row = normal_share(abs(y), g->sigma_y);
    for (int i = 0; i < n; i++)
        out[0][i] = row * normal_share(abs(x + i), g->sigma_x);
}

static const struct gp_model_key gaussian_keys[] = {
    GP_MODEL_SHARE(0.1),
    {"fwhm", "width at half its height, degrees", 0.5, 1e-4, 90.0, NULL,
     false},
    {0},
};

static gp_status open_gaussian(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    const double sigma =
        gp_recipe_value(r, "fwhm") / (2.0 * sqrt(2.0 * log1p(1.0)));
    const struct gaussian g = {
        sigma / (f->degrees * f->aspect), sigma / f->degrees,
    };
    // beyond 14 sigma a sample is under FLT_MIN
    const double reach = ceil(14.0 * fmax(g.sigma_x, g.sigma_y)) + 1.0;
    *out = (struct gp_shape) {
        .row = gaussian_row, .grey = true, .even = true, .smooth = INFINITY,
        .reach = reach < 1e6 ? (int) reach : INT_MAX,
    };
    return make_state(log, &g, sizeof g, out);
}

const struct gp_model gp_model_gaussian = {
    .name = "gaussian", .text = "a soft blur without a tail",
    .source = "normal distribution in two dimensions",
    .keys = gaussian_keys, .open = open_gaussian,
};

// -- moffat -------------------------------------------------------------------

/* (beta - 1) / (pi a^2) (1 + t^2 / a^2)^-beta, Moffat 1969 eq. 7: a blur with
 * wings, as air and emulsions make it. 1 over the plane; what lies beyond 90
 * degrees is left out. */
struct moffat {
    struct gp_field f;
    double a, beta, factor;
};

static void moffat_profile(const void *ctx, double t, double out[3])
{
    const struct moffat *const m = ctx;
    out[0] = m->factor * pow(1.0 + t * t / (m->a * m->a), -m->beta);
}

static void moffat_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct moffat *const m = state;
    for (int i = 0; i < n; i++) {
        double v[3];
        gp_pixel_integral(moffat_profile, m, 1, m->a, &m->f, x + i, y, v);
        out[0][i] = v[0];
    }
}

static const struct gp_model_key moffat_keys[] = {
    GP_MODEL_SHARE(0.1),
    {"fwhm", "width at half its height, degrees", 0.2, 1e-4, 90.0, NULL,
     false},
    {"beta", "power of its wings: light falls as distance^-2beta", 1.75, 1.05,
     20.0, NULL, false},
    {0},
};

static gp_status open_moffat(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct moffat m = {.f = *f, .beta = gp_recipe_value(r, "beta")};
    m.a = gp_recipe_value(r, "fwhm") / (2.0 * sqrt(exp2(1.0 / m.beta) - 1.0));
    m.factor = (m.beta - 1.0) / (PI * m.a * m.a);
    *out = (struct gp_shape) {
        .row = moffat_row, .grey = true, .even = true, .reach = INT_MAX,
        .smooth = m.a / (f->degrees * fmin(1.0, f->aspect)),
    };
    return make_state(log, &m, sizeof m, out);
}

const struct gp_model gp_model_moffat = {
    .name = "moffat", .text = "a blur with wings, as air and film make it",
    .source = "Moffat 1969, eq. 7", .keys = moffat_keys, .open = open_moffat,
};
