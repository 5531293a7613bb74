// SPDX-License-Identifier: Apache-2.0
/* Visible pixels: Yee, A Perceptual Metric for Production Testing, journal of
 * graphics tools 9(4), 2004, as idiff -p counts them. A difference of luminance
 * is seen over a threshold, which light around and details that mask it raise;
 * then one of colour. Both pictures are seen with 1.0 shown as 100 cd/m2, over a
 * field of view of 45 degrees. */
#include "compare/compare.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

/* Luminance at full resolution, blurred once more from level to level by a
 * kernel of 5x5; the levels are octaves of spatial frequency. A tile is
 * made with the surroundings that its last level needs. */
enum { LEVELS = 8, BANDS = LEVELS - 2, REACH = 2, TILE = 64 };
enum { MARGIN = REACH * (LEVELS - 1), SIDE = TILE + 2 * MARGIN };
struct tile {
    float level[2][LEVELS][SIDE][SIDE]; // of a and b, cd/m2
    float rows[SIDE][SIDE];             // a level blurred along x
    long long seen;                     // pixels, in all of a thread's tiles
};

static const double DISPLAY_WHITE = 100.0; // cd/m2
static const double FIELD = 45.0;          // degrees

struct view {
    int w, h;
    const struct gp_planes *image[2];
    struct tile *tile;        // of each thread
    double frequency[BANDS];  // cycles a degree
    double sharpness[BANDS];  // of the eye there, to that at its best
    int adaptation;           // level that is a degree wide
};

// -- the eye -----------------------------------------------------------------

/* Contrast sensitivity at `cycles` a degree (Barten, SPIE 1989). */
static double sensitivity(double cycles, double luminance)
{
    const double a = 440.0 * pow(1.0 + 0.7 / luminance, -0.2);
    const double b = 0.3 * pow(1.0 + 100.0 / luminance, 0.15);
    return a * cycles * exp(-b * cycles) * sqrt(1.0 + 0.06 * exp(b * cycles));
}

/* The share by which a pattern hides another (Daly 1993). */
static double masking(double contrast)
{
    const double a = pow(392.498 * contrast, 0.7);
    return pow(1.0 + pow(0.0153 * a, 4.0), 0.25);
}

/* The least difference that is seen, in cd/m2, at an adaptation luminance in
 * cd/m2 (Ward Larson et al. 1997). */
static double threshold(double adaptation)
{
    const double x = log10(adaptation);
    return pow(10.0, x < -3.94     ? -2.86
                     : x < -1.44   ? pow(0.405 * x + 1.6, 2.18) - 2.86
                     : x < -0.0184 ? x - 0.395
                     : x < 1.9     ? pow(0.249 * x + 0.65, 2.7) - 0.72
                                   : x - 1.255);
}

/* CIE a* and b* of linear BT.709. */
static void opponents(const float rgb[3], double ab[2])
{
    // IEC 61966-2-1
    static const double xyz[3][3] = {
        {0.4124, 0.3576, 0.1805},
        {0.2126, 0.7152, 0.0722},
        {0.0193, 0.1192, 0.9505},
    };
    double f[3];
    for (int i = 0; i < 3; i++) {
        double sum = 0.0, white = 0.0;
        for (int c = 0; c < 3; c++) {
            sum += xyz[i][c] * (double) rgb[c];
            white += xyz[i][c];
        }
        const double t = sum / white;
        f[i] = t > 216.0 / 24389.0 ? cbrt(t)
                                   : (24389.0 / 27.0 * t + 16.0) / 116.0;
    }
    ab[0] = 500.0 * (f[0] - f[1]);
    ab[1] = 200.0 * (f[1] - f[2]);
}

// -- tiles -------------------------------------------------------------------

/* Fills the levels; beyond the border the outermost pixels are repeated. */
static void make_levels(const struct view *v, int x0, int y0, struct tile *t)
{
    static const float kernel[] = {0.05f, 0.25f, 0.4f, 0.25f, 0.05f};
    for (int k = 0; k < 2; k++) {
        float (*const level)[SIDE][SIDE] = t->level[k];
        float *const *const light = v->image[k]->c;
        for (int y = 0; y < SIDE; y++) {
            const int from = gp_min(gp_max(y0 - MARGIN + y, 0), v->h - 1);
            for (int x = 0; x < SIDE; x++) {
                const int at = gp_min(gp_max(x0 - MARGIN + x, 0), v->w - 1);
                const size_t i = (size_t) from * (size_t) v->w + (size_t) at;
                const float lum = 0.2126f * light[0][i] +
                                  0.7152f * light[1][i] + 0.0722f * light[2][i];
                level[0][y][x] =
                    lum > 0.0f ? (float) DISPLAY_WHITE * lum : 0.0f;
            }
        }
        for (int n = 1; n < LEVELS; n++) {
            const int edge = REACH * n;
            for (int y = edge - REACH; y < SIDE - edge + REACH; y++) {
                for (int x = edge; x < SIDE - edge; x++) {
                    float sum = 0.0f;
                    for (int i = -REACH; i <= REACH; i++)
                        sum += kernel[i + REACH] * level[n - 1][y][x + i];
                    t->rows[y][x] = sum;
                }
            }
            for (int y = edge; y < SIDE - edge; y++) {
                for (int x = edge; x < SIDE - edge; x++) {
                    float sum = 0.0f;
                    for (int i = -REACH; i <= REACH; i++)
                        sum += kernel[i + REACH] * t->rows[y + i][x];
                    level[n][y][x] = sum;
                }
            }
        }
    }
}

