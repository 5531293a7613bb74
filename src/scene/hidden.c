/* A hierarchy of the frame's greatest depths. */
#include "scene/hidden.h"

#include "core/cpu.h"
#include "core/depth.h"
#include "core/memory.h"
#include "core/minmax.h"

/* Returns floor(v) as an int, cut to what fits with room for a picture: without
 * the call that processors of 2003 need. NaN becomes the greatest. */
static inline int floor_of(double v)
{
    static const double far = 1e9;
    const double cut = v < -far ? -far : v < far ? v : far;
    const int whole = (int) cut;
    return whole - ((double) whole > cut);
}

static inline int ceil_of(double v)
{
    static const double far = 1e9;
    const double cut = v < -far ? -far : v < far ? v : far;
    const int whole = (int) cut;
    return whole + ((double) whole < cut);
}

struct gp_rect gp_screen_pixels(const struct gp_screen_box *b,
                                struct gp_rect window)
{
    if (!b->seen)
        return (struct gp_rect) {0};
    return gp_rect_meet(window,
                        (struct gp_rect) {floor_of(b->x0), floor_of(b->y0),
                                          ceil_of(b->x1), ceil_of(b->y1)});
}

// -- making ------------------------------------------------------------------

enum { STRIP = 512 }; // pixels of a row at a time, whole tiles

/* Fills a level with the greatest of each 2 x 2 of the one below. */
static GP_CLONES void fill_level(struct gp_hidden *h, int level)
{
    const int w = h->w[level - 1], rows = h->h[level - 1];
    const float *const from = h->most[level - 1];
    float *to = h->most[level];
    float most[STRIP] = {0};
    for (int y = 0; y < rows; y += 2) {
        const float *const a = from + (size_t) y * (size_t) w;
        const float *const b = y + 1 < rows ? a + w : a;
        for (int x = 0; x < w; x += STRIP) {
            const int n = gp_min(STRIP, w - x), pairs = n / 2;
            for (int i = 0; i < n; i++)
                most[i] = gp_maxf(a[x + i], b[x + i]);
            for (int i = 0; i < pairs; i++)
                to[i] = gp_maxf(most[2 * i], most[2 * i + 1]);
            to += pairs;
            if (n % 2)
                *to++ = most[n - 1];
        }
    }
}

/* Fills a row of tiles from pixels [x, x + n) of rows [y, end). */
static GP_CLONES void fill_strip(struct gp_hidden *h, int x, int n, int y,
                                 int end)
{
    float low[STRIP], high[STRIP];
    for (int i = 0; i < n; i++) {
        low[i] = INFINITY;
        high[i] = 0.0f;
    }
    for (int k = y; k < end; k++) {
        const float *const row =
            h->most[0] + (size_t) k * (size_t) h->w[0] + (size_t) x;
        for (int i = 0; i < n; i++) {
            const float z = row[i], surface = z < GP_DEPTH_HUGE ? z : 0.0f;
            low[i] = gp_minf(z, low[i]);
            high[i] = gp_maxf(surface, high[i]);
        }
    }
    const size_t first =
        (size_t) (y / GP_TILE) * (size_t) h->w[GP_TILE_LEVEL];
    for (int i = 0; i < n; i++) {
        const size_t tile = first + (size_t) ((x + i) / GP_TILE);
        h->least[tile] = gp_minf(low[i], h->least[tile]);
        h->deepest[tile] = gp_maxf(high[i], h->deepest[tile]);
    }
}

static void fill_tiles(struct gp_hidden *h)
{
    const int tiles = h->w[GP_TILE_LEVEL] * h->h[GP_TILE_LEVEL];
    for (int i = 0; i < tiles; i++) {
        h->least[i] = INFINITY;
        h->deepest[i] = 0.0f;
    }
    for (int y = 0; y < h->h[0]; y += GP_TILE) {
        for (int x = 0; x < h->w[0]; x += STRIP)
            fill_strip(h, x, gp_min(STRIP, h->w[0] - x), y,
                       gp_min(y + GP_TILE, h->h[0]));
    }
}

