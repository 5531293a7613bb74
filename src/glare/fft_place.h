/* Where a convolution stands on its torus, what it costs, how wrong it may be.
 */
#ifndef GP_GLARE_FFT_PLACE_H
#define GP_GLARE_FFT_PLACE_H

#include "glare/kernel.h"
#include "glare/sensors.h"

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

/* How much smaller than the kernel's norm the light that a source leaves in
 * a frame of w x h pixels can be: it keeps at least one quarter of the kernel,
 * centre included, or of its middle w x h samples when the frame is smaller.
 * Infinite when light can cancel, in kernels with lobes. */
double gp_fft_kernel_spread(const struct gp_kernel *k, int w, int h);

/* What rel_l2 cannot exceed: rounding of three transforms, each within
 * (4 + sqrt 2) 2^-24 log2 n of its norm (Higham 2002, theorem 24.2), over the
 * least that the layer can be: no two sources of non-negative light cancel. */
double gp_fft_bound(double spread, const struct gp_fft_placing *p);

#endif
