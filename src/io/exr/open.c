// SPDX-License-Identifier: Apache-2.0
/* Opens an EXR: its header's bytes, the library's context, its end. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/colour.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

/* -- errors of the library ------------------------------------------------ */

static _Thread_local bool full;  // an allocation failed
static _Thread_local int unread; // errno of a read that failed
static _Thread_local bool cut;   // a read came short

void *gp_exr_allocate(size_t size)
{
    void *p;
    full |= gp_alloc(NULL, "EXR", size, 1, &p) != GP_OK;
    return p;
}

int64_t gp_exr_read_bytes(const struct gp_stream *s, void *to, uint64_t n,
                          uint64_t offset)
{
    const int64_t got = gp_stream_read(s, to, n, offset);
    if (got < 0)
        unread = errno;
    cut = cut || got < (int64_t) n;
    return got;
}

void gp_exr_fault_clear(void)
{
    full = false;
    unread = 0;
    cut = false;
}

gp_status gp_exr_fault(void)
{
    return full ? GP_ERR_BUG : unread ? GP_ERR_IO : GP_OK;
}

bool gp_exr_fault_short(void)
{
    return cut;
}

gp_status gp_exr_fault_print(const struct gp_log *log, const char *path,
                             gp_status fault)
{
    if (fault == GP_ERR_BUG)
        return gp_no_memory(log, path);
    errno = unread ? unread : EIO;
    return gp_stream_failed(log, path);
}

/* -- the header's bytes ------------------------------------------------------
 *
 * Lists the attributes of a header with their bytes, which --hdr copies, and
 * bounds their number, before the library parses them: it gives no attribute's
 * bytes, nor their places, in any version.
 *
 * It sorts channels and attributes by a walk from one end (3.1.5 to 3.4): lists
 * of n take it n^2 / 2 comparisons of names. So the squares of the lengths of
 * all channel lists together are bounded, those of attributes, and parts. */

/* Puts ? in the place of what a line cannot show, and returns `text`. */
static char *plain(char *text)
{
    for (char *c = text; *c; c++)
        *c = *c >= ' ' && *c <= '~' ? *c : '?';
    return text;
}

enum {
    NAME = 256,   // bytes of any name with its null, at most
    CHANNEL = 16, // bytes after a channel's name
    LIST_MOST = 8192,
};

/* A walk over the header, which it loads: the first counts the attributes, then
 * one lists them. */
struct walk {
    const struct gp_log *log;
    struct gp_input *in;
    uint64_t loaded; // bytes of index->bytes
    gp_status st;    // of loading them
};

/* Loads the first `end` bytes of the file. False where it has fewer. */
static bool has(struct walk *w, uint64_t end)
{
    enum { FIRST = 4096 }; // most headers
    const struct gp_stream *const s = &w->in->stream;
    struct gp_exr_index *const index = w->in->index;
    void *block = index->bytes;
    if (end > w->loaded && end <= s->size && !w->st) {
        uint64_t room = w->loaded ? 2 * w->loaded : FIRST;
        room = room > end ? room : end;
        room = room < s->size ? room : s->size;
        w->st = gp_resize(w->log, w->in->path, room, &block);
        index->bytes = block;
        const int64_t got = w->st ? 0
                                  : gp_stream_read(s, index->bytes + w->loaded,
                                                   room - w->loaded, w->loaded);
        if (got < 0)
            w->st = gp_stream_failed(w->log, w->in->path);
        w->loaded += got > 0 ? (uint64_t) got : 0;
    }
    return end <= w->loaded;
}

/* Steps over the name at *at, with its null. False where it does not end. */
static bool skip_name(struct walk *w, size_t *at)
{
    for (int n = 0; n < NAME && has(w, *at + 1); n++) {
        if (!w->in->index->bytes[(*at)++])
            return true;
    }
    return false;
}

