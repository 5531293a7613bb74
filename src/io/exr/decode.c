// SPDX-License-Identifier: Apache-2.0
/* Decodes the chunks of one part of an EXR: flat ones in parallel, straight
 * into planes, and those of deep data.
 *
 * OpenEXRCore finds, reads and expands them. Here is what 3.1.5 lacks:
 * libdeflate for ZIP, in half of zlib's time (3.2 has it), stored chunks of
 * B44, subsampled blocks (unpacked_bytes()), and DWA (right from 3.1.13 on, see
 * its issue 1682). Its unpacking turns halves to floats one by one where a part
 * has other channels too, in all versions. */
#include "io/exr/exr_priv.h"

#include "core/bytes.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "core/half.h"
#include "io/decoded.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <limits.h>
#include <pthread.h>
#include <string.h>

/* -- the list of chunks --------------------------------------------------- */

/* Prints the line for a chunk: a fault of memory or disk, else `why`. */
static gp_status damaged(const struct gp_log *log,
                         const struct gp_exr_chunks *cs, int chunk,
                         const char *why)
{
    const int row = chunk / ((cs->w - 1) / cs->tile_w + 1);
    if (gp_exr_fault())
        return gp_exr_fault_print(log, cs->input->path, gp_exr_fault());
    return gp_fail(log, GP_ERR_DATA,
                   "%s: truncated or damaged (part %d, chunk %d of %d, at line "
                   "%d: %s); copy or render the file again",
                   cs->input->path, cs->part, chunk + 1, cs->chunks,
                   cs->window.y0 + row * cs->tile_h, why);
}

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
        bool none = c->height == 1 && (c->start_y - cs->window.y0) % ys;
        uint64_t rows = none ? 0 : (uint64_t) (c->height + ys - 1) /
                                       (uint64_t) ys;
        *bytes += rows * (uint64_t) (c->width / xs) *
                  (e->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
    }
    return true;
}

/* The pixels of a chunk in the data window. */
static struct gp_rect pixels_of(const struct gp_exr_chunks *cs,
                                const exr_chunk_info_t *c)
{
    const int x = cs->tiled ? c->start_x * cs->tile_w : 0;
    const int y =
        cs->tiled ? c->start_y * cs->tile_h : c->start_y - cs->window.y0;
    return (struct gp_rect) {x, y, x + c->width, y + c->height};
}

/* Asks the library for all chunks. It checks that each is in the file and where
 * its number says; not that so few bytes can become so many pixels, for which
 * memory is taken. */
static gp_status read_chunks(const struct gp_log *log, struct gp_exr_chunks *cs)
{
    // DEFLATE: a code of 2 bits can stand for 258 bytes; PXR24 makes 4 of each
    // 3 bytes, DWA a block of 128 of one code of 2. The 64 are for headers and
    // for the last, unfinished unit
    const bool dwa = cs->compression > EXR_COMPRESSION_B44A;
    const bool stored = cs->compression == EXR_COMPRESSION_NONE;
    const uint64_t most = dwa ? 64 * 1032 : 1376;
    const exr_context_t exr = cs->input->exr;
    const bool deep = cs->input->each[cs->part].deep;
    const int across = (cs->w - 1) / cs->tile_w + 1;
    gp_exr_fault_clear();
    for (int i = 0; i < cs->chunks; i++) {
        exr_chunk_info_t *c = &cs->chunk[i];
        const exr_result_t r =
            cs->tiled ? exr_read_tile_chunk_info(exr, cs->part, i % across,
                                                 i / across, 0, 0, c)
                      : exr_read_scanline_chunk_info(
                            exr, cs->part, cs->window.y0 + i * cs->tile_h, c);
        const char *wrong = r ? exr_get_default_error_message(r) : NULL;
        uint64_t bytes = 0;
        if (!wrong && !deep && (!unpacked_bytes(cs, c, &bytes) ||
                                bytes != c->unpacked_size))
            return gp_fail(log, GP_ERR_DATA,
                           "%s: a chunk is no whole number of the channels' "
                           "subsampling steps (chunk %d); write the file "
                           "without subsampling",
                           cs->input->path, i + 1);
        if (!wrong && !deep && stored && c->packed_size != bytes)
            wrong = "its size is wrong";
        else if (!wrong && bytes > (c->packed_size + 64) * most)
            wrong = "it is too small for its pixels";
        if (wrong)
            return damaged(log, cs, i, wrong);
        if (bytes > cs->largest)
            cs->largest = bytes;
    }
    return GP_OK;
}

