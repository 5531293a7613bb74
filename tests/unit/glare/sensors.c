/* glare/sensors.c against a plain pixel-by-pixel form of its contract. */
#include "unit.h"
#include "glare/glare_priv.h"
#include "hard_cases.h"

/* -- cleaning ---------------------------------------------------------------*/

/* One bad pixel becomes what the contract says, is counted once, and touches
 * no other. */
static void bad_pixels_stay_alone(void **state)
{
    static const struct {
        float rgb[3], want[3];
        int nonfinite, clamped;
    } rows[] = {
        {{NAN, 2, 3}, {0, 2, 3}, 1, 0}, {{NAN, NAN, -NAN}, {0, 0, 0}, 1, 0},
        {{INFINITY, 2, 3}, {10, 2, 3}, 1, 0},
        {{-INFINITY, 2, 3}, {0, 2, 3}, 1, 0}, {{11, 2, 3}, {10, 2, 3}, 0, 1},
        {{11, FLT_MAX, 12}, {10, 10, 10}, 0, 1},
        {{11, NAN, INFINITY}, {10, 0, 10}, 1, 1},
        {{10, 2, 3}, {10, 2, 3}, 0, 0},
        {{-5, -FLT_MAX, 3}, {-5, -FLT_MAX, 3}, 0, 0},
        {{1e-42f, -1e-42f, 0}, {1e-42f, -1e-42f, 0}, 0, 0},
    };
    static const int sizes[][2] = {{1, 1}, {16, 16}, {37, 35}};
    for (size_t i = 0; i < 3 * COUNT(rows); i++) {
        const int w = sizes[i % 3][0], h = sizes[i % 3][1];
        struct gp_frame f = scene_frame(w, h, 0, 0, DARK, 9u);
        struct gp_frame was = scene_frame(w, h, 0, 0, DARK, 9u);
        const size_t at = (size_t) w * (size_t) h / 2;
        struct gp_sources src;
        for (int c = 0; c < 3; c++) {
            f.rgb.c[c][at] = rows[i / 3].rgb[c];
            was.rgb.c[c][at] = rows[i / 3].want[c];
        }
        assert_ok(gp_sense(NULL, &(struct gp_sensor_params){1.0f, 0.0f, 10.0f},
                           &f, &src));
        for (int c = 0; c < 3; c++)
            assert_memory_equal(f.rgb.c[c], was.rgb.c[c],
                                gp_frame_pixels(&f) * sizeof(float));
        assert_int_equal(src.nonfinite, rows[i / 3].nonfinite);
        assert_int_equal(src.clamped, rows[i / 3].clamped);
        gp_sources_free(&src);
        gp_sources_free(&src);
        gp_frame_free(&f);
        gp_frame_free(&was);
    }
}

/* -- the bright pass --------------------------------------------------------*/

static void threshold_is_shut(void **state)
{
    const struct gp_sensor_params hard = {3.0f, 0.0f, 100.0f};
    assert_true(gp_bright_pass(&hard, 3.0f) == 0.0f);
    assert_true(gp_bright_pass(&hard, nextafterf(3.0f, 4.0f)) == 1.0f);
    assert_true(gp_bright_pass(&hard, nextafterf(3.0f, 2.0f)) == 0.0f);
    assert_true(gp_bright_pass(&hard, 0.0f) == 0.0f);
    const struct gp_sensor_params open_all = {0.0f, 0.0f, 100.0f};
    assert_true(gp_bright_pass(&open_all, 0.0f) == 0.0f);
    assert_true(gp_bright_pass(&open_all, 1e-45f) == 1.0f);
    const struct gp_sensor_params zero_knee = {0.0f, 1.0f, 100.0f};
    assert_true(gp_bright_pass(&zero_knee, 0.0f) == 0.0f);
    assert_true(gp_bright_pass(&zero_knee, 1e-45f) == 1.0f);
}

/* The knee goes up from 0 at T(1-k) to 1 at T(1+k), a half at T, without a
 * jump in value or slope. */
