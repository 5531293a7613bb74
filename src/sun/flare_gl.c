/* Images of flare elements on GL: instanced quads, one draw an image. */
#include "sun/sun_priv.h"

#include "core/memory.h"

#include <string.h>

enum {
    TEXELS = 5,      // of a quad in its texture; the same as in flare.vert
    FIELD_MAX = 4096, // pixels of a target's side: 256 MiB
    BAND = 32,       // rows that are cleared and read at a time
};

/* One flare.frag each; images at their own pixels are PLAIN. */
enum flare_program { DRAW_IMAGE, DRAW_PLAIN, PROGRAMS };

/* An image on the context, in a border of one texel of 0. */
struct image_slot {
    unsigned long serial;
    int level;
    struct gp_texture texture;
};

/* The quads of one draw: one element's. */
struct batch {
    enum flare_program program;
    int first, n; // in the quads' texture
    int quad;     // one of them, in the list
    int slot;     // of its image
};

struct gp_flare_gl {
    struct gp_program program[PROGRAMS];
    struct gp_target target;
    struct gp_texture texels, intensity; // intensity is borrowed
    struct image_slot *slot;       // owned
    struct batch *batch;           // owned
    int slots, batches;
    struct gp_flare_quads quads;   // of the last draw
    struct gp_rect reach;          // of all of them, frame's pixels
    struct gp_rect field;          // the first, which the last draw left in
                                   // target
};

/* r from the corner of `field` on. */
static struct gp_rect rect_within(struct gp_rect r, struct gp_rect field)
{
    return (struct gp_rect) {r.x0 - field.x0, r.y0 - field.y0, r.x1 - field.x0,
                             r.y1 - field.y0};
}

/* Makes `t` where it is not as large, and zeroed texels for all of it; what is
 * in them goes to the context by write_texels(). */
static gp_status make_texels(
    const struct gp_log *log, const struct gp_gl *gl, const char *what, int w,
    int h, struct gp_texture *t, float **rgba)
{
    gp_status st = GP_OK;
    if (t->w < w || t->h < h) {
        gp_texture_free(gl, t);
        st = gp_texture_make(log, gl, what, GP_TEXEL_FLOAT, w, h, t);
    }
    return st ? st : gp_alloc_zero(log, what, (size_t) t->w * (size_t) t->h,
                                   4 * sizeof(float), rgba);
}

static void write_texels(const struct gp_gl *gl, const struct gp_texture *t,
                         float *rgba)
{
    gp_texture_write(gl, t, (struct gp_rect) {0, 0, t->w, t->h}, rgba);
    gp_free(rgba);
}

static gp_status make_image(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_flare_image *m, struct gp_texture *out)
{
    float *rgba;
    const gp_status st = make_texels(log, gl, "a flare image", m->w + 2,
                                     m->h + 2, out, &rgba);
    if (st)
        return st;
    for (int y = 0; y < m->h; y++) {
        for (int x = 0; x < m->w; x++) {
            const size_t from = (size_t) y * (size_t) m->w + (size_t) x;
            float *const to = rgba + 4 * ((size_t) (y + 1) * (size_t) out->w +
                                          (size_t) (x + 1));
            for (int c = 0; c < 3; c++)
                to[c] = m->rgb.c[c][from];
        }
    }
    write_texels(gl, out, rgba);
    return GP_OK;
}

static void free_slots(const struct gp_gl *gl, struct gp_flare_gl *s)
{
    for (int i = 0; i < s->slots; i++)
        gp_texture_free(gl, &s->slot[i].texture);
    GP_FREE(s->slot);
    s->slots = 0;
}

/* Gives each batch of an image a slot, that of an earlier draw where it has
 * one; frees slots that no batch uses. */
static gp_status fit_images(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    struct image_slot *slot;
    int n = 0;
    gp_status st = gp_alloc_zero(log, "flare images", (size_t) s->batches,
                                 sizeof *slot, &slot);
    if (st)
        return st;
    for (int i = 0; !st && i < s->batches; i++) {
        const struct gp_flare_quad *const q = &s->quads.at[s->batch[i].quad];
        const struct gp_flare_level *const l = &s->quads.level[q->element];
        struct image_slot *to = &slot[n];
        s->batch[i].slot = n++;
        *to = (struct image_slot) {.serial = l->image.serial,
                                   .level = l->level};
        for (int k = 0; to->serial && !to->texture.id && k < s->slots; k++) {
            if (s->slot[k].serial == to->serial &&
                s->slot[k].level == to->level) {
                to->texture = s->slot[k].texture;
                s->slot[k].texture = (struct gp_texture) {0};
            }
        }
        if (!to->texture.id)
            st = make_image(log, gl, &l->image, &to->texture);
    }
    free_slots(gl, s);
    s->slot = slot;
    s->slots = n;
    return st;
}

// -- quads -------------------------------------------------------------------

/* Makes batches of s->quads (not empty) and writes to the context what they
 * need: programs, images, texels. Errors: GP_ERR_GL an image over the context's
 * size, GL's own; GP_ERR_BUG memory. */
