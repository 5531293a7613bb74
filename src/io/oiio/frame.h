/* What the OpenImageIO bridge reads, as a frame. */
#ifndef GP_IO_OIIO_FRAME_H
#define GP_IO_OIIO_FRAME_H

#include "io/oiio/oiio.h"
#include "io/read.h"
#include "io/stream.h"

/* gp_read_frame() for a stream of any format but EXR; the stream stays the
 * caller's. Contract and errors as there, and GP_ERR_IO when there is no
 * bridge. */
GP_MUST_CHECK gp_status gp_read_other(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path,
                                      const struct gp_stream *stream,
                                      struct gp_frame *out);

/* Its image alone, with values as stored; free with gp_image_free(). Errors
 * as above. */
GP_MUST_CHECK gp_status gp_read_image(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path,
                                      const struct gp_stream *stream,
                                      struct gp_oiio_image *out);

/* Frees an image of gp_read_image(); one that is all zero is fine. */
void gp_image_free(struct gp_oiio_image *image);

/* gp_read_other() from an image that is already there; it stays the
 * caller's. `layer` as in gp_read_params. */
GP_MUST_CHECK gp_status gp_frame_of_image(const struct gp_log *log,
                                          const char *path, const char *layer,
                                          const struct gp_oiio_image *image,
                                          struct gp_frame *out);

#endif
