#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/half.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

/* Unpacked bytes of a chunk: either in order, or split by even and odd
 * places with the halves at `bytes` and `odd`. */
struct packed {
    const uint8_t *bytes;
    const uint8_t *odd;  // NULL when in order
};

/* What one thread needs; its pipeline is reused for all its chunks. */
struct worker {
    const struct gp_exr_chunks *layout;
    const struct gp_exr_sink *sink;
    exr_decode_pipeline_t pipe;
    exr_result_t (*library_decompress)(exr_decode_pipeline_t *);
    struct libdeflate_decompressor *inflate;
    uint8_t *split;  // layout->largest bytes
    bool is_split;   // the chunk at hand is in `split`
    bool is_stored;  // ... or lies in the file as it is
    bool ready;
};

struct job {
    const struct gp_exr_chunks *layout;
    struct worker *worker;
};

/* -- one row of one channel ----------------------------------------------- */

static void uints_to_floats(float *v, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t u;
        memcpy(&u, &v[i], sizeof u);
        v[i] = (float) u;
    }
}

static void put_in_order(const uint8_t *from, exr_pixel_type_t type,
                         bool as_float, void *to, size_t n)
{
    if (type == EXR_PIXEL_HALF && as_float)
        gp_half_to_float((const uint16_t *) (const void *) from, to, n);
    else
        memcpy(to, from, n * (type == EXR_PIXEL_HALF ? 2 : 4));
}

static void put_split(const uint8_t *even, const uint8_t *odd,
                      exr_pixel_type_t type, bool as_float, void *to, size_t n)
{
    if (type == EXR_PIXEL_HALF && as_float)
        gp_split_half_to_float(even, odd, to, n);
    else
        gp_interleave(even, odd, to, type == EXR_PIXEL_HALF ? n : 2 * n);
}

/* Samples that lie `at` bytes into the chunk; `at` is even always. */
static void put_row(const struct packed *p, size_t at, exr_pixel_type_t type,
                    bool as_float, void *to, size_t n)
{
    if (p->odd)
        put_split(p->bytes + at / 2, p->odd + at / 2, type, as_float, to, n);
    else
        put_in_order(p->bytes + at, type, as_float, to, n);
    if (type == EXR_PIXEL_UINT && as_float)
        uints_to_floats(to, n);
}

/* -- one chunk ------------------------------------------------------------ */

/* Where channel samples of chunk row `y` of the window begin in the sink. */
static void *sink_row(const struct gp_exr_chunks *l,
                      const struct gp_exr_sink *s,
                      const exr_attr_chlist_entry_t *e, int x, int y)
{
    size_t width = (size_t) (l->w / e->x_sampling);
    size_t index = (size_t) (y / e->y_sampling) * width +
                   (size_t) (x / e->x_sampling);
    bool wide = s->as_float || e->pixel_type != EXR_PIXEL_HALF;
    return (uint8_t *) s->to + index * (wide ? 4 : 2);
}

