// SPDX-License-Identifier: Apache-2.0
/* Command lines as text, parsed, and their messages. */
#ifndef GP_TESTS_OPTION_LINE_H
#define GP_TESTS_OPTION_LINE_H

#include "cli/options.h"

#include "kept_log.h"

enum { WORDS = 64 };

/* Parses a line of words with single blanks between; '' is an empty word. */
static inline gp_status parse(const char *line, struct gp_settings *s)
{
    static char copy[1024];
    char *argv[WORDS] = {"glarepp"};
    int argc = 1;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *w = strtok(copy, " "); w && argc < WORDS - 1;
         w = strtok(NULL, " "))
        argv[argc++] = strcmp(w, "''") == 0 ? "" : w;
    kept_clear();
    return gp_options_parse(&kept_all, argc, argv, s);
}

#endif
