/* Parts of sets, umbras and frusta for other files of the room and tests. */
#ifndef GP_SCENE_SCENE_PRIV_H
#define GP_SCENE_SCENE_PRIV_H

#include "scene/sets.h"

/* Returns the volume of the view's window from its near plane to `far`. */
struct gp_volume gp_sets_frustum(const struct gp_sets_view *v, double far);

/* Returns the hull of a light and of the visible points that it may light. */
struct gp_volume gp_sets_hull(const struct gp_sets_view *v,
                              const struct gp_scissor *lit,
                              const struct gp_reach *light);

/* Returns a distance along the view axis over that of every object. */
double gp_sets_far(const struct gp_scene *s, const struct gp_sets_view *v);

/* A sorted list of objects. */
struct gp_set {
    int *object; // owned
    int n;
};

/* The sets of a frame and of one light, as lists (15.4.3, first way). */
struct gp_lists {
    struct gp_set f, v, l, i, s;
};

/* Finds all of them. Arguments as of gp_sets_open() and gp_sets_light(); L is
 * whole. Free with gp_lists_free().
 * Errors: GP_ERR_BUG memory is full; *out is empty. */
GP_MUST_CHECK gp_status gp_lists_make(const struct gp_log *log,
                                      const struct gp_scene *s,
                                      const struct gp_bodies *bodies,
                                      const struct gp_sets_view *v,
                                      unsigned use, int light,
                                      struct gp_lists *out);
void gp_lists_free(struct gp_lists *a);

/* An edge from one corner to the other. Seen from outside plane `with` it is in
 * counter-clockwise order, outside `against` clockwise; gp_frustum.turn -1 swaps
 * them. */
struct gp_frustum_edge {
    unsigned char from, to, with, against;
};
extern const struct gp_frustum_edge gp_frustum_edges[12];

/* Finds the body of a mesh: of all of its triangles at once, in any winding.
 * False where they make none: not convex, open but not flat, cut out or
 * transparent, over 64 points or faces. Triangles without area do not count. */
bool gp_body_find(const struct gp_scene *s, int mesh, struct gp_body *out);

/* Makes the umbra of a body moved by `to_world` before a light. It is empty
 * where the light is in the body or in the plane of a flat one. */
void gp_umbra_make(const struct gp_body *body, const double to_world[16],
                   struct gp_from light, struct gp_umbra *out);

/* Writes the objects of a set, GP_SET_*, in their order; returns how many.
 * `object` has room for all of the scene, or is NULL. */
int gp_sets_list(const struct gp_sets *sets, unsigned set, int *object);

/* Returns the radius of a sphere around an object that is centred on c, the
 * middle of its box. */
double gp_object_radius(const struct gp_object *o, struct gp_v3 c);

#endif
