/* Shared by the files of scene/sets and their tests, and private to them:
 * volumes, umbras, scissors, the renderer. */
#ifndef GP_SCENE_SETS_PRIV_H
#define GP_SCENE_SETS_PRIV_H

#include "core/minmax.h"
#include "scene/bounds.h"
#include "scene/sets/sets.h"

// -- convex volumes (hull.c) --------------------------------------------------

/* A light's place for hulls and umbras: at w = 1 a point, at w = 0 the unit
 * direction to a light at infinity. */
struct gp_from {
    struct gp_v3 p;
    double w;
};

/* Returns the way from a place to a light. */
static inline struct gp_v3 gp_from_to(struct gp_from light, struct gp_v3 p)
{
    return gp_v3_sub(light.p, gp_v3_scale(p, light.w));
}

/* A half-space: n . p + d <= 0 is inside; n is a unit vector that points out. */
struct gp_half {
    struct gp_v3 n;
    double d;
};

static inline double gp_half_at(struct gp_half h, struct gp_v3 p)
{
    return gp_v3_dot(h.n, p) + h.d;
}

/* Returns the distance of a light before a plane; of one at infinity the
 * cosine. Over 0 is outside. */
static inline double gp_half_before(struct gp_half h, struct gp_from light)
{
    return gp_v3_dot(h.n, light.p) + light.w * h.d;
}

/* Returns how far a box of half sides e reaches along a plane's normal. */
static inline double gp_half_reach(struct gp_half h, struct gp_v3 e)
{
    return fabs(h.n.x) * e.x + fabs(h.n.y) * e.y + fabs(h.n.z) * e.z;
}

static inline struct gp_half gp_half_turned(struct gp_half h)
{
    return (struct gp_half) {gp_v3_scale(h.n, -1.0), -h.d};
}

/* Finds the plane of p, a and b, with `inside` in it. False: a and b are along
 * one line, and *out is all of space. */
bool gp_half_span(struct gp_v3 p, struct gp_v3 a, struct gp_v3 b,
                  struct gp_v3 inside, struct gp_half *out);

/* The intersection of half-spaces, and a box around it; a frustum has 6, a hull
 * with a point at most 6 and one for each edge. */
struct gp_volume {
    int planes;
    struct gp_half plane[18];
    struct gp_box box; // infinite towards a directional light
    double slack;      // rounding: what misses by less still meets
};

/* Returns the frustum of a part of the picture, or its convex hull with a light:
 * the planes that have the light inside and one through the light for each edge
 * of the silhouette.
 *   part   not empty; far > near > 0
 *   light  NULL: none
 * Source: O'Rorke, GPU Gems 15.4.4; Everitt and Kilgard 2003. */
struct gp_volume gp_hull(const struct gp_sets_view *view,
                         const struct gp_scissor *part,
                         const struct gp_from *light);

/* True where a box of centre c and half sides e cannot meet the volume: it is
 * outside a plane, or of the volume's box. A box that misses all of the volume
 * beside an edge may count as one that meets it, never the other way round. */
bool gp_volume_misses(const struct gp_volume *v, struct gp_v3 c,
                      struct gp_v3 e);

/* A light made ready: a ball of its range, a spot's cut by its cone; of a
 * directional one all of space. */
struct gp_reach {
    struct gp_from from;   // place, or direction to it
    double range;          // INFINITY: none
    struct gp_v3 along;    // of a spot
    double cos, sin;       // of a spot's outer half angle; sin 0: no cone
    struct gp_box box;     // around the volume; may be infinite
};

struct gp_reach gp_light_reach(const struct gp_scene_light *light);

/* True where an object's box is beyond the range, or its sphere is outside the
 * cone. */
bool gp_reach_misses(const struct gp_reach *r, const struct gp_object *o);

/* False where the light's volume cannot meet a frustum. */
bool gp_reach_meets(const struct gp_reach *r, const struct gp_volume *v);

// -- umbras (umbra.c) ---------------------------------------------------------

/* Bodies of a scene's meshes, and the umbras that they throw before one light: a
 * body is a closed convex polyhedron of at most 64 points, opaque everywhere. */
struct gp_umbras;

/* Errors: GP_ERR_BUG memory is full. Out: NULL; close it in any case. */
GP_MUST_CHECK gp_status gp_umbras_open(const struct gp_log *log,
                                       const struct gp_scene *s,
                                       struct gp_umbras **out);
void gp_umbras_close(struct gp_umbras **u);

/* Makes the umbras of the objects with GP_SET_L that are bodies and look largest
 * from a light; of those of one size of the first of the scene. `flag` NULL: of
 * none. */
