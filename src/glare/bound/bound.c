#include "core/cpu.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/bound/bound_priv.h"

#include <math.h>
#include <string.h>

/* Roundings of the factors of the sum, the polygon's light and the blurred
 * kernel's sample, doubled for safety. */
static const double OWN_ROUNDINGS = 4.0;

enum {
    // pixels around the frame that polygons may spread to; two widths, so that
    // the kept tables serve many settings
    BORDER = 16, WIDE_BORDER = 64,
    // two scales of cells, in pixels. NEAR_REACH near cells to each side cover
    // just what far cells that touch would
    NEAR = 4, FAR = 16, NEAR_REACH = 4, FAR_FROM = 2,
};

/* -- state kept for one kernel --------------------------------------------- */

/* Of the kernel's tail or whole, and one width of border. */
struct drawn {
    bool has_power, has_most, has_rings;
    struct gp_power power;
    struct gp_bound_table most;
    struct gp_bound_rings rings;
};

struct bound_state {
    int channels;           // 1 for a grey kernel
    bool has_least;
    double *square[3];      // integral images of k^2
    float *near[3], *far[3]; // least means over cells, by offset
    int far_reach;
    int w, h;               // of the frames that the rest is for
    struct gp_bound_cells cells;
    struct drawn drawn[2][2]; // [tail][wide border]
};

static void drop_drawn(struct bound_state *s)
{
    for (int i = 0; i < 4; i++) {
        struct drawn *const d = &s->drawn[i / 2][i % 2];
        gp_power_free(&d->power);
        gp_bound_table_free(&d->most);
        gp_bound_rings_free(&d->rings);
        *d = (struct drawn) {0};
    }
}

static void drop_least(struct bound_state *s)
{
    for (int c = 0; c < 3; c++) {
        GP_FREE(s->square[c]);
        GP_FREE(s->near[c]);
        GP_FREE(s->far[c]);
    }
}

void gp_bound_cache_free(struct gp_bound_cache *c)
{
    if (c->data) {
        drop_least(c->data);
        drop_drawn(c->data);
    }
    GP_FREE(c->data);
    c->kernel = 0;
}

/* The state of this kernel, made when the cache holds another's. */
static gp_status fit_state(const struct gp_log *log, const struct gp_kernel *k,
                           struct gp_bound_cache *cache,
                           struct bound_state **out)
{
    gp_status st = GP_OK;
    if (!cache->data || !k->serial || cache->kernel != k->serial) {
        gp_bound_cache_free(cache);
        st = gp_alloc_zero(log, "bound", 1, sizeof(struct bound_state),
                           &cache->data);
        if (st)
            return st;
        cache->kernel = k->serial;
    }
    *out = cache->data;
    return st;
}

/* -- the least of the layer: sums over rectangles of the kernel ------------ */

/* Sum of kernel offsets [x0, x1) x [y0, y1), from an integral image. */
static double rect_sum(const struct gp_kernel *k, const double *integral,
                       int x0, int y0, int x1, int y1)
{
    const size_t pitch = (size_t) k->w + 1;
    const size_t left = (size_t) gp_clamp(x0 + k->cx, 0, k->w);
    const size_t right = (size_t) gp_clamp(x1 + k->cx, 0, k->w);
    const size_t top = (size_t) gp_clamp(y0 + k->cy, 0, k->h) * pitch;
    const size_t low = (size_t) gp_clamp(y1 + k->cy, 0, k->h) * pitch;
    return integral[low + right] - integral[low + left] -
           integral[top + right] + integral[top + left];
}

static gp_status make_integral(const struct gp_log *log,
    const struct gp_kernel *k, int c, bool square, double **out)
{
    const size_t pitch = (size_t) k->w + 1;
    gp_status st = gp_alloc_zero(log, "bound", pitch * ((size_t) k->h + 1),
                                 sizeof **out, out);
    if (st)
        return st;
    double *const sum = *out;
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
    return GP_OK;
}

/* Makes the least means of one channel over a NEAR cell: of light from anywhere
 * in a cell of `side` that is so many cells away, up to `reach`. */
