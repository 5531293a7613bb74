/* io: writing of pictures, by the bridge and without it: endings, compressions,
 * places that cannot be written, files that may not grow, coverage, shapes of
 * pixels. What needs the bridge is skipped without it. */
#include "unit.h"
#include "oiio_here.h"
#include "resource_limit.h"
#include "write_fixture.h"

#include <math.h>
#include <signal.h>

static void endings(void **state)
{
    (void) state;
    static const struct {
        const char *ending;
        int can;
    } row[] = {
        {"", 0}, {"nosuch", 0}, {"exr", 1}, {"sxr", 0}, {"mxr", 0},
        {"tif", 1}, {"tiff", 1}, {"gif", 0}, {"ico", 0}, {"rla", 0},
        {"null", 0}, {"hdr", 1}, {"..", 0}, {"a/b", 0},
    };
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        if (api->can_write(row[i].ending) != row[i].can)
            fail_msg("%s", row[i].ending);
    }
}

static struct gp_oiio_image picture(float *pixels, int w, int channels)
{
    return (struct gp_oiio_image) {
        .w = w, .h = 1, .full_w = w, .full_h = 1, .channels = channels,
        .pixels = pixels,
    };
}

static void places_that_cannot_be_written(void **state)
{
    (void) state;
    static const struct {
        const char *path, *format, *said;
        int w;
    } row[] = {
        {"none/a", "tif", "", 2}, // the folder is not there
        {"none/a", "exr", "", 2},
        {"a", "nosuch", "nosuch", 2},
        {"a", "webp", "", 16384}, // one more than WebP has
        {"full", "tif", "", 2},
        {"full", "dpx", "No space left", 2},
    };
    static float pixels[3 * 16384];
    if (!api || access("/dev/full", W_OK))
        skip();
    assert_int_equal(symlink("/dev/full", wf_path("full")), 0);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const struct gp_oiio_image image = picture(pixels, row[i].w, 3);
        why[0] = '\0';
        if (api->write(wf_path(row[i].path), row[i].format, &image, "uint8",
                       "", why, sizeof why) != -1)
            fail_msg("%s was written to %s", row[i].format, row[i].path);
        assert_null(strchr(why, '\n'));
        assert_non_null(strstr(why, row[i].said));
    }
}

/* A file that may not grow as far as the picture might need: most of these
 * would be cut off without a word. */
static void files_that_may_not_grow(void **state)
{
    (void) state;
    static const char *const formats[] = {"tif", "sgi", "dpx", "bmp", "hdr",
                                          "tga", "ppm", "webp", "jpg", "exr"};
    enum { MANY = 2000, MOST = 2 * 3 * MANY + (1 << 16) };
    static float pixels[3 * MANY];
    const struct gp_oiio_image image = picture(pixels, MANY, 3);
    if (!api)
        skip();
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (size_t i = 0; i < 2 * sizeof formats / sizeof *formats; i++) {
        const bool room = i % 2;
        const char *const path = wf_path("grown"), *format = formats[i / 2];
        const char *const type = strcmp(format, "hdr") == 0   ? "float"
                                 : strcmp(format, "exr") == 0 ? "half"
                                                              : "uint8";
        const int most = MOST * (type[0] == 'f' ? 4 : type[0] == 'h' ? 2 : 1);
        const struct rlimit was =
            resource_limit(RLIMIT_FSIZE, room ? (rlim_t) most : 700);
        const int got = api->write(path, format, &image, type, "", why,
                                   sizeof why);
        setrlimit(RLIMIT_FSIZE, &was);
        if (got != (room ? 0 : -1))
            fail_msg("%s, %d: %d %s", format, room, got, why);
        if (!room)
            assert_non_null(strstr(why, "files may have 700, see ulimit -f"));
        remove(path);
    }
    signal(SIGXFSZ, handler);
}

/* Coverage is stored as it is; in integers it has not been multiplied into
 * the colour, which a reader does. */
