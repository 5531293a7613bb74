/* Whether a PNG is whole and its rows can be decoded. OpenImageIO lets libpng
 * print its errors to stderr; what libpng would say of these bytes is said
 * here first. */
#ifndef GP_IO_WHOLE_PNG_H
#define GP_IO_WHOLE_PNG_H

#include "core/status.h"
#include "io/stream.h"

/* Decodes every row once and drops it, then reads to IEND; a wrong checksum of
 * any chunk is an error. Memory is that of two rows and of libpng, whose own
 * limits on chunks hold.
 *
 *   max_pixels  a larger picture is refused before its rows
 *
 * Errors: GP_ERR_DATA; GP_ERR_IO cannot be read; GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_whole_png(const struct gp_log *log,
                                     const char *path,
                                     const struct gp_stream *s,
                                     long long max_pixels);

#endif
