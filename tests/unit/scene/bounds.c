/* Boxes and spheres of objects, and bounds of boxes on the screen, against points
 * of the objects one by one. */
#include "scene/gltf/gltf_priv.h"
#include "scene/sets/sets_priv.h"

#include "scene_made.h"

static const struct gp_rect display = {-3, 5, 157, 95};

/* Objects of random scenes are as each of their vertices says. */
static void vertices_of_objects(void **state)
{
    uint64_t seed = 1;
    for (int i = 0; i < 20; i++) {
        struct gp_scene s = made_random_scene(&seed, 30, 0);
        for (int k = 0; k < s.objects; k++) {
            const struct gp_object want = s.object[k];
            struct gp_object *const got = &s.object[k];
            got->box = (struct gp_box) {{1, 1, 1}, {0, 0, 0}};
            got->radius = -1.0;
            gp_bounds_set(&s, got);
            assert_true(gp_v3_length(gp_v3_sub(got->box.lo, want.box.lo)) <
                        1e-12);
            assert_true(gp_v3_length(gp_v3_sub(got->box.hi, want.box.hi)) <
                        1e-12);
            assert_true(fabs(got->radius - want.radius) <
                        1e-9 * want.radius);
        }
        made_free(&s);
    }
}

/* A large mesh is held by the corners of its box: every vertex, and little
 * more. */
static void large_mesh(void **state)
{
    uint64_t seed = 3;
    struct gp_scene s = made_scene();
    const int ball = made_ball(&s, 0, 40);
    for (int i = 0; i < 10; i++) {
        const int at = made_put_along(
            &s, ball, (struct gp_v3) {i, 2, 3}, (struct gp_v3) {1, 2, i + 1.0},
            (struct gp_v3) {made_random(&seed), 1, made_random(&seed)});
        const struct gp_object want = s.object[at];
        gp_bounds_set(&s, &s.object[at]);
        const struct gp_object *const o = &s.object[at];
        const struct gp_box both =
            gp_box_with(gp_box_with(o->box, want.box.lo), want.box.hi);
        assert_memory_equal(&both, &o->box, sizeof both);
        const double off = gp_v3_length(gp_v3_sub(o->centre, want.centre));
        assert_true(o->radius >= want.radius - off);
        assert_true(o->radius < 2.0 * want.radius);
    }
    made_free(&s);
}

/* A mesh without triangles has an empty box. */
static void mesh_of_nothing(void **state)
{
    struct gp_scene s = made_scene();
    const int box = made_box(&s, 0);
    const int at = made_put(&s, box, (struct gp_v3) {1, 2, 3},
                            (struct gp_v3) {1, 1, 1}, 0.0);
    const int part = s.mesh[box].first;
    s.submesh[part].count = 0;
    gp_bounds_set(&s, &s.object[at]);
    assert_true(gp_box_empty(s.object[at].box));
    assert_true(s.object[at].radius == 0.0);
    const struct gp_camera c = made_camera(
        &s, (struct gp_v3) {0, -9, 3}, (struct gp_v3) {0, 0, 0}, 50.0, 1.6);
    assert_false(gp_bounds_project(&c, display, &s.object[at].box, 0.1).seen);
    made_free(&s);
}

/* Widens `seen` by a point of the world that is at `near` or beyond. */
static void count(const struct gp_camera *c, struct gp_v3 p, double near,
                  struct gp_screen_box *seen)
{
    const double world[3] = {p.x, p.y, p.z};
    const struct gp_projected at = gp_camera_project(c, display, world, 1.0);
    if (at.behind || at.z < near)
        return;
    if (!seen->seen)
        *seen = (struct gp_screen_box) {at.x, at.y, at.x, at.y, at.z, at.z,
                                        true};
    seen->x0 = fmin(seen->x0, at.x);
    seen->x1 = fmax(seen->x1, at.x);
    seen->y0 = fmin(seen->y0, at.y);
    seen->y1 = fmax(seen->y1, at.y);
    seen->near = fmin(seen->near, at.z);
    seen->far = fmax(seen->far, at.z);
}

/* `b` holds `in`, and where `tight` is not over that much wider. */
static void check(struct gp_screen_box b, struct gp_screen_box in, double tight)
{
    assert_true(b.seen || !in.seen);
    if (!in.seen)
        return;
    const double got[] = {-b.x0, -b.y0, b.x1, b.y1, -b.near, b.far};
    const double least[] = {-in.x0, -in.y0, in.x1, in.y1, -in.near, in.far};
    for (int i = 0; i < 6; i++) {
        const double size = fabs(least[i]) + 1.0;
        assert_true(got[i] >= least[i] - 1e-9 * size);
        assert_true(got[i] <= least[i] + tight * size);
    }
}

/* Boxes before, around and behind a camera. */
static void boxes_on_screen(void **state)
{
    uint64_t seed = 2;
    struct gp_scene s = made_scene();
    const struct gp_camera c = made_camera(
        &s, (struct gp_v3) {1, -4, 2}, (struct gp_v3) {0, 3, 1}, 60.0, 1.6);
    const struct gp_box world = {{-6, -9, -6}, {6, 6, 6}};
    int tight = 0, cut = 0;
    for (int i = 0; i < 1500; i++) {
        const double near = made_between(&seed, 0.05, 1.0);
        const struct gp_v3 at = made_within(&seed, world);
        const struct gp_v3 to = made_within(&seed, world);
        struct gp_box box = gp_box_with(gp_box_with(GP_BOX_EMPTY, at), to);
        struct gp_screen_box in = {0};
        // all corners and edges
        for (int k = 0; k < 8; k++) {
            for (int axis = 1; axis < 8; axis *= 2) {
                const struct gp_v3 p = gp_box_corner(&box, k),
                                   q = gp_box_corner(&box, k ^ axis);
                for (int t = 0; t <= 64; t++)
                    count(&c, gp_v3_add(p, gp_v3_scale(gp_v3_sub(q, p),
                                                       t / 64.0)), near, &in);
            }
        }
        const struct gp_screen_box got =
            gp_bounds_project(&c, display, &box, near);
        check(got, in, got.near > near ? 1e-9 : INFINITY);
        tight += in.seen && got.near > near;
        cut += in.seen && !(got.near > near);
    }
    assert_true(tight > 200 && cut > 40);
    made_free(&s);
}

SUITE_OF(bounds, NULL, NULL, vertices_of_objects, large_mesh, mesh_of_nothing,
         boxes_on_screen)
