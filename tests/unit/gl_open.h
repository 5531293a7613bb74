// SPDX-License-Identifier: Apache-2.0
/* A context for tests that draw. Their log is kept_log.h's. */
#ifndef GP_TESTS_GL_OPEN_H
#define GP_TESTS_GL_OPEN_H

#include "gl/gl_priv.h"
#include "kept_log.h"
#include "unit.h"

/* A context, or a skip where the machine has no such library. */
static inline struct gp_gl *open_or_skip(enum gp_gl_api api)
{
    struct gp_gl *gl = NULL;
    kept_clear();
    if (gp_gl_open(&kept_log, api, &gl) != GP_OK) {
        print_message("no context: %s\n", kept_line);
        skip_for("no GL");
    }
    return gl;
}

#endif
