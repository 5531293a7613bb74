/* Whether PNG and JPEG files are all there. Their decoders fill what is missing
 * with grey and say nothing, or speak to stderr themselves. */
#ifndef GP_IO_WHOLE_H
#define GP_IO_WHOLE_H

#include "core/status.h"
#include "io/stream.h"

/* Walks a PNG's chunks to IEND, checksums included, and a JPEG's segments and
 * scans to EOI; files of other formats pass. What lies behind the end does not
 * matter. `path` is for the message.
 *
 * Errors: GP_ERR_DATA cut off, or a chunk's checksum is wrong; GP_ERR_IO.
 * Sources: W3C PNG (third edition), 5.3; ITU-T T.81, B.1.1.
 */
GP_MUST_CHECK gp_status gp_whole_check(const struct gp_log *log,
                                       const char *path,
                                       const struct gp_stream *s);

#endif
