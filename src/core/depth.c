// SPDX-License-Identifier: Apache-2.0
/* Depth samples for io, which fills empty pixels, and for sun, which compares
 * surfaces with lights. */
#include "core/depth.h"

#include <float.h>
#include <math.h>

struct gp_depth_range gp_depth_range_of(enum glarepp_depth type, bool reversed)
{
    const float least = FLT_TRUE_MIN, half = GP_DEPTH_HALF;
    const float deepest = nextafterf(GP_DEPTH_HUGE, 0.0f);
    const struct gp_depth_range inverse = {
        nextafterf(1.0f / GP_DEPTH_HUGE, 1.0f), INFINITY, NAN};
    // normalized, near is 1, and near is 0
    const struct gp_depth_range turned = {least, INFINITY, NAN};
    const struct gp_depth_range share = {-INFINITY, nextafterf(1.0f, 0.0f),
                                         NAN};
    switch (type) {
    case GLAREPP_INVERSE:
        return inverse;
    case GLAREPP_NORMALIZED:
        return reversed ? turned : share;
    case GLAREPP_Z:
    case GLAREPP_RAY:
        break;
    }
    return reversed ? (struct gp_depth_range) {-deepest, -least, -half}
                    : (struct gp_depth_range) {least, deepest, half};
}

double gp_surface_place(enum glarepp_depth type, bool reversed, float v)
{
    const double d = (double) v;
    switch (type) {
    case GLAREPP_INVERSE:
        return 1.0 / d;
    case GLAREPP_NORMALIZED:
        return fmax(reversed ? 1.0 - d : d, 0.0);
    case GLAREPP_Z:
    case GLAREPP_RAY:
        break;
    }
    return reversed ? -d : d;
}

float gp_empty_depth(enum glarepp_depth type, const float *v, size_t n)
{
    enum { ZERO, FAR, HALF, INFINITE, NONE, KINDS };
    size_t count[KINDS] = {0}, negative = 0, one = 0;
    float value[KINDS] = {0.0f, 0.0f, 0.0f, 0.0f, NAN};
    float least = INFINITY, largest = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        const float a = fabsf(v[i]);
        const int kind = isnan(v[i]) ? NONE : isinf(a) ? INFINITE
                         : a == 0.0f ? ZERO : a >= GP_DEPTH_HUGE ? FAR
                         : a == GP_DEPTH_HALF ? HALF : KINDS;
        one += v[i] >= 1.0f;
        if (kind < KINDS) {
            count[kind]++;
            value[kind] = kind == NONE || (kind == FAR && fabsf(value[FAR]) > a)
                              ? value[kind] : v[i];
            continue;
        }
        negative += v[i] < 0.0f;
        least = fminf(least, v[i]);
        largest = fmaxf(largest, v[i]);
    }
    if (type == GLAREPP_INVERSE)
        return 0.0f;
    if (type == GLAREPP_NORMALIZED)
        return one || !count[ZERO] ? 1.0f : 0.0f;
    int most = ZERO;
    for (int k = 1; k < KINDS; k++)
        most = count[k] > count[most] ? k : most;
    if (count[most])
        return value[most];
    // a camera that looks along -z has its farthest samples far below 0
    return !(least <= largest) ? 0.0f : negative && largest < 0.0f ? least
                                                                   : largest;
}
