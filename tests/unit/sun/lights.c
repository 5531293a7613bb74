// SPDX-License-Identifier: Apache-2.0
/* sun/lights: lights from JSON, and their places in a frame. */
#include "unit.h"
#include "core/memory.h"
#include "json_file.h"
#include "sun/lights.h"

static const struct gp_rect window = {0, 0, 400, 200};

static void lights_by_text(void **state)
{
    static const struct {
        const char *text; // of one light
        struct glarepp_light want;
    } row[] = {
        {"{'pixel': [3, -4.5]}",
         {GLAREPP_PIXEL,
          {3, -4.5, 0},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
        {"{'world': [1, 2, 3], 'name': 'lamp'}",
         {GLAREPP_WORLD,
          {1, 2, 3},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "lamp",
          {1, 1, 1}}},
        {"{'direction': [0, 0, 1e-9]}",
         {GLAREPP_DIRECTION,
          {0, 0, 1e-9},
          -1,
          0.533,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
        {"{'direction': [0, 0, 1], 'radius': 2}",
         {GLAREPP_DIRECTION,
          {0, 0, 1},
          2,
          0.533,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
        {"{'direction': [0, 0, 1], 'degrees': 2}",
         {GLAREPP_DIRECTION,
          {0, 0, 1},
          -1,
          2,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
        {"{'pixel': [0, 0], 'radius': 0, 'depth': 0, 'bias': 0}",
         {GLAREPP_PIXEL,
          {0, 0, 0},
          0,
          0.533,
          0,
          0,
          0,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
        {"{'pixel': [0, 0], 'depth': 1e30, 'bias': 1, 'flux': 1e12}",
         {GLAREPP_PIXEL,
          {0, 0, 0},
          0.5,
          0.533,
          0,
          1e30,
          1,
          {1e12f, 1e12f, 1e12f},
          "",
          {1, 1, 1}}},
        {"{'pixel': [0, 0], 'flux': [1, 2, 3]}",
         {GLAREPP_PIXEL,
          {0, 0, 0},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {1, 2, 3},
          "",
          {1, 1, 1}}},
        {"{'pixel': [0, 0], 'flux': 4, 'color': [1, 0.5, 0]}",
         {GLAREPP_PIXEL,
          {0, 0, 0},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {4, 2, 0},
          "",
          {1, 1, 1}}},
        {"{'found': [[7, 1, 2]], 'name': 'a', 'flux': 4, 'color': [1, 0.5, 0]}",
         {GLAREPP_FOUND,
          {1, 2, 7},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {4, 4, 4},
          "a",
          {1, 0.5, 0}}},
        {"{'pixel': [0, 0], 'color': [1, 2, 3]}",
         {GLAREPP_PIXEL,
          {0, 0, 0},
          0.5,
          0.533,
          0,
          NAN,
          1e-3,
          {0, 0, 0},
          "",
          {1, 1, 1}}},
    };
    for (size_t i = 0; i < 2 * COUNT(row); i++) { // both forms of a file
        const struct glarepp_light *want = &row[i / 2].want;
        struct glarepp_light *got = NULL;
        char text[400];
        int n = -1;
        snprintf(text, sizeof text, i % 2 ? "[%s]" : "{'lights': [%s]}",
                 row[i / 2].text);
        if (gp_lights_read(&kept_log, jf_write(text), &got, &n) || n != 1)
            fail_msg("row %zu: %s", i, kept_line);
        assert_int_equal(got->place, want->place);
        assert_memory_equal(got->at, want->at, sizeof got->at);
        assert_true(got->radius == want->radius);
        assert_true(got->degrees == want->degrees);
        assert_true(got->depth == want->depth ||
                    (isnan(got->depth) && isnan(want->depth)));
        assert_true(got->bias == want->bias);
        assert_memory_equal(got->flux, want->flux, sizeof got->flux);
        assert_memory_equal(got->gain, want->gain, sizeof got->gain);
        assert_string_equal(got->name, want->name);
        gp_free(got);
    }
}

static void files_that_are_refused(void **state)
{
    static const struct {
        const char *text, *say;
    } row[] = {
        {"", "empty"},
        {"3", "not JSON"},
        {"{}", "no \"lights\""},
        {"{'lights': [], 'sun': 1}", "unknown key (found \"sun\")"},
        {"{'lights': {}}", "not an array"},
        {"[3]", "light 1: not an object (found 3)"},
        {"[{}]", "light 1 needs one place (found 0)"},
        {"[{'pixel': [1, 2]}, {'flux': 1}]", "light 2 needs one place"},
        {"[{'pixel': [1, 2], 'world': [1, 2, 3]}]", "(found 2)"},
        {"[{'pixel': [1, 2], 'direction': [1, 2, 3], "
         "'world': [1, 2, 3]}]",
         "(found 3)"},
        {"[{'pixel': [1, 2], 'pixel': [1, 2]}]", "duplicate"},
        {"[{'pixel': [1, 2, 3]}]", "light 1: \"pixel\""},
        {"[{'pixel': 1}]", "light 1: \"pixel\""},
        {"[{'pixel': [1, 1.1e9]}]", "light 1: \"pixel\" out of range"},
        {"[{'world': [1, 2]}]", "light 1: \"world\""},
        {"[{'direction': [0, -0.0, 0]}]", "\"direction\" is 0, 0, 0"},
        {"[{'direction': [1, 2, 3], 'degrees': 1, 'radius': 1}]", "degrees"},
        {"[{'direction': [1, 2, 3], 'degrees': 91}]", "\"degrees\" out of"},
        {"[{'found': [1, 2]}]", "\"found\" without \"name\""},
        {"[{'found': [1, 2], 'name': 'a', 'radius': 3}]", "leave \"radius\""},
        {"[{'found': [[1, 2]], 'name': 'a'}]", "light 1: \"found\""},
        {"[{'found': [[2, 3, 4], [2, 3, 4]], 'name': 'a'}]",
         "frames of \"found\" must rise (found 2 after 2)"},
        {"[{'found': [1, 2], 'name': 'a'}, {'found': [3, 4], 'name': 'a'}]",
         "light 2: a name that one before has (found \"a\")"},
        // more of a light that has a pixel
        {"'Radius': 1", "Radius"},
        {"'radius': -1", "radius"},
        {"'radius': 1000001", "radius"},
        {"'degrees': 1", "degrees"},
        {"'depth': -1", "depth"},
        {"'depth': 'inf'", "depth"},
        {"'bias': 1.5", "bias"},
        {"'flux': [1, 2]", "flux"},
        {"'flux': -1", "flux"},
        {"'flux': 1e13", "flux"},
        {"'color': 1", "color"},
        {"'color': [1, 1, 2e6]", "color"},
        {"'name': 1", "name"},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct glarepp_light *const none = (struct glarepp_light *) kept_line;
        struct glarepp_light *got = none;
        int n = -1;
        char text[200];
        snprintf(text, sizeof text, row[i].text[0] == '\''
                 ? "[{'pixel': [1, 2], %s}]" : "%s", row[i].text);
        gp_status st = gp_lights_read(&kept_log, jf_write(text), &got, &n);
        if (st != GP_ERR_DATA || !strstr(kept_line, row[i].say) ||
            !strstr(kept_line, "; ") || strstr(kept_line, path) != kept_line)
            fail_msg("row %zu: status %d, %s", i, st, kept_line);
        assert_true(got == none && n == -1);
    }
    struct glarepp_light *got;
    int n;
    assert_int_equal(gp_lights_read(&kept_log, folder, &got, &n), GP_ERR_IO);
}

static void counts_up_to_the_limit(void **state)
{
    static const int counts[] = {0, 1, GP_LIGHTS_MAX, GP_LIGHTS_MAX + 1};
    static char text[1 << 16];
    for (size_t k = 0; k < COUNT(counts); k++) {
        struct glarepp_light *got = NULL;
        int at = snprintf(text, sizeof text, "["), n = -1;
        for (int i = 0; i < counts[k]; i++)
            at += snprintf(text + at, sizeof text - (size_t) at,
                           "%s{'pixel': [%d, 7]}", i ? "," : "", i);
        snprintf(text + at, sizeof text - (size_t) at, "]");
        gp_status st = gp_lights_read(&kept_log, jf_write(text), &got, &n);
        if (counts[k] > GP_LIGHTS_MAX) {
            assert_int_equal(st, GP_ERR_DATA);
            assert_kept(path);
            continue;
        }
        assert_ok(st);
        assert_int_equal(n, counts[k]);
        for (int i = 0; i < n; i++)
            assert_true(got[i].at[0] == i && got[i].at[1] == 7.0);
        gp_free(got);
    }
}

/* Looks along +y, z up; 200 pixels of height span 1 at distance 1. */
static struct gp_camera camera(void)
{
    static const double ndc[16] = {0.5, 0, 0, 0, 0.5, 0.5, 1, 1,
                                   0,   -1, 0, 0, 0, 0, -0.1, 0};
    struct gp_camera c;
    if (gp_camera_make(&kept_log, "a.exr", NULL, ndc, GLAREPP_NDC_AUTO, &c))
        fail_msg("%s", kept_line);
    return c;
}

static void places_by_kind(void **state)
{
    const struct gp_camera c = camera();
    // a disc in the middle: tan(0.2665 degrees) of 200 pixels
    static const double sun = 0.93026719998;
    static const struct {
        struct glarepp_light spec;
        enum glarepp_depth type;
        double x, y, radius, depth;
        bool behind;
    } row[] = {
        {{.place = GLAREPP_PIXEL, .at = {-7, 1e6}, .radius = 3, .depth = NAN},
         GLAREPP_Z,
         -7,
         1e6,
         3,
         INFINITY,
         false},
        {{.place = GLAREPP_PIXEL, .radius = -1, .depth = 5},
         GLAREPP_NORMALIZED,
         0,
         0,
         0.5,
         5,
         false},
        {{.place = GLAREPP_DIRECTION,
          .at = {0, 2, 0},
          .radius = -1,
          .degrees = 0.533,
          .depth = NAN},
         GLAREPP_Z,
         200,
         100,
         sun,
         INFINITY,
         false},
        {{.place = GLAREPP_DIRECTION,
          .at = {0, 2, 0},
          .radius = 4,
          .degrees = 0.533,
          .depth = NAN},
         GLAREPP_NORMALIZED,
         200,
         100,
         4,
         INFINITY,
         false},
        {{.place = GLAREPP_DIRECTION,
          .at = {0, -2, 0},
          .radius = -1,
          .degrees = 0.533,
          .depth = NAN},
         GLAREPP_Z,
         0,
         0,
         0,
         INFINITY,
         true},
        {{.place = GLAREPP_WORLD, .at = {3, 4, 0}, .radius = 1, .depth = NAN},
         GLAREPP_Z,
         350,
         100,
         1,
         4,
         false},
        {{.place = GLAREPP_WORLD, .at = {3, 4, 0}, .radius = 1, .depth = NAN},
         GLAREPP_INVERSE,
         350,
         100,
         1,
         4,
         false},
        {{.place = GLAREPP_WORLD, .at = {3, 4, 0}, .radius = 1, .depth = NAN},
         GLAREPP_RAY,
         350,
         100,
         1,
         5,
         false},
        {{.place = GLAREPP_WORLD, .at = {3, 4, 0}, .radius = 1, .depth = 0.25},
         GLAREPP_NORMALIZED,
         350,
         100,
         1,
         0.25,
         false},
        {{.place = GLAREPP_WORLD, .at = {3, 0, 0}, .radius = 1, .depth = NAN},
         GLAREPP_Z,
         0,
         0,
         1,
         0,
         true},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_light l = {0};
        struct glarepp_light spec = row[i].spec;
        spec.bias = 0.25;
        spec.flux[1] = 7;
        if (gp_light_place_in(&kept_log, "a.exr", &spec, &c, row[i].type,
                              window, &l))
            fail_msg("row %zu: %s", i, kept_line);
        if (!(fabs(l.x - row[i].x) < 1e-9 && fabs(l.y - row[i].y) < 1e-9 &&
            fabs(l.radius - row[i].radius) < 1e-9 &&
            (l.depth == row[i].depth || fabs(l.depth - row[i].depth) < 1e-12)))
            fail_msg("row %zu: %.12g, %.12g radius %.12g depth %.12g", i, l.x,
                     l.y, l.radius, l.depth);
        assert_int_equal(l.behind, row[i].behind);
        assert_true(l.bias == 0.25 && l.visibility == 1.0);
        assert_true(l.flux[0] == 0 && l.flux[1] == 7 && l.flux[2] == 0);
    }
}

/* The disc in the world of a light in its place. */
static void sights_by_kind(void **state)
{
    const struct gp_camera c = camera();
    static const struct {
        struct glarepp_light spec;
        struct gp_light_sight want;
        double radius, bias; // pixels; beside the light's own
    } row[] = {
        {{.place = GLAREPP_DIRECTION, .at = {0, 2, 0}, .radius = -1,
          .degrees = 0.533}, {true, false, {0, 2, 0}, 0.533 * M_PI / 360.0},
         0.93026719998, 0.0},
        {{.place = GLAREPP_DIRECTION, .at = {0, -2, 0}, .radius = -1,
          .degrees = 0.533}, {true, false, {0, -2, 0}, 0.533 * M_PI / 360.0},
         0.0, 0.0},
        {{.place = GLAREPP_PIXEL, .at = {200, 100}, .radius = 0.93026719998},
         {true, false, {0, 1, 0}, 0.533 * M_PI / 360.0}, 0.93026719998, 0.0},
        {{.place = GLAREPP_WORLD, .at = {0, 8, 0}, .radius = -1, .ball = 2},
         {true, true, {0, 8, 0}, 0.2526802551}, 51.63977795, 0.25},
        {{.place = GLAREPP_WORLD, .at = {0, -8, 0}, .radius = -1, .ball = 4},
         {true, true, {0, -8, 0}, M_PI / 6.0}, 0.0, 0.0},
        {{.place = GLAREPP_WORLD, .at = {0, 1, 0}, .radius = -1, .ball = 2},
         {true, true, {0, 1, 0}, M_PI / 2.0}, 0.0, 0.75},
        {{.place = GLAREPP_WORLD, .at = {0, 8, 0}, .radius = 51.63977795},
         {true, true, {0, 8, 0}, 0.2526802551}, 51.63977795, 0.0},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_light l;
        struct glarepp_light spec = row[i].spec;
        spec.bias = 0.25;
        spec.depth = NAN;
        assert_ok(gp_light_place_in(&kept_log, "a.exr", &spec, &c, GLAREPP_Z,
                                    window, &l));
        assert_true(l.sight.known && l.sight.lamp == row[i].want.lamp);
        double off = 0.0;
        for (int k = 0; k < 3; k++)
            off += fabs(l.sight.at[k] - row[i].want.at[k]);
        if (!(off < 1e-9 && fabs(l.sight.half - row[i].want.half) < 1e-9 &&
              fabs(l.radius - row[i].radius) < 1e-6 &&
              fabs(l.bias - 0.25 - row[i].bias) < 1e-12))
            fail_msg("row %zu: half %.12g, radius %.12g, bias %.12g", i,
                     l.sight.half, l.radius, l.bias);
    }
    // no camera: no place in the world
    struct gp_light l;
    const struct glarepp_light plain = {.at = {3, 4}, .radius = 2, .depth = NAN};
    assert_ok(gp_light_place_in(&kept_log, "a.exr", &plain, NULL, GLAREPP_Z,
                                window, &l));
    assert_false(l.sight.known);
}

static void places_that_cannot_be(void **state)
{
    const struct gp_camera c = camera();
    static const struct {
        struct glarepp_light spec;
        bool has_camera;
        enum glarepp_depth type;
        gp_status st;
    } row[] = {
        {{.place = GLAREPP_WORLD, .at = {0, 1, 0}, .depth = NAN},
         false,
         GLAREPP_Z,
         GP_ERR_USAGE},
        {{.place = GLAREPP_DIRECTION, .at = {0, 1, 0}, .depth = 3},
         false,
         GLAREPP_Z,
         GP_ERR_USAGE},
        {{.place = GLAREPP_WORLD, .at = {0, 1, 0}, .depth = NAN},
         true,
         GLAREPP_NORMALIZED,
         GP_ERR_DATA},
        {{.place = GLAREPP_PIXEL, .depth = NAN}, false, GLAREPP_Z, GP_OK},
    };
    for (size_t i = 0; i < COUNT(row); i++) {
        struct gp_light l = {.x = 99};
        gp_status st = gp_light_place_in(&kept_log, "a.exr", &row[i].spec,
                                         row[i].has_camera ? &c : NULL,
                                         row[i].type, window, &l);
        if (st != row[i].st)
            fail_msg("row %zu: status %d, %s", i, st, kept_line);
        assert_true(st == GP_OK || l.x == 99);
        assert_true(st == GP_OK || strstr(kept_line, "a.exr: ") == kept_line);
    }
}

SUITE_OF(lights, make_folder, remove_folder, lights_by_text, files_that_are_refused,
         counts_up_to_the_limit, places_by_kind, sights_by_kind, places_that_cannot_be)
