/* app/jobs with views: files for each, or parts of one file. */
#include "unit.h"
#include "jobs_folder.h"

/* A file for each view. */
static const struct job_row view_rows[] = {
    {"-o o.%V.#.png v.%V.####.exr", GP_OK,
     "v.left.0001.exr#left>o.left.1.png v.right.0001.exr#right>o.right.1.png "
     "v.left.0002.exr#left>o.left.2.png v.right.0002.exr#right>o.right.2.png"},
    {"-o o.%v.png w.%v.exr", GP_OK,
     "w.l.exr:left>o.l.png w.r.exr:right>o.r.png"},
    {"--views right,left -o o.%V.png w.%v.exr", GP_OK,
     "w.r.exr:right>o.right.png w.l.exr:left>o.left.png"},
    {"--views left -o o.png w.%v.exr", GP_OK, "w.l.exr:left>o.png"},
    {"--views left -f 2 -o o.#.png q.%V.####.exr", GP_OK,
     "q.left.0002.exr#left>o.2.png"},
    {"-o - v.%V.0001.exr", GP_OK, "v.left.0001.exr:left>- "
     "v.right.0001.exr:right>-"},
    {"-o - --layer %V%v.exr v.%V.0001.exr", GP_OK, "v.left.0001.exr:left>"
     "leftl.exr,- v.right.0001.exr:right>rightr.exr,-"},
    {"-o o.%V.#.png v.%V.0002.exr", GP_OK, "v.left.0002.exr#left>o.left.2.png "
     "v.right.0002.exr#right>o.right.2.png"},
    {"-f 1 -o d.%V/o.#.png d.%V/%v.#.exr", GP_OK, "d.left/l.1.exr#left>"
     "d.left/o.1.png d.right/r.1.exr#right>d.right/o.1.png"},
    {"--report r.json w.%v.exr", GP_OK, "w.l.exr:left> w.r.exr:right>"},
    {"--skip-bad-frames -o o.%V.#.png q.%V.####.exr", GP_OK,
     "q.left.0001.exr#left>o.left.1.png q.right.0001.exr#right>o.right.1.png "
     "q.left.0002.exr#left>o.left.2.png q.right.0002.exr#right>o.right.2.png"},
    {"-o o.png lit.%V.exr", GP_OK, "lit.%V.exr>o.png"},
    {"-f 4,1 --no-clobber -o m.%V.#.png v.%V.####.exr", GP_OK,
     "v.left.0004.exr#left>m.left.4.png v.right.0004.exr#right>m.right.4.png "
     "v.left.0001.exr#left>m.left.1.png v.right.0001.exr#right>m.right.1.png"},

    {"-o o.%V.#.png q.%V.####.exr", GP_ERR_IO, "q.right.0002.exr: no such "
     "frame (the first of 1 missing, of 4 in --views left,right)"},
    {"--views left,mono,right -o o.%V.#.png q.%V.####.exr", GP_ERR_IO,
     "q.mono.0001.exr: no such frame (the first of 3 missing, of 6 in --views "
     "left,mono,right)"},
    {"-f 1-2 -o o.%V.#.png q.%V.####.exr", GP_ERR_IO, "q.right.0002.exr: no "
     "such frame (the first of 1 missing, of 4 in --frames 1-2)"},
    {"--no-clobber -f 2-3 -o m.%V.#.png v.%V.####.exr", GP_ERR_IO,
     "v.right.0003.exr: no such"},
    {"-o o.%V.png q.%V.exr", GP_ERR_IO, "q.left.exr: no such frame (the first "
     "of 2"},
    {"-o o.%V.#.png none.%V.####.exr", GP_ERR_IO, "none.left.####.exr: no fra"},
    {"-o o.%V.#.png none/%V.####.exr", GP_ERR_IO, "none/left.####.exr: cannot"},
    {"-o o.#.png v.%V.####.exr", GP_ERR_USAGE, "o.#.png: one name for several"
     " views (found 2); write %V"},
    {"-o o.%V.png v.%V.####.exr", GP_ERR_USAGE, "one name for a sequence "
     "(found 2 frames)"},
    {"--hdr o.#.exr v.%V.####.exr", GP_ERR_USAGE, "o.#.exr: one name for sev"},
    {"-o o.%V.png --debug sensors=d.exr w.%v.exr", GP_ERR_USAGE, "d.exr: one"},
    {"-o o.%V.png in.exr", GP_ERR_USAGE, "o.%V.png: %V and %v are views, and "
     "there are none"},
    {"--hdr o.%v.#.exr -f 1-2 s.####.exr", GP_ERR_USAGE,
     "o.%v.#.exr: %V and %v"},
    {"-o o.%V.png lit.%V.exr", GP_ERR_USAGE,
     "(no %V in lit.%V.exr, no --views"},
    {"--views left,lefty -o o.%V.png w.%v.exr", GP_ERR_USAGE,
     "w.%v.exr: %v is the same letter for two views (found left and lefty)"},
    {"--views left,lefty -o o.%v.png v.%V.0001.exr", GP_ERR_USAGE,
     "o.%v.png: %v is the same"},
    {"--views left, -o o.%V.png w.%v.exr", GP_ERR_USAGE, "an empty name"},
    {"--views a,b,a -o o.%V.png w.%v.exr", GP_ERR_USAGE, "a comes twice"},
    {"--views a/b -o o.%V.png w.%v.exr", GP_ERR_USAGE, "a name with a slash"},
    {"-f 1 -o o.%V.png w.%v.exr", GP_ERR_USAGE, "--frames needs a pattern"},
    {"-o o.%V.#.png v.%V.####.exr s.####.exr", GP_ERR_USAGE,
     "s.####.exr: no %V or %v (found in v.%V.####.exr); make the two"},
    {"-o o.%V.#.png s.####.exr v.%V.####.exr", GP_ERR_USAGE,
     "s.####.exr: no %V or %v (found in v.%V"},
    {"-o o.%V.#.png v.%V.####.exr v.%V.0002.exr", GP_ERR_USAGE,
     "frame 2 comes twice (found it in v.left.0002.exr)"},
    {"-o o.%V.png w.%v.exr v.%V.0001.exr", GP_ERR_USAGE, "one name for a seq"},
    // two names that come out as one
    {"--views l,r -o o.%V.png --debug sensors=o.%v.png w.%v.exr",
     GP_ERR_USAGE, "o.l.png: given for two outputs (--output o.%V.png for w.l.exr, "
     "view l and --debug sensors o.%v.png for w.l.exr, view l); give each"},
    {"--views a,a1 -f 1,11 --skip-bad-frames -o o.%V#.png v.%V.####.exr",
     GP_ERR_USAGE, "o.a11.png: given for two outputs (--output o.%V#.png for "
     "v.a1.0001.exr, view a1 and --output o.%V#.png for v.a.0011.exr, view a)"},
    {"--views a,a1 -f 1,11 --skip-bad-frames -o o.%V.#.png v.%V.####.exr",
     GP_OK, "v.a.0001.exr#a>o.a.1.png v.a1.0001.exr#a1>o.a1.1.png "
     "v.a.0011.exr#a>o.a.11.png v.a1.0011.exr#a1>o.a1.11.png"},
    // over an input, of whichever job
    {"--hdr v.%V.####.exr v.%V.####.exr", GP_ERR_USAGE,
     "v.left.0001.exr: --hdr would replace a file that is read (input v.le"},
    {"--views right,left --hdr w.%v.exr v.%V.0001.exr", GP_OK,
     "v.right.0001.exr:right>w.r.exr v.left.0001.exr:left>w.l.exr"},
    {"-f 2-3 --skip-bad-frames --hdr v.%V.%04d.exr ./v.%V.####.exr",
     GP_ERR_USAGE, "v.left.0002.exr: --hdr would replace a file that is read "
     "(input ./v.left.0002.exr)"},
    {"--views - --stdout-format png -o %V w.%v.exr", GP_ERR_USAGE,
     "%V: is - for a view, which is stdout; write ./%V"},
};

