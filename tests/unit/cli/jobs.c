// SPDX-License-Identifier: Apache-2.0
/* cli/jobs: which inputs and outputs go together, which frames are left to
 * make; views as files, or as parts of one file. */
#include "unit.h"
#include "cli/jobs.h"
#include "cli/option_line.h"
#include "exr_fixture.h"
#include "folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

struct job_row {
    const char *line;
    gp_status status;
    const char *text;  // the error's start, or "input>outputs" of each frame
};

static gp_status make_jobs(
    const char *line, struct gp_settings *s, struct gp_jobs *j)
{
    const gp_status st = parse(line, s);
    return st ? st : gp_jobs_make(&kept_all, s, j);
}

/* "input>output,output input>...", the input with # where numbered and its
 * view behind that or :, an output of several views with ! */
static void describe(const struct gp_jobs *j, char *text, size_t size)
{
    size_t at = 0;
    for (int i = 0; i < j->n; i++) {
        const struct gp_job *const job = &j->job[i];
        const char *const view = job->view ? job->view : "";
        at += (size_t) snprintf(text + at, size - at, "%s%s%s%s>", i ? " " : "",
            job->input, job->numbered ? "#" : *view ? ":" : "", view);
        for (int k = 0; k < j->targets; k++) {
            char *name = gp_job_name(&j->job[i], &j->target[k]);
            at += (size_t) snprintf(text + at, size - at, "%s%s%s",
                k ? "," : "", name, j->target[k].whole ? "!" : "");
            free(name);
        }
    }
}

static void check_row(const struct job_row *r, bool views, bool parts)
{
    struct gp_settings s;
    struct gp_jobs j = {0};
    char text[1024] = "";
    gp_status st = make_jobs(r->line, &s, &j);
    describe(&j, text, sizeof text);
    bool same = st ? strncmp(kept_line, r->text, strlen(r->text)) == 0
                   : strcmp(text, r->text) == 0;
    if (st != r->status || !same)
        fail_msg("%s: status %d: %s%s", r->line, st, kept_line, text);
    if (!st && j.views != (parts ? gp_jobs_of_frame(&j) : 1))
        fail_msg("%s: %d jobs of one input", r->line, j.views);
    if (!st && !views && (j.view.n || gp_jobs_of_frame(&j) != 1))
        fail_msg("%s: %d views", r->line, j.view.n);
    gp_jobs_free(&j);
    gp_jobs_free(&j);
    gp_settings_free(&s);
}

static const char *const files[] = {
    "s.0001.exr", "s.0002.exr", "s.0010.exr", "s.7.exr", "real@2x.exr",
    "m.8.png", "m.1.png", "m.1.exr", "v.left.0001.exr", "v.right.0001.exr",
    "v.left.0002.exr", "v.right.0002.exr", "q.left.0001.exr",
    "q.right.0001.exr", "q.left.0002.exr", "w.l.exr", "w.r.exr", "lit.%V.exr",
    "m.left.1.png", "m.right.1.png", "m.left.2.png", "m.left.3.png",
    "m.left.4.png", "m.right.4.png", "x.10000.exr", "d.left/l.1.exr",
    "d.right/r.1.exr",
};

static int make_files(void **state)
{
    if (make_folder(state) || chdir(folder) != 0 || mkdir("d.left", 0700) ||
        mkdir("d.right", 0700))
        return -1;
    static const struct fixture pixel = {
        .part = {{.channel = {HALF_CH("Y")}, .data = W(1)}},
    };
    for (size_t i = 0; i < COUNT(files);
         i++) // outputs that are there are whole
        fixture_write_file(files[i], &pixel);
    // "-" must not be a terminal here
    return freopen("/dev/null", "r", stdin) ? 0 : -1;
}

// -- frames ------------------------------------------------------------------

