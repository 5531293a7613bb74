// SPDX-License-Identifier: Apache-2.0
/* Reads the suns' files, places the lights in a frame and measures their visibility. */
#include "sun/stage.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "sun/found.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static bool has_flux(const struct glarepp_light *s)
{
    return s->flux[0] > 0.0f || s->flux[1] > 0.0f || s->flux[2] > 0.0f;
}

/* Reads the image of an element, which becomes light: no NaN, no negative
 * values. */
static gp_status read_image(const struct gp_log *log, gp_sun_picture picture,
                            void *user, struct gp_flare_element *e)
{
    struct gp_image image = {0};
    const gp_status st = picture(user, log, e->path, &image);
    if (st)
        return st;
    const int w = gp_image_w(&image), h = gp_image_h(&image);
    for (int c = 0; c < 3; c++) {
        float *const v = image.rgb.c[c];
        for (size_t i = 0; i < gp_image_pixels(&image); i++)
            v[i] = v[i] > 0.0f && v[i] <= 1e30f ? v[i] : 0.0f;
    }
    e->image = (struct gp_flare_image) {
        .w = w, .h = h, .cx = 0.5 * w, .cy = 0.5 * h, .rgb = image.rgb,
    };
    image.rgb = (struct gp_planes) {0};
    gp_image_free(&image);
    return GP_OK;
}

/* The lights that have a place, of the run and then of the frame. */
static const struct glarepp_light *spec_at(const struct gp_suns *suns, int i)
{
    return i < suns->specs ? &suns->spec[i] : &suns->more[i - suns->specs];
}

gp_status gp_suns_begin(const struct gp_log *log, const struct glarepp_light_params *p,
    enum gp_gl_api api, gp_sun_picture picture, void *user, struct gp_suns *out)
{
    struct glarepp_light *read = NULL;
    int reads = 0, n = 0;
    gp_status st = GP_OK;
    out->p = p;
    out->api = api;
    if (p->file)
        GP_TRY(gp_lights_read(log, p->file, &read, &reads));
    if (p->cameras)
        GP_TRY(gp_camera_read(log, p->cameras, &out->cameras));
    if (p->flare)
        GP_TRY(gp_flare_read(log, p->flare, &out->flare));
    bool lit = p->file || p->faded || (p->cameras && has_flux(&p->sun));
    for (int i = 0; i < p->lights; i++)
        lit |= has_flux(&p->light[i]);
    if (gp_flare_has(&out->flare, GP_FLARE_LIGHTS) && !lit && out->given &&
        !p->found)
        GP_TRY(
            gp_fail_at(log, GP_ERR_USAGE,
                       p->lights || p->cameras ? "lights.sun" : "lights.flare",
                       "%s: has elements of lights, and there is no light "
                       "with flux; write \"source\": \"bright\" in it",
                       p->flare));
    const int all = p->lights + reads;
    GP_TRY(gp_alloc(log, "lights", (size_t) all + 1, sizeof *out->spec,
                    &out->spec));
    GP_TRY(gp_alloc(log, "lights", (size_t) all + 1, sizeof *out->known,
                    &out->known));
    for (int i = 0; i < 2 * all; i++) { // those with a place first
        const int k = i % all;
        const struct glarepp_light *const l =
            k < p->lights ? &p->light[k] : &read[k - p->lights];
        if ((l->place == GLAREPP_FOUND) == (i >= all))
            out->spec[n++] = *l;
        out->specs = i < all ? n : out->specs;
    }
    out->track = out->spec + out->specs;
    out->tracks = all - out->specs;
    out->knowns = gp_lights_at(out->track, out->tracks, 0.0, out->known);
    for (int k = 0; k < out->flare.n; k++) {
        if (out->flare.element[k].path)
            GP_TRY(read_image(log, picture, user, &out->flare.element[k]));
    }
out:
    gp_free(read);
    return st;
}

