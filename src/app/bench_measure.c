#include "app/bench_measure.h"

#include "core/clock.h"
#include "core/memory.h"
#include "compare/flip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double LONG_MS = 6e3;  // a run over this is extrapolated
static const double PART_MS = 10e3; // a tenth over this is made a hundredth
static const double ROW_MS = 15e3;  // no further run is started after this

/* A frame, and what every row of it is compared with. */
struct bench {
    const struct gp_bench_job *job;
    struct gp_frame *f;
    struct gp_sources src;
    double *exact;           // the layer, 3 * w * h
    struct gp_planes shown;  // exact composite, tone mapped; empty: no FLIP
};

/* One technique on the frame. */
struct trial {
    const struct bench *b;
    struct gp_glare_params params;
    const struct gp_engine *engine; // NULL for auto
    struct gp_glare glare;
    struct gp_log log;              // errors of GL go into row->why
    struct gp_bench_row *row;
    double *ms;                     // of the runs
};

// -- runs ------------------------------------------------------------------------

static void keep_line(void *user, enum gp_level level, const char *line)
{
    struct gp_bench_row *const row = user;
    if (level == GP_LEVEL_ERROR || level == GP_LEVEL_BARE)
        snprintf(row->why, sizeof row->why, "%s", line);
}

/* A run's times, and the sources it had. */
struct run {
    double sense_ms, glare_ms;
    size_t sources;
};

static double whole_ms(const struct run *r)
{
    return r->sense_ms + r->glare_ms;
}

static gp_status run_once(struct trial *t, struct gp_frame *f, struct run *r)
{
    struct gp_sources src = {0};
    const double start = gp_now_ms();
    gp_status st = gp_sense(&t->log, &t->b->job->s->sensor, f, &src);
    const double middle = gp_now_ms();
    if (!st)
        st = gp_glare_run(&t->log, &t->params, &t->glare, &src,
                          t->b->job->kernel, f, &t->row->stats);
    *r = (struct run) {middle - start, gp_now_ms() - middle, src.n};
    gp_sources_free(&src);
    return st;
}

