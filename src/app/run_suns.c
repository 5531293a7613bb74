/* Suns and lamps of a frame: their visible shares, their flare, and the facts
 * about them. */
#include "app/stages.h"

#include "core/clock.h"
#include "core/memory.h"

#include <string.h>

gp_status gp_run_dark_layer(struct gp_frame_state *fs)
{
    struct gp_planes *const p = &fs->frame.layer;
    const size_t n = gp_frame_pixels(&fs->frame);
    gp_status st = gp_planes_make(fs->log, "layer", n, p);
    if (!st)
        gp_planes_clear(p, 0, n);
    return st;
}

gp_status gp_run_suns(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_sun_files files = {r->s, fs->job};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    gp_status st = gp_suns_place(fs->log, &reader, &fs->frame, &r->suns);
    if (!st)
        st = gp_run_outside(r, fs);
    if (!st)
        st = gp_suns_measure(fs->log, &r->suns);
    if (st)
        return st;
    fs->facts.sun_way = gp_suns_way(&r->suns);
    if (r->suns.gl)
        fs->facts.sun_gl = gp_gl_info(r->suns.gl)->name;
    return GP_OK;
}

gp_status gp_run_flare(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_flare_facts *const facts = &fs->facts.flare;
    int *const frame = &r->suns.flare.frame;
    gp_status st = GP_OK;
    double cpu = 0.0;
    if (!gp_job_number(fs->job, frame))
        *frame = 0;
    if (gp_suns_add_light(&r->suns) && !fs->frame.layer.c[0])
        st = gp_run_dark_layer(fs);
    if (!st)
        st = gp_suns_draw(fs->log, &r->suns, gp_run_kernel_of(fs), &fs->frame);
    cpu = gp_cpu_ms();
    if (!st)
        st = gp_run_ghosts_add(fs->log, r, &fs->sources, &r->ghosts, &fs->frame,
                               facts);
    fs->engine_ms = facts->ms;
    fs->engine_cpu_ms = gp_cpu_ms() - cpu;
    return st;
}

gp_status gp_run_shares(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_suns *const suns = &r->suns;
    const struct gp_occluders *const o = &suns->occluders;
    struct gp_facts *const facts = &fs->facts;
    gp_status st = gp_alloc(fs->log, "lights", (size_t) suns->n,
                            sizeof *fs->light, &fs->light);
    if (st)
        return st;
    facts->light = fs->light;
    facts->lights = suns->n;
    if (suns->n)
        memcpy(fs->light, suns->light, (size_t) suns->n * sizeof *fs->light);
    gp_sun_interval(o, suns->p->map.outside, fs->light, suns->n);
    facts->depth = fs->depth = o->depth ? gp_strdup(o->depth->name) : NULL;
    facts->mask = fs->mask = o->mask ? gp_strdup(o->mask->name) : NULL;
    if ((o->depth && !fs->depth) || (o->mask && !fs->mask))
        return gp_no_memory_bare(fs->log, "lights");
    if (o->depth) {
        memcpy(facts->depth_empty, o->facts.empty, sizeof o->facts.empty);
        facts->depth_reversed = o->facts.reversed;
    }
    if (r->s->debug[GP_DEBUG_SUNMAP])
        st = gp_suns_picture(fs->log, suns, false, &fs->sunmap.w,
                             &fs->sunmap.h, &fs->sunmap.planes);
    if (!st && r->s->debug[GP_DEBUG_INTENSITY])
        st = gp_suns_picture(fs->log, suns, true, &fs->intensity.w,
                             &fs->intensity.h, &fs->intensity.planes);
    return st;
}