/* The views are in each file. */
static const struct job_row part_rows[] = {
    {"--views left,right -o o.%V.png in.exr", GP_OK,
     "in.exr:left>o.left.png in.exr:right>o.right.png"},
    {"--views left,right --hdr h.exr -o o.%v.png in.exr", GP_OK,
     "in.exr:left>h.exr!,o.l.png in.exr:right>h.exr!,o.r.png"},
    {"--views left,right --hdr h.%V.exr in.exr", GP_OK,
     "in.exr:left>h.left.exr in.exr:right>h.right.exr"},
    {"--views left,right --hdr - in.exr", GP_OK,
     "in.exr:left>-! in.exr:right>-!"},
    {"--views left --hdr h.exr -o o.png in.exr", GP_OK,
     "in.exr:left>h.exr,o.png"},
    {"--views left,right --hdr h.#.exr -f 2,1 s.####.exr", GP_OK,
     "s.0002.exr#left>h.2.exr! s.0002.exr#right>h.2.exr! "
     "s.0001.exr#left>h.1.exr! s.0001.exr#right>h.1.exr!"},
    {"--views a,b,c -o o.%V.#.png s.0010.exr s.0001.exr", GP_OK,
     "s.0010.exr#a>o.a.10.png s.0010.exr#b>o.b.10.png s.0010.exr#c>o.c.10.png "
     "s.0001.exr#a>o.a.1.png s.0001.exr#b>o.b.1.png s.0001.exr#c>o.c.1.png"},
    {"--views left,right --hdr h.exr lit.%V.exr", GP_OK,
     "lit.%V.exr:left>h.exr! lit.%V.exr:right>h.exr!"},
    {"--views left,right --report r.json in.exr", GP_OK,
     "in.exr:left> in.exr:right>"},

    {"--views left,right -o o.png in.exr", GP_ERR_USAGE, "o.png: one name for "
     "several views (found 2)"},
    {"--views left,right --hdr h.exr --layer l.exr in.exr", GP_ERR_USAGE,
     "l.exr: one name for several"},
    {"--views left,right --hdr h.exr s.####.exr", GP_ERR_USAGE,
     "h.exr: one name for a sequence (found 3 frames)"},
    {"--views left,right --hdr h.#.exr -f 1,3,5 s.####.exr", GP_ERR_IO,
     "s.0003.exr: no such frame (the first of 2 missing, of 3 in --frames "},
    {"--views left,right --hdr in.exr -o o.%V.png real@2x.exr real@2x.exr",
     GP_ERR_USAGE, "in.exr: one name for a sequence (found 2"},
    {"--views left,right --hdr w.l.exr -o o.%V.png ./w.l.exr", GP_ERR_USAGE,
     "w.l.exr: --hdr would replace a file that is read (input ./w.l.exr)"},
    {"--views left,right -o o.%V.#.png s.0001.exr x.0001.exr", GP_ERR_USAGE,
     "frame 1 comes twice"},
    {"--views left,right -o o.%V.png -", GP_ERR_DATA, "-: is empty"},
    {"--views left,right -o o.png -", GP_ERR_USAGE, "o.png: one name for sev"},
    {"--views left,right -o no.%V/o.png in.exr", GP_ERR_IO, "no.left/o.png"},
    {"--views left,right -o d.%v/o.png in.exr", GP_ERR_IO, "d.l/o.png"},
};

