/* Bodies of meshes, and umbras against rays. */
#include "scene/sets/sets_priv.h"

#include "scene_rays.h"

static struct gp_v3 around(uint64_t *seed, double size)
{
    const struct gp_box box = {{-size, -size, -size}, {size, size, size}};
    return made_within(seed, box);
}

/* Faces, edges and points of bodies; meshes that are none. */
static void bodies(void **state)
{
    struct gp_scene s = made_scene();
    struct gp_body b;
    assert_true(gp_body_find(&s, made_box(&s, 0), &b));
    assert_int_equal(b.points, 8);
    assert_int_equal(b.faces, 6);
    assert_int_equal(b.edges, 12);
    assert_true(gp_body_find(&s, made_card(&s, 0), &b));
    assert_int_equal(b.points, 4);
    assert_int_equal(b.faces, 1);
    assert_int_equal(b.edges, 4);
    assert_true(gp_body_find(&s, made_ball(&s, 0, 5), &b));
    assert_int_equal(b.points, 42);
    assert_int_equal(b.faces, 50);
    assert_int_equal(b.edges, 90);

    // one that light goes through, or beside
    const int holes = made_material(&s, 0.5f, made_holes(&s, 3, 4));
    assert_false(gp_body_find(&s, made_card(&s, holes), &b));
    assert_false(gp_body_find(&s, made_box(&s, holes), &b));
    assert_false(gp_body_find(&s, made_open_box(&s, 0, 1), &b));
    const int clear = made_material(&s, 0.5f, -1);
    s.material[clear].base[3] = 0.4f;
    assert_false(gp_body_find(&s, made_box(&s, clear), &b));
    s.material[clear].base[3] = 0.6f;
    assert_true(gp_body_find(&s, made_box(&s, clear), &b));

    // two boxes in one mesh, an L of three squares, a box with a dent
    const int first = s.indices;
    made_box(&s, 0);
    for (int i = 0; i < 36; i++) {
        const float *const p = &s.position[3 * s.index[first + i]];
        const double at[] = {(double) p[0], (double) p[1], (double) p[2]};
        const int v = made_vertex(&s, at[0] + 2.0, at[1], at[2], 0.0, 0.0);
        if (i % 3 == 2)
            made_triangle(&s, v - 2, v - 1, v);
    }
    assert_false(gp_body_find(&s, made_part(&s, first, 0, false), &b));
    const int ell = s.indices;
    static const int corner[8][2] = {{0, 0}, {1, 0}, {2, 0}, {2, 1},
                                     {1, 1}, {1, 2}, {0, 2}, {0, 1}};
    const int v = s.vertices;
    for (int i = 0; i < 8; i++)
        made_vertex(&s, corner[i][0], corner[i][1], 0.0, 0.0, 0.0);
    made_quad(&s, v, v + 1, v + 4, v + 7);
    made_quad(&s, v + 1, v + 2, v + 3, v + 4);
    made_quad(&s, v + 7, v + 4, v + 5, v + 6);
    assert_false(gp_body_find(&s, made_part(&s, ell, 0, false), &b));
    const int dent = made_ball(&s, 0, 5);
    assert_true(gp_body_find(&s, dent, &b));
    float *const p =
        &s.position[3 * s.index[s.submesh[s.mesh[dent].first].first + 40]];
    for (int i = 0; i < 3; i++)
        p[i] *= 0.97f;
    assert_false(gp_body_find(&s, dent, &b));
    made_free(&s);
}

/* True where the body keeps the light from a point: the segment meets it. */
static bool dark(const struct gp_scene *s, struct gp_v3 p, struct gp_from light)
{
    const struct gp_v3 to =
        gp_v3_sub(light.p, gp_v3_scale(p, light.w));
    return ray_scene(s, p, to, 0.0, light.w > 0.0 ? 1.0 : 1e9).object >= 0;
}

