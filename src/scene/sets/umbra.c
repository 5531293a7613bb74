/* Convex bodies of meshes, and the umbras they throw. */
#include "scene/sets/sets_priv.h"

#include "core/memory.h"

#include <string.h>

// -- bodies ------------------------------------------------------------------

static const double ON = 1e-5; // of the size of the body: floats of a file

bool gp_submesh_opaque(const struct gp_scene *s, const struct gp_submesh *p)
{
    const struct gp_material *const m = &s->material[p->material];
    return !gp_material_cut(m) && !gp_material_gone(m);
}

/* Returns the index of a point of the body, added when it is none yet; -1: no
 * room. */
static int point_of(struct gp_body *b, struct gp_v3 p, double near)
{
    for (int i = 0; i < b->points; i++) {
        if (gp_v3_length(gp_v3_sub(b->point[i], p)) <= near)
            return i;
    }
    if (b->points == GP_BODY_POINTS)
        return -1;
    b->point[b->points] = p;
    return b->points++;
}

static struct gp_half through(struct gp_v3 a, struct gp_v3 b, struct gp_v3 c)
{
    const struct gp_v3 n = gp_v3_unit(
        gp_v3_cross(gp_v3_sub(b, a), gp_v3_sub(c, a)));
    return (struct gp_half) {n, -gp_v3_dot(n, a)};
}

/* Adds the edge from one point to another of a face. The other way round within
 * one face, it is inside of that and goes. False: no room, or two faces on it
 * already. */
static bool add_edge(struct gp_body *b, int from, int to, int face)
{
    for (int i = 0; i < b->edges; i++) {
        const bool same = b->edge[i].from == from && b->edge[i].to == to;
        if (!same && !(b->edge[i].from == to && b->edge[i].to == from))
            continue;
        if (b->edge[i].side[0] == face && b->edge[i].side[1] == face) {
            b->edge[i] = b->edge[--b->edges];
            return !same; // two triangles over each other
        }
        if (b->edge[i].side[0] != b->edge[i].side[1])
            return false;
        b->edge[i].side[1] = (unsigned char) face;
        return true;
    }
    if (b->edges == GP_BODY_EDGES)
        return false;
    b->edge[b->edges].from = (unsigned char) from;
    b->edge[b->edges].to = (unsigned char) to;
    b->edge[b->edges].side[0] = b->edge[b->edges].side[1] =
        (unsigned char) face;
    b->edges++;
    return true;
}

static bool on_plane(const struct gp_body *b, const int p[3], struct gp_half h,
                     double near)
{
    return fabs(gp_half_at(h, b->point[p[0]])) <= near &&
           fabs(gp_half_at(h, b->point[p[1]])) <= near &&
           fabs(gp_half_at(h, b->point[p[2]])) <= near;
}

/* Adds a triangle, to the face of its plane or to one of its own. False: no
 * room, or more than two faces at an edge. */
static bool add_triangle(struct gp_body *b, const int p[3], double near,
                         struct gp_half plane[GP_BODY_FACES])
{
    struct gp_half h =
        through(b->point[p[0]], b->point[p[1]], b->point[p[2]]);
    const bool turned = gp_half_at(h, b->middle) > 0.0;
    if (turned)
        h = (struct gp_half) {gp_v3_scale(h.n, -1.0), -h.d};
    int f = 0;
    while (f < b->faces && !on_plane(b, p, plane[f], near))
        f++;
    if (f == b->faces) {
        if (f == GP_BODY_FACES)
            return false;
        for (int i = 0; i < 3; i++)
            b->face[f][i] = (unsigned char) p[i];
        plane[f] = h;
        b->faces++;
    }
    // in one winding for all triangles of a face
    const bool along = gp_v3_dot(
        through(b->point[p[0]], b->point[p[1]], b->point[p[2]]).n,
        plane[f].n) > 0.0;
    for (int i = 0; i < 3; i++) {
        const int from = p[along ? i : (i + 1) % 3],
                  to = p[along ? (i + 1) % 3 : i];
        if (!add_edge(b, from, to, f))
            return false;
    }
    return true;
}

/* Checks that faces and edges bound a convex body: every point is behind every
 * face; of a polygon, every point is behind every edge. */
