/* Tests of groups against the test of each box alone. */
#include "scene/groups.h"

#include "scene/bounds.h"
#include "scene/scene_priv.h"
#include "scene_made.h"

/* Objects of every size, some beside each other at one place. */
static struct gp_scene crowd(uint64_t *seed, int objects)
{
    static const struct gp_box world = {{-20, -20, -20}, {20, 20, 20}};
    struct gp_scene s = made_random_scene(seed, objects, 3);
    for (int i = 0; i < s.objects; i += 7) {
        struct gp_object *const o = &s.object[i];
        const struct gp_v3 at =
            i % 2 ? made_within(seed, world) : (struct gp_v3) {1, 2, 3};
        o->to_world[12] = at.x;
        o->to_world[13] = at.y;
        o->to_world[14] = at.z;
        made_bounds(&s, o);
    }
    return s;
}

/* Every object that has a box is in one group. */
static void each_once(void **state)
{
    uint64_t seed = 71;
    for (int objects = 1; objects < 70; objects++) {
        struct gp_scene s = crowd(&seed, objects);
        int seen[80] = {0}, n = 0;
        struct gp_bodies *bodies;
        struct gp_groups g;
        s.object[objects / 2].box = GP_BOX_EMPTY;
        assert_ok(gp_bodies_make(NULL, &s, &bodies));
        assert_ok(gp_groups_make(NULL, &s, bodies, &g));
        for (int i = 0; i < GP_PACK * g.n; i++) {
            const unsigned used = g.pack[i / GP_PACK].used;
            if (!(used >> i % GP_PACK & 1))
                continue;
            seen[g.object[i]]++;
            n++;
        }
        for (int i = 0; i < s.objects; i++)
            assert_int_equal(seen[i], i != objects / 2);
        assert_int_equal(n, s.objects - 1);
        gp_groups_free(&g);
        gp_bodies_free(&bodies);
        made_free(&s);
    }
}

/* The sums of a check: both answers of each test were seen. */
struct sum {
    long reached, held, missed, all;
};

static void check_light(struct gp_groups *g, const struct gp_scene *s,
                        const struct gp_bodies *bodies,
                        const struct gp_scene_light *light, double texel,
                        const struct gp_volume *v, struct sum *sum)
{
    const struct gp_reach r = gp_light_reach(light);
    struct gp_darkest most = {0}, plain = {0};
    static struct gp_umbras u;
    struct gp_pack_hint hint = {0};
    gp_groups_near(g, &r);
    for (int i = 0; i < g->n; i++) {
        if (g->near[i])
            gp_groups_darkest(g, i, gp_groups_reached(g, i, &r), &r, &most);
    }
    for (int i = 0; i < s->objects; i++) {
        const struct gp_object *const o = &s->object[i];
        const struct gp_v3 c = gp_box_middle(&o->box), e = gp_box_half(&o->box);
        const double size = gp_darkest_size(bodies, o);
        if (size > 0.0 && !gp_reach_too_far(&r, c, e) &&
            !gp_reach_beside(&r, c, gp_object_radius(o, c)))
            gp_darkest_try(&plain, &r, c, size, i);
    }
    assert_int_equal(most.n, plain.n);
    for (int i = 0; i < most.n; i++)
        assert_int_equal(most.object[i], plain.object[i]);
    gp_umbras_make(&most, s, bodies, &r, &u);
    for (int i = 0; i < g->n; i++) {
        const struct gp_pack p = gp_groups_widen(g, i, &r, texel);
        const unsigned in = g->near[i] ? gp_groups_reached(g, i, &r) : 0;
        const unsigned held = gp_pack_held(&p, &u, p.used, &hint);
        const unsigned missed = gp_pack_missed(&p, v, p.used);
        for (int k = 0; k < GP_PACK; k++) {
            const struct gp_object *const o =
                &s->object[g->object[GP_PACK * i + k]];
            const struct gp_v3 c = gp_box_middle(&o->box);
            const double radius = gp_object_radius(o, c);
            const struct gp_v3 e = gp_box_half(&o->box);
            const struct gp_v3 wide = gp_texel_widen(&r, texel, c, e, radius);
            const bool reached = !gp_reach_too_far(&r, c, e) &&
                                 !gp_reach_beside(&r, c, radius);
            bool dark = false;
            for (int m = 0; m < u.n; m++)
                dark |= gp_umbra_holds(&u.umbra[m], c, wide);
            if (!(p.used >> k & 1))
                continue;
            assert_int_equal(in >> k & 1, reached);
            assert_int_equal(held >> k & 1, dark);
            assert_int_equal(missed >> k & 1, gp_volume_misses(v, c, wide));
            assert_true(!dark || gp_umbras_hold(&u, c, wide));
            sum->reached += reached;
            sum->held += dark;
            sum->missed += missed >> k & 1;
            sum->all++;
        }
    }
}

/* Each test of a group gives each box what the test of it alone gives: ranges,
 * cones, umbras, the largest occluders, hulls with the light. */
static void as_alone(void **state)
{
    static const struct gp_rect display = {0, 0, 64, 36};
    static const double x[2] = {3, 60}, y[2] = {2, 30};
    uint64_t seed = 72;
    struct sum sum = {0};
    for (int k = 0; k < 200; k++) {
        struct gp_scene s = crowd(&seed, 20 + 3 * k);
        static const struct gp_box world = {{-18, -18, 0}, {18, 18, 9}};
        const struct gp_v3 eye = made_within(&seed, world);
        const struct gp_camera c = made_camera(
            &s, eye, made_within(&seed, world), 70.0, 64.0 / 36.0);
        struct gp_bodies *bodies;
        struct gp_groups g;
        assert_ok(gp_bodies_make(NULL, &s, &bodies));
        assert_ok(gp_groups_make(NULL, &s, bodies, &g));
        for (int i = 0; i < s.lights; i++) {
            const struct gp_frustum f =
                gp_frustum_make(&c, display, x, y, 0.1, 5.0 + i * 10.0);
            const struct gp_volume v =
                gp_hull(&f, gp_light_reach(&s.light[i]).from);
            check_light(&g, &s, bodies, &s.light[i], k % 2 ? 0.02 : 0.0, &v,
                        &sum);
        }
        gp_groups_free(&g);
        gp_bodies_free(&bodies);
        made_free(&s);
    }
    assert_true(sum.all > 100000 && sum.reached > sum.all / 10 &&
                sum.reached < sum.all && sum.held > sum.all / 50 &&
                sum.missed > sum.all / 10 && sum.missed < sum.all);
}

SUITE_OF(groups, NULL, NULL, each_once, as_alone)
