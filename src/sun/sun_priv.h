/* Shared by the files of sun, and private to them: areas of discs, and lights
 * as sources. */
#ifndef GP_SUN_PRIV_H
#define GP_SUN_PRIV_H

#include "sun/stage.h"

// -- discs (exact.c) ---------------------------------------------------------

/* Area of the disc of radius r around (cx, cy) within [x0, x1) x [y0, y1),
 * integers, in closed form; 0 for r <= 0, NaN, and empty rectangles. The
 * disc's edge is placed to 1e-12 of a pixel for r and distances up to 1e5. */
double gp_disc_rect_area(double cx, double cy, double r, double x0, double y0,
                         double x1, double y1);

/* Returns the pixels of `rect` that the disc of radius r around (x, y) may
 * touch. */
struct gp_rect gp_disc_box(double x, double y, double r, struct gp_rect rect);

/* Divides the pixels of the frame in which a plane has samples, and `margin` (0
 * or 1) more on each side, into rectangles that do not overlap; some may be
 * empty. Returns how many. */
enum { GP_SUN_RECTS = 5 };
int gp_sun_rects(const struct gp_occluders *o, int margin,
                 struct gp_rect rect[GP_SUN_RECTS]);

// -- lights as sources and sprites (stage_light.c) ---------------------------

/* Weights of the (2m+1) x (2m+1) pixels around a disc's centre pixel, whose
 * sum is 1; one pixel for a radius up to 1/2. */
struct gp_disc_pixels {
    int m;
    float *weight; // owned: gp_free()
};
GP_MUST_CHECK gp_status gp_disc_pixels_make(
    const struct gp_log *log, double radius, struct gp_disc_pixels *out);

/* The pixels of `frame` that a light's disc falls on, each with its share of
 * flux * visibility: the weights above, moved to the light's place by bilinear
 * shares, which keep flux and centroid. Appends to list[*n], which has room
 * for gp_disc_room() more. */
size_t gp_disc_room(double radius); // pixels of a disc, at most
void gp_disc_light(const struct gp_disc_pixels *d, const struct gp_light *l,
                   struct gp_rect frame, struct gp_source *list, size_t *n);

void gp_suns_drop_sprite(struct gp_suns *suns);

#endif
