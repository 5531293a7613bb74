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

#include <signal.h>
#include <sys/resource.h>

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

static struct gp_image picture(float *pixels, int channels, const char *space)
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
        struct gp_image image = picture(pixels, n, row[i].space);
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

/* Coverage is stored as it is; in integers it has not been multiplied into
 * the colour, which a reader does. */
static void alpha_of_every_type(void **state)
{
    static const struct {
        const char *format, *type;
        bool associated;
        float error;
    } row[] = {
        {"tif", "float", true, 0.0f},   {"tif", "half", true, 5e-4f},
        {"tif", "uint8", false, 4e-3f}, {"tif", "uint16", false, 2e-5f},
        {"tga", "uint8", false, 4e-3f},
    };
    static float pixels[] = {1.0f, 0.5f, 0.0f, 1.0f, 0.8f, 0.4f, 0.2f, 0.5f};
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_image back, image = image_of(pixels, 2, 1, rgba, 4, "");
        in_folder("alpha");
        image.colour_space = i % 2 ? "" : "Linear";
        assert_ok(write_image(path, row[i].format, &image, row[i].type, ""));
        assert_ok(read_image(path, 2, &back));
        assert_int_equal(back.channels, 4);
        for (int k = 0; k < 8; k++) {
            const float alpha = pixels[k / 4 * 4 + 3];
            const float want = row[i].associated || k % 4 == 3
                                   ? pixels[k] : pixels[k] * alpha;
            if (!(fabsf(back.pixels[k] - want) <= row[i].error))
                fail_msg("%s %s: sample %d is %g, not %g", row[i].format,
                    row[i].type, k, (double) back.pixels[k], (double) want);
        }
        gp_image_close(&back);
    }
}

/* Blocks of rows are the rows of the whole; each four channels count. */
static void blocks_and_channels(void **state)
{
    enum { BW = 700, BH = 2500 };
    struct gp_frame f;
    need_oiio();
    float *const pixels = malloc(sizeof(float) * 3 * BW * BH);
    assert_non_null(pixels);
    struct gp_image image = picture(pixels, 3, "Linear");
    for (int i = 0; i < 3 * BW * BH; i++)
        pixels[i] = (float) i;
    image.data = image.display = (struct gp_rect) {0, 0, BW, BH};
    in_folder("blocks.tif");
    assert_ok(write_image(path, "tif", &image, "float", ""));
    assert_ok(read_file(path, &f));
    for (int i = 0; i < 3 * BW * BH; i++)
        assert_true(f.rgb.c[i % 3][i / 3] == pixels[i]);
    gp_frame_free(&f);
    image = image_of(pixels, 10, 10, rgba, 9, "Linear");
    assert_ok(write_image(path, "tif", &image, "float", ""));
    assert_int_equal(read_image(path, 299, &image), GP_ERR_DATA);
    assert_kept("9 channels");
    assert_ok(read_image(path, 300, &image));
    gp_image_close(&image);
    gp_image_close(&image); // again is nothing
    free(pixels);
}

