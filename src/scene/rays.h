/* Rays through the triangles of objects, in double.
 *
 * A triangle stops a ray from either side, whatever its material says of its
 * back: renderers of frames do so. A material with a cutoff stops it where
 * base alpha times the texture's is the cutoff or more. */
#ifndef GP_SCENE_RAYS_H
#define GP_SCENE_RAYS_H

#include "scene/scene.h"

/* Triangles in a tree of boxes. */
struct gp_rays {
    const struct gp_scene *scene;     // borrowed
    struct gp_rays_triangle *triangle; // owned
    struct gp_rays_node *node;         // owned
    int n;
};

/* Selects triangles by a sphere around them. */
typedef bool (*gp_rays_keep)(const void *user, struct gp_v3 centre,
                             double radius);

/* Triangles of one tree: 60 MB. */
enum { GP_RAYS_TREE = 1 << 18 };

/* Builds the tree of the triangles of some objects, as posed: of the first
 * ones that have at most `most` triangles together, and of one at least. A few
 * nodes may place one large mesh often; a caller that visits the objects tree
 * by tree needs no memory for each of its copies.
 *   keep  NULL: takes all of them
 *   used  objects in the tree, 1 to `objects` (0 of 0)
 *   out   zero; freed by gp_rays_free() in any case
 * Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_rays_make(
    const struct gp_log *log, const struct gp_scene *s, const int *object,
    int objects, int most, gp_rays_keep keep, const void *user, int *used,
    struct gp_rays *out);
void gp_rays_free(struct gp_rays *r);

/* Returns true when a triangle is on the way from `from` along `along`, less
 * than `most` lengths of `along` away. Call from any thread. */
bool gp_rays_stopped(const struct gp_rays *r, struct gp_v3 from,
                     struct gp_v3 along, double most);

/* A triangle that a ray meets. */
struct gp_rays_hit {
    double at;           // lengths of `along` from the start
    struct gp_v3 normal; // unit, of the triangle, on either side
    int material;
};

/* Finds the first triangle on that way; false, and *out as it was, where there
 * is none. */
bool gp_rays_first(const struct gp_rays *r, struct gp_v3 from,
                   struct gp_v3 along, double most, struct gp_rays_hit *out);

#endif
