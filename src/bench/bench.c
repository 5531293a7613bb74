#include "bench/bench_priv.h"

#include "compare/flip.h"
#include "core/clock.h"
#include "core/memory.h"
#include "io/file.h"
#include "io/plane.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const double LONG_MS = 6e3;  // a run over this is extrapolated
static const size_t MANY = 10000;   // sources from which a tenth runs first; of
                                    // ten times as many, a hundredth
static const double ROW_MS = 15e3;  // no further run is started after this

/* A frame, and the exact layer that its rows are compared with. */
struct bench {
    const struct gp_log *log;
    const struct gp_bench_request *req;
    const struct gp_kernel *kernel;
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
    int state;                      // of the engine, in `glare`
    struct gp_glare glare;
    struct gp_log log;              // errors of GL go into row->why
    struct gp_bench_row *row;
    double *ms;                     // of the runs
};

/* A run's times, and the sources it had. */
struct run {
    double sense_ms, glare_ms, ms; // of the two stages, of both
    size_t sources;
};

static gp_status run_once(struct trial *t, struct gp_frame *f, struct run *r)
{
    struct gp_sources src = {0};
    const double start = gp_now_ms();
    gp_status st = gp_sense(&t->log, t->b->req->sensor, f, &src);
    const double middle = gp_now_ms();
    if (!st)
        st = gp_glare_run(&t->log, &t->params, &t->glare, &src,
                          t->b->kernel, f, &t->row->stats);
    const double end = gp_now_ms();
    *r = (struct run) {middle - start, end - middle, end - start, src.n};
    gp_sources_free(&src);
    return st;
}

// -- extrapolation -----------------------------------------------------------

enum { BLOCK = 32 }; // no group or cluster of bench's is cut by one

gp_status gp_bench_thin(const struct gp_log *log, const struct gp_frame *f,
    const struct gp_sources *src, int nth, struct gp_frame *out)
{
    const size_t n = gp_frame_pixels(f), w = (size_t) gp_frame_w(f);
    struct gp_frame thin = {.data = f->data, .display = f->display};
    memcpy(thin.luminance, f->luminance, sizeof thin.luminance);
    memcpy(thin.chromaticities, f->chromaticities, sizeof thin.chromaticities);
    gp_status st = gp_planes_make(log, "part of the frame", n, &thin.rgb);
    if (st)
        return st;
    // Rows of blocks start 3 blocks further than the one before, 37 for
    // hundredths, so that the chosen ones make no columns
    const size_t step = nth > 10 ? 37 : 3;
    size_t first = 0; // row of the first source
    while (src->n > 0 && src->row[first + 1] == 0)
        first++;
    for (int c = 0; c < 3; c++) {
        float *const to = thin.rgb.c[c];
        const float *const from = f->rgb.c[c];
        memset(to, 0, n * sizeof *to);
        for (size_t at = 0; at < n && nth > 0;) {
            const size_t x = at % w, y = at / w;
            const size_t run = w - x < BLOCK ? w - x : BLOCK;
            if ((x / BLOCK + y / BLOCK * step) % (size_t) nth == 0)
                memcpy(to + at, from + at, run * sizeof *to);
            at += run;
        }
        if (nth == 0 && src->n > 0) {
            const size_t at = first * w + (size_t) src->x[0];
            to[at] = from[at];
        }
    }
    *out = thin;
    return GP_OK;
}

/* Runs some of the sources twice, and only one source twice. */
static gp_status run_thinned(struct trial *t, int nth)
{
    gp_status st;
    struct gp_bench_row *const row = t->row;
    const struct bench *const b = t->b;
    struct gp_frame thin = {0}, single = {0};
    struct run first, warm, least;
    GP_TRY(gp_bench_thin(&t->log, b->f, &b->src, nth, &thin));
    GP_TRY(gp_bench_thin(&t->log, b->f, &b->src, 0, &single));
    GP_TRY(run_once(t, &single, &first)); // makes the state
    GP_TRY(run_once(t, &single, &least));
    GP_TRY(run_once(t, &thin, &warm));
    row->share = (double) warm.sources / (double) b->src.n;
    if (warm.sources == 0)
        goto out;
    row->extrapolated = true;
    row->runs = 1;
    // work that grows with each source, on top of what a single one costs
    const double base = least.glare_ms < warm.glare_ms ? least.glare_ms : 0.0;
    row->ms = warm.sense_ms + base + (warm.glare_ms - base) / row->share;
    row->ms_min = row->ms_max = row->ms;
    row->ms_first = row->ms + fmax(first.ms - least.ms, 0.0);
    row->polygons = (double) row->stats.polygons / row->share;
    row->polygon_pixels = row->stats.polygon_pixels / row->share;
out:
    gp_frame_free(&thin);
    gp_frame_free(&single);
    return st;
}