// -- places of the lights ----------------------------------------------------

/* Finds the entry of --camera for a frame; NULL without --camera. */
static gp_status find_entry(const struct gp_log *log,
                            const struct gp_suns *suns,
                            const struct glarepp_frame_params *about,
                            const struct gp_image *f,
                            const struct gp_camera_frame **out)
{
    const char *const path = suns->p->cameras;
    *out = NULL;
    if (!path)
        return GP_OK;
    *out = gp_camera_frame_find(&suns->cameras,
                                about->numbered ? about->number : -1);
    if (!*out && about->numbered)
        return gp_fail_at(log, GP_ERR_DATA, "lights.cameras.frame",
                          "%s: no camera for frame %d of %s; add it", path,
                          about->number, f->path);
    if (!*out)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: %s has no frame number to find its camera by; "
                       "add one to its name, or keep one camera in the "
                       "file", path, f->path);
    return GP_OK;
}

gp_status gp_suns_camera(const struct gp_log *log, const struct gp_suns *suns,
                         const struct glarepp_frame_params *about,
                         const struct gp_image *f, struct gp_camera *out,
                         bool *found)
{
    const struct gp_camera_frame *entry;
    const enum glarepp_ndc asked = suns->p->ndc;
    gp_status st = find_entry(log, suns, about, f, &entry);
    *found = entry || about->has_ndc || suns->wide.kind;
    if (!st && suns->wide.kind)
        return gp_camera_wide(log, f->path,
                              entry && entry->camera.has_camera
                                  ? entry->camera.to_camera
                              : about->has_camera ? about->to_camera
                                                  : NULL,
                              &suns->wide, out);
    if (entry)
        *out = entry->camera;
    else if (!st && about->has_ndc)
        st = gp_camera_make(log, f->path,
                            about->has_camera ? about->to_camera : NULL,
                            about->to_ndc, asked ? asked : about->ndc, out);
    return st;
}

/* The sun that the camera's file names, of a frame's entry. */
static struct glarepp_light sun_of(const struct gp_suns *suns,
    const struct gp_camera_frame *entry, const struct gp_image *f)
{
    struct glarepp_light spec = suns->p->sun;
    memcpy(spec.at, entry->sun_dir, sizeof spec.at);
    spec.place = GLAREPP_DIRECTION;
    spec.radius = -1.0;
    // pixels of the pictures that the file was written for
    if (entry->sun_radius > 0.0 && suns->p->degrees == 0.533f)
        spec.radius = entry->sun_radius *
                      (suns->cameras.width > 0.0
                           ? gp_rect_w(f->display) / suns->cameras.width : 1.0);
    return spec;
}

gp_status gp_suns_find(const struct gp_log *log,
                       const struct glarepp_frame_params *about,
                       const struct gp_image *f, struct gp_suns *suns)
{
    const struct glarepp_light_params *const p = suns->p;
    const int all = suns->specs + suns->mores;
    const struct gp_camera_frame *entry;
    struct gp_camera camera;
    bool found = false, needed = p->cameras || suns->mores > 0 || suns->camera;
    gp_status st;
    GP_FREE(suns->light);
    suns->n = suns->placed = 0;
    // a camera that no light needs is not looked at, and may be wrong
    for (int i = 0; i < suns->specs; i++)
        needed = needed || suns->spec[i].place != GLAREPP_PIXEL;
    GP_TRY(find_entry(log, suns, about, f, &entry));
    if (needed)
        GP_TRY(gp_suns_camera(log, suns, about, f, &camera, &found));
    if (needed && !found && suns->camera) {
        found = true;
        camera = *suns->camera;
    }
    // where the command line names none
    const bool sun = entry && entry->has_sun && !p->lights;
    if (all + sun > GP_LIGHTS_MAX)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: too many lights with the sun (%d); the limit is %d",
                       p->file ? p->file : f->path, all + sun,
                       GP_LIGHTS_MAX));
    if (entry && p->needed && !(all + sun))
        GP_TRY(gp_fail_at(log, GP_ERR_DATA, "lights.needed",
                          "%s: frame %lld has no sun_dir_world", p->cameras,
                          entry->frame));
    GP_TRY(gp_alloc(log, "lights", (size_t) (all + sun),
                    sizeof *suns->light, &suns->light));
    for (int i = -(int) sun; i < all; i++) {
        const struct glarepp_light spec = i < 0 ? sun_of(suns, entry, f)
                                                : *spec_at(suns, i);
        GP_TRY(gp_light_place_in(log, f->path, &spec, found ? &camera : NULL,
                                 p->depth, f->display, &suns->light[suns->n]));
        suns->placed = ++suns->n;
    }
