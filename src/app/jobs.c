#include "app/jobs.h"

#include "app/files.h"
#include "core/memory.h"

#include <errno.h>
#include <stdio.h>
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

/* The number of each frame: those of --frames, or 1, 2, 3. */
static gp_status number_frames(const struct gp_log *log,
                               const struct gp_settings *s,
                               struct gp_jobs *j)
{
    struct gp_frames f = {0};
    gp_status st = s->frames ? gp_frames_parse(log, s->frames, &f) : GP_OK;
    const int n = j->members.n;
    if (!st && s->frames && f.n != n)
        st = gp_fail(log, GP_ERR_USAGE,
                     "-: stdin has %d frame%s, --frames %s lists %d; list one "
                     "number for each", n, n == 1 ? "" : "s", s->frames, f.n);
    for (int i = 0; i < j->n && !st; i++)
        j->job[i].frame = s->frames ? f.number[i / j->views] : i / j->views + 1;
    gp_frames_free(&f);
    return st;
}

static char *name_of(int frame)
{
    char name[32];
    snprintf(name, sizeof name, "- (frame %d)", frame);
    return gp_strdup(name);
}

gp_status gp_jobs_read_stdin(const struct gp_log *log,
                             const struct gp_settings *s, struct gp_jobs *j)
{
    gp_status st = gp_members_read(log, &s->read, "-", &j->members);
    if (st)
        return st;
    const bool many = j->members.n > 1;
    if (j->members.n > GP_FRAME_LIST_MAX / j->views)
        return gp_fail(log, GP_ERR_USAGE,
                       "-: too many frames (over %d); make them in several "
                       "runs", GP_FRAME_LIST_MAX);
    const int n = j->members.n * j->views;
    struct gp_job *grown = realloc(j->job, (size_t) n * sizeof *grown);
    if (!grown)
        return gp_fail_bare(log, GP_ERR_BUG, "frame list: out of memory");
    j->job = grown;
    for (; j->n < n; j->n++) // its views are those of the first
        grown[j->n] = (struct gp_job) {.view = grown[j->n % j->views].view};
    st = number_frames(log, s, j);
    for (int i = 0; i < n && many && !st; i++) {
        j->job[i].numbered = true;
        free(j->job[i].input);
        j->job[i].input = name_of(j->job[i].frame);
        if (!j->job[i].input)
            st = gp_fail_bare(log, GP_ERR_BUG, "frame list: out of memory");
    }
    return st;
}
