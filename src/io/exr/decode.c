/* Decodes the chunks of one part of an EXR in parallel, straight into planes.
 *
 * OpenEXRCore finds, reads and expands them. Here is what 3.1.5 lacks:
 * libdeflate for ZIP, in half of zlib's time (3.2 has it), stored chunks of B44,
 * subsampled blocks (unpacked_bytes()), and DWA (right from 3.1.13 on, see its
 * issue 1682). Its unpacking turns halves to floats one by one where a part has
 * other channels too, in all versions. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "core/half.h"
#include "io/decoded.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <limits.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>

/* -- the list of chunks --------------------------------------------------- */

/* Unpacked bytes of a chunk, and whether the library divides its rows and
 * columns as the channels' sampling asks. 3.1.5 does not where a block of
 * lines is no multiple of the sampling. */
static bool unpacked_bytes(const struct gp_exr_chunks *cs,
                           const exr_chunk_info_t *c, uint64_t *bytes)
{
    *bytes = 0;
    for (int i = 0; i < cs->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
        int xs = e->x_sampling, ys = e->y_sampling;
        // if the first block's height divides, so does the start of the others
        if (c->width % xs || (c->height > 1 && c->height % ys))
            return false;
        bool none = c->height == 1 && (c->start_y - cs->y0) % ys;
        uint64_t rows = none ? 0 : (uint64_t) (c->height + ys - 1) /
                                       (uint64_t) ys;
        *bytes += rows * (uint64_t) (c->width / xs) *
                  (e->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
    }
    return true;
}

/* Asks the library for all chunks. It checks that each is in the file and where
 * its number says; not that so few bytes can become so many pixels, for which
 * memory is taken. */
static gp_status read_chunks(const struct gp_log *log, struct gp_exr_chunks *cs)
{
    // DEFLATE: a code of 2 bits can stand for 258 bytes; PXR24 makes 4 of each 3
    // bytes, DWA a block of 128 of one code of 2. The 64 are for headers and for
    // the last, unfinished unit
    const bool dwa = cs->compression > EXR_COMPRESSION_B44A;
    const bool stored = cs->compression == EXR_COMPRESSION_NONE;
    const uint64_t most = dwa ? 64 * 1032 : 1376;
    const exr_context_t exr = cs->input->exr;
    const bool deep = gp_exr_is_deep(cs->input, cs->part);
    const int across = (cs->w - 1) / cs->tile_w + 1;
    gp_exr_fault_clear();
    for (int i = 0; i < cs->chunks; i++) {
        exr_chunk_info_t *c = &cs->chunk[i];
        const exr_result_t r =
            cs->tiled ? exr_read_tile_chunk_info(exr, cs->part, i % across,
                                                 i / across, 0, 0, c)
                      : exr_read_scanline_chunk_info(exr, cs->part,
                                                     cs->y0 + i * cs->tile_h, c);
        const char *wrong = r ? exr_get_default_error_message(r) : NULL;
        uint64_t bytes = 0;
        if (!wrong && !deep && (!unpacked_bytes(cs, c, &bytes) ||
                                bytes != c->unpacked_size))
            return gp_fail(log, GP_ERR_DATA,
                           "%s: a chunk is no whole number of the channels' "
                           "subsampling steps (chunk %d); write the file "
                           "without subsampling", cs->path, i + 1);
        if (!wrong && !deep && stored && c->packed_size != bytes)
            wrong = "its size is wrong";
        else if (!wrong && bytes > (c->packed_size + 64) * most)
            wrong = "it is too small for its pixels";
        if (wrong && gp_exr_fault())
            return gp_exr_fault_print(log, cs->path, gp_exr_fault());
        if (wrong)
            return gp_fail(log, GP_ERR_DATA,
                "%s: truncated or damaged (chunk %d of %d: %s); copy "
                "or render the file again", cs->path, i + 1, cs->chunks, wrong);
        if (bytes > cs->largest)
            cs->largest = bytes;
    }
    return GP_OK;
}

gp_status gp_exr_chunks_any(const struct gp_log *log, const char *path,
                            const struct gp_input *in, int part,
                            long long max_pixels, struct gp_exr_chunks *out)
{
    const exr_context_t exr = in->exr;
    exr_storage_t storage;
    gp_status st;
    exr_attr_box2i_t d;
    *out = (struct gp_exr_chunks) {.input = in, .path = path, .part = part};
    if (exr_get_storage(exr, part, &storage) ||
        exr_get_compression(exr, part, &out->compression) ||
        exr_get_channels(exr, part, &out->channel) ||
        exr_get_data_window(exr, part, &d))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR header is damaged (part %d lacks window, "
                       "channels, compression or type); render the file again",
                       path, part);
    const int64_t w = (int64_t) d.max.x - d.min.x + 1;
    const int64_t h = (int64_t) d.max.y - d.min.y + 1;
    GP_TRY(gp_window_check(log, path, "data", w, h, max_pixels));
    out->x0 = d.min.x;
    out->y0 = d.min.y;
    out->w = out->tile_w = (int) w;
    out->h = (int) h;

    // the number of chunks of level 0, which come first in the table; each has
    // 8 bytes there, so the file bounds the list
    const uint64_t size = in->stream.size;
    const int all = in->index->part[part].chunks;
    uint32_t tw, th;
    int64_t n = 0;
    exr_tile_level_mode_t mode;
    exr_tile_round_mode_t round;
    out->tiled = storage == EXR_STORAGE_TILED ||
                 storage == EXR_STORAGE_DEEP_TILED;
    if (!out->tiled) {
        if (exr_get_scanlines_per_chunk(exr, part, &out->tile_h))
            out->tile_h = 0;
    } else if (!exr_get_tile_descriptor(exr, part, &tw, &th, &mode, &round) &&
               tw < INT_MAX && th < INT_MAX) {
        out->tile_w = (int) tw;
        out->tile_h = (int) th;
    }
    if (out->tile_w > 0 && out->tile_h > 0)
        n = ((w - 1) / out->tile_w + 1) * ((h - 1) / out->tile_h + 1);
    if (n < 1 || n > all || (uint64_t) n > size / 8)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: truncated or damaged (%d chunks in a file of %llu "
                       "bytes, %lld needed); copy or render the file again",
                       path, all, (unsigned long long) size, (long long) n);
    out->chunks = (int) n;
    GP_TRY(gp_alloc_zero(log, "chunks", (size_t) n, sizeof *out->chunk,
                         &out->chunk));
    GP_TRY(read_chunks(log, out));
out:
    return st;
}

gp_status gp_exr_chunks_find(const struct gp_log *log, const char *path,
                             const struct gp_input *in, int part,
                             long long max_pixels, struct gp_exr_chunks *out)
{
    exr_storage_t storage; // where there is none, the part is not known as deep
    *out = (struct gp_exr_chunks) {.input = in};
    if (!exr_get_storage(in->exr, part, &storage) && gp_exr_is_deep(in, part))
        return gp_fail(log, GP_ERR_DATA,
            "%s: deep data has no single colour per pixel (part "
            "%d); flatten it first, with e.g. oiiotool --flatten", path, part);
    return gp_exr_chunks_any(log, path, in, part, max_pixels, out);
}

void gp_exr_chunks_free(struct gp_exr_chunks *chunks)
{
    gp_free(chunks->chunk);
    *chunks = (struct gp_exr_chunks) {0};
}

/* -- one chunk ------------------------------------------------------------ */

/* State of one thread; its pipeline is reused for all its chunks. */
struct worker {
    const struct gp_exr_chunks *chunks;
    const struct gp_exr_sink *sink;
    exr_decode_pipeline_t pipe;
    exr_result_t (*library_decompress)(exr_decode_pipeline_t *);
    struct libdeflate_decompressor *inflate; // of ZIP and RLE
    uint8_t *scratch; // chunks->largest bytes, of ZIP and RLE
    bool ready;
};

/* The samples of a chunk to the sinks; for unpack_and_convert_fn. */
static exr_result_t unpack_chunk(exr_decode_pipeline_t *pipe)
{
    const struct worker *w = pipe->decoding_user_data;
    const struct gp_exr_chunks *cs = w->chunks;
    const exr_chunk_info_t *c = &pipe->chunk;
    const int x0 = cs->tiled ? c->start_x * cs->tile_w : 0;
    const int y0 = cs->tiled ? c->start_y * cs->tile_h : c->start_y - cs->y0;
    const uint8_t *from = pipe->unpacked_buffer;
    if (!from)
        return EXR_ERR_CORRUPT_CHUNK;
    for (int y = y0; y < y0 + c->height; y++) {
        for (int i = 0; i < cs->channel->num_channels; i++) {
            const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
            const struct gp_exr_sink *s = &w->sink[i];
            if (y % e->y_sampling)
                continue;
            const bool half = e->pixel_type == EXR_PIXEL_HALF;
            const size_t n = (size_t) (c->width / e->x_sampling);
            const size_t width = (size_t) (cs->w / e->x_sampling);
            const size_t index = (size_t) (y / e->y_sampling) * width +
                                 (size_t) (x0 / e->x_sampling);
            const size_t size = half ? 2 : 4;
            const void *const row = from;
            from += n * size;
            if (!s->to)
                continue;
            void *const to =
                (uint8_t *) s->to + index * (s->as_float ? 4 : size);
            if (half && s->as_float)
                gp_half_to_float(row, to, n);
            else
                memcpy(to, row, n * size);
            const bool number = e->pixel_type == EXR_PIXEL_UINT && s->as_float;
            for (size_t k = 0; number && k < n; k++)
                ((float *) to)[k] = (float) ((const uint32_t *) row)[k];
        }
    }
    return EXR_ERR_SUCCESS;
}

/* Replaces the library's zlib and run lengths. Leaves what does not decode here
 * to the library, so that odd files give the same. Chunks that B44 would have
 * made larger are stored (tiny windows): OpenEXR's C++ library writes and reads
 * such chunks; OpenEXRCore 3.1.5 decodes them as compressed ones. */
static exr_result_t decompress(exr_decode_pipeline_t *pipe)
{
    const struct worker *w = pipe->decoding_user_data;
    const exr_compression_t how = w->chunks->compression;
    const size_t in = pipe->chunk.packed_size, out = pipe->chunk.unpacked_size;
    if (in == out && how >= EXR_COMPRESSION_B44) // both are one buffer
        return EXR_ERR_SUCCESS;
    if (in != out && w->inflate &&
        gp_exr_unzip(w->inflate, how == EXR_COMPRESSION_RLE,
                     pipe->packed_buffer, in, w->scratch, pipe->unpacked_buffer,
                     out))
        return EXR_ERR_SUCCESS;
    return w->library_decompress(pipe);
}

static exr_result_t run_chunk(struct worker *w, int index)
{
    const struct gp_exr_chunks *cs = w->chunks;
    const exr_context_t exr = cs->input->exr;
    if (cs->chunk[index].unpacked_size == 0) // lines that no channel samples
        return EXR_ERR_SUCCESS;
    exr_result_t r =
        exr_decoding_update(exr, cs->part, &cs->chunk[index], &w->pipe);
    return r ? r : exr_decoding_run(exr, cs->part, &w->pipe);
}

static gp_status open_worker(const struct gp_log *log,
                             const struct gp_exr_chunks *cs,
                             const struct gp_exr_sink *sink, struct worker *w)
{
    // the library chooses its routines on first use without a lock, and
    // frames may be read by several threads at once
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    const exr_context_t exr = cs->input->exr;
    *w = (struct worker) {.chunks = cs, .sink = sink, .ready = true};
    gp_exr_fault_clear();
    exr_result_t r =
        exr_decoding_initialize(exr, cs->part, &cs->chunk[0], &w->pipe);
    if (!r) {
        pthread_mutex_lock(&lock);
        r = exr_decoding_choose_default_routines(exr, cs->part, &w->pipe);
        pthread_mutex_unlock(&lock);
    }
    if (gp_exr_fault())
        return gp_exr_fault_print(log, cs->path, gp_exr_fault());
    if (r)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR library cannot decode it (%s); write the "
                       "file with another compression", cs->path,
                       exr_get_default_error_message(r));
    w->pipe.decoding_user_data = w;
    w->pipe.unpack_and_convert_fn = unpack_chunk;
    w->library_decompress = w->pipe.decompress_fn;
    if (cs->compression == EXR_COMPRESSION_NONE)
        return GP_OK;
    w->pipe.decompress_fn = decompress;
    if (cs->compression > EXR_COMPRESSION_ZIP)
        return GP_OK;
    w->inflate = libdeflate_alloc_decompressor();
    gp_status st = gp_alloc(log, "chunk", cs->largest, 1, &w->scratch);
    return st || w->inflate ? st : gp_no_memory(log, cs->path);
}

