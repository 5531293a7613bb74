/* What flare.vert and flare.frag read: items, sides of polygons, images. */
#include "sun/flare_state.h"

#include "core/memory.h"

#include <string.h>

enum { TEXELS = 5 }; // of an item; the same as in flare.vert

/* -- images ---------------------------------------------------------------- */

static gp_status upload_image(const struct gp_log *log, const struct gp_gl *gl,
                              const struct gp_flare_image *m,
                              struct gp_texture *out)
{
    const int w = m->w + 2, h = m->h + 2;
    void *block;
    gp_status st = gp_texture_make(log, gl, "a flare image", w, h, out);
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
                            struct gp_flare_slot *slot)
{
    const unsigned serial = l->image.serial;
    for (int i = 0; serial && i < s->slots; i++) {
        if (s->slot[i].serial != serial || s->slot[i].level != l->level ||
            !s->slot[i].texture.id)
            continue;
        *slot = s->slot[i];
        s->slot[i] = (struct gp_flare_slot) {0};
        return GP_OK;
    }
    slot->serial = serial;
    slot->level = l->level;
    return upload_image(log, gl, &l->image, &slot->texture);
}

void gp_flare_free_slots(const struct gp_gl *gl, struct gp_flare_slot **slot,
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
    struct gp_flare_slot *const slot = block;
    for (int i = 0; !st && i < s->batches; i++) {
        const struct gp_flare_item *const item =
            &s->items.at[s->batch[i].item];
        if (!item->image)
            continue;
        s->batch[i].slot = n;
        st = find_image(log, gl, s, &s->items.level[item->element],
                        &slot[n++]);
    }
    gp_flare_free_slots(gl, &s->slot, &s->slots);
    s->slot = slot;
    s->slots = n;
    return st;
}

/* -- items ----------------------------------------------------------------- */

static enum gp_flare_program program_of(const struct gp_flare_item *i)
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
static int key_of(const struct gp_flare_item *i)
{
    return i->image ? FIRST_IMAGE + i->element : (int) program_of(i);
}

static void put_item(const struct gp_flare_item *i, struct gp_rect reach,
                     float t[4 * TEXELS])
{
    const struct gp_rect r = gp_flare_in(i->rect, reach);
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
            s->batch[s->batches++] = (struct gp_flare_batch) {
                .program = program_of(&s->items.at[item[k]]),
                .first = start[k], .n = n, .item = item[k],
            };
    }
    return GP_OK;
}

static gp_status fit_texels(const struct gp_log *log, const struct gp_gl *gl,
                            struct gp_flare_gl *s)
{
    const int most = gp_gl_max_size(gl), n = s->items.n;
    const int rows = n < most ? n : most;
    if (s->texels.w / TEXELS * s->texels.h >= n)
        return GP_OK;
    gp_texture_free(gl, &s->texels);
    return gp_texture_make(log, gl, "flare elements",
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
        const struct gp_flare_item *const item = &s->items.at[i];
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
        st = gp_texture_make(log, gl, "flare polygons", GP_FLARE_SIDES, rows,
                             &s->edges);
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

gp_status gp_flare_upload(const struct gp_log *log, const struct gp_gl *gl,
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
