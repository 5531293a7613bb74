// SPDX-License-Identifier: Apache-2.0
/* Suns and lamps of a frame: their places, shares and flare. */
#include "api/plan.h"

#include "core/clock.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

static gp_status read_picture(void *user, const struct gp_log *log,
                              const char *path, struct gp_image *out)
{
    return gp_api_picture(user, log, path, out, NULL);
}

gp_status gp_api_lights_begin(struct glarepp_plan *plan,
                              struct gp_api_work *work)
{
    gp_api_about("lights");
    const gp_status st = gp_alloc_zero(&plan->log, "lights", 1,
                                       sizeof *work->lights, &work->lights);
    if (!st)
        work->lights->suns.given = plan->lights;
    return st ? st
              : gp_suns_begin(&plan->log, &plan->sun, plan->glare.gl,
                              read_picture, plan->gp, &work->lights->suns);
}

void gp_api_lights_end(struct gp_api_lights **lights)
{
    struct gp_api_ghosts *const ghosts[] = {&(*lights)->ghosts,
                                            &(*lights)->group_ghosts};
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < ghosts[k]->engines; i++)
            gp_glare_close(&ghosts[k]->engine[i]);
        gp_free(ghosts[k]->engine);
        gp_ghosts_free(&ghosts[k]->set);
    }
    gp_suns_close(&(*lights)->suns);
    GP_FREE(*lights);
}

// -- shares by the scene ------------------------------------------------------

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
               ? gp_eye_lamp(eye, at,
                             gp_sin(s->half) * gp_v3_length(gp_v3_sub(at, eye)))
               : gp_eye_sun(eye, at, s->half);
}

/* Tests whether the scene's rays are for all of a light, or all in the frame: it has a
 * place there. */
static bool is_traced(const struct glarepp_frame *f, const struct gp_light *l)
{
    const struct glarepp_light_params *const p = &f->plan->sun;
    return f->work->scene && l->sight.known &&
           (l->sight.lamp || isinf(l->depth)) &&
           (p->share_by == GLAREPP_SHARES_SCENE ||
            (p->share_by == GLAREPP_SHARES_AUTO && p->method == GLAREPP_EXACT &&
             f->work->scene->scene.objects > 0));
}

/* Warns once where the frame's own planes say another share than the scene: of the
 * light that is furthest off. */
static void check_shares(struct glarepp_frame *f)
{
    const struct gp_suns *const suns = &f->work->lights->suns;
    const struct gp_occluders *const o = &suns->occluders;
    struct gp_light worst = {0};
    double most = 0.0;
    int more = -1;
    char others[32] = "";
    for (int i = 0; (o->depth || o->mask || o->deep) && i < suns->n; i++) {
        struct gp_light own = suns->light[i];
        if (!own.traced)
            continue;
        own.traced = false;
        gp_sun_exact(o, GLAREPP_IGNORE, &own, 1);
        gp_sun_interval(o, GLAREPP_IGNORE, &own, 1); // any share outside of it
        const double apart = fmax(own.low - own.outside - own.outside_error,
                                  own.outside - own.outside_error - own.high);
        more += own.in_frame && apart > 0.0;
        if (own.in_frame && apart > most) {
            most = apart;
            worst = own;
        }
    }
    if (more < 0 || !gp_api_says(&f->plan->said, GP_SAID_SHARE))
        return;
    if (more)
        snprintf(others, sizeof others, " (%d more differ)", more);
    gp_say_at(&f->log, GP_LEVEL_WARN, "lights.share_by.scene",
              "%s: the scene shows %.3f of the light %s%sat %.1f,%.1f, and the "
              "frame %.3f to %.3f%s: one has what the other has not",
              f->sink.name, worst.outside, worst.name, worst.name[0] ? " " : "",
              worst.x, worst.y, worst.low, worst.high, others);
}

/* Sets each light's clear share by the scene's rays: outside of the frame, or of
 * all of it; where another rule is for what is outside, of those traced only. */
