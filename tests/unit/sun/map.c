// SPDX-License-Identifier: Apache-2.0
/* sun/map: GL's sun maps equal the reference texel by texel, their sums in
 * each form are what it says they are, and what cannot be drawn is refused.
 * (Shares by each method against plain forms: tests/hard/sun.c.) */
#include "scene.h"
#include "gl/gl_priv.h"
#include "sun/mask/mask_priv.h"

static const struct gp_rect window = {-40, 25, 120, 125}; // 160 x 100

// -- sun maps ----------------------------------------------------------------

enum { CASES = 14 };

/* Inside, at an edge, at a corner, outside; whole numbers, which lie on the
 * lines between pixels; smaller than a pixel, larger than the frame; not to be
 * shown at all; before and behind what is there. */
static void cases(struct gp_light l[CASES])
{
    static const double at[CASES][3] = {
        {37.3, 70.8, 2.5}, {20.0, 60.0, 24.0}, {-41.0, 70.0, 9.0},
        {120.0, 125.0, 12.0}, {-300.0, 70.0, 8.0}, {50.0, 50.0, 0.0},
        {51.99, 52.01, 0.3}, {10.0, 75.0, 400.0}, {60.5, 60.5, 31.0},
        {80.0, 90.0, 10.0}, {NAN, 60.0, 5.0}, {1e300, -1e300, 1e300},
        {40.0, 75.0, 45.0}, {70.25, 80.75, 7.0},
    };
    for (int i = 0; i < CASES; i++)
        l[i] = light_at(at[i][0], at[i][1], at[i][2]);
    l[9].behind = true;
    l[8].depth = 12.0; // that of many samples: compared at equality
    l[8].bias = 0.0;
    l[12].depth = 15.1;
    l[13].depth = NAN;
}

/* Draws maps, and compares sums with those in double. */
static void assert_sums(struct machine *m, const struct sun_frame *f,
    const struct glarepp_light_params *p, struct gp_light *l, int n)
{
    measure(m, &f->o, p, false, l, n);
    for (int i = 0; i < n; i++) {
        const double want = gp_sun_map_reference(&f->o, p, &l[i], NULL);
        if (!(fabs(l[i].visibility - want) <= 1e-6))
            fail_msg("%s, light %d, pattern %d, map %d, sum %d, outside %d: "
                     "%.9g is %.9g", gp_gl_info(m->gl)->name, i, p->square,
                     p->side, p->bytes, p->outside, want, l[i].visibility);
    }
}

/* Maps of all lights, texel by texel, and their sums. */
static void try_lights(struct machine *m, const struct sun_frame *f,
                       struct glarepp_light_params p, struct gp_light *l, int n)
{
    const int side = p.side, texels = side * side;
    const int columns = (int) ceil(sqrt(n)), w = columns * side;
    const int h = (n + columns - 1) / columns * side;
    float *const atlas = malloc(4 * (size_t) w * (size_t) h * sizeof *atlas);
    float *const want = malloc(2 * (size_t) texels * sizeof *want);
    assert_true(atlas && want);
    assert_sums(m, f, &p, l, n);
    gp_target_read(m->gl, &m->map.atlas, 0, (struct gp_rect) {0, 0, w, h},
                   atlas);
    for (int k = 0; k < n * texels; k++) {
        const int i = k / texels, t = k % texels;
        const int x = i % columns * side + t % side;
        const float *const got =
            atlas + 4 * ((i / columns * side + t / side) * w + x);
        if (t == 0)
            (void) gp_sun_map_reference(&f->o, &p, &l[i], want);
        if (fabs((double) (got[0] - want[2 * t])) > 1e-6 ||
            fabs((double) (got[1] - want[2 * t + 1])) > 1e-6)
            fail_msg("%s, light %d, pattern %d, map %d, outside %d, texel %d: "
                "%.9g %.9g is %.9g %.9g", gp_gl_info(m->gl)->name, i,
                p.square, side, p.outside, t, (double) want[2 * t],
                (double) want[2 * t + 1], (double) got[0], (double) got[1]);
    }
    free(want);
    free(atlas);
}

/* All, for which the frame is uploaded, and the small ones, whose boxes are. */
static void try_params(struct machine *m, const struct sun_frame *f,
                       struct glarepp_light_params p)
{
    struct gp_light l[CASES];
    cases(l);
    try_lights(m, f, p, l, CASES);
    try_lights(m, f, p, l, 7);
}

/* Every pattern, planes, and outside, at sizes that go through all of each. */
static void maps_equal_the_reference(void **state)
{
    static const int sizes[] = {2, 4, 6, 8, 12, 16, 24, 32, 64};
    const int step = getenv("GLAREPP_TEST_QUICK") ? 5 : 1;
    for (int k = 0; k < 2 * 4 * 4; k += step) {
        struct sun_frame f;
        seed = 77u + (uint32_t) k;
        make_frame(&f, window, k % 4, 1 + k % 3);
        for (int i = 0; i < machine_count; i++) {
            const struct glarepp_light_params p = {
                .square = k % 8 / 4,
                .outside = (enum glarepp_outside) (k / 8),
                .side = sizes[(k + 4 * i) % 9],
            };
            try_params(machine_at(i), &f, p);
        }
        free_frame(&f);
    }
}

// -- sums --------------------------------------------------------------------

