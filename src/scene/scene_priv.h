/* Shared by the files of scene and their tests, and private to them. */
#ifndef GP_SCENE_SCENE_PRIV_H
#define GP_SCENE_SCENE_PRIV_H

#include "scene/eye.h"

/* Returns a texture's alpha at (u, v): bilinear between texel centres on the
 * base level, wrapped. */
double gp_cutout_alpha(const struct gp_cutout *c, double u, double v);

/* The set E: objects whose sphere meets the cone from the eye over the disc, and
 * is nearer than a lamp. No object that hides a part of the disc is
 * left out; one that is kept may hide nothing.
 *   object  room for s->objects; their indices, ascending
 * Returns how many. */
int gp_eye_set(const struct gp_scene *s, const struct gp_eye_disc *d,
               int *object);

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

#endif
