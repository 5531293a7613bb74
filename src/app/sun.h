/* Suns and lamps of a run: who they are, where they stand in a frame, how much
 * of each shows, and the light that they bring. */
#ifndef GP_APP_SUN_H
#define GP_APP_SUN_H

#include "app/jobs.h"
#include "app/settings.h"
#include "core/frame.h"
#include "glare/sources.h"
#include "glare/kernel.h"
#include "glare/sensors.h"
#include "gl/gl.h"
#include "sun/camera.h"
#include "sun/flare.h"
#include "sun/lights.h"
#include "sun/map.h"
#include "sun/occluder.h"

#include <stdbool.h>

/* The kernel spread over a light's disc, drawn as a flare element at the
 * light's own place. */
struct gp_sun_sprite {
    double radius;
    struct gp_flare_element element;
    struct gp_flare_gl *drawn;
};
enum { GP_SUN_SPRITES = 64 }; // kept at once

struct gp_suns {
    // of the run
    struct gp_light_spec *spec; // owned; the sun of the command line first
    int specs;
    struct gp_camera_file cameras;
    struct gp_flare flare;      // its images read
    bool told_clear;            // that nothing says what hides the lights
    bool told_window;           // that a plane does not cover the frame
    // on GL, kept from frame to frame
    struct gp_gl *gl;
    struct gp_sun_map *map;
    struct gp_flare_gl *drawn;
    struct gp_sun_sprite sprite[GP_SUN_SPRITES];
    int sprites;
    unsigned long sprite_kernel; // serial of the kernel they are made of
    // of the frame
    struct gp_plane depth, mask;
    struct gp_occluders occluders;
    struct gp_light *light;     // owned
    int n;
    bool early;  // the mask's shares were read before the engines ran
};

/* Whether the command line names a light. */
bool gp_suns_wanted(const struct gp_sun_settings *s);

/* Reads what the command line names, before the first frame.
 *   out  zero; freed by gp_suns_close() in any case
 * Errors: those of the readers. */
GP_MUST_CHECK gp_status gp_suns_begin(const struct gp_log *log,
                                      const struct gp_settings *s,
                                      struct gp_suns *out);

/* Reads the frame's depth and coverage, and gives each light its place.
 * Errors: GP_ERR_USAGE, GP_ERR_DATA, GP_ERR_IO of the readers; GP_ERR_DATA a
 * frame that --camera does not have. */
GP_MUST_CHECK gp_status gp_suns_place(const struct gp_log *log,
                                      const struct gp_settings *s,
                                      const struct gp_job *job,
                                      const struct gp_frame *f,
                                      struct gp_suns *suns);

/* Finds how much of each light shows. With the mask the answer stays on GL
 * until gp_suns_draw(), unless suns->early. Errors: GP_ERR_GL, GP_ERR_BUG. */
GP_MUST_CHECK gp_status gp_suns_see(const struct gp_log *log,
                                    const struct gp_settings *s,
                                    struct gp_suns *suns);

/* Whether any light needs the kernel, for glare of its own. */
bool gp_suns_glare(const struct gp_suns *suns);

/* Whether gp_suns_draw() may have light to add: lights with flux that are not
 * known to be hidden. */
bool gp_suns_add_light(const struct gp_settings *s,
                       const struct gp_suns *suns);

/* The sources and the visible light of those lights that go through the
 * engines: none with the mask, whose share is not known yet, and none that
 * reaches beyond the frame. *joined says whether *out was made. */
GP_MUST_CHECK gp_status gp_suns_join(const struct gp_log *log,
                                     const struct gp_settings *s,
                                     const struct gp_suns *suns,
                                     const struct gp_frame *f,
                                     const struct gp_sources *src,
                                     struct gp_sources *out, bool *joined);

/* Adds to f->layer, which is made, what did not go through the engines: lens
 * flare, and glare of the other lights. All visibilities are known then. */
GP_MUST_CHECK gp_status gp_suns_draw(const struct gp_log *log,
                                     const struct gp_settings *s,
                                     struct gp_suns *suns,
                                     const struct gp_kernel *kernel,
                                     struct gp_frame *f);

/* The way of the lights in words, for the report: "mask, drawn on GL". */
const char *gp_suns_way(const struct gp_settings *s,
                        const struct gp_suns *suns);

/* The mean visibility, by flux where any is given: what a pupil meets. */
double gp_suns_mean(const struct gp_suns *suns);

/* Pictures for --debug, as planes of *w x *h, values 0 to 1: sun maps of all
 * lights side by side, or the intensity map. */
GP_MUST_CHECK gp_status gp_suns_picture(const struct gp_log *log,
                                        const struct gp_settings *s,
                                        const struct gp_suns *suns,
                                        bool intensity, int *w, int *h,
                                        struct gp_planes *out);

/* Frees the frame's part. */
void gp_suns_end_frame(struct gp_suns *suns);
void gp_suns_close(struct gp_suns *suns);

// -- sun_light.c: a light's disc in pixels ------------------------------------

/* Weights of the (2m+1) x (2m+1) pixels around a disc's centre pixel, whose
 * sum is 1; one pixel for a radius up to 1/2. */
struct gp_disc_pixels {
    int m;
    float *weight; // owned: gp_free()
};
GP_MUST_CHECK gp_status gp_disc_pixels_make(const struct gp_log *log,
                                            double radius,
                                            struct gp_disc_pixels *out);

/* The pixels of `frame` that a light's disc falls on, each with its share of
 * flux * visibility: the weights above, moved to the light's place by bilinear
 * shares, which keep flux and centroid. Appends to list[*n], which has room
 * for gp_disc_room() more. */
size_t gp_disc_room(double radius); // pixels of a disc, at most
void gp_disc_light(const struct gp_disc_pixels *d, const struct gp_light *l,
                   struct gp_rect frame, struct gp_source *list, size_t *n);

#endif
