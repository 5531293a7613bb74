// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of io/exr: nothing here is for other folders. */
#ifndef GP_IO_EXR_EXR_PRIV_H
#define GP_IO_EXR_EXR_PRIV_H

#include "io/exr/exr.h"
#include "io/file.h"

#include <stdint.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__,
               "EXR is little-endian: big-endian machines need byte swaps");

/* -- why the library failed (open.c) ----------------------------------------
 *
 * The library reports full memory and read errors as a damaged file, and after
 * some of them goes on without an attribute. So it allocates and reads through
 * these functions, which keep failures, for each thread. */

/* malloc(), for alloc_fn of a context, and gp_stream_read(). */
void *gp_exr_allocate(size_t size);
int64_t gp_exr_read_bytes(const struct gp_stream *s, void *to, uint64_t n,
                          uint64_t offset);

/* Clears this thread's failures; call it before the library. Afterwards: GP_OK,
 * GP_ERR_BUG memory was full, GP_ERR_IO a read failed. */
void gp_exr_fault_clear(void);
gp_status gp_exr_fault(void);

/* True when a read since got fewer bytes than it asked for, as those of headers
 * may. Of an uncompressed chunk of a file that was truncated after it was
 * opened, OpenEXRCore 3.1.5 makes the rest black and reports nothing. */
bool gp_exr_fault_short(void);

/* Prints the line for `fault`, with this thread's reason, and returns it. */
gp_status gp_exr_fault_print(const struct gp_log *log, const char *path,
                             gp_status fault);

/* -- the header's bytes (open.c) ------------------------------------------- */

/* An attribute; pointers go into gp_exr_index.bytes. */
struct gp_exr_attr {
    const char *name, *type;
    const uint8_t *data; // `size` bytes, little-endian, not aligned
    uint32_t size;
};

struct gp_exr_index {
    uint8_t *bytes;   // of the file, from its start to the offset tables
    bool multi, flat; // several parts; one that is not deep
    uint64_t type;    // first byte of the attribute "type" of a flat file; or 0
    uint64_t tables;  // first byte of the offset tables, after the header; 0:
                      // it is damaged
    uint64_t *offset; // the tables of all parts, `chunks` entries
    uint64_t chunks;
    int parts;
    struct gp_exr_attr *attr; // of all parts
    int attrs;
};

/* The attribute of that name and type, or NULL; a `part` that is NULL has
 * none. */
const struct gp_exr_attr *gp_exr_attr_find(const struct gp_exr_part *part,
                                           const char *name, const char *type);

/* Flags of the version field, openexr file layout, "Version Field". */
enum {
    GP_EXR_MAGIC = 20000630,
    GP_EXR_VERSION = 2,
    GP_EXR_LONG_NAMES = 0x400,
    GP_EXR_DEEP = 0x800,
    GP_EXR_MULTIPART = 0x1000,
};

/* -- chunks as bytes (open.c) --------------------------------------------- */

/* Bytes of the chunk at `offset`, leader included; offset and bytes together
 * are more than the file has where it is truncated. 0 when no chunk of that
 * part begins there, or a read failed. */
uint64_t gp_exr_chunk_bytes(const struct gp_input *in, int part,
                            uint64_t offset);

/* -- choice of part and channels (choose.c) ------------------------------- */

/* The channel's name without its view, into `to`, which has room for it: its
 * own name in parts of one view. False when it belongs to another view.
 * Channels of no view go with the default view. */
bool gp_exr_bare_name(const struct gp_input *in, int part, const char *view,
                      const char *name, char *to);

/* Finds in->crypto by the attributes of all parts. */
void gp_exr_find_crypto(struct gp_input *in);

/* Returns what a channel of a part holds: by its own layer, or by the part's
 * name when it has none. Without an input only its name says so. */
enum gp_crypto_kind gp_exr_crypto_channel(const struct gp_input *in, int part,
                                          const char *name);

struct gp_exr_choice {
    int part;
    struct gp_colour_choice colour; // indices of the part's channels
};

/* Chooses by p->layer, p->part and p->view, as read.h says.
 *
 *   first  the part that is searched first
 *   out    may be a deep part, where no other has the colour; one without
 *          colour is refused by gp_exr_chunks_find()
 *
 * Errors: GP_ERR_DATA no colour channel; GP_ERR_USAGE as in gp_read_frame(). */
GP_MUST_CHECK gp_status gp_exr_choose(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const struct gp_input *in, int first,
                                      struct gp_exr_choice *out);

/* -- luminance-chroma images to RGB (luma_chroma.c) ------------------------
 *
 * A file may hold luminance Y = wr R + wg G + wb B at full resolution and the
 * chroma differences RY = (R - Y) / Y and BY = (B - Y) / Y at every second
 * column of every second row. Getting RGB back: missing chroma by a windowed
 * sinc of 27 taps, first in rows, then in columns; YC to RGB; then colours
 * more saturated than their neighbours, which the filter's ringing makes,
 * are pulled back.
 * Source: OpenEXR, ImfRgbaYca.cpp and class RgbaInputFile::FromYca of
 * ImfRgbaFile.cpp, whose results these equal bit by bit for half files. */

