/* Checks the bytes of a header, before the library parses them. */
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

/* A block of the file, so that short reads cost no call each. */
struct window {
    const struct gp_stream *stream;
    uint64_t from, to; // the bytes of the file that are in b
    int error;         // errno of a read that failed, else 0
    uint8_t b[16 * NAME];
};

/* Up to `n` bytes, at most NAME, at `at`; *left is how many there are. NULL
 * when there is none. */
static const uint8_t *window_at(struct window *w, uint64_t at, uint64_t n,
                                size_t *left)
{
    if (at < w->from || at + n > w->to) {
        const int64_t got = gp_stream_read(w->stream, w->b, sizeof w->b, at);
        w->error = got < 0 ? errno : w->error;
        w->from = at;
        w->to = at + (uint64_t) (got > 0 ? got : 0);
    }
    *left = (size_t) (w->to - at < n ? w->to - at : n);
    return *left > 0 ? w->b + (at - w->from) : NULL;
}

/* -- values --------------------------------------------------------------- */

/* A value in the file: bytes [at, at + size). */
struct value {
    struct window *w;
    uint64_t at, size;
};

/* Walks a list of channels, as far as `most` of them; returns how many there
 * are.
 *
 *   complete  written: the list ends where the value does, or the file
 *             before */
static uint64_t count_channels(const struct value *v, uint64_t most,
                               bool *complete)
{
    const uint64_t end = v->at + v->size;
    uint64_t n = 0;
    *complete = false;
    for (uint64_t at = v->at; at < end && n < most; n++) {
        const uint64_t room = end - at < NAME ? end - at : NAME;
        size_t left;
        const uint8_t *const name = window_at(v->w, at, room, &left);
        const uint8_t *const null = name ? memchr(name, 0, left) : NULL;
        if (!null || null == name) { // no more, or the list's end
            *complete = null ? at + 1 == end : left < NAME && at + left < end;
            break;
        }
        at += (uint64_t) (null - name) + 1 + CHANNEL;
    }
    return n;
}

/* Film codes within the ranges of SMPTE 254. */
static bool is_keycode(const struct value *v)
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
    size_t left;
    if (v->size != 4 * N)
        return false;
    const uint8_t *const b = window_at(v->w, v->at, 4 * N, &left);
    for (size_t i = 0; left == 4 * N && i < N; i++) {
        const uint32_t code = gp_le32(b + 4 * i);
        if (code < range[i].lo || code > range[i].hi)
            return false;
    }
    return true;
}

/* Width, height and as many RGBA bytes. */
static bool is_preview(const struct value *v)
{
    size_t left;
    if (v->size < 8)
        return false;
    const uint8_t *const b = window_at(v->w, v->at, 8, &left);
    if (left < 8)
        return true;
    const uint64_t w = gp_le32(b), h = gp_le32(b + 4);
    return w <= INT32_MAX && h <= INT32_MAX && v->size == 8 + 4 * w * h;
}

/* Strings, each after its length. */
static bool is_stringvector(const struct value *v)
{
    const uint64_t end = v->at + v->size;
    for (uint64_t at = v->at; at < end;) {
        size_t left;
        if (end - at < 4)
            return false;
        const uint8_t *const b = window_at(v->w, at, 4, &left);
        if (left < 4)
            return true;
        at += 4;
        if (gp_le32(b) > end - at)
            return false;
        at += gp_le32(b);
    }
    return true;
}

/* Returns true when the bytes are a value of that type, for types that OpenEXR
 * does not know, and for bytes that cannot be read, which the library
 * reports. */
