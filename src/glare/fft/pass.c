// SPDX-License-Identifier: Apache-2.0
/* The passes over rows and columns, in float and, from the same text
 * (pass_body.inc), in double. */
#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "glare/fft/fft_priv.h"

#include <stdbool.h>
#include <string.h>

// -- numbers in float ---------------------------------------------------------

enum {
    ROWS = 8,     // rows that share a cache line of a column
    PAIRS = 4,    // complex rows that hold them
    COLUMNS = 16, // columns a task takes
    ROW_LINES = 1 + PAIRS + 1, // scratch of four pairs: one, all, and in double
                               // one row in float
    AHEAD = 12,   // columns fetched before they are needed: no CPU foresees
                  // steps as long as a column
};

/* Four complex numbers; as floats to calculate, as doubles to move. */
typedef float vf __attribute__((vector_size(32)));
typedef double vd __attribute__((vector_size(32)));
typedef vf vf_loose __attribute__((aligned(8), may_alias));
typedef float vh __attribute__((vector_size(16))); // four real numbers
typedef vh vh_loose __attribute__((aligned(4), may_alias));

#define INLINE static inline __attribute__((always_inline))
#define CONJ ((vf) {1, -1, 1, -1, 1, -1, 1, -1})

INLINE vf load4(const float *p)
{
    return *(const vf_loose *) p;
}

INLINE void store4(float *p, vf v)
{
    *(vf_loose *) p = v;
}

/* The four numbers in reverse order. */
INLINE vf reverse(vf v)
{
    return (vf) __builtin_shufflevector((vd) v, (vd) v, 3, 2, 1, 0);
}

/* re and im of each number exchanged. */
INLINE vf swap(vf v)
{
    return __builtin_shufflevector(v, v, 1, 0, 3, 2, 5, 4, 7, 6);
}

/* Rows of four to columns of four. */
INLINE void transpose(const vf in[4], vf out[4])
{
    const vd a = (vd) in[0], b = (vd) in[1], c = (vd) in[2], d = (vd) in[3];
    const vd ab0 = __builtin_shufflevector(a, b, 0, 4, 2, 6);
    const vd ab1 = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const vd cd0 = __builtin_shufflevector(c, d, 0, 4, 2, 6);
    const vd cd1 = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    out[0] = (vf) __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5);
    out[1] = (vf) __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5);
    out[2] = (vf) __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7);
    out[3] = (vf) __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7);
}

/* Spectra Z of four pairs of rows, each nx + 4 numbers with Z[nx] = Z[0], to
 * twice the spectra of the eight rows, transposed into the matrix. */
GP_CLONES static void float_unpack(const float *z, size_t z_pitch, int nx,
                                   float *out, size_t pitch)
{
    for (int k = 0; k <= nx / 2; k += 4) {
        vf row[ROWS];
        for (int p = 0; p < PAIRS; p++) {
            const float *const zp = z + (size_t) p * z_pitch;
            const vf f = load4(zp + 2 * k);
            const vf r = reverse(load4(zp + 2 * (nx - k - 3))) * CONJ;
            row[2 * p] = f + r;
            row[2 * p + 1] = swap(f - r) * CONJ; // times -i
        }
        vf lo[4], hi[4];
        transpose(row, lo);
        transpose(row + 4, hi);
        for (int i = 0; i < 4; i++) {
            float *const line = out + 2 * ((size_t) (k + i) * pitch);
            __builtin_prefetch(line + 2 * AHEAD * pitch, 1);
            store4(line, lo[i]);
            store4(line + 8, hi[i]);
        }
    }
}

/* The inverse: eight columns' rows to four complex rows of nx numbers. */
GP_CLONES static void float_pack(const float *in, size_t pitch, int nx,
                                 float *z, size_t z_pitch)
{
    for (int k = 0; k < nx / 2; k += 4) {
        vf lo[4], hi[4], row[ROWS];
        for (int i = 0; i < 4; i++) {
            const float *const line = in + 2 * ((size_t) (k + i) * pitch);
            __builtin_prefetch(line + 2 * AHEAD * pitch);
            lo[i] = load4(line);
            hi[i] = load4(line + 8);
        }
        transpose(lo, row);
        transpose(hi, row + 4);
        for (int p = 0; p < PAIRS; p++) {
            float *const zp = z + (size_t) p * z_pitch;
            const vf ib = swap(row[2 * p + 1] * CONJ); // times i
            const vf minus = (row[2 * p] - ib) * CONJ;
            // Z[nx - k] for k = 0 is Z[nx], which nothing reads
            store4(zp + 2 * (nx - k - 3), reverse(minus));
            store4(zp + 2 * k, row[2 * p] + ib);
        }
    }
    const float *const nyquist = in + 2 * ((size_t) (nx / 2) * pitch);
    for (int p = 0; p < PAIRS; p++) {
        float *const mid = z + (size_t) p * z_pitch + nx;
        mid[0] = nyquist[4 * p] - nyquist[4 * p + 3];
        mid[1] = nyquist[4 * p + 1] + nyquist[4 * p + 2];
    }
}

