/* Shared by the files of sun, and private to them: floats in order, areas of
 * discs, the sun map's state, and quads of flare elements. */
#ifndef GP_SUN_PRIV_H
#define GP_SUN_PRIV_H

#include "gl/gl.h"
#include "sun/flare.h"
#include "sun/map.h"
#include "sun/stage.h"

#include <stdint.h>
#include <string.h>

// -- depth samples (occluder.c) ----------------------------------------------

/* Floats in order as whole numbers, and back; -0 and 0 are one. */
static inline int32_t gp_float_order(float v)
{
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits < 0 ? INT32_MIN - bits : bits;
}

static inline float gp_float_of(int32_t k)
{
    const int32_t bits = k < 0 ? INT32_MIN - k : k;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

// -- discs (exact.c) ---------------------------------------------------------

/* Maps (u, v) in [0, 1)^2 to the square [-1, 1]^2, or to the unit disc by
 * the concentric map (Shirley and Chiu 1997), which keeps areas' ratios.
 * Texel (i, j) of an n x n sun map is the cell [i, i+1)/n x [j, j+1)/n. */
void gp_pattern_place(enum gp_sun_pattern pattern, double u, double v,
                      double *x, double *y);

/* Area of the disc of radius r around (cx, cy) within [x0, x1) x [y0, y1),
 * integers, in closed form; 0 for r <= 0, NaN, and empty rectangles. The
 * disc's edge is placed to 1e-12 of a pixel for r and distances up to 1e5. */
double gp_disc_rect_area(double cx, double cy, double r, double x0, double y0,
                         double x1, double y1);

/* Divides the pixels of the frame in which a plane has samples, and `margin` (0
 * or 1) more on each side, into rectangles that do not overlap; some may be
 * empty. Returns how many. */
enum { GP_SUN_PARTS = 5 };
int gp_sun_parts(const struct gp_occluders *o, int margin,
                 struct gp_rect part[GP_SUN_PARTS]);

// -- lights in pixels of the frame, and the pixels under them (map_pixels.c) -

/* Place on the scale of depth of a pixel without surface, and of a light
 * beyond everything; surfaces are under it. Known to sun_map.frag as EMPTY. */
#define GP_SUN_EMPTY 3.4e38f

/* Samples are moved so many pixels right and down. A sample is often on the
 * line between two pixels (whole positions and radii); this decides which one
 * it reads, whatever the rounding. */
#define GP_SUN_NUDGE (1.0 / 1048576.0)

/* A light as sun_map.frag sees it. Places are from o->frame's first pixel. */
struct gp_map_light {
    double x, y, radius; // pixels, each the sum of two floats; 1e8 at most
    int k;               // samples along a texel's side; 0: invisible, as it
                         // is behind the camera or its place is not finite
    float limit;         // surfaces at a place under it hide the light
    struct gp_rect box;  // pixels that its samples read; may be empty
    float outside[2];    // gp_map_outside(); 0 where the place is not finite
    int slot_x, slot_y;  // place of box in the texture, pixels; even x
};

struct gp_map_light gp_map_light_of(const struct gp_occluders *o, int map,
                                  const struct gp_light *l);

/* Pixel of coordinate `at`, -1 or `size` outside of [0, size). */
int gp_map_pixel_at(double at, int size);

/* Sets the r and g of a light's samples outside the frame: shown * weight,
 * weight. Those of a light behind the camera are all of its map. */
void gp_map_outside(enum gp_sun_outside outside, const struct gp_light *l,
                    float count[2]);

/* The texture of pixels under the lights: two a texel, w x h texels. */
struct gp_map_pixels {
    bool whole; // the frame once; else each light's box
    int w, h;
};

/* Gives each box its slot, in rows of boxes, or all of them the frame's where
 * that is less. Errors: GP_ERR_GL over `most` texels wide or high. */
GP_MUST_CHECK gp_status gp_map_pack(
    const struct gp_log *log, const struct gp_occluders *o,
    struct gp_map_light *light, int n, int most, struct gp_map_pixels *out);

// -- the sun map's state on a context (map.c) --------------------------------

enum gp_sun_program {
    GP_SUN_TEXELS,          // sun map
    GP_SUN_PIXELS,          // a region for readback
    GP_SUN_POINTS,          // as enum gp_sun_sum from here
    GP_SUN_POINTS_BYTE,
    GP_SUN_POINTS_BILINEAR,
    GP_SUN_TOTAL,           // sums to intensity
    GP_SUN_PROGRAMS,
};

enum { GP_SUN_BAND = 1 << 18 }; // texels that are written at a time

struct gp_sun_map {
    struct gp_program program[GP_SUN_PROGRAMS]; // made when first used
    struct gp_texture pixels, lights;           // see sun_map.frag
    struct gp_target atlas;      // sides are powers of two, so that the middle
                                 // between texels is exact in float
    struct gp_target region;     // for readback
    struct gp_target sums, byte_sums; // a pixel for each map of the atlas
    struct gp_target intensity;       // n x 1, RGBA32F, of the last draw
    struct gp_map_light light[GP_LIGHTS_MAX];
    float *band;                 // GP_SUN_BAND texels; owned
    int n, map, columns;         // of the last draw; map 0: a readback
};

/* Makes *state and what a frame of n lights needs but the atlas: lights and
 * pixels written, intensity of n x 1. Errors: as gp_sun_map_draw(). */
GP_MUST_CHECK gp_status gp_map_begin(
    const struct gp_log *log, const struct gp_gl *gl,
    const struct gp_occluders *o, const struct gp_map_params *p,
    const struct gp_light *light, int n, struct gp_sun_map **state);
GP_MUST_CHECK gp_status gp_map_use(const struct gp_log *log,
    const struct gp_gl *gl, struct gp_sun_map *s, enum gp_sun_program which);

/* Writes all boxes to s->pixels, which is made to fit. */
GP_MUST_CHECK gp_status gp_map_write_pixels(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_occluders *o,
    const struct gp_map_pixels *pixels, struct gp_sun_map *s, int n);

// -- flare: closed forms of elements (element.c) ------------------------------

enum { GP_FLARE_SIDES = 64 };

/* In [0, 1), the same for the same seed and i. */
double gp_flare_random(int seed, int i);

/* A ray of a streak or of spikes, in the element's axes. */
struct gp_flare_ray {
    float c, s;   // direction
    float per_t;  // entries of the table in a pixel along it
    float half;   // of its width, pixels
    float steep;  // of its edges, in a pixel
};

/* An element, not an image, at one size: tables of its profile, in square
 * pixels' light for a sum of `area`. */
struct gp_flare_look {
    struct gp_flare_element e;  // borrows
    double diameter;            // asked for, pixels
    double radius, reach;       // pixels; of the profile, in radii
    double aspect, per_t;       // entries of the table in a radius
    float share;                // 1 / radius
    float across;               // pixels across an edge for 1 of the norm
    float edge[6];              // hard edges, in radii; `edges` of them
    int edges;
    bool flat;                  // a ring without profile, drawn without table:
    float outer[3], inner[3];   // its radii in pixels, and the light between
    float weight[3];
    int n;                      // entries of the table: [entry][channel]
    float *table;               // owned
    float side[GP_FLARE_SIDES][2]; // of a polygon: normal over its distance
    struct gp_flare_ray *ray;   // owned
    double *ray_area;           // owned; length in radii of each
    int rays;
    double area[3];             // sum over an unbounded plane
};
GP_MUST_CHECK gp_status gp_flare_look_make(const struct gp_log *log,
    const struct gp_flare_element *e, double diameter,
    struct gp_flare_look *out);
void gp_flare_look_free(struct gp_flare_look *l);

/* Pixels from the place, in any direction, beyond which the element is 0. */
double gp_flare_look_reach(const struct gp_flare_element *e, double diameter);

/* Pixels from the middle of ray i across it, beyond which it is 0. */
double gp_flare_ray_width(const struct gp_flare_look *l, int i);

// -- flare: elements made ready for the lights of one frame (flare.c) --------

/* Distance in [0, 1] that by_place measures, of a light at (x, y). */
double gp_flare_place_share(const struct gp_flare_by_place *b, double x,
                            double y, struct gp_rect display);

/* Factor of an element's brightness in a frame. */
double gp_flare_flicker(const struct gp_flare_element *e, int frame);

/* Texture of an image at half size, `level` times. */
struct gp_flare_level {
    struct gp_flare_image image; // rgb owned when level > 0, else borrowed
    int level;
    double sum[3], luminance;    // of the whole image, level 0; 0 when not
                                 // finite or not over 0: draws nothing
};

/* The level at which `size` of the longer side in pixels is not under a pixel
 * a texel, with its sums. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_flare_level_make(const struct gp_log *log,
    const struct gp_flare_image *image, double size,
    struct gp_flare_level *out);

/* The quad of one element of one light. */
struct gp_flare_quad {
    bool plain;
    int element, light;
    const struct gp_flare_look *look; // NULL: an image
    struct gp_rect rect;  // pixels of the frame that it may reach; not empty
    double x, y;          // place, EXR pixel space
    float base[2];        // centre of pixel (rect.x0, rect.y0) less the place
    float turn[2];        // cosine and sine of the rotation
    float radius;         // image: texels a pixel
    float inner[2];       // image: the place in texels
    int corner[2];        // plain: texel of pixel (rect.x0, rect.y0), whose
    float fraction[2];    // weight is 1 - fraction, and the next one's it
    float cut[2];         // radii by which the pupil's rim is moved
    float dirt[4];        // texels a pixel, and the place in texels
    float amount[3];      // light where the value or sample is 1, when clear
    const struct gp_flare_image *image; // of the quad's level; dirt
};

struct gp_flare_quads {
    struct gp_flare_quad *at;     // owned; in the order of lights, elements
    int n;
    struct gp_flare_look *look;   // owned; room for one a quad
    int looks;
    int *last;                    // owned; last look of each element, from 1
    struct gp_flare_level *level; // owned; one an element
    int elements;
};

/* All that is not empty, at full visibility; with `clear` only of lights whose
 * visibility is over 0. Elements of f are not needed afterwards, but plain
 * images and such as are drawn at their own size or larger. Free with
 * gp_flare_quads_free(), after a failure too. Errors: GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_flare_quads_make(const struct gp_log *log,
    const struct gp_flare *f, const struct gp_light *light, int n, bool clear,
    struct gp_rect frame, struct gp_rect display, struct gp_flare_quads *out);
void gp_flare_quads_free(struct gp_flare_quads *quads);

/* The pixels of `frame` (data window) that element e, as light l sees it, may
 * reach; empty when it reaches none. `display` gives centre and height. */
struct gp_rect gp_flare_reach(const struct gp_flare_element *e,
    const struct gp_light *l, struct gp_rect frame, struct gp_rect display);

/* Columns [*x0, *x1) outside of which the quad reaches nothing in rows
 * [y0, y1); cut to its rect. false: nothing at all. */
bool gp_flare_span(const struct gp_flare_quad *q, int y0, int y1, int *x0,
                   int *x1);

/* The same of an image's channel c: adds amount * sample in row y to out[0] =
 * column x0, and on to x1; both inside the quad's rect. */
void gp_flare_add_row(const struct gp_flare_quad *q, int c, int y, int x0,
                      int x1, float amount, float *out);

/* Adds amount * value of all channels in row y to out[c][0] = column x0, and on
 * to x1; both inside the quad's rect. The quad has a look. */
void gp_flare_look_row(const struct gp_flare_quad *q, int y, int x0, int x1,
                       const float amount[3], float *const out[3]);

/* Bilinear sample at a place in texels; 0 outside. */
float gp_flare_sample(const struct gp_flare_image *m, int c, float x, float y);

// -- lights as sources and sprites (stage_light.c) ---------------------------

/* Weights of the (2m+1) x (2m+1) pixels around a disc's centre pixel, whose
 * sum is 1; one pixel for a radius up to 1/2. */
struct gp_disc_pixels {
    int m;
    float *weight; // owned: gp_free()
};
GP_MUST_CHECK gp_status gp_disc_pixels_make(
    const struct gp_log *log, double radius, struct gp_disc_pixels *out);

/* The pixels of `frame` that a light's disc falls on, each with its share of
 * flux * visibility: the weights above, moved to the light's place by bilinear
 * shares, which keep flux and centroid. Appends to list[*n], which has room
 * for gp_disc_room() more. */
size_t gp_disc_room(double radius); // pixels of a disc, at most
void gp_disc_light(const struct gp_disc_pixels *d, const struct gp_light *l,
                   struct gp_rect frame, struct gp_source *list, size_t *n);

void gp_suns_drop_sprites(struct gp_suns *suns);

#endif
