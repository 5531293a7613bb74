// SPDX-License-Identifier: Apache-2.0
/* The layer of sources: light up the levels, spread on each, and down again. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sphere.h"
#include "glare/sky/sum.h"

#include <string.h>

enum {
    BAND = GP_SKY_BAND,
    REACH = 6, // nodes that dividing splines meets on either side
};

struct adding {
    const struct gp_sky *sky;
    const struct gp_sky_drawing *d;
    struct gp_sky_grid light[GP_SKY_LEVELS]; // of levels from 1 on: moments
    struct gp_planes out[GP_SKY_LEVELS];     // what is spread there
    struct gp_planes node[GP_SKY_LEVELS];    // splines of it and farther levels
    struct gp_sky_index index;
    float *scratch; // `room` of each thread
    size_t room;
    int level; // that tasks work on
};

// -- rows ---------------------------------------------------------------------

GP_CLONES static float dot_row(const float *restrict a, const float *restrict b,
                               int n)
{
    enum { LANES = 8 };
    float sum[LANES] = {0}, total = 0.0f; // become vectors
    int i = 0;
    for (; i + LANES <= n; i += LANES) {
        for (int k = 0; k < LANES; k++)
            sum[k] += a[i + k] * b[i + k];
    }
    for (int k = 0; k < LANES; k++)
        total += sum[k];
    for (; i < n; i++)
        total += a[i] * b[i];
    return total;
}

/* to += the sum of at[k] from[k] over `count` rows, n of each. */
static void add_rows(const float *const *from, const float *at, int count,
                     int n, float *to)
{
    for (int first = 0; first < count; first += 4) {
        const float *four[4];
        float by[4] = {0.0f};
        for (int k = 0; k < 4; k++) {
            four[k] = from[gp_min(first + k, count - 1)];
            by[k] = first + k < count ? at[first + k] : 0.0f;
        }
        gp_sky_add_four(four, by, (size_t) n, to);
    }
}

static void sum_rows(const float *const *from, const float *at, int count,
                     int n, float *to)
{
    memset(to, 0, (size_t) n * sizeof *to);
    add_rows(from, at, count, n, to);
}

static inline __attribute__((always_inline)) float
between(const float at[GP_SKY_TAPS], const float *node)
{
    return at[0] * node[0] + at[1] * node[1] + at[2] * node[2] +
           at[3] * node[3];
}

/* Adds n values between nodes: of those from i on, by `even` to row[2 i] and by `odd` to
 * row[2 i + 1]. */
GP_CLONES static void between_row(const float *restrict node, const float *even,
                                  const float *odd, int n, float *restrict row)
{
    for (int i = 0; i < n / 2; i++) {
        row[2 * i] += between(even, node + i);
        row[2 * i + 1] += between(odd, node + i);
    }
    if (n % 2)
        row[n - 1] += between(even, node + n / 2);
}

/* out[i] = the sum of at[|k|] line[i + k], |k| <= REACH: n of them. */
GP_CLONES static void divide_row(const float *restrict line,
                                 const float at[REACH + 1], int n,
                                 float *restrict out)
{
    for (int i = 0; i < n; i++) {
        float v = at[0] * line[i];
        for (int k = 1; k <= REACH; k++)
            v += at[k] * (line[i - k] + line[i + k]);
        out[i] = v;
    }
}

// -- up -----------------------------------------------------------------------

/* B of the nodes around an even and an odd pixel of level 0 on level 1. */
static const float B1[2][GP_SKY_TAPS] = {
    {1.0f / 6, 4.0f / 6, 1.0f / 6},
    {1.0f / 48, 23.0f / 48, 23.0f / 48, 1.0f / 48},
};

/* Adds the light of the few sources of row y, times their solid angles, to the nodes of
 * a line, channel after channel. */
static void gather_few(const struct adding *a, int y, float *line)
{
    const struct gp_sources *const src = a->d->src;
    const size_t pitch = a->light[1].pitch;
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
        const int x = src->x[i];
        const float omega =
            (float) gp_projection_solid(&a->sky->p.projection, x, y);
        for (int c = a->sky->from; c < a->sky->to; c++) {
            const float v = omega * src->rgb[c][i];
            float *const node = line + (size_t) c * pitch + (size_t) (x >> 1);
            for (int k = 0; k < GP_SKY_TAPS; k++)
                node[k] += v * B1[x & 1][k];
        }
    }
}

