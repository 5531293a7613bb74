/* sun: lights, what hides them, and the flare they make in a lens.
 *
 *   light     a sun or lamp as it stands in a frame (this file)
 *   camera    where a direction or a place in the world stands in the frame
 *   lights    lights from JSON
 *   occluder  what stands before a light: depth, coverage
 *   exact     the share that shows, by area, in double
 *   disc      equal-area samples of a disc
 *   map       the same share after Maughan: sun map and intensity map on GL
 *   flare     lens-flare elements, on the CPU and on GL
 */
#ifndef GP_SUN_LIGHT_H
#define GP_SUN_LIGHT_H

#include <stdbool.h>

/* A light in one frame. */
struct gp_light {
    double x, y;       // centre, EXR pixel space; y down
    double radius;     // pixels, >= 0
    double depth;      // what is nearer hides it: in scene units as the depth
                       // channel counts them (along the view axis or along
                       // the ray; for normalized depth in its 0 to 1);
                       // INFINITY: a sun, beyond everything
    double bias;       // share of depth that may be nearer and hides nothing
    float flux[3];     // scene-linear, summed over pixels, >= 0
    bool behind;       // the camera: shows nothing, is drawn nowhere
    double visibility; // 0 hidden to 1 clear; written by exact and map
};
#define GP_LIGHT_DEFAULTS \
    { .radius = 0.5, .depth = INFINITY, .bias = 1e-3, .visibility = 1.0 }

/* Whether it has light to give: glare of its own, flare. */
static inline bool gp_light_has_flux(const struct gp_light *l)
{
    return !l->behind && (l->flux[0] > 0.0f || l->flux[1] > 0.0f ||
                          l->flux[2] > 0.0f);
}

/* The part of a light outside the frame, where nothing is known. */
enum gp_sun_outside {
    GP_OUTSIDE_IGNORE,  // the share is taken over the part inside; 0 where
                        // there is none
    GP_OUTSIDE_VISIBLE, // counts as clear
    GP_OUTSIDE_HIDDEN,  // counts as hidden
};

enum gp_sun_method {
    GP_SUN_EXACT,    // gp_sun_exact()
    GP_SUN_MASK,     // gp_sun_map_draw(): nothing returns before the end
    GP_SUN_READBACK, // gp_sun_readback()
};

/* Where the glare and flare of a mask's lights are drawn. */
enum gp_sun_draw {
    GP_DRAW_AUTO, // GL on a GPU; CPU on a software context
    GP_DRAW_GL,   // sprites and elements that fetch the share by themselves:
                  // nothing is read back before the layer is done
    GP_DRAW_CPU,  // the shares are read first; engines and CPU do the rest
};

enum gp_sun_pattern { GP_PATTERN_DISC, GP_PATTERN_SQUARE };

/* How the intensity map is summed. */
enum gp_sun_sum {
    GP_SUM_FLOAT,    // every texel, in float, times 1 / count
    GP_SUM_BYTE,     // in 8 bits, as in the paper: times 1 / 255, saturating
    GP_SUM_BILINEAR, // a quarter of the points, each the mean of 2x2 texels
};

struct gp_sun_params {
    enum gp_sun_method method;
    enum gp_sun_outside outside;
    enum gp_sun_pattern pattern;
    enum gp_sun_sum sum;
    enum gp_sun_draw draw;
    int map; // texels of a sun map's side, 2 to 256, even
};
#define GP_SUN_DEFAULTS { .map = 16 }

#endif
