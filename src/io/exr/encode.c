#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/half.h"

#include <libdeflate.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* Chunks that are compressed before the batch is written. More a thread
 * means less waiting for the slowest; memory is bounded beside it. */
enum { CHUNKS_A_THREAD = 16 };
static const size_t batch_bytes = (size_t) 64 << 20;

static int by_name(const void *a, const void *b)
{
    const struct gp_exr_source *p = a, *q = b;
    return strcmp(p->name, q->name);
}

void gp_exr_sort(struct gp_exr_source *source, int sources)
{
    qsort(source, (size_t) sources, sizeof *source, by_name);
}

int gp_exr_chunk_rows(enum gp_compression compression)
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
    const int rows = gp_exr_chunk_rows(img->compression);
    return (gp_rect_h(img->data) + rows - 1) / rows;
}

/* Row y of the window as a row of the channel's grid. */
static size_t grid_row(int y, int y0, int step)
{
    const int first = y0 + (step - y0 % step) % step % step;
    return (size_t) ((y - first) / step);
}

/* B44 counts each 4x4 block down from its largest value in steps of up to 2048
 * codes, to the nearest: its least one may land 1024 codes lower. From -32752
 * on that is still a number; -65504 came back as -Inf, or NaN. */
enum { B44_LEAST = 0xf7ff, MINUS_INF = 0xfc00 };

/* A row of halfs within that range. Values beyond -65504 are counted before. */
static void limit_b44(const float *from, uint16_t *to, size_t n,
                      long long *clamped)
{
    for (size_t i = 0; i < n; i++) {
        if (to[i] > B44_LEAST && to[i] < MINUS_INF) {
            *clamped += from[i] > -65520.0f;
            to[i] = B44_LEAST;
        }
    }
}

/* One row of one channel; returns its bytes. */
static size_t pack_row(const struct gp_exr_source *s, size_t row, bool b44,
                       uint8_t *to, long long *clamped)
{
    const size_t n = (size_t) s->columns, size = gp_type_size(s->type);
    if (!to)
        return n * size;
    if (s->plane && s->type == GP_HALF) {
        const float *const from = s->plane + row * n;
        *clamped += (long long) gp_float_to_half(from, (uint16_t *) to, n);
        if (b44)
            limit_b44(from, (uint16_t *) to, n, clamped);
    } else if (s->plane)
        memcpy(to, s->plane + row * n, n * size);
    else
        memcpy(to, (const uint8_t *) s->data + row * n * size, n * size);
    return n * size;
}

size_t gp_exr_pack(const struct gp_exr_image *img, int y0, int y1, uint8_t *to,
                   long long *clamped)
{
    const bool b44 = img->compression == GP_COMPRESSION_B44 ||
                     img->compression == GP_COMPRESSION_B44A;
    size_t n = 0;
    for (int y = y0; y < y1; y++) {
        for (int i = 0; i < img->sources; i++) {
            const struct gp_exr_source *s = &img->source[i];
            if (y % s->ys != 0)
                continue;
            n += pack_row(s, grid_row(y, img->data.y0, s->ys), b44,
                          to ? to + n : NULL, clamped);
        }
    }
    return n;
}

// -- chunks in parallel -------------------------------------------------------

struct worker {             // of one thread
    uint8_t *raw, *scratch;
    struct libdeflate_compressor *zip;
    struct gp_exr_core *core;
};

struct slot {               // one compressed chunk of the batch
    uint8_t *bytes;
    size_t size;
    long long clamped;
};

struct batch {
    const struct gp_exr_image *img;
    size_t chunk_bytes;     // most that a chunk has before compression
    struct worker *worker;
    int workers;
    struct slot *slot;
    uint8_t *bytes;         // of all slots
    int slots;
    int first;              // chunk of slot 0
};

static void zip_chunk(const struct batch *b, const struct worker *w,
                      struct slot *s, int y0, int y1)
{
    const size_t n = gp_exr_pack(b->img, y0, y1, w->raw, &s->clamped);
    s->size = gp_exr_zip(w->zip, w->raw, n, w->scratch, s->bytes);
    if (s->size == 0) {
        memcpy(s->bytes, w->raw, n);
        s->size = n;
    }
}

static gp_status encode_chunk(void *ctx, int i, int thread)
{
    struct batch *b = ctx;
    struct worker *w = &b->worker[thread];
    struct slot *s = &b->slot[i];
    const struct gp_rect r = b->img->data;
    const int rows = gp_exr_chunk_rows(b->img->compression);
    const int y0 = r.y0 + (b->first + i) * rows;
    const int y1 = rows < r.y1 - y0 ? y0 + rows : r.y1;
    s->clamped = 0;
    if (b->img->compression == GP_COMPRESSION_NONE) {
        s->size = gp_exr_pack(b->img, y0, y1, s->bytes, &s->clamped);
    } else if (w->zip) {
        zip_chunk(b, w, s, y0, y1);
    } else {
        const void *bytes;
        gp_status st = gp_exr_core_run(w->core, y0, y1, &bytes, &s->size,
                                       &s->clamped);
        if (st)
            return st;
        memcpy(s->bytes, bytes, s->size);
    }
    return GP_OK;
}

static gp_status alloc_bytes(const struct gp_log *log, size_t n, uint8_t **out)
{
    void *mem;
    gp_status st = gp_alloc(log, "EXR chunks", n, 1, &mem);
    *out = mem;
    return st;
}

