// SPDX-License-Identifier: Apache-2.0
/* Sets against rays, and by the paper's figures.
 *
 *   build/tests/scene sets --time    times all sets of 10,000 objects and 100
 *                                    lights
 *   GLAREPP_SEED=N                   another seed; failures print the scene's */
#include "scene/sets/sets_priv.h"

#include "scene_shot.h"

#include <time.h>

enum { W = 20, H = 14 };

/* True where the picture shows the place of a light. */
static bool on_screen(const struct gp_camera *c,
                      const struct gp_scene_light *light)
{
    const bool sun = light->kind == GP_LIGHT_DIRECTIONAL;
    const struct gp_v3 at = sun ? gp_v3_scale(light->along, -1.0) : light->at;
    const double world[3] = {at.x, at.y, at.z};
    const struct gp_projected p = gp_camera_project(
        c, (struct gp_rect) {0, 0, W, H}, world, sun ? 0.0 : 1.0);
    return !p.behind && p.x >= 0 && p.x < W && p.y >= 0 && p.y < H;
}

static uint64_t first_seed(void)
{
    const char *const text = getenv("GLAREPP_SEED");
    return text ? strtoull(text, NULL, 10) : 60;
}

// -- against rays ------------------------------------------------------------

/* Counts of objects over all scenes. */
struct sum {
    long objects, f, v, seen;   // of frames
    long l, i, lit, s, casting; // of lights
    int off, lights;
};

static void check_light(const struct gp_scene *s, const struct shot *shot,
                        struct gp_sets *sets, int light, unsigned long long at,
                        struct sum *sum)
{
    bool lit[64] = {false}, casting[64] = {false};
    const struct gp_scene_light *const from = &s->light[light];
    const struct gp_scissor cut = gp_sets_light(sets, light);
    const uint8_t *const flag = gp_sets_flags(sets);
    const bool any = !gp_rect_empty(cut.rect);
    for (int k = 0; k < shot->pixels; k++) {
        const int o = shot->object[k];
        const double z = (double) shot->depth[k];
        if (o < 0 || !shot_reaches(from, shot->point[k]))
            continue;
        const int first = shot_blocker(s, from, shot->point[k]);
        // without a test of depth bounds all of its rectangle is drawn
        const int x = k % shot->w, y = k / shot->w;
        const bool drawn = x >= cut.rect.x0 && x < cut.rect.x1 &&
                           y >= cut.rect.y0 && y < cut.rect.y1 &&
                           (flag[o] & GP_SET_I) != 0;
        const bool in = drawn && z >= cut.near && z <= cut.far;
        if (first < 0) {
            lit[o] = true;
            if (!any || !in)
                fail_msg("GLAREPP_SEED=%llu: light %d, pixel %d, %d: object "
                         "%d is lit and not in I or the scissor", at, light,
                         k % shot->w, k / shot->w, o);
        } else if (drawn) { // it must stay dark
            casting[first] = true;
            if (!(flag[first] & GP_SET_S))
                fail_msg("GLAREPP_SEED=%llu: light %d, pixel %d, %d: object "
                         "%d casts a shadow and is not in S", at, light, x,
                         y, first);
        }
    }
    for (int i = 0; i < s->objects; i++) {
        sum->l += (flag[i] & GP_SET_L) != 0;
        sum->i += (flag[i] & GP_SET_I) != 0;
        sum->s += (flag[i] & GP_SET_S) != 0;
        sum->lit += lit[i];
        sum->casting += casting[i];
        assert_true(!(flag[i] & GP_SET_I) ||
                    ((flag[i] & GP_SET_V) && (flag[i] & GP_SET_L) && any));
        assert_true(!(flag[i] & GP_SET_S) || (flag[i] & GP_SET_L));
    }
    sum->lights++;
    sum->off += !on_screen(&shot->camera, from);
}

