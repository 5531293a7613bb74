/* Models of the eye: Spencer et al. 1995, and the CIE's of 1999 and 2002. */
#include "core/memory.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

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
    {"needles", "rays into which the ciliary corona breaks up; 0: none, it is "
     "even", 0.0, 0.0, 1000.0, NULL, false},
    {"seed", "which needles", 1.0, 0.0, 1e9, NULL, false},
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

/* The ciliary corona, f1 and f2, as needles: section 3.1 has it made of rays of
 * random strength, which the cells of the lens scatter. A pixel's corona at
 * distance t and angle phi is multiplied by
 *
 *   1 + a(t) (mean of m(phi) over what the pixels cover - 1)
 *
 * where m has mean 1 over the circle, so that each circle keeps its light, and
 * a falls from 1 to 0 between half of NEEDLE_END and that, where needles would
 * be wide. Light that sums over pixels miss goes to the light's own pixel. */
enum { CIRCLE = 1 << 14 }; // steps of m
static const double NEEDLE_END = 5.0, CONTRAST = 0.8;

struct needles {
    struct gp_shape eye;
    int rx, ry;        // offsets that `add` has
    float *add;        // what needles add to the even corona; owned
    bool grey;
};

/* The sums of m up to each step, of mean 1. */
static void make_circle(const struct gp_recipe *r, double sum[CIRCLE + 1])
{
    const int n = (int) gp_recipe_value(r, "needles");
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    double total = 0.0;
    memset(sum, 0, (CIRCLE + 1) * sizeof *sum);
    for (int i = 0; i < n; i++) {
        const uint64_t key = 3 * (uint64_t) i;
        const double at = CIRCLE * gp_model_random(seed, key);
        // a few are strong, as of an exponential distribution
        const double strength = -log(1.0 - gp_model_random(seed, key + 1));
        const double width = CIRCLE * (0.3 + gp_model_random(seed, key + 2)) *
                             0.35 / fmax(n, 32.0);
        const int reach = (int) ceil(4.0 * width);
        for (int k = -reach; k <= reach; k++) {
            const double z = (floor(at) + k + 0.5 - at) / width;
            const double v = strength * exp(-0.5 * z * z) / width;
            const int step = (((int) at + k) % CIRCLE + CIRCLE) % CIRCLE;
            sum[step + 1] += v;
            total += v;
        }
    }
    for (int i = 0; i < CIRCLE; i++)
        sum[i + 1] = sum[i] + (1.0 - CONTRAST) / CIRCLE +
                     CONTRAST * sum[i + 1] / total;
}

/* The sum up to a place, in turns, of any number of turns. */
static double circle_sum(const double sum[CIRCLE + 1], double turns)
{
    const double whole = floor(turns), at = (turns - whole) * CIRCLE;
    const int i = (int) fmin(at, CIRCLE - 1);
    return whole + sum[i] + (at - i) * (sum[i + 1] - sum[i]);
}

static void needles_row(const void *state, int x, int y, int n,
                        double *const out[3])
{
    const struct needles *const s = state;
    s->eye.row(s->eye.state, x, y, n, out);
    if (abs(y) > s->ry)
        return;
    const float *const row =
        s->add + (size_t) (y + s->ry) * (2 * (size_t) s->rx + 1);
    for (int i = 0; i < n; i++) {
        for (int c = 0; c < (s->grey ? 1 : 3) && abs(x + i) <= s->rx; c++)
            out[c][i] = fmax(out[c][i] + (double) row[x + i + s->rx], 0.0);
    }
}

static void free_needles(void *state)
{
    struct needles *const s = state;
    s->eye.free(s->eye.state);
    gp_free(s->add);
    gp_free(s);
}

/* Makes needles of the corona of *shape. */
static gp_status add_needles(const struct gp_log *log,
    const struct gp_recipe *r, const struct spencer *eye,
    const struct gp_field *f, struct gp_shape *shape)
{
    gp_status st;
    struct spencer even = *eye;
    struct gp_shape corona = {0};
    double *circle = NULL, rest = 0.0;
    struct needles *s = NULL;
    const double b = f->degrees, a = b * f->aspect;
    even.weight[0] = even.weight[3] = 0.0;
    even.channels = 1;
    GP_TRY(gp_alloc_zero(log, "kernel", 1, sizeof *s, &s));
    s->rx = (int) fmin(ceil(NEEDLE_END / a), f->w - 1);
    s->ry = (int) fmin(ceil(NEEDLE_END / b), f->h - 1);
    const int w = 2 * s->rx + 1, h = 2 * s->ry + 1;
    GP_TRY(gp_alloc_zero(log, "kernel", (size_t) w * (size_t) h,
                         sizeof *s->add, &s->add));
    GP_TRY(gp_alloc(log, "kernel", CIRCLE + 1, sizeof *circle, &circle));
    GP_TRY(gp_radial_shape(log, spencer_profile, &even, 1, 0.0, f, &corona));
    make_circle(r, circle);
    for (int y = -s->ry; y <= s->ry; y++) {
        float *const row = s->add + (size_t) (y + s->ry) * (size_t) w + s->rx;
        for (int from = -s->rx; from <= s->rx; from += GP_SHAPE_STRIP) {
            const int n = s->rx + 1 - from < GP_SHAPE_STRIP ? s->rx + 1 - from
                                                           : GP_SHAPE_STRIP;
            double strip[GP_SHAPE_STRIP] = {0};
            double *const out[3] = {strip, NULL, NULL};
            corona.row(corona.state, from, y, n, out);
            for (int i = 0; i < n; i++) {
                const double u = a * (from + i), v = b * y, t = hypot(u, v);
                const double end = fmin(2.0 * (1.0 - t / NEEDLE_END), 1.0);
                if (!(t > 0.0) || end <= 0.0)
                    continue;
                // both pixels' widths across the ray, as a box about it
                const double half = sqrt(0.5) * hypot(a * v, b * u) / t / t;
                const double at = atan2(-v, u) / (2.0 * PI) - f->rotate / 360.0;
                const double turns = fmin(half / (2.0 * PI), 0.5);
                const double mean = (circle_sum(circle, at + turns) -
                                     circle_sum(circle, at - turns)) /
                                    (2.0 * turns);
                const double fade = end * end * (3.0 - 2.0 * end);
                row[from + i] = (float) (strip[i] * fade * (mean - 1.0));
                rest += (double) row[from + i];
            }
        }
    }
    s->add[(size_t) s->ry * (size_t) w + (size_t) s->rx] = (float) -rest;
    s->eye = *shape;
    s->grey = shape->grey;
    shape->state = s;
    shape->row = needles_row;
    shape->free = free_needles;
    shape->even = false;
    shape->smooth = (NEEDLE_END + 0.2) / fmin(a, b);
    s = NULL;
out:
    if (corona.free)
        corona.free(corona.state);
    gp_free(circle);
    if (s)
        gp_free(s->add);
    gp_free(s);
    return st;
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
    if (st || gp_recipe_value(r, "needles") < 1.0)
        return st;
    st = add_needles(log, r, &s, f, out);
    if (st)
        out->free(out->state);
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
