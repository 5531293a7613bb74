/* All engines: bounds, names, the laws of a convolution. GLAREPP_TEST_QUICK
 * leaves out GL and large cases. The table of hard cases is in tests/hard. */
#include "unit.h"
#include "hard_cases.h"

static int is_dark(const struct scene *s)
{
    for (size_t i = 0; i < 3 * gp_frame_pixels(&s->f); i++) {
        if (s->exact[i] != 0.0)
            return 0;
    }
    return 1;
}

/* -- bounds, names ---------------------------------------------------*/

/* Every bound that auto goes by holds, and is what the run reports. */
static void bounds_hold(void **state)
{
    static const enum light lights[] = {ALL, FEW, CORNERS, RAMP, BLOCK, HOT};
    static const enum shape shapes[] = {PEAK, TINTED, BOX, RING, BORDER};
    static const struct { int w, h, kernel; } size[] = {
        {1, 1, 3}, {97, 61, 31}, {64, 64, 33}, {131, 83, 140}, {257, 31, 9},
    };
    const int sizes = quick ? 2 : 5;
    double least = INFINITY;
    for (int i = 0; i < 6 * 5 * sizes; i++) {
        const int at = i / 30;
        struct scene s = scene_make(scene_frame(size[at].w, size[at].h, 0, 0,
            lights[i % 6], (uint32_t) i + 1), scene_kernel(size[at].kernel,
            size[at].kernel, MID, 0, shapes[i / 6 % 5]), &usual);
        for (int e = 0; s.src.n && !is_dark(&s) && e < 2; e++) {
            struct gp_glare g = {0};
            struct gp_glare_stats stats;
            struct gp_glare_params p = GP_GLARE_DEFAULTS;
            const struct gp_glare_request req = {
                .params = &p, .src = &s.src, .kernel = &s.k, .stats = &stats,
            };
            double bound;
            assert_ok(gp_engines[e]->bound(&req, &g.state[e], &bound));
            assert_ok(scene_run(gp_engines[e]->name, &s, &g, &stats));
            const double rel_l2 = scene_rel_l2(&s);
            // a run does not look for the least that these sources leave
            if (!(rel_l2 <= bound && bound <= stats.bound))
                fail_msg("%s, scene %d: rel_l2 %g, bound %g, reported %g",
                    gp_engines[e]->name, i, rel_l2, bound, stats.bound);
            if (e == 1 && rel_l2 > 0.0)
                least = fmin(least, bound / rel_l2);
            gp_glare_close(&g);
        }
        scene_free(&s);
    }
    print_message("fft: the bound is %.1f times what was measured, or more\n",
                  least);
}

/* A kernel of 1 where no light lands, and of `rest` elsewhere: what a frame
 * of one source sees of it is far under its peak. */
static struct scene beside(float rest)
{
    enum { SIDE = 9, N = SIDE * SIDE };
    struct gp_kernel_params p = {0};
    struct gp_frame image = scene_frame(SIDE, SIDE, 0, 0, BLACK, 1);
    struct gp_frame f = scene_frame(33, 31, 0, 0, BLACK, 1);
    struct gp_kernel k;
    p.normalize = GP_NORMALIZE_NONE;
    for (int i = 0; i < 3 * N; i++)
        image.rgb.c[i / N][i % N] = i % N == 0 ? 1.0f : rest;
    assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
    gp_frame_free(&image);
    for (int c = 0; c < 3; c++)
        f.rgb.c[c][33 + 1] = 1.0f; // its upper left is outside
    return scene_make(f, k, &open_all);
}

/* Values that leave the range of float downwards are in the bound; of kernels
 * under it nothing is left, and the kernel says so. */
