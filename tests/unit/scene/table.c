/* Table 15-1: each row draws the same picture with no more batches than the row
 * before, and those that its sets say. */
#include "unit.h"
#include "gl_open.h"
#include "scene/table.h"
#include "scene_made.h"

static void rows_draw_the_same_picture(void **state)
{
    struct gp_gl *gl = open_or_skip(GP_GL_AUTO);
    struct gp_table_params p = GP_TABLE_DEFAULTS;
    int first = 0, last = 0;
    p.draw.w = 128;
    p.draw.h = 80;
    p.draw.map = 96;
    p.draw.light_scale = 1.0;
    p.runs = 1;
    p.occluders = 12;
    for (uint64_t k = 0; k < 8; k++) {
        uint64_t seed = 2004 + k;
        struct gp_scene s = made_random_scene(&seed, 80, 5);
        const struct gp_v3 eye = {k & 1 ? 18 : 0, -25.0 + 4.0 * (double) k, 4};
        const struct gp_camera c = made_camera(&s, eye, (struct gp_v3) {0, 0, 3},
                                               50.0, 1.6);
        struct gp_table t = {0};
        p.draw.separate = k == 3;
        if (gp_table_make(&kept_log, gl, &s, &c, &p, &t) != GP_OK)
            fail_msg("%s", kept_line);
        for (int i = 0; i < GP_TABLE_ROWS; i++) {
            const struct gp_table_row *const r = &t.row[i];
            if (!r->same)
                fail_msg("seed %d: row %s draws another picture", (int) k,
                         gp_table_names[i]);
            assert_true(r->ms > 0.0 && r->drawn.lights <= 5);
            assert_true(i == 0 || r->visible <= t.row[i - 1].visible);
            assert_true(i == 0 || r->lit <= t.row[i - 1].lit);
            assert_true(i == 0 || r->casters <= t.row[i - 1].casters);
            assert_true(i < 2 || r->drawn.batches <= t.row[i - 1].drawn.batches);
            if (gp_gl_info(gl)->counts)
                assert_true(r->fragments >= 0);
        }
        first += t.row[0].drawn.batches;
        last += t.row[GP_TABLE_ROWS - 1].drawn.batches;
        gp_table_free(&t);
        assert_null(t.picture);
        made_free(&s);
    }
    if (last * 10 > first * 9)
        fail_msg("%d batches with all sets, %d by the frustum", last, first);
    gp_gl_close(&gl);
}

SUITE_OF(table, NULL, NULL, rows_draw_the_same_picture)