static bool convex(const struct gp_body *b, double near,
                   const struct gp_half plane[GP_BODY_FACES])
{
    for (int f = 0; f < b->faces; f++) {
        for (int i = 0; i < b->points; i++) {
            if (gp_half_at(plane[f], b->point[i]) > near)
                return false;
        }
    }
    int border = 0;
    for (int i = 0; i < b->edges; i++) {
        if (b->edge[i].side[0] != b->edge[i].side[1])
            continue;
        border++;
        const struct gp_v3 a = b->point[b->edge[i].from],
                           to = gp_v3_sub(b->point[b->edge[i].to], a);
        const struct gp_v3 out =
            gp_v3_unit(gp_v3_cross(to, plane[b->edge[i].side[0]].n));
        for (int k = 0; k < b->points; k++) {
            if (gp_v3_dot(out, gp_v3_sub(b->point[k], a)) > near)
                return false;
        }
    }
    // closed (Euler), or flat with one border around: as many edges as points
    const bool closed = border == 0 && b->faces >= 4 &&
                        b->points - b->edges + b->faces == 2;
    return closed || (b->faces == 1 && border >= 3 && border == b->edges &&
                      border == b->points);
}

bool gp_body_find(const struct gp_scene *s, int mesh, struct gp_body *out)
{
    const struct gp_mesh *const m = &s->mesh[mesh];
    const struct gp_submesh *const end = s->submesh + m->first + m->submeshes;
    struct gp_half plane[GP_BODY_FACES];
    const double size = gp_v3_length(gp_v3_sub(m->box.hi, m->box.lo));
    const double near = ON * size;
    int triangles = 0;
    memset(out, 0, sizeof *out);
    for (const struct gp_submesh *p = s->submesh + m->first; p < end; p++) {
        triangles += p->count / 3;
        if (!gp_submesh_opaque(s, p) || triangles > 4 * GP_BODY_POINTS)
            return false;
    }
    if (triangles == 0 || !(size > 0.0))
        return false;
    for (int pass = 0; pass < 2; pass++) { // points, then faces and edges
        for (const struct gp_submesh *p = s->submesh + m->first; p < end; p++) {
            for (int i = p->first; i < p->first + p->count; i += 3) {
                int v[3];
                for (int k = 0; k < 3; k++)
                    v[k] = point_of(out, gp_scene_vertex(s, s->index[i + k]),
                                    near);
                if (v[0] < 0 || v[1] < 0 || v[2] < 0)
                    return false;
                if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
                    continue; // without area
                if (pass == 1 && !add_triangle(out, v, near, plane))
                    return false;
            }
        }
        for (int i = 0; pass == 0 && i < out->points; i++)
            out->middle = gp_v3_add(
                out->middle, gp_v3_scale(out->point[i], 1.0 / out->points));
    }
    return convex(out, near, plane);
}

// -- of a scene's meshes ------------------------------------------------------

gp_status gp_bodies_make(const struct gp_log *log, const struct gp_scene *s,
                         struct gp_bodies *b)
{
    struct gp_body found;
    gp_status st;
    GP_TRY(gp_alloc(log, "bodies of the scene", (size_t) s->meshes + 1,
                    sizeof *b->of_mesh, &b->of_mesh));
    for (int i = 0; i < s->meshes; i++) {
        b->of_mesh[i] = -1;
        if (!gp_body_find(s, i, &found))
            continue;
        const size_t n = (size_t) b->bodies;
        if ((n & (n - 1)) == 0) // 0, 1, 2, 4...
            GP_TRY(gp_resize(log, "bodies of the scene",
                             (n ? 2 * n : 1) * sizeof found,
                             (void **) &b->body));
        b->body[n] = found;
        b->of_mesh[i] = b->bodies++;
    }
out:
    return st;
}

void gp_bodies_free(struct gp_bodies *b)
{
    gp_free(b->of_mesh);
    gp_free(b->body);
    *b = (struct gp_bodies) {0};
}

// -- umbras ------------------------------------------------------------------

static struct gp_half turned_from(struct gp_half h, struct gp_v3 inside)
{
    return gp_half_at(h, inside) > 0.0
               ? (struct gp_half) {gp_v3_scale(h.n, -1.0), -h.d}
               : h;
}

