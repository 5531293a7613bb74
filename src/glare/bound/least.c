/* The least that the exact layer can be: see bound.h. */
#include "glare/bound/bound.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/state.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Two scales of cells, in pixels. NEAR_REACH near cells to each side cover
 * just what far cells that touch would. */
enum { NEAR = 4, FAR = 16, NEAR_REACH = 4, FAR_FROM = 2 };

static int min(int a, int b)
{
    return a < b ? a : b;
}

static int max(int a, int b)
{
    return a > b ? a : b;
}

static int clamp(int v, int low, int high)
{
    return max(low, min(v, high));
}

// -- sums over rectangles of the kernel ---------------------------------------

/* Sum of kernel offsets [x0, x1) x [y0, y1), from an integral image. */
static double rect_sum(const struct gp_kernel *k, const double *integral,
                       int x0, int y0, int x1, int y1)
{
    const size_t pitch = (size_t) k->w + 1;
    const size_t left = (size_t) clamp(x0 + k->cx, 0, k->w);
    const size_t right = (size_t) clamp(x1 + k->cx, 0, k->w);
    const size_t top = (size_t) clamp(y0 + k->cy, 0, k->h) * pitch;
    const size_t low = (size_t) clamp(y1 + k->cy, 0, k->h) * pitch;
    return integral[low + right] - integral[low + left] -
           integral[top + right] + integral[top + left];
}

static gp_status make_integral(const struct gp_log *log,
                               const struct gp_kernel *k, int c, bool square,
                               double **out)
{
    void *v;
    const size_t pitch = (size_t) k->w + 1;
    gp_status st = gp_alloc_zero(log, "bound", pitch * ((size_t) k->h + 1),
                                 sizeof **out, &v);
    if (st)
        return st;
    double *const sum = v;
    for (int y = 0; y < k->h; y++) {
        const float *const in = k->k.c[c] + (size_t) y * (size_t) k->w;
        double *const to = sum + ((size_t) y + 1) * pitch;
        double row = 0.0;
        for (int x = 0; x < k->w; x++) {
            const double s = (double) in[x];
            row += square ? s * s : s;
            to[x + 1] = to[(size_t) x + 1 - pitch] + row;
        }
    }
    *out = sum;
    return GP_OK;
}

/* The least mean over a NEAR cell of light from anywhere in a cell of `side`
 * whose corner is (dx, dy) pixels left and above of the nearest such cell that
 * lies in the same place of a cell of `side`. */
static double least_mean(const struct gp_kernel *k, const double *sum, int dx,
                         int dy, int side)
{
    double least = INFINITY;
    for (int y = dy - side + 1; y <= dy + side - NEAR; y++) {
        for (int x = dx - side + 1; x <= dx + side - NEAR; x++)
            least = fmin(least, rect_sum(k, sum, x, y, x + NEAR, y + NEAR));
    }
    // differences of an integral image may fall short of 0
    return fmax(least - 1e-13 * sum[((size_t) k->w + 1) *
                                    ((size_t) k->h + 1) - 1], 0.0) /
           (NEAR * NEAR);
}

static gp_status make_table(const struct gp_log *log,
                            const struct gp_kernel *k, const double *sum,
                            int side, int reach, float **out)
{
    void *v;
    const int n = 2 * reach + 1;
    gp_status st = gp_alloc(log, "bound", (size_t) n * (size_t) n,
                            sizeof **out, &v);
    if (st)
        return st;
    *out = v;
    for (int y = -reach; y <= reach; y++) {
        for (int x = -reach; x <= reach; x++)
            (*out)[(y + reach) * n + x + reach] =
                (float) (least_mean(k, sum, x * side, y * side, side) *
                         (1.0 - 1e-6));
    }
    return GP_OK;
}

/* Half of them would be made once more by the next call. */
static void drop_least(struct gp_bound_state *s)
{
    for (int c = 0; c < 3; c++) {
        GP_FREE(s->square[c]);
        GP_FREE(s->near[c]);
        GP_FREE(s->far[c]);
    }
}

