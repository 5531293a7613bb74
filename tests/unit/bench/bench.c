// SPDX-License-Identifier: Apache-2.0
/* bench: the Pareto front, parts of a frame, options, files. */
#include "unit.h"
#include "bench/bench_priv.h"

static void the_front_is_what_nothing_beats(void **state)
{
    static const struct {
        double ms, least, error; // error < 0: not measured
        bool pareto;
    } rows[] = {
        {10, 10, 1e-3, true},
        {20, 20, 1e-7, true},
        {5, 5, 1e-1, true},
        {20, 20, 1e-3, false}, // slower than the first, as wrong
        {10, 10, 1e-2, false}, // as fast as the first, more wrong
        {1, 1, -1, false},
        {30, 30, 1e-8, true},
        {30, 30, 1e-8, true},   // twins
        {31, 29.9, 1e-8, true}, // its fastest run is faster than their median
        {31, 29.9, 2e-8, true}, // and so it is where another has less error
        {31, 30.1, 1e-8, false},
        {40, 40, 0, true},
        {5.1, 5.1, 2e-1, false},
        {50, 50, 0, false},
        {60, 60, INFINITY, false},
    };
    struct gp_bench_frame f = {.rows = COUNT(rows)};
    for (size_t i = 0; i < COUNT(rows); i++) {
        f.row[i].took.ms = rows[i].ms;
        f.row[i].took.least = rows[i].least;
        f.row[i].error[GP_REL_L2] =
            rows[i].error >= 0.0 ? rows[i].error : (double) NAN;
    }
    gp_bench_mark_pareto(&f);
    for (size_t i = 0; i < COUNT(rows); i++) {
        if (f.row[i].pareto != rows[i].pareto)
            fail_msg("row %zu", i);
    }
}

/* The fastest row within each error, by each measure; none where none is. */
static void choices_are_the_fastest(void **state)
{
    struct gp_bench_frame f = {
        .rows = 4,
        .row = {{.took.ms = 9, .error = {1e-7, 1e-3, NAN}},
                {.took.ms = 5, .error = {1e-3, .5, 1e-2}},
                {.took.ms = 1, .error = {NAN, NAN, NAN}},
                {.took.ms = 2, .error = {0, 0, 0}, .layer = "flare"}}};
    static const int want[GP_BENCH_BY][GP_BENCH_WITHIN] = {
        {1, 1, 1, 0},
        {0, 0, 0, -1},
        {1, 1, -1, -1},
    };
    gp_bench_mark_pareto(&f);
    assert_memory_equal(f.choice, want, sizeof want);
}

/* Rows of another layer are beaten by rows of that layer only. */
static void layers_have_their_own_front(void **state)
{
    static const char flare[] = "flare", lens[] = "lens";
    struct gp_bench_frame f = {
        .rows = 4,
        .row = {
            {.took = {.ms = 1, .least = 1}, .error = {1e-8}},
            {.took = {.ms = 9, .least = 9}, .error = {1e-3}, .layer = flare},
            {.took = {.ms = 10, .least = 10}, .error = {1e-3}, .layer = lens},
            {.took = {.ms = 11, .least = 11}, .error = {1e-2}, .layer = lens}}};
    gp_bench_mark_pareto(&f);
    assert_true(f.row[0].pareto && f.row[1].pareto && f.row[2].pareto);
    assert_false(f.row[3].pareto);
}

static void options_ask_for_the_technique(void **state)
{
    static const struct {
        const char *name, *options;
    } rows[] = {
        {"direct", "-e direct"},
        {"fft", "-e fft"},
        {"splat group 8", "-e splat --group 8 --cluster 0 --shrink 0"},
        {"splat 4/8/1e-3", "-e splat --group 4 --cluster 8 --shrink 0.001"},
        {"levels", "-e fft --tolerance 0.001"},
        {"levels 1e-2", "-e fft --tolerance 0.01"},
        {"auto", "-e auto --tolerance 0.25"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        const struct gp_bench_technique *t = gp_bench_techniques;
        char line[sizeof((struct gp_bench_row *) 0)->options];
        while (t->name && strcmp(t->name, rows[i].name) != 0)
            t++;
        assert_non_null(t->name);
        gp_bench_options(t, 0.25f, false, line, sizeof line);
        assert_string_equal(line, rows[i].options);
        // of true angles, what draws a plane asks for it
        char angles[sizeof line];
        gp_bench_options(t, 0.25f, true, angles, sizeof angles);
        if (!t->follows)
            strcat(line, " --projection plane");
        assert_string_equal(line, angles);
    }
}

/* A time of a fixed part and one that grows with the sources is found as it is: over
 * shares of it alone, 0.5 s of the first are 5 s. */
static void a_fixed_part_is_not_multiplied(void **state)
{
    static const double fixed[] = {0.0, 40.0, 500.0}, each[] = {0.0, 70.0, 9e4};
    static const double share[][2] = {{0.011, 0.1}, {0.0009, 0.01}};
    for (int i = 0; i < 18; i++) {
        const double a = fixed[i % 3], b = each[i / 3 % 3];
        const double *const s = share[i / 9];
        const double ms[2] = {a + b * s[0], a + b * s[1]};
        assert_true(fabs(gp_bench_whole_ms(s, ms) - (a + b)) <= 1e-9 * (a + b));
    }
    // times that jump never fall as sources are added
    assert_true(gp_bench_whole_ms(share[0], (const double[]) {9.0, 8.0}) ==
                8.0);
}

static struct gp_frame grey(int w, int h, float light)
{
    struct gp_frame f = {.data = {-9, 5, w - 9, h + 5},
                         .luminance = {0.25f, 0.5f, 0.25f}};
    assert_ok(gp_planes_make(NULL, "test", gp_frame_pixels(&f), &f.rgb));
    for (size_t i = 0; i < 3 * gp_frame_pixels(&f); i++)
        f.rgb.c[i % 3][i / 3] = light + (float) (i / 3 % 7);
    return f;
}

static void parts_are_even_and_untouched(void **state)
{
    static const struct {
        int w, h, parts;
        double least, most; // share of the light's pixels
    } rows[] = {
        {1024, 768, 10, 0.09, 0.11},   {1024, 768, 100, 0.008, 0.012},
        {1000, 70, 10, 0.07, 0.13},    {70, 1000, 10, 0.07, 0.13},
        {2048, 1536, 100, 0.009, 0.011}, {7, 5, 10, 1.0, 1.0},
    };
    for (size_t r = 0; r < COUNT(rows); r++) {
        struct gp_frame f = grey(rows[r].w, rows[r].h, 2.0f), part;
        const size_t n = gp_frame_pixels(&f);
        size_t lit = 0;
        assert_ok(gp_bench_thin(NULL, &f, rows[r].parts, &part));
        assert_true(part.data.x0 == -9 && part.data.y0 == 5);
        for (size_t i = 0; i < n; i++) {
            const float v = part.rgb.c[1][i];
            assert_true(v == 0.0f || v == f.rgb.c[1][i]);
            lit += v > 0.0f;
        }
        const double share = (double) lit / (double) n;
        if (!(share >= rows[r].least && share <= rows[r].most))
            fail_msg("row %zu: a share of %g", r, share);
        gp_frame_free(&part);
        gp_frame_free(&f);
    }
}

SUITE_OF(bench, NULL, NULL, the_front_is_what_nothing_beats,
         choices_are_the_fastest, layers_have_their_own_front,
         options_ask_for_the_technique, parts_are_even_and_untouched,
         a_fixed_part_is_not_multiplied)
