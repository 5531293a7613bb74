/* One plane of samples with its own window: depth, coverage. */
#ifndef GP_CORE_PLANE_H
#define GP_CORE_PLANE_H

#include "core/frame.h"

/* w * h floats of `window`, rows from the top, no padding; NaN and Inf stay
 * as they were read. Empty: v is NULL. */
struct gp_plane {
    struct gp_rect window; // EXR pixel space
    float *v;              // owned
    char *name;            // channel it came from, for the report; owned
};

/* Frees what it owns and clears it; an empty one is fine. */
void gp_plane_free(struct gp_plane *p);

#endif
