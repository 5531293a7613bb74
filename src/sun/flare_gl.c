/* Flare elements as instanced quads, one draw a shape and one an image. */
#include "sun/flare_state.h"

#include "core/memory.h"
#include "gl/program.h"

enum {
    TILE_MAX = 4096, // pixels of a target's side: 256 MiB
    BAND = 32,       // rows that are cleared and read at a time
};

static const char *const defines[GP_FLARE_PROGRAMS] = {
    "#define ROUND\n", "#define POLYGON\n", "#define STREAK\n",
    "#define IMAGE\n", "#define PLAIN\n",
};

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
                            const struct gp_flare_batch *b, struct gp_rect tile)
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
        const struct gp_rect band = gp_flare_in(band_of(s, tile, y), tile);
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
    const int limit = gp_gl_max_size(gl);
    const int most = limit < TILE_MAX ? limit : TILE_MAX;
    const int w = gp_rect_w(s->reach) < most ? gp_rect_w(s->reach) : most;
    const int h = gp_rect_h(s->reach) < most ? gp_rect_h(s->reach) : most;
    const struct gp_texture had = s->target.colour;
    s->tile = (struct gp_rect) {s->reach.x0, s->reach.y0, s->reach.x0 + w,
                                s->reach.y0 + h};
    if (had.w >= w && had.h >= h)
        return GP_OK;
    gp_target_free(gl, &s->target);
    return gp_target_make(log, gl, "a lens flare", had.w > w ? had.w : w,
                          had.h > h ? had.h : h, &s->target);
}

static gp_status fit_programs(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_flare_gl *s)
{
    gp_status st = GP_OK;
    for (int i = 0; !st && i < s->batches; i++) {
        const enum gp_flare_program p = s->batch[i].program;
        if (!s->program[p].id)
            st = gp_program_make_as(log, gl, defines[p], "flare.vert",
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
    gp_flare_items_free(&s->items);
    s->intensity = *intensity;
    GP_TRY(gp_flare_items_make(log, f, light, n, false, frame, display,
                               &s->items));
    if (s->items.n == 0)
        return GP_OK;
    s->reach = s->items.at[0].rect;
    for (int i = 1; i < s->items.n; i++)
        s->reach = join(s->reach, s->items.at[i].rect);
    GP_TRY(fit_target(log, gl, s));
    GP_TRY(gp_flare_upload(log, gl, s));
    GP_TRY(fit_programs(log, gl, s));
    GP_TRY(draw_tile(log, gl, s, s->tile));
out:
    if (st)
        gp_flare_items_free(&s->items);
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
        gp_target_read(gl, &s->target, gp_flare_in(band, tile), rgba);
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
    gp_flare_free_slots(gl, &s->slot, &s->slots);
    gp_flare_items_free(&s->items);
    gp_free(s->batch);
    GP_FREE(*state);
}
