// SPDX-License-Identifier: Apache-2.0
/* Depth samples: which are surfaces, and which mean that there is none.
 *
 * Empty, by type:
 *   z, ray      <= 0, NaN, Inf, >= 1e9 (Blender's 1e10, 1e30), 65504 (1e10 in
 *               half). Where no surface is over 0 and some would be with the
 *               other sign, the file counts backwards along the axis: its
 *               sign is turned (reversed).
 *   inverse     1 / z: <= 1e-9, NaN; +Inf is a surface at the camera
 *   normalized  0 near to 1 far: >= 1, NaN. Where no sample is >= 1 and some
 *               are 0, 0 is the background and near is 1 (reversed). */
#ifndef GP_CORE_DEPTH_H
#define GP_CORE_DEPTH_H

#include "glarepp.h"

#include <stdbool.h>
#include <stddef.h>

/* Blender's 1e10 and 1e30 are backgrounds; no scene is this deep. */
#define GP_DEPTH_HUGE 1e9f

/* The largest half: what 1e10 becomes in one. */
#define GP_DEPTH_HALF 65504.0f

/* Samples that are surfaces: [lo, hi] but `hole`. */
struct gp_depth_range {
    float lo, hi;
    float hole; // NAN: none
};
struct gp_depth_range gp_depth_range_of(enum glarepp_depth type, bool reversed);

static inline bool gp_is_surface(struct gp_depth_range s, float v)
{
    return (v >= s.lo) & (v <= s.hi) & (v != s.hole);
}

/* Returns the place of a surface's sample: distance for z, ray and inverse, 0
 * near to 1 far for normalized. */
double gp_surface_place(enum glarepp_depth type, bool reversed, float v);

/* Returns the empty value that most of a plane's n samples have, or, of z and
 * ray where none is empty, the farthest sample; of no samples 0. */
float gp_empty_depth(enum glarepp_depth type, const float *v, size_t n);

#endif
