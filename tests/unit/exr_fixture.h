// SPDX-License-Identifier: Apache-2.0
/* Small EXR files for tests, written by OpenEXRCore's own encoder, with
 * samples that a formula gives, so that any reader can be checked. */
#ifndef EXR_FIXTURE_H
#define EXR_FIXTURE_H

#include "unit.h"
#include "core/status.h"

#include <math.h>
#include <openexr.h>
#include <stdbool.h>

enum { FIXTURE_CHANNELS = 12, FIXTURE_PARTS = 3 };

struct fixture_channel {
    const char *name;
    exr_pixel_type_t type;
    int xs, ys;  // 0 counts as 1
};

struct fixture_part {
    const char *name;
    struct fixture_channel channel[FIXTURE_CHANNELS];  // in name order
    exr_attr_box2i_t data;
    exr_compression_t compression;
    int tile;          // 0 scanlines
    bool mipmap, deep; // deep: header and an empty table only
};

struct fixture {
    struct fixture_part part[FIXTURE_PARTS];
    int parts;                  // 0 counts as 1
    bool chromaticities;        // ACES AP0's
    float aspect;               // 0 counts as 1
    exr_attr_box2i_t display;   // empty (all 0): the first data window
    void (*more)(exr_context_t exr, int part);  // adds attributes; NULL: none
};

static const exr_attr_chromaticities_t fixture_ap0 = {
    0.7347f, 0.2653f, 0.0f, 1.0f, 0.0001f, -0.077f, 0.32168f, 0.33767f,
};

#define FIXTURE_WINDOW(x0, y0, w, h)                                          \
    {{.x = (x0), .y = (y0)}, {.x = (x0) + (w) - 1, .y = (y0) + (h) - 1}}

#define W(n) FIXTURE_WINDOW(0, 0, n, n)

/* Channels, for a fixture_part. */
#define HALVES EXR_PIXEL_HALF
#define FLOATS EXR_PIXEL_FLOAT
#define HALF_CH(name) {name, HALVES, 0, 0}
#define FLOAT_CH(name) {name, FLOATS, 0, 0}
#define UINT_CH(name) {name, EXR_PIXEL_UINT, 0, 0}
#define RGB(type)                                                             \
    {"B", type, 0, 0}, {"G", type, 0, 0}, {"R", type, 0, 0}

static const exr_compression_t lossless[] __attribute__((unused)) = {
    EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE, EXR_COMPRESSION_ZIPS,
    EXR_COMPRESSION_ZIP,  EXR_COMPRESSION_PIZ, EXR_COMPRESSION_PXR24,
};
enum { LOSSLESS = sizeof lossless / sizeof *lossless };

static uint32_t fixture_hash(const char *name, int x, int y)
{
    uint32_t h = 2166136261u;
    for (const char *c = name; *c; c++)
        h = (h ^ (uint8_t) *c) * 16777619u;
    h = (h ^ (uint32_t) x) * 16777619u;
    h = (h ^ (uint32_t) y) * 16777619u;
    h ^= h >> 15;
    return h * 2246822519u;
}

/* The sample of a uint channel. Few of its bits vary: OpenEXRCore 3.1.5 makes
 * unreadable chunks of data that zlib neither shrinks nor grows. */
static uint32_t fixture_uint(const char *name, int x, int y)
{
    return fixture_hash(name, x, y) & 0x8100000fu;
}

/* The sample of a half or float channel: exact in half. */
static float fixture_value(const char *name, int x, int y)
{
    return (float) (fixture_hash(name, x, y) >> 26) / 4.0f - 8.0f;
}

static uint16_t fixture_half(float v)
{
    // |v| is 0 or in [1/4, 8] with 6 significant bits: normal and exact
    int e;
    float m = frexpf(fabsf(v), &e);
    unsigned bits = v == 0.0f ? 0
                    : (unsigned) (e + 14) << 10 |
                          ((unsigned) (m * 2048.0f) & 1023u);
    return (uint16_t) (bits | (v < 0.0f ? 0x8000u : 0u));
}

/* The bytes that the writer makes. */
struct fixture_file {
    uint8_t *bytes;
    size_t size, room;
};

