/* Light that lies together, as in lamps, windows, skies, in columns of four.
 *
 * Four sources one above the other shine through one row of the kernel on
 * four pixels one above the other, so that a sample of the kernel that was
 * loaded once serves four products.
 */
#ifndef GP_GLARE_DIRECT_QUAD_H
#define GP_GLARE_DIRECT_QUAD_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/direct/direct.h"
#include "glare/sensors.h"

enum { GP_QUAD = 4 };

/* Sources (x, y), (x, y + 1), (x, y + 2), (x, y + 3) for each x and y where one
 * of them is light; dark ones are 0. Those of y are [row[y + 3], row[y + 4]),
 * from y = -3 on, x ascending. */
struct gp_quads {
    size_t n;
    uint32_t *row;   // h + GP_QUAD offsets
    int32_t *x;      // n columns
    float *light[3]; // GP_QUAD * n each
};

/* How many there are, counted in every `step`-th row and multiplied: n to
 * 4 n for n sources. */
size_t gp_quads_count(const struct gp_sources *src, int step);

/* Errors: GP_ERR_BUG out of memory. Free with gp_quads_free(). */
GP_MUST_CHECK gp_status gp_quads_make(const struct gp_log *log,
                                      const struct gp_sources *src,
                                      struct gp_quads *out);
void gp_quads_free(struct gp_quads *q);

/* gp_direct_sum() of w x h pixels, in the same order of the sources and within
 * the same bound. (h + taps->h) * taps->pitch must fit an int; best when the
 * taps fit the second-level cache. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_quads_sum(const struct gp_log *log,
                                     const struct gp_quads *quads,
                                     const struct gp_taps *taps, int w, int h,
                                     bool add, struct gp_planes *layer);

#endif
