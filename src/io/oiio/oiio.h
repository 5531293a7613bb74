// SPDX-License-Identifier: Apache-2.0
/* Formats that io has no reader or writer for, by OpenImageIO.
 *
 * OpenImageIO runs in a helper program, glarepp-oiio: its libraries cost 200 ms
 * at every start, and a damaged file may crash or hang the process that reads
 * it. The first such file starts it, and it stays; after a crash the next file
 * starts another. It gets files as open descriptors and never a name, may not
 * use the network, and its memory, time and files are limited.
 *
 * The program is looked for in $GLAREPP_BRIDGES, beside glarepp, in
 * ../lib/glarepp from there, and in the installed folder.
 * $GLAREPP_HELPER_SECONDS is how long one call may take (60), and a second
 * more for each MiB that is read or unpacked. */
#ifndef GP_IO_OIIO_OIIO_H
#define GP_IO_OIIO_OIIO_H

#include "core/bridge.h"
#include "core/status.h"
#include "io/decoded.h"
#include "io/stream.h"

/* -- reading --------------------------------------------------------------- */

/* Reads picture `part` of a stream. Of EXR, channels that are stored as uint32
 * come as those 32 bits in the place of the float, and each four channels count
 * on their own for max_pixels.
 *
 *   reader  OpenImageIO's name of the format, of gp_readers; the
 *           helper refuses all others
 *
 * Errors: GP_ERR_IO there is no helper; GP_ERR_DATA damaged, truncated, over
 * max_pixels, no format that is read, or the helper did not survive it. */
GP_MUST_CHECK gp_status gp_oiio_open(const struct gp_log *log, const char *path,
    const struct gp_stream *stream, const char *reader, int part,
    long long max_pixels, struct gp_decoded *out);

/* -- writing --------------------------------------------------------------- */

/* Makes a file in memory.
 *
 *   image        what is written, but its pixels; attributes are not
 *   types        of EXR: of each channel (enum gp_pixel_type); NULL: floats
 *   pixels       w * h * channels floats, interleaved, or samples of `types`
 *                without padding
 *   ending       of the format, "tif", "exr", ...
 *   type         stored: "half", "float", "uint8", "uint16"
 *   compression  EXR/TIFF compression name, "dwaa:45" with its quality, or ""
 *                for the default
 *   out          the file's bytes; close with gp_stream_close(); empty on
 *                failure
 *
 * A fourth channel is alpha: associated in float types, not associated in
 * integer ones. OpenImageIO does not report a full disk in every format, so the
 * bytes go on to where they belong like all others.
 *
 * Errors: GP_ERR_IO no helper, or OpenImageIO refuses or fails. */
GP_MUST_CHECK gp_status gp_oiio_write(const struct gp_log *log,
    const struct gp_decoded *image, const int *types,
    const struct gp_shared *pixels, const char *ending, const char *type,
    const char *compression, struct gp_stream *out);

/* Starts the helper, so that a run that cannot write fails before its first
 * frame. Errors: GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_oiio_check(const struct gp_log *log,
                                      const char *path);

#endif
