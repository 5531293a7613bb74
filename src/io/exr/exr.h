// SPDX-License-Identifier: Apache-2.0
/* io/exr: EXR files in and out, by OpenEXRCore.
 *
 * In: open.c (checks the bytes of the header before the library sees them),
 * choose.c (which part and channels are the frame), read.c and decode.c. Out:
 * write.c (parts and channels), header.c and encode.c (tables and chunks). */
#ifndef GP_IO_EXR_EXR_H
#define GP_IO_EXR_EXR_H

#include "io/channels.h"
#include "io/frame.h"
#include "core/status.h"
#include "io/read.h"
#include "io/stream.h"
#include "io/write.h"

#include <openexr.h>
#include <stdbool.h>
#include <stddef.h>

/* -- an open file --------------------------------------------------------- */

/* A part; names and channels are borrowed from the context. */
struct gp_exr_part {
    const char *name;  // NULL: none
    const char *view;  // its "view"; NULL: none
    const char *layer; // its name without the view at its end: "rgba" of
                       // rgba.left and rgba_left in a part whose view is left
    size_t length;     // bytes of `layer`; 0 when the part has no name
    const exr_attr_chlist_t *channel; // empty where the library has no list
    exr_attr_box2i_t data;            // window, of at least a pixel
    bool deep, tiled, levels;         // it has smaller levels, too
    int tile_w, tile_h;               // of a chunk of level 0; 0: not known, or
                                      // the width of scanlines
    int chunks;                       // entries of its offset table
    uint64_t first;                   // of these among those of all parts
    uint64_t from, to; // its attributes, with the null that ends them
    const struct gp_exr_attr *attr; // `attrs` of them (exr_priv.h)
    int attrs;
};

/* The EXR that a frame came from: gp_frame.input. It stays open: gp_write_hdr()
 * reads other parts and their raw chunks when it needs them. */
struct gp_input {
    char *path;        // for messages
    exr_context_t exr; // whole header parsed; many threads may read, errors are
                       // return values only
    struct gp_stream stream; // the bytes of exr
    int part, parts;         // colour part and number of parts
    struct gp_exr_part *each; // part
    struct gp_crypto crypto;  // of all parts
    uint64_t
        end; // of the last chunk, by the offset tables of all parts, at most
             // stream.size; 0 when the tables are incomplete
    struct gp_exr_index *index; // places of attributes and offset tables
    char reason[256]; // the library's last message about a bad header
};

/* NULL for a frame that came from no EXR. */
static inline const struct gp_input *gp_input_of(const struct gp_frame *f)
{
    return f->input;
}

/* Parses the header of an EXR.
 *
 *   stream  the whole file; taken over: empty afterwards, also on failure
 *   out     written only on GP_OK; its `part` is 0, the reader sets it
 *
 * Errors: GP_ERR_DATA the header is damaged, or the file is truncated before
 * its last chunk ends, of any part or level; GP_ERR_IO a read failed */
GP_MUST_CHECK gp_status gp_exr_open(const struct gp_log *log, const char *path,
    struct gp_stream *stream, struct gp_input **out);

/* Closes and frees; for gp_frame.input_free. NULL is fine. */
void gp_input_free(void *input);

/* -- parts and views -------------------------------------------------------
 *
 * A stereo file has a part for each view, named by the part's "view"
 * attribute, or all views in one part, named by its "multiView" attribute, a
 * list of which the first is the default view. There the view's name is before
 * the channel's own: right.R, diffuse.right.R; the default view has R.
 * Source: OpenEXR, "Storing Multi-View Images in OpenEXR Files", and
 * viewFromChannelName() of ImfMultiView.cpp.
 *
 * `part` is in [0, in->parts). Strings are borrowed. */

/* True when both parts have views, and not the same. */
bool gp_exr_other_view(const struct gp_input *in, int a, int b);

/* The view, of several in its part, that a channel belongs to; NULL for the
 * default view and in parts of one. */
