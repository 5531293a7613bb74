/* io/plane: depth and coverage beside a frame, from any part; matrices. */
#include "unit.h"
#include "io/exr/exr.h"

#include "plane_fixture.h"

static void open_fixture(const struct fixture *f, struct gp_frame *frame)
{
    fixture_write_file(in_folder("f.exr"), f);
    assert_ok(read_file(path, frame));
}

/* -- search --------------------------------------------------------------- */

/* Views of parts are told by their names, "_left" or "_right". */
static void views_by_name(exr_context_t exr, int part)
{
    const char *name;
    assert_ok(exr_get_name(exr, part, &name));
    // which a file with deep parts must have in all
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
        const char *said;     // a warning, or NULL
    } row[] = {
        {{COLOUR("c")}, 1, -1, NULL, NULL, NULL},
        {{PART("c", 4, RGB(HALVES), HALF_CH("Z")), Z_PART("depth", 5)},
         2, 0, "Z", "Z", NULL},
        {{COLOUR("c"), Z_PART("z", 5)}, 2, 1, "Z", "z.Z", NULL},
        // the colour is not the first part
        {{Z_PART("z", 5), COLOUR("c")}, 2, 0, "Z", "z.Z", NULL},
        // file order; a part called depth before it
        {{COLOUR("c"), Z_PART("a", 5), Z_PART("b", 6)},
         3, 1, "Z", "a.Z", NULL},
        {{COLOUR("c"), Z_PART("a", 5), Z_PART("x.Depth.1", 6)},
         3, 2, "Z", "x.Depth.1.Z", NULL},
        // vectors are no depth
        {{COLOUR("c"), PART("n", 5, HALF_CH("X"), HALF_CH("Y"), HALF_CH("Z")),
          PART("z", 6, HALF_CH("far.Z"))}, 3, 2, "far.Z", "z.far.Z", NULL},
        {{COLOUR("c"),
          PART("n", 5, HALF_CH("X"), HALF_CH("Y"), HALF_CH("Z"))},
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
         2, 1, "Z", "depth_left.Z", "view left"},
        {{COLOUR("c"), Z_PART("z_right", 5)}, 2, 1, "Z", "z_right.Z", NULL},
        // deep parts are passed over, and named when there is nothing else
        {{COLOUR("c"), Z_PART("z", 6), DEEP("depth")},
         3, 1, "Z", "z.Z", NULL},
        {{COLOUR("c"), DEEP("d")}, 2, -1, NULL, NULL, "deep"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct fixture f = {.parts = row[i].parts, .more = views_by_name};
        struct gp_frame frame;
        struct gp_plane p;
        memcpy(f.part, row[i].part, sizeof f.part);
        open_fixture(&f, &frame);
        said[0] = '\0';
        assert_ok(gp_read_depth(&notes, &limits, &frame, NULL, &p));
        assert_int_equal(said[0] != '\0', row[i].said != NULL);
        if (row[i].said)
            assert_non_null(strstr(said, row[i].said));
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
                assert_ok(
                    gp_read_depth(&said_log, &limits, &frame, name[k], &again));
                assert_plane(&again, &f.part[row[i].from], row[i].channel);
                gp_plane_free(&again);
            }
        }
        gp_plane_free(&p);
        gp_frame_free(&frame);
    }
}

/* -- names ---------------------------------------------------------------- */

static void channels_by_name(void **state)
{
    static const struct {
        const char *name;
        int part;
        const char *channel, *called;
    } row[] = {
        {"A", 0, "A", "A"}, {"R", 0, "R", "R"}, {"main.A", 0, "A", "A"},
        {"mask", 1, "mask", "one.left.mask"},
        {"one.left.mask", 1, "mask", "one.left.mask"},
        {"two.mask", 2, "mask", "two.mask"}, {"two.b.Z", 2, "b.Z", "two.b.Z"},
        {"a.Z", 2, "a.Z", "two.a.Z"}, {"ids", 1, "ids", "one.left.ids"},
        {"wide", 1, "wide", "one.left.wide"},
    };
    struct gp_frame frame;
    open_fixture(&named, &frame);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_plane p;
        assert_ok(
            gp_read_coverage(&said_log, &limits, &frame, row[i].name, &p));
        assert_string_equal(p.name, row[i].called);
        assert_plane(&p, &named.part[row[i].part], row[i].channel);
        gp_plane_free(&p);
        // and without a frame
        assert_ok(read_plane(row[i].name, i & 1, &p));
        assert_plane(&p, &named.part[row[i].part], row[i].channel);
        gp_plane_free(&p);
    }
    gp_frame_free(&frame);
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
        assert_int_equal(gp_read_depth(&said_log, &limits, &frame, name[i], &p),
                         GP_ERR_USAGE);
        assert_non_null(strstr(said_line, list));
        assert_int_equal(read_plane(name[i], false, &p), GP_ERR_USAGE);
        assert_non_null(strstr(said_line, "; "));
        assert_null(p.v);
    }
    // two of one rank, which search must not choose between
    assert_int_equal(gp_read_depth(&said_log, &limits, &frame, NULL, &p),
                     GP_ERR_DATA);
    assert_non_null(strstr(said_line, "a.Z and b.Z"));
    assert_null(p.v);
    gp_frame_free(&frame);
}