/* Reads the attribute at *at and steps over it. False where it does not end. */
static bool read_attribute(struct walk *w, size_t *at, struct gp_exr_attr *out)
{
    size_t type = *at, size, value;
    if (!skip_name(w, &type))
        return false;
    size = type;
    if (!skip_name(w, &size) || !has(w, size + sizeof out->size))
        return false;
    value = size + sizeof out->size;
    out->size = gp_le32(w->in->index->bytes + size);
    // after it comes another, or the null that ends them
    if (out->size > INT_MAX || !has(w, value + out->size + 1))
        return false;
    const uint8_t *const bytes = w->in->index->bytes;
    out->name = (const char *) bytes + *at;
    out->type = (const char *) bytes + type;
    out->data = bytes + value;
    *at = value + out->size;
    return true;
}

/* Counts a list's channels, up to LIST_MOST + 1. The library stops at its null:
 * *whole is false where bytes follow, which it would take for an attribute. */
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

/* Fails when a list of n is too long after squares that were `before`. */
static gp_status check_length(const struct walk *walk, uint64_t before,
                              const char *what, uint64_t n)
{
    if (before + n * n <= (uint64_t) LIST_MOST * LIST_MOST)
        return GP_OK;
    return gp_fail(walk->log, GP_ERR_DATA,
                   "%s: the EXR header lists too many %s (%llu or more; at "
                   "most %d, fewer in several parts); spread them over "
                   "several files",
                   walk->in->path, what, (unsigned long long) n, LIST_MOST);
}

/* Walks all parts; sets index->tables where they end. */
static gp_status walk_parts(struct walk *w)
{
    struct gp_exr_index *const index = w->in->index;
    struct gp_exr_attr a;
    uint64_t channels = 0, attributes = 0;
    size_t at = 8;
    gp_status st = GP_OK;
    index->parts = index->attrs = 0;
    while (has(w, at + 1)) {
        const size_t from = at;
        uint64_t n = 0;
        for (; index->bytes[at]; n++) {
            const size_t name = at;
            if (!read_attribute(w, &at, &a))
                return w->st;
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
                               "%s); copy or render the file again",
                               w->in->path, plain((char *) index->bytes + name),
                               a.type);
            if (!index->type && index->flat && strcmp(a.name, "type") == 0)
                index->type = name;
            if (w->in->each)
                index->attr[(uint64_t) index->attrs + n] = a;
        }
        at++;
        if (!index->multi || n == 0) // or the null that ends all parts
            index->tables = at;
        if (index->multi && n == 0)
            break;
        GP_TRY(check_length(w, 0, "parts", (uint64_t) index->parts + 1));
        if (w->in->each)
            w->in->each[index->parts] = (struct gp_exr_part) {
                .from = from,
                .to = at,
                .attr = index->attr + index->attrs,
                .attrs = (int) n,
            };
        attributes += n * n;
        index->attrs += (int) n;
        index->parts++;
        if (!index->multi)
            break;
    }
    st = w->st;
out:
    return st;
}

/* Fills the index. GP_OK also of a damaged header (tables is 0 then): the
 * library's message says more. */
static gp_status index_header(const struct gp_log *log, struct gp_input *in)
{
    struct walk w = {.log = log, .in = in};
    struct gp_exr_index *const out = in->index;
    const uint32_t flags = has(&w, 8) ? gp_le32(out->bytes + 4) : 0;
    gp_status st;
    out->multi = flags & GP_EXR_MULTIPART;
    out->flat = !(flags & (GP_EXR_DEEP | GP_EXR_MULTIPART));
    GP_TRY(walk_parts(&w));
    if (out->parts == 0)
        out->tables = 0;
    if (out->tables) {
        GP_TRY(gp_alloc(log, in->path, (size_t) out->parts, sizeof *in->each,
                        &in->each));
        GP_TRY(gp_alloc(log, in->path, (size_t) out->attrs, sizeof *out->attr,
                        &out->attr));
        GP_TRY(walk_parts(&w));
    }
out:
    return st;
}

