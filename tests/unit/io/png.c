// SPDX-License-Identifier: Apache-2.0
/* PNG out: pixels, windows, alpha, colour chunks. */
#include "unit.h"
#include "write_fixture.h"
#include "core/bytes.h"
#include "core/colour.h"
#include "io/io_priv.h"

#include <png.h>

/* A PNG read back by libpng, and its bytes. */
struct png {
    int w, h, channels, bits;
    uint8_t *bytes;   // w * h * channels samples, big-endian if 16 bits
    uint8_t *file;
    size_t size;
};

static struct png read_png(const char *path)
{
    struct png p = {0};
    p.file = wf_read(path, &p.size);
    FILE *f = fopen(path, "rb");
    png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, NULL,
                                             NULL, NULL);
    png_infop info = png_create_info_struct(png);
    png_init_io(png, f);
    png_read_png(png, info, PNG_TRANSFORM_IDENTITY, NULL); // aborts if bad
    p.w = (int) png_get_image_width(png, info);
    p.h = (int) png_get_image_height(png, info);
    p.channels = png_get_channels(png, info);
    p.bits = png_get_bit_depth(png, info);
    const size_t row = png_get_rowbytes(png, info);
    p.bytes = malloc(row * (size_t) p.h);
    for (int y = 0; y < p.h; y++)
        memcpy(p.bytes + (size_t) y * row, png_get_rows(png, info)[y], row);
    png_destroy_read_struct(&png, &info, NULL);
    fclose(f);
    return p;
}

/* Writes a.png and reads it. */
static struct png write_png(const struct gp_write_params *p,
    const struct gp_frame *f, enum gp_picture_kind kind)
{
    assert_ok(wf_write(p, "a.png", f, kind));
    return read_png(wf_path("a.png"));
}

static void free_png(struct png *p)
{
    free(p->bytes);
    free(p->file);
}

static int sample(const struct png *p, int x, int y, int c)
{
    const size_t i = ((size_t) y * (size_t) p->w + (size_t) x) *
                     (size_t) p->channels + (size_t) c;
    return p->bits == 8 ? p->bytes[i]
                        : p->bytes[2 * i] << 8 | p->bytes[2 * i + 1];
}

/* Values that fill [0, 1] and go past both ends. */
static void fill_unit(struct gp_frame *f)
{
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < gp_frame_pixels(f); i++)
            f->rgb.c[c][i] = f->rgb.c[c][i] / 12.0f + 0.5f;
    }
}

static int plain(float v, int bits)
{
    return (int) (gp_srgb_encode(v) * (float) ((1 << bits) - 1) + 0.5f);
}

/* Every pixel of every window, against the plain formula. */
static void pixels_and_windows(void **state)
{
    static const struct {
        struct gp_rect data, display;
    } rows[] = {
        {{0, 0, 1, 1}, {0, 0, 1, 1}}, {{0, 0, 67, 45}, {0, 0, 67, 45}},
        {{-5, -7, 30, 21}, {0, 0, 20, 10}},   // overscan
        {{3, 4, 13, 9}, {0, 0, 20, 17}},      // a part of the picture
        {{-9, 2, 5, 8}, {-4, -3, 12, 5}},     // both
        {{50, 50, 60, 60}, {0, 0, 7, 5}},     // nothing in common
        {{0, 0, 257, 1}, {0, 0, 257, 1}}, {{0, 0, 1, 300}, {0, 0, 1, 300}},
    };
    for (size_t i = 0; i < 2 * COUNT(rows); i++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        const struct gp_rect data = rows[i / 2].data;
        const struct gp_rect display = rows[i / 2].display;
        struct gp_frame f = wf_frame(data, display, wf_rgb);
        fill_unit(&f);
        p.depth_bits = i % 2 ? 16 : 8;
        p.dither = i % 2 ? GP_DITHER_8_BITS : GP_DITHER_NEVER;
        struct png png = write_png(&p, &f, GP_PICTURE_SHOWN);
        assert_int_equal(png.w, gp_rect_w(display));
        assert_int_equal(png.h, gp_rect_h(display));
        assert_int_equal(png.bits, p.depth_bits);
        assert_int_equal(png.channels, 3);
        for (int k = 0; k < png.w * png.h * 3; k++) {
            const int c = k % 3, x = k / 3 % png.w, y = k / 3 / png.w;
            const int dx = x + display.x0 - data.x0;
            const int dy = y + display.y0 - data.y0;
            const bool in = dx >= 0 && dx < gp_rect_w(data) && dy >= 0 &&
                            dy < gp_rect_h(data);
            const float v = in ? f.rgb.c[c][dy * gp_rect_w(data) + dx] : 0.0f;
            assert_int_equal(sample(&png, x, y, c), plain(v, p.depth_bits));
        }
        free_png(&png);
        gp_frame_free(&f);
    }
}

