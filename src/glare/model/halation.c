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
#include "glare/model/model_priv.h"

#include <math.h>

struct halation {
    double across; // 2 d, degrees
    double ring;   // r at the critical angle, in units of `across`
    double faint;  // R straight on
    double pass[3];
    double factor; // that makes the luminance 1
};

/* Scale on which the ring's edge rises, share of its radius: half of the
 * emulsion's thickness, which in colour film is 0.02 to 0.03 mm, a fifth of the
 * base. */
#define SOFT 0.1

static void halation_profile(const void *ctx, double t, double out[3])
{
    const struct halation *const h = ctx;
    const double r = t / h->across;
    const double along = sqrt(1.0 + r * r); // 1 / cos w
    const double edge = 0.5 + 0.5 * tanh((r / h->ring - 1.0) / SOFT);
    const double back = h->faint + (1.0 - h->faint) * edge;
    const double light = h->factor * back /
                         (M_PI * h->across * h->across * pow(along, 4.0));
    for (int c = 0; c < 3; c++)
        out[c] = light * pow(h->pass[c], along);
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
    double sum[3], all = 0.0;
    // farther, where a fourth power ends, are 1e-6 of the light
    gp_profile_integral(halation_profile, &h, 3, 0.0, 1e3 * h.across, sum);
    for (int c = 0; c < 3; c++)
        all += (double) f->luminance[c] * sum[c];
    h.factor = 1.0 / all;
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
