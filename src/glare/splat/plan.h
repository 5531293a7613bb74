/* What the splat engine draws and what that may cost, found on the CPU before
 * any drawing. */
#ifndef GP_GLARE_SPLAT_PLAN_H
#define GP_GLARE_SPLAT_PLAN_H

#include "glare/splat/blur.h"
#include "glare/bound/bound.h"
#include "glare/engine.h"
#include "glare/splat/group.h"

#include <stdbool.h>
#include <stdint.h>

struct gp_splat_plan {
    bool made;
    uint64_t key;                  // of what it was made from
    struct gp_splat_params params; // in force: method CENTROID when single
    bool single;                   // each source is a polygon on whole pixels
    bool turned;                   // quads may turn an unturned kernel
    bool core;                     // sources draw the kernel's core
    bool tail;                     // the kernel is more than its core
    struct gp_rect crop;           // of the kernel, that can reach the frame
    struct gp_polygons polygons;
    struct gp_shrink shrink;
    double polygon_pixels;         // of polygons and cores, on the layer
    double bound;                  // of rel_l2, for any way to draw
};

/* The part of the kernel that can reach a pixel of a w x h frame from within
 * it, in kernel pixels, when blurred by boxes of sides up to `side`. May be
 * empty, as --kernel-center may be far away. */
struct gp_rect gp_splat_crop(const struct gp_kernel *k, int w, int h,
                             int side);

/* Makes the plan of a job, or keeps *p when it was made from the same light,
 * kernel and parameters. src->n is over 0.
 * Errors: GP_ERR_BUG out of memory; *p is then empty. */
GP_MUST_CHECK gp_status gp_splat_plan_make(const struct gp_glare_job *job,
                                           struct gp_bound_cache *cache,
                                           struct gp_splat_plan *p);
void gp_splat_plan_free(struct gp_splat_plan *p);

/* Polygons whose light is summed by itself before it is added to the layer:
 * about the square root of all, as a sum of n equal terms in float may drift
 * by n / 2 roundings. */
size_t gp_splat_chunk(size_t polygons);

/* Reach of a polygon in pixels; at most 2^20. */
int gp_splat_reach(const struct gp_splat_plan *p, float light);

#endif
