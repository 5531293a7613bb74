/* Models of rays: stars, crosses and streaks as bundles of tapered strands. */
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
 * The eighth power is a window that no brightness shows the end of: a lamp that
 * is 2^23 times as bright as what is seen has rays of 0.8 L, which fade over a
 * third of that. n is the normal density, cut at 5; w the spectrum's weights, which sum to 1
 * in each channel: white light stays white, only redder far out, as diffraction
 * makes it (without `dispersion` g_c is g). Lengths, angles and strengths a of
 * strands come from `seed`, spread about those of their ray, and the sum is 1
 * in each channel, then tinted to a luminance of 1. */
enum {
    MOST_STRANDS = 512,
    TABLE = 2048,        // steps of g_c from 0 to the longest strand
    BANDS = 24,          // wavelengths
};
static const double CUT = 5.0;
static const double DARK = 6.5; // widths past which the density is under 1e-9
static const double WIDE = 4.0; // widths in a pixel from which points are cheap

struct strand {
    double cosine, sine; // of its direction; y is down
    double length, gain;
};

struct rays {
    struct gp_field f;
    int rx, ry;                 // offsets to which samples are made
    float *sample[3];           // rows of 2 rx + 1; sample[0] is owned
    double (*row_sum)[3];       // of each row, in making
    struct strand strand[MOST_STRANDS];
    int n;
    bool even;                  // opposite rays are alike
    double width, squeeze;
    double curve[3][TABLE + 2]; // g_c at steps of p / length, for length 1
    double within[3][TABLE + 2]; // its integral from 0 to there
    double tint[3];
    struct gp_deposit points;   // in place of samples, where pixels are wide
};

/* g_c at a share `t` of a strand's length, of light 1 in all. */
static double along(const struct rays *r, int c, double t)
{
    const double at = t * TABLE;
    const int i = (int) at;
    return i > TABLE ? 0.0
                     : r->curve[c][i] + (at - i) * (r->curve[c][i + 1] -
                                                    r->curve[c][i]);
}

/* The integral of g_c from 0 to a share `t` of a strand's length. */
static double light_within(const struct rays *r, int c, double t)
{
    const double at = fmin(t, 1.0) * TABLE;
    const int i = (int) at;
    return r->within[c][i] + (at - i) / TABLE * 0.5 *
                                 (r->curve[c][i] + along(r, c, fmin(t, 1.0)));
}

/* The second integral of the normal density of width 1. */
static double ramp(double z)
{
    return 0.5 * z * erfc(-sqrt(0.5) * z) +
           exp(-0.5 * z * z) / sqrt(2.0 * M_PI);
}

/* Adds the strand's integral over a pixel whose middle is (p, q) along and
 * across it, where g_c and the width change little on a pixel: the pixel seen
 * along the strand is two boxes folded, whose integral under the normal density
 * has a closed form, times the mean of g_c. The light's own pixel, as wide,
 * makes the density wider by as much. */
static void add_far_pixel(const struct rays *r, const struct strand *s,
    double p, double q, double a, double b, double sum[3])
{
    const struct gp_gauss *const g = gp_gauss_rule(3);
    const double thin = r->width * (1.0 - 0.8 * p / s->length);
    const double width = hypot(thin, hypot(a * s->sine, b * s->cosine) /
                                         sqrt(12.0));
    // half the boxes, in widths; a side that is seen end on keeps some
    const double i = 0.5 * a * fabs(s->sine) / width;
    const double j = 0.5 * b * fabs(s->cosine) / width;
    const double low = 1e-3 * fmax(i, j);
    const double m = fmax(i, low), n = fmax(j, low), z = q / width;
    if (fabs(z) > m + n + DARK) // strands are thinner far out
        return;
    const double share = // at its ends rounding is all there is
        fmax(ramp(z + m + n) - ramp(z + m - n) - ramp(z - m + n) +
         ramp(z - m - n), 0.0) / (4.0 * m * n) * s->gain * a * b /
        (width * s->length);
    // a box as deep as both squares are spread along the strand
    const double depth = sqrt(2.0) * hypot(a * s->cosine, b * s->sine);
    for (int k = 0; k < g->n; k++) {
        const double at = (p + depth * g->node[k]) / s->length;
        for (int c = 0; c < 3; c++)
            sum[c] += share * g->weight[k] * along(r, c, fmin(at, 1.0));
    }
}

