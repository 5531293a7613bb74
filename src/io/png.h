/* PNG files in and out, 8 and 16 bits. */
#ifndef GP_IO_PNG_H
#define GP_IO_PNG_H

#include "core/frame.h"
#include "core/status.h"
#include "io/image.h"
#include "io/stream.h"
#include "io/write.h"

/* Opens a PNG of any colour type, depth and interlacing.
 *
 *   stream  stays the caller's and must live until gp_image_close()
 *   part    must be 0: there is one picture
 *   out     written only on GP_OK. Channels Y, YA, RGB or RGBA: palettes and
 *           transparent colours are resolved, alpha is associated as
 *           OpenImageIO 2.4 does it, on codes: truncated c * a with an sRGB
 *           curve or none, c * a^g with a gamma of g. Samples of less than 8
 *           bits come as 8. colour_space is sRGB of a file with sRGB or
 *           without gAMA, else its gamma to two digits. Text chunks and the
 *           time are attributes; profiles, XMP and Exif are not looked at
 *
 * Memory is that of a block of rows, with interlacing of all rows, and what
 * libpng holds of other chunks, which is bounded.
 *
 * Errors, also of rows(): GP_ERR_DATA cut off, a chunk's checksum or data are
 * wrong (the last rows() reads on to IEND), over max_pixels; GP_ERR_IO cannot
 * be read; GP_ERR_BUG out of memory.
 * Source: W3C PNG (third edition).
 */
GP_MUST_CHECK gp_status gp_png_open(const struct gp_log *log, const char *path,
                                    const struct gp_stream *stream, int part,
                                    long long max_pixels,
                                    struct gp_image *out);

/* gp_write_picture() for PNG: RGB, or RGBA with GP_ALPHA_KEEP and an alpha
 * channel (picture.h says what alpha means where light has none).
 *
 * Colour chunks: for BT.709 primaries cICP (BT.709, sRGB curve), sRGB, gAMA
 * and cHRM; for a scene-linear picture in other primaries gAMA, and cHRM with
 * these primaries unless they are imaginary. Pixels that are not square get a
 * pHYs chunk.
 */
GP_MUST_CHECK gp_status gp_png_write(const struct gp_log *log,
                                     const struct gp_write_params *p,
                                     const char *path,
                                     const struct gp_frame *f,
                                     const struct gp_planes *planes,
                                     enum gp_picture_kind kind);

#endif
