/* Which channels of a file are its colour. */
#ifndef GP_IO_COLOUR_H
#define GP_IO_COLOUR_H

#include "core/frame.h"

#include <stdbool.h>

struct gp_colour_choice {
    enum gp_colour_model model;
    /* Channels of R, G, B; for GREY the channel is [0]; for YC RY, Y, BY, as
     * OpenEXR's Rgba keeps them. -1 where the file has none. */
    int index[3];
};

enum { GP_CHANNEL_NAME = 255 }; // bytes of an EXR channel's name, at most

/* Finds the colour among n channel names, in the order that read.h gives;
 * false when there is none.
 *
 *   lone  also take the only channel there is (alpha does not count), which
 *         in a file of many parts is more likely depth than colour
 *
 * Of several layers one that is called Combined, beauty or rgba comes before
 * the first: Blender's ambient occlusion pass stands before its picture.
 * Cryptomatte's ids are never colour (crypto.h), nor is an empty name, which
 * stands for a channel that is not to be taken.
 */
bool gp_find_colour(const char *const *name, int n, bool lone,
                    struct gp_colour_choice *out);

/* Finds the colour of one layer: LAYER.R,G,B, LAYER.red,green,blue of any
 * case, LAYER.Y with LAYER.RY or BY, LAYER.Y. Of "" the channels without a
 * layer.
 *
 *   lone  only the channel that is called `layer` itself, as grey
 */
bool gp_find_layer_colour(const char *const *name, int n, const char *layer,
                          bool lone, struct gp_colour_choice *out);

#endif
