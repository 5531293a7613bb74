/* glare/splat/group.c: formula (1), clusters, blurs; and that what is drawn of
 * a group is what was meant. */
#include "unit.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "plain_groups.h"

/* Takes the frame. */
static struct gp_sources sources_of(struct gp_frame f,
                                    const struct gp_sensor_params *p)
{
    struct gp_sources s;
    assert_ok(gp_sense(NULL, p, &f, &s));
    gp_frame_free(&f);
    return s;
}

static struct gp_polygons group(const struct gp_sources *s,
                                const struct gp_splat_params *p)
{
    struct gp_polygons q;
    assert_ok(gp_polygons_make(NULL, s, p, &q));
    assert_int_equal(q.n, q.groups + q.clusters);
    return q;
}

/* The variance that drawing `q` by bilinear samples of a box gives it, in
 * pixels^2. */
static double spread_of(int box, const struct gp_polygon *q)
{
    double f[2] = {(double) q->x - (box - 1) / 2.0,
                   (double) q->y - (box - 1) / 2.0};
    double sum = (box * box - 1) / 12.0;
    for (int i = 0; i < 2; i++) {
        f[i] -= floor(f[i]);
        sum += f[i] * (1.0 - f[i]) / 2.0;
    }
    return sum;
}

/* Sources of a frame of w x h grey pixels. */
static struct gp_sources grey_sources(int w, int h, const float *grey)
{
    struct gp_frame f = scene_frame(w, h, 0, 0, BLACK, 1u);
    for (int c = 0; c < 3; c++)
        memcpy(f.rgb.c[c], grey, (size_t) (w * h) * sizeof *grey);
    return sources_of(f, &open_all);
}

/* -- formula (1) ------------------------------------------------------------*/

static void formula_by_hand(void **state)
{
    // two blocks of 2x2; the second holds one pixel
    static const float grey[] = {1, 3, 0, 0,
                                 0, 4, 0, 5};
    struct gp_sources s = grey_sources(4, 2, grey);
    const struct gp_splat_params p = {.group = 2};
    struct gp_polygons q = group(&s, &p);
    assert_int_equal(q.groups, 2);
    assert_true(fabsf(q.at[0].light - 8.0f) < 1e-6f);
    assert_true(fabsf(q.at[0].rgb[1] - 8.0f) < 1e-6f);
    assert_true(fabsf(q.at[0].x - 7.0f / 8.0f) < 1e-6f);
    assert_true(fabsf(q.at[0].y - 4.0f / 8.0f) < 1e-6f);
    assert_true(q.at[1].x == 3.0f && q.at[1].y == 1.0f);
    assert_int_equal(q.at[1].blur, 0);
    gp_polygons_free(&q);
    gp_sources_free(&s);
}

/* -- the naive form ---------------------------------------------------------*/

/* Block of side `side` that holds v, in EXR pixel space. */
static int block_of(int v, int side)
{
    return (int) floor((double) v / side);
}

struct naive {
    double light, x, y, square, rgb[3];
    int sources, area;
};

/* The block (bx, by) of EXR pixel space, looking at every source. */
static struct naive naive_block(const struct gp_sources *s, int bx, int by,
                                int side)
{
    struct naive n = {0};
    for (int y = 0; y < s->h; y++) {
        for (int x = 0; x < s->w; x++)
            n.area += block_of(x + s->x0, side) == bx &&
                      block_of(y + s->y0, side) == by;
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            const int x = s->x[i];
            if (block_of(x + s->x0, side) != bx ||
                block_of(y + s->y0, side) != by)
                continue;
            double light = 0.0;
            for (int c = 0; c < 3; c++) {
                n.rgb[c] += (double) s->rgb[c][i];
                light += (double) s->luminance[c] * (double) s->rgb[c][i];
            }
            n.light += light;
            n.x += light * x;
            n.y += light * y;
            n.square += light * (x * x + y * y);
            n.sources++;
        }
    }
    n.x /= n.light;
    n.y /= n.light;
    n.square = (n.square / n.light - n.x * n.x - n.y * n.y) / 2.0;
    return n;
}

static int naive_filled(const struct naive *n, const struct gp_splat_params *p)
{
    return (float) n->sources >= p->cluster_fill * (float) n->area;
}

