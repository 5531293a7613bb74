/* What the names of outputs and inputs must meet before the first frame. */
#include "app/jobs.h"

#include "core/memory.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static bool is_dash(const char *path)
{
    return strcmp(path, "-") == 0;
}

// -- patterns ----------------------------------------------------------------

/* Several frames and patterns belong together. */
static gp_status check_frames(const struct gp_log *log,
                              const struct gp_jobs *j, bool patterns,
                              const struct gp_pattern *p)
{
    const int frames = j->n / gp_jobs_of_frame(j);
    if (!p->len && !is_dash(p->path) && (patterns || frames > 1))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: one name for a sequence (found %d frame%s); write "
                       "a pattern such as out.####.png, or -", p->path, frames,
                       frames == 1 ? "" : "s");
    for (int i = 0; i < j->n && p->len; i++) {
        if (!j->job[i].numbered)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: no frame number in this input (needed for "
                           "%s); number it, or write plain names",
                           j->job[i].input, p->path);
    }
    return GP_OK;
}

/* Several views and %V belong together. */
static gp_status check_views(const struct gp_log *log, const struct gp_jobs *j,
                             const struct gp_output *t)
{
    const struct gp_pattern *const p = &t->name;
    if (p->views && !j->view.n)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %%V and %%v are views, and there are none (no %%V "
                       "in %s, no --views); give --views left,right", p->path,
                       j->job[0].input);
    if (!p->views && !t->whole && j->view.n > 1 && !is_dash(p->path))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: one name for several views (found %d); write %%V "
                       "or %%v into it, such as out.%%V.png, or -", p->path,
                       j->view.n);
    return gp_views_check(log, p, &j->view);
}

gp_status gp_jobs_check_patterns(const struct gp_log *log,
                                 const struct gp_jobs *j, bool patterns)
{
    gp_status st = GP_OK;
    for (int i = 0; i < j->targets && !st; i++) {
        st = check_frames(log, j, patterns, &j->target[i].name);
        if (!st)
            st = check_views(log, j, &j->target[i]);
    }
    return st;
}

// -- numbers -----------------------------------------------------------------

static int by_frame(const void *a, const void *b)
{
    const struct gp_job *x = *(struct gp_job *const *) a;
    const struct gp_job *y = *(struct gp_job *const *) b;
    if (x->frame != y->frame)
        return x->frame > y->frame ? 1 : -1;
    const int order = x->view && y->view ? strcmp(x->view, y->view) : 0;
    return order ? order : (x > y) - (x < y);
}

/* Two inputs with one number would write one file twice. */
static gp_status check_numbers(const struct gp_log *log,
                               const struct gp_jobs *j)
{
    void *block;
    gp_status st = gp_alloc(log, "frame list", (size_t) j->n,
                            sizeof(struct gp_job *), &block);
    if (st)
        return st;
    const struct gp_job **order = block;
    for (int i = 0; i < j->n; i++)
        order[i] = &j->job[i];
    qsort(order, (size_t) j->n, sizeof *order, by_frame);
    for (int i = 1; i < j->n && !st; i++) {
        if (order[i]->frame == order[i - 1]->frame &&
            order[i]->view == order[i - 1]->view)
            st = gp_fail(log, GP_ERR_USAGE,
                         "%s: frame %d comes twice (found it in %s); make the "
                         "two in separate runs", order[i]->input,
                         order[i]->frame, order[i - 1]->input);
    }
    gp_free(block);
    return st;
}

// -- outputs -----------------------------------------------------------------

/* What gp_write_check() says of each view of the first frame. */
static gp_status check_first(const struct gp_log *log,
                             const struct gp_settings *s,
                             const struct gp_jobs *j,
                             const struct gp_output *t)
{
    gp_status st = GP_OK;
    for (int i = 0; i < gp_jobs_of_frame(j) && !st; i++) {
        char *const name = gp_job_name(&j->job[i], t);
        st = !name ? gp_fail(log, GP_ERR_BUG, "%s: out of memory",
                             t->name.path)
             : t->kind == GP_TARGET_HDR
                 ? gp_write_hdr_check(log, &s->write, name)
                 : gp_write_check(log, &s->write, name);
        free(name);
    }
    return st;
}

