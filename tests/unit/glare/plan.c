/* The planner: made-up candidates to a choice, sequences, and what the real
 * predictions and bounds promise. */
#include "unit.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"
#include "glare_scene.h"

// -- one frame ----------------------------------------------------------------

enum { MOST = 4 };

struct made_up {
    double ms, later_ms, bound;
    bool exact;
};

struct asked {
    const struct made_up *c;
    struct gp_candidate *candidates;
    double slower;    // ms more of candidate 1, once it was asked
    int times[MOST];
    int all, failing; // the failing-th answer is an error
};

static gp_status answer(void *ctx, int i, double *bound)
{
    struct asked *const a = ctx;
    *bound = a->c[i].bound;
    a->candidates[i].ms += i == 1 ? a->slower : 0.0;
    a->times[i]++;
    return ++a->all == a->failing ? GP_ERR_DATA : GP_OK;
}

static gp_status choose(const struct made_up *from, int n, double tolerance,
    struct gp_plan_past *past, struct asked *asked, struct gp_choice *out)
{
    struct gp_candidate c[MOST] = {0};
    for (int i = 0; i < n; i++)
        c[i] = (struct gp_candidate) {
            .exact = from[i].exact, .ms = from[i].ms, .bound = NAN,
            .later_ms = from[i].later_ms > 0.0 ? from[i].later_ms : from[i].ms,
        };
    *asked = (struct asked) {
        .c = from, .candidates = c, .failing = asked->failing,
        .slower = asked->slower,
    };
    return gp_plan_choose(c, n, tolerance, past, answer, asked, out);
}

static const struct row {
    const char *name;
    double tolerance;
    struct made_up c[MOST]; // ends with ms 0
    int taken;
    bool within;
    int asked; // a digit a candidate: which bounds were asked
} rows[] = {
    {"the faster", 1e-3, {{9, 0, 1e-6, true}, {8, 0, 1e-5, true}}, 1, true, 10},
    {"only its bound is asked", 1e-3,
     {{1, 0, 1e-6, true}, {8, 0, 1e-5, true}, {9, 0, 1e-2, false}}, 0, true, 1},
    {"a fast one that is too wrong", 1e-3,
     {{9, 0, 1e-6, true}, {8, 0, 1e-5, true}, {2, 0, 1e-2, false}}, 1, true,
     110},
    {"a fast one that is right enough", 1e-2,
     {{9, 0, 1e-6, true}, {8, 0, 1e-5, true}, {2, 0, 1e-2, false}}, 2, true,
     110},
    {"too wrong by a hair", 0.999e-2,
     {{9, 0, 1e-6, true}, {8, 0, 1e-5, true}, {2, 0, 1e-2, false}}, 1, true,
     110},
    {"an approximation that saves under a fifth: not asked", 1e-2,
     {{10, 0, 1e-6, true}, {8.01, 0, 1e-4, false}}, 0, true, 1},
    {"an approximation that saves over a fifth", 1e-2,
     {{10, 0, 1e-6, true}, {7.99, 0, 1e-4, false}}, 1, true, 11},
    {"worth it against the fastest exact one only", 1e-2,
     {{99, 0, 1e-6, true}, {10, 0, 1e-6, true}, {9, 0, 1e-4, false}}, 1, true,
     10},
    {"the second of two approximations", 1e-2,
     {{9, 0, 1e-6, true}, {2, 0, 2e-2, false}, {3, 0, 5e-3, false}}, 2, true,
     111},
    {"tolerance 0", 0.0,
     {{90, 0, 1e-6, true}, {8, 0, 1e-5, true}, {2, 0, 1e-3, false}}, 0, false,
     11},
    {"tolerance 0 and a bound of 0", 0.0,
     {{90, 0, 0.0, true}, {8, 0, 1e-5, true}}, 0, true, 11},
    {"tolerance under all roundings", 1e-9,
     {{90, 0, 1e-5, true}, {8, 0, 1e-6, true}}, 1, false, 11},
    {"none keeps it, equal bounds: the faster", 1e-9,
     {{90, 0, 1e-6, true}, {8, 0, 1e-6, true}}, 1, false, 11},
    {"nothing is guaranteed: the faster exact one", 1e-3,
     {{9, 0, INFINITY, true}, {8, 0, INFINITY, true},
      {1, 0, INFINITY, false}}, 1, false, 11},
    {"no number for a bound", 1e-3, {{2, 0, NAN, true}, {8, 0, 1e-5, true}}, 1,
     true, 11},
    {"no number for all", 1e-3, {{2, 0, NAN, true}, {8, 0, NAN, true}}, 0,
     false, 11},
    {"no number for ms", 1e-3, {{NAN, 0, 0, true}, {8, 0, 1e-5, true}}, 1,
     true, 10},
    {"never", 1e-3, {{INFINITY, 0, 0, false}, {8, 0, 1e-5, true}}, 1, true, 10},
    {"equal: the first", 1e-3, {{8, 0, 1e-5, true}, {8, 0, 1e-5, true}}, 0,
     true, 1},
    {"infinite tolerance", INFINITY,
     {{8, 0, INFINITY, true}, {1, 0, INFINITY, false}}, 1, true, 11},
    {"the only one", 1e-3, {{8, 0, 1, true}}, 0, false, 1},
};

