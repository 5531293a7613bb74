/* Scissor and range of depths of a light, from its objects and tiles. */
#include "scene/scissor.h"

#include "core/memory.h"
#include "core/minmax.h"

#include <limits.h>

static struct gp_screen_box widened(struct gp_screen_box b)
{
    b.near *= 1.0 - GP_DEPTH_SLACK;
    b.far *= 1.0 + GP_DEPTH_SLACK;
    return b;
}

/* The tiles that pixels are in. */
static struct gp_rect tiles_of(const struct gp_hidden *h, struct gp_rect r)
{
    const struct gp_rect w = h->window;
    return (struct gp_rect) {
        (r.x0 - w.x0) / GP_TILE, (r.y0 - w.y0) / GP_TILE,
        (r.x1 - 1 - w.x0) / GP_TILE + 1, (r.y1 - 1 - w.y0) / GP_TILE + 1};
}

/* True where tile i has depths from near to far, and is lit; lit NULL: all
 * are. */
static inline bool tile_in(const struct gp_hidden *h, int i, double near,
                           double far, const uint8_t *lit)
{
    return ((double) h->least[i] <= far) & ((double) h->deepest[i] >= near) &
           (!lit || lit[i] == GP_TILE_LIT);
}

/* Returns the bounds of the tiles of r that are in. */
static struct gp_scissor of_tiles(const struct gp_hidden *h, struct gp_rect r,
                                  double near, double far, const uint8_t *lit)
{
    const struct gp_rect w = h->window;
    const int across = h->w[GP_TILE_LEVEL];
    float least = INFINITY, most = -INFINITY;
    if (gp_rect_empty(r))
        return (struct gp_scissor) {0};
    const struct gp_rect all = tiles_of(h, r);
    struct gp_rect tile = {INT_MAX, INT_MAX, INT_MIN, INT_MIN};
    for (int y = all.y0; y < all.y1; y++) {
        const int first = y * across;
        int x0 = INT_MAX, x1 = INT_MIN;
        for (int x = all.x0; x < all.x1; x++) {
            const int i = first + x;
            if (!tile_in(h, i, near, far, lit))
                continue;
            x0 = gp_min(x, x0);
            x1 = x + 1;
            least = gp_minf(h->least[i], least);
            most = gp_maxf(h->deepest[i], most);
        }
        if (x0 < x1)
            tile = (struct gp_rect) {gp_min(tile.x0, x0), gp_min(tile.y0, y),
                                     gp_max(tile.x1, x1), y + 1};
    }
    if (gp_rect_empty(tile))
        return (struct gp_scissor) {0};
    return (struct gp_scissor) {
        gp_rect_meet(r, (struct gp_rect) {
            w.x0 + tile.x0 * GP_TILE, w.y0 + tile.y0 * GP_TILE,
            w.x0 + tile.x1 * GP_TILE, w.y0 + tile.y1 * GP_TILE}),
        fmax((double) least, near), fmin((double) most, far)};
}

/* True where a tile of r is in. */
static bool any_tile(const struct gp_hidden *h, struct gp_rect r, double near,
                     double far, const uint8_t *lit)
{
    const struct gp_rect all = tiles_of(h, r);
    for (int y = all.y0; y < all.y1; y++) {
        const int first = y * h->w[GP_TILE_LEVEL];
        for (int x = all.x0; x < all.x1; x++) {
            if (tile_in(h, first + x, near, far, lit))
                return true;
        }
    }
    return false;
}

struct gp_screen_box gp_scissor_visible(const struct gp_hidden *h,
                                        const struct gp_screen_box *box)
{
    const struct gp_screen_box b = widened(*box);
    if (h->levels == 0 || !b.seen)
        return *box;
    const struct gp_scissor s = of_tiles(
        h, gp_screen_pixels(&b, h->window), b.near, b.far, NULL);
    if (gp_rect_empty(s.rect))
        return (struct gp_screen_box) {0};
    return (struct gp_screen_box) {
        fmax(b.x0, s.rect.x0), fmax(b.y0, s.rect.y0), fmin(b.x1, s.rect.x1),
        fmin(b.y1, s.rect.y1), s.near, s.far, true,
    };
}

struct gp_scissor gp_scissor_make(const struct gp_hidden *h,
                                  const struct gp_screen_box *box,
                                  const int *index, int n,
                                  const struct gp_screen_box *light)
{
    struct gp_screen_box all = {INFINITY, INFINITY, -INFINITY, -INFINITY,
                                INFINITY, -INFINITY, false};
    const struct gp_screen_box l = widened(*light);
    for (int i = 0; l.seen && i < n; i++) {
        const struct gp_screen_box *const b = &box[index[i]];
        const double x0 = b->x0 > l.x0 ? b->x0 : l.x0,
                     y0 = b->y0 > l.y0 ? b->y0 : l.y0,
                     x1 = b->x1 < l.x1 ? b->x1 : l.x1,
                     y1 = b->y1 < l.y1 ? b->y1 : l.y1,
                     near = b->near > l.near ? b->near : l.near,
                     far = b->far < l.far ? b->far : l.far;
        if (!b->seen || x0 > x1 || y0 > y1 || near > far)
            continue;
        all.seen = true;
        all.x0 = x0 < all.x0 ? x0 : all.x0;
        all.y0 = y0 < all.y0 ? y0 : all.y0;
        all.x1 = x1 > all.x1 ? x1 : all.x1;
        all.y1 = y1 > all.y1 ? y1 : all.y1;
        all.near = near < all.near ? near : all.near;
        all.far = far > all.far ? far : all.far;
    }
    if (!all.seen)
        return (struct gp_scissor) {0};
    const struct gp_screen_box b = widened(all);
    if (h->levels > 0)
        return of_tiles(h, gp_screen_pixels(&b, h->window), b.near, b.far,
                        NULL);
    const struct gp_scissor s = {gp_screen_pixels(&b, h->window), b.near,
                                 b.far};
    if (gp_rect_empty(s.rect))
        return (struct gp_scissor) {0};
    return s;
}