const struct gp_exr_attr *gp_exr_attr_find(const struct gp_exr_part *part,
                                           const char *name, const char *type)
{
    for (int i = 0; part && i < part->attrs; i++) {
        const struct gp_exr_attr *a = &part->attr[i];
        if (strcmp(a->name, name) == 0 && strcmp(a->type, type) == 0)
            return a;
    }
    return NULL;
}

/* -- the library's context ------------------------------------------------ */

/* Puts the offset tables, little-endian as in the file and maybe rebuilt, over its bytes from
 * `first` to `end`, which `to` has. */
static void lay_tables(const struct gp_exr_index *index, void *to,
                       uint64_t first, uint64_t end)
{
    const uint64_t last = index->tables + 8 * index->chunks;
    const uint64_t a = first > index->tables ? first : index->tables;
    const uint64_t b = end < last ? end : last;
    if (a < b)
        memcpy((char *) to + (a - first),
               (const char *) index->offset + (a - index->tables), b - a);
}

/* Some files of one part have the "type" attribute of another file: OpenEXR's
 * own readers use the version's flags instead; OpenEXRCore 3.1.5 trusts the
 * attribute, and refuses the header. So it is hidden from it. */
static int64_t read_for_library(exr_const_context_t ctxt, void *user, void *to,
    uint64_t n, uint64_t offset, exr_stream_error_func_ptr_t error)
{
    (void) ctxt;
    (void) error; // the error is kept above
    const struct gp_input *in = user;
    if (!in->exr && in->reason[0]) // it would go on amid a value
        return -1;
    const uint64_t hidden = in->index->type;
    const int64_t got = gp_exr_read_bytes(&in->stream, to, n, offset);
    if (got > 0 && hidden && hidden >= offset &&
        hidden - offset < (uint64_t) got)
        ((char *) to)[hidden - offset] = '-'; // "-ype", a name of no use
    // with the flag of deep parts it would ask flat ones for a version, too
    if (got > 5 - (int64_t) offset && offset < 6 && in->index->multi)
        ((char *) to)[5 - offset] &= ~(GP_EXR_DEEP >> 8);
    if (got > 0 && in->index->offset)
        lay_tables(in->index, to, offset, offset + (uint64_t) got);
    return got;
}

static int64_t query_size(exr_const_context_t ctxt, void *user)
{
    (void) ctxt;
    const struct gp_input *in = user;
    return (int64_t) in->stream.size;
}

/* True for what the library reports and OpenEXR reads all the same: a preview
 * without pixels, a wrong number of chunks, and in a file of one flat part
 * attributes of those names that mean something only in others. */
static bool is_harmless(const struct gp_input *in, const char *message)
{
    static const char *const words[] = {
        "for preview 0 x 0", "Invalid chunk count", // of all files
        "'version'", "Invalid version", "'name'", "'chunkCount'", "'tiles'",
    };
    const size_t n = in->index->flat ? sizeof words / sizeof *words : 2;
    for (size_t i = 0; i < n; i++) {
        if (strstr(message, words[i]))
            return true;
    }
    return false;
}

/* Keeps the first error while the header is parsed, by one thread: the library
 * itself leaves out an attribute that it cannot parse, and goes on. */
static void keep_reason(exr_const_context_t ctxt, exr_result_t code,
                        const char *message)
{
    void *user;
    (void) code;
    if (!ctxt || exr_get_user_data(ctxt, &user))
        return;
    struct gp_input *const in = user;
    if (in->exr || in->reason[0] || is_harmless(in, message))
        return;
    snprintf(in->reason, sizeof in->reason, "%s", message);
    (void) plain(in->reason);
}

