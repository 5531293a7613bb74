/* Bounds the light that polygons lack where shrinking cuts the kernel off, and
 * the least that cells of the frame get. Kernels without lobes. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/bound_priv.h"

#include <math.h>
#include <string.h>

static const double MOST_WORK = 4e6; // multiply-adds of a channel

/* A polygon's light is within a square of twice its cell's side, on the
 * lattice of cells: so at most four of one size share a pixel, and the norm
 * of their sum is at most twice the root of their squares' sum. */
static const double SHARED = 2.0;

/* -- the kernel's largest samples, by cells -------------------------------- */

struct gp_bound_cells gp_bound_cells_choose(int w, int h,
                                            const struct gp_kernel *kernel)
{
    struct gp_bound_cells c = {.w = w, .h = h, .side = 1};
    for (;; c.side *= 2) {
        c.columns = (w + c.side - 1) / c.side;
        c.rows = (h + c.side - 1) / c.side;
        const double across = fmin(2.0 * c.columns, kernel->w / c.side + 2.0);
        const double down = fmin(2.0 * c.rows, kernel->h / c.side + 2.0);
        if ((double) c.columns * c.rows * across * down <= MOST_WORK)
            return c;
    }
}

void gp_bound_table_free(struct gp_bound_table *t)
{
    for (int c = 0; c < 3; c++)
        gp_free(t->at[c]);
    *t = (struct gp_bound_table) {0};
}

/* Samples of one axis that cell offset d looks at: `far` before and after that
 * of d * side + center, [from, to) of n. */
struct window {
    int center, side; // of the kernel; of cells
    int far;
    int n;            // samples there are
};

static bool find_window(const struct window *w, int d, int *from, int *to)
{
    *from = gp_max(d * w->side + w->center - w->far, 0);
    *to = gp_min(d * w->side + w->center + w->far + 1, w->n);
    return *from < *to;
}

/* Offsets that meet any sample, within [-(cells - 1), cells - 1]. */
static void find_offsets(const struct window *w, int cells, int *first, int *n)
{
    int from, to, low = 1 - cells, high = cells;
    while (low < high && !find_window(w, low, &from, &to))
        low++;
    while (high > low && !find_window(w, high - 1, &from, &to))
        high--;
    *first = low;
    *n = high - low;
}

gp_status gp_bound_table_make(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_kernel *kernel,
    enum gp_bound_end end, bool tail, int carry, struct gp_bound_table *out)
{
    gp_status st;
    const bool least = end == GP_BOUND_LEAST;
    const int far = cells->side - 1 + carry, whole = 2 * far + 1;
    const struct gp_rect crop = gp_bound_crop(kernel, cells->w + carry,
                                              cells->h + carry);
    struct gp_blur b = {0};
    struct gp_bound_table t = {.channels = kernel->grey ? 1 : 3};
    float *rows = NULL;
    int from, to;
    GP_TRY(gp_blur_make(log, kernel, crop, tail, 1, &b));
    const struct window x = {kernel->cx - crop.x0, cells->side, far, b.w};
    const struct window y = {kernel->cy - crop.y0, cells->side, far, b.h};
    find_offsets(&x, cells->columns, &t.x0, &t.w);
    find_offsets(&y, cells->rows, &t.y0, &t.h);
    const size_t w = (size_t) t.w;
    GP_TRY(gp_alloc(log, "bound", w * (size_t) b.h, sizeof *rows, &rows));
    for (int c = 0; c < t.channels; c++) {
        GP_TRY(gp_alloc(log, "bound", w * (size_t) t.h, sizeof(double),
                        &t.at[c]));
        // the end of each window, first along rows, then down; the least of
        // one that the kernel does not fill is 0
        for (int i = 0; i < b.h; i++) {
            const float *const row = b.k.c[c] + (size_t) i * (size_t) b.w;
            for (int j = 0; j < t.w; j++) {
                find_window(&x, t.x0 + j, &from, &to);
                float v = least && to - from == whole ? row[from] : 0.0f;
                for (int k = from; k < to; k++)
                    v = (row[k] > v) != least ? row[k] : v;
                rows[(size_t) i * w + (size_t) j] = v;
            }
        }
        for (int j = 0; j < t.h; j++) {
            find_window(&y, t.y0 + j, &from, &to);
            for (size_t i = 0; i < w; i++) {
                const float *const column = rows + i;
                float v = least && to - from == whole
                              ? column[(size_t) from * w] : 0.0f;
                for (int k = from; k < to; k++) {
                    const float u = column[(size_t) k * w];
                    v = (u > v) != least ? u : v;
                }
                t.at[c][(size_t) j * w + i] = (double) v;
            }
        }
    }
    *out = t;
    t = (struct gp_bound_table) {0};
out:
    gp_bound_table_free(&t);
    gp_blur_free(&b);
    gp_free(rows);
    return st;
}

