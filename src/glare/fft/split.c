// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/direct/direct.h"
#include "glare/fft/fft_priv.h"
#include "glare/kernel_rows.h"

#include <limits.h>
#include <math.h>

// -- places on the torus ------------------------------------------------------

struct axis {
    int out0, out1, tap0, tap1;
    int period; // the least
};

/* One axis: sources [in0, in1), kernel offsets [-c, w - 1 - c], frame [0, n). */
static struct axis place_axis(int in0, int in1, int c, int w, int n)
{
    struct axis a = {gp_max(0, in0 - c), gp_min(n, in1 + w - 1 - c), 0, 0, 0};
    if (a.out1 <= a.out0) // nothing of the kernel reaches the frame
        a.out1 = a.out0 = 0;
    a.tap0 = gp_max(-c, a.out0 - (in1 - 1));
    a.tap1 = gp_min(w - c, a.out1 - in0);
    const int right = in1 - 1 + a.tap1 - 1 - a.out0; // wraps to the left end
    const int left = a.out1 - 1 - (in0 + a.tap0);
    a.period = gp_max(gp_max(right, left) + 1,
                      gp_max(in1 - in0, a.tap1 - a.tap0));
    return a;
}

struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k)
{
    struct gp_fft_placing p = {.in = s->box};
    const struct axis x = place_axis(p.in.x0, p.in.x1, k->cx, k->w, s->w);
    const struct axis y = place_axis(p.in.y0, p.in.y1, k->cy, k->h, s->h);
    p.out = (struct gp_rect) {x.out0, y.out0, x.out1, y.out1};
    p.taps = (struct gp_rect) {x.tap0, y.tap0, x.tap1, y.tap1};
    if (!gp_rect_empty(p.out)) {
        // by the frame's rows: lights that come and go change no length
        p.ny = gp_fft_column_length(y.period);
        p.nx = gp_fft_row_length(x.period, s->h, p.ny);
    }
    return p;
}

double gp_fft_passes_ms(const struct gp_sources *s,
                        const struct gp_fft_placing *p, enum gp_fft_plan how)
{
    int light = 0;
    for (int y = 0; y < s->h; y++)
        light += s->row[y + 1] > s->row[y];
    const double rows = (light + gp_rect_h(p->out)) / 2.0;
    return 3.0 * GP_COST_FFT_PASS *
           (rows * gp_fft_cost(p->nx, how) +
            (p->nx + 2.0) * gp_fft_cost(p->ny, how));
}

void gp_fft_find_quarters(const struct gp_kernel *k, int w, int h,
                          struct gp_fft_quarters *out)
{
    // distance from the centre that a source in the frame surely sees, to one
    // side at least: everything, where the kernel has no more samples than that
    const int reach_x = k->w - 1 <= w ? INT_MAX / 2 : w / 2;
    const int reach_y = k->h - 1 <= h ? INT_MAX / 2 : h / 2;
    *out = (struct gp_fft_quarters) {0};
    if (k->lit && reach_x > w && reach_y > h) {
        for (int c = 0; c < 3; c++) {
            out->square[c] = k->quarter_square[c];
            out->sum[c] = k->quarter_sum[c];
        }
        return;
    }
    for (int c = 0; c < 3 && !k->negative; c++) {
        if (c > 0 && k->grey) {
            out->square[c] = out->square[0];
            out->sum[c] = out->sum[0];
            continue;
        }
        struct gp_quarter_sums q = {0};
        for (int y = 0; y < k->h; y++) {
            double side[4];
            gp_row_sides(k->k.c[c] + (size_t) y * (size_t) k->w, k->w, k->cx,
                         reach_x, side);
            gp_quarter_add(&q, side, y <= k->cy && y >= k->cy - reach_y,
                           y >= k->cy && y <= k->cy + reach_y);
        }
        out->square[c] = gp_quarter_least(q.square);
        out->sum[c] = gp_quarter_least(q.sum);
    }
}

double gp_fft_least(const struct gp_sources *s, const struct gp_fft_quarters *q)
{
    double all = 0.0;
    for (int c = 0; c < 3; c++) {
        const double flux = s->flux[c] * q->sum[c];
        all += fmax(s->energy[c] * q->square[c],
                    flux * flux / ((double) s->w * s->h));
    }
    return sqrt(all);
}

static const double STAGE = 0.75; // of 2^-24: see fft_priv.h

double gp_fft_bound(const struct gp_sources *s, const struct gp_kernel *k,
                    double least, const struct gp_fft_placing *p)
{
    static const double ADDING = 0.45;
    static const double CERTAIN = 1e-6; // sums in double lose what is under it
    double noise = 0.0, layer = 0.0; // squares
    for (int c = 0; c < 3; c++) {
        const double norm = sqrt(s->energy[c]);
        const double young = fmin(norm * k->norm1[c], s->flux[c] * k->norm2[c]);
        noise += norm * norm * k->norm2[c] * k->norm2[c];
        layer += young * young;
    }
    if (!(least > CERTAIN * sqrt(noise)))
        return INFINITY;
    return 0x1p-24 * sqrt(log2((double) p->nx * p->ny)) *
           (2.0 * STAGE * sqrt(noise) +
            (STAGE + 2.0 * ADDING) * sqrt(layer)) / least;
}

