// SPDX-License-Identifier: Apache-2.0
/* The eye of Spencer et al. 1995. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>

// -- Spencer ------------------------------------------------------------------

/* Spencer, Shirley, Zimmerman, Greenberg: Physically-Based Glare Effects for
 * Digital Images, SIGGRAPH 95, eqs. 5 to 8, per steradian, t in degrees:
 *
 *   f0 = 2.61e6 exp(-(t / 0.02)^2)                    unscattered light
 *   f1 = 20.91 / (t + 0.02)^3                         ciliary corona
 *   f2 = 72.37 / (t + 0.02)^2                         ciliary corona, far out
 *   f3 = (180 / pi)^2 / (2 pi r sqrt(2 pi) w) exp(-((t - r) / w)^2 / 2)
 *        r = 3 l / 568, l in nm                       lenticular halo
 *
 *   photopic  0.384 f0 + 0.478 f1 + 0.138 f2
 *   mesopic   0.368 f0 + 0.478 f1 + 0.138 f2 + 0.016 f3
 *   scotopic  0.282 f0 + 0.478 f1 + 0.207 f2 + 0.033 f3
 *
 * Between them weights change evenly with the pupil's diameter, which the
 * paper gives as 3 mm by day and 7 by night; mesopic in the middle. Each f is 1
 * over the hemisphere to the digits of its constants; the sum is divided by
 * what the hemisphere holds.
 *
 * The paper's halo is 0.159 degrees wide (one sigma), as of fibres that are all
 * as wide: a rainbow. Cross-sections of a lens' fibres are 24 +- 9 square microns
 * (Taylor et al., IOVS 37, 1996), so their widths, as roots of these, are 19 %
 * apart, and so are the rings that they make: w^2 = 0.159^2 + (0.19 r)^2. Rings
 * of colours that lie over each other are pale, red outside.
 *
 * The key `halo` scales its weight; what is not in the halo is not scattered, in
 * each channel: f0 has what the channel's halo leaves.
 * The paper has it strong, while the CIE's mean of many eyes (135/1) has none:
 * so by itself it is as far over the corona as one eye is over the mean of its
 * age, whose standard deviation is a factor of 10^0.1 (van den Berg et al., AJO
 * 144, 2007). That is 1.26 times the corona for HALO of 0.18. */
enum { BANDS = 20 };
static const double CORONA = 20.91, CORONA_FAR = 72.37;
static const double HALO_WIDE = 0.159, FIBRES = 0.19; // sigma; of r
#define HALO 0.18
struct spencer {
    double weight[4];
    double pale[3]; // of f0, by channel, more than weight[0]
    int channels;
    double factor;
    double nm[BANDS], rgb[BANDS][3];
    float luminance[3]; // of the primaries
};

double gp_spencer_term(int i, double t, double nm)
{
    const double a = t + 0.02, z = t / 0.02, r = 3.0 * nm / 568.0;
    const double wide = gp_hypot(HALO_WIDE, FIBRES * r), off = (t - r) / wide;
    static const double degree = M_PI / 180.0;
    return i == 0   ? 2.61e6 * gp_exp(-z * z)
           : i == 1 ? CORONA / (a * a * a)
           : i == 2 ? CORONA_FAR / (a * a)
                    : gp_exp(-0.5 * off * off) /
                          (2.0 * M_PI * r * wide * sqrt(2.0 * M_PI) * degree *
                           degree);
}

/* f0 to f2, and in three channels f3, per steradian, folded into the primaries.
 * Returns the part that is grey, of f0 to f2. */
static double spencer_sky(const struct spencer *s, double t, double out[3])
{
    const double unscattered = gp_spencer_term(0, t, 0.0);
    double grey = s->weight[0] * unscattered;
    for (int i = 1; i < 3; i++)
        grey += s->weight[i] * gp_spencer_term(i, t, 0.0);
    for (int c = 0; c < s->channels; c++)
        out[c] = grey + s->pale[c] * unscattered;
    if (s->channels == 1)
        return grey;
    for (int i = 0; i < BANDS; i++) {
        const double halo = s->weight[3] * gp_spencer_term(3, t, s->nm[i]);
        for (int c = 0; c < 3; c++)
            out[c] += s->rgb[i][c] * halo;
    }
    gp_gamut_fold(s->luminance, out);
    return grey;
}

