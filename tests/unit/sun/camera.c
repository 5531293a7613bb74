/* sun/camera: matrices by hand, places and discs under them. */
#include "unit.h"
#include "json_file.h"
#include "sun/camera.h"

#include <float.h>

static const double PI = 3.14159265358979323846;
static const struct gp_rect hd = {0, 0, 1920, 1080};

static void near_to(const char *what, double got, double want, double within)
{
    if (!(fabs(got - want) <= within))
        fail_msg("%s: %.12g is not %.12g within %g", what, got, want, within);
}

/* -- a camera by hand ----------------------------------------------------- */

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

static const struct hand plain = {1.5, 0, 0, {10, 20, 30}, 1};

static void places_of_a_hand_made_camera(void **state)
{
    (void) state;
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
        {{0, -1, 0}, 0, 0, 0, 0, 0, true},
        {{1, 0, 0}, 0, 0, 0, 0, 0, true},
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
        double m[16];
        struct gp_camera c;
        h.scale = form & 2 ? 1e-200 : 1.0; // of a projection says nothing
        hand_matrix(&h, form & 1, m);
        if (gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_AUTO, &c))
            fail_msg("%s", jf_line);
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
    (void) state;
    static const struct gp_rect rows[] = {
        {0, 0, 1, 1}, {-500, 300, 1420, 1380}, {7, -9, 8, 1000},
        {INT32_MIN / 4, INT32_MIN / 4, INT32_MAX / 4, INT32_MAX / 4},
        {5, 5, 5, 5},
    };
    static const double dir[3] = {0.2, 1, 0.3};
    double m[16];
    struct gp_camera c;
    hand_matrix(&plain, false, m);
    assert_int_equal(
        gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_AUTO, &c), GP_OK);
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_rect r = rows[i];
        struct gp_projected p = gp_camera_project(&c, r, dir, 0.0);
        const double w = (double) r.x1 - r.x0, h = (double) r.y1 - r.y0;
        near_to("x", p.x, r.x0 + w * (0.5 + 1.5 * 9 / 16 * 0.2), 1e-6);
        near_to("y", p.y, r.y0 + h * (0.5 - 1.5 * 0.3), 1e-6);
    }
}

/* Units of the camera, where its matrix is known, are those of the depth. */
static void depth_counts_in_camera_units(void **state)
{
    (void) state;
    static const double at[3] = {13, 24, 30};
    double m[16], to_camera[16] = {0};
    struct gp_camera c;
    hand_matrix(&plain, false, m);
    for (int i = 0; i < 3; i++)
        to_camera[5 * i] = 0.01; // world in cm, camera in m
    to_camera[15] = 1;
    assert_int_equal(
        gp_camera_make(&jf_log, "a.exr", to_camera, m, GP_NDC_AUTO, &c),
        GP_OK);
    struct gp_projected p = gp_camera_project(&c, hd, at, 1.0);
    near_to("z", p.z, 0.04, 1e-12);
    near_to("ray", p.ray, 0.05, 1e-12);
    near_to("x", p.x, 960 + 1215, 1e-9);
}

static void conventions_are_told_apart(void **state)
{
    (void) state;
    static const struct {
        double sx, sy; // lens shift
        bool clip, told;
    } row[] = {
        {0, 0, false, true},       {0, 0, true, true},
        {0.15, -0.15, false, true}, {0.08, -0.08, true, true},
        {0.19, 0, false, true},    {0, 0.095, true, true},
        {0.21, 0, false, false},   {0, 0.3, false, false},
        {0, 0.11, true, false},    {5, 5, false, false},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct hand h = plain;
        static const double dir[3] = {0.1, 1, 0.2};
        double m[16];
        struct gp_camera c, known;
        h.sx = row[i].sx;
        h.sy = row[i].sy;
        hand_matrix(&h, row[i].clip, m);
        gp_status st =
            gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_AUTO, &c);
        if (st != (row[i].told ? GP_OK : GP_ERR_DATA))
            fail_msg("row %zu: status %d", i, st);
        if (!row[i].told)
            assert_non_null(strstr(jf_line, "--ndc"));
        assert_int_equal(
            gp_camera_make(&jf_log, "a.exr", NULL, m,
                           row[i].clip ? GP_NDC_CLIP : GP_NDC_SPEC, &known),
            GP_OK);
        struct gp_projected p = gp_camera_project(&known, hd, dir, 0.0);
        near_to("x", p.x, 1920 * (0.5 + h.sx + 1.5 * 9 / 16 * 0.1), 1e-6);
        near_to("y", p.y, 1080 * (0.5 + h.sy - 1.5 * 0.2), 1e-6);
        if (row[i].told)
            assert_memory_equal(&c, &known, sizeof c);
    }
}

