// SPDX-License-Identifier: Apache-2.0
/* Real lenses: their prescription, whose JSON is in man/glarepp.1.in, first-order
 * optics, and the ghosts that two reflections inside make of a light.
 *
 * Lengths are in millimetres along the axis z, which points from the scene to
 * the sensor. Slopes are dy/dz of rays in air before the lens: a light of slope
 * u has its image at y = focal length * u on the sensor.
 */
#ifndef GP_SUN_LENS_H
#define GP_SUN_LENS_H

#include "core/image.h"
#include "core/status.h"
#include "glare/sources.h"
#include "glarepp.h"
#include "sun/lights.h"

#include <stdbool.h>
#include <stdio.h>

enum {
    GP_LENS_SURFACES = 64,
    // pairs of surfaces that reflect
    GP_LENS_GHOSTS = GP_LENS_SURFACES * (GP_LENS_SURFACES - 1) / 2,
    // of one path: to the sensor, back and forth
    GP_LENS_STEPS = 3 * GP_LENS_SURFACES,
    GP_LENS_COATS = 8,
    GP_LENS_NUMBERS = 4096, // of all tables
};

/* A coat's table, in the numbers of its lens: its wavelengths in nm, its angles in
 * degrees in the thinner medium, both rising; then the shares that it reflects, a
 * wavelength after the other. */
struct gp_lens_coat {
    char name[32];
    int at, nms, angles;
};

struct gp_lens_surface {
    double curvature; // 1 / radius; 0: flat
    double gap;       // to the next surface, of the last to the sensor
    double n, v;      // index at the d line and Abbe number after it
    double semi;
    double coat; // wavelength in nm of a quarter-wave layer; 0: bare;
                 // -1 - k: table k of the lens
};

#define GP_D_LINE 587.5618 // nm, of helium: n and V are given for it

/* Zeroed is none. Owns nothing. */
struct gp_lens {
    struct glarepp_lens says; // texts, claims and blades; else 0
    struct gp_lens_surface at[GP_LENS_SURFACES];
    int n, stop;      // surfaces; index of the stop
    double turn;      // of blades, degrees, counter-clockwise
    struct gp_lens_coat coat[GP_LENS_COATS];
    int coats, numbers;
    double number[GP_LENS_NUMBERS];
};

/* A surface on the path of a ghost, in the order of the path. */
struct gp_lens_step {
    int surface;
    bool back;        // light arrives from the sensor's side
    bool reflects;
};

/* A path through the lens: straight to the sensor, or by two reflections. */
struct gp_lens_path {
    int steps;
    struct gp_lens_step step[GP_LENS_STEPS];
};

/* Rows of [[a, b], [c, d]], from (height, slope) to (height, slope). */
struct gp_lens_matrix {
    double a, b, c, d;
};

/* Reads a prescription: a file, or that of an installed lens by its name, "heliar".
 * *out is written on GP_OK only. Errors: GP_ERR_IO cannot be read; GP_ERR_DATA (names
 * file, surface and key), also for files over 1 MiB. */
GP_MUST_CHECK gp_status gp_lens_read(const struct gp_log *log, const char *name,
                                     struct gp_lens *out);

/* Returns the index of glass at a wavelength: n + B / nm^2 (Cauchy), which
 * meets n at the d line and V between the lines F and C. */
double gp_lens_index(double n, double v, double nm);

/* Returns the share that surface i reflects of unpolarised light, with its coat:
 * a layer of magnesium fluoride, or of the square root of n1 n2 where that is
 * higher, or a table. `cosine` is in the thinner medium: from both sides it is the
 * same.
 * Source: Fresnel; two beams of a layer as in Hullin et al. 2011, appendix. */
double gp_lens_reflected(const struct gp_lens *lens, int i, double cosine,
                         double nm);

/* Focuses: sets the last gap so that an object at `distance` mm before the
 * first surface (INFINITY: far) is sharp, and closes the stop to f_number where
 * that is over 0 and over the lens's own. Errors: GP_ERR_USAGE no image of such
 * an object; the lens has no focal length over 0; f_number is under its own. */
GP_MUST_CHECK gp_status gp_lens_focus(const struct gp_log *log,
    struct gp_lens *lens, double distance, double f_number);

