#include "tone/ocio.h"

#include "core/bridge.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <float.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 4096 }; // pixels at a time: 96 KiB in and out

struct gp_ocio {
    const struct gp_ocio_api *api;
    struct gp_ocio_made made;
};

gp_status gp_ocio_open(const struct gp_log *log,
                       const struct gp_ocio_params *p, struct gp_ocio **out)
{
    static const struct gp_ocio_api *api; // stays open until the end
    char why[2048];
    struct gp_ocio *o;
    *out = NULL;
    if (!api)
        api = gp_bridge_open("glarepp-ocio.so", "gp_ocio_api", why, sizeof why);
    if (api && api->version != GP_OCIO_API_VERSION) {
        snprintf(why, sizeof why, "glarepp-ocio.so is of another version");
        api = NULL;
    }
    if (!api)
        return gp_fail(log, GP_ERR_IO,
                       "--ocio: the OpenColorIO bridge cannot be opened (%s); "
                       "put it beside the program", why);
    gp_status st = gp_alloc_zero(log, "OCIO", 1, sizeof *o, &o);
    if (st)
        return st;
    o->api = api;
    st = (gp_status) api->open(p, &o->made, why, sizeof why);
    if (st) {
        gp_free(o);
        return gp_fail(log, st, "%s", why);
    }
    *out = o;
    return GP_OK;
}

void gp_ocio_close(struct gp_ocio **ocio)
{
    if (*ocio)
        (*ocio)->api->close(&(*ocio)->made);
    GP_FREE(*ocio);
}

const struct gp_ocio_names *gp_ocio_names(const struct gp_ocio *ocio)
{
    return &ocio->made.names;
}

// -- pixels ------------------------------------------------------------------

struct pass {
    const struct gp_ocio_api *api;
    const void *processor;
    const struct gp_planes *in;
    struct gp_planes *out;
    float scale;
    size_t pixels;
};

static gp_status pass_block(void *ctx, int block, int thread)
{
    const struct pass *p = ctx;
    const size_t at = (size_t) block * BLOCK, left = p->pixels - at;
    const size_t n = left < BLOCK ? left : BLOCK;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const in = p->in->c[c] + at;
        float *const out = p->out->c[c] + at;
        for (size_t i = 0; i < n; i++) // NaN stays
            out[i] = gp_maxf(-FLT_MAX, gp_minf(FLT_MAX, in[i] * p->scale));
    }
    return p->api->apply(p->processor, p->out->c[0] + at, p->out->c[1] + at,
                         p->out->c[2] + at, n) ? GP_ERR_BUG : GP_OK;
}

/* Makes `out` where it is empty, named `what` in errors, and runs the pass. */
static gp_status run_pass(const struct gp_log *log, const char *what,
                          struct pass *p)
{
    const int blocks = (int) ((p->pixels + BLOCK - 1) / BLOCK);
    gp_status st = p->out->c[0]
                       ? GP_OK : gp_planes_make(log, what, p->pixels, p->out);
    if (st)
        return st;
    if (!p->processor)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "OCIO: this transform was never asked for");
    st = gp_parallel(blocks, pass_block, p, NULL);
    return !st ? GP_OK : gp_fail_bare(log, st,
        "OCIO: OpenColorIO failed on the pixels; free some memory");
}

gp_status gp_ocio_show(const struct gp_log *log, const struct gp_ocio *ocio,
                       const struct gp_tone_params *p, struct gp_frame *f)
{
    return run_pass(log, "shown frame", &(struct pass) {
        .api = ocio->api, .processor = ocio->made.view, .in = &f->lit,
        .out = &f->shown, .scale = gp_tone_scale(p, f),
        .pixels = gp_frame_pixels(f),
    });
}

gp_status gp_ocio_convert(const struct gp_log *log, const struct gp_ocio *ocio,
                          const struct gp_frame *f, struct gp_planes *out)
{
    gp_status st = run_pass(log, "converted frame", &(struct pass) {
        .api = ocio->api, .processor = ocio->made.output, .in = &f->lit,
        .out = out, .scale = 1.0f, .pixels = gp_frame_pixels(f),
    });
    if (st)
        gp_planes_free(out);
    return st;
}