static void matrices_that_are_none(void **state)
{
    (void) state;
    static const struct {
        int at; // entry changed, or -1: all of them
        double to;
        const char *say; // NULL: fine
    } row[] = {
        {-1, 0, "no view axis"},
        {-1, 1, "singular"},
        {-1, NAN, "worldToNDC is no matrix (row 0, column 0 is NaN)"},
        {-1, DBL_MAX, "singular"},
        {-1, DBL_TRUE_MIN, "singular"},
        {14, NAN, "row 3, column 2 is NaN"},
        {7, INFINITY, "row 1, column 3 is Inf"},
        {7, 0, "no view axis"},      // orthographic
        {7, 1e-12, "no view axis"},  // but for rounding
        {7, 1e-200, "no view axis"},
        {0, 0, "singular"},          // flat
        {0, 1e-12, "singular"},
        {0, 1e300, "no view axis"},
        {12, 1e40, "no view axis"},
        {13, -DBL_MAX, "no view axis"},
        {12, 1e9, NULL},             // far from the origin
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
            gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_SPEC, &c);
        if (st != (row[i].say ? GP_ERR_DATA : GP_OK))
            fail_msg("row %zu: status %d %s", i, st, jf_line);
        if (row[i].say) {
            if (!strstr(jf_line, row[i].say) || !strstr(jf_line, "a.exr: "))
                fail_msg("row %zu: %s", i, jf_line);
            assert_memory_equal(&c, &before, sizeof c);
        }
    }
}

static void cameras_that_are_none(void **state)
{
    (void) state;
    static const double all[] = {0, 1, NAN, INFINITY, DBL_MAX, DBL_TRUE_MIN};
    double m[16];
    hand_matrix(&plain, false, m);
    for (size_t i = 0; i < COUNT(all); i++) {
        double to_camera[16];
        struct gp_camera c;
        for (int k = 0; k < 16; k++)
            to_camera[k] = all[i];
        assert_int_equal(gp_camera_make(&jf_log, "a.exr", to_camera, m,
                                        GP_NDC_AUTO, &c), GP_ERR_DATA);
        assert_non_null(strstr(jf_line, "a.exr: worldToCamera"));
    }
}

/* -- discs ----------------------------------------------------------------- */

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
    const double t = tan(degrees * PI / 360.0);
    const struct gp_projected middle = gp_camera_project(c, hd, d, 0.0);
    double area = 0.0, x0 = 0.0, y0 = 0.0;
    for (int i = 0; i <= POINTS; i++) {
        const double a = 2.0 * PI * i / POINTS;
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
    return sqrt(fabs(area) / PI);
}

static void discs_cover_what_their_cones_cut(void **state)
{
    (void) state;
    static const double dirs[][3] = {
        {0, 1, 0}, {0.1, 1, 0.05}, {0.6, 2, -0.9}, {3, 1, 0}, {-9, 1, 4},
    };
    static const double degrees[] = {1e-3, 0.533, 5, 11};
    struct hand h = plain;
    double m[16];
    struct gp_camera c;
    h.sx = 0.1;
    hand_matrix(&h, true, m);
    assert_int_equal(
        gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_CLIP, &c), GP_OK);
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
    (void) state;
    static const struct {
        double dir[3], degrees;
    } row[] = {
        {{0, -1, 0}, 1}, {{1, 0, 0}, 1}, {{0, 0, 0}, 1}, {{NAN, 1, 0}, 1},
        {{0, 1, 0}, 0}, {{0, 1, 0}, -1}, {{0, 1, 0}, NAN}, {{0, 1, 0}, 180},
        {{0, 1, 0}, 1e300}, {{0, INFINITY, 0}, 1},
        {{1, 0.005, 0}, 1},   // its edge is beside the camera
        {{1, 1, 0}, 91},
    };
    double m[16];
    struct gp_camera c;
    hand_matrix(&plain, false, m);
    assert_int_equal(
        gp_camera_make(&jf_log, "a.exr", NULL, m, GP_NDC_SPEC, &c), GP_OK);
    for (size_t i = 0; i < COUNT(row); i++)
        near_to("radius", gp_camera_disc(&c, hd, row[i].dir, row[i].degrees),
                0.0, 0.0);
    static const double ahead[3] = {0, 1, 0};
    near_to("half of all", gp_camera_disc(&c, hd, ahead, 179.9999999), 1e6, 0);
    near_to("no window",
            gp_camera_disc(&c, (struct gp_rect) {5, 5, 5, 5}, ahead, 1), 0, 0);
}

SUITE_OF(camera, jf_setup, jf_teardown,
    places_of_a_hand_made_camera, windows_move_and_scale,
    depth_counts_in_camera_units, conventions_are_told_apart,
    matrices_that_are_none, cameras_that_are_none,
    discs_cover_what_their_cones_cut, discs_that_are_none)