/* Adds even pixels e and odd ones o, which is the one right of e, to n nodes. */
GP_CLONES static void gather_row(const float *restrict e,
                                 const float *restrict o, int n,
                                 float *restrict node)
{
    for (int m = 0; m < n; m++)
        node[m] += (e[m] + e[m - 2]) * (1.0f / 6.0f) +
                   e[m - 1] * (4.0f / 6.0f) +
                   (o[m] + o[m - 3]) * (1.0f / 48.0f) +
                   (o[m - 1] + o[m - 2]) * (23.0f / 48.0f);
}

/* Lays light times solid angles out in black rows, one of even pixels, one of odd. */
GP_CLONES static void lay_apart(const struct adding *a, int y,
                                const float *restrict rgb,
                                const float *restrict solid,
                                float *restrict even, float *restrict odd)
{
    const int32_t *const x = a->d->src->x;
    const uint32_t *const at = gp_sky_index_row(&a->index, y);
    for (int b = 0; b < a->index.blocks; b++) {
        const float *const by = solid + b * GP_SKY_BLOCK, *const v =
                                                              rgb + at[b];
        const size_t first = (size_t) b * GP_SKY_BLOCK / 2;
        if (at[b + 1] - at[b] == GP_SKY_BLOCK) { // all of its pixels
            for (size_t k = 0; k < GP_SKY_BLOCK / 2; k++) {
                even[first + k] = by[2 * k] * v[2 * k];
                odd[first + k] = by[2 * k + 1] * v[2 * k + 1];
            }
            continue;
        }
        for (uint32_t i = at[b]; i < at[b + 1]; i++)
            (x[i] & 1 ? odd : even)[x[i] / 2] = solid[x[i]] * rgb[i];
    }
}

/* The same of many, which are laid out first: a tenth less for the layer of a bright
 * sky. */
static void gather_many(const struct adding *a, int y, float *line,
                        float *scratch)
{
    enum { BEFORE = 3 };
    const struct gp_sources *const src = a->d->src;
    const size_t half = gp_sky_row_room(src->w / 2 + 2 * BEFORE);
    float *const solid = scratch + 2 * half, *const even = scratch + BEFORE;
    gp_projection_solid_row(&a->sky->p.projection, 0.0, y, src->w, solid);
    for (int c = a->sky->from; c < a->sky->to; c++) {
        memset(scratch, 0, 2 * half * sizeof *scratch);
        lay_apart(a, y, src->rgb[c], solid, even, even + half);
        gather_row(even, even + half, (src->w + 1) / 2 + BEFORE,
                   line + (size_t) c * a->light[1].pitch);
    }
}

/* BAND rows of nodes of level 1. */
static void gather_band(void *ctx, int band, int thread)
{
    enum { FEW = 64, ROWS = GP_SKY_ROWS };
    const struct adding *const a = ctx;
    const struct gp_sources *const src = a->d->src;
    const struct gp_sky_grid *const to = &a->light[1];
    const size_t row = 3 * to->pitch;
    float *const lines = a->scratch + (size_t) thread * a->room;
    const int from = band * BAND, end = gp_min(from + BAND, to->h);
    // node row g lies on pixel row 2 (g - 1), and meets three on each side
    for (int y = gp_max(2 * from - 6, 0); y < gp_min(2 * end + 2, src->h);
         y += ROWS) {
        const int n = gp_min(ROWS, src->h - y);
        if (src->row[y + n] == src->row[y])
            continue;
        memset(lines, 0, ROWS * row * sizeof *lines);
        for (int r = 0; r < n; r++) {
            if (src->row[y + r + 1] - src->row[y + r] > FEW)
                gather_many(a, y + r, lines + (size_t) r * row,
                            lines + ROWS * row);
            else
                gather_few(a, y + r, lines + (size_t) r * row);
        }
        for (int g = gp_max(y / 2, from);
             g < gp_min(y / 2 + GP_SKY_TAPS + ROWS / 2 - 1, end); g++) {
            float at[ROWS] = {0.0f};
            for (int r = 0; r < ROWS; r++) {
                const int k = g - (y + r) / 2;
                if (k >= 0 && k < GP_SKY_TAPS)
                    at[r] = B1[r & 1][k];
            }
            for (int c = a->sky->from; c < a->sky->to; c++) {
                const float *const v = lines + (size_t) c * to->pitch;
                const float *const line[ROWS] = {v, v + row, v + 2 * row,
                                                 v + 3 * row};
                gp_sky_add_four(line, at, (size_t) to->w,
                                gp_sky_grid_row(to, c, g));
            }
        }
    }
}

