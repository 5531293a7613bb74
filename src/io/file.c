#include "io/file.h"

#include "core/memory.h"
#include "io/file_name.h"
#include "io/file_temp.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BUFFER_BYTES = 1 << 20 }; // chunk leaders of 8 bytes are no writes

struct gp_file {
    const struct gp_log *log;
    char *path;      // as the user gave it, "stdout" for "-": for messages
    bool is_stdout;
    char *target;    // where the rename goes; NULL: straight to fd
    struct gp_temp temp; // while it is written; no name: straight to fd
    int fd;          // -1 when closed
    bool own_fd;     // false for stdout
    gp_status st;    // first failure; later writes repeat it silently
    uint8_t *buffer; // what is not yet in fd; for straight targets all of it
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
    gp_temp_wait(); // the handler has removed what this is about
    return gp_fail(log, GP_ERR_IO, "%s: cannot be written (%s); %s", path,
                   strerror(error), hint(error));
}

bool gp_file_exists(const char *path)
{
    struct stat s;
    return stat(path, &s) == 0 && S_ISREG(s.st_mode);
}

gp_status gp_file_check(const struct gp_log *log, const char *path,
                        bool create_dir)
{
    struct stat s;
    if (gp_file_is_straight(path))
        return GP_OK;
    bool there = stat(path, &s) == 0;
    if (there && S_ISDIR(s.st_mode))
        return gp_fail(log, GP_ERR_IO,
                       "%s: cannot be written (it is a folder); give the name "
                       "of a file", path);
    if (there && access(path, W_OK))
        return cannot_write(log, path, errno);
    char *folder = gp_file_folder(path);
    if (!folder)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    gp_status st = GP_OK;
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

/* Opens the temporary file with the permissions of the one it replaces. */
static gp_status open_temp(struct gp_file *f, bool create_dir)
{
    struct stat old;
    f->target = gp_file_resolve(f->path);
    if (!f->target && errno != ENOMEM)
        return cannot_write(f->log, f->path, errno);
    if (!f->target)
        return gp_fail(f->log, GP_ERR_BUG, "%s: out of memory", f->path);
    if (create_dir && gp_file_make_folders(f->target))
        return cannot_write(f->log, f->path, errno);
    f->fd = gp_temp_make(&f->temp, f->target);
    if (f->fd < 0 && errno == ENOMEM)
        return gp_fail(f->log, GP_ERR_BUG, "%s: out of memory", f->path);
    if (f->fd < 0)
        return cannot_write(f->log, f->path, errno);
    f->own_fd = true;
    if (stat(f->target, &old) == 0 && fchmod(f->fd, old.st_mode & 0777))
        return cannot_write(f->log, f->path, errno);
    return GP_OK;
}

static gp_status open_straight(struct gp_file *f)
{
    if (f->is_stdout) {
        f->fd = STDOUT_FILENO;
        return GP_OK;
    }
    f->fd = open(f->path, O_WRONLY | O_CLOEXEC);
    f->own_fd = true;
    return f->fd < 0 ? cannot_write(f->log, f->path, errno) : GP_OK;
}

gp_status gp_file_open(const struct gp_log *log, const char *path,
                       bool create_dir, struct gp_file **out)
{
    gp_status st;
    void *mem = NULL;
    struct gp_file *f = NULL;
    GP_TRY(gp_file_check(log, path, create_dir));
    GP_TRY(gp_alloc_zero(log, path, 1, sizeof *f, &mem));
    f = mem;
    *f = (struct gp_file) {.log = log, .fd = -1};
    f->is_stdout = strcmp(path, "-") == 0;
    f->path = gp_strdup(f->is_stdout ? "stdout" : path);
    f->buffer = malloc(BUFFER_BYTES);
    f->room = BUFFER_BYTES;
    if (!f->path || !f->buffer)
        GP_TRY(gp_fail(log, GP_ERR_BUG, "%s: out of memory", path));
    GP_TRY(gp_file_is_straight(path) ? open_straight(f)
                                     : open_temp(f, create_dir));
    *out = f;
    f = NULL;
out:
    gp_file_discard(&f);
    return st;
}

// -- writing ------------------------------------------------------------------

static gp_status failed(struct gp_file *f, int error)
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
        return failed(f, error);
    f->flushed += f->held;
    f->held = 0;
    return GP_OK;
}

static gp_status full(struct gp_file *f)
{
    f->st = gp_fail(f->log, GP_ERR_BUG, "%s: out of memory; close other "
                    "programs", f->path);
    return f->st;
}

static gp_status grow(struct gp_file *f, size_t size)
{
    size_t want = f->room, need;
    if (__builtin_add_overflow(f->held, size, &need))
        return full(f);
    while (want < need && !__builtin_mul_overflow(want, 2, &want))
        ;
    uint8_t *more = want >= need ? realloc(f->buffer, want) : NULL;
    if (!more)
        return full(f);
    f->buffer = more;
    f->room = want;
    return GP_OK;
}

gp_status gp_file_write(struct gp_file *f, const void *data, size_t size)
{
    if (f->st)
        return f->st;
    if (size > f->room - f->held) {
        gp_status st = f->temp.name ? flush(f) : grow(f, size);
        if (st)
            return st;
    }
    if (size > f->room) { // a temporary file's buffer does not grow
        int error = write_all(f->fd, data, size);
        if (error)
            return failed(f, error);
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
            return failed(f, n < 0 ? errno : EIO);
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

static gp_status close_fd(struct gp_file *f)
{
    int fd = f->fd;
    f->fd = -1;
    if (fd >= 0 && f->own_fd && close(fd) && !f->st)
        return failed(f, errno);
    return f->st;
}

gp_status gp_file_commit(struct gp_file **file)
{
    struct gp_file *f = *file;
    gp_status st = f->st ? f->st : flush(f);
    if (!st)
        st = close_fd(f); // network file systems tell of a full disk here
    if (!st && f->temp.name && gp_temp_end(&f->temp, f->target))
        st = failed(f, errno);
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
    gp_temp_end(&f->temp, NULL);
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