double gp_fft_pixel_error(const struct gp_fft_placing *p, double most,
                          double norm, double pair)
{
    static const double T = 7.0;
    const double points = (double) p->nx * p->ny;
    double sum = 0.0;
    for (double n = 1.0; n <= points; n *= 2.0) {
        const double mean = fmin(most * most, norm * norm / n);
        sum += mean + 2.0 * fmin(mean, n * pair * most);
    }
    return T * STAGE * 0x1p-24 * sqrt(sum);
}

// -- the direct part ---------------------------------------------------------

static const struct gp_fft_core NONE = {-1, -1};
const struct gp_fft_core gp_fft_cores[GP_FFT_CORES] = {
    {-1, -1}, {4, 4},  {8, 8},  {12, 12}, {16, 16},  {32, 32},
    {64, 8},  {8, 64}, {64, 16}, {16, 64}, {128, 16}, {16, 128},
};

/* The largest error of a pixel is about this times |s| |k| / sqrt(points): 1e-6
 * to 6.5e-6 over random frames, W1 to W3 and all radii (test_fft_split; numpy
 * float32 against float64); rounded up, as the darkest pixels count. */
static const double NOISE = 6.5e-6;

/* The sum of squares of h rows of w samples, `pitch` apart. */
GP_CLONES static double box_squares(const float *v, int pitch, int w, int h)
{
    enum { LANES = 8 };
    double square[LANES] = {0}, sum = 0.0;
    for (int y = 0; y < h; y++) {
        const float *const row = v + (ptrdiff_t) y * pitch;
        int x = 0;
        for (; x + LANES <= w; x += LANES) {
            for (int i = 0; i < LANES; i++)
                square[i] += (double) row[x + i] * (double) row[x + i];
        }
        for (; x < w; x++)
            sum += (double) row[x] * (double) row[x];
    }
    for (int i = 0; i < LANES; i++)
        sum += square[i];
    return sum;
}

void gp_fft_far_norms(const struct gp_kernel *k, double norm[GP_FFT_CORES])
{
    double all[3]; // of the kernel's own samples, without its tail
    for (int c = 0; c < 3; c++)
        all[c] = k->far ? box_squares(k->k.c[c], k->w, k->w, k->h)
                        : k->norm2[c] * k->norm2[c];
    for (int i = 0; i < GP_FFT_CORES; i++) {
        const struct gp_fft_core r = gp_fft_cores[i];
        norm[i] = 0.0;
        for (int c = 0; c < 3; c++) {
            const int from = gp_max(k->cx - r.x, 0);
            const int to = gp_min(k->cx + r.x + 1, k->w);
            const int top = gp_max(k->cy - r.y, 0);
            const int bottom = gp_min(k->cy + r.y + 1, k->h);
            const double core = box_squares(
                k->k.c[c] + (ptrdiff_t) top * k->w + from, k->w, to - from,
                bottom - top);
            norm[i] = fmax(norm[i], sqrt(fmax(all[c] - core, 0.0)));
        }
    }
}

/* Estimates the sum of squares of a bin's sources: the mean square of [1,
 * 3/2) and [3/2, 2) is 0.7 and 0.77 of their ends'. */
static double bin_energy(const struct gp_sources *s, int bin)
{
    const double end = (double) gp_source_bin_start(bin + 1);
    return s->count[bin] ? 0.75 * s->count[bin] * end * end : 0.0;
}

/* Milliseconds of quads of taps w x h, touched in tiles. Measured at 2.5 GHz
 * with AVX2: 8.6 and 23.3 ms for w2's 28504 quads and cores of radii 16 and 32,
 * 2 ms of each being the pass over the layer. */
static double quads_ms(double quads, double w, double h)
{
    static const double TALL = 4.0, WIDE = 16.0; // pixels of a tile
    return GP_COST_DIRECT_QUAD_TILE * quads * h / TALL * (w + WIDE - 1.0) /
           WIDE;
}

enum { BINS = GP_SOURCE_BINS - 1 }; // the last one would hold NaN

/* State that all splits of one frame share. A split sends no source, or all
 * from one bin up, whole, and one of the cores for the rest. */
struct search {
    const struct gp_sources *src;
    const double *tail;
    double energy, scale;
    double quads;     // that all sources make, or 0
    double hot_ms;    // of one hot source
    double hot_pass_ms; // of adding those of all hot sources to the layer
};

/* Milliseconds of adding a part of the kernel to the pixels that it reaches. */
static double pass_ms(const struct gp_sources *s, int rx, int ry)
{
    const double w = fmin(gp_rect_w(s->box) + 2.0 * rx, s->w);
    const double h = fmin(gp_rect_h(s->box) + 2.0 * ry, s->h);
    return GP_COST_DIRECT_PIXEL * w * h;
}