gp_status gp_exr_chunks_find(const struct gp_log *log,
                             const struct gp_input *in, int part, bool deep,
                             long long max_pixels, struct gp_exr_chunks *out)
{
    const struct gp_exr_part *const own = &in->each[part];
    const exr_attr_box2i_t d = own->data;
    const int64_t w = (int64_t) d.max.x - d.min.x + 1;
    const int64_t h = (int64_t) d.max.y - d.min.y + 1;
    int64_t n = 0;
    gp_status st;
    *out = (struct gp_exr_chunks) {
        .input = in,
        .part = part,
        .tiled = own->tiled,
        .tile_h = own->tile_h,
        .channel = own->channel,
    };
    if (!deep && own->deep)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: deep data has no single colour per pixel (part "
                       "%d); flatten it first, with e.g. oiiotool --flatten",
                       in->path, part);
    if (exr_get_compression(in->exr, part, &out->compression))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR header is damaged (part %d lacks its "
                       "compression); render the file again",
                       in->path, part);
    GP_TRY(gp_window_check(log, in->path, "data", w, h, max_pixels));
    out->window = (struct gp_rect) {d.min.x, d.min.y, d.max.x + 1, d.max.y + 1};
    out->w = (int) w;
    out->h = (int) h;
    out->tile_w = own->tiled ? own->tile_w : out->w;
    // the number of chunks of level 0, which come first in the table, which is
    // in the file: that bounds the list
    if (out->tile_w > 0 && out->tile_h > 0)
        n = ((w - 1) / out->tile_w + 1) * ((h - 1) / out->tile_h + 1);
    if (n < 1 || n > own->chunks)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: truncated or damaged (%d chunks, %lld needed); "
                       "copy or render the file again",
                       in->path, own->chunks, (long long) n);
    out->chunks = (int) n;
    GP_TRY(gp_alloc_zero(log, "chunks", (size_t) n, sizeof *out->chunk,
                         &out->chunk));
    GP_TRY(read_chunks(log, out));
out:
    return st;
}

void gp_exr_chunks_free(struct gp_exr_chunks *chunks)
{
    gp_free(chunks->chunk);
    *chunks = (struct gp_exr_chunks) {0};
}

/* -- ZIP, ZIPS and RLE ---------------------------------------------------- */

/* Expands EXR's run lengths to exactly `out_size` bytes, or returns false. */
static bool expand_runs(const uint8_t *in, size_t in_size, uint8_t *out,
                        size_t out_size)
{
    const uint8_t *const in_end = in + in_size;
    uint8_t *const out_end = out + out_size;
    while (in < in_end) {
        // NOLINTNEXTLINE(*-signed-char-misuse,cert-str34-c): below 0 is a copy
        int code = (int8_t) *in++;
        size_t count = (size_t) (code < 0 ? -code : code + 1);
        size_t taken = code < 0 ? count : 1;
        if (taken > (size_t) (in_end - in) || count > (size_t) (out_end - out))
            return false;
        if (code < 0)
            memcpy(out, in, count);
        else
            memset(out, *in, count);
        in += taken;
        out += count;
    }
    return out == out_end;
}

/* Undoes the filter of ZIP, ZIPS and RLE: all bytes at even places come first,
 * then those at odd places, each as the difference to the one before, plus 128
 * (ImfZip.cpp). */
static void undo_filter(const uint8_t *restrict in, uint8_t *restrict out,
                        size_t n)
{
    const size_t half = n / 2;
    uint8_t even = 128, odd = 128; // the first byte is stored without the bias
    for (size_t i = 0; i < half; i++)
        odd = (uint8_t) (odd + in[i] - 128);
    for (size_t i = 0; i < half; i++) {
        even = (uint8_t) (even + in[i] - 128);
        odd = (uint8_t) (odd + in[half + i] - 128);
        out[2 * i] = even;
        out[2 * i + 1] = odd;
    }
}

/* Expands `size` bytes to exactly `n`, even; false when they give more or
 * less. */
static bool unzip(struct libdeflate_decompressor *d, bool rle,
                  const uint8_t *packed, size_t size, uint8_t *scratch,
                  uint8_t *out, size_t n)
{
    // without a place for the size, another one than n is a failure
    if (rle ? !expand_runs(packed, size, scratch, n)
            : libdeflate_zlib_decompress(d, packed, size, scratch, n, NULL))
        return false;
    undo_filter(scratch, out, n);
    return true;
}

/* -- one chunk ------------------------------------------------------------ */

