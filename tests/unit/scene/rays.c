// SPDX-License-Identifier: Apache-2.0
/* Rays through objects beside a test of every triangle in the world: moved,
 * sheared, mirrored, flat and far away ones. */
#include "scene/rays.h"

#include "kept_log.h"
#include "scene_made.h"

/* The first triangle that a ray meets, by each of the scene's. */
struct truth {
    double at, beside; // `beside`: the least distance from an edge, as a share
    bool found;
};

static int texel_of(int i, int n, enum gp_wrap wrap)
{
    const int period = wrap == GP_WRAP_MIRROR ? 2 * n : n;
    if (wrap == GP_WRAP_CLAMP)
        return i < 0 ? 0 : i < n ? i : n - 1;
    i = (i % period + period) % period;
    return i < n ? i : period - 1 - i;
}

/* Alpha of a texture: bilinear between the centres of texels. */
static double alpha_of(const struct gp_cutout *c, double u, double v)
{
    const int x = (int) floor(u * c->w - 0.5), y = (int) floor(v * c->h - 0.5);
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        const int at = x + i % 2, down = y + i / 2;
        sum += (1.0 - fabs(u * c->w - 0.5 - at)) *
               (1.0 - fabs(v * c->h - 0.5 - down)) / 65535.0 *
               c->alpha[texel_of(down, c->h, c->wrap[1]) * c->w +
                        texel_of(at, c->w, c->wrap[0])];
    }
    return sum;
}

static bool opaque(const struct gp_scene *s, const struct gp_material *m,
                   const uint32_t *v, const double share[3])
{
    double u = 0.0, w = 0.0, alpha = (double) m->base[3];
    if (!(m->cutoff > 0.0f))
        return true;
    for (int i = 0; i < 3; i++) {
        u += share[i] * (double) s->uv[2 * v[i]];
        w += share[i] * (double) s->uv[2 * v[i] + 1];
    }
    if (m->cutout >= 0)
        alpha *= alpha_of(&s->cutout[m->cutout], u, w);
    return alpha >= (double) m->cutoff;
}

static struct truth first_of_all(const struct gp_scene *s, struct gp_v3 from,
                                 struct gp_v3 along, double most)
{
    struct truth out = {.at = most, .beside = INFINITY};
    for (int k = 0; k < s->objects; k++) {
        const struct gp_object *const o = &s->object[k];
        const struct gp_mesh *const m = &s->mesh[o->mesh];
        for (int j = m->first; j < m->first + m->submeshes; j++) {
            const struct gp_submesh *const p = &s->submesh[j];
            for (int i = p->first; i < p->first + p->count; i += 3) {
                const struct gp_v3 a = made_corner(s, o, i);
                const struct gp_v3 b = made_corner(s, o, i + 1);
                const struct gp_v3 c = made_corner(s, o, i + 2);
                const struct gp_v3 n =
                    gp_v3_cross(gp_v3_sub(b, a), gp_v3_sub(c, a));
                const double slope = gp_v3_dot(n, along);
                const double area = gp_v3_dot(n, n);
                if (slope == 0.0 || area == 0.0)
                    continue;
                const double at = gp_v3_dot(n, gp_v3_sub(a, from)) / slope;
                const struct gp_v3 hit =
                    gp_v3_add(from, gp_v3_scale(along, at));
                const struct gp_v3 to[3] = {gp_v3_sub(a, hit),
                                            gp_v3_sub(b, hit),
                                            gp_v3_sub(c, hit)};
                const double share[3] = {
                    gp_v3_dot(n, gp_v3_cross(to[1], to[2])) / area,
                    gp_v3_dot(n, gp_v3_cross(to[2], to[0])) / area,
                    gp_v3_dot(n, gp_v3_cross(to[0], to[1])) / area};
                const double least =
                    fmin(fmin(share[0], share[1]), share[2]);
                if (at > 0.0 && at <= most)
                    out.beside = fmin(out.beside, fabs(least));
                if (at > 0.0 && at < out.at && least >= 0.0 &&
                    opaque(s, &s->material[p->material], s->index + i, share)) {
                    out.at = at;
                    out.found = true;
                }
            }
        }
    }
    return out;
}

/* Moves each object by a random matrix, and all of them by `far`; one in six is
 * flat. */
