#include "io/file.h"

#include "core/memory.h"
#include "io/io_priv.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum {
    LIVE_MAX = 64, // temporary files that a signal can remove
    LIVE_NAME_MAX = 4096,
    PATIENCE_MS = 1000,
    TRIES = 1000, // names of one target and one process number
    NAME_BYTES = 255, // of one path component, on all usual systems
};

// -- temporary files: what a signal must remove -------------------------------

static struct {
    volatile sig_atomic_t live;
    char name[LIVE_NAME_MAX];
} live_temps[LIVE_MAX];
static pthread_mutex_t live_lock = PTHREAD_MUTEX_INITIALIZER;

/* A signal's handler may run while other threads make or remove files. It waits
 * for those; threads that start to do so later wait for the end. */
static atomic_int naming;
static atomic_bool ending;

/* Never returns once a signal has temporary files removed: errors from then on
 * are its doing and need no line. */
static void wait_for_signal(void)
{
    while (atomic_load(&ending))
        pause();
}

/* Between begin_naming() and end_naming() this thread handles no signal, and no
 * signal ends the process, so that live_temps matches the files on disk. */
static void begin_naming(sigset_t *before)
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, before);
    atomic_fetch_add(&naming, 1);
    if (atomic_load(&ending)) {
        atomic_fetch_sub(&naming, 1);
        wait_for_signal();
    }
}

static void end_naming(const sigset_t *before)
{
    atomic_fetch_sub(&naming, 1);
    pthread_sigmask(SIG_SETMASK, before, NULL);
}

static int live_add(const char *name)
{
    int slot = -1;
    if (strlen(name) >= LIVE_NAME_MAX)
        return -1;
    pthread_mutex_lock(&live_lock);
    for (int i = 0; i < LIVE_MAX && slot < 0; i++) {
        if (!live_temps[i].live) {
            strcpy(live_temps[i].name, name);
            live_temps[i].live = 1; // last: the handler trusts the name
            slot = i;
        }
    }
    pthread_mutex_unlock(&live_lock);
    return slot;
}

/* Removes all temporary files of the process, which must end then: threads that
 * make or remove one wait forever. Safe in a signal handler. */
static void remove_and_end(int sig)
{
    const struct timespec moment = {.tv_nsec = 1000000};
    atomic_store(&ending, true);
    // not forever: a file system may hang
    for (int i = 0; i < PATIENCE_MS && atomic_load(&naming) > 0; i++)
        nanosleep(&moment, NULL);
    for (int i = 0; i < LIVE_MAX; i++) {
        if (live_temps[i].live)
            unlink(live_temps[i].name);
    }
    raise(sig); // SA_RESETHAND: the default action, once this returns
}

void gp_temp_cleanup_on_signal(void)
{
    static const int deadly[] = {SIGINT,  SIGTERM,   SIGHUP,  SIGQUIT, SIGXCPU,
                                 SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
    struct sigaction act = {.sa_handler = remove_and_end,
                            .sa_flags = (int) SA_RESETHAND};
    sigemptyset(&act.sa_mask);
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++) {
        struct sigaction was;
        if (!sigaction(deadly[i], NULL, &was) && was.sa_handler != SIG_IGN)
            sigaction(deadly[i], &act, NULL);
    }
    signal(SIGPIPE, SIG_IGN);
}

// -- temporary files: names --------------------------------------------------

/* One temporary file; all zero: none. */
struct temp {
    char *name; // owned; gone after end_temp()
    int live;   // slot in which a signal finds the name, or -1
};

char *gp_file_temp_name(const char *path, int nth)
{
    const char *const slash = strrchr(path, '/');
    const char *const base = slash ? slash + 1 : path;
    const long pid = (long) getpid();
    char tail[48];
    int tail_bytes = nth ? snprintf(tail, sizeof tail, ".%ld-%d.tmp", pid, nth)
                         : snprintf(tail, sizeof tail, ".%ld.tmp", pid);
    int name_bytes = NAME_BYTES - 1 - tail_bytes;
    if (strlen(base) < (size_t) name_bytes)
        name_bytes = (int) strlen(base);
    size_t size = (size_t) (base - path) + NAME_BYTES + 1;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%.*s%s", (int) (base - path), path,
                 name_bytes, base, tail);
    return name;
}

