#include "cli/commands.h"

#include "cli/flight.h"
#include "cli/machine.h"
#include "cli/plan_settings.h"
#include "cli/say.h"
#include "cli/stages.h"
#include "core/clock.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <string.h>

struct schedule {
    bool on[GP_STAGES];       // the stage runs
    unsigned dead[GP_STAGES]; // data that no later stage needs
    size_t pixel_bytes;       // peak of a frame, without carried channels
};

/* An input file in flight: one frame, or the views inside it. */
struct unit {
    struct gp_frame_log log;
    struct gp_frame_state *view; // jobs->views of them, owned
    int begun;                   // of these
    bool kept;                   // skipped: all its outputs exist
};

struct pipeline {
    const struct gp_log *log;
    const struct gp_settings *asked; // the command line's
    struct gp_settings s;            // the stages'
    const struct gp_jobs *jobs;
    struct gp_progress *progress;
    struct schedule schedule;
    struct gp_run run;
    struct gp_failures failures;
    struct gp_flight flight;
    struct unit *unit;               // one a slot, owned
    int slots;
    atomic_int kept;                 // frames skipped, for the progress
    atomic_size_t largest;           // bytes of the largest unit so far
    atomic_size_t shared;            // bytes that are no unit's
    atomic_bool lit;                 // a unit with light was computed
    atomic_int most;                 // units in flight so far
    size_t memory;                   // limit of the process; 0: unknown
    int frames, dark;                // written; of these without sources
    struct gp_frame_report brightest;       // of the dark frames
    struct gp_tally tally;           // of those written
};

/* Counts the peak bytes of a pixel. */
static void count_pixel_bytes(const struct gp_run *r, struct schedule *p)
{
    enum { PLANES = 3 * sizeof(float), EXACT = 3 * sizeof(double),
           FFT = 16, // rows and columns while they are made, some as doubles
           SPLAT = 4 * sizeof(float), // render target
           LENS = 32, // steps of 1, 2, 4, 8 and 16 pixels, 24 bytes each
           REST = 9 }; // sources, 14 each, and files
    const unsigned kinds[] = {GP_HAS_RGB, GP_HAS_LAYER, GP_HAS_LIT,
                              GP_HAS_SHOWN};
    const char *const name = r->s->light.layer.engine;
    const size_t engine = strcmp(name, "direct") == 0 ? 0
                          : strcmp(name, "fft") == 0 ? FFT : SPLAT;
    unsigned alive = 0;
    for (int i = 0; i < GP_STAGES; i++) {
        const unsigned gives = p->on[i] ? gp_stages[i].gives : 0u;
        size_t bytes = REST + (gives & GP_HAS_LAYER ? engine : 0) +
                       (gives & GP_HAS_MEASURED ? EXACT : 0) +
                       (gives & GP_HAS_LENS ? LENS : 0);
        alive |= gives;
        if ((gives & GP_HAS_LIT) && (p->dead[i] & GP_HAS_LAYER))
            alive &= ~(unsigned) GP_HAS_LAYER; // the lit frame's memory is that
        for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
            bytes += alive & kinds[k] ? PLANES : 0;
        p->pixel_bytes = bytes > p->pixel_bytes ? bytes : p->pixel_bytes;
        alive &= p->on[i] ? ~p->dead[i] : ~0u;
    }
}

/* Chooses the stages that the wanted files need, from the last to the first. */
static gp_status make_schedule(const struct gp_log *log,
                               const struct gp_run *r, struct schedule *p)
{
    unsigned written = 0;
    for (int i = 0; i < r->jobs->targets; i++)
        written |= gp_target_needs(r->s, r->jobs->target[i].kind);
    const bool reports = r->s->run.report || r->s->run.level >= GP_LEVEL_INFO;
    unsigned wanted = (r->jobs->targets ? GP_HAS_FILES : 0u) |
                      GP_HAS_END | (reports ? GP_HAS_SHARES : 0u) |
                      (r->s->run.verify ? GP_HAS_MEASURED : 0u);
    unsigned needs[GP_STAGES], have = 0;
    for (int i = GP_STAGES - 1; i >= 0; i--) {
        bool writes = gp_stages[i].gives == GP_HAS_FILES;
        needs[i] = gp_stages[i].needs | (writes ? written : 0u);
        // (composing tells what the layer's flux is)
        if (gp_stages[i].gives == GP_HAS_END &&
            (!r->s->run.report || wanted & GP_HAS_LIT))
            needs[i] = 0;
        p->on[i] = (gp_stages[i].gives & wanted) &&
                   (!gp_stages[i].asked || gp_stages[i].asked(r->s));
        p->dead[i] = ~wanted;
        wanted |= p->on[i] ? needs[i] : 0u;
    }
    for (int i = 0; i < GP_STAGES; i++) {
        if (p->on[i] && (needs[i] & ~have))
            return gp_fail(log, GP_ERR_BUG, "%s: runs before its input "
                "exists (bits %#x)", gp_stages[i].name, needs[i] & ~have);
        const bool there = p->on[i] || (gp_stages[i].asked &&
                                        !gp_stages[i].asked(r->s));
        have |= there ? gp_stages[i].gives : 0u;
    }
    count_pixel_bytes(r, p);
    return GP_OK;
}

