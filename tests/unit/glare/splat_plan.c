/* What splat draws and says of it: limits, counts, what shrinking leaves out,
 * and plans that are kept. */
#include "unit.h"
#include "glare/splat/splat_priv.h"
#include "splat_open.h"

/* -- limits and counts ------------------------------------------------ */

static void large_points_are_refused(void **state)
{
    (void) state;
    void *kept = NULL;
    struct gp_planes layer;
    assert_int_equal(open_or_skip(&kept), GP_OK);
    const int most =
        (int) gp_gl_info(((struct gp_splat *) kept)->gl)->max_point;
    if (most > 2000)
        skip();
    struct gp_sources src = make_sources(40, 30, CORNERS);
    struct gp_kernel k = make_kernel(4 * most, 5, 2 * most, 2, PEAK);
    src.w = 40;
    how.primitive = GP_PRIMITIVE_POINT;
    gp_status st = splat(GP_GL_AUTO, &src, &k, &layer, &kept);
    if (most < 79) { // what reaches a frame of 40 pixels is 79 wide
        assert_int_equal(st, GP_ERR_GL);
        assert_non_null(strstr(last_line, "--primitive quad or tile"));
    } else {
        assert_int_equal(st, GP_OK);
    }
    gp_planes_free(&layer);
    free_sources(&src);
    src = make_sources(2 * most, 3, CORNERS);
    assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept), GP_ERR_GL);
    assert_non_null(strstr(last_line, "--primitive quad or tile"));
    gp_planes_free(&layer);
    how.primitive = GP_PRIMITIVE_QUAD;
    assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept), GP_OK);
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    free_sources(&src);
    gp_engine_splat.close(&kept);
}

static void counts_are_those_of_the_groups(void **state)
{
    static const char *const names[] = {"blended quads", "blended points",
                                        "tiles, groups from the CPU"};
    (void) state;
    void *kept = NULL;
    assert_int_equal(open_or_skip(&kept), GP_OK);
    struct gp_sources src = make_sources(64, 32, EVERY);
    struct gp_kernel k = make_kernel(41, 41, 20, 20, PEAK);
    for (int p = 0; p < PRIMITIVES; p++) {
        struct gp_planes layer;
        how = (struct gp_splat_params) GP_SPLAT_DEFAULTS;
        how.shrink = 0.0f;
        how.primitive = primitives[p];
        assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept), GP_OK);
        assert_int_equal(stats.clusters, 32);
        assert_int_equal(stats.groups, 0);
        assert_int_equal(stats.polygons, 32);
        assert_int_equal(stats.cores, 64 * 32);
        assert_string_equal(stats.form, names[p]);
        assert_true(stats.polygon_pixels > 32 * 20 * 20);
        gp_planes_free(&layer);
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_planes_free(&k.k);
    free_sources(&src);
    gp_engine_splat.close(&kept);
}

/* Share of all luminance by which `layer` is darker, pixel after pixel. */
static double light_lost(const struct gp_sources *src,
                         const struct gp_kernel *k,
                         const struct gp_planes *exact,
                         const struct gp_planes *layer)
{
    const double norm = fmax(k->norm1[0], fmax(k->norm1[1], k->norm1[2]));
    double lost = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        const double weight = (double) src->luminance[c];
        for (int i = 0; i < src->w * src->h; i++) {
            const double was = (double) exact->c[c][i];
            const double is = (double) layer->c[c][i];
            assert_true(is <= was * (1.0 + 1e-5));
            lost += weight * (was - is);
        }
        all += weight * src->flux[c] * norm;
    }
    return lost / all;
}

/* Shrinking takes light away and never adds any, takes no more than it may,
 * and takes more the more it may. */
static void shrinking_leaves_out_what_it_may(void **state)
{
    static const float shares[] = {0.0f, 1e-4f, 1e-3f, 1e-2f, 0.1f};
    (void) state;
    void *kept = NULL;
    assert_int_equal(open_or_skip(&kept), GP_OK);
    struct gp_sources src = make_sources(131, 67, MANY);
    struct gp_kernel k = make_kernel(63, 61, 31, 30, PEAK);
    for (int p = 0; p < PRIMITIVES; p++) {
        struct gp_planes exact = {0}, layer;
        double before = 0.0, pixels = INFINITY;
        for (int i = 0; i < 5; i++) {
            how.primitive = primitives[p];
            how.shrink = shares[i];
            assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept),
                             GP_OK);
            assert_true(stats.polygon_pixels <= pixels);
            pixels = stats.polygon_pixels;
            if (i == 0) {
                exact = layer;
                continue;
            }
            const double lost = light_lost(&src, &k, &exact, &layer);
            if (!(lost <= (double) shares[i] + 1e-6 && lost > before))
                fail_msg("primitive %d: %g lost of %g", p, lost,
                         (double) shares[i]);
            before = lost;
            gp_planes_free(&layer);
        }
        assert_true(before > 1e-3); // polygons did shrink
        gp_planes_free(&exact);
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_planes_free(&k.k);
    free_sources(&src);
    gp_engine_splat.close(&kept);
}

/* bound() before run() says what run() publishes, and a plan that is kept
 * never outlives its light. */
static void plans_are_kept_for_their_light_alone(void **state)
{
    (void) state;
    void *kept = NULL;
    assert_int_equal(open_or_skip(&kept), GP_OK);
    struct gp_sources src = make_sources(50, 40, FEW);
    struct gp_kernel k = make_kernel(31, 31, 15, 15, PEAK);
    k.serial = 12345; // as one that was made from a file
    for (int i = 0; i < 4; i++) {
        const struct gp_glare_params params = {.splat = how};
        const struct gp_glare_job job = {.log = &log_kept, .params = &params,
                                         .src = &src, .kernel = &k,
                                         .stats = &stats};
        struct gp_planes layer;
        double bound = -1.0;
        if (i % 2 == 0)
            assert_int_equal(gp_engine_splat.bound(&job, &kept, &bound),
                             GP_OK);
        if (i == 2)
            src.rgb[1][src.n / 2] *= 2.0f; // at the same address
        assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept), GP_OK);
        if (i == 0)
            assert_true(bound == stats.bound);
        assert_true(rel_l2(&src, &k, &layer) <= 1e-6);
        gp_planes_free(&layer);
    }
    gp_planes_free(&k.k);
    free_sources(&src);
    gp_engine_splat.close(&kept);
}

SUITE(splat_plan)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(large_points_are_refused),
        cmocka_unit_test(counts_are_those_of_the_groups),
        cmocka_unit_test(shrinking_leaves_out_what_it_may),
        cmocka_unit_test(plans_are_kept_for_their_light_alone),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("plans_are_kept*");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
