/* Every name that a run writes, held against the others and all it reads. */
#include "app/files.h"
#include "app/jobs.h"

#include <stdlib.h>
#include <string.h>

// -- outputs -----------------------------------------------------------------

static const char *option_of(enum gp_target_kind kind)
{
    switch (kind) {
    case GP_TARGET_HDR:
        return "--hdr";
    case GP_TARGET_LAYER:
        return "--layer";
    case GP_TARGET_PICTURE:
        return "--output";
    case GP_TARGET_SENSORS:
        return "--debug sensors";
    case GP_TARGET_POLYGONS:
        return "--debug polygons";
    case GP_TARGET_SUNMAP:
        return "--debug sunmap";
    case GP_TARGET_INTENSITY:
        return "--debug intensity";
    }
    return "";
}

/* The role is a target, the item a job. */
static struct gp_file_owner owner(const void *user,
                                  const struct gp_file_id *id)
{
    const struct gp_jobs *const j = user;
    const struct gp_output *const t = &j->target[id->role];
    return (struct gp_file_owner) {
        .name = gp_job_name(&j->job[id->item], t),
        .what = option_of(t->kind),
        .as = t->name.path,
        .of = j->n > 1 ? j->job[id->item].input : NULL,
        .view = j->n > 1 ? j->job[id->item].view : NULL,
    };
}

static gp_status add_output(const struct gp_log *log, struct gp_files *f,
                            const struct gp_jobs *j, int target, int job)
{
    const struct gp_output *const t = &j->target[target];
    char *const name = gp_job_name(&j->job[job], t);
    if (!name)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", t->name.path);
    gp_status st = t->name.views && strcmp(name, "-") == 0
        ? gp_fail(log, GP_ERR_USAGE,
                  "%s: is - for a view, which is stdout; write ./%s",
                  t->name.path, t->name.path)
        : gp_files_write(f, name, target, job);
    free(name);
    return st;
}

/* A stream and a file of all views are one for several jobs. */
static gp_status add_outputs(const struct gp_log *log, struct gp_files *f,
                             const struct gp_jobs *j)
{
    gp_status st = GP_OK;
    for (int i = 0; i < j->targets; i++) {
        const struct gp_output *const t = &j->target[i];
        const bool stream = strcmp(t->name.path, "-") == 0;
        const int step = stream ? j->n : t->whole ? j->views : 1;
        for (int k = 0; k < j->n && !st; k += step)
            st = add_output(log, f, j, i, k);
    }
    return st;
}

// -- inputs ------------------------------------------------------------------

/* The files of --depth-file and --mask-file when these are patterns. */
static gp_status check_beside(const struct gp_log *log,
                              const struct gp_files *f, const char *what,
                              const char *path, const struct gp_jobs *j)
{
    struct gp_pattern p = {0};
    gp_status st = path ? gp_pattern_of_input(log, path, &p) : GP_OK;
    if (st || (!p.len && !p.views))
        return st;
    for (int i = 0; i < j->n && !st; i++) {
        const struct gp_job *const job = &j->job[i];
        int number = job->frame;
        if ((p.views && !job->view) ||
            (p.len && !job->numbered && !gp_frame_number(job->input, &number)))
            continue; // it is told when the frame is read
        char *const name = gp_pattern_name(&p, number, job->view);
        st = name ? gp_files_read(f, what, name)
                  : gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
        free(name);
    }
    return st;
}

static gp_status check_inputs(const struct gp_log *log,
                              const struct gp_settings *s,
                              const struct gp_files *f,
                              const struct gp_jobs *j)
{
    gp_status st = GP_OK;
    // (frames of stdin have names of their own)
    if (j->members.n)
        st = gp_files_read(f, "input", "-");
    for (int i = 0; i < j->n && !j->members.n && !st; i += j->views)
        st = gp_files_read(f, "input", j->job[i].input);
    if (!st)
        st = check_beside(log, f, "--depth-file", s->sun.depth_file, j);
    return st ? st : check_beside(log, f, "--mask-file", s->sun.mask_file, j);
}

gp_status gp_jobs_check_names(const struct gp_log *log,
                              const struct gp_settings *s,
                              const struct gp_jobs *j,
                              const struct gp_texts *also)
{
    gp_status st;
    struct gp_files f;
    GP_TRY(gp_files_begin(log, s, owner, j, &f));
    GP_TRY(add_outputs(log, &f, j));
    GP_TRY(gp_files_settle(&f));
    if (f.there)
        GP_TRY(check_inputs(log, s, &f, j));
    for (int i = 0; also && i < also->n; i++)
        GP_TRY(gp_files_read(&f, "another file names", also->at[i]));
out:
    gp_files_end(&f);
    return st;
}
