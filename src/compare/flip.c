// SPDX-License-Identifier: Apache-2.0
/* FLIP. LDR: tile after tile, each picture is filtered in a tile with its
 * surroundings, its colours and features are kept, and compared with those of
 * the other. HDR: the largest LDR-FLIP of many exposures. */
#include "compare/compare.h"

#include "core/colour.h"
#include "core/cpu.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

// -- filters -----------------------------------------------------------------

/* Pixels a degree: compare.h. */
static const double PPD = (double) 67.0206f;

/* The filters of FLIP: the eye's resolution, and its detectors of edges and
 * points. All are separable. They reach three standard deviations of the widest
 * Gaussian, sqrt(0.04 / (2 pi^2)) degrees, and of the detectors, which are
 * narrower. */
enum { RADIUS = 10, TAPS = 2 * RADIUS + 1 };
enum { NARROW = 9, NARROW_TAPS = 2 * NARROW + 1 };

/* Contrast sensitivity of the opponent channels (section 4.1.1): Gaussians,
 * for blue-yellow the sum of two. Each sums to 1. */
enum { ACHROMATIC, RED_GREEN, BLUE_YELLOW, BLUE_YELLOW_2, COLOURS };

/* Detectors (section 4.2): a Gaussian and its first two derivatives. The
 * Gaussian sums to 1, the derivatives' positive and negative taps to 1 each. */
enum { BLUR, EDGES, POINTS, FEATURES };

struct filters {
    float colour[COLOURS][TAPS];
    float feature[FEATURES][NARROW_TAPS];
    float share[2]; // of the two blue-yellow Gaussians; sum 1
};

/* Table 1 of the paper: a * sqrt(pi / b) * exp(-pi^2 x^2 / b), x in degrees. */
static const struct {
    double a, b;
} gaussian[COLOURS] = {
    [ACHROMATIC] = {1.0, 0.0047},
    [RED_GREEN] = {1.0, 0.0053},
    [BLUE_YELLOW] = {34.1, 0.04},
    [BLUE_YELLOW_2] = {13.5, 0.025},
};

/* Scales positive and negative taps to a sum of 1 each; returns the sum of the
 * positive ones. */
static double normalise(const double *tap, int n, float *out)
{
    double above = 0.0, below = 0.0;
    for (int i = 0; i < n; i++) {
        above += tap[i] > 0.0 ? tap[i] : 0.0;
        below -= tap[i] < 0.0 ? tap[i] : 0.0;
    }
    for (int i = 0; i < n; i++)
        out[i] = (float) (tap[i] / (tap[i] < 0.0 ? below : above));
    return above;
}

static void make_filters(struct filters *f)
{
    // section 4.2: degrees from peak to trough, two standard deviations
    const double sigma = 0.5 * 0.082 * PPD, s2 = sigma * sigma;
    double tap[FEATURES][TAPS], volume[COLOURS];
    for (int c = 0; c < COLOURS; c++) {
        for (int i = -RADIUS; i <= RADIUS; i++) {
            const double x = i / PPD;
            tap[0][i + RADIUS] = exp(-M_PI * M_PI * x * x / gaussian[c].b);
        }
        const double sum = normalise(tap[0], TAPS, f->colour[c]);
        volume[c] = gaussian[c].a * sqrt(M_PI / gaussian[c].b) * sum * sum;
    }
    const double both = volume[BLUE_YELLOW] + volume[BLUE_YELLOW_2];
    f->share[0] = (float) (volume[BLUE_YELLOW] / both);
    f->share[1] = (float) (volume[BLUE_YELLOW_2] / both);
    for (int i = -NARROW; i <= NARROW; i++) {
        const double g = exp(-(double) i * i / (2.0 * s2));
        tap[BLUR][i + NARROW] = g;
        tap[EDGES][i + NARROW] = -i * g;
        tap[POINTS][i + NARROW] = ((double) i * i / s2 - 1.0) * g;
    }
    for (int k = 0; k < FEATURES; k++)
        (void) normalise(tap[k], NARROW_TAPS, f->feature[k]);
}

/* out[i] += weight * sum over t of tap[t] * in[t * pitch + i]. */
GP_CLONES static void filter(const float *in, int pitch, const float *tap,
                             int taps, float weight, int n, float *restrict out)
{
    for (int t = 0; t < taps; t++) {
        const float k = weight * tap[t];
        const float *const from = in + (long) t * pitch;
        for (int i = 0; i < n; i++)
            out[i] += k * from[i];
    }
}

// -- tiles -------------------------------------------------------------------

enum { TILE_W = 128, TILE_H = 64, TILE = TILE_W * TILE_H };

/* Lines of a tile that are filtered along x: colours, then features. */
enum { LINES = COLOURS + FEATURES };

/* Planes of a filtered picture: Hunt-adjusted L*a*b*, and the magnitudes of
 * edges and points. */
