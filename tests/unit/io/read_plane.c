// SPDX-License-Identifier: Apache-2.0
/* io/plane: depth and coverage beside a frame, from any part, and from files
 * of their own; matrices. */
#include "unit.h"
#include "io/exr/exr.h"
#include "oiio_here.h"
#include "plane_fixture.h"

static gp_status beside(const struct gp_frame *f, const char *name, bool depth,
                        struct gp_plane *p)
{
    return gp_read_plane(&kept_log, &limits, f, name, depth, p);
}

static void open_fixture(const struct fixture *f, struct gp_frame *frame)
{
    fixture_write_file(in_folder("f.exr"), f);
    assert_ok(read_file(path, frame));
}

/* Views of parts are told by their names, "_left" or "_right". */
static void views_by_name(exr_context_t exr, int part)
{
    const char *name;
    assert_ok(exr_get_name(exr, part, &name));
    // a file with deep parts must have it in all
    assert_ok(exr_set_version(exr, part, 1));
    const char *view = strrchr(name, '_');
    if (view)
        assert_ok(exr_attr_set_string(exr, part, "view", view + 1));
}

/* A part of n x n pixels; then its channels. */
#define PART(called, n, ...)                                                  \
    {.name = called, .channel = {__VA_ARGS__}, .data = W(n),                  \
     .compression = EXR_COMPRESSION_ZIP}
#define COLOUR(called) PART(called, 3, RGB(HALVES))
#define Z_PART(called, n) PART(called, n, HALF_CH("Z"))
#define DEEP(called)                                                          \
    {.name = called, .channel = {HALF_CH("Z")}, .data = W(5),                 \
     .compression = EXR_COMPRESSION_ZIPS, .deep = true}