/* -- the most that is left out in a pixel ---------------------------------- */

/* The light of polygons by cell, in planes by ring: plane r holds those that
 * leave something out between cells r apart, max(|dx|, |dy|) = r. */
struct light {
    const struct gp_bound_cells *cells;
    const struct gp_bound_table *table;
    size_t plane;          // rows * columns
    double *at[3];         // planes
    double *line;          // one a thread: columns
    double (*most)[3];     // of each row of cells
};

GP_CLONES static void add_scaled(double *restrict to,
                                 const double *restrict from, int n, double k)
{
    for (int i = 0; i < n; i++)
        to[i] += k * from[i];
}

/* Adds the light that the table spreads from all cells to row y of them.
 *   light  of each cell; plane r of `plane` cells is for those r apart
 *   own    counts a cell's light in itself */
static void add_spread(const struct gp_bound_table *t, int c,
    const struct gp_bound_cells *cells, const double *light, size_t plane,
    bool own, int y, double *line)
{
    const int columns = cells->columns;
    for (int dy = t->y0; dy < t->y0 + t->h; dy++) {
        const double *const k = t->at[t->channels == 1 ? 0 : c] +
                                (size_t) (dy - t->y0) * (size_t) t->w;
        if (y - dy < 0 || y - dy >= cells->rows)
            continue;
        for (int i = 0; i < t->w; i++) {
            const int dx = t->x0 + i, far = gp_max(abs(dx), abs(dy));
            const int from = gp_max(dx, 0), end = columns + gp_min(dx, 0);
            if (k[i] > 0.0 && from < end && (own || far))
                add_scaled(line + from,
                           light + (size_t) far * plane +
                               (size_t) (y - dy) * (size_t) columns +
                               (from - dx),
                           end - from, k[i]);
        }
    }
}

/* Finds the largest of the light that the table spreads to a row of cells. */
static void spread_row(void *ctx, int y, int thread)
{
    const struct light *const l = ctx;
    const int columns = l->cells->columns;
    double *const line = l->line + (size_t) columns * (size_t) thread;
    for (int c = 0; c < 3; c++) {
        memset(line, 0, (size_t) columns * sizeof *line);
        add_spread(l->table, c, l->cells, l->at[c], l->plane, true, y, line);
        l->most[y][c] = 0.0;
        for (int x = 0; x < columns; x++)
            l->most[y][c] = fmax(l->most[y][c], line[x]);
    }
}

/* The farthest from 0 of the n numbers from `first` on. */
static int farthest(int first, int n)
{
    return gp_max(abs(first), abs(first + n - 1));
}

