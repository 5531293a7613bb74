/* Writes the report: JSON, one object a line for each frame. */
#ifndef GP_APP_REPORT_H
#define GP_APP_REPORT_H

#include "app/jobs.h"
#include "core/frame.h"
#include "core/status.h"
#include "glare/engine.h"
#include "glare/model/model.h"
#include "io/read.h"
#include "sun/lens.h"
#include "sun/lights.h"
#include "tone/ocio.h"

#include <stdbool.h>
#include <stdio.h>

/* Stages that are timed, in their order. */
enum gp_time {
    GP_TIME_READ,
    GP_TIME_SCENE,
    GP_TIME_RELIGHT,
    GP_TIME_SUN,
    GP_TIME_SENSORS,
    GP_TIME_KERNEL, // of frames that none kept fits
    GP_TIME_GLARE,
    GP_TIME_LENS,
    GP_TIME_COMPOSE,
    GP_TIME_TONEMAP,
    GP_TIME_WRITE,
    GP_TIME_TOTAL,
    GP_TIMES,
};

struct gp_settings;

/* Of the frame's job and its end. */
struct gp_job_facts {
    bool numbered;
    int frame;                   // when numbered
    const char *view;            // of stereo, or NULL
    const char *input;
    const char *style;           // NULL: left out
    char *command;               // that makes the picture again; owned, or NULL
    const struct gp_settings *settings; // of the run; NULL: left out
    const char *views;           // line about the views of the run, or NULL
    const char *warned;          // `warned_bytes` of lines, each with its null
    size_t warned_bytes;         // byte
    gp_status status;
    const char *error;           // the message of a frame that failed
};

/* Of the stage that reads. */
struct gp_read_facts {
    struct gp_taken taken;       // part, layer and view of the input
    const char *const *group;    // `groups` layers that glare
    int groups;                  // 0: the frame's own colour glares
    struct gp_rect window;       // data window of the outputs
    int width, height;           // of it
    bool grown;                  // the file's differs
    struct gp_rect file;         // data window of the file
};

/* Luminance summed over pixels, for words; all 0: not measured. */
struct gp_spread {
    double light;                // of the frame as it was read
    double bright, lamps;        // that the kernel spreads: of bright pixels, of
                                 // lights
};

/* Of the light that glares. */
struct gp_sensor_facts {
    long long sources;           // bright pixels, and pixels of lights
    double flux[3];              // of the sources, by channel
    double faint[3];             // light under FLT_MIN, which counts as 0
    struct gp_spread spread;
    long long nonfinite;         // pixels of the input
    float threshold;             // as luminance
    bool dark;                   // glare was wanted, no pixel is a source
    float peak;                  // largest luminance of a dark frame
    int peak_at[2];              // its pixel, in EXR pixel space
};

/* Of light that --max-value and the types of outputs removed. */
struct gp_clamp_facts {
    struct {
        long long pixels;        // of the input over --max-value
        long long values;        // that an output's type cannot hold
    } n;
    double flux[3];              // by channel
};

/* Of the kernel of a frame, and its angle of view; 0 x 0: none was needed. */
struct gp_kernel_facts {
    const struct gp_recipe *recipe; // `recipes` of them
    int recipes;                 // 0: an image
    double pupil[GP_RECIPES];    // of each, mm; 0: it has none
    int w, h;                    // samples at full rate: all, or the core
    int grid;                    // pixels between the others; 0: no others
    bool modelled;               // the next two are known
    double left_out;             // a model's light outside of what is computed
    double missed;               // of which falls in the frame
    double faint[3];             // magnitudes under FLT_MIN
    double deg_per_pixel;        // 0: the kernel is an image
    double fov;                  // vertical angle of view, degrees
    const char *fov_from;        // "option", "camera", "lens", "default"
};

/* Of the flare of bright pixels. Its bound is of rel_l2 of that part of the
 * layer: the engines' bounds of each run, and its gp_ghost.split. */
struct gp_flare_facts {
    int elements, runs;          // runs 0: none was needed
    const char *engine;          // of all runs; "several"
    double bound, ms;
};

/* Of the layer inside the frame. */
struct gp_layer_facts {
    double flux[3];
    bool bounded;
    double bound;                // of rel_l2, with what a lens leaves out
    bool verified;
    struct gp_glare_error error; // when verified
};

/* Of the ghosts of a lens. */
struct gp_lens_facts {
    const char *name;            // NULL: no --lens
    double sensor;               // width of the display window on it, mm
    const char *sensor_from;     // "option", "angle", "attribute", "lens"
                                 // or "default"
    double rest;                 // share of the sources that has no ghosts
    double bound;                // of rel_l2 of the layer, of what is left out
    struct gp_lens_stats stats;
};

