// SPDX-License-Identifier: Apache-2.0
/* Sources: the light that glare spreads, as a sparse list of pixels. Sensors
 * make one from a frame; lights whose flux was given join it. */
#ifndef GP_GLARE_SOURCES_H
#define GP_GLARE_SOURCES_H

#include "core/bytes.h"
#include "core/image.h"
#include "core/status.h"
#include "glarepp.h"

#include <stdint.h>

/* Bins of light, two an octave. */
enum { GP_SOURCE_BINS = 512 };

/* The bin of a value > 0, and where a bin starts; bin b ends where b + 1
 * starts. From the exponent and the first bit of the mantissa. */
static inline int gp_source_bin(float v)
{
    return (int) (gp_bits_of(v) >> 22) & (GP_SOURCE_BINS - 1);
}
static inline float gp_source_bin_start(int bin)
{
    return gp_float_with_bits((uint32_t) bin << 22);
}

/* 2^26 times FLT_MIN, 1.2e-38: next to a channel of at least this, one under
 * FLT_MIN is below its rounding. */
#define GP_FAINT 0x1p-100f

/* Light on one pixel of the frame. */
struct gp_source {
    int x, y;      // from the data window's corner, inside the frame
    float rgb[3];  // finite, >= 0
};

/* Sources in row order: those of row y are [row[y], row[y + 1]). Coordinates
 * count from the data window's corner. Colours are finite and >= 0. Light under
 * FLT_MIN counts as 0: channels of sources that have none from GP_FAINT up. */
struct gp_sources {
    int w, h;             // of the frame
    int x0, y0;           // the data window's corner, EXR pixel space
    float luminance[3];   // weights of the frame's primaries
    size_t n;             // sources
    uint32_t *row;        // h + 1 offsets
    int32_t *x;           // n columns, ascending in a row
    float *rgb[3];        // n colours, after knee
    struct gp_rect box;   // smallest that holds all; empty when n is 0
    double flux[3];       // sum of each channel
    double faint[3];      // sum of each channel of what counts as 0
    double energy[3];     // sum of squares of each channel
    float brightest;      // largest channel value
    long long nonfinite;  // pixels with NaN or Inf in rgb
    long long clamped;    // pixels with a finite value over max_value
    double flux_clamped[3]; // light that max_value removed, by channel
    float threshold;      // T as luminance
    double darkest; // 0.01 % percentile of the cleaned frame's luminance: 0
                    // where more is black
};

/* Makes a list without sources, with room for `room` of them, for a frame like
 * that of `like`, of which it copies sizes, window, weights, faint, the facts
 * of the frame, and darkest. Written only on GP_OK; free with
 * gp_sources_free(). */
GP_MUST_CHECK gp_status gp_sources_make(const struct gp_log *log,
    const struct gp_sources *like, size_t room, struct gp_sources *out);

/* Returns what counts as a dark pixel's own luminance: `darkest`, or with a black
 * frame, which has none to spoil, 1e-6 of the brightest source. */
static inline double gp_sources_dark(const struct gp_sources *s)
{
    return s->darkest > 0.0 ? s->darkest : 1e-6 * (double) s->brightest;
}

/* Appends a source that comes after all others in row order, and adds it to
 * flux, energy and brightest. Channels that count as 0 are added to
 * `faint`; a source without light is left out. There must be room. */
void gp_sources_add(struct gp_sources *s, int x, int y, const float rgb[3]);

/* Appends `share` of source i of `src` in the same way, at (x, y). */
void gp_sources_copy(const struct gp_sources *src, uint32_t i, double share,
                     int x, int y, struct gp_sources *to);

/* Completes row[] and box once all sources are in the list. */
void gp_sources_finish(struct gp_sources *s);
void gp_sources_free(struct gp_sources *s);

/* Joins `src` and `n` more sources; light of the same pixel is added.
 *
 *   more  is sorted into row order; sums do not depend on the order given
 *   out   as gp_sources_make() of src
 * Errors: GP_ERR_BUG a pixel outside the frame. */
GP_MUST_CHECK gp_status gp_sources_join(const struct gp_log *log,
    const struct gp_sources *src, struct gp_source *more, size_t n,
    struct gp_sources *out);

/* The same sources and darkest, times `share`, and where there is a mask each times that's
 * value in its pixel, clamped to [0, 1]; NaN and pixels outside of the mask's window are 0.
 * A source without light is left out.
 *   mask  window in EXR pixel space; NULL: none
 *   out   as gp_sources_make() of src, written only on GP_OK */
GP_MUST_CHECK gp_status gp_sources_scale(const struct gp_log *log,
                                         const struct gp_sources *src,
                                         double share,
                                         const struct gp_plane *mask,
                                         struct gp_sources *out);

/* Makes a list of all sources, n of them, 1 at least; owned by the caller. Errors:
 * GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sources_list(const struct gp_log *log,
                                        const struct gp_sources *s,
                                        struct gp_source **out);

/* The sources as full planes (w * h, 0 where dark), for engines that need
 * an image and for --debug sensors. `p` is made. */
GP_MUST_CHECK gp_status gp_sources_planes(const struct gp_log *log,
    const struct gp_sources *s, struct gp_planes *p);

// -- sensors.c: which pixels are light, and how much, once for every engine -------

/* Cleans f->rgb in place: NaN and -Inf become 0, +Inf the largest finite value
 * of the frame or 65504, whichever is more; finite values stay, but where a
 * channel is over max_value its pixel is scaled until the largest is that.
 * Then finds T, and lists the sources: pixels whose luminance Y, of the
 * non-negative part, is over T, with the part of the colour that the mode
 * keeps; the knee's ramp is a smoothstep, 1 when knee is 0. Light under FLT_MIN
 * then counts as 0 (gp_sources.faint).
 *
 * A warning says so when max_value takes over 1 % of a channel's light.
 *
 *   sphere  f is a lat-long: percentiles and averages are of its solid angle
 *   out     written only on GP_OK; free with gp_sources_free() */
GP_MUST_CHECK gp_status gp_sense(const struct gp_log *log,
                                 const struct glarepp_sense_params *p,
                                 bool sphere, struct gp_image *f,
                                 struct gp_sources *out);

#endif