static gp_status prepare_draw(const struct gp_log *log, const struct gp_gl *gl,
                              struct gp_flare_gl *s)
{
    static const char *const defines[PROGRAMS] = {
        "#define IMAGE\n", "#define PLAIN\n",
    };
    const int keys = s->quads.elements; // an element's quads are one draw
    struct batch *batch;
    const int n = s->quads.n, most = gp_gl_info(gl)->max_size;
    const int rows = n < most ? n : most;
    int *start = NULL; // of each key, the next one's place in the texture
    float *rgba;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "flare draws", 2 * (size_t) keys + 1, sizeof(int),
                         &start));
    GP_TRY(gp_alloc_zero(log, "flare draws", (size_t) keys, sizeof *batch,
                         &batch));
    gp_free(s->batch);
    s->batch = batch;
    s->batches = 0;

    // one batch a key
    int *const quad = start + keys + 1;
    for (int i = 0; i < n; i++) {
        const int key = s->quads.at[i].element;
        start[key + 1]++;
        quad[key] = i;
    }
    for (int k = 0; k < keys; k++) {
        const int of_key = start[k + 1];
        start[k + 1] += start[k];
        if (of_key > 0)
            batch[s->batches++] = (struct batch) {
                .program = s->quads.at[quad[k]].plain ? DRAW_PLAIN
                                                      : DRAW_IMAGE,
                .first = start[k], .n = of_key, .quad = quad[k],
            };
    }
    GP_TRY(fit_images(log, gl, s));

    // all quads as texels, those of a key together
    GP_TRY(make_texels(log, gl, "flare elements",
                       (n + rows - 1) / rows * TEXELS, rows, &s->texels,
                       &rgba));
    for (int i = 0; i < n; i++) {
        const struct gp_flare_quad *const q = &s->quads.at[i];
        const struct gp_rect r = rect_within(q->rect, s->reach);
        const int at = start[q->element]++, h = s->texels.h;
        float *const t = rgba + 4 * ((size_t) (at % h) * (size_t) s->texels.w +
                                     (size_t) (at / h * TEXELS));
        const float rect[4] = {(float) r.x0, (float) r.y0, (float) r.x1,
                               (float) r.y1};
        memcpy(t, rect, sizeof rect);
        memcpy(t + 4, q->base, sizeof q->base);
        memcpy(t + 6, q->turn, sizeof q->turn);
        t[8] = q->radius;
        t[11] = (float) q->light;
        memcpy(t + 12, q->inner, sizeof q->inner);
        memcpy(t + 16, q->amount, sizeof q->amount);
        for (int k = 0; k < 2 && q->plain; k++) {
            t[8 + k] = (float) (q->corner[k] + 1); // the border
            t[12 + k] = q->fraction[k];
        }
    }
    write_texels(gl, &s->texels, rgba);

    for (int i = 0; i < s->batches; i++) {
        const enum flare_program p = s->batch[i].program;
        if (!s->program[p].id)
            GP_TRY(gp_program_make(log, gl, defines[p], "flare.vert",
                                      "flare.frag", &s->program[p]));
    }
out:
    gp_free(start);
    return st;
}

/* Finds the pixels reached in the rows of a field from y0 on. */
static struct gp_rect band_of(const struct gp_flare_gl *s,
                              struct gp_rect field, int y0)
{
    const int y1 = field.y1 - y0 < BAND ? field.y1 : y0 + BAND;
    struct gp_rect band = {field.x1, y0, field.x0, y1};
    for (int i = 0; i < s->quads.n; i++) {
        int x0, x1;
        if (!gp_flare_span(&s->quads.at[i], y0, y1, &x0, &x1))
            continue;
        band.x0 = x0 < band.x0 ? x0 : band.x0;
        band.x1 = x1 > band.x1 ? x1 : band.x1;
    }
    return gp_rect_meet(band, field);
}

static gp_status draw_field(const struct gp_log *log, const struct gp_gl *gl,
                            const struct gp_flare_gl *s, struct gp_rect field)
{
    const struct gp_texture *const to = &s->target.colour;
    gp_status st = GP_OK;
    for (int y = field.y0; y < field.y1; y += BAND) {
        const struct gp_rect band = rect_within(band_of(s, field, y), field);
        if (!gp_rect_empty(band))
            gp_target_clear(gl, &s->target, band);
    }
    for (int i = 0; !st && i < s->batches; i++) {
        const struct batch *const b = &s->batch[i];
        const struct gp_uniform uniform[] = {
            {.name = "quads", .texture = &s->texels},
            {.name = "intensity", .texture = &s->intensity},
            {.name = "first", .v = {b->first, 0}},
            {.name = "field",
             .v = {field.x0 - s->reach.x0, field.y0 - s->reach.y0}},
            {.name = "size", .v = {to->w, to->h}},
            {.name = "image", .texture = &s->slot[b->slot].texture},
            {0},
        };
        const struct gp_draw draw = {
            .program = &s->program[b->program], .target = &s->target,
            .cut = {0, 0, gp_rect_w(field), gp_rect_h(field)},
            .uniform = uniform, .vertices = 6, .instances = b->n,
        };
        st = gp_draw_run(log, gl, &draw);
    }
    return st ? st : gp_gl_check(log, gl, "drawing a lens flare");
}

