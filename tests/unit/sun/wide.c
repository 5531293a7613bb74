// SPDX-License-Identifier: Apache-2.0
/* core/camera: cameras of lat-longs and fisheyes. */
#include "unit.h"
#include "core/camera.h"

static void near_to(const char *what, double got, double want, double within)
{
    if (!(fabs(got - want) <= within))
        fail_msg("%s: %.12g is not %.12g within %g", what, got, want, within);
}

/* Rays and places are each other's inverse, whichever hand the camera's space has; a
 * disc's pixels are those within its cone. */
static void wide_pictures_have_cameras(void **state)
{
    static const struct gp_rect d = {-4, 9, 396, 209};
    static const enum gp_projecting kinds[] = {GP_LATLONG, GP_FISHEYE,
                                               GP_EQUISOLID};
    // a turn about y, twice the size, moved; to the left hand and to the right
    static const double turned[2][16] = {
        {1.2, 0, 1.6, 0, 0, 2, 0, 0, 1.6, 0, -1.2, 0, 5, -6, 7, 1},
        {1.2, 0, -1.6, 0, 0, 2, 0, 0, 1.6, 0, 1.2, 0, 5, -6, -7, 1}};
    (void) state;
    for (int i = 0; i < 6; i++) {
        const struct gp_projection p =
            gp_projection_of(kinds[i / 2], d, 1.0, 180.0);
        struct gp_camera c;
        assert_ok(gp_camera_wide(NULL, "a.exr", turned[i % 2], &p, &c));
        const struct gp_v3 eye = gp_camera_eye(&c);
        const struct gp_v3 middle = gp_camera_ray(&c, d, p.x0, p.y0);
        near_to("the view", 0.8 * middle.x - 0.6 * middle.z, 1.0, 1e-12);
        for (int k = 0; k < 24; k++) {
            const double x = 200 + 90 * cos(k), y = 109 + 85 * sin(k);
            const struct gp_v3 ray = gp_camera_ray(&c, d, x, y);
            const struct gp_v3 far = gp_v3_add(eye, gp_v3_scale(ray, 3.0));
            const double to[3] = {ray.x, ray.y, ray.z};
            const double place[3] = {far.x, far.y, far.z};
            const struct gp_projected sun = gp_camera_project(&c, d, to, 0.0);
            const struct gp_projected at = gp_camera_project(&c, d, place, 1.0);
            near_to("sun x", sun.x, x, 1e-6);
            near_to("sun y", sun.y, y, 1e-6);
            near_to("lamp x", at.x, x, 1e-6);
            near_to("lamp y", at.y, y, 1e-6);
            near_to("distance", at.ray, 6.0, 1e-9);
            // count hundredths of pixels
            const double radius = gp_camera_disc(&c, d, to, 6.0);
            const double wide = gp_camera_disc_wide(&c, y, 6.0);
            const int n = (int) (10.0 * radius * sqrt(wide)) + 20;
            int inside = 0, across = 0;
            for (int q = 0; q < (2 * n + 1) * (2 * n + 1); q++) {
                const double u = x + (q % (2 * n + 1) - n) / 10.0;
                const double v = y + (q / (2 * n + 1) - n) / 10.0;
                const bool in = gp_v3_dot(gp_camera_ray(&c, d, u, v), ray) >
                                cos(3.0 * M_PI / 180.0);
                inside += in;
                across += in && q / (2 * n + 1) == n;
            }
            const double area = M_PI * radius * radius;
            near_to("area", inside / 100.0, area, 0.02 * area);
            if (p.kind == GP_LATLONG)
                near_to("width", across / 10.0, 2.0 * radius * sqrt(wide),
                        0.02 * radius * sqrt(wide) + 0.2);
            near_to("degrees", gp_camera_disc_degrees(&c, d, to, radius), 6.0,
                    1e-6);
        }
    }
}

/* Without a matrix a lat-long is as OpenEXR has it; a fisheye is the camera's. */
static void the_worlds_of_wide_pictures(void **state)
{
    static const struct gp_rect d = {0, 0, 400, 200};
    static const struct {
        enum gp_projecting kind;
        double to[3], x, y;
    } rows[] = {
        {GP_LATLONG, {0, 0, 1}, 200, 100},  {GP_LATLONG, {1, 0, 0}, 100, 100},
        {GP_LATLONG, {-1, 0, 0}, 300, 100}, {GP_LATLONG, {0, 1, 1}, 200, 50},
        {GP_FISHEYE, {0, 0, 1}, 200, 100},  {GP_FISHEYE, {1, 0, 0}, 300, 100},
        {GP_FISHEYE, {0, 1, 1}, 200, 50},
    };
    (void) state;
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_projection p =
            gp_projection_of(rows[i].kind, d, 1.0, 180.0);
        struct gp_camera c;
        assert_ok(gp_camera_wide(NULL, "a.exr", NULL, &p, &c));
        const struct gp_projected at =
            gp_camera_project(&c, d, rows[i].to, 0.0);
        near_to("x", at.x, rows[i].x, 1e-9);
        near_to("y", at.y, rows[i].y, 1e-9);
    }
}

SUITE_OF(wide, NULL, NULL, wide_pictures_have_cameras,
         the_worlds_of_wide_pictures)
