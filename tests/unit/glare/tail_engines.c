/* Engines with kernels over the whole field, whose far part is a tail, against
 * the plain double sum and their bounds. */
#include "unit.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/model/model.h"
#include "glare/tail/tail_priv.h"
#include "hard_cases.h"
#include "starved.h"

static const double fine = 1.0 / 36.0;

/* The kernel of recipes with a + between them, 36 pixels a degree. */
static struct gp_kernel field_kernel(const struct gp_frame *f, const char *text)
{
    enum { MOST = 4 };
    struct gp_field field = gp_field_of(f, 30.0);
    struct gp_recipe r[MOST];
    struct gp_kernel k;
    char words[256];
    int n = 0;
    field.degrees = fine;
    snprintf(words, sizeof words, "%s", text);
    for (char *at = words, *next; at; at = next) {
        next = strchr(at, '+');
        if (next)
            *next++ = '\0';
        assert_ok(gp_recipe_parse(NULL, at, &r[n++]));
    }
    assert_ok(gp_model_kernel(NULL, r, n, &field, &k));
    while (n > 0)
        gp_recipe_free(&r[--n]);
    return k;
}

static struct scene field_scene(struct gp_frame f, const char *text)
{
    return scene_make(f, field_kernel(&f, text), &usual);
}

/* Every engine's error against the whole kernel's sum is within its bound, and
 * nothing is wrong where there is no light. */
static void check_engines(struct scene *s, const char *what)
{
    static const char *const names[] = {"direct", "fft", "splat", "auto"};
    for (size_t i = 0; i < COUNT(names); i++) {
        struct gp_glare_stats stats;
        if (!ran_once(names[i], s, &stats, what))
            continue;
        const double error = s->src.n ? scene_rel_l2(s) : 0.0;
        if (!(error <= stats.bound) || !(stats.bound < 1e-3))
            fail_msg("%s, %s: rel_l2 %g, bound %g", what, names[i], error,
                     stats.bound);
        for (size_t k = 0; k < 3 * gp_frame_pixels(&s->f) && !s->src.n; k++)
            assert_true(s->f.layer.c[k % 3][k / 3] == 0.0f);
        const bool tail = s->src.n && s->k.tail && i != 0;
        assert_int_equal(stats.tail_step, tail ? s->k.tail->split.step : 0);
    }
}

static void engines_keep_their_bounds(void **state)
{
    static const struct { int w, h, x, y; enum light light; } rows[] = {
        {331, 257, 0, 0, FEW},     {331, 67, -700, 3, MANY},
        {256, 48, 0, 0, FLAT},     {257, 191, 5, 5, HOT},
        {300, 200, 0, 0, BAD},     {300, 200, 0, 0, DENORMAL},
        {300, 200, 0, 0, CORNERS}, {1, 700, 0, 0, ALL},
        {700, 1, 0, 0, COLOURED},  {1, 1, 0, 0, ALL},
        {4096, 3, 0, 0, MANY},     {300, 200, 0, 0, DARK},
        {300, 50, 0, 0, OVER},     {300, 50, 0, 0, CANCEL},
    };
    static const char *const recipes[] = {"eye", "cie:age=70,share=.3",
                                          "moffat:share=1"};
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        char what[64];
        struct scene s = field_scene(
            scene_frame(rows[i].w, rows[i].h, rows[i].x, rows[i].y,
                        rows[i].light, (uint32_t) i), recipes[i % 3]);
        snprintf(what, sizeof what, "row %zu %s", i, recipes[i % 3]);
        assert_true(!s.k.tail == (gp_max(rows[i].w, rows[i].h) < 192));
        check_engines(&s, what);
        scene_free(&s);
    }
    // and the table's own frames, from those that are wide enough on
    for (int i = 0; i < (int) COUNT(hard_cases); i++) {
        const struct hard_case *const h = &hard_cases[i];
        struct gp_frame f = hard_frame(h);
        if (gp_max(gp_frame_w(&f), gp_frame_h(&f)) < 192 ||
            gp_frame_pixels(&f) > 400000) {
            gp_frame_free(&f);
            continue;
        }
        struct scene s = field_scene(f, "eye");
        check_engines(&s, h->name);
        scene_free(&s);
    }
}

/* Beside shapes that are smooth all over, sharp ones stay in the core and make
 * neither it larger than they are nor the tail coloured, but for diffraction's.
 * Core and tail are not negative, and add up to the whole within 1e-5. */
