// SPDX-License-Identifier: Apache-2.0
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/splat/polygons.h"

#include <float.h>
#include <math.h>
#include <string.h>

const int gp_blur_box[GP_BLURS] = {1, 2, 3, 4, 6, 8, 12, 16, 32, 64};

/* Sums over one cell, positions from its corner. */
struct cell_sum {
    double light, x, y, square; // of luminance, and times x, y, x^2 + y^2
    double rgb[3];
    int sources;
};

/* Polygons of one row of the largest cells. */
struct band {
    struct gp_polygon *at;   // clusters, then groups
    size_t clusters, groups; // counts
};

struct grouping {
    const struct gp_sources *src;
    const struct gp_splat_params *p;
    int step;            // rows of a band: the larger cell's side
    int left, above;     // pixels of the first cell outside the window
    int columns;         // group cells in a row
    int wide;            // cluster cells in a row
    struct band *band;
    struct cell_sum *scratch; // for each thread: columns + wide
    struct gp_polygon *out;   // src->n: those of a band from its first source's
};

/* -- cells ----------------------------------------------------------------- */

/* Adds sources [i, end) of one row of a cell; `dx` is added to their columns,
 * and they are `dy` rows under its first row. */
static void add_sources(const struct gp_sources *src, uint32_t i, uint32_t end,
                        int dx, int dy, struct cell_sum *cell)
{
    const double wr = (double) src->luminance[0];
    const double wg = (double) src->luminance[1];
    const double wb = (double) src->luminance[2];
    double rgb[3] = {0}, light = 0.0, lx = 0.0, square = 0.0;
    cell->sources += (int) (end - i);
    for (; i < end; i++) {
        const double r = (double) src->rgb[0][i], g = (double) src->rgb[1][i];
        const double b = (double) src->rgb[2][i], x = src->x[i] + dx;
        double y = wr * r + wg * g + wb * b;
        y = y > 0.0 ? y : 0.0; // unreal primaries have negative weights
        rgb[0] += r;
        rgb[1] += g;
        rgb[2] += b;
        light += y;
        lx += y * x;
        square += y * x * x;
    }
    for (int c = 0; c < 3; c++)
        cell->rgb[c] += rgb[c];
    cell->light += light;
    cell->x += lx;
    cell->y += light * dy;
    cell->square += square + light * dy * dy;
}

/* The cell whose corner is pixel (x0, y0) as a polygon. */
static struct gp_polygon close_cell(const struct cell_sum *cell, int x0, int y0,
                                    int side)
{
    double x = (side - 1) / 2.0, y = x, variance = 0.0;
    if (cell->light > 0.0) {
        x = cell->x / cell->light;
        y = cell->y / cell->light;
        variance = (cell->square / cell->light - x * x - y * y) / 2.0;
    }
    struct gp_polygon p = {
        .x = (float) (x0 + x), .y = (float) (y0 + y),
        .light = (float) fmin(cell->light, (double) FLT_MAX),
        .side = (uint8_t) side,
    };
    for (int c = 0; c < 3; c++)
        p.rgb[c] = (float) fmin(cell->rgb[c], (double) FLT_MAX);
    // the box that spreads the light most nearly by the variance
    double least = INFINITY;
    for (uint8_t b = 0; b < GP_BLURS && gp_blur_box[b] <= side; b++) {
        const int box = gp_blur_box[b];
        const double u = (double) p.x - (box - 1) / 2.0;
        const double v = (double) p.y - (box - 1) / 2.0;
        const double fx = u - floor(u), fy = v - floor(v);
        const double spread = (box * box - 1) / 12.0 +
                              (fx * (1.0 - fx) + fy * (1.0 - fy)) / 2.0;
        if (fabs(spread - variance) < least) {
            least = fabs(spread - variance);
            p.blur = b;
        }
    }
    return p;
}

/* Writes the cells of a row that hold light; returns how many. */
static size_t close_row(const struct grouping *g, const struct cell_sum *cell,
                        int cells, int y0, int side, struct gp_polygon *out)
{
    size_t n = 0;
    for (int k = 0; k < cells; k++) {
        if (cell[k].sources)
            out[n++] = close_cell(&cell[k], k * side - g->left, y0, side);
    }
    return n;
}

/* -- one band -------------------------------------------------------------- */

/* Sums the rows [y0, y1) into one row of cells, but for sources in a cluster,
 * where that is not NULL. */
