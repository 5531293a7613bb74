/* tone/ocio: what becomes of pixels. */
#include "unit.h"
#include "ocio_config.h"

#include "core/parallel.h"

/* Sizes of one pixel, one column, and over several blocks; exposure is a
 * scale before the view. */
static void view_of_every_pixel(void **state)
{
    (void) state;
    static const struct {
        int w, h;
        float ev;
    } rows[] = {{1, 1, 0}, {1, 37, 1}, {4097, 3, -2}, {64, 64, 3}};
    struct gp_ocio_params p = ask();
    struct gp_ocio *o = opened(&p);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_frame f = lit_frame(rows[i].w, rows[i].h, 40000.0f);
        struct gp_tone_params tone = GP_TONE_DEFAULTS;
        tone.exposure = rows[i].ev;
        tone.curve = "none"; // does not count
        assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), 0);
        for (size_t k = 0; k < 3 * gp_frame_pixels(&f); k++) {
            const float x = f.lit.c[k % 3][k / 3];
            const float y = 0.5f * x * exp2f(rows[i].ev) + 0.25f;
            if (f.shown.c[k % 3][k / 3] != y)
                fail_msg("row %zu, sample %zu: %g of %g, wanted %g", i, k,
                         (double) f.shown.c[k % 3][k / 3], (double) x,
                         (double) y);
        }
        gp_frame_free(&f);
    }
    gp_ocio_close(&o);
}

static void auto_exposure_is_a_scale(void **state)
{
    (void) state;
    struct gp_ocio_params p = ask();
    struct gp_ocio *o = opened(&p);
    struct gp_frame f = lit_frame(9, 7, 1.0f);
    struct gp_tone_params tone = GP_TONE_DEFAULTS;
    tone.auto_exposure = true;
    const float scale = gp_tone_scale(&tone, &f);
    assert_true(scale > 0.0f && scale != 1.0f);
    assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), 0);
    for (size_t i = 0; i < gp_frame_pixels(&f); i++) {
        const float wanted = 0.5f * (f.lit.c[1][i] * scale) + 0.25f;
        assert_true(fabsf(f.shown.c[1][i] - wanted) <= 1e-6f);
    }
    gp_frame_free(&f);
    gp_ocio_close(&o);
}

/* What is not finite, or becomes so, stays with its own pixel. */
static void bad_pixels_stay_alone(void **state)
{
    (void) state;
    static const float bad[] = {NAN, INFINITY, -INFINITY, 3e38f, -3e38f};
    struct gp_ocio_params p = ask();
    struct gp_ocio *o = opened(&p);
    for (size_t i = 0; i < COUNT(bad); i++) {
        struct gp_frame f = lit_frame(5, 5, bad[i]);
        struct gp_tone_params tone = GP_TONE_DEFAULTS;
        tone.exposure = 8;
        assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), 0);
        for (size_t k = 1; k < 25; k++)
            assert_true(f.shown.c[0][k] ==
                        128.0f * f.lit.c[0][k] + 0.25f);
        assert_true(isnan(bad[i]) || isfinite(f.shown.c[0][0]));
        gp_frame_free(&f);
    }
    gp_ocio_close(&o);
}

static void same_for_any_threads(void **state)
{
    (void) state;
    struct gp_ocio_params p = ask();
    p.view = "Twice";
    p.output = "turned";
    struct gp_ocio *o = opened(&p);
    struct gp_frame f = lit_frame(301, 97, 0.1f);
    const size_t n = gp_frame_pixels(&f);
    const struct gp_tone_params tone = {.exposure = 0.3f, .key = 0.18f,
                                        .auto_exposure = true};
    float *first = malloc(n * sizeof *first);
    assert_non_null(first);
    for (int threads = 1; threads <= 5; threads += 2) {
        struct gp_planes out = {0};
        gp_set_threads(threads);
        assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), 0);
        assert_int_equal(gp_ocio_convert(&wf_log, o, &f, &out), 0);
        if (threads == 1)
            memcpy(first, f.shown.c[2], n * sizeof *first);
        assert_memory_equal(first, f.shown.c[2], n * sizeof *first);
        assert_memory_equal(out.c[1], f.lit.c[0], n * sizeof *first);
        gp_planes_free(&out);
    }
    gp_set_threads(0);
    free(first);
    gp_frame_free(&f);
    gp_ocio_close(&o);
}

/* A transform that was not asked for is an error, not a crash. */
static void only_what_was_asked(void **state)
{
    (void) state;
    struct gp_ocio_params p = ask();
    struct gp_frame f = lit_frame(2, 2, 1.0f);
    struct gp_planes out = {0};
    const struct gp_tone_params tone = GP_TONE_DEFAULTS;
    p.shows = false;
    struct gp_ocio *o = opened(&p);
    assert_null(gp_ocio_names(o)->view);
    assert_int_equal(gp_ocio_show(&wf_log, o, &tone, &f), GP_ERR_BUG);
    assert_int_equal(gp_ocio_convert(&wf_log, o, &f, &out), GP_ERR_BUG);
    assert_null(out.c[0]);
    gp_frame_free(&f);
    gp_ocio_close(&o);
}

SUITE_OF(ocio, start, wf_end, view_of_every_pixel, auto_exposure_is_a_scale,
         bad_pixels_stay_alone, same_for_any_threads, only_what_was_asked)
