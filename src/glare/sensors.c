// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

enum {
    BLOCK = 16,  // rows a task takes
    WIDE = 4,    // doubles summed side by side
    PIECE = 256, // pixels of a row at a time: they stay in the L1 cache
};

/* The dark percentile is found to within a sixteenth, on a fixed grid. */
enum {
    GRID = 16384,    // pixels, about
    DARK_SHIFT = 19, // leaves sign, exponent and 4 bits of mantissa
    DARK_BINS = 1 << 13,
    BLACK = DARK_BINS - 1, // no luminance over 0 has it
};

/* The bright pixels of a piece of a row, packed, and dark ones that fill the
 * last WIDE of them. */
struct bright_piece {
    float rgb[3][PIECE + WIDE]; // non-negative part, then its light
    float largest[PIECE + WIDE]; // channel of each
    int32_t x[PIECE];
};

/* Sums of one block of rows; added up in the order of the blocks. */
struct block_sum {
    long long nonfinite, clamped;
    double taken[3];   // light that max_value removed
    bool infinite;     // has +Inf
    float largest;     // measure_block()
    double light[3];
    double flux[3][WIDE], energy[3][WIDE]; // of every WIDE-th source of a piece
    float brightest;
    bool faint; // a source is under GP_FAINT
};

struct sense {
    const struct glarepp_sense_params *p;
    float most;                  // limit of a channel
    float top;                   // replaces +Inf; 0: not known yet
    bool again;                  // bad pixels were counted
    float open;                  // luminance over which a pixel is bright
    float weight[3];             // of luminance
    int w, h;
    float *rgb[3];
    struct block_sum *block;
    uint32_t *bright;            // pixels of each row
    struct gp_sources *out;
    uint16_t *dark;              // of each pixel of the grid: bin of luminance
    size_t step;                 // of the grid, in pixels
};

float gp_bright_pass(const struct glarepp_sense_params *p, float y)
{
    if (!p->whole)
        return y > FLT_MAX ? 1.0f : y > p->threshold ? (y - p->threshold) / y
                                                     : 0.0f;
    if (p->knee <= 0.0f)
        return y > p->threshold ? 1.0f : 0.0f;
    const float lo = p->threshold * (1.0f - p->knee);
    const float hi = p->threshold * (1.0f + p->knee);
    if (!(y > lo))
        return 0.0f;
    if (y >= hi)
        return 1.0f;
    const float t = (y - lo) / (hi - lo);
    return t * t * (3.0f - 2.0f * t); // smoothstep: slope 0 at both ends
}

// -- bad pixels, counts, darkness --------------------------------------------

struct row_count {
    int nonfinite, clamped, bright;
};

/* Counts one row's bad pixels and, if there are none, its bright ones. No
 * branch and no store, so that it becomes vector code and the frame is only
 * read: bad pixels are rare. */
GP_CLONES static struct row_count count_row(const float *restrict r,
    const float *restrict g, const float *restrict b, int w, float max,
    const float *restrict weight, float open)
{
    int bad = 0, over = 0, lit_up = 0;
    for (int x = 0; x < w; x++) {
        const float vr = r[x], vg = g[x], vb = b[x];
        const int finite = (fabsf(vr) <= FLT_MAX) & (fabsf(vg) <= FLT_MAX) &
                           (fabsf(vb) <= FLT_MAX);
        const int large = ((vr > max) & (vr <= FLT_MAX)) |
                          ((vg > max) & (vg <= FLT_MAX)) |
                          ((vb > max) & (vb <= FLT_MAX));
        bad += !finite;
        over += large;
        lit_up += gp_lit_luminance(weight, vr, vg, vb) > open;
    }
    return (struct row_count) {bad, over, lit_up};
}

/* Cleans the pixels of a row; +Inf stays until the frame's largest finite value
 * is known. */
static void clean_row(const struct sense *s, struct block_sum *sum, size_t at)
{
    for (size_t i = at; i < at + (size_t) s->w; i++) {
        float v[3], most = -FLT_MAX;
        for (int k = 0; k < 3; k++) {
            const float f = s->rgb[k][i];
            v[k] = f != f || f < -FLT_MAX         ? 0.0f
                   : f > FLT_MAX && s->top > 0.0f ? s->top : f;
            most = gp_maxf(v[k], most);
        }
        sum->infinite = sum->infinite || most > FLT_MAX;
        const bool over = most > s->most && most <= FLT_MAX;
        const double less = over ? (double) s->most / (double) most : 1.0;
        for (int k = 0; k < 3; k++) {
            s->rgb[k][i] = over ? (float) ((double) v[k] * less) : v[k];
            if (!s->again)
                sum->taken[k] += (double) gp_lit(v[k]) -
                                 (double) gp_lit(s->rgb[k][i]);
        }
    }
}

