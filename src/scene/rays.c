// SPDX-License-Identifier: Apache-2.0
/* A tree of boxes over triangles, and rays through it. */
#include "scene/rays.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

/* A triangle of a mesh, in its space. */
struct triangle {
    float at[9];    // three vertices
    int index;      // of its first vertex in the scene's index
    int material;
};

struct gp_mesh_tree {
    struct gp_tree tree;       // of them
    struct triangle *triangle; // owned
    bool made;
};

/* An object: a place of the world is (p - move) . in[0..2] in its mesh. */
struct gp_rays_place {
    struct gp_v3 move, in[3];
    int object;
};

// -- cutouts -----------------------------------------------------------------

/* Returns the texel of a whole coordinate, in [0, n). */
static int wrapped(double at, int n, enum gp_wrap wrap)
{
    if (wrap == GP_WRAP_CLAMP)
        return !(at > 0.0) ? 0 : at < (double) n ? (int) at : n - 1;
    const double period = wrap == GP_WRAP_MIRROR ? 2.0 * n : (double) n;
    const double turned = at - period * floor(at / period);
    // rounding may give the period itself
    const int i = turned > 0.0 && turned < period ? (int) turned : 0;
    return i < n ? i : 2 * n - 1 - i;
}

/* Returns the alpha of a code, rounded to float as a material's cutoff is: they
 * are equal where the file says so. */
static double texel(uint16_t code)
{
    return (double) ((float) code / 65535.0f);
}

/* Returns a texture's alpha at (u, v): bilinear between texel centres. */
static double alpha_at(const struct gp_cutout *c, double u, double v)
{
    // (no texture is wrapped so often that its fraction still has digits)
    const double x = (fabs(u) < 1e9 ? u : 0.0) * c->w - 0.5;
    const double y = (fabs(v) < 1e9 ? v : 0.0) * c->h - 0.5;
    const double x0 = floor(x), y0 = floor(y), fx = x - x0, fy = y - y0;
    double row[2];
    for (int i = 0; i < 2; i++) {
        const uint16_t *const p =
            c->alpha + (size_t) wrapped(y0 + i, c->h, c->wrap[1]) *
                           (size_t) c->w;
        row[i] = (1.0 - fx) * texel(p[wrapped(x0, c->w, c->wrap[0])]) +
                 fx * texel(p[wrapped(x0 + 1.0, c->w, c->wrap[0])]);
    }
    return (1.0 - fy) * row[0] + fy * row[1];
}

// -- trees -------------------------------------------------------------------

typedef float four __attribute__((vector_size(16)));
typedef int four_bits __attribute__((vector_size(16)));

/* Four boxes, rounded to hold what they are of. */
struct gp_tree_node {
    four bound[6]; // lo.x, lo.y, lo.z, hi.x, hi.y, hi.z
    int first[4];     // item of a leaf, or a node
    int count[4];     // items of a leaf; -1: a node; 0: nothing
};

enum {
    MOST_LEVELS = 48,
    LEAF = 4,   // items, at most
    DEEP = 256, // nodes and leaves that wait in a walk, at most
};

/* Items [first, first + count), `level` splits below the root. */
struct range {
    int first, count, level;
};

/* Returns twice the middle of a box on an axis. */
static double middle(const struct gp_box *b, int axis)
{
    return axis == 0   ? b->lo.x + b->hi.x
           : axis == 1 ? b->lo.y + b->hi.y
                       : b->lo.z + b->hi.z;
}

/* Splits a range in two, neither empty: at the middle of its items' middles on the
 * axis on which these are farthest apart, or in halves. */