void gp_umbras_light(struct gp_umbras *u, const uint8_t *flag,
                     struct gp_from light);

/* True where an umbra holds a box of centre c and half sides e. */
bool gp_umbras_hold(const struct gp_umbras *u, struct gp_v3 c, struct gp_v3 e);

// -- bounds on the screen, and scissors (scissor.c) ---------------------------

/* Returns the pixels of the window whose centres may show the part of a box at
 * view->near or beyond, and its depths. The box is not empty. */
struct gp_scissor gp_box_project(const struct gp_sets_view *view,
                                 const struct gp_box *box);

/* Parts by which depths may be wrong: 2^-10 holds those stored as half. */
#define GP_DEPTH_SLACK 0x1p-10

enum { GP_TILE = 16 }; // pixels a side

/* Depths of the frame, by pixels and tiles; INFINITY where there is no
 * surface. */
struct gp_depths {
    struct gp_rect window;
    int across, down;     // tiles; 0: no depth is known, nothing is hidden
    float *pixel;         // owned
    struct gp_depth_tile {
        float least, most; // of all pixels
        float deepest;     // of surfaces; 0: there is none
    } *tile;              // owned
};

/* Copies depths, as of gp_sets_view.
 *   out  empty on failure; free with gp_depths_free()
 * Errors: GP_ERR_BUG memory is full. */
GP_MUST_CHECK gp_status gp_depths_make(const struct gp_log *log,
                                       struct gp_rect window,
                                       const float *depth,
                                       struct gp_depths *out);
void gp_depths_free(struct gp_depths *d);

/* Returns the greatest depth of a surface, with its slack; 0: there is none. */
double gp_depths_deepest(const struct gp_depths *d);

/* True where bounds are behind the surfaces of all of their pixels, or have none:
 * no pixel's centre can show a part of what is in them. */
bool gp_depths_hide(const struct gp_depths *d, const struct gp_scissor *b);

/* Returns the part of bounds in the tiles that have depths in them, from the
 * least to the greatest of these. Without depths all of it. */
struct gp_scissor gp_depths_cut(const struct gp_depths *d,
                                const struct gp_scissor *of);

/* Returns the bounds of n objects, those of `index`, within a light's.
 * Source: O'Rorke, GPU Gems 15.5. */
struct gp_scissor gp_scissor_join(const struct gp_scissor *box,
                                  const int *index, int n,
                                  const struct gp_scissor *light);

// -- the paper's renderer (draw.c) --------------------------------------------
//
// A pass of ambient light that sets the depth, then for each light its map of
// shadows and a pass over the lit objects. It draws the objects that it is
// given, in that order, and counts.

/* A light and what it is drawn with: indices of objects. */
struct gp_draw_light {
    const struct gp_scene_light *light;
    const int *shadow, *lit;
    int shadows, lits;
    struct gp_rect cut; // pixels that its pass may change
    const struct gp_rect *own; // ... of each lit object; NULL: cut
    double near, far;   // distances along the view axis that it may change; far
                        // INFINITY: no limit. Counts where the context's info
                        // has depth_bounds
    struct gp_box all;  // of a sun: holds every lit object, the same for every
                        // choice of them: its map is laid over it
};

struct gp_drawing; // a scene on a context

/* Uploads the posed scene's meshes; its places are read at each draw.
 *   log, gl, s, c  borrowed
 *   out       written on GP_OK only; end with gp_drawing_close()
 * Errors: GP_ERR_GL what the context refuses; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_drawing_open(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct gp_drawing_params *p, struct gp_drawing **out);
void gp_drawing_close(struct gp_drawing **d);

/* Makes the picture black and infinitely far, and sets the counts to 0. */
void gp_drawing_clear(struct gp_drawing *d);

/* Draws objects in ambient light; may be called several times. */
GP_MUST_CHECK gp_status gp_drawing_ambient(struct gp_drawing *d,
                                           const int *object, int n);

/* Draws a light: its map and its pass. One with lits 0 is skipped. */
GP_MUST_CHECK gp_status gp_drawing_light(struct gp_drawing *d,
                                         const struct gp_draw_light *l);

/* Waits until all is drawn. */
void gp_drawing_wait(struct gp_drawing *d);

/* Waits, then copies distances along the view axis, w * h, INFINITY where there
 * is no surface; and the picture, w * h * 4, scene-linear. */
void gp_drawing_depth(struct gp_drawing *d, float *z);
void gp_drawing_picture(struct gp_drawing *d, float *rgba);

struct gp_drawn gp_drawing_counts(const struct gp_drawing *d);

#endif