/* -- DWAA and DWAB, by OpenImageIO ---------------------------------------- */

static gp_status decode_by_oiio(const struct gp_log *log,
    const struct gp_exr_chunks *cs, const struct gp_exr_sink *sink)
{
    const struct gp_stream *s = &cs->input->stream;
    const size_t n = (size_t) cs->w * (size_t) cs->h;
    struct gp_decoded image = {0};
    gp_status st;
    for (int i = 0; i < cs->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return gp_fail(log, GP_ERR_DATA,
                           "%s: channel %s is subsampled and DWA compressed, "
                           "which glarepp cannot decode; write the file with "
                           "another compression", cs->path, e->name.str);
    }
    GP_TRY(gp_oiio_open(log, cs->path, s, "openexr", cs->part, (long long) n,
                        &image));
    const size_t step = (size_t) image.channels;
    for (int i = 0; i < cs->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
        void *const to = sink[i].to;
        int from = 0; // its channels may be in another order
        while (from < image.channels &&
               strcmp(image.channel_name[from], e->name.str) != 0)
            from++;
        if (from == image.channels || gp_rect_w(image.data) != cs->w ||
            gp_rect_h(image.data) != cs->h)
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: OpenImageIO found another window, or no channel "
                           "%s; write the file with another compression",
                           cs->path, e->name.str));
        const float *p = image.pixels + from;
        for (size_t k = 0; to && k < n; k++, p += step) {
            if (e->pixel_type == EXR_PIXEL_HALF && !sink[i].as_float)
                (void) gp_float_to_half(p, (uint16_t *) to + k, 1);
            else if (e->pixel_type == EXR_PIXEL_UINT && sink[i].as_float)
                ((float *) to)[k] = (float) gp_bits_of(*p);
            else
                memcpy((float *) to + k, p, sizeof *p);
        }
    }
