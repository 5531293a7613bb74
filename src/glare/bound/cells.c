#include "glare/bound/cells.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The light of polygons by cell, in planes by ring: plane r holds those that
 * leave something out between cells r apart, max(|dx|, |dy|) = r. */
struct light {
    const struct gp_bound_cells *cells;
    int rings;
    double *at[3];   // rings * rows * columns
};

static size_t plane_of(const struct gp_bound_cells *c)
{
    return (size_t) c->columns * (size_t) c->rows;
}

static gp_status make_light(const struct gp_log *log,
                            const struct gp_bound_cells *cells, int rings,
                            struct light *l)
{
    *l = (struct light) {.cells = cells, .rings = rings};
    for (int c = 0; c < 3; c++) {
        void *v;
        const gp_status st = gp_alloc_zero(
            log, "bound", plane_of(cells) * (size_t) rings, sizeof(double),
            &v);
        if (st)
            return st;
        l->at[c] = v;
    }
    return GP_OK;
}

static void free_light(struct light *l)
{
    for (int c = 0; c < 3; c++)
        gp_free(l->at[c]);
}

// -- sums over a table --------------------------------------------------------

struct spreading {
    const struct light *light;
    const struct gp_cell_table *table;
    double *line;          // one a thread: columns
    double (*most)[3];     // of each row of cells
};

GP_CLONES static void add_scaled(double *restrict to,
                                 const double *restrict from, int n, double k)
{
    for (int i = 0; i < n; i++)
        to[i] += k * from[i];
}

/* What source row `sy` adds to a row of targets `dy` further down. */
static void add_source_row(const struct spreading *s, int c, int sy, int dy,
                           double *line)
{
    const struct gp_bound_cells *const cells = s->light->cells;
    const struct gp_cell_table *const t = s->table;
    const double *const k =
        t->at[t->channels == 1 ? 0 : c] + (size_t) (dy - t->y0) * (size_t) t->w;
    for (int i = 0; i < t->w; i++) {
        const int dx = t->x0 + i;
        const int far = abs(dx) > abs(dy) ? abs(dx) : abs(dy);
        const int from = dx > 0 ? dx : 0;
        const int end = cells->columns + (dx < 0 ? dx : 0);
        if (k[i] > 0.0 && from < end)
            add_scaled(line + from,
                       s->light->at[c] + (size_t) far * plane_of(cells) +
                           (size_t) sy * (size_t) cells->columns + (from - dx),
                       end - from, k[i]);
    }
}

static void spread_row(void *ctx, int y, int thread)
{
    const struct spreading *const s = ctx;
    const struct gp_cell_table *const t = s->table;
    const int columns = s->light->cells->columns;
    double *const line = s->line + (size_t) columns * (size_t) thread;
    for (int c = 0; c < 3; c++) {
        memset(line, 0, (size_t) columns * sizeof *line);
        for (int dy = t->y0; dy < t->y0 + t->h; dy++) {
            if (y - dy >= 0 && y - dy < s->light->cells->rows)
                add_source_row(s, c, y - dy, dy, line);
        }
        s->most[y][c] = 0.0;
        for (int x = 0; x < columns; x++)
            s->most[y][c] = fmax(s->most[y][c], line[x]);
    }
}

/* The largest of the light spread by the table, over all cells. */
static gp_status spread(const struct gp_log *log, const struct light *light,
                        const struct gp_cell_table *table, double out[3])
{
    void *line = NULL, *most = NULL;
    gp_status st;
    const int rows = light->cells->rows;
    struct spreading s = {.light = light, .table = table};
    GP_TRY(gp_alloc(log, "bound", (size_t) gp_threads() *
                                      (size_t) light->cells->columns,
                    sizeof *s.line, &line));
    GP_TRY(gp_alloc(log, "bound", (size_t) rows, sizeof *s.most, &most));
    s.line = line;
    s.most = most;
    gp_parallel_do(rows, spread_row, &s);
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int y = 0; y < rows; y++)
            out[c] = fmax(out[c], s.most[y][c]);
        out[c] *= 1.0 + 1e-9; // rounding of the sums
    }
out:
    gp_free(line);
    gp_free(most);
    return st;
}

// -- polygons -----------------------------------------------------------------

/* The cell of a polygon. */
static size_t cell_of(const struct gp_bound_cells *cells, const struct gp_polygon *p)
{
    const int x = (int) fmin(fmax(floor((double) p->x / cells->side), 0.0),
                             cells->columns - 1.0);
    const int y = (int) fmin(fmax(floor((double) p->y / cells->side), 0.0),
                             cells->rows - 1.0);
    return (size_t) y * (size_t) cells->columns + (size_t) x;
}

/* A polygon of that reach leaves nothing out between cells less than this many
 * rings apart: (ring + 1) * side is farther than any two of their points. */
static int first_ring(const struct gp_bound_cells *cells, int reach)
{
    return reach / cells->side;
}

static int farthest(int first, int n)
{
    return abs(first) > abs(first + n - 1) ? abs(first) : abs(first + n - 1);
}

/* Fills the planes: each polygon is in that of its first ring and, as it
 * leaves these out too, in all farther ones. */
static void fill(const struct gp_polygons *polygons,
                 const struct gp_shrink *shrink, const struct light *l)
{
    const size_t plane = plane_of(l->cells);
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const p = &polygons->at[i];
        const int ring =
            first_ring(l->cells, shrink->reach[gp_source_bin(p->light)]);
        const size_t at = (size_t) ring * plane + cell_of(l->cells, p);
        for (int c = 0; c < 3 && ring < l->rings; c++)
            l->at[c][at] += (double) p->rgb[c];
    }
    for (int c = 0; c < 3; c++) {
        for (size_t i = plane; i < plane * (size_t) l->rings; i++)
            l->at[c][i] += l->at[c][i - plane];
    }
}

gp_status gp_cells_left(const struct gp_log *log,
                        const struct gp_bound_cells *cells,
                        const struct gp_polygons *polygons,
                        const struct gp_shrink *shrink,
                        const struct gp_cell_table *most, double out[3])
{
    struct light l;
    const int x = farthest(most->x0, most->w);
    const int y = farthest(most->y0, most->h);
    gp_status st = make_light(log, cells, (x > y ? x : y) + 1, &l);
    if (!st) {
        fill(polygons, shrink, &l);
        st = spread(log, &l, most, out);
    }
    free_light(&l);
    return st;
}
