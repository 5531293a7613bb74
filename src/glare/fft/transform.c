// SPDX-License-Identifier: Apache-2.0
#include "core/cpu.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "glare/fft/pass.h"

#include <string.h>

// -- one point of several lines -----------------------------------------------

#ifdef GP_FFT_DOUBLE
enum { LINES = GP_DOUBLE_LINES };
typedef double real;
typedef gp_double_lines lines;
#define OF(name) gp_double_##name
// the perfect shuffle of two vectors
#define LOW 0, 4, 1, 5
#define HIGH 2, 6, 3, 7
#else
enum { LINES = GP_FLOAT_LINES };
typedef float real;
typedef gp_float_lines lines;
#define OF(name) gp_float_##name
#define LOW 0, 8, 1, 9, 2, 10, 3, 11
#define HIGH 4, 12, 5, 13, 6, 14, 7, 15
#endif

#define INLINE static inline __attribute__((always_inline))

enum { PRIME = 127 }; // the largest radix

struct point {
    lines re, im;
};

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
    struct point both[PRIME / 2], apart[PRIME / 2], first = a[0];
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

/* The same of any odd radix r. */
GP_CLONES_WIDE static void pass_odd(int r, const struct point *restrict in,
                                    int m, int s, const real *restrict root,
                                    struct point *restrict out)
{
    const size_t step = (size_t) s, turn_of = step * (size_t) m;
    real c[PRIME], sine[PRIME];
    for (int k = 0; k < r; k++) {
        c[k] = root[2 * turn_of * (size_t) k];
        sine[k] = -root[2 * turn_of * (size_t) k + 1];
    }
    for (size_t i = 0; i < step * (size_t) m; i++) {
        const size_t p = i / step, q = i % step;
        struct point a[PRIME];
        for (size_t k = 0; k < (size_t) r; k++)
            a[k] = in[i + turn_of * k];
        dft_odd(r, c, sine, a);
        for (size_t j = 0; j < (size_t) r; j++) {
            const real *const w = root + 2 * j * p * step;
            out[q + step * ((size_t) r * p + j)] =
                (struct point) {a[j].re * w[0] - a[j].im * w[1],
                                a[j].re * w[1] + a[j].im * w[0]};
        }
    }
}

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
        if (r <= 8)
            pass[r](from, m, s, t->root, to);
        else
            pass_odd(r, from, m, s, t->root, to);
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
    for (int p = 11; p <= PRIME && rest > 1; p += 2) {
        for (; rest % p == 0; rest /= p)
            t.radix[t.passes++] = (unsigned char) p;
    }
    if (rest != 1)
        return gp_fail_bare(log, GP_ERR_BUG,
                            "transform: length %d has a prime over %d", n,
                            PRIME);
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

// -- tasks of the passes ------------------------------------------------------

enum { ROWS = 2 * LINES }; // of a block of lines

/* Samples from row to row of a block in scratch: a cache line over n, as rows
 * must not share the sets of a cache; they end in the gap after the points. */
static size_t pitch_of(int n)
{
    return (size_t) n + 16;
}

/* Samples of a row in float, of as many points as there are lines. */
typedef float flat
    __attribute__((vector_size(4 * LINES), aligned(4), may_alias));

/* LINES vectors to those of the same lane of each: perfect shuffles. */
INLINE void transpose(lines v[LINES])
{
    for (int round = 1; round < LINES; round *= 2) {
        lines w[LINES];
        for (int i = 0; i < LINES / 2; i++) {
            w[2 * i] = __builtin_shufflevector(v[i], v[i + LINES / 2], LOW);
            w[2 * i + 1] =
                __builtin_shufflevector(v[i], v[i + LINES / 2], HIGH);
        }
        memcpy(v, w, sizeof w);
    }
}

/* Rows of n samples, `pitch` apart, to the re of n points from the first row, to
 * their im from the second, and so on. */
GP_CLONES_WIDE static void weave(const float *rows, size_t pitch, int n,
                                 struct point *z)
{
    for (int x = 0; x < n; x += LINES) {
        lines re[LINES], im[LINES];
        for (size_t i = 0; i < LINES; i++) {
            const float *const row = rows + 2 * i * pitch + x;
            re[i] = __builtin_convertvector(*(const flat *) row, lines);
            im[i] =
                __builtin_convertvector(*(const flat *) (row + pitch), lines);
        }
        transpose(re);
        transpose(im);
        for (int i = 0; i < LINES; i++)
            z[x + i] = (struct point) {re[i], im[i]};
    }
}

