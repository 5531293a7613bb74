// SPDX-License-Identifier: Apache-2.0
/* Formats of plain samples: raw frames, and the portable float map.
 *
 * PFM, by P. Debevec: "PF" for three floats a pixel or "Pf" for one, width,
 * height, and a scale, which is negative where the floats are little-endian;
 * one white space; rows from the bottom. As netpbm's readers do, multiplies
 * samples by the scale. */
#include "core/bytes.h"
#include "core/memory.h"
#include "io/file.h"
#include "io/io_priv.h"

#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HEADER_BYTES = 64 }; // at most

struct header {
    int width, height, channels;
    float scale;
    uint64_t bytes;           // before the first row
};

/* Returns false when the bytes are no header. */
static bool parse_header(const uint8_t *data, size_t size, struct header *h)
{
    char text[HEADER_BYTES] = "", *at = text;
    if (size < 3)
        return false;
    memcpy(text, data + 2, size - 2 < sizeof text ? size - 2 : sizeof text - 1);
    const long width = strtol(at, &at, 10), height = strtol(at, &at, 10);
    const float scale = strtof(at, &at);
    if (width < 1 || height < 1 || width > INT_MAX || height > INT_MAX ||
        !isfinite(scale) || scale == 0.0f || !*at ||
        !strchr(" \t\n\v\f\r", *at))
        return false;
    *h = (struct header) {
        (int) width, (int) height, data[1] == 'F' ? 3 : 1, scale,
        2 + (uint64_t) (at - text) + 1,
    };
    return true;
}

/* Checks that all rows are in `size` bytes. */
static bool holds_rows(const struct header *h, uint64_t size)
{
    const uint64_t row = (uint64_t) h->width * (uint64_t) h->channels * 4;
    return h->bytes <= size && (size - h->bytes) / row >= (uint64_t) h->height;
}

gp_status gp_pfm_length(struct gp_stream *stream, uint64_t *length)
{
    uint8_t first[HEADER_BYTES];
    struct header h;
    const int64_t n = gp_stream_read(stream, first, sizeof first, 0);
    if (n > 0 && parse_header(first, (size_t) n, &h) &&
        holds_rows(&h, stream->size))
        *length = h.bytes + (uint64_t) h.width * (uint64_t) h.height *
                                (uint64_t) h.channels * 4;
    return GP_OK;
}

// -- reading PFM --------------------------------------------------------------

static gp_status read_rows(const struct gp_log *log, const char *path,
    const struct gp_stream *stream, const struct header *h, float *to)
{
    const size_t n = (size_t) h->width * (size_t) h->channels;
    const bool little = __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__;
    const bool swap = (h->scale < 0.0f) != little;
    const float scale = fabsf(h->scale);
    for (int y = 0; y < h->height; y++, to += n) {
        const uint64_t row = (uint64_t) (h->height - 1 - y);
        const int64_t got = gp_stream_read(stream, to, 4 * n,
                                           h->bytes + row * 4 * n);
        if (got < 0)
            return gp_stream_failed(log, path);
        if ((uint64_t) got < 4 * n)
            return gp_fail(log, GP_ERR_DATA, "%s: truncated (row %d); copy or "
                           "render the file again", path, y);
        for (size_t i = 0; i < n && swap; i++) {
            const uint32_t turned = __builtin_bswap32(gp_bits_of(to[i]));
            memcpy(&to[i], &turned, sizeof turned); // a NaN too
        }
        for (size_t i = 0; i < n && scale != 1.0f; i++)
            to[i] *= scale;
    }
    return GP_OK;
}

