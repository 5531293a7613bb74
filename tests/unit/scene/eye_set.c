/* The set E against rays through each object, and its tests of boxes and
 * spheres against points of them. */
#include "scene/scene_priv.h"

#include "scene/bounds.h"
#include "scene/rays.h"
#include "scene_made.h"

/* A direction within the disc. */
static struct gp_v3 within(const struct gp_eye_disc *d, uint64_t *seed)
{
    const struct gp_v3 side = fabs(d->to.z) < 0.9 ? (struct gp_v3) {0, 0, 1}
                                                  : (struct gp_v3) {1, 0, 0};
    const struct gp_v3 a = gp_v3_unit(gp_v3_cross(d->to, side));
    const struct gp_v3 b = gp_v3_cross(d->to, a);
    const double t = d->half * sqrt(made_random(seed));
    const double turn = made_between(seed, 0.0, 2.0 * MADE_PI);
    return gp_v3_add(
        gp_v3_scale(d->to, cos(t)),
        gp_v3_add(gp_v3_scale(a, sin(t) * cos(turn)),
                  gp_v3_scale(b, sin(t) * sin(turn))));
}

static double ball_way(const struct gp_eye_disc *d, struct gp_v3 along)
{
    const double m = d->distance * gp_v3_dot(along, d->to);
    const double square = m * m - d->distance * d->distance + d->ball * d->ball;
    return isfinite(d->distance) ? m - sqrt(fmax(square, 0.0)) : INFINITY;
}

/* A sun or a lamp at a random place around a random eye. */
static struct gp_eye_disc random_disc(uint64_t *seed)
{
    static const struct gp_box world = {{-15, -15, 0.5}, {15, 15, 9}};
    const struct gp_v3 eye = made_within(seed, world);
    const struct gp_v3 at = made_within(seed, world);
    if (made_random(seed) < 0.5)
        return gp_eye_lamp(eye, at, made_between(seed, 0.0, 1.0));
    return gp_eye_sun(eye, gp_v3_sub(at, eye),
                      made_random(seed) < 0.5 ? 0.00465
                                              : made_between(seed, 0.0, 0.6));
}

