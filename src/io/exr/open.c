/* Opens an EXR: its bytes, the library's context, its end. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- errors of the library ------------------------------------------------ */

static _Thread_local bool full;  // an allocation failed
static _Thread_local int unread; // errno of a read that failed
static _Thread_local bool cut;   // a read came short

void *gp_exr_allocate(size_t size)
{
    void *const p = malloc(size);
    full = full || !p;
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
    return gp_fail(log, fault, "%s: cannot read (%s); check the disk", path,
                   strerror(unread ? unread : EIO));
}

/* -- the library's context ------------------------------------------------ */

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

char *gp_exr_plain(char *text)
{
    for (char *c = text; *c; c++)
        *c = *c >= ' ' && *c <= '~' ? *c : '?';
    return text;
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
    (void) gp_exr_plain(in->reason);
}

/* Parses the header with the library, and finds the offset tables. */
static gp_status parse_header(const struct gp_log *log, const char *path,
                              struct gp_input *in)
{
    struct gp_exr_index *const index = in->index;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_reason;
    init.user_data = in;
    init.alloc_fn = gp_exr_allocate;
    init.free_fn = free;
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
                       "or render the file again", path, why);
    uint64_t at = index->tables;
    for (int i = 0; i < in->parts; i++) {
        struct gp_exr_index_part *const part = &index->part[i];
        int32_t chunks;
        part->table = at;
        if (!exr_get_chunk_count(in->exr, i, &chunks) && chunks > 0)
            part->chunks = chunks;
        at += (uint64_t) part->chunks * sizeof(uint64_t);
    }
    return GP_OK;
}

/* -- chunks as bytes ------------------------------------------------------ */

bool gp_exr_offsets_read(const struct gp_input *in, int part, int first, int n,
                         uint64_t *offset)
{
    const uint64_t bytes = (uint64_t) n * sizeof *offset;
    const uint64_t at = in->index->part[part].table +
                        (uint64_t) first * sizeof *offset;
    return gp_exr_read_bytes(&in->stream, offset, bytes, at) ==
           (int64_t) bytes;
}

/* The leader has, all numbers little-endian: the part in files of several; y,
 * or tile x and y and level x and y; the bytes that follow, in deep parts of
 * count table, samples and unpacked samples. */
uint64_t gp_exr_chunk_bytes(const struct gp_input *in, int part,
                            uint64_t offset)
{
    exr_storage_t storage;
    uint8_t leader[44];
    int32_t number = part;
    uint32_t flat;
    uint64_t size, deep_size[2];
    if (exr_get_storage(in->exr, part, &storage))
        return 0;
    const bool deep = gp_exr_is_deep(in, part);
    const bool tiled = storage == EXR_STORAGE_TILED ||
                       storage == EXR_STORAGE_DEEP_TILED;
    const size_t head = (in->index->multi ? 4u : 0u) + (tiled ? 16u : 4u);
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

/* gp_input.end, or more where the file is truncated. */
static uint64_t find_end(const struct gp_input *in)
{
    enum { BLOCK = 512 };
    uint64_t offset[BLOCK], last = 0, tables = 0;
    int last_part = 0;
    for (int p = 0; p < in->parts; p++) {
        const struct gp_exr_index_part *const part = &in->index->part[p];
        if (part->chunks < 1)
            return 0;
        tables = part->table + (uint64_t) part->chunks * sizeof *offset;
        if (tables > in->stream.size)
            return tables;
        for (int i = 0; i < part->chunks; i += BLOCK) {
            const int n = part->chunks - i < BLOCK ? part->chunks - i : BLOCK;
            if (!gp_exr_offsets_read(in, p, i, n, offset))
                return 0;
            for (int k = 0; k < n; k++) {
                if (offset[k] == 0) // never written
                    return 0;
                if (offset[k] > last) {
                    last = offset[k];
                    last_part = p;
                }
            }
        }
    }
    const uint64_t bytes =
        last >= tables ? gp_exr_chunk_bytes(in, last_part, last) : 0;
    return bytes ? last + bytes : 0;
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
    GP_TRY(gp_alloc_zero(log, path, 1, sizeof *in->index, &in->index));
    GP_TRY(gp_exr_index_make(log, path, &in->stream, in->index));
    GP_TRY(parse_header(log, path, in));
    // also parts and levels that are not read must be whole
    in->end = find_end(in);
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
    if (in->index)
        gp_exr_index_free(in->index);
    gp_free(in->index);
    gp_free(in);
}

const struct gp_exr_attr *
gp_exr_attr_find(const struct gp_exr_index_part *part, const char *name,
                 const char *type)
{
    for (int i = 0; part && i < part->attrs; i++) {
        const struct gp_exr_attr *a = &part->attr[i];
        if (strcmp(a->name, name) == 0 && strcmp(a->type, type) == 0)
            return a;
    }
    return NULL;
}
