/* Polygons on GL, blended: quads or point sprites over the sensors of a grid
 * (Ando et al. 2007, sections 3 and 4). */
#ifndef GP_GLARE_SPLAT_DRAW_H
#define GP_GLARE_SPLAT_DRAW_H

#include "glare/splat/group_gl.h"
#include "glare/splat/state.h"

struct gp_splat_work {
    const struct gp_glare_job *job;
    struct gp_splat *s;
    const struct gp_splat_plan *plan;
    bool points;
    bool turned;          // quads turn, and the kernel stays as it was
    int sprite;           // points: pixels of the largest; quads: 0
    int margin;           // pixels that the view reaches beyond the tile
    int span;             // of the coarsest cells
    int side, tile_side;  // of the largest block and tile, in pixels
    struct gp_rect meets; // offsets from a polygon of pixels it may touch
    unsigned group_blurs, cluster_blurs; // bits of those that are used
    size_t chunk;         // polygons summed at a time
    struct gp_rect tile;  // of the frame

    size_t held;          // polygons in the chunk
    int top, bottom;      // rows of the tile that they may touch
};

/* Draws the sensors of the block of coarse cells, with groups and clusters
 * made on the way: to the total, or to the chunk when there are many polygons.
 * Errors: GP_ERR_GL, GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_splat_block(struct gp_splat_work *k,
                                       const struct gp_cells *coarse);

/* Adds what the chunk holds to the total, and empties it. */
GP_MUST_CHECK gp_status gp_splat_flush(struct gp_splat_work *k);

/* The layer that s->plan says, by blended quads or by points. The context is
 * open and current. Nothing is read back before a tile of the layer is done.
 * Errors: GP_ERR_GL, as when a point would be larger than the driver draws;
 * GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_splat_draw(const struct gp_glare_job *job,
                                      struct gp_splat *s, bool points);

#endif
