// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"
#include "glare/fft/lines.h"

// -- transforms of a few points -----------------------------------------------

INLINE struct point add(struct point a, struct point b)
{
    return (struct point) {a.re + b.re, a.im + b.im};
}

INLINE struct point sub(struct point a, struct point b)
{
    return (struct point) {a.re - b.re, a.im - b.im};
}

/* a times -i. */
INLINE struct point turn(struct point a)
{
    return (struct point) {a.im, -a.re};
}

INLINE void dft2(struct point a[2])
{
    const struct point b = a[1];
    a[1] = sub(a[0], b);
    a[0] = add(a[0], b);
}

INLINE void dft4(struct point a[4])
{
    struct point even[2] = {a[0], a[2]}, odd[2] = {a[1], a[3]};
    dft2(even);
    dft2(odd);
    odd[1] = turn(odd[1]);
    for (int j = 0; j < 2; j++) {
        a[j] = add(even[j], odd[j]);
        a[j + 2] = sub(even[j], odd[j]);
    }
}

INLINE void dft8(struct point a[8])
{
    static const real HALF = (real) 0.70710678118654752440; // sqrt(1 / 2)
    struct point even[4] = {a[0], a[2], a[4], a[6]};
    struct point odd[4] = {a[1], a[3], a[5], a[7]};
    dft4(even);
    dft4(odd);
    // times exp(-2 pi i j / 8)
    odd[1] = (struct point) {(odd[1].re + odd[1].im) * HALF,
                             (odd[1].im - odd[1].re) * HALF};
    odd[2] = turn(odd[2]);
    odd[3] = (struct point) {(odd[3].im - odd[3].re) * HALF,
                             -(odd[3].re + odd[3].im) * HALF};
    for (int j = 0; j < 4; j++) {
        a[j] = add(even[j], odd[j]);
        a[j + 4] = sub(even[j], odd[j]);
    }
}

/* An odd number r of points: those of k and r - k share their products. c and s
 * are cos and sin of 2 pi k / r, k in [0, r). */
INLINE void dft_odd(int r, const real *c, const real *s, struct point *a)
{
    struct point both[3], apart[3], first = a[0];
    for (int k = 1; k <= r / 2; k++) {
        both[k - 1] = add(a[k], a[r - k]);
        apart[k - 1] = sub(a[k], a[r - k]);
        a[0] = add(a[0], both[k - 1]);
    }
    for (int j = 1; j <= r / 2; j++) {
        struct point cosines = first, sines = {{0}, {0}};
        for (int k = 1; k <= r / 2; k++) {
            const int turn_of = j * k % r;
            cosines.re += both[k - 1].re * c[turn_of];
            cosines.im += both[k - 1].im * c[turn_of];
            sines.re += apart[k - 1].re * s[turn_of];
            sines.im += apart[k - 1].im * s[turn_of];
        }
        a[j] = add(cosines, turn(sines));
        a[r - j] = sub(cosines, turn(sines));
    }
}

INLINE void dft3(struct point a[3])
{
    static const real c[] = {1, (real) -0.5, (real) -0.5};
    static const real s[] = {0, (real) 0.86602540378443864676,
                             (real) -0.86602540378443864676};
    dft_odd(3, c, s, a);
}

INLINE void dft5(struct point a[5])
{
    static const real C1 = (real) 0.30901699437494742410;
    static const real C2 = (real) -0.80901699437494742410;
    static const real S1 = (real) 0.95105651629515357212;
    static const real S2 = (real) 0.58778525229247312917;
    const real c[] = {1, C1, C2, C2, C1}, s[] = {0, S1, S2, -S2, -S1};
    dft_odd(5, c, s, a);
}

INLINE void dft7(struct point a[7])
{
    static const real C1 = (real) 0.62348980185873353053;
    static const real C2 = (real) -0.22252093395631440429;
    static const real C3 = (real) -0.90096886790241912624;
    static const real S1 = (real) 0.78183148246802980871;
    static const real S2 = (real) 0.97492791218182360702;
    static const real S3 = (real) 0.43388373911755812048;
    const real c[] = {1, C1, C2, C3, C3, C2, C1};
    const real s[] = {0, S1, S2, S3, -S3, -S2, -S1};
    dft_odd(7, c, s, a);
}

// -- passes -------------------------------------------------------------------

/* A pass of radix R over n = R * m * s points, of which s in turn have the same
 * factors: point q + s (p + m k), k in [0, R), of one small transform goes to
 * q + s (R p + j), times exp(-2 pi i j p / (R m)). */
