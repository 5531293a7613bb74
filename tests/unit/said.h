/* A log that keeps the last error's line and the last warning's, and counts
 * the errors. */
#ifndef GP_TESTS_SAID_H
#define GP_TESTS_SAID_H

#include "core/status.h"

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char said_line[4096], said_warning[1024];
static int said_errors;

static inline void said_keep(void *user, enum gp_level level, const char *line)
{
    (void) user;
    if (level == GP_LEVEL_WARN)
        snprintf(said_warning, sizeof said_warning, "%s", line);
    if (level != GP_LEVEL_ERROR && level != GP_LEVEL_BARE)
        return;
    said_errors++;
    snprintf(said_line, sizeof said_line, "%s", line);
}

static const struct gp_log said_log = {said_keep, NULL, GP_LEVEL_WARN};

static inline void said_nothing(void)
{
    said_errors = 0;
    said_line[0] = said_warning[0] = '\0';
}

#endif