static void clean_block(void *ctx, int i, GP_UNUSED int thread)
{
    struct sense *const s = ctx;
    struct block_sum *const sum = &s->block[i];
    const int end = gp_min((i + 1) * BLOCK, s->h);
    for (int y = i * BLOCK; y < end; y++) {
        const size_t at = (size_t) y * (size_t) s->w;
        const float *const r = s->rgb[0] + at, *const g = s->rgb[1] + at;
        const float *const b = s->rgb[2] + at;
        struct row_count n = count_row(r, g, b, s->w, s->most, s->weight,
                                       s->open);
        const int bad = n.nonfinite, over = n.clamped;
        if (bad || over) {
            clean_row(s, sum, at);
            n = count_row(r, g, b, s->w, s->most, s->weight,
                          s->open);
        }
        // the grid's pixels of the row, which is in the cache by now: every
        // k-th pixel of the frame, about GRID in all
        const size_t row_end = at + (size_t) s->w;
        for (size_t k = (at + s->step - 1) / s->step * s->step; k < row_end;
             k += s->step) {
            const float lum = gp_lit_luminance(s->weight, s->rgb[0][k],
                                               s->rgb[1][k], s->rgb[2][k]);
            s->dark[k / s->step] =
                (uint16_t) (lum > 0.0f ? gp_bits_of(lum) >> DARK_SHIFT : BLACK);
        }
        s->bright[y] = (uint32_t) n.bright;
        if (!s->again) {
            sum->nonfinite += bad;
            sum->clamped += over;
        }
    }
}

/* Cleans and counts a frame in which a first pass found bad pixels. */
static void clean_again(struct sense *s, int blocks)
{
    s->again = true;
    gp_parallel_do(blocks, clean_block, s);
}

/* The largest finite value of a block, and its light. */
static void measure_block(void *ctx, int i, GP_UNUSED int thread)
{
    struct sense *const s = ctx;
    struct block_sum *const sum = &s->block[i];
    const size_t w = (size_t) s->w;
    const size_t end = w * (size_t) gp_min((i + 1) * BLOCK, s->h);
    for (int k = 0; k < 3; k++) {
        sum->light[k] = 0.0;
        for (size_t p = (size_t) i * BLOCK * w; p < end; p++) {
            const float v = s->rgb[k][p];
            if (v > 0.0f && v <= FLT_MAX) {
                sum->largest = gp_maxf(v, sum->largest);
                sum->light[k] += (double) v;
            }
        }
    }
}

/* Warns when max_value removed over 1 % of the frame's light. */
static void warn_of_clamping(const struct gp_log *log, const char *path,
                             struct sense *s, int blocks,
                             const struct gp_sources *o)
{
    static const char *const name[3] = {"red", "green", "blue"};
    double light[3] = {0.0, 0.0, 0.0}, share = 0.01;
    int worst = -1;
    if (!o->clamped)
        return;
    gp_parallel_do(blocks, measure_block, s);
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < blocks; i++)
            light[k] += s->block[i].light[k];
        const double taken = o->flux_clamped[k];
        if (taken > share * (light[k] + taken)) {
            share = taken / (light[k] + taken);
            worst = k;
        }
    }
    if (worst >= 0)
        gp_say_at(log, GP_LEVEL_WARN, "sense.max_value.low", "%s: the limit of "
                  "values removes %.3g %% of the frame's %s light (%lld pixels "
                  "over %g)", path ? path : "frame", 100.0 * share, name[worst],
                  o->clamped, (double) s->p->max_value);
}

// -- the list -----------------------------------------------------------------

/* Packs the bright ones of n <= PIECE cleaned pixels whose first is at column
 * x0, with the part of each that is light; returns how many. */
GP_CLONES static int find_bright(const struct sense *s,
    const float *const rgb[3], int x0, int n, struct bright_piece *out)
{
    float light[3][PIECE], lum[PIECE] = {0};
    int at = 0;
    for (int i = 0; i < n; i++) {
        for (int k = 0; k < 3; k++)
            light[k][i] = gp_lit(rgb[k][i]);
        lum[i] = gp_lit_luminance(s->weight, light[0][i], light[1][i],
                                  light[2][i]);
    }
    for (int from = 0; from < n; from += WIDE) {
        bool any = false;
        for (int i = from; i < from + WIDE; i++)
            any |= lum[i] > s->open;
        for (int i = from; any && i < gp_min(from + WIDE, n); i++) {
            for (int k = 0; k < 3; k++)
                out->rgb[k][at] = light[k][i];
            out->largest[at] = lum[i];
            out->x[at] = x0 + i;
            at += lum[i] > s->open; // a dark one is overwritten by the next
        }
    }
    const bool whole = s->p->whole && !(s->p->knee > 0.0f);
    for (int i = 0; i < at && !whole; i++) {
        const float pass = gp_bright_pass(s->p, out->largest[i]);
        for (int k = 0; k < 3; k++)
            out->rgb[k][i] *= pass;
    }
    return at;
}

