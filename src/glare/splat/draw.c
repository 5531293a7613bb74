/* Polygons on GL, blended: quads over the sensors of a grid
 * (Ando et al. 2007, sections 3 and 4).
 *
 * A frame larger than a target is drawn field by field, and the sensors that
 * reach a field patch by patch. Blending adds in float, one polygon after
 * another, so layout->chunk of them at a time are summed in a target of their
 * own, which is then added to the total. */
#include "core/minmax.h"
#include "glare/splat/splat_priv.h"

#include <math.h>
#include <string.h>

// -- programs -----------------------------------------------------------------

/* Makes a program unless it exists. Errors: GP_ERR_GL. */
static gp_status use_program(const struct gp_log *log, struct gp_splat *s,
                             enum gp_splat_program which)
{
#define FILES(name, vert, frag) {vert, frag},
    static const char *const files[][2] = {GP_SPLAT_PROGRAMS(FILES)};
#undef FILES
    if (s->program[which].id)
        return GP_OK;
    return gp_program_make(log, s->gl, "", files[which][0], files[which][1],
                           &s->program[which]);
}

gp_status gp_splat_fit_target(const struct gp_log *log, const struct gp_gl *gl,
    const char *what, int n, int w, int h, struct gp_target *t)
{
    if (t->framebuffer && t->colour.w >= w && t->colour.h >= h)
        return GP_OK;
    w = gp_max(t->colour.w, w);
    h = gp_max(t->colour.h, h);
    gp_target_free(gl, t);
    return gp_target_make(log, gl, what, GP_TEXEL_FLOAT, n, w, h, t);
}

/* -- kernels --------------------------------------------------------------- */

void gp_splat_drop_kernels(struct gp_splat *s)
{
    for (int i = 0; i < GP_SPLAT_KERNELS; i++) {
        gp_texture_free(s->gl, &s->kernel[i].texture);
        s->kernel[i] = (struct gp_splat_kernel) {0};
    }
}

/* Drops the kernels unless they were made from this kernel, crop, and use:
 * `tail` leaves the core out of all but GP_SPLAT_CORE. */
static void set_kernel(struct gp_splat *s, const struct gp_kernel *k,
                       struct gp_rect crop, bool tail)
{
    const bool same = k->serial && k->serial == s->serial &&
                      memcmp(&crop, &s->crop, sizeof crop) == 0 &&
                      tail == s->tail;
    if (same)
        return;
    gp_splat_drop_kernels(s);
    s->serial = k->serial;
    s->crop = crop;
    s->tail = tail;
}

/* Uploads the planes with their border, band after band; what was made so far
 * stays in *o when it fails. */
static gp_status upload_kernel(const struct gp_log *log, struct gp_splat *s,
    const struct gp_planes *k, struct gp_splat_kernel *o)
{
    const int b = o->border, w = o->w + 2 * b, h = o->h + 2 * b;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    gp_status st = gp_texture_make(log, s->gl, "kernel", GP_TEXEL_FLOAT, w, h,
                                   &o->texture);
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(h - y0, rows) + y0};
        memset(s->band, 0,
               (size_t) gp_rect_h(band) * (size_t) w * 4 * sizeof(float));
        for (int y = gp_max(y0, b); y < gp_min(band.y1, o->h + b); y++) {
            const size_t from = (size_t) (y - b) * (size_t) o->w;
            float *const to =
                s->band + 4 * ((size_t) (y - y0) * (size_t) w + (size_t) b);
            for (size_t x = 0; x < (size_t) o->w; x++) {
                for (size_t c = 0; c < 3; c++)
                    to[4 * x + c] = k->c[c][from + x];
            }
        }
        gp_texture_write(s->gl, &o->texture, band, s->band);
    }
    return st;
}

/* Makes s->kernel[which] unless it exists. A kernel of no samples (a core
 * that the crop does not meet) has w 0 and no texture.
 * Errors: GP_ERR_GL over the texture limit, GP_ERR_BUG out of memory. */
