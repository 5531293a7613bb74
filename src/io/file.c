// SPDX-License-Identifier: Apache-2.0
#include "io/file.h"

#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

enum {
    PATIENCE = 1, // seconds that a signal waits for a file system that hangs
    TRIES = 1000, // names of one target and one process number
    NAME_BYTES = 255, // of one path component, on all usual systems
    LINKS = 40,       // as many as the system follows
};

// -- names --------------------------------------------------------------------

/* Returns where the last component starts. */
static const char *base_of(const char *path)
{
    const char *slash = strrchr(path, '/');
    return slash ? slash + 1 : path;
}

/* The folder of a path, "." for a bare name; from malloc, or NULL. */
static char *folder_of(const char *path)
{
    const size_t n = (size_t) (base_of(path) - path);
    char *const folder = gp_strdup(n ? path : ".");
    if (folder)
        folder[n > 1 ? n - 1 : 1] = '\0'; // no slash, but that of the root
    return folder;
}

/* Copies the folder of a path with links followed; "": there is none. */
static void real_folder(const char *path, char real[PATH_MAX])
{
    char *const folder = folder_of(path);
    if (!folder || !realpath(folder, real))
        real[0] = '\0';
    gp_free(folder);
}

/* The descriptor that `path`, in the folder `real`, names; -1: none. */
static int named_descriptor(const char *path, const char *real)
{
    static const char digits[] = "0123456789", task[] = "/task/";
    char own[PATH_MAX], *end;
    const char *const number = base_of(path);
    const long fd = strtol(number, &end, 10);
    if (!strchr(digits, *number) || end == number || *end || fd > INT_MAX ||
        !realpath("/proc/self", own) ||
        strncmp(real, own, strlen(own)) != 0)
        return -1;
    real += strlen(own);
    if (strncmp(real, task, strlen(task)) == 0) // of one thread
        real += strlen(task) + strspn(real + strlen(task), digits);
    return strcmp(real, "/fd") == 0 ? (int) fd : -1;
}

/* Replaces a link by its target; false with errno for other names. */
static bool follow(char at[PATH_MAX])
{
    char to[PATH_MAX];
    const ssize_t n = readlink(at, to, sizeof to);
    if (n <= 0)
        return false;
    const size_t folder = to[0] == '/' ? 0 : (size_t) (base_of(at) - at);
    if (folder + (size_t) n >= PATH_MAX) {
        errno = ENAMETOOLONG;
        return false;
    }
    memcpy(at + folder, to, (size_t) n);
    at[folder + (size_t) n] = '\0';
    return true;
}

/* Follows a name's links to a descriptor, or -1; *system: through /proc. */
static int follow_names(const char *path, bool *system)
{
    char at[PATH_MAX], real[PATH_MAX];
    *system = gp_is_dash(path);
    if (gp_is_dash(path))
        return STDOUT_FILENO;
    if (strlen(path) >= sizeof at)
        return -1;
    strcpy(at, path);
    for (int links = 0; links < LINKS; links++) {
        real_folder(at, real);
        *system |= strncmp(at, "/proc/", 6) == 0 ||
                   strncmp(real, "/proc/", 6) == 0;
        const int fd = named_descriptor(at, real);
        if (fd >= 0 || !follow(at))
            return fd;
    }
    return -1;
}

int gp_file_descriptor(const char *path)
{
    bool system;
    return follow_names(path, &system);
}

bool gp_file_is_straight(const char *path)
{
    struct stat s;
    bool system;
    (void) follow_names(path, &system);
    return system || (stat(path, &s) == 0 && !S_ISREG(s.st_mode) &&
                      !S_ISDIR(s.st_mode));
}

char *gp_file_resolve(const char *path)
{
    char at[PATH_MAX];
    int links = 0;
    if (strlen(path) >= sizeof at)
        return gp_strdup(path); // which the system refuses
    strcpy(at, path);
    while (links <= LINKS && follow(at))
        links++;
    if (links > LINKS)
        errno = ELOOP;
    return links > LINKS || errno == ENAMETOOLONG ? NULL : gp_strdup(at);
}

/* Makes every missing folder above `path`; 0, or -1 with errno set. */
static int make_folders(const char *path)
{
    struct stat s;
    char *const folder = folder_of(path), *at = folder;
    int error = folder ? 0 : ENOMEM;
    while (!error && *at) {
        at += 1 + strcspn(at + 1, "/");
        const char keep = *at;
        *at = '\0';
        // errno of mkdir(), not of stat(), is the reason
        error = mkdir(folder, 0777) ? errno : 0;
        if (error && stat(folder, &s) == 0 && S_ISDIR(s.st_mode))
            error = 0;
        *at = keep;
    }
    gp_free(folder);
    errno = error;
    return error ? -1 : 0;
}

