/* Sensors: which pixels are light, and how much. The bright pass and the
 * cleaning of bad pixels are defined here, once, for every engine. */
#ifndef GP_GLARE_SENSORS_H
#define GP_GLARE_SENSORS_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"

/* Light of a pixel of luminance Y over T.
 *   WHOLE   all of its colour (Ando et al. 2007, section 3.1), times the knee
 *   EXCESS  the part over T: rgb * (Y - T) / Y */
enum gp_threshold_mode { GP_THRESHOLD_WHOLE, GP_THRESHOLD_EXCESS };

/* Units of the threshold: luminance of the frame's own primaries, >= 0; the
 * percentile of the luminance of the pixels that were read, 0 to 100; EV over
 * its log-average. */
enum gp_threshold_unit {
    GP_THRESHOLD_LUMINANCE, GP_THRESHOLD_PERCENT, GP_THRESHOLD_EV,
};

struct gp_sensor_params {
    float threshold;  // T, in its unit
    enum gp_threshold_unit unit;
    float knee;       // of WHOLE, k in [0,1]: ramp from 0 at T(1-k) to 1 at
                      // T(1+k)
    float max_value;  // upper limit of a channel, > 0; 0: none
    enum gp_threshold_mode mode;
};
#define GP_SENSOR_DEFAULTS                                                    \
    { .threshold = 1.0f, .mode = GP_THRESHOLD_EXCESS }

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
 *   out  written only on GP_OK; free with gp_sources_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sense(const struct gp_log *log,
                                 const struct gp_sensor_params *p,
                                 struct gp_image *f, struct gp_sources *out);

#endif
