// SPDX-License-Identifier: Apache-2.0
/* A picture in memory, and its planes: what the library's rooms work on. */
#ifndef GP_CORE_IMAGE_H
#define GP_CORE_IMAGE_H

#include "core/status.h"
#include "glarepp.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The rooms' name of it. Empty when x1 <= x0 or y1 <= y0. */
#define gp_rect glarepp_rect

static inline int gp_rect_w(struct gp_rect r)
{
    return r.x1 > r.x0 ? r.x1 - r.x0 : 0;
}

static inline int gp_rect_h(struct gp_rect r)
{
    return r.y1 > r.y0 ? r.y1 - r.y0 : 0;
}

static inline size_t gp_rect_pixels(struct gp_rect r)
{
    return (size_t) gp_rect_w(r) * (size_t) gp_rect_h(r);
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

/* Row y of a plane of w samples a row. */
static inline float *gp_row(float *plane, int w, int y)
{
    return plane + (size_t) y * (size_t) w;
}

/* Sample (x, y) of channel c of w x h planes; 0 outside. */
static inline float gp_planes_at(const struct gp_planes *p, int c, int w, int h,
                                 int x, int y)
{
    return x >= 0 && x < w && y >= 0 && y < h ? gp_row(p->c[c], w, y)[x] : 0.0f;
}

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

/* A picture. Each plane has one writer, named beside it: a later step reads what
 * earlier ones wrote and never writes there. */
struct gp_image {
    char *path;                    // for messages; owned
    struct gp_rect data, display;  // windows in EXR pixel space
    struct gp_rect read;           // pixels that were not added to `data`; empty:
                                   // all of it
    float pixel_aspect;
    float chromaticities[8];       // rx ry gx gy bx by wx wy
    bool names_chromaticities;     // given; else BT.709's
    float luminance[3];            // Y = sum luminance[c] * rgb[c]

    struct gp_planes rgb;    // the caller's; sensors clean (NaN, Inf, limit)
    struct gp_planes layer;  // glare
    struct gp_planes lit;    // compose: rgb with glare, scene-linear
    struct gp_planes shown;  // tone: display-referred
};

static inline int gp_image_w(const struct gp_image *f)
{
    return gp_rect_w(f->data);
}

static inline int gp_image_h(const struct gp_image *f)
{
    return gp_rect_h(f->data);
}

/* The pixels that were not added. */
static inline struct gp_rect gp_image_read(const struct gp_image *f)
{
    return gp_rect_empty(f->read) ? f->data : f->read;
}

static inline size_t gp_image_pixels(const struct gp_image *f)
{
    return gp_rect_pixels(f->data);
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

/* Returns an image of that window without pixels: square, in Rec.709. */
struct gp_image gp_image_blank(struct gp_rect window);

/* Frees all that the image owns and clears it; an empty one is fine. */
void gp_image_free(struct gp_image *f);

#endif
