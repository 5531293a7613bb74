// SPDX-License-Identifier: Apache-2.0
/* The chunks of a file that is written, and its offset tables (openexr file
 * layout, "Chunk Layout"): planes and carried channels as chunks of scanlines,
 * or those of another file as they are.
 *
 * ZIP straight from planes with libdeflate, in half of the time that
 * OpenEXRCore's zlib takes (3.2 has libdeflate); DWA by OpenImageIO (OpenEXRCore
 * has it, rightly, from 3.1.13 on); the others by OpenEXRCore.
 * Not put into the file by that: 3.1.5 refuses chunks out of order (unless the
 * part's lineOrder is random) and deep chunks without samples, and carried
 * parts have both. Its write_scan_chunk() and write_tile_chunk() do so at
 * 01e9f18f of its repository too. */
#include "io/exr/exr_priv.h"

#include "core/cpu.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"
#include "core/half.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* -- tables and chunks ---------------------------------------------------- */

gp_status gp_exr_out_tables(struct gp_exr_out *out, const int *chunks,
                            int parts)
{
    const uint32_t version = GP_EXR_VERSION | out->flags;
    const char *const path = gp_file_path(out->file);
    gp_status st;
    GP_TRY(gp_file_patch(out->file, 4, &version, sizeof version));
    GP_TRY(gp_alloc_zero(out->log, path, (size_t) parts + 1,
                         sizeof *out->first, &out->first));
    for (int p = 0; p < parts; p++)
        out->first[p + 1] = out->first[p] + (size_t) chunks[p];
    out->chunks = out->first[parts];
    GP_TRY(gp_alloc_zero(out->log, path, out->chunks, sizeof *out->offset,
                         &out->offset));
    out->tables = gp_file_size(out->file);
    GP_TRY(gp_file_write(out->file, out->offset,
                         out->chunks * sizeof *out->offset));
out:
    return st;
}

/* Begins a chunk, with the part's number in files of several. */
static gp_status begin_chunk(struct gp_exr_out *out, int part, int index)
{
    const int32_t number = part;
    out->offset[out->first[part] + (size_t) index] = gp_file_size(out->file);
    return gp_file_write(out->file, &number,
                         out->flags & GP_EXR_MULTIPART ? sizeof number : 0);
}

gp_status gp_exr_out_end(struct gp_exr_out *out)
{
    return gp_file_patch(out->file, out->tables, out->offset,
                         out->chunks * sizeof *out->offset);
}

void gp_exr_out_free(struct gp_exr_out *out)
{
    gp_free(out->first);
    gp_free(out->offset);
    *out = (struct gp_exr_out) {0};
}

/* -- chunks of another file, as they are ---------------------------------- */

static int by_offset(const void *a, const void *b)
{
    const uint64_t *const p = *(const uint64_t *const *) a;
    const uint64_t *const q = *(const uint64_t *const *) b;
    return *p != *q ? (*p > *q ? 1 : -1) : (p > q) - (p < q);
}

