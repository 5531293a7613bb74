// SPDX-License-Identifier: Apache-2.0
/* Boxes and spheres of objects, against their vertices one by one. */
#include "scene/gltf/gltf_priv.h"

#include "scene_made.h"

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
            const struct gp_submesh *const p =
                &s.submesh[s.mesh[got->mesh].first];
            for (int j = p->first; j < p->first + p->count; j++)
                assert_true(gp_v3_length(gp_v3_sub(made_corner(&s, got, j),
                                                   gp_box_middle(&got->box))) <=
                            got->radius);
        }
        made_free(&s);
    }
}

/* Objects of a mesh of many vertices for their number are held by the
 * corners of its box: every vertex, and little more. */
static void large_mesh(void **state)
{
    enum { INDICES = 18720 }; // of the ball
    uint64_t seed = 3;
    struct gp_scene s = made_scene();
    const int ball = made_ball(&s, 0, 40);
    assert_int_equal(s.indices, INDICES);
    for (int i = 0; i <= (1 << 20) / INDICES; i++)
        made_put_along(
            &s, ball, (struct gp_v3) {i, 2, 3},
            (struct gp_v3) {1, 2, i % 3 + 1},
            (struct gp_v3) {made_random(&seed), 1, made_random(&seed)});
    for (int at = 0; at < s.objects; at++) {
        const struct gp_object want = s.object[at];
        struct gp_object *const o = &s.object[at];
        gp_bounds_set(&s, o);
        const struct gp_box both =
            gp_box_with(gp_box_with(o->box, want.box.lo), want.box.hi);
        assert_memory_equal(&both, &o->box, sizeof both);
        const double off = gp_v3_length(gp_v3_sub(gp_box_middle(&o->box),
                                                  gp_box_middle(&want.box)));
        assert_true(o->radius >= want.radius - off);
        assert_true(o->radius < 2.0 * want.radius);
        assert_true(o->radius > 1.1 * want.radius); // of corners
        s.objects--; // one object fewer: of vertices
        gp_bounds_set(&s, o);
        s.objects++;
        assert_true(fabs(o->radius - want.radius) < 1e-9 * want.radius);
    }
    made_free(&s);
}

SUITE_OF(bounds, NULL, NULL, vertices_of_objects, large_mesh)
