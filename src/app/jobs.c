#include "app/jobs.h"

#include "core/memory.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool is_dash(const char *path)
{
    return strcmp(path, "-") == 0;
}

/* True when some output is a pattern. */
static bool has_place(const struct gp_jobs *j)
{
    for (int i = 0; i < j->targets; i++) {
        if (j->target[i].name.len)
            return true;
    }
    return false;
}

// -- frames ------------------------------------------------------------------

/* Appends a job; takes `input`, which may be NULL when memory was full. */
static gp_status add_job(const struct gp_log *log, struct gp_jobs *j,
                         struct gp_job job)
{
    struct gp_job *grown = NULL;
    if (job.input) // doubles at powers of two
        grown = (j->n & (j->n - 1)) ? j->job
                : realloc(j->job, (size_t) (j->n ? 2 * j->n : 1) *
                                      sizeof *grown);
    if (!grown) {
        gp_free(job.input);
        return gp_fail_bare(log, GP_ERR_BUG, "frame list: out of memory");
    }
    j->job = grown;
    j->job[j->n++] = job;
    return GP_OK;
}

/* Appends all views of one frame. */
static gp_status add_frame(const struct gp_log *log, struct gp_jobs *j,
                           const struct gp_pattern *p, bool numbered,
                           int frame)
{
    gp_status st = GP_OK;
    if (j->n > GP_FRAME_LIST_MAX - gp_jobs_of_frame(j))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: too many frames (over %d); make them in several "
                       "runs", p->path, GP_FRAME_LIST_MAX);
    for (int i = 0; i < gp_jobs_of_frame(j) && !st; i++) {
        const char *const view = j->view.n ? j->view.name[i] : NULL;
        st = add_job(log, j, (struct gp_job) {
            gp_pattern_name(p, frame, view), numbered, frame, view,
        });
    }
    return st;
}

/* The frames of which some view is on disk. */
static gp_status list_views(const struct gp_log *log,
                            const struct gp_pattern *p,
                            const struct gp_views *view,
                            struct gp_frames *all)
{
    gp_status st = GP_OK;
    for (int i = 0; i < view->n; i++) {
        struct gp_frames more = {0};
        st = gp_frames_on_disk(NULL, p, view->name[i], &more);
        if (!st && !gp_frames_join(all, &more))
            st = gp_fail_bare(log, GP_ERR_BUG, "frame list: out of memory");
        gp_frames_free(&more);
        if (st && st != GP_ERR_IO)
            return st;
    }
    // the first view says why there is none
    return all->n ? GP_OK : gp_frames_on_disk(log, p, view->name[0], all);
}

static gp_status add_pattern(const struct gp_log *log,
                             const struct gp_settings *s,
                             const struct gp_pattern *p, struct gp_jobs *j)
{
    struct gp_frames f = {0};
    gp_status st = s->frames  ? gp_frames_parse(log, s->frames, &f)
                   : p->views ? list_views(log, p, &j->view, &f)
                              : gp_frames_on_disk(log, p, NULL, &f);
    for (int i = 0; i < f.n && !st; i++)
        st = add_frame(log, j, p, true, f.number[i]);
    gp_frames_free(&f);
    return st;
}

/* One frame stands for stdin until it is read. */
static gp_status add_stdin(const struct gp_log *log,
                           const struct gp_settings *s, struct gp_jobs *j)
{
    const struct gp_pattern p = {.path = "-"};
    struct gp_frames f = {0};
    gp_status st = s->frames ? gp_frames_parse(log, s->frames, &f) : GP_OK;
    if (!st)
        st = add_frame(log, j, &p, has_place(j) || s->frames,
                       f.n ? f.number[0] : 1);
    gp_frames_free(&f);
    return st;
}

static gp_status add_input(const struct gp_log *log,
                           const struct gp_settings *s,
                           const struct gp_pattern *p, struct gp_jobs *j)
{
    int frame = 0;
    if (is_dash(p->path))
        return add_stdin(log, s, j);
    if (p->len)
        return add_pattern(log, s, p, j);
    if (s->frames)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: --frames needs a pattern (found a plain name); "
                       "write shot.####.exr, or leave --frames out", p->path);
    bool numbered = has_place(j) && gp_frame_number(p->path, &frame);
    return add_frame(log, j, p, numbered, frame);
}

// -- inputs ------------------------------------------------------------------

static gp_status check_stdin(const struct gp_log *log,
                             const struct gp_settings *s)
{
    if (s->inputs.n > 1)
        return gp_fail(log, GP_ERR_USAGE,
                       "-: stdin goes with no other input (found %d); "
                       "give - alone", s->inputs.n);
    if (isatty(STDIN_FILENO))
        return gp_fail(log, GP_ERR_USAGE,
                       "-: stdin is a terminal; pipe an EXR file in");
    if (is_dash(s->kernel.source))
        return gp_fail(log, GP_ERR_USAGE,
                       "-: frame and kernel cannot both come from stdin; "
                       "give one of them as a file");
    return GP_OK;
}

/* Finds the places in all inputs; a file that has the very name has none. */
static gp_status find_inputs(const struct gp_log *log,
                             const struct gp_settings *s,
                             struct gp_pattern *in, bool *patterns)
{
    for (int i = 0; i < s->inputs.n; i++) {
        const char *const path = s->inputs.at[i];
        gp_status st;
        in[i] = (struct gp_pattern) {.path = path};
        st = is_dash(path) ? check_stdin(log, s)
                           : gp_pattern_of_input(log, path, &in[i]);
        if (st)
            return st;
        *patterns = *patterns || in[i].len;
    }
    return GP_OK;
}

