/* splat against a plain double sum: sizes, kernels, tiles, sequences; its
 * limits and counts, what shrinking leaves out, and plans that are kept. */
#include "unit.h"
#include "splat_scene.h"

/* -- rows ------------------------------------------------------------------ */

struct row {
    int w, h;
    enum light light;
    int kw, kh, cx, cy;
    enum shape shape;
};

static const struct row rows[] = {
    {1, 1, EVERY, 1, 1, 0, 0, PEAK}, {1, 1, EVERY, 9, 7, 4, 3, PEAK},
    {7, 5, EVERY, 1, 1, 0, 0, BOX}, {40, 30, NONE, 9, 9, 4, 4, PEAK},
    {40, 30, CORNERS, 9, 9, 4, 4, PEAK}, {40, 30, CORNERS, 8, 8, 4, 4, HOLES},
    {40, 30, CORNERS, 200, 151, 100, 75, PEAK}, // larger than the frame
    {40, 30, EVERY, 200, 151, 100, 75, PEAK}, {31, 29, FEW, 16, 9, 8, 4, LOBES},
    {97, 1, FEW, 33, 33, 16, 16, PEAK}, {1, 97, FEW, 33, 33, 16, 16, PEAK},
    {64, 64, FEW, 13, 11, 0, 10, PEAK},         // centre in a corner
    {64, 64, FEW, 13, 11, -20, 31, PEAK},       // centre outside
    {64, 64, FEW, 13, 11, 2000, 5, PEAK},       // reaches no pixel
    {64, 64, FEW, 13, 11, 2147483647, -2147483647, PEAK},
    {64, 64, FEW, 200, 3, 180, 1, LOBES}, {61, 67, HOT, 63, 63, 31, 31, PEAK},
    {131, 67, MANY, 31, 30, 15, 15, HOLES},
    {131, 67, MANY, 31, 30, 15, 15, LOBES},
    {64, 80, EVERY, 24, 25, 12, 12, PEAK},      // 5120 sources
    {50, 50, EQUAL, 96, 96, 48, 48, BOX},       // roundings of one direction
    {1, 4801, FEW, 3, 70, 1, 35, PEAK},         // over one tile
    {4801, 1, FEW, 70, 3, 35, 1, PEAK},
    {16384, 3, CORNERS, 65, 5, 32, 2, PEAK},
};

static void run_row(enum gp_gl_api gl, const struct row *r, void **state)
{
    seed = 20071u;
    struct gp_sources src = make_sources(r->w, r->h, r->light);
    struct gp_kernel k = make_kernel(r->kw, r->kh, r->cx, r->cy, r->shape);
    struct gp_planes layer;
    int row = (int) (r - rows);
    if (splat(gl, &src, &k, &layer, state) != GP_OK)
        fail_msg("row %d, %d: %s", row, how.primitive, said_line);
    double error = rel_l2(&src, &k, &layer);
    if (!(error <= 2e-6))
        fail_msg("row %d, %d: rel_l2 %g", row, how.primitive, error);
    if (stats.gl && !(error <= stats.bound))
        fail_msg("row %d, %d: rel_l2 %g over the bound %g", row,
                 how.primitive, error, stats.bound);
    if (stats.gl && r->shape == LOBES)
        assert_true(isinf(stats.bound));
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    gp_sources_free(&src);
}

/* One state for all rows: frames and kernels change size under way, and how
 * they are drawn. */
static void rows_equal_the_sum(enum gp_gl_api gl)
{
    void *state = open_or_skip(gl);
    for (size_t i = 0; i < COUNT(rows); i++) {
        for (int p = 0; p <= PRIMITIVES; p++) {
            how.primitive = p < PRIMITIVES ? primitives[p] : GP_PRIMITIVE_AUTO;
            run_row(gl, &rows[i], &state);
        }
    }
    how.primitive = GP_PRIMITIVE_AUTO;
    gp_engine_splat.close(&state);
    assert_null(state);
}

static void osmesa_equals_the_sum(void **state)
{
    rows_equal_the_sum(GP_GL_OSMESA);
}

static void egl_equals_the_sum(void **state)
{
    rows_equal_the_sum(GP_GL_EGL);
}

/* Tiles and blocks of sensors, many times smaller than frame and kernel. */
static void tiles_equal_the_sum(void **state)
{
    static const struct {
        const char *side;
        struct row row;
    } tiled[] = {
        {"16", {131, 67, MANY, 15, 16, 7, 8, PEAK}},
        {"16", {40, 50, EVERY, 16, 3, 8, 1, LOBES}},
        {"64", {200, 150, FEW, 64, 61, 32, 30, PEAK}},
        {"64", {200, 150, CORNERS, 9, 61, -30, 90, PEAK}},
        {"1", {5, 4, EVERY, 1, 1, 0, 0, PEAK}},
        {"7", {22, 1, EVERY, 7, 7, 0, 6, HOLES}},
    };
    how.primitive = GP_PRIMITIVE_QUAD;
    for (size_t i = 0; i < COUNT(tiled); i++) {
        setenv("GLAREPP_GL_MAX_SIZE", tiled[i].side, 1);
        void *kept = open_or_skip(GP_GL_AUTO);
        run_row(GP_GL_AUTO, &tiled[i].row, &kept);
        unsetenv("GLAREPP_GL_MAX_SIZE");
        gp_engine_splat.close(&kept);
    }
    how.primitive = GP_PRIMITIVE_AUTO;
}