static bool value_is(const struct value *v, const char *type)
{
    // those of OpenEXR's C++ library; "string" and "bytes" may be any bytes
    static const struct {
        const char *name;
        uint64_t size;
        bool (*is)(const struct value *v); // for types of several sizes
    } types[] = {
        {"box2f", 16, NULL},         {"box2i", 16, NULL},
        {"chromaticities", 32, NULL}, {"compression", 1, NULL},
        {"deepImageState", 1, NULL}, {"double", 8, NULL},
        {"envmap", 1, NULL},         {"float", 4, NULL},
        {"int", 4, NULL},            {"keycode", 0, is_keycode},
        {"lineOrder", 1, NULL},      {"m33d", 72, NULL},
        {"m33f", 36, NULL},          {"m44d", 128, NULL},
        {"m44f", 64, NULL},          {"preview", 0, is_preview},
        {"rational", 8, NULL},       {"stringvector", 0, is_stringvector},
        {"tiledesc", 9, NULL},       {"timecode", 8, NULL},
        {"v2d", 16, NULL},           {"v2f", 8, NULL},
        {"v2i", 8, NULL},            {"v3d", 24, NULL},
        {"v3f", 12, NULL},           {"v3i", 12, NULL},
    };
    bool complete;
    if (strcmp(type, "chlist") == 0) {
        (void) count_channels(v, UINT64_MAX, &complete);
        return complete;
    }
    if (strcmp(type, "floatvector") == 0)
        return v->size % 4 == 0;
    if (strcmp(type, "idmanifest") == 0) // unpacked size, then what is packed
        return v->size >= 8;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(type, types[i].name) == 0)
            return types[i].is ? types[i].is(v) : v->size == types[i].size;
    }
    return true;
}

bool gp_exr_value_is(const struct gp_stream *s, const char *type)
{
    struct window w = {.stream = s};
    return value_is(&(struct value) {&w, 0, s->size}, type);
}

/* -- the walk ------------------------------------------------------------- */

struct walk {
    const struct gp_log *log;
    const char *path;
    struct window w;
    struct gp_exr_index *index;
    uint64_t channels, attributes; // squares of the lists that have ended
    // the attribute at hand
    char name[NAME], type[NAME];
    struct gp_exr_place at;
};

/* Copies the name at *at, of up to 255 bytes and its null, and steps over it.
 * False when it does not end in time. */
