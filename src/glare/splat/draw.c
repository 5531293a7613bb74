// SPDX-License-Identifier: Apache-2.0
/* Polygons on GL, blended: quads over the sensors of a grid
 * (Ando et al. 2007, sections 3 and 4).
 *
 * Blending adds in float, one polygon after another. So layout->chunk of them at
 * a time are summed in a target of their own, which is then added to the
 * total. */
#include "core/minmax.h"
#include "glare/splat/splat_priv.h"

#include <math.h>
#include <string.h>

// -- objects ------------------------------------------------------------------

static const size_t KEEP_BYTES = (size_t) 1 << 30; // of kernels

gp_status gp_splat_need_target(const struct gp_log *log, struct gp_splat *s,
    const char *what, int n, int w, int h, struct gp_target *t)
{
    const gp_status st = gp_target_make(log, s->gl, what, GP_TEXEL_FLOAT, n,
                                        gp_max(t->w, w), gp_max(t->h, h), t);
    if (!st)
        gp_target_clear(s->gl, t, (struct gp_rect) {0, 0, w, h});
    return st;
}

void gp_splat_drop_kernels(struct gp_splat *s)
{
    for (int i = 0; i < GP_SPLAT_KERNELS; i++) {
        gp_texture_free(s->gl, &s->kernel[i].texture);
        s->kernel[i] = (struct gp_splat_kernel) {0};
    }
    s->bytes = 0;
}

/* Writes row y of texels, which are 0. */
typedef void (*fill_row)(const void *ctx, int y, float *texel);

/* Uploads w x h texels, band after band, to a texture of that size at least. */
static gp_status upload(const struct gp_log *log, struct gp_splat *s,
                        const char *what, int w, int h, fill_row fill,
                        const void *ctx, struct gp_texture *t)
{
    const int rows = GP_SPLAT_TEXELS / w;
    const size_t pitch = 4 * (size_t) w;
    const gp_status st = gp_texture_make(log, s->gl, what, GP_TEXEL_FLOAT,
                                         gp_max(t->w, w), gp_max(t->h, h), t);
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const int y1 = gp_min(h - y0, rows) + y0;
        memset(s->texel, 0, (size_t) (y1 - y0) * pitch * sizeof *s->texel);
        for (int y = y0; y < y1; y++)
            fill(ctx, y, s->texel + (size_t) (y - y0) * pitch);
        gp_texture_write(s->gl, t, (struct gp_rect) {0, y0, w, y1}, s->texel);
    }
    return st;
}

static void fill_kernel(const void *ctx, int y, float *texel)
{
    const struct gp_blur *const b = ctx;
    const size_t n = (size_t) b->w, first = (size_t) y * n;
    if (b->grey)
        memcpy(texel, b->k.c[0] + first, n * sizeof *texel);
    for (size_t i = 0; !b->grey && i < 3 * n; i++)
        texel[i / 3 * 4 + i % 3] = b->k.c[i % 3][first + i / 3];
}

/* The light of pixels: rgb, and luminance. */
static void fill_sources(const void *ctx, int y, float *row)
{
    const struct gp_sources *const src = ctx;
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
        float *const texel = row + 4 * src->x[i];
        double light = 0.0;
        for (int c = 0; c < 3; c++) {
            texel[c] = src->rgb[c][i];
            light += (double) src->luminance[c] * (double) texel[c];
        }
        // weights of unreal primaries may be negative
        texel[3] = light > 0.0 ? (float) light : 0.0f;
    }
}

