// SPDX-License-Identifier: Apache-2.0
#include "glare/direct/direct.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/engine.h"

#include <limits.h>
#include <math.h>
#include <string.h>

enum {
    LANES = 8,
    STRIP = GP_TAPS_PAD,       // columns a task takes; 4 vectors
    GROUP = 32,                // sources summed before the sum is put aside
    LINE = 64 / sizeof(float), // floats of a cache line
};

typedef float vector __attribute__((vector_size(4 * LANES)));
typedef float loose
    __attribute__((vector_size(4 * LANES), aligned(4), may_alias));

/* A source as one strip sees it: taps[base + y * pitch] is the kernel's
 * sample for the strip's first column of row y. */
struct strip_source {
    ptrdiff_t base;
    float rgb[3];
};

struct direct {
    const struct gp_sources *src;
    const struct gp_taps *taps;
    struct gp_planes *layer;
    bool add;
    struct strip_source *list; // scratch: src->n for each thread
    uint32_t *row;             // h + 1 for each thread
};

gp_status gp_taps_cut(const struct gp_log *log, const struct gp_kernel *k,
                      int rx, int ry, struct gp_taps *out)
{
    // the cut, in kernel pixels; the centre may lie outside the kernel
    const struct gp_rect cut = gp_kernel_around(k, rx, ry);
    struct gp_taps t = {
        .w = gp_rect_w(cut), .h = gp_rect_h(cut),
        .cx = k->cx - cut.x0, .cy = k->cy - cut.y0,
    };
    t.pitch = (size_t) t.w + 2 * GP_TAPS_PAD;
    // one block, as it fills huge pages
    const int channels = k->grey ? 1 : 3;
    const size_t plane = t.pitch * (size_t) t.h;
    gp_status st = gp_alloc(log, "kernel", (size_t) channels * plane,
                            sizeof(float), &t.k[0]);
    if (st)
        return st;
    for (int c = 1; c < 3; c++)
        t.k[c] = t.k[0] + (k->grey ? 0 : (size_t) c * plane);
    for (int i = 0; i < channels * t.h; i++) {
        const int c = i / t.h, y = i % t.h + cut.y0;
        float *const row = t.k[0] + (size_t) i * t.pitch;
        memset(row, 0, t.pitch * sizeof *row);
        memcpy(row + GP_TAPS_PAD, gp_row(k->k.c[c], k->w, y) + cut.x0,
               (size_t) t.w * sizeof *row);
    }
    *out = t;
    return GP_OK;
}

/* sum[c][0..STRIP) = sum over the n sources of rgb[c] * taps. */
GP_CLONES static void sum_strip(const struct strip_source *s, uint32_t n,
                                const float *k0, const float *k1,
                                const float *k2, ptrdiff_t row_at,
                                float sum[3][STRIP])
{
    vector total[3][STRIP / LANES] = {0}, lost[3][STRIP / LANES] = {0};
    while (n > 0) {
        const uint32_t group = n < GROUP ? n : GROUP;
        vector a[3][STRIP / LANES] = {0};
        for (uint32_t i = 0; i < group; i++) {
            const ptrdiff_t at = s[i].base + row_at;
            for (int v = 0; v < STRIP / LANES; v++) {
                a[0][v] += s[i].rgb[0] * *(const loose *) (k0 + at + v * LANES);
                a[1][v] += s[i].rgb[1] * *(const loose *) (k1 + at + v * LANES);
                a[2][v] += s[i].rgb[2] * *(const loose *) (k2 + at + v * LANES);
            }
        }
        for (int c = 0; c < 3; c++) {
            for (int v = 0; v < STRIP / LANES; v++) { // Kahan 1965
                const vector more = a[c][v] - lost[c][v];
                const vector next = total[c][v] + more;
                lost[c][v] = (next - total[c][v]) - more;
                total[c][v] = next;
            }
        }
        s += group;
        n -= group;
    }
    memcpy(sum, total, sizeof total);
}

