/* Convex volumes: what a camera sees, its hull with a light by the counts of its
 * edges (O'Rorke 15.4.4), and what a light reaches. */
#include "scene/sets/sets_priv.h"

/* Corners 0 to 3 are the near ones, 4 to 7 the far ones:
 *
 *     0---1    4---5      planes: 0 left, 1 right, 2 upper, 3 lower,
 *     |   |    |   |              4 near, 5 far
 *     2---3    6---7
 *
 * as the camera sees them, which is outside the near plane. */
const struct gp_frustum_edge gp_frustum_edges[12] = {
    {1, 0, 4, 2}, {0, 2, 4, 0}, {2, 3, 4, 3}, {3, 1, 4, 1},
    {4, 5, 5, 2}, {6, 4, 5, 0}, {7, 6, 5, 3}, {5, 7, 5, 1},
    {0, 4, 0, 2}, {5, 1, 1, 2}, {6, 2, 0, 3}, {3, 7, 1, 3},
};

/* Rounding of a plane's distance, in parts of the largest coordinate. */
static const double SLACK = 1e-9;

/* Returns s * (p . column k - at * p . w) <= 0, normalised. */
static struct gp_half side(const struct gp_camera *c, int k, double at,
                           double s)
{
    const double *const m = c->to_ndc;
    const struct gp_v3 n = gp_v3_scale(
        gp_v3_sub(gp_column(m, k), gp_v3_scale(gp_column(m, 3), at)), s);
    const double length = gp_v3_length(n);
    return (struct gp_half) {gp_v3_scale(n, 1.0 / length),
                             s * (m[12 + k] - at * m[15]) / length};
}

struct gp_frustum gp_frustum_make(const struct gp_camera *c,
                                  struct gp_rect display, const double x[2],
                                  const double y[2], double near, double far)
{
    const double *const m = c->to_ndc;
    const double w = (double) display.x1 - display.x0,
                 h = (double) display.y1 - display.y0;
    const double u[2] = {(x[0] - display.x0) / w, (x[1] - display.x0) / w};
    const double v[2] = {(y[0] - display.y0) / h, (y[1] - display.y0) / h};
    const struct gp_v3 axis = gp_column(m, 3); // of length 1
    struct gp_frustum f = {
        .plane = {side(c, 0, u[0], -1.0), side(c, 0, u[1], 1.0),
                  side(c, 1, v[0], -1.0), side(c, 1, v[1], 1.0),
                  {gp_v3_scale(axis, -1.0), near - m[15]},
                  {axis, m[15] - far}},
    };
    for (int i = 0; i < 8; i++) {
        const double z = i & 4 ? far : near;
        f.corner[i] = gp_camera_point(c, u[i & 1], v[i >> 1 & 1], z);
    }
    // x right and y down in the picture, and the view axis
    const double det = gp_v3_det(gp_column(m, 0), gp_column(m, 1), axis);
    f.turn = det > 0.0 ? 1.0 : -1.0;
    return f;
}

struct gp_volume gp_frustum_volume(const struct gp_frustum *f)
{
    struct gp_volume v = {.planes = 6, .box = GP_BOX_EMPTY};
    for (int i = 0; i < 6; i++)
        v.plane[i] = f->plane[i];
    double most = 0.0;
    for (int i = 0; i < 8; i++) {
        v.box = gp_box_with(v.box, f->corner[i]);
        most = fmax(most, gp_v3_length(f->corner[i]));
    }
    v.slack = SLACK * most;
    return v;
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

/* Returns the distance of a light before a plane; of one at infinity the
 * cosine. Over 0 is outside. */
static double before(struct gp_half h, struct gp_from light)
{
    return gp_v3_dot(h.n, light.p) + light.w * h.d;
}

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

struct gp_volume gp_hull(const struct gp_frustum *f, struct gp_from light)
{
    struct gp_volume v = gp_frustum_volume(f);
    bool out[6]; // planes that the light is outside of
    v.planes = 0;
    for (int i = 0; i < 6; i++) {
        out[i] = before(f->plane[i], light) > 0.0;
        if (!out[i])
            v.plane[v.planes++] = f->plane[i];
    }
    if (v.planes == 6) // the light is in the frustum: this is it
        return v;
    v.box = box_with(v.box, light);
    v.slack = fmax(v.slack, light.w * 1e-9 * gp_v3_length(light.p));

    // an edge with a count of one is on the silhouette
    for (int i = 0; i < 12; i++) {
        const struct gp_frustum_edge e = gp_frustum_edges[i];
        if (out[e.with] == out[e.against])
            continue;
        // in the order of the plane that the light is outside of
        const double wind = out[e.with] ? f->turn : -f->turn;
        const struct gp_v3 a = f->corner[e.from],
                           along = gp_v3_sub(f->corner[e.to], a);
        const struct gp_v3 to =
            gp_v3_sub(light.p, gp_v3_scale(a, light.w));
        const struct gp_v3 n = gp_v3_scale(gp_v3_cross(along, to), wind);
        const double length = gp_v3_length(n);
        // (a light on the edge's line makes no plane: the hull is larger)
        if (length <= 1e-9 * gp_v3_length(along) * gp_v3_length(to))
            continue;
        const struct gp_v3 unit = gp_v3_scale(n, 1.0 / length);
        v.plane[v.planes++] = (struct gp_half) {unit, -gp_v3_dot(unit, a)};
    }
    return v;
}

// -- what a light reaches -----------------------------------------------------

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

bool gp_reach_too_far(const struct gp_reach *r, struct gp_v3 c, struct gp_v3 e)
{
    const double x = gp_maxd(fabs(c.x - r->from.p.x) - e.x, 0.0),
                 y = gp_maxd(fabs(c.y - r->from.p.y) - e.y, 0.0),
                 z = gp_maxd(fabs(c.z - r->from.p.z) - e.z, 0.0);
    return r->from.w * (x * x + y * y + z * z) > r->range * r->range;
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
