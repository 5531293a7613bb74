// SPDX-License-Identifier: Apache-2.0
/* io/grow: windows that grow, and what is in their new pixels. */
#include "io/grow.h"

#include "exr_fixture.h"
#include "core/memory.h"
#include "io/channels.h"
#include "core/half.h"
#include "io/plane.h"
#include "reading.h"

#include <limits.h>

#define Z GLAREPP_Z
#define INV GLAREPP_INVERSE
#define SHARE GLAREPP_NORMALIZED

static void window_is_the_union_and_as_much_more(void **state)
{
    static const struct {
        struct gp_rect data, display, want;
        struct gp_grow_params by;
    } row[] = {
        {{40, 30, 56, 46}, {0, 0, 100, 80}, {0, 0, 100, 80}, {0}},
        {{-25, -25, 281, 281}, {0, 0, 256, 256}, {-25, -25, 281, 281}, {0}},
        {{0, 0, 400, 300}, {399, 299, 500, 400}, {0, 0, 500, 400}, {0}},
        {{-8, -9, -4, -5}, {-20, -7, -6, 3}, {-20, -9, -4, 3}, {0}},
        {{2, 3, 4, 5}, {0}, {2, 3, 4, 5}, {0}}, // no display window
        {{2, 3, 4, 5}, {0, 0, 8, 9}, {-1, -2, 11, 13},
         {.left = 1, .top = 2, .right = 3, .bottom = 4}},
        {{INT_MAX / 4 - 1, 0, INT_MAX / 4, 1}, {0, 0, 1, 1},
         {-9, -9, INT_MAX / 4, 10},
         {.left = 9, .top = 9, .right = 9, .bottom = 9}},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct gp_frame f = {.data = row[i].data,
                                   .display = row[i].display};
        const struct gp_rect got = gp_grow_window(&row[i].by, &f);
        assert_memory_equal(&got, &row[i].want, sizeof got);
    }
}

/* Chroma of 2x2 counts only when it is carried. */
static void grids_of_carried_channels_fit(void **state)
{
    struct gp_channel c[] = {
        {.xs = 3, .ys = 1, .colour = -1}, {.xs = 2, .ys = 4, .colour = -1},
        {.xs = 7, .ys = 7, .colour = 0},
    };
    const struct gp_frame f = {.data = {-12, 8, 12, 24}, .channel = c,
                               .channels = COUNT(c)};
    const struct gp_rect got = gp_grow_align(&f, (struct gp_rect) {
        -13, 7, 13, 25,
    });
    const struct gp_rect want = {-18, 4, 18, 28};
    assert_memory_equal(&got, &want, sizeof got);
    const struct gp_rect same = gp_grow_align(&f, f.data);
    assert_memory_equal(&same, &f.data, sizeof same);
}