/* The inverse, of points whose re and im are exchanged. */
GP_CLONES_WIDE static void unweave(const struct point *z, int n, size_t pitch,
                                   float *rows)
{
    for (int x = 0; x < n; x += LINES) {
        lines re[LINES], im[LINES];
        for (int i = 0; i < LINES; i++) {
            re[i] = z[x + i].im;
            im[i] = z[x + i].re;
        }
        transpose(re);
        transpose(im);
        for (size_t i = 0; i < LINES; i++) {
            float *const row = rows + 2 * i * pitch + x;
            *(flat *) row = __builtin_convertvector(re[i], flat);
            *(flat *) (row + pitch) = __builtin_convertvector(im[i], flat);
        }
    }
}

/* Spectra z of LINES pairs of rows to twice the spectra of the rows: of block b
 * of columns to m[b * pitch + row]. */
GP_CLONES_WIDE static void part(const struct point *z, int n, int blocks,
                                size_t pitch, struct point *m)
{
    for (int b = 0; b < blocks; b++, m += pitch) {
        struct {
            lines re[LINES], im[LINES];
        } first, second;
        for (int i = 0; i < LINES; i++) {
            const int k = b * LINES + i;
            const struct point f = z[k], r = z[k ? n - k : 0];
            first.re[i] = f.re + r.re;
            first.im[i] = f.im - r.im;
            second.re[i] = f.im + r.im; // times -i
            second.im[i] = r.re - f.re;
        }
        transpose(first.re);
        transpose(first.im);
        transpose(second.re);
        transpose(second.im);
        for (int i = 0; i < LINES; i++) {
            m[2 * i] = (struct point) {first.re[i], first.im[i]};
            m[2 * i + 1] = (struct point) {second.re[i], second.im[i]};
        }
    }
}

/* The inverse, to points whose re and im are exchanged. */
GP_CLONES_WIDE static void join(const struct point *m, size_t pitch, int blocks,
                                int n, struct point *z)
{
    for (int b = 0; b < blocks; b++, m += pitch) {
        struct {
            lines re[LINES], im[LINES];
        } first, second;
        for (int i = 0; i < LINES; i++) {
            first.re[i] = m[2 * i].re;
            first.im[i] = m[2 * i].im;
            second.re[i] = m[2 * i + 1].re;
            second.im[i] = m[2 * i + 1].im;
        }
        transpose(first.re);
        transpose(first.im);
        transpose(second.re);
        transpose(second.im);
        for (int i = 0; i < LINES; i++) {
            const int k = b * LINES + i;
            if (2 * k > n)
                break;
            if (k) // the conjugates, of column -k
                z[n - k] = (struct point) {second.re[i] - first.im[i],
                                           first.re[i] + second.im[i]};
            z[k] = (struct point) {first.im[i] + second.re[i],
                                   first.re[i] - second.im[i]};
        }
    }
}

/* z times a kernel's spectrum, re and im exchanged. */
GP_CLONES_WIDE static void times(struct point *restrict z,
                                 const struct point *restrict k, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].re * k[y].im + z[y].im * k[y].re,
                               z[y].re * k[y].re - z[y].im * k[y].im};
}

GP_CLONES_WIDE static void times_real(struct point *restrict z,
                                      const lines *restrict k, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].im * k[y], z[y].re * k[y]};
}

/* Scratch of a task, and its place. */
struct task {
    int c, block; // channel, block of lines
    struct point *z, *other;
};

static struct task open_task(const struct gp_pass *s, int i, int thread)
{
    const size_t room = gp_transform_room(s->t->n);
    char *const scratch = s->scratch + 2 * room * (size_t) thread;
    return (struct task) {
        s->req->channel + i / s->tasks,
        i % s->tasks,
        (void *) scratch,
        (void *) (scratch + room),
    };
}

/* Returns the other array. */
static struct point *transform(const struct gp_pass *s, struct task *t)
{
    struct point *const from = t->z, *const to = t->other;
    t->z = (void *) OF(transform)(s->t, (void *) from, (void *) to);
    t->other = t->z == from ? to : from;
    return t->z;
}

