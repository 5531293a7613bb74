// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_priv.h"

#include "core/clock.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double LONG_MS = 6e3;  // a run over this is extrapolated
static const double ROW_MS = 15e3;  // no further run is started after this
enum { MANY = 20000 };              // sources from which direct is thinned
static const double PAIRS = 6e7;    // most by true angles; one takes 0.1 us

struct trial {
    struct gp_bench *b;
    struct glarepp_plan *plan;
    struct gp_log log;           // errors of GL go into row->why
    struct gp_bench_row *row;
    gp_status st;                // of the runs
    const struct trial *same;    // an earlier one that computes the same
    struct gp_bench_times times; // of turns; the total has the first run, too
};

/* A run's time of bright pass and glare, and the sources it had. */
struct run {
    double ms;
    long long sources;
};

/* A plan by a technique; edges are black: the table is of a kernel's sum. */
static gp_status make_plan(const struct gp_bench *b,
                           const struct gp_bench_technique *t,
                           struct glarepp_plan **out)
{
    struct glarepp_plan_params p = *b->req->plan;
    struct glarepp_layer_params layer = *p.layer;
    layer.edges = GLAREPP_BLACK;
    if (!b->angles || (t && !t->follows))
        p.projection = GLAREPP_PLANE;
    if (!t)
        layer.tolerance = fminf(layer.tolerance, 1e-6f); // what FLIP is against
    if (t) {
        if (t->tolerance > 0.0f)
            layer.tolerance = t->tolerance;
        layer.engine = t->engine;
        layer.group = t->group;
        layer.cluster = t->cluster;
        layer.shrink = t->shrink;
    }
    p.layer = &layer;
    p.kernel = b->kernel;
    p.lights = NULL;
    p.lens = NULL;
    p.scene = NULL;
    return (gp_status) glarepp_plan(b->req->gp, &p, out);
}

/* Runs sensors and glare; *out is the frame after them. */
static gp_status run_once(struct trial *t, const struct gp_frame *f,
                          struct run *r, struct glarepp_frame **out)
{
    struct glarepp_frame_params p = t->b->params;
    struct glarepp_frame *frame = NULL;
    gp_status st;
    p.image = gp_frame_view(f, &f->rgb);
    p.user = &t->log;
    GP_TRY(glarepp_frame(t->plan, &p, &frame));
    const double start = gp_now_ms();
    GP_TRY(glarepp_frame_run(frame, GLAREPP_SENSE));
    const double middle = gp_now_ms();
    GP_TRY(glarepp_frame_run(frame, GLAREPP_KERNEL));
    const double made = gp_now_ms();
    GP_TRY(glarepp_frame_run(frame, GLAREPP_LAYER));
    const double end = gp_now_ms();
    const struct glarepp_facts *const facts = glarepp_frame_facts(frame);
    *r = (struct run) {middle - start + end - made, facts->sense.sources};
    t->row->facts = facts->layer;
    GP_TRY(glarepp_frame_run(frame, GLAREPP_DONE));
    if (out) {
        *out = frame;
        frame = NULL;
    }
out:
    glarepp_frame_end(&frame);
    return st;
}

// -- extrapolation -----------------------------------------------------------

enum { BLOCK = 32 }; // no group or cluster of bench's is cut by one

gp_status gp_bench_thin(const struct gp_log *log, const struct gp_frame *f,
                        int nth, struct gp_frame *out)
{
    const size_t n = gp_frame_pixels(f), w = (size_t) gp_frame_w(f);
    struct gp_frame thin = gp_frame_blank(f->data);
    thin.display = f->display;
    memcpy(thin.luminance, f->luminance, sizeof thin.luminance);
    memcpy(thin.chromaticities, f->chromaticities, sizeof thin.chromaticities);
    thin.names_chromaticities = f->names_chromaticities;
    gp_status st = gp_planes_make(log, "part of the frame", n, &thin.rgb);
    if (st)
        return st;
    // Rows of blocks start 3 blocks further than the one before, 37 for
    // hundredths, so that the chosen ones make no columns
    const size_t step = nth > 10 ? 37 : 3;
    for (int c = 0; c < 3; c++) {
        float *const to = thin.rgb.c[c];
        const float *const from = f->rgb.c[c];
        memset(to, 0, n * sizeof *to);
        for (size_t at = 0; at < n;) {
            const size_t x = at % w, y = at / w;
            const size_t run = w - x < BLOCK ? w - x : BLOCK;
            if ((x / BLOCK + y / BLOCK * step) % (size_t) nth == 0)
                memcpy(to + at, from + at, run * sizeof *to);
            at += run;
        }
    }
    *out = thin;
    return GP_OK;
}

