/* Suns and lamps of a frame: their visible shares, their flare, and the facts
 * about them. */
#include "app/stages.h"

#include "core/clock.h"
#include "core/memory.h"

#include <math.h>
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

// -- shares outside of the frame, by the scene (--sun-outside scene) ----------

/* Returns true when a light's circle in the picture leaves the rectangle: that
 * of its cone, an ellipse, may differ. */
static bool leaves(const struct gp_light *l, struct gp_rect r)
{
    return l->x - l->radius < r.x0 || l->x + l->radius > r.x1 ||
           l->y - l->radius < r.y0 || l->y + l->radius > r.y1;
}

/* Returns a light's disc; that of a lamp is its ball. */
static struct gp_eye_disc disc_of(const struct gp_light *l, struct gp_v3 eye)
{
    const struct gp_light_sight *const s = &l->sight;
    const struct gp_v3 at = {s->at[0], s->at[1], s->at[2]};
    return s->lamp
               ? gp_eye_lamp(eye, at, sin(s->half) *
                                          gp_v3_length(gp_v3_sub(at, eye)))
               : gp_eye_sun(eye, at, s->half);
}

/* Sets the clear share outside the frame of each light that is placed, where
 * --sun-outside asks for it. Errors: those of gp_eye_rays(); GP_ERR_USAGE no
 * camera. */
static gp_status measure_outside(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_run_scene *const scene = &r->scene;
    const struct gp_rect known = r->suns.occluders.frame;
    gp_status st;
    if (r->s->sun.map.outside != GP_OUTSIDE_SCENE || r->suns.n == 0)
        return GP_OK;
    if (!scene->has_camera)
        return gp_fail(fs->log, GP_ERR_USAGE,
                       "%s: --sun-outside scene needs a camera (the frame has "
                       "no worldToNDC, %s no camera); give --camera FILE, or "
                       "--sun-outside ignore", fs->job->input,
                       r->s->scene.path);
    const struct gp_eye_window window = {&scene->frame_camera,
                                         fs->frame.display, known};
    const struct gp_v3 eye = gp_camera_eye(&scene->frame_camera);
    for (int i = 0; i < r->suns.n; i++) {
        struct gp_light *const l = &r->suns.light[i];
        const struct gp_eye_disc disc = disc_of(l, eye);
        struct gp_eye_share share;
        st = gp_eye_rays(fs->log, &scene->scene, &scene->meshes, &disc, &window,
                         &share);
        if (!st && share.outside == 0.0 && leaves(l, known))
            st = gp_eye_rays(fs->log, &scene->scene, &scene->meshes, &disc, NULL,
                             &share);
        if (st)
            return st;
        l->outside = share.clear;
        l->outside_error = 3.0 * share.error;
    }
    return GP_OK;
}

// -- the stages ---------------------------------------------------------------

gp_status gp_run_suns(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_sun_files files = {r->s, fs->job};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    static const char *const ways[] = {
        [GP_SUN_EXACT] = "exact", [GP_SUN_MASK] = "mask",
        [GP_SUN_READBACK] = "readback",
    };
    gp_status st = gp_suns_place(fs->log, &reader, &fs->frame, &r->suns);
    if (!st)
        st = measure_outside(r, fs);
    if (!st)
        st = gp_suns_measure(fs->log, &r->suns);
    if (st)
        return st;
    fs->facts.sun.way = ways[r->suns.p->method];
    if (r->suns.gl)
        fs->facts.sun.gl = gp_gl_info(r->suns.gl)->name;
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
        st = gp_run_ghosts_add(fs->log, r, &fs->sources, &r->glare.ghosts,
                               &fs->frame, facts);
    fs->engine_ms = facts->ms;
    fs->engine_cpu_ms = gp_cpu_ms() - cpu;
    return st;
}

gp_status gp_run_shares(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_suns *const suns = &r->suns;
    const struct gp_occluders *const o = &suns->occluders;
    struct gp_sun_facts *const facts = &fs->facts.sun;
    gp_status st = gp_alloc(fs->log, "lights", (size_t) suns->n,
                            sizeof *facts->light, &facts->light);
    if (st)
        return st;
    facts->lights = suns->n;
    if (suns->n)
        memcpy(facts->light, suns->light,
               (size_t) suns->n * sizeof *facts->light);
    gp_sun_interval(o, suns->p->map.outside, facts->light, suns->n);
    facts->depth = o->depth ? gp_strdup(o->depth->name) : NULL;
    facts->mask = o->mask ? gp_strdup(o->mask->name) : NULL;
    if ((o->depth && !facts->depth) || (o->mask && !facts->mask))
        return gp_no_memory_bare(fs->log, "lights");
    if (o->depth) {
        memcpy(facts->empty, o->facts.empty, sizeof o->facts.empty);
        facts->reversed = o->facts.reversed;
    }
    for (int i = 0; i < suns->n && !facts->edges; i++) {
        if (facts->light[i].in_frame)
            facts->edges = facts->mask ? facts->depth ? GP_EDGES_COVERAGE
                                                      : GP_EDGES_MASK
                           : facts->depth ? GP_EDGES_DEPTH : GP_EDGES_NONE;
    }
    if (r->s->output.debug[GP_DEBUG_SUNMAP])
        st = gp_sun_map_picture(fs->log, o, &suns->p->map, suns->light,
                                suns->n, &fs->sunmap.w, &fs->sunmap.h,
                                &fs->sunmap.planes);
    if (!st && r->s->output.debug[GP_DEBUG_INTENSITY])
        st = gp_sun_map_picture(fs->log, o, NULL, suns->light, suns->n,
                                &fs->intensity.w, &fs->intensity.h,
                                &fs->intensity.planes);
    return st;
}
