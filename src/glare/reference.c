// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/fft/fft.h"
#include "glare/glare_priv.h"
#include "glare/model/model.h"
#include "glare/sky/sky.h"

#include <math.h>
#include <string.h>

/* Beyond so many taps of a channel the plain loops would take minutes. */
static const double MOST_TAPS = 1e9;

struct plain {
    const struct gp_sources *src;
    const struct gp_kernel *k;
    double *layer;
};

/* layer(p) = sum over q of source(q) * kernel(p - q), one row of p. */
GP_CLONES static void plain_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct plain *const s = ctx;
    const struct gp_sources *const src = s->src;
    const struct gp_kernel *const k = s->k;
    const int w = src->w;
    const int first = gp_clamp_wide((long long) y + k->cy - k->h + 1, 0,
                                    src->h);
    const int end = gp_clamp_wide((long long) y + k->cy + 1, 0, src->h);
    for (int c = 0; c < 3; c++) {
        double *const out =
            s->layer +
            ((size_t) c * (size_t) src->h + (size_t) y) * (size_t) w;
        memset(out, 0, (size_t) w * sizeof *out);
        for (int sy = first; sy < end; sy++) {
            const float *const row = gp_row(k->k.c[c], k->w, y - sy + k->cy);
            for (uint32_t i = src->row[sy]; i < src->row[sy + 1]; i++) {
                const int at = src->x[i] - k->cx; // of kernel column 0
                const double light = (double) src->rgb[c][i];
                const int last = gp_min(k->w, w - at);
                for (int kx = gp_max(0, -at); kx < last; kx++)
                    out[at + kx] += light * (double) row[kx];
            }
        }
    }
}

void gp_glare_reference_direct(const struct gp_sources *src,
                               const struct gp_kernel *kernel, double *layer)
{
    struct plain s = {src, kernel, layer};
    gp_parallel_do(src->h, plain_row, &s);
}

/* -- dense frames: complex two-dimensional transforms, in double ----------- */

/* Transforms `lines` lines of complex numbers in place, the first numbers `apart`
 * one from the next, those of a line `step`; z is scratch for two arrays of
 * points. `back`: back. */
static void transform_lines(const struct gp_transform *t, bool back,
                            size_t lines, size_t apart, size_t step, double *a,
                            double *z)
{
    enum { LINES = GP_DOUBLE_LINES };
    double *const other = z + gp_transform_room(t->n) / sizeof *z;
    const size_t n = (size_t) t->n, re = back ? LINES : 0, im = LINES - re;
    for (size_t first = 0; first < lines; first += LINES) {
        const size_t count = lines - first < LINES ? lines - first : LINES;
        memset(z, 0, n * GP_POINT_BYTES);
        for (size_t k = 0; k < n; k++) {
            for (size_t i = 0; i < count; i++) {
                const double *const at =
                    a + 2 * ((first + i) * apart + k * step);
                z[2 * LINES * k + re + i] = at[0];
                z[2 * LINES * k + im + i] = at[1];
            }
        }
        const double *const out = gp_double_transform(t, z, other);
        for (size_t k = 0; k < n; k++) {
            for (size_t i = 0; i < count; i++) {
                double *const at = a + 2 * ((first + i) * apart + k * step);
                at[0] = out[2 * LINES * k + re + i];
                at[1] = out[2 * LINES * k + im + i];
            }
        }
    }
}

/* Transforms nx x ny complex numbers, rows, then columns. */
static void transform(const struct gp_transform pair[2], bool back, double *a,
                      double *z)
{
    const size_t nx = (size_t) pair[0].n, ny = (size_t) pair[1].n;
    transform_lines(&pair[0], back, ny, nx, 1, a, z);
    transform_lines(&pair[1], back, nx, 1, nx, a, z);
}

