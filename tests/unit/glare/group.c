// SPDX-License-Identifier: Apache-2.0
/* glare/splat/group.c: formula (1), clusters, blurs; and that what is drawn of
 * a group is what was meant. */
#include "unit.h"
#include "core/memory.h"
#include "glare/splat/splat_priv.h"
#include "glare_scene.h"
#include "plain_groups.h"

/* Takes the frame. */
static struct gp_sources sources_of(struct gp_image f,
                                    const struct glarepp_sense_params *p)
{
    struct gp_sources s;
    assert_ok(gp_sense(NULL, p, false, &f, &s));
    gp_image_free(&f);
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
    struct gp_image f = scene_frame(w, h, 0, 0, BLACK, 1u);
    for (int c = 0; c < 3; c++)
        memcpy(f.rgb.c[c], grey, (size_t) (w * h) * sizeof *grey);
    return sources_of(f, &open_all);
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
        gp_free(q.at);
        gp_sources_free(&s);
    }
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
    gp_free(q.at);
    gp_sources_free(&s);
}

SUITE_OF(group, NULL, NULL, all_as_the_naive_form,
         light_without_luminance_is_kept)

