// SPDX-License-Identifier: Apache-2.0
/* Pictures out. */
#ifndef GP_IO_WRITE_H
#define GP_IO_WRITE_H

#include "io/frame.h"
#include "core/status.h"

#include <stdbool.h>

/* Values of --type; AUTO keeps the input's type, but is float for a frame with
 * a value over 65504. */
enum gp_out_type { GP_OUT_AUTO, GP_OUT_HALF, GP_OUT_FLOAT };

/* Values of --compression, in OpenEXR's numbering; AUTO keeps an EXR input's
 * own when it is lossless and is zip else. */
enum gp_compression {
    GP_COMPRESSION_AUTO = -1,
    GP_COMPRESSION_NONE = 0,
    GP_COMPRESSION_RLE,
    GP_COMPRESSION_ZIPS,
    GP_COMPRESSION_ZIP,
    GP_COMPRESSION_PIZ,
    GP_COMPRESSION_PXR24,
    GP_COMPRESSION_B44,
    GP_COMPRESSION_B44A,
    GP_COMPRESSION_DWAA,
    GP_COMPRESSION_DWAB,
};

/* Values of --stdout-format, formats of an output without an ending: a name,
 * its ending, and a line for the man page, or NULL where the ending suffices. */
#define GP_STDOUT_LIST(X)                                                     \
    X(EXR, "exr", "OpenEXR; the only one for --hdr")                          \
    X(PNG, "png", NULL)                                                       \
    X(PFM, "pfm", "portable float map: floats as they are")                   \
    X(RAW, "raw", "pixels without a header, top left first, for "             \
      "ffmpeg -f rawvideo; all frames must have one size")
enum gp_stdout_format {
#define X(name, ending, text) GP_STDOUT_##name,
    GP_STDOUT_LIST(X)
#undef X
};

/* Values of --raw, ffmpeg's names of these pixel formats. */
enum gp_raw_format {
    GP_RAW_RGB24,
    GP_RAW_RGB48LE,
    GP_RAW_RGB48BE,
    GP_RAW_RGBF32LE,
};

/* Dither before rounding to integers, against banding of faint glows.
 *   8_BITS  pictures of 8 bits only, whose steps show
 *   ALWAYS  those of 16 bits too */
enum gp_dither { GP_DITHER_8_BITS, GP_DITHER_ALWAYS, GP_DITHER_NEVER };

/* Values of --alpha, and ASSOCIATED, into which writers of integers turn KEEP
 * in formats whose readers take alpha as associated. */
enum gp_alpha { GP_ALPHA_BLACK, GP_ALPHA_KEEP, GP_ALPHA_ASSOCIATED };

enum { GP_PNG_LEVELS = 12 };

struct gp_write_params {
    enum gp_out_type type;
    enum gp_compression compression;
    int depth_bits;             // PNG and other integer formats: 8 or 16
    int png_level; // of libdeflate: 0 none, 1 fast to GP_PNG_LEVELS
    enum gp_dither dither;
    enum gp_alpha alpha;        // pictures: over black, or keep A
    enum gp_stdout_format stdout_format;
    enum gp_raw_format raw;     // with GP_STDOUT_RAW
    bool no_clobber, create_dir;
    bool fsync; // as gp_file_open() syncs
    bool pages; // gp_write_check() lets names in .html pass: the
                // caller writes these
    bool converted;             // --hdr: not in the input's primaries any more
    const float *primaries;     // of what is converted, as in struct gp_frame;
                                // NULL: not known
    unsigned char cicp[2];      // of GP_PICTURE_ENCODED: ITU-T H.273
                                // ColourPrimaries, TransferCharacteristics;
                                // 0, 0 not known
    const char *command;        // for glarepp:command of EXR and PNG, UTF-8;
                                // NULL: they do not say what made them
    const char *output;         // for glarepp:output beside it: the option that
                                // names the file; NULL: none
    const struct gp_attribute *added; // `n_added` texts for EXR files
    int n_added;
};
#define GP_WRITE_DEFAULTS                                        \
    {                                                            \
        .type = GP_OUT_AUTO, .compression = GP_COMPRESSION_AUTO, \
        .depth_bits = 8, .png_level = 1                          \
    }

/* Pixels of a raw frame. */
struct gp_raw_size {
    int w, h;
};

/* Results of writing. */
struct gp_write_stats {
    long long clamped; // values that did not fit the file's type, added up
    double flux_clamped[3]; // light that this cost, by channel, added up
    struct gp_raw_size raw; // of all raw frames so far; keep between frames
};

/* Kinds of values in the planes of a picture. */
enum gp_picture_kind {
    GP_PICTURE_SCENE,    // scene-linear, in the frame's own primaries
    GP_PICTURE_SHOWN,    // display-linear BT.709; the file says so
    GP_PICTURE_ENCODED,  // as some display takes it: gp_write_params.cicp
};

/* Writes `planes` (w * h of f's data window) with the frame's windows,
 * chromaticities and attributes, as a picture of three channels; with
 * GP_ALPHA_KEEP alpha is a fourth in the formats of gp_write_has_alpha(). The
 * ending of `path` picks the format: .exr, .png and .pfm are written here, those
 * of oiio.h by the program glarepp-oiio; "-" (stdout), pipes and devices
 * without an ending get what p->stdout_format says, which may be raw pixels.
 * Stdout may be given many frames, one after the other.
 *
 * EXR and other float formats store the values as they are; an EXR of halfs
 * scales a pixel over 65504 until it fits, which keeps its hue (of DWA 57344),
 * and warns when that takes over 1 % of a channel's light. Radiance HDR stores
 * the nearest that its pixels hold; integer formats clamp them to [0,1], encode
 * them with the sRGB curve and tag them as sRGB.
 * Values of GP_PICTURE_ENCODED are fractions of the largest code already; only
 * PNG tags their encoding, with cICP. All but EXR show the display
 * window: pixels outside the data window are black. TIFF is float for
 * scene-linear pictures and where p->type says so. p->compression is for EXR
 * and TIFF.
 *
 * With p->command EXR and PNG have it as glarepp:command, and the program's
 * version as glarepp:version: string attributes, or text chunks. Those of the
 * input are never carried.
 *
 * Errors: GP_ERR_IO with the system's reason; GP_ERR_USAGE unknown ending,
 * or a compression that the format lacks. */
