/* Compresses planes and carried channels to the chunks of a scanline part.
 *
 * ZIP straight from planes with libdeflate, in half of the time that OpenEXRCore's
 * zlib takes (3.2 has libdeflate); DWA by OpenImageIO (OpenEXRCore has it,
 * rightly, from 3.1.13 on); the others by OpenEXRCore, whose bytes out.c writes. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "core/half.h"
#include "io/oiio/oiio.h"

#include <libdeflate.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Chunks that are compressed before the batch is written. More a thread
 * means less waiting for the slowest; memory is bounded beside it. */
enum { CHUNKS_A_THREAD = 16 };
static const size_t batch_bytes = (size_t) 64 << 20;

/* Of libdeflate's levels the fastest whose files are as small as those of zlib's
 * level 4, which OpenEXR writes: within 2 % on rendered nights of half and
 * float and on files of 4 to 56 channels, in 0.4 to 0.65 of its time. Level 1
 * takes 0.25 to 0.45, and 2 to 5 % more bytes. */
enum { ZIP_LEVEL = 2 };

static int chunk_rows(enum gp_compression compression)
{
    switch (compression) {
    case GP_COMPRESSION_ZIP:
    case GP_COMPRESSION_PXR24:
        return 16;
    case GP_COMPRESSION_PIZ:
    case GP_COMPRESSION_B44:
    case GP_COMPRESSION_B44A:
    case GP_COMPRESSION_DWAA:
        return 32;
    case GP_COMPRESSION_DWAB:
        return 256;
    default:
        return 1;
    }
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

/* Packs the rows [y0, y1) as EXR stores them before compression: row by row,
 * channel by channel, into `to`, or only counts when `to` is NULL.
 *
 *   clamped  grows by the finite values that half cannot hold; B44 can hold
 *            none below -32752
 *
 * Returns the number of bytes, always even. */
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
            const size_t before = at;
            at += n * size;
            if (!to)
                continue;
            uint8_t *const row = to + before;
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

/* -- OpenEXRCore's compressors: RLE, PIZ, PXR24, B44, B44A -------------------
 *
 * The library ties them to a file that it writes itself. Here each thread gives
 * them one that goes nowhere, and takes the compressed bytes. */

struct worker { // of one thread
    uint8_t *raw, *scratch;            // of ZIP
    struct libdeflate_compressor *zip; // of ZIP
    exr_context_t ctxt;                // of the library
    exr_encode_pipeline_t pipe;
    bool started; // pipe is initialised
    const struct gp_exr_image *img;
    int y0, y1;   // of the chunk under way
    long long *clamped;
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
    const struct worker *const w = pipe->encoding_user_data;
    size_t room = 0;
    for (int c = 0; c < pipe->channel_count; c++) {
        const exr_coding_channel_info_t *i = &pipe->channels[c];
        room += (size_t) i->width * (size_t) i->height *
                (size_t) i->bytes_per_element;
    }
    // the library's count need not be that of the file layout: 3.1.5 and odd
    // subsampling
    if (pack_rows(w->img, w->y0, w->y1, NULL, NULL) != room)
        return EXR_ERR_INVALID_ARGUMENT;
    pipe->packed_bytes = pack_rows(w->img, w->y0, w->y1, pipe->packed_buffer,
                                   w->clamped);
    return EXR_ERR_SUCCESS;
}

/* Compresses the chunk under way. */
static exr_result_t run_library(struct worker *w)
{
    exr_encode_pipeline_t *const pipe = &w->pipe;
    exr_chunk_info_t chunk;
    exr_result_t r = exr_write_scanline_chunk_info(w->ctxt, 0, w->y0, &chunk);
    if (!r)
        r = w->started ? exr_encoding_update(w->ctxt, 0, &chunk, pipe)
                       : exr_encoding_initialize(w->ctxt, 0, &chunk, pipe);
    if (!r && !w->started) {
        w->started = true;
        for (int c = 0; c < pipe->channel_count; c++) {
            // asked for by the library, not read by pack_for_library()
            pipe->channels[c].encode_from_ptr = (const uint8_t *) w;
            pipe->channels[c].user_pixel_stride = 4;
            pipe->channels[c].user_line_stride = 4;
        }
        r = exr_encoding_choose_default_routines(w->ctxt, 0, pipe);
        pipe->encoding_user_data = w;
        pipe->convert_and_pack_fn = pack_for_library;
        pipe->yield_until_ready_fn = NULL;
        pipe->write_fn = NULL;
    }
    return r ? r : exr_encoding_run(w->ctxt, 0, pipe);
}

/* Opens a file that goes nowhere, with the least header that the library's
 * compressors need. */
static exr_result_t open_library(const struct gp_exr_image *img,
                                 exr_context_t *ctxt)
{
    const struct gp_rect d = img->data;
    const exr_attr_box2i_t window = {.min = {.x = d.x0, .y = d.y0},
                                     .max = {.x = d.x1 - 1, .y = d.y1 - 1}};
    const exr_attr_v2f_t centre = {.x = 0.0f, .y = 0.0f};
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    int part;
    init.error_handler_fn = print_nothing;
    init.alloc_fn = gp_exr_allocate;
    init.free_fn = free;
    init.write_fn = write_nowhere;
    gp_exr_fault_clear();
    exr_result_t r =
        exr_start_write(ctxt, "nowhere", EXR_WRITE_FILE_DIRECTLY, &init);
    if (!r)
        r = exr_set_longname_support(*ctxt, 1);
    if (!r)
        r = exr_add_part(*ctxt, "part", EXR_STORAGE_SCANLINE, &part);
    if (!r)
        r = exr_initialize_required_attr(*ctxt, part, &window, &window, 1.0f,
            &centre, 1.0f, EXR_LINEORDER_INCREASING_Y,
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

struct slot { // one compressed chunk of the batch
    size_t size;
    long long clamped;
};

struct batch {
    const struct gp_exr_image *img;
    int rows;           // of a chunk
    size_t chunk_bytes; // most that a chunk has before compression
    struct worker *worker;
    int workers;
    struct slot *slot;
    uint8_t *bytes;     // chunk_bytes for each slot
    int slots;
    int first;          // chunk of slot 0
};

static gp_status encode_chunk(void *ctx, int i, int thread)
{
    struct batch *b = ctx;
    struct worker *w = &b->worker[thread];
    struct slot *s = &b->slot[i];
    uint8_t *const to = b->bytes + (size_t) i * b->chunk_bytes;
    const struct gp_rect r = b->img->data;
    s->clamped = 0;
    w->clamped = &s->clamped;
    w->y0 = r.y0 + (b->first + i) * b->rows;
    w->y1 = b->rows < r.y1 - w->y0 ? w->y0 + b->rows : r.y1;
    if (w->zip) {
        const size_t n = pack_rows(b->img, w->y0, w->y1, w->raw, &s->clamped);
        s->size = gp_exr_zip(w->zip, w->raw, n, w->scratch, to);
        if (s->size == 0) {
            memcpy(to, w->raw, n);
            s->size = n;
        }
    } else if (w->ctxt) {
        gp_exr_fault_clear();
        if (run_library(w))
            return gp_exr_fault() ? gp_exr_fault() : GP_ERR_USAGE;
        // a chunk that did not shrink is stored as it is, and readers know
        // such a chunk by its size; 3.1.5 forgets that for the equal
        // size
        const exr_encode_pipeline_t *p = &w->pipe;
        const bool stored = p->compressed_bytes >= p->packed_bytes;
        s->size = stored ? (size_t) p->packed_bytes : p->compressed_bytes;
        memcpy(to, stored ? p->packed_buffer : p->compressed_buffer,
               s->size);
    } else {
        s->size = pack_rows(b->img, w->y0, w->y1, to, &s->clamped);
    }
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

static gp_status start_worker(const struct gp_log *log, const char *path,
                              const struct batch *b, struct worker *w)
{
    gp_status st = GP_OK;
    w->img = b->img;
    switch (b->img->compression) {
    case GP_COMPRESSION_NONE:
        break;
    case GP_COMPRESSION_ZIP:
    case GP_COMPRESSION_ZIPS:
        GP_TRY(gp_alloc(log, "EXR chunks", b->chunk_bytes, 1, &w->raw));
        GP_TRY(gp_alloc(log, "EXR chunks", b->chunk_bytes, 1, &w->scratch));
        w->zip = libdeflate_alloc_compressor(ZIP_LEVEL);
        if (!w->zip)
            GP_TRY(gp_no_memory_bare(log, "EXR compressor"));
        break;
    default:
        if (open_library(b->img, &w->ctxt))
            st = refused(log, path, gp_exr_fault());
    }
out:
    return st;
}

static void stop_batch(struct batch *b)
{
    for (int i = 0; b->worker && i < b->workers; i++) {
        struct worker *const w = &b->worker[i];
        gp_free(w->raw);
        gp_free(w->scratch);
        if (w->zip)
            libdeflate_free_compressor(w->zip);
        if (w->started)
            exr_encoding_destroy(w->ctxt, &w->pipe);
        if (w->ctxt)
            exr_finish(&w->ctxt);
    }
    gp_free(b->worker);
    gp_free(b->slot);
    gp_free(b->bytes);
}

/* The caller calls stop_batch() in any case. */
static gp_status start_batch(const struct gp_log *log, const char *path,
                             const struct gp_exr_image *img, struct batch *b)
{
    gp_status st;
    *b = (struct batch) {
        .img = img, .rows = chunk_rows(img->compression),
        .workers = gp_threads(),
    };
    for (int i = 0; i < img->sources; i++)
        b->chunk_bytes += (size_t) img->source[i].columns *
                          gp_type_size(img->source[i].type);
    b->chunk_bytes *= (size_t) b->rows;
    if (b->chunk_bytes > INT_MAX)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %d rows of this frame are more than an EXR chunk "
                       "may hold; use --compression zips", path, b->rows);
    const size_t most = batch_bytes / (b->chunk_bytes + 1) + 1;
    b->slots = b->workers * CHUNKS_A_THREAD;
    if ((size_t) b->slots > most) // at least one a thread all the same
        b->slots = most > (size_t) b->workers ? (int) most : b->workers;
    if (b->slots > gp_exr_chunk_count(img))
        b->slots = gp_exr_chunk_count(img);
    GP_TRY(gp_alloc_zero(log, "EXR threads", (size_t) b->workers,
                         sizeof *b->worker, &b->worker));
    GP_TRY(gp_alloc_zero(log, "EXR chunks", (size_t) b->slots, sizeof *b->slot,
                         &b->slot));
    GP_TRY(gp_alloc(log, "EXR chunks", (size_t) b->slots, b->chunk_bytes,
                    &b->bytes));
    for (int i = 0; i < b->workers; i++)
        GP_TRY(start_worker(log, path, b, &b->worker[i]));
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
    const struct gp_exr_image *img, float quality, struct gp_write_stats *stats)
{
    const struct gp_log *const log = out->log;
    const char *const path = gp_file_path(out->file);
    const size_t n = (size_t) img->sources;
    const int units = (int) quality; // by halves: no locale's decimal comma
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
             (int) ((quality - (float) units) * 1000.0f));
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
    GP_TRY(interleave(log, path, img, step, &pixels, &stats->clamped));
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
    GP_TRY(gp_exr_out_copy(out, part, path, file, 0));
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
    const struct gp_exr_image *img, float quality, struct gp_write_stats *stats)
{
    struct batch b;
    gp_status st;
    const char *path = gp_file_path(out->file);
    if (img->compression == GP_COMPRESSION_DWAA ||
        img->compression == GP_COMPRESSION_DWAB)
        return encode_dwa(out, part, img, quality, stats);
    const int chunks = gp_exr_chunk_count(img);
    GP_TRY(start_batch(out->log, path, img, &b));
    for (; b.first < chunks; b.first += b.slots) {
        const int left = chunks - b.first;
        const int n = left < b.slots ? left : b.slots;
        st = gp_parallel(n, encode_chunk, &b, NULL);
        if (st)
            GP_TRY(refused(out->log, path, st));
        for (int i = 0; i < n; i++) {
            const struct slot *s = &b.slot[i];
            const int index = b.first + i;
            GP_TRY(gp_exr_out_scanlines(out, part, index,
                   img->data.y0 + index * b.rows,
                   b.bytes + (size_t) i * b.chunk_bytes, s->size));
            stats->clamped += s->clamped;
        }
    }
out:
    stop_batch(&b);
    return st;
}
