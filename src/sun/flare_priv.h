// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of flares: elements at one size, and quads of them. */
#ifndef GP_SUN_FLARE_PRIV_H
#define GP_SUN_FLARE_PRIV_H

#include "sun/flare.h"

// -- flare: closed forms of elements (element.c) ------------------------------

enum { GP_FLARE_SIDES = 64 };

/* In [0, 1), the same for the same seed and i. */
double gp_flare_random(int seed, int i);

/* A ray of a streak or of spikes, in the element's axes. */
struct gp_flare_ray {
    float c, s;   // direction
    float per_t;  // entries of the table in a pixel along it
    float half;   // of its width, pixels
    double length; // in radii
};

/* An element, not an image, at one size: tables of its profile, in square
 * pixels' light for a sum of `area`. */
struct gp_flare_look {
    struct gp_flare_element e;  // borrows
    double diameter;            // asked for, pixels
    double radius, extent;      // pixels; of the profile, in radii
    double aspect, per_t;       // entries of the table in a radius
    float pixel;                // in radii: 1 / radius
    float across;               // pixels across an edge for 1 of the norm
    float edge[6];              // hard edges, in radii; `edges` of them
    int edges;
    int n;                      // entries of the table: [entry][channel]
    float *table;               // owned
    float side[GP_FLARE_SIDES][2]; // of a polygon: normal over its distance
    struct gp_flare_ray *ray;   // owned
    int rays;
    double area[3];             // sum over an unbounded plane
};
GP_MUST_CHECK gp_status gp_flare_look_make(const struct gp_log *log,
    const struct gp_flare_element *e, double diameter,
    struct gp_flare_look *out);
void gp_flare_look_free(struct gp_flare_look *l);

/* Pixels from the place beyond which the element is 0. */
double gp_flare_look_reach(const struct gp_flare_element *e, double diameter);

// -- flare: elements made ready for the lights of one frame (flare.c) --------

/* Factors of by_place for a light at (x, y). */
void gp_flare_factors(const struct gp_flare_by_place *b, double x, double y,
                      struct gp_rect display, double *size, double colour[3]);

/* Factor of an element's brightness in a frame. */
double gp_flare_flicker(const struct gp_flare_element *e, int frame);

/* The quad of one element of one light. */
struct gp_flare_quad {
    bool plain;
    const struct gp_flare_look *look; // NULL: an image
    struct gp_rect rect;  // pixels of the frame that it may reach; not empty
    double x, y;          // place, EXR pixel space
    float base[2];        // centre of pixel (rect.x0, rect.y0) less the place
    float turn[2];        // cosine and sine of the rotation
    float radius[3];      // image: texels a pixel, of each channel
    float inner[2];       // image: the place in texels
    int corner[2];        // plain: texel of pixel (rect.x0, rect.y0), whose
    float fraction[2];    // weight is 1 - fraction, and the next one's it
    float cut[2];         // radii by which the pupil's rim is moved
    float dirt[4];        // texels a pixel, and the place in texels
    float amount[3];      // light where the value or sample is 1
    const struct gp_flare_image *image; // of the quad's level; dirt
};

/* The pixels that element e, as light l sees it, may reach, in a frame or not;
 * empty when it reaches none. `display` gives centre and height. */
struct gp_rect gp_flare_reach(const struct gp_flare_element *e,
    const struct gp_light *l, struct gp_rect display);

/* Adds amount * value of a look, or sample of an image, in row y of the quad's
 * rect. */
void gp_flare_add_row(const struct gp_flare_quad *q, int y,
                      const float amount[3], float *const out[3]);

#endif
