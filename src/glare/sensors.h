// SPDX-License-Identifier: Apache-2.0
/* Sensors: which pixels are light, and how much. The bright pass and the
 * cleaning of bad pixels are defined here, once, for every engine. */
#ifndef GP_GLARE_SENSORS_H
#define GP_GLARE_SENSORS_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"
#include "glarepp.h"

/* Cleans f->rgb in place: NaN and -Inf become 0, +Inf the largest finite value
 * of the frame or 65504, whichever is more; finite values stay, but where a
 * channel is over max_value its pixel is scaled until the largest is that.
 * Then finds T, and lists the sources: pixels whose luminance Y, of the
 * non-negative part, is over T, with the part of the colour that the mode
 * keeps; the knee's ramp is a smoothstep, 1 when knee is 0. Light under FLT_MIN
 * then counts as 0 (gp_sources.faint).
 *
 * A warning says so when max_value takes over 1 % of a channel's light.
 *
 *   sphere  f is a lat-long: percentiles and averages are of its solid angle
 *   out     written only on GP_OK; free with gp_sources_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sense(const struct gp_log *log,
                                 const struct glarepp_sense_params *p,
                                 bool sphere, struct gp_image *f,
                                 struct gp_sources *out);

#endif