// -- steps of a unit ---------------------------------------------------------

/* Counts the bytes of a frame's channels other than its colour. */
static size_t carried_bytes(const struct gp_frame *f)
{
    size_t bytes = 0;
    for (int i = 0; i < f->channels; i++) {
        const struct gp_channel *const c = &f->channel[i];
        bytes += c->data ? (size_t) c->w * (size_t) c->h * gp_type_size(c->type)
                         : 0;
    }
    return bytes;
}

/* Estimates the memory that a frame takes in flight, at most. */
static size_t frame_bytes(const struct pipeline *p,
                          const struct gp_frame_state *fs)
{
    const size_t pixels = gp_frame_pixels(&fs->file);
    const size_t group =
        (p->s.output.hdr.n ? 6 : 3) * sizeof(float); // read, lit
    size_t bytes = pixels * p->schedule.pixel_bytes + carried_bytes(&fs->file);
    for (int i = 0; i < fs->groups; i++)
        bytes += pixels * group + carried_bytes(&fs->group[i]);
    return bytes;
}

/* Measures what units share; call on the thread that computes. */
static void measure_shared(struct pipeline *p)
{
    const size_t peak = gp_peak_memory();
    const size_t units =
        (size_t) atomic_load(&p->most) * atomic_load(&p->largest);
    if (peak > units && peak - units > atomic_load(&p->shared))
        atomic_store(&p->shared, peak - units);
    atomic_store(&p->lit, true);
}

/* Runs a stage of a frame, and counts its time: of engines within it as
 * glare. */
static gp_status run_stage(struct pipeline *p, const struct gp_stage *stage,
                           struct gp_frame_state *fs)
{
    struct gp_cost_facts *const cost = &fs->facts.cost;
    const double start = gp_now_ms(), cpu = gp_cpu_ms();
    double engines = 0.0, engines_cpu = 0.0;
    const gp_status st =
        stage->run ? stage->run(&p->run, fs)
                   : (gp_status) glarepp_frame_run(fs->frame, stage->step);
    if (st)
        return st;
    if (!stage->run) {
        const struct glarepp_facts *const lib = glarepp_frame_facts(fs->frame);
        engines = lib->engines_ms;
        engines_cpu = lib->engines_cpu_ms;
        if (stage->step == GLAREPP_KERNEL && lib->kernel.ms > 0.0)
            gp_cost_add(cost, GP_TIME_KERNEL, lib->kernel.ms,
                        lib->kernel.cpu_ms);
    }
    gp_cost_add(cost, stage->time, gp_now_ms() - start - engines,
                gp_cpu_ms() - cpu - engines_cpu);
    if (engines > 0.0)
        gp_cost_add(cost, GP_TIME_GLARE, engines, engines_cpu);
    return GP_OK;
}

/* Runs the stages of a phase for one view. */
static gp_status run_view(struct pipeline *p, struct gp_frame_state *fs,
                          enum gp_phase phase)
{
    gp_status st = GP_OK;
    fs->facts.cost.has_cpu = p->slots == 1; // CPU time is the process's
    for (int i = 0; i < GP_STAGES && !st; i++) {
        const struct gp_stage *const stage = &gp_stages[i];
        if (!p->schedule.on[i] || stage->phase != phase)
            continue;
        // skipped frames count neither as done nor in the total
        const int kept = atomic_load(&p->kept);
        gp_progress_update(p->progress,
                           gp_flight_head(&p->flight) * p->jobs->views - kept,
                           p->jobs->n - kept, fs->job->input, stage->name);
        st = run_stage(p, stage, fs);
        if (!st)
            gp_frame_state_release(fs, p->schedule.dead[i]);
    }
    if (st && fs->frame) // the next frame needs what the plan lent
        (void) glarepp_frame_run(fs->frame, GLAREPP_DONE);
    return st;
}

