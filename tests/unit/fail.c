/* The calls of the system that tests make fail; see fail.h. Those of a whole
 * program, from outside it, are tests/faults/shim.c's. */
#include "fail.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>

static _Atomic(enum fail_class) armed;
static atomic_long calls, nth, blocks;
struct fail_always fail_always;
_Atomic mode_t fail_made_mode;

void fail_at(enum fail_class class, long n)
{
    atomic_store(&calls, 0);
    atomic_store(&nth, n);
    atomic_store(&armed, class);
}

bool fail_end(void)
{
    const bool was = atomic_exchange(&armed, FAIL_NONE) != FAIL_NONE;
    return was && atomic_load(&calls) >= atomic_load(&nth);
}

long fail_blocks(void)
{
    return atomic_load(&blocks);
}

static bool hits(enum fail_class class, int error)
{
    if (class != atomic_load(&armed) ||
        atomic_fetch_add(&calls, 1) + 1 != atomic_load(&nth))
        return false;
    errno = error;
    return true;
}

/* Defines the call `name`, which returns `bad` with errno `error`. */
#define CALL(class, error, bad, type, name, parameters, arguments)            \
    type __real_##name parameters;                                            \
    type __wrap_##name parameters;                                            \
    type __wrap_##name parameters                                             \
    {                                                                         \
        if (hits(FAIL_##class, error))                                        \
            return bad;                                                       \
        return __real_##name arguments;                                       \
    }

CALL(IO, EIO, -1, ssize_t, read, (int fd, void *to, size_t n), (fd, to, n))
CALL(IO, EIO, -1, ssize_t, pread, (int fd, void *to, size_t n, off_t at),
     (fd, to, n, at))
CALL(IO, ENOSPC, -1, ssize_t, write, (int fd, const void *from, size_t n),
     (fd, from, n))
CALL(IO, ENOSPC, -1, ssize_t, pwrite,
     (int fd, const void *from, size_t n, off_t at), (fd, from, n, at))
CALL(IO, EIO, -1, int, fstat, (int fd, struct stat *s), (fd, s))
CALL(IO, EACCES, -1, int, rename, (const char *a, const char *b), (a, b))
CALL(IO, EMFILE, -1, int, memfd_create, (const char *name, unsigned flags),
     (name, flags))

int __wrap_close(int fd);
int __wrap_close(int fd)
{
    const bool bad = fail_always.closes || hits(FAIL_IO, EIO);
    const int result = __real_close(fd); // it is closed all the same
    if (bad)
        errno = EIO;
    return bad ? -1 : result;
}

int __wrap_open(const char *path, int flags, ...);
int __wrap_open(const char *path, int flags, ...)
{
    va_list arguments;
    va_start(arguments, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(arguments, mode_t) : 0;
    va_end(arguments);
    if (flags & O_CREAT)
        fail_made_mode = mode;
    return hits(FAIL_IO, EMFILE) ? -1 : __real_open(path, flags, mode);
}

// -- memory -------------------------------------------------------------------

static void *counted(void *p)
{
    if (p)
        atomic_fetch_add(&blocks, 1);
    return p;
}

void *__real_malloc(size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_malloc(size_t size)
{
    return hits(FAIL_ALLOC, ENOMEM) ? NULL : counted(__real_malloc(size));
}

/* Never refused: the program does not call it, only its tests do. */
void *__real_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_calloc(size_t count, size_t size)
{
    return counted(__real_calloc(count, size));
}

void *__real_realloc(void *p, size_t size);
void *__wrap_realloc(void *p, size_t size);
void *__wrap_realloc(void *p, size_t size)
{
    if (hits(FAIL_ALLOC, ENOMEM))
        return NULL;
    return p ? __real_realloc(p, size) : counted(__real_realloc(NULL, size));
}

int __real_posix_memalign(void **p, size_t align, size_t size);
int __wrap_posix_memalign(void **p, size_t align, size_t size);
int __wrap_posix_memalign(void **p, size_t align, size_t size)
{
    if (hits(FAIL_ALLOC, ENOMEM))
        return ENOMEM;
    const int error = __real_posix_memalign(p, align, size);
    if (!error)
        counted(*p);
    return error;
}

void __real_free(void *p);
void __wrap_free(void *p);
void __wrap_free(void *p)
{
    if (p)
        atomic_fetch_sub(&blocks, 1);
    __real_free(p);
}

// -- threads, processors, libraries -------------------------------------------

int __real_pthread_create(pthread_t *id, const pthread_attr_t *attributes,
                          void *(*body)(void *), void *arg);
int __wrap_pthread_create(pthread_t *id, const pthread_attr_t *attributes,
                          void *(*body)(void *), void *arg);
int __wrap_pthread_create(pthread_t *id, const pthread_attr_t *attributes,
                          void *(*body)(void *), void *arg)
{
    if (fail_always.threads || hits(FAIL_THREAD, EAGAIN))
        return EAGAIN;
    return __real_pthread_create(id, attributes, body, arg);
}

int __real_sched_getaffinity(pid_t pid, size_t size, cpu_set_t *set);
int __wrap_sched_getaffinity(pid_t pid, size_t size, cpu_set_t *set);
int __wrap_sched_getaffinity(pid_t pid, size_t size, cpu_set_t *set)
{
    return fail_always.affinity ? -1
                                : __real_sched_getaffinity(pid, size, set);
}

ssize_t __real_readlink(const char *path, char *to, size_t size);
ssize_t __wrap_readlink(const char *path, char *to, size_t size);
ssize_t __wrap_readlink(const char *path, char *to, size_t size)
{
    return fail_always.links ? -1 : __real_readlink(path, to, size);
}

void *__real_dlopen(const char *file, int flags);
void *__wrap_dlopen(const char *file, int flags);
void *__wrap_dlopen(const char *file, int flags)
{
    const bool gone = fail_always.library && file &&
                      strcmp(file, fail_always.library) == 0;
    return __real_dlopen(gone ? "/nonexistent/library.so" : file, flags);
}

// -- answers of GL ------------------------------------------------------------

typedef void (*function)(void);
enum { OUT_OF_MEMORY = 0x0505 }; // GL_OUT_OF_MEMORY

/* The two libraries that contexts come from: how each finds a function, and
 * its glGetError(). */
static struct {
    function (*find)(const char *name);
    unsigned (*error)(void);
} libraries[2];

static unsigned answer(int i)
{
    return hits(FAIL_GL, 0) ? OUT_OF_MEMORY : libraries[i].error();
}

static unsigned osmesa_error(void)
{
    return answer(0);
}

static unsigned egl_error(void)
{
    return answer(1);
}

static function find_in(int i, const char *name)
{
    const function f = libraries[i].find(name);
    if (!f || strcmp(name, "glGetError") != 0)
        return f;
    libraries[i].error = (unsigned (*)(void)) f;
    return i ? (function) egl_error : (function) osmesa_error;
}

static function osmesa_find(const char *name)
{
    return find_in(0, name);
}

static function egl_find(const char *name)
{
    return find_in(1, name);
}

void *__real_dlsym(void *library, const char *name);
void *__wrap_dlsym(void *library, const char *name);
void *__wrap_dlsym(void *library, const char *name)
{
    static const struct {
        const char *name;
        function (*find)(const char *name);
    } hooks[2] = {{"OSMesaGetProcAddress", osmesa_find},
                  {"eglGetProcAddress", egl_find}};
    void *symbol = fail_always.symbol && strcmp(name, fail_always.symbol) == 0
                       ? NULL : __real_dlsym(library, name);
    for (int i = 0; symbol && i < 2; i++) {
        if (strcmp(name, hooks[i].name) == 0) {
            memcpy(&libraries[i].find, &symbol, sizeof symbol);
            memcpy(&symbol, &hooks[i].find, sizeof symbol);
            break;
        }
    }
    return symbol;
}
