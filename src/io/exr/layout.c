#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "io/image.h"

#include <limits.h>
#include <string.h>

/* The most bytes that one byte of a chunk can become, by compression, rounded
 * up. DEFLATE: a 2-bit code can stand for 258 bytes, and there is nothing
 * shorter (1032). RLE: 2 bytes for 128. PIZ: a run code of 1 bit and a count
 * of 8 bits give 255 samples of 2 bytes (454). PXR24: DEFLATE, then 3 bytes
 * become 4. B44: 3 bytes for 4x4 halfs. DWA: an 8x8 block of 128 bytes is at
 * least one AC code of 2 bytes in DEFLATE.
 */
static uint64_t most_expansion(exr_compression_t compression)
{
    switch (compression) {
    case EXR_COMPRESSION_NONE:
        return 1;
    case EXR_COMPRESSION_RLE:
        return 64;
    case EXR_COMPRESSION_ZIPS:
    case EXR_COMPRESSION_ZIP:
        return 1032;
    case EXR_COMPRESSION_PIZ:
        return 454;
    case EXR_COMPRESSION_PXR24:
        return 1376;
    case EXR_COMPRESSION_B44:
    case EXR_COMPRESSION_B44A:
        return 11;
    default:
        return 64 * 1032;
    }
}

static gp_status bad_chunk(const struct gp_log *log,
                           const struct gp_exr_chunks *l, int index,
                           const char *what)
{
    const gp_status fault = gp_exr_fault();
    if (fault)
        return gp_exr_fault_print(log, l->path, fault);
    return gp_fail(log, GP_ERR_DATA,
                   "%s: cut off or damaged (chunk %d of %d: %s); copy or "
                   "render the file again", l->path, index + 1, l->chunks,
                   what);
}

/* Unpacked bytes of a chunk, and whether the library divides its rows and
 * columns as the channels' sampling asks. 3.1.5 does not where a block of
 * lines is no multiple of the sampling. */
static bool chunk_size(const struct gp_exr_chunks *l,
                       const exr_chunk_info_t *c, uint64_t *bytes)
{
    *bytes = 0;
    for (int i = 0; i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *e = &l->channel->entries[i];
        int xs = e->x_sampling, ys = e->y_sampling;
        // where the first block's height divides, the others' start does
        if (c->width % xs || (c->height > 1 && c->height % ys))
            return false;
        bool none = c->height == 1 && (c->start_y - l->y0) % ys;
        uint64_t rows = none ? 0 : (uint64_t) (c->height + ys - 1) /
                                       (uint64_t) ys;
        *bytes += rows * (uint64_t) (c->width / xs) *
                  (e->pixel_type == EXR_PIXEL_HALF ? 2 : 4);
    }
    return true;
}

static gp_status check_chunk(const struct gp_log *log,
                             const struct gp_exr_chunks *l, int index)
{
    const exr_chunk_info_t *c = &l->chunk[index];
    uint64_t bytes;
    if (!chunk_size(l, c, &bytes) || bytes != c->unpacked_size)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: channels are subsampled in a way that its blocks "
                       "of lines do not hold (chunk %d); write the file "
                       "without subsampling", l->path, index + 1);
    if (c->packed_size > l->input->stream.size)
        return bad_chunk(log, l, index, "it ends after the file");
    if (l->compression == EXR_COMPRESSION_NONE && c->packed_size != bytes)
        return bad_chunk(log, l, index, "its size is wrong");
    // the 64 are for headers and for the last, unfinished unit
    if (bytes > (c->packed_size + 64) * most_expansion(l->compression))
        return bad_chunk(log, l, index, "it is too small for its pixels");
    return GP_OK;
}

/* Pixels of block `i` of those of `size` that cover `all`. */
static int64_t block_pixels(int all, int size, int i)
{
    const int64_t left = all - (int64_t) i * size;
    return left < size ? left : size;
}

/* The rectangle of a chunk must be the one that its index says: together they
 * cover the window, each pixel once. */
static bool chunk_in_place(const struct gp_exr_chunks *l, int index,
                           const exr_chunk_info_t *c)
{
    if (l->lines) {
        const int64_t is[4] = {c->idx, c->start_y, c->width, c->height};
        const int64_t want[4] = {index, l->y0 + (int64_t) index * l->lines,
                                 l->w, block_pixels(l->h, l->lines, index)};
        return memcmp(is, want, sizeof is) == 0;
    }
    const int across = (l->w - 1) / l->tile_w + 1;
    const int column = index % across, row = index / across;
    const int64_t is[5] = {c->idx, c->start_x, c->start_y, c->width,
                           c->height};
    const int64_t want[5] = {index, column, row,
                             block_pixels(l->w, l->tile_w, column),
                             block_pixels(l->h, l->tile_h, row)};
    return memcmp(is, want, sizeof is) == 0;
}