static int64_t fixture_write(exr_const_context_t ctxt, void *user,
                             const void *from, uint64_t n, uint64_t at,
                             exr_stream_error_func_ptr_t error)
{
    (void) ctxt;
    (void) error;
    struct fixture_file *f = user;
    if (at + n > f->room) {
        const size_t had = f->room;
        f->room = (size_t) (at + n) * 2;
        f->bytes = realloc(f->bytes, f->room);
        assert_non_null(f->bytes);
        memset(f->bytes + had, 0, f->room - had); // tables of deep parts stay
    }
    if (at + n > f->size)
        f->size = (size_t) (at + n);
    memcpy(f->bytes + at, from, n);
    return (int64_t) n;
}

static void fixture_silent(exr_const_context_t ctxt, exr_result_t code,
                           const char *text)
{
    (void) ctxt;
    (void) code;
    (void) text;
}

/* Samples of a channel for a rectangle of pixels; the caller frees. */
static void *fixture_samples(const struct fixture_channel *c, int x0, int y0,
                             int w, int h)
{
    int xs = c->xs ? c->xs : 1, ys = c->ys ? c->ys : 1;
    size_t size = c->type == EXR_PIXEL_HALF ? 2 : 4;
    uint8_t *all = calloc((size_t) w * (size_t) h + 1, size), *to = all;
    assert_non_null(all);
    for (int y = y0; y < y0 + h; y++) {
        for (int x = x0; x < x0 + w && y % ys == 0; x++) {
            if (x % xs)
                continue;
            uint32_t u = fixture_uint(c->name, x, y);
            float f = fixture_value(c->name, x, y);
            uint16_t half = fixture_half(f);
            if (c->type == EXR_PIXEL_HALF)
                memcpy(to, &half, 2);
            else
                memcpy(to, c->type == EXR_PIXEL_UINT ? (void *) &u
                                                     : (void *) &f, 4);
            to += size;
        }
    }
    return all;
}

/* Encodes one chunk; `pipe` has channels from the first one on. */
static void fixture_chunk(exr_context_t exr, int part,
    const struct fixture_part *p, const exr_chunk_info_t *info,
    exr_encode_pipeline_t *pipe)
{
    const bool first = pipe->channel_count == 0;
    void *data[FIXTURE_CHANNELS] = {0};
    int x0 = p->data.min.x, y0 = info->start_y;
    if (p->tile) {
        x0 += info->start_x * p->tile;
        y0 = p->data.min.y + info->start_y * p->tile;
    }
    assert_ok(first ? exr_encoding_initialize(exr, part, info, pipe)
                    : exr_encoding_update(exr, part, info, pipe));
    for (int i = 0; i < pipe->channel_count; i++) {
        exr_coding_channel_info_t *c = &pipe->channels[i];
        data[i] = fixture_samples(&p->channel[i], x0, y0, info->width,
                                  info->height);
        c->encode_from_ptr = data[i];
        c->user_pixel_stride = c->user_bytes_per_element;
        c->user_line_stride = c->user_bytes_per_element * c->width;
    }
    if (first)
        assert_ok(exr_encoding_choose_default_routines(exr, part, pipe));
    assert_ok(exr_encoding_run(exr, part, pipe));
    for (int i = 0; i < pipe->channel_count; i++)
        free(data[i]);
}

static void fixture_chunks(exr_context_t exr, int part,
                           const struct fixture_part *p)
{
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_chunk_info_t info;
    int32_t levels = 0, lines = 1, n, w, h;
    if (p->tile)
        assert_ok(exr_get_tile_levels(exr, part, &levels, &n));
    else
        assert_ok(exr_get_scanlines_per_chunk(exr, part, &lines));
    for (int level = 0; level < levels; level++) {
        assert_ok(exr_get_level_sizes(exr, part, level, level, &w, &h));
        for (int ty = 0; ty * p->tile < h; ty++) {
            for (int tx = 0; tx * p->tile < w; tx++) {
                assert_ok(exr_write_tile_chunk_info(exr, part, tx, ty, level,
                                                    level, &info));
                fixture_chunk(exr, part, p, &info, &pipe);
            }
        }
    }
    for (int y = p->data.min.y; !p->tile && y <= p->data.max.y; y += lines) {
        assert_ok(exr_write_scanline_chunk_info(exr, part, y, &info));
        fixture_chunk(exr, part, p, &info, &pipe);
    }
    exr_encoding_destroy(exr, &pipe);
}

