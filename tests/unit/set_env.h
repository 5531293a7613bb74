// SPDX-License-Identifier: Apache-2.0
/* Variables of the environment as the program passes them on. */
#ifndef SET_ENV_H
#define SET_ENV_H

#include "cli/machine.h"
#include "core/parallel.h"

#include <stdlib.h>

/* Sets a variable, removes it where `value` is NULL, or leaves all as they are
 * where `name` is; then reads them for this thread. */
static inline int set_env(const char *name, const char *value)
{
    static struct gp_env env;
    struct glarepp_params p = GLAREPP_PARAMS;
    const int failed = !name ? 0
                       : value ? setenv(name, value, 1) : unsetenv(name);
    gp_environment_read(&p);
    env = (struct gp_env) {
        .bridges = p.bridges, .data = p.data, .osmesa = p.osmesa, .egl = p.egl,
        .gl_size = p.gl_size,
    };
    gp_env_use(&env);
    return failed;
}

#endif
