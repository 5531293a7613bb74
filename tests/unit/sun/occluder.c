// SPDX-License-Identifier: Apache-2.0
/* sun/occluder: what a depth sample means by type and background, and the
 * share that a pixel shows with either plane or both. */
#include "scene.h"

#include <float.h>

enum { MOST = 6 };

/* A plane of one row over samples that the caller owns. */
static struct gp_plane row_of(float *v, int n)
{
    return (struct gp_plane) {{0, 0, n, 1}, v, NULL, false};
}

static struct gp_occluders counted(const struct gp_plane *depth,
                                   const struct gp_plane *mask,
                                   enum glarepp_depth type)
{
    struct gp_occluders o = {.depth = depth, .mask = mask, .type = type};
    o.frame = depth ? depth->window : mask ? mask->window : o.frame;
    gp_occluders_count(&o);
    return o;
}

static void assert_same(double got, double want, const char *what, int i)
{
    if (!(got == want || fabs(got - want) <= 1e-12 * fabs(want)))
        fail_msg("%s, %d: %.17g, not %.17g", what, i, got, want);
}

#define Z GLAREPP_Z
#define RAY GLAREPP_RAY
#define INV GLAREPP_INVERSE
#define NRM GLAREPP_NORMALIZED
#define NO INFINITY
#define MAXF FLT_MAX

/* Samples of a frame, and the place that each must have; NO: empty. */
static const struct {
    const char *name;
    enum glarepp_depth type;
    bool reversed;
    const char *empty;
    int n;
    float v[MOST];
    double place[MOST];
} grounds[] = {
    {"0", Z, false, "0", 3, {0, 5, -0.0f}, {NO, 5, NO}},
    {"1e10", Z, false, "1e+10", 3, {1e10f, 5, 1e10f}, {NO, 5, NO}},
    {"1e30", RAY, false, "1e+30", 3, {1e30f, 5, 7}, {NO, 5, 7}},
    {"Inf", RAY, false, "inf", 2, {INFINITY, 5}, {NO, 5}},
    {"NaN", Z, false, "nan", 2, {NAN, 5}, {NO, 5}},
    {"65504", Z, false, "65504", 3, {65504, 65472, 65536}, {NO, 65472, 65536}},
    {"none", Z, false, "none", 3, {1, 1e-40f, 9e8f}, {1, 1e-40f, 9e8f}},
    {"just under and at 1e9", Z, false, "1e+09", 2, {999999936.0f, 1e9f},
     {999999936.0, NO}},
    {"huge of both signs", Z, false, "-1e+30 to 1e+30", 3,
     {-1e30f, 1e30f, 3}, {NO, NO, 3}},
    {"sky alone", Z, false, "1e+10", 2, {1e10f, 1e10f}, {NO, NO}},
    {"negative z, 0", Z, true, "0", 3, {0, -5, -9}, {NO, 5, 9}},
    {"negative z, 1e10", Z, true, "1e+10", 3, {1e10f, -5, -9}, {NO, 5, 9}},
    {"negative z, -1e10", Z, true, "-1e+10", 2, {-1e10f, -5}, {NO, 5}},
    {"negative z, -Inf", Z, true, "inf", 2, {-INFINITY, -5}, {NO, 5}},
    {"negative z, 65504", Z, true, "-65504", 2, {-65504, -5}, {NO, 5}},
    {"a few under 0", Z, false, "negative", 3, {-5, 5, 4}, {NO, 5, 4}},
    {"inverse, 0", INV, false, "0", 3, {0, 0.5f, 4}, {NO, 2, 0.25}},
    {"inverse, Inf is near", INV, false, "none", 2, {INFINITY, 1}, {0, 1}},
    {"inverse, under 0, NaN", INV, false, "negative, nan", 3, {-1, NAN, 1},
     {NO, NO, 1}},
    {"inverse, far away", INV, false, "under 1e-09", 4,
     {0x1p-149f, 1e-10f, 1e-30f, 0.5f}, {NO, NO, NO, 2}},
    {"inverse, large", INV, false, "none", 2, {1e10f, 65504},
     {1.0 / 1e10f, 1.0 / 65504}},
    {"normalized, 1", NRM, false, "1", 3, {1, 0.25f, 0}, {NO, 0.25, 0}},
    {"normalized, over 1", NRM, false, "over 1", 3, {2, 0.25f, 0},
     {NO, 0.25, 0}},
    {"normalized, Inf", NRM, false, "over 1", 2, {INFINITY, 0}, {NO, 0}},
    {"normalized, NaN", NRM, false, "nan", 2, {NAN, 0.5f}, {NO, 0.5}},
    {"normalized, under 0", NRM, false, "1", 2, {-0.5f, 1}, {0, NO}},
    {"normalized, no ground", NRM, false, "none", 2, {0.5f, 0.25f},
     {0.5, 0.25}},
    {"reversed", NRM, true, "0", 3, {0, 0.25f, 0.75f}, {NO, 0.75, 0.25}},
    {"reversed, under 0", NRM, true, "0, negative", 3, {0, -1, 0.75f},
     {NO, NO, 0.25}},
};
enum { GROUNDS = COUNT(grounds) };

static void test_backgrounds(void **state)
{
    for (int i = 0; i < GROUNDS; i++) {
        const int n = grounds[i].n;
        float v[MOST];
        memcpy(v, grounds[i].v, sizeof v);
        const struct gp_plane p = row_of(v, n);
        const struct gp_occluders o = counted(&p, NULL, grounds[i].type);
        if (o.reversed != grounds[i].reversed)
            fail_msg("%s: reversed is %d", grounds[i].name, o.reversed);
        if (strcmp(o.empty, grounds[i].empty) != 0)
            fail_msg("%s: empty is '%s', not '%s'", grounds[i].name,
                     o.empty, grounds[i].empty);
        for (int k = 0; k < n; k++)
            assert_same(gp_occluders_at(&o, k, 0).place, grounds[i].place[k],
                        grounds[i].name, k);
    }
}

