// SPDX-License-Identifier: Apache-2.0
/* io/decoded: pictures of other formats than EXR, made frames; portable float
 * maps, which io reads itself. */
#include "unit.h"
#include "core/colour.h"
#include "core/half.h"
#include "core/memory.h"
#include "io/decoded.h"
#include "io/io_priv.h"
#include "exr_fixture.h"
#include "reading.h"

static const char *const rgba[] = {"R", "G", "B", "A"};

/* A row of pixels; its windows are right. */
static struct gp_decoded row_of(const char *const *names, int channels,
                              float *pixels, int w)
{
    return (struct gp_decoded) {
        .path = "a.tif", .data = {0, 0, w, 1}, .display = {0, 0, w, 1},
        .channels = channels, .channel_name = names, .pixels = pixels,
        .colour_space = "",
    };
}

static gp_status make_frame_of(const char *layer, struct gp_decoded *image,
                      struct gp_frame *f)
{
    kept_clear();
    *f = (struct gp_frame) {0};
    return gp_decoded_frame(&kept_log, layer, image, f);
}

/* Values from the curves' definitions, by another program. 0.5 lies between
 * two codes of 16 bits; the second value is a code. */
static void curves(void **state)
{
    const float code = 13107.0f / 65535.0f; // 0.2
    const struct {
        const char *space;
        int bits;
        float half, fifth, error;
    } row[] = {
        {"sRGB", 8, 0.2140411f, 0.0331048f, 1e-6f},
        {"srgb", 16, 0.2140411f, 0.0331048f, 1e-6f},
        {"", 8, 0.2140411f, 0.0331048f, 1e-6f}, {"", 16, 0.5f, 0.2f, 0.0f},
        {"sRGB", 0, 0.5f, 0.2f, 0.0f},
        {"Rec709", 10, 0.2595894f, 0.0554267f, 1e-6f},
        {"KodakLog", 10, 0.2560047f, 0.0143996f, 1e-6f},
        {"cineon", 10, 0.2560047f, 0.0143996f, 1e-6f},
        {"Gamma2.2", 8, 0.2176376f, 0.0289912f, 1e-6f},
        {"GammaCorrected 1.75", 8, 0.2973018f, 0.0598140f, 1e-6f},
        {"Gamma2.2:1", 8, 0.2176376f, 0.0289912f, 1e-6f},
        {"Gamma 2.2 ", 8, 0.2176376f, 0.0289912f, 1e-6f},
        {"gamma3", 16, 0.125f, 0.008f, 1e-6f}, {"Gamma", 8, 0.5f, 0.2f, 0.0f},
        {"Linear", 8, 0.5f, 0.2f, 0.0f}, {"ACEScg", 16, 0.5f, 0.2f, 0.0f},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        float pixels[] = {0.5f, 0.5f, 0.5f, 0.5f, code, code, code, code};
        struct gp_decoded image = row_of(rgba, 4, pixels, 2);
        struct gp_frame f;
        image.colour_space = row[i].space;
        image.bits = row[i].bits;
        assert_ok(make_frame_of(NULL, &image, &f));
        for (int c = 0; c < 3; c++) {
            const float *v = f.rgb.c[c];
            if (!(fabsf(v[0] - row[i].half) <= row[i].error &&
                  fabsf(v[1] - row[i].fifth) <= row[i].error))
                fail_msg("%s, %d bits: %.8g %.8g", row[i].space, row[i].bits,
                         (double) v[0], (double) v[1]);
        }
        // coverage has no curve
        const float *a = gp_frame_channel(&f, "A")->data;
        assert_true(a[0] == 0.5f && a[1] == code);
        gp_frame_free(&f);
    }
}