/* No object that a ray to the disc hits is left out. */
static void no_object_is_lost(void **state)
{
    enum { SCENES = 150, OBJECTS = 40, RAYS = 60 };
    uint64_t seed = 11;
    int kept = 0, hit = 0, sphere_alone = 0;
    for (int i = 0; i < SCENES; i++) {
        struct gp_scene s = made_random_scene(&seed, OBJECTS, 0);
        struct gp_rays rays[OBJECTS] = {{0}};
        struct gp_meshes meshes = {0};
        for (int k = 0; k < OBJECTS; k++)
            assert_ok(gp_rays_make(NULL, &s, &meshes, &k, 1, &rays[k]));
        for (int j = 0; j < 4; j++) {
            const struct gp_eye_disc d = random_disc(&seed);
            bool in[OBJECTS] = {0}, hits[OBJECTS] = {0};
            int object[OBJECTS];
            const int n = gp_eye_set(&s, &d, object);
            for (int k = 0; k < n; k++) {
                assert_true(k == 0 || object[k] > object[k - 1]);
                in[object[k]] = true;
            }
            for (int ray = 0; ray < RAYS; ray++) {
                const struct gp_v3 along = within(&d, &seed);
                for (int k = 0; k < OBJECTS; k++)
                    hits[k] = hits[k] ||
                              gp_rays_stopped(&rays[k], d.eye, along,
                                              ball_way(&d, along));
            }
            for (int k = 0; k < OBJECTS; k++) {
                if (hits[k] && !in[k])
                    fail_msg("scene %d, disc %d: object %d is lost", i, j, k);
                kept += in[k];
                hit += hits[k];
                sphere_alone += gp_eye_meets_sphere(&d, s.object[k].centre,
                                                    s.object[k].radius);
            }
        }
        for (int k = 0; k < OBJECTS; k++)
            gp_rays_free(&rays[k]);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
    print_message("# E: %d objects of %d discs, %d hit by rays, %d by spheres "
                  "alone\n", kept, 4 * SCENES, hit, sphere_alone);
    assert_true(hit > 500 && kept < 3 * hit && kept < sphere_alone);
}

/* A box meets a cone exactly when one of its points does: a search of the least
 * angle over its surface. */
static void boxes_as_their_points(void **state)
{
    enum { GRID = 24 };
    uint64_t seed = 12;
    static const struct gp_box world = {{-3, -3, -3}, {3, 3, 3}};
    int met = 0;
    for (int i = 0; i < 1500; i++) {
        const struct gp_v3 eye = made_within(&seed, world);
        const struct gp_eye_disc d =
            gp_eye_sun(eye, gp_v3_sub(made_within(&seed, world), eye),
                       made_between(&seed, 0.0, 0.8));
        const struct gp_box box = gp_box_with(
            gp_box_with(GP_BOX_EMPTY, made_within(&seed, world)),
            made_within(&seed, world));
        const struct gp_v3 size = gp_v3_sub(box.hi, box.lo);
        double least = INFINITY;
        bool held = true;
        for (int axis = 0; axis < 3; axis++) {
            const double e = axis == 0 ? eye.x : axis == 1 ? eye.y : eye.z;
            const double lo = axis == 0 ? box.lo.x : axis == 1 ? box.lo.y
                                                               : box.lo.z;
            const double hi = axis == 0 ? box.hi.x : axis == 1 ? box.hi.y
                                                               : box.hi.z;
            held = held && e >= lo && e <= hi;
        }
        for (int k = 0; k < 6 * (GRID + 1) * (GRID + 1); k++) {
            const int face = k / ((GRID + 1) * (GRID + 1));
            const double u = (double) (k % (GRID + 1)) / GRID;
            const double v = (double) (k / (GRID + 1) % (GRID + 1)) / GRID;
            const double f = face & 1;
            const struct gp_v3 t = face < 2   ? (struct gp_v3) {f, u, v}
                                   : face < 4 ? (struct gp_v3) {u, f, v}
                                              : (struct gp_v3) {u, v, f};
            const struct gp_v3 p = {box.lo.x + t.x * size.x - eye.x,
                                    box.lo.y + t.y * size.y - eye.y,
                                    box.lo.z + t.z * size.z - eye.z};
            least = fmin(least, acos(fmin(1.0, gp_v3_dot(gp_v3_unit(p),
                                                         d.to))));
        }
        const bool got = gp_eye_meets_box(&d, &box);
        if (!got && (held || least < d.half))
            fail_msg("box %d: lost at %g of %g", i, least, d.half);
        // the grid misses the least angle by up to a step of it
        if (got && !held && least > d.half + 0.35)
            fail_msg("box %d: kept at %g of %g", i, least, d.half);
        met += got;
    }
    assert_in_range(met, 200, 1300);
}

/* Spheres, and boxes of one point, at angles and distances that are known. */
static void places_that_are_known(void **state)
{
    const struct gp_v3 eye = {1, 2, 3};
    const struct gp_eye_disc sun =
        gp_eye_sun(eye, (struct gp_v3) {0, 5, 0}, 0.1);
    const struct gp_eye_disc lamp =
        gp_eye_lamp(eye, (struct gp_v3) {1, 12, 3}, 1.0);
    assert_true(fabs(sin(lamp.half) - 0.1) < 1e-15);
    static const struct {
        double angle, distance, radius;
        bool sun, lamp;
    } row[] = {
        {0.0, 5.0, 0.0, true, true},    {0.0999, 5.0, 0.0, true, true},
        {0.1005, 5.0, 0.0, false, false}, {0.3, 5.0, 0.9, false, false},
        {0.3, 5.0, 1.1, true, true},    {3.1, 5.0, 4.9, false, false},
        {3.1, 5.0, 5.1, true, true},    {0.0, 9.9, 0.0, true, true},
        {0.0, 11.0, 0.5, true, false},  {0.0, 12.0, 2.1, true, true},
        {0.0, 1e9, 1.0, true, false},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        const struct gp_v3 p = {
            eye.x + row[i].distance * sin(row[i].angle),
            eye.y + row[i].distance * cos(row[i].angle), eye.z};
        const struct gp_box box = {p, p};
        if (gp_eye_meets_sphere(&sun, p, row[i].radius) != row[i].sun ||
            gp_eye_meets_sphere(&lamp, p, row[i].radius) != row[i].lamp)
            fail_msg("row %zu", i);
        if (row[i].radius == 0.0) {
            assert_true(gp_eye_meets_box(&sun, &box) == row[i].sun);
            assert_true(gp_eye_meets_box(&lamp, &box) == row[i].lamp);
        }
    }
    assert_false(gp_eye_meets_box(&sun, &GP_BOX_EMPTY));
}

/* One triangle that hides all of a disc leaves no ray through; without one some
 * discs are hidden by many. */
static void one_triangle_hides_all(void **state)
{
    enum { SCENES = 100, RAYS = 40 };
    uint64_t seed = 13;
    int hidden = 0, others = 0;
    for (int i = 0; i < SCENES; i++) {
        struct gp_scene s = made_random_scene(&seed, 40, 0);
        struct gp_rays rays = {0};
        struct gp_meshes meshes = {0};
        int object[40];
        for (int k = 0; k < 40; k++)
            object[k] = k;
        assert_ok(gp_rays_make(NULL, &s, &meshes, object, 40, &rays));
        for (int j = 0; j < 10; j++) {
            const struct gp_eye_disc d = random_disc(&seed);
            const bool all = gp_eye_hidden(&s, &d, object, 40);
            bool open = false;
            for (int k = 0; k < RAYS; k++) {
                const struct gp_v3 along = within(&d, &seed);
                open = open || !gp_rays_stopped(&rays, d.eye, along,
                                                ball_way(&d, along));
            }
            if (all && open)
                fail_msg("scene %d, disc %d shows", i, j);
            hidden += all;
            others += !all && !open;
        }
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
    print_message("# %d of %d discs hidden by one triangle, %d by more\n",
                  hidden, 10 * SCENES, others);
    assert_true(hidden > 100 && others < hidden);
}

SUITE_OF(eye_set, NULL, NULL, no_object_is_lost, boxes_as_their_points,
         places_that_are_known, one_triangle_hides_all)
