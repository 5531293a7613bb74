#include "glare/splat/group.h"

#include "core/memory.h"
#include "core/parallel.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

const int gp_blur_box[GP_BLURS] = {1, 2, 3, 4, 6, 8, 12, 16, 32, 64};

/* Sums over one block, positions from its corner. */
struct cell {
    double light, x, y, square; // of luminance, and times x, y, x^2 + y^2
    double rgb[3];
    int sources;
};

/* What one row of the largest blocks makes. */
struct band {
    size_t clusters, groups;           // how many
    size_t first_cluster, first_group; // where they go
};

struct grouping {
    const struct gp_sources *src;
    const struct gp_splat_params *p;
    int step;            // rows of a band: the larger block's side
    int left, above;     // pixels of the first block outside the window
    int columns;         // group blocks in a row
    int wide;            // cluster blocks in a row
    struct band *band;
    struct cell *scratch; // for each thread: columns + wide
    struct gp_polygon *out; // NULL while counting
};

/* v modulo n in [0, n). */
static int wrap(int v, int n)
{
    return (v % n + n) % n;
}

static int blocks(int before, int size, int side)
{
    return (before + size + side - 1) / side;
}

static int min(int a, int b)
{
    return a < b ? a : b;
}

static int max(int a, int b)
{
    return a > b ? a : b;
}

// -- blocks -------------------------------------------------------------------

static int log2_of(int side)
{
    int shift = 0;
    while (1 << shift < side)
        shift++;
    return shift;
}

/* Adds sources [i, end), which lie in one row of a block: `dx` is to be added
 * to their columns, and they are `dy` rows under its first row. */
static void add_sources(const struct gp_sources *src, uint32_t i, uint32_t end,
                        int dx, int dy, struct cell *cell)
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
        y = y > 0.0 ? y : 0.0; // weights of unreal primaries
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

/* What box and bilinear sampling at p spread the light by. */
static double spread(int side, float x, float y)
{
    const double shift = (side - 1) / 2.0;
    const double u = (double) x - shift, v = (double) y - shift;
    const double fx = u - floor(u), fy = v - floor(v);
    return (side * side - 1) / 12.0 +
           (fx * (1.0 - fx) + fy * (1.0 - fy)) / 2.0;
}

static uint8_t choose_blur(double variance, const struct gp_polygon *p)
{
    int best = 0;
    double least = INFINITY;
    for (int b = 0; b < GP_BLURS && gp_blur_box[b] <= p->side; b++) {
        const double off = fabs(spread(gp_blur_box[b], p->x, p->y) - variance);
        if (off < least) {
            least = off;
            best = b;
        }
    }
    return (uint8_t) best;
}

static float to_float(double v)
{
    return (float) fmin(v, (double) FLT_MAX);
}

/* The block whose corner is pixel (x0, y0) as a polygon. */
static struct gp_polygon close_block(const struct cell *cell, int x0, int y0,
                                     int side, enum gp_group_method method)
{
    double x = (side - 1) / 2.0, y = x, variance = 0.0;
    if (cell->light > 0.0) {
        x = cell->x / cell->light;
        y = cell->y / cell->light;
        variance = (cell->square / cell->light - x * x - y * y) / 2.0;
    }
    struct gp_polygon p = {
        .x = (float) (x0 + x), .y = (float) (y0 + y),
        .light = to_float(cell->light), .side = (uint8_t) side,
    };
    for (int c = 0; c < 3; c++)
        p.rgb[c] = to_float(cell->rgb[c]);
    if (method != GP_GROUP_CENTROID)
        p.blur = choose_blur(variance, &p);
    return p;
}

// -- one band -----------------------------------------------------------------

/* Rows of the frame that lie in band i. */
static void band_rows(const struct grouping *g, int i, int *y0, int *y1)
{
    *y0 = max(0, i * g->step - g->above);
    *y1 = min(g->src->h, (i + 1) * g->step - g->above);
}

