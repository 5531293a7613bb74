/* EXR files to frames. */
#ifndef GP_IO_EXR_READ_H
#define GP_IO_EXR_READ_H

#include "io/exr/choose.h"
#include "io/exr/origin.h"
#include "io/read.h"
#include "io/stream.h"

/* gp_read_frame() for a stream that begins as an EXR; takes the stream over,
 * also on failure. Contract and errors as there. */
GP_MUST_CHECK gp_status gp_read_exr(const struct gp_log *log,
                                    const struct gp_read_params *p,
                                    const char *path, struct gp_stream *stream,
                                    struct gp_frame *out);

/* The frame of one part and its colour. `o` stays the caller's, and the frame
 * has no origin. Errors as in gp_read_frame(). */
GP_MUST_CHECK gp_status gp_exr_read_choice(const struct gp_log *log,
                                           const struct gp_read_params *p,
                                           const char *path,
                                           const struct gp_origin *o,
                                           const struct gp_exr_choice *choice,
                                           struct gp_frame *out);

#endif
