/* The kernel as polygons need it: whole or without its core, blurred by
 * boxes; and how far from its centre it still counts.
 */
#ifndef GP_GLARE_SPLAT_BLUR_H
#define GP_GLARE_SPLAT_BLUR_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"

#include <stdbool.h>

/* One blur: sample (i, j) is the share of a polygon's light that falls at
 * offset (i - cx, j - cy) from its centroid; cx and cy are whole or halves
 * (boxes of even side). w = kernel's w + M - 1. Outside it is 0. */
struct gp_blur {
    int w, h;
    float cx, cy;
    struct gp_planes k;
    bool grey; // the three planes are equal (and share no memory)
};

/* Makes the kernel blurred by a box of side `side`, cut first to `crop` (in
 * kernel pixels), and without its core when `tail`: samples with both
 * |dx|, |dy| <= GP_CORE_RADIUS from the kernel's centre count as 0.
 * Written only on GP_OK; free with gp_blur_free().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_blur_make(const struct gp_log *log,
                                      const struct gp_kernel *kernel,
                                      struct gp_rect crop, bool tail, int side,
                                      struct gp_blur *out);
void gp_blur_free(struct gp_blur *b);

/* Shrinking (Ando et al. 2007, section 4.3): a polygon of light L reaches as
 * far as L times the kernel is over `least` somewhere on the square ring at
 * that distance. `least` is the largest for which the light left out, summed
 * over all polygons, is at most share * (the light of all polygons). */
struct gp_shrink {
    float least;
    /* Reach in pixels by gp_source_bin(L0): pixels with |dx| and |dy| up to
     * this from P0 are drawn; those beyond are left out. INT_MAX / 2 draws
     * all. For GP_GROUP_CORE at least GP_CORE_RADIUS. Grows with the bin. */
    int reach[GP_SOURCE_BINS];
    double left_out; // bound of the share of light that is left out, <= share
};

/* `share` 0 leaves nothing out. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_shrink_make(const struct gp_log *log,
                                       const struct gp_kernel *kernel,
                                       const struct gp_splat_params *p,
                                       const struct gp_polygons *polygons,
                                       struct gp_shrink *out);

#endif
