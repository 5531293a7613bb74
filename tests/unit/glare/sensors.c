// SPDX-License-Identifier: Apache-2.0
/* Sensors by their contract's words, and lists of sources, which are whole
 * however they were made. */
#include "unit.h"
#include "glare/glare_priv.h"
#include "glare/sources.h"
#include "glare_scene.h"

/* -- cleaning ---------------------------------------------------------------*/

/* One bad pixel becomes what the contract says, is counted once, and touches
 * no other. */
static void bad_pixels_stay_alone(void **state)
{
    static const struct {
        float limit, rgb[3], want[3];
        int nonfinite, clamped;
    } rows[] = {
        {0, {NAN, 2, 3}, {0, 2, 3}, 1, 0},
        {0, {NAN, NAN, -NAN}, {0, 0, 0}, 1, 0},
        {0, {INFINITY, 2, 3}, {65504, 2, 3}, 1, 0},
        {0, {INFINITY, 7e4f, INFINITY}, {7e4f, 7e4f, 7e4f}, 1, 0},
        {0, {-INFINITY, 2, 3}, {0, 2, 3}, 1, 0},
        {0, {11, FLT_MAX, 12}, {11, FLT_MAX, 12}, 0, 0},
        {0, {250000, 200000, 150000}, {250000, 200000, 150000}, 0, 0},
        {0, {-5, -FLT_MAX, 3}, {-5, -FLT_MAX, 3}, 0, 0},
        {0, {1e-42f, -1e-42f, 0}, {1e-42f, -1e-42f, 0}, 0, 0},
        {10, {20, 2, -3}, {10, 1, -1.5f}, 0, 1},
        {10, {250000, 200000, 150000}, {10, 8, 6}, 0, 1},
        {10, {11, FLT_MAX, 12}, {11e1f / FLT_MAX, 10, 12e1f / FLT_MAX}, 0, 1},
        {10, {INFINITY, 65504, 0}, {10, 10, 0}, 1, 1},
        {10, {10, 2, 3}, {10, 2, 3}, 0, 0},
        {10, {NAN, 2, 20}, {0, 1, 10}, 1, 1},
    };
    static const int sizes[][2] = {{1, 1}, {16, 16}, {37, 35}};
    for (size_t i = 0; i < 3 * COUNT(rows); i++) {
        const struct glarepp_sense_params limited =
            WHOLE(1.0f, 0.0f, rows[i / 3].limit);
        const int w = sizes[i % 3][0], h = sizes[i % 3][1];
        struct gp_image f = scene_frame(w, h, 0, 0, DARK, 9u);
        struct gp_image was = scene_frame(w, h, 0, 0, DARK, 9u);
        const size_t at = (size_t) w * (size_t) h / 2;
        struct gp_sources src;
        for (int c = 0; c < 3; c++) {
            f.rgb.c[c][at] = rows[i / 3].rgb[c];
            was.rgb.c[c][at] = rows[i / 3].want[c];
        }
        assert_ok(gp_sense(NULL, &limited, false, &f, &src));
        for (int c = 0; c < 3; c++)
            assert_memory_equal(f.rgb.c[c], was.rgb.c[c],
                                gp_image_pixels(&f) * sizeof(float));
        assert_int_equal(src.nonfinite, rows[i / 3].nonfinite);
        assert_int_equal(src.clamped, rows[i / 3].clamped);
        gp_sources_free(&src);
        gp_sources_free(&src);
        gp_image_free(&f);
        gp_image_free(&was);
    }
}

/* -- the bright pass --------------------------------------------------------*/

static void threshold_is_shut(void **state)
{
    const struct glarepp_sense_params hard = WHOLE(3.0f, 0.0f, 100.0f);
    assert_true(gp_bright_pass(&hard, 3.0f) == 0.0f);
    assert_true(gp_bright_pass(&hard, nextafterf(3.0f, 4.0f)) == 1.0f);
    assert_true(gp_bright_pass(&hard, nextafterf(3.0f, 2.0f)) == 0.0f);
    assert_true(gp_bright_pass(&hard, 0.0f) == 0.0f);
    assert_true(gp_bright_pass(&open_all, 0.0f) == 0.0f);
    assert_true(gp_bright_pass(&open_all, 1e-45f) == 1.0f);
    const struct glarepp_sense_params zero_knee = WHOLE(0.0f, 1.0f, 100.0f);
    assert_true(gp_bright_pass(&zero_knee, 0.0f) == 0.0f);
    assert_true(gp_bright_pass(&zero_knee, 1e-45f) == 1.0f);
}