/* -- what a frame does not keep as it was --------------------------------- */

static void samples_are_those_of_the_file(void **state)
{
    static const struct fixture yc = {.part = {{
        .channel = {{"BY", HALVES, 2, 2}, {"RY", HALVES, 2, 2}, HALF_CH("Y")},
        .data = FIXTURE_WINDOW(2, 4, 6, 8),
        .compression = EXR_COMPRESSION_ZIP}}};
    static const struct fixture rgb = {.part = {COLOUR("c")}};
    struct gp_frame frame;
    struct gp_plane p;
    open_fixture(&yc, &frame);
    assert_int_equal(frame.model, GP_COLOUR_YC);
    assert_ok(gp_read_coverage(&said_log, &limits, &frame, "Y", &p));
    assert_plane(&p, &yc.part[0], "Y");
    gp_plane_free(&p);
    assert_ok(gp_read_coverage(&said_log, &limits, &frame, "BY", &p));
    assert_plane(&p, &yc.part[0], "BY");
    gp_plane_free(&p);
    gp_frame_free(&frame);
    // a plane that another stage has changed
    open_fixture(&rgb, &frame);
    memset(frame.rgb.c[0], 0, gp_frame_pixels(&frame) * sizeof(float));
    assert_ok(gp_read_coverage(&said_log, &limits, &frame, "R", &p));
    assert_plane(&p, &rgb.part[0], "R");
    gp_plane_free(&p);
    gp_frame_free(&frame);
}

/* A frame of channels only, as formats other than EXR give one. */
static void frames_without_a_file(void **state)
{
    static float z[2] = {NAN, INFINITY}, red[2] = {-1.0f, 5.0f};
    static char z_name[] = "Z", red_name[] = "R", name[] = "made";
    struct gp_channel channel[2] = {
        {.name = red_name, .type = GP_FLOAT, .xs = 1, .ys = 1, .w = 2, .h = 1,
         .colour = 0},
        {.name = z_name, .type = GP_FLOAT, .xs = 1, .ys = 1, .w = 2, .h = 1,
         .colour = -1, .data = z},
    };
    struct gp_frame f = {.path = name, .data = {-3, 7, -1, 8},
                         .channel = channel, .channels = 2,
                         .rgb = {{red, NULL, NULL}}};
    struct gp_plane p;
    double m[16] = {42.0};
    assert_ok(gp_read_depth(&said_log, &limits, &f, NULL, &p));
    assert_true(isnan(p.v[0]) && isinf(p.v[1]));
    assert_memory_equal(&p.window, &f.data, sizeof f.data);
    gp_plane_free(&p);
    assert_ok(gp_read_coverage(&said_log, &limits, &f, "R", &p));
    assert_memory_equal(p.v, red, sizeof red);
    gp_plane_free(&p);
    assert_int_equal(gp_read_coverage(&said_log, &limits, &f, "A", &p),
                     GP_ERR_USAGE);
    assert_non_null(strstr(said_line, "(it has R, Z)"));
    assert_false(gp_frame_matrix(&f, "worldToCamera", m));
    assert_true(m[0] == 42.0);
}

/* -- matrices ------------------------------------------------------------- */

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
        assert_true(gp_frame_matrix(&frame, "worldToCamera", m));
        for (int i = 0; i < 16; i++) // of the colour's part, wherever it is
            assert_true(m[i] == (swapped ? -1.0 / (i + 1) : i + 0.5));
        assert_true(gp_frame_matrix(&frame, "worldToNDC", m));
        assert_true(m[2] == -1.0 / 3);
        assert_false(gp_frame_matrix(&frame, "other", m));
        assert_false(gp_frame_matrix(&frame, "", m));
        assert_true(m[2] == -1.0 / 3);
        gp_frame_free(&frame);
        const struct fixture_part first = f.part[0];
        f.part[0] = f.part[1];
        f.part[1] = first;
    }
}

