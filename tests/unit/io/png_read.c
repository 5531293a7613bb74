// SPDX-License-Identifier: Apache-2.0
/* PNG in: every kind of pixel, chunks, damaged files. */
#include "unit.h"
#include "write_fixture.h"
#include "io/io_priv.h"
#include "io/plane.h"

#include <libdeflate.h>

enum { ROOM = 1 << 18 };

/* A PNG in memory that is made chunk by chunk. */
struct made {
    uint8_t bytes[ROOM];
    size_t n;
};

static void put_chunk(struct made *m, const char *type, const void *data,
                      size_t n)
{
    uint8_t *const to = m->bytes + m->n;
    assert_true(m->n + n + 12 <= ROOM);
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t) (n >> (24 - 8 * i));
    memcpy(to + 4, type, 4);
    memcpy(to + 8, data, n);
    const uint32_t crc = libdeflate_crc32(0, to + 4, n + 4);
    for (int i = 0; i < 4; i++)
        to[8 + n + (size_t) i] = (uint8_t) (crc >> (24 - 8 * i));
    m->n += n + 12;
}

static void put_head(struct made *m, int w, int h, int bits, int type,
                     bool interlaced)
{
    const uint8_t head[13] = {
        0, (uint8_t) (w >> 16), (uint8_t) (w >> 8), (uint8_t) w,
        0, (uint8_t) (h >> 16), (uint8_t) (h >> 8), (uint8_t) h,
        (uint8_t) bits, (uint8_t) type, 0, 0, interlaced,
    };
    memcpy(m->bytes, "\x89PNG\r\n\x1a\n", 8);
    m->n = 8;
    put_chunk(m, "IHDR", head, sizeof head);
}

/* `head` and `n` bytes deflated, cut to `part` percent, as one chunk. */
static void put_packed(struct made *m, const char *type, const char *head,
                       size_t head_bytes, const void *data, size_t n, int part)
{
    static uint8_t packed[ROOM];
    struct libdeflate_compressor *const c = libdeflate_alloc_compressor(9);
    assert_non_null(c);
    memcpy(packed, head, head_bytes);
    const size_t got = libdeflate_zlib_compress(c, data, n, packed + head_bytes,
        sizeof packed - head_bytes);
    assert_true(got > 0);
    put_chunk(m, type, packed, head_bytes + got * (size_t) part / 100);
    libdeflate_free_compressor(c);
}

static void put_pixels(struct made *m, const void *data, size_t n, int part)
{
    put_packed(m, "IDAT", "", 0, data, n, part);
    put_chunk(m, "IEND", "", 0);
}

/* All of a picture; the caller closes it, where it can be read. */
static gp_status read_png(const void *bytes, size_t size,
                          struct gp_decoded *image)
{
    const struct gp_stream s = gp_stream_of(bytes, size);
    kept_clear();
    *image = (struct gp_decoded) {0};
    return gp_png_open(&kept_all, "in", &s, 1 << 20, image);
}

static gp_status check_png(const void *bytes, size_t size)
{
    struct gp_decoded image;
    const gp_status st = read_png(bytes, size, &image);
    gp_decoded_close(&image);
    return st;
}

/* Code c of pixel x, y as it is stored. */
static unsigned stored(int x, int y, int c, int bits)
{
    return wf_hash((uint32_t) x, (uint32_t) y, (uint32_t) c) >> 3 &
           ((1u << bits) - 1);
}

/* Rows of codes of 8 or 16 bits, each after a filter type of 0. */
static size_t put_rows(uint8_t *to, int samples, int bits, int w, int h)
{
    uint8_t *const start = to;
    for (int i = 0; i < w * h * samples; i++) {
        const int x = i / samples % w, y = i / samples / w;
        const unsigned v = stored(x, y, i % samples, bits);
        if (i % (w * samples) == 0)
            *to++ = 0;
        if (bits == 16)
            *to++ = (uint8_t) (v >> 8);
        *to++ = (uint8_t) v;
    }
    return (size_t) (to - start);
}

