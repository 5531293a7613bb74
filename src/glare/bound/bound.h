// SPDX-License-Identifier: Apache-2.0
/* Bounds of errors that are known before an engine runs, from only the sources,
 * the kernel and the frame. */
#ifndef GP_GLARE_BOUND_BOUND_H
#define GP_GLARE_BOUND_BOUND_H

#include "core/status.h"
#include "glare/engine.h"

/* Finds a lower limit of the 2-norm of the exact layer over the frame; 0 for a
 * kernel with negative samples. Where nothing is negative, light only adds up.
 * So the square of the norm is no less than the sum of the squares of the
 * sources' layers, each by itself; nor than that of a layer in which each pixel
 * has the least light of its cell. Each channel takes the larger of the two. */
GP_MUST_CHECK gp_status gp_layer_least(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    double *least);

/* Such a limit at once: by what each source leaves in its own pixel, and of a sky by the
 * sum of samples, whose mean square is no less than the mean's. */
double gp_layer_some(const struct gp_glare_request *req);

/* Limits for gp_pixel_bound(): of the composite's luminance Y, in which a
 * pixel's own part is all but the light of other pixels; and of a layer's
 * samples and errors, by channel. */
struct gp_pixel_floor {
    double own;            // least own part of a pixel
    double dimmest;        // every pixel has Y >= dimmest - negative
    double brightest;      // some pixel has Y >= brightest - negative
    double negative;       // most that the layer takes from Y, where a channel
                           // has negative weight; else 0
    double weight[3];      // of luminance
    double layer[3];       // largest sample
    double lost[3], far[3]; // error by values under FLT_MIN; of the far field
    double rounded;        // error of light from beyond the border, over Y
    int times;             // that engines have the light halved
};
GP_MUST_CHECK gp_status gp_pixel_floor_find(const struct gp_glare_request *req,
    const struct gp_image *f, struct gp_pixel_floor *out);

/* Bounds max_rel, the largest |error of Y| / (Y + 1e-6 peak) of a pixel, where
 * `e` is the engine's error of the layer, and `gain` the layer's factor. */
double gp_pixel_bound(const struct gp_pixel_floor *f,
                      const struct gp_pixel_error *e, double gain);

/* Finds two errors, over the layer's norm, that an engine's bound of rel_l2
 * leaves out: by values under FLT_MIN that became 0, and by the far field.
 * INFINITY where nothing can be guaranteed. */
GP_MUST_CHECK gp_status gp_error_floor_find(const struct gp_glare_request *req,
                                            double *floor);

#endif
