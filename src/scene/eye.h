/* Lights as discs before the eye: the objects between, and the share of a disc
 * that they leave clear. For lights that the frame does not show (Maughan, Game
 * Programming Gems 3, 5.5: his culling frustum, his alternative of rays, and
 * his sun map from geometry). */
#ifndef GP_SCENE_EYE_H
#define GP_SCENE_EYE_H

#include "gl/gl.h"
#include "scene/rays.h"
#include "scene/scene.h"

/* A light as the eye sees it: the directions within `half` of `to`. */
struct gp_eye_disc {
    struct gp_v3 eye, to;  // to: unit
    double half;           // half angle, radians, 0 to pi / 2
    double distance;       // of a lamp from the eye; INFINITY: a sun
    double ball;           // radius of a lamp; sin(half) = ball / distance
};

/* A sun towards `to`, which is not 0; its half angle in radians is cut to
 * [0, pi / 2]. */
struct gp_eye_disc gp_eye_sun(struct gp_v3 eye, struct gp_v3 to, double half);

/* A lamp at a place. Within its ball the eye sees it in every direction before
 * it: half is pi / 2, and nothing is nearer. */
struct gp_eye_disc gp_eye_lamp(struct gp_v3 eye, struct gp_v3 at, double ball);

/* The set E: objects whose sphere and box meet the cone from the eye over the
 * disc, and are nearer than a lamp. No object that hides a part of the disc is
 * left out; one that is kept may hide nothing.
 *   object  room for s->objects; their indices, ascending
 * Returns how many. */
int gp_eye_set(const struct gp_scene *s, const struct gp_eye_disc *d,
               int *object);

/* The part of the picture that the frame itself answers for. */
struct gp_eye_window {
    const struct gp_camera *camera; // its eye is the disc's
    struct gp_rect display;         // as for gp_camera_project()
    struct gp_rect known;           // pixels; empty: none
};

/* Numbers that gp_eye_rays() and gp_eye_map_draw() find. */
struct gp_eye_share {
    double clear;   // share of the disc's part outside the window that shows,
                    // 0 to 1; 1 where no part is outside
    double outside; // share of the disc outside the window, 0 to 1
    double error;   // of `clear`: one standard deviation of the samples, at
                    // most
    int samples;    // a side, of the disc's square; 0: no object is before it
    int objects;    // of E
};

/* Casts rays in double through the triangles of E; materials are tested as
 * rays.h says. One ray for a disc of no size.
 *
 * A side of 64 rays, jittered in cells of equal solid angle by a fixed pattern,
 * is doubled up to 256 until `error` is at most 5e-4. The disc's part outside
 * the window counts by area in the picture where the window cuts it, as that
 * inside does, and else by solid angle.
 *   meshes  of this scene, kept from call to call; NULL: made and freed
 *   window  NULL: no part is known
 *   out     written on GP_OK only
 * The same bits for any number of threads. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_eye_rays(
    const struct gp_log *log, const struct gp_scene *s,
    struct gp_meshes *meshes, const struct gp_eye_disc *d,
    const struct gp_eye_window *window, struct gp_eye_share *out);

/* Triangles that a map draws, at most. Rays need one tree of a mesh, however many
 * nodes place it. */
enum { GP_EYE_DRAWN = 1 << 18 };

/* Programs and targets on a context; kept from frame to frame. */
struct gp_eye_map;

/* Draws a sun map from geometry (Maughan, step 3): the viewer at the eye looks
 * at the light, whose square fills the map; the sun is white, the objects of E
 * black, alpha tested, without depth; the front plane is at the eye, or at
 * 5e-4 of a lamp's distance, the back plane at the edge of a lamp's ball.
 * Nothing is drawn where one triangle hides all. The map is read back, and
 * texels whose centres are in the disc count as gp_eye_rays() counts.
 *   side   texels, cut to [2, 256]
 *   state  made at the first call; of one scene; gp_eye_map_close()
 * Discs of no size, or of a half angle over 1 radian, and objects of more than
 * GP_EYE_DRAWN triangles together are left to gp_eye_rays(). Errors: GP_ERR_GL; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_eye_map_draw(
    const struct gp_log *log, const struct gp_gl *gl, const struct gp_scene *s,
    struct gp_meshes *meshes, const struct gp_eye_disc *d,
    const struct gp_eye_window *window, int side,
    struct gp_eye_map **state, struct gp_eye_share *out);
void gp_eye_map_close(const struct gp_gl *gl, struct gp_eye_map **state);

#endif
