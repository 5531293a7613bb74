/* glare/sensors.c against a plain pixel-by-pixel form of its contract.
 *
 *   test_sensors --time   also times both forms
 */
#include "unit.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"
#include "hard_cases.h"
#include "pair.h"

/* -- reference and fast form ------------------------------------------------*/

static const struct gp_sensor_params *pair_params;

struct sensors_pair {
    struct gp_frame f;
    float *plain; // the frame as it was
};

static void *open_pair(struct pair_input *in)
{
    struct sensors_pair *const p = scene_alloc(1, sizeof *p);
    p->f = scene_frame(in->w, in->h, 0, 0, DARK, 1u);
    const size_t n = gp_frame_pixels(&p->f);
    p->plain = scene_alloc(3 * n, sizeof(float));
    for (int c = 0; c < 3; c++)
        memcpy(p->plain + (size_t) c * n, in->rgb[c], n * sizeof(float));
    return p;
}

/* What a channel's value becomes, by the contract's words. */
static float plain_clean(float v, float max)
{
    if (isnan(v) || v == -INFINITY)
        return 0.0f;
    return v > max ? max : v;
}

/* A pixel's luminance is taken of its light: what is over 0. */
static float plain_luminance(const float weight[3], const float rgb[3])
{
    float y = weight[0] * fmaxf(rgb[0], 0.0f);
    y += weight[1] * fmaxf(rgb[1], 0.0f);
    return y + weight[2] * fmaxf(rgb[2], 0.0f);
}

static void run_plain(void *ctx, double *out)
{
    const struct sensors_pair *const p = ctx;
    const size_t n = gp_frame_pixels(&p->f);
    for (size_t i = 0; i < n; i++) {
        float rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = plain_clean(p->plain[(size_t) c * n + i],
                                 pair_params->max_value);
        const float y = plain_luminance(p->f.luminance, rgb);
        for (int c = 0; c < 3; c++) {
            const float v = fmaxf(rgb[c], 0.0f) * gp_bright_pass(pair_params, y);
            out[(size_t) c * n + i] = v < FLT_MIN ? 0.0 : (double) v;
        }
    }
}

static void run_sense(void *ctx, float *out)
{
    struct sensors_pair *const p = ctx;
    struct gp_sources src;
    struct gp_planes image;
    const size_t n = gp_frame_pixels(&p->f);
    for (int c = 0; c < 3; c++)
        memcpy(p->f.rgb.c[c], p->plain + (size_t) c * n, n * sizeof(float));
    if (gp_sense(NULL, pair_params, &p->f, &src) ||
        gp_sources_planes(NULL, &src, &image))
        abort();
    for (int c = 0; c < 3; c++)
        memcpy(out + (size_t) c * n, image.c[c], n * sizeof(float));
    gp_planes_free(&image);
    gp_sources_free(&src);
}

static void close_pair(void *ctx)
{
    struct sensors_pair *const p = ctx;
    gp_frame_free(&p->f);
    free(p->plain);
    free(p);
}

static const struct pair sensors_pair = {
    "sensors", FLT_MAX, 0.0, 0.0, open_pair, run_plain, run_sense, close_pair,
};

static void sensors_equal_the_words(void **state)
{
    static const struct gp_sensor_params params[] = {
        GP_SENSOR_DEFAULTS, {0.0f, 0.0f, 65504.0f}, {0.0f, 1.0f, 65504.0f},
        {1.0f, 0.5f, 65504.0f}, {1.0f, 1.0f, 1e30f}, {0.5f, 0.01f, 0.75f},
        {1.0f, 0.0f, FLT_MAX}, {FLT_MIN, 0.0f, FLT_MIN},
        {FLT_MAX, 0.0f, FLT_MAX},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(params); i++) {
        pair_params = &params[i];
        pair_run(&sensors_pair);
    }
}

/* -- cleaning ---------------------------------------------------------------*/

/* One bad pixel becomes what the contract says, is counted once, and touches
 * no other. */
