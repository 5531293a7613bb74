// SPDX-License-Identifier: Apache-2.0
/* The transform and its passes in double. */
#define GP_FFT_DOUBLE
#include "glare/fft/transform.c" // NOLINT(bugprone-suspicious-include)
#include "glare/fft/pass.c"      // NOLINT(bugprone-suspicious-include)
