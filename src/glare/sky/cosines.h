// SPDX-License-Identifier: Apache-2.0
/* Diffraction by direction cosines.
 *
 * Behind a flat pupil light spreads from u' to u by D(u - u') for all u', where
 * u = (x, y) of a direction of length 1, z along the pupil's normal: its cosines. What
 * so spreads is radiance: Harvey et al., Diffracted radiance: a fundamental quantity in
 * nonparaxial scalar diffraction theory, Applied Optics 38 (1999), eq. 13.
 *
 *   layer(p) = sum over sources s of L_s a_s D(u_p - u_s)
 *
 * a_s being the area of a pixel in the cosines, its solid angle times z. D is as a pixel
 * in the middle of the field sees it, which shines and is lit evenly: its transform has
 * sinc^2 of each axis up to the first zeros, and nothing beyond. Light that is finer than
 * that stays in its pixel and those around it, the same everywhere. So D rings a little;
 * the layer of all sources is at least 0.
 *
 * It is summed on nodes, a step apart. With B the spline of degree 7,
 *
 *   n(j)     = sum over s of L_s a_s / step^2  B(u_s / step - j)
 *   r(j)     = sum over k of K(j - k) n(k)
 *   layer(p) = sum over j of r(j) B(u_p / step - j)
 *
 * K's transform is D's over the square of B's, and D a spline of degree 7 through what K
 * and B's own samples make. What splines let through of other frequencies is the error:
 * at most twice the share (2 eps + eps^2) of far_field.h. */
#ifndef GP_GLARE_SKY_COSINES_H
#define GP_GLARE_SKY_COSINES_H

#include "core/image.h"
#include "core/projection.h"
#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <stdbool.h>

/* The nodes of pictures that a camera shows. */
struct gp_cosine_grid {
    struct gp_projection projection; // PERSPECTIVE; places count from ...
    int w, h;                        // ... the corner of so many pixels
    double step[2];                  // along each axis
    double nodes;                    // steps that a pixel in the middle is wide
    int size[2];                     // nodes that the frame meets
};

/* Lays the nodes for light of at most `finest` cycles a radian, as fine as that or a
 * pixel in the middle needs; false: another projection, or pixels are over 8 degrees
 * wide. */
bool gp_cosine_grid_lay(const struct gp_projection *p, int w, int h,
                        double finest, struct gp_cosine_grid *out);

struct gp_cosines {
    struct gp_cosine_grid grid;
    struct gp_kernel nodes; // K; owned
    float weight[3];        // of luminance
    double light[3], all;   // of a source, that is spread; its luminance
    double wrong; // limits the norm of the splines' error for light of norm 1
    // D's samples at w x h nodes around its middle, without its far field: sums of their
    // luminance from the left, rows of w + 1; owned
    int w, h;
    double *sums;
};

/* Frees them, allocated by gp_alloc(), and what they own. */
void gp_cosines_free(struct gp_cosines **c);

/* D at (u, v) steps of a kernel's nodes, without its far field. */
void gp_cosines_at(const struct gp_kernel *k, double u, double v, double d[3]);

/* The share of the light of a source at (x, y) that falls outside of the frame, within
 * 1e-3 of the light. */
double gp_cosines_outside(const struct gp_cosines *c, double x, double y);

/* Fills planes of w x h pixels, as below, with the share of a pixel's glare that comes from outside
 * where all is even, by channel. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_cosines_beyond(const struct gp_log *log,
                                          const struct gp_cosines *c, int w,
                                          int h, struct gp_planes *share);

/* State that is kept from frame to frame: NULL at first. */
struct gp_cosines_kept;
void gp_cosines_kept_free(struct gp_cosines_kept **kept);

/* Adds the layer of `n` sources, of which places count from the corner of a picture of
 * w x h pixels in the middle of those of the grid; they may lie beside it. Beyond the
 * kernel's reach they light nothing. `last`: nothing is kept. Errors: GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_cosines_add(const struct gp_log *log,
                                       const struct gp_cosines *c,
                                       const struct gp_source *source, size_t n,
                                       struct gp_rect picture,
                                       struct gp_planes *layer, bool last,
                                       struct gp_cosines_kept **kept);

/* The same as it is defined, pair by pair in double, of sources in the grid's pixels: to
 * 3 w h numbers that are not NaN. */
GP_MUST_CHECK gp_status gp_cosines_exact(const struct gp_log *log,
                                         const struct gp_cosines *c,
                                         const struct gp_source *source,
                                         size_t n, double *layer);

#endif
