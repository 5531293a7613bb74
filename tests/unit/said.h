/* Logs that keep lines: said_log the last error's, said_all that of any
 * message; both the last warning's. They count errors and lines. */
#ifndef GP_TESTS_SAID_H
#define GP_TESTS_SAID_H

#include "core/status.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char said_line[4096], said_warning[1024];
static int said_errors, said_lines;

static inline void said_keep(void *user, enum gp_level level, const char *line)
{
    const int error = level == GP_LEVEL_ERROR || level == GP_LEVEL_BARE;
    said_lines++;
    said_errors += error;
    if (error || user)
        snprintf(said_line, sizeof said_line, "%s", line);
    if (level == GP_LEVEL_WARN)
        snprintf(said_warning, sizeof said_warning, "%s", line);
}

static const struct gp_log said_log = {said_keep, NULL, GP_LEVEL_WARN};
static const struct gp_log said_all = {said_keep, said_line, GP_LEVEL_INFO};

static inline void said_nothing(void)
{
    said_errors = said_lines = 0;
    said_line[0] = said_warning[0] = '\0';
}

#endif
