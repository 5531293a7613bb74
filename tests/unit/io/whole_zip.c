/* Deflated TIFFs: each bit of their rows counts. */
#include "unit.h"
#include "tiff_bytes.h"
#include "write_fixture.h"

#include "io/whole.h"
#include "io/whole_zip.h"

#include <libdeflate.h>

enum { W = 40, H = 7, ROWS = 4, MOST = 1 << 20 };

static gp_status check(const uint8_t *bytes, size_t n, long long max_pixels)
{
    const struct gp_stream s = {
        .fd = -1, .data = (uint8_t *) (uintptr_t) bytes, .size = n,
        .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s, 0, max_pixels);
}

static size_t pack(uint8_t *to, size_t room, size_t rows)
{
    uint8_t raw[W * (ROWS + 1)];
    struct libdeflate_compressor *const c = libdeflate_alloc_compressor(9);
    assert_non_null(c);
    for (size_t i = 0; i < W * rows; i++)
        raw[i] = (uint8_t) wf_hash(1, (uint32_t) i, 2);
    const size_t n = libdeflate_zlib_compress(c, raw, W * rows, to, room);
    assert_true(n > 0);
    libdeflate_free_compressor(c);
    return n;
}

/* A grey picture of one strip with `rows` packed rows. */
struct strip {
    const char *name;
    int height, of_strip, rows; // of the picture, said, packed
    int compression, photometric, order;
    const char *said;           // NULL: it passes
};

static size_t make(const struct strip *s, uint8_t bytes[TIFF_ROOM],
                   size_t *packed)
{
    uint8_t zip[1024];
    *packed = pack(zip, sizeof zip, (size_t) s->rows);
    const struct tiff_field field[TIFF_FIELDS] = {
        TIFF_LONG(256, W), TIFF_LONG(257, (uint32_t) s->height),
        TIFF_SHORT(258, 8), TIFF_SHORT(259, (uint32_t) s->compression),
        TIFF_SHORT(262, (uint32_t) s->photometric),
        TIFF_SHORT(266, (uint32_t) s->order), TIFF_LONG(273, TIFF_PIXELS),
        TIFF_SHORT(277, 1), TIFF_LONG(278, (uint32_t) s->of_strip),
        TIFF_LONG(279, (uint32_t) *packed),
    };
    return tiff_make(field, zip, *packed, bytes);
}

static const char unlike[] = "in: cut off or damaged (strip 0 does not unpack "
                             "to its rows: ";

static void strips(void **state)
{
    (void) state;
    static const struct strip row[] = {
        {"whole", 4, 4, 4, 8, 1, 1, NULL},
        {"the old number", 4, 4, 4, 32946, 1, 1, NULL},
        {"three of four rows", 3, 4, 3, 8, 1, 1, NULL},
        {"a row too few", 4, 4, 3, 8, 1, 1, unlike},
        {"a row too many", 4, 4, 5, 8, 1, 1, unlike},
        {"the old number, a row too few", 4, 4, 3, 32946, 1, 1, unlike},
        // nobody knows how many rows
        {"YCbCr", 4, 4, 3, 8, 6, 1, NULL},
        {"bits turned round", 4, 4, 3, 8, 1, 2, NULL},
    };
    uint8_t bytes[TIFF_ROOM];
    size_t packed;
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const size_t n = make(&row[i], bytes, &packed);
        if (check(bytes, n, MOST) != (row[i].said ? GP_ERR_DATA : GP_OK))
            fail_msg("%s: %s", row[i].name, wf_line);
        if (row[i].said)
            wf_assert_said(row[i].said);
    }
}

/* The bridge refuses what is over the limit; no memory is taken for it. */
static void too_many_bytes(void **state)
{
    (void) state;
    static const struct strip few = {"", 4, 4, 3, 8, 1, 1, unlike};
    uint8_t bytes[TIFF_ROOM];
    size_t packed;
    const size_t n = make(&few, bytes, &packed);
    assert_int_equal(check(bytes, n, 4 * W / 32), GP_ERR_DATA);
    assert_int_equal(check(bytes, n, 4 * W / 32 - 1), GP_OK);
}

static void every_byte(void **state)
{
    (void) state;
    static const struct strip whole = {"", 4, 4, 4, 8, 1, 1, NULL};
    uint8_t bytes[TIFF_ROOM];
    size_t packed;
    const size_t n = make(&whole, bytes, &packed);
    for (size_t i = TIFF_PIXELS; i < TIFF_PIXELS + packed; i++) {
        bytes[i] ^= 1;
        if (check(bytes, n, MOST) != GP_ERR_DATA)
            fail_msg("byte %zu of %zu", i - TIFF_PIXELS, packed);
        wf_assert_said(unlike);
        bytes[i] ^= 1;
    }
}

/* The last strip may be filled up with rows that are not the picture's. Which
 * one is damaged is said. */
static void many_streams(void **state)
{
    (void) state;
    enum { STREAMS = 3 };
    uint8_t bytes[4096];
    struct gp_zip zip[STREAMS];
    size_t at = 0;
    int failed = -1;
    for (int i = 0; i < STREAMS; i++) {
        const size_t n = pack(bytes + at, sizeof bytes - at, ROWS);
        zip[i] = (struct gp_zip) {at, n, W * ROWS, W * ROWS};
        at += n;
    }
    const struct gp_stream s = {
        .fd = -1, .data = bytes, .size = at, .borrowed = true,
    };
    const struct gp_stream closed = {.fd = -1, .size = at};
    zip[2].size = W * (H - ROWS);
    assert_int_equal(gp_whole_zip(&s, zip, STREAMS, &failed), GP_OK);
    zip[0].bytes = at; // the others lie behind its end
    assert_int_equal(gp_whole_zip(&s, zip, STREAMS, &failed), GP_OK);
    assert_int_equal(gp_whole_zip(&closed, zip, STREAMS, &failed), GP_ERR_IO);
    assert_int_equal(failed, 0);
    bytes[zip[1].at + 20] ^= 1;
    assert_int_equal(gp_whole_zip(&s, zip, STREAMS, &failed), GP_ERR_DATA);
    assert_int_equal(failed, 1);
    bytes[zip[1].at + 20] ^= 1;
    zip[2].bytes++; // the file ends before
    assert_int_equal(gp_whole_zip(&s, zip, STREAMS, &failed), GP_ERR_DATA);
    assert_int_equal(failed, 2);
}

SUITE(whole_zip)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strips),
        cmocka_unit_test(too_many_bytes),
        cmocka_unit_test(every_byte),
        cmocka_unit_test(many_streams),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
