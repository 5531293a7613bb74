// SPDX-License-Identifier: Apache-2.0
/* The environment of a thread, and parallel loops whose result does not depend on the
 * number of threads.
 *
 * Any number of threads may run loops at once; those of one environment
 * share its pool, and never do more than gp_threads() threads work
 * at a time. A loop inside a body runs in that thread. A child of fork() must
 * not run loops on a pool that its parent used. */
#ifndef GP_CORE_PARALLEL_H
#define GP_CORE_PARALLEL_H

#include "core/status.h"

#include <locale.h>

/* Settings of a context of the library, which every function below it finds through its
 * thread. Threads of a parallel loop have that of the loop's caller. All borrowed; zero is
 * what a thread starts with. */
struct gp_env {
    struct gp_pool *pool;     // of its loops; NULL: one that the process has
    const char *bridges;      // folder that is looked in first for bridges,
    const char *data;         // for flares/ and lenses/; NULL: none
    const char *osmesa, *egl; // GL library files; NULL: the system's
    int gl_size;              // largest side of a GL texture; 0: the driver's
    locale_t locale;          // of its calls; 0: the thread's own
};

/* Returns that of this thread. */
const struct gp_env *gp_env(void);

/* Sets it; returns the one before. Borrowed until another is set. */
const struct gp_env *gp_env_use(const struct gp_env *env);

/* Makes a pool for environments; `threads` as in gp_set_threads(). No thread
 * starts before a loop needs it. Ends all of them when it is freed. */
GP_MUST_CHECK gp_status gp_pool_make(const struct gp_log *log, int threads,
                                     struct gp_pool **out);
void gp_pool_free(struct gp_pool **pool);

/* Sets the number of threads of every later loop of this thread's pool; 0 takes all processors
 * that the process may use. */
void gp_set_threads(int threads);

/* The number of threads that a loop will use, >= 1. */
int gp_threads(void);

/* Runs body(ctx, i, thread) for each i in [0, n), each once, in any order and
 * on any thread; `thread` is in [0, gp_threads()) and is for scratch buffers
 * only. To stay deterministic a body writes nothing that another i reads.
 * Bodies print nothing.
 *
 * When bodies fail, every i still below the first failure is run, and the
 * status of the lowest failing i is returned; *failed (may be NULL) is that i.
 */
typedef gp_status (*gp_body)(void *ctx, int i, int thread);
GP_MUST_CHECK gp_status gp_parallel(int n, gp_body body, void *ctx,
                                    int *failed);

/* The same for bodies that cannot fail. */
typedef void (*gp_task)(void *ctx, int i, int thread);
void gp_parallel_do(int n, gp_task task, void *ctx);

/* For threads that the program starts itself: enter() before work, which waits
 * until fewer than gp_threads() threads work; leave() before any wait and at
 * the end. Threads that help a loop give way to one that waits. In the process's
 * own pool the first thread counts as entered. */
void gp_parallel_enter(void);
void gp_parallel_leave(void);

#endif