/* Alpha is carried, not bent by the curve, and attributes are kept. */
static void alpha_and_attributes(void **state)
{
    float pixels[4 * PIXELS];
    struct gp_frame f;
    need_oiio();
    for (int i = 0; i < 4 * PIXELS; i++)
        pixels[i] = i % 4 == 3 ? 1.0f - (float) (i / 4) / 400.0f : 0.25f;
    const struct gp_image image = image_of(pixels, W, H, rgba, 4, "Linear");
    in_folder("alpha.tif");
    assert_ok(write_image(path, "tif", &image, "float", ""));
    assert_ok(read_file(path, &f));
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

/* As in an EXR, what a picture would show counts. */
static void display_window_that_lies(void **state)
{
    const struct gp_read_params p = {.max_pixels = 1000};
    float pixels[3 * PIXELS];
    struct gp_image image = picture(pixels, 3, "Linear");
    need_oiio();
    in_folder("shown.tif");
    for (int h = 25; h < 27; h++) {
        struct gp_frame f = {0};
        image.display = (struct gp_rect) {0, 0, 40, h};
        assert_ok(write_image(path, "tif", &image, "half", ""));
        kept_clear();
        assert_int_equal(gp_read_frame(&kept_log, &p, path, &f),
                         h == 25 ? GP_OK : GP_ERR_DATA);
        assert_int_equal(kept_errors, h - 25);
        gp_frame_free(&f);
    }
    assert_kept("shown.tif: ");
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

// -- TIFFs made byte by byte -----------------------------------------------

/* One directory after the pixels, Intel's order, each field with the one value
 * that fits into it. */

enum { TIFF_FIELDS = 16, TIFF_PIXELS = 8, TIFF_ROOM = 8192 };

/* Ends with tag 0. A value of short goes into two bytes, two of them into
 * four. */
struct tiff_field {
    int tag, type, count;
    uint32_t value;
};
#define TIFF_SHORT(tag, value) {tag, 3, 1, value}
#define TIFF_LONG(tag, value) {tag, 4, 1, value}

static size_t tiff_put(uint8_t *to, uint64_t v, int n)
{
    for (int i = 0; i < n; i++)
        to[i] = (uint8_t) (v >> 8 * i);
    return (size_t) n;
}

/* `pixels` of `size` bytes at TIFF_PIXELS; returns the bytes of it all. */
static size_t tiff_make(const struct tiff_field *field, const void *pixels,
                        size_t size, uint8_t to[TIFF_ROOM])
{
    int n = 0;
    while (field[n].tag)
        n++;
    assert_true(n <= TIFF_FIELDS && size < TIFF_ROOM - 256);
    size_t at = TIFF_PIXELS + (size + 1) / 2 * 2;
    memset(to, 0, TIFF_ROOM);
    memcpy(to, "II*\0", 4);
    tiff_put(to + 4, at, 4);
    memcpy(to + TIFF_PIXELS, pixels, size);
    at += tiff_put(to + at, (uint64_t) n, 2);
    for (int i = 0; i < n; i++) {
        at += tiff_put(to + at, (uint64_t) field[i].tag, 2);
        at += tiff_put(to + at, (uint64_t) field[i].type, 2);
        at += tiff_put(to + at, (uint64_t) field[i].count, 4);
        at += tiff_put(to + at, field[i].value, 4);
    }
    return at + tiff_put(to + at, 0, 4);
}

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
    static const struct {
        const char *name;
        struct tiff_field field[TIFF_FIELDS];
    } row[] = {
        {"large tiles", {GREY(4, 4, 8), TILE(8192, 8192, 4096)}},
        {"doubles",
         {GREY(16, 16, 64), TILE(16, 16, 2048), TIFF_SHORT(339, 3)}},
        {"deep tiles",
         {GREY(16, 16, 8), TILE(16, 16, 512), TIFF_LONG(32998, 2)}},
        // LZW that begins with a code of no string, which libtiff reads past
        {"damaged",
         {TIFF_LONG(256, 4), TIFF_LONG(257, 4), TIFF_SHORT(258, 8),
          TIFF_SHORT(259, 5), TIFF_SHORT(262, 1), STRIP(4, 16)}},
        {"many", {GREY(1024, 1025, 8), STRIP(1025, 16)}},
    };
    static const double none[512];
    uint8_t bytes[TIFF_ROOM];
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++)
        refused(row[i].name, bytes, tiff_make(row[i].field, none, 2048, bytes));
}

/* Neighbours of what is refused. */
static void tiffs_that_are_read(void **state)
{
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
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_image a;
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
            fail_msg("%s: %s", row[i].name, kept_line);
        for (int k = 0; k < 16; k++) {
            const int stored = k / 4 * row[i].w + k % 4;
            assert_true(fabs((double) a.pixels[k] - stored / 255.0) < 1e-7);
        }
        gp_image_close(&a);
    }
}

#define FAR (1 << 29)

static void odd_exrs(void **state)
{
    static const struct {
        const char *name;
        bool bad;
        exr_attr_box2i_t data, display;
    } row[] = {
        {"far right", true, FIXTURE_WINDOW(FAR, 0, 2, 2), W(2)},
        {"far left", true, FIXTURE_WINDOW(-FAR, 0, 2, 2), W(2)},
        {"display", true, W(2), FIXTURE_WINDOW(0, 0, 2, FAR)},
        {"near", false, FIXTURE_WINDOW(1 - FAR, FAR - 2, 2, 2),
         FIXTURE_WINDOW(0, 0, FAR - 1, 2)},
    };
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct fixture f = {
            .display = row[i].display,
            .part = {{.channel = {RGB(HALVES)}, .data = row[i].data,
                      .compression = EXR_COMPRESSION_ZIPS}},
        };
        struct gp_image a;
        size_t n;
        uint8_t *const bytes = fixture_make(&f, &n);
        if (row[i].bad) {
            refused(row[i].name, bytes, n);
        } else {
            if (read_bytes(bytes, n, 4, &a))
                fail_msg("%s: %s", row[i].name, kept_line);
            assert_int_equal(a.data.x0, 1 - FAR);
            assert_int_equal(a.data.y0, FAR - 2);
            assert_int_equal(gp_rect_w(a.display), FAR - 1);
            assert_true(a.pixels[0] ==
                        fixture_value("R", a.data.x0, a.data.y0));
            gp_image_close(&a);
        }
        free(bytes);
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
    const struct gp_image image = picture(pixels, 3, "");
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_image a;
        size_t size;
        in_folder("cut");
        assert_ok(write_image(path, row[i].format, &image, row[i].type,
                              row[i].compression));
        uint8_t *const bytes = wf_read(path, &size);
        if (read_bytes(bytes, size, PIXELS, &a))
            fail_msg("%s", kept_line);
        gp_image_close(&a);
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
        {"\x53\x80\xf6\x34 a scene", "reads (Softimage PIC); "},
        {"SIMPLE  =                    T", "reads (FITS); "},
        {"8BPS\0\1", "reads (Photoshop); "}, {"DDS |", "reads (DDS); "},
        {"GIF89a", "reads (GIF); "}, {"FOR4\0\0\0", "reads (IFF); "},
        {"\x80\x2a\x5f\xd7", "reads (Cineon); "},
        {"ffconcat version 1.0\nfile a", "reads (ffmpeg playlist); "},
        {"#EXTM3U\nhttp://a", "reads (M3U playlist); "},
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
    const struct gp_image image = picture(pixels, 3, "");
    need_oiio();
    in_folder("a.tif");
    assert_ok(write_image(path, "tif", &image, "uint8", ""));
    size_t size;
    uint8_t *const bytes = wf_read(path, &size);
    struct gp_stream s = gp_stream_of(bytes, size);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_image got = {0};
        const gp_status st = gp_oiio_open(&kept_log, path, &s, row[i], 0,
                                          PIXELS, &got);
        if (st != GP_ERR_DATA || !strstr(kept_line, "not a format"))
            fail_msg("%s: status %d, %s", row[i], (int) st, kept_line);
    }
    for (const struct gp_reader *r = gp_readers; r->format; r++) {
        struct gp_image got = {0};
        const bool tiff = r->oiio && strcmp(r->oiio, "tiff") == 0;
        const gp_status st = r->oiio ? gp_oiio_open(&kept_log, path, &s,
            r->oiio, 0, PIXELS, &got) : GP_ERR_DATA;
        if (st != (tiff ? GP_OK : GP_ERR_DATA) ||
            (r->oiio && !tiff && strstr(kept_line, "not a format")))
            fail_msg("%s: status %d, %s", r->format, (int) st, kept_line);
        gp_image_close(&got);
    }
    free(bytes);
}

