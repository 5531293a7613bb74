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

enum { FINER = 4 }; // texels of a scene's sun map for one of --sun-map

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

/* Measures a disc's part outside the window. With the other methods a context
 * is open already, or is opened here for them too. */
static gp_status measure_disc(const struct gp_log *log, struct gp_run *r,
                              const struct gp_eye_disc *disc,
                              const struct gp_eye_window *window,
                              struct gp_eye_share *out)
{
    const struct gp_sun_params *const p = &r->s->sun;
    const struct gp_scene *const s = &r->scene.scene;
    if (p->method == GP_SUN_EXACT)
        return gp_eye_rays(log, s, &r->scene.meshes, disc, window, out);
    gp_status st = r->suns.gl ? gp_gl_use(log, r->suns.gl)
                              : gp_gl_open(log, r->suns.api, &r->suns.gl);
    return st ? st
              : gp_eye_map_draw(log, r->suns.gl, s, &r->scene.meshes, disc,
                                window, FINER * p->map.side, &r->eye_map, out);
}

/* Sets the clear share outside the frame of each light that is placed, where
 * --sun-outside asks for it: by rays with --sun-method exact, else by a sun map
 * from geometry. Errors: those of these; GP_ERR_USAGE no camera. */
static gp_status measure_outside(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_run_scene *const scene = &r->scene;
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
        st = measure_disc(fs->log, r, &disc, &window, &share);
        if (!st && share.outside == 0.0 && leaves(l, known))
            st = measure_disc(fs->log, r, &disc, NULL, &share);
        if (st)
            return st;
        l->outside = share.clear;
        l->outside_error = 3.0 * share.error;
    }
    return GP_OK;
}

void gp_run_suns_close(struct gp_run *r)
{
    if (r->suns.gl)
        gp_eye_map_close(r->suns.gl, &r->eye_map);
}

// -- the stages ---------------------------------------------------------------

gp_status gp_run_suns(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_sun_files files = {r->s, fs->job};
    const struct gp_sun_reader reader = gp_sun_reader_of(&files);
    gp_status st = gp_suns_place(fs->log, &reader, &fs->frame, &r->suns);
    if (!st)
        st = measure_outside(r, fs);
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
    if (r->s->output.debug[GP_DEBUG_SUNMAP])
        st = gp_suns_picture(fs->log, suns, false, &fs->sunmap.w,
                             &fs->sunmap.h, &fs->sunmap.planes);
    if (!st && r->s->output.debug[GP_DEBUG_INTENSITY])
        st = gp_suns_picture(fs->log, suns, true, &fs->intensity.w,
                             &fs->intensity.h, &fs->intensity.planes);
    return st;
}