out:
    return st;
}

/* Tests whether a light has a place on whose disc is a centre. */
static bool is_placed(const struct gp_suns *suns, const struct gp_light *found)
{
    static const double NEAR = 2.0; // pixels
    for (int i = 0; i < suns->placed; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (!l->behind && gp_hypot(l->x - found->x, l->y - found->y) <
                              fmax(l->radius, found->radius) + NEAR)
            return true;
    }
    return false;
}

gp_status gp_suns_spot(const struct gp_log *log, const struct gp_sources *src,
                       const struct gp_image *f,
                       const struct glarepp_light *known, int knowns, int most,
                       bool *wide, struct gp_suns *suns)
{
    struct gp_light *found = NULL, *all;
    int n, kept = 0, fresh = 0, named = 0;
    gp_status st;
    GP_TRY(gp_lights_find(log, src, f, &found, &n, wide));
    GP_TRY(gp_lights_name(log, found, n, known, knowns, gp_rect_h(f->display)));
    GP_TRY(gp_alloc(log, "lights", (size_t) (suns->placed + n) + 1, sizeof *all,
                    &all));
    for (int i = 0; i < suns->placed; i++)
        all[i] = suns->light[i];
    for (int i = 0; i < n; i++)
        named += found[i].name[0] != '\0';
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &found[i];
        if (is_placed(suns, l) || (!l->name[0] && named + fresh >= most))
            continue;
        if (!l->name[0])
            snprintf(l->name, sizeof l->name, "%s%d", knowns ? "new" : "lamp",
                     ++fresh);
        all[suns->placed + kept++] = *l;
    }
    gp_free(suns->light);
    suns->light = all;
    suns->n = suns->placed + kept;
out:
    gp_free(found);
    return st;
}

/* Warns of a plane from another file, which has a name, that does not cover the frame:
 * it may be the wrong file. */
static void warn_of_window(const struct gp_log *log, const char *name,
                           struct gp_rect w, const struct gp_image *f,
                           struct gp_suns *suns)
{
    const struct gp_rect own = gp_image_read(f), common = gp_rect_meet(w, own);
    if (!name || suns->warned_window)
        return;
    if (memcmp(&common, &own, sizeof common) == 0)
        return;
    suns->warned_window = true;
    gp_say(log, GP_LEVEL_WARN,
           "%s: does not cover %s (its window is %dx%d at %d,%d, the frame's "
           "%dx%d at %d,%d); the rest counts as empty",
           name, f->path, gp_rect_w(w), gp_rect_h(w), w.x0, w.y0,
           gp_rect_w(own), gp_rect_h(own), own.x0, own.y0);
}

/* Tests whether a light's disc may have a part in the frame. */
static bool is_seen(const struct gp_light *l, struct gp_rect frame)
{
    const double q = gp_light_stretch(l), u = l->radius * q + 1.0,
                 v = l->radius / q + 1.0;
    return !l->behind && l->x + u > frame.x0 && l->x - u < frame.x1 &&
           l->y + v > frame.y0 && l->y - v < frame.y1;
}

/* Warns once of lights before which the frame has nothing. Those that a scene
 * measures do not count. */
