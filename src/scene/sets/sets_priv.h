/* Shared by the files of scene/sets and their tests, and private to them:
 * volumes, umbras, scissors, the renderer. */
#ifndef GP_SCENE_SETS_PRIV_H
#define GP_SCENE_SETS_PRIV_H

#include "core/minmax.h"
#include "scene/bounds.h"
#include "scene/sets/sets.h"

// -- convex volumes (hull.c) --------------------------------------------------

/* A half-space: n . p + d <= 0 is inside; n is a unit vector that points out. */
struct gp_half {
    struct gp_v3 n;
    double d;
};

static inline double gp_half_at(struct gp_half h, struct gp_v3 p)
{
    return gp_v3_dot(h.n, p) + h.d;
}

/* Returns how far a box of half sides e reaches along a plane's normal. */
static inline double gp_half_reach(struct gp_half h, struct gp_v3 e)
{
    return fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
}

/* The pixels of a rectangle between two distances along the view axis: corners
 * (bit 0 right, 1 low, 2 far) and planes (left, right, upper, lower, near,
 * far). Each pair of planes that meet has an edge. */
struct gp_frustum {
    struct gp_v3 corner[8];
    struct gp_half plane[6];
    double turn;    // 1 or, of a camera that mirrors, -1: winding of edges
};

/* An edge from one corner to the other. Seen from outside plane `with` it is in
 * counter-clockwise order, outside `against` clockwise; gp_frustum.turn -1 swaps
 * them. */
struct gp_frustum_edge {
    unsigned char from, to, with, against;
};
extern const struct gp_frustum_edge gp_frustum_edges[12];

/* The intersection of half-spaces, and a box around it; a frustum has 6, a hull
 * with a point at most 6 and one for each edge. */
struct gp_volume {
    int planes;
    struct gp_half plane[18];
    struct gp_box box; // infinite towards a directional light
    double slack;      // rounding: what misses by less still meets
};

/* A light's place for hulls and umbras: at w = 1 a point, at w = 0 the unit
 * direction to a light at infinity. */
struct gp_from {
    struct gp_v3 p;
    double w;
};

/* Returns the frustum of pixels [x0, x1] x [y0, y1] (EXR pixel space) from near
 * > 0 to far > near, units of the world along the view axis. */
struct gp_frustum gp_frustum_make(const struct gp_camera *c,
                                  struct gp_rect display, const double x[2],
                                  const double y[2], double near, double far);

struct gp_volume gp_frustum_volume(const struct gp_frustum *f);

/* Returns the convex hull of a frustum and a light: the frustum itself where
 * the light is inside, else the planes that have the light inside and one
 * through the light for each edge of the silhouette.
 * Source: O'Rorke, GPU Gems 15.4.4; Everitt and Kilgard 2003. */
struct gp_volume gp_hull(const struct gp_frustum *f, struct gp_from light);

/* True where a box of centre c and half sides e cannot meet the volume: it is
 * outside a plane, or of the volume's box. A box that misses all of the volume
 * beside an edge may count as one that meets it, never the other way round. */
bool gp_volume_misses(const struct gp_volume *v, struct gp_v3 c,
                      struct gp_v3 e);

/* A light made ready: a ball of its range, a spot's cut by its cone; of a
 * directional one all of space. */
struct gp_reach {
    struct gp_from from;   // place, or direction to it
    double range;          // INFINITY: none
    struct gp_v3 along;    // of a spot
    double cos, sin;       // of a spot's outer half angle; sin 0: no cone
    struct gp_box box;     // around the volume; may be infinite
};

struct gp_reach gp_light_reach(const struct gp_scene_light *light);

/* True where a box (centre c, half sides e) beyond the range cannot be lit. */
bool gp_reach_too_far(const struct gp_reach *r, struct gp_v3 c,
                      struct gp_v3 e);

/* True where a sphere is outside a spot's cone. */
bool gp_reach_beside(const struct gp_reach *r, struct gp_v3 c, double radius);

/* False where the volume cannot meet a frustum. */
bool gp_reach_meets(const struct gp_reach *r, const struct gp_volume *v);

// -- umbras (umbra.c) ---------------------------------------------------------

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

/* True where no light passes through a submesh. */
bool gp_submesh_opaque(const struct gp_scene *s, const struct gp_submesh *p);

/* Convex bodies of a scene's meshes. */
struct gp_bodies {
    int *of_mesh;         // index; -1: none; owned
    struct gp_body *body; // owned
    int bodies;
};

