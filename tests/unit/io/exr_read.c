// SPDX-License-Identifier: Apache-2.0
/* io/read of EXR: every layout that the library can write. */
#include "unit.h"
#include "core/colour.h"
#include "core/parallel.h"
#include "io/channels.h"
#include "io/exr/exr_priv.h"
#include "exr_fixture.h"
#include "reading.h"

static void assert_frame_is(const struct gp_frame *f,
                            const struct fixture_part *p)
{
    const int w = gp_frame_w(f);
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *c = &f->channel[i];
        const struct fixture_channel *want = &p->channel[i];
        assert_string_equal(c->name, want->name);
        assert_int_equal(c->xs, want->xs ? want->xs : 1);
        if (c->colour < 0) {
            void *all = fixture_samples(want, f->data.x0, f->data.y0, w,
                                        gp_frame_h(f));
            assert_memory_equal(c->data, all,
                (size_t) c->w * (size_t) c->h * gp_type_size(c->type));
            free(all);
            continue;
        }
        for (int y = 0; y < gp_frame_h(f); y++) {
            for (int x = 0; x < w; x++) {
                int px = f->data.x0 + x, py = f->data.y0 + y;
                float v = want->type == EXR_PIXEL_UINT
                              ? (float) fixture_uint(c->name, px, py)
                              : fixture_value(c->name, px, py);
                assert_true(f->rgb.c[c->colour][y * w + x] == v);
            }
        }
    }
}

static void every_layout(void **state)
{
    static const struct fixture_part row[] = {
        {.channel = {RGB(HALVES)}, .data = W(1)},
        {.channel = {RGB(HALVES)}, .data = FIXTURE_WINDOW(0, 0, 67, 1)},
        {.channel = {RGB(FLOATS)}, .data = FIXTURE_WINDOW(-3, -40, 1, 53)},
        {.channel = {HALF_CH("A"), RGB(HALVES), FLOAT_CH("Z"), UINT_CH("id")},
         .data = FIXTURE_WINDOW(-17, 5, 83, 200)},
        {.channel = {RGB(EXR_PIXEL_UINT)},
         .data = FIXTURE_WINDOW(3, 3, 19, 37)},
        {.channel = {RGB(HALVES), FLOAT_CH("Z")},
         .data = FIXTURE_WINDOW(-5, -9, 50, 41), .tile = 16},
        {.channel = {RGB(FLOATS)},
         .data = FIXTURE_WINDOW(0, 0, 64, 48), .tile = 32, .mipmap = true},
    };
    in_folder("layout.exr");
    for (size_t i = 0; i < COUNT(row); i++) {
        for (int c = 0; c < LOSSLESS; c++) {
            struct fixture f = {.part = {row[i]}};
            struct gp_frame frame;
            f.part[0].compression = lossless[c];
            fixture_write_file(path, &f);
            gp_set_threads(c); // 0: as many as there are
            assert_ok(read_file(path, &frame));
            assert_int_equal(frame.data.x0, row[i].data.min.x);
            assert_int_equal(frame.data.y1, row[i].data.max.y + 1);
            assert_int_equal(frame.model, GP_COLOUR_RGB);
            assert_int_equal(frame.colour_type,
                f.part[0].channel[1].type == HALVES ? GP_HALF : GP_FLOAT);
            assert_frame_is(&frame, &f.part[0]);
            gp_frame_free(&frame);
        }
    }
    gp_set_threads(0);
}

static void subsampled_channels_stay_as_they_are(void **state)
{
    static const exr_compression_t method[] = {
        EXR_COMPRESSION_NONE, EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
        EXR_COMPRESSION_PIZ,
    };
    enum { W = 24, H = 36 };
    for (size_t i = 0; i < COUNT(method); i++) {
        struct fixture f = {.part = {{
            .channel = {RGB(HALVES), {"wide", HALVES, 4, 1},
                        {"zoom", FLOATS, 2, 2}},
            .data = FIXTURE_WINDOW(-8, 4, W, H), .compression = method[i],
        }}};
        struct gp_frame frame;
        fixture_write_file(in_folder("sampled.exr"), &f);
        assert_ok(read_file(path, &frame));
        assert_frame_is(&frame, &f.part[0]);
        float full[W * H];
        gp_channel_floats(&frame, 4, full);
        for (int y = 0; y < H; y++) {
            for (int x = 0; x < W; x++)
                assert_true(full[y * W + x] == fixture_value("zoom",
                    -8 + x / 2 * 2, 4 + y / 2 * 2));
        }
        gp_frame_free(&frame);
    }
}

