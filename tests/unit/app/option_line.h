/* Command lines as text, parsed, and what is said of them. */
#ifndef GP_TESTS_OPTION_LINE_H
#define GP_TESTS_OPTION_LINE_H

#include "app/options.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { WORDS = 40, LINE = 4096 };

static char said[LINE];  // the last message
static int lines;        // how many there were

static inline void keep_line(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    lines++;
    snprintf(said, sizeof said, "%s", line);
}

static const struct gp_log keeper = {keep_line, NULL, GP_LEVEL_INFO};

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
    said[0] = '\0';
    lines = 0;
    return gp_options_parse(&keeper, argc, argv, s);
}

#endif
