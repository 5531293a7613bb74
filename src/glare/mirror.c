// SPDX-License-Identifier: Apache-2.0
/* What is around a picture: its mirror image, --edges mirror, or its other side. */
#include "core/minmax.h"
#include "glare/edges.h"
#include "glare/kernel.h"

#include <stdlib.h>

int gp_mirror_reach(int w, int h)
{
    return (gp_min(w, h) + 3) / 4;
}

struct gp_margin gp_margin_of(const struct gp_surround *edges,
                              const struct gp_kernel *k, int w, int h)
{
    const int reach = edges->how == GLAREPP_MIRROR ? gp_mirror_reach(w, h) : 0;
    const int widest = gp_max(abs(k->cx), abs(k->w - 1 - k->cx));
    const int turn = edges->turn; // a far field is made for half of one
    return turn ? (struct gp_margin) {.x = k->far ? turn / 2
                                                  : gp_min(widest, turn),
                                      .turn = turn}
                : (struct gp_margin) {.x = reach, .y = reach};
}

/* The place in [0, n) that i in [-n, 2 n) shows. */
static int mirrored(int i, int n)
{
    return i < 0 ? -1 - i : i < n ? i : 2 * n - 1 - i;
}

/* The column that column x shows: of a part of a turn, where that has none, one of its
 * sides. */
static int shown(const struct gp_margin *m, int x, int w)
{
    if (!m->turn)
        return mirrored(x, w);
    const int around = x < 0 ? x + m->turn : x < w ? x : x - m->turn;
    return gp_min(gp_max(around, 0), w - 1);
}

/* The place of column x of a row in the picture, at side 0, or in the margin on the left,
 * -1, or on the right, 1; where a turn has no columns that is its mirror image. */
static int place_of(const struct gp_margin *m, int side, int x, int w)
{
    return !side     ? x
           : m->turn ? x + side * m->turn
                     : (side < 0 ? -1 : 2 * w - 1) - x;
}

/* Adds row y of sources to row `to` of a picture with a margin, from the left to the right,
 * or where `out` is NULL counts them. */
static size_t add_row(const struct gp_sources *src, const struct gp_margin *m,
                      int y, int to, struct gp_sources *out)
{
    const uint32_t first = src->row[y], last = src->row[y + 1];
    size_t n = 0;
    for (int side = -1; side <= 1; side++) {
        for (uint32_t k = first; k < last; k++) {
            const uint32_t i = side && !m->turn ? last - 1 - (k - first) : k;
            const int x = place_of(m, side, src->x[i], src->w);
            const bool has = x >= -m->x && x < src->w + m->x &&
                             (!side || x < 0 || x >= src->w);
            n += has;
            if (has && out)
                gp_sources_copy(src, i, 1.0, m->x + x, to, out);
        }
    }
    return n;
}

gp_status gp_mirror_sources(const struct gp_log *log,
                            const struct gp_sources *src,
                            const struct gp_margin *m, struct gp_sources *out)
{
    struct gp_sources like = *src;
    size_t n = 0;
    like.w += 2 * m->x;
    like.h += 2 * m->y;
    like.x0 -= m->x;
    like.y0 -= m->y;
    for (int y = 0; y < like.h; y++)
        n += add_row(src, m, mirrored(y - m->y, src->h), y, NULL);
    gp_status st = gp_sources_make(log, &like, n, out);
    if (st)
        return st;
    for (int y = 0; y < like.h; y++)
        (void) add_row(src, m, mirrored(y - m->y, src->h), y, out);
    gp_sources_finish(out);
    return GP_OK;
}

static gp_status mirror_planes(const struct gp_log *log,
                               const struct gp_planes *p, int w, int h,
                               const struct gp_margin *m, struct gp_planes *out)
{
    const size_t wide = (size_t) w + 2 * (size_t) m->x;
    gp_status st = gp_planes_make(log, "mirror image",
                                  wide * ((size_t) h + 2 * (size_t) m->y), out);
    for (int c = 0; !st && c < 3; c++) {
        for (int y = -m->y; y < h + m->y; y++) {
            const float *const from = gp_row(p->c[c], w, mirrored(y, h));
            float *const to = out->c[c] + (size_t) (y + m->y) * wide;
            for (int x = -m->x; x < w + m->x; x++)
                to[x + m->x] = from[shown(m, x, w)];
        }
    }
    return st;
}

gp_status gp_mirror(const struct gp_log *log, const struct gp_surround *edges,
                    const struct gp_sources *src, const struct gp_planes *rgb,
                    const struct gp_margin *margin, struct gp_mirrored *m)
{
    gp_status st;
    *m = (struct gp_mirrored) {
        .edges = {.how = margin->turn ? GLAREPP_BLACK : GLAREPP_EXTEND},
    };
    GP_TRY(gp_mirror_sources(log, src, margin, &m->src));
    m->edges.picture = !edges->picture         ? NULL
                       : edges->picture == src ? &m->src
                                               : &m->picture;
    if (m->edges.picture == &m->picture)
        GP_TRY(gp_mirror_sources(log, edges->picture, margin, &m->picture));
    if (edges->own && edges->own != edges->picture)
        m->edges.own = edges->own == src ? &m->src : &m->own;
    if (m->edges.own == &m->own)
        GP_TRY(gp_mirror_sources(log, edges->own, margin, &m->own));
    if (rgb)
        GP_TRY(mirror_planes(log, rgb, src->w, src->h, margin, &m->rgb));
out:
    return st;
}

void gp_mirrored_free(struct gp_mirrored *m)
{
    gp_sources_free(&m->src);
    gp_sources_free(&m->picture);
    gp_sources_free(&m->own);
    gp_planes_free(&m->rgb);
}
