/* The part of the picture that a light can change. */
#ifndef GP_SCENE_SCISSOR_H
#define GP_SCENE_SCISSOR_H

#include "scene/hidden.h"
#include "scene/umbra.h"

/* Pixels and a range of depths; empty: rect is, and the rest is 0. */
struct gp_scissor {
    struct gp_rect rect;
    double near, far;   // along the view axis, units of the world
};

/* Returns the bounds of the visible points of an object: those of the tiles of
 * GP_TILE pixels where the range of depths meets the object's, cut by the
 * window. Without depths, levels 0, the object's own. */
struct gp_screen_box gp_scissor_visible(const struct gp_hidden *h,
                                        const struct gp_screen_box *box);

/* Returns the bounds of the visible points of objects within a light's bounds,
 * less the tiles at its sides that have no depth in them; their range of depths
 * is between the least and the greatest of the tiles.
 *   box, n   bounds of visible points, those of `index`
 *   light    the light's
 *   h        depths, levels 0: none; its window cuts
 * Source: O'Rorke, GPU Gems 15.5. */
struct gp_scissor gp_scissor_make(const struct gp_hidden *h,
                                  const struct gp_screen_box *box,
                                  const int *index, int n,
                                  const struct gp_screen_box *light);

/* A tile of the frame before a light. */
enum {
    GP_TILE_BEYOND, // out of its reach, or without a surface
    GP_TILE_DARK,   // in its reach, in one umbra
    GP_TILE_LIT,    // it may be lit
};

/* Boxes of the world around the visible points of each tile. */
struct gp_lit_tiles {
    struct gp_box *box;      // owned; empty: a tile without a surface
    uint8_t *lit;            // owned; GP_TILE_DARK... of the light
    struct gp_box *seen;     // owned; of the tiles of a scissor in reach
    int seens;
};

/* Makes *out; free with gp_lit_tiles_free(); empty on failure and without depths.
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_lit_tiles_make(const struct gp_log *log,
                                      const struct gp_hidden *h,
                                      const struct gp_camera *c,
                                      struct gp_rect display,
                                      struct gp_lit_tiles *out);
void gp_lit_tiles_free(struct gp_lit_tiles *t);

/* Sets lit[i] of the tiles of a scissor, and returns the part of it that holds
 * those that may be lit.
 *   texel  as of gp_sets_view */
struct gp_scissor gp_lit_tiles_light(struct gp_lit_tiles *t,
                                     const struct gp_hidden *h,
                                     const struct gp_scissor *s,
                                     const struct gp_reach *light,
                                     const struct gp_umbras *umbras,
                                     double texel);

/* False where no lit tile of a scissor can show a point in the bounds. */
bool gp_lit_tiles_show(const struct gp_lit_tiles *t, const struct gp_hidden *h,
                   const struct gp_scissor *s, const struct gp_screen_box *box);

/* Lists the boxes of the tiles of a scissor that are in reach in `seen`, and
 * returns it with the range of their depths: a pass over its pixels needs the
 * shadows on them, also on those beyond the scissor's own range. */
struct gp_scissor gp_lit_tiles_list(struct gp_lit_tiles *t,
                                    const struct gp_hidden *h,
                                    const struct gp_scissor *s);

#endif