gp_status gp_splat_need_kernel(const struct gp_log *log, struct gp_splat *s,
                               const struct gp_kernel *k, int which)
{
    struct gp_splat_kernel *const o = &s->kernel[which];
    const bool middle = which == GP_SPLAT_MIDDLE;
    const struct gp_rect crop =
        middle ? gp_rect_meet(
                     gp_kernel_around(k, GP_MIDDLE_RADIUS, GP_MIDDLE_RADIUS),
                     s->crop)
               : s->crop;
    if (o->texture.id || gp_rect_empty(crop))
        return GP_OK;
    struct gp_blur b = {0};
    gp_status st = gp_blur_make(log, k, crop, s->hollow && !middle,
                                middle ? 1 : gp_blur_box[which], &b);
    if (st)
        return st;
    const size_t bytes = (size_t) b.w * (size_t) b.h * (b.grey ? 1 : 4) *
                         sizeof(float);
    if (s->bytes + bytes > KEEP_BYTES)
        gp_splat_drop_kernels(s);
    s->bytes += bytes;
    *o = (struct gp_splat_kernel) {
        .grey = b.grey, .w = b.w, .h = b.h,
        .cx = (int) floorf(b.cx), .cy = (int) floorf(b.cy),
    };
    o->rest[0] = b.cx - (float) o->cx;
    o->rest[1] = b.cy - (float) o->cy;
    st = upload(log, s, "kernel", b.grey ? (b.w + 3) / 4 : b.w, b.h,
                fill_kernel, &b, &o->texture);
    if (!st)
        st = gp_gl_check(log, s->gl, "packing the kernel");
    if (st)
        gp_splat_drop_kernels(s);
    gp_planes_free(&b.k);
    return st;
}

/* -- groups ---------------------------------------------------------------- */

/* One pass over the sources (Ando et al. 2007, sections 4.1 and 4.2): makes
 * `out`, two attachments, as group.frag says.
 *
 *   boxes    bits of the blurs that may be taken
 *   fill     share of bright pixels under which a cell stays shut; 0: none
 *   parent   side of the clusters in s->clusters whose cells stay shut; 0: none
 * Errors: GP_ERR_GL. */
static gp_status make_groups(const struct gp_glare_request *req,
                             struct gp_splat *s, const struct gp_cells *c,
                             unsigned boxes, float fill, int parent,
                             struct gp_target *out)
{
    const struct gp_log *const log = req->log;
    gp_status st =
        gp_program_make(log, s->gl, "", "add.vert", "group.frag", &s->group);
    if (!st)
        st = gp_splat_need_target(log, s, "groups", 2, c->w, c->h, out);
    if (st)
        return st;
    const struct gp_uniform uniform[] = {
        {.name = "sources", .texture = &s->sources},
        {.name = "parents", .texture = parent ? &s->clusters.colour
                                              : &s->sources},
        {.name = "origin", .v = {c->x, c->y}},
        {.name = "size", .v = {req->src->w, req->src->h}},
        {.name = "side", .v = {c->side, parent / c->side}},
        {.name = "boxes", .v = {(int) boxes, 0}},
        {.name = "fill", .floats = 1, .f = {fill}},
        {0},
    };
    const struct gp_draw draw = {
        .program = &s->group, .target = out,
        .cut = {0, 0, c->w, c->h}, .uniform = uniform, .vertices = 3,
        .instances = 1, .replace = true,
    };
    return gp_draw_run(log, s->gl, &draw);
}

enum {
    QUADS = 64,        // of one instance, which costs llvmpipe 0.2 us
    QUAD_VERTICES = 6,
    FAR = 1 << 20,     // pixels, beyond every frame
};

struct drawing {
    const struct gp_glare_request *req;
    struct gp_splat *s;
    const struct gp_splat_layout *layout;
};

/* Cells whose sensors are drawn. */
struct grid {
    struct gp_cells cells;
    const struct gp_texture *sensors, *places; // places NULL: whole pixels
    const struct gp_polygon *at; // of the whole frame, in row order of cells
    size_t n;
};

/* -- one draw -------------------------------------------------------------- */

