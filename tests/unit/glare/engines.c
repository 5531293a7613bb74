// SPDX-License-Identifier: Apache-2.0
/* All engines: bounds, names, the laws of a convolution. GLAREPP_TEST_QUICK
 * leaves out GL and large cases. The table of hard cases is in tests/hard. */
#include "unit.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

/* Runs an engine on one frame alone; false where it cannot run here, or shall
 * not, for want of GL. */
static bool ran(const char *engine, struct scene *s,
                struct glarepp_layer_facts *stats)
{
    static bool no_gl;
    struct gp_glare g = {0};
    const bool is_gl = strcmp(engine, "splat") == 0;
    if (is_gl && (no_gl || getenv("GLAREPP_TEST_QUICK")))
        return false;
    const gp_status st = scene_run(engine, s, &g, stats);
    gp_glare_close(&g);
    no_gl |= is_gl && st == GP_ERR_GL && strstr(kept_line, "install the Debian");
    if (st && !no_gl)
        fail_msg("%s: %s", engine, kept_line);
    return !st;
}

static int is_dark(const struct scene *s)
{
    for (size_t i = 0; i < 3 * gp_image_pixels(&s->f); i++) {
        if (s->exact[i] != 0.0)
            return 0;
    }
    return 1;
}

/* -- bounds, names ---------------------------------------------------*/

/* A kernel of 1 where no light lands, and of `rest` elsewhere: what a frame
 * of one source sees of it is far under its peak. */
static struct scene beside(float rest)
{
    enum { SIDE = 9, N = SIDE * SIDE };
    struct gp_kernel_params p = {0};
    struct gp_image image = scene_frame(SIDE, SIDE, 0, 0, BLACK, 1);
    struct gp_image f = scene_frame(33, 31, 0, 0, BLACK, 1);
    struct gp_kernel k;
    p.normalize = GP_NORMALIZE_NONE;
    for (int i = 0; i < 3 * N; i++)
        image.rgb.c[i / N][i % N] = i % N == 0 ? 1.0f : rest;
    assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
    gp_image_free(&image);
    for (int c = 0; c < 3; c++)
        f.rgb.c[c][33 + 1] = 1.0f; // its upper left is outside
    return scene_make(f, k, &open_all);
}

/* Values that leave the range of float downwards are in the bound; of kernels
 * under it nothing is left, and the kernel says so. */
static void bounds_know_the_range(void **state)
{
    static const float rests[] = {1e-3f,  1e-9f,  1e-13f, 1e-20f,
                                  1e-30f, 1e-36f, 2e-38f, 1e-42f};
    int large = 0;
    for (size_t r = 0; r < COUNT(rests); r++) {
        struct scene s = beside(rests[r]);
        const bool faint = rests[r] < FLT_MIN;
        assert_int_equal(s.k.faint[1] > 0.0, faint);
        assert_int_equal(is_dark(&s), faint);
        for (int i = 0; gp_engines[i]; i++) {
            struct glarepp_layer_facts stats;
            if (!ran(gp_engines[i]->name, &s, &stats))
                continue;
            const double rel_l2 = scene_rel_l2(&s);
            if (!(rel_l2 <= stats.bound))
                fail_msg("%s, %g: %g over its bound %g", gp_engines[i]->name,
                         (double) rests[r], rel_l2, stats.bound);
            large += stats.bound > 1.0;
        }
        scene_free(&s);
    }
    assert_true(large > 0);
}

/* A layer over FLT_MAX is FLT_MAX, not 0 and not Inf, whatever the kernel sums
 * to; it has no bound, and a line says so. */
static void overflows_are_limited(void **state)
{
    static const struct {
        float kernel, light;
    } rows[] = {{3e38f, 3.0f}, {1e36f, 1e30f}, {1e20f, 1e30f}};
    enum { SIDE = 33, W = 97, H = 61 };
    struct gp_kernel_params p = {0};
    p.normalize = GP_NORMALIZE_NONE;
    for (size_t r = 0; r < COUNT(rows); r++) {
        struct gp_image image = scene_frame(SIDE, SIDE, 0, 0, BLACK, 1);
        struct gp_image f = scene_frame(W, H, 0, 0, BLACK, 1);
        struct gp_kernel k;
        for (int i = 0; i < 3 * SIDE * SIDE; i++)
            image.rgb.c[i % 3][i / 3] =
                rows[r].kernel / (float) (1 + i / 3 % SIDE);
        for (int i = 0; i < 3 * W * H; i++)
            f.rgb.c[i % 3][i / 3] = rows[r].light;
        assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
        gp_image_free(&image);
        struct scene s = scene_sense(f, k, &open_all);
        for (int i = 0; gp_engines[i]; i++) {
            struct glarepp_layer_facts stats;
            kept_clear();
            if (!ran(gp_engines[i]->name, &s, &stats))
                continue;
            assert_true(stats.bound == INFINITY);
            assert_non_null(strstr(kept_warning, "overflows"));
            for (size_t x = 0; x < W * H; x++)
                assert_true(s.f.layer.c[1][x] == FLT_MAX);
        }
        scene_free(&s);
    }
}

static void names_are_checked(void **state)
{
    struct scene s = scene_sense(scene_frame(9, 7, 0, 0, FEW, 9u),
                                 scene_kernel(3, 3, MID, 0, PEAK), &usual);
    struct scene dark = scene_sense(scene_frame(9, 7, 0, 0, DARK, 9u),
                                    scene_kernel(3, 3, MID, 0, PEAK), &usual);
    struct gp_glare g = {0};
    struct glarepp_layer_facts stats;
    assert_int_equal(scene_run("ftt", &s, &g, &stats), GP_ERR_USAGE);
    assert_kept("ftt");
    for (int i = 0; gp_engines[i]; i++)
        assert_kept(gp_engines[i]->name);
    assert_int_equal(scene_run("", &s, &g, &stats), GP_ERR_USAGE);
    assert_int_equal(scene_run("ftt", &dark, &g, &stats), GP_ERR_USAGE);
    // no light: no engine is opened
    assert_ok(scene_run("splat", &dark, &g, &stats));
    assert_null(stats.engine);
    for (int i = 0; gp_engines[i]; i++)
        assert_null(g.state[i]);
    gp_glare_close(&g);
    scene_free(&s);
    scene_free(&dark);
}

SUITE_OF(engines, NULL, NULL, bounds_know_the_range, overflows_are_limited,
         names_are_checked)