gp_status gp_exr_out_copy(struct gp_exr_out *out, int part,
                          const struct gp_input *in, int from)
{
    gp_status st;
    const char *const path = in->path;
    uint64_t *const offset = out->offset + out->first[part];
    const int n = (int) (out->first[part + 1] - out->first[part]);
    const size_t number = in->index->multi ? 4 : 0; // bytes of the part's
    void *chunk = NULL;
    uint64_t room = 0;
    const uint64_t **order = NULL;
    GP_TRY(gp_alloc(out->log, path, (size_t) n, sizeof *order, &order));
    gp_exr_fault_clear();
    if (n < 1)
        st = GP_ERR_DATA;
    for (int i = 0; i < n; i++) {
        offset[i] = in->index->offset[in->each[from].first + (uint64_t) i];
        order[i] = &offset[i];
    }
    qsort(order, (size_t) n, sizeof *order, by_offset);
    for (int i = 0; !st && i < n; i++) {
        const uint64_t at = *order[i]; // begin_chunk() replaces it
        const uint64_t bytes = gp_exr_chunk_bytes(in, from, at);
        const uint64_t copied = bytes - number;
        if (bytes == 0 || at + bytes > in->stream.size) {
            st = GP_ERR_DATA;
            break;
        }
        if (bytes > room) {
            GP_TRY(gp_resize(out->log, path, bytes, &chunk));
            room = bytes;
        }
        GP_TRY(begin_chunk(out, part, (int) (order[i] - offset)));
        st = gp_exr_read_bytes(&in->stream, chunk, copied, at + number) ==
                     (int64_t) copied
                 ? gp_file_write(out->file, chunk, copied) : GP_ERR_DATA;
    }
    if (st == GP_ERR_DATA && gp_exr_fault())
        st = gp_exr_fault_print(out->log, path, gp_exr_fault());
    else if (st == GP_ERR_DATA)
        (void) gp_fail(out->log, st,
            "%s: part %d is truncated or damaged; copy or render the "
            "file again, or give --hdr a file without it", path, from);
out:
    gp_free(order);
    gp_free(chunk);
    return st;
}

/* -- chunks of scanlines --------------------------------------------------- */

/* Chunks that are compressed before the batch is written. More a thread
 * means less waiting for the slowest; memory is bounded beside it. */
enum { CHUNKS_A_THREAD = 16 };
static const size_t batch_bytes = (size_t) 64 << 20;

/* Of libdeflate's levels the fastest whose files are as small as those of
 * zlib's level 4, which OpenEXR writes: within 2 % on rendered nights of half
 * and float and on files of 4 to 56 channels, in 0.4 to 0.65 of its time. Level 1
 * takes 0.25 to 0.45, and 2 to 5 % more bytes. */
enum { ZIP_LEVEL = 2 };

static int chunk_rows(enum gp_compression compression)
{
    static const int rows[] = {
        // from NONE to DWAB
        1, 1, 1, 16, 32, 16, 32, 32, 32, 256,
    };
    return rows[compression];
}

int gp_exr_chunk_count(const struct gp_exr_image *img)
{
    const int rows = chunk_rows(img->compression);
    return (gp_rect_h(img->data) + rows - 1) / rows;
}

/* -- packing -------------------------------------------------------------- */

/* B44 counts each 4x4 block down from its largest value in steps of up to 2048
 * codes, to the nearest: its least one may be 1024 codes lower. From -32752
 * on that is still a number; -65504 came back as -Inf, or NaN. */
enum { B44_LEAST = 0xf7ff, MINUS_INF = 0xfc00 };

/* Packs rows as EXR has them before compression, or only counts (`to` NULL).
 * Adds values that half or B44 cannot hold to *clamped. Returns bytes, even. */
static size_t pack_rows(const struct gp_exr_image *img, int y0, int y1,
                        uint8_t *to, long long *clamped)
{
    const bool b44 = img->compression == GP_COMPRESSION_B44 ||
                     img->compression == GP_COMPRESSION_B44A;
    const int top = img->data.y0;
    size_t at = 0;
    for (int y = y0; y < y1; y++) {
        for (int i = 0; i < img->sources; i++) {
            const struct gp_exr_source *s = &img->source[i];
            const size_t n = (size_t) s->columns, size = gp_type_size(s->type);
            if (y % s->ys != 0)
                continue;
            uint8_t *const row = to ? to + at : NULL;
            at += n * size;
            if (!to)
                continue;
            // from the row of the channel's own grid, which need not begin at
            // y0
            const int first = top + (s->ys - top % s->ys) % s->ys % s->ys;
            const size_t from = (size_t) ((y - first) / s->ys) * n;
            if (!s->plane) {
                memcpy(row, (const uint8_t *) s->data + from * size, n * size);
                continue;
            }
            const float *const plane = s->plane + from;
            if (s->type != GP_HALF) {
                memcpy(row, plane, n * size);
                continue;
            }
            uint16_t *const half = (uint16_t *) row;
            *clamped += (long long) gp_float_to_half(plane, half, n);
            for (size_t k = 0; b44 && k < n; k++) {
                if (half[k] > B44_LEAST && half[k] < MINUS_INF) {
                    *clamped += plane[k] > -65520.0f; // below, it is counted
                    half[k] = B44_LEAST;
                }
            }
        }
    }
    return at;
}

