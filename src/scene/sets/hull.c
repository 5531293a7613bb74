/* Convex volumes: what a camera sees, its hull with a light by the counts of its
 * edges (O'Rorke 15.4.4), and what a light reaches. */
#include "scene/sets/sets_priv.h"

/* Rounding of a plane's distance, in parts of the largest coordinate. */
static const double SLACK = 1e-9;

bool gp_half_span(struct gp_v3 p, struct gp_v3 a, struct gp_v3 b,
                  struct gp_v3 inside, struct gp_half *out)
{
    const struct gp_v3 n = gp_v3_cross(a, b);
    const double length = gp_v3_length(n);
    *out = (struct gp_half) {0};
    if (!(length > 1e-9 * gp_v3_length(a) * gp_v3_length(b)))
        return false;
    out->n = gp_v3_scale(n, 1.0 / length);
    out->d = -gp_v3_dot(out->n, p);
    if (gp_half_at(*out, inside) > 0.0)
        *out = gp_half_turned(*out);
    return true;
}

bool gp_volume_misses(const struct gp_volume *v, struct gp_v3 c, struct gp_v3 e)
{
    if (c.x - e.x > v->box.hi.x + v->slack ||
        c.x + e.x < v->box.lo.x - v->slack ||
        c.y - e.y > v->box.hi.y + v->slack ||
        c.y + e.y < v->box.lo.y - v->slack ||
        c.z - e.z > v->box.hi.z + v->slack ||
        c.z + e.z < v->box.lo.z - v->slack)
        return true;
    for (int i = 0; i < v->planes; i++) {
        if (gp_half_at(v->plane[i], c) - gp_half_reach(v->plane[i], e) >
            v->slack)
            return true;
    }
    return false;
}

// -- hull with a light -------------------------------------------------------

/* Returns the box that holds b and a light; one at infinity is reached along
 * its direction. */
static struct gp_box box_with(struct gp_box b, struct gp_from light)
{
    if (light.w != 0.0)
        return gp_box_with(b, light.p);
    const struct gp_v3 to = light.p;
    b.lo.x = to.x < 0.0 ? -INFINITY : b.lo.x;
    b.lo.y = to.y < 0.0 ? -INFINITY : b.lo.y;
    b.lo.z = to.z < 0.0 ? -INFINITY : b.lo.z;
    b.hi.x = to.x > 0.0 ? INFINITY : b.hi.x;
    b.hi.y = to.y > 0.0 ? INFINITY : b.hi.y;
    b.hi.z = to.z > 0.0 ? INFINITY : b.hi.z;
    return b;
}

/* Corners of the frustum have bit 0 right, 1 low, 2 far. Plane 2 k + side is
 * that of the corners whose bit k is `side`. */
struct gp_volume gp_hull(const struct gp_sets_view *view,
                         const struct gp_scissor *part,
                         const struct gp_from *light)
{
    const struct gp_rect d = view->display, r = part->rect;
    const double w = gp_rect_w(d), h = gp_rect_h(d);
    struct gp_volume v = {.box = GP_BOX_EMPTY};
    struct gp_v3 corner[8], middle = {0.0, 0.0, 0.0};
    struct gp_half plane;
    bool out[6]; // planes that the light is outside of
    for (int i = 0; i < 8; i++) {
        corner[i] = gp_camera_point(
            &view->camera, ((i & 1 ? r.x1 : r.x0) - d.x0) / w,
            ((i & 2 ? r.y1 : r.y0) - d.y0) / h, i & 4 ? part->far : part->near);
        middle = gp_v3_add(middle, gp_v3_scale(corner[i], 0.125));
        v.box = gp_box_with(v.box, corner[i]);
        v.slack = fmax(v.slack, SLACK * gp_v3_length(corner[i]));
    }
    for (int i = 0; i < 6; i++) {
        const int k = i / 2, a = 1 << (k + 1) % 3, b = 1 << (k + 2) % 3;
        const int at = (i % 2) << k | (k < 2 ? 4 : 0); // far, if it may be
        gp_half_span(corner[at], gp_v3_sub(corner[at ^ a], corner[at]),
                     gp_v3_sub(corner[at ^ b], corner[at]), middle, &plane);
        out[i] = light && gp_half_before(plane, *light) > 0.0;
        if (!out[i])
            v.plane[v.planes++] = plane;
    }
    if (v.planes == 6) // the light is in the frustum: this is it
        return v;
    v.box = box_with(v.box, *light);
    v.slack = fmax(v.slack, light->w * SLACK * gp_v3_length(light->p));

    // an edge with a count of one is on the silhouette
    for (int i = 0; i < 12; i++) {
        const int k = i / 4, a = (k + 1) % 3, b = (k + 2) % 3;
        const int at = (i & 1) << a | (i >> 1 & 1) << b;
        if (out[2 * a + (i & 1)] == out[2 * b + (i >> 1 & 1)])
            continue;
        // (a light on the edge's line makes no plane: the hull is larger)
        if (gp_half_span(corner[at], gp_v3_sub(corner[at | 1 << k], corner[at]),
                         gp_from_to(*light, corner[at]), middle, &plane))
            v.plane[v.planes++] = plane;
    }
    return v;
}

