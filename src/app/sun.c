#include "app/sun.h"

#include "core/memory.h"
#include "io/plane.h"
#include "io/sequence.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

bool gp_suns_wanted(const struct gp_sun_settings *s)
{
    return s->at.n || s->dir.n || s->camera || s->lights;
}

// -- what the command line names ----------------------------------------------

static void set_flux(const struct gp_numbers *color, float flux[3])
{
    for (int c = 0; c < 3; c++)
        flux[c] = color->n ? (float) color->v[color->n == 3 ? c : 0] : 0.0f;
}

/* The sun of --sun or --sun-dir. */
static struct gp_light_spec sun_spec(const struct gp_sun_settings *s)
{
    const struct gp_light usual = GP_LIGHT_DEFAULTS;
    struct gp_light_spec spec = {
        .place = s->at.n ? GP_PLACE_PIXEL : GP_PLACE_DIRECTION,
        .radius = s->at.n == 3 ? fabs(s->at.v[2])
                  : s->at.n ? usual.radius : -1.0,
        .degrees = (double) s->size, .depth = NAN, .bias = usual.bias,
    };
    memcpy(spec.at, s->at.n ? s->at.v : s->dir.v, sizeof spec.at);
    set_flux(&s->color, spec.flux);
    return spec;
}

/* The sun goes before the lights of the file. */
static gp_status put_sun_first(const struct gp_log *log,
                               const struct gp_light_spec *sun,
                               struct gp_suns *suns)
{
    void *v;
    gp_status st = gp_alloc(log, "lights", (size_t) suns->specs + 1,
                            sizeof *suns->spec, &v);
    if (st)
        return st;
    struct gp_light_spec *const all = v;
    all[0] = *sun;
    if (suns->specs)
        memcpy(all + 1, suns->spec,
               (size_t) suns->specs * sizeof *suns->spec);
    gp_free(suns->spec);
    suns->spec = all;
    suns->specs++;
    return GP_OK;
}

/* What an element's picture holds becomes light: no NaN, nothing under 0. */
static void clean(struct gp_planes *p, size_t n)
{
    for (int c = 0; c < 3; c++) {
        for (size_t i = 0; i < n; i++) {
            const float v = p->c[c][i];
            p->c[c][i] = v > 0.0f && v <= 1e30f ? v : 0.0f;
        }
    }
}

static gp_status read_images(const struct gp_log *log,
                             const struct gp_settings *s, struct gp_flare *f)
{
    const struct gp_read_params limits = gp_read_limits(&s->read);
    for (int i = 0; i < f->n; i++) {
        struct gp_flare_element *const e = &f->element[i];
        struct gp_frame image = {0};
        if (!e->path)
            continue;
        gp_status st = gp_read_frame(log, &limits, e->path, &image);
        if (st)
            return st;
        const int w = gp_frame_w(&image), h = gp_frame_h(&image);
        clean(&image.rgb, gp_frame_pixels(&image));
        e->image = (struct gp_flare_image) {
            .w = w, .h = h, .cx = 0.5 * w, .cy = 0.5 * h, .rgb = image.rgb,
            .serial = gp_serial_next(),
        };
        image.rgb = (struct gp_planes) {0};
        gp_frame_free(&image);
    }
    return GP_OK;
}

gp_status gp_suns_begin(const struct gp_log *log, const struct gp_settings *s,
                        struct gp_suns *out)
{
    const struct gp_sun_settings *const sun = &s->sun;
    gp_status st = GP_OK;
    if (!gp_suns_wanted(sun))
        return GP_OK;
    if (sun->lights)
        GP_TRY(gp_lights_read(log, sun->lights, &out->spec, &out->specs));
    if (sun->at.n || sun->dir.n) {
        const struct gp_light_spec spec = sun_spec(sun);
        GP_TRY(put_sun_first(log, &spec, out));
    }
    if (sun->camera)
        GP_TRY(gp_camera_read(log, sun->camera, &out->cameras));
    if (sun->flare) {
        GP_TRY(gp_flare_read(log, sun->flare, &out->flare));
        GP_TRY(read_images(log, s, &out->flare));
    }
out:
    return st;
}

// -- what stands before the lights ----------------------------------------------

/* The frame's number: the job's, or that of its file. */
static bool number_of(const struct gp_job *job, int *number)
{
    *number = job->frame;
    return job->numbered || gp_frame_number(job->input, number);
}

