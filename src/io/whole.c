#include "io/whole.h"

#include "io/whole_iff.h"
#include "io/whole_tiff.h"

#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

enum { BLOCK = 1 << 16 };

/* A place in a stream, read a block at a time. */
struct reader {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *s;
    uint64_t at;            // of block[0]
    size_t next, held;      // in block
    uint8_t block[BLOCK];
};

static gp_status cut_off(const struct reader *r, const char *where)
{
    return gp_fail(r->log, GP_ERR_DATA,
                   "%s: cut off or damaged (the file ends in %s); copy or "
                   "render the file again", r->path, where);
}

/* The bytes of the block from `next` on, at least one: *n is how many. */
static gp_status fill(struct reader *r, const char *where, size_t *n)
{
    if (r->next == r->held) {
        r->at += r->held;
        const int64_t got = gp_stream_read(r->s, r->block, BLOCK, r->at);
        if (got < 0)
            return gp_fail(r->log, GP_ERR_IO,
                           "%s: cannot be read (%s); check the disk", r->path,
                           strerror(errno));
        if (got == 0)
            return cut_off(r, where);
        r->next = 0;
        r->held = (size_t) got;
    }
    *n = r->held - r->next;
    return GP_OK;
}

/* Passes over `size` bytes, which may be more than the file has; `to` takes
 * them where it is not NULL. */
static gp_status pass(struct reader *r, const char *where, uint64_t size,
                      uint8_t *to)
{
    while (size > 0) {
        size_t n = 0;
        const gp_status st = fill(r, where, &n);
        if (st)
            return st;
        if (n > size)
            n = (size_t) size;
        const uint8_t *const from = r->block + r->next;
        if (to) {
            memcpy(to, from, n);
            to += n;
        }
        r->next += n;
        size -= n;
    }
    return GP_OK;
}

static uint32_t be32(const uint8_t b[4])
{
    return (uint32_t) b[0] << 24 | (uint32_t) b[1] << 16 |
           (uint32_t) b[2] << 8 | b[3];
}

// -- JPEG ---------------------------------------------------------------------

enum { SOI = 0xd8, EOI = 0xd9, SOS = 0xda, TEM = 0x01, RST0 = 0xd0 };

/* To the code of the next marker; in a scan 0 and RST are parts of it. */
static gp_status next_marker(struct reader *r, bool scan, uint8_t *code)
{
    const char *const where = scan ? "a scan" : "its headers";
    size_t n = 0;
    for (;;) {
        gp_status st = fill(r, where, &n);
        if (st)
            return st;
        const uint8_t *const from = r->block + r->next;
        const uint8_t *const found = memchr(from, 0xff, n);
        r->next += found ? (size_t) (found - from) + 1 : n;
        if (!found)
            continue;
        do // any number of 0xff may fill up before the code
            st = pass(r, where, 1, code);
        while (!st && *code == 0xff);
        if (st || (*code != 0 && !(scan && *code >= RST0 && *code < SOI)))
            return st;
    }
}

static gp_status check_jpeg(struct reader *r)
{
    uint8_t code = 0;
    bool scan = false;
    gp_status st = pass(r, "its first bytes", 2, NULL);
    while (!st && !(st = next_marker(r, scan, &code)) && code != EOI) {
        uint8_t size[2] = {0, 0};
        scan = code == SOS;
        if (code == TEM || (code >= RST0 && code <= SOI))
            continue; // these stand alone
        st = pass(r, "its headers", 2, size);
        const unsigned length = (unsigned) size[0] << 8 | size[1];
        if (!st && length > 2)
            st = pass(r, "its headers", length - 2, NULL);
    }
    return st;
}

// -- DPX ----------------------------------------------------------------------

/* What the header says of the user's own data, which the reader takes memory
 * for: bytes 32 to 35, all bits set when there are none. */
static gp_status check_dpx(struct reader *r, bool big)
{
    uint8_t head[36];
    const gp_status st = pass(r, "its header", sizeof head, head);
    if (st)
        return st;
    const uint8_t *const b = head + 32;
    const uint32_t user = big ? be32(b)
                              : (uint32_t) b[3] << 24 | (uint32_t) b[2] << 16 |
                                    (uint32_t) b[1] << 8 | b[0];
    return user == UINT32_MAX || user <= r->s->size
               ? GP_OK
               : cut_off(r, "its user data");
}

gp_status gp_whole_check(const struct gp_log *log, const char *path,
                         const struct gp_stream *s, int part,
                         long long max_pixels)
{
    static const uint8_t jpeg[3] = "\xff\xd8\xff";
    uint8_t magic[8] = {0};
    if (gp_stream_read(s, magic, sizeof magic, 0) < (int64_t) sizeof jpeg)
        return GP_OK;
    struct reader r = {.log = log, .path = path, .s = s};
    if (memcmp(magic, "II*\0", 4) == 0 || memcmp(magic, "II+\0", 4) == 0 ||
        memcmp(magic, "MM\0*", 4) == 0 || memcmp(magic, "MM\0+", 4) == 0)
        return gp_whole_tiff(log, path, s, part, max_pixels);
    if (memcmp(magic, "FOR4", 4) == 0)
        return gp_whole_iff(log, path, s, max_pixels);
    if (memcmp(magic, "SDPX", 4) == 0 || memcmp(magic, "XPDS", 4) == 0)
        return check_dpx(&r, magic[0] == 'S');
    return memcmp(magic, jpeg, sizeof jpeg) == 0 ? check_jpeg(&r) : GP_OK;
}
