/* Ghosts of many lights in a real lens, drawn into a layer.
 *
 * A light's image and its ghosts share the light that enters: with E the light
 * that crosses a square millimetre before the lens, the image of a light on the
 * axis has E * pupil * transmission, and a ghost E * cos * area * share, both
 * traced. What a frame holds as the light's flux is its image, so brightness is
 * absolute: nothing is tuned. The frame is taken to have no vignetting.
 *
 * Each cell of a ghost's mesh is a polygon of even light, cut by rims and
 * blades, and covers pixels by area, at half, quarter, ... of the frame's
 * resolution where the stop's Fresnel fringe, which no edge is sharper than, is
 * that much wider than a pixel. Wavelengths between the three that are traced
 * are interpolated, as many as dispersion needs.
 */
#ifndef GP_SUN_LENS_DRAW_H
#define GP_SUN_LENS_DRAW_H

#include "core/frame.h"
#include "core/status.h"
#include "sun/lens.h"

/* A light in the picture. */
struct gp_lens_light {
    double x, y;      // EXR pixel space
    double flux[3];   // of its image, scene-linear, summed over pixels
};

/* Cells of meshes, steps of pixels and bands of the spectrum. */
enum gp_lens_detail {
    GP_LENS_COARSE,            // of many lights
    GP_LENS_FINE,              // of a few: several times the time
    GP_LENS_REFERENCE,         // the finest, many times the time; for bench and
                               // tests
};

struct gp_lens_view {
    struct gp_rect frame;      // of the layer
    struct gp_rect display;    // its middle is on the axis
    double mm[2];              // of a pixel on the sensor, across and down
    const float *chromaticities; // 8, borrowed
    const float *luminance;    // 3 weights, borrowed
    double mean;               // mean luminance of the frame
    double tolerance;          // ghosts are left out that together stay under
                               // this share of `mean` at every pixel, by first
                               // order; error of meshes
    double rest[3];            // flux of lights that are not given, which
                               // counts as left out
    enum gp_lens_detail detail;
};

struct gp_lens_stats {
    int lights, ghosts;        // with light; pairs of surfaces
    int drawn, left_out;       // pairs
    double light[3];           // of the ghosts, inside and outside the frame
    double lost;               // share of the ghosts' light whose rays miss a
                               // surface or are reflected wholly
    double dark;               // luminance at a pixel of all ghosts left out,
                               // by first order, over `mean`
    double missing;            // bound of the norm, over pixels and channels,
                               // of all ghosts left out, by first order
    double steps[5];           // ghosts drawn at 1, 2, 4, 8, 16 pixels a step
};

/* Adds the ghosts of `n` lights to `layer`, of the frame's size. Same bytes
 * for any threads.
 *   lens  focused
 * Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_lens_draw(const struct gp_log *log,
    const struct gp_lens *lens, const struct gp_lens_view *view,
    const struct gp_lens_light *light, int n, struct gp_planes *layer,
    struct gp_lens_stats *out);

#endif
