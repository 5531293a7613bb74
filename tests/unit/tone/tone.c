// SPDX-License-Identifier: Apache-2.0
/* tone/map.c: exposure, primaries, white, the stage as a whole. */
#include "unit.h"
#include "core/colour.h"
#include "core/luminance.h"
#include "core/parallel.h"
#include "tone/tone.h"
#include "tone_forms.h"

#include <float.h>

static struct gp_image make_frame(int w, int h)
{
    struct gp_image f = gp_image_blank((struct gp_rect) {-7, 3, w - 7, h + 3});
    f.path = strdup("test");
    assert_ok(gp_planes_make(NULL, "t", gp_image_pixels(&f), &f.lit));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_image_pixels(&f); i++)
            f.lit.c[c][i] = (float) exp2(20.0 * noise() - 12.0);
    }
    return f;
}

/* A frame of one grey. */
static struct gp_image make_flat(int w, int h, float v)
{
    struct gp_image f = make_frame(w, h);
    for (size_t i = 0; i < 3 * gp_image_pixels(&f); i++)
        f.lit.c[i % 3][i / 3] = v;
    return f;
}

/* Each has its printed form, and reads the white where it says so. */
static void curves_are_listed(void **state)
{
    size_t forms = 0;
    for (const struct gp_tone_curve *const *c = gp_tone_curves; *c; c++) {
        assert_ptr_equal(gp_tone_find((*c)->name), *c);
        assert_true(strlen((*c)->text) > 5);
        assert_true(!(*c)->map == (strcmp((*c)->name, "none") == 0));
        if (!(*c)->map)
            continue;
        if (!tone_form_of((*c)->name))
            fail_msg("%s: has no row in tone_forms.h", (*c)->name);
        forms++;
        float a[3] = {0.5f, 0.4f, 0.3f}, b[3] = {0.5f, 0.4f, 0.3f};
        (*c)->map(&a[0], &a[1], &a[2], 1, 2.0f);
        (*c)->map(&b[0], &b[1], &b[2], 1, 200.0f);
        assert_true((memcmp(a, b, sizeof a) != 0) == (*c)->reads_white);
    }
    assert_int_equal(forms, TONE_FORMS);
    struct glarepp_tone_params defaults = GLAREPP_TONE_PARAMS;
    assert_non_null(gp_tone_find(defaults.curve));
}

static void one_stop_is_a_factor_of_two(void **state)
{
    static const float exposures[] = {-3.0f, 0.0f, 0.3f, 5.0f};
    for (const struct gp_tone_curve *const *c = gp_tone_curves; *c; c++) {
        for (size_t e = 0; (*c)->map && e < COUNT(exposures); e++) {
            seed = 3;
            struct gp_image a = make_frame(97, 31);
            seed = 3;
            struct gp_image b = make_frame(97, 31);
            const size_t n = gp_image_pixels(&a);
            a.chromaticities[0] = b.chromaticities[0] = 0.7f; // mixed, too
            for (int k = 0; k < 3; k++) {
                for (size_t i = 0; i < n; i++)
                    b.lit.c[k][i] *= 2.0f;
            }
            struct glarepp_tone_params p = GLAREPP_TONE_PARAMS;
            p.curve = (*c)->name;
            float scale_a, scale_b;
            p.exposure = exposures[e] + 1.0f;
            assert_ok(gp_tone_map(NULL, &p, &a));
            scale_a = gp_tone_scale(&p, &a);
            p.exposure = exposures[e];
            assert_ok(gp_tone_map(NULL, &p, &b));
            scale_b = gp_tone_scale(&p, &b);
            assert_true(fabsf(scale_a / scale_b / 2.0f - 1.0f) < 1e-6f);
            for (int k = 0; k < 3; k++) {
                for (size_t i = 0; i < n; i++)
                    assert_true(fabsf(a.shown.c[k][i] - b.shown.c[k][i]) <=
                                2e-6f);
            }
            if (exposures[e] == truncf(exposures[e])) // exact powers of two
                assert_memory_equal(a.shown.c[1], b.shown.c[1],
                                    n * sizeof(float));
            gp_image_free(&a);
            gp_image_free(&b);
        }
    }
}

