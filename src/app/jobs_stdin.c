#include "app/jobs.h"

#include "core/memory.h"

#include <stdio.h>
#include <stdlib.h>

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
