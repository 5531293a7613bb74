// SPDX-License-Identifier: Apache-2.0
/* The transform beside the definition that proves it, and beside FFTW with
 * measured plans.
 *
 *   transform lines            of each length: roundings against the definition
 *                              in long double, over log2 n; GFLOP/s of lines in
 *                              the cache, 5 n log2 n each, beside FFTW's
 *   transform plain W H K N    ms of a glare by plain FFTW, kernel's spectrum
 *                              made before: three channels of W x H pixels, a
 *                              kernel of K x K, the fastest of the N least sizes
 *                              that nothing wraps on
 *
 * Two threads; the least of a few times. */
#include "core/memory.h"
#include "glare/fft/transform.h"

#include <complex.h>
#include <fftw3.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double) t.tv_sec + 1e-9 * (double) t.tv_nsec;
}

static void *room(size_t bytes)
{
    void *p;
    if (gp_alloc_zero(NULL, "bench", bytes, 1, &p))
        exit(1);
    return p;
}

/* -- lines ------------------------------------------------------------------*/

enum { LINES = GP_FLOAT_LINES, ROUNDS = 12 };

/* Roundings of line 3 against the definition. */
static double error_of(const float *in, const float *out, int n)
{
    long double wrong = 0.0L, all = 0.0L;
    const long double turn = 2.0L * acosl(-1.0L) / n;
    const int step = 1 + n / 64;
    for (int k = 0; k < n; k += step) {
        long double complex sum = 0.0L;
        for (int x = 0; x < n; x++) {
            const long double a = turn * (long double) ((long long) k * x % n);
            const float *const z = in + 2 * LINES * x + 3;
            sum += (z[0] + z[LINES] * (long double complex) I) *
                   (cosl(a) - sinl(a) * I);
        }
        const float *const z = out + 2 * LINES * k + 3;
        const long double d =
            cabsl(sum - (z[0] + z[LINES] * (long double complex) I));
        wrong += d * d;
        all += cabsl(sum) * cabsl(sum);
    }
    return (double) sqrtl(wrong / all) * 0x1p24;
}

static int lines(void)
{
    static const int lengths[] = {256,  512,  1024, 1280,  1536, 1600, 2000,
                                  2048, 2400, 2700, 4000,  4050, 4096, 4374,
                                  5000, 8000, 8192, 16000, 16384};
    printf("length  roundings  / log2 n  GFLOP/s  FFTW, measured  ratio\n");
    for (size_t i = 0; i < sizeof lengths / sizeof *lengths; i++) {
        const int n = lengths[i];
        struct gp_transform t;
        if (gp_float_transform_make(NULL, n, &t))
            return 1;
        char *const both = room(2 * gp_transform_room(n));
        float *const z = (float *) (void *) both;
        float *const other = (float *) (void *) (both + gp_transform_room(n));
        float *const in = room((size_t) n * GP_POINT_BYTES);
        srand(1);
        for (int j = 0; j < 2 * LINES * n; j++)
            in[j] = z[j] = (float) rand() / (float) RAND_MAX - 0.5f;
        const double error = error_of(in, gp_float_transform(&t, z, other), n);
        fftwf_complex *const a = fftwf_malloc(sizeof *a * (size_t) (n * LINES));
        fftwf_complex *const b = fftwf_malloc(sizeof *b * (size_t) (n * LINES));
        const fftwf_plan plan =
            fftwf_plan_dft_1d(n, a, b, FFTW_FORWARD, FFTW_MEASURE);
        for (int j = 0; j < n * LINES; j++)
            a[j] = 1.0f;
        const double flops = LINES * 5.0 * n * log2(n);
        const int times = (int) (1e8 / flops) + 1;
        double own = INFINITY, peer = INFINITY;
        for (int round = 0; round < ROUNDS; round++) {
            double start = now();
            for (int j = 0; j < times; j++) {
                memcpy(z, in, GP_POINT_BYTES); // values stay in range
                gp_float_transform(&t, z, other);
                memset(z, 0, (size_t) n * GP_POINT_BYTES);
            }
            own = fmin(own, now() - start);
            start = now();
            for (int j = 0; j < times; j++) {
                for (int l = 0; l < LINES; l++)
                    fftwf_execute_dft(plan, a + l * n, b + l * n);
                memset(z, 0, (size_t) n * GP_POINT_BYTES);
            }
            peer = fmin(peer, now() - start);
        }
        printf("%6d  %9.2f  %8.3f  %7.1f  %14.1f  %5.2f\n", n, error,
               error / log2(n), flops * times / own * 1e-9,
               flops * times / peer * 1e-9, own / peer);
        fflush(stdout);
        fftwf_destroy_plan(plan);
        fftwf_free(a);
        fftwf_free(b);
        gp_free(both);
        gp_free(in);
        gp_transform_free(&t);
    }
    return 0;
}