void gp_file_ending(const char *path, char *ending, int room)
{
    const char *base = base_of(path);
    const char *dot = strrchr(base, '.');
    ending[0] = '\0';
    if (!dot || dot == base || strlen(dot + 1) >= (size_t) room)
        return;
    int n = 0;
    for (const char *c = dot + 1; *c; c++)
        ending[n++] = *c >= 'A' && *c <= 'Z' ? (char) (*c - 'A' + 'a') : *c;
    ending[n] = '\0';
}

// -- temporary files ----------------------------------------------------------

/* One temporary file; all zero: none. */
struct temp {
    char *name;        // owned; gone after end_temp()
    struct temp *next; // of those that a signal removes
};
static struct temp *temps;
static pthread_mutex_t naming = PTHREAD_MUTEX_INITIALIZER;

/* Between begin_naming() and end_naming() this thread handles no signal, and no
 * signal ends the process, so that `temps` matches the files on disk. */
static void begin_naming(sigset_t *before)
{
    sigset_t all;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, before);
    pthread_mutex_lock(&naming);
}

static void end_naming(const sigset_t *before)
{
    pthread_mutex_unlock(&naming);
    pthread_sigmask(SIG_SETMASK, before, NULL);
}

/* Removes all temporary files of the process, which must end then: threads that
 * make or remove one wait forever. The thread that it interrupts is not naming,
 * so it may wait for one that is. */
static void remove_and_end(int sig)
{
    struct timespec until;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += PATIENCE;
    (void) pthread_mutex_timedlock(&naming, &until);
    for (const struct temp *t = temps; t; t = t->next)
        unlink(t->name);
    raise(sig); // SA_RESETHAND: the default action, once this returns
}

void gp_temp_cleanup_on_signal(void)
{
    static const int deadly[] = {SIGINT,  SIGTERM,   SIGHUP,  SIGQUIT, SIGXCPU,
                                 SIGALRM, SIGVTALRM, SIGPROF, SIGUSR1, SIGUSR2};
    struct sigaction act = {.sa_handler = remove_and_end,
                            .sa_flags = (int) SA_RESETHAND};
    sigfillset(&act.sa_mask);
    for (size_t i = 0; i < sizeof deadly / sizeof *deadly; i++) {
        struct sigaction was;
        if (!sigaction(deadly[i], NULL, &was) && was.sa_handler != SIG_IGN)
            sigaction(deadly[i], &act, NULL);
    }
}

/* FOLDER/.NAME.PID.tmp, or .NAME.PID-N.tmp for a choice N > 0, NAME cut to
 * what a file name may have. From malloc, or NULL. */
static char *temp_name(const char *path, int nth)
{
    const char *const base = base_of(path);
    const long pid = (long) getpid();
    char suffix[48];
    int bytes = nth ? snprintf(suffix, sizeof suffix, ".%ld-%d.tmp", pid, nth)
                    : snprintf(suffix, sizeof suffix, ".%ld.tmp", pid);
    size_t size = (size_t) (base - path) + NAME_BYTES + 1;
    char *name = malloc(size);
    if (name)
        snprintf(name, size, "%.*s.%.*s%s", (int) (base - path), path,
                 NAME_BYTES - 1 - bytes, base, suffix);
    return name;
}

/* Makes the temporary file of `target`; its descriptor, or -1 with errno. */
static int make_temp(struct temp *temp, const char *target, mode_t mode)
{
    const int flags = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
    int fd = -1, error = EEXIST;
    sigset_t before;
    begin_naming(&before);
    for (int nth = 0; fd < 0 && error == EEXIST && nth < TRIES; nth++) {
        char *name = temp_name(target, nth);
        fd = name ? open(name, flags, mode) : -1;
        error = name ? errno : ENOMEM;
        if (fd >= 0) {
            *temp = (struct temp) {name, temps};
            temps = temp;
        } else {
            gp_free(name);
        }
    }
    end_naming(&before);
    errno = error;
    return fd;
}

/* Renames it to `target`, or removes it (NULL); 0, or -1 with errno set. */
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
        struct temp **at = &temps;
        while (*at != temp)
            at = &(*at)->next;
        *at = temp->next;
        GP_FREE(temp->name);
    }
    end_naming(&before);
    errno = error;
    return result;
}

// -- files under way ----------------------------------------------------------

struct gp_file {
    const struct gp_log *log;
    char *path;      // as the user gave it, "stdout" for "-": for messages
    char *target;    // final name; NULL: straight to fd
    struct temp temp; // while it is written; no name: straight to fd
    int fd;          // -1 when closed
    bool own_fd;     // false for stdout
    bool sync;       // to disk
    gp_status st;    // first failure; later writes repeat it silently
    uint64_t size;   // of what was written
    void *held;      // of straight targets: all of it
    uint64_t room;   // of `held`
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
    default:
        return "check the name and the place";
    }
}

static gp_status cannot_write(const struct gp_log *log, const char *path,
                              int error)
{
    sigset_t before;
    struct stat s;
    begin_naming(&before); // never, where a signal has removed the file
    end_naming(&before);
    if (error == ENOENT && lstat(path, &s) == 0 && S_ISLNK(s.st_mode))
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot be written (a link into a folder that is "
                       "not there); remove the link, or make the folder",
                       path);
    return gp_fail(log, GP_ERR_IO, "%s: cannot be written (%s); %s", path,
                   strerror(error), hint(error));
}

