/* Convex volumes by planes: what a camera sees, and its hull with a light. */
#ifndef GP_SCENE_FRUSTUM_H
#define GP_SCENE_FRUSTUM_H

#include "scene/scene.h"

/* A half-space: n . p + d <= 0 is inside; n is a unit vector that points out. */
struct gp_half {
    struct gp_v3 n;
    double d;
};

static inline double gp_half_at(struct gp_half h, struct gp_v3 p)
{
    return gp_v3_dot(h.n, p) + h.d;
}

/* The pixels of a rectangle between two distances along the view axis: corners
 * (bit 0 right, 1 low, 2 far) and planes (left, right, upper, lower, near,
 * far). Each pair of planes that meet has an edge. */
struct gp_frustum {
    struct gp_v3 corner[8];
    struct gp_half plane[6];
    double turn;    // 1 or, of a camera that mirrors, -1: winding of edges
};

/* The intersection of half-spaces, and a box around it; a frustum has 6, a hull
 * with a point at most 6 and one for each edge. */
struct gp_volume {
    int planes;
    struct gp_half plane[18];
    struct gp_box box; // infinite towards a directional light
    double slack;      // rounding: what misses by less still meets
};

/* A light's place for hulls and umbras: at w = 1 a point, at w = 0 the unit
 * direction to a light at infinity. */
struct gp_from {
    struct gp_v3 p;
    double w;
};

/* Returns the frustum of pixels [x0, x1] x [y0, y1] (EXR pixel space) from near
 * > 0 to far > near, units of the world along the view axis. */
struct gp_frustum gp_frustum_make(const struct gp_camera *c,
                                  struct gp_rect display, const double x[2],
                                  const double y[2], double near, double far);

struct gp_volume gp_frustum_volume(const struct gp_frustum *f);

/* Returns the convex hull of a frustum and a light: the frustum itself where
 * the light is inside, else the planes that have the light inside and one
 * through the light for each edge of the silhouette.
 * Source: O'Rorke, GPU Gems 15.4.4; Everitt and Kilgard 2003. */
struct gp_volume gp_hull(const struct gp_frustum *f, struct gp_from light);

/* True where a box of centre c and half sides e is outside a half-space. */
static inline bool gp_half_misses(struct gp_half h, struct gp_v3 c,
                                  struct gp_v3 e, double slack)
{
    const double reach =
        fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
    return h.n.x * c.x + h.n.y * c.y + h.n.z * c.z + h.d - reach > slack;
}

#endif
