// SPDX-License-Identifier: Apache-2.0
/* core/camera, sun/lights: matrices by hand, places and discs under them;
 * cameras from JSON, and against the data folder's frames and their headers.
 * The folder is data_path()'s; without it those tests skip. */
#include "json_file.h"
#include "core/json.h"
#include "io/plane.h"
#include "sun/lights.h"

#include <float.h>
#include <unistd.h>

static const double SUN = 0.533; // degrees, as the data's generator took it
static const struct gp_rect hd = {0, 0, 1920, 1080};

static void near_to(const char *what, double got, double want, double within)
{
    if (!(fabs(got - want) <= within))
        fail_msg("%s: %.12g is not %.12g within %g", what, got, want, within);
}

// -- a camera by hand --------------------------------------------------------

/* A pinhole that looks along +y, z up, x right: focal length f in heights,
 * aspect 16:9, lens shift (sx, sy) in shares of the picture. For the spec's
 * convention, times `scale`. */
struct hand {
    double f, sx, sy, eye[3], scale;
};

static void hand_matrix(const struct hand *h, bool clip, double m[16])
{
    const double fx = h->f * 9.0 / 16.0;
    const double cx = 0.5 + h->sx, cy = 0.5 + h->sy;
    // X = fx x + cx y, Y = cy y - f z, depth y - 0.1, W = y
    double a[4][3] = {{fx, 0, 0}, {cx, cy, 1}, {0, -h->f, 0}, {0, 0, 0}};
    double w[4] = {0, 1, 0, 0};
    for (int i = 0; i < 3; i++) {
        for (int c = 0; c < 3; c++)
            a[3][c] -= h->eye[i] * a[i][c];
        w[3] -= h->eye[i] * w[i];
    }
    for (int r = 0; r < 4; r++) {
        const double x = a[r][0], y = a[r][1];
        m[4 * r] = h->scale * (clip ? 2.0 * x - w[r] : x);
        m[4 * r + 1] = h->scale * (clip ? w[r] - 2.0 * y : y);
        m[4 * r + 2] = h->scale * a[r][2];
        m[4 * r + 3] = h->scale * w[r];
    }
}

static struct gp_camera camera_of(const struct hand *h, bool clip,
                                  enum glarepp_ndc ndc)
{
    double m[16];
    struct gp_camera c;
    hand_matrix(h, clip, m);
    if (gp_camera_make(&kept_log, "a.exr", NULL, m, ndc, &c))
        fail_msg("%s", kept_line);
    return c;
}

static const struct hand plain = {1.5, 0, 0, {10, 20, 30}, 1};

