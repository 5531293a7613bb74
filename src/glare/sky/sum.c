// SPDX-License-Identifier: Apache-2.0
#include "glare/sky/sum.h"

#include "core/bytes.h"
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    LANES = 8,
    BLOCK = GP_SKY_BLOCK,
    ROWS = GP_SKY_ROWS,
    PAD = GP_SKY_PAD,
};

typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef float loose
    __attribute__((vector_size(4 * LANES), aligned(4), may_alias));
typedef float wide __attribute__((vector_size(4 * BLOCK)));
typedef float loose_wide
    __attribute__((vector_size(4 * BLOCK), aligned(4), may_alias));

// -- light --------------------------------------------------------------------

gp_status gp_sky_grid_make(const struct gp_log *log,
                           const struct gp_sky_level *g,
                           struct gp_sky_grid *out)
{
    struct gp_sky_grid t = {
        .w = g->w, .h = g->h, .rx = g->rx + LANES, .ry = g->ry};
    t.pitch = gp_sky_row_room(g->w + 2 * t.rx);
    const size_t rows = (size_t) t.h + 2 * (size_t) t.ry + ROWS;
    t.before = (size_t) t.ry * t.pitch + (size_t) t.rx;
    gp_status st =
        gp_alloc_zero(log, "layer", 3 * rows * t.pitch, sizeof(float), &t.v[0]);
    if (st)
        return st;
    t.v[0] += t.before;
    for (int c = 1; c < 3; c++)
        t.v[c] = t.v[c - 1] + rows * t.pitch;
    *out = t;
    return GP_OK;
}

void gp_sky_grid_free(struct gp_sky_grid *g)
{
    if (g->v[0])
        gp_free(g->v[0] - g->before);
    *g = (struct gp_sky_grid) {0};
}

GP_CLONES void gp_sky_add_scaled(float *restrict to, const float *restrict from,
                                 float by, int n)
{
    for (int i = 0; i < n; i++)
        to[i] += by * from[i];
}

GP_CLONES float gp_sky_dot(const float *a, const float *b, int n)
{
    lanes sum = {0};
    int i = 0;
    for (; i + LANES <= n; i += LANES)
        sum += *(const loose *) (a + i) * *(const loose *) (b + i);
    float total = 0.0f;
    for (int k = 0; k < LANES; k++)
        total += sum[k];
    for (; i < n; i++)
        total += a[i] * b[i];
    return total;
}

// -- weights of a block -------------------------------------------------------

static size_t pitch_of(const struct gp_sky_level *g)
{
    return g->pitch + 2 * PAD;
}

size_t gp_sky_weights_room(const struct gp_sky *s, const struct gp_sky_level *g)
{
    const size_t columns = (size_t) s->places.n[0];
    const size_t rows = 2 * (size_t) g->ry + 1;
    return columns * g->size + 2 * rows * pitch_of(g) + columns + 2 * rows +
           4 * BLOCK;
}

/* Opens weights for the rows [first, first + n) of a level, in scratch; returns
 * what is left of that. */
float *gp_sky_weights_open(const struct gp_sky *s, int l, int first, int n,
                           float *scratch, struct gp_sky_weights *w)
{
    const struct gp_sky_level *const g = &s->level[l];
    const size_t columns = (size_t) s->places.n[0];
    const size_t rows = 2 * (size_t) g->ry + 1;
    const double before = l ? -g->step : 0.0;
    double slope, at[4], t;
    *w = (struct gp_sky_weights) {.s = s,
                                  .g = g,
                                  .pitch = pitch_of(g),
                                  .spans = -1,
                                  .column = -1,
                                  .by_wide = gp_cpu_wide()};
    t = gp_sky_place_of(s, 1, before + (first + 0.5 * (n - 1)) * g->step,
                        &slope);
    w->place = gp_sky_cubic(t, s->places.n[1], at);
    for (int k = 0; k < 4; k++)
        w->at[k] = (float) at[k];
    for (int r = 0; r < n; r++) {
        t = gp_sky_place_of(s, 1, before + (first + r) * g->step, &slope);
        // by the same four, beyond which a group is but little
        (void) gp_sky_cubic(t - w->place, 4, w->row[r]);
    }
    w->places = scratch;
    w->value = w->places + columns * g->size;
    w->slope = w->value + rows * w->pitch;
    memset(w->value, 0, 2 * rows * w->pitch * sizeof *w->value);
    w->known = (bool *) (void *) (w->slope + rows * w->pitch);
    memset(w->known, 0, columns);
    w->span = (short *) (void *) (w->slope + rows * w->pitch + columns);
    w->laid = w->span + 2 * rows;
    memset(w->laid, 0, 2 * rows * sizeof *w->laid);
    return w->slope + rows * w->pitch + columns + 2 * rows + BLOCK;
}

