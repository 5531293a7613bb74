/* Models of the eye: Spencer et al. 1995, and the CIE's of 1999 and 2002. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>

#define PI 3.14159265358979323846

// -- Spencer ------------------------------------------------------------------

/* Spencer, Shirley, Zimmerman, Greenberg: Physically-Based Glare Effects for
 * Digital Images, SIGGRAPH 95, eqs. 5 to 8, per steradian, t in degrees:
 *
 *   f0 = 2.61e6 exp(-(t / 0.02)^2)                    unscattered light
 *   f1 = 20.91 / (t + 0.02)^3                         ciliary corona
 *   f2 = 72.37 / (t + 0.02)^2                         ciliary corona, far out
 *   f3 = 436.9 (568 / l) exp(-19.75 (t - 3 l / 568)^2) lenticular halo, l in nm
 *
 *   photopic  0.384 f0 + 0.478 f1 + 0.138 f2
 *   mesopic   0.368 f0 + 0.478 f1 + 0.138 f2 + 0.016 f3
 *   scotopic  0.282 f0 + 0.478 f1 + 0.207 f2 + 0.033 f3
 *
 * Between them weights change evenly with the pupil's diameter, which the
 * paper gives as 3 mm by day and 7 by night; mesopic in the middle. Each f is 1
 * over the hemisphere to the digits of its constants; the sum is divided by
 * what the hemisphere holds. */
enum { BANDS = 20 };
struct spencer {
    double weight[4];
    int channels;
    double factor;
    double nm[BANDS], rgb[BANDS][3];
};

double gp_spencer_term(int i, double t, double nm)
{
    const double a = t + 0.02, z = t / 0.02, off = t - 3.0 * nm / 568.0;
    return i == 0   ? 2.61e6 * exp(-z * z)
           : i == 1 ? 20.91 / (a * a * a)
           : i == 2 ? 72.37 / (a * a)
                    : 436.9 * 568.0 / nm * exp(-19.75 * off * off);
}

static void spencer_profile(const void *ctx, double t, double out[3])
{
    const struct spencer *const s = ctx;
    const double plane = s->factor * gp_plane_factor(t);
    double grey = 0.0;
    for (int i = 0; i < 3; i++)
        grey += s->weight[i] * gp_spencer_term(i, t, 0.0);
    for (int c = 0; c < s->channels; c++)
        out[c] = plane * grey;
    for (int i = 0; i < BANDS && s->channels == 3; i++) {
        const double halo =
            s->weight[3] * plane * gp_spencer_term(3, t, s->nm[i]);
        for (int c = 0; c < 3; c++)
            out[c] += s->rgb[i][c] * halo;
    }
}

enum { PHOTOPIC, MESOPIC, SCOTOPIC };
static const char *const lights[] = {"photopic", "mesopic", "scotopic", NULL};
static const double spencer_weights[3][4] = {
    {0.384, 0.478, 0.138, 0.0},
    {0.368, 0.478, 0.138, 0.016},
    {0.282, 0.478, 0.207, 0.033},
};

static const struct gp_model_key spencer_keys[] = {
    GP_MODEL_SHARE(1.0),
    {"light", "by day, at dusk or by night", PHOTOPIC, PHOTOPIC, SCOTOPIC,
     lights, false},
    {"pupil", "diameter in mm, 3 by day to 7 by night, in place of light; 0: "
     "by light", 0.0, 0.0, 9.0, NULL, false},
    {0},
};

static gp_status spencer_of(const struct gp_log *log, const struct gp_recipe *r,
                            const struct gp_field *f, struct spencer *out)
{
    const double pupil = gp_recipe_value(r, "pupil");
    // 3 mm is photopic, 5 mesopic, 7 scotopic
    const double at = pupil > 0.0 ? fmin(fmax((pupil - 3.0) / 2.0, 0.0), 2.0)
                                  : gp_recipe_value(r, "light");
    const int i = at < 1.0 ? 0 : 1;
    struct spencer s = {.factor = 1.0};
    for (int k = 0; k < 4; k++)
        s.weight[k] = spencer_weights[i][k] +
                      (at - i) * (spencer_weights[i + 1][k] -
                                  spencer_weights[i][k]);
    s.channels = s.weight[3] > 0.0 ? 3 : 1;
    gp_spectrum_weights(f, BANDS, s.nm, s.rgb);
    double sum[3], y = 0.0;
    gp_profile_integral(spencer_profile, &s, s.channels, 0.0, 90.0, sum);
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * sum[s.channels == 3 ? c : 0];
    if (!(y > 0.0))
        return gp_fail(log, GP_ERR_USAGE, "spencer: no luminance in the "
                       "frame's primaries; repair its chromaticities");
    s.factor = 1.0 / y;
    *out = s;
    return GP_OK;
}