static void split_range(const struct gp_box *box, struct gp_tree *t,
                        struct range r, struct range out[2])
{
    int *const item = t->item + r.first;
    double at = 0.0, wide = 0.0;
    int best = 0, below = 0, j = r.count - 1;
    for (int axis = 0; axis < 3 && r.level < MOST_LEVELS; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (int i = 0; i < r.count; i++) {
            low = fmin(low, middle(&box[item[i]], axis));
            high = fmax(high, middle(&box[item[i]], axis));
        }
        if (high - low > wide) {
            best = axis;
            wide = high - low;
            at = 0.5 * (low + high);
        }
    }
    while (wide > 0.0 && below <= j) {
        if (middle(&box[item[below]], best) < at) {
            below++;
            continue;
        }
        const int swap = item[below];
        item[below] = item[j];
        item[j--] = swap;
    }
    if (below == 0 || below == r.count)
        below = r.count / 2;
    out[0] = (struct range) {r.first, below, r.level + 1};
    out[1] = (struct range) {r.first + below, r.count - below, r.level + 1};
}

static float below(double v)
{
    return nextafterf((float) v, -INFINITY);
}

/* Splits the largest part of a range until there are four, and each part that
 * is no leaf again; returns its node. A node of five items or more has three
 * for each node at most: there are at most n / 3 + 1. */
// NOLINTNEXTLINE(misc-no-recursion): as deep as the tree
static int make_node(const struct gp_box *box, struct gp_tree *t,
                     struct range r)
{
    const int i = t->nodes++;
    struct gp_tree_node *const node = &t->node[i];
    struct range part[4] = {r};
    for (int parts = 1; parts < 4; parts++) {
        int most = 0;
        for (int k = 1; k < parts; k++)
            most = part[k].count > part[most].count ? k : most;
        if (part[most].count <= LEAF)
            break;
        struct range two[2];
        split_range(box, t, part[most], two);
        part[most] = two[0];
        part[parts] = two[1];
    }
    for (int k = 0; k < 4; k++) {
        struct gp_box all = GP_BOX_EMPTY;
        for (int j = part[k].first; j < part[k].first + part[k].count; j++)
            all = gp_box_join(all, box[t->item[j]]);
        const bool leaf = part[k].count <= LEAF;
        node->bound[0][k] = below(all.lo.x);
        node->bound[1][k] = below(all.lo.y);
        node->bound[2][k] = below(all.lo.z);
        node->bound[3][k] = -below(-all.hi.x);
        node->bound[4][k] = -below(-all.hi.y);
        node->bound[5][k] = -below(-all.hi.z);
        node->count[k] = leaf ? part[k].count : -1;
        node->first[k] = leaf ? part[k].first : make_node(box, t, part[k]);
    }
    return i;
}

/* Makes the tree of n boxes: splits at the middle, 48 levels deep at most, and in
 * halves below. (The least sum of surfaces times items, MacDonald and Booth 1990,
 * saves 6 to 20 % of a ray's time.) `out` is zero; free_tree() frees it in any
 * case. */
static gp_status make_tree(const struct gp_log *log, const struct gp_box *box,
                           int n, struct gp_tree *out)
{
    gp_status st;
    GP_TRY(gp_alloc(log, "tree of boxes", (size_t) n, sizeof *out->item,
                    &out->item));
    GP_TRY(gp_alloc(log, "tree of boxes", (size_t) n / 3 + 1,
                    sizeof *out->node, &out->node));
    for (int i = 0; i < n; i++)
        out->item[i] = i;
    out->n = n;
    if (n > 0)
        make_node(box, out, (struct range) {0, n, 0});
out:
    return st;
}

static void free_tree(struct gp_tree *t)
{
    gp_free(t->node);
    gp_free(t->item);
    *t = (struct gp_tree) {0};
}

/* Returns where an item stops the ray, or `most`; -1 ends the walk. */
typedef double (*meet_item)(void *user, int item, double most);

/* Walks a ray through the boxes that it meets before `most` lengths of `along`,
 * near ones first. Returns what the items leave of `most`. */