/* The same of any pixel around (u, v), a by b degrees: by parts of a tent. */
static void add_pixel(const struct rays *r, const struct strand *s, double u,
                      double v, double a, double b, double sum[3])
{
    const double taper = r->width * 0.8 / s->length;
    const double p0 = u * s->cosine + v * s->sine;
    if (p0 > 4.0 * fmax(fmax(a, b), r->width)) {
        add_far_pixel(r, s, p0, v * s->cosine - u * s->sine, a, b, sum);
        return;
    }
    const double thin = fmax(r->width - taper * fmax(p0, 0.0),
                             0.2 * r->width);
    // parts along each side, as squeezed pixels are much narrower than high
    const int m = (int) fmin(ceil(0.7 * a / thin), 16.0);
    const int n = (int) fmin(ceil(0.7 * b / thin), 16.0);
    const struct gp_gauss *const g = gp_gauss_rule(a / thin > 0.5 ? 7 : 4);
    const struct gp_gauss *const h = gp_gauss_rule(b / thin > 0.5 ? 7 : 4);
    const double da = a / m, db = b / n;
    for (int j = 0; j < 2 * n * h->n; j++) {
        const double dy = (j / h->n + 0.5 + h->node[j % h->n]) / n - 1.0;
        for (int i = 0; i < 2 * m * g->n; i++) {
            const double dx = (i / g->n + 0.5 + g->node[i % g->n]) / m - 1.0;
            const double x = u + a * dx, y = v + b * dy;
            const double p = x * s->cosine + y * s->sine;
            const double q = y * s->cosine - x * s->sine;
            const double width = r->width - taper * fmax(p, 0.0);
            const double z = q / width, back = fmin(p, 0.0) / r->width;
            if (p > s->length || fabs(z) > CUT || back < -CUT)
                continue;
            const double density = s->gain *
                                   exp(-0.5 * (z * z + back * back)) /
                                   (sqrt(2.0 * M_PI) * width * s->length) * da *
                                   db * g->weight[i % g->n] *
                                   h->weight[j % h->n] * (1.0 - fabs(dx)) *
                                   (1.0 - fabs(dy));
            for (int c = 0; c < 3; c++)
                sum[c] += density * along(r, c, fmax(p, 0.0) / s->length);
        }
    }
}

// -- pixels wider than strands ------------------------------------------------

/* A line of a strand, z widths from its axis, straight as widths taper evenly:
 * points on it from p = 0 on and, `back`, of its round end. */
struct line {
    const struct rays *r;
    const struct strand *s;
    double z, light;
    double a, b; // a pixel's sides in the plane of strands
};

/* Adds the stretch of a line from p to q degrees along it by few points, which
 * hold all of that stretch's light. */
static void add_stretch(const struct line *l, bool back, double p, double q)
{
    const struct rays *const r = l->r;
    const struct strand *const s = l->s;
    const struct gp_gauss *const g = gp_gauss_rule(4);
    double density[4][3], sum[3] = {0};
    for (int k = 0; k < g->n; k++) {
        const double at = 0.5 * (p + q) + (q - p) * g->node[k];
        for (int c = 0; c < 3; c++) {
            density[k][c] =
                g->weight[k] * (back ? exp(-0.5 * at * at / (r->width *
                                                             r->width))
                                     : along(r, c, at / s->length));
            sum[c] += density[k][c];
        }
    }
    for (int k = 0; k < g->n; k++) {
        const double at = 0.5 * (p + q) + (q - p) * g->node[k];
        const double across = l->z * (r->width - 0.8 * r->width / s->length *
                                                     fmax(at, 0.0));
        double light[3];
        for (int c = 0; c < 3; c++) {
            const double all = back
                ? r->curve[c][0] * r->width / s->length * sqrt(0.5 * M_PI) *
                      (erf(sqrt(0.5) * q / r->width) -
                       erf(sqrt(0.5) * p / r->width))
                : light_within(r, c, q / s->length) -
                      light_within(r, c, p / s->length);
            light[c] = sum[c] > 0.0 ? l->light * all * density[k][c] / sum[c]
                                    : 0.0;
        }
        gp_deposit_add(&r->points, (at * s->cosine - across * s->sine) / l->a,
                       (at * s->sine + across * s->cosine) / l->b, light);
    }
}

