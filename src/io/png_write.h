/* PNG files out, 8 and 16 bits. */
#ifndef GP_IO_PNG_WRITE_H
#define GP_IO_PNG_WRITE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/write.h"

/* gp_write_picture() for PNG: RGB, or RGBA with GP_ALPHA_KEEP and an alpha
 * channel (picture.h says what alpha means where light has none).
 *
 * Colour chunks: for BT.709 primaries cICP (BT.709, sRGB curve), sRGB, gAMA
 * and cHRM; for a scene-linear picture in other primaries gAMA, and cHRM with
 * these primaries unless they are imaginary. Pixels that are not square get a
 * pHYs chunk.
 */
GP_MUST_CHECK gp_status gp_png_write(const struct gp_log *log,
                                     const struct gp_write_params *p,
                                     const char *path,
                                     const struct gp_frame *f,
                                     const struct gp_planes *planes,
                                     enum gp_picture_kind kind);

#endif