struct gp_yc {
    int w, h;        // of the picture, both even when xs or ys is 2
    int xs, ys;      // sampling of both chroma planes: 1, 1 or 2, 2
    const float *y;  // w * h
    const float *ry; // (w / xs) * (h / ys)
    const float *by; // the same
    float weight[3]; // of R, G, B in Y; from gp_yc_weights()
    bool half;       // round every step to half, as OpenEXR does; for files
                     // whose planes are all half
};

/* The weights of R, G, B in Y for these primaries, in OpenEXR's own single
 * precision (RgbaYca::computeYw, ImfChromaticities.cpp). Degenerate primaries
 * give those of BT.709.
 *   chromaticities  rx ry gx gy bx by wx wy */
void gp_yc_weights(const float chromaticities[8], float weight[3]);

/* Fills out->c[0..2], w * h each; they may not overlap the inputs. */
GP_MUST_CHECK gp_status gp_yc_to_rgb(const struct gp_log *log,
    const struct gp_yc *in, struct gp_planes *out);

/* -- pixels to the chunks of a scanline part (encode.c) ------------------- */

/* One channel of the part: samples of its grid (frame.h), either a colour
 * plane or samples of the file's own type. */
struct gp_exr_source {
    const char *name;        // borrowed
    enum gp_pixel_type type; // as written
    int xs, ys;              // subsampling, >= 1
    bool linear;             // EXR's pLinear
    int columns;             // samples in a row
    const float *plane;      // columns * rows floats, made half where the
                             // type says so; xs = ys = 1; or NULL
    const void *data;        // samples of `type`, when plane is NULL
};

struct gp_exr_image {
    struct gp_rect data;
    enum gp_compression compression;    // not AUTO
    float quality; // of DWAA and DWAB: OpenEXR's default is 45
    struct gp_exr_source *source; // sorted by name as strcmp() does
    int sources;
};

/* Chunks of a part with that compression. */
int gp_exr_chunk_count(const struct gp_exr_image *img);

/* -- a file on its way out --------------------------------------------------
 *
 * Begin(), attributes by put...() (header.c); tables(), chunks of all parts,
 * end() (encode.c). */

struct gp_exr_out {
    const struct gp_log *log;
    struct gp_file *file; // borrowed
    uint32_t flags;       // of the version field
    uint64_t tables;      // their first byte in the file
    uint64_t *offset;     // of the chunks of all parts, `chunks` of them
    size_t *first;        // the first of each part among these, and `chunks`
    size_t chunks;
};

/* The attributes of the input that a part gets. */
enum gp_exr_kept {
    GP_EXR_KEEP_ALL,       // --hdr: the frame as it was, with glare
    GP_EXR_KEEP_CONVERTED, // the same in another colour space
    GP_EXR_KEEP_SCENE,     // another picture in the frame's own light
    GP_EXR_KEEP_SHOWN,     // a display-referred one
};

/* Free with gp_exr_out_free(). */
void gp_exr_out_begin(struct gp_exr_out *out, const struct gp_log *log,
                      struct gp_file *file, uint32_t flags);

/* One attribute, or bytes as they are: another part's header. */
void gp_exr_put(struct gp_exr_out *out, const char *name, const char *type,
                const void *data, size_t size);
void gp_exr_put_raw(struct gp_exr_out *out, const void *bytes, size_t size);

/* All attributes of the scanline part that holds the colour, and its end.
 *
 *   own     of the input; NULL when that was not EXR
 *   p       command and, when GP_EXR_KEEP_CONVERTED, primaries are used
 *   chunks  of the part in a multi-part file, where name, type and number of
 *           chunks are required; 0 in files of one part */
void gp_exr_put_part(struct gp_exr_out *out, const struct gp_frame *f,
                     const struct gp_exr_image *img,
                     const struct gp_exr_part *own, enum gp_exr_kept kept,
                     const struct gp_write_params *p, int chunks);

/* Ends the header, and makes room for the tables of each part's chunks. */
GP_MUST_CHECK gp_status gp_exr_out_tables(struct gp_exr_out *out,
    const int *chunks, int parts);

/* Compresses all chunks, in parallel, and appends them to part `part` in order.
 * Values that did not fit are added to *clamped.
 * Errors: GP_ERR_USAGE it cannot hold these channels; GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_exr_encode(struct gp_exr_out *out, int part,
    const struct gp_exr_image *img, long long *clamped);

/* Copies all chunks of part `from` of another file, flat or deep and of all
 * levels, in the order in which they are in it.
 * Errors: GP_ERR_DATA a chunk is missing or reaches out of the file; GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_exr_out_copy(struct gp_exr_out *out, int part,
                                        const struct gp_input *in, int from);

/* Fills in the offset tables. */
GP_MUST_CHECK gp_status gp_exr_out_end(struct gp_exr_out *out);
void gp_exr_out_free(struct gp_exr_out *out);

#endif