/* The sum with a kernel that has no far field. */
static gp_status sum_plain(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k, double *layer)
{
    gp_status st;
    if (gp_direct_work(src, k->w, k->h, k->cx, k->cy, MOST_TAPS) <= MOST_TAPS) {
        gp_glare_reference_direct(src, k, layer);
        return GP_OK;
    }
    const size_t nx = (size_t) gp_fft_length(src->w + k->w - 1);
    const size_t ny = (size_t) gp_fft_length(src->h + k->h - 1), n = nx * ny;
    const double scale = 1.0 / (double) n;
    double *a = NULL, *b = NULL, *z = NULL; // complex
    struct gp_transform pair[2] = {{0}, {0}};
    GP_TRY(gp_fft_pair_make(log, (int) nx, (int) ny, true, pair));
    GP_TRY(gp_alloc(log, "reference", 2 * n, 16, &a));
    b = a + 2 * n;
    GP_TRY(gp_alloc(log, "reference", 2,
                    gp_transform_room(gp_max((int) nx, (int) ny)), &z));
    for (int c = 0; c < 3; c++) {
        memset(a, 0, 2 * sizeof(double) * n);
        memset(b, 0, 2 * sizeof(double) * n);
        for (int y = 0; y < src->h; y++) {
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                a[2 * ((size_t) y * nx + (size_t) src->x[i])] =
                    (double) src->rgb[c][i];
        }
        for (int y = 0; y < k->h; y++) {
            for (int x = 0; x < k->w; x++)
                b[2 * ((size_t) y * nx + (size_t) x)] =
                    (double) gp_row(k->k.c[c], k->w, y)[x];
        }
        transform(pair, false, a, z);
        transform(pair, false, b, z);
        for (size_t i = 0; i < n; i++) {
            const double re = a[2 * i], im = a[2 * i + 1];
            a[2 * i] = scale * (re * b[2 * i] - im * b[2 * i + 1]);
            a[2 * i + 1] = scale * (re * b[2 * i + 1] + im * b[2 * i]);
        }
        transform(pair, true, a, z);
        // the full convolution's sample (x + cx, y + cy) is the layer's (x, y)
        double *out = layer + (size_t) c * (size_t) src->w * (size_t) src->h;
        for (int gy = k->cy; gy < src->h + k->cy; gy++) {
            for (int gx = k->cx; gx < src->w + k->cx; gx++) {
                const bool inside = gx >= 0 && gx < src->w + k->w - 1 &&
                                    gy >= 0 && gy < src->h + k->h - 1;
                *out++ = inside ? a[2 * ((size_t) gy * nx + (size_t) gx)] : 0.0;
            }
        }
    }
out:
    gp_fft_pair_free(pair);
    gp_free(a);
    gp_free(z);
    return st;
}

/* Adds true angles, of pixels that are wanted: others are NaN. */
static gp_status add_sky(const struct gp_log *log, const struct gp_sources *src,
                         const struct gp_kernel *k, const unsigned char *only,
                         double *layer)
{
    const size_t n = (size_t) src->w * (size_t) src->h;
    for (size_t i = 0; i < n && only; i++) {
        if (!only[i])
            layer[i] = layer[n + i] = layer[2 * n + i] = (double) NAN;
    }
    return gp_sky_exact(log, k->sky, src, layer);
}

/* The sum with any kernel, or but its core, and the light from beyond the border. */
static gp_status sum_all(const struct gp_log *log,
                         const struct gp_surround *edges,
                         const struct gp_sources *src,
                         const struct gp_kernel *k, bool core,
                         const unsigned char *only, double *layer)
{
    gp_status st = GP_OK;
    struct gp_kernel whole = {0};
    struct gp_beyond *beyond = NULL;
    const struct gp_kernel *const all = k->far ? &whole : k;
    if (k->far)
        GP_TRY(gp_kernel_whole(log, k, src->w, src->h, &whole));
    GP_TRY(sum_plain(log, src, all, layer));
    if (k->sky && !core)
        GP_TRY(add_sky(log, src, k, only, layer));
    if (edges)
        GP_TRY(gp_beyond_find(log, edges, &beyond));
    GP_TRY(gp_beyond_add_exact(log, beyond, all, layer));
out:
    gp_beyond_free(&beyond);
    gp_kernel_free(&whole);
    return st;
}

