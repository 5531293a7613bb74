/* io: files in and out. The only room that knows file formats.
 *
 * In: a path (or "-", stdin) becomes a gp_frame. Out: planes of a frame become
 * a file under its final name, whole or not at all.
 */
#ifndef GP_IO_READ_H
#define GP_IO_READ_H

#include "core/frame.h"
#include "core/status.h"

struct gp_read_params {
    /* A data window of more pixels is refused, and so is a frame's display
     * window: pictures show it. Planes and what is compared need none. >= 1 */
    long long max_pixels;
    // what of the file is the frame, by name; NULL: the first that fits
    const char *layer;     // its colour
    const char *part;      // where it is looked for: number from 0, or name
    const char *view;      // of a stereo file
};
#define GP_READ_DEFAULTS { .max_pixels = 1LL << 28 }

/* The limits of `p` for another file than the frame: without layer, part and
 * view, which the frame's files alone have. */
static inline struct gp_read_params gp_read_limits(
    const struct gp_read_params *p)
{
    return (struct gp_read_params) {.max_pixels = p->max_pixels};
}

/* Reads a frame: EXR by OpenEXRCore, any other format by the OpenImageIO
 * bridge, told apart by the first bytes, never by the name.
 *
 *   path  file, or "-" for stdin (read to its end, like any pipe; refused by
 *         its first bytes when no format begins so)
 *   out   written only on GP_OK: windows, chromaticities and luminance,
 *         rgb, channels, input; other planes empty. Free: gp_frame_free().
 *
 * Colour is, in this order: R,G,B; red,green,blue of any case; Y with RY or
 * BY; Y; LAYER.R,G,B of a layer called Combined, beauty or rgba, or else of
 * the first layer in file order; the only channel there is, alpha aside. The
 * first part of a multi-part file that has one of these (a lone channel
 * last, which is more likely depth) is the frame; the other parts pass
 * through to gp_write_hdr(). Missing colour channels of a set of three are 0.
 * `colour` of a grey file's channel is 0; RY, Y, BY have 0, 1, 2, and rgb
 * holds the RGB that OpenEXR's RgbaInputFile would give. Cryptomatte's ids
 * (crypto.h) are no colour under any name.
 *
 * With p->layer colour is LAYER.R,G,B (or words, or LAYER.Y, with or without
 * chroma), or R,G,B of a part that is called LAYER; failing these, the channel
 * LAYER as grey. p->view leaves the parts whose view attribute is that view,
 * and of a part with a multiView attribute the channels of that view, whose
 * name stands before the channel's own (right.R, diffuse.right.R; none for the
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
 * truncated, damaged, deep, over max_pixels, or no colour channel; GP_ERR_USAGE the
 * file has no such layer, part or view (the line lists what it has), or the
 * layer is Cryptomatte's.
 */
GP_MUST_CHECK gp_status gp_read_frame(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const char *path, struct gp_frame *out);

/* Another layer of the file that `f` was read from, without reading the file
 * again: what lies in f's part comes from f's channels, the rest is decoded
 * from f's input.
 *
 *   p      p->view narrows, else f's own view comes first; p->layer and
 *          p->part do not count
 *   f      read by gp_read_frame() or its like from an EXR; its rgb may have
 *          changed since
 *   layer  as p->layer there; NULL is the colour of p->view
 *   out    written only on GP_OK: windows, chromaticities, rgb and channels.
 *          A layer of f's part has its colour channels only; one of another
 *          part has all channels of that part, as gp_write_hdr() needs them.
 *          input is f's, so free it before f
 *
 * Errors: those of gp_read_frame(); GP_ERR_DATA the layer's data window is not
 * f's; GP_ERR_USAGE f is not from an EXR.
 */
GP_MUST_CHECK gp_status gp_read_layer(const struct gp_log *log,
                                      const struct gp_read_params *p,
                                      const struct gp_frame *f,
                                      const char *layer, struct gp_frame *out);

#endif
