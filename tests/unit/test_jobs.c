/* app/jobs, app/tally: which inputs and outputs go together, which frames are
 * left to make, which failed. */
#include "app/jobs.h"
#include "app/options.h"
#include "app/tally.h"

#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

enum { WORDS = 20 };

static char said[4096];

static void keep_line(void *user, enum gp_level level, const char *line)
{
    (void) user;
    (void) level;
    snprintf(said, sizeof said, "%s", line);
}

static const struct gp_log keeper = {keep_line, NULL, GP_LEVEL_WARN};

struct job_row {
    const char *line;
    gp_status status;
    const char *text;  // of the error, or "input>outputs" of each frame
};

static const struct job_row rows[] = {
    {"-o o.png in.exr", GP_OK, "in.exr>o.png"},
    {"-o o.png --layer l.exr --hdr h.exr in.exr", GP_OK,
     "in.exr>h.exr,l.exr,o.png"},
    {"--report r.json in.exr", GP_OK, "in.exr>"},
    {"-o o.##.png s.####.exr", GP_OK,
     "s.0001.exr#>o.01.png s.0002.exr#>o.02.png s.0010.exr#>o.10.png"},
    {"-f 2-1 -o o.%d.png s.####.exr", GP_OK,
     "s.0002.exr#>o.2.png s.0001.exr#>o.1.png"},
    {"-f 77 --skip-bad-frames -o o.@.png s.####.exr", GP_OK,
     "s.0077.exr#>o.77.png"},
    {"-f 10-8x2 --no-clobber -o m.@.png s.####.exr", GP_OK,
     "s.0010.exr#>m.10.png s.0008.exr#>m.8.png"},
    {"--report r.json s.####.exr", GP_OK,
     "s.0001.exr#> s.0002.exr#> s.0010.exr#>"},
    {"-o o.#.png s.0002.exr s.0001.exr", GP_OK,
     "s.0002.exr#>o.2.png s.0001.exr#>o.1.png"},
    {"-o o.#.png s.0002.exr", GP_OK, "s.0002.exr#>o.2.png"},
    {"-o o.#.png s.####.exr x.0077.exr", GP_OK,
     "s.0001.exr#>o.1.png s.0002.exr#>o.2.png s.0010.exr#>o.10.png "
     "x.0077.exr#>o.77.png"},
    {"--report r.json in.exr s.0001.exr", GP_OK, "in.exr> s.0001.exr>"},
    {"-f 1-2 -o - s.####.exr", GP_OK, "s.0001.exr#>- s.0002.exr#>-"},
    {"-o - in.exr s.0001.exr", GP_OK, "in.exr>- s.0001.exr>-"},
    {"-o - --layer l.@.exr s.####.exr", GP_OK, "s.0001.exr#>l.1.exr,- "
     "s.0002.exr#>l.2.exr,- s.0010.exr#>l.10.exr,-"},
    {"-o o.png s.0002.exr", GP_OK, "s.0002.exr>o.png"},
    {"-o o.png real@2x.exr", GP_OK, "real@2x.exr>o.png"},

    {"-o o.png s.####.exr", GP_ERR_USAGE, "one name for a sequence (found 3 f"},
    {"-f 1 -o o.png s.####.exr", GP_ERR_USAGE, "o.png: one name for a seq"},
    {"-o o.#.png --hdr h.exr s.####.exr", GP_ERR_USAGE, "h.exr: one name"},
    {"-o o.#.png --debug sensors=d.exr s.####.exr", GP_ERR_USAGE, "d.exr: on"},
    {"-o o.png s.0001.exr s.0002.exr", GP_ERR_USAGE, "o.png: one name for"},
    {"-o o.#.png in.exr", GP_ERR_USAGE, "in.exr: no frame number in this"},
    {"-o o.#.png s.0001.exr in.exr", GP_ERR_USAGE, "in.exr: no frame number"},
    {"-o o.#.png s.0001.exr x.0001.exr", GP_ERR_USAGE, "frame 1 comes twice"},
    {"-o o.#.png s.####.exr s.0002.exr", GP_ERR_USAGE, "frame 2 comes twice"},
    {"-o o.#.#.png s.####.exr", GP_ERR_USAGE, "two places"},
    {"-f 1-2 -o o.png in.exr", GP_ERR_USAGE, "--frames needs a pattern"},
    {"-f 1- -o o.#.png s.####.exr", GP_ERR_USAGE, "not a list of frames"},
    {"-f 77 -o o.@.png s.####.exr", GP_ERR_IO,
     "s.0077.exr: no such frame (the first of 1 missing, of 1 in --frames 77);"
     " render it,"},
    {"-f 1-10 -o o.@.png s.####.exr", GP_ERR_IO,
     "s.0003.exr: no such frame (the first of 7 missing, of 10 in"},
    {"-f 10-8x2 -o m.@.png s.####.exr", GP_ERR_IO, "s.0008.exr: no such frame"},
    {"-f 10-8x2 --no-clobber --layer m.@.exr -o m.@.png s.####.exr", GP_ERR_IO,
     "s.0008.exr: no such frame"},
    {"-f 1-3 -o o.png s.####.exr", GP_ERR_USAGE, "o.png: one name for a seq"},
    {"-o o.#.png none.####.exr", GP_ERR_IO, "none.####.exr: no frame on disk"},
    {"-o o.png - in.exr", GP_ERR_USAGE, "stdin goes with no other"},
    {"-o o.png -k - -", GP_ERR_USAGE, "cannot both come from stdin"},
    {"-o o.png -o o.png in.exr", GP_ERR_USAGE, "o.png: given for two"},
    {"-o - --layer l.exr s.####.exr", GP_ERR_USAGE, "l.exr: one name"},
    {"-f 1- -o - -", GP_ERR_USAGE, "not a list of frames"},
    {"-o no/o.png -", GP_ERR_IO, "no/o.png"},
    {"-o o.png -", GP_ERR_DATA, "-: is empty"},
    {"--hdr - --raw rgb24 in.exr", GP_ERR_USAGE, "--hdr keeps all channels"},
    {"-o - --raw rgb24 --stdout-format exr in.exr", GP_ERR_USAGE,
     "--raw: --stdout-format says otherwise"},
    {"-o - --hdr - in.exr", GP_ERR_USAGE, "only one can go to stdout"},
    {"-o - --report - in.exr", GP_ERR_USAGE, "only one can go to stdout"},
    {"-o no/o.png in.exr", GP_ERR_IO, "no/o.png"},
    {"-o o in.exr", GP_ERR_USAGE, "o: unknown format"},
};