static void check_frame(const struct gp_scene *s, const struct shot *shot,
                        const struct gp_sets *sets, unsigned long long at,
                        struct sum *sum)
{
    bool seen[64] = {false};
    const uint8_t *const flag = gp_sets_flags(sets);
    for (int k = 0; k < shot->pixels; k++) {
        const int o = shot->object[k];
        if (o >= 0)
            seen[o] = true;
        if (o >= 0 && !(flag[o] & GP_SET_V))
            fail_msg("GLAREPP_SEED=%llu: object %d of pixel %d, %d is not in V",
                     at, o, k % shot->w, k / shot->w);
        const struct gp_v3 to = gp_v3_sub(shot->point[k], shot->eye);
        for (int i = 0; k % 5 == 0 && shot->w == W && i < s->objects; i++) {
            if (!(flag[i] & GP_SET_F) &&
                isfinite(ray_object(s, &s->object[i], shot->eye, to,
                                    SHOT_NEAR / 1e-3, 1e9)))
                fail_msg("GLAREPP_SEED=%llu: object %d behind pixel %d, %d is "
                         "not in F", at, i, k % shot->w, k / shot->w);
        }
    }
    for (int i = 0; i < s->objects; i++) {
        sum->f += (flag[i] & GP_SET_F) != 0;
        sum->v += (flag[i] & GP_SET_V) != 0;
        sum->seen += seen[i];
    }
    sum->objects += s->objects;
}

/* A random scene and a camera in it, whose picture shows light 0 or not. */
static struct gp_scene random_shot(uint64_t *seed, bool on, int objects,
                                   int size, struct shot *shot)
{
    static const struct gp_box world = {{-18, -18, 0.5}, {18, 18, 9}};
    struct gp_scene s = made_random_scene(seed, objects, 2);
    struct gp_camera c;
    struct gp_v3 eye;
    for (int tries = 0; tries < 200; tries++) {
        eye = made_within(seed, world);
        c = made_camera(&s, eye, made_within(seed, world),
                        made_between(seed, 30.0, 90.0), (double) W / H);
        if (on_screen(&c, &s.light[0]) == on)
            break;
    }
    shot_take(&s, c, eye, size * W, size * H, shot);
    return s;
}

/* Checks random scenes with pictures of size * W x size * H. */
static struct sum check_scenes(int scenes, uint64_t first, int size)
{
    static struct shot shot;
    struct sum n = {0};
    for (int k = 0; k < scenes; k++) {
        const uint64_t at = first + (uint64_t) k;
        uint64_t seed = at;
        struct gp_scene s = random_shot(&seed, at % 2 == 0, 16, size, &shot);
        struct gp_sets *sets;
        const struct gp_sets_view view = shot_view(&shot);
        assert_ok(gp_sets_open(NULL, &s, &view,
                               k % 4 ? GP_SETS_ALL
                                     : GP_SETS_ALL & ~GP_SETS_SCISSOR, &sets));
        check_frame(&s, &shot, sets, at, &n);
        for (int i = 0; i < s.lights; i++)
            check_light(&s, &shot, sets, i, at, &n);
        gp_sets_close(&sets);
        made_free(&s);
    }
    print_message("# sets: %d scenes, %d lights, %d of them off screen; "
                  "objects: %ld, F %ld, V %ld, seen by rays %ld; of lights: "
                  "L %ld, I %ld, lit by rays %ld, S %ld, casting by "
                  "rays %ld\n", scenes, n.lights, n.off, n.objects, n.f, n.v,
                  n.seen, n.l, n.i, n.lit, n.s, n.casting);
    // it is of use
    assert_true(n.v < n.f && n.f < n.objects && n.s < n.l);
    return n;
}

/* In 10,000 random scenes, half with the light off screen, no object is lost
 * that rays find to matter. GLAREPP_TEST_QUICK: in 500. */
static void nothing_is_lost(void **state)
{
    const int scenes = getenv("GLAREPP_TEST_QUICK") ? 500 : 10000;
    const struct sum n = check_scenes(scenes, first_seed(), 1);
    assert_true(n.off > n.lights / 3 && n.off < n.lights);
    assert_true(n.seen > 2 * scenes && n.lit > scenes && n.casting > scenes);
}

/* The same where the picture has 20 tiles. */
static void many_tiles(void **state)
{
    check_scenes(getenv("GLAREPP_TEST_QUICK") ? 40 : 800,
                 first_seed() + 20000, 4);
}

// -- surfaces that no object has ----------------------------------------------

/* Checks a light by the depths of a picture, which shows more than the scene.
 * Returns how many of its points are lit that no object has. */
