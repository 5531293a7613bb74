/* The passes of the two-dimensional convolution by Fourier transforms.
 *
 * All transforms are complex, contiguous and out of place, the kind FFTW does
 * fastest (2 to 3 times faster than real or strided ones, measured):
 *
 *   rows     two real rows are one complex row: z = a + ib, so that
 *            A(k) = (Z(k) + conj Z(-k)) / 2, B(k) = (Z(k) - conj Z(-k)) / 2i.
 *            Eight rows at a time go transposed into the matrix, a full cache
 *            line to each column.
 *   columns  one column stays in the first-level cache: forward, times the
 *            kernel's column, backward; rows without light are not stored,
 *            rows that are no output are not kept.
 *   rows     back, eight at a time, two to a transform, into the layer.
 */
#ifndef GP_GLARE_FFT_PASS_H
#define GP_GLARE_FFT_PASS_H

#include "core/status.h"
#include "glare/fft/lib.h"

#include <stddef.h>

/* Columns k = 0 .. nx/2 of a half spectrum, each `pitch` complex numbers. */
struct gp_fft_matrix {
    int columns;    // stored: nx / 2 + 1, rounded up to a multiple of 4
    size_t pitch;   // complex numbers from column to column, multiple of 8
    float *z[3];    // interleaved re, im; [column * pitch + row]
};

/* Makes `channels` planes; not cleared. Free with gp_fft_matrix_free(). */
GP_MUST_CHECK gp_status gp_fft_matrix_make(const struct gp_log *log,
                                           int channels, int nx, int rows,
                                           struct gp_fft_matrix *out);
void gp_fft_matrix_free(struct gp_fft_matrix *m);

/* What the passes share. */
struct gp_fft_job {
    const struct gp_log *log;
    const struct gp_fft_plan_pair *x, *y;  // lengths nx, ny
    int channel, channels; // the first, and how many
};

/* Row `j` of channel `c` to z[2 * x], x in [0, nx); z is cleared, and only
 * every other float may be written. */
typedef void (*gp_fft_load)(const void *ctx, int c, int j, float *z);

/* Transforms `rows` rows into m->z[c][column][j]; factors of 1/2 are left out:
 * the matrix holds twice the spectrum. */
GP_MUST_CHECK gp_status gp_fft_rows_in(const struct gp_fft_job *job, int rows,
                                       gp_fft_load load, const void *ctx,
                                       struct gp_fft_matrix *m);

/* Transforms columns of `rows` rows, row j standing at place[j] of ny, to
 * whole columns of `out` (pitch >= ny), times `scale`. */
GP_MUST_CHECK gp_status gp_fft_columns(const struct gp_fft_job *job,
                                       const struct gp_fft_matrix *m, int rows,
                                       const int *place, float scale,
                                       struct gp_fft_matrix *out);

/* Forward, times the kernel, backward, each column in place: rows [0, rows)
 * in, places first .. first + count (modulo ny) out to rows [0, count).
 * The kernel has one channel (grey) or three. */
GP_MUST_CHECK gp_status gp_fft_multiply(const struct gp_fft_job *job,
                                        struct gp_fft_matrix *m, int rows,
                                        const int *place,
                                        const struct gp_fft_matrix *kernel,
                                        int kernel_channels, int first,
                                        int count);

/* Row `j` of channel `c` from z[2 * x], x in [0, nx). */
typedef void (*gp_fft_store)(const void *ctx, int c, int j, const float *z);

/* Transforms rows [0, rows) back. */
GP_MUST_CHECK gp_status gp_fft_rows_out(const struct gp_fft_job *job,
                                        const struct gp_fft_matrix *m,
                                        int rows, gp_fft_store store,
                                        const void *ctx);

#endif
