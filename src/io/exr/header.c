/* Lists the attributes of a header with their bytes, which --hdr copies, and
 * bounds their number, before the library parses them. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/memory.h"

#include <errno.h>
#include <limits.h>
#include <string.h>

enum {
    NAME = GP_EXR_NAME,
    CHANNEL = 16, // bytes after a channel's name
    /* OpenEXRCore (3.1.5) puts every channel and attribute into its sorted list
     * by a walk from one end: lists of n take it n^2 / 2 comparisons of names.
     * So the squares of the lengths of all channel lists together are bounded
     * by the square of this, and so are those of attributes, and the parts. */
    LIST_MOST = 8192,
};

/* -- values that OpenEXRCore 3.1.5 does not check ---------------------------
 *
 * It stops at the null of a channel list, takes any film code, and does not know
 * two types. OpenEXR's C++ library would refuse an output that such a value is
 * carried to. Once OpenEXRCore checks them too (not at 3.4), these go. */

/* Walks a list of channels, as far as `most` of them; returns how many there
 * are.
 *
 *   complete  written: the list ends where its bytes do */
static uint64_t count_channels(const uint8_t *b, size_t size, uint64_t most,
                               bool *complete)
{
    uint64_t n = 0;
    *complete = false;
    for (size_t at = 0; at < size && n < most; n++) {
        const size_t left = size - at;
        const uint8_t *const null =
            memchr(b + at, 0, left < NAME ? left : NAME);
        if (!null || null == b + at) { // no more, or the list's end
            *complete = null && at + 1 == size;
            break;
        }
        at = (size_t) (null - b) + 1 + CHANNEL;
    }
    return n;
}

/* Film codes within the ranges of SMPTE 254. */
static bool is_keycode(const uint8_t *b, size_t size)
{
    static const struct {
        uint32_t lo, hi;
    } range[] = {
        {0, 99},    // manufacturer
        {0, 99},    // type
        {0, 999999}, // prefix
        {0, 9999},  // count
        {0, 119},   // perforation offset
        {1, 15},    // perforations a frame
        {20, 120},  // perforations a count
    };
    enum { N = sizeof range / sizeof *range };
    bool fits = size == 4 * N;
    for (size_t i = 0; fits && i < N; i++) {
        const uint32_t code = gp_le32(b + 4 * i);
        fits = code >= range[i].lo && code <= range[i].hi;
    }
    return fits;
}

static bool is_value(const uint8_t *b, size_t size, const char *type)
{
    return strcmp(type, "keycode") == 0          ? is_keycode(b, size)
           : strcmp(type, "deepImageState") == 0 ? size == 1
           : strcmp(type, "idmanifest") == 0     ? size >= 8
                                                 : true;
}

/* -- the walk ------------------------------------------------------------- */

struct walk {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *stream;
    struct gp_exr_index *index;
    uint64_t loaded; // bytes of index->bytes
    gp_status st;    // of loading them
    uint64_t channels, attributes; // squares of the lists that have ended
};

/* The first bytes of an attribute's name, type and value in the file. */
struct place {
    uint64_t name, type, value;
    uint32_t size; // of the value
};

/* Loads the file's start as far as the `n` bytes at `at`; returns how many of
 * these there are. */
static size_t load_bytes(struct walk *w, uint64_t at, uint64_t n)
{
    enum { FIRST = 4096 }; // most headers
    const uint64_t all = w->stream->size;
    const uint64_t end = n < all - at ? at + n : all;
    if (end > w->loaded && !w->st) {
        uint64_t room = end > FIRST ? end : FIRST;
        void *block = w->index->bytes;
        room = room > 2 * w->loaded ? room : 2 * w->loaded;
        room = room < all ? room : all;
        w->st = gp_resize(w->log, w->path, room, &block);
        w->index->bytes = block;
        const int64_t got =
            w->st ? 0 : gp_stream_read(w->stream, w->index->bytes + w->loaded,
                                       room - w->loaded, w->loaded);
        if (got < 0)
            w->st = gp_fail(w->log, GP_ERR_IO, "%s: cannot read (%s); check "
                            "the disk", w->path, strerror(errno));
        else
            w->loaded += (uint64_t) got;
    }
    const uint64_t left = w->loaded > at ? w->loaded - at : 0;
    return (size_t) (n < left ? n : left);
}

/* Steps over the name at *at, of up to 255 bytes and its null. False when it
 * does not end in time. */
static bool skip_name(struct walk *w, uint64_t *at)
{
    const size_t n = load_bytes(w, *at, NAME);
    const uint8_t *const from = w->index->bytes + *at;
    const uint8_t *const null = n ? memchr(from, 0, n) : NULL;
    *at += null ? (uint64_t) (null - from) + 1 : 0;
    return null;
}

/* Finds the attribute at `at`. False when its size is not there. */
static bool find_attribute(struct walk *w, uint64_t at, struct place *out)
{
    out->name = out->type = at;
    if (!skip_name(w, &out->type))
        return false;
    out->value = out->type;
    if (!skip_name(w, &out->value) || load_bytes(w, out->value, 4) < 4)
        return false;
    out->size = gp_le32(w->index->bytes + out->value);
    out->value += 4;
    return true;
}

/* Fails when a list of n is too long after lists of one kind whose squares
 * were `before`. */