static gp_status measure_by_scene(struct glarepp_frame *f, int traced)
{
    const enum glarepp_outside by = f->plan->sun.outside;
    const bool ruled = by != GLAREPP_BY_SCENE;
    struct gp_api_scene *const scene = f->work->scene;
    struct gp_suns *const suns = &f->work->lights->suns;
    const struct gp_rect known = suns->occluders.frame;
    if (suns->n == 0 || (ruled && traced == 0))
        return GP_OK;
    if (!scene || !scene->has_camera)
        return gp_api_refuse(
            f, "lights.outside",
            "shares outside of the frame by a scene need a camera (the frame "
            "has no worldToNDC, %s no camera)",
            f->plan->scene.path);
    const struct gp_eye_window window = {&scene->frame_camera, f->image.display,
                                         known, ruled};
    const struct gp_v3 eye = gp_camera_eye(&scene->frame_camera);
    for (int i = 0; i < suns->n; i++) {
        struct gp_light *const l = &suns->light[i];
        const struct gp_eye_disc disc = disc_of(l, eye);
        struct gp_eye_share share;
        if (ruled && !l->traced)
            continue;
        gp_status st =
            gp_eye_rays(&f->log, &scene->scene, &scene->meshes, &disc,
                        l->traced && !ruled ? NULL : &window, &share);
        if (!st && !ruled && share.part == 0.0 && leaves(l, known))
            st = gp_eye_rays(&f->log, &scene->scene, &scene->meshes, &disc,
                             NULL, &share);
        if (st)
            return st;
        l->outside = share.clear;
        l->outside_error = 3.0 * share.error;
        if (!ruled)
            continue;
        const double rest = 1.0 - share.part; // whose share is not known
        if (by != GLAREPP_IGNORE || share.part == 0.0)
            l->outside = share.part * share.clear +
                         (by == GLAREPP_VISIBLE && !l->behind ? rest : 0.0);
        l->outside_error = share.part * l->outside_error + rest;
    }
    check_shares(f);
    return GP_OK;
}

// -- steps --------------------------------------------------------------------

gp_status gp_api_place(struct glarepp_frame *f)
{
    struct gp_suns *const suns = &f->work->lights->suns;
    const gp_status st = gp_suns_find(&f->log, &f->p, &f->image, suns);
    f->facts.lights = st ? 0 : suns->n;
    return st;
}

/* Copies the facts about lights, whose state the next frame reuses. */
static gp_status note_shares(struct glarepp_frame *f)
{
    struct gp_suns *const suns = &f->work->lights->suns;
    const struct gp_occluders *const o = &suns->occluders;
    GP_FREE(f->share);
    const gp_status st = gp_alloc_zero(&f->log, "lights", (size_t) suns->n + 1,
                                       sizeof *f->share, &f->share);
    if (st)
        return st;
    if (f->p.details)
        gp_sun_interval(o, suns->p->outside, suns->light, suns->placed);
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        struct glarepp_share *const s = &f->share[i];
        *s = (struct glarepp_share) {
            .x = l->x,
            .y = l->y,
            .radius = l->radius,
            .depth = l->depth,
            .flux = {l->flux[0], l->flux[1], l->flux[2]},
            .behind = l->behind,
            .in_frame = l->in_frame,
            .visibility = l->visibility,
            .low = l->low,
            .high = l->high,
            .found = l->found,
        };
        memcpy(s->name, l->name, sizeof s->name);
        // those of the scene are the last that have a place
        const int own = i - (suns->placed - suns->mores);
        if (own >= 0 && own < suns->mores &&
            f->work->scene->scene.light[own].kind == GP_LIGHT_DIRECTIONAL)
            s->sun_degrees = gp_api_sun_size(
                f->plan, &f->work->scene->scene.light[own], &s->sun_from);
    }
    f->facts.light = f->share;
    f->facts.lights = suns->n;
    if (o->depth) {
        memcpy(f->facts.depth_empty, o->empty, sizeof o->empty);
        f->facts.depth_reversed = o->reversed;
    }
    return GP_OK;
}

