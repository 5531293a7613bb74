/* How much light a kernel can make of a residue: what sources and polygons
 * differ by, before either is spread.
 *
 * By Parseval, |k * d|^2 = sum |K|^2 |D|^2 / (nx ny) on a torus of nx * ny
 * pixels. The torus need not hold all that k * d covers: where no wrapped light
 * reaches the frame, the frame's part of the sum is the true one, and the rest
 * only adds to it.
 */
#ifndef GP_GLARE_BOUND_SPECTRUM_H
#define GP_GLARE_BOUND_SPECTRUM_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/fft/fft.h"
#include "glare/splat/group.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

#include <stdbool.h>

/* |K| of one kernel, whole or without its core. */
struct gp_power {
    int nx, ny;         // 0 when no transform was made
    struct gp_fft_plan_pair x, y;
    int channels;       // 1 (grey) or 3
    float *power[3];    // |K|: [column * ny + row], columns 0 .. nx / 2, each
                        // a little over the true value: no rounding hides it
    float *most[3];     // the largest of each column
    double mean2[3];    // mean of |K|^2 over the whole plane
    double norm1[3];    // sum of the kernel's magnitudes
};

/* Makes the power of the part of the kernel that can reach a frame of w x h
 * pixels from sources up to `pad` pixels outside it. Without FFTW, or on a
 * plane over the memory that this may take, there is only norm1.
 * Written only on GP_OK; free with gp_power_free().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_power_make(const struct gp_log *log,
                                      const struct gp_kernel *kernel,
                                      bool tail, int w, int h, int pad,
                                      struct gp_power *out);
void gp_power_free(struct gp_power *p);

/* d = sources - polygons: each polygon is its light set down bilinearly at
 * P0 - (M - 1) / 2 and blurred by its box of side M. */
struct gp_residue {
    int w, h, pad;        // of the frame; the planes have pad pixels around it
    struct gp_planes d;   // (w + 2 pad) * (h + 2 pad)
    int rows;             // rows that are not 0
    int *row;             // which, ascending
    double norm2[3];      // sqrt of the sum of squares
    double rounding[3];   // what norm2 of the error of `d` cannot exceed
};

/* Free with gp_residue_free(). Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_residue_make(const struct gp_log *log,
                                        const struct gp_sources *src,
                                        const struct gp_polygons *polygons,
                                        int pad, struct gp_residue *out);
void gp_residue_free(struct gp_residue *r);

/* What |k * d| over the frame cannot exceed, each channel.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_power_bound(const struct gp_log *log,
                                       const struct gp_power *power,
                                       const struct gp_residue *r,
                                       double out[3]);

#endif
