/* Makes one call of the system or of malloc fail: LD_PRELOAD this.
 *
 *   FAULT=KIND:N[+][:ERRNO]   the N-th call of that kind fails, from 1 on;
 *                             with + so does every later one
 *   FAULT_LOG=FILE            gets a line "fired" when it happens, and at the
 *                             end of main a line "KIND COUNT" for each kind
 *
 * Kinds: malloc (all ways to allocate), open, close, rename, unlink, fchmod,
 * ftruncate, fdopen, read (EIO), thread; short: the N-th read gives half of
 * what it could; truncate: the file read from is cut to half before the N-th
 * read, and grow: is made longer; write: N counts bytes, what is before them
 * is written and every later write fails (ENOSPC); interrupt: the N-th write
 * of any size gives EINTR once, and nothing is written; term: SIGTERM comes
 * when the N-th open() has made or found its file.
 *
 * Only calls of a program named .../glarepp count, from its main on, and only
 * those of the program itself, its bridges and the C libraries it links with.
 * Those made inside Mesa, LLVM, FFTW, OpenImageIO, OpenColorIO and the dynamic
 * linker are not: there a full memory ends the process by the library's own
 * hand.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>
#include <unwind.h>

#define KINDS(X)                                                              \
    X(malloc, ENOMEM) X(open, EACCES) X(close, EIO) X(rename, EACCES)         \
    X(unlink, EACCES) X(fchmod, EPERM) X(ftruncate, EIO) X(fdopen, ENOMEM)    \
    X(read, EIO) X(thread, EAGAIN) X(write, ENOSPC)                           \
    X(short, 0) X(truncate, 0) X(grow, 0) X(interrupt, EINTR) X(term, 0)
#define ENUM(name, error) KIND_##name,
#define NAME(name, error) #name,
#define ERROR(name, error) error,
enum kind { KINDS(ENUM) KIND_COUNT };
static const char *const names[] = {KINDS(NAME)};
static const int errors[] = {KINDS(ERROR)};

static atomic_long calls[KIND_COUNT];
static enum kind wanted = KIND_COUNT;
static long nth;
static bool later;
static int error;
static atomic_bool counting, fired;
static char log_path[4096];
static _Thread_local bool inside; // the shim's own calls

#define REAL(name) ((__typeof__(&name)) real(#name))
static void *real(const char *name)
{
    return dlsym(RTLD_NEXT, name);
}

// -- the caller ----------------------------------------------------------------

enum module { FOREIGN, OURS, PASSING };

/* PASSING: what it allocates is for its caller. */
static enum module module_of(const void *address)
{
    static const char *const ours[] = {"/glarepp-", "/libOpenEXRCore", "/libpng",
                                       "/libz.", "/libdeflate", "/libjansson"};
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

// -- the fault -----------------------------------------------------------------

static void tell(const char *line)
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

static void fire(void)
{
    if (!atomic_exchange(&fired, true))
        tell("fired\n");
}

/* True when this call must fail; errno is set. */
static bool fails(enum kind kind, const void *caller)
{
    if (!atomic_load(&counting) || inside || !is_ours(caller))
        return false;
    const long n = atomic_fetch_add(&calls[kind], 1) + 1;
    if (kind != wanted || n < nth || (n > nth && !later))
        return false;
    fire();
    errno = error;
    return true;
}
#define FAILS(kind) fails(KIND_##kind, __builtin_return_address(0))

static void print_counts(void)
{
    char line[64];
    for (int i = 0; i < KIND_COUNT; i++) {
        snprintf(line, sizeof line, "%s %ld\n", names[i],
                 atomic_load(&calls[i]));
        tell(line);
    }
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
            wanted = (enum kind) i;
    }
    if (wanted == KIND_COUNT)
        return;
    char *end;
    nth = strtol(colon + 1, &end, 10);
    later = *end == '+';
    error = errors[wanted];
    const char *word = strchr(end, ':');
    for (size_t i = 0; word && i < sizeof words / sizeof *words; i++) {
        if (strcmp(word + 1, words[i].name) == 0)
            error = words[i].value;
    }
}

// -- main ----------------------------------------------------------------------

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
    const char *fault = getenv("FAULT"), *log = getenv("FAULT_LOG");
    const char *slash = argv[0] ? strrchr(argv[0], '/') : NULL;
    // a shell on the way to the program starts as ever
    if (!slash || strcmp(slash + 1, "glarepp") != 0)
        return ((start) real("__libc_start_main"))(m, argc, argv, init, fini,
                                                   rtld_fini, stack_end);
    if (fault)
        parse(fault);
    if (log && strlen(log) < sizeof log_path)
        strcpy(log_path, log);
    real_main = m;
    return ((start) real("__libc_start_main"))(counted_main, argc, argv, init,
                                               fini, rtld_fini, stack_end);
}

