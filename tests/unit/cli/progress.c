// SPDX-License-Identifier: Apache-2.0
/* cli/progress: the line on the terminal, and which frames failed, as a list
 * that --frames takes. */
#include "unit.h"
#include "cli/progress.h"
#include "core/clock.h"
#include "kept_log.h"

// -- failed frames -----------------------------------------------------------

/* The list in the last message, "" when it has none; *whole: --frames would
 * take it. */
static const char *printed_list(bool *whole)
{
    static char list[2 * GP_FAILURES_BYTES];
    const char *const from = strstr(kept_line, "failed (");
    const char *const end = from ? strstr(from, "); ") : NULL;
    snprintf(list, sizeof list, "%.*s", end ? (int) (end - from - 8) : 0,
             end ? from + 8 : "");
    *whole = strstr(kept_line, " --frames ") != NULL;
    return list;
}

/* The list of these frames when they fail, every other of the jobs. */
static const char *list_of(const struct gp_frames *f, bool *whole)
{
    struct gp_jobs j = {.n = 2 * f->n, .views = 1};
    j.job = calloc((size_t) j.n, sizeof *j.job);
    assert_non_null(j.job);
    for (int i = 0; i < j.n; i++)
        j.job[i] = (struct gp_job) {strdup("in.exr"), i % 2 == 0,
                                    i % 2 ? 0 : f->number[i / 2], NULL,
                                    i % 2 == 0};
    kept_clear();
    assert_int_equal(gp_failures_report(&kept_log, &j, 0), GP_ERR_FRAMES);
    gp_jobs_free(&j);
    return printed_list(whole);
}