static void over_the_limit_fails_with_words(void **state)
{
    setenv("GLAREPP_GL_MAX_SIZE", "16", 1);
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(40, 30, FEW);
    struct gp_kernel small = make_kernel(9, 9, 4, 4, PEAK);
    struct gp_kernel large = make_kernel(17, 9, 8, 4, PEAK);
    struct gp_planes layer;
    how.primitive = GP_PRIMITIVE_QUAD;
    assert_ok(splat(GP_GL_AUTO, &src, &small, &layer, &kept));
    gp_planes_free(&layer);
    assert_int_equal(splat(GP_GL_AUTO, &src, &large, &layer, &kept), GP_ERR_GL);
    assert_non_null(strstr(said_line, "kernel: 17x9"));
    assert_non_null(strstr(said_line, "16x16 is the limit"));
    gp_planes_free(&layer);
    // the state is whole: the next frame is drawn as if nothing had been
    assert_ok(splat(GP_GL_AUTO, &src, &small, &layer, &kept));
    assert_true(rel_l2(&src, &small, &layer) <= 2e-6);
    unsetenv("GLAREPP_GL_MAX_SIZE");
    how.primitive = GP_PRIMITIVE_AUTO;
    gp_planes_free(&layer);
    gp_planes_free(&small.k);
    gp_planes_free(&large.k);
    gp_engine_splat.close(&kept);
    gp_sources_free(&src);
}

/* -- sequences ------------------------------------------------------------- */

static void same_bits(const struct gp_sources *src, const struct gp_planes *a,
                      const struct gp_planes *b)
{
    for (int c = 0; c < 3; c++)
        assert_memory_equal(a->c[c], b->c[c], (size_t) src->w *
                                                  (size_t) src->h * 4);
}

/* A kernel that changes in place, at one address, is seen; what the state
 * went through leaves no trace in the bytes. */
static void no_stale_kernel(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(61, 47, MANY);
    struct gp_kernel k = make_kernel(21, 21, 10, 10, PEAK);
    for (int i = 0; i < 10; i++) {
        void *fresh = NULL;
        struct gp_planes a, b;
        if (i == 2)
            k.k.c[2][20 * 21 + 20] = 0.5f; // the last sample alone
        if (i == 4)
            k.cx = 3;
        if (i == 5)
            fill_kernel(&k, LOBES);
        if (i == 6)
            fill_kernel(&k, BOX);
        if (i == 7)
            k.w = 19; // all samples are as before
        if (i == 8)
            k.h = 18;
        assert_ok(splat(GP_GL_AUTO, &src, &k, &a, &kept));
        assert_ok(splat(GP_GL_AUTO, &src, &k, &b, &fresh));
        same_bits(&src, &a, &b);
        assert_true(rel_l2(&src, &k, &a) <= 2e-6);
        gp_engine_splat.close(&fresh);
        gp_planes_free(&a);
        gp_planes_free(&b);
    }
    gp_engine_splat.close(&kept);
    gp_planes_free(&k.k);
    gp_sources_free(&src);
}

/* Two states in turns, one of them changing its context under way. */
static void contexts_in_turns(void **state)
{
    void *one = open_or_skip(GP_GL_OSMESA), *two = open_or_skip(GP_GL_EGL);
    struct gp_sources src = make_sources(50, 40, FEW);
    struct gp_kernel k = make_kernel(15, 15, 7, 7, PEAK);
    for (int i = 0; i < 4; i++) {
        struct gp_planes a, b;
        assert_ok(splat(i % 2 ? GP_GL_EGL : GP_GL_OSMESA, &src, &k, &a, &one));
        assert_non_null(strstr(stats.gl, i % 2 ? "EGL" : "OSMesa"));
        assert_ok(splat(GP_GL_EGL, &src, &k, &b, &two));
        assert_true(rel_l2(&src, &k, &a) <= 2e-6);
        assert_true(rel_l2(&src, &k, &b) <= 2e-6);
        gp_planes_free(&a);
        gp_planes_free(&b);
    }
    gp_engine_splat.close(&one);
    gp_engine_splat.close(&two);
    gp_planes_free(&k.k);
    gp_sources_free(&src);
}

