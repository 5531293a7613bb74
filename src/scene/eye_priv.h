/* Directions of a disc, shared by the two ways to find its share. */
#ifndef GP_SCENE_EYE_PRIV_H
#define GP_SCENE_EYE_PRIV_H

#include "scene/eye.h"

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
