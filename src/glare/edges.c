// SPDX-License-Identifier: Apache-2.0
/* Light from beyond the border. */
#include "glare/edges.h"

#include "core/bytes.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/kernel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

// -- the cells of a border ------------------------------------------------------

/* A cell: the middle of its outer side, in pixels (the first pixel's centre is
 * 0, 0), and its light. */
struct cell {
    float x, y, length;
    float root[3]; // mean of cube roots of the picture's light
    float all[3];  // mean of it
    float own[3];  // ... of the part that is wanted
};

void gp_beyond_free(struct gp_beyond **b)
{
    if (*b)
        gp_planes_free(&(*b)->b);
    GP_FREE(*b);
}

/* The cube root of a normal float or 0, within 3e-7: a third of the exponent, then
 * two of Halley's steps. Faint light counts as none. */
static inline float cube_root(float v)
{
    float r = gp_float_with_bits(gp_bits_of(v) / 3 + 0x2a5119f2);
    for (int i = 0; i < 2; i++) {
        const float cube = r / v * r * r; // over v
        r *= (cube + 2.0f) / (2.0f * cube + 1.0f);
    }
    return v >= FLT_MIN ? r : 0.0f;
}

/* Sets the means of the light in a box, and of its cube roots. */
static void sum_box(const struct gp_sources *s, struct gp_rect box,
                    float light[3], float root[3])
{
    const double n = (double) gp_rect_w(box) * (double) gp_rect_h(box);
    double sum[3] = {0}, roots[3] = {0};
    for (int y = box.y0; y < box.y1; y++) {
        const uint32_t past = s->row[y + 1];
        uint32_t i = gp_first_from(s->x, s->row[y], past, box.x0);
        for (; i < past && s->x[i] < box.x1; i++) {
            for (int c = 0; c < 3; c++) {
                sum[c] += (double) s->rgb[c][i];
                roots[c] += (double) cube_root(s->rgb[c][i]);
            }
        }
    }
    for (int c = 0; c < 3; c++) {
        light[c] = (float) (sum[c] / n);
        root[c] = (float) (roots[c] / n);
    }
}

struct border {
    const struct gp_sources *picture, *own;
    int side, depth;  // of a cell along the border, and across
    int across, down; // cells of a side
    struct cell *cell;
};

/* Cell i: those of the upper side, the lower, the left, the right. */
static void find_cell(const struct border *a, int i)
{
    const int w = a->picture->w, h = a->picture->h;
    const bool flat = i < 2 * a->across; // upper or lower
    const int k = flat ? i % a->across : (i - 2 * a->across) % a->down;
    const bool far = flat ? i >= a->across : i >= 2 * a->across + a->down;
    const int from = k * a->side;
    const int to = gp_min(from + a->side, flat ? w : h);
    const int deep = gp_min(a->depth, flat ? h : w);
    const int first = far ? (flat ? h : w) - deep : 0;
    const struct gp_rect box =
        flat ? (struct gp_rect) {from, first, to, first + deep}
             : (struct gp_rect) {first, from, first + deep, to};
    const float middle = 0.5f * (float) (from + to - 1);
    const float line = far ? (float) (flat ? h : w) - 0.5f : -0.5f;
    struct cell *const out = &a->cell[i];
    out->x = flat ? middle : line;
    out->y = flat ? line : middle;
    out->length = (float) (to - from);
    sum_box(a->own, box, out->own, out->root);
    sum_box(a->picture, box, out->all, out->root);
}

/* The cell i of n around the picture: along the upper side, down the right, back
 * along the lower and up the left. */
static struct cell *cell_around(const struct border *a, int i)
{
    const int n = 2 * (a->across + a->down);
    i = (i + n) % n;
    const int right = i - a->across, lower = right - a->down,
              left = lower - a->across;
    return &a->cell[right < 0   ? i
                    : lower < 0 ? 2 * a->across + a->down + right
                    : left < 0  ? 2 * a->across - 1 - lower
                                : 2 * a->across + a->down - 1 - left];
}

/* Takes lamps out: opens the luminance of roots along the border (Serra, Image
 * Analysis and Mathematical Morphology, 1982), which lowers what is shorter than
 * 2 GP_EDGE_LAMP + 1 cells to what is beside it. */
