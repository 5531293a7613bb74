// SPDX-License-Identifier: Apache-2.0
/* Channels by their names: which are the colour, its alpha, the depth, ids. */
#ifndef GP_IO_CHANNELS_H
#define GP_IO_CHANNELS_H

#include "io/frame.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>

/* -- colour ---------------------------------------------------------------- */

struct gp_colour_choice {
    enum gp_colour_model model;
    /* Channels of R, G, B; for GREY the channel is [0]; for YC RY, Y, BY, as
     * OpenEXR's Rgba keeps them. -1 where the file has none. */
    int index[3];
};

/* Returns which colour a channel is, 0 to 2; -1: none. */
static inline int gp_colour_of(const struct gp_colour_choice *c, int channel)
{
    return c->index[0] == channel   ? 0
           : c->index[1] == channel ? 1
           : c->index[2] == channel ? 2
                                    : -1;
}

enum { GP_CHANNEL_NAME = 255 }; // bytes of an EXR channel's name, at most

/* Finds the colour among n channel names, in the order that read.h gives;
 * false when there is none.
 *
 *   lone  also take the only channel there is beside those of data: coverage,
 *         depth, numbers of objects, and layers that gp_is_light() refuses
 *
 * Of several layers one called Combined, beauty or rgba is preferred to the
 * first: in Blender's files the ambient occlusion pass comes first.
 * Cryptomatte's ids are never colour, nor are layers of data, nor is an empty
 * name, by which the caller excludes a channel. */
bool gp_find_colour(const char *const *name, int n, bool lone,
                    struct gp_colour_choice *out);

/* Finds the colour of one layer: LAYER.R,G,B, LAYER.red,green,blue of any
 * case, LAYER.Y with LAYER.RY or BY, LAYER.Y. Of "" the channels without a
 * layer.
 *
 *   lone  only the channel that is called `layer` itself, as grey */
bool gp_find_layer_colour(const char *const *name, int n, const char *layer,
                          bool lone, struct gp_colour_choice *out);

/* Length of the layer in front of a channel's own name, with its dot: 8 for
 * "diffuse.R", 0 for "R". */
size_t gp_layer_length(const char *name);

/* The start of the last part of the first n bytes of a name: 10 for
 * "ViewLayer.Mist". */
size_t gp_last_part(const char *name, size_t n);

/* Returns the name of red, green or blue (c = 0, 1, 2) in the layer of `name`,
 * in its spelling: G for R, diffuse.blue for diffuse.red; R, G, B for a `name`
 * that is no colour. From malloc, NULL when memory is full. */
char *gp_colour_name(const char *name, int c);

/* Returns the channel of f with its colour's opacity: A or alpha (any case) in
 * the colour's layer; -1 when there is none. */
int gp_find_alpha(const struct gp_frame *f);

/* -- depth and samples ----------------------------------------------------- */

/* Finds the depth among n channels, of which only names are used, in the order
 * Z, depth.Z, Depth.Z, *.Depth.Z, *.Z. The last of these is not depth when its
 * layer also has X and Y (normals.Z is not depth), is named like a vector (N,
 * normal(s), P, position, velocity, ...), or is Mist, Blender's factor of fog
 * in [0, 1]; nor is Z beside plain X and Y, which a part of vectors has.
 *
 *   path    of their file, for messages
 *   colour  a channel of the colour, or NULL: depth in its layer comes before
 *           any other, then depth in the layer around that, and so on: with
 *           B.Combined.R B.Depth.Z, and not A.Depth.Z
 *   out     its index, or -1 when there is none
 *
 * Errors: GP_ERR_DATA two candidates of equal rank (names both). */
GP_MUST_CHECK gp_status gp_find_depth(const struct gp_log *log,
    const char *path, const struct gp_channel *channel, int n,
    const char *colour, int *out);

/* True for a layer, or part, called Mist (any case) after its last dot. */
bool gp_is_mist(const char *layer, size_t len);

/* False for a layer, or part, that by its name, after its last dot, holds
 * vectors, depth, ids or masks (N, position, uv, depth, mask, ...; any case). */
bool gp_is_light(const char *layer, size_t len);

/* True when the channel's name is among those that gp_find_depth() searches. */
bool gp_channel_is_depth(const struct gp_frame *f, int channel);

/* Adds a channel's name, as PART.NAME where `part` is not NULL, to a list with
 * commas, which starts as ""; one that is full ends with "...". */
enum { GP_CHANNEL_LIST = 1500 };
void gp_channel_list_add(char to[GP_CHANNEL_LIST], const char *part,
                         const char *name);

/* Samples of a channel at full resolution as float, w * h of the frame, into
 * caller's `out`; subsampled channels are repeated. NaN and Inf stay. */
void gp_channel_floats(const struct gp_frame *f, int channel, float *out);

/* -- Cryptomatte -----------------------------------------------------------
 *
 * Layers that hold ids of objects as the bits of floats.
 *
 * Such samples are no light. A sum or a mean of two of them is another id, and
 * one bit less is too, so they are never filtered and never stored with loss.
 * Source: Friedman and Jones, "Cryptomatte specification", version 1.2.0: the
 * attribute cryptomatte/HASH/name names a layer NAME, whose ids and coverages
 * are the channels NAME00.R,G,B,A, NAME01.R, ... and whose preview, if there
 * is one, is NAME.R,G,B. */

/* Layers that a file names; more of them are known only by their channels'
 * names, as in a file that names none. */
enum { GP_CRYPTO_LAYERS = 64 };
struct gp_crypto {
    // borrowed from the input; key: the attribute's name, of `part`
    const char *layer[GP_CRYPTO_LAYERS];
    int n, part[GP_CRYPTO_LAYERS];
    const char *key[GP_CRYPTO_LAYERS];
};

enum gp_crypto_kind {
    GP_CRYPTO_NONE,
    GP_CRYPTO_PREVIEW,  // a picture of ids, which nothing reads back
    GP_CRYPTO_IDS,
};

/* Returns what the layer of that name of `len` bytes holds. Without an
 * attribute that names it, ids are what begins with "crypto" (any case) after
 * its last dot and ends with two digits. */
enum gp_crypto_kind gp_crypto_layer(const struct gp_crypto *c,
                                    const char *layer, size_t len);

#endif
