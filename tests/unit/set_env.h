/* Variables of the environment as the program passes them on. */
#ifndef SET_ENV_H
#define SET_ENV_H

#include "app/environment.h"

#include <stdlib.h>

/* Sets a variable, removes it where `value` is NULL, or leaves all as they are
 * where `name` is; then reads them for this thread. */
static inline int set_env(const char *name, const char *value)
{
    static struct gp_env env;
    const int failed = !name ? 0
                       : value ? setenv(name, value, 1) : unsetenv(name);
    gp_environment_read(&env);
    gp_env_use(&env);
    return failed;
}

#endif