static void test_no_depth(void **state)
{
    struct gp_plane none = {0};
    float m[] = {0.25f};
    const struct gp_plane mask = row_of(m, 1);
    const struct gp_occluders each[] = {
        counted(NULL, NULL, Z), counted(&none, NULL, Z),
        counted(NULL, &none, Z), counted(&none, &mask, NRM)};
    const struct gp_light l = GP_LIGHT_DEFAULTS;
    for (int i = 0; i < 4; i++) {
        assert_string_equal(each[i].empty, "none");
        assert_same(gp_occluders_show(&each[i], &l, 0, 0, NULL),
                    i < 3 ? 1 : 0.75, "show", i);
    }
}

/* Depth and mask of a pixel, a light's depth, and the share by depth alone,
 * by the mask alone, and by both. */
static const struct {
    const char *name;
    enum glarepp_depth type;
    float z, m;
    double light, alone, mask, both;
    double bias;
} shows[] = {
    {"nearer", Z, 5, 0.75f, 10, 0, 0.25, 0.25, 1e-3},
    {"behind", Z, 15, 0.75f, 10, 1, 0.25, 1, 1e-3},
    {"empty", Z, 1e10f, 0.75f, 10, 1, 0.25, 0.25, 1e-3},
    {"empty, clear mask", Z, 1e10f, 0, 10, 1, 1, 1, 1e-3},
    {"nearer, clear mask", Z, 5, 0, 10, 0, 1, 1, 1e-3},
    {"nearer, opaque mask", Z, 5, 1, 10, 0, 0, 0, 1e-3},
    {"before a sun", Z, 9e8f, 1, INFINITY, 0, 0, 0, 1e-3},
    {"a sun in the sky", Z, INFINITY, 0.5f, INFINITY, 1, 0.5, 0.5, 1e-3},
    {"within the bias", Z, 9.995f, 1, 10, 1, 0, 1, 1e-3},
    {"over the bias", Z, 9.98f, 1, 10, 0, 0, 0, 1e-3},
    {"mask NaN", Z, 5, NAN, 10, 0, 1, 1, 1e-3},
    {"mask over 1", Z, 5, 3, 10, 0, 0, 0, 1e-3},
    {"mask +Inf", Z, 5, INFINITY, 10, 0, 0, 0, 1e-3},
    {"mask under 0", Z, 5, -3, 10, 0, 1, 1, 1e-3},
    {"inverse, nearer", INV, 0.5f, 1, 10, 0, 0, 0, 1e-3},
    {"inverse, behind", INV, 0.05f, 1, 10, 1, 0, 1, 1e-3},
    {"inverse, at the camera", INV, INFINITY, 1, 1e-9, 0, 0, 0, 1e-3},
    {"normalized, nearer", NRM, 0.25f, 1, 0.5, 0, 0, 0, 1e-3},
    {"normalized, behind", NRM, 0.75f, 1, 0.5, 1, 0, 1, 1e-3},
    {"normalized, before a sun", NRM, 0.999f, 1, INFINITY, 0, 0, 0, 1e-3},
    {"a light at the camera", Z, 5, 1, 0, 1, 0, 1, 1e-3},
    {"a light of NaN depth", Z, 5, 1, NAN, 1, 0, 1, 1e-3},
    // lets nothing hide a lamp, and does not turn a sun into NaN
    {"a sun, bias 1", Z, 5, 1, INFINITY, 0, 0, 0, 1.0},
    {"a lamp, bias 1", Z, 5, 1, 1000, 1, 0, 1, 1.0},
};
enum { SHOWS = COUNT(shows) };

static void test_show(void **state)
{
    for (int i = 0; i < SHOWS; i++) {
        float z[] = {shows[i].z, shows[i].type == NRM ? 1.0f : 5.0f};
        float m[] = {shows[i].m, 0};
        const struct gp_plane d = row_of(z, 2), a = row_of(m, 2);
        struct gp_light l = GP_LIGHT_DEFAULTS;
        l.depth = shows[i].light;
        l.bias = shows[i].bias;
        const struct gp_occluders o[] = {counted(&d, NULL, shows[i].type),
                                         counted(NULL, &a, shows[i].type),
                                         counted(&d, &a, shows[i].type)};
        const double want[] = {shows[i].alone, shows[i].mask, shows[i].both};
        for (int k = 0; k < 3; k++) {
            assert_same(gp_occluders_show(&o[k], &l, 0, 0, NULL), want[k],
                        shows[i].name, k);
        }
    }
}

/* Far corners of pixel space: offsets must not wrap. */
static void test_far_pixels(void **state)
{
    float z[] = {5, 0, 0, 0, 0, 7};
    static const int at[] = {-(1 << 30), 1 << 30, 0};
    const struct gp_light l = GP_LIGHT_DEFAULTS;
    for (int i = 0; i < 3; i++) {
        const int x = at[i], y = at[(i + 1) % 3];
        const struct gp_plane d = {{x, y, x + 3, y + 2}, z, NULL, false};
        const struct gp_occluders o = counted(&d, NULL, Z);
        assert_same(gp_occluders_show(&o, &l, x, y, NULL), 0, "first", i);
        assert_same(gp_occluders_show(&o, &l, x + 2, y + 1, NULL), 0, "end", i);
        assert_same(gp_occluders_show(&o, &l, INT32_MIN, INT32_MAX, NULL), 1,
                    "far", i);
    }
}

SUITE_OF(occluder, NULL, NULL, test_backgrounds, test_no_depth, test_show,
         test_far_pixels)