// -- memory --------------------------------------------------------------------

#define KEEP(name)                                                            \
    static __typeof__(&name) next;                                            \
    if (!next)                                                                \
        next = REAL(name)

void *malloc(size_t size)
{
    KEEP(malloc);
    return FAILS(malloc) ? NULL : next(size);
}

void *calloc(size_t count, size_t size)
{
    KEEP(calloc);
    return FAILS(malloc) ? NULL : next(count, size);
}

void *realloc(void *p, size_t size)
{
    KEEP(realloc);
    return FAILS(malloc) ? NULL : next(p, size);
}

int posix_memalign(void **p, size_t align, size_t size)
{
    KEEP(posix_memalign);
    return FAILS(malloc) ? ENOMEM : next(p, align, size);
}

void *aligned_alloc(size_t align, size_t size)
{
    KEEP(aligned_alloc);
    return FAILS(malloc) ? NULL : next(align, size);
}

// -- files ---------------------------------------------------------------------

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

ssize_t read(int fd, void *to, size_t size)
{
    KEEP(read);
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, to, (size_t) n);
}

ssize_t pread(int fd, void *to, size_t size, off_t at)
{
    KEEP(pread);
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, to, (size_t) n, at);
}

ssize_t __read_chk(int fd, void *to, size_t size, size_t room)
{
    KEEP(read);
    if (size > room)
        abort();
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, to, (size_t) n);
}

ssize_t __pread_chk(int fd, void *to, size_t size, off_t at, size_t room)
{
    KEEP(pread);
    if (size > room)
        abort();
    const ssize_t n = before_read(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, to, (size_t) n, at);
}

/* Bytes of `size` that may be written: the disk has room for nth - 1. */
static ssize_t before_write(int fd, size_t size, const void *caller)
{
    if (fd == STDERR_FILENO || !atomic_load(&counting) || !is_ours(caller))
        return (ssize_t) size;
    if (fails(KIND_interrupt, caller))
        return -1;
    const long had = atomic_fetch_add(&calls[KIND_write], (long) size);
    const long left = nth - 1 - had;
    if (wanted != KIND_write || left >= (long) size)
        return (ssize_t) size;
    fire();
    errno = error;
    return left > 0 ? left : -1;
}

ssize_t write(int fd, const void *from, size_t size)
{
    KEEP(write);
    const ssize_t n = before_write(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, from, (size_t) n);
}

ssize_t pwrite(int fd, const void *from, size_t size, off_t at)
{
    KEEP(pwrite);
    const ssize_t n = before_write(fd, size, __builtin_return_address(0));
    return n < 0 ? -1 : next(fd, from, (size_t) n, at);
}

/* A file was made that its maker has not heard of yet. The signal may be
 * handled by any thread: while this one waits, unless it has died by then. */
static void send_term(void)
{
    const struct timespec a_while = {.tv_nsec = 100000000};
    kill(getpid(), SIGTERM);
    nanosleep(&a_while, NULL);
}

int open(const char *path, int flags, ...)
{
    KEEP(open);
    va_list args;
    va_start(args, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(args, mode_t) : 0;
    va_end(args);
    if (FAILS(open))
        return -1;
    const int fd = next(path, flags, mode);
    if (fd >= 0 && FAILS(term))
        send_term();
    return fd;
}

int close(int fd)
{
    KEEP(close);
    const bool bad = FAILS(close);
    const int result = next(fd); // a close that fails closes all the same
    if (!bad)
        return result;
    errno = error;
    return -1;
}

int rename(const char *from, const char *to)
{
    KEEP(rename);
    return FAILS(rename) ? -1 : next(from, to);
}

int unlink(const char *path)
{
    KEEP(unlink);
    return FAILS(unlink) ? -1 : next(path);
}

int fchmod(int fd, mode_t mode)
{
    KEEP(fchmod);
    return FAILS(fchmod) ? -1 : next(fd, mode);
}

int ftruncate(int fd, off_t size)
{
    KEEP(ftruncate);
    return FAILS(ftruncate) ? -1 : next(fd, size);
}

FILE *fdopen(int fd, const char *mode)
{
    KEEP(fdopen);
    return FAILS(fdopen) ? NULL : next(fd, mode);
}

// -- threads -------------------------------------------------------------------

int pthread_create(pthread_t *id, const pthread_attr_t *attributes,
                   void *(*body)(void *), void *arg)
{
    KEEP(pthread_create);
    return FAILS(thread) ? error : next(id, attributes, body, arg);
}
