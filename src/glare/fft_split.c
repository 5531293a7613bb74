#include "glare/fft_split.h"

#include "core/memory.h"
#include "glare/direct.h"

#include <math.h>
#include <string.h>

const int gp_fft_core_radius[GP_FFT_CORES] = {-1, 4, 8, 16, 32};

/* The largest error of a pixel is about this times |s| |k| / sqrt(points):
 * 1e-6 to 8e-6 over the frames W1 to W3 and all radii (numpy float32 against
 * float64), rounded up because the darkest pixels are what counts. */
static const double NOISE = 4e-6;
static const double ALLOWED = 1e-6;

void gp_fft_tail_norms(const struct gp_kernel *k, double norm[GP_FFT_CORES])
{
    for (int i = 0; i < GP_FFT_CORES; i++) {
        const int r = gp_fft_core_radius[i];
        norm[i] = 0.0;
        for (int c = 0; c < 3; c++) {
            double core = 0.0; // sum of squares within the radius
            for (int y = k->cy - r; y <= k->cy + r; y++) {
                for (int x = k->cx - r; x <= k->cx + r; x++) {
                    if (y < 0 || y >= k->h || x < 0 || x >= k->w)
                        continue;
                    const double v =
                        (double) k->k.c[c][(size_t) y * (size_t) k->w +
                                           (size_t) x];
                    core += v * v;
                }
            }
            const double left = k->norm2[c] * k->norm2[c] - core;
            norm[i] = fmax(norm[i], sqrt(fmax(left, 0.0)));
        }
    }
}

/* Sources by the half-octave of their largest channel, hottest last. */
enum { BINS = 512 };
struct histogram {
    double count[BINS], energy[BINS];
};

static float largest(const struct gp_sources *s, size_t i)
{
    return fmaxf(s->rgb[0][i], fmaxf(s->rgb[1][i], s->rgb[2][i]));
}

/* Exponent and first mantissa bit; positive floats only. */
static int bin_of(float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return (int) (bits >> 22) & (BINS - 1);
}

/* The lower end of a bin. */
static float bin_start(int bin)
{
    const uint32_t bits = (uint32_t) bin << 22;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Milliseconds of the core for n sources: a side and a strip less one, on
 * average, are touched in each row. */
static double core_ms(double n, int r)
{
    if (r < 0)
        return 0.0;
    const double side = 2.0 * r + 1.0;
    return 1.25 * n * side * (side + GP_TAPS_PAD - 1.0) * GP_DIRECT_MS_PER_TAP;
}

/* One way to split, and what it costs. */
struct choice {
    struct gp_fft_split split;
    double ms;
};

/* A split within its means beats another when it reaches the aim more cheaply,
 * or comes nearer to it. Reaching it may cost as much as the transform. */
static int beats(const struct choice *a, const struct choice *b, double fft_ms)
{
    const int reaches = a->split.rounding <= ALLOWED;
    if (a->ms > (reaches ? fft_ms : fft_ms / 4.0))
        return 0;
    if (reaches != (b->split.rounding <= ALLOWED))
        return reaches;
    return reaches ? a->ms < b->ms : a->split.rounding < b->split.rounding;
}

void gp_fft_split_choose(const struct gp_sources *src,
                         const struct gp_kernel *k,
                         const double tail[GP_FFT_CORES], double points,
                         double fft_ms, double gain, struct gp_fft_split *out)
{
    static const double LEAST_GAIN = 4.0;
    struct histogram h = {0};
    for (size_t i = 0; i < src->n; i++) {
        const double v = (double) largest(src, i);
        h.count[bin_of((float) v)] += 1.0;
        h.energy[bin_of((float) v)] += v * v;
    }
    double energy = 0.0;
    for (int b = 0; b < BINS; b++)
        energy += h.energy[b];
    // black frames have no own value to spoil: the layer's peak counts there
    const double own = src->darkest > 0.0 ? src->darkest
                                          : 1e-6 * (double) src->brightest;
    const double scale = gain * NOISE / sqrt(points) / own;
    const double hot_ms = (double) k->w * k->h * GP_DIRECT_MS_PER_TAP;
    const double plain = scale * tail[0] * sqrt(energy);
    struct choice best = {
        {.core = -1, .hot = INFINITY, .rounding = plain}, 0.0,
    };

    double hot = 0.0, left = energy; // sources at and over bin b, energy under
    for (int b = BINS; b > 0 && plain > ALLOWED && hot * hot_ms < fft_ms; b--) {
        if (b < BINS) {
            hot += h.count[b];
            left -= h.energy[b];
            if (h.count[b] == 0.0)
                continue;
        }
        for (int i = 0; i < GP_FFT_CORES; i++) {
            const int r = gp_fft_core_radius[i];
            const struct choice c = {
                {
                    .core = r,
                    .hot = b < BINS ? bin_start(b) : INFINITY,
                    .hot_count = (size_t) hot,
                    .rounding = scale * tail[i] * sqrt(fmax(left, 0.0)),
                },
                hot * hot_ms + core_ms((double) src->n - hot, r),
            };
            if (beats(&c, &best, fft_ms))
                best = c;
        }
    }
    if (best.split.rounding > ALLOWED &&
        best.split.rounding * LEAST_GAIN > plain)
        best.split = (struct gp_fft_split) {
            .core = -1, .hot = INFINITY, .rounding = plain,
        };
    *out = best.split;
}

/* The sources for which (largest channel >= hot) == want. */
static gp_status filter(const struct gp_log *log, const struct gp_sources *src,
                        float hot, int want, struct gp_sources *out)
{
    gp_status st;
    void *v;
    struct gp_sources o = {.w = src->w, .h = src->h};
    GP_TRY(gp_alloc_zero(log, "sources", (size_t) src->h + 1, sizeof *o.row,
                         &v));
    o.row = v;
    GP_TRY(gp_alloc(log, "sources", src->n, sizeof *o.x, &v));
    o.x = v;
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc(log, "sources", src->n, sizeof *o.rgb[c], &v));
        o.rgb[c] = v;
    }
    struct gp_rect box = {src->w, src->h, 0, 0};
    for (int y = 0; y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            if ((largest(src, i) >= hot) != want)
                continue;
            const int x = src->x[i];
            o.x[o.n] = x;
            for (int c = 0; c < 3; c++)
                o.rgb[c][o.n] = src->rgb[c][i];
            o.n++;
            box.x0 = x < box.x0 ? x : box.x0;
            box.x1 = x + 1 > box.x1 ? x + 1 : box.x1;
            box.y0 = y < box.y0 ? y : box.y0;
            box.y1 = y + 1;
        }
        o.row[y + 1] = (uint32_t) o.n;
    }
    if (o.n)
        o.box = box;
    *out = o;
    o = (struct gp_sources) {0};
out:
    gp_sources_free(&o);
    return st;
}

gp_status gp_fft_split_sources(const struct gp_log *log,
                               const struct gp_sources *src, float hot,
                               struct gp_sources *hottest,
                               struct gp_sources *rest)
{
    gp_status st = filter(log, src, hot, 1, hottest);
    if (st)
        return st;
    st = filter(log, src, hot, 0, rest);
    if (st)
        gp_sources_free(hottest);
    return st;
}
