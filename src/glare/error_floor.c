/* Bounds the errors that no engine does: values under the range of float, and
 * the composite's worst pixel. */
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/bound/bound.h"
#include "glare/fft/fft.h"
#include "glare/glare_priv.h"

#include <math.h>

// -- underflow ----------------------------------------------------------------

/* Values under 2^-126 are lost. A lost kernel sample costs a pixel up to 2^-126
 * of all light, a lost source that of the kernel's sum, products and sums that
 * each. Times 2^6, as engines have more steps than one. */
gp_status gp_error_floor_find(const struct gp_glare_request *req, double *floor)
{
    static const double NEGLIGIBLE = 1e-12, SMALL = 1e-5;
    const struct gp_sources *const src = req->src;
    const struct gp_kernel *const k = req->kernel;
    const double flux = fmax(src->flux[0], fmax(src->flux[1], src->flux[2]));
    const double norm = fmax(k->norm1[0], fmax(k->norm1[1], k->norm1[2]));
    const double lost = 0x1p-120 * (flux + norm + 2.0 * (double) src->n) *
                        sqrt(3.0 * src->w * src->h);
    const double tail = req->tail ? gp_far_error_of(req->tail)->norm : 0.0;
    const double wrong = // the tail's error
        tail * sqrt(src->energy[0] + src->energy[1] + src->energy[2]);
    const double beyond = // ... of light from beyond the border
        tail * gp_beyond_most(req->beyond) * sqrt(3.0 * src->w * src->h);
    const double enough = fmax(lost / NEGLIGIBLE, wrong / SMALL);
    double least = 0.0; // lower limit of the layer's norm
    *floor = 0.0;
    if (k->negative) // no engine guarantees anything
        return GP_OK;
    // light of each source in its own pixel
    if (k->cx >= 0 && k->cx < k->w && k->cy >= 0 && k->cy < k->h) {
        const size_t at = (size_t) k->cy * (size_t) k->w + (size_t) k->cx;
        for (int c = 0; c < 3; c++)
            least += src->energy[c] * (double) k->k.c[c][at] *
                     (double) k->k.c[c][at];
        least = sqrt(least);
    }
    if (least < enough) { // light of sources, wherever they are
        struct gp_fft_quarters quarters;
        gp_fft_find_quarters(k, src->w, src->h, &quarters);
        least = gp_fft_least(src, &quarters);
    }
    if (least < enough) { // light of these sources
        double other;
        gp_status st = gp_layer_least(req->log, src, k, &other);
        if (st)
            return st;
        least = fmax(least, other);
    }
    // (adding the tail rounds the sum once, light from beyond the border four
    // times)
    *floor = least > 0.0 ? (lost + wrong + beyond) / least : INFINITY;
    *floor += (req->tail ? 0x1p-24 : 0.0) + (req->beyond ? 0x1p-22 : 0.0);
    return GP_OK;
}

// -- the worst pixel of the composite -----------------------------------------

struct floors {
    const struct gp_glare_request *req;
    const struct gp_image *f;
    double centre[3];   // kernel samples that a source's own pixel gets
    struct gp_bound_cells cells;
    double *least, *most; // of each cell
};

/* The composite's luminance in pixel x of row y, but for the light of other
 * pixels; *taken and *lit step through the sources of the row. */
static double own_luminance(const struct floors *m, size_t x, size_t y,
                            uint32_t *taken, uint32_t *lit)
{
    const struct gp_glare_params *const p = m->req->params;
    const struct gp_sources *const t = p->taken, *const s = m->req->src;
    const size_t at = y * (size_t) gp_image_w(m->f) + x;
    const double gain = (double) p->gain;
    double sum = 0.0;
    const bool gives = t && *taken < t->row[y + 1] &&
                       (size_t) t->x[*taken] == x;
    const bool gets = *lit < s->row[y + 1] && (size_t) s->x[*lit] == x;
    for (int c = 0; c < 3; c++) {
        double v = (double) m->f->rgb.c[c][at];
        if (gives)
            v -= fmin(gain, 1.0) * (double) t->rgb[c][*taken];
        if (gets)
            v += gain * m->centre[c] * (double) s->rgb[c][*lit];
        sum += (double) m->f->luminance[c] * v;
    }
    *taken += gives;
    *lit += gets;
    return sum;
}