double gp_bench_whole_ms(const double share[2], const double ms[2])
{
    const double each = (ms[1] - ms[0]) / (share[1] - share[0]);
    return ms[1] + fmax(each, 0.0) * (1.0 - share[1]);
}

/* Runs one of `nth` blocks of the frame three times; *least is the fastest run but
 * the first, whose sources are *share of all. */
static gp_status run_part(struct trial *t, int nth, struct run *first,
                          struct run *least, double *share)
{
    gp_status st;
    struct gp_frame thin = {0};
    struct run r;
    GP_TRY(gp_bench_thin(&t->log, t->b->f, nth, &thin));
    GP_TRY(run_once(t, &thin, first, NULL));
    GP_TRY(run_once(t, &thin, least, NULL));
    if (least->ms < LONG_MS) {
        GP_TRY(run_once(t, &thin, &r, NULL));
        *least = r.ms < least->ms ? r : *least;
    }
    *share = (double) least->sources / (double) t->b->sense.sources;
out:
    gp_frame_free(&thin);
    return st;
}

/* Runs two parts of the sources, as what a run takes whatever they are would count
 * ten times or a hundred. */
static gp_status run_thinned(struct trial *t, int nth)
{
    gp_status st;
    struct gp_bench_row *const row = t->row;
    struct run first, later, part[2];
    double share[2];
    GP_TRY(run_part(t, 10 * nth, &first, &part[0], &share[0]));
    GP_TRY(run_part(t, nth, &later, &part[1], &share[1]));
    if (!(share[1] > share[0]))
        goto out;
    const double ms[2] = {part[0].ms, part[1].ms};
    const double all = gp_bench_whole_ms(share, ms);
    const double part_of = row->facts.polygons ? share[1] : (double) NAN;
    row->share = share[1];
    row->took = (struct gp_bench_took) {
        all, all, all, all + fmax(first.ms - part[0].ms, 0.0), 1};
    row->polygons = (double) row->facts.polygons / part_of;
    row->polygon_pixels = row->facts.polygon_pixels / part_of;
out:
    return st;
}

/* The first run, or thinned ones; *out is the frame of a whole one. */
static gp_status run_first(struct trial *t, const char *engine,
                           struct glarepp_frame **out)
{
    const struct gp_bench *const b = t->b;
    struct gp_bench_row *const row = t->row;
    const long long sources = b->sense.sources;
    // auto chooses what is fast; the work of fft does not grow with the sources
    const bool grows =
        strcmp(engine, "direct") == 0 || strcmp(engine, "splat") == 0;
    gp_status st = GP_OK;
    if (grows && sources > MANY)
        st = run_thinned(t, sources > 10 * MANY ? 100 : 10);
    if (st || (!isnan(row->share) && row->took.ms > LONG_MS))
        return st;
    row->share = NAN; // faster than that
    struct run r;
    st = run_once(t, b->f, &r, out);
    t->times.total = row->took.first = r.ms;
    return st;
}

static bool has_turn(const struct trial *t)
{
    return !t->st && !t->same && isnan(t->row->share) &&
           t->times.total < ROW_MS && t->times.n < t->b->req->params->runs;
}

/* Runs a trial once more; one that has no further turn gives back its memory. */
static void take_turn(struct trial *t)
{
    struct run r;
    if (has_turn(t)) {
        t->st = run_once(t, t->b->f, &r, NULL);
        gp_bench_time(&t->times, r.ms);
    }
    if (!has_turn(t))
        glarepp_plan_end(&t->plan);
}

// -- errors -------------------------------------------------------------------

/* Composes and tone maps a frame; *out has its picture, borrowed. */
static gp_status show(struct glarepp_frame *frame, struct glarepp_image *out)
{
    gp_status st;
    GP_TRY(glarepp_frame_run(frame, GLAREPP_COMPOSE));
    GP_TRY(glarepp_frame_run(frame, GLAREPP_TONE));
    GP_TRY(glarepp_frame_run(frame, GLAREPP_DONE));
    GP_TRY(glarepp_frame_view(frame, GLAREPP_SHOWN, 0, out));
out:
    return st;
}

