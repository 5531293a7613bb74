// SPDX-License-Identifier: Apache-2.0
/* Vectors of space, in double. */
#ifndef GP_CORE_VECTOR_H
#define GP_CORE_VECTOR_H

#include <math.h>

struct gp_v3 {
    double x, y, z;
};

static inline struct gp_v3 gp_v3_add(struct gp_v3 a, struct gp_v3 b)
{
    return (struct gp_v3) {a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline struct gp_v3 gp_v3_sub(struct gp_v3 a, struct gp_v3 b)
{
    return (struct gp_v3) {a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline struct gp_v3 gp_v3_scale(struct gp_v3 a, double s)
{
    return (struct gp_v3) {a.x * s, a.y * s, a.z * s};
}

static inline double gp_v3_dot(struct gp_v3 a, struct gp_v3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline struct gp_v3 gp_v3_cross(struct gp_v3 a, struct gp_v3 b)
{
    return (struct gp_v3) {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z,
                           a.x * b.y - a.y * b.x};
}

static inline double gp_v3_length(struct gp_v3 a)
{
    return sqrt(gp_v3_dot(a, a));
}

/* Returns a with length 1; one of length 0 stays. */
static inline struct gp_v3 gp_v3_unit(struct gp_v3 a)
{
    const double length = gp_v3_length(a);
    return length > 0.0 ? gp_v3_scale(a, 1.0 / length) : a;
}

/* Returns the volume that three vectors span, signed. */
static inline double gp_v3_det(struct gp_v3 a, struct gp_v3 b, struct gp_v3 c)
{
    return gp_v3_dot(a, gp_v3_cross(b, c));
}

#endif
