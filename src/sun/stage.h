// SPDX-License-Identifier: Apache-2.0
/* Suns and lamps of a run. For each frame, in this order: gp_suns_find(),
 * gp_suns_hide(), gp_suns_measure(), gp_suns_join() with the engines,
 * gp_suns_draw(), gp_suns_end_frame(). */
#ifndef GP_SUN_STAGE_H
#define GP_SUN_STAGE_H

#include "core/image.h"
#include "core/status.h"
#include "gl/gl.h"
#include "glare/kernel.h"
#include "glare/sources.h"
#include "sun/flare.h"
#include "sun/lights.h"
#include "sun/mask/mask.h"
#include "sun/occluder.h"

#include <stdbool.h>

/* Reads the image of a flare element; `user` as given beside it. */
typedef gp_status (*gp_sun_picture)(void *user, const struct gp_log *log,
                                    const char *path, struct gp_image *out);

struct gp_suns {
    // of the run
    bool given; // lights may have places; set by the caller, before all calls
    const struct glarepp_light_params *p; // borrowed
    enum gp_gl_api api;
    struct glarepp_light *spec;  // owned; of p and of its file: those that
    int specs;                   // have a place, and then
    struct glarepp_light *track; // ... those to be found, in each frame that
    int tracks;                  // is given,
    struct glarepp_light *known; // owned; ... and in this one
    int knowns;
    struct gp_camera_file cameras;
    struct gp_flare flare;      // its images read
    struct gp_projection wide;  // of a frame that no plain camera makes, set
                                // before gp_suns_find(); PLANE: it is none
    double more_fov;            // degrees, of the scene's camera; 0: none
    bool warned_clear, warned_window; // that nothing hides the lights; that a
                                      // plane does not cover the frame
    struct gp_gl *gl;
    struct gp_sun_map map;
    // of the frame
    // of a scene: set by the caller, before gp_suns_find(); borrowed
    const struct glarepp_light *more; // lights that join those of the run
    int mores;
    const struct gp_camera *camera; // of frames that have none; NULL: none
    struct gp_occluders occluders;
    struct gp_light *light; // owned; those found come after
    int n, placed;          // ... so many
};

/* Reads the files of *p, before the first frame.
 *   p    must stay as long as *out
 *   out  zero but for `given`; freed by gp_suns_close() in any case
 * Errors: those of `picture`; GP_ERR_USAGE elements of lights, and no light
 * with flux. */
GP_MUST_CHECK gp_status gp_suns_begin(
    const struct gp_log *log, const struct glarepp_light_params *p, enum gp_gl_api api,
    gp_sun_picture picture, void *user, struct gp_suns *out);

/* The camera of a frame, of --camera or of its own attributes, where one is *found.
 * Errors: GP_ERR_DATA a frame that --camera does not have; those of
 * gp_camera_make(). */
GP_MUST_CHECK gp_status gp_suns_camera(const struct gp_log *log,
    const struct gp_suns *suns, const struct glarepp_frame_params *about,
    const struct gp_image *f, struct gp_camera *out, bool *found);

/* Gives each light its place. Errors: GP_ERR_USAGE, and GP_ERR_DATA a frame that
 * the cameras do not have, or one without a sun there where p->needed and no
 * other light is given. */
GP_MUST_CHECK gp_status gp_suns_find(const struct gp_log *log,
    const struct glarepp_frame_params *about, const struct gp_image *f,
    struct gp_suns *suns);

/* Adds lights that the frame shows, after gp_sense(): those with names of `known`,
 * and up to `most` in all; others are new1, new2, ... or, where `known` is empty,
 * lamp1, lamp2, .... None has its centre on the disc of a light with a place.
 * *wide as gp_lights_find() has it. */
GP_MUST_CHECK gp_status gp_suns_spot(const struct gp_log *log,
                                     const struct gp_sources *src,
                                     const struct gp_image *f,
                                     const struct glarepp_light *known,
                                     int knowns, int most, bool *wide,
                                     struct gp_suns *suns);

/* Notes what may hide the lights: planes, or deep pixels in their place, borrowed to
 * the end of the frame, or NULL. Warns of one with a name, that of another file, which
 * does not cover the frame. */
void gp_suns_hide(const struct gp_log *log, const struct gp_image *f,
                  const struct gp_plane *depth, const struct gp_plane *mask,
                  const struct gp_deep *deep, struct gp_suns *suns);

/* Measures the visibility of each light. Errors: GP_ERR_GL, GP_ERR_BUG. */
GP_MUST_CHECK gp_status gp_suns_measure(const struct gp_log *log,
                                        struct gp_suns *suns);

/* Pixels of a turn where the frame is a sphere, else 0. */
double gp_suns_around(const struct gp_suns *suns);

/* Returns the pixels over which a light has its flux, at least one's: those of its disc
 * *there, in its place; in a wide picture as many as its solid angle has in the middle,
 * so that a light that turns with its sphere keeps its glare. */
double gp_suns_pixels(const struct gp_suns *suns, const struct gp_light *l,
                      double *there);

/* Returns true when a light has flux; `seen`: and is not hidden. */
bool gp_suns_have_light(const struct gp_suns *suns, bool seen);

/* The largest offsets in x and y from a light that gp_suns_draw() draws to a pixel of
 * the frame, as far as the kernel must reach; 0: no such light. */
void gp_suns_offsets(const struct gp_suns *suns, struct gp_rect data,
                     int offset[2]);

/* Joins the sources and the visible light that lights have in the frame's pixels:
 * those of a disc have shares of flux * visibility, moved to its place by bilinear
 * shares, which keep flux and centroid. Without a light *out stays as it is. */
GP_MUST_CHECK gp_status gp_suns_join(const struct gp_log *log,
    const struct gp_suns *suns, const struct gp_image *f,
    const struct gp_sources *src, struct gp_sources *out);

/* Adds the glare of light beyond the frame's pixels to f->layer, which is made.
 * Errors: GP_ERR_DATA a radius over 1024 pixels; those of gp_kernel_spread(). */
GP_MUST_CHECK gp_status gp_suns_draw(const struct gp_log *log,
    struct gp_suns *suns, const struct gp_kernel *kernel, struct gp_image *f);

/* Returns the mean visibility, weighted by flux where lights have any. */
double gp_suns_mean(const struct gp_suns *suns);

/* Frees the frame's part. */
void gp_suns_end_frame(struct gp_suns *suns);
void gp_suns_close(struct gp_suns *suns);

#endif
