// SPDX-License-Identifier: Apache-2.0
/* Lower limits of light, and errors in proportion to them: by values too small
 * for float, and in the worst pixel of the composite. */
#include "glare/bound/bound.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft.h"
#include "glare/sky/sky.h"

#include <math.h>
#include <string.h>

static const double MOST_WORK = 4e6; // products

/* Lowers a limit by more than rounding in double can have raised it. */
static const double SURE = 1.0 - 1e-9;

/* The frame cut into cells of side x side pixels; those at the right and at the
 * bottom may be smaller. */
struct cells {
    int w, h; // of the frame
    int side, columns, rows;
};

/* Returns the smallest cells, their side a power of two, with which add_least()
 * takes at most MOST_WORK for a channel. */
static struct cells choose_cells(int w, int h, const struct gp_kernel *kernel)
{
    struct cells c = {.w = w, .h = h, .side = 1};
    for (;; c.side *= 2) {
        c.columns = (w + c.side - 1) / c.side;
        c.rows = (h + c.side - 1) / c.side;
        const double across = fmin(2.0 * c.columns, kernel->w / c.side + 2.0);
        const double down = fmin(2.0 * c.rows, kernel->h / c.side + 2.0);
        if ((double) c.columns * c.rows * across * down <= MOST_WORK)
            return c;
    }
}

// -- the least that a unit of light adds from one cell to another -------------

/* The least kernel sample between any two pixels of two cells, by the cells'
 * offset (dx, dy) from source to pixel; 0 for offsets that are not there. */
struct table {
    int x0, y0, w, h;
    double *at; // [(dy - y0) * w + dx - x0]
};

/* Finds the offsets d of cells, *n of them from *first on, at which the kernel
 * has a sample for any two pixels. It has samples at offsets -before to after.
 * The pixels are d side - (side - 1) to d side + (side - 1) apart. In a frame
 * |d| is less than `cells`. */
static void find_offsets(int before, int after, int side, int cells,
                         int *first, int *n)
{
    const bool any = before >= side - 1 && after >= side - 1;
    *first = any ? gp_max(-((before - side + 1) / side), 1 - cells) : 0;
    const int last = gp_min((after - side + 1) / side, cells - 1);
    *n = any ? gp_max(last - *first + 1, 0) : 0;
}

/* The caller frees out->at, on failure too. */
static gp_status make_table(const struct gp_log *log,
    const struct cells *cells, const struct gp_kernel *k, int c,
    struct table *out)
{
    gp_status st;
    struct table t = {0};
    const int side = cells->side, more = side - 1;
    float *rows = NULL;
    // the centre may lie far outside
    find_offsets(k->cx, gp_clamp_wide(k->w - 1LL - k->cx, -1, k->w), side,
                 cells->columns, &t.x0, &t.w);
    find_offsets(k->cy, gp_clamp_wide(k->h - 1LL - k->cy, -1, k->h), side,
                 cells->rows, &t.y0, &t.h);
    if (t.w == 0 || t.h == 0)
        t.w = t.h = 0;
    const size_t w = (size_t) t.w, n = w * (size_t) t.h;
    GP_TRY(gp_alloc(log, "bound", w * (size_t) k->h + 1, sizeof *rows, &rows));
    GP_TRY(gp_alloc(log, "bound", n + 1, sizeof *t.at, &t.at));
    // the least in a square around d side, first along rows, then down
    for (int y = 0; y < k->h && t.w; y++) {
        const float *const row = gp_row(k->k.c[c], k->w, y);
        for (int i = 0; i < t.w; i++) {
            const int at = (t.x0 + i) * side + k->cx;
            float v = row[at];
            for (int x = at - more; x <= at + more; x++)
                v = gp_minf(v, row[x]);
            rows[(size_t) y * w + (size_t) i] = v;
        }
    }
    for (size_t i = 0; i < n; i++) {
        const int at = (t.y0 + (int) (i / w)) * side + k->cy;
        float v = rows[(size_t) at * w + i % w];
        for (int y = at - more; y <= at + more; y++)
            v = gp_minf(v, rows[(size_t) y * w + i % w]);
        t.at[i] = (double) v;
    }
out:
    *out = t;
    gp_free(rows);
    return st;
}

// -- the least light of a cell ------------------------------------------------

struct spreading {
    const struct cells *cells;
    const struct table *table;
    const double *light; // sum of the sources of each cell
    bool own;            // sources light their own cell, too
    double *out;
};

GP_CLONES static void add_scaled(double *restrict to,
                                 const double *restrict from, int n, double k)
{
    for (int i = 0; i < n; i++)
        to[i] += k * from[i];
}

