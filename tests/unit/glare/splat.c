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
    {1, 1, ALL, 1, 1, 0, 0, PEAK}, {1, 1, ALL, 9, 7, 4, 3, PEAK},
    {7, 5, ALL, 1, 1, 0, 0, BOX}, {40, 30, DARK, 9, 9, 4, 4, PEAK},
    {40, 30, CORNERS, 9, 9, 4, 4, PEAK}, {40, 30, CORNERS, 8, 8, 4, 4, HOLES},
    {40, 30, CORNERS, 200, 151, 100, 75, PEAK}, // larger than the frame
    {40, 30, ALL, 200, 151, 100, 75, PEAK}, {31, 29, FEW, 16, 9, 8, 4, LOBES},
    {97, 1, FEW, 33, 33, 16, 16, PEAK}, {1, 97, FEW, 33, 33, 16, 16, PEAK},
    {64, 64, FEW, 13, 11, 0, 10, PEAK},         // centre in a corner
    {64, 64, FEW, 13, 11, -20, 31, PEAK},       // centre outside
    {64, 64, FEW, 13, 11, 2000, 5, PEAK},       // reaches no pixel
    {64, 64, FEW, 13, 11, 2147483647, -2147483647, PEAK},
    {64, 64, FEW, 200, 3, 180, 1, LOBES}, {61, 67, HOT, 63, 63, 31, 31, PEAK},
    {131, 67, MANY, 31, 30, 15, 15, HOLES},
    {131, 67, MANY, 31, 30, 15, 15, LOBES},
    {64, 80, ALL, 24, 25, 12, 12, PEAK},      // 5120 sources
    {50, 50, EQUAL, 96, 96, 48, 48, BOX},       // roundings of one direction
    {1, 4801, FEW, 3, 70, 1, 35, PEAK},         // over one tile
    {4801, 1, FEW, 70, 3, 35, 1, PEAK},
    {16384, 3, CORNERS, 65, 5, 32, 2, PEAK},
};

static void run_row(enum gp_gl_api gl, const struct row *r, void **state)
{
    struct scene s = splat_scene(r->w, r->h, r->light, splat_kernel(r->kw,
        r->kh, r->cx, r->cy, r->shape));
    const int row = (int) (r - rows);
    if (splat(gl, &s, state) != GP_OK)
        fail_msg("row %d, %d: %s", row, how.primitive, kept_line);
    const double error = splat_error(&s);
    if (!(error <= 2e-6 && (!stats.gl || error <= stats.bound)))
        fail_msg("row %d, %d: rel_l2 %g, bound %g", row, how.primitive, error,
                 stats.bound);
    if (stats.gl && r->shape == LOBES)
        assert_true(isinf(stats.bound));
    scene_free(&s);
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
        {"16", {40, 50, ALL, 16, 3, 8, 1, LOBES}},
        {"64", {200, 150, FEW, 64, 61, 32, 30, PEAK}},
        {"64", {200, 150, CORNERS, 9, 61, -30, 90, PEAK}},
        {"1", {5, 4, ALL, 1, 1, 0, 0, PEAK}},
        {"7", {22, 1, ALL, 7, 7, 0, 6, HOLES}},
    };
    how.primitive = GP_PRIMITIVE_QUAD;
    for (size_t i = 0; i < COUNT(tiled); i++) {
        void *kept = open_small_or_skip(tiled[i].side);
        run_row(GP_GL_AUTO, &tiled[i].row, &kept);
        gp_engine_splat.close(&kept);
    }
    how.primitive = GP_PRIMITIVE_AUTO;
}

static void over_the_limit_fails_with_words(void **state)
{
    static const int widths[] = {9, 17, 9}; // of the kernel
    void *kept = open_small_or_skip("16");
    how.primitive = GP_PRIMITIVE_QUAD;
    for (int i = 0; i < 3; i++) {
        struct scene s = splat_scene(40, 30, FEW, scene_kernel(widths[i], 9,
            MID, 0, PEAK));
        const gp_status st = splat(GP_GL_AUTO, &s, &kept);
        if (i == 1) {
            assert_int_equal(st, GP_ERR_GL);
            assert_kept("kernel: 17x9");
            assert_kept("1x1 to 16x16 do");
        } else { // the last is drawn as if nothing had been: the state is whole
            assert_ok(st);
            assert_true(splat_error(&s) <= 2e-6);
        }
        scene_free(&s);
    }
    how.primitive = GP_PRIMITIVE_AUTO;
    gp_engine_splat.close(&kept);
}