gp_status gp_hidden_make(const struct gp_log *log, struct gp_rect window,
                         const float *depth, struct gp_hidden *out)
{
    gp_status st = GP_OK;
    struct gp_hidden h = {.window = window};
    int w = gp_rect_w(window), rows = gp_rect_h(window);
    while (h.levels <= GP_TILE_LEVEL || h.w[h.levels - 1] > 1 ||
           h.h[h.levels - 1] > 1) {
        const int k = h.levels;
        h.w[k] = w;
        h.h[k] = rows;
        GP_TRY(gp_alloc(log, "depths of the scene", (size_t) w * (size_t) rows,
                        sizeof *h.most[k], &h.most[k]));
        h.levels++;
        w = (w + 1) / 2;
        rows = (rows + 1) / 2;
    }
    const size_t n = (size_t) h.w[0] * (size_t) h.h[0];
    for (size_t i = 0; i < n; i++)
        h.most[0][i] = depth[i] > 0.0f && depth[i] < GP_DEPTH_HUGE ? depth[i]
                                                                   : INFINITY;
    for (int k = 1; k < h.levels; k++)
        fill_level(&h, k);
    const size_t tiles =
        (size_t) h.w[GP_TILE_LEVEL] * (size_t) h.h[GP_TILE_LEVEL];
    GP_TRY(gp_alloc(log, "tiles of the scene", tiles, sizeof *h.least,
                    &h.least));
    GP_TRY(gp_alloc(log, "tiles of the scene", tiles, sizeof *h.deepest,
                    &h.deepest));
    fill_tiles(&h);
out:
    if (st)
        gp_hidden_free(&h);
    *out = h;
    return st;
}

double gp_hidden_deepest(const struct gp_hidden *h)
{
    double deepest = 0.0;
    const int tiles = h->levels > 0 ? h->w[GP_TILE_LEVEL] * h->h[GP_TILE_LEVEL]
                                    : 0;
    for (int i = 0; i < tiles; i++)
        deepest = fmax(deepest, (double) h->deepest[i]);
    return deepest * (1.0 + GP_DEPTH_SLACK);
}

void gp_hidden_free(struct gp_hidden *h)
{
    for (int k = 0; k < 32; k++)
        gp_free(h->most[k]);
    gp_free(h->least);
    gp_free(h->deepest);
    *h = (struct gp_hidden) {0};
}

// -- asking ------------------------------------------------------------------

bool gp_hidden_box(const struct gp_hidden *h, const struct gp_screen_box *b)
{
    const struct gp_rect r = gp_screen_pixels(b, h->window);
    if (gp_rect_empty(r))
        return true;
    const double near = b->near * (1.0 - GP_DEPTH_SLACK);
    const int x0 = r.x0 - h->window.x0, x1 = r.x1 - 1 - h->window.x0;
    const int y0 = r.y0 - h->window.y0, y1 = r.y1 - 1 - h->window.y0;
    // from the level where four cells at most cover it, down to those cells
    // that are not behind `near`
    int level = 0;
    while (level + 1 < h->levels && ((x1 >> level) - (x0 >> level) > 1 ||
                                     (y1 >> level) - (y0 >> level) > 1))
        level++;
    struct {
        int level, x, y;
    } stack[4 * 32];
    int n = 0;
    for (int y = y0 >> level; y <= y1 >> level; y++) {
        for (int x = x0 >> level; x <= x1 >> level; x++) {
            stack[n].level = level;
            stack[n].x = x;
            stack[n++].y = y;
        }
    }
    while (n > 0) {
        n--;
        const int k = stack[n].level, x = stack[n].x, y = stack[n].y;
        if (near > (double) h->most[k][(size_t) y * (size_t) h->w[k] +
                                       (size_t) x])
            continue;
        if (k == 0)
            return false;
        for (int i = 0; i < 4; i++) { // the parts that are in the bounds
            const int u = 2 * x + (i & 1), v = 2 * y + (i >> 1);
            if (u < x0 >> (k - 1) || u > x1 >> (k - 1) || v < y0 >> (k - 1) ||
                v > y1 >> (k - 1))
                continue;
            stack[n].level = k - 1;
            stack[n].x = u;
            stack[n++].y = v;
        }
    }
    return true;
}