/* Block b of a plane of complex numbers. */
static struct point *block_of(const struct gp_fft_matrix *m, int c, int b)
{
    return (struct point *) m->z[c] + (size_t) b * m->pitch;
}

void OF(rows_in)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n, first = t.block * ROWS;
    float *const rows = (void *) t.other;
    const size_t pitch = pitch_of(n);
    memset(rows, 0, sizeof *rows * ROWS * pitch);
    for (int j = 0; j < ROWS && first + j < s->rows.n; j++)
        s->load(s->ctx, t.c, first + j, rows + (size_t) j * pitch);
    weave(rows, pitch, n, t.z);
    part(transform(s, &t), n, s->m->blocks, s->m->pitch,
         block_of(s->m, t.c, 0) + first);
}

/* Rows of a block to their places on a torus of n points, dark between them. */
static void place_rows(const struct gp_fft_rows *r, int n,
                       const struct point *from, struct point *to)
{
    int at = 0, j = 0; // places under `at` are written; the first that wraps
    while (j < r->n && r->place[j] >= r->place[0])
        j++;
    for (int i = 0; i < r->n; i++, j++) {
        const int row = j < r->n ? j : j - r->n, place = r->place[row];
        memset(to + at, 0, sizeof *to * (size_t) (place - at));
        to[place] = from[row];
        at = place + 1;
    }
    memset(to + at, 0, sizeof *to * (size_t) (n - at));
}

GP_CLONES_WIDE static void scale(struct point *z, real by, int n)
{
    for (int y = 0; y < n; y++)
        z[y] = (struct point) {z[y].re * by, z[y].im * by};
}

/* Of a real spectrum re of all points, one after the other. */
void OF(make_kernel)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n;
    const bool real_only = s->m->of.real;
    struct point *const block = block_of(s->m, t.c, t.block);
    place_rows(&s->rows, n, block, t.z);
    for (int y = 1; real_only && y < s->rows.n; y++)
        t.z[n - y] = (struct point) {t.z[y].re, -t.z[y].im};
    scale(transform(s, &t), (real) s->scale, n);
    for (int y = 0; real_only && y < n; y++)
        ((lines *) t.z)[y] = t.z[y].re;
    memcpy(block, t.z,
           (real_only ? sizeof(lines) : sizeof *block) * (size_t) n);
}

void OF(multiply)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n, upper = gp_min(s->count, n - s->first);
    const struct gp_fft_matrix *const m = s->kernel;
    struct point *const block = block_of(s->m, t.c, t.block);
    const struct point *const k = block_of(m, m->z[t.c] ? t.c : 0, t.block);
    place_rows(&s->rows, n, block, t.z);
    if (m->of.real)
        times_real(transform(s, &t), (const lines *) k, n);
    else
        times(transform(s, &t), k, n);
    const struct point *const z = transform(s, &t);
    for (int y = 0; y < s->count; y++) {
        const struct point *const from =
            z + (y < upper ? s->first + y : y - upper);
        block[y] = (struct point) {from->im, from->re};
    }
}

void OF(rows_out)(void *ctx, int i, int thread)
{
    const struct gp_pass *const s = ctx;
    struct task t = open_task(s, i, thread);
    const int n = s->t->n, first = t.block * ROWS;
    const int past = first + ROWS - s->rows.n; // rows of the last lines, dark
    for (int b = 0; past > 0 && b < s->m->blocks; b++)
        memset(block_of(s->m, t.c, b) + s->rows.n, 0,
               sizeof(struct point) * (size_t) past);
    join(block_of(s->m, t.c, 0) + first, s->m->pitch, s->m->blocks, n, t.z);
    transform(s, &t);
    float *const rows = (void *) t.other;
    const size_t pitch = pitch_of(n);
    unweave(t.z, n, pitch, rows);
    for (int j = 0; j < ROWS && first + j < s->rows.n; j++)
        s->store(s->ctx, t.c, first + j, rows + (size_t) j * pitch);
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

/* Tests whether a length has no prime factors over `most`. */
static bool has_primes(int n, int most)
{
    for (int p = 2; p <= most; p++) {
        while (n % p == 0)
            n /= p;
    }
    return n == 1;
}

bool gp_fft_takes(int n)
{
    return has_primes(n, PRIME);
}

int gp_fft_length(int n)
{
    int m = (n + 7) / 8 * 8;
    while (!has_primes(m, 7))
        m += 8;
    return m;
}
#endif
