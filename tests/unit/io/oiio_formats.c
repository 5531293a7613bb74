// SPDX-License-Identifier: Apache-2.0
/* io: formats other than EXR and PNG, in and out, by the helper: what comes
 * back is what was written, and what is cut off, damaged or lies is one line.
 * Skipped without the helper. */
#include "unit.h"
#include "core/colour.h"
#include "io/exr/exr.h"
#include "exr_fixture.h"
#include "oiio_here.h"
#include "reading.h"
#include "write_fixture.h"

enum { W = 16, H = 12, PIXELS = W * H };

static const char *const rgba[] = {"R", "G", "B", "A", "a", "b", "c", "d", "e"};

static void need_oiio(void)
{
    if (!has_oiio)
        skip_for("no OpenImageIO");
}

/* A smooth picture in [0,1] with the ends in it. */
static float code_value(int x, int y, int c)
{
    float v = ((float) x + (float) y * (c == 1 ? 0.5f : 1.0f)) /
              (float) (W - 1 + H - 1);
    return c == 2 ? 1.0f - v : v;
}

static struct gp_decoded picture(float *pixels, int channels, const char *space)
{
    static const char *const grey[] = {"Y"};
    for (int i = 0; i < PIXELS; i++) {
        for (int c = 0; c < channels; c++)
            pixels[i * channels + c] = code_value(i % W, i / W, c);
    }
    return image_of(pixels, W, H, channels == 1 ? grey : rgba, channels, space);
}

// -- out and in again ---------------------------------------------------------

/* Pictures that are written with a curve come back without it. */
static void written_formats_come_back(void **state)
{
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
        {"tga", "uint8", "sRGB", 3, 2.1e-3f},
        {"sgi", "uint16", "Linear", 3, 1e-5f}, {"bmp", "uint8", "", 3, 2.1e-3f},
        {"jpg", "uint8", "sRGB", 3, 6e-2f},
        {"dpx", "uint16", "Linear", 3, 2e-5f},
        {"hdr", "float", "Linear", 3, 8e-3f}, // 8 bits of mantissa
    };
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        float pixels[3 * PIXELS];
        const int n = row[i].channels;
        struct gp_decoded image = picture(pixels, n, row[i].space);
        struct gp_frame f;
        snprintf(path, sizeof path, "%s/a.%s", folder, row[i].format);
        assert_ok(write_image(path, row[i].format, &image, row[i].type, ""));
        assert_ok(read_file(path, &f));
        assert_int_equal(gp_frame_w(&f), W);
        assert_int_equal(gp_frame_h(&f), H);
        assert_int_equal(f.model, n == 1 ? GP_COLOUR_GREY : GP_COLOUR_RGB);
        assert_memory_equal(f.luminance, gp_rec709_luminance,
                            sizeof f.luminance);
        const bool curve = strcmp(row[i].space, "Linear") != 0;
        for (int k = 0; k < 3 * PIXELS; k++) {
            float want = code_value(k / 3 % W, k / 3 / W, n == 1 ? 0 : k % 3);
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

/* A header that claims more than the bytes behind it hold, or no pixels. */
static void claims(void **state)
{
    static const struct {
        bool padded; // zeros after the bytes
        const char *bytes;
        size_t n;
    } row[] = {
#define ROW(padded, text) {padded, text, sizeof text - 1}
        ROW(false, "P6\n1000 1000\n255\n0123456789"),
        ROW(false, "\0\0\2\0\0\0\0\0\0\0\0\0\xe8\3\xe8\3\x18\0 0123456789"),
        ROW(false, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1000 +X 1000\n"
                   "\2\2\3\xe8"),
        ROW(true, "P6\n0 5\n255\n0123456789"),
        ROW(true, "P6\n5 0\n255\n0123456789"),
        ROW(true, "P5\n-3 4\n255\n0123456789"),
        ROW(true, "\1\332\0\1\0\3\0\4\0\4\0\0"), // SGI of no channels
#undef ROW
    };
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        uint8_t bytes[1024] = {0}; // SGI's header has 512
        memcpy(bytes, row[i].bytes, row[i].n);
        refused("claim", bytes, row[i].padded ? sizeof bytes : row[i].n);
    }
}

/* Each format cut off, by little and by much, in its file and in memory. */
static void cut_off(void **state)
{
    static const struct {
        const char *format, *type, *compression;
    } row[] = {
        {"tif", "uint8", "none"}, {"tif", "float", "zip"},
        {"tif", "uint16", "lzw"}, {"tif", "half", "packbits"},
        {"tif", "uint8", "jpeg"}, {"jpg", "uint8", ""}, {"bmp", "uint8", ""},
        {"tga", "uint8", ""},     {"ppm", "uint8", ""}, {"sgi", "uint8", ""},
        {"webp", "uint8", ""},    {"dpx", "uint8", ""}, {"dpx", "uint16", ""},
        {"hdr", "float", ""},     {"exr", "half", "dwaa"},
    };
    float pixels[3 * PIXELS];
    const struct gp_decoded image = picture(pixels, 3, "");
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_decoded a;
        size_t size;
        in_folder("cut");
        assert_ok(write_image(path, row[i].format, &image, row[i].type,
                              row[i].compression));
        uint8_t *const bytes = wf_read(path, &size);
        if (read_bytes(bytes, size, PIXELS, &a))
            fail_msg("%s", kept_line);
        gp_decoded_close(&a);
        // Targa's footer and JPEG's last mark may be cut without loss
        const bool tga = strcmp(row[i].format, "tga") == 0;
        const size_t most = tga ? 18 + 3 * PIXELS - 1 : size - 3;
        for (size_t k = 1; k <= 8; k++)
            refused(row[i].format, bytes, 20 + (most - 20) * k / 8);
        free(bytes);
    }
}

