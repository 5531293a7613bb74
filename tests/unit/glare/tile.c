/* Polygons gathered per tile against a plain double sum: sizes, kernels,
 * blurs, cuts, fields, limits, and the roundings they promise; and what a layer
 * does not depend on: batches, and what was drawn before. */
#include "unit.h"
#include "splat_scene.h"

/* -- scenes ---------------------------------------------------------------- */

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

struct gathered {
    struct scene s; // its kernel and layer
    struct gp_rect crop;
    bool tail;
    struct gp_polygons polygons;
    struct gp_shrink shrink;
};

static float place_of(enum where where, int i, int size, uint32_t *seed)
{
    const float at = scene_random(seed) * (float) (size - 1);
    return where == WHOLE || (where == MIXED && i % 2) ? floorf(at) : at;
}

static struct gathered gather(const struct row *r, uint32_t seed)
{
    struct gathered g = {.crop = r->crop, .tail = r->tail};
    g.s.f = scene_frame(r->w, r->h, 0, 0, BLACK, seed);
    g.s.k = splat_kernel(r->kw, r->kh, r->cx, r->cy, r->shape);
    if (gp_rect_empty(g.crop))
        g.crop = (struct gp_rect) {0, 0, r->kw, r->kh};
    g.polygons.n = (size_t) r->n;
    g.polygons.at = scene_alloc((size_t) r->n, sizeof *g.polygons.at);
    for (int i = 0; i < r->n; i++) {
        struct gp_polygon *const q = &g.polygons.at[i];
        q->x = place_of(r->where, i, r->w, &seed);
        q->y = place_of(r->where, i, r->h, &seed);
        q->blur = (uint8_t) (i % r->blurs);
        for (int c = 0; c < 3; c++)
            q->rgb[c] = i % 11 == c ? 0.0f : i % 5 == 0
                        ? 65504.0f * scene_random(&seed)
                        : 1.0f + scene_random(&seed);
        q->light = (q->rgb[0] + q->rgb[1] + q->rgb[2]) / 3.0f;
    }
    for (int b = 0; b < GP_SOURCE_BINS; b++) // up to 50 pixels for 65504
        g.shrink.reach[b] = r->reach ? (b > r->reach ? b - r->reach : 0)
                                     : INT_MAX / 2;
    return g;
}

static void free_gathered(struct gathered *g)
{
    free(g->polygons.at);
    scene_free(&g->s);
}

static gp_status draw_tiles(struct gp_splat *to, struct gathered *g,
                            struct gp_tiles **tiles, double *roundings)
{
    scene_clear_layer(&g->s);
    return gp_tiles_draw(&kept_log, to->gl, &(struct gp_tiles_light) {
        &g->s.k, g->crop, g->tail, &g->polygons, &g->shrink,
        gp_frame_w(&g->s.f), gp_frame_h(&g->s.f)}, &g->s.f.layer, tiles,
        roundings);
}

/* -- the sum --------------------------------------------------------------- */

static double sample(const struct gp_blur *b, int c, double x, double y)
{
    return x < 0 || y < 0 || x >= b->w || y >= b->h
               ? 0.0 : (double) b->k.c[c][(size_t) y * (size_t) b->w +
                                          (size_t) x];
}

struct sums {
    double sum, size, slack; // the sum; of magnitudes; where positions are
                             // rounded
};

/* One polygon on one channel. */
static void add_polygon(const struct gathered *g, const struct gp_blur *b,
                        const struct gp_polygon *q, int c, struct sums *out)
{
    const int reach = g->shrink.reach[gp_source_bin(q->light)];
    const int w = gp_frame_w(&g->s.f), h = gp_frame_h(&g->s.f);
    for (int i = 0; i < w * h; i++) {
        const double dx = i % w - (double) q->x, dy = i / w - (double) q->y;
        const double x = dx + (double) b->cx, y = dy + (double) b->cy;
        const double fx = x - floor(x), fy = y - floor(y);
        double biggest = 0.0;
        if (fabs(dx) > reach || fabs(dy) > reach || x <= -1 || y <= -1 ||
            x >= b->w || y >= b->h)
            continue;
        for (int k = 0; k < 4; k++) {
            const double v = sample(b, c, floor(x) + k % 2, floor(y) + k / 2) *
                             (double) q->rgb[c];
            const double share =
                v * (k % 2 ? fx : 1 - fx) * (k / 2 ? fy : 1 - fy);
            out[i].sum += share;
            out[i].size += fabs(share);
            biggest = fmax(biggest, fabs(v));
        }
        if (fx != 0.0 || fy != 0.0)
            out[i].slack += 0x1p-23 * biggest;
    }
}