/* Adds to row y of cells the least light that they get from all cells. */
static void add_least_row(void *ctx, int y, GP_UNUSED int thread)
{
    const struct spreading *const f = ctx;
    const struct table *const t = f->table;
    const int columns = f->cells->columns;
    double *const line = f->out + (size_t) y * (size_t) columns;
    for (int i = 0; i < t->w * t->h; i++) {
        const int dx = t->x0 + i % t->w, dy = t->y0 + i / t->w;
        const int from = gp_max(dx, 0), end = columns + gp_min(dx, 0);
        if (y - dy < 0 || y - dy >= f->cells->rows || !(t->at[i] > 0.0) ||
            from >= end || (!f->own && dx == 0 && dy == 0))
            continue;
        add_scaled(line + from,
                   f->light + (size_t) (y - dy) * (size_t) columns + (from - dx),
                   end - from, t->at[i]);
    }
}

/* Adds to each cell a lower limit of the light, times a weight, that channel c
 * has in any pixel of the cell; with `own` from sources in the cell, too. */
static gp_status add_least(const struct gp_log *log,
    const struct cells *cells, const struct gp_kernel *kernel, int c,
    const struct gp_sources *src, double weight, bool own, double *out)
{
    struct table table = {0};
    double *light = NULL;
    const size_t columns = (size_t) cells->columns;
    gp_status st = make_table(log, cells, kernel, c, &table);
    if (!st)
        st = gp_alloc_zero(log, "bound", columns * (size_t) cells->rows,
                           sizeof *light, &light);
    for (int y = 0; y < src->h && !st; y++) {
        double *const row = light + (size_t) (y / cells->side) * columns;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++)
            row[src->x[i] / cells->side] +=
                weight * SURE * (double) src->rgb[c][i];
    }
    struct spreading f = {cells, &table, light, own, out};
    if (!st)
        gp_parallel_do(cells->rows, add_least_row, &f);
    gp_free(light);
    gp_free(table.at);
    return st;
}

// -- the least of the layer ---------------------------------------------------

/* Sums squares over the frame's pixels, of the least light of their cells. */
static double together(const struct cells *b, const double *least)
{
    double sum = 0.0;
    for (int y = 0; y < b->rows; y++) {
        const int high = gp_min(b->side, b->h - y * b->side);
        for (int x = 0; x < b->columns; x++) {
            const double v = least[(size_t) y * (size_t) b->columns + (size_t) x];
            sum += v * v * high * gp_min(b->side, b->w - x * b->side);
        }
    }
    return sum;
}

/* Sums squares over the sources' layers, each by itself, inside the frame. */
static double alone(const struct gp_sources *src, const struct gp_kernel *k,
                    int c, const double *square)
{
    const size_t pitch = (size_t) k->w + 1;
    // rounding of differences in the integral image
    const double lost = 4.0 * 0x1p-53 * ((double) k->w + k->h + 4.0) *
                        square[pitch * ((size_t) k->h + 1) - 1];
    double sum = 0.0;
    for (int y = 0; y < src->h; y++) {
        const double *const top =
            square +
            (size_t) gp_clamp_wide((long long) k->cy - y, 0, k->h) * pitch;
        const double *const low = square +
            (size_t) gp_clamp_wide((long long) k->cy - y + src->h, 0, k->h) *
                pitch;
        for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
            const int x = src->x[i];
            const double light = (double) src->rgb[c][i];
            const int left = gp_clamp_wide((long long) k->cx - x, 0, k->w);
            const int right =
                gp_clamp_wide((long long) k->cx - x + src->w, 0, k->w);
            const double seen =
                low[right] - low[left] - top[right] + top[left];
            sum += light * light * fmax(seen - lost, 0.0);
        }
    }
    return sum;
}

gp_status gp_layer_least(const struct gp_log *log, const struct gp_sources *src,
    const struct gp_kernel *kernel, double *least)
{
    gp_status st = GP_OK;
    const struct cells cells = choose_cells(src->w, src->h, kernel);
    const size_t n = (size_t) cells.columns * (size_t) cells.rows;
    double *square = NULL, *cell = NULL, all = 0.0;
    *least = 0.0;
    if (kernel->negative || !src->n)
        return GP_OK;
    GP_TRY(gp_alloc(log, "bound", n, sizeof *cell, &cell));
    GP_TRY(gp_alloc(log, "bound",
                    ((size_t) kernel->w + 1) * ((size_t) kernel->h + 1),
                    sizeof *square, &square));
    for (int c = 0; c < 3; c++) {
        memset(cell, 0, n * sizeof *cell);
        gp_kernel_sums(kernel, c, true, square);
        GP_TRY(add_least(log, &cells, kernel, c, src, 1.0, true, cell));
        all += fmax(alone(src, kernel, c, square), together(&cells, cell));
    }
    *least = sqrt(all) * SURE;
out:
    gp_free(square);
    gp_free(cell);
    return st;
}