static void places_of_a_hand_made_camera(void **state)
{
    static const struct {
        double at[3], w, x, y, z, ray;
        bool behind;
    } row[] = {
        {{0, 1, 0}, 0, 960, 540, INFINITY, INFINITY, false},
        {{0, 1e-300, 0}, 0, 960, 540, INFINITY, INFINITY, false},
        {{0, 1e308, 0}, 0, 960, 540, INFINITY, INFINITY, false},
        {{0, 1e308, -1.7e308}, 0, 960, 3294, INFINITY, INFINITY, false},
        {{1, 3, 0}, 0, 960 + 540, 540, INFINITY, INFINITY, false},
        {{0, 3, 1}, 0, 960, 540 - 540, INFINITY, INFINITY, false},
        {{10, 24, 30}, 1, 960, 540, 4, 4, false},
        {{13, 24, 30}, 1, 960 + 1215, 540, 4, 5, false},
        {{10, 24, 18}, 1, 960, 540 + 4860, 4, 12.649110640673518, false},
        {{0, -1, 0}, 0, 0, 0, 0, 0, true}, {{1, 0, 0}, 0, 0, 0, 0, 0, true},
        {{0, 0, 0}, 0, 0, 0, 0, 0, true},
        {{10, 20, 30}, 1, 0, 0, 0, 0, true}, // the camera itself
        {{10, 19, 30}, 1, 0, 0, 0, 0, true},
        {{1, 1e-8, 0}, 0, 0, 0, 0, 0, true}, // beside: 1.6e11 pixels away
        {{NAN, 1, 0}, 0, 0, 0, 0, 0, true},
        {{0, INFINITY, 0}, 0, 0, 0, 0, 0, true},
        {{0, NAN, 0}, 1, 0, 0, 0, 0, true},
        {{DBL_MAX, DBL_MAX, DBL_MAX}, 1, 0, 0, 0, 0, true},
    };
    for (int form = 0; form < 4; form++) {
        struct hand h = plain;
        h.scale = form & 2 ? 1e-200 : 1.0; // of a projection says nothing
        const struct gp_camera c = camera_of(&h, form & 1, GLAREPP_NDC_AUTO);
        for (size_t i = 0; i < COUNT(row); i++) {
            struct gp_projected p =
                gp_camera_project(&c, hd, row[i].at, row[i].w);
            if (p.behind != row[i].behind)
                fail_msg("form %d row %zu: behind is %d", form, i, p.behind);
            near_to("x", p.x, row[i].x, 1e-6);
            near_to("y", p.y, row[i].y, 1e-6);
            if (isfinite(row[i].z)) {
                near_to("z", p.z, row[i].z, 1e-9);
                near_to("ray", p.ray, row[i].ray, 1e-9);
            } else {
                assert_true(isinf(p.z) && isinf(p.ray));
            }
        }
    }
}

/* NDC spans the display window, wherever that lies. */
static void windows_move_and_scale(void **state)
{
    static const struct gp_rect rows[] = {
        {0, 0, 1, 1}, {-500, 300, 1420, 1380}, {7, -9, 8, 1000},
        {INT32_MIN / 4, INT32_MIN / 4, INT32_MAX / 4, INT32_MAX / 4},
        {5, 5, 5, 5},
    };
    static const double dir[3] = {0.2, 1, 0.3};
    const struct gp_camera c = camera_of(&plain, false, GLAREPP_NDC_AUTO);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_rect r = rows[i];
        struct gp_projected p = gp_camera_project(&c, r, dir, 0.0);
        const double w = (double) r.x1 - r.x0, h = (double) r.y1 - r.y0;
        near_to("x", p.x, r.x0 + w * (0.5 + 1.5 * 9 / 16 * 0.2), 1e-6);
        near_to("y", p.y, r.y0 + h * (0.5 - 1.5 * 0.3), 1e-6);
    }
}

/* The ray of a place goes to the points that are seen there; a disc of the
 * radius of some degrees has these degrees. */
static void places_have_rays_and_discs_degrees(void **state)
{
    static const double at[3] = {13.5, 26, 31};
    static const double degrees[] = {1e-3, 0.533, 20.0};
    const struct gp_camera c = camera_of(&plain, false, GLAREPP_NDC_AUTO);
    const struct gp_v3 eye = gp_camera_eye(&c);
    const struct gp_v3 to = gp_v3_unit(
        gp_v3_sub((struct gp_v3) {at[0], at[1], at[2]}, eye));
    const struct gp_projected p = gp_camera_project(&c, hd, at, 1.0);
    const struct gp_v3 ray = gp_camera_ray(&c, hd, p.x, p.y);
    near_to("distance", gp_v3_length(gp_v3_sub(
        (struct gp_v3) {at[0], at[1], at[2]}, eye)), p.ray, 1e-9);
    near_to("angle", gp_v3_length(gp_v3_sub(ray, to)), 0.0, 1e-9);
    const double dir[3] = {to.x, to.y, to.z};
    const double back[3] = {-to.x, -to.y, -to.z};
    for (size_t i = 0; i < COUNT(degrees); i++) {
        const double r = gp_camera_disc(&c, hd, dir, degrees[i]);
        near_to("degrees", gp_camera_disc_degrees(&c, hd, dir, r), degrees[i],
                1e-8);
    }
    near_to("behind", gp_camera_disc_degrees(&c, hd, back, 1.0), 0.0, 0.0);
}