/* State of one thread. */
struct worker {
    const struct gp_exr_chunks *chunks;
    const struct gp_exr_sink *sink;
    exr_result_t (*library_decompress)(exr_decode_pipeline_t *);
    struct libdeflate_decompressor *inflate; // of ZIP and RLE
    uint8_t *scratch; // chunks->largest bytes, of ZIP and RLE
};

/* The samples of a chunk to the sinks; for unpack_and_convert_fn. */
static exr_result_t unpack_chunk(exr_decode_pipeline_t *pipe)
{
    const struct worker *w = pipe->decoding_user_data;
    const struct gp_exr_chunks *cs = w->chunks;
    const exr_chunk_info_t *c = &pipe->chunk;
    const struct gp_rect r = pixels_of(cs, c);
    const uint8_t *from = pipe->unpacked_buffer;
    if (!from)
        return EXR_ERR_CORRUPT_CHUNK;
    for (int y = r.y0; y < r.y1; y++) {
        for (int i = 0; i < cs->channel->num_channels; i++) {
            const exr_attr_chlist_entry_t *e = &cs->channel->entries[i];
            const struct gp_exr_sink *s = &w->sink[i];
            if (y % e->y_sampling)
                continue;
            const bool half = e->pixel_type == EXR_PIXEL_HALF;
            const size_t n = (size_t) (c->width / e->x_sampling);
            const size_t width = (size_t) (cs->w / e->x_sampling);
            const size_t index = (size_t) (y / e->y_sampling) * width +
                                 (size_t) (r.x0 / e->x_sampling);
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
                ((float *) to)[k] = (float) gp_bits_of(((float *) to)[k]);
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
        unzip(w->inflate, how == EXR_COMPRESSION_RLE, pipe->packed_buffer, in,
              w->scratch, pipe->unpacked_buffer, out))
        return EXR_ERR_SUCCESS;
    return w->library_decompress(pipe);
}

static exr_result_t run_chunk(struct worker *w, int index)
{
    // the library chooses its routines on first use without a lock, and
    // frames may be read by several threads at once
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    const struct gp_exr_chunks *cs = w->chunks;
    const exr_context_t exr = cs->input->exr;
    exr_decode_pipeline_t pipe = EXR_DECODE_PIPELINE_INITIALIZER;
    gp_exr_fault_clear();
    if (cs->chunk[index].unpacked_size == 0) // lines that no channel samples
        return EXR_ERR_SUCCESS;
    exr_result_t r =
        exr_decoding_initialize(exr, cs->part, &cs->chunk[index], &pipe);
    if (!r) {
        pthread_mutex_lock(&lock);
        r = exr_decoding_choose_default_routines(exr, cs->part, &pipe);
        pthread_mutex_unlock(&lock);
    }
    pipe.decoding_user_data = w;
    pipe.unpack_and_convert_fn = unpack_chunk;
    w->library_decompress = pipe.decompress_fn;
    if (cs->compression != EXR_COMPRESSION_NONE)
        pipe.decompress_fn = decompress;
    if (!r)
        r = exr_decoding_run(exr, cs->part, &pipe);
    (void) exr_decoding_destroy(exr, &pipe);
    return r;
}

/* -- DWAA and DWAB, by OpenImageIO ---------------------------------------- */

static gp_status decode_by_oiio(const struct gp_log *log,
    const struct gp_exr_chunks *cs, const struct gp_exr_sink *sink)
{
    const struct gp_stream *s = &cs->input->stream;
    const size_t n = (size_t) cs->w * (size_t) cs->h;
    struct gp_decoded image = {0};
    gp_status st;
    GP_TRY(gp_oiio_open(log, cs->input->path, s, "openexr", cs->part,
                        (long long) n, &image));
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
            GP_TRY(
                gp_fail(log, GP_ERR_DATA,
                        "%s: OpenImageIO found another window, or no "
                        "channel %s; write the file with another compression",
                        cs->input->path, e->name.str));
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
    const exr_result_t r = run_chunk(&worker[thread], index);
    const gp_status fault = gp_exr_fault();
    return fault ? fault : r || gp_exr_fault_short() ? GP_ERR_DATA : GP_OK;
}

gp_status gp_exr_decode(const struct gp_log *log,
    const struct gp_exr_chunks *cs, const struct gp_exr_sink *sink)
{
    const int team = gp_min(gp_threads(), cs->chunks);
    struct worker *worker;
    int failed;
    if (cs->compression > EXR_COMPRESSION_B44A)
        return decode_by_oiio(log, cs, sink);
    gp_status st = gp_alloc_zero(log, "decoders", (size_t) team,
                                 sizeof *worker, &worker);
    if (st)
        return st;
    for (int i = 0; i < team; i++) {
        struct worker *const w = &worker[i];
        w->chunks = cs;
        w->sink = sink;
        if (cs->compression == EXR_COMPRESSION_NONE ||
            cs->compression > EXR_COMPRESSION_ZIP)
            continue;
        GP_TRY(gp_alloc(log, "chunk", cs->largest, 1, &w->scratch));
        w->inflate = libdeflate_alloc_decompressor();
        if (!w->inflate)
            GP_TRY(gp_no_memory(log, cs->input->path));
    }
    st = gp_parallel(cs->chunks, decode_body, worker, &failed);
    if (st == GP_ERR_DATA) { // does it again to learn why
        const exr_result_t r = run_chunk(worker, failed);
        // the library says of zlib's blocks that end early that memory is full
        st = damaged(log, cs, failed, r == EXR_ERR_OUT_OF_MEMORY
                     ? "a block does not fit its pixels"
                     : gp_exr_fault_short() ? "the file ends before them"
                     : exr_get_default_error_message(r));
    } else if (st) {
        st = gp_exr_fault_print(log, cs->input->path, st);
    }
out:
    for (int i = 0; i < team; i++) {
        if (worker[i].inflate)
            libdeflate_free_decompressor(worker[i].inflate);
        gp_free(worker[i].scratch);
    }
    gp_free(worker);
    return st;
}

/* -- deep data -------------------------------------------------------------
 *
 * A chunk (openexr file layout, "Deep Scan Line" and "Deep Tiled") has a count
 * table, for each row the samples up to and with each pixel, then the samples,
 * row by row, channel by channel, pixel by pixel. Each of both is compressed by
 * itself, or stored where that does not shrink it. Deep parts are compressed
 * by RLE, ZIPS or not at all.
 *
 * Not expanded by OpenEXRCore: damaged counts make 3.1.5 write out of its
 * buffers (CVE-2023-5841). From 3.1.12 and 3.2.2 on it can. */

struct deep {
    const struct gp_log *log;
    struct gp_exr_deep *out;
    struct libdeflate_decompressor *inflate;
    uint8_t *bytes; // of a table or of samples; packed, and half expanded
    size_t room;    // bytes of each of these three
};

/* Reads and expands `packed` bytes at `from` into d->bytes, `size` of them. If
 * they are stored, the file has `whole` bytes: an edge tile's table is then as
 * long as any other's, so a compressed one may be longer than its `size`. */
static gp_status read_bytes(struct deep *d, int chunk, uint64_t from,
                            uint64_t packed, uint64_t size, uint64_t whole)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const bool none = l->compression == EXR_COMPRESSION_NONE;
    const bool stored = packed == whole || (none && packed == size);
    const uint64_t read = stored ? size : packed;
    const uint64_t room = read > size ? read : size;
    gp_status st;
    // a byte of DEFLATE is at most 1032, one of RLE at most 64
    if (packed > whole || size > (packed + 64) * 1032 || size % 2 ||
        (!stored && none))
        return damaged(d->log, l, chunk, "its size is wrong");
    if (room > d->room) {
        GP_FREE(d->bytes);
        GP_TRY(gp_alloc(d->log, l->input->path, room, 3, &d->bytes));
        d->room = room;
    }
    uint8_t *const from_file = d->bytes + d->room;
    if (gp_exr_read_bytes(&l->input->stream, stored ? d->bytes : from_file,
                          read, from) != (int64_t) read)
        return damaged(d->log, l, chunk, "it cannot be read");
    if (!stored &&
        !unzip(d->inflate, l->compression == EXR_COMPRESSION_RLE, from_file,
               packed, from_file + d->room, d->bytes, size))
        return damaged(d->log, l, chunk, "it does not expand to its size");
    return GP_OK;
out:
    return st;
}