/* z[i] *= k[i] for n complex numbers, n a multiple of 4. */
GP_CLONES static void float_multiply(float *restrict z,
                                     const float *restrict k, int n)
{
    for (int i = 0; i < n; i += 4) {
        const vf a = load4(z + 2 * i), b = load4(k + 2 * i);
        const vf re = __builtin_shufflevector(b, b, 0, 0, 2, 2, 4, 4, 6, 6);
        const vf im = __builtin_shufflevector(b, b, 1, 1, 3, 3, 5, 5, 7, 7);
        store4(z + 2 * i, a * re - swap(a) * im * CONJ);
    }
}

/* z[i] *= k[i] for n complex numbers and as many real ones, n a multiple of
 * 4. */
GP_CLONES static void float_multiply_real(float *restrict z,
                                          const float *restrict k, int n)
{
    for (int i = 0; i < n; i += 4) {
        const vh b = *(const vh_loose *) (k + i);
        store4(z + 2 * i, load4(z + 2 * i) *
                   __builtin_shufflevector(b, b, 0, 0, 1, 1, 2, 2, 3, 3));
    }
}

// -- numbers in double --------------------------------------------------------

/* One complex number, and two. */
typedef double vz __attribute__((vector_size(16)));
typedef vz vz_loose __attribute__((aligned(8), may_alias));
typedef double vzz __attribute__((vector_size(32)));
typedef vzz vzz_loose __attribute__((aligned(8), may_alias));

#define CONJ_Z ((vz) {1, -1})

INLINE vz load_z(const double *p)
{
    return *(const vz_loose *) p;
}

INLINE void store_z(double *p, vz v)
{
    *(vz_loose *) p = v;
}

INLINE vz swap_z(vz v)
{
    return __builtin_shufflevector(v, v, 1, 0);
}

/* As those in float; numbers fill two cache lines of a column. */
GP_CLONES static void double_unpack(const double *z, size_t z_pitch, int nx,
                                    double *out, size_t pitch)
{
    for (int k = 0; k <= nx / 2; k++) {
        double *const line = out + 2 * ((size_t) k * pitch);
        __builtin_prefetch(line + 2 * AHEAD * pitch, 1);
        __builtin_prefetch(line + 2 * AHEAD * pitch + ROWS, 1);
        for (int p = 0; p < PAIRS; p++) {
            const double *const zp = z + (size_t) p * z_pitch;
            const vz f = load_z(zp + 2 * k);
            const vz r = load_z(zp + 2 * (nx - k)) * CONJ_Z;
            store_z(line + 4 * p, f + r);
            store_z(line + 4 * p + 2, swap_z(f - r) * CONJ_Z); // times -i
        }
    }
}

GP_CLONES static void double_pack(const double *in, size_t pitch, int nx,
                                  double *z, size_t z_pitch)
{
    for (int k = 0; k < nx / 2; k++) {
        const double *const line = in + 2 * ((size_t) k * pitch);
        __builtin_prefetch(line + 2 * AHEAD * pitch);
        __builtin_prefetch(line + 2 * AHEAD * pitch + ROWS);
        for (int p = 0; p < PAIRS; p++) {
            double *const zp = z + (size_t) p * z_pitch;
            const vz a = load_z(line + 4 * p);
            const vz ib = swap_z(load_z(line + 4 * p + 2) * CONJ_Z);
            // Z[nx], for k = 0, is read by nothing
            store_z(zp + 2 * (nx - k), (a - ib) * CONJ_Z);
            store_z(zp + 2 * k, a + ib);
        }
    }
    const double *const nyquist = in + 2 * ((size_t) (nx / 2) * pitch);
    for (int p = 0; p < PAIRS; p++) {
        double *const mid = z + (size_t) p * z_pitch + nx;
        mid[0] = nyquist[4 * p] - nyquist[4 * p + 3];
        mid[1] = nyquist[4 * p + 1] + nyquist[4 * p + 2];
    }
}