static void one_frame(void **state)
{
    for (size_t r = 0; r < COUNT(rows); r++) {
        const struct row *const w = &rows[r];
        struct gp_plan_past past = {0};
        struct asked asked = {0};
        struct gp_choice got;
        int n = 0, digits = 0;
        while (n < MOST && w->c[n].ms != 0.0)
            n++;
        assert_ok(choose(w->c, n, w->tolerance, &past, &asked, &got));
        for (int i = 0, unit = 1; i < n; i++, unit *= 10) {
            assert_true(asked.times[i] <= 1);
            digits += unit * asked.times[i];
        }
        if (got.taken != w->taken || got.within != w->within || got.kept ||
            digits != w->asked)
            fail_msg("%s: took %d (within %d, kept %d, asked %d)", w->name,
                     got.taken, got.within, got.kept, digits);
        assert_int_equal(past.last, got.taken + 1);
    }
}

/* A bound that cannot be had ends the choice, whichever it is, and what was
 * before stays. */
static void questions_may_fail(void **state)
{
    static const double bounds[][MOST] = {
        {1e-4, 1e-4, 1e-4, 1e-6}, {1.0, 9e-4, 2e-4, 1e-6},
        {9e-4, 9e-4, 9e-4, 9e-4}, {1.0, 1.0, 1.0, 1e-6}, {1.0, 1.0, 1.0, 1.0},
    };
    static const double times[][MOST] = {
        {1, 2, 3, 4}, {4, 3, 2, 1}, {10, 9.5, 9, 10}, {1, 1, 1, 100},
    };
    int failures = 0;
    for (int k = 0; k < 5 * 4 * 5; k++) {
        struct made_up c[MOST];
        for (int i = 0; i < MOST; i++)
            c[i] = (struct made_up) {
                times[k / 5 % 4][i], 0.7 * times[k / 5 % 4][i],
                bounds[k / 20][i], i == MOST - 1,
            };
        struct asked asked = {0};
        for (int n = 0, all = 1; n <= all; n++) { // the first time, none fails
            struct gp_plan_past past = {.last = k % 5, .rival = 1, .lost = 5.0};
            struct gp_choice got;
            asked.failing = n;
            const gp_status st =
                choose(c, MOST, 1e-3, &past, &asked, &got);
            assert_int_equal(st, n ? GP_ERR_DATA : GP_OK);
            if (n == 0) {
                all = asked.all;
                assert_true(all > 0 && got.taken >= 0 && got.taken < MOST);
            } else {
                assert_int_equal(past.last, k % 5);
                failures++;
            }
        }
    }
    assert_true(failures > 100);
}

// -- sequences ----------------------------------------------------------------

/* Two exact engines whose bounds together are 2e-5, one of which, "b", has
 * something to set up; and the frame from which b is taken, counted from 1. */
static const struct change {
    const char *name;
    double tolerance;
    struct made_up a, b;
    double set_up; // of b, until it is taken
    int first;     // 0: never
} changes[] = {
    {"21 % less", 1e-3, {10, 0, 1e-5, 1}, {7.9, 0, 1e-5, 1}, 0, 2},
    {"19 % less: when 10 ms are lost", 1e-3, {10, 0, 1e-5, 1},
     {8.1, 0, 1e-5, 1}, 0, 7},
    {"1 % less: much later", 1e-3, {10, 0, 1e-5, 1}, {9.9, 0, 1e-5, 1}, 0,
     102},
    {"as fast", 1e-3, {10, 0, 1e-5, 1}, {10, 0, 1e-5, 1}, 0, 0},
    {"slower", 1e-3, {10, 0, 1e-5, 1}, {11, 0, 1e-5, 1}, 0, 0},
    {"set-up that 5 ms a frame repay", 1e-3, {10, 0, 1e-5, 1},
     {5, 0, 1e-5, 1}, 20, 8},
    {"set-up that still leaves a gain", 1e-3, {100, 0, 1e-5, 1},
     {5, 0, 1e-5, 1}, 70, 2},
    {"bounds together over the tolerance", 1.9e-5, {10, 0, 1e-5, 1},
     {1, 0, 1e-5, 1}, 0, 0},
    {"bounds together just within", 2.1e-5, {10, 0, 1e-5, 1},
     {1, 0, 1e-5, 1}, 0, 2},
    {"approximate and too wrong", 1e-3, {10, 0, 1e-5, 1},
     {1, 0, 2e-3, 0}, 0, 0},
    {"approximate and right enough", 1e-3, {10, 0, 1e-5, 1},
     {1, 0, 5e-4, 0}, 0, 2},
    {"approximate, 19 % less: its bound takes that", 1e-3, {10, 0, 1e-5, 1},
     {8.1, 0, 5e-4, 0}, 0, 0},
};