static void counts_are_right(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(40, 30, CORNERS);
    struct gp_kernel k = make_kernel(9, 7, 4, 3, PEAK);
    struct gp_planes layer;
    const struct gp_glare_params params = {.splat = how};
    const struct gp_glare_job job = {.params = &params, .src = &src,
                                     .kernel = &k};
    assert_ok(splat(GP_GL_AUTO, &src, &k, &layer, &kept));
    assert_int_equal(stats.polygons, 4);
    assert_true(stats.polygon_pixels == 4 * 5 * 4);
    assert_true(stats.bound > 0 && stats.bound < 1e-5);
    assert_true(gp_engine_splat.predict(&job, NULL).ms > 0);
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    gp_engine_splat.close(&kept);
    gp_engine_splat.close(&kept);
    gp_sources_free(&src);
}

/* -- limits and counts ------------------------------------------------ */

static void large_points_are_refused(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_planes layer;
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
        assert_non_null(strstr(said_line, "--primitive quad or tile"));
    } else {
        assert_int_equal(st, GP_OK);
    }
    gp_planes_free(&layer);
    gp_sources_free(&src);
    src = make_sources(2 * most, 3, CORNERS);
    assert_int_equal(splat(GP_GL_AUTO, &src, &k, &layer, &kept), GP_ERR_GL);
    assert_non_null(strstr(said_line, "--primitive quad or tile"));
    gp_planes_free(&layer);
    how.primitive = GP_PRIMITIVE_QUAD;
    assert_ok(splat(GP_GL_AUTO, &src, &k, &layer, &kept));
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    gp_sources_free(&src);
    gp_engine_splat.close(&kept);
}

static void counts_are_those_of_the_groups(void **state)
{
    static const char *const names[] = {"blended quads", "blended points",
                                        "tiles, groups from the CPU"};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(64, 32, EVERY);
    struct gp_kernel k = make_kernel(41, 41, 20, 20, PEAK);
    for (int p = 0; p < PRIMITIVES; p++) {
        struct gp_planes layer;
        how = (struct gp_splat_params) GP_SPLAT_DEFAULTS;
        how.shrink = 0.0f;
        how.primitive = primitives[p];
        assert_ok(splat(GP_GL_AUTO, &src, &k, &layer, &kept));
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
    gp_sources_free(&src);
    gp_engine_splat.close(&kept);
}

/* Share of all luminance by which `layer` is darker, pixel after pixel. */
static double light_lost(const struct gp_sources *src,
    const struct gp_kernel *k, const struct gp_planes *exact,
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
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(131, 67, MANY);
    struct gp_kernel k = make_kernel(63, 61, 31, 30, PEAK);
    for (int p = 0; p < PRIMITIVES; p++) {
        struct gp_planes exact = {0}, layer;
        double before = 0.0, pixels = INFINITY;
        for (int i = 0; i < 5; i++) {
            how.primitive = primitives[p];
            how.shrink = shares[i];
            assert_ok(splat(GP_GL_AUTO, &src, &k, &layer, &kept));
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
    gp_sources_free(&src);
    gp_engine_splat.close(&kept);
}

/* bound() before run() says what run() publishes, and a plan that is kept
 * never outlives its light. */
static void plans_are_kept_for_their_light_alone(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_sources src = make_sources(50, 40, FEW);
    struct gp_kernel k = make_kernel(31, 31, 15, 15, PEAK);
    k.serial = 12345; // as one that was made from a file
    for (int i = 0; i < 4; i++) {
        const struct gp_glare_params params = {.splat = how};
        const struct gp_glare_job job = {.log = &said_log, .params = &params,
                                         .src = &src, .kernel = &k,
                                         .stats = &stats};
        struct gp_planes layer;
        double bound = -1.0;
        if (i % 2 == 0)
            assert_ok(gp_engine_splat.bound(&job, &kept, &bound));
        if (i == 2)
            src.rgb[1][src.n / 2] *= 2.0f; // at the same address
        assert_ok(splat(GP_GL_AUTO, &src, &k, &layer, &kept));
        if (i == 0)
            assert_true(bound == stats.bound);
        assert_true(rel_l2(&src, &k, &layer) <= 1e-6);
        gp_planes_free(&layer);
    }
    gp_planes_free(&k.k);
    gp_sources_free(&src);
    gp_engine_splat.close(&kept);
}

SUITE(splat)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(osmesa_equals_the_sum),
        cmocka_unit_test(egl_equals_the_sum),
        cmocka_unit_test(tiles_equal_the_sum),
        cmocka_unit_test(over_the_limit_fails_with_words),
        cmocka_unit_test(no_stale_kernel),
        cmocka_unit_test(contexts_in_turns),
        cmocka_unit_test(counts_are_right),
        cmocka_unit_test(large_points_are_refused),
        cmocka_unit_test(counts_are_those_of_the_groups),
        cmocka_unit_test(shrinking_leaves_out_what_it_may),
        cmocka_unit_test(plans_are_kept_for_their_light_alone),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
