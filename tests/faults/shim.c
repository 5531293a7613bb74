// SPDX-License-Identifier: Apache-2.0
/* Makes calls of the system, of malloc and of GL fail. One source, built twice:
 *
 *   shim.o   with FAIL_WRAPPED, linked into the unit tests with --wrap of these
 *            calls (FAIL_WRAP in tests/Makefile): fail.h says which call fails.
 *            Only the program's own calls count.
 *   shim.so  for a whole program, by LD_PRELOAD; the environment says which:
 *
 *     FAULT=KIND:N[+][:ERRNO]   the N-th call of that kind fails, from 1 on;
 *                               with + every later one too
 *     FAULT_LOG=FILE            gets a line "fired" when it happens, and at
 *                               the end of main a line "KIND COUNT" for each
 *                               kind, and "leaked COUNT": blocks of memory that
 *                               the program still has
 *
 * Kinds without a class of fail.h: short: the N-th read gives half of what it
 * could; truncate: the file is cut to half before the N-th read, and grow: is
 * made longer; space: N counts bytes, the bytes before are written and every
 * later write fails; term: SIGTERM comes when the N-th open() has made or found
 * its file.
 *
 * In the preloaded form only calls of a program named .../glarepp count, from
 * its main on, and only those of the program itself, its bridges and the C
 * libraries it links with. Those made inside Mesa, LLVM, FFTW, OpenImageIO,
 * OpenColorIO and the dynamic linker do not: with a full memory these libraries
 * end the process themselves.
 */
#include "fail.h"
#ifndef FAIL_WRAPPED
#include "blocks.h"
#endif

#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <limits.h>
#include <link.h>
#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>
#include <unwind.h>

// (kind, class, errno)
// clang-format off
#define KINDS(X)                                                     \
    X(malloc, ALLOC, ENOMEM) X(open, IO, EACCES) X(close, IO, EIO)   \
    X(rename, IO, EACCES) X(unlink, IO, EACCES) X(fchmod, IO, EPERM) \
    X(ftruncate, IO, EIO) X(fdopen, IO, ENOMEM) X(fstat, IO, EIO)    \
    X(fsync, IO, EIO) X(memfd, IO, EMFILE) X(read, IO, EIO)          \
    X(write, IO, ENOSPC) X(thread, THREAD, EAGAIN) X(error, GL, 0)   \
    X(space, NONE, ENOSPC) X(short, NONE, 0) X(truncate, NONE, 0)    \
    X(grow, NONE, 0) X(term, NONE, 0)
// clang-format on
#define ENUM(name, class, error) KIND_##name,
#define NAME(name, class, error) #name,
#define CLASS(name, class, error) FAIL_##class,
#define ERROR(name, class, error) error,
enum kind { KINDS(ENUM) KIND_COUNT };

static const int errors[] = {KINDS(ERROR)};
#ifdef FAIL_WRAPPED
static const enum fail_class classes[] = {KINDS(CLASS)};
#else
static const char *const names[] = {KINDS(NAME)};
#endif

/* The fault: the nth call of the kinds in `wanted`, and with `later` those
 * after it; `own_errno`, where not 0, is in place of the kind's. */
static atomic_uint wanted; // a bit for each kind
static atomic_long nth, tried, calls[KIND_COUNT];
static atomic_bool by_path, fired;
static bool later;
static int own_errno;
#ifdef FAIL_WRAPPED
static atomic_long blocks; // allocated and not freed
#endif
struct fail_always fail_always;
_Atomic mode_t fail_made_mode;

/* Define, in either form, a call; call the system's; and ask whether it fails.
 * CALL defines one that only fails or does not. */
#ifdef FAIL_WRAPPED
#define DEFINE(type, name, ...)                                               \
    type __real_##name(__VA_ARGS__);                                          \
    type __wrap_##name(__VA_ARGS__);                                          \
    type __wrap_##name(__VA_ARGS__)
