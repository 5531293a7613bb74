/* Whether zlib streams of a file are whole. OpenImageIO leaves the rows of a
 * strip of 8 or 16 bits that it cannot unpack as they were, and libtiff does
 * not look at the checksum of one whose rows it has. */
#ifndef GP_IO_WHOLE_ZIP_H
#define GP_IO_WHOLE_ZIP_H

#include "core/status.h"
#include "io/stream.h"

struct gp_zip {
    uint64_t at, bytes;      // of the stream in the file; it may end earlier
    uint64_t size, or_size;  // of what it unpacks to: either
};

/* Unpacks each of `n` streams and drops it, checksum included. Memory is that
 * of a packed and an unpacked one for each thread. Prints nothing.
 *
 *   failed  the first one that fails, when one does
 *
 * Errors: GP_ERR_DATA damaged; GP_ERR_IO cannot be read; GP_ERR_BUG out of
 * memory.
 * Source: RFC 1950.
 */
GP_MUST_CHECK gp_status gp_whole_zip(const struct gp_stream *s,
                                     const struct gp_zip *zip, int n,
                                     int *failed);

#endif
