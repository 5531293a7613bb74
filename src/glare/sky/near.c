// SPDX-License-Identifier: Apache-2.0
/* Light of sources near a pixel: listed where they are few, else laid out. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/sky/sum.h"

#include <string.h>

enum { BLOCK = GP_SKY_BLOCK, ROWS = GP_SKY_ROWS };

static void index_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct gp_sky_index *const index = ctx;
    const struct gp_sources *const s = index->src;
    uint32_t *const at = gp_sky_index_row(index, y);
    uint32_t i = s->row[y];
    for (int b = 0; b < index->blocks; b++) {
        while (i < s->row[y + 1] && s->x[i] < b * BLOCK)
            i++;
        at[b] = i;
    }
    at[index->blocks] = s->row[y + 1];
}

gp_status gp_sky_index_make(const struct gp_log *log,
                            const struct gp_sources *src,
                            struct gp_sky_index *out)
{
    out->src = src;
    out->blocks = (src->w + BLOCK - 1) / BLOCK;
    const gp_status st =
        gp_alloc(log, "layer", (size_t) src->h * (size_t) (out->blocks + 1),
                 sizeof *out->at, &out->at);
    if (!st)
        gp_parallel_do(src->h, index_row, out);
    return st;
}

/* Rows of sources that reach a band. */
struct near {
    const struct gp_sky *s;
    const struct gp_sky_index *index;
    int top;                  // row of the band
    struct gp_sky_grid light; // laid out, where it is
    bool laid;
};

/* Lays the sources of a row out. */
static void lay_row(const struct near *v, int y, const float *rgb, float *row)
{
    const int32_t *const x = v->index->src->x;
    const uint32_t *const at = gp_sky_index_row(v->index, y);
    for (int b = 0; b < v->index->blocks; b++) {
        if (at[b + 1] - at[b] == BLOCK) { // all of its pixels
            memcpy(row + b * BLOCK, rgb + at[b], BLOCK * sizeof *row);
            continue;
        }
        for (uint32_t i = at[b]; i < at[b + 1]; i++)
            row[x[i]] = rgb[i];
    }
}

/* Lays sources out, black elsewhere. */
static void lay_out(struct near *v)
{
    const struct gp_sources *const s = v->index->src;
    struct gp_sky_grid *const g = &v->light;
    const int from = gp_max(v->top - g->ry, 0);
    const int to = gp_min(v->top + g->h + g->ry, s->h);
    memset(g->v[0] - g->before, 0,
           3 * (size_t) (2 * g->ry + g->h) * g->pitch * sizeof(float));
    for (int y = from; y < to; y++) {
        for (int c = 0; c < 3; c++)
            lay_row(v, y, s->rgb[c], gp_sky_grid_row(g, c, y - v->top));
    }
    v->laid = true;
}

static size_t pitch_of(const struct gp_sky *s)
{
    return gp_sky_row_room(s->p.w + 2 * (s->level[0].rx + GP_SKY_LANES));
}

size_t gp_sky_room(const struct gp_sky *s)
{
    const size_t rows = 2 * (size_t) s->level[0].ry + GP_SKY_BAND;
    size_t room = gp_sky_weights_room(s, &s->level[0]) + 3 * rows * pitch_of(s);
    for (int l = 1; l < s->levels; l++) {
        const size_t more = gp_sky_weights_room(s, &s->level[l]) +
                            4 * (size_t) s->level[l].w + 64;
        room = room > more ? room : more;
    }
    return room + 3 * (GP_SKY_BAND + 2) * gp_sky_row_room(s->p.w + BLOCK);
}

/* Counts the sources that reach a block of n rows; [*left, *right) are the index's
 * blocks that have them. */
static size_t count_near(const struct near *v, int x, int y, int n, int *left,
                         int *right)
{
    const struct gp_sky_level *const g = &v->s->level[0];
    const size_t blocks = (size_t) v->index->blocks + 1;
    size_t count = 0;
    *left = gp_max(x - g->rx, 0) / BLOCK;
    *right = gp_min((x + g->block - 1 + g->rx) / BLOCK + 1, v->index->blocks);
    for (int j = gp_max(y - g->ry, 0);
         j < gp_min(y + n + g->ry, v->index->src->h); j++)
        count += v->index->at[(size_t) j * blocks + (size_t) *right] -
                 v->index->at[(size_t) j * blocks + (size_t) *left];
    return count;
}

