/* Frames without a header, as ffmpeg's rawvideo takes them. */
#ifndef GP_IO_RAW_WRITE_H
#define GP_IO_RAW_WRITE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/write.h"

/* gp_write_picture() for frames that follow each other in one stream: the
 * display window's pixels, R, G, B, rows from the top, no padding.
 *
 *   p      raw and dither are used. Integers are the codes that a PNG of 8 or
 *          16 bits has; floats are the values as they are
 *   stats  raw is the size of the frames before, 0 x 0 at the first, and
 *          becomes this frame's
 *
 * Errors: those of gp_write_picture(); GP_ERR_DATA a size other than that of
 * the frames before, which a stream without headers cannot say.
 */
GP_MUST_CHECK gp_status gp_raw_write(const struct gp_log *log,
                                     const struct gp_write_params *p,
                                     const char *path,
                                     const struct gp_frame *f,
                                     const struct gp_planes *planes,
                                     enum gp_picture_kind kind,
                                     struct gp_write_stats *stats);

#endif