/* Palettes, transparent colours, few bits and interlacing are resolved. */
static void kinds(void **state)
{
    static const struct {
        int w, h, bits, type, interlaced;
        const char *more, *chunk; // before the pixels
        size_t more_bytes;
        const char *raw;
        size_t n;
        int channels, want_bits;
        float want[8]; // of 255 or 65535
    } row[] = {
        {2, 1, 1, 0, 0, "", "", 0, "\0\x40", 2, 1, 8, {0, 255}},
        {2, 1, 2, 0, 0, "\0\2", "tRNS", 2, "\0\x90", 2, 2, 8, {0, 0, 85, 255}},
        {2, 1, 4, 3, 0, "abcdef", "PLTE", 6, "\0\x10", 2, 3, 8,
         {'d', 'e', 'f', 'a', 'b', 'c'}},
        {1, 1, 16, 2, 0, "\0\1\0\2\0\3", "tRNS", 6, "\0\0\1\0\2\0\3", 7, 4,
         16, {0, 0, 0, 0}},
        {1, 1, 16, 4, 0, "", "", 0, "\0\x40\0\x80\0", 5, 2, 16,
         {8192, 32768}},
        // passes: x 0; x 1, y 0; y 1
        {2, 2, 8, 0, 1, "", "", 0, "\0\1\0\2\0\3\4", 7, 1, 8, {1, 2, 3, 4}},
    };
    static struct made m;
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_decoded image;
        put_head(&m, row[i].w, row[i].h, row[i].bits, row[i].type,
                 row[i].interlaced);
        if (row[i].more_bytes)
            put_chunk(&m, row[i].chunk, row[i].more, row[i].more_bytes);
        put_pixels(&m, row[i].raw, row[i].n, 100);
        if (read_png(m.bytes, m.n, &image))
            fail_msg("row %zu: %s", i, kept_line);
        assert_int_equal(image.bits, row[i].want_bits);
        assert_int_equal(image.channels, row[i].channels);
        const float max = row[i].want_bits == 16 ? 65535.0f : 255.0f;
        for (int k = 0; k < row[i].w * row[i].h * row[i].channels; k++) {
            if (fabsf(image.pixels[k] * max - row[i].want[k]) > 0.01f)
                fail_msg("row %zu: %g", i, (double) (image.pixels[k] * max));
        }
        gp_decoded_close(&image);
    }
}