static void knee_is_smooth(void **state)
{
    static const float knees[] = {1e-3f, 0.1f, 0.5f, 1.0f};
    for (size_t i = 0; i < COUNT(knees); i++) {
        const struct gp_sensor_params p = {2.0f, knees[i], 100.0f};
        const double lo = 2.0 * (1.0 - (double) knees[i]);
        const double wide = 4.0 * (double) knees[i];
        double last = 0.0, last_rise = 0.0;
        assert_true(gp_bright_pass(&p, (float) lo) == 0.0f);
        assert_true(gp_bright_pass(&p, (float) (lo + wide)) == 1.0f);
        assert_true(fabsf(gp_bright_pass(&p, 2.0f) - 0.5f) < 1e-3f);
        for (int s = -10; s <= 110; s++) { // hundredths of the ramp
            const float y = (float) (lo + wide * s / 100.0);
            const double v = (double) gp_bright_pass(&p, y);
            const double rise = v - last;
            assert_true(rise >= 0.0 && v <= 1.0);
            // the steepest slope is 3/2, the sharpest bend 6
            assert_true(rise <= 0.0151 + 2e-4 / (double) knees[i] * 1e-2);
            assert_true(fabs(rise - last_rise) <= 7e-4 + 1e-3 * (i == 0));
            last = v;
            last_rise = rise;
        }
    }
}

/* -- of the whole frame -----------------------------------------------------*/

/* A low percentile of what light there is: black counts for nothing, and a
 * few dark pixels do not pull it down. */
static void darkest_is_robust(void **state)
{
    struct gp_frame f = scene_frame(300, 200, 0, 0, DARK, 3u);
    const size_t n = gp_frame_pixels(&f);
    struct gp_sources src;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            f.rgb.c[c][i] = i < n / 2 ? 0.0f : 0.25f + (float) (i % 7);
        f.rgb.c[c][n - 1] = 1e-30f;
    }
    assert_ok(gp_sense(NULL, &(struct gp_sensor_params) GP_SENSOR_DEFAULTS, &f,
                       &src));
    assert_true(src.darkest <= 0.25 && src.darkest >= 0.25 * 15 / 16 * 15 / 16);
    gp_sources_free(&src);
    for (int c = 0; c < 3; c++)
        memset(f.rgb.c[c], 0, n * sizeof(float));
    assert_ok(gp_sense(NULL, &(struct gp_sensor_params) GP_SENSOR_DEFAULTS, &f,
                       &src));
    assert_true(src.darkest == 0.0 && src.n == 0);
    gp_sources_free(&src);
    gp_frame_free(&f);
}

/* The frame's own weights decide, negative ones too. */
static void weights_are_the_frames(void **state)
{
    struct gp_frame f = scene_frame(8, 4, 0, 0, DARK, 5u);
    const float weights[3] = {0.0f, -1.0f, 2.0f};
    struct gp_sources src;
    memcpy(f.luminance, weights, sizeof weights);
    for (int c = 0; c < 3; c++)
        memset(f.rgb.c[c], 0, gp_frame_pixels(&f) * sizeof(float));
    f.rgb.c[0][1] = 100.0f;                        // no luminance
    f.rgb.c[2][2] = 0.6f;                          // 1.2
    f.rgb.c[2][3] = 0.6f; f.rgb.c[1][3] = 0.3f;    // 0.9
    f.rgb.c[2][4] = 0.6f; f.rgb.c[1][4] = -9.0f;   // 1.2: negative is no light
    assert_ok(gp_sense(NULL, &(struct gp_sensor_params) GP_SENSOR_DEFAULTS, &f,
                       &src));
    assert_int_equal(src.n, 2);
    assert_int_equal(src.x[0], 2);
    assert_int_equal(src.x[1], 4);
    assert_true(src.rgb[1][1] == 0.0f && f.rgb.c[1][4] == -9.0f);
    gp_sources_free(&src);
    gp_frame_free(&f);
}

SUITE_OF(sensors, NULL, NULL,
    bad_pixels_stay_alone, threshold_is_shut, knee_is_smooth, darkest_is_robust,
    weights_are_the_frames)
