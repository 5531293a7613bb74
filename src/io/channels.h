/* Finding a channel by what it is for. */
#ifndef GP_IO_CHANNELS_H
#define GP_IO_CHANNELS_H

#include "core/frame.h"
#include "core/status.h"

#include <stdbool.h>

/* Finds the depth channel.
 *
 *   name  the channel the user asked for, or NULL to search in the order
 *         Z, depth.Z, Depth.Z, *.Depth.Z, *.Z. A trailing ".Z" alone is not
 *         depth when its layer also has X and Y (normals.Z is not depth), or
 *         is named like a vector (N, normal(s), P, position, velocity, ...);
 *         nor is Z beside plain X and Y, which a part of vectors has.
 *   out   index into f->channel, or -1 when searching finds none
 *
 * Errors: GP_ERR_USAGE the name is not in the frame (the line lists the
 * channels it has); GP_ERR_DATA two candidates of equal rank (names both).
 */
GP_MUST_CHECK gp_status gp_find_depth(const struct gp_log *log,
                                      const struct gp_frame *f,
                                      const char *name, int *out);

/* Finds a channel by its exact name; the error is as above. */
GP_MUST_CHECK gp_status gp_find_channel(const struct gp_log *log,
                                        const struct gp_frame *f,
                                        const char *name, int *out);

/* Adds a channel's name, as PART.NAME where `part` is not NULL, to a list
 * with commas, which begins empty. False when it ends with "...", for want of
 * room. */
enum { GP_CHANNEL_LIST = 1500 };
bool gp_channel_list_add(char to[GP_CHANNEL_LIST], const char *part,
                         const char *name);

/* Samples of a channel at full resolution as float, w * h of the frame, into
 * caller's `out`; subsampled channels are repeated. NaN and Inf stay. */
void gp_channel_floats(const struct gp_frame *f, int channel, float *out);

#endif
