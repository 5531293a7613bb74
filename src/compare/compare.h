/* How different two images in memory are: the figures of OpenImageIO's idiff
 * 2.4, those of the engines (the program's own errors), FLIP, and what an eye
 * sees. All are the same for any number of threads. */
#ifndef GP_COMPARE_COMPARE_H
#define GP_COMPARE_COMPARE_H

#include "compare/flip.h"
#include "core/status.h"
#include "core/stored.h"

#include <math.h>
#include <stdbool.h>

/* Channels of one name, or of one number where the name fits none; NULL, and
 * 0 everywhere, in an image without it. */
struct gp_compare_pair {
    const struct gp_stored_channel *a, *b;
};

/* Two images over each other, both borrowed: they must outlive it. */
struct gp_compare_match {
    const struct gp_stored_image *a, *b;
    struct gp_rect window;         // union of the data windows
    struct gp_compare_pair *pair;  // R, G, B, A first, else a's order; owned
    int pairs;
    bool lit;                      // both have colour
};

/* Finds the pairs: by exact names, then the first channel of a that fits none
 * with the first such of b, and so on. The other calls hold every pixel of the
 * window, which is large where the images are far apart: look at it first.
 *   m  written always; free with gp_compare_match_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_match_make(
    const struct gp_log *log, const struct gp_stored_image *a,
    const struct gp_stored_image *b, struct gp_compare_match *m);
void gp_compare_match_free(struct gp_compare_match *m);

/* Returns the name of a pair's channel. */
const char *gp_compare_name(const struct gp_compare_match *m, int pair);

/* Limits, idiff's and our own. A value counts when it is over an absolute limit
 * and the relative one; errors are of stored values. */
struct gp_compare_params {
    float fail, warn;                   // absolute
    float fail_relative, warn_relative; // of the mean of both magnitudes
    float fail_percent, warn_percent;   // of pixels that may be over it
    float hard_fail, hard_warn;         // that no pixel may exceed, where more
                                        // pixels fail than may
    int allow_failures;                 // pixels that may fail by any amount;
                                        // < 0: all
    float fail_flip, fail_rel;          // mean FLIP, rel_l2; +Inf: no limit
};
#define GP_COMPARE_DEFAULTS                                                   \
    { .fail = 1e-6f, .warn = 1e-6f, .hard_fail = INFINITY,                    \
      .hard_warn = INFINITY, .fail_flip = INFINITY, .fail_rel = INFINITY }

/* All over the union of the windows; outside its own window an image is 0, and
 * so are the samples that a deep pixel has less than that of the other.
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
    long long uneven;       // deep pixels with other numbers of samples, which
    int uneven_x, uneven_y; // fail; the first of them
    long long warned, failed; // pixels over a limit in some channel
    long long seen;         // by gp_compare_see(); -1: not counted
    long long pixels;       // of a: what percentages refer to, as in idiff
};

/* Computes them. Errors: GP_ERR_BUG out of memory.
 * Source: OpenImageIO 2.4 ImageBufAlgo::compare for max, mean, rms, psnr,
 * failed and warned; the relative error there is |a - b| over the mean of |a|
 * and |b|. */
GP_MUST_CHECK gp_status gp_compare_measure(
    const struct gp_log *log, const struct gp_compare_params *limits,
    const struct gp_compare_match *m, struct gp_compare_figures *out);

/* Counts the pixels whose difference is visible; NaN against a number is
 * seen. Primaries are taken as BT.709. Both images must be lit.
 * Errors: GP_ERR_BUG out of memory.
 * Source: Yee 2004, as perceptual.c has it. */
GP_MUST_CHECK gp_status gp_compare_see(const struct gp_log *log,
    const struct gp_compare_match *m, long long *seen);

/* The light of an image over the window, 0 outside its own; infinite light
 * counts as 65504 where `hdr`. Both images must be lit.
 *   out  free with gp_planes_free(). Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_light(
    const struct gp_log *log, const struct gp_compare_match *m,
    const struct gp_stored_image *image, bool hdr, struct gp_planes *out);

struct gp_compare_flip {
    bool known;    // false: not computed, or an image has no colour
    bool hdr;      // HDR-FLIP; LDR-FLIP where both are stored as integers
    double mean;   // of the map, 0 to 1
    struct gp_flip_exposures exposures; // of HDR-FLIP
    float *map;    // of the window, rows from the top; owned
};

/* Computes FLIP; infinite light counts as 65504, as in frames. Primaries are
 * taken as BT.709.
 *   e    exposures of HDR-FLIP; NULL: those that fit a, the reference
 *   out  written always; free with gp_compare_flip_free()
 * Errors: GP_ERR_BUG out of memory; those of gp_flip_hdr(). */
GP_MUST_CHECK gp_status gp_compare_flip(
    const struct gp_log *log, const struct gp_flip_exposures *e,
    const struct gp_compare_match *m, struct gp_compare_flip *out);
void gp_compare_flip_free(struct gp_compare_flip *f);

/* The numbers are exit statuses, worse is larger. */
enum gp_compare_result {
    GP_COMPARE_MATCH = 0,
    GP_COMPARE_WARNING = 1,
    GP_COMPARE_FAILURE = 2,
};

/* As idiff 2.4.7 to 3.x have it: no more than allow_failures failing pixels
 * match, whatever the other limits are. Beside that rel_l2 over fail_rel and
 * FLIP over fail_flip are failures. */
enum gp_compare_result gp_compare_judge(const struct gp_compare_params *limits,
    const struct gp_compare_figures *f, const struct gp_compare_flip *flip);

// -- pictures, a sample for each pixel of the window -------------------------

/* Draws n values of FLIP, clamped to [0, 1]; NaN is 0. Colours are display-linear
 * BT.709 of magma, black to pale yellow: a polynomial near the map of Smith and
 * van der Walt (matplotlib 1.5). */
void gp_compare_heatmap(const float *map, size_t n, const struct gp_planes *to);

/* Sets `to` to a - b of a pair of flat images, or |a - b|, times `scale`. */
void gp_compare_subtract(const struct gp_compare_match *m, int pair,
                         bool absolute, float scale, float *to);

#endif
