#include "app/jobs.h"

#include "core/memory.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
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
                         char *input, bool numbered, int frame)
{
    struct gp_job *grown = NULL;
    if (input) // doubles at powers of two
        grown = j->n & (j->n - 1) ? j->job
                : realloc(j->job, (size_t) (j->n ? 2 * j->n : 1) *
                                      sizeof *grown);
    if (!grown) {
        gp_free(input);
        return gp_fail(log, GP_ERR_BUG, "frame list: out of memory");
    }
    j->job = grown;
    j->job[j->n++] = (struct gp_job) {input, numbered, frame, NULL};
    return GP_OK;
}

static gp_status add_pattern(const struct gp_log *log,
                             const struct gp_settings *s,
                             const struct gp_pattern *p, struct gp_jobs *j)
{
    struct gp_frames f = {0};
    gp_status st = s->frames ? gp_frames_parse(log, s->frames, &f)
                             : gp_frames_on_disk(log, p, &f);
    for (int i = 0; i < f.n && !st; i++)
        st = add_job(log, j, gp_pattern_name(p, f.number[i]), true,
                     f.number[i]);
    gp_frames_free(&f);
    return st;
}

/* One job stands for stdin until it is read. */
static gp_status add_stdin(const struct gp_log *log,
                           const struct gp_settings *s, struct gp_jobs *j)
{
    struct gp_frames f = {0};
    gp_status st = s->frames ? gp_frames_parse(log, s->frames, &f) : GP_OK;
    if (!st)
        st = add_job(log, j, gp_strdup("-"), has_place(j) || s->frames,
                     f.n ? f.number[0] : 1);
    gp_frames_free(&f);
    return st;
}

static gp_status add_input(const struct gp_log *log,
                           const struct gp_settings *s, const char *path,
                           struct gp_jobs *j, bool *patterns)
{
    if (is_dash(path))
        return add_stdin(log, s, j);
    struct gp_pattern p = {0};
    int frame = 0;
    if (access(path, F_OK) != 0) {
        gp_status st = gp_pattern_find(log, path, &p);
        if (st)
            return st;
    }
    *patterns = *patterns || p.len;
    if (p.len)
        return add_pattern(log, s, &p, j);
    if (s->frames)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: --frames needs a pattern (found a plain name); "
                       "write shot.####.exr, or leave --frames out", path);
    bool numbered = has_place(j) && gp_frame_number(path, &frame);
    return add_job(log, j, gp_strdup(path), numbered, frame);
}

static int by_frame(const void *a, const void *b)
{
    const struct gp_job *x = *(struct gp_job *const *) a;
    const struct gp_job *y = *(struct gp_job *const *) b;
    return (x->frame > y->frame) - (x->frame < y->frame);
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
        if (order[i]->frame == order[i - 1]->frame)
            st = gp_fail(log, GP_ERR_USAGE,
                         "%s: frame %d comes twice (found it in %s); make the "
                         "two in separate runs", order[i]->input,
                         order[i]->frame, order[i - 1]->input);
    }
    gp_free(block);
    return st;
}

static gp_status add_inputs(const struct gp_log *log,
                            const struct gp_settings *s, struct gp_jobs *j,
                            bool *patterns)
{
    const struct gp_texts *in = &s->inputs;
    for (int i = 0; i < in->n; i++) {
        const char *path = in->at[i];
        if (is_dash(path) && in->n > 1)
            return gp_fail(log, GP_ERR_USAGE,
                           "-: stdin goes with no other input (found %d); "
                           "give - alone", in->n);
        if (is_dash(path) && isatty(STDIN_FILENO))
            return gp_fail(log, GP_ERR_USAGE,
                           "-: stdin is a terminal; pipe an EXR file in");
        if (is_dash(path) && is_dash(s->kernel.source))
            return gp_fail(log, GP_ERR_USAGE,
                           "-: frame and kernel cannot both come from stdin; "
                           "give one of them as a file");
        gp_status st = add_input(log, s, path, j, patterns);
        if (st)
            return st;
    }
    return GP_OK;
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

/* Several frames and patterns belong together. */
static gp_status check_pattern(const struct gp_log *log,
                               const struct gp_jobs *j, bool patterns,
                               const struct gp_pattern *p)
{
    if (!p->len && !is_dash(p->path) && (patterns || j->n > 1))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: one name for a sequence (found %d frame%s); write "
                       "a pattern such as out.####.png, or -", p->path, j->n,
                       j->n == 1 ? "" : "s");
    for (int i = 0; i < j->n && p->len; i++) {
        if (!j->job[i].numbered)
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: no frame number in this input (needed for "
                           "%s); number it, or write plain names",
                           j->job[i].input, p->path);
    }
    return GP_OK;
}

