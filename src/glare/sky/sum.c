// SPDX-License-Identifier: Apache-2.0
#include "glare/sky/sum.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"

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

GP_CLONES_WIDE void gp_sky_add_four(const float *const from[4],
                                    const float at[4], size_t n,
                                    float *restrict to)
{
    for (size_t i = 0; i < n; i++)
        to[i] = to[i] + at[0] * from[0][i] + at[1] * from[1][i] +
                at[2] * from[2][i] + at[3] * from[3][i];
}

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

// -- weights of a block -------------------------------------------------------

/* Zeros after a row are those before the next. */
static size_t pitch_of(const struct gp_sky_level *g)
{
    return g->pitch + PAD;
}

static size_t table_of(const struct gp_sky_level *g)
{
    return (2 * (size_t) g->ry + 1) * pitch_of(g) + PAD;
}

size_t gp_sky_weights_room(const struct gp_sky *s, const struct gp_sky_level *g)
{
    const size_t columns = (size_t) s->places.n[0];
    const size_t rows = 2 * (size_t) g->ry + 1;
    return columns * (2 * g->size + 1 + rows) + 4 * table_of(g) + 2 * rows +
           g->pitch + 4 * BLOCK;
}

float *gp_sky_weights_open(const struct gp_sky *s, int l, int first, int n,
                           float *scratch, struct gp_sky_weights *w)
{
    const struct gp_sky_level *const g = &s->level[l];
    const size_t columns = (size_t) s->places.n[0];
    const size_t rows = 2 * (size_t) g->ry + 1;
    const double before = l ? -g->step : 0.0;
    double at[4], t;
    *w = (struct gp_sky_weights) {.s = s,
                                  .g = g,
                                  .middle = 0.5 * (n - 1),
                                  .pitch = pitch_of(g),
                                  .table = table_of(g),
                                  .spanned = -1,
                                  .block = -1,
                                  .by_wide = gp_cpu_wide()};
    t = gp_sky_place_of(s, 1, before + (first + w->middle) * g->step);
    w->place = gp_sky_cubic(t, s->places.n[1], at);
    for (int r = 0; r < n; r++) {
        t = gp_sky_place_of(s, 1, before + (first + r) * g->step);
        // by the same four, beyond which a group is but little
        (void) gp_sky_cubic(t - w->place, 4, w->row[r]);
    }
    for (int k = 0; k < 4; k++) {
        w->at[0][k] = (float) at[k];
        w->at[1][k] =
            n > 1 ? (float) ((w->row[n - 1][k] - w->row[0][k]) / (n - 1))
                  : 0.0f;
    }
    w->places = scratch;
    w->value = w->places + 2 * columns * g->size;
    memset(w->value, 0, 4 * w->table * sizeof *w->value);
    w->known = (bool *) (void *) (w->value + 4 * w->table);
    memset(w->known, 0, columns);
    w->span = (short *) (void *) (w->value + 4 * w->table + columns);
    w->laid = w->span + 2 * rows;
    w->column = w->laid + 2 * rows;
    w->spans = w->column + 2 * g->pitch;
    memset(w->laid, 0, 2 * rows * sizeof *w->laid);
    return scratch + gp_sky_weights_room(s, g);
}

/* Adds four times weights to tables of a block, as far as they are laid: of `value` and
 * its slope.
 * `next`: the sum is the next block's, and what this one's slope leads to becomes its
 * value. */
GP_CLONES_WIDE static void add_rows(const struct gp_sky_weights *w,
                                    const float *const from[4],
                                    const float at[4], bool next, float *to)
{
    const struct gp_sky_level *const g = w->g;
    const float block = (float) g->block, step = 1.0f / block;
    for (int j = 0; j <= 2 * g->ry; j++) {
        const size_t row = (size_t) j * g->pitch;
        float *const value = to + PAD + (size_t) j * w->pitch;
        float *const slope = value + w->table;
        for (int i = w->laid[2 * j] / BLOCK * BLOCK; i < w->laid[2 * j + 1];
             i += BLOCK) {
            const wide v = at[0] * *(const loose_wide *) (from[0] + row + i) +
                           at[1] * *(const loose_wide *) (from[1] + row + i) +
                           at[2] * *(const loose_wide *) (from[2] + row + i) +
                           at[3] * *(const loose_wide *) (from[3] + row + i);
            loose_wide *const here = (loose_wide *) (value + i);
            loose_wide *const by = (loose_wide *) (slope + i);
            if (next) {
                *here += block * *by;
                *by = (v - *here) * step;
            } else {
                *here = v;
            }
        }
    }
}

