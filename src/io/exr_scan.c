#include "io/exr_scan.h"

#include <stdbool.h>
#include <string.h>

enum {
    NAME = 256,                  // bytes of a name with its null, at most
    CHANNEL = 16,                // behind a channel's name
    PARTS = 0x10,                // flags in byte 5 of the file: several parts,
    DEEP = 0x08,                 // a deep part
};

struct attribute {
    uint64_t at, data, size; // bytes in the file
    bool is_type, is_channels;
};

enum found { ATTRIBUTE, END_OF_PART, DAMAGED };

static enum found next(const struct gp_stream *s, uint64_t at,
                       struct attribute *a)
{
    uint8_t b[2 * NAME + 4]; // a name, its type, its size
    const int64_t n = gp_stream_read(s, b, sizeof b, at);
    if (n < 1)
        return DAMAGED;
    if (b[0] == 0)
        return END_OF_PART;
    const uint8_t *const end = b + n;
    const uint8_t *const type = memchr(b, 0, (size_t) n);
    const uint8_t *const size =
        type ? memchr(type + 1, 0, (size_t) (end - type) - 1) : NULL;
    if (!size || end - size < 5)
        return DAMAGED;
    *a = (struct attribute) {
        .at = at, .data = at + (uint64_t) (size + 5 - b),
        .size = (uint64_t) size[1] | (uint64_t) size[2] << 8 |
                (uint64_t) size[3] << 16 | (uint64_t) size[4] << 24,
        .is_type = strcmp((const char *) b, "type") == 0,
        .is_channels = strcmp((const char *) type + 1, "chlist") == 0,
    };
    return ATTRIBUTE;
}

/* Channels of a list, as far as `most` of them. */
static uint64_t count_channels(const struct gp_stream *s,
                               const struct attribute *a, uint64_t most)
{
    uint8_t b[16 * NAME];
    const uint64_t end = a->data + a->size;
    uint64_t from = 0, to = a->data, n = 0; // b holds [from, to)
    for (uint64_t at = a->data; at < end && n < most; n++) {
        if (at + NAME > to && to < end) {
            const uint64_t size = end - at < sizeof b ? end - at : sizeof b;
            const int64_t got = gp_stream_read(s, b, size, at);
            from = at;
            to = at + (uint64_t) (got > 0 ? got : 0);
        }
        const uint8_t *const name = b + (at - from);
        const uint8_t *const null =
            at < to ? memchr(name, 0, (size_t) (to - at)) : NULL;
        if (!null || null == name) // the list's end, or damage
            break;
        at += (uint64_t) (null - name) + 1 + CHANNEL;
    }
    return n;
}

/* False when a list of n is too long behind lists of one kind whose squares
 * were `before`. */
static bool allow(struct gp_exr_scan *scan, uint64_t before, const char *what,
                  uint64_t n)
{
    const uint64_t most = (uint64_t) GP_EXR_LIST_MOST * GP_EXR_LIST_MOST;
    scan->count = n;
    if (before + n * n > most)
        scan->too_long = what;
    return !scan->too_long;
}

struct gp_exr_scan gp_exr_scan_header(const struct gp_stream *s)
{
    struct gp_exr_scan scan = {0};
    uint8_t head[8];
    uint64_t all_channels = 0, all_attributes = 0; // squares
    uint64_t attributes = 0, parts = 1, at = sizeof head;
    if (gp_stream_read(s, head, sizeof head, 0) < (int64_t) sizeof head)
        return scan;
    const bool flat = !(head[5] & (DEEP | PARTS));
    scan.multi = head[5] & PARTS;
    for (;;) {
        struct attribute a;
        const enum found found = next(s, at, &a);
        if (found == DAMAGED)
            return scan;
        if (found == END_OF_PART) {
            at++;
            all_attributes += attributes * attributes;
            if (!scan.multi || attributes == 0) {
                scan.tables = at;
                return scan;
            }
            if (!allow(&scan, 0, "parts", ++parts))
                return scan;
            attributes = 0;
            continue;
        }
        if (!allow(&scan, all_attributes, "attributes", ++attributes))
            return scan;
        if (a.is_type && flat && !scan.type)
            scan.type = a.at;
        if (a.is_channels) {
            const uint64_t n = count_channels(s, &a, GP_EXR_LIST_MOST + 1);
            if (!allow(&scan, all_channels, "channels", n))
                return scan;
            all_channels += n * n;
        }
        at = a.data + a.size;
    }
}
