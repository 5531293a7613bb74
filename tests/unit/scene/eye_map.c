/* Sun maps from geometry are within their sampling of rays. */
#include "unit.h"
#include "gl_open.h"
#include "scene/eye.h"
#include "scene_made.h"
#include "starved.h"

static const struct gp_rect display = {0, 0, 640, 360};
static struct gp_gl *gl;
static struct gp_eye_map *map;

static int set_up(void **state)
{
    (void) state;
    gl = open_or_skip(GP_GL_AUTO);
    return 0;
}

static int tear_down(void **state)
{
    (void) state;
    gp_eye_map_close(gl, &map);
    gp_eye_map_close(gl, &map); // twice is harmless
    gp_gl_close(&gl);
    return 0;
}

/* Suns and lamps of random scenes, with walls, cards with holes and balls. */
static void maps_are_near_rays(void **state)
{
    enum { SCENES = 60, SIDE = 128 };
    static const struct gp_box world = {{-15, -15, 0.5}, {15, 15, 9}};
    uint64_t seed = 21;
    double sum = 0.0, worst = 0.0;
    int n = 0, partial = 0;
    for (int i = 0; i < SCENES; i++) {
        struct gp_scene s = made_random_scene(&seed, 40, 0);
        gp_eye_map_close(gl, &map); // its textures are another scene's
        for (int k = 0; k < 6; k++) {
            const struct gp_v3 eye = made_within(&seed, world);
            const struct gp_v3 at = made_within(&seed, world);
            const double ball = made_between(&seed, 0.01, 1.0);
            if (k % 2 && made_touched(&s, at, ball))
                continue;
            const struct gp_eye_disc d =
                k % 2 ? gp_eye_lamp(eye, at, ball)
                      : gp_eye_sun(eye, gp_v3_sub(at, eye),
                                   made_between(&seed, 0.002, 0.3));
            struct gp_eye_share want, got;
            assert_ok(gp_eye_rays(&kept_log, &s, NULL, &d, NULL, &want));
            if (gp_eye_map_draw(&kept_log, gl, &s, NULL, &d, NULL, SIDE, &map, &got))
                fail_msg("%s", kept_line);
            const double off = fabs(got.clear - want.clear);
            assert_true(got.objects == want.objects && got.outside == 1.0);
            if (off > 3.0 * (got.error + want.error) + 1.0 / SIDE)
                fail_msg("scene %d, disc %d: %g by the map, %g by rays, errors "
                         "%g, %g, half %g", i, k, got.clear, want.clear,
                         got.error, want.error, d.half);
            partial += want.clear > 0.02 && want.clear < 0.98;
            sum += off;
            worst = fmax(worst, off);
            n++;
        }
        made_free(&s);
    }
    print_message("# maps of %d texels a side: mean %.5f, worst %.4f of %d, %d "
                  "of them partial\n", SIDE, sum / n, worst, n, partial);
    assert_true(partial > 20 && sum / n < 0.002);
}

/* The part inside the window counts nothing; 16 texels a side are as near as
 * the paper's. */
static void windows_and_small_maps(void **state)
{
    struct gp_scene s = made_scene();
    const struct gp_camera c = made_camera(
        &s, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 30.0,
        640.0 / 360.0);
    const struct gp_v3 edge = gp_camera_ray(&c, display, 640.0, 180.0);
    const struct gp_eye_window w = {&c, display, display};
    const struct gp_eye_disc d = gp_eye_sun((struct gp_v3) {0, 0, 0}, edge,
                                            0.00465);
    // a box hides the lower half
    made_put(&s, made_box(&s, 0), (struct gp_v3) {10, 20, -5},
             (struct gp_v3) {60, 0.1, 10}, 0.0);
    struct gp_eye_share rays, got;
    assert_ok(gp_eye_rays(&kept_log, &s, NULL, &d, &w, &rays));
    assert_ok(gp_eye_map_draw(&kept_log, gl, &s, NULL, &d, &w, 16, &map, &got));
    assert_int_equal(got.samples, 16);
    assert_true(fabs(got.outside - 0.5) < 0.05);
    assert_true(fabs(rays.clear - 0.5) < 0.01);
    assert_true(fabs(got.clear - rays.clear) < 0.05);
    // nothing is drawn for what the frame shows, nor behind one triangle
    const struct gp_eye_disc in =
        gp_eye_sun((struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 0.00465);
    assert_ok(gp_eye_map_draw(&kept_log, gl, &s, NULL, &in, &w, 16, &map, &got));
    assert_true(got.outside == 0.0 && got.clear == 1.0 && got.samples == 0);
    const struct gp_eye_disc hidden = gp_eye_sun(
        (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0.3, 1, -0.1}, 0.00465);
    assert_ok(gp_eye_map_draw(&kept_log, gl, &s, NULL, &hidden, NULL, 16, &map, &got));
    assert_true(got.clear == 0.0 && got.samples == 0);
    // a point is left to a ray
    const struct gp_eye_disc point = gp_eye_lamp(
        (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 40, -1}, 0.0);
    assert_ok(gp_eye_map_draw(&kept_log, gl, &s, NULL, &point, NULL, 16, &map, &got));
    assert_true(got.clear == 0.0);
    made_free(&s);
}

/* A map of more triangles than a driver draws soon is left to rays. */
static void copies_are_left_to_rays(void **state)
{
    struct gp_scene s = made_scene();
    const struct gp_eye_disc d = gp_eye_sun(
        (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 0.1);
    struct gp_eye_share want, got;
    const int ball = made_ball(&s, 0, 60);
    uint64_t seed = 23;
    for (int i = 0; i < 30; i++) {
        const double y = made_between(&seed, 5.0, 50.0);
        made_put(&s, ball, (struct gp_v3) {made_between(&seed, -0.1, 0.1) * y, y,
                                           made_between(&seed, -0.1, 0.1) * y},
                 (struct gp_v3) {0.02 * y, 0.02 * y, 0.02 * y}, 0.0);
    }
    assert_ok(gp_eye_rays(&kept_log, &s, NULL, &d, NULL, &want));
    assert_ok(gp_eye_map_draw(&kept_log, gl, &s, NULL, &d, NULL, 32, &map,
                              &got));
    assert_true(want.clear > 0.2 && want.clear < 0.95 && want.objects > 20);
    assert_memory_equal(&got, &want, sizeof got);
    made_free(&s);
}

static struct gp_scene many;
static double many_share;

static gp_status one_share(void)
{
    const struct gp_eye_disc d = gp_eye_sun(
        (struct gp_v3) {-19, -19, 3}, (struct gp_v3) {1, 0.8, 0.1}, 0.3);
    struct gp_eye_map *own = NULL;
    struct gp_eye_share share;
    const gp_status st = gp_eye_map_draw(&kept_log, gl, &many, NULL, &d, NULL, 32,
                                         &own, &share);
    if (!st)
        many_share = share.clear;
    gp_eye_map_close(gl, &own);
    return st;
}

static void full_memory(void **state)
{
    uint64_t seed = 5;
    many = made_random_scene(&seed, 60, 0);
    starve("sun map of a scene", one_share, &many_share, 3);
    made_free(&many);
}

SUITE_OF(eye_map, set_up, tear_down, maps_are_near_rays,
         windows_and_small_maps, copies_are_left_to_rays, full_memory)
