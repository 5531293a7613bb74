/* The measuring of auto-exposure, which tests hold against its definition. */
#ifndef GP_TONE_TONE_PRIV_H
#define GP_TONE_TONE_PRIV_H

#include "tone/tone.h"

/* exp(mean(log(delta + Y))) over pixels with Y > 0 is finite, Reinhard et al.
 * 2002, eq. 1 (with the 1/N inside the exponent, as its erratum says);
 * delta 1e-6. 0 when no pixel counts. Same value for any thread count. */
double gp_log_average(const struct gp_frame *f, const struct gp_planes *p);

#endif
