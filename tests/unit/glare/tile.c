/* Polygons gathered per tile against a plain double sum: sizes, kernels,
 * blurs, cuts, fields, limits, and the roundings they promise; and what a layer
 * does not depend on: batches, and what was drawn before. */
#include "unit.h"
#include "gl_open.h"
#include "glare/splat/splat_priv.h"

#include <limits.h>

/* -- scenes ---------------------------------------------------------------- */

static uint32_t seed;

static float uniform(void)
{
    seed = seed * 1664525u + 1013904223u;
    return (float) (seed >> 8) * 0x1p-24f;
}

enum shape { GREY, COLOUR, LOBES, BOX };

static struct gp_kernel make_kernel(int w, int h, int cx, int cy,
                                           enum shape shape)
{
    static unsigned long serial;
    struct gp_kernel k = {.w = w, .h = h, .cx = cx, .cy = cy,
                          .grey = shape != COLOUR, .serial = ++serial};
    if (gp_planes_make(NULL, "kernel", (size_t) w * (size_t) h, &k.k))
        abort();
    for (int i = 0; i < w * h; i++) {
        double dx = i % w - w / 2, dy = i / w - h / 2;
        for (int c = 0; c < 3; c++) {
            double fall = shape == COLOUR ? 0.1 * (c + 1) : 0.2;
            double v = 1.0 / (1.0 + fall * (dx * dx + dy * dy));
            k.k.c[c][i] = (float) (shape == BOX ? 0.1 : shape == LOBES
                                   ? v * cos(0.7 * dx) * cos(0.4 * dy) : v);
        }
    }
    return k;
}

enum where { WHOLE, BETWEEN, MIXED }; // on pixels, between them, both

struct row {
    int w, h, n;
    enum where where;
    int blurs;  // polygons take blurs 0 to blurs - 1
    int reach;  // by bins from this one on; 0 draws all
    int kw, kh, cx, cy;
    enum shape shape;
    struct gp_rect crop; // of the kernel; empty: all
    bool tail;
};

struct scene {
    int w, h;
    struct gp_kernel kernel;
    struct gp_rect crop;
    bool tail;
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    struct gp_planes layer;
};

static float place(enum where where, int i, int size)
{
    float at = uniform() * (float) (size - 1);
    return where == WHOLE || (where == MIXED && i % 2) ? floorf(at) : at;
}

static struct scene make_scene(const struct row *r)
{
    struct scene s = {.w = r->w, .h = r->h, .crop = r->crop, .tail = r->tail};
    s.kernel = make_kernel(r->kw, r->kh, r->cx, r->cy, r->shape);
    if (gp_rect_empty(s.crop))
        s.crop = (struct gp_rect) {0, 0, r->kw, r->kh};
    s.polygons.n = (size_t) r->n;
    s.polygons.at = calloc((size_t) r->n + 1, sizeof *s.polygons.at);
    for (int i = 0; i < r->n; i++) {
        struct gp_polygon *g = &s.polygons.at[i];
        g->x = place(r->where, i, r->w);
        g->y = place(r->where, i, r->h);
        g->blur = (uint8_t) (i % r->blurs);
        for (int c = 0; c < 3; c++)
            g->rgb[c] = i % 11 == c ? 0.0f : i % 5 == 0
                        ? 65504.0f * uniform() : 1.0f + uniform();
        g->light = (g->rgb[0] + g->rgb[1] + g->rgb[2]) / 3.0f;
    }
    for (int b = 0; b < GP_SOURCE_BINS; b++) // up to 50 pixels for 65504
        s.shrink.reach[b] = r->reach ? (b > r->reach ? b - r->reach : 0)
                                     : INT_MAX / 2;
    size_t samples = (size_t) r->w * (size_t) r->h;
    if (gp_planes_make(NULL, "layer", samples, &s.layer))
        abort();
    for (int c = 0; c < 3; c++) // every sample must be written
        memset(s.layer.c[c], 0xff, samples * sizeof(float));
    return s;
}

static void free_scene(struct scene *s)
{
    gp_planes_free(&s->kernel.k);
    gp_planes_free(&s->layer);
    free(s->polygons.at);
}

static gp_status draw(struct gp_gl *gl, struct scene *s,
                             struct gp_tiles **state, double *roundings)
{
    return gp_tiles_draw(&log_kept, gl, &s->kernel, s->crop, s->tail,
        &s->polygons, &s->shrink, s->w, s->h, &s->layer, state, roundings);
}

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
                assert_ok(gp_blur_make(NULL, &s->kernel, s->crop, s->tail,
                                       gp_blur_box[blur], &b));
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
    for (int i = 0; i < (int) COUNT(rows); i++)
        run_row(gl, &rows[i], &state, i);
    gp_tiles_free(gl, &state);
    assert_null(state);
    gp_tiles_free(gl, &state);
    assert_ok(gp_gl_check(&log_kept, gl, "test"));
    gp_gl_close(&gl);
}

static void osmesa_equals_the_sum(void **state)
{
    rows_equal_the_sum(GP_GL_OSMESA);
}

static void egl_equals_the_sum(void **state)
{
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
    for (size_t i = 0; i < COUNT(small); i++) {
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
    struct gp_tile_batch batch = {0};
    batch.texel = malloc((size_t) GP_TILE_TEXELS * 4 * sizeof(float));
    for (size_t i = 0; i < COUNT(sizes); i++) {
        struct scene s = make_scene(&sizes[i]);
        struct gp_tile_pieces p;
        size_t next = 0, batches = 0;
        assert_ok(gp_tile_pieces_make(&log_kept, &s.kernel, s.crop, &s.polygons,
                                      &s.shrink, s.w, s.h, &p));
        batch.field = (struct gp_rect) {0, 0, s.w, s.h};
        batch.side = gp_tile_side(&p, 1, batch.field);
        assert_true(batch.side >= 4 && batch.side <= 6);
        for (; next < p.first[2]; batches++) {
            gp_tile_batch_enter(&s.polygons, &p, 1, &next, &batch);
            assert_true(batch.texels <= GP_TILE_TEXELS && batch.most > 0);
        }
        assert_true(batches <= 1 + s.polygons.n / GP_TILE_BATCH);
        gp_tile_pieces_free(&p);
        free_scene(&s);
    }
    free(batch.texel);
}

/* Lists that do not fit one batch: every tile of the field for each of more
 * polygons than the least of a batch. */
static void batches_equal_the_sum(void **state)
{
    enum { SIDE = 1024, N = 1300 };
    static const struct row row = {SIDE, SIDE, N, WHOLE, 1, 0, 1, 1, 0, 0,
                                   GREY, {0}, false};
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_tiles *kept = NULL;
    double roundings;
    seed = 5u;
    struct scene s = make_scene(&row);
    gp_planes_free(&s.kernel.k); // one value everywhere, as far as it goes
    s.kernel = make_kernel(2 * SIDE, 2 * SIDE, SIDE, SIDE, BOX);
    s.crop = (struct gp_rect) {0, 0, 2 * SIDE, 2 * SIDE};
    assert_ok(draw(gl, &s, &kept, &roundings));
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
        assert_ok(draw(gl, &a, &kept, &roundings));
        assert_ok(draw(gl, &b, &fresh, &roundings));
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

SUITE(tile)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(osmesa_equals_the_sum),
        cmocka_unit_test(egl_equals_the_sum),
        cmocka_unit_test(small_fields_equal_the_sum),
        cmocka_unit_test(over_the_limit_fails_with_words),
        cmocka_unit_test(batches_are_large),
        cmocka_unit_test(batches_equal_the_sum),
        cmocka_unit_test(no_stale_kernel),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
