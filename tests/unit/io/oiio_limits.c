/* io: what the bridge refuses to read and to resize, and how it fails: pictures
 * that are none, memory and files that there are no more of. Skipped without
 * the bridge. */
#include "unit.h"
#include "io/oiio/image.h"

#include "exr_fixture.h"
#include "oiio_here.h"
#include "resource_limit.h"
#include "tiff_bytes.h"
#include "write_fixture.h"

#include <signal.h>

// -- TIFF ---------------------------------------------------------------------

#define GREY(w, h, bits)                                                      \
    TIFF_LONG(256, w), TIFF_LONG(257, h), TIFF_SHORT(258, bits),              \
    TIFF_SHORT(259, 1), TIFF_SHORT(262, 1)
#define STRIP(rows, bytes)                                                    \
    TIFF_LONG(273, TIFF_PIXELS), TIFF_SHORT(277, 1), TIFF_LONG(278, rows),    \
    TIFF_LONG(279, bytes)
#define TILE(w, h, bytes)                                                     \
    TIFF_SHORT(277, 1), TIFF_LONG(322, w), TIFF_LONG(323, h),                 \
    TIFF_LONG(324, TIFF_PIXELS), TIFF_LONG(325, bytes)

static void odd_tiffs(void **state)
{
    (void) state;
    static const struct {
        const char *name, *said;
        struct tiff_field field[TIFF_FIELDS];
    } row[] = {
        {"large tiles", "tiles larger than the picture",
         {GREY(4, 4, 8), TILE(8192, 8192, 4096)}},
        {"doubles", "tiles of 64-bit floats",
         {GREY(16, 16, 64), TILE(16, 16, 2048), TIFF_SHORT(339, 3)}},
        {"deep tiles", "a volume, not a picture",
         {GREY(16, 16, 8), TILE(16, 16, 512), TIFF_LONG(32998, 2)}},
        {"many", "too large: 1024 x 1025 pixels, at most 1048576",
         {GREY(1024, 1025, 8), STRIP(1025, 16)}},
    };
    static const double none[512];
    uint8_t bytes[TIFF_ROOM];
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++)
        refused(row[i].name, bytes,
                tiff_make(row[i].field, none, 2048, bytes), row[i].said);
}

/* Neighbours of what is refused. */
static void tiffs_that_are_read(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        int size;     // bytes of a sample: 1, or 8 for doubles
        int w, h;     // of the stored rows
        struct tiff_field field[TIFF_FIELDS];
    } row[] = {
        {"bytes", 1, 4, 4, {GREY(4, 4, 8), STRIP(4, 16)}},
        // "all rows", as many writers put it
        {"one strip", 1, 4, 4, {GREY(4, 4, 8), STRIP(0xffffffffu, 16)}},
        {"double strips", 8, 4, 4,
         {GREY(4, 4, 64), STRIP(4, 128), TIFF_SHORT(339, 3)}},
        {"tile", 1, 16, 16, {GREY(4, 4, 8), TILE(16, 16, 256)}},
    };
    uint8_t bytes[TIFF_ROOM], pixels[2048];
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct gp_oiio_image a;
        float whole[16], got[16];
        const int n = row[i].w * row[i].h;
        for (int k = 0; k < n; k++) {
            const double v = k / 255.0;
            if (row[i].size == 8)
                memcpy(pixels + 8 * k, &v, 8);
            else
                pixels[k] = (uint8_t) k;
        }
        const size_t size = tiff_make(row[i].field, pixels,
                                      (size_t) (n * row[i].size), bytes);
        if (read_bytes(bytes, size, 16, &a))
            fail_msg("%s: %s", row[i].name, why);
        for (int k = 0; k < 16; k++) {
            const int stored = k / 4 * row[i].w + k % 4;
            assert_true(fabs((double) a.pixels[k] - stored / 255.0) < 1e-7);
        }
        memcpy(whole, a.pixels, sizeof whole);
        api->image_free(&a);
        // and a block at a time
        assert_int_equal(api->open("-", bytes, size, 0, 16, &a, why,
                                   sizeof why), 0);
        assert_int_equal(a.block, 4);
        assert_null(a.pixels);
        memset(got, 0, sizeof got);
        assert_int_equal(api->rows(&a, 0, got, why, sizeof why), 0);
        assert_memory_equal(got, whole, sizeof got);
        api->image_free(&a);
    }
}

// -- other formats --------------------------------------------------------------