/* True when some output has a place for a number. */
static bool has_place(const struct gp_jobs *j)
{
    for (int i = 0; i < j->targets; i++) {
        if (j->target[i].name.len)
            return true;
    }
    return false;
}

gp_status gp_jobs_check_targets(const struct gp_log *log,
                                const struct gp_settings *s,
                                const struct gp_jobs *j, bool patterns)
{
    gp_status st;
    GP_TRY(gp_jobs_check_patterns(log, j, patterns));
    if (has_place(j))
        GP_TRY(check_numbers(log, j));
    for (int i = 0; i < j->targets; i++) {
        const struct gp_pattern *p = &j->target[i].name;
        if (is_dash(p->path) && isatty(STDOUT_FILENO))
            return gp_fail(log, GP_ERR_USAGE,
                           "-: stdout is a terminal; pipe it on, or give a "
                           "file");
        GP_TRY(check_first(log, s, j, &j->target[i]));
    }
    GP_TRY(gp_jobs_check_names(log, s, j, NULL));
out:
    return st;
}

// -- what is there -----------------------------------------------------------

static bool outputs_there(const struct gp_write_params *p,
                          const struct gp_jobs *j, const struct gp_job *job)
{
    for (int i = 0; i < j->targets; i++) {
        char *name = gp_job_name(job, &j->target[i]);
        const bool there = name && gp_write_would_clobber(p, name);
        free(name);
        if (!there)
            return false;
    }
    return p->no_clobber && j->targets > 0;
}

bool gp_job_made(const struct gp_write_params *p, const struct gp_jobs *j,
                 const struct gp_job *job)
{
    bool whole = false;
    for (int i = 0; i < j->targets; i++)
        whole = whole || j->target[i].whole;
    if (!whole)
        return outputs_there(p, j, job);
    const int at = (int) (job - j->job);
    for (int i = at - at % j->views, end = i + j->views; i < end; i++) {
        if (!outputs_there(p, j, &j->job[i]))
            return false;
    }
    return true;
}

static bool is_missing(const struct gp_settings *s, const struct gp_jobs *j,
                       int i)
{
    // (what cannot be looked at says why when it is read)
    if (is_dash(j->job[i].input) || access(j->job[i].input, F_OK) == 0 ||
        (errno != ENOENT && errno != ENOTDIR))
        return false;
    for (int k = i; k < i + j->views; k++) {
        if (!gp_job_made(&s->write, j, &j->job[k]))
            return true;
    }
    return false;
}

/* Frames that were asked for by number, and views of a frame, that are not
 * there cost no work. */
gp_status gp_jobs_check_missing(const struct gp_log *log,
                                const struct gp_settings *s,
                                const struct gp_jobs *j)
{
    const bool eyes = j->view.n > 1 && j->views == 1; // files of each frame
    const struct gp_job *first = NULL;
    int missing = 0;
    if ((!s->frames && !eyes) || s->skip_bad_frames)
        return GP_OK;
    for (int i = 0; i < j->n; i += j->views) {
        if (!is_missing(s, j, i))
            continue;
        first = first ? first : &j->job[i];
        missing++;
    }
    if (!first)
        return GP_OK;
    return gp_fail(log, GP_ERR_IO,
                   "%s: no such frame (the first of %d missing, of %d in "
                   "%s %s); render %s, or give --skip-bad-frames",
                   first->input, missing, j->n / j->views,
                   s->frames ? "--frames" : "--views",
                   s->frames  ? s->frames
                   : s->views ? s->views : "left,right",
                   missing == 1 ? "it" : "them");
}
