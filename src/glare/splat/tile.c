// SPDX-License-Identifier: Apache-2.0
/* Polygons gathered per tile. The frame is cut into fields, a field into
 * tiles; a batch lists the polygons that reach each tile, and one fragment pass
 * over the field walks it (shaders/tile.frag), once for each blur.
 *
 * A fragment is 4x2 pixels: six attachments hold the two rows of each plane,
 * and what a polygon costs beside its samples is paid once for eight pixels. A
 * texel of a grey kernel holds four samples of a row, so that a fragment loads
 * two texels a row and takes its samples from them. Loads that would filter
 * (GL_LINEAR) are slower, and their weights are the driver's. */
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/splat/splat_priv.h"

#include <math.h>
#include <string.h>

/* Sizes, chosen so that a batch holds a thousand polygons of any size:
 * gp_tiles_roundings() counts on it. */
enum {
    FIELD = 1024, // widest and highest part of the frame, pixels
    LOW_SIDE = 4, // log2 of 16 pixels: what llvmpipe shades at a time
    SIDES = 3,    // tiles are 16, 32 or 64 pixels wide and high
    TILES_MAX = (FIELD >> LOW_SIDE) * (FIELD >> LOW_SIDE),
    BATCH = 1000, // polygons, at least, when not all are in it
    ENTRY = 2,    // texels
    // entries a polygon, on average, that a kind may have: what a field of
    // the largest tiles has at most
    ENTRIES_MAX = (FIELD >> 6) * (FIELD >> 6),
    FRAGMENT_W = 4, FRAGMENT_H = 2, // pixels
    ATTACHMENTS = 3 * FRAGMENT_H,
    MIXING = 7,   // roundings of a share: light, and three for each of two
                  // mixes
};
/* Milliseconds of a pixel of a tile's entry, and of the entry itself, on Mesa
 * 22.3's llvmpipe and two cores. */
static const double PIXEL_MS = 1.3e-6, ENTRY_MS = 1e-4;

/* A batch that is full leaves less than TILES_MAX entries free. */
_Static_assert((GP_SPLAT_TEXELS - TILES_MAX) / ENTRY - TILES_MAX >=
                   BATCH * ENTRIES_MAX, "a batch holds too little");

/* -- pieces ---------------------------------------------------------------- */

/* Polygons that one program and one kernel texture can draw together. Kind 0
 * is on whole pixels and has blur 0, so that samples are not mixed; kind
 * 1 + b has blur b. */
enum { KINDS = GP_BLURS + 1 };

/* A polygon that reaches the frame. */
struct piece {
    struct gp_rect box; // the frame's pixels that it draws; not empty
    size_t polygon;     // index
};

struct pieces {
    struct piece *at;        // within a kind in the polygons' order
    size_t first[KINDS + 1]; // kind k: pieces [first[k], first[k + 1])
    double cx[GP_BLURS], cy[GP_BLURS]; // centre of each blur, in its samples
};

static int kind_of(const struct gp_polygon *g)
{
    bool whole = g->blur == 0 && floorf(g->x) == g->x && floorf(g->y) == g->y;
    return whole ? 0 : 1 + g->blur;
}

/* Pixels of [0, limit) on one axis, half-open: those between the samples
 * before the first and after the last, both 0, and within the reach. */
static void find_span(double at, double centre, int samples, int reach,
                      int limit, int *first, int *end)
{
    const double low = fmax(floor(at - centre - 1.0) + 1.0, ceil(at - reach));
    const double high = fmin(ceil(at - centre + samples),
                             floor(at + reach) + 1.0);
    *first = (int) fmin(fmax(low, 0.0), limit);
    *end = (int) fmin(fmax(high, 0.0), limit);
}

/* The pixels that a polygon draws: those that its blurred kernel covers and its
 * reach does not cut, inside the frame. */
static struct gp_rect box_of(const struct pieces *p,
    const struct gp_splat_layout *l, const struct gp_sources *frame,
    const struct gp_polygon *g)
{
    const int reach = l->shrink.reach[gp_source_bin(g->light)];
    const int more = gp_blur_box[g->blur] - 1;
    struct gp_rect box;
    find_span((double) g->x, p->cx[g->blur], gp_rect_w(l->crop) + more, reach,
              frame->w, &box.x0, &box.x1);
    find_span((double) g->y, p->cy[g->blur], gp_rect_h(l->crop) + more, reach,
              frame->h, &box.y0, &box.y1);
    return box;
}