/* DDS, "DDS File Layout" of Microsoft: RGB of 24 bits, d slices of it. */
static size_t dds(uint8_t to[TIFF_ROOM], int w, int h, int d)
{
    const uint32_t head[32] = {
        0x20534444, 124, 0x80100f, (uint32_t) h, (uint32_t) w,
        (uint32_t) (3 * w), (uint32_t) d, [19] = 32, 0x40, 0, 24, 0xff0000,
        0xff00, 0xff, 0, 0x1008, d > 1 ? 0x200000 : 0,
    };
    const size_t n = 3 * (size_t) (w * h * d);
    for (int i = 0; i < 32; i++)
        tiff_put(to + 4 * i, head[i], 4);
    memset(to + sizeof head, 51, n);
    return sizeof head + n;
}

static void volumes(void **state)
{
    (void) state;
    uint8_t bytes[TIFF_ROOM];
    struct gp_oiio_image a;
    if (!api)
        skip();
    refused("volume", bytes, dds(bytes, 4, 3, 2), "a volume, not a picture");
    if (read_bytes(bytes, dds(bytes, 4, 3, 1), 12, &a))
        fail_msg("slice: %s", why);
    assert_true(a.w == 4 && a.h == 3 && a.channels == 3);
    assert_true(fabs((double) a.pixels[0] - 0.2) < 1e-7);
    api->image_free(&a);
}

/* Sizes that are none. */
static void no_pixels(void **state)
{
    (void) state;
    static const struct {
        const char *name, *bytes;
        size_t n;
    } row[] = {
#define ROW(name, text) {name, text, sizeof text - 1}
        ROW("no width", "P6\n0 5\n255\n0123456789"),
        ROW("no height", "P6\n5 0\n255\n0123456789"),
        ROW("negative", "P5\n-3 4\n255\n0123456789"),
        ROW("none", "PF\n0 0\n-1\n0123456789"),
        ROW("no channels", "\1\332\0\1\0\3\0\4\0\4\0\0"
                           "0123456789012345678901234567890123456789"
                           "0123456789012345678901234567890123456789"),
#undef ROW
    };
    uint8_t bytes[1024]; // SGI's header has 512 bytes
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        memset(bytes, 0, sizeof bytes);
        memcpy(bytes, row[i].bytes, row[i].n);
        refused(row[i].name, bytes, sizeof bytes, "no pixels");
    }
}

// -- EXR ----------------------------------------------------------------------

#define FAR (1 << 29)

static void odd_exrs(void **state)
{
    (void) state;
    static const struct {
        const char *name, *said;
        exr_attr_box2i_t data, display;
    } row[] = {
        {"far right", "windows out of range",
         FIXTURE_WINDOW(FAR, 0, 2, 2), FIXTURE_WINDOW(0, 0, 2, 2)},
        {"far left", "windows out of range",
         FIXTURE_WINDOW(-FAR, 0, 2, 2), FIXTURE_WINDOW(0, 0, 2, 2)},
        {"display", "windows out of range", FIXTURE_WINDOW(0, 0, 2, 2),
         FIXTURE_WINDOW(0, 0, 2, FAR)},
        {"near", NULL, FIXTURE_WINDOW(1 - FAR, FAR - 2, 2, 2),
         FIXTURE_WINDOW(0, 0, FAR - 1, 2)},
    };
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const struct fixture f = {
            .display = row[i].display,
            .part = {{.channel = {RGB(EXR_PIXEL_HALF)}, .data = row[i].data,
                      .compression = EXR_COMPRESSION_ZIPS}},
        };
        struct gp_oiio_image a;
        size_t n;
        uint8_t *const bytes = fixture_make(&f, &n);
        if (row[i].said) {
            refused(row[i].name, bytes, n, row[i].said);
        } else {
            if (read_bytes(bytes, n, 4, &a))
                fail_msg("%s: %s", row[i].name, why);
            assert_int_equal(a.x, 1 - FAR);
            assert_int_equal(a.y, FAR - 2);
            assert_int_equal(a.full_w, FAR - 1);
            assert_true(a.pixels[0] == fixture_value("R", a.x, a.y));
            api->image_free(&a);
        }
        free(bytes);
    }
}

// -- what there is no more of -------------------------------------------------

static const char ppm[] = "P6\n2 1\n255\n\377\0\0\0\0\377";

static void no_copy_in_memory(void **state)
{
    (void) state;
    struct gp_oiio_image a;
    if (!api)
        skip();
    assert_int_equal(read_bytes(ppm, sizeof ppm - 1, 2, &a), 0);
    assert_true(a.pixels[0] == 1.0f && a.pixels[5] == 1.0f);
    api->image_free(&a);
    api->image_free(&a); // again is nothing
    assert_null(a.own);

    struct rlimit was = resource_limit(RLIMIT_NOFILE, 0);
    const int no_file = read_bytes(ppm, sizeof ppm - 1, 2, &a);
    setrlimit(RLIMIT_NOFILE, &was);
    assert_int_equal(no_file, -1);
    assert_null(a.own);
    assert_true(strlen(why) > 0 && !strchr(why, '\n'));

    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    was = resource_limit(RLIMIT_FSIZE, 8);
    const int no_room = read_bytes(ppm, sizeof ppm - 1, 2, &a);
    setrlimit(RLIMIT_FSIZE, &was);
    signal(SIGXFSZ, handler);
    assert_int_equal(no_room, GP_OIIO_MEMORY);
    assert_string_equal(why, "no room for a copy in memory");

    assert_int_equal(read_bytes(ppm, sizeof ppm - 1, 2, &a), 0); // as before
    api->image_free(&a);
}