static gp_status open_spencer(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct spencer s;
    gp_status st = spencer_of(log, r, f, &s);
    if (!st)
        st = gp_radial_shape(log, spencer_profile, &s, s.channels,
                             s.channels == 3 ? 5.2 : 0.0, f, out);
    // the halo of 780 nm ends at 5 degrees
    if (!st)
        out->smooth = (s.channels == 3 ? 5.2 : 0.1) /
                      (f->degrees * fmin(f->aspect, 1.0));
    return st;
}

const struct gp_model gp_model_spencer = {
    .name = "spencer", .text = "the eye by day, at dusk or by night",
    .source = "Spencer et al. 1995, eqs. 5 to 8", .keys = spencer_keys,
    .open = open_spencer,
};

// -- CIE ----------------------------------------------------------------------

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
 * The total is divided by its integral over the hemisphere; the general one is
 * what scatters, and the rest of 1 stays in its pixel. */
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
           (1.0 + 1.6 * a4) *
               (400.0 / z + 3e-8 * t * t +
                p * (1300.0 / (z * root) + 0.8 / root)) +
           2.5e-3 * p;
}

static void cie_profile(const void *ctx, double t, double out[3])
{
    const struct cie *const e = ctx;
    out[0] = e->factor * gp_plane_factor(t) *
             (e->general ? gp_cie_general(e->age, e->pigment, fmax(t, 0.1))
                         : cie_total(e->age, e->pigment, t));
}

enum { TOTAL, GENERAL };
static const char *const equations[] = {"total", "general", NULL};

static const struct gp_model_key cie_keys[] = {
    GP_MODEL_SHARE(1.0),
    {"equation", "total: CIE 135/1 with the fovea's peak; general: CIE 146, "
     "even within 0.1 degree", TOTAL, TOTAL, GENERAL, equations, false},
    {"age", "years", 35.0, 1.0, 100.0, NULL, false},
    {"pigment", "0 black, 0.5 brown, 1 light, 1.2 light blue eyes", 0.5, 0.0,
     1.2, NULL, false},
    {0},
};

static struct cie cie_of(const struct gp_recipe *r)
{
    struct cie e = {
        .age = gp_recipe_value(r, "age"), .factor = 1.0,
        .pigment = gp_recipe_value(r, "pigment"),
        .general = (int) gp_recipe_value(r, "equation") == GENERAL,
    };
    double sum[3];
    gp_profile_integral(cie_profile, &e, 1, 0.0, 90.0, sum);
    if (!e.general)
        e.factor = 1.0 / sum[0];
    return e;
}

/* The general equation, and the light that it does not scatter. */
struct cie_rest {
    struct gp_shape scattered;
    double stays;
};

static void general_row(const void *state, int x, int y, int n,
                        double *const out[3])
{
    const struct cie_rest *const s = state;
    s->scattered.row(s->scattered.state, x, y, n, out);
    if (y == 0 && x <= 0 && x + n > 0)
        out[0][-x] += s->stays;
}

static void free_general(void *state)
{
    struct cie_rest *const s = state;
    s->scattered.free(s->scattered.state);
    gp_free(s);
}

static gp_status open_cie(const struct gp_log *log, const struct gp_recipe *r,
                          const struct gp_field *f, struct gp_shape *out)
{
    const struct cie e = cie_of(r);
    struct cie_rest *s;
    gp_status st = gp_radial_shape(log, cie_profile, &e, 1, 0.2, f, out);
    if (!st)
        out->smooth = 0.2 / (f->degrees * fmin(f->aspect, 1.0));
    if (st || !e.general)
        return st;
    st = gp_alloc(log, "kernel", 1, sizeof *s, &s);
    if (st) {
        out->free(out->state);
        return st;
    }
    double sum[3];
    gp_profile_integral(cie_profile, &e, 1, 0.0, 90.0, sum);
    *s = (struct cie_rest) {*out, 1.0 - sum[0]};
    out->state = s;
    out->row = general_row;
    out->free = free_general;
    return GP_OK;
}

const struct gp_model gp_model_cie = {
    .name = "cie", .text = "the eye by age and pigment, as the CIE has it",
    .source = "CIE 135/1 (1999) and CIE 146 (2002)", .keys = cie_keys,
    .open = open_cie,
};

double gp_eye_beyond(const struct gp_recipe *r, const struct gp_field *f,
                     double t)
{
    double sum[3] = {0}, y = 0.0;
    if (r->model == &gp_model_cie) {
        const struct cie e = cie_of(r);
        gp_profile_integral(cie_profile, &e, 1, t, 90.0, sum);
        return sum[0];
    }
    struct spencer s;
    if (spencer_of(NULL, r, f, &s))
        return NAN;
    gp_profile_integral(spencer_profile, &s, s.channels, t, 90.0, sum);
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * sum[s.channels == 3 ? c : 0];
    return y;
}
