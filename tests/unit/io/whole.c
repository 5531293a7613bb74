/* PNG, JPEG and DPX that are not all there, byte by byte. */
#include "unit.h"
#include "write_fixture.h"

#include "io/whole.h"

#include <libdeflate.h>

static gp_status check(const void *bytes, size_t size)
{
    const struct gp_stream s = {
        .fd = -1, .data = (uint8_t *) (uintptr_t) bytes, .size = size,
        .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s, 0, 1 << 20);
}

/* Any byte changed, and any end but the last, is found; what follows IEND and
 * what begins otherwise is nobody's business. */
static void png(void **state)
{
    (void) state;
    const struct gp_rect r = {0, 0, 9, 5};
    const struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_write_stats stats = {0};
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    if (gp_write_picture(&wf_log, &p, wf_path("a.png"), &f, &f.rgb,
                         GP_PICTURE_SHOWN, &stats))
        fail_msg("%s", wf_line);
    gp_frame_free(&f);
    size_t size;
    uint8_t *const bytes = wf_read(wf_path("a.png"), &size);
    assert_int_equal(check(bytes, size), GP_OK);
    for (size_t i = 0; i < size; i++) {
        assert_int_equal(check(bytes, i), i < 4 ? GP_OK : GP_ERR_DATA);
        bytes[i] ^= 0x10;
        assert_int_equal(check(bytes, size), i < 4 ? GP_OK : GP_ERR_DATA);
        bytes[i] ^= 0x10;
    }
    bytes[size - 14] ^= 1; // of IDAT's checksum
    assert_int_equal(check(bytes, size), GP_ERR_DATA);
    wf_assert_said("in: damaged (IDAT: CRC error)");
    bytes[size - 14] ^= 1;
    assert_int_equal(check(bytes, size - 20), GP_ERR_DATA);
    wf_assert_said("in: damaged (the file ends too early)");
    uint8_t *const more = calloc(1, size + 100);
    assert_non_null(more);
    memcpy(more, bytes, size);
    assert_int_equal(check(more, size + 100), GP_OK);
    free(more);
    free(bytes);
}

static size_t put_chunk(uint8_t *to, const char *type, const void *data,
                        size_t n)
{
    for (int i = 0; i < 4; i++)
        to[i] = (uint8_t) (n >> (24 - 8 * i));
    memcpy(to + 4, type, 4);
    memcpy(to + 8, data, n);
    const uint32_t crc = libdeflate_crc32(0, to + 4, n + 4);
    for (int i = 0; i < 4; i++)
        to[8 + n + (size_t) i] = (uint8_t) (crc >> (24 - 8 * i));
    return n + 12;
}

/* A grey PNG of w x h whose `rows` bytes of zeros are deflated, cut to `part`
 * percent; all checksums are right. */
static size_t make_png(uint8_t *to, int w, int h, bool interlaced, size_t rows,
                       size_t part)
{
    uint8_t *const raw = calloc(1, rows), packed[4096];
    struct libdeflate_compressor *const c = libdeflate_alloc_compressor(9);
    const uint8_t head[13] = {
        0, (uint8_t) (w >> 16), (uint8_t) (w >> 8), (uint8_t) w,
        0, (uint8_t) (h >> 16), (uint8_t) (h >> 8), (uint8_t) h,
        8, 0, 0, 0, interlaced,
    };
    assert_true(raw && c);
    size_t n = libdeflate_zlib_compress(c, raw, rows, packed, sizeof packed);
    assert_true(n > 0);
    n = n * part / 100;
    memcpy(to, "\x89PNG\r\n\x1a\n", 8);
    size_t at = 8 + put_chunk(to + 8, "IHDR", head, sizeof head);
    at += put_chunk(to + at, "IDAT", packed, n);
    at += put_chunk(to + at, "IEND", "", 0);
    libdeflate_free_compressor(c);
    free(raw);
    return at;
}