static int by_value(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

/* Of n values in ascending order. */
static double median(const double *v, int n)
{
    return n % 2 ? v[n / 2] : 0.5 * (v[n / 2 - 1] + v[n / 2]);
}

static gp_status run_whole(struct trial *t)
{
    struct gp_bench_row *const row = t->row;
    struct run r;
    gp_status st = run_once(t, t->b->f, &r);
    double total = row->ms_first = t->ms[0] = whole_ms(&r);
    int n = 0;
    while (!st && n < t->b->job->s->bench.runs && total < ROW_MS) {
        st = run_once(t, t->b->f, &r);
        total += t->ms[n++] = whole_ms(&r);
    }
    if (st)
        return st;
    row->runs = n > 0 ? n : 1; // the first took so long that it is the only one
    qsort(t->ms, (size_t) row->runs, sizeof *t->ms, by_value);
    row->ms = median(t->ms, row->runs);
    row->ms_min = t->ms[0];
    row->ms_max = t->ms[row->runs - 1];
    row->polygons = (double) row->stats.polygons;
    row->polygon_pixels = row->stats.polygon_pixels;
    row->bound = row->stats.bound;
    return GP_OK;
}

// -- extrapolation ------------------------------------------------------------------

/* Work that grows with each source, on top of what a single one costs. */
static double extrapolated_ms(const struct run *part, const struct run *single,
                              double share)
{
    const double base = single->glare_ms < part->glare_ms ? single->glare_ms
                                                          : 0.0;
    return part->sense_ms + base + (part->glare_ms - base) / share;
}

/* Runs a part of the sources twice, and one source alone. */
static gp_status run_part(struct trial *t, int parts)
{
    gp_status st;
    struct gp_bench_row *const row = t->row;
    const struct bench *const b = t->b;
    struct gp_frame part = {0}, single = {0};
    struct run first, warm, least;
    GP_TRY(gp_bench_part(&t->log, b->f, &b->src, parts, &part));
    GP_TRY(gp_bench_part(&t->log, b->f, &b->src, 0, &single));
    GP_TRY(run_once(t, &single, &first)); // makes the state
    GP_TRY(run_once(t, &single, &least));
    GP_TRY(run_once(t, &part, &warm));
    row->share = (double) warm.sources / (double) b->src.n;
    if (warm.sources == 0)
        goto out;
    row->extrapolated = true;
    row->runs = 1;
    row->ms = extrapolated_ms(&warm, &least, row->share);
    row->ms_min = row->ms_max = row->ms;
    const double start = whole_ms(&first) - whole_ms(&least);
    row->ms_first = row->ms + (start > 0.0 ? start : 0.0);
    row->polygons = (double) row->stats.polygons / row->share;
    row->polygon_pixels = row->stats.polygon_pixels / row->share;
out:
    gp_frame_free(&part);
    gp_frame_free(&single);
    return st;
}

/* The whole frame's bound, where the engine has one without a run. */
static gp_status ask_bound(struct trial *t)
{
    const struct bench *const b = t->b;
    struct gp_glare_stats stats = {0};
    const struct gp_glare_job job = {
        .log = &t->log, .params = &t->params, .src = &b->src,
        .kernel = b->job->kernel, .layer = &b->f->layer, .stats = &stats,
    };
    int i = 0;
    t->row->bound = NAN;
    if (!t->engine || !t->engine->bound)
        return GP_OK;
    while (gp_engines[i] != t->engine)
        i++;
    return t->engine->bound(&job, &t->glare.state[i], &t->row->bound);
}

/* What the engine expects of itself; 0 for auto and for fft, whose work does
 * not grow with the sources. */
static double predict(const struct trial *t)
{
    const struct bench *const b = t->b;
    struct gp_glare_stats stats = {0};
    const struct gp_glare_job job = {
        .log = &t->log, .params = &t->params, .src = &b->src,
        .kernel = b->job->kernel, .layer = &b->f->layer, .stats = &stats,
    };
    if (!t->engine || t->engine == &gp_engine_fft)
        return 0.0;
    return t->engine->predict(&job, NULL).ms;
}

/* Whole runs, or a part when those would take too long. */
static gp_status time_row(struct trial *t)
{
    const double expected = predict(t);
    gp_status st = GP_OK;
    if (expected > LONG_MS)
        st = run_part(t, expected > 10.0 * PART_MS ? 100 : 10);
    if (st || (t->row->extrapolated && t->row->ms > LONG_MS))
        return st ? st : ask_bound(t);
    t->row->extrapolated = false; // it takes less than was expected
    return run_whole(t);
}

// -- errors ------------------------------------------------------------------------

/* Composes and tone maps what f->layer holds. */
static gp_status show(const struct bench *b)
{
    gp_status st = gp_compose(b->job->log, &b->job->s->compose, &b->src, b->f);
    return st ? st : gp_tone_map(b->job->log, &b->job->s->tone, b->f, NULL);
}

static gp_status measure_row(const struct trial *t)
{
    const struct bench *const b = t->b;
    struct gp_bench_row *const row = t->row;
    gp_glare_measure(b->f, &b->f->layer, b->exact, b->job->s->compose.gain,
                     &row->error);
    row->measured = true;
    if (!b->shown.c[0])
        return GP_OK;
    gp_status st = show(b);
    return st ? st : gp_flip_ldr(b->job->log, gp_frame_w(b->f),
                                 gp_frame_h(b->f), &b->shown, &b->f->shown,
                                 GP_FLIP_PPD, NULL, &row->flip);
}

/* A technique that cannot run here is a row, not an error of bench. */
static bool is_refusal(gp_status st)
{
    return st == GP_ERR_GL || st == GP_ERR_USAGE;
}

static gp_status run_technique(const struct bench *b, double *ms,
                               const struct gp_bench_technique *technique,
                               struct gp_bench_row *row)
{
    const struct gp_settings *const s = b->job->s;
    struct trial t = {
        .b = b, .params = s->glare, .row = row, .ms = ms,
        .log = {keep_line, row, GP_LEVEL_ERROR},
    };
    t.params.engine = technique->engine;
    t.params.splat = technique->splat;
    for (int i = 0; gp_engines[i]; i++) {
        if (strcmp(gp_engines[i]->name, technique->engine) == 0)
            t.engine = gp_engines[i];
    }
    gp_status st = time_row(&t);
    if (!st && !row->extrapolated)
        st = measure_row(&t);
    // the renderer's name goes with its context
    snprintf(row->gl, sizeof row->gl, "%s", row->stats.gl ? row->stats.gl : "");
    row->stats.gl = row->gl;
    gp_glare_close(&t.glare);
    if (!st)
        row->why[0] = '\0'; // of a context that another stood in for
    else if (!row->why[0])
        snprintf(row->why, sizeof row->why, "%s", gp_status_text(st));
    if (!st || is_refusal(st))
        return GP_OK;
    return gp_fail(b->job->log, st, "%s: %s", row->name, row->why);
}

static void say_row(const struct gp_log *log, const struct gp_bench_row *row)
{
    if (row->why[0])
        gp_say(log, GP_LEVEL_INFO, "%s: cannot run: %s", row->name, row->why);
    else if (row->extrapolated)
        gp_say(log, GP_LEVEL_INFO, "%s: %.3g ms, extrapolated", row->name,
               row->ms);
    else
        gp_say(log, GP_LEVEL_INFO, "%s: %.3g ms, rel_l2 %.3g", row->name,
               row->ms, row->error.rel_l2);
}

// -- the frame ---------------------------------------------------------------------

/* The exact layer, and what its composite looks like. */
static gp_status make_truth(struct bench *b)
{
    const struct gp_bench_job *const job = b->job;
    const size_t n = gp_frame_pixels(b->f);
    void *block;
    gp_status st = gp_alloc(job->log, "exact layer", 3 * n, sizeof(double),
                            &block);
    if (st)
        return st;
    b->exact = block;
    GP_TRY(gp_glare_reference(job->log, &b->src, job->kernel, b->exact));
    GP_TRY(gp_planes_make(job->log, "layer", n, &b->f->layer));
    if (strcmp(job->s->tone.curve, "none") == 0)
        return GP_OK; // light itself: no picture that FLIP could judge
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++)
            b->f->layer.c[c][i] = (float) b->exact[(size_t) c * n + i];
    }
    GP_TRY(show(b));
    b->shown = b->f->shown;
    b->f->shown = (struct gp_planes) {0};
