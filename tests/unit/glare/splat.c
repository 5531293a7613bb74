/* splat against a plain double sum: sizes, kernels, tiles, sequences.
 *
 *   test_splat          the tests
 *   test_splat --time   measures the constants of splat.c's prediction
 */
#include "unit.h"
#include "core/clock.h"
#include "core/parallel.h"
#include "glare/engine.h"
#include "splat_scene.h"

static gp_status splat_or_skip(enum gp_gl_api gl,
                               const struct gp_sources *src,
                               const struct gp_kernel *k,
                               struct gp_planes *layer, void **state)
{
    gp_status st = splat(gl, src, k, layer, state);
    if (st == GP_ERR_GL && strstr(last_line, "install the Debian")) {
        print_message("no context: %s\n", last_line);
        skip();
    }
    return st;
}

/* -- rows ------------------------------------------------------------------ */

struct row {
    int w, h;
    enum light light;
    int kw, kh, cx, cy;
    enum shape shape;
};

static const struct row rows[] = {
    {1, 1, EVERY, 1, 1, 0, 0, PEAK},
    {1, 1, EVERY, 9, 7, 4, 3, PEAK},
    {7, 5, EVERY, 1, 1, 0, 0, BOX},
    {40, 30, NONE, 9, 9, 4, 4, PEAK},
    {40, 30, CORNERS, 9, 9, 4, 4, PEAK},
    {40, 30, CORNERS, 8, 8, 4, 4, HOLES},
    {40, 30, CORNERS, 200, 151, 100, 75, PEAK}, // larger than the frame
    {40, 30, EVERY, 200, 151, 100, 75, PEAK},
    {31, 29, FEW, 16, 9, 8, 4, LOBES},
    {97, 1, FEW, 33, 33, 16, 16, PEAK},
    {1, 97, FEW, 33, 33, 16, 16, PEAK},
    {64, 64, FEW, 13, 11, 0, 10, PEAK},         // centre in a corner
    {64, 64, FEW, 13, 11, -20, 31, PEAK},       // centre outside
    {64, 64, FEW, 13, 11, 2000, 5, PEAK},       // reaches no pixel
    {64, 64, FEW, 13, 11, 2147483647, -2147483647, PEAK},
    {64, 64, FEW, 200, 3, 180, 1, LOBES},
    {61, 67, HOT, 63, 63, 31, 31, PEAK},
    {131, 67, MANY, 31, 30, 15, 15, HOLES},
    {131, 67, MANY, 31, 30, 15, 15, LOBES},
    {64, 80, EVERY, 24, 25, 12, 12, PEAK},      // 5120 sources
    {50, 50, EQUAL, 96, 96, 48, 48, BOX},       // roundings of one direction
    {1, 4801, FEW, 3, 70, 1, 35, PEAK},         // over one tile
    {4801, 1, FEW, 70, 3, 35, 1, PEAK},
    {16384, 3, CORNERS, 65, 5, 32, 2, PEAK},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static void run_row(enum gp_gl_api gl, const struct row *r, void **state)
{
    seed = 20071u;
    struct gp_sources src = make_sources(r->w, r->h, r->light);
    struct gp_kernel k = make_kernel(r->kw, r->kh, r->cx, r->cy, r->shape);
    struct gp_planes layer;
    int row = (int) (r - rows);
    if (splat_or_skip(gl, &src, &k, &layer, state) != GP_OK)
        fail_msg("row %d, %d: %s", row, how.primitive, last_line);
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
    free_sources(&src);
}

/* One state for all rows: frames and kernels change size under way, and how
 * they are drawn. */
static void rows_equal_the_sum(enum gp_gl_api gl)
{
    static const enum gp_primitive primitives[] = {
        GP_PRIMITIVE_QUAD, GP_PRIMITIVE_POINT, GP_PRIMITIVE_TILE,
        GP_PRIMITIVE_AUTO,
    };
    void *state = NULL;
    for (int i = 0; i < ROWS; i++) {
        for (int p = 0; p < 4; p++) {
            how.primitive = primitives[p];
            run_row(gl, &rows[i], &state);
        }
    }
    how.primitive = GP_PRIMITIVE_AUTO;
    gp_engine_splat.close(&state);
    assert_null(state);
}

static void osmesa_equals_the_sum(void **state)
{
    (void) state;
    rows_equal_the_sum(GP_GL_OSMESA);
}

static void egl_equals_the_sum(void **state)
{
    (void) state;
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
    (void) state;
    how.primitive = GP_PRIMITIVE_QUAD;
    for (size_t i = 0; i < sizeof tiled / sizeof tiled[0]; i++) {
        void *kept = NULL;
        setenv("GLAREPP_GL_MAX_SIZE", tiled[i].side, 1);
        run_row(GP_GL_AUTO, &tiled[i].row, &kept);
        unsetenv("GLAREPP_GL_MAX_SIZE");
        gp_engine_splat.close(&kept);
    }
    how.primitive = GP_PRIMITIVE_AUTO;
}

static void over_the_limit_fails_with_words(void **state)
{
    (void) state;
    void *kept = NULL;
    struct gp_sources src = make_sources(40, 30, FEW);
    struct gp_kernel small = make_kernel(9, 9, 4, 4, PEAK);
    struct gp_kernel large = make_kernel(17, 9, 8, 4, PEAK);
    struct gp_planes layer;
    how.primitive = GP_PRIMITIVE_QUAD;
    setenv("GLAREPP_GL_MAX_SIZE", "16", 1);
    assert_int_equal(splat_or_skip(GP_GL_AUTO, &src, &small, &layer, &kept),
                     GP_OK);
    gp_planes_free(&layer);
    assert_int_equal(splat(GP_GL_AUTO, &src, &large, &layer, &kept),
                     GP_ERR_GL);
    assert_non_null(strstr(last_line, "kernel: 17x9"));
    assert_non_null(strstr(last_line, "16x16 is the limit"));
    gp_planes_free(&layer);
    // the state is whole: the next frame is drawn as if nothing had been
    assert_int_equal(splat(GP_GL_AUTO, &src, &small, &layer, &kept), GP_OK);
    assert_true(rel_l2(&src, &small, &layer) <= 2e-6);
    unsetenv("GLAREPP_GL_MAX_SIZE");
    how.primitive = GP_PRIMITIVE_AUTO;
    gp_planes_free(&layer);
    gp_planes_free(&small.k);
    gp_planes_free(&large.k);
    gp_engine_splat.close(&kept);
    free_sources(&src);
}

static void missing_library_fails_with_words(void **state)
{
    (void) state;
    void *kept = NULL;
    struct gp_sources src = make_sources(4, 3, EVERY);
    struct gp_kernel k = make_kernel(3, 3, 1, 1, PEAK);
    struct gp_planes layer;
    setenv("GLAREPP_OSMESA", "/nonexistent/libOSMesa.so.8", 1);
    assert_int_equal(splat(GP_GL_OSMESA, &src, &k, &layer, &kept), GP_ERR_GL);
    unsetenv("GLAREPP_OSMESA");
    gp_engine_splat.close(&kept);
    assert_null(kept);
    assert_non_null(strstr(last_line, "libosmesa6"));
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    free_sources(&src);
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
    (void) state;
    void *kept = NULL;
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
        assert_int_equal(splat_or_skip(GP_GL_AUTO, &src, &k, &a, &kept),
                         GP_OK);
        assert_int_equal(splat(GP_GL_AUTO, &src, &k, &b, &fresh), GP_OK);
        same_bits(&src, &a, &b);
        assert_true(rel_l2(&src, &k, &a) <= 2e-6);
        gp_engine_splat.close(&fresh);
        gp_planes_free(&a);
        gp_planes_free(&b);
    }
    gp_engine_splat.close(&kept);
    gp_planes_free(&k.k);
    free_sources(&src);
}

