// SPDX-License-Identifier: Apache-2.0
/* Shares of discs by rays against closed forms, and laws of them. */
#include "scene/eye.h"

#include "core/parallel.h"
#include "scene_made.h"

static const struct gp_rect display = {0, 0, 640, 360};

static void near_to(const char *what, double got, double want, double most)
{
    if (!(fabs(got - want) <= most))
        fail_msg("%s: %.9g, not %.9g within %g", what, got, want, most);
}

/* A card of `size` metres in the plane y = `at`, its lower edge at z. */
static void put_wall(struct gp_scene *s, int card, double at, double x,
                     double z, double size)
{
    // the card's y becomes z
    const double m[16] = {size, 0, 0, 0, 0, 0, size, 0, 0, -size, 0, 0,
                          x,    at, z + 0.5 * size, 1};
    made_place(s, card, m);
}

static struct gp_eye_share share_of(const struct gp_scene *s,
                                    const struct gp_eye_disc *d,
                                    const struct gp_eye_window *w)
{
    struct gp_meshes meshes = {0};
    struct gp_eye_share out;
    assert_ok(gp_eye_rays(NULL, s, &meshes, d, w, &out));
    gp_meshes_free(&meshes);
    assert_true(out.clear >= 0.0 && out.clear <= 1.0);
    return out;
}

/* Share of a disc of radius 1 above the line at height h. */
static double segment(double h)
{
    return h >= 1.0    ? 0.0
           : h <= -1.0 ? 1.0
                       : (acos(h) - h * sqrt(1.0 - h * h)) / MADE_PI;
}

/* A wall hides the part of a small sun that its edge leaves: closed form. */
static void edge_of_a_wall(void **state)
{
    const double half = 0.00465;
    double worst = 0.0, sum = 0.0;
    int n = 0;
    for (double h = -1.2; h <= 1.2; h += 0.0371) {
        struct gp_scene s = made_scene();
        const int card = made_card(&s, 0);
        const double edge = 20.0 * tan(h * half);
        put_wall(&s, card, 20.0, 0.1, edge - 8.0, 8.0); // hides what is below
        const struct gp_eye_disc d = gp_eye_sun(
            (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, half);
        const struct gp_eye_share got = share_of(&s, &d, NULL);
        const double off = fabs(got.clear - segment(h));
        assert_true(got.part == 1.0);
        assert_true(got.error <= 5e-4);
        worst = fmax(worst, off);
        sum += off;
        n++;
        if (fabs(h) > 1.0)
            assert_true(off == 0.0);
        made_free(&s);
    }
    print_message("# edge: mean %.2g, worst %.2g of %d\n", sum / n, worst, n);
    assert_true(worst < 4.0 * 5e-4 && sum / n < 5e-4);
}

/* What a wall leaves of a disc, or hides of it, may be under a ray's share: no ray meets
 * it, and three times `error` still hold it. */
static void slivers_are_in_the_error(void **state)
{
    const double half = 0.00465;
    int missed = 0;
    for (int i = 0; i < 60; i++) {
        struct gp_scene s = made_scene();
        const double h = (i % 2 ? -1.0 : 1.0) * (0.985 + 0.00025 * i);
        put_wall(&s, made_card(&s, 0), 20.0, 0.1, 20.0 * tan(h * half) - 8.0,
                 8.0);
        const struct gp_eye_disc d = gp_eye_sun((struct gp_v3) {0, 0, 0},
                                                (struct gp_v3) {0, 1, 0}, half);
        const struct gp_eye_share got = share_of(&s, &d, NULL);
        near_to("sliver", got.clear, segment(h), 3.0 * got.error);
        missed += got.clear == (i % 2 ? 1.0 : 0.0);
        made_free(&s);
    }
    assert_true(missed > 4);
}

/* Walls with regular holes show their share; `error` holds the difference. */
static void leaves_with_holes(void **state)
{
    static const double eye[][3] = {{0, 0, 0}, {0.013, 0.5, 0.021}};
    for (size_t i = 0; i < COUNT(eye); i++) {
        struct gp_scene s = made_scene();
        const int holes = made_material(&s, 0.5f, made_holes(&s, 64, 8));
        const int card = made_card(&s, holes);
        put_wall(&s, card, 20.0, 0.0, -1.5, 3.0);
        const struct gp_eye_disc d =
            gp_eye_sun((struct gp_v3) {eye[i][0], eye[i][1], eye[i][2]},
                       (struct gp_v3) {0, 1, 0}, 0.05);
        const struct gp_eye_share got = share_of(&s, &d, NULL);
        near_to("half", got.clear, 0.5, 0.01);
        assert_true(got.error < 0.002);
        s.material[holes].cutoff = 0.0f; // opaque everywhere
        assert_true(share_of(&s, &d, NULL).clear == 0.0);
        s.material[holes].cutoff = 0.5f;
        s.material[holes].base[3] = 0.49f; // and nowhere
        assert_true(share_of(&s, &d, NULL).clear == 1.0);
        made_free(&s);
    }
}

/* A lamp is hidden by what is before it, and by nothing in it or after it;
 * nothing behind the eye counts. */
static void walls_and_lamps(void **state)
{
    static const struct {
        double wall; // y; the lamp is at 10, its ball 0.5
        double want;
    } row[] = {{5.0, 0.5}, {9.4, 0.5}, {10.0, 1.0}, {11.0, 1.0}, {-5.0, 1.0}};
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_scene s = made_scene();
        put_wall(&s, made_card(&s, 0), row[i].wall, 0.0, 0.0, 9.0);
        const struct gp_eye_disc d = gp_eye_lamp(
            (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 10, 0}, 0.5);
        near_to("lamp", share_of(&s, &d, NULL).clear, row[i].want, 0.002);
        // a point: one ray, hidden or clear
        const struct gp_eye_disc point = gp_eye_lamp(
            (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 10, 0.001}, 0.0);
        const struct gp_eye_share got = share_of(&s, &point, NULL);
        assert_true(got.clear == (row[i].want < 1.0 ? 0.0 : 1.0));
        // an eye in the ball sees all of it
        const struct gp_eye_disc in = gp_eye_lamp(
            (struct gp_v3) {0, row[i].wall + 0.1, 0},
            (struct gp_v3) {0, row[i].wall, 0}, 0.3);
        assert_true(share_of(&s, &in, NULL).clear == 1.0);
        made_free(&s);
    }
}