static gp_status need_kernel(const struct gp_log *log, struct gp_splat *s,
                             const struct gp_kernel *k, int which)
{
    if (s->kernel[which].texture.id)
        return GP_OK;
    const struct gp_unturned *const u = k->unturned;
    if (which == GP_SPLAT_TURNED) {
        struct gp_splat_kernel o = {.border = 1, .w = u->w, .h = u->h,
                                    .cx = u->cx, .cy = u->cy};
        gp_status st = upload_kernel(log, s, &u->k, &o);
        if (!st)
            s->kernel[which] = o;
        return st;
    }
    const bool core = which == GP_SPLAT_CORE, smooth = which < GP_BLURS;
    const struct gp_rect around = {
        k->cx - GP_CORE_RADIUS, k->cy - GP_CORE_RADIUS,
        k->cx + GP_CORE_RADIUS + 1, k->cy + GP_CORE_RADIUS + 1,
    };
    const struct gp_rect crop = core ? gp_rect_meet(around, s->crop) : s->crop;
    if (gp_rect_empty(crop))
        return GP_OK;
    struct gp_blur b = {0};
    gp_status st = gp_blur_make(log, k, crop, s->tail && !core,
                                smooth ? gp_blur_box[which] : 1, &b);
    if (st)
        return st;
    struct gp_splat_kernel o = {
        .border = smooth, .w = b.w, .h = b.h,
        .cx = (int) floorf(b.cx), .cy = (int) floorf(b.cy),
    };
    o.rest[0] = b.cx - (float) o.cx;
    o.rest[1] = b.cy - (float) o.cy;
    st = upload_kernel(log, s, &b.k, &o);
    if (!st)
        s->kernel[which] = o;
    gp_blur_free(&b);
    return st;
}

/* -- sensors --------------------------------------------------------------- */

/* In EXR pixel space a cell starts at each multiple of its side. */
static int first_corner(int at, int origin, int side)
{
    const long long v = (long long) at + origin, part = v % side;
    return (int) (v - part - (part < 0 ? side : 0) - origin);
}

struct gp_cells gp_cells_over(const struct gp_sources *src, struct gp_rect rect,
                              int side)
{
    struct gp_cells c = {
        .side = side,
        .x = first_corner(rect.x0, src->x0, side),
        .y = first_corner(rect.y0, src->y0, side),
    };
    c.w = (rect.x1 - c.x + side - 1) / side;
    c.h = (rect.y1 - c.y + side - 1) / side;
    return c;
}

static struct gp_rect cells_rect(const struct gp_cells *c)
{
    return (struct gp_rect) {c->x, c->y, c->x + c->w * c->side,
                             c->y + c->h * c->side};
}

gp_status gp_splat_upload(const struct gp_log *log, struct gp_splat *s,
                          const struct gp_sources *src, struct gp_rect rect)
{
    const int w = gp_rect_w(rect), h = gp_rect_h(rect);
    struct gp_texture *const t = &s->sources;
    gp_status st = GP_OK;
    if (w < 1)
        return GP_OK;
    if (t->w < w || t->h < h) { // the box of a moving light changes each frame
        const int wide = gp_max(t->w, w), high = gp_max(t->h, h);
        gp_texture_free(s->gl, t);
        st = gp_texture_make(log, s->gl, "sensors", GP_TEXEL_FLOAT, wide, high,
                             t);
    }
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; !st && y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(h - y0, rows) + y0};
        memset(s->band, 0,
               (size_t) w * (size_t) gp_rect_h(band) * 4 * sizeof(float));
        for (int y = y0; y < band.y1; y++) {
            float *const row = s->band + 4 * (size_t) (y - y0) * (size_t) w;
            const uint32_t end = src->row[rect.y0 + y + 1];
            for (uint32_t i = src->row[rect.y0 + y]; i < end; i++) {
                if (src->x[i] < rect.x0 || src->x[i] >= rect.x1)
                    continue;
                float *const texel = row + 4 * (src->x[i] - rect.x0);
                double light = 0.0;
                for (int c = 0; c < 3; c++) {
                    texel[c] = src->rgb[c][i];
                    light += (double) src->luminance[c] * (double) texel[c];
                }
                // weights of unreal primaries may be negative
                texel[3] = light > 0.0 ? (float) light : 0.0f;
            }
        }
        gp_texture_write(s->gl, t, band, s->band);
    }
    return st;
}