/* Widens the spans of rows by others; by[0] >= by[1]: nothing. */
static void widen(short *span, const short *by, int rows)
{
    for (int j = 0; j < rows; j++, span += 2, by += 2) {
        const bool none = span[0] >= span[1];
        if (by[0] >= by[1])
            continue;
        span[0] = none || by[0] < span[0] ? by[0] : span[0];
        span[1] = none || by[1] > span[1] ? by[1] : span[1];
    }
}

/* Finds weights of a column of places, and where the level tilts how they grow; and
 * their spans. */
static void find_places(struct gp_sky_weights *w, int i)
{
    const struct gp_sky_level *const g = w->g;
    const size_t columns = (size_t) w->s->places.n[0];
    const int rows = 2 * g->ry + 1;
    const float *from[4];
    short *const span = w->spans + 2 * i * rows;
    if (w->known[i])
        return;
    memset(span, 0, 2 * (size_t) rows * sizeof *span);
    for (size_t k = 0; k < 4; k++) {
        const size_t at = ((size_t) w->place + k) * columns + (size_t) i;
        from[k] = g->weight + at * g->size;
        widen(span, g->span + 2 * at * (size_t) rows, rows);
    }
    for (size_t p = 0; p < (g->tilts ? 2 : 1); p++) {
        float *const to = w->places + (p * columns + (size_t) i) * g->size;
        memset(to, 0, g->size * sizeof *to);
        gp_sky_add_four(from, w->at[p], g->size, to);
    }
    w->known[i] = true;
}

/* Finds the spans of a block: what any of its places has. */
static void find_spans(struct gp_sky_weights *w, int place)
{
    const struct gp_sky_level *const g = w->g;
    const int rows = 2 * g->ry + 1;
    if (w->spanned == place)
        return;
    w->spanned = place;
    memset(w->span, 0, 2 * (size_t) rows * sizeof *w->span);
    // five columns: a block may end among the next four
    for (int i = place; i < gp_min(place + 5, w->s->places.n[0]); i++) {
        find_places(w, i);
        widen(w->span, w->spans + 2 * i * rows, rows);
    }
    widen(w->laid, w->span, rows); // of blocks before, too
    if (g->block == 1)             // sum_node() goes along rows
        return;
    for (int i = 0; i <= 2 * g->rx; i++) {
        w->column[2 * i] = (short) rows;
        w->column[2 * i + 1] = 0;
    }
    for (int j = 0; j < rows; j++) {
        for (int i = w->span[2 * j]; i < w->span[2 * j + 1]; i++) {
            // as many as a sum starts and ends with
            const int from = gp_min(w->column[2 * i], gp_min(j, rows - ROWS));
            w->column[2 * i] = (short) from;
            w->column[2 * i + 1] = (short) gp_max(j + 1, from + ROWS);
        }
    }
}

/* Adds the weights of a column of the level to the tables, by those of four columns of
 * places. */
static void add_column(struct gp_sky_weights *w, const struct gp_sky_column *b,
                       bool next)
{
    const size_t size = w->g->size, columns = (size_t) w->s->places.n[0];
    for (int k = 0; k < 4; k++)
        find_places(w, b->place + k);
    for (size_t p = 0; p < (w->g->tilts ? 2 : 1); p++) {
        const float *from[4];
        for (size_t k = 0; k < 4; k++)
            from[k] = w->places + (p * columns + (size_t) b->place + k) * size;
        add_rows(w, from, b->at, next, w->value + 2 * p * w->table);
    }
}

void gp_sky_find_block(struct gp_sky_weights *w, int i)
{
    const struct gp_sky_level *const g = w->g;
    find_spans(w, g->column[i].place);
    // where the last block was another than the one before, its end is not known
    for (int k = w->block == i ? i + 1 : i; k <= i + 1; k++)
        add_column(w, &g->column[k], true);
    w->block = i + 1;
}