static gp_status make_means(const struct gp_log *log, const struct gp_kernel *k,
    const double *sum, int side, int reach, float **out)
{
    const int n = 2 * reach + 1;
    // differences of an integral image may fall short of 0
    const double lost = 1e-13 * sum[((size_t) k->w + 1) *
                                    ((size_t) k->h + 1) - 1];
    gp_status st = gp_alloc(log, "bound", (size_t) n * (size_t) n,
                            sizeof **out, out);
    if (st)
        return st;
    for (int i = 0; i < n * n; i++) {
        // from the corner of a cell to that of the other
        const int dx = (i % n - reach) * side, dy = (i / n - reach) * side;
        double least = INFINITY;
        for (int y = dy - side + 1; y <= dy + side - NEAR; y++) {
            for (int x = dx - side + 1; x <= dx + side - NEAR; x++)
                least = fmin(least, rect_sum(k, sum, x, y, x + NEAR, y + NEAR));
        }
        (*out)[i] = (float) (fmax(least - lost, 0.0) / (NEAR * NEAR) *
                             (1.0 - 1e-6));
    }
    return GP_OK;
}

/* -- the least of the layer: by sources, and by cells ---------------------- */

struct least_layer {
    const struct gp_sources *src;
    const struct gp_kernel *k;
    const struct bound_state *s;
    double (*alone)[3];      // of each row: squares of single sources
    int w, h;                // near cells that hold any of the frame
    int whole;               // columns of them that the frame does not cut
    int far_w, far_h;        // far cells that hold any of the frame
    float *near[3], *far[3]; // light of each cell
    bool *lit;               // of each row of far cells: it holds light
    float *back[3];          // least mean of the layer, far part, a far cell
    float *line;             // of each thread: means of a row of near cells
    double (*together)[3];   // of each row of near cells
};

/* Squares of what each source of a row adds to the frame. */
static void diagonal_row(void *ctx, int y, int thread)
{
    const struct least_layer *const d = ctx;
    const struct gp_sources *const src = d->src;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const double *const square = d->s->square[d->s->channels == 1 ? 0 : c];
        // rounding of an integral image's differences
        const double lost = 4.0 * 0x1p-53 * ((double) d->k->w + d->k->h + 4.0) *
            square[((size_t) d->k->w + 1) * ((size_t) d->k->h + 1) - 1];
        double sum = 0.0;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const int x = src->x[i];
            const double light = (double) src->rgb[c][i];
            const double seen = rect_sum(d->k, square, -x, -y, src->w - x,
                                         src->h - y);
            sum += light * light * fmax(seen - lost, 0.0);
        }
        d->alone[y][c] = sum;
    }
}

/* Adds `times` from[i] to to[i]. */
GP_CLONES static void add_times(const float *restrict from, float times, int n,
                                float *restrict to)
{
    for (int i = 0; i < n; i++)
        to[i] += times * from[i];
}

/* Adds the light of a far cell, `light` at column sx, to columns sx + from to
 * sx + end of the row `to`, by this row of the table. */
static void add_cell(const struct least_layer *m, const float *table, int sx,
                     int from, int end, float light, float *to)
{
    const int first = gp_max(from, -sx), last = gp_min(end, m->far_w - sx);
    if (first < last)
        add_times(table + first, light, last - first, to + sx + first);
}

/* Fills back[c] of one row of far cells. */
static void far_row(void *ctx, int y, int thread)
{
    const struct least_layer *const m = ctx;
    const int reach = m->s->far_reach, n = 2 * reach + 1;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const table = m->s->far[m->s->channels == 1 ? 0 : c];
        float *const to = m->back[c] + (size_t) y * (size_t) m->far_w;
        for (int sy = gp_max(0, y - reach);
             sy <= gp_min(m->far_h - 1, y + reach); sy++) {
            const float *const from =
                m->far[c] + (size_t) sy * (size_t) m->far_w;
            const float *const k = table + (y - sy + reach) * n + reach;
            // near cells count those that touch
            const int gap = abs(y - sy) < FAR_FROM ? FAR_FROM : 0;
            for (int sx = m->far_w - 1; m->lit[sy] && sx >= 0; sx--) {
                if (!(from[sx] > 0.0f))
                    continue;
                add_cell(m, k, sx, -reach, 1 - gap, from[sx], to);
                add_cell(m, k, sx, gap ? gap : 1, reach + 1, from[sx], to);
            }
        }
    }
}

/* Adds the light of one row of near cells to a row of means, by the row of the
 * table for their offset. */
static void add_near(const struct least_layer *m, const float *from,
                     const float *k, float *to)
{
    for (int x0 = 0, x1; x0 < m->w; x0 = x1) {
        // a run of lit cells
        while (x0 < m->w && !(from[x0] > 0.0f))
            x0++;
        for (x1 = x0; x1 < m->w && from[x1] > 0.0f;)
            x1++;
        for (int dx = NEAR_REACH; dx >= -NEAR_REACH; dx--) {
            const int first = gp_max(x0 + dx, 0);
            const int last = gp_min(x1 + dx, m->whole);
            if (first < last)
                add_times(from + first - dx, k[dx], last - first, to + first);
        }
    }
}

