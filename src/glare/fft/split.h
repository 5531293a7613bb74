/* Which part of the sum goes direct, so that float rounding stays unseen.
 *
 * The rounding noise of a transform spreads evenly over the frame, about
 * |sources| |kernel| 2^-24 strong: one hot pixel lays it over the darkest
 * corner. Two parts of the sum carry nearly all of that product and cost
 * little by themselves: the kernel's core, for all sources, and the few
 * hottest sources, for the whole kernel. What remains is transformed.
 */
#ifndef GP_GLARE_FFT_SPLIT_H
#define GP_GLARE_FFT_SPLIT_H

#include "core/status.h"
#include "glare/kernel.h"
#include "glare/sensors.h"

enum { GP_FFT_CORES = 5 };

/* Radii of the core that may go direct; -1 is none. */
extern const int gp_fft_core_radius[GP_FFT_CORES];

/* Norms of the kernel without its core, largest channel, one a radius. */
void gp_fft_tail_norms(const struct gp_kernel *k, double norm[GP_FFT_CORES]);

struct gp_fft_split {
    int core;         // radius in gp_fft_core_radius
    float hot;        // a source with a channel from this up goes direct
                      // whole; INFINITY sends none
    size_t hot_count;
    double rounding;  // expected largest error of a pixel over its own value
    double ms;        // predicted for the direct part, on one core
};

/* Chooses the cheapest split that keeps `rounding` under 1e-6 and costs at
 * most four times the transform and 5 ms, the core as much as the
 * transform and 5 ms: a night is worth that. When none does, as in a bright
 * sky: the cheapest that costs at most half of the transform and comes within
 * twice the least rounding to be had for that, if that is at least 4 times
 * less than without; else no split.
 *   tail       from gp_fft_tail_norms()
 *   points     nx * ny
 *   fft_ms     predicted for the transform
 *   gain       of the layer in the composite, > 0
 * The choice depends on the frame alone, never on the number of threads.
 */
void gp_fft_split_choose(const struct gp_sources *src,
                         const struct gp_kernel *k,
                         const double tail[GP_FFT_CORES], double points,
                         double fft_ms, double gain,
                         struct gp_fft_split *out);

#endif