/* By their first bytes these are no format that is read, whatever OpenImageIO
 * has a reader for; the name does not matter. */
static void formats_that_are_not_read(void **state)
{
    static const char *const row[][2] = {
        {"SIMPLE  =                    T", "reads (unknown data, 53 49 4d 50"},
        {"8BPS\0\1", "reads (Photoshop); "}, {"GIF89a", "reads (GIF); "},
        {"\x80\x2a\x5f\xd7", "reads (Cineon); "},
        {"#EXTM3U\nhttp://a", "reads (unknown data, 23 45 58 54 ...); "},
        {"hi, there", "reads (unknown data, 68 69 2c 20 ...); "},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        refused(row[i][1], row[i][0], strlen(row[i][0]));
        assert_kept(row[i][1]);
    }
    fixture_save(in_folder("http:127.0.0.1:9989.null"), "hi\n", 3);
    assert_refused(path, GP_ERR_DATA, "not a format that glarepp reads");
}

/* The helper asks no reader but those of gp_readers, whatever it is asked
 * for; a TIFF is what most of them would open, or pass on. */
static void readers_that_are_never_asked(void **state)
{
    static const char *const row[] = {
        "cineon", "dds", "dicom", "ffmpeg", "fits", "gif", "heif", "ico",
        "iff", "jpeg2000", "null", "openvdb", "png", "psd", "raw", "rla",
        "softimage", "zfile", "tif", "mp4", "a.tif", "",
    };
    float pixels[3 * PIXELS];
    const struct gp_decoded image = picture(pixels, 3, "");
    need_oiio();
    in_folder("a.tif");
    assert_ok(write_image(path, "tif", &image, "uint8", ""));
    size_t size;
    uint8_t *const bytes = wf_read(path, &size);
    struct gp_stream s = gp_stream_of(bytes, size);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_decoded got = {0};
        const gp_status st = gp_oiio_open(&kept_log, path, &s, row[i], 0,
                                          PIXELS, &got);
        if (st != GP_ERR_DATA || !strstr(kept_line, "not a format"))
            fail_msg("%s: status %d, %s", row[i], (int) st, kept_line);
    }
    for (const struct gp_reader *r = gp_readers; r->format; r++) {
        struct gp_decoded got = {0};
        const bool tiff = r->oiio && strcmp(r->oiio, "tiff") == 0;
        const gp_status st = r->oiio ? gp_oiio_open(&kept_log, path, &s,
            r->oiio, 0, PIXELS, &got) : GP_ERR_DATA;
        if (st != (tiff ? GP_OK : GP_ERR_DATA) ||
            (r->oiio && !tiff && strstr(kept_line, "not a format")))
            fail_msg("%s: status %d, %s", r->format, (int) st, kept_line);
        gp_decoded_close(&got);
    }
    free(bytes);
}

/* Endings that are written; OpenImageIO has writers for more. */
static void endings(void **state)
{
    static const struct {
        const char *name;
        bool can;
    } row[] = {
        {"a.tif", true}, {"a.tiff", true}, {"a.hdr", true}, {"a.jpeg", true},
        {"a.pfm", true}, {"a", false}, {"a.nosuch", false}, {"a.sxr", false},
        {"a.gif", false}, {"a.ico", false}, {"a.rla", false},
        {"a.null", false}, {"a.a/b", false},
    };
    const struct gp_write_params p = GP_WRITE_DEFAULTS;
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        if (gp_write_check(&kept_all, &p, wf_path(row[i].name)) !=
            (row[i].can ? GP_OK : GP_ERR_USAGE))
            fail_msg("%s: %s", row[i].name, kept_line);
    }
    // each ending in the line for unknown ones is one that is written
    kept_clear();
    assert_int_equal(gp_write_check(&kept_all, &p, wf_path("a.nosuch")),
                     GP_ERR_USAGE);
    char line[512], name[32];
    int listed = 0;
    assert_true(strlen(kept_line) < sizeof line);
    strcpy(line, kept_line);
    char *word = strstr(line, "; end the name in one of .");
    assert_non_null(word);
    for (word = strtok(word + 24, ", "); word; word = strtok(NULL, ", ")) {
        snprintf(name, sizeof name, "a%s", word);
        assert_ok(gp_write_check(&kept_all, &p, wf_path(name)));
        listed += strcmp(word, ".exr") == 0 || strcmp(word, ".png") == 0 ||
                  strcmp(word, ".pfm") == 0 || strcmp(word, ".tif") == 0;
    }
    assert_int_equal(listed, 4);
}

static int setup(void **state)
{
    return open_oiio(state) || make_folder(state);
}

SUITE_OF(oiio_formats, setup, remove_folder, written_formats_come_back, claims,
         cut_off, formats_that_are_not_read, readers_that_are_never_asked,
         endings)
