// SPDX-License-Identifier: Apache-2.0
/* Shared by the files of lenses: rays, meshes, cells, bands of the spectrum. */
#ifndef GP_SUN_LENS_PRIV_H
#define GP_SUN_LENS_PRIV_H

#include "sun/lens.h"

#include <stdint.h>

// -- lenses: rays and meshes (lens.c, lens_trace.c, lens_cover.c) ------------

enum {
    GP_LENS_TABLE = 512, // steps of the cosine
    GP_LENS_NODES = 3,   // traced wavelengths
    GP_LENS_PASSES = 3,  // of the stop on one path
    GP_LENS_CELLS = 128, // most of a mesh, a side
    GP_LENS_RAYS = (GP_LENS_CELLS + 1) * (GP_LENS_CELLS / 2 + 1),
};

/* The lens at one wavelength. */
struct gp_lens_optics {
    const struct gp_lens *lens; // borrowed
    double nm;
    double n[GP_LENS_SURFACES + 1]; // before each surface, after the last
    double z[GP_LENS_SURFACES + 1]; // of each surface and of the sensor
    // share reflected, by the cosine in the thinner medium: from both sides
    float reflected[GP_LENS_SURFACES][GP_LENS_TABLE + 2];
};

/* The place at which a ray lands. */
struct gp_lens_hit {
    double x, y;     // on the sensor
    float through;   // share of the ray's light; negative: it does not arrive
    float passed;    // the same, without the two reflections
    float cosine[2]; // at these, in the thinner medium
    float weight[2]; // mm^2 that it stands for: in cells that are drawn, in all
    float rim;       // largest height over semi of any surface but the stop
    float stop[GP_LENS_PASSES][2]; // place over the stop's semi, at each pass
};

/* Rays of one ghost of one light: (cells + 1) times (cells / 2 + 1) places
 * before the lens for each wavelength, over x in [x0, x1] and y in [0, y1]; the
 * light is in the plane y = 0, which mirrors the rest. */
struct gp_lens_mesh {
    int cells;          // a side, even; 0: none arrives
    int passes;         // of the stop
    double x0, x1, y1;  // mm
    double flux[GP_LENS_NODES]; // mm^2 times share that arrives
    double root[GP_LENS_NODES]; // of what other rims at a node let through
    double scale;       // of the cells' light, towards an endless mesh
    double lost;        // the same of cells with a ray that does not arrive
    struct gp_lens_hit *hit; // owned; [node][row of y][column of x]
};

/* A convex outline of stop's blades: n.x * x + n.y * y <= apothem. None: the
 * unit circle. */
struct gp_lens_blades {
    int n;
    double normal[32][2], apothem;
};

/* A corner of a piece of a cell; all of it is linear between two. */
union gp_lens_corner {
    struct {
        double p, q;   // before the lens
        double x, y;   // on the sensor
        double rim;
        double stop[GP_LENS_PASSES][2];
    };
    double all[5 + 2 * GP_LENS_PASSES];
};
enum { GP_LENS_CORNERS = 4 + 1 + GP_LENS_PASSES * 32 };

void gp_lens_optics_make(const struct gp_lens *lens, double nm,
                         struct gp_lens_optics *out);

/* Traces a ray that meets the plane of the first surface at (x, y), with slope
 * u in x. `at`, if not NULL, gets a point (x, y, z) for each step, and that on the
 * sensor. Source: sphere and refraction in vectors, as in Hullin et al. 2011. */
struct gp_lens_hit gp_lens_trace(const struct gp_lens_optics *o,
    const struct gp_lens_path *path, double x, double y, double u,
    double (*at)[3]);

/* The blades as seen with the x axis turned by `angle` (radians, from x to
 * y); of the area of no circle, but with corners on it. */
struct gp_lens_blades gp_lens_blades_of(const struct gp_lens *lens,
                                        double angle);