/* Row i % h of channel i / h of a level from 2 on: 1, 4, 6, 4, 1 of 8 nodes of the
 * one before it, along and down. */
static void halve_row(void *ctx, int i, int thread)
{
    static const float B[5] = {0.125f, 0.5f, 0.75f, 0.5f, 0.125f};
    const struct adding *const a = ctx;
    const struct gp_sky_grid *const to = &a->light[a->level];
    const struct gp_sky_grid *const from = &a->light[a->level - 1];
    const int c = a->sky->from + i / to->h, g = i % to->h;
    float *const out = gp_sky_grid_row(to, c, g);
    float *const line = a->scratch + (size_t) thread * a->room + 4;
    // nodes before and after those of `from` are black
    memset(line - 4, 0, ((size_t) from->w + 16) * sizeof *line);
    const int first = gp_max(2 * g - 3, 0);
    const int n = gp_min(2 * g + 2, from->h) - first;
    const float *row[5];
    for (int k = 0; k < n; k++)
        row[k] = gp_sky_grid_row(from, c, first + k);
    add_rows(row, B + (first - (2 * g - 3)), n, from->w, line);
    for (int x = 0; x < to->w; x++) {
        const float *const at = line + 2 * x - 3;
        out[x] = B[0] * (at[0] + at[4]) + B[1] * (at[1] + at[3]) + B[2] * at[2];
    }
}

// -- spread -------------------------------------------------------------------

/* A group of rows of a level. */
static void spread_rows(void *ctx, int group, int thread)
{
    const struct adding *const a = ctx;
    gp_sky_spread(a->sky, a->level, &a->light[a->level], group,
                  a->out[a->level].c, a->scratch + (size_t) thread * a->room);
}

/* Node i of the last level. */
static void spread_last(void *ctx, int i, GP_UNUSED int thread)
{
    const struct adding *const a = ctx;
    const int l = a->sky->levels - 1, n = a->sky->level[l].w;
    const float *const w =
        a->sky->pairs + (size_t) i * (size_t) n * (size_t) a->sky->level[l].h;
    for (int c = a->sky->from; c < a->sky->to; c++) {
        float sum = 0.0f;
        for (int y = 0; y < a->sky->level[l].h; y++)
            sum += dot_row(w + (size_t) y * (size_t) n,
                           gp_sky_grid_row(&a->light[l], c, y), n);
        a->out[l].c[c][i] = sum;
    }
}

// -- down ---------------------------------------------------------------------

/* Weights by which the samples 1/6, 4/6, 1/6 of the cubic B-spline are divided out of
 * what a level spreads, sqrt 3 (sqrt 3 - 2)^|k|, so that its splines meet it at the
 * nodes. Of the light weights have done so. Nodes beyond either end continue the
 * parabola of the last three: `to` has the weights of n nodes around node i. */
static void divide_weights(int i, int n, float to[2 * REACH + 1 + 6],
                           int *first)
{
    static const double Z = -0.26794919243112270647;
    double w[2 * REACH + 1 + 6] = {0}, all = 0.0, z = 1.0;
    const int from = gp_max(gp_min(i - REACH, n - 3), 0);
    for (int k = 0; k <= REACH; k++, z *= Z)
        all += k ? 2.0 * z : z;
    z = 1.0;
    for (int k = 0; k <= REACH; k++, z *= Z) {
        for (int side = -1; side <= (k ? 1 : 0); side += 2) {
            const int at = i + side * k;
            const double by = z / all;
            const int end = at < 0 ? 0 : n - 1, in = at < 0 ? 1 : -1;
            const double d = at < 0 ? -at : at - (n - 1);
            if (d <= 0.0 || n < 3) {
                w[gp_min(gp_max(at, 0), n - 1) - from] += by;
                continue;
            }
            w[end - from] += by * (1.0 + d * (d + 3.0) / 2.0);
            w[end + in - from] -= by * d * (d + 2.0);
            w[end + 2 * in - from] += by * d * (d + 1.0) / 2.0;
        }
    }
    for (int k = 0; k < 2 * REACH + 1 + 6; k++)
        to[k] = (float) w[k];
    *first = from;
}

