/* Shared by lens_draw, lens_bands and lens_cells, and private to them: ghosts
 * of lights, by cells and parts of the spectrum. */
#ifndef GP_SUN_LENS_CELLS_PRIV_H
#define GP_SUN_LENS_CELLS_PRIV_H

#include "sun/lens_draw.h"
#include "sun/lens_priv.h"

#include <stdint.h>

enum {
    GP_LENS_SETS = 7,        // of bands
    GP_LENS_SETS_COARSE = 5, // that many lights have
    GP_LENS_BANDS = 96,      // most of a set
    GP_LENS_PAIRS = GP_LENS_NODES * (GP_LENS_NODES + 1) / 2,
};

/* Wavelengths in nm that the rays have: of blue, green and red. */
extern const double gp_lens_node[GP_LENS_NODES];

/* Parts of the spectrum in each set. */
extern const int gp_lens_bands_of_set[GP_LENS_SETS];

/* A part of the spectrum: how the nodes make its rays (Lagrange), and each
 * channel's light of a ray from the products of two nodes' roots of it, over
 * the light of the image on the axis. */
struct gp_lens_band {
    double of_node[GP_LENS_NODES];
    double light[3][GP_LENS_PAIRS];
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
    double flux[3], turn[2], u; // turn: cosine and sine of the light's axis
    double along[2], aside[2], middle[2]; // pixels of the layer: of a mm along
                                          // and across the light's axis, and
                                          // of the lens's axis
    double y0, y1;     // rows of the layer that it covers
    int level;         // of its step; negative: outside the frame
    struct gp_lens_cell cell[2][GP_LENS_CELLS * GP_LENS_CELLS / 2]; // halves
};

/* A band's rays of an item, to be drawn; for one thread. */
struct gp_lens_rays;
GP_MUST_CHECK gp_status gp_lens_rays_make(struct gp_lens_rays **out);

/* Makes all sets of bands.
 *   chromaticities  8, of the frame
 *   image           light of the image on the axis at each node */
void gp_lens_bands_make(const float *chromaticities,
                        const double image[GP_LENS_NODES],
                        struct gp_lens_band band[GP_LENS_SETS][GP_LENS_BANDS]);

/* Sets each channel's light from the square roots of that at the nodes. */
void gp_lens_light_of(const struct gp_lens_band *b,
                      const double root[GP_LENS_NODES], double out[3]);

/* Finds the step of an item with a mesh, the bands of each of its cells, and
 * the rows of those in the frame. `ease` >= 1: bands of many lights may be
 * so much wider. */
void gp_lens_item_place(const struct gp_lens_view *v,
                        const struct gp_lens_ghost *g, double ease,
                        struct gp_lens_item *it);

/* Draws an item into rows [top, end) of the steps of its level. */
void gp_lens_item_draw(const struct gp_lens_item *it,
    struct gp_lens_band band[GP_LENS_SETS][GP_LENS_BANDS],
    const struct gp_lens_steps *steps, int top, int end,
    struct gp_lens_rays *rays);

#endif
