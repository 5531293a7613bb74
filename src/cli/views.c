/* Finds the views of a run that the command line does not name: all that the
 * first input holds. */
#include "cli/jobs.h"

#include "core/memory.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

bool gp_views_all(const struct gp_settings *s)
{
    return !s->input.views || strcmp(s->input.views, "all") == 0;
}

/* Replaces each job by one for each view; takes over `found`. */
static gp_status spread_views(const struct gp_log *log, struct gp_jobs *j,
                              struct gp_views *found)
{
    const int n = found->n;
    struct gp_job *job;
    j->view = *found;
    *found = (struct gp_views) {0};
    if (j->n > GP_FRAME_LIST_MAX / n)
        return gp_fail(log, GP_ERR_USAGE, "%s: too many frames (over %d); make "
                       "them in several runs", j->job[0].input,
                       GP_FRAME_LIST_MAX);
    gp_status st = gp_alloc_zero(log, "frame list",
                                 (size_t) j->n * (size_t) n, sizeof *job, &job);
    for (int i = 0; i < j->n * n && !st; i++) {
        job[i] = j->job[i / n];
        job[i].view = j->view.name[i % n];
        if (i % n == 0)
            continue;
        job[i].input = gp_strdup(j->job[i / n].input);
        if (!job[i].input)
            st = gp_no_memory_bare(log, "frame list");
    }
    if (st) { // each frame's first input is still owned by j
        for (int i = 0; job && i < j->n * n; i++) {
            if (i % n)
                free(job[i].input);
        }
        gp_free(job);
        return st;
    }
    gp_free(j->job);
    j->job = job;
    j->n *= n;
    j->views = n;
    j->views_inside = true;
    return GP_OK;
}

/* Finds the views of the first input that is a regular file: a pipe can be read
 * only once. `log` is NULL where reading the frame will report the error. */
static gp_status find_views(const struct gp_log *log,
    const struct gp_settings *s, const struct gp_jobs *j,
    struct gp_views *found, const char **input)
{
    *input = j->job[0].input;
    if (j->members.n)
        return gp_members_views(log, &s->input.read, &j->members, found);
    gp_status st = GP_OK;
    for (int i = 0; i < j->n; i++) {
        struct stat info;
        *input = j->job[i].input;
        if (stat(*input, &info) != 0 || !S_ISREG(info.st_mode))
            continue;
        st = gp_read_views(log, &s->input.read, *input, found);
        if (!st || st == GP_ERR_BUG)
            return st;
    }
    return st;
}

gp_status gp_jobs_find_views(const struct gp_log *log,
    const struct gp_settings *s, struct gp_jobs *j)
{
    struct gp_views found = {0};
    char list[512] = "", line[GP_LINE_BYTES];
    const char *input, *hero = NULL; // an output of the first view only
    bool places = false;             // an output by view
    j->views_found = j->targets == 0;  // the report has a line for each
    for (int i = 0; i < j->targets; i++) {
        const struct gp_output *const t = &j->target[i];
        places = places || t->name.views;
        if (!hero && t->kind != GP_TARGET_HDR && !t->name.views)
            hero = t->name.path;
        j->views_found = j->views_found || t->kind == GP_TARGET_HDR ||
                         t->name.views;
    }
    gp_status st = find_views(NULL, s, j, &found, &input);
    // names with %V cannot be made without views: report why there are none
    if (st == GP_ERR_IO && places && j->n == 1)
        GP_TRY(find_views(log, s, j, &found, &input));
    if (st == GP_ERR_BUG)
        return gp_no_memory(log, input);
    if (st || found.n == 0)
        return GP_OK;
    for (int i = 0; i < found.n; i++) {
        const char *const name = found.name[i];
        const size_t used = strlen(list);
        snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", name);
        if (places && (strchr(name, '/') || strcmp(name, ".") == 0 ||
                       strcmp(name, "..") == 0))
            st = gp_fail(log, GP_ERR_DATA, "%s: has a view whose name cannot "
                         "be part of a file name (found %s); choose others "
                         "with --views", input, name);
    }
    if (!st && !j->views_found)
        snprintf(line, sizeof line, "%s: makes only view %s of %s; write a "
                 "name with %%V to make all, or choose with --views", input,
                 found.name[0], list);
    else if (hero)
        snprintf(line, sizeof line, "%s: makes its views %s, but of %s only "
                 "%s; write a name with %%V to make all, or choose with "
                 "--views", input, list, hero, found.name[0]);
    else
        snprintf(line, sizeof line, "%s: makes its views %s; choose with "
                 "--views", input, list);
    if (!st) {
        gp_say(log, GP_LEVEL_WARN, "%s", line);
        free(j->views_line);
        j->views_line = gp_strdup(line);
        st = j->views_line ? GP_OK : gp_no_memory(log, input);
    }
    if (!st && j->views_found)
        st = spread_views(log, j, &found);
out:
    gp_views_free(&found);
    return st;
}

gp_status gp_jobs_check_views(const struct gp_log *log,
    const struct gp_read_params *p, const struct gp_jobs *j,
    const struct gp_frame *f)
{
    struct gp_views own;
    gp_status st = gp_frame_views(log, p, f, &own);
    for (int i = 0; i < own.n && !st; i++) {
        int k = 0;
        while (k < j->view.n && strcmp(j->view.name[k], own.name[i]) != 0)
            k++;
        if (k == j->view.n)
            st = gp_fail(log, GP_ERR_USAGE, "%s: has view %s (the first input "
                "has %s); choose with --views, or make it in a run of its own",
                f->path, own.name[i], j->view.n ? "others" : "none");
    }
    gp_views_free(&own);
    return st;
}
