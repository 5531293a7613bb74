/* Flare elements as instanced quads, one draw a shape and one an image. */
#include "sun/sun_priv.h"

#include "core/memory.h"
#include "gl/gl.h"

#include <string.h>

/* One flare.frag each; images at their own pixels are PLAIN. */
enum gp_flare_program {
    GP_FLARE_DRAW_ROUND, GP_FLARE_DRAW_POLYGON, GP_FLARE_DRAW_STREAK,
    GP_FLARE_DRAW_IMAGE, GP_FLARE_DRAW_PLAIN, GP_FLARE_PROGRAMS,
};

/* An image on the context, in a border of one texel of 0. */
struct image_slot {
    unsigned long serial;
    int level;
    struct gp_texture texture;
};

/* Items that one draw draws: one shape's, or one image's. */
struct batch {
    enum gp_flare_program program;
    int first, n; // in the items' texture
    int item;     // one of them, in the list
    int slot;     // of its image
};

struct gp_flare_gl {
    struct gp_program program[GP_FLARE_PROGRAMS];
    struct gp_target target;
    struct gp_texture texels, edges, intensity; // intensity is borrowed
    struct image_slot *slot;    // owned
    struct batch *batch;  // owned
    int slots, batches;
    struct gp_flare_quads items;   // of the last draw
    struct gp_rect reach;          // of all of them, frame's pixels
    struct gp_rect tile;           // the first, which the last draw left in
                                   // target
};

/* r from the corner of `tile` on. */
static inline struct gp_rect rect_within(struct gp_rect r, struct gp_rect tile)
{
    return (struct gp_rect) {r.x0 - tile.x0, r.y0 - tile.y0, r.x1 - tile.x0,
                             r.y1 - tile.y0};
}

enum {
    TILE_MAX = 4096, // pixels of a target's side: 256 MiB
    BAND = 32,       // rows that are cleared and read at a time
};

static const char *const defines[GP_FLARE_PROGRAMS] = {
    "#define ROUND\n", "#define POLYGON\n", "#define STREAK\n",
    "#define IMAGE\n", "#define PLAIN\n",
};

enum { TEXELS = 5 }; // of an item; the same as in flare.vert

/* -- images ---------------------------------------------------------------- */

static gp_status upload_image(const struct gp_log *log, const struct gp_gl *gl,
                              const struct gp_flare_image *m,
                              struct gp_texture *out)
{
    const int w = m->w + 2, h = m->h + 2;
    void *block;
    gp_status st =
        gp_texture_make(log, gl, "a flare image", GP_TEXEL_FLOAT, w, h, out);
    if (st)
        return st;
    st = gp_alloc_zero(log, "a flare image", (size_t) w * (size_t) h,
                       4 * sizeof(float), &block);
    if (st)
        return st;
    float *const rgba = block;
    for (int y = 0; y < m->h; y++) {
        for (int x = 0; x < m->w; x++) {
            const size_t from = (size_t) y * (size_t) m->w + (size_t) x;
            float *const to = rgba + 4 * ((size_t) (y + 1) * (size_t) w +
                                          (size_t) (x + 1));
            for (int c = 0; c < 3; c++)
                to[c] = m->rgb.c[c][from];
        }
    }
    gp_texture_write(gl, out, (struct gp_rect) {0, 0, w, h}, rgba);
    gp_free(block);
    return GP_OK;
}

/* Fills *slot with the image, from what an earlier draw left where it can. */
static gp_status find_image(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s,
                            const struct gp_flare_level *l,
                            struct image_slot *slot)
{
    const unsigned long serial = l->image.serial;
    for (int i = 0; serial && i < s->slots; i++) {
        if (s->slot[i].serial != serial || s->slot[i].level != l->level ||
            !s->slot[i].texture.id)
            continue;
        *slot = s->slot[i];
        s->slot[i] = (struct image_slot) {0};
        return GP_OK;
    }
    slot->serial = serial;
    slot->level = l->level;
    return upload_image(log, gl, &l->image, &slot->texture);
}

