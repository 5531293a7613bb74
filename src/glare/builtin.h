/* Builtin kernels besides the eye: what lenses do to a point of light.
 *
 * Each is a formula of dx, dy, pixels from the centre's pixel, and of
 * R = size / 2 (255.5 for 511 pixels), sampled at pixel centres. All are
 * >= 0 and fade to nothing at the rim by gp_builtin_fade().
 */
#ifndef GP_GLARE_BUILTIN_H
#define GP_GLARE_BUILTIN_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/kernel.h"

/* The builtin kernel of that name, with or without "builtin:", or NULL. */
const struct gp_builtin_kernel *gp_builtin_find(const char *name);

/* Fails with GP_ERR_USAGE and the names that there are. */
GP_MUST_CHECK gp_status gp_builtin_unknown(const struct gp_log *log,
                                           const char *name);

/* A builtin kernel has to end somewhere, and where it ends at once a square
 * shows around every lamp at night: from half the radius on it fades to 0 at
 * the edge, by a smoothstep of the distance from the centre. Kernels under 65
 * pixels have no room for that and stay as they are. */
void gp_builtin_fade(int size, struct gp_planes *k);

#endif