static void check_polygon(const struct gp_polygon *q, const struct naive *n,
                          int side, const struct gp_splat_params *p)
{
    const double span = 1e-6 * (1.0 + fabs(n->x) + fabs(n->y));
    assert_int_equal(q->side, side);
    assert_true(fabs((double) q->light - n->light) <= 1e-6 * n->light);
    assert_true(fabs((double) q->x - n->x) <= span);
    assert_true(fabs((double) q->y - n->y) <= span);
    for (int c = 0; c < 3; c++)
        assert_true(fabs((double) q->rgb[c] - n->rgb[c]) <= 1e-6 * n->rgb[c]);
    const double off = fabs(spread_of(gp_blur_box[q->blur], q) - n->square);
    assert_true(gp_blur_box[q->blur] <= side);
    for (int b = 0; b < GP_BLURS && gp_blur_box[b] <= side; b++)
        assert_true(off <= fabs(spread_of(gp_blur_box[b], q) - n->square) +
                               1e-3);
}

/* Every block of that side in row order; those in filled areas are left out
 * unless they are these areas. Returns how many polygons it saw. */
static size_t check_blocks(const struct gp_sources *s,
    const struct gp_splat_params *p, int side, const struct gp_polygon *at)
{
    size_t n = 0;
    for (int by = block_of(s->y0, side); by * side < s->y0 + s->h; by++) {
        for (int bx = block_of(s->x0, side); bx * side < s->x0 + s->w; bx++) {
            const struct naive b = naive_block(s, bx, by, side);
            if (!b.sources || (side == p->cluster && !naive_filled(&b, p)))
                continue;
            if (side != p->cluster && p->cluster) {
                const struct naive c =
                    naive_block(s, block_of(bx * side, p->cluster),
                                block_of(by * side, p->cluster), p->cluster);
                if (naive_filled(&c, p))
                    continue;
            }
            check_polygon(&at[n++], &b, side, p);
        }
    }
    return n;
}

struct naive_row {
    int w, h, x0, y0;
    enum light light;
    struct gp_splat_params p;
};

#define FILLED .cluster_fill = 0.9f
static const struct naive_row naive_rows[] = {
    {1, 1, 0, 0, ALL, {.group = 4, .cluster = 8, FILLED}},
    {1, 1, -1, -1, ALL, {.group = 1, .cluster = 2, FILLED}},
    {1, 33, 3, -7, ALL, {.group = 8, .cluster = 16, FILLED}},
    {40, 24, 0, 0, FEW, {.group = 4, FILLED}},
    {41, 23, -5, 3, FEW, {.group = 4, .cluster = 8, FILLED}},
    {41, 23, 1000003, -77, FEW, {.group = 8, .cluster = 64, FILLED}},
    {67, 45, -1001, -13, BLOCK, {.group = 2, .cluster = 8, FILLED}},
    {67, 45, -1001, -13, BLOCK, {.group = 4, .cluster = 16, FILLED}},
    {67, 45, 7, 9, BLOCK, {.group = 1, .cluster = 8, FILLED}},
    {67, 45, 7, 9, BLOCK, {.group = 1, FILLED}},
    {39, 31, 2, 2, ALL, {.group = 16, .cluster = 32, FILLED}},
    {39, 31, -2, -2, ALL, {.group = 64, FILLED}},
    {39, 31, 0, 0, DARK, {.group = 4, .cluster = 8, FILLED}},
    {53, 37, 1, 1, COLOURED, {.group = 8, FILLED}},
    {53, 37, -3, 1, RAMP, {.group = 4, .cluster = 8, FILLED}},
    {53, 37, -3, 1, RAMP, {.group = 4, .cluster = 8, .cluster_fill = 0.25f}},
    {16384, 2, -9, 0, CORNERS, {.group = 4, .cluster = 8, FILLED}},
};

static void all_as_the_naive_form(void **state)
{
    for (size_t i = 0; i < COUNT(naive_rows); i++) {
        const struct naive_row *const r = &naive_rows[i];
        if (r->w > 1000 && getenv("GLAREPP_TEST_QUICK"))
            continue;
        struct gp_sources s = sources_of(
            scene_frame(r->w, r->h, r->x0, r->y0, r->light, 7u), &usual);
        struct gp_polygons q = group(&s, &r->p);
        size_t clusters = 0;
        if (r->p.cluster)
            clusters = check_blocks(&s, &r->p, r->p.cluster, q.at);
        const size_t groups =
            check_blocks(&s, &r->p, r->p.group, q.at + q.clusters);
        if (clusters != q.clusters || groups != q.groups)
            fail_msg("row %zu: %zu clusters and %zu groups in place of %zu "
                     "and %zu", i, q.clusters, q.groups, clusters, groups);
        gp_polygons_free(&q);
        gp_sources_free(&s);
    }
}

