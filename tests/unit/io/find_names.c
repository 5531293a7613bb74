/* io/colour, io/colour_name, io/crypto: what channels are, by their names. */
#include "unit.h"
#include "io/channels.h"
#include "io/exr/exr_priv.h"

enum { NAMES = 8 };

static int count(const char *const name[NAMES])
{
    int n = 0;
    while (n < NAMES && name[n])
        n++;
    return n;
}

static void assert_choice(const char *const *name, int n,
                          const struct gp_colour_choice *got,
                          enum gp_colour_model model, const char *const *want)
{
    assert_int_equal(got->model, model);
    for (int c = 0; c < 3; c++) {
        if (!want[c]) {
            assert_int_equal(got->index[c], -1);
            continue;
        }
        assert_in_range(got->index[c], 0, n - 1);
        assert_string_equal(name[got->index[c]], want[c]);
    }
}

static void colour_of_names(void **state)
{
    (void) state;
    static const struct {
        const char *name[NAMES];
        bool lone;
        enum gp_colour_model model;
        const char *want[3]; // all NULL: none
    } row[] = {
        {{"B", "G", "R"}, false, GP_COLOUR_RGB, {"R", "G", "B"}},
        // layers that ascend, as in an EXR, and layers that do not
        {{"a.B", "a.G", "a.R", "b.B", "b.G", "b.R"}, false, GP_COLOUR_RGB,
         {"a.R", "a.G", "a.B"}},
        {{"b.R", "a.R", "b.G", "", "b.B"}, false, GP_COLOUR_RGB,
         {"b.R", "b.G", "b.B"}},
        {{"z.blue", "a.x", "z.Red", "z.GREEN"}, false, GP_COLOUR_RGB,
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
        {{"A"}, true, GP_COLOUR_GREY, {"A", NULL, NULL}},
        {{"u", "v"}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
        {{NULL}, true, GP_COLOUR_RGB, {NULL, NULL, NULL}},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        const int n = count(row[i].name);
        struct gp_colour_choice got;
        const char *const *want = row[i].want;
        const bool found = gp_find_colour(row[i].name, n, row[i].lone, &got);
        if (found != (want[0] != NULL))
            fail_msg("row %zu: %s", i, found ? "found" : "not found");
        if (found)
            assert_choice(row[i].name, n, &got, row[i].model, want);
    }
}

static void alpha_of_the_colour(void **state)
{
    (void) state;
    static const struct {
        const char *name[4];
        int colour[4];
        int alpha;
    } row[] = {
        {{"A", "B", "G", "R"}, {-1, 2, 1, 0}, 0},
        {{"l.B", "l.G", "l.R", "l.ALPHA"}, {2, 1, 0, -1}, 3},
        {{"A", "l.B", "l.G", "l.R"}, {-1, 2, 1, 0}, -1}, // another layer's
        {{"B", "G", "R", "l.A"}, {2, 1, 0, -1}, -1},
        {{"A"}, {0, -1, -1, -1}, -1},   // it is the colour itself
        {{"A", "Z"}, {-1, -1}, -1},     // no colour, so nothing of its
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
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
    (void) state;
    static const struct gp_crypto told = {{"uObject", "l.mat"}, 2};
    static const struct {
        const char *layer;
        enum gp_crypto_kind kind;
    } row[] = {
        {"uObject00", GP_CRYPTO_IDS},     {"uObject99", GP_CRYPTO_IDS},
        {"uObject", GP_CRYPTO_PREVIEW},   {"uObject0x", GP_CRYPTO_NONE},
        {"uObjectx0", GP_CRYPTO_NONE},    {"uObject000", GP_CRYPTO_NONE},
        {"uObjec00", GP_CRYPTO_NONE},     {"l.mat07", GP_CRYPTO_IDS},
        {"mat07", GP_CRYPTO_NONE},        {"CryptoAsset02", GP_CRYPTO_IDS},
        {"l.cryptoX12", GP_CRYPTO_IDS},   {"crypto12", GP_CRYPTO_IDS},
        {"crypto1", GP_CRYPTO_NONE},      {"crypt012", GP_CRYPTO_NONE},
        {"crypto.a12", GP_CRYPTO_NONE},   {"12", GP_CRYPTO_NONE},
        {"", GP_CRYPTO_NONE},
    };
    // a file that is not EXR has names of channels only
    static const struct gp_input other = {0};
    struct gp_crypto found = told;
    gp_exr_crypto(&other, &found);
    assert_int_equal(found.n, 0);
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        char channel[40];
        const char *const layer = row[i].layer;
        const size_t len = strlen(layer);
        if (gp_crypto_layer(&told, layer, len) != row[i].kind)
            fail_msg("%s: not %d", layer, row[i].kind);
        snprintf(channel, sizeof channel, "%s.R", layer);
        assert_int_equal(gp_exr_crypto_channel(&told, &other, 0, channel),
                         row[i].kind);
        // without a layer of its own
        assert_int_equal(gp_exr_crypto_channel(&told, &other, 0, "R"),
                         GP_CRYPTO_NONE);
        assert_int_equal(gp_exr_crypto_channel(&told, NULL, 0, "R"),
                         GP_CRYPTO_NONE);
    }
}

SUITE_OF(find_names, NULL, NULL,
    colour_of_names, alpha_of_the_colour, layers_of_ids)