/* Errors: GP_ERR_BUG memory is full. Out: zero; free with gp_bodies_free() in
 * any case. */
GP_MUST_CHECK gp_status gp_bodies_make(const struct gp_log *log,
                                       const struct gp_scene *s,
                                       struct gp_bodies *out);
void gp_bodies_free(struct gp_bodies *b);

/* The umbra of a body: behind its front faces and within the planes through
 * the light and the edges of its silhouette. */
struct gp_umbra {
    int planes; // 0: none
    struct gp_half plane[GP_BODY_EDGES + GP_BODY_FACES];
    double margin; // what is in by less counts as outside: faces that touch
};

/* Makes the umbra of a body moved by `to_world` before a light. It is empty
 * where the light is in the body or in the plane of a flat one. */
void gp_umbra_make(const struct gp_body *body, const double to_world[16],
                   struct gp_from light, struct gp_umbra *out);

/* True where all of a box is in the umbra: of centre c and half sides e. */
static inline bool gp_umbra_holds(const struct gp_umbra *u, struct gp_v3 c,
                                  struct gp_v3 e)
{
    for (int i = 0; i < u->planes; i++) {
        const struct gp_half h = u->plane[i];
        if (gp_half_at(h, c) + gp_half_reach(h, e) > -u->margin)
            return false;
    }
    return u->planes > 0;
}

/* The largest occluders of a light, by the angle that they fill. */
enum { GP_OCCLUDERS = 16 };
struct gp_darkest {
    int n;
    int object[GP_OCCLUDERS];
    double size[GP_OCCLUDERS]; // falling
};

/* Keeps object i where its mesh is a body and it is among the largest; of those
 * of one size the first of the scene. */
void gp_darkest_try(struct gp_darkest *o, const struct gp_scene *s,
                    const struct gp_bodies *b, const struct gp_reach *light,
                    int i);

/* The umbras of a light. */
struct gp_umbras {
    int n;
    struct gp_umbra umbra[GP_OCCLUDERS];
};

/* Makes the umbras of a choice of occluders, those that are not empty. */
void gp_umbras_make(const struct gp_darkest *o, const struct gp_scene *s,
                    const struct gp_bodies *b, const struct gp_reach *light,
                    struct gp_umbras *out);

/* True where an umbra holds a box of centre c and half sides e. */
bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e);

// -- bounds on the screen, and scissors (scissor.c) ---------------------------

/* A box of the world in the picture. */
struct gp_screen_box {
    double x0, y0, x1, y1; // EXR pixel space, not cut by the picture
    double near, far;      // along the view axis, units of the world
    bool seen;             // a part is at `near` or beyond; else the rest is 0
};

/* Returns the bounds of the part of a box at least `near` > 0 along the view
 * axis. They hold every point of it, but for rounding. */
struct gp_screen_box gp_bounds_project(const struct gp_camera *c,
                                       struct gp_rect display,
                                       const struct gp_box *box, double near);

/* Returns the bounds of a light's volume, from `near` on; those of one without
 * a range are a picture of 1e9 pixels. */
struct gp_screen_box gp_reach_project(const struct gp_reach *r,
                                      const struct gp_camera *c,
                                      struct gp_rect display, double near);

/* Returns the pixels whose centres may be in the bounds, cut by `window`. */
struct gp_rect gp_screen_pixels(const struct gp_screen_box *b,
                                struct gp_rect window);

/* Parts by which depths may be wrong: 2^-10 holds those stored as half. */
#define GP_DEPTH_SLACK 0x1p-10

enum { GP_TILE = 16 }; // pixels a side

/* Depths of the frame, by pixels and tiles; INFINITY where there is no
 * surface. */
struct gp_depths {
    struct gp_rect window;
    int across, down;     // tiles; 0: no depth is known, nothing is hidden
    float *pixel;         // owned
    struct gp_depth_tile {
        float least, most; // of all pixels
        float deepest;     // of surfaces; 0: there is none
    } *tile;              // owned
};

/* Copies depths, as of gp_sets_view.
 *   out  empty on failure; free with gp_depths_free()
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_depths_make(const struct gp_log *log,
                                       struct gp_rect window,
                                       const float *depth,
                                       struct gp_depths *out);
void gp_depths_free(struct gp_depths *d);

/* Returns the greatest depth of a surface, with its slack; 0: there is none. */
double gp_depths_deepest(const struct gp_depths *d);