out:
    gp_decoded_close(&image);
    return st;
}

/* -- all chunks ----------------------------------------------------------- */

static gp_status decode_body(void *ctx, int index, int thread)
{
    struct worker *const worker = ctx;
    gp_exr_fault_clear();
    const exr_result_t r = run_chunk(&worker[thread], index);
    const gp_status fault = gp_exr_fault();
    return fault ? fault : r || gp_exr_fault_short() ? GP_ERR_DATA : GP_OK;
}

/* Decodes the failed chunk again to learn why; it fails again when the file is
 * to blame. */
static gp_status explain(const struct gp_log *log, struct worker *w, int index,
                         gp_status st)
{
    const struct gp_exr_chunks *cs = w->chunks;
    const exr_chunk_info_t *c = &cs->chunk[index];
    char place[64];
    if (st != GP_ERR_DATA)
        return gp_exr_fault_print(log, cs->path, st);
    gp_exr_fault_clear();
    exr_result_t r = run_chunk(w, index);
    const bool cut = gp_exr_fault_short();
    if (gp_exr_fault())
        return gp_exr_fault_print(log, cs->path, gp_exr_fault());
    if (!r && !cut)
        return gp_no_memory(log, cs->path);
    if (cs->tiled)
        snprintf(place, sizeof place, "tile %d,%d", c->start_x, c->start_y);
    else
        snprintf(place, sizeof place, "line %d", c->start_y);
    // the library says of zlib's blocks that end early that memory is full
    return gp_fail(log, GP_ERR_DATA,
                   "%s: the pixels are damaged at %s (%s); copy or render the "
                   "file again", cs->path, place,
                   r == EXR_ERR_OUT_OF_MEMORY
                       ? "a block does not fit its pixels"
                   : cut ? "the file ends before them"
                       : exr_get_default_error_message(r));
}

gp_status gp_exr_decode(const struct gp_log *log,
    const struct gp_exr_chunks *cs, const struct gp_exr_sink *sink)
{
    const int team = gp_threads() < cs->chunks ? gp_threads() : cs->chunks;
    struct worker *worker;
    int failed;
    if (cs->compression > EXR_COMPRESSION_B44A)
        return decode_by_oiio(log, cs, sink);
    gp_status st = gp_alloc_zero(log, "decoders", (size_t) team,
                                 sizeof *worker, &worker);
    if (st)
        return st;
    for (int i = 0; i < team; i++)
        GP_TRY(open_worker(log, cs, sink, &worker[i]));
    st = gp_parallel(cs->chunks, decode_body, worker, &failed);
    if (st)
        st = explain(log, worker, failed, st);
out:
    for (int i = 0; i < team; i++) {
        if (worker[i].ready)
            (void) exr_decoding_destroy(cs->input->exr, &worker[i].pipe);
        if (worker[i].inflate)
            libdeflate_free_decompressor(worker[i].inflate);
        gp_free(worker[i].scratch);
    }
    gp_free(worker);
    return st;
}
