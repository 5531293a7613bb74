/* Groups and clusters: fewer polygons for the same light (Ando et al. 2007,
 * sections 4.1 and 4.2). This is the plain form on the CPU, which the passes on GL are
 * tested against, and which the bound, the planner and the picture of polygons
 * count with.
 *
 * Blocks of NxN pixels are counted from pixel (0, 0) of EXR pixel space, so
 * that a moving data window moves no block; those that straddle the window's
 * edge hold what lies inside.
 */
#ifndef GP_GLARE_SPLAT_GROUP_H
#define GP_GLARE_SPLAT_GROUP_H

#include "core/status.h"
#include "glare/engine.h"
#include "glare/sensors.h"

/* Half the side, less one half, of the square that GP_GROUP_CORE draws from
 * single sensors: 17x17 pixels around each. */
enum { GP_CORE_RADIUS = 8 };

/* Boxes that a kernel is blurred by to meet the spread of a group. A box of
 * side M has the second moment (M * M - 1) / 12 on each axis. */
enum { GP_BLURS = 10 };
extern const int gp_blur_box[GP_BLURS]; // 1 2 3 4 6 8 12 16 32 64

struct gp_polygon {
    float x, y;      // formula (1): P0, in pixels from the data window's
                     // corner; the centre of pixel (i, j) is (i, j)
    float rgb[3];    // sum of the block's light
    float light;     // formula (1): L0, sum of luminance
    uint8_t side;    // of the block: 1, group or cluster
    uint8_t blur;    // index in gp_blur_box; 0 with GP_GROUP_CENTROID
};

struct gp_polygons {
    size_t n;
    size_t groups, clusters; // n = groups + clusters
    struct gp_polygon *at;   // clusters first, then groups; each in row order
                             // of their blocks
};

/* Groups the sources: a polygon for each cluster area whose share of bright
 * pixels (of its pixels inside the data window) is at least cluster_fill, and
 * one for each other group block that holds light. With group 1 and no
 * cluster: one polygon a source.
 *
 * L0, P0 and the second moment are weighted by luminance, which is over 0 in
 * every source; where it is 0 all the same (denormals), P0 is the block's
 * centre. The blur is the box for which box and bilinear sampling at P0
 * together come nearest to the block's second moment, the mean of x and y:
 *   (M * M - 1) / 12 + (fx (1 - fx) + fy (1 - fy)) / 2
 * with fx, fy the fractions of P0 - (M - 1) / 2; the smaller box on a tie,
 * and none over `side`.
 *
 *   out  written only on GP_OK; free with gp_polygons_free()
 * Errors: GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_group(const struct gp_log *log,
                                 const struct gp_sources *src,
                                 const struct gp_splat_params *p,
                                 struct gp_polygons *out);
void gp_polygons_free(struct gp_polygons *p);

/* Double-precision layer of the polygons as they are meant to be drawn, for
 * tests: the plain form of every way of drawing. Each polygon adds
 *   light * blurred kernel, sampled bilinearly at pixel - P0,
 * cut to |dx|, |dy| <= reach of gp_shrink; GP_GROUP_CORE adds the core from
 * each source. `layer` has 3 * w * h doubles. Slow. */
struct gp_shrink;
GP_MUST_CHECK gp_status gp_group_reference(const struct gp_log *log,
                                           const struct gp_sources *src,
                                           const struct gp_kernel *kernel,
                                           const struct gp_splat_params *p,
                                           const struct gp_polygons *polygons,
                                           const struct gp_shrink *shrink,
                                           double *layer);

#endif