static gp_status run_step(void *user, int slot, int unit, enum gp_phase phase)
{
    struct pipeline *const p = user;
    struct unit *const u = &p->unit[slot];
    const int views = p->jobs->views, first = unit * views;
    const struct gp_job *const job = &p->jobs->job[first];
    size_t bytes = 0;
    gp_status st = GP_OK;
    if (phase == GP_PHASE_READ) {
        gp_frame_log_open(&u->log, p->log, &p->flight, unit, job->input);
        u->kept = true;
        for (int v = 0; v < views && u->kept; v++)
            u->kept =
                gp_job_complete(&p->asked->output.write, p->jobs, &job[v]);
        if (u->kept)
            atomic_fetch_add(&p->kept, views);
        for (u->begun = 0; u->begun < views && !u->kept && !st; u->begun++)
            st = gp_frame_state_begin(&u->log.log, &p->run, first + u->begun,
                                      &u->view[u->begun]);
    }
    for (int v = 0; v < u->begun && !st; v++) {
        struct gp_frame_state *const fs = &u->view[v];
        st = run_view(p, fs, phase);
        if (phase == GP_PHASE_READ) {
            fs->facts.cost.bytes = frame_bytes(p, fs);
            bytes += fs->facts.cost.bytes;
        }
        if (phase == GP_PHASE_COMPUTE && fs->facts.lib.kernel.w > 0)
            measure_shared(p);
    }
    size_t largest = atomic_load(&p->largest);
    while (bytes > largest &&
           !atomic_compare_exchange_weak(&p->largest, &largest, bytes))
        ;
    return st;
}

// -- the end of a unit -------------------------------------------------------

static void free_unit(struct unit *u)
{
    while (u->begun > 0)
        gp_frame_state_end(&u->view[--u->begun]);
    gp_frame_log_close(&u->log);
    u->kept = false;
}

/* True for errors that may be of one frame only; a lost context, a full memory
 * or a closed stdout would fail the others too. */
static bool can_skip(void *user, int slot, gp_status st)
{
    const struct pipeline *const p = user;
    const struct unit *const u = &p->unit[slot];
    for (int v = 0; v < u->begun && st == GP_ERR_IO; v++) {
        const struct gp_frame_state *const fs = &u->view[v];
        const char *const writing = fs->facts.write.name[fs->facts.write.n];
        if (writing && gp_is_dash(writing))
            return false;
    }
    return p->asked->input.skip_bad_frames &&
           (st == GP_ERR_IO || st == GP_ERR_DATA || st == GP_ERR_USAGE);
}

static gp_status end_unit(void *user, int slot, int unit, gp_status st)
{
    struct pipeline *const p = user;
    struct unit *const u = &p->unit[slot];
    const bool skipped = st && can_skip(p, slot, st);
    gp_status reported = GP_OK;
    gp_frame_log_flush(&u->log);
    if (u->kept)
        p->failures.kept += p->jobs->views;
    if (skipped)
        gp_progress_fail(p->progress, p->jobs->views);
    for (int v = 0; v < u->begun && !reported && (!st || skipped); v++) {
        struct gp_frame_report *const facts = &u->view[v].facts;
        facts->job.warned = u->log.warned;
        facts->job.warned_bytes = u->log.warned_bytes;
        facts->job.status = st;
        facts->job.error = st ? u->log.last : NULL;
        if (!st) {
            if (facts->dark &&
                (!p->dark ||
                 facts->lib.sense.peak > p->brightest.lib.sense.peak))
                p->brightest = *facts;
            p->dark += facts->dark;
            gp_tally_add(&p->tally, facts);
            p->frames++;
        }
        if (st)
            gp_failures_add(&p->failures, unit * p->jobs->views + v);
        else if (p->log->level >= GP_LEVEL_INFO)
            gp_say_frame(p->log, facts);
        if (p->s.run.report)
            reported = gp_report_frame(p->log, &p->run.report, facts);
    }
    free_unit(u);
    return st && !skipped ? st : reported;
}

// -- frames in flight --------------------------------------------------------

enum { FLIGHT = 3 }; // one is read, one computed, one written

/* Memory that all units share, in parts of the largest one, until a frame
 * has a kernel: that of a frame full of light is up to twice as wide and high,
 * and so are its transforms. */
enum { UNKNOWN_SHARED = 4 };

/* Called under the lock of the flight. */
static bool has_room(void *user, int in_flight)
{
    struct pipeline *const p = user;
    struct gp_flight_memory m = {
        .limit = p->memory, .largest = atomic_load(&p->largest),
    };
    m.shared = atomic_load(&p->lit) ? atomic_load(&p->shared)
                                    : UNKNOWN_SHARED * m.largest;
    if (!p->asked->run.frame_jobs && !gp_flight_has_room(&m, in_flight))
        return false;
    if (in_flight + 1 > atomic_load(&p->most))
        atomic_store(&p->most, in_flight + 1);
    return true;
}

