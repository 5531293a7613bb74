// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_priv.h"

#include "core/clock.h"
#include "core/json.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "io/file.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { MASK = 2, ROWS = 22 }; // the first row of a mask; all

struct row {
    struct glarepp_light_params p;
    char name[40];
    char why[GP_BENCH_WHY]; // "": it ran
    struct gp_bench_took took;
    double visibility;     // of the first light
    double mean, worst;    // error over all lights
};

struct bench {
    const struct gp_log *log;
    const struct gp_bench_request *req;
    struct gp_frame frame;
    struct glarepp_share light; // the first, and
    int lights;                 // their number
    double *exact;         // visibility of each light
    struct gp_bench_times times; // of the present row
    char gl[160];
    struct row row[ROWS];
};

/* Exact and readback, then masks by side, pattern and sum. */
static void make_rows(struct bench *b)
{
    for (int i = 0; i < ROWS; i++) {
        struct row *const r = &b->row[i];
        r->p = *b->req->plan->lights;
        r->p.method = i == 0   ? GLAREPP_EXACT
                      : i == 1 ? GLAREPP_READBACK : GLAREPP_MASK;
        r->p.bytes = i >= MASK && (i - MASK) % 2;
        if (i < MASK) {
            strcpy(r->name, i ? "readback" : "exact");
            continue;
        }
        r->p.side = 4 << (i - MASK) / 4;
        r->p.square = (i - MASK) / 2 % 2;
        snprintf(r->name, sizeof r->name, "mask %dx%d %s %s", r->p.side,
                 r->p.side, r->p.square ? "square" : "disc",
                 r->p.bytes ? "8bit" : "float");
    }
}

// -- measuring ---------------------------------------------------------------

/* Measures a row; the first finds the lights, and its errors are those of all. */
static gp_status measure_row(struct bench *b, struct row *r)
{
    const bool first = r == b->row;
    const struct gp_log keep = {gp_bench_keep_why, r->why, GP_LEVEL_ERROR};
    const struct gp_log *const log = first ? b->log : &keep;
    struct glarepp_plan_params p = *b->req->plan;
    struct glarepp_frame_params f = b->req->describe(b->req->user, &b->frame);
    struct glarepp_plan *plan = NULL;
    struct glarepp_frame *frame = NULL;
    gp_status st;
    p.lights = &r->p;
    p.lens = NULL;
    GP_TRY(glarepp_plan(b->req->gp, &p, &plan));
    f.in_place = true;
    f.user = (void *) (uintptr_t) log;
    GP_TRY(glarepp_frame(plan, &f, &frame));
    GP_TRY(glarepp_frame_run(frame, GLAREPP_POSE));
    GP_TRY(glarepp_frame_run(frame, GLAREPP_PLACE));
    if (glarepp_frame_facts(frame)->lights)
        GP_TRY(b->req->planes(b->req->user, log, &b->frame, frame));
    b->times.n = 0;
    for (int run = 0; run <= b->req->params->runs; run++) {
        const double start = gp_now_ms();
        GP_TRY(glarepp_frame_run(frame, GLAREPP_SHARES));
        if (run)
            gp_bench_time(&b->times, gp_now_ms() - start);
        else
            r->took.first = gp_now_ms() - start;
    }
    gp_bench_spread(&b->times, &r->took);
    const struct glarepp_facts *const facts = glarepp_frame_facts(frame);
    b->lights = facts->lights;
    if (!b->lights)
        goto out;
    b->light = facts->light[0];
    r->visibility = b->light.visibility;
    if (first)
        GP_TRY(gp_alloc(b->log, "lights", (size_t) b->lights, sizeof *b->exact,
                        &b->exact));
    for (int i = 0; i < b->lights; i++) {
        const double v = facts->light[i].visibility;
        if (first)
            b->exact[i] = v;
        const double off = fabs(v - b->exact[i]);
        r->mean += off / b->lights;
        r->worst = fmax(r->worst, off);
    }
    if (facts->shares_gl)
        snprintf(b->gl, sizeof b->gl, "%s", facts->shares_gl);
out:
    glarepp_frame_end(&frame);
    glarepp_plan_end(&plan);
    return st == GP_ERR_GL ? GP_OK : st;
}