static gp_status make(const char *line, struct gp_settings *s,
                      struct gp_jobs *j)
{
    static char copy[512];
    char *argv[WORDS] = {"glarepp"};
    int argc = 1;
    snprintf(copy, sizeof copy, "%s", line);
    for (char *w = strtok(copy, " "); w && argc < WORDS - 1;
         w = strtok(NULL, " "))
        argv[argc++] = w;
    said[0] = '\0';
    gp_status st = gp_options_parse(&keeper, argc, argv, s);
    return st ? st : gp_jobs_make(&keeper, s, j);
}

/* "input>output,output input>...", the input with # where numbered */
static void describe(const struct gp_jobs *j, char *text, size_t size)
{
    size_t at = 0;
    for (int i = 0; i < j->n; i++) {
        at += (size_t) snprintf(text + at, size - at, "%s%s%s>", i ? " " : "",
                                j->job[i].input,
                                j->job[i].numbered ? "#" : "");
        for (int k = 0; k < j->targets; k++) {
            char *name = gp_job_name(&j->job[i], &j->target[k]);
            at += (size_t) snprintf(text + at, size - at, "%s%s",
                                    k ? "," : "", name);
            free(name);
        }
    }
}

static void inputs_and_outputs(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
        const struct job_row *r = &rows[i];
        struct gp_settings s;
        struct gp_jobs j = {0};
        char text[1024] = "";
        gp_status st = make(r->line, &s, &j);
        describe(&j, text, sizeof text);
        bool same = st ? strstr(said, r->text) != NULL
                       : strcmp(text, r->text) == 0;
        if (st != r->status || !same)
            fail_msg("%s: status %d: %s%s", r->line, st, said, text);
        gp_jobs_free(&j);
        gp_jobs_free(&j);
        gp_settings_free(&s);
    }
}

// -- what is made already ------------------------------------------------------

static const struct made_row {
    const char *line;
    bool made;  // of the first frame
} made_rows[] = {
    {"--no-clobber -o m.#.png s.0001.exr", true},
    {"--no-clobber -o m.#.png --layer m.#.exr s.0001.exr", true},
    {"-o m.#.png s.0001.exr", false},
    {"--no-clobber -o m.#.png s.0002.exr", false},
    {"--no-clobber -o m.#.png --layer l.#.exr s.0001.exr", false},
    {"--no-clobber --layer l.#.exr -o m.#.png s.0001.exr", false},
    {"--no-clobber --report m.1.png s.0001.exr", false},
    {"--no-clobber --hdr - s.0001.exr", false},
    {"--no-clobber --hdr /dev/null s.0001.exr", false},
};

