// SPDX-License-Identifier: Apache-2.0
/* Parts of relight.c: samples of a frame, albedo of a scene's materials as a
 * frame shows it, and places in a pixel at which a renderer may have looked. */
#ifndef GP_SCENE_RELIGHT_PRIV_H
#define GP_SCENE_RELIGHT_PRIV_H

#include "scene/relight.h"

// -- relight.c ----------------------------------------------------------------

/* Returns the sample of a plane, or 0 outside. */
double gp_surface_sample(const struct gp_plane *p, int x, int y);

/* Returns the distance along the view axis; 0: no surface. */
double gp_surface_depth(const struct gp_surfaces *f, int x, int y);

// -- colours.c ----------------------------------------------------------------

/* Albedo of a pixel that shows one surface. */
struct gp_shade {
    int material;    // -1: of none of the scene
    float albedo[3]; // >= 0, finite
};

/* Albedo of each material, which the frame may scale, tint or texture. All of
 * it is proportional to that of the pixels. */
struct gp_colours {
    double (*of)[3];     // owned; median of its pixels; of fewer than 8, its
                         // base colour in units
    unsigned char *many; // owned; 1: its pixels differ, as by a texture
    double unit;         // > 0; albedo of the pixels over that of base colours
};

/* Makes *out, empty on failure; free with gp_colours_free().
 *   shade  n pixels; are sorted */
GP_MUST_CHECK gp_status gp_colours_make(const struct gp_log *log,
                                        const struct gp_scene *s,
                                        struct gp_shade *shade, size_t n,
                                        struct gp_colours *out);
void gp_colours_free(struct gp_colours *c);

// -- places.c -----------------------------------------------------------------

enum {
    GP_PLACES_BITS = 6,
    GP_PLACES = 1 << GP_PLACES_BITS,
    GP_MEANS = 6, // albedo and normal
};

/* Sets places, pixels from the middle, that have the density of Blender's
 * filter: no two share a row or a column (Hammersley's set), as edges along
 * these are frequent. */
void gp_places_set(double place[GP_PLACES][2]);

/* Weighs places so that their mean comes near the frame's: the renderer's are
 * random, and met its surfaces in other shares (the regression estimator of
 * Deville and Sarndal 1992).
 *   of      albedo, about 1 or less, and unit normal of each place; 0: none
 *   frame   the same of the pixel
 *   weight  >= 0; of sum 1 where none is cut at 0 */
void gp_places_weigh(const double of[GP_PLACES][GP_MEANS],
                     const double frame[GP_MEANS], double weight[GP_PLACES]);

#endif
