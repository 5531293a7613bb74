// SPDX-License-Identifier: Apache-2.0
/* Rays through the triangles of objects, in double.
 *
 * A triangle stops a ray from either side, whatever its material says of its
 * back: renderers of frames do so. A material with a cutoff stops it where
 * base alpha times the texture's is the cutoff or more. */
#ifndef GP_SCENE_RAYS_H
#define GP_SCENE_RAYS_H

#include "scene/scene.h"

/* Trees of a scene's meshes, each in its mesh's space: one that many objects
 * place is there once. They are made when an object first needs them, and hold
 * while the scene is posed anew. Zero is none. */
struct gp_meshes {
    struct gp_mesh_tree *tree; // owned; of scene->mesh[]
    int n;
};

void gp_meshes_free(struct gp_meshes *m);

/* Boxes in a tree, four to a node. */
struct gp_tree {
    struct gp_tree_node *node; // owned; [0] is the root
    int *item;                 // owned; of leaves: indices of boxes
    int n, nodes;              // items; nodes
};

/* Objects in a tree, in their places. */
struct gp_rays {
    const struct gp_scene *scene;     // borrowed
    const struct gp_mesh_tree *mesh;  // borrowed
    struct gp_tree tree;
    struct gp_rays_place *place;      // owned
};

/* Builds the tree of some objects, as posed, and the trees of their meshes that
 * are not yet in `meshes`: 92 bytes for each triangle of these, 110 more while
 * they are built; 420 for each object.
 *   meshes  of this scene; they are there as long as `out` is used
 *   out     zero; freed by gp_rays_free() in any case */
GP_MUST_CHECK gp_status gp_rays_make(const struct gp_log *log,
                                     const struct gp_scene *s,
                                     struct gp_meshes *meshes,
                                     const int *object, int objects,
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