gp_status gp_api_shares(struct glarepp_frame *f)
{
    static const char *const methods[] = {
        [GLAREPP_EXACT] = "exact", [GLAREPP_MASK] = "mask",
        [GLAREPP_READBACK] = "readback",
    };
    struct gp_suns *const suns = &f->work->lights->suns;
    int traced = 0;
    for (int i = 0; i < suns->n; i++) {
        suns->light[i].traced = is_traced(f, &suns->light[i]);
        traced += suns->light[i].traced;
    }
    if (f->deep.first && f->plan->sun.method != GLAREPP_EXACT)
        return gp_api_refuse(f, "lights.method",
                             "GL has no samples of deep pixels");
    if (!f->hidden)
        gp_suns_hide(&f->log, &f->image, f->depth.v ? &f->depth : NULL,
                     f->mask.v ? &f->mask : NULL,
                     f->deep.first ? &f->deep : NULL, suns);
    f->hidden = true;
    gp_status st = measure_by_scene(f, traced);
    if (!st)
        st = gp_suns_measure(&f->log, suns);
    if (!st && suns->gl)
        f->facts.shares_gl = gp_gl_info(suns->gl)->name;
    if (f->plan->lights)
        f->facts.shares_by = !traced            ? methods[f->plan->sun.method]
                             : traced < suns->n ? "scene and frame"
                                                : "scene";
    return st || !f->plan->lights ? st : note_shares(f);
}

/* Tests whether bright pixels at a light's own place hide it: they are the light;
 * warns if it `says` so. */
static bool is_hidden(struct glarepp_frame *f, const struct gp_light *l,
                      bool says)
{
    const struct gp_image *const image = &f->image;
    const struct gp_suns *const suns = &f->work->lights->suns;
    const int x = (int) floor(l->x), y = (int) floor(l->y);
    const struct gp_rect data = image->data;
    if (l->behind || l->visibility > 0.0 || x < data.x0 || x >= data.x1 ||
        y < data.y0 || y >= data.y1)
        return false;
    const double depth = gp_occluders_at(&suns->occluders, x, y).place;
    const size_t at = (size_t) (y - data.y0) * (size_t) gp_rect_w(data) +
                      (size_t) (x - data.x0);
    float own = 0.0f;
    for (int c = 0; c < 3; c++)
        own += image->luminance[c] * image->rgb.c[c][at];
    if (!(own > f->sources.threshold && depth < l->depth))
        return false;
    if (says)
        gp_say_at(
            &f->log, GP_LEVEL_WARN, "lights.depth_there",
            "%s: the light %s%sat %.1f,%.1f is hidden by bright pixels at "
            "its own place (depth %.6g, the light's %.6g)",
            f->sink.name, l->name, l->name[0] ? " " : "", l->x, l->y, depth,
            l->depth);
    return true;
}

void gp_api_warn_of_lights(struct glarepp_frame *f)
{
    static const double MANY = 1000.0;
    const struct gp_suns *const suns = &f->work->lights->suns;
    const double brightest = // or nearly: at most by the threshold more
        f->sources.n
            ? (double) f->sources.brightest + (double) f->sources.threshold
            : (double) f->facts.sense.peak;
    const bool says = !(f->plan->said >> GP_SAID_HIDDEN & 1);
    for (int i = 0; i < suns->placed; i++) {
        const struct gp_light *const l = &suns->light[i];
        double own = 0.0, there;
        if (is_hidden(f, l, says)) // all of the first frame that has some
            (void) gp_api_says(&f->plan->said, GP_SAID_HIDDEN);
        for (int c = 0; c < 3; c++)
            own += (double) f->image.luminance[c] * (double) l->flux[c];
        own /= gp_suns_pixels(suns, l, &there);
        if (!(own > 0.0) || l->behind || f->plan->sun.in_frame)
            continue;
        if (own > MANY * brightest && brightest > 0.0 &&
            gp_api_says(&f->plan->said, GP_SAID_BRIGHT))
            gp_say_at(&f->log, GP_LEVEL_WARN, "lights.flux",
                      "%s: the light %s%sis about %.0f times as bright as the "
                      "brightest pixel (%.3g a pixel, %.3g)",
                      f->sink.name, l->name, l->name[0] ? " " : "",
                      own / brightest, own, brightest);
    }
}

