/* Which depth samples are surfaces: what occluder and survey share. */
#ifndef GP_SUN_SURFACES_H
#define GP_SUN_SURFACES_H

#include "sun/occluder.h"

#include <stdint.h>
#include <string.h>

/* Blender's 1e10 and 1e30 are backgrounds; no scene is this deep. */
#define GP_DEPTH_HUGE 1e9f

/* The largest half: what 1e10 becomes in one. */
#define GP_DEPTH_HALF 65504.0f

/* Samples that are surfaces: [lo, hi] but `hole`. */
struct gp_surfaces {
    float lo, hi;
    float hole;     // NAN: none
    bool near_high; // the nearest is hi
};
struct gp_surfaces gp_surfaces_of(enum gp_depth_type type, bool reversed);

static inline bool gp_is_surface(struct gp_surfaces s, float v)
{
    return (v >= s.lo) & (v <= s.hi) & (v != s.hole);
}

/* Floats in order as whole numbers, and back; -0 and 0 are one. */
static inline int32_t gp_float_order(float v)
{
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits < 0 ? INT32_MIN - bits : bits;
}

static inline float gp_float_of(int32_t k)
{
    const int32_t bits = k < 0 ? INT32_MIN - k : k;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

#endif