/* Sums squares of the layer over one row of near cells, at least. */
static void near_row(void *ctx, int y, int thread)
{
    const struct least_layer *const m = ctx;
    enum { N = 2 * NEAR_REACH + 1 };
    float *const mean = m->line + (size_t) thread * (size_t) m->whole;
    for (int c = 0; c < 3; c++) {
        const float *const table = m->s->near[m->s->channels == 1 ? 0 : c];
        const float *const back =
            m->back[c] + (size_t) (y * NEAR / FAR) * (size_t) m->far_w;
        double sum = 0.0;
        for (int x = 0; x < m->whole; x++)
            mean[x] = back[x * NEAR / FAR];
        for (int sy = gp_max(0, y - NEAR_REACH);
             sy <= gp_min(m->h - 1, y + NEAR_REACH); sy++) {
            if (m->lit[sy * NEAR / FAR])
                add_near(m, m->near[c] + (size_t) sy * (size_t) m->w,
                         table + (y - sy + NEAR_REACH) * N + NEAR_REACH, mean);
        }
        for (int x = 0; x < m->whole; x++)
            sum += (double) mean[x] * (double) mean[x];
        m->together[y][c] = sum * (NEAR * NEAR);
    }
}

/* gp_layer_least() with the kernel's state. */
static gp_status find_layer_least(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *k,
    struct bound_state *s, double *least)
{
    gp_status st = GP_OK;
    const int rows = src->h / NEAR; // a cell that the frame cuts is not counted
    double *integral = NULL, all = 0.0;
    struct least_layer m = {
        .src = src, .k = k, .s = s, .whole = src->w / NEAR,
        .w = (src->w + NEAR - 1) / NEAR, .h = (src->h + NEAR - 1) / NEAR,
        .far_w = (src->w + FAR - 1) / FAR, .far_h = (src->h + FAR - 1) / FAR,
    };
    const size_t near = (size_t) m.w * (size_t) m.h;
    const size_t far = (size_t) m.far_w * (size_t) m.far_h;
    *least = 0.0;
    if (k->negative || !src->n)
        return GP_OK;
    if (!s->has_least) {
        const int farthest = gp_max(gp_max(k->cx, k->w - k->cx),
                                    gp_max(k->cy, k->h - k->cy));
        s->far_reach = gp_clamp(farthest / FAR + 1, FAR_FROM, 64);
        s->channels = k->grey ? 1 : 3;
        for (int c = 0; c < s->channels; c++) {
            GP_TRY(make_integral(log, k, c, true, &s->square[c]));
            GP_TRY(make_integral(log, k, c, false, &integral));
            GP_TRY(make_means(log, k, integral, NEAR, NEAR_REACH, &s->near[c]));
            GP_TRY(make_means(log, k, integral, FAR, s->far_reach, &s->far[c]));
            GP_FREE(integral);
        }
        s->has_least = true;
    }
    const size_t h = (size_t) src->h;
    GP_TRY(gp_alloc_zero(log, "bound", h, sizeof *m.alone, &m.alone));
    GP_TRY(gp_alloc_zero(log, "bound", h, sizeof *m.together, &m.together));
    for (int c = 0; c < 3; c++) {
        GP_TRY(gp_alloc_zero(log, "bound", near, sizeof(float), &m.near[c]));
        GP_TRY(gp_alloc_zero(log, "bound", far, sizeof(float), &m.far[c]));
        GP_TRY(gp_alloc_zero(log, "bound", far, sizeof(float), &m.back[c]));
    }
    GP_TRY(gp_alloc_zero(log, "bound", (size_t) m.far_h, sizeof *m.lit,
                         &m.lit));
    GP_TRY(gp_alloc(log, "bound", (size_t) gp_threads() * (size_t) m.whole,
                    sizeof *m.line, &m.line));
    for (int y = 0; y < src->h; y++) {
        m.lit[y / FAR] |= src->row[y + 1] > src->row[y];
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const size_t n = (size_t) (y / NEAR) * (size_t) m.w +
                             (size_t) (src->x[i] / NEAR);
            const size_t f = (size_t) (y / FAR) * (size_t) m.far_w +
                             (size_t) (src->x[i] / FAR);
            for (int c = 0; c < 3; c++) {
                m.near[c][n] += src->rgb[c][i];
                m.far[c][f] += src->rgb[c][i];
            }
        }
    }
    gp_parallel_do(src->h, diagonal_row, &m);
    gp_parallel_do(m.far_h, far_row, &m);
    gp_parallel_do(rows, near_row, &m);
    for (int c = 0; c < 3; c++) {
        double alone = 0.0, together = 0.0;
        for (int y = 0; y < src->h; y++)
            alone += m.alone[y][c];
        for (int y = 0; y < rows; y++)
            together += m.together[y][c];
        all += fmax(alone, together);
    }
    *least = sqrt(all) * (1.0 - 1e-4); // float sums of thousands of terms