/* -- groups ---------------------------------------------------------------- */

gp_status gp_splat_group(const struct gp_log *log, struct gp_splat *s,
    struct gp_rect rect, const struct gp_cells *c, unsigned boxes, float fill,
    const struct gp_splat_parents *parents, struct gp_target *out)
{
    gp_status st = use_program(log, s, GP_SPLAT_GROUP);
    if (!st)
        st = gp_splat_fit_target(log, s->gl, "groups", 2, c->w, c->h, out);
    if (st)
        return st;
    const struct gp_uniform uniform[] = {
        {.name = "sources", .texture = &s->sources},
        {.name = "parents", .texture = parents ? &parents->cells->colour
                                               : &s->sources},
        {.name = "origin", .v = {c->x - rect.x0, c->y - rect.y0}},
        {.name = "size", .v = {gp_rect_w(rect), gp_rect_h(rect)}},
        {.name = "side", .v = {c->side, parents ? parents->side / c->side : 0}},
        {.name = "boxes", .v = {(int) boxes, 0}},
        {.name = "fill", .floats = 1, .f = {fill}},
        {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SPLAT_GROUP], .target = out,
        .cut = {0, 0, c->w, c->h}, .uniform = uniform, .vertices = 3,
        .instances = 1, .replace = true,
    };
    return gp_draw_run(log, s->gl, &draw);
}

enum {
    QUADS = 64,        // of one instance, which costs llvmpipe 0.2 us
    QUAD_VERTICES = 6,
    FIELD_MAX = 4096,  // 256 MiB a target; Mesa stops at 2 GiB a texture
    TURNED_MAX = 8192, // pixels, times 1/1024, that float holds exactly
    FAR = 1 << 20,     // pixels, beyond every frame
    UNIFORMS = 24,     // room for those of any program here
};

struct drawing {
    const struct gp_glare_request *req;
    struct gp_splat *s;
    const struct gp_splat_layout *layout;
    bool turned;          // quads turn, and the kernel stays as it was
    int margin;           // pixels that the view reaches beyond the field
    int span;             // of the coarsest cells
    int patch_side, field_side; // of the largest of each, in pixels
    struct gp_rect meets; // offsets from a polygon of pixels it may touch
    unsigned group_blurs, cluster_blurs; // bits of those that are used
    struct gp_rect field; // of the frame

    size_t held;          // polygons in the chunk
    int top, bottom;      // rows of the field that they may touch
};

/* Cells whose sensors are drawn. */
struct grid {
    struct gp_cells cells;
    const struct gp_texture *sensors, *places; // places NULL: whole pixels
    unsigned blurs;                            // when there are places
    const struct gp_polygon *at; // of the whole frame, in row order of cells
    size_t n;
};

static int reach_of(const struct gp_splat_layout *p, float light)
{
    return gp_min(p->shrink.reach[gp_source_bin(light)], FAR);
}

/* -- one draw -------------------------------------------------------------- */

