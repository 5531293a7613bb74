// SPDX-License-Identifier: Apache-2.0
/* io: files in and out. The only room that knows file formats.
 *
 * In: a path (or "-", stdin) becomes a gp_frame. Out: planes of a frame become
 * a file under its final name, whole or not at all. */
#ifndef GP_IO_READ_H
#define GP_IO_READ_H

#include "io/decoded.h"
#include "io/frame.h"
#include "core/status.h"
#include "io/sequence.h"
#include "io/stream.h"

#include <stdbool.h>
#include <stddef.h>

struct gp_read_params {
    /* A data window of more pixels is refused, and so is a frame's display
     * window: pictures show it. Planes and what is compared need none. >= 1 */
    long long max_pixels;
    // choose the frame in the file, by name; NULL: the first that fits
    const char *layer;     // EXR layer of its colour
    const char *part;      // number from 0, or name
    const char *view;      // eye of a stereo file
};
#define GP_READ_DEFAULTS { .max_pixels = 1LL << 28 }

/* The limits of `p` for another file than the frame. */
static inline struct gp_read_params gp_read_limits(
    const struct gp_read_params *p)
{
    return (struct gp_read_params) {.max_pixels = p->max_pixels};
}

/* The part, layer and view of a frame, as gp_read_params takes them; "" where
 * the file has only one, or it has no name. */
struct gp_taken {
    char part[256], layer[256], view[256];
};
void gp_read_taken(const struct gp_frame *f, struct gp_taken *out);

/* Reads a frame: EXR by OpenEXRCore, PNG by libpng, PFM here, others by the
 * program glarepp-oiio, chosen by the first bytes, never by the name.
 *
 *   path  file, or "-" for stdin (read to its end, like any pipe; refused by
 *         its first bytes when no format begins so)
 *   out   written only on GP_OK: windows, chromaticities and luminance,
 *         rgb, channels, input; other planes empty. Free: gp_frame_free().
 *
 * Colour is, in this order: R,G,B; red,green,blue of any case; Y with RY or
 * BY; Y; LAYER.R,G,B of a layer called Combined, beauty or rgba, or else of
 * the first layer in file order; the only channel there is. Layers and parts
 * that are no light by their names (gp_is_light()) are passed over, and for a
 * lone channel coverage, depth (Z, as gp_find_depth() has it), numbers of
 * objects and all whole numbers too. The first part of a multi-part file
 * that has one of these (a lone channel last) is the frame; the other parts
 * pass through to gp_write_hdr(). Missing colour channels of a set of three
 * are 0. `colour` of a grey file's channel is 0; RY, Y, BY have 0, 1, 2, and
 * rgb holds the RGB that OpenEXR's RgbaInputFile would give. Cryptomatte's ids
 * are never colour.
 *
 * With p->layer colour is LAYER.R,G,B (or words, or LAYER.Y, with or without
 * chroma), or R,G,B of a part that is called LAYER; failing these, the channel
 * LAYER as grey. p->view leaves the parts whose view attribute is that view,
 * and of a part with a multiView attribute the channels of that view, whose
 * name comes before the channel's own (right.R, diffuse.right.R; none for the
 * first view). A layer may also name its view: right.diffuse or diffuse.right.
 * p->part leaves one part. Part names may end with their view (rgba.left,
 * rgba_left). Other formats have layers by the channel names of OpenImageIO,
 * parts by number (its subimages), and no views.
 *
 * EXR's values are as stored: NaN and Inf are the sensors' business. Integers
 * of other formats are made linear by the curve that the file names, 8-bit
 * ones without a name by sRGB's.
 *
 * Errors: GP_ERR_IO cannot open or read, is a folder; GP_ERR_DATA empty,
 * truncated, damaged, deep, over max_pixels, or no colour channel;
 * GP_ERR_USAGE the file has no such layer, part or view (the line lists what
 * it has), or the layer is Cryptomatte's. */
GP_MUST_CHECK gp_status gp_read_frame(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_frame *out);

/* True for a regular file of a format that is read, with its end: an EXR's offset
 * tables and last chunk, a PNG's IEND, a PFM's last row; of other formats any
 * content. True also for one that cannot be opened: nobody knows. */
bool gp_read_has_end(const char *path);

/* Another layer of the EXR that `f`, whose rgb may have changed since, was read
 * from.
 *
 *   p      p->view narrows, else f's own view comes first; p->layer and
 *          p->part do not count
 *   layer  as p->layer there; NULL is the colour of p->view
 *   out    written only on GP_OK: a layer of f's part has its colour channels
 *          only, one of another part all channels of that part, as
 *          gp_write_hdr() needs them. Its input is f's, so free it before f
 *
 * Errors: those of gp_read_frame(); GP_ERR_DATA the layer's data window is not
 * f's; GP_ERR_USAGE f is not from an EXR. */
GP_MUST_CHECK gp_status gp_read_layer(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f, const char *layer,
    struct gp_frame *out);

/* -- views of a file ------------------------------------------------------- */

/* Lists the views that an EXR names and that hold the colour which `p` asks
 * for; p->view does not count. First comes the view that gp_read_frame() takes
 * without p->view, then the others in the order of the file. None of a file
 * that names fewer than two, and of other formats. Free with gp_views_free().
 *   m  where it has images, the first of them is read in place of a file
 * Errors: those of gp_read_frame() for a file that cannot be opened. */
