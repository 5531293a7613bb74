#include "glare/bound/cells.h"

#include "core/memory.h"

#include <math.h>

static const double MOST_WORK = 4e6; // multiply-adds of a channel

static int min(int a, int b)
{
    return a < b ? a : b;
}

static int max(int a, int b)
{
    return a > b ? a : b;
}

struct gp_bound_cells gp_cells_choose(int w, int h, const struct gp_kernel *kernel)
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

void gp_cell_table_free(struct gp_cell_table *t)
{
    for (int c = 0; c < 3; c++)
        gp_free(t->at[c]);
    *t = (struct gp_cell_table) {0};
}

// -- the largest of each window ----------------------------------------------

/* Samples of one axis that cell offset d looks at: `far` before and after that
 * of d * side + center, [from, to) of n. */
struct window {
    int center, side; // of the kernel; of cells
    int far;
    int n;            // samples there are
};

static bool look(const struct window *w, int d, int *from, int *to)
{
    *from = max(d * w->side + w->center - w->far, 0);
    *to = min(d * w->side + w->center + w->far + 1, w->n);
    return *from < *to;
}

/* Offsets that meet any sample, within [-(cells - 1), cells - 1]. */
static void offsets(const struct window *w, int cells, int *first, int *n)
{
    int from, to, low = 1 - cells, high = cells;
    while (low < high && !look(w, low, &from, &to))
        low++;
    while (high > low && !look(w, high - 1, &from, &to))
        high--;
    *first = low;
    *n = high - low;
}

/* The largest of each window of a row: n numbers. */
static void reduce_row(const float *row, const struct window *w, int first,
                       int n, float *out)
{
    int from, to;
    for (int i = 0; i < n; i++) {
        out[i] = 0.0f;
        look(w, first + i, &from, &to);
        for (int x = from; x < to; x++)
            out[i] = row[x] > out[i] ? row[x] : out[i];
    }
}

/* The largest of the windows of a plane, first along rows, then down. */
static void reduce(const float *plane, const struct window *x,
                   const struct window *y, const struct gp_cell_table *t,
                   float *rows, double *out)
{
    int from, to;
    const size_t w = (size_t) t->w;
    for (int i = 0; i < y->n; i++)
        reduce_row(plane + (size_t) i * (size_t) x->n, x, t->x0, t->w,
                   rows + (size_t) i * w);
    for (int j = 0; j < t->h; j++) {
        look(y, t->y0 + j, &from, &to);
        for (size_t i = 0; i < w; i++) {
            float v = 0.0f;
            for (int k = from; k < to; k++)
                v = fmaxf(v, rows[(size_t) k * w + i]);
            out[(size_t) j * w + i] = (double) v;
        }
    }
}

/* The table of a kernel's windows. */
static gp_status make_table(const struct gp_log *log,
                            const struct gp_bound_cells *cells,
                            const struct gp_blur *b, const struct window *x,
                            const struct window *y, struct gp_cell_table *out)
{
    gp_status st;
    struct gp_cell_table t = {.channels = b->grey ? 1 : 3};
    void *v, *rows = NULL;
    offsets(x, cells->columns, &t.x0, &t.w);
    offsets(y, cells->rows, &t.y0, &t.h);
    GP_TRY(gp_alloc(log, "bound", (size_t) t.w * (size_t) b->h, sizeof(float),
                    &rows));
    for (int c = 0; c < t.channels; c++) {
        GP_TRY(gp_alloc(log, "bound", (size_t) t.w * (size_t) t.h,
                        sizeof(double), &v));
        t.at[c] = v;
        reduce(b->k.c[c], x, y, &t, rows, t.at[c]);
    }
    *out = t;
    t = (struct gp_cell_table) {0};
out:
    gp_cell_table_free(&t);
    gp_free(rows);
    return st;
}

/* The part of the kernel whose light can go from a pixel of the frame, or one
 * `carry` outside, to another. */
static struct gp_rect crop_of(const struct gp_kernel *k,
                              const struct gp_bound_cells *cells, int carry)
{
    const int x = cells->w + carry, y = cells->h + carry;
    return (struct gp_rect) {
        min(max(k->cx - x, 0), k->w), min(max(k->cy - y, 0), k->h),
        max(min(k->cx + x + 1, k->w), 0), max(min(k->cy + y + 1, k->h), 0),
    };
}

gp_status gp_cell_most(const struct gp_log *log, const struct gp_bound_cells *cells,
                       const struct gp_kernel *kernel, bool tail, int carry,
                       struct gp_cell_table *out)
{
    const int far = cells->side - 1 + carry;
    const struct gp_rect crop = crop_of(kernel, cells, carry);
    struct gp_blur b;
    gp_status st = gp_blur_make(log, kernel, crop, tail, 1, &b);
    if (st)
        return st;
    const struct window x = {kernel->cx - crop.x0, cells->side, far, b.w};
    const struct window y = {kernel->cy - crop.y0, cells->side, far, b.h};
    st = make_table(log, cells, &b, &x, &y, out);
    gp_blur_free(&b);
    return st;
}
