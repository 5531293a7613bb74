#include "core/memory.h"
#include "core/parallel.h"
#include "glare/glare_priv.h"

#include <stdio.h>
#include <string.h>

static void clear_plane(void *ctx, int c, int thread)
{
    const struct gp_frame *const f = ctx;
    (void) thread;
    memset(f->layer.c[c], 0, gp_frame_pixels(f) * sizeof(float));
}

gp_status gp_glare_run(const struct gp_log *log,
    const struct gp_glare_params *p, struct gp_glare *g,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    struct gp_frame *f, struct gp_glare_stats *stats)
{
    static const double LONG_MS = 20e3;
    gp_status st = GP_OK;
    const char *const path = f->path ? f->path : "frame";
    int named = 0;
    *stats = (struct gp_glare_stats) {0};
    while (gp_engines[named] && strcmp(gp_engines[named]->name, p->engine) != 0)
        named++;
    if (!gp_engines[named])
        named = -1;
    if (named < 0 && strcmp(p->engine, "auto") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no engine has this name; use auto, direct, fft or "
                       "splat", p->engine);
    if (!f->layer.c[0])
        st = gp_planes_make(log, "layer", gp_frame_pixels(f), &f->layer);
    if (st)
        return st;
    if (!src->n) {
        gp_parallel_do(3, clear_plane, f);
        return GP_OK;
    }
    struct gp_candidate taken = {.engine = named, .splat = p->splat};
    struct gp_glare_params params = *p;
    struct gp_glare_job job = {
        .log = log, .params = &params, .src = src, .kernel = kernel,
        .layer = &f->layer, .stats = stats,
    };
    st = gp_floor_find(&job, &g->floor, &job.floor);
    if (st)
        return st;
    struct gp_pixel_floor floor = {0};
    if (p->tolerance_pixel > 0.0f)
        st = gp_pixel_floor_find(&job, f, &floor);
    if (!st && p->tolerance_pixel > 0.0f && named >= 0)
        st = gp_plan_pixel(&job, g, named, &floor, &taken.pixel);
    if (st)
        return st;
    if (named < 0) {
        st = gp_plan(&job, g, path, &floor, &taken);
        if (st)
            return st;
        stats->bound = taken.bound;
    } else {
        snprintf(stats->why, sizeof stats->why, "asked for");
        // a job on a farm should not find out after an hour that another
        // engine takes less
        const double ms = gp_engines[named]->predict(&job, g->state[named]).ms;
        struct gp_candidate c[GP_CANDIDATES];
        const int n = ms > LONG_MS ? gp_plan_candidates(&job, g, c) : 0;
        int best = 0;
        for (int i = 1; i < n; i++)
            best = c[i].exact && c[i].ms < c[best].ms ? i : best;
        if (n && c[best].engine != named)
            gp_say(log, GP_LEVEL_WARN,
                   "%s: %s will take about %.0f s for %zu sources; --engine %s "
                   "takes %.3g s, fewer sources come with a higher --threshold",
                   path, gp_engines[named]->name, ms * 1e-3, src->n,
                   gp_engines[c[best].engine]->name, c[best].ms * 1e-3);
    }
    params.splat = taken.splat;
    stats->engine = gp_engines[taken.engine]->name;
    stats->bound_pixel = taken.pixel;
    st = gp_engines[taken.engine]->run(&job, &g->state[taken.engine]);
    stats->bound = named >= 0 ? stats->bound + job.floor : taken.bound;
    return st;
}

void gp_glare_close(struct gp_glare *g)
{
    for (int i = 0; gp_engines[i]; i++)
        gp_engines[i]->close(&g->state[i]);
    gp_floor_free(&g->floor);
}

// -- a kernel spread over a disc: the layer of a frame that is the disc -------

gp_status gp_kernel_spread(const struct gp_log *log, const struct gp_kernel *k,
    int reach, const float *weight, struct gp_spread_kernel *out)
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
