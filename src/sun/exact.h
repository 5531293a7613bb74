/* How much of a light shows: by the area of each pixel under its disc. */
#ifndef GP_SUN_EXACT_H
#define GP_SUN_EXACT_H

#include "core/status.h"
#include "sun/light.h"
#include "sun/occluder.h"

/* Area of the disc of radius r around (cx, cy) within [x, x+1) x [y, y+1), in
 * closed form; 0 to 1. Exact to 1e-12 for r up to 1e5. */
double gp_disc_pixel_area(double cx, double cy, double r, int x, int y);

/* visibility = sum(area * shown) / sum(area), both over the pixels of
 * o->frame, and the area outside of it as `outside` says; in double. A light
 * of radius 0 (or under 1e-3) counts as one of radius 1e-3, one over 1e9 as
 * 1e9; one behind the camera has 0. All hidden is exactly 0, all clear exactly
 * 1. Rows are summed in order: the same bits for any threads.
 * Time grows with the disc's area inside the planes' windows; what of the
 * frame is outside of them is clear, and costs one closed form.
 * Cannot fail. */
GP_MUST_CHECK gp_status gp_sun_exact(const struct gp_log *log,
                                     const struct gp_occluders *o,
                                     enum gp_sun_outside outside,
                                     struct gp_light *light, int n);

#endif
