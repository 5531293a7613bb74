#include "glare/extra.h"

#include "core/memory.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* Row order; of one pixel, the darker first: sums do not depend on the order
 * that they were given in. */
static int by_place(const void *a, const void *b)
{
    const struct gp_extra *const p = a, *const q = b;
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

/* Sorts, and puts those of one pixel together; how many are left. */
static size_t tidy(struct gp_extra *e, size_t n)
{
    size_t kept = 0;
    if (n)
        qsort(e, n, sizeof *e, by_place);
    for (size_t i = 0; i < n; i++) {
        if (!(e[i].rgb[0] > 0.0f) && !(e[i].rgb[1] > 0.0f) &&
            !(e[i].rgb[2] > 0.0f))
            continue;
        struct gp_extra *const last = kept ? &e[kept - 1] : NULL;
        if (last && last->x == e[i].x && last->y == e[i].y) {
            for (int k = 0; k < 3; k++)
                last->rgb[k] += e[i].rgb[k];
        } else {
            e[kept++] = e[i];
        }
    }
    return kept;
}

static float larger(float a, float b)
{
    return a > b ? a : b;
}

/* Counts a source into everything but the list. */
static void count(struct gp_sources *o, int x, int y, const float rgb[3])
{
    const float most = larger(rgb[0], larger(rgb[1], rgb[2]));
    for (int k = 0; k < 3; k++) {
        o->flux[k] += (double) rgb[k];
        o->energy[k] += (double) rgb[k] * (double) rgb[k];
    }
    o->brightest = larger(o->brightest, most);
    o->count[gp_source_bin(most)]++;
    const struct gp_rect at = {x, y, x + 1, y + 1};
    if (gp_rect_empty(o->box)) {
        o->box = at;
        return;
    }
    o->box.x0 = at.x0 < o->box.x0 ? at.x0 : o->box.x0;
    o->box.y0 = at.y0 < o->box.y0 ? at.y0 : o->box.y0;
    o->box.x1 = at.x1 > o->box.x1 ? at.x1 : o->box.x1;
    o->box.y1 = at.y1 > o->box.y1 ? at.y1 : o->box.y1;
}

static void append(struct gp_sources *o, int x, int y, const float rgb[3])
{
    o->x[o->n] = x;
    for (int k = 0; k < 3; k++)
        o->rgb[k][o->n] = rgb[k];
    o->n++;
    count(o, x, y, rgb);
}

/* Row by row, both lists in step. */
static void merge(const struct gp_sources *src, const struct gp_extra *e,
                  size_t n, struct gp_sources *o)
{
    size_t at = 0;
    for (int y = 0; y < src->h; y++) {
        uint32_t i = src->row[y];
        while (i < src->row[y + 1] || (at < n && e[at].y == y)) {
            const bool more = at < n && e[at].y == y;
            const int ex = more ? e[at].x : src->w;
            const int sx = i < src->row[y + 1] ? src->x[i] : src->w;
            float rgb[3] = {0.0f, 0.0f, 0.0f};
            for (int k = 0; k < 3; k++)
                rgb[k] = (sx <= ex ? src->rgb[k][i] : 0.0f) +
                         (ex <= sx ? e[at].rgb[k] : 0.0f);
            append(o, sx < ex ? sx : ex, y, rgb);
            i += sx <= ex;
            at += ex <= sx;
        }
        o->row[y + 1] = (uint32_t) o->n;
    }
}

gp_status gp_sources_with(const struct gp_log *log,
                          const struct gp_sources *src, struct gp_extra *extra,
                          size_t n, struct gp_sources *out)
{
    gp_status st;
    void *v;
    struct gp_sources o = *src;
    o.n = 0;
    o.row = NULL;
    o.x = NULL;
    o.box = (struct gp_rect) {0};
    o.brightest = 0.0f;
    memset(o.rgb, 0, sizeof o.rgb);
    memset(o.flux, 0, sizeof o.flux);
    memset(o.energy, 0, sizeof o.energy);
    memset(o.count, 0, sizeof o.count);
    for (size_t i = 0; i < n; i++) {
        if (extra[i].x < 0 || extra[i].x >= src->w || extra[i].y < 0 ||
            extra[i].y >= src->h)
            return gp_fail_bare(log, GP_ERR_BUG,
                                "light at %d,%d: outside the frame (%dx%d); "
                                "report this", extra[i].x, extra[i].y,
                                src->w, src->h);
    }
    n = tidy(extra, n);
    GP_TRY(gp_alloc_zero(log, "sources", (size_t) src->h + 1, sizeof *o.row,
                         &v));
    o.row = v;
    GP_TRY(gp_alloc(log, "sources", src->n + n, sizeof *o.x, &v));
    o.x = v;
    for (int k = 0; k < 3; k++) {
        GP_TRY(gp_alloc(log, "sources", src->n + n, sizeof *o.rgb[k], &v));
        o.rgb[k] = v;
    }
    merge(src, extra, n, &o);
    *out = o;
    o = (struct gp_sources) {0};
out:
    gp_sources_free(&o);
    return st;
}
