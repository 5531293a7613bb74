// SPDX-License-Identifier: Apache-2.0
/* The command line: its settings, and the one table of options that lookup.c,
 * parse.c, check.c, help.c and report.c read. */
#ifndef GP_CLI_OPTIONS_H
#define GP_CLI_OPTIONS_H

#include "bench/bench.h"
#include "core/status.h"
#include "glarepp.h"
#include "io/read.h"
#include "io/write.h"

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Values of --progress; the last three are lines for programs. */
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

/* The first word of the command line; bits, as options have sets of them. */
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

/* Words of --grow in place of a number of pixels. */
enum { GP_GROW_KERNEL = -1, GP_GROW_NONE = -2 };

/* Words from the command line, in its order. */
struct gp_texts {
    const char **at;  // borrowed words
    int n;
};

/* The numbers of a value: one, or a list. */
struct gp_quantity {
    struct gp_numbers list;
    int unit; // of a threshold: enum glarepp_threshold; of a size 1: degrees
};

/* Keys of an option whose value changes over frames: linear between them, held
 * outside. */
struct gp_keyed {
    const struct gp_option *option;
    const char *file; // borrowed; NULL: written on the command line
    struct gp_key {
        int frame;            // rises
        struct gp_quantity v; // as many numbers, in the same unit, in all
    } * key;                  // owned
    int n;                    // at least 1
};

/* A layer that glares. */
struct gp_light_group {
    char *name;         // owned, with the kernel's word
    const char *kernel; // a word; NULL: those of --kernel
    int more;           // 0, or from 1 which of group_kernels
    float gain;
};

/* Frames to read. */
struct gp_input_settings {
    struct gp_texts files;
    const char *frames, *views;        // lists as given; NULL: not given
    struct gp_read_params read;
    struct gp_texts light_groups;      // layers that glare, as given
    struct gp_light_group *group;      // ... as read; owned
    struct gp_texts group_kernels;     // words of these, each once
    const char *depth;                 // channel
    bool skip_bad_frames;
};

/* Reads the words of --light-group into input.group and group_kernels. Errors:
 * GP_ERR_USAGE; GP_ERR_BUG out of memory. */
struct gp_settings;
GP_MUST_CHECK gp_status gp_light_groups_read(const struct gp_log *log,
                                             struct gp_settings *s);

/* The layers of --parts, in the order of views from GLAREPP_PART_VEIL on. */
enum { GP_PART_NAMES = 4 };
extern const char *const gp_part_names[GP_PART_NAMES];

/* Files to write. */
struct gp_output_settings {
    struct gp_texts pictures;          // -o
    struct gp_texts hdr, layer, parts;
    const char *debug[GP_DEBUG_KINDS];
    const char *grow;                  // as given; NULL: 0 pixels
    int grow_pixels;                   // ... as checked; or GP_GROW_*
    struct gp_write_params write;
    bool no_provenance;                // no glarepp:command in files
};

/* Settings of the light that glares, and of its layer. */
struct gp_light_settings {
    const char *style;                 // a word of gp_styles
    struct glarepp_sense_params sense;
    struct gp_numbers tint;            // ... of layer
    struct glarepp_layer_params layer; // edges, where not given: black with add
    const char *mask;                  // of what may glare, as given; or NULL
    const char *source;                // file of a frame whose light it is
};

/* The value of --source-mask. */
struct gp_mask_word {
    const char *word;      // a channel or file, or
    bool crypto, inverted; // names of Cryptomatte; "!" was before it
};
static inline struct gp_mask_word gp_mask_word_of(const char *value)
{
    const bool inverted = value[0] == '!';
    const bool crypto = strncmp(value + inverted, "crypto:", 7) == 0;
    return (struct gp_mask_word) {value + inverted + (crypto ? 7 : 0), crypto,
                                  inverted};
}

/* Forms of --kernel-normalize. */
enum gp_kernel_sum { GP_NORMALIZE_LUMINANCE, GP_NORMALIZE_NONE };

struct gp_kernel_settings {
    struct gp_texts words;             // files and recipes
    struct gp_numbers centre;          // x, y
    struct glarepp_kernel_params p;    // of these
    enum gp_kernel_sum normalize;      // ... where it is given
};

