/* Reads the suns' files, places the lights in a frame, and measures their
 * visibility. */
#include "sun/stage.h"

#include "core/memory.h"
#include "sun/sun_priv.h"

#include <math.h>
#include <string.h>

/* The sun of --sun or --sun-dir. */
static struct gp_light_spec sun_spec(const struct gp_sun_params *p)
{
    if (p->sun)
        return *p->sun;
    const struct gp_light usual = GP_LIGHT_DEFAULTS;
    const struct gp_numbers *const color = &p->color;
    struct gp_light_spec spec = {
        .place = p->at.n ? GP_PLACE_PIXEL : GP_PLACE_DIRECTION,
        .radius = p->at.n == 3 ? fabs(p->at.v[2])
                  : p->at.n ? usual.radius : -1.0,
        .degrees = (double) p->size, .depth = NAN, .bias = usual.bias,
        .name = "sun",
    };
    memcpy(spec.at, p->at.n ? p->at.v : p->dir.v, sizeof spec.at);
    for (int c = 0; c < 3; c++)
        spec.flux[c] =
            color->n ? (float) color->v[color->n == 3 ? c : 0] : 0.0f;
    return spec;
}

static bool has_flux(const struct gp_light_spec *s)
{
    return s->flux[0] > 0.0f || s->flux[1] > 0.0f || s->flux[2] > 0.0f;
}

gp_status gp_suns_begin(const struct gp_log *log, const struct gp_sun_params *p,
    enum gp_gl_api api, const struct gp_sun_reader *reader, struct gp_suns *out)
{
    struct gp_light_spec *lamps = NULL;
    struct gp_image image = {0};
    int n = 0;
    gp_status st = GP_OK;
    out->p = p;
    out->api = api;
    if (p->lights)
        GP_TRY(gp_lights_read(log, p->lights, &lamps, &n));
    const int sun = p->sun ? p->specs : p->at.n || p->dir.n;
    GP_TRY(gp_alloc(log, "lights", (size_t) (sun + n) + 1, sizeof *out->spec,
                    &out->spec));
    if (p->sun && sun)
        memcpy(out->spec, p->spec, (size_t) sun * sizeof *p->spec);
    else if (sun)
        out->spec[0] = sun_spec(p);
    if (n)
        memcpy(out->spec + sun, lamps, (size_t) n * sizeof *lamps);
    out->specs = sun + n;
    if (p->camera)
        GP_TRY(gp_camera_read(log, p->camera, &out->cameras));
    if (p->flare)
        GP_TRY(gp_flare_read(log, p->flare, &out->flare));
    bool lit = p->color.n || p->lights || p->more_flux;
    for (int i = 0; p->sun && i < sun; i++)
        lit |= has_flux(&p->spec[i]);
    if (p->sun)
        lit |= p->camera && has_flux(p->sun);
    if (gp_flare_has(&out->flare, GP_FLARE_LIGHTS) && !lit)
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE,
                          p->specs || p->camera || p->lights ? "lights.sun" : "lights.flare",
                          "%s: has elements of lights, and there is no light "
                          "with flux; write \"source\": \"bright\" in it",
                          p->flare));
    // images of flare elements become light: no NaN, no negative values
    for (int k = 0; k < out->flare.n; k++) {
        struct gp_flare_element *const e = &out->flare.element[k];
        if (!e->path)
            continue;
        GP_TRY(reader->picture(reader->user, log, e->path, &image));
        const int w = gp_image_w(&image), h = gp_image_h(&image);
        const size_t pixels = gp_image_pixels(&image);
        for (int c = 0; c < 3; c++) {
            float *const v = image.rgb.c[c];
            for (size_t i = 0; i < pixels; i++)
                v[i] = v[i] > 0.0f && v[i] <= 1e30f ? v[i] : 0.0f;
        }
        e->image = (struct gp_flare_image) {
            .w = w, .h = h, .cx = 0.5 * w, .cy = 0.5 * h, .rgb = image.rgb,
        };
        image.rgb = (struct gp_planes) {0};
        gp_image_free(&image);
    }
out:
    gp_free(lamps);
    return st;
}

// -- places of the lights ----------------------------------------------------

double gp_suns_fov(const struct gp_suns *suns, const struct gp_sun_about *about,
                   const struct gp_image *f)
{
    const struct gp_camera_frame *const entry = gp_camera_frame_find(
        &suns->cameras, about->numbered ? about->number : -1);
    struct gp_camera camera;
    if (entry)
        return gp_camera_fov(&entry->camera);
    // a matrix that is wrong is said where a light needs it
    if (!about->has_ndc ||
        gp_camera_make(NULL, f->path, NULL, about->to_ndc,
                       suns->p->ndc == GP_NDC_AUTO ? about->ndc : suns->p->ndc,
                       &camera))
        return suns->more_fov;
    return gp_camera_fov(&camera);
}

