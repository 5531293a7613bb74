// SPDX-License-Identifier: Apache-2.0
/* glare/reference.c: the truth itself, against sums gathered pixel by pixel. */
#include "unit.h"
#include "glare/direct/direct.h"
#include "glare/glare_priv.h"
#include "../../hard/scenes.h"

/* Compares samples with gathered sums, relative to the layer's peak: every
 * sample when step is 1, else the borders and some between. */
static void check_samples(const struct scene *s, const double *layer, int step,
                          double bar, const char *what)
{
    const int w = s->src.w, h = s->src.h;
    const size_t n = gp_image_pixels(&s->f);
    double peak = 0.0, worst = 0.0;
    struct gp_planes image;
    assert_ok(gp_sources_planes(NULL, &s->src, &image));
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
    for (int i = 0; i < HARD_CASES; i++) {
        const struct hard_case *const h = &hard_cases[i];
        if (!hard_is_quick(h))
            continue;
        struct scene s = hard_sense(h);
        double *const layer = scene_alloc(3 * gp_image_pixels(&s.f),
                                          sizeof *layer);
        memset(layer, 0xff, 3 * gp_image_pixels(&s.f) * sizeof *layer);
        gp_glare_reference_direct(&s.src, &s.k, layer);
        check_samples(&s, layer, getenv("GLAREPP_TEST_QUICK") ? 7 : 1, 1e-13, h->name);
        free(layer);
        scene_free(&s);
    }
}

/* Over 3e9 taps the reference takes transforms in double. */
static void transform_is_the_sum(void **state)
{
    if (getenv("GLAREPP_TEST_QUICK"))
        skip_for("quick");
    static const struct {
        int w, h, kw, kh, cx, cy;
        enum shape shape;
    } rows[] = {
        {401, 397, 89, 91, MID, 0, TINTED}, {401, 397, 89, 90, MID, 0, LOBES},
        {300, 211, 601, 423, MID, 0, PEAK},    // larger than the frame
        {401, 397, 101, 99, -20, 110, TINTED}, // centre outside
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = scene_sense(scene_frame(rows[i].w, rows[i].h, 0, 0,
            ALL, 5u), scene_kernel(rows[i].kw, rows[i].kh, rows[i].cx,
            rows[i].cy, rows[i].shape), &usual);
        // else the plain loops would be checked again
        assert_true(gp_direct_work(&s.src, s.k.w, s.k.h, s.k.cx, s.k.cy,
                                   INFINITY) > 1e9);
        scene_find_exact(&s);
        check_samples(&s, s.exact, 1009, 1e-13, "transform");
        scene_free(&s);
    }
}

/* -- errors against it, by hand and by law: design.md section 6 -------------*/

/* A frame of w x h pixels of `light` with its layer and truth. */
static struct scene measured(int w, int h, float light, double exact,
                             float layer)
{
    struct scene s = {.f = scene_frame(w, h, 0, 0, DARK, 1u)};
    const size_t n = gp_image_pixels(&s.f);
    s.exact = scene_alloc(3 * n, sizeof *s.exact);
    assert_ok(gp_planes_make(NULL, "layer", n, &s.f.layer));
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
        {1.0f, 1.0f, 1.0, 0, 0.5f}, {1.0f, 1.0f, 1.0, 1, -0.5f},
        {0.0f, 1.0f, 2.0, 2, 1.0f}, {3.0f, 0.25f, 2.0, 1, 1.0f},
        {1.0f, 0.0f, 2.0, 1, 1.0f}, {-5.0f, 1.0f, 1.0, 1, 0.25f},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const double exact = rows[i].exact, off = (double) rows[i].off;
        const double gain = (double) rows[i].gain;
        struct scene s = measured(8, 4, rows[i].light, exact, (float) exact);
        struct glarepp_errors e;
        s.f.layer.c[rows[i].channel][17] += rows[i].off;
        gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, rows[i].gain, NULL,
                         &e);
        double weight = 0.0;
        for (int c = 0; c < 3; c++)
            weight += (double) s.f.luminance[c];
        // the largest composite is no less than 0
        const double own = weight * ((double) rows[i].light + gain * exact);
        assert_near(e.rel_l2, fabs(off) / (exact * sqrt(96.0)), "rel_l2");
        assert_near(e.max_abs, fabs(off), "max_abs");
        assert_near(e.flux_error, fabs(off) / (exact * 96.0), "flux_error");
        const double y = (double) s.f.luminance[rows[i].channel];
        assert_near(e.off,
                    gain * y * fabs(off) > 5e-3 * gain * weight * exact
                        ? 1.0 / 32.0
                        : 0.0,
                    "off");
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

/* A layer that is not a number never measures well. */
static void nan_is_an_error(void **state)
{
    static const float bad[] = {NAN, INFINITY, -INFINITY};
    static const size_t places[] = {0, 7, 14};
    for (int i = 0; i < 9; i++) {
        struct scene s = measured(5, 3, 1.0f, 1.0, 1.0f);
        struct glarepp_errors e;
        s.f.layer.c[i / 3][places[i % 3]] = bad[i % 3];
        gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, 1.0f, NULL, &e);
        assert_true(!(e.rel_l2 <= 1e30));
        assert_true(!(e.max_rel <= 1e30));
        assert_true(!(e.max_abs <= 1e30));
        assert_true(!(e.flux_error <= 1e30));
        scene_free(&s);
    }
}

/* Sources whose light leaves their pixels are no part of the composite. */
static void scattered_light_leaves_the_composite(void **state)
{
    static const float gains[] = {0.25f, 1.0f, 3.0f};
    for (size_t i = 0; i < COUNT(gains); i++) {
        const struct glarepp_sense_params p = GLAREPP_SENSE_PARAMS;
        const double gain = (double) gains[i];
        struct scene s = measured(8, 4, 0.5f, 2.0, 2.0f);
        struct glarepp_errors e;
        for (int c = 0; c < 3; c++)
            s.f.rgb.c[c][17] = 4.0f; // 3 of it are a source
        assert_ok(gp_sense(NULL, &p, false, &s.f, &s.src));
        s.f.layer.c[1][17] += 1.0f;
        gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, gains[i], &s.src, &e);
        const double own = 4.0 - 3.0 * fmin(gain, 1.0) + gain * 2.0;
        const double peak = fmax(own, 0.5 + gain * 2.0);
        assert_near(e.max_rel, gain * (double) s.f.luminance[1] /
                                   (own + 1e-6 * peak), "max_rel");
        scene_free(&s);
    }
}

SUITE_OF(reference, NULL, NULL, plain_loops_are_the_sum,
         transform_is_the_sum, one_error_is_what_it_is, nan_is_an_error,
         scattered_light_leaves_the_composite)