gp_status gp_bound_cells_left(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, const struct gp_bound_table *most,
    double out[3])
{
    gp_status st;
    const int rings = gp_max(farthest(most->x0, most->w),
                             farthest(most->y0, most->h)) + 1;
    struct light l = {
        .cells = cells, .table = most,
        .plane = (size_t) cells->columns * (size_t) cells->rows,
    };
    for (int c = 0; c < 3; c++)
        GP_TRY(gp_alloc_zero(log, "bound", l.plane * (size_t) rings,
                             sizeof(double), &l.at[c]));
    GP_TRY(gp_alloc(log, "bound",
                    (size_t) gp_threads() * (size_t) cells->columns,
                    sizeof *l.line, &l.line));
    GP_TRY(gp_alloc(log, "bound", (size_t) cells->rows, sizeof *l.most,
                    &l.most));
    // each polygon is in the plane of its first ring and, as it leaves these
    // out too, in all farther ones. It leaves nothing out between cells less
    // than reach / side rings apart: (ring + 1) * side is farther than any two
    // of their points
    for (size_t i = 0; i < polygons->n; i++) {
        const struct gp_polygon *const p = &polygons->at[i];
        const int ring = shrink->reach[gp_source_bin(p->light)] / cells->side;
        const double x = floor((double) p->x / cells->side);
        const double y = floor((double) p->y / cells->side);
        const size_t column = (size_t) fmin(fmax(x, 0.0), cells->columns - 1.0);
        const size_t row = (size_t) fmin(fmax(y, 0.0), cells->rows - 1.0);
        const size_t at = (size_t) ring * l.plane +
                          row * (size_t) cells->columns + column;
        for (int c = 0; c < 3 && ring < rings; c++)
            l.at[c][at] += (double) p->rgb[c];
    }
    for (int c = 0; c < 3; c++) {
        for (size_t i = l.plane; i < l.plane * (size_t) rings; i++)
            l.at[c][i] += l.at[c][i - l.plane];
    }
    gp_parallel_do(cells->rows, spread_row, &l);
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int y = 0; y < cells->rows; y++)
            out[c] = fmax(out[c], l.most[y][c]);
        out[c] *= 1.0 + 1e-9; // rounding of the sums
    }
out:
    for (int c = 0; c < 3; c++)
        gp_free(l.at[c]);
    gp_free(l.line);
    gp_free(l.most);
    return st;
}

/* -- the least light of a cell --------------------------------------------- */

struct faint {
    const struct gp_bound_cells *cells;
    const struct gp_bound_table *table;
    double *light;       // of the sources of each cell
    int c;               // channel
    double *out;
};

static void faint_row(void *ctx, int y, int thread)
{
    const struct faint *const f = ctx;
    (void) thread;
    add_spread(f->table, f->c, f->cells, f->light, 0, false, y,
               f->out + (size_t) y * (size_t) f->cells->columns);
}

gp_status gp_bound_cells_faint(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_kernel *kernel,
    const struct gp_sources *src, const double weight[3], double *out)
{
    gp_status st;
    struct gp_bound_table table = {0};
    struct faint f = {.cells = cells, .table = &table, .out = out};
    const size_t n = (size_t) cells->columns * (size_t) cells->rows;
    memset(out, 0, n * sizeof *out);
    GP_TRY(gp_bound_table_make(log, cells, kernel, GP_BOUND_LEAST, false, 0,
                               &table));
    GP_TRY(gp_alloc(log, "bound", n, sizeof *f.light, &f.light));
    for (f.c = 0; f.c < 3; f.c++) {
        if (!(weight[f.c] > 0.0))
            continue;
        memset(f.light, 0, n * sizeof *f.light);
        for (int y = 0; y < src->h; y++) {
            double *const row = f.light + (size_t) (y / cells->side) *
                                              (size_t) cells->columns;
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
                row[src->x[i] / cells->side] +=
                    weight[f.c] * (1.0 - 1e-9) * (double) src->rgb[f.c][i];
        }
        gp_parallel_do(cells->rows, faint_row, &f);
    }
out:
    gp_bound_table_free(&table);
    gp_free(f.light);
    return st;
}

/* -- the kernel by rings --------------------------------------------------- */

gp_status gp_bound_rings_make(const struct gp_log *log,
                              const struct gp_kernel *k, bool tail, int w,
                              int h, struct gp_bound_rings *out)
{
    gp_status st = GP_OK;
    struct gp_bound_rings r = {0};
    const struct gp_rect crop = gp_bound_crop(k, w, h);
    r.n = gp_rect_empty(crop) ? 0 : gp_max(w, h) + 1;
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc_zero(log, "bound", (size_t) r.n + 1, sizeof(double),
                             &r.beyond[c]));
        double *const beyond = r.beyond[c];
        if (c > 0 && k->grey) {
            memcpy(beyond, r.beyond[0], ((size_t) r.n + 1) * sizeof(double));
            r.slope[c] = r.slope[0];
            continue;
        }
        for (int y = crop.y0; y < crop.y1; y++) {
            for (int x = crop.x0; x < crop.x1; x++)
                beyond[gp_max(abs(x - k->cx), abs(y - k->cy))] +=
                    (double) gp_bound_sample(k, tail, c, x, y);
        }
        for (int i = r.n - 1; i >= 0; i--)
            beyond[i] += beyond[i + 1];
        for (int y = crop.y0 - 1; r.n && y < crop.y1; y++) {
            for (int x = crop.x0 - 1; x < crop.x1; x++) {
                const double s = (double) gp_bound_sample(k, tail, c, x, y);
                r.slope[c] +=
                    fabs((double) gp_bound_sample(k, tail, c, x + 1, y) - s) +
                    fabs((double) gp_bound_sample(k, tail, c, x, y + 1) - s);
            }
        }
    }
    *out = r;
    r = (struct gp_bound_rings) {0};