__attribute__((always_inline))
static inline double walk_tree(const struct gp_tree *t, struct gp_v3 from,
                               struct gp_v3 along, double most,
                               meet_item meet, void *user)
{
    // a walk in float loses no box: places are wider by their rounding, and so
    // are lengths
    static const double PLACE = 0x1p-22;
    static const float LESS = 1.0f - 1e-6f, MORE = 1.0f + 1e-6f;
    const double o[3] = {from.x, from.y, from.z};
    const double d[3] = {along.x, along.y, along.z};
    four enter[3], leave[3], per[3];
    int near[3], far[3], n = 1; // bounds that it meets first and last
    struct {
        float at;
        int first, count;
    } wait[DEEP];
    for (int c = 0; c < 3; c++) {
        const double q = 1.0 / d[c];
        const double wide = copysign(PLACE * fabs(o[c]), q);
        const float a = (float) (o[c] + wide), b = (float) (o[c] - wide);
        const float p = (float) q;
        enter[c] = (four) {a, a, a, a};
        leave[c] = (four) {b, b, b, b};
        per[c] = (four) {p, p, p, p};
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
        four in = {0.0f, 0.0f, 0.0f, 0.0f};
        const float end = most < 1e38 ? (float) most : INFINITY;
        four out = {end, end, end, end};
        for (int c = 0; c < 3; c++) {
            const four a = (node->bound[near[c]] - enter[c]) * per[c];
            const four b = (node->bound[far[c]] - leave[c]) * per[c];
            // NaN, of a ray in the plane of a bound, is neither
            const four_bits later = a > in, sooner = b < out;
            in = (four) ((later & (four_bits) a) |
                            (~later & (four_bits) in));
            out = (four) ((sooner & (four_bits) b) |
                             (~sooner & (four_bits) out));
        }
        const int from_here = n;
        in *= LESS;
        const four_bits meets = in <= out * MORE;
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

// -- meshes ------------------------------------------------------------------

static gp_status make_mesh(const struct gp_log *log, const struct gp_scene *s,
                           const struct gp_mesh *m, struct gp_mesh_tree *out)
{
    static const char what[] = "triangles before a light";
    const struct gp_submesh *const part = s->submesh + m->first;
    struct gp_box *box = NULL;
    size_t most = 0, n = 0;
    gp_status st;
    for (int k = 0; k < m->submeshes; k++)
        most += (size_t) part[k].count / 3;
    GP_TRY(gp_alloc(log, what, most, sizeof *box, &box));
    GP_TRY(gp_alloc(log, what, most, sizeof *out->triangle, &out->triangle));
    for (int k = 0; k < m->submeshes; k++) {
        for (int i = 0; i < part[k].count; i += 3, n++) {
            struct triangle *const t = &out->triangle[n];
            t->index = part[k].first + i;
            t->material = part[k].material;
            box[n] = GP_BOX_EMPTY;
            for (int v = 0; v < 3; v++) {
                const uint32_t at = s->index[t->index + v];
                memcpy(t->at + 3 * v, s->position + 3 * (size_t) at,
                       3 * sizeof *t->at);
                box[n] = gp_box_with(box[n], gp_scene_vertex(s, at));
            }
        }
    }
    GP_TRY(make_tree(log, box, (int) n, &out->tree));
    out->made = true;
out:
    gp_free(box);
    if (st) { // a later call makes it anew
        free_tree(&out->tree);
        GP_FREE(out->triangle);
    }
    return st;
}

void gp_meshes_free(struct gp_meshes *m)
{
    for (int i = 0; i < m->n; i++) {
        free_tree(&m->tree[i].tree);
        gp_free(m->tree[i].triangle);
    }
    gp_free(m->tree);
    *m = (struct gp_meshes) {0};
}

// -- objects -----------------------------------------------------------------

/* Sets the way from the world to an object's mesh. A flat object gets a
 * thickness of 1e-7 of its scale, so that there is a way; false of one that is
 * a line or a point, which stops no ray. */
static bool set_place(const struct gp_object *o, struct gp_rays_place *out)
{
    const double *const m = o->to_world;
    struct gp_v3 row[3], across[3];
    double scale = 0.0, wide = 0.0, thick = 0.0;
    for (int pass = 0; pass < 2; pass++) {
        int widest = 0;
        for (int i = 0; i < 3; i++) {
            if (pass == 0)
                row[i] = (struct gp_v3) {m[4 * i], m[4 * i + 1], m[4 * i + 2]};
            scale = fmax(scale, gp_v3_length(row[i]));
        }
        for (int i = 0; i < 3; i++) {
            across[i] = gp_v3_cross(row[(i + 1) % 3], row[(i + 2) % 3]);
            if (gp_v3_length(across[i]) > gp_v3_length(across[widest]))
                widest = i;
        }
        wide = gp_v3_length(across[widest]);
        thick = gp_v3_dot(row[0], across[0]);
        if (!(wide > 1e-14 * scale * scale))
            return false;
        if (fabs(thick) > 1e-10 * scale * wide)
            break;
        // the sum of row[i] * (across[i] . normal) is 0: no other change of the
        // rows gives them a third direction with less
        const struct gp_v3 normal = gp_v3_unit(across[widest]);
        for (int i = 0; i < 3; i++)
            row[i] = gp_v3_add(row[i], gp_v3_scale(
                normal, 1e-7 * scale * gp_v3_dot(across[i], normal) / wide));
    }
    for (int i = 0; i < 3; i++)
        out->in[i] = gp_v3_scale(across[i], 1.0 / thick);
    out->move = (struct gp_v3) {m[12], m[13], m[14]};
    return isfinite(1.0 / thick);
}

gp_status gp_rays_make(const struct gp_log *log, const struct gp_scene *s,
                       struct gp_meshes *meshes, const int *object, int objects,
                       struct gp_rays *out)
{
    static const char what[] = "objects before a light";
    struct gp_box *box = NULL;
    gp_status st;
    int n = 0;
    out->scene = s;
    if (!meshes->tree)
        GP_TRY(gp_alloc_zero(log, "meshes", (size_t) s->meshes + 1,
                             sizeof *meshes->tree, &meshes->tree));
    meshes->n = s->meshes;
    out->mesh = meshes->tree;
    GP_TRY(gp_alloc(log, what, (size_t) objects, sizeof *out->place,
                    &out->place));
    GP_TRY(gp_alloc(log, what, (size_t) objects, sizeof *box, &box));
    for (int i = 0; i < objects; i++) {
        const struct gp_object *const o = &s->object[object[i]];
        struct gp_mesh_tree *const mesh = &meshes->tree[o->mesh];
        if (!mesh->made)
            GP_TRY(make_mesh(log, s, &s->mesh[o->mesh], mesh));
        out->place[n].object = object[i];
        if (mesh->tree.n > 0 && set_place(o, &out->place[n]))
            box[n++] = o->box;
    }
    st = make_tree(log, box, n, &out->tree);
out:
    gp_free(box);
    return st;
}

void gp_rays_free(struct gp_rays *r)
{
    free_tree(&r->tree);
    gp_free(r->place);
    *r = (struct gp_rays) {0};
}

// -- rays --------------------------------------------------------------------

/* Beside an edge by so many of its lengths a triangle still stops a ray: none
 * slips between two that share it. */
static const double EDGE = 1e-12;

static bool opaque_at(const struct gp_scene *s, const struct triangle *t,
                      double b, double c)
{
    const struct gp_material *const m = &s->material[t->material];
    if (!(m->cutoff > 0.0f))
        return true;
    double alpha = (double) m->base[3];
    if (m->cutout >= 0) {
        const uint32_t *const v = s->index + t->index;
        const float *const p = s->uv + 2 * (size_t) v[0];
        const float *const q = s->uv + 2 * (size_t) v[1];
        const float *const r = s->uv + 2 * (size_t) v[2];
        const double a = 1.0 - b - c;
        alpha *= alpha_at(
            &s->cutout[m->cutout],
            a * (double) p[0] + b * (double) q[0] + c * (double) r[0],
            a * (double) p[1] + b * (double) q[1] + c * (double) r[1]);
    }
    return alpha >= (double) m->cutoff;
}

/* A ray in the space of a mesh, and the triangle that last stopped it. */
struct walk {
    const struct gp_rays *rays;
    const struct gp_mesh_tree *mesh;
    struct gp_v3 from, along;             // of the mesh
    struct gp_v3 world_from, world_along;
    const struct triangle *found;         // NULL: none yet
    int object;                           // its
    bool any;                             // the first found ends the walk
};

static struct gp_v3 vertex(const struct triangle *t, int i)
{
    const float *const p = t->at + 3 * i;
    return (struct gp_v3) {(double) p[0], (double) p[1], (double) p[2]};
}

/* Returns the distance at which a triangle stops a ray before `most`, or `most`
 * (Moeller and Trumbore 1997, without culling). */
static inline double triangle_at(const struct walk *w, const struct triangle *t,
                                 double most)
{
    const struct gp_v3 a = vertex(t, 0);
    const struct gp_v3 ab = gp_v3_sub(vertex(t, 1), a);
    const struct gp_v3 ac = gp_v3_sub(vertex(t, 2), a);
    const struct gp_v3 p = gp_v3_cross(w->along, ac);
    const double det = gp_v3_dot(ab, p);
    if (det == 0.0)
        return most;
    const double per = 1.0 / det;
    const struct gp_v3 to = gp_v3_sub(w->from, a);
    const double b = gp_v3_dot(to, p) * per;
    if (!(b >= -EDGE && b <= 1.0 + EDGE))
        return most;
    const struct gp_v3 q = gp_v3_cross(to, ab);
    const double c = gp_v3_dot(w->along, q) * per;
    const double at = gp_v3_dot(ac, q) * per;
    const bool stops = c >= -EDGE && b + c <= 1.0 + EDGE && at > 0.0 &&
                       at < most && opaque_at(w->rays->scene, t, b, c);
    return stops ? at : most;
}

static double meet_triangle(void *user, int item, double most)
{
    struct walk *const w = user;
    const double at = triangle_at(w, &w->mesh->triangle[item], most);
    if (!(at < most))
        return most;
    w->found = &w->mesh->triangle[item];
    return w->any ? -1.0 : at;
}

static double meet_object(void *user, int item, double most)
{
    struct walk *const w = user;
    const struct gp_rays_place *const p = &w->rays->place[item];
    const struct gp_v3 from = gp_v3_sub(w->world_from, p->move);
    w->mesh = &w->rays->mesh[w->rays->scene->object[p->object].mesh];
    w->from = (struct gp_v3) {gp_v3_dot(from, p->in[0]),
                              gp_v3_dot(from, p->in[1]),
                              gp_v3_dot(from, p->in[2])};
    w->along = (struct gp_v3) {gp_v3_dot(w->world_along, p->in[0]),
                               gp_v3_dot(w->world_along, p->in[1]),
                               gp_v3_dot(w->world_along, p->in[2])};
    const double at = walk_tree(&w->mesh->tree, w->from, w->along, most,
                                meet_triangle, w);
    w->object = at < most ? p->object : w->object;
    return at;
}

bool gp_rays_stopped(const struct gp_rays *r, struct gp_v3 from,
                     struct gp_v3 along, double most)
{
    struct walk w = {
        .rays = r, .world_from = from, .world_along = along, .any = true,
    };
    walk_tree(&r->tree, from, along, most, meet_object, &w);
    return w.found;
}

bool gp_rays_first(const struct gp_rays *r, struct gp_v3 from,
                   struct gp_v3 along, double most, struct gp_rays_hit *out)
{
    struct walk w = {.rays = r, .world_from = from, .world_along = along};
    most = walk_tree(&r->tree, from, along, most, meet_object, &w);
    if (!w.found)
        return false;
    const double *const m = r->scene->object[w.object].to_world;
    const struct gp_v3 a = gp_move(m, vertex(w.found, 0));
    const struct gp_v3 ab = gp_v3_sub(gp_move(m, vertex(w.found, 1)), a);
    const struct gp_v3 ac = gp_v3_sub(gp_move(m, vertex(w.found, 2)), a);
    out->at = most;
    out->normal = gp_v3_unit(gp_v3_cross(ab, ac));
    out->material = w.found->material;
    return true;
}
