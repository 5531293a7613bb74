/* builtin:eye, the point-spread function of the human eye in daylight.
 *
 *   P(t) = 0.384 f0 + 0.478 f1 + 0.138 f2        t: degrees from the source
 *   f0   = 2.61e6 exp(-(t / 0.02)^2)             unscattered light
 *   f1   = 20.91 / (t + 0.02)^3                  ciliary corona
 *   f2   = 72.37 / (t + 0.02)^2                  ciliary corona, far out
 *
 * Spencer, Shirley, Zimmerman, Greenberg: Physically-Based Glare Effects for
 * Digital Images, SIGGRAPH 95, the photopic function, eq. 5, per steradian.
 * (The lenticular halo belongs to the mesopic and scotopic functions.) Each
 * f is normalised: its integral over the hemisphere is 1, to the digits of
 * its constants.
 */
#ifndef GP_GLARE_EYE_H
#define GP_GLARE_EYE_H

#include "core/frame.h"
#include "core/status.h"

/* Degrees of view that one pixel spans: 1080 lines over 30 degrees, about
 * the height that a normal lens sees (its focal length is the diagonal of
 * its film, 43 mm on 36 x 24 mm: 31 degrees). The paper takes the scene's
 * angles too, not those of the screen. Angles are taken as proportional to
 * pixels, as in the paper's section 3.2. */
#define GP_EYE_DEGREES_PER_PIXEL (1.0 / 36.0)

/* The share of a source's light that falls into the whole square of the
 * pixel `x`, `y` pixels away from it; integrated, not sampled, to about
 * 1e-10 of the value. The same to the bit for all signs and orders of x, y. */
double gp_eye_share(int x, int y);

/* Makes a size x size kernel of these shares, centre at pixel (size / 2,
 * size / 2), three equal planes, not normalised: its sum is the share of the
 * light that stays inside, 0.9548 at size 511 (tests/unit/glare/eye.c).
 * Errors: GP_ERR_BUG no memory; *k is empty then. */
GP_MUST_CHECK gp_status gp_eye_make(const struct gp_log *log, int size,
                                    struct gp_planes *k);

#endif
