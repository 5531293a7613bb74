/* Opening an input and seeing what it is. */
#ifndef GP_IO_READ_OPEN_H
#define GP_IO_READ_OPEN_H

#include "io/image.h"
#include "io/read.h"
#include "io/stream.h"

#include <stdbool.h>

/* Opens `path` or stdin, looks at its first bytes and, when an image may begin
 * so, reads a pipe to its end.
 *
 *   stream  empty on failure; else the caller's to close
 *   exr     written on GP_OK: it begins as an EXR
 *
 * Errors: those of gp_stream_open() and gp_stream_fill(), whose limit is 16
 * bytes for each of max_pixels, and 64 MiB; GP_ERR_DATA the name says EXR and
 * the bytes do not, or a pipe begins like no image.
 */
GP_MUST_CHECK gp_status gp_read_open(const struct gp_log *log,
                                     const struct gp_read_params *p,
                                     const char *path,
                                     struct gp_stream *stream, bool *exr);

/* Opens picture `part` of a stream of any format but EXR, by its first bytes;
 * the stream stays the caller's and must live until gp_image_close().
 * Errors: GP_ERR_IO there is no bridge; GP_ERR_DATA damaged, cut off, over
 * max_pixels, or no format that is read; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_read_image(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path,
                                      const struct gp_stream *stream, int part,
                                      struct gp_image *out);

/* gp_read_frame() for an open stream, from its first bytes on; takes the
 * stream over: it is closed, or lives on in the frame. */
GP_MUST_CHECK gp_status gp_read_stream(const struct gp_log *log,
                                       const struct gp_read_params *p,
                                       const char *path,
                                       struct gp_stream *stream,
                                       struct gp_frame *out);

#endif
