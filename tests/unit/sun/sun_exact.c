/* sun/exact: visibility in every place that a light may have, against what it
 * must be and against pixel after pixel. */
#include "unit.h"
#include "core/parallel.h"

#include "sun_scene.h"

static void fill(struct gp_plane *p, float v)
{
    const int n = gp_rect_w(p->window) * gp_rect_h(p->window);
    for (int i = 0; i < n; i++)
        p->v[i] = v;
}

static void fill_random(struct gp_plane *p, unsigned seed, float scale)
{
    const int n = gp_rect_w(p->window) * gp_rect_h(p->window);
    for (int i = 0; i < n; i++) {
        seed = seed * 1664525u + 1013904223u;
        p->v[i] = scale * (float) (seed >> 8) * 0x1p-24f;
    }
}

/* -- places of a light ----------------------------------------------------- */

/* Lights over a frame of 20 x 10 whose left half (x under 10) is hidden: the
 * share by mode. */
static const struct {
    const char *name;
    double x, y, r;
    double want[MODES]; // ignore, visible, hidden
    double bar;
} places[] = {
    {"clear", 15, 5, 3, {1, 1, 1}, 0},
    {"hidden", 5, 5, 3, {0, 0, 0}, 0},
    {"on the edge", 10, 5, 3, {0.5, 0.5, 0.5}, 1e-14},
    {"touches the edge", 13, 5, 3, {1, 1, 1}, 0},
    {"touches the frame", 3, 5, 3, {0, 0, 0}, 0},
    {"half outside, clear", 20, 5, 3, {1, 1, 0.5}, 1e-14},
    {"half outside, hidden", 0, 5, 3, {0, 0.5, 0}, 1e-14},
    {"a quarter inside, clear", 20, 10, 3, {1, 1, 0.25}, 1e-14},
    {"a quarter inside, hidden", 0, 0, 3, {0, 0.75, 0}, 1e-14},
    {"three ways", 10, 0, 4, {0.5, 0.75, 0.25}, 1e-14},
    {"outside", -4, 5, 3, {0, 1, 0}, 0},
    {"far outside", 1e12, -1e12, 3, {0, 1, 0}, 0},
    {"outside, touches", -3, 5, 3, {0, 1, 0}, 0},
    {"beside a corner", -2.2, -2.2, 3, {0, 1, 0}, 0},
    {"point, clear", 15.5, 5.5, 0, {1, 1, 1}, 0},
    {"point, hidden", 5.5, 5.5, 0, {0, 0, 0}, 0},
    {"point on the edge", 10, 5.25, 0, {0.5, 0.5, 0.5}, 1e-12},
    {"point on a corner of the frame", 20, 0, 0, {1, 1, 0.25}, 1e-12},
    {"smaller than a pixel", 9.9, 5.5, 0.2,
     {0.19550110947788532, 0.19550110947788532, 0.19550110947788532}, 1e-13},
    {"negative radius", 15.5, 5.5, -5, {1, 1, 1}, 0},
    {"larger than the frame", 10, 5, 1e4, {0.5, 1, 0}, 1e-6},
    {"of a huge radius", 10, 5, 1e300, {0.5, 1, 0}, 1e-6},
    {"of an infinite radius", 10, 5, INFINITY, {0.5, 1, 0}, 1e-6},
};
enum { PLACES = sizeof places / sizeof *places };

static void test_places(void **state)
{
    (void) state;
    static const int corner[][2] = {{0, 0}, {-1000, -77}, {100000, 70000}};
    for (int c = 0; c < 3; c++) {
        const int x0 = corner[c][0], y0 = corner[c][1];
        const struct gp_rect frame = {x0, y0, x0 + 20, y0 + 10};
        struct gp_plane depth = plane_of(frame), mask = plane_of(frame);
        for (int i = 0; i < 200; i++) {
            depth.v[i] = i % 20 < 10 ? 5.0f : 1e10f;
            mask.v[i] = i % 20 < 10 ? 1.0f : 0.0f;
        }
        const struct gp_occluders o[] = {occluders(&depth, NULL, frame),
                                         occluders(NULL, &mask, frame),
                                         occluders(&depth, &mask, frame)};
        for (int i = 0; i < PLACES * MODES * 3; i++) {
            const int p = i / (3 * MODES), mode = i / 3 % MODES;
            // where pixels are far from 0, so are ulps of the place
            assert_near(visibility(&o[i % 3], mode,
                                   light_at(places[p].x + x0, places[p].y + y0,
                                            places[p].r)),
                        places[p].want[mode],
                        places[p].bar + (c > 0 ? 1e-9 : 0.0), places[p].name,
                        mode);
        }
        struct gp_light behind = light_at(15 + x0, 5 + y0, 3);
        behind.behind = true;
        for (int mode = 0; mode < MODES; mode++)
            assert_near(visibility(&o[0], mode, behind), 0, 0, "behind", mode);
        gp_plane_free(&depth);
        gp_plane_free(&mask);
    }
}

