/* What the bound keeps for one kernel; only bound*.c include this. */
#ifndef GP_GLARE_BOUND_STATE_H
#define GP_GLARE_BOUND_STATE_H

#include "glare/bound/bound.h"
#include "glare/bound/cells.h"
#include "glare/bound/rings.h"
#include "glare/bound/spectrum.h"

#include <stdbool.h>

/* Of the kernel's tail or whole, and one width of border. */
struct gp_bound_drawn {
    bool has_power, has_most, has_rings;
    struct gp_power power;
    struct gp_cell_table most;
    struct gp_bound_rings rings;
};

struct gp_bound_state {
    bool lobes;             // nothing can be said
    int channels;           // 1 for a grey kernel
    bool has_least;
    double *square[3];      // integral images of k^2
    float *near[3], *far[3]; // least means over cells, by offset
    int far_reach;
    int w, h;               // of the frames that the rest is for
    struct gp_bound_cells cells;
    struct gp_bound_drawn drawn[2][2]; // [tail][wide border]
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

#endif
