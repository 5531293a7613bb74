/* Limits of the change by lossy EXR compressions, from their encoders. Each
 * gives the largest error of `got`, a frame as it was read back, against f.rgb,
 * or HARD_NO_BAR where a value is lost. Sources: OpenEXR 3.1.5,
 * ImfPxr24Compressor, ImfB44Compressor, ImfDwaCompressor. */
#ifndef GP_TESTS_HARD_FILES_LOSSY_H
#define GP_TESTS_HARD_FILES_LOSSY_H

#include "io/frame.h"

/* PXR24 keeps a float's sign, exponent and 15 of its 23 bits, rounded: of the
 * value, at most 2^-16. Below the normal range, of the least normal value. */
#define HARD_PXR24_BAR 0x1p-16
double hard_pxr24_error(const struct gp_frame *got, const struct gp_frame *f);

/* B44 holds the 15 steps from value to value of a 4x4 block in 6 bits each,
 * of a size that doubles until they fit: half a step is at most 1/31 of the
 * range of the block, both counted in half's own codes. NaN and Inf become 0,
 * and values below -32752 that. */
#define HARD_B44_BAR (1.0 / 31.0)
double hard_b44_error(const struct gp_frame *got, const struct gp_frame *f);

/* DWA bends values (power 1/2.2 up to 1, logarithm above), turns R, G, B into
 * Y, Cb, Cr, and lets the 64 terms of an 8x8 block's cosine transform move by
 * 4.5e-5 of JPEG's table (Cb, Cr: 2.6e-5 of theirs). A term reaches a sample by
 * 1/4 at most, and the tables add up to 3688 and 5505: 0.041 in Y, 0.036 in Cb,
 * with B = Y + 1.86 Cb 0.108, and up to 0.023 for terms held as half. In bent
 * values; NaN becomes 0, and values beyond 57344 that. */
#define HARD_DWA_BAR 0.131
double hard_dwa_error(const struct gp_frame *got, const struct gp_frame *f);

#endif
