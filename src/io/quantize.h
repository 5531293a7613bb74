/* Linear light to 8- and 16-bit sRGB codes. */
#ifndef GP_IO_QUANTIZE_H
#define GP_IO_QUANTIZE_H

#include "core/status.h"

#include <stddef.h>
#include <stdint.h>

struct gp_quantizer;

/* Makes the tables for codes 0 .. 2^bits - 1.
 *
 *   bits  8 or 16
 *   out   written only on GP_OK; free with gp_quantizer_free(). Read only
 *         after this, so any number of threads may share it.
 *
 * Errors: GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_quantizer_make(const struct gp_log *log, int bits,
                                          struct gp_quantizer **out);
void gp_quantizer_free(struct gp_quantizer *q);

/* The largest code, 255 or 65535. */
int gp_quantizer_max(const struct gp_quantizer *q);

/* n samples to the nearest codes: exactly
 * (int) (gp_srgb_encode(linear[i]) * max + 0.5f) for every float; NaN and
 * values below 0 become 0, values over 1 the largest code. */
void gp_quantize(const struct gp_quantizer *q, const float *linear,
                 uint16_t *code, size_t n);

/* The same with ordered dither: floor(encoded * max + d), where d in [0, 1)
 * depends on the pixel's place only, so a picture has the same bytes whoever
 * writes it, and grey stays grey. Over an area of one value the mean of the
 * codes is the encoded value. 0 and 1 stay the smallest and largest code.
 *
 *   x, y  place of linear[0] in the picture
 *
 * d is interleaved gradient noise: Jimenez, "Next Generation Post Processing
 * in Call of Duty: Advanced Warfare", SIGGRAPH 2014 courses, in fixed point,
 * so that wide pictures do not lose its low bits.
 */
void gp_quantize_dither(const struct gp_quantizer *q, const float *linear,
                        int x, int y, uint16_t *code, size_t n);

/* n values to codes with no curve, for alpha and what is encoded already: the
 * nearest code of the value clamped to [0, 1]; NaN becomes 0. */
void gp_quantize_linear(const struct gp_quantizer *q, const float *value,
                        uint16_t *code, size_t n);

/* The same with the dither of gp_quantize_dither(). */
void gp_quantize_linear_dither(const struct gp_quantizer *q,
                               const float *value, int x, int y,
                               uint16_t *code, size_t n);

#endif