// -- what a light reaches -----------------------------------------------------

/* Returns how far a light reaches along an axis whose cosine with its cone's is
 * `at`. */
static double reach_along(const struct gp_reach *r, double at)
{
    double share = 1.0; // the cosine of the cone's nearest direction
    if (r->sin != 0.0 && at < r->cos)
        // rounded up; 0 where it points away: the apex
        share = fmax(0.0, at * r->cos +
                     sqrt(fmax(0.0, 1.0 - at * at)) * r->sin + 1e-12);
    return share > 0.0 ? share * r->range : 0.0;
}

struct gp_reach gp_light_reach(const struct gp_scene_light *light)
{
    const bool sun = light->kind == GP_LIGHT_DIRECTIONAL;
    const struct gp_v3 a = light->along;
    struct gp_reach r = {
        .from = {sun ? gp_v3_scale(a, -1.0) : light->at, sun ? 0.0 : 1.0},
        .range = sun ? INFINITY : light->range, .along = a,
    };
    if (light->kind == GP_LIGHT_SPOT && light->outer < 1.5707963) {
        r.cos = cos(light->outer);
        r.sin = sin(light->outer);
    }
    r.box.lo = gp_v3_sub(r.from.p, (struct gp_v3) {reach_along(&r, -a.x),
                                                   reach_along(&r, -a.y),
                                                   reach_along(&r, -a.z)});
    r.box.hi = gp_v3_add(r.from.p, (struct gp_v3) {reach_along(&r, a.x),
                                                   reach_along(&r, a.y),
                                                   reach_along(&r, a.z)});
    return r;
}

bool gp_reach_misses(const struct gp_reach *r, const struct gp_object *o)
{
    const struct gp_v3 e = gp_box_half(&o->box);
    const struct gp_v3 v = gp_v3_sub(gp_box_middle(&o->box), r->from.p);
    const double x = gp_maxd(fabs(v.x) - e.x, 0.0),
                 y = gp_maxd(fabs(v.y) - e.y, 0.0),
                 z = gp_maxd(fabs(v.z) - e.z, 0.0);
    if (r->from.w * (x * x + y * y + z * z) > r->range * r->range)
        return true;
    const double along = gp_v3_dot(v, r->along);
    const double aside = sqrt(fmax(0.0, gp_v3_dot(v, v) - along * along));
    // distance before the cone's side; never over the distance from the cone
    return r->sin != 0.0 && r->cos * aside - r->sin * along >
                                o->radius + 1e-9 * (fabs(along) + aside);
}

bool gp_reach_meets(const struct gp_reach *r, const struct gp_volume *v)
{
    for (int i = 0; i < v->planes && r->from.w != 0.0; i++) {
        const struct gp_half h = v->plane[i];
        // the farthest point of ball, or cone, inwards
        if (gp_half_at(h, r->from.p) -
                reach_along(r, -gp_v3_dot(h.n, r->along)) > v->slack)
            return false;
    }
    return true;
}
