/* io: formats other than EXR, through the bridge. Skipped without it. */
#include "unit.h"
#include "core/colour.h"

#include "oiio_here.h"
#include "reading.h"

#include <math.h>

enum { W = 16, H = 12, PIXELS = W * H };

/* A smooth picture in [0,1] with the ends in it. */
static float value(int x, int y, int c)
{
    float v = ((float) x + (float) y * (c == 1 ? 0.5f : 1.0f)) /
              (float) (W - 1 + H - 1);
    return c == 2 ? 1.0f - v : v;
}

static struct gp_oiio_image picture(float *pixels, int channels,
                                    const char *space)
{
    static const char *const rgb[] = {"R", "G", "B"}, *const grey[] = {"Y"};
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < channels; c++)
            pixels[i * channels + c] = value(i % W, i / W, c);
    }
    return (struct gp_oiio_image) {
        .w = W, .h = H, .full_w = W, .full_h = H, .channels = channels,
        .channel_name = channels == 1 ? grey : rgb, .pixels = pixels,
        .colour_space = space,
    };
}

/* What is written with a curve comes back without it. */
static void written_formats_come_back(void **state)
{
    (void) state;
    static const struct {
        const char *format, *type, *space;
        int channels;
        float error; // of stored values
    } row[] = {
        {"tif", "float", "Linear", 3, 0.0f},
        {"tif", "half", "Linear", 3, 5e-4f},
        {"tif", "uint16", "Linear", 3, 1e-5f},
        {"tif", "uint16", "sRGB", 3, 1e-5f},
        {"tif", "uint8", "sRGB", 3, 2.1e-3f},
        {"tif", "uint16", "Linear", 1, 1e-5f},
        {"png", "uint8", "sRGB", 3, 2.1e-3f},
        {"png", "uint16", "sRGB", 3, 1e-5f},
        {"bmp", "uint8", "", 3, 2.1e-3f},
        {"jpg", "uint8", "sRGB", 3, 6e-2f},
        {"dpx", "uint16", "Linear", 3, 2e-5f},
        {"hdr", "float", "Linear", 3, 8e-3f}, // 8 bits of mantissa
    };
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        float pixels[3 * PIXELS];
        const int n = row[i].channels;
        struct gp_oiio_image image = picture(pixels, n, row[i].space);
        struct gp_frame f;
        snprintf(path, sizeof path, "%s/a.%s", folder, row[i].format);
        assert_int_equal(api->write(path, row[i].format, &image, row[i].type,
                                    "", why, sizeof why), 0);
        assert_int_equal(read_file(path, &f), GP_OK);
        assert_int_equal(gp_frame_w(&f), W);
        assert_int_equal(gp_frame_h(&f), H);
        assert_int_equal(f.model, n == 1 ? GP_COLOUR_GREY : GP_COLOUR_RGB);
        assert_memory_equal(f.luminance, gp_rec709_luminance,
                            sizeof f.luminance);
        const bool curve = strcmp(row[i].space, "Linear") != 0;
        for (int k = 0; k < 3 * PIXELS; k++) {
            float want = value(k / 3 % W, k / 3 / W, n == 1 ? 0 : k % 3);
            float got = f.rgb.c[k % 3][k / 3];
            if (curve)
                got = gp_srgb_encode(got);
            if (!(fabsf(got - want) <= row[i].error))
                fail_msg("%s %s %s: %g, not %g", row[i].format, row[i].type,
                         row[i].space, (double) got, (double) want);
        }
        gp_frame_free(&f);
    }
}

static void save(const char *name, const void *bytes, size_t n)
{
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, n, file), n);
    assert_int_equal(fclose(file), 0);
}

/* As in an EXR, what a picture would show counts. */
static void display_window_that_lies(void **state)
{
    (void) state;
    const struct gp_read_params p = {.max_pixels = 1000};
    float pixels[3 * PIXELS];
    struct gp_oiio_image image = picture(pixels, 3, "Linear");
    if (!api)
        skip();
    snprintf(path, sizeof path, "%s/shown.tif", folder);
    for (int h = 25; h < 27; h++) {
        struct gp_frame f = {0};
        char why[512];
        image.full_w = 40;
        image.full_h = h;
        assert_int_equal(api->write(path, "tif", &image, "half", "", why,
                                    sizeof why), 0);
        heard.count = 0;
        assert_int_equal(gp_read_frame(&hear, &p, path, &f),
                         h == 25 ? GP_OK : GP_ERR_DATA);
        assert_int_equal(heard.count, h - 25);
        gp_frame_free(&f);
    }
    assert_non_null(strstr(heard.line, "shown.tif: the display window is too "
                           "large (40 x 26 pixels, at most 1000); "));
}

