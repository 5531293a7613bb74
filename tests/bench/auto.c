/* `auto` against the best single engine, frame by frame.
 *
 *   auto KERNEL RUNS FRAME...
 *
 * KERNEL is a file or builtin:NAME. Each of direct, fft and auto keeps its own
 * state, as in a sequence of this one frame, and has been warmed up; runs
 * alternate, so that a machine whose speed drifts drifts for all; medians of
 * RUNS. An engine whose first run takes over 20 ms and five times the
 * other's time runs no more. The error is auto's, against the double-precision
 * reference.
 */
#include "median.h"

#include "core/clock.h"
#include "core/memory.h"
#include "core/colour.h"
#include "glare/engine.h"
#include "glare/model/model.h"
#include "glare/sensors.h"
#include "io/read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TECHNIQUES = 3, MOST_RUNS = 99, WARM_UPS = 40 };
static const double LONG_MS = 20.0, HOPELESS = 5.0, WARM_MS = 1500.0;
static const char *const names[TECHNIQUES] = {"direct", "fft", "auto"};

static const struct gp_log auto_log = BENCH_LOG("auto");

struct technique {
    struct gp_glare g;
    struct gp_glare_params p;
    struct gp_glare_stats stats;
    double ms[MOST_RUNS], first, median;
    bool out; // not run
};

struct frame {
    struct gp_frame f;
    struct gp_sources src;
    const struct gp_kernel *k;
    struct technique t[TECHNIQUES];
};

static double run_engine(struct frame *w, int i)
{
    struct technique *const t = &w->t[i];
    const double start = gp_now_ms();
    if (gp_glare_run(&auto_log, &t->p, &t->g, &w->src, w->k, &w->f, &t->stats))
        exit(70);
    return gp_now_ms() - start;
}

static void measure(struct frame *w, int runs)
{
    for (int i = 0; i < TECHNIQUES; i++) {
        struct technique *const t = &w->t[i];
        t->p = (struct gp_glare_params) GP_GLARE_DEFAULTS;
        t->p.engine = names[i];
    }
    for (int i = 0; i < 2; i++)
        w->t[i].first = run_engine(w, i);
    for (int i = 0; i < TECHNIQUES; i++) {
        struct technique *const t = &w->t[i];
        double all = 0.0;
        t->out = i < 2 && t->first > LONG_MS &&
                 t->first > HOPELESS * w->t[1 - i].first;
        for (int k = 0; !t->out && k < (i < 2 ? 3 : WARM_UPS) && all < WARM_MS;
             k++)
            all += run_engine(w, i);
    }
    for (int k = 0; k < runs; k++) {
        // each follows each other as often: caches and clock remember
        static const int order[6][TECHNIQUES] = {
            {0, 1, 2}, {2, 1, 0}, {1, 2, 0}, {0, 2, 1}, {2, 0, 1}, {1, 0, 2},
        };
        for (int j = 0; j < TECHNIQUES; j++) {
            const int i = order[k % 6][j];
            if (!w->t[i].out)
                run_engine(w, i);
            w->t[i].ms[k] = w->t[i].out ? INFINITY : run_engine(w, i);
        }
    }
    for (int i = 0; i < TECHNIQUES; i++) {
        w->t[i].median = median(w->t[i].ms, runs);
    }
}

/* auto's, whose run was the last. */
static double error_of(struct frame *w)
{
    struct gp_glare_error e = {.rel_l2 = INFINITY};
    double *const exact =
        malloc(3 * gp_frame_pixels(&w->f) * sizeof *exact);
    if (exact && gp_glare_reference(&auto_log, NULL, &w->src, w->k, exact) == GP_OK)
        gp_glare_measure(&w->f, &w->f.layer, exact, 1.0f, NULL, &e);
    free(exact);
    return e.rel_l2;
}

/* The kernel for a frame. */
static int open_kernel(const char *name, const struct gp_frame *f,
                       struct gp_kernel *k)
{
    const struct gp_read_params read = GP_READ_DEFAULTS;
    struct gp_kernel_params p = {0};
    struct gp_frame image = {0};
    if (gp_recipe_is(name)) {
        const struct gp_field field = gp_field_of(f, GP_USUAL_FOV);
        struct gp_recipe r;
        if (gp_recipe_parse(&auto_log, name, &r))
            return 0;
        const int ok = gp_model_kernel(&auto_log, &r, 1, &field, k) == GP_OK;
        gp_recipe_free(&r);
        return ok;
    }
    const int ok = gp_read_frame(&auto_log, &read, name, &image) == GP_OK &&
                   gp_kernel_from_frame(&auto_log, &p, &image, k) == GP_OK;
    gp_frame_free(&image);
    return ok;
}

/* auto's time over the fastest engine's; 0 for a frame that is not read or
 * holds no light. */
static double try_frame(const char *path, const char *kernel, int runs)
{
    static struct frame w;
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    const struct gp_read_params read = GP_READ_DEFAULTS;
    double ratio = 0.0;
    struct gp_kernel k = {0};
    w = (struct frame) {.k = &k};
    if (gp_read_frame(&auto_log, &read, path, &w.f) ||
        gp_sense(&auto_log, &sense, &w.f, &w.src))
        return 0.0;
    if (w.src.n && open_kernel(kernel, &w.f, &k)) {
        measure(&w, runs);
        const double best = fmin(w.t[0].median, w.t[1].median);
        const double error = error_of(&w);
        ratio = w.t[2].median / best;
        printf("%6.3f  %-6s %9.3f ms  direct %9.3f  fft %9.3f  "
               "rel_l2 %8.1e of %8.1e  %4dx%-4d n %7zu  %s\n",
               ratio, w.t[2].stats.engine, w.t[2].median, w.t[0].median,
               w.t[1].median, error,
               w.t[2].stats.bound, w.src.w, w.src.h, w.src.n, path);
        if (!(error <= w.t[2].stats.bound))
            printf("        over its bound\n");
        fflush(stdout);
    }
    for (int i = 0; i < TECHNIQUES; i++)
        gp_glare_close(&w.t[i].g);
    gp_kernel_free(&k);
    gp_sources_free(&w.src);
    gp_frame_free(&w.f);
    return ratio;
}

int main(int argc, char **argv)
{
    double worst = 0.0;
    const char *where = "none";
    gp_keep_memory();
    if (argc < 4) {
        fprintf(stderr, "usage: auto KERNEL RUNS FRAME...\n");
        return 2;
    }
    int runs = atoi(argv[2]);
    runs = runs < 1 ? 1 : runs > MOST_RUNS ? MOST_RUNS : runs;
    for (int i = 3; i < argc; i++) {
        const double ratio = try_frame(argv[i], argv[1], runs);
        if (ratio > worst) {
            worst = ratio;
            where = argv[i];
        }
    }
    printf("worst: auto takes %.3f times the fastest engine's time, on %s\n",
           worst, where);
    return 0;
}
