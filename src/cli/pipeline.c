// SPDX-License-Identifier: Apache-2.0
#include "cli/commands.h"

#include "cli/machine.h"
#include "cli/stages.h"
#include "cli/tracks.h"
#include "core/clock.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <limits.h>
#include <math.h>
#include <pthread.h>
#include <signal.h>

enum state {
    FREE,
    BUSY,      // a phase runs
    HAS_READ,  // waits to be computed
    COMPUTED,  // waits to be written
    DONE,      // written, or failed; waits to be ended
};

/* An input file in flight: one frame, or the views inside it. */
struct unit {
    enum state state;
    gp_status st;                // of its phases
    struct gp_frame_log log;
    struct gp_frame_state *view; // jobs->views of them, owned
    int begun;                   // of these
    bool kept;                   // skipped: all its outputs exist
    size_t bytes;                // that it takes; 0 before it is read
};

/* Several units are in flight: while one is computed, others are read and
 * written, so that no core waits for a file. Units are computed by the first
 * thread only, and computed and ended in order, so that shared state depends on
 * the units before, never on threads. */
struct pipeline {
    const struct gp_log *log;
    struct glarepp *gp;              // threads enter it; the caller is in it
    struct gp_progress *progress;
    bool on[GP_STAGES];              // the stage runs
    unsigned dead[GP_STAGES];        // data that no later stage needs
    struct gp_run run;
    int units, slots;
    size_t memory;                   // limit of the process; 0: unknown
    atomic_int head;                 // unit that is ended next
    atomic_int kept;                 // frames skipped, for the progress

    pthread_mutex_t lock;            // of all below
    pthread_cond_t changed;
    struct unit *unit;               // one a slot, owned; unit u has u % slots
    struct gp_own_plan *ended;       // of frames that are; owned
    int next_compute, next_read;
    int limit;                       // units from here on get no further phase
    gp_status result;                // of the unit that ended the run
    size_t largest;                  // bytes of the largest unit so far
    int dark;                        // frames written without sources
    struct gp_frame_report brightest; // of the dark frames
    struct gp_tally tally;           // of those written
    struct gp_tracks tracks;         // for --write-lights
};

/* Chooses the stages that the wanted files need, from the last to the first. */
static void make_schedule(struct pipeline *p)
{
    const struct gp_run *const r = &p->run;
    const struct gp_settings *const s = r->s;
    const bool lights = gp_lights_wanted(s);
    // data that nothing is asked of, so that it counts as present
    const unsigned unasked =
        (s->scene.path ? 0u : GP_HAS_SCENE) |
        (s->scene.path && s->sun.relight.n ? 0u : GP_HAS_RELIT) |
        (lights ? 0u : GP_HAS_SUNS | GP_HAS_SHARES) |
        (lights || s->sun.p.flare ? 0u : GP_HAS_FLARE) |
        (s->lens.lens ? 0u : GP_HAS_LENS);
    unsigned written = 0;
    for (int i = 0; i < r->jobs->targets; i++)
        written |= gp_target_needs(s, r->jobs->target[i].kind);
    const bool reports = s->run.report || s->run.level >= GP_LEVEL_INFO;
    unsigned wanted = (r->jobs->targets ? GP_HAS_FILES : 0u) | GP_HAS_END |
                      (reports ? GP_HAS_SHARES : 0u) |
                      (s->sun.write_lights ? GP_HAS_SOURCES : 0u) |
                      (s->run.verify ? GP_HAS_MEASURED : 0u);
    for (int i = GP_STAGES - 1; i >= 0; i--) {
        const struct gp_stage *const stage = &gp_stages[i];
        // (composing tells what the layer's flux is)
        const bool idle = stage->gives == GP_HAS_END &&
                          (!s->run.report || wanted & GP_HAS_LIT);
        p->on[i] = stage->gives & wanted & ~unasked;
        p->dead[i] = ~wanted;
        if (stage->gives == GP_HAS_LIT)
            p->run.layer_ends = p->dead[i] & GP_HAS_LAYER;
        if (p->on[i] && !idle)
            wanted |= stage->needs |
                      (stage->gives == GP_HAS_FILES ? written : 0u);
    }
}

// -- phases of a unit --------------------------------------------------------

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

/* Estimates the memory that a frame takes in flight, at most: the frame, its
 * layer, and sources and rows of transforms, or with --verify three planes of
 * doubles, or with a lens its steps of 1 to 16 pixels. */