static void spencer_profile(const void *ctx, double t, double out[3])
{
    const struct spencer *const s = ctx;
    const double plane = s->factor * gp_plane_factor(t);
    spencer_sky(s, t, out);
    for (int c = 0; c < s->channels; c++)
        out[c] *= plane;
}

/* A profile of the angle in the sky, 0 to 90 degrees, as one of the plane,
 * which has no end (model.h): beyond 45 degrees the place t is at the angle
 *   45 + s atan((t - 45) / s),  s = (90 - 45) 2 / pi
 * as in a rectilinear picture: all the hemisphere's light is in the plane. */
struct sky {
    gp_profile p;
    const void *ctx;
    int channels;
};

static void sky_in_plane(const void *sky, double t, double out[3])
{
    static const double EVEN = 45.0, SKY = 90.0;
    const struct sky *const s = sky;
    const double scale = (SKY - EVEN) * 2.0 / M_PI;
    const double x = fmax(t - EVEN, 0.0) / scale;
    const double angle = x > 0.0 ? EVEN + scale * gp_atan(x) : t;
    const double slope = 1.0 / (1.0 + x * x); // of the angle, by t
    s->p(s->ctx, angle, out);
    for (int c = 0; c < s->channels && slope < 1.0; c++)
        out[c] *= angle * slope / t;
}

gp_status gp_sky_shape(const struct gp_log *log, gp_profile p, const void *ctx,
                       int channels, double bends, const struct gp_field *f,
                       struct gp_shape *out)
{
    const struct sky sky = {p, ctx, channels};
    return gp_radial_shape(log, sky_in_plane, &sky, channels, bends, f, out);
}

enum { PHOTOPIC, MESOPIC, SCOTOPIC, ADAPTED };
static const char *const lights[] = {"photopic", "mesopic", "scotopic",
                                     "adapted", NULL};
static const double spencer_weights[3][4] = {
    {0.384, 0.478, 0.138, 0.0},
    {0.368, 0.478, 0.138, 0.016},
    {0.282, 0.478, 0.207, 0.033},
};

static const struct gp_model_key spencer_keys[] = {
    GP_MODEL_SHARE(1.0),
    {"light", "by day, at dusk, by night, or by the pupil of adaptation",
     PHOTOPIC, PHOTOPIC, ADAPTED, lights},
    GP_MODEL_ADAPTATION(0),
    {"pupil", "diameter in mm, 3 by day to 7 by night, in place of light; 0: "
     "by light", 0.0, 0.0, 9.0, NULL},
    {"halo", "strength of the lenticular halo, 0 none to 1 as Spencer et al. "
     "have it", HALO, 0.0, 1.0, NULL},
    {"needles", "rays into which the ciliary corona breaks up; 0: none, it is "
     "even", 0.0, 0.0, 1000.0, NULL},
    {"seed", "which needles", 1.0, 0.0, 1e9, NULL},
    {0},
};

static bool spencer_adapts(const struct gp_recipe *r)
{
    return gp_recipe_value(r, "light") == ADAPTED &&
           !(gp_recipe_value(r, "pupil") > 0.0);
}

static double spencer_pupil(const struct gp_recipe *r,
                            GP_UNUSED const struct gp_field *f)
{
    const double pupil = gp_recipe_value(r, "pupil");
    return pupil > 0.0 ? pupil
           : spencer_adapts(r)
               ? gp_pupil_moon_spencer(gp_recipe_value(r, "adaptation"))
               : 3.0 + 2.0 * gp_recipe_value(r, "light");
}

