/* Boxes in a tree, four to a node, and the walk of a ray through them. */
#ifndef GP_SCENE_TREE_H
#define GP_SCENE_TREE_H

#include "core/status.h"
#include "scene/scene.h"

enum { GP_TREE_DEEP = 256 }; // nodes and leaves that wait in a walk, at most

typedef float gp_four __attribute__((vector_size(16)));
typedef int gp_four_bits __attribute__((vector_size(16)));

/* Four boxes, rounded to hold what they are of. */
struct gp_tree_node {
    gp_four bound[6]; // lo.x, lo.y, lo.z, hi.x, hi.y, hi.z
    int first[4];     // item of a leaf, or a node
    int count[4];     // items of a leaf; -1: a node; 0: nothing
};

struct gp_tree {
    struct gp_tree_node *node; // owned; [0] is the root
    int *item;                 // owned; of leaves: indices of boxes
    int n, nodes;              // items; nodes
};

/* Makes the tree of n boxes: splits by the least sum of surfaces times items
 * (MacDonald and Booth 1990) over 12 bins an axis (Wald 2007), 48 levels deep
 * at most, in the middle below.
 *   out  zero; freed by gp_tree_free() in any case
 * Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_tree_make(const struct gp_log *log,
                                     const struct gp_box *box, int n,
                                     struct gp_tree *out);
void gp_tree_free(struct gp_tree *t);

/* Tests an item. Returns where it stops the ray, or `most`; -1 ends the walk. */
typedef double (*gp_tree_meet)(void *user, int item, double most);

/* Walks a ray through the boxes that it meets before `most` lengths of `along`,
 * near ones first. Returns what the items leave of `most`. */
__attribute__((always_inline))
static inline double gp_tree_walk(const struct gp_tree *t, struct gp_v3 from,
                                  struct gp_v3 along, double most,
                                  gp_tree_meet meet, void *user)
{
    // a walk in float loses no box: places are wider by their rounding, and so
    // are lengths
    static const double PLACE = 0x1p-22;
    static const float LESS = 1.0f - 1e-6f, MORE = 1.0f + 1e-6f;
    const double o[3] = {from.x, from.y, from.z};
    const double d[3] = {along.x, along.y, along.z};
    gp_four enter[3], leave[3], per[3];
    int near[3], far[3], n = 1; // bounds that it meets first and last
    struct {
        float at;
        int first, count;
    } wait[GP_TREE_DEEP];
    for (int c = 0; c < 3; c++) {
        const double q = 1.0 / d[c];
        const double wide = copysign(PLACE * fabs(o[c]), q);
        const float a = (float) (o[c] + wide), b = (float) (o[c] - wide);
        const float p = (float) q;
        enter[c] = (gp_four) {a, a, a, a};
        leave[c] = (gp_four) {b, b, b, b};
        per[c] = (gp_four) {p, p, p, p};
        near[c] = q < 0.0 ? 3 + c : c;
        far[c] = q < 0.0 ? c : 3 + c;
    }
    wait[0].at = 0.0f;
    wait[0].first = 0;
    wait[0].count = -1;
    while (t->n > 0 && n > 0) {
        n--;
        if ((double) wait[n].at > most)
            continue;
        const int first = wait[n].first, count = wait[n].count;
        for (int i = first; i < first + count && most >= 0.0; i++)
            most = meet(user, t->item[i], most);
        if (most < 0.0)
            return most;
        if (count > 0)
            continue;
        const struct gp_tree_node *const node = &t->node[first];
        gp_four in = {0.0f, 0.0f, 0.0f, 0.0f};
        const float end = most < 1e38 ? (float) most : INFINITY;
        gp_four out = {end, end, end, end};
        for (int c = 0; c < 3; c++) {
            const gp_four a = (node->bound[near[c]] - enter[c]) * per[c];
            const gp_four b = (node->bound[far[c]] - leave[c]) * per[c];
            // NaN, of a ray in the plane of a bound, is neither
            const gp_four_bits later = a > in, sooner = b < out;
            in = (gp_four) ((later & (gp_four_bits) a) |
                            (~later & (gp_four_bits) in));
            out = (gp_four) ((sooner & (gp_four_bits) b) |
                             (~sooner & (gp_four_bits) out));
        }
        const int from_here = n;
        in *= LESS;
        const gp_four_bits meets = in <= out * MORE;
        for (int k = 0; k < 4; k++) {
            if (!meets[k] || node->count[k] == 0)
                continue;
            int i = n++; // the nearest is the last
            for (; i > from_here && wait[i - 1].at < in[k]; i--)
                wait[i] = wait[i - 1];
            wait[i].at = in[k];
            wait[i].first = node->first[k];
            wait[i].count = node->count[k];
        }
    }
    return most;
}

#endif
