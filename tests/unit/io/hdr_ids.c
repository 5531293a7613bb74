/* Which channels are ids, and what lossy compressions do to them and to all
 * that is carried. */
#include "unit.h"
#include "write_fixture.h"

#include "io/crypto.h"
#include "io/exr/exr_priv.h"
#include "io/read.h"

static const struct gp_read_params read_params = GP_READ_DEFAULTS;
static const struct gp_rect window = {-3, 5, 42, 45};

/* gp_exr_loses() against what OpenEXR does to random bits. */
static void lossy_channels(void **state)
{
    (void) state;
    static const char *const last[] = {"A", "B", "BY", "G", "R", "RY", "Y",
                                       "Z", "r", "red", "x"};
    enum { LAST = sizeof last / sizeof *last };
    for (int type = GP_UINT; type <= GP_FLOAT; type++) {
        char name[LAST][16];
        struct wf_channel list[LAST + 4];
        memcpy(list, wf_rgb, sizeof wf_rgb);
        for (int i = 0; i < LAST; i++) {
            snprintf(name[i], sizeof name[i], "a.%s", last[i]);
            list[3 + i] = (struct wf_channel) {name[i], type, -1, 0, 0};
        }
        list[3 + LAST] = (struct wf_channel) {NULL, 0, 0, 0, 0};
        struct gp_frame f = wf_frame(window, window, list);
        wf_fill_bits(&f, true);
        for (int c = GP_COMPRESSION_NONE; c <= GP_COMPRESSION_DWAB; c++) {
            struct gp_write_params p = GP_WRITE_DEFAULTS;
            struct gp_write_stats stats = {0};
            p.compression = c;
            if (wf_write_hdr(&p, wf_path("a.exr"), &f, &stats))
                fail_msg("%s", wf_line);
            struct gp_frame b;
            if (gp_read_frame(&wf_log, &read_params, wf_path("a.exr"), &b))
                fail_msg("%s", wf_line);
            for (int i = 3; i < 3 + LAST; i++) {
                const struct gp_channel *q = &b.channel[i];
                const bool same =
                    memcmp(q->data, f.channel[i].data,
                           gp_frame_pixels(&f) * gp_type_size(q->type)) == 0;
                if (same == gp_exr_loses(c, (enum gp_pixel_type) type,
                                         q->name))
                    fail_msg("%s of type %d in compression %d is %s", q->name,
                             type, c, same ? "kept" : "lost");
            }
            gp_frame_free(&b);
        }
        gp_frame_free(&f);
    }
    assert_false(gp_exr_loses(GP_COMPRESSION_AUTO, GP_FLOAT, "R"));
}

static void lossy_ids(void **state)
{
    (void) state;
    static const struct {
        const char *name;
        enum gp_pixel_type type;
        enum gp_compression compression;
        bool fine;
    } rows[] = {
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"CryptoObject00.A", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_B44, true},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_B44A, true},
        {"CryptoObject00.R", GP_HALF, GP_COMPRESSION_B44A, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_DWAA, false},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_DWAB, false},
        {"CryptoObject00.r", GP_FLOAT, GP_COMPRESSION_DWAB, true},
        {"CryptoObject00.A", GP_FLOAT, GP_COMPRESSION_DWAA, true},
        {"View.crypto_asset02.R", GP_FLOAT, GP_COMPRESSION_PXR24, false},
        {"crypto_asset.R", GP_FLOAT, GP_COMPRESSION_PXR24, true},
        {"diffuse00.R", GP_FLOAT, GP_COMPRESSION_PXR24, true},
        {"Z", GP_FLOAT, GP_COMPRESSION_PXR24, true},
        {"CryptoObject00.R", GP_FLOAT, GP_COMPRESSION_AUTO, true},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        struct wf_channel list[5];
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        struct gp_write_stats stats = {0};
        memcpy(list, wf_rgb, sizeof wf_rgb);
        list[4] = list[3];
        list[3] = (struct wf_channel) {rows[i].name, rows[i].type, -1, 0, 0};
        struct gp_frame f = wf_frame(window, window, list);
        wf_fill_bits(&f, true);
        p.compression = rows[i].compression;
        const gp_status st = wf_write_hdr(&p, wf_path("a.exr"), &f, &stats);
        if (st != (rows[i].fine ? GP_OK : GP_ERR_USAGE))
            fail_msg("row %zu: %d", i, st);
        if (!rows[i].fine) {
            wf_assert_said(rows[i].name);
            wf_assert_said("; use --compression zip");
            assert_int_equal(wf_names(), 0);
        } else {
            assert_int_equal(remove(wf_path("a.exr")), 0);
        }
        gp_frame_free(&f);
    }
}

/* By a manifest, and without one. */
static void crypto_names(void **state)
{
    (void) state;
    const struct gp_crypto manifest = {{"matte", "a.b"}, 2}, none = {0};
    static const struct {
        const char *layer;
        enum gp_crypto_kind with, without;
    } rows[] = {
        {"matte", GP_CRYPTO_PREVIEW, GP_CRYPTO_NONE},
        {"matte00", GP_CRYPTO_IDS, GP_CRYPTO_NONE},
        {"matte0", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"matte000", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"x.matte00", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"a.b01", GP_CRYPTO_IDS, GP_CRYPTO_NONE},
        {"CryptoObject00", GP_CRYPTO_IDS, GP_CRYPTO_IDS},
        {"View.cryptomaterial12", GP_CRYPTO_IDS, GP_CRYPTO_IDS},
        {"Crypto.Object00", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"CryptoObject", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"crypto00", GP_CRYPTO_IDS, GP_CRYPTO_IDS},
        {"00", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
        {"", GP_CRYPTO_NONE, GP_CRYPTO_NONE},
    };
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const char *l = rows[i].layer;
        assert_int_equal(gp_crypto_layer(&manifest, l, strlen(l)),
                         rows[i].with);
        assert_int_equal(gp_crypto_layer(&none, l, strlen(l)),
                         rows[i].without);
    }
}

SUITE(hdr_ids)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, wf_start, wf_end)
    const struct CMUnitTest tests[] = {
        TEST(lossy_channels), TEST(lossy_ids), TEST(crypto_names),
    };
    return cmocka_run_group_tests(tests, find_bridges, NULL);
}