/* Settles which views there are, and whether they are files or parts. */
static gp_status find_views(const struct gp_log *log,
                            const struct gp_settings *s,
                            const struct gp_pattern *in, struct gp_jobs *j)
{
    const bool in_names = in[0].views > 0;
    gp_status st = GP_OK;
    for (int i = 1; i < s->inputs.n; i++) {
        if ((in[i].views > 0) != in_names)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: no %%V or %%v (found in %s); make the two in "
                           "separate runs", in[in_names ? i : 0].path,
                           in[in_names ? 0 : i].path);
    }
    if (s->views || in_names)
        st = gp_views_parse(log, s->views ? s->views : "left,right", &j->view);
    for (int i = 0; i < s->inputs.n && !st; i++)
        st = gp_views_check(log, &in[i], &j->view);
    j->views = in_names ? 1 : gp_jobs_of_frame(j);
    j->views_inside = !in_names && j->view.n > 0;
    for (int i = 0; i < j->targets; i++)
        j->target[i].whole = j->target[i].kind == GP_TARGET_HDR &&
                             j->views > 1 && !j->target[i].name.views;
    return st;
}

static gp_status add_inputs(const struct gp_log *log,
                            const struct gp_settings *s, struct gp_jobs *j,
                            bool *patterns)
{
    gp_status st;
    void *block;
    GP_TRY(gp_alloc_zero(log, "input list", (size_t) s->inputs.n,
                         sizeof(struct gp_pattern), &block));
    struct gp_pattern *const in = block;
    st = find_inputs(log, s, in, patterns);
    if (!st)
        st = find_views(log, s, in, j);
    for (int i = 0; i < s->inputs.n && !st; i++)
        st = add_input(log, s, &in[i], j);
    gp_free(block);
out:
    return st;
}

// -- outputs -----------------------------------------------------------------

static gp_status add_target(const struct gp_log *log, struct gp_jobs *j,
                            enum gp_target_kind kind, const char *path)
{
    if (!path)
        return GP_OK;
    struct gp_output *t = &j->target[j->targets++];
    t->kind = kind;
    return gp_pattern_find(log, path, &t->name);
}

static gp_status add_targets(const struct gp_log *log,
                             const struct gp_settings *s, struct gp_jobs *j)
{
    gp_status st;
    void *block;
    GP_TRY(gp_alloc_zero(log, "output list",
                         (size_t) s->outputs.n + 2 + GP_DEBUG_KINDS,
                         sizeof *j->target, &block));
    j->target = block;
    // --hdr first: it may copy from an input that a later output replaces
    GP_TRY(add_target(log, j, GP_TARGET_HDR, s->hdr));
    GP_TRY(add_target(log, j, GP_TARGET_LAYER, s->layer));
    for (int i = 0; i < s->outputs.n; i++)
        GP_TRY(add_target(log, j, GP_TARGET_PICTURE, s->outputs.at[i]));
    GP_TRY(add_target(log, j, GP_TARGET_SENSORS, s->debug[GP_DEBUG_SENSORS]));
    GP_TRY(add_target(log, j, GP_TARGET_POLYGONS,
                      s->debug[GP_DEBUG_POLYGONS]));
    GP_TRY(add_target(log, j, GP_TARGET_SUNMAP, s->debug[GP_DEBUG_SUNMAP]));
    GP_TRY(add_target(log, j, GP_TARGET_INTENSITY,
                      s->debug[GP_DEBUG_INTENSITY]));
out:
    return st;
}

// -- both --------------------------------------------------------------------

gp_status gp_jobs_make(const struct gp_log *log, const struct gp_settings *s,
                       struct gp_jobs *out)
{
    gp_status st;
    struct gp_jobs j = {.views = 1, .members.stream = GP_STREAM_EMPTY};
    bool patterns = false;
    GP_TRY(add_targets(log, s, &j));
    GP_TRY(add_inputs(log, s, &j, &patterns));
    GP_TRY(gp_jobs_check_targets(log, s, &j, patterns));
    GP_TRY(gp_jobs_check_missing(log, s, &j));
    if (is_dash(j.job[0].input)) {
        GP_TRY(gp_jobs_read_stdin(log, s, &j));
        GP_TRY(gp_jobs_check_patterns(log, &j, patterns));
        GP_TRY(gp_jobs_check_names(log, s, &j, NULL));
    }
    *out = j;
    return GP_OK;
out:
    gp_jobs_free(&j);
    return st;
}

void gp_jobs_free(struct gp_jobs *j)
{
    for (int i = 0; i < j->n; i++)
        free(j->job[i].input);
    free(j->job);
    gp_members_free(&j->members);
    gp_views_free(&j->view);
    gp_free(j->target);
    *j = (struct gp_jobs) {0};
}

char *gp_job_name(const struct gp_job *job, const struct gp_output *target)
{
    return gp_pattern_name(&target->name, job->frame, job->view);
}

int gp_jobs_of_frame(const struct gp_jobs *j)
{
    return j->view.n ? j->view.n : 1;
}