/* Adds n sources to the sums, each lane by itself, in the order of the row:
 * the same bits with any vectors. */
GP_CLONES static void sum_row(struct bright_piece *c, int n,
                              struct block_sum *sum)
{
    for (int i = n; i % WIDE; i++) // dark lanes fill the last vector
        c->rgb[0][i] = c->rgb[1][i] = c->rgb[2][i] = 0.0f;
    for (int k = 0; k < 3; k++) {
        for (int i = 0; i < n; i += WIDE) {
            for (int j = 0; j < WIDE; j++) {
                const double v = (double) c->rgb[k][i + j];
                sum->flux[k][j] += v;
                sum->energy[k][j] += v * v;
            }
        }
    }
    for (int i = 0; i < n; i++) {
        c->largest[i] = gp_maxf(gp_maxf(c->rgb[0][i], c->rgb[1][i]),
                                c->rgb[2][i]);
        sum->brightest = gp_maxf(c->largest[i], sum->brightest);
    }
}

/* Writes the sources of a block's rows at their places in the list. */
static void list_block(void *ctx, int block, GP_UNUSED int thread)
{
    struct sense *const s = ctx;
    const struct gp_sources *const o = s->out;
    struct block_sum *const sum = &s->block[block];
    struct bright_piece c;
    const int y0 = block * BLOCK, end = gp_min(y0 + BLOCK, s->h);
    if (o->row[end] == o->row[y0])
        return;
    for (int y = y0; y < end; y++) {
        uint32_t at = o->row[y];
        for (int x0 = 0; x0 < s->w && at < o->row[y + 1]; x0 += PIECE) {
            const size_t first = (size_t) y * (size_t) s->w + (size_t) x0;
            const float *const rgb[3] = {s->rgb[0] + first, s->rgb[1] + first,
                                         s->rgb[2] + first};
            const int n =
                find_bright(s, rgb, x0, gp_min(s->w - x0, PIECE), &c);
            sum_row(&c, n, sum);
            for (int i = 0; i < n; i++)
                sum->faint |= c.largest[i] < GP_FAINT;
            memcpy(o->x + at, c.x, (size_t) n * sizeof *o->x);
            for (int k = 0; k < 3; k++)
                memcpy(o->rgb[k] + at, c.rgb[k], (size_t) n * sizeof *c.rgb[k]);
            at += (uint32_t) n;
        }
    }
}

/* Finds the 0.01 % percentile of luminance of the grid's pixels. */
static double find_darkest(const struct sense *s, size_t n)
{
    uint32_t count[DARK_BINS] = {0}, b = 0;
    for (size_t i = 0; i < n; i++)
        count[s->dark[i]]++;
    for (size_t below = count[BLACK]; below * 10000 < n && b < BLACK; b++)
        below += count[b];
    return b ? (double) gp_float_with_bits((b - 1) << DARK_SHIFT) : 0.0;
}

static double total(const double v[WIDE])
{
    return (v[0] + v[1]) + (v[2] + v[3]);
}

/* Returns the luminance over which a pixel is bright, for a threshold in
 * luminance. */
static float opening(const struct glarepp_sense_params *p)
{
    const bool ramp = p->whole && p->knee > 0.0f;
    return ramp ? p->threshold * (1.0f - p->knee) : p->threshold;
}

/* Finds a threshold in luminance. */
static gp_status find_threshold(const struct gp_log *log,
                                const struct gp_image *f,
                                struct glarepp_sense_params *p)
{
    gp_status st = GP_OK;
    if (p->unit == GLAREPP_PERCENTILE)
        st = gp_luminance_percentile(log, f, (double) p->threshold,
                                     &p->threshold);
    if (p->unit == GLAREPP_EV)
        p->threshold = (float) fmin(gp_exp2((double) p->threshold) *
                                        gp_log_average(f, &f->rgb),
                                    (double) FLT_MAX);
    return st;
}

/* The same of a lat-long: by as many pixels of each row as it has of the sphere. */
static gp_status find_round_threshold(const struct gp_log *log,
                                      const struct gp_image *f,
                                      struct glarepp_sense_params *p)
{
    const int w = gp_image_w(f), h = gp_rect_h(f->display);
    struct gp_image even = *f;
    size_t n = 0;
    even.rgb = (struct gp_planes) {0};
    gp_status st =
        gp_planes_make(log, "sensors", gp_image_pixels(f), &even.rgb);
    for (int y = f->data.y0; y < f->data.y1 && !st; y++) {
        const double v = M_PI * ((y + 0.5 - f->display.y0) / h - 0.5);
        const int count = (int) ceil(w * fmax(gp_cos(v), 0.0));
        const size_t row = (size_t) (y - f->data.y0) * (size_t) w;
        for (int i = 0; i < count; i++, n++) {
            const size_t x = (size_t) ((i + 0.5) / count * w);
            for (int c = 0; c < 3; c++)
                even.rgb.c[c][n] = f->rgb.c[c][row + x];
        }
    }
    even.data = even.display = even.read = (struct gp_rect) {0, 0, (int) n, 1};
    if (!st && n)
        st = find_threshold(log, &even, p);
    gp_planes_free(&even.rgb);
    return st;
}

