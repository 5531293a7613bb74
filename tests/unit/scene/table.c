// SPDX-License-Identifier: Apache-2.0
/* Table 15-1: each row draws the same picture with no more batches than the row
 * before, and those that its sets say. */
#include "unit.h"
#include "gl_open.h"
#include "scene/sets/sets_priv.h"
#include "scene_made.h"

static void rows_draw_the_same_picture(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct glarepp_sets_params p = {
        .w = 128, .h = 80, .near = 0.1, .light_scale = 1.0, .ambient = 0.02,
        .map = 96, .runs = 1, .occluders = 12,
    };
    int first = 0, last = 0;
    for (uint64_t k = 0; k < 8; k++) {
        uint64_t seed = 2004 + k;
        struct gp_scene s = made_random_scene(&seed, 80, 5);
        const struct gp_v3 eye = {k & 1 ? 18 : 0, -25.0 + 4.0 * (double) k, 4};
        const struct gp_camera c = made_camera(&s, eye, (struct gp_v3) {0, 0, 3},
                                               50.0, 1.6);
        struct gp_table t = {0};
        p.separate = k == 3;
        if (gp_table_make(&kept_log, gl, &s, &c, &p, &t) != GP_OK)
            fail_msg("%s", kept_line);
        for (int i = 0; i < GP_TABLE_ROWS; i++) {
            const struct glarepp_sets_row *const r = &t.row[i];
            if (!r->same)
                fail_msg("seed %d: row %s draws another picture", (int) k,
                         r->name);
            assert_true(r->ms > 0.0 && r->lights <= 5);
            assert_true(i == 0 || r->visible <= t.row[i - 1].visible);
            assert_true(i == 0 || r->lit <= t.row[i - 1].lit);
            assert_true(i == 0 || r->casters <= t.row[i - 1].casters);
            assert_true(i < 2 || r->batches <= t.row[i - 1].batches);
            assert_true((r->fragments < 0) == (t.row[0].fragments < 0));
        }
        first += t.row[0].batches;
        last += t.row[GP_TABLE_ROWS - 1].batches;
        gp_table_free(&t);
        assert_null(t.picture);
        made_free(&s);
    }
    if (last * 10 > first * 9)
        fail_msg("%d batches with all sets, %d by the frustum", last, first);
    gp_gl_close(&gl);
}

/* Suns and lamps that graze a slab, and boxes, balls and cards close to it: maps
 * of coarse texels light no surface that umbras leave out. */
static void light_grazes_slabs(void **state)
{
    static const struct gp_box world = {{-9, -9, -4}, {9, 9, 4}};
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct glarepp_sets_params p = {
        .w = 160, .h = 90, .near = 0.1, .light_scale = 1.0, .ambient = 0.02,
        .runs = 1, .occluders = 40,
    };
    int first = 0, last = 0;
    for (uint64_t k = 0; k < 60; k++) {
        uint64_t seed = 1501 + k;
        struct gp_scene s = made_scene();
        const int slab = made_box(&s, 0);
        const int mesh[] = {slab, made_ball(&s, 0, 4), made_card(&s, 0)};
        const struct gp_v3 thin = {20, 20, 0.3};
        made_put_along(&s, slab, (struct gp_v3) {0, 0, 0}, thin,
                       made_within(&seed, world));
        for (int i = 0; i < 6; i++) {
            const double big = made_between(&seed, 0.3, 4.0);
            made_put_along(&s, mesh[i % 3], made_within(&seed, world),
                           (struct gp_v3) {big, big, 0.5 * big},
                           made_within(&seed, world));
        }
        for (int i = 0; i < 3; i++)
            made_sun(&s, made_within(&seed, world), 3.0);
        made_point(&s, made_within(&seed, world), 50.0, 30.0);
        const struct gp_camera c = made_camera(
            &s, (struct gp_v3) {0, -22, 6}, (struct gp_v3) {0, 0, 0}, 50.0,
            16.0 / 9.0);
        struct gp_table t = {0};
        p.map = 64 << (k % 3);
        if (gp_table_make(&kept_log, gl, &s, &c, &p, &t) != GP_OK)
            fail_msg("%s", kept_line);
        for (int i = 0; i < GP_TABLE_ROWS; i++) {
            if (!t.row[i].same)
                fail_msg("seed %d: row %s draws another picture", (int) k,
                         t.row[i].name);
        }
        first += t.row[0].lit;
        last += t.row[GP_TABLE_ROWS - 1].lit;
        gp_table_free(&t);
        made_free(&s);
    }
    if (last >= first) // umbras left something out
        fail_msg("%d objects lit of %d", last, first);
    gp_gl_close(&gl);
}

SUITE_OF(table, NULL, NULL, rows_draw_the_same_picture, light_grazes_slabs)
