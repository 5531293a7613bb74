/* Polygons gathered per tile: one fragment pass over a tile sums over the
 * polygons that reach it, four pixels a fragment, so that nothing is blended
 * and a kernel sample is fetched four at a time. */
#ifndef GP_GLARE_SPLAT_TILE_H
#define GP_GLARE_SPLAT_TILE_H

#include "core/frame.h"
#include "core/status.h"
#include "gl/gl.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"
#include "glare/splat/blur.h"

/* Programs, packed kernels and targets kept from frame to frame. */
struct gp_tiles;

/* Writes the polygons' light to the layer's planes (w x h samples, three
 * planes; what they held is lost). The context is current.
 *
 *   crop    part of the kernel that can reach the frame, in kernel pixels
 *   tail    leave the kernel's core out (GP_GROUP_CORE)
 *   shrink  reach of each polygon
 *   *state  NULL at first; kept by the caller; gp_tiles_free(). Packed kernels
 *           are kept while kernel->serial, crop and tail stay.
 *
 * Polygons at whole pixels with blur 0 are fetched exactly; others are
 * sampled bilinearly, with weights in float and not the driver's. Fractions
 * of positions are rounded to 2^-25 of a pixel. The sum's order depends on
 * nothing but the arguments (within a blur the polygons' own), and each pixel
 * sees at most *roundings float roundings of its sum, each 2^-24 of it where
 * GL rounds to nearest.
 * Errors: GP_ERR_GL no context can draw it, or a blurred kernel over the
 * texture limit; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_tiles_draw(const struct gp_log *log,
                                      struct gp_gl *gl,
                                      const struct gp_kernel *kernel,
                                      struct gp_rect crop, bool tail,
                                      const struct gp_polygons *polygons,
                                      const struct gp_shrink *shrink, int w,
                                      int h, struct gp_planes *layer,
                                      struct gp_tiles **state,
                                      double *roundings);
void gp_tiles_free(struct gp_gl *gl, struct gp_tiles **state);

/* Roundings of a pixel's sum that gp_tiles_draw() stays under, before it is
 * called. */
double gp_tiles_roundings(const struct gp_polygons *polygons);

#endif
