// SPDX-License-Identifier: Apache-2.0
#include "io/stream.h"

#include "core/json.h"
#include "core/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { BLOCK = 1 << 16 };

gp_status gp_stream_failed(const struct gp_log *log, const char *path)
{
    return gp_fail(log, GP_ERR_IO, "%s: cannot read (%s); check the file",
                   path, strerror(errno));
}

static void close_fd(struct gp_stream *s)
{
    if (s->fd >= 0 && s->fd != STDIN_FILENO)
        close(s->fd);
    s->fd = -1;
    s->more = false;
}

/* Makes room for `size` bytes and reads them, or until the pipe ends. */
static gp_status read_until(const struct gp_log *log, const char *path,
                            uint64_t size, struct gp_stream *s)
{
    void *block = s->data;
    const gp_status st = gp_resize(log, "input", size, &block);
    s->data = block;
    while (!st && s->more && s->size < size) {
        const ssize_t got = read(s->fd, s->data + s->size, size - s->size);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return gp_stream_failed(log, path);
        if (got == 0)
            close_fd(s);
        s->size += (uint64_t) got;
    }
    return st;
}

gp_status gp_stream_fill(const struct gp_log *log, const char *path,
                         uint64_t limit, struct gp_stream *s)
{
    gp_status st = GP_OK;
    while (s->more && s->size <= limit && !st) {
        // a pipe does not declare its length
        uint64_t room = s->size + s->size / 4 + BLOCK;
        if (room > limit)
            room = limit + 1;
        st = read_until(log, path, room, s);
    }
    if (!st && s->more)
        st = gp_fail(log, GP_ERR_DATA,
            "%s: more than --max-pixels allows (over %llu bytes); "
            "raise it, or give files", path, (unsigned long long) limit);
    if (st)
        gp_stream_close(s);
    return st;
}

/* Refuses a stream without a byte; closes it where opening it failed. */
static gp_status check_size(const struct gp_log *log, const char *path,
                            struct gp_stream *s, gp_status st)
{
    if (!st && s->size == 0)
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: is empty (0 bytes); write or render it again", path);
    if (st)
        gp_stream_close(s);
    return st;
}

gp_status gp_stream_open(const struct gp_log *log, const char *path,
                         uint64_t first, struct gp_stream *s)
{
    struct stat info;
    gp_status st = GP_OK;
    *s = (struct gp_stream) GP_STREAM_EMPTY;
    s->fd = STDIN_FILENO;
    if (strcmp(path, "-") != 0)
        s->fd = open(path, O_RDONLY | O_CLOEXEC);
    if (s->fd < 0)
        return gp_fail(log, GP_ERR_IO, "%s: cannot open (%s); check the name",
                       path, strerror(errno));
    if (fstat(s->fd, &info)) {
        st = gp_stream_failed(log, path);
    } else if (S_ISDIR(info.st_mode)) {
        st = gp_fail(log, GP_ERR_IO,
                     "%s: is a folder; give a file or a pattern such as "
                     "frame.####.exr", path);
    } else if (S_ISREG(info.st_mode) && s->fd != STDIN_FILENO) {
        s->size = (uint64_t) info.st_size;
    } else { // also a redirected stdin, whose offset may not be 0
        s->more = true;
        st = read_until(log, path, first, s);
    }
    return check_size(log, path, s, st);
}

gp_status gp_stream_open_regular(const struct gp_log *log, const char *path,
                                 struct gp_stream *s)
{
    *s = (struct gp_stream) GP_STREAM_EMPTY;
    const gp_status st = gp_open_regular(log, path, &s->fd, &s->size);
    return check_size(log, path, s, st);
}

int64_t gp_stream_read(const struct gp_stream *s, void *to, uint64_t n,
                       uint64_t offset)
{
    uint64_t done = 0;
    if (offset >= s->size)
        return 0;
    if (n > s->size - offset)
        n = s->size - offset;
    if (s->data) {
        memcpy(to, s->data + offset, n);
        return (int64_t) n;
    }
    while (done < n) {
        const ssize_t got = pread(s->fd, (uint8_t *) to + done, n - done,
                                  (off_t) (offset + done));
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

void gp_stream_close(struct gp_stream *s)
{
    close_fd(s);
    if (!s->borrowed)
        gp_free(s->data);
    *s = (struct gp_stream) GP_STREAM_EMPTY;
}
