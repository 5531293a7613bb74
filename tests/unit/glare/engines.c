/* All engines: the table of hard cases against the reference, the laws of a
 * convolution, bounds, auto. GLAREPP_TEST_QUICK leaves out GL, large cases. */
#include "unit.h"
#include "core/parallel.h"
#include "hard_cases.h"

static const int threads[] = {1, 2, 4, 7};
enum { THREADS = COUNT(threads) };

/* -- the table --------------------------------------------------------------*/

static int is_dark(const struct scene *s)
{
    for (size_t i = 0; i < 3 * gp_frame_pixels(&s->f); i++) {
        if (s->exact[i] != 0.0)
            return 0;
    }
    return 1;
}

static int misses;

/* All cells are run before the test fails. */
static void miss(const struct hard_case *h, const char *engine,
                 const char *what, double got, double want)
{
    print_error("%s, %s: %s is %g, not %g\n", h->name, engine, what, got, want);
    misses++;
}

static void check_cell(const struct hard_case *h, const char *engine,
    const struct scene *s, const struct gp_glare_stats *stats)
{
    struct gp_glare_error e;
    const double bar = hard_bar(h, engine);
    gp_glare_measure(&s->f, &s->f.layer, s->exact, 1.0f, &e);
    if (!(bar > 0.0))
        miss(h, engine, "bar in hard_cases.h", bar, 0.0);
    if (is_dark(s)) {
        if (!(e.max_abs == 0.0 && e.rel_l2 == 0.0))
            miss(h, engine, "max_abs", e.max_abs, 0.0);
        return;
    }
    if (!(e.rel_l2 <= bar))
        miss(h, engine, "rel_l2", e.rel_l2, bar);
    if (!(stats->bound > 0.0))
        miss(h, engine, "bound", stats->bound, INFINITY);
    if (isfinite(stats->bound) && !(e.rel_l2 <= stats->bound))
        miss(h, engine, "rel_l2 against the bound", e.rel_l2, stats->bound);
    if (h->shape == LOBES && isfinite(stats->bound))
        miss(h, engine, "bound where light cancels", stats->bound, INFINITY);
    const double own = scene_own_error(s);
    if (h->own > 0.0 && strcmp(engine, "fft") == 0 && !(own <= h->own))
        miss(h, engine, "error over a pixel's own value", own, h->own);
}

/* One state for the whole table: frames and kernels change under way, and no
 * byte may show it. */
static void check_row(const struct hard_case *h, struct gp_glare *kept)
{
    struct scene s = hard_scene(h);
    if (h->sources && s.src.n != h->sources)
        miss(h, "sensors", "sources", (double) s.src.n, (double) h->sources);
    for (int i = 0; gp_engines[i]; i++) {
        const char *const engine = gp_engines[i]->name;
        struct gp_glare_stats stats, again;
        if (!ran(engine, &s, kept, &stats, h->name))
            continue;
        check_cell(h, engine, &s, &stats);
        const uint64_t hash = scene_hash(&s);
        // a context takes a tenth of a second: the suite splat does this for GL
        if (strcmp(engine, "splat") == 0)
            continue;
        ran_once(engine, &s, &again, h->name);
        if (scene_hash(&s) != hash || again.bound != stats.bound)
            miss(h, engine, "bound when the state is kept, or the layer",
                 stats.bound, again.bound);
    }
    scene_free(&s);
}

static void hard_cases_hold(void **state)
{
    struct gp_glare kept = {0};
    for (int i = 0; i < HARD_CASES; i++) {
        if (!quick || hard_is_quick(&hard_cases[i]))
            check_row(&hard_cases[i], &kept);
    }
    gp_glare_close(&kept);
    assert_int_equal(misses, 0);
    for (int i = 0; gp_engines[i]; i++)
        assert_null(kept.state[i]);
}

/* -- threads, auto, names ---------------------------------------------------*/

static const struct gp_sensor_params open_all = {0.0f, 0.0f, 1e10f};

static struct scene law_scene(enum light light, uint32_t seed)
{
    return scene_make(scene_frame(97, 61, 0, 0, light, seed),
                      scene_kernel(31, 29, MID, 0, TINTED), &usual);
}

