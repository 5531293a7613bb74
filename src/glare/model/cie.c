// SPDX-License-Identifier: Apache-2.0
/* The eye by the CIE's equations of 1999 and 2002. */
#include "core/maths.h"
#include "glare/model/model_priv.h"

#include <math.h>

/* The glare equations of the International Commission on Illumination, per
 * steradian, t in degrees, A years of age, p the eye's pigment (0 black, 0.5
 * brown, 1 light, 1.2 very light blue).
 *
 * `total`, CIE 135/1 (Vos and van den Berg 1999), 0 to 100 degrees, with the
 * fovea's peak:
 *   (1 - 0.08 (A/70)^4) (9.2e6 / (1 + (t/0.0046)^2)^1.5 +
 *                        1.5e5 / (1 + (t/0.045)^2)^1.5)
 *   + (1 + 1.6 (A/70)^4) ((400 / (1 + (t/0.1)^2) + 3e-8 t^2) +
 *        p (1300 / (1 + (t/0.1)^2)^1.5 + 0.8 / (1 + (t/0.1)^2)^0.5))
 *   + 2.5e-3 p
 *
 * `general`, CIE 146 (2002), 0.1 to 100 degrees; nearer than that it is kept
 * even, so that no edge shows:
 *   10 / t^3 + (5 / t^2 + 0.1 p / t) (1 + (A/62.5)^4) + 0.0025 p
 *
 * Both are absolute. The general one is the scattered light only, and the rest of 1
 * stays in its pixel. The total adds up to 1.03 at 35 years, 1.2 at 85 with light eyes:
 * what is over 1 comes out of its peaks A / (1 + (t/a)^2)^1.5, of the narrow one first. A
 * peak of width a / (1 - e) and height A (1 - e)^3 has a share e less of light, and the
 * same A a^3 / t^3 farther out. */
struct cie {
    double age, pigment;
    double less[2]; // e of both peaks
    bool general;
};

double gp_cie_general(double age, double p, double t)
{
    const double a = age / 62.5, more = 1.0 + a * a * a * a;
    return 10.0 / (t * t * t) + (5.0 / (t * t) + 0.1 * p / t) * more +
           0.0025 * p;
}

static const double width[2] = {0.0046, 0.045}; // of both peaks, degrees

/* Peak i of the total. */
static double cie_peak(const struct cie *e, int i, double t)
{
    static const double height[2] = {9.2e6, 1.5e5};
    const double a = e->age / 70.0, left = 1.0 - e->less[i];
    const double u = t * left / width[i], x = 1.0 + u * u;
    return (1.0 - 0.08 * a * a * a * a) * height[i] * left * left * left /
           (x * sqrt(x));
}

static double cie_total(const struct cie *e, double t)
{
    const double a = e->age / 70.0, p = e->pigment;
    const double z = 1.0 + t * t / (0.1 * 0.1), root = sqrt(z);
    return cie_peak(e, 0, t) + cie_peak(e, 1, t) +
           (1.0 + 1.6 * a * a * a * a) *
               (400.0 / z + 3e-8 * t * t +
                p * (1300.0 / (z * root) + 0.8 / root)) +
           2.5e-3 * p;
}

static const double CIE_NEAREST = 0.1; // degrees

static double cie_sky(const struct cie *e, double t)
{
    return e->general ? gp_cie_general(e->age, e->pigment, fmax(t, CIE_NEAREST))
                      : cie_total(e, t);
}

static void cie_profile(const void *ctx, double t, double out[3])
{
    out[0] = gp_plane_factor(t) * cie_sky(ctx, t);
}

enum { TOTAL, GENERAL };
static const char *const equations[] = {"total", "general", NULL};

static const struct gp_model_key cie_keys[] = {
    GP_MODEL_SHARE(1.0),
    {"equation",
     "total: CIE 135/1 with the fovea's peak; general: CIE 146, "
     "even within 0.1 degree",
     TOTAL, TOTAL, GENERAL, equations},
    {"age", "years", 35.0, 1.0, 100.0, NULL},
    {"pigment", "0 black, 0.5 brown, 1 light, 1.2 light blue eyes", 0.5, 0.0,
     1.2, NULL},
    {0},
};

/* *light: its integral; over all of the sphere, as true angles have it, or before
 * the eye. */
static struct cie cie_of(const struct gp_recipe *r, bool sphere, double *light)
{
    static const double MOST = 0.9; // of a peak's light
    struct cie e = {
        .age = gp_recipe_value(r, "age"),
        .pigment = gp_recipe_value(r, "pigment"),
        .general = (int) gp_recipe_value(r, "equation") == GENERAL,
    };
    double sum[3];
    gp_profile_integral(cie_profile, &e, 1, 0.0, 90.0, sum);
    for (double t = 90.5; sphere && t < 180.0; t += 1.0)
        sum[0] += cie_sky(&e, fmin(t, 100.0)) * 2.0 * M_PI *
                  gp_sin(t * M_PI / 180.0) * (M_PI / 180.0);
    for (int i = 0; i < 2 && !e.general; i++) {
        // (a narrower peak ends as it did, so that its light is a plane's)
        const double a = width[i] * (M_PI / 180.0);
        const double peak = 2.0 * M_PI * a * a * cie_peak(&e, i, 0.0);
        e.less[i] = fmin((sum[0] - 1.0) / peak, MOST);
        sum[0] -= e.less[i] * peak;
    }
    *light = sum[0];
    return e;
}

static double cie_light(const struct gp_angular *a, GP_UNUSED int c, double t)
{
    const struct cie e = {a->v[0], a->v[1], {a->v[2], a->v[3]}, a->v[4] > 0.0};
    return cie_sky(&e, t);
}

static bool cie_angular(const struct gp_recipe *r,
                        GP_UNUSED const struct gp_field *f,
                        struct gp_angular *out)
{
    double sum;
    const struct cie e = cie_of(r, true, &sum);
    *out = (struct gp_angular) {
        .light = cie_light,
        .v = {e.age, e.pigment, e.less[0], e.less[1], e.general},
        .stays = e.general ? 1.0 - sum : 0.0,
        .bends = e.general ? CIE_NEAREST : 0.0,
    };
    return true;
}

static gp_status open_cie(const struct gp_log *log, const struct gp_recipe *r,
                          const struct gp_field *f, struct gp_shape *out)
{
    double sum;
    const struct cie e = cie_of(r, false, &sum);
    gp_status st = gp_sky_shape(log, cie_profile, &e, 1, 0.2, f, out);
    if (st)
        return st;
    out->smooth = 0.2 / (f->degrees * fmin(f->aspect, 1.0));
    if (e.general)
        out->own[0] = 1.0 - sum;
    return GP_OK;
}

const struct gp_model gp_model_cie = {
    .name = "cie",
    .text = "the eye by age and pigment, as the CIE has it",
    .source = "CIE 135/1 (1999) and CIE 146 (2002)",
    .keys = cie_keys,
    .angular = cie_angular,
    .open = open_cie,
};
