/* Sensors on GL: the frame's light as a texture, and the passes that make
 * groups and clusters of it (Ando et al. 2007, sections 4.1 and 4.2). */
#ifndef GP_GLARE_SPLAT_GROUP_GL_H
#define GP_GLARE_SPLAT_GROUP_GL_H

#include "glare/splat/state.h"

/* A grid of cells of side x side pixels. Pixels count from the data window's
 * corner, so the grid's may be negative. */
struct gp_cells {
    int side;
    int x, y; // the first cell's corner
    int w, h; // cells
};

/* The whole cells, counted from EXR pixel (0, 0), that meet the pixels of
 * `rect`, which is not empty. */
struct gp_cells gp_cells_over(const struct gp_sources *src, struct gp_rect rect,
                              int side);

/* Their pixels. */
struct gp_rect gp_cells_rect(const struct gp_cells *c);

/* Uploads the light of the pixels of `rect`, which lies inside the frame, to
 * s->sources: rgb, and luminance. Errors: GP_ERR_GL over the texture limit. */
GP_MUST_CHECK gp_status gp_splat_upload(const struct gp_log *log,
                                        struct gp_splat *s,
                                        const struct gp_sources *src,
                                        struct gp_rect rect);

/* One pass over what gp_splat_upload() left of `rect`: makes `out`, at least
 * c->w x c->h, two attachments, as group.frag says.
 *
 *   boxes    bits of the blurs that may be taken
 *   fill     share of bright pixels under which a cell stays shut; 0: none
 *   parents  clusters whose cells stay shut, over the same pixels and of
 *            side parent_side; NULL: none
 * Errors: GP_ERR_GL. */
GP_MUST_CHECK gp_status gp_splat_group(const struct gp_log *log,
                                       struct gp_splat *s, struct gp_rect rect,
                                       const struct gp_cells *c,
                                       unsigned boxes, float fill,
                                       const struct gp_target *parents,
                                       int parent_side,
                                       struct gp_target *out);

#endif