/* Light over alpha: the picture over black is the picture without alpha. */
static void alpha_keeps_light(void **state)
{
    static const struct wf_channel layered[] = {
        {"A", GP_HALF, -1, 0, 0}, {"l.R", GP_HALF, 0, 0, 0},
        {"l.G", GP_HALF, 1, 0, 0}, {"l.B", GP_HALF, 2, 0, 0},
        {"l.Alpha", GP_FLOAT, -1, 0, 0}, {NULL, 0, 0, 0, 0},
    };
    static const float alpha[8] = {0, 0, 0.5f, 0.5f, 1, 1, 0.25f, NAN};
    static const float light[8] = {0, 0.7f, 0.25f, 0.9f, 0.3f, 5, -1, 0.1f};
    static const double want[8] = {0, 0.7, 0.5, 0.9, 1, 1, 0.25, 0.1};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_sized(8, 1, layered);
    memcpy(f.channel[4].data, alpha, sizeof alpha);
    for (int c = 0; c < 3; c++) {
        for (int x = 0; x < 8; x++)
            f.rgb.c[c][x] = light[x] / (float) (c + 1);
    }
    p.alpha = GP_ALPHA_KEEP;
    p.depth_bits = 16;
    struct png png = write_png(&p, &f, GP_PICTURE_SHOWN);
    assert_int_equal(png.channels, 4);
    for (int x = 0; x < 8; x++) {
        const double a = sample(&png, x, 0, 3) / 65535.0;
        assert_true(fabs(a - want[x]) < 1e-5);
        for (int c = 0; c < 3; c++) {
            const double over = a * (double) gp_srgb_decode((float) sample(&png,
                x, 0, c) / 65535.0f);
            const double v = (double) f.rgb.c[c][x];
            const double shown = v > 1 ? 1 : v > 0 ? v : 0;
            assert_true(fabs(over - shown) < 3e-5);
        }
    }
    free_png(&png);
    p.alpha = GP_ALPHA_BLACK; // the same light with no alpha at all
    png = write_png(&p, &f, GP_PICTURE_SHOWN);
    assert_int_equal(png.channels, 3);
    for (int x = 0; x < 8; x++)
        assert_int_equal(sample(&png, x, 0, 0), plain(f.rgb.c[0][x], 16));
    free_png(&png);
    gp_frame_free(&f);
}

/* OpenImageIO would write the time into TIFF, its stack into SGI, the number of
 * a descriptor into DPX. */
static void bytes_hold_no_time_and_no_memory(void **state)
{
    static const struct {
        const char *name;
        size_t at, n; // bytes that must be 0
    } row[] = {{"a.tif", 0, 0}, {"a.sgi", 24, 80}, {"a.dpx", 36, 100}};
    static const uint8_t none[100] = {0};
    struct gp_frame f = wf_sized(5, 3, wf_rgb);
    if (!wf_bridge())
        skip_for("no OpenImageIO");
    for (size_t i = 0; i < COUNT(row); i++) {
        size_t size;
        assert_ok(wf_write(NULL, row[i].name, &f, GP_PICTURE_SHOWN));
        uint8_t *const bytes = wf_read(wf_path(row[i].name), &size);
        assert_true(size >= row[i].at + row[i].n);
        assert_memory_equal(bytes + row[i].at, none, row[i].n);
        free(bytes);
    }
    usleep(1100000); // TIFF counts seconds
    assert_ok(wf_write(NULL, "b.tif", &f, GP_PICTURE_SHOWN));
    wf_assert_same(wf_path("a.tif"), wf_path("b.tif"));
    gp_frame_free(&f);
}

