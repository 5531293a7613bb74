/* O'Rorke's Table 15-1 for a scene: the paper's renderer with one test of
 * visibility after another. Every row draws the same picture. */
#ifndef GP_SCENE_TABLE_H
#define GP_SCENE_TABLE_H

#include "scene/draw.h"

/* Rows, each with all parts of those before it. */
enum gp_table_kind {
    GP_TABLE_FRUSTUM,   // V is F; L is what a light reaches, S is L
    GP_TABLE_OCCLUSION, // V by depth; lights that reach nothing of V are left
                        // out
    GP_TABLE_LIGHTS,    // L by umbras
    GP_TABLE_SHADOWS,   // S by the hull of the light and of what it lights
    GP_TABLE_SCISSOR,
    GP_TABLE_ROWS,
};
extern const char *const gp_table_names[GP_TABLE_ROWS];

struct gp_table_row {
    struct gp_drawn drawn;
    long long fragments; // -1: the context does not count
    double ms;           // the fastest of the runs: sets, drawing, and the wait
                         // for it
    double cpu_ms;       // the least of the runs, of all threads
    int visible;         // objects of V
    int lit, casters;    // of I and of S, summed over the lights
    int batches[2];      // of V, I and S by their submeshes; [1]: opaque ones
                         // of a caster in one
    bool same;           // its picture has the bytes of the first row's
};

struct gp_table_params {
    struct gp_drawing_params draw;
    int runs;      // timed runs of all rows in turn, >= 1, after one that is not
    int occluders; // objects that are drawn first, for V by depth, >= 0: those
                   // that look largest
};
#define GP_TABLE_DEFAULTS                                                     \
    { .draw = GP_DRAWING_DEFAULTS, .runs = 3, .occluders = 40 }

/* A light of the last row. */
struct gp_table_light {
    int light;           // index
    struct gp_rect rect; // its scissor; empty: the light is left out
    double near, far;
};

struct gp_table {
    struct gp_table_row row[GP_TABLE_ROWS];
    float *picture;              // w * h * 4, scene-linear; owned
    struct gp_table_light *light; // of all lights; owned
    unsigned char *set;          // of all objects: GP_SET_*, I and S of any
                                 // light; owned
};

/* Draws all rows.
 *   s    posed
 *   out  written on GP_OK only; free with gp_table_free()
 * V by depth: the objects that look largest are drawn first, V is found by their
 * depth and drawn, and found again by the depth of the whole picture for the
 * lights.
 * Errors: those of gp_drawing_open(); GP_ERR_BUG memory. */
GP_MUST_CHECK gp_status gp_table_make(const struct gp_log *log,
    const struct gp_gl *gl, const struct gp_scene *s, const struct gp_camera *c,
    const struct gp_table_params *p, struct gp_table *out);
void gp_table_free(struct gp_table *t);

#endif