/* Continues a line of n nodes by REACH on both sides. */
static void continue_line(float *line, int n)
{
    for (int side = 0; side < 2; side++) {
        const int in = side ? -1 : 1;
        float *const end = line + (side ? n - 1 : 0);
        const float a = end[0], b = n > 2 ? end[in] : a;
        const float c = n > 2 ? end[2 * in] : a;
        for (int k = 1; k <= REACH; k++) {
            const float d = (float) k;
            end[-in * k] = a * (1.0f + d * (d + 3.0f) * 0.5f) -
                           b * d * (d + 2.0f) + c * d * (d + 1.0f) * 0.5f;
        }
    }
}

/* Adds to a row of a level, of channel c, the nodes of the next. */
static void double_row(const struct adding *a, int c, int f, float *line,
                       float *out)
{
    // fine node f lies on the coarse node (f + 1) / 2, or between two
    static const float EVEN[4] = {0.5f, 0.5f}, ODD[4] = {0.125f, 0.75f, 0.125f};
    const struct gp_sky_level *const to = &a->sky->level[a->level];
    const int w = a->sky->level[a->level + 1].w;
    const int n = f & 1 ? 3 : 2;
    const float *from[3];
    for (int k = 0; k < n; k++)
        from[k] =
            a->node[a->level + 1].c[c] + (size_t) (f / 2 + k) * (size_t) w;
    sum_rows(from, f & 1 ? ODD : EVEN, n, w, line);
    memset(line + w, 0, 4 * sizeof *line);
    between_row(line, EVEN, ODD, to->w, out);
}

/* Spreads a row of a level that has one weight a node. */
GP_CLONES static void weigh_row(const struct gp_sky *s,
                                const struct gp_sky_level *g, int y,
                                const float *restrict light,
                                float *restrict out)
{
    double cubic[4];
    const double t = gp_sky_place_of(s, 1, (y - 1) * g->step);
    const float *const line =
        g->line +
        (size_t) gp_sky_cubic(t, s->places.n[1], cubic) * (size_t) g->w;
    const float *const row[4] = {line, line + g->w, line + 2 * g->w,
                                 line + 3 * g->w};
    const float at[4] = {(float) cubic[0], (float) cubic[1], (float) cubic[2],
                         (float) cubic[3]};
    for (int x = 0; x < g->w; x++)
        out[x] = light[x] * (at[0] * row[0][x] + at[1] * row[1][x] +
                             at[2] * row[2][x] + at[3] * row[3][x]);
}

/* Row i % h of channel i / h of a level: splines of what is spread on it and on all
 * farther ones. */
static void find_row(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_level *const g = &a->sky->level[a->level];
    const int c = a->sky->from + i / g->h, y = i % g->h;
    const size_t w = (size_t) g->w;
    float *const line = a->scratch + (size_t) thread * a->room + REACH;
    float *const out = a->node[a->level].c[c] + (size_t) y * w;
    float at[2 * REACH + 1 + 6], along[2 * REACH + 1 + 6];
    const float *from[2 * REACH + 1 + 6];
    int first, middle, n = 0;
    if (a->sky->single && a->level < a->sky->levels - 1) {
        weigh_row(a->sky, g, y, gp_sky_grid_row(&a->light[a->level], c, y),
                  out);
        double_row(a, c, y, line, out);
        return;
    }
    divide_weights(y, g->h, at, &first);
    divide_weights(4 * REACH, 8 * REACH + 1, along, &middle);
    for (; n < 2 * REACH + 1 + 6 && first + n < g->h; n++)
        from[n] = a->out[a->level].c[c] + (size_t) (first + n) * w;
    while (n > 1 && at[n - 1] == 0.0f)
        n--;
    sum_rows(from, at, n, g->w, line);
    continue_line(line, g->w);
    divide_row(line, along + REACH, g->w, out);
    if (a->level < a->sky->levels - 1)
        double_row(a, c, y, line, out);
}

