/* Umbras: space that a convex body keeps all light of one lamp from. */
#ifndef GP_SCENE_UMBRA_H
#define GP_SCENE_UMBRA_H

#include "scene/reach.h"

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

/* True where no light passes through a submesh. */
bool gp_submesh_opaque(const struct gp_scene *s, const struct gp_submesh *p);

/* The umbra of a body: behind its front faces and within the planes through
 * the light and the edges of its silhouette. */
struct gp_umbra {
    int planes; // 0: none
    struct gp_half plane[GP_BODY_EDGES + GP_BODY_FACES];
    double margin; // what is in by less counts as outside: faces that touch
};

/* True where all of a box is in the umbra: of centre c and half sides e. */
static inline bool gp_umbra_holds(const struct gp_umbra *u, struct gp_v3 c,
                                  struct gp_v3 e)
{
    for (int i = 0; i < u->planes; i++) {
        const struct gp_half h = u->plane[i];
        const double reach =
            fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
        if (gp_half_at(h, c) + reach > -u->margin)
            return false;
    }
    return u->planes > 0;
}

/* Returns half sides e of a box at c, wider by what lookups in a map of shadows
 * may be off: `texel` radians as seen from the light; of one at infinity a
 * length. */
struct gp_v3 gp_texel_widen(const struct gp_reach *light, double texel,
                            struct gp_v3 c, struct gp_v3 e, double radius);

/* Convex bodies of a scene's meshes, for umbras: one search for all frames. */
struct gp_bodies {
    int *of_mesh;         // index; -1: none
    struct gp_body *body;
    int bodies;
};

/* Out: *out, free with gp_bodies_free(). Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_bodies_make(const struct gp_log *log,
                                       const struct gp_scene *s,
                                       struct gp_bodies **out);
void gp_bodies_free(struct gp_bodies **b);

/* The largest occluders of a light, by the angle that they fill. */
enum { GP_OCCLUDERS = 16 };
struct gp_darkest {
    int n;
    int object[GP_OCCLUDERS];
    double size[GP_OCCLUDERS]; // falling
};

/* Returns the mean of the areas of an object's box as seen from each axis, a
 * measure of the shadow it throws; 0 where its mesh is no body. */
double gp_darkest_size(const struct gp_bodies *b, const struct gp_object *o);

/* Keeps object i of that centre and size where it is among the largest; of those
 * of one size the first of the scene. */
void gp_darkest_try(struct gp_darkest *o, const struct gp_reach *light,
                    struct gp_v3 centre, double size, int i);

/* The umbras of a light, each in a cone of its rays, or a cylinder of those of
 * a light at infinity, that is quick to ask. */
struct gp_umbras {
    int n;
    struct gp_from light;
    // place and unit axis of the cone of each, cosine and sine of its half
    // angle, and the radius of a cylinder
    double cone[9][GP_OCCLUDERS];
    struct gp_umbra umbra[GP_OCCLUDERS];
};

/* Makes the umbras of a choice of occluders, those that are not empty. */
void gp_umbras_make(const struct gp_darkest *o, const struct gp_scene *s,
                    const struct gp_bodies *b, const struct gp_reach *light,
                    struct gp_umbras *out);

/* Returns bits of the umbras in which a box may be whose centre is within
 * `radius` of c. */
unsigned gp_umbras_near(const struct gp_umbras *u, struct gp_v3 c,
                        double radius);

/* True where an umbra holds a box of centre c and half sides e. */
bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e);

#endif
