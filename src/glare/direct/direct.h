// SPDX-License-Identifier: Apache-2.0
/* The convolution sum as it is written, source by source. */
#ifndef GP_GLARE_DIRECT_DIRECT_H
#define GP_GLARE_DIRECT_DIRECT_H

#include "core/image.h"
#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sources.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A kernel laid out for direct sums: each row has GP_TAPS_PAD zeros on both
 * sides, so that a strip of that many pixels never needs a border case. */
enum { GP_TAPS_PAD = 32 };
struct gp_taps {
    int w, h, cx, cy;  // as in gp_kernel
    size_t pitch;      // floats from row to row
    float *k[3];       // one block; a grey kernel's are the same
};

/* Copies the part of the kernel within rx pixels of its centre in x and ry in
 * y. Free out->k[0]. */
GP_MUST_CHECK gp_status gp_taps_cut(const struct gp_log *log,
                                    const struct gp_kernel *kernel, int rx,
                                    int ry, struct gp_taps *out);

/* Adds the sum to the layer (`add`), or writes it there. Each sample is summed
 * in the order of the sources, in float, in groups of 32 whose sums are added
 * with compensation, so that its error grows only with the group. */
GP_MUST_CHECK gp_status gp_direct_sum(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_taps *taps, bool add,
    struct gp_planes *layer);

/* Multiply-adds that gp_direct_sum makes on a channel: each source's kernel,
 * cut to the frame. No more rows are counted from where they are over `most`. */
double gp_direct_work(const struct gp_sources *src, int w, int h, int cx,
                      int cy, double most);

/* First index in [lo, hi) whose column is >= x. */
static inline uint32_t gp_first_from(const int32_t *col, uint32_t lo,
                                     uint32_t hi, int x)
{
    while (lo < hi) {
        const uint32_t mid = lo + (hi - lo) / 2;
        if (col[mid] < x)
            lo = mid + 1;
        else
            hi = mid;
    }
    return lo;
}

#endif