static gp_status read_ppm(const struct gp_read_params *p,
                          const struct gp_stream *s, struct gp_frame *f)
{
    struct gp_image image;
    gp_status st = gp_oiio_image_open(&wf_log, "a.ppm", s, 0, p->max_pixels,
                                      &image);
    if (!st) {
        st = gp_image_frame(&wf_log, NULL, &image, f);
        gp_image_close(&image);
    }
    return st;
}

/* The same as a frame's reader says it. */
static void no_room_for_frames(void **state)
{
    (void) state;
    const struct gp_read_params p = GP_READ_DEFAULTS;
    const struct gp_stream s = {
        .fd = -1, .data = (void *) ppm, .size = sizeof ppm - 1,
        .borrowed = true,
    };
    struct gp_frame f = {0};
    if (!api)
        skip();
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    const struct rlimit was = resource_limit(RLIMIT_FSIZE, 8);
    const gp_status st = read_ppm(&p, &s, &f);
    setrlimit(RLIMIT_FSIZE, &was);
    signal(SIGXFSZ, handler);
    assert_int_equal(st, GP_ERR_BUG);
    wf_assert_said("a.ppm: out of memory");
    assert_null(f.rgb.c[0]);
    assert_int_equal(read_ppm(&p, &s, &f), GP_OK);
    assert_true(f.rgb.c[0][0] == 1.0f && f.rgb.c[2][1] == 1.0f);
    gp_frame_free(&f);
}

/* A reason fits into any room, none too. */
static void reasons_are_cut(void **state)
{
    (void) state;
    struct gp_oiio_image a;
    if (!api)
        skip();
    for (size_t room = 0; room < 5; room++) {
        char small[8] = "=======";
        assert_int_equal(api->read("-", ppm, sizeof ppm - 1, 0, 1, &a, small,
                                   room), -1);
        assert_int_equal(strlen(small), room ? room - 1 : 7);
        assert_memory_equal(small, "too large", room ? room - 1 : 0);
        assert_int_equal(small[room], '=');
    }
}

// -- resizing -----------------------------------------------------------------

static struct gp_oiio_image picture(float *pixels, int w, int channels)
{
    return (struct gp_oiio_image) {
        .w = w, .h = 1, .full_w = w, .full_h = 1, .channels = channels,
        .pixels = pixels,
    };
}

/* Means that cancel say nothing: what is resized is not blown up by their
 * quotient. Channels need no names. */
static void means_that_cancel(void **state)
{
    (void) state;
    enum { W = 24 };
    float pixels[3 * W];
    struct gp_oiio_image out;
    if (!api)
        skip();
    for (int at = 0; at < W / 2; at++) {
        for (int i = 0; i < W; i++) {
            pixels[3 * i] = 0.0f;
            pixels[3 * i + 1] = i == at ? 1.0f : i == W - 1 ? -1.0001f : 0.0f;
            pixels[3 * i + 2] = i == at ? -1.0f : i == W - 1 ? 1.1f : 0.0f;
        }
        const struct gp_oiio_image image = picture(pixels, W, 3);
        for (int w = 5; w < 2 * W; w += 7) {
            assert_int_equal(api->resize(&image, w, 1, &out, why, sizeof why),
                             0);
            assert_int_equal(out.channels, 3);
            assert_string_equal(out.channel_name[0], "R");
            for (int i = 0; i < w; i++) {
                assert_true(out.pixels[3 * i] == 0.0f);
                assert_true(fabsf(out.pixels[3 * i + 1]) < 2.5f);
                assert_true(fabsf(out.pixels[3 * i + 2]) < 2.5f);
            }
            api->image_free(&out);
        }
    }
}

static int setup(void **state)
{
    return wf_start(state) || open_oiio(state);
}

SUITE(oiio_limits)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(odd_tiffs),
        cmocka_unit_test(tiffs_that_are_read),
        cmocka_unit_test(volumes),
        cmocka_unit_test(no_pixels),
        cmocka_unit_test(odd_exrs),
        cmocka_unit_test(no_copy_in_memory),
        cmocka_unit_test(no_room_for_frames),
        cmocka_unit_test(reasons_are_cut),
        cmocka_unit_test(means_that_cancel),
    };
    return cmocka_run_group_tests(tests, setup, wf_end);
}