static void alpha_of_every_type(void **state)
{
    (void) state;
    static const struct {
        const char *format, *type;
        bool associated;
        float error;
    } row[] = {
        {"tif", "float", true, 0.0f},   {"tif", "half", true, 5e-4f},
        {"tif", "uint8", false, 4e-3f}, {"tif", "uint16", false, 2e-5f},
        {"png", "uint8", false, 4e-3f}, {"png", "uint16", false, 2e-5f},
    };
    static float pixels[] = {1.0f, 0.5f, 0.0f, 1.0f, 0.8f, 0.4f, 0.2f, 0.5f};
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct gp_oiio_image image = picture(pixels, 2, 4), back;
        const char *path = wf_path("alpha");
        image.colour_space = i % 2 ? "" : "Linear";
        assert_int_equal(api->write(path, row[i].format, &image, row[i].type,
                                    "", why, sizeof why), 0);
        assert_int_equal(api->read(path, NULL, 1 << 20, 0, 2, &back, why,
                                   sizeof why), 0);
        assert_int_equal(back.channels, 4);
        for (int k = 0; k < 8; k++) {
            const float alpha = pixels[k / 4 * 4 + 3];
            const float want = row[i].associated || k % 4 == 3
                                   ? pixels[k] : pixels[k] * alpha;
            if (!(fabsf(back.pixels[k] - want) <= row[i].error))
                fail_msg("%s %s: sample %d is %g, not %g", row[i].format,
                         row[i].type, k, (double) back.pixels[k],
                         (double) want);
        }
        api->image_free(&back);
    }
}

// -- pictures of frames -------------------------------------------------------

static gp_status write_frame(const struct gp_write_params *p, const char *name,
                             const struct gp_frame *f,
                             enum gp_picture_kind kind)
{
    struct gp_write_stats stats = {0};
    wf_line[0] = '\0';
    return gp_write_picture(&wf_log, p, wf_path(name), f, &f->rgb, kind,
                            &stats);
}

/* The first value of a field of a TIFF of Intel's order. */
static unsigned tiff_field(const char *name, int tag)
{
    size_t size;
    uint32_t at, v = 0, count;
    uint8_t *const b = wf_read(wf_path(name), &size);
    memcpy(&at, b + 4, 4);
    const int n = b[at] | b[at + 1] << 8;
    for (const uint8_t *e = b + at + 2; e < b + at + 2 + 12 * n; e += 12) {
        if ((e[0] | e[1] << 8) != tag)
            continue;
        memcpy(&count, e + 4, 4);
        memcpy(&v, e + 8, 4);
        if (count * (e[2] == 3 ? 2 : 4) > 4)
            memcpy(&v, b + v, 4);
        v &= e[2] == 3 ? 0xffff : 0xffffffff;
    }
    free(b);
    return v;
}

/* Compression is TIFF 6.0's field 259; sizes of samples are field 258. */
static void tiffs_of_every_kind(void **state)
{
    (void) state;
    static const struct {
        enum gp_compression compression;
        enum gp_picture_kind kind;
        int depth_bits;
        unsigned packing, bits; // 0: refused
    } row[] = {
        {GP_COMPRESSION_NONE, GP_PICTURE_SHOWN, 8, 1, 8},
        {GP_COMPRESSION_RLE, GP_PICTURE_SHOWN, 8, 32773, 8},
        {GP_COMPRESSION_ZIPS, GP_PICTURE_SHOWN, 16, 8, 16},
        {GP_COMPRESSION_ZIP, GP_PICTURE_ENCODED, 16, 8, 16},
        {GP_COMPRESSION_NONE, GP_PICTURE_SCENE, 8, 1, 32},
        {GP_COMPRESSION_ZIP, GP_PICTURE_SCENE, 16, 8, 32},
        {GP_COMPRESSION_PIZ, GP_PICTURE_SHOWN, 8, 0, 0},
        {GP_COMPRESSION_DWAB, GP_PICTURE_SCENE, 8, 0, 0},
    };
    const struct gp_rect r = {0, 0, 40, 30};
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        p.compression = row[i].compression;
        p.depth_bits = row[i].depth_bits;
        const gp_status st = write_frame(&p, "a.tif", &f, row[i].kind);
        if (st != (row[i].packing ? GP_OK : GP_ERR_USAGE))
            fail_msg("row %d: %s", (int) i, wf_line);
        if (st) {
            wf_assert_said("a.tif: TIFF has no such compression; use none");
            assert_int_equal(access(wf_path("a.tif"), F_OK), -1);
            continue;
        }
        assert_int_equal(tiff_field("a.tif", 259), row[i].packing);
        assert_int_equal(tiff_field("a.tif", 258), row[i].bits);
        remove(wf_path("a.tif"));
    }
    gp_frame_free(&f);
}

