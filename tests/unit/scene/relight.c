// SPDX-License-Identifier: Apache-2.0
/* Light of a scene on a frame's surfaces: that of the formula, shadows of what is
 * above them and off the picture, at any number of threads. */
#include "unit.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "kept_log.h"
#include "scene/rays.h"
#include "scene/relight.h"
#include "scene_made.h"

enum { W = 61, H = 37 };

static struct gp_scene scene;
static struct gp_meshes meshes;
static struct gp_surfaces surfaces;
static struct gp_plane z, normal[3], albedo[3];
static struct gp_planes rgb;
static int every[4] = {0, 1, 2, 3};
static const struct gp_rect all = {0, 0, W, H};
static const double colour[3] = {0.25, 0.5, 0.75};

static struct gp_plane plane(void)
{
    struct gp_plane p = {.window = all};
    assert_ok(gp_alloc_zero(NULL, "plane", W * H, sizeof *p.v, &p.v));
    return p;
}

/* A ground of which every pixel shows a part; a box above it, which none does. */
static int set_up(void **state)
{
    (void) state;
    scene = made_scene();
    made_put(&scene, made_card(&scene, 0), (struct gp_v3) {0, 0, 0},
             (struct gp_v3) {60, 60, 1}, 0);
    made_put(&scene, made_box(&scene, 0), (struct gp_v3) {0, 0, 3.5},
             (struct gp_v3) {1, 1, 0.5}, 20.0);
    const struct gp_v3 eye = {0.3, -6, 5};
    const struct gp_camera c = made_camera(&scene, eye, (struct gp_v3) {0, 0, 0},
                                           30.0, (double) W / H);
    z = plane();
    for (int k = 0; k < 3; k++) {
        normal[k] = plane();
        albedo[k] = plane();
    }
    surfaces = (struct gp_surfaces) {
        .rgb = &rgb, .data = all,
        .camera = c, .display = all, .z = &z, .normal = normal,
        .albedo = albedo,
    };
    for (int i = 0; i < W * H; i++) {
        const struct gp_v3 ray = gp_camera_ray(&c, all, i % W + 0.5,
                                               i / W + 0.5);
        const struct gp_v3 p = gp_v3_add(eye, gp_v3_scale(ray, -eye.z / ray.z));
        z.v[i] = (float) gp_camera_project(&c, all, (const double[3]) {
            p.x, p.y, p.z}, 1.0).z;
        normal[2].v[i] = 1.0f;
        for (int k = 0; k < 3; k++)
            albedo[k].v[i] = (float) colour[k];
    }
    assert_ok(gp_planes_make(NULL, "picture", W * H, &rgb));
    gp_planes_clear(&rgb, 0, W * H);
    return 0;
}

static int tear_down(void **state)
{
    (void) state;
    gp_plane_free(&z);
    for (int k = 0; k < 3; k++) {
        gp_plane_free(&normal[k]);
        gp_plane_free(&albedo[k]);
    }
    gp_planes_free(&rgb);
    gp_meshes_free(&meshes);
    made_free(&scene);
    return 0;
}

static struct glarepp_relit add(int light, int casters, struct gp_rect cut)
{
    struct glarepp_relit facts;
    const struct gp_relight_pass pass = {
        .light = &scene.light[light], .light_scale = 2.0, .caster = every,
        .casters = casters, .cut = cut, .far = INFINITY,
    };
    assert_ok(gp_relight(&kept_log, &scene, &meshes, &surfaces, &pass, 1,
                         &facts));
    return facts;
}

/* The formula's light on the ground at p. */
static double formula(const struct gp_scene_light *l, struct gp_v3 p)
{
    if (l->kind == GP_LIGHT_DIRECTIONAL)
        return -l->intensity * l->along.z;
    const struct gp_v3 to = gp_v3_sub(l->at, p);
    const double d = gp_v3_length(to);
    double light = l->intensity * to.z / (d * d * d) *
                   fmax(1.0 - pow(d / l->range, 4.0), 0.0);
    if (l->kind == GP_LIGHT_SPOT) {
        const double x = (-gp_v3_dot(to, l->along) / d - cos(l->outer)) /
                         (cos(l->inner) - cos(l->outer));
        light *= x <= 0.0 ? 0.0 : x >= 1.0 ? 1.0 : x * x;
    }
    return light;
}