/* A light of NaN place must come out a share all the same. */
static void test_nowhere(void **state)
{
    (void) state;
    const struct gp_rect frame = {0, 0, 20, 10};
    const struct gp_occluders o = occluders(NULL, NULL, frame);
    const double nan = (double) NAN;
    for (int mode = 0; mode < MODES; mode++) {
        const double v[] = {visibility(&o, mode, light_at(nan, nan, 3)),
                            visibility(&o, mode, light_at(3, 3, nan)),
                            visibility(&o, mode, light_at(nan, 3, nan))};
        for (int i = 0; i < 3; i++)
            assert_true(v[i] >= 0.0 && v[i] <= 1.0);
    }
}

/* Nothing to hide behind, whether a window is large or empty. */
static void test_no_planes(void **state)
{
    (void) state;
    const struct gp_rect vast = {-1000000000, -1000000000, 1000000000,
                                 1000000000};
    for (int mode = 0; mode < MODES; mode++) {
        const struct gp_occluders o = occluders(NULL, NULL, vast);
        assert_near(visibility(&o, mode, light_at(3, 4, 5)), 1, 0, "all", mode);
        assert_near(visibility(&o, mode, light_at(3, 4, 1e8)), 1, 0, "vast",
                    mode);
        const struct gp_occluders none = occluders(NULL, NULL,
                                                   (struct gp_rect) {0});
        assert_near(visibility(&none, mode, light_at(3, 4, 5)), mode == 1, 0,
                    "empty frame", mode);
    }
}

/* -- against pixel after pixel --------------------------------------------- */

static double by_pixels(const struct gp_occluders *o, int outside,
                        const struct gp_light *l)
{
    double area = 0.0, shown = 0.0;
    for (int y = o->frame.y0; y < o->frame.y1; y++) {
        for (int x = o->frame.x0; x < o->frame.x1; x++) {
            const double a = gp_disc_pixel_area(l->x, l->y, l->radius, x, y);
            area += a;
            shown += a * gp_occluders_show(o, l, x, y);
        }
    }
    const double rest = M_PI * l->radius * l->radius - area;
    if (outside != (int) GP_OUTSIDE_IGNORE)
        area += rest;
    if (outside == (int) GP_OUTSIDE_VISIBLE)
        shown += rest;
    return area > 0.0 ? shown / area : 0.0;
}

/* Windows of depth, of the mask, and of the frame, in every relation. */
static const struct gp_rect windows[][3] = {
    {{0, 0, 60, 40}, {0, 0, 60, 40}, {0, 0, 60, 40}},
    {{10, 5, 50, 30}, {10, 5, 50, 30}, {0, 0, 60, 40}},
    {{-10, -5, 70, 50}, {-10, -5, 70, 50}, {0, 0, 60, 40}},
    {{0, 0, 30, 40}, {20, 10, 60, 30}, {0, 0, 60, 40}},
    {{20, 10, 40, 30}, {0, 0, 60, 40}, {0, 0, 60, 40}},
    {{0, 0, 20, 20}, {40, 20, 60, 40}, {0, 0, 60, 40}},
    {{0, 0, 0, 0}, {5, 5, 55, 35}, {0, 0, 60, 40}},
    {{100, 100, 120, 120}, {5, 5, 55, 35}, {0, 0, 60, 40}},
    {{0, 0, 1, 1}, {0, 0, 1, 1}, {0, 0, 1, 1}},
    {{0, 0, 60, 1}, {0, 0, 60, 1}, {0, 0, 60, 1}},
};
enum { WINDOWS = sizeof windows / sizeof *windows };

