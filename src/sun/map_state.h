/* What the files of sun/map share: where lights fall, what is uploaded for
 * them, and what is kept on a context from frame to frame. */
#ifndef GP_SUN_MAP_STATE_H
#define GP_SUN_MAP_STATE_H

#include "gl/gl.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "sun/map.h"

/* Place on the scale of depth of a pixel without surface, and of a light
 * beyond everything; surfaces lie under it. Known to sun_map.frag as EMPTY. */
#define GP_SUN_EMPTY 3.4e38f

/* Pixels that samples are moved to the right and down. A sample often lies on
 * the line between two pixels (whole positions and radii); this settles which
 * of them it reads, the same for every way to round. */
#define GP_SUN_NUDGE (1.0 / 1048576.0)

/* -- lights in pixels of the frame (map_spot.c) ----------------------------*/

/* A light as sun_map.frag sees it. Places are from o->frame's first pixel. */
struct gp_sun_spot {
    double x, y, radius; // pixels, each the sum of two floats; 1e8 at most
    int k;               // samples along a texel's side; 0: shows nothing, as
                         // it is behind the camera or its place is no number
    float limit;         // surfaces at a place under it hide the light
    struct gp_rect box;  // pixels that its samples read; may be empty
    int slot_x, slot_y;  // where box lies in what is uploaded, pixels; even x
};

struct gp_sun_spot gp_sun_spot_of(const struct gp_occluders *o, int map,
                                  const struct gp_light *l);

/* Pixel of coordinate `at`, -1 or `size` outside of [0, size). */
int gp_sun_pixel(double at, int size);

/* What counts for samples outside the frame: shown times weight, weight. */
void gp_sun_outside_counts(enum gp_sun_outside outside, float count[2]);

/* What is uploaded: two pixels a texel, w x h texels. */
struct gp_sun_upload {
    bool whole; // the frame once; else each light's box
    int w, h;
};

/* Gives each box its slot, in rows of boxes, or all of them the frame's where
 * that is less. Errors: GP_ERR_GL over `most` texels wide or high. */
GP_MUST_CHECK gp_status gp_sun_pack(const struct gp_log *log,
                                    const struct gp_occluders *o,
                                    struct gp_sun_spot *spot, int n, int most,
                                    struct gp_sun_upload *out);

/* -- kept on a context (map_state.c) ----------------------------------------*/

enum gp_sun_program {
    GP_SUN_TEXELS,          // sun map
    GP_SUN_PIXELS,          // a region for readback
    GP_SUN_POINTS,          // as enum gp_sun_sum from here
    GP_SUN_POINTS_BYTE,
    GP_SUN_POINTS_BILINEAR,
    GP_SUN_TOTAL,           // sums to intensity
    GP_SUN_PROGRAMS,
};

enum { GP_SUN_BAND = 1 << 18 }; // texels that are uploaded at a time

struct gp_sun_map {
    struct gp_program program[GP_SUN_PROGRAMS]; // made when first used
    struct gp_texture pixels, lights;           // see sun_map.frag
    struct gp_target atlas;      // sides are powers of two, so that the middle
                                 // between texels is exact in float
    struct gp_target region;     // for readback
    struct gp_target sums, byte_sums; // a pixel for each map of the atlas
    struct gp_target intensity;       // n x 1
    struct gp_sun_spot spot[GP_LIGHTS_MAX];
    float *band;                 // GP_SUN_BAND texels; owned
    int n, map, columns;         // of the last draw; map 0: a readback
};

/* Makes *state and what a frame of n lights needs but the atlas: spots packed
 * and uploaded, intensity of n x 1. Errors: as gp_sun_map_draw(). */
GP_MUST_CHECK gp_status gp_sun_begin(const struct gp_log *log,
                                     const struct gp_gl *gl,
                                     const struct gp_occluders *o,
                                     const struct gp_sun_params *p,
                                     const struct gp_light *light, int n,
                                     struct gp_sun_map **state);
GP_MUST_CHECK gp_status gp_sun_use(const struct gp_log *log,
                                   const struct gp_gl *gl,
                                   struct gp_sun_map *s,
                                   enum gp_sun_program which);

/* Uploads all boxes to s->pixels (map_upload.c), which is made to fit. */
GP_MUST_CHECK gp_status gp_sun_upload(const struct gp_log *log,
                                      const struct gp_gl *gl,
                                      const struct gp_occluders *o,
                                      const struct gp_sun_upload *u,
                                      struct gp_sun_map *s, int n);

#endif