/* Measures in first order; *out has no ghosts. Returns the millimetres on the
 * sensor for a slope of 1 of the chief ray, as the lens is focused. */
double gp_lens_measure(const struct gp_lens *lens, struct glarepp_lens *out);

/* Fills in the path by surfaces first > second, or straight with -1, -1. */
void gp_lens_path(const struct gp_lens *lens, int first, int second,
                  struct gp_lens_path *out);

/* Returns the first-order matrix of the path's steps [0, steps), each with the
 * way to it and its refraction. Source: Lee and Eisemann 2013, section 3. */
struct gp_lens_matrix gp_lens_matrix(const struct gp_lens *lens,
    const struct gp_lens_path *path, int steps, double nm);

/* Lists the ghosts of all pairs of surfaces that reflect; returns how many. `blur`,
 * unless NULL, gets the width in mm of the stop's Fresnel fringe in each. */
int gp_lens_ghosts(const struct gp_lens *lens, double nm,
                   struct glarepp_ghost out[GP_LENS_GHOSTS],
                   double blur[GP_LENS_GHOSTS]);

/* Draws the lens in section as SVG, with the rays of a ghost, which may be
 * NULL. `f` keeps errors of writing. */
GP_MUST_CHECK gp_status gp_lens_svg(const struct gp_log *log, FILE *f,
    const struct gp_lens *lens, const struct glarepp_ghost *ghost);

// -- ghosts of many lights, drawn into a layer (lens_draw.c) -----------------

/* A light in the picture.
 *
 * Its image and its ghosts share the light that enters: with E the light
 * that crosses a square millimetre before the lens, the image of a light on the
 * axis has E * pupil * transmission, and a ghost E * cos * area * share, both
 * traced. The frame, taken to have no vignetting, holds the image's light as the
 * light's flux, so brightness is absolute: nothing is tuned.
 *
 * Each cell of a ghost's mesh is a polygon of even light, cut by rims and
 * blades, and covers pixels by area, at half, quarter, ... of the frame's
 * resolution where the stop's Fresnel fringe, which no edge is sharper than, is
 * that much wider than a pixel. Wavelengths between the three that are traced
 * are interpolated, as many as dispersion needs. */
struct gp_lens_light {
    double x, y;      // EXR pixel space
    double flux[3];   // of its image, scene-linear, summed over pixels
};

/* Cells of meshes, steps of pixels and bands of the spectrum. */
enum gp_lens_detail {
    GP_LENS_COARSE,    // of many lights
    GP_LENS_FINE,      // of a few: several times the time
    GP_LENS_REFERENCE, // the finest, many times the time
};

struct gp_lens_view {
    struct gp_rect frame;      // of the layer
    struct gp_rect display;    // its middle is on the axis
    double mm[2];              // of a pixel on the sensor, across and down
    const float *chromaticities; // 8, borrowed
    const float *luminance;    // 3 weights, borrowed
    double mean;               // mean luminance of the frame
    double tolerance;          // error of meshes; ghosts are left out that
                               // together, by first order, stay under this
                               // share of `mean` at every pixel
    double rest[3];            // flux of lights that are not given: left out
    enum gp_lens_detail detail;
};

/* Lists the visible lights that have flux; of a frame without lights the 100
 * brightest blocks of 16 x 16 pixels with sources.
 *   out   owned by the caller, gp_free(); *n of them
 *   rest  share of the sources' luminance that has none
 *   dark  flux of these is added to it */
GP_MUST_CHECK gp_status gp_lens_lights(const struct gp_log *log,
    const struct gp_light *light, int lights, const struct gp_sources *src,
    struct gp_lens_light **out, int *n, double *rest, double dark[3]);

/* Adds the ghosts of `n` lights by a lens that is focused to `layer`, of the frame's
 * size: the same bytes for any threads. *out gets the facts that it finds; 0 else. */
GP_MUST_CHECK gp_status gp_lens_draw(const struct gp_log *log,
    const struct gp_lens *lens, const struct gp_lens_view *view,
    const struct gp_lens_light *light, int n, struct gp_planes *layer,
    struct glarepp_lens_facts *out);

#endif
