#include "io/picture.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "io/colour_name.h"
#include "io/quantize.h"

#include <limits.h>
#include <string.h>

// as --max-pixels, which bounds what files claim
static const int64_t pixels_max = 1LL << 40, edge_max = INT_MAX / 4;

gp_status gp_picture_make(const struct gp_log *log,
                          const struct gp_write_params *p, const char *path,
                          const struct gp_frame *f,
                          const struct gp_planes *planes,
                          enum gp_picture_kind kind, bool codes,
                          struct gp_picture *out)
{
    gp_status st;
    void *alpha;
    const struct gp_rect d = f->display;
    const int64_t w = (int64_t) d.x1 - d.x0, h = (int64_t) d.y1 - d.y0;
    const int channel = p->alpha == GP_ALPHA_KEEP ? gp_find_alpha(f) : -1;
    *out = (struct gp_picture) {0};
    if (w < 1 || h < 1 || w > edge_max || h > edge_max || w > pixels_max / h)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: no picture of this display window (%lld x %lld "
                       "pixels); write .exr", path, (long long) w,
                       (long long) h);
    *out = (struct gp_picture) {
        .width = (int) w, .height = (int) h, .channels = channel >= 0 ? 4 : 3,
        .bits = p->depth_bits, .dither = p->dither,
        .encoded = kind == GP_PICTURE_ENCODED, .f = f, .planes = planes,
    };
    if (channel >= 0) {
        GP_TRY(gp_alloc(log, "alpha", gp_frame_pixels(f), sizeof(float),
                        &alpha));
        out->alpha = alpha;
        gp_channel_floats(f, channel, out->alpha);
    }
    if (codes)
        GP_TRY(gp_quantizer_make(log, p->depth_bits, &out->quantizer));
    return GP_OK;
out:
    gp_picture_free(out);
    return st;
}

void gp_picture_free(struct gp_picture *pic)
{
    gp_quantizer_free(pic->quantizer);
    gp_free(pic->alpha);
    *pic = (struct gp_picture) {0};
}

// -- rows ---------------------------------------------------------------------

struct rows {
    gp_picture_body body;
    void *ctx;
    struct scratch {
        struct gp_picture_row row;
        void *own;
    } *of; // each thread; one without `own` ends them
};

static void free_rows(struct rows *r)
{
    for (struct scratch *s = r->of; s && s->own; s++)
        gp_free(s->own);
    GP_FREE(r->of);
}

static gp_status make_scratch(const struct gp_log *log, size_t w,
                              struct scratch *s)
{
    const gp_status st = gp_alloc(log, "picture rows", w * 4,
                                  sizeof(float) + sizeof(uint16_t), &s->own);
    if (st)
        return st;
    for (size_t c = 0; c < 4; c++) {
        s->row.linear[c] = (float *) s->own + c * w;
        s->row.code[c] = (uint16_t *) ((float *) s->own + 4 * w) + c * w;
    }
    return GP_OK;
}

static void run_row(void *ctx, int y, int thread)
{
    const struct rows *const r = ctx;
    r->body(r->ctx, y, &r->of[thread].row);
}

gp_status gp_picture_each_row(const struct gp_log *log,
                              const struct gp_picture *pic,
                              gp_picture_body body, void *ctx)
{
    void *list;
    const size_t n = (size_t) gp_threads();
    struct rows r = {.body = body, .ctx = ctx};
    gp_status st = gp_alloc_zero(log, "picture rows", n + 1, sizeof *r.of,
                                 &list);
    r.of = list;
    for (size_t i = 0; !st && i < n; i++)
        st = make_scratch(log, (size_t) pic->width, &r.of[i]);
    if (!st)
        gp_parallel_do(pic->height, run_row, &r);
    free_rows(&r);
    return st;
}

/* Where the data window's row lies in the picture's row y: samples [at,
 * at + n) of the planes go to [x, x + n). */
struct span {
    size_t at, x, n;
};

static struct span span_of(const struct gp_picture *pic, int y)
{
    const struct gp_rect data = pic->f->data, show = pic->f->display;
    const struct gp_rect both = gp_rect_meet(data, show);
    const int row = show.y0 + y;
    if (gp_rect_empty(both) || row < both.y0 || row >= both.y1)
        return (struct span) {0};
    return (struct span) {
        .at = (size_t) (row - data.y0) * (size_t) gp_rect_w(data) +
              (size_t) (both.x0 - data.x0),
        .x = (size_t) (both.x0 - show.x0),
        .n = (size_t) gp_rect_w(both),
    };
}

/* `n` samples of `size` bytes stand from x on; the rest becomes 0. */
static void clear_around(void *row, size_t size, struct span s, size_t width)
{
    uint8_t *bytes = row;
    memset(bytes, 0, s.x * size);
    memset(bytes + (s.x + s.n) * size, 0, (width - s.x - s.n) * size);
}

static float clamp01(float v)
{
    return v > 0.0f ? (v < 1.0f ? v : 1.0f) : 0.0f;
}

/* Alpha codes and colours divided by what these codes mean; see the header. */
static void take_apart(const struct gp_picture *pic, struct span s,
                       struct gp_picture_row *row)
{
    const float max = (float) gp_quantizer_max(pic->quantizer);
    float *const *v = row->linear;
    for (size_t i = 0; i < s.n; i++) {
        float most = clamp01(pic->alpha[s.at + i]);
        for (int c = 0; c < 3; c++) {
            v[c][i] = clamp01(pic->planes->c[c][s.at + i]);
            most = v[c][i] > most ? v[c][i] : most;
        }
        v[3][i] = most;
    }
    gp_quantize_linear(pic->quantizer, v[3], row->code[3] + s.x, s.n);
    for (size_t i = 0; i < s.n; i++) {
        const float code = (float) row->code[3][s.x + i];
        const float scale = code > 0.0f ? max / code : 0.0f;
        for (int c = 0; c < 3; c++)
            v[c][i] *= scale;
    }
}

static void make_codes(const struct gp_picture *pic, const float *from,
                       struct span s, int y, uint16_t *to)
{
    const struct gp_quantizer *const q = pic->quantizer;
    if (pic->encoded && pic->dither)
        gp_quantize_linear_dither(q, from, (int) s.x, y, to, s.n);
    else if (pic->encoded)
        gp_quantize_linear(q, from, to, s.n);
    else if (pic->dither)
        gp_quantize_dither(q, from, (int) s.x, y, to, s.n);
    else
        gp_quantize(q, from, to, s.n);
}

void gp_picture_codes(const struct gp_picture *pic, int y,
                      struct gp_picture_row *row)
{
    const struct span s = span_of(pic, y);
    if (pic->alpha)
        take_apart(pic, s, row);
    for (int c = 0; c < 3; c++) {
        const float *from = pic->alpha ? row->linear[c]
                                       : pic->planes->c[c] + s.at;
        uint16_t *to = row->code[c] + s.x;
        make_codes(pic, from, s, y, to);
    }
    for (int c = 0; c < pic->channels; c++)
        clear_around(row->code[c], sizeof(uint16_t), s, (size_t) pic->width);
}

void gp_picture_floats(const struct gp_picture *pic, int y,
                       struct gp_picture_row *row)
{
    const struct span s = span_of(pic, y);
    for (int c = 0; c < pic->channels; c++) {
        const float *from = c < 3 ? pic->planes->c[c] : pic->alpha;
        memcpy(row->linear[c] + s.x, from + s.at, s.n * sizeof *from);
        clear_around(row->linear[c], sizeof(float), s, (size_t) pic->width);
    }
}
