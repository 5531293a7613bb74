/* Shared by the files of this folder and by their tests. */
#ifndef GP_GLARE_TAIL_TAIL_PRIV_H
#define GP_GLARE_TAIL_TAIL_PRIV_H

#include "glare/tail/tail.h"

enum {
    GP_TAIL_TAPS = 4,  // nodes that a cubic B-spline meets, from one before
                       // the pixel's own
    GP_TAIL_FADE = 12, // steps over which a tail fades out past the frame
};

/* Nodes that n pixels meet: of pixel x from x / step on, the first being one
 * step before the frame. */
static inline int gp_tail_nodes(int n, int step)
{
    return (n - 1) / step + GP_TAIL_TAPS;
}

#endif
