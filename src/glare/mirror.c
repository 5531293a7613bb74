// SPDX-License-Identifier: Apache-2.0
/* The mirror image of a picture around it: --edges mirror. */
#include "core/minmax.h"
#include "glare/edges.h"

int gp_mirror_reach(int w, int h)
{
    return (gp_min(w, h) + 3) / 4;
}

/* The place in [0, n) that i in [-n, 2 n) shows. */
static int mirrored(int i, int n)
{
    return i < 0 ? -1 - i : i < n ? i : 2 * n - 1 - i;
}

gp_status gp_mirror_sources(const struct gp_log *log,
                            const struct gp_sources *src, int reach,
                            struct gp_sources *out)
{
    struct gp_sources like = *src;
    const int w = src->w, h = src->h;
    size_t n = 0;
    like.w += 2 * reach;
    like.h += 2 * reach;
    like.x0 -= reach;
    like.y0 -= reach;
    for (int y = -reach; y < h + reach; y++) {
        const int from = mirrored(y, h);
        for (uint32_t i = src->row[from]; i < src->row[from + 1]; i++)
            n += 1u + (src->x[i] < reach) + (src->x[i] >= w - reach);
    }
    gp_status st = gp_sources_make(log, &like, n, out);
    if (st)
        return st;
    for (int y = -reach; y < h + reach; y++) {
        const int from = mirrored(y, h);
        const uint32_t first = src->row[from], end = src->row[from + 1];
        for (uint32_t i = end; i-- > first;) { // left of the picture
            if (src->x[i] < reach)
                gp_sources_copy(src, i, 1.0, reach - 1 - src->x[i], y + reach,
                                out);
        }
        for (uint32_t i = first; i < end; i++)
            gp_sources_copy(src, i, 1.0, reach + src->x[i], y + reach, out);
        for (uint32_t i = end; i-- > first;) {
            if (src->x[i] >= w - reach)
                gp_sources_copy(src, i, 1.0, reach + 2 * w - 1 - src->x[i],
                                y + reach, out);
        }
    }
    gp_sources_finish(out);
    return GP_OK;
}

static gp_status mirror_planes(const struct gp_log *log,
    const struct gp_planes *p, int w, int h, int reach, struct gp_planes *out)
{
    const size_t wide = (size_t) w + 2 * (size_t) reach;
    gp_status st = gp_planes_make(log, "mirror image",
                                  wide * ((size_t) h + 2 * (size_t) reach), out);
    for (int c = 0; !st && c < 3; c++) {
        for (int y = -reach; y < h + reach; y++) {
            const float *const from = gp_row(p->c[c], w, mirrored(y, h));
            float *const to = out->c[c] + (size_t) (y + reach) * wide;
            for (int x = -reach; x < w + reach; x++)
                to[x + reach] = from[mirrored(x, w)];
        }
    }
    return st;
}

/* Sets *at to the mirrored sources of `one`: those that are there, or `own`,
 * which is made. */
static gp_status mirror_other(const struct gp_log *log,
    const struct gp_sources *one, const struct gp_sources *src, int reach,
    const struct gp_sources *there, struct gp_sources *own,
    const struct gp_sources **at)
{
    *at = one == src ? there : one ? own : NULL;
    return *at == own && one ? gp_mirror_sources(log, one, reach, own) : GP_OK;
}

gp_status gp_mirror(const struct gp_log *log, const struct gp_surround *edges,
    const struct gp_sources *src, const struct gp_planes *rgb,
    struct gp_mirrored *m)
{
    gp_status st;
    *m = (struct gp_mirrored) {
        .reach = gp_mirror_reach(src->w, src->h),
        .edges = {.how = GLAREPP_EXTEND},
    };
    GP_TRY(gp_mirror_sources(log, src, m->reach, &m->src));
    GP_TRY(mirror_other(log, edges->picture, src, m->reach, &m->src,
                        &m->picture, &m->edges.picture));
    if (edges->own != edges->picture)
        GP_TRY(mirror_other(log, edges->own, src, m->reach, &m->src, &m->own,
                            &m->edges.own));
    if (rgb)
        GP_TRY(mirror_planes(log, rgb, src->w, src->h, m->reach, &m->rgb));
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
