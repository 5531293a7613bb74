// SPDX-License-Identifier: Apache-2.0
/* Planes beside the colour: depth and coverage, from any part or file. */
#ifndef GP_IO_PLANE_H
#define GP_IO_PLANE_H

#include "io/frame.h"
#include "core/status.h"
#include "io/read.h"

#include <stdbool.h>

/* Reads a plane beside a frame that gp_read_frame() read.
 *
 *   name   a channel of just that name in any part, the colour's first, or
 *          PART.CHANNEL, the part by its name attribute; NULL searches
 *   depth  search for depth: first among the channels of the colour's part,
 *          as gp_find_depth(); then, where that has none, in the file's other
 *          parts by the same ranks within each; the first part that has one
 *          is taken. Parts of the colour's view (of stereo) or of none come
 *          before those of other views, which are taken with a warning; then
 *          those with "depth" in their name; then file order. Passes over
 *          deep parts, with a warning when only they have depth. False: for
 *          A, the coverage
 *   out    written on GP_OK; empty (v NULL) when searching finds none; its
 *          window is that of the part in the file, also where the frame has
 *          grown; its name in the form that `name` takes
 *
 * Samples are those of the file, also of an EXR's colour channels whose planes
 * the frame has changed. Subsampled ones are repeated.
 *
 * Errors: GP_ERR_USAGE the name is nowhere (the line lists the channels of
 * all parts); GP_ERR_DATA two candidates of equal rank in one part, a part
 * that cannot be decoded. Frames of other formats than EXR have one part. */
GP_MUST_CHECK gp_status gp_read_plane(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f, const char *name,
    bool depth, struct gp_plane *out);

/* Reads `n` channels of a part of a frame's file, flat, by their numbers in the
 * part; for one below 0 the plane stays empty. The part is decoded once, the
 * frame's own not at all, unless they are its colour.
 *   out  empty; on failure some may have been read, too */
GP_MUST_CHECK gp_status gp_read_channels(const struct gp_log *log,
                                         const struct gp_read_params *p,
                                         const struct gp_frame *f, int part,
                                         const int *channel, int n,
                                         struct gp_plane *out);

/* Names of a layer of three channels, best first, and sets of names of those
 * channels. */
struct gp_layer_names {
    const char *what;     // for messages
    const char *layer[8]; // NULL ends
    const char *channel[3][3];
};

/* Reads three planes of a layer beside a frame.
 *
 * Searches the colour's part, then the other parts of the colour's view or of
 * none in the order of gp_read_plane(), whose channels are called PART.CHANNEL
 * here; passes over deep parts. Within a part, LAYER.CHANNEL in the colour's
 * layer comes before any other, then that in the layer around it, and so on:
 * with B.Combined.R B.N.X, and not A.N.X. All three are of one layer. In parts
 * of several views the names are those within the colour's.
 *
 *   out  written on GP_OK: the planes, as gp_read_plane()
 *
 * Warns where two layers rank equal (the first is taken), and where the layer
 * is in another one than the colour.
 *
 * Errors: GP_ERR_USAGE no such layer; else as gp_read_plane(). */
GP_MUST_CHECK gp_status gp_read_vectors(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f,
    const struct gp_layer_names *wanted, struct gp_plane out[3]);

/* Finds that depth without reading it: its name in the form that `name` takes,
 * gp_free() it, or NULL when searching finds none; and the type of its samples. */
GP_MUST_CHECK gp_status gp_name_depth(const struct gp_log *log,
    const struct gp_frame *f, const char *name, char **channel,
    enum gp_pixel_type *type);

/* Reads a plane from a file of its own, which need not hold colour: EXR, or any
 * format of glarepp-oiio (a grey TIFF of depth, a PNG matte as stored, without
 * a colour curve; integers 0 to 1). `depth` says which of the two is looked
 * for; name NULL: depth as above, coverage A, else the only channel there is
 * (for depth beside alpha). `out` is never empty on GP_OK.
 * Errors: as gp_read_frame(), and as above; without a name GP_ERR_USAGE when
 * no channel, or more than one, could be it. */
GP_MUST_CHECK gp_status gp_read_plane_file(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const char *name,
    bool depth, struct gp_plane *out);

/* Reads a mask: the channel `name` beside a frame, as gp_read_plane(); where it
 * has none, from the file `path` A, else the only channel, else R.
 * Errors: as above; GP_ERR_USAGE neither is there. */
GP_MUST_CHECK gp_status gp_read_mask(const struct gp_log *log,
                                     const struct gp_read_params *p,
                                     const struct gp_frame *f, const char *name,
                                     const char *path, struct gp_plane *out);

/* Reads the coverage of objects from Cryptomatte: of each type the sum over
 * ranks and names, of several types the largest, at most 1 (cryptomatte.c).
 *
 *   f      maybe grown; the layers may be in any of its file's parts
 *   names  NAME[,NAME]: * is any text, ? one character, and \ takes what
 *          follows as it is. Names are those of the manifests, in the header or
 *          in the file beside f's that it names. A whole name that they lack
 *          counts where a pixel has its id; where none has and a type comes
 *          without a manifest, a warning says so
 *   out    written on GP_OK: the window is f's, the name a list of those that
 *          were found, cut at GP_CHANNEL_LIST
 *
 * Errors: GP_ERR_DATA f has no Cryptomatte, or one of another hash, whose ids are
 * no 32-bit floats, or whose manifest is damaged or has over 4 bytes a pixel and
 * 1 MiB; no such name (the nearest three); a wild card without a manifest. */
GP_MUST_CHECK gp_status gp_read_crypto(const struct gp_log *log,
                                       const struct gp_read_params *p,
                                       const struct gp_frame *f,
                                       const char *names, struct gp_plane *out);

#endif