/* `st` is that of a compressor; what is no full memory is a refusal. */
static gp_status refused(const struct gp_log *log, const char *path,
                         gp_status st)
{
    if (st == GP_ERR_BUG)
        return gp_exr_fault_print(log, path, st);
    return gp_fail(log, GP_ERR_USAGE,
                   "%s: OpenEXR cannot put these channels into this "
                   "compression (names or subsampling); use --compression "
                   "zip", path);
}

static gp_status start_worker(const struct gp_log *log, const char *path,
                              const struct batch *b, struct worker *w)
{
    const enum gp_compression c = b->img->compression;
    if (c == GP_COMPRESSION_NONE)
        return GP_OK;
    if (c != GP_COMPRESSION_ZIP && c != GP_COMPRESSION_ZIPS) {
        gp_exr_fault_clear();
        w->core = gp_exr_core_new(b->img);
        return w->core ? GP_OK : refused(log, path, gp_exr_fault());
    }
    gp_status st = alloc_bytes(log, b->chunk_bytes, &w->raw);
    if (!st)
        st = alloc_bytes(log, b->chunk_bytes, &w->scratch);
    if (!st) {
        w->zip = gp_exr_zip_compressor();
        st = w->zip ? GP_OK : gp_fail_bare(log, GP_ERR_BUG,
                                           "EXR compressor: out of memory");
    }
    return st;
}

static void stop(struct batch *b)
{
    for (int i = 0; b->worker && i < b->workers; i++) {
        gp_free(b->worker[i].raw);
        gp_free(b->worker[i].scratch);
        if (b->worker[i].zip)
            libdeflate_free_compressor(b->worker[i].zip);
        gp_exr_core_free(b->worker[i].core);
    }
    gp_free(b->worker);
    gp_free(b->slot);
    gp_free(b->bytes);
}

static gp_status start(const struct gp_log *log, const char *path,
                       const struct gp_exr_image *img, struct batch *b)
{
    gp_status st;
    void *mem;
    *b = (struct batch) {.img = img};
    for (int i = 0; i < img->sources; i++)
        b->chunk_bytes += (size_t) img->source[i].columns *
                          gp_type_size(img->source[i].type);
    b->chunk_bytes *= (size_t) gp_exr_chunk_rows(img->compression);
    if (b->chunk_bytes > INT_MAX)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %d rows of this frame are more than an EXR chunk "
                       "may hold; use --compression zips", path,
                       gp_exr_chunk_rows(img->compression));
    const size_t most = batch_bytes / (b->chunk_bytes + 1) + 1;
    b->workers = gp_threads();
    b->slots = b->workers * CHUNKS_A_THREAD;
    if ((size_t) b->slots > most) // at least one a thread all the same
        b->slots = most > (size_t) b->workers ? (int) most : b->workers;
    if (b->slots > gp_exr_chunk_count(img))
        b->slots = gp_exr_chunk_count(img);
    GP_TRY(gp_alloc_zero(log, "EXR threads", (size_t) b->workers,
                         sizeof *b->worker, &mem));
    b->worker = mem;
    GP_TRY(gp_alloc_zero(log, "EXR chunks", (size_t) b->slots, sizeof *b->slot,
                         &mem));
    b->slot = mem;
    GP_TRY(alloc_bytes(log, (size_t) b->slots * b->chunk_bytes, &b->bytes));
    for (int i = 0; i < b->slots; i++)
        b->slot[i].bytes = b->bytes + (size_t) i * b->chunk_bytes;
    for (int i = 0; i < b->workers; i++)
        GP_TRY(start_worker(log, path, b, &b->worker[i]));
    return GP_OK;
out:
    return st; // the caller calls stop() in any case
}

static gp_status write_batch(struct gp_exr_out *out, int part,
                             const struct batch *b, int n,
                             struct gp_write_stats *stats)
{
    const int rows = gp_exr_chunk_rows(b->img->compression);
    for (int i = 0; i < n; i++) {
        const struct slot *s = &b->slot[i];
        const int index = b->first + i;
        const int y = b->img->data.y0 + index * rows;
        gp_status st = gp_exr_out_scanlines(out, part, index, y, s->bytes,
                                            s->size);
        if (st)
            return st;
        stats->clamped += s->clamped;
    }
    return GP_OK;
}

gp_status gp_exr_encode(struct gp_exr_out *out, int part,
                        const struct gp_exr_image *img, float quality,
                        struct gp_write_stats *stats)
{
    struct batch b;
    gp_status st;
    const char *path = gp_file_path(out->file);
    if (img->compression == GP_COMPRESSION_DWAA ||
        img->compression == GP_COMPRESSION_DWAB)
        return gp_exr_encode_dwa(out, part, img, quality, stats);
    const int chunks = gp_exr_chunk_count(img);
    GP_TRY(start(out->log, path, img, &b));
    for (; b.first < chunks; b.first += b.slots) {
        const int left = chunks - b.first;
        const int n = left < b.slots ? left : b.slots;
        st = gp_parallel(n, encode_chunk, &b, NULL);
        if (st)
            GP_TRY(refused(out->log, path, st));
        GP_TRY(write_batch(out, part, &b, n, stats));
    }
out:
    stop(&b);
    return st;
}
