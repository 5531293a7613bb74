/* Shared by the two ways of finding sets. */
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

#endif
