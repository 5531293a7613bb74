/* Makes one allocation of the program's own code fail: for tests that the
 * Makefile links with --wrap of these names. What libraries allocate for
 * themselves is not counted.
 *
 *   starve(n)  the n-th allocation from here on fails, from 1; 0: none
 */
#ifndef GP_TESTS_STARVE_H
#define GP_TESTS_STARVE_H

#include "core/status.h"

#include <errno.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static atomic_long starve_calls, starve_at;
static atomic_long starve_blocks; // allocated and not freed

static inline void starve(long n)
{
    atomic_store(&starve_calls, 0);
    atomic_store(&starve_at, n);
}

static inline bool starve_fired(void)
{
    const long at = atomic_load(&starve_at);
    return at > 0 && atomic_load(&starve_calls) >= at;
}

static inline bool starve_now(void)
{
    return atomic_fetch_add(&starve_calls, 1) + 1 == atomic_load(&starve_at);
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
int __real_posix_memalign(void **p, size_t align, size_t size);
int __wrap_posix_memalign(void **p, size_t align, size_t size);
void __real_free(void *p);
void __wrap_free(void *p);

void *__wrap_malloc(size_t size)
{
    void *const p = starve_now() ? NULL : __real_malloc(size);
    if (p)
        atomic_fetch_add(&starve_blocks, 1);
    return p;
}

/* Never refused: the program has no use for it, only its tests. */
void *__wrap_calloc(size_t count, size_t size)
{
    void *const p = __real_calloc(count, size);
    if (p)
        atomic_fetch_add(&starve_blocks, 1);
    return p;
}

int __wrap_posix_memalign(void **p, size_t align, size_t size)
{
    if (starve_now())
        return ENOMEM;
    const int error = __real_posix_memalign(p, align, size);
    if (!error)
        atomic_fetch_add(&starve_blocks, 1);
    return error;
}

void __wrap_free(void *p)
{
    if (p)
        atomic_fetch_sub(&starve_blocks, 1);
    __real_free(p);
}

/* -- what was said --------------------------------------------------------- */

static char said_line[1024];
static int said_errors;

static inline void said_keep(void *user, enum gp_level level, const char *line)
{
    (void) user;
    if (level != GP_LEVEL_ERROR && level != GP_LEVEL_BARE)
        return;
    said_errors++;
    snprintf(said_line, sizeof said_line, "%s", line);
}

static const struct gp_log said_log = {said_keep, NULL, GP_LEVEL_WARN};

static inline void said_nothing(void)
{
    said_errors = 0;
    said_line[0] = '\0';
}

#endif
