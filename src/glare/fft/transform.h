// SPDX-License-Identifier: Apache-2.0
/* Complex transforms of many lines at once, rows or columns of a matrix.
 *
 *   Z(k) = sum over x in [0, n) of z(x) exp(-2 pi i k x / n)
 *
 * A vector holds one point of several lines, one in each lane. So no lane ever
 * meets another, and every CPU, whatever the width of its vectors, does the same
 * sums and products in the same order: the bytes are the same on all of them.
 *
 * The transform is Stockham's (Cochran et al., What is the fast Fourier
 * transform?, 1967): passes between two arrays, which leave the frequencies in
 * order, by radices 2, 3, 4, 5, 7 and 8 (Temperton, Self-sorting mixed-radix fast
 * Fourier transforms, J. Comp. Phys. 52, 1983), and by sums of as many products for
 * other primes. The transform back is this one of
 * numbers whose re and im are exchanged, before and after: who packs them does
 * that, at no cost.
 *
 * transform.c is compiled for float, and by double.c for double. */
#ifndef GP_GLARE_FFT_TRANSFORM_H
#define GP_GLARE_FFT_TRANSFORM_H

#include "core/status.h"

#include <stddef.h>

/* Lines that are transformed at once. */
enum { GP_FLOAT_LINES = 8, GP_DOUBLE_LINES = 4 };

/* A point of so many lines: re of each, then im of each; one cache line. */
typedef float gp_float_lines __attribute__((vector_size(32)));
typedef double gp_double_lines __attribute__((vector_size(32)));
enum { GP_POINT_BYTES = 64 };

/* A transform of one length in one precision, for any thread. */
struct gp_transform {
    int n, passes;
    unsigned char radix[30]; // of each pass
    void *root; // exp(-2 pi i k / n), k in [0, n), interleaved re, im
};

/* Makes the transform of a length n >= 1 that gp_fft_takes(). Roots are found in
 * double. Errors: GP_ERR_BUG. Free with gp_transform_free(). */
GP_MUST_CHECK gp_status gp_float_transform_make(const struct gp_log *log, int n,
                                                struct gp_transform *out);
GP_MUST_CHECK gp_status gp_double_transform_make(const struct gp_log *log,
                                                 int n,
                                                 struct gp_transform *out);
void gp_transform_free(struct gp_transform *t);

/* Transforms the n points of `z`; each has re of all lines, then im. `other` is
 * scratch of as many. Both are at GP_ALIGN, and best gp_transform_room() apart.
 * Returns that one of them which has the result; the other is spoilt. */
float *gp_float_transform(const struct gp_transform *t, float *z, float *other);
double *gp_double_transform(const struct gp_transform *t, double *z,
                            double *other);

/* Bytes of an array of n points, and a gap after it: half a page is between two
 * arrays, so that they do not share the sets of a cache. */
size_t gp_transform_room(int n);

/* Returns the least length >= n, n >= 1, that is a multiple of 8 and has no
 * factors but 2, 3, 5 and 7. */
int gp_fft_length(int n);

/* Tests whether a length has no prime factors over 127. */
bool gp_fft_takes(int n);

#endif