/* Suns and lamps, and what hides them. */
struct gp_sun_settings {
    struct gp_numbers at;              // x, y and maybe radius, pixels
    struct gp_numbers dir;             // towards the sun, world
    struct gp_numbers color;           // flux by channel, or one for all
    const char *lights;                // a file, or auto[:N]; NULL: none
    const char *write_lights;          // those found; NULL: not given
    struct glarepp_light light;        // of these
    struct glarepp_light_params p;     // degrees is --sun-size
    const char *depth_file, *mask, *mask_file, *deep;
    struct gp_texts relight;           // names of the scene's lights, or all
};

/* A view of the config, or a curve where map.config is NULL. */
struct gp_tone_settings {
    struct glarepp_tone_params map;
    struct gp_texts context;           // ... of map
};

/* Settings of glarepp kernel and glarepp lens. */
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

/* Pages of glarepp compare, bench and styles. */
struct gp_page_settings {
    const char *html, *index; // NULL: not wanted
    double megabytes;         // of a page, 1e6 bytes each
};

enum { GP_FRAME_JOBS = 64 }; // most frames in flight

/* Settings of the whole run, and of its words. */
struct gp_run_settings {
    int threads;                       // 0: all processors
    int frame_jobs;                    // frames in flight; 0: by memory
    bool verify;
    const char *report;
    struct gp_numbers fixation;        // x, y
    double luminance_scale;            // cd/m2 of 1; 0: the file's
    enum gp_level level;               // of messages
    enum gp_progress_when progress;
};

/* The command line itself. */
struct gp_word_settings {
    const char **all;                  // those of all lists; owned
    struct gp_texts options;           // name and value (NULL: takes none) of
                                       // each option given, in turn
    struct gp_texts settings;          // files of options, the later rules
    const char *save_settings;
    struct gp_words *read;             // of these files; owned, or NULL
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
    struct gp_page_settings page;
    struct gp_run_settings run;
    struct gp_word_settings words;
    struct gp_keyed *keyed; // owned: `keyeds` options, each once; their
    int keyeds;             // fields hold the first key
};

/* The defaults of all options. */
extern const struct gp_settings gp_defaults;

/* Frees what gp_options_parse() made. */
void gp_settings_free(struct gp_settings *s);

// -- the table ---------------------------------------------------------------

/* Kinds of values. The field's type gives the kind; a field of another type
 * does not compile. */
enum gp_option_kind {
    GP_KIND_FLAG, // bool: set true, or false by `off`
    GP_KIND_SET,  // enum: set to `set`, takes no value
    GP_KIND_FLOAT,
    GP_KIND_REAL,      // double
    GP_KIND_LEVEL,     // float: "2", "+3ev", or "auto", which is 0
    GP_KIND_THRESHOLD, // struct glarepp_sense_params: "1", "99.9%", "+3ev"
    GP_KIND_INT,
    GP_KIND_COUNT,   // long long
    GP_KIND_SIZE,    // struct glarepp_kernel_params: "50", "50%", "2deg"
    GP_KIND_NUMBERS, // struct gp_numbers, "1,2,3": `least` to `most` of them
    GP_KIND_CHOICE,  // enum or int: one of `choices`
    GP_KIND_EITHER,  // bool: one of two `choices`
    GP_KIND_TEXT,    // const char *: one of `list`, or any when `open`
    GP_KIND_TEXTS,   // struct gp_texts: one more at each use
    GP_KIND_NAMED,   // const char *[]: "NAME=FILE", index from `choices`
};

/* Headings of --help. */
enum gp_option_group {
    GP_GROUP_OUTPUT, GP_GROUP_INPUT, GP_GROUP_LIGHT, GP_GROUP_SUN,
    GP_GROUP_ENGINE, GP_GROUP_TONE, GP_GROUP_FILE, GP_GROUP_REPORT,
    GP_GROUP_KERNEL, GP_GROUP_LENS, GP_GROUP_SETS, GP_GROUP_BENCH,
    GP_GROUP_COMPARE, GP_GROUP_GENERAL,
    GP_GROUPS,
};
struct gp_option_heading {
    const char *title;
    const char *word;     // its name as a topic of glarepp help
    const char *example;  // a command line that uses options of the group
};
extern const struct gp_option_heading gp_option_groups[GP_GROUPS];

struct gp_option_choice {
    const char *name;
    int value;
    const char *text;  // one line for the man page; NULL: the name suffices
};