out:
    return st;
}

static void start_row(const struct bench *b,
                      const struct gp_bench_technique *technique,
                      struct gp_bench_row *row)
{
    *row = (struct gp_bench_row) {
        .name = technique->name, .share = 1.0, .bound = NAN, .flip = NAN,
    };
    gp_bench_options(technique, b->job->s->glare.tolerance, row->options,
                     sizeof row->options);
}

gp_status gp_bench_measure(const struct gp_bench_job *job, struct gp_frame *f,
                           struct gp_bench_frame *out)
{
    gp_status st;
    struct bench b = {.job = job, .f = f};
    void *ms = NULL;
    GP_TRY(gp_alloc(job->log, "times", (size_t) job->s->bench.runs,
                    sizeof(double), &ms));
    GP_TRY(gp_sense(job->log, &job->s->sensor, f, &b.src));
    out->width = gp_frame_w(f);
    out->height = gp_frame_h(f);
    out->sources = (long long) b.src.n;
    if (b.src.n > 0)
        GP_TRY(make_truth(&b));
    for (out->rows = 0; gp_bench_techniques[out->rows].name; out->rows++) {
        struct gp_bench_row *const row = &out->row[out->rows];
        start_row(&b, &gp_bench_techniques[out->rows], row);
        if (b.src.n == 0)
            snprintf(row->why, sizeof row->why,
                     "no pixel is over the threshold");
        else
            GP_TRY(run_technique(&b, ms, &gp_bench_techniques[out->rows],
                                 row));
        say_row(job->log, row);
    }
    gp_bench_mark_pareto(out);
out:
    gp_sources_free(&b.src);
    gp_free(b.exact);
    gp_free(ms);
    gp_planes_free(&b.shown);
    return st;
}