/* Luminance and chroma are EXR's alone. */
static void no_such_layer(void **state)
{
    static const char *const chroma[] = {"sky.BY", "sky.RY", "sky.Y", "A"};
    float pixels[4] = {0};
    for (int i = 0; i < 2; i++) {
        struct gp_decoded image = row_of(i ? chroma : rgba, 4, pixels, 1);
        struct gp_frame f;
        assert_int_equal(make_frame_of("sky", &image, &f), GP_ERR_USAGE);
        assert_int_equal(kept_errors, 1);
        assert_kept("a.tif: ");
        assert_kept(i ? "(channels: sky.BY, sky.RY, " "sky.Y, A); "
                    : "(channels: R, G, B, A); ");
        assert_null(f.rgb.c[0]);
    }
}

static void windows_and_attributes(void **state)
{
    static const float weird[] = {0.713f, 0.293f, 0.165f, 0.83f,
                                  0.128f, 0.044f, 0.32168f, 0.33767f};
    static const float aspect[] = {2.0f, 0.0f, -1.0f, 1e9f, NAN, 1.0f};
    static const struct gp_attribute attribute[] = {
        {(char *) "owner", GP_ATTRIBUTE_TEXT, (char *) "me", 0, 0.0f},
        {(char *) "shots", GP_ATTRIBUTE_INT, NULL, 7, 0.0f},
    };
    for (size_t i = 0; i < COUNT(aspect); i++) {
        float pixels[] = {1.0f, 2.0f, 3.0f, 0.333333f};
        struct gp_decoded image = row_of(rgba, 4, pixels, 1);
        struct gp_frame f;
        image.data = (struct gp_rect) {-7, 3, -6, 4};
        image.half = true;
        image.display.x1 = i % 2 ? 40 : 0; // none: the data window
        image.pixel_aspect = aspect[i];
        image.attribute = attribute;
        image.attributes = 2;
        image.chromaticities = i % 2 ? weird : NULL;
        assert_ok(make_frame_of(NULL, &image, &f));
        assert_true(f.pixel_aspect == (i == 0 ? 2.0f : 1.0f));
        assert_int_equal(f.attributes, 2);
        assert_string_equal(f.attribute[0].text, "me");
        assert_int_equal(f.attribute[1].number, 7);
        assert_int_equal(f.data.x0, -7);
        assert_int_equal(f.data.y1, 4);
        assert_int_equal(f.display.x0, i % 2 ? 0 : -7);
        assert_int_equal(f.display.x1, i % 2 ? 40 : -6);
        assert_memory_equal(f.chromaticities, i % 2
            ? weird : gp_rec709_chromaticities, sizeof weird);
        const struct gp_channel *a = gp_frame_channel(&f, "A");
        uint16_t half;
        (void) gp_float_to_half(&pixels[3], &half, 1);
        assert_int_equal(a->type, GP_HALF);
        assert_int_equal(*(const uint16_t *) a->data, half);
        gp_frame_free(&f);
    }
}

/* Parts and views are looked at before the file is. */
static void parts_and_views(void **state)
{
    static const struct {
        const char *part, *view;
    } row[] = {
        {NULL, "left"}, {"beauty", NULL}, {"", NULL}, {"1b", NULL},
        {"-1", NULL}, {"123456789", NULL},
    };
    fixture_save(in_folder("a.tif"), "II*", 4);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_read_params p = GP_READ_DEFAULTS;
        struct gp_frame f = {0};
        p.part = row[i].part;
        p.view = row[i].view;
        kept_clear();
        assert_int_equal(gp_read_frame(&kept_log, &p, path, &f), GP_ERR_USAGE);
        assert_kept(path);
        assert_null(f.rgb.c[0]);
    }
}

enum { MOST = 1000 };

static const float sample[2][3] = {{0.25f, 300.0f, -1.0f},
                                   {1e-4f, 0.5f, 70000.0f}};

/* `head`, then both rows, from the bottom; with the other order of bytes. */
static size_t make_pfm(const char *head, bool swapped, uint8_t to[256])
{
    const size_t n = strlen(head);
    memcpy(to, head, n);
    memcpy(to + n, sample[1], 12);
    memcpy(to + n + 12, sample[0], 12);
    for (size_t i = n; swapped && i < n + 24; i += 4) {
        for (size_t k = 0; k < 2; k++) {
            const uint8_t byte = to[i + k];
            to[i + k] = to[i + 3 - k];
            to[i + 3 - k] = byte;
        }
    }
    return n + 24;
}