/* Draws cells [first, end) with one kernel. */
static gp_status draw_with(const struct drawing *k, const struct grid *g,
    const struct gp_target *to, int which, int first, int end)
{
    struct gp_splat *const s = k->s;
    const struct gp_splat_kernel *const o = &s->kernel[which];
    const enum gp_splat_program program =
        which == GP_SPLAT_TURNED ? GP_SPLAT_TURNED_QUAD
        : g->places              ? GP_SPLAT_SMOOTH_QUAD
                                 : GP_SPLAT_EXACT_QUAD;
    gp_status st = need_kernel(k->req->log, s, k->req->kernel, which);
    // NOLINTNEXTLINE(clang-analyzer-core.NullDereference): always has its s
    if (st || !o->w)
        return st;
    st = use_program(k->req->log, s, program);
    if (st)
        return st;
    const bool shrinks = k->layout->params.shrink > 0.0f &&
                         which != GP_SPLAT_CORE;
    const struct gp_rect view = {-k->margin, -k->margin,
                                 to->colour.w + k->margin,
                                 to->colour.h + k->margin};
    struct gp_uniform uniform[UNIFORMS] = {
        {.name = "sensors", .texture = g->sensors},
        {.name = "reaches", .block = &s->reaches},
        {.name = "kernel", .texture = &o->texture},
        {.name = "cells", .v = {g->cells.w, g->cells.h}},
        {.name = "range", .v = {first, end}},
        {.name = "offset", .v = {g->cells.x - k->field.x0,
                                 g->cells.y - k->field.y0}},
        {.name = "extent", .v = {o->w, o->h}},
        {.name = "centre", .v = {o->cx, o->cy}},
        {.name = "shrinks", .v = {shrinks, 0}},
        {.name = "view", .v = {view.x0, view.y0}},
        {.name = "viewed", .v = {gp_rect_w(view), gp_rect_h(view)}},
    };
    struct gp_uniform *own = uniform;
    while (own->name)
        own++;
    if (which == GP_SPLAT_TURNED) {
        // cosine and sine in two parts: the first, in 1/1024, times a whole
        // number of pixels is exact in float
        const struct gp_unturned *const u = k->req->kernel->unturned;
        const double cos = round(u->cos * 1024.0) / 1024.0;
        const double sin = round(u->sin * 1024.0) / 1024.0;
        *own++ = (struct gp_uniform) {
            .name = "turn", .floats = 2, .f = {(float) u->cos, (float) u->sin}};
        *own++ = (struct gp_uniform) {
            .name = "most", .floats = 2, .f = {(float) cos, (float) sin}};
        *own = (struct gp_uniform) {
            .name = "least", .floats = 2, .f = {(float) (u->cos - cos),
                                                (float) (u->sin - sin)}};
    } else {
        *own++ = (struct gp_uniform) {
            .name = "places", .texture = g->places ? g->places : g->sensors};
        *own++ = (struct gp_uniform) {
            .name = "grid", .v = {g->cells.side, g->places ? which : -1}};
        *own = (struct gp_uniform) {
            .name = "rest", .floats = 2, .f = {o->rest[0], o->rest[1]}};
    }
    const struct gp_draw draw = {
        .program = &s->program[program], .target = to,
        .cut = {0, 0, gp_rect_w(k->field), gp_rect_h(k->field)}, .view = view,
        .uniform = uniform,
        .vertices = QUADS * QUAD_VERTICES,
        .instances = (end - first + QUADS - 1) / QUADS,
    };
    return gp_draw_run(k->req->log, s->gl, &draw);
}

/* Draws cells [first, end) in row order, blur after blur. */
static gp_status draw_range(const struct drawing *k, const struct grid *g,
                            const struct gp_target *to, int first, int end)
{
    if (!g->places)
        return draw_with(k, g, to, k->turned ? GP_SPLAT_TURNED : GP_SPLAT_WHOLE,
            first, end);
    gp_status st = GP_OK;
    for (int blur = 0; !st && blur < GP_BLURS; blur++) {
        if (g->blurs >> blur & 1)
            st = draw_with(k, g, to, blur, first, end);
    }
    return st;
}

/* -- chunks ---------------------------------------------------------------- */