/* The knee goes up from 0 at T(1-k) to 1 at T(1+k), a half at T, without a
 * jump in value or slope. */
static void knee_is_smooth(void **state)
{
    static const float knees[] = {1e-3f, 0.1f, 0.5f, 1.0f};
    for (size_t i = 0; i < COUNT(knees); i++) {
        const struct glarepp_sense_params p = WHOLE(2.0f, knees[i], 100.0f);
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

/* The list has it too, for each pixel over T. */
static void sources_hold_the_excess(void **state)
{
    static const float thresholds[] = {0.0f, 0.3f, 1.0f, 3.7f};
    struct gp_image f = scene_frame(67, 41, 0, 0, DARK, 5u);
    const size_t n = gp_image_pixels(&f);
    uint32_t seed = 17;
    for (size_t i = 0; i < n; i++) {
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = exp2f(8.0f * scene_random(&seed) - 4.0f);
    }
    for (size_t t = 0; t < COUNT(thresholds); t++) {
        const struct glarepp_sense_params p = {
            .threshold = thresholds[t],
        };
        struct gp_sources src;
        size_t over = 0, at = 0;
        assert_ok(gp_sense(NULL, &p, false, &f, &src));
        for (size_t i = 0; i < n; i++) {
            double y = 0.0;
            for (int c = 0; c < 3; c++)
                y += (double) (f.luminance[c] * f.rgb.c[c][i]);
            over += y > (double) p.threshold * (1.0 + 1e-6);
            if (at == src.n || src.x[at] != (int) (i % 67) ||
                at >= src.row[i / 67 + 1] || at < src.row[i / 67])
                continue;
            for (int c = 0; c < 3; c++) {
                const double v = (double) f.rgb.c[c][i];
                assert_true(fabs((double) src.rgb[c][at] -
                                 v * (y - (double) p.threshold) / y) <=
                            1e-6 * v);
            }
            at++;
        }
        assert_true(at == src.n && over <= src.n && over > n / 5);
        gp_sources_free(&src);
    }
    gp_image_free(&f);
}

/* -- of the whole frame -----------------------------------------------------*/

static void add_source(const struct gp_sources *s, uint32_t i, double flux[3],
                       double energy[3])
{
    float largest = 0.0f;
    for (int c = 0; c < 3; c++) {
        const float v = s->rgb[c][i];
        assert_true(isfinite(v) && v >= 0.0f);
        flux[c] += (double) v;
        energy[c] += (double) v * (double) v;
        largest = fmaxf(largest, v);
    }
    assert_true(largest >= FLT_MIN);
    assert_true(largest <= s->brightest);
    assert_true(largest >= gp_source_bin_start(gp_source_bin(largest)));
}

/* Order, sums and box, each from the list alone. */
static void assert_list(const struct gp_sources *s, const char *what)
{
    double flux[3] = {0}, energy[3] = {0};
    struct gp_rect box = {s->w, s->h, 0, 0};
    assert_int_equal(s->row[0], 0);
    assert_int_equal(s->row[s->h], s->n);
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            assert_true(s->x[i] >= 0 && s->x[i] < s->w);
            assert_true(i == s->row[y] || s->x[i] > s->x[i - 1]);
            add_source(s, i, flux, energy);
            box.x0 = s->x[i] < box.x0 ? s->x[i] : box.x0;
            box.x1 = s->x[i] >= box.x1 ? s->x[i] + 1 : box.x1;
            box.y0 = y < box.y0 ? y : box.y0;
            box.y1 = y + 1;
        }
    }
    if (!s->n)
        box = (struct gp_rect) {0};
    assert_memory_equal(&box, &s->box, sizeof box);
    for (int c = 0; c < 3; c++) {
        if (!(fabs(flux[c] - s->flux[c]) <= 1e-12 * flux[c]) ||
            !(fabs(energy[c] - s->energy[c]) <= 1e-12 * energy[c]))
            fail_msg("%s: flux %g or energy %g of channel %d", what,
                     s->flux[c], s->energy[c], c);
    }
}

static struct gp_sources dark_list(void)
{
    const struct gp_sources like = {.w = 20, .h = 10, .faint = {1e-39}};
    struct gp_sources s;
    assert_ok(gp_sources_make(NULL, &like, 0, &s));
    gp_sources_finish(&s);
    return s;
}

