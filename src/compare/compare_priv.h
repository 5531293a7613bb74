/* The figures of one pair of images: those of OpenImageIO's idiff 2.4, those
 * of the engines (the program's own errors), and FLIP; and their pictures. */
#ifndef GP_COMPARE_COMPARE_PRIV_H
#define GP_COMPARE_COMPARE_PRIV_H

#include "compare/compare.h"
#include "compare/flip.h"
#include "io/read.h"

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
 * with the first such of b, and so on.
 *   m  written always; free with gp_compare_match_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_match_make(
    const struct gp_log *log, const struct gp_stored_image *a,
    const struct gp_stored_image *b, struct gp_compare_match *m);
void gp_compare_match_free(struct gp_compare_match *m);

/* Returns the name of a pair's channel; its value in a or b, 0 outside. */
const char *gp_compare_name(const struct gp_compare_match *m, int pair);
double gp_compare_value(const struct gp_compare_match *m, bool of_b, int pair,
                        int x, int y);

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
    long long seen;         // pixels of visible difference; -1: not counted
    long long pixels;       // of a: what percentages refer to, as in idiff
};

/* Computes them; the same for any number of threads.
 * Errors: GP_ERR_BUG out of memory.
 * Source: OpenImageIO 2.4 ImageBufAlgo::compare for max, mean, rms, psnr,
 * failed and warned; the relative error there is |a - b| over the mean of |a|
 * and |b|. */
GP_MUST_CHECK gp_status gp_compare_measure(
    const struct gp_log *log, const struct gp_compare_params *limits,
    const struct gp_compare_match *m, struct gp_compare_figures *out);

/* The light of an image over the window, 0 outside its own; infinite light
 * counts as 65504 where `hdr`. Both images must be lit.
 *   out  free with gp_planes_free(). Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_light(
    const struct gp_log *log, const struct gp_compare_match *m,
    const struct gp_stored_image *image, bool hdr, struct gp_planes *out);

/* Counts the pixels whose difference is visible; NaN against a number is
 * seen. Primaries are taken as BT.709. Both images must be lit; the same for
 * any number of threads. Errors: GP_ERR_BUG out of memory.
 * Source: Yee 2004, as figures.c has it. */
GP_MUST_CHECK gp_status gp_compare_see(const struct gp_log *log,
    const struct gp_compare_match *m, long long *seen);

struct gp_compare_flip {
    bool known;    // false: an image has no colour, or --no-flip
    bool hdr;      // HDR-FLIP; LDR-FLIP where both are stored as integers
    double mean;   // of the map, 0 to 1
    struct gp_flip_exposures exposures; // of HDR-FLIP
    float *map;    // of the window, rows from the top; owned
};

/* Computes FLIP; infinite light counts as 65504, as in frames. The first image
 * is the reference whose exposures are found. Primaries are taken as BT.709.
 *   out  written always; free with gp_compare_flip_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_flip(
    const struct gp_log *log, const struct gp_compare_params *p,
    const struct gp_compare_match *m, struct gp_compare_flip *out);
void gp_compare_flip_free(struct gp_compare_flip *f);

/* MATCH, WARNING or FAILURE, as idiff 2.4.7 to 3.x have it: no more than
 * allow_failures failing pixels match, whatever the other limits are. Beside
 * that rel_l2 over fail_rel and FLIP over fail_flip are failures. */
enum gp_compare_result gp_compare_judge(const struct gp_compare_params *limits,
    const struct gp_compare_figures *f, const struct gp_compare_flip *flip);

/* Writes the map in the colours of magma, 0 black to 1 pale yellow, as the
 * ending of `path` says. The map must be known.
 * Errors: as gp_write_picture(). */
GP_MUST_CHECK gp_status gp_compare_heatmap(
    const struct gp_log *log, const struct gp_write_params *p, const char *path,
    const struct gp_compare_match *m, const struct gp_compare_flip *f);

/* Writes a - b of flat images, or |a - b|, times p->scale, over the union of
 * the windows: all channels as floats to .exr; to other formats R, G and B, or
 * the first channel as grey, of which integer ones keep [0,1] without a
 * curve.
 * Errors: as gp_write_picture(); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_subtract(const struct gp_log *log,
    const struct gp_write_params *write, const struct gp_compare_params *p,
    const char *path, const struct gp_compare_match *m);

/* The colour of v (0 to 1, clamped; NaN is 0) in magma, sRGB-encoded, 0 to 1:
 * a polynomial near the map of Smith and van der Walt (matplotlib 1.5). */
void gp_compare_magma(float v, float rgb[3]);

#endif