/* The sum of four times weights. */
GP_CLONES_WIDE static void add_four(const float *const from[4],
                                    const float at[4], size_t n,
                                    float *restrict to)
{
    for (size_t i = 0; i < n; i++)
        to[i] = at[0] * from[0][i] + at[1] * from[1][i] + at[2] * from[2][i] +
                at[3] * from[3][i];
}

/* The same to the weights of a block, as far as they are laid. `next`: the sum is the
 * next block's, and what this one's slope leads to becomes its value. */
GP_CLONES static void add_rows(const struct gp_sky_weights *w,
                               const float *const from[4], const float at[4],
                               bool next)
{
    const struct gp_sky_level *const g = w->g;
    const float block = (float) g->block, step = 1.0f / block;
    for (int j = 0; j <= 2 * g->ry; j++) {
        const size_t row = (size_t) j * g->pitch;
        float *const value = w->value + PAD + (size_t) j * w->pitch;
        float *const slope = w->slope + PAD + (size_t) j * w->pitch;
        for (int i = w->laid[2 * j] / LANES * LANES; i < w->laid[2 * j + 1];
             i += LANES) {
            const lanes v = at[0] * *(const loose *) (from[0] + row + i) +
                            at[1] * *(const loose *) (from[1] + row + i) +
                            at[2] * *(const loose *) (from[2] + row + i) +
                            at[3] * *(const loose *) (from[3] + row + i);
            loose *const here = (loose *) (value + i);
            loose *const by = (loose *) (slope + i);
            if (next) {
                *here += block * *by;
                *by = (v - *here) * step;
            } else {
                *here = v;
            }
        }
    }
}

static void find_places(struct gp_sky_weights *w, int i)
{
    const struct gp_sky_level *const g = w->g;
    const float *from[4];
    for (int k = 0; k < 4; k++)
        from[k] =
            g->weight + ((size_t) (w->place + k) * (size_t) w->s->places.n[0] +
                         (size_t) i) *
                            g->size;
    add_four(from, w->at, g->size, w->places + (size_t) i * g->size);
    w->known[i] = true;
}

/* Finds the spans of a block: what any of its places has. */
static void find_spans(struct gp_sky_weights *w, int place)
{
    const struct gp_sky_level *const g = w->g;
    const int rows = 2 * g->ry + 1;
    for (int j = 0; j < rows; j++) {
        w->span[2 * j] = (short) (2 * g->rx + 1);
        w->span[2 * j + 1] = 0;
    }
    // five columns: a block may end among the next four
    for (int k = 0; k < 20; k++) {
        const int column = gp_min(place + k % 5, w->s->places.n[0] - 1);
        const short *const span =
            g->span +
            2 * (size_t) rows *
                ((size_t) (w->place + k / 5) * (size_t) w->s->places.n[0] +
                 (size_t) column);
        for (int j = 0; j < rows; j++) {
            if (span[2 * j] >= span[2 * j + 1])
                continue;
            if (span[2 * j] < w->span[2 * j])
                w->span[2 * j] = span[2 * j];
            if (span[2 * j + 1] > w->span[2 * j + 1])
                w->span[2 * j + 1] = span[2 * j + 1];
        }
    }
    w->spans = place;
}

/* Points at the four columns of places around a column of the level. */
static void point_at(struct gp_sky_weights *w, const struct gp_sky_column *b,
                     const float *from[4])
{
    for (int k = 0; k < 4; k++) {
        if (!w->known[b->place + k])
            find_places(w, b->place + k);
        from[k] = w->places + (size_t) (b->place + k) * w->g->size;
    }
}

/* Writes over what is laid of blocks before, too. */
static void widen_laid(struct gp_sky_weights *w)
{
    for (int j = 0; j <= 2 * w->g->ry; j++) {
        short *const laid = w->laid + 2 * j;
        const short *const span = w->span + 2 * j;
        if (span[0] >= span[1])
            continue;
        const bool none = laid[0] >= laid[1];
        laid[0] = none || span[0] < laid[0] ? span[0] : laid[0];
        laid[1] = none || span[1] > laid[1] ? span[1] : laid[1];
    }
}

/* Finds the weights of block i. */
void gp_sky_find_block(struct gp_sky_weights *w, int i)
{
    const struct gp_sky_level *const g = w->g;
    const float *from[4];
    if (w->spans != g->column[i].place) {
        find_spans(w, g->column[i].place);
        widen_laid(w);
    }
    // where the last block was another than the one before, its end is not known
    for (int k = w->column == i ? i + 1 : i; k <= i + 1; k++) {
        point_at(w, &g->column[k], from);
        add_rows(w, from, g->column[k].at, true);
    }
    w->column = i + 1;
}