static bool read_name(struct window *w, uint64_t *at, char to[NAME])
{
    size_t left;
    const uint8_t *const from = window_at(w, *at, NAME, &left);
    const uint8_t *const null = from ? memchr(from, 0, left) : NULL;
    if (!null)
        return false;
    memcpy(to, from, (size_t) (null - from) + 1);
    *at += (uint64_t) (null - from) + 1;
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

/* Makes room for one more than n in a list, which doubles at powers of two. */
static gp_status grow_list(const struct walk *walk, void **list, int n,
                           size_t size)
{
    if (n & (n - 1))
        return GP_OK;
    return gp_resize(walk->log, walk->path, (n ? 2 * (size_t) n : 1) * size,
                     list);
}

/* Checks the attribute at hand, and puts it into the index. */
static gp_status add_attribute(struct walk *walk,
                               struct gp_exr_index_part *part)
{
    static const struct {
        const char *name, *type; // that it must have
        bool multi;              // only in files of several parts
    } known[] = {
        {"channels", "chlist", false},
        {"compression", "compression", false},
        {"dataWindow", "box2i", false},
        {"displayWindow", "box2i", false},
        {"lineOrder", "lineOrder", false},
        {"pixelAspectRatio", "float", false},
        {"screenWindowCenter", "v2f", false},
        {"screenWindowWidth", "float", false},
        {"type", "string", false},
        {"name", "string", true},
        {"chunkCount", "int", true},
    };
    struct gp_exr_index *const index = walk->index;
    const struct value v = {&walk->w, walk->at.value, walk->at.size};
    const char *must = NULL; // any type
    void *list = index->attr;
    gp_status st;
    GP_TRY(check_length(walk, walk->attributes, "attributes",
                        (uint64_t) ++part->attrs));
    if (strcmp(walk->type, "chlist") == 0) {
        bool complete;
        const uint64_t n = count_channels(&v, LIST_MOST + 1, &complete);
        GP_TRY(check_length(walk, walk->channels, "channels", n));
        walk->channels += n * n;
    }
    for (size_t i = 0; i < sizeof known / sizeof *known; i++) {
        if (strcmp(walk->name, known[i].name) == 0 &&
            (index->multi || !known[i].multi))
            must = known[i].type;
    }
    const bool fits = (!must || strcmp(must, walk->type) == 0) &&
                      value_is(&v, walk->type);
    if (!fits && !walk->w.error) {
        for (char *c = walk->name; *c; c++) // damage may have made any bytes
            *c = *c > ' ' && *c <= '~' ? *c : '?';
        for (char *c = walk->type; *c; c++)
            *c = *c > ' ' && *c <= '~' ? *c : '?';
        GP_TRY(gp_fail(walk->log, GP_ERR_DATA,
                       "%s: attribute %s is damaged (its %u bytes are not a "
                       "valid %s); copy or render the file again", walk->path,
                       walk->name, walk->at.size, must ? must : walk->type));
    }
    GP_TRY(grow_list(walk, &list, index->attrs, sizeof *index->attr));
    index->attr = list;
    index->attr[index->attrs++] = walk->at;
out:
    return st;
}

/* Walks a part's header from `at` on, to *end; 0 where it is damaged. */
static gp_status walk_part(struct walk *walk, uint64_t at, uint64_t *end)
{
    struct gp_exr_index *const index = walk->index;
    struct gp_exr_index_part part = {.from = at, .attr = index->attrs};
    struct window *const w = &walk->w;
    struct gp_exr_place *const to = &walk->at;
    const uint8_t *b;
    size_t left;
    gp_status st;
    *end = 0;
    while ((b = window_at(w, at, 1, &left)) && *b != 0) {
        to->name = to->type = at;
        if (!read_name(w, &to->type, walk->name))
            return GP_OK;
        to->value = to->type;
        if (!read_name(w, &to->value, walk->type))
            return GP_OK;
        b = window_at(w, to->value, 4, &left);
        if (left < 4)
            return GP_OK;
        to->size = gp_le32(b);
        to->value += 4;
        st = add_attribute(walk, &part);
        if (st)
            return st;
        if (!index->type && index->flat && strcmp(walk->name, "type") == 0)
            index->type = at;
        at = to->value + to->size;
        if (to->size > INT_MAX || at > w->stream->size)
            return GP_OK;
    }
    if (!b)
        return GP_OK;
    *end = part.to = at + 1;
    walk->attributes += (uint64_t) part.attrs * (uint64_t) part.attrs;
    if (index->multi && part.attrs == 0) // the null that ends all parts
        return GP_OK;
    void *list = index->part;
    st = check_length(walk, 0, "parts", (uint64_t) index->parts + 1);
    if (!st)
        st = grow_list(walk, &list, index->parts, sizeof part);
    index->part = list;
    if (!st)
        index->part[index->parts++] = part;
    return st;
}

gp_status gp_exr_index_make(const struct gp_log *log, const char *path,
                            const struct gp_stream *s, struct gp_exr_index *out)
{
    enum { PARTS = 0x10, DEEP = 0x08 }; // flags in byte 5 of the file
    struct walk walk = {.log = log, .path = path, .index = out};
    uint64_t at = 8, end = 0;
    size_t left;
    *out = (struct gp_exr_index) {0};
    walk.w.stream = s;
    const uint8_t *const head = window_at(&walk.w, 0, at, &left);
    gp_status st = GP_OK;
    if (head && left == at) {
        out->multi = head[5] & PARTS;
        out->flat = !(head[5] & (DEEP | PARTS));
        for (int parts = 0; !st; parts++) {
            st = walk_part(&walk, at, &end);
            at = end;
            if (end == 0 || !out->multi || out->parts == parts)
                break;
        }
    }
    if (walk.w.error && !st)
        st = gp_fail(log, GP_ERR_IO, "%s: cannot read (%s); check the disk",
                     path, strerror(walk.w.error));
    out->tables = st ? 0 : end;
    return st;
}

void gp_exr_index_free(struct gp_exr_index *index)
{
    gp_free(index->part);
    gp_free(index->attr);
    *index = (struct gp_exr_index) {0};
}