/* Describes a part by the library. */
static void describe(const struct gp_input *in, int number,
                     struct gp_exr_part *part)
{
    static const exr_attr_chlist_t none;
    const exr_context_t exr = in->exr;
    exr_storage_t storage;
    exr_tile_level_mode_t mode = EXR_TILE_ONE_LEVEL;
    exr_tile_round_mode_t round;
    uint32_t w = 0, h = 0;
    int32_t n;
    if (exr_get_name(exr, number, &part->name) || (part->name && !*part->name))
        part->name = NULL;
    if (exr_attr_get_string(exr, number, "view", &n, &part->view))
        part->view = NULL;
    if (exr_get_channels(exr, number, &part->channel))
        part->channel = &none;
    const bool unknown = exr_get_storage(exr, number, &storage) ||
                         exr_get_data_window(exr, number, &part->data);
    part->deep = unknown || storage == EXR_STORAGE_DEEP_SCANLINE ||
                 storage == EXR_STORAGE_DEEP_TILED;
    part->tiled = !unknown && (storage == EXR_STORAGE_TILED ||
                               storage == EXR_STORAGE_DEEP_TILED);
    if (part->tiled)
        (void) exr_get_tile_descriptor(exr, number, &w, &h, &mode, &round);
    else if (!exr_get_scanlines_per_chunk(exr, number, &n) && n > 0)
        h = (uint32_t) n;
    part->levels = mode != EXR_TILE_ONE_LEVEL;
    part->tile_w = w < INT_MAX ? (int) w : 0;
    part->tile_h = h < INT_MAX ? (int) h : 0;
    if (!exr_get_chunk_count(exr, number, &n) && n > 0)
        part->chunks = n;
    part->layer = part->name ? part->name : "";
    const size_t all = strlen(part->layer);
    const size_t end = part->view ? strlen(part->view) : 0;
    const bool ends = end > 0 && all >= end + 2 &&
                      strcmp(part->layer + all - end, part->view) == 0 &&
                      strchr("._", part->layer[all - end - 1]);
    part->length = ends ? all - end - 1 : all;
}

/* Parses the header with the library, and finds the offset tables. */
static gp_status parse_header(const struct gp_log *log, struct gp_input *in)
{
    const char *const path = in->path;
    struct gp_exr_index *const index = in->index;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_reason;
    init.user_data = in;
    init.alloc_fn = gp_exr_allocate;
    init.free_fn = gp_free;
    init.read_fn = read_for_library;
    init.size_fn = query_size;
    // offsets outside of the file are an error; the library would guess
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    gp_exr_fault_clear();
    exr_result_t r = exr_start_read(&in->exr, path, &init);
    if (!r)
        r = exr_get_count(in->exr, &in->parts);
    if (gp_exr_fault())
        return gp_exr_fault_print(log, path, gp_exr_fault());
    const char *why = NULL;
    if (r || in->parts < 1 || in->reason[0])
        why = in->reason[0] ? in->reason : exr_get_default_error_message(r);
    else if (!index->tables || index->parts != in->parts)
        why = "its parts do not end";
    if (why)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR header is damaged or truncated (%s); copy "
                       "or render the file again",
                       path, why);
    for (int i = 0; i < in->parts; i++) {
        struct gp_exr_part *const part = &in->each[i];
        describe(in, i, part);
        part->first = index->chunks;
        index->chunks += (uint64_t) part->chunks;
    }
    return GP_OK;
}

/* -- chunks as bytes ------------------------------------------------------ */

/* The leader has, all numbers little-endian: the part in files of several; y,
 * or tile x and y and level x and y; the bytes that follow, in deep parts of
 * count table, samples and unpacked samples. */
