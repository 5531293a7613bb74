// SPDX-License-Identifier: Apache-2.0
/* The bytes of an input: a file, or all of stdin or a pipe in memory. */
#ifndef GP_IO_STREAM_H
#define GP_IO_STREAM_H

#include "core/status.h"

#include <stdbool.h>
#include <stdint.h>

struct gp_stream {
    int fd;         // a regular file, a pipe with more, or -1
    uint8_t *data;  // all bytes, or NULL when fd is used
    uint64_t size;
    bool borrowed;  // data belongs to a caller that outlives this
    bool more;      // a pipe of which only the start is in data; fd is its
};
#define GP_STREAM_EMPTY { .fd = -1 }

/* Bytes that belong to the caller, as a stream. */
static inline struct gp_stream gp_stream_of(const void *data, uint64_t size)
{
    return (struct gp_stream) {
        .fd = -1, .data = (uint8_t *) (uintptr_t) data, .size = size,
        .borrowed = true,
    };
}

/* Opens `path`, or stdin for "-". Regular files stay on disk and are read
 * with pread(): a file that shrinks meanwhile is a short read and never a
 * signal. Of pipes, devices and terminals it reads the first bytes into memory,
 * so that data that is no image is refused before the rest is read.
 *
 *   first  how many, >= 1; fewer only where the pipe ends
 *   s      written always; empty on failure; s->more: gp_stream_fill() is
 *          still to come
 *
 * Errors: GP_ERR_IO cannot open or read, is a folder; GP_ERR_DATA empty. */
GP_MUST_CHECK gp_status gp_stream_open(const struct gp_log *log,
    const char *path, uint64_t first, struct gp_stream *s);

/* Opens a regular file; "-" is a name too.
 * Errors: those of gp_open_regular(); GP_ERR_DATA empty. */
GP_MUST_CHECK gp_status gp_stream_open_regular(const struct gp_log *log,
    const char *path, struct gp_stream *s);

/* Reads a pipe to its end into memory; does nothing for other streams. Takes at
 * most a quarter (and 64 KiB) more memory than the pipe gave, and never more
 * than `limit` + 1 bytes.
 *
 *   limit  most bytes to take, >= what was read before
 *   s      empty on failure
 *
 * Errors: GP_ERR_IO cannot read; GP_ERR_DATA it gives more than `limit`. */
GP_MUST_CHECK gp_status gp_stream_fill(const struct gp_log *log,
    const char *path, uint64_t limit, struct gp_stream *s);

/* Reads up to `n` bytes at `offset`. Returns how many there were, which is
 * less than n only at the end, or -1 with errno. Any number of threads may
 * read at once. */
int64_t gp_stream_read(const struct gp_stream *s, void *to, uint64_t n,
                       uint64_t offset);

/* Prints the line for a read that failed, by errno; returns GP_ERR_IO. */
gp_status gp_stream_failed(const struct gp_log *log, const char *path);

/* Closes and frees; an empty or closed stream is fine. */
void gp_stream_close(struct gp_stream *s);

#endif
