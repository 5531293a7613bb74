// SPDX-License-Identifier: Apache-2.0
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
    double aspect;                 // width over height of a frame's pixel; 0:
                                   // square
    double scale;                  // frame pixels a pixel of the image, down;
                                   // 0: 1
    double left_out;               // gp_kernel's, of the model that drew the
                                   // image; 0: it is no model's
    const float *chromaticities;   // 8, of the frames, as struct gp_image has
                                   // them; borrowed; NULL: the image's
};

struct gp_far_field; // glare/far_field/far_field.h
struct gp_sky;       // glare/sky/sky.h
struct gp_source;    // glare/sources.h

/* A normalised kernel. Sample (x, y) of `k` is the share of a source's light
 * that falls (x - cx, y - cy) pixels away: layer(p) = sum source(q) k(p - q).
 * With a far field `k` is only the core, and the far field's light is added.
 * Samples may be negative. Magnitudes under FLT_MIN, 1.2e-38, become 0. Rows
 * and columns of zeros at the border are cut off. */
struct gp_kernel {
    int w, h;
    int cx, cy;           // the centre's pixel; may lie outside [0,w) x [0,h)
                          // after cutting zero borders
    struct gp_planes k;   // w * h each
    struct gp_far_field *far; // NULL: `k` is the whole kernel; owned
    struct gp_sky *sky;   // light by true angles, which is added; NULL: none;
                          // owned. Sums and norms are without it
    double sum[3];        // of samples by channel, the far field's too
    double norm2[3];      // root of their sum of squares, and ...
    double norm1[3];      // ... sum of magnitudes; upper limits of both with a
                          // far field
    double faint[3];      // sum of magnitudes that became 0, by channel
    bool grey;            // the three planes are equal
    bool negative;        // a sample is under 0
    double over; // magnitudes are at most so often the light of samples and
                 // sky together: 1, or INFINITY where that is not known
    unsigned long serial; // by gp_serial_next(): two kernels with the same one
                          // are the same; 0: made by hand, nothing is known
    bool resampled;       // by an angle that is not right, or to another size
    double left_out;      // of a model: 1 less the luminance of `sum`, which is
                          // light that falls outside of frames; else 0
    struct gp_kernel_origin *origin; // recipes and field of a model's kernel
                          // (model/make.c); owned
};

/* Makes a kernel from planes that were read from a file.
 *
 *   image      rgb and luminance weights of the kernel file; borrowed
 *   out        written only on GP_OK; free with gp_kernel_free()
 *
 * First an image that names its primaries is converted to p->chromaticities by
 * gp_spectrum_to_spectrum(). Where that makes a channel of a sample negative,
 * gp_gamut_fold() ends that. Then the image is rotated by p->rotate about its
 * centre, pixel (floor(w/2), floor(h/2)) of the data window unless p->centered.
 * For another scale, or pixels that are not square, it is resampled by areas,
 * which keeps each channel's sum, and its centroid within 1e-3 pixel. At last
 * it is divided by its sum in luminance, unless GP_NORMALIZE_NONE.
 * Errors: GP_ERR_DATA no pixels, a NaN or Inf (says where), no FLT_MIN in it, a
 * luminance sum that is not positive when normalising, primaries that cannot be
 * converted; GP_ERR_USAGE a centre over 2^20 pixels away, an angle that is not
 * finite, a rotated or resampled kernel of over 2^28 pixels. */
GP_MUST_CHECK gp_status gp_kernel_from_frame(const struct gp_log *log,
    const struct gp_kernel_params *p, const struct gp_image *image,
    struct gp_kernel *out);

/* Makes a kernel of planes as they are, w * h each, its centre pixel
 * (floor(w/2), floor(h/2)); takes them, also on failure.
 * Errors: GP_ERR_DATA no light in it, or a sample that is not finite. */
GP_MUST_CHECK gp_status gp_kernel_of_planes(const struct gp_log *log,
    const char *name, int w, int h, struct gp_planes *planes,
    struct gp_kernel *out);

void gp_kernel_free(struct gp_kernel *k);

/* Returns the sample of the centre, 0 where that is outside. */
static inline float gp_kernel_centre(const struct gp_kernel *k, int c)
{
    return gp_planes_at(&k->k, c, k->w, k->h, k->cx, k->cy);
}

/* Sums samples of channel c over boxes, or their squares: at y (w + 1) + x of (h + 1)
 * (w + 1) doubles those above and left of (x, y). */
void gp_kernel_sums(const struct gp_kernel *k, int c, bool squares, double *to);

/* The samples up to (x, y) from the centre, x and y under 2^30. */
static inline struct gp_rect gp_kernel_around(const struct gp_kernel *k, int x,
                                              int y)
{
    return gp_rect_meet(
        (struct gp_rect) {0, 0, k->w, k->h},
        (struct gp_rect) {k->cx - x, k->cy - y, k->cx + x + 1, k->cy + y + 1});
}

/* Adds to the layer of a frame of w x h pixels what n sources beside it, of which places
 * count from its corner, light there by true angles; k->sky is not NULL. The farther a
 * tile of pixels is, the larger are the groups of sources that count as one, so that a
 * disc costs little more than a lamp. */
GP_MUST_CHECK gp_status gp_kernel_add_beyond(const struct gp_log *log,
                                             const struct gp_kernel *k,
                                             const struct gp_source *source,
                                             size_t n, int w, int h,
                                             struct gp_planes *layer);

/* A kernel spread over a light's disc: the layer of a disc of flux 1. */
struct gp_spread_kernel {
    int w, h;
    double cx, cy;        // the disc's centre, pixel (i,j) covers [i, i + 1)
    struct gp_planes k;   // w * h each
    int step;             // pixels from sample to sample: 1 of a core
};

/* Spreads k over a disc in (2 reach + 1)^2 pixels around the kernel's centre.
 * `weight` has each pixel's share of the light, row after row; their sum is 1.
 *
 *   out  w = k->w + 2 reach, h alike; written only on GP_OK; free its planes
 *        with gp_planes_free()
 * Errors: those of gp_glare_run(). */
GP_MUST_CHECK gp_status gp_kernel_spread(const struct gp_log *log,
    const struct gp_kernel *k, int reach, const float *weight,
    struct gp_spread_kernel *out);

/* Spreads k's far field, which it must have, where gp_kernel_spread() does so
 * with the core. Between samples it is linear within 1 %. */
GP_MUST_CHECK gp_status gp_kernel_spread_far(const struct gp_log *log,
    const struct gp_kernel *k, int reach, const float *weight,
    struct gp_spread_kernel *out);

#endif
