// SPDX-License-Identifier: Apache-2.0
/* The layer of sources: light up the levels, spread on each, and down again. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky_priv.h"
#include "glare/sky/sum.h"

#include <math.h>
#include <string.h>

enum { BAND = 16 }; // rows of a task

struct adding {
    const struct gp_sky *sky;
    const struct gp_sources *src;
    struct gp_sky_index index;
    struct gp_planes *layer;
    bool add;
    float more[3];
    gp_task rest;
    void *ctx;
    struct gp_sky_grid light[GP_SKY_LEVELS]; // of levels from 1 on: moments
    float *out[GP_SKY_LEVELS][3];            // w * h: what is spread there
    float
        *node[GP_SKY_LEVELS][3]; // w * h: splines of it, and of farther levels
    int level;                   // that tasks work on
    float *scratch;
    size_t room; // floats of a thread
};

// -- up -----------------------------------------------------------------------

/* B of the nodes around an even and an odd pixel of level 0 on level 1. */
static void spline_rows(float at[2][GP_SKY_TAPS])
{
    for (int i = 0; i < 2; i++) {
        double b[GP_SKY_TAPS];
        gp_far_spline(0.5 * i, b);
        for (int k = 0; k < GP_SKY_TAPS; k++)
            at[i][k] = (float) b[k];
    }
}

/* Adds the light of a row of pixels, times its solid angles, to the nodes of a
 * line, channel after channel. */
static void gather_row(const struct adding *a, int y, float *solid, float *line)
{
    enum { FEW = 64 };
    const struct gp_sources *const src = a->src;
    const size_t pitch = a->light[1].pitch;
    const struct gp_projection *const p = &a->sky->p.projection;
    const uint32_t from = src->row[y], to = src->row[y + 1];
    float at[2][GP_SKY_TAPS];
    spline_rows(at);
    if (to - from > FEW)
        gp_projection_solid_row(p, 0.0, y, src->w, solid);
    for (uint32_t i = from; i < to; i++) {
        const int x = src->x[i];
        const float omega =
            to - from > FEW ? solid[x] : (float) gp_projection_solid(p, x, y);
        for (size_t c = 0; c < 3; c++) {
            const float v = omega * src->rgb[c][i];
            float *const node = line + c * pitch + (size_t) (x >> 1);
            for (int k = 0; k < GP_SKY_TAPS; k++)
                node[k] += v * at[x & 1][k];
        }
    }
}

