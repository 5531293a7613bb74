#include "core/cpu.h"
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
    bool tail;
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
        const float *const in =
            k->k.c[c] + (size_t) ky * (size_t) k->w + b->crop.x0;
        const bool core = b->tail && abs(ky - k->cy) <= GP_CORE_RADIUS;
        for (int j = 0; j < n + before; j++) {
            const int x = x0 - before + j;
            const bool left_out = x < 0 || x >= w ||
                (core && abs(b->crop.x0 + x - k->cx) <= GP_CORE_RADIUS);
            row[j] = left_out ? 0.0 : (double) in[x];
        }
        sum_box(b, row, n + before, 1);
        memcpy(rows + (size_t) y * STRIP, row + before,
               (size_t) n * sizeof *row);
    }
    sum_box(b, rows, b->out->h, STRIP);
    for (int y = 0; y < b->out->h; y++) {
        float *const to = b->out->k.c[c] + (size_t) y * (size_t) b->out->w + x0;
        for (int x = 0; x < n; x++)
            to[x] = (float) (rows[(size_t) y * STRIP + (size_t) x] * scale);
    }
}

gp_status gp_blur_make(const struct gp_log *log, const struct gp_kernel *kernel,
    struct gp_rect crop, bool tail, int side, struct gp_blur *out)
{
    gp_status st;
    struct gp_blur o = {.grey = kernel->grey};
    struct blurring b = {.kernel = kernel, .tail = tail, .side = side,
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
    gp_blur_free(&o);
    return st;
}

void gp_blur_free(struct gp_blur *b)
{
    gp_planes_free(&b->k);
    *b = (struct gp_blur) {0};
}

/* -- shrinking ------------------------------------------------------------- */

/* The kernel by square rings around its centre: ring d holds the samples
 * with max(|dx|, |dy|) = d, rings first .. first + n - 1 all samples. */
struct rings {
    int first, n;
    float *peak;  // largest magnitude on ring first + i or any beyond
    double *left; // share of the kernel beyond ring first + i, largest channel
    double whole; // the same beyond no ring: 1, or the tail's share
};

/* The light of polygons by bin. */
struct lights {
    double bin[GP_SOURCE_BINS];
    double all;
};

/* Samples [x0, x1) of a row that lie on one ring. */
GP_CLONES static void add_flat(const float *row, int x0, int x1,
                               double *restrict sum, float *restrict peak)
{
    double total = 0.0;
    float most = *peak;
    for (int x = x0; x < x1; x++) {
        const float v = fabsf(row[x]);
        total += (double) v;
        most = v > most ? v : most;
    }
    *sum += total;
    *peak = most;
}

/* n samples from `from` on, each on the ring after the last one's; `way` is 1
 * to the right, -1 to the left. */
GP_CLONES static void add_outward(const float *from, int way, int n,
                                  double *restrict sum, float *restrict peak)
{
    for (int i = 0; i < n; i++) {
        const float v = fabsf(from[i * way]);
        sum[i] += (double) v;
        peak[i] = v > peak[i] ? v : peak[i];
    }
}

static gp_status make_rings(const struct gp_log *log, const struct gp_kernel *k,
    bool tail, struct rings *r)
{
    gp_status st;
    double *sum = NULL; // of magnitudes, by ring
    // distances of the kernel's sides from its centre, which may be outside
    const int left = -k->cx, right = k->w - 1 - k->cx;
    const int top = -k->cy, bottom = k->h - 1 - k->cy;
    r->first = gp_max(0, gp_max(gp_max(left, -right), gp_max(top, -bottom)));
    r->n = gp_max(gp_max(abs(left), abs(right)),
                  gp_max(abs(top), abs(bottom))) - r->first + 1;
    const size_t n = (size_t) r->n;
    GP_TRY(gp_alloc_zero(log, "shrinking", n, sizeof *r->peak, &r->peak));
    GP_TRY(gp_alloc_zero(log, "shrinking", n, sizeof *r->left, &r->left));
    GP_TRY(gp_alloc(log, "shrinking", n, sizeof *sum, &sum));
    for (int c = 0; c < (k->grey ? 1 : 3); c++) {
        memset(sum, 0, n * sizeof *sum);
        for (int y = 0; y < k->h; y++) {
            const float *const row = k->k.c[c] + (size_t) y * (size_t) k->w;
            const int dy = abs(y - k->cy);
            const bool core = tail && dy <= GP_CORE_RADIUS; // drawn elsewhere
            const int flat = core ? GP_CORE_RADIUS : dy;
            const int x0 = gp_clamp(k->cx - flat, 0, k->w);
            const int x1 = gp_clamp(k->cx + flat + 1, 0, k->w);
            if (!core && x0 < x1)
                add_flat(row, x0, x1, sum + dy - r->first,
                         r->peak + dy - r->first);
            if (x0 > 0) { // starts on the ring of its rightmost sample
                const int at = k->cx - (x0 - 1) - r->first;
                add_outward(row + x0 - 1, -1, x0, sum + at, r->peak + at);
            }
            if (x1 < k->w) {
                const int at = x1 - k->cx - r->first;
                add_outward(row + x1, 1, k->w - x1, sum + at, r->peak + at);
            }
        }
        if (!(k->norm1[c] > 0.0))
            continue;
        double beyond = 0.0;
        for (int i = r->n - 1; i >= 0; i--) {
            r->left[i] = fmax(r->left[i], beyond / k->norm1[c]);
            beyond += sum[i];
        }
        r->whole = fmax(r->whole, beyond / k->norm1[c]);
    }
    for (int i = r->n - 2; i >= 0; i--)
        r->peak[i] = fmaxf(r->peak[i], r->peak[i + 1]);
out:
    gp_free(sum);
    return st;
}

/* Rings that a polygon with the most light of the bin keeps: those up to the
 * last one where it is over `least`. */
static int rings_kept(const struct rings *r, int bin, double least)
{
    static const int last = (0xff << 1) - 1; // beyond it are Inf and NaN
    const float v = gp_source_bin_start(bin < last ? bin + 1 : last + 1);
    const double light = isfinite(v) ? (double) v : 0x1p128;
    int low = 0, high = r->n; // the peaks fall
    while (low < high) {
        const int mid = (low + high) / 2;
        if (light * (double) r->peak[mid] > least)
            low = mid + 1;
        else
            high = mid;
    }
    return low;
}

/* Share of all light that is left out. */
static double share_left_out(const struct rings *r, const struct lights *l,
                             double least)
{
    double sum = 0.0;
    for (int b = 0; b < GP_SOURCE_BINS; b++) {
        if (!(l->bin[b] > 0.0))
            continue;
        const int n = rings_kept(r, b, least);
        sum += l->bin[b] * (n ? r->left[n - 1] : r->whole);
    }
    return sum / l->all;
}

gp_status gp_shrink_make(const struct gp_log *log,
    const struct gp_kernel *kernel, const struct gp_splat_params *p,
    const struct gp_polygons *polygons, struct gp_shrink *out)
{
    gp_status st = GP_OK;
    const bool tail = !gp_splat_single(p);
    struct lights l = {0};
    struct rings r = {0};
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
        GP_TRY(make_rings(log, kernel, tail, &r));
        // the largest float for which at most the share is left out: floats
        // over 0 are in the order of their bits
        uint32_t low = 0, high = 0x7f800000; // 0 leaves nothing out; Inf
        while (high - low > 1) {
            const uint32_t mid = low + (high - low) / 2;
            memcpy(&s.least, &mid, sizeof s.least);
            if (share_left_out(&r, &l, (double) s.least) <= (double) p->shrink)
                low = mid;
            else
                high = mid;
        }
        memcpy(&s.least, &low, sizeof s.least);
        s.left_out = share_left_out(&r, &l, (double) s.least);
        for (int b = 0; b < GP_SOURCE_BINS; b++) {
            const int n = rings_kept(&r, b, (double) s.least);
            const int reach = n ? r.first + n - 1 + carry : 0;
            s.reach[b] = tail ? gp_max(reach, GP_CORE_RADIUS) : reach;
        }
    }
    *out = s;
out:
    gp_free(r.peak);
    gp_free(r.left);
    return st;
}