/* True where the box is on the way of p's light, grown by `more`. */
static bool shaded(const struct gp_scene_light *l, struct gp_v3 p, double more)
{
    const struct gp_v3 to = l->kind == GP_LIGHT_DIRECTIONAL
                                ? gp_v3_scale(l->along, -100.0)
                                : gp_v3_sub(l->at, p);
    const double c = cos(20.0 * MADE_PI / 180.0),
                 s = sin(20.0 * MADE_PI / 180.0);
    for (int i = 0; i <= 2000; i++) { // the part of the way at its height
        const double t = (3.25 - more + (0.5 + 2 * more) * i / 2000.0) / to.z;
        const struct gp_v3 q = gp_v3_add(p, gp_v3_scale(to, t));
        if (t < 1.0 && fabs(q.x * c + q.y * s) < 0.5 + more &&
            fabs(q.y * c - q.x * s) < 0.5 + more)
            return true;
    }
    return false;
}

static void light_is_that_of_the_formula(void **state)
{
    made_point(&scene, (struct gp_v3) {0.4, 0.2, 6}, 100.0, 20.0);
    made_spot(&scene, (struct gp_v3) {1, -1, 6}, (struct gp_v3) {-0.2, 0.1, -1},
              100.0, 30.0, 10.0, 22.0);
    made_sun(&scene, (struct gp_v3) {0.1, 0.1, -1}, 3.0);
    for (int l = 0; l < 3; l++) {
        int dark = 0, lit = 0;
        gp_planes_clear(&rgb, 0, W * H);
        const struct glarepp_relit facts = add(l, 2, all);
        for (int i = 0; i < W * H; i++) {
            const struct gp_v3 ray = gp_camera_ray(&surfaces.camera, all,
                                                   i % W + 0.5, i / W + 0.5);
            const struct gp_v3 eye = gp_camera_eye(&surfaces.camera);
            const struct gp_v3 p =
                gp_v3_add(eye, gp_v3_scale(ray, -eye.z / ray.z));
            const double full = 2.0 / MADE_PI * formula(&scene.light[l], p);
            for (int c = 0; c < 3; c++) {
                const double got = (double) rgb.c[c][i];
                const double want = full * colour[c];
                // what the box hides by more or by less than its sides
                const bool dark_here = shaded(&scene.light[l], p, -0.3);
                const bool lit_here = !shaded(&scene.light[l], p, 0.3);
                const double slack = 1e-5 * want + 1e-7;
                if (dark_here ? got != 0.0
                    : lit_here ? fabs(got - want) > slack
                               : got < 0.0 || got > want + slack)
                    fail_msg("light %d at %d,%d: %g, not %g", l, i % W, i / W,
                             got, want);
                dark += got == 0.0 && want > 0.0;
                lit += got > 0.0;
            }
        }
        assert_true(dark > 30 && lit > 300);
        assert_int_equal(3 * facts.pixels, lit);
        assert_true(facts.rays >= facts.pixels);
    }
}

/* A surface is not in its own shadow where its normal is not quite that of its
 * triangles, as a curved mesh's is: places of a pixel are below them then. */
static void curved_surfaces_throw_no_shadow_on_themselves(void **state)
{
    static const float LEAN = 0.003f;
    float clear[W * H];
    (void) state;
    made_point(&scene, (struct gp_v3) {0.4, 0.2, 6}, 100.0, 20.0);
    for (int i = 0; i < W * H; i++)
        normal[1].v[i] = LEAN;
    add(0, 0, all);
    memcpy(clear, rgb.c[1], sizeof clear);
    gp_planes_clear(&rgb, 0, W * H);
    add(0, 1, all); // the ground alone
    for (int i = 0; i < W * H; i++)
        assert_true(rgb.c[1][i] >= clear[i]);
}

