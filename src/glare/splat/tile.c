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

enum {
    LOW_SIDE = 4, // log2 of 16 pixels: what llvmpipe shades at a time
    TILES_MAX = (GP_TILE_FIELD >> LOW_SIDE) * (GP_TILE_FIELD >> LOW_SIDE),
    ENTRY = 2,    // texels
    // entries a polygon, on average, that a kind may have: what a field of
    // the largest tiles has at most
    ENTRIES_MAX = (GP_TILE_FIELD >> 6) * (GP_TILE_FIELD >> 6),
    FRAGMENT_W = 4, FRAGMENT_H = 2, // pixels
    ATTACHMENTS = 3 * FRAGMENT_H,
    BAND_TEXELS = 1 << 16,    // of kernel rows on their way in
    VARIANTS = 4,             // of the program: WHOLE, COLOUR
    MIXING = 7,               // roundings of a share: light, and three for
                              // each of two mixes
};
/* Milliseconds of a pixel of a tile's entry, and of the entry itself, on Mesa
 * 22.3's llvmpipe and two cores. */
static const double PIXEL_MS = 1.3e-6, ENTRY_MS = 1e-4;
static const size_t KEEP_BYTES = (size_t) 1 << 30; // of packed kernels

/* A batch that is full leaves less than TILES_MAX entries free. */
_Static_assert((GP_TILE_TEXELS - TILES_MAX) / ENTRY - TILES_MAX >=
                   GP_TILE_BATCH * ENTRIES_MAX, "a batch holds too little");

/* -- pieces ---------------------------------------------------------------- */

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

/* The frame's pixels that a polygon draws. */
static struct gp_rect box_of(const struct gp_tile_pieces *p,
    const struct gp_shrink *shrink, struct gp_rect crop, int w, int h,
    const struct gp_polygon *g)
{
    const int reach = shrink->reach[gp_source_bin(g->light)];
    const int more = gp_blur_box[g->blur] - 1;
    struct gp_rect box;
    find_span((double) g->x, p->cx[g->blur], gp_rect_w(crop) + more, reach, w,
              &box.x0, &box.x1);
    find_span((double) g->y, p->cy[g->blur], gp_rect_h(crop) + more, reach, h,
              &box.y0, &box.y1);
    return box;
}

gp_status gp_tile_pieces_make(const struct gp_log *log,
    const struct gp_kernel *kernel, struct gp_rect crop,
    const struct gp_polygons *polygons, const struct gp_shrink *shrink, int w,
    int h, struct gp_tile_pieces *out)
{
    struct gp_tile_pieces p = {0};
    size_t to[GP_TILE_KINDS];
    for (int b = 0; b < GP_BLURS; b++) {
        double more = 0.5 * (gp_blur_box[b] - 1);
        p.cx[b] = (double) kernel->cx - crop.x0 + more;
        p.cy[b] = (double) kernel->cy - crop.y0 + more;
    }
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *g = &polygons->at[i];
        if (!gp_rect_empty(box_of(&p, shrink, crop, w, h, g)))
            p.first[kind_of(g) + 1]++;
    }
    for (int k = 0; k < GP_TILE_KINDS; k++)
        p.first[k + 1] += p.first[k];
    gp_status st = gp_alloc(log, "polygons of tiles",
                            p.first[GP_TILE_KINDS] + 1, sizeof *p.at, &p.at);
    if (st)
        return st;
    memcpy(to, p.first, sizeof to);
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *g = &polygons->at[i];
        const struct gp_rect box = box_of(&p, shrink, crop, w, h, g);
        if (!gp_rect_empty(box))
            p.at[to[kind_of(g)]++] = (struct gp_tile_piece) {box, i};
    }
    *out = p;
    return GP_OK;
}