static void move_objects(struct gp_scene *s, uint64_t *seed, double far)
{
    for (int k = 0; k < s->objects; k++) {
        struct gp_object *const o = &s->object[k];
        double m[16] = {0};
        for (int i = 0; i < 12; i++)
            m[i] = i % 4 < 3 ? made_between(seed, -3.0, 3.0) : 0.0;
        if (k % 6 == 5) { // in the plane of two rows
            const double u = made_between(seed, -1.0, 1.0);
            for (int c = 0; c < 3; c++)
                m[4 + c] = k % 12 == 5 ? 0.0 : u * m[c];
        }
        for (int c = 0; c < 3; c++)
            m[12 + c] = made_between(seed, -8.0, 8.0) + far;
        m[15] = 1.0;
        memcpy(o->to_world, m, sizeof m);
        made_bounds(s, o);
    }
}

static void rays_meet_what_each_triangle_says(void **state)
{
    enum { SCENES = 24, OBJECTS = 30, RAYS = 400 };
    static const double offset[] = {0.0, 1e4, -3e6};
    uint64_t seed = 31;
    int found = 0, none = 0, unsure = 0;
    for (int i = 0; i < SCENES; i++) {
        const double far = offset[i % 3];
        struct gp_scene s = made_random_scene(&seed, OBJECTS, 0);
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        int object[OBJECTS];
        for (int k = 0; k < OBJECTS; k++)
            object[k] = k;
        move_objects(&s, &seed, far);
        assert_ok(gp_rays_make(NULL, &s, &meshes, object, OBJECTS, &rays));
        for (int k = 0; k < RAYS; k++) {
            const struct gp_box world = {{far - 15, far - 15, far - 15},
                                         {far + 15, far + 15, far + 15}};
            const struct gp_v3 from = made_within(&seed, world);
            struct gp_v3 along =
                gp_v3_scale(gp_v3_sub(made_within(&seed, world), from),
                            made_between(&seed, 0.1, 3.0));
            if (k % 16 == 0) // along an axis
                along = (struct gp_v3) {0.0, k % 32 ? 2.0 : -2.0, 0.0};
            const double most = k % 3 ? INFINITY : 1.0;
            const struct truth want = first_of_all(&s, from, along, most);
            struct gp_rays_hit hit = {.at = -1.0};
            const bool got = gp_rays_first(&rays, from, along, most, &hit);
            if (want.beside < 1e-7 * (1.0 + fabs(far))) {
                unsure++; // on an edge, as far as a double says
                continue;
            }
            if (got != want.found ||
                gp_rays_stopped(&rays, from, along, most) != got ||
                (got && !(fabs(hit.at - want.at) <
                          1e-6 * (1.0 + 1e-2 * fabs(far)))))
                fail_msg("scene %d, ray %d: %d at %.9g, not %d at %.9g", i, k,
                         got, hit.at, want.found, want.at);
            found += got;
            none += !got;
        }
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
    print_message("# %d rays stopped, %d free, %d on edges\n", found, none,
                  unsure);
    assert_true(found > 1000 && none > 1000 && unsure < found);
}

/* A card is cut out where its texture says so, however that is wrapped. */
static void cutouts_are_wrapped(void **state)
{
    uint64_t seed = 7;
    int stopped = 0, free = 0;
    for (int k = 0; k < 9; k++) {
        struct gp_scene s = made_scene();
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        const int one = 0, texture = made_holes(&s, 4, 1);
        const int card = made_card(&s, made_material(&s, 0.5f, texture));
        struct gp_cutout *const c = &s.cutout[texture];
        c->w = 3;
        c->wrap[0] = (enum gp_wrap) (k % 3);
        c->wrap[1] = (enum gp_wrap) (k / 3);
        for (int i = 0; i < 12; i++)
            c->alpha[i] = (uint16_t) made_between(&seed, 0, 65535);
        for (int i = 0; i < 2 * s.vertices; i++) // three times either way
            s.uv[i] = 6.0f * s.uv[i] - 3.0f;
        made_put(&s, card, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {2, 2, 1},
                 0);
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, 1, &rays));
        for (int i = 0; i < 400; i++) {
            const struct gp_v3 from = {made_between(&seed, -1, 1),
                                       made_between(&seed, -1, 1), 1.0};
            const struct gp_v3 down = {0, 0, -2};
            const struct truth want = first_of_all(&s, from, down, 1.0);
            if (gp_rays_stopped(&rays, from, down, 1.0) != want.found &&
                want.beside > 1e-6)
                fail_msg("wraps %d, ray %d: %d", k, i, !want.found);
            stopped += want.found;
            free += !want.found;
        }
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
    assert_true(stopped > 500 && free > 500);
}

