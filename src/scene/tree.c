/* A tree of boxes, built from above. */
#include "scene/tree.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "scene/bounds.h"

#include <float.h>
#include <string.h>

enum { BINS = 12, MOST_LEVELS = 48 };
static const double GROW = 0x1p-20; // of the largest coordinate

/* Items [first, first + count), `level` splits below the root. */
struct range {
    int first, count, level;
};

struct builder {
    const struct gp_tree_box *box;
    struct gp_tree *tree;
    struct range *wait; // of each node
    int nodes;
    float grow;
};

static const struct gp_tree_box empty_box = {
    {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY},
};

static inline void join(struct gp_tree_box *a, const struct gp_tree_box *b)
{
    for (int c = 0; c < 3; c++) {
        a->lo[c] = gp_minf(a->lo[c], b->lo[c]);
        a->hi[c] = gp_maxf(a->hi[c], b->hi[c]);
    }
}

/* Returns half the surface of a box; 0 of an empty one. */
static double surface(const struct gp_tree_box *b)
{
    double side[3];
    for (int c = 0; c < 3; c++)
        side[c] = fmax((double) b->hi[c] - (double) b->lo[c], 0.0);
    return side[0] * side[1] + side[1] * side[2] + side[2] * side[0];
}

/* Returns twice the middle of a box on an axis. */
static inline double middle(const struct gp_tree_box *b, int axis)
{
    return (double) b->lo[axis] + (double) b->hi[axis];
}

/* Returns the nearest float that is finite. */
static inline float to_float(double v)
{
    const double most = (double) FLT_MAX;
    return (float) (v < -most ? -most : v > most ? most : v);
}

struct gp_tree_box gp_tree_box_of(const struct gp_box *b)
{
    const double lo[3] = {b->lo.x, b->lo.y, b->lo.z};
    const double hi[3] = {b->hi.x, b->hi.y, b->hi.z};
    struct gp_tree_box out;
    for (int c = 0; c < 3; c++) {
        const float l = to_float(lo[c]), h = to_float(hi[c]);
        out.lo[c] = (double) l > lo[c] ? nextafterf(l, -INFINITY) : l;
        out.hi[c] = (double) h < hi[c] ? nextafterf(h, INFINITY) : h;
    }
    return out;
}

static struct gp_tree_box box_of(const struct builder *b, struct range r)
{
    struct gp_tree_box all = empty_box;
    for (int i = r.first; i < r.first + r.count; i++)
        join(&all, &b->box[b->tree->item[i]]);
    return all;
}

// -- splitting ----------------------------------------------------------------

struct bin {
    struct gp_tree_box box;
    int n;
};

/* Items are below a split if their bin on the axis is. */
struct split {
    int axis, bin; // axis -1: none
    double low, per;
    double cost;
};

static inline int bin_of(const struct gp_tree_box *b, const struct split *s)
{
    const double at = (middle(b, s->axis) - s->low) * s->per;
    return !(at > 0.0) ? 0 : at >= BINS - 1 ? BINS - 1 : (int) at; // NaN: 0
}

/* Tries the splits of an axis between `low` and `high`, twice the middles of
 * items, and keeps the best. */
