// SPDX-License-Identifier: Apache-2.0
/* lens: prescriptions are read strictly; first order agrees with traced rays,
 * and light with closed forms; no more light leaves than enters. */
#include "json_file.h"
#include "scene.h"
#include "sun/lens_priv.h"

static const char *const installed[] = {
    "heliar", "double-gauss", "tessar", "telephoto", "zoom-wide", "zoom-tele"};

static struct gp_lens installed_lens(const char *name)
{
    struct gp_lens lens = {0};
    if (gp_lens_read(&kept_log, name, &lens))
        fail_msg("%s", kept_line);
    assert_ok(gp_lens_focus(&kept_log, &lens, INFINITY, 0.0));
    return lens;
}

static struct gp_lens lens_of(const char *text)
{
    struct gp_lens lens = {0};
    assert_ok(gp_lens_read(&kept_log, jf_write(text), &lens));
    return lens;
}

// -- files --------------------------------------------------------------------

#define SINGLET "{'radius': 50, 'thickness': 4, 'n': 1.5, 'v': 60, 'semi': 9}"
#define BACK "{'radius': -50, 'thickness': 3, 'semi': 9}"
#define STOP "{'stop': true, 'semi': 5}"

static void reads_lenses(void **state)
{
    const struct gp_lens lens = lens_of(
        "{'name': 'one', 'patent': 'none', 'blades': 6, 'blade_turn': 10,"
        " 'coating': 520, 'claims': {'focal_length': 51},"
        " 'surfaces': [" SINGLET "," BACK "," STOP "]}");
    assert_int_equal(lens.n, 3);
    assert_int_equal(lens.stop, 2);
    assert_int_equal(lens.says.blades, 6);
    assert_true(lens.at[0].curvature == 0.02 && lens.at[1].curvature == -0.02);
    assert_true(lens.at[0].coat == 520.0 && lens.at[1].coat == 520.0);
    assert_true(lens.at[1].n == 1.0 && lens.at[2].coat == 0.0);
    assert_true(lens.says.claims_focal == 51.0 && lens.says.claims_back == 0.0);
}

#define TABLE "{'name': 'a', 'coating': 'c', 'coatings': ["
#define FACES "], 'surfaces': [" SINGLET "," BACK "," STOP "]}"

/* A coat by a table: between its numbers, before and after them, and from both
 * sides. */
static void reads_tables(void **state)
{
    const struct gp_lens lens = lens_of(
        TABLE
        "{'name': 'b', 'nm': [1e3, 2e3], 'degrees': [0, 9],"
        " 'reflectance': [1, 1, 1, 1]}, {'name': 'c', 'nm': [400, 500, 700],"
        " 'degrees': [0, 30, 60], 'reflectance': [0.1, 0.2, 0.3, 0.2, 0.4, 0.5,"
        " 0, 0, 0]}" FACES);
    const double c15 = cos(acos(-1.0) / 12.0);
    assert_true(lens.coats == 2 && lens.at[0].coat == -2.0);
    assert_true(lens.at[1].coat == -2.0 && lens.at[2].coat == 0.0);
    assert_near(gp_lens_reflected(&lens, 0, 1.0, 400.0), 0.1, 1e-12, "at", 0);
    assert_near(gp_lens_reflected(&lens, 1, c15, 450.0), 0.225, 1e-9, "in", 1);
    assert_near(gp_lens_reflected(&lens, 0, 0.5, 300.0), 0.3, 1e-9, "low", 2);
    assert_near(gp_lens_reflected(&lens, 0, 1.0, 900.0), 0.0, 0.0, "high", 3);
    assert_near(gp_lens_reflected(&lens, 0, cos(acos(-1.0) / 2.4), 400.0), 0.65,
                1e-9, "half of what 60 degrees leave to 90", 4);
}

