// SPDX-License-Identifier: Apache-2.0
#include "core/bytes.h"
#include "core/colour.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "io/io_priv.h"

#include <endian.h>
#include <limits.h>
#include <math.h>
#include <string.h>

// -- codes --------------------------------------------------------------------

#define INLINE inline __attribute__((always_inline)) // also in clones

enum { BLOCK = 128 }; // samples at a time, in the first cache
enum { ONE = 0x3f800000, INF = 0x7f800000 }; // bits of 1.0f and INFINITY

/* Compares the bits of floats: those of values >= 0 ascend with the values, and
 * the compiler vectorises integer selects but must keep branches for float
 * ones, which may trap. */
static inline float clamp_by_bits(float v)
{
    int32_t i = (int32_t) gp_bits_of(v);
    i = i > INF ? 0 : i; // NaN
    i = i < 0 ? 0 : i;   // negative values, and NaN with its sign set
    i = i > ONE ? ONE : i;
    return gp_float_with_bits((uint32_t) i);
}

/* 1.055 x^(1/2.4) - 0.055 within 4e-7, without a call: x^(1/2.4) is
 * 2^(log2(x) / 2.4), log2 by the series of atanh around m in
 * [sqrt(1/2), sqrt(2)), 2^t by its Taylor series around the nearest whole. */
static INLINE float curve(float x)
{
    const int32_t half_root = 0x3f3504f3; // bits of sqrt(1/2)
    const int32_t e = ((int32_t) gp_bits_of(x) - half_root) >> 23;
    const float m = gp_float_with_bits(gp_bits_of(x) - ((uint32_t) e << 23));
    const float s = (m - 1.0f) / (m + 1.0f), s2 = s * s;
    const float log2m =
        s * (2.8853901f +
             s2 * (0.96179669f + s2 * (0.57707802f + s2 * 0.41219859f)));
    const float t = ((float) e + log2m) * (1.0f / 2.4f);
    const int32_t whole = (int32_t) (t - 0.5f); // t <= 0: rounds to nearest
    const float f = (t - (float) whole) * 0.69314718f;
    const float p =
        1.0f + f * (1.0f + f * (0.5f + f * (1.0f / 6 + f * (1.0f / 24 +
               f * (1.0f / 120 + f * (1.0f / 720))))));
    const float scale = gp_float_with_bits((uint32_t) (whole + 127) << 23);
    return 1.055f * (p * scale) - 0.055f;
}

/* gp_srgb_encode() of x in [0, 1] within 4e-7, times max. Exact at 0 and at 1.
 * A loop for each step, over arrays, keeps the compiler from making branches,
 * which would not vectorise. */
static INLINE void encode_block(const float *restrict x, float max,
                                float *restrict v, size_t n)
{
    float power[BLOCK];
    for (size_t i = 0; i < n; i++)
        power[i] = curve(x[i]) * max;
    for (size_t i = 0; i < n; i++)
        v[i] = x[i] * (12.92f * max);
    for (size_t i = 0; i < n; i++) {
        const float rest = x[i] <= 0.0031308f ? v[i] : power[i];
        v[i] = x[i] < 1.0f ? rest : max;
    }
}

static INLINE void encode_exactly(const float *restrict x, float max,
                                  float *restrict v, size_t n)
{
    for (size_t i = 0; i < n; i++)
        v[i] = gp_srgb_encode(x[i]) * max;
}

/* Jimenez: fract(52.9829189 * fract(0.06711056 x + 0.00583715 y)), with
 * fractions as 32-bit numbers that wrap by themselves. */
static const uint32_t noise_x = 288237660u;   // 0.06711056 * 2^32
static const uint32_t noise_y = 25070368u;    // 0.00583715 * 2^32
static const uint32_t noise_scale = 3472289u; // 52.9829189 * 2^16

/* v is in codes. */
static INLINE void dither_block(const float *v, uint32_t inner,
                                uint16_t *code, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        const uint32_t at = inner + (uint32_t) i * noise_x;
        const uint32_t d = (uint32_t) (((uint64_t) at * noise_scale) >> 16);
        const int32_t c = (int32_t) v[i];
        // v + d as one float would round some sums up to the next code
        const int32_t up = (int32_t) ((1.0f - (v[i] - (float) c)) * 0x1p24f);
        code[i] = (uint16_t) (c + ((int32_t) (d >> 8) >= up));
    }
}