static void depth_of_any_part(void **state)
{
    static const struct {
        struct fixture_part part[FIXTURE_PARTS];
        int parts;
        int from;             // part that has it, -1 none
        const char *channel, *name;
        const char *text;     // a warning, or NULL
    } row[] = {
        {{COLOUR("c")}, 1, -1, NULL, NULL, NULL},
        {{PART("c", 4, RGB(HALVES), HALF_CH("Z")), Z_PART("depth", 5)},
         2, 0, "Z", "Z", NULL},
        {{COLOUR("c"), Z_PART("z", 5)}, 2, 1, "Z", "z.Z", NULL},
        // the colour is not the first part
        {{Z_PART("z", 5), COLOUR("c")}, 2, 0, "Z", "z.Z", NULL},
        // file order; a part called depth before it
        {{COLOUR("c"), Z_PART("a", 5), Z_PART("b", 6)}, 3, 1, "Z", "a.Z", NULL},
        {{COLOUR("c"), Z_PART("a", 5), Z_PART("x.Depth.1", 6)},
         3, 2, "Z", "x.Depth.1.Z", NULL},
        // vectors are no depth
        {{COLOUR("c"), PART("n", 5, HALF_CH("X"), HALF_CH("Y"), HALF_CH("Z")),
          PART("z", 6, HALF_CH("far.Z"))}, 3, 2, "far.Z", "z.far.Z", NULL},
        {{COLOUR("c"), PART("n", 5, HALF_CH("X"), HALF_CH("Y"), HALF_CH("Z"))},
         2, -1, NULL, NULL, NULL},
        // ranks within a part
        {{COLOUR("c"), PART("p", 5, HALF_CH("a.Z"), HALF_CH("depth.Z"))},
         2, 1, "depth.Z", "p.depth.Z", NULL},
        // the colour's view first, then none, then others with a word
        {{COLOUR("c_right"), Z_PART("depth_left", 5), Z_PART("z_right", 6)},
         3, 2, "Z", "z_right.Z", NULL},
        {{COLOUR("c_right"), Z_PART("depth_left", 5), Z_PART("z", 6)},
         3, 2, "Z", "z.Z", NULL},
        {{COLOUR("c_right"), Z_PART("depth_left", 5)},
         2, 1, "Z", "depth_left.Z", "layer and view have no depth"},
        {{COLOUR("c"), Z_PART("z_right", 5)}, 2, 1, "Z", "z_right.Z", NULL},
        // depth of the colour's own view layer; fog is none
        {{COLOUR("B.Combined"), Z_PART("A.Depth", 5), Z_PART("B.Depth", 6)},
         3, 2, "Z", "B.Depth.Z", NULL},
        {{COLOUR("B.Combined"), Z_PART("B.Mist", 5), Z_PART("A.depth", 6)},
         3, 2, "Z", "A.depth.Z", "using A.depth.Z of another"},
        {{COLOUR("s.B.Combined"), Z_PART("s.Depth", 5)},
         2, 1, "Z", "s.Depth.Z", NULL},
        {{PART("c", 3, HALF_CH("A.Depth.Z"), HALF_CH("B.Combined.B"),
               HALF_CH("B.Combined.G"), HALF_CH("B.Combined.R"))},
         1, 0, "A.Depth.Z", "A.Depth.Z", "using A.Depth.Z of another"},
        {{PART("c", 3, HALF_CH("B.Combined.R"),
               HALF_CH("B.Combined.G"), HALF_CH("B.Combined.B"),
               HALF_CH("A.Depth.Z"), HALF_CH("B.Depth.Z"))},
         1, 0, "B.Depth.Z", "B.Depth.Z", NULL},
        // deep parts are passed over, and named when there is nothing else
        {{COLOUR("c"), Z_PART("z", 6), DEEP("depth")}, 3, 1, "Z", "z.Z", NULL},
        {{COLOUR("c"), DEEP("d")}, 2, -1, NULL, NULL, "deep"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct fixture f = {.parts = row[i].parts, .more = views_by_name};
        struct gp_frame frame;
        struct gp_plane p;
        memcpy(f.part, row[i].part, sizeof f.part);
        open_fixture(&f, &frame);
        kept_clear();
        assert_ok(gp_read_plane(&kept_all, &limits, &frame, NULL, true, &p));
        assert_int_equal(kept_lines != 0, row[i].text != NULL);
        if (row[i].text)
            assert_kept(row[i].text);
        if (row[i].from < 0) {
            assert_null(p.v);
            assert_null(p.name);
        } else {
            assert_string_equal(p.name, row[i].name);
            assert_plane(&p, &f.part[row[i].from], row[i].channel);
            // both names lead back to it
            const char *const name[] = {p.name, row[i].channel};
            for (int k = 0; k < 2; k++) {
                struct gp_plane again;
                assert_ok(beside(&frame, name[k], true, &again));
                assert_plane(&again, &f.part[row[i].from], row[i].channel);
                gp_plane_free(&again);
            }
        }
        gp_plane_free(&p);
        gp_frame_free(&frame);
    }
}

static void names_that_are_not_there(void **state)
{
    static const char *const name[] = {
        "Z", "", ".", "main", "main.", "main.Z", "two", "a", "b.Z.", "mas",
        "mainXA", "one.mask", "left.mask", "two..a.Z", "%s%n",
    };
    static const char list[] =
        "A, B, G, R, one.left.ids, one.left.mask, one.left.wide, two.a.Z, "
        "two.b.Z, two.mask)";
    struct gp_frame frame;
    struct gp_plane p = {0};
    open_fixture(&named, &frame);
    for (size_t i = 0; i < COUNT(name); i++) {
        assert_int_equal(beside(&frame, name[i], true, &p), GP_ERR_USAGE);
        assert_kept(list);
        assert_int_equal(read_plane(name[i], false, &p), GP_ERR_USAGE);
        assert_kept("; ");
        assert_null(p.v);
    }
    // two of one rank, which search must not choose between
    assert_int_equal(beside(&frame, NULL, true, &p), GP_ERR_DATA);
    assert_kept("a.Z and b.Z");
    assert_null(p.v);
    gp_frame_free(&frame);
}

/* Whatever another stage has made of the frame's planes. */
static void samples_are_those_of_the_file(void **state)
{
    static const struct fixture yc = {.part = {{
        .channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2}, HALF_CH("Y")},
        .data = FIXTURE_WINDOW(2, 4, 6, 8),
        .compression = EXR_COMPRESSION_ZIP}}};
    static const struct fixture rgb = {.part = {COLOUR("c")}};
    static const struct {
        const struct fixture *f;
        enum gp_colour_model model;
        const char *name;
    } row[] = {{&yc, GP_COLOUR_YC, "Y"}, {&yc, GP_COLOUR_YC, "BY"},
               {&rgb, GP_COLOUR_RGB, "R"}};
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame frame;
        struct gp_plane p;
        open_fixture(row[i].f, &frame);
        assert_int_equal(frame.model, row[i].model);
        memset(frame.rgb.c[0], 0, gp_frame_pixels(&frame) * sizeof(float));
        assert_ok(beside(&frame, row[i].name, false, &p));
        assert_plane(&p, &row[i].f->part[0], row[i].name);
        gp_plane_free(&p);
        gp_frame_free(&frame);
    }
}

