/* io: files in and out. The only room that knows file formats.
 *
 * In: a path (or "-", stdin) becomes a gp_frame. Out: planes of a frame become
 * a file under its final name, whole or not at all.
 */
#ifndef GP_IO_READ_H
#define GP_IO_READ_H

#include "core/frame.h"
#include "core/status.h"

struct gp_read_params {
    long long max_pixels;  // a data window of more pixels is refused, >= 1
};
#define GP_READ_DEFAULTS { .max_pixels = 1LL << 28 }

/* Reads a frame: EXR by OpenEXRCore, any other format by the OpenImageIO
 * bridge, told apart by the first bytes, never by the name.
 *
 *   path  file, or "-" for stdin (read to its end)
 *   out   written only on GP_OK: windows, chromaticities and luminance,
 *         rgb, channels, origin; other planes empty. Free: gp_frame_free().
 *
 * Colour is, in this order: R,G,B; red,green,blue of any case; Y with RY or
 * BY; Y; LAYER.R,G,B of a layer called Combined, beauty or rgba, or else of
 * the first layer in file order; the only channel there is, alpha aside. The
 * first part of a multi-part file that has one of these (a lone channel
 * last, which is more likely depth) is the frame; the other parts pass
 * through to gp_write_hdr(). Missing colour channels of a set of three are 0.
 * `colour` of a grey file's channel is 0; RY, Y, BY have 0, 1, 2, and rgb
 * holds the RGB that OpenEXR's RgbaInputFile would give.
 *
 * EXR's values are as stored: NaN and Inf are the sensors' business. Integers
 * of other formats are made linear by the curve that the file names, 8-bit
 * ones without a name by sRGB's.
 *
 * Errors: GP_ERR_IO cannot open or read, is a folder; GP_ERR_DATA empty,
 * truncated, damaged, deep, over max_pixels, or no colour channel.
 */
GP_MUST_CHECK gp_status gp_read_frame(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path, struct gp_frame *out);

#endif
