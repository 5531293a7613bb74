// SPDX-License-Identifier: Apache-2.0
/* Convex bodies of meshes, and the umbras they throw. */
#include "scene/sets/sets_priv.h"

#include "core/memory.h"

#include <string.h>

enum { POINTS = 64, FACES = 128, EDGES = 192, OCCLUDERS = 16 };

/* A body, in the space of its mesh. */
struct body {
    struct gp_v3 point[POINTS];
    struct gp_v3 middle;          // inside
    unsigned char face[FACES][3]; // triangles, in any winding
    struct {
        unsigned char from, to;   // points
        unsigned char side[2];    // faces; equal ones: only one
    } edge[EDGES];
    int points, faces, edges;
};

/* The umbra of a body: behind its front faces and within the planes through
 * the light and the edges of its silhouette. */
struct umbra {
    int planes; // 0: none
    struct gp_half plane[EDGES + FACES];
    double margin; // what is in by less counts as outside: faces that touch
};

struct gp_umbras {
    const struct gp_scene *scene;
    struct body *body; // of each mesh; without faces: none; owned
    struct umbra umbra[OCCLUDERS];
    int n;
};

bool gp_half_span(struct gp_v3 p, struct gp_v3 a, struct gp_v3 b,
                  struct gp_v3 inside, struct gp_half *out)
{
    const struct gp_v3 n = gp_v3_cross(a, b);
    const double length = gp_v3_length(n);
    *out = (struct gp_half) {0};
    if (!(length > 1e-9 * gp_v3_length(a) * gp_v3_length(b)))
        return false;
    out->n = gp_v3_scale(n, 1.0 / length);
    out->d = -gp_v3_dot(out->n, p);
    if (gp_half_at(*out, inside) > 0.0)
        *out = (struct gp_half) {gp_v3_scale(out->n, -1.0), -out->d};
    return true;
}

// -- bodies ------------------------------------------------------------------

static const double ON = 1e-5; // of the size of the body: floats of a file

/* Returns the index of a point of the body, added when it is none yet; -1: no
 * room. */
static int point_of(struct body *b, struct gp_v3 p, double near)
{
    for (int i = 0; i < b->points; i++) {
        if (gp_v3_length(gp_v3_sub(b->point[i], p)) <= near)
            return i;
    }
    if (b->points == POINTS)
        return -1;
    b->point[b->points] = p;
    return b->points++;
}

/* Adds a triangle's edge, or its second side. False: no room, or two there
 * already. */
static bool add_edge(struct body *b, int from, int to, int face)
{
    int i = 0;
    while (i < b->edges &&
           !(b->edge[i].from == from && b->edge[i].to == to) &&
           !(b->edge[i].from == to && b->edge[i].to == from))
        i++;
    if (i == EDGES ||
        (i < b->edges && b->edge[i].side[0] != b->edge[i].side[1]))
        return false;
    if (i == b->edges) {
        b->edge[i].from = (unsigned char) from;
        b->edge[i].to = (unsigned char) to;
        b->edge[i].side[0] = (unsigned char) face;
        b->edges++;
    }
    b->edge[i].side[1] = (unsigned char) face;
    return true;
}

static bool add_face(struct body *b, const int p[3])
{
    if (p[0] == p[1] || p[1] == p[2] || p[2] == p[0])
        return true; // without area
    if (b->faces == FACES)
        return false;
    for (int i = 0; i < 3; i++) {
        b->face[b->faces][i] = (unsigned char) p[i];
        if (!add_edge(b, p[i], p[(i + 1) % 3], b->faces))
            return false;
    }
    b->faces++;
    return true;
}

/* Finds the plane of a face, moved by a matrix, with `inside` behind it. */
static bool plane_of(const struct body *b, int face,
                     const struct gp_v3 point[POINTS],
                     struct gp_v3 inside, struct gp_half *out)
{
    const unsigned char *const v = b->face[face];
    const struct gp_v3 a = point[v[0]];
    return gp_half_span(a, gp_v3_sub(point[v[1]], a),
                        gp_v3_sub(point[v[2]], a), inside, out);
}

/* Checks that faces and edges bound a convex body: every point is behind every
 * face or in it, and not all are in it. */
static bool is_convex(const struct body *b, double near)
{
    struct gp_half h;
    for (int f = 0; f < b->faces; f++) {
        double least = 0.0, most = 0.0;
        if (!plane_of(b, f, b->point, b->middle, &h))
            return false;
        for (int i = 0; i < b->points; i++) {
            least = fmin(least, gp_half_at(h, b->point[i]));
            most = fmax(most, gp_half_at(h, b->point[i]));
        }
        if (most > near || least >= -near)
            return false;
    }
    for (int i = 0; i < b->edges; i++) {
        if (b->edge[i].side[0] == b->edge[i].side[1])
            return false;
    }
    return b->points - b->edges + b->faces == 2; // closed (Euler)
}

/* Finds the body of a mesh: of all of its triangles at once; without faces
 * where they make none. Triangles without area do not count. */
