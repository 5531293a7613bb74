/* JPEG and DPX that are not all there, byte by byte. */
#include "unit.h"
#include "write_fixture.h"

#include "io/whole.h"

static gp_status check(const void *bytes, size_t size)
{
    const struct gp_stream s = {
        .fd = -1, .data = (uint8_t *) (uintptr_t) bytes, .size = size,
        .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s, 0, 1 << 20);
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
        TEST(dpx), TEST(jpeg),
        TEST(long_scans),
    };
    return cmocka_run_group_tests(tests, find_bridges, NULL);
}