static gp_status take_lamps_out(const struct gp_log *log, const float weight[3],
                                const struct border *a)
{
    const int n = 2 * (a->across + a->down);
    float *y, *least;
    gp_status st = gp_alloc(log, "edges", 2 * (size_t) n, sizeof *y, &y);
    if (st)
        return st;
    least = y + n;
    for (int i = 0; i < n; i++) {
        const float *const r = cell_around(a, i)->root;
        y[i] = weight[0] * r[0] + weight[1] * r[1] + weight[2] * r[2];
    }
    for (int i = 0; i < n; i++) {
        least[i] = y[i];
        for (int k = -GP_EDGE_LAMP; k <= GP_EDGE_LAMP; k++)
            least[i] = gp_minf(least[i], y[((i + k) % n + n) % n]);
    }
    for (int i = 0; i < n; i++) {
        float open = 0.0f;
        for (int k = -GP_EDGE_LAMP; k <= GP_EDGE_LAMP; k++)
            open = gp_maxf(open, least[((i + k) % n + n) % n]);
        float *const r = cell_around(a, i)->root;
        for (int c = 0; c < 3 && y[i] > open; c++)
            r[c] *= open / y[i];
    }
    gp_free(y);
    return GP_OK;
}

// -- the light that is seen from a pixel ------------------------------------------

struct seeing {
    struct gp_beyond *b;
    const struct cell *cell;
    int cells, corners; // of the border; in a row
    bool part;          // of the light of the border
    float *sums; // 10 rows of corners for each thread
};

/* Adds a cell to the sums of a row of corners: of weights, of roots, and where
 * the light is a part, of that and of all, each times weights. */
GP_CLONES static void add_cell(const struct cell *restrict cell, float y,
                               bool part, int side, int n, float *restrict sums)
{
    const float up = y - cell->y, soft = up * up + (float) (side * side);
    const float step = (float) side;
    for (int i = 0; i < n; i++) {
        const float dx = (float) i * step - cell->x;
        const float d2 = dx * dx + soft;
        const float v = cell->length / (d2 * sqrtf(d2));
        sums[i] += v;
        for (int c = 0; c < 3; c++)
            sums[i + (1 + c) * n] += v * cell->root[c];
        for (int c = 0; c < 3 && part; c++) {
            sums[i + (4 + c) * n] += v * cell->own[c];
            sums[i + (7 + c) * n] += v * cell->all[c];
        }
    }
}

/* Fills a row of n pixels from its corners, `side` pixels apart. */
GP_CLONES static void fill_between(const float *corner, int side, int n,
                                   float *restrict row)
{
    const float step = 1.0f / (float) side;
    for (int x = 0; x < n; x += side, corner++) {
        const float slope = (corner[1] - corner[0]) * step;
        const int end = gp_min(side, n - x);
        for (int k = 0; k < end; k++)
            row[x + k] = corner[0] + slope * (float) k;
    }
}

static void see_row(void *ctx, int row, int thread)
{
    const struct seeing *const a = ctx;
    struct gp_beyond *const b = a->b;
    const int n = a->corners;
    float *const sums = a->sums + (size_t) thread * 10 * (size_t) n;
    memset(sums, 0, 10 * (size_t) n * sizeof *sums);
    for (int i = 0; i < a->cells; i++)
        add_cell(&a->cell[i], (float) (row * b->side), a->part, b->side, n,
                 sums);
    for (int c = 0; c < 3; c++) {
        float *const out = sums + (1 + c) * n;
        const float *const own = sums + (4 + c) * n, *const all = own + 3 * n;
        for (int i = 0; i < n; i++) {
            const float r = out[i] / sums[i];
            const float part = all[i] > 0.0f ? own[i] / all[i] : 0.0f;
            out[i] = r * r * r * (a->part ? part : 1.0f);
        }
        fill_between(out, b->side, b->w, gp_row(b->b.c[c], b->w, row));
    }
}