/* Every pixel of a channel is as near to the sum as the roundings say (those
 * of 1e-38, the smallest normal number, are flushed away). */
static void check_channel(const struct gathered *g, int c, double roundings,
                          int row)
{
    const int w = gp_frame_w(&g->s.f), n = w * gp_frame_h(&g->s.f);
    struct sums *const want = scene_alloc((size_t) n, sizeof *want);
    for (int blur = 0; blur < GP_BLURS; blur++) {
        struct gp_blur b = {0};
        for (size_t i = 0; i < g->polygons.n; i++) {
            if (g->polygons.at[i].blur != blur)
                continue;
            if (b.w == 0)
                assert_ok(gp_blur_make(NULL, &g->s.k, g->crop, g->tail,
                                       gp_blur_box[blur], &b));
            add_polygon(g, &b, &g->polygons.at[i], c, want);
        }
        gp_blur_free(&b);
    }
    for (int i = 0; i < n; i++) {
        const double got = (double) g->s.f.layer.c[c][i];
        const double most =
            roundings * 0x1p-24 * want[i].size + want[i].slack + 1e-36;
        if (!(fabs(got - want[i].sum) <= most))
            fail_msg("row %d, plane %d, pixel (%d, %d): %g, not %g within %g",
                     row, c, i % w, i / w, got, want[i].sum, most);
    }
    free(want);
}

/* -- rows ------------------------------------------------------------------ */

static const struct row rows[] = {
    {1, 1, 1, WHOLE, 1, 0, 1, 1, 0, 0, PEAK, {0}, false},
    {1, 1, 9, MIXED, 10, 0, 9, 7, 4, 3, TINTED, {0}, false},
    {1, 97, 20, MIXED, 3, 0, 33, 33, 16, 16, PEAK, {0}, false},
    {97, 1, 20, MIXED, 3, 0, 33, 33, 16, 16, TINTED, {0}, false},
    {2, 3, 5, BETWEEN, 2, 0, 2, 2, 1, 1, PEAK, {0}, false},
    {40, 30, 0, WHOLE, 1, 0, 9, 9, 4, 4, PEAK, {0}, false},
    {40, 30, 30, WHOLE, 1, 0, 9, 9, 4, 4, PEAK, {0}, false},
    {41, 31, 30, WHOLE, 1, 0, 8, 6, 4, 3, TINTED, {0}, false},
    {42, 33, 30, BETWEEN, 1, 0, 9, 9, 4, 4, PEAK, {0}, false},
    {43, 35, 30, BETWEEN, 1, 0, 8, 6, 4, 3, TINTED, {0}, false},
    {43, 35, 30, BETWEEN, 2, 0, 1, 1, 0, 0, PEAK, {0}, false},
    {70, 67, 40, MIXED, 10, 0, 31, 30, 15, 15, PEAK, {0}, false},
    {70, 67, 40, MIXED, 10, 0, 31, 30, 15, 15, TINTED, {0}, true},
    {70, 67, 40, BETWEEN, 4, 0, 31, 30, 15, 15, LOBES, {0}, false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, PEAK, {0}, false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, PEAK, {60, 40, 140, 110},
     false},
    {40, 30, 15, MIXED, 4, 0, 200, 151, 100, 75, TINTED, {0}, true},
    {64, 64, 20, MIXED, 3, 0, 13, 11, 0, 10, PEAK, {0}, false}, // corner
    {64, 64, 20, MIXED, 3, 0, 13, 11, -20, 31, PEAK, {0}, false}, // outside
    {64, 64, 20, MIXED, 3, 0, 13, 11, 2000, 5, PEAK, {0}, false}, // nowhere
    {64, 64, 20, MIXED, 3, 0, 13, 11, INT_MAX, -INT_MAX, PEAK, {0}, false},
    {130, 70, 60, WHOLE, 1, 255, 61, 63, 30, 31, PEAK, {0}, false}, // cuts
    {130, 70, 60, MIXED, 6, 250, 61, 63, 30, 31, PEAK, {0}, false},
    {130, 70, 60, MIXED, 6, 254, 61, 63, 30, 31, TINTED, {0}, true},
    {130, 70, 60, MIXED, 6, 511, 61, 63, 30, 31, BOX, {0}, false}, // 0 px
    {64, 80, 3000, WHOLE, 1, 0, 24, 25, 12, 12, BOX, {0}, false}, // drift
    {50, 40, 2000, BETWEEN, 2, 0, 96, 96, 48, 48, BOX, {0}, false},
    {4099, 3, 30, MIXED, 3, 0, 65, 5, 32, 2, PEAK, {0}, false}, // fields
    {3, 2051, 30, MIXED, 3, 0, 5, 65, 2, 32, TINTED, {0}, false},
};

