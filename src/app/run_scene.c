/* The scene of a run: read once, posed for each frame, its lights and camera
 * handed to the sun's stage. */
#include "app/stages.h"

#include "core/memory.h"
#include "core/minmax.h"
#include "io/plane.h"
#include "io/read.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double USUAL_RATE = 24.0; // frames a second, without an attribute
static const double MOST_APART = 0.5;  // pixels between two cameras
static const double PI = 3.14159265358979323846;

// -- reading ------------------------------------------------------------------

/* Reads a texture's alpha, from bytes of the scene's file or a file beside. */
static gp_status read_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, struct gp_cutout *out)
{
    const struct gp_settings *const s = user;
    struct gp_coverage a;
    const gp_status st =
        gp_read_coverage(log, &s->input.read, name, bytes, n, most, &a);
    if (st)
        return st;
    out->w = a.w;
    out->h = a.h;
    out->alpha = a.code;
    return GP_OK;
}

/* Lists the names of a scene's cameras, cut to fit. */
static void camera_names(const struct gp_scene *s, char *text, size_t size)
{
    size_t at = 0;
    text[0] = '\0';
    for (int i = 0; i < s->cameras && at < size; i++)
        at += (size_t) snprintf(text + at, size - at, "%s%s", i ? ", " : "",
                                s->camera[i].name);
}

struct gp_scene_images gp_scene_images_of(const struct gp_settings *s)
{
    return (struct gp_scene_images) {(void *) (uintptr_t) s, read_alpha};
}

gp_status gp_run_scene_begin(const struct gp_log *log, struct gp_run *r)
{
    const struct gp_scene_settings *const p = &r->s->scene;
    const struct gp_scene_images images = gp_scene_images_of(r->s);
    struct gp_run_scene *const own = &r->scene;
    gp_status st;
    if (!p->path)
        return GP_OK;
    GP_TRY(gp_scene_read(log, p->path, p->up, &images, &own->scene));
    const struct gp_scene *const s = &own->scene;
    const struct gp_scene_camera *const camera =
        gp_scene_find_camera(s, p->camera);
    own->camera = camera ? (int) (camera - s->camera) : -1;
    own->settled = p->up != GP_UP_AUTO;
    if (p->camera && !camera)
        GP_TRY(gp_scene_no_camera(log, s, p->camera));
    if (s->lights > GP_LIGHTS_MAX)
        GP_TRY(gp_fail(log, GP_ERR_DATA, "%s: too many lights (found %d); the "
                       "limit is %d", p->path, s->lights, GP_LIGHTS_MAX));
    if (camera)
        r->suns.more_fov = camera->yfov * (180.0 / PI);
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) s->lights, sizeof *own->spec,
                         &own->spec));
out:
    return st;
}

void gp_run_scene_free(struct gp_run_scene *s)
{
    gp_meshes_free(&s->meshes);
    gp_scene_free(&s->scene);
    gp_free(s->spec);
    *s = (struct gp_run_scene) {0};
}

// -- a frame's lights ---------------------------------------------------------

/* Light of the scene as one of the frame. Its flux is that of a disc as bright
 * as the light: a lamp's intensity over pi r^2, a sun's illuminance over the
 * disc's solid angle, times the disc's pixels. */
static struct gp_light_spec spec_of(const struct gp_settings *s,
    const struct gp_scene_light *l, const struct gp_camera *c,
    struct gp_rect display)
{
    const struct gp_light usual = GP_LIGHT_DEFAULTS;
    struct gp_light_spec spec = {
        .place = GP_PLACE_WORLD, .at = {l->at.x, l->at.y, l->at.z},
        .depth = NAN, .bias = usual.bias,
        .ball = l->ball > 0.0 ? l->ball : (double) s->scene.lamp_size,
    };
    struct gp_v3 to = gp_v3_scale(l->along, -1.0); // the light, from the eye
    double sine = 1.0; // of half the angle that the disc is seen under
    memcpy(spec.name, l->name, sizeof spec.name);
    if (l->kind == GP_LIGHT_DIRECTIONAL) {
        spec.place = GP_PLACE_DIRECTION;
        spec.at[0] = to.x;
        spec.at[1] = to.y;
        spec.at[2] = to.z;
        spec.degrees = (double) s->sun.size;
        spec.radius = -1.0;
        sine = sin(spec.degrees * (PI / 360.0));
    } else {
        spec.radius = spec.ball > 0.0 ? -1.0 : usual.radius;
    }
    if (!c || !(s->scene.light_scale > 0.0f))
        return spec;
    // a disc of a small angle has as many pixels as its sine's square says
    double power = l->intensity;
    if (l->kind != GP_LIGHT_DIRECTIONAL) {
        to = gp_v3_sub(l->at, gp_camera_eye(c));
        const double distance = fmax(gp_v3_length(to), 1e-9);
        const double size = spec.ball > 0.0 ? spec.ball : 1e-4 * distance;
        to = gp_v3_scale(to, 1.0 / distance);
        power *= gp_spot_share(l, gp_v3_scale(to, -1.0)) /
                 (distance * distance);
        sine = fmin(size / distance, 1.0);
    }
    const double dir[3] = {to.x, to.y, to.z};
    const double radius =
        gp_camera_disc(c, display, dir, asin(sine) * (360.0 / PI));
    const double flux = (double) s->scene.light_scale * power * radius *
                        radius / fmax(sine * sine, 1e-18);
    for (int i = 0; i < 3; i++)
        spec.flux[i] = (float) fmin(flux * l->color[i], 1e12);
    return spec;
}