/* The first bytes of a chunk's data, NULL without such a chunk. */
static const uint8_t *chunk_of(const struct png *p, const char *type)
{
    for (size_t at = 8; at + 12 <= p->size; at += 12 + gp_be32(p->file + at)) {
        if (memcmp(p->file + at + 4, type, 4) == 0)
            return p->file + at + 8;
    }
    return NULL;
}

/* cHRM with gAMA, and pHYs, where PNG can hold what they would say; the
 * standard's names where the picture is shown, or its primaries are sRGB's. */
static void colour_chunks(void **state)
{
#define PRIMARIES(red_x)                                                      \
    {red_x, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f}
    static const struct {
        enum gp_picture_kind kind;
        float primaries[8], aspect;
        bool srgb;
        unsigned red_x;         // of cHRM, 0 without
        unsigned x, y;          // of pHYs, pixels of a unit; 0 without
    } row[] = {
        {GP_PICTURE_SHOWN, PRIMARIES(0.64f), 1.0f, true, 64000, 0, 0},
        {GP_PICTURE_SCENE, PRIMARIES(0.64f), 2.0f, true, 64000, 5000, 10000},
        {GP_PICTURE_SCENE, PRIMARIES(0.65f), 0.5f, false, 65000, 20000, 10000},
        {GP_PICTURE_SHOWN, PRIMARIES(0.65f), 9999.0f, true, 64000, 1, 10000},
        // primaries and shapes that PNG cannot hold
        {GP_PICTURE_SCENE, {0.7347f, 0.2653f, 0, 1, 0.0001f, -0.077f, 0.32168f,
                            0.33767f}, 1e5f, false, 0, 0, 0}, // AP0
        {GP_PICTURE_SCENE, PRIMARIES(0.7f), 1e-5f, false, 0, 0, 0},
        {GP_PICTURE_SCENE, {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f},
         0.0f, false, 0, 0, 0},
        {GP_PICTURE_SCENE, PRIMARIES(NAN), NAN, false, 0, 0, 0},
        {GP_PICTURE_SCENE, {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f,
                            0}, -2.0f, false, 0, 0, 0},
        {GP_PICTURE_SCENE, PRIMARIES(INFINITY), INFINITY, false, 0, 0, 0},
    };
    struct gp_frame f = wf_sized(3, 2, wf_rgb);
    for (size_t i = 0; i < COUNT(row); i++) {
        memcpy(f.chromaticities, row[i].primaries, sizeof f.chromaticities);
        f.pixel_aspect = row[i].aspect;
        struct png png = write_png(NULL, &f, row[i].kind);
        const uint8_t *const chrm = chunk_of(&png, "cHRM");
        const uint8_t *const phys = chunk_of(&png, "pHYs");
        assert_int_equal(chunk_of(&png, "sRGB") != NULL, row[i].srgb);
        assert_int_equal(chunk_of(&png, "cICP") != NULL, row[i].srgb);
        if (chrm)
            assert_int_equal(gp_be32(chunk_of(&png, "gAMA")), 45455);
        assert_int_equal(chrm ? gp_be32(chrm + 8) : 0, row[i].red_x);
        assert_int_equal(phys ? gp_be32(phys) : 0, row[i].x);
        assert_int_equal(phys ? gp_be32(phys + 4) : 0, row[i].y);
        free_png(&png);
    }
    gp_frame_free(&f);
}

SUITE_OF_EACH(png, wf_start, remove_folder, pixels_and_windows,
              alpha_keeps_light, colour_chunks, bytes_hold_no_time_and_no_memory)
