/* app/tally: which frames failed, as a list that --frames takes. */
#include "unit.h"
#include "app/progress.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static char said[4096];

static void keep_line(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(said, sizeof said, "%s", line);
}

static const struct gp_log keeper = {keep_line, NULL, GP_LEVEL_WARN};

static const struct tally_row {
    const char *bad;   // frames that failed, as --frames takes them
    size_t size;       // of the text
    const char *text;
    bool whole;
} tally_rows[] = {
    {"5", 400, "5", true},
    {"5,6", 400, "5-6", true},
    {"5,7", 400, "5,7", true},
    {"5,7,9", 400, "5-9x2", true},
    {"1,2,3,7,9,12", 400, "1-3,7,9,12", true},
    {"1,2,4,6,8", 400, "1-2,4-8x2", true},
    {"9-5,1", 400, "9-5,1", true},
    {"40-10x10", 400, "40-10x10", true},
    {"-3--1", 400, "-3--1", true},
    {"-999999999,999999999,-999999998", 400,
     "-999999999,999999999,-999999998", true},
    {"1,3,4,6,7,9,20,25,31,44,58", 64, "1,3-4,6-7,9,20,25,31,44,58", true},
    {"1,11,31,61,101,151,211,281,361,451,551", 64,
     "1,11,31,61,101,151,211,281,361 and 2 more", false},
};

static struct gp_failures failed_frames(const struct gp_frames *f,
                                     struct gp_jobs *j)
{
    struct gp_failures t = {0};
    // every other job fails
    j->job = calloc(2 * (size_t) f->n, sizeof *j->job);
    j->n = 2 * f->n;
    assert_non_null(j->job);
    for (int i = 0; i < f->n; i++)
        j->job[2 * i] = (struct gp_job) {strdup("in.exr"), true,
                                          f->number[i], NULL};
    for (int i = 0; i < f->n; i++)
        j->job[2 * i + 1] = (struct gp_job) {strdup("x.exr"), false, 0, NULL};
    assert_int_equal(gp_failures_make(NULL, j, &t), GP_OK);
    for (int i = 0; i < f->n; i++) {
        gp_failures_add(&t, 2 * i);
        gp_failures_add(&t, 2 * i);
    }
    assert_int_equal(t.bad, f->n);
    return t;
}

static void failed_lists(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof tally_rows / sizeof tally_rows[0]; i++) {
        const struct tally_row *r = &tally_rows[i];
        struct gp_frames f, back;
        struct gp_jobs j = {0};
        char text[400];
        assert_int_equal(gp_frames_parse(NULL, r->bad, &f), GP_OK);
        struct gp_failures t = failed_frames(&f, &j);
        bool whole = gp_failures_list(&t, text, r->size);
        if (whole != r->whole || strcmp(text, r->text) != 0)
            fail_msg("%s: %s", r->bad, text);
        if (whole) { // --frames reads the same frames from it
            assert_int_equal(gp_frames_parse(NULL, text, &back), GP_OK);
            assert_int_equal(back.n, f.n);
            assert_memory_equal(back.number, f.number,
                                (size_t) f.n * sizeof *f.number);
            gp_frames_free(&back);
        }
        gp_failures_free(&t);
        gp_failures_free(&t);
        gp_jobs_free(&j);
        gp_frames_free(&f);
    }
}

static void tally_ends(void **state)
{
    (void) state;
    struct gp_job job[] = {{(char *) "a.exr", false, 0, NULL},
                           {(char *) "b.0007.exr", true, 7, NULL},
                           {(char *) "c.exr", false, 0, NULL}};
    const struct gp_jobs j = {.job = job, .n = 3};
    struct gp_failures t;
    assert_int_equal(gp_failures_make(NULL, &j, &t), GP_OK);
    said[0] = '\0';
    assert_int_equal(gp_failures_report(&keeper, &t), GP_OK);
    assert_string_equal(said, "");
    t.kept = 1;
    assert_int_equal(gp_failures_report(&keeper, &t), GP_OK);
    assert_non_null(strstr(said, "left 1 of 3 frames alone"));
    gp_failures_add(&t, 1);
    assert_int_equal(gp_failures_report(&keeper, &t), GP_ERR_FRAMES);
    assert_non_null(strstr(said, "1 of 3 frames failed (7);"));
    assert_non_null(strstr(said, " --frames 7"));
    gp_failures_add(&t, 0); // one without a number: names
    assert_int_equal(gp_failures_report(&keeper, &t), GP_ERR_FRAMES);
    assert_non_null(strstr(said, "failed (a.exr, b.0007.exr);"));
    assert_null(strstr(said, " --frames "));
    gp_failures_free(&t);
}

/* Which jobs fail, of frames 1 to 5 or of nameless ones, each of two views. */
static const struct tally_views_row {
    int views;          // jobs of one input: 1 or 2
    bool numbered;
    const char *bad;    // a sign for each job, x where it fails
    const char *text;   // of the error
} tally_views_rows[] = {
    {1, true, "x.........", " 1 of 5 frames failed (1);"},
    {1, true, ".x........", " 1 of 5 frames failed (1);"},
    {1, true, "xx........", " 1 of 5 frames failed (1);"},
    {1, true, "x..x.x.xx.", " 5 of 5 frames failed (1-5);"},
    {2, true, ".x......xx", " 2 of 5 frames failed (1,5);"},
    {2, true, ".xxx......", " 2 of 5 frames failed (1-2);"},
    {1, false, ".xx.......", " 2 of 5 frames failed (1.r, 2.l);"},
    {1, false, "xx........", " 1 of 5 frames failed (1.l, 1.r);"},
    {2, false, ".xx.......", " 2 of 5 frames failed (1.l, 2.l);"},
};

static void failed_views(void **state)
{
    (void) state;
    static const char *const views[] = {"l", "r"};
    for (size_t i = 0; i < sizeof tally_views_rows / sizeof *tally_views_rows;
         i++) {
        const struct tally_views_row *r = &tally_views_rows[i];
        struct gp_job job[10];
        char name[10][24];
        struct gp_failures t;
        for (int k = 0; k < 10; k++) {
            snprintf(name[k], sizeof name[k], "%d.%s", k / 2 + 1,
                     views[k % 2]);
            job[k] = (struct gp_job) {name[k], r->numbered, k / 2 + 1,
                                      views[k % 2]};
        }
        const struct gp_jobs j = {
            .job = job, .n = 10, .views = r->views,
            .view = {.name = (const char **) views, .n = 2},
        };
        assert_int_equal(gp_failures_make(NULL, &j, &t), GP_OK);
        for (int k = 0; k < 10; k++) {
            if (r->bad[k] == 'x')
                gp_failures_add(&t, k);
        }
        assert_int_equal(gp_failures_report(&keeper, &t), GP_ERR_FRAMES);
        if (!strstr(said, r->text))
            fail_msg("%s: %s", r->bad, said);
        gp_failures_free(&t);
    }
}

SUITE(tally)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(failed_lists),
        cmocka_unit_test(tally_ends),
        cmocka_unit_test(failed_views),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
