/* The part of the picture that a light can change. */
#ifndef GP_SCENE_SCISSOR_H
#define GP_SCENE_SCISSOR_H

#include "scene/hidden.h"

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

#endif