/* What libpng would say to stderr is said once, here. */
static void png_rows(void **state)
{
    (void) state;
    static const struct {
        int w, h;
        bool interlaced;
        size_t rows, part;
        const char *said; // NULL: whole
    } rows[] = {
        {7, 5, false, 5 * 8, 100, NULL},
        {7, 5, false, 4 * 8, 100, "damaged (Not enough image data)"},
        {7, 5, false, 5 * 8 - 1, 100, "damaged (Not enough image data)"},
        {7, 5, false, 5 * 8, 50, "damaged ("},
        // passes of 1x1, 1x1, 2x1, 2x2, 4x1, 3x3 and 7x2, a byte more a row
        {7, 5, true, 2 + 2 + 3 + 6 + 10 + 12 + 16, 100, NULL},
        {7, 5, true, 20, 100, "damaged (Not enough image data)"},
        {16384, 16384, false, 1000, 100, "in: too large (16384 x 16384 "},
        {1000, 1048, false, 1001 * 1048, 100, NULL},
        {1000, 1049, false, 1001 * 1049, 100, "too large (1000 x 1049 "},
        {1000000, 1, false, 1000001, 100, NULL},
        {1000001, 1, false, 1000002, 100, "too large (1000001 x 1 pixels; a"},
        {1, 1000001, false, 10, 100, "too large (1 x 1000001 pixels; a"},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint8_t bytes[8192];
        const size_t n = make_png(bytes, rows[i].w, rows[i].h,
                                  rows[i].interlaced, rows[i].rows,
                                  rows[i].part);
        if (check(bytes, n) != (rows[i].said ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: %s", i, wf_line);
        if (rows[i].said)
            wf_assert_said(rows[i].said);
    }
}

/* Seven million bytes in seven thousand, `texts` times, and one pixel. */
static size_t make_texts(uint8_t *to, size_t room, int texts)
{
    enum { TEXT = 7000000 };
    uint8_t *const raw = calloc(1, TEXT), *const packed = malloc(room);
    struct libdeflate_compressor *const c = libdeflate_alloc_compressor(9);
    assert_true(raw && packed && c);
    size_t at = make_png(to, 1, 1, false, 2, 100);
    const size_t after_head = 8 + 25, rest = at - after_head;
    uint8_t pixels[100];
    assert_true(rest <= sizeof pixels);
    memcpy(pixels, to + after_head, rest);
    at = after_head;
    memset(raw, 'a', TEXT);
    memcpy(packed, "key\0", 5); // and the method, 0
    const size_t n = libdeflate_zlib_compress(c, raw, TEXT, packed + 5,
                                              room - 5);
    assert_true(n > 0);
    for (int i = 0; i < texts; i++)
        at += put_chunk(to + at, "zTXt", packed, n + 5);
    memcpy(to + at, pixels, rest);
    libdeflate_free_compressor(c);
    free(packed);
    free(raw);
    return at + rest;
}

/* A few texts are ordinary; a length that the file has no room for, or many
 * texts, take no memory. */
static void png_texts(void **state)
{
    (void) state;
    enum { ROOM = 1 << 18 };
    uint8_t *const bytes = malloc(ROOM);
    assert_non_null(bytes);
    size_t n = make_texts(bytes, 1 << 14, 3);
    if (check(bytes, n))
        fail_msg("%s", wf_line);
    n = make_texts(bytes, 1 << 14, 9);
    assert_int_equal(check(bytes, n), GP_ERR_DATA);
    wf_assert_said("in: damaged (its chunks are said to be, or unpack ");
    n = make_png(bytes, 1, 1, false, 2, 100);
    const size_t after_head = 33;
    uint8_t *const other = bytes + ROOM / 2;
    memcpy(other, bytes, after_head);
    memcpy(other + after_head, "\4\0\0\0zTXtabcd", 12);
    memcpy(other + after_head + 12, bytes + after_head, n - after_head);
    assert_int_equal(check(other, n + 12), GP_ERR_DATA);
    wf_assert_said("in: damaged (its chunks are said to be, or unpack ");
    free(bytes);
}

/* User data that are there, are not, and of which there are none. */
static void dpx(void **state)
{
    (void) state;
    static const struct {
        uint8_t user[4]; // high byte first
        gp_status st;
    } rows[] = {
        {{0, 0, 0, 0}, GP_OK},
        {{0, 0, 0, 200}, GP_OK},
        {{0, 0, 0, 201}, GP_ERR_DATA},
        {{0x7f, 0, 0, 0}, GP_ERR_DATA},
        {{0xff, 0, 0, 0}, GP_ERR_DATA},
        {{0xff, 0xff, 0xff, 0xfe}, GP_ERR_DATA},
        {{0xff, 0xff, 0xff, 0xff}, GP_OK},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        uint8_t big[200] = "SDPX", little[200] = "XPDS";
        memcpy(big + 32, rows[i].user, 4);
        for (int k = 0; k < 4; k++)
            little[32 + k] = rows[i].user[3 - k];
        assert_int_equal(check(big, sizeof big), rows[i].st);
        assert_int_equal(check(little, sizeof little), rows[i].st);
        assert_int_equal(check(big, 35), GP_ERR_DATA);
    }
}

static void jpeg(void **state)
{
    (void) state;
    static const struct {
        const char *bytes;
        size_t size;
        const char *ends_in; // NULL: whole
    } rows[] = {
#define ROW(text, where) {text, sizeof text - 1, where}
        ROW("\xff\xd8\xff\xd9", NULL),
        ROW("\xff\xd8\xff\xe0\0\4ab\xff\xd9", NULL),
        ROW("\xff\xd8\xff\xe0\0\4ab\xff\xff\xff\xd9 and more", NULL),
        // a thumbnail's EOI inside a segment is not the picture's
        ROW("\xff\xd8\xff\xe1\0\6\xff\xd9""ab", "its headers"),
        ROW("\xff\xd8\xff\xe1\0\6\xff\xd9", "its headers"),
        ROW("\xff\xd8\xff", "its headers"),
        ROW("\xff\xd8\xff\xff\xff", "its headers"),
        ROW("\xff\xd8\xff\xda\0\3x scan \xff\0 \xff\xd3 on \xff\xd9", NULL),
        ROW("\xff\xd8\xff\xda\0\3x scan \xff\0 \xff\xd3 on ", "a scan"),
        ROW("\xff\xd8\xff\xda\0\3x scan \xff", "a scan"),
        // a second scan, with a table before it
        ROW("\xff\xd8\xff\xda\0\2abc\xff\xc4\0\3t\xff\xda\0\2def\xff\xd9", NULL),
        ROW("\xff\xd8\xff\xda\0\2abc\xff\xc4\0\3t\xff\xda\0\2de", "a scan"),
#undef ROW
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const gp_status st = check(rows[i].bytes, rows[i].size);
        assert_int_equal(st, rows[i].ends_in ? GP_ERR_DATA : GP_OK);
        if (rows[i].ends_in)
            wf_assert_said(rows[i].ends_in);
    }
}

/* A scan longer than a block of reading, with markers over its ends. */
static void long_scans(void **state)
{
    (void) state;
    enum { SIZE = 200000 };
    uint8_t *const bytes = malloc(SIZE);
    assert_non_null(bytes);
    for (size_t shift = 0; shift < 4; shift++) {
        memset(bytes, 'x', SIZE);
        memcpy(bytes, "\xff\xd8\xff\xda\0\2", 6);
        for (size_t i = 65536 - 2 + shift; i + 1 < SIZE; i += 65536)
            memcpy(bytes + i, "\xff\0", 2);
        assert_int_equal(check(bytes, SIZE), GP_ERR_DATA);
        memcpy(bytes + SIZE - 2, "\xff\xd9", 2);
        assert_int_equal(check(bytes, SIZE), GP_OK);
    }
    free(bytes);
}

SUITE(whole)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, wf_start, wf_end)
    const struct CMUnitTest tests[] = {
        TEST(png), TEST(png_rows), TEST(png_texts), TEST(dpx), TEST(jpeg),
        TEST(long_scans),
    };
    return cmocka_run_group_tests(tests, find_bridges, NULL);
}