static void bad_pixels_stay_alone(void **state)
{
    static const struct {
        float rgb[3], want[3];
        int nonfinite, clamped;
    } rows[] = {
        {{NAN, 2, 3}, {0, 2, 3}, 1, 0},
        {{NAN, NAN, -NAN}, {0, 0, 0}, 1, 0},
        {{INFINITY, 2, 3}, {10, 2, 3}, 1, 0},
        {{-INFINITY, 2, 3}, {0, 2, 3}, 1, 0},
        {{11, 2, 3}, {10, 2, 3}, 0, 1},
        {{11, FLT_MAX, 12}, {10, 10, 10}, 0, 1},
        {{11, NAN, INFINITY}, {10, 0, 10}, 1, 1},
        {{10, 2, 3}, {10, 2, 3}, 0, 0},
        {{-5, -FLT_MAX, 3}, {-5, -FLT_MAX, 3}, 0, 0},
        {{1e-42f, -1e-42f, 0}, {1e-42f, -1e-42f, 0}, 0, 0},
    };
    static const int sizes[][2] = {{1, 1}, {16, 16}, {37, 35}};
    (void) state;
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
        assert_int_equal(gp_sense(NULL, &(struct gp_sensor_params) {
            1.0f, 0.0f, 10.0f}, &f, &src), GP_OK);
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
    (void) state;
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
    (void) state;
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
    (void) state;
    struct gp_frame f = scene_frame(300, 200, 0, 0, DARK, 3u);
    const size_t n = gp_frame_pixels(&f);
    struct gp_sources src;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            f.rgb.c[c][i] = i < n / 2 ? 0.0f : 0.25f + (float) (i % 7);
        f.rgb.c[c][n - 1] = 1e-30f;
    }
    assert_int_equal(gp_sense(NULL, &(struct gp_sensor_params)
                                         GP_SENSOR_DEFAULTS, &f, &src), GP_OK);
    assert_true(src.darkest <= 0.25 && src.darkest >= 0.25 * 15 / 16 * 15 / 16);
    gp_sources_free(&src);
    for (int c = 0; c < 3; c++)
        memset(f.rgb.c[c], 0, n * sizeof(float));
    assert_int_equal(gp_sense(NULL, &(struct gp_sensor_params)
                                         GP_SENSOR_DEFAULTS, &f, &src), GP_OK);
    assert_true(src.darkest == 0.0 && src.n == 0);
    gp_sources_free(&src);
    gp_frame_free(&f);
}

/* Threads share rows in blocks; no sum may depend on who took which. */
static void threads_change_nothing(void **state)
{
    static const int threads[] = {1, 2, 4, 7};
    struct gp_sources first = {0};
    (void) state;
    for (int t = 0; t < 4; t++) {
        struct gp_frame f = scene_frame(211, 151, 0, 0, BAD, 4u);
        struct gp_sources src;
        gp_set_threads(threads[t]);
        assert_int_equal(gp_sense(NULL, &(struct gp_sensor_params) {
            0.5f, 0.5f, 1e9f}, &f, &src), GP_OK);
        gp_frame_free(&f);
        if (t == 0) {
            first = src;
            continue;
        }
        assert_int_equal(src.n, first.n);
        assert_memory_equal(src.flux, first.flux, sizeof src.flux);
        assert_memory_equal(src.energy, first.energy, sizeof src.energy);
        assert_true(src.darkest == first.darkest);
        assert_memory_equal(src.x, first.x, src.n * sizeof *src.x);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(src.rgb[c], first.rgb[c],
                                src.n * sizeof(float));
        gp_sources_free(&src);
    }
    gp_sources_free(&first);
    gp_set_threads(0);
}

/* The frame's own weights decide, negative ones too. */
static void weights_are_the_frames(void **state)
{
    (void) state;
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
    assert_int_equal(gp_sense(NULL, &(struct gp_sensor_params)
                                         GP_SENSOR_DEFAULTS, &f, &src), GP_OK);
    assert_int_equal(src.n, 2);
    assert_int_equal(src.x[0], 2);
    assert_int_equal(src.x[1], 4);
    assert_true(src.rgb[1][1] == 0.0f && f.rgb.c[1][4] == -9.0f);
    gp_sources_free(&src);
    gp_frame_free(&f);
}

/* Pieces of a row of any length hold the same pixels, whole vectors or not. */
static void pieces_of_any_length(void **state)
{
    enum { MOST = 600 };
    static const float odd[] = {0.0f, -0.0f, 1.0f, -3.0f, 2.0f, 65504.0f};
    static const struct gp_sensor_params usual = GP_SENSOR_DEFAULTS;
    float rgb[3][MOST], fast[3 * MOST];
    double words[3 * MOST];
    uint32_t seed = 3u;
    (void) state;
    pair_params = &usual;
    for (int n = 1; n <= MOST; n += n < 40 ? 1 : 36) {
        for (int i = 0; i < 3 * n; i++) {
            const float v = 2.0f * scene_random(&seed);
            rgb[i % 3][i / 3] = i % 11 ? v : odd[i / 11 % 6];
        }
        struct pair_input in = {
            .w = n, .h = 1, .rgb = {rgb[0], rgb[1], rgb[2]},
        };
        void *const both = open_pair(&in);
        run_plain(both, words);
        run_sense(both, fast);
        close_pair(both);
        for (int i = 0; i < 3 * n; i++)
            assert_true((double) fast[i] == words[i]);
    }
}

SUITE(sensors)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(sensors_equal_the_words),
        cmocka_unit_test(bad_pixels_stay_alone),
        cmocka_unit_test(threshold_is_shut),
        cmocka_unit_test(knee_is_smooth),
        cmocka_unit_test(darkest_is_robust),
        cmocka_unit_test(threads_change_nothing),
        cmocka_unit_test(weights_are_the_frames),
        cmocka_unit_test(pieces_of_any_length),
    };
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    const struct gp_sensor_params usual = GP_SENSOR_DEFAULTS;
    pair_params = &usual;
    if (pair_wants_time(argc, argv))
        pair_time(&sensors_pair, 1920, 1080, PAIR_UNIFORM);
    return failed;
}
