/* Boxes in a tree, four to a node, and the walk of a ray through them.
 *
 * Bounds are floats; a ray's way through them is found in float from where it
 * enters the tree. All are grown by 2^-20 of the largest coordinate, which is
 * more than every rounding of the walk: no box that a ray in double meets is
 * missed. */
#ifndef GP_SCENE_TREE_H
#define GP_SCENE_TREE_H

#include "core/status.h"
#include "scene/scene.h"

enum {
    GP_TREE_LEAF = 4,    // items of a leaf, at most
    GP_TREE_DEEP = 256,  // nodes that wait in a walk, at most
};

/* Bounds of an item; empty where lo > hi. */
struct gp_tree_box {
    float lo[3], hi[3];
};

typedef float gp_four __attribute__((vector_size(16)));
typedef int gp_four_int __attribute__((vector_size(16)));

/* Four boxes; one that is not used is empty, and no ray meets it. */
struct gp_tree_node {
    gp_four bound[6];       // lo.x, lo.y, lo.z, hi.x, hi.y, hi.z
    int first[4], count[4]; // items of a leaf; count 0: `first` is a node
};

struct gp_tree {
    struct gp_tree_node *node; // owned; [0] is the root
    int *item;                 // owned; of leaves: indices of boxes
    int n;                     // items
    struct gp_box box;         // of all
};

/* Makes the tree of n boxes: splits by the least sum of surfaces times items
 * (MacDonald and Booth 1990) over 12 bins an axis (Wald 2007), 48 levels deep
 * at most, in the middle below.
 *   out  zero; freed by gp_tree_free() in any case
 * Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_tree_make(const struct gp_log *log,
                                     const struct gp_tree_box *box, int n,
                                     struct gp_tree *out);
void gp_tree_free(struct gp_tree *t);

/* Returns the box in floats that holds another. */
struct gp_tree_box gp_tree_box_of(const struct gp_box *b);

/* A ray in a tree: lengths are those of the largest component of `along`, from
 * where it enters. */
struct gp_tree_ray {
    gp_four from[3], per[3]; // each the same four times; per: 1 / along
    int near[3], far[3];     // bounds that it meets first and last
    double start, scale;     // lengths of `along` are start + at / scale
};

/* Sets a ray; false where it misses the tree within `most`. */
bool gp_tree_enter(const struct gp_tree *t, struct gp_v3 from,
                   struct gp_v3 along, double most, struct gp_tree_ray *out);

/* Returns a length of `along` in the ray's, not too small. */
static inline float gp_tree_most(const struct gp_tree_ray *r, double most)
{
    const double length = (most - r->start) * r->scale * (1.0 + 1e-6);
    return length < 1e38 ? (float) length : 1e38f;
}

/* Tests the items [first, first + n) of a leaf. Returns where the first stops
 * the ray, or `most`; -1 ends the walk. */
typedef double (*gp_tree_leaf)(void *user, int first, int n, double most);

static inline gp_four gp_four_max(gp_four a, gp_four b)
{
    const gp_four_int more = a > b;
    return (gp_four) ((more & (gp_four_int) a) | (~more & (gp_four_int) b));
}

static inline gp_four gp_four_min(gp_four a, gp_four b)
{
    const gp_four_int less = a < b;
    return (gp_four) ((less & (gp_four_int) a) | (~less & (gp_four_int) b));
}

/* Walks a ray through the boxes that it meets before `most` lengths of `along`,
 * near ones first. Returns what the leaves leave of `most`. */
static inline double gp_tree_walk(const struct gp_tree *t, struct gp_v3 from,
                                  struct gp_v3 along, double most,
                                  gp_tree_leaf leaf, void *user)
{
    struct {
        float at;
        int first, count;
    } wait[GP_TREE_DEEP];
    struct gp_tree_ray ray;
    int n = 0;
    if (!gp_tree_enter(t, from, along, most, &ray))
        return most;
    float far_end = gp_tree_most(&ray, most);
    wait[n].at = 0.0f;
    wait[n].first = wait[n].count = 0;
    n++;
    while (n > 0) {
        n--;
        if (wait[n].at > far_end)
            continue;
        if (wait[n].count > 0) {
            most = leaf(user, wait[n].first, wait[n].count, most);
            if (most < 0.0)
                return most;
            far_end = gp_tree_most(&ray, most);
            continue;
        }
        const struct gp_tree_node *const node = &t->node[wait[n].first];
        gp_four near = (node->bound[ray.near[0]] - ray.from[0]) * ray.per[0];
        gp_four far = (node->bound[ray.far[0]] - ray.from[0]) * ray.per[0];
        for (int axis = 1; axis < 3; axis++) {
            near = gp_four_max(near, (node->bound[ray.near[axis]] -
                                      ray.from[axis]) * ray.per[axis]);
            far = gp_four_min(far, (node->bound[ray.far[axis]] -
                                    ray.from[axis]) * ray.per[axis]);
        }
        near = gp_four_max(near, (gp_four) {0.0f, 0.0f, 0.0f, 0.0f});
        const int from_here = n;
        for (int k = 0; k < 4; k++) {
            if (!(near[k] <= far[k]) || near[k] > far_end)
                continue;
            int i = n++; // the nearest is the last
            for (; i > from_here && wait[i - 1].at < near[k]; i--)
                wait[i] = wait[i - 1];
            wait[i].at = near[k];
            wait[i].first = node->first[k];
            wait[i].count = node->count[k];
        }
    }
    return most;
}

#endif