/* Sums what reaches n of ROWS rows of a block, from row r of a group on, which starts
 * at row y; false: nothing does. */
static bool sum_near(struct near *v, struct gp_sky_weights *w, int x, int y,
                     int r, int n, float sum[ROWS][3][BLOCK])
{
    const struct gp_sky_level *const g = &v->s->level[0];
    const size_t blocks = (size_t) v->index->blocks + 1;
    int left, right;
    y += r;
    const size_t count = count_near(v, x, y, n, &left, &right);
    // as many as take as long as all pixels of the window
    const size_t few =
        (size_t) (right - left) * BLOCK * (size_t) (2 * g->ry + n) / 20;
    if (!count)
        return false;
    if (w->block != x / g->block + 1)
        gp_sky_find_block(w, x / g->block);
    if (count > few) {
        if (!v->laid)
            lay_out(v);
        gp_sky_sum_dense(w, &v->light, x, y - v->top, r, sum);
        return true;
    }
    memset(sum, 0, ROWS * sizeof *sum);
    for (int j = gp_max(y - g->ry, 0);
         j < gp_min(y + n + g->ry, v->index->src->h); j++)
        gp_sky_sum_few(w, v->index->src,
                       v->index->at[(size_t) j * blocks + (size_t) left],
                       v->index->at[(size_t) j * blocks + (size_t) right], x,
                       y - j, r, sum);
    return true;
}

/* A group of n rows from y on. */
static void sum_group(struct near *v, int y, int n, float *rows, float *scratch)
{
    const struct gp_sky_level *const g = &v->s->level[0];
    const size_t across = gp_sky_row_room(v->index->src->w), down = 3 * across;
    struct gp_sky_weights w;
    (void) gp_sky_weights_open(v->s, 0, y, n, scratch, &w);
    for (int x = 0; x < v->index->src->w; x += g->block) {
        float sum[ROWS][3][BLOCK], factor[GP_SKY_BAND];
        bool known = false;
        for (int r = 0; r < n; r += ROWS) {
            const int m = gp_min(ROWS, n - r);
            if (!sum_near(v, &w, x, y, r, m, sum))
                continue;
            if (!known)
                gp_sky_find_factors(&w, x / g->block, n, factor);
            known = true;
            gp_sky_put_block(sum, factor + r, g->block, m, down, across,
                             rows + (size_t) r * down + (size_t) x);
        }
    }
}

void gp_sky_near(const struct gp_sky *s, const struct gp_sky_index *index,
                 int first, int n, float *rows, float *scratch)
{
    const struct gp_sources *const src = index->src;
    const struct gp_sky_level *const g = &s->level[0];
    const size_t across = gp_sky_row_room(src->w), down = 3 * across;
    const int from = gp_max(first - g->ry, 0);
    const int to = gp_min(first + n + g->ry, src->h);
    struct near v = {.s = s, .index = index, .top = first};
    struct gp_sky_grid *const light = &v.light;
    *light = (struct gp_sky_grid) {.w = src->w,
                                   .h = GP_SKY_BAND,
                                   .rx = g->rx + GP_SKY_LANES,
                                   .ry = g->ry,
                                   .pitch = pitch_of(s)};
    light->before = (size_t) g->ry * light->pitch + (size_t) light->rx;
    for (int c = 0; c < 3; c++) {
        light->v[c] = scratch + light->before;
        scratch += (2 * (size_t) g->ry + GP_SKY_BAND) * light->pitch;
    }
    memset(rows, 0, (size_t) n * down * sizeof *rows);
    if (src->row[from] == src->row[to])
        return;
    if (g->block == 1)
        lay_out(&v);
    for (int r = 0; r < n; r += g->block == 1 ? 1 : g->rows) {
        float *const row = rows + (size_t) r * down;
        if (g->block == 1)
            gp_sky_sum_nodes(s, 0, first + r, light, r, across, row, scratch);
        else
            sum_group(&v, first + r, gp_min(g->rows, n - r), row, scratch);
    }
}