/* The paper's sum, on the CPU: 8 bits, a step rounded at a time, in two halves whose
 * dither is opposite; of a map of over 16 texels a side at most 16 x 16 means of
 * squares, in the middles of as many parts of it. */
static double byte_sum(const float *map, int side, bool weight)
{
    const int n = side > 32 ? 16 : side > 16 ? side / 2 : side;
    const int wide = side / n;
    double half[2] = {0.0};
    for (int t = 0; t < n * n; t++) {
        const int x = t % n, y = t / n;
        const int i = (int) ((x + 0.5) * side / n - wide / 2.0 + 0.5);
        const int j = (int) ((y + 0.5) * side / n - wide / 2.0 + 0.5);
        const double turn =
            0.7548777 * (i / wide + 1) + 0.5698403 * (j / wide + 1);
        const double dither = (floor(16.0 * (turn - floor(turn))) - 7.5) / 16.0;
        double mean = 0.0;
        for (int k = 0; k < wide * wide; k++)
            mean +=
                (double)
                    map[2 * ((j + k / wide) * side + i + k % wide) + weight] /
                (wide * wide);
        for (int k = 0; k < 2; k++)
            half[k] = fmin(255.0, half[k] + rint(mean * floor(256.0 / (n * n)) +
                                                 (k ? -dither : dither)));
    }
    return half[0] + half[1];
}

/* White and black texels only, so that nothing hangs on how GL rounds. */
static void bytes_are_the_papers(void **state)
{
    static const int sizes[] = {2, 4, 8, 12, 16, 20, 30, 32, 34, 64};
    struct sun_frame f;
    seed = 2; // in the quick form too
    make_frame(&f, window, WITH_DEPTH, 3);
    for (int k = 0; k < 10 * machine_count; k++) {
        struct machine *const m = machine_at(k / 10);
        const int size = sizes[k % 10];
        struct glarepp_light_params p = {.side = size, .bytes = true};
        struct gp_light l = light_at(30.3, 70.8, size / 2);
        float *const map = malloc(2 * (size_t) (size * size) * sizeof *map);
        measure(m, &f.o, &p, false, &l, 1);
        const double exact = gp_sun_map_reference(&f.o, &p, &l, map);
        const double r = byte_sum(map, size, false);
        const double g = byte_sum(map, size, true);
        assert_true(fabs(l.visibility - (g > 0.0 ? r / g : 0.0)) < 1e-6);
        if (size == 16) // a step, and the last one that does not fit
            assert_true(fabs(l.visibility - exact) <= 1.0 / 255.0);
        if (size >= 32 && !(fabs(l.visibility - exact) <= 0.02 && exact > 0.1))
            fail_msg("%d: %g, not %g", size, l.visibility, exact);
        free(map);
    }
    free_frame(&f);
}

/* Textures that cannot hold all boxes side by side, but the frame once; and
 * those that cannot hold that either, but a light's box. */
static void textures_may_be_small(void **state)
{
    static const struct {
        int most;
        double radius;
        gp_status want;
    } rows[] = {
        {128, 40.0, GP_OK}, {80, 3.0, GP_OK}, {32, 8.0, GP_OK},
        {32, 40.0, GP_ERR_GL},
    };
    struct sun_frame f;
    make_frame(&f, window, WITH_DEPTH | WITH_MASK, 2);
    for (int k = 0; k < 4 * machine_count; k++) {
        struct machine *const m = machine_at(k / 4);
        const struct glarepp_light_params p = {.side = 8};
        const int limit = m->gl->info.max_size;
        struct gp_light l[2] = {light_at(40.3, 75.2, rows[k % 4].radius),
                                light_at(45.3, 75.2, rows[k % 4].radius)};
        m->gl->info.max_size = rows[k % 4].most;
        gp_sun_map_close(m->gl, &m->map); // its textures may be larger
        const gp_status st =
            gp_sun_by_gl(&kept_log, m->gl, &f.o, &p, l, 2, &m->map);
        if (!rows[k % 4].want)
            assert_sums(m, &f, &p, l, 2);
        m->gl->info.max_size = limit;
        gp_sun_map_close(m->gl, &m->map);
        assert_int_equal(st, rows[k % 4].want);
    }
    free_frame(&f);
}

static void refused(struct machine *m, const struct gp_occluders *o, int map,
                    int n, const char *parameter)
{
    const struct glarepp_light_params p = {.side = map};
    static struct gp_light l[GP_LIGHTS_MAX];
    for (int i = 0; i < GP_LIGHTS_MAX; i++)
        l[i] = light_at(30.0, 60.0, 4.0);
    kept_clear();
    assert_int_equal(gp_sun_by_gl(&kept_log, m->gl, o, &p, l, n, &m->map),
                     GP_ERR_GL);
    assert_string_equal(kept_parameter, parameter);
}

static void what_is_too_large_is_refused(void **state)
{
    const struct gp_occluders o = {.frame = window};
    const struct gp_occluders wide = {.frame = {0, 0, 1 << 25, 1}};
    for (int i = 0; i < machine_count; i++) {
        struct machine *const m = machine_at(i);
        refused(m, &o, 256, 1024, "lights.side");
        refused(m, &wide, 16, 1, "lights.method");
    }
}

SUITE_OF(map, open_machines, close_machines, maps_equal_the_reference,
         bytes_are_the_papers, textures_may_be_small,
         what_is_too_large_is_refused)
