/* The passes that group and cluster on GL against gp_polygons_make(), cell by
 * cell. */
#include "unit.h"
#include "splat_scene.h"

/* -- the passes ------------------------------------------------------------ */

struct pass {
    int w, h, x0, y0; // data window: size and corner
    enum light light;
    int group, cluster;
    float fill;
};

static const struct pass passes[] = {
    {1, 1, 0, 0, ALL, 1, 0, 1}, {1, 1, -7, 5, ALL, 4, 8, 1},
    {1, 1, 3, 3, ALL, 64, 0, 1}, {64, 48, 0, 0, MANY, 1, 0, 1},
    {64, 48, 0, 0, MANY, 2, 0, 1}, {64, 48, 0, 0, MANY, 4, 0, 1},
    {64, 48, 0, 0, MANY, 8, 0, 1}, {64, 48, 0, 0, MANY, 16, 0, 1},
    {61, 47, 0, 0, MANY, 4, 0, 1},      // N divides neither side
    {61, 47, -13, -30, MANY, 4, 0, 1}, {61, 47, -1, 1, MANY, 8, 0, 1},
    {61, 47, 2147483000, -2147483000, MANY, 16, 0, 1},
    {130, 3, 5, -2, FEW, 2, 4, 0.25f},
    {64, 64, 0, 0, ALL, 4, 8, 0.9f},  // all clusters
    {67, 59, -3, -5, ALL, 4, 8, 1.0f},
    {67, 59, -3, -5, MANY, 4, 8, 0.3f}, // some
    {67, 59, 3, 5, MANY, 1, 8, 0.3f},
    {67, 59, 3, 5, MANY, 1, 2, 0.5f},   // shares that lie on the limit
    {67, 59, 3, 5, MANY, 2, 4, 0.25f}, {67, 59, 3, 5, MANY, 2, 64, 0.1f},
    {61, 67, 0, 0, HOT, 8, 0, 1}, {61, 67, 0, 0, HOT, 8, 32, 0.01f},
    {50, 50, 1, 0, EQUAL, 16, 64, 1}, {50, 50, 1, 0, EQUAL, 64, 0, 1},
    {40, 30, 0, 0, CORNERS, 4, 8, 0.9f}, {40, 30, 2, 0, FAINT, 4, 8, 0.9f},
};
enum { PASSES = COUNT(passes) };

struct cells {
    struct gp_cells grid;
    float *light, *place; // 4 a cell
};

static struct cells read_cells(struct gp_splat *s, struct gp_cells grid,
                               const struct gp_target *t)
{
    const struct gp_rect all = {0, 0, grid.w, grid.h};
    const size_t n = (size_t) grid.w * (size_t) grid.h;
    struct cells c = {grid, malloc(n * 16), malloc(n * 16)};
    gp_target_read(s->gl, t, 0, all, c.light);
    gp_target_read(s->gl, t, 1, all, c.place);
    return c;
}

static void free_cells(struct cells *c)
{
    free(c->light);
    free(c->place);
}

static size_t count_open(const struct cells *c)
{
    size_t open = 0;
    for (int i = 0; i < c->grid.w * c->grid.h; i++)
        open += c->light[4 * i] > 0.0f || c->light[4 * i + 1] > 0.0f ||
                c->light[4 * i + 2] > 0.0f;
    return open;
}

/* Second moment on one axis of a box and of bilinear sampling at x. */
static double moment(int side, double x)
{
    const double at = x - 0.5 * (side - 1), f = at - floor(at);
    return (side * side - 1) / 12.0 + f * (1.0 - f);
}

/* Blurs may differ only where both boxes miss the spread by as much. */
static bool is_tie(const struct gp_sources *src, const struct gp_polygon *p,
                   const struct gp_cells *grid, int cell, int other)
{
    const int x0 = grid->x + cell % grid->w * grid->side;
    const int y0 = grid->y + cell / grid->w * grid->side;
    double sum = 0.0, spread = 0.0, off[2];
    for (int y = y0 < 0 ? 0 : y0; y < y0 + grid->side && y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const double dx = src->x[i] - (double) p->x, dy = y - (double) p->y;
            if (src->x[i] < x0 || src->x[i] >= x0 + grid->side)
                continue;
            double l = 0.0;
            for (int c = 0; c < 3; c++)
                l += (double) src->luminance[c] * (double) src->rgb[c][i];
            sum += l;
            spread += l * (dx * dx + dy * dy) / 2.0;
        }
    }
    for (int i = 0; i < 2; i++) {
        const int side = gp_blur_box[i ? other : p->blur];
        off[i] = fabs((moment(side, (double) p->x) +
                       moment(side, (double) p->y)) / 2.0 - spread / sum);
    }
    return fabs(off[0] - off[1]) <= 2e-3 * (1.0 + spread / sum);
}