static void every_sample_keeps_its_place(void **state)
{
    const struct fixture file = {
        .part[0] = {.channel = {HALF_CH("A"), RGB(FLOATS),
                                {"half", HALVES, 2, 2}, UINT_CH("id")},
                    .data = FIXTURE_WINDOW(-6, 4, 8, 6)},
        .display = FIXTURE_WINDOW(-9, -3, 25, 17),
    };
    static const char *const rgb[] = {"R", "G", "B"};
    const struct gp_grow_params p = {0};
    struct gp_frame f;
    fixture_write_file(in_folder("grows.exr"), &file);
    assert_ok(read_file(path, &f));
    const struct gp_rect was = f.data;
    const struct gp_rect window = gp_grow_align(&f, gp_grow_window(&p, &f));
    const struct gp_rect want = {-10, -4, 16, 14};
    assert_memory_equal(&window, &want, sizeof want);
    assert_ok(gp_grow(&kept_log, &p, window, &f));
    assert_memory_equal(&f.data, &want, sizeof want);
    assert_memory_equal(&f.read, &was, sizeof was);
    float *const v = calloc(gp_frame_pixels(&f), sizeof *v);
    for (int i = 0; i < f.channels + 3; i++) {
        const int k = i - f.channels;
        const struct gp_channel *const c = &f.channel[k < 0 ? i : 0];
        const char *const name = k < 0 ? c->name : rgb[k];
        const int xs = k < 0 ? c->xs : 1, ys = k < 0 ? c->ys : 1;
        const float *const got = k < 0 ? v : f.rgb.c[k];
        if (k < 0)
            gp_channel_floats(&f, i, v);
        for (int y = want.y0; y < want.y1; y++) {
            for (int x = want.x0; x < want.x1; x++) {
                const int sx = x & -xs, sy = y & -ys; // floored
                const bool in = sx >= was.x0 && sx < was.x1 &&
                                sy >= was.y0 && sy < was.y1;
                const float wanted = !in ? 0.0f : strcmp(name, "id") == 0
                    ? (float) fixture_uint(name, sx, sy)
                    : fixture_value(name, sx, sy);
                if (got[(y - want.y0) * 26 + x - want.x0] != wanted)
                    fail_msg("%s at %d,%d", name, x, y);
            }
        }
    }
    free(v);
    // planes beside it have the pixels of the file
    struct gp_plane alpha = {0};
    const struct gp_read_params limits = GP_READ_DEFAULTS;
    assert_ok(gp_read_plane(&kept_log, &limits, &f, "A", false, &alpha));
    assert_memory_equal(&alpha.window, &was, sizeof was);
    for (int i = 0; i < 48; i++)
        assert_float_equal(alpha.v[i],
                           fixture_value("A", -6 + i % 8, 4 + i / 8), 0.0f);
    gp_plane_free(&alpha);
    gp_frame_free(&f);
}

/* A frame of 4x1 pixels with one channel, which grows to 5x1; returns the
 * sample of the fifth. */
static float empty_of(const char *name, enum gp_pixel_type type,
                      const float v[4], const struct gp_grow_params *p)
{
    float out[5];
    struct gp_frame f = {.data = {0, 0, 4, 1}, .display = {0, 0, 5, 1},
                         .path = gp_strdup("frame.exr"), .channels = 1};
    assert_ok(gp_planes_make(&kept_log, "rgb", 4, &f.rgb));
    assert_ok(gp_alloc_zero(&kept_log, "channels", 1, sizeof *f.channel,
                            &f.channel));
    *f.channel = (struct gp_channel) {
        .name = gp_strdup(name), .type = type, .xs = 1, .ys = 1, .w = 4,
        .h = 1, .colour = -1,
    };
    assert_ok(gp_alloc(&kept_log, "depth", 4, 4, &f.channel->data));
    for (int i = 0; i < 4; i++) {
        ((float *) f.channel->data)[i] = v[i];
        if (type == GP_UINT)
            ((uint32_t *) f.channel->data)[i] = (uint32_t) v[i];
    }
    if (type == GP_HALF)
        gp_float_to_half(v, f.channel->data, 4);
    assert_ok(gp_grow(&kept_log, p, f.display, &f));
    gp_channel_floats(&f, 0, out);
    gp_frame_free(&f);
    return out[4];
}

