// SPDX-License-Identifier: Apache-2.0
/* The difference of two images in memory: the figures of OpenImageIO's idiff
 * 2.4, those of the engines (the program's own errors), FLIP, and what an eye
 * sees. All are the same for any number of threads. Images, limits and figures
 * are those of glarepp.h. */
#ifndef GP_COMPARE_COMPARE_H
#define GP_COMPARE_COMPARE_H

#include "core/image.h"
#include "core/status.h"
#include "glarepp.h"

#include <stdbool.h>

/* Two images over each other, both borrowed: they must outlive it. Channels of
 * one name are a pair, or of one number where the name fits none. */
struct gp_compare_match {
    const struct glarepp_stored *a, *b;
    struct gp_rect window; // union of the data windows
    int pairs;             // R, G, B, A first, else a's order
    const char **name;     // of each, borrowed in a list that is owned
    int *in[2];            // channel of each in a and b, owned; -1: none, and 0
                           // everywhere
    bool lit;                      // both have colour
    float luminance[3];            // weights of a's primaries
};

/* Finds the pairs: by exact names, then the first channel of a that fits none
 * with the first such of b, and so on. The other calls hold every pixel of the
 * window, which is large where the images are far apart: look at it first.
 *   m  written always; free with gp_compare_match_free() */
GP_MUST_CHECK gp_status gp_compare_match_make(
    const struct gp_log *log, const struct glarepp_stored *a,
    const struct glarepp_stored *b, struct gp_compare_match *m);
void gp_compare_match_free(struct gp_compare_match *m);

/* Sets *out: figures over the union of the windows; outside its own window an
 * image is 0, and so are the samples that a deep pixel has less than that of the
 * other. Two NaN are equal, and two infinities of one sign. A value that is NaN
 * or infinite against another is an infinite error: it counts in `max` and
 * `nonfinite`, makes its pixel fail and warn, and stays out of the sums.
 * psnr is 20 log10(peak / rms), peak the largest |value| of both, at least 1.
 * Source: OpenImageIO 2.4 ImageBufAlgo::compare for max, mean, rms, psnr,
 * failed and warned; the relative error there is |a - b| over the mean of |a|
 * and |b|. */
GP_MUST_CHECK gp_status gp_compare_measure(
    const struct gp_log *log, const struct glarepp_compare_params *limits,
    const struct gp_compare_match *m, struct glarepp_compare_facts *out);

/* Counts the pixels whose difference is visible; NaN against a number is
 * seen. Primaries are taken as BT.709. Both images must be lit.
 * Source: Yee 2004, as perceptual.c has it. */
GP_MUST_CHECK gp_status gp_compare_see(const struct gp_log *log,
    const struct gp_compare_match *m, long long *seen);

/* The light of an image over the window, 0 outside its own; infinite light
 * counts as 65504 where `hdr`, as in frames. Both images must be lit.
 *   out  free with gp_planes_free() */
GP_MUST_CHECK gp_status gp_compare_light(
    const struct gp_log *log, const struct gp_compare_match *m,
    const struct glarepp_stored *image, bool hdr, struct gp_planes *out);

// -- FLIP ---------------------------------------------------------------------

/* FLIP: how different two pictures look when they are shown in turn, a number
 * in [0,1] for each pixel.
 *
 * LDR-FLIP: Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild,
 *   FLIP: A Difference Evaluator for Alternating Images, HPG 2020.
 * HDR-FLIP: Andersson, Nilsson, Shirley, Akenine-Moeller, Visualizing Errors in
 *   Rendered High Dynamic Range Images, Eurographics 2021 short papers.
 *
 * A degree of view has 67.02 pixels, as the papers take it: 3840 pixels on a
 * display 0.7 m wide, seen from 0.7 m.
 *
 * Planes are w * h samples, rows from the top. Results are the same for (a, b) and
 * (b, a) at equal exposures. */
enum { GP_FLIP_EXPOSURES_MAX = 64 };

/* The exposures at which two frames are compared: `count` of them, in equal
 * steps from start to stop, in EV. */
struct gp_flip_exposures {
    float start, stop;
    int count;  // 1 to GP_FLIP_EXPOSURES_MAX; only start when 1
};

/* The exposures that fit a reference frame (Andersson et al. 2021, section 4):
 * at `start` the largest luminance is mapped to 0.85, at `stop` the median is;
 * about one EV between two of them, and at least two.
 *
 *   reference  `pixels` samples, scene-linear BT.709; negative and NaN are 0
 *
 * A median of 0, which the paper leaves open, is replaced by that of the pixels
 * over 0; a black frame gives exposure 0, once. */
GP_MUST_CHECK gp_status gp_flip_exposures_find(
    const struct gp_log *log, size_t pixels, const struct gp_planes *reference,
    struct gp_flip_exposures *out);

/* FLIP of two pictures. Beyond the border the outermost pixels are repeated.
 *
 *   a, b  of LDR-FLIP, where `e` is NULL: display-linear BT.709 (the sRGB curve
 *         undone); values outside [0,1] are clamped, NaN counts as 0. Of
 *         HDR-FLIP: scene-linear BT.709; negative and NaN count as 0
 *   e     exposures, each tone mapped by the ACES curve (Narkowicz 2016, its input
 *         times 0.6): the largest LDR-FLIP of all counts
 *   map   w * h values in [0,1]
 *   mean  of the map; written only on GP_OK
 *
 * Errors: GP_ERR_USAGE exposures that are not finite, or a count out of range. */
GP_MUST_CHECK gp_status gp_flip(const struct gp_log *log, int w, int h,
                                const struct gp_planes *a,
                                const struct gp_planes *b,
                                const struct gp_flip_exposures *e, float *map,
                                double *mean);

/* Computes FLIP of lit images, LDR-FLIP where both are stored as integers, at
 * the exposures of `p` or, of none, those that fit a. Primaries are taken as
 * BT.709. Sets what *out says of FLIP.
 *   map  of the window, rows from the top; gp_free()
 * Errors: those of gp_flip(). */
GP_MUST_CHECK gp_status gp_compare_flip(
    const struct gp_log *log, const struct glarepp_compare_params *p,
    const struct gp_compare_match *m, struct glarepp_compare_facts *out,
    float **map);

/* Sets gates and `result` as idiff 2.4.7 to 3.x have it: no more than allow_failures
 * failing pixels match, whatever the other limits are. Beside that rel_l2 over
 * fail_rel and FLIP over fail_flip are failures. */
enum { GP_COMPARE_MATCH, GP_COMPARE_WARNING, GP_COMPARE_FAILURE };
void gp_compare_judge(const struct glarepp_compare_params *limits,
                      struct glarepp_compare_facts *f);

// -- pictures, a sample for each pixel of the window -------------------------

/* Draws n values of FLIP, clamped to [0, 1]; NaN is 0. Colours are display-linear
 * BT.709 of magma, black to pale yellow: a polynomial near the map of Smith and
 * van der Walt (matplotlib 1.5). */
void gp_compare_heatmap(const float *map, size_t n, const struct gp_planes *to);

/* Sets `to` to a - b of a pair of flat images, or |a - b|, times `scale`. */
void gp_compare_subtract(const struct gp_compare_match *m, int pair,
                         bool absolute, float scale, float *to);

#endif