/* Whole runs, or thinned ones when those would take too long. */
static gp_status time_row(struct trial *t)
{
    const struct bench *const b = t->b;
    struct gp_bench_row *const row = t->row;
    // auto chooses what is fast; the work of fft does not grow with the sources
    const bool grows = t->engine && t->engine != &gp_engine_fft;
    gp_status st = GP_OK;
    if (grows && b->src.n > MANY)
        st = run_thinned(t, b->src.n > 10 * MANY ? 100 : 10);
    if (st || (row->extrapolated && row->ms > LONG_MS)) {
        // the whole frame's bound, where the engine has one without a run
        row->bound = NAN;
        if (!st && t->engine && t->engine->bound)
            st = t->engine->bound(
                &(struct gp_glare_request) {
                    .log = &t->log, .params = &t->params, .src = &b->src,
                    .kernel = b->kernel, .layer = &b->f->layer,
                }, &t->glare.state[t->state], &row->bound);
        return st;
    }
    row->extrapolated = false; // faster than that
    struct run r;
    st = run_once(t, b->f, &r);
    double total = row->ms_first = t->ms[0] = r.ms;
    int n = 0;
    while (!st && n < b->req->params->runs && total < ROW_MS) {
        st = run_once(t, b->f, &r);
        total += t->ms[n++] = r.ms;
    }
    if (st)
        return st;
    row->runs = n > 0 ? n : 1; // the first took so long that it is the only one
    row->ms = gp_bench_median(t->ms, row->runs);
    row->ms_min = t->ms[0];
    row->ms_max = t->ms[row->runs - 1];
    row->polygons = (double) row->stats.polygons;
    row->polygon_pixels = row->stats.polygon_pixels;
    row->bound = row->stats.bound;
    return GP_OK;
}

/* Composes and tone maps f->layer. */
static gp_status show_layer(const struct bench *b)
{
    gp_status st = gp_compose(b->log, b->req->compose, &b->src, b->f);
    return st ? st : gp_tone_map(b->log, b->req->tone, b->f, NULL);
}

static gp_status run_technique(const struct bench *b, double *ms,
    const struct gp_bench_technique *technique, struct gp_bench_row *row)
{
    struct trial t = {
        .b = b, .params = *b->req->glare, .row = row, .ms = ms,
        .log = {gp_bench_keep_why, row->why, GP_LEVEL_ERROR},
    };
    t.params.engine = technique->engine;
    t.params.splat = technique->splat;
    for (int i = 0; gp_engines[i]; i++) {
        if (strcmp(gp_engines[i]->name, technique->engine) == 0) {
            t.engine = gp_engines[i];
            t.state = i;
        }
    }
    gp_status st = time_row(&t);
    if (!st && !row->extrapolated) {
        gp_glare_measure(
            b->f, &b->f->layer, b->exact, b->req->compose->gain,
            b->req->compose->mix == GP_MIX_SCATTER ? &b->src : NULL,
            &row->error);
        row->measured = true;
        if (b->shown.c[0])
            st = show_layer(b);
        if (!st && b->shown.c[0])
            st = gp_flip_ldr(b->log, gp_frame_w(b->f), gp_frame_h(b->f),
                &b->shown, &b->f->shown, NULL, &row->flip);
    }
    // the renderer's name goes with its context
    snprintf(row->gl, sizeof row->gl, "%s", row->stats.gl ? row->stats.gl : "");
    row->stats.gl = row->gl;
    gp_glare_close(&t.glare);
    if (!st)
        row->why[0] = '\0'; // written for a context that another replaced
    else if (!row->why[0])
        snprintf(row->why, sizeof row->why, "%s", gp_status_text(st));
    // a technique that cannot run here is a row, not an error of bench
    if (st && st != GP_ERR_GL && st != GP_ERR_USAGE)
        return gp_fail(b->log, st, "%s: %s", row->name, row->why);
    if (st)
        gp_say(b->log, GP_LEVEL_INFO, "%s: cannot run: %s", row->name,
               row->why);
    else if (row->extrapolated)
        gp_say(b->log, GP_LEVEL_INFO, "%s: %.3g ms, extrapolated", row->name,
               row->ms);
    else
        gp_say(b->log, GP_LEVEL_INFO, "%s: %.3g ms, rel_l2 %.3g", row->name,
               row->ms, row->error.rel_l2);
    return GP_OK;
}

