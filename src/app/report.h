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

#include <jansson.h>
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
    GP_TIMES,
};

/* Facts about the flare of bright pixels. Its bound is of rel_l2 of that part
 * of the layer: the engines' bounds of each run, and its gp_ghost.split. */
struct gp_flare_facts {
    int elements, runs;  // runs 0: none was needed
    const char *engine;  // of all runs; "several"
    double bound, ms;
};

struct gp_settings;

/* Luminance summed over pixels, for words; all 0: not measured. */
struct gp_spread {
    double light;                // of the frame as it was read
    double bright, lamps;        // that the kernel spreads: of bright pixels, of
                                 // lights
};

/* The kernel of a frame; 0 x 0: none was needed. */
struct gp_kernel_facts {
    const struct gp_recipe *recipe; // `recipes` of them, borrowed
    int recipes;                 // 0: an image
    double pupil[GP_RECIPES];    // of each, mm; 0: it has none
    int w, h;                    // samples at full rate: all, or the core
    int grid;                    // pixels between the others; 0: no others
    bool modelled;               // the next two are known
    double left_out;             // a model's light outside of what is computed
    double missed;               // of which falls in the frame
};

/* Facts about the ghosts of a lens. */
struct gp_lens_facts {
    const char *name;            // borrowed; NULL: no --lens
    double sensor;               // width of the display window on it, mm
    const char *sensor_from;     // "option", "angle", "attribute", "lens"
                                 // or "default"
    double rest;                 // share of the sources that has no ghosts
    double bound;                // of rel_l2 of the layer, of what is left out
    struct gp_lens_stats stats;
};

/* The report's object of them, in run_lens.c; errors as gp_json_print(). */
json_t *gp_lens_facts_json(const struct gp_lens_facts *l);

/* Facts about the scene that a frame was posed from. */
struct gp_scene_facts {
    const char *path;            // NULL: no scene
    double seconds;              // posed at
    const char *camera;          // of the scene, where the frame has none
    bool compared;               // both have one
    double apart;                // pixels between the two
};

/* Facts about a light of --relight. */
struct gp_relit_facts {
    const char *name;            // borrowed from the scene
    long long pixels;            // that got light
    long long rays;              // cast for its shadows and edges
    int casters;                 // objects that may cast its shadows
};

/* The facts about one frame. Strings are borrowed. */
struct gp_facts {
    bool numbered;
    int frame;                   // when numbered
    const char *view;            // of stereo, or NULL
    const char *const *light_group; // `light_groups` layers that glare
    int light_groups;            // 0: the frame's own colour glares
    const char *input;
    struct gp_taken taken;       // part, layer and view of the input
    char **outputs;              // `n_outputs` names
    const enum gp_target_kind *kinds; // of each
    int n_outputs;
    int width, height;           // of `window`
    struct gp_rect window, read; // data windows: of the outputs, of the file
    long long sources;           // bright pixels, and pixels of lights
    double flux_in[3];           // of the sources, by channel
    struct gp_spread spread;
    double flux_faint[3];        // light under FLT_MIN, which counts as 0
    double kernel_faint[3];      // magnitudes of the kernel under FLT_MIN
    struct gp_kernel_facts kernel;
    double deg_per_pixel;        // 0: the kernel is an image
    double fov;                  // vertical angle of view, degrees
    const char *fov_from;        // "option", "camera", "lens", "default"
    double flux_out[3];          // of the layer inside the frame
    bool has_flux_out;
    long long nonfinite;         // pixels of the input
    long long clamped;           // pixels of the input over --max-value
    double flux_clamped[3];      // light that --max-value and the outputs'
                                 // types removed, by channel
    float threshold;             // as luminance
    const char *views;           // line about the views of the run, or NULL
    bool dark;                   // glare was wanted, no pixel is a source
    float peak;                  // largest luminance of a dark frame
    int peak_at[2];              // its pixel, in EXR pixel space
    long long clamped_out;       // values that an output's type cannot hold
    struct gp_glare_stats glare; // engine NULL: no glare stage
    struct gp_flare_facts flare;
    bool verified;
    struct gp_glare_error error; // when verified
    const struct gp_light *light; // `lights` of them; NULL: none asked for
    int lights;
    const char *sun_way;         // sun_method
    const char *sun_gl;          // context of the lights, or NULL
    struct gp_lens_facts lens;
    const char *depth;           // channel, or NULL
    enum gp_pixel_type depth_type;
    char depth_empty[64];        // values that count as no surface; "": the
                                 // frame has no light
    bool depth_reversed;         // larger is nearer
    const char *mask;            // coverage channel, or NULL
    struct gp_scene_facts scene;
    const struct gp_relit_facts *relit; // `relits`, in the scene's order
    int relits;                  // 0: no --relight
    const struct gp_ocio_names *ocio; // NULL: tone mapped
    const struct gp_settings *settings; // of the run; NULL: left out
    const char *warned;          // `warned_bytes` of lines, each with its null
    size_t warned_bytes;         // byte
    size_t bytes;                // estimated memory of the frame in flight
    double ms[GP_TIMES];         // negative: the stage was not needed
    double total_ms;
    double cpu_ms[GP_TIMES];     // of all threads
    bool has_cpu;                // one frame was in flight, so that it is known
};

struct gp_report {
    FILE *file;        // NULL: closed
    const char *path;  // borrowed; "-" is stdout
    char *created;     // owned: the file that did not exist; NULL: it did
    bool given;        // an open descriptor's, whose file is never cut
    bool append;
    long long lines;
    json_t *settings;  // owned; made for the first frame, as all have the same
};

/* Opens the file, in folders that are made if `create_dir`. Its old lines are
 * removed with the first new one, not before; with `append` they stay, but for
 * a last one without a line feed, left by a killed run. Errors: GP_ERR_IO with
 * the system's reason. */
GP_MUST_CHECK gp_status gp_report_open(const struct gp_log *log,
    const char *path, bool create_dir, bool append, struct gp_report *out);

/* Appends one line and flushes it. Fields that were not needed are left out;
 * NaN and Inf are null; bytes of names that are not UTF-8 become U+FFFD.
 * Errors: GP_ERR_IO (full disk, closed pipe); GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_report_frame(const struct gp_log *log,
    struct gp_report *r, const struct gp_facts *facts);

/* Appends the line of a frame that failed: frame (when numbered), view, input,
 * warnings, the status of its failure, not GP_OK, and error, the message that
 * was printed for it. Same errors. */
GP_MUST_CHECK gp_status gp_report_failed(const struct gp_log *log,
    struct gp_report *r, const struct gp_facts *facts, gp_status status,
    const char *error);

/* Closes the file, and removes it if this run made it and wrote no line. A
 * closed or zeroed report is fine. Errors: GP_ERR_IO. */
gp_status gp_report_close(const struct gp_log *log, struct gp_report *r);

/* Formats the warning that no pixel of `frames` frames is over the threshold,
 * f being of the brightest. The report has it for each dark frame. */
void gp_facts_dark(const struct gp_facts *f, int frames, char *line,
                   size_t size);

/* Measure of the edges before the lights that the frame shows, by which the
 * report says how near their shares are. */
enum gp_edges {
    GP_EDGES_NONE, // no light is in the frame, or nothing hides any
    GP_EDGES_DEPTH,
    GP_EDGES_COVERAGE, // and depth
    GP_EDGES_MASK,     // coverage without depth
};
enum gp_edges gp_facts_edges(const struct gp_facts *f);

#endif
