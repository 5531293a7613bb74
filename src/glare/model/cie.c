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
 * The total is divided by its integral over the hemisphere; the general one
 * is the scattered light only, and the rest of 1 stays in its pixel. */
struct cie {
    double age, pigment, factor;
    bool general;
};

double gp_cie_general(double age, double p, double t)
{
    const double a = age / 62.5, more = 1.0 + a * a * a * a;
    return 10.0 / (t * t * t) + (5.0 / (t * t) + 0.1 * p / t) * more +
           0.0025 * p;
}

static double cie_total(double age, double p, double t)
{
    const double a = age / 70.0, a4 = a * a * a * a;
    const double x = 1.0 + t * t / (0.0046 * 0.0046);
    const double y = 1.0 + t * t / (0.045 * 0.045);
    const double z = 1.0 + t * t / (0.1 * 0.1), root = sqrt(z);
    return (1.0 - 0.08 * a4) * (9.2e6 / (x * sqrt(x)) + 1.5e5 / (y * sqrt(y))) +
           (1.0 + 1.6 * a4) * (400.0 / z + 3e-8 * t * t +
                               p * (1300.0 / (z * root) + 0.8 / root)) +
           2.5e-3 * p;
}

static const double CIE_NEAREST = 0.1; // degrees

static double cie_sky(const struct cie *e, double t)
{
    return e->factor * (e->general ? gp_cie_general(e->age, e->pigment,
                                                    fmax(t, CIE_NEAREST))
                                   : cie_total(e->age, e->pigment, t));
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

/* *light: the integral that the factor is to make 1. */
static struct cie cie_of(const struct gp_recipe *r, double *light)
{
    struct cie e = {
        .age = gp_recipe_value(r, "age"),
        .factor = 1.0,
        .pigment = gp_recipe_value(r, "pigment"),
        .general = (int) gp_recipe_value(r, "equation") == GENERAL,
    };
    double sum[3];
    gp_profile_integral(cie_profile, &e, 1, 0.0, 90.0, sum);
    if (!e.general)
        e.factor = 1.0 / sum[0];
    *light = sum[0];
    return e;
}

static double cie_light(const struct gp_angular *a, double t)
{
    return cie_sky(&(struct cie) {a->v[0], a->v[1], a->v[2], a->v[3] > 0.0}, t);
}

static bool cie_angular(const struct gp_recipe *r, const struct gp_field *f,
                        struct gp_angular *out)
{
    double sum;
    const struct cie e = cie_of(r, &sum);
    (void) f;
    *out = (struct gp_angular) {
        .light = cie_light,
        .v = {e.age, e.pigment, e.factor, e.general},
        .stays = e.general ? 1.0 - sum : 0.0,
        .bends = e.general ? CIE_NEAREST : 0.0,
    };
    return true;
}

static gp_status open_cie(const struct gp_log *log, const struct gp_recipe *r,
                          const struct gp_field *f, struct gp_shape *out)
{
    double sum;
    const struct cie e = cie_of(r, &sum);
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