GP_CLONES static void double_multiply(double *restrict z,
                                      const double *restrict k, int n)
{
    for (int i = 0; i < n; i += 2) {
        const vzz a = *(const vzz_loose *) (z + 2 * i);
        const vzz b = *(const vzz_loose *) (k + 2 * i);
        const vzz re = __builtin_shufflevector(b, b, 0, 0, 2, 2);
        const vzz im = __builtin_shufflevector(b, b, 1, 1, 3, 3);
        const vzz turned = __builtin_shufflevector(a, a, 1, 0, 3, 2);
        *(vzz_loose *) (z + 2 * i) =
            a * re - turned * im * (vzz) {1, -1, 1, -1};
    }
}

GP_CLONES static void double_multiply_real(double *restrict z,
                                           const double *restrict k, int n)
{
    for (int i = 0; i < n; i++) {
        z[2 * i] *= k[i];
        z[2 * i + 1] *= k[i];
    }
}

// -- matrices -----------------------------------------------------------------

/* A matrix without planes. */
static struct gp_fft_matrix matrix_of(struct gp_fft_numbers of, int nx,
                                      int rows)
{
    struct gp_fft_matrix m = {.columns = (nx / 2 + 1 + 3) / 4 * 4, .of = of};
    m.pitch = ((size_t) rows + ROWS - 1) / ROWS * ROWS;
    if (m.pitch % 64 == 0)
        m.pitch += ROWS; // neighbouring columns must not share a cache set
    return m;
}

/* Bytes of one of these numbers. */
static size_t number_bytes(struct gp_fft_numbers of)
{
    return (of.real ? 1 : 2) * (of.in_double ? sizeof(double) : sizeof(float));
}

size_t gp_fft_matrix_bytes(struct gp_fft_numbers of, int nx, int rows)
{
    const struct gp_fft_matrix m = matrix_of(of, nx, rows);
    return number_bytes(of) * (size_t) m.columns * m.pitch;
}

struct gp_fft_matrix gp_fft_matrix_in(void *memory, struct gp_fft_numbers of,
                                      int nx, int rows)
{
    struct gp_fft_matrix m = matrix_of(of, nx, rows);
    m.z[0] = memory;
    return m;
}

gp_status gp_fft_matrix_make_of(const struct gp_log *log,
    struct gp_fft_numbers of, int channels, int nx, int rows,
    struct gp_fft_matrix *out)
{
    struct gp_fft_matrix m = matrix_of(of, nx, rows);
    // one block, as it fills huge pages
    const size_t plane = (size_t) m.columns * m.pitch;
    gp_status st = gp_alloc(log, "spectrum", (size_t) channels * plane,
                            number_bytes(of), &m.z[0]);
    if (st)
        return st;
    for (int c = 1; c < channels; c++)
        m.z[c] = (float *) (void *) ((char *) m.z[0] +
                                     number_bytes(of) * (size_t) c * plane);
    *out = m;
    return GP_OK;
}

gp_status gp_fft_matrix_make(const struct gp_log *log, int channels, int nx,
                             int rows, struct gp_fft_matrix *out)
{
    return gp_fft_matrix_make_of(log, (struct gp_fft_numbers) {false, false},
                                 channels, nx, rows, out);
}

void gp_fft_matrix_free(struct gp_fft_matrix *m)
{
    gp_free(m->z[0]);
    *m = (struct gp_fft_matrix) {0};
}

// -- passes -------------------------------------------------------------------

/* A pass under way: scratch for each thread, and what its tasks read. */
struct pass {
    const struct gp_fftwf *float_lib;
    const struct gp_fftwd *double_lib; // of a pass in double
    const struct gp_fft_request *req;
    struct gp_fft_matrix *m, *out;
    const struct gp_fft_kernel *kernel;
    int rows, tasks; // tasks of one channel
    const int *place;
    int first, count;
    double scale;
    gp_fft_load load;
    gp_fft_store store;
    const void *ctx;
    size_t scratch; // scalars of each thread
    void *buffer;
};

/* Scalars of a complex row of n numbers and a little more, cache-aligned. */
static size_t row_scalars(int n)
{
    return (2 * (size_t) n + 8 + 15) / 16 * 16;
}

