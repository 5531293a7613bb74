/* Lists the attributes of a header with their bytes, which --hdr copies, and
 * bounds their number, before the library parses them: it gives no attribute's
 * bytes, nor their places, in any version.
 *
 * It sorts channels and attributes by a walk from one end (3.1.5 to 3.4): lists
 * of n take it n^2 / 2 comparisons of names. So the squares of the lengths of
 * all channel lists together are bounded, those of attributes, and the parts. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/memory.h"

#include <errno.h>
#include <limits.h>
#include <string.h>

enum {
    NAME = 256,   // bytes of any name with its null, at most
    CHANNEL = 16, // bytes after a channel's name
    LIST_MOST = 8192,
};

/* A walk over the bytes that are loaded: the first ones count, then one lists
 * the attributes. */
struct walk {
    const struct gp_log *log;
    const char *path;
    const struct gp_stream *stream;
    struct gp_exr_index *index;
    size_t loaded; // bytes of index->bytes
    bool more;     // the header goes on after these
};

/* Steps over the name at *at, with its null. False where it does not end. */
static bool skip_name(struct walk *w, size_t *at)
{
    const size_t left = w->loaded - *at, n = left < NAME ? left : NAME;
    const uint8_t *const from = w->index->bytes + *at;
    const uint8_t *const null = memchr(from, 0, n);
    w->more |= !null && n < NAME;
    *at += null ? (size_t) (null - from) + 1 : 0;
    return null;
}

/* Reads the attribute at *at and steps over it. False where it does not end. */
static bool read_attribute(struct walk *w, size_t *at, struct gp_exr_attr *out)
{
    const uint8_t *const bytes = w->index->bytes;
    size_t type = *at, size;
    if (!skip_name(w, &type))
        return false;
    size = type;
    if (!skip_name(w, &size))
        return false;
    const size_t value = size + sizeof out->size;
    w->more |= value > w->loaded;
    if (w->more)
        return false;
    *out = (struct gp_exr_attr) {
        .name = (const char *) bytes + *at, .type = (const char *) bytes + type,
        .data = bytes + value, .size = gp_le32(bytes + size),
    };
    if (out->size > INT_MAX || value + out->size >= w->stream->size)
        return false;
    *at = value + out->size;
    w->more |= *at >= w->loaded;
    return !w->more;
}

/* Returns how many channels a list begins with, as far as LIST_MOST + 1.
 *
 *   whole  written: the list ends where its bytes do. The library stops at its
 *          null, and would take what follows for another attribute */
static uint64_t count_channels(const struct gp_exr_attr *list, bool *whole)
{
    uint64_t n = 0;
    *whole = false;
    for (size_t at = 0; at < list->size && n <= LIST_MOST; n++) {
        const uint8_t *const null =
            memchr(list->data + at, 0, list->size - at);
        if (!null || null == list->data + at) { // no more, or the list's end
            *whole = null && at + 1 == list->size;
            break;
        }
        at = (size_t) (null - list->data) + 1 + CHANNEL;
    }
    return n;
}

/* Checks what OpenEXRCore does not (3.1.5 to 3.4): film codes (SMPTE 254), and
 * the sizes of two types that it does not know. OpenEXR's C++ library would
 * refuse an output that such a value is carried to. */
