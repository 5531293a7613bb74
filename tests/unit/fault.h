/* Calls that fail: memory, or those on files, the n-th from when it was armed.
 * A test that includes this is linked with -Wl,--wrap (FAULT_WRAP in the
 * Makefile); it hears the calls of src/, not those of libraries. */
#ifndef FAULT_H
#define FAULT_H

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/stat.h>
#include <sys/types.h>

enum fault_kind { FAULT_NONE, FAULT_MEMORY, FAULT_FILES };

static enum fault_kind fault_armed;
static atomic_int fault_calls;
static int fault_at;

static bool fault_hits(enum fault_kind kind, int error)
{
    if (kind != fault_armed ||
        atomic_fetch_add(&fault_calls, 1) + 1 != fault_at)
        return false;
    errno = error;
    return true;
}

static void fault_arm(enum fault_kind kind, int n)
{
    atomic_store(&fault_calls, 0);
    fault_at = n;
    fault_armed = kind;
}

/* Whether the call came that had to fail. */
static bool fault_disarm(void)
{
    fault_armed = FAULT_NONE;
    return atomic_load(&fault_calls) >= fault_at;
}

#define FAULT_CALL(kind, error, bad, type, name, parameters, arguments)       \
    type __real_##name parameters;                                            \
    type __wrap_##name parameters;                                            \
    type __wrap_##name parameters                                             \
    {                                                                         \
        if (fault_hits(FAULT_##kind, error))                                  \
            return bad;                                                       \
        return __real_##name arguments;                                       \
    }

FAULT_CALL(MEMORY, ENOMEM, NULL, void *, malloc, (size_t n), (n))
FAULT_CALL(MEMORY, ENOMEM, NULL, void *, calloc, (size_t n, size_t m), (n, m))
FAULT_CALL(MEMORY, ENOMEM, NULL, void *, realloc, (void *p, size_t n), (p, n))
FAULT_CALL(MEMORY, ENOMEM, ENOMEM, int, posix_memalign,
           (void **p, size_t align, size_t n), (p, align, n))
FAULT_CALL(FILES, EIO, -1, ssize_t, read, (int fd, void *to, size_t n),
           (fd, to, n))
FAULT_CALL(FILES, EIO, -1, ssize_t, pread,
           (int fd, void *to, size_t n, off_t at), (fd, to, n, at))
FAULT_CALL(FILES, ENOSPC, -1, ssize_t, write,
           (int fd, const void *from, size_t n), (fd, from, n))
FAULT_CALL(FILES, ENOSPC, -1, ssize_t, pwrite,
           (int fd, const void *from, size_t n, off_t at), (fd, from, n, at))
FAULT_CALL(FILES, EIO, -1, int, fstat, (int fd, struct stat *s), (fd, s))
FAULT_CALL(FILES, EACCES, -1, int, rename, (const char *a, const char *b),
           (a, b))
FAULT_CALL(FILES, EMFILE, -1, int, memfd_create,
           (const char *name, unsigned flags), (name, flags))

int __real_close(int fd);
int __wrap_close(int fd);
int __wrap_close(int fd)
{
    const bool bad = fault_hits(FAULT_FILES, EIO);
    const int result = __real_close(fd); // it is closed all the same
    if (bad)
        errno = EIO;
    return bad ? -1 : result;
}

int __real_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    return fault_hits(FAULT_FILES, EMFILE) ? -1
                                           : __real_open(path, flags, mode);
}

#endif
