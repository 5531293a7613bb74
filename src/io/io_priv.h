// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of io: readers, writers, pictures of frames. */
#ifndef GP_IO_IO_PRIV_H
#define GP_IO_IO_PRIV_H

#include "io/frame.h"
#include "core/status.h"
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
 * also, for messages, "gzip" or "web page". NULL for unknown bytes. */
const char *gp_format_name(const uint8_t *first, size_t n);

/* Reads the only picture of a file, as gp_read_image() does. */
typedef gp_status gp_picture_reader(const struct gp_log *log, const char *path,
    const struct gp_stream *stream, long long max_pixels,
    struct gp_decoded *out);

/* A format that is read. */
struct gp_reader {
    const char *format; // by gp_format_name()
    const char *oiio;   // OpenImageIO's name of its reader, or:
    gp_picture_reader *open;
    // sets *length to the bytes of the image that `stream` begins with, and may
    // close it; leaves it when they are unknown or not all there; fails, without
    // a line, only when memory is full. NULL: a stream holds one image
    gp_status (*length)(struct gp_stream *stream, uint64_t *length);
};
extern const struct gp_reader gp_readers[]; // EXR first; ends with {0}

/* Opens `path` or stdin, checks its first bytes and reads a pipe to its end, at
 * most 16 bytes for each of max_pixels and 64 MiB. `stream` is empty on failure.
 * Errors: those of gp_stream_open() and gp_stream_fill(); GP_ERR_DATA no format
 * that is read, or none of EXR under the name of one. */
GP_MUST_CHECK gp_status gp_read_open(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stream *stream,
    bool *exr);

/* Reads picture `part` of a stream of any format (of EXR, those with DWA); its
 * first bytes choose the reader. The stream stays the caller's.
 * Errors: GP_ERR_IO no helper program; GP_ERR_DATA damaged, truncated, over
 * max_pixels, no such part, or no format that is read. */
GP_MUST_CHECK gp_status gp_read_image(const struct gp_log *log,
    const struct gp_read_params *p, const char *path,
    const struct gp_stream *stream, int part, struct gp_decoded *out);

/* gp_read_frame() for an open stream, which it takes over. */
GP_MUST_CHECK gp_status gp_read_stream(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stream *stream,
    struct gp_frame *out);

/* A PNG of any colour type, depth and interlacing: channels Y, YA, RGB or RGBA.
 * Palettes and transparent colours are resolved, less than 8 bits come as 8.
 * Alpha is associated as OpenImageIO 2.4 does it, on codes: truncated c * a
 * with an sRGB curve or none, c * a^g with a gamma of g. colour_space is sRGB
 * of a file with sRGB or without gAMA, else its gamma to two digits. Text
 * chunks and the time are attributes; profiles, XMP and Exif are not looked at.
 * Source: W3C PNG (third edition). */
gp_picture_reader gp_png_open, gp_pfm_open;
GP_MUST_CHECK gp_status gp_pfm_length(struct gp_stream *stream,
                                      uint64_t *length);

/* -- writing --------------------------------------------------------------- */

/* gp_write_picture() for one format. */
typedef gp_status gp_picture_writer(const struct gp_picture_job *j);

/* PNG: RGB, or RGBA with GP_ALPHA_KEEP and an alpha channel.
 *
 * Colour chunks: for BT.709 primaries cICP (BT.709, sRGB curve), sRGB, gAMA
 * and cHRM; for a scene-linear picture in other primaries gAMA, and cHRM with
 * these primaries unless they are imaginary; for an encoded picture cICP with
 * p->cicp where that is known, and the others too where that is sRGB. Pixels
 * that are not square get a pHYs chunk. */
gp_picture_writer gp_png_write;

/* PFM: values over black, not clamped. */
gp_picture_writer gp_pfm_write;

/* Frames that follow each other in one stream, as ffmpeg's rawvideo reads them:
 * R, G, B over black, rows from the top, no padding; codes as a PNG of 8 or 16
 * bits has them, or floats as they are. stats->raw is the size of the frames
 * before; GP_ERR_DATA one of another size. */
gp_picture_writer gp_raw_write;

/* -- a frame's planes as a picture of its display window ------------------- */

/* Makes linear light or encoded values codes 0 .. max. */
struct gp_quantizer {
    int max;            // 255 or 65535
    bool curve, dither; // sRGB's; without it values are encoded already
};

/* Makes n samples codes. NaN and values below 0 become 0, values over 1 the
 * largest.
 *
 * Without dither the nearest code: with the curve exactly
 * (int) (gp_srgb_encode(value[i]) * max + 0.5f) for every float. With it
 * floor(encoded * max + d), where d in [0, 1) depends on the pixel's place
 * only, so a picture has the same bytes whoever writes it, and grey stays
 * grey. Over an area of one value the mean of the codes is the encoded value.
 *
 *   x, y  place of value[0] in the picture
 *
 * d is interleaved gradient noise in fixed point: Jimenez, "Next Generation
 * Post Processing in Call of Duty: Advanced Warfare", SIGGRAPH 2014 courses. */
void gp_quantize(const struct gp_quantizer *q, const float *value, int x, int y,
                 uint16_t *code, size_t n);

struct gp_picture {
    int width, height;  // of the display window
    int channels;       // 3, or 4 with alpha
    int bits;           // of a code, 8 or 16
    bool associated;    // codes of colour are not divided by alpha
    const struct gp_frame *f;
    const struct gp_planes *planes;
    float *alpha;       // of the data window, or NULL
    struct gp_quantizer quantizer;
};

/* Prepares rows: of four channels without GP_ALPHA_BLACK where alpha is beside the
 * colour; codes of GP_PICTURE_ENCODED are without a curve.
 *
 *   out  empty on failure; free with gp_picture_free()
 *
 * Errors: GP_ERR_DATA an empty display window, or one of more than 2^40
 * pixels (those of files are bounded by --max-pixels when they are read). */
GP_MUST_CHECK gp_status gp_picture_make(const struct gp_picture_job *j,
                                        struct gp_picture *out);
void gp_picture_free(struct gp_picture *pic);

/* Interleaved samples of a picture's display window. */
struct gp_picture_form {
    size_t bytes;     // of one: codes of 1 or 2, little-endian floats of 4
    bool big;         // codes are big-endian
    bool fractions;   // floats are codes divided by the largest
    bool from_bottom; // the last row comes first
    size_t lead;      // bytes before the samples of each row
    void (*finish)(const struct gp_picture *pic, uint8_t *row); // or NULL
    void *to; // rows of `lead` and width * channels * bytes
};

/* Fills s->to, in parallel. Codes are sRGB, or as an encoded picture has them,
 * floats values as they are with associated alpha. Pixels outside the data
 * window are 0 in all channels.
 *
 * With alpha the colours of codes are not associated, as PNG wants them. A pixel
 * may hold more light than its opacity A lets through, above all where A is 0
 * and glare shines over an empty background. Alpha is raised to the largest
 * component there: a = max(A, R, G, B), each clamped to [0, 1], so that
 * colour / a stays within 1 and the picture put over black is, pixel by
 * pixel, the picture without alpha. With GP_ALPHA_ASSOCIATED the colours are
 * those of the picture without alpha, with A beside them. */
GP_MUST_CHECK gp_status gp_picture_samples(const struct gp_log *log,
                                           const struct gp_picture *pic,
                                           const struct gp_picture_form *s);

#endif
