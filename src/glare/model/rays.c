// SPDX-License-Identifier: Apache-2.0
/* Models of rays: stars, crosses and streaks as bundles of tapered strands. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model_priv.h"

#include <math.h>
#include <stdlib.h>

/* A ray is a bundle of strands that start at the light and fan out. A strand at
 * distance p along it and q across it, both in degrees, has
 *
 *   v_c(p, q) = a g_c(p) n(q / s(p)) / s(p)        p <= L
 *   g_c(p)    = g_c(0) exp(-p^2 / (2 width^2))     p < 0: a round end
 *             = sum over wavelengths l of w_c(l) g(p 550 / l) 550 / l
 *   g(p)      = (1 - p / L)^8 / (1 + (p / core)^2)
 *   s(p)      = width (1 - 0.8 p / L)
 *
 * The eighth power is a window that no brightness shows the end of. n is the
 * normal density, cut at 5; w the spectrum's weights, which sum to 1 in each
 * channel: white light stays white, only redder far out, as diffraction makes it
 * (without `dispersion` g_c is g). Lengths, angles and strengths a of strands
 * come from `seed`, and the sum is tinted to a luminance of 1. */
enum {
    MOST_STRANDS = 512,
    TABLE = 2048,        // steps of g_c from 0 to the longest strand
    BANDS = 24,          // wavelengths
};
static const double CUT = 5.0;
static const double DARK = 6.5; // widths past which the density is under 1e-9
static const double WIDE = 4.0; // widths in a slice of a pixel

struct strand {
    double cosine, sine; // of its direction; y is down
    double length, gain;
};

struct rays {
    double a, b;                // sides of a pixel, or of a slice of one, in the
                                // plane of strands, which is not squeezed
    struct gp_samples *to;
    double (*row_sum)[3];       // of each row
    struct strand strand[MOST_STRANDS];
    int n;
    bool even;                  // opposite rays are alike
    double width;
    double curve[3][TABLE + 2]; // g_c at steps of p / length, for length 1
};

/* g_c at a fraction `t` of a strand's length, of light 1 in all. */
static double along(const struct rays *r, int c, double t)
{
    const double at = t * TABLE;
    const int i = (int) at;
    return i > TABLE ? 0.0
                     : r->curve[c][i] + (at - i) * (r->curve[c][i + 1] -
                                                    r->curve[c][i]);
}

/* Adds the strand's integral over a pixel whose middle is (p, q) along and
 * across it, where g_c and the width change little on a pixel: seen along the
 * strand it is two boxes folded, whose integral under the normal density has a
 * closed form, times the mean of g_c. The light's own pixel widens the density. */
static void add_far_pixel(const struct rays *r, const struct strand *s,
                          double p, double q, double sum[3])
{
    const double a = r->a, b = r->b;
    const struct gp_gauss *const g = gp_gauss_rule(3);
    const double thin = r->width * (1.0 - 0.8 * p / s->length);
    const double width =
        gp_hypot(thin, gp_hypot(a * s->sine, b * s->cosine) / sqrt(12.0));
    // half the boxes, in widths; a side that is seen end on keeps some
    const double i = 0.5 * a * fabs(s->sine) / width;
    const double j = 0.5 * b * fabs(s->cosine) / width;
    const double low = 1e-3 * fmax(i, j);
    const double m = fmax(i, low), n = fmax(j, low), z = fabs(q) / width;
    if (z > m + n + DARK) // strands are thinner far out
        return;
    const double share = // at its ends rounding is all there is
        fmax(gp_normal_twice(z + m + n) - gp_normal_twice(z + m - n) -
                 gp_normal_twice(z - m + n) + gp_normal_twice(z - m - n),
             0.0) /
        (4.0 * m * n) * s->gain * a * b / (width * s->length);
    // a box as deep as both squares are spread along the strand
    const double depth = sqrt(2.0) * gp_hypot(a * s->cosine, b * s->sine);
    for (int k = 0; k < g->n; k++) {
        const double at = (p + depth * g->node[k]) / s->length;
        for (int c = 0; c < 3; c++)
            sum[c] += share * g->weight[k] * along(r, c, fmin(at, 1.0));
    }
}

