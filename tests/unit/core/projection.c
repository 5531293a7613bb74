// SPDX-License-Identifier: Apache-2.0
/* core/projection.c: directions, solid angles, metrics. */
#include "unit.h"
#include "core/camera.h"
#include "core/projection.h"

static const double pi = 3.14159265358979323846;

static const struct {
    enum gp_projecting kind;
    double degrees;
    struct gp_rect display;
    double aspect;
} cases[] = {
    {GP_PERSPECTIVE, 40.0, {0, 0, 96, 54}, 1.0},
    {GP_PERSPECTIVE, 120.0, {-10, 7, 54, 71}, 2.0},
    {GP_PERSPECTIVE, 0.001, {0, 0, 7, 5}, 1.0},
    {GP_PERSPECTIVE, 179.9, {0, 0, 64, 64}, 1.0},
    {GP_LATLONG, 0.0, {0, 0, 128, 64}, 1.0},
    {GP_FISHEYE, 180.0, {0, 0, 64, 64}, 1.0},
    {GP_FISHEYE, 300.0, {3, 4, 67, 68}, 1.0},
    {GP_EQUISOLID, 180.0, {0, 0, 64, 64}, 1.0},
    {GP_EQUISOLID, 350.0, {0, 0, 64, 64}, 1.0},
};

static struct gp_projection of_case(size_t i)
{
    return gp_projection_of(cases[i].kind, cases[i].display, cases[i].aspect,
                            cases[i].degrees);
}

/* Tests whether a place has a direction: those of a fisheye end in a circle. */
static bool is_seen(const struct gp_projection *p, double x, double y)
{
    const double u = (x - p->x0) * p->dx, v = (y - p->y0) * p->dy;
    const double most = p->kind == GP_FISHEYE     ? pi
                        : p->kind == GP_EQUISOLID ? 2.0
                                                  : INFINITY;
    return hypot(u, v) < 0.98 * most;
}

/* A step of 1e-4 pixels, both ways, in eight directions. */
static void metrics_are_those_of_directions(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const struct gp_projection p = of_case(i);
        const struct gp_rect d = cases[i].display;
        for (int k = 0; k < 60; k++) {
            const double x =
                d.x0 + 0.5 + (k * 37 % 101) / 101.0 * (d.x1 - d.x0 - 1);
            const double y =
                d.y0 + 0.5 + (k * 53 % 97) / 97.0 * (d.y1 - d.y0 - 1);
            if (!is_seen(&p, x, y))
                continue;
            const struct gp_metric g = gp_projection_metric(&p, x, y);
            for (int turn = 0; turn < 8; turn++) {
                const double h = 1e-4 * fmin(1.0, 1e-3 / p.dy);
                const double a = h * cos(turn * pi / 8.0),
                             b = h * sin(turn * pi / 8.0);
                const double want =
                    g.xx * a * a + 2.0 * g.xy * a * b + g.yy * b * b;
                const struct gp_v3 apart =
                    gp_v3_sub(gp_projection_direction(&p, x + a, y + b),
                              gp_projection_direction(&p, x - a, y - b));
                assert_true(fabs(0.25 * gp_v3_dot(apart, apart) - want) <
                            2e-3 * want + 1e-30);
            }
            const double det = sqrt(g.xx * g.yy - g.xy * g.xy);
            assert_true(fabs(gp_projection_solid(&p, x, y) - det) <
                        1e-9 * det + 1e-300);
        }
    }
}

/* What a place shows is found there again; what is beyond a rim, or behind a pinhole,
 * nowhere. */
static void directions_have_places(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const struct gp_projection p = of_case(i);
        const struct gp_rect d = cases[i].display;
        for (int k = 0; k < 100; k++) {
            const double x = d.x0 + (k % 10 + 0.5) / 10.0 * (d.x1 - d.x0);
            const double y = d.y0 + (k / 10 + 0.5) / 10.0 * (d.y1 - d.y0);
            const struct gp_v3 to = gp_projection_direction(&p, x, y);
            const double r = hypot((x - p.x0) * p.dx, (y - p.y0) * p.dy);
            double at[2];
            if (!is_seen(&p, x, y))
                continue;
            const bool shows =
                gp_projection_place(&p, gp_v3_scale(to, 3.0), at);
            assert_int_equal(shows, !(p.rim > 0.0) || r <= p.rim);
            assert_true(!shows || hypot(at[0] - x, at[1] - y) < 1e-9);
            assert_true(p.kind != GP_PERSPECTIVE ||
                        !gp_projection_place(&p, gp_v3_scale(to, -1.0), at));
        }
    }
}

