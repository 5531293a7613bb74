// SPDX-License-Identifier: Apache-2.0
#include "core/luminance.h"

#include "core/bytes.h"
#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

// -- sums of planes ----------------------------------------------------------

GP_CLONES void gp_samples_add(const float *v, int n, double *squares,
                              double *sum)
{
    enum { LANES = 8 };
    double square[LANES] = {0}, whole[LANES] = {0}; // become vectors
    int x = 0;
    for (; x + LANES <= n; x += LANES) {
        for (int i = 0; i < LANES; i++) {
            const double one = (double) v[x + i];
            square[i] += one * one;
            whole[i] += one;
        }
    }
    for (; x < n; x++) {
        square[0] += (double) v[x] * (double) v[x];
        whole[0] += (double) v[x];
    }
    for (int i = 0; i < LANES; i++) {
        *squares += square[i];
        *sum += whole[i];
    }
}

struct plane_sums {
    const struct gp_planes *p;
    size_t pixels;
    struct {
        double sum[3], squares;
    } band[GP_FRAME_BANDS];
};

static void sum_band(void *ctx, int band, int thread)
{
    struct plane_sums *const s = ctx;
    const size_t at = gp_band_start(s->pixels, band);
    const size_t n = gp_band_start(s->pixels, band + 1) - at;
    double squares = 0.0;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        s->band[band].sum[c] = 0.0;
        gp_samples_add(s->p->c[c] + at, (int) n, &squares,
                       &s->band[band].sum[c]);
    }
    s->band[band].squares = squares;
}

void gp_planes_sum(const struct gp_planes *p, size_t pixels, double sum[3],
                   double *squares)
{
    struct plane_sums s = {.p = p, .pixels = pixels};
    gp_parallel_do(GP_FRAME_BANDS, sum_band, &s);
    sum[0] = sum[1] = sum[2] = *squares = 0.0;
    for (int i = 0; i < GP_FRAME_BANDS; i++) {
        for (int c = 0; c < 3; c++)
            sum[c] += s.band[i].sum[c];
        *squares += s.band[i].squares;
    }
}

// -- the mean ----------------------------------------------------------------

struct mean_sums {
    const struct gp_image *f;
    const struct gp_planes *p;
    struct gp_rect seen;        // of the data window
    double band[GP_FRAME_BANDS];
};

static void sum_rows(void *ctx, int band, int thread)
{
    struct mean_sums *const s = ctx;
    const struct gp_rect *const at = &s->seen, *const data = &s->f->data;
    const size_t rows = (size_t) (at->y1 - at->y0);
    const size_t w = (size_t) gp_image_w(s->f);
    double sum = 0.0;
    (void) thread;
    for (size_t y = gp_band_start(rows, band);
         y < gp_band_start(rows, band + 1); y++) {
        const size_t from = (y + (size_t) (at->y0 - data->y0)) * w +
                            (size_t) (at->x0 - data->x0);
        const int seen = at->x1 - at->x0;
        for (int c = 0; c < 3; c++) {
            double channel = 0.0, squares = 0.0;
            gp_samples_add(s->p->c[c] + from, seen, &squares, &channel);
            sum += (double) s->f->luminance[c] * channel;
        }
    }
    s->band[band] = sum;
}

double gp_mean_luminance(const struct gp_image *f, const struct gp_planes *p)
{
    const struct gp_rect *const b = &f->display;
    struct mean_sums s = {.f = f, .p = p, .seen = gp_rect_meet(f->data, *b)};
    double sum = 0.0;
    if (gp_rect_empty(s.seen))
        return 0.0;
    gp_parallel_do(GP_FRAME_BANDS, sum_rows, &s);
    for (int i = 0; i < GP_FRAME_BANDS; i++)
        sum += s.band[i];
    sum /= ((double) b->x1 - b->x0) * ((double) b->y1 - b->y0);
    return fmax(sum, 0.0);
}

// -- the average -------------------------------------------------------------

/* A sum of logarithms, as the product of mantissas and the sum of exponents:
 * one logarithm for many pixels, and nothing lost. */
struct log_sum {
    double sum;
    long long count;
};

struct log_measure {
    const struct gp_planes *p;
    double weight[3];
    size_t pixels;
    struct log_sum band[GP_FRAME_BANDS];
};

static void measure_log(void *ctx, int band, int thread)
{
    enum { FOLD = 512 }; // mantissas are under 2: their product fits a double
    struct log_measure *m = ctx;
    const double delta = 1e-6; // Reinhard et al. leave its size open
    const size_t end = gp_band_start(m->pixels, band + 1);
    struct log_sum s = {0};
    (void) thread;
    for (size_t at = gp_band_start(m->pixels, band); at < end; at += FOLD) {
        const size_t stop = end - at < FOLD ? end : at + FOLD;
        double product = 1.0;
        int64_t exponents = 0;
        for (size_t i = at; i < stop; i++) {
            double y = m->weight[0] * (double) m->p->c[0][i] +
                       m->weight[1] * (double) m->p->c[1][i] +
                       m->weight[2] * (double) m->p->c[2][i];
            const bool counts = y > 0.0 && y < (double) INFINITY;
            const double v = counts ? y + delta : 1.0;
            const uint64_t bits = gp_bits_of_double(v);
            exponents += (int64_t) (bits >> 52) - 1023;
            product *= gp_double_with_bits((bits & 0xfffffffffffffu) |
                                           (uint64_t) 1023 << 52);
            s.count += counts;
        }
        s.sum += gp_log(product) + (double) exponents * M_LN2;
    }
    m->band[band] = s;
}