/* Nodes of a tent over (-1, 1), in parts over which a strand's section bends little:
 * a pixel's side is so many times as long as the strand is thin. */
enum {
    MOST_PARTS = 16,
    MOST_NODES = 7,
    MOST_TENT = 2 * MOST_PARTS * MOST_NODES
};
struct tent {
    int n;
    double node[MOST_TENT], weight[MOST_TENT];
};

static void make_tent(double side, struct tent *t)
{
    const struct gp_gauss *const g = gp_gauss_rule(side > 0.5 ? MOST_NODES : 4);
    // squeezed pixels are much narrower than high
    const int parts = (int) fmin(ceil(0.7 * side), MOST_PARTS);
    t->n = 0;
    for (int k = 0; k < 2 * parts; k++) {
        for (int i = 0; i < g->n; i++, t->n++) {
            t->node[t->n] = (k + 0.5 + g->node[i]) / parts - 1.0;
            t->weight[t->n] =
                g->weight[i] * (1.0 - fabs(t->node[t->n])) / parts;
        }
    }
}

/* The same of any pixel around (u, v). */
GP_CLONES static void add_pixel(const struct rays *r, const struct strand *s,
                                double u, double v, double sum[3])
{
    const double a = r->a, b = r->b, end = s->length;
    const double taper = r->width * 0.8 / end;
    const double p0 = u * s->cosine + v * s->sine;
    if (p0 > 4.0 * gp_maxd(gp_maxd(a, b), r->width)) {
        add_far_pixel(r, s, p0, v * s->cosine - u * s->sine, sum);
        return;
    }
    const double thin =
        gp_maxd(r->width - taper * gp_maxd(p0, 0.0), 0.2 * r->width);
    const double all = s->gain * a * b / (sqrt(2.0 * M_PI) * end);
    struct tent across, down;
    make_tent(a / thin, &across);
    make_tent(b / thin, &down);
    for (int j = 0; j < down.n; j++) {
        double light[MOST_TENT], at[MOST_TENT];
        const double y = v + b * down.node[j];
        for (int i = 0; i < across.n; i++) {
            const double x = u + a * across.node[i];
            const double p = x * s->cosine + y * s->sine;
            const double q = y * s->cosine - x * s->sine;
            const double past = gp_maxd(p, 0.0),
                         width = r->width - taper * past;
            const double z = q / width, back = gp_mind(p, 0.0) / r->width;
            const double density =
                gp_exp(-0.5 * (z * z + back * back)) / width * across.weight[i];
            const bool in = p <= end && fabs(z) <= CUT && back >= -CUT;
            light[i] = in ? density : 0.0;
            at[i] = past / end;
        }
        for (int i = 0; i < across.n; i++) {
            for (int c = 0; c < 3 && light[i] > 0.0; c++)
                sum[c] += all * down.weight[j] * light[i] * along(r, c, at[i]);
        }
    }
}

// -- pixels that resolve strands ----------------------------------------------

/* Makes row i of the samples, and where opposite rays are alike the one
 * opposite to it. */