/* Units of the camera, where its matrix is known, are those of the depth. */
static void depth_counts_in_camera_units(void **state)
{
    static const double at[3] = {13, 24, 30};
    double m[16], to_camera[16] = {0};
    struct gp_camera c;
    hand_matrix(&plain, false, m);
    for (int i = 0; i < 3; i++)
        to_camera[5 * i] = 0.01; // world in cm, camera in m
    to_camera[15] = 1;
    assert_ok(
        gp_camera_make(&kept_log, "a.exr", to_camera, m, GLAREPP_NDC_AUTO, &c));
    struct gp_projected p = gp_camera_project(&c, hd, at, 1.0);
    near_to("z", p.z, 0.04, 1e-12);
    near_to("ray", p.ray, 0.05, 1e-12);
    near_to("x", p.x, 960 + 1215, 1e-9);
}

/* Without a camera's own matrix, and with it: its y is up. */
static void conventions_are_told_apart(void **state)
{
    static const double upright[16] = {1, 0, 0, 0, 0, 0, 1, 0,
                                       0, 1, 0, 0, 0, 0, 0, 1};
    static const struct {
        double sx, sy; // lens shift
        bool clip, told;
    } row[] = {
        {0, 0, false, true},
        {0, 0, true, true},
        {0.3, -0.3, false, true},
        {5, 5, false, true},
        // the axis at .25, .5 and .5, .25, at .255, .35, .15, .15 and .025, .025
        {-0.25, 0, false, true},
        {0, -0.25, false, true},
        {-0.245, -0.15, false, true},
        {-0.35, -0.35, false, true},
        {-0.475, -0.475, false, true},
        // of tiles, in a corner
        {0.5, -0.5, false, true},
        {-0.5, -0.5, false, false},
        {-0.5, -0.2, false, false},
        // shifted in one direction, and in both
        {0, 0.11, true, true},
        {0.23, 0.005, true, true},
        {0, 0.25, true, false},
        {0.08, -0.08, true, false},
    };
    for (size_t i = 0; i < 2 * COUNT(row); i++) {
        struct hand h = plain;
        static const double dir[3] = {0.1, 1, 0.2};
        const double *const own = i % 2 ? upright : NULL;
        const bool clip = row[i / 2].clip;
        const bool told = own || row[i / 2].told;
        double m[16];
        struct gp_camera c, known;
        h.sx = row[i / 2].sx;
        h.sy = row[i / 2].sy;
        hand_matrix(&h, clip, m);
        assert_ok(gp_camera_make(&kept_log, "a.exr", own, m,
                                 clip ? GLAREPP_NDC_CLIP : GLAREPP_NDC_SPEC,
                                 &known));
        struct gp_projected p = gp_camera_project(&known, hd, dir, 0.0);
        near_to("x", p.x, 1920 * (0.5 + h.sx + 1.5 * 9 / 16 * 0.1), 1e-6);
        near_to("y", p.y, 1080 * (0.5 + h.sy - 1.5 * 0.2), 1e-6);
        if (!told)
            assert_ok(gp_camera_make(&kept_log, "a.exr", own, m,
                                     clip ? GLAREPP_NDC_SPEC : GLAREPP_NDC_CLIP,
                                     &known));
        assert_ok(
            gp_camera_make(&kept_log, "a.exr", own, m, GLAREPP_NDC_AUTO, &c));
        if (memcmp(&c, &known, sizeof c) != 0)
            fail_msg("row %zu: the other convention", i / 2);
    }
}