void gp_tile_pieces_free(struct gp_tile_pieces *p)
{
    gp_free(p->at);
    *p = (struct gp_tile_pieces) {0};
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

int gp_tile_side(const struct gp_tile_pieces *p, int kind, struct gp_rect field)
{
    double entries[GP_TILE_SIDES] = {0}, polygons = 0.0;
    for (size_t i = p->first[kind]; i < p->first[kind + 1]; i++) {
        if (gp_rect_empty(gp_rect_meet(p->at[i].box, field)))
            continue;
        polygons += 1.0;
        for (int s = 0; s < GP_TILE_SIDES; s++) {
            const struct gp_rect t = tiles_of(p->at[i].box, field,
                                              LOW_SIDE + s);
            entries[s] += gp_rect_w(t) * gp_rect_h(t);
        }
    }
    int best = GP_TILE_SIDES - 1;
    double least = INFINITY;
    for (int s = GP_TILE_SIDES - 1; s >= 0; s--) {
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

void gp_tile_batch_enter(const struct gp_polygons *polygons,
                         const struct gp_tile_pieces *p, int kind,
                         size_t *next, struct gp_tile_batch *batch)
{
    int in_tile[TILES_MAX];
    const struct gp_rect field = batch->field;
    const int side = batch->side, last = (1 << side) - 1;
    const int across = (gp_rect_w(field) + last) >> side;
    const int tiles = across * ((gp_rect_h(field) + last) >> side);
    // the entries of each tile, for as many pieces as fit
    int entries = 0, room = (GP_TILE_TEXELS - tiles) / ENTRY;
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

/* -- state ----------------------------------------------------------------- */

/* A blurred kernel, as tile.frag reads it. */
struct packed {
    struct gp_texture texture;
    bool grey;
};

struct gp_tiles {
    struct gp_program program[VARIANTS];
    struct gp_target target;
    struct gp_buffer entries;
    float *texel; // GP_TILE_TEXELS, the entries' and pixels on their way out

    // source of `packed`
    unsigned long serial;
    struct gp_rect crop;
    bool tail;
    struct packed packed[GP_BLURS];
    size_t bytes; // of all of them, about
};

struct gathering {
    const struct gp_log *log;
    struct gp_gl *gl;
    const struct gp_kernel *kernel;
    const struct gp_polygons *polygons;
    struct gp_tiles *t;
    struct gp_tile_pieces pieces;
    struct gp_rect field;
    int w;                   // of the frame
    struct gp_planes *layer;
    double roundings; // of the worst field so far
};

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
    gp_buffer_free(gl, &t->entries);
    gp_free(t->texel);
    GP_FREE(*state);
}

/* Uploads the blurred kernel, four samples a texel when it is grey, the last
 * one's rest being dark, else a sample of each plane; others go when they are
 * too many. */
static gp_status pack_kernel(const struct gathering *k, int b)
{
    struct gp_tiles *const t = k->t;
    struct packed *const p = &t->packed[b];
    struct gp_blur blur;
    float *band = NULL;
    if (p->texture.id)
        return GP_OK;
    gp_status st = gp_blur_make(k->log, k->kernel, t->crop, t->tail,
                                gp_blur_box[b], &blur);
    if (st)
        return st;
    const size_t bytes = (size_t) blur.w * (size_t) blur.h *
                         (blur.grey ? 1 : 4) * sizeof(float);
    if (t->bytes + bytes > KEEP_BYTES)
        forget_kernels(k->gl, t);
    t->bytes += bytes;
    const int w = blur.grey ? (blur.w - 1) / FRAGMENT_W + 1 : blur.w;
    const int rows = BAND_TEXELS / w + 1;
    const size_t pitch = 4 * (size_t) w, samples = (size_t) blur.w;
    GP_TRY(gp_texture_make(k->log, k->gl, "kernel", GP_TEXEL_FLOAT, w, blur.h,
                           &p->texture));
    GP_TRY(gp_alloc_zero(k->log, "kernel rows", pitch * (size_t) rows,
                         sizeof *band, &band));
    for (int y0 = 0; y0 < blur.h; y0 += rows) {
        const int y1 = blur.h - y0 < rows ? blur.h : y0 + rows;
        for (int y = y0; y < y1; y++) {
            float *const texel = band + (size_t) (y - y0) * pitch;
            const size_t first = (size_t) y * samples;
            if (blur.grey)
                memcpy(texel, blur.k.c[0] + first, samples * sizeof(float));
            for (size_t x = 0; !blur.grey && x < samples; x++) {
                for (size_t c = 0; c < 3; c++)
                    texel[4 * x + c] = blur.k.c[c][first + x];
            }
        }
        gp_texture_write(k->gl, &p->texture, (struct gp_rect) {0, y0, w, y1},
                         band);
    }
    p->grey = blur.grey;
    st = gp_gl_check(k->log, k->gl, "packing the kernel");
out:
    if (st)
        forget_kernels(k->gl, t);
    gp_free(band);
    gp_blur_free(&blur);
    return st;
}

/* -- drawing --------------------------------------------------------------- */

/* Draws the pieces of one kind that reach the field; *draws and *sums count the
 * roundings of a pixel. */
static gp_status draw_kind(const struct gathering *k, int kind, int *draws,
                           double *sums)
{
    static const char *const defines[VARIANTS] = {
        "", "#define COLOUR\n", "#define WHOLE\n",
        "#define WHOLE\n#define COLOUR\n",
    };
    gp_status st = GP_OK;
    struct gp_tiles *const t = k->t;
    const int blur = kind > 0 ? kind - 1 : 0;
    struct gp_tile_batch batch = {.field = k->field, .texel = t->texel};
    batch.side = gp_tile_side(&k->pieces, kind, k->field);
    // log2 of a tile's fragments
    const int columns = batch.side - 2, rows = batch.side - 1;
    for (size_t next = k->pieces.first[kind];
         next < k->pieces.first[kind + 1];) {
        gp_tile_batch_enter(k->polygons, &k->pieces, kind, &next, &batch);
        if (batch.most == 0)
            break;
        GP_TRY(pack_kernel(k, blur));
        const int variant = 2 * (kind == 0) + !t->packed[blur].grey;
        struct gp_program *const p = &t->program[variant];
        if (!p->id)
            GP_TRY(gp_program_make(k->log, k->gl, defines[variant], "add.vert",
                                   "tile.frag", p));
        const int inner = inner_sum((size_t) batch.most);
        const struct gp_uniform uniform[] = {
            {.name = "list", .texels = &t->entries},
            {.name = "tile", .v = {columns, rows}},
            {.name = "sums", .v = {batch.across, 2 * inner}},
            {.name = "kernel", .image = &t->packed[blur].texture},
            {0},
        };
        const struct gp_draw draw = {
            .program = p, .target = &t->target,
            .cut = {batch.lit.x0 << columns, batch.lit.y0 << rows,
                    batch.lit.x1 << columns, batch.lit.y1 << rows},
            .uniform = uniform, .vertices = 3, .instances = 1,
        };
        gp_buffer_write(k->gl, &t->entries, 0, batch.texels, batch.texel);
        GP_TRY(gp_draw_run(k->log, k->gl, &draw));
        *sums = fmax(*sums, inner + ceil(batch.most / (double) inner));
        ++*draws;
    }
out:
    return st;
}

static gp_status draw_field(struct gathering *k)
{
    int draws = 0;
    double sums = 0.0;
    const int w = (gp_rect_w(k->field) + FRAGMENT_W - 1) / FRAGMENT_W;
    const int h = (gp_rect_h(k->field) + FRAGMENT_H - 1) / FRAGMENT_H;
    gp_status st = gp_splat_fit_target(k->log, k->gl, "layer", ATTACHMENTS, w,
                                       h, &k->t->target);
    if (st)
        return st;
    gp_target_clear(k->gl, &k->t->target,
                    (struct gp_rect) {0, 0, GP_TILE_FIELD, GP_TILE_FIELD});
    for (int kind = 0; !st && kind < GP_TILE_KINDS; kind++)
        st = draw_kind(k, kind, &draws, &sums);
    if (st)
        return st;
    if (draws == 0) {
        for (int y = k->field.y0; y < k->field.y1; y++)
            gp_planes_clear(k->layer, (size_t) y * (size_t) k->w +
                                          (size_t) k->field.x0,
                            (size_t) gp_rect_w(k->field));
        return GP_OK;
    }
    for (int i = 0; i < ATTACHMENTS; i++) {
        // an attachment holds every other row of a plane
        const int lower = i % FRAGMENT_H;
        const int rows = (gp_rect_h(k->field) + FRAGMENT_H - 1 - lower) /
                         FRAGMENT_H;
        if (rows < 1)
            continue;
        gp_target_read(k->gl, &k->t->target, i,
                       (struct gp_rect) {0, 0, w, rows}, k->t->texel);
        for (int y = 0; y < rows; y++)
            memcpy(k->layer->c[i / FRAGMENT_H] +
                       (size_t) (k->field.y0 + FRAGMENT_H * y + lower) *
                           (size_t) k->w + k->field.x0,
                   k->t->texel + 4 * (size_t) y * (size_t) w,
                   (size_t) gp_rect_w(k->field) * sizeof(float));
    }
    k->roundings = fmax(k->roundings, MIXING + sums + draws);
    return gp_gl_check(k->log, k->gl, "gathering glare polygons");
}

/* The length of the fewest equal fields of `most` fragments and at most
 * GP_TILE_FIELD pixels, whole fragments. */
static int field_size(int size, int most, int fragment)
{
    const int limit = most < GP_TILE_FIELD / fragment ? most * fragment
                                                      : GP_TILE_FIELD;
    const int fields = (size - 1) / limit + 1;
    const int length = (size - 1) / fields + 1;
    return (length + fragment - 1) / fragment * fragment;
}

gp_status gp_tiles_draw(const struct gp_log *log, struct gp_gl *gl,
    const struct gp_tiles_light *light, struct gp_planes *layer,
    struct gp_tiles **state, double *roundings)
{
    const struct gp_kernel *const kernel = light->kernel;
    const struct gp_rect crop = light->crop;
    const int w = light->w, h = light->h;
    struct gathering k = {.log = log, .gl = gl, .kernel = kernel,
                          .polygons = light->polygons, .w = w,
                          .layer = layer};
    const struct gp_rect frame = {0, 0, w, h};
    gp_status st;
    *roundings = 0.0;
    if (light->polygons->n == 0 || gp_rect_empty(crop)) {
        gp_planes_clear(layer, 0, (size_t) w * (size_t) h);
        return GP_OK;
    }
    if (!*state) {
        GP_TRY(gp_alloc_zero(log, "tiles", 1, sizeof **state, state));
        GP_TRY(gp_alloc(log, "lists of tiles", GP_TILE_TEXELS,
                        4 * sizeof(float), &(*state)->texel));
        GP_TRY(gp_buffer_make(log, gl, "lists of tiles", GP_BUFFER_TEXELS,
                              GP_TILE_TEXELS, &(*state)->entries));
    }
    struct gp_tiles *const t = k.t = *state;
    if (t->serial == 0 || t->serial != kernel->serial || t->tail != light->tail ||
        memcmp(&t->crop, &crop, sizeof crop) != 0)
        forget_kernels(gl, t);
    t->serial = kernel->serial;
    t->crop = crop;
    t->tail = light->tail;
    GP_TRY(gp_tile_pieces_make(log, kernel, crop, light->polygons,
                               light->shrink, w, h, &k.pieces));
    const int most = gp_gl_info(gl)->max_size;
    const int field_w = field_size(w, most, FRAGMENT_W);
    const int field_h = field_size(h, most, FRAGMENT_H);
    for (int y = 0; y < h; y += field_h) {
        for (int x = 0; x < w; x += field_w) {
            k.field = gp_rect_meet(
                (struct gp_rect) {x, y, x + field_w, y + field_h}, frame);
            GP_TRY(draw_field(&k));
        }
    }
    *roundings = k.roundings;
out:
    if (!k.t) // the state is half made
        gp_tiles_free(gl, state);
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
    double inner = inner_sum(most);
    return MIXING + inner + ceil((double) most / inner) + draws;
}
