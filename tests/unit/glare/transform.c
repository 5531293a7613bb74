// SPDX-License-Identifier: Apache-2.0
/* glare/fft/transform.c, in float and in double, against the transform by its
 * definition in long double, and the laws of it. */
#include "unit.h"
#include "core/memory.h"
#include "glare/fft/transform.h"
#include "glare_scene.h"

#include <complex.h>

#ifndef CMPLX // glibc defines it only for gcc; clang has the built-in
#define CMPLX(re, im) __builtin_complex((double) (re), (double) (im))
#endif

/* A precision: how many lines there are, and how to make, fill, run and read. */
struct form {
    const char *name;
    int lines;
    double eps;
    bool in_double;
};
static const struct form forms[] = {
    {"float", GP_FLOAT_LINES, 0x1p-24, false},
    {"double", GP_DOUBLE_LINES, 0x1p-53, true},
};

/* Lines of numbers, and a transform of them. */
struct bank {
    const struct form *form;
    struct gp_transform t;
    char *room;
    double complex *in, *out; // [line][point]
};

static struct bank bank_open(const struct form *form, int n)
{
    struct bank b = {.form = form};
    const size_t numbers = (size_t) n * (size_t) form->lines;
    assert_ok(form->in_double ? gp_double_transform_make(NULL, n, &b.t)
                              : gp_float_transform_make(NULL, n, &b.t));
    assert_ok(gp_alloc(NULL, "test", 2, gp_transform_room(n), &b.room));
    b.in = calloc(numbers, sizeof *b.in);
    b.out = calloc(numbers, sizeof *b.out);
    assert_non_null(b.in);
    assert_non_null(b.out);
    return b;
}

static void bank_close(struct bank *b)
{
    gp_transform_free(&b->t);
    gp_free(b->room);
    free(b->in);
    free(b->out);
}

/* Transforms `in`, which is rounded to the form, to `out`; `back` by re and im
 * exchanged. */
static void bank_run(struct bank *b, bool back)
{
    const size_t n = (size_t) b->t.n, lines = (size_t) b->form->lines;
    const size_t room = gp_transform_room(b->t.n);
    void *z = b->room;
    for (size_t i = 0; i < n * lines; i++) {
        const size_t at = i % n * 2 * lines + i / n;
        const size_t re = at + (back ? lines : 0), im = at + (back ? 0 : lines);
        if (b->form->in_double) {
            ((double *) z)[re] = creal(b->in[i]);
            ((double *) z)[im] = cimag(b->in[i]);
        } else {
            ((float *) z)[re] = (float) creal(b->in[i]);
            ((float *) z)[im] = (float) cimag(b->in[i]);
            b->in[i] = CMPLX(((float *) z)[re], ((float *) z)[im]);
        }
    }
    if (b->form->in_double)
        z = gp_double_transform(&b->t, z, (double *) (void *) (b->room + room));
    else
        z = gp_float_transform(&b->t, z, (float *) (void *) (b->room + room));
    for (size_t i = 0; i < n * lines; i++) {
        const size_t at = i % n * 2 * lines + i / n;
        const size_t re = at + (back ? lines : 0), im = at + (back ? 0 : lines);
        b->out[i] = b->form->in_double
                        ? CMPLX(((double *) z)[re], ((double *) z)[im])
                        : CMPLX(((float *) z)[re], ((float *) z)[im]);
    }
}

static void fill(struct bank *b, uint32_t seed)
{
    for (int i = 0; i < b->t.n * b->form->lines; i++)
        b->in[i] = CMPLX((double) scene_random(&seed) - 0.5,
                         (double) scene_random(&seed) - 0.5);
}

/* exp(-2 pi i k / n) of k in [0, n). Free it. */
static long double complex *roots_of(int n)
{
    long double complex *const w = malloc((size_t) n * sizeof *w);
    assert_non_null(w);
    for (int k = 0; k < n; k++) {
        const long double a = 2.0L * acosl(-1.0L) * k / n;
        w[k] = cosl(a) - sinl(a) * I;
    }
    return w;
}

/* The transform by its definition, at frequency k. */
static long double complex plain(const double complex *z, int n, int k,
                                 const long double complex *root)
{
    long double complex sum = 0.0L;
    for (int x = 0; x < n; x++)
        sum += (long double complex) z[x] * root[(long long) k * x % n];
    return sum;
}

/* Each line is the transform by its definition, within 0.6 log2 n roundings in
 * the mean, for every length that is taken up to 512, and longer ones; of
 * these by some frequencies. */