static void add_rows(const struct grouping *g, int y0, int y1, int side,
                     const struct cell_sum *cluster, struct cell_sum *cell)
{
    const int32_t *const x = g->src->x;
    for (int y = y0; y < y1; y++) {
        const uint32_t past = g->src->row[y + 1];
        for (uint32_t i = g->src->row[y], end; i < past; i = end) {
            const int at = (x[i] + g->left) / side;
            const int beyond = (at + 1) * side - g->left;
            for (end = i + 1; end < past && x[end] < beyond;)
                end++;
            if (!cluster || !cluster[(x[i] + g->left) / g->p->cluster].sources)
                add_sources(g->src, i, end, g->left - at * side,
                            (y + g->above) % side, &cell[at]);
        }
    }
}

/* Makes the band's polygons. */
static void group_band(void *ctx, int i, int thread)
{
    const struct grouping *const g = ctx;
    struct cell_sum *const cell =
        g->scratch + (size_t) (g->columns + g->wide) * (size_t) thread;
    struct cell_sum *const cluster = cell + g->columns;
    struct band *const b = &g->band[i];
    const int side = g->p->group, large = g->p->cluster;
    const int start = i * g->step - g->above;
    const int y0 = gp_max(0, start), y1 = gp_min(g->src->h, start + g->step);
    b->at = g->out + g->src->row[y0];
    memset(cluster, 0, (size_t) g->wide * sizeof *cluster);
    if (large)
        add_rows(g, y0, y1, large, NULL, cluster);
    for (int k = 0; k < g->wide; k++) {
        const int x0 = gp_max(0, k * large - g->left);
        const int x1 = gp_min(g->src->w, (k + 1) * large - g->left);
        // in float, as the shaders decide it
        const float area = (float) ((x1 - x0) * (y1 - y0));
        if (!((float) cluster[k].sources >= g->p->cluster_fill * area))
            cluster[k].sources = 0;
    }
    b->clusters = close_row(g, cluster, g->wide, start, large, b->at);
    for (int top = start; top < y1; top += side) {
        if (top + side <= y0)
            continue;
        memset(cell, 0, (size_t) g->columns * sizeof *cell);
        add_rows(g, gp_max(top, y0), gp_min(top + side, y1), side,
                 large ? cluster : NULL, cell);
        b->groups += close_row(g, cell, g->columns, top, side,
                               b->at + b->clusters + b->groups);
    }
}

/* -- the frame ------------------------------------------------------------- */

/* Cells that `size` pixels meet, the first one `before` pixels outside. */
static int cells_over(int before, int size, int side)
{
    return (before + size + side - 1) / side;
}

gp_status gp_polygons_make(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_splat_params *p,
    struct gp_polygons *out)
{
    gp_status st;
    struct gp_polygons o = {0};
    // cells count from pixel (0, 0); the larger cell holds whole smaller ones
    const int step = gp_max(p->group, p->cluster);
    struct grouping g = {
        .src = src, .p = p, .step = step,
        .left = (src->x0 % step + step) % step,
        .above = (src->y0 % step + step) % step,
    };
    g.columns = cells_over(g.left, src->w, p->group);
    g.wide = p->cluster ? cells_over(g.left, src->w, p->cluster) : 0;
    const int bands = cells_over(g.above, src->h, step);
    GP_TRY(gp_alloc_zero(log, "groups", (size_t) bands, sizeof *g.band,
                         &g.band));
    GP_TRY(gp_alloc(log, "groups",
                    (size_t) gp_threads() * (size_t) (g.columns + g.wide),
                    sizeof *g.scratch, &g.scratch));
    GP_TRY(gp_alloc(log, "groups", src->n, sizeof *g.out, &g.out));
    gp_parallel_do(bands, group_band, &g);
    for (int i = 0; i < bands; i++) {
        o.clusters += g.band[i].clusters;
        o.groups += g.band[i].groups;
    }
    GP_TRY(gp_alloc(log, "polygons", o.clusters + o.groups, sizeof *o.at,
                    &o.at));
    struct gp_polygon *cluster = o.at, *group = o.at + o.clusters;
    for (int i = 0; i < bands; i++) {
        const struct band *const b = &g.band[i];
        memcpy(cluster, b->at, b->clusters * sizeof *cluster);
        memcpy(group, b->at + b->clusters, b->groups * sizeof *group);
        cluster += b->clusters;
        group += b->groups;
    }
    o.n = o.clusters + o.groups;
    *out = o;
out:
    gp_free(g.band);
    gp_free(g.scratch);
    gp_free(g.out);
    return st;
}

void gp_polygons_free(struct gp_polygons *p)
{
    gp_free(p->at);
    *p = (struct gp_polygons) {0};
}
