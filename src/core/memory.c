#include "core/memory.h"

#include <malloc.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

/* Planes of this size ask for huge pages: a page fault for every 4 KiB of a
 * single frame at 1920x1080 took a fifth of the run's CPU time. */
enum { HUGE_PAGE = 2 << 20, LARGE = 4 << 20 };

gp_status gp_alloc(const struct gp_log *log, const char *what, size_t count,
                   size_t size, void **out)
{
    *out = NULL;
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) ||
        bytes > SIZE_MAX - HUGE_PAGE)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: more memory than there can be (%zu x %zu bytes); "
                       "use a smaller frame", what, count, size);
    // never no bytes: NULL is for failure alone
    if (posix_memalign(out, bytes < LARGE ? GP_ALIGN : HUGE_PAGE,
                       bytes ? bytes : 1) != 0)
        *out = NULL;
#ifdef MADV_HUGEPAGE
    if (*out && bytes >= LARGE)
        madvise(*out, bytes / HUGE_PAGE * HUGE_PAGE, MADV_HUGEPAGE);
#endif
    if (!*out)
        return gp_fail(log, GP_ERR_BUG,
                       "%s: out of memory (%zu bytes); use a smaller frame "
                       "or a machine with more memory", what, bytes);
    return GP_OK;
}

gp_status gp_alloc_zero(const struct gp_log *log, const char *what,
                        size_t count, size_t size, void **out)
{
    gp_status st = gp_alloc(log, what, count, size, out);
    if (!st)
        memset(*out, 0, count * size);
    return st;
}

void gp_free(void *p)
{
    free(p);
}

void gp_keep_memory(void)
{
    static const int huge = 32 << 20; // the most that glibc takes
    static const int kept = 1 << 30;  // at the heap's end, from frame to frame
    static const int heaps = 1; // a heap for each thread grows, frame by frame,
                                // by what another thread took and gives back
#ifdef __GLIBC__
    mallopt(M_MMAP_THRESHOLD, huge);
    mallopt(M_TRIM_THRESHOLD, kept);
    mallopt(M_ARENA_MAX, heaps);
#else
    (void) huge;
    (void) kept;
    (void) heaps;
#endif
}

char *gp_strdup(const char *s)
{
    size_t n = strlen(s) + 1;
    char *copy = malloc(n);
    if (copy)
        memcpy(copy, s, n);
    return copy;
}