static void matrices_that_are_none(void **state)
{
    static const struct {
        int at; // entry changed, or -1: all of them
        double to;
        bool fine;
    } row[] = {
        {-1, 0, false}, {-1, 1, false}, {-1, NAN, false}, {-1, DBL_MAX, false},
        {-1, DBL_TRUE_MIN, false}, {14, NAN, false}, {7, INFINITY, false},
        {7, 0, false},     // orthographic
        {7, 1e-12, false}, // but for rounding
        {7, 1e-200, false}, {0, 0, false}, // flat
        {0, 1e-12, false}, {0, 1e300, false}, {12, 1e40, false},
        {13, -DBL_MAX, false}, {12, 1e9, true}, // far from the origin
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        double m[16];
        struct gp_camera c;
        memset(&c, 0x55, sizeof c);
        const struct gp_camera before = c;
        hand_matrix(&plain, false, m);
        for (int k = 0; k < 16; k++)
            m[k] = row[i].at < 0 || row[i].at == k ? row[i].to : m[k];
        gp_status st =
            gp_camera_make(&kept_log, "a.exr", NULL, m, GLAREPP_NDC_SPEC, &c);
        if (st != (row[i].fine ? GP_OK : GP_ERR_DATA))
            fail_msg("row %zu: status %d %s", i, st, kept_line);
        if (st) {
            assert_kept("a.exr: ");
            assert_memory_equal(&c, &before, sizeof c);
        }
    }
    // the camera's, with all entries one number
    static const double all[] = {0, 1, NAN, INFINITY, DBL_MAX, DBL_TRUE_MIN};
    double m[16], to_camera[16];
    struct gp_camera c;
    hand_matrix(&plain, false, m);
    for (size_t i = 0; i < COUNT(all); i++) {
        for (int k = 0; k < 16; k++)
            to_camera[k] = all[i];
        assert_int_equal(gp_camera_make(&kept_log, "a.exr", to_camera, m,
                                        GLAREPP_NDC_AUTO, &c),
                         GP_ERR_DATA);
        assert_kept("a.exr: ");
    }
}

/* The half-axes' mean from the cone's own outline, which is an ellipse: by the
 * area that many of its points enclose. */
static double traced_radius(const struct gp_camera *c, const double dir[3],
                            double degrees)
{
    enum { POINTS = 20000 };
    const double l = sqrt(dir[0] * dir[0] + dir[1] * dir[1] + dir[2] * dir[2]);
    const double d[3] = {dir[0] / l, dir[1] / l, dir[2] / l};
    // two directions across: any that is not d, made square to it
    const double k = sqrt(d[0] * d[0] + d[1] * d[1]);
    const double u[3] = {d[1] / k, -d[0] / k, 0.0};
    const double v[3] = {u[1] * d[2], -u[0] * d[2], u[0] * d[1] - u[1] * d[0]};
    const double t = tan(degrees * M_PI / 360.0);
    const struct gp_projected middle = gp_camera_project(c, hd, d, 0.0);
    double area = 0.0, x0 = 0.0, y0 = 0.0;
    for (int i = 0; i <= POINTS; i++) {
        const double a = 2.0 * M_PI * i / POINTS;
        double at[3];
        for (int j = 0; j < 3; j++)
            at[j] = d[j] + t * (cos(a) * u[j] + sin(a) * v[j]);
        struct gp_projected p = gp_camera_project(c, hd, at, 0.0);
        assert_false(p.behind);
        p.x -= middle.x;
        p.y -= middle.y;
        if (i)
            area += 0.5 * (x0 * p.y - p.x * y0);
        x0 = p.x;
        y0 = p.y;
    }
    return sqrt(fabs(area) / M_PI);
}