static void run_strip(void *ctx, int strip, int thread)
{
    const struct direct *const d = ctx;
    const struct gp_sources *const s = d->src;
    const struct gp_taps *const t = d->taps;
    const int w = s->w, h = s->h, x0 = strip * STRIP;
    const int cols = w - x0 < STRIP ? w - x0 : STRIP;
    struct strip_source *const list = d->list + (size_t) thread * s->n;
    uint32_t *const row = d->row + (size_t) thread * ((size_t) h + 1);
    // the sources that reach columns [x0, x0 + STRIP): one at x reaches
    // [x - cx, x - cx + w)
    const int left = x0 + t->cx - t->w + 1, right = x0 + STRIP + t->cx;
    uint32_t n = 0;
    for (int y = 0; y < h; y++) {
        row[y] = n;
        uint32_t i = gp_first_from(s->x, s->row[y], s->row[y + 1], left);
        for (; i < s->row[y + 1] && s->x[i] < right; i++) {
            list[n++] = (struct strip_source) {
                .base = ((ptrdiff_t) t->cy - y) * (ptrdiff_t) t->pitch +
                        (x0 - s->x[i] + t->cx + GP_TAPS_PAD),
                .rgb = {s->rgb[0][i], s->rgb[1][i], s->rgb[2][i]},
            };
        }
    }
    row[h] = n;
    for (int y = 0; y < h; y++) {
        // source rows whose kernel reaches y: y - sy + cy in [0, t->h)
        int from = y + t->cy - t->h + 1, to = y + t->cy + 1;
        from = from < 0 ? 0 : from > h ? h : from;
        to = to < from ? from : to > h ? h : to;
        if (d->add && row[to] == row[from])
            continue;
        float sum[3][STRIP];
        for (int c = 0; c < 3; c++) { // the layer comes while the sum is made
            const float *const out = d->layer->c[c] + (size_t) y * (size_t) w;
            __builtin_prefetch(out + x0, 1);
            __builtin_prefetch(out + x0 + LINE, 1);
        }
        sum_strip(list + row[from], row[to] - row[from], t->k[0], t->k[1],
                  t->k[2], (ptrdiff_t) y * (ptrdiff_t) t->pitch, sum);
        for (int c = 0; c < 3; c++) {
            float *const out = d->layer->c[c] + (size_t) y * (size_t) w + x0;
            for (int x = 0; x < cols; x++)
                out[x] = d->add ? out[x] + sum[c][x] : sum[c][x];
        }
    }
}

gp_status gp_direct_sum(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_taps *taps, bool add, struct gp_planes *layer)
{
    gp_status st;
    const size_t threads = (size_t) gp_threads();
    struct direct d = {.src = src, .taps = taps, .layer = layer, .add = add};
    GP_TRY(gp_alloc(log, "direct", threads * src->n, sizeof *d.list, &d.list));
    GP_TRY(gp_alloc(log, "direct", threads * ((size_t) src->h + 1),
                    sizeof *d.row, &d.row));
    gp_parallel_do((src->w + STRIP - 1) / STRIP, run_strip, &d);
out:
    gp_free(d.list);
    gp_free(d.row);
    return st;
}

/* Bounds rel_l2 of the sum of n sources, as long as no product is under the range
 * of float: GROUP terms, each within 2^-24; then groups, whose sum is within
 * 2 * 2^-24 and n 2^-48 (Higham 2002, eq. 4.8); then the sum to the layer. Light of a
 * kernel that is negative somewhere can cancel while the rounding stays. */
static double bound_of(const struct gp_kernel *k, size_t n)
{
    return k->over * ((GROUP + 4.0) * 0x1p-24 + (double) n * 0x1p-48);
}

/* Length of the overlap of [at - c, at - c + n) and [0, limit). */
static int overlap(int at, int c, int n, int limit)
{
    const int from = at - c > 0 ? at - c : 0;
    const int to = at - c + n < limit ? at - c + n : limit;
    return to > from ? to - from : 0;
}

double gp_direct_work(const struct gp_sources *src, int w, int h, int cx,
                      int cy, double most)
{
    double work = 0.0;
    for (int y = 0; y < src->h && work <= most; y++) {
        const double rows = overlap(y, cy, h, src->h);
        double cols = 0.0;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
            cols += overlap(src->x[i], cx, w, src->w);
        work += rows * cols;
    }
    return work;
}

static gp_status run_direct(const struct gp_glare_request *req, void **state)
{
    struct gp_taps taps;
    gp_status st =
        gp_taps_cut(req->log, req->kernel, INT_MAX / 2, INT_MAX / 2, &taps);
    (void) state;
    if (st)
        return st;
    if (!(req->stats->bound > 0.0))
        req->stats->bound = bound_of(req->kernel, req->src->n);
    st = gp_direct_sum(req->log, req->src, &taps, false, req->layer);
    gp_free(taps.k[0]);
    return st;
}

static gp_status bound_direct(const struct gp_glare_request *req, void **state,
                              double *out)
{
    (void) state;
    *out = bound_of(req->kernel, req->src->n);
    return GP_OK;
}

static gp_status pixel_direct(const struct gp_glare_request *req, void **state,
                              struct gp_pixel_error *out)
{
    (void) state;
    out->relative = bound_of(req->kernel, req->src->n);
    return GP_OK;
}

const struct gp_engine gp_engine_direct = {
    .name = "direct",
    .text = "the sum as it is written; the fastest for a handful of sources",
    .bound = bound_direct,
    .pixel = pixel_direct,
    .run = run_direct,
};
