/* Whether an IFF's tiles are all there. OpenImageIO's reader trusts their runs
 * and their place, and leaves those that it does not find black. */
#ifndef GP_IO_WHOLE_IFF_H
#define GP_IO_WHOLE_IFF_H

#include "core/status.h"
#include "io/stream.h"

/* Checks Maya's IFF (FOR4, CIMG): its length, its head, and its tiles, which
 * are as many as said, lie within the picture, have its area, and unpack to
 * their rows. Memory is that of a packed tile.
 *
 *   max_pixels  a larger picture passes without a look at its tiles: it is
 *               refused later
 *
 * Refused though whole, for it is read wrong: an origin other than 0,0, and a
 * chunk between the tiles that is none.
 *
 * Errors: GP_ERR_DATA; GP_ERR_IO; GP_ERR_BUG out of memory.
 * Source: iff.imageio of OpenImageIO 2.4, which has Autodesk's description.
 */
GP_MUST_CHECK gp_status gp_whole_iff(const struct gp_log *log,
                                     const char *path,
                                     const struct gp_stream *s,
                                     long long max_pixels);

#endif
