// SPDX-License-Identifier: Apache-2.0
/* io/channels: depth, colour and ids by names; samples at full resolution. */
#include "unit.h"
#include "io/frame.h"
#include "io/channels.h"
#include "io/exr/exr_priv.h"
#include "io/write.h"
#include "kept_log.h"

enum { NAMES = 12 };

/* A frame of names only; the channels are the caller's. */
static struct gp_frame frame_of(const char *const name[NAMES],
                                struct gp_channel channel[NAMES])
{
    static char path[] = "frame.exr";
    struct gp_frame f = {.path = path, .channel = channel};
    for (; f.channels < NAMES && name[f.channels]; f.channels++)
        channel[f.channels] = (struct gp_channel) {
            .name = (char *) (uintptr_t) name[f.channels], .colour = -1,
        };
    return f;
}

static void depth_by_search(void **state)
{
    static const struct {
        const char *name[NAMES];
        const char *want;    // NULL: none
        const char *also;    // not NULL: an error that names both
        const char *colour;
    } row[] = {
        {{"A", "B", "G", "R"}, NULL, NULL, NULL},
        {{"B", "G", "R", "Z"}, "Z", NULL, NULL},
        {{"Z", "depth.Z", "left.Z"}, "Z", NULL, NULL},
        {{"Depth.Z", "depth.Z", "x.Z"}, "depth.Z", NULL, NULL},
        {{"Depth.Z", "ViewLayer.Depth.Z"}, "Depth.Z", NULL, NULL},
        {{"ViewLayer.Combined.R", "ViewLayer.Depth.Z", "ViewLayer.N.Z"},
         "ViewLayer.Depth.Z", NULL, NULL},
        {{"A.Depth.Z", "B.Depth.Z"}, "A.Depth.Z", "B.Depth.Z", NULL},
        // depth beside the colour, in its layer or the ones around it
        {{"A.Depth.Z", "B.Depth.Z"}, "B.Depth.Z", NULL, "B.Combined.R"},
        {{"A.Depth.Z", "B.Z"}, "B.Z", NULL, "B.Combined.R"},
        {{"A.Z", "B.Z", "Z"}, "B.Z", NULL, "B.R"},
        {{"s.A.Depth.Z", "s.B.Z"}, "s.A.Depth.Z", NULL, "s.C.Combined.R"},
        {{"s.A.Z", "s.B.Z"}, "s.A.Z", "s.B.Z", "s.C.Combined.R"},
        {{"B.Normal.Z", "B.Mist.Z", "A.Z"}, "A.Z", NULL, "B.Combined.R"},
        {{"A.Depth.Z", "B.Depth.Z"}, "A.Depth.Z", "B.Depth.Z", "R"},
        {{"A.Depth.Z", "B.Depth.Z"}, "A.Depth.Z", "B.Depth.Z", "C.Combined.R"},
        // Blender's fog
        {{"ViewLayer.Combined.R", "ViewLayer.Mist.Z"}, NULL, NULL, NULL},
        {{"ViewLayer.Mist.Z", "far.Z"}, "far.Z", NULL, NULL},
        {{"mist.Z"}, NULL, NULL, NULL},
        {{"Mistral.Z"}, "Mistral.Z", NULL, NULL},
        {{"left.Z", "right.Z"}, "left.Z", "right.Z", NULL},
        {{"a.Z", "b.Z", "c.Z"}, "a.Z", "b.Z", NULL}, // the first two are named
        {{"a.Z", "b.Z", "Z"}, "Z", NULL, NULL},
        {{"character.Z"}, "character.Z", NULL, NULL},
        // a vector by its axes, whatever its name
        {{"thing.X", "thing.Y", "thing.Z"}, NULL, NULL, NULL},
        {{"thing.X", "thing.Z"}, "thing.Z", NULL, NULL},
        {{"X", "Y", "Z"}, NULL, NULL, NULL}, {{"Y", "Z"}, "Z", NULL, NULL},
        {{"X", "Z"}, "Z", NULL, NULL},
        // a vector by its name, whatever its axes
        {{"normals.Z"}, NULL, NULL, NULL}, {{"Normal.Z"}, NULL, NULL, NULL},
        {{"N.Z"}, NULL, NULL, NULL}, {{"P.Z"}, NULL, NULL, NULL},
        {{"V.position.Z"}, NULL, NULL, NULL},
        {{"velocity.Z", "far.Z"}, "far.Z", NULL, NULL},
        {{"Nothing.Z"}, "Nothing.Z", NULL, NULL}, // begins with N only
        // names that only look like it
        {{".Z"}, NULL, NULL, NULL},
        {{"ZBack", "depth.ZBack", "depth.z", "depthZ"}, NULL, NULL, NULL},
        {{NULL}, NULL, NULL, NULL},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_channel channel[NAMES];
        struct gp_frame f = frame_of(row[i].name, channel);
        int found = -2;
        gp_status st = gp_find_depth(&kept_log, f.path, f.channel, f.channels,
                                     row[i].colour, &found);
        if (row[i].also) {
            assert_int_equal(st, GP_ERR_DATA);
            assert_kept(row[i].want);
            assert_kept(row[i].also);
            continue;
        }
        assert_ok(st);
        if (!row[i].want)
            assert_int_equal(found, -1);
        else
            assert_string_equal(f.channel[found].name, row[i].want);
    }
}

