/* Polygons gathered per tile against a plain double sum: sizes, kernels,
 * blurs, cuts, fields, limits; and the roundings they promise.
 *
 *   test_tile          the tests
 *   test_tile --time   ms a polygon, against blended quads
 */
#include "unit.h"
#include "tile_scene.h"

#include "core/clock.h"
#include "glare/splat/polygons.h"
#include "glare/engine.h"

/* -- the sum --------------------------------------------------------------- */

static double sample(const struct gp_blur *b, int c, double x, double y)
{
    return x < 0 || y < 0 || x >= b->w || y >= b->h
               ? 0.0 : (double) b->k.c[c][(size_t) y * (size_t) b->w +
                                          (size_t) x];
}

struct sums {
    double *sum, *size, *slack; // the sum; of magnitudes; where positions
                                // are rounded
};

/* One polygon on one channel. */
static void add_polygon(const struct scene *s, const struct gp_blur *b,
                        const struct gp_polygon *g, int c, struct sums *out)
{
    int reach = s->shrink.reach[gp_source_bin(g->light)];
    for (int i = 0; i < s->w * s->h; i++) {
        double dx = i % s->w - (double) g->x, dy = i / s->w - (double) g->y;
        double x = dx + (double) b->cx, y = dy + (double) b->cy;
        double fx = x - floor(x), fy = y - floor(y), biggest = 0.0;
        if (fabs(dx) > reach || fabs(dy) > reach || x <= -1 || y <= -1 ||
            x >= b->w || y >= b->h)
            continue;
        for (int k = 0; k < 4; k++) {
            double v = sample(b, c, floor(x) + k % 2, floor(y) + k / 2) *
                       (double) g->rgb[c];
            double share = v * (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
            out->sum[i] += share;
            out->size[i] += fabs(share);
            biggest = fmax(biggest, fabs(v));
        }
        if (fx != 0.0 || fy != 0.0)
            out->slack[i] += 0x1p-23 * biggest;
    }
}

static struct sums make_sums(const struct scene *s, int c)
{
    size_t n = (size_t) s->w * (size_t) s->h;
    struct sums out = {calloc(n, sizeof(double)), calloc(n, sizeof(double)),
                       calloc(n, sizeof(double))};
    for (int blur = 0; blur < GP_BLURS; blur++) {
        struct gp_blur b = {0};
        for (size_t i = 0; i < s->polygons.n; i++) {
            if (s->polygons.at[i].blur != blur)
                continue;
            if (b.w == 0)
                assert_int_equal(gp_blur_make(NULL, &s->kernel, s->crop,
                                              s->tail, gp_blur_box[blur], &b),
                                 GP_OK);
            add_polygon(s, &b, &s->polygons.at[i], c, &out);
        }
        gp_blur_free(&b);
    }
    return out;
}

/* Every pixel is as near to the sum as the roundings say (those of 1e-38, the
 * smallest normal number, are flushed away). */
static void check_layer(const struct scene *s, double roundings, int row)
{
    for (int c = 0; c < 3; c++) {
        struct sums want = make_sums(s, c);
        for (int i = 0; i < s->w * s->h; i++) {
            double error = fabs((double) s->layer.c[c][i] - want.sum[i]);
            double most = roundings * 0x1p-24 * want.size[i] + want.slack[i];
            if (!(error <= most + 1e-36))
                fail_msg("row %d, plane %d, pixel (%d, %d): %g, not %g, off "
                         "by %g of %g", row, c, i % s->w, i / s->w,
                         (double) s->layer.c[c][i], want.sum[i], error, most);
        }
        free(want.sum);
        free(want.size);
        free(want.slack);
    }
}

/* -- rows ------------------------------------------------------------------ */

static const struct row rows[] = {
    {1, 1, 1, WHOLE, 1, 0, 1, 1, 0, 0, GREY, {0}, false},
    {1, 1, 9, MIXED, 10, 0, 9, 7, 4, 3, COLOUR, {0}, false},
    {1, 97, 20, MIXED, 3, 0, 33, 33, 16, 16, GREY, {0}, false},
    {97, 1, 20, MIXED, 3, 0, 33, 33, 16, 16, COLOUR, {0}, false},
    {2, 3, 5, BETWEEN, 2, 0, 2, 2, 1, 1, GREY, {0}, false},
    {40, 30, 0, WHOLE, 1, 0, 9, 9, 4, 4, GREY, {0}, false},
    {40, 30, 30, WHOLE, 1, 0, 9, 9, 4, 4, GREY, {0}, false},
    {41, 31, 30, WHOLE, 1, 0, 8, 6, 4, 3, COLOUR, {0}, false},
    {42, 33, 30, BETWEEN, 1, 0, 9, 9, 4, 4, GREY, {0}, false},
    {43, 35, 30, BETWEEN, 1, 0, 8, 6, 4, 3, COLOUR, {0}, false},
    {43, 35, 30, BETWEEN, 2, 0, 1, 1, 0, 0, GREY, {0}, false},
    {70, 67, 40, MIXED, 10, 0, 31, 30, 15, 15, GREY, {0}, false},
    {70, 67, 40, MIXED, 10, 0, 31, 30, 15, 15, COLOUR, {0}, true},
    {70, 67, 40, BETWEEN, 4, 0, 31, 30, 15, 15, LOBES, {0}, false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, GREY, {0}, false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, GREY, {60, 40, 140, 110},
     false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, COLOUR, {0}, true},
    {64, 64, 20, MIXED, 3, 0, 13, 11, 0, 10, GREY, {0}, false}, // corner
    {64, 64, 20, MIXED, 3, 0, 13, 11, -20, 31, GREY, {0}, false}, // outside
    {64, 64, 20, MIXED, 3, 0, 13, 11, 2000, 5, GREY, {0}, false}, // nowhere
    {64, 64, 20, MIXED, 3, 0, 13, 11, INT_MAX, -INT_MAX, GREY, {0}, false},
    {130, 70, 60, WHOLE, 1, 255, 61, 63, 30, 31, GREY, {0}, false}, // cuts
    {130, 70, 60, MIXED, 6, 250, 61, 63, 30, 31, GREY, {0}, false},
    {130, 70, 60, MIXED, 6, 254, 61, 63, 30, 31, COLOUR, {0}, true},
    {130, 70, 60, MIXED, 6, 511, 61, 63, 30, 31, BOX, {0}, false}, // 0 px
    {64, 80, 3000, WHOLE, 1, 0, 24, 25, 12, 12, BOX, {0}, false}, // drift
    {50, 40, 2000, BETWEEN, 2, 0, 96, 96, 48, 48, BOX, {0}, false},
    {4099, 3, 30, MIXED, 3, 0, 65, 5, 32, 2, GREY, {0}, false}, // fields
    {3, 2051, 30, MIXED, 3, 0, 5, 65, 2, 32, COLOUR, {0}, false},
};
enum { ROWS = sizeof rows / sizeof rows[0] };

static void run_row(struct gp_gl *gl, const struct row *r,
                    struct gp_tiles **state, int row)
{
    seed = 2007u + (uint32_t) row;
    struct scene s = make_scene(r);
    double roundings;
    if (draw(gl, &s, state, &roundings) != GP_OK)
        fail_msg("row %d: %s", row, last_line);
    assert_true(roundings <= gp_tiles_roundings(&s.polygons));
    check_layer(&s, roundings, row);
    free_scene(&s);
}

/* One state for all rows: frames and kernels change size under way. */
static void rows_equal_the_sum(enum gp_gl_api api)
{
    struct gp_gl *gl = open_or_skip(api);
    struct gp_tiles *state = NULL;
    for (int i = 0; i < ROWS; i++)
        run_row(gl, &rows[i], &state, i);
    gp_tiles_free(gl, &state);
    assert_null(state);
    gp_tiles_free(gl, &state);
    assert_int_equal(gp_gl_check(&log_kept, gl, "test"), GP_OK);
    gp_gl_close(&gl);
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

/* Targets far smaller than the frame. */
static void small_fields_equal_the_sum(void **state)
{
    static const struct {
        const char *side;
        struct row row;
    } small[] = {
        {"16", {131, 67, 40, MIXED, 1, 0, 64, 16, 7, 8, GREY, {0}, false}},
        {"64", {200, 150, 40, MIXED, 3, 0, 62, 60, 32, 30, COLOUR, {0},
                false}},
        {"64", {200, 150, 40, MIXED, 3, 250, 58, 60, 32, 30, GREY, {0},
                true}},
        {"7", {22, 15, 9, WHOLE, 1, 0, 4, 7, 0, 6, GREY, {0}, false}},
        {"1", {9, 5, 9, BETWEEN, 1, 0, 1, 1, 0, 0, GREY, {0}, false}},
    };
    (void) state;
    for (size_t i = 0; i < sizeof small / sizeof small[0]; i++) {
        struct gp_tiles *kept = NULL;
        setenv("GLAREPP_GL_MAX_SIZE", small[i].side, 1);
        struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
        unsetenv("GLAREPP_GL_MAX_SIZE");
        run_row(gl, &small[i].row, &kept, (int) i);
        gp_tiles_free(gl, &kept);
        gp_gl_close(&gl);
    }
}

static void over_the_limit_fails_with_words(void **state)
{
    static const struct row large = {40, 30, 5, WHOLE, 1, 0, 65, 9, 8, 4,
                                     GREY, {0}, false};
    static const struct row fits = {40, 30, 5, WHOLE, 1, 0, 16, 16, 8, 4,
                                    COLOUR, {0}, false};
    struct gp_tiles *kept = NULL;
    double roundings;
    (void) state;
    setenv("GLAREPP_GL_MAX_SIZE", "16", 1);
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    unsetenv("GLAREPP_GL_MAX_SIZE");
    struct scene s = make_scene(&large);
    assert_int_equal(draw(gl, &s, &kept, &roundings), GP_ERR_GL);
    assert_non_null(strstr(last_line, "kernel: 17x9"));
    free_scene(&s);
    run_row(gl, &fits, &kept, 0); // the state is whole
    gp_tiles_free(gl, &kept);
    gp_gl_close(&gl);
}

/* -- timing ---------------------------------------------------------------- */

enum { TIMED_W = 1024, TIMED_H = 768, TIMED = 256 };

/* Sources on a lattice, whose kernels of 512x512 lie on the frame. */
static struct gp_sources make_lattice(void)
{
    struct gp_sources s = {.w = TIMED_W, .h = TIMED_H, .n = TIMED,
                           .luminance = {0.25f, 0.5f, 0.25f},
                           .box = {256, 256, 256 + 16 * 32, 256 + 16 * 16}};
    s.row = calloc(TIMED_H + 1, sizeof *s.row);
    s.x = calloc(TIMED, sizeof *s.x);
    for (int c = 0; c < 3; c++)
        s.rgb[c] = calloc(TIMED, sizeof(float));
    for (int i = 0; i < TIMED; i++) {
        s.x[i] = 256 + 32 * (i % 16);
        for (int c = 0; c < 3; c++)
            s.rgb[c][i] = 2.0f;
    }
    for (int y = 0; y < TIMED_H; y++) {
        bool lit = y >= 256 && y < 512 && y % 16 == 0;
        s.row[y + 1] = s.row[y] + (lit ? 16 : 0);
    }
    return s;
}

static double time_quads(const struct gp_kernel *k, struct gp_planes *layer)
{
    struct gp_sources src = make_lattice();
    const struct gp_glare_params params = {
        .engine = "splat", .gain = 1.0f,
        .splat = {.group = 1, .cluster_fill = 0.9f,
                  .primitive = GP_PRIMITIVE_QUAD}};
    struct gp_glare_stats stats = {0};
    const struct gp_glare_job job = {
        .log = &log_kept, .params = &params, .src = &src, .kernel = k,
        .layer = layer, .stats = &stats,
    };
    void *state = NULL;
    double best = INFINITY;
    for (int i = 0; i < 4; i++) {
        double start = gp_now_ms();
        if (gp_engine_splat.run(&job, &state) != GP_OK) {
            fprintf(stderr, "%s\n", last_line);
            exit(77);
        }
        double ms = gp_now_ms() - start;
        best = ms < best && i > 0 ? ms : best;
    }
    gp_engine_splat.close(&state);
    free(src.row);
    free(src.x);
    for (int c = 0; c < 3; c++)
        free(src.rgb[c]);
    return best;
}

/* Milliseconds of a frame with the first n polygons. */
static double time_tiles(struct gp_gl *gl, struct scene *s, size_t n,
                         struct gp_tiles **state)
{
    double best = INFINITY, roundings;
    s->polygons.n = n;
    for (int i = 0; i < 4; i++) {
        double start = gp_now_ms();
        if (draw(gl, s, state, &roundings) != GP_OK)
            exit(77);
        double ms = gp_now_ms() - start;
        best = ms < best && i > 0 ? ms : best;
    }
    return best;
}

struct timed {
    enum where where;
    int reach;
    enum shape shape;
};

/* The scene's polygons on the lattice; their mean area in pixels. */
static double lay_out(struct scene *s, const struct timed *t)
{
    double pixels = 0.0;
    for (int i = 0; i < TIMED; i++) {
        struct gp_polygon *g = &s->polygons.at[i];
        float more = t->where == WHOLE ? 0.0f : 0.37f;
        g->x = (float) (256 + 32 * (i % 16)) + more;
        g->y = (float) (256 + 16 * (i / 16)) + more;
        double side = fmin(512, 2.0 * s->shrink.reach[gp_source_bin(g->light)] +
                                    1.0);
        pixels += side * side;
    }
    return pixels / TIMED;
}

static int print_times(void)
{
    static const struct timed timed[] = {
        {WHOLE, 0, GREY}, {WHOLE, 0, COLOUR}, {BETWEEN, 0, GREY},
        {BETWEEN, 0, COLOUR}, {BETWEEN, 160, GREY}, {BETWEEN, 240, GREY},
        {BETWEEN, 248, GREY},
    };
    for (size_t i = 0; i < sizeof timed / sizeof timed[0]; i++) {
        const struct timed *t = &timed[i];
        const struct row r = {TIMED_W, TIMED_H, TIMED, t->where, 1, t->reach,
                              512, 512, 256, 256, t->shape, {0}, false};
        struct scene s = make_scene(&r);
        struct gp_tiles *state = NULL;
        struct gp_gl *gl;
        double pixels = lay_out(&s, t);
        double quads = t->reach ? NAN : time_quads(&s.kernel, &s.layer);
        double start = gp_now_ms();
        if (gp_gl_open(&log_kept, GP_GL_AUTO, &gl) != GP_OK)
            return 77;
        double frame = time_tiles(gl, &s, 1, &state);
        double first = gp_now_ms() - start - 3 * frame;
        double ms = (time_tiles(gl, &s, TIMED, &state) - frame) / (TIMED - 1);
        printf("%s, %s, %.0f pixels: %.4f ms a polygon, %.3f of 512x512 "
               "(blended %.3f); frame %.2f ms, the first %.0f\n",
               t->where == WHOLE ? "whole" : "between",
               t->shape == GREY ? "grey" : "coloured", pixels, ms,
               ms / pixels * 512 * 512, quads / TIMED, frame, first);
        gp_tiles_free(gl, &state);
        gp_gl_close(&gl);
        free_scene(&s);
    }
    return 0;
}

SUITE(tile)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(osmesa_equals_the_sum),
        cmocka_unit_test(egl_equals_the_sum),
        cmocka_unit_test(small_fields_equal_the_sum),
        cmocka_unit_test(over_the_limit_fails_with_words),
    };
    if (argc > 1 && strcmp(argv[1], "--time") == 0)
        return print_times();
    if (getenv("GLAREPP_TEST_QUICK")) { // Mesa's compiler crawls in valgrind
        puts("1..0 # skipped: too long for GLAREPP_TEST_QUICK");
        return 0;
    }
    return cmocka_run_group_tests(tests, NULL, NULL);
}
