/* Stability in motion: a point, a thin line and a small disc slide through
 * 64 steps of 1/8 pixel, for every technique. With --table it prints what it
 * measured, in Markdown. */
#include "unit.h"
#include "motion.h"
#include "plain_groups.h"

/* A technique's layer comes about by an engine, or, for those that are
 * slow on a software GL, by the polygons' plain form in double. */
struct technique {
    const char *name;
    const char *engine;  // NULL: plain groups
    struct gp_splat_params splat;
    // limits: flux ripple; centroid error, pixels; jump
    double ripple, centroid, jump;
};

#define GROUPED(n) { .group = n, .cluster_fill = 0.9f }
#define CLUSTERED(n) { .group = 1, .cluster = n, .cluster_fill = 0.9f }
#define SHRUNK(e) { .group = 1, .cluster_fill = 0.9f, .shrink = e }

/* Exact engines may only round; groups keep flux and centroid, to the float
 * positions of their polygons; shrinking leaves light out. */
static const struct technique techniques[] = {
    {"direct", "direct", GP_SPLAT_EXACT, 1e-5, 1e-4, 1e-5},
    {"fft", "fft", GP_SPLAT_EXACT, 1e-5, 1e-4, 1e-5},
    {"splat, exact", "splat", GP_SPLAT_EXACT, 1e-5, 1e-4, 1e-5},
    {"group 2", NULL, GROUPED(2), 1e-6, 1e-4, 1e-4},
    {"group 4", NULL, GROUPED(4), 1e-6, 1e-4, 2e-3},
    {"group 8", NULL, GROUPED(8), 1e-6, 1e-4, 5e-3},
    {"cluster 4", NULL, CLUSTERED(4), 1e-6, 1e-4, 2e-3},
    {"shrink 1e-3", NULL, SHRUNK(1e-3f), 1e-3, 1e-2, 1e-3},
    {"the default", NULL, GP_SPLAT_DEFAULTS, 1e-3, 1e-2, 2e-3},
    {"the default, drawn by GL", "splat", GP_SPLAT_DEFAULTS, 1e-3, 1e-2, 2e-3},
};
enum { TECHNIQUES = (int) (COUNT(techniques)) };

static const size_t pixels = (size_t) MOTION_SIZE * MOTION_SIZE;

/* The light at each step, with its exact layer; all share the kernel. */
static struct scene steps[MOTION_STEPS];
static int count = MOTION_STEPS; // that are taken: fewer in slow builds

// -- one layer ----------------------------------------------------------------

static void draw_plain(const struct technique *t, const struct scene *s,
                       double *layer)
{
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    assert_ok(gp_polygons_make(NULL, &s->src, &t->splat, &polygons));
    assert_ok(gp_shrink_make(NULL, &s->k, &t->splat, &polygons, &shrink));
    plain_groups(&s->src, &s->k, &t->splat, &polygons, &shrink, layer);
    gp_polygons_free(&polygons);
}

/* False when there is no GL. */
static bool draw_engine(const struct technique *t, struct scene *s,
                        struct gp_glare *g, double *layer)
{
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats;
    p.engine = t->engine;
    p.splat = t->splat;
    const gp_status st =
        gp_glare_run(&kept_log, &p, g, &s->src, &s->k, &s->f, &stats);
    if (st == GP_ERR_GL)
        return false;
    assert_ok(st);
    for (size_t i = 0; i < 3 * pixels; i++)
        layer[i] = (double) s->f.layer.c[i / pixels][i % pixels];
    return true;
}

/* Runs a technique over all steps; false when it cannot run here. */
static bool slide(const struct technique *t, struct motion_result *out)
{
    double *const layer = scene_alloc(3 * pixels, sizeof *layer);
    struct motion_track track = {0};
    struct gp_glare g = {0};
    bool ran = true;
    for (int i = 0; i < count && ran; i++) {
        if (t->engine)
            ran = draw_engine(t, &steps[i], &g, layer);
        else
            draw_plain(t, &steps[i], layer);
        if (ran)
            motion_follow(&track, i, layer + pixels, steps[i].exact + pixels);
    }
    gp_glare_close(&g);
    free(layer);
    *out = motion_end(&track);
    return ran;
}

