/* The frustum of a camera, and its convex hull with a light by the counts of its
 * edges. */
#include "scene/frustum.h"

#include "scene/bounds.h"
#include "scene/scene_priv.h"

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
        if (gp_half_misses(v->plane[i], c, e, v->slack))
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
