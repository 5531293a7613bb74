// SPDX-License-Identifier: Apache-2.0
/* glare/bound/bound.c, fft/fft.c: what every single pixel of a layer keeps. */
#include "unit.h"
#include "glare/fft/fft.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

/* -- reach ------------------------------------------------------------------*/

/* Kernel n of the table below: with holes, to one side, dark in a channel. */
static struct gp_kernel reaching_kernel(int n, uint32_t *seed)
{
    static const char *const names[] = {
        "star:length=1,share=1", "circle:share=1,soft=0.08", "ring", "eye",
    };
    struct gp_kernel_params p = {0};
    struct gp_kernel k;
    if (n < 4)
        return scene_model(names[n], 67, 0.0);
    struct gp_image f = scene_frame(31, 24, 0, 0, BLACK, 1u);
    for (int i = 0; i < 31 * 24; i++) {
        for (int c = 0; c < 3 - (n == 5); c++)
            f.rgb.c[c][i] = scene_random(seed) < 0.05f ? scene_random(seed)
                                                       : 0.0f;
    }
    p.centered = n == 5;
    p.center[0] = -7.5;
    p.center[1] = 60.5;
    assert_ok(gp_kernel_from_frame(NULL, &p, &f, &k));
    gp_image_free(&f);
    return k;
}

/* Light and kernel are not negative: the layer is not, and 0 where no source
 * reaches, channel by channel. */
static void no_light_where_no_light_reaches(void **state)
{
    static const struct { int lamps; float most; } light[] = {
        {1, 1e6f}, {5, 1e4f}, {60, 30.0f}, {4000, 3.0f},
    };
    enum { W = 211, H = 134 };
    for (uint32_t i = 0; i < 6 * COUNT(light); i++) {
        uint32_t seed = 77u + i;
        struct gp_image f = scene_frame(W, H, 0, 0, BLACK, 1u);
        for (int n = 0; n < light[i / 6].lamps; n++) {
            const int at = (int) (W * H * scene_random(&seed));
            for (int c = 0; c < 3; c++)
                f.rgb.c[c][at] = scene_random(&seed) < 0.3f ? 0.0f
                    : 2.0f + light[i / 6].most * scene_random(&seed);
        }
        struct scene s = scene_sense(f, reaching_kernel((int) i % 6, &seed),
                                     &usual);
        struct gp_glare g = {0};
        struct glarepp_layer_facts stats;
        s.exact = scene_alloc(3 * W * H, sizeof *s.exact);
        gp_glare_reference_direct(&s.src, &s.k, s.exact);
        assert_ok(scene_run("fft", &s, &g, &stats));
        long dark = 0, wrong = 0;
        for (int j = 0; j < 3 * W * H; j++) {
            const float v = s.f.layer.c[j / (W * H)][j % (W * H)];
            dark += s.exact[j] == 0.0;
            wrong += !(v >= 0.0f) || (s.exact[j] == 0.0 && v != 0.0f);
        }
        if (wrong || scene_rel_l2(&s) > 1e-6)
            fail_msg("%d lamps, kernel %u: %ld of %ld dark samples are not "
                     "dark, rel_l2 %g", light[i / 6].lamps, i % 6, wrong, dark,
                     scene_rel_l2(&s));
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* -- the worst pixel --------------------------------------------------------*/

/* A frame and a kernel of a search: few or many lamps in the dark, and a kernel
 * that is flat, has a peak, or holds few samples. `red` below 1: of the primaries
 * AP0, whose blue is darker than black, with so much of red and green beside it. */
static struct scene search_scene(uint32_t *seed, float red)
{
    static const float ap0[3] = {0.3439664f, 0.7281661f, -0.0721325f};
    const int w = 8 + (int) (120.0f * scene_random(seed));
    const int h = 8 + (int) (90.0f * scene_random(seed));
    const float few = scene_random(seed);
    const float hot = exp2f(24.0f * scene_random(seed));
    const float dark = scene_random(seed) < 0.5f ? 0.0f : 1e-3f;
    const int side = 1 + (int) (60.0f * scene_random(seed));
    const float holes = scene_random(seed), peak = scene_random(seed);
    struct gp_image f = scene_frame(w, h, 0, 0, BLACK, 1u);
    struct gp_image image = scene_frame(side, side, 0, 0, BLACK, 1u);
    struct gp_kernel_params p = {0};
    struct gp_kernel k;
    for (int i = 0; i < w * h; i++) {
        const bool lit = i == w * h / 3 || scene_random(seed) < few * few * few;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] =
                lit ? (2.0f + hot * scene_random(seed)) * (c < 2 ? red : 1.0f)
                    : dark;
    }
    for (int i = 0; i < side * side; i++) {
        const bool on = i == side * side / 2 || scene_random(seed) > holes;
        for (int c = 0; c < 3; c++)
            image.rgb.c[c][i] = !on ? 0.0f
                : (peak < 0.3f ? 1.0f : scene_random(seed)) +
                  (i == side * side / 2 ? 1000.0f * (peak > 0.7f) : 0.0f);
    }
    assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
    gp_image_free(&image);
    if (red < 1.0f)
        memcpy(f.luminance, ap0, sizeof ap0);
    return scene_make(f, k, red < 1.0f ? &open_all : &usual);
}

/* No pixel of the composite is further off than bound_pixel says, on frames
 * found by a search (the suite adversary has the bound from below). */
static void no_pixel_is_over_its_bound(void **state)
{
    static const char *const engines[] = {"direct", "fft"};
    for (uint32_t i = 0; i < 190; i++) {
        uint32_t seed = 9000u + i % 150;
        struct scene s = search_scene(
            &seed, i < 150 ? 1.0f : 0.07f + 0.01f * (float) (i - 150));
        for (int scatter = 0; scatter < 2; scatter++) {
            for (size_t e = 0; e < COUNT(engines); e++) {
                struct gp_glare_params p = GP_GLARE_DEFAULTS;
                struct gp_glare g = {0};
                struct glarepp_layer_facts stats;
                struct glarepp_errors error;
                p.engine = engines[e];
                p.tolerance_pixel = 1e-3f;
                p.taken = scatter ? &s.src : NULL;
                assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f,
                                       &stats));
                gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, p.gain,
                                 p.taken, &error);
                if (!(error.max_rel <= stats.bound_pixel))
                    fail_msg("frame %u, %s: max_rel %g, bound %g", i, p.engine,
                             error.max_rel, stats.bound_pixel);
                gp_glare_close(&g);
            }
        }
        scene_free(&s);
    }
}

