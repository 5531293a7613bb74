/* Where a convolution stands on its torus, what it costs, how wrong it may be.
 */
#ifndef GP_GLARE_FFT_PLACE_H
#define GP_GLARE_FFT_PLACE_H

#include "glare/kernel.h"
#include "glare/sensors.h"

#include <stdbool.h>

/* Where the sources, the kernel and the outputs stand on the torus of
 * nx * ny samples. The smallest on which no wrapped light reaches an output. */
struct gp_fft_placing {
    int nx, ny;          // 0 when no light reaches the frame
    struct gp_rect in;   // box of the sources
    struct gp_rect out;  // pixels of the frame that light reaches
    struct gp_rect taps; // offsets from source to pixel that occur
};

/* Places sources (at least one) and a kernel. */
struct gp_fft_placing gp_fft_place(const struct gp_sources *s,
                                   const struct gp_kernel *k);

/* Milliseconds of the passes on one core, kernel's spectrum not included. */
double gp_fft_predict_ms(const struct gp_sources *s,
                         const struct gp_fft_placing *p);

/* What a source leaves in a frame at least, in each channel: one quarter of the
 * kernel, centre included, or of its middle w x h samples when the frame is
 * smaller. 0 where a quarter is dark or, with `lobes`, may cancel. */
struct gp_fft_quarters {
    double square[3], sum[3]; // sum of squares, and of samples
    bool lobes;               // samples are under 0
};
void gp_fft_find_quarters(const struct gp_kernel *k, int w, int h,
                          struct gp_fft_quarters *out);

/* The layer's norm cannot be under this: light adds up, so its square is at
 * least the sum of the squares of what each source leaves in the frame, and its
 * sum spread evenly. */
double gp_fft_least(const struct gp_sources *s,
                    const struct gp_fft_quarters *q);

/* What rel_l2 of transforms of s with k cannot exceed, where the layer's norm
 * is at least `least`; INFINITY where that is 0.
 *
 * A stage of a transform is within (4 + sqrt 2) 2^-24 of its norm, one that
 * only adds within 2^-24 (Higham 2002, theorem 24.2). Roundings of different
 * stages are taken as independent and of mean 0, so that n of them add up to
 * sqrt n (Higham and Mary 2019); the largest that each can be is over 10 times
 * what they come to together. Errors of the two transforms forward are spread
 * over all frequencies, and meet the other factor's norm; where they lie with
 * the light, at the lowest, only additions made them. Those, and those of the
 * transform back, grow with the whole layer, in the frame and beyond it, which
 * Young's inequality limits. */
double gp_fft_bound(const struct gp_sources *s, const struct gp_kernel *k,
                    double least, const struct gp_fft_placing *p);

#endif