static gp_status spencer_of(const struct gp_log *log, const struct gp_recipe *r,
                            const struct gp_field *f, struct spencer *out)
{
    // 3 mm is photopic, 5 mesopic, 7 scotopic
    const double at =
        fmin(fmax((spencer_pupil(r, f) - 3.0) / 2.0, 0.0), 2.0);
    const int i = at < 1.0 ? 0 : 1;
    struct spencer s = {.factor = 1.0};
    memcpy(s.luminance, f->luminance, sizeof s.luminance);
    for (int k = 0; k < 4; k++)
        s.weight[k] = spencer_weights[i][k] +
                      (at - i) * (spencer_weights[i + 1][k] -
                                  spencer_weights[i][k]);
    const double halo = gp_recipe_value(r, "halo") * s.weight[3];
    s.weight[0] += s.weight[3] - halo; // it is not scattered
    s.weight[3] = halo;
    s.channels = halo > 0.0 ? 3 : 1;
    gp_spectrum_colours(f->chromaticities, BANDS, s.nm, s.rgb);
    double sum[3], y = 0.0;
    gp_profile_integral(spencer_profile, &s, s.channels, 0.0, 90.0, sum);
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * sum[s.channels == 3 ? c : 0];
    if (!(y > 0.0))
        return gp_fail(log, GP_ERR_USAGE, "spencer: no luminance in the "
                       "frame's primaries; repair its chromaticities");
    s.factor = 1.0 / y;
    for (int c = 0; c < s.channels && s.channels == 3; c++)
        s.pale[c] = y - sum[c]; // f0 holds 1
    *out = s;
    return GP_OK;
}

static double spencer_light(const struct gp_angular *a, int c, double t)
{
    struct spencer s;
    double v[3];
    memcpy(&s, a->v, sizeof s);
    spencer_sky(&s, t, v);
    return v[s.channels == 3 ? c : 0];
}

static bool spencer_angular(const struct gp_recipe *r, const struct gp_field *f,
                            struct gp_angular *out)
{
    struct spencer s;
    _Static_assert(sizeof s <= sizeof out->v, "its figures");
    if (spencer_of(NULL, r, f, &s))
        return false;
    const bool needles = gp_recipe_value(r, "needles") >= 1.0;
    *out = (struct gp_angular) {
        .light = spencer_light,
        .tint = s.channels == 3,
        .lacks =
            needles && f->projection.kind != GP_PERSPECTIVE ? "needles" : NULL,
    };
    memcpy(out->v, &s, sizeof s);
    return true;
}

// -- needles ------------------------------------------------------------------

/* The ciliary corona, f1 and f2, as needles: section 3.1 has it made of rays of
 * random strength, which the cells of the lens scatter. The corona at distance t
 * and angle phi is multiplied by
 *
 *   1 + a(t) (m(phi) - 1)
 *
 * where m has mean 1 over the circle, so that each circle keeps its light, and
 * a falls from 1 to 0 between half of NEEDLE_END and that, where needles would
 * be wide. m is at least 1 - NEEDLE_CONTRAST.
 *
 * Beside a corona by true angles needles have one shape all over a camera's frame. Where
 * an angle from the axis has the cosine e, a pixel is e^2 by e of those in the middle, and
 * that corona e^3 f(e t) / f(t) of theirs at least: with f1 as much, with f2 e of it. So
 * much of their contrast needles have, by the least e: no gap is darker than
 * NEEDLE_CONTRAST has it. Other frames, whose pixels differ by more, have none. */
static const double NEEDLE_END = 5.0; // degrees
static const double NEEDLE_CONTRAST = 0.8;
enum {
    CIRCLE = 1 << 14, // steps of m
    NEAR = 3, // pixels as near, in columns and in rows, take points of rings
};

struct needling {
    double f1, f2;     // the corona f1 / (t + 0.02)^3 + f2 / (t + 0.02)^2, per
                       // steradian
    double least;      // e
    double a, b, turn; // degrees of a pixel; turns
    int rx, ry;
    float *out;
    // by steps of a turn, both periodic: the integral of m - 1, and of that
    double first[CIRCLE + 1], second[CIRCLE + 1];
    double sum[]; // that rows add
};

/* The share of the needles' contrast that is left t degrees from the light. */
static double needle_fade(double t)
{
    return gp_smoothstep(2.0 * (1.0 - t / NEEDLE_END));
}