/* Rows come and go in float: a pass in double converts them, behind the lines
 * of its scratch. */
GP_CLONES static void double_widen(const float *restrict from, int n,
                                   double *restrict to)
{
    for (int i = 0; i < n; i++)
        to[i] = (double) from[i];
}

GP_CLONES static void double_narrow(const double *restrict from, int n,
                                    float *restrict to)
{
    for (int i = 0; i < n; i++)
        to[i] = (float) from[i];
}

#define float_widen(from, n, to) ((void) 0)
#define float_narrow(from, n, to) ((void) 0)

/* Fetches n complex numbers of `bytes` that are written next: a transform's
 * steps are too long for the CPU to foresee. */
static void fetch_column(const void *z, int n, size_t bytes)
{
    enum { LINE = 64 };
    for (size_t i = 0; i < bytes * (size_t) n; i += LINE)
        __builtin_prefetch((const char *) z + i, 1, 2);
}

#define REAL float
#define IN_DOUBLE 0
#define OF(name) float_##name
#define PLAN(pair, way) ((pair)->way)
#include "pass_body.inc"
#undef REAL
#undef IN_DOUBLE
#undef OF
#undef PLAN
#define REAL double
#define IN_DOUBLE 1
#define OF(name) double_##name
#define PLAN(pair, way) ((pair)->way##_double)
#include "pass_body.inc"

/* Runs the tasks of a pass in its precision, with `scratch` scalars a thread. */
static gp_status run_pass(struct pass *s, size_t scratch, gp_task in_float,
                          gp_task in_double)
{
    const struct gp_fft_request *const req = s->req;
    const bool twice = req->x->in_double;
    gp_status st = twice ? gp_fftwd_open(req->log, &s->double_lib)
                         : gp_fftwf_open(req->log, &s->float_lib);
    if (st)
        return st;
    s->scratch = (scratch + 15) / 16 * 16;
    st = gp_alloc(req->log, "transform", s->scratch * (size_t) gp_threads(),
                  twice ? sizeof(double) : sizeof(float), &s->buffer);
    if (st)
        return st;
    gp_parallel_do(s->tasks * req->channels, twice ? in_double : in_float, s);
    gp_free(s->buffer);
    return GP_OK;
}

gp_status gp_fft_rows_in(const struct gp_fft_request *req, int rows,
    gp_fft_load load, const void *ctx, struct gp_fft_matrix *m)
{
    struct pass s = {
        .req = req, .m = m, .rows = rows, .load = load, .ctx = ctx,
        .tasks = (rows + ROWS - 1) / ROWS,
    };
    return run_pass(&s, ROW_LINES * row_scalars(req->x->n), float_rows_in,
                    double_rows_in);
}

gp_status gp_fft_columns(const struct gp_fft_request *req,
    const struct gp_fft_matrix *m, int rows, const int *place, double scale,
    struct gp_fft_matrix *out)
{
    struct gp_fft_matrix in = *m;
    struct pass s = {
        .req = req, .m = &in, .out = out, .rows = rows, .place = place,
        .scale = scale, .tasks = (req->x->n / 2 + COLUMNS) / COLUMNS,
    };
    return run_pass(&s, 2 * row_scalars(req->y->n), float_columns_forward,
                    double_columns_forward);
}

gp_status gp_fft_multiply(const struct gp_fft_request *req,
    struct gp_fft_matrix *m, int rows, const int *place,
    const struct gp_fft_kernel *kernel, int first, int count)
{
    struct pass s = {
        .req = req, .m = m, .kernel = kernel, .rows = rows, .place = place,
        .first = first, .count = count,
        .tasks = (req->x->n / 2 + COLUMNS) / COLUMNS,
    };
    return run_pass(&s, 3 * row_scalars(req->y->n), float_columns_multiply,
                    double_columns_multiply);
}

gp_status gp_fft_rows_out(const struct gp_fft_request *req,
                          const struct gp_fft_matrix *m, int rows,
                          gp_fft_store store, const void *ctx)
{
    struct gp_fft_matrix in = *m;
    struct pass s = {
        .req = req, .m = &in, .rows = rows, .store = store, .ctx = ctx,
        .tasks = (rows + ROWS - 1) / ROWS,
    };
    return run_pass(&s, ROW_LINES * row_scalars(req->x->n), float_rows_out,
                    double_rows_out);
}
