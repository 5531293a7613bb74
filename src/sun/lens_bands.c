/* Parts of the spectrum, and the light of rays in them. */
#include "sun/lens_priv.h"

#include "core/colour.h"

#include <math.h>

enum { FINE = GP_LENS_BANDS }; // bands that sets of bands join

const double gp_lens_node[GP_LENS_NODES] = {450.0, 545.0, 640.0};
const int gp_lens_bands_of_set[GP_LENS_SETS] = {1, 3, 6, 12, 24, 48, 96};

/* In 1 / nm: Cauchy's index, and with it the places of rays, go with its
 * square. */
static void lagrange(double nm, double out[GP_LENS_NODES])
{
    for (int k = 0; k < GP_LENS_NODES; k++) {
        out[k] = 1.0;
        for (int i = 0; i < GP_LENS_NODES; i++) {
            const double other = 1.0 / gp_lens_node[i];
            out[k] *= i == k ? 1.0 : (1.0 / nm - other) /
                                         (1.0 / gp_lens_node[k] - other);
        }
    }
}

/* Sets each channel's light from that at the nodes. A coat's reflectance goes
 * with the square of the distance, in 1 / nm, to its own wavelength, and that
 * of two surfaces with the fourth power: it is the root that Lagrange's
 * polynomial follows. */
void gp_lens_light_of(const struct gp_lens_band *b,
                      const double root[GP_LENS_NODES], double out[3])
{
    double pair[GP_LENS_PAIRS] = {0};
    int n = 0;
    for (int i = 0; i < GP_LENS_NODES; i++) {
        for (int k = i; k < GP_LENS_NODES; k++)
            pair[n++] = root[i] * root[k];
    }
    for (int c = 0; c < 3; c++) {
        out[c] = 0.0;
        for (int i = 0; i < GP_LENS_PAIRS; i++)
            out[c] += b->light[c][i] * pair[i];
        out[c] = out[c] > 0.0 ? out[c] : 0.0;
    }
}

/* Adds a part of the spectrum, of weights rgb and the image's light. */
static void add_light(const double rgb[3], const double of_node[GP_LENS_NODES],
                      double image, struct gp_lens_band *b)
{
    int n = 0;
    for (int i = 0; i < GP_LENS_NODES; i++) {
        for (int k = i; k < GP_LENS_NODES; k++, n++) {
            const double both = of_node[i] * of_node[k] * (i == k ? 1.0 : 2.0);
            for (int c = 0; c < 3; c++)
                b->light[c][n] += rgb[c] * both / image;
        }
    }
}

void gp_lens_bands_make(const float *chromaticities,
                        const double image[GP_LENS_NODES],
                        struct gp_lens_band band[GP_LENS_SETS][GP_LENS_BANDS])
{
    double nm[FINE], rgb[FINE][3];
    gp_spectrum_weights(chromaticities, FINE, nm, rgb);
    for (int s = 0; s < GP_LENS_SETS; s++) {
        const int each = FINE / gp_lens_bands_of_set[s];
        for (int b = 0; b < gp_lens_bands_of_set[s]; b++) {
            struct gp_lens_band *const out = &band[s][b];
            double sum = 0.0, middle = 0.0;
            *out = (struct gp_lens_band) {0};
            for (int i = b * each; i < (b + 1) * each; i++) {
                double at[GP_LENS_NODES], root = 0.0;
                // no curve is followed below the least light that an eye sees
                lagrange(fmin(fmax(nm[i], 420.0), 680.0), at);
                for (int k = 0; k < GP_LENS_NODES; k++)
                    root += at[k] * sqrt(image[k]);
                add_light(rgb[i], at, root * root, out);
                for (int c = 0; c < 3; c++) {
                    sum += fabs(rgb[i][c]);
                    middle += fabs(rgb[i][c]) * nm[i];
                }
            }
            // places, of Cauchy's index, are followed further: all violet at
            // the place of one wavelength would be a ring
            lagrange(fmin(fmax(middle / sum, 390.0), 720.0), out->of_node);
        }
    }
}