static size_t frame_bytes(const struct pipeline *p,
                          const struct gp_frame_state *fs)
{
    // bytes of a pixel; of another kernel's layer, in double with --verify
    enum { USUAL = 49, VERIFY = 57, LENS = 65, MORE = 12, MORE_VERIFY = 24 };
    const size_t pixels = gp_frame_pixels(&fs->file);
    const size_t pixel = p->run.s->lens.lens      ? LENS
                         : p->run.s->run.verify ? VERIFY : USUAL;
    const bool lit = p->run.s->output.hdr.n && !p->run.s->light.source;
    const size_t group = (lit ? 6 : 3) * sizeof(float); // read, lit
    size_t bytes = pixels * pixel + carried_bytes(&fs->file);
    if (p->run.s->input.group_kernels.n)
        bytes += pixels * (p->run.s->run.verify ? MORE_VERIFY : MORE);
    for (int i = 0; i < fs->groups; i++)
        bytes += pixels * group + carried_bytes(&fs->group[i]);
    if (fs->source_mask.v)
        bytes += pixels * sizeof(float);
    return bytes;
}

/* Adds to the time of a stage, an enum gp_time; under 0 is none. */
static void add_cost(struct gp_cost_facts *c, int time, double ms, double cpu)
{
    if (time < 0)
        return;
    c->ms[time] = fmax(c->ms[time], 0.0) + ms;
    c->cpu_ms[time] = fmax(c->cpu_ms[time], 0.0) + cpu;
    c->ms[GP_TIME_TOTAL] = fmax(c->ms[GP_TIME_TOTAL], 0.0) + ms;
}

/* Runs a stage, and counts its time: of engines within it as glare. */
static gp_status run_stage(struct pipeline *p, const struct gp_stage *stage,
                           struct gp_frame_state *fs)
{
    struct gp_cost_facts *const cost = &fs->facts.cost;
    const double start = gp_now_ms(), cpu = gp_cpu_ms();
    double engines = 0.0, engines_cpu = 0.0;
    struct gp_run *const r = &p->run;
    // a lat-long has no axis for the flare or lens of a style
    if (fs->sphere && stage->gives & (GP_HAS_FLARE | GP_HAS_LENS) &&
        !gp_option_given(r->s, stage->name) &&
        gp_style_sets(r->s->light.style, stage->name)) {
        if (!r->warned_axis)
            gp_say(fs->log, GP_LEVEL_WARN,
                   "%s: a lat-long has no axis of a lens: style %s is without "
                   "its %s",
                   fs->job->input, r->s->light.style, stage->name);
        r->warned_axis = true;
        return GP_OK;
    }
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
            add_cost(cost, GP_TIME_KERNEL, lib->kernel.ms, lib->kernel.cpu_ms);
    }
    add_cost(cost, stage->time, gp_now_ms() - start - engines,
             gp_cpu_ms() - cpu - engines_cpu);
    if (engines > 0.0)
        add_cost(cost, GP_TIME_GLARE, engines, engines_cpu);
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
        if (!p->on[i] || phase != (i == 0 ? GP_PHASE_READ : i < GP_STAGES - 1
                                       ? GP_PHASE_COMPUTE : GP_PHASE_WRITE))
            continue;
        // skipped frames count neither as done nor in the total
        const int kept = atomic_load(&p->kept);
        gp_progress_update(p->progress,
                           atomic_load(&p->head) * p->run.jobs->views - kept,
                           p->run.jobs->n - kept, fs->job->input, stage->name);
        st = run_stage(p, stage, fs);
        if (!st)
            gp_frame_state_release(fs, p->dead[i]);
    }
    if (st && fs->frame) // the next frame needs what the plan lent
        (void) glarepp_frame_run(fs->frame, GLAREPP_DONE);
    return st;
}

static gp_status run_phase(struct pipeline *p, int unit, enum gp_phase phase)
{
    struct unit *const u = &p->unit[unit % p->slots];
    const int views = p->run.jobs->views, first = unit * views;
    const struct gp_job *const job = &p->run.jobs->job[first];
    gp_status st = GP_OK;
    if (phase == GP_PHASE_READ) {
        gp_frame_log_open(&u->log, p->log, &p->head, unit, job->input);
        u->kept = true;
        for (int v = 0; v < views && u->kept; v++)
            u->kept = gp_job_complete(&u->log.log, &p->run.s->output.write,
                                      p->run.jobs, &job[v]);
        if (u->kept)
            atomic_fetch_add(&p->kept, views);
        for (u->begun = 0; u->begun < views && !u->kept && !st; u->begun++)
            st = gp_frame_state_begin(&u->log.log, &p->run, first + u->begun,
                                      &u->view[u->begun]);
    }
    for (int v = 0; v < u->begun && !st; v++) {
        struct gp_cost_facts *const cost = &u->view[v].facts.cost;
        st = run_view(p, &u->view[v], phase);
        if (phase == GP_PHASE_READ)
            u->bytes += cost->bytes = frame_bytes(p, &u->view[v]);
    }
    return st;
}

