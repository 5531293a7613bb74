// SPDX-License-Identifier: Apache-2.0
/* Deep pixels: any number of samples each, which are surfaces or volumes with a share
 * of light that they hide, in any order.
 * Source: Hillman, "Interpreting OpenEXR Deep Pixels" (OpenEXR documents). */
#ifndef GP_CORE_DEEP_H
#define GP_CORE_DEEP_H

#include "core/image.h"
#include "core/status.h"

#include <stdint.h>

/* Samples of the pixels of a window; all borrowed. Those of pixel i, rows from the
 * top, are [first[i], first[i + 1]). */
struct gp_deep {
    struct gp_rect window;
    const int64_t *first; // from 0, never falling
    const float *z;       // NaN: no sample
    const float *back;  // its end, if that is over z: a volume; NULL: none are
    const float *alpha; // cut to 0 to 1, NaN 0
    const float *colour[3]; // times alpha; NULL: none
    const char *name;       // of another file than the frame's; else NULL
};

/* Returns the share of light from `depth`, in the unit of z and beyond all for
 * INFINITY, that shows in a pixel: the product over its samples of 1 - alpha, of
 * a volume that reaches beyond `depth` to the power of its part before that. 1
 * outside of the window. */
double gp_deep_clear(const struct gp_deep *d, int x, int y, double depth);

/* Flattens all pixels: samples are sorted; volumes that overlap are split where another
 * begins or ends, and merged, each with the share of its light that the part has; then
 * laid one over the other. Surfaces in one place are merged too.
 *   out    colour of each pixel, times alpha
 *   alpha  of each pixel, or NULL
 * The same for any order of samples but for rounding. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_deep_flatten(const struct gp_log *log,
                                        const struct gp_deep *d,
                                        const struct gp_planes *out,
                                        float *alpha);

#endif