static void light_outside_is_refused(void **state)
{
    static const int outside[][2] = {
        {-1, 0}, {20, 0}, {0, -1}, {0, 10}, {INT_MIN, INT_MAX},
    };
    struct gp_sources dark = dark_list();
    for (size_t i = 0; i < COUNT(outside); i++) {
        struct gp_sources out = {0};
        struct gp_source one = {outside[i][0], outside[i][1], {1, 1, 1}};
        kept_clear();
        assert_int_equal(gp_sources_join(&kept_log, &dark, &one, 1, &out),
                         GP_ERR_BUG);
        assert_int_equal(kept_errors, 1);
        assert_null(out.row);
    }
    gp_sources_free(&dark);
}

/* Any order gives the same sum, black light is none, and what is under FLT_MIN
 * counts as 0. */
static void light_joins(void **state)
{
    static const float lights[] = {0.1f, 1e7f, -0.0f, 3e-4f};
    struct gp_sources dark = dark_list();
    for (int turn = 0; turn < 4; turn++) {
        struct gp_source list[12];
        struct gp_sources out, twice;
        for (int i = 0; i < 8; i++) {
            const float v = lights[(i + turn) % 4];
            list[i] = (struct gp_source) {i < 4 ? 7 : i % 2 ? 3 : 19,
                                          i < 4 ? 5 : 2, {v, v, v}};
        }
        list[8] = (struct gp_source) {3, 2, {0, 0, 0}};
        list[9] = (struct gp_source) {4, 2, {1e-39f, 0, 2e-39f}};
        list[10] = (struct gp_source) {9, 9, {3.0f, 1e-40f, FLT_MIN}};
        list[11] = (struct gp_source) {10, 9, {1e-37f, 1e-40f, FLT_MIN}};
        assert_ok(gp_sources_join(&kept_log, &dark, list, 12, &out));
        assert_list(&out, "joined");
        assert_int_equal(out.n, 5);
        assert_true(out.x[0] == 3 && out.x[1] == 19 && out.x[2] == 7);
        assert_true(out.rgb[0][2] == (3e-4f + 0.1f) + 1e7f);
        assert_true(out.rgb[0][3] == 3.0f && out.rgb[1][3] == 1e-40f);
        assert_true(out.rgb[0][4] == 1e-37f && out.rgb[1][4] == 0.0f &&
                    out.rgb[2][4] == FLT_MIN);
        assert_true(out.faint[0] == 1e-39 + (double) 1e-39f &&
            out.faint[1] == (double) 1e-40f && out.faint[2] == (double) 2e-39f);
        struct gp_source one = {9, 9, {1.0f, 1.0f, 1.0f}};
        assert_ok(gp_sources_join(NULL, &out, &one, 1, &twice));
        assert_list(&twice, "joined twice");
        assert_true(twice.n == 5 && twice.rgb[0][3] == 4.0f);
        gp_sources_free(&out);
        gp_sources_free(&twice);
    }
    gp_sources_free(&dark);
}

/* A mask is clamped, of NaN and outside of its window 0; a source without light is
 * none. */
static void masks_share_light(void **state)
{
    static float v[] = {0.25f, 2.0f, -1.0f, NAN};
    static const struct gp_plane mask = {.window = {-2, 7, 2, 8}, .v = v};
    static const float want[] = {1.0f, 4.0f};
    struct gp_sources dark = dark_list(), src, out;
    dark.x0 = -3;
    dark.y0 = 5;
    assert_ok(gp_sources_make(NULL, &dark, 12, &src));
    for (int y = 1; y < 3; y++) { // columns -3 to 2 of rows 6 and 7
        for (int x = 0; x < 6; x++)
            gp_sources_add(&src, x, y, (float[3]) {4.0f, 1.0f, 0.0f});
    }
    gp_sources_finish(&src);
    assert_ok(gp_sources_scale(NULL, &src, 1.0, &mask, &out));
    assert_list(&out, "masked");
    assert_int_equal(out.n, 2);
    for (uint32_t i = 0; i < 2; i++)
        assert_true(out.x[i] == 1 + (int) i && out.rgb[0][i] == want[i] &&
                    out.rgb[1][i] == want[i] / 4.0f && out.rgb[2][i] == 0.0f);
    assert_true(out.row[2] == 0 && out.flux[0] == 5.0);
    gp_sources_free(&dark);
    gp_sources_free(&src);
    gp_sources_free(&out);
}

SUITE_OF(sensors, NULL, NULL, bad_pixels_stay_alone, threshold_is_shut,
         knee_is_smooth, sources_hold_the_excess, light_outside_is_refused,
         light_joins, masks_share_light)
