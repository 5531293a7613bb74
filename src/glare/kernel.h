/* The glare kernel: the point-spread function of one bright pixel. */
#ifndef GP_GLARE_KERNEL_H
#define GP_GLARE_KERNEL_H

#include "core/image.h"
#include "core/status.h"

#include <stdbool.h>

enum gp_normalize { GP_NORMALIZE_LUMINANCE, GP_NORMALIZE_NONE };

/* Settings by which an image becomes a kernel. */
struct gp_kernel_params {
    bool centered;                 // `center` was given
    double center[2];              // x, y in EXR pixel space of the kernel's
                                   // image (centre of pixel i is i + 0.5);
                                   // the pixel that holds it is the centre
    enum gp_normalize normalize;
    float rotate;                  // degrees, counter-clockwise as seen (y is
                                   // down), about the centre's pixel
    double aspect;                 // width over height of the pixels that it
                                   // is made for; 0: square
    double scale;                  // their number for one pixel of the image's
                                   // height; 0: 1
    double left_out;               // of a model whose kernel the image is:
                                   // becomes the kernel's; else 0
    const float *chromaticities;   // 8, of the frames that it is made for, as
                                   // gp_frame's; borrowed; NULL: the image's
};

/* The kernel before --rotate, scaled by the same factor, so that
 *   kernel(dx, dy) = bilinear(unturned, (cos * dx - sin * dy,
 *                                        sin * dx + cos * dy))
 * for whole offsets dx, dy from the centre, with zero outside. */
struct gp_unturned {
    int w, h;
    int cx, cy;           // the centre's pixel; may lie outside
    struct gp_planes k;   // w * h each
    double cos, sin;      // of the angle
};

struct gp_far_field; // glare/far_field/far_field.h

/* The samples of a row of one channel that are not 0. */
struct gp_lit_row {
    int from, to; // half-open: all are in it; empty where there is none
    int dark;     // samples in it that are 0
};

/* A normalised kernel. Sample (x, y) is the share of a source's light that
 * falls (x - cx, y - cy) pixels away: layer(p) = sum source(q) k(p - q), and
 * that of the far field, where there is one: then k is only the core.
 * Negative lobes are allowed. Zero borders are cut off on making; magnitudes
 * under FLT_MIN, 1.2e-38, are 0. */
struct gp_kernel {
    int w, h;
    int cx, cy;           // the centre's pixel; may lie outside [0,w) x [0,h)
                          // after cutting zero borders
    struct gp_planes k;   // w * h each
    struct gp_far_field *far; // what is beyond the core; NULL: nothing; owned
    double sum[3];        // of each channel, with the far field
    double norm2[3];      // sqrt of the sum of squares of each channel, and ...
    double norm1[3];      // ... sum of magnitudes; limits with a far field
    double faint[3];      // magnitudes of each channel that count as 0
    bool grey;            // the three planes are equal
    bool negative;        // a sample is under 0
    struct gp_lit_row *lit; // of row y of channel c: lit[c * h + y]; owned.
                          // NULL where nothing is known of the samples: they
                          // or the centre were changed. No quarters then
    // A quarter of the kernel has its centre's row and column. Least of the
    // four, of each channel; 0 of a negative kernel:
    double quarter_square[3]; // sum of squares
    double quarter_sum[3];    // sum of samples
    unsigned long serial; // gp_serial_next() of this making; 0 (made by hand)
                          // is never taken for known
    struct gp_unturned *unturned; // NULL when the kernel was not rotated, or
                          // by right angles, which need no sampling; owned
    double left_out;      // of a model: light that falls where nothing is
                          // computed, in luminance, most of it outside of the
                          // frame; else 0
    struct gp_kernel_origin *origin; // recipes and field of a model's kernel
                          // (model/make.c); owned
};

/* Makes a kernel from planes that were read from a file.
 *
 *   image      rgb and luminance weights of the kernel file; borrowed
 *   out        written only on GP_OK; free with gp_kernel_free()
 *
 * The centre is pixel (floor(w/2), floor(h/2)) of the data window unless
 * p->centered. Rotated about it by p->rotate. Normalised then so that
 * each channel's sum keeps the file's ratios and the luminance sum is 1,
 * unless GP_NORMALIZE_NONE. For another scale, or pixels that are not square,
 * it is resampled by areas after it was turned: it is round on the screen, and
 * each channel's sum and centroid (within 1e-3 pixel) stay.
 * First of all, an image that names its primaries is converted to those of
 * p->chromaticities by gp_spectrum_to_spectrum(). A sample of no negative channel
 * that gets one is folded in by gp_gamut_fold().
 * Errors: GP_ERR_DATA no pixels, a NaN or Inf (says where), all zero or faint, a
 * luminance sum that is not positive when normalising, primaries that cannot be
 * converted; GP_ERR_USAGE a centre over 2^20 pixels away, an angle that is not
 * finite, a rotated or resampled kernel of over 2^28 pixels. */
GP_MUST_CHECK gp_status gp_kernel_from_frame(const struct gp_log *log,
    const struct gp_kernel_params *p, const struct gp_image *image,
    struct gp_kernel *out);

/* Makes a kernel of planes as they are, w * h each, its centre pixel
 * (floor(w/2), floor(h/2)); takes them, also on failure.
 * Errors: GP_ERR_DATA no light in it, or a sample that is not finite;
 * GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_kernel_of_planes(const struct gp_log *log,
    const char *name, int w, int h, struct gp_planes *planes,
    struct gp_kernel *out);

void gp_kernel_free(struct gp_kernel *k);

/* A kernel spread over a light's disc: the layer of that disc of flux 1. */
struct gp_spread_kernel {
    int w, h;
    double cx, cy;        // the disc's centre, pixel (i,j) covers [i, i + 1)
    struct gp_planes k;   // w * h each
    int step;             // pixels from sample to sample; 1, but of a far field
};

/* Spreads k over the (2 reach + 1)^2 pixels of a disc around its centre's
 * pixel; `weight` has their shares of the light, row after row, of sum 1.
 *
 *   out  w = k->w + 2 reach, h alike; written only on GP_OK; free its planes
 *        with gp_planes_free()
 * Errors: those of gp_glare_run(). */
GP_MUST_CHECK gp_status gp_kernel_spread(const struct gp_log *log,
    const struct gp_kernel *k, int reach, const float *weight,
    struct gp_spread_kernel *out);

/* The same of k's far field, which there must be, where `k` above is its core:
 * samples every out->step pixels, between which it is linear within 1 %. */
GP_MUST_CHECK gp_status gp_kernel_spread_far(const struct gp_log *log,
    const struct gp_kernel *k, int reach, const float *weight,
    struct gp_spread_kernel *out);

#endif
