// SPDX-License-Identifier: Apache-2.0
/* Numbers of options, and keys: values that change over frames, written as
 * "1001:0.5,1050:2", lists as "1001:960/200,1050:990/180", or as "@FILE" with a
 * line "frame,value" or "frame,x,y" for each key. */
#ifndef GP_CLI_KEYS_H
#define GP_CLI_KEYS_H

#include "cli/options.h"

/* An option as it is given, and its value. */
struct gp_use {
    const struct gp_log *log;
    const struct gp_option *option;
    const char *value; // NULL for options that take none
};

/* Reads the value of an option of numbers, GP_KIND_FLOAT to GP_KIND_NUMBERS, and
 * checks its range. Errors: GP_ERR_USAGE. */
GP_MUST_CHECK gp_status gp_quantity_read(const struct gp_use *u,
                                         struct gp_quantity *out);

/* Sets the field of that option in *s. */
void gp_quantity_set(const struct gp_option *o, const struct gp_quantity *v,
                     struct gp_settings *s);

enum { GP_KEYS_MOST = 10000 }; // of one option

/* Reads keys, checks the range of each, and adds them to *s, which has none of
 * that option; the value is borrowed.
 * Errors: GP_ERR_USAGE the option does not change over frames; frames that do
 * not rise, values out of range, of other units or counts; GP_ERR_IO,
 * GP_ERR_DATA of the file. */
GP_MUST_CHECK gp_status gp_keys_read(const struct gp_use *u,
                                     struct gp_settings *s);

/* Removes the keys of an option, if it has any. */
void gp_keys_drop(struct gp_settings *s, const struct gp_option *o);

/* Copies the settings with the values of a frame. *out borrows all that s owns:
 * it is not freed, and must not move. */
void gp_settings_at(const struct gp_settings *s, int frame,
                    struct gp_settings *out);

#endif
