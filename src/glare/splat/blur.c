// SPDX-License-Identifier: Apache-2.0
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/splat/splat_priv.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* -- the blurred kernel ---------------------------------------------------- */

enum { STRIP = 64 }; // columns a task takes

/* A box of side q * 2^n is q samples added as they are written, then n times
 * the sum of itself and its own shifted half: few additions, and none that
 * cancels, so that what is 0 stays 0 (running sums would leave dust there). */
struct blurring {
    const struct gp_kernel *kernel;
    struct gp_rect crop;
    bool hollow;
    int side, odd;      // side = odd * 2^n
    const struct gp_blur *out;
    int strips;
    size_t scratch;     // doubles of a thread
    double *buffer;
};

/* Adds to each of n samples of `width` numbers those `by`, 2 * by, ...
 * times * by before it; from the last backwards, so that nothing is
 * overwritten that is still needed. */
static void add_shifted(double *v, int n, int width, int by, int times)
{
    for (int i = n - 1; i >= by; i--) {
        double *const to = v + (size_t) i * (size_t) width;
        for (int k = 1; k <= times && i - k * by >= 0; k++) {
            const double *const from =
                v + (size_t) (i - k * by) * (size_t) width;
            for (int x = 0; x < width; x++)
                to[x] += from[x];
        }
    }
}

/* Turns n samples of `width` numbers each into box sums that end at each
 * sample. */
static void sum_box(const struct blurring *b, double *v, int n, int width)
{
    add_shifted(v, n, width, 1, b->odd - 1);
    for (int half = b->odd; half < b->side; half *= 2)
        add_shifted(v, n, width, half, 1);
}

/* Blurs one strip of columns of one channel, all rows: each row on its own,
 * then all rows down. */
static void blur_strip(void *ctx, int i, int thread)
{
    const struct blurring *const b = ctx;
    const struct gp_kernel *const k = b->kernel;
    const int c = i / b->strips, x0 = i % b->strips * STRIP;
    const int before = b->side - 1;
    const int w = gp_rect_w(b->crop), h = gp_rect_h(b->crop);
    const int n = gp_min(b->out->w - x0, STRIP);
    double *const row = b->buffer + b->scratch * (size_t) thread;
    double *const rows = row + STRIP + before;
    const double scale = 1.0 / ((double) b->side * b->side);
    memset(rows, 0, (size_t) b->out->h * STRIP * sizeof *rows);
    for (int y = 0; y < h; y++) {
        const int ky = b->crop.y0 + y;
        const float *const in = gp_row(k->k.c[c], k->w, ky) + b->crop.x0;
        const bool middle = b->hollow && abs(ky - k->cy) <= GP_MIDDLE_RADIUS;
        for (int j = 0; j < n + before; j++) {
            const int x = x0 - before + j;
            const bool left_out = x < 0 || x >= w ||
                (middle && abs(b->crop.x0 + x - k->cx) <= GP_MIDDLE_RADIUS);
            row[j] = left_out ? 0.0 : (double) in[x];
        }
        sum_box(b, row, n + before, 1);
        memcpy(rows + (size_t) y * STRIP, row + before,
               (size_t) n * sizeof *row);
    }
    sum_box(b, rows, b->out->h, STRIP);
    for (int y = 0; y < b->out->h; y++) {
        float *const to = gp_row(b->out->k.c[c], b->out->w, y) + x0;
        for (int x = 0; x < n; x++)
            to[x] = (float) (rows[(size_t) y * STRIP + (size_t) x] * scale);
    }
}

