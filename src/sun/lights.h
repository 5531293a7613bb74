// SPDX-License-Identifier: Apache-2.0
/* Suns, lamps and cameras: from JSON, and their places in a frame. */
#ifndef GP_SUN_LIGHTS_H
#define GP_SUN_LIGHTS_H

#include "core/camera.h"
#include "core/depth.h"
#include "core/image.h"
#include "core/status.h"
#include "glarepp.h"

#include <math.h>
#include <stdbool.h>

enum {
    GP_LIGHTS_MAX = 1024, // of one frame
    GP_LIGHT_NAME = 64,   // bytes of a name, with its null byte
};

/* A light's disc in the world, as the camera sees it. */
struct gp_light_sight {
    bool known;        // the frame has a camera; else the rest is 0
    bool lamp;         // `at` is a place; else a direction, not 0
    double at[3];
    double half;       // half angle of the disc, radians, 0 to pi / 2
};

/* A light in one frame. */
struct gp_light {
    double x, y;       // centre, EXR pixel space; y down
    double radius;     // pixels, >= 0
    double wide;       // its disc's width over its height, >= 1, or 0: 1; the
                       // radius is the geometric mean of both halves
    double depth;      // nearer surfaces hide it: in scene units as the depth
                       // channel counts them (along the view axis or along
                       // the ray; for normalized depth in its 0 to 1);
                       // INFINITY: a sun, beyond everything
    double bias;       // fraction of depth that may be nearer and hides nothing
    float flux[3];     // scene-linear, summed over pixels, >= 0
    char name[GP_LIGHT_NAME]; // for flare of some lights; "": none
    bool behind;       // the camera: is drawn nowhere, shows nothing but what
                       // GLAREPP_BY_SCENE says
    double outside;    // share of its part outside the frame that is clear, 0
                       // to 1; for GLAREPP_BY_SCENE
    bool traced;       // ... of all of it, where another rule is with that rule
    double outside_error; // of it, at most
    double visibility; // 0 hidden to 1 clear; written by exact and map
    double low, high;  // of the true share; written by gp_sun_interval()
    bool in_frame;     // the frame has a part of it; written with them
    struct gp_light_sight sight;
    bool found; // the frame shows it (sun/found.h): no glare of its own,
                // and nothing hides it
};
#define GP_LIGHT_DEFAULTS \
    { .radius = 0.5, .depth = INFINITY, .bias = 1e-3, .visibility = 1.0 }

/* Its disc becomes a circle of the same area where x is divided by this, and y
 * multiplied. */
static inline double gp_light_stretch(const struct gp_light *l)
{
    return sqrt(fmax(l->wide, 1.0));
}

/* Returns true when it has flux: glare of its own, flare. */
static inline bool gp_light_has_flux(const struct gp_light *l)
{
    return !l->behind && (l->flux[0] > 0.0f || l->flux[1] > 0.0f ||
                          l->flux[2] > 0.0f);
}

/* Reads lights from JSON, at most GP_LIGHTS_MAX; man/glarepp.1.in has its form.
 * *out is owned by the caller (gp_free()), written on GP_OK only; *n may be 0: one
 * that is "found" has an item for each of its frames. Errors: GP_ERR_IO; GP_ERR_DATA
 * (names file, light and key), also for files over 8 MiB. */
GP_MUST_CHECK gp_status gp_lights_read(const struct gp_log *log,
    const char *path, struct glarepp_light **out, int *n);

/* Gives a light its place in a frame. The depth of "world" is distance along
 * the axis for z and inverse, along the ray for ray; for normalized it cannot
 * be known: GP_ERR_DATA asks for "depth". A lamp's own ball is in the depth
 * channel of many frames: it hides nothing, as the bias grows by the ball's
 * radius over the depth.
 *   c     NULL: no camera; GP_ERR_USAGE when the place needs one (says that
 *         the frame has no worldToNDC, and that --camera gives one)
 *   path  of the frame, for the message
 *   out   written on GP_OK only; visibility 1 until it is measured */
GP_MUST_CHECK gp_status gp_light_place_in(
    const struct gp_log *log, const char *path,
    const struct glarepp_light *spec, const struct gp_camera *c,
    enum glarepp_depth type, struct gp_rect display, struct gp_light *out);

/* The cameras of a sequence, and the sun, from JSON; man/glarepp.1.in has its
 * form. worldToCamera_rowmajor is for row vectors; worldToNDC_blender_colvec is
 * for column vectors, rows first, GLAREPP_NDC_CLIP; worldToNDC_rowmajor, for row
 * vectors and GLAREPP_NDC_SPEC, may replace it. All other keys are ignored. */
struct gp_camera_frame {
    long long frame;
    struct gp_camera camera;
    bool has_sun;
    double sun_dir[3];
    double sun_radius;   // pixels; 0: not given
};
struct gp_camera_file {
    struct gp_camera_frame *at; // owned
    int n;
    double width;        // of the pictures that radii are for; 0: not given
};

/* Files over 8 MiB (some 5000 frames) are refused.
 *   out  written on GP_OK only, by frame number; gp_camera_file_free()
 * Errors: GP_ERR_IO; GP_ERR_DATA not JSON, no frames, a frame without matrix
 * or number, two of one number (each names the frame), what gp_camera_make()
 * refuses, a direction of 0, a radius outside 0 to 1e6. */
GP_MUST_CHECK gp_status gp_camera_read(
    const struct gp_log *log, const char *path, struct gp_camera_file *out);
void gp_camera_file_free(struct gp_camera_file *f);

/* Returns the camera of frame `number`, or the only one of the file; else
 * NULL. */
const struct gp_camera_frame *
gp_camera_frame_find(const struct gp_camera_file *f, long long number);

#endif
