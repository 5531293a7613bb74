/* The command line.
 *
 * app/ as a room: argv in, exit status out.
 *   options   the one table of options: lookup.c, parse.c, check.c, help.c,
 *             report.c read it
 *   jobs      the frames of a run and the names of its files
 *   pipeline  frame after frame through the stages
 *   report    JSON lines; progress: the line on the terminal */
#ifndef GP_CLI_OPTIONS_H
#define GP_CLI_OPTIONS_H

#include "cli/settings.h"
#include "core/status.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

/* Kinds of values. The field's type gives the kind; a field of another type
 * does not compile. */
enum gp_option_kind {
    GP_KIND_FLAG,    // bool: set true, or false by `off`
    GP_KIND_SET,     // enum: set to `set`, takes no value
    GP_KIND_FLOAT,
    GP_KIND_REAL,    // double
    GP_KIND_THRESHOLD, // struct glarepp_sense_params: "1", "99.9%", "+3ev"
    GP_KIND_INT,
    GP_KIND_COUNT,   // long long
    GP_KIND_PAIR,    // double[2], "x,y"
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

// Values of options, in option_lists.c
extern const struct gp_option_choice gp_progresses[], gp_debugs[], gp_gls[],
    gp_types[], gp_compressions[], gp_bits[], gp_alphas[], gp_stdout_formats[],
    gp_raws[];

/* Settings that an option needs; check.c has the messages. */
enum gp_need {
    GP_NEED_OWN_FRAMES = 1 << 0,  // no input
    GP_NEED_NO_LIGHT = 1 << 1,
    GP_NEED_REPORT = 1 << 2,      // --report or --verbose
    GP_NEED_RAW = 1 << 3,         // --stdout-format raw, or none given
    GP_NEED_LIGHT = 1 << 4,       // a sun or lamp
    GP_NEED_NO_PLACE = 1 << 5,    // no --sun
    GP_NEED_SUN = 1 << 6,         // --sun, --sun-dir or --camera
    GP_NEED_CONFIG = 1 << 7,      // --ocio
    GP_NEED_NO_CONFIG = 1 << 8,
    GP_NEED_PICTURE = 1 << 9,    // a tone-mapped picture
    GP_NEED_HDR = 1 << 10,        // --hdr
    GP_NEED_LENS = 1 << 11,      // --lens
    GP_NEED_SCENE = 1 << 12,     // --scene
    GP_NEED_RELIGHT = 1 << 13,   // --relight
    // without these the option does nothing: a warning
    GP_NEED_MASK = 1 << 14,       // --sun-method mask
    GP_NEED_MAP = 1 << 15,        // --sun-method mask or --debug sunmap
    GP_NEED_TONES = 1 << 16,      // no --ocio
    GP_NEED_CURVE = 1 << 17,      // --ocio, or a curve other than none
    GP_NEED_EXTENDED = 1 << 18,   // --tonemap reinhard-extended
    GP_NEED_SPLAT = 1 << 19,      // --engine auto or splat, or --debug polygons
    GP_NEED_AUTO = 1 << 20,       // --engine auto
    GP_NEED_STREAM = 1 << 21,     // an output without an ending
    GP_NEED_FILES = 1 << 22,      // an output file
    GP_NEEDS = 23,
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
    const char *arg;       // name of the value in --help; NULL: takes none
    const char *help;      // one line, no full stop
    const char *usual;     // at most 50 characters, for --help of one screen;
                           // NULL: it is not there
    const struct gp_option_choice *choices;  // NULL name at the end
    /* The i-th value and its line, NULL after the last. */
    const char *(*list)(int i, const char **text);
    bool open;             // values outside `list` are valid too
    bool blank;            // GP_KIND_TEXT: an empty word is valid
    bool optional;         // ... and the value may be left out: the next word is
                           // it only where it is all letters
    bool once;             // GP_KIND_TEXT: a second value is an error
    bool hidden;           // not in --help
    bool aside;            // no pixel of an output depends on it; implied for
                           // OUTPUT, REPORT and GENERAL,
    bool pixels;           // but for these
};
extern const struct gp_option gp_options[];  // NULL name at the end

/* The i-th value that the option names; *text is its line or NULL. NULL after
 * the last. */
const char *gp_option_value(const struct gp_option *o, int i,
                            const char **text);

/* Lists of values for the table's `list`: engines, tone curves, words of
 * --grow and --help. */
const char *gp_engine_name(int i, const char **text);
const char *gp_curve_name(int i, const char **text);
const char *gp_grow_word(int i, const char **text);
const char *gp_help_word(int i, const char **text);

/* The i-th word of --kernel that is no file: presets, then models without a
 * preset of their name. Valid until the next call. */
const char *gp_kernel_word(int i, const char **text);

/* The range of a number in words: "0 to 1", "0 or more", "any number". */
struct gp_range_text {
    char text[48];
};
struct gp_range_text gp_option_range(const struct gp_option *o);

/* The option of that name, or of that letter for one of the commands (bits); or
 * NULL. */
const struct gp_option *gp_option_find(const char *name, size_t length);
const struct gp_option *gp_option_letter(char letter, unsigned commands);

/* True when the command line gave that option, even with its default. */
bool gp_option_given(const struct gp_settings *s, const char *name);

/* The choice that an option's field holds; NULL when it holds none. */
const struct gp_option_choice *gp_option_chosen(const struct gp_option *o,
                                                const void *field);

/* True when a word of --kernel or --check is a path, not a recipe. */
bool gp_kernel_is_file(const char *word);

/* True when a frame may have lights: an option names one, a file or a scene. */
bool gp_lights_wanted(const struct gp_settings *s);

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

/* The row of a command, of several bits the first. */
const struct gp_command_row *gp_command_of(unsigned commands);

/* Reads the command line into *out, which starts as gp_defaults; the last value
 * of an option wins, unless it is `once`. The first word may be a command's;
 * `--` ends the options, `-` is a file. Then checks the settings, unless --help
 * or --version is given.
 *
 *   out  written in any case; free with gp_settings_free(); borrows from argv
 * Errors: GP_ERR_USAGE with one line; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_options_parse(const struct gp_log *log, int argc,
    char *const argv[], struct gp_settings *out);

/* The needs that the settings do not meet: bits of enum gp_need. */
unsigned gp_needs_unmet(const struct gp_settings *s);

/* Checks settings that depend on each other, sets fields that follow from
 * several options, and warns of options that do nothing.
 * Errors: GP_ERR_USAGE with one line. */
GP_MUST_CHECK gp_status gp_settings_check(const struct gp_log *log,
                                          struct gp_settings *s);

/* The command line that makes the same picture of those inputs: the given
 * options that a pixel can depend on, then the inputs; quoted for a shell, in
 * UTF-8, on one line, file names without their folders. It is the same in any
 * folder and for any --threads.
 *   out  from malloc; NULL on failure. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_command_text(const struct gp_log *log,
    const struct gp_settings *s, const char *const *input, int inputs,
    char **out);

/* --help of one screen, to `f`: at most 24 lines of 80 columns. */
void gp_help_screen(FILE *f);

/* All options of a command, after its own text. */
void gp_help(FILE *f, enum gp_command command);

/* Ends a line of help that is `column` characters long with `text`, wrapped at
 * 80 columns, the 29th its first. */
void gp_help_text(FILE *f, int column, const char *text);

/* Prints the table of options, models and statuses, a row a line, its fields
 * separated by tabs: man/page.awk and man/completions.awk read it. */
void gp_help_table(FILE *f);

/* Prints `glarepp help TOPIC` to `f`; a NULL topic lists the topics. A
 * topic is a command, the word of a group, all (as --help all), an option's
 * name or letter with or without dashes, a value's name, or a section of the
 * manual, which man(1) shows in place of this program.
 * Errors: GP_ERR_USAGE no such topic, with the nearest if there is one;
 * GP_ERR_IO the manual cannot be shown. */
GP_MUST_CHECK gp_status gp_help_topic(const struct gp_log *log, FILE *f,
                                      const char *topic);

#endif