static void samples_of_every_type(void **state)
{
    static uint16_t half[6] = {0x3c00, 0xc000, 0x0001, 0x7c00, 0x7e00, 0x7bff};
    static float real[6] = {1.0f, -2.0f, 1e-40f, INFINITY, NAN, 3e38f};
    static uint32_t whole[6] = {0, 1, 16777217u, 4294967295u, 7, 8};
    static float plane[6] = {6, 5, 4, 3, 2, 1};
#define CHANNEL(kind, is, samples)                                            \
    {.type = kind, .xs = 1, .ys = 1, .w = 3, .h = 2, .colour = is,            \
     .data = samples}
    static struct gp_channel channel[4] = {
        CHANNEL(GP_HALF, -1, half), CHANNEL(GP_FLOAT, -1, real),
        CHANNEL(GP_UINT, -1, whole), CHANNEL(GP_HALF, 1, NULL),
    };
    struct gp_frame f = {.data = {-1, 4, 2, 6}, .channel = channel,
                         .channels = 4, .rgb = {{NULL, plane, NULL}}};
    static const float want_half[6] = {1, -2, 5.9604645e-8f, INFINITY, NAN,
                                       65504};
    static const float want_whole[6] = {0, 1, 16777216.0f, 4294967296.0f, 7,
                                        8};
    const float *want[4] = {want_half, real, want_whole, plane};
    for (int c = 0; c < 4; c++) {
        float out[6];
        gp_channel_floats(&f, c, out);
        for (int i = 0; i < 6; i++)
            assert_true(out[i] == want[c][i] ||
                        (isnan(out[i]) && isnan(want[c][i])));
    }
}

/* A subsampled channel's samples are repeated; the last one stands for what
 * is right of it and below it. Without samples nothing is written. */
static void subsampled_channels(void **state)
{
    static const struct {
        int xs, ys, w, h; // of the samples
        struct gp_rect window;
    } row[] = {
        {2, 3, 3, 2, {-4, -3, 2, 3}}, {2, 2, 2, 1, {0, 0, 5, 3}},
        {4, 4, 0, 1, {1, 1, 3, 3}},   {4, 4, 1, 0, {1, 1, 3, 3}},
        {4, 4, 0, 0, {1, 1, 3, 3}}, // the window is between two samples
    };
    static float some[6] = {1, 2, 3, 4, 5, 6};
    for (size_t i = 0; i < COUNT(row); i++) {
        const int w = row[i].w, h = row[i].h, width = gp_rect_w(row[i].window);
        struct gp_channel channel = {
            .type = GP_FLOAT, .xs = row[i].xs, .ys = row[i].ys, .w = w, .h = h,
            .colour = -1, .data = some,
        };
        struct gp_frame f = {
            .data = row[i].window, .channel = &channel, .channels = 1};
        float out[36] = {0};
        gp_channel_floats(&f, 0, out);
        for (int k = 0; k < width * gp_rect_h(row[i].window); k++) {
            const int x = k % width / row[i].xs, y = k / width / row[i].ys;
            const int at = (y < h ? y : h - 1) * w + (x < w ? x : w - 1);
            assert_true(out[k] == (w && h ? some[at] : 0.0f));
        }
    }
}