static gp_status make_pieces(const struct gp_glare_request *req,
                             const struct gp_splat_layout *l,
                             struct pieces *out)
{
    const struct gp_polygons *const polygons = &l->polygons;
    struct pieces p = {0};
    size_t to[KINDS];
    for (int b = 0; b < GP_BLURS; b++) {
        const double more = 0.5 * (gp_blur_box[b] - 1);
        p.cx[b] = (double) req->kernel->cx - l->crop.x0 + more;
        p.cy[b] = (double) req->kernel->cy - l->crop.y0 + more;
    }
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const g = &polygons->at[i];
        if (!gp_rect_empty(box_of(&p, l, req->src, g)))
            p.first[kind_of(g) + 1]++;
    }
    for (int k = 0; k < KINDS; k++)
        p.first[k + 1] += p.first[k];
    gp_status st = gp_alloc(req->log, "polygons of tiles", p.first[KINDS] + 1,
                            sizeof *p.at, &p.at);
    if (st)
        return st;
    memcpy(to, p.first, sizeof to);
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const g = &polygons->at[i];
        const struct gp_rect box = box_of(&p, l, req->src, g);
        if (!gp_rect_empty(box))
            p.at[to[kind_of(g)]++] = (struct piece) {box, i};
    }
    *out = p;
    return GP_OK;
}

/* -- tiles ----------------------------------------------------------------- */

/* Tiles that a box of the frame touches; empty where it leaves the field. */
static struct gp_rect tiles_of(struct gp_rect box, struct gp_rect field,
                               int side)
{
    struct gp_rect b = gp_rect_meet(box, field);
    if (gp_rect_empty(b))
        return (struct gp_rect) {0};
    return (struct gp_rect) {
        (b.x0 - field.x0) >> side, (b.y0 - field.y0) >> side,
        ((b.x1 - 1 - field.x0) >> side) + 1,
        ((b.y1 - 1 - field.y0) >> side) + 1,
    };
}

/* The side of tiles with which the kind's pieces cost least in the field. */
static int choose_side(const struct pieces *p, int kind, struct gp_rect field)
{
    double entries[SIDES] = {0}, polygons = 0.0;
    for (size_t i = p->first[kind]; i < p->first[kind + 1]; i++) {
        if (gp_rect_empty(gp_rect_meet(p->at[i].box, field)))
            continue;
        polygons += 1.0;
        for (int s = 0; s < SIDES; s++) {
            const struct gp_rect t = tiles_of(p->at[i].box, field,
                                              LOW_SIDE + s);
            entries[s] += gp_rect_w(t) * gp_rect_h(t);
        }
    }
    int best = SIDES - 1;
    double least = INFINITY;
    for (int s = SIDES - 1; s >= 0; s--) {
        double pixels = (double) (1 << 2 * (LOW_SIDE + s));
        double ms = entries[s] * (PIXEL_MS * pixels + ENTRY_MS);
        if (ms < least && entries[s] <= ENTRIES_MAX * polygons) {
            least = ms;
            best = s;
        }
    }
    return LOW_SIDE + best;
}

/* -- batches --------------------------------------------------------------- */

/* Packs the part of [first, end) that the tile at `at` has, for tile.frag. */
static int pack_span(int first, int end, int at, int side)
{
    const int last = (1 << side) - 1;
    return gp_max(first - at, 0) + 64 * gp_min(end - 1 - at, last);
}

/* Some of a kind's pieces, entered for the tiles of a field that they reach. */
struct batch {
    struct gp_rect field; // in: pixels of the frame, up to FIELD
    int side;             // in: log2 of a tile's pixels, 4 to 6
    int across;           // out: tiles in a row
    struct gp_rect lit;   // out: box of the tiles with polygons, in tiles
    int most;             // out: polygons of the fullest tile; 0: none left
    int texels;           // out: in use
    float *texel;         // GP_SPLAT_TEXELS; borrowed
};

/* Enters pieces of the kind from *next on, as many as fit, and moves *next
 * after them. */