/* -- clusters ---------------------------------------------------------------*/

/* An area of w x h pixels of which `bright` are bright: one polygon or not. */
static size_t clusters_of(int w, int h, int bright, float fill)
{
    float grey[64] = {0};
    for (int i = 0; i < bright; i++)
        grey[i] = 2.0f;
    struct gp_sources s = grey_sources(w, h, grey);
    struct gp_polygons q = group(&s, &(struct gp_splat_params) {
        .group = 4, .cluster = 8, .cluster_fill = fill});
    const size_t n = q.clusters;
    gp_polygons_free(&q);
    gp_sources_free(&s);
    return n;
}

static void clusters_from_the_fill_on(void **state)
{
    static const struct {
        int w, h, bright;
        float fill;
        size_t clusters;
    } rows[] = {
        {8, 8, 58, 0.9f, 1}, {8, 8, 57, 0.9f, 0}, // 57.6
        {5, 2, 9, 0.9f, 1},  {5, 2, 8, 0.9f, 0},  // cut by the window: 9
        {5, 2, 6, 0.6f, 1}, {5, 2, 5, 0.6f, 0},
        {8, 8, 64, 1.0f, 1}, {8, 8, 63, 1.0f, 0},
        {8, 8, 1, 1e-6f, 1}, {8, 8, 0, 1e-6f, 0}, {1, 1, 1, 0.9f, 1},
    };
    for (size_t i = 0; i < COUNT(rows); i++)
        assert_int_equal(clusters_of(rows[i].w, rows[i].h, rows[i].bright,
            rows[i].fill), rows[i].clusters);
}

/* -- laws -------------------------------------------------------------------*/

/* Light without luminance, of unreal primaries, stands in its cell's middle. */
static void light_without_luminance_is_kept(void **state)
{
    static const float grey[] = {1, 2, 0, 0};
    struct gp_sources s = grey_sources(2, 2, grey);
    s.luminance[0] = s.luminance[1] = s.luminance[2] = 0.0f;
    struct gp_polygons q = group(&s, &(struct gp_splat_params) {
        .group = 2});
    assert_int_equal(q.n, 1);
    assert_true(q.at[0].x == 0.5f && q.at[0].y == 0.5f);
    assert_true(q.at[0].light == 0.0f && q.at[0].rgb[0] == 3.0f);
    gp_polygons_free(&q);
    gp_sources_free(&s);
}

/* Light over the range of float stays finite. */
static void too_much_light_stays_finite(void **state)
{
    static const float grey[] = {1, 1, 1, 1};
    struct gp_sources s = grey_sources(2, 2, grey);
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < s.n; i++)
            s.rgb[c][i] = FLT_MAX;
    }
    struct gp_polygons q = group(&s, &(struct gp_splat_params) {.group = 2});
    assert_true(isfinite(q.at[0].light) && isfinite(q.at[0].rgb[0]));
    assert_true(q.at[0].x == 0.5f && q.at[0].y == 0.5f);
    gp_polygons_free(&q);
    gp_sources_free(&s);
}

/* -- the drawing ------------------------------------------------------------*/

static double *draw_reference(
    const struct gp_sources *s, const struct gp_kernel *k,
    const struct gp_splat_params *p, const struct gp_polygons *q)
{
    double *const layer =
        scene_alloc(3 * (size_t) s->w * (size_t) s->h, sizeof *layer);
    struct gp_shrink shrink;
    assert_ok(gp_shrink_make(NULL, k, p, q, &shrink));
    plain_groups(s, k, p, q, &shrink, layer);
    return layer;
}