/* Adds what the chunk holds to the total, and empties it. */
static gp_status flush_chunk(struct drawing *k)
{
    struct gp_splat *const s = k->s;
    const struct gp_rect rows = {0, k->top, gp_rect_w(k->field), k->bottom};
    const struct gp_uniform uniform[] = {
        {.name = "addend", .texture = &s->chunk.colour}, {0},
    };
    const struct gp_draw draw = {
        .program = &s->program[GP_SPLAT_ADD], .target = &s->total, .cut = rows,
        .uniform = uniform, .vertices = 3, .instances = 1,
    };
    gp_status st = use_program(k->req->log, s, GP_SPLAT_ADD);
    if (!st)
        st = gp_draw_run(k->req->log, s->gl, &draw);
    gp_target_clear(s->gl, &s->chunk, rows);
    k->held = 0;
    return st;
}

/* Draws the grid: to the total, or to the chunk when there are many
 * polygons. */
static gp_status draw_grid(struct drawing *k, const struct grid *g)
{
    const struct gp_cells *const c = &g->cells;
    const struct gp_rect r = cells_rect(c);
    const int end = c->w * c->h;
    if (k->layout->polygons.n <= k->layout->chunk)
        return draw_range(k, g, &k->s->total, 0, end);
    gp_status st = GP_OK;
    const double rows = gp_rect_h(k->field);
    int first = 0;
    bool pending = false;
    for (size_t i = 0; !st && i < g->n; i++) {
        // P0 lies among the pixels of its cell: its whole part is enough
        const int x = (int) floorf(g->at[i].x), y = (int) floorf(g->at[i].y);
        if (x < r.x0 || x >= r.x1 || y < r.y0 || y >= r.y1)
            continue;
        // the rows that the polygon may touch
        const double middle = (double) g->at[i].y - k->field.y0;
        const int top =
            (int) fmin(fmax(floor(middle) + k->meets.y0, 0.0), rows);
        const int low = (int) fmin(fmax(ceil(middle) + k->meets.y1, 0.0), rows);
        k->top = k->held ? gp_min(k->top, top) : top;
        k->bottom = k->held ? gp_max(k->bottom, low) : low;
        k->held++;
        pending = true;
        if (k->held < k->layout->chunk)
            continue;
        const int next = (y - r.y0) / c->side * c->w + (x - r.x0) / c->side + 1;
        st = draw_range(k, g, &k->s->chunk, first, next);
        if (!st)
            st = flush_chunk(k);
        first = next;
        pending = false;
    }
    return st || !pending ? st : draw_range(k, g, &k->s->chunk, first, end);
}

/* -- patches of sensors ---------------------------------------------------- */

/* Draws the light of the pixels that the coarse cells cover: each for itself,
 * or its core for itself, and groups and clusters, which are made on the
 * way. */
static gp_status draw_patch(struct drawing *k, const struct gp_cells *coarse)
{
    gp_status st;
    struct gp_splat *const s = k->s;
    const struct gp_log *const log = k->req->log;
    const struct gp_sources *const src = k->req->src;
    const struct gp_splat_params *const p = &k->layout->params;
    const struct gp_polygons *const all = &k->layout->polygons;
    const struct gp_rect rect = gp_rect_meet(
        cells_rect(coarse), (struct gp_rect) {0, 0, src->w, src->h});
    const struct grid pixels = {
        .cells = {1, rect.x0, rect.y0, gp_rect_w(rect), gp_rect_h(rect)},
        .sensors = &s->sources, .at = all->at, .n = all->n,
    };
    GP_TRY(gp_splat_upload(log, s, src, rect));
    if (k->layout->single)
        return draw_grid(k, &pixels);
    if (k->layout->core)
        GP_TRY(draw_with(k, &pixels, &s->total, GP_SPLAT_CORE, 0,
                         pixels.cells.w * pixels.cells.h));
    if (!k->layout->tail)
        return GP_OK;
    // clusters first: their cells hold no groups
    const bool clustered = p->cluster && all->clusters;
    const struct grid clusters = {
        .cells = *coarse, .blurs = k->cluster_blurs, .at = all->at,
        .n = all->clusters, .sensors = &s->clusters.colour,
        .places = &s->clusters.more[0],
    };
    if (clustered) {
        GP_TRY(gp_splat_group(log, s, rect, coarse, k->cluster_blurs,
                              p->cluster_fill, NULL, &s->clusters));
        GP_TRY(draw_grid(k, &clusters));
    }
    const struct gp_splat_parents parents = {&s->clusters, p->cluster};
    const struct grid groups = {
        .cells = {p->group, coarse->x, coarse->y,
                  coarse->w * (k->span / p->group),
                  coarse->h * (k->span / p->group)},
        .blurs = k->group_blurs, .at = all->at + all->clusters,
        .n = all->groups, .sensors = &s->groups.colour,
        .places = p->group > 1 ? &s->groups.more[0] : NULL,
    };
    GP_TRY(gp_splat_group(log, s, rect, &groups.cells, k->group_blurs, 0.0f,
                          clustered ? &parents : NULL, &s->groups));
    st = draw_grid(k, &groups);
out:
    return st;
}

