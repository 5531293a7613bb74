/* What a layer gathered per tile does not depend on: the batches that lists
 * are cut into, what was drawn before, the number of threads.
 *
 *   test_tile_same          the tests
 *   test_tile_same --hash   prints a checksum of one layer (the tests call it)
 */
#include "unit.h"
#include "tile_scene.h"
#include "driver_threads.h"
#include "hash.h"

#include "glare/splat/splat_priv.h"

/* -- batches --------------------------------------------------------------- */

/* Batches hold at least GP_TILE_BATCH polygons, whatever side is taken. */
static void batches_are_large(void **state)
{
    static const struct row sizes[] = {
        {1024, 1024, 4000, BETWEEN, 1, 0, 2047, 2047, 1023, 1023, GREY, {0},
         false},
        {1024, 1024, 4000, BETWEEN, 1, 0, 31, 31, 15, 15, GREY, {0}, false},
        {1024, 1024, 4000, BETWEEN, 1, 210, 2047, 3, 1023, 1, GREY, {0},
         false},
        {1024, 768, 4000, BETWEEN, 1, 240, 511, 511, 255, 255, GREY, {0},
         false},
    };
    struct gp_tile_batch list = {0};
    (void) state;
    list.texel = malloc((size_t) GP_TILE_TEXELS * 4 * sizeof(float));
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        struct scene s = make_scene(&sizes[i]);
        struct gp_tile_pieces p;
        size_t next = 0, batches = 0;
        assert_int_equal(gp_tile_pieces_make(&log_kept, &s.kernel, s.crop,
                                             &s.polygons, &s.shrink, s.w, s.h,
                                             &p), GP_OK);
        list.field = (struct gp_rect) {0, 0, s.w, s.h};
        list.side = gp_tile_side(&p, 1, list.field);
        assert_true(list.side >= 4 && list.side <= 6);
        for (; next < p.first[2]; batches++) {
            gp_tile_batch_enter(&s.polygons, &p, 1, &next, &list);
            assert_true(list.texels <= GP_TILE_TEXELS && list.most > 0);
        }
        assert_true(batches <= 1 + s.polygons.n / GP_TILE_BATCH);
        gp_tile_pieces_free(&p);
        free_scene(&s);
    }
    free(list.texel);
}

/* Lists that do not fit one batch: every tile of the field for each of more
 * polygons than the least of a batch. */
static void batches_equal_the_sum(void **state)
{
    enum { SIDE = 1024, N = 1300 };
    static const struct row row = {SIDE, SIDE, N, WHOLE, 1, 0, 1, 1, 0, 0,
                                   GREY, {0}, false};
    (void) state;
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_tiles *kept = NULL;
    double roundings;
    seed = 5u;
    struct scene s = make_scene(&row);
    gp_planes_free(&s.kernel.k); // one value everywhere, as far as it goes
    s.kernel = make_kernel(2 * SIDE, 2 * SIDE, SIDE, SIDE, BOX);
    s.crop = (struct gp_rect) {0, 0, 2 * SIDE, 2 * SIDE};
    assert_int_equal(draw(gl, &s, &kept, &roundings), GP_OK);
    assert_true(roundings <= gp_tiles_roundings(&s.polygons));
    for (int c = 0; c < 3; c++) {
        double want = 0.0;
        for (int i = 0; i < N; i++)
            want += (double) (0.1f * s.polygons.at[i].rgb[c]);
        for (int i = 0; i < SIDE * SIDE; i++) {
            double error = fabs((double) s.layer.c[c][i] - want);
            assert_true(error <= roundings * 0x1p-24 * want);
        }
    }
    free_scene(&s);
    gp_tiles_free(gl, &kept);
    gp_gl_close(&gl);
}

/* -- sequences ------------------------------------------------------------- */

/* Kernels, crops and tails that change under one state leave no trace. */
static void no_stale_kernel(void **state)
{
    static const struct row row = {61, 47, 50, MIXED, 4, 252, 33, 35, 16, 17,
                                   GREY, {0}, false};
    (void) state;
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_tiles *kept = NULL;
    for (int i = 0; i < 8; i++) {
        struct gp_tiles *fresh = NULL;
        double roundings;
        seed = 7u;
        struct scene a = make_scene(&row);
        seed = 7u;
        struct scene b = make_scene(&row);
        if (i >= 2 && i < 6)
            a.crop.x0 = b.crop.x0 = 3;
        a.tail = b.tail = i >= 4;
        a.kernel.serial = b.kernel.serial = i < 5 ? 1000000u : 0u;
        for (int c = 0; i >= 5 && c < 3; c++) // the same serial, 0, each time
            a.kernel.k.c[c][40] = b.kernel.k.c[c][40] = (float) i;
        assert_int_equal(draw(gl, &a, &kept, &roundings), GP_OK);
        assert_int_equal(draw(gl, &b, &fresh, &roundings), GP_OK);
        for (int c = 0; c < 3; c++)
            assert_memory_equal(a.layer.c[c], b.layer.c[c],
                                61 * 47 * sizeof(float));
        gp_tiles_free(gl, &fresh);
        free_scene(&a);
        free_scene(&b);
    }
    gp_tiles_free(gl, &kept);
    gp_gl_close(&gl);
}

/* -- threads --------------------------------------------------------------- */

/* The hash of a layer with all blurs, cuts and several fields. */
static int print_hash(void)
{
    static const struct row row = {1211, 173, 300, MIXED, 10, 252, 64, 61, 32,
                                   30, COLOUR, {0}, false};
    struct gp_gl *gl;
    struct gp_tiles *kept = NULL;
    double roundings;
    if (gp_gl_open(&log_kept, GP_GL_AUTO, &gl) != GP_OK)
        return 77;
    seed = 5u;
    struct scene s = make_scene(&row);
    if (draw(gl, &s, &kept, &roundings) != GP_OK)
        return 1;
    printf("%016llx\n",
           (unsigned long long) hash_layer(&s.layer, 1211 * 173));
    free_scene(&s);
    gp_tiles_free(gl, &kept);
    gp_gl_close(&gl);
    return 0;
}

static const char *suite;

static void threads_change_no_byte(void **state)
{
    (void) state;
    threads_same_bytes(suite);
}

SUITE(tile_same)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(batches_are_large),
        cmocka_unit_test(batches_equal_the_sum),
        cmocka_unit_test(no_stale_kernel),
        cmocka_unit_test(threads_change_no_byte),
    };
    suite = argv[0];
    if (argc > 1 && strcmp(argv[1], "--hash") == 0)
        return print_hash();
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
