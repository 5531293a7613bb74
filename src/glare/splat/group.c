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
    size_t clusters, groups;           // counts
    size_t first_cluster, first_group; // places of the first ones
};

struct grouping {
    const struct gp_sources *src;
    const struct gp_splat_params *p;
    int step;            // rows of a band: the larger cell's side
    int left, above;     // pixels of the first cell outside the window
    int group_shift, cluster_shift; // log2 of the cells' sides
    int columns;         // group cells in a row
    int wide;            // cluster cells in a row
    struct band *band;
    struct cell_sum *scratch; // for each thread: columns + wide
    struct gp_polygon *out;   // NULL while counting
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

/* Writes the cells of a row that hold light. */
static void close_row(const struct grouping *g, const struct cell_sum *cell,
                      int cells, int y0, int side, struct gp_polygon *out)
{
    for (int k = 0; k < cells; k++) {
        if (cell[k].sources)
            *out++ = close_cell(&cell[k], k * side - g->left, y0, side);
    }
}

/* -- one band -------------------------------------------------------------- */

/* Returns the end of the sources from i on, in row y, in the same cell. */
static uint32_t run_end(const struct grouping *g, uint32_t i, int y, int shift)
{
    const int cell = (g->src->x[i] + g->left) >> shift;
    const int beyond = ((cell + 1) << shift) - g->left;
    const uint32_t end = g->src->row[y + 1];
    while (++i < end && g->src->x[i] < beyond)
        continue;
    return i;
}

static bool is_clustered(const struct grouping *g,
                         const struct cell_sum *cluster, int x)
{
    return g->wide && cluster[(x + g->left) >> g->cluster_shift].sources;
}

/* Sums what clusters leave of the rows [y0, y1) into one row of group cells,
 * or only counts. Returns how many cells hold light. */
static size_t add_to_groups(const struct grouping *g, int y0, int y1,
    const struct cell_sum *cluster, struct cell_sum *cell)
{
    const int shift = g->group_shift, mask = g->p->group - 1;
    size_t n = 0;
    memset(cell, 0, (size_t) g->columns * sizeof *cell);
    for (int y = y0; y < y1; y++) {
        uint32_t i = g->src->row[y], end;
        for (; i < g->src->row[y + 1]; i = end) {
            const int at = (g->src->x[i] + g->left) >> shift;
            end = run_end(g, i, y, shift);
            if (is_clustered(g, cluster, g->src->x[i]))
                continue;
            n += cell[at].sources == 0;
            if (g->out)
                add_sources(g->src, i, end, g->left - (at << shift),
                            (y + g->above) & mask, &cell[at]);
            else
                cell[at].sources++;
        }
    }
    return n;
}

/* Counts the band's polygons, or makes them when `out` is set. */
static void group_band(void *ctx, int i, int thread)
{
    const struct grouping *const g = ctx;
    struct cell_sum *const cell =
        g->scratch + (size_t) (g->columns + g->wide) * (size_t) thread;
    struct cell_sum *const cluster = cell + g->columns;
    struct band *const b = &g->band[i];
    const int side = g->p->group, start = i * g->step - g->above;
    const int y0 = gp_max(0, start), y1 = gp_min(g->src->h, start + g->step);
    const int large = g->p->cluster, shift = g->cluster_shift;
    // the sources of each cluster cell; none where it is not filled
    memset(cluster, 0, (size_t) g->wide * sizeof *cluster);
    for (int y = y0; large && y < y1; y++) {
        uint32_t k = g->src->row[y], end;
        for (; k < g->src->row[y + 1]; k = end) {
            end = run_end(g, k, y, shift);
            cluster[(g->src->x[k] + g->left) >> shift].sources +=
                (int) (end - k);
        }
    }
    b->clusters = 0;
    for (int k = 0; k < g->wide; k++) {
        const int x0 = gp_max(0, k * large - g->left);
        const int x1 = gp_min(g->src->w, (k + 1) * large - g->left);
        // in float, as the shaders decide it
        const float area = (float) ((x1 - x0) * (y1 - y0));
        if ((float) cluster[k].sources >= g->p->cluster_fill * area)
            b->clusters++;
        else
            cluster[k].sources = 0;
    }
    b->groups = 0;
    for (int top = start; top < y1; top += side) {
        struct gp_polygon *out =
            g->out ? g->out + b->first_group + b->groups : NULL;
        if (top + side <= y0)
            continue;
        if (side > 1) {
            b->groups += add_to_groups(g, gp_max(top, y0),
                                       gp_min(top + side, y1), cluster, cell);
            if (out)
                close_row(g, cell, g->columns, top, side, out);
            continue;
        }
        // single sensors that no cluster holds: no sum is needed
        for (uint32_t k = g->src->row[top]; k < g->src->row[top + 1]; k++) {
            const int x = g->src->x[k];
            if (is_clustered(g, cluster, x))
                continue;
            if (out) {
                struct cell_sum own = {0};
                add_sources(g->src, k, k + 1, -x, 0, &own);
                *out++ = close_cell(&own, x, top, 1);
            }
            b->groups++;
        }
    }
    if (!g->out || !b->clusters)
        return;
    const int mask = large - 1;
    for (int y = y0; y < y1; y++) { // sums into the filled cells
        const uint32_t past = g->src->row[y + 1];
        for (uint32_t k = g->src->row[y], end; k < past; k = end) {
            const int at = (g->src->x[k] + g->left) >> shift;
            end = run_end(g, k, y, shift);
            if (cluster[at].sources)
                add_sources(g->src, k, end, g->left - (at << shift),
                            (y + g->above) & mask, &cluster[at]);
        }
    }
    close_row(g, cluster, g->wide, start, large, g->out + b->first_cluster);
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
        .group_shift = __builtin_ctz((unsigned) p->group),
        .cluster_shift = p->cluster ? __builtin_ctz((unsigned) p->cluster) : 0,
    };
    g.columns = p->group > 1 ? cells_over(g.left, src->w, p->group) : 0;
    g.wide = p->cluster ? cells_over(g.left, src->w, p->cluster) : 0;
    const int bands = cells_over(g.above, src->h, step);
    GP_TRY(gp_alloc_zero(log, "groups", (size_t) bands, sizeof *g.band,
                         &g.band));
    GP_TRY(gp_alloc(log, "groups",
                    (size_t) gp_threads() * (size_t) (g.columns + g.wide),
                    sizeof *g.scratch, &g.scratch));
    gp_parallel_do(bands, group_band, &g);
    for (int i = 0; i < bands; i++) { // every band gets its place
        g.band[i].first_cluster = o.clusters;
        o.clusters += g.band[i].clusters;
    }
    for (int i = 0; i < bands; i++) {
        g.band[i].first_group = o.clusters + o.groups;
        o.groups += g.band[i].groups;
    }
    o.n = o.clusters + o.groups;
    GP_TRY(gp_alloc(log, "polygons", o.n, sizeof *o.at, &o.at));
    g.out = o.at;
    if (o.n)
        gp_parallel_do(bands, group_band, &g);
    *out = o;
out:
    gp_free(g.band);
    gp_free(g.scratch);
    return st;
}

void gp_polygons_free(struct gp_polygons *p)
{
    gp_free(p->at);
    *p = (struct gp_polygons) {0};
}
