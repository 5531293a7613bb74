/* The samples of a deep part.
 *
 * A chunk (openexr file layout, "Deep Scan Line" and "Deep Tiled") has a count
 * table, for each row the samples up to and with each pixel, then the samples,
 * row by row, channel by channel, pixel by pixel. Each of both is compressed by
 * itself, or stored where that does not shrink it. Deep parts are compressed
 * by RLE, ZIPS or not at all.
 *
 * Not by OpenEXRCore: damaged counts make 3.1.5 write out of its buffers
 * (CVE-2023-5841). From 3.1.12 and 3.2.2 on it can have this file's place. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/half.h"

#include <libdeflate.h>
#include <string.h>

/* A chunk: its pixels in the data window, and its bytes in the file. */
struct block {
    int x0, y0, w, h;
    uint64_t table, samples; // first bytes of these
    uint64_t table_bytes, sample_bytes, unpacked_bytes;
};

struct deep {
    const struct gp_log *log;
    struct gp_exr_deep *out;
    uint64_t *offset;        // of each chunk
    struct libdeflate_decompressor *inflate;
    uint8_t *packed, *split, *bytes; // of a table or of samples
    size_t room;             // bytes of each of these
};

static gp_status damaged(const struct deep *d, int chunk, const char *why)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    if (gp_exr_fault())
        return gp_exr_fault_print(d->log, l->path, gp_exr_fault());
    return gp_fail(d->log, GP_ERR_DATA,
                   "%s: truncated or damaged (deep part %d, chunk %d of %d: "
                   "%s); copy or render the file again", l->path, l->part,
                   chunk + 1, l->chunks, why);
}

/* Reads the header and the offset table. */
static gp_status read_part(struct deep *d, long long max_pixels)
{
    struct gp_exr_chunks *const l = &d->out->part;
    gp_status st;
    GP_TRY(gp_exr_part_find(d->log, l->path, l->input, l->part, max_pixels, l));
    if (l->lines) {
        l->tile_w = l->w;
        l->tile_h = l->lines;
    }
    for (int i = 0; i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *const e = &l->channel->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return gp_fail(d->log, GP_ERR_DATA,
                           "%s: deep channel %s is subsampled; write the file "
                           "without subsampling", l->path, e->name.str);
    }
    if (l->compression != EXR_COMPRESSION_NONE &&
        l->compression != EXR_COMPRESSION_RLE &&
        l->compression != EXR_COMPRESSION_ZIPS)
        return gp_fail(d->log, GP_ERR_DATA,
                       "%s: deep data has a compression that deep data cannot "
                       "have (number %d); write it as zips", l->path,
                       (int) l->compression);
    GP_TRY(gp_alloc(d->log, l->path, (size_t) l->chunks, sizeof *d->offset,
                    &d->offset));
    if (!gp_exr_offsets_read(l->input, l->part, 0, l->chunks, d->offset))
        st = damaged(d, 0, "its place cannot be read");
out:
    return st;
}

/* Finds chunk `i`, which must be where its number says. */
static gp_status find_block(const struct deep *d, int i, struct block *b)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const int across = (l->w - 1) / l->tile_w + 1;
    const int tx = i % across, ty = i / across;
    const int words = (l->input->index->multi ? 1 : 0) + (l->lines ? 1 : 4);
    const uint64_t end = gp_exr_chunk_bytes(l->input, l->part, d->offset[i]);
    int32_t at[5];
    uint64_t size[3];
    uint8_t leader[sizeof at + sizeof size];
    const size_t lead = (size_t) words * sizeof *at + sizeof size;
    if (end == 0 || d->offset[i] + end > l->input->stream.size ||
        gp_exr_read_bytes(&l->input->stream, leader, lead, d->offset[i]) !=
            (int64_t) lead)
        return damaged(d, i, "it ends after the file");
    memcpy(at, leader, lead - sizeof size);
    memcpy(size, leader + lead - sizeof size, sizeof size);
    const int32_t *const place = at + (l->input->index->multi ? 1 : 0);
    *b = (struct block) {
        .x0 = tx * l->tile_w, .y0 = ty * l->tile_h,
        .table = d->offset[i] + lead, .table_bytes = size[0],
        .samples = d->offset[i] + lead + size[0], .sample_bytes = size[1],
        .unpacked_bytes = size[2],
    };
    b->w = gp_min(l->tile_w, l->w - b->x0);
    b->h = gp_min(l->tile_h, l->h - b->y0);
    const bool right = l->lines ? place[0] == l->y0 + b->y0
                                : place[0] == tx && place[1] == ty &&
                                      place[2] == 0 && place[3] == 0;
    return right ? GP_OK : damaged(d, i, "it is out of place");
}