/* Makes the temporary file of `target`, with `mode` less umask, open for
 * writing; its descriptor, or -1 with errno set and nothing made. */
static int make_temp(struct temp *temp, const char *target, mode_t mode)
{
    const int flags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    int fd = -1, error = EEXIST;
    sigset_t before;
    begin_naming(&before);
    for (int nth = 0; fd < 0 && error == EEXIST && nth < TRIES; nth++) {
        char *name = gp_file_temp_name(target, nth);
        fd = name ? open(name, flags, mode) : -1;
        error = name ? errno : ENOMEM;
        if (fd >= 0)
            *temp = (struct temp) {name, live_add(name)};
        else
            gp_free(name);
    }
    end_naming(&before);
    errno = error;
    return fd;
}

/* Renames it to `target`, or removes it when that is NULL; 0, or -1 with errno
 * set: then it stays to be removed. Does nothing where there is none. */
static int end_temp(struct temp *temp, const char *target)
{
    if (!temp->name)
        return 0;
    sigset_t before;
    begin_naming(&before);
    const int result = target ? rename(temp->name, target)
                              : unlink(temp->name);
    const int error = errno;
    if (!target || result == 0) {
        if (temp->live >= 0) {
            pthread_mutex_lock(&live_lock);
            live_temps[temp->live].live = 0;
            pthread_mutex_unlock(&live_lock);
        }
        GP_FREE(temp->name);
    }
    end_naming(&before);
    errno = error;
    return result;
}

// -- files under way ----------------------------------------------------------

enum { BUFFER_BYTES = 128 << 10 }; // so that 8-byte chunk leaders cost no write

struct gp_file {
    const struct gp_log *log;
    char *path;      // as the user gave it, "stdout" for "-": for messages
    char *target;    // final name; NULL: straight to fd
    struct temp temp; // while it is written; no name: straight to fd
    int fd;          // -1 when closed
    bool own_fd;     // false for stdout
    gp_status st;    // first failure; later writes repeat it silently
    uint8_t *buffer; // bytes not yet in fd; for straight targets all
    size_t held, room;
    uint64_t flushed;
};

// -- opening ------------------------------------------------------------------

static const char *hint(int error)
{
    switch (error) {
    case ENOSPC:
    case EDQUOT:
    case EFBIG:
        return "free some space there or write to another place";
    case EPIPE:
        return "the program that reads the pipe ended first";
    case EACCES:
    case EPERM:
    case EROFS:
        return "check the permissions or write to another place";
    case ENAMETOOLONG:
        return "use a shorter name";
    default:
        return "check the name and the place";
    }
}

static gp_status cannot_write(const struct gp_log *log, const char *path,
                              int error)
{
    wait_for_signal(); // a signal may have removed the file
    return gp_fail(log, GP_ERR_IO, "%s: cannot be written (%s); %s", path,
                   strerror(error), hint(error));
}

bool gp_file_exists(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode);
}

/* Refuses a regular file in /proc that is no descriptor of this process: it
 * may be another's log. */
static gp_status check_system(const struct gp_log *log, const char *path,
                              bool *straight)
{
    *straight = gp_file_is_straight(path);
    return *straight && gp_file_descriptor(path) < 0 && gp_file_exists(path)
               ? gp_fail(log, GP_ERR_IO,
                         "%s: cannot be written (a file under a name in "
                         "/proc); give the name in its own folder", path)
               : GP_OK;
}

gp_status gp_file_check(const struct gp_log *log, const char *path,
                        bool create_dir)
{
    struct stat s;
    bool straight;
    gp_status st = check_system(log, path, &straight);
    if (st || straight)
        return st;
    bool there = stat(path, &s) == 0;
    if (there && S_ISDIR(s.st_mode))
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot be written (it is a folder); give the name "
                       "of a file", path);
    if (there && access(path, W_OK))
        return cannot_write(log, path, errno);
    char *folder = gp_file_folder(path);
    if (!folder)
        return gp_no_memory(log, path);
    if (stat(folder, &s) && errno == ENOENT && create_dir)
        st = GP_OK; // it will be made
    else if (stat(folder, &s))
        st = gp_fail(log, GP_ERR_IO,
                     "%s: cannot be written (folder %s: %s); %s", path,
                     folder, strerror(errno),
                     errno == ENOENT ? "make the folder or give --create-dir"
                                     : hint(errno));
    else if (!S_ISDIR(s.st_mode))
        st = cannot_write(log, path, ENOTDIR);
    else if (access(folder, W_OK | X_OK))
        st = cannot_write(log, path, errno);
    gp_free(folder);
    return st;
}