static bool all_dark(const struct gp_scene *s, struct gp_v3 c, struct gp_v3 e,
                     struct gp_from light)
{
    const struct gp_box box = {gp_v3_sub(c, e), gp_v3_add(c, e)};
    for (int i = 0; i < 8; i++) {
        if (!dark(s, gp_box_corner(&box, i), light))
            return false;
    }
    return true;
}

/* A box is in the umbra exactly where rays from its corners meet the body: the
 * umbra is convex. */
static void against_rays(void **state)
{
    uint64_t seed = 41;
    int in = 0, out = 0, none = 0;
    for (int i = 0; i < 30000; i++) {
        struct gp_scene s = made_scene();
        const int mesh = i % 3 == 0   ? made_box(&s, 0)
                         : i % 3 == 1 ? made_card(&s, 0)
                                      : made_ball(&s, 0, 4);
        struct gp_v3 size = around(&seed, 3.0);
        if (i % 5) // not mirrored
            size = (struct gp_v3) {fabs(size.x), fabs(size.y), fabs(size.z)};
        made_put_along(&s, mesh, around(&seed, 2.0), size, around(&seed, 1.0));
        struct gp_from light = {around(&seed, 8.0), 1.0};
        if (i % 4 == 0)
            light = (struct gp_from) {gp_v3_unit(light.p), 0.0};
        struct gp_body b;
        assert_true(gp_body_find(&s, mesh, &b));
        struct gp_umbra u;
        gp_umbra_make(&b, s.object[0].to_world, light, &u);
        // on the far side of the body from the light, at some distance
        const struct gp_v3 to =
            light.w > 0.0 ? gp_v3_sub(s.object[0].centre, light.p)
                          : gp_v3_scale(light.p, -3.0);
        const struct gp_v3 c =
            gp_v3_add(gp_v3_add(s.object[0].centre, around(&seed, 0.7)),
                      gp_v3_scale(to, made_random(&seed)));
        struct gp_v3 e = around(&seed, 0.2);
        e = (struct gp_v3) {fabs(e.x), fabs(e.y), fabs(e.z)};
        const struct gp_v3 more = {e.x + 1e-3, e.y + 1e-3, e.z + 1e-3};
        const bool holds = gp_umbra_holds(&u, c, e);
        const bool flat = fmin(fmin(fabs(size.x), fabs(size.y)),
                               fabs(size.z)) < 0.05;
        assert_true(!holds || all_dark(&s, c, e, light));
        none += u.planes == 0;
        if (u.planes > 0 && !flat)
            assert_true(holds || !all_dark(&s, c, more, light));
        in += holds;
        out += !holds;
        made_free(&s);
    }
    assert_true(in > 9000 && out > 9000 && none > 0);
}

/* What touches a face of the body before the light, or is the body, is lit. */
static void not_itself(void **state)
{
    struct gp_scene s = made_scene();
    const int box = made_box(&s, 0), card = made_card(&s, 0);
    made_put(&s, box, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {2, 2, 2}, 30.0);
    made_put(&s, card, (struct gp_v3) {0, 0, 1}, (struct gp_v3) {1, 1, 1}, 0.0);
    made_put(&s, card, (struct gp_v3) {0, 0, -1}, (struct gp_v3) {1, 1, 1}, 0);
    struct gp_body b;
    assert_true(gp_body_find(&s, box, &b));
    struct gp_umbra u;
    gp_umbra_make(&b, s.object[0].to_world,
                  (struct gp_from) {{0.1, 0.2, 9}, 1.0}, &u);
    bool holds[3];
    for (int i = 0; i < 3; i++) {
        const struct gp_object *const o = &s.object[i];
        holds[i] = gp_umbra_holds(
            &u, o->centre, gp_v3_sub(o->box.hi, o->centre));
    }
    assert_false(holds[0]);
    assert_false(holds[1]);
    assert_true(holds[2]);
    // a light in the body has no umbra
    gp_umbra_make(&b, s.object[0].to_world,
                  (struct gp_from) {{0.1, 0.2, 0}, 1.0}, &u);
    assert_int_equal(u.planes, 0);
    made_free(&s);
}

SUITE_OF(umbra, NULL, NULL, bodies, against_rays, not_itself)
