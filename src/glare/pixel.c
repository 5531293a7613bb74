/* The bound of an engine's error in the worst pixel of the composite. */
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <math.h>

struct floors {
    const struct gp_glare_job *job;
    const struct gp_frame *f;
    double centre[3];   // kernel samples that a source's own pixel gets
    double *least, *most; // of each row
};

/* The composite's luminance in pixel x of row y, but for the light of other
 * pixels; *taken and *lit step through the sources of the row. */
static double own_luminance(const struct floors *m, size_t x, size_t y,
                            uint32_t *taken, uint32_t *lit)
{
    const struct gp_glare_params *const p = m->job->params;
    const struct gp_sources *const t = p->taken, *const s = m->job->src;
    const size_t at = y * (size_t) gp_frame_w(m->f) + x;
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

static void find_row(void *ctx, int row, int thread)
{
    const struct floors *const m = ctx;
    const struct gp_sources *const t = m->job->params->taken;
    const size_t w = (size_t) gp_frame_w(m->f), y = (size_t) row;
    uint32_t taken = t ? t->row[y] : 0, lit = m->job->src->row[y];
    double least = INFINITY, most = -INFINITY;
    (void) thread;
    for (size_t x = 0; x < w; x++) {
        const double v = own_luminance(m, x, y, &taken, &lit);
        least = fmin(least, v);
        most = fmax(most, v);
    }
    m->least[y] = least;
    m->most[y] = most;
}

gp_status gp_pixel_floor_find(const struct gp_glare_job *job,
    const struct gp_frame *f, struct gp_pixel_floor *out)
{
    const struct gp_kernel *const k = job->kernel;
    const size_t h = (size_t) gp_frame_h(f);
    struct floors m = {.job = job, .f = f};
    struct gp_pixel_floor o = {.least = INFINITY};
    gp_status st = gp_alloc(job->log, "pixel bound", 2 * h, sizeof *m.least,
                            &m.least);
    if (st)
        return st;
    m.most = m.least + h;
    for (int c = 0; c < 3; c++) {
        const double norm = sqrt(job->src->energy[c]);
        o.weight[c] = (double) f->luminance[c];
        o.layer[c] = fmin((double) job->src->brightest * k->norm1[c],
                          norm * k->norm2[c]);
        if (k->cx >= 0 && k->cx < k->w && k->cy >= 0 && k->cy < k->h)
            m.centre[c] = (double) k->k.c[c][(size_t) k->cy * (size_t) k->w +
                                             (size_t) k->cx];
        // of unreal primaries, whose light can be of less luminance than none
        o.less += fmax(-o.weight[c], 0.0) * o.layer[c] *
                  (double) job->params->gain;
        o.lost[c] = 0x1p-120 * (job->src->flux[c] + k->norm1[c] +
                                2.0 * (double) job->src->n);
    }
    gp_parallel_do((int) h, find_row, &m);
    for (size_t y = 0; y < h; y++) {
        o.least = fmin(o.least, m.least[y]);
        o.most = fmax(o.most, m.most[y]);
    }
    gp_free(m.least);
    *out = o;
    return GP_OK;
}

double gp_pixel_bound(const struct gp_pixel_floor *f,
                      const struct gp_pixel_error *e, double gain)
{
    const double peak = 1e-6 * (f->most - f->less);
    const double dark = fmax(f->least - f->less, 0.0) + peak;
    double sum = 0.0;
    if (!(peak > 0.0) || !(e->share < INFINITY))
        return INFINITY;
    for (int c = 0; c < 3; c++) {
        const double share = f->less > 0.0 ? e->share * f->layer[c] : 0.0;
        sum += gain * fabs(f->weight[c]) * (e->of[c] + share + f->lost[c]);
    }
    const double own =
        f->less > 0.0 ? 0.0 : e->share * (1.0 + fmax(-f->least, 0.0) / peak);
    return sum / dark + own;
}
