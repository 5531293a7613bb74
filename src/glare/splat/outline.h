/* The picture of polygons, as in Ando et al. 2007, figure 6. */
#ifndef GP_GLARE_SPLAT_OUTLINE_H
#define GP_GLARE_SPLAT_OUTLINE_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

/* Draws over the picture, in one-pixel lines of full green (0, 1, 0), the
 * rim of each polygon that splat draws with these settings: the pixels at the
 * edge of the square around P0 that its reach leaves, cut to what the kernel
 * covers there. Edges outside the frame are not seen. The single sensors of
 * GP_GROUP_CORE are no polygons.
 *
 *   picture  src->w x src->h planes, changed where there is a line
 * Takes time for polygons and pixels, not for the lines' length.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_outline(const struct gp_log *log,
                                   const struct gp_sources *src,
                                   const struct gp_kernel *kernel,
                                   const struct gp_splat_params *p,
                                   struct gp_planes *picture);

#endif