static gp_status read_chunks(const struct gp_log *log,
                             struct gp_exr_chunks *l)
{
    gp_exr_fault_clear();
    for (int i = 0; i < l->chunks; i++) {
        exr_chunk_info_t *c = &l->chunk[i];
        exr_result_t r = gp_input_chunk(l->input, l->part, i, c);
        if (r)
            return bad_chunk(log, l, i, exr_get_default_error_message(r));
        if (!chunk_in_place(l, i, c))
            return bad_chunk(log, l, i, "it is not where it belongs");
        gp_status st = check_chunk(log, l, i);
        if (st)
            return st;
        if (c->unpacked_size > l->largest)
            l->largest = c->unpacked_size;
    }
    return GP_OK;
}

static gp_status read_window(const struct gp_log *log, long long max_pixels,
                             struct gp_exr_chunks *l)
{
    exr_attr_box2i_t d;
    if (exr_get_data_window(l->input->exr, l->part, &d))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: has no data window; render the file again",
                       l->path);
    const int64_t w = (int64_t) d.max.x - d.min.x + 1;
    const int64_t h = (int64_t) d.max.y - d.min.y + 1;
    const gp_status st = gp_window_check(log, l->path, "data", w, h,
                                         max_pixels);
    if (st)
        return st;
    l->x0 = d.min.x;
    l->y0 = d.min.y;
    l->w = (int) w;
    l->h = (int) h;
    return GP_OK;
}

/* Number of chunks of level 0, which come first in the table. */
static gp_status count_chunks(const struct gp_log *log,
                              struct gp_exr_chunks *l)
{
    const exr_context_t exr = l->input->exr;
    int32_t all = 0, lines = 0;
    int64_t n = 0;
    exr_result_t r = exr_get_chunk_count(exr, l->part, &all);
    if (l->storage == EXR_STORAGE_TILED) {
        uint32_t tw = 0, th = 0;
        exr_tile_level_mode_t mode;
        exr_tile_round_mode_t round;
        if (!r)
            r = exr_get_tile_descriptor(exr, l->part, &tw, &th, &mode, &round);
        if (!r && tw > 0 && th > 0 && tw < INT_MAX && th < INT_MAX) {
            l->tile_w = (int) tw;
            l->tile_h = (int) th;
            n = (((int64_t) l->w + tw - 1) / tw) *
                (((int64_t) l->h + th - 1) / th);
        }
    } else {
        if (!r)
            r = exr_get_scanlines_per_chunk(exr, l->part, &lines);
        if (!r && lines > 0) {
            l->lines = lines;
            n = ((int64_t) l->h + lines - 1) / lines;
        }
    }
    // each chunk has 8 bytes in the offset table, so the file bounds the list
    if (r || n < 1 || n > all || (uint64_t) n > l->input->stream.size / 8)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: cut off or damaged (%d chunks in a file of %llu "
                       "bytes, %lld needed); copy or render the file again",
                       l->path, all,
                       (unsigned long long) l->input->stream.size,
                       (long long) n);
    l->chunks = (int) n;
    return GP_OK;
}

gp_status gp_exr_chunks_find(const struct gp_log *log, const char *path,
                             const struct gp_input *input, int part,
                             long long max_pixels, struct gp_exr_chunks *l)
{
    gp_status st;
    void *list = NULL;
    *l = (struct gp_exr_chunks) {
        .input = input, .path = path, .part = part,
    };
    if (exr_get_storage(input->exr, part, &l->storage) ||
        exr_get_compression(input->exr, part, &l->compression) ||
        exr_get_channels(input->exr, part, &l->channel))
        return gp_fail(log, GP_ERR_DATA,
                       "%s: the EXR header is damaged (part %d lacks "
                       "channels, compression or type); render the file again",
                       path, part);
    if (l->storage != EXR_STORAGE_SCANLINE && l->storage != EXR_STORAGE_TILED)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: deep data has no single colour per pixel (part "
                       "%d); flatten it first, with e.g. oiiotool --flatten",
                       path, part);
    GP_TRY(read_window(log, max_pixels, l));
    GP_TRY(count_chunks(log, l));
    GP_TRY(gp_alloc_zero(log, "chunks", (size_t) l->chunks, sizeof *l->chunk,
                         &list));
    l->chunk = list;
    GP_TRY(read_chunks(log, l));
out:
    return st;
}

void gp_exr_chunks_free(struct gp_exr_chunks *l)
{
    gp_free(l->chunk);
    *l = (struct gp_exr_chunks) {0};
}