/* The next place after p, p >= 0, where u0 + p du passes a whole number within
 * `reach`; INFINITY: none. */
static double next_whole(double u0, double du, double p, double reach)
{
    const double u = u0 + p * du;
    if (fabs(du) < 1e-12)
        return INFINITY;
    double whole = du > 0.0 ? floor(u) + 1.0 : ceil(u) - 1.0;
    if (fabs(whole - u) < 1e-9) // p is such a place
        whole += du > 0.0 ? 1.0 : -1.0;
    whole = du > 0.0 ? fmax(whole, -reach) : fmin(whole, reach);
    return fabs(whole) <= reach ? (whole - u0) / du : INFINITY;
}

/* Adds a strand by lines along it, cut where they pass from pixel to pixel and
 * at distances that double from a fraction of the core on. */
static void add_strand(const struct rays *r, const struct strand *s,
                       double core, double a, double b)
{
    enum { MOST_PANELS = 64 };
    const struct gp_gauss *const g = gp_gauss_rule(4);
    const double taper = 0.8 * r->width / s->length;
    const double least = fmax(0.25 * core, s->length / TABLE);
    const double reach = fmax(r->points.rx, r->points.ry) + 1.0;
    // across: panels of half a pixel's shorter side, as many on each
    const double half = ceil(2.0 * CUT * r->width / fmin(a, b));
    const int panels = 2 * (int) fmin(fmax(2.0, half), MOST_PANELS / 2);
    double sum = 0.0;
    for (int pass = 0; pass < 2; pass++) { // the first sums up
        for (int k = 0; k < panels * g->n; k++) {
            const double z = CUT * (2.0 * (k / g->n + 0.5 + g->node[k % g->n]) /
                                        panels - 1.0);
            const double w = g->weight[k % g->n] * exp(-0.5 * z * z);
            if (pass == 0) {
                sum += w;
                continue;
            }
            const struct line l = {r, s, z, s->gain * w / sum, a, b};
            const double q = z * r->width;
            // u and v of p along the line, in pixels
            const double u0 = -q * s->sine / a, v0 = q * s->cosine / b;
            const double du = (s->cosine + z * taper * s->sine) / a;
            const double dv = (s->sine - z * taper * s->cosine) / b;
            for (double p = 0.0, cut = least; p < s->length;) {
                const double to = fmin(fmin(next_whole(u0, du, p, reach),
                                            next_whole(v0, dv, p, reach)),
                                       fmin(cut, s->length));
                add_stretch(&l, false, p, to);
                p = to;
                if (to >= cut)
                    cut *= 1.5;
            }
            for (double p = 0.0, cut = r->width; p < CUT * r->width;) {
                const double to =
                    fmin(fmin(next_whole(u0, -s->cosine / a, p, reach),
                              next_whole(v0, -s->sine / b, p, reach)), cut);
                add_stretch(&l, true, -to, -p);
                p = to;
                if (to >= cut)
                    cut += r->width;
            }
        }
    }
}

static void points_row(const void *state, int x, int y, int n,
                       double *const out[3])
{
    const struct rays *const r = state;
    gp_deposit_row(&r->points, 3, x, y, n, out);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < n; i++)
            out[c][i] *= r->tint[c];
    }
}

// -- pixels that resolve strands ----------------------------------------------

/* Makes row i of the samples, and where opposite rays are alike the one
 * opposite to it. */
static void make_row(void *ctx, int i, int thread)
{
    const struct rays *const r = ctx;
    const int y = i - r->ry, n = 2 * r->rx + 1, opposite = 2 * r->ry - i;
    const size_t at = (size_t) i * (size_t) n;
    const bool both = r->even && i != opposite;
    double sums[3] = {0};
    (void) thread;
    const double b = r->f.degrees;
    const double a = b * r->f.aspect / r->squeeze; // in the plane of strands
    const double v = b * y, side = CUT * r->width + a + b;
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
        const int first = (int) fmax(ceil(from / a), -r->rx);
        const int last = (int) fmin(floor(to / a), r->rx);
        for (int x = first; x <= last; x++) {
            double sum[3] = {0};
            add_pixel(r, s, a * x, v, a, b, sum);
            for (int c = 0; c < 3; c++) {
                r->sample[c][at + (size_t) (x + r->rx)] += (float) sum[c];
                sums[c] += sum[c];
            }
        }
    }
    memcpy(r->row_sum[i], sums, sizeof sums);
    for (int c = 0; c < 3 && both; c++) {
        float *const to = r->sample[c] + (size_t) opposite * (size_t) n;
        for (int x = 0; x < n; x++)
            to[n - 1 - x] = r->sample[c][at + (size_t) x];
        r->row_sum[opposite][c] = sums[c];
    }
}