/* Finds the file to write, links followed, and makes its folders. */
static gp_status find_target(const struct gp_log *log, const char *path,
                             bool create_dir, char **target)
{
    *target = gp_file_resolve(path);
    if (!*target && errno == ENOMEM)
        return gp_no_memory(log, path);
    return !*target || (create_dir && gp_file_make_folders(*target))
               ? cannot_write(log, path, errno) : GP_OK;
}

/* Opens the temporary file with the permissions of the one it replaces; never,
 * not even before fchmod(), with more. */
static gp_status open_temp(struct gp_file *f, bool create_dir)
{
    struct stat old;
    gp_status st = find_target(f->log, f->path, create_dir, &f->target);
    if (st)
        return st;
    const bool replaces = stat(f->target, &old) == 0;
    const mode_t mode = replaces ? old.st_mode & 0777 : 0666;
    f->fd = make_temp(&f->temp, f->target, mode);
    if (f->fd < 0 && errno == ENOMEM)
        return gp_no_memory(f->log, f->path);
    if (f->fd < 0)
        return cannot_write(f->log, f->path, errno);
    f->own_fd = true;
    if (replaces && fchmod(f->fd, mode)) // the bits that umask took
        return cannot_write(f->log, f->path, errno);
    return GP_OK;
}

/* Duplicates a descriptor, or opens a pipe or device. */
static int open_straight(const char *path, int flags)
{
    const int given = gp_file_descriptor(path);
    return given < 0 ? open(path, flags | O_CLOEXEC)
                     : fcntl(given, F_DUPFD_CLOEXEC, 0);
}

gp_status gp_file_open(const struct gp_log *log, const char *path,
                       bool create_dir, struct gp_file **out)
{
    gp_status st;
    struct gp_file *f = NULL;
    GP_TRY(gp_file_check(log, path, create_dir));
    GP_TRY(gp_alloc_zero(log, path, 1, sizeof *f, &f));
    *f = (struct gp_file) {.log = log, .fd = -1};
    f->path = gp_strdup(gp_is_dash(path) ? "stdout" : path);
    f->buffer = malloc(BUFFER_BYTES);
    f->room = BUFFER_BYTES;
    if (!f->path || !f->buffer)
        GP_TRY(gp_no_memory(log, path));
    if (gp_is_dash(path)) {
        f->fd = STDOUT_FILENO;
    } else if (gp_file_is_straight(path)) {
        f->fd = open_straight(path, O_WRONLY);
        f->own_fd = true;
        if (f->fd < 0)
            GP_TRY(cannot_write(log, f->path, errno));
    } else {
        GP_TRY(open_temp(f, create_dir));
    }
    *out = f;
    f = NULL;
out:
    gp_file_discard(&f);
    return st;
}

