/* Discs: equal-area samples, and the area within a rectangle. */
#ifndef GP_SUN_DISC_H
#define GP_SUN_DISC_H

#include "sun/light.h"

/* Where (u, v) in [0, 1)^2 falls: the square [-1, 1]^2, or the unit disc by
 * the concentric map (Shirley and Chiu 1997), which keeps areas' ratios. Texel
 * (i, j) of an n x n sun map is the cell [i, i+1)/n x [j, j+1)/n. */
void gp_pattern_place(enum gp_sun_pattern pattern, double u, double v,
                      double *x, double *y);

/* Area of the disc of radius r around (cx, cy) within [x0, x1) x [y0, y1),
 * whole numbers, in closed form; 0 for r <= 0, NaN, and empty rectangles. The
 * disc's edge is placed to 1e-12 of a pixel for r and distances up to 1e5. */
double gp_disc_rect_area(double cx, double cy, double r, double x0, double y0,
                         double x1, double y1);

#endif