// -- tables ------------------------------------------------------------------

static void print_table(const struct bench *b)
{
    printf("%s: %dx%d, %d lights, the first at %.2f,%.2f of radius %.2f; "
           "median of %d runs, %d threads\n",
           gp_printable(b->frame.path).text,
           gp_frame_w(&b->frame), gp_frame_h(&b->frame), b->lights,
           b->light.x, b->light.y, b->light.radius,
           b->req->params->runs, gp_threads());
    printf("  %-26s %8s %8s %8s %8s %10s %10s %10s\n", "method", "ms", "min",
           "max", "first", "visible", "mean error", "worst");
    for (int i = 0; i < ROWS; i++) {
        const struct row *const r = &b->row[i];
        const struct gp_bench_took *const t = &r->took;
        if (r->why[0])
            printf("  %-26s cannot run: %s\n", r->name,
                   gp_printable(r->why).text);
        else
            printf("  %-26s %8.3f %8.3f %8.3f %8.1f %10.6f %10.2g %10.2g\n",
                   r->name, t->ms, t->least, t->most, t->first, r->visibility,
                   r->mean, r->worst);
    }
    const struct row *const back = &b->row[1], *const mask = &b->row[MASK + 8];
    if (!mask->why[0] && !back->why[0])
        printf("readback over %s: %.2f times (the paper, on a GPU of 2002: "
               "1.92)\n",
               mask->name, back->took.ms / mask->took.ms);
    printf("error: to exact\n");
    if (b->gl[0])
        printf("GL ran on %s\n", gp_printable(b->gl).text);
}

static json_t *row_json(const struct row *r)
{
    const struct gp_bench_took *const t = &r->took;
    if (r->why[0])
        return json_pack("{ss so}", "method", r->name, "why",
                         gp_json_name(r->why));
    return json_pack("{ss so so so so sf sf sf}", "method", r->name, "ms",
                     gp_bench_ms(t->ms), "ms_min", gp_bench_ms(t->least),
                     "ms_max", gp_bench_ms(t->most), "ms_first",
                     gp_bench_ms(t->first), "visibility", r->visibility,
                     "error_mean", r->mean, "error_worst", r->worst);
}

static gp_status save_files(const struct bench *b)
{
    static const char columns[] = "method,ms,ms_min,ms_max,ms_first,visibility,"
                                  "error_mean,error_worst";
    json_t *const rows = json_array();
    for (int i = 0; i < ROWS; i++)
        json_array_append_new(rows, row_json(&b->row[i]));
    return gp_bench_save(b->log, b->req->params,
                         json_pack("{so si si si so}", "input",
                                   gp_json_name(b->frame.path), "lights",
                                   b->lights, "runs", b->req->params->runs,
                                   "threads", gp_threads(), "rows", rows),
                         columns);
}

gp_status gp_bench_sun(const struct gp_log *log,
                       const struct gp_bench_request *req, bool *lit)
{
    gp_status st;
    const struct gp_bench_params *const p = req->params;
    const struct glarepp_light_params *const lights = req->plan->lights;
    struct bench b = {.log = log, .req = req};
    GP_TRY(gp_read_frame(log, req->read, req->input, &b.frame));
    make_rows(&b);
    GP_TRY(measure_row(&b, &b.row[0]));
    // a camera without suns only says how large angles are
    *lit = b.lights || lights->needed || lights->lights || lights->file;
    if (!*lit)
        goto out;
    if (p->plot || p->page)
        GP_TRY(gp_fail(log, GP_ERR_USAGE,
                       "--%s: cannot show the sun's table; use --csv or --json",
                       p->plot ? "plot" : "html"));
    if (!b.lights)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
               "%s: no lights; add one, or give --sun",
               lights->file ? lights->file : lights->cameras));
    for (int i = 1; i < ROWS; i++)
        GP_TRY(measure_row(&b, &b.row[i]));
    if (p->csv || p->json)
        GP_TRY(save_files(&b));
    if (!gp_is_dash(p->csv) && !gp_is_dash(p->json)) {
        print_table(&b);
        GP_TRY(gp_flush_stdout(log));
    }
out:
    gp_frame_free(&b.frame);
    gp_free(b.exact);
    return st;
}