static gp_status draw_with(const struct drawing *k, const struct grid *g,
    const struct gp_target *to, int which, int first, int end)
{
    struct gp_splat *const s = k->s;
    const struct gp_log *const log = k->req->log;
    const struct gp_splat_kernel *const o = &s->kernel[which];
    gp_status st = gp_splat_need_kernel(log, s, k->req->kernel, which);
    if (st || !o->w)
        return st;
    struct gp_program *const program = &s->quad[o->grey];
    st = gp_program_make(log, s->gl, o->grey ? "#define GREY\n" : "",
                         "splat.vert", "splat.frag", program);
    if (st)
        return st;
    const bool shrinks = k->layout->params.shrink > 0.0f &&
                         which != GP_SPLAT_MIDDLE;
    const struct gp_uniform uniform[] = {
        {.name = "sensors", .texture = g->sensors},
        {.name = "reaches", .block = &s->reaches},
        {.name = "kernel", .texture = &o->texture},
        {.name = "cells", .v = {g->cells.w, g->cells.h}},
        {.name = "range", .v = {first, end}},
        {.name = "offset", .v = {g->cells.x, g->cells.y}},
        {.name = "extent", .v = {o->w, o->h}},
        {.name = "centre", .v = {o->cx, o->cy}},
        {.name = "shrinks", .v = {shrinks, 0}},
        {.name = "size", .v = {to->colour.w, to->colour.h}},
        {.name = "places", .texture = g->places ? g->places : g->sensors},
        {.name = "grid", .v = {g->cells.side, g->places ? which : -1}},
        {.name = "rest", .floats = 2, .f = {o->rest[0], o->rest[1]}},
        {0},
    };
    const struct gp_draw draw = {
        .program = program, .target = to,
        .cut = {0, 0, to->colour.w, to->colour.h}, .uniform = uniform,
        .vertices = QUADS * QUAD_VERTICES,
        .instances = (end - first + QUADS - 1) / QUADS,
    };
    return gp_draw_run(log, s->gl, &draw);
}

static unsigned blurs_of(const struct gp_polygon *at, size_t n)
{
    unsigned used = 0;
    for (size_t i = 0; i < n; i++)
        used |= 1u << at[i].blur;
    return used;
}

/* Draws cells [first, end) in row order, blur after blur. */
static gp_status draw_range(const struct drawing *k, const struct grid *g,
                            const struct gp_target *to, int first, int end)
{
    if (!g->places)
        return draw_with(k, g, to, 0, first, end);
    const unsigned blurs = blurs_of(g->at, g->n);
    gp_status st = GP_OK;
    for (int blur = 0; !st && blur < GP_BLURS; blur++) {
        if (blurs >> blur & 1)
            st = draw_with(k, g, to, blur, first, end);
    }
    return st;
}

/* -- chunks ---------------------------------------------------------------- */

/* Adds what the chunk holds to the total, and empties it. */
static gp_status flush_chunk(const struct drawing *k)
{
    struct gp_splat *const s = k->s;
    const struct gp_rect all = {0, 0, k->req->src->w, k->req->src->h};
    const struct gp_uniform uniform[] = {
        {.name = "addend", .texture = &s->chunk.colour}, {0},
    };
    const struct gp_draw draw = {
        .program = &s->add, .target = &s->total, .cut = all,
        .uniform = uniform, .vertices = 3, .instances = 1,
    };
    gp_status st = gp_program_make(k->req->log, s->gl, "", "add.vert",
                                   "add.frag", &s->add);
    if (!st)
        st = gp_draw_run(k->req->log, s->gl, &draw);
    gp_target_clear(s->gl, &s->chunk, all);
    return st;
}

static bool has_chunks(const struct gp_splat_layout *p)
{
    return p->polygons.n > p->chunk;
}

/* Draws the grid: to the total, or chunk after chunk when there are many
 * polygons. */
static gp_status draw_grid(const struct drawing *k, const struct grid *g)
{
    const struct gp_cells *const c = &g->cells;
    const size_t chunk = k->layout->chunk;
    if (!has_chunks(k->layout))
        return draw_range(k, g, &k->s->total, 0, c->w * c->h);
    gp_status st = GP_OK;
    int first = 0;
    for (size_t i = 0; !st && i < g->n; i += chunk) {
        // P0 lies among the pixels of its cell: its whole part is enough
        const struct gp_polygon *const last =
            &g->at[i + chunk < g->n ? i + chunk - 1 : g->n - 1];
        const int x = (int) floorf(last->x), y = (int) floorf(last->y);
        const int next =
            (y - c->y) / c->side * c->w + (x - c->x) / c->side + 1;
        st = draw_range(k, g, &k->s->chunk, first, next);
        if (!st)
            st = flush_chunk(k);
        first = next;
    }
    return st;
}