static void unpack(const struct worker *w, const struct packed *p)
{
    const struct gp_exr_chunks *l = w->layout;
    const exr_chunk_info_t *c = &w->pipe.chunk;
    int x0 = l->tile_w ? c->start_x * l->tile_w : 0;
    int y0 = l->tile_w ? c->start_y * l->tile_h : c->start_y - l->y0;
    size_t at = 0;
    for (int y = y0; y < y0 + c->height; y++) {
        for (int i = 0; i < l->channel->num_channels; i++) {
            const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
            const struct gp_exr_sink *s = &w->sink[i];
            if (y % e->y_sampling)
                continue;
            size_t n = (size_t) (c->width / e->x_sampling);
            if (s->to)
                put_row(p, at, e->pixel_type, s->as_float,
                        sink_row(l, s, e, x0, y), n);
            at += n * (e->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
        }
    }
}

/* Takes the place of the library's zlib and run lengths. What does not
 * decode here is given to the library, so that odd files mean the same. */
static exr_result_t decompress(exr_decode_pipeline_t *pipe)
{
    struct worker *w = pipe->decoding_user_data;
    const exr_chunk_info_t *c = &pipe->chunk;
    size_t in = c->packed_size, out = c->unpacked_size;
    exr_compression_t method = w->layout->compression;
    if (in == out) // stored
        return w->library_decompress(pipe);
    if (method == EXR_COMPRESSION_RLE)
        w->is_split = gp_unrle(pipe->packed_buffer, in, w->split, out);
    else
        w->is_split = libdeflate_zlib_decompress(w->inflate,
                                                 pipe->packed_buffer, in,
                                                 w->split, out, NULL) ==
                      LIBDEFLATE_SUCCESS;
    if (!w->is_split)
        return w->library_decompress(pipe);
    gp_undo_delta(w->split, out);
    return EXR_ERR_SUCCESS;
}

/* B44 blocks that would have grown are stored as they are (tiny windows).
 * OpenEXR's C++ library writes and reads such chunks; OpenEXRCore 3.1.5 takes
 * them for compressed ones. */
static exr_result_t decompress_b44(exr_decode_pipeline_t *pipe)
{
    struct worker *w = pipe->decoding_user_data;
    w->is_stored = pipe->chunk.packed_size == pipe->chunk.unpacked_size;
    return w->is_stored ? EXR_ERR_SUCCESS : w->library_decompress(pipe);
}

static exr_result_t unpack_chunk(exr_decode_pipeline_t *pipe)
{
    const struct worker *w = pipe->decoding_user_data;
    struct packed p = {.bytes = pipe->unpacked_buffer};
    if (w->is_split) {
        p.bytes = w->split;
        p.odd = w->split + (pipe->chunk.unpacked_size + 1) / 2;
    }
    if (w->is_stored)
        p.bytes = pipe->packed_buffer;
    if (!p.bytes)
        return EXR_ERR_CORRUPT_CHUNK;
    unpack(w, &p);
    return EXR_ERR_SUCCESS;
}

static exr_result_t run_chunk(struct worker *w, int index)
{
    const struct gp_exr_chunks *l = w->layout;
    const exr_context_t exr = l->input->exr;
    w->is_split = false;
    w->is_stored = false;
    if (l->chunk[index].unpacked_size == 0) // lines that no channel samples
        return EXR_ERR_SUCCESS;
    exr_result_t r =
        exr_decoding_update(exr, l->part, &l->chunk[index], &w->pipe);
    return r ? r : exr_decoding_run(exr, l->part, &w->pipe);
}

/* -- all chunks ----------------------------------------------------------- */

static void close_worker(struct worker *w)
{
    if (w->ready)
        (void) exr_decoding_destroy(w->layout->input->exr, &w->pipe);
    if (w->inflate)
        libdeflate_free_decompressor(w->inflate);
    GP_FREE(w->split);
    *w = (struct worker) {0};
}

static bool is_zip(exr_compression_t c)
{
    return c == EXR_COMPRESSION_ZIP || c == EXR_COMPRESSION_ZIPS;
}

/* The library chooses its routines on first use without a lock; frames may be
 * read by several threads at once. */
static exr_result_t choose_routines(const struct gp_exr_chunks *l,
                                    exr_decode_pipeline_t *pipe)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    pthread_mutex_lock(&lock);
    const exr_result_t r =
        exr_decoding_choose_default_routines(l->input->exr, l->part, pipe);
    pthread_mutex_unlock(&lock);
    return r;
}

