/* What the bound keeps for one kernel; only bound*.c include this. */
#ifndef GP_GLARE_BOUND_STATE_H
#define GP_GLARE_BOUND_STATE_H

#include "glare/bound.h"

#include <stdbool.h>

/* |K|^2 of the kernel, whole or without its core, on one grid. */
struct gp_bound_power {
    int nx, ny;      // 0: not made
    int channels;
    size_t columns;  // nx / 2 + 1, each of ny numbers
    float *power[3];
};

struct gp_bound_state {
    bool lobes;             // nothing can be said
    int channels;           // 1 for a grey kernel
    bool has_least;
    double *square[3];      // integral images of k^2
    float *near[3], *far[3]; // least means over cells, by offset
    int far_reach;
    struct gp_bound_power power[2]; // [tail]
};

/* The state of this kernel, made new when the cache holds another's. */
GP_MUST_CHECK gp_status gp_bound_state(const struct gp_log *log,
                                       const struct gp_kernel *k,
                                       struct gp_bound_cache *cache,
                                       struct gp_bound_state **out);

/* gp_layer_least() with the kernel's state, which is not made anew. */
GP_MUST_CHECK gp_status gp_bound_least(const struct gp_log *log,
                                       const struct gp_sources *src,
                                       const struct gp_kernel *kernel,
                                       struct gp_bound_state *s,
                                       double *least);

/* || k * d ||_2 over the whole plane for each channel, by Parseval's theorem:
 * the sum of |K|^2 |D|^2 over a grid on which nothing wraps around.
 *   d     w * h samples of each channel
 *   tail  leave the kernel's core out */
GP_MUST_CHECK gp_status gp_bound_convolved(const struct gp_log *log,
                                           const struct gp_kernel *k,
                                           bool tail,
                                           const struct gp_planes *d, int w,
                                           int h, struct gp_bound_state *s,
                                           double norm[3]);

#endif