static struct scene thread_scene(int i)
{
    static const enum light lights[] = {FEW, ALL, HOT, CORNERS};
    const struct gp_sensor_params *const p = i == 2 ? &open_all : &usual;
    return scene_make(scene_frame(131, 83, 0, 0, lights[i], 8u),
                      scene_kernel(31, 29, MID, 0, i % 2 ? PEAK : TINTED), p);
}
enum { THREAD_SCENES = 4 };

/* What auto picks must not depend on the threads, or the bytes would. */
static void auto_asks_no_threads(void **state)
{
    for (int k = 0; k < THREAD_SCENES && !quick; k++) {
        struct scene s = thread_scene(k);
        struct gp_glare_stats first = {0}, stats;
        for (int t = 0; t < THREADS; t++) {
            gp_set_threads(threads[t]);
            if (!ran_once("auto", &s, &stats, "auto"))
                break;
            first = t == 0 ? stats : first;
            assert_string_equal(stats.engine, first.engine);
            assert_string_equal(stats.why, first.why);
        }
        assert_true(scene_rel_l2(&s) <= usual_bar(stats.engine));
        scene_free(&s);
    }
    gp_set_threads(0);
}

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
            const struct gp_glare_job job = {
                .params = &p, .src = &s.src, .kernel = &s.k, .stats = &stats,
            };
            double bound;
            assert_ok(gp_engines[e]->bound(&job, &g.state[e], &bound));
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
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_frame image = {.data = {0, 0, SIDE, SIDE}};
    struct gp_kernel k;
    p.normalize = GP_NORMALIZE_NONE;
    assert_ok(gp_planes_make(NULL, "kernel", N, &image.rgb));
    for (int i = 0; i < 3 * N; i++)
        image.rgb.c[i / N][i % N] = i % N == 0 ? 1.0f : rest;
    assert_ok(gp_kernel_from_frame(NULL, &p, &image, &k));
    gp_planes_free(&image.rgb);
    struct gp_frame f = scene_frame(33, 31, 0, 0, DARK, 1);
    for (int c = 0; c < 3; c++) {
        memset(f.rgb.c[c], 0, gp_frame_pixels(&f) * sizeof(float));
        f.rgb.c[c][33 + 1] = 1.0f; // its upper left is outside
    }
    return scene_make(f, k, &open_all);
}

/* What leaves the range of float downwards is in the bound; of kernels under
 * it nothing is left, and the kernel says so. */
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

/* Of direct and fft, whose bounds keep the tolerance, the one of the least
 * prediction; each engine is in the words. */
static void auto_takes_the_fastest(void **state)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    for (int k = 0; k < THREAD_SCENES && !quick; k++) {
        struct scene s = thread_scene(k);
        struct gp_glare_stats stats;
        const struct gp_glare_job job = {
            .params = &p, .src = &s.src, .kernel = &s.k,
        };
        const struct gp_engine *best = gp_engines[0];
        for (int i = 0; gp_engines[i]; i++) {
            assert_true(gp_engines[i]->predict(&job, NULL).ms > 0.0);
            if (gp_engines[i]->predict(&job, NULL).ms <
                best->predict(&job, NULL).ms)
                best = gp_engines[i];
        }
        if (ran_once("auto", &s, &stats, "auto")) {
            assert_string_equal(stats.engine, best->name);
            for (int i = 0; gp_engines[i]; i++)
                assert_non_null(strstr(stats.why, gp_engines[i]->name));
        }
        scene_free(&s);
    }
}

static void names_are_checked(void **state)
{
    struct scene s = law_scene(FEW, 9u), dark = law_scene(DARK, 9u);
    struct gp_glare g = {0};
    struct gp_glare_stats stats;
    assert_int_equal(scene_run("ftt", &s, &g, &stats), GP_ERR_USAGE);
    assert_non_null(strstr(scene_line, "ftt"));
    for (int i = 0; gp_engines[i]; i++)
        assert_non_null(strstr(scene_line, gp_engines[i]->name));
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

/* |a + b - sum| / |sum| over all samples; exact layers are not looked at. */
static double sum_error(const struct gp_planes *a, const struct gp_planes *b,
                        const struct gp_planes *sum, size_t n)
{
    double wrong = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const double s = (double) sum->c[c][i];
            const double d = (double) a->c[c][i] + (double) b->c[c][i] - s;
            wrong += d * d;
            all += s * s;
        }
    }
    return sqrt(wrong / all);
}

