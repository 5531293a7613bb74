// SPDX-License-Identifier: Apache-2.0
/* Models by plain formulas: blurs, halation, discs and rings; and an image, as
 * one of several recipes: a lens' measured or painted picture of a point. */
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

// -- gaussian -----------------------------------------------------------------

/* exp(-t^2 / (2 sigma^2)) / (2 pi sigma^2) in the plane: a product of one curve
 * a direction, whose integral over a pixel is a difference of error
 * functions. */
struct gaussian {
    double sigma_x, sigma_y; // pixels
};

/* The share of pixel x, x >= 0, of light that is even over pixel 0. */
static double normal_share(double x, double sigma)
{
    const struct gp_gauss *const g = gp_tent_rule(6);
    double sum = 0.0;
    if (sigma < 30.0)
        return fmax(sigma * (gp_normal_twice((x + 1.0) / sigma) -
                             2.0 * gp_normal_twice(x / sigma) +
                             gp_normal_twice((x - 1.0) / sigma)),
                    0.0);
    for (int i = 0; i < g->n; i++) { // differences would lose their digits
        const double z = (x + g->node[i]) / sigma;
        sum += g->weight[i] * gp_exp(-0.5 * z * z);
    }
    return sum / (sqrt(2.0 * M_PI) * sigma);
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
    {"fwhm", "width at half its height, degrees", 0.5, 1e-4, 90.0, NULL},
    {0},
};

static gp_status open_gaussian(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    const double sigma = gp_recipe_value(r, "fwhm") / (2.0 * sqrt(2.0 * M_LN2));
    struct gaussian *g;
    gp_status st = gp_alloc(log, "kernel", 1, sizeof *g, &g);
    if (st)
        return st;
    g->sigma_x = sigma / (f->degrees * f->aspect);
    g->sigma_y = sigma / f->degrees;
    // beyond 14 sigma a sample is under FLT_MIN
    const double reach = ceil(14.0 * fmax(g->sigma_x, g->sigma_y)) + 1.0;
    *out = (struct gp_shape) {
        .state = g, .free = gp_free, .row = gaussian_row, .grey = true,
        .even = true, .smooth = INFINITY,
        .reach = reach < 1e6 ? (int) reach : INT_MAX,
    };
    return GP_OK;
}

const struct gp_model gp_model_gaussian = {
    .name = "gaussian", .text = "a soft blur without a tail",
    .source = "normal distribution in two dimensions",
    .keys = gaussian_keys, .open = open_gaussian,
};

// -- moffat -------------------------------------------------------------------

/* (beta - 1) / (pi a^2) (1 + t^2 / a^2)^-beta, Moffat 1969 eq. 7: a blur with
 * wings, as air and emulsions make it. 1 over the plane, which goes on beyond
 * 90 degrees. */
struct moffat {
    double a, beta, factor;
};

static void moffat_profile(const void *ctx, double t, double out[3])
{
    const struct moffat *const m = ctx;
    out[0] = m->factor * gp_pow(1.0 + t * t / (m->a * m->a), -m->beta);
}

static const struct gp_model_key moffat_keys[] = {
    GP_MODEL_SHARE(0.1),
    {"fwhm", "width at half its height, degrees", 0.2, 1e-4, 90.0, NULL},
    {"beta", "power of its wings: light falls as distance^-2beta", 1.75, 1.05,
     20.0, NULL},
    {0},
};

static struct moffat moffat_of(const struct gp_recipe *r)
{
    struct moffat m = {.beta = gp_recipe_value(r, "beta")};
    m.a =
        gp_recipe_value(r, "fwhm") / (2.0 * sqrt(gp_exp2(1.0 / m.beta) - 1.0));
    m.factor = (m.beta - 1.0) / (M_PI * m.a * m.a);
    return m;
}

static double moffat_light(const struct gp_angular *a, GP_UNUSED int c,
                           double t)
{
    const struct moffat m = {a->v[0], a->v[1], a->v[2]};
    double v[3];
    moffat_profile(&m, t, v);
    return v[0];
}

/* The same powers per steradian, 1 over the hemisphere. */
static void moffat_in_plane(const void *ctx, double t, double out[3])
{
    moffat_profile(ctx, t, out);
    out[0] *= gp_plane_factor(t);
}

static bool moffat_angular(const struct gp_recipe *r,
                           GP_UNUSED const struct gp_field *f,
                           struct gp_angular *out)
{
    const struct moffat m = moffat_of(r);
    double sum[3];
    gp_profile_integral(moffat_in_plane, &m, 1, 0.0, 90.0, sum);
    *out = (struct gp_angular) {
        .light = moffat_light,
        .v = {m.a, m.beta, m.factor / sum[0]},
    };
    return true;
}

