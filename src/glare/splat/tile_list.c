#include "glare/splat/tile_list.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

enum {
    LOW_SIDE = 4, // log2 of 16 pixels: what llvmpipe shades at a time
    TILES_MAX = (GP_TILE_FIELD >> LOW_SIDE) * (GP_TILE_FIELD >> LOW_SIDE),
    ENTRY = 2,    // texels
    // entries a polygon, on average, that a kind may have: what a field of
    // the largest tiles has at most
    ENTRIES_MAX = (GP_TILE_FIELD >> 6) * (GP_TILE_FIELD >> 6),
};

/* A batch that is full leaves less than TILES_MAX entries free. */
_Static_assert((GP_TILE_TEXELS - TILES_MAX) / ENTRY - TILES_MAX >=
                   GP_TILE_BATCH * ENTRIES_MAX, "a batch holds too little");

/* Milliseconds, by `test_tile --time` on two cores of a 2.5 GHz Xeon, Mesa 22.3
 * llvmpipe: a pixel of an entry, and what an entry costs beside. */
static const double PIXEL_MS = 1.3e-6, ENTRY_MS = 1e-4;

/* -- pieces ---------------------------------------------------------------- */

static int kind_of(const struct gp_polygon *g)
{
    bool whole = g->blur == 0 && floorf(g->x) == g->x && floorf(g->y) == g->y;
    return whole ? 0 : 1 + g->blur;
}

static int clamp(double v, int high)
{
    return v < 0.0 ? 0 : v > high ? high : (int) v;
}

/* Pixels of [0, limit) on one axis, half-open: those between the samples
 * before the first and after the last, both 0, and within the reach. */
static void span(double at, double centre, int samples, int reach, int limit,
                 int *first, int *end)
{
    double low = floor(at - centre - 1.0) + 1.0;
    double high = ceil(at - centre + samples);
    *first = clamp(fmax(low, ceil(at - reach)), limit);
    *end = clamp(fmin(high, floor(at + reach) + 1.0), limit);
}

struct frame {
    const struct gp_shrink *shrink;
    struct gp_rect crop;
    int w, h;
};

static struct gp_rect box_of(const struct frame *f,
                             const struct gp_tile_pieces *p,
                             const struct gp_polygon *g)
{
    int reach = f->shrink->reach[gp_source_bin(g->light)];
    int more = gp_blur_box[g->blur] - 1;
    struct gp_rect box;
    span((double) g->x, p->cx[g->blur], gp_rect_w(f->crop) + more, reach, f->w,
         &box.x0, &box.x1);
    span((double) g->y, p->cy[g->blur], gp_rect_h(f->crop) + more, reach, f->h,
         &box.y0, &box.y1);
    return box;
}

static void count_kinds(const struct frame *f,
                        const struct gp_polygons *polygons,
                        struct gp_tile_pieces *p)
{
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *g = &polygons->at[i];
        if (!gp_rect_empty(box_of(f, p, g)))
            p->first[kind_of(g) + 1]++;
    }
    for (int k = 0; k < GP_TILE_KINDS; k++)
        p->first[k + 1] += p->first[k];
}

gp_status gp_tile_pieces_make(const struct gp_log *log,
                              const struct gp_kernel *kernel,
                              struct gp_rect crop,
                              const struct gp_polygons *polygons,
                              const struct gp_shrink *shrink, int w, int h,
                              struct gp_tile_pieces *out)
{
    const struct frame f = {shrink, crop, w, h};
    struct gp_tile_pieces p = {0};
    size_t to[GP_TILE_KINDS];
    void *block;
    for (int b = 0; b < GP_BLURS; b++) {
        double more = 0.5 * (gp_blur_box[b] - 1);
        p.cx[b] = (double) kernel->cx - crop.x0 + more;
        p.cy[b] = (double) kernel->cy - crop.y0 + more;
    }
    count_kinds(&f, polygons, &p);
    gp_status st = gp_alloc(log, "polygons of tiles",
                            p.first[GP_TILE_KINDS] + 1, sizeof *p.at, &block);
    if (st)
        return st;
    p.at = block;
    memcpy(to, p.first, sizeof to);
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *g = &polygons->at[i];
        struct gp_rect box = box_of(&f, &p, g);
        if (!gp_rect_empty(box))
            p.at[to[kind_of(g)]++] = (struct gp_tile_piece) {box, i};
    }
    *out = p;
    return GP_OK;
}

void gp_tile_pieces_free(struct gp_tile_pieces *p)
{
    GP_FREE(p->at);
    *p = (struct gp_tile_pieces) {0};
}

/* -- tiles ----------------------------------------------------------------- */

/* The tiles that a box of the frame touches; empty where it leaves the field. */
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

static int count(struct gp_rect tiles)
{
    return gp_rect_w(tiles) * gp_rect_h(tiles);
}

