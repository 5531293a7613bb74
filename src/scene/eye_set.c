/* Discs before the eye, and the objects that their cones meet. */
#include "scene/scene_priv.h"

#include "scene/bounds.h"

#include <math.h>

/* Added to angles and, as a share, to distances: rounding loses no object. */
static const double SLACK = 1e-9;

struct gp_eye_disc gp_eye_sun(struct gp_v3 eye, struct gp_v3 to, double half)
{
    return (struct gp_eye_disc) {
        .eye = eye, .to = gp_v3_unit(to),
        .half = half > 0.0 ? fmin(half, M_PI / 2.0) : 0.0, .distance = INFINITY,
    };
}

struct gp_eye_disc gp_eye_lamp(struct gp_v3 eye, struct gp_v3 at, double ball)
{
    const struct gp_v3 way = gp_v3_sub(at, eye);
    const double distance = gp_v3_length(way);
    struct gp_eye_disc d = {
        .eye = eye, .to = gp_v3_unit(way), .distance = distance,
        .ball = fmax(ball, 0.0),
    };
    if (!(distance > 0.0))
        d.to = (struct gp_v3) {0.0, 0.0, 1.0};
    d.half = d.ball < distance ? asin(d.ball / distance) : M_PI / 2.0;
    return d;
}

/* Returns the largest distance from the eye to the disc's surface. */
static double reach(const struct gp_eye_disc *d)
{
    const double square = (d->distance - d->ball) * (d->distance + d->ball);
    return !isfinite(d->distance) ? INFINITY
           : square > 0.0         ? sqrt(square) * (1.0 + SLACK)
                                  : 0.0;
}

static double angle_between(struct gp_v3 a, struct gp_v3 b)
{
    return atan2(gp_v3_length(gp_v3_cross(a, b)), gp_v3_dot(a, b));
}

bool gp_eye_meets_sphere(const struct gp_eye_disc *d, struct gp_v3 centre,
                         double radius)
{
    const struct gp_v3 c = gp_v3_sub(centre, d->eye);
    const double distance = gp_v3_length(c);
    const double r = radius + SLACK * (distance + radius);
    if (distance - r > reach(d))
        return false;
    return distance <= r ||
           angle_between(c, d->to) <= d->half + asin(r / distance) + SLACK;
}

/* Returns true when the way from the eye to the box is longer than to the
 * disc. */
static bool beyond(const struct gp_eye_disc *d, const struct gp_box *b)
{
    const double lo[3] = {b->lo.x, b->lo.y, b->lo.z};
    const double hi[3] = {b->hi.x, b->hi.y, b->hi.z};
    const double at[3] = {d->eye.x, d->eye.y, d->eye.z};
    double square = 0.0, size = 0.0;
    for (int i = 0; i < 3; i++) {
        const double gap = fmax(fmax(lo[i] - at[i], at[i] - hi[i]), 0.0);
        square += gap * gap;
        size = fmax(size, fmax(fabs(lo[i]), fabs(hi[i])));
    }
    return sqrt(square) > reach(d) + SLACK * size;
}

/* Returns true when the ray from the eye along the axis meets the box. */
static bool axis_meets(const struct gp_eye_disc *d, const struct gp_box *b)
{
    const double lo[3] = {b->lo.x, b->lo.y, b->lo.z};
    const double hi[3] = {b->hi.x, b->hi.y, b->hi.z};
    const double at[3] = {d->eye.x, d->eye.y, d->eye.z};
    const double to[3] = {d->to.x, d->to.y, d->to.z};
    double near = 0.0, far = INFINITY;
    for (int i = 0; i < 3; i++) {
        const double s = (lo[i] - at[i]) / to[i], t = (hi[i] - at[i]) / to[i];
        if (to[i] == 0.0) { // beside the slab, or within it
            far = at[i] < lo[i] || at[i] > hi[i] ? -1.0 : far;
            continue;
        }
        near = fmax(near, fmin(s, t));
        far = fmin(far, fmax(s, t));
    }
    return near <= far;
}

/* Returns the smallest angle between the axis `to` and a point of the edge
 * from p to q, both from the eye. The cosine along p + s e,
 *   (to . p + s to . e) / |p + s e|,
 * has one stationary point. */
static double edge_angle(struct gp_v3 to, struct gp_v3 p, struct gp_v3 q)
{
    const struct gp_v3 e = gp_v3_sub(q, p);
    const double a = gp_v3_dot(to, p), b = gp_v3_dot(to, e);
    const double c = gp_v3_dot(p, p), k = gp_v3_dot(p, e), f = gp_v3_dot(e, e);
    const double s = (a * k - b * c) / (b * k - a * f);
    double least = fmin(angle_between(p, to), angle_between(q, to));
    if (s > 0.0 && s < 1.0)
        least = fmin(least, angle_between(gp_v3_add(p, gp_v3_scale(e, s)), to));
    return least;
}

/* The angle from the axis has no minimum inside a face but where the axis
 * passes: the least of a box is 0 or on one of its edges. */
bool gp_eye_meets_box(const struct gp_eye_disc *d, const struct gp_box *box)
{
    if (gp_box_empty(*box) || beyond(d, box))
        return false;
    if (axis_meets(d, box))
        return true;
    for (int i = 0; i < 8; i++) {
        for (int axis = 1; axis < 8; axis *= 2) {
            if (i & axis)
                continue;
            const struct gp_v3 p = gp_v3_sub(gp_box_corner(box, i), d->eye);
            const struct gp_v3 q =
                gp_v3_sub(gp_box_corner(box, i | axis), d->eye);
            if (edge_angle(d->to, p, q) <= d->half + SLACK)
                return true;
        }
    }
    return false;
}

