/* Pictures that the OpenImageIO bridge reads. */
#ifndef GP_IO_OIIO_IMAGE_H
#define GP_IO_OIIO_IMAGE_H

#include "io/image.h"
#include "io/stream.h"

/* Opens picture `part` (0: the first) of a stream, which stays the caller's
 * and must live until gp_image_close().
 *
 *   out  written only on GP_OK; rows from rows()
 *
 * Errors: GP_ERR_IO there is no bridge; GP_ERR_DATA damaged, cut off, over
 * max_pixels, or no format that OpenImageIO reads; GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_oiio_image_open(const struct gp_log *log,
                                           const char *path,
                                           const struct gp_stream *stream,
                                           int part, long long max_pixels,
                                           struct gp_image *out);

#endif
