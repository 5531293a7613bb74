// SPDX-License-Identifier: Apache-2.0
#include "io/grow.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "core/half.h"

#include <limits.h>
#include <string.h>

// -- windows -----------------------------------------------------------------

/* Clamps v so that sums of four edges fit an int. */
static int edge(int64_t v)
{
    const int64_t most = INT_MAX / 4;
    return (int) (v < -most ? -most : v > most ? most : v);
}

struct gp_rect gp_grow_window(const struct gp_grow_params *p,
                              const struct gp_frame *f)
{
    const struct gp_rect r = gp_rect_empty(f->display)
                                 ? f->data
                                 : gp_rect_join(f->data, f->display);
    return (struct gp_rect) {
        edge((int64_t) r.x0 - p->left), edge((int64_t) r.y0 - p->top),
        edge((int64_t) r.x1 + p->right), edge((int64_t) r.y1 + p->bottom),
    };
}

/* Moves `to` away from `from` to a whole number of steps from it. */
static int step_out(int from, int to, int step)
{
    const int64_t way = (int64_t) to - from, rest = way % step;
    return edge(rest == 0 ? to : way > 0 ? to + step - rest : to - step - rest);
}

struct gp_rect gp_grow_align(const struct gp_frame *f, struct gp_rect window)
{
    struct gp_rect r = gp_rect_join(f->data, window), before;
    // ends: all steps divide the data window's corner, width and height, so at
    // the latest where the window is a whole number of data windows
    do {
        before = r;
        for (int i = 0; i < f->channels; i++) {
            const struct gp_channel *const c = &f->channel[i];
            if (c->colour >= 0)
                continue;
            r.x0 = step_out(f->data.x0, r.x0, c->xs);
            r.x1 = step_out(f->data.x0, r.x1, c->xs);
            r.y0 = step_out(f->data.y0, r.y0, c->ys);
            r.y1 = step_out(f->data.y0, r.y1, c->ys);
        }
    } while (memcmp(&r, &before, sizeof r) != 0);
    return r;
}

gp_status gp_grow_check(const struct gp_log *log, const struct gp_frame *f,
                        struct gp_rect r, long long max_pixels)
{
    // (renderers write an 8K frame without content as one pixel)
    enum { MUCH = 1 << 24, TIMES = 16, VAST = 8192 * 4320, MOST = 1 << 14 };
    const int most = INT_MAX / 4;
    const long long pixels = (long long) gp_rect_w(r) * gp_rect_h(r);
    const bool far = r.x0 <= -most || r.y0 <= -most || r.x1 >= most ||
                     r.y1 >= most;
    if (far || pixels > max_pixels)
        return gp_fail(log, GP_ERR_DATA,
            "%s: data window and display window are too large together "
            "(%d x %d pixels, at most %lld); give --grow none to keep the data "
            "window%s", f->path, gp_rect_w(r), gp_rect_h(r), max_pixels,
            far ? "" : ", or raise --max-pixels");
    if (pixels > VAST && (size_t) pixels / MOST > gp_frame_pixels(f))
        return gp_fail(
            log, GP_ERR_DATA,
            "%s: its data window (%d x %d pixels) would grow to %d x %d, over "
            "%d times as many; give --grow none to keep it",
            f->path, gp_frame_w(f), gp_frame_h(f), gp_rect_w(r), gp_rect_h(r),
            MOST);
    if (pixels > MUCH && (size_t) pixels / TIMES > gp_frame_pixels(f))
        gp_say(log, GP_LEVEL_WARN,
            "%s: its data window (%d x %d pixels) grows to %d x %d; give "
            "--grow none to keep it, which takes less memory", f->path,
            gp_frame_w(f), gp_frame_h(f), gp_rect_w(r), gp_rect_h(r));
    return GP_OK;
}

// -- depth -------------------------------------------------------------------

/* The bytes of a sample of value v. */
static void sample_bytes(float v, enum gp_pixel_type type, uint8_t to[4])
{
    const uint32_t u = !(v > 0.0f) ? 0 : v >= 4294967295.0f ? UINT32_MAX
                                                             : (uint32_t) v;
    uint16_t half;
    gp_float_to_half(&v, &half, 1);
    memcpy(to, type == GP_HALF ? (const void *) &half
               : type == GP_UINT ? (const void *) &u : (const void *) &v,
           gp_type_size(type));
}

