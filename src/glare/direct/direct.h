/* The convolution sum as it is written, source by source. */
#ifndef GP_GLARE_DIRECT_DIRECT_H
#define GP_GLARE_DIRECT_DIRECT_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

#include <stdbool.h>

/* A tap of all three channels on one core: one 512 x 512 source takes 0.063 ms
 * at 2.5 GHz with AVX2 (1542 sources over the whole kernel in 97 ms). Pieces
 * narrower than a strip pay for the strip. */
#define GP_DIRECT_MS_PER_TAP (0.063 / (512.0 * 512.0))

/* A kernel laid out for direct sums: each row has GP_TAPS_PAD zeros on both
 * sides, so that a strip of that many pixels never needs a border case. */
enum { GP_TAPS_PAD = 32 };
struct gp_taps {
    int w, h, cx, cy;  // as in gp_kernel
    size_t pitch;      // floats from row to row
    float *k[3];
    bool lobes;        // a sample is under 0
};

/* Copies the part of the kernel within `radius` pixels of its centre in x
 * and in y (the whole kernel when radius < 0). Free with gp_taps_free().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_taps_make(const struct gp_log *log,
                                     const struct gp_kernel *kernel,
                                     int radius, struct gp_taps *out);
void gp_taps_free(struct gp_taps *t);

/* Adds the sum to the layer (`add`), or writes it there. Each sample is summed
 * in the order of the sources, in float, in groups of 32 whose sums are added
 * with compensation, so that its error grows with the group alone.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_direct_sum(const struct gp_log *log,
                                      const struct gp_sources *src,
                                      const struct gp_taps *taps, bool add,
                                      struct gp_planes *layer);

/* Quads (direct_quad.h) that gp_direct_sum() makes of the sources when the
 * kernel is small, about; 0 when it takes them one by one, as they stand too
 * far apart. */
double gp_direct_quads(const struct gp_sources *src);

/* What rel_l2 of the sum of n sources cannot exceed: float rounding, as long
 * as no product is under the range of float. INFINITY for taps with lobes,
 * whose light can cancel while the rounding stays. */
double gp_direct_bound(const struct gp_taps *taps, size_t n);

/* Whether the kernel has samples under 0: where magnitudes add up to more than
 * samples do, as both are summed in one order. */
bool gp_direct_lobes(const struct gp_kernel *kernel);

/* Multiply-adds that gp_direct_sum makes on a channel: each source's kernel,
 * cut to the frame. */
double gp_direct_work(const struct gp_sources *src, int w, int h, int cx,
                      int cy);

#endif
