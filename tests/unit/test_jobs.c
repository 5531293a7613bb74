/* app/jobs: which inputs and outputs go together. */
#include "app/jobs.h"
#include "app/options.h"

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
    {"-f 77 -o o.@.png s.####.exr", GP_OK, "s.0077.exr#>o.77.png"},
    {"--report r.json s.####.exr", GP_OK,
     "s.0001.exr#> s.0002.exr#> s.0010.exr#>"},
    {"-o o.#.png s.0002.exr s.0001.exr", GP_OK,
     "s.0002.exr#>o.2.png s.0001.exr#>o.1.png"},
    {"-o o.#.png s.0002.exr", GP_OK, "s.0002.exr#>o.2.png"},
    {"-o o.#.png s.####.exr x.0077.exr", GP_OK,
     "s.0001.exr#>o.1.png s.0002.exr#>o.2.png s.0010.exr#>o.10.png "
     "x.0077.exr#>o.77.png"},
    {"--report r.json in.exr s.0001.exr", GP_OK, "in.exr> s.0001.exr>"},
    {"-o o.png s.0002.exr", GP_OK, "s.0002.exr>o.png"},
    {"-o o.png real@2x.exr", GP_OK, "real@2x.exr>o.png"},

    {"-o o.png s.####.exr", GP_ERR_USAGE, "one name for a sequence (found 3 f"},
    {"-f 1 -o o.png s.####.exr", GP_ERR_USAGE, "o.png: one name for a seq"},
    {"-f 1 -o - s.####.exr", GP_ERR_USAGE, "-: one name for a sequence"},
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
    {"-o o.#.png none.####.exr", GP_ERR_IO, "none.####.exr: no frame on disk"},
    {"-o o.png - in.exr", GP_ERR_USAGE, "stdin holds one frame"},
    {"-o o.png -k - -", GP_ERR_USAGE, "cannot both come from stdin"},
    {"-o o.png -o o.png in.exr", GP_ERR_USAGE, "o.png: given for two"},
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

// -- a folder with frames ----------------------------------------------------

static const char *const files[] = {
    "s.0001.exr", "s.0002.exr", "s.0010.exr", "s.7.exr", "real@2x.exr",
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
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