static void discs_cover_what_their_cones_cut(void **state)
{
    static const double dirs[][3] = {
        {0, 1, 0}, {0.1, 1, 0.05}, {0.6, 2, -0.9}, {3, 1, 0}, {-9, 1, 4},
    };
    static const double degrees[] = {1e-3, 0.533, 5, 11};
    struct hand h = plain;
    h.sx = 0.1;
    const struct gp_camera c = camera_of(&h, true, GLAREPP_NDC_CLIP);
    for (size_t i = 0; i < COUNT(dirs); i++) {
        for (size_t k = 0; k < COUNT(degrees); k++) {
            const double want = traced_radius(&c, dirs[i], degrees[k]);
            near_to("radius", gp_camera_disc(&c, hd, dirs[i], degrees[k]),
                    want, 1e-6 * want);
        }
    }
}

static void discs_that_are_none(void **state)
{
    static const struct {
        double dir[3], degrees;
    } row[] = {
        {{0, -1, 0}, 1}, {{1, 0, 0}, 1}, {{0, 0, 0}, 1}, {{NAN, 1, 0}, 1},
        {{0, 1, 0}, 0}, {{0, 1, 0}, -1}, {{0, 1, 0}, NAN}, {{0, 1, 0}, 180},
        {{0, 1, 0}, 1e300}, {{0, INFINITY, 0}, 1},
        {{1, 0.005, 0}, 1},   // its edge is beside the camera
        {{1, 1, 0}, 91},
    };
    const struct gp_camera c = camera_of(&plain, false, GLAREPP_NDC_SPEC);
    for (size_t i = 0; i < COUNT(row); i++)
        near_to("radius", gp_camera_disc(&c, hd, row[i].dir, row[i].degrees),
                0.0, 0.0);
    static const double ahead[3] = {0, 1, 0};
    near_to("half of all", gp_camera_disc(&c, hd, ahead, 179.9999999), 1e6, 0);
    near_to("no window",
            gp_camera_disc(&c, (struct gp_rect) {5, 5, 5, 5}, ahead, 1), 0, 0);
}

// looks along +y, z up; the same camera in both forms
#define SPEC "'worldToNDC_rowmajor': " \
    "[1,0,0,0, 0.5,0.5,1,1, 0,-2,0,0, 0,0,-0.1,0]"
#define CLIP "'worldToNDC_blender_colvec': " \
    "[2,0,0,0, 0,0,4,0, 0,1,0,-0.1, 0,1,0,0]"
#define UNIT "'worldToCamera_rowmajor': [1,0,0,0, 0,0,1,0, 0,1,0,0, 0,0,0,1]"
#define NONE "[0,0,0,0, 0,0,0,0, 0,0,0,0, 0,0,0,0]"
#define NINE "[{'frame': 9, "

static void files_by_content(void **state)
{
    static const struct {
        const char *text;
        int frames; // 0: an error
    } row[] = {
        {"{'frames': [{'frame': 1, " SPEC "}]}", 1},
        {"[{'frame': 1, " SPEC "}]", 1},
        {"{'x': 1, 'frames': [{'frame': 1, " CLIP ", 'y': null}]}", 1},
        {"[{'frame': 5, " SPEC "}, {'frame': -3, " CLIP "}]", 2},
        {NINE SPEC ", 'worldToNDC_blender_colvec': " NONE "}]", 1},
        {NINE UNIT ", " CLIP ", 'sun_dir_world': [0,1,0.1], "
         "'sun_radius_px': 2.5}]", 1},
        {"{}", 0}, {"[]", 0}, {"{'frames': []}", 0}, {"{'frames': 3}", 0},
        {"[3]", 0}, {"[{" SPEC "}]", 0}, {"[{'frame': 1.5, " SPEC "}]", 0},
        {"[{'frame': 1e17, " SPEC "}]", 0}, {"[{'frame': '1', " SPEC "}]", 0},
        {"[{'frame': 9}]", 0}, {NINE UNIT "}]", 0},
        {NINE "'worldToNDC_rowmajor': [1, 2]}]", 0},
        {NINE "'worldToNDC_rowmajor': [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,0,0,1]}]",
         0},
        {NINE SPEC ", 'worldToCamera_rowmajor': " NONE "}]", 0},
        {NINE SPEC ", 'worldToCamera_rowmajor': null}]", 0},
        {"[{'frame': 7, " SPEC "}, {'frame': 8, " SPEC "}, {'frame': 7, "
         SPEC "}]", 0},
        {NINE SPEC ", 'sun_dir_world': [0,0,0]}]", 0},
        {NINE SPEC ", 'sun_dir_world': [0,1]}]", 0},
        {NINE SPEC ", 'sun_radius_px': -1}]", 0},
        {NINE SPEC ", 'frame': 9}]", 0}, {"", 0},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_camera_file f = {0};
        gp_status st = gp_camera_read(&kept_log, jf_write(row[i].text), &f);
        if (st != (row[i].frames ? GP_OK : GP_ERR_DATA) || f.n != row[i].frames)
            fail_msg("row %zu: status %d, %d frames, %s", i, st, f.n,
                     kept_line);
        if (st)
            assert_ptr_equal(strstr(kept_line, path), kept_line);
        gp_camera_file_free(&f);
        gp_camera_file_free(&f);
    }
}

