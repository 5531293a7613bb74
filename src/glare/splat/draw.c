/* Blending adds in float, one polygon after another, so gp_splat_chunk() of
 * them at a time are summed in a target of their own, which is then added to
 * the total. */
#include "glare/splat/draw.h"

#include "glare/splat/group_gl.h"

#include <math.h>
#include <string.h>

enum {
    QUADS = 64,       // of one instance, which costs llvmpipe 0.2 us
    QUAD_VERTICES = 6,
};

/* Cells whose sensors are drawn. */
struct grid {
    struct gp_cells cells;
    const struct gp_texture *sensors, *places; // places NULL: whole pixels
    unsigned blurs;                            // when there are places
    const struct gp_polygon *at; // of the whole frame, in row order of cells
    size_t n;
};

/* -- one draw -------------------------------------------------------------- */

enum { UNIFORMS = 24 }; // room for those of any program here

/* What all programs of polygons have in common. Returns how many. */
static int shared_uniforms(const struct gp_splat_work *k,
                           const struct grid *g, int which, int first, int end,
                           struct gp_rect view, struct gp_uniform *out)
{
    struct gp_splat *const s = k->s;
    const struct gp_splat_kernel *const o = &s->kernel[which];
    const bool shrinks = k->plan->params.shrink > 0.0f &&
                         which != GP_SPLAT_CORE;
    const struct gp_uniform shared[] = {
        {.name = "sensors", .texture = g->sensors},
        {.name = "reaches", .block = &s->reaches},
        {.name = "kernel", .texture = &o->texture},
        {.name = "cells", .v = {g->cells.w, g->cells.h}},
        {.name = "range", .v = {first, end}},
        {.name = "offset", .v = {g->cells.x - k->tile.x0,
                                 g->cells.y - k->tile.y0}},
        {.name = "extent", .v = {o->w, o->h}},
        {.name = "centre", .v = {o->cx, o->cy}},
        {.name = "form", .v = {k->points ? 1 : QUAD_VERTICES, shrinks}},
        {.name = "view", .v = {view.x0, view.y0}},
        {.name = "viewed", .v = {gp_rect_w(view), gp_rect_h(view)}},
    };
    memcpy(out, shared, sizeof shared);
    return sizeof shared / sizeof *shared;
}

static void grid_uniforms(const struct grid *g, const struct gp_splat_kernel *o,
                         int which, struct gp_uniform *out)
{
    const struct gp_uniform own[] = {
        {.name = "places", .texture = g->places ? g->places : g->sensors},
        {.name = "grid", .v = {g->cells.side, g->places ? which : -1}},
        {.name = "rest", .floats = 2, .f = {o->rest[0], o->rest[1]}},
    };
    memcpy(out, own, sizeof own);
}

/* Cosine and sine in two parts: the first, in 1/1024, times a whole number of
 * pixels is exact in float. */
static void turn_uniforms(const struct gp_unturned *u, struct gp_uniform *out)
{
    const double c = round(u->cos * 1024.0) / 1024.0;
    const double s = round(u->sin * 1024.0) / 1024.0;
    const struct gp_uniform own[] = {
        {.name = "turn", .floats = 2, .f = {(float) u->cos, (float) u->sin}},
        {.name = "most", .floats = 2, .f = {(float) c, (float) s}},
        {.name = "least", .floats = 2, .f = {(float) (u->cos - c),
                                             (float) (u->sin - s)}},
    };
    memcpy(out, own, sizeof own);
}

static enum gp_splat_program program_for(const struct gp_splat_work *k,
                                         const struct grid *g, int which)
{
    if (which == GP_SPLAT_TURNED)
        return GP_SPLAT_TURNED_QUAD;
    if (k->points)
        return GP_SPLAT_POINT;
    return g->places ? GP_SPLAT_SMOOTH_QUAD : GP_SPLAT_EXACT_QUAD;
}

static gp_status draw_with(const struct gp_splat_work *k, const struct grid *g,
                           const struct gp_target *to, int which, int first,
                           int end)
{
    struct gp_splat *const s = k->s;
    const struct gp_kernel *const kernel = k->job->kernel;
    gp_status st = gp_splat_need_kernel(k->job->log, s, kernel, which);
    const struct gp_splat_kernel *const o = &s->kernel[which];
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): all work has its s
    if (st || !o->w)
        return st;
    const enum gp_splat_program program = program_for(k, g, which);
    st = gp_splat_use(k->job->log, s, program);
    if (st)
        return st;
    const struct gp_rect view = {-k->margin, -k->margin,
                                 to->colour.w + k->margin,
                                 to->colour.h + k->margin};
    struct gp_uniform uniform[UNIFORMS] = {0};
    const int n = shared_uniforms(k, g, which, first, end, view, uniform);
    if (which == GP_SPLAT_TURNED)
        turn_uniforms(kernel->unturned, uniform + n);
    else
        grid_uniforms(g, o, which, uniform + n);
    const struct gp_draw draw = {
        .program = &s->program[program], .target = to,
        .cut = {0, 0, gp_rect_w(k->tile), gp_rect_h(k->tile)}, .view = view,
        .uniform = uniform,
        .vertices = QUADS * (k->points ? 1 : QUAD_VERTICES),
        .instances = (end - first + QUADS - 1) / QUADS, .points = k->points,
    };
    return gp_draw_run(k->job->log, s->gl, &draw);
}