/* -- ZIP and ZIPS --------------------------------------------------------- */

/* Puts the bytes at even places first, then those at odd places, each as the
 * difference to the one before, plus 128 (ImfZip.cpp). */
GP_CLONES static void filter_bytes(const uint8_t *restrict in,
                                   uint8_t *restrict out, size_t n)
{
    const size_t half = n / 2;
    uint8_t *restrict even = out, *restrict odd = out + half;
    if (n == 0)
        return;
    even[0] = in[0]; // the very first byte has none before it
    odd[0] = (uint8_t) (in[1] - in[n - 2] + 128);
    for (size_t i = 1; i < half; i++) {
        even[i] = (uint8_t) (in[2 * i] - in[2 * i - 2] + 128);
        odd[i] = (uint8_t) (in[2 * i + 1] - in[2 * i - 1] + 128);
    }
}

/* Compresses the `n` bytes of a chunk; `n` is even, scratch and out have that
 * room. Returns the compressed size, n where it does not shrink. */
static size_t zip(struct libdeflate_compressor *c, const uint8_t *raw, size_t n,
                  uint8_t *scratch, uint8_t *out)
{
    filter_bytes(raw, scratch, n);
    const size_t size =
        n ? libdeflate_zlib_compress(c, scratch, n, out, n - 1) : 0;
    if (!size)
        memcpy(out, raw, n);
    return size ? size : n;
}

/* -- OpenEXRCore's compressors: RLE, PIZ, PXR24, B44, B44A -------------------
 *
 * The library ties them to a file that it writes itself. Here that is one that
 * goes nowhere, and the compressed bytes are taken. */

struct slot { // one chunk of the batch
    const struct gp_exr_image *img;
    int y0, y1;
    size_t size; // compressed
    long long clamped;
};

static int64_t write_nowhere(exr_const_context_t ctxt, void *user,
                             const void *data, uint64_t size, uint64_t offset,
                             exr_stream_error_func_ptr_t error)
{
    (void) ctxt;
    (void) user;
    (void) data;
    (void) offset;
    (void) error;
    return (int64_t) size;
}

static void print_nothing(exr_const_context_t ctxt, exr_result_t code,
                          const char *message)
{
    (void) ctxt; // the caller has the code
    (void) code;
    (void) message;
}

/* Our packing in the place of the library's; for convert_and_pack_fn. */
static exr_result_t pack_for_library(exr_encode_pipeline_t *pipe)
{
    struct slot *const s = pipe->encoding_user_data;
    size_t room = 0;
    for (int c = 0; c < pipe->channel_count; c++) {
        const exr_coding_channel_info_t *i = &pipe->channels[c];
        room += (size_t) i->width * (size_t) i->height *
                (size_t) i->bytes_per_element;
    }
    // the library's count need not be that of the file layout: 3.1.5 and odd
    // subsampling
    if (pack_rows(s->img, s->y0, s->y1, NULL, NULL) != room)
        return EXR_ERR_INVALID_ARGUMENT;
    pipe->packed_bytes =
        pack_rows(s->img, s->y0, s->y1, pipe->packed_buffer, &s->clamped);
    return EXR_ERR_SUCCESS;
}

