/* Which channels an EXR part gets, and from where. */
#ifndef GP_IO_EXR_SOURCES_H
#define GP_IO_EXR_SOURCES_H

#include "core/frame.h"
#include "core/status.h"
#include "io/exr/encode.h"
#include "io/write.h"

/* `source` borrows names and samples from the frame and the planes, which
 * must live longer. Free with gp_exr_sources_free(). */
struct gp_exr_sources {
    struct gp_exr_source *source;  // sorted by name
    int sources;
    char **made;                   // names that no frame has
    int mades;
};

/* R, G and B from `planes`, as `type`. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_exr_sources_picture(const struct gp_log *log,
                                               const struct gp_frame *f,
                                               const struct gp_planes *planes,
                                               enum gp_pixel_type type,
                                               struct gp_exr_sources *out);

/* The channels of one part, with the colours of several frames of it:
 *   - what is the colour of none of them as it is;
 *   - R, G, B under their names; one that the file did not have is added when
 *     its plane is not all 0;
 *   - grey stays one channel when the planes are the same, bit by bit, and is
 *     R, G, B in its layer otherwise (of a channel without a layer, where R, G
 *     or B are taken, in a layer of its name); luminance-chroma is always
 *     R, G, B.
 *
 *   set  n >= 1 frames of one part; one of them at least was read whole
 *   p    --type holds for the colours
 *
 * Errors: GP_ERR_DATA such a name is taken; GP_ERR_USAGE a channel is the
 * colour of two frames; GP_ERR_BUG out of memory, or no frame is whole.
 */
GP_MUST_CHECK gp_status gp_exr_sources_hdr(const struct gp_log *log,
                                           const struct gp_write_params *p,
                                           const struct gp_hdr_colour *set,
                                           int n, struct gp_exr_sources *out);
void gp_exr_sources_free(struct gp_exr_sources *s);

#endif
