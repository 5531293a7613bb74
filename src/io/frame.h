// SPDX-License-Identifier: Apache-2.0
/* A frame of a file: its picture, and all else that the file holds and that
 * outputs carry on. */
#ifndef GP_IO_FRAME_H
#define GP_IO_FRAME_H

#include "core/image.h"
#include "glarepp.h"

/* One channel of the part that holds the colour, in the file's order.
 *
 * A channel either is a colour plane (`colour` 0, 1, 2 for rgb.c[colour];
 * `data` NULL) or is carried as it is in the file (`colour` -1, `data` has
 * the samples in native byte order and the file's own type).
 * Its grid: columns where x % xs == 0 and rows where y % ys == 0 within the
 * data window, as in OpenEXR; `w` x `h` samples, rows without padding. */
struct gp_channel {
    char *name;
    enum gp_pixel_type type;
    int xs, ys;   // subsampling, >= 1
    int w, h;     // samples of this channel's grid
    bool linear;  // EXR's pLinear
    int colour;   // 0..2, or -1
    void *data;   // owned; NULL for colour
};

/* The channels that rgb was made from. */
enum gp_colour_model {
    GP_COLOUR_RGB,   // three channels R, G, B (or red, green, blue)
    GP_COLOUR_GREY,  // one channel, the same in all three planes
    GP_COLOUR_YC,    // luminance-chroma: Y, RY, BY
};

/* An attribute of a file that is not EXR, for the EXR made from it. An EXR's
 * own attributes stay in its header. */
struct gp_attribute {
    char *name;
    enum { GP_ATTRIBUTE_TEXT, GP_ATTRIBUTE_INT, GP_ATTRIBUTE_FLOAT } kind;
    char *text;   // TEXT; else NULL
    int number;   // INT
    float real;   // FLOAT
};

struct gp_frame {
    char *path;                    // for messages; "-" is stdin
    struct gp_rect data, display;  // windows in EXR pixel space
    struct gp_rect read;           // data window of the file, of a frame that
                                   // has grown (io/grow.h); empty: `data`
    float pixel_aspect;
    float chromaticities[8];       // rx ry gx gy bx by wx wy
    bool names_chromaticities;     // set in the file; else BT.709's
    float luminance[3];            // Y = sum luminance[c] * rgb[c]
    enum gp_colour_model model;
    enum gp_pixel_type colour_type;  // GP_HALF or GP_FLOAT, as in the file
    int part;                      // index of the part that holds the colour
    int parts;

    struct gp_planes rgb;

    struct gp_channel *channel;  // all channels of the part, file order
    int channels;

    struct gp_attribute *attribute;  // owned, names and texts too; not of EXR
    int attributes;

    void *input;                    // private to io: an EXR's header, parts
    void (*input_free)(void *input);
};

static inline int gp_frame_w(const struct gp_frame *f)
{
    return gp_rect_w(f->data);
}

static inline int gp_frame_h(const struct gp_frame *f)
{
    return gp_rect_h(f->data);
}

/* The pixels that the file has. */
static inline struct gp_rect gp_frame_read(const struct gp_frame *f)
{
    return gp_rect_empty(f->read) ? f->data : f->read;
}

static inline size_t gp_frame_pixels(const struct gp_frame *f)
{
    return gp_rect_pixels(f->data);
}

/* Returns a frame of that window without pixels: floats, square, in Rec.709,
 * of one part. */
struct gp_frame gp_frame_blank(struct gp_rect window);

/* Frees all that the frame owns and clears it; an empty frame is fine. */
void gp_frame_free(struct gp_frame *f);

/* Gives a frame of that window its path, room for n channels and planes.
 * On failure f may only be freed. */
GP_MUST_CHECK gp_status gp_frame_make(const struct gp_log *log,
                                      const char *path, int n,
                                      struct gp_frame *f);

/* Adds a channel to those that there is room for: a copy of `like` with samples
 * of its own where it is no colour. A colour that is no half makes colour_type
 * GP_FLOAT. */
GP_MUST_CHECK gp_status gp_frame_add(const struct gp_log *log,
                                     struct gp_frame *f,
                                     const struct gp_channel *like);

/* Fills the planes of colours without a channel (index -1): grey's first, else
 * black. */
void gp_frame_fill(struct gp_frame *f, const int index[3]);

/* The channel of that exact name, or NULL. */
const struct gp_channel *gp_frame_channel(const struct gp_frame *f,
                                          const char *name);

/* The first channel of the colour, or NULL. */
const char *gp_frame_colour(const struct gp_frame *f);

/* -- attributes of an EXR ------------------------------------------------- */

/* Reads `n` numbers of an attribute of the frame's colour part, else of the
 * first part that has it: 1 of a float or a rational number, 2 of a v2f, 16 of
 * a matrix (m44f or m44d), v[4 * row + column], row vectors, as stored. False,
 * with v as it was, where there is none or, but for a matrix, it is not finite.
 */
bool gp_frame_numbers(const struct gp_frame *f, const char *name, int n,
                      double *v);

/* A string attribute of the frame's colour part, from gp_alloc(); NULL where
 * there is none, or memory is full. */
char *gp_frame_text(const struct gp_frame *f, const char *name);

/* Returns a view of planes of a frame for the library, as its file describes
 * them. It lives no longer than they. */
struct glarepp_image gp_frame_view(const struct gp_frame *f,
                                   const struct gp_planes *planes);

#endif
