/* Sensors: which pixels are light, and how much. The bright pass and the
 * cleaning of bad pixels are defined here, once, for every engine.
 *
 * glare/ as a room: cleaned frame and kernel in, one layer out.
 *   sensors  frame  -> sources (a sparse list of bright pixels)
 *   kernel   file or builtin -> normalised point-spread function
 *   engines  sources * kernel -> layer (direct, fft, splat; auto picks) */
#ifndef GP_GLARE_SENSORS_H
#define GP_GLARE_SENSORS_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/sources.h"

/* Light of a pixel of luminance Y over T.
 *   WHOLE   all of its colour (Ando et al. 2007, section 3.1), times the knee
 *   EXCESS  the part over T: rgb * (Y - T) / Y */
enum gp_threshold_mode { GP_THRESHOLD_WHOLE, GP_THRESHOLD_EXCESS };

struct gp_sensor_params {
    float threshold;  // T, luminance of the frame's own primaries, >= 0
    float knee;       // of WHOLE, k in [0,1]: ramp from 0 at T(1-k) to 1 at
                      // T(1+k)
    float max_value;  // upper limit of a channel, > 0
    enum gp_threshold_mode mode;
};
#define GP_SENSOR_DEFAULTS                                                    \
    { .threshold = 1.0f, .knee = 0.0f, .max_value = 65504.0f,                 \
      .mode = GP_THRESHOLD_EXCESS }

/* Cleans f->rgb in place (NaN to 0, +Inf and values over max_value to
 * max_value, -Inf to 0; finite negative values stay), then lists the
 * sources: pixels whose luminance Y of the non-negative part is over T, with
 * the part of the colour that the mode says; the knee's ramp is a smoothstep, 1
 * when knee is 0. What is under FLT_MIN then counts as 0 (gp_sources.faint).
 *
 *   out  written only on GP_OK; free with gp_sources_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sense(const struct gp_log *log,
                                 const struct gp_sensor_params *p,
                                 struct gp_frame *f, struct gp_sources *out);

#endif