// -- tiles in the world ------------------------------------------------------

/* Returns the box around the visible points of a tile. */
static struct gp_box box_of(const struct gp_hidden *h,
                            const struct gp_camera *c, struct gp_rect display,
                            int tx, int ty)
{
    const int i = ty * h->w[GP_TILE_LEVEL] + tx;
    const struct gp_rect w = h->window;
    const double x[2] = {w.x0 + tx * GP_TILE,
                         fmin(w.x0 + (tx + 1.0) * GP_TILE, w.x1)};
    const double y[2] = {w.y0 + ty * GP_TILE,
                         fmin(w.y0 + (ty + 1.0) * GP_TILE, w.y1)};
    const struct gp_frustum f = gp_frustum_make(
        c, display, x, y, (double) h->least[i] * (1.0 - GP_DEPTH_SLACK),
        (double) h->deepest[i] * (1.0 + GP_DEPTH_SLACK));
    struct gp_box box = GP_BOX_EMPTY;
    for (int k = 0; k < 8; k++)
        box = gp_box_with(box, f.corner[k]);
    return box;
}

gp_status gp_lit_tiles_make(const struct gp_log *log, const struct gp_hidden *h,
                        const struct gp_camera *c, struct gp_rect display,
                        struct gp_lit_tiles *out)
{
    static const char what[] = "tiles of the scene";
    gp_status st = GP_OK;
    struct gp_lit_tiles t = {0};
    *out = t;
    if (h->levels == 0)
        return GP_OK;
    const int across = h->w[GP_TILE_LEVEL], down = h->h[GP_TILE_LEVEL];
    const size_t n = (size_t) across * (size_t) down;
    GP_TRY(gp_alloc(log, what, n, sizeof *t.box, &t.box));
    GP_TRY(gp_alloc_zero(log, what, n, 1, &t.lit));
    GP_TRY(gp_alloc(log, what, n, sizeof *t.seen, &t.seen));
    for (int i = 0; i < across * down; i++)
        t.box[i] = h->least[i] < INFINITY
                       ? box_of(h, c, display, i % across, i / across)
                       : GP_BOX_EMPTY;
    *out = t;
out:
    if (st)
        gp_lit_tiles_free(&t);
    return st;
}

void gp_lit_tiles_free(struct gp_lit_tiles *t)
{
    gp_free(t->box);
    gp_free(t->lit);
    gp_free(t->seen);
    *t = (struct gp_lit_tiles) {0};
}

struct gp_scissor gp_lit_tiles_light(struct gp_lit_tiles *t,
                                     const struct gp_hidden *h,
                                     const struct gp_scissor *s,
                                     const struct gp_reach *light,
                                     const struct gp_umbras *umbras,
                                     double texel)
{
    if (gp_rect_empty(s->rect))
        return *s;
    const struct gp_rect all = tiles_of(h, s->rect);
    for (int y = all.y0; y < all.y1; y++) {
        for (int x = all.x0; x < all.x1; x++) {
            const int i = y * h->w[GP_TILE_LEVEL] + x;
            const struct gp_v3 c = gp_box_middle(&t->box[i]),
                               e = gp_box_half(&t->box[i]);
            t->lit[i] = GP_TILE_BEYOND;
            if (gp_box_empty(t->box[i]) || gp_reach_too_far(light, c, e))
                continue;
            const double radius = gp_v3_length(e);
            if (gp_reach_beside(light, c, radius))
                continue;
            const struct gp_v3 wide =
                gp_texel_widen(light, texel, c, e, radius);
            t->lit[i] = gp_umbras_hold(umbras, c, wide) ? GP_TILE_DARK
                                                        : GP_TILE_LIT;
        }
    }
    return of_tiles(h, s->rect, s->near, s->far, t->lit);
}

bool gp_lit_tiles_show(const struct gp_lit_tiles *t, const struct gp_hidden *h,
                   const struct gp_scissor *s, const struct gp_screen_box *box)
{
    const struct gp_screen_box b = widened(*box);
    const struct gp_rect r =
        gp_rect_meet(s->rect, gp_screen_pixels(&b, h->window));
    const double near = b.near > s->near ? b.near : s->near;
    const double far = b.far < s->far ? b.far : s->far;
    return !gp_rect_empty(r) && any_tile(h, r, near, far, t->lit);
}

struct gp_scissor gp_lit_tiles_list(struct gp_lit_tiles *t,
                                    const struct gp_hidden *h,
                                    const struct gp_scissor *s)
{
    struct gp_scissor all = *s;
    t->seens = 0;
    if (h->levels == 0 || gp_rect_empty(s->rect))
        return all;
    const struct gp_rect tile = tiles_of(h, s->rect);
    for (int y = tile.y0; y < tile.y1; y++) {
        for (int x = tile.x0; x < tile.x1; x++) {
            const int i = y * h->w[GP_TILE_LEVEL] + x;
            if (t->lit[i] == GP_TILE_BEYOND)
                continue;
            t->seen[t->seens++] = t->box[i];
            all.near = fmin(all.near, (double) h->least[i]);
            all.far = fmax(all.far, (double) h->deepest[i]);
        }
    }
    all.near *= 1.0 - GP_DEPTH_SLACK;
    all.far *= 1.0 + GP_DEPTH_SLACK;
    return all;
}
