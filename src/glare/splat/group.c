// SPDX-License-Identifier: Apache-2.0
#include "core/memory.h"
#include "core/minmax.h"
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

struct grouping {
    const struct gp_sources *src;
    const struct gp_splat_params *p;
    struct gp_cells bands;    // of the larger cell's side
    int columns;              // cells of groups in a row
    int wide;                 // cells of clusters in a row
    struct cell_sum *cell;    // columns, then wide
    struct gp_polygon *group; // room for src->n
    struct gp_polygons out;   // with room for as many
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
            out[n++] = close_cell(&cell[k], k * side + g->bands.x, y0, side);
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
            const int in = x[i] - g->bands.x, at = in / side;
            const int beyond = (at + 1) * side + g->bands.x;
            for (end = i + 1; end < past && x[end] < beyond;)
                end++;
            if (!cluster || !cluster[in / g->p->cluster].sources)
                add_sources(g->src, i, end, -g->bands.x - at * side,
                            (y - g->bands.y) % side, &cell[at]);
        }
    }
}

static void group_band(struct grouping *g, int i)
{
    struct cell_sum *const cell = g->cell, *const cluster = cell + g->columns;
    struct gp_polygons *const o = &g->out;
    const int side = g->p->group, large = g->p->cluster;
    const int start = i * g->bands.side + g->bands.y;
    const int y0 = gp_max(0, start);
    const int y1 = gp_min(g->src->h, start + g->bands.side);
    memset(cluster, 0, (size_t) g->wide * sizeof *cluster);
    if (large)
        add_rows(g, y0, y1, large, NULL, cluster);
    for (int k = 0; k < g->wide; k++) {
        const int x0 = gp_max(0, k * large + g->bands.x);
        const int x1 = gp_min(g->src->w, (k + 1) * large + g->bands.x);
        // in float, as the shaders decide it
        const float area = (float) ((x1 - x0) * (y1 - y0));
        if (!((float) cluster[k].sources >= g->p->cluster_fill * area))
            cluster[k].sources = 0;
    }
    o->clusters +=
        close_row(g, cluster, g->wide, start, large, o->at + o->clusters);
    for (int top = start; top < y1; top += side) {
        if (top + side <= y0)
            continue;
        memset(cell, 0, (size_t) g->columns * sizeof *cell);
        add_rows(g, gp_max(top, y0), gp_min(top + side, y1), side,
                 large ? cluster : NULL, cell);
        o->groups +=
            close_row(g, cell, g->columns, top, side, g->group + o->groups);
    }
}

/* -- the frame ------------------------------------------------------------- */

struct gp_cells gp_cells_over(const struct gp_sources *src, int side)
{
    struct gp_cells c = {
        .side = side,
        .x = -((src->x0 % side + side) % side),
        .y = -((src->y0 % side + side) % side),
    };
    c.w = (src->w - c.x + side - 1) / side;
    c.h = (src->h - c.y + side - 1) / side;
    return c;
}

gp_status gp_polygons_make(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_splat_params *p,
    struct gp_polygons *out)
{
    gp_status st;
    // the larger cell holds whole smaller ones
    struct grouping g = {
        .src = src,
        .p = p,
        .bands = gp_cells_over(src, gp_max(p->group, p->cluster)),
    };
    g.columns = g.bands.w * (g.bands.side / p->group);
    g.wide = p->cluster ? g.bands.w : 0;
    GP_TRY(gp_alloc(log, "groups", (size_t) (g.columns + g.wide),
                    sizeof *g.cell, &g.cell));
    GP_TRY(gp_alloc(log, "groups", src->n, sizeof *g.group, &g.group));
    GP_TRY(gp_alloc(log, "polygons", src->n, sizeof *g.out.at, &g.out.at));
    for (int i = 0; i < g.bands.h; i++)
        group_band(&g, i);
    memcpy(g.out.at + g.out.clusters, g.group, g.out.groups * sizeof *g.group);
    g.out.n = g.out.clusters + g.out.groups;
    *out = g.out;
    g.out.at = NULL;
out:
    gp_free(g.cell);
    gp_free(g.group);
    gp_free(g.out.at);
    return st;
}