/* No ray slips between the triangles of a closed ball, or through an edge that
 * two of them share. */
static void closed_balls_are_tight(void **state)
{
    for (int rings = 2; rings < 9; rings++) {
        struct gp_scene s = made_scene();
        const int ball = made_ball(&s, 0, rings);
        made_put(&s, ball, (struct gp_v3) {0, 5, 0}, (struct gp_v3) {4, 4, 4},
                 17.0);
        const struct gp_eye_disc d = gp_eye_sun(
            (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 0.2);
        assert_true(share_of(&s, &d, NULL).clear == 0.0);
        // from within, in all directions that a disc may have
        const struct gp_eye_disc in = gp_eye_sun(
            (struct gp_v3) {0, 5, 0}, (struct gp_v3) {0.3, 1, 0.2}, 9.0);
        assert_true(in.half < 1.6);
        assert_true(share_of(&s, &in, NULL).clear == 0.0);
        made_free(&s);
    }
}

/* The window's part counts nothing: its share is what is left, and what hides
 * in it is not seen. */
static void windows_are_left_out(void **state)
{
    struct gp_scene s = made_scene();
    const struct gp_camera c = made_camera(
        &s, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 30.0,
        640.0 / 360.0);
    put_wall(&s, made_card(&s, 0), 20.0, 0.0, -40.0, 80.0);
    const struct gp_v3 edge = gp_camera_ray(&c, display, 640.0, 180.0);
    static const struct {
        double turn; // of the window's edge, in half angles from the middle
        double outside;
    } row[] = {{0.0, 0.5}, {0.5, 0.80450}, {-0.5, 0.19550}, {2, 1}, {-2, 0}};
    for (size_t i = 0; i < COUNT(row); i++) {
        const double half = 0.005, t = row[i].turn * half;
        const struct gp_v3 to = {edge.x * cos(t) + edge.y * sin(t),
                                 edge.y * cos(t) - edge.x * sin(t), 0.0};
        const struct gp_eye_disc d =
            gp_eye_sun((struct gp_v3) {0, 0, 0}, to, half);
        const struct gp_eye_window w = {&c, display, display, false};
        const struct gp_eye_share got = share_of(&s, &d, &w);
        near_to("outside", got.part, row[i].outside, 0.005);
        assert_true(got.clear == (row[i].outside > 0.0 ? 0.0 : 1.0));
        const struct gp_eye_window none = {&c, display, {0, 0, 0, 0}, false};
        assert_true(share_of(&s, &d, &none).part == 1.0);
    }
    // area in the picture: a disc cut by the frame has there the share of its
    // ellipse, not of its solid angle
    const struct gp_eye_disc wide =
        gp_eye_sun((struct gp_v3) {0, 0, 0}, edge, 0.5);
    const struct gp_eye_window w = {
        &c, display, {-100000, -100000, 640, 100000}, false};
    const double world[3] = {edge.x, edge.y, edge.z};
    assert_true(gp_camera_disc(&c, display, world, 57.0) > 0.0);
    assert_true(share_of(&s, &wide, &w).part > 0.55);
    made_free(&s);
}

static void threads_change_nothing(void **state)
{
    uint64_t seed = 5;
    struct gp_scene many = made_random_scene(&seed, 60, 0);
    const struct gp_eye_disc d = gp_eye_sun(
        (struct gp_v3) {-19, -19, 3}, (struct gp_v3) {1, 0.8, 0.1}, 0.3);
    double first = 0.0;
    for (int threads = 1; threads < 4; threads++) {
        gp_set_threads(threads);
        const double share = share_of(&many, &d, NULL).clear;
        first = threads == 1 ? share : first;
        assert_memory_equal(&first, &share, sizeof first);
    }
    assert_true(first > 0.0 && first < 1.0);
    gp_set_threads(0);
    made_free(&many);
}

/* A card of side x side squares, of the size and place of made_card()'s. */
static int fine_card(struct gp_scene *s, int side)
{
    const int first = s->indices;
    for (int y = 0; y <= side; y++) {
        for (int x = 0; x <= side; x++)
            made_vertex(s, (double) x / side - 0.5, (double) y / side - 0.5,
                        0.0, 0.0, 0.0);
    }
    const int from = s->vertices - (side + 1) * (side + 1);
    for (int y = 0; y < side; y++) {
        for (int x = 0; x < side; x++) {
            const int a = from + y * (side + 1) + x;
            made_quad(s, a, a + 1, a + side + 2, a + side + 1);
        }
    }
    return made_part(s, first, 0, false);
}

/* Copies of a large mesh are one tree, and hide as small ones in
 * their place do. */
static void copies_of_a_large_mesh(void **state)
{
    enum { COPIES = 6, SIDE = 240 };
    struct gp_scene fine = made_scene(), coarse = made_scene();
    const int large = fine_card(&fine, SIDE), card = made_card(&coarse, 0);
    int object[COPIES];
    for (int i = 0; i < COPIES; i++) {
        object[i] = i;
        put_wall(&fine, large, 20.0 + i, 2.0 * i - 5.0, -3.1, 1.0 + 0.3 * i);
        put_wall(&coarse, card, 20.0 + i, 2.0 * i - 5.0, -3.1, 1.0 + 0.3 * i);
    }
    struct gp_rays rays = {0};
    struct gp_meshes meshes = {0};
    assert_ok(gp_rays_make(NULL, &fine, &meshes, object, COPIES, &rays));
    const struct gp_mesh_tree *const first = meshes.tree;
    gp_rays_free(&rays);
    assert_ok(gp_rays_make(NULL, &fine, &meshes, object, 1, &rays));
    assert_ptr_equal(meshes.tree, first); // made once
    gp_rays_free(&rays);
    gp_meshes_free(&meshes);
    const struct gp_eye_disc d = gp_eye_sun(
        (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 0.5);
    const struct gp_eye_share got = share_of(&fine, &d, NULL);
    const struct gp_eye_share want = share_of(&coarse, &d, NULL);
    assert_true(want.clear > 0.5 && want.clear < 0.99);
    near_to("copies", got.clear, want.clear, 1e-9);
    made_free(&fine);
    made_free(&coarse);
}

SUITE_OF(eye, NULL, NULL, edge_of_a_wall, slivers_are_in_the_error,
         leaves_with_holes, walls_and_lamps, closed_balls_are_tight,
         windows_are_left_out, threads_change_nothing, copies_of_a_large_mesh)