// -- the end of a unit -------------------------------------------------------

static void free_unit(struct pipeline *p, struct unit *u)
{
    while (u->begun > 0) {
        struct gp_own_plan *const own = u->view[--u->begun].own;
        gp_frame_state_end(&u->view[u->begun]);
        if (own) {
            own->next = p->ended;
            p->ended = own;
        }
    }
    gp_frame_log_close(&u->log);
    *u = (struct unit) {.view = u->view};
}

/* True for errors that may be of one frame only; a lost context, a full memory
 * or a closed stdout would fail the others too. */
static bool can_skip(const struct pipeline *p, const struct unit *u,
                     gp_status st)
{
    for (int v = 0; v < u->begun && st == GP_ERR_IO; v++) {
        const struct gp_frame_state *const fs = &u->view[v];
        const char *const writing = fs->facts.write.file[fs->facts.write.n].name;
        if (writing && gp_is_dash(writing))
            return false;
    }
    return p->run.s->input.skip_bad_frames &&
           (st == GP_ERR_IO || st == GP_ERR_DATA || st == GP_ERR_USAGE);
}

/* Reports the unit that is next; an error ends the run. */
static gp_status end_unit(struct pipeline *p, struct unit *u)
{
    const gp_status st = u->st;
    const bool skipped = st && can_skip(p, u, st);
    const int first = atomic_load(&p->head) * p->run.jobs->views;
    gp_status reported = GP_OK;
    gp_frame_log_flush(&u->log);
    if (skipped)
        gp_progress_fail(p->progress, p->run.jobs->views);
    for (int v = 0; v < u->begun && !reported && (!st || skipped); v++) {
        struct gp_frame_report *const facts = &u->view[v].facts;
        facts->job.said = u->log.text;
        facts->job.said_bytes = u->log.bytes;
        facts->job.status = st;
        facts->job.error = st ? gp_frame_log_error(&u->log) : NULL;
        if (!st) {
            if (facts->dark &&
                (!p->dark ||
                 facts->lib.sense.peak > p->brightest.lib.sense.peak))
                p->brightest = *facts;
            p->dark += facts->dark;
            gp_tally_add(&p->tally, facts);
        }
        if (st)
            p->run.jobs->job[first + v].failed = true;
        else if (p->log->level >= GP_LEVEL_INFO)
            gp_say_frame(p->log, facts);
        if (p->run.s->run.report)
            reported = gp_report_frame(p->log, p->run.report, facts);
        if (!st && !reported && v == 0 && p->run.s->sun.write_lights)
            reported = gp_tracks_add(
                p->log, &p->tracks, &facts->lib,
                facts->job.of.numbered ? facts->job.of.frame : first,
                facts->read.height);
    }
    free_unit(p, u);
    return st && !skipped ? st : reported;
}

// -- units in flight, under the lock ------------------------------------------

enum { FLIGHT = 3 }; // one is read, one computed, one written

/* Memory that all units share, or with keys each has, the kernel and its transforms,
 * in parts of the largest unit, at most: that of a frame full of light is up to twice
 * as wide and high. */
enum { SHARED = 2 };

/* Chooses the next phase of a thread; false when there is none. Writing comes
 * before reading: it frees what the unit holds. */
static bool pick_phase(struct pipeline *p, bool first_thread, int *unit,
                       enum gp_phase *phase)
{
    const int head = atomic_load(&p->head), in_flight = p->next_read - head;
    // pass units that failed
    while (first_thread &&
           (p->next_compute < head ||
            (p->next_compute < p->next_read &&
             p->unit[p->next_compute % p->slots].state == DONE)))
        p->next_compute++;
    if (first_thread && p->next_compute < p->next_read &&
        p->next_compute < p->limit &&
        p->unit[p->next_compute % p->slots].state == HAS_READ) {
        *phase = GP_PHASE_COMPUTE;
        *unit = p->next_compute++;
        return true;
    }
    const int end = p->run.ordered ? head + 1 : p->next_compute;
    for (int u = head; u < end && u < p->next_compute; u++) {
        if (u < p->limit && p->unit[u % p->slots].state == COMPUTED) {
            *phase = GP_PHASE_WRITE;
            *unit = u;
            return true;
        }
    }
    // all units and what they share take half of the memory at most, each as much as
    // the largest so far; the first is read by itself, as nothing is known before
    const int shared = p->run.s->keyeds ? SHARED * (in_flight + 1) : SHARED;
    const bool room =
        in_flight == 0 || p->run.s->run.frame_jobs || !p->memory ||
        (p->largest > 0 &&
         p->largest < p->memory / 2 / (size_t) (in_flight + 1 + shared));
    if (p->next_read >= p->units || p->next_read >= p->limit ||
        in_flight >= p->slots || !room)
        return false;
    *phase = GP_PHASE_READ;
    *unit = p->next_read++;
    return true;
}