/* Under a limit in the midst of the pixels: one line, and no file. */
static void pictures_that_do_not_fit(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        bool bridge;
        const char *said;
    } row[] = {
        {"a.png", false, "File too large"},
        {"a.pfm", false, "File too large"},
        {"a.tif", true, "see ulimit -f"},
    };
    const struct gp_rect r = {0, 0, 900, 900};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    p.depth_bits = 16;
    for (size_t i = 0; i < 3 * gp_frame_pixels(&f); i++)
        f.rgb.c[i % 3][i / 3] =
            (float) (wf_hash((uint32_t) i, 1, 2) >> 8) / 0x1p24f;
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        if (row[i].bridge && !api)
            continue;
        const int before = wf_names();
        const struct rlimit was = resource_limit(RLIMIT_FSIZE, 1500000);
        const gp_status st = write_frame(&p, row[i].name, &f,
                                         GP_PICTURE_SHOWN);
        setrlimit(RLIMIT_FSIZE, &was);
        assert_int_equal(st, GP_ERR_IO);
        wf_assert_said(row[i].name);
        wf_assert_said(row[i].said);
        assert_int_equal(wf_names(), before);
        assert_int_equal(write_frame(&p, row[i].name, &f, GP_PICTURE_SHOWN),
                         GP_OK);
        remove(wf_path(row[i].name));
    }
    signal(SIGXFSZ, handler);
    gp_frame_free(&f);
}

/* What OpenImageIO refuses is said with its reason. */
static void more_than_a_format_has(void **state)
{
    (void) state;
    const struct gp_rect r = {0, 0, 16384, 1};
    const struct gp_write_params p = GP_WRITE_DEFAULTS;
    if (!api)
        skip();
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    const int before = wf_names();
    assert_int_equal(write_frame(&p, "a.webp", &f, GP_PICTURE_SHOWN),
                     GP_ERR_IO);
    wf_assert_said("a.webp: OpenImageIO cannot write it (");
    wf_assert_said("; write another format");
    assert_int_equal(wf_names(), before);
    gp_frame_free(&f);
}

/* PNG's pHYs holds ratios that two whole numbers can. */
static void shapes_of_pixels(void **state)
{
    (void) state;
    static const struct {
        float aspect;
        unsigned x, y; // pixels of a unit; 0 no chunk
    } row[] = {
        {1.0f, 0, 0},         {2.0f, 5000, 10000}, {0.5f, 20000, 10000},
        {1e5f, 0, 0},         {1e-5f, 0, 0},       {0.0f, 0, 0},
        {9999.0f, 1, 10000},  {NAN, 0, 0},         {-2.0f, 0, 0},
        {INFINITY, 0, 0},
    };
    const struct gp_rect r = {0, 0, 3, 2};
    const struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        size_t size;
        f.pixel_aspect = row[i].aspect;
        assert_int_equal(write_frame(&p, "a.png", &f, GP_PICTURE_SHOWN),
                         GP_OK);
        uint8_t *const b = wf_read(wf_path("a.png"), &size);
        const uint8_t *const at = memmem(b, size, "pHYs", 4);
        assert_int_equal(at != NULL, row[i].x > 0);
        for (int k = 0; at && k < 4; k++) {
            assert_int_equal(at[4 + k], row[i].x >> (24 - 8 * k) & 0xff);
            assert_int_equal(at[8 + k], row[i].y >> (24 - 8 * k) & 0xff);
        }
        free(b);
    }
    gp_frame_free(&f);
}

static int setup(void **state)
{
    return wf_start(state) || open_oiio(state);
}

SUITE(oiio_write)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(endings),
        cmocka_unit_test(places_that_cannot_be_written),
        cmocka_unit_test(files_that_may_not_grow),
        cmocka_unit_test(alpha_of_every_type),
        cmocka_unit_test(tiffs_of_every_kind),
        cmocka_unit_test(pictures_that_do_not_fit),
        cmocka_unit_test(more_than_a_format_has),
        cmocka_unit_test(shapes_of_pixels),
    };
    return cmocka_run_group_tests(tests, setup, wf_end);
}
