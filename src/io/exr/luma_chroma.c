// SPDX-License-Identifier: Apache-2.0
#include "io/exr/exr_priv.h"

#include "core/cpu.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "core/half.h"

#include <float.h>
#include <math.h>
#include <string.h>

enum {
    REACH = 13,  // taps lie at odd distances up to this
    TAPS = 14,
};

/* ImfRgbaYca.cpp, reconstructChromaHoriz(): taps at -13, -11, ... 13. */
static const float tap[TAPS] = {
    0.002128f,  -0.007540f, 0.019597f, -0.043159f, 0.087929f,
    -0.186077f, 0.627123f,  0.627123f, -0.186077f, 0.087929f,
    -0.043159f, 0.019597f,  -0.007540f, 0.002128f,
};

struct rows {
    const struct gp_yc *in;
    float *chroma[2];  // rows y / ys of RY and BY, all columns
    float *outside;    // R, G, B of the rows above and below the picture
    float *saturation; // of the picture's rows, and of those
    struct gp_planes *out;
};

static void keep_half(const struct gp_yc *in, float *row)
{
    for (int x = 0; in->half && x < in->w; x++)
        row[x] = gp_half_nearest(row[x]);
}

/* -- chroma --------------------------------------------------------------- */

/* Odd columns from the even ones; outside the row its ends are repeated. */
static void chroma_row(void *ctx, int i, int thread)
{
    const struct rows *r = ctx;
    const struct gp_yc *in = r->in;
    const int n = in->w / in->xs;
    const size_t w = (size_t) in->w, row = (size_t) i;
    (void) thread;
    for (int c = 0; c < 2; c++) {
        const float *from = (c ? in->by : in->ry) + row * (size_t) n;
        float *to = r->chroma[c] + row * w;
        for (int x = 0; x < n; x++) {
            const int first = x + 1 - TAPS / 2;
            float sum = from[gp_max(first, 0)] * tap[0];
            for (int k = 1; k < TAPS; k++)
                sum += from[gp_clamp(first + k, 0, n - 1)] * tap[k];
            to[2 * x] = from[x];
            to[2 * x + 1] = sum;
        }
        keep_half(in, to);
    }
}

/* RY or BY of row y: odd rows are filtered, rows outside repeat the ends. */
static void chroma_of_row(const struct rows *r, int c, int y, float *out)
{
    const struct gp_yc *const in = r->in;
    const size_t w = (size_t) in->w;
    const int last = in->h / 2 - 1;
    const float *source[TAPS];
    if (in->ys == 1) {
        memcpy(out,
               (c ? in->by : in->ry) + (size_t) gp_clamp(y, 0, in->h - 1) * w,
               w * sizeof *out);
        return;
    }
    if (y % 2 == 0) {
        memcpy(out, r->chroma[c] + (size_t) gp_min(y / 2, last) * w,
               w * sizeof *out);
        return;
    }
    for (int k = 0; k < TAPS; k++)
        source[k] = r->chroma[c] +
                    (size_t) gp_clamp((y - REACH) / 2 + k, 0, last) * w;
    for (size_t x = 0; x < w; x++) {
        float sum = source[0][x] * tap[0];
        for (int k = 1; k < TAPS; k++)
            sum += source[k][x] * tap[k];
        out[x] = sum;
    }
    keep_half(in, out);
}

/* -- colour --------------------------------------------------------------- */

GP_CLONES static void row_to_rgb(const float weight[3], const float *luma,
                                 float *r, float *g, float *b, int w)
{
    for (int x = 0; x < w; x++) {
        float ry = r[x], by = b[x], y = luma[x];
        bool grey = ry == 0.0f && by == 0.0f; // exact, whatever the weights
        float red = (ry + 1.0f) * y, blue = (by + 1.0f) * y;
        float green = (y - red * weight[0] - blue * weight[2]) / weight[1];
        r[x] = grey ? y : red;
        g[x] = grey ? y : green;
        b[x] = grey ? y : blue;
    }
}

// gp_maxf(b, a) is std::max(a, b): `a` where one is NaN; and so is the minimum
GP_CLONES static void find_saturation(const float *r, const float *g,
                                      const float *b, int w, float *out)
{
    for (int x = 0; x < w; x++) {
        float high = gp_maxf(gp_maxf(b[x], g[x]), r[x]);
        float low = gp_minf(gp_minf(b[x], g[x]), r[x]);
        out[x] = high > 0.0f ? 1.0f - low / high : 0.0f;
    }
}

/* Row i - 1 of the picture, in [-1, h], before saturation is fixed. */
static void colour_row(void *ctx, int i, int thread)
{
    const struct rows *rows = ctx;
    const struct gp_yc *in = rows->in;
    const int y = i - 1;
    const size_t w = (size_t) in->w;
    // luminance of a row outside is that of the chroma row in its place
    const int inside = gp_max(y >= in->h ? in->h - 2 : y, 0);
    float *rgb[3];
    (void) thread;
    for (int c = 0; c < 3; c++)
        rgb[c] = y < 0       ? rows->outside + (size_t) c * w
                 : y < in->h ? rows->out->c[c] + (size_t) y * w
                             : rows->outside + (size_t) (3 + c) * w;
    chroma_of_row(rows, 0, y, rgb[0]);
    chroma_of_row(rows, 1, y, rgb[2]);
    row_to_rgb(in->weight, in->y + (size_t) inside * w, rgb[0], rgb[1], rgb[2],
               in->w);
    for (int c = 0; c < 3; c++)
        keep_half(in, rgb[c]);
    find_saturation(rgb[0], rgb[1], rgb[2], in->w,
                    rows->saturation + (size_t) i * w);
}