int gp_tile_side(const struct gp_tile_pieces *p, int kind,
                 struct gp_rect field)
{
    double entries[GP_TILE_SIDES] = {0}, polygons = 0.0;
    for (size_t i = p->first[kind]; i < p->first[kind + 1]; i++) {
        if (gp_rect_empty(gp_rect_meet(p->at[i].box, field)))
            continue;
        polygons += 1.0;
        for (int s = 0; s < GP_TILE_SIDES; s++)
            entries[s] += count(tiles_of(p->at[i].box, field, LOW_SIDE + s));
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

/* -- lists ----------------------------------------------------------------- */

/* Counts the entries of each tile, for as many pieces as fit; the piece after
 * the last of them. */
static size_t count_entries(const struct gp_tile_pieces *p, size_t first,
                            size_t end, struct gp_tile_list *list,
                            int tiles, int in_tile[])
{
    int entries = 0, room = (GP_TILE_TEXELS - tiles) / ENTRY;
    memset(in_tile, 0, (size_t) tiles * sizeof in_tile[0]);
    list->lit = (struct gp_rect) {list->across, tiles, 0, 0};
    size_t i = first;
    for (; i < end; i++) {
        struct gp_rect t = tiles_of(p->at[i].box, list->field, list->side);
        if (entries + count(t) > room)
            break;
        entries += count(t);
        for (int y = t.y0; y < t.y1; y++) {
            for (int x = t.x0; x < t.x1; x++)
                in_tile[y * list->across + x]++;
        }
        if (count(t) > 0)
            list->lit = (struct gp_rect) {
                t.x0 < list->lit.x0 ? t.x0 : list->lit.x0,
                t.y0 < list->lit.y0 ? t.y0 : list->lit.y0,
                t.x1 > list->lit.x1 ? t.x1 : list->lit.x1,
                t.y1 > list->lit.y1 ? t.y1 : list->lit.y1,
            };
    }
    return i;
}

/* Writes the range of each tile; in_tile becomes where its next entry goes. */
static void write_ranges(struct gp_tile_list *list, int tiles, int in_tile[])
{
    list->texels = tiles;
    list->most = 0;
    for (int t = 0; t < tiles; t++) {
        int n = in_tile[t];
        in_tile[t] = list->texels;
        list->texels += ENTRY * n;
        list->most = n > list->most ? n : list->most;
        float *texel = list->texel + 4 * t;
        texel[0] = (float) in_tile[t];
        texel[1] = (float) list->texels;
        texel[2] = texel[3] = 0.0f;
    }
}

/* What of [first, end) lies in the tile at `at`, as tile.frag packs it. */
static int drawn(int first, int end, int at, int side)
{
    int low = first - at, high = end - 1 - at, last = (1 << side) - 1;
    return (low > 0 ? low : 0) + 64 * (high < last ? high : last);
}

static void write_entries(const struct gp_polygon *g,
                          const struct gp_tile_pieces *p, struct gp_rect box,
                          const struct gp_tile_list *list, int in_tile[])
{
    struct gp_rect t = tiles_of(box, list->field, list->side);
    double x = p->cx[g->blur] - (double) g->x;
    double y = p->cy[g->blur] - (double) g->y;
    double left = floor(x), top = floor(y);
    for (int row = t.y0; row < t.y1; row++) {
        int py = list->field.y0 + (row << list->side);
        int rows = drawn(box.y0, box.y1, py, list->side);
        for (int column = t.x0; column < t.x1; column++) {
            int px = list->field.x0 + (column << list->side);
            int *to = &in_tile[row * list->across + column];
            float *e = list->texel + 4 * (size_t) *to;
            *to += ENTRY;
            memcpy(e, g->rgb, sizeof g->rgb);
            e[3] = (float) (x - left);
            e[4] = (float) (y - top);
            e[5] = (float) (left + px);
            e[6] = (float) (top + py);
            e[7] = (float) (drawn(box.x0, box.x1, px, list->side) +
                            4096 * rows);
        }
    }
}

void gp_tile_list_fill(const struct gp_polygons *polygons,
                       const struct gp_tile_pieces *p, int kind, size_t *next,
                       struct gp_tile_list *list)
{
    int in_tile[TILES_MAX], last = (1 << list->side) - 1;
    list->across = (gp_rect_w(list->field) + last) >> list->side;
    int tiles = list->across * ((gp_rect_h(list->field) + last) >> list->side);
    size_t end = count_entries(p, *next, p->first[kind + 1], list, tiles,
                               in_tile);
    write_ranges(list, tiles, in_tile);
    for (size_t i = *next; i < end; i++)
        write_entries(&polygons->at[p->at[i].polygon], p, p->at[i].box, list,
                      in_tile);
    *next = end;
}

int gp_tile_inner(size_t most)
{
    int root = (int) ceil(sqrt((double) most));
    return root > 8 ? root : 8;
}