static int check_shown(const struct gp_scene *s, const struct shot *shot,
                       struct gp_sets *sets, int light, unsigned long long at)
{
    const struct gp_scissor cut = gp_sets_light(sets, light);
    const uint8_t *const flag = gp_sets_flags(sets);
    const bool any = !gp_rect_empty(cut.rect);
    int lit = 0;
    for (int k = 0; k < shot->pixels; k++) {
        const double z = (double) shot->depth[k];
        const int x = k % shot->w, y = k / shot->w;
        if (shot->object[k] < 0 ||
            !shot_reaches(&s->light[light], shot->point[k]))
            continue;
        const int first = shot_blocker(s, &s->light[light], shot->point[k]);
        const bool drawn = any && x >= cut.rect.x0 && x < cut.rect.x1 &&
                           y >= cut.rect.y0 && y < cut.rect.y1;
        if (first < 0 && !(drawn && z >= cut.near && z <= cut.far))
            fail_msg("GLAREPP_SEED=%llu: light %d, pixel %d, %d is lit and not "
                     "in the scissor", at, light, x, y);
        if (first >= 0 && drawn && !(flag[first] & GP_SET_S))
            fail_msg("GLAREPP_SEED=%llu: light %d, pixel %d, %d: object %d "
                     "casts a shadow and is not in S", at, light, x, y, first);
        lit += first < 0 && shot->object[k] >= s->objects;
    }
    return lit;
}

/* The depths of a picture whose scene has lost objects, or all: no lit point is
 * outside the scissor, no object that shades one outside S. */
static void depths_show_more_than_objects(void **state)
{
    static struct shot shot;
    int lit = 0;
    for (int k = 0; k < 200; k++) {
        const uint64_t at = first_seed() + 40000 + (uint64_t) k;
        uint64_t seed = at;
        struct gp_scene s = random_shot(&seed, k % 2 == 0, 16, 4, &shot);
        struct gp_sets *sets;
        const struct gp_sets_view view = shot_view(&shot);
        const int objects = s.objects;
        s.objects = k % 4 * objects / 4;
        assert_ok(gp_sets_open(NULL, &s, &view,
                               GP_SETS_ALL | GP_SETS_DEPTHS, &sets));
        for (int i = 0; i < s.lights; i++)
            lit += check_shown(&s, &shot, sets, i, at);
        gp_sets_close(&sets);
        s.objects = objects;
        made_free(&s);
    }
    assert_true(lit > 1000);
}

static int count_set(const struct gp_scene *s, const struct gp_sets *sets,
                     unsigned set)
{
    int n = 0;
    for (int i = 0; i < s->objects; i++)
        n += (gp_sets_flags(sets)[i] & set) != 0;
    return n;
}

// -- the paper's figures -----------------------------------------------------

/* A ground, a camera at (0, -10, 2) that looks along y, and `things` boxes of
 * side 1 at places on it; the flags of each light are found one by one. */
static struct gp_scene figure(const struct gp_v3 *at, const struct gp_v3 *size,
                              int things, struct shot *shot)
{
    struct gp_scene s = made_scene();
    const int box = made_box(&s, 0), card = made_card(&s, 0);
    made_put(&s, card, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {99, 99, 1}, 0);
    for (int i = 0; i < things; i++)
        made_put(&s, box, at[i], size[i], 0.0);
    const struct gp_v3 eye = {0, -10, 2};
    const struct gp_camera c =
        made_camera(&s, eye, (struct gp_v3) {0, 0, 2}, 50.0, (double) W / H);
    shot_take(&s, c, eye, W, H, shot);
    return s;
}

static unsigned flags_of(const struct gp_scene *s, const struct shot *shot,
                         int light, int object)
{
    struct gp_sets *sets;
    const struct gp_sets_view view = shot_view(shot);
    assert_ok(gp_sets_open(NULL, s, &view, GP_SETS_ALL, &sets));
    gp_sets_light(sets, light);
    const unsigned flags = gp_sets_flags(sets)[object];
    gp_sets_close(&sets);
    return flags;
}

/* Figure 15-1: an object outside of the frustum casts a shadow into it; one
 * on the other side of the light does not. */
static void figure_15_1(void **state)
{
    static struct shot shot;
    const struct gp_v3 at[] = {{-9, 0, 1}, {-19, 0, 1}, {0, 0, 1}};
    const struct gp_v3 one[] = {{1, 1, 2}, {1, 1, 2}, {1, 1, 2}};
    struct gp_scene s = figure(at, one, 3, &shot);
    made_point(&s, (struct gp_v3) {-14, 0, 3}, 100.0, 30.0);
    const unsigned between = flags_of(&s, &shot, 0, 1);
    const unsigned beyond = flags_of(&s, &shot, 0, 2);
    const unsigned in = flags_of(&s, &shot, 0, 3);
    assert_int_equal(between, GP_SET_L | GP_SET_S);
    assert_int_equal(beyond, GP_SET_L);
    assert_int_equal(in, GP_SET_F | GP_SET_V | GP_SET_L | GP_SET_I | GP_SET_S);
    made_free(&s);
}

