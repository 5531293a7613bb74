/* glare/scale: light and kernels near the least that a float holds. */
#include "unit.h"
#include "glare/scale.h"

#include "hard_cases.h"

static const struct gp_splat_params grouped = GP_SPLAT_DEFAULTS,
                                    single = GP_SPLAT_EXACT;

/* The scene's layer; NaN where no sample is written. False without GL. What
 * fft sends direct depends on how much of the frame the layer is: `gain`. */
static bool draw(const char *engine, const struct gp_splat_params *splat,
                 double gain, struct scene *s, struct gp_glare_stats *stats)
{
    struct gp_glare g = {0};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    p.engine = engine;
    p.splat = *splat;
    p.gain = (float) gain;
    if (!s->f.layer.c[0] &&
        gp_planes_make(NULL, "layer", gp_frame_pixels(&s->f), &s->f.layer))
        abort();
    for (int c = 0; c < 3; c++)
        memset(s->f.layer.c[c], 0xff, gp_frame_pixels(&s->f) * sizeof(float));
    const gp_status st =
        gp_glare_run(&scene_log, &p, &g, &s->src, &s->k, &s->f, stats);
    gp_glare_close(&g);
    if (st && st != GP_ERR_GL)
        fail_msg("%s: %s", engine, scene_line);
    return !st;
}

static const struct {
    const char *engine;
    const struct gp_splat_params *splat;
} ways[] = {
    {"direct", &single}, {"fft", &single}, {"auto", &grouped},
    {"splat", &single}, {"splat", &grouped},
};
enum { WAYS = sizeof ways / sizeof *ways };

static bool has_way(int i)
{
    return !getenv("GLAREPP_TEST_QUICK") || strcmp(ways[i].engine, "splat");
}

/* Light times `light` in (0, 1), all of it sources, and a kernel times
 * `kernel`. */
static struct scene scaled(double light, double kernel)
{
    const struct hard_case h = {
        .w = 61, .h = 47, .light = FEW, .kw = 23, .kh = 21, .cx = MID,
        .shape = TINTED, .all_light = true, .light_gain = light,
        .kernel_gain = kernel,
    };
    return hard_sense(&h);
}

/* No digit depends on the scale: the layer is the usual one times a power of
 * two, in bits, though everything before it is out of range. */
static void powers_of_two(void **state)
{
    (void) state;
    static const struct {
        int light, kernel;
    } row[] = {{0, -20}, {0, -100}, {-40, 0}, {-100, 0}, {-40, -50},
               {-100, 120}};
    struct scene usual = scaled(1.0, 1.0);
    for (int i = 0; i < WAYS; i++) {
        struct gp_glare_stats stats, other;
        if (!has_way(i) || !draw(ways[i].engine, ways[i].splat, 1.0, &usual,
                                 &stats))
            continue;
        for (size_t r = 0; r < sizeof row / sizeof *row; r++) {
            const int both = row[r].light + row[r].kernel;
            struct scene s = scaled(ldexp(1.0, row[r].light),
                                    ldexp(1.0, row[r].kernel));
            assert_true(draw(ways[i].engine, ways[i].splat,
                             ldexp(1.0, -row[r].kernel), &s, &other));
            assert_string_equal(other.engine, stats.engine);
            if (!(other.bound >= stats.bound &&
                  other.bound <= stats.bound * (1.0 + 1e-6)))
                fail_msg("%s, row %zu: bound %g, not %g", ways[i].engine, r,
                         other.bound, stats.bound);
            for (size_t at = 0; at < gp_frame_pixels(&s.f); at++) {
                const float want = (float) ldexp(
                    (double) usual.f.layer.c[1][at], both);
                if (s.f.layer.c[1][at] != want)
                    fail_msg("%s, row %zu, pixel %zu: %a, not %a",
                             ways[i].engine, r, at,
                             (double) s.f.layer.c[1][at], (double) want);
            }
            scene_free(&s);
        }
    }
    scene_free(&usual);
}

/* A job of ordinary values is left alone. */
static void ordinary(void **state)
{
    (void) state;
    struct scene s = scaled(1.0, 1.0);
    struct gp_scale *keep = NULL;
    struct gp_sources light = {0};
    struct gp_glare_job job = {.log = &scene_log, .src = &s.src,
                               .kernel = &s.k};
    double floor = 1.0;
    assert_int_equal(gp_scale_job(&job, &keep, &light), GP_OK);
    assert_int_equal(gp_scale_floor(&job, &keep, &floor), GP_OK);
    assert_int_equal(job.exponent, 0);
    assert_ptr_equal(job.src, &s.src);
    assert_ptr_equal(job.kernel, &s.k);
    assert_null(keep);
    assert_null(light.rgb[0]);
    assert_true(floor >= 0.0 && floor < 1e-20);
    scene_free(&s);
}

/* A kernel of 1 where no light lands, and of `rest` elsewhere: what a frame
 * of one source sees of it is far under its peak. */
static struct scene beside(float rest)
{
    enum { SIDE = 9 };
    struct gp_kernel_params p = GP_KERNEL_DEFAULTS;
    struct gp_frame image = {.data = {0, 0, SIDE, SIDE}};
    struct gp_sensor_params all = GP_SENSOR_DEFAULTS;
    struct gp_kernel k;
    all.threshold = 0.0f;
    p.normalize = GP_NORMALIZE_NONE;
    if (gp_planes_make(NULL, "kernel", SIDE * SIDE, &image.rgb))
        abort();
    for (int i = 0; i < 3 * SIDE * SIDE; i++)
        image.rgb.c[i / (SIDE * SIDE)][i % (SIDE * SIDE)] =
            i % (SIDE * SIDE) == 0 ? 1.0f : rest;
    if (gp_kernel_from_frame(NULL, &p, &image, &k))
        abort();
    gp_planes_free(&image.rgb);
    struct gp_frame f = scene_frame(33, 31, 0, 0, DARK, 1);
    for (int c = 0; c < 3; c++) {
        memset(f.rgb.c[c], 0, gp_frame_pixels(&f) * sizeof(float));
        f.rgb.c[c][33 + 1] = 1.0f; // its upper left is outside
    }
    struct scene s = scene_make(f, k, &all);
    return s;
}

/* What no scale mends is said: the bound holds, whatever is lost. */
static void bounds_hold(void **state)
{
    (void) state;
    static const float rests[] = {1e-3f,  1e-20f, 1e-30f,
                                  1e-36f, 1e-38f, 1e-42f};
    int large = 0;
    for (size_t r = 0; r < sizeof rests / sizeof *rests; r++) {
        struct scene s = beside(rests[r]);
        for (int i = 0; i < WAYS; i++) {
            struct gp_glare_stats stats;
            struct gp_glare_error e;
            if (!has_way(i) ||
                !draw(ways[i].engine, ways[i].splat, 1.0, &s, &stats))
                continue;
            gp_glare_measure(&s.f, &s.f.layer, s.exact, 1.0f, &e);
            if (!(e.rel_l2 <= stats.bound))
                fail_msg("%s, %g: %g over its bound %g", ways[i].engine,
                         (double) rests[r], e.rel_l2, stats.bound);
            large += stats.bound > 1.0;
        }
        scene_free(&s);
    }
    assert_true(large > 0);
}

SUITE(scale)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(powers_of_two),
        cmocka_unit_test(ordinary),
        cmocka_unit_test(bounds_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