/* True when the pixel at x, y of the tile is seen to differ: its colours are a
 * and b, one of which has other bits. */
static bool is_seen(const struct view *v, const struct tile *t, int x, int y,
                    const float a[3], const float b[3])
{
    double lum[2][LEVELS], contrast[BANDS], sum = 0.0, factor = 0.0;
    double of_a[2], of_b[2];
    for (int n = 0; n < LEVELS; n++) {
        for (int k = 0; k < 2; k++)
            lum[k][n] = (double) t->level[k][n][y][x];
    }
    for (int n = 0; n < BANDS; n++) {
        const double step = fmax(fabs(lum[0][n] - lum[0][n + 1]),
                                 fabs(lum[1][n] - lum[1][n + 1]));
        contrast[n] = step / fmax(fmax(lum[0][n + 2], lum[1][n + 2]), 1e-5);
        sum += contrast[n];
    }
    const double adapt = fmax(0.5 * (lum[0][v->adaptation] +
                                     lum[1][v->adaptation]), 1e-5);
    for (int n = 0; n < BANDS; n++)
        factor += contrast[n] / fmax(sum, 1e-5) / v->sharpness[n] *
                  masking(contrast[n] * sensitivity(v->frequency[n], adapt));
    factor = fmin(fmax(factor, 1.0), 10.0);
    if (fabs(lum[0][0] - lum[1][0]) > factor * threshold(adapt))
        return true;
    // colour, of which the eye sees less in the dark
    opponents(a, of_a);
    opponents(b, of_b);
    const double da = of_a[0] - of_b[0], db = of_a[1] - of_b[1];
    const double dim = adapt < 10.0 ? 0.1 * 0.1 : 1.0;
    return (da * da + db * db) * dim > factor;
}

static void count_tile(void *ctx, int index, int thread)
{
    struct view *const v = ctx;
    struct tile *const t = &v->tile[thread];
    const int across = (v->w + TILE - 1) / TILE;
    const int x0 = index % across * TILE, y0 = index / across * TILE;
    bool levels = false; // most tiles of two pictures are equal
    for (int y = y0; y < gp_min(y0 + TILE, v->h); y++) {
        for (int x = x0; x < gp_min(x0 + TILE, v->w); x++) {
            const size_t i = (size_t) y * (size_t) v->w + (size_t) x;
            float rgb[2][3];
            bool nan[2] = {false, false};
            for (int k = 0; k < 2; k++) {
                for (int c = 0; c < 3; c++) {
                    rgb[k][c] = v->image[k]->c[c][i];
                    nan[k] = nan[k] || isnan(rgb[k][c]);
                }
            }
            if (nan[0] || nan[1] || memcmp(rgb[0], rgb[1], sizeof *rgb) == 0) {
                t->seen += nan[0] != nan[1];
                continue;
            }
            if (!levels)
                make_levels(v, x0, y0, t);
            levels = true;
            t->seen +=
                is_seen(v, t, x - x0 + MARGIN, y - y0 + MARGIN, rgb[0], rgb[1]);
        }
    }
}

gp_status gp_compare_see(const struct gp_log *log,
                         const struct gp_compare_match *m, long long *seen)
{
    struct gp_planes a = {0}, b = {0};
    struct view v = {
        .w = gp_rect_w(m->window), .h = gp_rect_h(m->window),
        .image = {&a, &b},
    };
    const int threads = gp_threads();
    const int tiles = ((v.w + TILE - 1) / TILE) * ((v.h + TILE - 1) / TILE);
    gp_status st;
    GP_TRY(gp_compare_light(log, m, m->a, true, &a));
    GP_TRY(gp_compare_light(log, m, m->b, true, &b));
    GP_TRY(
        gp_alloc_zero(log, "tiles", (size_t) threads, sizeof *v.tile, &v.tile));
    // pixels of a display, one unit away, that is as wide as the field
    const double degrees = 2.0 * tan(0.5 * FIELD * M_PI / 180.0) * 180.0 / M_PI;
    for (int n = 0; n < BANDS; n++) {
        v.frequency[n] = 0.5 * v.w / degrees / (double) (1 << n);
        v.sharpness[n] = sensitivity(v.frequency[n], 100.0) /
                         sensitivity(3.248, 100.0);
    }
    while (v.adaptation < LEVELS - 1 && 2 << v.adaptation <= degrees)
        v.adaptation++;
    gp_parallel_do(tiles, count_tile, &v);
    *seen = 0;
    for (int i = 0; i < threads; i++)
        *seen += v.tile[i].seen;
out:
    gp_free(v.tile);
    gp_planes_free(&a);
    gp_planes_free(&b);
    return st;
}