static void free_slots(const struct gp_gl *gl, struct image_slot **slot,
                       int *n)
{
    for (int i = 0; i < *n; i++)
        gp_texture_free(gl, &(*slot)[i].texture);
    GP_FREE(*slot);
    *n = 0;
}

/* A slot for each batch of an image; those that none uses any more go. */
static gp_status fit_images(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    void *block;
    int n = 0;
    gp_status st = gp_alloc_zero(log, "flare images", (size_t) s->batches,
                                 sizeof *s->slot, &block);
    if (st)
        return st;
    struct image_slot *const slot = block;
    for (int i = 0; !st && i < s->batches; i++) {
        const struct gp_flare_quad *const item =
            &s->items.at[s->batch[i].item];
        if (!item->image)
            continue;
        s->batch[i].slot = n;
        st = find_image(log, gl, s, &s->items.level[item->element],
                        &slot[n++]);
    }
    free_slots(gl, &s->slot, &s->slots);
    s->slot = slot;
    s->slots = n;
    return st;
}

/* -- items ----------------------------------------------------------------- */

static enum gp_flare_program program_of(const struct gp_flare_quad *i)
{
    switch (i->shape) {
    case GP_FLARE_POLYGON:
        return GP_FLARE_DRAW_POLYGON;
    case GP_FLARE_STREAK:
        return GP_FLARE_DRAW_STREAK;
    case GP_FLARE_IMAGE:
        return i->plain ? GP_FLARE_DRAW_PLAIN : GP_FLARE_DRAW_IMAGE;
    default:
        return GP_FLARE_DRAW_ROUND;
    }
}

enum { FIRST_IMAGE = GP_FLARE_DRAW_IMAGE };

/* Items of one draw have one key: a shape's, or an image's own. */
static int key_of(const struct gp_flare_quad *i)
{
    return i->image ? FIRST_IMAGE + i->element : (int) program_of(i);
}

static void put_item(const struct gp_flare_quad *i, struct gp_rect reach,
                     float t[4 * TEXELS])
{
    const struct gp_rect r = rect_within(i->rect, reach);
    const float whole[4] = {(float) r.x0, (float) r.y0, (float) r.x1,
                            (float) r.y1};
    memcpy(t, whole, sizeof whole);
    memcpy(t + 4, i->base, sizeof i->base);
    memcpy(t + 6, i->turn, sizeof i->turn);
    memcpy(t + 8, i->radius, sizeof i->radius);
    t[11] = (float) i->light;
    memcpy(t + 12, i->inner, sizeof i->inner);
    t[15] = (float) i->sides;
    memcpy(t + 16, i->amount, sizeof i->amount);
    t[19] = (float) i->element;
    for (int k = 0; k < 2 && i->plain; k++) {
        t[8 + k] = (float) (i->corner[k] + 1); // the border
        t[12 + k] = i->fraction[k];
    }
}

/* One batch a key; start[k] becomes the first of key k in the texture. */
static gp_status make_batches(const struct gp_log *log, struct gp_flare_gl *s,
                              int *start, int *item)
{
    const int keys = FIRST_IMAGE + s->items.elements;
    void *block;
    gp_status st = gp_alloc_zero(log, "flare draws", (size_t) keys,
                                 sizeof *s->batch, &block);
    if (st)
        return st;
    gp_free(s->batch);
    s->batch = block;
    s->batches = 0;
    for (int i = 0; i < s->items.n; i++) {
        const int key = key_of(&s->items.at[i]);
        start[key + 1]++;
        item[key] = i;
    }
    for (int k = 0; k < keys; k++) {
        const int n = start[k + 1];
        start[k + 1] += start[k];
        if (n > 0)
            s->batch[s->batches++] = (struct batch) {
                .program = program_of(&s->items.at[item[k]]),
                .first = start[k], .n = n, .item = item[k],
            };
    }
    return GP_OK;
}

