// SPDX-License-Identifier: Apache-2.0
/* Lens flare: elements on the line from a light through the image's centre.
 * Lights are those listed, or every bright pixel (sun/ghosts.h).
 *
 * An element's total over all pixels (of an unbounded picture) is colour *
 * flux * visibility in each channel, so that it looks the same at every
 * resolution and dims by exactly the hidden share; of hard rings a pixel wide
 * that are over 128 pixels across, to 1 %. Dirt adds less: a glow of
 * that total times the image's value at each pixel. An element's place is
 *   light + at * (centre - light)       at 0 the light, 1 the centre, 2 beyond
 * its diameter `size` times the frame's height (an image's longer side). No element
 * is smaller, and no edge, ring or ray thinner, than a pixel.
 *
 * man/glarepp.1.in has the JSON, all its keys, and which go together. Elements of
 * bright pixels are one image for all of them: nothing of a light's own counts.
 */
#ifndef GP_SUN_FLARE_H
#define GP_SUN_FLARE_H

#include "core/image.h"
#include "core/status.h"
#include "sun/lights.h"

enum gp_flare_shape {
    GP_FLARE_DISC, GP_FLARE_RING, GP_FLARE_POLYGON, GP_FLARE_STREAK,
    GP_FLARE_IMAGE, GP_FLARE_GLOW, GP_FLARE_SPIKES, GP_FLARE_CAUSTIC,
    GP_FLARE_DIRT, GP_FLARE_SHAPES,
};

enum gp_flare_source { GP_FLARE_LIGHTS, GP_FLARE_BRIGHT };

/* Pixels of an image element; rows from the top. The middle of the image is at
 * (cx, cy) in its own continuous pixels. */
struct gp_flare_image {
    int w, h;
    double cx, cy;
    struct gp_planes rgb; // owned
};

/* Factors by a light's place, at [0] and at [1], linear between. */
struct gp_flare_by_place {
    bool given, edge;     // distance from the edge, not from the centre
    double size[2], colour[2][3];
};

enum { GP_FLARE_PROFILE = 32 };

struct gp_flare_element {
    enum gp_flare_shape shape;
    enum gp_flare_source source;
    double at, size, rotation, width;
    int sides;
    float colour[3], scale[3];
    bool plain;           // image at its own pixels, not scaled to sum 1:
                          // value = flux * visibility * sample. size, scale,
                          // rotation and colour do not count
    float profile[GP_FLARE_PROFILE];
    int profiles;         // 0: the shape's own
    // as the man page's keys
    double softness, rim, dispersion, aspect, completion, feather, round;
    double falloff, random, spread, offset, cut, shrink, flicker;
    int count, seed;
    bool axis;            // rotation counts from the line
    struct gp_flare_by_place by_place;
    char *only;           // owned; NULL: all lights
    char *path;           // image's file as the JSON names it, resolved
                          // against the JSON's folder; owned; NULL none
    struct gp_flare_image image; // filled by the caller that reads `path`
};
#define GP_FLARE_DEFAULTS                                                     \
    { .size = 0.1, .width = 0.1, .sides = 6, .colour = {0.01f, 0.01f, 0.01f}, \
      .scale = {1.0f, 1.0f, 1.0f}, .aspect = 1.0, .completion = 1.0,          \
      .falloff = 6.0, .count = 1 }

struct gp_flare {
    struct gp_flare_element *element; // owned
    int n;
    char *path;                       // of the JSON, for messages; owned
    int frame;                        // number of the one to draw, for flicker
};

/* Returns true when an element of f has that source. */
bool gp_flare_has(const struct gp_flare *f, enum gp_flare_source source);

/* Reads a file, or the installed flare that "preset:NAME" names. Copies are
 * elements of their own. *out is written on GP_OK only; gp_flare_free(). Errors:
 * GP_ERR_USAGE no such preset (the message lists them); GP_ERR_IO cannot be read;
 * GP_ERR_DATA (names file, element and key), also for files over 1 MiB or of over
 * 1024 elements, copies counted. */
GP_MUST_CHECK gp_status gp_flare_read(const struct gp_log *log,
                                      const char *word, struct gp_flare *out);
void gp_flare_free(struct gp_flare *f);

/* Adds all elements of lights, for every light, to `layer` (w * h of `frame`), in the
 * order of lights, then elements: the same bytes for any threads. */
GP_MUST_CHECK gp_status gp_flare_add(const struct gp_log *log,
    const struct gp_flare *f, const struct gp_light *light, int n,
    struct gp_rect frame, struct gp_rect display, struct gp_planes *layer);

#endif