static gp_status check_patterns(const struct gp_log *log,
                                const struct gp_jobs *j, bool patterns)
{
    gp_status st = GP_OK;
    for (int i = 0; i < j->targets && !st; i++)
        st = check_pattern(log, j, patterns, &j->target[i].name);
    return st;
}

static gp_status check_twice(const struct gp_log *log, const char *a,
                             const char *b)
{
    if (b && strcmp(a, b) == 0)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: given for two outputs; %s", a,
                       is_dash(a) ? "only one can go to stdout"
                                  : "give each a name of its own");
    return GP_OK;
}

/* Refuses to write over a frame that is read, by any of its names. */
static gp_status check_input(const struct gp_log *log, const char *name,
                             const char *input)
{
    struct stat a, b;
    if (stat(name, &a) == 0 && S_ISREG(a.st_mode) && stat(input, &b) == 0 &&
        a.st_dev == b.st_dev && a.st_ino == b.st_ino)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: is the input (%s); write to another name", name,
                       input);
    return GP_OK;
}

static gp_status check_targets(const struct gp_log *log,
                               const struct gp_settings *s,
                               const struct gp_jobs *j, bool patterns)
{
    gp_status st;
    GP_TRY(check_patterns(log, j, patterns));
    if (has_place(j))
        GP_TRY(check_numbers(log, j));
    for (int i = 0; i < j->targets; i++) {
        const struct gp_pattern *p = &j->target[i].name;
        GP_TRY(check_twice(log, p->path, s->report));
        for (int k = 0; k < i; k++)
            GP_TRY(check_twice(log, p->path, j->target[k].name.path));
        if (is_dash(p->path) && isatty(STDOUT_FILENO))
            return gp_fail(log, GP_ERR_USAGE,
                           "-: stdout is a terminal; pipe it on, or give a "
                           "file");
        char *name = gp_job_name(&j->job[0], &j->target[i]);
        if (!name)
            return gp_fail(log, GP_ERR_BUG, "%s: out of memory", p->path);
        st = j->target[i].kind == GP_TARGET_HDR
                 ? gp_write_hdr_check(log, &s->write, name)
                 : gp_write_check(log, &s->write, name);
        if (!st)
            st = check_input(log, name, j->job[0].input);
        free(name);
        if (st)
            return st;
    }
out:
    return st;
}

// -- what is there -----------------------------------------------------------

bool gp_job_made(const struct gp_write_params *p, const struct gp_jobs *j,
                 const struct gp_job *job)
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

/* Frames that were asked for by number and are not there cost no work. */
static gp_status check_missing(const struct gp_log *log,
                               const struct gp_settings *s,
                               const struct gp_jobs *j)
{
    const struct gp_job *first = NULL;
    int missing = 0;
    if (!s->frames || s->skip_bad_frames)
        return GP_OK;
    for (int i = 0; i < j->n; i++) {
        // (what cannot be looked at says why when it is read)
        const bool gone = !is_dash(j->job[i].input) &&
                          access(j->job[i].input, F_OK) != 0 &&
                          (errno == ENOENT || errno == ENOTDIR);
        if (!gone || gp_job_made(&s->write, j, &j->job[i]))
            continue;
        first = first ? first : &j->job[i];
        missing++;
    }
    if (!first)
        return GP_OK;
    return gp_fail(log, GP_ERR_IO,
                   "%s: no such frame (the first of %d missing, of %d in "
                   "--frames %s); render %s, or give --skip-bad-frames",
                   first->input, missing, j->n, s->frames,
                   missing == 1 ? "it" : "them");
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
    GP_TRY(check_targets(log, s, &j, patterns));
    GP_TRY(check_missing(log, s, &j));
    if (is_dash(j.job[0].input)) {
        GP_TRY(gp_jobs_read_stdin(log, s, &j));
        GP_TRY(check_patterns(log, &j, patterns));
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
    gp_free(j->target);
    *j = (struct gp_jobs) {0};
}

char *gp_job_name(const struct gp_job *job, const struct gp_output *target)
{
    return gp_pattern_name(&target->name, job->frame);
}