/* Settings that an option needs; check.c has the messages. */
enum gp_need {
    GP_NEED_OWN_FRAMES = 1 << 0, // no input
    GP_NEED_NO_LIGHT = 1 << 1,
    GP_NEED_REPORT = 1 << 2,   // --report or --verbose
    GP_NEED_RAW = 1 << 3,      // --stdout-format raw, or none given
    GP_NEED_LIGHT = 1 << 4,    // a sun or lamp
    GP_NEED_NO_PLACE = 1 << 5, // no --sun
    GP_NEED_SUN = 1 << 6,      // --sun, --sun-dir or --camera
    GP_NEED_CONFIG = 1 << 7,   // --ocio
    GP_NEED_NO_CONFIG = 1 << 8,
    GP_NEED_PICTURE = 1 << 9,  // a tone-mapped picture
    GP_NEED_HDR = 1 << 10,     // --hdr
    GP_NEED_LENS = 1 << 11,    // --lens
    GP_NEED_SCENE = 1 << 12,   // --scene
    GP_NEED_RELIGHT = 1 << 13, // --relight
    GP_NEED_FLARE = 1 << 14,   // --flare
    // without these the option does nothing: a warning
    GP_NEED_MASK = 1 << 15,     // --sun-method mask
    GP_NEED_MAP = 1 << 16,      // --sun-method mask or --debug sunmap
    GP_NEED_TONES = 1 << 17,    // no --ocio
    GP_NEED_CURVE = 1 << 18,    // --ocio, or a curve other than none
    GP_NEED_EXTENDED = 1 << 19, // --tonemap reinhard-extended
    GP_NEED_SPLAT = 1 << 20,    // --engine splat, or --debug polygons
    GP_NEED_AUTO = 1 << 21,     // --engine auto
    GP_NEED_STREAM = 1 << 22,   // an output without an ending
    GP_NEED_FILES = 1 << 23,    // an output file
    GP_NEEDS = 24,
};

struct gp_option {
    const char *name;      // without "--"
    char letter;           // 0: none
    enum gp_option_kind kind;
    enum gp_option_group group;
    unsigned commands;     // bits of enum gp_command
    size_t at;             // offset of the field in struct gp_settings
    unsigned needs;        // bits of enum gp_need
    double lo, hi;         // numbers: inclusive range; NaN is outside
    int set;               // GP_KIND_SET
    bool off;              // GP_KIND_FLAG
    int least, most;       // GP_KIND_NUMBERS
    const char *arg;       // name of the value in --help; NULL: takes none; in
                           // brackets: it may be left out, and the next word is
                           // it only where it is all letters
    const char *help;      // one line, no full stop; NULL: not in --help
    const char *usual;     // at most 50 characters, for --help of one screen;
                           // NULL: it is not there
    const struct gp_option_choice *choices;  // NULL name at the end
    const char *(*list)(int i, const char **text); // as gp_option_value()
    bool open;             // values outside `list` are valid too
    bool blank;            // GP_KIND_TEXT: an empty word is valid
    bool once;             // GP_KIND_TEXT: a second value is an error
    bool aside;            // no pixel of an output depends on it; implied for
                           // OUTPUT, REPORT and GENERAL,
    bool pixels;           // but for these
};
extern const struct gp_option gp_options[];  // NULL name at the end

/* The i-th value that the option names, and its line or NULL; NULL after the
 * last. */
const char *gp_option_value(const struct gp_option *o, int i,
                            const char **text);

/* Lists of values for the table's `list`: engines, tone curves, styles, and
 * words of --kernel that are no file, valid until the next call. */
const char *gp_engine_name(int i, const char **text);
const char *gp_curve_name(int i, const char **text);
const char *gp_style_name(int i, const char **text);
const char *gp_kernel_word(int i, const char **text);

/* The range of a number in words: "0 to 1", "0 or more", "any number". */
struct gp_range_text {
    char text[48];
};
struct gp_range_text gp_option_range(const struct gp_option *o);

/* The option of that name, or that letter for one of the commands; or NULL. */
const struct gp_option *gp_option_find(const char *name, size_t length);
const struct gp_option *gp_option_letter(char letter, unsigned commands);

/* True when pixels of an output may depend on the option. */
bool gp_option_makes_pixels(const struct gp_option *o);

/* True when the command line gave that option, even with its default. */
bool gp_option_given(const struct gp_settings *s, const char *name);

/* The choice that an option's field holds; NULL when it holds none. */
const struct gp_option_choice *gp_option_chosen(const struct gp_option *o,
                                                const void *field);

/* True when a word of --kernel or --check is a path, not a recipe. */
bool gp_kernel_is_file(const char *word);