/* -- a glare by plain FFTW --------------------------------------------------*/

/* Milliseconds with transforms of w x h. */
static double plain_ms(int w, int h)
{
    const size_t pitch = 2 * (size_t) (w / 2 + 1), n = pitch * (size_t) h;
    float *const z = fftwf_alloc_real(n), *const k = fftwf_alloc_real(n);
    const fftwf_plan there =
        fftwf_plan_dft_r2c_2d(h, w, z, (fftwf_complex *) z, FFTW_MEASURE);
    const fftwf_plan back =
        fftwf_plan_dft_c2r_2d(h, w, (fftwf_complex *) z, z, FFTW_MEASURE);
    double least = INFINITY;
    for (size_t i = 0; i < n; i++)
        k[i] = 1e-6f;
    for (int round = 0; round < 5; round++) {
        const double start = now();
        for (int c = 0; c < 3; c++) {
#pragma omp parallel for
            for (int y = 0; y < h; y++)
                memset(z + (size_t) y * pitch, 0, pitch * sizeof *z);
            fftwf_execute(there);
#pragma omp parallel for
            for (size_t i = 0; i < n / 2; i++) {
                const float u = z[2 * i], v = z[2 * i + 1];
                z[2 * i] = u * k[2 * i] - v * k[2 * i + 1];
                z[2 * i + 1] = u * k[2 * i + 1] + v * k[2 * i];
            }
            fftwf_execute(back);
        }
        least = fmin(least, now() - start);
    }
    fftwf_destroy_plan(there);
    fftwf_destroy_plan(back);
    fftwf_free(z);
    fftwf_free(k);
    return 1e3 * least;
}

/* The i-th even length from n on that has no factor over 7. */
static int length_from(int n, int i)
{
    for (n += n % 2;; n += 2) {
        int rest = n;
        for (int p = 2; p <= 7; p++) {
            while (rest % p == 0)
                rest /= p;
        }
        if (rest == 1 && i-- == 0)
            return n;
    }
}

static int plain(int w, int h, int kernel, int sizes)
{
    double least = INFINITY;
    int best[2] = {0};
    fftwf_init_threads();
    fftwf_plan_with_nthreads(2);
    for (int i = 0; i < sizes * sizes; i++) {
        const int nx = length_from(w + kernel / 2, i % sizes);
        const int ny = length_from(h + kernel / 2, i / sizes);
        const double ms = plain_ms(nx, ny);
        if (ms < least) {
            least = ms;
            best[0] = nx;
            best[1] = ny;
        }
    }
    printf("%.1f %dx%d\n", least, best[0], best[1]);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 2 && strcmp(argv[1], "lines") == 0)
        return lines();
    if (argc == 6 && strcmp(argv[1], "plain") == 0)
        return plain(atoi(argv[2]), atoi(argv[3]), atoi(argv[4]),
                     atoi(argv[5]));
    fprintf(stderr, "usage: transform lines | transform plain W H K SIZES\n");
    return 2;
}
