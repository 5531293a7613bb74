/* Umbras: space that a convex body keeps all light of one lamp from. */
#ifndef GP_SCENE_UMBRA_H
#define GP_SCENE_UMBRA_H

#include "scene/frustum.h"

enum { GP_BODY_POINTS = 64, GP_BODY_FACES = 64, GP_BODY_EDGES = 128 };

/* A convex body that a mesh fills: a closed convex polyhedron, or a flat convex
 * polygon (one face), opaque everywhere. Faces are planar; triangles of one
 * plane are joined. In the space of the mesh. */
struct gp_body {
    struct gp_v3 point[GP_BODY_POINTS];
    struct gp_v3 middle;             // inside
    unsigned char face[GP_BODY_FACES][3]; // points that span it
    struct {
        unsigned char from, to;      // points
        unsigned char side[2];       // faces; equal ones: a polygon's border
    } edge[GP_BODY_EDGES];
    int points, faces, edges;
};

/* Finds the body of a mesh: of all of its triangles at once, in any winding.
 * False where they make none: not convex, open but not flat, cut out or
 * transparent, over 64 points or faces. Triangles without area do not count. */
bool gp_body_find(const struct gp_scene *s, int mesh, struct gp_body *out);

/* The umbra of a body: behind its front faces and within the planes through
 * the light and the edges of its silhouette. */
struct gp_umbra {
    int planes; // 0: none
    struct gp_half plane[GP_BODY_EDGES + GP_BODY_FACES];
    double margin; // what is in by less counts as outside: faces that touch
};

/* Returns the umbra of a body moved by `to_world` before a light. It is empty
 * where the light is in the body or in the plane of a flat one. */
struct gp_umbra gp_umbra_make(const struct gp_body *body,
                              const double to_world[16], struct gp_from light);

/* True where all of a box is in the umbra: of centre c and half sides e. */
static inline bool gp_umbra_holds(const struct gp_umbra *u, struct gp_v3 c,
                                  struct gp_v3 e)
{
    for (int i = 0; i < u->planes; i++) {
        const struct gp_half h = u->plane[i];
        if (gp_half_at(h, c) + fabs(h.n.x) * e.x + fabs(h.n.y) * e.y +
                fabs(h.n.z) * e.z > -u->margin)
            return false;
    }
    return u->planes > 0;
}

#endif