struct gp_members;
GP_MUST_CHECK gp_status gp_read_views(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path,
                                      const struct gp_members *m,
                                      struct gp_views *out);

/* The same of a frame that was read. */
GP_MUST_CHECK gp_status gp_frame_views(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_frame *f,
    struct gp_views *out);

/* -- several images in one stream ------------------------------------------
 *
 * One after the other, as `cat a.exr b.exr` makes them. */

/* The place of one image in the stream. */
struct gp_member {
    uint64_t at, size; // bytes
};

struct gp_members {
    struct gp_stream stream;  // owned: all bytes
    struct gp_member *member; // owned; in the stream's order
    int n;
};

/* Reads a pipe, "-" or another, to its end, of 16 bytes for each of max_pixels
 * and 64 MiB at most, and finds its images.
 *
 * EXR declares its end by its offset tables, PNG by IEND, PFM by its header; an
 * image of any other format must be the only one. An image whose end is unknown
 * (damaged, truncated) reaches to the end of the stream, so that its reader
 * reports the damage. Zero bytes after an image are padding.
 *
 *   out   written only on GP_OK; outlives the frames read from it
 *
 * Errors: those of gp_read_frame(); GP_ERR_DATA bytes after an image that
 * begin no EXR, PNG or PFM. */
GP_MUST_CHECK gp_status gp_members_read(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_members *out);
/* Frees what it owns and clears it; an empty or all-zero one is fine. */
void gp_members_free(struct gp_members *m);

/* gp_read_frame() for image `i`, called `name`. The frame borrows the stream's
 * bytes; several threads may read at once. */
GP_MUST_CHECK gp_status gp_members_frame(const struct gp_log *log,
    const struct gp_read_params *p, const char *name,
    const struct gp_members *m, int i, struct gp_frame *out);

/* -- versions -------------------------------------------------------------- */

/* Writes "OpenEXRCore 3.1.5, libpng 1.6.39, ..." into `line`: the versions that
 * this process runs with where the library has a call for it. */
void gp_io_versions(char *line, size_t size);

// -- the alpha of a picture ---------------------------------------------------

/* Alpha of a picture: w * h codes in rows from the top. */
struct gp_coverage {
    int w, h;
    uint16_t *code; // of GP_COVERED; owned
};
enum { GP_COVERED = 65535 };

/* Reads the alpha of a picture of any format, an EXR by glarepp-oiio; samples
 * are clamped to [0, 1], NaN is 0.
 *
 *   bytes  the file's, n of them; NULL: `path` is opened, a regular file
 *   most   pixels; over it is refused
 *   out    written on GP_OK only; gp_free() its codes. Of a picture without
 *          alpha one pixel of GP_COVERED
 *
 * Errors: those of gp_read_frame(). */
GP_MUST_CHECK gp_status gp_read_coverage(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, const void *bytes,
    size_t n, long long most, struct gp_coverage *out);

// -- every channel with its values as stored, for comparing ------------------

/* One part at full resolution; subsampled channels are repeated. Half and float
 * samples are as stored, integers of other formats are divided by their largest
 * code, without a curve. */
struct gp_stored_image {
    struct gp_rect data, display;   // EXR pixel space
    struct glarepp_channel *channel; // owned, names and values too; in the
                                     // file's order
    int channels;
    int64_t *first;     // of deep data: the samples of pixel i are
                        // v[first[i]] to before v[first[i + 1]]; else NULL
    bool integers;      // display-referred: stored as integers, not EXR
    /* Linear colour of the data window: the channels that gp_read_frame()
     * would take (of luminance-chroma the luminance in all three), integers
     * made linear by the curve that their file names. Borrowed from the
     * channels or from `own`; NULL where there is no colour, or one of the
     * three is missing. */
    const float *light[3];
    struct gp_planes own;
    float chromaticities[8], luminance[3]; // as in struct gp_image
};

struct gp_input;

/* An open file. */
struct gp_stored_file {
    const char *path;         // borrowed
    struct gp_input *input;   // of an EXR, else NULL
    struct gp_stream stream;  // of other formats
    struct gp_decoded first;  // part 0 of other formats
    int parts;
};

/* Opens a file or stdin ("-") of any format. Close it in any case.
 * Errors: as gp_read_frame(). */
GP_MUST_CHECK gp_status gp_stored_open(const struct gp_log *log,
    const struct gp_read_params *p, const char *path, struct gp_stored_file *f);
void gp_stored_close(struct gp_stored_file *f);

/* Reads part `part` of [0, f->parts), deep ones too; `out` is written only on
 * GP_OK. Errors: as gp_read_frame(); more samples than p->max_pixels. */
GP_MUST_CHECK gp_status gp_stored_read(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_stored_file *f, int part,
    struct gp_stored_image *out);
void gp_stored_image_free(struct gp_stored_image *image);

/* Reads the first deep part that has A: of a file, or with path NULL of a frame's, of
 * its colour's view; *found false: it has none. Errors: as gp_stored_read(); GP_ERR_DATA
 * the file has none. */
GP_MUST_CHECK gp_status gp_read_deep(const struct gp_log *log,
                                     const struct gp_read_params *p,
                                     const struct gp_frame *f, const char *path,
                                     struct gp_stored_image *out, bool *found);

#endif