const char *gp_exr_view_of(const struct gp_input *in, int part,
                           const char *name);

/* Names of all channels of a part in the file's order, as they are called in a
 * view, "" for those of others; with `view` NULL their own. gp_free() before
 * `in`. */
GP_MUST_CHECK gp_status gp_exr_names_in(const struct gp_log *log,
    const struct gp_input *in, int part, const char *view, const char ***out);

/* -- pixels --------------------------------------------------------------- */

/* The chunks of level 0 of a part, checked. */
struct gp_exr_chunks {
    const struct gp_input *input; // borrowed
    int part;
    struct gp_rect window; // of data
    int w, h;              // its size
    exr_compression_t compression;
    bool tiled;
    int tile_w, tile_h;               // or of a block of scanlines
    const exr_attr_chlist_t *channel; // borrowed from the context
    exr_chunk_info_t *chunk;
    int chunks;
    size_t largest;                   // unpacked bytes of the largest chunk
};

/* Where w/xs * h/ys samples of a channel go; not wanted when `to` is NULL. */
struct gp_exr_sink {
    void *to;
    bool as_float; // convert; else the file's own type
};

/* Finds every chunk of level 0 and checks that it is in the file and can expand
 * to its pixels. `out` is written always; free with gp_exr_chunks_free().
 * Errors: GP_ERR_DATA deep data without `deep`, more than max_pixels, truncated or damaged. */
GP_MUST_CHECK gp_status gp_exr_chunks_find(const struct gp_log *log,
                                           const struct gp_input *in, int part,
                                           bool deep, long long max_pixels,
                                           struct gp_exr_chunks *out);
void gp_exr_chunks_free(struct gp_exr_chunks *chunks);

/* Decodes all chunks, in parallel: by OpenEXRCore, DWAA and DWAB by OpenImageIO.
 * `sink` has one entry a channel, in file order.
 * Errors: GP_ERR_DATA a chunk is damaged (the first one is named);
 * GP_ERR_IO no OpenImageIO */
GP_MUST_CHECK gp_status gp_exr_decode(const struct gp_log *log,
    const struct gp_exr_chunks *chunks, const struct gp_exr_sink *sink);

/* The same at full resolution: w * h samples for each channel of the file, in
 * its order; NULL: not wanted. Samples are floats; those of UINT are uint32_t
 * with `numbers`, but for subsampled ones, which are repeated. */
GP_MUST_CHECK gp_status gp_exr_decode_full(const struct gp_log *log,
    const struct gp_exr_chunks *chunks, bool numbers, float *const *to);

/* Deep data: any number of samples a pixel. */
struct gp_exr_deep {
    struct gp_exr_chunks part;
    int64_t *first; // of each pixel, rows from the top: its samples are
                    // [first[i], first[i + 1])
    void **sample;  // of each channel, in file order: floats, of UINT uint32_t
};

/* Reads level 0 of a deep part; most pixels, and samples of a channel, are
 * max_pixels. `out` is written always; free with gp_exr_deep_free().
 * Errors: GP_ERR_DATA over max_pixels, truncated or damaged; GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_exr_deep_read(const struct gp_log *log,
                                         const struct gp_input *in, int part,
                                         long long max_pixels,
                                         struct gp_exr_deep *out);
void gp_exr_deep_free(struct gp_exr_deep *deep);

/* Sets f's windows, pixel aspect ratio, primaries and part by the header. */
void gp_exr_frame_header(const struct gp_exr_chunks *chunks,
                         struct gp_frame *f);

/* gp_read_frame() for an EXR; takes the stream over, also on failure. */
GP_MUST_CHECK gp_status gp_read_exr(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stream *stream,
    struct gp_frame *out);

/* -- out ------------------------------------------------------------------ */

/* gp_write_picture() once `path` is checked. */
GP_MUST_CHECK gp_status gp_exr_write_picture(const struct gp_picture_job *j);

#endif
