/* Visibility as sets, by flags on objects (O'Rorke, GPU Gems 15.3 and 15.4.3,
 * second way): what is drawn in the passes of a frame and of each of its lights.
 *
 * Every set is conservative: an object that a visible point, or a ray from one
 * to a light, meets is in it; some are in it in vain.
 *
 *   F  in the frustum
 *   V  in F, and not hidden by the frame's depth
 *   L  in a light's reach and cone, and not wholly in the umbra of its largest
 *      occluders
 *   I  V and L: lit anew; with a scissor, less those that show nothing in it
 *   S  casts shadows: L in the hull of the light and of what it lights */
#ifndef GP_SCENE_SETS_H
#define GP_SCENE_SETS_H

#include "scene/scene.h"
#include "scene/scissor.h"
#include "scene/umbra.h"

enum {
    GP_SET_F = 1,
    GP_SET_V = 2,
    GP_SET_L = 4,
    GP_SET_I = 8,
    GP_SET_S = 16,
};

/* Parts of visibility, each a row of Table 15-1. Without any V is F, L the
 * reach, S is L, and the scissor is the window. */
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
    const float *depth;     // of the window's pixels, as gp_hidden_make(); NULL:
                            // unknown. A pixel's visible point is at its depth
    double texel;           // widest angle, radians (of directional lights
                            // length, units of the world), between a lookup in
                            // a shadow map and the ray that it is for; 0: none
};

/* The sets of a frame and of one light at a time. */
struct gp_sets;

/* Finds F and V.
 *   scene, bodies  borrowed until gp_sets_close(); posed
 *   view           its depth is borrowed until this returns
 *   use            GP_SETS_*
 *   out            NULL on failure
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_sets_open(const struct gp_log *log,
                                     const struct gp_scene *scene,
                                     const struct gp_bodies *bodies,
                                     const struct gp_sets_view *view,
                                     unsigned use, struct gp_sets **out);
void gp_sets_close(struct gp_sets **sets);

/* Finds L, I, S and the scissor of a light, in place of those of the last one.
 * False: nothing that is visible can be lit; I and S are empty, L may be. With
 * GP_SETS_DEPTHS the depths decide, and I may be empty in any case. */
bool gp_sets_light(struct gp_sets *sets, int light);

/* Returns GP_SET_* of each object; changes with gp_sets_light(). */
const uint8_t *gp_sets_flags(const struct gp_sets *sets);

/* Returns the scissor of the light; empty where nothing is lit. */
struct gp_scissor gp_sets_scissor(const struct gp_sets *sets);

/* Returns the part of that scissor in which an object of V can show a point. */
struct gp_rect gp_sets_scissor_of(const struct gp_sets *sets, int object);

/* Returns how many batches draw a set once: the submeshes of its meshes
 * (15.2.2). `merged`: shadow batches, the opaque submeshes of an object in one.
 * A frame has those of V, and for each light those of S and of I. */
int gp_sets_batches(const struct gp_sets *sets, unsigned set, bool merged);

/* Returns boxes of the world that hold every visible point of the scissor that
 * is in the light's reach, for as long as its sets; *n 0: none, or these may be
 * anywhere, as without GP_SETS_SHADOWS or depths. */
const struct gp_box *gp_sets_seen(const struct gp_sets *sets, int *n);

#endif
