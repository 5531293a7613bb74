/* glare/measure.c: the errors of design.md section 6, by hand and by law. */
#include "unit.h"
#include "hard_cases.h"

/* A frame of w x h pixels of `light` with its layer and truth. */
static struct scene measured(int w, int h, float light, double exact,
                             float layer)
{
    struct scene s = {.f = scene_frame(w, h, 0, 0, DARK, 1u)};
    const size_t n = gp_frame_pixels(&s.f);
    s.exact = scene_alloc(3 * n, sizeof *s.exact);
    assert_int_equal(gp_planes_make(NULL, "layer", n, &s.f.layer), GP_OK);
    for (size_t i = 0; i < 3 * n; i++) {
        s.f.rgb.c[i / n][i % n] = light;
        s.f.layer.c[i / n][i % n] = layer;
        s.exact[i] = exact;
    }
    return s;
}

static void assert_near(double got, double want, const char *what)
{
    if (!(fabs(got - want) <= 1e-6 * fabs(want)))
        fail_msg("%s is %.9g, not %.9g", what, got, want);
}

/* One pixel of one channel off in a flat frame. */
static void one_error_is_what_it_is(void **state)
{
    static const struct {
        float light, gain;
        double exact;
        int channel;
        float off;
    } rows[] = {
        {1.0f, 1.0f, 1.0, 0, 0.5f},    {1.0f, 1.0f, 1.0, 1, -0.5f},
        {0.0f, 1.0f, 2.0, 2, 1.0f},    {3.0f, 0.25f, 2.0, 1, 1.0f},
        {1.0f, 0.0f, 2.0, 1, 1.0f},    {-5.0f, 1.0f, 1.0, 1, 0.25f},
    };
    (void) state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const double exact = rows[i].exact, off = (double) rows[i].off;
        const double gain = (double) rows[i].gain;
        struct scene s = measured(8, 4, rows[i].light, exact, (float) exact);
        struct gp_glare_error e;
        s.f.layer.c[rows[i].channel][17] += rows[i].off;
        gp_glare_measure(&s.f, &s.f.layer, s.exact, rows[i].gain, &e);
        double weight = 0.0;
        for (int c = 0; c < 3; c++)
            weight += (double) s.f.luminance[c];
        // the largest composite is no less than 0
        const double own = weight * ((double) rows[i].light + gain * exact);
        assert_near(e.rel_l2, fabs(off) / (exact * sqrt(96.0)), "rel_l2");
        assert_near(e.max_abs, fabs(off), "max_abs");
        assert_near(e.flux_error, fabs(off) / (exact * 96.0), "flux_error");
        if (own > 0.0)
            assert_near(e.max_rel,
                        gain * fabs(off) *
                            (double) s.f.luminance[rows[i].channel] /
                            (own * (1.0 + 1e-6)), "max_rel");
        else
            assert_true(isinf(e.max_rel));
        scene_free(&s);
    }
}

static void no_error_is_zero(void **state)
{
    static const double layers[] = {0.0, 1.0, 1e30, -2.0};
    (void) state;
    for (size_t i = 0; i < sizeof layers / sizeof *layers; i++) {
        const float layer = (float) layers[i];
        struct scene s = measured(5, 3, 0.0f, (double) layer, layer);
        struct gp_glare_error e;
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
        assert_true(e.rel_l2 == 0.0 && e.max_rel == 0.0 && e.max_abs == 0.0);
        scene_free(&s);
    }
}

/* Where nothing should be, what is there is the error itself. */
static void dark_layers_have_absolute_errors(void **state)
{
    (void) state;
    struct scene s = measured(2, 2, 1.0f, 0.0, 0.0f);
    struct gp_glare_error e;
    s.f.layer.c[1][3] = 0.25f;
    gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
    assert_near(e.rel_l2, 0.25, "rel_l2");
    assert_near(e.max_abs, 0.25, "max_abs");
    assert_near(e.flux_error, 0.25, "flux_error");
    scene_free(&s);
}

/* A layer that is not a number never measures well. */
static void nan_is_an_error(void **state)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    static const size_t places[] = {0, 7, 14};
    (void) state;
    for (int i = 0; i < 9; i++) {
        struct scene s = measured(5, 3, 1.0f, 1.0, 1.0f);
        struct gp_glare_error e;
        s.f.layer.c[i / 3][places[i % 3]] = bad[i % 3];
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
        assert_true(!(e.rel_l2 <= 1e30));
        assert_true(!(e.max_rel <= 1e30));
        assert_true(!(e.max_abs <= 1e30));
        assert_true(!(e.flux_error <= 1e30));
        scene_free(&s);
    }
}

/* Errors scale: twice the difference is twice the error, and light scaled
 * with its layer has the same relative errors. */
static void errors_scale(void **state)
{
    (void) state;
    struct scene s = hard_scene(&hard_cases[5]);
    struct gp_glare_error one, two, scaled;
    const size_t n = gp_frame_pixels(&s.f);
    assert_int_equal(gp_planes_make(NULL, "layer", n, &s.f.layer), GP_OK);
    for (int pass = 0; pass < 2; pass++) {
        for (size_t i = 0; i < 3 * n; i++)
            s.f.layer.c[i / n][i % n] =
                (float) (s.exact[i] + (pass + 1) * (double) (i % 5));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, pass ? &two : &one);
    }
    assert_near(two.rel_l2, 2.0 * one.rel_l2, "rel_l2");
    assert_near(two.max_rel, 2.0 * one.max_rel, "max_rel");
    for (size_t i = 0; i < 3 * n; i++) {
        s.exact[i] *= 64.0;
        s.f.layer.c[i / n][i % n] *= 64.0f;
        s.f.rgb.c[i / n][i % n] *= 64.0f;
    }
    gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &scaled);
    assert_near(scaled.rel_l2, two.rel_l2, "rel_l2 of scaled light");
    assert_near(scaled.max_rel, two.max_rel, "max_rel of scaled light");
    scene_free(&s);
}

SUITE(measure)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_error_is_what_it_is),
        cmocka_unit_test(no_error_is_zero),
        cmocka_unit_test(dark_layers_have_absolute_errors),
        cmocka_unit_test(nan_is_an_error),
        cmocka_unit_test(errors_scale),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