/* Rays through the edge of two triangles, up to roundings of the place. */
static void no_ray_slips_through_an_edge(void **state)
{
    uint64_t seed = 3;
    (void) state;
    for (int k = 0; k < 20; k++) {
        struct gp_scene s = made_scene();
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        const int one = 0;
        made_put_along(&s, made_card(&s, 0), (struct gp_v3) {0.1, 0.2, 0.3},
                       (struct gp_v3) {3, 2, 1},
                       (struct gp_v3) {made_between(&seed, -1, 1),
                                       made_between(&seed, -1, 1), 0.7});
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, 1, &rays));
        const double *const m = s.object[0].to_world;
        for (int i = 0; i < 500; i++) {
            const double t = made_between(&seed, -0.5, 0.5); // from a to c
            const struct gp_v3 at = {m[12] + t * (m[0] + m[4]),
                                     m[13] + t * (m[1] + m[5]),
                                     m[14] + t * (m[2] + m[6])};
            const struct gp_v3 from = {made_between(&seed, -9, 9),
                                       made_between(&seed, -9, 9), 8.0};
            assert_true(gp_rays_stopped(&rays, from, gp_v3_sub(at, from), 2.0));
        }
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
}

/* Rays just inside the sides of a card, by far less than floats know, near the origin,
 * where lengths have roundings, and where floats of places are twice as far apart as
 * those of the card: none passes its box by. */
static void no_ray_passes_a_box_by(void **state)
{
    static const double half = 0.99999, high = 3.9999;
    uint64_t seed = 5;
    for (int far = 0; far < 2; far++) {
        struct gp_scene s = made_scene();
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        const int one = 0;
        const double middle = far * 4094.00013; // its side is rounded inwards
        made_put(&s, made_card(&s, 0), (struct gp_v3) {middle, middle, high},
                 (struct gp_v3) {2.0 * half, 2.0 * half, 1}, 0.0);
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, 1, &rays));
        int missed = 0;
        for (int i = 0; i < 20000; i++) {
            const double side = (i & 1 ? 1.0 : -1.0) * half * (1.0 - 1e-9);
            const double t = made_between(&seed, -half, half);
            const double scale = made_between(&seed, 0.1, 3.0);
            const double beside = far * made_between(&seed, 4096.1, 4097.0);
            const struct gp_v3 eye = {beside, beside, 0};
            const struct gp_v3 at = {middle + (i & 2 ? side : t),
                                     middle + (i & 2 ? t : side), high};
            missed += !gp_rays_stopped(&rays, eye,
                                       gp_v3_scale(gp_v3_sub(at, eye), scale),
                                       2.0 / scale);
        }
        if (missed > 0)
            fail_msg("%d missed, %s", missed, far ? "far" : "near");
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
}

/* Alpha that is the cut-off stops a ray, as glTF has it: of a material, and of a
 * texture times that. */
static void alpha_of_the_cutoff_is_opaque(void **state)
{
    for (int textured = 0; textured < 2; textured++) {
        struct gp_scene s = made_scene();
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        const int one = 0, holes = textured ? made_holes(&s, 4, 1) : -1;
        const int m = made_material(&s, 0.5f, holes);
        s.material[m].base[3] = 0.5f;
        made_put(&s, made_card(&s, m), (struct gp_v3) {0, 0, 0},
                 (struct gp_v3) {2, 2, 1}, 0);
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, 1, &rays));
        int stopped = 0;
        for (int i = 0; i < 16; i++) { // middles of texels
            const struct gp_v3 from = {0.5 * (i % 4) - 0.75,
                                       0.5 * (int) (i / 4) - 0.75, 1.0};
            stopped +=
                gp_rays_stopped(&rays, from, (struct gp_v3) {0, 0, -2}, 1.0);
        }
        assert_int_equal(stopped, textured ? 8 : 16);
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
}

