// SPDX-License-Identifier: Apache-2.0
/* Lights as discs before the eye: the objects between, and the share of a disc
 * that they leave clear. For lights that the frame does not show (Maughan, Game
 * Programming Gems 3, 5.5: his culling frustum, and his alternative of rays.
 * His sun map from geometry took 16 to 140 times as long on llvmpipe, and was
 * up to 0.005 off where rays are within 0.0002). */
#ifndef GP_SCENE_EYE_H
#define GP_SCENE_EYE_H

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

/* The part of the picture that the frame itself answers for. */
struct gp_eye_window {
    const struct gp_camera *camera; // its eye is the disc's
    struct gp_rect display;         // as for gp_camera_project()
    struct gp_rect known;           // pixels; empty: none
    bool turned; // it asks for the part of a disc inside of it
};

/* Shares that gp_eye_rays() finds, 0 to 1. The error is one standard deviation of the
 * samples, at most; a ray's share, or more, where triangles are before the disc. */
struct gp_eye_share {
    double clear; // of the disc's part outside the window; 1: no part is
    double part;  // of the disc that is outside
    double error; // of `clear`
};

/* Casts rays in double through the triangles of E; materials are tested as
 * rays.h says. One ray for a disc of no size.
 *
 * A side of 64 rays, jittered in cells of equal solid angle by a fixed pattern,
 * is doubled up to 256 until `error` is at most 5e-4. The disc's part outside
 * the window counts by area in the picture where the window cuts it, as that
 * inside does, and else by solid angle.
 *   meshes  of this scene, kept from call to call
 *   window  NULL: no part is known
 *   out     written on GP_OK only
 * The same bits for any number of threads. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_eye_rays(
    const struct gp_log *log, const struct gp_scene *s,
    struct gp_meshes *meshes, const struct gp_eye_disc *d,
    const struct gp_eye_window *window, struct gp_eye_share *out);

#endif
