// SPDX-License-Identifier: Apache-2.0
/* io/stored: every channel as stored, and which of them are light. */
#include "bridge_here.h"
#include "exr_fixture.h"
#include "io/read.h"
#include "reading.h"
#include "unit.h"

#define WIDE FIXTURE_WINDOW(0, 0, 512, 1)

static const struct gp_read_params limits = GP_READ_DEFAULTS;

/* Reads part 0 of a fixture. */
static gp_status read_fixture(const struct fixture *f,
                              struct gp_stored_image *out)
{
    struct gp_stored_file file;
    fixture_write_file(in_folder("a.exr"), f);
    *out = (struct gp_stored_image) {0};
    gp_status st = gp_stored_open(&kept_log, &limits, path, &file);
    if (!st)
        st = gp_stored_read(&kept_log, &limits, &file, 0, out);
    gp_stored_close(&file);
    return st;
}

static const struct glarepp_channel *channel_of(
    const struct gp_stored_image *image, const char *name)
{
    const struct glarepp_channel *c = image->channel;
    while (strcmp(c->name, name) != 0)
        c++;
    return c;
}

static void light(void **state)
{
    static const struct {
        struct fixture f;
        const char *light[3]; // channels; NULL: no light at all
    } row[] = {
        {{.part = {{.channel = {RGB(HALVES)}, .data = WIDE}}}, {"R", "G", "B"}},
        {{.part = {{.channel = {HALF_CH("Y")}, .data = WIDE}}},
         {"Y", "Y", "Y"}},
        // the chroma is no light of its own
        {{.part = {{.channel = {{"BY", HALVES, 2, 1}, {"RY", HALVES, 2, 1},
                                HALF_CH("Y")}, .data = WIDE}}},
         {"Y", "Y", "Y"}},
        // one of the three is missing, or whole numbers
        {{.part = {{.channel = {HALF_CH("G"), HALF_CH("R")},
                    .data = WIDE}}}, {NULL}},
        {{.part = {{.channel = {HALF_CH("B"), UINT_CH("G"),
                                HALF_CH("R")}, .data = WIDE}}},
         {NULL}},
        {{.part = {{.channel = {HALF_CH("u"), HALF_CH("v")},
                    .data = WIDE}}}, {NULL}},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_stored_image image;
        assert_ok(read_fixture(&row[i].f, &image));
        for (int c = 0; c < 3; c++) {
            const char *name = row[i].light[c];
            if (image.light[c] != (name ? channel_of(&image, name)->v : NULL))
                fail_msg("row %d, colour %d", (int) i, c);
        }
        gp_stored_image_free(&image);
    }
}

/* At full resolution, uint as floats only where it was subsampled. */
static void samples(void **state)
{
    static const struct fixture f = {
        .part = {{.channel = {{"few", EXR_PIXEL_UINT, 2, 2},
                              {"half", HALVES, 2, 1}, UINT_CH("id")},
                  .data = FIXTURE_WINDOW(-4, 2, 8, 6)}},
    };
    struct gp_stored_image image;
    assert_ok(read_fixture(&f, &image));
    const struct glarepp_channel *const id = channel_of(&image, "id"),
                                   *const few = channel_of(&image, "few"),
                                   *const half = channel_of(&image, "half");
    assert_true(id->is_uint);
    assert_false(few->is_uint);
    assert_false(half->is_uint);
    for (int i = 0; i < 48; i++) {
        const int x = i % 8 - 4, y = i / 8 + 2;
        assert_int_equal(((const uint32_t *) id->v)[i],
                         fixture_uint("id", x, y));
        assert_true(((const float *) few->v)[i] ==
                    (float) fixture_uint("few", x & ~1, y & ~1));
        assert_true(((const float *) half->v)[i] ==
                    fixture_value("half", x & ~1, y));
    }
    gp_stored_image_free(&image);
}

static void header(void **state)
{
    struct fixture f = {
        .chromaticities = true, .display = FIXTURE_WINDOW(-3, -2, 100, 50),
        .part = {{.channel = {RGB(HALVES)}, .data = WIDE}},
    };
    struct gp_stored_image image;
    assert_ok(read_fixture(&f, &image));
    assert_true(image.chromaticities[0] == fixture_ap0.red_x);
    assert_true(image.chromaticities[5] == fixture_ap0.blue_y);
    assert_true(image.chromaticities[7] == fixture_ap0.white_y);
    assert_int_equal(image.display.x0, -3);
    assert_int_equal(image.display.y1, 48);
    assert_int_equal(image.data.x1, 512);
    assert_null(image.first);
    gp_stored_image_free(&image);

    f.part[0].deep = true; // whose chunks were never written
    assert_int_equal(read_fixture(&f, &image), GP_ERR_DATA);
}

/* Says of a file's chunks, which are ZIP, that they are DWAA. Of so few rows
 * both have one chunk. */
static void call_dwaa(const struct fixture *f)
{
    static const char name[] = "compression\0compression\0\1\0\0";
    size_t size;
    uint8_t *bytes = fixture_make(f, &size);
    uint8_t *at = memmem(bytes, size, name, sizeof name);
    assert_non_null(at);
    assert_int_equal(at[sizeof name], EXR_COMPRESSION_ZIP);
    at[sizeof name] = EXR_COMPRESSION_DWAA;
    fixture_save(in_folder("dwaa.exr"), bytes, size);
    free(bytes);
}

static void dwa_that_is_none(void **state)
{
    static const struct {
        struct fixture f;
        const char *says; // the bridge, if there is one
    } row[] = {
        {{.part = {{.channel = {RGB(HALVES)}, .data = WIDE,
                    .compression = EXR_COMPRESSION_ZIP}}}, "; "},
        {{.part = {{.channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2},
                                HALF_CH("Y")},
                    .data = FIXTURE_WINDOW(0, 0, 512, 2),
                    .compression = EXR_COMPRESSION_ZIP}}},
         "Subsampled channels"},
        {{.part = {{.channel = {RGB(HALVES), {"low", HALVES, 0, 2}},
                    .data = FIXTURE_WINDOW(0, 0, 512, 2),
                    .compression = EXR_COMPRESSION_ZIP}}},
         "(channel \"low\" has"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame f;
        call_dwaa(&row[i].f);
        const gp_status st = read_file(path, &f);
        assert_true(st == GP_ERR_DATA || st == GP_ERR_IO);
        assert_int_equal(kept_errors, 1);
        if (!strstr(kept_line, st == GP_ERR_DATA ? row[i].says : "; "))
            fail_msg("row %d: %s", (int) i, kept_line);
        assert_null(f.rgb.c[0]);
    }
}

static int start(void **state)
{
    return find_bridges(state) || make_folder(state);
}

SUITE_OF(stored, start, remove_folder, light, samples, header, dwa_that_is_none)