/* The first frame is one that b cannot win. */
static void a_choice_is_kept(void **state)
{
    for (size_t r = 0; r < COUNT(changes); r++) {
        const struct change *const w = &changes[r];
        struct gp_plan_past past = {0};
        struct asked asked = {0};
        struct gp_choice got;
        int first = 0;
        for (int frame = 1; frame <= 200; frame++) {
            struct made_up c[2] = {w->a, w->b};
            c[1].later_ms = frame == 1 ? 1e3 : w->b.ms;
            c[1].ms = frame == 1 ? 1e3 : w->b.ms + (first ? 0.0 : w->set_up);
            assert_ok(choose(c, 2, w->tolerance, &past, &asked, &got));
            assert_true(got.within);
            assert_true(!got.kept || got.taken == 0);
            if (got.taken == 1 && !first)
                first = frame;
            if (first) // it never goes back
                assert_int_equal(got.taken, 1);
        }
        if (first != w->first)
            fail_msg("%s: changes at frame %d, not %d", w->name, first,
                     w->first);
    }
}

static void a_lost_bound_ends_it(void **state)
{
    struct made_up c[2] = {{10, 0, 1e-5, 1}, {20, 0, 1e-5, 1}};
    struct gp_plan_past past = {0};
    struct asked asked = {0};
    struct gp_choice got;
    assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
    assert_int_equal(got.taken, 0);
    c[0].bound = INFINITY;
    assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
    assert_int_equal(got.taken, 1);
    assert_true(got.within && !got.kept);
}

/* Two that are faster in turn by less than 20 %: no change every frame. */
static void no_flicker(void **state)
{
    struct gp_plan_past past = {0};
    struct asked asked = {0};
    struct gp_choice got;
    int before = -1, taken = 0;
    for (int frame = 0; frame < 100; frame++) {
        const struct made_up c[2] = {{frame % 2 ? 10 : 9, 0, 1e-5, 1},
                                     {frame % 2 ? 9 : 10, 0, 1e-5, 1}};
        assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
        taken += got.taken != before;
        before = got.taken;
    }
    assert_true(taken <= 11); // the first, and after ten ms lost
}

/* An approximation that is refused is asked after 2, 4, 8, 16, 32, 32 frames;
 * at once when it takes a fifth less; and taken when it is right then. */
static void refused_ones_wait(void **state)
{
    static const int frames[] = {1, 3, 7, 15, 31, 63, 95, 127};
    struct made_up c[] = {{100, 0, 1e-5, true}, {50, 0, 2e-3, false}};
    struct gp_plan_past past = {0};
    struct asked asked = {0};
    struct gp_choice got;
    int times = 0;
    for (int frame = 1; frame <= 130; frame++) {
        c[1].ms = frame % 2 ? 50 : 41; // under a fifth less
        assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
        assert_int_equal(got.taken, 0);
        assert_int_equal(asked.times[0], 1);
        assert_int_equal(asked.times[1], times < (int) COUNT(frames) &&
                                             frame == frames[times]);
        times += asked.times[1];
    }
    c[1].ms = 0.79 * 41;
    assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
    assert_int_equal(asked.times[1], 1);
    c[1].bound = 1e-4;
    for (int frame = 1; frame <= 32; frame++) {
        assert_ok(choose(c, 2, 1e-3, &past, &asked, &got));
        assert_int_equal(got.taken, frame == 32);
    }
    assert_int_equal(past.refused[1].wait, 0);
}

// -- real candidates ----------------------------------------------------------

