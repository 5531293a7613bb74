/* The frame that flows through the program, and its planes.
 *
 * Each plane has one writer, named beside it. A stage reads what earlier
 * stages wrote and never writes there. */
#ifndef GP_CORE_FRAME_H
#define GP_CORE_FRAME_H

#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Half-open pixel rectangle: x in [x0, x1), y in [y0, y1); x right, y down.
 * Empty when x1 <= x0 or y1 <= y0. */
struct gp_rect {
    int x0, y0, x1, y1;
};

static inline int gp_rect_w(struct gp_rect r)
{
    return r.x1 > r.x0 ? r.x1 - r.x0 : 0;
}

static inline int gp_rect_h(struct gp_rect r)
{
    return r.y1 > r.y0 ? r.y1 - r.y0 : 0;
}

/* Returns the middle of a window on axis k, 0 x or 1 y. */
static inline double gp_rect_middle(struct gp_rect r, int k)
{
    return k == 0 ? 0.5 * ((double) r.x0 + (double) r.x1)
                  : 0.5 * ((double) r.y0 + (double) r.y1);
}

static inline bool gp_rect_empty(struct gp_rect r)
{
    return r.x1 <= r.x0 || r.y1 <= r.y0;
}

static inline struct gp_rect gp_rect_meet(struct gp_rect a, struct gp_rect b)
{
    return (struct gp_rect) {
        a.x0 > b.x0 ? a.x0 : b.x0, a.y0 > b.y0 ? a.y0 : b.y0,
        a.x1 < b.x1 ? a.x1 : b.x1, a.y1 < b.y1 ? a.y1 : b.y1,
    };
}

/* The smallest rectangle that holds both. */
static inline struct gp_rect gp_rect_join(struct gp_rect a, struct gp_rect b)
{
    return (struct gp_rect) {
        a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
        a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1,
    };
}

/* Numbers of one option, "1,2,3". */
struct gp_numbers {
    double v[4];
    int n; // 0: not given
};

/* Three float planes of one size, w * h samples each, rows from the top,
 * no padding, samples [y * w + x]. All NULL when empty. */
struct gp_planes {
    float *c[3];
};

/* One plane of samples with its own window: depth, coverage. w * h floats of
 * `window`, rows from the top, no padding; NaN and Inf stay as they were read.
 * Empty: v is NULL. */
struct gp_plane {
    struct gp_rect window; // EXR pixel space
    float *v;              // owned
    char *name;            // channel it came from, for the report; owned
    bool borrowed;         // v is not its own
};

enum gp_pixel_type { GP_UINT, GP_HALF, GP_FLOAT };

/* Bytes of one sample: 4, 2, 4. */
static inline size_t gp_type_size(enum gp_pixel_type type)
{
    return type == GP_HALF ? 2 : 4;
}

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

    struct gp_planes rgb;    // io reads; sensors clean (NaN, Inf, limit)
    struct gp_planes layer;  // glare
    struct gp_planes lit;    // compose: rgb with glare, scene-linear
    struct gp_planes shown;  // tone: display-referred

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
    return (size_t) gp_frame_w(f) * (size_t) gp_frame_h(f);
}

/* Allocates three planes of w * h uninitialised samples, each at GP_ALIGN, in
 * one block. `what` is for the message. On failure *p is empty. Free with
 * gp_planes_free(). */
GP_MUST_CHECK gp_status gp_planes_make(const struct gp_log *log,
    const char *what, size_t samples, struct gp_planes *p);
void gp_planes_free(struct gp_planes *p);

/* Sets samples [from, from + n) of each plane to 0. */
void gp_planes_clear(const struct gp_planes *p, size_t from, size_t n);

/* Frees what it owns and clears it; an empty one is fine. */
void gp_plane_free(struct gp_plane *p);

/* Returns a frame of that window without pixels: floats, square, in Rec.709,
 * of one part. */
struct gp_frame gp_frame_blank(struct gp_rect window);

/* Frees all that the frame owns and clears it; an empty frame is fine. */
void gp_frame_free(struct gp_frame *f);

/* The channel of that exact name, or NULL. */
const struct gp_channel *gp_frame_channel(const struct gp_frame *f,
                                          const char *name);

#endif
