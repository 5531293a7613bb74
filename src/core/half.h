// SPDX-License-Identifier: Apache-2.0
/* IEEE 754 binary16 rows to float and back. */
#ifndef GP_CORE_HALF_H
#define GP_CORE_HALF_H

#include <stddef.h>
#include <stdint.h>

/* n halfs to floats, exact; Inf stays, NaN keeps sign and payload and becomes
 * a quiet one. */
void gp_half_to_float(const uint16_t *in, float *out, size_t n);

/* n floats to halfs, round to nearest even, NaN stays NaN, denormals kept.
 * Values over 65504 after rounding become +-65504, not Inf, which would spread
 * through every later filter. Inf itself stays Inf.
 * Returns the number of finite values that were clamped. */
size_t gp_float_to_half(const float *in, uint16_t *out, size_t n);

/* The nearest value that a half can hold, as Imath's half does it: too large
 * becomes Inf, not 65504. */
float gp_half_nearest(float v);

#endif
