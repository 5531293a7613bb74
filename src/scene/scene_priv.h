/* Shared by the files of scene and their tests, and private to them: parts of
 * sets, umbras and frusta, the renderer's maps, directions of a disc. */
#ifndef GP_SCENE_SCENE_PRIV_H
#define GP_SCENE_SCENE_PRIV_H

#include "scene/draw.h"
#include "scene/eye.h"
#include "scene/sets.h"

// -- sets, umbras and frusta ------------------------------------------------

/* Returns the volume of the view's window from its near plane to `far`. */
struct gp_volume gp_sets_frustum(const struct gp_sets_view *v, double far);

/* Returns the hull of a light and of the visible points that it may light. */
struct gp_volume gp_sets_hull(const struct gp_sets_view *v,
                              const struct gp_scissor *lit,
                              const struct gp_reach *light);

/* Returns a distance along the view axis over that of every object. */
double gp_sets_far(const struct gp_scene *s, const struct gp_sets_view *v);

/* True where a box cannot meet the volume: it is outside a plane, or of the
 * volume's box. A box of centre c and half sides e. A box that misses all of
 * the volume beside an edge may count as one that meets it, never the other way
 * round. */
bool gp_volume_misses(const struct gp_volume *v, struct gp_v3 c,
                      struct gp_v3 e);

/* An edge from one corner to the other. Seen from outside plane `with` it is in
 * counter-clockwise order, outside `against` clockwise; gp_frustum.turn -1 swaps
 * them. */
struct gp_frustum_edge {
    unsigned char from, to, with, against;
};
extern const struct gp_frustum_edge gp_frustum_edges[12];

/* Finds the body of a mesh: of all of its triangles at once, in any winding.
 * False where they make none: not convex, open but not flat, cut out or
 * transparent, over 64 points or faces. Triangles without area do not count. */
bool gp_body_find(const struct gp_scene *s, int mesh, struct gp_body *out);

/* Makes the umbra of a body moved by `to_world` before a light. It is empty
 * where the light is in the body or in the plane of a flat one. */
void gp_umbra_make(const struct gp_body *body, const double to_world[16],
                   struct gp_from light, struct gp_umbra *out);

// -- maps of the renderer (draw.c, shadow.c) ---------------------------------

enum { GP_FACES = 6 }; // of a point's map: +x -x +y -y +z -z

/* The form of a light's map. */
enum gp_map_form {
    GP_MAP_SPOT,  // one square
    GP_MAP_CUBE,  // six squares, 3 x 2, around a point
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
    // x0, y0, x1, y1 of each square in which a lit point looks, as places in it
    // from -1 to 1; x0 > x1: none does
    double cut[GP_FACES][4];
};

/* Lays a map out; `whole` holds every object. Spots wider than 120 degrees get
 * a cube. */
struct gp_shadow_map gp_shadow_map_of(const struct gp_draw_light *l,
                                      const struct gp_box *whole, int side);

/* Returns bits of the squares of a map where a box of the world may be in the
 * part that is looked at; of a map of one square 0 or 1. */
int gp_shadow_faces(const struct gp_shadow_map *m, const struct gp_box *box);

/* Returns a rectangle around the texels of those squares that are looked at. */
struct gp_rect gp_shadow_cut(const struct gp_shadow_map *m, int faces);

// -- directions of a disc (eye_rays.c, eye_set.c) ----------------------------

/* Returns a texture's alpha at (u, v): bilinear between texel centres on the
 * base level, wrapped. */
double gp_cutout_alpha(const struct gp_cutout *c, double u, double v);

/* The two tests of the set; true when they may meet. */
bool gp_eye_meets_sphere(const struct gp_eye_disc *d, struct gp_v3 centre,
                         double radius);
bool gp_eye_meets_box(const struct gp_eye_disc *d, const struct gp_box *box);

/* A disc, the axes across it, and how its directions are weighed. */
struct gp_eye_measure {
    const struct gp_eye_disc *disc;
    const struct gp_eye_window *window; // NULL: none
    struct gp_v3 across, up;            // unit, upright to disc->to
    bool cut;                           // the window has a part of the disc
                                        // and lacks one
    bool plane;                         // weigh by area in the picture
};

struct gp_eye_measure gp_eye_measure_of(const struct gp_eye_disc *d,
                                        const struct gp_eye_window *window);

/* Returns true when the window shows a unit direction. */
bool gp_eye_inside(const struct gp_eye_measure *m, struct gp_v3 along);

/* Returns the weight of a solid angle around a unit direction. */
double gp_eye_weight(const struct gp_eye_measure *m, struct gp_v3 along);

/* Returns true when one opaque triangle of an object hides all of the disc. */
bool gp_eye_hidden(const struct gp_scene *s, const struct gp_eye_disc *d,
                   const int *object, int objects);

#endif