/* Of a sphere 4 pi; of a rectangle before a pinhole its closed form. */
static void solid_angles_add_up(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const struct gp_projection p = of_case(i);
        const struct gp_rect d = cases[i].display;
        const double r = cases[i].degrees * pi / 180.0;
        double sum = 0.0, want = 4.0 * pi;
        if (p.kind == GP_FISHEYE || p.kind == GP_EQUISOLID)
            want = 2.0 * pi * (1.0 - cos(0.5 * r));
        if (p.kind == GP_PERSPECTIVE) {
            const double b = tan(0.5 * r);
            const double a =
                b * cases[i].aspect * (d.x1 - d.x0) / (d.y1 - d.y0);
            want = 4.0 * asin(a * b / sqrt((1 + a * a) * (1 + b * b)));
        }
        enum { PARTS = 4 }; // of a pixel
        for (int y = 0; y < PARTS * (d.y1 - d.y0); y++) {
            for (int x = 0; x < PARTS * (d.x1 - d.x0); x++) {
                const double at[2] = {d.x0 + (x + 0.5) / PARTS,
                                      d.y0 + (y + 0.5) / PARTS};
                const struct gp_v3 v =
                    gp_projection_direction(&p, at[0], at[1]);
                const bool round =
                    p.kind == GP_FISHEYE || p.kind == GP_EQUISOLID;
                const double u =
                    hypot((at[0] - p.x0) * p.dx, (at[1] - p.y0) * p.dy);
                if (round && (v.z < cos(0.5 * r) ||
                              u > (p.kind == GP_FISHEYE ? pi : 2.0)))
                    continue;
                sum += gp_projection_solid(&p, at[0], at[1]) / (PARTS * PARTS);
            }
        }
        // pixels of 179.9 degrees are far too wide for a sum
        assert_true(fabs(sum / want - 1.0) <
                    (cases[i].degrees > 170.0 && p.kind == GP_PERSPECTIVE
                         ? 2.0
                         : 5e-3));
    }
}

static void rows_of_solid_angles_are_the_same(void **state)
{
    (void) state;
    for (size_t i = 0; i < COUNT(cases); i++) {
        const struct gp_projection p = of_case(i);
        float row[37];
        gp_projection_solid_row(&p, -3.5, 11.25, 37, row);
        for (int x = 0; x < 37; x++)
            assert_true(row[x] ==
                        (float) gp_projection_solid(&p, x - 3.5, 11.25));
    }
}

/* By matrices, shifted and anamorphic: the same places as the camera's own. */
static void cameras_have_projections(void **state)
{
    static const double to_ndc[16] = {
        0.9, 0, 0, 0, 0, -1.2, 0, 0, 0.6, 0.35, 1, 1, 0, 0, -1, 0,
    };
    const struct gp_rect display = {10, -20, 110, 40};
    struct gp_camera c;
    (void) state;
    assert_ok(gp_camera_make(NULL, NULL, NULL, to_ndc, GLAREPP_NDC_SPEC, &c));
    const struct gp_projection p = gp_camera_projection(&c, display);
    for (int i = 0; i < 20; i++) {
        const double to[3] = {0.1 * (i % 5) - 0.2, 0.15 * (i / 5) - 0.2, 1.0};
        const struct gp_projected at = gp_camera_project(&c, display, to, 0.0);
        const struct gp_v3 want =
            gp_v3_unit((struct gp_v3) {to[0], -to[1], 1.0});
        const struct gp_v3 apart =
            gp_v3_sub(gp_projection_direction(&p, at.x, at.y), want);
        assert_true(gp_v3_length(apart) < 1e-12);
    }
    assert_true(fabs(p.dx - 1.0 / 90.0) < 1e-15 &&
                fabs(p.dy - 1.0 / 72.0) < 1e-15);
}

static void chords_are_those_of_angles(void **state)
{
    (void) state;
    const struct gp_projection p = of_case(0), plane = {.dx = 0.1, .dy = 0.2};
    const struct gp_v3 a = gp_projection_direction(&p, 3.5, 7.5);
    const struct gp_v3 b = gp_projection_direction(&p, 90.5, 50.5);
    const double t = acos(gp_v3_dot(a, b)), chord = 2.0 * sin(0.5 * t);
    assert_true(fabs(gp_projection_chord2(&p, 3.5, 7.5, 90.5, 50.5) -
                     chord * chord) < 1e-12);
    assert_true(fabs(gp_projection_chord2(&plane, 0, 0, 3, 4) - 0.73) < 1e-12);
}

SUITE_OF(projection, NULL, NULL, metrics_are_those_of_directions,
         directions_have_places, solid_angles_add_up,
         rows_of_solid_angles_are_the_same, cameras_have_projections,
         chords_are_those_of_angles)
