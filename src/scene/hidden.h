/* Occlusion by the frame's depth: a pyramid of its greatest depths, and the
 * least and greatest of tiles. */
#ifndef GP_SCENE_HIDDEN_H
#define GP_SCENE_HIDDEN_H

#include "scene/bounds.h"

enum {
    GP_TILE = 16,      // pixels a side
    GP_TILE_LEVEL = 4, // of the pyramid: 2^4
};

/* Depths of the frame: level 0 are the pixels, level k the greatest of 2^k x 2^k
 * of them. No surface is INFINITY. */
struct gp_hidden {
    struct gp_rect window;
    int levels;           // 0: no depth is known, nothing is hidden
    int w[32], h[32];
    float *most[32];      // owned; w * h of each level
    // of tiles, as level GP_TILE_LEVEL; owned
    float *least, *deepest; // of surfaces; INFINITY and 0 where there is none
};

/* Parts by which depths may be wrong: 2^-10 holds those stored as half. */
#define GP_DEPTH_SLACK 0x1p-10

/* Makes the pyramid.
 *   depth  gp_rect_w x gp_rect_h of window, along the view axis, units of the
 *          world; NaN, <= 0 and >= GP_DEPTH_HUGE: no surface; borrowed until
 *          this returns
 *   out    free with gp_hidden_free(); empty on failure
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_hidden_make(const struct gp_log *log,
                                       struct gp_rect window,
                                       const float *depth,
                                       struct gp_hidden *out);
void gp_hidden_free(struct gp_hidden *h);

/* Returns the greatest depth of a surface, with its slack; 0: there is none. */
double gp_hidden_deepest(const struct gp_hidden *h);

/* True where the box is behind the surfaces of all pixels of its bounds in the
 * window, or of no pixel there: no pixel's centre can show a part of it. */
bool gp_hidden_box(const struct gp_hidden *h, const struct gp_screen_box *b);

/* Returns the pixels whose centres may be in the bounds, cut by `window`. */
struct gp_rect gp_screen_pixels(const struct gp_screen_box *b,
                                struct gp_rect window);

#endif
