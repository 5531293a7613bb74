/* EXR out where half or a lossy compression cannot hold what is there. */
#include "unit.h"
#include "io/plane.h"

#include "write_fixture.h"

#include <math.h>

static void half_overflow_is_counted(void **state)
{
    (void) state;
    const struct gp_rect r = {0, 0, 33, 40};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    static const float v[6] = {1e9f, -1e9f, 65504, 65519, 65520, INFINITY};
    memcpy(f.rgb.c[0] + 700, v, sizeof v);
    memcpy(f.rgb.c[2] + 7, v, sizeof v);
    static const enum gp_compression c[] = {
        GP_COMPRESSION_NONE, GP_COMPRESSION_ZIP, GP_COMPRESSION_PIZ,
        GP_COMPRESSION_DWAA};
    for (int k = 0; k < (wf_bridge() ? 4 : 3); k++) {
        struct gp_write_stats stats = {.clamped = 100};
        p.compression = c[k];
        assert_int_equal(gp_write_picture(&wf_log, &p, wf_path("a.exr"), &f,
                                          &f.rgb, GP_PICTURE_SCENE, &stats),
                         GP_OK);
        // DWA's range ends an eighth earlier, and Inf is no part of it
        assert_int_equal(stats.clamped, k < 3 ? 106 : 112);
        struct gp_frame b = wf_read_back(wf_path("a.exr"));
        for (size_t i = 0; k == 3 && i < gp_frame_pixels(&b); i++)
            assert_true(isfinite(b.rgb.c[0][i]) && isfinite(b.rgb.c[2][i]));
        if (k < 3) {
            assert_true(b.rgb.c[0][700] == 65504 && b.rgb.c[0][701] == -65504);
            assert_true(isinf(b.rgb.c[2][12]));
        }
        gp_frame_free(&b);
    }
    gp_frame_free(&f);
}

/* B44 rounds the least value of a block down, past the end of half if let. */
static void b44_keeps_what_is_far_below_0_finite(void **state)
{
    (void) state;
    static const float v[7] = {-65504, 65504, -1e9f, -60000, -32752, -32736,
                               1};
    const struct gp_rect r = {0, 0, 33, 40};
    struct gp_frame f = wf_frame(r, r, wf_rgb);
    for (size_t i = 0; i < gp_frame_pixels(&f); i++)
        f.rgb.c[0][i] = v[i * i % 7];
    long long beyond = 0;
    for (size_t i = 0; i < gp_frame_pixels(&f); i++)
        beyond += f.rgb.c[0][i] < -32752;
    for (int k = 0; k < 2; k++) {
        struct gp_write_params p = GP_WRITE_DEFAULTS;
        struct gp_write_stats stats = {0};
        p.compression = k ? GP_COMPRESSION_B44A : GP_COMPRESSION_B44;
        assert_int_equal(gp_write_picture(&wf_log, &p, wf_path("a.exr"), &f,
                                          &f.rgb, GP_PICTURE_SCENE, &stats),
                         GP_OK);
        assert_int_equal(stats.clamped, beyond);
        struct gp_frame b = wf_read_back(wf_path("a.exr"));
        for (size_t i = 0; i < gp_frame_pixels(&b); i++) {
            assert_true(isfinite(b.rgb.c[0][i]));
            if (f.rgb.c[0][i] < -32000)
                assert_true(b.rgb.c[0][i] < -16000);
        }
        gp_frame_free(&b);
    }
    gp_frame_free(&f);
}

static uint32_t id_at(const struct gp_frame *f, size_t i)
{
    return ((const uint32_t *) gp_frame_channel(f, "id")->data)[i];
}

/* DWA leaves whole numbers alone: all 32 bits, and their values as coverage. */
static void dwa_keeps_ids(void **state)
{
    (void) state;
    const struct gp_rect r = {-3, 5, 30, 45};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_write_stats stats = {0};
    struct gp_plane ids = {0}, depth = {0};
    if (!wf_bridge())
        skip();
    struct gp_frame f = wf_frame(r, r, wf_all);
    p.compression = GP_COMPRESSION_DWAA;
    assert_int_equal(wf_write_hdr(&p, wf_path("a.exr"), &f, &stats), GP_OK);
    struct gp_frame b = wf_read_back(wf_path("a.exr"));
    const struct gp_read_params limits = GP_READ_DEFAULTS;
    assert_int_equal(gp_read_plane_file(&wf_log, &limits, wf_path("a.exr"),
                                        "id", false, &ids), GP_OK);
    assert_int_equal(gp_read_plane_file(&wf_log, &limits, wf_path("a.exr"),
                                        "Z", true, &depth), GP_OK);
    const float *const z = gp_frame_channel(&b, "Z")->data;
    for (size_t i = 0; i < gp_frame_pixels(&f); i++) {
        assert_int_equal(id_at(&b, i), id_at(&f, i));
        assert_true(ids.v[i] == (float) id_at(&f, i));
        assert_true(depth.v[i] == z[i]);
    }
    gp_plane_free(&ids);
    gp_plane_free(&depth);
    gp_frame_free(&b);
    gp_frame_free(&f);
}

SUITE(exr_lossy)
{
#define TEST(name) cmocka_unit_test_setup_teardown(name, wf_start, wf_end)
    const struct CMUnitTest tests[] = {
        TEST(half_overflow_is_counted),
        TEST(b44_keeps_what_is_far_below_0_finite),
        TEST(dwa_keeps_ids),
    };
    return cmocka_run_group_tests(tests, find_bridges, NULL);
}