static gp_status make_least(const struct gp_log *log,
                            const struct gp_kernel *k,
                            struct gp_bound_state *s)
{
    gp_status st = GP_OK;
    double *sum = NULL;
    const int farthest = max(max(k->cx, k->w - k->cx),
                             max(k->cy, k->h - k->cy));
    s->far_reach = clamp(farthest / FAR + 1, FAR_FROM, 64);
    s->channels = k->grey ? 1 : 3;
    for (int c = 0; c < s->channels; c++) {
        GP_TRY(make_integral(log, k, c, true, &s->square[c]));
        GP_TRY(make_integral(log, k, c, false, &sum));
        GP_TRY(make_table(log, k, sum, NEAR, NEAR_REACH, &s->near[c]));
        GP_TRY(make_table(log, k, sum, FAR, s->far_reach, &s->far[c]));
        GP_FREE(sum);
    }
    s->has_least = true;
out:
    if (st)
        drop_least(s);
    gp_free(sum);
    return st;
}

// -- the diagonal: each source by itself --------------------------------------

struct diagonal {
    const struct gp_sources *src;
    const struct gp_kernel *k;
    const struct gp_bound_state *s;
    double (*row)[3];
};

/* Squares of what each source of a row adds to the frame. */
static void diagonal_row(void *ctx, int y, int thread)
{
    const struct diagonal *const d = ctx;
    const struct gp_sources *const src = d->src;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const double *const square = d->s->square[d->s->channels == 1 ? 0 : c];
        // what differences of an integral image may have made up
        const double lost =
            4.0 * 0x1p-53 * ((double) d->k->w + d->k->h + 4.0) *
            square[((size_t) d->k->w + 1) * ((size_t) d->k->h + 1) - 1];
        double sum = 0.0;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const int x = src->x[i];
            const double light = (double) src->rgb[c][i];
            const double seen = rect_sum(d->k, square, -x, -y, src->w - x,
                                         src->h - y);
            sum += light * light * fmax(seen - lost, 0.0);
        }
        d->row[y][c] = sum;
    }
}

// -- cells: what lights up together -------------------------------------------

struct cells {
    const struct gp_bound_state *s;
    int w, h;         // near cells that hold any of the frame
    int whole;        // columns of them that the frame does not cut
    int far_w, far_h; // far cells that hold any of the frame
    float *near[3], *far[3]; // light of each cell
    float *back[3];          // least mean of the layer, far part, a far cell
    double (*row)[3];
};

static void free_cells(struct cells *m)
{
    for (int c = 0; c < 3; c++) {
        gp_free(m->near[c]);
        gp_free(m->far[c]);
        gp_free(m->back[c]);
    }
    gp_free(m->row);
}

static gp_status make_cells(const struct gp_log *log,
                            const struct gp_sources *src, struct cells *m)
{
    void *v;
    gp_status st;
    m->w = (src->w + NEAR - 1) / NEAR;
    m->h = (src->h + NEAR - 1) / NEAR;
    m->whole = src->w / NEAR;
    m->far_w = (src->w + FAR - 1) / FAR;
    m->far_h = (src->h + FAR - 1) / FAR;
    const size_t near = (size_t) m->w * (size_t) m->h;
    const size_t far = (size_t) m->far_w * (size_t) m->far_h;
    GP_TRY(gp_alloc_zero(log, "bound", (size_t) src->h, sizeof *m->row, &v));
    m->row = v;
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc_zero(log, "bound", near, sizeof(float), &v));
        m->near[c] = v;
        GP_TRY(gp_alloc_zero(log, "bound", far, sizeof(float), &v));
        m->far[c] = v;
        GP_TRY(gp_alloc_zero(log, "bound", far, sizeof(float), &v));
        m->back[c] = v;
    }
    for (int y = 0; y < src->h; y++) {
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const size_t n = (size_t) (y / NEAR) * (size_t) m->w +
                             (size_t) (src->x[i] / NEAR);
            const size_t f = (size_t) (y / FAR) * (size_t) m->far_w +
                             (size_t) (src->x[i] / FAR);
            for (int c = 0; c < 3; c++) {
                m->near[c][n] += src->rgb[c][i];
                m->far[c][f] += src->rgb[c][i];
            }
        }
    }
out:
    return st;
}