/* A plane from a file of its own, whose name may be a pattern. */
static gp_status read_beside(const struct gp_log *log,
                             const struct gp_settings *s,
                             const struct gp_job *job, const char *path,
                             const char *channel, bool depth,
                             struct gp_plane *out)
{
    struct gp_pattern pattern;
    int number = 0;
    gp_status st = gp_pattern_of_input(log, path, &pattern);
    if (st)
        return st;
    if (pattern.views && !job->view)
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: %%V and %%v are views, and %s has none; name the "
                       "file, or give --views", path, job->input);
    if (pattern.len && !number_of(job, &number))
        return gp_fail(log, GP_ERR_USAGE,
                       "%s: a pattern, and %s has no frame number; name the "
                       "file", path, job->input);
    char *const name = gp_pattern_name(&pattern, number, job->view);
    if (!name)
        return gp_fail(log, GP_ERR_BUG, "%s: out of memory", path);
    st = gp_read_plane_file(log, &s->read, name, channel, depth, out);
    free(name);
    return st;
}

/* A plane of another file that leaves out a part of the frame may be the wrong
 * file; what it does not have counts as empty. */
static void warn_of_window(const struct gp_log *log, const char *path,
                           const struct gp_plane *p, const struct gp_frame *f,
                           struct gp_suns *suns)
{
    const struct gp_rect common = gp_rect_meet(p->window, f->data);
    if (!path || !p->v || suns->told_window ||
        memcmp(&common, &f->data, sizeof common) == 0)
        return;
    suns->told_window = true;
    gp_say(log, GP_LEVEL_WARN,
           "%s: does not cover %s (its window is %dx%d at %d,%d, the frame's "
           "%dx%d at %d,%d); the rest counts as empty", path, f->path,
           gp_rect_w(p->window), gp_rect_h(p->window), p->window.x0,
           p->window.y0, gp_frame_w(f), gp_frame_h(f), f->data.x0, f->data.y0);
}

static gp_status read_planes(const struct gp_log *log,
                             const struct gp_settings *s,
                             const struct gp_job *job,
                             const struct gp_frame *f, struct gp_suns *suns)
{
    const struct gp_sun_settings *const sun = &s->sun;
    gp_status st = GP_OK;
    if (sun->depth_file)
        GP_TRY(read_beside(log, s, job, sun->depth_file, s->depth, true,
                           &suns->depth));
    else
        GP_TRY(gp_read_depth(log, &s->read, f, s->depth, &suns->depth));
    warn_of_window(log, sun->depth_file, &suns->depth, f, suns);
    if (sun->mask_file)
        GP_TRY(read_beside(log, s, job, sun->mask_file, sun->mask, false,
                           &suns->mask));
    else if (sun->mask)
        GP_TRY(gp_read_coverage(log, &s->read, f, sun->mask, &suns->mask));
    warn_of_window(log, sun->mask_file, &suns->mask, f, suns);
    if (!suns->depth.v && !suns->mask.v && !suns->told_clear) {
        suns->told_clear = true;
        gp_say(log, GP_LEVEL_WARN,
               "%s: no depth channel and no --mask: nothing hides the lights",
               f->path);
    }
out:
    return st;
}

static struct gp_rect both(struct gp_rect a, struct gp_rect b)
{
    return (struct gp_rect) {
        a.x0 < b.x0 ? a.x0 : b.x0, a.y0 < b.y0 ? a.y0 : b.y0,
        a.x1 > b.x1 ? a.x1 : b.x1, a.y1 > b.y1 ? a.y1 : b.y1,
    };
}

// -- where the lights stand -------------------------------------------------------

/* The camera of the frame's own attributes; *found says whether it has one. */
static gp_status own_camera(const struct gp_log *log, enum gp_ndc ndc,
                            const struct gp_frame *f, struct gp_camera *c,
                            bool *found)
{
    double to_camera[16], to_ndc[16];
    const bool has = gp_frame_matrix(f, "worldToCamera", to_camera);
    *found = gp_frame_matrix(f, "worldToNDC", to_ndc);
    if (!*found && gp_frame_matrix(f, "worldToScreen", to_ndc)) {
        *found = true;
        ndc = ndc == GP_NDC_AUTO ? GP_NDC_CLIP : ndc;
    }
    return *found ? gp_camera_make(log, f->path, has ? to_camera : NULL,
                                   to_ndc, ndc, c)
                  : GP_OK;
}

