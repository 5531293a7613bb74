/* The flare's GL form: what it keeps from frame to frame. */
#ifndef GP_SUN_FLARE_STATE_H
#define GP_SUN_FLARE_STATE_H

#include "gl/program.h"
#include "sun/flare_item.h"

/* One flare.frag each; images at their own pixels are PLAIN. */
enum gp_flare_program {
    GP_FLARE_DRAW_ROUND, GP_FLARE_DRAW_POLYGON, GP_FLARE_DRAW_STREAK,
    GP_FLARE_DRAW_IMAGE, GP_FLARE_DRAW_PLAIN, GP_FLARE_PROGRAMS,
};

/* An image on the context, in a border of one texel of 0. */
struct gp_flare_slot {
    unsigned serial;
    int level;
    struct gp_texture texture;
};

/* Items that one draw draws: one shape's, or one image's. */
struct gp_flare_batch {
    enum gp_flare_program program;
    int first, n; // in the items' texture
    int item;     // one of them, in the list
    int slot;     // of its image
};

struct gp_flare_gl {
    struct gp_program program[GP_FLARE_PROGRAMS];
    struct gp_target target;
    struct gp_texture texels, edges, intensity; // intensity is borrowed
    struct gp_flare_slot *slot;    // owned
    struct gp_flare_batch *batch;  // owned
    int slots, batches;
    struct gp_flare_items items;   // of the last draw
    struct gp_rect reach;          // of all of them, frame's pixels
    struct gp_rect tile;           // the first, which the last draw left in
                                   // target
};

/* r from the corner of `tile` on. */
static inline struct gp_rect gp_flare_in(struct gp_rect r, struct gp_rect tile)
{
    return (struct gp_rect) {r.x0 - tile.x0, r.y0 - tile.y0, r.x1 - tile.x0,
                             r.y1 - tile.y0};
}

/* Makes batches of s->items (not empty) and brings to the context what they
 * need; s->reach is set. Errors: GP_ERR_GL an image over the context's size,
 * GL's own; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_flare_upload(const struct gp_log *log,
                                        const struct gp_gl *gl,
                                        struct gp_flare_gl *s);
void gp_flare_free_slots(const struct gp_gl *gl, struct gp_flare_slot **slot,
                         int *n);

#endif
