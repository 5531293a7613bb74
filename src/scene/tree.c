/* A tree of boxes, built from above. */
#include "scene/tree.h"

#include "core/memory.h"
#include "scene/bounds.h"

enum {
    BINS = 12, MOST_LEVELS = 48,
    LEAF = 4, // items, at most
};

/* Items [first, first + count), `level` splits below the root. */
struct range {
    int first, count, level;
};

struct builder {
    const struct gp_box *box;
    struct gp_tree *tree;
};

/* Returns half the surface of a box; 0 of an empty one. */
static double surface(const struct gp_box *b)
{
    const double x = fmax(b->hi.x - b->lo.x, 0.0);
    const double y = fmax(b->hi.y - b->lo.y, 0.0);
    const double z = fmax(b->hi.z - b->lo.z, 0.0);
    return x * y + y * z + z * x;
}

/* Returns twice the middle of a box on an axis. */
static double middle(const struct gp_box *b, int axis)
{
    return axis == 0   ? b->lo.x + b->hi.x
           : axis == 1 ? b->lo.y + b->hi.y
                       : b->lo.z + b->hi.z;
}

static struct gp_box box_of(const struct builder *b, struct range r)
{
    struct gp_box all = GP_BOX_EMPTY;
    for (int i = r.first; i < r.first + r.count; i++)
        all = gp_box_join(all, b->box[b->tree->item[i]]);
    return all;
}

// -- splitting ----------------------------------------------------------------

struct bin {
    struct gp_box box;
    int n;
};

/* Items are below a split if their bin on the axis is. */
struct split {
    int axis, bin; // axis -1: none
    double low, per;
    double cost;
};

static int bin_of(const struct gp_box *b, const struct split *s)
{
    const double at = (middle(b, s->axis) - s->low) * s->per;
    return !(at > 0.0) ? 0 : at >= BINS - 1 ? BINS - 1 : (int) at; // NaN: 0
}

/* Tries the splits of an axis, and keeps the best. */
static void try_axis(const struct builder *b, struct range r, int axis,
                     struct split *best)
{
    const int *const item = b->tree->item + r.first;
    struct bin bin[BINS];
    double above[BINS] = {0}, low = INFINITY, high = -INFINITY;
    for (int i = 0; i < r.count; i++) {
        const double at = middle(&b->box[item[i]], axis);
        low = fmin(low, at);
        high = fmax(high, at);
    }
    struct split s = {.axis = axis, .low = low, .per = BINS / (high - low)};
    if (!isfinite(s.per))
        return;
    for (int i = 0; i < BINS; i++)
        bin[i] = (struct bin) {.box = GP_BOX_EMPTY};
    for (int i = 0; i < r.count; i++) {
        const struct gp_box *const box = &b->box[item[i]];
        struct bin *const k = &bin[bin_of(box, &s)];
        k->box = gp_box_join(k->box, *box);
        k->n++;
    }
    struct gp_box all = GP_BOX_EMPTY;
    for (int i = BINS - 1, n = 0; i > 0; i--) {
        all = gp_box_join(all, bin[i].box);
        n += bin[i].n;
        above[i] = surface(&all) * n;
    }
    all = GP_BOX_EMPTY;
    for (int i = 1, n = 0; i < BINS; i++) {
        all = gp_box_join(all, bin[i - 1].box);
        n += bin[i - 1].n;
        s.bin = i;
        s.cost = surface(&all) * n + above[i];
        if (n > 0 && n < r.count && s.cost < best->cost)
            *best = s;
    }
}

/* Splits a range in two, neither empty. */
static void split_range(const struct builder *b, struct range r,
                        struct range out[2])
{
    int *const item = b->tree->item + r.first;
    struct split best = {.axis = -1, .cost = INFINITY};
    int below = r.count / 2;
    for (int axis = 0; axis < 3 && r.level < MOST_LEVELS; axis++)
        try_axis(b, r, axis, &best);
    if (best.axis >= 0) {
        int j = r.count - 1;
        for (below = 0; below <= j;) {
            if (bin_of(&b->box[item[below]], &best) < best.bin) {
                below++;
                continue;
            }
            const int swap = item[below];
            item[below] = item[j];
            item[j--] = swap;
        }
    }
    out[0] = (struct range) {r.first, below, r.level + 1};
    out[1] = (struct range) {r.first + below, r.count - below, r.level + 1};
}

/* Returns a float below a number. */
static float below(double v)
{
    return nextafterf((float) v, -INFINITY);
}

/* Splits the largest part of a range until there are four, and each part that
 * is no leaf again; returns its node. A node of five items or more has three
 * for each node at most: there are at most n / 3 + 1. */
static int make_node(struct builder *b, struct range r)
{
    const int i = b->tree->nodes++;
    struct gp_tree_node *const node = &b->tree->node[i];
    struct range part[4] = {r};
    for (int parts = 1; parts < 4; parts++) {
        int most = 0;
        for (int k = 1; k < parts; k++)
            most = part[k].count > part[most].count ? k : most;
        if (part[most].count <= LEAF)
            break;
        struct range two[2];
        split_range(b, part[most], two);
        part[most] = two[0];
        part[parts] = two[1];
    }
    for (int k = 0; k < 4; k++) {
        const struct gp_box box = box_of(b, part[k]);
        const bool leaf = part[k].count <= LEAF;
        node->bound[0][k] = below(box.lo.x);
        node->bound[1][k] = below(box.lo.y);
        node->bound[2][k] = below(box.lo.z);
        node->bound[3][k] = -below(-box.hi.x);
        node->bound[4][k] = -below(-box.hi.y);
        node->bound[5][k] = -below(-box.hi.z);
        node->count[k] = leaf ? part[k].count : -1;
        node->first[k] = leaf ? part[k].first : make_node(b, part[k]);
    }
    return i;
}

gp_status gp_tree_make(const struct gp_log *log, const struct gp_box *box,
                       int n, struct gp_tree *out)
{
    struct builder b = {.box = box, .tree = out};
    gp_status st;
    GP_TRY(gp_alloc(log, "tree of boxes", (size_t) n, sizeof *out->item,
                    &out->item));
    GP_TRY(gp_alloc(log, "tree of boxes", (size_t) n / 3 + 1,
                    sizeof *out->node, &out->node));
    for (int i = 0; i < n; i++)
        out->item[i] = i;
    out->n = n;
    if (n > 0)
        make_node(&b, (struct range) {0, n, 0});
out:
    return st;
}

void gp_tree_free(struct gp_tree *t)
{
    gp_free(t->node);
    gp_free(t->item);
    *t = (struct gp_tree) {0};
}