/* Cells [first, end) in row order, blur after blur. */
static gp_status draw_range(const struct gp_splat_work *k, const struct grid *g,
                            const struct gp_target *to, int first, int end)
{
    if (!g->places)
        return draw_with(k, g, to,
                         k->turned ? GP_SPLAT_TURNED : GP_SPLAT_WHOLE, first,
                         end);
    gp_status st = GP_OK;
    for (int blur = 0; !st && blur < GP_BLURS; blur++) {
        if (g->blurs >> blur & 1)
            st = draw_with(k, g, to, blur, first, end);
    }
    return st;
}

/* -- chunks ---------------------------------------------------------------- */

static int clamp_row(double y, int rows)
{
    return y < 0.0 ? 0 : y > rows ? rows : (int) y;
}

static void hold(struct gp_splat_work *k, const struct gp_polygon *p)
{
    const int rows = gp_rect_h(k->tile);
    const double y = (double) p->y - k->tile.y0;
    const int top = clamp_row(floor(y) + k->meets.y0, rows);
    const int bottom = clamp_row(ceil(y) + k->meets.y1, rows);
    k->top = !k->held || top < k->top ? top : k->top;
    k->bottom = !k->held || bottom > k->bottom ? bottom : k->bottom;
    k->held++;
}

/* Adds what the chunk holds to the total, and empties it. */
gp_status gp_splat_flush(struct gp_splat_work *k)
{
    struct gp_splat *const s = k->s;
    const struct gp_rect rows = {0, k->top, gp_rect_w(k->tile), k->bottom};
    const struct gp_uniform uniform[] = {
        {.name = "addend", .texture = &s->chunk.colour}, {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SPLAT_ADD], .target = &s->total, .cut = rows,
        .uniform = uniform, .vertices = 3, .instances = 1,
    };
    gp_status st = gp_splat_use(k->job->log, s, GP_SPLAT_ADD);
    if (!st)
        st = gp_draw_run(k->job->log, s->gl, &draw);
    gp_target_clear(s->gl, &s->chunk, rows);
    k->held = 0;
    return st;
}

/* The polygon's cell, -1 outside of the grid. P0 lies among the pixels of its
 * cell, so its whole part is enough. */
static int cell_of(const struct grid *g, const struct gp_polygon *p)
{
    const struct gp_rect r = gp_cells_rect(&g->cells);
    const int x = (int) floorf(p->x), y = (int) floorf(p->y);
    if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1)
        return -1;
    return (y - r.y0) / g->cells.side * g->cells.w + (x - r.x0) / g->cells.side;
}

static gp_status draw_grid(struct gp_splat_work *k, const struct grid *g)
{
    const int end = g->cells.w * g->cells.h;
    if (k->plan->polygons.n <= k->chunk)
        return draw_range(k, g, &k->s->total, 0, end);
    gp_status st = GP_OK;
    int first = 0;
    bool pending = false;
    for (size_t i = 0; !st && i < g->n; i++) {
        const int cell = cell_of(g, &g->at[i]);
        if (cell < 0)
            continue;
        hold(k, &g->at[i]);
        pending = true;
        if (k->held < k->chunk)
            continue;
        st = draw_range(k, g, &k->s->chunk, first, cell + 1);
        if (!st)
            st = gp_splat_flush(k);
        first = cell + 1;
        pending = false;
    }
    return st || !pending ? st : draw_range(k, g, &k->s->chunk, first, end);
}

/* -- blocks ---------------------------------------------------------------- */

static gp_status draw_cells(struct gp_splat_work *k, struct gp_rect rect,
                            const struct gp_cells *coarse)
{
    struct gp_splat *const s = k->s;
    const struct gp_log *const log = k->job->log;
    const struct gp_splat_params *const p = &k->plan->params;
    const struct gp_polygons *const all = &k->plan->polygons;
    struct grid clusters = {
        .cells = *coarse, .blurs = k->cluster_blurs, .at = all->at,
        .n = all->clusters,
    };
    struct grid groups = {
        .cells = {p->group, coarse->x, coarse->y,
                  coarse->w * (k->span / p->group),
                  coarse->h * (k->span / p->group)},
        .blurs = k->group_blurs, .at = all->at + all->clusters,
        .n = all->groups,
    };
    const bool clustered = p->cluster && all->clusters;
    gp_status st = GP_OK;
    if (clustered)
        st = gp_splat_group(log, s, rect, &clusters.cells, k->cluster_blurs,
                            p->cluster_fill, NULL, 0, &s->clusters);
    clusters.sensors = &s->clusters.colour;
    clusters.places = &s->clusters.more[0];
    if (!st && clustered)
        st = draw_grid(k, &clusters);
    if (!st)
        st = gp_splat_group(log, s, rect, &groups.cells, k->group_blurs, 0.0f,
                            clustered ? &s->clusters : NULL, p->cluster,
                            &s->groups);
    groups.sensors = &s->groups.colour;
    groups.places = p->group > 1 ? &s->groups.more[0] : NULL;
    return st ? st : draw_grid(k, &groups);
}

gp_status gp_splat_block(struct gp_splat_work *k, const struct gp_cells *coarse)
{
    const struct gp_sources *const src = k->job->src;
    const struct gp_rect rect = gp_rect_meet(
        gp_cells_rect(coarse), (struct gp_rect) {0, 0, src->w, src->h});
    const struct grid pixels = {
        .cells = {1, rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect)},
        .sensors = &k->s->sources, .at = k->plan->polygons.at,
        .n = k->plan->polygons.n,
    };
    gp_status st = gp_splat_upload(k->job->log, k->s, src, rect);
    if (!st && k->plan->single)
        return draw_grid(k, &pixels);
    if (!st && k->plan->core)
        st = draw_with(k, &pixels, &k->s->total, GP_SPLAT_CORE, 0,
                       pixels.cells.w * pixels.cells.h);
    return st || !k->plan->tail ? st : draw_cells(k, rect, coarse);
}
