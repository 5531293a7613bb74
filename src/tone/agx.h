/* The AgX operator, as the `map` of a gp_tone_curve. */
#ifndef GP_TONE_AGX_H
#define GP_TONE_AGX_H

#include <stddef.h>

/* n pixels in place, linear BT.709 to display-linear BT.709 in [0,1]; any
 * value is taken, negative ones too, since AgX's own primaries are wider.
 * `white` is not read. */
void gp_tone_agx(float *r, float *g, float *b, size_t n, float white);

#endif