static gp_status measure_error(const struct gp_bench *b,
                               struct glarepp_frame *frame,
                               struct gp_bench_row *row)
{
    const bool page = b->req->params->page != NULL;
    struct glarepp_image layer, picture, exact, map = GLAREPP_IMAGE;
    struct glarepp_compare_facts facts;
    gp_status st;
    GP_TRY(glarepp_frame_view(frame, GLAREPP_GLARE, 0, &layer));
    GP_TRY(glarepp_frame_set(b->truth, GLAREPP_GLARE, &layer));
    GP_TRY(glarepp_frame_run(b->truth, GLAREPP_VERIFY));
    const struct glarepp_errors *const e =
        &glarepp_frame_facts(b->truth)->errors;
    row->error[GP_REL_L2] = e->rel_l2;
    row->error[GP_MAX_REL] = e->max_rel;
    row->max_abs = e->max_abs;
    if (b->shown.c[0]) {
        GP_TRY(show(frame, &picture));
        exact = picture;
        for (int k = 0; k < 3; k++)
            exact.plane[k] = b->shown.c[k];
        GP_TRY(gp_bench_compare(b->req->gp, &exact, &picture, true, &facts,
                                page ? &map : NULL));
        row->error[GP_FLIP] = facts.flip;
        if (page)
            GP_TRY(b->req->picture(b->req->user, b->log, row->name,
                                   row->options, &picture, &exact, &map));
    }
out:
    glarepp_image_end(&map);
    return st;
}

static void begin_trial(struct gp_bench *b,
                        const struct gp_bench_technique *technique,
                        struct trial *t)
{
    struct gp_bench_row *const row = t->row;
    struct glarepp_frame *frame = NULL;
    t->st = make_plan(b, technique, &t->plan);
    if (!t->st)
        t->st = run_first(t, technique->engine, &frame);
    if (!t->st && frame) {
        const double part = row->facts.polygons ? 1.0 : (double) NAN;
        row->polygons = part * (double) row->facts.polygons;
        row->polygon_pixels = part * row->facts.polygon_pixels;
        // no plane bounds what it is off true angles
        if (!b->angles || technique->follows)
            row->bound = row->facts.bound;
        t->st = measure_error(b, frame, row);
    }
    // the renderer's name goes with its context
    snprintf(row->gl, sizeof row->gl, "%s", row->facts.gl ? row->facts.gl : "");
    glarepp_frame_end(&frame);
}

/* Tests whether a row of `auto` is a computation that another row has, too. */
static bool is_same(const struct gp_bench_row *a, const struct gp_bench_row *b)
{
    return a->max_abs == b->max_abs && // of none NaN
           strcmp(a->facts.engine, b->facts.engine) == 0 &&
           a->facts.in_double == b->facts.in_double &&
           memcmp(a->error, b->error, sizeof a->error) == 0;
}

static gp_status end_trial(struct trial *t)
{
    struct gp_bench_row *const row = t->row;
    const struct gp_log *const log = t->b->log;
    const gp_status st = t->st;
    if (t->same) {
        struct gp_bench_row *const other = t->same->row;
        other->twin = row->name;
        row->same = other->name;
        row->took = other->took;
        row->bound = other->bound;
    } else if (!st && isnan(row->share)) {
        if (!t->times.n)
            gp_bench_time(&t->times, row->took.first); // the only one: long
        gp_bench_spread(&t->times, &row->took);
    }
    if (!st)
        row->why[0] = '\0'; // written for a context that another replaced
    else
        row->took.first = NAN;
    if (st && !row->why[0])
        snprintf(row->why, sizeof row->why, "%s", gp_status_text(st));
    // a technique that cannot run here is a row, not an error of bench
    if (st && st != GP_ERR_GL && st != GP_ERR_USAGE)
        return gp_fail(log, st, "%s: %s", row->name, row->why);
    if (st)
        gp_say(log, GP_LEVEL_INFO, "%s: cannot run: %s", row->name, row->why);
    else if (!isnan(row->share))
        gp_say(log, GP_LEVEL_INFO, "%s: %.3g ms, extrapolated", row->name,
               row->took.ms);
    else
        gp_say(log, GP_LEVEL_INFO, "%s: %.3g ms, rel_l2 %.3g", row->name,
               row->took.ms, row->error[GP_REL_L2]);
    return GP_OK;
}

/* Measures n techniques, of which each run of one is followed by one of the next;
 * their rows are named. */
