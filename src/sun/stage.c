/* Reads the suns' files, places the lights in a frame, and measures their
 * visibility. */
#include "sun/stage.h"

#include "core/memory.h"

#include <math.h>
#include <string.h>

static bool has_flux(const struct gp_light_spec *s)
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

gp_status gp_suns_begin(const struct gp_log *log, const struct gp_sun_params *p,
    enum gp_gl_api api, gp_sun_picture picture, void *user, struct gp_suns *out)
{
    struct gp_light_spec *lamps = NULL;
    int n = 0;
    gp_status st = GP_OK;
    out->p = p;
    out->api = api;
    if (p->lights)
        GP_TRY(gp_lights_read(log, p->lights, &lamps, &n));
    GP_TRY(gp_alloc(log, "lights", (size_t) (p->specs + n) + 1,
                    sizeof *out->spec, &out->spec));
    if (p->specs)
        memcpy(out->spec, p->spec, (size_t) p->specs * sizeof *p->spec);
    if (n)
        memcpy(out->spec + p->specs, lamps, (size_t) n * sizeof *lamps);
    out->specs = p->specs + n;
    if (p->camera)
        GP_TRY(gp_camera_read(log, p->camera, &out->cameras));
    if (p->flare)
        GP_TRY(gp_flare_read(log, p->flare, &out->flare));
    bool lit = p->lights || p->more_flux || (p->camera && has_flux(p->sun));
    for (int i = 0; i < p->specs; i++)
        lit |= has_flux(&p->spec[i]);
    if (gp_flare_has(&out->flare, GP_FLARE_LIGHTS) && !lit)
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE,
                          p->specs || p->camera ? "lights.sun" : "lights.flare",
                          "%s: has elements of lights, and there is no light "
                          "with flux; write \"source\": \"bright\" in it",
                          p->flare));
    for (int k = 0; k < out->flare.n; k++) {
        if (out->flare.element[k].path)
            GP_TRY(read_image(log, picture, user, &out->flare.element[k]));
    }
out:
    gp_free(lamps);
    return st;
}

// -- places of the lights ----------------------------------------------------

/* Finds the entry of --camera for a frame; NULL without --camera. */
static gp_status find_entry(const struct gp_log *log,
                            const struct gp_suns *suns,
                            const struct gp_sun_about *about,
                            const struct gp_image *f,
                            const struct gp_camera_frame **out)
{
    const char *const path = suns->p->camera;
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
                         const struct gp_sun_about *about,
                         const struct gp_image *f, struct gp_camera *out,
                         bool *found)
{
    const struct gp_camera_frame *entry;
    const enum gp_ndc asked = suns->p->ndc;
    gp_status st = find_entry(log, suns, about, f, &entry);
    *found = entry || about->has_ndc;
    if (entry)
        *out = entry->camera;
    else if (!st && about->has_ndc)
        st = gp_camera_make(log, f->path,
                            about->has_camera ? about->to_camera : NULL,
                            about->to_ndc,
                            asked == GP_NDC_AUTO ? about->ndc : asked, out);
    return st;
}

double gp_suns_fov(const struct gp_suns *suns, const struct gp_sun_about *about,
                   const struct gp_image *f)
{
    struct gp_sun_about own = *about;
    struct gp_camera camera;
    bool found;
    own.has_camera = false;
    // a matrix that is wrong is said where a light needs it
    if (gp_suns_camera(NULL, suns, &own, f, &camera, &found) || !found)
        return suns->more_fov;
    return gp_camera_fov(&camera);
}

/* The sun that the camera's file names, of a frame's entry. */
static struct gp_light_spec sun_of(const struct gp_suns *suns,
    const struct gp_camera_frame *entry, const struct gp_image *f)
{
    struct gp_light_spec spec = *suns->p->sun;
    memcpy(spec.at, entry->sun_dir, sizeof spec.at);
    spec.place = GP_PLACE_DIRECTION;
    spec.radius = -1.0;
    // pixels of the pictures that the file was written for
    if (entry->sun_radius > 0.0 && suns->p->size == 0.533f)
        spec.radius = entry->sun_radius *
                      (suns->cameras.width > 0.0
                           ? gp_rect_w(f->display) / suns->cameras.width : 1.0);
    return spec;
}

gp_status gp_suns_find(const struct gp_log *log,
                       const struct gp_sun_about *about,
                       const struct gp_image *f, struct gp_suns *suns)
{
    const struct gp_sun_params *const p = suns->p;
    const struct gp_suns_more *const more = &suns->more;
    const int all = suns->specs + more->specs;
    const struct gp_camera_frame *entry;
    struct gp_camera camera;
    bool found = false, needed = p->camera || more->specs > 0 ||
                                p->map.outside == GP_OUTSIDE_SCENE;
    gp_status st;
    // a camera that no light needs is not looked at, and may be wrong
    for (int i = 0; i < suns->specs; i++)
        needed = needed || suns->spec[i].place != GP_PLACE_PIXEL;
    GP_TRY(find_entry(log, suns, about, f, &entry));
    if (needed)
        GP_TRY(gp_suns_camera(log, suns, about, f, &camera, &found));
    if (needed && !found && more->camera) {
        found = true;
        camera = *more->camera;
    }
    // where the command line names none
    const bool sun = entry && entry->has_sun && !p->specs;
    if (all + sun > GP_LIGHTS_MAX)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: too many lights with the sun (%d); the limit is %d",
                       p->lights ? p->lights : f->path, all + sun,
                       GP_LIGHTS_MAX));
    if (entry && p->needed && !(all + sun))
        GP_TRY(gp_fail_at(log, GP_ERR_DATA, "lights.needed",
                          "%s: frame %lld has no sun_dir_world", p->camera,
                          entry->frame));
    GP_TRY(gp_alloc(log, "lights", (size_t) (all + sun),
                    sizeof *suns->light, &suns->light));
    for (int i = -(int) sun; i < all; i++) {
        const struct gp_light_spec spec =
            i < 0             ? sun_of(suns, entry, f)
            : i < suns->specs ? suns->spec[i] : more->spec[i - suns->specs];
        GP_TRY(gp_light_place_in(log, f->path, &spec, found ? &camera : NULL,
                                 p->depth_type, f->display,
                                 &suns->light[suns->n]));
        suns->n++;
    }