static void sharp_shapes_stay_in_the_core(void **state)
{
    static const struct {
        const char *text;
        int reach;    // of the core, at most
        bool turned;  // the same when halved by a line through the centre
    } rows[] = {
        {"cie+star:length=5", 185, true}, {"moffat+eye+cross:length=3", 130, true},
        {"spencer:light=scotopic", 282, true}, {"eye-night", 282, false},
        {"spencer:needles=40+circle", 200, false},
        {"cie+streak:length=3.9", 150, false},
        // reaches of 144 pixels; the mean far out takes over before its end
        {"eye+aperture:reach=4,wavelengths=5", 205, true},
        {"temporal:reach=4,wavelengths=5", 205, true},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct scene s = field_scene(
            scene_frame(430, i == 1 ? 70 : 310, 0, 0, i == 1 ? MANY : CORNERS,
                        (uint32_t) i), rows[i].text);
        struct gp_glare_stats stats;
        const bool grey = !strstr(rows[i].text, "wavelengths");
        if (!s.k.tail || s.k.tail->grey != grey || s.k.cx > rows[i].reach)
            fail_msg("%s: %s, a core of %d pixels", rows[i].text,
                     s.k.tail ? "a tail" : "no tail", s.k.cx);
        assert_true(!s.k.negative);
        for (int x = 0; x < s.k.w && rows[i].turned; x++) // across the centre
            assert_true(fabsf(s.k.k.c[1][s.k.cy * s.k.w + x] -
                              s.k.k.c[1][s.k.cy * s.k.w + s.k.w - 1 - x]) <=
                        1e-4f * s.k.k.c[1][s.k.cy * s.k.w + x]);
        check_engines(&s, rows[i].text);
        assert_true(ran_once("fft", &s, &stats, rows[i].text));
        const double error = scene_rel_l2(&s);
        if (!(error < 1e-5))
            fail_msg("%s: rel_l2 %g", rows[i].text, error);
        scene_free(&s);
    }
}

/* Fields as wide as the sky, and pixels of any aspect: transforms are within
 * 1e-5 of the exact layer, and their bounds hold. */
static void any_field_is_within_1e_5(void **state)
{
    enum { W = 400, H = 150 };
    static const char *const recipes[] = {
        "eye", "eye-night", "cie:age=100", "moffat",
    };
    static const double fovs[] = {30.0, 60.0, 100.0, 170.0};
    static const double aspects[] = {1.0, 2.0, 0.1};
    (void) state;
    for (size_t i = 0; i < COUNT(recipes) * COUNT(fovs) * COUNT(aspects); i++) {
        const char *const text = recipes[i / 12];
        const double fov = fovs[i / 3 % 4], aspect = aspects[i % 3];
        struct gp_frame f = scene_frame(W, H, 0, 0, DARK, (uint32_t) i);
        uint32_t seed = (uint32_t) i;
        for (int k = 0; k < 20; k++) {
            const int x = (int) (scene_random(&seed) * (W - 2));
            const int y = (int) (scene_random(&seed) * (H - 2));
            for (int c = 0; c < 12; c++)
                f.rgb.c[c % 3][(y + c / 6) * W + x + c / 3 % 2] =
                    100.0f + 1000.0f * scene_random(&seed);
        }
        struct gp_field field = gp_field_of(&f, fov);
        struct gp_recipe r;
        struct gp_kernel k;
        struct gp_glare_stats stats;
        field.aspect = aspect;
        assert_ok(gp_recipe_parse(NULL, text, &r));
        assert_ok(gp_model_kernel(NULL, &r, 1, &field, &k));
        gp_recipe_free(&r);
        assert_true(k.tail || aspect < 1.0); // where the halo is that wide
        struct scene s = scene_make(f, k, &usual);
        assert_true(ran_once("fft", &s, &stats, text));
        const double error = scene_rel_l2(&s);
        if (!(error <= 1e-5) || !(error <= stats.bound))
            fail_msg("%s, %g degrees, aspect %g: rel_l2 %g, bound %g", text,
                     fov, aspect, error, stats.bound);
        scene_free(&s);
    }
}

/* A sharp shape that reaches over the field, or lobes that a tail would fill,
 * leave the kernel whole. */
static void some_kernels_stay_whole(void **state)
{
    static const char *const rows[] = {"star:length=20", "cie+cross:length=12",
                                       "gaussian:fwhm=20+eye"};
    struct gp_frame f = scene_frame(430, 310, 0, 0, DARK, 0);
    struct gp_frame lobes = scene_frame(3, 3, 0, 0, ALL, 0);
    struct gp_field field = gp_field_of(&f, 30.0);
    struct gp_recipe r[2];
    struct gp_kernel k;
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        k = field_kernel(&f, rows[i]);
        assert_true(!k.tail);
        gp_kernel_free(&k);
    }
    for (int c = 0; c < 3; c++)
        lobes.rgb.c[c][0] = -lobes.rgb.c[c][4];
    assert_ok(gp_recipe_parse(NULL, "cie", &r[0]));
    assert_ok(gp_recipe_of_image(NULL, "lobes", 0.0, 100.0, &r[1]));
    r[1].image = &lobes;
    field.degrees = fine;
    for (int tail = 0; tail < 2; tail++) {
        assert_ok(gp_model_kernel(NULL, r, 2, &field, &k));
        assert_true(k.negative == !tail && !k.tail == !tail);
        gp_kernel_free(&k);
        for (int c = 0; c < 3; c++)
            lobes.rgb.c[c][0] = 0.0f;
    }
    gp_recipe_free(&r[0]);
    gp_recipe_free(&r[1]);
    gp_frame_free(&lobes);
    gp_frame_free(&f);
}

