/* Files that the OpenImageIO bridge makes, gathered in memory.
 *
 * OpenImageIO does not tell of a full disk in every format, and has no
 * temporary names. So it writes to a file in memory, and the bytes go on to
 * where they belong like all others.
 */
#ifndef GP_IO_BRIDGE_WRITE_H
#define GP_IO_BRIDGE_WRITE_H

#include "core/status.h"
#include "io/oiio/oiio.h"
#include "io/stream.h"

#include <stdbool.h>

/* Writes `img` as `format`; arguments as in gp_oiio_api.write.
 *
 *   path  for messages
 *   out   the file's bytes; close with gp_stream_close(); empty on failure
 *
 * Errors: GP_ERR_IO no bridge, or OpenImageIO refuses.
 */
GP_MUST_CHECK gp_status gp_bridge_write(const struct gp_log *log,
                                        const char *path, const char *format,
                                        const struct gp_oiio_image *img,
                                        const char *type,
                                        const char *compression,
                                        struct gp_stream *out);

/* Whether the bridge writes that ending. Errors: GP_ERR_IO no bridge. */
GP_MUST_CHECK gp_status gp_bridge_can_write(const struct gp_log *log,
                                            const char *path,
                                            const char *format, bool *can);

#endif