static void failed_lists(void **state)
{
    static const char *const rows[][2] = {
        {"5", "5"}, {"5,6", "5-6"}, {"5,7", "5,7"}, {"-3--1", "-3--1"},
        {"1,2,3,7,9,12", "1-3,7,9,12"}, {"7-5,1", "7,6,5,1"},
        {"-999999999,999999999,-999999998", "-999999999,999999999,-999999998"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_frames f, back;
        bool whole;
        assert_ok(gp_frames_parse(NULL, rows[i][0], &f));
        const char *const text = list_of(&f, &whole);
        assert_string_equal(text, rows[i][1]);
        assert_true(whole);
        // --frames reads the same frames from it
        assert_ok(gp_frames_parse(NULL, text, &back));
        assert_int_equal(back.n, f.n);
        assert_memory_equal(back.number, f.number,
                            (size_t) f.n * sizeof *f.number);
        gp_frames_free(&back);
        gp_frames_free(&f);
    }
}

/* A list that does not fit ends with the count of the rest. */
static void long_lists_are_cut(void **state)
{
    enum { N = 400 };
    int number[N], items = 1, more = 0;
    const struct gp_frames f = {.number = number, .n = N};
    bool whole;
    for (int i = 0; i < N; i++) // no two in a row
        number[i] = i * i * 7 + i % 3;
    const char *const text = list_of(&f, &whole);
    const char *const rest = strstr(text, " and ");
    assert_true(rest && !whole && strlen(text) < GP_FAILURES_BYTES);
    for (const char *c = text; *c; c++)
        items += *c == ',';
    assert_int_equal(sscanf(rest, " and %d more", &more), 1);
    assert_int_equal(items + more, N);
}

static void names_without_numbers(void **state)
{
    struct gp_job job[] = {{(char *) "a.exr", false, 0, NULL, false},
                           {(char *) "b.0007.exr", true, 7, NULL, true},
                           {(char *) "c.exr", false, 0, NULL, false}};
    const struct gp_jobs j = {.job = job, .n = 3, .views = 1};
    bool whole;
    assert_int_equal(gp_failures_report(&kept_log, &j, 0), GP_ERR_FRAMES);
    assert_string_equal(printed_list(&whole), "7");
    assert_true(whole);
    job[0].failed = true; // one without a number: names
    assert_int_equal(gp_failures_report(&kept_log, &j, 0), GP_ERR_FRAMES);
    assert_string_equal(printed_list(&whole), "a.exr, b.0007.exr");
    assert_false(whole);
}

/* Jobs that fail, of frames 1 to 5 or of nameless ones, each of two views. */
static void failed_views(void **state)
{
    static char l[] = "l", r[] = "r";
    char *const views[] = {l, r};
    static const struct {
        int views;          // jobs of one input: 1 or 2
        bool numbered;
        const char *bad;    // a sign for each job, x where it fails
        int frames;
        const char *list;
    } rows[] = {
        {1, true, "x.........", 1, "1"}, {1, true, ".x........", 1, "1"},
        {1, true, "xx........", 1, "1"}, {1, true, "x..x.x.xx.", 5, "1-5"},
        {2, true, ".x......xx", 2, "1,5"}, {2, true, ".xxx......", 2, "1-2"},
        {1, false, ".xx.......", 2, "1.r, 2.l"},
        {1, false, "xx........", 1, "1.l, 1.r"},
        {2, false, ".xx.......", 2, "1.l, 2.l"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        struct gp_job job[10];
        char name[10][24], frames[32];
        bool whole;
        for (int k = 0; k < 10; k++) {
            snprintf(name[k], sizeof name[k], "%d.%s", k / 2 + 1, views[k % 2]);
            job[k] = (struct gp_job) {name[k], rows[i].numbered, k / 2 + 1,
                                      views[k % 2], rows[i].bad[k] == 'x'};
        }
        const struct gp_jobs j = {
            .job = job, .n = 10, .views = rows[i].views,
            .view = {.name = {l, r}, .n = 2},
        };
        assert_int_equal(gp_failures_report(&kept_log, &j, 0), GP_ERR_FRAMES);
        snprintf(frames, sizeof frames, "%d of 5 frames", rows[i].frames);
        assert_kept(frames);
        assert_string_equal(printed_list(&whole), rows[i].list);
    }
}

/* Returns what an update draws into a file that is no terminal, `ms` after the
 * start; "" for nothing. */
static const char *drawn(enum gp_progress_when when, bool quiet, int done,
                         int total, double ms, const char *name)
{
    static char line[128];
    FILE *const f = tmpfile();
    struct gp_progress p;
    gp_progress_open(&p, f, quiet ? GP_PROGRESS_NEVER : when);
    p.start_ms = gp_now_ms() - ms;
    gp_progress_update(&p, done, total, name, "read");
    gp_progress_close(&p);
    line[0] = '\0';
    rewind(f);
    (void) !fgets(line, sizeof line, f);
    fclose(f);
    return line;
}

static void progress_lines(void **state)
{
    static const struct {
        int done, total;
        double ms;
        const char *line;
    } rows[] = {
        {0, 1, 2000, "0 of 1 made, 2 s so far: f"},
        {1, 100, 250, "1 of 100 made, 4.0 frames/s, 25 s left: f"},
        {50, 100, 100000, "50 of 100 made, 0.500 frames/s, 1 min 40 s left: f"},
        {1, 101, 100000, "1 of 101 made, 0.010 frames/s, 2 h 46 min left: f"},
    };
    for (size_t i = 0; i < COUNT(rows); i++) {
        char line[128];
        snprintf(line, sizeof line, "glarepp: %s: read\n", rows[i].line);
        assert_string_equal(drawn(GP_PROGRESS_ALWAYS, false, rows[i].done,
                                  rows[i].total, rows[i].ms, "f"), line);
    }
    // a file's name cannot move the cursor
    assert_string_equal(drawn(GP_PROGRESS_ALWAYS, false, 0, 2, 0.0,
                              "b/a\x1b[2J.exr"),
                        "glarepp: 0 of 2 made, 0 s so far: a?[2J.exr: read\n");
    assert_string_equal(drawn(GP_PROGRESS_AUTO, false, 0, 2, 0.0, "f"), "");
    assert_string_equal(drawn(GP_PROGRESS_NEVER, false, 0, 2, 0.0, "f"), "");
    assert_string_equal(drawn(GP_PROGRESS_ALWAYS, true, 0, 2, 0.0, "f"), "");
}

SUITE_OF(progress, NULL, NULL, failed_lists, long_lists_are_cut,
         names_without_numbers, failed_views, progress_lines)
