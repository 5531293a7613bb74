// SPDX-License-Identifier: Apache-2.0
/* Shared by the .c files of this folder and by their tests. */
#ifndef GP_GLARE_GLARE_PRIV_H
#define GP_GLARE_GLARE_PRIV_H

#include "core/status.h"
#include "glare/bound/bound.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <stdbool.h>

// -- sensors.c, reference.c: declared for tests ------------------------------

/* Returns the share of a pixel of luminance y that is light, 0 to 1. */
float gp_bright_pass(const struct glarepp_sense_params *p, float y);

/* gp_glare_reference() by plain loops, in time of sources times taps. */
void gp_glare_reference_direct(const struct gp_sources *src,
                               const struct gp_kernel *kernel, double *layer);

// -- plan.c: `--engine auto` --------------------------------------------------

/* The planner's choice. */
struct gp_choice {
    int engine;      // index in gp_engines
    bool whole;      // it sums the kernel with its far field, sample by sample
    bool in_double;  // for tolerance_pixel's sake
    double bound;    // of rel_l2
    double pixel;    // of max_rel; 0: not asked
};

/* Chooses by the request alone, and writes stats->why: `direct` for a handful
 * of sources, else `fft`. Where its bounds are over the tolerances, the other;
 * where both are over them and the kernel has a far field, `direct` of the
 * whole kernel. Where nothing keeps them, the lower bound runs, and a warning
 * that names `path` is printed once in a sequence.
 * Errors: an engine's bound. */
GP_MUST_CHECK gp_status gp_plan(const struct gp_glare_request *req,
    struct gp_glare *g, const char *path, const struct gp_pixel_floor *floor,
    struct gp_choice *out);

/* Seconds that direct sums take on all threads, within a factor of 2 on the machine
 * that they were measured on: of products of the kernel, and by true angles of pairs
 * of a source and a pixel. */
double gp_sum_seconds(const struct gp_glare_request *req);

/* Bounds max_rel of engine i; INFINITY where nothing is guaranteed. Errors: its
 * own. */
GP_MUST_CHECK gp_status gp_plan_pixel(const struct gp_glare_request *req,
    struct gp_glare *g, int engine, const struct gp_pixel_floor *floor,
    double *bound);

#endif