static void settings_of_a_pass_count(void **state)
{
    made_point(&scene, (struct gp_v3) {0.4, 0.2, 6}, 100.0, 20.0);
    float first[W * H];
    const double *const m = surfaces.camera.to_camera;
    add(0, 2, all);
    memcpy(first, rgb.c[1], sizeof first);
    // light is added; any threads; nothing outside the cut
    gp_set_threads(1);
    add(0, 2, (struct gp_rect) {-5, 0, 20, H});
    gp_set_threads(0);
    for (int i = 0; i < W * H; i++)
        assert_true(rgb.c[1][i] == (i % W < 20 ? first[i] + first[i]
                                               : first[i]));
    // axes of the camera
    for (int i = 0; i < W * H; i++) {
        for (int c = 0; c < 3; c++)
            normal[c].v[i] = (float) m[8 + c];
    }
    surfaces.normal_of_camera = true;
    // as in Blender, z along the view, no worldToCamera, a shifted lens
    for (int kind = 0; kind < 4; kind++) {
        struct gp_camera *const c = &surfaces.camera;
        const struct gp_camera usual = *c;
        for (int i = 0; i < 16; i++) {
            if (kind == 2 || (kind == 1 && i % 4 == 2))
                c->to_camera[i] *= kind == 2 ? 0.0 : -1.0;
            if (kind == 3 && i % 4 < 2)
                c->to_ndc[i] += 8.0 / (i % 4 ? H : W) * c->to_ndc[i / 4 * 4 + 3];
        }
        c->has_camera = kind != 2;
        if (kind == 3)
            surfaces.display = (struct gp_rect) {-8, -8, W - 8, H - 8};
        gp_planes_clear(&rgb, 0, W * H);
        add(0, 2, all);
        *c = usual;
        surfaces.display = all;
        for (int i = 0; i < W * H; i++)
            assert_true(fabsf(rgb.c[1][i] - first[i]) <=
                        1e-5f * first[i] + 1e-7f);
    }
    // no caster: no shadow; no albedo, no normal, no depth: no light
    gp_planes_clear(&rgb, 0, W * H);
    assert_true(add(0, 0, all).pixels == W * H);
    for (int y = 0; y < H; y++) {
        for (int x = 0; x < 6; x++) {
            const int i = y * W + x;
            if (x < 2)
                albedo[0].v[i] = albedo[1].v[i] = albedo[2].v[i] = 0.0f;
            else if (x < 4)
                normal[0].v[i] = normal[1].v[i] = normal[2].v[i] = NAN;
            z.v[i] = x < 4 ? z.v[i] : 1e10f;
        }
    }
    gp_planes_clear(&rgb, 0, W * H);
    add(0, 0, all);
    for (int i = 0; i < W * H; i++) // a neighbour's light may reach one pixel
        assert_true(i % W >= 4 || rgb.c[1][i] == 0.0f);
    for (int c = 0; c < 3; c++) {
        for (int i = 0; i < W * H; i++)
            assert_true(isfinite(rgb.c[c][i]));
    }
}