static gp_status open_moffat(const struct gp_log *log,
                             const struct gp_recipe *r,
                             const struct gp_field *f, struct gp_shape *out)
{
    const struct moffat m = moffat_of(r);
    gp_status st = gp_radial_shape(log, moffat_profile, &m, 1, 4.0 * m.a, f,
                                   out);
    if (!st)
        out->smooth = 4.0 * m.a / (f->degrees * fmin(f->aspect, 1.0));
    return st;
}

const struct gp_model gp_model_moffat = {
    .name = "moffat",
    .text = "a blur with wings, as air and film make it",
    .source = "Moffat 1969, eq. 7",
    .keys = moffat_keys,
    .angular = moffat_angular,
    .open = open_moffat,
};

// -- halation -----------------------------------------------------------------

/* Halation of film: light that the emulsion scatters into the base, and that
 * the base's back reflects.
 *
 * The emulsion scatters as a Lambertian sheet does. Light at the angle w comes
 * back r = 2 d tan w away, d the base's thickness, with the irradiance of a
 * sheet at the distance 2 d,
 *
 *   E(r) = R(w) cos^4 w / (pi (2 d)^2)
 *
 * R is 1 over the critical angle, sin w = 1 / n, and (n - 1)^2 / (n + 1)^2
 * straight on: a disc of faint and a ring of full light, which ends with the
 * fourth power. Of the layers the red-sensitive one is the lowest. Those above
 * get what passes it, by Beer's law: g^(1 / cos w) of the share g that passes
 * straight up, so that red is wider than green, and green than blue.
 *
 * The layers are the frame's channels; the ring's edge is as soft as the
 * emulsion is thick. */
struct halation {
    double across; // 2 d, degrees
    double ring;   // r at the critical angle, in units of `across`
    double faint;  // R straight on
    double pass[3];
    double factor; // that makes the luminance 1
};

/* Scale on which the ring's edge rises, share of its radius: a quarter of the
 * emulsion's thickness, which in colour film is 0.02 to 0.03 mm, a fifth of the
 * base. */
#define SOFT 0.05

static void halation_profile(const void *ctx, double t, double out[3])
{
    const struct halation *const h = ctx;
    const double r = t / h->across;
    const double along = sqrt(1.0 + r * r); // 1 / cos w
    const double edge = 1.0 / (1.0 + gp_exp((1.0 - r / h->ring) / SOFT));
    const double back = h->faint + (1.0 - h->faint) * edge;
    const double sheet = h->across * (1.0 + r * r);
    const double light = h->factor * back / (M_PI * sheet * sheet);
    for (int c = 0; c < 3; c++)
        out[c] = light * gp_pow(h->pass[c], along);
}

/* The usual film has a base of cellulose triacetate, 5 mils thick, n = 1.48;
 * the usual lens shows 14 mm of it in GP_USUAL_FOV: 35 mm film in 16:9.
 * What the layers pass is chosen for halos of orange and red, as film without a
 * backing has. */
static const struct gp_model_key halation_keys[] = {
    GP_MODEL_SHARE(0.03),
    {"base", "thickness of the film's base, mm", 0.13, 0.01, 2.0, NULL},
    {"index", "refractive index of the base", 1.48, 1.3, 2.0, NULL},
    {"focal", "focal length of the lens, mm", 26.0, 1.0, 2000.0, NULL},
    {"green", "share of the light that reaches the layer for green", 0.36, 0.0,
     1.0, NULL},
    {"blue", "share of the light that reaches the layer for blue", 0.1, 0.0,
     1.0, NULL},
    {0},
};

static gp_status open_halation(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    const double n = gp_recipe_value(r, "index");
    struct halation h = {
        .across = 2.0 * gp_recipe_value(r, "base") /
                  gp_recipe_value(r, "focal") * 180.0 / M_PI,
        .ring = 1.0 / sqrt(n * n - 1.0),
        .faint = (n - 1.0) * (n - 1.0) / ((n + 1.0) * (n + 1.0)),
        .pass = {1.0, gp_recipe_value(r, "green"), gp_recipe_value(r, "blue")},
        .factor = 1.0,
    };
    double sum[3];
    // farther, where a fourth power ends, are 1e-6 of the light
    gp_profile_integral(halation_profile, &h, 3, 0.0, 1e3 * h.across, sum);
    h.factor = 1.0 / gp_luminance_of(f->luminance, sum);
    const double bends = 4.0 * h.across;
    gp_status st = gp_radial_shape(log, halation_profile, &h, 3, bends, f, out);
    if (!st)
        out->smooth = bends / (f->degrees * fmin(f->aspect, 1.0));
    return st;
}