static void refuses_lenses(void **state)
{
    static const char *const rows[] = {
        "[]",
        "{}",
        "{'name': 'a'}",
        "{'name': 'a', 'surfaces': []}",
        "{'name': 'a', 'surfaces': [" SINGLET "," BACK "]}",
        "{'name': 'a', 'surfaces': [" STOP ", 3]}",
        "{'name': 'a', 'surfaces': [" STOP "," STOP "]}",
        "{'name': 'a', 'surfaces': [" BACK "," SINGLET "," STOP "]}",
        "{'name': 'a', 'surfaces': [" SINGLET "," STOP "]}",
        "{'name': 'a', 'glass': 1, 'surfaces': [" STOP "]}",
        "{'name': 'a', 'blades': 2, 'surfaces': [" STOP "]}",
        "{'name': 'a', 'blades': 33, 'surfaces': [" STOP "]}",
        "{'name': 'a', 'claims': {'f': 1}, 'surfaces': [" STOP "]}",
        "{'name': 'a', 'surfaces': [{'stop': false, 'semi': 1}]}",
        "{'name': 'a', 'surfaces': [{'stop': true, 'n': 1, 'semi': 1}]}",
        "{'name': 'a', 'surfaces': [{'stop': true}]}",
        "{'name': 'a', 'surfaces': [{'semi': 1}," STOP "]}",
        "{'name': 'a', 'surfaces': [{'semi': 1, 'thickness': 0}," STOP "]}",
        "{'name': 'a', 'surfaces': [{'semi': 2, 'radius': 1.9,"
        " 'thickness': 1}," STOP "]}",
        "{'name': 'a', 'surfaces': [{'semi': 1, 'thickness': 1, 'n': 0.5}," STOP
        "]}",
        "{'name': 'a', 'surfaces': [{'semi': 1, 'thickness': 1, 'n': 1.5,"
        " 'v': 5}," STOP "]}",
        "{'name': 'a', 'surfaces': [{'semi': 1e9, 'thickness': 1}," STOP "]}",
        TABLE FACES, // no such coat
        TABLE "3" FACES,
        TABLE "{'name': 'c', 'nm': [1e3, 2e3], 'degrees': [0, 9]}" FACES,
        TABLE "{'nm': [1e3, 2e3], 'degrees': [0, 9], 'reflectance': [0, 0, 0,"
              " 0]}" FACES,
        TABLE "{'name': 'c', 'nm': [1e3, 2e3], 'degrees': [0, 9],"
              " 'reflectance': [0, 0, 0]}" FACES,
        TABLE "{'name': 'c', 'nm': [1e3, 2e3], 'degrees': [0, 9],"
              " 'reflectance': [0, 0, 0, 1.1]}" FACES,
        TABLE "{'name': 'c', 'nm': [2e3, 1e3], 'degrees': [0, 9],"
              " 'reflectance': [0, 0, 0, 0]}" FACES,
        TABLE "{'name': 'c', 'nm': [1e3], 'degrees': [0, 9],"
              " 'reflectance': [0, 0]}" FACES,
        TABLE "{'name': 'c', 'nm': [1e3, 2e3], 'degrees': [0, 90],"
              " 'reflectance': [0, 0, 0, 0]}" FACES,
    };
    char many[8192] = "{'name': 'a', 'surfaces': [";
    for (size_t i = 0; i <= COUNT(rows); i++) {
        struct gp_lens lens = {.n = -7};
        if (i == COUNT(rows)) { // more surfaces than there is room for
            for (int k = 0; k < 65; k++)
                strcat(many, "{'semi': 1, 'thickness': 1},");
            strcat(many, STOP "]}");
        }
        assert_int_equal(gp_lens_read(&kept_log, jf_write(i < COUNT(rows)
                                                              ? rows[i] : many),
                                      &lens), GP_ERR_DATA);
        assert_int_equal(lens.n, -7);
        assert_kept(path);
    }
    struct gp_lens lens;
    assert_int_equal(gp_lens_read(&kept_log, jf_write(
        "{'name': 'a', 'surfaces': [{'semi': 1, 'radius': 0,"
        " 'thickness': 1}," STOP "]}"), &lens), GP_ERR_DATA);
    assert_kept("surface 1: ");
    kept_clear();
    assert_int_equal(gp_lens_read(&kept_log, "./none.json", &lens), GP_ERR_IO);
    kept_clear();
    assert_int_equal(gp_lens_read(&kept_log, "nosuchlens", &lens), GP_ERR_IO);
    assert_kept("nosuchlens");
}

/* The claims of the files are the figures of their surfaces. */
static void meets_claims(void **state)
{
    for (size_t i = 0; i < COUNT(installed); i++) {
        const struct gp_lens lens = installed_lens(installed[i]);
        struct glarepp_lens f;
        gp_lens_measure(&lens, &f);
        assert_near(f.focal, lens.says.claims_focal, 0.01 * f.focal,
                    installed[i], 0);
        assert_near(f.f_number, lens.says.claims_f_number, 0.01 * f.f_number,
                    installed[i], 1);
        if (lens.says.claims_back > 0.0)
            assert_near(f.back, lens.says.claims_back, 0.002 * f.back,
                        installed[i], 2);
        assert_true(f.through > 0.5 && f.through < 1.0);
    }
}