/* Finds the lights that the frame shows. Those of the first frame become known. */
gp_status gp_api_spot(struct glarepp_frame *f)
{
    struct glarepp_plan *const names = f->plan->names;
    struct gp_suns *const suns = &f->work->lights->suns;
    const bool listed = suns->knowns;
    const int most = f->plan->sun.found ? f->plan->sun.found
                     : listed           ? 0
                                        : GP_FOUND_USUAL;
    bool wide;
    (void) gp_lights_at(suns->track, suns->tracks,
                        f->p.numbered ? f->p.number : 0.0, suns->known);
    pthread_mutex_lock(&names->lock);
    // all of it: frames may wait for the first
    const int knowns = listed ? suns->knowns : names->knowns;
    const gp_status st = gp_suns_spot(&f->log, &f->sources, &f->image,
                                      listed ? suns->known : names->known,
                                      knowns, most, &wide, suns);
    for (int i = suns->placed; i < suns->n && !st && !knowns; i++) {
        const struct gp_light *const l = &suns->light[i];
        struct glarepp_light *const k = &names->known[names->knowns++];
        *k = (struct glarepp_light) GLAREPP_LIGHT;
        k->place = GLAREPP_FOUND;
        k->at[0] = l->x;
        k->at[1] = l->y;
        memcpy(k->flux, l->flux, sizeof k->flux);
        memcpy(k->name, l->name, sizeof k->name);
    }
    pthread_mutex_unlock(&names->lock);
    if (st)
        return st;
    if (wide && !suns->n && gp_api_says(&names->said, GP_SAID_WIDE))
        gp_say_at(
            &f->log, GP_LEVEL_WARN, "lights.wide",
            "%s: no light is found: what is bright is wider than a quarter "
            "of the picture's height",
            f->sink.name);
    return note_shares(f);
}

gp_status gp_api_flare(struct glarepp_frame *f)
{
    struct gp_suns *const suns = &f->work->lights->suns;
    struct glarepp_flare_facts *const facts = &f->facts.flare;
    const bool seen = gp_suns_have_light(suns, true);
    const float gain = f->plan->sun.flare_gain;
    struct gp_planes before = {0};
    gp_status st = GP_OK;
    suns->flare.frame = f->p.numbered ? f->p.number : 0;
    if (seen)
        GP_TRY(gp_api_dark_layer(&f->log, &f->image));
    GP_TRY(gp_suns_draw(&f->log, suns, gp_api_kernel(f, 0), &f->image));
    if (!suns->flare.n)
        return st;
    facts->gain = 1.0;
    if (f->p.parts || gain != 1.0f)
        GP_TRY(gp_api_part_open(f, &f->image, &before));
    if (seen)
        GP_TRY(gp_flare_add(&f->log, &suns->flare, suns->light, suns->n,
                            f->image.data, f->image.display, &f->image.layer));
    const double cpu = gp_cpu_ms();
    GP_TRY(gp_api_ghosts_add(f, &f->sources, &f->work->lights->ghosts,
                             &f->image, facts));
    f->facts.engines_ms = facts->ms;
    f->facts.engines_cpu_ms = gp_cpu_ms() - cpu;
    if (before.c[0])
        facts->gain = gp_api_part_level(f, &f->image, gain);
out:
    if (before.c[0])
        gp_api_part_close(f, &f->image, facts->gain, &before,
                          &f->part[GLAREPP_PART_FLARE - GLAREPP_PART_VEIL]);
    return st;
}

// -- flare of bright pixels ---------------------------------------------------

/* A run's layer, to be added to the frame's, row by row. */
struct adding {
    const struct gp_image *from; // of the run's window
    struct gp_image *to;
    double *sum;                 // of squares, for each row of `from`: of all
                                 // pixels, then of those of the frame
};

static void add_row(void *ctx, int y, int thread)
{
    const struct adding *const a = ctx;
    const struct gp_rect in = a->from->data, to = a->to->data;
    const size_t w = (size_t) gp_rect_w(in);
    const int row = in.y0 + y - to.y0;
    const int first = to.x0 - in.x0, end = to.x1 - in.x0;
    double all = 0.0, own = 0.0;
    (void) thread;
    for (int c = 0; c < 3; c++) {
        const float *const v = a->from->layer.c[c] + (size_t) y * w;
        for (size_t x = 0; x < w; x++)
            all += (double) v[x] * (double) v[x];
        if (row < 0 || row >= gp_rect_h(to))
            continue;
        float *const out = a->to->layer.c[c] +
                           (size_t) row * (size_t) gp_rect_w(to);
        for (int x = first; x < end; x++) {
            own += (double) v[x] * (double) v[x];
            out[x - first] =
                gp_maxf(gp_minf(out[x - first] + v[x], FLT_MAX), -FLT_MAX);
        }
    }
    a->sum[2 * y] = all;
    a->sum[2 * y + 1] = own;
}