static void rays_row(const void *state, int x, int y, int n,
                     double *const out[3])
{
    const struct rays *const r = state;
    const size_t at = (size_t) (y + r->ry) * (2 * (size_t) r->rx + 1) +
                      (size_t) (x + r->rx);
    for (int i = 0; i < n; i++) {
        const bool inside = abs(y) <= r->ry && abs(x + i) <= r->rx;
        for (int c = 0; c < 3; c++)
            out[c][i] = inside ? r->tint[c] * (double) r->sample[c][at +
                                                  (size_t) i] : 0.0;
    }
}

static void rays_free(void *state)
{
    struct rays *const r = state;
    gp_deposit_free(&r->points);
    gp_free(r->sample[0]);
    gp_free(r->row_sum);
    gp_free(r);
}

/* A strand's light at share t of its length, at one wavelength. */
static double curve_of(double nm, double t, double core, double dispersion)
{
    const double scale = 1.0 + dispersion * (550.0 / nm - 1.0);
    const double at = t * scale / core, end = pow(fmax(1.0 - t, 0.0), 8.0);
    return end * scale / (1.0 + at * at);
}

/* g_c by wavelengths, of integral 1 in each channel, for strands of length 1;
 * what their round ends add is in their gains. Every wavelength has its light,
 * so that a strand is white in sum, in all primaries. */
static void make_curves(struct rays *r, double core, double dispersion)
{
    double nm[BANDS], rgb[BANDS][3], sum[3] = {0}, light[BANDS] = {0};
    gp_spectrum_colours(r->f.chromaticities, BANDS, nm, rgb);
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
        gp_gamut_fold(r->f.luminance, v);
        for (int c = 0; c < 3; c++) {
            r->curve[c][i] = v[c];
            sum[c] += v[c] * (i == 0 ? 0.5 : 1.0) / TABLE;
        }
    }
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i <= TABLE + 1; i++)
            r->curve[c][i] /= sum[c];
        for (int i = 0; i <= TABLE; i++)
            r->within[c][i + 1] = r->within[c][i] + 0.5 / TABLE *
                                  (r->curve[c][i] + r->curve[c][i + 1]);
    }
}