static gp_status open_bytes(const uint8_t *bytes, size_t n,
                            struct gp_decoded *image)
{
    static struct gp_stream s;
    s = gp_stream_of(bytes, n);
    *image = (struct gp_decoded) {0};
    kept_clear();
    return gp_pfm_open(&kept_log, "a.pfm", &s, MOST, image);
}

/* Values stay what they are, times the scale, and come from the top; where an
 * image ends is known by its header. */
static void headers(void **state)
{
    static const struct {
        const char *head;
        float scale;
        bool swapped;
    } row[] = {
        {"PF\n1 2\n-1.0\n", 1.0f, false}, {"PF 1 2 -1 ", 1.0f, false},
        {"PF\n1 2\n1.0\n", 1.0f, true},   {"PF\n1 2\n-2.5\n", 2.5f, false},
        {"PF\n1 2\n+25e-1\n", 2.5f, true}, {"PF\n\t1\r\n 2\v-1\f", 1, false},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        uint8_t bytes[256];
        struct gp_decoded image;
        uint64_t length = 0;
        const size_t n = make_pfm(row[i].head, row[i].swapped, bytes);
        struct gp_stream more = gp_stream_of(bytes, n + 9);
        assert_ok(gp_pfm_length(&more, &length));
        assert_int_equal(length, n);
        if (open_bytes(bytes, n, &image))
            fail_msg("row %zu: %s", i, kept_line);
        assert_int_equal(image.channels, 3);
        for (int k = 0; k < 6; k++)
            assert_true(image.pixels[k] == sample[k / 3][k % 3] * row[i].scale);
        gp_decoded_close(&image);
    }
}

static void damaged_headers(void **state)
{
    static const char *const head[] = {
        "PF", "PF\n", "PF\n1 2\n", "PF\n1 2\n-1.0", "PF\n0 2\n-1.0\n",
        "PF\n1 -2\n-1.0\n", "PF\n1 x\n-1.0\n", "PF\n1 2\n0\n",
        "PF\n1 2\nnan\n", "PF\n1 2\ninf\n", "PF\n1 2\n1e99\n",
        "PF\n4294967297 2\n-1.0\n", "PF\n1 99999999999999999999\n-1\n",
        "PF\n2147483647 2147483647\n-1\n", "PF\n1 1001\n-1\n",
        "PF\n1 3\n-1\n", "PF\n# 1 2 -1\n", "PF\n1 2 -1.0\0",
    };
    for (size_t i = 0; i < COUNT(head); i++) {
        uint8_t bytes[256] = {0};
        struct gp_decoded image;
        uint64_t length = 0;
        const size_t all = make_pfm(head[i], false, bytes);
        const size_t n = i < 4 ? strlen(head[i]) : all; // right up to there
        if (open_bytes(bytes, n, &image) != GP_ERR_DATA)
            fail_msg("%s", head[i]);
        assert_int_equal(kept_errors, 1);
        assert_null(image.pixels);
        struct gp_stream view = gp_stream_of(bytes, n);
        assert_ok(gp_pfm_length(&view, &length));
        if (length != 0 && length > n)
            fail_msg("%s: %d", head[i], (int) length);
    }
    // cut off anywhere
    uint8_t bytes[256];
    struct gp_decoded image;
    const size_t size = make_pfm("PF\n1 2\n-1.0\n", false, bytes);
    for (size_t n = 0; n < size; n++) {
        uint64_t length = 0;
        assert_int_equal(open_bytes(bytes, n, &image), GP_ERR_DATA);
        struct gp_stream view = gp_stream_of(bytes, n);
        assert_ok(gp_pfm_length(&view, &length));
        assert_int_equal(length, 0);
    }
}

SUITE_OF(decoded, make_folder, remove_folder, curves, no_such_layer,
         windows_and_attributes, parts_and_views, headers, damaged_headers)