static void none_copies(void **state)
{
    struct gp_image f = make_frame(61, 7);
    struct glarepp_tone_params p = {.curve = "none", .exposure = 3.0f,
                               .auto_exposure = true, .key = 0.18f};
    f.chromaticities[0] = 0.7f;
    f.lit.c[0][5] = NAN;
    f.lit.c[1][6] = -INFINITY;
    assert_ok(gp_tone_map(NULL, &p, &f));
    for (int c = 0; c < 3; c++)
        assert_memory_equal(f.shown.c[c], f.lit.c[c], 61 * 7 * sizeof(float));
    gp_image_free(&f);
}

/* One colour through `linear` at -2 EV. */
static void show_colour(const float chromaticities[8], const double in[3],
                        double out[3])
{
    struct gp_image f = make_frame(1, 1);
    struct glarepp_tone_params p = {.curve = "linear", .exposure = -2.0f};
    memcpy(f.chromaticities, chromaticities, sizeof f.chromaticities);
    for (int c = 0; c < 3; c++)
        f.lit.c[c][0] = (float) in[c];
    assert_ok(gp_tone_map(NULL, &p, &f));
    for (int c = 0; c < 3; c++)
        out[c] = 4.0 * (double) f.shown.c[c][0];
    gp_image_free(&f);
}