/* Compresses a chunk into `to`. */
static gp_status run_library(exr_context_t ctxt, struct slot *s, uint8_t *to)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t chunk;
    gp_exr_fault_clear();
    exr_result_t r = exr_write_scanline_chunk_info(ctxt, 0,
        s->y0 - s->img->data.y0, &chunk);
    if (!r)
        r = exr_encoding_initialize(ctxt, 0, &chunk, &pipe);
    for (int c = 0; c < pipe.channel_count; c++) {
        // asked for by the library, not read by pack_for_library()
        pipe.channels[c].encode_from_ptr = to;
        pipe.channels[c].user_pixel_stride = 4;
        pipe.channels[c].user_line_stride = 4;
    }
    if (!r)
        r = exr_encoding_choose_default_routines(ctxt, 0, &pipe);
    pipe.encoding_user_data = s;
    pipe.convert_and_pack_fn = pack_for_library;
    pipe.yield_until_ready_fn = NULL;
    pipe.write_fn = NULL;
    if (!r)
        r = exr_encoding_run(ctxt, 0, &pipe);
    if (!r) {
        // a chunk that did not shrink is stored as it is, and readers know
        // such a chunk by its size; 3.1.5 forgets that for the equal size
        const bool stored = pipe.compressed_bytes >= pipe.packed_bytes;
        s->size = stored ? (size_t) pipe.packed_bytes : pipe.compressed_bytes;
        memcpy(to, stored ? pipe.packed_buffer : pipe.compressed_buffer,
               s->size);
    }
    const gp_status fault = gp_exr_fault();
    exr_encoding_destroy(ctxt, &pipe);
    return fault || !r ? fault : GP_ERR_USAGE;
}

/* Opens a file that goes nowhere, with the least header that the library's
 * compressors need: its lines count from 0. */