/* Finds the entry of --camera for a frame; NULL without --camera. */
static gp_status find_entry(const struct gp_log *log,
                            const struct gp_suns *suns,
                            const struct gp_sun_about *about,
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
                          about->number, about->name);
    if (!*out)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: %s has no frame number to find its camera by; "
                       "add one to its name, or keep one camera in the "
                       "file", path, about->name);
    return GP_OK;
}

gp_status gp_suns_camera(const struct gp_log *log, const struct gp_suns *suns,
                         const struct gp_sun_about *about,
                         const struct gp_image *f, struct gp_camera *out,
                         bool *found)
{
    const struct gp_camera_frame *entry;
    const enum gp_ndc asked = suns->p->ndc;
    gp_status st = find_entry(log, suns, about, &entry);
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

static gp_status place_lights(const struct gp_log *log,
                              const struct gp_sun_about *about,
                              const struct gp_image *f, struct gp_suns *suns)
{
    static const struct gp_sun_params usual = GP_SUN_DEFAULTS;
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
    GP_TRY(find_entry(log, suns, about, &entry));
    if (needed)
        GP_TRY(gp_suns_camera(log, suns, about, f, &camera, &found));
    if (needed && !found && more->camera) {
        found = true;
        camera = *more->camera;
    }
    // the sun of --camera, where the command line names none
    const bool sun = entry && entry->has_sun &&
                     !(p->sun ? p->specs : p->at.n || p->dir.n);
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
        struct gp_light_spec spec = i < 0             ? sun_spec(p)
                                    : i < suns->specs ? suns->spec[i]
                                    : more->spec[i - suns->specs];
        if (i < 0) {
            memcpy(spec.at, entry->sun_dir, sizeof spec.at);
            spec.place = GP_PLACE_DIRECTION;
            spec.radius = -1.0;
        }
        // pixels of the pictures that the file was written for
        if (i < 0 && entry->sun_radius > 0.0 && p->size == usual.size)
            spec.radius = entry->sun_radius *
                          (suns->cameras.width > 0.0
                               ? gp_rect_w(f->display) / suns->cameras.width
                               : 1.0);
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
static void warn_of_window(const struct gp_log *log, const char *path,
    const struct gp_plane *p, const struct gp_image *f, struct gp_suns *suns)
{
    const struct gp_rect own = gp_image_read(f);
    const struct gp_rect common = gp_rect_meet(p->window, own);
    if (!path || !p->v || suns->warned_window ||
        memcmp(&common, &own, sizeof common) == 0)
        return;
    suns->warned_window = true;
    gp_say(log, GP_LEVEL_WARN,
           "%s: does not cover %s (its window is %dx%d at %d,%d, the frame's "
           "%dx%d at %d,%d); the rest counts as empty", path, f->path,
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
    if (!any || suns->depth.v || suns->mask.v || suns->warned_clear)
        return;
    suns->warned_clear = true;
    gp_say_at(log, GP_LEVEL_WARN, "frame.coverage",
              "%s: no depth channel and no mask: nothing hides the lights%s",
              f->path, scene ? " inside the frame" : "");
}

gp_status gp_suns_find(const struct gp_log *log,
                       const struct gp_sun_about *about,
                       const struct gp_image *f, struct gp_suns *suns)
{
    return place_lights(log, about, f, suns);
}

void gp_suns_hide(const struct gp_log *log, const struct gp_image *f,
                  const struct gp_plane *depth, const struct gp_plane *mask,
                  struct gp_suns *suns)
{
    if (depth && depth != &suns->depth) {
        suns->depth = *depth;
        suns->depth.borrowed = true;
        suns->depth.name = NULL;
        warn_of_window(log, depth->name, depth, f, suns);
    }
    if (mask && mask != &suns->mask) {
        suns->mask = *mask;
        suns->mask.borrowed = true;
        suns->mask.name = NULL;
        warn_of_window(log, mask->name, mask, f, suns);
    }
    suns->occluders = (struct gp_occluders) {
        .depth = suns->depth.v ? &suns->depth : NULL,
        .mask = suns->mask.v ? &suns->mask : NULL,
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
    gp_plane_free(&suns->depth);
    gp_plane_free(&suns->mask);
    GP_FREE(suns->light);
    suns->n = 0;
}

void gp_suns_close(struct gp_suns *suns)
{
    gp_suns_end_frame(suns);
    gp_suns_drop_sprite(suns);
    if (suns->map)
        gp_sun_map_close(suns->gl, &suns->map);
    if (suns->gl)
        gp_gl_close(&suns->gl);
    gp_flare_free(&suns->flare);
    gp_camera_file_free(&suns->cameras);
    gp_free(suns->spec);
    *suns = (struct gp_suns) {0};
}