bool gp_file_exists(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode);
}

/* Refuses a file in /proc that is not this process's: another's log. */
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
    char *folder = folder_of(path);
    if (!folder)
        return gp_no_memory(log, path);
    int error = stat(folder, &s) ? errno : S_ISDIR(s.st_mode) ? 0 : ENOTDIR;
    if (!error && access(folder, W_OK | X_OK))
        error = errno;
    if (error && !(error == ENOENT && create_dir)) // it will be made
        st = gp_fail(log, GP_ERR_IO,
                     "%s: cannot be written (folder %s: %s); %s", path,
                     folder, strerror(error),
                     error == ENOENT ? "make the folder or give --create-dir"
                                     : hint(error));
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
    return !*target || (create_dir && make_folders(*target))
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
                       bool create_dir, bool sync, struct gp_file **out)
{
    gp_status st;
    struct gp_file *f = NULL;
    GP_TRY(gp_file_check(log, path, create_dir));
    GP_TRY(gp_alloc_zero(log, path, 1, sizeof *f, &f));
    *f = (struct gp_file) {.log = log, .fd = -1, .sync = sync};
    f->path = gp_strdup(gp_is_dash(path) ? "stdout" : path);
    if (!f->path)
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

/* Writes bytes at a place of the file, of straight targets where these are. */
static gp_status write_bytes(struct gp_file *f, uint64_t at, const void *data,
                             uint64_t size)
{
    for (uint64_t done = 0; done < size;) {
        const uint8_t *const from = (const uint8_t *) data + done;
        const ssize_t n =
            f->temp.name ? pwrite(f->fd, from, size - done, (off_t) (at + done))
                         : write(f->fd, from, size - done);
        if (n < 0 && errno == EINTR)
            continue;
        if (n <= 0)
            return write_failed(f, n < 0 ? errno : EIO);
        done += (uint64_t) n;
    }
    return GP_OK;
}

/* Puts bytes at a place of the file, or of the memory that holds them. */
static gp_status put(struct gp_file *f, uint64_t at, const void *data,
                     size_t size)
{
    if (f->temp.name)
        return write_bytes(f, at, data, size);
    if (size)
        memcpy((uint8_t *) f->held + at, data, size);
    return GP_OK;
}

gp_status gp_file_write(struct gp_file *f, const void *data, size_t size)
{
    if (!f->st && !f->temp.name && f->size + size > f->room) {
        const uint64_t room = 2 * (f->size + size);
        f->st = gp_resize(f->log, f->path, room, &f->held);
        f->room = f->st ? f->room : room;
    }
    if (f->st || put(f, f->size, data, size))
        return f->st;
    f->size += size;
    return GP_OK;
}

gp_status gp_file_patch(struct gp_file *f, uint64_t at, const void *data,
                        size_t size)
{
    if (f->st)
        return f->st;
    if (at > f->size || size > f->size - at)
        return gp_fail(f->log, GP_ERR_BUG, "%s: patch outside the file",
                       f->path);
    return put(f, at, data, size);
}

uint64_t gp_file_size(const struct gp_file *f)
{
    return f->size;
}

const char *gp_file_path(const struct gp_file *f)
{
    return f->path;
}

// -- ending -------------------------------------------------------------------

/* Writes the new name through. Some file systems cannot (EINVAL). */
static gp_status sync_folder(struct gp_file *f)
{
    char *const folder = folder_of(f->target);
    const int fd = folder ? open(folder, O_RDONLY | O_CLOEXEC) : -1;
    const int error = fd < 0 || fsync(fd) ? errno : 0;
    if (fd >= 0)
        close(fd);
    gp_free(folder);
    return error && error != EINVAL ? write_failed(f, error) : GP_OK;
}

gp_status gp_file_commit(struct gp_file **file)
{
    struct gp_file *f = *file;
    gp_status st = f->st;
    if (!st && f->held)
        st = write_bytes(f, 0, f->held, f->size);
    if (!st && f->sync && f->target && fsync(f->fd))
        st = write_failed(f, errno);
    const int fd = f->fd;
    if (!st)
        f->fd = -1;
    if (!st && f->own_fd && close(fd)) // network file systems report a full
        st = write_failed(f, errno);   // disk here
    if (!st && f->temp.name && end_temp(&f->temp, f->target))
        st = write_failed(f, errno);
    if (!st && f->sync && f->target)
        st = sync_folder(f);
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
    gp_free(f->held);
    gp_free(f->target);
    gp_free(f->path);
    GP_FREE(*file);
}

gp_status gp_file_save(const struct gp_log *log, const char *path,
                       bool create_dir, bool sync, const void *data,
                       size_t size)
{
    struct gp_file *file = NULL;
    gp_status st = gp_file_open(log, path, create_dir, sync, &file);
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
