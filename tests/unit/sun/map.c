/* sun/map: GL's sun maps equal the reference texel by texel, their sums in
 * each form are what it says they are, readback is a plain count, masks are
 * near gp_sun_exact(), and what cannot be drawn is refused. */
#include "scene.h"
#include "gl/gl_priv.h"

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

/* GL's sums are near those in double. */
static void assert_sums(const struct machine *m, const struct sun_frame *f,
    const struct gp_map_params *p, struct gp_light *l, int n)
{
    assert_ok(gp_sun_map_read(&kept_log, m->gl, m->map, l, n));
    for (int i = 0; i < n; i++) {
        const double want = gp_sun_map_reference(&f->o, p, &l[i], NULL);
        if (!(fabs(l[i].visibility - want) <= 1e-6))
            fail_msg("%s, light %d, pattern %d, map %d, sum %d, outside %d: "
                     "%.9g is %.9g", gp_gl_info(m->gl)->name, i, p->pattern,
                     p->side, p->sum, p->outside, want, l[i].visibility);
    }
}

/* Maps of all lights, texel by texel, and both sums. */
static void try_lights(struct machine *m, const struct sun_frame *f,
                       struct gp_map_params p, struct gp_light *l, int n)
{
    const int side = p.side, texels = side * side;
    assert_ok(gp_sun_map_draw(&kept_log, m->gl, &f->o, &p, l, n, &m->map));
    const int columns = m->map->columns, w = columns * side;
    const int h = (n + columns - 1) / columns * side;
    float *const atlas = malloc(4 * (size_t) w * (size_t) h * sizeof *atlas);
    float *const want = malloc(2 * (size_t) texels * sizeof *want);
    assert_true(atlas && want);
    gp_target_read(m->gl, &m->map->atlas, 0, (struct gp_rect) {0, 0, w, h},
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
                p.pattern, side, p.outside, t, (double) want[2 * t],
                (double) want[2 * t + 1], (double) got[0], (double) got[1]);
    }
    free(want);
    free(atlas);
    assert_sums(m, f, &p, l, n);
    p.sum = GP_SUM_BILINEAR;
    assert_ok(gp_sun_map_draw(&kept_log, m->gl, &f->o, &p, l, n, &m->map));
    assert_sums(m, f, &p, l, n);
}

/* All, for which the frame is uploaded, and the small ones, whose boxes are. */
static void try_params(struct machine *m, const struct sun_frame *f,
                       struct gp_map_params p)
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
            const struct gp_map_params p = {
                .pattern = (enum gp_sun_pattern) (k % 8 / 4),
                .outside = (enum gp_sun_outside) (k / 8),
                .side = sizes[(k + 4 * i) % 9],
            };
            try_params(machine_at(i), &f, p);
        }
        free_frame(&f);
    }
}

/* Depth of every type, which may be no distance, and frames of one pixel, of
 * none, of a row, and of a column. */
static void depths_and_frames(void **state)
{
    static const struct {
        struct gp_rect frame;
        enum gp_depth_type type;
        int size, side; // of blobs; of the map
    } rows[] = {
        {{-40, 25, 120, 125}, GP_DEPTH_Z, 2, 16},
        {{-40, 25, 120, 125}, GP_DEPTH_RAY, 2, 16},
        {{-40, 25, 120, 125}, GP_DEPTH_INVERSE, 2, 16},
        {{-40, 25, 120, 125}, GP_DEPTH_NORMALIZED, 2, 16},
        {{50, 60, 51, 61}, GP_DEPTH_Z, 1, 8},
        {{50, 60, 50, 60}, GP_DEPTH_Z, 1, 8},
        {{-3, 60, 100, 61}, GP_DEPTH_Z, 1, 8},
        {{50, -900, 51, 900}, GP_DEPTH_Z, 1, 8},
    };
    for (size_t k = 0; k < COUNT(rows); k++) {
        const struct gp_rect r = rows[k].frame;
        struct sun_frame f;
        make_frame(&f, r, WITH_DEPTH | WITH_MASK, rows[k].size);
        for (int i = 0; i < gp_rect_w(r) * gp_rect_h(r); i++)
            if (rows[k].type >= GP_DEPTH_INVERSE && f.depth.v[i] < 1e9f)
                f.depth.v[i] = f.depth.v[i] / 25.0f;
        f.o.type = rows[k].type;
        gp_occluders_count(&f.o);
        for (int i = 0; i < machine_count; i++)
            try_params(machine_at(i), &f,
                       (struct gp_map_params) {.side = rows[k].side});
        free_frame(&f);
    }
}