// -- pictures of frames -------------------------------------------------------

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
    struct gp_frame f = wf_sized(40, 30, wf_rgb);
    need_oiio();
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        p.compression = row[i].compression;
        p.depth_bits = row[i].depth_bits;
        const gp_status st = wf_write(&p, "a.tif", &f, row[i].kind);
        if (st != (row[i].packing ? GP_OK : GP_ERR_USAGE))
            fail_msg("row %d: %s", (int) i, kept_line);
        if (st) {
            assert_kept("a.tif: ");
            assert_int_equal(access(wf_path("a.tif"), F_OK), -1);
            continue;
        }
        assert_int_equal(tiff_field("a.tif", 259), row[i].packing);
        assert_int_equal(tiff_field("a.tif", 258), row[i].bits);
        remove(wf_path("a.tif"));
    }
    gp_frame_free(&f);
    f = wf_sized(16384, 1, wf_rgb); // more than WebP has
    assert_int_equal(wf_write(NULL, "a.webp", &f, GP_PICTURE_SHOWN), GP_ERR_IO);
    assert_kept("a.webp: ");
    assert_int_equal(access(wf_path("a.webp"), F_OK), -1);
    gp_frame_free(&f);
}

/* Under a limit in the midst of the pixels: one line, and no file. */
static void pictures_that_do_not_fit(void **state)
{
    static const struct {
        const char *name;
        bool helper;
    } row[] = {
        {"a.png", false}, {"a.pfm", false}, {"a.tif", true}, {"a.sgi", true},
    };
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_sized(900, 900, wf_rgb);
    p.depth_bits = 16;
    for (size_t i = 0; i < 3 * gp_frame_pixels(&f); i++)
        f.rgb.c[i % 3][i / 3] =
            (float) (wf_hash((uint32_t) i, 1, 2) >> 8) / 0x1p24f;
    void (*const handler)(int) = signal(SIGXFSZ, SIG_IGN);
    for (size_t i = 0; i < COUNT(row); i++) {
        if (row[i].helper && !has_oiio)
            continue;
        const int before = wf_names();
        struct rlimit was, now;
        assert_int_equal(getrlimit(RLIMIT_FSIZE, &was), 0);
        now = (struct rlimit) {1500000, was.rlim_max};
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &now), 0);
        const gp_status st = wf_write(&p, row[i].name, &f, GP_PICTURE_SHOWN);
        setrlimit(RLIMIT_FSIZE, &was);
        assert_int_equal(st, GP_ERR_IO);
        assert_kept(row[i].name);
        assert_int_equal(wf_names(), before);
        assert_ok(wf_write(&p, row[i].name, &f, GP_PICTURE_SHOWN));
        remove(wf_path(row[i].name));
    }
    signal(SIGXFSZ, handler);
    gp_frame_free(&f);
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

SUITE_OF(oiio_formats, setup, remove_folder, written_formats_come_back,
         alpha_of_every_type, blocks_and_channels, alpha_and_attributes,
         display_window_that_lies, claims, odd_tiffs, tiffs_that_are_read,
         odd_exrs, cut_off, formats_that_are_not_read,
         readers_that_are_never_asked, tiffs_of_every_kind,
         pictures_that_do_not_fit, endings)