static bool is_over(const struct pipeline *p)
{
    return p->result || atomic_load(&p->head) >= p->units;
}

// -- threads -----------------------------------------------------------------

/* Runs phases until all units are ended. */
static void run_phases(struct pipeline *p, bool first_thread)
{
    static const enum state next[] = {
        [GP_PHASE_READ] = HAS_READ, [GP_PHASE_COMPUTE] = COMPUTED,
        [GP_PHASE_WRITE] = DONE,
    };
    int unit;
    enum gp_phase phase;
    pthread_mutex_lock(&p->lock);
    while (!is_over(p)) {
        struct gp_own_plan *ended = first_thread ? p->ended : NULL;
        if (ended) {
            p->ended = NULL;
            pthread_mutex_unlock(&p->lock);
            gp_own_plans_end(&ended);
            pthread_mutex_lock(&p->lock);
            continue;
        }
        if (!pick_phase(p, first_thread, &unit, &phase)) {
            glarepp_leave(p->gp); // another may work while this one waits
            pthread_cond_wait(&p->changed, &p->lock);
            pthread_mutex_unlock(&p->lock);
            glarepp_enter(p->gp);
            pthread_mutex_lock(&p->lock);
            continue;
        }
        struct unit *const u = &p->unit[unit % p->slots];
        u->state = BUSY;
        pthread_mutex_unlock(&p->lock);
        u->st = run_phase(p, unit, phase);
        pthread_mutex_lock(&p->lock);
        p->largest = u->bytes > p->largest ? u->bytes : p->largest;
        u->state = u->st ? DONE : next[phase];
        if (u->st && unit < p->limit && !can_skip(p, u, u->st))
            p->limit = unit;
        // end finished units, in order
        struct unit *done;
        while (!is_over(p) &&
               (done = &p->unit[p->head % p->slots])->state == DONE) {
            p->result = end_unit(p, done);
            atomic_fetch_add(&p->head, p->result == GP_OK);
        }
        pthread_cond_broadcast(&p->changed);
    }
    pthread_mutex_unlock(&p->lock);
}

static void *run_thread(void *arg)
{
    struct pipeline *const p = arg;
    glarepp_enter(p->gp);
    run_phases(p, false);
    glarepp_leave(p->gp);
    return NULL;
}

/* Makes all units, on this thread and, for more than one slot, on up to
 * gp_threads() - 1 others beside; fewer threads are no error. */
static gp_status run_units(struct pipeline *p)
{
    pthread_t id[GP_FRAME_JOBS];
    const int threads = p->slots < gp_threads() ? p->slots : gp_threads();
    sigset_t all, before;
    int started = 0;
    // signals are for the first thread
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    while (started < threads - 1 &&
           pthread_create(&id[started], NULL, run_thread, p) == 0)
        started++;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    run_phases(p, true);
    glarepp_leave(p->gp); // the other threads may still run a phase
    for (int i = 0; i < started; i++)
        pthread_join(id[i], NULL);
    glarepp_enter(p->gp);
    return p->result;
}

// -- all frames --------------------------------------------------------------

/* Makes what all frames share, so that errors of it come before any frame. */
static gp_status begin_run(const struct gp_log *log, struct gp_run *r)
{
    struct glarepp *const gp = r->gp;
    const struct gp_texts *const words = &r->s->input.group_kernels;
    struct glarepp_plan_params plan = r->s->plan;
    int frame;
    gp_status st;
    for (int i = 0; i < r->jobs->n && r->s->keyeds; i++) {
        if (!gp_job_number(&r->jobs->job[i], &frame))
            return gp_fail(log, GP_ERR_USAGE,
                           "%s: no frame number in this input (--%s has keys); "
                           "add one to its name, or give one value",
                           r->jobs->job[i].input, r->s->keyed[0].option->name);
    }
    for (int i = 0; i < r->jobs->targets; i++)
        r->ordered = r->ordered ||
                     gp_file_descriptor(r->jobs->target[i].name.path) >= 0;
    GP_TRY((gp_status) glarepp_kernel(gp, &r->s->kernel.p, &r->kernel));
    plan.kernel = r->kernel;
    GP_TRY(gp_alloc_zero(log, "kernels", (size_t) words->n + 1, sizeof *r->more,
                         &r->more));
    for (int i = 0; i < words->n; i++) {
        struct glarepp_kernel_params p = GLAREPP_KERNEL_PARAMS;
        p.word = &words->at[i];
        p.words = 1;
        GP_TRY(glarepp_kernel(gp, &p, &r->more[i]));
    }
    plan.more = (const struct glarepp_kernel *const *) r->more;
    plan.mores = words->n;
    GP_TRY((gp_status) glarepp_plan(gp, &plan, &r->plan));
    // outputs must not replace pictures of --flare or tables of --ocio either
    const struct glarepp_plan_facts *const facts = glarepp_plan_facts(r->plan);
    if (facts->files)
        GP_TRY(gp_jobs_check_names(log, r->s, r->jobs, facts->file,
                                   facts->files));
    if (r->s->run.report && !r->jobs->taker)
        GP_TRY(gp_report_open(log, r->s->run.report,
                              r->s->output.write.create_dir, r->report));
out:
    return st;
}