void gp_umbra_make(const struct gp_body *body, const double to_world[16],
                   struct gp_from light, struct gp_umbra *out)
{
    struct gp_v3 p[GP_BODY_POINTS];
    bool front[GP_BODY_FACES]; // the light sees it
    const struct gp_v3 middle = gp_move(to_world, body->middle);
    double size = light.w * gp_v3_length(light.p);
    for (int i = 0; i < body->points; i++) {
        p[i] = gp_move(to_world, body->point[i]);
        size = fmax(size, gp_v3_length(p[i]));
    }
    out->planes = 0;
    out->margin = 1e-6 * size;
    for (int f = 0; f < body->faces; f++) {
        const unsigned char *const v = body->face[f];
        const struct gp_half h =
            turned_from(through(p[v[0]], p[v[1]], p[v[2]]), middle);
        const double at = gp_v3_dot(h.n, light.p) + light.w * h.d;
        if (gp_v3_length(h.n) < 0.5) // moved by a singular matrix
            goto none;
        front[f] = at > 0.0;
        if (body->faces == 1) { // a polygon has two sides
            if (fabs(at) <= (light.w > 0.0 ? out->margin : 1e-6))
                goto none;
            front[f] = true;
        }
        if (front[f]) // away from the light is inside
            out->plane[out->planes++] = at > 0.0 ? h
                : (struct gp_half) {gp_v3_scale(h.n, -1.0), -h.d};
    }
    if (out->planes == 0) // the light is in the body
        goto none;
    for (int i = 0; i < body->edges; i++) {
        const unsigned char *const side = body->edge[i].side;
        if (side[0] != side[1] && front[side[0]] == front[side[1]])
            continue;
        const struct gp_v3 a = p[body->edge[i].from], b = p[body->edge[i].to];
        const struct gp_v3 c =
            light.w > 0.0 ? light.p : gp_v3_add(a, light.p);
        const struct gp_v3 n =
            gp_v3_cross(gp_v3_sub(b, a), gp_v3_sub(c, a));
        if (!(gp_v3_length(n) > 1e-9 * gp_v3_length(gp_v3_sub(b, a)) *
                                    gp_v3_length(gp_v3_sub(c, a))))
            goto none; // the light is on the edge's line
        out->plane[out->planes++] = turned_from(through(a, b, c), middle);
    }
    return;
none:
    out->planes = 0;
}

// -- of a light --------------------------------------------------------------

void gp_darkest_try(struct gp_darkest *o, const struct gp_scene *s,
                    const struct gp_bodies *b, const struct gp_reach *light,
                    int i)
{
    const struct gp_object *const at = &s->object[i];
    if (b->of_mesh[at->mesh] < 0)
        return;
    // the mean of the areas of its box as seen from each axis
    const struct gp_v3 e = gp_v3_sub(at->box.hi, at->box.lo);
    const double size = (e.x * e.y + e.y * e.z + e.z * e.x) / 3.0;
    const struct gp_v3 to =
        gp_v3_sub(gp_box_middle(&at->box), light->from.p);
    const double angle =
        light->from.w > 0.0 ? size / (gp_v3_dot(to, to) + 1e-6 * size) : size;
    int k = o->n;
    while (k > 0 && o->size[k - 1] < angle)
        k--;
    if (k == GP_OCCLUDERS || !(size > 0.0))
        return;
    o->n += o->n < GP_OCCLUDERS;
    for (int m = o->n - 1; m > k; m--) {
        o->size[m] = o->size[m - 1];
        o->object[m] = o->object[m - 1];
    }
    o->size[k] = angle;
    o->object[k] = i;
}

void gp_umbras_make(const struct gp_darkest *o, const struct gp_scene *s,
                    const struct gp_bodies *b, const struct gp_reach *light,
                    struct gp_umbras *out)
{
    out->n = 0;
    for (int k = 0; k < o->n; k++) {
        const struct gp_object *const at = &s->object[o->object[k]];
        gp_umbra_make(&b->body[b->of_mesh[at->mesh]], at->to_world,
                      light->from, &out->umbra[out->n]);
        out->n += out->umbra[out->n].planes > 0;
    }
}

bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e)
{
    for (int i = 0; i < u->n; i++) {
        if (gp_umbra_holds(&u->umbra[i], c, e))
            return true;
    }
    return false;
}
