// SPDX-License-Identifier: Apache-2.0
/* Surfaces before a light, from a frame's depth and coverage.
 *
 * A pixel shows a light's share s in [0, 1]:
 *   neither plane   1
 *   mask only       1 - m
 *   depth only      0 where a surface is nearer than the light, else 1
 *   both            1 - m where a surface is nearer or where depth is empty
 *                   (a leaf's edge, whose depth sample missed it); else 1
 *   deep        gp_deep_clear() of the samples that are nearer, whatever else is
 * m is the mask clamped to [0, 1], NaN 0. A surface is nearer when
 * z < depth * (1 - bias); every surface is nearer than an infinite depth.
 *
 * Empty depth is no surface; core/depth.h defines it.
 * Pixels outside a plane's window have no sample: depth is empty, m is 0.
 */
#ifndef GP_SUN_OCCLUDER_H
#define GP_SUN_OCCLUDER_H

#include "core/deep.h"
#include "core/image.h"
#include "core/status.h"
#include "sun/lights.h"

#include <stddef.h>

struct gp_occluders {
    const struct gp_plane *depth, *mask; // borrowed; NULL: none
    const struct gp_deep *deep;          // the same; z in the unit of lights
    enum glarepp_depth type;
    struct gp_rect frame;        // pixels that may be hidden or clear:
                                 // display and data window together, or with
                                 // GLAREPP_BY_SCENE the data window as read
    double around;               // pixels of a turn, of frames of a whole
                                 // sphere; else 0
    // by gp_occluders_count(), of all depth samples
    struct gp_depth_range surfaces;
    bool reversed;  // sign or direction turned, see core/depth.h
    char empty[64]; // values of the background that occur: "1e+10",
                    // "0, inf", "none"
};

/* Looks at o->depth's samples. Call before anything below; no depth is fine. */
void gp_occluders_count(struct gp_occluders *o);

/* A pixel, anywhere in the plane. */
struct gp_sun_pixel {
    double place; // of its surface on the light's scale: distance for z, ray
                  // and inverse, 0 near to 1 far for normalized. INFINITY: none
    float cover;  // share of a light that it hides where the surface is nearer,
                  // or there is none
};
struct gp_sun_pixel gp_occluders_at(const struct gp_occluders *o, int x, int y);

/* s of a pixel. Sets *beyond, unless it is NULL, to true where depth has a
 * surface that is not nearer than the light. */
double gp_occluders_show(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y, bool *beyond);

/* visibility = sum(area * shown) / sum(area), both over the pixels of
 * o->frame, and the area outside of it as `outside` says; in double. IGNORE takes
 * it over the part inside, 0 where there is none. A deep pixel that the edge of a
 * disc cuts shows more on the side of neighbours that do. BY_SCENE counts the part
 * outside by gp_light.outside, and so all of a light behind the camera, which else has
 * 0, or traced. Radii count as 1e-3 to 1e9. All hidden is exactly 0, all clear
 * exactly 1. Time grows with the disc's area inside the planes' windows. */
void gp_sun_exact(const struct gp_occluders *o, enum glarepp_outside outside,
                  struct gp_light *light, int n);

/* Writes in_frame, low and high, between which are visibility and the true share of
 * each light, but for details thinner than a pixel: of all its disc, with every
 * pixel at an edge hidden, and with every one clear. A pixel is at an edge where its
 * coverage is not 0 or 1; by depth alone, where one of its eight neighbours shows
 * another share; with both, there too if it or that neighbour has a surface that is
 * not nearer than the light. Deep pixels that are wholly in the disc show their share:
 * at most that of bias, at least that without.
 * Outside of the frame, and behind the camera, a light may be hidden or clear;
 * with GLAREPP_BY_SCENE it is gp_light.outside within its error. */
void gp_sun_interval(const struct gp_occluders *o, enum glarepp_outside outside,
                     struct gp_light *light, int n);

/* Area of a light's disc, of radius r, within pixel (x, y), in closed form; 0 for r <= 0
 * and NaN. */
double gp_light_pixel_area(const struct gp_light *l, double r, int x, int y);

#endif
