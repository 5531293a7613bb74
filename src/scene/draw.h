/* The paper's renderer (O'Rorke 15.2.2) on GL: a pass of ambient light that sets
 * the depth, then for each light its map of shadows and a pass over the lit
 * objects. It draws the objects that it is given, in that order, and counts. */
#ifndef GP_SCENE_DRAW_H
#define GP_SCENE_DRAW_H

#include "core/frame.h"
#include "gl/gl.h"
#include "scene/scene.h"

#include <stdbool.h>

struct gp_drawing_params {
    int w, h;           // of the picture
    double near;        // of the picture, > 0: surfaces nearer are not drawn
    double light_scale; // the picture's units a cd or lux
    double ambient;     // light that comes back from white, everywhere
    int map;            // side of a map's square, texels, >= 8
    bool separate;      // a shadow batch for each submesh; else one for all
                        // opaque ones of an object (15.2.2)
};
#define GP_DRAWING_DEFAULTS                                                   \
    { .w = 960, .h = 540, .near = 0.1, .light_scale = 1.0 / 683.0,            \
      .ambient = 0.02, .map = 256 }

/* Counts of what was drawn. A batch is a draw call. */
struct gp_drawn {
    int batches, shadow_batches; // all of them, and those of maps
    int passes;                  // ambient pass, maps, passes of lights
    int lights;                  // that were drawn
};

/* A light and what it is drawn with: indices of objects. */
struct gp_draw_light {
    const struct gp_scene_light *light;
    const int *shadow, *lit;
    int shadows, lits;
    struct gp_rect cut; // pixels that its pass may change
    const struct gp_rect *own; // ... of each lit object; NULL: cut
    const struct gp_box *seen; // hold all that its pass may change: only parts
    int seen_n;                // of a map that they can look up are drawn; 0:
                               // all of it
    double near, far;   // distances along the view axis that it may change; far
                        // INFINITY: no limit. Counts where the context's info
                        // has depth_bounds
    struct gp_box all;  // of a sun: holds every lit object, the same for every
                        // choice of them: its map is laid over it
};

struct gp_drawing; // a scene on a context

/* Uploads the posed scene's meshes; its places are read at each draw.
 *   gl, s, c  borrowed
 *   out       written on GP_OK only; end with gp_drawing_close()
 * Errors: GP_ERR_GL what the context refuses; GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_drawing_open(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct gp_drawing_params *p, struct gp_drawing **out);
void gp_drawing_close(struct gp_drawing **d);

/* Makes the picture black and infinitely far, and sets the counts to 0. */
void gp_drawing_clear(struct gp_drawing *d);

/* Draws objects in ambient light; may be called several times. */
GP_MUST_CHECK gp_status gp_drawing_ambient(const struct gp_log *log,
    struct gp_drawing *d, const int *object, int n);

/* Draws a light: its map and its pass. One with lits 0 is skipped. */
GP_MUST_CHECK gp_status gp_drawing_light(const struct gp_log *log,
    struct gp_drawing *d, const struct gp_draw_light *l);

/* Waits until all is drawn. */
void gp_drawing_wait(struct gp_drawing *d);

/* Waits, then copies distances along the view axis, w * h, INFINITY where there
 * is no surface; and the picture, w * h * 4, scene-linear. */
void gp_drawing_depth(struct gp_drawing *d, float *z);
void gp_drawing_picture(struct gp_drawing *d, float *rgba);

struct gp_drawn gp_drawing_counts(const struct gp_drawing *d);

#endif