static void lines_are_transforms(void **state)
{
    static const int longer[] = {640,  1024, 1400, 1536, 2048, 2401,
                                 2560, 2700, 3125, 4050, 4096, 4374,
                                 6080, 6561, 8192, 9898, 16384};
    for (size_t f = 0; f < COUNT(forms); f++) {
        double worst = 0.0;
        for (int i = 1; i <= 512 + (int) COUNT(longer); i++) {
            const int n = i <= 512 ? i : longer[i - 513];
            int rest = n;
            for (int p = 2; p <= 127; p++) {
                while (rest % p == 0)
                    rest /= p;
            }
            if (rest != 1)
                continue;
            struct bank b = bank_open(&forms[f], n);
            long double complex *const root = roots_of(n);
            long double wrong = 0.0L, all = 0.0L;
            fill(&b, (uint32_t) n);
            bank_run(&b, false);
            for (int line = 0; line < forms[f].lines; line++) {
                const double complex *const in = b.in + line * n;
                const double complex *const out = b.out + line * n;
                for (int k = 0; k < n; k += 1 + n / (n > 512 ? 16 : 64)) {
                    const long double complex want = plain(in, n, k, root);
                    const long double d = cabsl(want - out[k]);
                    wrong += d * d;
                    all += cabsl(want) * cabsl(want);
                }
            }
            const double rms = (double) sqrtl(wrong / all) / forms[f].eps;
            worst = fmax(worst, n > 1 ? rms / log2(n) : 0.0);
            if (!(rms <= 0.6 * log2(n)))
                fail_msg("%s, length %d: %g roundings", forms[f].name, n, rms);
            free(root);
            bank_close(&b);
        }
        print_message("%s: at most %.3f log2(n) roundings\n", forms[f].name,
                      worst);
    }
}

static long double square_of(long double complex z)
{
    return creall(z) * creall(z) + cimagl(z) * cimagl(z);
}

/* There and back is n times the line; energy is n times the line's; a sum goes to
 * the sum; a shift only turns. */
static void laws_hold(void **state)
{
    static const int lengths[] = {8, 105, 168, 1280, 1333, 2048};
    for (size_t f = 0; f < COUNT(forms); f++) {
        const double most = 16.0 * forms[f].eps;
        for (size_t i = 0; i < COUNT(lengths); i++) {
            const int n = lengths[i], lines = forms[f].lines;
            struct bank a = bank_open(&forms[f], n),
                        b = bank_open(&forms[f], n);
            long double complex *const root = roots_of(n);
            long double there = 0.0L, energy = 0.0L, again = 0.0L,
                        turned = 0.0L;
            fill(&a, 7u);
            bank_run(&a, false);
            memcpy(b.in, a.out, sizeof *b.in * (size_t) (n * lines));
            bank_run(&b, true);
            for (int k = 0; k < n * lines; k++) {
                there += square_of(a.in[k]);
                energy += square_of(a.out[k]) / n;
                again +=
                    square_of((long double complex) b.out[k] / n - a.in[k]);
            }
            assert_true(fabsl(energy / there - 1.0L) < most);
            assert_true(sqrtl(again / there) < most);
            for (int k = 0; k < n * lines; k++)
                b.in[k] = a.in[k / n * n + (k + 3) % n];
            bank_run(&b, false);
            for (int k = 0; k < n * lines; k++)
                turned +=
                    square_of(b.out[k] * root[3LL * (k % n) % n] - a.out[k]);
            assert_true(sqrtl(turned / (energy * n)) < most);
            free(root);
            bank_close(&a);
            bank_close(&b);
        }
    }
}

/* A line's bits depend on no other line, and not on which one it is. */
static void lines_do_not_meet(void **state)
{
    enum { N = 840 };
    for (size_t f = 0; f < COUNT(forms); f++) {
        struct bank a = bank_open(&forms[f], N), b = bank_open(&forms[f], N);
        const int lines = forms[f].lines;
        fill(&a, 3u);
        for (int i = 0; i < N * lines; i++)
            b.in[i] = i / N == 2 ? a.in[i % N] : INFINITY;
        bank_run(&a, false);
        bank_run(&b, false);
        assert_memory_equal(a.out, b.out + 2 * N, N * sizeof *a.out);
        bank_close(&a);
        bank_close(&b);
    }
}

/* The lengths that are asked for are the least there are. */
static void lengths_are_the_least(void **state)
{
    static const int row[][2] = {{1, 8},       {8, 8},      {9, 16},
                                 {41, 48},     {145, 160},  {1081, 1120},
                                 {2049, 2160}, {4097, 4200}};
    struct gp_transform t;
    for (size_t i = 0; i < COUNT(row); i++)
        assert_int_equal(gp_fft_length(row[i][0]), row[i][1]);
    assert_int_equal(gp_float_transform_make(NULL, 262, &t), GP_ERR_BUG);
    assert_true(!gp_fft_takes(262) && gp_fft_takes(254));
}

SUITE_OF(transform, NULL, NULL, lines_are_transforms, laws_hold,
         lines_do_not_meet, lengths_are_the_least)