static gp_status open_worker(const struct gp_log *log,
                             const struct gp_exr_chunks *l,
                             const struct gp_exr_sink *sink, struct worker *w)
{
    const exr_context_t exr = l->input->exr;
    *w = (struct worker) {.layout = l, .sink = sink};
    gp_exr_fault_clear();
    exr_result_t r =
        exr_decoding_initialize(exr, l->part, &l->chunk[0], &w->pipe);
    w->ready = true;
    if (!r)
        r = choose_routines(l, &w->pipe);
    const gp_status fault = gp_exr_fault();
    if (fault)
        return gp_exr_fault_print(log, l->path, fault);
    if (r)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR library cannot decode it (%s); write the "
                       "file with another compression", l->path,
                       exr_get_default_error_message(r));
    w->pipe.decoding_user_data = w;
    w->pipe.unpack_and_convert_fn = unpack_chunk;
    w->library_decompress = w->pipe.decompress_fn;
    if (l->compression == EXR_COMPRESSION_B44 ||
        l->compression == EXR_COMPRESSION_B44A)
        w->pipe.decompress_fn = decompress_b44;
    if (!is_zip(l->compression) && l->compression != EXR_COMPRESSION_RLE)
        return GP_OK;
    w->pipe.decompress_fn = decompress;
    w->inflate = libdeflate_alloc_decompressor();
    void *split;
    gp_status st = gp_alloc(log, "chunk", l->largest, 1, &split);
    w->split = split;
    if (!st && !w->inflate)
        st = gp_fail(log, GP_ERR_BUG, "%s: out of memory; close other "
                     "programs", l->path);
    return st;
}

static gp_status decode_body(void *ctx, int index, int thread)
{
    const struct job *job = ctx;
    gp_exr_fault_clear();
    const exr_result_t r = run_chunk(&job->worker[thread], index);
    const gp_status fault = gp_exr_fault();
    return fault ? fault : r || gp_exr_fault_short() ? GP_ERR_DATA : GP_OK;
}

/* -- DWAA and DWAB --------------------------------------------------------- */

static int image_channel(const struct gp_oiio_image *image, const char *name)
{
    for (int i = 0; i < image->channels; i++) {
        if (strcmp(image->channel_name[i], name) == 0)
            return i;
    }
    return -1;
}

/* Row `y` of one channel, `row` being w floats of scratch. */
static void put_bridge_row(const struct gp_exr_chunks *l,
                    const struct gp_oiio_image *image, int from,
                    exr_pixel_type_t type, const struct gp_exr_sink *s, int y,
                    float *row)
{
    const size_t w = (size_t) l->w, at = (size_t) y * w;
    const size_t step = (size_t) image->channels;
    const float *p = image->pixels + at * step + (size_t) from;
    for (size_t x = 0; x < w; x++) {
        uint32_t u;
        row[x] = p[x * step];
        if (type == EXR_PIXEL_UINT && s->as_float) {
            memcpy(&u, &row[x], sizeof u);
            row[x] = (float) u;
        }
    }
    if (type == EXR_PIXEL_HALF && !s->as_float)
        (void) gp_float_to_half(row, (uint16_t *) s->to + at, w);
    else
        memcpy((float *) s->to + at, row, w * sizeof *row);
}

static gp_status put_channels(const struct gp_log *log,
                              const struct gp_exr_chunks *l,
                              const struct gp_oiio_image *image,
                              const struct gp_exr_sink *sink)
{
    void *row;
    gp_status st = gp_alloc(log, "row", (size_t) l->w, sizeof(float), &row);
    for (int i = 0; !st && i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
        int from = image_channel(image, e->name.str);
        if (!sink[i].to)
            continue;
        if (from < 0)
            st = gp_fail(log, GP_ERR_DATA,
                         "%s: OpenImageIO did not find channel %s; write the "
                         "file with zip compression", l->path, e->name.str);
        for (int y = 0; !st && y < l->h; y++)
            put_bridge_row(l, image, from, e->pixel_type, &sink[i], y, row);
    }
    gp_free(row);
    return st;
}

