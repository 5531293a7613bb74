// SPDX-License-Identifier: Apache-2.0
/* Projections: which direction of view each place of a picture shows.
 *
 * Places are in EXR pixel space. With u = (x - x0) dx and v = (y - y0) dy, the
 * direction, x right, y down, z along the axis, is
 *
 *   PERSPECTIVE  (u, v, 1) / sqrt(1 + u^2 + v^2)
 *   LATLONG      (cos v sin u, sin v, cos v cos u): u is longitude, v latitude
 *                downwards, in radians
 *   FISHEYE      (sin t u / r, sin t v / r, cos t), r^2 = u^2 + v^2, at t = r
 *                radians from the axis: equidistant
 *   EQUISOLID    the same at t = 2 asin(r / 2): pixels of one solid angle
 *   PLANE        that of a picture of no camera: none. Angles are proportional
 *                to pixels, t^2 = u^2 + v^2 between any two places, and every
 *                pixel has the solid angle dx dy.
 *
 * The angle between two places is that between their directions; where it is
 * small, a step (a, b) in pixels is sqrt(xx a^2 + 2 xy a b + yy b^2) radians long
 * by the metric of its place. */
#ifndef GP_CORE_PROJECTION_H
#define GP_CORE_PROJECTION_H

#include "core/image.h"
#include "core/vector.h"

#include <stdbool.h>

/* PLANE is 0: what is not set. */
enum gp_projecting {
    GP_PLANE,
    GP_PERSPECTIVE,
    GP_LATLONG,
    GP_FISHEYE,
    GP_EQUISOLID
};

struct gp_projection {
    enum gp_projecting kind;
    double x0, y0; // place of the axis, pixels
    double dx, dy; // u and v of a pixel, > 0
    double rim;    // r beyond which a fisheye shows nothing; 0: there is none
};

/* The metric of a place: a symmetric matrix, square radians a square pixel. */
struct gp_metric {
    double xx, xy, yy;
};

/* Returns the projection of pictures whose display window shows `degrees` of view
 * from its upper to its lower edge, axis in the middle, of pixels that are
 * `aspect` times as wide as high. A LATLONG window shows the whole sphere, and a
 * PERSPECTIVE one less than 180 degrees; of an EQUISOLID one at most 360. A fisheye
 * shows half of the sphere, or `degrees` of it where that is more. */
struct gp_projection gp_projection_of(enum gp_projecting kind,
                                      struct gp_rect display, double aspect,
                                      double degrees);

/* Degrees that a pixel in the middle shows of a picture so many pixels high: a
 * camera's, or where its angle of view is more than that can be, a plane's. */
double gp_middle_degrees(double fov, double h);

static inline bool gp_projection_same(const struct gp_projection *a,
                                      const struct gp_projection *b)
{
    return a->kind == b->kind && a->x0 == b->x0 && a->y0 == b->y0 &&
           a->dx == b->dx && a->dy == b->dy && a->rim == b->rim;
}

/* Moves a place whose r is `beyond` the rim, or more, there, towards the axis: less
 * where all directions would end before. */
void gp_projection_pull(const struct gp_projection *p, double beyond,
                        double at[2]);

/* Finds the pixels [span[0], span[1]) of n from place (x, y) on that show anything. */
void gp_projection_span(const struct gp_projection *p, double x, double y,
                        int n, int span[2]);

/* Returns the direction that a place shows, of length 1. Of a PLANE, that of an
 * equidistant fisheye, for want of another. */
struct gp_v3 gp_projection_direction(const struct gp_projection *p, double x,
                                     double y);

/* Finds the place at which a direction, not 0, of any length, shows; false: it has none.
 * Of a LATLONG the one within half a turn. */
bool gp_projection_place(const struct gp_projection *p, struct gp_v3 to,
                         double at[2]);

struct gp_metric gp_projection_metric(const struct gp_projection *p, double x,
                                      double y);

/* Returns the steradians a square pixel at a place: the root of the metric's
 * determinant. 0 at the poles of a LATLONG. */
double gp_projection_solid(const struct gp_projection *p, double x, double y);

/* Fills `row` with those of n places from (x, y) on, a pixel apart. */
void gp_projection_solid_row(const struct gp_projection *p, double x, double y,
                             int n, float *row);

/* Returns the square of the chord between two places, 4 sin^2(t / 2) for the
 * angle t between them; of a PLANE, t^2. */
double gp_projection_chord2(const struct gp_projection *p, double x, double y,
                            double to_x, double to_y);

#endif