/* Makes m, of mean 1, and its integrals. */
static void make_circle(const struct gp_recipe *r, struct needling *out)
{
    const int n = (int) gp_recipe_value(r, "needles");
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    double *const sum = out->first, total = 0.0, mean = 0.0;
    memset(sum, 0, sizeof out->first);
    for (int i = 0; i < n; i++) {
        const uint64_t key = 3 * (uint64_t) i;
        const double at = CIRCLE * gp_model_random(seed, key);
        // a few are strong, as of an exponential distribution
        const double strength = -gp_log(1.0 - gp_model_random(seed, key + 1));
        const double width = CIRCLE * (0.3 + gp_model_random(seed, key + 2)) *
                             0.35 / fmax(n, 32.0);
        const int reach = (int) ceil(4.0 * width);
        for (int k = -reach; k <= reach; k++) {
            const double z = (floor(at) + k + 0.5 - at) / width;
            const double v = strength * gp_exp(-0.5 * z * z) / width;
            const int step = (((int) at + k) % CIRCLE + CIRCLE) % CIRCLE;
            sum[step + 1] += v;
            total += v;
        }
    }
    for (int i = 0; i < CIRCLE; i++) {
        const double more = NEEDLE_CONTRAST *
                            (sum[i + 1] / total - 1.0 / CIRCLE);
        sum[i + 1] = sum[i] + more;
        mean += (sum[i] + 0.5 * more) / CIRCLE;
    }
    for (int i = 0; i <= CIRCLE; i++)
        sum[i] -= mean;
    out->second[0] = 0.0;
    for (int i = 0; i < CIRCLE; i++)
        out->second[i + 1] =
            out->second[i] + 0.5 * (sum[i] + sum[i + 1]) / CIRCLE;
}

/* The second integral at a place in turns, from -8 on. */
static inline double second_at(const struct needling *m, double turns)
{
    const double at = (turns + 8.0) * CIRCLE;
    const int step = (int) at, i = step % CIRCLE;
    const double x = at - step, p = m->first[i], q = m->first[i + 1];
    return m->second[i] + x * (p + 0.5 * x * (q - p)) / CIRCLE;
}

/* The corona that needles have t degrees from the light, per square degree. */
static double corona_at(const struct needling *n, double t)
{
    const double near = 1.0 / (t + 0.02), r = t * M_PI / 180.0, rr = r * r;
    const double e = n->least, far = 1.0 / (e * t + 0.02);
    const double plane = (M_PI / 180.0) * (M_PI / 180.0) *
                         (1.0 - rr / 6.0 * (1.0 - rr / 20.0)); // sin(r) / r
    return plane * needle_fade(t) *
           fmin(near * near * (n->f1 * near + n->f2),
                e * e * e * far * far * (n->f1 * far + n->f2));
}

/* Adds the needles of the pixels (x, y), (-x, y), (x, -y) and (-x, -y) to v.
 * Across rays, along the pixel's side that they cross, light times the tent is
 * straight in the angle between a few places, at which m enters by its second
 * integral, however narrow needles are; along them, by a rule of quadrature. */
static void add_pixel(const struct needling *m, int x, int y, double v[4])
{
    enum { MOST = 4 };
    const bool steep = y > x;
    const int along = steep ? y : x, across = steep ? x : y;
    const double a = steep ? m->b : m->a, b = steep ? m->a : m->b;
    const int steps = along < 8 ? 4 : along < 24 ? 2 : 1;
    const struct gp_gauss *const g =
        gp_tent_rule(along < 8 ? 6 : along < 24 ? 4 : 2);
    for (int k = 0; k < g->n; k++) {
        const double u = a * (along + g->node[k]);
        double before = 0.0, turns = 0.0, last[4] = {0};
        for (int i = -steps; i <= steps; i++) { // by angles that grow
            const double offset = (double) (steep ? -i : i) / steps;
            const double w = b * (across + offset);
            const double tent = 1.0 - fabs(offset);
            const double ss = u * u + w * w;
            const double light = // a turn
                tent > 0.0 ? a * g->weight[k] * tent * 2.0 * M_PI * ss / u *
                                 corona_at(m, sqrt(ss)) : 0.0;
            const double angle =
                (steep ? gp_atan2(u, w) : gp_atan2(w, u)) / (2.0 * M_PI);
            const double slope = (light - before) / (angle - turns);
            const double at[4] = {angle, 0.5 - angle, 0.5 + angle, -angle};
            for (int q = 0; q < 4; q++) {
                const double here = second_at(m, at[q] - m->turn);
                if (i > -steps)
                    v[q] -= slope * (here - last[q]);
                last[q] = here;
            }
            before = light;
            turns = angle;
        }
    }
}

