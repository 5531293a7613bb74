// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of scene/sets and their tests, and private to them:
 * planes, umbras, the renderer. */
#ifndef GP_SCENE_SETS_PRIV_H
#define GP_SCENE_SETS_PRIV_H

#include "scene/sets/sets.h"

// -- planes, umbras (umbra.c) -------------------------------------------------

/* A light's place for hulls and umbras: at w = 1 a point, at w = 0 the unit
 * direction to a light at infinity. */
struct gp_from {
    struct gp_v3 p;
    double w;
};

/* Returns the way from a place to a light. */
static inline struct gp_v3 gp_from_to(struct gp_from light, struct gp_v3 p)
{
    return gp_v3_sub(light.p, gp_v3_scale(p, light.w));
}

/* A half-space: n . p + d <= 0 is inside; n is a unit vector that points out. */
struct gp_half {
    struct gp_v3 n;
    double d;
};

static inline double gp_half_at(struct gp_half h, struct gp_v3 p)
{
    return gp_v3_dot(h.n, p) + h.d;
}

/* Returns the distance of a light before a plane; of one at infinity the
 * cosine. Over 0 is outside. */
static inline double gp_half_before(struct gp_half h, struct gp_from light)
{
    return gp_v3_dot(h.n, light.p) + light.w * h.d;
}

/* Returns how far a box of half sides e reaches along a plane's normal. */
static inline double gp_half_reach(struct gp_half h, struct gp_v3 e)
{
    return fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
}

/* Finds the plane of p, a and b, with `inside` in it. False: a and b are along
 * one line, and *out is all of space. */
bool gp_half_span(struct gp_v3 p, struct gp_v3 a, struct gp_v3 b,
                  struct gp_v3 inside, struct gp_half *out);

/* Bodies of a scene's meshes, and the umbras that they throw before one light:
 * a body is a closed convex polyhedron of at most 64 points, opaque. */
struct gp_umbras;

/* Out: NULL; close it in any case. */
GP_MUST_CHECK gp_status gp_umbras_open(const struct gp_log *log,
                                       const struct gp_scene *s,
                                       struct gp_umbras **out);
void gp_umbras_close(struct gp_umbras **u);

/* Makes the umbras of the objects with GP_SET_L that are bodies and look
 * largest from a light; of those of one size of the first of the scene. `flag`
 * NULL: of none. */
void gp_umbras_light(struct gp_umbras *u, const uint8_t *flag,
                     struct gp_from light);

/* True where an umbra holds a box of centre c and half sides e. */
bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e);

// -- the paper's renderer (draw.c) --------------------------------------------
//
// A pass of ambient light that sets the depth, then for each light its map of
// shadows and a pass over the lit objects. It draws the objects that it is
// given, in that order, and counts.

/* A light and what it is drawn with: indices of objects. */
struct gp_draw_light {
    const struct gp_scene_light *light;
    const int *shadow, *lit;
    int shadows, lits;
    struct gp_rect cut; // pixels that its pass may change
    const struct gp_rect *own; // ... of each lit object; NULL: cut
    struct gp_box all;  // of a sun: holds every lit object, the same for every
                        // choice of them: its map is laid over it
};

struct gp_drawing; // a scene on a context

/* Uploads the posed scene's meshes; its places are read at each draw.
 *   log, gl, s, c  borrowed
 *   out       written on GP_OK only; end with gp_drawing_close()
 * Errors: GP_ERR_GL what the context refuses; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_drawing_open(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct glarepp_sets_params *p, struct gp_drawing **out);
void gp_drawing_close(struct gp_drawing **d);

/* Makes the picture black and infinitely far. Lights, passes and batches, which
 * are draw calls, are added to *counts from then on. */
void gp_drawing_clear(struct gp_drawing *d, struct glarepp_sets_row *counts);

/* Draws objects in ambient light; may be called several times. */
GP_MUST_CHECK gp_status gp_drawing_ambient(struct gp_drawing *d,
                                           const int *object, int n);

/* Draws a light: its map and its pass. One with lits 0 is skipped. */
GP_MUST_CHECK gp_status gp_drawing_light(struct gp_drawing *d,
                                         const struct gp_draw_light *l);

/* Waits until all is drawn. */
void gp_drawing_wait(struct gp_drawing *d);

/* Waits, then copies distances along the view axis, w * h, INFINITY where there
 * is no surface; and the picture, w * h * 4, scene-linear. */
void gp_drawing_depth(struct gp_drawing *d, float *z);
void gp_drawing_picture(struct gp_drawing *d, float *rgba);

#endif
