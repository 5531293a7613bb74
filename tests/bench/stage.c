/* The glare stage against plain 2-D FFTW, frame by frame in one run.
 *
 *   stage FRAME.exr KERNEL.exr WIDTH HEIGHT [RUNS [estimate|measure]]
 *
 * WIDTH and HEIGHT are the plain form's padded transform (its best sizes are
 * 1280x1024, 2304x1344 and 4096x2560 for the usual frames). The plain form
 * is what a good programmer writes first: one real 2-D plan with FFTW's own
 * threads, a cached kernel spectrum, channel after channel. Both sides take
 * the frame's planes to the layer (plain: to frame + layer), bright pass
 * included; pairs alternate, so a machine whose speed drifts drifts for both.
 * The CPU times are the least of all runs. FFTW's threads spin in them: on a
 * machine that other work shares, compare them on one processor (taskset -c 0).
 */
#include "median.h"

#include "core/clock.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/engine.h"
#include "glare/sensors.h"
#include "io/read.h"

#include <fftw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const struct gp_log stage_log = BENCH_LOG("stage");

struct plain {
    int w, h;
    size_t pitch; // floats of a row
    float *buffer, *kernel[3];
    fftwf_plan forward, backward;
};

static void plain_open(struct plain *p, const struct gp_kernel *k,
                       unsigned flags)
{
    if (gp_threads() > 1) {
        fftwf_init_threads();
        fftwf_plan_with_nthreads(gp_threads());
    }
    p->pitch = 2 * ((size_t) p->w / 2 + 1);
    const size_t n = p->pitch * (size_t) p->h;
    p->buffer = fftwf_alloc_real(n);
    p->forward = fftwf_plan_dft_r2c_2d(p->h, p->w, p->buffer,
                                       (fftwf_complex *) p->buffer, flags);
    p->backward = fftwf_plan_dft_c2r_2d(
        p->h, p->w, (fftwf_complex *) p->buffer, p->buffer, flags);
    const float scale = 1.0f / ((float) p->w * (float) p->h);
    for (int c = 0; c < 3; c++) {
        p->kernel[c] = fftwf_alloc_real(n);
        memset(p->kernel[c], 0, n * sizeof(float));
        for (int y = 0; y < k->h; y++) {
            for (int x = 0; x < k->w; x++) {
                const int ty = (y - k->cy + p->h) % p->h;
                const int tx = (x - k->cx + p->w) % p->w;
                p->kernel[c][(size_t) ty * p->pitch + (size_t) tx] =
                    scale * k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x];
            }
        }
        fftwf_execute_dft_r2c(p->forward, p->kernel[c],
                              (fftwf_complex *) p->kernel[c]);
    }
}

static void plain_run(const struct plain *p, const struct gp_frame *f,
                      struct gp_planes *out)
{
    const int w = gp_frame_w(f), h = gp_frame_h(f);
    const float *const weight = f->luminance;
    const float *const r = f->rgb.c[0], *const g = f->rgb.c[1];
    const float *const b = f->rgb.c[2];
    for (int c = 0; c < 3; c++) {
        const float *const in = f->rgb.c[c], *const k = p->kernel[c];
        float *const z = p->buffer;
#pragma omp parallel for num_threads(gp_threads())
        for (int y = 0; y < p->h; y++) {
            float *const row = z + (size_t) y * p->pitch;
            memset(row, 0, p->pitch * sizeof(float));
            for (int x = 0; y < h && x < w; x++) {
                const size_t i = (size_t) y * (size_t) w + (size_t) x;
                const float lum =
                    weight[0] * r[i] + weight[1] * g[i] + weight[2] * b[i];
                row[x] = lum > 1.0f ? in[i] : 0.0f;
            }
        }
        fftwf_execute(p->forward);
#pragma omp parallel for num_threads(gp_threads())
        for (int y = 0; y < p->h; y++) {
            for (size_t i = (size_t) y * p->pitch;
                 i < ((size_t) y + 1) * p->pitch; i += 2) {
                const float u = z[i], v = z[i + 1];
                z[i] = u * k[i] - v * k[i + 1];
                z[i + 1] = u * k[i + 1] + v * k[i];
            }
        }
        fftwf_execute(p->backward);
        float *const o = out->c[c];
#pragma omp parallel for num_threads(gp_threads())
        for (int y = 0; y < h; y++) {
            for (int x = 0; x < w; x++)
                o[(size_t) y * (size_t) w + (size_t) x] =
                    in[(size_t) y * (size_t) w + (size_t) x] +
                    z[(size_t) y * p->pitch + (size_t) x];
        }
    }
}

