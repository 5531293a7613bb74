/* Flare elements made ready for the lights of one frame: what the CPU and GL
 * forms evaluate alike, in float, pixel by pixel.
 *
 * With p the pixel's centre less the element's place, rho = |p|, and m the
 * larger of |x| and |y| of a unit vector across an edge, an edge at distance d
 * is a ramp of width m: coverage clamp(1/2 - d / m, 0, 1). m is what a line of
 * pixels along the axis nearest to the edge sees of a pixel; a straight edge
 * of any direction then covers, summed over pixels, its exact area.
 *
 *   disc     ramp at radius
 *   ring     ramp at radius less ramp at inner (-1: a disc, no hole)
 *   polygon  least of the ramps of its sides, at `inner` from the middle
 *   streak   (1 - |t|)^2 along, times the ramp at +inner less that at -inner
 *            across
 *   image    bilinear sample, 0 outside; one item a channel where their
 *            scales differ
 */
#ifndef GP_SUN_FLARE_ITEM_H
#define GP_SUN_FLARE_ITEM_H

#include "sun/flare.h"

/* Texture of an image at half size, `level` times. */
struct gp_flare_level {
    struct gp_flare_image image; // rgb owned when level > 0, else borrowed
    int level;
    double sum[3], luminance;    // of the whole image, level 0; 0 when not
                                 // finite or not over 0: draws nothing
};

/* One element of one light. */
struct gp_flare_item {
    enum gp_flare_shape shape;
    bool plain;
    int element, light;
    struct gp_rect rect;  // pixels of the frame that it may reach; not empty
    double x, y;          // place, EXR pixel space
    float base[2];        // centre of pixel (rect.x0, rect.y0) less the place
    float turn[2];        // cosine and sine of the rotation
    float radius[3];      // pixels, each channel's; image: [0] texels a pixel
    float inner[3];       // pixels: radius of the hole, distance of the sides,
                          // half the width; image: [0], [1] the place in
                          // texels
    int corner[2];        // plain: texel of pixel (rect.x0, rect.y0), whose
    float fraction[2];    // weight is 1 - fraction, and the next one's it
    float amount[3];      // light where coverage or sample is 1, when clear
    int sides;
    const float *edge;    // polygon: nx, ny, 1 / m of each side
    const struct gp_flare_image *image; // of the item's level
};

struct gp_flare_items {
    struct gp_flare_item *at;     // owned; in the order of lights, elements
    int n;
    float *edge;                  // owned; GP_FLARE_EDGE floats an element
    struct gp_flare_level *level; // owned; one an element
    int elements;
};

enum { GP_FLARE_SIDES = 64, GP_FLARE_EDGE = 3 * GP_FLARE_SIDES };

/* All that is not empty, at full visibility; with `clear` only of lights whose
 * visibility is over 0. Elements of f are not needed afterwards, but plain
 * images and such as are drawn at their own size or larger. Free with
 * gp_flare_items_free(), after a failure too. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_flare_items_make(const struct gp_log *log,
                                            const struct gp_flare *f,
                                            const struct gp_light *light,
                                            int n, bool clear,
                                            struct gp_rect frame,
                                            struct gp_rect display,
                                            struct gp_flare_items *out);
void gp_flare_items_free(struct gp_flare_items *items);

/* The level at which `size` of the longer side in pixels is not under a pixel
 * a texel, with its sums. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_flare_level_make(const struct gp_log *log,
                                            const struct gp_flare_image *image,
                                            double size,
                                            struct gp_flare_level *out);
void gp_flare_level_free(struct gp_flare_level *l);

/* Columns [*x0, *x1) outside of which the item reaches nothing in rows
 * [y0, y1); cut to its rect. false: nothing at all. */
bool gp_flare_span(const struct gp_flare_item *item, int y0, int y1, int *x0,
                   int *x1);

/* Adds amount * coverage of channel c in row y to out[0] = column x0, and on
 * to x1; both inside the item's rect. */
void gp_flare_row(const struct gp_flare_item *item, int c, int y, int x0,
                  int x1, float amount, float *out);

#endif