static exr_result_t open_library(const struct gp_exr_image *img,
                                 exr_context_t *ctxt)
{
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    int part;
    init.error_handler_fn = print_nothing;
    init.alloc_fn = gp_exr_allocate;
    init.free_fn = gp_free;
    init.write_fn = write_nowhere;
    gp_exr_fault_clear();
    exr_result_t r =
        exr_start_write(ctxt, "nowhere", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!r)
        r = exr_set_longname_support(*ctxt, 1);
    if (!r)
        r = exr_add_part(*ctxt, "part", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr_simple(*ctxt, part,
            gp_rect_w(img->data), gp_rect_h(img->data),
            (exr_compression_t) img->compression);
    for (int i = 0; !r && i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        r = exr_add_channel(*ctxt, part, s->name, (exr_pixel_type_t) s->type,
                            s->linear ? EXR_PERCEPTUALLY_LINEAR
                                      : EXR_PERCEPTUALLY_LOGARITHMIC,
                            s->xs, s->ys);
    }
    return r ? r : exr_write_header(*ctxt);
}

/* -- chunks in parallel --------------------------------------------------- */

struct batch {
    const struct gp_exr_image *img;
    int rows;           // of a chunk
    size_t chunk_bytes; // most that a chunk has before compression
    struct libdeflate_compressor **zip; // of each thread; NULL: not by ZIP
    uint8_t *raw;           // for ZIP: two chunks of each thread
    exr_context_t library;  // NULL: not by the library
    struct slot *slot;
    uint8_t *bytes;         // chunk_bytes for each slot
    int slots;
    int first;              // chunk of slot 0
};

static gp_status encode_chunk(void *ctx, int i, int thread)
{
    struct batch *b = ctx;
    struct slot *s = &b->slot[i];
    uint8_t *const to = b->bytes + (size_t) i * b->chunk_bytes;
    const struct gp_rect r = b->img->data;
    const int y0 = r.y0 + (b->first + i) * b->rows;
    *s = (struct slot) {
        .img = b->img, .y0 = y0,
        .y1 = b->rows < r.y1 - y0 ? y0 + b->rows : r.y1,
    };
    if (b->library)
        return run_library(b->library, s, to);
    uint8_t *const raw =
        b->zip ? b->raw + 2 * (size_t) thread * b->chunk_bytes : to;
    s->size = pack_rows(b->img, y0, s->y1, raw, &s->clamped);
    if (b->zip)
        s->size = zip(b->zip[thread], raw, s->size, raw + b->chunk_bytes, to);
    return GP_OK;
}

/* Prints the line for a compressor's `st`: full memory, else a refusal. */
static gp_status refused(const struct gp_log *log, const char *path,
                         gp_status st)
{
    if (st == GP_ERR_BUG)
        return gp_exr_fault_print(log, path, st);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: OpenEXR cannot compress these channels so (names or "
                   "subsampling); use --compression zip", path);
}

static void stop_batch(struct batch *b)
{
    for (int i = 0; b->zip && i < gp_threads(); i++) {
        if (b->zip[i])
            libdeflate_free_compressor(b->zip[i]);
    }
    if (b->library)
        exr_finish(&b->library);
    gp_free(b->zip);
    gp_free(b->raw);
    gp_free(b->slot);
    gp_free(b->bytes);
}

/* The caller calls stop_batch() in any case. */
static gp_status start_batch(const struct gp_log *log, const char *path,
                             const struct gp_exr_image *img, struct batch *b)
{
    gp_status st;
    const int threads = gp_threads(), chunks = gp_exr_chunk_count(img);
    *b = (struct batch) {.img = img, .rows = chunk_rows(img->compression)};
    for (int i = 0; i < img->sources; i++)
        b->chunk_bytes += (size_t) img->source[i].columns *
                          gp_type_size(img->source[i].type);
    b->chunk_bytes *= (size_t) b->rows;
    if (b->chunk_bytes > INT_MAX)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %d rows of this frame are more than an EXR chunk "
                       "may hold; use --compression zips", path, b->rows);
    // at least one a thread, whatever memory that takes
    const int most = (int) (batch_bytes / (b->chunk_bytes + 1)) + 1;
    b->slots = gp_min(gp_min(threads * CHUNKS_A_THREAD,
                             gp_max(most, threads)), chunks);
    GP_TRY(gp_alloc(log, "EXR chunks", (size_t) b->slots, sizeof *b->slot,
                    &b->slot));
    GP_TRY(gp_alloc(log, "EXR chunks", (size_t) b->slots, b->chunk_bytes,
                    &b->bytes));
    if (img->compression == GP_COMPRESSION_ZIP ||
        img->compression == GP_COMPRESSION_ZIPS) {
        GP_TRY(gp_alloc(log, "EXR chunks", 2 * (size_t) threads,
                        b->chunk_bytes, &b->raw));
        GP_TRY(gp_alloc_zero(log, "EXR threads", (size_t) threads,
                             sizeof *b->zip, &b->zip));
        for (int i = 0; i < threads; i++) {
            b->zip[i] = libdeflate_alloc_compressor(ZIP_LEVEL);
            if (!b->zip[i])
                GP_TRY(gp_no_memory_bare(log, "EXR compressor"));
        }
    } else if (img->compression != GP_COMPRESSION_NONE &&
               open_library(img, &b->library)) {
        st = refused(log, path, gp_exr_fault());
    }
out:
    return st;
}

/* -- DWAA and DWAB ----------------------------------------------------------
 *
 * OpenImageIO writes an EXR in memory with the same channels, whose chunks are
 * copied unchanged: OpenEXRCore 3.1.5 cannot make them. */

/* All samples, pixel by pixel. Errors: GP_ERR_BUG out of memory. */
static gp_status interleave(const struct gp_log *log, const char *path,
    const struct gp_exr_image *img, size_t step, struct gp_shared *out,
    long long *clamped)
{
    const size_t w = (size_t) gp_rect_w(img->data);
    const size_t h = (size_t) gp_rect_h(img->data);
    uint8_t *row = NULL;
    gp_status st = gp_shared_make(log, path, w * h * step, out);
    if (!st)
        st = gp_alloc(log, "DWA row", w, step, &row);
    for (size_t y = 0; y < h && !st; y++) {
        const int at = img->data.y0 + (int) y;
        const uint8_t *from = row;
        uint8_t *channel = (uint8_t *) out->at + y * w * step;
        pack_rows(img, at, at + 1, row, clamped);
        for (int i = 0; i < img->sources; i++) {
            const size_t size = gp_type_size(img->source[i].type);
            for (size_t x = 0; x < w; x++, from += size)
                memcpy(channel + x * step, from, size);
            channel += size;
        }
    }
    gp_free(row);
    return st;
}