/* Reads and expands `packed` bytes at `from` into d->bytes, `size` of them. */
static gp_status read_bytes(struct deep *d, int chunk, uint64_t from,
                            uint64_t packed, uint64_t size)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const bool stored = packed == size;
    gp_status st;
    // a byte of DEFLATE is at most 1032, one of RLE at most 64
    if (packed > size || size > (packed + 64) * 1032 || size % 2 ||
        (!stored && l->compression == EXR_COMPRESSION_NONE))
        return damaged(d, chunk, "its size is wrong");
    if (size > d->room) {
        gp_free(d->packed);
        gp_free(d->split);
        gp_free(d->bytes);
        d->packed = d->split = d->bytes = NULL;
        d->room = 0;
        GP_TRY(gp_alloc(d->log, l->path, size, 1, &d->packed));
        GP_TRY(gp_alloc(d->log, l->path, size, 1, &d->split));
        GP_TRY(gp_alloc(d->log, l->path, size, 1, &d->bytes));
        d->room = size;
    }
    if (gp_exr_read_bytes(&l->input->stream, stored ? d->bytes : d->packed,
                          packed, from) != (int64_t) packed)
        return damaged(d, chunk, "it cannot be read");
    if (stored)
        return GP_OK;
    const bool whole = l->compression == EXR_COMPRESSION_RLE
        ? gp_unrle(d->packed, packed, d->split, size)
        : !libdeflate_zlib_decompress(d->inflate, d->packed, packed, d->split,
                                      size, NULL);
    if (!whole)
        return damaged(d, chunk, "it does not expand to its size");
    gp_undo_delta(d->split, size);
    gp_interleave(d->split, d->split + size / 2, d->bytes, size / 2);
    return GP_OK;
out:
    return st;
}

/* Reads the count table of a chunk into first[pixel + 1]. */
static gp_status read_counts(struct deep *d, int chunk, const struct block *b)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const size_t size = (size_t) b->w * (size_t) b->h * sizeof(int32_t);
    gp_status st = read_bytes(d, chunk, b->table, b->table_bytes, size);
    const uint8_t *from = d->bytes;
    for (int y = b->y0; y < b->y0 + b->h && !st; y++) {
        int64_t *const to = d->out->first + (int64_t) y * l->w + b->x0 + 1;
        int32_t before = 0, up_to;
        for (int x = 0; x < b->w; x++, before = up_to) {
            memcpy(&up_to, from, sizeof up_to);
            from += sizeof up_to;
            if (up_to < before)
                return damaged(d, chunk, "its counts are wrong");
            to[x] = up_to - before;
        }
    }
    return st;
}

/* Reads the samples of a chunk; first[] is complete. */
static gp_status read_samples(struct deep *d, int chunk, const struct block *b)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const int64_t *const first = d->out->first;
    const int channels = l->channel->num_channels;
    uint64_t size = 0, a_sample = 0;
    for (int i = 0; i < channels; i++)
        a_sample += gp_type_size(gp_exr_pixel_type(
            l->channel->entries[i].pixel_type));
    for (int y = b->y0; y < b->y0 + b->h; y++) {
        const int64_t at = (int64_t) y * l->w + b->x0;
        size += (uint64_t) (first[at + b->w] - first[at]) * a_sample;
    }
    if (size != b->unpacked_bytes)
        return damaged(d, chunk, "its counts are not those of its samples");
    gp_status st = read_bytes(d, chunk, b->samples, b->sample_bytes, size);
    const uint8_t *from = d->bytes;
    for (int y = b->y0; y < b->y0 + b->h && !st; y++) {
        const int64_t at = (int64_t) y * l->w + b->x0;
        const size_t n = (size_t) (first[at + b->w] - first[at]);
        for (int i = 0; i < channels && n; i++) {
            const enum gp_pixel_type type =
                gp_exr_pixel_type(l->channel->entries[i].pixel_type);
            float *const to = (float *) d->out->sample[i] + first[at];
            if (type == GP_HALF)
                gp_half_to_float((const uint16_t *) (const void *) from, to, n);
            else
                memcpy(to, from, n * sizeof *to);
            from += n * gp_type_size(type);
        }
    }
    return st;
}

gp_status gp_exr_deep_read(const struct gp_log *log, const char *path,
                           const struct gp_input *in, int part,
                           long long max_pixels, struct gp_exr_deep *out)
{
    struct deep d = {.log = log, .out = out};
    struct gp_exr_chunks *const l = &out->part;
    struct block b;
    gp_status st;
    *out = (struct gp_exr_deep) {
        .part = {.input = in, .path = path, .part = part},
    };
    gp_exr_fault_clear();
    GP_TRY(read_part(&d, max_pixels));
    d.inflate = libdeflate_alloc_decompressor();
    if (!d.inflate)
        GP_TRY(gp_no_memory(log, path));
    const size_t pixels = (size_t) l->w * (size_t) l->h;
    const size_t channels = (size_t) l->channel->num_channels;
    GP_TRY(gp_alloc_zero(log, path, pixels + 1, sizeof *out->first,
                         &out->first));
    for (int i = 0; i < l->chunks; i++) {
        GP_TRY(find_block(&d, i, &b));
        GP_TRY(read_counts(&d, i, &b));
    }
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
    for (int i = 0; i < l->chunks; i++) {
        GP_TRY(find_block(&d, i, &b));
        GP_TRY(read_samples(&d, i, &b));
    }
out:
    if (d.inflate)
        libdeflate_free_decompressor(d.inflate);
    gp_free(d.offset);
    gp_free(d.packed);
    gp_free(d.split);
    gp_free(d.bytes);
    return st;
}

void gp_exr_deep_free(struct gp_exr_deep *deep)
{
    for (int i = 0; deep->sample && i < deep->part.channel->num_channels; i++)
        gp_free(deep->sample[i]);
    gp_free(deep->sample);
    gp_free(deep->first);
    *deep = (struct gp_exr_deep) {0};
}
