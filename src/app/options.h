/* The command line.
 *
 * app/ as a room: argv in, exit status out.
 *   options   the one table of options: lookup.c, parse.c, check.c, help.c,
 *             record.c read it
 *   jobs      which frames are made, and under which names
 *   pipeline  frame after frame through the stages
 *   report    JSON lines; progress: the line on the terminal */
#ifndef GP_APP_OPTIONS_H
#define GP_APP_OPTIONS_H

#include "app/settings.h"
#include "core/status.h"

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

/* The kind follows from the field's type; a field of another type does not
 * compile. */
enum gp_option_kind {
    GP_KIND_FLAG,    // bool: set true
    GP_KIND_SET,     // enum: set to `set`, takes no value
    GP_KIND_FLOAT,
    GP_KIND_THRESHOLD, // struct gp_sensor_params: "1", "99.9%", "+3ev"
    GP_KIND_INT,
    GP_KIND_COUNT,   // long long
    GP_KIND_PAIR,    // double[2], "x,y"
    GP_KIND_NUMBERS, // struct gp_numbers, "1,2,3": `least` to `most` of them
    GP_KIND_CHOICE,  // enum or int: one of `choices`
    GP_KIND_TEXT,    // const char *: one of `list`, or any when `open`
    GP_KIND_TEXTS,   // struct gp_texts: one more at each use
    GP_KIND_NAMED,   // const char *[]: "NAME=FILE", index from `choices`
};

/* Headings of --help. */
enum gp_option_group {
    GP_GROUP_OUTPUT, GP_GROUP_INPUT, GP_GROUP_LIGHT, GP_GROUP_SUN,
    GP_GROUP_ENGINE, GP_GROUP_TONE, GP_GROUP_FILE, GP_GROUP_REPORT,
    GP_GROUP_BENCH, GP_GROUP_COMPARE, GP_GROUP_GENERAL, GP_GROUPS,
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
    const char *text;  // one line for the man page; NULL: the name says it
};

/* Needs that an option has of other settings; check.c has the messages. */
enum gp_need {
    GP_NEED_OWN_FRAMES = 1 << 0,  // no input
    GP_NEED_NO_LIGHT = 1 << 1,
    GP_NEED_REPORT = 1 << 2,      // --report or --verbose
    GP_NEED_RAW = 1 << 3,         // --stdout-format raw, or none given
    GP_NEED_LIGHT = 1 << 4,       // a sun or lamp
    GP_NEED_NO_PLACE = 1 << 5,    // no --sun
    GP_NEED_SUN = 1 << 6,         // a sun of the command line
    GP_NEED_FLUX = 1 << 7,        // a light with flux
    GP_NEED_CONFIG = 1 << 8,      // --ocio
    GP_NEED_NO_CONFIG = 1 << 9,
    GP_NEED_PICTURE = 1 << 10,    // a picture that is shown
    GP_NEED_HDR = 1 << 11,        // --hdr
    // without these the option does nothing: a warning
    GP_NEED_MASK = 1 << 12,       // --sun-method mask
    GP_NEED_MAP = 1 << 13,        // the same, or a picture of the map
    GP_NEED_TONES = 1 << 14,      // no --ocio
    GP_NEED_CURVE = 1 << 15,      // a view, or a curve that is not none
    GP_NEED_EXTENDED = 1 << 16,   // --tonemap reinhard-extended
    GP_NEED_SPLAT = 1 << 17,      // an engine that draws polygons
    GP_NEED_AUTO = 1 << 18,       // --engine auto
    GP_NEED_STREAM = 1 << 19,     // an output without an ending
    GP_NEED_FILES = 1 << 20,      // a picture that is written
    GP_NEED_REPORT_FILE = 1 << 21, // --report
};

struct gp_option {
    const char *name;      // without "--"
    char letter;           // 0: none
    enum gp_option_kind kind;
    enum gp_option_group group;
    unsigned commands;     // that take it: bits of enum gp_command
    size_t at;             // offset of the field in struct gp_settings
    unsigned needs;        // of other options: bits of enum gp_need
    double lo, hi;         // numbers: inclusive range; NaN is outside
    int set;               // GP_KIND_SET
    int least, most;       // GP_KIND_NUMBERS
    const char *arg;       // what --help calls the value; NULL: takes none
    const char *help;      // one line, no full stop
    const struct gp_option_choice *choices;  // NULL name at the end
    /* The i-th value and its line, NULL after the last. */
    const char *(*list)(int i, const char **text);
    bool open;             // values outside `list` are taken as well
    bool blank;            // GP_KIND_TEXT: an empty word is a value
    bool hidden;           // not in --help
    bool aside;            // no pixel of an output depends on it; so it is
                           // with all of OUTPUT, REPORT and GENERAL
};
extern const struct gp_option gp_options[];  // NULL name at the end

