// SPDX-License-Identifier: Apache-2.0
/* O'Rorke, "Managing visibility for per-pixel lighting", GPU Gems chapter 15:
 * which objects matter to a frame and to each of its lights, the paper's
 * renderer, and its Table 15-1.
 *
 * Every set is conservative: an object that a visible point, or a ray from one
 * to a light, meets is in it; some are in it in vain.
 *
 *   F  in the frustum
 *   V  in F, and not hidden by the frame's depth
 *   L  in a light's range and cone, and not wholly in the umbra of its largest
 *      occluders
 *   I  V and L: lit anew
 *   S  casts shadows: L in the hull of the light and of what it lights */
#ifndef GP_SCENE_SETS_H
#define GP_SCENE_SETS_H

#include "core/image.h"
#include "gl/gl.h"
#include "glarepp.h"
#include "scene/scene.h"

enum {
    GP_SET_F = 1,
    GP_SET_V = 2,
    GP_SET_L = 4,
    GP_SET_I = 8,
    GP_SET_S = 16,
};

/* Parts of visibility, each a row of Table 15-1. Without any V is F, L the
 * range, S is L, and the scissor is the window. */
enum {
    GP_SETS_OCCLUSION = 1, // V by depth
    GP_SETS_LIGHTS = 2,    // L by umbras
    GP_SETS_SHADOWS = 4,   // S by the hull
    GP_SETS_SCISSOR = 8,
    GP_SETS_ALL = 15,
    // as well: the depths may show surfaces that no object has. A light and its
    // scissor are those of all surfaces within its bounds, not of I
    GP_SETS_DEPTHS = 16,
};

/* A frame, as far as sets need it. */
struct gp_sets_view {
    struct gp_camera camera;
    struct gp_rect display; // of the camera
    struct gp_rect window;  // pixels that are drawn, none empty
    double near;            // > 0, units of the world along the view axis: no
                            // visible point is nearer
    const float *depth;     // of the window's pixels, along the view axis, units
                            // of the world; NaN, <= 0 and >= GP_DEPTH_HUGE: no
                            // surface; NULL: unknown
    double texel;           // widest angle, radians (of directional lights
                            // length, units of the world), between a lookup in
                            // a shadow map and the ray that it is for; 0: none
};

/* Pixels and a range of depths; empty: rect is, and the rest is 0. */
struct gp_scissor {
    struct gp_rect rect;
    double near, far;   // along the view axis, units of the world
};

/* The sets of a frame and of one light at a time. */
struct gp_sets;

/* Finds F and V.
 *   scene  posed; borrowed until gp_sets_close()
 *   view   its depth is borrowed until this returns
 *   use    GP_SETS_*
 *   out    NULL on failure */
GP_MUST_CHECK gp_status gp_sets_open(const struct gp_log *log,
                                     const struct gp_scene *scene,
                                     const struct gp_sets_view *view,
                                     unsigned use, struct gp_sets **out);
void gp_sets_close(struct gp_sets **sets);

/* Finds V by other depths, as of gp_sets_view. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_sets_look(const struct gp_log *log,
                                     struct gp_sets *sets, const float *depth);

/* Finds L, I, S and the scissor of a light, in place of those of the last one.
 * Returns the scissor, the bounds of what it may light. Empty: nothing that is
 * visible can be lit; I and S are empty, L may be. With GP_SETS_DEPTHS the
 * depths decide, and I may be empty in any case. */
struct gp_scissor gp_sets_light(struct gp_sets *sets, int light);

/* Returns GP_SET_* of each object; changes with gp_sets_light(). */
const uint8_t *gp_sets_flags(const struct gp_sets *sets);

/* Returns the part of the scissor in which an object of V can show a point. */
struct gp_rect gp_sets_scissor_of(const struct gp_sets *sets, int object);

/* Returns how many batches draw a set once: the submeshes of its meshes
 * (15.2.2). A frame has those of V, and for each light those of S and of I. */
int gp_sets_batches(const struct gp_sets *sets, unsigned set);

// -- the renderer and its table -----------------------------------------------

/* Rows of Table 15-1: row n has the first n parts of GP_SETS_ALL. */
enum { GP_TABLE_ROWS = 5 };

struct gp_table {
    struct glarepp_sets_row row[GP_TABLE_ROWS];
    float *picture;              // w * h * 4, scene-linear; owned
    struct gp_scissor *light;    // of the last row's lights; owned
    unsigned char *set;          // of all objects: GP_SET_*, I and S of any
                                 // light; owned
};

/* Draws all rows; every one draws the same picture.
 *   s    posed
 *   p    of these its camera, scene and GL are not looked at
 *   out  written on GP_OK only; free with gp_table_free()
 * V by depth: the objects that look largest are drawn first, V is found by
 * their depth and drawn, and found again by the depth of the whole picture for
 * the lights. Errors: GP_ERR_GL what the context refuses; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_table_make(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct glarepp_sets_params *p, struct gp_table *out);
void gp_table_free(struct gp_table *t);

// -- pictures -----------------------------------------------------------------
//
// w * h samples in each of three planes, display-linear.

/* Draws the outlines of the lights' scissors over the picture. */
void gp_sets_draw_scissors(const struct gp_table *t, int lights, int w, int h,
                           const struct gp_planes *rgb);

/* Draws the scene from above, each object in the colour of its sets. It shows
 * the eye, lamps and objects; boxes that leave it end at its edge. */
void gp_sets_draw_map(const struct gp_table *t, const struct gp_scene *s,
                      const struct gp_camera *c, int w, int h,
                      const struct gp_planes *rgb);

#endif