gp_status gp_beyond_find(const struct gp_log *log, const struct gp_surround *edges,
                         struct gp_beyond **out)
{
    const struct gp_sources *const s = edges->picture;
    const struct gp_sources *const own = edges->own ? edges->own : s;
    struct gp_beyond *b = NULL;
    float *sums = NULL;
    gp_status st = GP_OK;
    bool lit = false;
    *out = NULL;
    if (edges->how == GLAREPP_BLACK || !s || !s->n || !own->n)
        return GP_OK;
    const int side = (gp_max(s->w, s->h) + GP_EDGE_CELLS - 1) / GP_EDGE_CELLS;
    struct border border = {
        .picture = s, .own = own, .side = side, .depth = (side + 7) / 8,
        .across = (s->w + side - 1) / side, .down = (s->h + side - 1) / side,
    };
    const int cells = 2 * (border.across + border.down);
    GP_TRY(gp_alloc(log, "edges", (size_t) cells, sizeof *border.cell,
                    &border.cell));
    for (int i = 0; i < cells; i++)
        find_cell(&border, i);
    GP_TRY(take_lamps_out(log, s->luminance, &border));
    for (int i = 0; i < cells; i++)
        lit = lit || border.cell[i].root[0] > 0.0f ||
              border.cell[i].root[1] > 0.0f || border.cell[i].root[2] > 0.0f;
    if (!lit)
        goto out;
    GP_TRY(gp_alloc_zero(log, "edges", 1, sizeof *b, &b));
    b->w = s->w;
    b->h = s->h;
    b->side = side;
    b->rows = (s->h - 1) / side + 2;
    const int corners = (s->w - 1) / side + 2;
    GP_TRY(
        gp_planes_make(log, "edges", (size_t) b->rows * (size_t) s->w, &b->b));
    GP_TRY(gp_alloc(log, "edges", (size_t) gp_threads() * 10 *
                    (size_t) corners, sizeof *sums, &sums));
    struct seeing seeing = {b, border.cell, cells, corners, own != s, sums};
    gp_parallel_do(b->rows, see_row, &seeing);
    for (int i = 0; i < 3 * b->rows; i++) {
        const float *const row = gp_row(b->b.c[i % 3], b->w, i / 3);
        float most = row[b->w - 1];
        for (int x = 0; x < b->w; x += side) // linear between corners
            most = gp_maxf(most, row[x]);
        b->most = fmax(b->most, (double) most);
    }
    *out = b;
    b = NULL;
out:
    gp_beyond_free(&b);
    gp_free(border.cell);
    gp_free(sums);
    return st;
}

// -- the share of the kernel that is outside ----------------------------------

/* Sums of a kernel's samples over boxes, channel after channel: gp_kernel_sums(). */
struct box_sums {
    const struct gp_kernel *k;
    int channels; // 1 of a kernel that is grey, its far field too
    size_t pitch;
    double *at;
};

/* The row of sums before row y of channel c. */
static double *box_row(const struct box_sums *s, int c, int y)
{
    return s->at + ((size_t) c * ((size_t) s->k->h + 1) + (size_t) y) * s->pitch;
}

static gp_status sum_boxes(const struct gp_log *log, const struct gp_kernel *k,
                           struct box_sums *s)
{
    *s = (struct box_sums) {
        .k = k, .channels = k->grey && (!k->far || k->far->grey) ? 1 : 3,
        .pitch = (size_t) k->w + 1,
    };
    gp_status st = gp_alloc(log, "edges", (size_t) s->channels *
                            (size_t) (k->h + 1) * s->pitch, sizeof *s->at, &s->at);
    for (int c = 0; !st && c < s->channels; c++)
        gp_kernel_sums(k, c, false, box_row(s, c, 0));
    return st;
}

/* The first row or column i of n of a kernel, centre c, that meets light at or
 * before place p: those of light in [0, end) are [kernel_from(p - end + 1),
 * kernel_from(p + 1)). */
static int kernel_from(long long p, int c, int n)
{
    return gp_clamp_wide(p + c, 0, n);
}

/* Facts of a kernel for pictures of one size, and what is added to which. */
struct gp_outside {
    const struct gp_beyond *b;
    struct gp_planes *layer;
    struct box_sums sums;
    struct gp_far_rows *far; // of light 1 everywhere; NULL: no far field
    struct gp_planes cosines; // w of direction cosines, w * h; or empty
    int w, h, threads;
    unsigned long serial;              // of the kernel
    const struct gp_far_state *state;  // what `far` is of
    double *box;   // pitch of the kernel for each thread
    float *weight; // three rows for each thread: w; the far field in the
                   // picture; what leaves it of the sky's
};