static const struct job_row rows[] = {
    {"-o o.png in.exr", GP_OK, "in.exr>o.png"},
    {"-o o.png --layer l.exr --hdr h.exr in.exr", GP_OK,
     "in.exr>h.exr,l.exr,o.png"},
    {"--layer l.exr --hdr h.exr --layer m.exr --hdr g.exr in.exr", GP_OK,
     "in.exr>h.exr,g.exr,l.exr,m.exr"},
    {"--hdr h.exr --hdr ./h.exr in.exr", GP_ERR_USAGE, "h.exr:"},
    {"--layer l.exr --layer in.exr s.0001.exr --hdr s.0001.exr", GP_ERR_USAGE,
     "s.0001.exr:"},
    {"--hdr - --hdr - in.exr", GP_ERR_USAGE, "-:"},
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
    {"-o o.#.png s.####.exr x.0077.exr", GP_OK, "s.0001.exr#>o.1.png "
     "s.0002.exr#>o.2.png s.0010.exr#>o.10.png x.0077.exr#>o.77.png"},
    {"-f 1-2 -o - s.####.exr", GP_OK, "s.0001.exr#>- s.0002.exr#>-"},
    {"-o - --layer l.@.exr s.####.exr", GP_OK,
     "s.0001.exr#>l.1.exr,- s.0002.exr#>l.2.exr,- s.0010.exr#>l.10.exr,-"},
    {"-o o.png s.0002.exr", GP_OK, "s.0002.exr>o.png"},
    {"-f 1 -o o.png s.####.exr", GP_ERR_USAGE, "o.png:"},
    {"-o o.#.png --hdr h.exr s.####.exr", GP_ERR_USAGE, "h.exr:"},
    {"-o o.png s.0001.exr s.0002.exr", GP_ERR_USAGE, "o.png:"},
    {"-o o.#.png s.0001.exr in.exr", GP_ERR_USAGE, "in.exr:"},
    {"-o o.#.png s.####.exr s.0002.exr", GP_ERR_USAGE, "o.2.png:"},
    {"-f 10-8x2 --no-clobber --layer m.@.exr -o m.@.png s.####.exr", GP_ERR_IO,
     "s.0008.exr:"},
    {"-o o.png -k - -", GP_ERR_USAGE, "-:"},
    {"-o - --layer l.exr s.####.exr", GP_ERR_USAGE, "l.exr:"},
    {"-f 1- -o - -", GP_ERR_USAGE, "--frames:"},
    {"-o o.png -", GP_ERR_DATA, "-:"},
    {"--hdr - --raw rgb24 in.exr", GP_ERR_USAGE, "-:"},
    {"-o s.0010.#.png --hdr s.%04d.exr x.10000.exr", GP_OK,
     "x.10000.exr#>s.10000.exr,s.0010.10000.png"},
};

// -- views -------------------------------------------------------------------

/* A file for each view. */
static const struct job_row view_rows[] = {
    {"-o o.%V.#.png v.%V.####.exr", GP_OK,
     "v.left.0001.exr#left>o.left.1.png v.right.0001.exr#right>o.right.1.png "
     "v.left.0002.exr#left>o.left.2.png v.right.0002.exr#right>o.right.2.png"},
    {"-o o.%v.png w.%v.exr", GP_OK,
     "w.l.exr:left>o.l.png w.r.exr:right>o.r.png"},
    {"--views right,left -o o.%V.png w.%v.exr", GP_OK,
     "w.r.exr:right>o.right.png w.l.exr:left>o.left.png"},
    {"--views left -f 2 -o o.#.png q.%V.####.exr", GP_OK,
     "q.left.0002.exr#left>o.2.png"},
    {"-o - v.%V.0001.exr", GP_OK,
     "v.left.0001.exr:left>- v.right.0001.exr:right>-"},
    {"-o - --layer %V%v.exr v.%V.0001.exr", GP_OK,
     "v.left.0001.exr:left>leftl.exr,- v.right.0001.exr:right>rightr.exr,-"},
    {"-o o.%V.#.png v.%V.0002.exr", GP_OK,
     "v.left.0002.exr#left>o.left.2.png v.right.0002.exr#right>o.right.2.png"},
    {"-f 1 -o d.%V/o.#.png d.%V/%v.#.exr", GP_OK,
     "d.left/l.1.exr#left>d.left/o.1.png "
     "d.right/r.1.exr#right>d.right/o.1.png"},
    {"--skip-bad-frames -o o.%V.#.png q.%V.####.exr", GP_OK,
     "q.left.0001.exr#left>o.left.1.png q.right.0001.exr#right>o.right.1.png "
     "q.left.0002.exr#left>o.left.2.png q.right.0002.exr#right>o.right.2.png"},
    {"-o o.png lit.%V.exr", GP_OK, "lit.%V.exr>o.png"},
    {"-f 4,1 --no-clobber -o m.%V.#.png v.%V.####.exr", GP_OK,
     "v.left.0004.exr#left>m.left.4.png v.right.0004.exr#right>m.right.4.png "
     "v.left.0001.exr#left>m.left.1.png v.right.0001.exr#right>m.right.1.png"},
    {"--no-clobber -f 2-3 -o m.%V.#.png v.%V.####.exr", GP_ERR_IO,
     "v.right.0003.exr:"},
    {"-o o.%V.png v.%V.####.exr", GP_ERR_USAGE, "o.%V.png:"},
    {"--hdr o.#.exr v.%V.####.exr", GP_ERR_USAGE, "o.#.exr:"},
    {"-o o.%V.png --debug sensors=d.exr w.%v.exr", GP_ERR_USAGE, "d.exr:"},
    {"--hdr o.%v.#.exr -f 1-2 s.####.exr", GP_ERR_USAGE, "o.%v.#.exr:"},
    {"-o o.%V.#.png v.%V.####.exr v.%V.0002.exr", GP_ERR_USAGE,
     "o.left.2.png:"},
    {"-o o.%V.png w.%v.exr v.%V.0001.exr", GP_ERR_USAGE, "o.%V.png:"},
    {"--views a,a1 -f 1,11 --skip-bad-frames -o o.%V.#.png v.%V.####.exr",
     GP_OK, "v.a.0001.exr#a>o.a.1.png v.a1.0001.exr#a1>o.a1.1.png "
     "v.a.0011.exr#a>o.a.11.png v.a1.0011.exr#a1>o.a1.11.png"},
    {"--hdr v.%V.####.exr v.%V.####.exr", GP_ERR_USAGE, "v.left.0001.exr:"},
    {"--views right,left --hdr w.%v.exr v.%V.0001.exr", GP_OK,
     "v.right.0001.exr:right>w.r.exr v.left.0001.exr:left>w.l.exr"},
    {"-f 2-3 --skip-bad-frames --hdr v.%V.%04d.exr ./v.%V.####.exr",
     GP_ERR_USAGE, "v.left.0002.exr:"},
    {"--views - --stdout-format png -o %V w.%v.exr", GP_ERR_USAGE, "%V:"},
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
    {"--views left,right -o o.png in.exr", GP_ERR_USAGE, "o.png:"},
    {"--views left,right --hdr h.exr --layer l.exr in.exr", GP_ERR_USAGE,
     "l.exr:"},
    {"--views left,right --hdr h.exr s.####.exr", GP_ERR_USAGE, "h.exr:"},
    {"--views left,right --hdr in.exr -o o.%V.png real@2x.exr real@2x.exr",
     GP_ERR_USAGE, "in.exr:"},
    {"--views left,right --hdr w.l.exr -o o.%V.png ./w.l.exr", GP_ERR_USAGE,
     "w.l.exr:"},
    {"--views left,right -o o.%V.#.png s.0001.exr x.0001.exr", GP_ERR_USAGE,
     "o.left.1.png:"},
    {"--views left,right -o o.%V.png -", GP_ERR_DATA, "-:"},
    {"--views left,right -o o.png -", GP_ERR_USAGE, "o.png:"},
};

