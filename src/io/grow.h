// SPDX-License-Identifier: Apache-2.0
/* Grows frames to the window of their outputs: glare reaches out of a data window
 * that holds only the pixels with something, and a sun may be outside of it. */
#ifndef GP_IO_GROW_H
#define GP_IO_GROW_H

#include "core/depth.h"
#include "io/frame.h"
#include "core/status.h"

struct gp_grow_params {
    int left, top, right, bottom; // pixels beyond the union; in [0, 2^24]
    const char *depth;            // one more channel that is depth, or NULL
    enum glarepp_depth type;      // of all that are depth
};

/* Returns the union of f's data and display window, extended by p's edges. An
 * empty display window counts as none. */
struct gp_rect gp_grow_window(const struct gp_grow_params *p,
                              const struct gp_frame *f);

/* Returns the smallest window that holds `window` and f->data and fits the
 * grids of all subsampled channels that f carries. */
struct gp_rect gp_grow_align(const struct gp_frame *f, struct gp_rect window);

/* Grows f->data to `window`; f->read keeps the old one, the display window
 * stays.
 *
 *   f       as read: rgb and channels; its other planes empty
 *   window  of gp_grow_align() for this frame; f->data: nothing happens
 *
 * New pixels are black; carried channels are 0 there, ids of Cryptomatte and
 * coverage too. Channels that are depth by their names (channels.h) get the
 * empty value that most of their own samples have, or, where they have none,
 * the farthest.
 * On failure f may only be freed. */
GP_MUST_CHECK gp_status gp_grow(const struct gp_log *log,
    const struct gp_grow_params *p, struct gp_rect window, struct gp_frame *f);

/* Checks a window that a frame of `path` would grow to.
 * Errors: GP_ERR_DATA more than max_pixels, or edges that int cannot hold four
 * times; the line names --grow none. Warns where it takes memory out of
 * proportion: over 16 Mi pixels, and over 16 times those of the file. */
GP_MUST_CHECK gp_status gp_grow_check(const struct gp_log *log,
    const struct gp_frame *f, struct gp_rect window, long long max_pixels);

#endif
