#include "core/memory.h"
#include "glare/engine.h"
#include "glare/sources.h"

/* The engines do it, on a frame just large enough. */
gp_status gp_kernel_spread(const struct gp_log *log, const struct gp_kernel *k,
                           int reach, const float *weight,
                           struct gp_spread_kernel *out)
{
    gp_status st;
    const int w = k->w + 2 * reach, h = k->h + 2 * reach;
    const int side = 2 * reach + 1;
    const struct gp_sources frame = {
        .w = w, .h = h, .luminance = {0.3f, 0.6f, 0.1f},
    };
    struct gp_frame f = {.data = {0, 0, w, h}, .display = {0, 0, w, h}};
    struct gp_glare_params p = GP_GLARE_DEFAULTS;
    struct gp_glare engines = {0};
    struct gp_glare_stats stats;
    struct gp_sources disc = {0};
    p.engine = reach > 3 ? "fft" : "direct";
    GP_TRY(gp_sources_make(log, &frame, (size_t) side * (size_t) side, &disc));
    // the kernel's centre may lie outside it, and pixels of the disc with it
    for (int i = 0; i < side * side; i++) {
        const int x = k->cx + i % side, y = k->cy + i / side;
        const float rgb[3] = {weight[i], weight[i], weight[i]};
        if (x >= 0 && x < w && y >= 0 && y < h)
            gp_sources_add(&disc, x, y, rgb);
    }
    gp_sources_finish(&disc);
    GP_TRY(gp_glare_run(log, &p, &engines, &disc, k, &f, &stats));
    *out = (struct gp_spread_kernel) {
        .w = w, .h = h, .cx = k->cx + reach + 0.5, .cy = k->cy + reach + 0.5,
        .k = f.layer, .serial = gp_serial_next(),
    };
    f.layer = (struct gp_planes) {0};
out:
    gp_glare_close(&engines);
    gp_sources_free(&disc);
    gp_planes_free(&f.layer);
    return st;
}
