/* Boxes and spheres of objects, from their vertices, and on the screen. */
#include "scene/bounds.h"

// -- of an object ------------------------------------------------------------

enum { MOST_INDICES = 4096 };

/* Returns point i of those that hold an object, in its mesh's space. */
static struct gp_v3 point_of(const struct gp_scene *s, const struct gp_mesh *m,
                             const struct gp_submesh *p, int i, bool corners)
{
    return corners ? gp_box_corner(&m->box, i)
                   : gp_scene_vertex(s, s->index[p->first + i]);
}

void gp_bounds_set(const struct gp_scene *s, struct gp_object *o)
{
    const struct gp_mesh *const m = &s->mesh[o->mesh];
    struct gp_box box = GP_BOX_EMPTY;
    struct gp_v3 c = {0.0, 0.0, 0.0};
    double most = 0.0; // squared
    int indices = 0;
    for (int k = m->first; k < m->first + m->submeshes; k++)
        indices += s->submesh[k].count;
    const bool corners = indices > MOST_INDICES;
    for (int pass = 0; pass < 2; pass++) { // the box, then the sphere
        for (int k = m->first; k < m->first + m->submeshes; k++) {
            const struct gp_submesh *const p = &s->submesh[k];
            const int n = corners ? 8 : p->count;
            for (int i = 0; i < n; i++) {
                const struct gp_v3 at =
                    gp_move(o->to_world, point_of(s, m, p, i, corners));
                const struct gp_v3 d = gp_v3_sub(at, c);
                if (pass == 0)
                    box = gp_box_with(box, at);
                else
                    most = fmax(most, gp_v3_dot(d, d));
            }
        }
        if (!gp_box_empty(box))
            c = gp_v3_scale(gp_v3_add(box.lo, box.hi), 0.5);
    }
    o->box = box;
    o->centre = c;
    o->radius = sqrt(most) * (1.0 + 1e-12); // rounding never leaves one out
}

double gp_object_radius(const struct gp_object *o, struct gp_v3 c)
{
    const double corner = gp_v3_length(gp_v3_sub(o->box.hi, c));
    return fmin(corner, o->radius + gp_v3_length(gp_v3_sub(o->centre, c)));
}

// -- on the screen -----------------------------------------------------------

/* A point before the division: x and y in units of the display window. */
struct image {
    double x, y, w;
};

static struct image image_of(const double m[16], struct gp_v3 p)
{
    return (struct image) {
        p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12],
        p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
        p.x * m[3] + p.y * m[7] + p.z * m[11] + m[15],
    };
}

static struct gp_screen_box with_image(struct gp_screen_box b, struct image p)
{
    const double x = p.x / p.w, y = p.y / p.w;
    return (struct gp_screen_box) {
        gp_mind(x, b.x0),     gp_mind(y, b.y0),
        gp_maxd(x, b.x1),     gp_maxd(y, b.y1),
        gp_mind(p.w, b.near), gp_maxd(p.w, b.far), true,
    };
}

static struct gp_screen_box to_pixels(struct gp_screen_box b,
                                      struct gp_rect display)
{
    if (!b.seen)
        return (struct gp_screen_box) {0};
    const double w = (double) display.x1 - display.x0,
                 h = (double) display.y1 - display.y0;
    b.x0 = display.x0 + b.x0 * w;
    b.x1 = display.x0 + b.x1 * w;
    b.y0 = display.y0 + b.y0 * h;
    b.y1 = display.y0 + b.y1 * h;
    return b;
}

static const struct gp_screen_box nothing = {
    INFINITY, INFINITY, -INFINITY, -INFINITY, INFINITY, -INFINITY, false,
};

struct gp_screen_box gp_bounds_project(const struct gp_camera *c,
                                       struct gp_rect display,
                                       const struct gp_box *box, double near)
{
    struct gp_screen_box b = nothing;
    struct image at[8];
    if (gp_box_empty(*box))
        return to_pixels(b, display);
    for (int i = 0; i < 8; i++) {
        at[i] = image_of(c->to_ndc, gp_box_corner(box, i));
        if (at[i].w >= near)
            b = with_image(b, at[i]);
    }
    // where an edge meets the plane at `near`, from corner i to i with bit k
    for (int e = 0; e < 24; e++) {
        const int i = e % 8, k = 1 << e / 8;
        const struct image p = at[i], q = at[i | k];
        if (i & k || (p.w < near) == (q.w < near))
            continue;
        const double t = (near - p.w) / (q.w - p.w);
        b = with_image(b, (struct image) {p.x + t * (q.x - p.x),
                                          p.y + t * (q.y - p.y), near});
    }
    return to_pixels(b, display);
}

/* Sets the two values s at which the plane x - s * w = 0 touches a sphere whose
 * centre has the image (x, w): (x - s w)^2 = r^2 |a - s v|^2, a and v the
 * gradients of x and w. */
static void touch(double x, double w, struct gp_v3 a, struct gp_v3 v, double r,
                  double *lo, double *hi)
{
    const double p = w * w - r * r * gp_v3_dot(v, v); // > 0
    const double q = x * w - r * r * gp_v3_dot(a, v);
    const double d = x * x - r * r * gp_v3_dot(a, a);
    const double root = sqrt(fmax(0.0, q * q - p * d));
    *lo = (q - root) / p;
    *hi = (q + root) / p;
}

struct gp_screen_box gp_bounds_project_sphere(const struct gp_camera *c,
                                              struct gp_rect display,
                                              struct gp_v3 centre,
                                              double radius, double near)
{
    const double *const m = c->to_ndc;
    const struct image at = image_of(m, centre);
    if (at.w - radius < near || at.w - radius < 1e-6 * at.w) {
        const struct gp_v3 r = {radius, radius, radius};
        const struct gp_box box = {gp_v3_sub(centre, r), gp_v3_add(centre, r)};
        return gp_bounds_project(c, display, &box, near);
    }
    const struct gp_v3 v = {m[3], m[7], m[11]};
    struct gp_screen_box b = {
        .near = at.w - radius, .far = at.w + radius, .seen = true};
    touch(at.x, at.w, (struct gp_v3) {m[0], m[4], m[8]}, v, radius, &b.x0,
          &b.x1);
    touch(at.y, at.w, (struct gp_v3) {m[1], m[5], m[9]}, v, radius, &b.y0,
          &b.y1);
    return to_pixels(b, display);
}