/* The frame's entry of --camera. */
static gp_status find_entry(const struct gp_log *log, const char *path,
                            const struct gp_job *job,
                            const struct gp_suns *suns,
                            const struct gp_camera_frame **entry)
{
    int number = 0;
    const bool known = number_of(job, &number);
    *entry = gp_camera_frame_find(&suns->cameras, known ? number : -1);
    if (!*entry && known)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: no camera for frame %d of %s; add it, or leave "
                       "--camera out", path, number, job->input);
    if (!*entry)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: %s has no frame number to look for; number it, or "
                       "keep one camera", path, job->input);
    return GP_OK;
}

/* The sun that --camera tells, where the command line names none. */
static gp_status camera_sun(const struct gp_log *log,
                            const struct gp_settings *s,
                            const struct gp_camera_frame *entry, double scale,
                            struct gp_light_spec *spec)
{
    if (!entry->has_sun)
        return gp_fail(log, GP_ERR_DATA,
                       "%s: frame %lld has no sun_dir_world; give --sun, "
                       "--sun-dir or --lights", s->sun.camera, entry->frame);
    *spec = sun_spec(&s->sun);
    memcpy(spec->at, entry->sun_dir, sizeof spec->at);
    spec->place = GP_PLACE_DIRECTION;
    spec->radius = -1.0;
    if (entry->sun_radius > 0.0 && s->sun.size == gp_defaults.sun.size)
        spec->radius = entry->sun_radius * scale;
    return GP_OK;
}

static gp_status place_lights(const struct gp_log *log,
                              const struct gp_settings *s,
                              const struct gp_job *job,
                              const struct gp_frame *f, struct gp_suns *suns)
{
    const struct gp_sun_settings *const sun = &s->sun;
    const struct gp_camera_frame *entry = NULL;
    struct gp_camera camera;
    bool has = false;
    void *v;
    gp_status st = GP_OK;
    if (sun->camera) {
        GP_TRY(find_entry(log, sun->camera, job, suns, &entry));
        camera = entry->camera;
        has = true;
    } else {
        bool needed = false;
        for (int i = 0; i < suns->specs; i++)
            needed = needed || suns->spec[i].place != GP_PLACE_PIXEL;
        if (needed)
            GP_TRY(own_camera(log, sun->ndc, f, &camera, &has));
    }
    const bool told = sun->camera && !sun->at.n && !sun->dir.n &&
                      (entry->has_sun || !sun->lights);
    if (suns->specs + told > GP_LIGHTS_MAX)
        GP_TRY(gp_fail(log, GP_ERR_DATA,
                       "%s: too many lights with the sun (%d); %d are the "
                       "most", sun->lights, suns->specs + told,
                       GP_LIGHTS_MAX));
    GP_TRY(gp_alloc(log, "lights", (size_t) (suns->specs + told),
                    sizeof *suns->light, &v));
    suns->light = v;
    if (told) {
        struct gp_light_spec spec;
        const double scale =
            suns->cameras.width > 0.0
                ? gp_rect_w(f->display) / suns->cameras.width : 1.0;
        GP_TRY(camera_sun(log, s, entry, scale, &spec));
        GP_TRY(gp_light_place_in(log, f->path, &spec, &camera,
                                 sun->depth_type, f->display,
                                 &suns->light[suns->n]));
        suns->n++;
    }
    for (int i = 0; i < suns->specs; i++) {
        GP_TRY(gp_light_place_in(log, f->path, &suns->spec[i],
                                 has ? &camera : NULL, sun->depth_type,
                                 f->display, &suns->light[suns->n]));
        suns->n++;
    }
out:
    return st;
}

gp_status gp_suns_place(const struct gp_log *log, const struct gp_settings *s,
                        const struct gp_job *job, const struct gp_frame *f,
                        struct gp_suns *suns)
{
    gp_status st = GP_OK;
    GP_TRY(place_lights(log, s, job, f, suns));
    GP_TRY(read_planes(log, s, job, f, suns));
    suns->occluders = (struct gp_occluders) {
        .depth = suns->depth.v ? &suns->depth : NULL,
        .mask = suns->mask.v ? &suns->mask : NULL,
        .type = s->sun.depth_type, .frame = both(f->data, f->display),
    };
    gp_occluders_count(&suns->occluders);
out:
    return st;
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
    gp_free(suns->light);
    suns->light = NULL;
    suns->n = 0;
}
