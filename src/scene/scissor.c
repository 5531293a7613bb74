/* Scissor and range of depths of a light, from its objects and tiles. */
#include "scene/scissor.h"

#include <limits.h>

static struct gp_screen_box widened(struct gp_screen_box b)
{
    b.near *= 1.0 - GP_DEPTH_SLACK;
    b.far *= 1.0 + GP_DEPTH_SLACK;
    return b;
}

/* Returns the bounds of the tiles of b, in pixels, that have depths of its
 * range. */
static struct gp_scissor of_tiles(const struct gp_hidden *h,
                                  const struct gp_screen_box *b)
{
    const struct gp_rect w = h->window, r = gp_screen_pixels(b, w);
    const int across = h->w[GP_TILE_LEVEL];
    struct gp_scissor s = {.near = INFINITY, .far = -INFINITY};
    if (gp_rect_empty(r))
        return (struct gp_scissor) {0};
    struct gp_rect tile = {INT_MAX, INT_MAX, INT_MIN, INT_MIN};
    for (int y = (r.y0 - w.y0) / GP_TILE; y <= (r.y1 - 1 - w.y0) / GP_TILE;
         y++) {
        const float *const least = h->least + y * across,
                    *const most = h->most[GP_TILE_LEVEL] + y * across;
        for (int x = (r.x0 - w.x0) / GP_TILE;
             x <= (r.x1 - 1 - w.x0) / GP_TILE; x++) {
            const double lo = (double) least[x], hi = (double) most[x];
            if (!(lo <= b->far && hi >= b->near && lo < INFINITY))
                continue;
            tile = gp_rect_join(tile, (struct gp_rect) {x, y, x + 1, y + 1});
            s.near = lo < s.near ? lo : s.near;
            s.far = hi > s.far ? hi : s.far;
        }
    }
    if (gp_rect_empty(tile))
        return (struct gp_scissor) {0};
    s.rect = gp_rect_meet(
        r, (struct gp_rect) {w.x0 + tile.x0 * GP_TILE, w.y0 + tile.y0 * GP_TILE,
                             w.x0 + tile.x1 * GP_TILE,
                             w.y0 + tile.y1 * GP_TILE});
    s.near = fmax(s.near, b->near);
    s.far = fmin(s.far, b->far);
    return s;
}

struct gp_screen_box gp_scissor_visible(const struct gp_hidden *h,
                                        const struct gp_screen_box *box)
{
    const struct gp_screen_box b = widened(*box);
    if (h->levels == 0 || !b.seen)
        return *box;
    const struct gp_scissor s = of_tiles(h, &b);
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
        return of_tiles(h, &b);
    const struct gp_scissor s = {gp_screen_pixels(&b, h->window), b.near,
                                 b.far};
    return gp_rect_empty(s.rect) ? (struct gp_scissor) {0} : s;
}