// -- a frame's camera ---------------------------------------------------------

/* Returns the scene's time of a frame. */
static double time_of(const struct gp_run *r, const struct gp_frame_state *fs)
{
    const struct gp_scene *const s = &r->scene.scene;
    const double rate = gp_frame_rate(&fs->frame);
    int number;
    if (!gp_job_number(fs->job, &number))
        return s->start; // a frame alone is the scene's first
    return ((double) number - (double) r->s->scene.start) /
           (rate > 0.0 ? rate : USUAL_RATE);
}

/* Warns once where a sequence runs beside the scene's keys. */
static void warn_of_time(struct gp_run *r, const struct gp_frame_state *fs,
                         double seconds)
{
    const struct gp_scene *const s = &r->scene.scene;
    if (r->scene.warned_time || s->start == s->end ||
        (seconds >= s->start - 0.5 / USUAL_RATE &&
         seconds <= s->end + 0.5 / USUAL_RATE))
        return;
    r->scene.warned_time = true;
    gp_say(fs->log, GP_LEVEL_WARN, "%s: %s is at %g s, its keys run from %g to "
           "%g s; give --scene-start, the frame at 0 s", r->s->scene.path,
           fs->job->input, seconds, s->start, s->end);
}

/* Finds the frame's camera, turns the scene to its world, and compares it with
 * the scene's own. */
static gp_status find_camera(struct gp_run *r, struct gp_frame_state *fs,
                             const struct gp_sun_about *about)
{
    const struct gp_scene_settings *const p = &r->s->scene;
    struct gp_run_scene *const own = &r->scene;
    struct gp_scene *const s = &own->scene;
    struct gp_scene_facts *const facts = &fs->facts.scene;
    const struct gp_rect display = fs->frame.display;
    struct gp_camera theirs;
    char names[512];
    gp_status st;
    GP_TRY(gp_suns_camera(fs->log, &r->suns, about, &fs->frame,
                          &own->frame_camera, &own->has_camera));
    if (!own->settled && own->has_camera)
        gp_scene_turn(s, gp_scene_find_up(s, &own->frame_camera));
    own->settled = own->settled || own->has_camera;
    if (own->camera < 0 && !own->has_camera && s->cameras) {
        camera_names(s, names, sizeof names);
        return gp_fail(fs->log, GP_ERR_USAGE, "%s: the frame has no camera "
                       "(worldToNDC), %s has %d; give --scene-camera, one of: "
                       "%s", fs->job->input, p->path, s->cameras, names);
    }
    if (own->camera < 0)
        return GP_OK;
    const struct gp_scene_camera *const c = &s->camera[own->camera];
    const double aspect = (double) gp_rect_w(display) *
                          (double) fs->frame.pixel_aspect /
                          (double) gp_max(gp_rect_h(display), 1);
    GP_TRY(gp_scene_camera_make(fs->log, s, c, aspect, &theirs));
    if (!own->has_camera) {
        own->frame_camera = theirs;
        own->has_camera = true;
        facts->camera = c->name;
        return GP_OK;
    }
    facts->apart = gp_scene_apart(s, &own->frame_camera, &theirs, display);
    facts->compared = true;
    if (facts->apart > MOST_APART && !own->warned_camera) {
        char apart[64] = "see nothing in common";
        if (isfinite(facts->apart))
            snprintf(apart, sizeof apart, "are %.3g pixels apart",
                     facts->apart);
        own->warned_camera = true;
        gp_say(fs->log, GP_LEVEL_WARN, "%s: its camera and \"%s\" of %s %s; "
               "the frame's counts; check --scene-start and --scene-up",
               fs->job->input, c->name, p->path, apart);
    }
out:
    return st;
}

gp_status gp_run_scene(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_run_scene *const own = &r->scene;
    const struct gp_sun_about about = gp_job_about(fs->job, &fs->frame);
    const double seconds = time_of(r, fs);
    warn_of_time(r, fs, seconds);
    gp_scene_pose(&own->scene, seconds);
    fs->facts.scene.path = r->s->scene.path;
    fs->facts.scene.seconds = seconds;
    gp_status st = find_camera(r, fs, &about);
    if (st)
        return st;
    const struct gp_camera *const c =
        own->has_camera ? &own->frame_camera : NULL;
    for (int i = 0; i < own->scene.lights; i++)
        own->spec[i] = spec_of(r->s, &own->scene.light[i], c,
                               fs->frame.display);
    r->suns.more = (struct gp_suns_more) {
        .spec = own->spec, .specs = own->scene.lights, .camera = c,
    };
    return GP_OK;
}
