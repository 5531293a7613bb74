/* Bounds of the error of grouping, clustering, shrinking and float blending,
 * before anything is drawn. */
#ifndef GP_GLARE_BOUND_BOUND_H
#define GP_GLARE_BOUND_BOUND_H

#include "glare/splat/polygons.h"

/* Kept for one kernel; zeroed at first. */
struct gp_bound_cache {
    unsigned long kernel; // serial
    void *data;
};
void gp_bound_cache_free(struct gp_bound_cache *c);

/* Finds a lower limit of || exact layer ||_2 over the frame, from only the
 * sources and the kernel; 0 for kernels with lobes.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_layer_least(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    struct gp_bound_cache *cache, double *least);

/* Bounds rel_l2 of a splat layer: grouping and clustering,
 * light left out by shrinking, samples' positions, and `roundings` float
 * roundings (each 2^-24 of a pixel's sum). INFINITY for kernels with lobes.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_group_bound(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    const struct gp_splat_params *p, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double roundings,
    struct gp_bound_cache *cache, double *out);

// -- left_out.c -------------------------------------------------------------

/* Cells of side x side pixels from the frame's corner; those at the right and
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

#endif