out:
    gp_bound_rings_free(&r);
    return st;
}

void gp_bound_rings_free(struct gp_bound_rings *r)
{
    for (int c = 0; c < 3; c++)
        gp_free(r->beyond[c]);
    *r = (struct gp_bound_rings) {0};
}

/* -- all that is left out -------------------------------------------------- */

/* Sum of squares of a polygon's bilinear and box weights on one axis. */
static double spread_square(const struct gp_polygon *p, float at)
{
    const int m = gp_blur_box[p->blur];
    const double start = (double) at - (m - 1) / 2.0;
    const double f = start - floor(start);
    return ((1.0 - f) * (1.0 - f) + f * f + (m - 1)) / ((double) m * m);
}

gp_status gp_bound_rings_left(const struct gp_log *log,
    const struct gp_bound_rings *r, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double sum[3], double norm[3])
{
    const size_t n = (size_t) r->n;
    double *left; // by the first ring that polygons leave out: n of their
                  // light, n of the squares of its norm
    gp_status st = gp_alloc(log, "bound", 2 * n, sizeof *left, &left);
    if (st)
        return st;
    for (int c = 0; c < 3; c++) {
        sum[c] = norm[c] = 0.0;
        for (int size = 0; size < 2; size++) { // clusters, groups
            memset(left, 0, 2 * n * sizeof *left);
            const size_t end = size ? polygons->n : polygons->clusters;
            for (size_t i = size ? polygons->clusters : 0; i < end; i++) {
                const struct gp_polygon *const p = &polygons->at[i];
                const int reach = shrink->reach[gp_source_bin(p->light)];
                // half a box and a pixel between pixels carry light that far
                const int ring = gp_max(reach - gp_blur_box[p->blur] / 2, 0);
                const double light = (double) p->rgb[c];
                if (ring >= r->n)
                    continue;
                left[ring] += light;
                left[n + (size_t) ring] += light * light *
                                           spread_square(p, p->x) *
                                           spread_square(p, p->y);
            }
            double square = 0.0;
            for (size_t i = 0; i < n; i++) {
                square += left[n + i]; // all that leave ring i out
                sum[c] += left[i] * r->beyond[c][i];
                norm[c] += (r->beyond[c][i] - r->beyond[c][i + 1]) * SHARED *
                           sqrt(square);
            }
        }
    }
    gp_free(left);
    return GP_OK;
}

void gp_bound_rings_sampled(const struct gp_bound_rings *r,
    const struct gp_polygons *polygons, double place, double norm[3])
{
    for (int c = 0; c < 3; c++) {
        double square[2][2] = {{0}}; // clusters, groups; blurred ones
        for (size_t i = 0; i < polygons->n; i++) {
            const struct gp_polygon *const p = &polygons->at[i];
            const int m = gp_blur_box[p->blur];
            if (m == 1 && p->x == floorf(p->x) && p->y == floorf(p->y))
                continue; // fetched, not sampled
            // a slope is the box's of whole pixels on its axis
            const double v = (double) p->rgb[c] / m;
            square[i >= polygons->clusters][m > 1] += v * v;
        }
        // one that is not blurred is within its own cell
        norm[c] = place * r->slope[c] *
                  (sqrt(square[0][0]) + sqrt(square[1][0]) +
                   SHARED * (sqrt(square[0][1]) + sqrt(square[1][1])));
    }
}