/* Traces meshes of a path at each of GP_LENS_NODES optics with 16, 32, ... cells, until
 * the light that arrives and the area that it covers change by less than ten times
 * `tolerance`, or than would move an edge by `step` mm on the sensor, and, where
 * `tolerance` is under 1e-3, sides of cells are straight and even enough; sets `scale`
 * by Richardson's rule, as both err with the square of a cell. */
GP_MUST_CHECK gp_status gp_lens_mesh_make(const struct gp_log *log,
    const struct gp_lens_optics *optics, const struct gp_lens_path *path,
    const struct gp_lens_blades *blades, double u, double tolerance,
    double step, struct gp_lens_mesh *out);
void gp_lens_mesh_free(struct gp_lens_mesh *m);

/* Returns true when blades and rims let all of a ray's light through. */
static inline bool gp_lens_is_clear(const struct gp_lens_blades *b, int passes,
                                    const struct gp_lens_hit *h)
{
    bool clear = h->rim <= 1.0f;
    for (int s = 0; s < passes && b->n; s++)
        clear = clear && (double) (h->stop[s][0] * h->stop[s][0] +
                                   h->stop[s][1] * h->stop[s][1]) <=
                             b->apothem * b->apothem;
    return clear;
}

/* Returns the corner of a cell at a ray, at (p, q) before the lens; `sign` -1:
 * of the mesh's other half. */
union gp_lens_corner gp_lens_corner_of(const struct gp_lens_hit *h, double p,
                                        double q, double sign);

/* Cuts the cell of corners c[0..3], in turn, by rims and blades, in place;
 * c has room for GP_LENS_CORNERS. Returns the corners left, 0: nothing. */
int gp_lens_cut(const struct gp_lens_blades *blades, int passes,
                union gp_lens_corner c[GP_LENS_CORNERS]);

/* Returns the area before the lens of a piece of the cell between two opposite corners,
 * and the shares of the cell's four corners in what is at the piece's middle. */
double gp_lens_piece(const union gp_lens_corner *c, int n,
                     const union gp_lens_corner *from,
                     const union gp_lens_corner *to, double share[4]);

/* Rows [y0, y1) of an accumulator: w + 2 columns of three channels a row, whose
 * running sums are light a pixel. */
struct gp_lens_cover {
    double *v; // borrowed, of row y0
    int w, y0, y1;
};

/* Adds an edge: `light` a pixel more to its right where it goes up, less where
 * it goes down. */
void gp_lens_cover_edge(const struct gp_lens_cover *k, const double a[2],
                        const double b[2], const double light[3]);

/* Spreads light evenly over a polygon of n >= 3 points, which does not cross
 * itself; of no area it goes to the pixels of its points. The part outside the
 * rows and columns is dropped. */
void gp_lens_cover_add(const struct gp_lens_cover *k, const double (*p)[2],
                       int n, const double light[3]);

/* Light of a frame in steps of pixels, from a step before it to one after it:
 * (w + 2) * (h + 2) places of three channels. */
struct gp_lens_steps {
    int step, w, h;
    double *v;       // owned; NULL: none
};
enum { GP_LENS_LEVELS = 5 }; // 1, 2, 4, 8 and 16 pixels a step

// -- ghosts by cells and parts of the spectrum (lens_cells.c, lens_draw.c) ----

enum {
    GP_LENS_SETS = 7,        // of bands
    GP_LENS_SETS_COARSE = 5, // that many lights have
    GP_LENS_PARTS = 96,      // of the spectrum, most bands of a set
    GP_LENS_COSINES = 128,   // steps
    GP_LENS_SAME = 12,       // most parts that meet a surface at one angle
};

/* Wavelengths in nm that the rays have: of violet, green and red. */
extern const double gp_lens_node[GP_LENS_NODES];

/* Parts of the spectrum, whose rays are between those of the nodes (Lagrange). Their
 * colours, over the light of the image on the axis, are folded into the gamut when they
 * are summed. */
