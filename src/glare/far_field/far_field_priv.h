/* Shared by the files of this folder and by their tests. */
#ifndef GP_GLARE_FAR_FIELD_TAIL_PRIV_H
#define GP_GLARE_FAR_FIELD_TAIL_PRIV_H

#include "glare/kernel.h"
#include "glare/far_field/far_field.h"

enum {
    GP_FAR_TAPS = 4,  // nodes that a cubic B-spline meets, from one before
                       // the pixel's own
    GP_FAR_FADE = 12, // steps over which a tail fades out past the frame
};

/* Nodes that n pixels meet: of pixel x from x / step on, the first being one
 * step before the frame. */
static inline int gp_far_nodes(int n, int step)
{
    return (n - 1) / step + GP_FAR_TAPS;
}

/* The cubic B-spline at the nodes one before to two after t in [0, 1). */
static inline void gp_far_spline(double t, double b[GP_FAR_TAPS])
{
    const double u = 1.0 - t;
    b[0] = u * u * u / 6.0;
    b[1] = (4.0 + t * t * (3.0 * t - 6.0)) / 6.0;
    b[2] = (4.0 + u * u * (3.0 * u - 6.0)) / 6.0;
    b[3] = t * t * t / 6.0;
}

#endif
