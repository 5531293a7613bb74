// SPDX-License-Identifier: Apache-2.0
/* Glare by true angles: models of the angle alone, over a frame that a projection
 * shows.
 *
 *   layer(p) = sum over sources s of L_s Omega_s P(p, s)
 *
 * P(p, s) is the light per steradian at the angle between both, its mean over the
 * two pixels, which shine and are lit evenly; Omega_s the solid angle of the
 * source's pixel. In a picture that is no convolution: a pixel off the axis covers
 * less of the sky, and a circle of the sky is an ellipse there.
 *
 * It is summed on levels. With c the square of the chord between two directions and
 * a scale A, let
 *
 *   P_A(c) = P(c) from c = A on, else P(A psi(c / A)),  psi(u) = u + 0.28 (1 - u)^2
 *
 * which has no peak, and bends on the scale of A only. Then
 *
 *   P = (P - P_A1) + (P_A1 - P_A2) + ... + P_AL,   A(l + 1) = 4 A(l)
 *
 * The first term ends at A1, some 7 pixels away, and is summed pixel by pixel. Term
 * l of the others is smooth on 2^l pixels: light goes to a grid of that step by
 * cubic B-splines, from grid to grid, a half in size each, is spread there, and
 * comes back the same way. Each term ends at A(l + 1), so that a grid costs a
 * quarter of the one before it, and all together a third of the first term.
 * Weights are those of true angles at every place of every grid. Where a tolerance
 * allows it, from 5e-3 on, a node spreads to itself alone: single.c; of light with a
 * tint none, of which each channel has levels of its own.
 *
 * Light that an opening diffracts goes by direction cosines: cosines.h. */
#ifndef GP_GLARE_SKY_H
#define GP_GLARE_SKY_H

#include "core/image.h"
#include "core/projection.h"
#include "core/status.h"
#include "glare/model/model.h"
#include "glare/sky/cosines.h"
#include "glare/sources.h"

struct gp_sky_params {
    int n; // models of the angle; 0: there are cosines alone
    struct gp_angular part[GP_RECIPES];
    double share[GP_RECIPES]; // of each
    double stays; // other light that stays in its pixel, of which an error is
                  // the less a share
    struct gp_projection projection; // not PLANE; places count from the frame's
                                     // corner
    int w, h;                        // of the frame, pixels
    float luminance[3];              // weights of its channels
    double tolerance;                // of rel_l2
    struct gp_cosines *cosines;      // NULL: none; gp_sky_make() takes them
};

struct gp_sky;

/* Makes what frames of w x h pixels need. Written only on GP_OK; free with
 * gp_sky_free(). *out stays NULL where levels are needed and cannot serve: a model that
 * bends within the first level, pixels of over 8 degrees or 16 times as long as wide.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sky_make(const struct gp_log *log,
                                    const struct gp_sky_params *p,
                                    struct gp_sky **out);
void gp_sky_free(struct gp_sky **sky);

/* The sky of channel c, for the functions that say so; itself without a tint. */
const struct gp_sky *gp_sky_channel(const struct gp_sky *sky, int c);

/* Takes the least share that stays in a pixel anywhere, a float, out of what the
 * levels leave there, for a kernel to have as its centre. */
double gp_sky_give(struct gp_sky *sky);

/* Adds the layer of sources, or writes it. */
struct gp_sky_drawing {
    const struct gp_sources *src;
    bool add;
    float more[3]; // share of each pixel's light that stays in it beside the
                   // levels'
    bool last;     // no frame follows
    struct gp_cosines_kept **kept; // from frame to frame; NULL at first
    struct gp_planes *layer;
};

/* Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sky_add(const struct gp_log *log,
                                   const struct gp_sky *sky,
                                   const struct gp_sky_drawing *d);

/* Fills `own` with the share of its light that a channel's levels leave in each of n
 * pixels, of columns x, which ascend, in row y of a frame of w x h pixels in the middle of
 * those that they are for. */
void gp_sky_own(const struct gp_sky *sky, int w, int h, int y, const int32_t *x,
                size_t n, float *own);

/* Leaves what is beyond a fisheye's rim dark, in a row of w samples of a layer; one of
 * other frames than the sky's, which a margin makes wider, has no rim. */
void gp_sky_cut_row(const struct gp_sky *sky, int y, int w, float *row);

/* Limit of the error of gp_sky_exact() over the layer, of curves and means. */
#define GP_SKY_EXACT 4e-6

/* Adds the layer as it is defined, sample by sample in double, to 3 w h numbers that
 * are not NaN: those are left out. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sky_exact(const struct gp_log *log,
                                     const struct gp_sky *sky,
                                     const struct gp_sources *src,
                                     double *layer);

/* The share of the light of a white source at (x, y) that falls outside of the frame. */
double gp_sky_left_out(const struct gp_sky *sky, double x, double y);

/* The same of a channel's levels: as much of a pixel's glare comes from there where the
 * sky is even. */
double gp_sky_outside(const struct gp_sky *sky, double x, double y);

/* Fills `row` with it; between places that are denser towards the border, within
 * 1e-3 of the light. */
void gp_sky_outside_row(const struct gp_sky *sky, int y, float *row);

/* Of the light, and limits of the error of gp_sky_add(). */
struct gp_sky_facts {
    struct gp_cosines *cosines; // NULL: none
    const char *way; // that light takes: "levels", or without them "fft"
    double light; // share that levels and cosines spread, and that levels leave
                  // in its pixel
    double given; // what gp_sky_give() took of that
    double relative; // the error's 2-norm over the layer's
    double splines; // and what it is more by of cosines, over that of the light
    double outside; // of gp_sky_outside_row(): the root of its mean square
    double kept;    // samples of a source's layer sum to no less a share of it
};
const struct gp_sky_facts *gp_sky_facts(const struct gp_sky *sky);

#endif