static gp_status run_techniques(struct gp_bench *b,
                                const struct gp_bench_technique *technique,
                                int n, struct gp_bench_row *row)
{
    struct trial trial[GP_BENCH_ROWS] = {{0}};
    gp_status st = GP_OK;
    for (int i = 0; i < n; i++) {
        struct trial *const t = &trial[i];
        *t = (struct trial) {
            .b = b,
            .row = &row[i],
            .log = {gp_bench_keep_why, row[i].why, GP_LEVEL_ERROR},
        };
        begin_trial(b, &technique[i], t);
        for (int k = 0; k < i && strcmp(technique[i].engine, "auto") == 0;
             k++) {
            if (!t->same && !t->st && is_same(&row[k], &row[i]))
                t->same = &trial[k];
        }
    }
    for (int i = 0; i < n * b->req->params->runs; i++)
        take_turn(&trial[i % n]);
    for (int i = 0; i < n; i++)
        GP_TRY(end_trial(&trial[i]));
out:
    for (int i = 0; i < n; i++)
        glarepp_plan_end(&trial[i].plan);
    return st;
}

// -- a frame ------------------------------------------------------------------

/* Finds the sources and the sum in double, and shows its composite; or the layer's,
 * where the sum may be of a sample. */
static gp_status make_truth(struct gp_bench *b)
{
    const size_t n = gp_frame_pixels(b->f);
    struct glarepp_image view;
    gp_status st;
    b->params.image = gp_frame_view(b->f, &b->f->rgb);
    b->params.in_place = true;
    b->params.details = true; // keeps the sum
    b->params.user = &b->errors;
    b->angles = b->req->plan->projection != GLAREPP_PLANE;
    GP_TRY(make_plan(b, NULL, &b->plan));
    GP_TRY(glarepp_frame(b->plan, &b->params, &b->truth));
    GP_TRY(glarepp_frame_run(b->truth, GLAREPP_SENSE));
    b->sense = glarepp_frame_facts(b->truth)->sense;
    if (b->sense.sources)
        GP_TRY(glarepp_frame_run(b->truth, GLAREPP_KERNEL));
    const char *const by = glarepp_frame_facts(b->truth)->kernel.projection;
    b->angles = b->angles && by && strcmp(by, "plane") != 0;
    if (!b->sense.sources)
        return GP_OK;
    GP_TRY(glarepp_frame_run(b->truth, GLAREPP_LAYER));
    GP_TRY(glarepp_frame_run(b->truth, GLAREPP_VERIFY));
    // FLIP judges the tone-mapped composite, not light
    if (strcmp(b->req->plan->tone->curve, "none") == 0)
        return GP_OK;
    GP_TRY(glarepp_frame_view(
        b->truth, b->angles ? GLAREPP_GLARE : GLAREPP_TRUTH, 0, &view));
    GP_TRY(glarepp_frame_set(b->truth, GLAREPP_GLARE, &view));
    GP_TRY(show(b->truth, &view));
    GP_TRY(gp_planes_make(b->log, "picture", n, &b->shown));
    for (int c = 0; c < 3; c++)
        memcpy(b->shown.c[c], view.plane[c], n * sizeof(float));
out:
    return st;
}

static gp_status measure_frame(struct gp_bench *b, struct gp_bench_frame *out)
{
    const struct glarepp_plan_params *const plan = b->req->plan;
    struct gp_bench_technique technique[GP_BENCH_ROWS];
    gp_status st;
    GP_TRY(make_truth(b));
    out->width = gp_frame_w(b->f);
    out->height = gp_frame_h(b->f);
    out->sources = b->sense.sources;
    const struct glarepp_kernel_facts *const kernel =
        &glarepp_frame_facts(b->truth)->kernel;
    out->angles = b->angles;
    out->kernel_w = kernel->w;
    out->kernel_h = kernel->h;
    out->kernel_left_out = kernel->modelled ? kernel->left_out : (double) NAN;
    const struct gp_bench_technique *t = gp_bench_techniques;
    const double pairs =
        (double) out->sources * (double) out->width * (double) out->height;
    for (; t->name; t++) {
        const bool direct = strcmp(t->engine, "direct") == 0;
        if (t->follows && t->tolerance > 0.0f &&
            (!b->angles || (direct && pairs > PAIRS)))
            continue;
        // the layer by the kernel's core and its far field is auto's
        const bool whole = (kernel->grid || b->angles) && direct && !t->follows;
        technique[out->rows] = *t;
        const bool plane = b->angles && strcmp(t->name, "fft") == 0;
        struct gp_bench_row *const row =
            gp_bench_row_add(b,
                             whole   ? "direct, whole kernel"
                             : plane ? "plane"
                                     : t->name,
                             NULL, out);
        gp_bench_options(t, plan->layer->tolerance, b->angles, row->options,
                         sizeof row->options);
        if (row->why[0])
            gp_say(b->log, GP_LEVEL_INFO, "%s: cannot run: %s", row->name,
                   row->why);
    }
    if (b->sense.sources)
        GP_TRY(run_techniques(b, technique, out->rows, out->row));
    GP_TRY(gp_bench_extras(b, out));
    gp_bench_mark_pareto(out);
out:
    glarepp_frame_end(&b->truth);
    glarepp_plan_end(&b->plan);
    gp_planes_free(&b->shown);
    return st;
}