/* back[c] of one row of far cells. */
static void far_row(void *ctx, int y, int thread)
{
    const struct cells *const m = ctx;
    const int reach = m->s->far_reach, n = 2 * reach + 1;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const table = m->s->far[m->s->channels == 1 ? 0 : c];
        float *const to = m->back[c] + (size_t) y * (size_t) m->far_w;
        for (int sy = max(0, y - reach); sy <= min(m->far_h - 1, y + reach);
             sy++) {
            const float *const from =
                m->far[c] + (size_t) sy * (size_t) m->far_w;
            for (int dx = -reach; dx <= reach; dx++) {
                if (abs(dx) < FAR_FROM && abs(y - sy) < FAR_FROM)
                    continue; // near cells count these
                const float k = table[(y - sy + reach) * n + dx + reach];
                const int x1 = min(m->far_w, m->far_w + dx);
                for (int x = max(0, dx); k > 0.0f && x < x1; x++)
                    to[x] += k * from[x - dx];
            }
        }
    }
}

/* Squares of the layer over one row of near cells, at least. */
static void near_row(void *ctx, int y, int thread)
{
    const struct cells *const m = ctx;
    enum { N = 2 * NEAR_REACH + 1 };
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const table = m->s->near[m->s->channels == 1 ? 0 : c];
        double sum = 0.0;
        for (int x = 0; x < m->whole; x++) {
            float mean = m->back[c][(size_t) (y * NEAR / FAR) *
                                        (size_t) m->far_w +
                                    (size_t) (x * NEAR / FAR)];
            for (int sy = max(0, y - NEAR_REACH);
                 sy <= min(m->h - 1, y + NEAR_REACH); sy++) {
                const float *const from =
                    m->near[c] + (size_t) sy * (size_t) m->w;
                const float *const k =
                    table + (y - sy + NEAR_REACH) * N + NEAR_REACH;
                for (int sx = max(0, x - NEAR_REACH);
                     sx <= min(m->w - 1, x + NEAR_REACH); sx++)
                    mean += k[x - sx] * from[sx];
            }
            sum += (double) mean * (double) mean;
        }
        m->row[y][c] = sum * (NEAR * NEAR);
    }
}

/* sum[c] becomes at least the sum of squares of channel c, by cells. A cell
 * that the frame cuts is not counted. */
static gp_status add_cells(const struct gp_log *log,
                           const struct gp_sources *src,
                           const struct gp_bound_state *s, double sum[3])
{
    struct cells m = {.s = s};
    gp_status st = make_cells(log, src, &m);
    if (!st) {
        const int rows = src->h / NEAR;
        gp_parallel_do(m.far_h, far_row, &m);
        gp_parallel_do(rows, near_row, &m);
        for (int y = 0; y < rows; y++) {
            for (int c = 0; c < 3; c++)
                sum[c] += m.row[y][c];
        }
    }
    free_cells(&m);
    return st;
}

gp_status gp_bound_least(const struct gp_log *log,
                         const struct gp_sources *src,
                         const struct gp_kernel *kernel,
                         struct gp_bound_state *s, double *least)
{
    gp_status st = GP_OK;
    void *v = NULL;
    double sum[3] = {0}, cells[3] = {0};
    *least = 0.0;
    if (s->lobes || !src->n)
        return GP_OK;
    if (!s->has_least)
        GP_TRY(make_least(log, kernel, s));
    GP_TRY(gp_alloc_zero(log, "bound", (size_t) src->h, 3 * sizeof(double),
                         &v));
    struct diagonal d = {src, kernel, s, v};
    gp_parallel_do(src->h, diagonal_row, &d);
    for (int y = 0; y < src->h; y++) {
        for (int c = 0; c < 3; c++)
            sum[c] += d.row[y][c];
    }
    GP_TRY(add_cells(log, src, s, cells));
    double all = 0.0;
    for (int c = 0; c < 3; c++)
        all += fmax(sum[c], cells[c]);
    *least = sqrt(all) * (1.0 - 1e-4); // float sums of thousands of terms
out:
    gp_free(v);
    return st;
}

gp_status gp_layer_least(const struct gp_log *log,
                         const struct gp_sources *src,
                         const struct gp_kernel *kernel,
                         struct gp_bound_cache *cache, double *least)
{
    struct gp_bound_state *s;
    gp_status st = gp_bound_state(log, kernel, cache, &s);
    return st ? st : gp_bound_least(log, src, kernel, s, least);
}
