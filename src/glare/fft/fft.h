// SPDX-License-Identifier: Apache-2.0
/* Convolution by fast Fourier transforms: FFTW, the passes over rows and
 * columns, and a layer's lower limit. The engine is gp_engine_fft. */
#ifndef GP_GLARE_FFT_FFT_H
#define GP_GLARE_FFT_FFT_H

#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <fftw3.h>
#include <stdbool.h>
#include <stddef.h>

// -- plans.c: FFTW by dlopen; a run without a transform never loads it --------

/* The functions of one precision; P is its prefix, real its scalar type. */
#define GP_FFTW_TABLE(name, P)                                                \
    struct name {                                                             \
        P##plan (*plan_dft_1d)(int, P##complex *, P##complex *, int,          \
                               unsigned);                                     \
        void (*execute_dft)(const P##plan, P##complex *, P##complex *);       \
        void (*destroy_plan)(P##plan);                                        \
        int (*import_wisdom_from_filename)(const char *);                     \
        int (*import_wisdom_from_string)(const char *);                       \
        void (*forget_wisdom)(void);                                          \
        int (*export_wisdom_to_filename)(const char *);                       \
    }
GP_FFTW_TABLE(gp_fftwf, fftwf_);  // float
GP_FFTW_TABLE(gp_fftwd, fftw_);   // double

/* The library's functions, loaded at first call. Errors: GP_ERR_IO, with the
 * Debian package that is missing (libfftw3-single3, libfftw3-double3). */
GP_MUST_CHECK gp_status gp_fftwf_open(const struct gp_log *log,
                                      const struct gp_fftwf **out);
GP_MUST_CHECK gp_status gp_fftwd_open(const struct gp_log *log,
                                      const struct gp_fftwd **out);

/* Plans a transform by estimate, with more flags of FFTW; NULL where it has
 * none. Plans are made and ended by these alone: they hold the planner's lock,
 * for any thread to call. */
fftw_plan gp_fftwd_plan(const struct gp_fftwd *lib, int n, void *in, void *out,
                        int sign, unsigned flags);
void gp_fftwd_end(const struct gp_fftwd *lib, fftw_plan plan); // NULL: nothing

/* Nanoseconds, about, of one complex transform of length n. */
double gp_fft_cost(int n, enum gp_fft_plan how);

/* The fastest transform length >= n, n >= 1, planned by measuring: a multiple
 * of 8 whose other factors are 3, 5 and 7. */
int gp_fft_length(int n);

/* The same for the passes below, of plans by estimate and with each point's
 * moves: the length of columns; and that of rows where columns are ny long,
 * `rows` > 0 rows each way, for which a longer row has more columns. */
int gp_fft_column_length(int n);
int gp_fft_row_length(int n, int rows, int ny);

/* The plans of one length: out of place, GP_ALIGN-aligned arrays. */
struct gp_fft_plan_pair {
    int n;
    enum gp_fft_plan how;
    bool in_double;
    fftwf_plan forward, backward;              // NULL in double
    fftw_plan forward_double, backward_double; // NULL in float
};

/* Plans for that length. Estimated plans depend on nothing but the length, the
 * library and the CPU, and are those of known.c where FFTW takes them; measured
 * ones may be faster, may differ in the last bits from run to run, and are read
 * from and added to the wisdom file (NULL: kept nowhere).
 * Errors: GP_ERR_BUG. Free with gp_fft_plan_free(). */
GP_MUST_CHECK gp_status gp_fft_plan_make(const struct gp_log *log, int n,
    enum gp_fft_plan how, const char *wisdom, struct gp_fft_plan_pair *out);

/* Plans in double, estimated. */
GP_MUST_CHECK gp_status gp_fft_plan_make_double(const struct gp_log *log, int n,
    struct gp_fft_plan_pair *out);
void gp_fft_plan_free(struct gp_fft_plan_pair *p);

// -- pass.c: passes ----------------------------------------------------------

/* The passes of the two-dimensional convolution by Fourier transforms.
 *
 * All transforms are complex, contiguous and out of place, the kind FFTW does
 * fastest (2 to 3 times faster than real or strided ones, measured):
 *
 *   rows     two real rows are one complex row: z = a + ib, so that
 *            A(k) = (Z(k) + conj Z(-k)) / 2, B(k) = (Z(k) - conj Z(-k)) / 2i.
 *            Eight rows at a time go transposed into the matrix, a full cache
 *            line (in double, two) to each column.
 *   columns  one column stays in the first-level cache: forward, times the
 *            kernel's column, backward; rows without light are not stored,
 *            rows that are no output are not kept.
 *   rows     back, eight at a time, two to a transform, into the layer. */

/* Kind and precision of a matrix's numbers. */
struct gp_fft_numbers {
    bool real;      // re only: the spectrum of what is even about its centre
    bool in_double;
};

/* Columns k = 0 .. nx/2 of a half spectrum, each `pitch` complex numbers. */
struct gp_fft_matrix {
    int columns;    // stored: nx / 2 + 1, rounded up to a multiple of 4
    size_t pitch;   // complex numbers from column to column, multiple of 8
    float *z[3];    // interleaved re, im; [column * pitch + row]; one block; of
                    // a matrix in double, its doubles
    struct gp_fft_numbers of;
};

/* Makes `channels` planes of such numbers, or of complex ones in float; not
 * cleared. Free with gp_fft_matrix_free(). */
GP_MUST_CHECK gp_status gp_fft_matrix_make_of(const struct gp_log *log,
    struct gp_fft_numbers of, int channels, int nx, int rows,
    struct gp_fft_matrix *out);
GP_MUST_CHECK gp_status gp_fft_matrix_make(const struct gp_log *log,
    int channels, int nx, int rows, struct gp_fft_matrix *out);
void gp_fft_matrix_free(struct gp_fft_matrix *m);

/* Bytes of one plane, and a matrix of one in memory of the caller, at
 * GP_ALIGN, which is not to be freed. */
size_t gp_fft_matrix_bytes(struct gp_fft_numbers of, int nx, int rows);
struct gp_fft_matrix gp_fft_matrix_in(void *memory, struct gp_fft_numbers of,
                                      int nx, int rows);

/* State that the passes share. */
struct gp_fft_request {
    const struct gp_log *log;
    const struct gp_fft_plan_pair *x, *y;  // lengths nx, ny; as both are, the
                                           // passes and all their matrices are
                                           // in float or in double
    int channel, channels; // the first, and how many
};

/* Row `j` of channel `c` to z[2 * x], x in [0, nx); z is cleared, and only
 * every other float may be written. */
typedef void (*gp_fft_load)(const void *ctx, int c, int j, float *z);

/* Transforms `rows` rows into m->z[c][column][j]; factors of 1/2 are left out:
 * the matrix holds twice the spectrum. */
GP_MUST_CHECK gp_status gp_fft_rows_in(const struct gp_fft_request *req,
    int rows, gp_fft_load load, const void *ctx, struct gp_fft_matrix *m);

/* Transforms columns of `rows` rows, row j at place[j] of ny, to
 * whole columns of `out` (pitch >= ny), times `scale`. Places are distinct and
 * ascend from place[0] on, modulo ny. */
GP_MUST_CHECK gp_status gp_fft_columns(const struct gp_fft_request *req,
    const struct gp_fft_matrix *m, int rows, const int *place, double scale,
    struct gp_fft_matrix *out);

/* A kernel's spectrum of one channel (grey) or three, in whole columns of
 * pitch >= ny, scaled so that the passes need no more factors; or the rows that
 * it is made of on the way. */
struct gp_fft_kernel {
    int channels;
    struct gp_fft_matrix spectrum; // made: its planes are written, or, where
                                   // they are NULL, it is not kept
    const struct gp_fft_matrix *rows; // of gp_fft_rows_in(), to make it of;
                                      // NULL: it is there
    int n;            // rows: row j at place[j] of ny, or, where the spectrum
    const int *place; // is real, at j, and -j is row j from right to left:
                      // n <= ny / 2
    double scale;
};

/* Forward, times the kernel, backward, each column in place: rows [0, rows)
 * in, as gp_fft_columns() takes them, places first .. first + count (modulo ny)
 * out to rows [0, count). A kernel's spectrum is made for one channel. */
GP_MUST_CHECK gp_status gp_fft_multiply(const struct gp_fft_request *req,
    struct gp_fft_matrix *m, int rows, const int *place,
    const struct gp_fft_kernel *kernel, int first, int count);

/* Row `j` of channel `c` from z[2 * x], x in [0, nx), on a thread of
 * gp_parallel_do(). */
typedef void (*gp_fft_store)(const void *ctx, int c, int j, int thread,
                             const float *z);

/* Transforms rows [0, rows) back. */
GP_MUST_CHECK gp_status gp_fft_rows_out(const struct gp_fft_request *req,
    const struct gp_fft_matrix *m, int rows, gp_fft_store store,
    const void *ctx);

// -- split.c -----------------------------------------------------------------

/* The least light that a source adds to a frame, in each channel: one quarter
 * of the kernel, centre included, or of its middle w x h samples when the frame
 * is smaller. 0 where a quarter is dark or, of a negative kernel, may
 * cancel. */
struct gp_fft_quarters {
    double square[3], sum[3]; // sum of squares, and of samples
};
void gp_fft_find_quarters(const struct gp_kernel *k, int w, int h,
                          struct gp_fft_quarters *out);

/* The layer's norm cannot be under this: light adds up, so its square is at
 * least the sum of the squares of what each source leaves in the frame, and its
 * sum spread evenly. */
double gp_fft_least(const struct gp_sources *s,
                    const struct gp_fft_quarters *q);

#endif