/* An object of no height hides as one that has some; one that is a line or a
 * point hides nothing. */
static void flat_objects_hide(void **state)
{
    static const struct {
        double size[3];
        bool hides;
    } row[] = {{{2, 2, 1}, true},   {{2, 2, 1e-5}, true}, {{2, 2, 1e-12}, true},
               {{2, 2, 0}, true},   {{2, 2, -0.0}, true}, {{0, 2, 2}, false},
               {{2, 0, 0}, false},  {{0, 0, 0}, false},   {{-2, 2, 0}, true},
               {{2, 1e-5, 0}, true}};
    const struct gp_v3 down = {0.0, 0.0, -2.0};
    const double turn = 30.0 * MADE_PI / 180.0;
    for (size_t i = 0; i < COUNT(row); i++) {
        const bool strip = row[i].size[1] == 1e-5; // the ray is on its middle
        const struct gp_v3 from = {strip ? 0.3 * cos(turn) : 0.3,
                                   strip ? 0.3 * sin(turn) : 0.2, 9.0};
        struct gp_scene s = made_scene();
        struct gp_meshes meshes = {0};
        struct gp_rays rays = {0};
        struct gp_rays_hit hit = {.at = -1.0};
        const int one = 0;
        made_put(&s, made_ball(&s, 0, 6), (struct gp_v3) {0, 0, 1},
                 (struct gp_v3) {row[i].size[0], row[i].size[1],
                                 row[i].size[2]}, 30.0);
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, 1, &rays));
        if (gp_rays_first(&rays, from, down, INFINITY, &hit) != row[i].hides)
            fail_msg("row %zu hides or not", i);
        if (row[i].hides)
            assert_true(fabs(hit.at - 4.0 + 0.23 * row[i].size[2]) < 0.03);
        gp_rays_free(&rays);
        gp_meshes_free(&meshes);
        made_free(&s);
    }
}

/* Places that no number holds stop nothing, and hide no other object. */
static void places_without_end(void **state)
{
    struct gp_scene s = made_scene();
    struct gp_meshes meshes = {0};
    struct gp_rays rays = {0};
    int object[12];
    const int box = made_box(&s, 0);
    for (int i = 0; i < 12; i++) {
        const double size = i % 3 == 0 ? 1.0 : i % 3 == 1 ? 1e308 : NAN;
        const double m[16] = {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0,
                              5.0 * i, 0, 0, 1};
        object[i] = made_place(&s, box, m);
    }
    assert_ok(gp_rays_make(NULL, &s, &meshes, object, 12, &rays));
    for (int i = 0; i < 12; i += 3) {
        const struct gp_v3 from = {5.0 * i, 0.1, 2.0};
        assert_true(gp_rays_stopped(&rays, from, (struct gp_v3) {0, 0, -1},
                                    2.0));
        assert_false(gp_rays_stopped(&rays, from, (struct gp_v3) {0, 0, -1},
                                     1.0));
    }
    gp_rays_free(&rays);
    gp_meshes_free(&meshes);
    made_free(&s);
}

/* No object, and one without triangles, stop nothing. */
static void empty_trees_stop_nothing(void **state)
{
    struct gp_scene s = made_scene();
    struct gp_meshes meshes = {0};
    struct gp_rays rays = {0};
    const int one = 0;
    made_put(&s, made_open_box(&s, 0, 63), (struct gp_v3) {0, 0, 0},
             (struct gp_v3) {1, 1, 1}, 0.0);
    for (int n = 0; n < 2; n++) {
        assert_ok(gp_rays_make(NULL, &s, &meshes, &one, n, &rays));
        assert_false(gp_rays_stopped(&rays, (struct gp_v3) {0, 0, 9},
                                     (struct gp_v3) {0, 0, -1}, INFINITY));
        gp_rays_free(&rays);
    }
    gp_meshes_free(&meshes);
    made_free(&s);
}

SUITE_OF(rays, NULL, NULL, rays_meet_what_each_triangle_says,
         cutouts_are_wrapped, alpha_of_the_cutoff_is_opaque,
         no_ray_slips_through_an_edge, no_ray_passes_a_box_by,
         flat_objects_hide, places_without_end, empty_trees_stop_nothing)
