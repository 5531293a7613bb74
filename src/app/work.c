#include "app/work.h"

#include "core/memory.h"

#include <stdlib.h>
#include <string.h>

gp_status gp_work_begin(const struct gp_log *log, const struct gp_jobs *jobs,
                        int index, struct gp_work *out)
{
    const struct gp_job *const job = &jobs->job[index];
    void *names;
    *out = (struct gp_work) {
        .log = log, .job = job, .view = index % jobs->views,
        .targets = jobs->targets,
    };
    gp_status st = gp_alloc_zero(log, "output list",
                                 (size_t) jobs->targets + 1, sizeof *out->names,
                                 &names);
    out->names = names;
    out->facts = (struct gp_facts) {
        .numbered = job->numbered, .frame = job->frame, .view = job->view,
        .input = job->input, .outputs = out->names,
    };
    for (int i = 0; i < GP_TIMES; i++)
        out->facts.ms[i] = -1.0;
    return st;
}

gp_status gp_work_dark_layer(struct gp_work *w)
{
    struct gp_planes *p = &w->frame.layer;
    size_t n = gp_frame_pixels(&w->frame);
    gp_status st = gp_planes_make(w->log, "layer", n, p);
    for (int c = 0; c < 3 && !st; c++)
        memset(p->c[c], 0, n * sizeof(float));
    return st;
}

void gp_work_release(struct gp_work *w, unsigned dead)
{
    if (dead & GP_HAS_RGB)
        gp_planes_free(&w->frame.rgb);
    if (dead & GP_HAS_SOURCES) {
        gp_sources_free(&w->sources);
        gp_sources_free(&w->joined);
    }
    if (dead & GP_HAS_LAYER)
        gp_planes_free(&w->frame.layer);
    if (dead & GP_HAS_LIT)
        gp_planes_free(&w->frame.lit);
    if (dead & GP_HAS_SHOWN)
        gp_planes_free(&w->frame.shown);
}

void gp_work_end(struct gp_work *w)
{
    gp_work_release(w, ~0u);
    gp_light_groups_free(&w->groups);
    gp_frame_free(&w->frame);
    gp_planes_free(&w->sunmap.planes);
    gp_planes_free(&w->intensity.planes);
    for (int i = 0; w->names && i < w->targets; i++)
        free(w->names[i]);
    gp_free(w->names);
    gp_free(w->light);
    gp_free(w->depth);
    gp_free(w->mask);
    *w = (struct gp_work) {0};
}
