// SPDX-License-Identifier: Apache-2.0
#include "glare/sources.h"

#include "core/memory.h"
#include "core/minmax.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

static float largest_channel(const float rgb[3])
{
    return gp_maxf(rgb[0], gp_maxf(rgb[1], rgb[2]));
}

// -- a list: make, add, finish, free ------------------------------------------

gp_status gp_sources_make(const struct gp_log *log,
    const struct gp_sources *like, size_t room, struct gp_sources *out)
{
    gp_status st;
    struct gp_sources s = *like; // its facts of the frame
    s.row = NULL;
    s.x = NULL;
    memset(s.rgb, 0, sizeof s.rgb);
    memset(s.flux, 0, sizeof s.flux);
    memset(s.energy, 0, sizeof s.energy);
    s.n = 0;
    s.box = (struct gp_rect) {0};
    s.brightest = 0.0f;
    GP_TRY(gp_alloc_zero(log, "sources", (size_t) s.h + 1, sizeof *s.row,
                         &s.row));
    GP_TRY(gp_alloc(log, "sources", room, sizeof *s.x, &s.x));
    for (int k = 0; k < 3; k++)
        GP_TRY(gp_alloc(log, "sources", room, sizeof *s.rgb[k], &s.rgb[k]));
    *out = s;
    s = (struct gp_sources) {0};
out:
    gp_sources_free(&s);
    return st;
}

void gp_sources_add(struct gp_sources *s, int x, int y, const float rgb[3])
{
    const float most = largest_channel(rgb);
    float v[3] = {rgb[0], rgb[1], rgb[2]};
    for (int k = 0; most < GP_FAINT && k < 3; k++) {
        v[k] = rgb[k] < FLT_MIN ? 0.0f : rgb[k];
        s->faint[k] += (double) rgb[k] - (double) v[k];
    }
    if (!(most >= FLT_MIN))
        return;
    s->x[s->n] = x;
    for (int k = 0; k < 3; k++) {
        s->rgb[k][s->n] = v[k];
        s->flux[k] += (double) v[k];
        s->energy[k] += (double) v[k] * (double) v[k];
    }
    s->brightest = gp_maxf(s->brightest, most);
    s->row[y + 1] = (uint32_t) ++s->n;
}

void gp_sources_copy(const struct gp_sources *src, uint32_t i, double share,
                     int x, int y, struct gp_sources *to)
{
    float rgb[3];
    for (int k = 0; k < 3; k++)
        rgb[k] = (float) ((double) src->rgb[k][i] * share);
    gp_sources_add(to, x, y, rgb);
}

void gp_sources_finish(struct gp_sources *s)
{
    struct gp_rect box = {s->w, s->h, 0, 0};
    for (int y = 0; y < s->h; y++) {
        if (s->row[y + 1] <= s->row[y]) { // a row without sources
            s->row[y + 1] = s->row[y];
            continue;
        }
        const int first = s->x[s->row[y]], last = s->x[s->row[y + 1] - 1];
        box.x0 = first < box.x0 ? first : box.x0;
        box.x1 = last >= box.x1 ? last + 1 : box.x1;
        box.y0 = y < box.y0 ? y : box.y0;
        box.y1 = y + 1;
    }
    s->n = s->row[s->h];
    s->box = s->n ? box : (struct gp_rect) {0};
}

void gp_sources_free(struct gp_sources *s)
{
    gp_free(s->row);
    gp_free(s->x);
    for (int k = 0; k < 3; k++)
        gp_free(s->rgb[k]);
    *s = (struct gp_sources) {0};
}

/* The mask's value in a pixel that counts from the data window's corner. */
static double share_of(const struct gp_plane *mask, const struct gp_sources *s,
                       int x, int y)
{
    const long long left = (long long) s->x0 + x - mask->window.x0;
    const long long top = (long long) s->y0 + y - mask->window.y0;
    const long long w = gp_rect_w(mask->window), h = gp_rect_h(mask->window);
    const bool inside = left >= 0 && left < w && top >= 0 && top < h;
    const float v = inside ? mask->v[top * w + left] : 0.0f;
    return v > 0.0f ? (double) gp_minf(v, 1.0f) : 0.0;
}