/* -- fields of the frame --------------------------------------------------- */

/* Draws the sensors that reach the field, and reads it back. */
static gp_status draw_field(struct drawing *k)
{
    struct gp_splat *const s = k->s;
    const struct gp_rect f = k->field, m = k->meets;
    const int w = gp_rect_w(f), h = gp_rect_h(f);
    const struct gp_rect whole = {0, 0, k->field_side, k->field_side};
    // the pixels whose polygons meet the field
    const struct gp_rect near = gp_rect_meet(
        (struct gp_rect) {f.x0 - m.x1 - 1, f.y0 - m.y1 - 1, f.x1 - m.x0 + 1,
                          f.y1 - m.y0 + 1}, k->req->src->box);
    gp_target_clear(s->gl, &s->total, whole);
    if (k->layout->polygons.n > k->layout->chunk)
        gp_target_clear(s->gl, &s->chunk, whole);
    gp_status st = GP_OK;
    if (!gp_rect_empty(near)) {
        const struct gp_cells all = gp_cells_over(k->req->src, near, k->span);
        const int most = k->patch_side / k->span; // cells of a patch's side
        for (int y = 0; !st && y < all.h; y += most) {
            for (int x = 0; !st && x < all.w; x += most) {
                const struct gp_cells coarse = {
                    k->span, all.x + x * k->span, all.y + y * k->span,
                    gp_min(most, all.w - x), gp_min(most, all.h - y),
                };
                st = draw_patch(k, &coarse);
            }
        }
    }
    if (!st && k->held)
        st = flush_chunk(k);
    k->held = 0;
    if (st)
        return st;
    const int rows = GP_SPLAT_BAND_TEXELS / w;
    for (int y0 = 0; y0 < h; y0 += rows) {
        const struct gp_rect band = {0, y0, w, gp_min(y0 + rows, h)};
        gp_target_read(s->gl, &s->total, 0, band, s->band);
        for (int y = y0; y < band.y1; y++) {
            const size_t to =
                (size_t) (f.y0 + y) * (size_t) k->req->src->w + (size_t) f.x0;
            const float *const from =
                s->band + 4 * (size_t) (y - y0) * (size_t) w;
            for (int c = 0; c < 3; c++) {
                for (int x = 0; x < w; x++)
                    k->req->layer->c[c][to + (size_t) x] = from[4 * x + c];
            }
        }
    }
    return gp_gl_check(k->req->log, s->gl, "drawing glare polygons");
}

static int ceil_div(int size, int side)
{
    return (size + side - 1) / side;
}

