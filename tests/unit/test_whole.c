/* PNG and JPEG that are not all there, byte by byte. */
#include "write_fixture.h"

#include "io/whole.h"

static gp_status check(const void *bytes, size_t size)
{
    const struct gp_stream s = {
        .fd = -1, .data = (uint8_t *) (uintptr_t) bytes, .size = size,
        .borrowed = true,
    };
    wf_line[0] = '\0';
    return gp_whole_check(&wf_log, "in", &s);
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
        assert_int_equal(check(bytes, i), i < 8 ? GP_OK : GP_ERR_DATA);
        bytes[i] ^= 0x10;
        assert_int_equal(check(bytes, size), i < 8 ? GP_OK : GP_ERR_DATA);
        bytes[i] ^= 0x10;
    }
    bytes[size - 20] ^= 1; // of IDAT
    assert_int_equal(check(bytes, size), GP_ERR_DATA);
    wf_assert_said("in: damaged (the checksum of chunk IDAT");
    bytes[size - 20] ^= 1;
    assert_int_equal(check(bytes, size - 20), GP_ERR_DATA);
    wf_assert_said("in: cut off or damaged (the file ends in chunk IDAT)");
    uint8_t *const more = calloc(1, size + 100);
    assert_non_null(more);
    memcpy(more, bytes, size);
    assert_int_equal(check(more, size + 100), GP_OK);
    free(more);
    free(bytes);
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

int main(void)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, wf_start, wf_end)
    const struct CMUnitTest tests[] = {TEST(png), TEST(jpeg), TEST(long_scans)};
    return cmocka_run_group_tests(tests, wf_find_bridge, NULL);
}