gp_status gp_sources_scale(const struct gp_log *log,
                           const struct gp_sources *src, double share,
                           const struct gp_plane *mask, struct gp_sources *out)
{
    gp_status st = gp_sources_make(log, src, src->n, out);
    if (st)
        return st;
    out->darkest *= share;
    for (int y = 0; y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const int x = src->x[i];
            const double own = mask ? share_of(mask, src, x, y) : 1.0;
            gp_sources_copy(src, i, share * own, x, y, out);
        }
    }
    gp_sources_finish(out);
    return GP_OK;
}

// -- two lists to one ---------------------------------------------------------

/* Row order; of one pixel, the darker first: sums do not depend on the order
 * that they were given in. */
static int by_place(const void *a, const void *b)
{
    const struct gp_source *const p = a, *const q = b;
    if (p->y != q->y)
        return p->y < q->y ? -1 : 1;
    if (p->x != q->x)
        return p->x < q->x ? -1 : 1;
    for (int k = 0; k < 3; k++) {
        if (p->rgb[k] != q->rgb[k])
            return p->rgb[k] < q->rgb[k] ? -1 : 1;
    }
    return 0;
}

gp_status gp_sources_join(const struct gp_log *log,
    const struct gp_sources *src, struct gp_source *more, size_t n,
    struct gp_sources *out)
{
    for (size_t i = 0; i < n; i++) {
        if (more[i].x < 0 || more[i].x >= src->w || more[i].y < 0 ||
            more[i].y >= src->h)
            return gp_fail_bare(log, GP_ERR_BUG,
                                "light at %d,%d: outside the frame (%dx%d); "
                                "report this", more[i].x, more[i].y,
                                src->w, src->h);
    }
    // in row order, those of one pixel together
    size_t kept = 0;
    if (n)
        qsort(more, n, sizeof *more, by_place);
    for (size_t i = 0; i < n; i++) {
        struct gp_source *const last = kept ? &more[kept - 1] : NULL;
        if (!(largest_channel(more[i].rgb) > 0.0f))
            continue;
        if (last && last->x == more[i].x && last->y == more[i].y) {
            for (int k = 0; k < 3; k++)
                last->rgb[k] += more[i].rgb[k]; // limited below
        } else {
            more[kept++] = more[i];
        }
    }
    n = kept;
    gp_status st = gp_sources_make(log, src, src->n + n, out);
    if (st)
        return st;
    size_t at = 0;
    for (int y = 0; y < src->h; y++) { // both lists in step
        uint32_t i = src->row[y];
        while (i < src->row[y + 1] || (at < n && more[at].y == y)) {
            const int mx = at < n && more[at].y == y ? more[at].x : src->w;
            const int sx = i < src->row[y + 1] ? src->x[i] : src->w;
            float rgb[3];
            for (int k = 0; k < 3; k++)
                rgb[k] = gp_minf((sx <= mx ? src->rgb[k][i] : 0.0f) +
                                 (mx <= sx ? more[at].rgb[k] : 0.0f), FLT_MAX);
            gp_sources_add(out, sx < mx ? sx : mx, y, rgb);
            i += sx <= mx;
            at += mx <= sx;
        }
    }
    gp_sources_finish(out);
    return GP_OK;
}

gp_status gp_sources_list(const struct gp_log *log, const struct gp_sources *s,
                          struct gp_source **out)
{
    struct gp_source *list;
    const gp_status st = gp_alloc(log, "layer", s->n, sizeof *list, &list);
    if (st)
        return st;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
            list[i] = (struct gp_source) {
                s->x[i], y, {s->rgb[0][i], s->rgb[1][i], s->rgb[2][i]}};
    }
    *out = list;
    return GP_OK;
}

gp_status gp_sources_planes(const struct gp_log *log,
                            const struct gp_sources *s, struct gp_planes *p)
{
    const size_t n = (size_t) s->w * (size_t) s->h;
    gp_status st = gp_planes_make(log, "sources", n, p);
    if (st)
        return st;
    gp_planes_clear(p, 0, n);
    for (int k = 0; k < 3; k++) {
        for (int y = 0; y < s->h; y++) {
            float *const row = p->c[k] + (size_t) y * (size_t) s->w;
            for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
                row[s->x[i]] = s->rgb[k][i];
        }
    }
    return GP_OK;
}