/* layer(a) + layer(b) = layer(a + b) */
static void layers_add_up(void **state)
{
    struct scene a = law_scene(FEW, 1u), b = law_scene(ALL, 2u);
    struct gp_frame both = scene_frame(97, 61, 0, 0, DARK, 0u);
    const size_t n = gp_frame_pixels(&both);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            both.rgb.c[c][i] = b.f.rgb.c[c][i];
        for (int y = 0; y < 61; y++) {
            for (uint32_t i = a.src.row[y]; i < a.src.row[y + 1]; i++)
                both.rgb.c[c][y * 97 + a.src.x[i]] += a.src.rgb[c][i];
        }
    }
    struct scene s = scene_make(both, scene_kernel(31, 29, MID, 0, TINTED),
                                &(struct gp_sensor_params) {1.0f, 0.0f, 1e6f});
    assert_int_equal(s.src.n, n);
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &a, &stats, "a") || !ran_once(e, &b, &stats, "b") ||
            !ran_once(e, &s, &stats, "a + b"))
            continue;
        const double error = sum_error(&a.f.layer, &b.f.layer, &s.f.layer, n);
        if (!(error <= 2.0 * usual_bar(e)))
            fail_msg("%s: layers do not add up (%g)", e, error);
    }
    scene_free(&a);
    scene_free(&b);
    scene_free(&s);
}

/* Four times the light is four times the layer, to the bit: no engine has a
 * scale of its own. */
static void layers_scale(void **state)
{
    struct scene a = law_scene(FEW, 3u);
    struct gp_frame f = scene_frame(97, 61, 0, 0, FEW, 3u);
    const size_t n = gp_frame_pixels(&f);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            f.rgb.c[c][i] *= 4.0f;
    }
    struct scene b = scene_make(f, scene_kernel(31, 29, MID, 0, TINTED),
                                &(struct gp_sensor_params) {4.0f, 0.0f, 1e6f});
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &a, &stats, "a") || !ran_once(e, &b, &stats, "4 a"))
            continue;
        for (int c = 0; c < 3; c++) {
            for (size_t j = 0; j < n; j++) {
                if (b.f.layer.c[c][j] != 4.0f * a.f.layer.c[c][j])
                    fail_msg("%s: sample %zu does not scale", e, j);
            }
        }
    }
    scene_free(&a);
    scene_free(&b);
}

/* The frame's pixels moved by (dx, dy); what enters is background. */
static struct gp_frame moved(int dx, int dy)
{
    struct gp_frame f = scene_frame(97, 61, 0, 0, DARK, 4u);
    struct gp_frame from = scene_frame(97, 61, 0, 0, MIDDLE, 4u);
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < 61; y++) {
            for (int x = 0; x < 97; x++) {
                const int sx = x - dx, sy = y - dy;
                if (sx >= 0 && sx < 97 && sy >= 0 && sy < 61)
                    f.rgb.c[c][y * 97 + x] = from.rgb.c[c][sy * 97 + sx];
            }
        }
    }
    gp_frame_free(&from);
    return f;
}

/* |moved layer - layer| / |layer| over the pixels that both frames have. */
static double shift_error(const struct gp_planes *a, const struct gp_planes *b,
                          int dx, int dy)
{
    double wrong = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        for (int y = 0; y < 61; y++) {
            for (int x = 0; x < 97; x++) {
                const int to_x = x + dx, to_y = y + dy;
                if (to_x < 0 || to_x >= 97 || to_y < 0 || to_y >= 61)
                    continue;
                const double v = (double) a->c[c][y * 97 + x];
                const double d = (double) b->c[c][to_y * 97 + to_x] - v;
                wrong += d * d;
                all += v * v;
            }
        }
    }
    return sqrt(wrong / all);
}

