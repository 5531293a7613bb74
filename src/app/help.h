/* Parts of --help, for those who print a part of it. */
#ifndef GP_APP_HELP_H
#define GP_APP_HELP_H

#include "app/options.h"

/* An option with its text, values, range and default, at most 79 columns. */
void gp_help_option(FILE *f, const struct gp_option *o);

/* A value of an option with its line, under the option's. */
void gp_help_value(FILE *f, const char *name, const char *text);

/* The heading of a group with its example, and those of its options that one
 * of the commands (bits of enum gp_command) takes. False, and prints nothing,
 * when there are none. */
bool gp_help_group(FILE *f, int group, unsigned commands);

/* What `glarepp help TOPIC` prints, to `f`; a NULL topic lists the topics. A
 * topic is a command, the word of a group, an option's name or letter with or
 * without dashes, a word of a heading of the man page, or a value's name.
 * Errors: GP_ERR_USAGE, with the nearest topic when there is one; GP_ERR_BUG
 * out of memory. */
GP_MUST_CHECK gp_status gp_help_topic(const struct gp_log *log, FILE *f,
                                      const char *topic);

/* What `glarepp help --completion SHELL` prints: a script for the shell that
 * completes commands, options, their values and topics. */
void gp_complete(FILE *f, enum gp_shell shell);

#endif