static struct scene scene_of(enum light light, int w, int h, int kernel)
{
    return scene_make(scene_frame(w, h, 0, 0, light, 5u),
                      scene_kernel(kernel, kernel, MID, 0, TINTED), &usual);
}

static int collect(struct scene *s, const struct gp_glare *g,
                   struct gp_candidate c[GP_CANDIDATES])
{
    static const struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    const struct gp_glare_request req = {
        .params = &p, .src = &s->src, .kernel = &s->k, .layer = &s->f.layer,
        .stats = &stats,
    };
    return gp_plan_candidates(&req, g, c);
}

static void candidates_are_whole(void **state)
{
    static const enum light light[] = {FEW, ALL, CORNERS, HOT};
    for (int i = 0; i < 4; i++) {
        struct scene s = scene_of(light[i], 97, 61, 31);
        const struct gp_glare none = {0};
        struct gp_candidate one[GP_CANDIDATES], two[GP_CANDIDATES];
        gp_set_threads(1);
        const int n = collect(&s, &none, one);
        gp_set_threads(5);
        assert_int_equal(collect(&s, &none, two), n);
        gp_set_threads(0);
        assert_in_range(n, 3, GP_CANDIDATES);
        for (int k = 0; k < n; k++) {
            assert_true(one[k].ms > 0.0 && one[k].later_ms <= one[k].ms);
            assert_true(one[k].ms == two[k].ms);
            assert_true(one[k].later_ms == two[k].later_ms);
            assert_true(isnan(one[k].bound));
        }
        for (int k = 0; gp_engines[k]; k++)
            assert_null(none.state[k]); // predicting opens nothing
        scene_free(&s);
    }
}

/* A frame of 879 fields costs splat more than a few sources cost direct. */
static void fields_cost(void **state)
{
    enum { W = 2, H = 900000 };
    struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 1);
    for (int y = 0; y < H; y += 1000)
        f.rgb.c[1][W * y] = 5.0f;
    struct scene s =
        scene_sense(f, scene_kernel(511, 511, MID, 0, PEAK), &usual);
    struct gp_glare none = {0};
    struct gp_candidate c[GP_CANDIDATES];
    const int n = collect(&s, &none, c);
    for (int k = 1; k < n; k++)
        assert_true(c[k].ms > c[0].ms); // direct is the first
    scene_free(&s);
}

/* Work that a run leaves in its state is not predicted again. */
static void states_count(void **state)
{
    for (int i = 0; i < 2; i++) {
        struct scene s = scene_of(FEW, 97, 61, 31);
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        const struct gp_engine *const e = gp_engines[i];
        const struct gp_glare_request req = {
            .params = &p, .src = &s.src, .kernel = &s.k, .layer = &s.f.layer,
            .stats = &stats,
        };
        p.engine = e->name;
        const struct gp_prediction cold = e->predict(&req, NULL);
        assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
        const struct gp_prediction warm = e->predict(&req, g.state[i]);
        assert_true(warm.ms < cold.ms);
        assert_true(warm.ms == warm.later_ms);
        assert_true(warm.later_ms == cold.later_ms);
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* The time of a splat's bound is part of its own, more of it for a kernel that
 * is new; an exact splat has none to find. */
static void bounds_count(void **state)
{
    struct scene s = scene_of(FEW, 97, 61, 31);
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_prediction cold[2], warm[2];
    void *kept = NULL;
    double bound;
    const struct gp_glare_request req = {
        .params = &p, .src = &s.src, .kernel = &s.k, .layer = &s.f.layer,
    };
    for (int exact = 0; exact < 2; exact++) {
        p.splat = exact ? (struct gp_splat_params) GP_SPLAT_EXACT
                        : (struct gp_splat_params) GP_SPLAT_DEFAULTS;
        cold[exact] = gp_engine_splat.predict(&req, NULL);
        assert_ok(gp_engine_splat.bound(&req, &kept, &bound));
        warm[exact] = gp_engine_splat.predict(&req, kept);
    }
    assert_true(warm[0].ms < cold[0].ms);
    assert_true(warm[0].later_ms == cold[0].later_ms);
    assert_true(warm[1].ms == cold[1].ms);
    gp_engine_splat.close(&kept);
    scene_free(&s);
}

static void run_auto_once(struct scene *s, struct gp_glare *g)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    assert_ok(gp_glare_run(NULL, &p, g, &s->src, &s->k, &s->f, &stats));
}

/* For a kernel that is another in each frame, its spectrum and its tail's count
 * in the frames to come; where it stays, they do not. */
static void kernels_that_move_cost_each_time(void **state)
{
    struct scene a = scene_of(ALL, 97, 61, 31), b = scene_of(ALL, 97, 61, 31);
    struct gp_glare g = {0};
    struct gp_candidate c[GP_CANDIDATES];
    int dearer = 0;
    assert_true(a.k.serial != b.k.serial);
    run_auto_once(&a, &g);
    int n = collect(&a, &g, c);
    for (int i = 0; i < n; i++)
        dearer += c[i].ms < INFINITY && c[i].later_ms < c[i].ms;
    run_auto_once(&b, &g); // another frame, another kernel
    n = collect(&a, &g, c);
    for (int i = 0; i < n; i++)
        assert_true(!(c[i].ms < INFINITY) || c[i].later_ms == c[i].ms);
    gp_glare_close(&g);
    const struct gp_glare none = {0};
    n = collect(&a, &none, c);
    for (int i = 0; i < n; i++)
        dearer += c[i].ms < INFINITY && c[i].later_ms < c[i].ms;
    assert_true(dearer > 0);
    scene_free(&a);
    scene_free(&b);
}

static struct gp_glare_stats run_auto(struct scene *s, double tolerance,
                                      struct gp_glare *g)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.tolerance = (float) tolerance;
    kept_clear();
    assert_ok(gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, &stats));
    return stats;
}