const struct gp_model gp_model_halation = {
    .name = "halation", .text = "film's halation: light that its base reflects",
    .source = "total reflection at the base, Fresnel and Beer's law",
    .keys = halation_keys, .open = open_halation,
};

// -- discs and rings ----------------------------------------------------------

/* Curves of the distance by channel, for shapes with edges, in pixels or slices
 * of them on which a curve bends little. */
struct radial {
    double a, b;      // degrees of a slice
    int n;            // steps
    double step;      // degrees; the curve is 0 from n * step on
    bool grey;
    double *curve[3]; // n + 2 each, after it in one block
};

static void radial_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct radial *const r = state;
    const struct gp_gauss *const g = gp_tent_rule(4);
    const double a = r->a, b = r->b, end = r->n * r->step + a + b;
    const int channels = r->grey ? 1 : 3;
    for (int i = 0; i < n; i++) {
        double sum[3] = {0};
        const double u = a * abs(x + i), v0 = b * abs(y);
        for (int k = 0; k < g->n * g->n && gp_hypot(u, v0) < end; k++) {
            const int p = k % g->n, q = k / g->n;
            const double t = gp_hypot(u + a * g->node[p], v0 + b * g->node[q]);
            const double at = fmin(t / r->step, r->n);
            const int s = (int) at;
            for (int c = 0; c < channels; c++)
                sum[c] += g->weight[p] * g->weight[q] *
                          (r->curve[c][s] + (at - s) * (r->curve[c][s + 1] -
                                                        r->curve[c][s]));
        }
        for (int c = 0; c < channels; c++)
            out[c][i] = sum[c] * a * b;
    }
}

/* Fills the curves by `value`, which has any height, scaled to a plane's
 * integral of 1 each. */
static void fill_curves(struct radial *r, gp_profile value, const void *ctx)
{
    const size_t room = (size_t) r->n + 2;
    double sum[3] = {0};
    for (int i = 0; i < r->n; i++) {
        double v[3];
        value(ctx, i * r->step, v);
        for (int c = 0; c < 3; c++) {
            r->curve[c][i] = v[r->grey ? 0 : c];
            // lines between steps, turned about the centre
            const double before = i > 0 ? (i - 1) / 2.0 + 1.0 / 3.0 : 0.0;
            sum[c] += 2.0 * M_PI * r->step * r->step * r->curve[c][i] *
                      (before + i / 2.0 + 1.0 / 6.0);
        }
    }
    for (size_t i = 0; i < 3 * room; i++)
        r->curve[0][i] /= sum[i / room];
}

/* Makes a shape whose curves end at `end` degrees and bend on the scale of
 * `bend`. */
static gp_status make_radial(const struct gp_log *log, const struct gp_field *f,
    double end, double bend, bool grey, gp_profile value, const void *ctx,
    struct gp_shape *out)
{
    const double b = f->degrees, a = b * f->aspect;
    const int slices[2] = {(int) ceil(4.0 * a / bend),
                           (int) ceil(4.0 * b / bend)};
    const bool whole = slices[0] == 1 && slices[1] == 1;
    const double step = bend / 64.0;
    const size_t room = (size_t) ceil(end / step) + 2;
    struct radial *r;
    gp_status st = gp_alloc_zero(log, "kernel", 1,
                                 sizeof *r + 3 * room * sizeof(double), &r);
    if (st)
        return st;
    *r = (struct radial) {
        .a = a / slices[0],
        .b = b / slices[1],
        .n = (int) room - 2,
        .step = step,
        .grey = grey,
    };
    for (size_t c = 0; c < 3; c++)
        r->curve[c] = (double *) (r + 1) + c * room;
    fill_curves(r, value, ctx);
    const double rx = ceil(end / r->a) + 1.0, ry = ceil(end / r->b) + 1.0;
    const double reach = fmax(rx, ry);
    *out = (struct gp_shape) {
        .state = r,
        .free = gp_free,
        .grey = grey,
        .row = radial_row,
        .even = true,
        .smooth = INFINITY,
        .reach = reach < 1e6 ? (int) reach : INT_MAX,
    };
    return whole ? GP_OK
                 : gp_slices_join(log, slices,
                                  (int) fmin(rx, (double) f->w * slices[0]),
                                  (int) fmin(ry, (double) f->h * slices[1]), f,
                                  out);
}