gp_status gp_glare_reference(const struct gp_log *log,
                             const struct gp_surround *edges,
                             const struct gp_sources *src,
                             const struct gp_kernel *k,
                             const unsigned char *only, double *layer)
{
    gp_status st;
    struct gp_mirrored m = {0};
    unsigned char *inner = NULL;
    double *wide = NULL;
    const struct gp_margin margin =
        edges ? gp_margin_of(edges, k, src->w, src->h) : (struct gp_margin) {0};
    if (!margin.x)
        return sum_all(log, edges, src, k, false, only, layer);
    GP_TRY(gp_mirror(log, edges, src, NULL, &margin, &m));
    const size_t pitch = (size_t) m.src.w, n = pitch * (size_t) m.src.h;
    const size_t w = (size_t) src->w, h = (size_t) src->h;
    const size_t first = (size_t) margin.y * pitch + (size_t) margin.x;
    GP_TRY(gp_alloc(log, "exact layer", 3 * n, sizeof *wide, &wide));
    GP_TRY(gp_alloc_zero(log, "exact layer", n, 1, &inner));
    for (size_t y = 0; y < h && only; y++)
        memcpy(inner + first + y * pitch, only + y * w, w);
    GP_TRY(sum_all(log, &m.edges, &m.src, k, margin.turn > 0,
                   only ? inner : NULL, wide));
    for (size_t i = 0; i < 3 * h; i++)
        memcpy(layer + i * w, wide + i / h * n + first + i % h * pitch,
               w * sizeof *layer);
    if (k->sky && margin.turn)
        GP_TRY(add_sky(log, src, k, only, layer));
out:
    gp_mirrored_free(&m);
    gp_free(inner);
    gp_free(wide);
    return st;
}

// -- errors against the truth ------------------------------------------------

static float luminance_at(const struct gp_image *f,
                          const struct gp_planes *layer, size_t i)
{
    float y = 0.0f;
    for (int c = 0; c < 3; c++)
        y += f->luminance[c] * layer->c[c][i];
    return y;
}

/* The luminance that at most so many pixels have: the least of a thirty-second octave. */
static float least_of(const struct gp_image *f, const struct gp_planes *layer,
                      size_t most)
{
    enum { SHIFT = 18, BINS = 1 << (31 - SHIFT) };
    size_t count[BINS] = {0}, n = 0;
    uint32_t bin = BINS;
    for (size_t i = 0; i < gp_image_pixels(f); i++) {
        const float y = luminance_at(f, layer, i);
        count[y > 0.0f ? gp_bits_of(y) >> SHIFT : 0]++;
    }
    while (bin > 1 && n + count[bin - 1] <= most)
        n += count[--bin];
    return bin < BINS ? gp_float_with_bits(bin << SHIFT) : INFINITY;
}

struct gp_glare_sample gp_glare_sample(const struct gp_image *f,
                                       const struct gp_planes *layer, double n,
                                       unsigned char *only)
{
    static const double MOST = 5e7; // pairs of a source and a pixel: seconds
    static const double PIXELS = 3e5;
    const size_t pixels = gp_image_pixels(f);
    const double most = floor(fmax(fmin(MOST / fmax(n, 1.0), PIXELS), 64.0));
    struct gp_glare_sample s = {0};
    memset(only, 1, pixels);
    if ((double) pixels <= most)
        return s;
    s.least = least_of(f, layer, (size_t) (0.5 * most));
    const double each = ceil((double) pixels / (0.5 * most));
    size_t rest = 0, taken = 0;
    for (size_t i = 0; i < pixels; i++) {
        const uint64_t hash = (i + 1) * 0x9e3779b97f4a7c15u;
        if (luminance_at(f, layer, i) >= s.least)
            continue;
        only[i] = fmod((double) (hash >> 40), each) < 1.0;
        rest++;
        taken += only[i];
    }
    s.each = (double) rest / (double) (taken ? taken : 1);
    return s;
}

