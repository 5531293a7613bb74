/* Adds the layer to the frame. Rows share nothing, so the result is the same
 * for any number of threads. */
#include "glare/compose.h"

#include "core/cpu.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <float.h>
#include <string.h>

struct composing {
    struct gp_frame *f;
    const struct gp_sources *src;
    float gain;
    float taken;  // share of a source's light that leaves its pixel
    float keep;   // share that the pupil lets through
};

/* Clamps infinite light to the largest float. */
static inline __attribute__((always_inline)) float finite(float v)
{
    return gp_maxf(gp_minf(v, FLT_MAX), -FLT_MAX);
}

GP_CLONES static void add_row(const float *in, const float *layer, float gain,
                              size_t n, float *restrict out)
{
    for (size_t i = 0; i < n; i++)
        out[i] = finite(in[i] + gain * layer[i]);
}

/* One row: in + gain * layer, less what sources scatter, dimmed. */
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
        // the sources' pixels once more, with their own light taken away first:
        // where gain is 1 and the source is the whole pixel nothing of it is
        // left, whatever the rounding of in + gain * layer was
        if (layer && m->taken > 0.0f) {
            const struct gp_sources *const src = m->src;
            for (uint32_t i = src->row[y]; i < src->row[y + 1]; i++) {
                const int32_t x = src->x[i];
                out[x] = finite((in[x] - m->taken * src->rgb[c][i]) +
                                m->gain * layer[x]);
            }
        }
        for (size_t x = 0; m->keep < 1.0f && x < w; x++)
            out[x] *= m->keep;
    }
}

gp_status gp_compose(const struct gp_log *log,
                     const struct gp_compose_params *p,
                     const struct gp_sources *src, struct gp_frame *f)
{
    struct composing m = {
        .f = f, .src = src, .gain = p->gain, .keep = 1.0f - p->dim,
        .taken = p->mix == GP_MIX_SCATTER && src->n > 0
                     ? gp_minf(p->gain, 1.0f) : 0.0f,
    };

    if (m.taken > 0.0f && (src->w != gp_frame_w(f) || src->h != gp_frame_h(f)))
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
