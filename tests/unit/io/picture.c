/* io/picture: each row is run once, in scratch that no other row has at the
 * same time. */
#include "unit.h"
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
    (void) state;
    for (size_t i = 0; i < sizeof rows / sizeof *rows; i++) {
        const struct gp_picture pic = {.width = rows[i].w,
                                       .height = rows[i].h};
        const size_t h = (size_t) rows[i].h;
        struct seen s = {rows[i].w, calloc(h, sizeof(int)),
                         calloc(h, sizeof(int))};
        assert_true(s.runs && s.wrong);
        gp_set_threads(rows[i].threads);
        assert_int_equal(gp_picture_each_row(NULL, &pic, fill_and_look, &s),
                         GP_OK);
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

SUITE_OF(picture, NULL, NULL,
    each_row_is_run_once)
