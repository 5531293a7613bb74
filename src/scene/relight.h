// SPDX-License-Identifier: Apache-2.0
/* The frame lit by lights of the scene: per-pixel lighting from depth, normal
 * and albedo (O'Rorke 15.2), one pass a light inside its scissor and range of
 * depths, shadows by rays through the objects of S. */
#ifndef GP_SCENE_RELIGHT_H
#define GP_SCENE_RELIGHT_H

#include "core/image.h"
#include "scene/rays.h"
#include "scene/scene.h"

/* A frame, and the surfaces of its pixels. A pixel outside a plane's window has
 * no surface. */
struct gp_surfaces {
    const struct gp_planes *rgb;   // the frame's colour, of pixels `data`
    struct gp_rect data;
    struct gp_camera camera;
    struct gp_rect display;        // of the camera
    const struct gp_plane *z;      // along the view axis, units of the world;
                                   // NaN, <= 0 and >= GP_DEPTH_HUGE: none
    struct gp_plane *normal;       // three: x, y, z; of any length over 0; turned
                                   // in place where only that fits the depth
    bool normal_of_camera;         // axes of the picture: x right, y up, z to
                                   // the eye; else of the world
    const struct gp_plane *albedo; // three: r, g, b; 0: lit by nothing
    const int *object;             // indices of those that may be visible; set
    int objects;                   // by gp_relit_add()
};

/* Passes of one call. */
enum { GP_RELIGHT_PASSES = 8 };

/* A light, and what its pass is drawn with. */
struct gp_relight_pass {
    const struct gp_scene_light *light;
    double light_scale;     // the frame's units a cd or lux
    const int *caster;      // S: indices of objects
    int casters;
    struct gp_rect cut;     // pixels that it can change, EXR pixel space
    double near, far;       // distances along the view axis that it can change
};

/* Adds the light of passes, in their order, to f->rgb:
 *
 *   albedo / pi * light_scale * intensity * colour * cos / d^2 * window * cone
 *
 * with the window and cone that KHR_lights_punctual recommends; a directional
 * light has no d, window and cone. The cosine is that of the pixel's normal,
 * made 1 long.
 *
 * A pixel inside a surface takes one ray for its shadow. Where a shadow ends,
 * and at edges, 64 places have the density of Blender's filter. At edges they
 * show the scene's own surfaces, if these have nearly the pixel's mean normal
 * and albedo, in shares that have them; else its mean is taken apart into the
 * two surfaces beside it. Albedo of the scene's materials is that which the
 * frame shows of them, so that the light added is proportional to the frame's
 * albedo.
 *   meshes  of this scene, kept from call to call
 *   passes  of pass[] and out[], at most GP_RELIGHT_PASSES
 *   out     their pixels that got light, and rays; written on GP_OK only
 * The same bits for any number of threads. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_relight(const struct gp_log *log,
    const struct gp_scene *s, struct gp_meshes *meshes,
    const struct gp_surfaces *f, const struct gp_relight_pass *pass, int passes,
    struct glarepp_relit *out);

// -- lights by name -----------------------------------------------------------

/* A frame that is lit. */
struct gp_relit_frame {
    const char *path;            // for messages
    struct gp_surfaces surfaces; // without their objects
    bool up_unknown;             // nothing but the normals says which axis of
                                 // their world points up
    double light_scale;          // the frame's units a cd or lux; 0: as Blender
};

/* Finds the lights that are named, of which "all" is every one.
 *   asked  set where a light is; zero before; NULL: not wanted
 * Errors: GP_ERR_USAGE no such light. */
GP_MUST_CHECK gp_status gp_relit_find(const struct gp_log *log,
    const struct gp_scene *s, const char *const *name, int names,
    unsigned char *asked);

/* Adds the light of scene lights named in `name` (or "all") to the frame's
 * colour.
 *   s, meshes  posed; meshes are kept from call to call
 *   out        owned by the caller, gp_free(); *lit of them, in the scene's
 *              order; names are borrowed from it
 * Warns of lights that are named and light no pixel, and where all do. Errors:
 * GP_ERR_USAGE no such light; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_relit_add(const struct gp_log *log,
    const struct gp_scene *s, struct gp_meshes *meshes,
    const struct gp_relit_frame *f, const char *const *name, int names,
    struct glarepp_relit **out, int *lit);

#endif