/* fixSaturation() of a row. The mean is of the four diagonal neighbours; beside
 * the image its edge column counts. */
static void fix_row(void *ctx, int y, int thread)
{
    const struct rows *rows = ctx;
    const struct gp_yc *const in = rows->in;
    const int w = in->w;
    const float *const wt = in->weight;
    const float *const above = rows->saturation + (size_t) y * (size_t) w;
    const float *const own = above + w, *const below = own + w;
    (void) thread;
    for (int x = 0; x < w; x++) {
        int left = gp_max(x - 1, 0), right = gp_min(x + 1, w - 1);
        float mean = gp_minf(0.25f * (above[left] + above[right] +
                                      below[left] + below[right]), 1.0f);
        float s = own[x];
        float most = gp_minf(1.0f - (1.0f - mean) * 0.25f, 1.0f);
        if (!(s > mean && s > most))
            continue;
        size_t at = (size_t) y * (size_t) w + (size_t) x;
        float rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = rows->out->c[c][at];
        // towards the largest component, then back to its luminance
        float high = gp_maxf(gp_maxf(rgb[2], rgb[1]), rgb[0]);
        float before = rgb[0] * wt[0] + rgb[1] * wt[1] + rgb[2] * wt[2];
        for (int c = 0; c < 3; c++) {
            float v = gp_maxf(0.0f, high - (high - rgb[c]) * (most / s));
            rgb[c] = in->half ? gp_half_nearest(v) : v;
        }
        float after = rgb[0] * wt[0] + rgb[1] * wt[1] + rgb[2] * wt[2];
        for (int c = 0; c < 3; c++) {
            float v = after > 0.0f ? rgb[c] * (before / after) : rgb[c];
            rows->out->c[c][at] = in->half ? gp_half_nearest(v) : v;
        }
    }
}

gp_status gp_yc_to_rgb(const struct gp_log *log, const struct gp_yc *in,
                       struct gp_planes *out)
{
    gp_status st;
    const size_t w = (size_t) in->w, h = (size_t) in->h;
    // chroma of every pixel is not filtered, so that nothing rings
    const int chroma_rows = in->ys == 1 ? 0 : in->h / 2;
    struct rows rows = {.in = in, .out = out};
    for (int c = 0; c < 2; c++)
        GP_TRY(gp_alloc(log, "chroma", (size_t) chroma_rows * w, sizeof(float),
                        &rows.chroma[c]));
    GP_TRY(gp_alloc(log, "chroma", 6 * w, sizeof(float), &rows.outside));
    GP_TRY(gp_alloc(log, "chroma", (h + 2) * w, sizeof(float),
                    &rows.saturation));
    gp_parallel_do(chroma_rows, chroma_row, &rows);
    gp_parallel_do(in->h + 2, colour_row, &rows);
    gp_parallel_do(chroma_rows ? in->h : 0, fix_row, &rows);
out:
    gp_free(rows.chroma[0]);
    gp_free(rows.chroma[1]);
    gp_free(rows.outside);
    gp_free(rows.saturation);
    return st;
}

/* -- weights -------------------------------------------------------------- */

/* RGBtoXYZ() with Y = 1, of which only the Y column is needed. */
void gp_yc_weights(const float ch[8], float weight[3])
{
    const float rx = ch[0], ry = ch[1], gx = ch[2], gy = ch[3], bx = ch[4],
                by = ch[5], wx = ch[6], wy = ch[7];
    float x = wx / wy, z = (1.0f - wx - wy) / wy;
    float d = rx * (by - gy) + bx * (gy - ry) + gx * (ry - by);
    float r = x * (by - gy) - gx * ((by - 1.0f) + by * (x + z)) +
              bx * ((gy - 1.0f) + gy * (x + z));
    float g = x * (ry - by) + rx * ((by - 1.0f) + by * (x + z)) -
              bx * ((ry - 1.0f) + ry * (x + z));
    float b = x * (gy - ry) - rx * ((gy - 1.0f) + gy * (x + z)) +
              gx * ((ry - 1.0f) + ry * (x + z));
    float yr = r / d * ry, yg = g / d * gy, yb = b / d * by;
    float sum = yr + yg + yb;
    weight[0] = yr / sum;
    weight[1] = yg / sum;
    weight[2] = yb / sum;
    // green is what the other two leave, so it must be there
    if (isfinite(weight[0]) && isfinite(weight[1]) && isfinite(weight[2]) &&
        fabsf(weight[1]) > FLT_MIN)
        return;
    memcpy(weight, gp_rec709_luminance, sizeof gp_rec709_luminance);
}
