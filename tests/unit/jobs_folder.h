/* A folder with files of no bytes, and command lines whose jobs are made in
 * it. */
#ifndef GP_TESTS_JOBS_FOLDER_H
#define GP_TESTS_JOBS_FOLDER_H

#include "app/jobs.h"
#include "option_line.h"

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

struct job_row {
    const char *line;
    gp_status status;
    const char *text;  // of the error, or "input>outputs" of each frame
};

static gp_status make(const char *line, struct gp_settings *s,
                      struct gp_jobs *j)
{
    const gp_status st = parse(line, s);
    return st ? st : gp_jobs_make(&keeper, s, j);
}

/* "input>output,output input>...", the input with # where numbered and its
 * view behind that or :, an output of several views with ! */
static void describe(const struct gp_jobs *j, char *text, size_t size)
{
    size_t at = 0;
    for (int i = 0; i < j->n; i++) {
        const struct gp_job *const job = &j->job[i];
        const char *const view = job->view ? job->view : "";
        at += (size_t) snprintf(text + at, size - at, "%s%s%s%s>",
                                i ? " " : "", job->input,
                                job->numbered ? "#" : *view ? ":" : "", view);
        for (int k = 0; k < j->targets; k++) {
            char *name = gp_job_name(&j->job[i], &j->target[k]);
            at += (size_t) snprintf(text + at, size - at, "%s%s%s",
                                    k ? "," : "", name,
                                    j->target[k].whole ? "!" : "");
            free(name);
        }
    }
}

static void check_row(const struct job_row *r, bool views, bool parts)
{
    struct gp_settings s;
    struct gp_jobs j = {0};
    char text[1024] = "";
    gp_status st = make(r->line, &s, &j);
    describe(&j, text, sizeof text);
    bool same = st ? strstr(said, r->text) != NULL
                   : strcmp(text, r->text) == 0;
    if (st != r->status || !same)
        fail_msg("%s: status %d: %s%s", r->line, st, said, text);
    if (!st && j.views != (parts ? gp_jobs_of_frame(&j) : 1))
        fail_msg("%s: %d jobs of one input", r->line, j.views);
    if (!st && !views && (j.view.n || gp_jobs_of_frame(&j) != 1))
        fail_msg("%s: %d views", r->line, j.view.n);
    gp_jobs_free(&j);
    gp_jobs_free(&j);
    gp_settings_free(&s);
}

struct made_row {
    const char *line;
    bool made;  // of the first frame
};

/* A test whose state is rows, the last without a line. */
static void what_is_made(void **state)
{
    for (const struct made_row *r = *state; r->line; r++) {
        struct gp_settings s;
        struct gp_jobs j = {0};
        if (make(r->line, &s, &j) != GP_OK)
            fail_msg("%s: %s", r->line, said);
        if (gp_job_made(&s.write, &j, &j.job[0]) != r->made)
            fail_msg("%s", r->line);
        gp_jobs_free(&j);
        gp_settings_free(&s);
    }
}

// -- a folder with frames ----------------------------------------------------

static const char *const files[] = {
    "s.0001.exr", "s.0002.exr", "s.0010.exr", "s.7.exr", "real@2x.exr",
    "m.8.png", "m.1.png", "m.1.exr", "v.left.0001.exr", "v.right.0001.exr",
    "v.left.0002.exr", "v.right.0002.exr", "q.left.0001.exr",
    "q.right.0001.exr", "q.left.0002.exr", "w.l.exr", "w.r.exr", "lit.%V.exr",
    "m.left.1.png", "m.right.1.png", "m.left.2.png", "m.left.3.png",
    "m.left.4.png", "m.right.4.png", "x.10000.exr",
};
static const char *const folders[] = {"d.left", "d.right"};
static char folder[] = "/tmp/gp_jobs_XXXXXX";

static int make_folder(void **state)
{
    (void) state;
    if (!mkdtemp(folder) || chdir(folder) != 0)
        return -1;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        close(creat(files[i], 0600));
    for (int i = 0; i < 2; i++) {
        char name[16];
        if (mkdir(folders[i], 0700) != 0)
            return -1;
        snprintf(name, sizeof name, "%s/%c.1.exr", folders[i], folders[i][2]);
        close(creat(name, 0600));
    }
    // "-" must not be a terminal here
    return freopen("/dev/null", "r", stdin) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void) state;
    for (size_t i = 0; i < sizeof files / sizeof files[0]; i++)
        unlink(files[i]);
    for (int i = 0; i < 2; i++) {
        char name[16];
        snprintf(name, sizeof name, "%s/%c.1.exr", folders[i], folders[i][2]);
        unlink(name);
        rmdir(folders[i]);
    }
    return chdir("/") || rmdir(folder);
}

#endif