double gp_layer_some(const struct gp_glare_request *req)
{
    const struct gp_sources *const src = req->src;
    const struct gp_kernel *const k = req->kernel;
    const double kept = k->sky ? gp_sky_facts(k->sky)->kept / k->over : 0.0;
    double own = 0.0, all = 0.0;
    for (int c = 0; c < 3; c++) {
        const double centre = fmax((double) gp_kernel_centre(k, c), 0.0);
        own += src->energy[c] * centre * centre;
        all += src->flux[c] * src->flux[c];
    }
    return k->over < INFINITY
               ? fmax(sqrt(own), kept * sqrt(all / ((double) src->w * src->h)))
               : 0.0;
}

// -- underflow ----------------------------------------------------------------

/* A value under FLT_MIN, 2^-126, may become 0. Of kernel samples that costs a
 * pixel up to 2^-126 times the flux of all sources. Of sources it costs up to
 * 2^-126 times the kernel's sum; of n products and n sums 2^-126 each. All this
 * counts 2^6 times, as engines compute in several steps. */
gp_status gp_error_floor_find(const struct gp_glare_request *req, double *floor)
{
    static const double NEGLIGIBLE = 1e-12, SMALL = 1e-5;
    const struct gp_sources *const src = req->src;
    const struct gp_kernel *const k = req->kernel;
    const double flux = fmax(src->flux[0], fmax(src->flux[1], src->flux[2]));
    const double norm = fmax(k->norm1[0], fmax(k->norm1[1], k->norm1[2]));
    const double lost = 0x1p-120 * (flux + norm + 2.0 * (double) src->n) *
                        sqrt(3.0 * src->w * src->h);
    const double far = req->far ? gp_far_error_of(req->far)->norm : 0.0;
    const double splines =
        k->sky && !req->exact ? gp_sky_facts(k->sky)->splines : 0.0;
    const double wrong = // the far field's error, and theirs: of sources' light
        (far + splines) *
        sqrt(src->energy[0] + src->energy[1] + src->energy[2]);
    const double outer = k->sky ? gp_sky_facts(k->sky)->outside : 0.0;
    const double beyond = // and of light from beyond the border
        (far + outer) * req->beyond * sqrt(3.0 * src->w * src->h);
    const double enough = fmax(lost / NEGLIGIBLE, wrong / SMALL);
    // lower limit of the layer's norm; cheap ways first
    double least = gp_layer_some(req);
    *floor = 0.0;
    if (!(k->over < INFINITY)) // no engine guarantees anything
        return GP_OK;
    if (least < enough) { // by a quarter of the kernel, in any frame
        struct gp_fft_quarters quarters;
        gp_fft_find_quarters(k, src->w, src->h, &quarters);
        least = gp_fft_least(src, &quarters);
    }
    if (least < enough) { // by the sources' places
        double other;
        gp_status st = gp_layer_least(req->log, src, k, &other);
        if (st)
            return st;
        least = fmax(least, other);
    }
    // (light from beyond the border is rounded 4 times)
    *floor = least > 0.0 ? (lost + wrong + beyond) / least : INFINITY;
    *floor += !k->sky      ? 0.0
              : req->exact ? GP_SKY_EXACT
                           : gp_sky_facts(k->sky)->relative;
    *floor += req->beyond > 0.0 ? 0x1p-22 : 0.0;
    return GP_OK;
}

// -- the worst pixel of the composite -----------------------------------------

struct floors {
    const struct gp_glare_request *req;
    const struct gp_image *f;
    double centre[3];     // kernel samples that a source's own pixel gets
    struct cells cells;
    double *least, *most; // own part of Y in a pixel of each cell
};

/* Returns the own part of Y in pixel x of row y. *taken and *spread are the
 * next sources of the row in p->taken and in m->req->src. */
static double own_luminance(const struct floors *m, size_t x, size_t y,
                            uint32_t *taken, uint32_t *spread)
{
    const struct gp_glare_params *const p = m->req->params;
    const struct gp_sources *const t = p->taken, *const s = m->req->src;
    const size_t at = y * (size_t) gp_image_w(m->f) + x;
    const double gain = (double) p->gain;
    double sum = 0.0;
    const bool gives = t && *taken < t->row[y + 1] &&
                       (size_t) t->x[*taken] == x;
    const bool gets = *spread < s->row[y + 1] && (size_t) s->x[*spread] == x;
    for (int c = 0; c < 3; c++) {
        double v = (double) m->f->rgb.c[c][at];
        if (gives)
            v -= fmin(gain, 1.0) * (double) t->rgb[c][*taken];
        if (gets)
            v += gain * m->centre[c] * (double) s->rgb[c][*spread];
        sum += (double) m->f->luminance[c] * v;
    }
    *taken += gives;
    *spread += gets;
    return sum;
}

