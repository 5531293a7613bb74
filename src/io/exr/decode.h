/* Pixels of one part of an EXR: first everything that could be a lie is
 * checked against the file, then the chunks are decoded in parallel straight
 * into the planes.
 */
#ifndef GP_IO_EXR_DECODE_H
#define GP_IO_EXR_DECODE_H

#include "core/status.h"
#include "io/exr/origin.h"

#include <stdbool.h>
#include <stddef.h>

/* The chunks of level 0 of a part, checked. */
struct gp_exr_layout {
    const struct gp_origin *origin;   // borrowed
    const char *path;                 // borrowed; for messages
    int part;
    int x0, y0, w, h;                 // data window
    exr_compression_t compression;
    exr_storage_t storage;
    int tile_w, tile_h;               // 0 for scanlines
    int lines;                        // of a block of scanlines; 0 for tiles
    const exr_attr_chlist_t *channel; // borrowed from the context
    exr_chunk_info_t *chunk;
    int chunks;
    size_t largest;                   // unpacked bytes of the largest chunk
};

/* Where the samples of one channel go: w/xs * h/ys of them, rows without
 * padding. Not wanted when `to` is NULL. */
struct gp_exr_sink {
    void *to;
    bool as_float;  // convert; else the file's own type
};

/* Reads the place and size of every chunk of level 0 and checks that each
 * lies in the file and could hold as much as it claims: stored chunks exactly
 * their size, compressed ones at most what their method can expand to. Takes
 * memory for the list of chunks only, which the offset table in the file
 * bounds.
 *
 *   l  written always; free with gp_exr_layout_free()
 *
 * Errors: GP_ERR_DATA deep data, more than max_pixels, cut off or damaged.
 */
GP_MUST_CHECK gp_status gp_exr_layout_make(const struct gp_log *log,
                                           const char *path,
                                           const struct gp_origin *origin,
                                           int part, long long max_pixels,
                                           struct gp_exr_layout *l);
void gp_exr_layout_free(struct gp_exr_layout *l);

/* True when the installed OpenEXRCore can decode the part's compression:
 * 3.1.5 lacks DWAA and DWAB. */
bool gp_exr_can_decode(const struct gp_exr_layout *l);

/* Decodes all chunks. `sink` has one entry a channel, in file order. The
 * planes are whole only on GP_OK.
 * Errors: GP_ERR_DATA a chunk is damaged (the first one is named);
 * GP_ERR_BUG out of memory.
 */
GP_MUST_CHECK gp_status gp_exr_decode(const struct gp_log *log,
                                      const struct gp_exr_layout *l,
                                      const struct gp_exr_sink *sink);

/* The same through the OpenImageIO bridge, for what the library lacks.
 * Errors: GP_ERR_IO no bridge; GP_ERR_DATA the bridge cannot read it. */
GP_MUST_CHECK gp_status gp_exr_decode_by_bridge(
    const struct gp_log *log, const struct gp_exr_layout *l,
    const struct gp_exr_sink *sink);

#endif