/* BAND rows of nodes of level 1. */
static void gather_band(void *ctx, int band, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_grid *const to = &a->light[1];
    const size_t n = 3 * to->pitch;
    float *const line = a->scratch + (size_t) thread * a->room;
    float *const solid = line + n;
    const int from = band * BAND, end = gp_min(from + BAND, to->h);
    float at[2][GP_SKY_TAPS];
    spline_rows(at);
    // node row g lies on pixel row 2 (g - 1), and meets three on each side
    for (int y = gp_max(2 * from - 5, 0); y < gp_min(2 * end + 2, a->src->h);
         y++) {
        if (a->src->row[y] == a->src->row[y + 1])
            continue;
        memset(line, 0, n * sizeof *line);
        gather_row(a, y, solid, line);
        for (int k = 0; k < GP_SKY_TAPS; k++) {
            const int g = (y >> 1) + k;
            if (g < from || g >= end)
                continue;
            for (size_t c = 0; c < 3; c++)
                gp_sky_add_scaled(gp_sky_grid_row(to, (int) c, g),
                                  line + c * to->pitch, at[y & 1][k], to->w);
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
    const int c = i / to->h, g = i % to->h;
    float *const out = gp_sky_grid_row(to, c, g);
    float *const line = a->scratch + (size_t) thread * a->room + 4;
    // nodes before and after those of `from` are black
    memset(line - 4, 0, ((size_t) from->w + 16) * sizeof *line);
    for (int k = 0; k < 5; k++) {
        const int y = 2 * g - 3 + k;
        if (y >= 0 && y < from->h)
            gp_sky_add_scaled(line, gp_sky_grid_row(from, c, y), B[k], from->w);
    }
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
                  a->out[a->level], a->scratch + (size_t) thread * a->room);
}

/* Node i of the last level. */
static void spread_last(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const int l = a->sky->levels - 1, n = a->sky->level[l].w;
    (void) thread;
    const float *const w =
        a->sky->pairs + (size_t) i * (size_t) n * (size_t) a->sky->level[l].h;
    for (int c = 0; c < 3; c++) {
        float sum = 0.0f;
        for (int y = 0; y < a->sky->level[l].h; y++)
            sum += gp_sky_dot(w + (size_t) y * (size_t) n,
                              gp_sky_grid_row(&a->light[l], c, y), n);
        a->out[l][c][i] = sum;
    }
}

// -- down ---------------------------------------------------------------------

enum { REACH = 6 }; // nodes

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

/* Divides splines out of a line of n nodes, both ways continued. */
GP_CLONES static void divide_line(const float *restrict line, int n,
                                  const float at[REACH + 1],
                                  float *restrict out)
{
    for (int i = 0; i < n; i++) {
        float v = at[0] * line[i];
        for (int k = 1; k <= REACH; k++)
            v += at[k] * (line[i - k] + line[i + k]);
        out[i] = v;
    }
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
    const struct gp_sky_level *const to = &a->sky->level[a->level];
    const struct gp_sky_level *const from = &a->sky->level[a->level + 1];
    const int w = from->w, half = (f + 1) / 2;
    const float *const at = a->node[a->level + 1][c];
    memset(line, 0, (size_t) w * sizeof *line);
    // fine node f lies on the coarse node (f + 1) / 2, or between two
    const float odd[3] = {0.125f, 0.75f, 0.125f}, even[2] = {0.5f, 0.5f};
    for (int k = 0; k < (f & 1 ? 3 : 2); k++)
        gp_sky_add_scaled(line, at + (size_t) (half - (f & 1) + k) * (size_t) w,
                          f & 1 ? odd[k] : even[k], w);
    for (int x = 0; x < to->w; x++) {
        const float *const v = line + (x + 1) / 2;
        out[x] += x & 1 ? 0.125f * (v[-1] + v[1]) + 0.75f * v[0]
                        : 0.5f * (v[0] + v[1]);
    }
}

/* Row i % h of channel i / h of a level: splines of what is spread on it and on all
 * farther ones. */
static void find_row(void *ctx, int i, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_level *const g = &a->sky->level[a->level];
    const int c = i / g->h, y = i % g->h;
    const size_t w = (size_t) g->w;
    float *const line = a->scratch + (size_t) thread * a->room + REACH;
    float *const out = a->node[a->level][c] + (size_t) y * w;
    float at[2 * REACH + 1 + 6], along[2 * REACH + 1 + 6];
    int first, middle;
    divide_weights(y, g->h, at, &first);
    divide_weights(4 * REACH, 8 * REACH + 1, along, &middle);
    memset(line, 0, w * sizeof *line);
    for (int k = 0; k < 2 * REACH + 1 + 6 && first + k < g->h; k++) {
        if (at[k] != 0.0f)
            gp_sky_add_scaled(line,
                              a->out[a->level][c] + (size_t) (first + k) * w,
                              at[k], g->w);
    }
    continue_line(line, g->w);
    divide_line(line, g->w, along + REACH, out);
    if (a->level < a->sky->levels - 1)
        double_row(a, c, y, line, out);
}

/* Adds the nodes of level 1 to a row of n pixels. */
GP_CLONES static void put_row(const float *restrict line, int n,
                              float *restrict row)
{
    for (int i = 0; 2 * i < n; i++) {
        row[2 * i] += (line[i] + line[i + 2]) * (1.0f / 6.0f) +
                      line[i + 1] * (4.0f / 6.0f);
        if (2 * i + 1 < n)
            row[2 * i + 1] += (line[i] + line[i + 3]) * (1.0f / 48.0f) +
                              (line[i + 1] + line[i + 2]) * (23.0f / 48.0f);
    }
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
static void stay_row(const struct adding *a, int y, float *own, float *rows,
                     size_t apart)
{
    const struct gp_sources *const src = a->src;
    if (src->row[y] == src->row[y + 1])
        return;
    gp_sky_own(a->sky, src->w, src->h, y, own);
    for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
        for (size_t c = 0; c < 3; c++)
            rows[c * apart + (size_t) src->x[i]] +=
                (own[src->x[i]] + a->more[c]) * src->rgb[c][i];
    }
}

/* A band of pixels. */
static void finish_band(void *ctx, int band, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_sky_level *const g = &a->sky->level[1];
    const int w = a->src->w, h = a->src->h, first = band * GP_SKY_BAND;
    const size_t wide = gp_sky_row_room(w), nodes = (size_t) g->w;
    float *const rows =
        a->scratch + (size_t) thread * a->room; // [row][c][wide]
    float *const line = rows + 3 * GP_SKY_BAND * wide;
    float at[2][GP_SKY_TAPS];
    spline_rows(at);
    const int n = gp_min(GP_SKY_BAND, h - first);
    gp_sky_near(a->sky, a->src, &a->index, first, n, rows, line);
    for (int r = 0; r < n; r++) {
        const int y = first + r;
        float *const row = rows + (size_t) r * 3 * wide;
        stay_row(a, y, line, row, wide);
        for (int c = 0; c < 3; c++) {
            memset(line, 0, nodes * sizeof *line);
            for (int k = 0; k < GP_SKY_TAPS; k++)
                gp_sky_add_scaled(
                    line, a->node[1][c] + (size_t) ((y >> 1) + k) * nodes,
                    at[y & 1][k], g->w);
            put_row(line, w, row + (size_t) c * wide);
            write_row(row + (size_t) c * wide, w, a->add,
                      a->layer->c[c] + (size_t) y * (size_t) w);
            if (a->rest)
                a->rest(a->ctx, c * h + y, thread);
        }
    }
}

// -- all of it ----------------------------------------------------------------

static gp_status alloc_grids(const struct gp_log *log, struct adding *a)
{
    gp_status st = GP_OK;
    const struct gp_sky *const s = a->sky;
    for (int l = 1; l < s->levels; l++) {
        const struct gp_sky_level *const g = &s->level[l];
        GP_TRY(gp_sky_grid_make(log, g, &a->light[l]));
        const size_t n = (size_t) g->w * (size_t) g->h;
        GP_TRY(gp_alloc(log, "layer", 3 * n, sizeof(float), &a->out[l][0]));
        GP_TRY(gp_alloc(log, "layer", 3 * n, sizeof(float), &a->node[l][0]));
        for (int c = 1; c < 3; c++) {
            a->out[l][c] = a->out[l][c - 1] + n;
            a->node[l][c] = a->node[l][c - 1] + n;
        }
    }
    a->room = gp_sky_room(s);
    st = gp_alloc(log, "layer", a->room * (size_t) gp_threads(), sizeof(float),
                  &a->scratch);
out:
    return st;
}

gp_status gp_sky_add(const struct gp_log *log, const struct gp_sky *sky,
                     const struct gp_sources *src, bool add,
                     const float more[3], gp_task rest, void *ctx,
                     struct gp_planes *layer)
{
    struct adding a = {.sky = sky,
                       .src = src,
                       .layer = layer,
                       .add = add,
                       .more = {more[0], more[1], more[2]},
                       .rest = rest,
                       .ctx = ctx};
    const int last = sky->levels - 1;
    gp_status st = alloc_grids(log, &a);
    if (!st)
        st = gp_sky_index_make(log, src, &a.index);
    if (!st) {
        gp_parallel_do((a.light[1].h + BAND - 1) / BAND, gather_band, &a);
        for (a.level = 2; a.level <= last; a.level++)
            gp_parallel_do(3 * a.light[a.level].h, halve_row, &a);
        gp_parallel_do(sky->level[last].w * sky->level[last].h, spread_last,
                       &a);
        for (a.level = last; a.level >= 1; a.level--) {
            const struct gp_sky_level *const g = &sky->level[a.level];
            if (a.level < last)
                gp_parallel_do((g->h + g->rows - 1) / g->rows, spread_rows, &a);
            gp_parallel_do(3 * g->h, find_row, &a);
        }
        gp_parallel_do((src->h + GP_SKY_BAND - 1) / GP_SKY_BAND, finish_band,
                       &a);
    }
    for (int l = 1; l < sky->levels; l++) {
        gp_sky_grid_free(&a.light[l]);
        gp_free(a.out[l][0]);
        gp_free(a.node[l][0]);
    }
    gp_free(a.index.at);
    gp_free(a.scratch);
    return st;
}
