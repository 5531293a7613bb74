// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of this folder and their tests. */
#ifndef GP_GLARE_SKY_PRIV_H
#define GP_GLARE_SKY_PRIV_H

#include "glare/curve.h"
#include "glare/sky/sky.h"

#include <stddef.h>

enum {
    GP_SKY_BLOCK = 16,  // columns of pixels or nodes that are summed together
    GP_SKY_ROWS = 4,    // rows of them
    GP_SKY_BAND = 16,   // rows of a task, and most of a group
    GP_SKY_LEVELS = 12, // most
    GP_SKY_TAPS = 4,    // nodes that a cubic B-spline meets
    GP_SKY_SINGLE_NEAR =
        2, // pixels that level 0 reaches, where others have one
           // weight a node
};

/* The light of all models by the square of the chord, and where it goes. */
struct gp_sky_light {
    struct gp_curve curve; // per steradian; chord^2 is 4 at 180 degrees
    double nearest;        // chord within which it is even
    double stays;          // light that stays in its pixel
};

/* Places at which weights are known; between them they are cubic. Along each axis
 * they are even in an angle: atan of PERSPECTIVE's u or v, else u or v. */
struct gp_sky_places {
    double first[2], step[2]; // radians
    int n[2];
};

/* A column of a level among the places: the first of four, and their weights. */
struct gp_sky_column {
    int place;
    float at[4];
};

/* A level: pixels, or nodes 2^l pixels apart, from one before the frame on. */
struct gp_sky_level {
    double step; // pixels
    int w, h;    // nodes
    int rx, ry;  // of weights, in nodes
    int block;   // columns between which weights are linear: BLOCK, half of
                 // it, or 1, where they are found for each
    int rows;    // of a group
    bool tilts;  // weights are linear in a group's rows, not the same but for a
                 // factor
    size_t pitch, size; // floats of a row of weights, and of a place's
    float *weight; // [place][ry + dy][rx + dx], of a source that is (dx, dy)
                   // nodes before the place; owned
    short *span;   // [place][ry + dy][2]: those that are not 0, from and to,
                   // of dx + rx; owned
    double *sum;   // of each place's weights; owned
    struct gp_sky_column *column; // every `block`, and one more; owned
    float *line; // single: of row k of places the weight of node x at [k][x];
                 // owned
};

struct gp_sky_sphere; // sphere.h
struct gp_sky_single; // single.c

struct gp_sky {
    struct gp_sky_params p;
    int from, to;        // channels [from, to) that it is for: all of them, ...
    struct gp_sky *next; // ... or one, and that of the next one; owned
    struct gp_sky_light light;
    double ratio;                 // root of A, in steps of the level
    struct gp_sky_single *single; // levels but the last have one weight a node,
                                  // which is not divided by splines; or NULL;
                                  // owned
    double negligible; // share of the light there, of a weight that is none
    struct gp_sky_places places;
    bool even[2]; // the axis is in the middle: mirrored places have mirrored
                  // weights
    int levels; // 0 is the pixels'; the last one's weights are `pairs`. There are
                // none, and nothing of them, where `p` has no models
    struct gp_sky_level level[GP_SKY_LEVELS];
    float *pairs;                 // of the last level: [to][from]; owned
    double *own;                  // of each place; owned
    struct gp_sky_column *column; // of each pixel; owned
    struct gp_sky_sphere *sphere; // NULL: not LATLONG; nor is what follows
    // light that leaves the frame
    struct gp_curve within;     // share of light within a chord
    double spread;              // all of it
    int outer[2], *outer_at[2]; // places along each axis, pixels; owned: [0]
    float *outside;             // of each; owned
    struct gp_sky_facts facts;
};

// -- light.c ------------------------------------------------------------------

/* The light of channel c. */
GP_MUST_CHECK gp_status gp_sky_light_make(const struct gp_log *log,
                                          const struct gp_sky_params *p, int c,
                                          struct gp_sky_light *out);

/* P_A; of A = 0 P itself. */
static inline double gp_sky_soft(const struct gp_sky_light *l, double a,
                                 double c)
{
    double v = 0.0;
    if (c < a) {
        const double u = c / a, w = 1.0 - u;
        c = a * (u + 0.28 * w * w);
    }
    gp_curve_add(&l->curve, c, 1.0, &v);
    return v;
}

/* Returns the mean of P_A over two pixels, or that of P for A = 0, less that of P_less
 * where it is not 0, by so many places of each axis. */
double gp_sky_mean(const struct gp_sky_light *l, const struct gp_projection *p,
                   double a, double less, int order, const double at[2],
                   const double from[2]);

/* Returns the nodes that keep 1e-6 of P's mean `away` of a pixel's longest side
 * from the light, at least 2 of them. */