static gp_status fit_texels(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    const int most = gp_gl_info(gl)->max_size, n = s->items.n;
    const int rows = n < most ? n : most;
    if (s->texels.w / TEXELS * s->texels.h >= n)
        return GP_OK;
    gp_texture_free(gl, &s->texels);
    return gp_texture_make(log, gl, "flare elements", GP_TEXEL_FLOAT,
                           (n + rows - 1) / rows * TEXELS, rows, &s->texels);
}

static gp_status upload_items(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_flare_gl *s, int *start)
{
    void *block;
    gp_status st = fit_texels(log, gl, s);
    const int w = s->texels.w, h = s->texels.h;
    if (!st)
        st = gp_alloc_zero(log, "flare elements", (size_t) w * (size_t) h,
                           4 * sizeof(float), &block);
    if (st)
        return st;
    for (int i = 0; i < s->items.n; i++) {
        const struct gp_flare_quad *const item = &s->items.at[i];
        const int at = start[key_of(item)]++;
        const size_t texel = (size_t) (at % h) * (size_t) w +
                             (size_t) (at / h * TEXELS);
        put_item(item, s->reach, (float *) block + 4 * texel);
    }
    gp_texture_write(gl, &s->texels, (struct gp_rect) {0, 0, w, h}, block);
    gp_free(block);
    return GP_OK;
}

static gp_status upload_edges(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_flare_gl *s)
{
    const int rows = s->items.elements;
    void *block;
    gp_status st = GP_OK;
    if (s->edges.h < rows) {
        gp_texture_free(gl, &s->edges);
        st = gp_texture_make(log, gl, "flare polygons", GP_TEXEL_FLOAT,
                             GP_FLARE_SIDES, rows, &s->edges);
    }
    if (!st)
        st = gp_alloc_zero(log, "flare polygons", (size_t) rows,
                           4 * GP_FLARE_SIDES * sizeof(float), &block);
    if (st)
        return st;
    for (int i = 0; i < rows * GP_FLARE_SIDES; i++)
        memcpy((float *) block + 4 * i, s->items.edge + 3 * i,
               3 * sizeof(float));
    gp_texture_write(gl, &s->edges,
                     (struct gp_rect) {0, 0, GP_FLARE_SIDES, rows}, block);
    gp_free(block);
    return GP_OK;
}

static gp_status send_quads(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    const size_t keys = (size_t) (FIRST_IMAGE + s->items.elements) + 1;
    void *block;
    gp_status st = gp_alloc_zero(log, "flare draws", 2 * keys, sizeof(int),
                                 &block);
    if (st)
        return st;
    int *const start = block;
    st = make_batches(log, s, start, start + keys);
    if (!st)
        st = fit_images(log, gl, s);
    if (!st)
        st = upload_items(log, gl, s, start);
    for (int i = 0; !st && i < s->batches; i++) {
        if (s->batch[i].program == GP_FLARE_DRAW_POLYGON)
            st = upload_edges(log, gl, s);
    }
    gp_free(block);
    return st;
}

/* -- tiles and bands ------------------------------------------------------- */

static struct gp_rect join(struct gp_rect a, struct gp_rect b)
{
    return (struct gp_rect) {
        a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
        a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1,
    };
}

/* The next tile after t in row order; false after the last. */
static bool next_tile(const struct gp_flare_gl *s, struct gp_rect *t)
{
    const int w = gp_rect_w(s->tile), h = gp_rect_h(s->tile);
    struct gp_rect next = {t->x1, t->y0, 0, 0};
    if (next.x0 >= s->reach.x1) {
        next.x0 = s->reach.x0;
        next.y0 = t->y1;
    }
    next.x1 = s->reach.x1 - next.x0 < w ? s->reach.x1 : next.x0 + w;
    next.y1 = s->reach.y1 - next.y0 < h ? s->reach.y1 : next.y0 + h;
    *t = next;
    return next.y0 < s->reach.y1;
}