#define PASS(R)                                                                \
    GP_CLONES_WIDE static void pass##R(const struct point *restrict in, int m, \
                                       int s, const real *restrict root,       \
                                       struct point *restrict out)             \
    {                                                                          \
        enum { N = (R) };                                                      \
        const size_t step = (size_t) s;                                        \
        for (int p = 0; p < m; p++) {                                          \
            const struct point *const from = in + step * (size_t) p;           \
            struct point *const to = out + step * (size_t) (N * p);            \
            for (size_t q = 0; q < step; q++) {                                \
                struct point a[N];                                             \
                for (size_t k = 0; k < N; k++)                                 \
                    a[k] = from[q + step * (size_t) m * k];                    \
                dft##R(a);                                                     \
                to[q] = a[0];                                                  \
                for (int j = 1; j < N; j++) {                                  \
                    const real *const w = root + 2 * (size_t) (j * p * s);     \
                    to[q + step * (size_t) j] =                                \
                        (struct point) {a[j].re * w[0] - a[j].im * w[1],       \
                                        a[j].re * w[1] + a[j].im * w[0]};      \
                }                                                              \
            }                                                                  \
        }                                                                      \
    }
PASS(2)
PASS(3)
PASS(4)
PASS(5)
PASS(7)
PASS(8)

static void (*const pass[])(const struct point *, int, int, const real *,
                            struct point *) = {
    [2] = pass2, [3] = pass3, [4] = pass4,
    [5] = pass5, [7] = pass7, [8] = pass8,
};

real *OF(transform)(const struct gp_transform *t, real *z, real *other)
{
    struct point *from = (void *) z, *to = (void *) other;
    int m = t->n, s = 1;
    for (int i = 0; i < t->passes; i++) {
        const int r = t->radix[i];
        m /= r;
        pass[r](from, m, s, t->root, to);
        s *= r;
        struct point *const next = from;
        from = to;
        to = next;
    }
    return (void *) from;
}

/* cos and sin of 2 pi k / n, from an angle within pi / 4: exact to a rounding. */
static void find_root(int k, int n, double out[2])
{
    static const double TURN = 6.28318530717958647693;
    const long long eighth = (8LL * k + n) / (2LL * n); // quarters, rounded
    const double a = TURN * (double) (4LL * k - eighth * n) / (4.0 * n);
    const double c = gp_cos(a), s = gp_sin(a);
    const double quarter[4][2] = {{c, s}, {-s, c}, {-c, -s}, {s, -c}};
    out[0] = quarter[eighth % 4][0];
    out[1] = quarter[eighth % 4][1];
}

gp_status OF(transform_make)(const struct gp_log *log, int n,
                             struct gp_transform *out)
{
    static const int radices[] = {8, 3, 5, 7, 4, 2};
    struct gp_transform t = {.n = n};
    int rest = n;
    for (size_t i = 0; i < sizeof radices / sizeof *radices; i++) {
        // 16 as 4 and 4, not as 8 and 2
        while (rest % radices[i] == 0 &&
               !(radices[i] == 8 && rest % 16 == 0 && rest % 32 != 0)) {
            t.radix[t.passes++] = (unsigned char) radices[i];
            rest /= radices[i];
        }
    }
    if (rest != 1)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "transform: length %d has a factor over 7", n);
    real *root;
    gp_status st =
        gp_alloc(log, "transform", (size_t) n, 2 * sizeof *root, &root);
    if (st)
        return st;
    for (int k = 0; k < n; k++) {
        double w[2];
        find_root(k, n, w);
        root[2 * k] = (real) w[0];
        root[2 * k + 1] = (real) -w[1];
    }
    t.root = root;
    *out = t;
    return GP_OK;
}

// -- of either precision ------------------------------------------------------

#ifndef GP_FFT_DOUBLE
void gp_transform_free(struct gp_transform *t)
{
    gp_free(t->root);
    *t = (struct gp_transform) {0};
}

size_t gp_transform_room(int n)
{
    enum { PAGE = 4096 };
    const size_t bytes = (size_t) n * GP_POINT_BYTES;
    return (bytes + PAGE - 1) / PAGE * PAGE + PAGE / 2;
}

int gp_fft_length(int n)
{
    for (int m = (n + 7) / 8 * 8;; m += 8) {
        int rest = m;
        for (int p = 2; p <= 7; p += p == 2 ? 1 : 2) {
            while (rest % p == 0)
                rest /= p;
        }
        if (rest == 1)
            return m;
    }
}
#endif
