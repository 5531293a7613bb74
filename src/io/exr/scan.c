#include "io/exr/exr_priv.h"


#include <stdbool.h>
#include <string.h>

enum {
    NAME = GP_EXR_NAME,
    PARTS = 0x10,                // flags in byte 5 of the file: several parts,
    DEEP = 0x08,                 // a deep part
};

struct attribute {
    uint64_t at; // byte in the file
    uint8_t head[2 * NAME + 4];
    const char *name, *type; // in head
    struct gp_exr_value value;
};

enum found { ATTRIBUTE, END_OF_PART, DAMAGED };

static enum found next(const struct gp_stream *s, uint64_t at,
                       struct attribute *a)
{
    uint8_t *const b = a->head;
    const int64_t n = gp_stream_read(s, b, sizeof a->head, at);
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
    a->at = at;
    a->name = (const char *) b;
    a->type = (const char *) type + 1;
    a->value = (struct gp_exr_value) {
        .stream = s, .at = at + (uint64_t) (size + 5 - b),
        .size = (uint64_t) size[1] | (uint64_t) size[2] << 8 |
                (uint64_t) size[3] << 16 | (uint64_t) size[4] << 24,
    };
    return ATTRIBUTE;
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

/* For a line of text; what damage made of a name may be any bytes. */
static void copy_word(char to[NAME], const char *from)
{
    int n = 0;
    for (; n < NAME - 1 && from[n]; n++)
        to[n] = from[n] > ' ' && from[n] <= '~' ? from[n] : '?';
    to[n] = '\0';
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
        if (strcmp(a.name, "type") == 0 && flat && !scan.type)
            scan.type = a.at;
        if (strcmp(a.type, "chlist") == 0) {
            bool whole;
            const uint64_t n =
                gp_exr_count_channels(&a.value, GP_EXR_LIST_MOST + 1, &whole);
            if (!allow(&scan, all_channels, "channels", n))
                return scan;
            all_channels += n * n;
        }
        const char *const must = gp_exr_type_of(a.name, scan.multi);
        if ((must && strcmp(must, a.type) != 0) ||
            !gp_exr_value_is(&a.value, a.type)) {
            scan.damaged = true;
            scan.count = a.value.size;
            copy_word(scan.name, a.name);
            copy_word(scan.kind, must ? must : a.type);
            return scan;
        }
        at = a.value.at + a.value.size;
    }
}