static gp_status check_length(const struct walk *walk, uint64_t before,
                              const char *what, uint64_t n)
{
    if (before + n * n <= (uint64_t) LIST_MOST * LIST_MOST)
        return GP_OK;
    return gp_fail(walk->log, GP_ERR_DATA,
                   "%s: the EXR header lists too many %s (%llu or more; at "
                   "most %d, fewer in several parts); spread them over "
                   "several files", walk->path, what, (unsigned long long) n,
                   LIST_MOST);
}

void gp_exr_plain(char *text)
{
    for (; *text; text++)
        *text = *text >= ' ' && *text <= '~' ? *text : '?';
}

/* Checks an attribute, the `attrs`th of its part. */
static gp_status check_attribute(struct walk *walk, const struct place *p,
                                 uint64_t attrs)
{
    const size_t there = load_bytes(walk, p->value, p->size);
    const uint8_t *const value = walk->index->bytes + p->value;
    char *const name = (char *) walk->index->bytes + p->name;
    const char *const type = (char *) walk->index->bytes + p->type;
    gp_status st;
    GP_TRY(check_length(walk, walk->attributes, "attributes", attrs));
    if (there < p->size) // the library reports it
        return walk->st;
    bool right = is_value(value, p->size, type);
    if (strcmp(type, "chlist") == 0) {
        const uint64_t n = count_channels(value, p->size, LIST_MOST + 1,
                                          &right);
        GP_TRY(check_length(walk, walk->channels, "channels", n));
        walk->channels += n * n;
    }
    if (right)
        return GP_OK;
    gp_exr_plain(name);
    st = gp_fail(walk->log, GP_ERR_DATA,
                 "%s: attribute %s is damaged (its %u bytes are not a valid "
                 "%s); copy or render the file again", walk->path, name,
                 p->size, type);
out:
    return st;
}

/* Walks a part's header from `at` on, to *end; 0 where it is damaged. */
static gp_status walk_part(struct walk *walk, uint64_t at, uint64_t *end)
{
    struct gp_exr_index *const index = walk->index;
    struct gp_exr_index_part part = {.from = at};
    struct place p;
    void *list = index->part;
    gp_status st;
    *end = 0;
    for (; load_bytes(walk, at, 1) && index->bytes[at]; at = p.value + p.size) {
        if (!find_attribute(walk, at, &p))
            return GP_OK;
        st = check_attribute(walk, &p, (uint64_t) ++part.attrs);
        if (st)
            return st;
        if (!index->type && index->flat &&
            strcmp((const char *) index->bytes + at, "type") == 0)
            index->type = at;
        if (p.size > INT_MAX || p.value + p.size > walk->stream->size)
            return GP_OK;
    }
    if (!load_bytes(walk, at, 1))
        return GP_OK;
    *end = part.to = at + 1;
    walk->attributes += (uint64_t) part.attrs * (uint64_t) part.attrs;
    if (index->multi && part.attrs == 0) // the null that ends all parts
        return GP_OK;
    GP_TRY(check_length(walk, 0, "parts", (uint64_t) index->parts + 1));
    if ((index->parts & (index->parts - 1)) == 0) // doubles at powers of two
        GP_TRY(gp_resize(walk->log, walk->path,
                         2 * (size_t) (index->parts + 1) * sizeof part, &list));
    index->part = list;
    index->part[index->parts++] = part;
    index->attrs += part.attrs;
out:
    return st;
}

/* Lists the attributes of all parts, whose bytes are loaded. */
static gp_status list_attributes(const struct walk *w)
{
    struct gp_exr_index *const index = w->index;
    gp_status st = gp_alloc(w->log, w->path, (size_t) index->attrs,
                            sizeof *index->attr, &index->attr);
    struct gp_exr_attr *a = index->attr;
    for (int i = 0; i < index->parts && !st; i++) {
        struct gp_exr_index_part *const part = &index->part[i];
        const uint8_t *at = index->bytes + part->from;
        part->attr = a;
        for (int k = 0; k < part->attrs; k++, a++) {
            a->name = (const char *) at;
            a->type = a->name + strlen(a->name) + 1;
            at = (const uint8_t *) a->type + strlen(a->type) + 1;
            a->size = gp_le32(at);
            a->data = at + 4;
            at = a->data + a->size;
        }
    }
    return st;
}

gp_status gp_exr_index_make(const struct gp_log *log, const char *path,
                            const struct gp_stream *s, struct gp_exr_index *out)
{
    enum { PARTS = 0x10, DEEP = 0x08 }; // flags in byte 5 of the file
    struct walk walk = {.log = log, .path = path, .stream = s, .index = out};
    uint64_t at = 8, end = 0;
    *out = (struct gp_exr_index) {0};
    gp_status st = GP_OK;
    if (load_bytes(&walk, 0, at) == at) {
        out->multi = out->bytes[5] & PARTS;
        out->flat = !(out->bytes[5] & (DEEP | PARTS));
        for (int parts = 0; !st; parts++) {
            st = walk_part(&walk, at, &end);
            at = end;
            if (end == 0 || !out->multi || out->parts == parts)
                break;
        }
    }
    st = st ? st : walk.st;
    if (!st && end)
        st = list_attributes(&walk);
    out->tables = st ? 0 : end;
    return st;
}

void gp_exr_index_free(struct gp_exr_index *index)
{
    gp_free(index->bytes);
    gp_free(index->part);
    gp_free(index->attr);
    *index = (struct gp_exr_index) {0};
}