static void test_windows(void **state)
{
    (void) state;
    static const double lights[][3] = {
        {30, 20, 7.3}, {11.7, 6.1, 4}, {0.5, 0.5, 0.4}, {30, 20, 100},
        {25.25, 38, 20}, {59, 3, 12}, {-3, 20, 9}};
    for (int i = 0; i < WINDOWS; i++) {
        struct gp_plane depth = plane_of(windows[i][0]);
        struct gp_plane mask = plane_of(windows[i][1]);
        fill_random(&depth, 3u, 20.0f);
        fill_random(&mask, 5u, 1.0f);
        for (int k = 0; k < 7 * 4 * MODES; k++) {
            const int planes = k / MODES % 4, mode = k % MODES;
            const struct gp_occluders o =
                occluders(planes & 1 ? &depth : NULL, planes & 2 ? &mask : NULL,
                          windows[i][2]);
            const double *const at = lights[k / (4 * MODES)];
            struct gp_light l = light_at(at[0], at[1], at[2]);
            l.depth = 10.0;
            assert_near(visibility(&o, mode, l), by_pixels(&o, mode, &l),
                        1e-12, "windows", 100 * i + k);
        }
        gp_plane_free(&depth);
        gp_plane_free(&mask);
    }
}

/* A frame far larger than its planes costs what the planes cost, and what is
 * hidden stays a hole in it. */
static void test_vast_frame(void **state)
{
    (void) state;
    struct gp_plane depth = plane_of((struct gp_rect) {5, 5, 15, 15});
    struct gp_plane mask =
        plane_of((struct gp_rect) {900000000, 900000000, 900000010, 900000010});
    fill(&depth, 5.0f);
    fill(&mask, 1.0f);
    const struct gp_occluders o = occluders(
        &depth, &mask, (struct gp_rect) {-1000000000, -1000000000, 1000000000,
                                         1000000000});
    // the mask does not cover what depth finds before the light: s = 1 - m
    assert_near(visibility(&o, 0, light_at(10, 10, 3)), 1, 0, "both", 0);
    struct gp_occluders alone = o;
    alone.mask = NULL;
    assert_near(visibility(&alone, 0, light_at(10, 10, 3)), 0, 0, "depth", 0);
    assert_near(visibility(&alone, 0, light_at(10, 10, 1000)),
                1.0 - 100.0 / (M_PI * 1e6), 1e-12, "a hole", 0);
    assert_near(visibility(&o, 0, light_at(900000005, 900000005, 3)), 0, 0,
                "mask", 0);
    assert_near(visibility(&o, 0, light_at(10, 10, 1e9)), 1, 1e-12, "all", 0);
    gp_plane_free(&depth);
    gp_plane_free(&mask);
}

/* -- threads --------------------------------------------------------------- */

static void test_threads(void **state)
{
    (void) state;
    const struct gp_rect frame = {-13, 7, 700, 420};
    struct gp_plane depth = plane_of(frame), mask = plane_of(frame);
    fill_random(&depth, 17u, 20.0f);
    fill_random(&mask, 19u, 1.0f);
    const struct gp_occluders o = occluders(&depth, &mask, frame);
    static const int threads[] = {1, 2, 3, 8};
    static const double radius[] = {2.5, 60, 190.7, 2000};
    double first[4] = {0};
    for (int i = 0; i < 16; i++) {
        gp_set_threads(threads[i / 4]);
        struct gp_light l = light_at(300.3, 200.7, radius[i % 4]);
        l.depth = 10.0;
        const double got = visibility(&o, 1, l);
        if (i < 4)
            first[i] = got;
        assert_true(got > 0.0 && got < 1.0);
        assert_memory_equal(&got, &first[i % 4], sizeof got);
    }
    gp_set_threads(0);
    gp_plane_free(&depth);
    gp_plane_free(&mask);
}

/* Each light has its own share, whatever it held before and whoever is beside
 * it; none is fine. */
static void test_many_lights(void **state)
{
    (void) state;
    enum { N = 64 };
    const struct gp_rect frame = {0, 0, 90, 50};
    struct gp_plane depth = plane_of(frame);
    fill_random(&depth, 23u, 20.0f);
    const struct gp_occluders o = occluders(&depth, NULL, frame);
    struct gp_light light[N];
    for (int i = 0; i < N; i++) {
        light[i] = light_at(1.7 * i - 5.0, 0.9 * i - 3.0, 0.2 * i);
        light[i].depth = i;
        light[i].behind = i % 9 == 4;
        light[i].visibility = (double) NAN;
    }
    gp_sun_exact(&o, GP_OUTSIDE_IGNORE, light, N);
    for (int i = 0; i < N; i++) {
        const double alone = visibility(&o, 0, light[i]);
        assert_true(light[i].visibility == alone);
        assert_true(!light[i].behind || alone == 0.0);
    }
    gp_sun_exact(&o, GP_OUTSIDE_IGNORE, NULL, 0);
    gp_plane_free(&depth);
}

SUITE_OF(sun_exact, NULL, NULL,
    test_places, test_nowhere, test_no_planes, test_windows, test_vast_frame,
    test_threads, test_many_lights)