static void warn_of_clear(const struct gp_log *log, const struct gp_image *f,
                          struct gp_suns *suns)
{
    const bool scene = suns->p->outside == GLAREPP_BY_SCENE;
    bool any = false;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        any |= !l->traced && (!scene || is_seen(l, suns->occluders.frame));
    }
    if (!any || suns->occluders.depth || suns->occluders.mask ||
        suns->occluders.deep || suns->warned_clear)
        return;
    suns->warned_clear = true;
    gp_say_at(log, GP_LEVEL_WARN, "frame.coverage",
              "%s: no depth channel and no mask: nothing hides the lights%s",
              f->path, scene ? " inside the frame" : "");
}

void gp_suns_hide(const struct gp_log *log, const struct gp_image *f,
                  const struct gp_plane *depth, const struct gp_plane *mask,
                  const struct gp_deep *deep, struct gp_suns *suns)
{
    if (depth)
        warn_of_window(log, depth->name, depth->window, f, suns);
    if (mask)
        warn_of_window(log, mask->name, mask->window, f, suns);
    if (deep)
        warn_of_window(log, deep->name, deep->window, f, suns);
    suns->occluders = (struct gp_occluders) {
        .depth = depth,
        .mask = mask,
        .deep = deep,
        .type = suns->p->depth,
        // a scene knows what is outside the file's pixels, and in the display
        .frame = suns->p->outside == GLAREPP_BY_SCENE
                     ? gp_image_read(f)
                     : gp_rect_join(f->data, f->display),
        .around = gp_suns_around(suns),
    };
    warn_of_clear(log, f, suns);
    gp_occluders_count(&suns->occluders);
}

// -- visibility ---------------------------------------------------------------

gp_status gp_suns_measure(const struct gp_log *log, struct gp_suns *suns)
{
    const struct glarepp_light_params *const p = suns->p;
    if (!suns->n)
        return GP_OK;
    // closed forms where no channel can hide any
    bool hides = false;
    for (int i = 0; i < suns->n; i++)
        hides |= (suns->occluders.depth || suns->occluders.mask) &&
                 is_seen(&suns->light[i], suns->occluders.frame);
    if (p->method == GLAREPP_EXACT || !hides) {
        gp_sun_exact(&suns->occluders, p->outside, suns->light, suns->n);
        return GP_OK;
    }
    gp_status st = suns->gl ? gp_gl_use(log, suns->gl)
                            : gp_gl_open(log, suns->api, &suns->gl);
    if (st)
        return st;
    return gp_sun_by_gl(log, suns->gl, &suns->occluders, p, suns->light,
                        suns->n, &suns->map);
}

double gp_suns_mean(const struct gp_suns *suns)
{
    double sum = 0.0, weight = 0.0, plain = 0.0;
    for (int i = 0; i < suns->placed; i++) {
        const struct gp_light *const l = &suns->light[i];
        const double flux = (double) l->flux[0] + (double) l->flux[1] +
                            (double) l->flux[2];
        sum += flux * l->visibility;
        weight += flux;
        plain += l->visibility;
    }
    return weight > 0.0   ? sum / weight
           : suns->placed ? plain / suns->placed
                          : 0.0;
}

// -- the end ------------------------------------------------------------------

void gp_suns_end_frame(struct gp_suns *suns)
{
    suns->occluders = (struct gp_occluders) {0};
    GP_FREE(suns->light);
    suns->n = suns->placed = 0;
}

void gp_suns_close(struct gp_suns *suns)
{
    gp_suns_end_frame(suns);
    gp_sun_map_close(suns->gl, &suns->map);
    gp_gl_close(&suns->gl);
    gp_flare_free(&suns->flare);
    gp_camera_file_free(&suns->cameras);
    gp_free(suns->spec);
    gp_free(suns->known);
    *suns = (struct gp_suns) {0};
}
