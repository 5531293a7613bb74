/* io/picture: each row is run once, in scratch that no other row has at the
 * same time; display windows that are none; alpha. */
#include "unit.h"
#include "write_fixture.h"

#include "core/parallel.h"
#include "io/picture.h"

struct seen {
    int width;
    int *runs, *wrong; // of each row
};

/* Fills the whole scratch with what this row alone writes, then looks. */
static void fill_and_look(void *ctx, int y, struct gp_picture_row *row)
{
    const struct seen *const s = ctx;
    for (int c = 0; c < 4; c++) {
        for (int x = 0; x < s->width; x++) {
            row->code[c][x] = (uint16_t) (4 * y + c);
            row->linear[c][x] = (float) (-4 * y - c);
        }
    }
    for (int c = 0; c < 4; c++) {
        for (int x = 0; x < s->width; x++)
            s->wrong[y] += row->code[c][x] != (uint16_t) (4 * y + c) ||
                           row->linear[c][x] != (float) (-4 * y - c);
    }
    s->runs[y]++;
}

static void each_row_is_run_once(void **state)
{
    static const struct {
        int w, h, threads;
    } rows[] = {
        {1, 1, 1},   {1, 1, 5},    {1, 301, 5},     {3001, 1, 5},
        {7, 2, 256}, {97, 211, 1}, {4099, 1000, 5}, {4099, 1000, 0},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_picture pic = {.width = rows[i].w,
                                       .height = rows[i].h};
        const size_t h = (size_t) rows[i].h;
        struct seen s = {rows[i].w, calloc(h, sizeof(int)),
                         calloc(h, sizeof(int))};
        assert_true(s.runs && s.wrong);
        gp_set_threads(rows[i].threads);
        assert_ok(gp_picture_each_row(NULL, &pic, fill_and_look, &s));
        for (size_t y = 0; y < h; y++) {
            if (s.runs[y] != 1 || s.wrong[y])
                fail_msg("%dx%d, %d threads, row %zu: run %d times, %d "
                         "samples of another row", rows[i].w, rows[i].h,
                         rows[i].threads, y, s.runs[y], s.wrong[y]);
        }
        free(s.runs);
        free(s.wrong);
    }
    gp_set_threads(0);
}

static void windows_that_are_no_picture(void **state)
{
    static const struct gp_rect display[] = {
        {0, 0, 0, 5}, {0, 0, 5, 0}, {3, 0, -2, 5}, {0, 9, 5, 2},
        {INT32_MIN, 0, INT32_MAX, 1}, {0, INT32_MIN, 1, INT32_MAX},
        {0, 0, 1 << 29, 1}, {0, 0, 1 << 20, (1 << 20) + 1},
    };
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_sized(2, 2, wf_rgb);
    for (size_t i = 0; i < COUNT(display); i++) {
        struct gp_picture pic;
        f.display = display[i];
        wf_line[0] = '\0';
        assert_int_equal(gp_picture_make(&wf_log, &p, "p.png", &f, &f.rgb,
                                         GP_PICTURE_SCENE, false, &pic),
                         GP_ERR_DATA);
        wf_assert_said("p.png: no picture of this display window (");
        assert_int_equal(pic.channels, 0); // empty
    }
    gp_frame_free(&f);
}

/* Rows of floats with alpha, the picture wider than the data. */
static void floats_with_alpha(void **state)
{
    const struct gp_rect data = {1, 0, 3, 2}, display = {0, 0, 4, 2};
    struct gp_write_params p = GP_WRITE_DEFAULTS;
    struct gp_frame f = wf_frame(data, display, wf_all);
    struct gp_picture pic;
    float to[4][4];
    struct gp_picture_row row = {.linear = {to[0], to[1], to[2], to[3]}};
    p.alpha = GP_ALPHA_KEEP;
    assert_ok(gp_picture_make(&wf_log, &p, "p", &f, &f.rgb, GP_PICTURE_SCENE,
                              false, &pic));
    assert_int_equal(pic.channels, 4);
    for (int y = 0; y < 2; y++) {
        memset(to, 0xff, sizeof to);
        gp_picture_floats(&pic, y, &row);
        for (int c = 0; c < 4; c++) {
            const int number = c < 3 ? c : 0; // alpha is channel 0 of the list
            assert_true(to[c][0] == 0.0f && to[c][3] == 0.0f);
            for (int x = 0; x < 2; x++)
                assert_true(to[c][1 + x] == wf_value(number, x, y));
        }
    }
    gp_picture_free(&pic);
    gp_frame_free(&f);
}

SUITE_OF(picture, NULL, NULL, each_row_is_run_once,
         windows_that_are_no_picture, floats_with_alpha)
