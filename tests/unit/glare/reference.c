/* glare/reference.c: the truth itself, against sums gathered pixel by pixel. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "hard_cases.h"

/* Compares samples with gathered sums, relative to the layer's peak: every
 * sample when step is 1, else the borders and some between. */
static void check_samples(const struct scene *s, const double *layer, int step,
                          double bar, const char *what)
{
    const int w = s->src.w, h = s->src.h;
    const size_t n = gp_frame_pixels(&s->f);
    double peak = 0.0, worst = 0.0;
    struct gp_planes image;
    assert_int_equal(gp_sources_planes(NULL, &s->src, &image), GP_OK);
    for (size_t i = 0; i < 3 * n; i++)
        peak = fmax(peak, fabs(layer[i]));
    for (int i = 0; i < w * h; i += step) {
        const int x = i % w, y = i / w;
        for (int c = 0; c < 3; c++) {
            const double want = scene_sample(image.c[c], w, h, &s->k, c, x, y);
            const double got = layer[(size_t) c * n + (size_t) i];
            worst = fmax(worst, fabs(want - got));
            peak = fmax(peak, fabs(want));
        }
    }
    if (!(worst <= bar * peak))
        fail_msg("%s: %g off, peak %g", what, worst, peak);
    gp_planes_free(&image);
}

/* The plain loops scatter, the check gathers: another order of up to 1024
 * terms, each within 2^-53. */
static void plain_loops_are_the_sum(void **state)
{
    (void) state;
    for (int i = 0; i < HARD_CASES; i++) {
        const struct hard_case *const h = &hard_cases[i];
        if (!hard_is_quick(h))
            continue;
        struct scene s = hard_sense(h);
        double *const layer = scene_alloc(3 * gp_frame_pixels(&s.f),
                                          sizeof *layer);
        memset(layer, 0xff, 3 * gp_frame_pixels(&s.f) * sizeof *layer);
        gp_glare_reference_direct(&s.src, &s.k, layer);
        check_samples(&s, layer, quick ? 7 : 1, 1e-13, h->name);
        free(layer);
        scene_free(&s);
    }
}

/* Over 3e9 taps the reference takes transforms in double. */
static void transform_is_the_sum(void **state)
{
    static const struct {
        int w, h, kw, kh, cx, cy;
        enum shape shape;
    } rows[] = {
        {401, 397, 89, 91, MID, 0, TINTED},
        {401, 397, 89, 90, MID, 0, LOBES},
        {300, 211, 601, 423, MID, 0, PEAK},    // larger than the frame
        {401, 397, 101, 99, -20, 110, TINTED}, // centre outside
    };
    (void) state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct scene s = scene_sense(
            scene_frame(rows[i].w, rows[i].h, 0, 0, ALL, 5u),
            scene_kernel(rows[i].kw, rows[i].kh, rows[i].cx, rows[i].cy,
                         rows[i].shape),
            &(struct gp_sensor_params) GP_SENSOR_DEFAULTS);
        // else the plain loops would be checked again
        assert_true(3.0 * gp_direct_work(&s.src, s.k.w, s.k.h, s.k.cx,
                                         s.k.cy) > 3e9);
        scene_find_exact(&s);
        check_samples(&s, s.exact, 1009, 1e-13, "transform");
        scene_free(&s);
    }
}

/* Every sample is written, the same by any number of threads. */
static void threads_change_nothing(void **state)
{
    static const int threads[] = {1, 2, 4, 7};
    (void) state;
    struct scene s = hard_scene(&hard_cases[5]);
    const size_t bytes = 3 * gp_frame_pixels(&s.f) * sizeof(double);
    double *const again = scene_alloc(1, bytes);
    for (int t = 0; t < 4; t++) {
        gp_set_threads(threads[t]);
        memset(again, 0xff, bytes);
        assert_int_equal(gp_glare_reference(NULL, &s.src, &s.k, again), GP_OK);
        assert_memory_equal(again, s.exact, bytes);
    }
    gp_set_threads(0);
    free(again);
    scene_free(&s);
}

SUITE(reference)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_loops_are_the_sum),
        cmocka_unit_test(transform_is_the_sum),
        cmocka_unit_test(threads_change_nothing),
    };
    quick = getenv("GLAREPP_TEST_QUICK") != NULL;
    if (quick)
        cmocka_set_skip_filter("transform_is_the_sum");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