static void header_values(void **state)
{
    static const struct gp_rect display = {-100, 50, -93, 59};
    struct gp_frame frame;
    float want[3];
    struct fixture f = {
        .part = {{.channel = {RGB(HALVES)},
                  .data = FIXTURE_WINDOW(-2, -3, 4, 5)}},
        .display = FIXTURE_WINDOW(-100, 50, 7, 9), .aspect = 1.5f,
        .chromaticities = true,
    };
    fixture_write_file(in_folder("header.exr"), &f);
    assert_ok(read_file(path, &frame));
    assert_string_equal(frame.path, path);
    assert_memory_equal(&frame.display, &display, sizeof display);
    assert_true(frame.pixel_aspect == 1.5f);
    assert_memory_equal(frame.chromaticities, &fixture_ap0,
                        sizeof frame.chromaticities);
    gp_luminance_weights(frame.chromaticities, want);
    assert_memory_equal(frame.luminance, want, sizeof want);
    gp_frame_free(&frame);

    f.chromaticities = false;
    fixture_write_file(path, &f);
    assert_ok(read_file(path, &frame));
    assert_memory_equal(frame.luminance, gp_rec709_luminance, sizeof want);
    gp_frame_free(&frame);
}

static void which_channels_are_colour(void **state)
{
    static const struct {
        struct fixture_channel channel[FIXTURE_CHANNELS];
        enum gp_colour_model model;
        const char *plane[3]; // NULL: zero
    } row[] = {
        {{HALF_CH("G")}, GP_COLOUR_RGB, {NULL, "G", NULL}},
        {{HALF_CH("B"), HALF_CH("R")}, GP_COLOUR_RGB, {"R", NULL, "B"}},
        {{HALF_CH("Blue"), HALF_CH("GREEN"), HALF_CH("red")}, GP_COLOUR_RGB,
         {"red", "GREEN", "Blue"}},
        {{HALF_CH("A"), HALF_CH("Y")}, GP_COLOUR_GREY, {"Y", "Y", "Y"}},
        {{HALF_CH("u")}, GP_COLOUR_GREY, {"u", "u", "u"}},
        {{HALF_CH("L.AO.B"), HALF_CH("L.AO.G"), HALF_CH("L.AO.R"),
          HALF_CH("L.Combined.B"), HALF_CH("L.Combined.G"),
          HALF_CH("L.Combined.R")}, GP_COLOUR_RGB,
         {"L.Combined.R", "L.Combined.G", "L.Combined.B"}},
    };
    in_folder("colour.exr");
    for (size_t i = 0; i < COUNT(row); i++) {
        struct fixture f = {.part = {{.data = FIXTURE_WINDOW(0, 0, 3, 2)}}};
        struct gp_frame frame;
        memcpy(f.part[0].channel, row[i].channel, sizeof row[i].channel);
        fixture_write_file(path, &f);
        assert_ok(read_file(path, &frame));
        assert_int_equal(frame.model, row[i].model);
        for (int c = 0; c < 3; c++) {
            for (int k = 0; k < 6; k++) {
                float want = row[i].plane[c]
                                 ? fixture_value(row[i].plane[c], k % 3, k / 3)
                                 : 0.0f;
                assert_true(frame.rgb.c[c][k] == want);
            }
        }
        gp_frame_free(&frame);
    }
}

/* Depth first, colour second: the part with only Z is not the picture. */
static void colour_part_of_many(void **state)
{
    struct gp_frame frame;
    struct fixture f = {
        .parts = 3, .part = {
            {.name = "depth", .channel = {FLOAT_CH("Z")}, .data = W(9)},
            {.name = "picture", .channel = {HALF_CH("A"), RGB(HALVES)},
             .data = FIXTURE_WINDOW(2, 2, 30, 40),
             .compression = EXR_COMPRESSION_ZIP},
            {.name = "more", .channel = {RGB(HALVES)}, .data = W(9)},
        },
    };
    fixture_write_file(in_folder("parts.exr"), &f);
    assert_ok(read_file(path, &frame));
    assert_int_equal(frame.part, 1);
    assert_int_equal(frame.parts, 3);
    assert_frame_is(&frame, &f.part[1]);
    assert_int_equal(gp_input_of(&frame)->part, 1);
    gp_frame_free(&frame);
}

SUITE_OF(exr_read, make_folder, remove_folder, every_layout,
         subsampled_channels_stay_as_they_are, header_values,
         which_channels_are_colour, colour_part_of_many)