/* The curve, the window and the texts that chunks name. */
static void chunks(void **state)
{
    static const struct {
        const char *type, *data;
        size_t n;
        const char *space, *name, *text;
        int x;
        float aspect;
    } row[] = {
#define ROW(type, data, ...) {type, data, sizeof data - 1, __VA_ARGS__}
        ROW("sRGB", "\0", "sRGB", NULL, NULL, 0, 0),
        ROW("gAMA", "\0\0\xb1\x8f", "Gamma2.2", NULL, NULL, 0, 0),
        ROW("gAMA", "\0\1\x86\xa0", "linear", NULL, NULL, 0, 0),
        ROW("gAMA", "\0\0\0\0", "sRGB", NULL, NULL, 0, 0),
        ROW("oFFs", "\0\0\0\5\xff\xff\xff\xf9\0", "sRGB", NULL, NULL, 5, 0),
        ROW("pHYs", "\0\0\7\xd0\0\0\3\xe8\0", "sRGB", NULL, NULL, 0, 0.5f),
        ROW("tEXt", "Author\0me", "sRGB", "Artist", "me", 0, 0),
        ROW("tEXt", "title\0it", "sRGB", "DocumentName", "it", 0, 0),
        ROW("tEXt", "Description\0what", "sRGB", "ImageDescription", "what", 0,
            0),
        ROW("tEXt", "shot\0", "sRGB", "shot", "", 0, 0),
        ROW("iTXt", "Comment\0\0\0en\0\0h\xc3\xa9", "sRGB", "Comment",
            "h\xc3\xa9", 0, 0),
        ROW("tIME", "\x07\xe4\2\3\4\5\6", "sRGB", "DateTime",
            "2020:02:03 04:05:06", 0, 0),
        ROW("tEXt", "Raw profile type exif\0x", "sRGB", NULL, NULL, 0, 0),
        ROW("iTXt", "XML:com.adobe.xmp\0\0\0\0\0<x/>", "sRGB", NULL, NULL, 0,
            0),
        ROW("iCCP", "any\0\0no profile", "sRGB", NULL, NULL, 0, 0),
        ROW("cICP", "\x09\x10\0\1", "sRGB", NULL, NULL, 0, 0),
        ROW("qqQq", "what is this", "sRGB", NULL, NULL, 0, 0),
#undef ROW
    };
    static struct made m;
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_decoded image;
        put_head(&m, 1, 1, 8, 0, false);
        put_chunk(&m, row[i].type, row[i].data, row[i].n);
        put_pixels(&m, "\0\x80", 2, 100);
        if (read_png(m.bytes, m.n, &image))
            fail_msg("row %zu: %s", i, kept_line);
        assert_string_equal(image.colour_space, row[i].space);
        assert_int_equal(image.data.x0, row[i].x);
        assert_int_equal(image.data.y0, row[i].x ? -7 : 0);
        assert_int_equal(image.display.x0, 0);
        assert_true(image.pixel_aspect == row[i].aspect);
        assert_int_equal(image.attributes, row[i].name != NULL);
        if (row[i].name) {
            assert_string_equal(image.attribute[0].name, row[i].name);
            assert_string_equal(image.attribute[0].text, row[i].text);
        }
        gp_decoded_close(&image);
    }
    // alpha is associated on codes, with a gamma by its power
    struct gp_decoded image;
    put_head(&m, 1, 1, 8, 6, false);
    put_chunk(&m, "gAMA", "\0\0\xb1\x8f", 4);
    put_pixels(&m, "\0\xc8\x64\0\x80", 5, 100);
    assert_ok(read_png(m.bytes, m.n, &image));
    assert_true(fabsf(image.pixels[0] * 255.0f - 43.0f) < 0.01f);
    assert_true(fabsf(image.pixels[1] * 255.0f - 21.0f) < 0.01f);
    gp_decoded_close(&image);
    // of two texts of one name the later counts, and there is no other part
    put_head(&m, 1, 1, 8, 0, false);
    put_chunk(&m, "tEXt", "shot\0one", 8);
    put_chunk(&m, "tEXt", "Shot\0two", 8);
    put_pixels(&m, "\0\x80", 2, 100);
    assert_ok(read_png(m.bytes, m.n, &image));
    assert_int_equal(image.attributes, 1);
    assert_string_equal(image.attribute[0].text, "two");
    gp_decoded_close(&image);
    const struct gp_stream s = gp_stream_of(m.bytes, m.n);
    const struct gp_read_params p = GP_READ_DEFAULTS;
    assert_int_equal(gp_read_image(&kept_all, &p, "in", &s, 1, &image),
                     GP_ERR_DATA);
}

/* Any byte changed, and any end but the last, is found; what follows IEND
 * does not matter. */
static void damaged_bytes(void **state)
{
    struct gp_frame f = wf_sized(9, 5, wf_rgb);
    assert_ok(wf_write(NULL, "a.png", &f, GP_PICTURE_SHOWN));
    gp_frame_free(&f);
    size_t size;
    uint8_t *const bytes = wf_read(wf_path("a.png"), &size);
    assert_ok(check_png(bytes, size));
    for (size_t i = 0; i < size; i++) {
        assert_int_equal(check_png(bytes, i), GP_ERR_DATA);
        bytes[i] ^= 0x10;
        assert_int_equal(check_png(bytes, size), GP_ERR_DATA);
        bytes[i] ^= 0x10;
    }
    uint8_t *const more = calloc(1, size + 100);
    assert_non_null(more);
    memcpy(more, bytes, size);
    assert_ok(check_png(more, size + 100));
    free(more);
    free(bytes);
}

