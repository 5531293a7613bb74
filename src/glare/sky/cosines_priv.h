// SPDX-License-Identifier: Apache-2.0
/* Shared by cosines.c and cosines_add.c. */
#ifndef GP_GLARE_SKY_COSINES_PRIV_H
#define GP_GLARE_SKY_COSINES_PRIV_H

#include "glare/sky/cosines.h"

#include <math.h>

/* Direction cosines of places between two corners. */
struct gp_cosine_box {
    double low[2], high[2];
};
struct gp_cosine_box gp_cosine_box_of(const struct gp_projection *p,
                                      const double from[2], const double to[2]);

enum { GP_COSINE_TAPS = 8 }; // nodes that a spline meets

/* The nodes around cosines from low to high: n from `first` on, in steps. */
struct gp_cosine_span {
    int first, n;
};
static inline struct gp_cosine_span gp_cosine_span(double low, double high,
                                                   double step)
{
    const int beyond = GP_COSINE_TAPS / 2;
    const int first = (int) floor(low / step) + 1 - beyond;
    return (struct gp_cosine_span) {first, (int) floor(high / step) + beyond +
                                               1 - first};
}

/* B at the nodes three before to four after t in [0, 1): de Boor's recursion. */
static inline void gp_cosine_spline(double t, double b[GP_COSINE_TAPS])
{
    b[0] = 1.0;
    for (int degree = 1; degree < GP_COSINE_TAPS; degree++) {
        double saved = 0.0;
        for (int i = 0; i < degree; i++) {
            const double part = b[i] / degree;
            b[i] = saved + part * (i + 1 - t);
            saved = part * (t + degree - 1 - i);
        }
        b[degree] = saved;
    }
}

#endif
