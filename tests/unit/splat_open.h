/* A context for tests of the splat engine's parts, and how it may draw. */
#ifndef GP_TESTS_SPLAT_OPEN_H
#define GP_TESTS_SPLAT_OPEN_H

#include "glare/splat/splat_priv.h"
#include "splat_scene.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

enum { PRIMITIVES = 3 };
static const enum gp_primitive primitives[PRIMITIVES] = {
    GP_PRIMITIVE_QUAD, GP_PRIMITIVE_POINT, GP_PRIMITIVE_TILE,
};

/* Makes the engine's state with a context, or skips the test without one. */
static inline gp_status open_or_skip(void **state)
{
    gp_status st = gp_splat_make(&log_kept, state);
    if (!st)
        st = gp_splat_open(&log_kept, *state, GP_GL_AUTO);
    if (st == GP_ERR_GL && strstr(last_line, "install the Debian")) {
        print_message("no context: %s\n", last_line);
        skip();
    }
    return st;
}

#endif
