/* Parts of the renderer. */
#ifndef GP_SCENE_DRAW_PRIV_H
#define GP_SCENE_DRAW_PRIV_H

#include "scene/draw.h"

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

/* Returns a * b, of matrices for row vectors: first a, then b. */
void gp_matrix_mul(const double a[16], const double b[16], double out[16]);

#endif