/* Part 0: m44f; part 1: m44d and another; both in bits that floats hold. */
static void put_matrices(exr_context_t exr, int part)
{
    exr_attr_m44f_t single;
    exr_attr_m44d_t twice;
    for (int i = 0; i < 16; i++) {
        single.m[i] = (float) i + 0.5f;
        twice.m[i] = -1.0 / (i + 1);
    }
    if (part == 0) {
        exr_attr_set_m44f(exr, part, "worldToCamera", &single);
        exr_attr_set_string(exr, part, "other", "no matrix");
    } else {
        exr_attr_set_m44d(exr, part, "worldToCamera", &twice);
        exr_attr_set_m44d(exr, part, "worldToNDC", &twice);
    }
}

static void matrices(void **state)
{
    struct fixture f = {.parts = 2, .more = put_matrices,
                        .part = {COLOUR("c"), Z_PART("z", 2)}};
    struct gp_frame frame;
    double m[16];
    for (int swapped = 0; swapped < 2; swapped++) {
        open_fixture(&f, &frame);
        assert_true(gp_frame_numbers(&frame, "worldToCamera", 16, m));
        for (int i = 0; i < 16; i++) // of the colour's part, wherever it is
            assert_true(m[i] == (swapped ? -1.0 / (i + 1) : i + 0.5));
        assert_true(gp_frame_numbers(&frame, "worldToNDC", 16, m));
        assert_true(m[2] == -1.0 / 3);
        assert_false(gp_frame_numbers(&frame, "other", 16, m));
        assert_false(gp_frame_numbers(&frame, "", 16, m));
        assert_true(m[2] == -1.0 / 3);
        gp_frame_free(&frame);
        const struct fixture_part first = f.part[0];
        f.part[0] = f.part[1];
        f.part[1] = first;
    }
}

/* -- files of their own --------------------------------------------------- */

