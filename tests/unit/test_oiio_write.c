/* io: writing by the bridge: endings, places that cannot be written, files that
 * may not grow, coverage. Skipped without it. */
#include "io/oiio.h"

#include "resource_limit.h"
#include "write_fixture.h"

#include <math.h>
#include <signal.h>

static const struct gp_oiio_api *api;
static char why[512];

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

static int setup(void **state)
{
    if (wf_start(state) || wf_find_bridge(state))
        return -1;
    api = gp_oiio_open(why, sizeof why);
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(endings),
        cmocka_unit_test(places_that_cannot_be_written),
        cmocka_unit_test(files_that_may_not_grow),
        cmocka_unit_test(alpha_of_every_type),
    };
    return cmocka_run_group_tests(tests, setup, wf_end);
}
