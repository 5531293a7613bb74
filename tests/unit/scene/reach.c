/* Volumes of lights, against points one by one. */
#include "scene/sets/sets_priv.h"

#include "scene_made.h"

static const struct gp_rect display = {0, 0, 160, 100};

static struct gp_v3 direction(uint64_t *seed)
{
    const double z = made_between(seed, -1, 1), a = made_between(seed, 0, 6.3);
    const double w = sqrt(1.0 - z * z);
    return (struct gp_v3) {w * cos(a), w * sin(a), z};
}

static struct gp_scene_light random_light(uint64_t *seed, int i)
{
    const double narrow = made_between(seed, 0.05, i % 3 == 2 ? 1.7 : 1.5);
    return (struct gp_scene_light) {
        .kind = i % 3 ? GP_LIGHT_SPOT : GP_LIGHT_POINT,
        .at = {made_between(seed, -9, 9), made_between(seed, -9, 9), 2},
        .along = direction(seed), .outer = fmin(narrow, 0.5 * MADE_PI),
        .range = i % 7 == 6 ? INFINITY : made_between(seed, 1, 12)};
}

/* No box, sphere, frustum or rectangle that holds a lit point is dropped;
 * those of most unlit ones are. */
static void lit_points(void **state)
{
    uint64_t seed = 31;
    struct gp_scene s = made_scene();
    const struct gp_camera c = made_camera(
        &s, (struct gp_v3) {0, -12, 3}, (struct gp_v3) {0, 0, 1}, 60.0, 1.6);
    const struct gp_rect d = display;
    const double x[2] = {d.x0, d.x1}, y[2] = {d.y0, d.y1};
    const struct gp_frustum f = gp_frustum_make(&c, d, x, y, 0.1, 40.0);
    const struct gp_volume v = gp_frustum_volume(&f);
    int lit = 0, seen = 0, far = 0, beside = 0, missed = 0;
    for (int i = 0; i < 3000; i++) {
        const struct gp_scene_light light = random_light(&seed, i);
        const struct gp_reach r = gp_light_reach(&light);
        const struct gp_screen_box b = gp_reach_project(&r, &c, d, 0.1);
        missed += !gp_reach_meets(&r, &v);
        for (int k = 0; k < 30; k++) {
            const double away = fmin(light.range, 15.0) *
                                made_between(&seed, 0.0, 1.5);
            const struct gp_v3 to = direction(&seed);
            const struct gp_v3 p =
                gp_v3_add(light.at, gp_v3_scale(to, away));
            const struct gp_v3 e = {made_random(&seed), made_random(&seed),
                                    made_random(&seed)};
            const struct gp_v3 q = {p.x + e.x * made_between(&seed, -1, 1),
                                    p.y + e.y * made_between(&seed, -1, 1),
                                    p.z + e.z * made_between(&seed, -1, 1)};
            const double radius = gp_v3_length(gp_v3_sub(q, p)) + 1e-9;
            const bool is_lit = away < light.range &&
                                (light.kind == GP_LIGHT_POINT ||
                                 gp_v3_dot(to, light.along) > cos(light.outer));
            if (!is_lit) {
                far += gp_reach_too_far(&r, q, e);
                beside += gp_reach_beside(&r, q, radius);
                continue;
            }
            lit++;
            assert_false(gp_reach_too_far(&r, q, e));
            assert_false(gp_reach_beside(&r, q, radius));
            assert_true(p.x > r.box.lo.x - 1e-9 && p.x < r.box.hi.x + 1e-9 &&
                        p.y > r.box.lo.y - 1e-9 && p.y < r.box.hi.y + 1e-9 &&
                        p.z > r.box.lo.z - 1e-9 && p.z < r.box.hi.z + 1e-9);
            const double world[3] = {p.x, p.y, p.z};
            const struct gp_projected at =
                gp_camera_project(&c, d, world, 1.0);
            if (at.behind || at.z < 0.1 || at.z > 40.0)
                continue;
            assert_true(b.seen && at.x > b.x0 - 1e-6 && at.x < b.x1 + 1e-6 &&
                        at.y > b.y0 - 1e-6 && at.y < b.y1 + 1e-6 &&
                        at.z > b.near - 1e-9 && at.z < b.far + 1e-9);
            if (at.x > d.x0 && at.x < d.x1 && at.y > d.y0 && at.y < d.y1) {
                assert_true(gp_reach_meets(&r, &v));
                seen++;
            }
        }
    }
    assert_true(lit > 5000 && seen > 1000);
    assert_true(far > 9000 && beside > 20000 && missed > 40);
    made_free(&s);
}

/* A directional light has no place and no end. */
static void directional(void **state)
{
    const struct gp_scene_light sun = {.kind = GP_LIGHT_DIRECTIONAL,
                                       .along = {0, 0, -1},
                                       .range = INFINITY};
    const struct gp_reach r = gp_light_reach(&sun);
    const struct gp_v3 far = {1e9, -1e9, -1e9}, e = {1, 1, 1};
    assert_true(r.from.w == 0.0 && r.from.p.z == 1.0);
    assert_false(gp_reach_too_far(&r, far, e));
    assert_false(gp_reach_beside(&r, far, 1.0));
}

SUITE_OF(reach, NULL, NULL, lit_points, directional)