static gp_status encode_dwa(struct gp_exr_out *out, int part,
    const struct gp_exr_image *img, long long *clamped)
{
    const struct gp_log *const log = out->log;
    const char *const path = gp_file_path(out->file);
    const size_t n = (size_t) img->sources;
    const int units = (int) img->quality; // by halves: no locale's comma
    gp_status st;
    const char **names = NULL;
    int *types = NULL;
    struct gp_shared pixels = {0};
    struct gp_stream stream = GP_STREAM_EMPTY;
    struct gp_input *file = NULL;
    exr_compression_t made;
    char compression[32];
    size_t step = 0;
    snprintf(compression, sizeof compression, "%s:%d.%03d",
             img->compression == GP_COMPRESSION_DWAA ? "dwaa" : "dwab", units,
             (int) ((img->quality - (float) units) * 1000.0f));
    GP_TRY(gp_alloc(log, path, n, sizeof *names, &names));
    GP_TRY(gp_alloc(log, path, n, sizeof *types, &types));
    for (int i = 0; i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        if (s->xs != 1 || s->ys != 1)
            GP_TRY(gp_fail(log, GP_ERR_USAGE,
                           "%s: channel %s is subsampled, which DWA "
                           "compression does not take here; use --compression "
                           "zip", path, s->name));
        names[i] = s->name;
        types[i] = (int) s->type;
        step += gp_type_size(s->type);
    }
    GP_TRY(interleave(log, path, img, step, &pixels, clamped));
    const struct gp_decoded image = {
        .path = path, .data = img->data, .display = img->data,
        .channels = img->sources, .channel_name = names, .colour_space = "",
    };
    GP_TRY(gp_oiio_write(log, &image, types, &pixels, "exr", "half",
                         compression, &stream));
    GP_TRY(gp_exr_open(log, path, &stream, &file));
    // it writes another compression where it does not trust its own
    if (exr_get_compression(file->exr, 0, &made) ||
        (int) made != (int) img->compression)
        GP_TRY(gp_fail(log, GP_ERR_BUG,
                       "%s: OpenImageIO did not compress these channels by "
                       "DWA; use --compression zip", path));
    GP_TRY(gp_exr_out_copy(out, part, file, 0));
out:
    gp_input_free(file);
    gp_stream_close(&stream);
    gp_shared_free(&pixels);
    gp_free(types);
    gp_free(names);
    return st;
}

/* -- all compressions ----------------------------------------------------- */

gp_status gp_exr_encode(struct gp_exr_out *out, int part,
    const struct gp_exr_image *img, long long *clamped)
{
    struct batch b;
    gp_status st;
    const char *path = gp_file_path(out->file);
    if (img->compression >= GP_COMPRESSION_DWAA)
        return encode_dwa(out, part, img, clamped);
    const int chunks = gp_exr_chunk_count(img);
    GP_TRY(start_batch(out->log, path, img, &b));
    for (; b.first < chunks; b.first += b.slots) {
        const int n = gp_min(chunks - b.first, b.slots);
        st = gp_parallel(n, encode_chunk, &b, NULL);
        if (st)
            GP_TRY(refused(out->log, path, st));
        for (int i = 0; i < n; i++) {
            const struct slot *s = &b.slot[i];
            const int32_t leader[2] = {s->y0, (int32_t) s->size};
            GP_TRY(begin_chunk(out, part, b.first + i));
            GP_TRY(gp_file_write(out->file, leader, sizeof leader));
            GP_TRY(gp_file_write(out->file,
                   b.bytes + (size_t) i * b.chunk_bytes, s->size));
            *clamped += s->clamped;
        }
    }
out:
    stop_batch(&b);
    return st;
}