/* The end of the sources from i on, in row y, that lie in the same block. */
static uint32_t run_end(const struct grouping *g, uint32_t i, int y, int shift)
{
    const int block = (g->src->x[i] + g->left) >> shift;
    const int beyond = ((block + 1) << shift) - g->left;
    const uint32_t end = g->src->row[y + 1];
    while (++i < end && g->src->x[i] < beyond)
        continue;
    return i;
}

/* Counts the sources of each cluster area and clears the counts of those
 * that are not filled. `wide` cells. */
static size_t find_clusters(const struct grouping *g, int y0, int y1,
                            struct cell *cluster)
{
    const int side = g->p->cluster, shift = log2_of(max(side, 1));
    memset(cluster, 0, (size_t) g->wide * sizeof *cluster);
    if (!side)
        return 0;
    for (int y = y0; y < y1; y++) {
        uint32_t i = g->src->row[y], end;
        for (; i < g->src->row[y + 1]; i = end) {
            end = run_end(g, i, y, shift);
            cluster[(g->src->x[i] + g->left) >> shift].sources +=
                (int) (end - i);
        }
    }
    size_t n = 0;
    for (int k = 0; k < g->wide; k++) {
        const int x0 = max(0, k * side - g->left);
        const int x1 = min(g->src->w, (k + 1) * side - g->left);
        // in float, as the shaders decide it
        const float area = (float) ((x1 - x0) * (y1 - y0));
        if ((float) cluster[k].sources >= g->p->cluster_fill * area)
            n++;
        else
            cluster[k].sources = 0;
    }
    return n;
}

static bool is_clustered(const struct grouping *g, const struct cell *cluster,
                         int shift, int x)
{
    return g->wide && cluster[(x + g->left) >> shift].sources;
}

/* Sums the rows [y0, y1) into the filled areas. */
static void add_to_clusters(const struct grouping *g, int y0, int y1,
                            struct cell *cluster)
{
    const int shift = log2_of(g->p->cluster), mask = g->p->cluster - 1;
    for (int y = y0; y < y1; y++) {
        uint32_t i = g->src->row[y], end;
        for (; i < g->src->row[y + 1]; i = end) {
            const int block = (g->src->x[i] + g->left) >> shift;
            end = run_end(g, i, y, shift);
            if (cluster[block].sources)
                add_sources(g->src, i, end, g->left - (block << shift),
                            (y + g->above) & mask, &cluster[block]);
        }
    }
}

/* Sums what clusters leave of the rows [y0, y1) into one row of group blocks,
 * or counts alone. Returns how many blocks hold light. */
static size_t add_to_groups(const struct grouping *g, int y0, int y1,
                            const struct cell *cluster, struct cell *cell)
{
    const int shift = log2_of(g->p->group), mask = g->p->group - 1;
    const int wide = log2_of(max(g->p->cluster, 1));
    size_t n = 0;
    memset(cell, 0, (size_t) g->columns * sizeof *cell);
    for (int y = y0; y < y1; y++) {
        uint32_t i = g->src->row[y], end;
        for (; i < g->src->row[y + 1]; i = end) {
            const int block = (g->src->x[i] + g->left) >> shift;
            end = run_end(g, i, y, shift);
            if (is_clustered(g, cluster, wide, g->src->x[i]))
                continue;
            n += cell[block].sources == 0;
            if (g->out)
                add_sources(g->src, i, end, g->left - (block << shift),
                            (y + g->above) & mask, &cell[block]);
            else
                cell[block].sources++;
        }
    }
    return n;
}

/* Single sensors of a row that no cluster holds: no sum is needed. */
static size_t take_singles(const struct grouping *g, int y,
                           const struct cell *cluster, struct gp_polygon *out)
{
    const int wide = log2_of(max(g->p->cluster, 1));
    size_t n = 0;
    for (uint32_t i = g->src->row[y]; i < g->src->row[y + 1]; i++) {
        const int x = g->src->x[i];
        if (is_clustered(g, cluster, wide, x))
            continue;
        if (out) {
            struct cell cell = {0};
            add_sources(g->src, i, i + 1, -x, 0, &cell);
            out[n] = close_block(&cell, x, y, 1, GP_GROUP_CENTROID);
        }
        n++;
    }
    return n;
}

