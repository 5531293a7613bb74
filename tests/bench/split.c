/* Ways to keep a transform's rounding out of dark pixels: error and time of
 * each, beside those of what fft chooses (src/glare/fft/split.c).
 *
 *   split FRAME.exr KERNEL.exr [RUNS]
 *
 * For each way: the largest error of a pixel of the composite over its own
 * luminance, and the least CPU time of RUNS (5) over that of the same transforms
 * in float, with which its runs alternate: take one processor (taskset -c 0).
 * Kernels' spectra are kept from run to run, and not counted.
 *
 *   columns  the columns of lowest frequency, which hold most of the light's
 *            and the kernel's product, in double: pairs of frequencies, as a
 *            real layer has them
 *   rows     the rows of most energy by a second transform
 *   compensated  butterflies that keep their rounding; radix 2, against the
 *            same without */
#include "median.h"

#include "core/clock.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/direct/direct.h"
#include "glare/engine.h"
#include "glare/fft/fft.h"
#include "glare/sensors.h"
#include "io/read.h"

#include <fftw3.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct gp_log split_log = BENCH_LOG("split");

#define REAL float
#define FFT(name) fftwf_##name
#define OF(name) float_##name
#include "split_passes.h"
#undef REAL
#undef FFT
#undef OF
#define REAL double
#define FFT(name) fftw_##name
#define OF(name) double_##name
#include "split_passes.h"

#include "split_kept.h"

/* A frame, its light and its exact layer. */
struct test {
    struct gp_frame f;
    struct gp_kernel k;
    struct gp_sources src;
    double *exact;
    bool *every;     // rows, all taken
    int runs, nx, ny;
};

/* Ends the program where a call failed, which has printed why. */
static void must(gp_status st)
{
    if (st)
        exit((int) st);
}

/* A way to make the layer. */
struct way {
    void (*run)(struct test *t, void *ctx);
    void *ctx;
};

static double way_ms(struct test *t, struct way way)
{
    for (int c = 0; c < 3; c++)
        memset(t->f.layer.c[c], 0, gp_frame_pixels(&t->f) * sizeof(float));
    const double from = gp_cpu_ms();
    way.run(t, way.ctx);
    return gp_cpu_ms() - from;
}

static void compare(struct test *t, const char *name, struct way unit,
                    struct way way)
{
    struct gp_glare_error e;
    double best[2] = {INFINITY, INFINITY};
    for (int i = -1; i < t->runs; i++) { // a warm-up
        const double ms[2] = {way_ms(t, unit), way_ms(t, way)};
        for (int j = 0; j < 2 && i >= 0; j++)
            best[j] = fmin(best[j], ms[j]);
    }
    gp_glare_measure(&t->f, &t->f.layer, t->exact, 1.0f, &t->src, &e);
    printf("%-48s %8.2g %8.2f ms %6.2f\n", name, e.max_rel, best[1],
           best[1] / best[0]);
    fflush(stdout);
}

// -- the engine ---------------------------------------------------------------

struct engine {
    float gain;
    struct gp_glare g;
};

static void run_engine(struct test *t, void *ctx)
{
    struct engine *const e = ctx;
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    params.engine = "fft";
    params.gain = e->gain;
    must(gp_glare_run(&split_log, &params, &e->g, &t->src, &t->k, &t->f,
                      &stats));
}

/* A core of the kernel and sources of some light by direct, the rest in float. */
struct split {
    struct engine e;
    struct gp_kernel rest;
    struct gp_taps core, all;
    float hot; // sources from this up
};

static struct split make_split(const struct test *t, int radius, size_t hottest)
{
    struct split s = {.e.gain = 1e-9f, .hot = INFINITY};
    const struct gp_kernel *const k = &t->k;
    const size_t n = (size_t) k->w * (size_t) k->h;
    struct gp_planes p;
    must(gp_planes_make(&split_log, "rest", n, &p));
    for (int c = 0; c < 3; c++) {
        memcpy(p.c[c], k->k.c[c], n * sizeof(float));
        for (int y = k->cy - radius; y <= k->cy + radius; y++)
            memset(p.c[c] + y * k->w + k->cx - radius, 0,
                   sizeof(float) * (2 * (size_t) radius + 1));
    }
    must(gp_kernel_of_planes(&split_log, "rest", k->w, k->h, &p, &s.rest));
    must(gp_taps_make(&split_log, k, radius, &s.core));
    must(gp_taps_make(&split_log, k, -1, &s.all));
    size_t hot = 0;
    for (int b = GP_SOURCE_BINS - 2; b >= 0 && hot < hottest; b--) {
        hot += t->src.count[b];
        s.hot = gp_source_bin_start(b);
    }
    return s;
}