/* Writes a row of the layer, or adds to it; light is never negative. */
GP_CLONES static void write_row(const float *restrict from, int n, bool add,
                                float *restrict to)
{
    for (int x = 0; x < n; x++) {
        const float v = gp_maxf(from[x], 0.0f);
        to[x] = add ? to[x] + v : v;
    }
}

/* Adds what stays in the pixels of row y. */
GP_CLONES static void stay_row(const struct adding *a, int y, float *own,
                               float *restrict rows, size_t apart)
{
    const struct gp_sources *const src = a->d->src;
    const uint32_t first = src->row[y], end = src->row[y + 1];
    gp_sky_own(a->sky, src->w, src->h, y, src->x + first, end - first, own);
    for (uint32_t i = first, n; i < end; i += n) {
        const bool all =
            end - i >= GP_SKY_BLOCK && // pixels side by side
            src->x[i + GP_SKY_BLOCK - 1] == src->x[i] + GP_SKY_BLOCK - 1;
        n = all ? GP_SKY_BLOCK : 1;
        for (int c = a->sky->from; c < a->sky->to; c++) {
            float *const to = rows + (size_t) c * apart + (size_t) src->x[i];
            const float *const v = src->rgb[c] + i, *const by =
                                                        own + (i - first);
            const float more = a->d->more[c];
            if (all)
                for (int k = 0; k < GP_SKY_BLOCK; k++)
                    to[k] += (by[k] + more) * v[k];
            else
                to[0] += (by[0] + more) * v[0];
        }
    }
}

void gp_sky_cut_row(const struct gp_sky *s, int y, int w, float *row)
{
    int span[2];
    if (w != s->p.w)
        return;
    gp_projection_span(&s->p.projection, 0.0, y, s->p.w, span);
    memset(row, 0, (size_t) span[0] * sizeof *row);
    memset(row + span[1], 0, (size_t) (s->p.w - span[1]) * sizeof *row);
}

/* A band of pixels. */
static void finish_band(void *ctx, int band, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_drawing *const d = a->d;
    const int w = d->src->w, h = d->src->h, first = band * BAND;
    const size_t wide = gp_sky_row_room(w), nodes = (size_t) a->sky->level[1].w;
    float *const rows =
        a->scratch + (size_t) thread * a->room; // [row][c][wide]
    float *const line = rows + 3 * BAND * wide;
    const int n = gp_min(BAND, h - first);
    gp_sky_near(a->sky, &a->index, first, n, rows, line);
    for (int r = 0; r < n; r++) {
        const int y = first + r;
        float *const row = rows + (size_t) r * 3 * wide;
        stay_row(a, y, line, row, wide);
        for (int c = a->sky->from; c < a->sky->to; c++) {
            const float *from[GP_SKY_TAPS];
            for (int k = 0; k < GP_SKY_TAPS; k++)
                from[k] = a->node[1].c[c] + (size_t) ((y >> 1) + k) * nodes;
            sum_rows(from, B1[y & 1], GP_SKY_TAPS, (int) nodes, line);
            between_row(line, B1[0], B1[1], w, row + (size_t) c * wide);
            float *const to = d->layer->c[c] + (size_t) y * (size_t) w;
            write_row(row + (size_t) c * wide, w, d->add, to);
            gp_sky_cut_row(a->sky, y, w, to);
        }
    }
}

// -- all of it ----------------------------------------------------------------

static gp_status alloc_levels(const struct gp_log *log, struct adding *a)
{
    gp_status st = GP_OK;
    for (int l = 1; l < a->sky->levels; l++) {
        const struct gp_sky_level *const g = &a->sky->level[l];
        const size_t n = (size_t) g->w * (size_t) g->h;
        GP_TRY(gp_sky_grid_make(log, g, &a->light[l]));
        GP_TRY(gp_planes_make(log, "layer", n, &a->out[l]));
        GP_TRY(gp_planes_make(log, "layer", n, &a->node[l]));
    }
    a->room = gp_sky_room(a->sky);
    st = gp_alloc(log, "layer", a->room * (size_t) gp_threads(), sizeof(float),
                  &a->scratch);
out:
    return st;
}