/* Returns the larger; NaN counts as infinitely wrong. */
static double worse(double a, double b)
{
    return b != b ? INFINITY : fmax(a, b);
}

/* Returns the luminance of the exact composite in pixel i. *next is the first
 * source at or after that pixel. */
static double composite_at(const struct gp_image *f, const double *exact,
    double gain, const struct gp_sources *taken, size_t i, size_t *next)
{
    const size_t n = gp_image_pixels(f), w = (size_t) gp_image_w(f);
    const bool source = taken && *next < taken->row[i / w + 1] &&
                        (size_t) taken->x[*next] == i % w;
    double sum = 0.0;
    for (size_t c = 0; c < 3; c++) {
        const double own = source ? (double) taken->rgb[c][*next] : 0.0;
        sum += (double) f->luminance[c] *
               ((double) f->rgb.c[c][i] - fmin(gain, 1.0) * own +
                gain * exact[c * n + i]);
    }
    *next += source;
    return sum;
}

/* The pixels that pixel i of a sample stands for. */
static double stands_for(const struct gp_image *f, const double *exact,
                         const struct gp_glare_sample *s, size_t i)
{
    const size_t n = gp_image_pixels(f);
    double y = 0.0;
    if (!s || !(s->each > 0.0))
        return 1.0;
    for (size_t c = 0; c < 3; c++)
        y += (double) f->luminance[c] * exact[c * n + i];
    return y >= (double) s->least ? 1.0 : s->each;
}

void gp_glare_measure(const struct gp_image *f, const struct gp_planes *layer,
                      const double *exact, const struct gp_glare_sample *sample,
                      float gain, const struct gp_sources *taken,
                      struct glarepp_errors *out)
{
    const size_t n = gp_image_pixels(f);
    double weight = 0.0, off = 0.0;
    double square = 0.0, exact_square = 0.0, sum = 0.0, exact_sum = 0.0;
    double max_abs = 0.0, max_rel = 0.0, peak = 0.0;
    long long measured = 0;
    for (size_t i = 0, next = 0; i < n; i++) {
        const double by = stands_for(f, exact, sample, i);
        for (int c = 0; c < 3 && !isnan(exact[i]); c++) {
            const double want = exact[(size_t) c * n + i];
            const double got = (double) layer->c[c][i];
            square += by * (got - want) * (got - want);
            exact_square += by * want * want;
            max_abs = worse(max_abs, fabs(got - want));
            sum += by * got;
            exact_sum += by * want;
        }
        // of pixels that were left out NaN, which is no peak
        peak = fmax(peak, composite_at(f, exact, (double) gain, taken, i,
                                       &next));
        measured += !isnan(exact[i]);
    }
    // a second pass: max_rel needs the composite's peak
    for (size_t i = 0, next = 0; i < n; i++) {
        const double composite =
            composite_at(f, exact, (double) gain, taken, i, &next);
        double wrong = 0.0, own = 0.0;
        for (int c = 0; c < 3; c++) {
            const double want = exact[(size_t) c * n + i];
            const double y = (double) f->luminance[c] * (double) gain;
            wrong += y * ((double) layer->c[c][i] - want);
            own += y * want;
        }
        if (!isnan(exact[i])) {
            const double by = stands_for(f, exact, sample, i);
            weight += by;
            off += fabs(wrong) <= 5e-3 * fabs(own) ? 0.0 : by;
        }
        if (wrong != 0.0 && !isnan(exact[i]))
            max_rel = worse(max_rel, fabs(wrong) / (fmax(composite, 0.0) +
                                                    1e-6 * peak));
    }
    *out = (struct glarepp_errors) {
        .rel_l2 = sqrt(exact_square > 0.0 ? square / exact_square : square),
        .max_rel = max_rel,
        .max_abs = max_abs,
        .flux_error = fabs(exact_sum > 0.0 ? sum / exact_sum - 1.0 : sum),
        .pixels = measured,
        .off = weight > 0.0 ? off / weight : 0.0,
    };
}
