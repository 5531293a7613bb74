/* app/jobs: which inputs and outputs go together, which frames are left to
 * make. */
#include "unit.h"
#include "jobs_folder.h"

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
    {"--hdr x.%d.exr -f 1,10000 --skip-bad-frames ./x.####.exr",
     GP_ERR_USAGE, "x.10000.exr: --hdr would replace a file that is read (input ./x.1"},
    {"-o s.0010.#.png --hdr s.%04d.exr x.10000.exr", GP_OK,
     "x.10000.exr#>s.10000.exr,s.0010.10000.png"},
    {"--hdr t.%04d.exr --layer t.%d.exr -f 1,1000 --skip-bad-frames s.#.exr",
     GP_ERR_USAGE, "t.1000.exr: given for two outputs (--hdr t.%04d.exr for s.1000."},
};

static void inputs_and_outputs(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        check_row(&rows[i], false, false);
}

// -- what is made already ------------------------------------------------------

static const struct made_row made_rows[] = {
    {"--no-clobber -o m.#.png s.0001.exr", true},
    {"--no-clobber -o m.#.png --layer m.#.exr s.0001.exr", true},
    {"-o m.#.png s.0001.exr", false},
    {"--no-clobber -o m.#.png s.0002.exr", false},
    {"--no-clobber -o m.#.png --layer l.#.exr s.0001.exr", false},
    {"--no-clobber --layer l.#.exr -o m.#.png s.0001.exr", false},
    {"--no-clobber --report m.1.png s.0001.exr", false},
    {"--no-clobber --hdr - s.0001.exr", false},
    {"--no-clobber --hdr /dev/null s.0001.exr", false},
    {0},
};

SUITE(jobs)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inputs_and_outputs),
        cmocka_unit_test_prestate(what_is_made, (void *) made_rows),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
