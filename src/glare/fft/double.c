// SPDX-License-Identifier: Apache-2.0
/* The transform and the tasks of its passes in double. */
#define GP_FFT_DOUBLE
#include "glare/fft/transform.c" // NOLINT(bugprone-suspicious-include)