/* The cheapest split of rounding <= `most` that costs up to `budget`; its
 * rounding is INFINITY when there is none. */
static struct gp_fft_split find_split(const struct search *s, double budget,
                                      double most)
{
    struct gp_fft_split best = {
        .core = NONE, .rounding = INFINITY, .ms = INFINITY,
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
            const struct gp_fft_core r = gp_fft_cores[i];
            const double n = (double) s->src->n, rest = n - hot;
            const double quads = s->quads * rest / n;
            const double across = 2.0 * r.x + 1.0, down = 2.0 * r.y + 1.0;
            // the core for the rest in quads, or one by one when there are
            // none: a side and a tile or strip less one, on average, are
            // touched in each row
            const double core =
                r.x < 0       ? 0.0
                : quads > 0.0 ? quads_ms(quads, across, down)
                              : 1.25 * rest * down *
                                    (across + GP_TAPS_PAD - 1.0) *
                                    GP_COST_DIRECT_TAP;
            const double ms = hot * s->hot_ms + core +
                              (hot > 0.0 ? s->hot_pass_ms : 0.0) +
                              (r.x < 0 ? 0.0 : pass_ms(s->src, r.x, r.y));
            const struct gp_fft_split split = {
                .core = r,
                .hot = b < BINS ? gp_source_bin_start(b) : INFINITY,
                .hot_count = (size_t) hot,
                .ms = ms,
                .rounding = s->scale * s->tail[i] * sqrt(fmax(left, 0.0)),
            };
            if (ms <= budget && split.rounding <= most && ms < best.ms)
                best = split;
        }
    }
    return best;
}

/* Noise that shows near black, over a dark pixel's own value. */
static double find_seen(const struct gp_sources *src, double own)
{
    // a frame that is black has no light of its own to hide noise at any EV
    return fmin(src->visible > 0.0 ? src->visible / own : INFINITY,
                src->hidden > 0.0 ? src->hidden / own : INFINITY);
}

/* Noise that shows in the layer itself where only the kernel's tail is left of
 * it. */
static double find_seen_of_tail(const struct gp_sources *src,
                                const struct gp_kernel *k, double own,
                                double gain)
{
    static const double SEEN = 5e-3; // of the layer's own value
    double seen = INFINITY;
    for (int c = 0; c < 3 && k->far; c++) {
        if (src->flux[c] > 0.0)
            seen = fmin(seen, SEEN * gain * src->flux[c] * k->far->least / own);
    }
    return seen;
}

void gp_fft_split_choose(const struct gp_sources *src,
    const struct gp_kernel *k, const double tail[GP_FFT_CORES], double points,
    double fft_ms, double gain, struct gp_fft_split *out)
{
    // wanted; enough of float alone; wanted where that is not: without a coarse
    // far part, and with one, which is no finer
    static const double levels[2][3] = {{1e-6, 1e-4, 1e-6}, {1e-5, 2e-3, 1e-4}};
    static const double CHEAP_MS = 5.0; // more than transforms take
    const double *const level = levels[k->far != NULL];
    const double own = gp_sources_dark(src);
    struct search s = {
        .src = src, .tail = tail,
        .scale = gain * NOISE / sqrt(points) / own,
        .hot_ms = (double) k->w * k->h * GP_COST_DIRECT_TAP,
        .hot_pass_ms = pass_ms(src, k->w, k->h),
    };
    for (int b = 0; b < BINS; b++)
        s.energy += bin_energy(src, b);
    *out = (struct gp_fft_split) {
        .core = NONE, .hot = INFINITY,
        .rounding = s.scale * tail[0] * sqrt(s.energy),
    };
    const double twice_ms = (GP_COST_FFT_DOUBLE - 1.0) * fft_ms;
    const double cheap_ms = fmax(fft_ms / 2.0, CHEAP_MS);
    const double of_tail = find_seen_of_tail(src, k, own, gain);
    // where the frame has light of its own, that in the layer is worth less
    const double seen = fmin(find_seen(src, own),
                             src->hidden > 0.0 ? of_tail : INFINITY);
    const double wanted = fmin(level[0], fmin(seen, of_tail));
    const bool would_do = out->rounding <= fmin(level[1], seen);
    if (out->rounding <= wanted)
        return;
    s.quads = gp_direct_quads(src);
    struct gp_fft_split found =
        find_split(&s, k->far ? cheap_ms : twice_ms, wanted);
    if (!(found.rounding <= wanted) && !would_do)
        found = find_split(&s, twice_ms, fmin(level[2], seen));
    if (found.rounding < INFINITY) {
        *out = found;
    } else if (!would_do) {
        out->in_double = true;
        out->rounding *= GP_FFT_DOUBLE_ROUNDING;
        out->ms = twice_ms;
    }
}