/* Figure 15-2: an object in the frustum that a wall hides is not in V, and
 * casts a shadow past the wall; the light is in the frustum. */
static void figure_15_2(void **state)
{
    static struct shot shot;
    const struct gp_v3 at[] = {{-2, 0, 2}, {-1.5, 4, 1}};
    const struct gp_v3 size[] = {{4, 0.2, 6}, {1, 1, 1}};
    struct gp_scene s = figure(at, size, 2, &shot);
    made_point(&s, (struct gp_v3) {-3, 6, 1.5}, 100.0, 30.0);
    const unsigned wall = flags_of(&s, &shot, 0, 1);
    const unsigned hidden = flags_of(&s, &shot, 0, 2);
    assert_true(wall & GP_SET_V);
    assert_int_equal(hidden, GP_SET_F | GP_SET_L | GP_SET_S);
    made_free(&s);
}

/* Space behind a mesh is dark where that is closed, convex, and lets no light
 * through. */
static void bodies_throw_umbras(void **state)
{
    struct gp_scene s = made_scene();
    const int holes = made_material(&s, 0.5f, made_holes(&s, 3, 4));
    const int clear = made_material(&s, 0.5f, -1);
    const int box = made_box(&s, 0), pole = s.vertices;
    const int dented = made_ball(&s, 0, 5); // by less than a hundredth
    const struct {
        int mesh;
        bool dark;
    } row[] = {
        {box, true},
        {made_ball(&s, 0, 5), true},
        {made_card(&s, 0), false},
        {dented, false},
        {made_open_box(&s, 0, 1), false},
        {made_box(&s, holes), false},
        {made_box(&s, clear), false},
    };
    const struct gp_rect window = {0, 0, W, H};
    const struct gp_sets_view view = {
        .camera = made_camera(&s, (struct gp_v3) {0, -9, 1},
                              (struct gp_v3) {0, 0, 1}, 50.0, (double) W / H),
        .display = window, .window = window, .near = SHOT_NEAR};
    s.material[clear].base[3] = 0.4f;
    s.position[3 * pole + 2] = -0.4f; // its ring is at -0.4045
    made_point(&s, (struct gp_v3) {0.1, 0.2, 9}, 100.0, 30.0);
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_sets *sets;
        s.objects = 0;
        made_put(&s, row[i].mesh, (struct gp_v3) {0, 0, 4},
                 (struct gp_v3) {4, 4, 4}, 20.0);
        made_put(&s, box, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {1, 1, 1},
                 0.0);
        assert_ok(gp_sets_open(NULL, &s, &view, GP_SETS_LIGHTS, &sets));
        gp_sets_light(sets, 0);
        if (!(gp_sets_flags(sets)[1] & GP_SET_L) != row[i].dark)
            fail_msg("row %zu is dark or not", i);
        gp_sets_close(&sets);
    }
    made_free(&s);
}

/* A depth that its renderer has rounded is that of the surface, before or behind
 * its box: the scissor holds it. */
static void rounded_depths_are_in_the_scissor(void **state)
{
    static const float off[] = {1.0f - 5e-4f, 1.0f, 1.0f + 5e-4f};
    static struct shot shot;
    struct gp_scene s = made_scene();
    const struct gp_v3 eye = {0, -10, 2};
    const struct gp_camera c =
        made_camera(&s, eye, (struct gp_v3) {0, 0, 2}, 50.0, (double) W / H);
    made_put(&s, made_box(&s, 0), (struct gp_v3) {0, 0, 2},
             (struct gp_v3) {4, 0, 4}, 0.0); // flat, across the view
    made_point(&s, (struct gp_v3) {0, -6, 2}, 100.0, 30.0);
    for (size_t i = 0; i < COUNT(off); i++) {
        struct gp_sets *sets;
        int seen = 0;
        shot_take(&s, c, eye, W, H, &shot);
        for (int k = 0; k < shot.pixels; k++)
            shot.depth[k] *= shot.object[k] < 0 ? 1.0f : off[i];
        const struct gp_sets_view view = shot_view(&shot);
        assert_ok(gp_sets_open(NULL, &s, &view, GP_SETS_ALL, &sets));
        const struct gp_scissor cut = gp_sets_light(sets, 0);
        for (int k = 0; k < shot.pixels; k++) {
            const double z = (double) shot.depth[k];
            if (shot.object[k] < 0)
                continue;
            seen++;
            if (!(k % W >= cut.rect.x0 && k % W < cut.rect.x1 &&
                  k / W >= cut.rect.y0 && k / W < cut.rect.y1 &&
                  z >= cut.near && z <= cut.far))
                fail_msg("%g of the depth: pixel %d, %d is cut off",
                         (double) off[i], k % W, k / W);
        }
        assert_true(seen > 20);
        gp_sets_close(&sets);
    }
    made_free(&s);
}