static void find_body(const struct gp_scene *s, int mesh, struct body *out)
{
    const struct gp_mesh *const m = &s->mesh[mesh];
    const double size = gp_v3_length(gp_v3_sub(m->box.hi, m->box.lo));
    const double near = ON * size;
    bool good = true;
    memset(out, 0, sizeof *out);
    for (int k = m->first; k < m->first + m->submeshes; k++) {
        const struct gp_submesh *const p = &s->submesh[k];
        const struct gp_material *const of = &s->material[p->material];
        good = good && !gp_material_cut(of) && !gp_material_gone(of);
        for (int i = p->first; good && i < p->first + p->count; i += 3) {
            int v[3];
            for (int c = 0; c < 3; c++)
                v[c] = point_of(out, gp_scene_vertex(s, s->index[i + c]), near);
            good = v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && add_face(out, v);
        }
    }
    for (int i = 0; i < out->points; i++)
        out->middle = gp_v3_add(
            out->middle, gp_v3_scale(out->point[i], 1.0 / out->points));
    if (!good || !is_convex(out, near))
        out->faces = 0;
}

gp_status gp_umbras_open(const struct gp_log *log, const struct gp_scene *s,
                         struct gp_umbras **out)
{
    static const char what[] = "bodies of the scene";
    struct gp_umbras *u;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, what, 1, sizeof *u, out));
    u = *out;
    u->scene = s;
    GP_TRY(gp_alloc(log, what, (size_t) s->meshes + 1, sizeof *u->body,
                    &u->body));
    for (int i = 0; i < s->meshes; i++)
        find_body(s, i, &u->body[i]);
out:
    return st;
}

void gp_umbras_close(struct gp_umbras **u)
{
    if (*u)
        gp_free((*u)->body);
    GP_FREE(*u);
}

// -- umbras ------------------------------------------------------------------

/* Sets the planes of an umbra; false: it is empty. */
static bool set_planes(const struct body *body,
                       const struct gp_v3 point[POINTS],
                       struct gp_v3 middle, struct gp_from light,
                       struct umbra *out)
{
    bool front[FACES]; // the light sees it
    for (int f = 0; f < body->faces; f++) {
        struct gp_half h;
        if (!plane_of(body, f, point, middle, &h)) // by a singular matrix
            return false;
        const double at = gp_half_before(h, light);
        front[f] = at > 0.0;
        if (front[f]) // away from the light is inside
            out->plane[out->planes++] = h;
    }
    if (out->planes == 0) // the light is in the body
        return false;
    for (int i = 0; i < body->edges; i++) {
        const unsigned char *const side = body->edge[i].side;
        const struct gp_v3 a = point[body->edge[i].from];
        if (front[side[0]] == front[side[1]])
            continue;
        // (no plane: the light is on the edge's line)
        if (!gp_half_span(a, gp_v3_sub(point[body->edge[i].to], a),
                          gp_from_to(light, a), middle,
                          &out->plane[out->planes++]))
            return false;
    }
    return true;
}

/* Makes the umbra of a moved body; empty where the light is in it. */
static void make_umbra(const struct body *body, const double to_world[16],
                   struct gp_from light, struct umbra *out)
{
    struct gp_v3 point[POINTS];
    double size = light.w * gp_v3_length(light.p);
    for (int i = 0; i < body->points; i++) {
        point[i] = gp_move(to_world, body->point[i]);
        size = fmax(size, gp_v3_length(point[i]));
    }
    out->planes = 0;
    out->margin = 1e-6 * size;
    if (!set_planes(body, point, gp_move(to_world, body->middle), light, out))
        out->planes = 0;
}

// -- of a light --------------------------------------------------------------

/* Returns a measure of the angle that an object fills before a light, of one at
 * infinity of its area: by the mean of the areas of its box's sides. */
static double angle_of(const struct gp_object *o, struct gp_from light)
{
    const struct gp_v3 e = gp_v3_sub(o->box.hi, o->box.lo);
    const double size = (e.x * e.y + e.y * e.z + e.z * e.x) / 3.0;
    const struct gp_v3 to = gp_v3_sub(gp_box_middle(&o->box), light.p);
    return light.w > 0.0 ? size / (gp_v3_dot(to, to) + 1e-6 * size) : size;
}

void gp_umbras_light(struct gp_umbras *u, const uint8_t *flag,
                     struct gp_from light)
{
    const struct gp_scene *const s = u->scene;
    int most[OCCLUDERS], n = 0; // objects
    double angle[OCCLUDERS];    // falling
    for (int i = 0; flag && i < s->objects; i++) {
        const double is = angle_of(&s->object[i], light);
        if (!(flag[i] & GP_SET_L) || !u->body[s->object[i].mesh].faces ||
            !(is > 0.0) || (n == OCCLUDERS && angle[n - 1] >= is))
            continue;
        n += n < OCCLUDERS;
        int k = n - 1;
        for (; k > 0 && angle[k - 1] < is; k--) {
            angle[k] = angle[k - 1];
            most[k] = most[k - 1];
        }
        angle[k] = is;
        most[k] = i;
    }
    u->n = 0;
    for (int k = 0; k < n; k++) {
        const struct gp_object *const o = &s->object[most[k]];
        make_umbra(&u->body[o->mesh], o->to_world, light, &u->umbra[u->n]);
        u->n += u->umbra[u->n].planes > 0;
    }
}

bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e)
{
    for (int i = 0; i < u->n; i++) { // none has no planes
        const struct umbra *const of = &u->umbra[i];
        int k = 0;
        while (k < of->planes &&
               gp_half_at(of->plane[k], c) + gp_half_reach(of->plane[k], e) <=
                   -of->margin)
            k++;
        if (k == of->planes)
            return true;
    }
    return false;
}
