// SPDX-License-Identifier: Apache-2.0
/* The far field: what a kernel has beyond its core, added on a coarse grid.
 *
 *   K(d) = K(d) (1 - share(d)) + K(d) share(d),    share 0 to 1 as |d| grows
 *
 * The first part is the core. It is summed at every pixel, and its rim is 0.
 * The second part is the far field T. It is smooth over some 95 pixels, the
 * width in which `share` grows. So samples at every 8th pixel hold it.
 *
 * Let B be the cubic B-spline of step s, and j and k nodes of the grid. Then
 *
 *   far(p) = sum_j B(p/s - j) sum_k C(j - k) sum_q B(q/s - k) source(q)
 *
 * From the right: light q is set down on the nodes around it, nodes are
 * convolved with C by a Fourier transform, and pixels are read between nodes. C
 * is T at the nodes, divided by B's own samples once for each of the two
 * splines. So from node to node the sum gives T itself.
 *
 * The error. Light of one frequency also comes out at the frequencies that are
 * 1/s apart, its images. For a frequency f of the grid let
 *
 *   F     be the transform of T's samples, times s^2
 *   beta  what the splines keep of it
 *   eps   the 2-norm of what they let through of the images
 *
 * By Parseval the norm of the error is at most
 *
 *   |source| (max_f F (|1 - beta^2| + beta eps + eps^2) + 2 max_edge F)
 *
 * The last term is for what T has at frequencies that the grid does not hold.
 * It is taken to be no more than what T has in the last tenth of those that it
 * does. */
#ifndef GP_GLARE_FAR_FIELD_H
#define GP_GLARE_FAR_FIELD_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"

#include <stdbool.h>

/* Pixels from the centre at which the core of a kernel that is smooth from
 * there on ends, where the coarse grid's step is 8. */
enum { GP_FAR_CORE = 127 };

/* The distances over which a kernel changes from core to far field. */
struct gp_far_split {
    double from, to; // pixels from the centre: only core, only far field
    int step;        // of the coarse grid; 0: no far field, all is core
};

/* Chooses the split of frames of w x h pixels for a kernel that, from `smooth`
 * pixels on, bends only on the scale of the distance, beside one that reaches
 * `sharp` pixels and stays in the core. Circles of it are `stretch` times as
 * long as wide, in pixels, >= 1. Step 0 where it is not smooth far out
 * (INFINITY), or the whole costs little more than a core. */
struct gp_far_split gp_far_choose(double smooth, double stretch, int sharp,
                                  int w, int h);

/* The far field's share of the sample at offset (x, y), in [0, 1]; the core's
 * is 1 less that. A step of degree 11 in the distance; five derivatives are
 * continuous. */
double gp_far_share(const struct gp_far_split *s, int x, int y);

/* The whole kernel's sample at offset (x, y), >= 0; out[0] only where grey. */
typedef void (*gp_far_sample)(const void *ctx, int x, int y, double out[3]);

/* A kernel that a far field is made of. */
struct gp_far_kernel {
    gp_far_sample sample;
    const void *ctx;
    bool grey;
    bool even; // samples at (-x, y) and (x, -y) are those at (x, y)
};

struct gp_far_field {
    struct gp_far_split split;
    int w, h;           // of the largest frame that it serves, pixels
    int rx, ry;         // offsets -rx .. rx, -ry .. ry of C, in steps
    float *c[3];        // (2 rx + 1) * (2 ry + 1) each; grey: c[0] only
    bool grey;
    double sum[3];      // of the far field over offsets that such a frame meets
    double norm1[3], norm2[3]; // sum, and root of the sum of squares, of the
                        // far field over all offsets; no less
    double least;       // smallest sample that frames meet from split.to on
    unsigned long serial;
};

