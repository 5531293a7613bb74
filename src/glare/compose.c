#include "glare/compose.h"

#include "core/cpu.h"
#include "core/parallel.h"

#include <stdbool.h>
#include <string.h>

struct composing {
    struct gp_frame *f;
    const struct gp_sources *src;
    float gain, keep;
    bool scatter;
};

GP_CLONES static void add_row(const float *in, const float *layer, float gain,
                              size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = in[i] + gain * layer[i];
}

/* The sources' pixels once more, with their own light taken away first: where
 * gain is 1 and the source is the whole pixel nothing of it is left, whatever
 * the rounding of in + gain * layer was. */
static void scatter_row(const struct composing *m, int c, int y,
                        const float *in, const float *layer, float *out)
{
    for (uint32_t i = m->src->row[y]; i < m->src->row[y + 1]; i++) {
        const int32_t x = m->src->x[i];
        out[x] = (in[x] - m->gain * m->src->rgb[c][i]) + m->gain * layer[x];
    }
}

static void dim_row(float keep, size_t n, float *out)
{
    for (size_t i = 0; i < n; i++)
        out[i] *= keep;
}

static void compose_row(void *ctx, int y, int thread)
{
    const struct composing *m = ctx;
    const struct gp_frame *f = m->f;
    const size_t w = (size_t) gp_frame_w(f);
    const size_t at = (size_t) y * w;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *in = f->rgb.c[c] + at;
        float *out = f->lit.c[c] + at;
        const float *layer = f->layer.c[c] ? f->layer.c[c] + at : NULL;
        if (layer)
            add_row(in, layer, m->gain, w, out);
        else
            memcpy(out, in, w * sizeof *out);
        if (layer && m->scatter)
            scatter_row(m, c, y, in, layer, out);
        if (m->keep < 1.0f)
            dim_row(m->keep, w, out);
    }
}

gp_status gp_compose(const struct gp_log *log,
                     const struct gp_compose_params *p,
                     const struct gp_sources *src, struct gp_frame *f)
{
    struct composing m = {
        .f = f, .src = src, .gain = p->gain, .keep = 1.0f - p->dim,
        .scatter = p->mix == GP_MIX_SCATTER && src->n > 0,
    };
    if (m.scatter && (src->w != gp_frame_w(f) || src->h != gp_frame_h(f)))
        return gp_fail(log, GP_ERR_BUG,
                       "%s: the sources are those of another frame (%dx%d, "
                       "the frame is %dx%d); report this", f->path, src->w,
                       src->h, gp_frame_w(f), gp_frame_h(f));
    if (!f->lit.c[0]) {
        gp_status st = gp_planes_make(log, "lit frame", gp_frame_pixels(f),
                                      &f->lit);
        if (st)
            return st;
    }
    gp_parallel_do(gp_frame_h(f), compose_row, &m);
    return GP_OK;
}
