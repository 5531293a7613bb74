/* io: what the bridge does not take OpenImageIO's word for. Skipped without the
 * bridge. */
#include "unit.h"
#include "tiff_bytes.h"
#include "write_fixture.h"

#include "oiio_here.h"

/* FITS: cards of 80 letters, 36 in a block, then samples from the bottom row
 * up, of which OpenImageIO passes over one. It names one channel of several. */
static void rows_one_off(void **state)
{
    (void) state;
    enum { CARD = 80, BLOCK = 2880 };
    static const char *const card[] = {
        "SIMPLE  =                    T", "BITPIX  =                    8",
        "NAXIS   =                    3", "NAXIS1  =                    3",
        "NAXIS2  =                    5", "NAXIS3  =                    2",
        "END",
    };
    uint8_t bytes[2 * BLOCK] = {0};
    if (!api)
        skip();
    memset(bytes, ' ', BLOCK);
    for (size_t i = 0; i < sizeof card / sizeof *card; i++)
        memcpy(bytes + i * CARD, card[i], strlen(card[i]));
    refused("FITS", bytes, sizeof bytes,
            "a FITS, which OpenImageIO reads a row off");
}

/* OpenImageIO makes one up from the name; the file's bytes do not matter. */
static void made_up_pictures(void **state)
{
    (void) state;
    struct gp_oiio_image a;
    if (!api)
        skip();
    FILE *const file = fopen(wf_path("a.null"), "wb");
    assert_non_null(file);
    assert_int_equal(fwrite("hi\n", 1, 3, file), 3);
    assert_int_equal(fclose(file), 0);
    assert_int_equal(api->read(wf_path("a.null"), NULL, 3, 0, 1 << 20, &a, why,
                               sizeof why), -1);
    assert_string_equal(why, "null, whose pictures OpenImageIO makes up from "
                        "a name");
}

/* LZW that begins with a code of no string: OpenImageIO says so and reads on,
 * as if there were rows. */
static void rows_that_are_damaged(void **state)
{
    (void) state;
    static const struct tiff_field field[TIFF_FIELDS] = {
        TIFF_LONG(256, 4), TIFF_LONG(257, 4), TIFF_SHORT(258, 8),
        TIFF_SHORT(259, 5), TIFF_SHORT(262, 1), TIFF_LONG(273, TIFF_PIXELS),
        TIFF_SHORT(277, 1), TIFF_LONG(278, 4), TIFF_LONG(279, 16),
    };
    static const uint8_t zeros[16];
    uint8_t bytes[TIFF_ROOM];
    struct gp_oiio_image a;
    float rows[16];
    if (!api)
        skip();
    const size_t n = tiff_make(field, zeros, sizeof zeros, bytes);
    refused("damaged", bytes, n, "code not yet in table");
    assert_int_equal(api->open("-", bytes, n, 0, 16, &a, why, sizeof why), 0);
    assert_int_equal(api->rows(&a, 0, rows, why, sizeof why), -1);
    assert_non_null(strstr(why, "code not yet in table"));
    api->image_free(&a);
}

static int setup(void **state)
{
    return wf_start(state) || open_oiio(state);
}

SUITE(oiio_trust)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_one_off),
        cmocka_unit_test(made_up_pictures),
        cmocka_unit_test(rows_that_are_damaged),
    };
    return cmocka_run_group_tests(tests, setup, wf_end);
}
