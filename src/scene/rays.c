/* A tree of boxes over triangles, and rays through it. */
#include "scene/rays.h"

#include "core/memory.h"
#include "scene/bounds.h"
#include "scene/scene_priv.h"

#include <math.h>
#include <string.h>

struct gp_rays_triangle {
    struct gp_v3 a, ab, ac;
    float uv[6];
    int material;
};

/* A box of triangles [first, first + count), or of two nodes, at left and
 * left + 1, where count is 0. */
struct gp_rays_node {
    struct gp_box box;
    int first, count, left;
};

enum { LEAF = 4, DEEP = 64 }; // triangles of a leaf; nodes that wait, at most

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

double gp_cutout_alpha(const struct gp_cutout *c, double u, double v)
{
    // (no texture is wrapped so often that its fraction still has digits)
    const double x = (fabs(u) < 1e9 ? u : 0.0) * c->w - 0.5;
    const double y = (fabs(v) < 1e9 ? v : 0.0) * c->h - 0.5;
    const double x0 = floor(x), y0 = floor(y), fx = x - x0, fy = y - y0;
    double row[2];
    for (int i = 0; i < 2; i++) {
        const float *const p =
            c->alpha + (size_t) wrapped(y0 + i, c->h, c->wrap[1]) *
                           (size_t) c->w;
        row[i] = (1.0 - fx) * (double) p[wrapped(x0, c->w, c->wrap[0])] +
                 fx * (double) p[wrapped(x0 + 1.0, c->w, c->wrap[0])];
    }
    return (1.0 - fy) * row[0] + fy * row[1];
}

// -- building ----------------------------------------------------------------

static struct gp_v3 centroid(const struct gp_rays_triangle *t)
{
    return gp_v3_add(t->a, gp_v3_scale(gp_v3_add(t->ab, t->ac), 1.0 / 3.0));
}