/* Copies the path that kernel i names, of --kernel or after these of
 * --light-group, to `path` of PATH_MAX bytes, or "". False after the last. */
bool gp_kernel_file(const struct gp_settings *s, int i, char *path);

/* True when an option names a light with a place, a file of them or a scene. */
bool gp_lights_wanted(const struct gp_settings *s);

/* True when --depth says that the frame's depth is not to be read. */
static inline bool gp_no_depth(const struct gp_settings *s)
{
    return s->input.depth && strcmp(s->input.depth, "none") == 0;
}

/* Reads whole numbers of 0 to 99999 with these characters between them, and
 * nothing else: 1920x1080,255 with "x,". */
static inline bool gp_read_whole(const char *text, const char *between, int *v)
{
    for (;; between++, v++) {
        char *end;
        if (*text < '0' || *text > '9')
            return false;
        const long n = strtol(text, &end, 10);
        if (n > 99999 || *end != *between)
            return false;
        *v = (int) n;
        if (!*between)
            return true;
        text = end + 1;
    }
}

/* The commands, the main one first; a NULL word ends them. */
struct gp_command_row {
    const char *word;    // "" of the main one
    enum gp_command bit;
    int least, most;     // inputs
    const char *usage;   // what it does, a line, then how to write it; NULL of
                         // help, whose options are topics
    struct gp_example {
        const char *line, *text;
    } example[4];        // NULL line at the end
};
extern const struct gp_command_row gp_commands[];

/* The row of a command, of several bits the first; that of a word, or NULL. */
const struct gp_command_row *gp_command_of(unsigned commands);
const struct gp_command_row *gp_command_named(const char *word);

/* Reads the command line into *out, which starts as gp_defaults; the last value
 * of an option wins, unless it is `once`. Then checks the settings, unless
 * --help or --version is given. *out is written in any case, and borrows from
 * argv. */
GP_MUST_CHECK gp_status gp_options_parse(const struct gp_log *log, int argc,
    char *const argv[], struct gp_settings *out);

/* Makes settings of pictures from those of glarepp styles, and one option more
 * where *s has none of that name. *out borrows all that s owns, is not freed and
 * must not move; one is made at a time. */
GP_MUST_CHECK gp_status gp_options_more(const struct gp_log *log,
                                        const struct gp_settings *s,
                                        const char *name, const char *value,
                                        struct gp_settings *out);

/* The needs that the settings do not meet: bits of enum gp_need. */
unsigned gp_needs_unmet(const struct gp_settings *s);

/* Sets what the library gets of the options, and the pointers within *s. */
void gp_settings_point(struct gp_settings *s);

/* Checks settings that depend on each other, sets fields that follow from
 * several options, and warns of options that do nothing. */
GP_MUST_CHECK gp_status gp_settings_check(const struct gp_log *log,
                                          struct gp_settings *s);

/* --help of one screen, to `f`: at most 24 lines of 80 columns. */
void gp_help_screen(FILE *f);

/* All options of a command, after its own text. */
void gp_help(FILE *f, enum gp_command command);

/* Ends a line of help that is `column` characters long with `text`, wrapped at
 * 80 columns, the 29th its first. */
void gp_help_text(FILE *f, int column, const char *text);

/* Prints the table of options, models and statuses for man/page.awk and
 * man/completions.awk: a row a line, fields separated by tabs. */
void gp_help_table(FILE *f);

/* Prints `glarepp help TOPIC`; a NULL topic lists the topics. A topic is a
 * command, the word of a group, all, an option's name or letter with or without
 * dashes, a value's name, or a section of the manual, which man(1) shows.
 * Errors: GP_ERR_USAGE no such topic; GP_ERR_IO the manual cannot be shown. */
GP_MUST_CHECK gp_status gp_help_topic(const struct gp_log *log, FILE *f,
                                      const char *topic);

// -- styles: names for options that belong together, as their words -----------

#define GP_STYLE_USUAL "camera" // of a run without --style

enum { GP_STYLE_WORDS = 16 };   // most of one style, with the NULL

struct gp_style {
    const char *name;
    const char *text;           // one line
    const char *word[GP_STYLE_WORDS]; // names of options, without dashes, and
                                // their values in turn; then NULL
};
extern const struct gp_style gp_styles[]; // ends with name NULL

/* The style of that name, which must be one. */
const struct gp_style *gp_style_of(const char *name);

/* True when a style has a value for an option, by its long name. */
bool gp_style_sets(const char *style, const char *option);

#endif