// -- sums --------------------------------------------------------------------

/* The paper's sum, on the CPU: 8 bits, a step rounded at a time. */
static double byte_sum(const float *map, int texels, bool weight)
{
    const double scale = 256.0 / texels;
    double sum = 0.0;
    for (int t = 0; t < texels; t++)
        sum = fmin(255.0, sum + rint((double) map[2 * t + weight] * scale));
    return sum;
}

/* White and black texels only, so that nothing hangs on how GL rounds. */
static void bytes_are_the_papers(void **state)
{
    static const int sizes[] = {2, 4, 8, 12, 16, 20, 32, 64};
    struct sun_frame f;
    make_frame(&f, window, WITH_DEPTH, 3);
    for (int k = 0; k < 8 * machine_count; k++) {
        struct machine *const m = machine_at(k / 8);
        const int size = sizes[k % 8];
        struct gp_map_params p = {.side = size, .sum = GP_SUM_BYTE};
        struct gp_light l = light_at(30.3, 70.8, size / 2);
        float *const map = malloc(2 * (size_t) (size * size) * sizeof *map);
        measure(m, &f.o, &p, false, &l, 1);
        const double exact = gp_sun_map_reference(&f.o, &p, &l, map);
        const double r = byte_sum(map, size * size, false);
        const double g = byte_sum(map, size * size, true);
        assert_true(fabs(l.visibility - (g > 0.0 ? r / g : 0.0)) < 1e-6);
        if (size == 16) // a step, and the last one that does not fit
            assert_true(fabs(l.visibility - exact) <= 1.0 / 255.0);
        if (size >= 32)
            assert_true(l.visibility == 0.0 && exact > 0.1);
        free(map);
    }
    free_frame(&f);
}

static void bytes_saturate(void **state)
{
    const struct gp_occluders clear = {.frame = window};
    const struct gp_map_params p = {.side = 16, .sum = GP_SUM_BYTE};
    for (int i = 0; i < machine_count; i++) {
        struct machine *const m = machine_at(i);
        const struct gp_light l = light_at(30.0, 70.0, 5.0);
        float texel[4];
        assert_ok(gp_sun_map_draw(&kept_log, m->gl, &clear, &p, &l, 1,
                                  &m->map));
        gp_target_read(m->gl, &m->map->byte_sums, 0,
                       (struct gp_rect) {0, 0, 1, 1}, texel);
        assert_true(texel[0] == 1.0f && texel[1] == 1.0f);
    }
}

/* The atlas and the order of lights in it change no bit of any. */
static void many_equal_single_ones(void **state)
{
    enum { N = 64 };
    struct sun_frame f;
    make_frame(&f, window, WITH_DEPTH | WITH_MASK, 2);
    for (int k = 0; k < 3 * machine_count; k++) {
        struct machine *const m = machine_at(k / 3);
        const struct gp_map_params p = {
            .side = 16, .sum = (enum gp_sun_sum) (k % 3),
        };
        struct gp_light all[N];
        for (int i = 0; i < N; i++)
            all[i] = light_at(-45.0 + 170.0 * uniform01(),
                20.0 + 110.0 * uniform01(), 20.0 * uniform01() * uniform01());
        measure(m, &f.o, &p, false, all, N);
        for (int i = 0; i < N; i++) {
            struct gp_light one = all[i];
            measure(m, &f.o, &p, false, &one, 1);
            assert_memory_equal(&one.visibility, &all[i].visibility,
                                sizeof one.visibility);
        }
    }
    free_frame(&f);
}