gp_status gp_pfm_open(const struct gp_log *log, const char *path,
                      const struct gp_stream *stream, long long max_pixels,
                      struct gp_decoded *out)
{
    static const char *const grey[] = {"Y"}, *const rgb[] = {"R", "G", "B"};
    uint8_t first[HEADER_BYTES] = {0};
    struct header h;
    float *pixels;
    const int64_t n = gp_stream_read(stream, first, sizeof first, 0);
    if (n < 0)
        return gp_stream_failed(log, path);
    if (!parse_header(first, (size_t) n, &h))
        return gp_fail(log, GP_ERR_DATA, "%s: damaged PFM header; it must "
                       "begin with PF or Pf, width, height and scale", path);
    gp_status st = gp_window_check(log, path, "data", h.width, h.height,
                                   max_pixels);
    if (!st && !holds_rows(&h, stream->size))
        st = gp_fail(log, GP_ERR_DATA, "%s: truncated (%llu bytes cannot hold "
                     "%d x %d pixels); copy or render the file again", path,
                     (unsigned long long) stream->size, h.width, h.height);
    if (!st)
        st = gp_alloc(log, path, (size_t) h.width * (size_t) h.height,
                      (size_t) h.channels * sizeof *pixels, &pixels);
    if (st)
        return st;
    st = read_rows(log, path, stream, &h, pixels);
    if (st) {
        gp_free(pixels);
        return st;
    }
    const struct gp_rect window = {0, 0, h.width, h.height};
    *out = (struct gp_decoded) {
        .path = path,
        .data = window,
        .display = window,
        .pixel_aspect = 1.0f,
        .channels = h.channels,
        .channel_name = h.channels == 3 ? rgb : grey,
        .colour_space = "",
        .pixels = pixels,
    };
    return GP_OK;
}

// -- writing ------------------------------------------------------------------

/* Writes samples over black: a raw frame of `frames`' size; NULL: a PFM. */
static gp_status write_samples(struct gp_picture_job j, enum gp_raw_format raw,
                               struct gp_raw_size *frames)
{
    gp_status st;
    struct gp_write_params p = *j.p;
    struct gp_picture pic;
    char *bytes = NULL;
    char head[64];
    const size_t sample = raw == GP_RAW_RGB24      ? 1
                          : raw == GP_RAW_RGBF32LE ? 4
                                                   : 2;
    p.depth_bits = sample == 1 ? 8 : 16;
    p.alpha = GP_ALPHA_BLACK;
    j.p = &p;
    GP_TRY(gp_picture_make(&j, &pic));
    if (frames && frames->w &&
        (frames->w != pic.width || frames->h != pic.height))
        GP_TRY(gp_fail(j.log, GP_ERR_DATA,
                       "%s: size differs from the raw frames before (found %d "
                       "x %d after %d x %d); make it in a run of its own",
                       j.f->path ? j.f->path : j.path, pic.width, pic.height,
                       frames->w, frames->h));
    if (frames)
        *frames = (struct gp_raw_size) {pic.width, pic.height};
    const size_t lead =
        frames ? 0
               : (size_t) snprintf(head, sizeof head, "PF\n%d %d\n-1.0\n",
                                   pic.width, pic.height);
    const size_t size = (size_t) pic.width * (size_t) pic.height * 3 * sample;
    GP_TRY(gp_alloc(j.log, "picture", lead + size, 1, &bytes));
    memcpy(bytes, head, lead);
    const struct gp_picture_form samples = {
        .bytes = sample,
        .big = raw == GP_RAW_RGB48BE,
        .from_bottom = !frames,
        .to = bytes + lead,
    };
    GP_TRY(gp_picture_samples(j.log, &pic, &samples));
    st = gp_file_save(j.log, j.path, p.create_dir, p.fsync, bytes, lead + size);
out:
    gp_free(bytes);
    gp_picture_free(&pic);
    return st;
}

gp_status gp_pfm_write(const struct gp_picture_job *j)
{
    return write_samples(*j, GP_RAW_RGBF32LE, NULL);
}

gp_status gp_raw_write(const struct gp_picture_job *j)
{
    return write_samples(*j, j->p->raw, &j->stats->raw);
}