static void enter(const struct gp_polygons *polygons, const struct pieces *p,
                  int kind, size_t *next, struct batch *batch)
{
    int in_tile[TILES_MAX];
    const struct gp_rect field = batch->field;
    const int side = batch->side, last = (1 << side) - 1;
    const int across = (gp_rect_w(field) + last) >> side;
    const int tiles = across * ((gp_rect_h(field) + last) >> side);
    // the entries of each tile, for as many pieces as fit
    int entries = 0, room = (GP_SPLAT_TEXELS - tiles) / ENTRY;
    memset(in_tile, 0, (size_t) tiles * sizeof in_tile[0]);
    struct gp_rect lit = {across, tiles, 0, 0};
    size_t end = *next;
    for (; end < p->first[kind + 1]; end++) {
        const struct gp_rect t = tiles_of(p->at[end].box, field, side);
        const int n = gp_rect_w(t) * gp_rect_h(t);
        if (entries + n > room)
            break;
        entries += n;
        for (int y = t.y0; y < t.y1; y++) {
            for (int x = t.x0; x < t.x1; x++)
                in_tile[y * across + x]++;
        }
        if (n > 0)
            lit = (struct gp_rect) {gp_min(t.x0, lit.x0), gp_min(t.y0, lit.y0),
                                    gp_max(t.x1, lit.x1), gp_max(t.y1, lit.y1)};
    }
    batch->across = across;
    batch->lit = lit;
    batch->texels = tiles;
    batch->most = 0;
    for (int t = 0; t < tiles; t++) { // each tile's range comes first
        const int n = in_tile[t];
        in_tile[t] = batch->texels; // place of its next entry
        batch->texels += ENTRY * n;
        batch->most = gp_max(batch->most, n);
        float *texel = batch->texel + 4 * t;
        texel[0] = (float) in_tile[t];
        texel[1] = (float) batch->texels;
        texel[2] = texel[3] = 0.0f;
    }
    for (; *next < end; ++*next) { // then the polygon's entry in each
        const struct gp_rect box = p->at[*next].box;
        const struct gp_rect t = tiles_of(box, field, side);
        const struct gp_polygon *const g =
            &polygons->at[p->at[*next].polygon];
        const double x = p->cx[g->blur] - (double) g->x, left = floor(x);
        const double y = p->cy[g->blur] - (double) g->y, top = floor(y);
        for (int row = t.y0; row < t.y1; row++) {
            const int py = field.y0 + (row << side);
            const int rows = pack_span(box.y0, box.y1, py, side);
            for (int column = t.x0; column < t.x1; column++) {
                const int px = field.x0 + (column << side);
                int *const to = &in_tile[row * across + column];
                float *const e = batch->texel + 4 * (size_t) *to;
                *to += ENTRY;
                memcpy(e, g->rgb, sizeof g->rgb);
                e[3] = (float) (x - left);
                e[4] = (float) (y - top);
                e[5] = (float) (left + px);
                e[6] = (float) (top + py);
                e[7] = (float) (pack_span(box.x0, box.x1, px, side) +
                                4096 * rows);
            }
        }
    }
}

/* Polygons of an inner sum, for a tile with `most` of them: about the square
 * root, so that a pixel takes the fewest roundings. */
static int inner_sum(size_t most)
{
    return gp_max((int) ceil(sqrt((double) most)), 8);
}

/* -- drawing --------------------------------------------------------------- */

struct gathering {
    const struct gp_glare_request *req;
    struct gp_splat *s;
    const struct gp_splat_layout *layout;
    struct pieces pieces;
    struct gp_rect field;
};

/* Draws the pieces of one kind that reach the field. */
static gp_status draw_kind(const struct gathering *k, int kind)
{
    static const char *const defines[] = {
        "", "#define COLOUR\n", "#define WHOLE\n",
        "#define WHOLE\n#define COLOUR\n",
    };
    gp_status st = GP_OK;
    struct gp_splat *const s = k->s;
    const struct gp_log *const log = k->req->log;
    const int blur = kind > 0 ? kind - 1 : 0;
    const size_t end = k->pieces.first[kind + 1];
    size_t next = k->pieces.first[kind];
    if (next == end)
        return GP_OK;
    GP_TRY(gp_splat_need_kernel(log, s, k->req->kernel, blur));
    const struct gp_splat_kernel *const kernel = &s->kernel[blur];
    const int variant = 2 * (kind == 0) + !kernel->grey;
    struct gp_program *const p = &s->tile[variant];
    GP_TRY(gp_program_make(log, s->gl, defines[variant], "add.vert",
                           "tile.frag", p));
    struct batch batch = {
        .field = k->field, .texel = s->texel,
        .side = choose_side(&k->pieces, kind, k->field),
    };
    // log2 of a tile's fragments
    const int columns = batch.side - 2, rows = batch.side - 1;
    while (next < end) {
        enter(&k->layout->polygons, &k->pieces, kind, &next, &batch);
        if (batch.most == 0)
            break;
        const struct gp_uniform uniform[] = {
            {.name = "list", .image = &s->entries.texture},
            {.name = "tile", .v = {columns, rows}},
            {.name = "sums",
             .v = {batch.across, 2 * inner_sum((size_t) batch.most)}},
            {.name = "kernel", .image = &kernel->texture},
            {0},
        };
        const struct gp_draw draw = {
            .program = p, .target = &s->field,
            .cut = {batch.lit.x0 << columns, batch.lit.y0 << rows,
                    batch.lit.x1 << columns, batch.lit.y1 << rows},
            .uniform = uniform, .vertices = 3, .instances = 1,
        };
        gp_buffer_write(s->gl, &s->entries, 0, batch.texels, batch.texel);
        GP_TRY(gp_draw_run(log, s->gl, &draw));
    }
out:
    return st;
}

