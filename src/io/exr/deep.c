/* The samples of a deep part, whose chunks the library finds.
 *
 * A chunk (openexr file layout, "Deep Scan Line" and "Deep Tiled") has a count
 * table, for each row the samples up to and with each pixel, then the samples,
 * row by row, channel by channel, pixel by pixel. Each of both is compressed by
 * itself, or stored where that does not shrink it. Deep parts are compressed
 * by RLE, ZIPS or not at all.
 *
 * Not expanded by OpenEXRCore: damaged counts make 3.1.5 write out of its
 * buffers (CVE-2023-5841). From 3.1.12 and 3.2.2 on it can have this file's
 * place. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "core/half.h"

#include <libdeflate.h>
#include <string.h>

struct deep {
    const struct gp_log *log;
    struct gp_exr_deep *out;
    struct libdeflate_decompressor *inflate;
    uint8_t *bytes; // of a table or of samples; packed, and half expanded
    size_t room;    // bytes of each of these three
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

static gp_status check_part(const struct deep *d)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    for (int i = 0; i < l->channel->num_channels; i++) {
        const exr_attr_chlist_entry_t *const e = &l->channel->entries[i];
        if (e->x_sampling != 1 || e->y_sampling != 1)
            return gp_fail(d->log, GP_ERR_DATA,
                           "%s: deep channel %s is subsampled; write the file "
                           "without subsampling", l->path, e->name.str);
    }
    if (l->compression > EXR_COMPRESSION_ZIPS)
        return gp_fail(d->log, GP_ERR_DATA,
                       "%s: deep data has a compression that deep data cannot "
                       "have (number %d); write it as zips", l->path,
                       (int) l->compression);
    return GP_OK;
}

/* The pixels of chunk `i` in the data window. */
static struct gp_rect pixels_of(const struct gp_exr_chunks *l, int i)
{
    const int across = (l->w - 1) / l->tile_w + 1;
    const int x = i % across * l->tile_w, y = i / across * l->tile_h;
    return (struct gp_rect) {x, y, x + gp_min(l->tile_w, l->w - x),
                             y + gp_min(l->tile_h, l->h - y)};
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
        GP_FREE(d->bytes);
        GP_TRY(gp_alloc(d->log, l->path, size, 3, &d->bytes));
        d->room = size;
    }
    uint8_t *const from_file = d->bytes + d->room;
    if (gp_exr_read_bytes(&l->input->stream, stored ? d->bytes : from_file,
                          packed, from) != (int64_t) packed)
        return damaged(d, chunk, "it cannot be read");
    if (!stored &&
        !gp_exr_unzip(d->inflate, l->compression == EXR_COMPRESSION_RLE,
                      from_file, packed, from_file + d->room, d->bytes, size))
        return damaged(d, chunk, "it does not expand to its size");
    return GP_OK;
out:
    return st;
}

/* Reads the count table of a chunk into first[pixel + 1]. */
static gp_status read_counts(struct deep *d, int chunk)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const exr_chunk_info_t *const c = &l->chunk[chunk];
    const struct gp_rect b = pixels_of(l, chunk);
    gp_status st = read_bytes(d, chunk, c->sample_count_data_offset,
                              c->sample_count_table_size,
                              (uint64_t) gp_rect_w(b) *
                                  (uint64_t) gp_rect_h(b) * sizeof(int32_t));
    const uint8_t *from = d->bytes;
    for (int y = b.y0; y < b.y1 && !st; y++) {
        int64_t *const to = d->out->first + (int64_t) y * l->w + 1;
        int32_t before = 0, up_to;
        for (int x = b.x0; x < b.x1; x++, before = up_to) {
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
static gp_status read_samples(struct deep *d, int chunk)
{
    const struct gp_exr_chunks *const l = &d->out->part;
    const exr_chunk_info_t *const c = &l->chunk[chunk];
    const struct gp_rect b = pixels_of(l, chunk);
    const int channels = l->channel->num_channels;
    uint64_t size = 0, a_sample = 0;
    for (int i = 0; i < channels; i++)
        a_sample += gp_type_size(gp_exr_pixel_type(
            l->channel->entries[i].pixel_type));
    for (int y = b.y0; y < b.y1; y++) {
        const int64_t *const first = d->out->first + (int64_t) y * l->w;
        size += (uint64_t) (first[b.x1] - first[b.x0]) * a_sample;
    }
    if (size != c->unpacked_size)
        return damaged(d, chunk, "its counts are not those of its samples");
    gp_status st = read_bytes(d, chunk, c->data_offset, c->packed_size, size);
    const uint8_t *from = d->bytes;
    for (int y = b.y0; y < b.y1 && !st; y++) {
        const int64_t *const first = d->out->first + (int64_t) y * l->w;
        const size_t n = (size_t) (first[b.x1] - first[b.x0]);
        for (int i = 0; i < channels && n; i++) {
            const enum gp_pixel_type type =
                gp_exr_pixel_type(l->channel->entries[i].pixel_type);
            float *const to = (float *) d->out->sample[i] + first[b.x0];
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
    gp_status st;
    *out = (struct gp_exr_deep) {0};
    GP_TRY(gp_exr_chunks_any(log, path, in, part, max_pixels, l));
    GP_TRY(check_part(&d));
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
