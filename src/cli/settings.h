/* Settings of the command line: the params of every stage, and the app's own.
 * Stages get only their own params. */
#ifndef GP_CLI_SETTINGS_H
#define GP_CLI_SETTINGS_H

#include "bench/bench.h"
#include "glarepp.h"
#include "io/read.h"
#include "io/write.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Values of --progress. AUTO draws on a terminal only. The last three print
 * lines for programs, on a terminal and in a pipe alike. */
enum gp_progress_when {
    GP_PROGRESS_AUTO,
    GP_PROGRESS_ALWAYS,
    GP_PROGRESS_NEVER,
    GP_PROGRESS_PERCENT,
    GP_PROGRESS_OPENJD,
    GP_PROGRESS_JSON,
};

/* Kinds of --debug KIND=FILE. */
enum gp_debug_kind {
    GP_DEBUG_SENSORS,
    GP_DEBUG_POLYGONS,
    GP_DEBUG_SUNMAP,
    GP_DEBUG_INTENSITY,
    GP_DEBUG_SCISSOR, // of glarepp sets, as the next
    GP_DEBUG_SETS,
    GP_DEBUG_KINDS,
};

/* Commands: the first word of the command line. Bits, as options have sets of
 * them. */
enum gp_command {
    GP_COMMAND_MAIN = 1 << 0,   // no word: pictures
    GP_COMMAND_BENCH = 1 << 1,  // "bench": speed against error
    GP_COMMAND_COMPARE = 1 << 2, // "compare": error between two images
    GP_COMMAND_KERNEL = 1 << 3, // "kernel": a kernel as a file
    GP_COMMAND_LENS = 1 << 4,   // "lens": figures of a lens
    GP_COMMAND_SETS = 1 << 5,   // "sets": visibility sets of a scene
    GP_COMMAND_STYLES = 1 << 6, // "styles": lists them, or draws a frame in all
    GP_COMMAND_HELP = 1 << 7,   // "help": explains a topic
};

/* Growth of a frame beyond data and display window (--grow). */
enum gp_grow_how {
    GP_GROW_PIXELS,  // by grow_pixels
    GP_GROW_KERNEL,  // as far as the kernel reaches
    GP_GROW_NONE,    // outputs keep the data window
};

/* Words from the command line, in its order. */
struct gp_texts {
    const char **at;  // owned array of borrowed words
    int n;
};

/* Frames to read. */
struct gp_input_settings {
    struct gp_texts files;
    const char *frames, *views;        // lists as given; NULL: not given
    struct gp_read_params read;
    struct gp_texts light_groups;      // layers that glare
    const char *depth;                 // channel
    bool skip_bad_frames;
};

/* Files to write. */
struct gp_output_settings {
    struct gp_texts pictures;          // -o
    struct gp_texts hdr, layer;
    const char *debug[GP_DEBUG_KINDS];
    const char *grow;                  // as given; NULL: 0 pixels
    enum gp_grow_how grow_how;         // ... as checked
    int grow_pixels;
    struct gp_write_params write;
    bool no_provenance;                // no glarepp:command in files
};

/* What glares, and how its layer is made and joins the frame. */
struct gp_light_settings {
    const char *style;                 // of styles.h
    struct glarepp_sense_params sense;
    struct glarepp_layer_params layer; // edges, where not given: black with add
};

/* Forms of --kernel-normalize. */
enum gp_kernel_sum { GP_NORMALIZE_LUMINANCE, GP_NORMALIZE_NONE };

struct gp_kernel_settings {
    struct gp_texts words;             // files and recipes
    struct glarepp_kernel_params p;    // of these
    enum gp_kernel_sum normalize;      // ... where it is given
    const char *size;                  // as given; NULL: 100 percent
};

/* Suns and lamps, and what hides them. */
struct gp_sun_settings {
    struct gp_numbers at;              // x, y and maybe radius, pixels
    struct gp_numbers dir;             // towards the sun, world
    struct gp_numbers color;           // flux by channel, or one for all
    struct glarepp_light light;        // of these
    struct glarepp_light_params p;     // degrees is --sun-size
    const char *depth_file, *mask, *mask_file;
    struct gp_texts relight;           // names of the scene's lights, or all
};

/* A view of the config, or a curve where map.config is NULL. */
struct gp_tone_settings {
    struct glarepp_tone_params map;
    struct gp_texts context;           // ... of map
};

/* What glarepp kernel and glarepp lens make. */
struct gp_making {
    bool list;
    const char *check;                 // NULL: not given
    const char *size;                  // of the frame, as given
    int w, h;                          // ... as checked
    int radius;                        // most of an offset; 0: the frame's
    int frame;                         // number, for models that move
    const char *draw;                  // SVG of the lens that `check` names
};

/* Limits of glarepp compare, and pictures to write. */
struct gp_compare_settings {
    struct glarepp_compare_params limits; // flip and perceptual too
    bool all_parts;                   // else the first
    struct gp_numbers flip_exposures; // start, stop, count; n 0: automatic
    const char *heatmap, *difference; // pictures of FLIP, of a - b; NULL: none
    bool only_different, absolute;    // only of pairs that differ; |a - b|
    float scale;                      // times this
};

enum { GP_FRAME_JOBS = 64 }; // most frames in flight

/* How a run goes and what it says. */
struct gp_run_settings {
    int threads;                       // 0: all processors
    int frame_jobs;                    // frames in flight; 0: by memory
    bool verify;
    const char *report;
    enum gp_level level;               // of messages
    enum gp_progress_when progress;
};

/* The command line itself. */
struct gp_word_settings {
    struct gp_texts options;           // name and value (NULL: takes none) of
                                       // each option given, in turn
    uint64_t given[4];                 // a bit for each option of the table
    const char *help;                  // topic, "" without one; NULL: no --help
    bool help_table, version;
    bool list_flares;                  // print their names, nothing else
};

/* Each stage gets its own. Strings are borrowed from argv or are constants. The
 * params of a plan point to others here: it must not move. */
struct gp_settings {
    enum gp_command command;
    struct gp_input_settings input;
    struct gp_output_settings output;
    struct gp_light_settings light;
    struct gp_kernel_settings kernel;
    struct gp_sun_settings sun;
    struct glarepp_lens_params lens;
    struct glarepp_scene_params scene; // light_scale 0: its lights have no flux
    struct gp_tone_settings tone;
    struct glarepp_plan_params plan;   // of all these, but for its kernel
    struct gp_making making;
    struct gp_bench_params bench;      // json: of compare and sets too
    struct glarepp_sets_params sets;   // its size is making's
    struct gp_compare_settings compare;
    struct gp_run_settings run;
    struct gp_word_settings words;
};

/* The defaults of all options. */
extern const struct gp_settings gp_defaults;

/* Frees what gp_options_parse() made. */
void gp_settings_free(struct gp_settings *s);

#endif
