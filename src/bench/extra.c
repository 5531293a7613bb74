// SPDX-License-Identifier: Apache-2.0
/* Layers that are no engine's of the kernel: flare of bright pixels, and ghosts of a
 * lens, each against a truth of its own. */
#include "bench/bench_priv.h"

#include "core/clock.h"

#include <math.h>
#include <stdio.h>

static const double ROW_MS = 15e3; // no further run is started after this

gp_status gp_bench_compare(struct glarepp *gp,
                           const struct glarepp_image *exact,
                           const struct glarepp_image *picture, bool shown,
                           struct glarepp_compare_facts *out,
                           struct glarepp_image *map)
{
    static const char *const names[] = {"R", "G", "B"};
    const struct glarepp_image *const image[2] = {exact, picture};
    struct glarepp_compare_params p = GLAREPP_COMPARE_PARAMS;
    struct glarepp_channel channel[2][3];
    struct glarepp_stored pair[2];
    struct glarepp_compare *c = NULL;
    for (int k = 0; k < 2; k++) {
        pair[k] = (struct glarepp_stored) {
            .size = sizeof *pair,
            .data = image[k]->data,
            .channel = channel[k],
            .channels = 3,
            .integers = shown,
            .primaries = shown ? NULL : image[k]->primaries,
        };
        for (int i = 0; i < 3; i++) {
            pair[k].light[i] = image[k]->plane[i];
            channel[k][i] =
                (struct glarepp_channel) {names[i], image[k]->plane[i], false};
        }
    }
    p.flip = shown;
    gp_status st = (gp_status) glarepp_compare(gp, &p, &pair[0], &pair[1], &c);
    if (!st)
        *out = *glarepp_compare_facts(c);
    if (!st && map)
        st = (gp_status) glarepp_compare_view(c, -2, false, 1.0f, map);
    glarepp_compare_end(&c);
    return st;
}

/* A layer that is no engine's of the kernel: its row, and how its truth is made. */
static const struct extra {
    const char *name, *options, *layer;
    enum glarepp_step step;
    int detail, true_detail; // of a lens
} extras[] = {
    {"flare of bright pixels", "--flare", "flare", GLAREPP_FLARE, 0, 0},
    {"lens, of many lights", "--lens", "lens", GLAREPP_LENS, 1, 3},
    {"lens, of up to 8 lights", "--lens --lights", "lens", GLAREPP_LENS, 2, 3},
};
enum { EXTRAS = sizeof extras / sizeof *extras };

static gp_status plan_extra(const struct gp_bench *b, const struct extra *e,
                            bool exact, struct glarepp_plan **out)
{
    struct glarepp_plan_params p = *b->req->plan;
    struct glarepp_layer_params layer = *p.layer;
    struct glarepp_lens_params lens = GLAREPP_LENS_PARAMS;
    if (p.lens)
        lens = *p.lens;
    lens.detail = exact ? e->true_detail : e->detail;
    layer.mix = GLAREPP_ADD;
    if (exact && e->step == GLAREPP_FLARE) {
        layer.engine = "fft";
        layer.in_double = true;
    }
    p.kernel = b->kernel;
    p.layer = &layer;
    p.lights = e->step == GLAREPP_FLARE ? p.lights : NULL;
    p.lens = e->step == GLAREPP_LENS ? &lens : NULL;
    p.scene = NULL;
    return (gp_status) glarepp_plan(b->req->gp, &p, out);
}

/* Draws one; *ms is the time of the step. */
static gp_status draw_extra(const struct gp_bench *b, const struct extra *e,
                            struct glarepp_plan *plan,
                            struct glarepp_frame **out, double *ms)
{
    gp_status st;
    GP_TRY(glarepp_frame(plan, &b->params, out));
    GP_TRY(glarepp_frame_run(*out, GLAREPP_SENSE));
    const double start = gp_now_ms();
    GP_TRY(glarepp_frame_run(*out, e->step));
    *ms = gp_now_ms() - start;
    GP_TRY(glarepp_frame_run(*out, GLAREPP_DONE));
out:
    return st;
}

/* Measures layers against exact ones, and composites, if light is added. */
static gp_status compare_extra(const struct gp_bench *b,
                               struct glarepp_frame *frame[2],
                               struct gp_bench_row *out)
{
    struct glarepp_image view[2];
    struct glarepp_compare_facts f;
    gp_status st;
    for (int k = 0; k < 2; k++)
        GP_TRY(glarepp_frame_view(frame[k], GLAREPP_GLARE, 0, &view[k]));
    GP_TRY(gp_bench_compare(b->req->gp, &view[1], &view[0], false, &f, NULL));
    out->error[GP_REL_L2] = f.rel_l2;
    out->max_abs = f.max;
    for (int k = 0; k < 2; k++) {
        GP_TRY(glarepp_frame_run(frame[k], GLAREPP_COMPOSE));
        GP_TRY(glarepp_frame_run(frame[k], GLAREPP_DONE));
        GP_TRY(glarepp_frame_view(frame[k], GLAREPP_LIT, 0, &view[k]));
    }
    GP_TRY(gp_bench_compare(b->req->gp, &view[1], &view[0], false, &f, NULL));
    out->error[GP_MAX_REL] = f.max_rel;
out:
    return st;
}

static gp_status run_extra(const struct gp_bench *b, const struct extra *e,
                           struct gp_bench_row *row)
{
    struct glarepp_plan *plan[2] = {NULL, NULL};
    struct glarepp_frame *frame[2] = {NULL, NULL};
    struct gp_bench_times times = {.n = 0};
    double took;
    gp_status st;
    for (int k = 0; k < 2; k++)
        GP_TRY(plan_extra(b, e, k == 1, &plan[k]));
    GP_TRY(draw_extra(b, e, plan[1], &frame[1], &took));
    GP_TRY(draw_extra(b, e, plan[0], &frame[0], &row->took.first));
    do {
        glarepp_frame_end(&frame[0]);
        GP_TRY(draw_extra(b, e, plan[0], &frame[0], &took));
        gp_bench_time(&times, took);
    } while (times.n < b->req->params->runs &&
             row->took.first + times.total < ROW_MS);
    gp_bench_spread(&times, &row->took);
    row->bound = e->step == GLAREPP_FLARE
                     ? glarepp_frame_facts(frame[0])->flare.bound
                     : (double) NAN;
    GP_TRY(compare_extra(b, frame, row));
    gp_say(b->log, GP_LEVEL_INFO, "%s: %.3g ms, rel_l2 %.3g", row->name,
           row->took.ms, row->error[GP_REL_L2]);
out:
    for (int k = 0; k < 2; k++) {
        glarepp_frame_end(&frame[k]);
        glarepp_plan_end(&plan[k]);
    }
    return st;
}

gp_status gp_bench_extras(const struct gp_bench *b, struct gp_bench_frame *out)
{
    const struct glarepp_plan_params *const plan = b->req->plan;
    gp_status st = GP_OK;
    for (int i = 0; i < EXTRAS; i++) {
        const struct extra *const e = &extras[i];
        if (e->step == GLAREPP_FLARE ? !plan->lights || !plan->lights->flare
                                     : !plan->lens || !plan->lens->lens)
            continue;
        struct gp_bench_row *const row =
            gp_bench_row_add(b, e->name, e->layer, out);
        snprintf(row->options, sizeof row->options, "%s", e->options);
        if (b->sense.sources)
            GP_TRY(run_extra(b, e, row));
    }
out:
    return st;
}
