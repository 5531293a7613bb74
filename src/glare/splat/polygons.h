// SPDX-License-Identifier: Apache-2.0
/* Polygons: groups of sources that share one drawn kernel (Ando et al. 2007,
 * section 4), on the CPU. The splat engine draws them, its bound uses them, and
 * GL makes the same ones by group.frag.
 *   group.c  groups and clusters
 *   blur.c   their blurred kernels and reach, and the picture of their rims */
#ifndef GP_GLARE_SPLAT_POLYGONS_H
#define GP_GLARE_SPLAT_POLYGONS_H

#include "core/image.h"
#include "core/status.h"
#include "glare/engine.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <stdbool.h>

/* -- groups and clusters --------------------------------------------------- */

/* Half the side, less one half, of the kernel's middle: 17x17 pixels that each
 * source draws by itself, while only the rest is drawn from groups. */
enum { GP_MIDDLE_RADIUS = 8 };

/* Tests whether each source is a polygon of the whole kernel. */
static inline bool gp_splat_single(const struct gp_splat_params *p)
{
    return p->group == 1 && !p->cluster;
}

/* Boxes that a kernel is blurred by to meet the spread of a group. A box of
 * side M has the second moment (M * M - 1) / 12 on each axis. */
enum { GP_BLURS = 10 };
extern const int gp_blur_box[GP_BLURS]; // 1 2 3 4 6 8 12 16 32 64

/* Square cells of a frame's pixels, which count from the data window's corner, so
 * that the first one's may be under 0. */
struct gp_cells {
    int side;
    int x, y; // the first cell's corner
    int w, h; // cells
};

/* Returns the whole cells that hold the frame: in EXR pixel space one starts at
 * each multiple of its side. */
struct gp_cells gp_cells_over(const struct gp_sources *src, int side);

struct gp_polygon {
    float x, y;      // formula (1): P0, in pixels from the data window's
                     // corner; the centre of pixel (i, j) is (i, j)
    float rgb[3];    // sum of the cell's light
    float light;     // formula (1): L0, sum of luminance
    uint8_t side;    // of the cell: 1, group or cluster
    uint8_t blur;    // index in gp_blur_box
};

struct gp_polygons {
    size_t n;
    size_t groups, clusters; // n = groups + clusters
    struct gp_polygon *at;   // clusters first, then groups; each in row order
                             // of their cells
};

/* Groups the sources by cells of NxN pixels: a polygon for each cell of side
 * p->cluster whose share of bright pixels (of its pixels inside the data
 * window) is at least cluster_fill, and one for each other cell of side
 * p->group that holds light. With group 1 and no cluster: one polygon a source.
 *
 * Cells count from pixel (0, 0) of EXR pixel space, so that a moving data
 * window moves no cell; those that straddle the window's edge hold what is
 * inside.
 *
 * L0, P0 and the second moment are weighted by luminance, which is over 0 in
 * every source; where it is 0 all the same (denormals), P0 is the cell's
 * centre. The blur is the box for which box and bilinear sampling at P0
 * together come nearest to the cell's second moment, the mean of x and y:
 *   (M * M - 1) / 12 + (fx (1 - fx) + fy (1 - fy)) / 2
 * with fx, fy the fractions of P0 - (M - 1) / 2; the smaller box on a tie,
 * and none over the cell's side.
 *
 *   out  written only on GP_OK; free out->at */
GP_MUST_CHECK gp_status gp_polygons_make(const struct gp_log *log,
                                         const struct gp_sources *src,
                                         const struct gp_splat_params *p,
                                         struct gp_polygons *out);

/* -- the kernel ------------------------------------------------------------ */

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
 * kernel pixels), and without its middle when `hollow`: samples with both
 * |dx|, |dy| <= GP_MIDDLE_RADIUS from the kernel's centre count as 0.
 * Written only on GP_OK; free out->k. */
GP_MUST_CHECK gp_status gp_blur_make(const struct gp_log *log,
                                     const struct gp_kernel *kernel,
                                     struct gp_rect crop, bool hollow, int side,
                                     struct gp_blur *out);

/* Samples of a kernel by square rings around its centre: ring d holds those with
 * max(|dx|, |dy|) = d. */
struct gp_rings {
    int n;             // rings 0 .. n - 1 hold all of them
    double *beyond[3]; // n + 1 sums of magnitudes: of ring i and farther ones
    double *peak;      // n + 1: largest magnitude of them, any channel
};

/* Makes them, in one block, of the samples in `crop`, without the middle when
 * `hollow`. Free out->beyond[0]. */
GP_MUST_CHECK gp_status gp_rings_make(const struct gp_log *log,
                                      const struct gp_kernel *k,
                                      struct gp_rect crop, bool hollow,
                                      struct gp_rings *out);

/* Shrinking (Ando et al. 2007, section 4.3): a polygon of light L reaches as
 * far as L times the kernel is over `least` somewhere on the square ring at
 * that distance. `least` is the largest for which the light left out, summed
 * over all polygons, is at most share * (the light of all polygons). */
struct gp_shrink {
    float least;
    /* Reach in pixels by gp_source_bin(L0): pixels with |dx| and |dy| up to
     * this from P0 are drawn; those beyond are left out. INT_MAX / 2 draws
     * all. At least GP_MIDDLE_RADIUS, or 0 of single sources. Grows with L0. */
    int reach[GP_SOURCE_BINS];
    double left_out; // bound of the share of light that is left out, <= share
};

/* Finds the reaches for p->shrink, the share; 0 leaves nothing out. */
GP_MUST_CHECK gp_status gp_shrink_make(const struct gp_log *log,
    const struct gp_kernel *kernel, const struct gp_splat_params *p,
    const struct gp_polygons *polygons, struct gp_shrink *out);

/* -- the picture of polygons ----------------------------------------------- */

/* Draws over the picture, in one-pixel lines of full green (0, 1, 0), the rim
 * of each polygon that splat draws with these settings, as in figure 6 of the
 * paper: the pixels at the edge of the square around P0 that its reach leaves,
 * cut to what the kernel covers there. Edges outside the frame are not seen.
 * The sources that draw only their middle are no polygons.
 *
 *   picture  src->w x src->h planes, changed where there is a line */
GP_MUST_CHECK gp_status gp_polygons_outline(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_kernel *kernel,
    const struct gp_splat_params *p, struct gp_planes *picture);

#endif
