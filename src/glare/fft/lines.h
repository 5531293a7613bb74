// SPDX-License-Identifier: Apache-2.0
/* One point of several lines, in the precision that a file is compiled for. */
#ifndef GP_GLARE_FFT_LINES_H
#define GP_GLARE_FFT_LINES_H

#include "glare/fft/transform.h"

#ifdef GP_FFT_DOUBLE
enum { LINES = GP_DOUBLE_LINES };
typedef double real;
typedef gp_double_lines lines;
#define OF(name) gp_double_##name
// the perfect shuffle of two vectors
#define LOW 0, 4, 1, 5
#define HIGH 2, 6, 3, 7
#else
enum { LINES = GP_FLOAT_LINES };
typedef float real;
typedef gp_float_lines lines;
#define OF(name) gp_float_##name
#define LOW 0, 8, 1, 9, 2, 10, 3, 11
#define HIGH 4, 12, 5, 13, 6, 14, 7, 15
#endif

#define INLINE static inline __attribute__((always_inline))

struct point {
    lines re, im;
};

#endif