// -- first order against rays -------------------------------------------------

/* Pixels of 1920 over 84 mm, the Heliar's own format. */
static const double pixel = 84.0 / 1920;

/* The middle of each ghost, by a ray at the middle of its pupil, for small
 * slopes. */
static void middles_agree(void **state)
{
    const struct gp_lens lens = installed_lens("heliar");
    struct glarepp_ghost ghost[GP_LENS_GHOSTS];
    struct gp_lens_optics o;
    gp_lens_optics_make(&lens, GP_D_LINE, &o);
    const int n = gp_lens_ghosts(&lens, GP_D_LINE, ghost, NULL);
    assert_int_equal(n, 28);
    for (int i = 0; i < n; i++) {
        struct gp_lens_path path;
        const double u = 0.002;
        gp_lens_path(&lens, ghost[i].first, ghost[i].second, &path);
        // as near the axis as aberrations of third order are under the bar
        const double x = ghost[i].shift * u;
        const struct gp_lens_hit h = gp_lens_trace(&o, &path, x, 0.0, u, NULL);
        assert_true(h.through >= 0.0f);
        assert_near(h.x, ghost[i].a * x + ghost[i].b * u, 0.1 * pixel,
                    "middle of ghost", i);
        assert_near(h.y, 0.0, 1e-9, "its height", i);
        // the share of light on the axis
        const struct gp_lens_hit axis = gp_lens_trace(&o, &path, 0, 0, 0, NULL);
        assert_near((double) axis.through / ghost[i].through, 1.0, 1e-4,
                    "light of ghost", i);
    }
}

/* The image of a light: slope times focal length. */
static void images_land(void **state)
{
    for (size_t i = 0; i < COUNT(installed); i++) {
        const struct gp_lens lens = installed_lens(installed[i]);
        struct gp_lens_path path;
        struct gp_lens_optics o;
        struct glarepp_lens f;
        gp_lens_measure(&lens, &f);
        gp_lens_optics_make(&lens, GP_D_LINE, &o);
        gp_lens_path(&lens, -1, -1, &path);
        const struct gp_lens_matrix m =
            gp_lens_matrix(&lens, &path, lens.stop + 1, GP_D_LINE);
        const struct gp_lens_hit h = gp_lens_trace(
            &o, &path, -m.b / m.a * 0.01, 0.0, 0.01, NULL);
        assert_near(h.x, 0.01 * f.focal, 1e-4 * f.focal, installed[i], 0);
    }
}

// -- light in closed form -----------------------------------------------------

/* Light that arrives on a path, in mm^2, by a mesh at the d line, as exact as
 * `tolerance`. */
static double mesh_light_within(double tolerance, const struct gp_lens *lens,
                                int first, int second, double u)
{
    struct gp_lens_optics o[GP_LENS_NODES];
    struct gp_lens_path path;
    struct gp_lens_mesh m;
    const struct gp_lens_blades blades = gp_lens_blades_of(lens, 0.0);
    for (int k = 0; k < GP_LENS_NODES; k++)
        gp_lens_optics_make(lens, GP_D_LINE, &o[k]);
    gp_lens_path(lens, first, second, &path);
    assert_ok(gp_lens_mesh_make(&kept_log, o, &path, &blades, u, tolerance,
                                0.0, &m));
    const double light = m.flux[1];
    gp_lens_mesh_free(&m);
    return light;
}

static double mesh_light(const struct gp_lens *lens, int first, int second,
                         double u)
{
    return mesh_light_within(1e-4, lens, first, second, u);
}

/* The share of light that a bare plate's ghost keeps. */
static double plate_share(double n, double cosine)
{
    const double inside = sqrt(1.0 - (1.0 - cosine * cosine) / (n * n));
    const double rs = (cosine - n * inside) / (cosine + n * inside);
    const double rp = (n * cosine - inside) / (n * cosine + inside);
    const double r = 0.5 * (rs * rs + rp * rp);
    return (1.0 - r) * (1.0 - r) * r * r;
}

/* A plate before the stop: two faces, one ghost that goes straight on. Its rays
 * keep their direction, so that all of the stop's area arrives at a slant, with
 * Fresnel's factors at one angle. */