// -- all frames --------------------------------------------------------------

/* Makes what all frames share, so that errors of it come before any frame. */
static gp_status begin_run(const struct gp_log *log, struct glarepp *gp,
                           struct gp_run *r)
{
    const struct glarepp_kernel_params kernel = gp_kernel_params(r->s);
    struct gp_plan_settings plan;
    gp_status st;
    for (int i = 0; i < r->jobs->targets; i++)
        r->ordered = r->ordered ||
                     gp_file_descriptor(r->jobs->target[i].name.path) >= 0;
    GP_TRY((gp_status) glarepp_kernel(gp, &kernel, &r->kernel));
    gp_plan_params(r->s, r->kernel, &plan);
    GP_TRY((gp_status) glarepp_plan(gp, &plan.plan, &r->plan));
    // outputs must not replace pictures of --flare or tables of --ocio either
    const struct glarepp_plan_facts *const facts = glarepp_plan_facts(r->plan);
    if (facts->files)
        GP_TRY(gp_jobs_check_names(log, r->s, r->jobs, facts->file,
                                   facts->files));
    if (r->s->run.report)
        GP_TRY(gp_report_open(log, r->s->run.report,
                              r->s->output.write.create_dir, r->s->run.append,
                              &r->report));
out:
    return st;
}

gp_status gp_pipeline_run(const struct gp_log *log, struct glarepp *gp,
    const struct gp_settings *s, const struct gp_jobs *jobs,
    struct gp_progress *progress)
{
    gp_status st;
    char line[GP_LINE_BYTES];
    const int units = jobs->n / jobs->views;
    const double start = gp_now_ms();
    // a person reads: notes say the same in more words
    const bool person = progress->terminal && s->run.level == GP_LEVEL_WARN;
    const int most = s->run.frame_jobs ? s->run.frame_jobs
                     : gp_threads() > 1 ? FLIGHT : 1;
    struct pipeline p = {
        .log = log, .asked = s, .s = *s, .jobs = jobs, .progress = progress,
        .run = {.s = &p.s, .jobs = jobs,
                .details = person || s->run.level >= GP_LEVEL_INFO ||
                           s->run.report},
        .memory = gp_memory_limit(""),
        .most = 1,
        .slots = most < units ? most : units > 0 ? units : 1,
    };
    const struct gp_flight_work work = {
        .user = &p, .step = run_step, .goes_on = can_skip,
        .has_room = has_room, .end = end_unit,
    };
    // a frame with missing outputs writes all
    p.s.output.write.no_clobber = false;
    GP_TRY(make_schedule(log, &p.run, &p.schedule));
    for (int i = 0; i < GP_STAGES; i++) {
        if (gp_stages[i].gives == GP_HAS_LIT)
            p.run.layer_ends = p.schedule.dead[i] & GP_HAS_LAYER;
    }
    GP_TRY(begin_run(log, gp, &p.run));
    GP_TRY(gp_failures_make(log, jobs, &p.failures));
    GP_TRY(gp_alloc_zero(log, "frames in flight", (size_t) p.slots,
                         sizeof *p.unit, &p.unit));
    for (int i = 0; i < p.slots; i++)
        GP_TRY(gp_alloc_zero(log, "frames in flight", (size_t) jobs->views,
                             sizeof *p.unit[i].view, &p.unit[i].view));
    const struct gp_flight_params params = {
        .gp = gp, .units = units, .slots = p.slots, .ordered = p.run.ordered,
    };
    GP_TRY(gp_flight_run(&params, &work, &p.flight));
    gp_progress_end(progress);
    if (person && jobs->targets && p.tally.made && !jobs->taker) {
        gp_tally_text(&p.tally, s, jobs, (gp_now_ms() - start) * 1e-3, line,
                      sizeof line);
        gp_make_printable(line);
        gp_progress_say(progress, stderr, line);
    }
    // (a sequence may fade in: dark frames beside others are in the report)
    if (p.frames && p.dark == p.frames) {
        gp_frame_report_dark(&p.brightest, p.frames, line, sizeof line);
        gp_say(log, GP_LEVEL_WARN, "%s", line);
    }
    GP_TRY(gp_failures_report(log, &p.failures));
out:;
    const gp_status closed = gp_report_close(st ? NULL : log, &p.run.report);
    for (int i = 0; p.unit && i < p.slots; i++) {
        free_unit(&p.unit[i]);
        gp_free(p.unit[i].view);
    }
    gp_free(p.unit);
    gp_failures_free(&p.failures);
    glarepp_plan_end(&p.run.plan);
    glarepp_kernel_end(&p.run.kernel);
    return st ? st : closed;
}