/* Three pictures of one pixel come in by stdin. */
static const struct job_row stdin_rows[] = {
    {"--views left,right --hdr h.#.exr -o o.%v.#.png -", GP_OK,
     "- (frame 1)#left>h.1.exr!,o.l.1.png - (frame "
     "1)#right>h.1.exr!,o.r.1.png - (frame 2)#left>h.2.exr!,o.l.2.png - "
     "(frame 2)#right>h.2.exr!,o.r.2.png - (frame 3)#left>h.3.exr!,o.l.3.png "
     "- (frame 3)#right>h.3.exr!,o.r.3.png"},
    {"--views a,b -f 9,7,8 -o - -", GP_OK, "- (frame 9)#a>- - (frame 9)#b>- - "
     "(frame 7)#a>- - (frame 7)#b>- - (frame 8)#a>- - (frame 8)#b>-"},
    {"--views a,b -f 1-4 -o o.%V.#.png -", GP_ERR_USAGE, "-:"},
    {"--views a,b -o o.%V.png -", GP_ERR_USAGE, "o.%V.png:"},
    {"--views b,b1 -f 1,11,111 -o o.%V#.png -", GP_ERR_USAGE, "o.b11.png:"},
};

static void frames_and_views(void **state)
{
    for (size_t i = 0; i < COUNT(rows); i++)
        check_row(&rows[i], false, false);
    for (size_t i = 0; i < COUNT(view_rows); i++)
        check_row(&view_rows[i], true, false);
    for (size_t i = 0; i < COUNT(part_rows); i++)
        check_row(&part_rows[i], true, true);
}

static void views_in_stdin(void **state)
{
    for (size_t i = 0; i < COUNT(stdin_rows); i++) {
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
    struct gp_settings s;
    struct gp_jobs j = {0};
    assert_int_equal(make_jobs("--views a,b -f 1-500001 --skip-bad-frames -o - "
                          "v.%V.#.exr", &s, &j), GP_ERR_USAGE);
    assert_int_equal(strncmp(kept_line, "v.%V.#.exr:", 11), 0);
    gp_settings_free(&s);
}

// `made`: of the first frame
static const struct { const char *line; bool made; } made_rows[] = {
    {"--no-clobber -o m.#.png s.0001.exr", true},
    {"--no-clobber -o m.#.png --layer m.#.exr s.0001.exr", true},
    {"-o m.#.png s.0001.exr", false},
    {"--no-clobber -o m.#.png s.0002.exr", false},
    {"--no-clobber -o m.#.png --layer l.#.exr s.0001.exr", false},
    {"--no-clobber --layer l.#.exr -o m.#.png s.0001.exr", false},
    {"--no-clobber --report m.1.png s.0001.exr", false},
    {"--no-clobber --hdr - s.0001.exr", false},
    {"--no-clobber --hdr /dev/null s.0001.exr", false},
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
};

static void what_is_made(void **state)
{
    for (size_t i = 0; i < COUNT(made_rows); i++) {
        struct gp_settings s;
        struct gp_jobs j = {0};
        if (make_jobs(made_rows[i].line, &s, &j) ||
            gp_job_complete(NULL, &s.output.write, &j, &j.job[0]) !=
                made_rows[i].made)
            fail_msg("%s: %s", made_rows[i].line, kept_line);
        gp_jobs_free(&j);
        gp_settings_free(&s);
    }
}

SUITE_OF(jobs, make_files, remove_folder, frames_and_views, views_in_stdin,
         too_many_jobs, what_is_made)
