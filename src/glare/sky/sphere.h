// SPDX-License-Identifier: Apache-2.0
/* Lat-long frames: a sphere, on whose circles of latitude glare is the same everywhere.
 *
 * The term of two circles is a convolution along them. With Fourier coefficients of
 * the light on each,
 *
 *   y_m(i) = sum over circles k of K_m(i, k) x_m(k)
 *
 * exactly, seam and poles among them. So levels are along meridians only: circles of
 * nodes, each level's half as many, between them cubic B-splines. A meridian goes on
 * beyond a pole as the one half a turn away, whose coefficients are (-1)^m of its own.
 *
 * The first term is summed pixel by pixel: by transforms in float a lamp leaves noise all
 * around its row, as strong there as its veil. Around the poles, where that term reaches
 * far along rows and rows are short, it goes by coefficients too. */
#ifndef GP_GLARE_SKY_SPHERE_H
#define GP_GLARE_SKY_SPHERE_H

#include "glare/fft/pass.h"
#include "glare/sky/sky_priv.h"

/* Coefficients of the terms of pairs of circles i and i + o, o <= reach, of which the
 * pair's middle is not beyond the equator: those have mirror images. */
struct gp_sky_circles {
    int n; // intervals from pole to pole; of level 0 rows around a pole
    int reach;
    int blocks;   // of GP_FLOAT_LINES coefficients; farther ones are nothing
    size_t pairs; // of which coefficients are stored
    float *k;     // [block][i (reach + 1) + o][GP_FLOAT_LINES]; owned
};

/* Weights of a row by another one, of sources -reach .. reach columns away. */
struct gp_sky_arc {
    int reach; // < 0: none
    size_t at; // of the middle one
};

/* A row among the circles of level 1: the first of four, and B there. */
struct gp_sky_between {
    int first; // from -1 on
    float at[GP_SKY_TAPS];
};

struct gp_sky_sphere {
    int w, h;   // pixels of the whole sphere
    int x0, y0; // of the frame's first pixel
    int levels; // level[1] .. level[levels - 1]; level[0]: around the poles
    struct gp_sky_circles level[GP_SKY_LEVELS];
    int near;                    // rows that the first term reaches
    int margin;                  // the most columns that an arc reaches
    struct gp_sky_arc *arc;      // [row][near + down], of the upper half; owned
    float *weight;               // of arcs; owned
    double *own;                 // share that stays in pixels of rows; owned
    double *even;                // factor of terms along rows; owned
    struct gp_sky_between *rows; // of each row; owned
    struct gp_transform around;
};

/* Makes s->sphere; it stays NULL where a frame is not whole pixels of a sphere, of a
 * width that transforms take. */
GP_MUST_CHECK gp_status gp_sky_sphere_make(const struct gp_log *log,
                                           struct gp_sky *s);
void gp_sky_sphere_free(struct gp_sky_sphere **sphere);

/* The mean of P over two pixels of any rows, a source's solid angle not in it; of a
 * pixel with itself but for `own`, which is over that. */
double gp_sky_sphere_mean(const struct gp_sky *s, const double at[2],
                          const double from[2]);

/* gp_sky_add() of a sphere. */
GP_MUST_CHECK gp_status gp_sky_sphere_add(const struct gp_log *log,
                                          const struct gp_sky *s,
                                          const struct gp_sky_drawing *d);

#endif
