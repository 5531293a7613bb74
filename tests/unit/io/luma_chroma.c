// SPDX-License-Identifier: Apache-2.0
/* io/luma_chroma: laws; test_data compares it with OpenEXR's own results. */
#include "unit.h"
#include "core/colour.h"
#include "core/parallel.h"
#include "core/half.h"
#include "io/exr/exr_priv.h"

#include <math.h>

enum { W = 46, H = 70, PIXELS = W * H };

static float luma[PIXELS], red[PIXELS], blue[PIXELS]; // inputs
static float out_r[PIXELS], out_g[PIXELS], out_b[PIXELS];
static struct gp_planes out = {{out_r, out_g, out_b}};

static struct gp_yc yc_picture(int w, int h, int sampling, bool half)
{
    struct gp_yc yc = {
        .w = w, .h = h, .xs = sampling, .ys = sampling, .y = luma, .ry = red,
        .by = blue, .half = half,
    };
    gp_yc_weights(gp_rec709_chromaticities, yc.weight);
    return yc;
}

static float random_unit(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return (float) (*seed >> 8) / 16777216.0f;
}

static void set_planes(float y, float ry, float by)
{
    for (int i = 0; i < PIXELS; i++) {
        luma[i] = y;
        red[i] = ry;
        blue[i] = by;
    }
}

static void random_planes(uint32_t seed)
{
    for (int i = 0; i < PIXELS; i++) {
        luma[i] = gp_half_nearest(random_unit(&seed) * 4.0f);
        red[i] = gp_half_nearest(random_unit(&seed) * 0.8f - 0.4f);
        blue[i] = gp_half_nearest(random_unit(&seed) * 0.8f - 0.4f);
    }
}

/* Without chroma every pixel is its luminance, exactly, whatever it is. */
static void grey_stays_grey(void **state)
{
    uint32_t seed = 5;
    set_planes(0.0f, 0.0f, 0.0f);
    for (int i = 0; i < PIXELS; i++)
        luma[i] = gp_half_nearest(random_unit(&seed) * 60000.0f);
    luma[3] = INFINITY;
    for (int sampling = 1; sampling <= 2; sampling++) {
        for (int half = 0; half < 2; half++) {
            struct gp_yc yc = yc_picture(W, H, sampling, half);
            assert_ok(gp_yc_to_rgb(NULL, &yc, &out));
            for (int c = 0; c < 3; c++)
                assert_memory_equal(out.c[c], luma, sizeof luma);
        }
    }
}

/* Chroma changes colour, never luminance: only where a component would be
 * negative is light lost. */
static void luminance_is_kept(void **state)
{
    random_planes(99);
    struct gp_yc yc = yc_picture(W, H, 2, false);
    assert_ok(gp_yc_to_rgb(NULL, &yc, &out));
    for (int i = 0; i < PIXELS; i++) {
        float y = yc.weight[0] * out_r[i] + yc.weight[1] * out_g[i] +
                  yc.weight[2] * out_b[i];
        assert_true(fabsf(y - luma[i]) <= 1e-5f * luma[i] + 1e-7f);
    }
}

static void smallest_pictures(void **state)
{
    static const struct {
        int w, h, sampling;
    } row[] = {{2, 2, 2}, {2, 40, 2}, {40, 2, 2}, {1, 1, 1}, {1, 5, 1},
               {3, 1, 1}, {4, 34, 2}};
    set_planes(0.5f, 0.1f, -0.1f);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_yc yc = yc_picture(row[i].w, row[i].h, row[i].sampling, true);
        memset(out_g, 0, sizeof out_g);
        assert_ok(gp_yc_to_rgb(NULL, &yc, &out));
        for (int k = 0; k < row[i].w * row[i].h; k++) {
            assert_true(fabsf(out_r[k] - 0.55f) < 1e-3f);
            assert_true(fabsf(out_b[k] - 0.45f) < 1e-3f);
        }
        assert_true(out_g[row[i].w * row[i].h] == 0.0f); // and no more
    }
}

static void weights_are_the_luminance_weights(void **state)
{
    static const float set[][8] = {
        {0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
        {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f, 0.33767f},
        {0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
    };
    float got[3], want[3];
    for (size_t i = 0; i < COUNT(set); i++) {
        gp_yc_weights(set[i], got);
        gp_luminance_weights(set[i], want);
        for (int c = 0; c < 3; c++) // 0.2126 against 0.212639
            assert_true(fabsf(got[c] - want[c]) < 1e-4f);
    }
    static const float bad[][8] = {
        {0}, {NAN, 0, 0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 0, 0, 1, 1},
        {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f},
    };
    for (size_t i = 0; i < COUNT(bad); i++) {
        gp_yc_weights(bad[i], got);
        assert_memory_equal(got, gp_rec709_luminance, sizeof got);
    }
}

SUITE_OF(luma_chroma, NULL, NULL, grey_stays_grey, luminance_is_kept,
         smallest_pictures, weights_are_the_luminance_weights)