static void primaries_become_bt709(void **state)
{
    static const struct {
        float ch[8];
        double m[9], tolerance;
    } rows[] = {
        // BT.2020 to BT.709, ITU-R BT.2087-0
        {{0.708f, 0.292f, 0.170f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.3290f},
         {1.6605, -0.5876, -0.0728, -0.1246, 1.1329, -0.0083, -0.0182, -0.1006,
          1.1187}, 1.6e-4},
        // AP0 to BT.709 through Bradford, as in OpenColorIO's ACES configs
        {{0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f},
         {2.52169, -1.13413, -0.38756, -0.27648, 1.37272, -0.09624, -0.01538,
          -0.15298, 1.16835}, 2e-5},
        // AP1 to BT.709 through Bradford
        {{0.713f, 0.293f, 0.165f, 0.830f, 0.128f, 0.044f, 0.32168f, 0.33767f},
         {1.70505, -0.62179, -0.08326, -0.13026, 1.14080, -0.01055, -0.02400,
          -0.12897, 1.15297}, 2e-5},
        {{0.64f, 0.33f, 0.30f, 0.60f, 0.15f, 0.06f, 0.3127f, 0.3290f},
         {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0},
        {{0, 0, 0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0},
        {{NAN}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0},
        // whites with a cone response of nearly nothing, or less
        {{1, 0, 0, 1, 0, 0, 0.9f, 0.0001f}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0},
        {{1, 0, 0, 1, 0, 0, 0.1f, 0.9f}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0},
    };
    static const double colours[][3] = {
        {1, 1, 1}, {1, 0.9, 0.8}, {0.5, 0.6, 0.5}, {0.3, 0.3, 0.7},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (size_t k = 0; k < COUNT(colours); k++) {
            double got[3], want[3];
            show_colour(rows[i].ch, colours[k], got);
            multiply(rows[i].m, colours[k], want);
            for (int c = 0; c < 3; c++) {
                if (!(fabs(got[c] - want[c]) <= rows[i].tolerance + 1e-6))
                    fail_msg("row %zu colour %zu channel %d is %.7g, not %.7g",
                             i, k, c, got[c], want[c]);
            }
        }
    }
}

static void white_zero_is_the_frames_maximum(void **state)
{
    for (int mixed = 0; mixed < 2; mixed++) {
        struct gp_image f = make_frame(131, 77);
        struct glarepp_tone_params p = {.curve = "reinhard-extended",
                                   .exposure = 1.5f};
        if (mixed)
            f.chromaticities[0] = 0.7f;
        for (int c = 0; c < 3; c++)
            f.lit.c[c][5000] = 3000.0f;
        assert_ok(gp_tone_map(NULL, &p, &f));
        int ones = 0;
        for (size_t i = 0; i < gp_image_pixels(&f); i++) {
            const double shown[3] = {(double) f.shown.c[0][i],
                                     (double) f.shown.c[1][i],
                                     (double) f.shown.c[2][i]};
            ones += luminance(shown) > 0.999999;
        }
        assert_true(f.shown.c[1][5000] > 0.999999f);
        assert_int_equal(ones, 1);
        gp_image_free(&f);
    }
    struct gp_image black = make_flat(5, 5, 0.0f);
    struct glarepp_tone_params p = {.curve = "reinhard-extended"};
    assert_ok(gp_tone_map(NULL, &p, &black));
    assert_true(black.shown.c[2][24] == 0.0f);
    gp_image_free(&black);
}

static void log_average_skips_what_is_not_light(void **state)
{
    static const float bad[] = {0.0f, -0.0f, -5.0f, NAN, INFINITY, -INFINITY};
    struct gp_image f = make_frame(301, 203);
    const size_t n = gp_image_pixels(&f);
    double sum = 0.0;
    long long count = 0;
    for (size_t i = 0; i < n; i++) {
        if (i % 11 == 0) {
            for (int c = 0; c < 3; c++)
                f.lit.c[c][i] = bad[i / 11 % COUNT(bad)];
            continue;
        }
        double y = 0.0;
        for (int c = 0; c < 3; c++)
            y += (double) gp_rec709_luminance[c] * (double) f.lit.c[c][i];
        sum += log(1e-6 + y);
        count++;
    }
    double want = exp(sum / (double) count);
    double got = gp_log_average(&f, &f.lit);
    assert_true(fabs(got / want - 1.0) < 1e-12);
    gp_image_free(&f);
}

static void auto_exposure_sets_the_key(void **state)
{
    static const struct { float light, shown; double scale; } rows[] = {
        {20.0f, 0.36f, 0.018}, {3e38f, 0.36f, 1.2e-39}, {1e-3f, 0.36f, 359.64},
        {-1.0f, 0.0f, 2.0}, // no light to measure: exposure alone
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_image f = make_flat(40, 30, rows[i].light);
        struct glarepp_tone_params p = {.curve = "linear", .exposure = 1.0f,
                                   .auto_exposure = true, .key = 0.18f};
        const float scale = gp_tone_scale(&p, &f);
        assert_ok(gp_tone_map(NULL, &p, &f));
        assert_true(fabs((double) scale / rows[i].scale - 1.0) < 1e-5);
        assert_true(fabsf(f.shown.c[0][77] - rows[i].shown) < 1e-3f);
        gp_image_free(&f);
    }
}

static void exposure_of_any_size_is_finite(void **state)
{
    static const float exposures[] = {-1e30f, -200.0f, 200.0f, 1e30f};
    for (size_t e = 0; e < COUNT(exposures); e++) {
        struct gp_image f = make_frame(3, 1);
        struct glarepp_tone_params p = {.curve = "reinhard",
                                   .exposure = exposures[e]};
        f.chromaticities[0] = 0.7f;
        for (int c = 0; c < 3; c++) {
            f.lit.c[c][0] = 0.0f;
            f.lit.c[c][1] = FLT_MAX;
            f.lit.c[c][2] = c == 1 ? FLT_MAX : -FLT_MAX;
        }
        assert_ok(gp_tone_map(NULL, &p, &f));
        const float scale = gp_tone_scale(&p, &f);
        assert_true(scale > 0.0f && isfinite(scale));
        for (int c = 0; c < 3; c++) {
            assert_true(f.shown.c[c][0] == 0.0f);
            for (int i = 1; i < 3; i++)
                assert_true(f.shown.c[c][i] >= 0.0f && f.shown.c[c][i] <= 1.0f);
        }
        if (exposures[e] > 0.0f) {
            assert_true(f.shown.c[0][1] > 0.99f);
            assert_true(f.shown.c[1][2] > 0.99f); // green, not NaN
        }
        gp_image_free(&f);
    }
}

SUITE_OF(tone, NULL, NULL, curves_are_listed, one_stop_is_a_factor_of_two,
         none_copies, primaries_become_bt709, white_zero_is_the_frames_maximum,
         log_average_skips_what_is_not_light, auto_exposure_sets_the_key,
         exposure_of_any_size_is_finite)