static void views_in_names(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof view_rows / sizeof view_rows[0]; i++)
        check_row(&view_rows[i], true, false);
}

static void views_in_files(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof part_rows / sizeof part_rows[0]; i++)
        check_row(&part_rows[i], true, true);
}

/* Three pictures of one pixel come in by stdin. */
static const struct job_row stdin_rows[] = {
    {"--views left,right --hdr h.#.exr -o o.%v.#.png -", GP_OK,
     "- (frame 1)#left>h.1.exr!,o.l.1.png - (frame 1)#right>h.1.exr!,o.r.1.png "
     "- (frame 2)#left>h.2.exr!,o.l.2.png - (frame 2)#right>h.2.exr!,o.r.2.png "
     "- (frame 3)#left>h.3.exr!,o.l.3.png "
     "- (frame 3)#right>h.3.exr!,o.r.3.png"},
    {"--views a,b -f 9,7,8 -o - -", GP_OK,
     "- (frame 9)#a>- - (frame 9)#b>- - (frame 7)#a>- - (frame 7)#b>- "
     "- (frame 8)#a>- - (frame 8)#b>-"},
    {"--views a,b -f 1-4 -o o.%V.#.png -", GP_ERR_USAGE,
     "-: stdin has 3 frames, --frames 1-4 lists 4"},
    {"--views a,b -o o.%V.png -", GP_ERR_USAGE,
     "o.%V.png: one name for a sequence (found 3 frames)"},
    {"--views b,b1 -f 1,11,111 -o o.%V#.png -", GP_ERR_USAGE,
     "o.b11.png: given for two outputs"},
};

