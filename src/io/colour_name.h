/* Names of channels that belong together. */
#ifndef GP_IO_COLOUR_NAME_H
#define GP_IO_COLOUR_NAME_H

#include "core/frame.h"

#include <stddef.h>

/* Length of the layer in front of a channel's own name, with its dot: 8 for
 * "diffuse.R", 0 for "R". */
size_t gp_layer_length(const char *name);

/* The name of red, green or blue (c = 0, 1, 2) in the layer of `name`, and
 * spelled as it: G for R, diffuse.blue for diffuse.red; R, G, B for a `name`
 * that is no colour. From malloc, NULL when memory is full. */
char *gp_colour_name(const char *name, int c);

/* The channel of f with the opacity of its colour: A or alpha (any case) in
 * the colour's layer. -1 when there is none. */
int gp_find_alpha(const struct gp_frame *f);

#endif