/* PFM stores rows from the bottom; values are light and stay what they are,
 * though OpenImageIO calls the format Rec709. */
static void pfm_is_linear(void **state)
{
    (void) state;
    static const float sample[2][3] = {{0.25f, 300.0f, -1.0f},
                                       {1e-4f, 0.5f, 70000.0f}};
    uint8_t bytes[64];
    struct gp_frame f;
    if (!api)
        skip();
    int n = snprintf((char *) bytes, sizeof bytes, "PF\n1 2\n-1.0\n");
    memcpy(bytes + n, sample[1], sizeof sample[1]);
    memcpy(bytes + n + sizeof sample[1], sample[0], sizeof sample[0]);
    save("a.pfm", bytes, (size_t) n + sizeof sample);
    assert_int_equal(read_file(path, &f), GP_OK);
    for (int y = 0; y < 2; y++) {
        for (int c = 0; c < 3; c++)
            assert_true(f.rgb.c[c][y] == sample[y][c]);
    }
    gp_frame_free(&f);

    n = snprintf((char *) bytes, sizeof bytes, "Pf\n2 1\n-1.0\n");
    memcpy(bytes + n, sample[0], 8);
    save("grey.pfm", bytes, (size_t) n + 8);
    assert_int_equal(read_file(path, &f), GP_OK);
    assert_int_equal(f.model, GP_COLOUR_GREY);
    for (int c = 0; c < 3; c++)
        assert_true(f.rgb.c[c][0] == 0.25f && f.rgb.c[c][1] == 300.0f);
    gp_frame_free(&f);
}

/* Alpha is carried, not bent by the curve, and attributes are kept. */
static void alpha_and_attributes(void **state)
{
    (void) state;
    static const char *const rgba[] = {"R", "G", "B", "A"};
    float pixels[4 * PIXELS];
    struct gp_frame f;
    if (!api)
        skip();
    for (int i = 0; i < 4 * PIXELS; i++)
        pixels[i] = i % 4 == 3 ? 1.0f - (float) (i / 4) / 400.0f : 0.25f;
    struct gp_oiio_image image = {
        .w = W, .h = H, .full_w = W, .full_h = H, .channels = 4,
        .channel_name = rgba, .pixels = pixels, .colour_space = "Linear",
    };
    snprintf(path, sizeof path, "%s/alpha.tif", folder);
    assert_int_equal(api->write(path, "tif", &image, "float", "", why,
                                sizeof why), 0);
    assert_int_equal(read_file(path, &f), GP_OK);
    assert_int_equal(f.channels, 4);
    const struct gp_channel *a = gp_frame_channel(&f, "A");
    assert_non_null(a);
    assert_int_equal(a->colour, -1);
    assert_int_equal(a->type, GP_FLOAT);
    for (int i = 0; i < PIXELS; i++)
        assert_true(((const float *) a->data)[i] == pixels[4 * i + 3]);
    assert_null(f.input);
    assert_true(f.attributes > 0);
    gp_frame_free(&f);
}

static void memory_equals_file(void **state)
{
    (void) state;
    float pixels[3 * PIXELS];
    static uint8_t bytes[1 << 16];
    struct gp_oiio_image image, a, b;
    if (!api)
        skip();
    image = picture(pixels, 3, "sRGB");
    snprintf(path, sizeof path, "%s/b.png", folder);
    assert_int_equal(api->write(path, "png", &image, "uint8", "", why,
                                sizeof why), 0);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    assert_int_equal(api->read(path, NULL, 0, 0, PIXELS, &a, why, sizeof why),
                     0);
    assert_int_equal(api->read("-", bytes, n, 0, PIXELS, &b, why, sizeof why),
                     0);
    assert_int_equal(a.bits, 8);
    assert_string_equal(a.colour_space, "sRGB");
    assert_memory_equal(a.pixels, b.pixels, sizeof pixels);
    api->image_free(&a);
    api->image_free(&b);
    assert_int_equal(
        api->read(path, NULL, 0, 0, PIXELS - 1, &a, why, sizeof why), -1);
    assert_non_null(strstr(why, "too large"));
    assert_int_equal(api->read(path, NULL, 0, 3, PIXELS, &a, why, 8), -1);
    assert_true(strlen(why) < 8);
}