static void make_row(void *ctx, int i, GP_UNUSED int thread)
{
    const struct rays *const r = ctx;
    const int rx = r->to->cx, n = 2 * rx + 1;
    const int y = i - r->to->cy, opposite = 2 * r->to->cy - i;
    const size_t at = (size_t) i * (size_t) n;
    const bool both = r->even && i != opposite;
    double sums[3] = {0};
    const double a = r->a, v = r->b * y, side = CUT * r->width + a + r->b;
    for (int k = 0; k < r->n; k++) {
        const struct strand *const s = &r->strand[k];
        // u of |q| <= side and -side <= p <= length + side on this row
        double from = -INFINITY, to = INFINITY;
        const double line[2][4] = {
            {-s->sine, v * s->cosine, -side, side},
            {s->cosine, v * s->sine, -side, s->length + side},
        };
        for (int j = 0; j < 2; j++) {
            const double *const l = line[j];
            if (fabs(l[0]) < 1e-12) {
                if (l[1] < l[2] || l[1] > l[3])
                    to = -INFINITY;
                continue;
            }
            const double p = (l[2] - l[1]) / l[0], q = (l[3] - l[1]) / l[0];
            from = fmax(from, fmin(p, q));
            to = fmin(to, fmax(p, q));
        }
        const int first = (int) fmax(ceil(from / a), -rx);
        const int last = (int) fmin(floor(to / a), rx);
        for (int x = first; x <= last; x++) {
            double sum[3] = {0};
            add_pixel(r, s, a * x, v, sum);
            for (int c = 0; c < 3; c++) {
                r->to->k.c[c][at + (size_t) (x + rx)] += (float) sum[c];
                sums[c] += sum[c];
            }
        }
    }
    memcpy(r->row_sum[i], sums, sizeof sums);
    for (int c = 0; c < 3 && both; c++) {
        float *const to = gp_row(r->to->k.c[c], n, opposite);
        for (int x = 0; x < n; x++)
            to[n - 1 - x] = r->to->k.c[c][at + (size_t) x];
        r->row_sum[opposite][c] = sums[c];
    }
}

/* A strand's light at a fraction t of its length, at one wavelength. */
static double curve_of(double nm, double t, double core, double dispersion)
{
    const double scale = 1.0 + dispersion * (550.0 / nm - 1.0);
    const double at = t * scale / core, left = fmax(1.0 - t, 0.0);
    const double q = left * left;
    return q * q * q * q * scale / (1.0 + at * at);
}

/* g_c by wavelengths, of integral 1 in each channel, for strands of length 1;
 * what their round ends add is in their gains. Every wavelength has its light,
 * so that a strand is white in sum, in all primaries. */
static void make_curves(const struct gp_field *f, double core,
                        double dispersion, struct rays *r)
{
    double nm[BANDS], rgb[BANDS][3], sum[3] = {0}, light[BANDS] = {0};
    gp_spectrum_colours(f->chromaticities, BANDS, nm, rgb);
    for (int k = 0; k < BANDS; k++) {
        for (int i = 0; i <= TABLE; i++)
            light[k] += curve_of(nm[k], (double) i / TABLE, core, dispersion) *
                        (i == 0 ? 0.5 : 1.0) / TABLE;
    }
    for (int i = 0; i <= TABLE + 1; i++) {
        double v[3] = {0};
        for (int k = 0; k < BANDS; k++) {
            const double g = curve_of(nm[k], (double) i / TABLE, core,
                                      dispersion) / light[k];
            for (int c = 0; c < 3; c++)
                v[c] += rgb[k][c] * g;
        }
        gp_gamut_fold(f->luminance, v);
        for (int c = 0; c < 3; c++) {
            r->curve[c][i] = v[c];
            sum[c] += v[c] * (i == 0 ? 0.5 : 1.0) / TABLE;
        }
    }
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i <= TABLE + 1; i++)
            r->curve[c][i] /= sum[c];
    }
}

/* Fills the samples, and finds the light of each channel in them. */
static gp_status fill_samples(const struct gp_log *log, struct rays *s,
                              double light[3])
{
    const int rows = 2 * s->to->cy + 1;
    const size_t n = (size_t) rows * (2 * (size_t) s->to->cx + 1);
    gp_status st = gp_alloc(log, "kernel", (size_t) rows, sizeof *s->row_sum,
                            &s->row_sum);
    if (st)
        return st;
    for (int c = 0; c < 3; c++)
        memset(s->to->k.c[c], 0, n * sizeof(float));
    gp_parallel_do(s->even ? s->to->cy + 1 : rows, make_row, s);
    for (int i = 0; i < 3 * rows; i++)
        light[i % 3] += s->row_sum[i / 3][i % 3];
    GP_FREE(s->row_sum);
    return GP_OK;
}

/* Lays the strands of all rays: a ray's first is its axis, the others are
 * random beside it. */