void gp_sky_find_factors(const struct gp_sky_weights *w, int i, int n,
                         float *factor)
{
    const struct gp_sky_column *const b = &w->g->column[i];
    double middle = 0.0, grows = 0.0, sum[GP_SKY_BAND] = {0};
    for (int j = 0; j < 4; j++) {
        double across = 0.0;
        for (int k = 0; k < 4; k++)
            across +=
                (double) b->at[k] *
                w->g->sum[(w->place + j) * w->s->places.n[0] + b->place + k];
        middle += (double) w->at[0][j] * across;
        grows += w->g->tilts ? (double) w->at[1][j] * across : 0.0;
        for (int r = 0; r < n; r++)
            sum[r] += w->row[r][j] * across;
    }
    // near weights are of either sign, and their sum is none
    for (int r = 0; r < n; r++)
        factor[r] = w->s->single
                        ? 1.0f
                        : (float) (sum[r] / (middle + (r - w->middle) * grows));
}

// -- sums ---------------------------------------------------------------------

/* Adds, to sums of ROWS rows, columns of weights times the light that they meet. Down a
 * column each row of light meets the weights of ROWS rows: `u` has those of rows j,
 * j + 1 .. before it, and `d` by how much they grow with a row; at both ends only some
 * of them. */
#define SUM_COLUMN(name, vector, unaligned)                                    \
    static inline __attribute__((always_inline)) void name##_row(              \
        vector a[ROWS][3], const vector u[ROWS], const vector d[ROWS],         \
        const float *down, const float *const v[3], int from, int to)          \
    {                                                                          \
        const vector l0 = *(const unaligned *) v[0];                           \
        const vector l1 = *(const unaligned *) v[1];                           \
        const vector l2 = *(const unaligned *) v[2];                           \
        _Pragma("GCC unroll 4") for (int r = from; r < to; r++)                \
        {                                                                      \
            const vector by = down ? u[r] + down[r] * d[r] : u[r];             \
            a[r][0] += by * l0;                                                \
            a[r][1] += by * l1;                                                \
            a[r][2] += by * l2;                                                \
        }                                                                      \
    }                                                                          \
    static inline __attribute__((always_inline)) void name##_column(           \
        const struct gp_sky_weights *w, int i, vector lane, const float *down, \
        const float *const light[3], ptrdiff_t pitch, vector a[ROWS][3])       \
    {                                                                          \
        const int first = w->column[2 * i], end = w->column[2 * i + 1];        \
        const float *at = w->value + (size_t) (end - 1) * w->pitch + PAD + i;  \
        const ptrdiff_t from = -(ptrdiff_t) (end - 1) * pitch;                 \
        const float *v[3] = {light[0] + from, light[1] + from,                 \
                             light[2] + from};                                 \
        vector u[ROWS] = {0}, d[ROWS] = {0};                                   \
        for (int j = end - 1, n = 1; j > first - ROWS; j--, n++) {             \
            _Pragma("GCC unroll 4") for (int r = ROWS - 1; r > 0; r--)         \
            {                                                                  \
                u[r] = u[r - 1];                                               \
                d[r] = d[r - 1];                                               \
            }                                                                  \
            if (j >= first) {                                                  \
                u[0] = at[0] + lane * at[w->table];                            \
                if (down)                                                      \
                    d[0] = at[2 * w->table] + lane * at[3 * w->table];         \
                at -= w->pitch;                                                \
            }                                                                  \
            if (n >= ROWS && j >= first)                                       \
                name##_row(a, u, d, down, v, 0, ROWS);                         \
            else if (n == 1)                                                   \
                name##_row(a, u, d, down, v, 0, 1);                            \
            else if (n == 2)                                                   \
                name##_row(a, u, d, down, v, 0, 2);                            \
            else if (n == 3)                                                   \
                name##_row(a, u, d, down, v, 0, 3);                            \
            else if (j == first - 1)                                           \
                name##_row(a, u, d, down, v, 1, ROWS);                         \
            else if (j == first - 2)                                           \
                name##_row(a, u, d, down, v, 2, ROWS);                         \
            else                                                               \
                name##_row(a, u, d, down, v, 3, ROWS);                         \
            for (int c = 0; c < 3; c++)                                        \
                v[c] += pitch;                                                 \
        }                                                                      \
    }

SUM_COLUMN(sum_narrow, lanes, loose)
SUM_COLUMN(sum_wide, wide, loose_wide)

/* Sums dense light around the BLOCK columns and ROWS rows from (x, y) on, so many columns
 * at a time as a vector has. */
