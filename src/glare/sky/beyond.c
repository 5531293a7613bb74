// SPDX-License-Identifier: Apache-2.0
/* Light from beside the frame. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sky_priv.h"

#include <math.h>

/* Sources that count as one: their light times solid angle, and its middle. */
struct group {
    double x, y, rgb[3], all;
};

/* Groups of 2^k x 2^k pixels, from the first source's row and column on. */
struct groups {
    int w, h;
    struct group *at; // owned
};

enum { LEVELS = 14, TILE = 32 };

struct beyond {
    const struct gp_sky *s;
    struct groups level[LEVELS];
    int levels;
    double x0, y0; // of the sources' corner and ...
    double dx, dy; // ... the frame's
    int w, h;
    struct gp_planes *layer;
};

static void join_group(struct group *to, const struct group *g)
{
    const double all = to->all + g->all, share = all > 0.0 ? g->all / all : 0.0;
    to->x += share * (g->x - to->x);
    to->y += share * (g->y - to->y);
    to->all = all;
    for (int c = 0; c < 3; c++)
        to->rgb[c] += g->rgb[c];
}

static gp_status make_groups(const struct gp_log *log,
                             const struct gp_source *source, size_t n,
                             struct beyond *b)
{
    int x0 = source[0].x, y0 = source[0].y, x1 = x0, y1 = y0;
    gp_status st = GP_OK;
    for (size_t i = 1; i < n; i++) {
        x0 = gp_min(x0, source[i].x);
        y0 = gp_min(y0, source[i].y);
        x1 = gp_max(x1, source[i].x);
        y1 = gp_max(y1, source[i].y);
    }
    int w = x1 - x0 + 1, h = y1 - y0 + 1;
    b->x0 = x0 + b->dx;
    b->y0 = y0 + b->dy;
    for (b->levels = 0; b->levels < LEVELS && !st;
         w = (w + 1) / 2, h = (h + 1) / 2) {
        struct groups *const g = &b->level[b->levels++];
        *g = (struct groups) {w, h, NULL};
        st = gp_alloc_zero(log, "lights", (size_t) w * (size_t) h,
                           sizeof *g->at, &g->at);
        if (w * h == 1)
            break;
    }
    for (size_t i = 0; i < n && !st; i++) {
        const int x = source[i].x - x0, y = source[i].y - y0;
        struct group one = {.x = b->x0 + x, .y = b->y0 + y};
        const double solid =
            gp_projection_solid(&b->s->p.projection, one.x, one.y);
        for (int c = 0; c < 3; c++) {
            one.rgb[c] = solid * (double) source[i].rgb[c];
            one.all += one.rgb[c];
        }
        for (int l = 0; l < b->levels; l++)
            join_group(&b->level[l].at[(y >> l) * b->level[l].w + (x >> l)],
                       &one);
    }
    return st;
}

/* Adds a group's light to a tile. */
static void add_group(const struct beyond *b, const struct group *g,
                      bool single, struct gp_rect tile)
{
    static const double FAR = 24.0; // pixels, of a mean that is one sample
    const struct gp_sky *const s = b->s;
    const struct gp_projection *const p = &s->p.projection;
    const size_t w = (size_t) b->w;
    for (int y = tile.y0; y < tile.y1; y++) {
        int span[2];
        gp_projection_span(p, b->dx, y + b->dy, b->w, span);
        for (int x = gp_max(tile.x0, span[0]); x < gp_min(tile.x1, span[1]);
             x++) {
            const double at[2] = {x + b->dx, y + b->dy}, from[2] = {g->x, g->y};
            const double c = gp_projection_chord2(p, at[0], at[1], g->x, g->y);
            double v = gp_sky_soft(&s->light, 0.0, c);
            if (single && fmax(fabs(at[0] - g->x), fabs(at[1] - g->y)) < FAR)
                v = gp_sky_pixel(s, at, from,
                                 gp_sky_ellipse_at(p, at[0], at[1]).most) /
                    gp_projection_solid(p, g->x, g->y);
            for (int k = s->from; k < s->to; k++)
                b->layer->c[k][(size_t) y * w + (size_t) x] +=
                    (float) (v * g->rgb[k]);
        }
    }
}

/* Tests whether a group counts as one for a tile. Over a side of s at a distance of d its
 * light is off by some (s / d)^2 / 3. */
static bool is_far(const struct beyond *b, int level, int x, int y,
                   struct gp_rect tile)
{
    static const double WIDE = 0.06;
    const double side = ldexp(1.0, level);
    const double left = b->x0 + x * side - b->dx;
    const double top = b->y0 + y * side - b->dy;
    const double u = fmax(fmax(tile.x0 - left - side, left - tile.x1), 0.0);
    const double v = fmax(fmax(tile.y0 - top - side, top - tile.y1), 0.0);
    return side < WIDE * sqrt(u * u + v * v);
}

/* Adds all light to a tile: of groups, or of their quarters where they are too near. */
static void add_all(const struct beyond *b, struct gp_rect tile)
{
    struct {
        int level, x, y;
    } left[4 * LEVELS] = {{b->levels - 1, 0, 0}};
    int n = 1;
    while (n > 0) {
        const int level = left[--n].level, x = left[n].x, y = left[n].y;
        const struct groups *const g = &b->level[level];
        const struct group *const one = &g->at[y * g->w + x];
        if (!(one->all > 0.0))
            continue;
        if (!level || is_far(b, level, x, y, tile)) {
            add_group(b, one, !level, tile);
            continue;
        }
        for (int i = 0; i < 4; i++) {
            left[n].level = level - 1;
            left[n].x = 2 * x + i % 2;
            left[n].y = 2 * y + i / 2;
            if (left[n].x < g[-1].w && left[n].y < g[-1].h)
                n++;
        }
    }
}

static void add_tile(void *ctx, int i, GP_UNUSED int thread)
{
    const struct beyond *const b = ctx;
    const int across = (b->w + TILE - 1) / TILE;
    const int x = i % across * TILE, y = i / across * TILE;
    add_all(b, (struct gp_rect) {x, y, gp_min(x + TILE, b->w),
                                 gp_min(y + TILE, b->h)});
}

gp_status gp_kernel_add_beyond(const struct gp_log *log,
                               const struct gp_kernel *k,
                               const struct gp_source *source, size_t n, int w,
                               int h, struct gp_planes *layer)
{
    const struct gp_sky *const sky = k->sky;
    struct beyond b = {
        .s = sky,
        .dx = 0.5 * (sky->p.w - w),
        .dy = 0.5 * (sky->p.h - h),
        .w = w,
        .h = h,
        .layer = layer,
    };
    gp_status st = GP_OK;
    struct gp_cosines_kept *kept = NULL;
    if (!n)
        return st;
    if (sky->p.cosines)
        GP_TRY(gp_cosines_add(log, sky->p.cosines, source, n,
                              (struct gp_rect) {0, 0, w, h}, layer, true,
                              &kept));
    if (!sky->p.n)
        goto out;
    GP_TRY(make_groups(log, source, n, &b));
    for (; b.s; b.s = b.s->next)
        gp_parallel_do((w + TILE - 1) / TILE * ((h + TILE - 1) / TILE),
                       add_tile, &b);
out:
    gp_cosines_kept_free(&kept);
    for (int l = 0; l < b.levels; l++)
        gp_free(b.level[l].at);
    return st;
}