/* Two states in turns, one of them changing its context under way. */
static void contexts_in_turns(void **state)
{
    (void) state;
    void *one = NULL, *two = NULL;
    struct gp_sources src = make_sources(50, 40, FEW);
    struct gp_kernel k = make_kernel(15, 15, 7, 7, PEAK);
    for (int i = 0; i < 4; i++) {
        struct gp_planes a, b;
        assert_int_equal(splat_or_skip(i % 2 ? GP_GL_EGL : GP_GL_OSMESA, &src,
                                       &k, &a, &one), GP_OK);
        assert_non_null(strstr(stats.gl, i % 2 ? "EGL" : "OSMesa"));
        assert_int_equal(splat_or_skip(GP_GL_EGL, &src, &k, &b, &two), GP_OK);
        assert_true(rel_l2(&src, &k, &a) <= 2e-6);
        assert_true(rel_l2(&src, &k, &b) <= 2e-6);
        gp_planes_free(&a);
        gp_planes_free(&b);
    }
    gp_engine_splat.close(&one);
    gp_engine_splat.close(&two);
    gp_planes_free(&k.k);
    free_sources(&src);
}

static void counts_are_right(void **state)
{
    (void) state;
    void *kept = NULL;
    struct gp_sources src = make_sources(40, 30, CORNERS);
    struct gp_kernel k = make_kernel(9, 7, 4, 3, PEAK);
    struct gp_planes layer;
    const struct gp_glare_params params = {.splat = how};
    const struct gp_glare_job job = {.params = &params, .src = &src,
                                     .kernel = &k};
    assert_int_equal(splat_or_skip(GP_GL_AUTO, &src, &k, &layer, &kept),
                     GP_OK);
    assert_int_equal(stats.polygons, 4);
    assert_true(stats.polygon_pixels == 4 * 5 * 4);
    assert_true(stats.bound > 0 && stats.bound < 1e-5);
    assert_true(gp_engine_splat.predict(&job, NULL).ms > 0);
    gp_planes_free(&layer);
    gp_planes_free(&k.k);
    gp_engine_splat.close(&kept);
    gp_engine_splat.close(&kept);
    free_sources(&src);
}

