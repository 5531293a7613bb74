/* A context for tests that draw, and the last line that was said. */
#ifndef GP_TESTS_GL_OPEN_H
#define GP_TESTS_GL_OPEN_H

#include "gl/gl.h"
#include "unit.h"

static char last_line[4096];

static void keep(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(last_line, sizeof last_line, "%s", line);
}

static const struct gp_log log_kept = {keep, NULL, GP_LEVEL_INFO};

static inline void assert_said(const char *part)
{
    if (!strstr(last_line, part))
        fail_msg("\"%s\" is not in \"%s\"", part, last_line);
}

/* A context, or a skip where the machine has no such library. */
static inline struct gp_gl *open_or_skip(enum gp_gl_api api)
{
    struct gp_gl *gl = NULL;
    if (gp_gl_open(&log_kept, api, &gl) != GP_OK) {
        print_message("no context: %s\n", last_line);
        skip();
    }
    return gl;
}

#endif