static void plate_in_closed_form(void **state)
{
    const double pi = acos(-1.0), n = 1.5;
    const struct gp_lens lens = lens_of(
        "{'name': 'plate', 'surfaces': [{'thickness': 3, 'n': 1.5, 'semi': 60},"
        "{'thickness': 10, 'semi': 60},{'stop': true, 'semi': 4}]}");
    for (int i = 0; i < 4; i++) {
        const double u = 0.3 * i, cosine = 1.0 / sqrt(1.0 + u * u);
        const double want = pi * 16.0 * cosine * plate_share(n, cosine);
        assert_near(mesh_light(&lens, 1, 0, u) / want, 1.0, 1e-3, "plate", u);
    }
}

/* A mirror that is a sphere turns light along the axis back up to R / sqrt 2 from
 * it; rays that meet it farther out go on, and make no ghost. */
static void rays_that_are_not_turned_back_make_no_ghost(void **state)
{
    static const char *const texts[] = {
        "{'name': 'ball', 'surfaces': [{'stop': true, 'semi': 12, 'thickness':"
        "1}, {'thickness': 2, 'n': 1.5, 'semi': 60}, {'radius': 10,"
        "'thickness': 20, 'n': 1.55, 'semi': 9.9}, {'semi': 60}]}",
        "{'name': 'bowl', 'surfaces': [{'stop': true, 'semi': 12, 'thickness':"
        "1}, {'thickness': 8, 'n': 1.5, 'semi': 60}, {'radius': -10,"
        "'thickness': 20, 'n': 1.55, 'semi': 9.9}, {'semi': 60}]}",
    };
    int arrived = 0;
    for (size_t i = 0; i < COUNT(texts); i++) {
        const struct gp_lens lens = lens_of(texts[i]);
        struct gp_lens_optics o;
        struct gp_lens_path path;
        gp_lens_optics_make(&lens, GP_D_LINE, &o);
        gp_lens_path(&lens, 2, 1, &path);
        for (int k = 1; k < 99; k++) {
            const double x = 0.1 * k;
            const struct gp_lens_hit h =
                gp_lens_trace(&o, &path, x, 0.0, 0.0, NULL);
            arrived += h.through >= 0.0f;
            if (h.through >= 0.0f && x > 10.0 * sqrt(0.5))
                fail_msg("%s: a ray at %g arrives", lens.says.name, x);
        }
    }
    assert_true(arrived > 20);
}

/* A thin lens behind the stop: all of the stop's disc reaches the sensor, with
 * Fresnel's factors of normal incidence. */
static void thin_lens_in_closed_form(void **state)
{
    const double pi = acos(-1.0), r = 0.04;
    const struct gp_lens lens = lens_of(
        "{'name': 'thin', 'surfaces': [{'stop': true, 'semi': 2,"
        "'thickness': 0.01}, {'radius': 400, 'thickness': 0.01, 'n': 1.5,"
        "'semi': 20},{'radius': -400, 'semi': 20}]}");
    assert_near(mesh_light(&lens, 2, 1, 0.0) /
                    (pi * 4.0 * (1.0 - r) * (1.0 - r) * r * r), 1.0, 1e-3,
                "thin lens", 0);
    assert_near(mesh_light(&lens, -1, -1, 0.0) / (pi * 4.0 * 0.96 * 0.96), 1.0,
                1e-3, "straight", 0);
}

/* Blades: the light of a stop's polygon. */
static void blades_in_closed_form(void **state)
{
    const double pi = acos(-1.0);
    const struct gp_lens lens = lens_of(
        "{'name': 'blades', 'blades': 5, 'surfaces': [{'thickness': 3,"
        "'n': 1.5, 'semi': 60}, {'thickness': 10, 'semi': 60},"
        "{'stop': true, 'semi': 4}]}");
    const double area = 2.5 * 16.0 * sin(2.0 * pi / 5.0);
    const double cosine = 1.0 / sqrt(1.04);
    assert_near(mesh_light(&lens, 1, 0, 0.2) /
                    (area * cosine * plate_share(1.5, cosine)), 1.0, 1e-3,
                "blades", 0);
}