gp_status gp_blur_make(const struct gp_log *log, const struct gp_kernel *kernel,
    struct gp_rect crop, bool hollow, int side, struct gp_blur *out)
{
    gp_status st;
    struct gp_blur o = {.grey = kernel->grey};
    struct blurring b = {.kernel = kernel, .hollow = hollow, .side = side,
                         .out = &o};
    crop = gp_rect_meet(crop, (struct gp_rect) {0, 0, kernel->w, kernel->h});
    if (!gp_rect_empty(crop)) {
        o.w = gp_rect_w(crop) + side - 1;
        o.h = gp_rect_h(crop) + side - 1;
    }
    o.cx = (float) (kernel->cx - crop.x0) + (float) (side - 1) / 2.0f;
    o.cy = (float) (kernel->cy - crop.y0) + (float) (side - 1) / 2.0f;
    const size_t n = (size_t) o.w * (size_t) o.h;
    GP_TRY(gp_planes_make(log, "blurred kernel", n, &o.k));
    if (o.w) {
        b.crop = crop;
        b.odd = side >> __builtin_ctz((unsigned) side);
        b.strips = (o.w + STRIP - 1) / STRIP;
        b.scratch = (size_t) (STRIP + side - 1) + (size_t) o.h * STRIP;
        GP_TRY(gp_alloc(log, "blurred kernel", (size_t) gp_threads(),
                        b.scratch * sizeof *b.buffer, &b.buffer));
        const int channels = o.grey ? 1 : 3;
        gp_parallel_do(channels * b.strips, blur_strip, &b);
        for (int c = channels; c < 3; c++)
            memcpy(o.k.c[c], o.k.c[0], n * sizeof(float));
    }
    *out = o;
    o = (struct gp_blur) {0};
out:
    gp_free(b.buffer);
    gp_planes_free(&o.k);
    return st;
}

/* -- shrinking ------------------------------------------------------------- */

gp_status gp_rings_make(const struct gp_log *log, const struct gp_kernel *k,
    struct gp_rect crop, bool hollow, struct gp_rings *out)
{
    struct gp_rings r = {0};
    if (!gp_rect_empty(crop))
        r.n = 1 + gp_max(gp_max(k->cx - crop.x0, crop.x1 - 1 - k->cx),
                         gp_max(k->cy - crop.y0, crop.y1 - 1 - k->cy));
    const size_t n = (size_t) r.n + 1;
    gp_status st =
        gp_alloc_zero(log, "rings", 4 * n, sizeof(double), &r.beyond[0]);
    if (st)
        return st;
    r.peak = r.beyond[0] + 3 * n;
    for (size_t c = 0; c < 3; c++) {
        r.beyond[c] = r.beyond[0] + c * n;
        for (int y = crop.y0; y < crop.y1; y++) {
            const float *const row = gp_row(k->k.c[c], k->w, y);
            for (int x = crop.x0; x < crop.x1; x++) {
                const int d = gp_max(abs(x - k->cx), abs(y - k->cy));
                const double size = fabs((double) row[x]);
                if (hollow && d <= GP_MIDDLE_RADIUS)
                    continue; // drawn elsewhere
                r.beyond[c][d] += size;
                r.peak[d] = gp_maxd(r.peak[d], size);
            }
        }
        for (int i = r.n - 1; i >= 0; i--)
            r.beyond[c][i] += r.beyond[c][i + 1];
    }
    for (int i = r.n - 1; i >= 0; i--)
        r.peak[i] = gp_maxd(r.peak[i], r.peak[i + 1]);
    *out = r;
    return GP_OK;
}

/* The light of polygons by bin. */
struct lights {
    double bin[GP_SOURCE_BINS];
    double all;
};

/* Rings that a polygon with the most light of the bin keeps: those up to the
 * last one where it is over `least`. */