/* The needles of the pixels y rows above and below the light. */
static void needle_row(void *ctx, int y, GP_UNUSED int thread)
{
    struct needling *const m = ctx;
    const size_t w = 2 * (size_t) m->rx + 1;
    float *const up = m->out + (size_t) (m->ry - y) * w + m->rx;
    float *const down = m->out + (size_t) (m->ry + y) * w + m->rx;
    double sum = 0.0;
    for (int x = y > NEAR ? 0 : NEAR + 1; x <= m->rx; x++) {
        const double nearest =
            gp_hypot(m->a * fmax(x - 1.0, 0.0), m->b * fmax(y - 1.0, 0.0));
        if (nearest >= NEEDLE_END)
            break;
        double v[4] = {0};
        add_pixel(m, x, y, v);
        for (int k = 0; k < 4; k++) {
            const bool left = k == 1 || k == 2, low = k >= 2;
            if ((left && x == 0) || (low && y == 0))
                continue;
            float *const to = (low ? down : up) + (left ? -x : x);
            *to = (float) v[k];
            sum += (double) *to;
        }
    }
    m->sum[y] = sum;
}

/* Fills the pixels within NEAR by points of rings, and adds them to `sum`, but
 * the light's own. */
static gp_status add_near(const struct gp_log *log, const struct needling *m,
                          double *sum)
{
    enum { ANGLES = 1024, FEW = 256 };
    static const double RATIO = 0.1, STEP = 0.07, LEAST = 1e-4;
    struct gp_deposit d = {0};
    const double side = fmin(m->a, m->b);
    const double end =
        fmin(NEEDLE_END, gp_hypot(m->a * (NEAR + 1), m->b * (NEAR + 1)));
    gp_status st = gp_deposit_make(log, 1, NEAR, NEAR, &d);
    if (st)
        return st;
    for (double t = LEAST * side; t < end;) {
        const double step = fmin(fmin(RATIO * t, STEP * side), end - t);
        const double mid = t + 0.5 * step;
        const double ring = 2.0 * M_PI * mid * step * corona_at(m, mid);
        const int angles = t < side / 2.0 ? FEW : ANGLES;
        const int steps = CIRCLE / angles;
        for (int i = 0; i < angles; i++) {
            const double more =
                m->first[(i + 1) * steps] - m->first[i * steps];
            const double angle = 2.0 * M_PI * ((i + 0.5) / angles + m->turn);
            gp_deposit_add(&d, mid * (gp_cos(angle) / m->a),
                           mid * (-gp_sin(angle) / m->b),
                           (const double[3]) {ring * more});
        }
        t = step < end - t ? t + step : end;
    }
    for (int y = -NEAR; y <= NEAR; y++) {
        for (int x = -NEAR; x <= NEAR; x++) {
            if (abs(y) > m->ry || abs(x) > m->rx || (x == 0 && y == 0))
                continue;
            float *const to = m->out + (size_t) (y + m->ry) *
                              (2 * (size_t) m->rx + 1) + (size_t) (x + m->rx);
            *to = (float) d.v[0][(y + NEAR) * (2 * NEAR + 1) + x + NEAR];
            *sum += (double) *to;
        }
    }
    gp_free(d.v[0]);
    return GP_OK;
}

/* Makes a shape of what needles add to the even corona, as where e is `least`. Light that
 * they miss goes to the light's own pixel: the sum is 0. */