/* Fills the factors that make the sum of a block's weights right in each row. */
void gp_sky_find_factors(const struct gp_sky_weights *w, int i, int n,
                         float *factor)
{
    const struct gp_sky_column *const b = &w->g->column[i];
    double middle = 0.0, sum[2 * ROWS] = {0};
    for (int j = 0; j < 4; j++) {
        double across = 0.0;
        for (int k = 0; k < 4; k++)
            across +=
                (double) b->at[k] *
                w->g->sum[(w->place + j) * w->s->places.n[0] + b->place + k];
        middle += (double) w->at[j] * across;
        for (int r = 0; r < n; r++)
            sum[r] += w->row[r][j] * across;
    }
    for (int r = 0; r < n; r++)
        factor[r] = (float) (sum[r] / middle);
}

// -- sums ---------------------------------------------------------------------

/* Sums dense light around the BLOCK columns and ROWS rows from (x, y) on, so many
 * columns at a time as a vector has. */
#define SUM_DENSE(name, vector, unaligned, target)                            \
    target static void name(const struct gp_sky_weights *w,                   \
                            const struct gp_sky_grid *light, int x, int y,    \
                            float sum[ROWS][3][BLOCK])                        \
    {                                                                         \
        enum { N = sizeof(vector) / sizeof(float) };                          \
        const struct gp_sky_level *const g = w->g;                            \
        const ptrdiff_t pitch = (ptrdiff_t) light->pitch;                     \
        for (int at = 0; at < g->block; at += N) {                            \
            vector a[ROWS][3] = {0}, lane = {0};                              \
            for (int k = 0; k < N; k++)                                       \
                lane[k] = (float) (at + k);                                   \
            for (int j = 0; j <= 2 * g->ry; j++) {                            \
                const float *const value = w->value + (size_t) j * w->pitch;  \
                const float *const slope = w->slope + (size_t) j * w->pitch;  \
                const ptrdiff_t from =                                        \
                    (ptrdiff_t) (y - j + g->ry) * pitch + x + at + g->rx;     \
                const float *const v0 = light->v[0] + from,                   \
                                   *const v1 = light->v[1] + from,            \
                                   *const v2 = light->v[2] + from;            \
                for (int i = w->span[2 * j]; i < w->span[2 * j + 1]; i++) {   \
                    const vector by = value[PAD + i] + lane * slope[PAD + i]; \
                    _Pragma("GCC unroll 4") for (int r = 0; r < ROWS; r++)    \
                    {                                                         \
                        const ptrdiff_t of = r * pitch - i;                   \
                        a[r][0] += by * *(const unaligned *) (v0 + of);       \
                        a[r][1] += by * *(const unaligned *) (v1 + of);       \
                        a[r][2] += by * *(const unaligned *) (v2 + of);       \
                    }                                                         \
                }                                                             \
            }                                                                 \
            for (int r = 0; r < ROWS; r++) {                                  \
                for (int c = 0; c < 3; c++)                                   \
                    memcpy(sum[r][c] + at, &a[r][c], sizeof(vector));         \
            }                                                                 \
        }                                                                     \
    }

SUM_DENSE(sum_narrow, lanes, loose, GP_CLONES)
SUM_DENSE(sum_wide, wide, loose_wide, GP_WIDE)

void gp_sky_sum_dense(const struct gp_sky_weights *w,
                      const struct gp_sky_grid *light, int x, int y,
                      float sum[ROWS][3][BLOCK])
{
    (w->by_wide && w->g->block == BLOCK ? sum_wide : sum_narrow)(w, light, x, y,
                                                                 sum);
}

/* Adds the sources [from, to) of a row, `down` rows above the first of ROWS rows
 * whose block starts at column x. */
GP_CLONES void gp_sky_sum_few(const struct gp_sky_weights *w,
                              const struct gp_sources *src, uint32_t from,
                              uint32_t to, int x, int down,
                              float sum[ROWS][3][BLOCK])
{
    const struct gp_sky_level *const g = w->g;
    const int first = gp_max(0, -g->ry - down);
    const int end = gp_min(ROWS, g->ry - down + 1);
    for (uint32_t i = from; i < to; i++) {
        const ptrdiff_t at = x - src->x[i] + g->rx + PAD;
        for (int r = first; r < end; r++) {
            const ptrdiff_t row =
                (ptrdiff_t) (down + r + g->ry) * (ptrdiff_t) w->pitch + at;
            for (int k = 0; k < g->block; k += LANES) {
                const float f = (float) k;
                const lanes lane = {f,     f + 1, f + 2, f + 3,
                                    f + 4, f + 5, f + 6, f + 7};
                const lanes by = *(const loose *) (w->value + row + k) +
                                 lane * *(const loose *) (w->slope + row + k);
                for (int c = 0; c < 3; c++)
                    *(loose *) (sum[r][c] + k) += by * src->rgb[c][i];
            }
        }
    }
}