/* OpenMP's threads spin for a while after a loop and would slow the other
 * side down. */
static void settle(void)
{
    const struct timespec nap = {0, 20 * 1000 * 1000};
    nanosleep(&nap, NULL);
}

enum { MOST_RUNS = 200 };

static int compare(struct gp_frame *f, const struct gp_kernel *k,
                   struct plain *p, int runs, enum gp_fft_plan how)
{
    static double ours[MOST_RUNS], plain[MOST_RUNS], ratio[MOST_RUNS];
    const struct gp_sensor_params sense = GP_SENSOR_DEFAULTS;
    struct gp_glare_params params = GP_GLARE_DEFAULTS;
    struct gp_glare g = {0};
    struct gp_glare_stats stats = {0};
    struct gp_planes out;
    double cpu[2] = {INFINITY, INFINITY}; // ours, plain
    params.engine = "fft";
    params.fft_plan = how;
    if (gp_planes_make(&stage_log, "plain", gp_frame_pixels(f), &out))
        return 70;
    for (int i = -2; i < runs; i++) { // two warm-ups
        struct gp_sources src;
        double t = gp_now_ms(), from = gp_cpu_ms();
        gp_status st = gp_sense(&stage_log, &sense, f, &src);
        if (!st)
            st = gp_glare_run(&stage_log, &params, &g, &src, k, f, &stats);
        if (st)
            return (int) st;
        const double a = gp_now_ms() - t, a_cpu = gp_cpu_ms() - from;
        gp_sources_free(&src);
        settle();
        t = gp_now_ms();
        from = gp_cpu_ms();
        plain_run(p, f, &out);
        const double b = gp_now_ms() - t, b_cpu = gp_cpu_ms() - from;
        settle();
        if (i >= 0) {
            ours[i] = a;
            plain[i] = b;
            ratio[i] = b / a;
            cpu[0] = fmin(cpu[0], a_cpu);
            cpu[1] = fmin(cpu[1], b_cpu);
        }
    }
    printf("%dx%d fft %dx%d core %d %d hot %zu: ours %.2f ms, plain %dx%d "
           "%.2f ms, plain/ours %.3f (medians of %d); CPU %.2f and %.2f ms, "
           "ours/plain %.2f\n",
           gp_frame_w(f), gp_frame_h(f), stats.fft_w, stats.fft_h,
           stats.fft_core[0], stats.fft_core[1], stats.hot, median(ours, runs), p->w, p->h,
           median(plain, runs), median(ratio, runs), runs, cpu[0], cpu[1],
           cpu[0] / cpu[1]);
    gp_planes_free(&out);
    gp_glare_close(&g);
    return 0;
}

int main(int argc, char **argv)
{
    gp_keep_memory();
    if (argc < 5) {
        fprintf(stderr, "usage: stage FRAME KERNEL WIDTH HEIGHT [RUNS "
                        "[estimate|measure]]\n");
        return 2;
    }
    const struct gp_read_params read = GP_READ_DEFAULTS;
    struct gp_kernel_params kernel = {0};
    struct gp_frame f = {0}, image = {0};
    struct gp_kernel k = {0};
    int runs = argc > 5 ? atoi(argv[5]) : 15;
    runs = runs < 1 ? 1 : runs > MOST_RUNS ? MOST_RUNS : runs;
    const int measure = argc > 6 && strcmp(argv[6], "measure") == 0;
    gp_status st = gp_read_frame(&stage_log, &read, argv[1], &f);
    if (!st)
        st = gp_read_frame(&stage_log, &read, argv[2], &image);
    if (!st)
        st = gp_kernel_from_frame(&stage_log, &kernel, &image, &k);
    if (st)
        return (int) st;
    struct plain p = {.w = atoi(argv[3]), .h = atoi(argv[4])};
    // the plain form is always at its best: measured plans
    plain_open(&p, &k, FFTW_MEASURE);
    if (gp_threads() > 1)
        fftwf_plan_with_nthreads(1); // the planner is shared with our side
    return compare(&f, &k, &p, runs,
                   measure ? GP_FFT_PLAN_MEASURE : GP_FFT_PLAN_ESTIMATE);
}
