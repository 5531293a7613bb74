// SPDX-License-Identifier: Apache-2.0
/* sun/exact: the area of a disc in a pixel by columns, and the share in every
 * place that a light may have, against what it must be and against pixel after
 * pixel. */
#include "scene.h"

static double disc_area(double cx, double cy, double r, int x, int y)
{
    const struct gp_light l = {.x = cx, .y = cy};
    return gp_light_pixel_area(&l, r, x, y);
}

/* Area by thin columns, whose heights are known. */
static double area_by_columns(double cx, double cy, double r, int x, int y)
{
    enum { COLUMNS = 20000 };
    double sum = 0.0;
    for (int i = 0; i < COLUMNS; i++) {
        const double at = x + (i + 0.5) / COLUMNS - cx;
        const double half = sqrt(fmax(r * r - at * at, 0.0));
        sum += fmax(fmin(cy + half, y + 1.0) - fmax(cy - half, y), 0.0);
    }
    return sum / COLUMNS;
}

static void test_pixel_area(void **state)
{
    static const double radii[] = {0.06, 0.2, 0.5, 1, 1.44, 2.4, 10, 62.5, 1e3};
    seed = 20071u;
    for (size_t k = 0; k < COUNT(radii); k++) {
        for (int i = 0; i < 40; i++) {
            // a pixel near the edge, at axes and between
            const double turn = i < 8 ? i * M_PI_4 : uniform01() * 2 * M_PI;
            const double fx = uniform01(), fy = uniform01(), r = radii[k];
            const int x = (int) floor(fx + r * cos(turn));
            const int y = (int) floor(fy + r * sin(turn)) - (i % 3 == 2);
            assert_near(disc_area(fx, fy, r, x, y),
                        area_by_columns(fx, fy, r, x, y), 3e-6, "area, radius",
                        r);
        }
    }
}

static void test_area_hard(void **state)
{
    const double inf = (double) INFINITY, nan = (double) NAN;
    assert_near(disc_area(0.5, 0.5, 0.5, 0, 0), M_PI / 4, 1e-15,
                "touches all sides", 0.5);
    assert_near(disc_area(0, 0, 1, 0, 0), M_PI / 4, 1e-15, "quarter", 1);
    assert_near(disc_area(0, 0, M_SQRT2 * 1.0000001, 0, 0), 1, 0,
                "over the corner", 0);
    const struct {
        double cx, cy, r;
    } none[] = {{0, 0, 0},    {0, 0, -1},  {0, 0, nan}, {nan, 0, 1},
                {0, nan, 1},  {-1, 0, 1},  {2, 0.5, 1}, {-1, -1, M_SQRT2},
                {1e300, 0, 1}, {inf, 0, 5}, {0, -inf, 5}};
    for (size_t i = 0; i < COUNT(none); i++)
        assert_near(disc_area(none[i].cx, none[i].cy, none[i].r, 0, 0), 0,
                    1e-15, "no area", (double) i);
    assert_near(
        disc_area(INT32_MAX + 0.5, INT32_MIN + 0.5, 9, INT32_MAX, INT32_MIN), 1,
        0, "far", 9);
    double last = 0.0; // it grows with the radius
    for (int i = 0; i <= 4000; i++) {
        const double area = disc_area(0.3, 0.6, i / 2000.0, 0, 0);
        assert_true(area >= last - 1e-15);
        last = area;
    }
    assert_near(last, 1.0, 0.0, "a pixel inside", 2);
}

static void fill_random(struct gp_plane *p, unsigned seed, float scale)
{
    const int n = gp_rect_w(p->window) * gp_rect_h(p->window);
    for (int i = 0; i < n; i++) {
        seed = seed * 1664525u + 1013904223u;
        p->v[i] = scale * (float) (seed >> 8) * 0x1p-24f;
    }
}

/* Lights over a frame of 20 x 10 whose left half (x under 10) is hidden: the
 * share by mode. */
