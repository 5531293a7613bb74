#include "app/pipeline.h"

#include "app/cache.h"
#include "app/stages.h"
#include "app/tally.h"
#include "core/clock.h"
#include "core/memory.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Which stages run, and what nobody needs after each. */
struct plan {
    bool on[GP_STAGES];
    unsigned dead[GP_STAGES];
};

/* From the files that are wanted back to what they need. */
static gp_status make_plan(const struct gp_run *r, struct plan *p)
{
    unsigned written = 0;
    for (int i = 0; i < r->jobs->targets; i++)
        written |= gp_target_needs(r->s, r->jobs->target[i].kind);
    unsigned wanted = (r->jobs->targets ? GP_HAS_FILES : 0u) |
                      (r->s->report ? GP_HAS_FLUX : 0u) |
                      (r->s->verify ? GP_HAS_MEASURED : 0u);
    unsigned needs[GP_STAGES], have = 0;
    for (int i = GP_STAGES - 1; i >= 0; i--) {
        bool writes = gp_stages[i].gives == GP_HAS_FILES;
        needs[i] = gp_stages[i].needs | (writes ? written : 0u);
        p->on[i] = (gp_stages[i].gives & wanted) &&
                   (!gp_stages[i].asked || gp_stages[i].asked(r->s));
        p->dead[i] = ~wanted;
        wanted |= p->on[i] ? needs[i] : 0u;
    }
    for (int i = 0; i < GP_STAGES; i++) {
        if (p->on[i] && (needs[i] & ~have))
            return gp_fail(r->log, GP_ERR_BUG,
                           "%s: runs before its input exists (bits %#x)",
                           gp_stages[i].name, needs[i] & ~have);
        const bool there = p->on[i] || (gp_stages[i].asked &&
                                        !gp_stages[i].asked(r->s));
        have |= there ? gp_stages[i].gives : 0u;
    }
    return GP_OK;
}

// -- one frame ---------------------------------------------------------------

static void begin_frame(struct gp_run *r, const struct gp_job *job)
{
    r->job = job;
    r->facts = (struct gp_facts) {
        .numbered = job->numbered, .frame = job->frame, .input = job->input,
        .outputs = r->names,
    };
    for (int i = 0; i < GP_TIMES; i++)
        r->facts.ms[i] = -1.0;
}

static void end_frame(struct gp_run *r)
{
    gp_run_release(r, ~0u);
    gp_suns_end_frame(&r->suns);
    gp_frame_free(&r->frame);
    for (int i = 0; i < r->jobs->targets; i++)
        GP_FREE(r->names[i]);
}

/* Tells the report and the log. */
static gp_status tell(struct gp_run *r)
{
    if (r->log->level >= GP_LEVEL_INFO) {
        char line[1024];
        gp_facts_text(&r->facts, line, sizeof line);
        gp_say(r->log, GP_LEVEL_INFO, "%s", line);
    }
    return r->s->report ? gp_report_frame(r->log, &r->report, &r->facts)
                        : GP_OK;
}

/* Frames that were left alone count as if they had not been asked for. */
static gp_status run_stages(struct gp_run *r, const struct plan *plan,
                            int index, int kept, struct gp_progress *progress)
{
    for (int i = 0; i < GP_STAGES; i++) {
        const struct gp_stage *stage = &gp_stages[i];
        if (!plan->on[i])
            continue;
        gp_progress_update(progress, index - kept, r->jobs->n - kept,
                           r->job->input, stage->name);
        double start = gp_now_ms();
        gp_status st = stage->run(r);
        if (st)
            return st;
        if (stage->time >= 0) {
            const double ms = gp_now_ms() - start;
            r->facts.ms[stage->time] = fmax(r->facts.ms[stage->time], 0) + ms;
            r->facts.total_ms += ms;
        }
        gp_run_release(r, plan->dead[i]);
    }
    return GP_OK;
}

// -- frames that fail --------------------------------------------------------

/* Hands every message on, and keeps the last error for the report. */
struct errors {
    const struct gp_log *to;
    char last[4096];
};