static gp_status make_needles(const struct gp_log *log,
                              const struct gp_recipe *r,
                              const struct spencer *s, const struct gp_field *f,
                              double least, struct gp_shape *out)
{
    gp_status st;
    struct needling *m = NULL;
    const double a = f->degrees * f->aspect, b = f->degrees;
    const int rx = (int) fmin(ceil(NEEDLE_END / a), f->w - 1);
    const int ry = (int) fmin(ceil(NEEDLE_END / b), f->h - 1);
    double rest = 0.0;
    const size_t w = 2 * (size_t) rx + 1, h = 2 * (size_t) ry + 1;
    GP_TRY(gp_samples_make(log, 1, rx, ry, out));
    GP_TRY(gp_alloc(log, "kernel", 1,
                    sizeof *m + ((size_t) ry + 1) * sizeof *m->sum, &m));
    *m = (struct needling) {
        .f1 = s->factor * s->weight[1] * CORONA,
        .f2 = s->factor * s->weight[2] * CORONA_FAR,
        .least = least,
        .a = a,
        .b = b,
        .turn = fmod(f->rotate / 360.0, 1.0),
        .rx = rx,
        .ry = ry,
        .out = ((struct gp_samples *) out->state)->k.c[0],
    };
    memset(m->out, 0, w * h * sizeof *m->out);
    make_circle(r, m);
    gp_parallel_do(ry + 1, needle_row, m);
    GP_TRY(add_near(log, m, &rest));
    for (int y = 0; y <= ry; y++)
        rest += m->sum[y];
    m->out[(size_t) ry * w + (size_t) rx] = (float) -rest;
out:
    gp_free(m);
    if (st && out->free) {
        out->free(out->state);
        *out = (struct gp_shape) {0};
    }
    return st;
}

/* Needles beside the corona by true angles. */
static gp_status spencer_rest(const struct gp_log *log,
                              const struct gp_recipe *r,
                              const struct gp_field *f, struct gp_shape *out)
{
    struct spencer s;
    gp_status st = spencer_of(log, r, f, &s);
    if (st || !(gp_recipe_value(r, "needles") >= 1.0) ||
        f->projection.kind != GP_PERSPECTIVE)
        return st;
    st = make_needles(log, r, &s, f, 1.0 / gp_hypot(1.0, f->tangent), out);
    // |n| <= (c + n) + c, and c <= (c + n) / (1 - NEEDLE_CONTRAST)
    out->negative = true;
    out->over = 1.0 + 1.0 / (1.0 - NEEDLE_CONTRAST);
    return st;
}

// -- an eye that is more than even and grey -----------------------------------

/* Degrees beyond which there is no halo: that of 700 nm is around 3.7 and falls
 * to 1e-7 of its height by then. */
static const double HALO_END = 7.8;

/* The part that is so, which goes on over the whole field, and what halo and
 * needles add near the light. */
enum { LEAST = 256 };
struct night {
    struct gp_shape eye;
    struct gp_shape halo; // the same with the halo; row NULL: no halo
    double degrees;   // a pixel's shorter side
    double least[LEAST + 1]; // of a channel over the grey part, from i / LEAST
                      // of HALO_END on; 1 without a halo
    float luminance[3];      // of the primaries
    int rx, ry;       // offsets of halo and needles
    struct gp_shape needles; // row NULL: none
};

static void night_far(const void *state, int x, int y, int n,
                      double *const out[3])
{
    const struct night *const s = state;
    s->eye.row(s->eye.state, x, y, n, out);
}

static void night_row(const void *state, int x, int y, int n,
                      double *const out[3])
{
    const struct night *const s = state;
    const int channels = s->halo.row ? 3 : 1;
    const int from = gp_max(x, -s->rx), to = gp_min(x + n, s->rx + 1);
    const bool near = abs(y) <= s->ry && from < to;
    double needles[GP_SHAPE_STRIP] = {0};
    night_far(state, x, y, n, out);
    for (int c = 1; c < channels; c++)
        memcpy(out[c], out[0], (size_t) n * sizeof *out[c]);
    if (near && s->halo.row)
        s->halo.row(s->halo.state, from, y, to - from,
                    (double *[3]) {out[0] + from - x, out[1] + from - x,
                                   out[2] + from - x});
    if (near && s->needles.row)
        s->needles.row(s->needles.state, from, y, to - from,
                       (double *[3]) {needles});
    for (int i = from; i < to && near; i++) {
        double v[3] = {0};
        for (int c = 0; c < channels; c++)
            v[c] = out[c][i - x] + needles[i - from];
        if (channels == 3) // it is darker between needles
            gp_gamut_fold(s->luminance, v);
        for (int c = 0; c < channels; c++)
            out[c][i - x] = channels == 3 ? v[c] : fmax(v[c], 0.0);
    }
}