/* The pixels that are reached among the rows of a tile from y0 on. */
static struct gp_rect band_of(const struct gp_flare_gl *s,
                              struct gp_rect tile, int y0)
{
    const int y1 = tile.y1 - y0 < BAND ? tile.y1 : y0 + BAND;
    struct gp_rect band = {tile.x1, y0, tile.x0, y1};
    for (int i = 0; i < s->items.n; i++) {
        int x0, x1;
        if (!gp_flare_span(&s->items.at[i], y0, y1, &x0, &x1))
            continue;
        band.x0 = x0 < band.x0 ? x0 : band.x0;
        band.x1 = x1 > band.x1 ? x1 : band.x1;
    }
    return gp_rect_meet(band, tile);
}

/* -- drawing --------------------------------------------------------------- */

static gp_status draw_batch(const struct gp_log *log, const struct gp_gl *gl,
                            const struct gp_flare_gl *s,
                            const struct batch *b, struct gp_rect tile)
{
    const struct gp_texture *const to = &s->target.colour;
    struct gp_uniform uniform[] = {
        {.name = "items", .texture = &s->texels},
        {.name = "intensity", .texture = &s->intensity},
        {.name = "first", .v = {b->first, 0}},
        {.name = "tile", .v = {tile.x0 - s->reach.x0, tile.y0 - s->reach.y0}},
        {.name = "size", .v = {to->w, to->h}},
        {0}, {0},
    };
    if (b->program == GP_FLARE_DRAW_POLYGON)
        uniform[5] = (struct gp_uniform) {.name = "edges",
                                          .texture = &s->edges};
    if (b->program == GP_FLARE_DRAW_IMAGE || b->program == GP_FLARE_DRAW_PLAIN)
        uniform[5] = (struct gp_uniform) {
            .name = "image", .texture = &s->slot[b->slot].texture};
    const struct gp_draw draw = {
        .program = &s->program[b->program], .target = &s->target,
        .cut = {0, 0, gp_rect_w(tile), gp_rect_h(tile)}, .uniform = uniform,
        .vertices = 6, .instances = b->n,
    };
    return gp_draw_run(log, gl, &draw);
}

static gp_status draw_tile(const struct gp_log *log, const struct gp_gl *gl,
                           const struct gp_flare_gl *s, struct gp_rect tile)
{
    gp_status st = GP_OK;
    for (int y = tile.y0; y < tile.y1; y += BAND) {
        const struct gp_rect band = rect_within(band_of(s, tile, y), tile);
        if (!gp_rect_empty(band))
            gp_target_clear(gl, &s->target, band);
    }
    for (int i = 0; !st && i < s->batches; i++)
        st = draw_batch(log, gl, s, &s->batch[i], tile);
    return st ? st : gp_gl_check(log, gl, "drawing a lens flare");
}

static gp_status fit_target(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    const int limit = gp_gl_info(gl)->max_size;
    const int most = limit < TILE_MAX ? limit : TILE_MAX;
    const int w = gp_rect_w(s->reach) < most ? gp_rect_w(s->reach) : most;
    const int h = gp_rect_h(s->reach) < most ? gp_rect_h(s->reach) : most;
    const struct gp_texture had = s->target.colour;
    s->tile = (struct gp_rect) {s->reach.x0, s->reach.y0, s->reach.x0 + w,
                                s->reach.y0 + h};
    if (had.w >= w && had.h >= h)
        return GP_OK;
    gp_target_free(gl, &s->target);
    return gp_target_make(log, gl, "a lens flare", GP_TEXEL_FLOAT, 1,
                          had.w > w ? had.w : w, had.h > h ? had.h : h,
                          &s->target);
}

static gp_status fit_programs(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_flare_gl *s)
{
    gp_status st = GP_OK;
    for (int i = 0; !st && i < s->batches; i++) {
        const enum gp_flare_program p = s->batch[i].program;
        if (!s->program[p].id)
            st = gp_program_make(log, gl, defines[p], "flare.vert",
                                    "flare.frag", &s->program[p]);
    }
    return st;
}