static void both_forms_are_one_camera(void **state)
{
    struct gp_camera_file f;
    assert_ok(gp_camera_read(&kept_log, jf_write("[{'frame': 2, " SPEC "}, "
                                         "{'frame': 1, " CLIP ", " UNIT ", "
                                         "'sun_dir_world': [0, 3, 1]}]"),
                       &f));
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
    static char text[1 << 20];
    struct gp_camera_file f;
    int n = 0;
    // 37 and 100 have no common factor: every number once, in no order
    for (int i = 0; i < 100; i++)
        n += snprintf(text + n, sizeof text - (size_t) n,
                      "%s{'frame': %d, " SPEC ", 'sun_radius_px': %d}",
                      i ? ", " : "[", i * 37 % 100 - 50, i * 37 % 100);
    snprintf(text + n, sizeof text - (size_t) n, "]");
    assert_ok(gp_camera_read(&kept_log, jf_write(text), &f));
    assert_int_equal(f.n, 100);
    for (int i = -60; i < 60; i++) {
        const struct gp_camera_frame *at = gp_camera_frame_find(&f, i);
        assert_int_equal(at != NULL, i >= -50 && i < 50);
        assert_true(!at || (at->frame == i && at->sun_radius == i + 50));
    }
    gp_camera_file_free(&f);
    assert_null(gp_camera_frame_find(&f, 0));
    // a lone camera is every frame's
    assert_ok(gp_camera_read(&kept_log,
                     jf_write("[{'frame': 9, " SPEC "}]"), &f));
    assert_non_null(gp_camera_frame_find(&f, 1234));
    gp_camera_file_free(&f);
}

/* A long sequence is more than the other files may be, but not without end. */
static void large_files_have_an_end(void **state)
{
    static const char frame[] = "[{'frame': 9, " SPEC "}";
    static const struct {
        size_t bytes;
        gp_status st;
    } row[] = {
        {2 << 20, GP_OK}, {8 << 20, GP_OK}, {(8 << 20) + 1, GP_ERR_DATA},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        char *text = malloc(row[i].bytes + 1);
        struct gp_camera_file f = {0};
        assert_non_null(text);
        memset(text, ' ', row[i].bytes);
        memcpy(text, frame, sizeof frame - 1);
        text[row[i].bytes - 1] = ']';
        text[row[i].bytes] = '\0';
        assert_int_equal(gp_camera_read(&kept_log, jf_write(text), &f),
                         row[i].st);
        free(text);
        gp_camera_file_free(&f);
    }
    struct gp_camera_file f;
    assert_int_equal(gp_camera_read(&kept_log, folder, &f), GP_ERR_IO);
    assert_int_equal(gp_camera_read(&kept_log, "/nowhere", &f), GP_ERR_IO);
}

// -- the data's frames -------------------------------------------------------

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