/* Measures a layer of its own, and makes its truth where that of `before`, the row
 * before, is another's. */
static gp_status run_layer(struct bench *b, const struct gp_bench_layer *e,
    const struct gp_bench_layer *before, double *ms, struct gp_bench_row *row)
{
    const size_t n = gp_frame_pixels(b->f);
    double total = 0.0;
    int runs = 0;
    gp_status st;
    if (!before || strcmp(before->layer, e->layer) != 0) {
        memset(b->exact, 0, 3 * n * sizeof *b->exact);
        GP_TRY(e->exact(e->user, b->log, &b->src, b->f, b->exact));
    }
    for (int i = 0; i <= b->req->params->runs && (i < 2 || total < ROW_MS);
         i++) {
        gp_planes_clear(&b->f->layer, 0, n);
        const double start = gp_now_ms();
        GP_TRY(e->draw(e->user, b->log, &b->src, b->f, &row->bound));
        const double took = gp_now_ms() - start;
        total += took;
        if (i == 0)
            row->ms_first = took;
        else
            ms[runs++] = took;
    }
    row->runs = runs;
    row->ms = gp_bench_median(ms, runs);
    row->ms_min = ms[0];
    row->ms_max = ms[runs - 1];
    gp_glare_measure(b->f, &b->f->layer, b->exact, b->req->compose->gain, NULL,
                     &row->error);
    row->measured = true;
    gp_say(b->log, GP_LEVEL_INFO, "%s: %.3g ms, rel_l2 %.3g", row->name,
           row->ms, row->error.rel_l2);
out:
    return st;
}

/* Measures all techniques on a frame into t->frame, in the order of
 * gp_bench_techniques. A run that would take over 6 s is made with a part of
 * the sources (a tenth, or a hundredth where that takes too long as well) and
 * extrapolated; no row takes much over a quarter of a minute. */
static gp_status measure_frame(struct bench *b, struct gp_bench_frame *out)
{
    gp_status st;
    const size_t n = gp_frame_pixels(b->f);
    double *ms = NULL;
    GP_TRY(gp_alloc(b->log, "times", (size_t) b->req->params->runs, sizeof *ms,
                    &ms));
    GP_TRY(gp_sense(b->log, b->req->sensor, b->f, &b->src));
    out->width = gp_frame_w(b->f);
    out->height = gp_frame_h(b->f);
    out->sources = (long long) b->src.n;
    if (b->src.n > 0) {
        GP_TRY(gp_alloc(b->log, "exact layer", 3 * n, sizeof *b->exact,
                        &b->exact));
        GP_TRY(gp_glare_reference(b->log, NULL, &b->src, b->kernel, b->exact));
        GP_TRY(gp_planes_make(b->log, "layer", n, &b->f->layer));
    }
    // FLIP judges the tone-mapped composite, not light
    if (b->src.n > 0 && strcmp(b->req->tone->curve, "none") != 0) {
        for (size_t i = 0; i < 3 * n; i++)
            b->f->layer.c[i / n][i % n] = (float) b->exact[i];
        GP_TRY(show_layer(b));
        b->shown = b->f->shown;
        b->f->shown = (struct gp_planes) {0};
    }
    for (out->rows = 0; gp_bench_techniques[out->rows].name; out->rows++) {
        const struct gp_bench_technique *const technique =
            &gp_bench_techniques[out->rows];
        struct gp_bench_row *const row = &out->row[out->rows];
        *row = (struct gp_bench_row) {
            .name = technique->name, .share = 1.0, .bound = NAN, .flip = NAN,
            .why = "no pixel is over the threshold",
        };
        gp_bench_options(technique, b->req->glare->tolerance, row->options,
                         sizeof row->options);
        if (b->src.n == 0) {
            gp_say(b->log, GP_LEVEL_INFO, "%s: cannot run: %s", row->name,
                   row->why);
            continue;
        }
        row->why[0] = '\0';
        GP_TRY(run_technique(b, ms, technique, row));
    }
    for (int i = 0; i < b->req->layers; i++) {
        const struct gp_bench_layer *const e = &b->req->layer[i];
        struct gp_bench_row *const row = &out->row[out->rows++];
        *row = (struct gp_bench_row) {
            .name = e->name, .layer = e->layer, .share = 1.0, .bound = NAN,
            .flip = NAN, .why = "no pixel is over the threshold",
        };
        snprintf(row->options, sizeof row->options, "%s", e->options);
        if (b->src.n == 0)
            continue;
        row->why[0] = '\0';
        GP_TRY(run_layer(b, e, i ? e - 1 : NULL, ms, row));
    }
    gp_bench_mark_pareto(out);
out:
    gp_sources_free(&b->src);
    GP_FREE(b->exact);
    gp_planes_free(&b->shown);
    gp_free(ms);
    return st;
}

