/* Lens flare: elements on the line from a light through the image's centre.
 * Lights are those listed, or every bright pixel (sun/ghosts.h).
 *
 * An element's total over all pixels (of an unbounded picture) is colour *
 * flux * visibility in each channel, so that it looks the same at every
 * resolution and dims by exactly the hidden share. Its place is
 *   light + at * (centre - light)       at 0 the light, 1 the centre, 2 beyond
 * its diameter `size` times the frame's height (an image's longer side), each
 * channel's times its `scale` (dispersion: the total stays). Coverage of a
 * pixel is by its distance to the edge, a pixel wide, so that edges are smooth
 * and a step of 1/8 pixel is a small change. No element is smaller, and no ring
 * or streak thinner, than a pixel.
 *
 * JSON, an array or {"elements": [...], "source": of elements without their
 * own}; every key has a default but shape:
 *   {"shape": "disc" | "ring" | "polygon" | "streak" | "image",
 *    "position": 0, "size": 0.1, "color": [r,g,b] | grey (0.01),
 *    "rotation": degrees (0), "scale": [r,g,b] (1,1,1),
 *    "width": ring's or streak's share of the radius (0.1; streak 0.01),
 *    "sides": of the polygon (6), "image": file beside the JSON,
 *    "source": "lights" | "bright" pixels of the frame (lights)}
 * disc: flat; ring: an annulus that ends at the radius; polygon: regular, its
 * corners on the radius; streak: a band along the rotation that fades to both
 * ends as (1 - |t|)^2; image: its luminance sum is scaled to 1, bilinear, and
 * nothing where that sum is not over 0. Rotation is counter-clockwise as seen.
 * Unknown keys and shapes, keys of another shape, numbers out of range (size 0
 * to 10, position -10 to 10, rotation -36000 to 36000, color 0 to 1e6, scale
 * 0.01 to 100, width 1e-6 to 1, sides 3 to 64) are errors that name file,
 * element and key.
 */
#ifndef GP_SUN_FLARE_H
#define GP_SUN_FLARE_H

#include "core/frame.h"
#include "core/status.h"
#include "gl/gl.h"
#include "sun/lights.h"

enum gp_flare_shape {
    GP_FLARE_DISC, GP_FLARE_RING, GP_FLARE_POLYGON, GP_FLARE_STREAK,
    GP_FLARE_IMAGE,
};

enum gp_flare_source { GP_FLARE_LIGHTS, GP_FLARE_BRIGHT };

/* Pixels of an image element; rows from the top. The middle of the image is at
 * (cx, cy) in its own continuous pixels. */
struct gp_flare_image {
    int w, h;
    double cx, cy;
    struct gp_planes rgb; // owned
    unsigned long serial; // gp_serial_next(); 0 none
};

struct gp_flare_element {
    enum gp_flare_shape shape;
    enum gp_flare_source source;
    double at, size, rotation, width;
    int sides;
    float colour[3], scale[3];
    bool plain;           // image at its own pixels, not scaled to sum 1:
                          // value = flux * visibility * sample. size, scale,
                          // rotation and colour do not count
    char *path;           // image's file as the JSON names it, resolved
                          // against the JSON's folder; owned; NULL none
    struct gp_flare_image image; // filled by the caller that reads `path`
};

struct gp_flare {
    struct gp_flare_element *element; // owned
    int n;
    char *path;                       // of the JSON, for messages; owned
};

/* Returns true when an element of f has that source. */
bool gp_flare_has(const struct gp_flare *f, enum gp_flare_source source);

/* Errors: GP_ERR_IO cannot be read; GP_ERR_DATA as above. Files over 1 MiB or
 * of over 1024 elements are refused. *out is written on GP_OK only; free:
 * gp_flare_free(). */
GP_MUST_CHECK gp_status gp_flare_read(const struct gp_log *log,
                                      const char *path, struct gp_flare *out);
void gp_flare_free(struct gp_flare *f);

/* Adds all elements of lights, for every light, to `layer` (w * h of `frame`), in plain C:
 * lights of visibility 0, or behind the camera, cost nothing. In the order of
 * lights, then elements; rows in parallel, same bytes for any threads. */
GP_MUST_CHECK gp_status gp_flare_add(const struct gp_log *log,
    const struct gp_flare *f, const struct gp_light *light, int n,
    struct gp_rect frame, struct gp_rect display, struct gp_planes *layer);

/* The same on GL, where visibility is texel (i, 0) of `intensity` (r / g, 0
 * where g is 0) and the vertex shader fetches it: a hidden light's polygons
 * stay shut. Draws, blended, into a float target of what the elements reach
 * together, and does not wait for it. *state keeps programs and textures.
 * `intensity` must not change until gp_flare_read_layer(), which draws the part
 * beyond a target's 4096 pixels. Errors: GP_ERR_GL, GP_ERR_BUG memory. */
struct gp_flare_gl;
GP_MUST_CHECK gp_status gp_flare_draw(
    const struct gp_log *log, const struct gp_gl *gl, const struct gp_flare *f,
    const struct gp_light *light, int n, const struct gp_texture *intensity,
    struct gp_rect frame, struct gp_rect display, struct gp_flare_gl **state);

/* Waits for the last draw, reads it back, and adds it to `layer`. */
GP_MUST_CHECK gp_status gp_flare_read_layer(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_flare_gl *state,
    struct gp_rect frame, struct gp_planes *layer);
void gp_flare_close(const struct gp_gl *gl, struct gp_flare_gl **state);

#endif
