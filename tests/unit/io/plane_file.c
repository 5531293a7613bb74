/* io/plane: depth and coverage from files of their own. */
#include "unit.h"
#include "oiio_here.h"

#include "plane_fixture.h"

#include <libgen.h>
#include <limits.h>

static void channels_of_a_plane_file(void **state)
{
    static const struct {
        struct fixture_channel channel[4];
        bool depth;
        const char *want;  // NULL: an error
        const char *line;  // what it says
    } row[] = {
        {{HALF_CH("anything")}, true, "anything", NULL},
        {{HALF_CH("anything")}, false, "anything", NULL},
        {{HALF_CH("A"), HALF_CH("far")}, true, "far", NULL},
        {{HALF_CH("A"), HALF_CH("far")}, false, "A", NULL},
        {{HALF_CH("A")}, true, "A", NULL},
        {{HALF_CH("A"), HALF_CH("Z")}, true, "Z", NULL},
        {{HALF_CH("a"), HALF_CH("b")}, true, NULL, "a, b); name one with "
                                                   "--depth"},
        {{HALF_CH("a"), HALF_CH("b")}, false, NULL, "a, b); name one with "
                                                    "--mask"},
        {{HALF_CH("B"), HALF_CH("G"), HALF_CH("R")}, true,
         NULL, "B, G, R"},
        {{HALF_CH("l.Z"), HALF_CH("r.Z")}, true, NULL, "l.Z and r.Z"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct fixture f = {.part = {{.data = FIXTURE_WINDOW(-5, 3, 9, 4),
                                      .compression = EXR_COMPRESSION_ZIP}}};
        struct gp_plane p = {0};
        memcpy(f.part[0].channel, row[i].channel, sizeof row[i].channel);
        fixture_write_file(in_folder("plane.exr"), &f);
        said_nothing();
        gp_status st = read_plane(NULL, row[i].depth, &p);
        if (row[i].want) {
            assert_ok(st);
            assert_string_equal(p.name, row[i].want);
            assert_plane(&p, &f.part[0], row[i].want);
        } else {
            assert_int_not_equal(st, GP_OK);
            assert_non_null(strstr(said_line, row[i].line));
            assert_null(p.v);
        }
        gp_plane_free(&p);
    }
}

/* One sample of a subsampled channel covers what is left of the window. */
static void small_windows(void **state)
{
    static const struct {
        int w, h, xs, ys;
        exr_compression_t compression;
    } row[] = {
        {1, 1, 1, 1, EXR_COMPRESSION_ZIP}, {1, 7, 1, 1, EXR_COMPRESSION_PIZ},
        {2, 2, 2, 2, EXR_COMPRESSION_ZIP}, {4, 2, 4, 1, EXR_COMPRESSION_NONE},
        {2, 6, 1, 2, EXR_COMPRESSION_ZIPS},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct fixture f = {.part = {{
            .channel = {{"Z", FLOATS, row[i].xs, row[i].ys}},
            .data = FIXTURE_WINDOW(-8, -16, row[i].w, row[i].h),
            .compression = row[i].compression}}};
        struct gp_plane p;
        fixture_write_file(in_folder("small.exr"), &f);
        assert_ok(read_plane(NULL, true, &p));
        assert_string_equal(p.name, "Z");
        assert_plane(&p, &f.part[0], "Z");
        gp_plane_free(&p);
    }
}

/* Integers come as stored, 0 to 1, with no curve. Skipped without a bridge. */
static void planes_of_other_formats(void **state)
{
    enum { N = 256 };
    static const char *const grey[] = {"Y"};
    static const struct {
        const char *format, *type;
        float scale;  // of codes, 0 for floats as they are
    } row[] = {
        {"png", "uint8", 255.0f}, {"png", "uint16", 65535.0f},
        {"tif", "uint8", 255.0f}, {"tif", "float", 0.0f},
    };
    static float v[N];
    if (!has_oiio)
        skip();
    for (size_t i = 0; i < COUNT(row); i++) {
        const bool real = row[i].scale == 0.0f;
        for (int k = 0; k < N; k++)
            v[k] = (float) k / 255.0f * (real ? 1e10f : 1.0f);
        const struct gp_image image = image_of(v, 16, 16, grey, 1, "sRGB");
        struct gp_plane p;
        snprintf(path, sizeof path, "%s/p.%s", folder, row[i].format);
        assert_ok(write_image(path, row[i].format, &image, row[i].type, ""));
        assert_ok(read_plane(NULL, i & 1, &p));
        assert_int_equal(gp_rect_w(p.window), 16);
        assert_string_equal(p.name, "Y");
        for (int k = 0; k < N; k++)
            assert_float_equal(p.v[k], v[k], real ? 0.0f : 0.5f / row[i].scale);
        gp_plane_free(&p);
        assert_int_equal(read_plane("Z", true, &p), GP_ERR_USAGE);
    }
}

static void one_channel_of_many(void **state)
{
    enum { N = 4 };
    static const char *const rgb[] = {"R", "G", "B"};
    static float v[3 * N];
    if (!has_oiio)
        skip();
    for (int i = 0; i < 3 * N; i++)
        v[i] = (float) i - 5.0f;
    const struct gp_image image = image_of(v, N, 1, rgb, 3, "Linear");
    in_folder("rgb.tif");
    assert_ok(write_image(path, "tif", &image, "float", ""));
    for (int c = 0; c < 3; c++) {
        struct gp_plane p;
        assert_ok(read_plane(rgb[c], false, &p));
        for (int i = 0; i < N; i++)
            assert_true(p.v[i] == v[3 * i + c]);
        gp_plane_free(&p);
    }
}

static void deep_files(void **state)
{
    static const struct fixture f = {.part = {{
        .name = "d", .channel = {HALF_CH("Z")}, .data = W(5),
        .compression = EXR_COMPRESSION_ZIPS, .deep = true}}};
    static const char *const name[] = {NULL, "Z", "d.Z"};
    struct gp_plane p = {0};
    fixture_write_file(in_folder("deep.exr"), &f);
    for (int i = 0; i < 3; i++) {
        said_nothing();
        assert_int_equal(read_plane(name[i], true, &p), GP_ERR_DATA);
        assert_non_null(strstr(said_line, "deep"));
        assert_null(p.v);
    }
}

/* -- files that lie ------------------------------------------------------- */

static void damaged_files(void **state)
{
    size_t size;
    struct gp_plane p = {0};
    uint8_t *bytes = fixture_make(&named, &size);
    in_folder("cut.exr");
    for (size_t n = 0; n < size; n += n < 1200 ? 37 : 211) {
        fixture_save(path, bytes, n);
        gp_status st =
            read_plane("two.mask", false, &p);
        // only the last part is asked for, and it lies at the end
        assert_int_not_equal(st, GP_OK);
        assert_null(p.v);
    }
    for (size_t i = 8; i < size; i += 5) { // must not crash, hang or leak
        const uint8_t keep = bytes[i];
        bytes[i] ^= (uint8_t) (1u << (i % 8));
        fixture_save(path, bytes, size);
        if (!gp_read_plane_file(NULL, &limits, path, "mask", false, &p))
            gp_plane_free(&p);
        bytes[i] = keep;
    }
    free(bytes);
    const struct gp_read_params few = {.max_pixels = 100};
    fixture_write_file(path, &named);
    assert_int_equal(gp_read_plane_file(&said_log, &few, path, "two.mask",
                                        false, &p), GP_ERR_DATA);
    assert_non_null(strstr(said_line, "too large"));
}

static int set_up(void **state)
{
    if (open_oiio(state))
        return -1;
    return make_folder(state);
}

SUITE_OF(plane_file, set_up, remove_folder, channels_of_a_plane_file,
         small_windows, planes_of_other_formats, one_channel_of_many,
         deep_files, damaged_files)