static gp_status make_state(const struct gp_log *log,
                            struct gp_flare_gl **state)
{
    void *block;
    if (*state)
        return GP_OK;
    const gp_status st = gp_alloc_zero(log, "the flare's state", 1,
                                       sizeof **state, &block);
    *state = st ? NULL : block;
    return st;
}

gp_status gp_flare_draw(const struct gp_log *log, const struct gp_gl *gl,
                        const struct gp_flare *f, const struct gp_light *light,
                        int n, const struct gp_texture *intensity,
                        struct gp_rect frame, struct gp_rect display,
                        struct gp_flare_gl **state)
{
    gp_status st = make_state(log, state);
    if (st)
        return st;
    struct gp_flare_gl *const s = *state;
    gp_flare_quads_free(&s->items);
    s->intensity = *intensity;
    GP_TRY(gp_flare_quads_make(log, f, light, n, false, frame, display,
                               &s->items));
    if (s->items.n == 0)
        return GP_OK;
    s->reach = s->items.at[0].rect;
    for (int i = 1; i < s->items.n; i++)
        s->reach = join(s->reach, s->items.at[i].rect);
    GP_TRY(fit_target(log, gl, s));
    GP_TRY(send_quads(log, gl, s));
    GP_TRY(fit_programs(log, gl, s));
    GP_TRY(draw_tile(log, gl, s, s->tile));
out:
    if (st)
        gp_flare_quads_free(&s->items);
    return st;
}

/* -- reading --------------------------------------------------------------- */

static void add_band(struct gp_rect band, struct gp_rect frame,
                     const float *rgba, struct gp_planes *layer)
{
    const int w = gp_rect_w(band);
    for (int y = band.y0; y < band.y1; y++, rgba += 4 * (size_t) w) {
        const size_t at = (size_t) (y - frame.y0) *
                              (size_t) gp_rect_w(frame) +
                          (size_t) (band.x0 - frame.x0);
        for (int c = 0; c < 3; c++) {
            float *const to = layer->c[c] + at;
            for (int x = 0; x < w; x++)
                to[x] += rgba[4 * x + c];
        }
    }
}

static void read_tile(const struct gp_gl *gl, const struct gp_flare_gl *s,
                      struct gp_rect tile, struct gp_rect frame, float *rgba,
                      struct gp_planes *layer)
{
    for (int y = tile.y0; y < tile.y1; y += BAND) {
        const struct gp_rect band = band_of(s, tile, y);
        if (gp_rect_empty(band))
            continue;
        gp_target_read(gl, &s->target, 0, rect_within(band, tile), rgba);
        add_band(band, frame, rgba, layer);
    }
}

gp_status gp_flare_read_layer(const struct gp_log *log, const struct gp_gl *gl,
                              const struct gp_flare_gl *s,
                              struct gp_rect frame, struct gp_planes *layer)
{
    if (!s || s->items.n == 0)
        return GP_OK;
    struct gp_rect tile = s->tile;
    void *block;
    gp_status st = gp_alloc(log, "a band of the lens flare",
                            (size_t) gp_rect_w(tile) * BAND, 4 * sizeof(float),
                            &block);
    if (st)
        return st;
    read_tile(gl, s, tile, frame, block, layer);
    while (!st && next_tile(s, &tile)) {
        st = draw_tile(log, gl, s, tile);
        if (!st)
            read_tile(gl, s, tile, frame, block, layer);
    }
    gp_free(block);
    return st ? st : gp_gl_check(log, gl, "reading a lens flare");
}

void gp_flare_close(const struct gp_gl *gl, struct gp_flare_gl **state)
{
    struct gp_flare_gl *const s = *state;
    if (!s)
        return;
    for (int i = 0; i < GP_FLARE_PROGRAMS; i++)
        gp_program_free(gl, &s->program[i]);
    gp_target_free(gl, &s->target);
    gp_texture_free(gl, &s->texels);
    gp_texture_free(gl, &s->edges);
    free_slots(gl, &s->slot, &s->slots);
    gp_flare_quads_free(&s->items);
    gp_free(s->batch);
    GP_FREE(*state);
}