/* -- the whole ------------------------------------------------------------- */

/* Draws each pixel, or its middle, for itself, and groups and clusters,
 * which are made on the way. */
static gp_status draw_grids(const struct drawing *k)
{
    gp_status st;
    struct gp_splat *const s = k->s;
    const struct gp_sources *const src = k->req->src;
    const struct gp_splat_params *const p = &k->layout->params;
    const struct gp_polygons *const all = &k->layout->polygons;
    const int span = gp_max(p->cluster, p->group);
    const struct gp_cells coarse = gp_cells_over(src, span);
    const struct grid pixels = {
        .cells = {1, 0, 0, src->w, src->h},
        .sensors = &s->sources, .at = all->at, .n = all->n,
    };
    GP_TRY(upload(k->req->log, s, "sensors", src->w, src->h, fill_sources, src,
                  &s->sources));
    if (k->layout->single)
        return draw_grid(k, &pixels);
    GP_TRY(draw_with(k, &pixels, &s->total, GP_SPLAT_MIDDLE, 0,
                     pixels.cells.w * pixels.cells.h));
    if (!k->layout->outer)
        return GP_OK;
    // clusters first: their cells hold no groups
    const struct grid clusters = {
        .cells = coarse, .at = all->at, .n = all->clusters,
        .sensors = &s->clusters.colour, .places = &s->clusters.more[0],
    };
    if (clusters.n) {
        GP_TRY(make_groups(k->req, s, &coarse, blurs_of(all->at, clusters.n),
                           p->cluster_fill, 0, &s->clusters));
        GP_TRY(draw_grid(k, &clusters));
    }
    const struct grid groups = {
        .cells = {p->group, coarse.x, coarse.y, coarse.w * (span / p->group),
                  coarse.h * (span / p->group)},
        .at = all->at + all->clusters, .n = all->groups,
        .sensors = &s->groups.colour,
        .places = p->group > 1 ? &s->groups.more[0] : NULL,
    };
    GP_TRY(make_groups(k->req, s, &groups.cells,
                       blurs_of(groups.at, groups.n), 0.0f,
                       clusters.n ? p->cluster : 0, &s->groups));
    st = draw_grid(k, &groups);
out:
    return st;
}

static void read_total(const struct gp_glare_request *req, struct gp_splat *s)
{
    const int w = req->src->w, h = req->src->h;
    const int rows = GP_SPLAT_TEXELS / w;
    for (int y0 = 0; y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(y0 + rows, h)};
        const size_t at = (size_t) y0 * (size_t) w;
        const size_t n = (size_t) w * (size_t) gp_rect_h(band);
        gp_target_read(s->gl, &s->total, 0, band, s->texel);
        for (size_t i = 0; i < n; i++) {
            for (size_t c = 0; c < 3; c++)
                req->layer->c[c][at + i] = s->texel[4 * i + c];
        }
    }
}

gp_status gp_splat_draw(const struct gp_glare_request *req, struct gp_splat *s,
                        const struct gp_splat_layout *p)
{
    gp_status st;
    const struct drawing k = {.req = req, .s = s, .layout = p};
    float reach[GP_SOURCE_BINS];
    if (!s->reaches.id)
        GP_TRY(gp_buffer_make(req->log, s->gl, "reaches", GP_BUFFER_BLOCK,
                              GP_SOURCE_BINS / 4, &s->reaches));
    for (int i = 0; i < GP_SOURCE_BINS; i++)
        reach[i] = (float) gp_min(p->shrink.reach[i], FAR);
    gp_buffer_write(s->gl, &s->reaches, 0, GP_SOURCE_BINS / 4, reach);
    GP_TRY(gp_splat_need_target(req->log, s, "layer", 1, req->src->w,
                                req->src->h, &s->total));
    if (has_chunks(p))
        GP_TRY(gp_splat_need_target(req->log, s, "layer", 1, req->src->w,
                                    req->src->h, &s->chunk));
    GP_TRY(draw_grids(&k));
    read_total(req, s);
    st = gp_gl_check(req->log, s->gl, "drawing glare polygons");
out:
    return st;
}