static void lay_strands(const struct gp_recipe *r, double rotate,
                        struct rays *s)
{
    const int points = (int) gp_recipe_value(r, "points");
    const int strands = (int) gp_recipe_value(r, "strands");
    const uint64_t seed = (uint64_t) gp_recipe_value(r, "seed");
    const double length = gp_recipe_value(r, "length");
    const double spread = gp_recipe_value(r, "spread");
    const double turned = gp_recipe_value(r, "angle") + rotate;
    s->n = points * strands;
    s->even = points % 2 == 0;
    for (int i = 0; i < s->n; i++) {
        struct strand *const one = &s->strand[i];
        // opposite rays are alike where their number is even, as those of a
        // stop are
        const uint64_t ray = (uint64_t) (i / strands) %
                             (uint64_t) (points % 2 ? points : points / 2);
        const uint64_t key = ray * 4096u + 3u * (uint64_t) (i % strands);
        const bool middle = i % strands == 0;
        const double off = middle ? 0.0 : gp_model_random(seed, key) - 0.5;
        const double angle = M_PI / 180.0 *
            (turned + 360.0 * (i / strands) / points + 2.0 * spread * off);
        one->cosine = gp_cos(angle);
        one->sine = -gp_sin(angle);
        one->length = length *
            (middle ? 1.0 : 0.35 + 0.6 * gp_model_random(seed, key + 1));
        one->gain = middle ? 1.0 : 0.2 + 0.8 * gp_model_random(seed, key + 2);
    }
}

/* Reads the colour, of luminance 1 in the field's primaries: white light's in
 * those of BT.709.
 * Errors: GP_ERR_USAGE it has no luminance. */
static gp_status find_tint(const struct gp_log *log, const struct gp_recipe *r,
                           const struct gp_field *f, double tint[3])
{
    const double own[3] = {gp_recipe_value(r, "red"),
                           gp_recipe_value(r, "green"),
                           gp_recipe_value(r, "blue")};
    double m[9];
    memcpy(tint, own, sizeof own);
    if (memcmp(f->chromaticities, gp_rec709_chromaticities,
               sizeof gp_rec709_chromaticities) != 0 &&
        gp_spectrum_to_spectrum(gp_rec709_chromaticities, f->chromaticities, m))
        for (int c = 0; c < 3; c++)
            tint[c] = m[3 * c] * own[0] + m[3 * c + 1] * own[1] +
                      m[3 * c + 2] * own[2];
    gp_gamut_fold(f->luminance, tint);
    const double y = gp_luminance_of(f->luminance, tint);
    if (!(y > 0.0))
        return gp_fail(log, GP_ERR_USAGE, "%s: its colour has no luminance "
                       "(%g,%g,%g); give red, green or blue over 0",
                       r->model->name, own[0], own[1], own[2]);
    for (int c = 0; c < 3; c++)
        tint[c] /= y;
    return GP_OK;
}

static gp_status open_rays(const struct gp_log *log, const struct gp_recipe *r,
                           const struct gp_field *f, struct gp_shape *out)
{
    static const double MOST = 1024.0; // slices from a light to a ray's end
    const int size[2] = {f->w, f->h};
    double reach[2] = {0.0, 0.0}, light[3] = {0}, tint[3];
    int slices[2], n[2];
    bool cut = false; // of light that the field does not need
    struct rays *s;
    gp_status st = find_tint(log, r, f, tint);
    if (!st)
        st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    s->width = gp_recipe_value(r, "width");
    make_curves(f, gp_recipe_value(r, "core") / gp_recipe_value(r, "length"),
                gp_recipe_value(r, "dispersion"), s);
    lay_strands(r, f->rotate, s);
    for (int i = 0; i < s->n; i++) {
        const struct strand *const one = &s->strand[i];
        reach[0] = fmax(reach[0], fabs(one->length * one->cosine));
        reach[1] = fmax(reach[1], fabs(one->length * one->sine));
    }
    double side[2] = {f->degrees * f->aspect / gp_recipe_value(r, "squeeze"),
                      f->degrees};
    for (int i = 0; i < 2; i++) {
        const double end = reach[i] + CUT * s->width;
        slices[i] = (int) ceil(side[i] / fmax(WIDE * s->width, end / MOST));
        side[i] /= slices[i];
        const double needed = ceil(end / side[i]) + 1.0;
        const double met = (double) size[i] * slices[i] - 1.0;
        cut |= needed > met;
        n[i] = (int) fmin(needed, met);
    }
    s->a = side[0];
    s->b = side[1];
    GP_TRY(gp_samples_make(log, 3, n[0], n[1], out));
    s->to = out->state;
    st = fill_samples(log, s, light);
    if (st) {
        out->free(out->state);
        goto out;
    }
    // all the light where it all is in them; else by the strands' integrals, a
    // round end being as much as width sqrt(pi / 2) of the strand there
    for (int c = 0; c < 3 && cut; c++) {
        light[c] = 0.0;
        for (int i = 0; i < s->n; i++) {
            const double end = s->width * sqrt(0.5 * M_PI) /
                               s->strand[i].length;
            light[c] += s->strand[i].gain * (1.0 + end * s->curve[c][0]);
        }
    }
    for (int c = 0; c < 3; c++)
        s->to->scale[c] = light[c] > 0.0 ? tint[c] / light[c] : 0.0;
    if (slices[0] > 1 || slices[1] > 1)
        st = gp_slices_join(log, slices, n[0], n[1], f, out);
out:
    gp_free(s);
    return st;
}

