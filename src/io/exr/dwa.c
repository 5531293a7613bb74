/* DWAA and DWAB: the bridge writes an EXR in memory with the same channels,
 * and its chunks are taken over as they are. */
#include "io/exr/exr_priv.h"

#include "core/memory.h"
#include "io/half.h"
#include "io/oiio/oiio.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

/* `n` samples of `size` bytes from a row to every `step` bytes of `to`. */
static void scatter(const void *row, size_t n, size_t size, uint8_t *to,
                    size_t step)
{
    const uint8_t *from = row;
    for (size_t i = 0; i < n; i++)
        memcpy(to + i * step, from + i * size, size);
}

/* DWA stores halfs, floats too, and its loss moves values near the end of
 * their range up to Inf: a sun of 65504 came back as Inf. An eighth below the
 * end nothing did. */
static const float DWA_MAX = 57344.0f;

/* One row of a plane within that range, to `row`; returns how many were not. */
static size_t limit_row(const float *from, size_t n, float *row)
{
    size_t over = 0;
    for (size_t i = 0; i < n; i++) {
        const bool large = fabsf(from[i]) > DWA_MAX;
        row[i] = large ? copysignf(DWA_MAX, from[i]) : from[i];
        over += large;
    }
    return over;
}

/* All rows of one channel into their place in the pixels. `row` is scratch
 * for one row of floats and one of halfs. */
static void interleave(const struct gp_exr_source *s, size_t rows,
                       float *row, uint8_t *to, size_t step,
                       struct gp_write_stats *stats)
{
    const size_t n = (size_t) s->columns, size = gp_type_size(s->type);
    for (size_t y = 0; y < rows; y++, to += n * step) {
        const void *from = (const uint8_t *) s->data + y * n * size;
        if (s->plane) {
            stats->clamped +=
                (long long) limit_row(s->plane + y * n, n, row);
            from = row;
        }
        if (s->plane && s->type == GP_HALF) {
            uint16_t *const half = (uint16_t *) (row + n);
            gp_float_to_half(row, half, n); // all within its range
            from = half;
        }
        scatter(from, n, size, to, step);
    }
}

/* Pixels as the bridge wants them; *types has room for every channel. */
static gp_status make_pixels(const struct gp_log *log,
                             const struct gp_exr_image *img, const char **names,
                             int *types, struct gp_shared *pixels,
                             struct gp_write_stats *stats)
{
    const size_t w = (size_t) gp_rect_w(img->data);
    const size_t h = (size_t) gp_rect_h(img->data);
    void *row = NULL;
    size_t step = 0, at = 0;
    for (int i = 0; i < img->sources; i++)
        step += gp_type_size(img->source[i].type);
    gp_status st = gp_shared_make(log, "DWA pixels", w * h * step, pixels);
    if (!st)
        st = gp_alloc(log, "DWA row", w, sizeof(float) + sizeof(uint16_t), &row);
    for (int i = 0; !st && i < img->sources; i++) {
        const struct gp_exr_source *s = &img->source[i];
        names[i] = s->name;
        types[i] = (int) s->type;
        interleave(s, h, row, (uint8_t *) pixels->at + at, step, stats);
        at += gp_type_size(s->type);
    }
    gp_free(row);
    return st;
}

static gp_status lost(const struct gp_exr_out *out, int chunk)
{
    const gp_status fault = gp_exr_fault();
    if (fault)
        return gp_exr_fault_print(out->log, gp_file_path(out->file), fault);
    return gp_fail(out->log, GP_ERR_BUG, "%s: DWA chunk %d was not made",
                   gp_file_path(out->file), chunk);
}

/* The chunks of the only part of `from`, to part `part` of `out`. */
static gp_status take_chunks(struct gp_exr_out *out, int part,
                             const struct gp_input *from)
{
    const char *const path = gp_file_path(out->file);
    struct gp_exr_chunks cs;
    void *data = NULL;
    gp_status st;
    GP_TRY(gp_exr_chunks_find(out->log, path, from, 0, LLONG_MAX, &cs));
    for (int i = 0; i < cs.chunks && i < out->table[part].chunks; i++) {
        const exr_chunk_info_t *c = &cs.chunk[i];
        GP_FREE(data);
        GP_TRY(gp_alloc(out->log, "chunk", c->packed_size, 1, &data));
        gp_exr_fault_clear();
        if (exr_read_chunk(from->exr, 0, c, data))
            GP_TRY(lost(out, i));
        GP_TRY(gp_exr_out_scanlines(out, part, i, c->start_y, data,
                                    c->packed_size));
    }
out:
    gp_free(data);
    gp_exr_chunks_free(&cs);
    return st;
}

static gp_status encode(const struct gp_log *log, const char *path,
                        const struct gp_exr_image *img, float quality,
                        const char *const *names, const int *types,
                        const struct gp_shared *pixels,
                        struct gp_stream *stream)
{
    const struct gp_rect r = img->data;
    char compression[32];
    const int whole = (int) quality; // by halves: no locale's decimal comma
    snprintf(compression, sizeof compression, "%s:%d.%03d",
             img->compression == GP_COMPRESSION_DWAA ? "dwaa" : "dwab", whole,
             (int) ((quality - (float) whole) * 1000.0f));
    const struct gp_image image = {
        .path = path, .data = r, .display = r, .channels = img->sources,
        .channel_name = names, .colour_space = "",
    };
    return gp_oiio_write(log, &image, types, pixels, "exr", "half",
                         compression, stream);
}

/* The library writes another compression where it does not trust its own. */
static gp_status check_made(const struct gp_exr_out *out,
                            const struct gp_exr_image *img,
                            const struct gp_input *made)
{
    exr_compression_t c;
    if (exr_get_compression(made->exr, 0, &c) ||
        (int) c != (int) img->compression)
        return gp_fail(out->log, GP_ERR_BUG,
                       "%s: OpenImageIO writes these channels in another "
                       "compression than DWA; use --compression zip",
                       gp_file_path(out->file));
    return GP_OK;
}

gp_status gp_exr_encode_dwa(struct gp_exr_out *out, int part,
                            const struct gp_exr_image *img, float quality,
                            struct gp_write_stats *stats)
{
    gp_status st;
    void *names = NULL, *types = NULL;
    struct gp_shared pixels = {0};
    struct gp_stream stream = GP_STREAM_EMPTY;
    struct gp_input *made = NULL;
    const char *path = gp_file_path(out->file);
    const size_t n = (size_t) img->sources;
    for (int i = 0; i < img->sources; i++) {
        if (img->source[i].xs != 1 || img->source[i].ys != 1)
            return gp_fail(out->log, GP_ERR_USAGE,
                           "%s: channel %s is subsampled, which DWA "
                           "compression cannot hold here; use --compression "
                           "zip", path, img->source[i].name);
    }
    GP_TRY(gp_alloc(out->log, path, n, sizeof(char *), &names));
    GP_TRY(gp_alloc(out->log, path, n, sizeof(int), &types));
    GP_TRY(make_pixels(out->log, img, names, types, &pixels, stats));
    GP_TRY(encode(out->log, path, img, quality, names, types, &pixels,
                  &stream));
    GP_TRY(gp_exr_open(out->log, path, &stream, &made));
    GP_TRY(check_made(out, img, made));
    GP_TRY(take_chunks(out, part, made));
out:
    gp_input_free(made);
    gp_stream_close(&stream);
    gp_shared_free(&pixels);
    gp_free(types);
    gp_free(names);
    return st;
}