static void views_in_stdin(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof stdin_rows / sizeof stdin_rows[0]; i++) {
        static const char picture[] = "Pf\n1 1\n-1.0\n\0\0\200?";
        FILE *const f = fopen("three.pfm", "wb");
        assert_non_null(f);
        for (int k = 0; k < 3; k++)
            fwrite(picture, 1, sizeof picture - 1, f);
        assert_int_equal(fclose(f), 0);
        assert_non_null(freopen("three.pfm", "rb", stdin));
        unlink("three.pfm");
        check_row(&stdin_rows[i], true, true);
    }
    assert_non_null(freopen("/dev/null", "r", stdin));
}

/* A million frames of many views are refused before they are listed. */
static void too_many_jobs(void **state)
{
    (void) state;
    struct gp_settings s;
    struct gp_jobs j = {0};
    assert_int_equal(make("--views a,b -f 1-500001 --skip-bad-frames -o - "
                          "v.%V.#.exr", &s, &j), GP_ERR_USAGE);
    assert_non_null(strstr(said, "v.%V.#.exr: too many frames"));
    gp_settings_free(&s);
}

// -- what is made already ----------------------------------------------------

static const struct made_row made_rows[] = {
    {"--no-clobber -o m.%V.#.png v.%V.0001.exr", true},
    {"--no-clobber -o m.%V.#.png v.%V.0002.exr", true},
    {"--no-clobber --views right,left -o m.%V.#.png v.%V.0002.exr", false},
    {"--no-clobber --views right,left -o m.%V.#.png v.%V.0001.exr", true},
    // a file of all views is made from all of them
    {"--no-clobber --views left,right --hdr m.1.exr s.0001.exr", true},
    {"--no-clobber --views left,right --hdr n.#.exr -o m.%V.#.png s.0001.exr",
     false},
    {"--no-clobber --views left,right --hdr m.#.exr -o m.%V.#.png s.0001.exr",
     true},
    {"--no-clobber --views left,right --hdr m.#.exr -o m.%V.#.png s.0002.exr",
     false},
    {"--no-clobber --views left,right --layer m.%V.#.png s.0002.exr", true},
    {0},
};

SUITE(job_views)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(views_in_names),
        cmocka_unit_test(views_in_files),
        cmocka_unit_test(views_in_stdin),
        cmocka_unit_test(too_many_jobs),
        cmocka_unit_test_prestate(what_is_made, (void *) made_rows),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