uint64_t gp_exr_chunk_bytes(const struct gp_input *in, int part,
                            uint64_t offset)
{
    uint8_t leader[44];
    int32_t number = part;
    uint32_t flat;
    uint64_t size, deep_size[2];
    const bool deep = in->each[part].deep;
    const size_t head =
        (in->index->multi ? 4u : 0u) + (in->each[part].tiled ? 16u : 4u);
    const size_t lead = head + (deep ? 24u : 4u);
    const int64_t got = gp_exr_read_bytes(&in->stream, leader, lead, offset);
    if (got != (int64_t) lead)
        return got < 0 ? 0 : lead;
    if (in->index->multi)
        memcpy(&number, leader, sizeof number);
    memcpy(&flat, leader + head, sizeof flat);
    size = flat;
    if (deep) {
        memcpy(deep_size, leader + head, sizeof deep_size);
        if (__builtin_add_overflow(deep_size[0], deep_size[1], &size))
            return 0;
    }
    // the sum must not wrap around for who adds the offset
    if (number != part || __builtin_add_overflow(size, lead, &size) ||
        size > UINT64_MAX - offset)
        return 0;
    return size;
}

/* Reads the offset tables, and finds in->end, or more where the file is
 * truncated. */
static gp_status read_tables(const struct gp_log *log, struct gp_input *in)
{
    struct gp_exr_index *const index = in->index;
    const uint64_t bytes = index->chunks * sizeof *index->offset;
    const uint64_t tables_end = index->tables + bytes;
    uint64_t last = 0;
    int last_part = 0;
    in->end = tables_end;
    if (tables_end > in->stream.size)
        return GP_OK;
    const gp_status st = gp_alloc(log, in->path, index->chunks,
                                  sizeof *index->offset, &index->offset);
    if (st)
        return st;
    if (gp_exr_read_bytes(&in->stream, index->offset, bytes, index->tables) !=
        (int64_t) bytes)
        return gp_exr_fault_print(log, in->path, GP_ERR_IO);
    bool written = true;
    for (int p = 0; p < in->parts; p++) {
        const struct gp_exr_part *const own = &in->each[p];
        written = written && own->chunks > 0;
        for (int i = 0; i < own->chunks; i++) {
            const uint64_t at = index->offset[own->first + (uint64_t) i];
            written = written && at > 0;
            last_part = at > last ? p : last_part;
            last = at > last ? at : last;
        }
    }
    const uint64_t size = written && last >= tables_end
                              ? gp_exr_chunk_bytes(in, last_part, last)
                              : 0;
    in->end = size ? last + size : 0;
    return GP_OK;
}

/* Returns the place in the tables of the chunk at an offset, by its leader;
 * -1: none, or one of a part with levels. */
static int64_t chunk_place(const struct gp_input *in, uint64_t offset,
                           int *part)
{
    const bool multi = in->index->multi;
    uint8_t leader[20] = {0}; // the last chunk may be shorter
    int32_t number[5];        // part; x, y and levels of a tile, or y
    if (gp_exr_read_bytes(&in->stream, leader, sizeof leader, offset) < 0)
        return -1;
    memcpy(number + !multi, leader, sizeof leader - (multi ? 0 : 4));
    *part = multi ? number[0] : 0;
    if (*part < 0 || *part >= in->parts)
        return -1;
    const struct gp_exr_part *const p = &in->each[*part];
    if (p->levels || p->tile_h < 1 || (p->tiled && p->tile_w < 1))
        return -1;
    int64_t k = ((int64_t) number[1] - p->data.min.y) / p->tile_h;
    if (p->tiled) {
        const int64_t across =
            ((int64_t) p->data.max.x - p->data.min.x) / p->tile_w + 1;
        if (number[1] < 0 || number[1] >= across)
            return -1;
        k = number[2] * across + number[1];
    }
    return k >= 0 && k < p->chunks ? (int64_t) p->first + k : -1;
}

/* Rebuilds the tables of a file whose writer left them out (OpenImageIO 2.4.7's
 * of some lat-long pictures), as OpenEXR's library does, if a walk finds each
 * chunk once and nothing else: else they stay as they are. */