/* Points that GL draws no larger than this are put side by side. */
static void points_may_be_small(void **state)
{
    enum { N = 50 };
    static const float most[] = {1.0f, 3.0f, 4.9f};
    struct sun_frame f;
    struct gp_light l[N];
    make_frame(&f, window, WITH_DEPTH, 2);
    for (int i = 0; i < N; i++)
        l[i] = light_at(-45.0 + 3.0 * i, 70.0 + i, 0.3 * i);
    for (int k = 0; k < 3 * machine_count; k++) {
        struct machine *const m = machine_at(k / 3);
        const struct gp_map_params p = {.side = 8};
        const float limit = m->gl->info.max_point;
        m->gl->info.max_point = most[k % 3];
        assert_ok(gp_sun_map_draw(&kept_log, m->gl, &f.o, &p, l, N, &m->map));
        m->gl->info.max_point = limit;
        assert_sums(m, &f, &p, l, N);
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
        const struct gp_map_params p = {.side = 8};
        const int limit = m->gl->info.max_size;
        struct gp_light l[2] = {light_at(40.3, 75.2, rows[k % 4].radius),
                                light_at(45.3, 75.2, rows[k % 4].radius)};
        m->gl->info.max_size = rows[k % 4].most;
        gp_sun_map_close(m->gl, &m->map); // its textures may be larger
        const gp_status st = gp_sun_map_draw(&kept_log, m->gl, &f.o, &p, l, 2,
                                             &m->map);
        m->gl->info.max_size = limit;
        assert_int_equal(st, rows[k % 4].want);
        if (!rows[k % 4].want)
            assert_sums(m, &f, &p, l, 2);
    }
    free_frame(&f);
}

/* Pixel by pixel over a box around the light. */
static double plain_count(const struct gp_occluders *o,
    const struct gp_map_params *p, const struct gp_light *l)
{
    double shown = 0.0, weight = 0.0;
    const bool none = l->radius < 0.5;
    const double r = none ? 0.0 : l->radius;
    for (int y = (int) floor(l->y - r) - 1; y <= l->y + r + 1.0; y++) {
        for (int x = (int) floor(l->x - r) - 1; x <= l->x + r + 1.0; x++) {
            const bool within = x >= o->frame.x0 && x < o->frame.x1 &&
                                y >= o->frame.y0 && y < o->frame.y1;
            const double dx = x + 0.5 - l->x, dy = y + 0.5 - l->y;
            const bool inside =
                none ? x == (int) floor(l->x) && y == (int) floor(l->y)
                : p->pattern == GP_PATTERN_DISC
                    ? dx * dx + dy * dy <= r * r
                    : fabs(dx) <= r && fabs(dy) <= r;
            if (!inside || (!within && p->outside == GP_OUTSIDE_IGNORE))
                continue;
            shown += within ? gp_occluders_show(o, l, x, y)
                     : p->outside == GP_OUTSIDE_SCENE ? l->outside
                            : p->outside == GP_OUTSIDE_VISIBLE;
            weight += 1.0;
        }
    }
    return weight > 0.0 ? shown / weight : 0.0;
}

static void readback_is_a_plain_count(void **state)
{
    static const double at[][3] = { // 0.1 and 0.2 are between all centres
        {37.3, 70.8, 2.5}, {20.0, 60.0, 24.0}, {-41.0, 70.0, 9.0},
        {120.0, 125.0, 12.0}, {-300.0, 70.0, 8.0}, {50.0, 50.0, 0.1},
        {-40.9, 52.0, 0.2}, {10.0, 75.0, 300.0}, {-50.0, 60.0, 0.2},
    };
    enum { N = 9 };
    for (int k = 0; k < 32 * machine_count; k++) {
        struct machine *const m = machine_at(k / 32);
        const struct gp_map_params p = {
            .side = 16, .pattern = (enum gp_sun_pattern) (k % 2),
            .outside = (enum gp_sun_outside) (k / 2 % 4),
        };
        struct sun_frame f;
        struct gp_light l[N];
        make_frame(&f, (struct gp_rect) {-40, 25, 120, 125}, k / 8 % 4, 2);
        for (int i = 0; i < N; i++)
            l[i] = light_at(at[i][0], at[i][1], at[i][2]);
        assert_ok(gp_sun_readback(&kept_log, m->gl, &f.o, &p, l, N, &m->map));
        for (int i = 0; i < N; i++) {
            const double want = plain_count(&f.o, &p, &l[i]);
            if (!(fabs(l[i].visibility - want) < 1e-6))
                fail_msg("row %d, light %d: %.9g is %.9g", k, i, want,
                         l[i].visibility);
        }
        struct gp_light again[N];
        memcpy(again, l, sizeof l);
        assert_ok(gp_sun_map_read(&kept_log, m->gl, m->map, again, N));
        for (int i = 0; i < N; i++)
            assert_true(fabs(again[i].visibility - l[i].visibility) < 1e-7);
        assert_true(m->map->intensity.colour.w == N);
        free_frame(&f);
    }
}

