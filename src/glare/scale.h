/* Light and kernels near the least that a float holds. GL takes what is under
 * 2^-126 for 0, and transforms keep few of its digits: such a layer is computed
 * of sources and a kernel times powers of two, which changes no digit of them,
 * and divided again at the end. Ordinary frames stay as they are. */
#ifndef GP_GLARE_SCALE_H
#define GP_GLARE_SCALE_H

#include "glare/engine.h"

struct gp_scale; // what is kept from frame to frame: struct gp_glare has it

/* Gives the job sources and a kernel that are large enough, where its own are
 * not, and job->exponent, by which powers of two the layer is too large then.
 *
 *   keep   what the kernel becomes, and what else is the same for frames alike;
 *          *keep is NULL at first, gp_scale_free()
 *   light  zero, or owns the scaled light: gp_scale_light_free()
 *
 * Errors: GP_ERR_BUG out of memory; the job is as it was.
 */
GP_MUST_CHECK gp_status gp_scale_job(struct gp_glare_job *job,
                                     struct gp_scale **keep,
                                     struct gp_sources *light);
void gp_scale_light_free(struct gp_sources *light);
void gp_scale_free(struct gp_scale **keep);

/* Divides the layer by 2^job->exponent. */
void gp_scale_back(const struct gp_glare_job *job);

/* What rel_l2 of the layer may be more than an engine's bound says, which is
 * about floats that never leave their range: where values leave it downwards,
 * and where the layer itself does. INFINITY where nothing can be said. 1e-20 in
 * ordinary frames, and found at once; else by gp_layer_least().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_scale_floor(const struct gp_glare_job *job,
                                       struct gp_scale **keep, double *floor);

#endif