static void channels_of_a_plane_file(void **state)
{
    static const struct {
        struct fixture_channel channel[4];
        bool depth;
        const char *want;  // NULL: an error
        const char *line;  // its message
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
        {{HALF_CH("B"), HALF_CH("G"), HALF_CH("R")}, true, NULL, "B, G, R"},
        {{HALF_CH("l.Z"), HALF_CH("r.Z")}, true, NULL, "l.Z and r.Z"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct fixture f = {.part = {{.data = FIXTURE_WINDOW(-5, 3, 9, 4),
                                      .compression = EXR_COMPRESSION_ZIP}}};
        struct gp_plane p = {0};
        memcpy(f.part[0].channel, row[i].channel, sizeof row[i].channel);
        fixture_write_file(in_folder("plane.exr"), &f);
        kept_clear();
        gp_status st = read_plane(NULL, row[i].depth, &p);
        if (row[i].want) {
            assert_ok(st);
            assert_string_equal(p.name, row[i].want);
            assert_plane(&p, &f.part[0], row[i].want);
        } else {
            assert_int_not_equal(st, GP_OK);
            assert_kept(row[i].line);
            assert_null(p.v);
        }
        gp_plane_free(&p);
    }
}

/* Integers come as stored, 0 to 1, with no curve. Skipped without a bridge. */
static void planes_of_other_formats(void **state)
{
    enum { N = 256 };
    static const char *const grey[] = {"Y"}, *const rgb[] = {"R", "G", "B"};
    static const struct {
        const char *format, *type;
        int channels;
        float scale;  // of codes, 0 for floats as they are
    } row[] = {
        {"png", "uint8", 1, 255.0f}, {"png", "uint16", 1, 65535.0f},
        {"tif", "uint8", 1, 255.0f}, {"tif", "float", 1, 0.0f},
        {"tif", "float", 3, 0.0f},
    };
    static float v[3 * N];
    if (!has_oiio)
        skip_for("no OpenImageIO");
    for (size_t i = 0; i < COUNT(row); i++) {
        const bool real = row[i].scale == 0.0f;
        const int n = row[i].channels;
        for (int k = 0; k < n * N; k++)
            v[k] = (float) k / (float) (n * N - 1) * (real ? 1e10f : 1.0f);
        const struct gp_decoded image = image_of(v, 16, 16, n == 3 ? rgb : grey,
                                               n, n == 3 ? "Linear" : "sRGB");
        struct gp_plane p;
        snprintf(path, sizeof path, "%s/p.%s", folder, row[i].format);
        assert_ok(write_image(path, row[i].format, &image, row[i].type, ""));
        for (int c = 0; c < n; c++) {
            assert_ok(read_plane(n == 3 ? rgb[c] : NULL, i & 1, &p));
            assert_int_equal(gp_rect_w(p.window), 16);
            assert_string_equal(p.name, image.channel_name[c]);
            for (int k = 0; k < N; k++)
                assert_float_equal(p.v[k], v[k * n + c],
                                   (real ? 0.0f : 0.5f / row[i].scale));
            gp_plane_free(&p);
        }
        assert_int_equal(read_plane("Z", true, &p), GP_ERR_USAGE);
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
        kept_clear();
        assert_int_equal(read_plane(name[i], true, &p), GP_ERR_DATA);
        assert_kept("deep");
        assert_null(p.v);
    }
}

static void planes_over_max_pixels(void **state)
{
    struct gp_plane p = {0};
    const struct gp_read_params few = {.max_pixels = 100};
    fixture_write_file(in_folder("many.exr"), &named);
    assert_int_equal(gp_read_plane_file(&kept_log, &few, path, "two.mask",
                                        false, &p), GP_ERR_DATA);
    assert_kept("too large");
}

/* exrmultipart writes none in a flat part beside a deep one. */
static void a_flat_part_without_version(void **state)
{
    static const char version[] = "version\0int";
    const struct fixture f = {
        .parts = 2, .part = {COLOUR("c"), DEEP("d")}, .more = views_by_name};
    struct gp_frame frame;
    size_t size;
    uint8_t *bytes = fixture_make(&f, &size);
    uint8_t *const at = memmem(bytes, size, version, sizeof version);
    assert_non_null(at);
    *at = '-';
    fixture_save(in_folder("f.exr"), bytes, size);
    free(bytes);
    assert_ok(read_file(path, &frame));
    assert_int_equal(frame.parts, 2);
    gp_frame_free(&frame);
}

static int set_up(void **state)
{
    return open_oiio(state) || make_folder(state);
}

SUITE_OF(read_plane, set_up, remove_folder, channels_of_a_plane_file,
         planes_of_other_formats, deep_files, planes_over_max_pixels,
         depth_of_any_part, a_flat_part_without_version,
         names_that_are_not_there, samples_are_those_of_the_file, matrices)