static void keep_error(void *user, enum gp_level level, const char *line)
{
    struct errors *const e = user;
    if (level == GP_LEVEL_ERROR)
        snprintf(e->last, sizeof e->last, "%s", line);
    if (e->to && e->to->sink)
        e->to->sink(e->to->user, level, line);
}

static struct gp_log log_of_errors(const struct gp_log *to, struct errors *e)
{
    *e = (struct errors) {.to = to};
    return (struct gp_log) {keep_error, e, to ? to->level : GP_LEVEL_ERROR};
}

/* True for what may be wrong with one frame alone; a lost context, a full
 * memory or a closed stdout would fail the others too. */
static bool can_skip(const struct gp_run *r, gp_status st)
{
    const char *const writing = r->names[r->facts.n_outputs];
    if (st == GP_ERR_IO && writing && strcmp(writing, "-") == 0)
        return false;
    return r->s->skip_bad_frames && (st == GP_ERR_IO || st == GP_ERR_DATA ||
                                     st == GP_ERR_USAGE);
}

static gp_status make_frame(struct gp_run *r, const struct plan *plan,
                            int index, struct gp_progress *progress,
                            struct gp_tally *tally)
{
    begin_frame(r, &r->jobs->job[index]);
    gp_status st = run_stages(r, plan, index, tally->kept, progress);
    if (!st) {
        st = tell(r);
    } else if (can_skip(r, st)) {
        const struct errors *const e = r->log->user;
        gp_tally_fail(tally, index);
        st = r->s->report ? gp_report_failed(r->log, &r->report, &r->facts,
                                             e->last) : GP_OK;
    }
    end_frame(r);
    return st;
}

// -- all frames --------------------------------------------------------------

/* What is made once; everything that can fail without a frame fails here. */
static gp_status begin_run(struct gp_run *r)
{
    gp_status st;
    void *block;
    GP_TRY(gp_alloc_zero(r->log, "output list", (size_t) r->jobs->targets + 1,
                         sizeof *r->names, &block));
    r->names = block;
    r->glare = r->s->glare;
    if (r->glare.fft_plan == GP_FFT_PLAN_MEASURE)
        r->wisdom = gp_cache_file("fft-wisdom");
    r->glare.wisdom = r->wisdom;
    GP_TRY(gp_run_read_kernel(r));
    if (r->s->ocio.config)
        GP_TRY(gp_ocio_open(r->log, &r->s->ocio, &r->ocio));
    GP_TRY(gp_suns_begin(r->log, r->s, &r->suns));
    if (r->s->report)
        GP_TRY(gp_report_open(r->log, r->s->report, &r->report));
out:
    return st;
}

gp_status gp_pipeline_run(const struct gp_log *log,
                          const struct gp_settings *s,
                          const struct gp_jobs *jobs,
                          struct gp_progress *progress)
{
    gp_status st;
    struct errors errors;
    const struct gp_log errors_log = log_of_errors(log, &errors);
    struct gp_settings own = *s;
    own.write.no_clobber = false; // a set that is not whole is made anew
    struct gp_run r = {.log = &errors_log, .s = &own, .jobs = jobs};
    struct gp_tally tally = {0};
    struct plan plan;
    GP_TRY(make_plan(&r, &plan));
    GP_TRY(begin_run(&r));
    GP_TRY(gp_tally_make(log, jobs, &tally));
    for (int i = 0; i < jobs->n; i++) {
        if (gp_job_made(&s->write, jobs, &jobs->job[i]))
            tally.kept++;
        else
            GP_TRY(make_frame(&r, &plan, i, progress, &tally));
    }
    GP_TRY(gp_tally_end(log, &tally));
out:;
    gp_status closed = gp_report_close(st ? NULL : log, &r.report);
    gp_tally_free(&tally);
    gp_glare_close(&r.engines);
    gp_suns_close(&r.suns);
    gp_ocio_close(&r.ocio);
    gp_kernel_free(&r.kernel);
    gp_free(r.names);
    free(r.wisdom);
    return st ? st : closed;
}
