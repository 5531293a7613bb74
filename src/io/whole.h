/* Whether JPEG, TIFF, IFF and DPX files are all there. Their decoders fill
 * what is missing with grey or zeros and say nothing, take memory for what is
 * not there, or speak to stderr themselves. */
#ifndef GP_IO_WHOLE_H
#define GP_IO_WHOLE_H

#include "core/status.h"
#include "io/stream.h"

/* Walks a JPEG's segments and scans to EOI, an IFF's tiles, a DPX's user data, the tables of
 * a TIFF's directory `part`, whose deflated rows it unpacks. Files of other
 * formats pass. What lies behind the end does not matter. `path` is for the
 * message.
 *
 * Errors: GP_ERR_DATA cut off, or a chunk's checksum or data are wrong;
 * GP_ERR_IO; GP_ERR_BUG out of memory.
 * Sources: ITU-T T.81, B.1.1; whole_iff.h,
 * whole_tiff.h.
 */
GP_MUST_CHECK gp_status gp_whole_check(const struct gp_log *log,
                                       const char *path,
                                       const struct gp_stream *s, int part,
                                       long long max_pixels);

#endif