static int rings_kept(const struct gp_rings *r, int bin, double least)
{
    static const int last = (0xff << 1) - 1; // beyond it are Inf and NaN
    const float v = gp_source_bin_start(bin < last ? bin + 1 : last + 1);
    const double light = isfinite(v) ? (double) v : 0x1p128;
    int low = 0, high = r->n; // the peaks fall
    while (low < high) {
        const int mid = (low + high) / 2;
        if (light * r->peak[mid] > least)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

/* Share of all light that is left out; left[i] of a polygon's goes beyond ring
 * i - 1. */
static double share_left_out(const struct gp_rings *r, const double *left,
                             const struct lights *l, double least)
{
    double sum = 0.0;
    for (int b = 0; b < GP_SOURCE_BINS; b++) {
        if (l->bin[b] > 0.0)
            sum += l->bin[b] * left[rings_kept(r, b, least)];
    }
    return sum / l->all;
}

gp_status gp_shrink_make(const struct gp_log *log,
    const struct gp_kernel *kernel, const struct gp_splat_params *p,
    const struct gp_polygons *polygons, struct gp_shrink *out)
{
    gp_status st = GP_OK;
    const bool hollow = !gp_splat_single(p);
    struct lights l = {0};
    struct gp_rings r = {0};
    double *left = NULL;
    struct gp_shrink s = {0};
    int side = 1;
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const q = &polygons->at[i];
        l.bin[gp_source_bin(q->light)] += (double) q->light;
        l.all += (double) q->light;
        side = gp_max(side, gp_blur_box[q->blur]);
    }
    const int carry = side / 2 + 1; // by a polygon's blur and its place between
                                    // pixels, in whole pixels
    for (int b = 0; b < GP_SOURCE_BINS; b++)
        s.reach[b] = INT_MAX / 2;
    if (p->shrink > 0.0f && l.all > 0.0) {
        const struct gp_rect whole = {0, 0, kernel->w, kernel->h};
        GP_TRY(gp_rings_make(log, kernel, whole, hollow, &r));
        GP_TRY(gp_alloc_zero(log, "shrinking", (size_t) r.n + 1, sizeof *left,
                             &left));
        for (int i = 0; i <= r.n; i++) {
            for (int c = 0; c < 3; c++) {
                if (kernel->norm1[c] > 0.0)
                    left[i] = fmax(left[i],
                                   r.beyond[c][i] / kernel->norm1[c]);
            }
        }
        // the largest float for which at most the share is left out: floats
        // over 0 are in the order of their bits
        uint32_t low = 0, high = 0x7f800000; // 0 leaves nothing out; Inf
        while (high - low > 1) {
            const uint32_t mid = low + (high - low) / 2;
            if (share_left_out(&r, left, &l,
                               (double) gp_float_with_bits(mid)) <=
                (double) p->shrink)
                low = mid;
            else
                high = mid;
        }
        s.least = gp_float_with_bits(low);
        s.left_out = share_left_out(&r, left, &l, (double) s.least);
        for (int b = 0; b < GP_SOURCE_BINS; b++) {
            const int n = rings_kept(&r, b, (double) s.least);
            const int reach = n ? n - 1 + carry : 0;
            s.reach[b] = hollow ? gp_max(reach, GP_MIDDLE_RADIUS) : reach;
        }
    }
    *out = s;
out:
    gp_free(r.beyond[0]);
    gp_free(left);
    return st;
}

/* -- the picture of polygons ----------------------------------------------- */

/* Paints pixel (x, y) green, if it is in the frame. */
static void paint(const struct gp_sources *frame, int x, int y,
                  struct gp_planes *picture)
{
    const size_t at = (size_t) y * (size_t) frame->w + (size_t) x;
    for (int c = 0; c < 3; c++) {
        if (x >= 0 && x < frame->w && y >= 0 && y < frame->h)
            picture->c[c][at] = c == 1 ? 1.0f : 0.0f;
    }
}

gp_status gp_polygons_outline(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k,
    const struct gp_splat_params *p, struct gp_planes *picture)
{
    gp_status st;
    struct gp_polygons polygons = {0};
    struct gp_shrink shrink;
    GP_TRY(gp_polygons_make(log, src, p, &polygons));
    GP_TRY(gp_shrink_make(log, k, p, &polygons, &shrink));
    for (size_t n = 0; n < polygons.n; n++) {
        // the first and the last of the pixels that the polygon lights; they
        // may leave the frame, and may be none
        const struct gp_polygon *const q = &polygons.at[n];
        const double reach = shrink.reach[gp_source_bin(q->light)];
        const double wider = (gp_blur_box[q->blur] - 1) / 2.0;
        const double x = (double) q->x, y = (double) q->y;
        const int x0 = (int) ceil(x - fmin(reach, k->cx + wider));
        const int x1 = (int) floor(x + fmin(reach, k->w - 1 - k->cx + wider));
        const int y0 = (int) ceil(y - fmin(reach, k->cy + wider));
        const int y1 = (int) floor(y + fmin(reach, k->h - 1 - k->cy + wider));
        if (x0 > x1 || y0 > y1)
            continue;
        for (int i = gp_max(x0, 0); i <= gp_min(x1, src->w - 1); i++) {
            paint(src, i, y0, picture);
            paint(src, i, y1, picture);
        }
        for (int i = gp_max(y0, 0); i <= gp_min(y1, src->h - 1); i++) {
            paint(src, x0, i, picture);
            paint(src, x1, i, picture);
        }
    }
out:
    gp_free(polygons.at);
    return st;
}
