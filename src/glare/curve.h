// SPDX-License-Identifier: Apache-2.0
/* Curves of a distance, and rules of quadrature. */
#ifndef GP_GLARE_CURVE_H
#define GP_GLARE_CURVE_H

#include "core/bytes.h"
#include "core/status.h"

#include <stddef.h>
#include <stdint.h>

enum { GP_CURVE_LOG2 = 6, GP_CURVE_STEPS = 1 << GP_CURVE_LOG2 };

/* A curve by the square s of a distance, at 64 even steps an octave, with slopes: a
 * cubic between them keeps about 1e-8 of what powers give. */
struct gp_curve {
    uint64_t first; // bits of the least square / (2^52 / STEPS)
    int n;          // steps
    int channels;
    double *value; // [n + 1][channels][2]: value, slope times the step; owned
};

/* Allocates entries for squares of distances from `least` to `most`, for the
 * caller to fill and gp_free(). */
GP_MUST_CHECK gp_status gp_curve_make(const struct gp_log *log, int channels,
                                      double least, double most,
                                      struct gp_curve *out);

/* Returns the square of entry i; *step is how far it is to the next. */
double gp_curve_square(const struct gp_curve *t, int i, double *step);

/* Adds weight times the value at s; nothing outside of the curve. */
static inline void gp_curve_add(const struct gp_curve *t, double s,
                                double weight, double *sum)
{
    const uint64_t bits = gp_bits_of_double(s);
    const int64_t i =
        (int64_t) (bits >> (52 - GP_CURVE_LOG2)) - (int64_t) t->first;
    if (i < 0 || i >= t->n)
        return;
    // the mantissa's rest is the place between two steps
    const uint64_t rest = bits << (12 + GP_CURVE_LOG2) >> 12;
    const double x = gp_double_with_bits(rest | 0x3ff0000000000000u) - 1.0;
    const double y = 1.0 - x;
    for (int c = 0; c < t->channels; c++) {
        const double *const a =
            t->value + 2 * ((size_t) i * (size_t) t->channels + (size_t) c);
        const double *const b = a + 2 * t->channels;
        // the slope of the step after an octave's last is by its own width
        const double next =
            i % GP_CURVE_STEPS == GP_CURVE_STEPS - 1 ? 0.5 * b[1] : b[1];
        sum[c] += weight * (y * y * ((1.0 + 2.0 * x) * a[0] + x * a[1]) +
                            x * x * ((1.0 + 2.0 * y) * b[0] - y * next));
    }
}

/* Gauss-Legendre nodes in (-0.5, 0.5), weights of sum 1; n from 1 to 16. */
struct gp_gauss {
    int n;
    double node[16], weight[16];
};
const struct gp_gauss *gp_gauss_rule(int n); // made at first call, kept

/* The same for the tent 1 - |x| on (-1, 1): light that is even over a pixel, in
 * an even pixel at its side. n from 1 to 10. */
const struct gp_gauss *gp_tent_rule(int n);

#endif
