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
 * Planes are w * h samples, rows from the top. Every result is the same for any
 * number of threads, and the same for (a, b) and (b, a) at equal exposures.
 */
#ifndef GP_COMPARE_FLIP_H
#define GP_COMPARE_FLIP_H

#include "core/image.h"
#include "core/status.h"

enum { GP_FLIP_EXPOSURES_MAX = 64 };

/* LDR-FLIP of two pictures.
 *
 *   a, b   display-linear BT.709 (the sRGB curve undone); values outside [0,1]
 *          are clamped, NaN counts as 0
 *   map    w * h values in [0,1]
 *   mean   of the map; written only on GP_OK
 *
 * Beyond the border the outermost pixels are repeated. */
GP_MUST_CHECK gp_status gp_flip_ldr(
    const struct gp_log *log, int w, int h, const struct gp_planes *a,
    const struct gp_planes *b, float *map, double *mean);

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

/* HDR-FLIP: for each pixel the largest LDR-FLIP of all exposures, each tone
 * mapped by the ACES curve (Narkowicz 2016, its input times 0.6).
 *
 *   reference, test  scene-linear BT.709; negative and NaN count as 0
 *   e                the exposures
 *
 * The rest as in gp_flip_ldr(). Errors: GP_ERR_USAGE exposures that are not
 * finite, or a count out of range. */
GP_MUST_CHECK gp_status gp_flip_hdr(const struct gp_log *log, int w, int h,
    const struct gp_planes *reference, const struct gp_planes *test,
    const struct gp_flip_exposures *e, float *map, double *mean);

#endif