/* From a frame's own header; `projection` names its matrix. */
static struct gp_camera header_camera(const char *name, const char *projection,
                                      enum glarepp_ndc form,
                                      struct gp_rect *display)
{
    static const struct gp_read_params params = GP_READ_DEFAULTS;
    struct gp_frame f;
    struct gp_camera c;
    double camera[16], ndc[16];
    if (gp_read_frame(&kept_log, &params, data_path(name), &f))
        fail_msg("%s", kept_line);
    assert_true(gp_frame_numbers(&f, "worldToCamera", 16, camera));
    assert_true(gp_frame_numbers(&f, projection, 16, ndc));
    if (gp_camera_make(&kept_log, name, camera, ndc, form, &c))
        fail_msg("%s", kept_line);
    *display = f.display;
    gp_frame_free(&f);
    return c;
}

static void suns_and_lamps_of_the_data(void **state)
{
    static const char *const names[] = {
        "seq_foliage/foliage", "seq_foliage/foliage_f32", "rendered/window",
        "rendered/brightsky", "rendered/night",
    };
    int suns = 0, outside = 0;
    for (size_t i = 0; i < COUNT(names); i++) {
        char path[256];
        struct gp_camera_file file;
        json_t *frame;
        size_t k;
        snprintf(path, sizeof path, "%s.camera.json", names[i]);
        json_t *const truth = json_load_file(data_path(path), 0, NULL);
        if (!truth)
            skip_for(NO_DATA);
        if (gp_camera_read(&kept_log, data_path(path), &file))
            fail_msg("%s", kept_line);
        json_array_foreach (json_object_get(truth, "frames"), k, frame) {
            const int number =
                (int) json_integer_value(json_object_get(frame, "frame"));
            struct gp_rect display;
            snprintf(path, sizeof path, "%s.%d.exr", names[i], number);
            const struct gp_camera header =
                header_camera(path, "worldToNDC", GLAREPP_NDC_AUTO, &display);
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
    static const struct {
        const char *file, *matrix;
    } row[] = {
        {"camera/arnold_multichannel_tiled64.exr", "worldToNDC"},
        {"camera/arnold_reference_worldToScreen.exr", "worldToScreen"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_rect display;
        if (access(data_path(row[i].file), R_OK) != 0)
            skip_for(NO_DATA);
        const struct gp_camera c = header_camera(row[i].file, row[i].matrix,
                                                 GLAREPP_NDC_AUTO, &display);
        const struct gp_camera clip = header_camera(row[i].file, row[i].matrix,
                                                    GLAREPP_NDC_CLIP, &display);
        const double *const camera = c.to_camera;
        assert_memory_equal(c.to_ndc, clip.to_ndc, sizeof c.to_ndc);
        // points above the camera's axis are higher in the picture
        const double up[3] = {camera[2] + 0.1 * camera[1],
                              camera[6] + 0.1 * camera[5],
                              camera[10] + 0.1 * camera[9]};
        const double back[3] = {0.2 * camera[1] - up[0],
                                0.2 * camera[5] - up[1],
                                0.2 * camera[9] - up[2]};
        struct gp_projected p = gp_camera_project(&c, display, up, 0.0);
        if (p.behind) // its z may count backwards
            p = gp_camera_project(&c, display, back, 0.0);
        assert_false(p.behind);
        near_to("x", p.x, 0.5 * display.x1, 1e-3);
        assert_true(p.y < 0.49 * display.y1 && p.y > 0.0);
    }
}

SUITE_OF(camera, make_folder, remove_folder, places_of_a_hand_made_camera,
         windows_move_and_scale, places_have_rays_and_discs_degrees,
         depth_counts_in_camera_units, conventions_are_told_apart,
         matrices_that_are_none, discs_cover_what_their_cones_cut,
         discs_that_are_none, files_by_content, both_forms_are_one_camera,
         frames_are_found_by_number, large_files_have_an_end,
         suns_and_lamps_of_the_data, arnold_is_told_from_the_spec)
