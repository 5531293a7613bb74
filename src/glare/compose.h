/* Composes the frame and its glare layer. */
#ifndef GP_GLARE_COMPOSE_H
#define GP_GLARE_COMPOSE_H

#include "core/frame.h"
#include "core/status.h"
#include "glare/sensors.h"

enum gp_mix { GP_MIX_ADD, GP_MIX_SCATTER };

struct gp_compose_params {
    float gain;  // >= 0
    enum gp_mix mix;
    float dim;   // share of everything that a narrower pupil takes; 0 to 1
};
#define GP_COMPOSE_DEFAULTS { .gain = 1.0f, .mix = GP_MIX_SCATTER }

/* Makes f->lit from f->rgb, f->layer and the sources.
 *   add:     lit = rgb + gain * layer
 *   scatter: lit = rgb - min(gain, 1) * source + gain * layer, which up to a
 *            gain of 1 conserves energy but for what leaves the frame
 * and then lit *= 1 - dim, the whole picture alike.
 * Values over FLT_MAX are clamped to it.
 * f->layer may be empty when no pixel is a source: then lit = rgb. f->lit is
 * made when it is empty, else it has the frame's size and is overwritten.
 * Errors: GP_ERR_BUG out of memory, or sources of another frame's size. */
GP_MUST_CHECK gp_status gp_compose(const struct gp_log *log,
    const struct gp_compose_params *p, const struct gp_sources *src,
    struct gp_frame *f);

#endif