/* Products under the range of float, whose last digits are lost, are in the bounds
 * of layer and pixel: of lights just inside it, each seen by a millionth. */
static void underflow_is_in_the_bounds(void **state)
{
    static const char *const engines[] = {"direct", "fft"};
    enum { N = 9 };
    for (size_t e = 0; e < COUNT(engines); e++) {
        struct gp_kernel_params kp = {.normalize = GP_NORMALIZE_NONE};
        struct gp_image f = scene_frame(N, N, 0, 0, BLACK, 1u);
        struct gp_image image = scene_frame(N, N, 0, 0, BLACK, 1u);
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct glarepp_layer_facts stats;
        struct glarepp_errors error;
        struct gp_kernel k;
        for (int i = 0; i < 3 * N * N; i++) {
            f.rgb.c[i % 3][i / 3] = i / 3 % 4 ? 0.0f : 1.7e-38f;
            image.rgb.c[i % 3][i / 3] = 1e-6f * (float) (1 + i / 3 % 5);
        }
        assert_ok(gp_kernel_from_frame(NULL, &kp, &image, &k));
        gp_image_free(&image);
        struct scene s = scene_make(f, k, &open_all);
        p.engine = engines[e];
        p.tolerance_pixel = 1e-3f;
        assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, p.gain, NULL, &error);
        assert_true(error.rel_l2 <= stats.bound);
        assert_true(error.max_rel <= stats.bound_pixel);
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* A frame in which each fifth pixel is a lamp and the others are black. */
static struct gp_image lamps(void)
{
    uint32_t seed = 5u;
    struct gp_image f = scene_frame(200, 150, 0, 0, BLACK, 1u);
    for (int i = 0; i < 200 * 150; i++) {
        const bool lit = scene_random(&seed) < 0.2f;
        for (int c = 0; c < 3; c++)
            f.rgb.c[c][i] = lit ? 50.0f * scene_random(&seed) : 0.0f;
    }
    return f;
}

/* Lamps in the dark: the darkest pixel is lit by a hundred others, and the
 * bound of fft knows it. */
static void lamps_light_the_dark(void **state)
{
    struct scene s =
        scene_make(lamps(), scene_kernel(90, 80, MID, 0, PEAK), &usual);
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare g = {0};
    struct glarepp_layer_facts stats;
    struct glarepp_errors error;
    p.engine = "fft";
    p.tolerance_pixel = 1e-3f;
    assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
    gp_glare_measure(&s.f, &s.f.layer, s.exact, NULL, p.gain, NULL, &error);
    assert_true(error.max_rel <= stats.bound_pixel);
    assert_true(stats.bound_pixel < 2e-4);
    gp_glare_close(&g);
    scene_free(&s);
}

SUITE_OF(pixel, NULL, NULL, no_light_where_no_light_reaches,
         no_pixel_is_over_its_bound, underflow_is_in_the_bounds,
         lamps_light_the_dark)