gp_status gp_pipeline_run(const struct gp_log *log, struct glarepp *gp,
    const struct gp_settings *s, const struct gp_jobs *jobs,
    struct gp_progress *progress)
{
    gp_status st;
    char line[GP_LINE_BYTES] = "";
    struct gp_report own = {0};
    const int units = jobs->n / jobs->views;
    const double start = gp_now_ms();
    // a person reads: notes say the same in more words
    const bool person = progress->terminal && s->run.level == GP_LEVEL_WARN;
    const int most = s->run.frame_jobs ? s->run.frame_jobs
                     : gp_threads() > 1 ? FLIGHT : 1;
    struct pipeline p = {
        .log = log,
        .gp = gp,
        .progress = progress,
        .run = {.s = s,
                .jobs = jobs,
                .gp = gp,
                .report = jobs->taker ? jobs->taker->report : &own,
                .details =
                    person || s->run.level >= GP_LEVEL_INFO || s->run.report},
        .units = units,
        .slots = most < units ? most
                 : units > 0  ? units
                              : 1,
        .memory = gp_memory_limit(""),
        .limit = INT_MAX,
        .lock = PTHREAD_MUTEX_INITIALIZER,
        .changed = PTHREAD_COND_INITIALIZER,
    };
    make_schedule(&p);
    GP_TRY(begin_run(log, &p.run));
    GP_TRY(gp_alloc_zero(log, "frames in flight", (size_t) p.slots,
                         sizeof *p.unit, &p.unit));
    for (int i = 0; i < p.slots; i++)
        GP_TRY(gp_alloc_zero(log, "frames in flight", (size_t) jobs->views,
                             sizeof *p.unit[i].view, &p.unit[i].view));
    GP_TRY(run_units(&p));
    gp_progress_end(progress);
    FILE *const told =
        person && jobs->targets && p.tally.made && !jobs->taker
            ? fmemopen(line, sizeof line - 1, "w") : NULL;
    if (told) {
        gp_tally_print(told, &p.tally, s, jobs, (gp_now_ms() - start) * 1e-3);
        fclose(told);
        gp_make_printable(line);
        gp_progress_say(progress, stderr, line);
    }
    // (a sequence may fade in: dark frames beside others are in the report)
    if (p.dark && p.dark == p.tally.made) {
        gp_frame_report_dark(&p.brightest, p.dark, line, sizeof line);
        gp_say(log, GP_LEVEL_WARN, "%s", line);
    }
    if (s->sun.write_lights && p.tracks.n)
        GP_TRY(gp_tracks_write(log, &p.tracks, s->sun.write_lights));
    else if (s->sun.write_lights)
        gp_say(log, GP_LEVEL_WARN,
               "%s: not written: no frame has a light; lower --threshold",
               s->sun.write_lights);
    GP_TRY(gp_failures_report(log, jobs, atomic_load(&p.kept)));
out:;
    const gp_status closed = gp_report_close(st ? NULL : log, &own);
    for (int i = 0; p.unit && i < p.slots; i++) {
        free_unit(&p, &p.unit[i]);
        gp_free(p.unit[i].view);
    }
    gp_free(p.unit);
    gp_own_plans_end(&p.ended);
    gp_tracks_free(&p.tracks);
    glarepp_plan_end(&p.run.plan);
    glarepp_kernel_end(&p.run.kernel);
    for (int i = 0; p.run.more && i < s->input.group_kernels.n; i++)
        glarepp_kernel_end(&p.run.more[i]);
    gp_free(p.run.more);
    return st ? st : closed;
}
