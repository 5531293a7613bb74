// SPDX-License-Identifier: Apache-2.0
/* core/luminance.c: means, percentiles against sorting, and the peak. */
#include "unit.h"
#include "core/luminance.h"
#include "core/parallel.h"

#include <stdlib.h>
#include <string.h>

enum { W = 37, H = 27, N = W * H };

static struct gp_image make_frame(uint32_t seed, float scale)
{
    struct gp_image f = {.data = {-5, 9, W - 5, H + 9},
                         .luminance = {0.2126f, 0.7152f, 0.0722f}};
    assert_ok(gp_planes_make(NULL, "test", N, &f.rgb));
    for (int i = 0; i < 3 * N; i++) {
        seed = seed * 1664525u + 1013904223u;
        const float u = (float) (seed >> 8) * 0x1p-24f;
        f.rgb.c[i / N][i % N] = scale * (u * u * u - 0.01f);
    }
    return f;
}

/* Over the display window, of which parts may be black, or cut off. */
static void mean_is_over_the_display_window(void **state)
{
    (void) state;
    struct gp_image f = make_frame(5u, 2.0f);
    static const struct gp_rect displays[] = {
        {-5, 9, W - 5, H + 9}, {-5, 9, 2 * W - 5, H + 9},
        {0, 12, 20, 30}, {-100, -100, 100, 100}, {W, 0, W + 1, 1},
    };
    for (size_t i = 0; i < COUNT(displays); i++) {
        const struct gp_rect d = displays[i];
        double sum = 0.0;
        for (int k = 0; k < N; k++) {
            const int x = k % W + f.data.x0, y = k / W + f.data.y0;
            for (int c = 0; c < 3 && x >= d.x0 && x < d.x1 && y >= d.y0 &&
                            y < d.y1; c++)
                sum += (double) f.luminance[c] * (double) f.rgb.c[c][k];
        }
        const double want = sum / ((double) (d.x1 - d.x0) * (d.y1 - d.y0));
        f.display = d;
        gp_set_threads(1);
        const double one = gp_mean_luminance(&f, &f.rgb);
        gp_set_threads(3);
        assert_true(gp_mean_luminance(&f, &f.rgb) == one);
        assert_true(fabs(one - want) <= 1e-12 * want);
    }
    gp_set_threads(0);
    gp_image_free(&f);
}

static int by_value(const void *a, const void *b)
{
    const float x = *(const float *) a, y = *(const float *) b;
    return (x > y) - (x < y);
}

/* The nearest rank, to the bit; no more than the rest is over it. */
static void percentiles_are_exact_ranks(void **state)
{
    static const double percents[] = {0, 0.01, 0.1, 25, 50, 99, 99.9, 99.99,
                                      100};
    static const float scales[] = {1.0f, 1e-30f, 3e38f, 0.0f};
    for (size_t i = 0; i < COUNT(percents) * COUNT(scales); i++) {
        struct gp_image f = make_frame((uint32_t) i, scales[i % COUNT(scales)]);
        const double percent = percents[i / COUNT(scales)];
        float y[N], got;
        for (int p = 0; p < N; p++)
            y[p] = gp_lit_luminance(f.luminance, f.rgb.c[0][p], f.rgb.c[1][p],
                                    f.rgb.c[2][p]);
        qsort(y, N, sizeof *y, by_value);
        // in thousandths of a percent, which are whole
        const long k = (lround(percent * 1000.0) * N + 99999) / 100000;
        for (int threads = 1; threads < 6; threads += 2) {
            gp_set_threads(threads);
            assert_ok(gp_luminance_percentile(NULL, &f, percent, &got));
            if (got != y[k > 0 ? k - 1 : 0])
                fail_msg("%g %%: %g, not %g", percent, (double) got,
                         (double) y[k > 0 ? k - 1 : 0]);
        }
        gp_set_threads(0);
        gp_image_free(&f);
    }
}

/* The first of equals, where the window says. */
static void peak_is_the_largest(void **state)
{
    struct gp_image f = make_frame(3u, 1.0f);
    int at[2];
    f.rgb.c[1][4 * W + 7] = f.rgb.c[1][20 * W + 1] = 50.0f;
    f.rgb.c[0][4 * W + 7] = f.rgb.c[0][20 * W + 1] = 0.0f;
    f.rgb.c[2][4 * W + 7] = f.rgb.c[2][20 * W + 1] = -9.0f;
    assert_true(gp_luminance_peak(&f, at) == 0.7152f * 50.0f);
    assert_true(at[0] == 7 - 5 && at[1] == 4 + 9);
    gp_image_free(&f);
}

SUITE_OF(luminance, NULL, NULL, mean_is_over_the_display_window,
    percentiles_are_exact_ranks, peak_is_the_largest)