/* -- the picture of polygons ----------------------------------------------- */

gp_status gp_polygons_outline(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    const struct gp_splat_params *p, struct gp_planes *picture)
{
    gp_status st;
    const struct gp_kernel *const k = kernel;
    struct gp_polygons polygons = {0};
    struct gp_shrink shrink;
    const size_t w = (size_t) src->w, h = (size_t) src->h;
    // lines are counted by their ends, +1 where one starts and -1 after its
    // last pixel, so that a frame full of polygons costs no more than its
    // pixels: (w + 1) * h of horizontal lines, w * (h + 1) of vertical ones
    int32_t *across = NULL, *down = NULL;
    GP_TRY(gp_polygons_make(log, src, p, &polygons));
    GP_TRY(gp_shrink_make(log, kernel, p, &polygons, &shrink));
    GP_TRY(gp_alloc_zero(log, "outlines", (w + 1) * h, sizeof *across,
                         &across));
    GP_TRY(gp_alloc_zero(log, "outlines", w * (h + 1), sizeof *down, &down));
    for (size_t n = 0; n < polygons.n; n++) {
        // the first and the last of the pixels that the polygon lights; they
        // may leave the frame, and may be none
        const struct gp_polygon *const q = &polygons.at[n];
        const double reach = shrink.reach[gp_source_bin(q->light)];
        const double wider = (gp_blur_box[q->blur] - 1) / 2.0;
        const double x = (double) q->x, y = (double) q->y;
        const int xs[2] = {
            (int) ceil(x - fmin(reach, k->cx + wider)),
            (int) floor(x + fmin(reach, k->w - 1 - k->cx + wider)),
        };
        const int ys[2] = {
            (int) ceil(y - fmin(reach, k->cy + wider)),
            (int) floor(y + fmin(reach, k->h - 1 - k->cy + wider)),
        };
        const int x0 = gp_max(xs[0], 0), x1 = gp_min(xs[1], src->w - 1);
        const int y0 = gp_max(ys[0], 0), y1 = gp_min(ys[1], src->h - 1);
        const bool none = xs[0] > xs[1] || ys[0] > ys[1];
        for (int i = 0; i < 2 && !none; i++) {
            if (ys[i] >= 0 && ys[i] < src->h && x0 <= x1) {
                int32_t *const row = across + (size_t) ys[i] * (w + 1);
                row[x0]++;
                row[x1 + 1]--;
            }
            if (xs[i] >= 0 && xs[i] < src->w && y0 <= y1) {
                down[(size_t) y0 * w + (size_t) xs[i]]++;
                down[((size_t) y1 + 1) * w + (size_t) xs[i]]--;
            }
        }
    }
    for (size_t y = 0; y < h; y++) {
        int32_t ends = 0;
        for (size_t x = 0; x < w; x++) {
            ends += across[y * (w + 1) + x];
            // (the row above holds the lines that come from there)
            if (y > 0)
                down[y * w + x] += down[(y - 1) * w + x];
            if (ends == 0 && down[y * w + x] == 0)
                continue;
            for (int c = 0; c < 3; c++)
                picture->c[c][y * w + x] = c == 1 ? 1.0f : 0.0f; // green
        }
    }
out:
    gp_free(across);
    gp_free(down);
    gp_polygons_free(&polygons);
    return st;
}