/* The i-th value that the option names, with its line in *text (may come out
 * NULL); NULL after the last. */
const char *gp_option_value(const struct gp_option *o, int i,
                            const char **text);

/* The range of a number in words: "0 to 1", "0 or more", "more than 0". */
struct gp_range_text {
    char text[48];
};
struct gp_range_text gp_option_range(const struct gp_option *o);

/* The option of that name, or of that letter among those that one of the
 * commands (bits) takes; or NULL. */
const struct gp_option *gp_option_find(const char *name, size_t length);
const struct gp_option *gp_option_letter(char letter, unsigned commands);

/* True when the command line gave that option, at its default or not. */
bool gp_option_given(const struct gp_settings *s, const char *name);

/* The i-th command with its word, from GP_COMMAND_MAIN on; NULL after the
 * last, which leaves *command as it is. */
const char *gp_command_at(int i, enum gp_command *command);

/* Reads the command line into *out, which starts as gp_defaults; its last
 * value wins where an option comes twice. The first word may be a command's;
 * `--` ends the options, `-` is a file. Options that only work together are
 * checked too, unless --help or --version is asked for.
 *
 *   out  written in any case; free with gp_settings_free(); borrows from argv
 * Errors: GP_ERR_USAGE with one line; GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_options_parse(const struct gp_log *log, int argc,
    char *const argv[], struct gp_settings *out);

/* The needs that the settings do not meet: bits of enum gp_need. */
unsigned gp_needs_unmet(const struct gp_settings *s);

/* Checks what no single option can see, settles what follows from several,
 * and warns of settings that do nothing.
 * Errors: GP_ERR_USAGE with one line. */
GP_MUST_CHECK gp_status gp_settings_check(const struct gp_log *log,
                                          struct gp_settings *s);

/* The command line that makes the same picture of those inputs: the options
 * that a pixel can depend on, as they were given, then the inputs; quoted for
 * a shell, in UTF-8, on one line, file names without their folders. It is the
 * same in any folder and for any --threads, and names no folder.
 *   out  from malloc; NULL on failure. Errors: GP_ERR_BUG out of memory. */
GP_MUST_CHECK gp_status gp_command_text(const struct gp_log *log,
    const struct gp_settings *s, const char *const *input, int inputs,
    char **out);

/* The settings that a picture was made with, by the names of the options with _
 * for -: those that can change a pixel and that do something beside the others,
 * given or not; without numbers and words that are unset. Errors: as
 * gp_json_print() says. */
json_t *gp_settings_json(const struct gp_settings *s);

/* --help of a command, to `f`. */
void gp_help(FILE *f, enum gp_command command);

/* The parts of the man page that come from the table and the status list:
 * mdoc items, each part after a line @NAME@ that names its place. */
void gp_help_man(FILE *f);

/* A search: start it with gp_nearest_to(), try each name, read `name`. */
struct gp_nearest {
    const char *word;
    size_t length;
    int most;          // edits; lowered to those of `name` as names are tried
    const char *name;  // the nearest so far, the first of equals; NULL: none
};

/* A search for the word of that many bytes, borrowed; names that take more
 * than `most` edits, or than half its bytes, are no match. */
struct gp_nearest gp_nearest_to(const char *word, size_t length, int most);

/* Tries one name, borrowed. An edit inserts, deletes or replaces a byte, or
 * swaps two neighbours (the optimal string alignment distance); words and names
 * over 31 bytes are no match. */
void gp_nearest_try(struct gp_nearest *search, const char *name);

/* Prints `glarepp help TOPIC` to `f`; a NULL topic lists the topics. A
 * topic is a command, the word of a group, an option's name or letter with or
 * without dashes, a value's name, or a section of the manual, which man(1)
 * shows in place of this program.
 * Errors: GP_ERR_USAGE no such topic, with the nearest when there is one;
 * GP_ERR_IO no manual, with where its page is. */
GP_MUST_CHECK gp_status gp_help_topic(const struct gp_log *log, FILE *f,
                                      const char *topic);

/* The i-th topic, in `word` or a constant: commands, groups, sections of
 * other names; NULL after the last. */
enum { GP_TOPIC_BYTES = 32 };
const char *gp_help_topic_at(int i, char word[GP_TOPIC_BYTES]);

/* Prints `glarepp help --completion SHELL` to `f`: a script for the shell that
 * completes commands, options, their values and topics. */
void gp_complete(FILE *f, enum gp_shell shell);

#endif