/* The field of a frame as the main job has it: its angle by --fov, by a camera,
 * else the usual one; its time by the frame's number and rate. */
static struct gp_field field_of(const struct gp_bench_request *req,
                                const struct gp_suns *suns,
                                const struct gp_frame *f)
{
    struct gp_sun_about about = {0};
    double fov = req->fov, rate = 0.0;
    if (!req->params->paper) {
        req->reader->about(req->reader->user, f, &about);
        fov = fov > 0.0 ? fov : gp_suns_fov(suns, &about, f);
        rate = gp_frame_rate(f);
    }
    struct gp_field field = gp_field_of(f, fov > 0.0 ? fov : GP_USUAL_FOV);
    field.rotate = (double) req->kernel->rotate;
    field.frame = about.number;
    field.fps = rate > 0.0 ? rate : field.fps;
    return field;
}

gp_status gp_bench_run(const struct gp_log *log,
                       const struct gp_bench_request *req)
{
    gp_status st;
    const struct gp_bench_params *const p = req->params;
    const bool paper = p->paper, own = paper && req->default_kernel;
    const char *const source = own ? "streaks" : req->kernel_name;
    const char *const files[] = {p->csv, p->json, p->plot};
    struct gp_kernel kernel = {0};
    struct gp_frame f = {0};
    struct bench b = {.log = log, .req = req, .kernel = &kernel, .f = &f};
    struct gp_bench_table table = {.runs = p->runs};
    struct gp_suns suns = {0}; // for the camera
    char *answer;
    // first check the names: minutes of measuring must not end at one that
    // cannot be written
    for (int i = 0; i < 3; i++) {
        if (files[i] && !gp_is_dash(files[i]))
            GP_TRY(gp_file_check(log, files[i], false));
    }
    size_t n = p->plot ? strlen(p->plot) : 0;
    if (p->plot && !gp_is_dash(p->plot) &&
        (n < 4 || strcasecmp(p->plot + n - 4, ".svg") != 0))
        return gp_fail(log, GP_ERR_USAGE,
            "%s: the plot is an SVG; give a name that ends in .svg", p->plot);
    if (p->plot) { // check that gnuplot runs
        GP_TRY(gp_gnuplot(log, "exit\n", &answer, &n));
        free(answer);
    }
    GP_TRY(gp_suns_begin(log, req->sun, req->glare->gl, req->reader, &suns));
    if (gp_suns_wanted(req->sun) && gp_suns_lit(&suns)) {
        st = gp_bench_sun(log, req);
        goto out;
    }
    for (int i = 0; i < (paper ? GP_PAPER_KINDS : 1); i++) {
        struct gp_bench_frame *const out = &table.frame[table.frames++];
        GP_TRY(paper ? gp_paper_frame(log, (enum gp_paper_kind) i, GP_PAPER_W,
                                      GP_PAPER_H, &f)
                     : gp_read_frame(log, req->read, req->input, &f));
        // the kernel given, else the paper's own
        struct gp_frame image = {0};
        const struct gp_field field = field_of(req, &suns, &f);
        struct gp_kernel_params of_image = *req->kernel;
        of_image.chromaticities = f.chromaticities;
        gp_kernel_free(&kernel);
        if (own)
            GP_TRY(gp_paper_kernel(log, GP_PAPER_KERNEL, &image));
        st = !own && req->recipes
                 ? gp_model_kernel(log, req->recipe, req->recipes, &field,
                                   &kernel)
                 : gp_kernel_from_frame(log, &of_image,
                                        own ? &image : req->kernel_image,
                                        &kernel);
        gp_frame_free(&image);
        GP_TRY(st);
        out->input = gp_strdup(f.path);
        out->kernel = gp_strdup(source);
        out->kernel_w = kernel.w;
        out->kernel_h = kernel.h;
        out->kernel_left_out =
            !own && (req->recipes || kernel.left_out != 0.0)
                ? kernel.left_out : (double) NAN;
        out->paper = paper ? &gp_paper_rates[i] : NULL;
        if (!out->input || !out->kernel)
            GP_TRY(gp_no_memory(log, f.path));
        GP_TRY(measure_frame(&b, out));
        gp_frame_free(&f);
    }
    GP_TRY(gp_bench_write(log, p, &table));
out:
    gp_suns_close(&suns);
    gp_bench_table_free(&table);
    gp_frame_free(&f);
    gp_kernel_free(&kernel);
    return st;
}