static void what_is_made(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof made_rows / sizeof made_rows[0]; i++) {
        struct gp_settings s;
        struct gp_jobs j = {0};
        if (make(made_rows[i].line, &s, &j) != GP_OK)
            fail_msg("%s: %s", made_rows[i].line, said);
        if (gp_job_made(&s.write, &j, &j.job[0]) != made_rows[i].made)
            fail_msg("%s", made_rows[i].line);
        gp_jobs_free(&j);
        gp_settings_free(&s);
    }
}

// -- the tally -----------------------------------------------------------------

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

static struct gp_tally failed_frames(const struct gp_frames *f,
                                     struct gp_jobs *j)
{
    struct gp_tally t = {0};
    // every other job fails
    j->job = calloc(2 * (size_t) f->n, sizeof *j->job);
    j->n = 2 * f->n;
    assert_non_null(j->job);
    for (int i = 0; i < f->n; i++)
        j->job[2 * i] = (struct gp_job) {strdup("in.exr"), true, f->number[i]};
    for (int i = 0; i < f->n; i++)
        j->job[2 * i + 1] = (struct gp_job) {strdup("x.exr"), false, 0};
    assert_int_equal(gp_tally_make(NULL, j, &t), GP_OK);
    for (int i = 0; i < f->n; i++) {
        gp_tally_fail(&t, 2 * i);
        gp_tally_fail(&t, 2 * i);
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
        struct gp_tally t = failed_frames(&f, &j);
        bool whole = gp_tally_list(&t, text, r->size);
        if (whole != r->whole || strcmp(text, r->text) != 0)
            fail_msg("%s: %s", r->bad, text);
        if (whole) { // --frames reads the same frames from it
            assert_int_equal(gp_frames_parse(NULL, text, &back), GP_OK);
            assert_int_equal(back.n, f.n);
            assert_memory_equal(back.number, f.number,
                                (size_t) f.n * sizeof *f.number);
            gp_frames_free(&back);
        }
        gp_tally_free(&t);
        gp_tally_free(&t);
        gp_jobs_free(&j);
        gp_frames_free(&f);
    }
}

static void tally_ends(void **state)
{
    (void) state;
    struct gp_job job[] = {{(char *) "a.exr", false, 0},
                           {(char *) "b.0007.exr", true, 7},
                           {(char *) "c.exr", false, 0}};
    const struct gp_jobs j = {.job = job, .n = 3};
    struct gp_tally t;
    assert_int_equal(gp_tally_make(NULL, &j, &t), GP_OK);
    said[0] = '\0';
    assert_int_equal(gp_tally_end(&keeper, &t), GP_OK);
    assert_string_equal(said, "");
    t.kept = 1;
    assert_int_equal(gp_tally_end(&keeper, &t), GP_OK);
    assert_non_null(strstr(said, "left 1 of 3 frames alone"));
    gp_tally_fail(&t, 1);
    assert_int_equal(gp_tally_end(&keeper, &t), GP_ERR_FRAMES);
    assert_non_null(strstr(said, "1 of 3 frames failed (7);"));
    assert_non_null(strstr(said, " --frames 7"));
    gp_tally_fail(&t, 0); // one without a number: names
    assert_int_equal(gp_tally_end(&keeper, &t), GP_ERR_FRAMES);
    assert_non_null(strstr(said, "failed (a.exr, b.0007.exr);"));
    assert_null(strstr(said, " --frames "));
    gp_tally_free(&t);
}

// -- a folder with frames ----------------------------------------------------

static const char *const files[] = {
    "s.0001.exr", "s.0002.exr", "s.0010.exr", "s.7.exr", "real@2x.exr",
    "m.8.png", "m.1.png", "m.1.exr",
};
static char folder[] = "/tmp/gp_jobs_XXXXXX";

static int make_folder(void **state)
{
    (void) state;
    if (!mkdtemp(folder) || chdir(folder) != 0)
        return -1;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        close(creat(files[i], 0600));
    // "-" must not be a terminal here
    return freopen("/dev/null", "r", stdin) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        unlink(files[i]);
    return chdir("/") || rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inputs_and_outputs),
        cmocka_unit_test(what_is_made),
        cmocka_unit_test(failed_lists),
        cmocka_unit_test(tally_ends),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