static void depth_is_padded_with_its_own_empty_value(void **state)
{
    static const struct {
        const char *name;
        enum gp_pixel_type type;
        enum glarepp_depth kind;
        float v[4], want;
    } row[] = {
        {"Z", GP_FLOAT, Z, {3, 1e10f, 5, 1e10f}, 1e10f},
        {"a.Depth.Z", GP_HALF, Z, {3, 65504, 5, 7}, 65504},
        {"Z", GP_FLOAT, Z, {3, INFINITY, 5, 7}, INFINITY},
        {"Z", GP_FLOAT, Z, {3, NAN, NAN, 1e30f}, NAN},
        {"depth.Z", GP_FLOAT, Z, {0, 4, 5, 7}, 0},
        {"Z", GP_FLOAT, Z, {0, 1e10f, 1e10f, 7}, 1e10f}, // the more frequent
        {"Z", GP_FLOAT, Z, {1e10f, 0, 5, 7}, 0}, // of equals the first kind
        {"Z", GP_FLOAT, Z, {65504, 5, 7, 1e10f}, 1e10f},
        {"Z", GP_FLOAT, Z, {INFINITY, 5, 65504, 7}, 65504},
        {"Z", GP_FLOAT, Z, {NAN, 5, INFINITY, 7}, INFINITY},
        {"a.ZBack", GP_FLOAT, Z, {3, 1e10f, 5, 1e10f}, 1e10f},
        {"Z", GP_FLOAT, Z, {2, 9, 5, 7}, 9},             // unknown: the largest
        {"Z", GP_UINT, Z, {2, 9, 5, 7}, 9},
        {"Z", GP_FLOAT, Z, {-2, -9, -5, -7}, -9}, // along -z: the farthest
        {"Z", GP_FLOAT, Z, {-2, -1e10f, -5, -7}, -1e10f},
        {"Z", GP_FLOAT, INV, {2, 9, 5, 7}, 0},
        {"Z", GP_FLOAT, SHARE, {0.5f, 1, 0, 0}, 1},
        {"Z", GP_FLOAT, SHARE, {0.5f, 0, 0, 0.25f}, 0}, // reversed
        {"Z", GP_FLOAT, SHARE, {0.5f, 0.25f, 0.5f, 0.25f}, 1},
        {"far", GP_FLOAT, Z, {3, 4, 5, 7}, 7}, // by --depth
        {"N.Z", GP_FLOAT, Z, {2, 9, 5, 7}, 0}, // a vector
        {"A", GP_HALF, Z, {1, 1, 1, 1}, 0},
        {"CryptoObject00.R", GP_FLOAT, Z, {1e10f, 1e10f, 3, 4}, 0},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct gp_grow_params p = {.depth = "far",
                                         .type = row[i].kind};
        const float got = empty_of(row[i].name, row[i].type, row[i].v, &p);
        if (got != row[i].want && !(isnan(got) && isnan(row[i].want)))
            fail_msg("row %zu: %g, wanted %g", i, (double) got,
                     (double) row[i].want);
    }
}

static void too_large_a_window_names_the_way_out(void **state)
{
    const struct gp_frame f = {.path = (char *) "far.exr",
                               .data = {0, 0, 46, 46}};
    static const struct {
        struct gp_rect window;
        gp_status want;
        const char *says; // NULL: nothing
    } row[] = {
        {{0, 0, 4096, 4096}, GP_OK, NULL},
        {{0, 0, 4097, 4096}, GP_OK, "which takes less memory"},
        {{0, 0, 5000, 4000}, GP_OK, "--grow none"},
        {{0, 0, 8192, 4320}, GP_OK, "--grow none"},
        {{0, 0, 8192, 4321}, GP_ERR_DATA, "over 16384 times as many"},
        {{0, 0, 8192, 5001}, GP_ERR_DATA, "--max-pixels"},
        {{-(INT_MAX / 4), 0, 10, 10}, GP_ERR_DATA, "--grow none"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        kept_clear();
        assert_int_equal(
            gp_grow_check(&kept_log, &f, row[i].window, 8192 * 5000),
            row[i].want);
        assert_int_equal(kept_lines, row[i].says != NULL);
        if (row[i].says)
            assert_non_null(strstr(kept_errors ? kept_line : kept_warning,
                                   row[i].says));
    }
}

SUITE_OF(grow, make_folder, remove_folder, window_is_the_union_and_as_much_more,
         grids_of_carried_channels_fit, every_sample_keeps_its_place,
         depth_is_padded_with_its_own_empty_value,
         too_large_a_window_names_the_way_out)