#define KEYS(share, points, strands, spread, length, core, width, angle,      \
             dispersion, squeeze, r, g, b)                                    \
    GP_MODEL_SHARE(share),                                                    \
    {"points", "rays", points, 1, 32, NULL},                                  \
    {"strands", "strands of each ray", strands, 1, 16, NULL},                 \
    {"spread", "angle to which strands fan out on each side, degrees", spread,\
     0, 90, NULL},                                                            \
    {"length", "degrees of view from the light to a ray's end, to which it "  \
     "fades: a half is seen of a bright lamp", length, 0.01, 180, NULL},      \
    {"core", "distance at which it has fallen to a half, degrees", core,      \
     0.001, 180, NULL},                                                       \
    {"width", "thickness at the light (one sigma), degrees", width, 0.002,    \
     10, NULL},                                                               \
    {"angle", "direction of the first ray, degrees counter-clockwise", angle, \
     -360, 360, NULL},                                                        \
    {"dispersion", "growth with wavelength, 0 none to 1 as diffraction",      \
     dispersion, 0, 1, NULL},                                                 \
    {"squeeze", "how many times as wide as high: an anamorphic lens",         \
     squeeze, 0.1, 20, NULL},                                                 \
    {"red", "its colour, BT.709", r, 0, 1, NULL},                             \
    {"green", "its colour, BT.709", g, 0, 1, NULL},                           \
    {"blue", "its colour, BT.709", b, 0, 1, NULL},                            \
    {"seed", "which strands", 1, 0, 1e9, NULL},                               \
    {0}

static const struct gp_model_key star_keys[] = {
    KEYS(0.1, 6, 7, 1.6, 10.0, 0.35, 0.02, 90.0, 1.0, 1.0, 1.0, 1.0, 1.0),
};
static const struct gp_model_key cross_keys[] = {
    KEYS(0.1, 4, 5, 0.7, 12.0, 0.6, 0.022, 45.0, 0.4, 1.0, 1.0, 1.0, 1.0),
};
static const struct gp_model_key streak_keys[] = {
    KEYS(0.06, 2, 9, 0.3, 44.0, 1.6, 0.03, 0.0, 0.3, 1.0, 0.3, 0.6, 1.0),
};

const struct gp_model gp_model_star = {
    .name = "star", .text = "rays of a stop's blades, redder far out",
    .source = "after Fraunhofer's edges: light falls with the square",
    .keys = star_keys, .open = open_rays,
};
const struct gp_model gp_model_cross = {
    .name = "cross", .text = "four rays of a cross screen filter",
    .source = "a photographer's filter", .keys = cross_keys, .open = open_rays,
};
const struct gp_model gp_model_streak = {
    .name = "streak", .text = "the horizontal streak of an anamorphic lens",
    .source = "a cylinder's scatter", .keys = streak_keys, .open = open_rays,
};
