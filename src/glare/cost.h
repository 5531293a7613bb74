/* Predictions by the numbers of costs.h. */
#ifndef GP_GLARE_COST_H
#define GP_GLARE_COST_H

#include "glare/costs.h"
#include "glare/fft/lib.h"
#include "glare/fft/place.h"

/* A cost at `size` from its values at first, 16 * first and 256 * first. */
double gp_cost_at(const double value[3], double size, double first);

/* Milliseconds of one complex transform of length n. */
double gp_cost_transform(int n, enum gp_fft_plan how);

/* Milliseconds of the passes of one frame on one core: sources in
 * `light_rows` rows of p->in to p->out. */
double gp_cost_passes(const struct gp_sources *s,
                      const struct gp_fft_placing *p, enum gp_fft_plan how);

/* Milliseconds of making the kernel's spectrum, its memory touched for the
 * first time. */
double gp_cost_spectrum(const struct gp_kernel *k,
                        const struct gp_fft_placing *p, enum gp_fft_plan how);

#endif