/* Cleans the frame, finds its threshold and counts its bright pixels. */
static gp_status clean_frame(const struct gp_log *log, struct sense *s,
                             int blocks, const struct gp_image *f, bool sphere,
                             struct glarepp_sense_params *p)
{
    gp_status st = GP_OK;
    const bool relative = p->unit != GLAREPP_LUMINANCE;
    bool infinite = false;
    s->open = opening(p);
    gp_parallel_do(blocks, clean_block, s);
    for (int i = 0; i < blocks; i++)
        infinite = infinite || s->block[i].infinite;
    if (infinite) {
        s->top = 65504.0f; // half's largest value
        gp_parallel_do(blocks, measure_block, s);
        for (int i = 0; i < blocks; i++)
            s->top = gp_maxf(s->block[i].largest, s->top);
        clean_again(s, blocks);
    }
    if (relative)
        st = sphere ? find_round_threshold(log, f, p)
                    : find_threshold(log, f, p);
    p->unit = GLAREPP_LUMINANCE;
    if (relative && !st) {
        s->open = opening(p);
        clean_again(s, blocks);
    }
    return st;
}

gp_status gp_sense(const struct gp_log *log,
                   const struct glarepp_sense_params *p, bool sphere,
                   struct gp_image *f, struct gp_sources *out)
{
    gp_status st;
    struct glarepp_sense_params found = *p; // its threshold in luminance
    const struct gp_sources like = {
        .w = gp_image_w(f), .h = gp_image_h(f),
        .x0 = f->data.x0, .y0 = f->data.y0,
        .luminance = {f->luminance[0], f->luminance[1], f->luminance[2]},
    };
    struct gp_sources o = {0};
    struct sense s = {
        .p = &found, .w = like.w, .h = like.h, .out = &o,
        .rgb = {f->rgb.c[0], f->rgb.c[1], f->rgb.c[2]},
        .step = (size_t) like.w * (size_t) like.h / GRID + 1,
        .most = p->max_value > 0.0f ? p->max_value : FLT_MAX,
    };
    const int blocks = (s.h + BLOCK - 1) / BLOCK;
    const size_t grid = ((size_t) s.w * (size_t) s.h - 1) / s.step + 1;
    memcpy(s.weight, f->luminance, sizeof s.weight);
    GP_TRY(gp_alloc_zero(log, "sensors", (size_t) blocks + 1,
                         sizeof *s.block, &s.block));
    GP_TRY(gp_alloc(log, "sensors", grid, sizeof *s.dark, &s.dark));
    GP_TRY(gp_alloc(log, "sensors", (size_t) s.h, sizeof *s.bright, &s.bright));
    GP_TRY(clean_frame(log, &s, blocks, f, sphere, &found));
    size_t n = 0;
    bool faint = false;
    for (int y = 0; y < s.h; y++)
        n += s.bright[y];
    GP_TRY(gp_sources_make(log, &like, n, &o));
    for (int y = 0; y < s.h; y++) // counts become offsets
        o.row[y + 1] = o.row[y] + s.bright[y];
    if (n)
        gp_parallel_do(blocks, list_block, &s);
    for (int i = 0; i < blocks; i++) {
        const struct block_sum *const b = &s.block[i];
        o.nonfinite += b->nonfinite;
        o.clamped += b->clamped;
        for (int k = 0; k < 3; k++) {
            o.flux[k] += total(b->flux[k]);
            o.energy[k] += total(b->energy[k]);
            o.flux_clamped[k] += b->taken[k];
        }
        o.brightest = gp_maxf(b->brightest, o.brightest);
        faint |= b->faint;
    }
    o.threshold = found.threshold;
    o.darkest = find_darkest(&s, grid);
    warn_of_clamping(log, f->path, &s, blocks, &o);
    gp_sources_finish(&o);
    if (!faint) {
        *out = o;
        o = (struct gp_sources) {0};
        goto out;
    }
    // the list anew without light under FLT_MIN, which is rare
    st = gp_sources_scale(log, &o, 1.0, NULL, out);
out:
    gp_free(s.block);
    gp_free(s.dark);
    gp_free(s.bright);
    gp_sources_free(&o);
    return st;
}
