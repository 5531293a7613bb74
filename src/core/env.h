// SPDX-License-Identifier: Apache-2.0
/* The environment of a call: what a context of the library sets, and every
 * function below it finds through its thread. Threads of a parallel loop have
 * that of the loop's caller. */
#ifndef GP_CORE_ENV_H
#define GP_CORE_ENV_H

#include <locale.h>

struct gp_pool; // core/parallel.h

/* All borrowed; zero is what a thread starts with. */
struct gp_env {
    struct gp_pool *pool;        // of its loops; NULL: one that the process has
    const char *bridges;         // folder that is looked in first for bridges,
    const char *data;            // for flares/ and lenses/; NULL: none
    const char *osmesa, *egl;    // GL library files; NULL: the system's
    int gl_size;                 // largest side of a GL texture; 0: the driver's
    locale_t locale;             // of its calls; 0: the thread's own
};

/* Returns that of this thread. */
const struct gp_env *gp_env(void);

/* Sets it; returns the one before. Borrowed until another is set. */
const struct gp_env *gp_env_use(const struct gp_env *env);

#endif