GP_CLONES void gp_quantize(const struct gp_quantizer *q, const float *value,
                           int x, int y, uint16_t *code, size_t n)
{
    const float max = (float) q->max;
    uint32_t inner = (uint32_t) x * noise_x + (uint32_t) y * noise_y;
    float in[BLOCK], v[BLOCK];
    for (size_t i = 0; i < n; i += BLOCK, inner += BLOCK * noise_x) {
        const size_t m = n - i < BLOCK ? n - i : BLOCK;
        for (size_t k = 0; k < m; k++)
            in[k] = clamp_by_bits(value[i + k]);
        if (q->curve && q->dither)
            encode_block(in, max, v, m);
        else if (q->curve)
            encode_exactly(in, max, v, m);
        for (size_t k = 0; k < m && !q->curve; k++)
            v[k] = in[k] * max;
        if (q->dither)
            dither_block(v, inner, code + i, m);
        for (size_t k = 0; k < m && !q->dither; k++)
            code[i + k] = (uint16_t) (int32_t) (v[k] + 0.5f);
    }
}

// -- pictures -----------------------------------------------------------------

// as much as --max-pixels allows files to claim
static const int64_t pixels_max = 1LL << 40, edge_max = INT_MAX / 4;

gp_status gp_picture_make(const struct gp_picture_job *j,
                          struct gp_picture *out)
{
    const struct gp_write_params *const p = j->p;
    const struct gp_frame *const f = j->f;
    const struct gp_rect d = f->display;
    const int64_t w = (int64_t) d.x1 - d.x0, h = (int64_t) d.y1 - d.y0;
    const int channel = p->alpha != GP_ALPHA_BLACK ? gp_find_alpha(f) : -1;
    *out = (struct gp_picture) {0};
    if (w < 1 || h < 1 || w > edge_max || h > edge_max || w > pixels_max / h)
        return gp_fail(j->log, GP_ERR_DATA,
                       "%s: cannot make a picture of this display window "
                       "(%lld x %lld pixels); write .exr",
                       j->path, (long long) w, (long long) h);
    *out = (struct gp_picture) {
        .width = (int) w,
        .height = (int) h,
        .channels = channel >= 0 ? 4 : 3,
        .bits = p->depth_bits,
        .f = f,
        .planes = j->planes,
        .associated = p->alpha == GP_ALPHA_ASSOCIATED,
        .quantizer =
            {
                .max = (1 << p->depth_bits) - 1,
                .curve = j->kind != GP_PICTURE_ENCODED,
                .dither = p->dither == GP_DITHER_ALWAYS ||
                          (p->dither == GP_DITHER_8_BITS && p->depth_bits == 8),
            },
    };
    if (channel < 0)
        return GP_OK;
    const gp_status st = gp_alloc(j->log, "alpha", gp_frame_pixels(f),
                                  sizeof *out->alpha, &out->alpha);
    if (st)
        *out = (struct gp_picture) {0};
    else
        gp_channel_floats(f, channel, out->alpha);
    return st;
}

void gp_picture_free(struct gp_picture *pic)
{
    gp_free(pic->alpha);
    *pic = (struct gp_picture) {0};
}

// -- rows ---------------------------------------------------------------------

/* Scratch for one row. */
struct row {
    uint16_t *code[4]; // width codes of each channel
    float *linear[4];  // the same as values
};

/* Samples [at, at + n) of the planes go to [x, x + n) of a picture's row. */
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

/* Clears a row of samples of `size` bytes outside of the span. */
static void clear_around(void *row, size_t size, struct span s, size_t width)
{
    uint8_t *bytes = row;
    memset(bytes, 0, s.x * size);
    memset(bytes + (s.x + s.n) * size, 0, (width - s.x - s.n) * size);
}

