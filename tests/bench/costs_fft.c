/* Cost of fft. */
#include "costs_scene.h"

#include "core/memory.h"
#include "glare/fft/fft_priv.h"

#include <math.h>

// -- transforms ---------------------------------------------------------------

struct transform {
    const struct gp_fftwf *lib;
    struct gp_fft_plan_pair plan;
    void *in, *out;
};

enum { TRANSFORMS = 16 };

static void there_and_back(void *ctx)
{
    const struct transform *const t = ctx;
    for (int i = 0; i < TRANSFORMS; i++) {
        t->lib->execute_dft(t->plan.forward, t->in, t->out);
        t->lib->execute_dft(t->plan.backward, t->in, t->out);
    }
}

static struct transform make_transform(int n, enum gp_fft_plan how)
{
    struct transform t;
    if (gp_fftwf_open(NULL, &t.lib) ||
        gp_fft_plan_make(NULL, n, how, NULL, &t.plan) ||
        gp_alloc_zero(NULL, "in", (size_t) n, 8, &t.in) ||
        gp_alloc_zero(NULL, "out", (size_t) n, 8, &t.out))
        costs_die("transform");
    for (int i = 0; i < 2 * n; i++)
        ((float *) t.in)[i] = (float) i / (float) n;
    return t;
}

static void free_transform(struct transform *t)
{
    gp_fft_plan_free(&t->plan);
    gp_free(t->in);
    gp_free(t->out);
}

/* Milliseconds of one transform. */
static double transform_ms(int n, enum gp_fft_plan how)
{
    struct transform t = make_transform(n, how);
    const double ms = costs_time(there_and_back, &t) / (2.0 * TRANSFORMS);
    free_transform(&t);
    return ms;
}

/* Picoseconds over n log2 n of lengths `odd` times a power of two, the mean of
 * those from `first` to `last`. */
static double mean_ps(int odd, int first, int last, enum gp_fft_plan how)
{
    double logs = 0.0;
    int count = 0, n = odd;
    while (n < first)
        n *= 2;
    for (; n < last; n *= 2) {
        if (how == GP_FFT_PLAN_ESTIMATE && gp_fft_known(n))
            continue; // measured
        logs += log(transform_ms(n, how) * 1e9 / (n * log2(n)));
        count++;
    }
    return exp(logs / count);
}

static void measure_transforms(void)
{
    enum { ODDS = 7 };
    static const int odd[ODDS] = {1, 3, 5, 9, 15, 25, 7};
    double ps[2][ODDS];
    if (!costs_wants("GP_COST_FFT_PS"))
        return;
    for (int how = 0; how < 2; how++) { // estimates first: FFTW remembers
        for (int i = 0; i < ODDS; i++)
            ps[how][i] = mean_ps(odd[i], 256, odd[i] == 5 ? 4096 : 16384,
                                 (enum gp_fft_plan) how);
    }
    const double *const e = ps[GP_FFT_PLAN_ESTIMATE];
    const double *const m = ps[GP_FFT_PLAN_MEASURE];
    COSTS_PRINT(GP_COST_FFT_PS, m[0], m[1], m[2], m[3], m[4], m[5], m[6]);
    COSTS_PRINT(GP_COST_FFT_PS_LARGE_5,
                mean_ps(5, 4096, 16384, GP_FFT_PLAN_MEASURE));
    COSTS_PRINT(GP_COST_FFT_ESTIMATED, e[0] / m[0], e[1] / m[1], e[2] / m[2],
                e[3] / m[3], e[4] / m[4], e[5] / m[5], e[6] / m[6]);
}

// -- passes -------------------------------------------------------------------

/* Few sources, so that loading them takes no time, in most rows; nothing goes
 * direct, as a gain of nearly 0 needs no exact light. */
static void measure_passes(void)
{
    static const int size[3][2] = {{320, 240}, {1024, 768}, {3840, 2160}};
    double pass[3];
    if (!costs_wants("GP_COST_FFT_PASS"))
        return;
    for (int i = 0; i < 3; i++) {
        struct costs_run j = costs_make(&gp_engine_fft, size[i][0], size[i][1],
                                        4000, 1, 129);
        const struct gp_fft_placing p = gp_fft_place(&j.src, &j.k);
        j.params.gain = 1e-30f;
        pass[i] = costs_time(costs_run, &j) * GP_COST_FFT_PASS /
                  gp_fft_passes_ms(&j.src, &p, GP_FFT_PLAN_ESTIMATE);
        costs_free(&j);
    }
    COSTS_PRINT(GP_COST_FFT_PASS, pass[0], pass[1], pass[2]);
}

// -- the rest -----------------------------------------------------------------

/* Before anything else has opened the library. */
static void measure_library(void)
{
    struct gp_fft_plan_pair plan;
    const struct gp_fftwf *lib;
    const double start = costs_now();
    if (gp_fftwf_open(NULL, &lib) ||
        gp_fft_plan_make(NULL, 8, GP_FFT_PLAN_ESTIMATE, NULL, &plan))
        costs_die("libfftw3f");
    gp_fft_plan_free(&plan);
    if (costs_wants("GP_COST_FFT_LIBRARY"))
        COSTS_PRINT(GP_COST_FFT_LIBRARY, costs_now() - start);
}

/* FFTW remembers what it measured: estimates come first, and measuring is
 * tried on lengths that no one else here asks for. */
static double plan_ms(enum gp_fft_plan how)
{
    static const int length[2][4] = {
        {320, 640, 1280, 2304}, {784, 1120, 1344, 2016},
    };
    const double t = costs_now();
    for (int i = 0; i < 4; i++) {
        struct gp_fft_plan_pair plan;
        if (gp_fft_plan_make(NULL, length[how][i], how, NULL, &plan))
            costs_die("plan");
        gp_fft_plan_free(&plan);
    }
    return (costs_now() - t) / 4.0;
}

static volatile double sink;

static void norms(void *ctx)
{
    struct gp_fft_quarters q;
    gp_fft_find_quarters(ctx, 1024, 768, &q);
    sink = q.sum[0];
}

void costs_fft(void)
{
    measure_library();
    if (costs_wants("GP_COST_FFT_PLAN_ESTIMATE"))
        COSTS_PRINT(GP_COST_FFT_PLAN_ESTIMATE, plan_ms(GP_FFT_PLAN_ESTIMATE));
    measure_transforms();
    measure_passes();
    if (costs_wants("GP_COST_FFT_RUN"))
        COSTS_PRINT(GP_COST_FFT_RUN, costs_engine_ms(&gp_engine_fft, 8, 8,
                                                         1, 1, 3, NULL));
    if (costs_wants("GP_COST_FFT_SOURCE")) {
        double few, many; // the same box, nearly the same rows
        const double a =
            costs_engine_ms(&gp_engine_fft, 640, 480, 400, 2, 65, &few);
        const double b =
            costs_engine_ms(&gp_engine_fft, 640, 480, 400, 40, 65, &many);
        COSTS_PRINT(GP_COST_FFT_SOURCE, (b - a) / (3.0 * (many - few)));
    }
    if (costs_wants("GP_COST_FFT_NORMS")) {
        struct gp_kernel k = costs_kernel(512);
        COSTS_PRINT(GP_COST_FFT_NORMS,
                      costs_time(norms, &k) / (3.0 * k.w * k.h));
        gp_kernel_free(&k);
    }
    if (costs_wants("GP_COST_FFT_PLAN_MEASURE"))
        COSTS_PRINT(GP_COST_FFT_PLAN_MEASURE, plan_ms(GP_FFT_PLAN_MEASURE));
}