/* -- sequences ------------------------------------------------------------- */

/* A kernel that changes in place, at one address, is seen; what the state
 * went through leaves no trace in the bytes. */
static void no_stale_kernel(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct scene s =
        splat_scene(61, 47, MANY, scene_kernel(21, 21, MID, 0, TINTED));
    for (int i = 0; i < 10; i++) {
        void *fresh = NULL;
        if (i == 2)
            s.k.k.c[2][20 * 21 + 20] = 0.5f; // the last sample alone
        if (i == 4)
            s.k.cx = 3;
        if (i == 5 || i == 6) {
            gp_kernel_free(&s.k);
            s.k = splat_kernel(21, 21, 3, 10, i == 5 ? LOBES : BOX);
        }
        if (i == 7)
            s.k.w = 19; // all samples are as before
        if (i == 8)
            s.k.h = 18;
        s.k.serial = 0;
        assert_ok(splat(GP_GL_AUTO, &s, &kept));
        const uint64_t hash = scene_hash(&s);
        assert_true(splat_error(&s) <= 2e-6);
        assert_ok(splat(GP_GL_AUTO, &s, &fresh));
        assert_true(scene_hash(&s) == hash);
        gp_engine_splat.close(&fresh);
    }
    gp_engine_splat.close(&kept);
    scene_free(&s);
}

/* Two states in turns, one of them changing its context under way. */
static void contexts_in_turns(void **state)
{
    void *one = open_or_skip(GP_GL_OSMESA), *two = open_or_skip(GP_GL_EGL);
    struct scene s =
        splat_scene(50, 40, FEW, scene_kernel(15, 15, MID, 0, PEAK));
    for (int i = 0; i < 4; i++) {
        assert_ok(splat(i % 2 ? GP_GL_EGL : GP_GL_OSMESA, &s, &one));
        assert_non_null(strstr(stats.gl, i % 2 ? "EGL" : "OSMesa"));
        assert_true(splat_error(&s) <= 2e-6);
        assert_ok(splat(GP_GL_EGL, &s, &two));
        assert_true(splat_error(&s) <= 2e-6);
    }
    gp_engine_splat.close(&one);
    gp_engine_splat.close(&two);
    scene_free(&s);
}

static void counts_are_right(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct scene s =
        splat_scene(40, 30, CORNERS, scene_kernel(9, 7, MID, 0, PEAK));
    assert_ok(splat(GP_GL_AUTO, &s, &kept));
    assert_int_equal(stats.polygons, 4);
    assert_true(stats.polygon_pixels == 4 * 5 * 4);
    assert_true(stats.bound > 0 && stats.bound < 1e-5);
    gp_engine_splat.close(&kept);
    gp_engine_splat.close(&kept);
    scene_free(&s);
}

/* One light and many that are each swallowed by the sum so far: every rounding
 * goes the same way. A blended one may be twice as large, as GL leaves its
 * direction to the driver. */