static void try_axis(const struct builder *b, struct range r, int axis,
                     double low, double high, struct split *best)
{
    struct split s = {.axis = axis, .low = low, .per = BINS / (high - low)};
    struct bin bin[BINS];
    double above[BINS] = {0};
    if (!isfinite(s.per))
        return;
    for (int i = 0; i < BINS; i++)
        bin[i] = (struct bin) {.box = empty_box};
    for (int i = r.first; i < r.first + r.count; i++) {
        const struct gp_tree_box *const box = &b->box[b->tree->item[i]];
        struct bin *const k = &bin[bin_of(box, &s)];
        join(&k->box, box);
        k->n++;
    }
    struct gp_tree_box all = empty_box;
    for (int i = BINS - 1, n = 0; i > 0; i--) {
        join(&all, &bin[i].box);
        n += bin[i].n;
        above[i] = surface(&all) * n;
    }
    all = empty_box;
    for (int i = 1, n = 0; i < BINS; i++) {
        join(&all, &bin[i - 1].box);
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
    int *const item = b->tree->item;
    struct split best = {.axis = -1, .cost = INFINITY};
    int below = r.count / 2;
    for (int axis = 0; axis < 3 && r.level < MOST_LEVELS; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (int i = r.first; i < r.first + r.count; i++) {
            const double at = middle(&b->box[item[i]], axis);
            low = fmin(low, at);
            high = fmax(high, at);
        }
        try_axis(b, r, axis, low, high, &best);
    }
    if (best.axis >= 0) {
        int i = r.first, j = r.first + r.count - 1;
        while (i <= j) {
            if (bin_of(&b->box[item[i]], &best) < best.bin) {
                i++;
                continue;
            }
            const int swap = item[i];
            item[i] = item[j];
            item[j--] = swap;
        }
        below = i - r.first;
    }
    out[0] = (struct range) {r.first, below, r.level + 1};
    out[1] = (struct range) {r.first + below, r.count - below, r.level + 1};
}

// -- nodes --------------------------------------------------------------------

/* Sets box k of a node, grown. */
static void set_bound(const struct builder *b, struct gp_tree_node *node, int k,
                      const struct gp_tree_box *box)
{
    for (int c = 0; c < 3; c++) {
        node->bound[c][k] = nextafterf(box->lo[c] - b->grow, -INFINITY);
        node->bound[3 + c][k] = nextafterf(box->hi[c] + b->grow, INFINITY);
    }
}

/* Makes node i of its range: splits the largest range until there are four.
 * Each range that is no leaf becomes a node. A node of five items or more has
 * three for each node at most: there are at most n / 3 + 1. */
static void make_node(struct builder *b, int i)
{
    struct gp_tree_node *const node = &b->tree->node[i];
    struct range of[4] = {b->wait[i]};
    int ranges = 1;
    while (ranges < 4) {
        int most = 0;
        for (int k = 1; k < ranges; k++)
            most = of[k].count > of[most].count ? k : most;
        if (of[most].count <= GP_TREE_LEAF)
            break;
        struct range two[2];
        split_range(b, of[most], two);
        of[most] = two[0];
        of[ranges++] = two[1];
    }
    for (int k = 0; k < 4; k++) {
        struct gp_tree_box box = empty_box;
        if (k >= ranges) {
            set_bound(b, node, k, &box);
            node->first[k] = node->count[k] = 0;
            continue;
        }
        box = box_of(b, of[k]);
        set_bound(b, node, k, &box);
        node->first[k] = of[k].first;
        node->count[k] = of[k].count;
        if (of[k].count > GP_TREE_LEAF) {
            b->wait[b->nodes] = of[k];
            node->first[k] = b->nodes++;
            node->count[k] = 0;
        }
    }
}

gp_status gp_tree_make(const struct gp_log *log, const struct gp_tree_box *box,
                       int n, struct gp_tree *out)
{
    struct builder b = {.box = box, .tree = out, .nodes = 1};
    const size_t most = (size_t) n / 3 + 1;
    double size = 0.0;
    gp_status st = GP_OK;
    if (n == 0)
        return GP_OK;
    GP_TRY(gp_alloc(log, "tree of boxes", (size_t) n, sizeof *out->item,
                    &out->item));
    GP_TRY(gp_alloc(log, "tree of boxes", most, sizeof *out->node,
                    &out->node));
    GP_TRY(gp_alloc(log, "tree of boxes", most, sizeof *b.wait, &b.wait));
    for (int i = 0; i < n; i++)
        out->item[i] = i;
    b.wait[0] = (struct range) {0, n, 0};
    const struct gp_tree_box all = box_of(&b, b.wait[0]);
    for (int c = 0; c < 3; c++)
        size = fmax(size, fmax(fabs((double) all.lo[c]),
                               fabs((double) all.hi[c])));
    b.grow = (float) fmin(GROW * size, (double) FLT_MAX);
    for (int i = 0; i < b.nodes; i++)
        make_node(&b, i);
    const double grow = (double) b.grow;
    out->n = n;
    out->box = (struct gp_box) {
        {(double) all.lo[0] - grow, (double) all.lo[1] - grow,
         (double) all.lo[2] - grow},
        {(double) all.hi[0] + grow, (double) all.hi[1] + grow,
         (double) all.hi[2] + grow},
    };
out:
    gp_free(b.wait);
    return st;
}

void gp_tree_free(struct gp_tree *t)
{
    gp_free(t->node);
    gp_free(t->item);
    *t = (struct gp_tree) {0};
}

// -- rays ---------------------------------------------------------------------

bool gp_tree_enter(const struct gp_tree *t, struct gp_v3 from,
                   struct gp_v3 along, double most, struct gp_tree_ray *out)
{
    const double o[3] = {from.x, from.y, from.z};
    const double d[3] = {along.x, along.y, along.z};
    const double lo[3] = {t->box.lo.x, t->box.lo.y, t->box.lo.z};
    const double hi[3] = {t->box.hi.x, t->box.hi.y, t->box.hi.z};
    double size = 0.0, start = 0.0, end = most, per[3];
    for (int c = 0; c < 3; c++)
        size = fabs(d[c]) > size ? fabs(d[c]) : size;
    if (t->n == 0 || !(size > 0.0) || !isfinite(size))
        return false;
    for (int c = 0; c < 3; c++) {
        per[c] = 1.0 / d[c];
        const bool back = per[c] < 0.0;
        const double a = ((back ? hi[c] : lo[c]) - o[c]) * per[c];
        const double b = ((back ? lo[c] : hi[c]) - o[c]) * per[c];
        // leaves out the NaN of a ray in the slab's own plane
        start = a > start ? a : start;
        end = b < end ? b : end;
    }
    if (!(start <= end * (1.0 + 1e-12)))
        return false;
    out->start = start;
    out->scale = size;
    for (int c = 0; c < 3; c++) {
        const bool back = per[c] < 0.0;
        const double slope = fabs(per[c] * size); // at most what floats hold
        const float p = (float) (slope < 1e30 ? slope : 1e30);
        const float q = back ? -p : p, f = to_float(o[c] + d[c] * start);
        out->from[c] = (gp_four) {f, f, f, f};
        out->per[c] = (gp_four) {q, q, q, q};
        out->near[c] = back ? 3 + c : c;
        out->far[c] = back ? c : 3 + c;
    }
    return true;
}
