// SPDX-License-Identifier: Apache-2.0
/* The passes of the two-dimensional convolution by Fourier transforms.
 *
 *   rows     Two real rows are one complex line z = a + ib, so that
 *            A(k) = (Z(k) + conj Z(-k)) / 2, B(k) = (Z(k) - conj Z(-k)) / 2i.
 *            The rows of a block of lines go into the matrix together.
 *   columns  The matrix has its columns in blocks of lines, as the transform
 *            takes them. A block stays in the cache: forward, times the kernel's
 *            block, back. Rows without light are not stored, rows that are no
 *            output are not kept.
 *   rows     back, a block at a time, into the layer. */
#ifndef GP_GLARE_FFT_PASS_H
#define GP_GLARE_FFT_PASS_H

#include "core/status.h"
#include "glare/fft/transform.h"

#include <stdbool.h>
#include <stddef.h>

/* Kind and precision of a matrix's numbers. */
struct gp_fft_numbers {
    bool real; // re only: the spectrum of what is even about its centre
    bool in_double;
};

/* Columns k = 0 .. nx / 2 of a half spectrum, and a few more that fill blocks of
 * GP_FLOAT_LINES or GP_DOUBLE_LINES. */
struct gp_fft_matrix {
    struct gp_fft_numbers of;
    int blocks;
    size_t pitch; // points from block to block; real: of half a point
    void *z[3];   // planes; one allocation
};

/* Makes `channels` planes of `rows` points a block; not cleared. Free with
 * gp_fft_matrix_free(). */
GP_MUST_CHECK gp_status gp_fft_matrix_make(const struct gp_log *log,
                                           struct gp_fft_numbers of,
                                           int channels, int nx, int rows,
                                           struct gp_fft_matrix *out);
void gp_fft_matrix_free(struct gp_fft_matrix *m);

/* The one plane of a matrix, as the plane of channel c; borrowed. */
struct gp_fft_matrix gp_fft_one_channel(const struct gp_fft_matrix *m, int c);

/* State that the passes share. */
struct gp_fft_request {
    const struct gp_log *log;
    const struct gp_transform *t; // of rows; then of columns, where these go
    bool in_double;               // their precision, and all matrices'
    int channel, channels;        // the first, and how many
};

/* Makes the transforms of a request: of lengths that gp_fft_length() gives.
 * Free both. */
GP_MUST_CHECK gp_status gp_fft_pair_make(const struct gp_log *log, int nx,
                                         int ny, bool in_double,
                                         struct gp_transform out[2]);
void gp_fft_pair_free(struct gp_transform pair[2]);

/* Row `j` of channel `c` to z[x], x in [0, nx), which is cleared. */
typedef void (*gp_fft_load)(const void *ctx, int c, int j, float *z);

/* Transforms `rows` rows into row j of m's blocks; factors of 1/2 are left out:
 * the matrix holds twice the spectrum. */
GP_MUST_CHECK gp_status gp_fft_rows_in(const struct gp_fft_request *req,
                                       int rows, gp_fft_load load,
                                       const void *ctx,
                                       struct gp_fft_matrix *m);

/* Rows of a matrix and where they are on the torus. */
struct gp_fft_rows {
    int n;
    const int *place; // row j at place[j] of ny; distinct, and ascending from
                      // place[0] on, modulo ny
};

/* Makes a kernel's spectrum in place of its rows, of gp_fft_rows_in() in a matrix
 * with room for ny points, times `scale`. Where m is real, row j >= 0 is at j,
 * n <= ny / 2, and row -j is row j from right to left: the rows of a real matrix are
 * written as those of a complex one with half as many points a block. */
GP_MUST_CHECK gp_status gp_fft_make_kernel(const struct gp_fft_request *req,
                                           struct gp_fft_rows rows,
                                           double scale,
                                           struct gp_fft_matrix *m);

/* Forward, times the kernel's spectrum (one plane for all, or the channels' own),
 * back, each block in place: of `rows`; places first .. first + count (modulo ny)
 * come out as rows [0, count). */
GP_MUST_CHECK gp_status gp_fft_multiply(const struct gp_fft_request *req,
                                        struct gp_fft_rows rows,
                                        const struct gp_fft_matrix *kernel,
                                        int first, int count,
                                        struct gp_fft_matrix *m);

/* Row `j` of channel `c` from z[x], x in [0, nx). */
typedef void (*gp_fft_store)(const void *ctx, int c, int j, const float *z);

/* Transforms rows [0, rows) back; those after them in their lines are spoilt. */
GP_MUST_CHECK gp_status gp_fft_rows_out(const struct gp_fft_request *req,
                                        const struct gp_fft_matrix *m, int rows,
                                        gp_fft_store store, const void *ctx);

// -- shared by transform.c and convolve.c ---------------------------------------------

/* A pass under way: what its tasks read, and scratch for each thread. */
struct gp_pass {
    const struct gp_fft_request *req;
    const struct gp_transform *t; // of the lines that are transformed
    struct gp_fft_matrix *m;
    const struct gp_fft_matrix *kernel;
    struct gp_fft_rows rows;
    double scale;
    int tasks; // of one channel
    int first, count;
    gp_fft_load load;
    gp_fft_store store;
    const void *ctx;
    char *scratch; // of each thread: two arrays of points
};

/* Their tasks, task i % tasks of channel req->channel + i / tasks, in either
 * precision: of the rows of a block of lines, of a block of columns. */
void gp_float_rows_in(void *ctx, int i, int thread);
void gp_float_make_kernel(void *ctx, int i, int thread);
void gp_float_multiply(void *ctx, int i, int thread);
void gp_float_rows_out(void *ctx, int i, int thread);
void gp_double_rows_in(void *ctx, int i, int thread);
void gp_double_make_kernel(void *ctx, int i, int thread);
void gp_double_multiply(void *ctx, int i, int thread);
void gp_double_rows_out(void *ctx, int i, int thread);

#endif