gp_status gp_api_add_layer(const struct gp_log *log,
                           const struct gp_image *from, struct gp_image *image,
                           double norm2[2])
{
    const int h = gp_image_h(from);
    struct adding a = {from, image, NULL};
    const gp_status st =
        gp_alloc(log, "layer", 2 * (size_t) h, sizeof *a.sum, &a.sum);
    if (st)
        return st;
    gp_parallel_do(h, add_row, &a);
    for (int y = 0; y < h; y++) {
        norm2[0] += a.sum[2 * y];
        norm2[1] += a.sum[2 * y + 1];
    }
    gp_free(a.sum);
    return GP_OK;
}

double gp_api_error_of(double bound, double norm2)
{
    // the exact layer's norm is at most that of the layer / (1 - bound)
    return bound < 1.0 ? bound * sqrt(norm2) / (1.0 - bound) : INFINITY;
}

double gp_api_bound_of(double error, double norm)
{
    return error < norm ? error / (norm - error) : INFINITY;
}

/* Adds one run's layer; norm2 and *stats stay 0 where it has no light. */
static gp_status add_run(struct glarepp_frame *f, const struct gp_sources *src,
    struct gp_api_ghosts *ghosts, int i, struct gp_image *image,
    double norm2[2], struct glarepp_layer_facts *stats)
{
    const struct gp_ghost *const run = &ghosts->set.run[i];
    struct gp_image window = {.path = image->path, .display = image->display};
    struct gp_glare_params p = f->plan->glare;
    struct gp_sources moved = {0};
    gp_status st = gp_ghost_move(&f->log, &ghosts->set, run, src, &moved);
    p.tolerance_pixel = 0.0f; // a window has no picture to be relative to
    window.data = (struct gp_rect) {moved.x0, moved.y0, moved.x0 + moved.w,
                                    moved.y0 + moved.h};
    if (!st && moved.n)
        st = gp_glare_run(&f->log, &p, &ghosts->engine[i], &moved, &run->kernel,
                          &window, stats);
    if (!st && moved.n)
        st = gp_api_add_layer(&f->log, &window, image, norm2);
    gp_planes_free(&window.layer);
    gp_sources_free(&moved);
    return st;
}

gp_status gp_api_ghosts_add(struct glarepp_frame *f,
    const struct gp_sources *src, struct gp_api_ghosts *ghosts,
    struct gp_image *image, struct glarepp_flare_facts *facts)
{
    const struct gp_flare *const flare = &f->work->lights->suns.flare;
    const double start = gp_now_ms();
    double error = 0.0; // norm of the errors
    double light = 0.0; // squared norms of the layers
    gp_status st = GP_OK;
    if (!src->n || !gp_flare_has(flare, GP_FLARE_BRIGHT))
        return GP_OK;
    GP_TRY(gp_ghosts_make(&f->log, flare, image->data, image->display,
                          &ghosts->set));
    if (!ghosts->engine)
        GP_TRY(gp_alloc_zero(&f->log, "engines", (size_t) ghosts->set.n,
                             sizeof *ghosts->engine, &ghosts->engine));
    ghosts->engines = ghosts->set.n;
    GP_TRY(gp_api_dark_layer(&f->log, image));
    for (int i = 0; i < ghosts->set.n; i++) {
        const struct gp_ghost *const run = &ghosts->set.run[i];
        struct glarepp_layer_facts stats = {0};
        double norm2[2] = {0};
        if (!run->kernel.w)
            continue;
        GP_TRY(add_run(f, src, ghosts, i, image, norm2, &stats));
        if (!stats.engine)
            continue;
        facts->engine = !facts->runs || facts->engine == stats.engine
                            ? stats.engine : "several";
        facts->elements += run->elements;
        facts->runs++;
        error += gp_api_error_of(stats.bound, norm2[0]) +
                 run->split * sqrt(norm2[0]);
        light += norm2[1]; // no layer is negative: their sum has no less
    }
    facts->bound = gp_api_bound_of(error, sqrt(light));
    facts->ms = gp_now_ms() - start;
out:
    return st;
}