struct gp_lens_spectrum {
    double nm[GP_LENS_PARTS], at[GP_LENS_NODES][GP_LENS_PARTS];
    double rgb[3][GP_LENS_PARTS];
    // share that a surface reflects, by the root of 1 - cosine in the thinner
    // medium: even steps of small angles
    float reflected[GP_LENS_SURFACES][GP_LENS_COSINES + 2][GP_LENS_PARTS];
};

/* The light of a path: of the two surfaces that reflect, if any; and of a ray on the axis
 * that the others let through, at each node, and in each part over what the nodes make
 * of it. */
struct gp_lens_pair {
    const float (*by[2])[GP_LENS_PARTS]; // borrowed of a spectrum
    double axis[GP_LENS_NODES], over[GP_LENS_PARTS];
};

/* Parts of the spectrum that are drawn at one place. */
struct gp_lens_band {
    int from, to;
    double of_node[GP_LENS_NODES]; // of its place
};

/* A cell in the frame: the rows of the layer that its light may meet. */
struct gp_lens_cell {
    float y0, y1;
    uint8_t set;       // 1 + its set of bands; 0: not in the frame
};

/* A light's ghost by one pair of surfaces. */
struct gp_lens_item {
    struct gp_lens_mesh mesh;
    struct gp_lens_blades blades;
    double flux[3], u;
    double light[3]; // of all that arrives
    // pixels of the layer: of a mm along and across the light's axis, and of the
    // lens's axis
    double along[2], aside[2], middle[2];
    const struct gp_lens_pair *pair; // borrowed
    int level;         // of its step; negative: no cell is in the frame
    struct gp_lens_cell cell[2][GP_LENS_CELLS * GP_LENS_CELLS / 2]; // halves
};

/* A band's rays of an item, to be drawn; for one thread. Places are in steps of the
 * item's accumulator. */
struct gp_lens_rays {
    double p[GP_LENS_RAYS][2][2]; // halves
    double light[GP_LENS_RAYS][3];
    uint8_t needs[GP_LENS_RAYS]; // bits of sets that need it
    uint8_t set[2][GP_LENS_CELLS * GP_LENS_CELLS / 2]; // of cells; 0: none
    bool arrives[GP_LENS_RAYS], clear[GP_LENS_RAYS];
    // of cells, with a dark one more on each side
    double density[(GP_LENS_CELLS + 2) * (GP_LENS_CELLS / 2 + 2)][3];
};

/* Makes the spectrum, with the frame's 8 chromaticities and the light of the image on
 * the axis at each node. */
void gp_lens_spectrum_make(const float *chromaticities,
                           const struct gp_lens *lens,
                           const double image[GP_LENS_NODES],
                           struct gp_lens_spectrum *out);

/* Measures a path; `s` needs its reflectances only. */
void gp_lens_pair_make(const struct gp_lens_spectrum *s,
                       const struct gp_lens *lens,
                       const struct gp_lens_path *path,
                       struct gp_lens_pair *out);

/* Sums up the light of a ray in a band, by the root of its share that passes, and the
 * cosines at its two reflections in the thinner medium, at each node. */
void gp_lens_light_of(const struct gp_lens_spectrum *s,
                      const struct gp_lens_pair *pair,
                      const struct gp_lens_band *band,
                      const double root[GP_LENS_NODES],
                      const double cosine[2][GP_LENS_NODES], double out[3]);

/* Sums up the light of an item's mesh, of flux 1, which its cells then have. */
void gp_lens_item_light(struct gp_lens_item *it,
                        const struct gp_lens_spectrum *s,
                        const float luminance[3]);

/* Finds the step of an item with a mesh, the bands of each of its cells, and the rows
 * of those in the frame. Bands of many lights may be `ease` >= 1 times as wide. */
void gp_lens_item_place(const struct gp_lens_view *v, double blur,
                        double ease, struct gp_lens_item *it);

/* Draws an item into rows [top, end) of the steps of its level. */
void gp_lens_item_draw(const struct gp_lens_item *it,
                       const struct gp_lens_spectrum *spectrum,
                       const struct gp_lens_steps *steps, int top, int end,
                       struct gp_lens_rays *rays);

#endif