/* Of a light of --relight. */
struct gp_relit_facts {
    const char *name;
    long long pixels;            // that got light
    long long rays;              // cast for its shadows and edges
    int casters;                 // objects that may cast its shadows
};

/* Of the scene that a frame was posed from. */
struct gp_scene_facts {
    const char *path;            // NULL: no scene
    double seconds;              // posed at
    const char *camera;          // of the scene, where the frame has none
    bool compared;               // both have one
    double apart;                // pixels between the two
    struct gp_relit_facts *relit; // `relits`, in the scene's order; owned
    int relits;                  // 0: no --relight
};

/* Measure of the edges before the lights that the frame shows, by which the
 * report says how near their shares are. */
enum gp_edges {
    GP_EDGES_NONE, // no light is in the frame, or nothing hides any
    GP_EDGES_DEPTH,
    GP_EDGES_COVERAGE, // and depth
    GP_EDGES_MASK,     // coverage without depth
};

/* Of lights and of what hides them. */
struct gp_sun_facts {
    struct gp_light *light;      // `lights` of them, owned; NULL: none asked for
    int lights;
    const char *way;             // sun_method, and where lights were drawn
    const char *gl;              // context of the lights, or NULL
    enum gp_edges edges;
    char *depth;                 // channel, owned, or NULL
    const char *depth_type;      // NULL: the frame has light
    char empty[64];              // depths that count as no surface; "": no light
    bool reversed;               // larger is nearer
    char *mask;                  // coverage channel, owned, or NULL
};

/* Of the files written. */
struct gp_write_facts {
    char **name;                 // `n`, then the one being written, then NULL;
                                 // all owned
    enum gp_target_kind *kind;   // of each; owned
    int n;
};

/* Of what the frame cost. */
struct gp_cost_facts {
    size_t bytes;                // estimated memory of the frame in flight
    double ms[GP_TIMES];         // negative: the stage was not needed
    double cpu_ms[GP_TIMES];     // of all threads
    bool has_cpu;                // one frame was in flight, so that it is known
};

/* Adds to the time of a stage, an enum gp_time; under 0 is none. */
void gp_cost_add(struct gp_cost_facts *c, int time, double ms, double cpu);

/* The facts about one frame, a struct a stage, which fills it. Strings and lists
 * are borrowed where none says owned. */
struct gp_facts {
    struct gp_job_facts job;
    struct gp_read_facts read;
    struct gp_sensor_facts sensor;
    struct gp_clamp_facts clamp;
    struct gp_kernel_facts kernel;
    struct gp_glare_stats glare; // engine NULL: no glare stage
    struct gp_flare_facts flare;
    struct gp_layer_facts layer;
    struct gp_lens_facts lens;
    struct gp_scene_facts scene;
    struct gp_sun_facts sun;
    const struct gp_ocio_names *ocio; // NULL: tone mapped
    struct gp_write_facts write;
    struct gp_cost_facts cost;
};

struct gp_report {
    FILE *file;        // NULL: closed
    const char *path;  // borrowed; "-" is stdout
    char *created;     // owned: the file that did not exist; NULL: it did
    bool given;        // an open descriptor's, whose file is never cut
    bool append;
    long long lines;
};

/* Opens the file, in folders that are made if `create_dir`. Its old lines are
 * removed with the first new one, not before; with `append` they stay. Errors:
 * GP_ERR_IO with the system's reason. */
GP_MUST_CHECK gp_status gp_report_open(const struct gp_log *log,
    const char *path, bool create_dir, bool append, struct gp_report *out);

/* Appends one line and flushes it. Fields that were not needed are left out;
 * NaN and Inf are null; bytes of names that are not UTF-8 become U+FFFD. The
 * line of a frame that failed has what its job and its end say, no more.
 * Errors: GP_ERR_IO (full disk, closed pipe); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_report_frame(const struct gp_log *log,
    struct gp_report *r, const struct gp_facts *facts);

/* Closes the file, and removes it if this run made it and wrote no line. A
 * closed or zeroed report is fine. Errors: GP_ERR_IO. */
gp_status gp_report_close(const struct gp_log *log, struct gp_report *r);

/* The i-th field's name, "kernel.grid" in an object; NULL after the last. */
const char *gp_report_field(int i);

/* Formats the warning that no pixel of `frames` frames is over the threshold,
 * f being of the brightest. The report has it for each dark frame. */
void gp_facts_dark(const struct gp_facts *f, int frames, char *line,
                   size_t size);

#endif