static void fixture_header(exr_context_t exr, const struct fixture *f,
                           int index)
{
    const struct fixture_part *p = &f->part[index];
    exr_attr_v2f_t centre = {{{0.0f, 0.0f}}};
    exr_attr_box2i_t display = f->display;
    int part;
    if (display.max.x == 0 && display.max.y == 0)
        display = f->part[0].data;
    exr_storage_t storage = p->deep ? p->tile ? EXR_STORAGE_DEEP_TILED
                                              : EXR_STORAGE_DEEP_SCANLINE
                            : p->tile ? EXR_STORAGE_TILED
                                      : EXR_STORAGE_SCANLINE;
    assert_ok(exr_add_part(exr, p->name ? p->name : "part", storage, &part));
    assert_ok(exr_initialize_required_attr(
        exr, part, &display, &p->data, f->aspect > 0.0f ? f->aspect : 1.0f,
        &centre, 1.0f, EXR_LINEORDER_INCREASING_Y, p->compression));
    if (p->tile)
        assert_ok(exr_set_tile_descriptor(
            exr, part, (uint32_t) p->tile, (uint32_t) p->tile,
            p->mipmap ? EXR_TILE_MIPMAP_LEVELS : EXR_TILE_ONE_LEVEL,
            EXR_TILE_ROUND_DOWN));
    if (p->deep)
        assert_ok(exr_set_version(exr, part, 1));
    if (f->chromaticities)
        assert_ok(exr_attr_set_chromaticities(exr, part, "chromaticities",
                                              &fixture_ap0));
    if (f->more)
        f->more(exr, part);
    for (int i = 0; i < FIXTURE_CHANNELS && p->channel[i].name; i++) {
        const struct fixture_channel *c = &p->channel[i];
        assert_ok(exr_add_channel(exr, part, c->name, c->type,
                                  EXR_PERCEPTUALLY_LOGARITHMIC,
                                  c->xs ? c->xs : 1, c->ys ? c->ys : 1));
    }
}

/* The bytes of the file; the caller frees them. */
static uint8_t *fixture_make(const struct fixture *f, size_t *size)
{
    struct fixture_file file = {0};
    exr_context_t exr;
    exr_context_initializer_t init = EXR_DEFAULT_CONTEXT_INITIALIZER;
    const int parts = f->parts ? f->parts : 1;
    init.user_data = &file;
    init.write_fn = fixture_write;
    init.error_handler_fn = fixture_silent;
    assert_ok(exr_start_write(&exr, "fixture", EXR_WRITE_FILE_DIRECTLY, &init));
    for (int i = 0; i < parts; i++)
        fixture_header(exr, f, i);
    assert_ok(exr_write_header(exr));
    for (int i = 0; i < parts && f->part[0].deep; i++) {
        int32_t chunks;
        assert_ok(exr_get_chunk_count(exr, i, &chunks));
        for (uint64_t none = 0; chunks > 0; chunks--)
            fixture_write(exr, &file, &none, sizeof none, file.size, NULL);
    }
    for (int i = 0; i < parts && !f->part[i].deep; i++)
        fixture_chunks(exr, i, &f->part[i]);
    exr_finish(&exr);
    *size = file.size;
    return file.bytes;
}

/* Writes bytes to a file: a new one, since file systems wait for the disk when
 * one is cut and filled again. */
static inline void fixture_save(const char *path, const void *bytes,
                                size_t size)
{
    remove(path);
    FILE *f = fopen(path, "wb");
    assert_non_null(f);
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
}

static inline void fixture_write_file(const char *path, const struct fixture *f)
{
    size_t size;
    uint8_t *bytes = fixture_make(f, &size);
    fixture_save(path, bytes, size);
    free(bytes);
}

#endif
