/* Volumes of lights against boxes, spheres, frusta and the screen. */
#include "scene/reach.h"

/* Returns how far a cone of directions around `along` reaches along an axis
 * whose cosine with it is `at`: the cosine of the nearest of its directions. */
static double cone_along(double at, double cos_outer, double sin_outer)
{
    if (at >= cos_outer) // the axis is in the cone
        return 1.0;
    // cos(angle - outer), rounded up; 0 where it points away: the apex
    return fmax(0.0, at * cos_outer +
                         sqrt(fmax(0.0, 1.0 - at * at)) * sin_outer + 1e-12);
}

static double times(double share, double range)
{
    return share > 0.0 ? share * range : 0.0;
}

struct gp_reach gp_light_reach(const struct gp_scene_light *light)
{
    struct gp_reach r = {.range = light->range, .along = light->along};
    const bool cone = light->kind == GP_LIGHT_SPOT && light->outer < 1.5707963;
    r.box = (struct gp_box) {{-INFINITY, -INFINITY, -INFINITY},
                             {INFINITY, INFINITY, INFINITY}};
    if (light->kind == GP_LIGHT_DIRECTIONAL) {
        r.from = (struct gp_from) {gp_v3_scale(light->along, -1.0), 0.0};
        r.range = INFINITY;
        return r;
    }
    r.from = (struct gp_from) {light->at, 1.0};
    struct gp_v3 lo = {1.0, 1.0, 1.0}, hi = lo; // parts of the range
    if (cone) {
        const double c = r.cos = cos(light->outer);
        const double s = r.sin = sin(light->outer);
        const struct gp_v3 a = r.along;
        lo = (struct gp_v3) {cone_along(-a.x, c, s), cone_along(-a.y, c, s),
                             cone_along(-a.z, c, s)};
        hi = (struct gp_v3) {cone_along(a.x, c, s), cone_along(a.y, c, s),
                             cone_along(a.z, c, s)};
    }
    r.box.lo = gp_v3_sub(light->at, (struct gp_v3) {times(lo.x, r.range),
                                                    times(lo.y, r.range),
                                                    times(lo.z, r.range)});
    r.box.hi = gp_v3_add(light->at, (struct gp_v3) {times(hi.x, r.range),
                                                    times(hi.y, r.range),
                                                    times(hi.z, r.range)});
    return r;
}

bool gp_reach_beside(const struct gp_reach *r, struct gp_v3 c, double radius)
{
    if (r->sin == 0.0)
        return false;
    const struct gp_v3 v = gp_v3_sub(c, r->from.p);
    const double along = gp_v3_dot(v, r->along);
    const double aside = sqrt(fmax(0.0, gp_v3_dot(v, v) - along * along));
    // distance before the cone's side; never over the distance from the cone
    return r->cos * aside - r->sin * along >
           radius + 1e-9 * (fabs(along) + aside);
}

bool gp_reach_meets(const struct gp_reach *r, const struct gp_volume *v)
{
    if (r->from.w == 0.0)
        return true;
    for (int i = 0; i < v->planes; i++) {
        const struct gp_half h = v->plane[i];
        // the farthest point of ball, or cone, inwards
        const double inwards =
            r->sin == 0.0 ? 1.0
                          : cone_along(-gp_v3_dot(h.n, r->along), r->cos,
                                       r->sin);
        if (gp_half_at(h, r->from.p) - times(inwards, r->range) > v->slack)
            return false;
    }
    return true;
}

struct gp_screen_box gp_reach_project(const struct gp_reach *r,
                                      const struct gp_camera *c,
                                      struct gp_rect display, double near,
                                      double far)
{
    static const double wide = 1e9;
    struct gp_screen_box b = {-wide, -wide, wide, wide, near, far, true};
    if (!isfinite(r->range)) // also of spots: bounds of what they light do
        return b;
    b = gp_bounds_project_sphere(c, display, r->from.p, r->range, near);
    if (r->sin > 0.0 && b.seen) {
        const struct gp_screen_box cone =
            gp_bounds_project(c, display, &r->box, near);
        if (!cone.seen)
            return cone;
        b.x0 = fmax(b.x0, cone.x0);
        b.y0 = fmax(b.y0, cone.y0);
        b.x1 = fmin(b.x1, cone.x1);
        b.y1 = fmin(b.y1, cone.y1);
        b.near = fmax(b.near, cone.near);
        b.far = fmin(b.far, cone.far);
    }
    return b;
}