static bool is_value(const struct gp_exr_attr *a)
{
    static const uint32_t least[7] = {0, 0, 0, 0, 0, 1, 20};
    static const uint32_t most[7] = {99, 99, 999999, 9999, 119, 15, 120};
    bool fits = true;
    if (strcmp(a->type, "deepImageState") == 0)
        return a->size == 1;
    if (strcmp(a->type, "idmanifest") == 0)
        return a->size >= 8;
    if (strcmp(a->type, "keycode") != 0 || a->size != sizeof least)
        return true;
    for (int i = 0; i < 7; i++) {
        const uint32_t code = gp_le32(a->data + 4 * i);
        fits = fits && code >= least[i] && code <= most[i];
    }
    return fits;
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

/* Walks all parts; sets index->tables where they end. */
static gp_status walk_parts(struct walk *w)
{
    struct gp_exr_index *const index = w->index;
    struct gp_exr_attr a;
    uint64_t channels = 0, attributes = 0;
    size_t at = 8;
    gp_status st = GP_OK;
    w->more = w->loaded <= at;
    index->parts = index->attrs = 0;
    while (!w->more) {
        const size_t from = at;
        uint64_t n = 0;
        for (; index->bytes[at]; n++) {
            const size_t name = at;
            if (!read_attribute(w, &at, &a))
                return GP_OK;
            GP_TRY(check_length(w, attributes, "attributes", n + 1));
            bool right = is_value(&a);
            if (strcmp(a.type, "chlist") == 0) {
                const uint64_t listed = count_channels(&a, &right);
                GP_TRY(check_length(w, channels, "channels", listed));
                channels += listed * listed;
            }
            if (!right)
                return gp_fail(w->log, GP_ERR_DATA,
                               "%s: attribute %s is damaged (its value is no "
                               "%s); copy or render the file again", w->path,
                               gp_exr_plain((char *) index->bytes + name),
                               a.type);
            if (!index->type && index->flat && strcmp(a.name, "type") == 0)
                index->type = name;
            if (index->part)
                index->attr[(uint64_t) index->attrs + n] = a;
        }
        at++;
        if (!index->multi || n == 0) // or the null that ends all parts
            index->tables = at;
        if (index->multi && n == 0)
            break;
        GP_TRY(check_length(w, 0, "parts", (uint64_t) index->parts + 1));
        if (index->part)
            index->part[index->parts] = (struct gp_exr_index_part) {
                .from = from, .to = at, .attr = index->attr + index->attrs,
                .attrs = (int) n,
            };
        attributes += n * n;
        index->attrs += (int) n;
        index->parts++;
        if (!index->multi)
            break;
        w->more = at >= w->loaded;
    }
out:
    return st;
}

gp_status gp_exr_index_make(const struct gp_log *log, const char *path,
                            const struct gp_stream *s, struct gp_exr_index *out)
{
    enum { FIRST = 4096 }; // most headers
    struct walk w = {.log = log, .path = path, .stream = s, .index = out};
    gp_status st = GP_OK;
    *out = (struct gp_exr_index) {0};
    for (w.more = true; w.more && w.loaded < s->size;) {
        const uint64_t room = w.loaded ? 2 * w.loaded : FIRST;
        const uint64_t end = room < s->size ? room : s->size;
        void *block = out->bytes;
        GP_TRY(gp_resize(log, path, end, &block));
        out->bytes = block;
        const int64_t got = gp_stream_read(s, out->bytes + w.loaded,
                                           end - w.loaded, w.loaded);
        if (got < 0)
            GP_TRY(gp_fail(log, GP_ERR_IO, "%s: cannot read (%s); check the "
                           "disk", path, strerror(errno)));
        if (got <= 0) // a file that has become shorter
            break;
        w.loaded += (size_t) got;
        const uint32_t flags = w.loaded > 8 ? gp_le32(out->bytes + 4) : 0;
        out->multi = flags & GP_EXR_MULTIPART;
        out->flat = !(flags & (GP_EXR_DEEP | GP_EXR_MULTIPART));
        GP_TRY(walk_parts(&w));
    }
    if (out->parts == 0)
        out->tables = 0;
    if (out->tables) {
        GP_TRY(gp_alloc(log, path, (size_t) out->parts, sizeof *out->part,
                        &out->part));
        GP_TRY(gp_alloc(log, path, (size_t) out->attrs, sizeof *out->attr,
                        &out->attr));
        GP_TRY(walk_parts(&w));
    }
out:
    return st;
}

void gp_exr_index_free(struct gp_exr_index *index)
{
    gp_free(index->bytes);
    gp_free(index->part);
    gp_free(index->attr);
    *index = (struct gp_exr_index) {0};
}
