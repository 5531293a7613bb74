#include "glare/engine.h"

#include <math.h>

/* Sums and maxima, row after row. */
struct row {
    double square, exact_square, max_abs, max_rel, peak, sum, exact_sum;
};

struct measure {
    const struct gp_frame *f;
    const struct gp_planes *layer;
    const double *exact;
    double gain, peak;
};

/* The larger; a layer that is not a number is as wrong as can be. */
static double worse(double a, double b)
{
    return b != b ? INFINITY : fmax(a, b);
}

static void measure_row(const struct measure *m, int y, struct row *r)
{
    const int w = gp_frame_w(m->f);
    const size_t plane = gp_frame_pixels(m->f);
    for (int x = 0; x < w; x++) {
        const size_t i = (size_t) y * (size_t) w + (size_t) x;
        double composite = 0.0, wrong = 0.0;
        for (int c = 0; c < 3; c++) {
            const double exact = m->exact[(size_t) c * plane + i];
            const double got = (double) m->layer->c[c][i];
            const double weight = (double) m->f->luminance[c];
            composite += weight *
                         ((double) m->f->rgb.c[c][i] + m->gain * exact);
            wrong += weight * m->gain * (got - exact);
            r->square += (got - exact) * (got - exact);
            r->exact_square += exact * exact;
            r->max_abs = worse(r->max_abs, fabs(got - exact));
            r->sum += got;
            r->exact_sum += exact;
        }
        r->peak = fmax(r->peak, composite);
        if (wrong != 0.0)
            r->max_rel = worse(r->max_rel,
                               fabs(wrong) / (fmax(composite, 0.0) +
                                              1e-6 * m->peak));
    }
}

void gp_glare_measure(const struct gp_frame *f, const struct gp_planes *layer,
                      const double *exact, float gain,
                      struct gp_glare_error *out)
{
    struct measure m = {
        .f = f, .layer = layer, .exact = exact, .gain = (double) gain,
    };
    struct row all = {0};
    // the peak is needed before any relative error can be taken
    for (int pass = 0; pass < 2; pass++) {
        m.peak = all.peak;
        all = (struct row) {0};
        for (int y = 0; y < gp_frame_h(f); y++)
            measure_row(&m, y, &all);
    }
    *out = (struct gp_glare_error) {
        .rel_l2 = all.exact_square > 0.0
                      ? sqrt(all.square / all.exact_square)
                      : sqrt(all.square),
        .max_rel = all.max_rel,
        .max_abs = all.max_abs,
        .flux_error = all.exact_sum > 0.0
                          ? fabs(all.sum / all.exact_sum - 1.0)
                          : fabs(all.sum),
    };
}
