// SPDX-License-Identifier: Apache-2.0
/* tone: from scene-linear light to what a display shows.
 *
 * In: f->lit, in the frame's own primaries. Out: f->shown, display-linear
 * BT.709, in [0,1] for every operator but `none`. The transfer curve of the
 * display (sRGB) is applied where values become integers, in io. */
#ifndef GP_TONE_TONE_H
#define GP_TONE_TONE_H

#include "core/image.h"
#include "core/status.h"
#include "glarepp.h"

#include <stdbool.h>

/* Light that counts as this where it is more: every operator has reached its
 * end far below, and squares of it stay finite. */
#define GP_LIGHT_MAX 1e15f

/* One operator. Works on one pixel; pure. */
struct gp_tone_curve {
    const char *name;
    const char *text;    // one line for --help and the man page
    /* n pixels in place, plane by plane: linear BT.709 in, after exposure,
     * any value; display-linear out. NULL: nothing is changed, the exposure
     * not even. A negative channel counts as 0, in aces and agx only after it
     * is mixed into their own, wider primaries. `white` as in the params,
     * resolved, > 0; only operators with reads_white read it. */
    void (*map)(float *r, float *g, float *b, size_t n, float white);
    bool reads_white;
};
extern const struct gp_tone_curve *const gp_tone_curves[];  // NULL at the end
const struct gp_tone_curve *gp_tone_find(const char *name);  // or NULL

/* Makes f->shown from f->lit: primaries to BT.709 (Bradford adaptation of the
 * white when it differs; degenerate primaries count as BT.709, as in
 * core/colour.h), exposure, operator. `none` copies f->lit as it is,
 * primaries and exposure untouched. f->shown is made when it is empty, else it
 * has the frame's size and is written over.
 * White 0 is the frame's maximum, FLT_MIN where it is under that.
 *   p  its curve is one of gp_tone_curves */
GP_MUST_CHECK gp_status gp_tone_map(const struct gp_log *log,
    const struct glarepp_tone_params *p, struct gp_image *f);

/* The factor that exposure and auto-exposure of f->lit make, within 2^-140 and
 * 2^60. Same value for any thread count. */
float gp_tone_scale(const struct glarepp_tone_params *p,
                    const struct gp_image *f);

#endif
