/* Formats that are neither EXR nor PNG. */
#ifndef GP_IO_OTHER_WRITE_H
#define GP_IO_OTHER_WRITE_H

#include "core/frame.h"
#include "core/status.h"
#include "io/write.h"

/* gp_write_picture() for Radiance HDR and PFM, which hold floats; TIFF, which
 * holds either; and integer formats, JPEG, DPX, TGA, BMP, PPM and what else
 * OpenImageIO writes. TIFF is what --type says, and without it floats for a
 * scene-linear picture and --depth-bits for one to be shown. All show the
 * display window. Radiance HDR holds three mantissas and an exponent: the
 * nearest of those are stored, NaN and negative values as 0, what lies beyond
 * as the largest. GP_ALPHA_KEEP keeps alpha in TIFF, TGA and WebP; the
 * others are over black. */
GP_MUST_CHECK gp_status gp_other_write(const struct gp_log *log,
                                       const struct gp_write_params *p,
                                       const char *path, const char *ending,
                                       const struct gp_frame *f,
                                       const struct gp_planes *planes,
                                       enum gp_picture_kind kind);

/* Whether that can be done with these params. Errors: GP_ERR_USAGE unknown
 * ending, more bits than the format has, a compression that TIFF lacks;
 * GP_ERR_IO no OpenImageIO bridge. */
GP_MUST_CHECK gp_status gp_other_check(const struct gp_log *log,
                                       const struct gp_write_params *p,
                                       const char *path, const char *ending);

#endif
