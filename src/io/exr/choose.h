/* Which part of an EXR is the frame, and which of its channels the colour. */
#ifndef GP_IO_EXR_CHOOSE_H
#define GP_IO_EXR_CHOOSE_H

#include "core/status.h"
#include "io/colour.h"
#include "io/exr/origin.h"
#include "io/read.h"

struct gp_exr_choice {
    int part;
    struct gp_colour_choice colour;  // indices of the part's channels
};

/* Chooses by p->layer, p->part and p->view, as read.h says.
 *
 *   first  the part that is looked at before the others
 *   out    written only on GP_OK; may be a deep part, without a colour, which
 *          gp_exr_layout_make() refuses
 *
 * Errors: GP_ERR_DATA no colour channel; GP_ERR_USAGE as in gp_read_frame();
 * GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_exr_choose(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path,
                                      const struct gp_origin *o, int first,
                                      struct gp_exr_choice *out);

/* The number of the part that p->part names, or -1. */
int gp_exr_part_number(const struct gp_origin *o, const char *part);

/* The line for what is not there: what p asks for, and what the file has.
 * Returns GP_ERR_USAGE. */
gp_status gp_exr_not_there(const struct gp_log *log,
                           const struct gp_read_params *p, const char *path,
                           const struct gp_origin *o);

#endif