static void bound_row(void *ctx, int row, GP_UNUSED int thread)
{
    const struct floors *const m = ctx;
    const struct gp_sources *const t = m->req->params->taken;
    const int side = m->cells.side;
    const size_t w = (size_t) gp_image_w(m->f);
    const size_t end = (size_t) gp_min((row + 1) * side, m->cells.h);
    const size_t first = (size_t) row * (size_t) m->cells.columns;
    for (int x = 0; x < m->cells.columns; x++) {
        m->least[first + (size_t) x] = INFINITY;
        m->most[first + (size_t) x] = -INFINITY;
    }
    for (size_t y = (size_t) row * (size_t) side; y < end; y++) {
        uint32_t taken = t ? t->row[y] : 0, spread = m->req->src->row[y];
        for (size_t x = 0; x < w; x++) {
            const size_t at = first + x / (size_t) side;
            const double v = own_luminance(m, x, y, &taken, &spread);
            m->least[at] = fmin(m->least[at], v);
            m->most[at] = fmax(m->most[at], v);
        }
    }
}

gp_status gp_pixel_floor_find(const struct gp_glare_request *req,
    const struct gp_image *f, struct gp_pixel_floor *out)
{
    const struct gp_kernel *const k = req->kernel;
    struct floors m = {.req = req, .f = f};
    struct gp_pixel_floor o = {.own = INFINITY, .dimmest = INFINITY};
    m.cells = choose_cells(req->src->w, req->src->h, k);
    const size_t n = (size_t) m.cells.columns * (size_t) m.cells.rows;
    gp_status st = gp_alloc_zero(req->log, "pixel bound", 3 * n,
                                 sizeof *m.least, &m.least);
    if (st)
        return st;
    double *const others = m.least + 2 * n;
    m.most = m.least + n;
    for (int c = 0; c < 3; c++) {
        const double norm = sqrt(req->src->energy[c]);
        o.weight[c] = (double) f->luminance[c];
        o.layer[c] = fmin((double) req->src->brightest * k->norm1[c],
                          norm * k->norm2[c]);
        m.centre[c] = (double) gp_kernel_centre(k, c);
        // a primary that is no visible colour may have negative luminance
        o.negative += fmax(-o.weight[c], 0.0) * o.layer[c] *
                  (double) req->params->gain;
        o.lost[c] = 0x1p-120 * (req->src->flux[c] + k->norm1[c] +
                                2.0 * (double) req->src->n);
        if (req->far)
            o.far[c] = gp_far_pixel_error(req->far, k->far, req->src, c) +
                       gp_far_error_of(req->far)->column *
                           sqrt((double) req->src->w * req->src->h) *
                           req->beyond;
    }
    gp_parallel_do(m.cells.rows, bound_row, &m);
    for (int c = 0; c < 3 && !k->negative; c++) {
        if (o.weight[c] > 0.0)
            GP_TRY(add_least(req->log, &m.cells, k, c, req->src, o.weight[c],
                             false, others));
    }
    for (size_t i = 0; i < n; i++) {
        const double more = (double) req->params->gain * others[i];
        o.own = fmin(o.own, m.least[i]);
        o.dimmest = fmin(o.dimmest, m.least[i] + more);
        o.brightest = fmax(o.brightest, m.most[i] + more);
    }
    o.rounded = req->beyond > 0.0 ? 0x1p-22 : 0.0; // light from beyond, 4 times
    *out = o;
out:
    gp_free(m.least);
    return st;
}

double gp_pixel_bound(const struct gp_pixel_floor *f,
                      const struct gp_pixel_error *e, double gain)
{
    const double peak = 1e-6 * (f->brightest - f->negative);
    const double dark = fmax(f->dimmest - f->negative, 0.0) + peak;
    double sum = 0.0;
    if (!(peak > 0.0) || !(e->relative < INFINITY))
        return INFINITY;
    // the light of other pixels is Y less the own part, if none is negative
    const bool adds = !(f->negative > 0.0);
    for (int c = 0; c < 3; c++)
        sum +=
            gain * fabs(f->weight[c]) *
            (ldexp(e->of[c], f->times) +
             (adds ? 0.0 : e->relative * f->layer[c]) + f->lost[c] + f->far[c]);
    const double in_proportion =
        adds ? e->relative * (1.0 + fmax(-f->own, 0.0) / peak) : 0.0;
    return sum / dark + in_proportion + f->rounded;
}