static gp_status rebuild_tables(const struct gp_log *log, struct gp_input *in)
{
    struct gp_exr_index *const index = in->index;
    uint64_t at = index->tables + 8 * index->chunks, found = 0;
    uint64_t *table;
    if (!index->chunks || at > in->stream.size)
        return GP_OK;
    const gp_status st =
        gp_alloc_zero(log, in->path, index->chunks, sizeof *table, &table);
    if (st)
        return st;
    for (; at < in->stream.size; found++) {
        int part;
        const int64_t k = chunk_place(in, at, &part);
        const uint64_t bytes = k < 0 ? 0 : gp_exr_chunk_bytes(in, part, at);
        if (!bytes || table[k])
            break;
        table[k] = at;
        at += bytes;
    }
    if (at != in->stream.size || found != index->chunks) {
        gp_free(table);
        return GP_OK;
    }
    gp_free(index->offset);
    index->offset = table;
    in->end = at;
    gp_say(log, GP_LEVEL_WARN,
           "%s: its offset table is incomplete; the chunks are "
           "all there and were found without it",
           in->path);
    return GP_OK;
}

/* -- opening and closing -------------------------------------------------- */

gp_status gp_exr_open(const struct gp_log *log, const char *path,
                      struct gp_stream *stream, struct gp_input **out)
{
    struct gp_input *in = NULL;
    gp_status st = gp_alloc_zero(log, "input", 1, sizeof *in, &in);
    if (st) {
        gp_stream_close(stream);
        return st;
    }
    in->stream = *stream;
    *stream = (struct gp_stream) GP_STREAM_EMPTY;
    in->path = gp_strdup(path);
    if (!in->path)
        GP_TRY(gp_no_memory(log, path));
    GP_TRY(gp_alloc_zero(log, path, 1, sizeof *in->index, &in->index));
    GP_TRY(index_header(log, in));
    GP_TRY(parse_header(log, in));
    gp_exr_find_crypto(in);
    // also parts and levels that are not read must be whole
    GP_TRY(read_tables(log, in));
    if (in->end == 0)
        GP_TRY(rebuild_tables(log, in));
    if (in->end > in->stream.size)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: truncated (%llu bytes, its chunks need %llu); copy "
                       "or render the file again", path,
                       (unsigned long long) in->stream.size,
                       (unsigned long long) in->end));
    *out = in;
    return GP_OK;
out:
    gp_input_free(in);
    return st;
}

void gp_input_free(void *input)
{
    struct gp_input *in = input;
    if (!in)
        return;
    if (in->exr)
        (void) exr_finish(&in->exr);
    gp_stream_close(&in->stream);
    if (in->index) {
        gp_free(in->index->bytes);
        gp_free(in->index->offset);
        gp_free(in->index->attr);
    }
    gp_free(in->index);
    gp_free(in->each);
    gp_free(in->path);
    gp_free(in);
}

void gp_exr_frame_header(const struct gp_exr_chunks *cs, struct gp_frame *f)
{
    const exr_context_t exr = cs->input->exr;
    exr_attr_box2i_t b;
    exr_attr_chromaticities_t c; // in our order
    f->data = f->display = cs->window;
    if (!exr_get_display_window(exr, cs->part, &b))
        f->display =
            (struct gp_rect) {b.min.x, b.min.y, b.max.x + 1, b.max.y + 1};
    if (exr_get_pixel_aspect_ratio(exr, cs->part, &f->pixel_aspect))
        f->pixel_aspect = 1.0f;
    memcpy(f->chromaticities, gp_rec709_chromaticities,
           sizeof f->chromaticities);
    if (!exr_attr_get_chromaticities(exr, cs->part, "chromaticities", &c)) {
        memcpy(f->chromaticities, &c, sizeof f->chromaticities);
        f->names_chromaticities = true;
    }
    gp_luminance_weights(f->chromaticities, f->luminance);
    f->part = cs->part;
    f->parts = cs->input->parts;
}
