/* EXR files to frames. */
#ifndef GP_IO_EXR_READ_H
#define GP_IO_EXR_READ_H

#include "io/read.h"
#include "io/stream.h"

/* gp_read_frame() for a stream that begins as an EXR; takes the stream over,
 * also on failure. Contract and errors as there. */
GP_MUST_CHECK gp_status gp_read_exr(const struct gp_log *log,
                                    const struct gp_read_params *p,
                                    const char *path, struct gp_stream *stream,
                                    struct gp_frame *out);

#endif