static const struct {
    const char *name;
    double x, y, r;
    double want[3]; // ignore, visible, hidden
    double bar;
} places[] = {
    {"clear", 15, 5, 3, {1, 1, 1}, 0}, {"hidden", 5, 5, 3, {0, 0, 0}, 0},
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
enum { PLACES = COUNT(places) };

static void test_places(void **state)
{
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
            const double *const want = places[p].want;
            const double scene = want[2] + 0.25 * (want[1] - want[2]);
            // far from 0 ulps of the place are larger
            assert_near(visibility(&o[i % 3], mode,
                                   light_at(places[p].x + x0, places[p].y + y0,
                                            places[p].r)),
                        mode == GLAREPP_BY_SCENE ? scene : want[mode],
                        places[p].bar + (c > 0 ? 1e-9 : 0.0), places[p].name,
                        mode);
        }
        struct gp_light behind = light_at(15 + x0, 5 + y0, 3);
        behind.behind = true;
        for (int mode = 0; mode < MODES; mode++)
            assert_near(visibility(&o[0], mode, behind),
                        mode == GLAREPP_BY_SCENE ? 0.25 : 0, 0, "behind", mode);
        gp_plane_free(&depth);
        gp_plane_free(&mask);
    }
}

/* Nothing to hide behind, whether a window is large or empty; and a light of
 * NaN place comes out a share all the same. */
static void test_no_planes(void **state)
{
    const struct gp_rect vast = {-1000000000, -1000000000, 1000000000,
                                 1000000000};
    const struct gp_occluders all = occluders(NULL, NULL, vast);
    const struct gp_occluders none = occluders(NULL, NULL,
                                               (struct gp_rect) {0});
    const struct gp_occluders some = occluders(NULL, NULL,
                                               (struct gp_rect) {0, 0, 20, 10});
    static const double nowhere[][3] = {{NAN, NAN, 3}, {3, 3, NAN},
                                        {NAN, 3, NAN}};
    for (int mode = 0; mode < MODES; mode++) {
        assert_near(visibility(&all, mode, light_at(3, 4, 5)), 1, 0, "all",
                    mode);
        assert_near(visibility(&all, mode, light_at(3, 4, 1e8)), 1, 0, "vast",
                    mode);
        assert_near(visibility(&none, mode, light_at(3, 4, 5)),
                    mode == GLAREPP_BY_SCENE ? 0.25 : mode == 1, 0,
                    "empty frame", mode);
        for (int i = 0; i < 3; i++) {
            const double *const at = nowhere[i];
            const double v =
                visibility(&some, mode, light_at(at[0], at[1], at[2]));
            assert_true(v >= 0.0 && v <= 1.0);
        }
    }
}

static double by_pixels(const struct gp_occluders *o, int outside,
                        const struct gp_light *l)
{
    double area = 0.0, shown = 0.0;
    for (int y = o->frame.y0; y < o->frame.y1; y++) {
        for (int x = o->frame.x0; x < o->frame.x1; x++) {
            const double a = disc_area(l->x, l->y, l->radius, x, y);
            area += a;
            shown += a * gp_occluders_show(o, l, x, y, NULL);
        }
    }
    const double rest = M_PI * l->radius * l->radius - area;
    if (outside != (int) GLAREPP_IGNORE)
        area += rest;
    if (outside == (int) GLAREPP_VISIBLE)
        shown += rest;
    if (outside == (int) GLAREPP_BY_SCENE)
        shown += rest * l->outside;
    return area > 0.0 ? shown / area : 0.0;
}

