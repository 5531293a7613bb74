/* Polygons gathered per tile. The frame is cut into fields, a field into
 * tiles; each tile has a list of the polygons that reach it
 * (splat_tile_list.c), and one fragment pass over the field walks the lists
 * (shaders/tile.frag), once for each blur.
 *
 * A fragment is a block of 4x2 pixels: six attachments hold the two rows of
 * each plane, and what a polygon costs beside its samples is paid once for
 * eight pixels. A texel of a grey kernel holds four samples of a row, so that
 * a block loads two texels a row and takes its samples from them. Loads that
 * would filter (GL_LINEAR) are slower, and their weights are the driver's.
 */
#include "glare/splat/tile.h"

#include "core/memory.h"
#include "gl/gl.h"
#include "glare/splat/tile_list.h"

#include <math.h>
#include <string.h>

enum {
    BLOCK_W = 4, BLOCK_H = 2, // pixels of a fragment
    ATTACHMENTS = 3 * BLOCK_H,
    BAND_TEXELS = 1 << 16,    // of kernel rows on their way in
    VARIANTS = 4,             // of the program: WHOLE, COLOUR
    MIXING = 7,               // roundings of a share: light, and three for
                              // each of two mixes
};
static const size_t KEEP_BYTES = (size_t) 1 << 30; // of packed kernels

/* A blurred kernel, as tile.frag reads it. */
struct packed {
    struct gp_texture texture;
    bool grey;
};

struct gp_tiles {
    struct gp_program program[VARIANTS];
    struct gp_target target;
    struct gp_texel_buffer list;
    float *texel; // GP_TILE_TEXELS, the list's and pixels on their way out

    // what `packed` was made from
    unsigned long serial;
    struct gp_rect crop;
    bool tail;
    struct packed packed[GP_BLURS];
    size_t bytes; // of all of them, about
};

struct work {
    const struct gp_log *log;
    struct gp_gl *gl;
    const struct gp_kernel *kernel;
    const struct gp_polygons *polygons;
    struct gp_tiles *t;
    struct gp_tile_pieces pieces;
    struct gp_rect field;
    int w, h;
    struct gp_planes *layer;
    double roundings; // of the worst field so far
};

/* -- state ----------------------------------------------------------------- */

static void forget_kernels(const struct gp_gl *gl, struct gp_tiles *t)
{
    for (int b = 0; b < GP_BLURS; b++)
        gp_texture_free(gl, &t->packed[b].texture);
    t->bytes = 0;
}

void gp_tiles_free(struct gp_gl *gl, struct gp_tiles **state)
{
    struct gp_tiles *t = *state;
    if (!t)
        return;
    forget_kernels(gl, t);
    for (int i = 0; i < VARIANTS; i++)
        gp_program_free(gl, &t->program[i]);
    gp_target_free(gl, &t->target);
    gp_texel_buffer_free(gl, &t->list);
    gp_free(t->texel);
    GP_FREE(*state);
}

/* Makes *state when it is not there, and forgets kernels of other kinds. */
static gp_status open_state(const struct gp_log *log, struct gp_gl *gl,
                            const struct gp_kernel *kernel,
                            struct gp_rect crop, bool tail,
                            struct gp_tiles **state)
{
    gp_status st = GP_OK;
    void *block;
    if (!*state) {
        GP_TRY(gp_alloc_zero(log, "tiles", 1, sizeof **state, &block));
        *state = block;
        GP_TRY(gp_alloc(log, "lists of tiles", GP_TILE_TEXELS,
                        4 * sizeof(float), &block));
        (*state)->texel = block;
        GP_TRY(gp_texel_buffer_make(log, gl, "lists of tiles", GP_TILE_TEXELS,
                            &(*state)->list));
    }
    struct gp_tiles *t = *state;
    if (t->serial == 0 || t->serial != kernel->serial || t->tail != tail ||
        memcmp(&t->crop, &crop, sizeof crop) != 0)
        forget_kernels(gl, t);
    t->serial = kernel->serial;
    t->crop = crop;
    t->tail = tail;
    return GP_OK;
out:
    gp_tiles_free(gl, state);
    return st;
}

static gp_status fit_program(const struct gp_log *log, const struct gp_gl *gl,
                             struct gp_tiles *t, bool whole, bool colour,
                             const struct gp_program **out)
{
    static const char *const defines[VARIANTS] = {
        "", "#define COLOUR\n", "#define WHOLE\n",
        "#define WHOLE\n#define COLOUR\n",
    };
    int i = 2 * whole + colour;
    *out = &t->program[i];
    if (t->program[i].id)
        return GP_OK;
    return gp_program_make(log, gl, defines[i], "add.vert", "tile.frag",
                              &t->program[i]);
}