double gp_log_average(const struct gp_image *f, const struct gp_planes *p)
{
    struct log_measure m = {.p = p, .pixels = gp_image_pixels(f)};
    for (int c = 0; c < 3; c++)
        m.weight[c] = (double) f->luminance[c];
    gp_parallel_do(GP_FRAME_BANDS, measure_log, &m);
    struct log_sum all = {0};
    for (int i = 0; i < GP_FRAME_BANDS; i++) {
        all.sum += m.band[i].sum;
        all.count += m.band[i].count;
    }
    return all.count ? gp_exp(all.sum / (double) all.count) : 0.0;
}

// -- percentiles -------------------------------------------------------------

/* Bits of a float >= 0 ascend with it: a histogram of their upper half, then
 * one of the lower half of those in the bin, find the value of a rank. */
enum { HALF_BITS = 16, HALF_BINS = 1 << HALF_BITS };

struct ranking {
    const struct gp_image *f;
    uint32_t (*count)[HALF_BINS]; // of each thread
    uint32_t upper;               // bin that is refined; HALF_BINS: none
};

static float luminance_at(const struct gp_image *f, size_t i)
{
    const float y = gp_lit_luminance(f->luminance, f->rgb.c[0][i],
                                     f->rgb.c[1][i], f->rgb.c[2][i]);
    return y < FLT_MAX ? gp_lit(y) : FLT_MAX; // weights may be under 0
}

static void count_band(void *ctx, int band, int thread)
{
    const struct ranking *const r = ctx;
    const struct gp_rect data = r->f->data, read = gp_image_read(r->f);
    const size_t w = (size_t) gp_rect_w(read), all = (size_t) gp_rect_w(data);
    const size_t pixels = w * (size_t) gp_rect_h(read);
    const size_t first = (size_t) (read.y0 - data.y0) * all +
                         (size_t) (read.x0 - data.x0);
    const size_t start = gp_band_start(pixels, band);
    const size_t end = gp_band_start(pixels, band + 1);
    uint32_t *const count = r->count[thread];
    size_t x = pixels ? start % w : 0, row = pixels ? start / w : 0;
    for (size_t i = start; i < end; i++, x++) {
        row += x == w;
        x = x == w ? 0 : x;
        const float y = luminance_at(r->f, first + row * all + x);
        const uint32_t bits = gp_bits_of(y);
        if (r->upper == HALF_BINS)
            count[bits >> HALF_BITS]++;
        else if (bits >> HALF_BITS == r->upper)
            count[bits & (HALF_BINS - 1)]++;
    }
}

/* Returns the bin of that rank, from 1; *rank becomes its rank in it. */
static uint32_t find_bin(struct ranking *r, uint64_t *rank)
{
    const int threads = gp_threads();
    memset(r->count, 0, (size_t) threads * sizeof *r->count);
    gp_parallel_do(GP_FRAME_BANDS, count_band, r);
    for (uint32_t b = 0; b < HALF_BINS - 1; b++) {
        uint64_t n = 0;
        for (int t = 0; t < threads; t++)
            n += r->count[t][b];
        if (*rank <= n)
            return b;
        *rank -= n;
    }
    return HALF_BINS - 1;
}

gp_status gp_luminance_rank(const struct gp_log *log, const struct gp_image *f,
                            uint64_t k, float *out)
{
    struct ranking r = {.f = f, .upper = HALF_BINS};
    gp_status st = gp_alloc(log, "percentile", (size_t) gp_threads(),
                            sizeof *r.count, &r.count);
    if (st)
        return st;
    r.upper = find_bin(&r, &k);
    *out = gp_float_with_bits(r.upper << HALF_BITS | find_bin(&r, &k));
    gp_free(r.count);
    return GP_OK;
}

gp_status gp_luminance_percentile(const struct gp_log *log,
    const struct gp_image *f, double percent, float *out)
{
    const struct gp_rect read = gp_image_read(f);
    const size_t pixels = gp_rect_pixels(read);
    // 99.9 in binary is a little more, and would skip a pixel of 1000
    const double k = percent / 100.0 * (double) pixels;
    const uint64_t rank = (uint64_t) ceil(k - 1e-9 * k);
    return gp_luminance_rank(
        log, f, rank < 1 ? 1 : rank > pixels ? pixels : rank, out);
}

// -- the largest -------------------------------------------------------------

float gp_luminance_peak(const struct gp_image *f, int at[2])
{
    const size_t w = (size_t) gp_image_w(f), pixels = gp_image_pixels(f);
    float largest = -1.0f;
    size_t first = 0;
    for (size_t i = 0; i < pixels; i++) {
        const float y = luminance_at(f, i);
        first = y > largest ? i : first;
        largest = y > largest ? y : largest;
    }
    at[0] = f->data.x0 + (int) (first % w);
    at[1] = f->data.y0 + (int) (first / w);
    return largest;
}