/* Rows that are missing, and sizes over the limits, checksums being right. */
static void rows_and_sizes(void **state)
{
    static const struct {
        int w, h;
        bool interlaced;
        size_t rows;
        int part;
        bool whole;
    } rows[] = {
        {7, 5, false, 5 * 8, 100, true}, {7, 5, false, 4 * 8, 100, false},
        {7, 5, false, 5 * 8 - 1, 100, false}, {7, 5, false, 5 * 8, 50, false},
        // passes of 1x1, 1x1, 2x1, 2x2, 4x1, 3x3 and 7x2, a byte more a row
        {7, 5, true, 2 + 2 + 3 + 6 + 10 + 12 + 16, 100, true},
        {7, 5, true, 20, 100, false}, {1024, 1024, false, 1000, 100, false},
        {16384, 16384, false, 1000, 100, false},
        {1000, 1048, false, 1001 * 1048, 100, true},
        {1000, 1049, false, 1001 * 1049, 100, false},
        {1000000, 1, false, 1000001, 100, true},
        {1000001, 1, false, 1000002, 100, false},
        {1, 1000001, false, 10, 100, false},
    };
    static struct made m;
    static const uint8_t zeros[1001 * 1049];
    for (size_t i = 0; i < COUNT(rows); i++) {
        put_head(&m, rows[i].w, rows[i].h, 8, 0, rows[i].interlaced);
        put_pixels(&m, zeros, rows[i].rows, rows[i].part);
        if (check_png(m.bytes, m.n) != (rows[i].whole ? GP_OK : GP_ERR_DATA))
            fail_msg("row %zu: %s", i, kept_line);
    }
}

/* Alpha of every kind of picture. */
static void alpha_only(void **state)
{
    enum { W = 5, H = 3 };
    static const struct {
        int type, bits, samples;
    } row[] = {{6, 8, 4}, {6, 16, 4}, {4, 16, 2}, {4, 8, 2}, {2, 8, 3}};
    const struct gp_read_params p = GP_READ_DEFAULTS;
    struct gp_coverage a;
    static struct made m;
    uint8_t raw[H * (1 + 8 * W)];
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const int n = row[i].samples, bits = row[i].bits;
        put_head(&m, W, H, bits, row[i].type, false);
        put_pixels(&m, raw, put_rows(raw, n, bits, W, H), 100);
        kept_clear();
        assert_ok(gp_read_coverage(&kept_all, &p, "in", m.bytes, m.n, W * H,
                                   &a));
        const bool opaque = n == 3;
        assert_int_equal(a.w, opaque ? 1 : W);
        assert_int_equal(a.h, opaque ? 1 : H);
        for (int k = 0; k < a.w * a.h; k++)
            assert_int_equal(a.code[k], opaque ? GP_COVERED :
                             stored(k % W, k / W, n - 1, bits) *
                                 (bits == 8 ? 257 : 1));
        gp_free(a.code);
        if (opaque)
            continue;
        const gp_status st = gp_read_coverage(&kept_all, &p, "in", m.bytes, m.n,
                                              W * H - 1, &a);
        assert_int_equal(st, GP_ERR_DATA);
        assert_kept("(5 x 3 pixels, at most 14)");
        put_head(&m, W, H, bits, row[i].type, false);
        put_pixels(&m, raw, put_rows(raw, n, bits, W, H), 50);
        assert_int_equal(gp_read_coverage(&kept_all, &p, "in", m.bytes, m.n,
                                          W * H, &a), GP_ERR_DATA);
    }
}

SUITE_OF_EACH(png_read, wf_start, remove_folder, kinds, chunks, damaged_bytes,
              rows_and_sizes, alpha_only)
