/* Shared by the files of io: readers, writers, quantizers, planes by name. */
#ifndef GP_IO_IO_PRIV_H
#define GP_IO_IO_PRIV_H

#include "io/frame.h"
#include "core/status.h"
#include "io/exr/exr.h"
#include "io/decoded.h"
#include "io/read.h"
#include "io/stream.h"
#include "io/write.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* -- reading --------------------------------------------------------------- */

enum { GP_FIRST_BYTES = 18 }; // checked for magic: Targa's header

/* Returns the name of the format that begins with these n bytes: "PNG", but
 * also, for messages, "gzip" or "web page". NULL for unknown bytes. Targa has
 * no magic: all fields of its header must agree. */
const char *gp_format_name(const uint8_t *first, size_t n);

/* A format that is read. */
struct gp_reader {
    const char *format; // by gp_format_name()
    const char *oiio;   // OpenImageIO's name of its reader, or:
    // opens a picture as gp_png_open() does
    gp_status (*open)(const struct gp_log *log, const char *path,
                      const struct gp_stream *stream, int part,
                      long long max_pixels, struct gp_decoded *out);
    // sets *length to the bytes of the image that `data` begins with; leaves it
    // when they are unknown; fails, without a line, only when memory is full.
    // NULL: the image must be the only one of a stream
    gp_status (*length)(const uint8_t *data, uint64_t size, uint64_t *length);
};
extern const struct gp_reader gp_readers[]; // EXR first; ends with {0}

/* Opens `path` or stdin, checks its first bytes and, when they are those of a
 * format that is read, reads a pipe to its end.
 *
 *   stream  empty on failure; else the caller's to close
 *   exr     written on GP_OK: true for EXR
 *
 * Errors: those of gp_stream_open() and gp_stream_fill(), whose limit is 16
 * bytes for each of max_pixels, and 64 MiB; GP_ERR_DATA the name says EXR and
 * the bytes do not, or a pipe begins like no image. */
GP_MUST_CHECK gp_status gp_read_open(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stream *stream,
    bool *exr);

/* Opens picture `part` of a stream of any format (of EXR, those with DWA); its
 * first bytes choose the reader. The stream stays the caller's and must live
 * until gp_decoded_close().
 * Errors: GP_ERR_IO no helper program; GP_ERR_DATA damaged, truncated, over
 * max_pixels, or no format that is read; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_read_image(const struct gp_log *log,
    const struct gp_read_params *p, const char *path,
    const struct gp_stream *stream, int part, struct gp_decoded *out);

/* gp_read_frame() for an open stream, from its first bytes on; takes the
 * stream over: it is closed, or lives on in the frame. */
GP_MUST_CHECK gp_status gp_read_stream(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stream *stream,
    struct gp_frame *out);

/* -- PNG ------------------------------------------------------------------- */

/* Reads a PNG of any colour type, depth and interlacing.
 *
 *   part    must be 0: there is one picture
 *   out     written only on GP_OK. Channels Y, YA, RGB or RGBA: palettes and
 *           transparent colours are resolved, alpha is associated as
 *           OpenImageIO 2.4 does it, on codes: truncated c * a with an sRGB
 *           curve or none, c * a^g with a gamma of g. Samples of less than 8
 *           bits come as 8. colour_space is sRGB of a file with sRGB or
 *           without gAMA, else its gamma to two digits. Text chunks and the
 *           time are attributes; profiles, XMP and Exif are not looked at
 *
 * Errors: GP_ERR_DATA truncated, a chunk's checksum or data are wrong, also
 * after the pixels, over max_pixels; GP_ERR_IO cannot be read; GP_ERR_BUG out
 * of memory.
 * Source: W3C PNG (third edition). */
GP_MUST_CHECK gp_status gp_png_open(const struct gp_log *log, const char *path,
                                    const struct gp_stream *stream, int part,
                                    long long max_pixels, struct gp_decoded *out);

/* gp_write_picture() for PNG: RGB, or RGBA with GP_ALPHA_KEEP and an alpha
 * channel (picture.h says what alpha means where light has none).
 *
 * Colour chunks: for BT.709 primaries cICP (BT.709, sRGB curve), sRGB, gAMA
 * and cHRM; for a scene-linear picture in other primaries gAMA, and cHRM with
 * these primaries unless they are imaginary; for an encoded picture cICP with
 * p->cicp where that is known, and the others too where that is sRGB. Pixels
 * that are not square get a pHYs chunk. */
GP_MUST_CHECK gp_status gp_png_write(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats);

/* -- PFM ------------------------------------------------------------------- */

/* Writes unclamped values over black, in the
 * display window. */
GP_MUST_CHECK gp_status gp_pfm_open(const struct gp_log *log, const char *path,
                                    const struct gp_stream *stream, int part,
                                    long long max_pixels, struct gp_decoded *out);
GP_MUST_CHECK gp_status gp_pfm_length(const uint8_t *data, uint64_t size,
                                      uint64_t *length);
GP_MUST_CHECK gp_status gp_pfm_write(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats);

/* -- raw frames, as ffmpeg's rawvideo reads them --------------------------- */

/* gp_write_picture() for frames that follow each other in one stream: the
 * display window's pixels, R, G, B, rows from the top, no padding.
 *
 *   p      raw and dither are used. Integers are the codes that a PNG of 8 or
 *          16 bits has; floats are the values as they are
 *   stats  raw is the size of the frames before, 0 x 0 at the first, and
 *          becomes this frame's
 *
 * Errors: those of gp_write_picture(); GP_ERR_DATA the size differs from that
 * of the frames before, which a stream without headers cannot declare. */
GP_MUST_CHECK gp_status gp_raw_write(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats);

/* -- folders --------------------------------------------------------------- */

/* Makes every missing folder above `path`; 0, or -1 with errno set. */
int gp_file_make_folders(const char *path);

#endif