#define REAL(name) __real_##name
#else
#define DEFINE(type, name, ...) type name(__VA_ARGS__)
#define REAL(name)                                                            \
    ({                                                                        \
        static __typeof__(&name) next;                                        \
        if (!next)                                                            \
            next = (__typeof__(&name)) dlsym(RTLD_NEXT, #name);               \
        next;                                                                 \
    })
#endif
#define FAILS(kind) fails(KIND_##kind, __builtin_return_address(0))
#define PACK(...) __VA_ARGS__
#define CALL(kind, bad, type, name, parameters, arguments)                    \
    DEFINE(type, name, PACK parameters)                                       \
    {                                                                         \
        return FAILS(kind) ? bad : REAL(name) arguments;                      \
    }

// -- the fault ---------------------------------------------------------------

static bool counts(const void *caller);
static void note(const char *line);

/* A path to a call: the addresses of its callers. */
struct path {
    uint64_t hash;
    int seen, failed; // in this run, and since fail_forget()
};
enum { PATHS = 2048, DEPTH = 40, TIMES = 2 };
static struct path paths[PATHS];
static int path_count;
static pthread_mutex_t paths_lock = PTHREAD_MUTEX_INITIALIZER;

/* True when this call is the first that fail_next() has not yet tried. */
static bool path_is_due(void)
{
    void *callers[DEPTH];
    uint64_t hash = 0xcbf29ce484222325u;
    const int n = backtrace(callers, DEPTH);
    for (int i = 0; i < n; i++)
        hash = (hash ^ (uintptr_t) callers[i]) * 0x100000001b3u;
    pthread_mutex_lock(&paths_lock);
    struct path *p = paths;
    while (p < paths + path_count && p->hash != hash)
        p++;
    if (p == paths + PATHS)
        abort();
    if (p == paths + path_count) {
        *p = (struct path) {.hash = hash};
        path_count++;
    }
    const bool due = !atomic_load(&fired) && p->failed < TIMES &&
                     p->seen++ == p->failed;
    if (due) {
        p->failed++;
        atomic_store(&fired, true);
    }
    pthread_mutex_unlock(&paths_lock);
    return due;
}

static void fire(void)
{
    if (!atomic_exchange(&fired, true))
        note("fired\n");
}

static bool is_due(enum kind kind)
{
    atomic_fetch_add(&calls[kind], 1);
    if ((kind == KIND_close && fail_always.closes) ||
        (kind == KIND_thread && fail_always.threads))
        return true;
    if (!(atomic_load(&wanted) >> kind & 1u))
        return false;
    if (by_path)
        return path_is_due();
    const long n = atomic_fetch_add(&tried, 1) + 1;
    if (n < nth || (n > nth && !later))
        return false;
    fire();
    return true;
}

/* True when this call must fail; errno is set. */
static bool fails(enum kind kind, const void *caller)
{
    if (!counts(caller) || !is_due(kind))
        return false;
    errno = own_errno ? own_errno : errors[kind];
    return true;
}

// -- what counts: in the unit tests, all of the program's own calls ----------

#ifdef FAIL_WRAPPED
static bool counts(const void *caller)
{
    (void) caller;
    return true;
}

static void note(const char *line)
{
    (void) line;
}

static void arm(enum fail_class class, long n)
{
    unsigned kinds = 0;
    for (int k = 0; k < KIND_COUNT; k++)
        kinds |= (unsigned) (class != FAIL_NONE && classes[k] == class) << k;
    atomic_store(&tried, 0);
    atomic_store(&fired, false);
    nth = n;
    atomic_store(&wanted, kinds);
}

void fail_at(enum fail_class class, long n)
{
    by_path = false;
    arm(class, n);
}

void fail_forget(void)
{
    path_count = 0;
}

void fail_next(enum fail_class class)
{
    void *first[1];
    backtrace(first, 1); // it allocates when it is first called
    for (int i = 0; i < path_count; i++)
        paths[i].seen = 0;
    by_path = true;
    arm(class, 0);
}

bool fail_end(void)
{
    return atomic_exchange(&wanted, 0) && atomic_load(&fired);
}

long fail_blocks(void)
{
    return atomic_load(&blocks);
}

// -- what counts: in a whole program, calls of its own from main on ----------

#else
static char log_path[4096];
static atomic_bool counting;
static _Thread_local bool inside; // the shim's own calls

enum module { FOREIGN, OURS, PASSING };

/* PASSING: it allocates for its caller. */
static enum module module_of(const void *address)
{
    static const char *const ours[] = {"/glarepp-", "/libOpenEXRCore",
                                       "/libpng", "/libz.", "/libdeflate",
                                       "/libjansson"};
    static const char *const passing[] = {"/libc.so", "/libstdc++", "/libgcc_s",
                                          "/shim.so"};
    struct dl_find_object found;
    if (_dl_find_object((void *) address, &found))
        return FOREIGN;
    const char *name = found.dlfo_link_map->l_name;
    if (!name[0])
        return OURS; // the program
    for (size_t i = 0; i < sizeof ours / sizeof *ours; i++) {
        if (strstr(name, ours[i]))
            return OURS;
    }
    for (size_t i = 0; i < sizeof passing / sizeof *passing; i++) {
        if (strstr(name, passing[i]))
            return PASSING;
    }
    return FOREIGN;
}

static _Unwind_Reason_Code step(struct _Unwind_Context *c, void *out)
{
    *(enum module *) out = module_of((const void *) _Unwind_GetIP(c));
    return *(enum module *) out == PASSING ? _URC_NO_REASON
                                           : _URC_NORMAL_STOP;
}

static bool is_ours(const void *caller)
{
    enum module m = module_of(caller);
    if (m == PASSING) {
        inside = true;
        _Unwind_Backtrace(step, &m);
        inside = false;
    }
    return m == OURS;
}

static bool counts(const void *caller)
{
    return atomic_load(&counting) && !inside && is_ours(caller);
}

static void note(const char *line)
{
    if (!log_path[0])
        return;
    const int fd = (int) syscall(SYS_openat, AT_FDCWD, log_path,
                                 O_WRONLY | O_CREAT | O_APPEND, 0666);
    if (fd < 0)
        return;
    (void) !syscall(SYS_write, fd, line, strlen(line));
    syscall(SYS_close, fd);
}

static void print_counts(void)
{
    char line[64];
    for (int i = 0; i < KIND_COUNT; i++) {
        snprintf(line, sizeof line, "%s %ld\n", names[i],
                 atomic_load(&calls[i]));
        note(line);
    }
    snprintf(line, sizeof line, "leaked %ld\n", count_blocks());
    note(line);
}

static void parse(const char *text)
{
    static const struct { const char *name; int value; } words[] = {
        {"EIO", EIO}, {"ENOSPC", ENOSPC}, {"EDQUOT", EDQUOT},
        {"EACCES", EACCES}, {"EMFILE", EMFILE}, {"EINTR", EINTR},
        {"EROFS", EROFS}, {"EPIPE", EPIPE}};
    const char *colon = strchr(text, ':');
    for (int i = 0; colon && i < KIND_COUNT; i++) {
        if (strlen(names[i]) == (size_t) (colon - text) &&
            strncmp(names[i], text, (size_t) (colon - text)) == 0)
            wanted = 1u << i;
    }
    if (!wanted)
        return;
    char *end;
    nth = strtol(colon + 1, &end, 10);
    later = *end == '+';
    const char *word = strchr(end, ':');
    for (size_t i = 0; word && i < sizeof words / sizeof *words; i++) {
        if (strcmp(word + 1, words[i].name) == 0)
            own_errno = words[i].value;
    }
}

static int (*real_main)(int, char **, char **);

static int counted_main(int argc, char **argv, char **env)
{
    atomic_store(&counting, true);
    const int status = real_main(argc, argv, env);
    atomic_store(&counting, false);
    print_counts();
    return status;
}

typedef int (*start)(int (*)(int, char **, char **), int, char **,
                     void (*)(void), void (*)(void), void (*)(void), void *);

int __libc_start_main(int (*m)(int, char **, char **), int argc, char **argv,
                      void (*init)(void), void (*fini)(void),
                      void (*rtld_fini)(void), void *stack_end)
{
    const start next = (start) dlsym(RTLD_NEXT, "__libc_start_main");
    const char *fault = getenv("FAULT"), *log = getenv("FAULT_LOG");
    const char *slash = argv[0] ? strrchr(argv[0], '/') : NULL;
    // a shell on the way to the program starts as ever
    if (!slash || strcmp(slash + 1, "glarepp") != 0)
        return next(m, argc, argv, init, fini, rtld_fini, stack_end);
    if (fault)
        parse(fault);
    if (log && strlen(log) < sizeof log_path)
        strcpy(log_path, log);
    real_main = m;
    return next(counted_main, argc, argv, init, fini, rtld_fini, stack_end);
}
#endif

// -- memory ------------------------------------------------------------------

#ifdef FAIL_WRAPPED
static void *counted(void *p, const void *caller)
{
    (void) caller;
    if (p)
        atomic_fetch_add(&blocks, 1);
    return p;
}
#else
static void *counted(void *p, const void *caller)
{
    return counts(caller) ? add_block(p) : p;
}
#endif
#define COUNTED(p) counted(p, __builtin_return_address(0))

DEFINE(void *, malloc, size_t size)
{
    return FAILS(malloc) ? NULL : COUNTED(REAL(malloc)(size));
}

/* The program itself does not call it, only its tests and libraries do. */
DEFINE(void *, calloc, size_t count, size_t size)
{
#ifndef FAIL_WRAPPED
    if (FAILS(malloc))
        return NULL;
#endif
    return COUNTED(REAL(calloc)(count, size));
}

DEFINE(void *, realloc, void *p, size_t size)
{
    if (FAILS(malloc))
        return NULL;
#ifdef FAIL_WRAPPED
    return p ? REAL(realloc)(p, size) : COUNTED(REAL(realloc)(NULL, size));
#else
    const bool had = remove_block(p);
    void *moved = REAL(realloc)(p, size);
    if (had && !moved && size)
        add_block(p);
    return !p ? COUNTED(moved) : had ? add_block(moved) : moved;
#endif
}

DEFINE(int, posix_memalign, void **p, size_t align, size_t size)
{
    if (FAILS(malloc))
        return ENOMEM;
    const int error = REAL(posix_memalign)(p, align, size);
    if (!error)
        COUNTED(*p);
    return error;
}

DEFINE(void, free, void *p)
{
#ifdef FAIL_WRAPPED
    if (p)
        atomic_fetch_sub(&blocks, 1);
#else
    remove_block(p);
#endif
    REAL(free)(p);
}

#ifndef FAIL_WRAPPED
DEFINE(void *, aligned_alloc, size_t align, size_t size)
{
    return FAILS(malloc) ? NULL : COUNTED(REAL(aligned_alloc)(align, size));
}
#endif

// -- files -------------------------------------------------------------------

/* Cuts the file to half, or lets it grow; false fails the read instead. What
 * has no name (a file in memory) is nobody else's to change. */
static bool alter_input(int fd, bool grow)
{
    struct stat s;
    char path[64];
    if (fstat(fd, &s) || !S_ISREG(s.st_mode))
        return false;
    if (s.st_nlink == 0)
        return true;
    snprintf(path, sizeof path, "/proc/self/fd/%d", fd);
    return syscall(SYS_truncate, path,
                   grow ? s.st_size + 4096 : s.st_size / 2) == 0;
}

/* Bytes of `size` that the read may give; negative: it fails. */
static ssize_t before_read(int fd, size_t size, const void *caller)
{
    if (fails(KIND_read, caller))
        return -1;
    if (fails(KIND_truncate, caller) && !alter_input(fd, false))
        return -1;
    if (fails(KIND_grow, caller) && !alter_input(fd, true))
        return -1;
    if (fails(KIND_short, caller) && size > 1)
        return (ssize_t) size / 2;
    return (ssize_t) size;
}

DEFINE(ssize_t, read, int fd, void *to, size_t size)
{
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(read)(fd, to, (size_t) n);
}

DEFINE(ssize_t, pread, int fd, void *to, size_t size, off_t at)
{
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(pread)(fd, to, (size_t) n, at);
}

// (the fortified forms, where the compiler does not know the room)
DEFINE(ssize_t, __read_chk, int fd, void *to, size_t size, size_t room)
{
    if (size > room)
        abort();
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(read)(fd, to, (size_t) n);
}

DEFINE(ssize_t, __pread_chk, int fd, void *to, size_t size, off_t at,
       size_t room)
{
    if (size > room)
        abort();
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(pread)(fd, to, (size_t) n, at);
}

/* Bytes of `size` that may be written; of `space` there are nth - 1. */
static ssize_t before_write(int fd, size_t size, const void *caller)
{
    if (fd == STDERR_FILENO || !counts(caller))
        return (ssize_t) size;
    if (fails(KIND_write, caller))
        return -1;
    const long had = atomic_fetch_add(&calls[KIND_space], (long) size);
    const long left = nth - 1 - had;
    if (wanted != 1u << KIND_space || left >= (long) size)
        return (ssize_t) size;
    fire();
    errno = own_errno ? own_errno : errors[KIND_space];
    return left > 0 ? left : -1;
}

DEFINE(ssize_t, write, int fd, const void *from, size_t size)
{
    const ssize_t n = before_write(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(write)(fd, from, (size_t) n);
}

DEFINE(ssize_t, pwrite, int fd, const void *from, size_t size, off_t at)
{
    const ssize_t n = before_write(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : REAL(pwrite)(fd, from, (size_t) n, at);
}

/* Sends SIGTERM when a file was made whose path open()'s caller has not yet
 * noted. Any thread may handle the signal: this one waits meanwhile. */
static void send_term(void)
{
    const struct timespec pause = {.tv_nsec = 100000000};
    kill(getpid(), SIGTERM);
    nanosleep(&pause, NULL);
}

DEFINE(int, open, const char *path, int flags, ...)
{
    va_list args;
    va_start(args, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(args, mode_t) : 0;
    va_end(args);
    if (flags & O_CREAT)
        fail_made_mode = mode;
    if (FAILS(open))
        return -1;
    const int fd = REAL(open)(path, flags, mode);
    if (fd >= 0 && FAILS(term))
        send_term();
    return fd;
}

DEFINE(int, close, int fd)
{
    const bool bad = FAILS(close); // it is closed all the same
    const int error = errno, result = REAL(close)(fd);
    if (!bad)
        return result;
    errno = error;
    return -1;
}

CALL(rename, -1, int, rename, (const char *from, const char *to), (from, to))
CALL(unlink, -1, int, unlink, (const char *path), (path))
CALL(fchmod, -1, int, fchmod, (int fd, mode_t mode), (fd, mode))
CALL(ftruncate, -1, int, ftruncate, (int fd, off_t size), (fd, size))
CALL(fsync, -1, int, fsync, (int fd), (fd))
CALL(fdopen, NULL, FILE *, fdopen, (int fd, const char *mode), (fd, mode))
CALL(fstat, -1, int, fstat, (int fd, struct stat *s), (fd, s))
CALL(memfd, -1, int, memfd_create, (const char *name, unsigned flags),
     (name, flags))

// -- threads -----------------------------------------------------------------

CALL(thread, errno, int, pthread_create,
     (pthread_t *id, const pthread_attr_t *attributes, void *(*body)(void *),
      void *arg), (id, attributes, body, arg))

// -- processors, links, libraries and the answers of GL ----------------------

#ifdef FAIL_WRAPPED
DEFINE(int, sched_getaffinity, pid_t pid, size_t size, cpu_set_t *set)
{
    return fail_always.affinity ? -1 : REAL(sched_getaffinity)(pid, size, set);
}

DEFINE(ssize_t, readlink, const char *path, char *to, size_t size)
{
    return fail_always.links ? -1 : REAL(readlink)(path, to, size);
}

DEFINE(void *, dlopen, const char *file, int flags)
{
    const bool gone = fail_always.library && file &&
                      strcmp(file, fail_always.library) == 0;
    return REAL(dlopen)(gone ? "/nonexistent/library.so" : file, flags);
}

typedef void (*function)(void);
enum { OUT_OF_MEMORY = 0x0505 }; // GL_OUT_OF_MEMORY

/* The two libraries that contexts come from: how each finds a function, and
 * its glGetError(). */
static struct {
    _Atomic(function (*)(const char *name)) find;
    _Atomic(unsigned (*)(void)) error;
} libraries[2]; // opened by any thread

static unsigned answer(int i)
{
    unsigned (*const error)(void) = atomic_load(&libraries[i].error);
    return FAILS(error) ? OUT_OF_MEMORY : error();
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
    function (*const find)(const char *) = atomic_load(&libraries[i].find);
    const function f = find(name);
    if (!f || strcmp(name, "glGetError") != 0)
        return f;
    atomic_store(&libraries[i].error, (unsigned (*)(void)) f);
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

DEFINE(void *, dlsym, void *library, const char *name)
{
    static const struct {
        const char *name;
        function (*find)(const char *name);
    } hooks[2] = {{"OSMesaGetProcAddress", osmesa_find},
                  {"eglGetProcAddress", egl_find}};
    void *symbol = fail_always.symbol && strcmp(name, fail_always.symbol) == 0
                       ? NULL : REAL(dlsym)(library, name);
    for (int i = 0; symbol && i < 2; i++) {
        if (strcmp(name, hooks[i].name) == 0) {
            function (*find)(const char *);
            memcpy(&find, &symbol, sizeof symbol);
            atomic_store(&libraries[i].find, find);
            memcpy(&symbol, &hooks[i].find, sizeof symbol);
            break;
        }
    }
    return symbol;
}
#endif
