#include "glare/fft/split.h"

#include "glare/direct/direct.h"

#include <math.h>

const int gp_fft_core_radius[GP_FFT_CORES] = {-1, 4, 8, 16, 32};

/* The largest error of a pixel is about this times |s| |k| / sqrt(points): 1e-6
 * to 6.5e-6 over random frames, W1 to W3 and all radii (test_fft_split; numpy
 * float32 against float64); rounded up, as the darkest pixels are what counts. */
static const double NOISE = 6.5e-6;
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

/* What the squares of a bin's sources add up to, about: the mean square of
 * [1, 3/2) and [3/2, 2) is 0.7 and 0.77 of their ends'. */
static double bin_energy(const struct gp_sources *s, int bin)
{
    const double end = (double) gp_source_bin_start(bin + 1);
    return s->count[bin] ? 0.75 * s->count[bin] * end * end : 0.0;
}

/* Milliseconds of the core for n sources in `quads` quads, or one by one when
 * there are none: a side and a tile or strip less one, on average, are touched
 * in each row. Measured at 2.5 GHz with AVX2: 8.6 and 23.3 ms for w2's 28504
 * quads and radii 16 and 32, 2 ms of each being the pass over the layer. */
static double core_ms(double n, double quads, int r)
{
    static const double QUAD_TILE_MS = 3.2e-6;
    static const int TALL = 4, WIDE = 16; // pixels of a tile
    if (r < 0)
        return 0.0;
    const double side = 2.0 * r + 1.0;
    if (quads > 0.0)
        return 3.0 * QUAD_TILE_MS * quads * side / TALL *
               (side + WIDE - 1.0) / WIDE;
    return 1.25 * n * side * (side + GP_TAPS_PAD - 1.0) * GP_DIRECT_MS_PER_TAP;
}

enum { BINS = GP_SOURCE_BINS - 1 }; // the last one would hold NaN

/* What all splits of one frame share. A split sends no source, or all from one
 * bin up, whole, and one of the cores for the rest. */
struct search {
    const struct gp_sources *src;
    const double *tail;
    double energy, scale;
    double quads;     // that all sources make, or 0
    double core_most; // milliseconds that the core may take
    double hot_ms;    // of one hot source
    double pass_ms;   // of adding a direct part to the layer
};

/* The cheapest split of rounding <= `most` that costs up to `budget`; its
 * rounding is INFINITY when there is none. With least_rounding, the split of
 * least rounding in the budget instead. */
static struct gp_fft_split find(const struct search *s, double budget,
                                double most, int least_rounding)
{
    struct gp_fft_split best = {
        .core = -1, .rounding = INFINITY, .ms = INFINITY,
    };
    double hot = 0.0, left = s->energy; // sources from bin b up; energy under
    for (int b = BINS; b >= 0 && hot * s->hot_ms <= budget; b--) {
        if (b < BINS) {
            if (!s->src->count[b])
                continue;
            hot += s->src->count[b];
            left -= bin_energy(s->src, b);
        }
        for (int i = 0; i < GP_FFT_CORES; i++) {
            const int r = gp_fft_core_radius[i];
            const double n = (double) s->src->n, rest = n - hot;
            const double core = core_ms(rest, s->quads * rest / n, r);
            const double ms = hot * s->hot_ms + core +
                              s->pass_ms * ((hot > 0.0) + (r >= 0));
            const struct gp_fft_split split = {
                .core = r,
                .hot = b < BINS ? gp_source_bin_start(b) : INFINITY,
                .hot_count = (size_t) hot,
                .ms = ms,
                .rounding = s->scale * s->tail[i] * sqrt(fmax(left, 0.0)),
            };
            if (ms > budget || core > s->core_most || split.rounding > most)
                continue;
            if (least_rounding ? split.rounding < best.rounding
                               : split.ms < best.ms)
                best = split;
        }
    }
    return best;
}

void gp_fft_split_choose(const struct gp_sources *src,
                         const struct gp_kernel *k,
                         const double tail[GP_FFT_CORES], double points,
                         double fft_ms, double gain, struct gp_fft_split *out)
{
    static const double LEAST_GAIN = 4.0, NEAR = 2.0, WORTH = 4.0;
    static const double ANYWAY_MS = 5.0;
    // black frames have no own value to spoil: the layer's peak counts there
    const double own = src->darkest > 0.0 ? src->darkest
                                          : 1e-6 * (double) src->brightest;
    struct search s = {
        .src = src, .tail = tail,
        .scale = gain * NOISE / sqrt(points) / own,
        .hot_ms = (double) k->w * k->h * GP_DIRECT_MS_PER_TAP,
        .pass_ms = 2.5e-6 * src->w * src->h,
        .core_most = fft_ms + ANYWAY_MS,
    };
    for (int b = 0; b < BINS; b++)
        s.energy += bin_energy(src, b);
    const struct gp_fft_split none = {
        .core = -1, .hot = INFINITY,
        .rounding = s.scale * tail[0] * sqrt(s.energy),
    };
    *out = none;
    if (none.rounding <= ALLOWED)
        return;
    s.quads = gp_direct_quads(src);
    struct gp_fft_split found = find(&s, WORTH * fft_ms + ANYWAY_MS, ALLOWED, 0);
    if (!(found.rounding <= ALLOWED)) {
        const double least =
            find(&s, fft_ms / 2.0, INFINITY, 1).rounding;
        found = find(&s, fft_ms / 2.0, NEAR * least, 0);
        if (found.rounding * LEAST_GAIN > none.rounding)
            return;
    }
    *out = found;
}
