/* Boxes and spheres of objects, and boxes on the screen. */
#ifndef GP_SCENE_BOUNDS_H
#define GP_SCENE_BOUNDS_H

#include "core/minmax.h"
#include "scene/scene.h"

#define GP_BOX_EMPTY                                                          \
    ((struct gp_box) {{INFINITY, INFINITY, INFINITY},                         \
                      {-INFINITY, -INFINITY, -INFINITY}})

static inline bool gp_box_empty(struct gp_box b)
{
    return !(b.lo.x <= b.hi.x && b.lo.y <= b.hi.y && b.lo.z <= b.hi.z);
}

/* Returns corner i of 8: bit 0 is x, 1 y, 2 z; set is the high side. */
static inline struct gp_v3 gp_box_corner(const struct gp_box *b, int i)
{
    return (struct gp_v3) {i & 1 ? b->hi.x : b->lo.x, i & 2 ? b->hi.y : b->lo.y,
                           i & 4 ? b->hi.z : b->lo.z};
}

/* Returns the middle of a box, and half its sides. */
static inline struct gp_v3 gp_box_middle(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_add(b->lo, b->hi), 0.5);
}

static inline struct gp_v3 gp_box_half(const struct gp_box *b)
{
    return gp_v3_scale(gp_v3_sub(b->hi, b->lo), 0.5);
}

/* Returns the smallest box that holds b and p. */
static inline struct gp_box gp_box_with(struct gp_box b, struct gp_v3 p)
{
    return (struct gp_box) {
        {gp_mind(p.x, b.lo.x), gp_mind(p.y, b.lo.y), gp_mind(p.z, b.lo.z)},
        {gp_maxd(p.x, b.hi.x), gp_maxd(p.y, b.hi.y), gp_maxd(p.z, b.hi.z)},
    };
}

/* Returns the smallest box that holds a and b, of which either may be empty. */
static inline struct gp_box gp_box_join(struct gp_box a, struct gp_box b)
{
    return (struct gp_box) {
        {gp_mind(a.lo.x, b.lo.x), gp_mind(a.lo.y, b.lo.y),
         gp_mind(a.lo.z, b.lo.z)},
        {gp_maxd(a.hi.x, b.hi.x), gp_maxd(a.hi.y, b.hi.y),
         gp_maxd(a.hi.z, b.hi.z)},
    };
}

/* Returns p' = p * m for an affine matrix of row vectors. */
static inline struct gp_v3 gp_move(const double m[16], struct gp_v3 p)
{
    return (struct gp_v3) {
        p.x * m[0] + p.y * m[4] + p.z * m[8] + m[12],
        p.x * m[1] + p.y * m[5] + p.z * m[9] + m[13],
        p.x * m[2] + p.y * m[6] + p.z * m[10] + m[14],
    };
}

/* Returns vertex v of the scene, in its mesh's space. */
static inline struct gp_v3 gp_scene_vertex(const struct gp_scene *s, uint32_t v)
{
    const float *const p = &s->position[3 * (size_t) v];
    return (struct gp_v3) {(double) p[0], (double) p[1], (double) p[2]};
}

/* Sets box, centre and radius of an object from to_world and each vertex of
 * its mesh that a triangle uses; of a mesh with over 4096 indices from the
 * corners of its box, as scenes are posed anew for every frame. Without a vertex
 * the box is empty, and so is the sphere: centre 0, radius 0. */
void gp_bounds_set(const struct gp_scene *s, struct gp_object *o);

/* Returns the radius of a sphere around an object that is centred on c, the
 * middle of its box. */
double gp_object_radius(const struct gp_object *o, struct gp_v3 c);

/* A box of the world in the picture. */
struct gp_screen_box {
    double x0, y0, x1, y1; // EXR pixel space, not cut by the picture
    double near, far;      // along the view axis, units of the world
    bool seen;             // a part is at `near` or beyond; else the rest is 0
};

/* Returns the bounds of the part of a box at least `near` > 0 along the view
 * axis. They hold every point of it, but for rounding. */
struct gp_screen_box gp_bounds_project(const struct gp_camera *c,
                                       struct gp_rect display,
                                       const struct gp_box *box, double near);

/* The same of a sphere: tight where all of it is beyond `near`, else those of
 * the box around it. */
struct gp_screen_box gp_bounds_project_sphere(
    const struct gp_camera *c, struct gp_rect display, struct gp_v3 centre,
    double radius, double near);

#endif
