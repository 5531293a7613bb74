// SPDX-License-Identifier: Apache-2.0
/* Options as words: the command that a picture keeps, and files of settings. */
#ifndef GP_CLI_WORDS_H
#define GP_CLI_WORDS_H

#include "cli/keys.h"

/* A log that puts "FILE:LINE: ", or with line 0 "FILE: ", before each line. */
struct gp_place {
    const struct gp_log *to;
    const char *path;
    int line;
};
struct gp_log gp_place_log(struct gp_place *p, const struct gp_log *to,
                           const char *path, int line);

/* The command line that makes the same picture of those inputs, from malloc:
 * the given options that a pixel can depend on, then the inputs; quoted for a
 * shell, in UTF-8, on one line. */
enum gp_command_form {
    GP_COMMAND_NAMES, // file names without their folders
    GP_COMMAND_WHOLE, // to be run in the same place
    GP_COMMAND_ALL,   // so, and then the other options that have values
};
GP_MUST_CHECK gp_status gp_command_text(const struct gp_log *log,
                                        const struct gp_settings *s,
                                        const char *const *input, int inputs,
                                        enum gp_command_form form, char **out);

/* The name of a path without its folders. */
const char *gp_base_name(const char *path);

/* Finds the command that made a PNG or EXR: glarepp:command, gp_free() it.
 *   named  with the option that named the file, where that is known, and its name
 * Errors: those of gp_read_frame(); GP_ERR_DATA the file has none. */
GP_MUST_CHECK gp_status gp_words_command(const struct gp_log *log,
                                         const char *path, bool named,
                                         char **out);

/* Writes these options to --save-settings, one a line, quoted for a shell, as
 * they were given; leaves a file that exists with --no-clobber.
 * Errors: GP_ERR_IO. */
GP_MUST_CHECK gp_status gp_settings_save(const struct gp_log *log,
                                         const struct gp_settings *s);

enum { GP_WORDS = 1000 }; // most in a file

/* Words of a file, and where they are from. */
struct gp_words {
    struct gp_words *next;
    const char *path; // of the file; borrowed
    char *text;       // holds the words; owned
    const char *word[GP_WORDS];
    int line[GP_WORDS];    // 0: the command of a picture
    char *found[GP_WORDS]; // paths that replace words; owned
    int n, founds;
};

/* Reads words as a shell does, without its expansions: blanks and ends of lines
 * between them, '...', "..." and \; # begins a comment. Of a PNG or EXR the
 * options of glarepp:command.
 * Errors: GP_ERR_IO; GP_ERR_DATA no such file, a quote without its end, too many
 * words. */
GP_MUST_CHECK gp_status gp_words_read(const struct gp_log *log,
                                      const char *path, struct gp_words **out);
void gp_words_free(struct gp_words **list);

/* Finds the file that the value of an option in *w names: beside the file of *w,
 * else by its name as it is; the value then becomes a word of *w. Others stay.
 * Errors: GP_ERR_IO it is in neither folder. */
GP_MUST_CHECK gp_status gp_words_file(struct gp_use *u, struct gp_words *w);

#endif