/* Fills the least and the most of one row of cells. */
static void bound_row(void *ctx, int row, int thread)
{
    const struct floors *const m = ctx;
    const struct gp_sources *const t = m->req->params->taken;
    const int side = m->cells.side;
    const size_t w = (size_t) gp_image_w(m->f);
    const size_t end = (size_t) gp_min((row + 1) * side, m->cells.h);
    const size_t first = (size_t) row * (size_t) m->cells.columns;
    (void) thread;
    for (int x = 0; x < m->cells.columns; x++) {
        m->least[first + (size_t) x] = INFINITY;
        m->most[first + (size_t) x] = -INFINITY;
    }
    for (size_t y = (size_t) row * (size_t) side; y < end; y++) {
        uint32_t taken = t ? t->row[y] : 0, lit = m->req->src->row[y];
        for (size_t x = 0; x < w; x++) {
            const size_t at = first + x / (size_t) side;
            const double v = own_luminance(m, x, y, &taken, &lit);
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
    struct gp_pixel_floor o = {.least = INFINITY, .lit = INFINITY};
    m.cells = gp_bound_cells_choose(req->src->w, req->src->h, k);
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
        if (k->cx >= 0 && k->cx < k->w && k->cy >= 0 && k->cy < k->h)
            m.centre[c] = (double) k->k.c[c][(size_t) k->cy * (size_t) k->w +
                                             (size_t) k->cx];
        // primaries outside the visible colours have negative luminance
        o.less += fmax(-o.weight[c], 0.0) * o.layer[c] *
                  (double) req->params->gain;
        o.lost[c] = 0x1p-120 * (req->src->flux[c] + k->norm1[c] +
                                2.0 * (double) req->src->n);
        if (req->tail)
            o.tail[c] = gp_far_pixel_error(req->tail, k->tail, req->src, c) +
                        0x1p-24 * o.layer[c] +
                        gp_far_error_of(req->tail)->column *
                            sqrt((double) req->src->w * req->src->h) *
                            gp_beyond_most(req->beyond);
    }
    gp_parallel_do(m.cells.rows, bound_row, &m);
    if (!k->negative)
        GP_TRY(gp_bound_cells_faint(req->log, &m.cells, k, req->src, o.weight,
                                    others));
    for (size_t i = 0; i < n; i++) {
        const double more = (double) req->params->gain * others[i];
        o.least = fmin(o.least, m.least[i]);
        o.lit = fmin(o.lit, m.least[i] + more);
        o.most = fmax(o.most, m.most[i] + more);
    }
    o.rounded = req->beyond ? 0x1p-22 : 0.0;
    *out = o;
out:
    gp_free(m.least);
    return st;
}

double gp_pixel_bound(const struct gp_pixel_floor *f,
                      const struct gp_pixel_error *e, double gain)
{
    const double peak = 1e-6 * (f->most - f->less);
    const double dark = fmax(f->lit - f->less, 0.0) + peak;
    double sum = 0.0;
    if (!(peak > 0.0) || !(e->share < INFINITY))
        return INFINITY;
    for (int c = 0; c < 3; c++) {
        const double share = f->less > 0.0 ? e->share * f->layer[c] : 0.0;
        sum += gain * fabs(f->weight[c]) * (e->of[c] + share + f->lost[c] +
                                           f->tail[c]);
    }
    const double own =
        f->less > 0.0 ? 0.0 : e->share * (1.0 + fmax(-f->least, 0.0) / peak);
    return sum / dark + own + f->rounded;
}
