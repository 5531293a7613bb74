// SPDX-License-Identifier: Apache-2.0
/* The planner: which engine, the tolerances, and that no frame before decides. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
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

/* A far field that a coarse grid holds badly, as no model's is. */
static void rippling(const void *ctx, int x, int y, double out[3])
{
    const double r = hypot(x, y);
    (void) ctx;
    out[0] = 1e-4 * exp(-r / 60.0) * (1.2 + cos(2.0 * acos(-1.0) * r / 19.0));
}

enum { FAR_W = 260, FAR_H = 200 };

/* A kernel of that far field and a dim core, and its exact layer. */
static struct scene far_scene(void)
{
    const struct gp_far_split split = gp_far_choose(0.0, 1.0, 0, FAR_W, FAR_H);
    const int w = 2 * FAR_W - 1, h = 2 * FAR_H - 1;
    struct gp_planes one, all;
    struct gp_kernel k, plain;
    struct scene s;
    assert_ok(gp_planes_make(NULL, "core", 1, &one));
    assert_ok(gp_planes_make(NULL, "all", (size_t) w * (size_t) h, &all));
    for (int i = 0; i < 3 * w * h; i++) {
        const int x = i / 3 % w - w / 2, y = i / 3 / w - h / 2;
        double v[3];
        rippling(NULL, x, y, v);
        all.c[i % 3][i / 3] = (float) (v[0] * gp_far_share(&split, x, y)) +
                              (x == 0 && y == 0 ? 1e-4f : 0.0f);
    }
    for (int c = 0; c < 3; c++)
        one.c[c][0] = 1e-4f;
    assert_ok(gp_kernel_of_planes(NULL, "core", 1, 1, &one, &k));
    assert_ok(gp_kernel_of_planes(NULL, "all", w, h, &all, &plain));
    s = scene_make(scene_frame(FAR_W, FAR_H, 0, 0, CORNERS, 1u), plain, &usual);
    assert_ok(gp_far_make(NULL, &split, FAR_W, FAR_H,
                          &(struct gp_far_kernel) {rippling, NULL, true, true},
                          &k.far));
    for (int c = 0; c < 3; c++) {
        k.norm1[c] += k.far->norm1[c];
        k.norm2[c] += k.far->norm2[c];
    }
    gp_kernel_free(&s.k);
    s.k = k;
    return s;
}

/* The light that the far field's grid does not hold is in the bound that is reported, of a
 * named engine too; it is over what roundings are. */
static void a_far_field_is_in_the_bound(void **state)
{
    static const char *const engines[] = {"auto", "fft"};
    struct scene s = far_scene();
    for (size_t i = 0; i < 2 * COUNT(engines); i++) {
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct glarepp_layer_facts stats = {0};
        p.engine = engines[i / 2];
        p.in_double = i % 2;
        p.tolerance = 1e9f;
        assert_ok(gp_glare_run(&kept_log, &p, &g, &s.src, &s.k, &s.f, &stats));
        const double wrong = scene_rel_l2(&s);
        print_message("%s: %g, bound %g\n", engines[i / 2], wrong, stats.bound);
        assert_true(wrong > 1e-3 && wrong <= stats.bound);
        gp_glare_close(&g);
    }
    scene_free(&s);
}

/* The whole kernel is summed if a far field guarantees a pixel too little. */
static void a_pixel_may_need_the_whole_kernel(void **state)
{
    struct scene s = scene_sense(scene_frame(FAR_W, FAR_H, 0, 0, FEW, 3u),
                                 (struct gp_kernel) {0}, &usual);
    const struct gp_field field = scene_field(FAR_W, FAR_H, 1.0 / 12.0, 1.0);
    struct gp_glare g = {0};
    model_make("spencer", &field, &s.k);
    assert_non_null(s.k.far);
    const struct glarepp_layer_facts loose = run_auto(&s, 1.0, 1e9, &g);
    assert_null(strstr(loose.why, "whole"));
    const struct glarepp_layer_facts tight =
        run_auto(&s, 1.0, 0.1 * loose.bound_pixel, &g);
    print_message("%s\n%s\n", loose.why, tight.why);
    assert_non_null(strstr(tight.why, "whole"));
    assert_true(tight.bound_pixel <= 0.1 * loose.bound_pixel);
    assert_string_equal(kept_warning, "");
    gp_glare_close(&g);
    scene_free(&s);
}

/* Products that a sum makes on a channel, one by one. */
static double products(const struct scene *s)
{
    double n = 0.0;
    for (int y = 0; y < s->src.h; y++) {
        for (uint32_t i = s->src.row[y]; i < s->src.row[y + 1]; i++) {
            for (int k = 0; k < s->k.w * s->k.h; k++) {
                const int px = s->src.x[i] + k % s->k.w - s->k.cx;
                const int py = y + k / s->k.w - s->k.cy;
                n += px >= 0 && px < s->src.w && py >= 0 && py < s->src.h;
            }
        }
    }
    return n;
}

/* The time of a sum that a warning names grows with its products, by true angles
 * with the pairs of a source and a pixel too, and threads share it. */
static void a_sum_takes_time_of_its_products(void **state)
{
    static char any[] = "any"; // is not looked into
    double each[2] = {0};
    for (int i = 0; i < ROWS; i++) {
        struct scene s =
            scene_of(rows[i].light, rows[i].w, rows[i].h, rows[i].kernel);
        struct gp_kernel wide = s.k;
        const struct gp_glare_request plane = {.src = &s.src, .kernel = &s.k};
        const struct gp_glare_request sky = {.src = &s.src, .kernel = &wide};
        const double pairs = (double) s.src.n * s.src.w * s.src.h;
        wide.sky = (struct gp_sky *) (void *) any;
        gp_set_threads(1);
        const double one = gp_sum_seconds(&plane);
        const double more = gp_sum_seconds(&sky) - one;
        each[0] = i ? each[0] : one / products(&s);
        each[1] = i ? each[1] : more / pairs;
        assert_true(fabs(one / products(&s) / each[0] - 1.0) < 1e-9);
        assert_true(fabs(more / pairs / each[1] - 1.0) < 1e-9);
        gp_set_threads(2);
        assert_true(fabs(2.0 * gp_sum_seconds(&plane) / one - 1.0) < 1e-9);
        gp_set_threads(0);
        scene_free(&s);
    }
    // a processor of these years does 1 to 16 billions a second, and from two to
    // thirty millions of pairs
    assert_true(each[0] > 6e-11 && each[0] < 1e-9);
    assert_true(each[1] > 3e-8 && each[1] < 5e-7);
}

/* Engine direct warns of a time that is long, and of no other. */
static void a_long_sum_is_a_warning(void **state)
{
    struct gp_glare g = {0};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct glarepp_layer_facts stats;
    struct scene s = scene_of(FEW, 97, 61, 31);
    p.engine = "direct";
    kept_clear();
    assert_ok(gp_glare_run(&kept_log, &p, &g, &s.src, &s.k, &s.f, &stats));
    assert_string_equal(kept_warning, "");
    gp_glare_close(&g);
    scene_free(&s);
}

SUITE_OF(plan, NULL, NULL, a_sum_takes_time_of_its_products,
         a_long_sum_is_a_warning, a_frame_alone_decides,
         the_tolerance_is_kept_or_a_warning_printed,
         a_bound_over_the_tolerance_is_not_taken, a_pixel_may_need_double,
         a_far_field_is_in_the_bound, a_pixel_may_need_the_whole_kernel)