/* A point on a side of the frustum is in it, however its place is rounded. */
static void sides_of_the_frustum_are_in_it(void **state)
{
    enum { POINTS = 60 };
    uint64_t seed = 1;
    struct gp_scene s = made_scene();
    const struct gp_camera c =
        made_camera(&s, (struct gp_v3) {3, -10, 2},
                    (struct gp_v3) {0.3, 0.2, 1}, 50.0, (double) W / H);
    const struct gp_sets_view view = {.camera = c,
                                      .near = SHOT_NEAR,
                                      .display = {0, 0, W, H},
                                      .window = {0, 0, W, H}};
    const int box = made_box(&s, 0);
    struct gp_sets *sets;
    for (int i = 0; i < POINTS; i++) {
        const double at = made_random(&seed), far = made_between(&seed, 1, 50);
        made_put(&s, box,
                 gp_camera_point(&c, i % 2 ? at : i / 2 % 2,
                                 i % 2 ? i / 2 % 2 : at, far),
                 (struct gp_v3) {0, 0, 0}, 0.0);
    }
    assert_ok(gp_sets_open(NULL, &s, &view, GP_SETS_ALL, &sets));
    for (int i = 0; i < POINTS; i++)
        assert_true(gp_sets_flags(sets)[i] & GP_SET_F);
    gp_sets_close(&sets);
    made_free(&s);
}

/* An octahedron whose nearest corner is 5 % of its radius inside a spot's cone, or
 * outside, is what the spot lights, or not. */
static void corners_in_a_cone_are_lit(void **state)
{
    const double a = 20.0 * MADE_PI / 180.0;
    const struct gp_rect window = {0, 0, W, H};
    struct gp_scene s = made_scene();
    const struct gp_sets_view view = {
        .camera = made_camera(&s, (struct gp_v3) {0, -9, 0},
                              (struct gp_v3) {0, 0, 0}, 50.0, (double) W / H),
        .display = window,
        .window = window,
        .near = SHOT_NEAR};
    const int ball = made_ball(&s, 0, 2);
    struct gp_sets *sets;
    for (int i = 0; i < 2; i++) {
        const double off = i ? 1.05 : 0.95;
        made_put(&s, ball,
                 (struct gp_v3) {5.0 * sin(a) + off * cos(a),
                                 5.0 * cos(a) - off * sin(a), 0},
                 (struct gp_v3) {2, 2, 2}, -20.0);
    }
    made_spot(&s, (struct gp_v3) {0, 0, 0}, (struct gp_v3) {0, 1, 0}, 100.0,
              30.0, 10.0, 20.0);
    assert_ok(gp_sets_open(NULL, &s, &view, GP_SETS_LIGHTS, &sets));
    gp_sets_light(sets, 0);
    assert_true(gp_sets_flags(sets)[0] & GP_SET_L);
    assert_false(gp_sets_flags(sets)[1] & GP_SET_L);
    gp_sets_close(&sets);
    made_free(&s);
}

/* 15.2.1: 14 batches of ambient light, and for each of three lights all of them
 * for shadows and all for light: 98. */
static void example_of_98(void **state)
{
    struct gp_scene s = made_example();
    const struct gp_camera c =
        made_camera(&s, (struct gp_v3) {-3.5, -3.5, 2},
                    (struct gp_v3) {0, 0, 1}, 90.0, (double) W / H);
    const struct gp_rect window = {0, 0, W, H};
    const struct gp_sets_view view = {.camera = c, .display = window,
                                      .window = window, .near = SHOT_NEAR};
    struct gp_sets *sets;
    assert_ok(gp_sets_open(NULL, &s, &view, 0, &sets));
    int n = gp_sets_batches(sets, GP_SET_V);
    for (int i = 0; i < s.lights; i++) {
        assert_false(gp_rect_empty(gp_sets_light(sets, i).rect));
        n += gp_sets_batches(sets, GP_SET_S);
        n += gp_sets_batches(sets, GP_SET_I);
    }
    assert_int_equal(n, 98);
    gp_sets_close(&sets);
    made_free(&s);
}

// -- time --------------------------------------------------------------------

