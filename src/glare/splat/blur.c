#include "glare/splat/blur.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <stdlib.h>
#include <string.h>

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

/* n samples of `width` numbers each to box sums that end at each sample. */
static void box(const struct blurring *b, double *v, int n, int width)
{
    add_shifted(v, n, width, 1, b->odd - 1);
    for (int half = b->odd; half < b->side; half *= 2)
        add_shifted(v, n, width, half, 1);
}

/* Samples x0 .. x0 + n of row y of the crop; 0 outside and in the core. */
static void load_row(const struct blurring *b, int c, int y, int x0, int n,
                     double *row)
{
    const struct gp_kernel *const k = b->kernel;
    const int ky = b->crop.y0 + y, w = gp_rect_w(b->crop);
    const float *const in =
        k->k.c[c] + (size_t) ky * (size_t) k->w + b->crop.x0;
    const bool core = b->tail && abs(ky - k->cy) <= GP_CORE_RADIUS;
    for (int i = 0; i < n; i++) {
        const int x = x0 + i;
        const bool left_out =
            x < 0 || x >= w ||
            (core && abs(b->crop.x0 + x - k->cx) <= GP_CORE_RADIUS);
        row[i] = left_out ? 0.0 : (double) in[x];
    }
}

/* One strip of columns of one channel, all rows. */
static void blur_strip(void *ctx, int i, int thread)
{
    const struct blurring *const b = ctx;
    const int c = i / b->strips, x0 = i % b->strips * STRIP;
    const int before = b->side - 1, h = gp_rect_h(b->crop);
    const int n = b->out->w - x0 < STRIP ? b->out->w - x0 : STRIP;
    double *const row = b->buffer + b->scratch * (size_t) thread;
    double *const rows = row + STRIP + before;
    const double scale = 1.0 / ((double) b->side * b->side);
    memset(rows, 0, (size_t) b->out->h * STRIP * sizeof *rows);
    for (int y = 0; y < h; y++) {
        load_row(b, c, y, x0 - before, n + before, row);
        box(b, row, n + before, 1);
        memcpy(rows + (size_t) y * STRIP, row + before,
               (size_t) n * sizeof *row);
    }
    box(b, rows, b->out->h, STRIP);
    for (int y = 0; y < b->out->h; y++) {
        float *const to =
            b->out->k.c[c] + (size_t) y * (size_t) b->out->w + x0;
        for (int x = 0; x < n; x++)
            to[x] = (float) (rows[(size_t) y * STRIP + (size_t) x] * scale);
    }
}

static gp_status blur_planes(const struct gp_log *log, struct blurring *b)
{
    const int channels = b->out->grey ? 1 : 3;
    const size_t n = (size_t) b->out->w * (size_t) b->out->h;
    void *buffer;
    b->strips = (b->out->w + STRIP - 1) / STRIP;
    b->scratch = (size_t) (STRIP + b->side - 1) + (size_t) b->out->h * STRIP;
    gp_status st = gp_alloc(log, "blurred kernel", (size_t) gp_threads(),
                            b->scratch * sizeof *b->buffer, &buffer);
    if (st)
        return st;
    b->buffer = buffer;
    gp_parallel_do(channels * b->strips, blur_strip, b);
    for (int c = channels; c < 3; c++)
        memcpy(b->out->k.c[c], b->out->k.c[0], n * sizeof(float));
    gp_free(buffer);
    return GP_OK;
}

gp_status gp_blur_make(const struct gp_log *log,
                       const struct gp_kernel *kernel, struct gp_rect crop,
                       bool tail, int side, struct gp_blur *out)
{
    struct gp_blur o = {.grey = kernel->grey};
    crop = gp_rect_meet(crop, (struct gp_rect) {0, 0, kernel->w, kernel->h});
    if (!gp_rect_empty(crop)) {
        o.w = gp_rect_w(crop) + side - 1;
        o.h = gp_rect_h(crop) + side - 1;
    }
    o.cx = (float) (kernel->cx - crop.x0) + (float) (side - 1) / 2.0f;
    o.cy = (float) (kernel->cy - crop.y0) + (float) (side - 1) / 2.0f;
    gp_status st = gp_planes_make(log, "blurred kernel",
                                  (size_t) o.w * (size_t) o.h, &o.k);
    struct blurring b = {
        .kernel = kernel, .crop = crop, .tail = tail, .side = side,
        .odd = side, .out = &o,
    };
    while (b.odd % 2 == 0)
        b.odd /= 2;
    if (!st && o.w)
        st = blur_planes(log, &b);
    if (st)
        gp_blur_free(&o);
    else
        *out = o;
    return st;
}

void gp_blur_free(struct gp_blur *b)
{
    gp_planes_free(&b->k);
    *b = (struct gp_blur) {0};
}
