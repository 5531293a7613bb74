/* The share of lights that the frame does not show, by the scene
 * (--sun-outside scene). */
#include "app/stages.h"

#include <math.h>

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
static gp_status measure(const struct gp_log *log, struct gp_run *r,
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

gp_status gp_run_outside(struct gp_run *r, struct gp_frame_state *fs)
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
        st = measure(fs->log, r, &disc, &window, &share);
        if (!st && share.outside == 0.0 && leaves(l, known))
            st = measure(fs->log, r, &disc, NULL, &share);
        if (st)
            return st;
        l->outside = share.clear;
        l->outside_error = 3.0 * share.error;
    }
    return GP_OK;
}

void gp_run_outside_close(struct gp_run *r)
{
    if (r->suns.gl)
        gp_eye_map_close(r->suns.gl, &r->eye_map);
}
