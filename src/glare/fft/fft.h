// SPDX-License-Identifier: Apache-2.0
/* Convolution by fast Fourier transforms. The engine is gp_engine_fft: fft.c is
 * its frame, place.c the torus and its bounds, spectrum.c the kernel's spectrum,
 * convolve.c the passes over rows and columns, transform.c their tasks. */
#ifndef GP_GLARE_FFT_FFT_H
#define GP_GLARE_FFT_FFT_H

#include "core/status.h"
#include "glare/engine.h"
#include "glare/fft/pass.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <stdbool.h>

// -- place.c ------------------------------------------------------------------

/* Returns v modulo n, in [0, n). */
static inline int gp_fft_wrap(int v, int n)
{
    return v % n < 0 ? v % n + n : v % n;
}

/* Tests whether what has this serial was made for k. */
static inline bool gp_fft_is_of(unsigned long serial, const struct gp_kernel *k)
{
    return serial && serial == k->serial;
}

/* The places of sources, kernel and outputs on the torus of nx * ny
 * samples. The smallest on which no wrapped light reaches an output. */
struct gp_fft_placing {
    int nx, ny;          // 0 when no light reaches the frame
    struct gp_rect in;   // box of the sources
    struct gp_rect out;  // pixels of the frame that light reaches
    struct gp_rect taps; // offsets from source to pixel that occur
};

/* Places sources (at least one) and a kernel. */
struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k);

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

/* What is transformed of a kernel, all but the sample of its centre: sum of
 * magnitudes, root of the sum of squares, and largest magnitude, by channel. */
struct gp_fft_norms {
    double sum[3], norm[3], most[3];
};

/* 2^-24, or in double 2^-53: half the last place of 1. */
double gp_fft_rounding(bool in_double);

/* Bounds rel_l2 of transforms of s with k, over gp_fft_rounding(), where the
 * layer's norm is at least `least`; INFINITY where that is 0.
 *
 * Roundings are taken as independent and of mean 0, so that n stages of a
 * transform add up to sqrt n (Higham and Mary 2019). One is uniform in +-2^-24
 * of the power of two under its result, whose mantissa m is as likely as 1 / m:
 * r = 2^-24 sqrt(1 / (8 ln 2)) = 0.425 * 2^-24 of the result in the mean, the
 * error of a stage that only adds. A butterfly a +- w b rounds w b in its four
 * products, in their two sums, and in w: 3 r^2 of |b|^2, and then adds: with
 * |a| = |b| it is within sqrt(3 / 2 + 1) r = 0.672 * 2^-24 of its norm. Both
 * are rounded up by a tenth. Independent as the errors of the three transforms
 * are, they are added here as if they were one: the largest that a search for
 * the worst frame found is 0.56 of the sum, and 0.3 is usual (the suite
 * adversary). Errors of the two transforms forward are spread
 * over all frequencies, and meet the other factor's norm; where they lie with
 * the light, at the lowest, only additions made them. Those, and those of the
 * transform back, grow with the whole layer, in the frame and beyond it, which
 * Young's inequality limits. */
double gp_fft_bound(const struct gp_sources *s, const struct gp_fft_norms *k,
                    double least, const struct gp_fft_placing *p);

/* Bounds the error of any sample of channel c that transforms of a frame give,
 * over gp_fft_rounding(), for light and a kernel that are not negative.
 *
 *   most  of a sample of the layer on the torus, by Young's inequality
 *   norm  of the layer there, at most, by it too
 *   pair  the most that a source adds to a pixel
 *
 * Roundings count as independent, uniform and of mean 0, and a stage's have the
 * deviation STAGE 2^-24 |v| in a node of value v, as for gp_fft_bound(). A
 * uniform variable is strictly sub-Gaussian (Arbel, Marchal and Nguyen 2020), so
 * the sum of all stays under t of its deviations, but for a chance of
 * 2 exp(-t^2 / 2): 4.6e-11 a sample with t = 7, one in 1000 frames of 4K.
 *
 * A stage that has folded n samples, nx ny / n apart, into each of its nodes
 * meets a pixel with nodes of light v and of kernel g: by Parseval the sum of
 * |v|^2 |g|^2 over a coset's n frequencies is 1 / n times the square of the
 * circular convolution of both cosets, whose samples are at most n pair. Summed
 * over cosets, as nothing is negative, that is at most the mean square of the
 * layer on n samples: at most most^2, norm^2 / n, and n pair most. The kernel's
 * transform is the same with light and kernel changed; the one back has the
 * layer's parts in its nodes, and only the first two limits. Two rows that
 * share a transform have half of its error each: the mean of their own and of
 * what their light in each other's place would make, which has the same limits.
 * The product with the kernel is within the sum's term n = 1. */
double gp_fft_pixel_error(const struct gp_fft_placing *p,
                          const struct gp_sources *s,
                          const struct gp_fft_norms *k, int c);

/* Estimates the deviation of a sample's error in channel c, over gp_fft_rounding():
 * what the two transforms there and the one back leave, spread evenly, the layer's
 * norm being what Young's inequality allows. Or the largest error of a sample: 18
 * deviations of what the transforms there leave, which lies in rows of light, 9 of what
 * the one back does, which only adds. Measured: up to three quarters of it. */
double gp_fft_noise(const struct gp_fft_placing *p, const struct gp_sources *s,
                    const struct gp_fft_norms *k, int c, bool most);

// -- spectrum.c ---------------------------------------------------------------

/* A kernel's spectrum, kept from frame to frame. The sample of the centre, where
 * most of a glare's light stays, is left out: it needs no transform. */
struct gp_fft_spectrum {
    unsigned long kernel; // serial
    struct gp_fft_placing placing;
    int channel;            // that it is of; -1: of all, or grey
    struct gp_fft_matrix m; // scaled so that the passes need no more factors
};
void gp_fft_spectrum_free(struct gp_fft_spectrum *s);

/* Makes *s the spectrum of the request's kernel for channel fft->channel, unless it
 * is; of a coloured kernel that no later frame takes, of that channel alone. */
GP_MUST_CHECK gp_status gp_fft_find_spectrum(const struct gp_glare_request *req,
                                             const struct gp_fft_request *fft,
                                             const struct gp_fft_placing *p,
                                             struct gp_fft_spectrum *s);

#endif
