// SPDX-License-Identifier: Apache-2.0
/* The paper's renderer: batches are counted as 15.2.1 counts them; surfaces have
 * the distance and the light that rays and formula give. */
#include "unit.h"
#include "gl_open.h"
#include "core/memory.h"
#include "scene/sets/sets_priv.h"
#include "scene_made.h"

enum { W = 96, H = 64 };

static struct gp_gl *gl;
static struct gp_scene scene;
static struct gp_camera camera;
static float picture[4 * W * H], depth[W * H];
static int every[16];

static int set_up(void **state)
{
    (void) state;
    gl = open_or_skip(GP_GL_AUTO);
    scene = made_scene();
    for (int i = 0; i < 16; i++)
        every[i] = i;
    return 0;
}

static int tear_down(void **state)
{
    (void) state;
    made_free(&scene);
    gp_gl_close(&gl);
    return 0;
}

/* A submesh of the triangles since the last one, of a material of its own. */
static int mesh_of_parts(int parts)
{
    const int mesh = made_box(&scene, made_material(&scene, 0.0f, -1));
    struct gp_mesh *const m = &scene.mesh[mesh];
    struct gp_submesh *const last = &scene.submesh[m->first];
    const int whole = last->count;
    assert_int_equal(whole, 36);
    last->count = 3;
    for (int i = 1; i < parts; i++) {
        MADE_GROW(scene.submesh, scene.submeshes);
        scene.submesh[scene.submeshes++] = (struct gp_submesh) {
            .first = scene.submesh[m->first].first + 3 * i,
            .count = i + 1 < parts ? 3 : whole - 3 * i,
            .material = made_material(&scene, 0.0f, -1),
        };
        scene.mesh[mesh].submeshes++;
    }
    return mesh;
}

static struct gp_drawing *open_drawing(bool separate, int map)
{
    const struct glarepp_sets_params p = {
        .w = W, .h = H, .near = 0.05, .light_scale = 1.0, .map = map,
        .separate = separate,
    };
    struct gp_drawing *d = NULL;
    if (gp_drawing_open(&kept_log, gl, &scene, &camera, &p, &d) != GP_OK)
        fail_msg("%s", kept_line);
    return d;
}

static struct gp_draw_light light_of(int i, int shadows)
{
    struct gp_box all = GP_BOX_EMPTY;
    for (int k = 0; k < scene.objects; k++) {
        all = gp_box_with(all, scene.object[k].box.lo);
        all = gp_box_with(all, scene.object[k].box.hi);
    }
    return (struct gp_draw_light) {
        .light = &scene.light[i],
        .shadow = every,
        .lit = every,
        .shadows = shadows,
        .lits = scene.objects,
        .cut = {0, 0, W, H},
        .all = all,
    };
}

/* Eight parts of a room, three models of two parts, three lights: 14 batches,
 * and 14 + 14 for each light. With a shadow batch for each model and one for
 * the room, 14 + 3 (4 + 14). */
static void batches_are_those_of_the_paper(void **state)
{
    const int room = mesh_of_parts(8), model = mesh_of_parts(2);
    made_put(&scene, room, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {9, 9, 9},
             0);
    for (int i = 0; i < 3; i++) {
        made_put(&scene, model, (struct gp_v3) {i - 1, 1, -1},
                 (struct gp_v3) {1, 1, 1}, 20.0 * i);
        made_point(&scene, (struct gp_v3) {2 - i, -1, 2}, 10.0, 40.0);
    }
    camera = made_camera(&scene, (struct gp_v3) {0, -4, 0},
                         (struct gp_v3) {0, 0, 0}, 50.0, (double) W / H);
    for (int separate = 0; separate < 2; separate++) {
        struct gp_drawing *d = open_drawing(separate, 64);
        struct glarepp_sets_row n = {0};
        gp_drawing_clear(d, &n);
        assert_ok(gp_drawing_ambient(d, every, 4));
        for (int i = 0; i < 3; i++) {
            const struct gp_draw_light l = light_of(i, 4);
            assert_ok(gp_drawing_light(d, &l));
        }
        assert_int_equal(n.batches, separate ? 98 : 68);
        assert_int_equal(n.shadow_batches, separate ? 42 : 12);
        assert_int_equal(n.passes, 7);
        assert_int_equal(n.lights, 3);
        struct gp_draw_light none = light_of(0, 4);
        none.lits = 0; // an empty I skips the light
        assert_ok(gp_drawing_light(d, &none));
        assert_int_equal(n.batches, separate ? 98 : 68);
        gp_drawing_close(&d);
    }
}

/* True where a triangle is on the way from p to p + t, apart from its ends. */
static bool blocked(struct gp_v3 p, struct gp_v3 t)
{
    for (int o = 0; o < scene.objects; o++) {
        const struct gp_mesh *const m = &scene.mesh[scene.object[o].mesh];
        const struct gp_submesh *const submesh = &scene.submesh[m->first];
        for (int k = submesh->first; k < submesh->first + submesh->count;
             k += 3) {
            const struct gp_v3 a = made_corner(&scene, &scene.object[o], k);
            const struct gp_v3 b = gp_v3_sub(
                made_corner(&scene, &scene.object[o], k + 1), a);
            const struct gp_v3 c = gp_v3_sub(
                made_corner(&scene, &scene.object[o], k + 2), a);
            const struct gp_v3 from = gp_v3_sub(p, a);
            const double det = gp_v3_det(b, c, gp_v3_scale(t, -1.0));
            const double u = gp_v3_det(from, c, gp_v3_scale(t, -1.0)) / det;
            const double v = gp_v3_det(b, from, gp_v3_scale(t, -1.0)) / det;
            const double at = gp_v3_det(b, c, from) / det;
            if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && at > 1e-4 &&
                at < 1.0 - 1e-4)
                return true;
        }
    }
    return false;
}

