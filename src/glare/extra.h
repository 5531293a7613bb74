/* Light that is not in the frame's pixels: lamps and suns whose flux was
 * given, spread over the pixels of their discs, join the sources. */
#ifndef GP_GLARE_EXTRA_H
#define GP_GLARE_EXTRA_H

#include "core/status.h"
#include "glare/sensors.h"

/* Light on one pixel of the frame. */
struct gp_extra {
    int x, y;      // from the data window's corner, inside the frame
    float rgb[3];  // finite, >= 0
};

/* `src` and `n` pixels of extra light together: where both have the same
 * pixel, or several extras do, their light adds up. Pixels that are black are
 * left out. All but the list itself (sizes, nonfinite, darkest ...) is src's.
 *
 *   extra  put into row order, equal ones together
 *   out    written only on GP_OK; free with gp_sources_free()
 * Errors: GP_ERR_BUG out of memory, or a pixel outside the frame. */
GP_MUST_CHECK gp_status gp_sources_with(const struct gp_log *log,
                                        const struct gp_sources *src,
                                        struct gp_extra *extra, size_t n,
                                        struct gp_sources *out);

#endif
