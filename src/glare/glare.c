#include "core/parallel.h"
#include "glare/engine.h"

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

/* The engine with the fewest predicted milliseconds; says why. */
static int fastest(const struct gp_glare_job *job)
{
    char *const why = job->stats->why;
    const size_t room = sizeof job->stats->why;
    int best = 0;
    double best_ms = 0.0;
    size_t used = 0;
    for (int i = 0; gp_engines[i]; i++) {
        const double ms = gp_engines[i]->predict_ms(job);
        if (i == 0 || ms < best_ms) {
            best = i;
            best_ms = ms;
        }
        const int n = snprintf(why + used, room - used, "%s%s %.3g",
                               i ? ", " : "predicted ms on one core: ",
                               gp_engines[i]->name, ms);
        used = n > 0 && (size_t) n < room - used ? used + (size_t) n : room - 1;
    }
    return best;
}

/* Says so when the engine that was asked for will take long and another not:
 * a job on a farm should not find out after an hour. */
static void warn_of_patience(const struct gp_glare_job *job, int i,
                             const char *path)
{
    static const double LONG_MS = 20e3;
    const double ms = gp_engines[i]->predict_ms(job);
    if (ms <= LONG_MS)
        return; // the other engines are not asked: that counts all sources
    struct gp_glare_stats stats = {0};
    struct gp_glare_job other = *job;
    other.stats = &stats;
    const int best = fastest(&other);
    if (best != i)
        gp_say(job->log, GP_LEVEL_WARN,
               "%s: %s will take about %.0f s for %zu sources; --engine %s "
               "takes %.3g s, fewer sources come with a higher --threshold",
               path, gp_engines[i]->name, ms * 1e-3, job->src->n,
               gp_engines[best]->name,
               gp_engines[best]->predict_ms(job) * 1e-3);
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
    const struct gp_glare_job job = {
        .log = log, .params = p, .src = src, .kernel = kernel,
        .layer = &f->layer, .stats = stats,
    };
    const int i = named >= 0 ? named : fastest(&job);
    if (named >= 0) {
        snprintf(stats->why, sizeof stats->why, "asked for");
        warn_of_patience(&job, named, f->path ? f->path : "frame");
    }
    stats->engine = gp_engines[i]->name;
    return gp_engines[i]->run(&job, &g->state[i]);
}

void gp_glare_close(struct gp_glare *g)
{
    for (int i = 0; gp_engines[i]; i++)
        gp_engines[i]->close(&g->state[i]);
}