int gp_eye_set(const struct gp_scene *s, const struct gp_eye_disc *d,
               int *object)
{
    int n = 0;
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        if (gp_eye_meets_sphere(d, o->centre, o->radius) &&
            gp_eye_meets_box(d, &o->box))
            object[n++] = i;
    }
    return n;
}

// -- one triangle before all of it ---------------------------------------------

/* Returns true when the cone of the disc is within the three planes through the
 * eye and the triangle's edges, and the triangle is nearer than the disc. */
static bool covers(const struct gp_eye_disc *d, const struct gp_v3 p[3])
{
    const double least = sin(fmin(d->half + SLACK, M_PI / 2.0));
    const double turn = gp_v3_det(p[0], p[1], p[2]) < 0.0 ? -1.0 : 1.0;
    for (int i = 0; i < 3; i++) {
        const struct gp_v3 n = gp_v3_cross(p[i], p[(i + 1) % 3]);
        if (!(turn * gp_v3_dot(n, d->to) > least * gp_v3_length(n)) ||
            !(gp_v3_length(p[i]) < (d->distance - d->ball) * (1.0 - SLACK)))
            return false;
    }
    return true;
}

/* Returns true when a sphere holds all ways to the disc, as that of an object
 * does whose triangle hides all. */
static bool sphere_covers(const struct gp_eye_disc *d, struct gp_v3 centre,
                          double radius)
{
    const struct gp_v3 c = gp_v3_sub(centre, d->eye);
    const double distance = gp_v3_length(c);
    const double r = radius + SLACK * (distance + radius);
    return distance <= r ||
           angle_between(c, d->to) + d->half <= asin(r / distance) + SLACK;
}

bool gp_eye_hidden(const struct gp_scene *s, const struct gp_eye_disc *d,
                   const int *object, int objects)
{
    for (int i = 0; i < objects; i++) {
        const struct gp_object *const o = &s->object[object[i]];
        const struct gp_mesh *const m = &s->mesh[o->mesh];
        if (!sphere_covers(d, o->centre, o->radius))
            continue;
        for (int k = m->first; k < m->first + m->submeshes; k++) {
            const struct gp_submesh *const submesh = &s->submesh[k];
            const bool opaque = !(s->material[submesh->material].cutoff > 0.0f);
            const uint32_t *const index = s->index + submesh->first;
            for (int t = 0; opaque && t < submesh->count; t += 3) {
                struct gp_v3 p[3];
                for (int v = 0; v < 3; v++)
                    p[v] = gp_v3_sub(
                        gp_move(o->to_world, gp_scene_vertex(s, index[t + v])),
                        d->eye);
                if (covers(d, p))
                    return true;
            }
        }
    }
    return false;
}

// -- directions ---------------------------------------------------------------

bool gp_eye_inside(const struct gp_eye_measure *m, struct gp_v3 along)
{
    const struct gp_eye_window *const w = m->window;
    const double world[3] = {along.x, along.y, along.z};
    if (!w || gp_rect_empty(w->known))
        return false;
    const struct gp_projected p =
        gp_camera_project(w->camera, w->display, world, 0.0);
    return !p.behind && p.x >= w->known.x0 && p.x < w->known.x1 &&
           p.y >= w->known.y0 && p.y < w->known.y1;
}

static double along_view(const struct gp_eye_measure *m, struct gp_v3 along)
{
    const double *const c = m->window->camera->to_ndc;
    return gp_v3_dot(along, (struct gp_v3) {c[3], c[7], c[11]});
}

/* Area in the picture of a solid angle there, but for a factor: 1 / cos^3 of
 * the angle from the view axis. */
double gp_eye_weight(const struct gp_eye_measure *m, struct gp_v3 along)
{
    const double c = m->plane ? along_view(m, along) : 1.0;
    return 1.0 / (c * c * c);
}

struct gp_eye_measure gp_eye_measure_of(const struct gp_eye_disc *d,
                                        const struct gp_eye_window *window)
{
    enum { AROUND = 256 }; // directions on the edge that are looked at
    const struct gp_v3 other = fabs(d->to.z) < 0.9
                                   ? (struct gp_v3) {0.0, 0.0, 1.0}
                                   : (struct gp_v3) {1.0, 0.0, 0.0};
    struct gp_eye_measure m = {.disc = d, .window = window};
    m.across = gp_v3_unit(gp_v3_cross(d->to, other));
    m.up = gp_v3_cross(m.across, d->to);
    const bool middle = gp_eye_inside(&m, d->to);
    for (int i = 0; window && i < AROUND; i++) {
        const double turn = 2.0 * M_PI * i / AROUND;
        const struct gp_v3 side =
            gp_v3_add(gp_v3_scale(m.across, cos(turn)),
                      gp_v3_scale(m.up, sin(turn)));
        const struct gp_v3 edge =
            gp_v3_add(gp_v3_scale(d->to, cos(d->half)),
                      gp_v3_scale(side, sin(d->half)));
        m.cut = m.cut || gp_eye_inside(&m, edge) != middle;
    }
    // all of the disc is before the camera
    m.plane = m.cut && along_view(&m, d->to) > 0.0 &&
              acos(fmin(along_view(&m, d->to), 1.0)) + d->half <
                  0.999 * M_PI / 2;
    return m;
}