/* Adds the target's field to `layer`, through `rgba` of a band. */
static void read_field(const struct gp_gl *gl, const struct gp_flare_gl *s,
                       struct gp_rect field, struct gp_rect frame, float *rgba,
                       struct gp_planes *layer)
{
    for (int y0 = field.y0; y0 < field.y1; y0 += BAND) {
        const struct gp_rect band = band_of(s, field, y0);
        const int w = gp_rect_w(band);
        const float *from = rgba;
        if (gp_rect_empty(band))
            continue;
        gp_target_read(gl, &s->target, 0, rect_within(band, field), rgba);
        for (int y = band.y0; y < band.y1; y++, from += 4 * (size_t) w) {
            const size_t at = (size_t) (y - frame.y0) *
                                  (size_t) gp_rect_w(frame) +
                              (size_t) (band.x0 - frame.x0);
            for (int c = 0; c < 3; c++) {
                float *const to = layer->c[c] + at;
                for (int x = 0; x < w; x++)
                    to[x] += from[4 * x + c];
            }
        }
    }
}

gp_status gp_flare_draw(
    const struct gp_log *log, const struct gp_gl *gl, const struct gp_flare *f,
    const struct gp_light *light, int n, const struct gp_texture *intensity,
    struct gp_rect frame, struct gp_rect display, struct gp_flare_gl **state)
{
    gp_status st = GP_OK;
    if (!*state)
        st = gp_alloc_zero(log, "the flare's state", 1, sizeof **state, state);
    if (st)
        return st;
    struct gp_flare_gl *const s = *state;
    gp_flare_quads_free(&s->quads);
    s->intensity = *intensity;
    GP_TRY(gp_flare_quads_make(log, f, light, n, false, frame, display,
                               &s->quads));
    if (s->quads.n == 0)
        return GP_OK;
    s->reach = s->quads.at[0].rect;
    for (int i = 1; i < s->quads.n; i++)
        s->reach = gp_rect_join(s->reach, s->quads.at[i].rect);
    // a target large enough for all, up to a field's size
    const int limit = gp_gl_info(gl)->max_size;
    const int most = limit < FIELD_MAX ? limit : FIELD_MAX;
    const int w = gp_rect_w(s->reach) < most ? gp_rect_w(s->reach) : most;
    const int h = gp_rect_h(s->reach) < most ? gp_rect_h(s->reach) : most;
    const struct gp_texture had = s->target.colour;
    s->field = (struct gp_rect) {s->reach.x0, s->reach.y0, s->reach.x0 + w,
                                s->reach.y0 + h};
    if (had.w < w || had.h < h) {
        gp_target_free(gl, &s->target);
        GP_TRY(gp_target_make(log, gl, "a lens flare", GP_TEXEL_FLOAT, 1,
                              had.w > w ? had.w : w, had.h > h ? had.h : h,
                              &s->target));
    }
    GP_TRY(prepare_draw(log, gl, s));
    GP_TRY(draw_field(log, gl, s, s->field));
out:
    if (st)
        gp_flare_quads_free(&s->quads);
    return st;
}

gp_status gp_flare_read_layer(const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_flare_gl *s, struct gp_rect frame, struct gp_planes *layer)
{
    if (!s || s->quads.n == 0)
        return GP_OK;
    const int w = gp_rect_w(s->field), h = gp_rect_h(s->field);
    void *block;
    gp_status st = gp_alloc(log, "a band of the lens flare", (size_t) w * BAND,
                            4 * sizeof(float), &block);
    if (st)
        return st;
    for (int y = s->reach.y0; !st && y < s->reach.y1; y += h) {
        for (int x = s->reach.x0; !st && x < s->reach.x1; x += w) {
            const struct gp_rect field = gp_rect_meet(
                (struct gp_rect) {x, y, x + w, y + h}, s->reach);
            if (x > s->field.x0 || y > s->field.y0) // else it is drawn
                st = draw_field(log, gl, s, field);
            if (!st)
                read_field(gl, s, field, frame, block, layer);
        }
    }
    gp_free(block);
    return st ? st : gp_gl_check(log, gl, "reading a lens flare");
}

void gp_flare_close(const struct gp_gl *gl, struct gp_flare_gl **state)
{
    struct gp_flare_gl *const s = *state;
    if (!s)
        return;
    for (int i = 0; i < PROGRAMS; i++)
        gp_program_free(gl, &s->program[i]);
    gp_target_free(gl, &s->target);
    gp_texture_free(gl, &s->texels);
    free_slots(gl, s);
    gp_flare_quads_free(&s->quads);
    gp_free(s->batch);
    GP_FREE(*state);
}
