#include "core/parallel.h"
#include "glare/engine.h"
#include "glare/plan.h"
#include "glare/scale.h"

#include <stdio.h>
#include <string.h>

const struct gp_engine *const gp_engines[] = {
    &gp_engine_direct, &gp_engine_fft, &gp_engine_splat, NULL,
};

/* The index in gp_engines, or -1. */
static int find(const char *name)
{
    for (int i = 0; gp_engines[i]; i++) {
        if (strcmp(gp_engines[i]->name, name) == 0)
            return i;
    }
    return -1;
}

/* Says so when the engine that was asked for will take long and another not:
 * a job on a farm should not find out after an hour. */
static void warn_of_patience(const struct gp_glare_job *job,
                             const struct gp_glare *g, int named,
                             const char *path)
{
    static const double LONG_MS = 20e3;
    const double ms = gp_engines[named]->predict(job, g->state[named]).ms;
    if (ms <= LONG_MS)
        return;
    struct gp_candidate c[GP_CANDIDATES];
    const int n = gp_plan_candidates(job, g, c);
    int best = 0;
    for (int i = 1; i < n; i++) {
        if (c[i].exact && c[i].ms < c[best].ms)
            best = i;
    }
    if (c[best].engine != named)
        gp_say(job->log, GP_LEVEL_WARN,
               "%s: %s will take about %.0f s for %zu sources; --engine %s "
               "takes %.3g s, fewer sources come with a higher --threshold",
               path, gp_engines[named]->name, ms * 1e-3, job->src->n,
               gp_engines[c[best].engine]->name, c[best].ms * 1e-3);
}

struct clear {
    const struct gp_planes *p;
    size_t n;
};

static void clear_plane(void *ctx, int c, int thread)
{
    const struct clear *const s = ctx;
    (void) thread;
    memset(s->p->c[c], 0, s->n * sizeof(float));
}

/* The engine that was named, or that the plan takes. */
static gp_status run_engine(struct gp_glare_job job, struct gp_glare *g,
                            int named, const char *path)
{
    struct gp_glare_params params = *job.params;
    struct gp_glare_stats *const stats = job.stats;
    struct gp_candidate taken;
    gp_status st = GP_OK;
    if (named >= 0) {
        snprintf(stats->why, sizeof stats->why, "asked for");
        warn_of_patience(&job, g, named, path);
        taken = (struct gp_candidate) {.engine = named};
    } else {
        st = gp_plan(&job, g, path, &taken);
        if (st)
            return st;
        params.splat = taken.splat;
        stats->bound = taken.bound;
        job.params = &params;
    }
    stats->engine = gp_engines[taken.engine]->name;
    st = gp_engines[taken.engine]->run(&job, &g->state[taken.engine]);
    stats->bound = named >= 0 ? stats->bound + job.floor : taken.bound;
    return st;
}

gp_status gp_glare_run(const struct gp_log *log,
                       const struct gp_glare_params *p, struct gp_glare *g,
                       const struct gp_sources *src,
                       const struct gp_kernel *kernel, struct gp_frame *f,
                       struct gp_glare_stats *stats)
{
    *stats = (struct gp_glare_stats) {0};
    const int named = find(p->engine);
    if (named < 0 && strcmp(p->engine, "auto") != 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: no engine has this name; use auto, direct, fft or "
                       "splat", p->engine);
    const size_t n = gp_frame_pixels(f);
    if (!f->layer.c[0]) {
        gp_status st = gp_planes_make(log, "layer", n, &f->layer);
        if (st)
            return st;
    }
    if (!src->n) {
        struct clear all = {&f->layer, n};
        gp_parallel_do(3, clear_plane, &all);
        return GP_OK;
    }
    struct gp_sources light = {0};
    struct gp_glare_job job = {
        .log = log, .params = p, .src = src, .kernel = kernel,
        .layer = &f->layer, .stats = stats,
    };
    gp_status st = gp_scale_job(&job, &g->scale, &light);
    if (!st)
        st = gp_scale_floor(&job, &g->scale, &job.floor);
    if (!st)
        st = run_engine(job, g, named, f->path ? f->path : "frame");
    if (!st)
        gp_scale_back(&job);
    gp_scale_light_free(&light);
    return st;
}

void gp_glare_close(struct gp_glare *g)
{
    for (int i = 0; gp_engines[i]; i++)
        gp_engines[i]->close(&g->state[i]);
    gp_scale_free(&g->scale);
}