enum { COLOURS = 8 };

static void colour_of_names(void **state)
{
    static const struct {
        const char *name[COLOURS];
        bool lone;
        enum gp_colour_model model;
        const char *want[3]; // all NULL: none
    } row[] = {
        {{"B", "G", "R"}, false, GP_COLOUR_RGB, {"R", "G", "B"}},
        // channels of a layer stand together, as in an EXR
        {{"a.B", "a.G", "a.R", "b.B", "b.G", "b.R"}, false, GP_COLOUR_RGB,
         {"a.R", "a.G", "a.B"}},
        {{"z.GREEN", "", "z.Red", "z.blue"}, false, GP_COLOUR_RGB,
         {"z.Red", "z.GREEN", "z.blue"}},
        // the first of two of one name
        {{"l.R", "l.R", "l.G", "l.B", "l.B"}, false, GP_COLOUR_RGB,
         {"l.R", "l.G", "l.B"}},
        // a layer that lacks one of three is passed over
        {{"a.B", "a.G", "b.B", "b.G", "b.R"}, false, GP_COLOUR_RGB,
         {"b.R", "b.G", "b.B"}},
        {{"a.B", "a.R", "b.B", "b.G", "b.R"}, false, GP_COLOUR_RGB,
         {"b.R", "b.G", "b.B"}},
        {{"a.G", "a.R", "b.B", "b.G", "b.R"}, false, GP_COLOUR_RGB,
         {"b.R", "b.G", "b.B"}},
        {{"a.G", "a.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"a.Blue", "a.Red"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"a.Green", "a.Red"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        // ids are no light
        {{"CryptoObject00.B", "CryptoObject00.G", "CryptoObject00.R", "l.B",
          "l.G", "l.R"}, false, GP_COLOUR_RGB, {"l.R", "l.G", "l.B"}},
        {{"CryptoObject00.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"CryptoObject00.R", "density"}, true, GP_COLOUR_GREY,
         {"density", NULL, NULL}},
        // one channel, beside alpha of any layer
        {{"density"}, true, GP_COLOUR_GREY, {"density", NULL, NULL}},
        {{"density"}, false, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A", "smoke.density", "smoke.Alpha"}, true, GP_COLOUR_GREY,
         {"smoke.density", NULL, NULL}},
        {{"smoke.A", "", "u"}, true, GP_COLOUR_GREY, {"u", NULL, NULL}},
        // coverage is no light
        {{"A"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"alpha"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"coverage"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"l.mask"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"matte.A"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"mask.B", "mask.G", "mask.R"}, true, GP_COLOUR_RGB,
         {NULL, NULL, NULL}},
        // vectors are no light, nor is one part of them
        {{"N.X"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"V.motion.u"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"P.X"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"P.Z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"N.B", "N.G", "N.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"N.B", "N.G", "N.R", "n2.B", "n2.G", "n2.R"}, false, GP_COLOUR_RGB,
         {"n2.R", "n2.G", "n2.B"}},
        {{"uv.blue", "uv.green", "uv.red"}, true, GP_COLOUR_RGB,
         {NULL, NULL, NULL}},
        // numbers of objects
        {{"id.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"objectID"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"V.IndexOB.X"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"grid"}, true, GP_COLOUR_GREY, {"grid", NULL, NULL}},
        // depth is no light
        {{"Z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A", "Z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A", "l.Depth.Z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Z", "ZBack"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A", "Z", "l.ZBack"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Z", "V.Depth.V"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Z", "id"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Depth"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A", "z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Z", "smoke"}, true, GP_COLOUR_GREY, {"smoke", NULL, NULL}},
        {{"l.Mist.Z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"depth.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"Z.Y"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"depth.B", "depth.G", "depth.R"}, false, GP_COLOUR_RGB,
         {NULL, NULL, NULL}},
        {{"AOV_depth"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"camera-z"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"depthZ"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"linearDepth"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"A.Z_depth"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"ZBuffer"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"zbuf"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"DepthNormalized.R"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"depthFiltered.B", "depthFiltered.G", "depthFiltered.R"}, false,
         GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{"depths", "z"}, true, GP_COLOUR_GREY, {"depths", NULL, NULL}},
        {{"jazz_blitz"}, true, GP_COLOUR_GREY, {"jazz_blitz", NULL, NULL}},
        {{"u", "v"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{NULL}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const char *const *const name = row[i].name, *const *want = row[i].want;
        struct gp_colour_choice got;
        int n = 0;
        while (n < COLOURS && name[n])
            n++;
        const bool found = gp_find_colour(name, n, row[i].lone, &got);
        if (found != (want[0] != NULL))
            fail_msg("row %zu: %s", i, found ? "found" : "not found");
        if (found)
            assert_int_equal(got.model, row[i].model);
        for (int c = 0; c < 3 && found; c++) {
            assert_int_equal(got.index[c] >= 0, want[c] != NULL);
            if (want[c])
                assert_string_equal(name[got.index[c]], want[c]);
        }
    }
}

static void alpha_of_the_colour(void **state)
{
    static const struct {
        const char *name[4];
        int colour[4], alpha;
    } row[] = {
        {{"A", "B", "G", "R"}, {-1, 2, 1, 0}, 0},
        {{"l.B", "l.G", "l.R", "l.ALPHA"}, {2, 1, 0, -1}, 3},
        {{"A", "l.B", "l.G", "l.R"}, {-1, 2, 1, 0}, -1}, // another layer's
        {{"B", "G", "R", "l.A"}, {2, 1, 0, -1}, -1},
        {{"A"}, {0, -1, -1, -1}, -1},   // it is the colour itself
        {{"A", "Z"}, {-1, -1}, -1},     // no colour, so nothing of its
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_channel channel[4] = {0};
        struct gp_frame f = {.channel = channel};
        for (; f.channels < 4 && row[i].name[f.channels]; f.channels++)
            channel[f.channels] = (struct gp_channel) {
                .name = (char *) (uintptr_t) row[i].name[f.channels],
                .colour = row[i].colour[f.channels],
            };
        assert_int_equal(gp_find_alpha(&f), row[i].alpha);
    }
}

static void layers_of_ids(void **state)
{
    static struct gp_exr_part part = {.layer = "uObject"};
    static const struct gp_input in = {
        .each = &part,
        .crypto = {.layer = {"uObject", "l.mat"}, .n = 2},
    };
    static const struct {
        const char *layer;
        enum gp_crypto_kind kind;
    } row[] = {
        {"uObject00", GP_CRYPTO_IDS},   {"uObject99", GP_CRYPTO_IDS},
        {"uObject", GP_CRYPTO_PREVIEW}, {"uObject0x", GP_CRYPTO_NONE},
        {"uObjectx0", GP_CRYPTO_NONE},  {"uObject000", GP_CRYPTO_NONE},
        {"uObjec00", GP_CRYPTO_NONE},   {"l.mat07", GP_CRYPTO_IDS},
        {"mat07", GP_CRYPTO_NONE},      {"CryptoAsset02", GP_CRYPTO_IDS},
        {"l.cryptoX12", GP_CRYPTO_IDS}, {"crypto12", GP_CRYPTO_IDS},
        {"crypto1", GP_CRYPTO_NONE},    {"crypt012", GP_CRYPTO_NONE},
        {"crypto.a12", GP_CRYPTO_NONE}, {"12", GP_CRYPTO_NONE},
        {"", GP_CRYPTO_NONE},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        char channel[40];
        const char *const layer = row[i].layer;
        const size_t len = strlen(layer);
        if (gp_crypto_layer(&in.crypto, layer, len) != row[i].kind)
            fail_msg("%s: not %d", layer, row[i].kind);
        snprintf(channel, sizeof channel, "%s.R", layer);
        assert_int_equal(gp_exr_crypto_channel(&in, 0, channel), row[i].kind);
    }
    // without a layer of its own, and in a file that is not EXR
    assert_int_equal(gp_exr_crypto_channel(&in, 0, "R"), GP_CRYPTO_NONE);
    part.length = strlen(part.layer);
    assert_int_equal(gp_exr_crypto_channel(&in, 0, "R"), GP_CRYPTO_PREVIEW);
    assert_int_equal(gp_exr_crypto_channel(NULL, 0, "R"), GP_CRYPTO_NONE);
    assert_int_equal(gp_exr_crypto_channel(NULL, 0, "l.mat07.R"),
                     GP_CRYPTO_NONE);
}

/* Triples the light, and needs the frame that it is of. */
static gp_status triple(const struct gp_log *log, void *user,
    const struct gp_frame *f, size_t n, const struct gp_planes *in,
    struct gp_planes *out)
{
    assert_ptr_equal(user, f);
    if (!out->c[0])
        assert_ok(gp_planes_make(log, "out", n, out));
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            out->c[c][i] = 3.0f * in->c[c][i];
    }
    return GP_OK;
}

/* Only layers of light are converted, each in its own type. */
static void other_layers_are_converted(void **state)
{
    static const struct {
        const char *name[NAMES];
        const char *changed; // y for each channel that is
        enum gp_pixel_type type;
        int xs;
        const char *left;    // channels that the line names; NULL: no line
    } row[] = {
        {{"R", "a.B", "a.G", "a.R", "a.A"}, "-yyy-", GP_FLOAT, 1, NULL},
        {{"R", "x.a.B", "x.a.G", "x.a.R"}, "-yyy", GP_HALF, 1, NULL},
        {{"R", "s.Blue", "s.Green", "s.RED"}, "-yyy", GP_FLOAT, 1, NULL},
        {{"d.R", "B", "G", "R"}, "-yyy", GP_FLOAT, 1, NULL},
        {{"R", "a.B", "a.R", "b.G"}, "----", GP_FLOAT, 1, NULL},
        {{"R", "N.B", "N.G", "N.R"}, "----", GP_FLOAT, 1, NULL},
        {{"R", "v.Position.B", "v.Position.G", "v.Position.R"}, "----",
         GP_FLOAT, 1, NULL},
        {{"R", "zDepth.B", "zDepth.G", "zDepth.R"}, "----", GP_FLOAT, 1, NULL},
        {{"R", "crypto01.B", "crypto01.G", "crypto01.R"}, "----", GP_FLOAT, 1,
         NULL},
        {{"R", "a.B", "a.G", "a.R"}, "----", GP_UINT, 1, NULL},
        {{"R", "a.B", "a.G", "a.R"}, "----", GP_HALF, 2, "(a.R)"},
        {{"R", "a.BY", "a.RY", "a.Y"}, "----", GP_HALF, 1, "(a.RY)"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const uint32_t one = row[i].type == GP_HALF ? 0x3c003c00u : 0x3f800000u;
        const uint32_t three = row[i].type == GP_HALF ? 0x42004200u
                                                      : 0x40400000u;
        struct gp_channel channel[NAMES];
        uint32_t sample[NAMES];
        struct gp_frame f = frame_of(row[i].name, channel);
        struct gp_write_stats stats = {0};
        // two pixels of half, one of others
        f.data = (struct gp_rect) {0, 0, row[i].type == GP_HALF ? 2 : 1, 1};
        channel[0].colour = 0;
        for (int k = 1; k < f.channels; k++) {
            struct gp_channel *const c = &channel[k];
            sample[k] = one;
            c->data = &sample[k];
            c->type = row[i].type;
            c->xs = row[i].xs;
            c->w = gp_frame_w(&f) / row[i].xs;
            c->ys = c->h = 1;
        }
        kept_clear();
        assert_ok(gp_convert_layers(&kept_log, triple, &f, &f, &stats));
        for (int k = 1; k < f.channels; k++) {
            if (sample[k] != (row[i].changed[k] == 'y' ? three : one))
                fail_msg("row %zu: %s is %x", i, channel[k].name, sample[k]);
        }
        assert_int_equal(kept_lines, row[i].left != NULL);
        if (row[i].left)
            assert_non_null(strstr(kept_warning, row[i].left));
    }
}

SUITE_OF(channels, NULL, NULL, depth_by_search, samples_of_every_type,
         subsampled_channels, colour_of_names, alpha_of_the_colour,
         layers_of_ids, other_layers_are_converted)
