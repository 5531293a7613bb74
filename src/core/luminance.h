// SPDX-License-Identifier: Apache-2.0
/* Sums of a frame's planes, and its luminance as a whole: its average,
 * percentiles, and largest.
 * All are the same for any number of threads. */
#ifndef GP_CORE_LUMINANCE_H
#define GP_CORE_LUMINANCE_H

#include "core/image.h"
#include "core/status.h"

/* Bands of a frame, each summed by itself; fixed, so that sums are the same for
 * any number of threads. */
enum { GP_FRAME_BANDS = 256 };

/* First pixel of a band; that of band GP_FRAME_BANDS is `pixels`. */
static inline size_t gp_band_start(size_t pixels, int band)
{
    return pixels / GP_FRAME_BANDS * (size_t) band +
           pixels % GP_FRAME_BANDS * (size_t) band / GP_FRAME_BANDS;
}

/* Light of a value: negative is none. */
static inline __attribute__((always_inline)) float gp_lit(float v)
{
    return v > 0.0f ? v : 0.0f;
}

/* Luminance of the non-negative part of a pixel. */
static inline __attribute__((always_inline)) float
gp_lit_luminance(const float weight[3], float r, float g, float b)
{
    return weight[0] * gp_lit(r) + weight[1] * gp_lit(g) +
           weight[2] * gp_lit(b);
}

/* Adds the sum of n samples, and of their squares. */
void gp_samples_add(const float *v, int n, double *squares, double *sum);

/* Sums each of three planes of `pixels`, and the squares in all of them. */
void gp_planes_sum(const struct gp_planes *p, size_t pixels, double sum[3],
                   double *squares);

/* The mean luminance over f's display window, where pixels outside of the data
 * window are black; negative channels count as they are, the result is >= 0.
 * `p` has the planes of f's size. */
double gp_mean_luminance(const struct gp_image *f, const struct gp_planes *p);

/* exp(mean(log(delta + Y))) over pixels with Y > 0 is finite, Reinhard et al.
 * 2002, eq. 1 (with the 1/N inside the exponent, as its erratum says);
 * delta 1e-6. 0 when no pixel counts. `p` has the planes of f's size. */
double gp_log_average(const struct gp_image *f, const struct gp_planes *p);

/* Finds the k-th smallest luminance, k from 1, of the non-negative part of
 * f->rgb, in the window that was read; NaN counts as 0.
 *   out  finite, >= 0; written only on GP_OK
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_luminance_rank(const struct gp_log *log,
    const struct gp_image *f, uint64_t k, float *out);

/* Finds that which `percent` (0 to 100) of the N pixels are not over, the nearest
 * rank: k = ceil(percent / 100 * N), at least 1. */
GP_MUST_CHECK gp_status gp_luminance_percentile(const struct gp_log *log,
    const struct gp_image *f, double percent, float *out);

/* The largest luminance of the same, and its first pixel in EXR pixel space. */
float gp_luminance_peak(const struct gp_image *f, int at[2]);

#endif