/* A point's polygon has its light, its centroid and the spread claimed. */
static void moments_are_kept(void **state)
{
    struct gp_kernel point = scene_kernel(1, 1, MID, 0, BOX);
    struct gp_sources s = sources_of(scene_frame(96, 96, 0, 0, CORNERS, 1u),
                                     &usual);
    for (int blur = 0; blur < GP_BLURS; blur++) {
        struct gp_polygon at = {
            .x = 47.3125f, .y = 46.75f, .rgb = {2, 2, 2}, .light = 2,
            .side = 64, .blur = (uint8_t) blur,
        };
        const struct gp_polygons q = {1, 1, 0, &at};
        const struct gp_splat_params p = {.group = 1}; // the whole kernel
        double *const layer = draw_reference(&s, &point, &p, &q);
        double m0 = 0.0, mx = 0.0, my = 0.0, m2 = 0.0;
        for (int i = 0; i < 96 * 96; i++) {
            const double dx = i % 96 - (double) at.x;
            const double dy = i / 96 - (double) at.y;
            m0 += layer[i];
            mx += layer[i] * dx;
            my += layer[i] * dy;
            m2 += layer[i] * (dx * dx + dy * dy);
        }
        assert_true(fabs(m0 - 2.0) < 1e-6 && fabs(mx) < 1e-5 &&
                    fabs(my) < 1e-5);
        const double want = spread_of(gp_blur_box[blur], &at);
        assert_true(fabs(m2 / m0 / 2.0 - want) < 1e-5 * (1.0 + want));
        free(layer);
    }
    gp_sources_free(&s);
    gp_kernel_free(&point);
}

/* Ungrouped, it is the exact sum, whatever the kernel. */
static void ungrouped_is_exact(void **state)
{
    static const int kernels[][4] = {
        {1, 1, MID, 0}, {9, 9, MID, 0}, {30, 18, MID, 0}, {121, 97, MID, 0},
        {13, 11, -20, 5}, {13, 11, 30, 25}, {13, 11, 1048575, 5},
    };
    for (int i = 0; i < 7; i++) {
        const int *const r = kernels[i];
        struct scene s = scene_make(scene_frame(61, 47, -3, 7, FEW, 5u),
            scene_kernel(r[0], r[1], r[2], r[3], TINTED), &usual);
        const struct gp_splat_params p = GP_SPLAT_EXACT;
        struct gp_polygons q = group(&s.src, &p);
        assert_int_equal(q.n, s.src.n);
        double *const layer = draw_reference(&s.src, &s.k, &p, &q);
        for (size_t k = 0; k < 3 * gp_frame_pixels(&s.f); k++)
            assert_true(fabs(layer[k] - s.exact[k]) <=
                        1e-12 * fabs(s.exact[k]));
        free(layer);
        gp_polygons_free(&q);
        scene_free(&s);
    }
}

/* Pixels beyond the reach get nothing from the tail, those within all. */
static void reach_cuts(void **state)
{
    struct gp_kernel k = scene_kernel(81, 81, MID, 0, PEAK);
    struct gp_sources s = sources_of(scene_frame(96, 96, 0, 0, DARK, 1u),
                                     &usual);
    struct gp_polygon at = {
        .x = 40.5f, .y = 44.0f, .rgb = {1, 1, 1}, .light = 1, .side = 4,
        .blur = 1,
    };
    const struct gp_polygons q = {1, 1, 0, &at};
    const struct gp_splat_params p = {.group = 1}; // the whole kernel
    double *const whole = draw_reference(&s, &k, &p, &q);
    double *const cut = scene_alloc(3 * 96 * 96, sizeof *cut);
    struct gp_shrink shrink = {.reach = {0}};
    shrink.reach[gp_source_bin(1.0f)] = 10;
    plain_groups(&s, &k, &p, &q, &shrink, cut);
    for (int i = 0; i < 3 * 96 * 96; i++) {
        const double dx = i % 96 - 40.5, dy = i / 96 % 96 - 44.0;
        const int inside = fabs(dx) <= 10.0 && fabs(dy) <= 10.0;
        assert_true(cut[i] == (inside ? whole[i] : 0.0));
        assert_true(!inside || cut[i] > 0.0);
    }
    free(whole);
    free(cut);
    gp_sources_free(&s);
    gp_kernel_free(&k);
}

SUITE_OF(group, NULL, NULL,
    formula_by_hand, all_as_the_naive_form, clusters_from_the_fill_on,
    light_without_luminance_is_kept, too_much_light_stays_finite,
    moments_are_kept, ungrouped_is_exact, reach_cuts)