int gp_sky_order(double away);

/* Returns the mean of P over two pixels that may meet, by boxes of offsets that are the
 * smaller the nearer they are to none. */
double gp_sky_close_mean(const struct gp_sky_light *l,
                         const struct gp_projection *p, const double at[2],
                         const double from[2]);

/* The metric at a place: the longest and shortest way that a pixel's step can
 * be, radians, how far a step of 1 radian reaches along x and y, pixels, and the side
 * that scales of levels count in, by which long pixels err as others do. */
struct gp_sky_ellipse {
    double most, least, x, y, side;
};
struct gp_sky_ellipse gp_sky_ellipse_at(const struct gp_projection *p, double x,
                                        double y);

// -- outside.c ----------------------------------------------------------------

/* Fills `within`, the share of light within a chord, by its square, and its sums. */
GP_MUST_CHECK gp_status gp_sky_outside_make(const struct gp_log *log,
                                            struct gp_sky *s);

/* Fills the table, by that, and facts.kept and outside. */
GP_MUST_CHECK gp_status gp_sky_outside_table(const struct gp_log *log,
                                             struct gp_sky *s);

// -- weigh.c ------------------------------------------------------------------

/* A of level l at a place whose pixels have that side: an ellipse's. */
double gp_sky_scale(const struct gp_sky *s, int l, double side);

/* The term of a level >= 1 between two places, `side` that of a pixel at the first: of its nodes, not divided by splines. `last`: none comes after it. */
double gp_sky_term(const struct gp_sky *s, int level, bool last,
                   const double at[2], const double from[2], double side);

/* The same of the square of a chord, no mean over pixels. */
double gp_sky_soft_term(const struct gp_sky *s, int level, double side,
                        double c);

/* The light that pixel `at`, its longest side `most`, gets from pixel `from`. */
double gp_sky_pixel(const struct gp_sky *s, const double at[2],
                    const double from[2], double most);

/* Fill the weights of a level >= 1, or of pixels, at a place, as level.weight has
 * them; scratch: (2 rx + 1) (2 ry + 1) numbers. Of pixels, the share that stays is
 * returned. */
void gp_sky_weigh_level(const struct gp_sky *s, int level, const double at[2],
                        double side, double *scratch, float *out);
double gp_sky_weigh_pixels(const struct gp_sky *s, const double at[2],
                           double side, double *scratch, float *out);

// -- single.c -----------------------------------------------------------------

/* Makes s->single, by the scales of s->ratio. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sky_single_make(const struct gp_log *log,
                                           struct gp_sky *s);

/* Fits the weight of each level at a place, per steradian. */
void gp_sky_single_fit(const struct gp_sky *s, const double at[2], double side,
                       double weight[GP_SKY_LEVELS]);

/* As gp_sky_weigh_pixels(), beside these weights. */
double gp_sky_single_pixels(const struct gp_sky *s, const double at[2],
                            const double weight[GP_SKY_LEVELS], double side,
                            double *scratch, float *out);

/* The norm of the error of these weights at a place over the layer's; `near` has the
 * pixels' weights, what stays among them. */
double gp_sky_single_error(const struct gp_sky *s, const double at[2],
                           double side, const double weight[GP_SKY_LEVELS],
                           const double *near);

// -- sum.c --------------------------------------------------------------------

/* to += the sum of at[k] from[k] over four rows, n of each. */
void gp_sky_add_four(const float *const from[4], const float at[4], size_t n,
                     float *to);

// -- bound.c ------------------------------------------------------------------

/* Fills facts.relative, once all else is made. */
GP_MUST_CHECK gp_status gp_sky_error_find(const struct gp_log *log,
                                          struct gp_sky *s);

/* The same of a sphere, of which levels are not along circles: no more than that. */
void gp_sky_error_of_sphere(struct gp_sky *s);

// -- places.c -----------------------------------------------------------------

/* Lays places over the frame, and over nodes beyond it of levels that have weights by
 * places. */
void gp_sky_lay_places(struct gp_sky *s);

/* Places n columns, `step` pixels apart, from `first` on. *out is owned by the caller.
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_sky_columns(const struct gp_log *log,
                                       const struct gp_sky *s, int n,
                                       double first, double step,
                                       struct gp_sky_column **out);

/* The place coordinate of x (axis 0) or y. */
double gp_sky_place_of(const struct gp_sky *s, int axis, double x);

/* The pixel of place i; of one far beyond a fisheye's rim, nearer to that. */
void gp_sky_place_at(const struct gp_sky *s, int i, double at[2]);

/* Weights of the four places around t, from the returned one on. */
int gp_sky_cubic(double t, int n, double w[4]);

#endif
