/* Shared by the .c files of this folder and by their tests. */
#ifndef GP_GLARE_GLARE_PRIV_H
#define GP_GLARE_GLARE_PRIV_H

#include "core/image.h"
#include "core/status.h"
#include "glare/bound/bound.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

#include <stdbool.h>

// -- sensors.c, reference.c: declared for tests ------------------------------

/* Returns the share of a pixel of luminance y that is light, 0 to 1. */
float gp_bright_pass(const struct gp_sensor_params *p, float y);

/* gp_glare_reference() by plain loops, in time of sources times taps. */
void gp_glare_reference_direct(const struct gp_sources *src,
                               const struct gp_kernel *kernel, double *layer);

// -- kernel_warp.c: rotation --------------------------------------------------

/* A rotated kernel: every whole offset at which it can be other than 0. */
struct gp_rotated {
    int w, h;
    int cx, cy;          // the centre's pixel; may lie outside
    struct gp_planes k;  // w * h each
};

/* Sets u->cos and u->sin, counter-clockwise. True for a whole number of right
 * angles, for which they are exact. */
bool gp_rotate_angle(float degrees, struct gp_unturned *u);

/* Sample of channel c at the whole offset (dx, dy) from the rotated kernel's
 * centre: the identity of struct gp_unturned, in double. The plain form. */
double gp_rotate_reference(const struct gp_unturned *u, int c, int dx, int dy);

/* Makes the rotated kernel by these samples, rounded to float; `grey` says
 * that the three planes are equal. By right angles the samples only move.
 *
 *   name  for messages
 *   out   written only on GP_OK; free its planes with gp_planes_free()
 * Errors: GP_ERR_USAGE the box that holds it has over GP_ROTATED_PIXELS
 * pixels; GP_ERR_BUG out of memory. */
enum { GP_ROTATED_PIXELS = 1 << 28 };
GP_MUST_CHECK gp_status gp_rotate(const struct gp_log *log, const char *name,
    const struct gp_unturned *u, bool grey, struct gp_rotated *out);

// -- kernel_warp.c: resampling ------------------------------------------------

/* Resamples a kernel to `across` and `down` new pixels for an old one, > 0: new
 * samples are the areas of old ones that they cover, so sums stay. The centre
 * stays the centre of its pixel; each channel's centroid is kept within 1e-3
 * pixel by a shift of all its samples. Replaces *k.
 * Errors: as gp_rotate(); *k stays. */
GP_MUST_CHECK gp_status gp_resample(const struct gp_log *log, const char *name,
    double across, double down, bool grey, struct gp_rotated *k);

// -- plan.c: `--engine auto` --------------------------------------------------

/* The planner's choice. */
struct gp_choice {
    int engine;      // index in gp_engines
    bool whole;      // it sums the kernel with its tail, sample by sample
    bool fft_double; // for tolerance_pixel's sake
    double bound;    // of rel_l2
    double pixel;    // of max_rel; 0: not asked
};

/* Chooses by the request alone, and writes stats->why: `direct` for a handful
 * of sources, else `fft`. Where its bounds are over the tolerances, the other;
 * where both are over them and the kernel has a tail, `direct` of the whole
 * kernel. Where nothing keeps them, the lower bound runs, and a warning that
 * names `path` is printed once in a sequence.
 * Errors: an engine's bound. */
GP_MUST_CHECK gp_status gp_plan(const struct gp_glare_request *req,
    struct gp_glare *g, const char *path, const struct gp_pixel_floor *floor,
    struct gp_choice *out);

/* Bounds max_rel of engine i; INFINITY where nothing is guaranteed. Errors: its
 * own. */
GP_MUST_CHECK gp_status gp_plan_pixel(const struct gp_glare_request *req,
    struct gp_glare *g, int engine, const struct gp_pixel_floor *floor,
    double *bound);

#endif