static void run_split(struct test *t, void *ctx)
{
    struct split *const s = ctx;
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct gp_glare_stats stats = {0};
    struct gp_sources hot, cool;
    params.engine = "fft";
    params.gain = s->e.gain;
    must(gp_sources_split(&split_log, &t->src, s->hot, &hot, &cool));
    must(gp_glare_run(&split_log, &params, &s->e.g, &cool, &s->rest, &t->f,
                      &stats));
    must(gp_direct_sum(&split_log, &cool, &s->core, true, &t->f.layer));
    if (hot.n)
        must(gp_direct_sum(&split_log, &hot, &s->all, true, &t->f.layer));
    gp_sources_free(&hot);
    gp_sources_free(&cool);
}

/* Compares its choice, no split (a gain that shows no rounding), and splits. */
static void compare_engine(struct test *t)
{
    static const struct { int radius; size_t hottest; } splits[] = {
        {8, 0}, {16, 39},
    };
    struct engine none = {.gain = 1e-9f}, chosen = {.gain = 1.0f};
    const struct way unit = {run_engine, &none};
    compare(t, "fft without a split", unit, unit);
    compare(t, "fft: as it chooses", unit, (struct way) {run_engine, &chosen});
    for (size_t i = 0; i < sizeof splits / sizeof *splits; i++) {
        char name[64];
        struct split s = make_split(t, splits[i].radius, splits[i].hottest);
        snprintf(name, sizeof name, "a core of radius %d, %zu sources direct",
                 splits[i].radius, splits[i].hottest);
        compare(t, name, unit, (struct way) {run_split, &s});
        gp_glare_close(&s.e.g);
        gp_kernel_free(&s.rest);
        gp_taps_free(&s.core);
        gp_taps_free(&s.all);
    }
    gp_glare_close(&none.g);
    gp_glare_close(&chosen.g);
}

// -- columns and rows in double -----------------------------------------------

/* Passes and the rows that each takes; NULL: none. */
struct parts {
    struct float_passes *a, *b;
    struct double_passes *d;
    const bool *of_a, *of_b, *of_d;
};

static void run_parts(struct test *t, void *ctx)
{
    const struct parts *const p = ctx;
    if (p->a)
        float_add(p->a, &t->src, p->of_a, &t->f.layer);
    if (p->b)
        float_add(p->b, &t->src, p->of_b, &t->f.layer);
    if (p->d)
        double_add(p->d, &t->src, p->of_d, &t->f.layer);
}

static void compare_columns(struct test *t, struct way unit, int share)
{
    const int all = t->nx / 2 + 1, low = all / share;
    char name[80];
    struct float_passes a = float_open(&t->k, t->nx, t->ny, low, all);
    struct double_passes d = double_open(&t->k, t->nx, t->ny, 0, low);
    struct parts p = {&a, NULL, &d, t->every, NULL, t->every};
    snprintf(name, sizeof name, "columns: the lowest 1/%d in double", share);
    compare(t, name, unit, (struct way) {run_parts, &p});
    float_close(&a);
    double_close(&d);
}

struct row {
    double energy;
    int y;
};

static int by_energy(const void *a, const void *b)
{
    const struct row *const p = a, *const q = b;
    return (p->energy < q->energy) - (p->energy > q->energy);
}

/* Marks 1 / share of the lit rows, those of most energy, as hot, and others as
 * rest. */
static void mark_rows(const struct test *t, int share, bool *hot, bool *rest)
{
    const struct gp_sources *const s = &t->src;
    struct row *row;
    int lit = 0;
    must(gp_alloc_zero(&split_log, "rows", (size_t) s->h, sizeof *row, &row));
    for (int y = 0; y < s->h; y++) {
        row[y].y = y;
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            for (int c = 0; c < 3; c++)
                row[y].energy += (double) s->rgb[c][i] * (double) s->rgb[c][i];
        }
        lit += s->row[y + 1] > s->row[y];
    }
    qsort(row, (size_t) s->h, sizeof *row, by_energy);
    for (int i = 0; i < s->h; i++) {
        hot[row[i].y] = i < lit / share;
        rest[row[i].y] = !hot[row[i].y];
    }
    gp_free(row);
}