static void light_moves_its_layer(void **state)
{
    static const int steps[][2] = {{1, 0}, {0, 1}, {-19, 7}, {30, -18}};
    struct scene a = scene_make(moved(0, 0),
                                scene_kernel(31, 29, MID, 0, TINTED), &usual);
    assert_true(a.src.n > 1);
    for (size_t k = 0; k < COUNT(steps); k++) {
        const int dx = steps[k][0], dy = steps[k][1];
        struct scene b = scene_make(moved(dx, dy), scene_kernel(31, 29, MID, 0,
            TINTED), &usual);
        assert_int_equal(b.src.n, a.src.n);
        for (int i = 0; gp_engines[i]; i++) {
            const char *const e = gp_engines[i]->name;
            struct gp_glare_stats stats;
            if (!ran_once(e, &a, &stats, "a") ||
                !ran_once(e, &b, &stats, "moved"))
                continue;
            const double error = shift_error(&a.f.layer, &b.f.layer, dx, dy);
            if (!(error <= 2.0 * usual_bar(e)))
                fail_msg("%s: moved by %d, %d: %g", e, dx, dy, error);
        }
        scene_free(&b);
    }
    scene_free(&a);
}

/* The window's place is no part of the sum. */
static void windows_change_no_byte(void **state)
{
    static const int corner[][2] = {
        {-1000, 3}, {7, -90000}, {1 << 20, 1 << 20},
    };
    struct scene a = law_scene(FEW, 5u);
    for (int i = 0; gp_engines[i]; i++) {
        struct gp_glare_stats stats;
        if (!ran_once(gp_engines[i]->name, &a, &stats, "window"))
            continue;
        const uint64_t hash = scene_hash(&a);
        for (size_t k = 0; k < COUNT(corner); k++) {
            struct scene b = scene_make(
                scene_frame(97, 61, corner[k][0], corner[k][1], FEW, 5u),
                scene_kernel(31, 29, MID, 0, TINTED), &usual);
            ran_once(gp_engines[i]->name, &b, &stats, "window");
            assert_true(scene_hash(&b) == hash);
            scene_free(&b);
        }
    }
    scene_free(&a);
}

/* A kernel of one pixel gives the sources back: exactly where the sum is
 * taken as it is written, to the bar through a transform. */
static void identity_gives_the_sources(void **state)
{
    struct gp_planes image;
    struct scene s = scene_make(scene_frame(97, 61, 0, 0, FEW, 6u),
                                scene_kernel(1, 1, MID, 0, BOX),
                                &(struct gp_sensor_params) {0.3f, 0.5f, 1e9f});
    const size_t n = gp_frame_pixels(&s.f);
    s.k.k.c[0][0] = s.k.k.c[1][0] = s.k.k.c[2][0] = 1.0f;
    assert_ok(gp_sources_planes(NULL, &s.src, &image));
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &s, &stats, "identity"))
            continue;
        for (size_t j = 0; j < 3 * n; j++)
            s.exact[j] = (double) image.c[j / n][j % n];
        const double rel_l2 = scene_rel_l2(&s);
        const double bar = strcmp(e, "fft") == 0 ? usual_bar(e) : 0.0;
        if (!(rel_l2 <= bar))
            fail_msg("%s: identity is %g off", e, rel_l2);
    }
    gp_planes_free(&image);
    scene_free(&s);
}

/* Sources whose whole kernel is in the frame lose no light. */
static void light_is_kept(void **state)
{
    struct scene s = law_scene(MIDDLE, 7u);
    assert_true(s.src.box.x0 >= 15 && s.src.box.x1 <= 97 - 15);
    assert_true(s.src.box.y0 >= 14 && s.src.box.y1 <= 61 - 14);
    for (int i = 0; gp_engines[i]; i++) {
        const char *const e = gp_engines[i]->name;
        struct gp_glare_stats stats;
        if (!ran_once(e, &s, &stats, "flux"))
            continue;
        for (int c = 0; c < 3; c++) {
            const double want = s.src.flux[c] * s.k.sum[c];
            double flux = 0.0;
            for (size_t j = 0; j < gp_frame_pixels(&s.f); j++)
                flux += (double) s.f.layer.c[c][j];
            if (!(fabs(flux - want) <= usual_bar(e) * want))
                fail_msg("%s: flux %.9g, not %.9g", e, flux, want);
        }
    }
    scene_free(&s);
}

SUITE_OF(engines, ask_quick, NULL,
    hard_cases_hold, auto_asks_no_threads, bounds_hold, bounds_know_the_range,
    auto_takes_the_fastest, names_are_checked, layers_add_up, layers_scale,
    light_moves_its_layer, windows_change_no_byte, identity_gives_the_sources,
    light_is_kept)