// -- samples -----------------------------------------------------------------

/* Copies w x h samples of `size` bytes to (x, y) of a grid of all_w x all_h,
 * whose other samples become `empty`. */
struct grid {
    int w, h, x, y, all_w, all_h;
    size_t size;
    uint8_t empty[4];
    const void *from;
    void *to;
};

static void copy_row(void *ctx, int y, int thread)
{
    const struct grid *const g = ctx;
    const size_t row = (size_t) g->all_w * g->size;
    const size_t own = (size_t) g->w * g->size;
    uint8_t *const out = (uint8_t *) g->to + (size_t) y * row;
    const int line = y - g->y;
    (void) thread;
    if (memcmp(g->empty, (uint8_t[4]) {0}, 4) == 0)
        memset(out, 0, row);
    else
        for (size_t i = 0; i < row; i += g->size)
            memcpy(out + i, g->empty, g->size);
    if (line >= 0 && line < g->h)
        memcpy(out + (size_t) g->x * g->size,
               (const uint8_t *) g->from + (size_t) line * own, own);
}

/* Replaces *samples by a block of the larger grid. */
static gp_status regrid(const struct gp_log *log, const char *what,
                        struct grid *g, void **samples)
{
    gp_status st = gp_alloc(log, what, (size_t) g->all_w * (size_t) g->all_h,
                            g->size, &g->to);
    if (st)
        return st;
    g->from = *samples;
    gp_parallel_do(g->all_h, copy_row, g);
    gp_free(*samples);
    *samples = g->to;
    return GP_OK;
}

/* Sets `empty`, which is 0, for a carried channel that has not grown. */
static gp_status empty_sample(const struct gp_log *log,
    const struct gp_grow_params *p, const struct gp_frame *f, int channel,
    uint8_t empty[4])
{
    const struct gp_channel *const c = &f->channel[channel];
    const bool named = p->depth && strcmp(p->depth, c->name) == 0;
    float *v;
    const bool back = strcmp(c->name + gp_layer_length(c->name), "ZBack") == 0;
    if (!named && !back && !gp_channel_is_depth(f, channel))
        return GP_OK;
    gp_status st = gp_alloc(log, c->name, gp_frame_pixels(f), sizeof *v, &v);
    if (st)
        return st;
    gp_channel_floats(f, channel, v);
    sample_bytes(gp_empty_depth(p->type, v, gp_frame_pixels(f)), c->type,
                 empty);
    gp_free(v);
    return GP_OK;
}

gp_status gp_grow(const struct gp_log *log, const struct gp_grow_params *p,
                  struct gp_rect window, struct gp_frame *f)
{
    const struct gp_rect was = f->data;
    const int dx = was.x0 - window.x0, dy = was.y0 - window.y0;
    const int w = gp_rect_w(window), h = gp_rect_h(window);
    struct gp_planes rgb;
    gp_status st = GP_OK;
    if (memcmp(&was, &window, sizeof was) == 0)
        return GP_OK;
    for (int i = 0; i < f->channels; i++) {
        struct gp_channel *const c = &f->channel[i];
        struct grid g = {
            c->w, c->h, dx / c->xs, dy / c->ys, w / c->xs, h / c->ys,
            .size = gp_type_size(c->type),
        };
        if (c->data) {
            GP_TRY(empty_sample(log, p, f, i, g.empty));
            GP_TRY(regrid(log, c->name, &g, &c->data));
        }
        c->w = g.all_w;
        c->h = g.all_h;
    }
    GP_TRY(gp_planes_make(log, "frame", (size_t) w * (size_t) h, &rgb));
    for (int c = 0; c < 3; c++) {
        struct grid g = {
            gp_frame_w(f), gp_frame_h(f), dx, dy, w, h, .size = sizeof(float),
            .from = f->rgb.c[c], .to = rgb.c[c],
        };
        gp_parallel_do(h, copy_row, &g);
    }
    gp_planes_free(&f->rgb);
    f->rgb = rgb;
    f->read = was;
    f->data = window;
out:
    return st;
}
