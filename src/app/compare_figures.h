/* How far two images are apart, in the figures of OpenImageIO's idiff 2.4 and
 * in those of the engines (the program's own errors). No files, no output. */
#ifndef GP_APP_COMPARE_FIGURES_H
#define GP_APP_COMPARE_FIGURES_H

#include "app/settings.h"
#include "core/status.h"
#include "io/raw_read.h"

#include <stdbool.h>

/* What a comparison says; the numbers are exit statuses, worse is larger. */
enum gp_compare_result {
    GP_COMPARE_MATCH = 0,
    GP_COMPARE_WARNING = 1,
    GP_COMPARE_FAILURE = 2,
    GP_COMPARE_DIFFERENT = 3, // cannot be compared
    GP_COMPARE_FILE = 4,      // a file could not be read or written
};

/* Channels of one name; NULL, and 0 everywhere, in an image without it. */
struct gp_compare_pair {
    const struct gp_raw_channel *a, *b;
};

/* Two images laid over each other. What it borrows must live longer. */
struct gp_compare_match {
    const struct gp_raw_image *a, *b;
    struct gp_rect window;         // union of the data windows
    struct gp_compare_pair *pair;  // R, G, B, A first, else a's order; owned
    int pairs;
    int shared;                    // pairs in which both have a channel
};

/* Finds the pairs by exact names; order does not matter.
 *   m  written always; free with gp_compare_match_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_match_make(const struct gp_log *log,
                                              const struct gp_raw_image *a,
                                              const struct gp_raw_image *b,
                                              struct gp_compare_match *m);
void gp_compare_match_free(struct gp_compare_match *m);

/* The name of a pair's channel. */
const char *gp_compare_name(const struct gp_compare_match *m, int pair);

/* All over the union of the windows; outside its own window an image is 0.
 * Two NaN are equal, and two infinities of one sign. A value that is NaN or
 * infinite against another is an infinite error: it counts in `max` and
 * `nonfinite`, makes its pixel fail and warn, and stays out of the sums. */
struct gp_compare_figures {
    double max;             // largest |a - b|, +Inf for one of `nonfinite`
    int x, y, channel;      // its first pixel, EXR pixel space, and pair
    double worst_a, worst_b;
    double mean, rms;       // of |a - b|, over all values of all pairs
    double psnr;            // dB: 20 log10(peak / rms), peak the largest
                            // |value| of both, at least 1; +Inf for rms 0
    double rel_l2;          // |a - b| over |a|, norms; |a - b| where a is 0
    double max_rel;         // of pixels' luminance: |dY| / (Y of a + 1e-6 of
                            // its maximum); NaN where one has no colour
    long long nonfinite;    // values
    long long warned, failed; // pixels over a limit in some channel
    long long pixels;       // of a: what percentages refer to, as in idiff
    enum gp_compare_result result;  // MATCH, WARNING or FAILURE
};

/* Computes them; the same for any number of threads.
 * Errors: GP_ERR_BUG out of memory.
 * Source: OpenImageIO 2.4 ImageBufAlgo::compare for max, mean, rms, psnr,
 * failed and warned; the relative error there is |a - b| over the mean of |a|
 * and |b|. */
GP_MUST_CHECK gp_status gp_compare_measure(
    const struct gp_log *log, const struct gp_compare_settings *limits,
    const struct gp_compare_match *m, struct gp_compare_figures *out);

/* The colour of both over the window as planes of light, 0 outside their own
 * windows; gp_planes_free() both. Empty where one has no colour.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_light(const struct gp_log *log,
                                         const struct gp_compare_match *m,
                                         struct gp_planes *a,
                                         struct gp_planes *b);

#endif
