/* Turning a kernel about its centre's pixel. */
#ifndef GP_GLARE_TURN_H
#define GP_GLARE_TURN_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/kernel.h"

#include <stdbool.h>

/* A turned kernel: every whole offset at which it can be other than 0. */
struct gp_turned {
    int w, h;
    int cx, cy;          // the centre's pixel; may lie outside
    struct gp_planes k;  // w * h each
};

/* True when the angle is a whole number of right angles; *quarters (may be
 * NULL) is that number counter-clockwise, 0 to 3. */
bool gp_turn_is_right(float degrees, int *quarters);

/* Sets u->cos and u->sin; exact for right angles. */
void gp_turn_angle(float degrees, struct gp_unturned *u);

/* Sample of channel c at the whole offset (dx, dy) from the turned kernel's
 * centre: the identity of struct gp_unturned, in double. The plain form. */
double gp_turn_sample(const struct gp_unturned *u, int c, int dx, int dy);

/* Makes the turned kernel by these samples, rounded to float; `grey` says
 * that the three planes are equal. By right angles the samples only move.
 *
 *   name  for messages
 *   out   written only on GP_OK; free its planes with gp_planes_free()
 * Errors: GP_ERR_USAGE the box that holds it has over GP_TURNED_PIXELS
 * pixels; GP_ERR_BUG out of memory. */
enum { GP_TURNED_PIXELS = 1 << 28 };
GP_MUST_CHECK gp_status gp_turn(const struct gp_log *log, const char *name,
                                const struct gp_unturned *u, bool grey,
                                struct gp_turned *out);

#endif