static double night_least(const void *state, double pixels)
{
    const struct night *const s = state;
    // both pixels' corners are nearer to each other
    const double t = fmax((pixels - 2.0) * s->degrees, 0.0);
    const double share = s->least[(int) fmin(t / HALO_END * LEAST, LEAST)];
    // 1 %: needles' integrals
    const double gaps = 1.01 * NEEDLE_CONTRAST * needle_fade(t);
    return s->needles.row ? fmax(share - gaps, 0.0) : share;
}

/* Fills s->least. Tables are exact to ROUNDING. */
static void find_least(const struct spencer *e, struct night *s)
{
    static const double ROUNDING = 1e-6;
    for (int i = LEAST; i >= 0; i--) {
        double v[3] = {0};
        const double grey = spencer_sky(e, HALO_END * i / LEAST, v);
        s->least[i] = i < LEAST ? s->least[i + 1] : 1.0;
        for (int c = 0; c < e->channels; c++)
            s->least[i] = fmin(s->least[i], v[c] / grey + ROUNDING);
    }
}

static void free_night(void *state)
{
    struct night *const s = state;
    const struct gp_shape *const shapes[] = {&s->eye, &s->halo, &s->needles};
    for (int i = 0; i < 3; i++) {
        if (shapes[i]->free)
            shapes[i]->free(shapes[i]->state);
    }
    gp_free(s);
}

/* The eye with its halo, of s->channels 3, and with needles. */
static gp_status open_night(const struct gp_log *log,
    const struct gp_recipe *r, const struct spencer *s,
    const struct gp_field *f, struct gp_shape *out)
{
    gp_status st;
    struct night *n;
    struct spencer eye = *s;
    const double far = fmax(HALO_END, NEEDLE_END);
    eye.channels = 1;
    st = gp_alloc_zero(log, "kernel", 1, sizeof *n, &n);
    if (st)
        return st;
    n->degrees = f->degrees * fmin(f->aspect, 1.0);
    memcpy(n->luminance, f->luminance, sizeof n->luminance);
    find_least(s, n);
    n->rx = (int) fmin(ceil(far / (f->degrees * f->aspect)), f->w - 1);
    n->ry = (int) fmin(ceil(far / f->degrees), f->h - 1);
    GP_TRY(gp_sky_shape(log, spencer_profile, &eye, 1, 0.0, f, &n->eye));
    if (s->channels == 3)
        GP_TRY(gp_sky_shape(log, spencer_profile, s, 3, HALO_END, f, &n->halo));
    if (gp_recipe_value(r, "needles") >= 1.0)
        GP_TRY(make_needles(log, r, s, f, 1.0, &n->needles));
    *out = (struct gp_shape) {
        .state = n, .free = free_night, .row = night_row, .far = night_far,
        .far_grey = true, .far_even = true, .least = night_least,
        .grey = s->channels == 1, .even = !n->needles.row,
        .reach = INT_MAX, .sharp = gp_max(n->rx, n->ry),
    };
    n = NULL;
out:
    if (n)
        free_night(n);
    return st;
}

static gp_status open_spencer(const struct gp_log *log,
    const struct gp_recipe *r, const struct gp_field *f, struct gp_shape *out)
{
    struct spencer s;
    gp_status st = spencer_of(log, r, f, &s);
    if (!st)
        st = s.channels == 3 || gp_recipe_value(r, "needles") >= 1.0
                 ? open_night(log, r, &s, f, out)
                 : gp_sky_shape(log, spencer_profile, &s, 1, 0.0, f, out);
    if (!st)
        out->smooth = 0.1 / (f->degrees * fmin(f->aspect, 1.0));
    return st;
}

const struct gp_model gp_model_spencer = {
    .name = "spencer",
    .text = "the eye by day, at dusk or by night",
    .source = "Spencer et al. 1995, eqs. 5 to 8",
    .keys = spencer_keys,
    .pupil = spencer_pupil,
    .adapts = spencer_adapts,
    .angular = spencer_angular,
    .rest = spencer_rest,
    .open = open_spencer,
};
