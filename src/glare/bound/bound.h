/* Lower limits of light, from only the sources and the kernel: what errors are
 * measured against before anything is drawn. */
#ifndef GP_GLARE_BOUND_BOUND_H
#define GP_GLARE_BOUND_BOUND_H

#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sources.h"

/* Cells of side x side pixels from the frame's corner. Those at the right and
 * at the bottom may be cut. */
struct gp_bound_cells {
    int w, h;           // of the frame
    int side, columns, rows;
};

/* The smallest cells, a power of two, for which the sums below stay cheap. */
struct gp_bound_cells gp_bound_cells_choose(int w, int h,
                                            const struct gp_kernel *kernel);

/* Finds the least weighted sum of light that sources of other cells add to any
 * pixel of each cell, channels of weight over 0 only. Kernels without lobes.
 *
 *   out  columns * rows
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_bound_cells_faint(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_kernel *kernel,
    const struct gp_sources *src, const double weight[3], double *out);

/* Finds a lower limit of || exact layer ||_2 over the frame; 0 for kernels with
 * lobes. Light only adds up: the layer's square is no less than the sum of the
 * squares of each source's own part, nor than that of the least light of each
 * cell in all of its pixels. Each channel takes the larger.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_layer_least(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    double *least);

#endif