/* Fills weight[x] with w in row y, but for the far field's. */
GP_CLONES static void find_weights(const struct gp_kernel *k,
    const double *restrict low, const double *restrict high, double rest, int w,
    double *restrict box, float *restrict weight)
{
    for (int i = 0; i <= k->w; i++)
        box[i] = high[i] - low[i];
    const double all = box[k->w];
    const float base = (float) rest;
    for (int x = 0; x < w; x++)
        weight[x] = base;
    // samples right of x + cx have their light left of the picture
    const int left = gp_clamp_wide((long long) k->w - k->cx - 1, 0, w);
    for (int x = 0; x < left; x++)
        weight[x] += (float) (all - box[gp_max(x + k->cx + 1, 0)]);
    // those left of x + cx - w + 1 right of it
    const int right = gp_clamp_wide((long long) w - k->cx, 0, w);
    for (int x = right; x < w; x++)
        weight[x] += (float) box[gp_min(x + k->cx + 1 - w, k->w)];
}

/* Adds w b; b lies between those of two rows of corners. */
GP_CLONES static void add_light(float *restrict layer,
    const float *restrict weight, const float *restrict above,
    const float *restrict below, float down, int n)
{
    for (int x = 0; x < n; x++) {
        const float b = above[x] + down * (below[x] - above[x]);
        layer[x] = gp_maxf(gp_minf(layer[x] + weight[x] * b, FLT_MAX),
                           -FLT_MAX);
    }
}

/* The light that samples leave out of a kernel, which comes from outside: none of
 * the sky. */
static double rest_of(const struct gp_kernel *k)
{
    return k->sky ? 0.0 : k->left_out;
}

/* Fills weight with w in row y of channel c. */
GP_CLONES static void weigh_row(const struct gp_outside *o, int c, int y,
                                int thread, const float *restrict outside,
                                float *restrict weight)
{
    const struct gp_kernel *const k = o->sums.k;
    const int from = c % o->sums.channels, w = o->w;
    const double *const low = box_row(
        &o->sums, from, kernel_from((long long) y - o->h + 1, k->cy, k->h));
    const double *const high =
        box_row(&o->sums, from, kernel_from((long long) y + 1, k->cy, k->h));
    const double all = box_row(&o->sums, from, k->h)[k->w];
    float *const inside = weight + w;
    find_weights(k, low, high, rest_of(k) + (all - (high[k->w] - low[k->w])), w,
                 o->box + (size_t) thread * o->sums.pitch, weight);
    for (int x = 0; x < w && k->sky; x++)
        weight[x] += outside[x];
    for (int x = 0; x < w && o->cosines.c[0]; x++)
        weight[x] += gp_row(o->cosines.c[c], w, y)[x];
    if (o->far) {
        const float far = (float) k->far->sum[from];
        gp_far_row(o->far, from, y, thread, inside);
        for (int x = 0; x < w; x++)
            weight[x] += far - inside[x];
    }
}

void gp_beyond_add_row(void *ctx, int y, int thread)
{
    const struct gp_outside *const o = ctx;
    const struct gp_beyond *const b = o->b;
    const struct gp_sky *const sky = o->sums.k->sky;
    const bool alike = o->sums.channels == 1 && !o->cosines.c[0] &&
                       (!sky || gp_sky_channel(sky, 1) == sky);
    float *const weight = o->weight + (size_t) thread * 3 * (size_t) b->w;
    float *const outside = weight + 2 * b->w;
    for (int c = 0; c < 3; c++) {
        const float *const above = gp_row(b->b.c[c], b->w, y / b->side);
        if (sky && (c == 0 || !alike))
            gp_sky_outside_row(gp_sky_channel(sky, c), y, outside);
        if (c == 0 || !alike)
            weigh_row(o, c, y, thread, outside, weight);
        add_light(gp_row(o->layer->c[c], b->w, y), weight, above, above + b->w,
                  (float) (y % b->side) / (float) b->side, b->w);
    }
}

void gp_outside_free(struct gp_outside **outside)
{
    struct gp_outside *const o = *outside;
    if (o) {
        gp_far_rows_free(&o->far);
        gp_planes_free(&o->cosines);
        gp_free(o->sums.at);
        gp_free(o->box);
        gp_free(o->weight);
    }
    GP_FREE(*outside);
}

/* Makes w of a kernel's direction cosines; stays empty where it has none. */
static gp_status find_cosines(const struct gp_log *log,
                              const struct gp_kernel *k, int w, int h,
                              struct gp_planes *out)
{
    gp_status st;
    if (!k->sky || !gp_sky_facts(k->sky)->cosines)
        return GP_OK;
    st = gp_planes_make(log, "edges", (size_t) w * (size_t) h, out);
    return st ? st
              : gp_cosines_beyond(log, gp_sky_facts(k->sky)->cosines, w, h,
                                  out);
}