static void ends_of_the_scale(void **state)
{
    static const struct {
        float depth;       // of every pixel
        double x;          // of a light of radius 5 in 64 x 64; behind at 99
        enum gp_sun_outside outside;
        double want;
    } rows[] = {
        {5.0f, 30.0, GP_OUTSIDE_IGNORE, 0.0},
        {1e10f, 30.0, GP_OUTSIDE_IGNORE, 1.0},
        {1e10f, 99.0, GP_OUTSIDE_VISIBLE, 0.0},
        {1e10f, -30.0, GP_OUTSIDE_IGNORE, 0.0},
        {1e10f, -30.0, GP_OUTSIDE_HIDDEN, 0.0},
        {5.0f, -30.0, GP_OUTSIDE_VISIBLE, 1.0},
        {5.0f, 0.0, GP_OUTSIDE_VISIBLE, 0.5},
        {1e10f, 0.0, GP_OUTSIDE_HIDDEN, 0.5},
        {1e10f, 0.0, GP_OUTSIDE_IGNORE, 1.0},
        // a quarter of what is outside is clear
        {1e10f, 30.0, GP_OUTSIDE_SCENE, 1.0},
        {1e10f, -30.0, GP_OUTSIDE_SCENE, 0.25},
        {5.0f, 0.0, GP_OUTSIDE_SCENE, 0.125},
        {1e10f, 99.0, GP_OUTSIDE_SCENE, 0.25},
    };
    enum { ROWS = (int) COUNT(rows) };
    struct gp_plane depth = plane_of((struct gp_rect) {0, 0, 64, 64});
    for (int k = 0; k < ROWS * machine_count; k++) {
        struct machine *const m = machine_at(k / ROWS);
        for (int i = 0; i < 64 * 64; i++)
            depth.v[i] = rows[k % ROWS].depth;
        const struct gp_occluders o = occluders(&depth, NULL, depth.window);
        for (int method = 0; method < 3; method++) {
            const struct gp_map_params p = {
                .side = 16, .outside = rows[k % ROWS].outside,
                .pattern = (enum gp_sun_pattern) (method % 2),
            };
            struct gp_light l = light_at(rows[k % ROWS].x, 32.0, 5.0);
            l.behind = l.x == 99.0;
            measure(m, &o, &p, method == 2, &l, 1);
            if (!(fabs(l.visibility - rows[k % ROWS].want) < 1e-6))
                fail_msg("row %d, method %d: %g is %g", k % ROWS, method,
                         rows[k % ROWS].want, l.visibility);
        }
    }
    gp_plane_free(&depth);
}

/* Leaves: discs of random size that cover about half of the plane. */
static void grow_leaves(struct gp_plane *p)
{
    const int w = gp_rect_w(p->window), h = gp_rect_h(p->window);
    for (int i = 0; i < w * h; i++)
        p->v[i] = 1e10f;
    for (int leaf = 0; leaf < 4000; leaf++) {
        const double r = 1.0 + 10.0 * uniform01() * uniform01();
        const int x = (int) (w * uniform01()), y = (int) (h * uniform01());
        for (int dy = (int) -r; dy <= r; dy++)
            for (int dx = (int) -r; dx <= r; dx++)
                if (dx * dx + dy * dy <= r * r && x + dx >= 0 && x + dx < w &&
                    y + dy >= 0 && y + dy < h)
                    p->v[(y + dy) * w + x + dx] = 8.0f;
    }
}

static void mask_64_is_near_exact(void **state)
{
    enum { N = 60 };
    struct gp_plane depth = plane_of((struct gp_rect) {0, 0, 1024, 768});
    const struct gp_map_params p = {.side = 64};
    struct gp_light exact[N], mask[N];
    seed = 9;
    grow_leaves(&depth);
    const struct gp_occluders o = occluders(&depth, NULL, depth.window);
    for (int i = 0; i < N; i++) {
        const double r = 2.0 + 58.0 * i / (N - 1);
        exact[i] = mask[i] = light_at(1024.0 * uniform01(),
                                      768.0 * uniform01(), r);
    }
    gp_sun_exact(&o, p.outside, exact, N);
    for (int k = 0; k < machine_count; k++) {
        struct machine *const m = machine_at(k);
        double mean = 0.0, worst = 0.0;
        measure(m, &o, &p, false, mask, N);
        for (int i = 0; i < N; i++) {
            const double off = fabs(mask[i].visibility - exact[i].visibility);
            mean += off / N;
            worst = fmax(worst, off);
        }
        print_message("64x64 against exact: mean %.5f, worst %.5f\n", mean,
                      worst);
        assert_true(mean > 0.0 && mean <= 0.01 && worst <= 0.03);
    }
    gp_plane_free(&depth);
}

