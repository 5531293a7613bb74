/* Which channel of which part a plane is, in a file of any format. */
#ifndef GP_IO_PLANE_FIND_H
#define GP_IO_PLANE_FIND_H

#include "core/frame.h"
#include "core/status.h"
#include "io/exr/exr.h"

#include <stdbool.h>

/* One part and its channels, of which only names count. */
struct gp_plane_part {
    int part;                // number in the file
    const char *name;        // NULL when it has none; borrowed
    const char *view;        // of stereo, NULL when it has none; borrowed
    bool colour;             // this is the part of the frame's colour
    bool deep;
    struct gp_channel *channel;  // into gp_plane_list.channel
    int channels;
};

/* All parts of a file in the order in which they are searched. */
struct gp_plane_list {
    const char *path;            // for messages; borrowed
    struct gp_plane_part *part;  // owned
    int parts;
    struct gp_channel *channel;  // owned; names are borrowed
    int channels;                // of all parts
    const char *view;            // of the frame's colour, where its part has
                                 // several and it is not the first; else NULL
    const struct gp_input *input; // with a view; borrowed
};

/* What was found: a part of the list and a channel of it. Nothing when `part`
 * is NULL. */
struct gp_plane_place {
    const struct gp_plane_part *part;
    int channel;  // index in its part, which is the file's order
};

/* The parts of an EXR. First comes the one of the colour, where there is one;
 * then those of its view or of none; within these, when `depth`, those called
 * depth, as a part of a layer-per-part file has plain Z whatever its layer;
 * deep ones last; then by number.
 *
 *   colour  o->part holds the colour of a frame
 *   list    written always; lives no longer than `o`; free with
 *           gp_plane_list_free()
 *
 * Errors: GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_plane_list_exr(const struct gp_log *log,
                                          const char *path,
                                          const struct gp_input *o,
                                          bool colour, bool depth,
                                          struct gp_plane_list *list);

/* A file of one part with `channels` channels, whose names the caller puts
 * into list->channel[]. Else as above. */
GP_MUST_CHECK gp_status gp_plane_list_one(const struct gp_log *log,
                                          const char *path, bool colour,
                                          int channels,
                                          struct gp_plane_list *list);
void gp_plane_list_free(struct gp_plane_list *list);

/* Finds a channel.
 *
 *   name   a channel of any part, or PART.CHANNEL; NULL searches: for depth
 *          by gp_find_depth() part by part, else A
 *   whole  the file is there for this plane alone: its only channel will do
 *          (for depth A does not count), and finding none is an error
 *   out    written on GP_OK
 *
 * Errors: GP_ERR_USAGE not there, with a list of what is, in the form in
 * which --depth takes it; GP_ERR_DATA two of equal rank in one part.
 */
GP_MUST_CHECK gp_status gp_plane_pick(const struct gp_log *log,
                                      const struct gp_plane_list *list,
                                      const char *name, bool depth, bool whole,
                                      struct gp_plane_place *out);

#endif
