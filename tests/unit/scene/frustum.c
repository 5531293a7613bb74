/* Frusta and their hulls with lights, against points one by one. */
#include "scene/sets/sets_priv.h"

#include "scene_made.h"

static const struct gp_rect display = {-3, 5, 157, 95};

static struct gp_v3 mix(struct gp_v3 a, struct gp_v3 b, double t)
{
    return gp_v3_add(gp_v3_scale(a, 1.0 - t), gp_v3_scale(b, t));
}

/* A random camera; every other one mirrors x. */
static struct gp_camera camera(uint64_t *seed, int i)
{
    static const struct gp_box world = {{-9, -9, -9}, {9, 9, 9}};
    struct gp_scene s = made_scene();
    const struct gp_v3 eye = made_within(seed, world);
    struct gp_camera c = made_camera(&s, eye, made_within(seed, world),
                                     made_between(seed, 10.0, 120.0), 1.6);
    for (int k = 0; i % 2 && k < 16; k += 4) // x becomes 1 - x
        c.to_ndc[k] = c.to_ndc[k + 3] - c.to_ndc[k];
    made_free(&s);
    return c;
}

static struct gp_frustum part_of(uint64_t *seed, const struct gp_camera *c,
                                 double x[2], double y[2], double z[2])
{
    x[0] = made_between(seed, display.x0, 70);
    x[1] = made_between(seed, x[0] + 1.0, display.x1);
    y[0] = made_between(seed, display.y0, 50);
    y[1] = made_between(seed, y[0] + 1.0, display.y1);
    z[0] = made_between(seed, 1e-3, 2.0);
    z[1] = z[0] + made_between(seed, 0.1, 30.0);
    return gp_frustum_make(c, display, x, y, z[0], z[1]);
}

static bool holds(const struct gp_volume *v, struct gp_v3 p, double slack)
{
    for (int i = 0; i < v->planes; i++) {
        if (gp_half_at(v->plane[i], p) > slack)
            return false;
    }
    return true;
}

/* Corners project to the corners of the rectangle, edges join the planes that
 * they name, and points are inside where their pixel and depth are. */
static void frusta(void **state)
{
    uint64_t seed = 11;
    int in = 0;
    for (int i = 0; i < 200; i++) {
        const struct gp_camera c = camera(&seed, i);
        double x[2], y[2], z[2];
        const struct gp_frustum f = part_of(&seed, &c, x, y, z);
        for (int k = 0; k < 8; k++) {
            const double p[3] = {f.corner[k].x, f.corner[k].y, f.corner[k].z};
            const struct gp_projected at =
                gp_camera_project(&c, display, p, 1.0);
            assert_true(fabs(at.x - x[k & 1]) < 1e-6 &&
                        fabs(at.y - y[k >> 1 & 1]) < 1e-6 &&
                        fabs(at.z - z[k >> 2]) < 1e-9);
        }
        for (int k = 0; k < 12; k++) {
            const struct gp_frustum_edge e = gp_frustum_edges[k];
            const struct gp_v3 a = f.corner[e.from], b = f.corner[e.to];
            const int plane[] = {e.with, e.against};
            for (int j = 0; j < 2; j++) {
                assert_true(fabs(gp_half_at(f.plane[plane[j]], a)) < 1e-9 &&
                            fabs(gp_half_at(f.plane[plane[j]], b)) < 1e-9);
            }
            // to the left of an edge, seen from outside `with`, is the face
            const struct gp_v3 left =
                gp_v3_cross(f.plane[e.with].n, gp_v3_sub(b, a));
            assert_true(f.turn * gp_half_at(f.plane[e.against],
                                            gp_v3_add(a, left)) < 0.0);
        }
        const struct gp_volume v = gp_frustum_volume(&f);
        const struct gp_v3 eye = gp_camera_eye(&c);
        for (int k = 0; k < 50; k++) {
            const struct gp_v3 to =
                mix(f.corner[k % 8], f.corner[(k / 8 + k) % 8],
                    made_random(&seed));
            const struct gp_v3 p = mix(eye, to, made_between(&seed, 0.0, 1.5));
            const double world[3] = {p.x, p.y, p.z};
            const struct gp_projected at =
                gp_camera_project(&c, display, world, 1.0);
            const bool want = !at.behind && at.x > x[0] && at.x < x[1] &&
                              at.y > y[0] && at.y < y[1] && at.z > z[0] &&
                              at.z < z[1];
            const bool wide = !at.behind && at.x > x[0] - 1e-4 &&
                              at.x < x[1] + 1e-4 && at.y > y[0] - 1e-4 &&
                              at.y < y[1] + 1e-4 && at.z > z[0] - 1e-9 &&
                              at.z < z[1] + 1e-9;
            assert_true(holds(&v, p, 1e-9) || !want);
            assert_true(!holds(&v, p, -1e-9) || wide);
            in += want;
        }
    }
    assert_true(in > 500);
}