static double axis_of(struct gp_v3 p, int axis)
{
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

/* Moves the k smallest along an axis to the front (Hoare's select). */
static void select_first(struct gp_rays_triangle *t, int n, int k, int axis)
{
    int lo = 0, hi = n - 1;
    while (lo < hi) {
        const double pivot =
            axis_of(centroid(&t[lo + (hi - lo) / 2]), axis);
        int i = lo, j = hi;
        while (i <= j) {
            while (axis_of(centroid(&t[i]), axis) < pivot)
                i++;
            while (axis_of(centroid(&t[j]), axis) > pivot)
                j--;
            if (i <= j) {
                const struct gp_rays_triangle swap = t[i];
                t[i++] = t[j];
                t[j--] = swap;
            }
        }
        if (k <= j)
            hi = j;
        else if (k >= i)
            lo = i;
        else
            return;
    }
}

static struct gp_box box_of(const struct gp_rays_triangle *t, int n)
{
    struct gp_box box = GP_BOX_EMPTY;
    for (int i = 0; i < n; i++) {
        box = gp_box_with(box, t[i].a);
        box = gp_box_with(box, gp_v3_add(t[i].a, t[i].ab));
        box = gp_box_with(box, gp_v3_add(t[i].a, t[i].ac));
    }
    return box;
}

/* Splits nodes at the middle triangle along the longest side, until leaves are
 * small: at most 2 n nodes, and as deep as n has bits. */
static void build(struct gp_rays *r)
{
    int nodes = 1;
    r->node[0] = (struct gp_rays_node) {.count = r->n};
    for (int i = 0; i < nodes; i++) {
        struct gp_rays_node *const node = &r->node[i];
        struct gp_rays_triangle *const t = r->triangle + node->first;
        const int n = node->count, half = n / 2;
        node->box = box_of(t, n);
        if (n <= LEAF)
            continue;
        const struct gp_v3 size = gp_v3_sub(node->box.hi, node->box.lo);
        const int axis = size.x >= size.y && size.x >= size.z ? 0
                         : size.y >= size.z                   ? 1
                                                              : 2;
        select_first(t, n, half, axis);
        node->left = nodes;
        node->count = 0;
        r->node[nodes++] =
            (struct gp_rays_node) {.first = node->first, .count = half};
        r->node[nodes++] = (struct gp_rays_node) {
            .first = node->first + half, .count = n - half};
    }
}

/* The triangle of three indices, in the world. */
static struct gp_rays_triangle triangle_of(const struct gp_scene *s,
    const struct gp_object *o, const uint32_t *index, int material)
{
    struct gp_rays_triangle t = {.material = material};
    struct gp_v3 p[3];
    for (int i = 0; i < 3; i++) {
        p[i] = gp_move(o->to_world, gp_scene_vertex(s, index[i]));
        memcpy(t.uv + 2 * i, s->uv + 2 * (size_t) index[i], 2 * sizeof *t.uv);
    }
    t.a = p[0];
    t.ab = gp_v3_sub(p[1], p[0]);
    t.ac = gp_v3_sub(p[2], p[0]);
    return t;
}

static bool keeps(gp_rays_keep keep, const void *user,
                  const struct gp_rays_triangle *t)
{
    const struct gp_v3 c = centroid(t), a = gp_v3_sub(t->a, c);
    return !keep ||
           keep(user, c, fmax(gp_v3_length(a),
                              fmax(gp_v3_length(gp_v3_add(a, t->ab)),
                                   gp_v3_length(gp_v3_add(a, t->ac)))));
}

/* Collects the triangles of an object; only counts them where r has no room. */
static void collect(const struct gp_scene *s, const struct gp_object *o,
                    gp_rays_keep keep, const void *user, struct gp_rays *r)
{
    const struct gp_mesh *const m = &s->mesh[o->mesh];
    for (int k = m->first; k < m->first + m->parts; k++) {
        const struct gp_part *const part = &s->part[k];
        for (int i = part->first; i < part->first + part->count; i += 3) {
            const struct gp_rays_triangle t =
                triangle_of(s, o, s->index + i, part->material);
            if (!keeps(keep, user, &t))
                continue;
            if (r->triangle)
                r->triangle[r->n] = t;
            r->n++;
        }
    }
}

gp_status gp_rays_make(const struct gp_log *log, const struct gp_scene *s,
    const int *object, int objects, int most, gp_rays_keep keep,
    const void *user, int *used, struct gp_rays *out)
{
    gp_status st = GP_OK;
    int n = 0;
    out->scene = s;
    *used = 0;
    for (; *used < objects; ++*used) { // counts; a mesh's triangles fit an int
        collect(s, &s->object[object[*used]], keep, user, out);
        if (*used > 0 && out->n > most)
            break;
        n = out->n;
        if (n > most) { // one object alone
            ++*used;
            break;
        }
    }
    out->n = 0;
    if (n == 0)
        return GP_OK;
    GP_TRY(gp_alloc(log, "triangles before a light", (size_t) n,
                    sizeof *out->triangle, &out->triangle));
    GP_TRY(gp_alloc(log, "triangles before a light", 2 * (size_t) n,
                    sizeof *out->node, &out->node));
    for (int i = 0; i < *used; i++)
        collect(s, &s->object[object[i]], keep, user, out);
    build(out);
out:
    return st;
}

void gp_rays_free(struct gp_rays *r)
{
    gp_free(r->triangle);
    gp_free(r->node);
    *r = (struct gp_rays) {0};
}

// -- rays --------------------------------------------------------------------

/* Beside an edge by so many of its lengths a triangle still stops a ray: none
 * slips between two that share it. */
static const double EDGE = 1e-12;

static bool opaque_at(const struct gp_scene *s,
                      const struct gp_rays_triangle *t, double b, double c)
{
    const struct gp_material *const m = &s->material[t->material];
    if (!(m->cutoff > 0.0f))
        return true;
    double alpha = (double) m->base[3];
    if (m->cutout >= 0) {
        const double a = 1.0 - b - c;
        alpha *= gp_cutout_alpha(
            &s->cutout[m->cutout],
            a * (double) t->uv[0] + b * (double) t->uv[2] +
                c * (double) t->uv[4],
            a * (double) t->uv[1] + b * (double) t->uv[3] +
                c * (double) t->uv[5]);
    }
    return alpha >= (double) m->cutoff;
}

/* Returns where a triangle stops a ray before `most`, or `most` (Moeller and
 * Trumbore 1997, without culling). */
static double triangle_at(const struct gp_scene *s,
    const struct gp_rays_triangle *t, struct gp_v3 from, struct gp_v3 along,
    double most)
{
    const struct gp_v3 p = gp_v3_cross(along, t->ac);
    const double det = gp_v3_dot(t->ab, p);
    if (det == 0.0)
        return most;
    const struct gp_v3 to = gp_v3_sub(from, t->a);
    const double b = gp_v3_dot(to, p) / det;
    if (!(b >= -EDGE && b <= 1.0 + EDGE))
        return most;
    const struct gp_v3 q = gp_v3_cross(to, t->ab);
    const double c = gp_v3_dot(along, q) / det;
    const double at = gp_v3_dot(t->ac, q) / det;
    const bool stops = c >= -EDGE && b + c <= 1.0 + EDGE && at > 0.0 &&
                       at < most && opaque_at(s, t, b, c);
    return stops ? at : most;
}

/* Returns true when the ray meets the box, by slabs; `per` is 1 / along. */
static bool box_meets(const struct gp_box *b, struct gp_v3 from,
                      struct gp_v3 per, double most)
{
    const double x0 = (b->lo.x - from.x) * per.x, x1 = (b->hi.x - from.x) * per.x;
    const double y0 = (b->lo.y - from.y) * per.y, y1 = (b->hi.y - from.y) * per.y;
    const double z0 = (b->lo.z - from.z) * per.z, z1 = (b->hi.z - from.z) * per.z;
    // fmin and fmax leave out the NaN of a ray in the slab's own plane
    const double near = fmax(fmax(fmin(x0, x1), fmin(y0, y1)),
                             fmax(fmin(z0, z1), 0.0));
    const double far = fmin(fmin(fmax(x0, x1), fmax(y0, y1)),
                            fmin(fmax(z0, z1), most));
    return near <= far * (1.0 + 1e-12);
}

bool gp_rays_stopped(const struct gp_rays *r, struct gp_v3 from,
                     struct gp_v3 along, double most)
{
    const struct gp_v3 per = {1.0 / along.x, 1.0 / along.y, 1.0 / along.z};
    int wait[DEEP], n = 0;
    if (r->n > 0)
        wait[n++] = 0;
    while (n > 0) {
        const struct gp_rays_node *const node = &r->node[wait[--n]];
        if (!box_meets(&node->box, from, per, most))
            continue;
        for (int i = node->first; i < node->first + node->count; i++) {
            if (triangle_at(r->scene, &r->triangle[i], from, along, most) <
                most)
                return true;
        }
        if (node->count == 0) {
            wait[n++] = node->left + 1;
            wait[n++] = node->left;
        }
    }
    return false;
}

bool gp_rays_first(const struct gp_rays *r, struct gp_v3 from,
                   struct gp_v3 along, double most, struct gp_rays_hit *out)
{
    const struct gp_v3 per = {1.0 / along.x, 1.0 / along.y, 1.0 / along.z};
    const struct gp_rays_triangle *found = NULL;
    int wait[DEEP], n = 0;
    if (r->n > 0)
        wait[n++] = 0;
    while (n > 0) {
        const struct gp_rays_node *const node = &r->node[wait[--n]];
        if (!box_meets(&node->box, from, per, most))
            continue;
        for (int i = node->first; i < node->first + node->count; i++) {
            const double at =
                triangle_at(r->scene, &r->triangle[i], from, along, most);
            found = at < most ? &r->triangle[i] : found;
            most = at;
        }
        if (node->count == 0) { // the nearer one is taken first
            const struct gp_box *const x = &r->node[node->left].box;
            const struct gp_box *const y = &r->node[node->left + 1].box;
            const struct gp_v3 way = gp_v3_sub(gp_v3_add(y->lo, y->hi),
                                               gp_v3_add(x->lo, x->hi));
            const int near = gp_v3_dot(way, along) < 0.0;
            wait[n++] = node->left + 1 - near;
            wait[n++] = node->left + near;
        }
    }
    if (!found)
        return false;
    out->at = most;
    out->normal = gp_v3_unit(gp_v3_cross(found->ab, found->ac));
    out->material = found->material;
    return true;
}
