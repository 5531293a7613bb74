/* The glare stage with a kernel over the whole field against the same stage
 * with one of 511 pixels, frame by frame in one run.
 *
 *   tail RECIPE RUNS FRAME.exr...
 *
 * Both take the engine fft, from the sources on; pairs alternate, so a machine
 * whose speed drifts drifts for both. Times are those of all threads together.
 * The error is against the whole kernel's sum in double. */
#include "median.h"

#include "core/memory.h"
#include "glare/engine.h"
#include "glare/model/model.h"
#include "glare/sensors.h"
#include "io/read.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static const struct gp_log tail_log = BENCH_LOG("tail");

/* Milliseconds of work of all threads. */
static double work_ms(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return 1e3 * (double) t.tv_sec + 1e-6 * (double) t.tv_nsec;
}

enum { MOST_RUNS = 200 };

/* The two kernels: a field's, and its middle 511 pixels. */
static gp_status make_both(const struct gp_recipe *r, const struct gp_frame *f,
                           struct gp_kernel k[2], double *ms)
{
    const struct gp_field field = gp_field_of(f, 30.0);
    const double from = work_ms();
    gp_status st = gp_model_kernel(&tail_log, r, 1, &field, &k[0]);
    *ms = work_ms() - from;
    return st ? st : gp_kernel_whole(&tail_log, &k[0], 256, 256, &k[1]);
}

static gp_status compare(const struct gp_recipe *r, int runs, const char *path)
{
    static double took[2][MOST_RUNS], ratio[MOST_RUNS];
    const struct gp_read_params read = GP_READ_DEFAULTS;
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct gp_glare g[2] = {0};
    struct gp_glare_stats stats;
    struct gp_glare_error error;
    struct gp_frame f = {0};
    struct gp_kernel k[2] = {0};
    struct gp_sources src = {0};
    double *exact = NULL, making;
    gp_status st;
    params.engine = "fft";
    GP_TRY(gp_read_frame(&tail_log, &read, path, &f));
    GP_TRY(make_both(r, &f, k, &making));
    GP_TRY(gp_sense(&tail_log, &sense, &f, &src));
    for (int i = -2; i < runs; i++) { // two warm-ups
        double ms[2];
        for (int j = 1; j >= 0; j--) {
            const double from = work_ms();
            GP_TRY(gp_glare_run(&tail_log, &params, &g[j], &src, &k[j], &f,
                                &stats));
            ms[j] = work_ms() - from;
        }
        if (i >= 0) {
            took[0][i] = ms[0];
            took[1][i] = ms[1];
            ratio[i] = ms[0] / ms[1];
        }
    }
    GP_TRY(gp_alloc(&tail_log, "exact", 3 * gp_frame_pixels(&f),
                    sizeof *exact, &exact));
    GP_TRY(gp_glare_reference(&tail_log, NULL, &src, &k[0], exact));
    gp_glare_measure(&f, &f.layer, exact, 1.0f, NULL, &error);
    printf("%s %dx%d, %zu sources: made in %.2f ms; fft %dx%d core %d %d hot %zu "
           "%.2f ms; 511 pixels %.2f ms, ratio %.3f "
           "(medians of %d); rel_l2 %.2g, bound %.2g; left out %.3g\n",
           path, gp_frame_w(&f), gp_frame_h(&f), src.n, making, stats.fft_w,
           stats.fft_h, stats.fft_core[0], stats.fft_core[1], stats.hot,
           median(took[0], runs),
           median(took[1], runs), median(ratio, runs),
           runs, error.rel_l2, stats.bound, k[0].left_out);
out:
    gp_free(exact);
    gp_sources_free(&src);
    for (int i = 0; i < 2; i++) {
        gp_glare_close(&g[i]);
        gp_kernel_free(&k[i]);
    }
    gp_frame_free(&f);
    return st;
}

int main(int argc, char **argv)
{
    struct gp_recipe r;
    gp_status st = GP_OK;
    gp_keep_memory();
    if (argc < 4) {
        fprintf(stderr, "usage: tail RECIPE RUNS FRAME...\n");
        return 2;
    }
    const int runs = atoi(argv[2]);
    if (gp_recipe_parse(&tail_log, argv[1], &r))
        return 2;
    for (int i = 3; i < argc && !st; i++)
        st = compare(&r, runs < 1 ? 1 : runs > MOST_RUNS ? MOST_RUNS : runs,
                     argv[i]);
    gp_recipe_free(&r);
    return (int) st;
}
