#include "glare/splat/outline.h"

#include "core/memory.h"
#include "glare/splat/blur.h"
#include "glare/splat/group.h"

#include <math.h>

/* Lines are counted by their ends, +1 where one starts and -1 behind its last
 * pixel, so that a frame full of polygons costs no more than its pixels. */
struct lines {
    int w, h;
    int32_t *across;  // (w + 1) * h: ends of horizontal lines
    int32_t *down;    // w * (h + 1): ends of vertical lines
};

/* Pixels that a polygon lights, from the first to the last; may leave the
 * frame, and may be none. */
struct square {
    int x0, y0, x1, y1;
};

static struct square find_square(const struct gp_kernel *k,
                                  const struct gp_shrink *shrink,
                                  const struct gp_polygon *p)
{
    const double reach = shrink->reach[gp_source_bin(p->light)];
    const double wider = (gp_blur_box[p->blur] - 1) / 2.0;
    const double x = (double) p->x, y = (double) p->y;
    return (struct square) {
        (int) ceil(x - fmin(reach, k->cx + wider)),
        (int) ceil(y - fmin(reach, k->cy + wider)),
        (int) floor(x + fmin(reach, k->w - 1 - k->cx + wider)),
        (int) floor(y + fmin(reach, k->h - 1 - k->cy + wider)),
    };
}

static void add_across(struct lines *l, int y, int x0, int x1)
{
    const size_t row = (size_t) y * ((size_t) l->w + 1);
    x0 = x0 > 0 ? x0 : 0;
    x1 = x1 < l->w - 1 ? x1 : l->w - 1;
    if (y < 0 || y >= l->h || x0 > x1)
        return;
    l->across[row + (size_t) x0]++;
    l->across[row + (size_t) x1 + 1]--;
}

static void add_down(struct lines *l, int x, int y0, int y1)
{
    y0 = y0 > 0 ? y0 : 0;
    y1 = y1 < l->h - 1 ? y1 : l->h - 1;
    if (x < 0 || x >= l->w || y0 > y1)
        return;
    l->down[(size_t) y0 * (size_t) l->w + (size_t) x]++;
    l->down[((size_t) y1 + 1) * (size_t) l->w + (size_t) x]--;
}

static void add_square(struct lines *l, struct square s)
{
    if (s.x0 > s.x1 || s.y0 > s.y1)
        return;
    add_across(l, s.y0, s.x0, s.x1);
    add_across(l, s.y1, s.x0, s.x1);
    add_down(l, s.x0, s.y0, s.y1);
    add_down(l, s.x1, s.y0, s.y1);
}

static void draw(struct lines *l, struct gp_planes *picture)
{
    static const float green[3] = {0.0f, 1.0f, 0.0f};
    const size_t w = (size_t) l->w;
    for (size_t y = 0; y < (size_t) l->h; y++) {
        int32_t across = 0;
        for (size_t x = 0; x < w; x++) {
            across += l->across[y * (w + 1) + x];
            // (the row above holds the lines that come from there)
            if (y > 0)
                l->down[y * w + x] += l->down[(y - 1) * w + x];
            if (across == 0 && l->down[y * w + x] == 0)
                continue;
            for (int c = 0; c < 3; c++)
                picture->c[c][y * w + x] = green[c];
        }
    }
}

gp_status gp_outline(const struct gp_log *log, const struct gp_sources *src,
                     const struct gp_kernel *kernel,
                     const struct gp_splat_params *p,
                     struct gp_planes *picture)
{
    gp_status st;
    struct gp_polygons polygons = {0};
    struct gp_shrink shrink;
    struct lines l = {src->w, src->h, NULL, NULL};
    const size_t w = (size_t) src->w, h = (size_t) src->h;
    void *across = NULL, *down = NULL;

    GP_TRY(gp_group(log, src, p, &polygons));
    GP_TRY(gp_shrink_make(log, kernel, p, &polygons, &shrink));
    GP_TRY(gp_alloc_zero(log, "outlines", (w + 1) * h, sizeof *l.across,
                         &across));
    GP_TRY(gp_alloc_zero(log, "outlines", w * (h + 1), sizeof *l.down, &down));
    l.across = across;
    l.down = down;
    for (size_t i = 0; i < polygons.n; i++)
        add_square(&l, find_square(kernel, &shrink, &polygons.at[i]));
    draw(&l, picture);
out:
    gp_free(across);
    gp_free(down);
    gp_polygons_free(&polygons);
    return st;
}
