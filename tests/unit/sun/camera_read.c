/* sun/camera_read: cameras from JSON, and against the data folder's frames and
 * their headers. The folder is $GLAREPP_DATA, or ../shared/data; without it
 * those tests are skipped. */
#include "unit.h"
#include "io/plane.h"
#include "io/read.h"
#include "json_file.h"
#include "sun/camera.h"

#include <jansson.h>

static const double SUN = 0.533; // degrees, as the data's generator took it

static void near_to(const char *what, double got, double want, double within)
{
    if (!(fabs(got - want) <= within))
        fail_msg("%s: %.12g is not %.12g within %g", what, got, want, within);
}

/* -- files ---------------------------------------------------------------- */

// looks along +y, z up; the same camera in both forms
#define SPEC "\"worldToNDC_rowmajor\": " \
    "[1,0,0,0, 0.5,0.5,1,1, 0,-2,0,0, 0,0,-0.1,0]"
#define CLIP "\"worldToNDC_blender_colvec\": " \
    "[2,0,0,0, 0,0,4,0, 0,1,0,-0.1, 0,1,0,0]"
#define UNIT "\"worldToCamera_rowmajor\": [1,0,0,0, 0,0,1,0, 0,1,0,0, 0,0,0,1]"

static void files_by_content(void **state)
{
    (void) state;
    static const struct {
        const char *text;
        int frames;      // 0: an error
        const char *say;
    } row[] = {
        {"{\"frames\": [{\"frame\": 1, " SPEC "}]}", 1, NULL},
        {"[{\"frame\": 1, " SPEC "}]", 1, NULL},
        {"{\"x\": 1, \"frames\": [{\"frame\": 1, " CLIP ", \"y\": null}]}", 1,
         NULL},
        {"[{\"frame\": 5, " SPEC "}, {\"frame\": -3, " CLIP "}]", 2, NULL},
        {"[{\"frame\": 1, " SPEC ", \"worldToNDC_blender_colvec\": "
         "[0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,0]}]", 1, NULL},
        {"[{\"frame\": 1, " UNIT ", " CLIP ", \"sun_dir_world\": [0,1,0.1], "
         "\"sun_radius_px\": 2.5}]", 1, NULL},
        {"{}", 0, "no \"frames\""},
        {"[]", 0, "no frames"},
        {"{\"frames\": []}", 0, "no frames"},
        {"{\"frames\": 3}", 0, "no array"},
        {"[3]", 0, "frame 1 in order is no object"},
        {"[{" SPEC "}]", 0, "frame 1 in order has no number (found no \"fr"},
        {"[{\"frame\": 1.5, " SPEC "}]", 0, "(found a fraction)"},
        {"[{\"frame\": 1e17, " SPEC "}]", 0, "out of range"},
        {"[{\"frame\": \"1\", " SPEC "}]", 0, "no number"},
        {"[{\"frame\": 9}]", 0, "frame 9: no projection"},
        {"[{\"frame\": 9, " UNIT "}]", 0, "frame 9: no projection"},
        {"[{\"frame\": 9, \"worldToNDC_rowmajor\": [1, 2]}]", 0,
         "frame 9: \"worldToNDC_rowmajor\" is no array of 16"},
        {"[{\"frame\": 9, \"worldToNDC_rowmajor\": "
         "[1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]", 0,
         "frame 9: worldToNDC has no view axis"},
        {"[{\"frame\": 9, " SPEC ", \"worldToCamera_rowmajor\": "
         "[0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,0]}]", 0,
         "frame 9: worldToCamera is singular"},
        {"[{\"frame\": 9, " SPEC ", \"worldToCamera_rowmajor\": null}]", 0,
         "frame 9: \"worldToCamera_rowmajor\""},
        {"[{\"frame\": 7, " SPEC "}, {\"frame\": 8, " SPEC "}, {\"frame\": 7, "
         SPEC "}]", 0, "frame 7 is there twice"},
        {"[{\"frame\": 9, " SPEC ", \"sun_dir_world\": [0,0,0]}]", 0,
         "frame 9: \"sun_dir_world\" has no direction"},
        {"[{\"frame\": 9, " SPEC ", \"sun_dir_world\": [0,1]}]", 0,
         "frame 9: \"sun_dir_world\""},
        {"[{\"frame\": 9, " SPEC ", \"sun_radius_px\": -1}]", 0,
         "frame 9: \"sun_radius_px\" out of range"},
        {"[{\"frame\": 9, " SPEC ", \"frame\": 9}]", 0, "duplicate"},
        {"", 0, "empty"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_camera_file f = {0};
        gp_status st = gp_camera_read(&jf_log, jf_write(row[i].text), &f);
        if (st != (row[i].frames ? GP_OK : GP_ERR_DATA) ||
            f.n != row[i].frames)
            fail_msg("row %zu: status %d, %d frames, %s", i, st, f.n, jf_line);
        if (st && (!strstr(jf_line, row[i].say) || !strstr(jf_line, "; ")))
            fail_msg("row %zu: %s", i, jf_line);
        gp_camera_file_free(&f);
        gp_camera_file_free(&f);
    }
}

static void both_forms_are_one_camera(void **state)
{
    (void) state;
    struct gp_camera_file f;
    assert_int_equal(
        gp_camera_read(&jf_log, jf_write("[{\"frame\": 2, " SPEC "}, "
                                         "{\"frame\": 1, " CLIP ", " UNIT ", "
                                         "\"sun_dir_world\": [0, 3, 1]}]"),
                       &f), GP_OK);
    const struct gp_camera_frame *a = gp_camera_frame_find(&f, 1);
    const struct gp_camera_frame *b = gp_camera_frame_find(&f, 2);
    assert_true(a && b && a != b);
    assert_memory_equal(a->camera.to_ndc, b->camera.to_ndc,
                        sizeof a->camera.to_ndc);
    assert_true(a->camera.has_camera && !b->camera.has_camera);
    assert_true(a->has_sun && !b->has_sun);
    assert_true(a->sun_dir[1] == 3.0 && a->sun_radius == 0.0);
    gp_camera_file_free(&f);
}

static void frames_are_found_by_number(void **state)
{
    (void) state;
    static char text[1 << 20];
    struct gp_camera_file f;
    int n = 0;
    // 37 and 100 have no common factor: every number once, in no order
    for (int i = 0; i < 100; i++)
        n += snprintf(text + n, sizeof text - (size_t) n,
                      "%s{\"frame\": %d, " SPEC ", \"sun_radius_px\": %d}",
                      i ? ", " : "[", i * 37 % 100 - 50, i * 37 % 100);
    snprintf(text + n, sizeof text - (size_t) n, "]");
    assert_int_equal(gp_camera_read(&jf_log, jf_write(text), &f), GP_OK);
    assert_int_equal(f.n, 100);
    for (int i = -60; i < 60; i++) {
        const struct gp_camera_frame *at = gp_camera_frame_find(&f, i);
        assert_int_equal(at != NULL, i >= -50 && i < 50);
        assert_true(!at || (at->frame == i && at->sun_radius == i + 50));
    }
    gp_camera_file_free(&f);
    assert_null(gp_camera_frame_find(&f, 0));
    // a lone camera is every frame's
    assert_int_equal(
        gp_camera_read(&jf_log, jf_write("[{\"frame\": 9, " SPEC "}]"), &f),
        GP_OK);
    assert_non_null(gp_camera_frame_find(&f, 1234));
    gp_camera_file_free(&f);
}

/* A long sequence is more than the other files may be, but not without end. */
static void large_files_have_an_end(void **state)
{
    (void) state;
    static const char frame[] = "[{\"frame\": 9, " SPEC "}";
    static const struct {
        size_t bytes;
        gp_status st;
    } row[] = {
        {2 << 20, GP_OK}, {8 << 20, GP_OK}, {(8 << 20) + 1, GP_ERR_DATA},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        char *text = malloc(row[i].bytes);
        struct gp_camera_file f = {0};
        assert_non_null(text);
        memset(text, ' ', row[i].bytes);
        memcpy(text, frame, sizeof frame - 1);
        text[row[i].bytes - 1] = ']';
        jf_write_bytes(text, row[i].bytes);
        free(text);
        assert_int_equal(gp_camera_read(&jf_log, jf_file, &f), row[i].st);
        gp_camera_file_free(&f);
    }
    struct gp_camera_file f;
    assert_int_equal(gp_camera_read(&jf_log, jf_folder, &f), GP_ERR_IO);
    assert_int_equal(gp_camera_read(&jf_log, "/nowhere", &f), GP_ERR_IO);
}

/* -- the data's frames ----------------------------------------------------- */

static const char *data_path(const char *name)
{
    static char path[4096];
    const char *data = getenv("GLAREPP_DATA");
    snprintf(path, sizeof path, "%s/%s", data ? data : "../shared/data", name);
    return path;
}

static json_t *truth_of(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s.camera.json", name);
    return json_load_file(data_path(path), 0, NULL);
}

static double item(const json_t *array, size_t i)
{
    return json_number_value(json_array_get(array, i));
}

static void vector(const json_t *o, const char *key, double out[3])
{
    for (size_t i = 0; i < 3; i++)
        out[i] = item(json_object_get(o, key), i);
}

/* The sun of a frame by one of its cameras. The data's radius is that of the
 * picture's middle: f tan a, without the growth off the axis. */
static void check_sun(const struct gp_camera *c, struct gp_rect display,
                      const json_t *truth)
{
    double dir[3];
    const json_t *pixel = json_object_get(truth, "sun_pixel_xy_depth");
    const double want =
        json_number_value(json_object_get(truth, "sun_radius_px"));
    vector(truth, "sun_dir_world", dir);
    struct gp_projected p = gp_camera_project(c, display, dir, 0.0);
    assert_false(p.behind);
    near_to("sun x", p.x, item(pixel, 0), 0.01);
    near_to("sun y", p.y, item(pixel, 1), 0.01);
    const double axis[3] = {c->to_ndc[3], c->to_ndc[7], c->to_ndc[11]};
    const double cos_t = dir[0] * axis[0] + dir[1] * axis[1] +
                         dir[2] * axis[2]; // both of length 1
    near_to("middle", gp_camera_disc(c, display, axis, SUN), want, 1e-3);
    near_to("radius", gp_camera_disc(c, display, dir, SUN) * pow(cos_t, 1.5),
            want, 1e-3);
}

/* The lamps of a frame: place and distance along the axis. */
static int check_lamps(const struct gp_camera *c, struct gp_rect display,
                       const json_t *lamps)
{
    int outside = 0;
    size_t i;
    json_t *lamp;
    json_array_foreach (lamps, i, lamp) {
        double pos[3], want[3];
        vector(lamp, "pos", pos);
        vector(lamp, "pixel_xy_depth", want);
        struct gp_projected p = gp_camera_project(c, display, pos, 1.0);
        assert_false(p.behind);
        near_to("lamp x", p.x, want[0], 0.05);
        near_to("lamp y", p.y, want[1], 0.05);
        near_to("lamp z", p.z, want[2], 1e-4 * want[2]);
        assert_true(p.ray > p.z && p.ray < 2.0 * p.z);
        outside += !(p.x >= 0 && p.x < display.x1 && p.y >= 0 &&
                     p.y < display.y1);
    }
    return outside;
}

/* From the frame's own header. */
static struct gp_camera header_camera(const char *name, int number,
                                      struct gp_rect *display)
{
    static const struct gp_read_params params = GP_READ_DEFAULTS;
    char path[256];
    struct gp_frame f;
    struct gp_camera c;
    double camera[16], ndc[16];
    snprintf(path, sizeof path, "%s.%d.exr", name, number);
    if (gp_read_frame(&jf_log, &params, data_path(path), &f))
        fail_msg("%s", jf_line);
    assert_true(gp_frame_matrix(&f, "worldToCamera", camera));
    assert_true(gp_frame_matrix(&f, "worldToNDC", ndc));
    if (gp_camera_make(&jf_log, path, camera, ndc, GP_NDC_AUTO, &c))
        fail_msg("%s", jf_line);
    *display = f.display;
    gp_frame_free(&f);
    return c;
}

static void suns_and_lamps_of_the_data(void **state)
{
    (void) state;
    static const char *const names[] = {
        "seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
        "rendered/brightsky", "rendered/night",
    };
    int suns = 0, outside = 0;
    for (size_t i = 0; i < COUNT(names); i++) {
        char path[256];
        struct gp_camera_file file;
        json_t *truth = truth_of(names[i]), *frame;
        size_t k;
        if (!truth)
            skip();
        snprintf(path, sizeof path, "%s.camera.json", names[i]);
        if (gp_camera_read(&jf_log, data_path(path), &file))
            fail_msg("%s", jf_line);
        json_array_foreach (json_object_get(truth, "frames"), k, frame) {
            const int number =
                (int) json_integer_value(json_object_get(frame, "frame"));
            struct gp_rect display;
            const struct gp_camera header =
                header_camera(names[i], number, &display);
            const struct gp_camera_frame *at =
                gp_camera_frame_find(&file, number);
            assert_non_null(at);
            assert_int_equal(at->frame, number);
            assert_true(at->camera.has_camera);
            for (int j = 0; j < 16; j++)
                near_to("entry", at->camera.to_ndc[j], header.to_ndc[j], 1e-5);
            assert_int_equal(at->has_sun,
                             json_object_get(frame, "sun_dir_world") != NULL);
            if (at->has_sun) {
                check_sun(&at->camera, display, frame);
                check_sun(&header, display, frame);
                assert_true(at->sun_radius == json_number_value(
                                json_object_get(frame, "sun_radius_px")));
                suns++;
            }
            const json_t *lamps = json_object_get(frame, "lamps");
            outside += check_lamps(&at->camera, display, lamps);
            assert_int_equal(check_lamps(&header, display, lamps),
                             check_lamps(&at->camera, display, lamps));
        }
        gp_camera_file_free(&file);
        json_decref(truth);
    }
    assert_int_equal(suns, 11);
    assert_int_equal(outside, 1);
}

/* Arnold's matrices, whatever they are called, are of the other convention. */
static void arnold_is_told_from_the_spec(void **state)
{
    (void) state;
    static const struct {
        const char *file, *matrix;
    } row[] = {
        {"camera/arnold_multichannel_tiled64.exr", "worldToNDC"},
        {"camera/arnold_reference_worldToScreen.exr", "worldToScreen"},
    };
    static const struct gp_read_params params = GP_READ_DEFAULTS;
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_frame f;
        struct gp_camera c, clip;
        double camera[16], ndc[16];
        if (access(data_path(row[i].file), R_OK) != 0)
            skip();
        if (gp_read_frame(&jf_log, &params, data_path(row[i].file), &f))
            fail_msg("%s", jf_line);
        assert_true(gp_frame_matrix(&f, "worldToCamera", camera));
        assert_true(gp_frame_matrix(&f, row[i].matrix, ndc));
        assert_int_equal(gp_camera_make(&jf_log, f.path, camera, ndc,
                                        GP_NDC_AUTO, &c), GP_OK);
        assert_int_equal(gp_camera_make(&jf_log, f.path, camera, ndc,
                                        GP_NDC_CLIP, &clip), GP_OK);
        assert_memory_equal(&c, &clip, sizeof c);
        // what stands above the axis in the camera is higher in the picture
        const double up[3] = {camera[2] + 0.1 * camera[1],
                              camera[6] + 0.1 * camera[5],
                              camera[10] + 0.1 * camera[9]};
        const double back[3] = {0.2 * camera[1] - up[0],
                                0.2 * camera[5] - up[1],
                                0.2 * camera[9] - up[2]};
        struct gp_projected p = gp_camera_project(&c, f.display, up, 0.0);
        if (p.behind) // its z may count backwards
            p = gp_camera_project(&c, f.display, back, 0.0);
        assert_false(p.behind);
        near_to("x", p.x, 0.5 * f.display.x1, 1e-3);
        assert_true(p.y < 0.49 * f.display.y1 && p.y > 0.0);
        gp_frame_free(&f);
    }
}

SUITE_OF(camera_read, jf_setup, jf_teardown,
    files_by_content, both_forms_are_one_camera, frames_are_found_by_number,
    large_files_have_an_end, suns_and_lamps_of_the_data,
    arnold_is_told_from_the_spec)
