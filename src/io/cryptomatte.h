// SPDX-License-Identifier: Apache-2.0
/* Cryptomatte: the coverage of objects by their names.
 *
 * A type (objects, materials, ...) NAME has layers NAME00, NAME01, ..., each of
 * two ranks: an id in R and its coverage in G, an id in B and its coverage in A.
 * Source: Friedman and Jones, "Cryptomatte specification", version 1.2.0. */
#ifndef GP_IO_CRYPTOMATTE_H
#define GP_IO_CRYPTOMATTE_H

#include "core/status.h"
#include "io/frame.h"
#include "io/read.h"

/* Reads the coverage of objects: of each type the sum over ranks and names,
 * of several types the largest, at most 1.
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