gp_status gp_file_open_lines(const struct gp_log *log, const char *path,
                             bool create_dir, int *out, char **created)
{
    bool straight;
    char *target = NULL;
    int fd = -1;
    gp_status st;
    *created = NULL;
    GP_TRY(check_system(log, path, &straight));
    if (straight) {
        fd = open_straight(path, O_WRONLY);
    } else {
        GP_TRY(find_target(log, path, create_dir, &target));
        fd = open(target, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (fd < 0 && errno == EEXIST)
            fd = open(target, O_WRONLY | O_CLOEXEC);
        else if (fd >= 0)
            *created = target;
    }
    if (fd < 0)
        GP_TRY(cannot_write(log, path, errno));
    *out = fd;
    if (*created)
        target = NULL;
out:
    gp_free(target);
    return st;
}

// -- writing ------------------------------------------------------------------

static gp_status write_failed(struct gp_file *f, int error)
{
    f->st = cannot_write(f->log, f->path, error);
    return f->st;
}

/* write() until all is out; returns 0 or an errno. */
static int write_all(int fd, const uint8_t *data, size_t size)
{
    while (size > 0) {
        ssize_t n = write(fd, data, size);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return n < 0 ? errno : EIO;
        data += n;
        size -= (size_t) n;
    }
    return 0;
}

static gp_status flush(struct gp_file *f)
{
    int error = write_all(f->fd, f->buffer, f->held);
    if (error)
        return write_failed(f, error);
    f->flushed += f->held;
    f->held = 0;
    return GP_OK;
}

static gp_status grow_buffer(struct gp_file *f, size_t size)
{
    size_t room = f->room;
    void *buffer = f->buffer;
    while (room - f->held < size)
        room *= 2;
    f->st = gp_resize(f->log, f->path, room, &buffer);
    f->buffer = buffer;
    f->room = f->st ? f->room : room;
    return f->st;
}

gp_status gp_file_write(struct gp_file *f, const void *data, size_t size)
{
    if (f->st)
        return f->st;
    if (size > f->room - f->held) {
        gp_status st = f->temp.name ? flush(f) : grow_buffer(f, size);
        if (st)
            return st;
    }
    if (size > f->room) { // a temporary file's buffer does not grow
        int error = write_all(f->fd, data, size);
        if (error)
            return write_failed(f, error);
        f->flushed += size;
        return GP_OK;
    }
    if (size)
        memcpy(f->buffer + f->held, data, size);
    f->held += size;
    return GP_OK;
}

gp_status gp_file_patch(struct gp_file *f, uint64_t at, const void *data,
                        size_t size)
{
    const uint8_t *from = data;
    if (f->st)
        return f->st;
    if (at > gp_file_size(f) || size > gp_file_size(f) - at)
        return gp_fail(f->log, GP_ERR_BUG, "%s: patch outside the file",
                       f->path);
    while (size > 0 && at < f->flushed) {
        size_t part = size < f->flushed - at ? size
                                             : (size_t) (f->flushed - at);
        ssize_t n = pwrite(f->fd, from, part, (off_t) at);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return write_failed(f, n < 0 ? errno : EIO);
        from += n;
        at += (uint64_t) n;
        size -= (size_t) n;
    }
    if (size)
        memcpy(f->buffer + (at - f->flushed), from, size);
    return GP_OK;
}

uint64_t gp_file_size(const struct gp_file *f)
{
    return f->flushed + f->held;
}

const char *gp_file_path(const struct gp_file *f)
{
    return f->path;
}

// -- ending -------------------------------------------------------------------

gp_status gp_file_commit(struct gp_file **file)
{
    struct gp_file *f = *file;
    gp_status st = f->st ? f->st : flush(f);
    const int fd = f->fd;
    if (!st)
        f->fd = -1;
    if (!st && f->own_fd && close(fd)) // network file systems report a full
        st = write_failed(f, errno);   // disk here
    if (!st && f->temp.name && end_temp(&f->temp, f->target))
        st = write_failed(f, errno);
    gp_file_discard(file);
    return st;
}

void gp_file_discard(struct gp_file **file)
{
    struct gp_file *f = *file;
    if (!f)
        return;
    if (f->fd >= 0 && f->own_fd)
        close(f->fd);
    end_temp(&f->temp, NULL);
    free(f->buffer);
    gp_free(f->target);
    gp_free(f->path);
    GP_FREE(*file);
}

gp_status gp_file_save(const struct gp_log *log, const char *path,
                       const void *data, size_t size)
{
    struct gp_file *file = NULL;
    gp_status st = gp_file_open(log, path, false, &file);
    if (!st)
        st = gp_file_write(file, data, size);
    if (!st)
        st = gp_file_commit(&file);
    gp_file_discard(&file);
    return st;
}

// -- stdout ------------------------------------------------------------------

gp_status gp_flush_stdout(const struct gp_log *log)
{
    if (fflush(stdout) == 0 && !ferror(stdout))
        return GP_OK;
    return gp_fail(log, GP_ERR_IO, "-: cannot write to stdout (%s); check the "
                   "program that reads it", strerror(errno));
}

gp_status gp_flush_text(const struct gp_log *log)
{
    // poll(2): POLLERR is set for the end of a pipe that nobody reads
    struct pollfd to = {.fd = STDOUT_FILENO, .events = POLLOUT};
    (void) fflush(stdout);
    if (poll(&to, 1, 0) > 0 && (to.revents & POLLERR))
        return GP_OK;
    return gp_flush_stdout(log);
}
