/* Lights for ghosts of a lens: those of a frame, or its brightest sources. */
#ifndef GP_SUN_LENS_LIGHTS_H
#define GP_SUN_LENS_LIGHTS_H

#include "glare/sources.h"
#include "sun/lens.h"
#include "sun/lights.h"

/* Lists the visible lights that have flux; of a frame without lights the 100
 * brightest blocks of 16 x 16 pixels with sources.
 *   out   owned by the caller, gp_free(); *n of them
 *   rest  share of the sources' luminance that has none
 *   dark  flux of these is added to it
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_lens_lights(const struct gp_log *log,
    const struct gp_light *light, int lights, const struct gp_sources *src,
    struct gp_lens_light **out, int *n, double *rest, double dark[3]);

#endif