enum { L, A, B, EDGE, POINT, SEEN };

struct metric {
    int w, h, across;              // the picture; tiles in a row
    const struct gp_planes *picture[2];
    struct filters filter;
    float to_xyz[9], to_rgb[9];    // BT.709 and XYZ over that of white
    float most;                    // largest colour difference, raised
    struct tile *tile;             // of each thread
    float scale;                   // of the present exposure; 0: display-linear
    float *map;                    // the largest of all exposures
};

/* A tile under way; rows of TILE_W. */
struct tile {
    int x0, y0, w, h;
    float row[3][TILE_W + 2 * RADIUS]; // opponent colours of a row, padded
    float line[LINES][(TILE_H + 2 * RADIUS) * TILE_W];
    float seen[2][SEEN][TILE];         // of each picture
};

// Section 4.1.3 of the paper: q_c, p_c and p_t
static const float COLOUR_POWER = 0.7f, KNEE_AT = 0.4f, KNEE_TO = 0.95f;

// -- colour ------------------------------------------------------------------

static void multiply(const float m[9], const float in[3], float out[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = m[3 * i] * in[0] + m[3 * i + 1] * in[1] + m[3 * i + 2] * in[2];
}

/* CIE 1976, with 6/29 as the border of the linear part. */
static float lab_curve(float t)
{
    const float border = 6.0f / 29.0f;
    return t > border * border * border
               ? cbrtf(t) : t / (3.0f * border * border) + 4.0f / 29.0f;
}

/* Linear BT.709 to L*a*b* whose a* and b* grow with L* (section 4.1.2). */
static void to_hunt_lab(const struct metric *m, const float rgb[3],
                        float lab[3])
{
    float xyz[3];
    multiply(m->to_xyz, rgb, xyz);
    const float x = lab_curve(xyz[0]), y = lab_curve(xyz[1]);
    const float z = lab_curve(xyz[2]);
    lab[0] = 116.0f * y - 16.0f;
    lab[1] = 0.01f * lab[0] * 500.0f * (x - y);
    lab[2] = 0.01f * lab[0] * 200.0f * (y - z);
}

/* HyAB distance, section 4.1.3. */
static float distance(const float a[3], const float b[3])
{
    const float da = a[1] - b[1], db = a[2] - b[2];
    return fabsf(a[0] - b[0]) + sqrtf(da * da + db * db);
}

/* Narkowicz, ACES Filmic Tone Mapping Curve (2016): (x (a x + b)) /
 * (x (c x + d) + e), with x times 0.6 as Andersson et al. 2021 take it. */
static const float ACES_A = 0.6f * 0.6f * 2.51f, ACES_B = 0.6f * 0.03f;
static const float ACES_C = 0.6f * 0.6f * 2.43f, ACES_D = 0.6f * 0.59f;
static const float ACES_E = 0.14f;

#define TARGET 0.85     // the largest and the median luminance map to this
#define LIGHT_MAX 1e15f // beyond, all is white; its square is finite

/* Light as the curve takes it. */
static float bounded(float v)
{
    return v > 0.0f ? (v < LIGHT_MAX ? v : LIGHT_MAX) : 0.0f; // NaN is 0
}

/* A sample as the display shows it. */
static float shown(const struct metric *m, float v)
{
    if (m->scale == 0.0f)
        return gp_clamp01(v);
    const float x = bounded(bounded(v) * m->scale);
    const float y =
        x * (ACES_A * x + ACES_B) / (x * (ACES_C * x + ACES_D) + ACES_E);
    return y < 1.0f ? y : 1.0f;
}

// -- one picture in a tile ---------------------------------------------------

/* Filters a picture in a tile. The lines along x hold the opponent colours
 * YCxCz without their factors, which the way back would take away again: Y,
 * X - Y, Y - Z over white's; beyond the border the outermost pixels are
 * repeated. */
static void resolve(const struct metric *m, struct tile *t, int picture)
{
    static const int plane[COLOURS] = {0, 1, 2, 2};
    const struct gp_planes *const p = m->picture[picture];
    const struct filters *const f = &m->filter;
    const int r = RADIUS, inset = RADIUS - NARROW;
    for (int j = 0; j < t->h + 2 * r; j++) {
        const size_t row = (size_t) gp_clamp(t->y0 - r + j, 0, m->h - 1);
        for (int i = 0; i < t->w + 2 * r; i++) {
            const size_t at = row * (size_t) m->w +
                              (size_t) gp_clamp(t->x0 - r + i, 0, m->w - 1);
            const float rgb[3] = {shown(m, p->c[0][at]), shown(m, p->c[1][at]),
                                  shown(m, p->c[2][at])};
            float xyz[3];
            multiply(m->to_xyz, rgb, xyz);
            t->row[0][i] = xyz[1];
            t->row[1][i] = xyz[0] - xyz[1];
            t->row[2][i] = xyz[1] - xyz[2];
        }
        for (int k = 0; k < LINES; k++)
            memset(t->line[k] + j * TILE_W, 0, TILE_W * sizeof(float));
        for (int c = 0; c < COLOURS; c++)
            filter(t->row[plane[c]], 1, f->colour[c], TAPS, 1.0f, t->w,
                   t->line[c] + j * TILE_W);
        for (int k = 0; k < FEATURES; k++)
            filter(t->row[0] + inset, 1, f->feature[k], NARROW_TAPS, 1.0f, t->w,
                   t->line[COLOURS + k] + j * TILE_W);
    }
    const float weight[COLOURS] = {1.0f, 1.0f, f->share[0], f->share[1]};
    for (int j = 0; j < t->h; j++) {
        float(*const seen)[TILE] = t->seen[picture];
        const int at = j * TILE_W, top = at + inset * TILE_W;
        float sum[3][TILE_W] = {0};
        // colours as the eye resolves them
        for (int c = 0; c < COLOURS; c++)
            filter(t->line[c] + at, TILE_W, f->colour[c], TAPS, weight[c], t->w,
                   sum[plane[c]]);
        for (int i = 0; i < t->w; i++) {
            const float y = sum[0][i];
            const float xyz[3] = {y + sum[1][i], y, y - sum[2][i]};
            float rgb[3], lab[3];
            multiply(m->to_rgb, xyz, rgb);
            for (int c = 0; c < 3; c++)
                rgb[c] = gp_clamp01(rgb[c]);
            to_hunt_lab(m, rgb, lab);
            for (int c = 0; c < 3; c++)
                seen[L + c][at + i] = lab[c];
        }
        // magnitudes of each detector along x and along y
        for (int k = EDGES; k <= POINTS; k++) {
            float x[TILE_W] = {0}, y[TILE_W] = {0};
            filter(t->line[COLOURS + k] + top, TILE_W, f->feature[BLUR],
                   NARROW_TAPS, 1.0f, t->w, x);
            filter(t->line[COLOURS + BLUR] + top, TILE_W, f->feature[k],
                   NARROW_TAPS, 1.0f, t->w, y);
            for (int i = 0; i < t->w; i++)
                seen[EDGE + k - EDGES][at + i] =
                    sqrtf(x[i] * x[i] + y[i] * y[i]);
        }
    }
}

// -- both --------------------------------------------------------------------

/* Sections 4.1.3 (colour), 4.2 (features) and 4.3 (both). */
static float difference(const struct metric *m, const struct tile *t, int at)
{
    const float(*const a)[TILE] = t->seen[0], (*const b)[TILE] = t->seen[1];
    const float lab_a[3] = {a[L][at], a[A][at], a[B][at]};
    const float lab_b[3] = {b[L][at], b[A][at], b[B][at]};
    const float e = powf(distance(lab_a, lab_b), COLOUR_POWER);
    const float knee = KNEE_AT * m->most;
    const float colour =
        e < knee ? KNEE_TO / knee * e
                 : KNEE_TO + (e - knee) / (m->most - knee) * (1.0f - KNEE_TO);
    const float edge = fabsf(a[EDGE][at] - b[EDGE][at]);
    const float point = fabsf(a[POINT][at] - b[POINT][at]);
    const float feature =
        sqrtf((edge > point ? edge : point) * (float) M_SQRT1_2); // q_f = 0.5
    return gp_clamp01(powf(gp_clamp01(colour), 1.0f - gp_clamp01(feature)));
}

static void compare_tile(void *ctx, int i, int thread)
{
    const struct metric *m = ctx;
    struct tile *const t = &m->tile[thread];
    t->x0 = i % m->across * TILE_W;
    t->y0 = i / m->across * TILE_H;
    t->w = gp_min(m->w - t->x0, TILE_W);
    t->h = gp_min(m->h - t->y0, TILE_H);
    resolve(m, t, 0);
    resolve(m, t, 1);
    for (int y = 0; y < t->h; y++) {
        float *const to = m->map + (size_t) (t->y0 + y) * (size_t) m->w + t->x0;
        for (int x = 0; x < t->w; x++)
            to[x] = gp_maxf(difference(m, t, y * TILE_W + x), to[x]);
    }
}

gp_status gp_flip(const struct gp_log *log, int w, int h,
                  const struct gp_planes *a, const struct gp_planes *b,
                  const struct gp_flip_exposures *e, float *map, double *mean)
{
    const struct gp_flip_exposures all =
        e ? *e : (struct gp_flip_exposures) {.count = 1};
    struct metric m = {.w = w, .h = h, .across = (w + TILE_W - 1) / TILE_W,
                       .picture = {a, b}, .map = map};
    const int tiles = m.across * ((h + TILE_H - 1) / TILE_H);
    const size_t n = (size_t) w * (size_t) h;
    double xyz[9], rgb[9], sum = 0.0;
    if (all.count < 1 || all.count > GP_FLIP_EXPOSURES_MAX ||
        !isfinite(all.start) || !isfinite(all.stop))
        return gp_fail(log, GP_ERR_USAGE,
                       "flip: exposures out of range (found "
                       "%d from %g to %g); give 1 to %d of finite EV",
                       all.count, (double) all.start, (double) all.stop,
                       GP_FLIP_EXPOSURES_MAX);
    // matrices between linear BT.709 and XYZ over that of white
    (void) gp_rgb_to_xyz(gp_rec709_chromaticities, xyz); // cannot fail
    for (int i = 0; i < 3; i++) {
        const double white = xyz[3 * i] + xyz[3 * i + 1] + xyz[3 * i + 2];
        for (int j = 0; j < 3; j++)
            xyz[3 * i + j] /= white;
    }
    gp_invert3(xyz, rgb);
    for (int i = 0; i < 9; i++) {
        m.to_xyz[i] = (float) xyz[i];
        m.to_rgb[i] = (float) rgb[i];
    }
    // green and blue are the two colours farthest apart
    static const float green[3] = {0.0f, 1.0f, 0.0f}, blue[3] = {0, 0, 1.0f};
    float lab[2][3];
    to_hunt_lab(&m, green, lab[0]);
    to_hunt_lab(&m, blue, lab[1]);
    m.most = powf(distance(lab[0], lab[1]), COLOUR_POWER);
    make_filters(&m.filter);
    const gp_status st =
        gp_alloc(log, "flip", (size_t) gp_threads(), sizeof *m.tile, &m.tile);
    if (st)
        return st;
    memset(map, 0, n * sizeof *map);
    for (int i = 0; i < all.count; i++) {
        const double start = (double) all.start, stop = (double) all.stop;
        const double ev =
            i ? start + (stop - start) * i / (all.count - 1) : start;
        // factors that move any float in or out of sight are finite
        m.scale = e ? (float) exp2(fmin(fmax(ev, -120.0), 120.0)) : 0.0f;
        gp_parallel_do(tiles, compare_tile, &m);
    }
    for (size_t i = 0; i < n; i++)
        sum += (double) map[i];
    *mean = sum / (double) n;
    gp_free(m.tile);
    return GP_OK;
}

// -- exposures ---------------------------------------------------------------

/* Finds the median of the n largest of `pixels` luminances; of an even number
 * the mean of the two in the middle. */
static gp_status median(const struct gp_log *log, const struct gp_image *f,
                        size_t pixels, size_t n, double *out)
{
    float upper, lower;
    gp_status st;
    GP_TRY(gp_luminance_rank(log, f, pixels - n + n / 2 + 1, &upper));
    GP_TRY(gp_luminance_rank(log, f, pixels - n + (n + 1) / 2, &lower));
    *out = 0.5 * ((double) lower + (double) upper);
out:
    return st;
}

gp_status gp_flip_exposures_find(const struct gp_log *log, size_t pixels,
    const struct gp_planes *reference, struct gp_flip_exposures *out)
{
    struct gp_image f = gp_image_blank((struct gp_rect) {0, 0, (int) pixels, 1});
    int at[2];
    double middle;
    gp_status st;
    f.rgb = *reference;
    const float most = gp_minf(gp_luminance_peak(&f, at), LIGHT_MAX);
    *out = (struct gp_flip_exposures) {.count = 1};
    if (!(most > 0.0f))
        return GP_OK;
    GP_TRY(median(log, &f, pixels, pixels, &middle));
    if (middle == 0.0) {
        const float *const k = f.luminance;
        size_t lit = 0;
        for (size_t i = 0; i < pixels; i++)
            lit += gp_lit_luminance(k, f.rgb.c[0][i], f.rgb.c[1][i],
                                    f.rgb.c[2][i]) > 0.0f;
        GP_TRY(median(log, &f, pixels, lit, &middle));
    }
    // the x for which the curve gives TARGET: its quadratic's positive root
    const double a = (double) ACES_A - TARGET * (double) ACES_C;
    const double b = (double) ACES_B - TARGET * (double) ACES_D;
    const double c = -TARGET * (double) ACES_E;
    const double target = (-b + sqrt(b * b - 4.0 * a * c)) / (2.0 * a);
    const double start = log2(target / (double) most);
    const double stop = log2(target / fmin(middle, (double) LIGHT_MAX));
    *out = (struct gp_flip_exposures) {
        (float) start, (float) stop,
        (int) fmin(fmax(ceil(stop - start), 2.0), GP_FLIP_EXPOSURES_MAX),
    };
out:
    return st;
}