static void make_codes(const struct gp_picture *pic, int y,
                       const struct row *row)
{
    const struct gp_quantizer *const q = &pic->quantizer;
    const struct gp_quantizer plain = {.max = q->max}; // of alpha
    const struct span s = span_of(pic, y);
    float *const *v = row->linear;
    const bool divided = pic->alpha && !pic->associated;
    if (pic->alpha && pic->associated)
        gp_quantize(&plain, pic->alpha + s.at, 0, 0, row->code[3] + s.x, s.n);
    if (divided) {
        for (size_t i = 0; i < s.n; i++) {
            float most = gp_clamp01(pic->alpha[s.at + i]);
            for (int c = 0; c < 3; c++) {
                v[c][i] = gp_clamp01(pic->planes->c[c][s.at + i]);
                most = v[c][i] > most ? v[c][i] : most;
            }
            v[3][i] = most;
        }
        gp_quantize(&plain, v[3], 0, 0, row->code[3] + s.x, s.n);
        // divides colours by the alpha that its code stands for
        for (size_t i = 0; i < s.n; i++) {
            const float code = (float) row->code[3][s.x + i];
            const float scale = code > 0.0f ? (float) q->max / code : 0.0f;
            for (int c = 0; c < 3; c++)
                v[c][i] *= scale;
        }
    }
    for (int c = 0; c < 3; c++) {
        const float *const from = divided ? v[c] : pic->planes->c[c] + s.at;
        gp_quantize(q, from, (int) s.x, y, row->code[c] + s.x, s.n);
    }
    for (int c = 0; c < pic->channels; c++)
        clear_around(row->code[c], sizeof(uint16_t), s, (size_t) pic->width);
}

static void make_floats(const struct gp_picture *pic, int y,
                        const struct row *row)
{
    const struct span s = span_of(pic, y);
    for (int c = 0; c < pic->channels; c++) {
        const float *from = c < 3 ? pic->planes->c[c] : pic->alpha;
        memcpy(row->linear[c] + s.x, from + s.at, s.n * sizeof *from);
        clear_around(row->linear[c], sizeof(float), s, (size_t) pic->width);
    }
}

struct gathering {
    const struct gp_picture *pic;
    const struct gp_picture_form *s;
    struct row *row; // of each thread
};

static void gather_row(void *ctx, int y, int thread)
{
    const struct gathering *const g = ctx;
    const struct gp_picture_form *const s = g->s;
    const struct row *const row = &g->row[thread];
    const size_t n = (size_t) g->pic->channels, w = (size_t) g->pic->width;
    const int line = s->from_bottom ? g->pic->height - 1 - y : y;
    uint8_t *const start =
        (uint8_t *) s->to + (size_t) line * (s->lead + w * n * s->bytes);
    uint8_t *const to = start + s->lead;
    const bool floats = s->bytes == 4 && !s->fractions;
    (floats ? make_floats : make_codes)(g->pic, y, row);
    for (size_t c = 0; c < n; c++) {
        const uint16_t *const code = row->code[c];
        for (size_t x = 0; s->bytes == 1 && x < w; x++)
            to[x * n + c] = (uint8_t) code[x];
        for (size_t x = 0; s->bytes == 2 && x < w; x++) {
            const uint16_t put = s->big ? htobe16(code[x]) : htole16(code[x]);
            memcpy(to + 2 * (x * n + c), &put, sizeof put);
        }
        for (size_t x = 0; s->bytes == 4 && x < w; x++) {
            const float v =
                floats ? row->linear[c][x]
                       : (float) code[x] / (float) g->pic->quantizer.max;
            const uint32_t bits = htole32(gp_bits_of(v));
            memcpy(to + 4 * (x * n + c), &bits, sizeof bits);
        }
    }
    if (s->finish)
        s->finish(g->pic, start);
}

gp_status gp_picture_samples(const struct gp_log *log,
                             const struct gp_picture *pic,
                             const struct gp_picture_form *s)
{
    gp_status st;
    float *linear = NULL;
    uint16_t *code = NULL;
    const size_t n = (size_t) gp_threads(), w = (size_t) pic->width;
    struct gathering g = {.pic = pic, .s = s};
    GP_TRY(gp_alloc_zero(log, "picture rows", n, sizeof *g.row, &g.row));
    GP_TRY(gp_alloc(log, "picture rows", 4 * n, w * sizeof(float), &linear));
    GP_TRY(gp_alloc(log, "picture rows", 4 * n, w * sizeof(uint16_t), &code));
    for (size_t i = 0; i < 4 * n; i++) {
        g.row[i / 4].linear[i % 4] = linear + i * w;
        g.row[i / 4].code[i % 4] = code + i * w;
    }
    gp_parallel_do(pic->height, gather_row, &g);
out:
    gp_free(code);
    gp_free(linear);
    gp_free(g.row);
    return st;
}