/* Takes the sources that are within a fisheye's rim. */
static gp_status take_within(const struct gp_log *log,
                             const struct gp_projection *p,
                             const struct gp_sources *src,
                             struct gp_sources *out)
{
    gp_status st = gp_sources_make(log, src, src->n, out);
    for (int y = 0; y < src->h && !st; y++) {
        int span[2];
        gp_projection_span(p, 0.0, y, src->w, span);
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            if (src->x[i] >= span[0] && src->x[i] < span[1])
                gp_sources_copy(src, i, 1.0, src->x[i], y, out);
        }
    }
    if (!st)
        gp_sources_finish(out);
    return st;
}

/* Adds direction cosines' light; `more` of a source stays in its pixel. */
static gp_status add_cosines(const struct gp_log *log, const struct gp_sky *sky,
                             const struct gp_sky_drawing *d)
{
    const struct gp_sources *const src = d->src;
    const size_t w = (size_t) src->w;
    struct gp_source *list = NULL;
    gp_status st;
    if (!d->add)
        gp_planes_clear(d->layer, 0, w * (size_t) src->h);
    GP_TRY(gp_sources_list(log, src, &list));
    for (size_t i = 0; i < src->n && !d->add; i++) {
        const size_t at = (size_t) list[i].y * w + (size_t) list[i].x;
        for (int c = 0; c < 3; c++)
            d->layer->c[c][at] = d->more[c] * list[i].rgb[c];
    }
    st = gp_cosines_add(log, sky->p.cosines, list, src->n,
                        (struct gp_rect) {0, 0, src->w, src->h}, d->layer,
                        d->last, d->kept);
out:
    gp_free(list);
    return st;
}

/* Adds light by levels. */
static gp_status add_levels(const struct gp_log *log, const struct gp_sky *sky,
                            const struct gp_sky_drawing *d)
{
    struct gp_sources within = {0};
    struct gp_sky_drawing own = *d;
    struct adding a = {.sky = sky, .d = &own};
    const int last = sky->levels - 1, channels = sky->to - sky->from;
    gp_status st;
    if (sky->p.projection.rim > 0.0) {
        GP_TRY(take_within(log, &sky->p.projection, d->src, &within));
        own.src = &within;
    }
    GP_TRY(alloc_levels(log, &a));
    GP_TRY(gp_sky_index_make(log, own.src, &a.index));
    gp_parallel_do((a.light[1].h + BAND - 1) / BAND, gather_band, &a);
    for (a.level = 2; a.level <= last; a.level++)
        gp_parallel_do(channels * a.light[a.level].h, halve_row, &a);
    gp_parallel_do(sky->level[last].w * sky->level[last].h, spread_last, &a);
    for (a.level = last; a.level >= 1; a.level--) {
        const struct gp_sky_level *const g = &sky->level[a.level];
        if (a.level < last && !sky->single)
            gp_parallel_do((g->h + g->rows - 1) / g->rows, spread_rows, &a);
        gp_parallel_do(channels * g->h, find_row, &a);
    }
    gp_parallel_do((d->src->h + BAND - 1) / BAND, finish_band, &a);
out:
    gp_sources_free(&within);
    for (int l = 1; l < sky->levels; l++) {
        gp_sky_grid_free(&a.light[l]);
        gp_planes_free(&a.out[l]);
        gp_planes_free(&a.node[l]);
    }
    gp_free(a.index.at);
    gp_free(a.scratch);
    return st;
}

gp_status gp_sky_add(const struct gp_log *log, const struct gp_sky *sky,
                     const struct gp_sky_drawing *d)
{
    struct gp_sky_drawing own = *d;
    gp_status st = GP_OK;
    if (sky->p.cosines) {
        st = add_cosines(log, sky, d);
        own.add = true;
        memset(own.more, 0, sizeof own.more);
    }
    for (; sky && sky->p.n && !st; sky = sky->next)
        st = (sky->sphere ? gp_sky_sphere_add : add_levels)(log, sky, &own);
    return st;
}
