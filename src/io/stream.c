#include "io/stream.h"

#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { FIRST_BLOCK = 1 << 16 };

static gp_status cannot_read(const struct gp_log *log, const char *path)
{
    return gp_fail(log, GP_ERR_IO, "%s: cannot read (%s); check the file",
                   path, strerror(errno));
}

/* Doubles the buffer; `have` bytes of it are kept. */
static gp_status grow(const struct gp_log *log, uint64_t have, uint64_t *room,
                      uint8_t **data)
{
    void *wider;
    uint64_t n = *room ? *room * 2 : FIRST_BLOCK;
    gp_status st = gp_alloc(log, "input", n, 1, &wider);
    if (st)
        return st;
    if (have)
        memcpy(wider, *data, have);
    gp_free(*data);
    *data = wider;
    *room = n;
    return GP_OK;
}

static gp_status read_pipe(const struct gp_log *log, const char *path, int fd,
                           uint64_t limit, struct gp_stream *s)
{
    uint64_t room = 0;
    for (;;) {
        if (s->size == room) {
            gp_status st = grow(log, s->size, &room, &s->data);
            if (st)
                return st;
        }
        ssize_t got = read(fd, s->data + s->size, room - s->size);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return cannot_read(log, path);
        if (got == 0)
            return GP_OK;
        s->size += (uint64_t) got;
        if (s->size > limit)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: more than --max-pixels allows (over %llu "
                           "bytes); raise it, or give files", path,
                           (unsigned long long) limit);
    }
}

static gp_status take(const struct gp_log *log, const char *path, int fd,
                      uint64_t limit, struct gp_stream *s)
{
    struct stat info;
    if (fstat(fd, &info))
        return cannot_read(log, path);
    if (S_ISDIR(info.st_mode))
        return gp_fail(log, GP_ERR_IO,
                       "%s: is a folder; give a file or a pattern such as "
                       "frame.####.exr", path);
    // a redirected stdin is a file too, but its offset may not be 0
    if (S_ISREG(info.st_mode) && fd != STDIN_FILENO) {
        s->fd = fd;
        s->size = (uint64_t) info.st_size;
        return GP_OK;
    }
    return read_pipe(log, path, fd, limit, s);
}

gp_status gp_stream_open(const struct gp_log *log, const char *path,
                         uint64_t limit, struct gp_stream *s)
{
    *s = (struct gp_stream) GP_STREAM_EMPTY;
    int fd = STDIN_FILENO;
    if (strcmp(path, "-") != 0)
        fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd < 0)
        return gp_fail(log, GP_ERR_IO, "%s: cannot open (%s); check the name",
                       path, strerror(errno));
    gp_status st = take(log, path, fd, limit, s);
    if (!st && s->size == 0)
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: is empty (0 bytes); write or render it again", path);
    if (s->fd < 0 && fd != STDIN_FILENO)
        close(fd);
    if (st)
        gp_stream_close(s);
    return st;
}

static int64_t read_file(int fd, uint8_t *to, uint64_t n, uint64_t offset)
{
    uint64_t done = 0;
    while (done < n) {
        ssize_t got = pread(fd, to + done, n - done, (off_t) (offset + done));
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return -1;
        if (got == 0)
            break;
        done += (uint64_t) got;
    }
    return (int64_t) done;
}

int64_t gp_stream_read(const struct gp_stream *s, void *to, uint64_t n,
                       uint64_t offset)
{
    if (offset >= s->size)
        return 0;
    if (n > s->size - offset)
        n = s->size - offset;
    if (!s->data)
        return read_file(s->fd, to, n, offset);
    memcpy(to, s->data + offset, n);
    return (int64_t) n;
}

void gp_stream_close(struct gp_stream *s)
{
    if (s->fd >= 0)
        close(s->fd);
    if (!s->borrowed)
        gp_free(s->data);
    *s = (struct gp_stream) GP_STREAM_EMPTY;
}