/* Makes the target hold the field. */
static gp_status fit_target(const struct work *k)
{
    struct gp_target *to = &k->t->target;
    int w = (gp_rect_w(k->field) + BLOCK_W - 1) / BLOCK_W;
    int h = (gp_rect_h(k->field) + BLOCK_H - 1) / BLOCK_H;
    if (to->colour.w >= w && to->colour.h >= h)
        return GP_OK;
    w = to->colour.w > w ? to->colour.w : w;
    h = to->colour.h > h ? to->colour.h : h;
    gp_target_free(k->gl, to);
    return gp_target_make(k->log, k->gl, "layer", GP_TEXEL_FLOAT, ATTACHMENTS,
                          w, h, to);
}

/* -- kernels --------------------------------------------------------------- */

/* One row of the blur as texels: four samples each when it is grey, what the
 * last has over being dark; else a sample of each plane. */
static void pack_row(const struct gp_blur *b, int y, float *texel)
{
    size_t first = (size_t) y * (size_t) b->w;
    if (b->grey) {
        memcpy(texel, b->k.c[0] + first, (size_t) b->w * sizeof(float));
        return;
    }
    for (int x = 0; x < b->w; x++) {
        for (int c = 0; c < 3; c++)
            texel[4 * x + c] = b->k.c[c][first + (size_t) x];
    }
}

static gp_status pack(const struct work *k, const struct gp_blur *blur,
                      struct packed *p)
{
    int w = blur->grey ? (blur->w - 1) / BLOCK_W + 1 : blur->w;
    int rows = BAND_TEXELS / w + 1;
    size_t pitch = 4 * (size_t) w;
    gp_status st = gp_texture_make(k->log, k->gl, "kernel", GP_TEXEL_FLOAT, w,
                                   blur->h, &p->texture);
    void *block = NULL;
    if (!st)
        st = gp_alloc_zero(k->log, "kernel rows", pitch * (size_t) rows,
                           sizeof(float), &block);
    if (st)
        return st;
    float *band = block;
    for (int y0 = 0; y0 < blur->h; y0 += rows) {
        int y1 = blur->h - y0 < rows ? blur->h : y0 + rows;
        for (int y = y0; y < y1; y++)
            pack_row(blur, y, band + (size_t) (y - y0) * pitch);
        gp_texture_write(k->gl, &p->texture, (struct gp_rect) {0, y0, w, y1},
                         band);
    }
    gp_free(band);
    p->grey = blur->grey;
    return gp_gl_check(k->log, k->gl, "packing the kernel");
}

static size_t bytes_of(const struct gp_blur *b)
{
    return (size_t) b->w * (size_t) b->h * (b->grey ? 1 : 4) * sizeof(float);
}

/* Makes the packed kernel of a blur; others go when they are too many. */
static gp_status fit_kernel(const struct work *k, int b)
{
    struct gp_tiles *t = k->t;
    struct gp_blur blur;
    if (t->packed[b].texture.id)
        return GP_OK;
    gp_status st = gp_blur_make(k->log, k->kernel, t->crop, t->tail,
                                gp_blur_box[b], &blur);
    if (st)
        return st;
    if (t->bytes + bytes_of(&blur) > KEEP_BYTES)
        forget_kernels(k->gl, t);
    t->bytes += bytes_of(&blur);
    st = pack(k, &blur, &t->packed[b]);
    if (st)
        forget_kernels(k->gl, t);
    gp_blur_free(&blur);
    return st;
}

/* -- drawing --------------------------------------------------------------- */

static gp_status draw_list(const struct work *k, const struct gp_program *p,
                           const struct packed *kernel,
                           const struct gp_tile_list *list)
{
    int columns = list->side - 2, rows = list->side - 1; // log2 of blocks
    const struct gp_uniform uniform[] = {
        {.name = "list", .texels = &k->t->list},
        {.name = "tile", .v = {columns, rows}},
        {.name = "sums", .v = {list->across,
                               2 * gp_tile_inner((size_t) list->most)}},
        {.name = "kernel", .image = &kernel->texture},
        {0},
    };
    const struct gp_draw draw = {
        .program = p, .target = &k->t->target,
        .cut = {list->lit.x0 << columns, list->lit.y0 << rows,
                list->lit.x1 << columns, list->lit.y1 << rows},
        .uniform = uniform, .vertices = 3, .instances = 1,
    };
    gp_texel_buffer_write(k->gl, &k->t->list, 0, list->texels, list->texel);
    return gp_draw_run(k->log, k->gl, &draw);
}

/* Draws the pieces of one kind that reach the field; *draws and *sums count
 * what a pixel may see of it. */
static gp_status draw_kind(const struct work *k, int kind, int *draws,
                           double *sums)
{
    int b = kind > 0 ? kind - 1 : 0;
    const struct gp_program *p;
    struct gp_tile_list list = {.field = k->field, .texel = k->t->texel};
    gp_status st = GP_OK;
    list.side = gp_tile_side(&k->pieces, kind, k->field);
    for (size_t next = k->pieces.first[kind];
         !st && next < k->pieces.first[kind + 1];) {
        gp_tile_list_fill(k->polygons, &k->pieces, kind, &next, &list);
        if (list.most == 0)
            break;
        st = fit_kernel(k, b);
        if (!st)
            st = fit_program(k->log, k->gl, k->t, kind == 0,
                             !k->t->packed[b].grey, &p);
        if (!st)
            st = draw_list(k, p, &k->t->packed[b], &list);
        double inner = gp_tile_inner((size_t) list.most);
        *sums = fmax(*sums, inner + ceil(list.most / inner));
        ++*draws;
    }
    return st;
}