static void run_row(struct gp_splat *to, const struct row *r, int row)
{
    struct gathered g = gather(r, 2007u + (uint32_t) row);
    double roundings;
    if (draw_tiles(to, &g, &to->tiles, &roundings) != GP_OK)
        fail_msg("row %d: %s", row, kept_line);
    assert_true(roundings <= gp_tiles_roundings(&g.polygons));
    for (int c = 0; c < 3; c++)
        check_channel(&g, c, roundings, row);
    free_gathered(&g);
}

/* One state for all rows: frames and kernels change size under way. */
static void rows_equal_the_sum(enum gp_gl_api api)
{
    void *state = open_or_skip(api);
    struct gp_splat *const s = state;
    for (int i = 0; i < (int) COUNT(rows); i++)
        run_row(s, &rows[i], i);
    gp_tiles_free(s->gl, &s->tiles);
    assert_null(s->tiles);
    gp_tiles_free(s->gl, &s->tiles);
    assert_ok(gp_gl_check(&kept_log, s->gl, "test"));
    gp_engine_splat.close(&state);
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
        {"16", {131, 67, 40, MIXED, 1, 0, 64, 16, 7, 8, PEAK, {0}, false}},
        {"64", {200, 150, 40, MIXED, 3, 0, 62, 60, 32, 30, TINTED, {0},
                false}},
        {"64", {200, 150, 40, MIXED, 3, 250, 58, 60, 32, 30, PEAK, {0},
                true}},
        {"7", {22, 15, 9, WHOLE, 1, 0, 4, 7, 0, 6, PEAK, {0}, false}},
        {"1", {9, 5, 9, BETWEEN, 1, 0, 1, 1, 0, 0, PEAK, {0}, false}},
    };
    for (size_t i = 0; i < COUNT(small); i++) {
        void *kept = open_small_or_skip(small[i].side);
        run_row(kept, &small[i].row, (int) i);
        gp_engine_splat.close(&kept);
    }
}

static void over_the_limit_fails_with_words(void **state)
{
    static const struct row large = {40, 30, 5, WHOLE, 1, 0, 65, 9, 8, 4,
                                     PEAK, {0}, false};
    static const struct row fits = {40, 30, 5, WHOLE, 1, 0, 16, 16, 8, 4,
                                    TINTED, {0}, false};
    void *kept = open_small_or_skip("16");
    struct gp_splat *const to = kept;
    double roundings;
    struct gathered g = gather(&large, 5u);
    assert_int_equal(draw_tiles(to, &g, &to->tiles, &roundings), GP_ERR_GL);
    assert_kept("kernel: 17x9");
    free_gathered(&g);
    run_row(to, &fits, 0); // the state is whole
    gp_engine_splat.close(&kept);
}

/* -- batches --------------------------------------------------------------- */

/* Batches hold at least GP_TILE_BATCH polygons, whatever side is taken. */
static void batches_are_large(void **state)
{
    static const struct row sizes[] = {
        {1024, 1024, 4000, BETWEEN, 1, 0, 2047, 2047, 1023, 1023, BOX, {0},
         false},
        {1024, 1024, 4000, BETWEEN, 1, 0, 31, 31, 15, 15, PEAK, {0}, false},
        {1024, 1024, 4000, BETWEEN, 1, 210, 2047, 3, 1023, 1, PEAK, {0},
         false},
        {1024, 768, 4000, BETWEEN, 1, 240, 511, 511, 255, 255, PEAK, {0},
         false},
    };
    struct gp_tile_batch batch = {0};
    batch.texel = malloc((size_t) GP_TILE_TEXELS * 4 * sizeof(float));
    for (size_t i = 0; i < COUNT(sizes); i++) {
        struct gathered g = gather(&sizes[i], 5u);
        struct gp_tile_pieces p;
        size_t next = 0, batches = 0;
        assert_ok(gp_tile_pieces_make(&kept_log, &g.s.k, g.crop, &g.polygons,
                                      &g.shrink, sizes[i].w, sizes[i].h, &p));
        batch.field = g.s.f.data;
        batch.side = gp_tile_side(&p, 1, batch.field);
        assert_true(batch.side >= 4 && batch.side <= 6);
        for (; next < p.first[2]; batches++) {
            gp_tile_batch_enter(&g.polygons, &p, 1, &next, &batch);
            assert_true(batch.texels <= GP_TILE_TEXELS && batch.most > 0);
        }
        assert_true(batches <= 1 + g.polygons.n / GP_TILE_BATCH);
        gp_tile_pieces_free(&p);
        free_gathered(&g);
    }
    free(batch.texel);
}