/* Bounds of a share, pixel by pixel. */
static void check_interval(const struct gp_occluders *o, int outside,
                           struct gp_light l)
{
    const struct gp_rect f = o->frame;
    double area = 0.0, low = 0.0, high = 0.0;
    for (int i = 0; i < gp_rect_w(f) * gp_rect_h(f); i++) {
        const int x = f.x0 + i % gp_rect_w(f), y = f.y0 + i / gp_rect_w(f);
        const double a = disc_area(l.x, l.y, l.radius, x, y);
        double lo = 1.0, hi = 0.0;
        for (int k = 0; k < 9; k++) {
            const int near_x = x + k % 3 - 1, near_y = y + k / 3 - 1;
            if (near_x < f.x0 || near_x >= f.x1 || near_y < f.y0 ||
                near_y >= f.y1)
                continue;
            bool beyond, past;
            (void) gp_occluders_show(o, &l, x, y, &beyond);
            const double s = gp_occluders_show(o, &l, near_x, near_y, &past);
            if (o->mask && k != 4 && !beyond && !past)
                continue;
            lo = fmin(lo, s);
            hi = fmax(hi, s);
        }
        area += a;
        low += lo < 1.0 ? 0.0 : a;
        high += hi > 0.0 ? a : 0.0;
    }
    const double disc = M_PI * l.radius * l.radius, rest = disc - area;
    const bool scene = outside == (int) GLAREPP_BY_SCENE;
    l.outside_error = 0.1;
    l.visibility = visibility(o, outside, l);
    gp_sun_interval(o, (enum glarepp_outside) outside, &l, 1);
    assert_near(l.low, (low + rest * (scene ? 0.15 : 0.0)) / disc, 1e-9, "low",
                outside);
    assert_near(l.high, (high + rest * (scene ? 0.35 : 1.0)) / disc, 1e-9,
                "high", outside);
    assert_true(l.low <= l.visibility && l.visibility <= l.high);
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
enum { WINDOWS = COUNT(windows) };

static void test_windows(void **state)
{
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
            check_interval(&o, mode, l);
        }
        gp_plane_free(&depth);
        gp_plane_free(&mask);
    }
}

/* A frame far larger than its planes costs what the planes cost, and what is
 * hidden stays a hole in it. */
static void test_vast_frame(void **state)
{
    struct gp_plane depth = plane_of((struct gp_rect) {5, 5, 15, 15});
    struct gp_plane mask =
        plane_of((struct gp_rect) {900000000, 900000000, 900000010, 900000010});
    for (int i = 0; i < 100; i++) {
        depth.v[i] = 5.0f;
        mask.v[i] = 1.0f;
    }
    const struct gp_occluders o = occluders(&depth, &mask,
        (struct gp_rect) {-1000000000, -1000000000, 1000000000, 1000000000});
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
    // so do bounds: a block of 10 x 10, its edges on both sides
    struct gp_light l = light_at(10, 10, 1000);
    l.visibility = visibility(&alone, 0, l);
    gp_sun_interval(&alone, GLAREPP_IGNORE, &l, 1);
    assert_near(l.low, 1.0 - 144.0 / (M_PI * 1e6), 1e-12, "low", 0);
    assert_near(l.high, 1.0 - 64.0 / (M_PI * 1e6), 1e-12, "high", 0);
    l = light_at(10, 10, 1e6);
    l.visibility = visibility(&o, 0, l);
    gp_sun_interval(&o, GLAREPP_IGNORE, &l, 1);
    assert_near(l.high - l.low, 0.0, 1e-9, "both", 0);
    gp_plane_free(&depth);
    gp_plane_free(&mask);
}

/* Each light has its own share, whatever it held before and whoever is beside
 * it; none is fine. */
static void test_many_lights(void **state)
{
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
    gp_sun_exact(&o, GLAREPP_IGNORE, light, N);
    for (int i = 0; i < N; i++) {
        const double alone = visibility(&o, 0, light[i]);
        assert_true(light[i].visibility == alone);
        assert_true(!light[i].behind || alone == 0.0);
    }
    gp_sun_exact(&o, GLAREPP_IGNORE, NULL, 0);
    gp_plane_free(&depth);
}

SUITE_OF(exact, NULL, NULL, test_pixel_area, test_area_hard, test_places,
         test_no_planes, test_windows, test_vast_frame,
         test_many_lights)
