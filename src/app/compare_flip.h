/* FLIP of two images that are compared, and its picture. */
#ifndef GP_APP_COMPARE_FLIP_H
#define GP_APP_COMPARE_FLIP_H

#include "app/compare_figures.h"
#include "app/settings.h"
#include "tone/flip.h"

#include <stdbool.h>

struct gp_compare_flip {
    bool known;    // false: an image has no colour, or --no-flip
    bool hdr;      // HDR-FLIP; LDR-FLIP where both are stored as integers
    double mean;   // of the map, 0 to 1
    struct gp_flip_exposures exposures; // of HDR-FLIP
    float *map;    // of the window, rows from the top; owned
};

/* Computes it; infinite light counts as 65504, as in frames. The first image
 * is the reference whose exposures are found. Primaries are taken as BT.709.
 *   out  written always; free with gp_compare_flip_free()
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_compare_flip(const struct gp_log *log,
                                        const struct gp_compare_settings *s,
                                        const struct gp_compare_match *m,
                                        struct gp_compare_flip *out);
void gp_compare_flip_free(struct gp_compare_flip *f);

/* Writes the map in the colours of magma, 0 black to 1 pale yellow, as the
 * ending of `path` says. The map must be known.
 * Errors: as gp_write_picture(). */
GP_MUST_CHECK gp_status gp_compare_heatmap(const struct gp_log *log,
                                           const struct gp_write_params *p,
                                           const char *path,
                                           const struct gp_compare_match *m,
                                           const struct gp_compare_flip *f);

/* The colour of v (0 to 1, clamped; NaN is 0) in magma, sRGB-encoded, 0 to 1:
 * a polynomial near the map of Smith and van der Walt (matplotlib 1.5). */
void gp_compare_magma(float v, float rgb[3]);

#endif
