// SPDX-License-Identifier: Apache-2.0
/* Logs that keep lines: kept_log the last error's and its parameter, kept_all
 * those of any message; both the last warning's. They count errors and lines. */
#ifndef GP_TESTS_KEPT_LOG_H
#define GP_TESTS_KEPT_LOG_H

#include "core/status.h"
#include "unit.h"

static char kept_line[4096], kept_parameter[64], kept_warning[1024];
static int kept_errors, kept_lines;

static inline void kept_sink(void *user, const struct gp_line *message)
{
    const enum gp_level level = message->level;
    const char *const line = message->text;
    const int error = level == GP_LEVEL_ERROR || level == GP_LEVEL_BARE;
    kept_lines++;
    kept_errors += error;
    if (error || user) {
        snprintf(kept_line, sizeof kept_line, "%s", line);
        snprintf(kept_parameter, sizeof kept_parameter, "%s",
                 message->parameter);
    }
    if (level == GP_LEVEL_WARN)
        snprintf(kept_warning, sizeof kept_warning, "%s", line);
}

static const struct gp_log kept_log = {kept_sink, NULL, GP_LEVEL_WARN};
static const struct gp_log kept_all = {kept_sink, kept_line, GP_LEVEL_INFO};

static inline void kept_clear(void)
{
    kept_errors = kept_lines = 0;
    kept_line[0] = kept_parameter[0] = kept_warning[0] = '\0';
}

/* The line that is kept has this in it. */
static inline void assert_kept(const char *part)
{
    if (!strstr(kept_line, part))
        fail_msg("\"%s\" is not in: %s", part, kept_line);
}

#endif