static void make_steps(enum motion_shape shape, const struct gp_kernel *kernel)
{
    for (int i = 0; i < count; i++)
        steps[i] = scene_make(motion_frame(shape, i), *kernel, &motion_sensors);
}

static void free_steps(void)
{
    for (int i = 0; i < count; i++) {
        steps[i].k = (struct gp_kernel) {0}; // of all
        scene_free(&steps[i]);
    }
}

// -- tests --------------------------------------------------------------------

static struct motion_result results[TECHNIQUES][MOTION_SHAPES];
static bool ran[TECHNIQUES];
static double own[MOTION_SHAPES];

static int measure(void **state)
{
    struct gp_kernel kernel = motion_kernel();
    for (int s = 0; s < MOTION_SHAPES; s++) {
        make_steps((enum motion_shape) s, &kernel);
        for (int i = 1; i < count; i++)
            own[s] = fmax(own[s], motion_own(steps[i - 1].exact,
                                             steps[i].exact));
        for (int t = 0; t < TECHNIQUES; t++)
            ran[t] = slide(&techniques[t], &results[t][s]);
        free_steps();
    }
    gp_kernel_free(&kernel);
    return 0;
}

/* The light itself: its flux and its centroid do not depend on the place. */
static void light_slides_evenly(void **state)
{
    for (int s = 0; s < MOTION_SHAPES; s++) {
        struct motion_track track = {0};
        double *const light = scene_alloc(pixels, sizeof *light);
        for (int i = 0; i < count; i++) {
            struct gp_frame f = motion_frame((enum motion_shape) s, i);
            for (size_t p = 0; p < pixels; p++)
                light[p] = (double) f.rgb.c[1][p];
            motion_follow(&track, i, light, light);
            gp_frame_free(&f);
        }
        const struct motion_result r = motion_end(&track);
        assert_true(r.ripple < 1e-6);
        assert_true(r.centroid < 1e-4);
        assert_true(r.jump == 0.0);
        free(light);
    }
}

static void check_motion(const char *name, const char *shape, const char *what,
                         double got, double bar)
{
    if (!(got <= bar))
        fail_msg("%s, %s: %s is %.3g, over %.3g", name, shape, what, got, bar);
}

static void techniques_stay_steady(void **state)
{
    int skipped = 0;
    for (int i = 0; i < TECHNIQUES; i++) {
        const struct technique *const t = &techniques[i];
        skipped += !ran[i];
        for (int s = 0; s < MOTION_SHAPES && ran[i]; s++) {
            const struct motion_result *const r = &results[i][s];
            const char *const shape = motion_shapes[s];
            check_motion(t->name, shape, "flux ripple", r->ripple, t->ripple);
            check_motion(t->name, shape, "centroid error", r->centroid, t->centroid);
            check_motion(t->name, shape, "jump", r->jump, t->jump);
        }
    }
    if (skipped)
        print_message("%d techniques have no GL here\n", skipped);
}

static void print_row(const char *name, const struct motion_result *row,
                      bool there)
{
    printf("| %s |", name);
    for (int s = 0; s < MOTION_SHAPES; s++) {
        if (there)
            printf(" %.1e | %.1e | %.1e |", row[s].ripple, row[s].centroid,
                   row[s].jump);
        else
            printf(" no GL | | |");
    }
    printf("\n");
}

static void print_table(void)
{
    printf("| technique |");
    for (int s = 0; s < MOTION_SHAPES; s++)
        printf(" %s: flux ripple | centroid, px | jump |", motion_shapes[s]);
    printf("\n|---|");
    for (int s = 0; s < 3 * MOTION_SHAPES; s++)
        printf("---|");
    printf("\n| (the light's own motion) |");
    for (int s = 0; s < MOTION_SHAPES; s++)
        printf(" | | %.1e |", own[s]);
    printf("\n");
    for (int i = 0; i < TECHNIQUES; i++)
        print_row(techniques[i].name, results[i], ran[i]);
}

SUITE(motion)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(light_slides_evenly),
        cmocka_unit_test(techniques_stay_steady),
    };
    if (argc > 1 && strcmp(argv[1], "--table") == 0) {
        measure(NULL);
        print_table();
        return 0;
    }
    if (getenv("GLAREPP_TEST_QUICK"))
        count = 12;
    return cmocka_run_group_tests(tests, measure, NULL);
}