/* The same by single rays all over the front. */
static double light_by_rays(const struct gp_lens *lens, int first, int second,
                            double u)
{
    enum { SIDE = 320 };
    const struct gp_lens_blades b = gp_lens_blades_of(lens, 0.0);
    const double side = 2.6 * lens->at[0].semi / SIDE;
    struct gp_lens_optics o;
    struct gp_lens_path path;
    double light = 0.0;
    gp_lens_optics_make(lens, GP_D_LINE, &o);
    gp_lens_path(lens, first, second, &path);
    for (int i = 0; i < SIDE * SIDE / 2; i++) {
        const struct gp_lens_hit h =
            gp_lens_trace(&o, &path, (i % SIDE + 0.5 - SIDE / 2) * side,
                          (i / SIDE + 0.5) * side, u, NULL);
        for (int half = -1; half <= 1 && h.through >= 0.0f; half += 2) {
            bool open = h.rim <= 1.0f;
            for (int k = 0; k < 3 * b.n; k++)
                open = open && b.normal[k / 3][0] * (double) h.stop[k % 3][0] +
                                       half * b.normal[k / 3][1] *
                                           (double) h.stop[k % 3][1] <=
                                   b.apothem;
            light += open ? side * side * (double) h.through : 0.0;
        }
    }
    return light / sqrt(1.0 + u * u);
}

/* Near the corner: light that meets the front's rim behind the vertex's plane, and that
 * aberrations send to where first order has none, or a second time. */
static void corners_lose_no_light(void **state)
{
    static const struct {
        const char *lens;
        int first, second;
    } row[] = {{"heliar", 3, 2},
               {"heliar", 8, 6},
               {"zoom-wide", 12, 6},
               {"zoom-wide", 5, 3}};
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct gp_lens lens = installed_lens(row[i].lens);
        const double want =
            light_by_rays(&lens, row[i].first, row[i].second, 0.3);
        assert_near(mesh_light(&lens, row[i].first, row[i].second, 0.3) / want,
                    1.0, 0.01, row[i].lens, row[i].second);
    }
}

/* All ghosts and the image together are no more than what meets the front. Fine
 * meshes of every ghost take seconds, and the first lens has them. */
static void energy_is_kept(void **state)
{
    const double pi = acos(-1.0);
    for (size_t l = 0; l < COUNT(installed); l++) {
        const struct gp_lens lens = installed_lens(installed[l]);
        struct glarepp_ghost ghost[GP_LENS_GHOSTS];
        const int n = gp_lens_ghosts(&lens, GP_D_LINE, ghost, NULL);
        for (int i = 0; i < 3; i++) {
            const double u = 0.02 * i, cosine = 1.0 / sqrt(1.0 + u * u);
            const double enters = pi * lens.at[0].semi * lens.at[0].semi *
                                  cosine;
            const double tolerance = l == 0 ? 1e-4 : 2e-3;
            const double image = mesh_light(&lens, -1, -1, u);
            double sum = image;
            for (int k = 0; k < n; k++)
                sum += mesh_light_within(tolerance, &lens, ghost[k].first,
                                         ghost[k].second, u);
            assert_true(image > 0.0 && sum > image);
            assert_true(sum < enters);
        }
    }
}

static void coats_reflect_less(void **state)
{
    struct gp_lens lens =
        lens_of("{'name': 'a', 'surfaces': [{'radius': 50,"
                " 'thickness': 4, 'n': 1.5, 'semi': 9}," BACK "," STOP "]}");
    assert_near(gp_lens_reflected(&lens, 0, 1.0, 550.0), 0.04, 1e-12, "bare",
                0);
    assert_near(gp_lens_reflected(&lens, 1, 0.0, 550.0), 1.0, 0.0, "grazing",
                0);
    // r = ((n1 n2 - n^2) / (n1 n2 + n^2))^2 of a quarter wave
    const double q = (1.5 - 1.38 * 1.38) / (1.5 + 1.38 * 1.38);
    lens.at[0].coat = 550.0;
    assert_near(gp_lens_reflected(&lens, 0, 1.0, 550.0), q * q, 1e-12, "coated",
                0);
    // n meets V between the lines F and C
    assert_near(0.5 / (gp_lens_index(1.5, 60.0, 486.1327) -
                       gp_lens_index(1.5, 60.0, 656.2725)), 60.0, 1e-9, "V", 0);
}

SUITE_OF(lens, make_folder, remove_folder, reads_lenses, refuses_lenses,
         reads_tables, meets_claims, middles_agree, images_land,
         plate_in_closed_form, rays_that_are_not_turned_back_make_no_ghost,
         thin_lens_in_closed_form, blades_in_closed_form, corners_lose_no_light,
         energy_is_kept, coats_reflect_less)