/* Light of the formula on the ground z = 0 at p, shadows by rays. */
static double light_on_ground(const struct gp_scene_light *l, struct gp_v3 p)
{
    const bool sun = l->kind == GP_LIGHT_DIRECTIONAL;
    const struct gp_v3 to = sun ? gp_v3_scale(l->along, -100.0)
                                : gp_v3_sub(l->at, p);
    const double d = gp_v3_length(to), cosine = to.z / d;
    double light = sun ? l->intensity : l->intensity / (d * d);
    if (!sun)
        light *= fmax(1.0 - pow(d / l->range, 4.0), 0.0);
    if (l->kind == GP_LIGHT_SPOT) {
        const double x = (-gp_v3_dot(to, l->along) / d - cos(l->outer)) /
                         (cos(l->inner) - cos(l->outer));
        light *= x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : x * x;
    }
    return blocked(p, to) || cosine <= 0.0 ? 0.0
           : 0.5 / MADE_PI * light * cosine;
}

/* Direction of a pixel's centre, 1 long along the view axis. */
static struct gp_v3 ray_of(struct gp_v3 eye, struct gp_v3 at, double degrees,
                           int x, int y)
{
    const double half = tan(degrees * MADE_PI / 360.0);
    const struct gp_v3 f = gp_v3_unit(gp_v3_sub(at, eye));
    const struct gp_v3 r = gp_v3_unit(
        gp_v3_cross(f, (struct gp_v3) {0, 0, 1}));
    const struct gp_v3 u = gp_v3_cross(r, f);
    return gp_v3_add(f, gp_v3_add(
        gp_v3_scale(r, half * W / H * (2.0 * (x + 0.5) / W - 1.0)),
        gp_v3_scale(u, half * (1.0 - 2.0 * (y + 0.5) / H))));
}

/* Boxes on a ground below lights of all kinds; the ground's pixels are compared
 * with rays. A map's texels decide at the edges of shadows. */
static void light_is_that_of_the_formula(void **state)
{
    const int box = made_box(&scene, made_material(&scene, 0.0f, -1));
    made_put(&scene, made_card(&scene, 0), (struct gp_v3) {0, 0, 0},
             (struct gp_v3) {60, 60, 1}, 0);
    made_put(&scene, box, (struct gp_v3) {1, 1, 1}, (struct gp_v3) {1, 1, 1},
             30.0);
    made_put(&scene, box, (struct gp_v3) {-2, 0, 1.5},
             (struct gp_v3) {0.5, 2, 1}, 10.0);
    made_point(&scene, (struct gp_v3) {0.2, 0.3, 4}, 100.0, 20.0);
    made_spot(&scene, (struct gp_v3) {3, -1, 5}, (struct gp_v3) {-0.5, 0.2, -1},
              200.0, 30.0, 20.0, 35.0);
    made_spot(&scene, (struct gp_v3) {-3, -1, 3}, (struct gp_v3) {1, 0.2, -1},
              200.0, 30.0, 20.0, 70.0);
    made_sun(&scene, (struct gp_v3) {0.3, 0.4, -1}, 5.0);
    const struct gp_v3 eye = {1, -7, 5};
    camera = made_camera(&scene, eye, (struct gp_v3) {0, 1, 0}, 45.0,
                         (double) W / H);
    struct gp_drawing *d = open_drawing(false, 256);
    for (int i = 0; i < 4; i++) {
        int ground = 0, lit = 0, wrong = 0;
        struct gp_draw_light l = light_of(i, 3);
        if (i == 3)
            l.all = (struct gp_box) {{-9, -9, 0}, {9, 9, 2}};
        struct glarepp_sets_row counts = {0};
        gp_drawing_clear(d, &counts);
        assert_ok(gp_drawing_ambient(d, every, 3));
        assert_ok(gp_drawing_light(d, &l));
        gp_drawing_picture(d, picture);
        gp_drawing_depth(d, depth);
        for (int y = 0; y < H; y++) {
            for (int x = 0; x < W; x++) {
                const struct gp_v3 to = ray_of(eye, (struct gp_v3) {0, 1, 0},
                                               45.0, x, y);
                const double z = (double) depth[y * W + x];
                const struct gp_v3 q = gp_v3_add(eye, gp_v3_scale(to, z));
                if (fabs(q.z) > 1e-4 || fmax(fabs(q.x), fabs(q.y)) > 9.0)
                    continue; // another surface, or beside the sun's map
                const double want = light_on_ground(&scene.light[i], q);
                const double got = (double) picture[4 * (y * W + x)];
                ground++;
                lit += want > 0.0;
                wrong += fabs(got - want) > 1e-3 * want + 1e-6;
            }
        }
        if (ground < W * H / 3 || lit < 300 || wrong * 50 > ground)
            fail_msg("light %d: %d of %d pixels of the ground are wrong, %d lit",
                     i, wrong, ground, lit);
    }
    gp_drawing_close(&d);
}

SUITE_OF_EACH(draw, set_up, tear_down, batches_are_those_of_the_paper,
              light_is_that_of_the_formula)