gp_status gp_outside_find(const struct gp_log *log, const struct gp_kernel *k,
    const struct gp_far_state *far, const struct gp_beyond *b,
    struct gp_planes *layer, struct gp_outside **outside)
{
    gp_status st;
    const int w = b->w, h = b->h;
    struct gp_outside *o = *outside;
    const size_t threads = (size_t) gp_threads(), wide = (size_t) w;
    if (o && k->serial && o->serial == k->serial && o->w == w && o->h == h &&
        o->threads == gp_threads() && o->state == far) {
        o->sums.k = k;
        o->b = b;
        o->layer = layer;
        return GP_OK;
    }
    gp_outside_free(outside);
    GP_TRY(gp_alloc_zero(log, "edges", 1, sizeof *o, &o));
    *o = (struct gp_outside) {.b = b, .layer = layer, .w = w, .h = h, .threads = gp_threads(),
                              .serial = k->serial, .state = far};
    GP_TRY(sum_boxes(log, k, &o->sums));
    GP_TRY(gp_alloc(log, "edges", threads * o->sums.pitch, sizeof *o->box,
                    &o->box));
    GP_TRY(gp_alloc(log, "edges", threads * 3 * wide, sizeof *o->weight,
                    &o->weight));
    if (k->far)
        GP_TRY(gp_far_find(log, k->far, far, NULL, w, h, NULL, &o->far));
    GP_TRY(find_cosines(log, k, w, h, &o->cosines));
    *outside = o;
    o = NULL;
out:
    gp_outside_free(&o);
    return st;
}

/* The share of the sky outside, for pixels that are not left out. */
struct outer {
    const struct gp_sky *sky;
    const double *layer;
    double *share;
    int w;
};

static void find_outer(void *ctx, int y, GP_UNUSED int thread)
{
    const struct outer *const o = ctx;
    const size_t row = (size_t) y * (size_t) o->w;
    for (int x = 0; x < o->w; x++)
        o->share[row + (size_t) x] = isnan(o->layer[row + (size_t) x])
                                         ? 0.0
                                         : gp_sky_outside(o->sky, x, y);
}

gp_status gp_beyond_add_exact(const struct gp_log *log,
    const struct gp_beyond *b, const struct gp_kernel *k, double *layer)
{
    struct box_sums sums;
    const double rest = rest_of(k);
    struct outer outer = {.layer = layer};
    struct gp_planes cosines = {0};
    gp_status st = b ? sum_boxes(log, k, &sums) : GP_OK;
    if (!b || st)
        return st;
    outer.w = b->w;
    GP_TRY(gp_alloc_zero(log, "edges", (size_t) b->w * (size_t) b->h,
                         sizeof *outer.share, &outer.share));
    GP_TRY(find_cosines(log, k, b->w, b->h, &cosines));
    for (int i = 0; i < 3 * b->h; i++) {
        const int c = i / b->h, y = i % b->h, from = c % sums.channels;
        if (k->sky && outer.sky != gp_sky_channel(k->sky, c)) {
            outer.sky = gp_sky_channel(k->sky, c);
            gp_parallel_do(b->h, find_outer, &outer);
        }
        const int y0 = kernel_from((long long) y - b->h + 1, k->cy, k->h);
        const int y1 = kernel_from((long long) y + 1, k->cy, k->h);
        const float down = (float) (y % b->side) / (float) b->side;
        const double *const low = box_row(&sums, from, y0);
        const double *const high = box_row(&sums, from, y1);
        const double all = box_row(&sums, from, k->h)[k->w];
        const float *const above = gp_row(b->b.c[c], b->w, y / b->side);
        double *const out = layer + (size_t) i * (size_t) b->w;
        for (int x = 0; x < b->w; x++) {
            const int x0 = kernel_from((long long) x - b->w + 1, k->cx, k->w);
            const int x1 = kernel_from((long long) x + 1, k->cx, k->w);
            const double inside = high[x1] - high[x0] - low[x1] + low[x0];
            const float light = above[x] + down * (above[x + b->w] - above[x]);
            const size_t at = (size_t) y * (size_t) b->w + (size_t) x;
            const double sky = outer.share[at] +
                               (cosines.c[0] ? (double) cosines.c[c][at] : 0.0);
            out[x] += (rest + all - inside + sky) * (double) light;
        }
    }
out:
    gp_planes_free(&cosines);
    gp_free(outer.share);
    gp_free(sums.at);
    return st;
}
