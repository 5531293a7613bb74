// SPDX-License-Identifier: Apache-2.0
/* OpenColorIO: a config's view instead of a tone curve, and conversion of the
 * frame to another scene-linear space. */
#ifndef GP_TONE_OCIO_H
#define GP_TONE_OCIO_H

#include "core/image.h"
#include "core/status.h"
#include "tone/ocio_bridge.h"
#include "tone/tone.h"

struct gp_ocio;

/* Reads the config and makes its processors, once for all frames.
 *
 *   p     p->config is not NULL; borrowed until the call returns
 *   out   NULL on failure; close with gp_ocio_close()
 *
 * Errors, each with one line: GP_ERR_USAGE a name that the config does not
 * have (the line lists those it has), $OCIO unset, ocio:// with a library
 * before 2.2; GP_ERR_IO the config cannot be read, or the bridge is missing;
 * GP_ERR_DATA OpenColorIO refuses the config or a LUT of it; GP_ERR_BUG no
 * memory.
 */
GP_MUST_CHECK gp_status gp_ocio_open(const struct gp_log *log,
    const struct glarepp_tone_params *p, struct gp_ocio **out);
void gp_ocio_close(struct gp_ocio **ocio);

/* Returns the names, files and code points in use, and the chromaticities of
 * the output space: the published ones, else those that give the same light with
 * the reference's white. Lives as long as `ocio`. */
const struct glarepp_plan_facts *gp_ocio_facts(const struct gp_ocio *ocio);

/* Warns, once, of an output space whose chromaticities are not known; and, for
 * the first such frame, that a frame's chromaticities are ignored, as they or
 * the input space's are unusable. Call it for one frame after the other. */
void gp_ocio_note(const struct gp_log *log, struct gp_ocio *ocio,
                  const struct gp_image *f);

/* A frame whose file names chromaticities, other than those of the input space
 * as far as that is known, is converted to the input space first (white to
 * white, gp_rgb_to_rgb()), but for any_primaries.
 *
 * Makes f->shown from f->lit: exposure (and auto-exposure) of `p` as a scale,
 * then the view; p->curve and p->white do not count. f->shown is
 * display-encoded then, in whatever range the display's space has. Scaled
 * light is kept finite; NaN stays with its own pixel. f->shown is made when it
 * is empty, else it has the frame's size and is written over.
 *   ocio  was asked for a view (shows)
 * Errors: GP_ERR_BUG no memory, or no view.
 */
GP_MUST_CHECK gp_status gp_ocio_show(
    const struct gp_log *log, const struct gp_ocio *ocio,
    const struct glarepp_tone_params *p, struct gp_image *f);

/* Makes *out from *in, `n` pixels of colour of a layer of f's part: the same
 * light in the output space; no exposure. *out is made
 * when it is empty, else written over, and owned by the caller. Errors:
 * GP_ERR_BUG no memory, or no such space was asked for; *out is empty then. */
GP_MUST_CHECK gp_status gp_ocio_convert(
    const struct gp_log *log, const struct gp_ocio *ocio,
    const struct gp_image *f, size_t n, const struct gp_planes *in,
    struct gp_planes *out);

#endif