/* Reads the count table of a chunk into first[pixel + 1]. */
static gp_status read_counts(struct deep *d, int chunk)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const exr_chunk_info_t *const c = &l->chunk[chunk];
    const struct gp_rect b = pixels_of(l, c);
    const uint64_t w = (uint64_t) gp_rect_w(b), h = (uint64_t) gp_rect_h(b);
    const uint64_t whole = (uint64_t) l->tile_w * (uint64_t) l->tile_h;
    gp_status st = read_bytes(d, chunk, c->sample_count_data_offset,
                              c->sample_count_table_size,
                              w * h * sizeof(int32_t), whole * sizeof(int32_t));
    const uint8_t *from = d->bytes;
    for (int y = b.y0; y < b.y1 && !st; y++) {
        int64_t *const to = d->out->first + (int64_t) y * l->w + 1;
        int32_t before = 0, up_to;
        for (int x = b.x0; x < b.x1; x++, before = up_to) {
            memcpy(&up_to, from, sizeof up_to);
            from += sizeof up_to;
            if (up_to < before)
                return damaged(d->log, l, chunk, "its counts are wrong");
            to[x] = up_to - before;
        }
    }
    return st;
}

/* Reads the samples of a chunk; first[] is complete. */
static gp_status read_samples(struct deep *d, int chunk)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const exr_chunk_info_t *const c = &l->chunk[chunk];
    const struct gp_rect b = pixels_of(l, c);
    const int channels = l->channel->num_channels;
    uint64_t size = 0, a_sample = 0;
    for (int i = 0; i < channels; i++)
        a_sample += l->channel->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
    for (int y = b.y0; y < b.y1; y++) {
        const int64_t *const first = d->out->first + (int64_t) y * l->w;
        size += (uint64_t) (first[b.x1] - first[b.x0]) * a_sample;
    }
    if (size != c->unpacked_size)
        return damaged(d->log, l, chunk, "its counts are not its samples'");
    gp_status st =
        read_bytes(d, chunk, c->data_offset, c->packed_size, size, size);
    const uint8_t *from = d->bytes;
    for (int y = b.y0; y < b.y1 && !st; y++) {
        const int64_t *const first = d->out->first + (int64_t) y * l->w;
        const size_t n = (size_t) (first[b.x1] - first[b.x0]);
        for (int i = 0; i < channels && n; i++) {
            const bool half =
                l->channel->entries[i].pixel_type == EXR_PIXEL_HALF;
            float *const to = (float *) d->out->sample[i] + first[b.x0];
            if (half)
                gp_half_to_float((const uint16_t *) (const void *) from, to, n);
            else
                memcpy(to, from, n * sizeof *to);
            from += n * (half ? 2 : sizeof *to);
        }
    }
    return st;
}