/* The samples at full rate, and the light of each channel in them. */
static gp_status make_samples(const struct gp_log *log, struct rays *s,
                              double light[3])
{
    const size_t rows = 2 * (size_t) s->ry + 1;
    const size_t samples = rows * (2 * (size_t) s->rx + 1);
    gp_status st = gp_alloc_zero(log, "kernel", 3 * samples, sizeof(float),
                                 &s->sample[0]);
    if (!st)
        st = gp_alloc(log, "kernel", rows, sizeof *s->row_sum, &s->row_sum);
    if (st)
        return st;
    s->sample[1] = s->sample[0] + samples;
    s->sample[2] = s->sample[1] + samples;
    gp_parallel_do(s->even ? s->ry + 1 : (int) rows, make_row, s);
    for (size_t i = 0; i < rows; i++) {
        for (int c = 0; c < 3; c++)
            light[c] += s->row_sum[i][c];
    }
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
        one->cosine = cos(angle);
        one->sine = -sin(angle);
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
    double m[9], y = 0.0;
    memcpy(tint, own, sizeof own);
    if (memcmp(f->chromaticities, gp_rec709_chromaticities,
               sizeof gp_rec709_chromaticities) != 0 &&
        gp_spectrum_to_spectrum(gp_rec709_chromaticities, f->chromaticities, m))
        for (int c = 0; c < 3; c++)
            tint[c] = m[3 * c] * own[0] + m[3 * c + 1] * own[1] +
                      m[3 * c + 2] * own[2];
    gp_gamut_fold(f->luminance, tint);
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * tint[c];
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
    struct rays *s;
    gp_status st = gp_alloc_zero(log, "kernel", 1, sizeof *s, &s);
    if (st)
        return st;
    s->f = *f;
    s->width = gp_recipe_value(r, "width");
    s->squeeze = gp_recipe_value(r, "squeeze");
    make_curves(s, gp_recipe_value(r, "core") / gp_recipe_value(r, "length"),
                gp_recipe_value(r, "dispersion"));
    lay_strands(r, f->rotate, s);
    // samples as far as a strand goes and the field needs them
    const double b = f->degrees, a = b * f->aspect / s->squeeze;
    double wide = 0.0, high = 0.0;
    for (int i = 0; i < s->n; i++) {
        const struct strand *const one = &s->strand[i];
        wide = fmax(wide, fabs(one->length * one->cosine));
        high = fmax(high, fabs(one->length * one->sine));
    }
    wide = ceil((wide + CUT * s->width) / a) + 1.0;
    high = ceil((high + CUT * s->width) / b) + 1.0;
    const bool cut = wide > f->w - 1 || high > f->h - 1;
    s->rx = (int) fmin(wide, f->w - 1);
    s->ry = (int) fmin(high, f->h - 1);
    // points hold all of a strand's light, of samples only those in the field
    const bool coarse = fmax(a, b) > WIDE * s->width;
    double light[3] = {0};
    if (coarse) {
        GP_TRY(gp_deposit_make(log, s->rx, s->ry, &s->points));
        for (int i = 0; i < s->n; i++)
            add_strand(s, &s->strand[i], gp_recipe_value(r, "core"), a, b);
    } else {
        GP_TRY(make_samples(log, s, light));
    }
    // all the light where it all is in them; else by the strands' integrals, a
    // round end being as much as width sqrt(pi / 2) of the strand there
    if (coarse || cut)
        memset(light, 0, sizeof light);
    for (int i = 0; i < s->n && (coarse || cut); i++) {
        const double end = s->width * sqrt(0.5 * M_PI) / s->strand[i].length;
        for (int c = 0; c < 3; c++)
            light[c] += s->strand[i].gain * (1.0 + end * s->curve[c][0]);
    }
    double tint[3];
    GP_TRY(find_tint(log, r, f, tint));
    for (int c = 0; c < 3; c++)
        s->tint[c] = light[c] > 0.0 ? tint[c] / light[c] : 0.0;
    *out = (struct gp_shape) {
        .state = s, .free = rays_free,
        .row = coarse ? points_row : rays_row, .smooth = INFINITY,
        .reach = gp_max(s->rx, s->ry),
    };
    return GP_OK;
out:
    rays_free(s);
    return st;
}

#define KEYS(share, points, strands, spread, length, core, width, angle,      \
             dispersion, squeeze, r, g, b)                                    \
    GP_MODEL_SHARE(share),                                                    \
    {"points", "rays", points, 1, 32, NULL, false},                           \
    {"strands", "strands of each ray", strands, 1, 16, NULL, false},          \
    {"spread", "angle to which strands fan out on each side, degrees", spread, \
     0, 90, NULL, false},                                                     \
    {"length", "degrees of view from the light to a ray's end, to which it "   \
     "fades: a half is seen of a bright lamp", length, 0.01, 180, NULL,        \
     false},                                                       \
    {"core", "distance at which it has fallen to a half, degrees", core,      \
     0.001, 180, NULL, false},                                                \
    {"width", "thickness at the light (one sigma), degrees", width, 0.002,    \
     10, NULL, false},                                                        \
    {"angle", "direction of the first ray, degrees counter-clockwise", angle, \
     -360, 360, NULL, false},                                                 \
    {"dispersion", "growth with wavelength, 0 none to 1 as diffraction",      \
     dispersion, 0, 1, NULL, false},                                          \
    {"squeeze", "how many times as wide as high: an anamorphic lens",         \
     squeeze, 0.1, 20, NULL, false},                                          \
    {"red", "its colour, BT.709", r, 0, 1, NULL, false},                                  \
    {"green", "its colour, BT.709", g, 0, 1, NULL, false},                                \
    {"blue", "its colour, BT.709", b, 0, 1, NULL, false},                                 \
    {"seed", "which strands", 1, 0, 1e9, NULL, false},                        \
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