GP_MUST_CHECK gp_status gp_write_picture(const struct gp_log *log,
    const struct gp_write_params *p, const char *path, const struct gp_frame *f,
    const struct gp_planes *planes, enum gp_picture_kind kind,
    struct gp_write_stats *stats);

/* A picture to write, as the writers of formats take it. */
struct gp_picture_job {
    const struct gp_log *log;
    const struct gp_write_params *p;
    const char *path;
    const struct gp_frame *f;
    const struct gp_planes *planes;
    enum gp_picture_kind kind;
    struct gp_write_stats *stats;
};

/* A frame, and the new planes of its colour channels (w * h of its data), both
 * borrowed. */
struct gp_hdr_colour {
    const struct gp_frame *f;
    struct gp_planes planes;
};

/* Writes an EXR in which the colour channels of each frame hold its planes and
 * every other channel, attribute and part of the input passes through.
 * gp_write_hdr_check() has passed `path`. Luminance-chroma and grey inputs: grey
 * stays one channel when the planes are equal, else R,G,B take its place. With
 * p->converted the attributes of the input's primaries and of how to show them
 * are left out, and chromaticities are p->primaries.
 *
 *   set  n >= 1 frames of one file, from gp_read_frame() or gp_read_layer();
 *        set[0].f's path and input are the input. Several may lie in one
 *        part, of which one then was read whole, as gp_read_frame() does
 *
 * Errors: those of gp_write_picture(); GP_ERR_USAGE a channel is the colour of
 * two frames, or p->compression is lossy and would change Cryptomatte's ids;
 * GP_ERR_DATA an added colour channel's name is taken. */
GP_MUST_CHECK gp_status gp_write_hdr(const struct gp_log *log,
    const struct gp_write_params *p, const char *path,
    const struct gp_hdr_colour *set, int n, struct gp_write_stats *stats);

/* Makes *out, three planes of `n` samples, from `in`. */
typedef gp_status gp_convert(const struct gp_log *log, void *user,
                             const struct gp_frame *f, size_t n,
                             const struct gp_planes *in, struct gp_planes *out);

/* Converts, in place, the layers of light that a frame carries beside its
 * colour, for gp_write_hdr() with p->converted: LAYER.R,G,B or words, also
 * without a layer. Layers that are not light by their names (gp_is_light()),
 * Cryptomatte's and integers stay as they are; so do subsampled ones and those of
 * luminance and chroma, and one line names these. GP_LEVEL_INFO names the
 * layers that are converted.
 *   stats  values that do not fit the channel's type are added to `clamped`
 * Errors: GP_ERR_BUG out of memory; those of `convert`. */
GP_MUST_CHECK gp_status gp_convert_layers(const struct gp_log *log,
    gp_convert *convert, void *user, struct gp_frame *f,
    struct gp_write_stats *stats);

/* Writes `n` layers of light of a frame's size into one EXR, part[i] as NAME.R,
 * NAME.G, NAME.B of name[i], no two the same. gp_write_hdr_check() has passed
 * `path`. Errors: those of gp_write_picture(). */
#define GP_PARTS_KEEP "--parts writes layers"
GP_MUST_CHECK gp_status gp_write_parts(
    const struct gp_log *log, const struct gp_write_params *p, const char *path,
    const struct gp_frame *f, const char *const *name,
    const struct gp_planes *part, int n, struct gp_write_stats *stats);

/* True when scene-linear light under that name is 32-bit floats, of a frame whose
 * colour is `own`. */
bool gp_write_has_floats(const struct gp_write_params *p, const char *path,
                         enum gp_pixel_type own);

/* gp_write_check() for outputs that only EXR can hold, as of gp_write_hdr();
 * `keeps` is the option and what it keeps, for messages. */
#define GP_HDR_KEEPS "--hdr keeps all channels"
GP_MUST_CHECK gp_status gp_write_hdr_check(const struct gp_log *log,
    const struct gp_write_params *p, const char *keeps, const char *path);

/* True when a picture under that name can have alpha (GP_ALPHA_KEEP); in other
 * formats it is over black. */
bool gp_write_has_alpha(const struct gp_write_params *p, const char *path);

/* True when no_clobber is set and a regular file of that name exists, with its
 * end (gp_read_has_end()). Warns of one that has it not. */
bool gp_write_kept(const struct gp_log *log, const struct gp_write_params *p,
                   const char *path);

/* Checks before any frame is read that `path` could be written. Same errors. */
GP_MUST_CHECK gp_status gp_write_check(const struct gp_log *log,
    const struct gp_write_params *p, const char *path);

/* Packs `n` bytes as zlib does, RFC 1950.
 *   level  1, fast, to 12, small
 *   out    gp_free(); `size` bytes */
GP_MUST_CHECK gp_status gp_zlib_pack(const struct gp_log *log, const void *from,
                                     size_t n, int level, void **out,
                                     size_t *size);

#endif