static void roundings_are_not_twice_too_many(void **state)
{
    static const struct {
        enum gp_primitive primitive;
        int lights, parts; // that are summed by themselves
        double least, most;
    } rows_of[] = {
        {GP_PRIMITIVE_QUAD, 64, 1, 0.4, 0.5},
        {GP_PRIMITIVE_TILE, 1024, 32, 0.7, 1.0},
    };
    void *kept = open_or_skip(GP_GL_AUTO);
    for (size_t i = 0; i < COUNT(rows_of); i++) {
        const int n = rows_of[i].lights, part = n / rows_of[i].parts;
        struct gp_frame f = scene_frame(n, 1, 0, 0, BLACK, 0);
        struct gp_kernel k = scene_kernel(2 * n - 1, 1, MID, 0, BOX);
        for (int c = 0; c < 3; c++) {
            for (int j = 0; j < n; j++)
                f.rgb.c[c][j] = j == 0      ? 1.0f
                                : j < part  ? 0x1.fffffep-25f
                                            : 0x1.fffffep-25f / (float) part;
            for (int j = 0; j < k.w; j++)
                k.k.c[c][j] = 1.0f;
        }
        struct scene s = scene_sense(f, k, &open_all);
        how.primitive = rows_of[i].primitive;
        assert_ok(splat(GP_GL_AUTO, &s, &kept));
        const double share = splat_error(&s) / stats.bound;
        print_message("roundings: %.3f of the bound %.2g\n", share,
                      stats.bound);
        assert_true(share > rows_of[i].least && share <= rows_of[i].most);
        scene_free(&s);
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    gp_engine_splat.close(&kept);
}

/* -- limits and counts ------------------------------------------------ */

static void counts_are_those_of_the_groups(void **state)
{
    static const char *const names[] = {"blended quads",
                                        "tiles, groups from the CPU"};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct scene s =
        splat_scene(64, 32, ALL, scene_kernel(41, 41, MID, 0, PEAK));
    for (int p = 0; p < PRIMITIVES; p++) {
        how = (struct gp_splat_params) GP_SPLAT_DEFAULTS;
        how.shrink = 0.0f;
        how.primitive = primitives[p];
        assert_ok(splat(GP_GL_AUTO, &s, &kept));
        assert_int_equal(stats.clusters, 32);
        assert_int_equal(stats.groups, 0);
        assert_int_equal(stats.polygons, 32);
        assert_int_equal(stats.cores, 64 * 32);
        assert_string_equal(stats.form, names[p]);
        assert_true(stats.polygon_pixels > 32 * 20 * 20);
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    scene_free(&s);
    gp_engine_splat.close(&kept);
}

/* Share of all luminance by which the layer is darker than the exact one,
 * pixel after pixel. */
static double light_lost(const struct scene *s)
{
    const size_t n = gp_frame_pixels(&s->f);
    const double norm =
        fmax(s->k.norm1[0], fmax(s->k.norm1[1], s->k.norm1[2]));
    double lost = 0.0, all = 0.0;
    for (size_t c = 0; c < 3; c++) {
        const double weight = (double) s->src.luminance[c];
        for (size_t i = 0; i < n; i++) {
            const double was = s->exact[c * n + i];
            const double is = (double) s->f.layer.c[c][i];
            assert_true(is <= was * (1.0 + 1e-5));
            lost += weight * (was - is);
        }
        all += weight * s->src.flux[c] * norm;
    }
    return lost / all;
}

/* Shrinking takes light away and never adds any, takes no more than it may,
 * and takes more the more it may. */
static void shrinking_leaves_out_what_it_may(void **state)
{
    static const float shares[] = {0.0f, 1e-4f, 1e-3f, 1e-2f, 0.1f};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct scene s =
        splat_scene(131, 67, MANY, scene_kernel(63, 61, MID, 0, PEAK));
    for (int p = 0; p < PRIMITIVES; p++) {
        double before = 0.0, pixels = INFINITY;
        for (int i = 0; i < 5; i++) {
            how.primitive = primitives[p];
            how.shrink = shares[i];
            assert_ok(splat(GP_GL_AUTO, &s, &kept));
            assert_true(stats.polygon_pixels <= pixels);
            pixels = stats.polygon_pixels;
            if (i == 0) {
                assert_true(splat_error(&s) <= 2e-6);
                continue;
            }
            const double lost = light_lost(&s);
            if (!(lost <= (double) shares[i] + 1e-6 && lost > before))
                fail_msg("primitive %d: %g lost of %g", p, lost,
                         (double) shares[i]);
            before = lost;
        }
        assert_true(before > 1e-3); // polygons did shrink
    }
    how = (struct gp_splat_params) GP_SPLAT_EXACT;
    scene_free(&s);
    gp_engine_splat.close(&kept);
}

/* bound() before run() says what run() publishes, and a layout that is kept
 * never outlives its light. */
static void layouts_are_kept_for_their_light_only(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    struct scene s =
        splat_scene(50, 40, FEW, scene_kernel(31, 31, MID, 0, PEAK));
    for (int i = 0; i < 4; i++) {
        if (i == 2)
            s.src.rgb[1][s.src.n / 2] *= 2.0f; // at the same address
        assert_ok(splat(GP_GL_AUTO, &s, &kept));
        assert_true(splat_error(&s) <= 1e-6);
    }
    scene_free(&s);
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
        cmocka_unit_test(roundings_are_not_twice_too_many),
        cmocka_unit_test(counts_are_those_of_the_groups),
        cmocka_unit_test(shrinking_leaves_out_what_it_may),
        cmocka_unit_test(layouts_are_kept_for_their_light_only),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