/* The bound keeps the tolerance, or one warning and the report say that none
 * does; and the layer keeps the bound. */
static void the_tolerance_is_kept_or_a_warning_printed(void **state)
{
    static const double tolerance[] = {1.0, 1e-3, 1e-9, 0.0};
    for (int i = 0; i < 4; i++) {
        struct scene s = scene_of(FEW, 97, 61, 31);
        struct gp_glare g = {0};
        const struct gp_glare_stats stats = run_auto(&s, tolerance[i], &g);
        const bool within = stats.bound <= (double) (float) tolerance[i];
        assert_true(scene_rel_l2(&s) <= stats.bound);
        assert_int_equal(within, i < 2);
        assert_int_equal(kept_warning[0] == '\0', within);
        assert_int_equal(strstr(stats.why, "the lowest there is") == NULL,
                         within);
        assert_int_equal(strncmp(stats.why, stats.engine,
                                 strlen(stats.engine)), 0);
        run_auto(&s, tolerance[i], &g); // said once
        assert_string_equal(kept_warning, "");
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* Splat, which guarantees no pixel, is not asked for a layout's bound where one
 * is to be kept, though nothing else keeps it. */
static void no_pixel_bound_no_question(void **state)
{
    for (int pixel = 0; pixel < 2; pixel++) {
        struct scene s = scene_of(FEW, 97, 61, 31);
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        p.splat = (struct gp_splat_params) GP_SPLAT_EXACT;
        p.tolerance = pixel ? 1e-3f : 1e-9f;
        p.tolerance_pixel = pixel ? 1e-9f : 0.0f;
        kept_clear();
        assert_ok(gp_glare_run(&kept_log, &p, &g, &s.src, &s.k, &s.f, &stats));
        assert_string_not_equal(kept_warning, "");
        for (int i = 0; gp_engines[i]; i++) {
            if (gp_engines[i] == &gp_engine_splat)
                assert_int_equal(g.state[i] != NULL, !pixel);
        }
        gp_glare_close(&g);
        scene_free(&s);
    }
}

/* One that asking makes slower, as fft in double, is taken only where it still
 * is the fastest; the others are asked only then. */
static void asking_may_make_one_slower(void **state)
{
    static const struct made_up c[] = {
        {9, 0, 1e-6, true}, {8, 0, 1e-5, true}, {10, 0, 1e-5, true},
    };
    (void) state;
    for (int i = 0; i < 2; i++) {
        struct gp_plan_past past = {0};
        struct asked asked = {.slower = i ? 1.5 : 0.5};
        struct gp_choice choice;
        assert_ok(choose(c, 3, 1e-3, &past, &asked, &choice));
        assert_int_equal(choice.taken, i ? 0 : 1);
        assert_int_equal(asked.times[0], i);
        assert_int_equal(asked.times[2], 0);
    }
}

SUITE_OF(plan, NULL, NULL,
    one_frame, asking_may_make_one_slower, questions_may_fail, a_choice_is_kept,
    a_lost_bound_ends_it,
    no_flicker, refused_ones_wait, candidates_are_whole, fields_cost, states_count,
    bounds_count, kernels_that_move_cost_each_time,
    the_tolerance_is_kept_or_a_warning_printed, no_pixel_bound_no_question)
