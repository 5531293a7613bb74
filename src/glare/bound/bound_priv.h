/* The bound's parts:
 *   spectrum.c  the error of grouping, by the kernel's spectrum
 *   left_out.c  the light that shrinking leaves out, by cells of the frame and
 *               by rings of the kernel; the least light between cells
 *   bound.c     the lower limit of the layer, and the sum of all parts */
#ifndef GP_GLARE_BOUND_BOUND_PRIV_H
#define GP_GLARE_BOUND_BOUND_PRIV_H

#include "core/minmax.h"
#include "glare/bound/bound.h"
#include "glare/fft/fft.h"

#include <stdbool.h>
#include <stdlib.h>

/* The kernel's samples up to (x, y) from its centre. */
static inline struct gp_rect gp_bound_crop(const struct gp_kernel *k, int x,
                                           int y)
{
    const long long cx = k->cx, cy = k->cy;
    return (struct gp_rect) {
        gp_clamp_wide(cx - x, 0, k->w), gp_clamp_wide(cy - y, 0, k->h),
        gp_clamp_wide(cx + x + 1, 0, k->w), gp_clamp_wide(cy + y + 1, 0, k->h),
    };
}

/* Sample (x, y), 0 outside the kernel, and in its core when `tail`. */
static inline float gp_bound_sample(const struct gp_kernel *k, bool tail,
                                    int c, int x, int y)
{
    const bool core = tail && abs(x - k->cx) <= GP_CORE_RADIUS &&
                      abs(y - k->cy) <= GP_CORE_RADIUS;
    return core || x < 0 || x >= k->w || y < 0 || y >= k->h
               ? 0.0f
               : k->k.c[c][(size_t) y * (size_t) k->w + (size_t) x];
}

/* -- spectrum.c: how much light a kernel can make of a residue --------------
 *
 * By Parseval, |k * d|^2 = sum |K|^2 |D|^2 / (nx ny) on a torus of nx * ny
 * pixels. The torus need not hold all that k * d covers: where no wrapped light
 * reaches the frame, the frame's part of the sum is the true one, and the rest
 * only adds to it.
 */

/* |K| of one kernel, whole or without its core. */
struct gp_power {
    int nx, ny;         // 0 when no transform was made
    struct gp_fft_plan_pair x, y;
    int channels;       // 1 (grey) or 3
    float *power[3];    // |K|: [column * ny + row], columns 0 .. nx / 2, each
                        // a little over the true value: no rounding hides it
                        // Not written where that is faint throughout
    float *most[3];     // the largest of each column
    double mean2[3];    // mean of |K|^2 over the whole plane
    double norm1[3];    // sum of the kernel's magnitudes
};

/* Makes the power of the part of the kernel that can reach a frame of w x h
 * pixels from sources up to `pad` pixels outside it. Without FFTW, or on a
 * plane over its limit of memory, only norm1 is found.
 * (The fft engine's spectrum cannot serve: its torus is by the box of the
 * sources, and it is made after the choice that this bound is for.)
 * Written only on GP_OK; free with gp_power_free(). */
GP_MUST_CHECK gp_status gp_power_make(const struct gp_log *log,
    const struct gp_kernel *kernel, bool tail, int w, int h, int pad,
    struct gp_power *out);
void gp_power_free(struct gp_power *p);

/* d = sources - polygons, before either is spread: each polygon is its light
 * set down bilinearly at P0 - (M - 1) / 2 and blurred by its box of side M. */
struct gp_residue {
    int w, h, pad;        // of the frame; the planes have pad pixels around it
    struct gp_planes d;   // (w + 2 pad) * (h + 2 pad)
    int rows;             // rows that are not 0
    int *row;             // numbers of these rows, ascending
    double norm2[3];      // sqrt of the sum of squares
    double rounding[3];   // bound of norm2 of the error of `d`
};

/* Free with gp_residue_free(). */
GP_MUST_CHECK gp_status gp_residue_make(const struct gp_log *log,
    const struct gp_sources *src, const struct gp_polygons *polygons, int pad,
    struct gp_residue *out);
void gp_residue_free(struct gp_residue *r);

/* Bounds |k * d| over the frame, each channel. */
GP_MUST_CHECK gp_status gp_power_bound(const struct gp_log *log,
    const struct gp_power *power, const struct gp_residue *r, double out[3]);

/* -- left_out.c: light that polygons lack where their kernel is cut -------- */

/* Numbers by the offset from a source's cell to a pixel's:
 * at[c][(dy - y0) * w + dx - x0]; 0 beyond. Grey kernels have channel 0 only.
 * Free with gp_bound_table_free(). */
struct gp_bound_table {
    int x0, y0, w, h;
    int channels;
    double *at[3];
};
void gp_bound_table_free(struct gp_bound_table *t);

/* Finds the most, or the least, that a unit of light up to `carry` pixels from
 * a cell adds to a pixel of another. Kernel without its core when `tail`. */
enum gp_bound_end { GP_BOUND_MOST, GP_BOUND_LEAST };
GP_MUST_CHECK gp_status gp_bound_table_make(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_kernel *kernel,
    enum gp_bound_end end, bool tail, int carry, struct gp_bound_table *out);

/* Finds the most light of each channel that shrinking leaves out in any
 * pixel. */
GP_MUST_CHECK gp_status gp_bound_cells_left(const struct gp_log *log,
    const struct gp_bound_cells *cells, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, const struct gp_bound_table *most,
    double out[3]);

/* Kernel samples within (w, h) of the centre, without the core when `tail`, by
 * square rings around it. */
struct gp_bound_rings {
    int n;             // rings 0 .. n - 1 hold all of them
    double *beyond[3]; // n + 1 sums: of ring i and those farther out
    double slope[3];   // sum of |dk/dx| + |dk/dy|, differences to the next
};

/* Free with gp_bound_rings_free(). */
GP_MUST_CHECK gp_status gp_bound_rings_make(const struct gp_log *log,
    const struct gp_kernel *k, bool tail, int w, int h,
    struct gp_bound_rings *out);
void gp_bound_rings_free(struct gp_bound_rings *r);

/* Sums the light left out by shrinking over an unbounded plane, and bounds its
 * norm by Young's inequality, ring by ring. */
GP_MUST_CHECK gp_status gp_bound_rings_left(const struct gp_log *log,
    const struct gp_bound_rings *r, const struct gp_polygons *polygons,
    const struct gp_shrink *shrink, double sum[3], double norm[3]);

/* Bounds the norm of the error when polygons between pixels are sampled up to
 * `place` pixels off, in x and in y. */
void gp_bound_rings_sampled(const struct gp_bound_rings *r,
    const struct gp_polygons *polygons, double place, double norm[3]);

#endif
