/* Maughan's texture masking (Game Programming Gems 3, 5.5), from a frame's
 * depth and coverage instead of its geometry.
 *
 * Sun map: for each light side x side texels, all lights' side by
 * side in one atlas, drawn at once. A texel is a sample of the pattern, which
 * gp_pattern_place() scales by the radius; it holds
 *   r  the share shown, times g: grey where its cell is larger than a pixel,
 *      as the mean of k x k samples of it, k = clamp(ceil(2 R / side), 1, 16)
 *   g  the share of it that counts: 0 outside the frame with
 *      GP_OUTSIDE_IGNORE, else 1
 * A sample reads the pixel it falls in.
 *
 * Intensity map: texel (i, 0) of one row is light i. The map's texels are
 * drawn as points into it and add up, times 1 / count: visibility = r / g, 0
 * where g is 0.
 *
 * Only the pixels under lights are uploaded: each light's box, cut to the
 * frame, side by side; the whole frame where that is less.
 */
#ifndef GP_SUN_MAP_H
#define GP_SUN_MAP_H

#include "core/status.h"
#include "gl/gl.h"
#include "sun/occluder.h"

enum gp_sun_pattern { GP_PATTERN_DISC, GP_PATTERN_SQUARE };

/* Forms of summing the intensity map. */
enum gp_sun_sum {
    GP_SUM_FLOAT,    // every texel, in float, times 1 / count
    GP_SUM_BYTE,     // in 8 bits, as in the paper: times 1 / 255, saturating
    GP_SUM_BILINEAR, // a quarter of the points, each the mean of 2x2 texels
};

struct gp_map_params {
    enum gp_sun_outside outside;
    enum gp_sun_pattern pattern;
    enum gp_sun_sum sum;
    int side; // texels of a sun map's side, 2 to 256, even
};
#define GP_MAP_DEFAULTS { .side = 16 }

/* Programs, textures and targets on a context; kept from frame to frame. */
struct gp_sun_map;

/* Draws the maps; waits for nothing and reads nothing back. *state is made at
 * the first call.
 *   n  1 to GP_LIGHTS_MAX; lights behind the camera come out 0
 * Errors: GP_ERR_GL sizes over the context's, GL's own; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_sun_map_draw(
    const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    const struct gp_light *light, int n, struct gp_sun_map **state);

/* Waits for the last draw and reads light[].visibility. */
GP_MUST_CHECK gp_status gp_sun_map_read(
    const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_sun_map *s, struct gp_light *light, int n);

/* The paper's other method: the region under each light is drawn at the frame's
 * own pixels (r shown, g counts), read back, and counted on the CPU: every
 * pixel whose centre is in the disc; the nearest one when there is none. Sets
 * visibility, and writes it to the intensity map too. */
GP_MUST_CHECK gp_status gp_sun_readback(
    const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    struct gp_light *light, int n, struct gp_sun_map **state);

/* Pictures of the last draw, for --debug: the atlas (side * columns wide), and
 * the intensity map (n x 1); both from r / g, *out owned by the caller, w * h
 * floats. */
GP_MUST_CHECK gp_status gp_sun_map_picture(
    const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_sun_map *s, bool intensity, int *w, int *h, float **out);
void gp_sun_map_close(const struct gp_gl *gl, struct gp_sun_map **state);

/* Returns the visibility of one light on the CPU, the plain form of the map,
 * summed in double whatever p->sum; `map` gets p->side squared texels of r and
 * g, or is NULL. */
double gp_sun_map_reference(const struct gp_occluders *o,
    const struct gp_map_params *p, const struct gp_light *light, float *map);

#endif