static void bounds_know_the_range(void **state)
{
    static const float rests[] = {1e-3f,  1e-20f, 1e-30f,
                                  1e-36f, 2e-38f, 1e-42f};
    int large = 0;
    for (size_t r = 0; r < COUNT(rests); r++) {
        struct scene s = beside(rests[r]);
        const bool faint = rests[r] < FLT_MIN;
        assert_int_equal(s.k.faint[1] > 0.0, faint);
        assert_int_equal(is_dark(&s), faint);
        for (int i = 0; gp_engines[i]; i++) {
            struct gp_glare_stats stats;
            if (!ran_once(gp_engines[i]->name, &s, &stats, "range"))
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
        struct gp_frame image = scene_frame(SIDE, SIDE, 0, 0, BLACK, 1);
        struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 1);
        struct gp_kernel k;
        for (int i = 0; i < 3 * SIDE * SIDE; i++)
            image.rgb.c[i % 3][i / 3] =
                rows[r].kernel / (float) (1 + i / 3 % SIDE);
        for (int i = 0; i < 3 * W * H; i++)
            f.rgb.c[i % 3][i / 3] = rows[r].light;
        assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
        gp_frame_free(&image);
        struct scene s = scene_sense(f, k, &open_all);
        for (int i = 0; gp_engines[i]; i++) {
            struct gp_glare_stats stats;
            kept_clear();
            if (!ran_once(gp_engines[i]->name, &s, &stats, "overflow"))
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
    struct gp_glare_stats stats;
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

/* -- laws -------------------------------------------------------------------*/

enum { LAW_W = 97, LAW_H = 61, LAW_N = LAW_W * LAW_H };

/* Takes the frame: its layer by the engine, and an exact one to be filled. */
static struct scene law_scene(const char *engine, struct gp_frame f,
                              float threshold)
{
    struct scene s =
        scene_sense(f, scene_kernel(31, 29, MID, 0, TINTED),
                    &(struct gp_sensor_params) WHOLE(threshold, 0.0f, 1e6f));
    struct gp_glare_stats stats;
    ran_once(engine, &s, &stats, "law");
    s.exact = scene_alloc(3 * LAW_N, sizeof *s.exact);
    return s;
}

static struct scene law_light(const char *engine, enum light light,
                              uint32_t seed)
{
    return law_scene(engine, scene_frame(LAW_W, LAW_H, 0, 0, light, seed),
                     1.0f);
}

/* layer(a) + layer(b) = layer(a + b) */
static double layers_add_up(const char *engine)
{
    struct scene a = law_light(engine, FEW, 1u);
    struct scene b = law_light(engine, ALL, 2u);
    struct gp_frame both = scene_frame(LAW_W, LAW_H, 0, 0, DARK, 0u);
    for (int i = 0; i < 3 * LAW_N; i++) {
        const float few = a.f.rgb.c[i / LAW_N][i % LAW_N];
        both.rgb.c[i / LAW_N][i % LAW_N] =
            b.f.rgb.c[i / LAW_N][i % LAW_N] + (few > 1.0f ? few : 0.0f);
    }
    struct scene s = law_scene(engine, both, 1.0f);
    assert_int_equal(s.src.n, LAW_N);
    for (int i = 0; i < 3 * LAW_N; i++)
        s.exact[i] = (double) a.f.layer.c[i / LAW_N][i % LAW_N] +
                     (double) b.f.layer.c[i / LAW_N][i % LAW_N];
    const double error = scene_rel_l2(&s);
    scene_free(&a);
    scene_free(&b);
    scene_free(&s);
    return error;
}

/* Four times the light is four times the layer, to the bit: no engine has a
 * scale of its own. */
static double layers_scale(const char *engine)
{
    struct scene a = law_light(engine, FEW, 3u);
    struct gp_frame f = scene_frame(LAW_W, LAW_H, 0, 0, FEW, 3u);
    for (int i = 0; i < 3 * LAW_N; i++)
        f.rgb.c[i / LAW_N][i % LAW_N] *= 4.0f;
    struct scene b = law_scene(engine, f, 4.0f);
    for (int i = 0; i < 3 * LAW_N; i++)
        b.exact[i] = 4.0 * (double) a.f.layer.c[i / LAW_N][i % LAW_N];
    const double error = scene_rel_l2(&b);
    scene_free(&a);
    scene_free(&b);
    return error;
}

/* Light that moves takes its layer with it; what enters is background. Only
 * pixels that both frames have are looked at. */
static double layers_move(const char *engine)
{
    static const int steps[][2] = {{1, 0}, {0, 1}, {-19, 7}, {30, -18}};
    struct scene a = law_light(engine, MIDDLE, 4u);
    double error = 0.0;
    assert_true(a.src.n > 1);
    for (size_t k = 0; k < COUNT(steps); k++) {
        struct gp_frame f = scene_frame(LAW_W, LAW_H, 0, 0, DARK, 4u);
        int from[LAW_N]; // the pixel that moved here, or -1
        for (int i = 0; i < LAW_N; i++) {
            const int x = i % LAW_W - steps[k][0], y = i / LAW_W - steps[k][1];
            const bool both = x >= 0 && x < LAW_W && y >= 0 && y < LAW_H;
            from[i] = both ? y * LAW_W + x : -1;
            for (int c = 0; c < 3 && both; c++)
                f.rgb.c[c][i] = a.f.rgb.c[c][from[i]];
        }
        struct scene b = law_scene(engine, f, 1.0f);
        assert_int_equal(b.src.n, a.src.n);
        for (int i = 0; i < 3 * LAW_N; i++) {
            const int c = i / LAW_N, at = from[i % LAW_N];
            if (at < 0)
                b.f.layer.c[c][i % LAW_N] = 0.0f;
            else
                b.exact[i] = (double) a.f.layer.c[c][at];
        }
        error += scene_rel_l2(&b);
        scene_free(&b);
    }
    scene_free(&a);
    return error;
}

/* The window's place is no part of the sum. */
static double windows_change_no_byte(const char *engine)
{
    static const int corner[][2] = {
        {-1000, 3}, {7, -90000}, {1 << 20, 1 << 20},
    };
    struct scene a = law_light(engine, FEW, 5u);
    int differ = 0;
    for (size_t k = 0; k < COUNT(corner); k++) {
        struct scene b = law_scene(engine, scene_frame(LAW_W, LAW_H,
            corner[k][0], corner[k][1], FEW, 5u), 1.0f);
        differ += scene_hash(&b) != scene_hash(&a);
        scene_free(&b);
    }
    scene_free(&a);
    return differ;
}

/* A kernel of one pixel gives the sources back: exactly where the sum is
 * taken as it is written, to the bar through a transform. */
static double identity_gives_the_sources(const char *engine)
{
    const struct gp_sensor_params ramp = WHOLE(0.3f, 0.5f, 1e9f);
    struct gp_planes image;
    struct gp_glare_stats stats;
    struct scene s = scene_make(scene_frame(LAW_W, LAW_H, 0, 0, FEW, 6u),
                                scene_kernel(1, 1, MID, 0, BOX), &ramp);
    s.k.k.c[0][0] = s.k.k.c[1][0] = s.k.k.c[2][0] = 1.0f;
    assert_ok(gp_sources_planes(NULL, &s.src, &image));
    for (int i = 0; i < 3 * LAW_N; i++)
        s.exact[i] = (double) image.c[i / LAW_N][i % LAW_N];
    ran_once(engine, &s, &stats, "identity");
    const double error = scene_rel_l2(&s);
    gp_planes_free(&image);
    scene_free(&s);
    return error;
}

/* Sources whose whole kernel is in the frame lose no light. */
static double light_is_kept(const char *engine)
{
    struct scene s = law_light(engine, MIDDLE, 7u);
    double error = 0.0;
    assert_true(s.src.box.x0 >= 15 && s.src.box.x1 <= LAW_W - 15);
    assert_true(s.src.box.y0 >= 14 && s.src.box.y1 <= LAW_H - 14);
    for (int c = 0; c < 3; c++) {
        double flux = 0.0;
        for (int i = 0; i < LAW_N; i++)
            flux += (double) s.f.layer.c[c][i];
        error += fabs(flux / (s.src.flux[c] * s.k.sum[c]) - 1.0);
    }
    scene_free(&s);
    return error;
}

/* An engine may be off a law by so many bars of rel_l2. */
static const struct {
    const char *name;
    double (*error)(const char *engine);
    double fft, others;
} laws[] = {
    {"layers add up", layers_add_up, 2, 2},
    {"layers scale", layers_scale, 0, 0},
    {"light moves its layer", layers_move, 2, 2},
    {"windows change no byte", windows_change_no_byte, 0, 0},
    {"identity gives the sources", identity_gives_the_sources, 1, 0},
    {"light is kept", light_is_kept, 1, 1},
};

static void laws_hold(void **state)
{
    for (int i = 0; gp_engines[i]; i++) {
        const char *const engine = gp_engines[i]->name;
        struct scene s = law_light("direct", FEW, 1u);
        struct gp_glare_stats stats;
        const bool there = ran_once(engine, &s, &stats, "law");
        for (size_t k = 0; k < COUNT(laws) && there; k++) {
            const double error = laws[k].error(engine);
            const double bars =
                strcmp(engine, "fft") == 0 ? laws[k].fft : laws[k].others;
            if (!(error <= bars * usual_bar(engine)))
                fail_msg("%s: %s, %g off", engine, laws[k].name, error);
        }
        scene_free(&s);
    }
}

SUITE_OF(engines, ask_quick, NULL,
    bounds_hold, bounds_know_the_range, overflows_are_limited,
    names_are_checked, laws_hold)
