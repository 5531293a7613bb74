/* Parts of an EXR by name and view, and views within a part.
 *
 * A stereo file has a part for each view, told by the part's "view" attribute,
 * or all views in one part, told by its "multiView" attribute, a list of names
 * of which the first is the default view. There the view's name stands before
 * the channel's own: right.R, diffuse.right.R; the default view has R.
 * Source: OpenEXR, "Storing Multi-View Images in OpenEXR Files", and
 * viewFromChannelName() of ImfMultiView.cpp.
 */
#ifndef GP_IO_EXR_VIEW_H
#define GP_IO_EXR_VIEW_H

#include "core/status.h"
#include "io/exr/origin.h"

#include <stdbool.h>
#include <stddef.h>

/* All of `o` are EXR, and `part` is in [0, o->parts). Strings are borrowed. */

bool gp_exr_is_deep(const struct gp_origin *o, int part);

/* The part's name or view; NULL when it says none. */
const char *gp_exr_part_name(const struct gp_origin *o, int part);
const char *gp_exr_part_view(const struct gp_origin *o, int part);

/* The part's name without the view at its end: "rgba" of rgba.left and
 * rgba_left in a part whose view is left. Returns its length; 0 and "" when
 * the part has no name. */
size_t gp_exr_part_layer(const struct gp_origin *o, int part,
                         const char **name);

/* The views of a part with several: how many, and each one's name; 0 for
 * other parts. The first GP_EXR_VIEWS count: no file of use has more, and a
 * hostile one would cost that many comparisons for each channel. */
enum { GP_EXR_VIEWS = 64 };
int gp_exr_views(const struct gp_origin *o, int part);
const char *gp_exr_view_name(const struct gp_origin *o, int part, int i);

/* True when the part is of that view, or has channels of it. */
bool gp_exr_part_has_view(const struct gp_origin *o, int part,
                          const char *view);

/* The channel's name without its view, into `to`, which has room for it: its
 * own name in parts of one view. False when it belongs to another view.
 * Channels of no view go with the default view. */
bool gp_exr_bare_name(const struct gp_origin *o, int part, const char *view,
                      const char *name, char *to);

/* The channels of a part as they are called within a view. */
struct gp_exr_names {
    const char **name;  // "" for those of other views
    char *text;
    int n;
};

/* Names of all channels in the file's order; with `view` NULL their own. Lives
 * no longer than `o`; written always; free with gp_exr_names_free().
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_exr_names_in(const struct gp_log *log,
                                        const struct gp_origin *o, int part,
                                        const char *view,
                                        struct gp_exr_names *out);
void gp_exr_names_free(struct gp_exr_names *names);

/* The view, of several in its part, that a channel belongs to; NULL for the
 * default view and in parts of one. */
const char *gp_exr_view_of(const struct gp_origin *o, int part,
                           const char *name);

#endif