gp_status gp_exr_deep_read(const struct gp_log *log, const struct gp_input *in,
                           int part, long long max_pixels,
                           struct gp_exr_deep *out)
{
    const char *const path = in->path;
    struct deep d = {.log = log, .out = out};
    struct gp_exr_chunks *const l = &out->part;
    gp_status st;
    *out = (struct gp_exr_deep) {0};
    GP_TRY(gp_exr_chunks_find(log, in, part, true, max_pixels, l));
    gp_exr_fault_clear();
    d.inflate = libdeflate_alloc_decompressor();
    if (!d.inflate)
        GP_TRY(gp_no_memory(log, path));
    const size_t pixels = (size_t) l->w * (size_t) l->h;
    const size_t channels = (size_t) l->channel->num_channels;
    GP_TRY(gp_alloc_zero(log, path, pixels + 1, sizeof *out->first,
                         &out->first));
    for (int i = 0; i < l->chunks; i++)
        GP_TRY(read_counts(&d, i));
    for (size_t i = 0; i < pixels; i++) {
        out->first[i + 1] += out->first[i];
        if (out->first[i + 1] > max_pixels)
            GP_TRY(gp_fail(log, GP_ERR_DATA,
                           "%s: more than %lld deep samples (part %d); raise "
                           "--max-pixels", path, max_pixels, part));
    }
    GP_TRY(gp_alloc_zero(log, path, channels + 1, sizeof *out->sample,
                         &out->sample));
    for (size_t i = 0; i < channels; i++)
        GP_TRY(gp_alloc_zero(log, path, (size_t) out->first[pixels] + 1,
                             sizeof(float), &out->sample[i]));
    for (int i = 0; i < l->chunks; i++)
        GP_TRY(read_samples(&d, i));
out:
    if (d.inflate)
        libdeflate_free_decompressor(d.inflate);
    gp_free(d.bytes);
    return st;
}

void gp_exr_deep_free(struct gp_exr_deep *deep)
{
    for (int i = 0; deep->sample && i < deep->part.channel->num_channels; i++)
        gp_free(deep->sample[i]);
    gp_free(deep->sample);
    gp_free(deep->first);
    gp_exr_chunks_free(&deep->part);
    *deep = (struct gp_exr_deep) {0};
}