/* A point out of focus: an even disc, a rim on it that a lens which corrects
 * too much has, and an edge of width `soft` that falls by a smoothstep. */
struct disc {
    double radius, soft, rim;
};

static void disc_value(const void *ctx, double t, double out[3])
{
    const struct disc *const d = ctx;
    const double radii = fmin(t / d->radius, 1.0), q = radii * radii;
    out[0] = gp_smoothstep((d->radius - t) / d->soft + 0.5) *
             (1.0 + d->rim * q * q * q * q);
}

/* A lamp keeps its light in a picture: 0.4 % of that of 3 pixels is a faint disc
 * around them, where 4 % painted a ball over them. Chosen on the night frame and
 * the street of examples/. */
static const struct gp_model_key circle_keys[] = {
    GP_MODEL_SHARE(0.004),
    {"size", "diameter, degrees", 2.0, 0.01, 90.0, NULL},
    {"soft", "width of its edge, share of the radius", 0.6, 0.01, 1.0, NULL},
    {"rim", "how much brighter its rim is", 0.3, 0.0, 10.0, NULL},
    {0},
};

static gp_status open_circle(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct disc d = {.radius = 0.5 * gp_recipe_value(r, "size"),
                     .rim = gp_recipe_value(r, "rim")};
    d.soft = d.radius * gp_recipe_value(r, "soft");
    return make_radial(log, f, d.radius + 0.5 * d.soft, d.soft, true,
                       disc_value, &d, out);
}

const struct gp_model gp_model_circle = {
    .name = "circle", .text = "a faint disc around a lamp, as out of focus",
    .source = "geometric optics", .keys = circle_keys, .open = open_circle,
};

/* The corona of small drops, fogged glass, or lashes' moisture: drops diffract
 * like holes of their size (Babinet), so by Airy's pattern,
 *
 *   v_c(t) = sum over wavelengths l, drops d of w_c(l) d^4 / l^2 (J1(x) / x)^2
 *   x      = pi d sin t / l
 *
 * folded into the primaries where a channel of the sum is under 0: an aureole
 * and rings, blue inside and red outside. `radius` is the first
 * ring's at 550 nm, x = 5.1356; drops are `spread` apart, and all
 * fades by (1 - (t / end)^2)^6, an end that no brightness shows, with five radii
 * to it, 90 degrees at most. */
enum { BANDS = 24, DROPS = 5 };
struct halo {
    double size, spread, end; // of a drop: x is size sin t at 550 nm
    double nm[BANDS], rgb[BANDS][3];
    const float *luminance;   // of the primaries; borrowed
};

/* 2 J1(x) / x within 1e-11: Abramowitz and Stegun 9.1.10, and 9.2.5 from 12
 * on. */
static double airy(double x)
{
    double term = 1.0, sum = 1.0, part[2] = {1.0, 0.0};
    for (int k = 1; k < 32 && x < 12.0; k++) {
        term *= -0.25 * x * x * (1.0 / (k * (k + 1.0)));
        sum += term;
    }
    if (x < 12.0)
        return sum;
    for (int k = 1; k < 20; k++) {
        term *= (4.0 - (2.0 * k - 1.0) * (2.0 * k - 1.0)) / (8.0 * k * x);
        part[k % 2] += k % 4 < 2 ? term : -term;
    }
    const double c = gp_cos(x), s = gp_sin(x);
    return 2.0 / (x * sqrt(M_PI * x)) * (part[0] * (s - c) + part[1] * (s + c));
}

/* The light of each wavelength t degrees away. */
static void halo_bands(const struct halo *h, double t, double out[BANDS])
{
    const double place = t / h->end, q = fmax(1.0 - place * place, 0.0);
    const double left = q * q * q * q * q * q, sine = gp_sin(t * M_PI / 180.0);
    for (int i = 0; i < BANDS; i++) {
        out[i] = 0.0;
        for (int k = 0; k < DROPS; k++) {
            const double at = 2.0 * k / (DROPS - 1) - 1.0;
            const double size =
                h->size * (1.0 + h->spread * at) * 550.0 / h->nm[i];
            const double v = size * airy(size * sine);
            out[i] += left * (1.0 - 0.75 * at * at) * v * v;
        }
    }
}

