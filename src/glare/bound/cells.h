/* The most light that polygons can be short of in a pixel when they leave a
 * part of the kernel out, counted by square cells of the frame. Kernels
 * without lobes.
 */
#ifndef GP_GLARE_BOUND_CELLS_H
#define GP_GLARE_BOUND_CELLS_H

#include "core/status.h"
#include "glare/splat/blur.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"

#include <stdbool.h>

/* Cells of side x side pixels from the frame's corner; those at the right and
 * at the bottom may be cut. */
struct gp_bound_cells {
    int w, h;           // of the frame
    int side, columns, rows;
};

/* The smallest cells, a power of two, for which the sums below stay cheap. */
struct gp_bound_cells gp_cells_choose(int w, int h, const struct gp_kernel *kernel);

/* Numbers by the offset from a source's cell to a pixel's:
 * at[c][(dy - y0) * w + dx - x0]; 0 beyond. Grey kernels have channel 0 alone.
 * Free with gp_cell_table_free(). */
struct gp_cell_table {
    int x0, y0, w, h;
    int channels;
    double *at[3];
};
void gp_cell_table_free(struct gp_cell_table *t);

/* The most that a unit of light up to `carry` pixels from a cell adds to a
 * pixel of another. Kernel without its core when `tail`.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_cell_most(const struct gp_log *log,
                                     const struct gp_bound_cells *cells,
                                     const struct gp_kernel *kernel, bool tail,
                                     int carry, struct gp_cell_table *out);

/* The most light of each channel that shrinking leaves out in any pixel.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_cells_left(const struct gp_log *log,
                                      const struct gp_bound_cells *cells,
                                      const struct gp_polygons *polygons,
                                      const struct gp_shrink *shrink,
                                      const struct gp_cell_table *most,
                                      double out[3]);

#endif