/* Makes the far field of a kernel for frames of w x h pixels; split->step > 0.
 * Owned by the caller; free with gp_far_free(). *out is written only on GP_OK.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_far_make(const struct gp_log *log,
    const struct gp_far_split *split, int w, int h,
    const struct gp_far_kernel *kernel, struct gp_far_field **out);
void gp_far_free(struct gp_far_field *t); // NULL: nothing

// -- applying it --------------------------------------------------------------

/* Limits of the error of the far field, for light s of one channel. */
struct gp_far_error {
    double norm;   // the error's 2-norm over |s|
    double pixel;  // its largest sample over the sum of s
    double column; // its largest sample over |s|
    double rounding; // over the most that a sample can be
};

/* Transforms, spectrum and scratch for one far field; kept from frame to frame. */
struct gp_far_state;
void gp_far_close(struct gp_far_state **state);

/* Makes *state fit the far field: NULL at first, or any. Errors: GP_ERR_BUG out of
 * memory. */
GP_MUST_CHECK gp_status gp_far_open(const struct gp_log *log,
    const struct gp_far_field *t, struct gp_far_state **state);
const struct gp_far_error *gp_far_error_of(const struct gp_far_state *s);

/* The largest error of a sample of channel c. */
double gp_far_pixel_error(const struct gp_far_state *s,
                          const struct gp_far_field *t,
                          const struct gp_sources *src, int c);

/* The far field of one frame's sources, found on the grid. */
struct gp_far_rows;

/* Finds the far field of the sources, one at least, or of light 1 in every pixel where
 * `src` is NULL, for a layer of w * h, at most t->w * t->h. `state` is open for t; it,
 * the sources and the layer are borrowed. Free with gp_far_rows_free().
 * Errors: GP_ERR_BUG out of memory, a larger frame. */
GP_MUST_CHECK gp_status gp_far_find(const struct gp_log *log,
                                    const struct gp_far_field *t,
                                    const struct gp_far_state *state,
                                    const struct gp_sources *src, int w, int h,
                                    struct gp_planes *layer,
                                    struct gp_far_rows **out);
/* Adds it to row i % h of channel i / h of the layer, i in [0, 3 h), of which no
 * sample becomes negative; a task of gp_parallel_do(), whose ctx are the
 * rows. */
void gp_far_add_row(void *ctx, int i, int thread);
void gp_far_rows_free(struct gp_far_rows **rows);

/* Sets `row` to the far field in row y of channel c. */
void gp_far_row(const struct gp_far_rows *rows, int c, int y, int thread,
                float *row);

// -- shared by the files of this folder ----------------------------------------

enum {
    GP_FAR_TAPS = 4,  // nodes that a cubic B-spline meets, from one before
                      // the pixel's own
    GP_FAR_FADE = 12, // steps over which a far field fades out past the frame
};

/* Nodes that n pixels meet: of pixel x from x / step on, the first being one
 * step before the frame. */
static inline int gp_far_nodes(int n, int step)
{
    return (n - 1) / step + GP_FAR_TAPS;
}

/* The cubic B-spline at the nodes one before to two after t in [0, 1). */
static inline void gp_far_spline(double t, double b[GP_FAR_TAPS])
{
    const double u = 1.0 - t;
    b[0] = u * u * u / 6.0;
    b[1] = (4.0 + t * t * (3.0 * t - 6.0)) / 6.0;
    b[2] = (4.0 + u * u * (3.0 * u - 6.0)) / 6.0;
    b[3] = t * t * t / 6.0;
}

/* Divides the samples 1/6, 4/6, 1/6 of the cubic B-spline out of w x h values, so many
 * times, zero beyond them: Unser et al. 1993, part II, eq. 2.5. */
void gp_far_divide(double *v, int w, int h, int times);

/* Frequency i of n of an axis, -0.5 to 0.5 periods a step: the transform of the spline's
 * own samples; and over that, `kept` of the band by the spline, and the sum and the
 * sum of squares of it and its images. */
struct gp_far_keeping {
    double own, kept, sum, square;
    bool edge; // near the end of the band, whose half is 0.5
};
struct gp_far_keeping gp_far_keep_of(int i, int n);

#endif