out:
    return st;
}

/* Warns of a plane from another file that does not cover the frame: it may be
 * the wrong file. */
static void warn_of_window(const struct gp_log *log, const struct gp_plane *p,
                           const struct gp_image *f, struct gp_suns *suns)
{
    const struct gp_rect own = gp_image_read(f);
    if (!p || !p->name || suns->warned_window)
        return;
    const struct gp_rect common = gp_rect_meet(p->window, own);
    if (memcmp(&common, &own, sizeof common) == 0)
        return;
    suns->warned_window = true;
    gp_say(log, GP_LEVEL_WARN,
           "%s: does not cover %s (its window is %dx%d at %d,%d, the frame's "
           "%dx%d at %d,%d); the rest counts as empty", p->name, f->path,
           gp_rect_w(p->window), gp_rect_h(p->window), p->window.x0,
           p->window.y0, gp_rect_w(own), gp_rect_h(own), own.x0, own.y0);
}

/* Warns once of lights before which the frame has nothing. Those that a scene
 * measures outside of it do not count. */
static void warn_of_clear(const struct gp_log *log, const struct gp_image *f,
                          struct gp_suns *suns)
{
    const bool scene = suns->p->map.outside == GP_OUTSIDE_SCENE;
    const struct gp_rect r = suns->occluders.frame;
    bool any = !scene && suns->n;
    for (int i = 0; scene && i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        any = any || (!l->behind && l->x + l->radius > r.x0 &&
                      l->x - l->radius < r.x1 && l->y + l->radius > r.y0 &&
                      l->y - l->radius < r.y1);
    }
    if (!any || suns->occluders.depth || suns->occluders.mask ||
        suns->warned_clear)
        return;
    suns->warned_clear = true;
    gp_say_at(log, GP_LEVEL_WARN, "frame.coverage",
              "%s: no depth channel and no mask: nothing hides the lights%s",
              f->path, scene ? " inside the frame" : "");
}

void gp_suns_hide(const struct gp_log *log, const struct gp_image *f,
                  const struct gp_plane *depth, const struct gp_plane *mask,
                  struct gp_suns *suns)
{
    warn_of_window(log, depth, f, suns);
    warn_of_window(log, mask, f, suns);
    suns->occluders = (struct gp_occluders) {
        .depth = depth, .mask = mask,
        .type = suns->p->depth_type,
        // a scene knows what is outside the file's pixels, and in the display
        .frame = suns->p->map.outside == GP_OUTSIDE_SCENE
                     ? gp_image_read(f)
                     : gp_rect_join(f->data, f->display),
    };
    warn_of_clear(log, f, suns);
    gp_occluders_count(&suns->occluders);
}

// -- visibility ---------------------------------------------------------------

gp_status gp_suns_measure(const struct gp_log *log, struct gp_suns *suns)
{
    const struct gp_sun_params *const p = suns->p;
    if (!suns->n)
        return GP_OK;
    if (p->method == GP_SUN_EXACT) {
        gp_sun_exact(&suns->occluders, p->map.outside, suns->light, suns->n);
        return GP_OK;
    }
    gp_status st = suns->gl ? gp_gl_use(log, suns->gl)
                            : gp_gl_open(log, suns->api, &suns->gl);
    if (st)
        return st;
    return (p->method == GP_SUN_MASK ? gp_sun_mask : gp_sun_readback)(
        log, suns->gl, &suns->occluders, &p->map, suns->light, suns->n,
        &suns->map);
}

double gp_suns_mean(const struct gp_suns *suns)
{
    double sum = 0.0, weight = 0.0, plain = 0.0;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        const double flux = (double) l->flux[0] + (double) l->flux[1] +
                            (double) l->flux[2];
        sum += flux * l->visibility;
        weight += flux;
        plain += l->visibility;
    }
    return weight > 0.0 ? sum / weight : suns->n ? plain / suns->n : 0.0;
}

void gp_suns_end_frame(struct gp_suns *suns)
{
    suns->occluders = (struct gp_occluders) {0};
    GP_FREE(suns->light);
    suns->n = 0;
}

void gp_suns_close(struct gp_suns *suns)
{
    gp_suns_end_frame(suns);
    if (suns->map)
        gp_sun_map_close(suns->gl, &suns->map);
    if (suns->gl)
        gp_gl_close(&suns->gl);
    gp_flare_free(&suns->flare);
    gp_camera_file_free(&suns->cameras);
    gp_free(suns->spec);
    *suns = (struct gp_suns) {0};
}