static gp_status decode_by_bridge(const struct gp_log *log,
                                  const struct gp_exr_chunks *l,
                                  const struct gp_exr_sink *sink)
{
    const struct gp_stream *s = &l->input->stream;
    struct gp_oiio_image image;
    char why[512];
    for (int i = 0; i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: channel %s is subsampled and DWA compressed, "
                           "which nothing here decodes; write the file with "
                           "another compression", l->path, e->name.str);
    }
    const struct gp_oiio_api *api = gp_oiio_open(why, sizeof why);
    if (!api)
        return gp_fail(log, GP_ERR_IO,
                       "%s: DWA compression needs the OpenImageIO bridge "
                       "(%s); install it, or write the file with zip",
                       l->path, why);
    const int got = api->read(l->path, s->data, s->size, l->part,
                              (long long) l->w * l->h, &image, why,
                              sizeof why);
    if (got == GP_OIIO_MEMORY)
        return gp_oiio_no_memory(log, l->path, why);
    if (got)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the pixels are damaged (%s); copy or render the "
                       "file again", l->path, why);
    gp_status st;
    if (image.w == l->w && image.h == l->h)
        st = put_channels(log, l, &image, sink);
    else
        st = gp_fail(log, GP_ERR_DATA,
                     "%s: OpenImageIO found %d x %d pixels (%d x %d in the "
                     "header); render the file again", l->path, image.w,
                     image.h, l->w, l->h);
    api->image_free(&image);
    return st;
}

/* -- in parallel ----------------------------------------------------------- */

/* zlib takes its memory behind the library's back, and the library says the
 * same of a full one and of blocks that end early. */
static bool is_memory_full(const struct gp_exr_chunks *l)
{
    enum { ZLIB_BYTES = 1 << 16 };
    void *p;
    const bool full = gp_alloc(NULL, l->path, ZLIB_BYTES, 1, &p);
    gp_free(p);
    return full;
}

/* Decodes the chunk that failed once more to learn why; it fails again when
 * the file is to blame. DWA is left to the bridge: OpenEXRCore 3.1.5 lacks
 * it. */
static gp_status explain(const struct gp_log *log, const struct job *job,
                         int index, gp_status st)
{
    const struct gp_exr_chunks *l = job->layout;
    const exr_chunk_info_t *c = &l->chunk[index];
    if (st != GP_ERR_DATA)
        return gp_exr_fault_print(log, l->path, st);
    gp_exr_fault_clear();
    exr_result_t r = run_chunk(&job->worker[0], index);
    if (gp_exr_fault())
        return gp_exr_fault_print(log, l->path, gp_exr_fault());
    const bool cut = gp_exr_fault_short();
    if (r == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
        return decode_by_bridge(log, l, job->worker[0].sink);
    if ((!r && !cut) || (r == EXR_ERR_OUT_OF_MEMORY && is_memory_full(l)))
        return gp_exr_fault_print(log, l->path, GP_ERR_BUG);
    char place[64];
    if (l->tile_w)
        snprintf(place, sizeof place, "tile %d,%d", c->start_x, c->start_y);
    else
        snprintf(place, sizeof place, "line %d", c->start_y);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the pixels are damaged at %s (%s); copy or render the "
                   "file again", l->path, place,
                   // which the library also says of blocks that end early
                   r == EXR_ERR_OUT_OF_MEMORY
                       ? "a block does not fit its pixels"
                   : cut ? "the file ends before them"
                       : exr_get_default_error_message(r));
}

gp_status gp_exr_decode(const struct gp_log *log,
                        const struct gp_exr_chunks *l,
                        const struct gp_exr_sink *sink)
{
    int team = gp_threads() < l->chunks ? gp_threads() : l->chunks, failed;
    void *list;
    gp_status st = gp_alloc_zero(log, "decoders", (size_t) team,
                                 sizeof(struct worker), &list);
    if (st)
        return st;
    struct job job = {.layout = l, .worker = list};
    for (int i = 0; i < team; i++)
        GP_TRY(open_worker(log, l, sink, &job.worker[i]));
    st = gp_parallel(l->chunks, decode_body, &job, &failed);
    if (st)
        st = explain(log, &job, failed, st);
out:
    for (int i = 0; i < team; i++)
        close_worker(&job.worker[i]);
    gp_free(list);
    return st;
}