out:
    if (!s->has_least) // half of them would be made once more by the next call
        drop_least(s);
    for (int c = 0; c < 3; c++) {
        gp_free(m.near[c]);
        gp_free(m.far[c]);
        gp_free(m.back[c]);
    }
    gp_free(integral);
    gp_free(m.line);
    gp_free(m.lit);
    gp_free(m.alone);
    gp_free(m.together);
    return st;
}

gp_status gp_layer_least(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_kernel *kernel, struct gp_bound_cache *cache, double *least)
{
    struct bound_state *s;
    gp_status st = fit_state(log, kernel, cache, &s);
    return st ? st : find_layer_least(log, src, kernel, s, least);
}

/* -- the error of the polygons --------------------------------------------- */

gp_status gp_group_bound(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_kernel *kernel, const struct gp_splat_params *p,
    const struct gp_polygons *polygons, const struct gp_shrink *shrink,
    double roundings, struct gp_bound_cache *cache, double *out)
{
    gp_status st;
    struct bound_state *s;
    struct gp_residue residue = {0};
    double wrong[3] = {0}, most[3], sum[3], norm[3], least;
    *out = INFINITY;
    if (kernel->negative)
        return GP_OK;
    GP_TRY(fit_state(log, kernel, cache, &s));
    if (s->w != src->w || s->h != src->h) {
        drop_drawn(s);
        s->w = src->w;
        s->h = src->h;
        s->cells = gp_bound_cells_choose(s->w, s->h, kernel);
    }
    int side = 1;
    for (size_t i = 0; i < polygons->n; i++)
        side = gp_max(side, polygons->at[i].side);
    const bool tail = !gp_splat_single(p), wide = side > BORDER;
    const int border = wide ? WIDE_BORDER : BORDER;
    struct drawn *const d = &s->drawn[tail][wide];
    GP_TRY(find_layer_least(log, src, kernel, s, &least));
    if ((side > 1 || shrink->left_out > 0.0) && !d->has_rings) {
        GP_TRY(gp_bound_rings_make(log, kernel, tail, src->w + border,
                                   src->h + border, &d->rings));
        d->has_rings = true;
    }

    // grouping and clustering
    if (side > 1)
        GP_TRY(gp_residue_make(log, src, polygons, border, &residue));
    if (residue.rows) {
        if (!d->has_power)
            GP_TRY(gp_power_make(log, kernel, tail, src->w, src->h, border,
                                 &d->power));
        d->has_power = true;
        GP_TRY(gp_power_bound(log, &d->power, &residue, norm));
        for (int c = 0; c < 3; c++)
            wrong[c] += norm[c];
    }
    // float coordinates of the frame are 2^(exponent - 24) pixels apart, and a
    // sample may be taken so far from its place
    if (side > 1) {
        int exponent;
        frexp((double) gp_max(src->w, src->h), &exponent);
        gp_bound_rings_sampled(&d->rings, polygons, ldexp(1.0, exponent - 24),
                               norm);
        for (int c = 0; c < 3; c++)
            wrong[c] += norm[c];
    }
    // the light e that shrinking leaves out: Young's inequality where lights
    // are side by side, |e|^2 <= max e * sum e where they are far apart
    if (shrink->left_out > 0.0) {
        if (!d->has_most) // blurs carry light half a box and a pixel away
            GP_TRY(gp_bound_table_make(log, &s->cells, kernel, GP_BOUND_MOST,
                                       tail, border / 2 + 1, &d->most));
        d->has_most = true;
        GP_TRY(gp_bound_cells_left(log, &s->cells, polygons, shrink, &d->most,
                                   most));
        GP_TRY(gp_bound_rings_left(log, &d->rings, polygons, shrink, sum,
                                   norm));
        for (int c = 0; c < 3; c++)
            wrong[c] += fmin(norm[c], sqrt(most[c] * sum[c]));
    }
    const double all = sqrt(wrong[0] * wrong[0] + wrong[1] * wrong[1] +
                            wrong[2] * wrong[2]);
    // each rounding is relative to the drawn layer: the exact one and its error
    const double share = (roundings + OWN_ROUNDINGS) * 0x1p-24;
    if (all == 0.0)
        *out = share;
    else if (least > 0.0)
        *out = all / least * (1.0 + share) + share;
out:
    gp_residue_free(&residue);
    return st;
}