static void halo_value(const void *ctx, double t, double out[3])
{
    const struct halo *const h = ctx;
    double v[BANDS];
    halo_bands(h, t, v);
    out[0] = out[1] = out[2] = 0.0;
    for (int i = 0; i < 3 * BANDS; i++)
        out[i % 3] += h->rgb[i / 3][i % 3] * v[i / 3];
    gp_gamut_fold(h->luminance, out);
}

/* Scales each wavelength to the same light, of which the longest lose the most
 * where all fade: then their sum is white in all primaries. */
static void even_bands(struct halo *h)
{
    enum { STEPS = 2000 };
    double light[BANDS] = {0}, v[BANDS];
    for (int k = 0; k < STEPS; k++) {
        halo_bands(h, h->end * k / STEPS, v);
        for (int i = 0; i < BANDS; i++)
            light[i] += (double) k / STEPS * v[i];
    }
    for (int i = 0; i < 3 * BANDS; i++)
        h->rgb[i / 3][i % 3] /= light[i / 3];
}

static const struct gp_model_key ring_keys[] = {
    GP_MODEL_SHARE(0.04),
    {"radius", "of the first bright ring at 550 nm, degrees", 2.4, 0.02, 29.0,
     NULL},
    {"spread", "of the drops' sizes to each side, share", 0.18, 0.0, 0.9, NULL},
    {0},
};

static gp_status open_ring(const struct gp_log *log, const struct gp_recipe *r,
                           const struct gp_field *f, struct gp_shape *out)
{
    const double first = 5.1356;
    const double radius = gp_recipe_value(r, "radius");
    struct halo h = {
        .size = first / gp_sin(radius * M_PI / 180.0),
        .end = fmin(5.0 * radius, 90.0),
        .spread = gp_recipe_value(r, "spread"),
        .luminance = f->luminance,
    };
    gp_spectrum_colours(f->chromaticities, BANDS, h.nm, h.rgb);
    even_bands(&h);
    return make_radial(log, f, h.end, radius / first, false, halo_value, &h,
                       out);
}

const struct gp_model gp_model_ring = {
    .name = "ring", .text = "a corona: an aureole and rings of small drops",
    .source = "Airy's pattern by Babinet's principle", .keys = ring_keys,
    .open = open_ring,
};

// -- images -------------------------------------------------------------------

static gp_status open_image(const struct gp_log *log, const struct gp_recipe *r,
                            const struct gp_field *f, struct gp_shape *out)
{
    const double size = gp_recipe_value(r, "size");
    const double x = gp_recipe_value(r, "x"), y = gp_recipe_value(r, "y");
    const struct gp_rect window = r->image->data;
    const int middle[2] = {gp_rect_w(window) / 2, gp_rect_h(window) / 2};
    struct gp_kernel k = {0};
    const struct gp_kernel_params p = {
        .centered = true,
        .center = {window.x0 + (x < 0.0 ? middle[0] : x) + 0.5,
                   window.y0 + (y < 0.0 ? middle[1] : y) + 0.5},
        .rotate = (float) f->rotate,
        .normalize = r->as_it_is ? GP_NORMALIZE_NONE : GP_NORMALIZE_LUMINANCE,
        .aspect = f->aspect, .chromaticities = f->chromaticities,
        .scale = size > 0.0 ? size / (f->degrees * gp_rect_h(window))
                            : gp_recipe_value(r, "percent") / 100.0,
    };
    gp_status st = gp_kernel_from_frame(log, &p, r->image, &k);
    if (!st)
        st = gp_samples_shape(log, k.w, k.h, k.cx, k.cy, k.grey ? 1 : 3, &k.k,
                              out);
    if (!st)
        out->negative = k.negative;
    k.k = (struct gp_planes) {0}; // they are the shape's
    gp_kernel_free(&k);
    return st;
}

static const struct gp_model_key image_keys[] = {
    GP_MODEL_SHARE(1.0),
    {"file", "the image; needed", 1, 0, 0, gp_model_file},
    {"size", "its height in degrees of view; 0: by percent", 0, 0, 180, NULL},
    {"percent", "frame pixels for 100 of its own", 100, 0.1, 10000, NULL},
    {"x", "column of its centre's pixel, from 0; -1: the middle", -1, -1, 1e6,
     NULL},
    {"y", "row of its centre's pixel, from 0; -1: the middle", -1, -1, 1e6,
     NULL},
    {0},
};

const struct gp_model gp_model_image = {
    .name = "image", .text = "an image of a point of light",
    .source = "measured or painted; resampled by areas",
    .keys = image_keys, .open = open_image,
};