/* -- timing ---------------------------------------------------------------- */

static double time_frame(const struct gp_sources *src,
                         const struct gp_kernel *k, void **state)
{
    struct gp_planes layer;
    double best = INFINITY;
    for (int i = 0; i < 5; i++) {
        double start = gp_now_ms();
        if (splat(GP_GL_AUTO, src, k, &layer, state) != GP_OK)
            exit(77);
        double ms = gp_now_ms() - start;
        best = ms < best && (i > 0 || !*state) ? ms : best;
        gp_planes_free(&layer);
    }
    return best;
}

/* A frame of 1024x768 whose box is whole: the corners, and `n` sources in a
 * square lattice about the middle half. */
static struct gp_sources make_timed(int n)
{
    int across = (int) sqrt((double) n);
    struct gp_sources s = make_sources(1024, 768, CORNERS);
    size_t at = 2; // behind the upper corners
    for (int y = 1; y < 768; y++) {
        bool lit = y >= 256 && y < 256 + across;
        for (int i = 0; i < (lit ? across : 0); i++)
            s.x[at++] = 256 + i * (512 / across);
        for (int i = 0; y == 767 && i < 2; i++)
            s.x[at++] = i * 1023;
        s.row[y + 1] = (uint32_t) at;
    }
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < at; i++)
            s.rgb[c][i] = 2.0f;
    }
    s.n = at;
    return s;
}

static int print_times(void)
{
    static const struct { int n, side; } timed[] = {
        {0, 1}, {400, 1}, {400, 16}, {400, 64}, {400, 256}, {400, 512},
        {4000, 16}, {4000, 64}, {40000, 1}, {40000, 8},
    };
    void *state = NULL;
    double start = gp_now_ms();
    struct gp_sources one = make_sources(8, 8, CORNERS);
    struct gp_kernel dot = make_kernel(1, 1, 0, 0, BOX);
    struct gp_planes layer;
    if (splat(GP_GL_AUTO, &one, &dot, &layer, &state) != GP_OK)
        return 77;
    printf("%s, %d threads: first frame %.1f ms, later ones %.2f ms\n",
           stats.gl, gp_threads(), gp_now_ms() - start,
           time_frame(&one, &dot, &state));
    for (size_t i = 0; i < sizeof timed / sizeof timed[0]; i++) {
        struct gp_sources src = make_timed(timed[i].n);
        struct gp_kernel k = make_kernel(timed[i].side, timed[i].side,
                                         timed[i].side / 2, timed[i].side / 2,
                                         PEAK);
        const struct gp_glare_params params = {.splat = how};
        const struct gp_glare_job job = {.params = &params, .src = &src,
                                         .kernel = &k};
        double ms = time_frame(&src, &k, &state);
        printf("1024x768, %5zu polygons of %dx%d: %.1f ms (%.0f predicted "
               "with the start)\n", src.n, k.w, k.h, ms,
               gp_engine_splat.predict(&job, NULL).ms);
        gp_planes_free(&k.k);
        free_sources(&src);
    }
    gp_engine_splat.close(&state);
    return 0;
}

SUITE(splat)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(osmesa_equals_the_sum),
        cmocka_unit_test(egl_equals_the_sum),
        cmocka_unit_test(tiles_equal_the_sum),
        cmocka_unit_test(over_the_limit_fails_with_words),
        cmocka_unit_test(missing_library_fails_with_words),
        cmocka_unit_test(no_stale_kernel),
        cmocka_unit_test(contexts_in_turns),
        cmocka_unit_test(counts_are_right),
    };
    if (argc > 1 && strcmp(argv[1], "--time") == 0)
        return print_times();
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