#define SUM_DENSE(name, vector, target)                                        \
    target static void name(const struct gp_sky_weights *w,                    \
                            const struct gp_sky_grid *light, int x, int y,     \
                            const float *down, float sum[ROWS][3][BLOCK])      \
    {                                                                          \
        enum { N = sizeof(vector) / sizeof(float) };                           \
        const struct gp_sky_level *const g = w->g;                             \
        const ptrdiff_t pitch = (ptrdiff_t) light->pitch;                      \
        for (int at = 0; at < g->block; at += N) {                             \
            vector a[ROWS][3] = {0}, lane = {0};                               \
            for (int k = 0; k < N; k++)                                        \
                lane[k] = (float) (at + k);                                    \
            for (int i = 0; i <= 2 * g->rx; i++) {                             \
                const ptrdiff_t of = (y + g->ry) * pitch + x + at + g->rx - i; \
                const float *const v[3] = {light->v[0] + of, light->v[1] + of, \
                                           light->v[2] + of};                  \
                if (w->column[2 * i] >= w->column[2 * i + 1])                  \
                    continue;                                                  \
                if (down)                                                      \
                    name##_column(w, i, lane, down, v, pitch, a);              \
                else                                                           \
                    name##_column(w, i, lane, NULL, v, pitch, a);              \
            }                                                                  \
            for (int r = 0; r < ROWS; r++) {                                   \
                for (int c = 0; c < 3; c++)                                    \
                    memcpy(sum[r][c] + at, &a[r][c], sizeof(vector));          \
            }                                                                  \
        }                                                                      \
    }

SUM_DENSE(sum_narrow, lanes, GP_CLONES)
SUM_DENSE(sum_wide, wide, GP_WIDE)

void gp_sky_sum_dense(const struct gp_sky_weights *w,
                      const struct gp_sky_grid *light, int x, int y, int r,
                      float sum[ROWS][3][BLOCK])
{
    float down[ROWS];
    for (int k = 0; k < ROWS; k++)
        down[k] = (float) (r + k - w->middle);
    (w->by_wide && w->g->block == BLOCK ? sum_wide : sum_narrow)(
        w, light, x, y, w->g->tilts ? down : NULL, sum);
}

GP_CLONES void gp_sky_sum_few(const struct gp_sky_weights *w,
                              const struct gp_sources *src, uint32_t from,
                              uint32_t to, int x, int down, int r,
                              float sum[ROWS][3][BLOCK])
{
    const struct gp_sky_level *const g = w->g;
    const int first = gp_max(0, -g->ry - down);
    const int end = gp_min(ROWS, g->ry - down + 1);
    for (uint32_t i = from; i < to; i++) {
        const ptrdiff_t at = x - src->x[i] + g->rx + PAD;
        for (int k = first; k < end; k++) {
            const float *const row =
                w->value + at +
                (ptrdiff_t) (down + k + g->ry) * (ptrdiff_t) w->pitch;
            const float of = (float) (r + k - w->middle);
            for (int b = 0; b < g->block; b += LANES) {
                const float f = (float) b, *const v = row + b;
                const lanes lane = {f,     f + 1, f + 2, f + 3,
                                    f + 4, f + 5, f + 6, f + 7};
                lanes by =
                    *(const loose *) v + lane * *(const loose *) (v + w->table);
                if (g->tilts)
                    by += of * (*(const loose *) (v + 2 * w->table) +
                                lane * *(const loose *) (v + 3 * w->table));
                for (int c = 0; c < 3; c++)
                    *(loose *) (sum[k][c] + b) += by * src->rgb[c][i];
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

void gp_sky_sum_nodes(const struct gp_sky *s, int l, int row,
                      const struct gp_sky_grid *light, int y, size_t across,
                      float *to, float *scratch)
{
    const struct gp_sky_level *const g = &s->level[l];
    struct gp_sky_weights w;
    (void) gp_sky_weights_open(s, l, row, 1, scratch, &w);
    for (int x = 0; x < g->w; x++) {
        const struct gp_sky_column *const b = &g->column[x];
        float sum[3];
        find_spans(&w, b->place);
        add_column(&w, b, false);
        sum_node(&w, light, x, y, sum);
        for (size_t c = 0; c < 3; c++)
            to[c * across + (size_t) x] = sum[c];
    }
}

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
        float sum[ROWS][3][BLOCK], factor[GP_SKY_BAND];
        gp_sky_find_block(&w, x / g->block);
        gp_sky_find_factors(&w, x / g->block, n, factor);
        for (int r = 0; r < n; r += ROWS) {
            gp_sky_sum_dense(&w, light, x, first + r, r, sum);
            gp_sky_put_block(sum, factor + r, gp_min(g->block, g->w - x),
                             gp_min(ROWS, n - r), wide, across,
                             to + (size_t) r * wide + (size_t) x);
        }
    }
}