static void compare_rows(struct test *t, struct way unit, int share,
                         struct float_passes *a, struct double_passes *d)
{
    char name[80];
    bool *hot, *rest;
    const size_t h = (size_t) t->src.h;
    must(gp_alloc_zero(&split_log, "hot rows", h, sizeof *hot, &hot));
    must(gp_alloc_zero(&split_log, "other rows", h, sizeof *rest, &rest));
    mark_rows(t, share, hot, rest);
    struct parts single = {a, a, NULL, rest, hot, NULL};
    struct parts both = {a, NULL, d, rest, NULL, hot};
    snprintf(name, sizeof name, "rows: the hottest 1/%d, again in float", share);
    compare(t, name, unit, (struct way) {run_parts, &single});
    snprintf(name, sizeof name, "rows: the hottest 1/%d, in double", share);
    compare(t, name, unit, (struct way) {run_parts, &both});
    gp_free(hot);
    gp_free(rest);
}

static void compare_parts(struct test *t)
{
    const int all = t->nx / 2 + 1;
    struct float_passes a = float_open(&t->k, t->nx, t->ny, 0, all);
    struct double_passes d = double_open(&t->k, t->nx, t->ny, 0, all);
    struct parts single = {.a = &a, .of_a = t->every};
    struct parts both = {.d = &d, .of_d = t->every};
    const struct way unit = {run_parts, &single};
    compare(t, "all in float", unit, unit);
    compare(t, "all in double", unit, (struct way) {run_parts, &both});
    for (int share = 8; share > 1; share /= 2)
        compare_columns(t, unit, share);
    for (int share = 16; share > 1; share /= 4)
        compare_rows(t, unit, share, &a, &d);
    float_close(&a);
    double_close(&d);
}

// -- compensated --------------------------------------------------------------

static void run_kept(struct test *t, void *ctx)
{
    kept_add(ctx, &t->src, &t->f.layer);
}

static void compare_kept(struct test *t)
{
    int nx = LANES, ny = LANES;
    while (nx < t->nx)
        nx *= 2;
    while (ny < t->ny)
        ny *= 2;
    struct kept none = kept_open(&t->k, nx, ny, false);
    struct kept keep = kept_open(&t->k, nx, ny, true);
    const struct way unit = {run_kept, &none};
    compare(t, "radix 2", unit, unit);
    compare(t, "radix 2, compensated", unit, (struct way) {run_kept, &keep});
    kept_close(&none);
    kept_close(&keep);
}

/* Returns a length on which no light of n pixels wraps around into them. */
static int period(int n, int kernel, int centre)
{
    return gp_fft_length(gp_max(n, centre) + gp_max(centre, kernel - centre));
}

int main(int argc, char **argv)
{
    const struct gp_read_params read = GP_READ_DEFAULTS;
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    const struct gp_kernel_params kernel = {0};
    struct gp_frame image = {0};
    struct test t = {.runs = argc > 3 ? atoi(argv[3]) : 5};
    if (argc < 3 || t.runs < 1) {
        fprintf(stderr, "usage: split FRAME KERNEL [RUNS]\n");
        return 2;
    }
    gp_keep_memory();
    must(gp_read_frame(&split_log, &read, argv[1], &t.f));
    must(gp_read_frame(&split_log, &read, argv[2], &image));
    must(gp_kernel_from_frame(&split_log, &kernel, &image, &t.k));
    must(gp_sense(&split_log, &sense, &t.f, &t.src));
    const size_t n = gp_frame_pixels(&t.f), h = (size_t) t.src.h;
    must(gp_planes_make(&split_log, "layer", n, &t.f.layer));
    must(gp_alloc(&split_log, "exact", 3 * n, sizeof *t.exact, &t.exact));
    must(gp_alloc(&split_log, "rows", h, sizeof *t.every, &t.every));
    memset(t.every, true, h * sizeof *t.every);
    must(gp_glare_reference(&split_log, NULL, &t.src, &t.k, t.exact));
    t.nx = period(t.src.w, t.k.w, t.k.cx);
    t.ny = period(t.src.h, t.k.h, t.k.cy);
    compare_engine(&t);
    compare_parts(&t);
    compare_kept(&t);
    gp_free(t.exact);
    gp_free(t.every);
    gp_sources_free(&t.src);
    gp_kernel_free(&t.k);
    gp_frame_free(&t.f);
    gp_frame_free(&image);
    return 0;
}
