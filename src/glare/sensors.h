/* Sensors: which pixels are light, and how much. The bright pass and the
 * cleaning of bad pixels are defined here, once, for every engine.
 *
 * glare/ as a room: cleaned frame and kernel in, one layer out.
 *   sensors  frame  -> sources (a sparse list of bright pixels)
 *   kernel   file or builtin -> normalised point-spread function
 *   engines  sources * kernel -> layer (direct, fft, splat; auto picks)
 */
#ifndef GP_GLARE_SENSORS_H
#define GP_GLARE_SENSORS_H

#include "core/frame.h"
#include "core/status.h"

struct gp_sensor_params {
    float threshold;  // T, luminance of the frame's own primaries, >= 0
    float knee;       // k in [0,1]: ramp from 0 at T(1-k) to 1 at T(1+k)
    float max_value;  // upper limit of a channel, > 0
};
#define GP_SENSOR_DEFAULTS                                                    \
    { .threshold = 1.0f, .knee = 0.0f, .max_value = 65504.0f }

/* Sources are counted by their largest channel, two bins an octave. */
enum { GP_SOURCE_BINS = 512 };

/* The bin of a value > 0, and where a bin starts; bin b ends where b + 1
 * starts. From the exponent and the first bit of the mantissa. */
int gp_source_bin(float v);
float gp_source_bin_start(int bin);

/* The bright pixels of a frame in row order: sources of row y are
 * [row[y], row[y + 1]). Coordinates count from the data window's corner.
 * Colours are finite and >= 0. */
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
    double energy[3];     // sum of squares of each channel
    float brightest;      // largest channel value
    uint32_t count[GP_SOURCE_BINS];
    long long nonfinite;  // pixels with NaN or Inf in rgb
    long long clamped;    // pixels with a finite value over max_value
    double darkest;       // a low percentile (0.1 %) of the cleaned frame's
                          // positive luminance; 0 when all is black
};

/* Cleans f->rgb in place (NaN to 0, +Inf and values over max_value to
 * max_value, -Inf to 0; finite negative values stay), then lists the
 * sources: pixels whose luminance Y of the non-negative part is over T, with
 * the colour times the knee's ramp (smoothstep, 1 when knee is 0).
 *
 *   out  written only on GP_OK; free with gp_sources_free()
 * Errors: GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_sense(const struct gp_log *log,
                                 const struct gp_sensor_params *p,
                                 struct gp_frame *f, struct gp_sources *out);
void gp_sources_free(struct gp_sources *s);

/* Weight of a pixel of luminance y: 0 shut, 1 open, between on the ramp. */
float gp_bright_pass(const struct gp_sensor_params *p, float y);

/* The sources as full planes (w * h, 0 where dark), for engines that need
 * an image and for --debug sensors. `p` is made. */
GP_MUST_CHECK gp_status gp_sources_planes(const struct gp_log *log,
                                          const struct gp_sources *s,
                                          struct gp_planes *p);

#endif