/* -- fields ---------------------------------------------------------------- */

/* Copies one row of a plane's attachment, in pixels, to the layer. */
static void read_plane(const struct work *k, int c, int lower)
{
    int w = (gp_rect_w(k->field) + BLOCK_W - 1) / BLOCK_W;
    int h = (gp_rect_h(k->field) + BLOCK_H - 1 - lower) / BLOCK_H;
    if (h < 1)
        return;
    gp_target_read(k->gl, &k->t->target, BLOCK_H * c + lower,
                        (struct gp_rect) {0, 0, w, h}, k->t->texel);
    for (int y = 0; y < h; y++)
        memcpy(k->layer->c[c] +
                   (size_t) (k->field.y0 + BLOCK_H * y + lower) *
                       (size_t) k->w + k->field.x0,
               k->t->texel + 4 * (size_t) y * (size_t) w,
               (size_t) gp_rect_w(k->field) * sizeof(float));
}

static void clear_layer(const struct work *k, struct gp_rect r)
{
    for (int c = 0; c < 3; c++) {
        for (int y = r.y0; y < r.y1; y++)
            memset(k->layer->c[c] + (size_t) y * (size_t) k->w + r.x0, 0,
                   (size_t) gp_rect_w(r) * sizeof(float));
    }
}

static gp_status draw_field(struct work *k)
{
    int draws = 0;
    double sums = 0.0;
    gp_status st = fit_target(k);
    if (st)
        return st;
    gp_target_clear(k->gl, &k->t->target,
                    (struct gp_rect) {0, 0, GP_TILE_FIELD, GP_TILE_FIELD});
    for (int kind = 0; !st && kind < GP_TILE_KINDS; kind++)
        st = draw_kind(k, kind, &draws, &sums);
    if (st)
        return st;
    if (draws == 0) {
        clear_layer(k, k->field);
        return GP_OK;
    }
    for (int i = 0; i < ATTACHMENTS; i++)
        read_plane(k, i / BLOCK_H, i % BLOCK_H);
    k->roundings = fmax(k->roundings, MIXING + sums + draws);
    return gp_gl_check(k->log, k->gl, "gathering glare polygons");
}

/* The length of the fewest equal fields of `limit` pixels, whole blocks. */
static int field_size(int size, int limit, int block)
{
    int parts = (size - 1) / limit + 1;
    int length = (size - 1) / parts + 1;
    return (length + block - 1) / block * block;
}

static gp_status draw_fields(struct work *k)
{
    int max = gp_gl_info(k->gl)->max_size, limit = GP_TILE_FIELD;
    int w = field_size(k->w, max < limit / BLOCK_W ? max * BLOCK_W : limit,
                       BLOCK_W);
    int h = field_size(k->h, max < limit / BLOCK_H ? max * BLOCK_H : limit,
                       BLOCK_H);
    gp_status st = GP_OK;
    for (int y = 0; !st && y < k->h; y += h) {
        for (int x = 0; !st && x < k->w; x += w) {
            k->field = gp_rect_meet(
                (struct gp_rect) {x, y, x + w, y + h},
                (struct gp_rect) {0, 0, k->w, k->h});
            st = draw_field(k);
        }
    }
    return st;
}

gp_status gp_tiles_draw(const struct gp_log *log, struct gp_gl *gl,
                        const struct gp_kernel *kernel, struct gp_rect crop,
                        bool tail, const struct gp_polygons *polygons,
                        const struct gp_shrink *shrink, int w, int h,
                        struct gp_planes *layer, struct gp_tiles **state,
                        double *roundings)
{
    struct work k = {.log = log, .gl = gl, .kernel = kernel,
                     .polygons = polygons, .w = w, .h = h, .layer = layer};
    gp_status st;
    *roundings = 0.0;
    if (polygons->n == 0 || gp_rect_empty(crop)) {
        clear_layer(&k, (struct gp_rect) {0, 0, w, h});
        return GP_OK;
    }
    GP_TRY(open_state(log, gl, kernel, crop, tail, state));
    k.t = *state;
    GP_TRY(gp_tile_pieces_make(log, kernel, crop, polygons, shrink, w, h,
                               &k.pieces));
    GP_TRY(draw_fields(&k));
    *roundings = k.roundings;
out:
    gp_tile_pieces_free(&k.pieces);
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
            draws += 1.0 + (double) n[b] / GP_TILE_BATCH;
    }
    double inner = gp_tile_inner(most);
    return MIXING + inner + ceil((double) most / inner) + draws;
}
