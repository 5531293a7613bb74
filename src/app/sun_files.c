#include "app/stages.h"

#include "io/plane.h"
#include "io/sequence.h"

#include <stdlib.h>

static gp_status read_picture(void *user, const struct gp_log *log,
                              const char *path, struct gp_frame *out)
{
    const struct gp_sun_files *const files = user;
    const struct gp_read_params limits = gp_read_limits(&files->s->input.read);
    return gp_read_frame(log, &limits, path, out);
}

bool gp_job_number(const struct gp_job *job, int *number)
{
    *number = job->frame;
    return job->numbered || gp_frame_number(job->input, number);
}

struct gp_sun_about gp_job_about(const struct gp_job *job,
                                 const struct gp_frame *f)
{
    struct gp_sun_about about = {.name = job->input, .ndc = GP_NDC_AUTO};
    about.numbered = gp_job_number(job, &about.number);
    about.has_camera = gp_frame_matrix(f, "worldToCamera", about.to_camera);
    about.has_ndc = gp_frame_matrix(f, "worldToNDC", about.to_ndc);
    if (!about.has_ndc) {
        about.has_ndc = gp_frame_matrix(f, "worldToScreen", about.to_ndc);
        about.ndc = GP_NDC_CLIP;
    }
    return about;
}

static void describe_frame(void *user, const struct gp_frame *f,
                           struct gp_sun_about *out)
{
    *out = gp_job_about(((struct gp_sun_files *) user)->job, f);
}

/* Reads a plane from a file of its own, whose name may be a pattern. */
static gp_status read_beside(
    const struct gp_sun_files *files, const struct gp_log *log,
    const char *path, const char *channel, bool depth, struct gp_plane *out)
{
    const struct gp_job *const job = files->job;
    struct gp_pattern pattern;
    int number = 0;
    gp_status st = gp_pattern_of_input(log, path, &pattern);
    if (st)
        return st;
    if (pattern.views && !job->view)
        return gp_fail(log, GP_ERR_USAGE, "%s: %%V and %%v need views (%s has "
            "none); give a plain file name, or --views", path, job->input);
    if (pattern.len && !gp_job_number(job, &number))
        return gp_fail(log, GP_ERR_USAGE, "%s: a pattern needs frame numbers "
                       "(%s has none); give a plain file name", path,
                       job->input);
    char *const name = gp_pattern_name(&pattern, number, job->view);
    if (!name)
        return gp_no_memory(log, path);
    st = gp_read_plane_file(log, &files->s->input.read, name, channel, depth,
                            out);
    free(name);
    return st;
}

static gp_status read_planes(void *user, const struct gp_log *log,
    const struct gp_frame *f, struct gp_plane *depth, struct gp_plane *mask)
{
    const struct gp_sun_files *const files = user;
    const struct gp_settings *const s = files->s;
    const struct gp_sun_params *const p = &s->sun;
    gp_status st = p->depth_file ? read_beside(files, log, p->depth_file,
                                               s->input.depth, true, depth)
                                 : gp_read_plane(log, &s->input.read, f,
                                                 s->input.depth, true, depth);
    if (!st && p->mask_file)
        st = read_beside(files, log, p->mask_file, p->mask, false, mask);
    else if (!st && p->mask)
        st = gp_read_plane(log, &s->input.read, f, p->mask, false, mask);
    return st;
}

struct gp_sun_reader gp_sun_reader_of(struct gp_sun_files *files)
{
    return (struct gp_sun_reader) {files, read_picture, describe_frame,
                                   read_planes};
}

double gp_run_fov(const struct gp_run *r, const struct gp_frame_state *fs)
{
    if (r->s->kernel.fov > 0.0f)
        return (double) r->s->kernel.fov;
    const struct gp_sun_about about = gp_job_about(fs->job, &fs->frame);
    return gp_suns_fov(&r->suns, &about, &fs->frame);
}