static gp_status make_kernel(struct gp_bench *b)
{
    struct glarepp_kernel_params p = *b->req->kernel;
    struct glarepp_image view;
    struct gp_frame image = {0};
    gp_status st;
    if (!b->req->kernel_name) {
        GP_TRY(gp_paper_kernel(b->log, &image));
        view = gp_frame_view(&image, &image.rgb);
        p = (struct glarepp_kernel_params) GLAREPP_KERNEL_PARAMS;
        p.image = &view;
    }
    GP_TRY(glarepp_kernel(b->req->gp, &p, &b->kernel));
out:
    gp_frame_free(&image);
    return st;
}

/* Checks the names of outputs first: minutes of measuring must not end at one
 * that cannot be written. */
static gp_status check_outputs(const struct gp_log *log,
                               const struct gp_bench_params *p)
{
    const char *const files[] = {p->csv, p->json, p->plot, p->page};
    char ending[8] = "svg";
    gp_status st = GP_OK;
    if (p->plot && !gp_is_dash(p->plot))
        gp_file_ending(p->plot, ending, sizeof ending);
    for (int i = 0; i < 4 && !st; i++) {
        if (files[i] && !gp_is_dash(files[i]))
            st = gp_file_check(log, files[i], false);
    }
    if (!st && strcmp(ending, "svg") != 0)
        st = gp_fail(log, GP_ERR_USAGE,
                     "%s: the plot is an SVG; give a name "
                     "that ends in .svg",
                     p->plot);
    return st;
}

gp_status gp_bench_run(const struct gp_log *log,
                       const struct gp_bench_request *req)
{
    gp_status st;
    const struct gp_bench_params *const p = req->params;
    const bool paper = p->paper;
    struct gp_frame f = {0};
    struct gp_bench b = {
        .log = log,
        .errors = {log->sink, log->user, GP_LEVEL_ERROR},
        .req = req,
        .f = &f,
    };
    struct gp_bench_table table = {.runs = p->runs};
    GP_TRY(check_outputs(log, p));
    const struct glarepp_light_params *const l = req->plan->lights;
    if (!paper && l && (l->lights || l->file || l->cameras || l->needed)) {
        bool lit = false;
        st = gp_bench_sun(log, req, &lit);
        if (st || lit)
            return st;
    }
    GP_TRY(make_kernel(&b));
    for (int i = 0; i < (paper ? GP_PAPER_KINDS : 1); i++) {
        struct gp_bench_frame *const out = &table.frame[table.frames++];
        GP_TRY(paper ? gp_paper_frame(log, (enum gp_paper_kind) i, &f)
                     : gp_read_frame(log, req->read, req->input, &f));
        b.params = paper ? (struct glarepp_frame_params) GLAREPP_FRAME_PARAMS
                         : req->describe(req->user, &f);
        out->input = paper ? gp_paper_rates[i].name : req->input;
        out->kernel = req->kernel_name ? req->kernel_name : "streaks";
        out->paper = paper ? &gp_paper_rates[i] : NULL;
        GP_TRY(measure_frame(&b, out));
        if (!paper)
            GP_TRY(gp_bench_whole_run(&b, &out->whole));
        if (p->page)
            GP_TRY(req->table(req->user, log, gp_bench_json_frame(out)));
        gp_frame_free(&f);
    }
    GP_TRY(gp_bench_write(log, p, &table));
out:
    gp_frame_free(&f);
    glarepp_kernel_end(&b.kernel);
    return st;
}