static void refused(struct machine *m, const struct gp_occluders *o, int map,
                    int n, gp_status want, const char *text)
{
    const struct gp_map_params p = {.side = map};
    static struct gp_light l[GP_LIGHTS_MAX];
    for (int i = 0; i < GP_LIGHTS_MAX; i++)
        l[i] = light_at(30.0, 60.0, 4.0);
    kept_clear();
    assert_int_equal(gp_sun_map_draw(&kept_log, m->gl, o, &p, l, n, &m->map),
                     want);
    if (!strstr(kept_line, text))
        fail_msg("\"%s\" is not in \"%s\"", text, kept_line);
    // nothing was drawn, so nothing is read
    assert_int_equal(gp_sun_map_read(&kept_log, m->gl, m->map, l, 1),
                     GP_ERR_BUG);
}

static void what_is_too_large_is_refused(void **state)
{
    const struct gp_occluders o = {.frame = window};
    const struct gp_occluders wide = {.frame = {0, 0, 1 << 25, 1}};
    for (int i = 0; i < machine_count; i++) {
        struct machine *const m = machine_at(i);
        struct gp_sun_map *const kept = m->map;
        m->map = NULL;
        refused(m, &o, 16, 0, GP_ERR_BUG, "0 lights");
        refused(m, &o, 7, 1, GP_ERR_BUG, "7 texels");
        refused(m, &o, 256, 1024, GP_ERR_GL, "use a smaller --sun-map");
        refused(m, &wide, 16, 1, GP_ERR_GL, "--sun-method exact");
        gp_sun_map_close(m->gl, &m->map);
        m->map = kept;
    }
}

static void pictures(void **state)
{
    struct sun_frame f;
    make_frame(&f, window, WITH_DEPTH, 4);
    for (int i = 0; i < machine_count; i++) {
        struct machine *const m = machine_at(i);
        const struct gp_map_params p = {.side = 8};
        struct gp_light l[5];
        float *grey = NULL;
        int w, h;
        for (int k = 0; k < 5; k++)
            l[k] = light_at(20.0 * k, 70.0, 6.0);
        measure(m, &f.o, &p, false, l, 5);
        assert_ok(gp_sun_map_picture(&kept_log, m->gl, m->map, false, &w, &h,
                                     &grey));
        assert_true(w == 24 && h == 16);
        assert_true(grey[8 * w + 16] == 0.0f && grey[16 * w - 1] == 0.0f);
        double sum = 0.0; // light 4 is second in the second row
        for (int t = 0; t < 64; t++)
            sum += (double) grey[(8 + t / 8) * w + 8 + t % 8];
        assert_true(fabs(sum / 64.0 - l[4].visibility) < 1e-6);
        gp_free(grey);
        assert_ok(gp_sun_map_picture(&kept_log, m->gl, m->map, true, &w, &h,
                                     &grey));
        assert_true(w == 5 && h == 1);
        for (int k = 0; k < 5; k++)
            assert_true(fabs((double) grey[k] - l[k].visibility) < 1e-6);
        gp_free(grey);
        assert_ok(gp_sun_readback(&kept_log, m->gl, &f.o, &p, l, 5, &m->map));
        assert_int_equal(gp_sun_map_picture(&kept_log, m->gl, m->map, false,
                                            &w, &h, &grey), GP_ERR_USAGE);
    }
    free_frame(&f);
}

SUITE_OF(map, open_machines, close_machines, maps_equal_the_reference,
         depths_and_frames, bytes_are_the_papers,
         bytes_saturate, many_equal_single_ones, points_may_be_small,
         textures_may_be_small, readback_is_a_plain_count, ends_of_the_scale,
         mask_64_is_near_exact, what_is_too_large_is_refused, pictures)