/* Lists that do not fit one batch: every tile of the field for each of more
 * polygons than the least of a batch. */
static void batches_equal_the_sum(void **state)
{
    enum { SIDE = 1024, N = 1300 };
    // one value everywhere, as far as it goes
    static const struct row row = {SIDE, SIDE, N, WHOLE, 1, 0, 2 * SIDE,
                                   2 * SIDE, SIDE, SIDE, BOX, {0}, false};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_splat *const to = kept;
    double roundings;
    struct gathered g = gather(&row, 5u);
    assert_ok(draw_tiles(to, &g, &to->tiles, &roundings));
    assert_true(roundings <= gp_tiles_roundings(&g.polygons));
    for (int c = 0; c < 3; c++) {
        double want = 0.0;
        for (int i = 0; i < N; i++)
            want += (double) (g.s.k.k.c[c][0] * g.polygons.at[i].rgb[c]);
        for (int i = 0; i < SIDE * SIDE; i++) {
            const double error = fabs((double) g.s.f.layer.c[c][i] - want);
            assert_true(error <= roundings * 0x1p-24 * want);
        }
    }
    free_gathered(&g);
    gp_engine_splat.close(&kept);
}

/* One light and many that are each swallowed by the sum so far, in parts as the
 * shader's: every rounding goes the same way. */
static void roundings_are_not_twice_too_many(void **state)
{
    enum { PARTS = 30, N = PARTS * PARTS };
    static const struct row row = {1, 1, N, WHOLE, 1, 0, 1, 1, 0, 0, BOX,
                                   {0}, false};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_splat *const to = kept;
    struct gathered g = gather(&row, 5u);
    double roundings, want = 0.0;
    for (int i = 0; i < N; i++) {
        const float light = i == 0      ? 1.0f
                            : i < PARTS ? 0x1.fffffep-25f
                                        : 0x1.fffffep-25f / (float) PARTS;
        for (int c = 0; c < 3; c++)
            g.polygons.at[i].rgb[c] = light;
        g.polygons.at[i].light = light;
        want += (double) light;
    }
    for (int c = 0; c < 3; c++)
        g.s.k.k.c[c][0] = 1.0f;
    assert_ok(draw_tiles(to, &g, &to->tiles, &roundings));
    const double error = fabs((double) g.s.f.layer.c[1][0] - want) / want;
    const double share = error / (roundings * 0x1p-24);
    const double before = error / (gp_tiles_roundings(&g.polygons) * 0x1p-24);
    print_message("roundings: %.3f of the bound, %.3f of that before\n", share,
                  before);
    assert_true(share > 0.5 && share <= 1.0);
    assert_true(before > 0.5 && before <= share);
    free_gathered(&g);
    gp_engine_splat.close(&kept);
}

/* -- sequences ------------------------------------------------------------- */

/* Kernels, crops and tails that change under one state leave no trace. */
static void no_stale_kernel(void **state)
{
    static const struct row row = {61, 47, 50, MIXED, 4, 252, 33, 35, 16, 17,
                                   PEAK, {0}, false};
    void *kept = open_or_skip(GP_GL_AUTO);
    struct gp_splat *const to = kept;
    for (int i = 0; i < 8; i++) {
        struct gp_tiles *fresh = NULL;
        double roundings;
        struct gathered g = gather(&row, 7u);
        if (i >= 2 && i < 6)
            g.crop.x0 = 3;
        g.tail = i >= 4;
        g.s.k.serial = i < 5 ? 1000000u : 0u;
        for (int c = 0; i >= 5 && c < 3; c++) // the same serial, 0, each time
            g.s.k.k.c[c][40] = (float) i;
        assert_ok(draw_tiles(to, &g, &to->tiles, &roundings));
        const uint64_t hash = scene_hash(&g.s);
        assert_ok(draw_tiles(to, &g, &fresh, &roundings));
        assert_true(scene_hash(&g.s) == hash);
        gp_tiles_free(to->gl, &fresh);
        free_gathered(&g);
    }
    gp_engine_splat.close(&kept);
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
        cmocka_unit_test(roundings_are_not_twice_too_many),
        cmocka_unit_test(no_stale_kernel),
    };
    if (getenv("GLAREPP_TEST_QUICK")) // Mesa's compiler crawls in valgrind
        cmocka_set_test_filter("no_stale_kernel");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
