/* Volumes of lights: where one can add light at all. */
#ifndef GP_SCENE_REACH_H
#define GP_SCENE_REACH_H

#include "scene/bounds.h"
#include "scene/frustum.h"

/* A light made ready: a ball of its range, a spot's cut by its cone; of a
 * directional one all of space. */
struct gp_reach {
    struct gp_from from;   // place, or direction to it
    double range;          // INFINITY: none
    struct gp_v3 along;    // of a spot
    double cos, sin;       // of a spot's outer half angle; sin 0: no cone
    struct gp_box box;     // around the volume; may be infinite
};

struct gp_reach gp_light_reach(const struct gp_scene_light *light);

/* True where a box (centre c, half sides e) beyond the range cannot be lit. */
static inline bool gp_reach_too_far(const struct gp_reach *r, struct gp_v3 c,
                                    struct gp_v3 e)
{
    const double x = gp_maxd(fabs(c.x - r->from.p.x) - e.x, 0.0),
                 y = gp_maxd(fabs(c.y - r->from.p.y) - e.y, 0.0),
                 z = gp_maxd(fabs(c.z - r->from.p.z) - e.z, 0.0);
    return r->from.w * (x * x + y * y + z * z) > r->range * r->range;
}

/* True where a sphere is outside a spot's cone. */
bool gp_reach_beside(const struct gp_reach *r, struct gp_v3 c, double radius);

/* False where the volume cannot meet a frustum. */
bool gp_reach_meets(const struct gp_reach *r, const struct gp_volume *v);

/* Returns the bounds of the volume on the screen, from `near` on; infinite
 * ones are cut to [near, far] and a picture of 1e9 pixels. */
struct gp_screen_box gp_reach_project(const struct gp_reach *r,
                                      const struct gp_camera *c,
                                      struct gp_rect display, double near,
                                      double far);

#endif