/* Rays find the nearest triangle, its normal and its material. */
static void first_triangle_is_found(void **state)
{
    static const struct {
        struct gp_v3 from, along;
        double most, at; // 0: none
        double z;        // of the normal, either side
    } rows[] = {
        {{0, 0, 10}, {0, 0, -1}, INFINITY, 6.25, 1.0}, // the box's top
        {{0, 0, 10}, {0, 0, -1}, 6.0, 0.0, 0.0},       // before it
        {{0, 0, 3}, {0, 0, -2}, INFINITY, 1.5, 1.0},   // the ground
        {{2, 2, 10}, {0, 0, -1}, INFINITY, 10.0, 1.0}, // beside the box
        {{9, 0, 3.5}, {-1, 0, 0}, 10.0, 8.5, 0.0},     // its side, near 0.5
        {{9, 0, 3.5}, {1, 0, 0}, INFINITY, 0.0, 0.0},
    };
    struct gp_rays rays = {0};
    assert_ok(gp_rays_make(&kept_log, &scene, &meshes, every, 2, &rays));
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_rays_hit hit = {.at = -1.0};
        const bool found = gp_rays_first(&rays, rows[i].from, rows[i].along,
                                         rows[i].most, &hit);
        assert_int_equal(found, rows[i].at > 0.0);
        assert_int_equal(gp_rays_stopped(&rays, rows[i].from, rows[i].along,
                                         rows[i].most), found);
        if (!found) {
            assert_true(hit.at == -1.0);
            continue;
        }
        assert_true(fabs(hit.at - rows[i].at) < 0.1);
        assert_true(fabs(fabs(hit.normal.z) - rows[i].z) < 1e-9);
        assert_true(fabs(gp_v3_length(hit.normal) - 1.0) < 1e-9);
        assert_int_equal(hit.material, 0);
    }
    gp_rays_free(&rays);
}

/* A pixel at the top edge of a wall: a sun lights the ground behind it by the
 * share that the frame's mean normal gives the ground. */
static void edges_have_the_shares_of_the_frame(void **state)
{
    const int x = W / 2, row = H / 2 - 5;
    const double shares[] = {0.38, 0.46, 0.54, 0.62};
    double low = 0.0, high = 3.0; // heights of the wall
    for (int i = 0; i < 50; i++) { // its edge in the middle of the row
        const double h = 0.5 * (low + high);
        const double y = gp_camera_project(&surfaces.camera, all,
            (const double[3]) {0.0, 0.0, h}, 1.0).y;
        *(y > row + 0.5 ? &low : &high) = h;
    }
    made_put(&scene, made_box(&scene, 0), (struct gp_v3) {0, 0, 0.5 * low},
             (struct gp_v3) {20, 1e-3, low}, 0);
    made_sun(&scene, (struct gp_v3) {0, 0, -1}, 3.0);
    surfaces.object = every;
    surfaces.objects = 3;
    for (int i = 0; i < 3 * W * H; i++)
        albedo[i % 3].v[i / 3] = 0.5f;
    const size_t at = (size_t) row * W + (size_t) x;
    for (size_t i = 0; i < COUNT(shares); i++) {
        const float s = (float) shares[i];
        normal[1].v[at] = s - 1.0f;
        normal[2].v[at] = s;
        gp_planes_clear(&rgb, 0, W * H);
        add(0, 0, all);
        const double got = (double) rgb.c[1][at] / (2.0 * 3.0 * 0.5 / MADE_PI);
        if (!(fabs(got - shares[i]) < 0.01))
            fail_msg("share %g: lit by %g", shares[i], got);
    }
}

/* Lights a frame by a sun, with an albedo that is k times that of a pattern, or
 * of one colour, and of no material. */
static void light_edges(float k, bool textured)
{
    for (int i = 0; i < W * H; i++) {
        const float part = textured ? 0.5f + 0.5f * (float) (i * 37 % 64) / 64
                                    : 1.0f;
        for (int c = 0; c < 3; c++)
            albedo[c].v[i] = k * part * (float) colour[c];
    }
    gp_planes_clear(&rgb, 0, W * H);
    add(1, 0, all);
}

/* The light added is proportional to the frame's albedo, at edges too, whose
 * materials have another. */