/* Processor time, which other processes do not change. */
static double cpu_ms(void)
{
    return 1e3 * (double) clock() / CLOCKS_PER_SEC;
}

/* A city: 10,000 objects on 220 x 220, as dense as the street of the data, and
 * 100 lamps with ranges of 9 to 40. */
static struct gp_scene city(uint64_t *seed)
{
    static const struct gp_box world = {{-110, -110, 0}, {110, 110, 6}};
    struct gp_scene s = made_random_scene(seed, 10000, 0);
    for (int i = 1; i < s.objects; i++) {
        struct gp_object *const o = &s.object[i];
        o->to_world[12] *= 5.5;
        o->to_world[13] *= 5.5;
        made_bounds(&s, o);
    }
    for (int i = 0; i < 100; i++) {
        const struct gp_v3 at = made_within(seed, world);
        const double range = made_between(seed, 9, 40);
        if (i % 3)
            made_point(&s, at, 100.0, range);
        else
            made_spot(&s, at, (struct gp_v3) {1, i % 5 - 2, -1}, 100.0, range,
                      10.0, 42.0);
    }
    return s;
}

/* Times all sets of a frame of 640 x 360. */
static void time_scene(const char *name, struct gp_scene s, struct gp_v3 eye)
{
    static const struct gp_rect big = {0, 0, 640, 360};
    const struct gp_camera c =
        made_camera(&s, eye, (struct gp_v3) {0, 0, 3}, 60.0, 16.0 / 9.0);
    float *const depth = calloc(640 * 360, sizeof *depth);
    const double far = 2.0 * gp_v3_length(eye);
    for (int i = 0; depth && i < 640 * 360; i++) // walls and a sky
        depth[i] = i < 640 * 90
                       ? 1e10f
                       : (float) (5.0 + far * (i % 640 / 80) / 7.0);
    const struct gp_sets_view view = {.camera = c, .display = big,
                                      .window = big, .near = SHOT_NEAR,
                                      .depth = depth};
    double least = INFINITY, frame = INFINITY;
    long sum[5] = {0};
    for (int run = 0; run < 7; run++) {
        struct gp_sets *sets;
        const double start = cpu_ms();
        assert_ok(gp_sets_open(NULL, &s, &view, GP_SETS_ALL, &sets));
        frame = fmin(frame, cpu_ms() - start);
        for (int i = 0; i < s.lights; i++)
            gp_sets_light(sets, i);
        least = fmin(least, cpu_ms() - start);
        for (int i = 0; run == 0 && i < s.lights; i++) {
            gp_sets_light(sets, i);
            for (unsigned k = 0; k < 5; k++)
                sum[k] += count_set(&s, sets, 1u << k);
        }
        gp_sets_close(&sets);
    }
    printf("%s: %d objects, %d lights: %.2f ms (F and V %.2f); F %ld, V %ld; "
           "mean of lights: L %.1f, I %.1f, S %.1f\n",
           name, s.objects, s.lights, least, frame, sum[0] / 100, sum[1] / 100,
           (double) sum[2] / 100, (double) sum[3] / 100, (double) sum[4] / 100);
    free(depth);
    made_free(&s);
}

static void time_sets(void)
{
    uint64_t seed = first_seed();
    const struct gp_v3 street = {0, -19, 3}, above = {0, -140, 80};
    time_scene("city, from a street", city(&seed), street);
    time_scene("city, all of it", city(&seed), above);
    time_scene("all in 40 x 40", made_random_scene(&seed, 10000, 100), street);
}

SUITE(sets)
{
    const CMUnitTestFunction tests[] = {
        nothing_is_lost,
        many_tiles,
        depths_show_more_than_objects,
        figure_15_1,
        figure_15_2,
        bodies_throw_umbras,
        example_of_98,
        sides_of_the_frustum_are_in_it,
        corners_in_a_cone_are_lit,
        rounded_depths_are_in_the_scissor,
    };
    if ((argc > 1 && strcmp(argv[1], "--time") == 0) || getenv("GLAREPP_TIME"))
        time_sets();
    return argc > 1 ? 0
                    : suite_run(tests, COUNT(tests),
                                "nothing_is_lost, many_tiles, "
                                "depths_show_more_than_objects, "
                                "figure_15_1, figure_15_2, "
                                "bodies_throw_umbras, example_of_98, "
                                "sides_of_the_frustum_are_in_it, "
                                "rounded_depths_are_in_the_scissor",
                                NULL, NULL, NULL, NULL);
}