/* True where the box is behind the surfaces of all pixels of its bounds in the
 * window, or of no pixel there: no pixel's centre can show a part of it. */
bool gp_depths_hide(const struct gp_depths *d, const struct gp_screen_box *b);

/* Returns the bounds of the visible points of an object: those of the tiles
 * where the range of depths meets the object's, cut by the window. Without
 * depths the object's own. */
struct gp_screen_box gp_scissor_visible(const struct gp_depths *d,
                                        const struct gp_screen_box *box);

/* Returns the bounds of the visible points of objects within a light's bounds,
 * less the tiles at its sides that have no depth in them; their range of depths
 * is between the least and the greatest of the tiles.
 *   box, n   bounds of visible points, those of `index`
 *   light    the light's
 *   d        its window cuts
 * Source: O'Rorke, GPU Gems 15.5. */
struct gp_scissor gp_scissor_make(const struct gp_depths *d,
                                  const struct gp_screen_box *box,
                                  const int *index, int n,
                                  const struct gp_screen_box *light);

// -- maps of shadows (shadow.c) -----------------------------------------------

/* A light and what it is drawn with: indices of objects. */
struct gp_draw_light {
    const struct gp_scene_light *light;
    const int *shadow, *lit;
    int shadows, lits;
    struct gp_rect cut; // pixels that its pass may change
    const struct gp_rect *own; // ... of each lit object; NULL: cut
    double near, far;   // distances along the view axis that it may change; far
                        // INFINITY: no limit. Counts where the context's info
                        // has depth_bounds
    struct gp_box all;  // of a sun: holds every lit object, the same for every
                        // choice of them: its map is laid over it
};

/* The form of a light's map. */
enum gp_map_form {
    GP_MAP_SPOT,  // one square
    GP_MAP_CUBE,  // six squares, 3 x 2, around a point: +x -x +y -y +z -z
    GP_MAP_SUN,   // one square, parallel light
};

/* The map of one light: how places come to it. */
struct gp_shadow_map {
    enum gp_map_form form;
    int side;            // texels of a square
    double near;         // near plane of SPOT and CUBE
    double to_map[16];   // world, from origin, to clip coordinates; not CUBE
    struct gp_v3 origin; // the light's place; of a sun the middle of its box
    float form_of[4];    // `map` of light.frag
};

/* Lays a map out; `whole` holds every object. Spots wider than 120 degrees get
 * a cube. */
struct gp_shadow_map gp_shadow_map_of(const struct gp_draw_light *l,
                                      const struct gp_box *whole, int side);

/* Returns bits of the squares of a map where a box of the world may be; of a map
 * of one square 0 or 1. */
int gp_shadow_faces(const struct gp_shadow_map *m, const struct gp_box *box);

// -- the paper's renderer (draw.c) --------------------------------------------
//
// A pass of ambient light that sets the depth, then for each light its map of
// shadows and a pass over the lit objects. It draws the objects that it is
// given, in that order, and counts.

struct gp_drawing; // a scene on a context

/* Uploads the posed scene's meshes; its places are read at each draw.
 *   gl, s, c  borrowed
 *   out       written on GP_OK only; end with gp_drawing_close()
 * Errors: GP_ERR_GL what the context refuses; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_drawing_open(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct gp_drawing_params *p, struct gp_drawing **out);
void gp_drawing_close(struct gp_drawing **d);

/* Makes the picture black and infinitely far, and sets the counts to 0. */
void gp_drawing_clear(struct gp_drawing *d);

/* Draws objects in ambient light; may be called several times. */
GP_MUST_CHECK gp_status gp_drawing_ambient(const struct gp_log *log,
    struct gp_drawing *d, const int *object, int n);

/* Draws a light: its map and its pass. One with lits 0 is skipped. */
GP_MUST_CHECK gp_status gp_drawing_light(const struct gp_log *log,
    struct gp_drawing *d, const struct gp_draw_light *l);

/* Waits until all is drawn. */
void gp_drawing_wait(struct gp_drawing *d);

/* Waits, then copies distances along the view axis, w * h, INFINITY where there
 * is no surface; and the picture, w * h * 4, scene-linear. */
void gp_drawing_depth(struct gp_drawing *d, float *z);
void gp_drawing_picture(struct gp_drawing *d, float *rgba);

struct gp_drawn gp_drawing_counts(const struct gp_drawing *d);

#endif
