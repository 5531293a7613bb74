/* What fft costs. */
#include "costs_scene.h"

#include "core/memory.h"
#include "glare/fft/lib.h"
#include "glare/fft/pass.h"
#include "glare/fft/place.h"

#include <math.h>
#include <stdio.h>

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

static void measure_transforms(void)
{
    enum { ODDS = 7, OCTAVES = 8 };
    static const char *const how_name[] = {"ESTIMATE", "MEASURE"};
    static const struct { int odd; const char *name; } class[ODDS] = {
        {1, "1"}, {3, "3"}, {5, "5"}, {9, "9"}, {15, "15"}, {25, "25"},
        {7, "OTHER"},
    };
    for (int i = 0; i < 2 * ODDS; i++) {
        char name[64];
        double ps[OCTAVES];
        const int how = i / ODDS;
        snprintf(name, sizeof name, "GP_COST_FFT_%s_%s", how_name[how],
                 class[i % ODDS].name);
        if (!costs_wants(name))
            continue;
        for (int o = 0; o < OCTAVES; o++) {
            int n = class[i % ODDS].odd;
            while (n < 64 << o)
                n *= 2;
            ps[o] = transform_ms(n, (enum gp_fft_plan) how) * 1e9 /
                    (n * log2(n));
        }
        costs_put(name, ps, OCTAVES);
    }
}

// -- passes -------------------------------------------------------------------

/* Square matrices, all rows used. */
struct passes {
    int n;
    struct gp_fft_job job;
    struct gp_fft_matrix m, kernel;
    int *place;
    float *layer;
};

static void load(const void *ctx, int c, int j, float *z)
{
    (void) ctx, (void) c;
    z[2 * (j % 7)] = 1.0f;
}

static void store(const void *ctx, int c, int j, const float *z)
{
    const struct passes *const p = ctx;
    float *const row = p->layer + (size_t) j * (size_t) p->n;
    (void) c;
    for (int x = 0; x < p->n * 3 / 4; x++)
        row[x] = z[2 * x];
}

static void rows(void *ctx)
{
    struct passes *const p = ctx;
    if (gp_fft_rows_in(&p->job, p->n, load, p, &p->m) ||
        gp_fft_rows_out(&p->job, &p->m, p->n, store, p))
        costs_die("rows");
}

static void columns(void *ctx)
{
    struct passes *const p = ctx;
    if (gp_fft_multiply(&p->job, &p->m, p->n, p->place, &p->kernel, 1, 0,
                        p->n))
        costs_die("columns");
}

static struct passes make_passes(int n, const struct gp_fft_plan_pair *plan)
{
    struct passes p = {
        .n = n, .job = {.x = plan, .y = plan, .channels = 1},
    };
    void *place, *layer;
    if (gp_fft_matrix_make(NULL, 1, n, n, &p.m) ||
        gp_fft_matrix_make(NULL, 1, n, n, &p.kernel) ||
        gp_alloc_zero(NULL, "place", (size_t) n, sizeof(int), &place) ||
        gp_alloc_zero(NULL, "layer", (size_t) n * (size_t) n, 4, &layer))
        costs_die("out of memory");
    p.place = place;
    p.layer = layer;
    const size_t floats = (size_t) p.m.columns * p.m.pitch * 2;
    for (size_t i = 0; i < floats; i++)
        p.m.z[0][i] = p.kernel.z[0][i] = 1e-3f * (float) (i % 11);
    for (int i = 0; i < n; i++)
        p.place[i] = i;
    return p;
}

static void measure_passes(void)
{
    static const int size[3] = {256, 1024, 4096};
    double row[3], column[3];
    if (!costs_wants("GP_COST_FFT_ROW_POINT") &&
        !costs_wants("GP_COST_FFT_COLUMN_POINT"))
        return;
    for (int i = 0; i < 3; i++) {
        const int n = size[i];
        struct transform t = make_transform(n, GP_FFT_PLAN_ESTIMATE);
        const double one =
            costs_time(there_and_back, &t) / (2.0 * TRANSFORMS);
        struct passes p = make_passes(n, &t.plan);
        row[i] = (costs_time(rows, &p) / n - one) / n;
        columns(&p); // leaves numbers that stay in range
        memset(p.m.z[0], 0, (size_t) p.m.columns * p.m.pitch * 8);
        column[i] = (costs_time(columns, &p) / (n / 2 + 1) - 2.0 * one) / n;
        gp_fft_matrix_free(&p.m);
        gp_fft_matrix_free(&p.kernel);
        gp_free(p.place);
        gp_free(p.layer);
        free_transform(&t);
    }
    costs_put("GP_COST_FFT_ROW_POINT", row, 3);
    costs_put("GP_COST_FFT_COLUMN_POINT", column, 3);
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
        costs_put_one("GP_COST_FFT_LIBRARY", costs_now() - start);
}

/* FFTW remembers what it measured: estimates come first, and measuring is
 * tried on lengths that no one else here asks for. */
static void measure_plans(enum gp_fft_plan how, const char *name)
{
    static const int length[2][4] = {
        {320, 640, 1280, 2304}, {784, 1120, 1344, 2016},
    };
    if (!costs_wants(name))
        return;
    const double t = costs_now();
    for (int i = 0; i < 4; i++) {
        struct gp_fft_plan_pair plan;
        if (gp_fft_plan_make(NULL, length[how][i], how, NULL, &plan))
            costs_die("plan");
        gp_fft_plan_free(&plan);
    }
    costs_put_one(name, (costs_now() - t) / 4.0);
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
    measure_plans(GP_FFT_PLAN_ESTIMATE, "GP_COST_FFT_PLAN_ESTIMATE");
    measure_transforms();
    measure_passes();
    if (costs_wants("GP_COST_FFT_RUN"))
        costs_put_one("GP_COST_FFT_RUN", costs_engine_ms(&gp_engine_fft, 8, 8,
                                                         1, 1, 3, NULL));
    if (costs_wants("GP_COST_FFT_SOURCE")) {
        double few, many; // the same box, nearly the same rows
        const double a =
            costs_engine_ms(&gp_engine_fft, 640, 480, 400, 2, 65, &few);
        const double b =
            costs_engine_ms(&gp_engine_fft, 640, 480, 400, 40, 65, &many);
        costs_put_one("GP_COST_FFT_SOURCE", (b - a) / (3.0 * (many - few)));
    }
    if (costs_wants("GP_COST_FFT_NORMS")) {
        struct gp_kernel k = costs_kernel(512);
        costs_put_one("GP_COST_FFT_NORMS",
                      costs_time(norms, &k) / (3.0 * k.w * k.h));
        gp_kernel_free(&k);
    }
    measure_plans(GP_FFT_PLAN_MEASURE, "GP_COST_FFT_PLAN_MEASURE");
}