static gp_status draw_field(struct gathering *k)
{
    struct gp_splat *const s = k->s;
    struct gp_planes *const layer = k->req->layer;
    const size_t pitch = (size_t) k->req->src->w;
    const struct gp_rect f = k->field;
    const int w = (gp_rect_w(f) + FRAGMENT_W - 1) / FRAGMENT_W;
    const int h = (gp_rect_h(f) + FRAGMENT_H - 1) / FRAGMENT_H;
    gp_status st = gp_splat_need_target(k->req->log, s, "layer", ATTACHMENTS,
                                        w, h, &s->field);
    for (int kind = 0; !st && kind < KINDS; kind++)
        st = draw_kind(k, kind);
    for (int i = 0; i < ATTACHMENTS && !st; i++) {
        // an attachment holds every other row of a plane
        const int lower = i % FRAGMENT_H;
        const int rows = (gp_rect_h(f) + FRAGMENT_H - 1 - lower) / FRAGMENT_H;
        if (rows < 1)
            continue;
        gp_target_read(s->gl, &s->field, i, (struct gp_rect) {0, 0, w, rows},
                       s->texel);
        for (int y = 0; y < rows; y++)
            memcpy(layer->c[i / FRAGMENT_H] +
                       (size_t) (f.y0 + FRAGMENT_H * y + lower) * pitch + f.x0,
                   s->texel + 4 * (size_t) y * (size_t) w,
                   (size_t) gp_rect_w(f) * sizeof(float));
    }
    return st ? st
              : gp_gl_check(k->req->log, s->gl, "gathering glare polygons");
}

/* The length of the fewest equal fields of `most` fragments and at most
 * FIELD pixels, whole fragments. */
static int field_size(int size, int most, int fragment)
{
    const int limit = most < FIELD / fragment ? most * fragment : FIELD;
    const int fields = (size - 1) / limit + 1;
    const int length = (size - 1) / fields + 1;
    return (length + fragment - 1) / fragment * fragment;
}

gp_status gp_tiles_draw(const struct gp_glare_request *req, struct gp_splat *s,
                        const struct gp_splat_layout *layout)
{
    gp_status st;
    struct gathering k = {.req = req, .s = s, .layout = layout};
    const int w = req->src->w, h = req->src->h;
    const int most = gp_gl_info(s->gl)->max_size;
    const int field_w = field_size(w, most, FRAGMENT_W);
    const int field_h = field_size(h, most, FRAGMENT_H);
    if (!s->entries.id)
        GP_TRY(gp_buffer_make(req->log, s->gl, "lists of tiles",
                              GP_BUFFER_TEXELS, GP_SPLAT_TEXELS, &s->entries));
    GP_TRY(make_pieces(req, layout, &k.pieces));
    for (int y = 0; y < h; y += field_h) {
        for (int x = 0; x < w; x += field_w) {
            k.field = gp_rect_meet((struct gp_rect) {0, 0, w, h},
                (struct gp_rect) {x, y, x + field_w, y + field_h});
            GP_TRY(draw_field(&k));
        }
    }
out:
    gp_free(k.pieces.at);
    return st;
}

double gp_tiles_roundings(const struct gp_polygons *polygons)
{
    size_t n[GP_BLURS] = {0}, most = 0;
    for (size_t i = 0; i < polygons->n; i++)
        n[polygons->at[i].blur]++;
    double draws = 1.0; // blur 0 may be two kinds
    for (int b = 0; b < GP_BLURS; b++) {
        most = n[b] > most ? n[b] : most;
        if (n[b] > 0)
            draws += 1.0 + (double) n[b] / BATCH;
    }
    double inner = inner_sum(most);
    return MIXING + inner + ceil((double) most / inner) + draws;
}