static void light_follows_albedo(void **state)
{
    float first[3][W * H];
    made_put(&scene, made_box(&scene, 0), (struct gp_v3) {-1, 1, 0.5},
             (struct gp_v3) {0.8, 0.8, 1.0}, 30);
    made_point(&scene, (struct gp_v3) {0.4, 0.2, 6}, 100.0, 20.0);
    made_sun(&scene, (struct gp_v3) {0, 0, -1}, 3.0);
    surfaces.object = every;
    for (int i = 0; i < W * H; i += 7) // pixels that look like edges
        normal[2].v[i] = 0.97f;
    for (int k = 0; k < 4; k++) {
        const bool textured = k % 2;
        surfaces.objects = k < 2 ? 1 : 3;
        light_edges(1.0f, textured);
        for (int c = 0; c < 3; c++)
            memcpy(first[c], rgb.c[c], sizeof first[c]);
        for (int i = 0; k < 2 && i < W * H; i++) {
            // a mixed pixel of the ground is as bright as the others
            const double want = 2.0 / MADE_PI * 3.0 *
                                (double) albedo[1].v[i];
            if (!(fabs((double) first[1][i] - want) <= 0.1 * want))
                fail_msg("%d,%d: %g, not %g", i % W, i / W,
                         (double) first[1][i], want);
        }
        light_edges(0.5f, textured);
        for (int c = 0; c < 3; c++) {
            for (int i = 0; i < W * H; i++)
                assert_true(fabsf(rgb.c[c][i] - 0.5f * first[c][i]) <=
                            1e-3f * first[c][i]);
        }
        light_edges(0.3f, textured);
        for (int i = 0; i < W * H; i++)
            assert_true(fabsf(rgb.c[0][i] - 0.3f * first[0][i]) <=
                        1e-3f * first[0][i]);
    }
}

/* Passes of one call give the bits of calls one after another. */
static void passes_of_a_call_are_calls(void **state)
{
    static const struct gp_rect cuts[] = {
        {0, 0, W, H}, {5, 3, 40, 30}, {30, -4, 90, 20}, {9, 9, 9, 20}};
    struct gp_relight_pass pass[COUNT(cuts)];
    struct glarepp_relit facts[COUNT(cuts)], one[COUNT(cuts)];
    float first[3][W * H];
    made_put(&scene, made_box(&scene, 0), (struct gp_v3) {-1, 1, 0.5},
             (struct gp_v3) {0.8, 0.8, 1.0}, 30);
    surfaces.object = every;
    surfaces.objects = 3;
    for (int i = 0; i < W * H; i += 7) // pixels that look like edges
        normal[2].v[i] = 0.9f;
    for (int i = 0; i < (int) COUNT(cuts); i++)
        made_point(&scene, (struct gp_v3) {0.4 - i, 0.2 + i, 6}, 100.0, 20.0);
    for (int i = 0; i < (int) COUNT(cuts); i++) {
        pass[i] = (struct gp_relight_pass) {
            .light = &scene.light[i], .light_scale = 2.0, .caster = every,
            .casters = 3, .cut = cuts[i], .far = INFINITY,
        };
        one[i] = add(i, 3, cuts[i]);
    }
    for (int c = 0; c < 3; c++)
        memcpy(first[c], rgb.c[c], sizeof first[c]);
    gp_planes_clear(&rgb, 0, W * H);
    assert_ok(gp_relight(&kept_log, &scene, &meshes, &surfaces, pass,
                         COUNT(cuts), facts));
    for (int c = 0; c < 3; c++)
        assert_memory_equal(rgb.c[c], first[c], sizeof first[c]);
    for (size_t i = 0; i < COUNT(cuts); i++) {
        assert_int_equal(facts[i].pixels, one[i].pixels);
        assert_int_equal(facts[i].rays, one[i].rays);
    }
    assert_true(facts[0].pixels > facts[1].pixels && facts[2].pixels > 100);
    assert_int_equal(facts[3].pixels, 0);
}

SUITE_OF_EACH(relight, set_up, tear_down, first_triangle_is_found,
              light_is_that_of_the_formula, edges_have_the_shares_of_the_frame,
              light_follows_albedo, settings_of_a_pass_count,
              curved_surfaces_throw_no_shadow_on_themselves,
              passes_of_a_call_are_calls)