/* A lone lamp in the dark at +6 EV: no rim, no step where the core ends, and no
 * noise of transforms, out to the frame's end. In black, and in a night whose
 * own light hides such noise from the choice of what goes direct. */
static void a_lamp_has_no_rim(void **state)
{
    enum { W = 1200, H = 300, X = 40, Y = 150 };
    static const char *const names[] = {"fft", "auto"};
    static const struct {
        const char *text;
        int radius; // of the lamp, pixels
        float sky;
        double within;
    } rows[] = {
        {"eye", 0, 0.0f, 1e-3}, {"eye", 2, 0.1f, 1e-3},
        {"moffat", 0, 0.1f, 1e-3}, {"moffat", 6, 0.1f, 1e-3},
        {"moffat", 20, 0.1f, 0.02}, {"moffat:share=1", 0, 0.1f, 1e-3},
        {"eye-night", 0, 0.1f, 1e-3}, {"cie:equation=general", 2, 0.1f, 1e-3},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows) * COUNT(names); i++) {
        const int radius = rows[i / 2].radius;
        const char *const text = rows[i / 2].text, *const name = names[i % 2];
        struct gp_frame f = scene_frame(W, H, 0, 0, BLACK, 0);
        struct gp_glare_stats stats;
        for (int k = 0; k < 3 * W * H; k++) {
            const int x = k / 3 % W - X, y = k / 3 / W - Y;
            f.rgb.c[k % 3][k / 3] =
                x * x + y * y <= radius * radius ? 64.0f : rows[i / 2].sky;
        }
        struct scene s = field_scene(f, text);
        ran_once(name, &s, &stats, "lamp");
        for (int r = radius + 4; X + r + 1 < W; r++) {
            const size_t at = Y * W + X + (size_t) r;
            const double v = (double) s.f.layer.c[1][at];
            const double next = (double) s.f.layer.c[1][at + 1];
            const double exact = s.exact[W * H + at];
            const double beyond = s.exact[W * H + at + 1];
            if (!(fabs(v / exact - 1.0) < rows[i / 2].within) ||
                (r > 150 && !(fabs(next / v - beyond / exact) < 0.005)))
                fail_msg("%s of %s, %d pixels away: %g, then %g, not %g", name,
                         text, r, v, next, exact);
        }
        scene_free(&s);
    }
}

/* Bounds of --tolerance-pixel count the tail's error. */
static void pixels_are_within_their_bounds(void **state)
{
    static const enum light lights[] = {FEW, MANY, HOT, ALL};
    (void) state;
    for (size_t i = 0; i < COUNT(lights); i++) {
        struct scene s = field_scene(
            scene_frame(300, 200, 0, 0, lights[i], (uint32_t) i), "eye");
        struct gp_glare_params p = GP_GLARE_DEFAULTS;
        struct gp_glare g = {0};
        struct gp_glare_stats stats;
        struct gp_glare_error e;
        p.engine = "fft";
        p.tolerance_pixel = 1.0f;
        assert_ok(gp_glare_run(NULL, &p, &g, &s.src, &s.k, &s.f, &stats));
        gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, NULL, &e);
        print_message("max_rel %.2g, bound %.2g\n", e.max_rel,
                      stats.bound_pixel);
        assert_true(e.max_rel <= stats.bound_pixel);
        gp_glare_close(&g);
        scene_free(&s);
    }
}

// -- without memory -----------------------------------------------------------

static struct scene starved;
static const char *starved_engine;
static double starved_sum;

static gp_status run_starved(void)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    struct gp_glare g = {0};
    p.engine = starved_engine;
    gp_status st = gp_glare_run(&kept_log, &p, &g, &starved.src, &starved.k,
                                &starved.f, &stats);
    gp_glare_close(&g);
    for (int i = 0; !st && i < starved.src.w * starved.src.h; i++)
        starved_sum += (double) starved.f.layer.c[0][i];
    gp_planes_free(&starved.f.layer);
    return st;
}

static void full_memory_is_an_error(void **state)
{
    static const char *const engines[] = {"fft", "direct", "auto"};
    (void) state;
    starved = field_scene(scene_frame(300, 200, 0, 0, FEW, 3u), "eye");
    gp_set_threads(1);
    for (size_t i = 0; i < COUNT(engines); i++) {
        starved_engine = engines[i];
        starve(engines[i], run_starved, &starved_sum, 8);
    }
    gp_set_threads(0);
    scene_free(&starved);
}

SUITE_OF(tail_engines, ask_quick, NULL, engines_keep_their_bounds,
    sharp_shapes_stay_in_the_core, any_field_is_within_1e_5,
    some_kernels_stay_whole, a_lamp_has_no_rim, pixels_are_within_their_bounds,
    full_memory_is_an_error)
