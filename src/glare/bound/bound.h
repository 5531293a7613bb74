/* Bounds of errors that are known before an engine runs, from only the sources,
 * the kernel and the frame. */
#ifndef GP_GLARE_BOUND_BOUND_H
#define GP_GLARE_BOUND_BOUND_H

#include "core/status.h"
#include "glare/engine.h"

/* Finds a lower limit of || exact layer ||_2 over the frame; 0 for kernels with
 * lobes. Light only adds up: the layer's square is no less than the sum of the
 * squares of each source's own part, nor than that of the least light of each
 * cell in all of its pixels. Each channel takes the larger.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_layer_least(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    double *least);

/* Limits of the exact composite, known before it is made. */
struct gp_pixel_floor {
    double least;          // of its luminance, without light from other pixels
    double lit, most;      // of its luminance, some of that light included
    double less;           // most negative luminance of such light, as >= 0
    double weight[3];      // of luminance
    double layer[3], lost[3]; // most of a sample; its part under FLT_MIN
    double far[3];        // most error of a sample by the kernel's far field
    double rounded;        // share of a sample that rounding light from beyond
                           // the border is wrong by
};
GP_MUST_CHECK gp_status gp_pixel_floor_find(const struct gp_glare_request *req,
    const struct gp_image *f, struct gp_pixel_floor *out);

/* Bounds max_rel: |error| / (Y + 1e-6 peak), where the error in luminance is at
 * most share * gain * layer + gain * sum of weight * of, and the composite Y is
 * at least `lit`, as kernel and light are not negative. The
 * share's part is at most `share` where Y's own part is not negative. */
double gp_pixel_bound(const struct gp_pixel_floor *f,
                      const struct gp_pixel_error *e, double gain);

/* Finds the error that underflow, and the far field, add to an engine's
 * bound of rel_l2, which is for the core in floats that never leave their
 * range; INFINITY where nothing can be guaranteed. 1e-20 in ordinary
 * frames, 1e-6 with a far field, and cheap; else by gp_layer_least().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_error_floor_find(const struct gp_glare_request *req,
                                            double *floor);

#endif