static void check_cell(int row, const struct gp_sources *src,
                       const struct gp_polygon *p, const struct cells *c)
{
    const struct gp_cells *const g = &c->grid;
    const int at = ((int) floorf(p->y) - g->y) / g->side * g->w +
                   ((int) floorf(p->x) - g->x) / g->side;
    const float *const light = c->light + 4 * at, *const place = c->place +
                                                                 4 * at;
    for (int k = 0; k < 4; k++) {
        const double want = k < 3 ? (double) p->rgb[k] : (double) p->light;
        if (!(fabs((double) light[k] - want) <= 4e-6 * want))
            fail_msg("row %d, cell %d: light %d is %g, not %g", row, at, k,
                     (double) light[k], want);
    }
    const double dx = g->x + at % g->w * g->side + (double) place[0] -
                      (double) p->x;
    const double dy = g->y + at / g->w * g->side + (double) place[1] -
                      (double) p->y;
    if (!(fabs(dx) <= 8e-6 && fabs(dy) <= 8e-6))
        fail_msg("row %d, cell %d: P0 is off by %g, %g", row, at, dx, dy);
    if ((int) place[2] != p->blur && !is_tie(src, p, g, at, (int) place[2]))
        fail_msg("row %d, cell %d: blur %g, not %d", row, at,
                 (double) place[2], p->blur);
}

static void run_pass(const struct pass *p, struct gp_splat *s)
{
    const int row = (int) (p - passes);
    struct gp_frame f =
        scene_frame(p->w, p->h, p->x0, p->y0, p->light, 91u + (uint32_t) row);
    struct gp_sources src;
    assert_ok(gp_sense(NULL, p->light == FAINT || p->light == HOT
                                 ? &open_all : &usual, &f, &src));
    struct gp_splat_params params = GP_SPLAT_EXACT;
    params.group = p->group;
    params.cluster = p->cluster;
    params.cluster_fill = p->fill;
    struct gp_polygons want;
    assert_ok(gp_polygons_make(&kept_log, &src, &params, &want));

    const struct gp_rect frame = {0, 0, p->w, p->h};
    const int span = p->cluster ? p->cluster : p->group;
    const struct gp_cells coarse = gp_cells_over(&src, frame, span);
    const struct gp_cells fine = {p->group, coarse.x, coarse.y,
                                  coarse.w * (span / p->group),
                                  coarse.h * (span / p->group)};
    assert_ok(gp_splat_upload(&kept_log, s, &src, frame));
    struct cells clusters = {0};
    if (p->cluster) {
        assert_ok(gp_splat_group(&kept_log, s, frame, &coarse, ~0u, p->fill,
                                 NULL, &s->clusters));
        clusters = read_cells(s, coarse, &s->clusters);
    }
    assert_ok(gp_splat_group(&kept_log, s, frame, &fine, ~0u, 0.0f,
        p->cluster ? &(struct gp_splat_parents) {&s->clusters, p->cluster}
                   : NULL, &s->groups));
    struct cells groups = read_cells(s, fine, &s->groups);
    assert_int_equal(count_open(&clusters), want.clusters);
    assert_int_equal(count_open(&groups), want.groups);
    for (size_t i = 0; i < want.n; i++)
        check_cell(row, &src, &want.at[i],
                   i < want.clusters ? &clusters : &groups);
    free_cells(&clusters);
    free_cells(&groups);
    gp_polygons_free(&want);
    gp_sources_free(&src);
    gp_frame_free(&f);
}

static void passes_equal_the_cpu(void **state)
{
    void *kept = open_or_skip(GP_GL_AUTO);
    // Mesa's compiler crawls in valgrind
    const int n = getenv("GLAREPP_TEST_QUICK") ? 8 : PASSES;
    for (int i = 0; i < n; i++)
        run_pass(&passes[i], kept);
    gp_engine_splat.close(&kept);
}

SUITE_OF(splat_group, NULL, NULL, passes_equal_the_cpu)