/* Draws fields of nearly one size, so that the last is not mostly empty. */
static gp_status draw_fields(struct drawing *k)
{
    struct gp_splat *const s = k->s;
    const int w = k->req->src->w, h = k->req->src->h;
    const int field_w = ceil_div(w, ceil_div(w, k->field_side));
    const int field_h = ceil_div(h, ceil_div(h, k->field_side));
    const int targets = k->layout->polygons.n > k->layout->chunk ? 2 : 1;
    gp_status st = GP_OK;
    for (int i = 0; !st && i < targets; i++) {
        struct gp_target *const t = i ? &s->chunk : &s->total;
        if (t->colour.w == field_w && t->colour.h == field_h)
            continue;
        gp_target_free(s->gl, t);
        st = gp_target_make(k->req->log, s->gl, "layer", GP_TEXEL_FLOAT, 1,
                            field_w, field_h, t);
    }
    for (int y = 0; !st && y < h; y += field_h) {
        for (int x = 0; !st && x < w; x += field_w) {
            k->field = (struct gp_rect) {x, y, gp_min(x + field_w, w),
                                         gp_min(y + field_h, h)};
            st = draw_field(k);
        }
    }
    return st;
}

/* -- the whole ------------------------------------------------------------- */

static unsigned blurs_of(const struct gp_polygon *at, size_t n)
{
    unsigned used = 0;
    for (size_t i = 0; i < n; i++)
        used |= 1u << at[i].blur;
    return used;
}

gp_status gp_splat_draw(const struct gp_glare_request *req, struct gp_splat *s)
{
    const struct gp_splat_layout *const p = &s->layout;
    const struct gp_polygons *const q = &p->polygons;
    const struct gp_gl_info *const gl = gp_gl_info(s->gl);
    const int span = gp_max(p->params.cluster, p->params.group);
    const int more = p->single ? 0 : span / 2 + 1; // half a box, and bilinear
    struct drawing k = {
        .req = req, .s = s, .layout = p, .span = span,
        .patch_side = gp_min(gl->max_size, FIELD_MAX),
        .meets = {p->crop.x0 - req->kernel->cx - more,
                  p->crop.y0 - req->kernel->cy - more,
                  p->crop.x1 - req->kernel->cx + more,
                  p->crop.y1 - req->kernel->cy + more},
        .group_blurs = blurs_of(q->at + q->clusters, q->groups),
        .cluster_blurs = blurs_of(q->at, q->clusters),
    };
    // the view's reach beyond a field, so that no polygon that meets
    // it is clipped. Quads on whole pixels are cut by the vertex shader; turned
    // ones, whose kernel would need too large a view, are not turned there
    if (p->turned) { // to the farthest corner of a quad
        const struct gp_unturned *const u = req->kernel->unturned;
        const double x = fmax(u->cx, u->w - u->cx);
        const double y = fmax(u->cy, u->h - u->cy);
        const int radius = (int) fmin(hypot(x + 2.0, y + 2.0), FAR) + 1;
        k.turned = radius <= TURNED_MAX &&
                   gl->max_size - 2 * radius >= k.patch_side / 2;
        k.margin = k.turned ? radius : 0;
    }
    k.field_side = gp_min(k.patch_side, gl->max_size - 2 * k.margin);
    if (k.patch_side / span < 1 || k.field_side < 1)
        return gp_fail_bare_at(req->log, GP_ERR_GL, "layer.engine",
                               "%s: groups of %d do not fit into a texture (the "
                               "limit is %d pixels)", gl->name, span,
                               k.patch_side);
    float reach[GP_SOURCE_BINS];
    gp_status st = GP_OK;
    if (!s->reaches.id)
        st = gp_buffer_make(req->log, s->gl, "reaches", GP_BUFFER_BLOCK,
                            GP_SOURCE_BINS / 4, &s->reaches);
    if (st)
        return st;
    for (int i = 0; i < GP_SOURCE_BINS; i++)
        reach[i] = (float) reach_of(p, gp_source_bin_start(i));
    gp_buffer_write(s->gl, &s->reaches, 0, GP_SOURCE_BINS / 4, reach);
    set_kernel(s, req->kernel, p->crop, p->core);
    return draw_fields(&k);
}
