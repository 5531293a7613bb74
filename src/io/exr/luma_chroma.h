/* Luminance-chroma images to RGB.
 *
 * A file may hold luminance Y = wr R + wg G + wb B at full resolution and the
 * chroma differences RY = (R - Y) / Y and BY = (B - Y) / Y at every second
 * column of every second row. Getting RGB back: missing chroma by a windowed
 * sinc of 27 taps, first in rows, then in columns; YC to RGB; then colours
 * more saturated than their neighbours, which the filter's ringing makes,
 * are pulled back.
 * Source: OpenEXR, ImfRgbaYca.cpp and class RgbaInputFile::FromYca of
 * ImfRgbaFile.cpp, whose results these equal bit by bit for half files.
 */
#ifndef GP_IO_EXR_LUMA_CHROMA_H
#define GP_IO_EXR_LUMA_CHROMA_H

#include "core/frame.h"
#include "core/status.h"

struct gp_yc {
    int w, h;         // of the picture, both even when xs or ys is 2
    int xs, ys;       // sampling of both chroma planes: 1, 1 or 2, 2
    const float *y;   // w * h
    const float *ry;  // (w / xs) * (h / ys)
    const float *by;  // the same
    float weight[3];  // of R, G, B in Y; from gp_yc_weights()
    bool half;        // round every step to half, as OpenEXR does; for files
                      // whose planes are all half
};

/* The weights of R, G, B in Y for these primaries, in OpenEXR's own single
 * precision (RgbaYca::computeYw, ImfChromaticities.cpp). Degenerate primaries
 * give those of BT.709.
 *   chromaticities  rx ry gx gy bx by wx wy
 */
void gp_yc_weights(const float chromaticities[8], float weight[3]);

/* Fills out->c[0..2], w * h each; they may not overlap the inputs.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_yc_to_rgb(const struct gp_log *log,
                                     const struct gp_yc *in,
                                     struct gp_planes *out);

#endif
