// SPDX-License-Identifier: Apache-2.0
/* The planner: which engine, the tolerances, and that no frame before decides. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

static struct scene scene_of(enum light light, int w, int h, int kernel)
{
    return scene_make(scene_frame(w, h, 0, 0, light, 5u),
                      scene_kernel(kernel, kernel, MID, 0, TINTED), &usual);
}

static struct glarepp_layer_facts run_auto(struct scene *s, double tolerance,
                                      double pixel, struct gp_glare *g)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct glarepp_layer_facts stats;
    p.tolerance = (float) tolerance;
    p.tolerance_pixel = (float) pixel;
    kept_clear();
    assert_ok(gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, &stats));
    return stats;
}

static const struct row {
    enum light light;
    int w, h, kernel;
    const char *engine;
} rows[] = {
    {FEW, 97, 61, 31, "direct"},  {ALL, 300, 200, 99, "fft"},
    {CORNERS, 300, 200, 99, "direct"}, {ALL, 131, 83, 140, "fft"},
    {ALL, 9, 7, 3, "direct"},     {MANY, 400, 300, 121, "fft"},
};
enum { ROWS = COUNT(rows) };

/* A handful of sources go by direct, others by fft, alone and after any other
 * frame, on any number of threads: the same engine, words and bytes. */
static void a_frame_alone_decides(void **state)
{
    struct gp_glare all = {0};
    for (int pass = 0; pass < 2; pass++) {
        for (int i = 0; i < ROWS; i++) {
            const struct row *const r = &rows[pass ? ROWS - 1 - i : i];
            struct scene s = scene_of(r->light, r->w, r->h, r->kernel);
            struct gp_glare own = {0};
            const struct glarepp_layer_facts alone = run_auto(&s, 1e-3, 0.0, &own);
            const uint64_t hash = scene_hash(&s);
            assert_string_equal(alone.engine, r->engine);
            gp_set_threads(1 + i % 3);
            const struct glarepp_layer_facts then = run_auto(&s, 1e-3, 0.0, &all);
            assert_string_equal(then.why, alone.why);
            assert_true(scene_hash(&s) == hash);
            gp_set_threads(0);
            gp_glare_close(&own);
            scene_free(&s);
        }
    }
    gp_glare_close(&all);
}

/* The bound keeps the tolerance, or one warning and the report say that none
 * does; and the layer keeps the bound. */
static void the_tolerance_is_kept_or_a_warning_printed(void **state)
{
    static const double tolerance[] = {1.0, 1e-3, 1e-9, 0.0};
    for (int i = 0; i < 8; i++) {
        struct scene s = scene_of(FEW, 97, 61, i / 4 ? 31 : 91);
        struct gp_glare g = {0};
        const double most = tolerance[i % 4];
        const struct glarepp_layer_facts stats = run_auto(&s, most, 0.0, &g);
        const bool within = stats.bound <= (double) (float) most;
        assert_true(scene_rel_l2(&s) <= stats.bound);
        assert_int_equal(within, i % 4 < 2);
        assert_int_equal(kept_warning[0] == '\0', within);
        assert_int_equal(strstr(stats.why, "the lowest there is") == NULL,
                         within);
        assert_int_equal(strncmp(stats.why, stats.engine,
                                 strlen(stats.engine)), 0);
        run_auto(&s, most, 0.0, &g); // said once
        assert_string_equal(kept_warning, "");
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* A bound over the tolerance is not taken without a word. */
static void a_bound_over_the_tolerance_is_not_taken(void **state)
{
    struct scene s = scene_of(ALL, 300, 200, 99);
    for (double most = 1e-4; most > 1e-9; most *= 0.7) {
        struct gp_glare g = {0};
        const struct glarepp_layer_facts stats = run_auto(&s, most, 0.0, &g);
        assert_int_equal(kept_warning[0] == '\0',
                         stats.bound <= (double) (float) most);
        gp_glare_close(&g);
    }
    scene_free(&s);
}

/* Of a pixel, fft goes to double where float is over the tolerance. */
static void a_pixel_may_need_double(void **state)
{
    struct scene s = scene_of(ALL, 300, 200, 99);
    struct gp_glare g = {0};
    const struct glarepp_layer_facts loose = run_auto(&s, 1e-3, 1.0, &g);
    assert_true(loose.bound_pixel > 0.0 && !loose.in_double);
    const struct glarepp_layer_facts tight =
        run_auto(&s, 1e-3, 0.5 * loose.bound_pixel, &g);
    assert_true(tight.in_double);
    assert_true(tight.bound_pixel <= 0.5 * loose.bound_pixel);
    assert_non_null(strstr(tight.why, "in double"));
    assert_string_equal(kept_warning, "");
    gp_glare_close(&g);
    scene_free(&s);
}

SUITE_OF(plan, NULL, NULL,
    a_frame_alone_decides, the_tolerance_is_kept_or_a_warning_printed,
    a_bound_over_the_tolerance_is_not_taken, a_pixel_may_need_double)
