// SPDX-License-Identifier: Apache-2.0
/* Allocation with checked sizes. Every function that allocates fails with
 * GP_ERR_BUG where memory is full; contracts in private headers do not repeat
 * it. */
#ifndef GP_CORE_MEMORY_H
#define GP_CORE_MEMORY_H

#include "core/status.h"

#include <stddef.h>

/* Every block starts on a cache line, which aligns any vector too. */
enum { GP_ALIGN = 64 };

/* Allocates `count` * `size` zeroed bytes at GP_ALIGN. `out` is the address of
 * any object pointer, which is NULL on failure, also of a product that
 * overflows.
 * Ownership passes to the caller; free with gp_free().
 * Errors: GP_ERR_BUG, with a line that names `what` and the bytes, and no
 * file: gp_fail_bare().
 */
GP_MUST_CHECK gp_status gp_alloc_zero(const struct gp_log *log,
    const char *what, size_t count, size_t size, void *out);

/* The same without zeroing, for planes that are written whole. */
GP_MUST_CHECK gp_status gp_alloc(const struct gp_log *log, const char *what,
                                 size_t count, size_t size, void *out);

/* Gives *block, which is NULL or from this function, a new size of `bytes` >= 1
 * and keeps its content, as far as it fits. The system moves pages of a large
 * block, so that old and new never exist at once. The block is aligned for any
 * type, but not at GP_ALIGN. On failure *block is as it was.
 * Errors: as gp_alloc(). */
GP_MUST_CHECK gp_status gp_resize(const struct gp_log *log, const char *what,
                                  size_t bytes, void **block);

/* Frees *p and sets it to NULL; `p` is the address of any object pointer.
 * Calling it twice is harmless. */
#define GP_FREE(p) (gp_free(p), (void) ((p) = NULL))
void gp_free(void *p);

/* Keeps the pages of freed blocks for the next ones, of any size: stages of a
 * frame take turns with them, and so do frames of a sequence.
 * For the whole process, until each call with true had one with false. */
void gp_keep_memory(bool keeps);

/* Returns a number > 0, unique in this process: caches compare it to see
 * whether their source is still the same. Call from any thread. */
unsigned long gp_serial_next(void);

/* A copy of a string, or NULL when memory is full. */
char *gp_strdup(const char *s);

#endif