/* The sum of light around node (x, y). */
GP_CLONES static void sum_node(const struct gp_sky_weights *w,
                               const struct gp_sky_grid *light, int x, int y,
                               float out[3])
{
    const struct gp_sky_level *const g = w->g;
    lanes a[3] = {{0}, {0}, {0}};
    for (int j = 0; j <= 2 * g->ry; j++) {
        const float *const value = w->value + PAD + (size_t) j * w->pitch;
        const ptrdiff_t at =
            (ptrdiff_t) (y - j + g->ry) * (ptrdiff_t) light->pitch + x + g->rx -
            (LANES - 1);
        // whole vectors: zeros come after
        for (int i = w->span[2 * j]; i < w->span[2 * j + 1]; i += LANES) {
            const lanes by = *(const loose *) (value + i);
            const lanes turned =
                __builtin_shufflevector(by, by, 7, 6, 5, 4, 3, 2, 1, 0);
            for (int c = 0; c < 3; c++)
                a[c] += turned * *(const loose *) (light->v[c] + at - i);
        }
    }
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0f;
        for (int k = 0; k < LANES; k++)
            out[c] += a[c][k];
    }
}

// -- rows ---------------------------------------------------------------------

/* A row of a level whose weights are found for each node; `light` has it as row y.
 * Of channel c at to + c * across. */
void gp_sky_sum_nodes(const struct gp_sky *s, int l, int row,
                      const struct gp_sky_grid *light, int y, size_t across,
                      float *to, float *scratch)
{
    const struct gp_sky_level *const g = &s->level[l];
    struct gp_sky_weights w;
    (void) gp_sky_weights_open(s, l, row, 1, scratch, &w);
    for (int x = 0; x < g->w; x++) {
        const struct gp_sky_column *const b = &g->column[x];
        const float *from[4];
        float sum[3];
        if (w.spans != b->place) {
            find_spans(&w, b->place);
            widen_laid(&w);
        }
        point_at(&w, b, from);
        add_rows(&w, from, b->at, false);
        sum_node(&w, light, x, y, sum);
        for (size_t c = 0; c < 3; c++)
            to[c * across + (size_t) x] = sum[c];
    }
}

/* Puts a block's sums, times factors, into rows: of channel c and row r at
 * to + r * down + c * across. */
void gp_sky_put_block(float sum[ROWS][3][BLOCK], const float *factor,
                      int columns, int n, size_t down, size_t across, float *to)
{
    for (int r = 0; r < n; r++) {
        for (size_t c = 0; c < 3; c++) {
            float *const at = to + (size_t) r * down + c * across;
            for (int k = 0; k < columns; k++)
                at[k] = sum[r][c][k] * factor[r];
        }
    }
}

void gp_sky_spread(const struct gp_sky *s, int l,
                   const struct gp_sky_grid *light, int group,
                   float *const out[3], float *scratch)
{
    const struct gp_sky_level *const g = &s->level[l];
    const int first = group * g->rows, n = gp_min(g->rows, g->h - first);
    const size_t wide = (size_t) g->w, across = (size_t) (out[1] - out[0]);
    float *const to = out[0] + (size_t) first * wide;
    struct gp_sky_weights w;
    for (int r = 0; r < n && g->block == 1; r++)
        gp_sky_sum_nodes(s, l, first + r, light, first + r, across,
                         to + (size_t) r * wide, scratch);
    if (g->block == 1)
        return;
    (void) gp_sky_weights_open(s, l, first, n, scratch, &w);
    for (int x = 0; x < g->w; x += g->block) {
        float sum[ROWS][3][BLOCK], factor[2 * ROWS];
        gp_sky_find_block(&w, x / g->block);
        gp_sky_find_factors(&w, x / g->block, n, factor);
        for (int r = 0; r < n; r += ROWS) {
            gp_sky_sum_dense(&w, light, x, first + r, sum);
            gp_sky_put_block(sum, factor + r, gp_min(g->block, g->w - x),
                             gp_min(ROWS, n - r), wide, across,
                             to + (size_t) r * wide + (size_t) x);
        }
    }
}
