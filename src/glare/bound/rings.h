/* What a kernel's parts beyond square rings around its centre amount to. */
#ifndef GP_GLARE_BOUND_RINGS_H
#define GP_GLARE_BOUND_RINGS_H

#include "core/status.h"
#include "glare/splat/blur.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"

#include <stdbool.h>

/* Kernel samples within (w, h) of the centre, without the core when `tail`. */
struct gp_bound_rings {
    int n;             // rings 0 .. n - 1 hold all of them
    double *beyond[3]; // n + 1 sums: of ring i and those farther out
    double slope[3];   // sum of |dk/dx| + |dk/dy|, differences to the next
};

/* Free with gp_bound_rings_free(). Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bound_rings_make(const struct gp_log *log,
                                            const struct gp_kernel *k,
                                            bool tail, int w, int h,
                                            struct gp_bound_rings *out);
void gp_bound_rings_free(struct gp_bound_rings *r);

/* What the light left out by shrinking adds up to over an unbounded plane,
 * and, by Young's inequality ring for ring, what its norm cannot exceed.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bound_rings_left(const struct gp_log *log,
                                            const struct gp_bound_rings *r,
                                            const struct gp_polygons *polygons,
                                            const struct gp_shrink *shrink,
                                            double sum[3], double norm[3]);

/* What the norm cannot exceed when polygons that lie between pixels are
 * sampled up to `place` pixels away from where they should be, in x and in
 * y. */
void gp_bound_rings_sampled(const struct gp_bound_rings *r,
                            const struct gp_polygons *polygons, double place,
                            double norm[3]);

#endif
