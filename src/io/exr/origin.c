#include "io/exr/exr_priv.h"

#include "core/memory.h"

#include <stdio.h>
#include <string.h>

static int64_t read_bytes(exr_const_context_t ctxt, void *user, void *to,
                          uint64_t n, uint64_t offset,
                          exr_stream_error_func_ptr_t error)
{
    (void) ctxt;
    (void) error; // what went wrong is kept there
    const struct gp_input *o = user;
    const int64_t got = gp_exr_read_bytes(&o->stream, to, n, offset);
    if (got > 0 && o->hidden && o->hidden >= offset &&
        o->hidden - offset < (uint64_t) got)
        ((char *) to)[o->hidden - offset] = '-'; // "-ype", a name of no use
    return got;
}

static int64_t query_size(exr_const_context_t ctxt, void *user)
{
    (void) ctxt;
    const struct gp_input *o = user;
    return (int64_t) o->stream.size;
}

/* Only while the header is parsed, by one thread: */
static void keep_reason(exr_const_context_t ctxt, exr_result_t code,
                        const char *message)
{
    (void) code;
    void *user;
    if (!ctxt || exr_get_user_data(ctxt, &user))
        return;
    struct gp_input *o = user;
    if (!o->exr)
        snprintf(o->reason, sizeof o->reason, "%s", message);
}

static gp_status new_origin(const struct gp_log *log, struct gp_input **out)
{
    void *p;
    gp_status st = gp_alloc_zero(log, "input", 1, sizeof **out, &p);
    if (st)
        return st;
    *out = p;
    (*out)->stream = (struct gp_stream) GP_STREAM_EMPTY;
    return GP_OK;
}

/* The header as the library parses it. */
static gp_status parse(const struct gp_log *log, const char *path,
                       struct gp_input *o)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    init.error_handler_fn = keep_reason;
    init.user_data = o;
    init.alloc_fn = gp_exr_allocate;
    init.read_fn = read_bytes;
    init.size_fn = query_size;
    // a table that points outside the file means lost pixels: say so instead
    // of guessing where they are
    init.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    gp_exr_fault_clear();
    exr_result_t r = exr_start_read(&o->exr, path, &init);
    if (!r)
        r = exr_get_count(o->exr, &o->parts);
    const gp_status fault = gp_exr_fault();
    if (fault)
        return gp_exr_fault_print(log, path, fault);
    if (r || o->parts < 1)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR header is damaged or cut off (%s); copy "
                       "or render the file again", path,
                       o->reason[0] ? o->reason
                                    : exr_get_default_error_message(r));
    return GP_OK;
}

/* What the library would not see, or take too long with. Some files of one
 * part carry the "type" of another file along: OpenEXR's own readers go by the
 * flags of the version there; OpenEXRCore 3.1.5 believes the attribute, and
 * finds the header damaged. */
static gp_status scan(const struct gp_log *log, const char *path,
                      struct gp_input *o)
{
    const struct gp_exr_scan found = gp_exr_scan_header(&o->stream);
    o->hidden = found.type;
    o->tables = found.tables;
    o->multi = found.multi;
    if (found.damaged)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the attribute %s is damaged (its %llu bytes are "
                       "no %s); copy or render the file again", path,
                       found.name, (unsigned long long) found.count,
                       found.kind);
    if (!found.too_long)
        return GP_OK;
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the EXR header lists too many %s (%llu or more; at "
                   "most %d, fewer in several parts); spread them over "
                   "several files", path, found.too_long,
                   (unsigned long long) found.count, GP_EXR_LIST_MOST);
}

/* Parts and levels that nobody reads are there as well. */
static gp_status check_end(const struct gp_log *log, const char *path,
                           struct gp_input *o)
{
    const uint64_t end = gp_exr_end(o), size = o->stream.size;
    o->end = end;
    return end <= size
               ? GP_OK
               : gp_fail(log, GP_ERR_DATA,
                         "%s: cut off or damaged (its chunks end at byte %llu "
                         "of %llu); copy or render the file again", path,
                         (unsigned long long) end, (unsigned long long) size);
}

gp_status gp_exr_open(const struct gp_log *log, const char *path,
                             struct gp_stream *stream, struct gp_input **out)
{
    struct gp_input *o;
    gp_status st = new_origin(log, &o);
    if (st) {
        gp_stream_close(stream);
        return st;
    }
    o->stream = *stream;
    *stream = (struct gp_stream) GP_STREAM_EMPTY;
    st = scan(log, path, o);
    if (!st)
        st = parse(log, path, o);
    if (!st)
        st = check_end(log, path, o);
    if (st)
        gp_input_free(o);
    else
        *out = o;
    return st;
}

enum gp_pixel_type gp_exr_pixel_type(exr_pixel_type_t type)
{
    return type == EXR_PIXEL_HALF ? GP_HALF
           : type == EXR_PIXEL_UINT ? GP_UINT : GP_FLOAT;
}

/* How many tiles cover so many pixels. */
static int64_t tiles_of(int32_t pixels, uint32_t tile)
{
    return ((int64_t) pixels + tile - 1) / tile;
}

static exr_result_t tile_chunk(const struct gp_input *o, int part, int index,
                               exr_chunk_info_t *info)
{
    int32_t nx, ny;
    uint32_t tw, th;
    exr_tile_level_mode_t mode;
    exr_tile_round_mode_t round;
    exr_result_t r = exr_get_tile_levels(o->exr, part, &nx, &ny);
    if (!r)
        r = exr_get_tile_descriptor(o->exr, part, &tw, &th, &mode, &round);
    if (!r && (tw < 1 || th < 1))
        r = EXR_ERR_INVALID_ATTR;
    if (r)
        return r;
    int64_t left = index;
    for (int ly = 0; ly < ny; ly++) {
        bool rip = mode == EXR_TILE_RIPMAP_LEVELS;
        for (int lx = rip ? 0 : ly; lx < (rip ? nx : ly + 1); lx++) {
            int32_t w, h;
            r = exr_get_level_sizes(o->exr, part, lx, ly, &w, &h);
            if (r)
                return r;
            const int64_t across = tiles_of(w, tw);
            const int64_t tiles = across * tiles_of(h, th);
            if (left < tiles)
                return exr_read_tile_chunk_info(
                    o->exr, part, (int) (left % across), (int) (left / across),
                    lx, ly, info);
            left -= tiles;
        }
    }
    return EXR_ERR_ARGUMENT_OUT_OF_RANGE;
}

exr_result_t gp_input_chunk(const struct gp_input *o, int part, int index,
                             exr_chunk_info_t *info)
{
    exr_storage_t storage;
    exr_attr_box2i_t data;
    int32_t lines;
    exr_result_t r = exr_get_storage(o->exr, part, &storage);
    if (r)
        return r;
    if (storage == EXR_STORAGE_TILED || storage == EXR_STORAGE_DEEP_TILED)
        return tile_chunk(o, part, index, info);
    r = exr_get_data_window(o->exr, part, &data);
    if (!r)
        r = exr_get_scanlines_per_chunk(o->exr, part, &lines);
    if (r)
        return r;
    int64_t y = (int64_t) data.min.y + (int64_t) index * lines;
    if (lines < 1 || index < 0 || y > data.max.y)
        return EXR_ERR_ARGUMENT_OUT_OF_RANGE;
    return exr_read_scanline_chunk_info(o->exr, part, (int) y, info);
}

void gp_input_free(void *input)
{
    struct gp_input *o = input;
    if (!o)
        return;
    if (o->exr)
        (void) exr_finish(&o->exr);
    gp_stream_close(&o->stream);
    gp_free(o);
}