/* A header's claim is refused by the number of bytes behind it. */
static void bytes_cannot_hold_the_claim(void **state)
{
    (void) state;
    static const struct {
        const char *name, *bytes;
        size_t n;
    } row[] = {
#define ROW(name, text) {name, text, sizeof text - 1}
        ROW("c.ppm", "P6\n9000 9000\n255\n0123456789"),
        ROW("c.pfm", "PF\n9000 9000\n-1.0\n0123456789"),
        ROW("c.tga", "\0\0\2\0\0\0\0\0\0\0\0\0\0\x40\0\x40\x18\0 0123456789"),
        ROW("c.hdr", "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 9000 +X 9000\n"
                     "\2\2\x23\x28"),
#undef ROW
    };
    struct gp_frame f;
    if (!api)
        skip();
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        save(row[i].name, row[i].bytes, row[i].n);
        assert_int_equal(read_file(path, &f), GP_ERR_DATA);
        if (!strstr(heard.line, "bytes cannot hold"))
            fail_msg("%s", heard.line);
    }
}

/* Blocks of rows are the rows of the whole; each four channels count. */
static void blocks_and_channels(void **state)
{
    (void) state;
    enum { BW = 700, BH = 2500 };
    struct gp_frame f;
    if (!api)
        skip();
    float *const pixels = malloc(sizeof(float) * 3 * BW * BH);
    assert_non_null(pixels);
    struct gp_oiio_image image = picture(pixels, 3, "Linear");
    for (int i = 0; i < 3 * BW * BH; i++)
        pixels[i] = (float) i;
    image.w = image.full_w = BW;
    image.h = image.full_h = BH;
    snprintf(path, sizeof path, "%s/blocks.tif", folder);
    assert_int_equal(api->write(path, "tif", &image, "float", "", why,
                                sizeof why), 0);
    assert_int_equal(read_file(path, &f), GP_OK);
    for (int i = 0; i < 3 * BW * BH; i++)
        assert_true(f.rgb.c[i % 3][i / 3] == pixels[i]);
    gp_frame_free(&f);
    image = (struct gp_oiio_image) {
        .w = 10, .h = 10, .full_w = 10, .full_h = 10, .channels = 9,
        .pixels = pixels, .colour_space = "Linear",
    };
    assert_int_equal(api->write(path, "tif", &image, "float", "", why,
                                sizeof why), 0);
    assert_int_equal(api->read(path, NULL, 1 << 20, 0, 299, &image, why,
                               sizeof why), -1);
    assert_non_null(strstr(why, "9 channels"));
    assert_int_equal(api->read(path, NULL, 1 << 20, 0, 300, &image, why,
                               sizeof why), 0);
    api->image_free(&image);
    free(pixels);
}

static void no_picture_is_an_error(void **state)
{
    (void) state;
    static const char text[] = "This is no picture.\n";
    struct gp_frame f;
    if (!api)
        skip();
    save("a.png", text, sizeof text);
    assert_int_equal(read_file(path, &f), GP_ERR_DATA);
    assert_ptr_equal(strstr(heard.line, path), heard.line);
    assert_null(strchr(heard.line, '\n'));
}

static double mean(const struct gp_oiio_image *image, int c)
{
    double sum = 0.0;
    for (int i = 0; i < image->w * image->h; i++)
        sum += (double) image->pixels[i * image->channels + c];
    return sum / (image->w * image->h);
}

/* Also for one bright pixel, whose filter rings. */
static void resizing_keeps_the_mean(void **state)
{
    (void) state;
    static const int size[][2] = {{8, 6}, {33, 25}, {16, 12}, {5, 31}};
    float pixels[3 * PIXELS];
    if (!api)
        skip();
    struct gp_oiio_image image = picture(pixels, 3, "Linear");
    pixels[3 * (5 * W + 7)] = 1000.0f;
    for (size_t i = 0; i < sizeof size / sizeof *size; i++) {
        struct gp_oiio_image out;
        assert_int_equal(api->resize(&image, size[i][0], size[i][1], &out,
                                     why, sizeof why), 0);
        assert_int_equal(out.w, size[i][0]);
        assert_int_equal(out.h, size[i][1]);
        for (int c = 0; c < 3; c++)
            assert_true(fabs(mean(&out, c) / mean(&image, c) - 1.0) < 1e-5);
        api->image_free(&out);
    }
}

static int setup(void **state)
{
    return open_oiio(state) || make_folder(state);
}

SUITE(oiio_read)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(written_formats_come_back),
        cmocka_unit_test(display_window_that_lies),
        cmocka_unit_test(pfm_is_linear),
        cmocka_unit_test(alpha_and_attributes),
        cmocka_unit_test(memory_equals_file),
        cmocka_unit_test(bytes_cannot_hold_the_claim),
        cmocka_unit_test(blocks_and_channels),
        cmocka_unit_test(no_picture_is_an_error),
        cmocka_unit_test(resizing_keeps_the_mean),
    };
    return cmocka_run_group_tests(tests, setup, remove_folder);
}