/* The farthest that n reaches over points and light; of a light at infinity
 * INFINITY where n points to it. */
static double support(const struct gp_frustum *f, struct gp_from light,
                      struct gp_v3 n)
{
    double most = -INFINITY;
    for (int i = 0; i < 8; i++)
        most = fmax(most, gp_v3_dot(n, f->corner[i]));
    const double to = gp_v3_dot(n, light.p);
    return light.w > 0.0 ? fmax(most, to) : to > 1e-9 ? INFINITY : most;
}

/* A hull holds all segments from points of the frustum to the light, and each
 * of its planes touches frustum or light: it is no larger. A point that a plane
 * through the light and an edge parts from the frustum is not in it. */
static void hulls(void **state)
{
    static const struct gp_box world = {{-30, -30, -30}, {30, 30, 30}};
    uint64_t seed = 12;
    int same = 0, apart = 0;
    for (int i = 0; i < 2000; i++) {
        const struct gp_camera c = camera(&seed, i);
        double x[2], y[2], z[2];
        const struct gp_frustum f = part_of(&seed, &c, x, y, z);
        struct gp_from light = {made_within(&seed, world), 1.0};
        if (i % 3 == 0) { // in it, or near
            light.p = mix(mix(f.corner[0], f.corner[7], made_random(&seed)),
                          mix(f.corner[1], f.corner[6], made_random(&seed)),
                          made_between(&seed, -0.5, 1.5));
        } else if (i % 3 == 1) {
            light = (struct gp_from) {gp_v3_unit(light.p), 0.0};
        }
        const struct gp_volume v = gp_hull(&f, light);
        const struct gp_volume own = gp_frustum_volume(&f);
        if (light.w > 0.0 && holds(&own, light.p, 0.0)) {
            assert_int_equal(v.planes, 6);
            same++;
        }
        for (int k = 0; k < v.planes; k++)
            assert_true(fabs(support(&f, light, v.plane[k].n) + v.plane[k].d) <
                        1e-7);
        for (int k = 0; k < 40; k++) {
            struct gp_v3 p = f.corner[k % 8];
            for (int j = 0; j < 3; j++)
                p = mix(p, f.corner[(k * 5 + j * 3) % 8], made_random(&seed));
            const double t = made_random(&seed);
            p = light.w > 0.0 ? mix(p, light.p, t)
                              : gp_v3_add(p, gp_v3_scale(light.p, 100.0 * t));
            assert_true(holds(&v, p, v.slack));
            const struct gp_v3 none = {0, 0, 0};
            assert_false(gp_volume_misses(&v, p, none));
            // a step out over a plane is out
            const struct gp_half h = v.plane[k % v.planes];
            const struct gp_v3 q = gp_v3_add(
                p, gp_v3_scale(h.n, 1e-3 - gp_half_at(h, p)));
            assert_true(gp_volume_misses(&v, q, none));
            apart++;
        }
    }
    assert_true(same > 20 && apart > 1000);
}

SUITE_OF(frustum, NULL, NULL, frusta, hulls)