/* Writes the blocks that hold light. */
static void close_row(const struct grouping *g, const struct cell *cell,
                        int cells, int y0, int side, struct gp_polygon *out)
{
    for (int k = 0; k < cells; k++) {
        if (cell[k].sources)
            *out++ = close_block(&cell[k], k * side - g->left, y0, side,
                                 g->p->method);
    }
}

/* The band's group blocks, row after row; returns how many hold light. */
static size_t do_groups(const struct grouping *g, int i, int y0, int y1,
                        const struct cell *cluster, struct cell *cell)
{
    const int side = g->p->group;
    struct gp_polygon *const out = g->out ? g->out + g->band[i].first_group
                                          : NULL;
    size_t n = 0;
    for (int top = i * g->step - g->above; top < y1; top += side) {
        struct gp_polygon *const to = out ? out + n : NULL;
        if (top + side <= y0)
            continue;
        if (side == 1) {
            n += take_singles(g, top, cluster, to);
            continue;
        }
        n += add_to_groups(g, max(top, y0), min(top + side, y1), cluster,
                           cell);
        if (to)
            close_row(g, cell, g->columns, top, side, to);
    }
    return n;
}

/* Counts the band's polygons, or makes them when there is a place to put
 * them. */
static void do_band(void *ctx, int i, int thread)
{
    const struct grouping *const g = ctx;
    struct cell *const cell =
        g->scratch + (size_t) (g->columns + g->wide) * (size_t) thread;
    struct cell *const cluster = cell + g->columns;
    struct band *const b = &g->band[i];
    int y0, y1;
    band_rows(g, i, &y0, &y1);
    b->clusters = find_clusters(g, y0, y1, cluster);
    b->groups = do_groups(g, i, y0, y1, cluster, cell);
    if (!g->out || !b->clusters)
        return;
    add_to_clusters(g, y0, y1, cluster);
    close_row(g, cluster, g->wide, i * g->step - g->above, g->p->cluster,
              g->out + b->first_cluster);
}

// -- the frame ----------------------------------------------------------------

/* Gives every band its place; returns the number of polygons. */
static size_t place(struct grouping *g, int bands, struct gp_polygons *out)
{
    for (int i = 0; i < bands; i++) {
        g->band[i].first_cluster = out->clusters;
        out->clusters += g->band[i].clusters;
    }
    for (int i = 0; i < bands; i++) {
        g->band[i].first_group = out->clusters + out->groups;
        out->groups += g->band[i].groups;
    }
    out->n = out->clusters + out->groups;
    return out->n;
}

gp_status gp_group(const struct gp_log *log, const struct gp_sources *src,
                   const struct gp_splat_params *p, struct gp_polygons *out)
{
    gp_status st;
    void *band = NULL, *scratch = NULL, *at = NULL;
    struct gp_polygons o = {0};
    struct grouping g = {.src = src, .p = p, .step = max(p->group, p->cluster)};
    // blocks count from pixel (0, 0); the larger block holds whole smaller ones
    g.left = wrap(src->x0, g.step);
    g.above = wrap(src->y0, g.step);
    g.columns = p->group > 1 ? blocks(g.left, src->w, p->group) : 0;
    g.wide = p->cluster ? blocks(g.left, src->w, p->cluster) : 0;
    const int bands = blocks(g.above, src->h, g.step);
    GP_TRY(gp_alloc_zero(log, "groups", (size_t) bands, sizeof *g.band, &band));
    GP_TRY(gp_alloc(log, "groups",
                    (size_t) gp_threads() * (size_t) (g.columns + g.wide),
                    sizeof *g.scratch, &scratch));
    g.band = band;
    g.scratch = scratch;
    gp_parallel_do(bands, do_band, &g);
    GP_TRY(gp_alloc(log, "polygons", place(&g, bands, &o), sizeof *o.at, &at));
    g.out = o.at = at;
    if (o.n)
        gp_parallel_do(bands, do_band, &g);
    *out = o;
out:
    gp_free(band);
    gp_free(scratch);
    return st;
}

void gp_polygons_free(struct gp_polygons *p)
{
    gp_free(p->at);
    *p = (struct gp_polygons) {0};
}