/* -- real files ----------------------------------------------------------- */

static bool data_path(const char *name)
{
    const char *data = getenv("GLAREPP_DATA");
    snprintf(path, sizeof path, "%s/%s", data ? data : "../shared/data", name);
    return access(path, R_OK) == 0;
}

/* Facts by OpenImageIO 2.4. */
static void depth_of_real_files(void **state)
{
    static const struct {
        const char *file, *name;
        struct gp_rect window;
        float first, middle; // samples at [0, 0] and [h/2, w/2]
    } row[] = {
        {"depth/Beachball_multipart.0001.exr", "depth_right.Z",
         {654, 245, 1531, 1121}, 0.0f, 9.0f},
        {"depth/Beachball_singlepart.0001.exr", "Z", {654, 245, 1565, 1121},
         0.0f, 9.0078125f},
        {"depth/gaffer_multipart_customDepth.exr", "customDepth.Z",
         {20, 20, 80, 80}, 0.0f, 0.25f},
        {"depth/rgbaz_38x38.exr", "Z", {0, 0, 38, 38}, 0.5f, 1.0f},
        {"depth/v1.7.test.1_RGBZ.exr", "Z", {20, 20, 198, 175}, 0.10199069f,
         0.49493554f},
        {"depth/weta_trees_aristea_RGBAZ.exr", "Z", {0, 0, 1024, 576},
         80.514984f, 276.25644f},
        {"channels/channelTestNukePartPerLayer.exr", "depth.main.Z",
         {0, 0, 16, 16}, 0.099975586f, 0.099975586f},
        {"channels/channelTestNukeSinglePart.exr", "depth.Z", {0, 0, 16, 16},
         0.099975586f, 0.099975586f},
        {"channels/channelTestPartPerLayer.exr", "Z", {0, 0, 16, 16}, 0.1f,
         0.1f},
        {"channels/channelTestSinglePart.exr", "Z", {0, 0, 16, 16}, 0.1f,
         0.1f},
        {"seq_foliage/foliage.1004.exr", "Z", {0, 0, 640, 360}, 1e10f,
         17.670004f},
        {"seq_foliage/foliage_blender_multilayer.1004.exr",
         "ViewLayer.Depth.Z", {0, 0, 640, 360}, 1e10f, 17.670004f},
        {"camera/arnold_reference_worldToScreen.exr", NULL, {0}, 0, 0},
    };
    bool some = false;
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame frame;
        struct gp_plane p;
        if (!data_path(row[i].file))
            continue;
        some = true;
        assert_ok(read_file(path, &frame));
        assert_ok(gp_read_depth(&said_log, &limits, &frame, NULL, &p));
        if (row[i].name) {
            const int w = gp_rect_w(p.window), h = gp_rect_h(p.window);
            assert_string_equal(p.name, row[i].name);
            assert_memory_equal(&p.window, &row[i].window, sizeof p.window);
            assert_true(p.v[0] == row[i].first);
            assert_true(p.v[h / 2 * w + w / 2] == row[i].middle);
        } else {
            assert_null(p.v);
        }
        gp_plane_free(&p);
        gp_frame_free(&frame);
    }
    if (!some)
        skip();
}

static void matrices_of_real_files(void **state)
{
    struct gp_frame frame;
    double m[16];
    if (!data_path("seq_foliage/foliage.1004.exr"))
        skip();
    assert_ok(read_file(path, &frame));
    assert_true(gp_frame_matrix(&frame, "worldToCamera", m));
    assert_true(m[15] == 1.0 && m[3] == 0.0); // rows: translation is last
    assert_true(gp_frame_matrix(&frame, "worldToNDC", m));
    assert_false(gp_frame_matrix(&frame, "cameraToWorld", m));
    gp_frame_free(&frame);
}

SUITE_OF(read_plane, make_folder, remove_folder,
    depth_of_any_part, channels_by_name, names_that_are_not_there,
    samples_are_those_of_the_file, frames_without_a_file, matrices,
    depth_of_real_files, matrices_of_real_files)
