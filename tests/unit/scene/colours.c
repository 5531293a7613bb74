// SPDX-License-Identifier: Apache-2.0
/* Albedo of materials from a frame's pixels. */
#include "scene/relight_priv.h"

#include "kept_log.h"
#include "scene_made.h"
#include "unit.h"

enum { SEEN, WOVEN, UNSEEN, MATERIALS };

static void albedo_is_that_of_the_pixels(void **state)
{
    struct gp_material material[MATERIALS] = {
        {.base = {0.2f, 0.4f, 0.8f, 1}}, {.base = {1, 1, 1, 1}},
        {.base = {0.6f, 0.5f, 0.4f, 1}}};
    const struct gp_scene s = {.material = material, .materials = MATERIALS};
    (void) state;
    for (int pass = 0; pass < 2; pass++) {
        const float k = pass ? 0.5f : 1.0f;
        struct gp_shade shade[100];
        struct gp_colours got;
        for (int i = 0; i < 100; i++) {
            const float part = i % 2 ? k : k * (float) i / 100;
            shade[i] = i % 10 == 0 ? (struct gp_shade) {-1, {9, 9, 9}}
                       : i < 50    ? (struct gp_shade) {SEEN, {k, k / 2, k / 4}}
                                   : (struct gp_shade) {WOVEN, {part, part, k}};
        }
        shade[11].albedo[0] = 7.0f; // one that is none of it
        assert_ok(gp_colours_make(&kept_log, &s, shade, 100, &got));
        assert_true(got.of[SEEN][0] == (double) k);
        assert_true(got.of[SEEN][1] == (double) k / 2);
        assert_true(got.of[SEEN][2] == (double) k / 4);
        assert_true(!got.many[SEEN] && got.many[WOVEN] && !got.many[UNSEEN]);
        assert_true(got.unit > 0.8 * (double) k && got.unit < 1.3 * (double) k);
        for (int c = 0; c < 3; c++)
            assert_true(got.of[UNSEEN][c] ==
                        got.unit * (double) material[UNSEEN].base[c]);
        gp_colours_free(&got);
    }
}

static void no_pixel_leaves_base_colours(void **state)
{
    struct gp_material material[1] = {{.base = {0.2f, 0.4f, 0.8f, 1}}};
    const struct gp_scene s = {.material = material, .materials = 1};
    struct gp_shade none[2] = {{-1, {0}}, {-1, {0.5f, 0.5f, 0.5f}}};
    struct gp_colours got;
    (void) state;
    assert_ok(gp_colours_make(&kept_log, &s, none, 1, &got));
    assert_true(got.unit == 1.0 && got.of[0][2] == (double) 0.8f);
    gp_colours_free(&got);
    assert_ok(gp_colours_make(&kept_log, &s, none, 2, &got));
    assert_true(got.unit == 2.0 && got.of[0][2] == 2.0 * (double) 0.8f);
    gp_colours_free(&got);
}

SUITE_OF(colours, NULL, NULL, albedo_is_that_of_the_pixels,
         no_pixel_leaves_base_colours)
