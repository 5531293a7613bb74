// SPDX-License-Identifier: Apache-2.0
/* The scene of a frame: read once, posed for each, its lights and camera handed to
 * the lights' steps. */
#include "api/plan.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "scene/relight.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const double USUAL_RATE = 24.0; // frames a second, without an attribute
static const double MOST_APART = 0.5;  // pixels between two cameras

// -- reading ------------------------------------------------------------------

/* Has the caller decode a texture's alpha. */
static gp_status read_alpha(void *user, const struct gp_log *log,
                            const char *name, const void *bytes, size_t n,
                            long long most, struct gp_cutout *out)
{
    const struct glarepp_params *const p = &((struct glarepp *) user)->params;
    const struct glarepp_picture what = {name, bytes, n, true, most};
    struct glarepp_image image = GLAREPP_IMAGE;
    struct glarepp_label label = {0};
    gp_status st = (gp_status) p->picture(p->user, &what, &image, &label);
    if (st)
        return st; // its message is the caller's
    const struct glarepp_rect d = image.data;
    const size_t codes = (size_t) (d.x1 - d.x0) * (size_t) (d.y1 - d.y0);
    if (image.type != GLAREPP_CODES || !image.plane[0])
        GP_TRY(gp_fail_at(log, GP_ERR_USAGE, "params.picture", "%s: its alpha "
                          "was not decoded as codes", name));
    GP_TRY(gp_alloc(log, "texture", codes, sizeof *out->alpha, &out->alpha));
    memcpy(out->alpha, image.plane[0], codes * sizeof *out->alpha);
    out->w = d.x1 - d.x0;
    out->h = d.y1 - d.y0;
out:
    if (p->release)
        p->release(p->user, &image);
    return st;
}

gp_status gp_api_scene_read(struct glarepp *gp, const struct gp_log *log,
                            const char *path, enum glarepp_up up,
                            struct gp_scene *out)
{
    const struct gp_scene_images images = {gp, read_alpha};
    return gp_scene_read(log, path, up,
                         gp->params.picture ? &images : NULL, out);
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

gp_status gp_api_scene_begin(const struct glarepp_plan *plan,
                             struct gp_api_work *work)
{
    const struct glarepp_scene_params *const p = &plan->scene;
    const struct gp_log *const log = &plan->log;
    struct gp_api_scene *own;
    gp_status st;
    gp_api_about("scene");
    GP_TRY(gp_alloc_zero(log, "scene", 1, sizeof *own, &work->scene));
    own = work->scene;
    GP_TRY(gp_api_scene_read(plan->gp, log, p->path, p->up, &own->scene));
    const struct gp_scene *const s = &own->scene;
    const struct gp_scene_camera *const camera =
        gp_scene_find_camera(s, p->camera);
    own->camera = camera ? (int) (camera - s->camera) : -1;
    own->settled = p->up != GLAREPP_UP_AUTO;
    if (p->camera && !camera)
        GP_TRY(gp_scene_no_camera(log, s, p->camera));
    if (s->lights > GP_LIGHTS_MAX)
        GP_TRY(gp_fail(log, GP_ERR_DATA, "%s: too many lights (found %d); the "
                       "limit is %d", p->path, s->lights, GP_LIGHTS_MAX));
    if (camera)
        work->lights->suns.more_fov = camera->yfov * (180.0 / M_PI);
    GP_TRY(gp_alloc_zero(log, "lights", (size_t) s->lights + 1,
                         sizeof *own->light, &own->light));
out:
    return st;
}

void gp_api_scene_end(struct gp_api_scene **scene)
{
    gp_meshes_free(&(*scene)->meshes);
    gp_scene_free(&(*scene)->scene);
    gp_free((*scene)->light);
    GP_FREE(*scene);
}

// -- a frame's lights ---------------------------------------------------------

double gp_api_sun_size(const struct glarepp_plan *plan,
                       const struct gp_scene_light *l, const char **from)
{
    static const struct glarepp_light_params usual = GLAREPP_LIGHT_PARAMS;
    const bool option = plan->sun.degrees != usual.degrees;
    const bool own = !option && l->degrees > 0.0;
    *from = own ? "scene" : option ? "option" : "default";
    return own ? l->degrees : (double) plan->sun.degrees;
}

/* Light of the scene as one of the frame. Its flux is that of a disc as bright
 * as the light: a lamp's intensity over pi r^2, a sun's illuminance over the
 * disc's solid angle, times the disc's pixels, of a wide picture those in its middle. */
static struct glarepp_light spec_of(const struct glarepp_plan *plan,
    const struct gp_scene_light *l, const struct gp_camera *c,
    struct gp_rect display)
{
    const bool sun = l->kind == GP_LIGHT_DIRECTIONAL;
    struct gp_v3 to = gp_v3_scale(l->along, -1.0); // the light, from the eye
    struct glarepp_light spec = GLAREPP_LIGHT;
    const char *from;
    const struct gp_v3 at = sun ? to : l->at;
    spec.place = sun ? GLAREPP_DIRECTION : GLAREPP_WORLD;
    memcpy(spec.at, (double[3]) {at.x, at.y, at.z}, sizeof spec.at);
    spec.degrees = gp_api_sun_size(plan, l, &from);
    spec.ball = l->ball > 0.0 ? l->ball : plan->scene.lamp_size;
    memcpy(spec.name, l->name, sizeof spec.name);
    // of half the angle that the disc is seen under
    double sine = gp_sin(spec.degrees * (M_PI / 360.0));
    if (!c || !(plan->scene.light_scale > 0.0))
        return spec;
    // a disc of a small angle has as many pixels as its sine's square says
    double power = l->intensity;
    if (!sun) {
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
        c->wide.kind
            ? 2.0 * gp_sin(0.5 * gp_asin(sine)) / sqrt(c->wide.dx * c->wide.dy)
            : gp_camera_disc(c, display, dir, gp_asin(sine) * (360.0 / M_PI));
    const double flux = plan->scene.light_scale * power * radius *
                        radius / fmax(sine * sine, 1e-18);
    for (int i = 0; i < 3; i++)
        spec.flux[i] = (float) fmin(flux * l->color[i], 1e12);
    return spec;
}

// -- a frame's camera ---------------------------------------------------------

/* Warns once where a sequence runs beside the scene's keys. */
static void warn_of_time(const struct glarepp_frame *f, double seconds)
{
    const struct gp_scene *const s = &f->work->scene->scene;
    if (s->start == s->end ||
        (seconds >= s->start - 0.5 / USUAL_RATE &&
         seconds <= s->end + 0.5 / USUAL_RATE) ||
        !gp_api_says(&f->plan->said, GP_SAID_TIME))
        return;
    gp_say_at(&f->log, GP_LEVEL_WARN, "scene.start", "%s: %s is at %g s, its "
              "keys run from %g to %g s", f->plan->scene.path, f->sink.name,
              seconds, s->start, s->end);
}

/* Compares the frame's camera with the scene's own. */
static void compare_cameras(struct glarepp_frame *f, const char *name,
                            const struct gp_camera *theirs)
{
    const struct gp_api_scene *const own = f->work->scene;
    struct glarepp_scene_facts *const facts = &f->facts.scene;
    char apart[64] = "see nothing in common";
    facts->apart = gp_scene_apart(&own->scene, &own->frame_camera, theirs,
                                  f->image.display);
    facts->compared = true;
    if (!(facts->apart > MOST_APART) ||
        !gp_api_says(&f->plan->said, GP_SAID_CAMERA))
        return;
    if (isfinite(facts->apart))
        snprintf(apart, sizeof apart, "are %.3g pixels apart", facts->apart);
    gp_say_at(&f->log, GP_LEVEL_WARN, "scene.up", "%s: its camera and \"%s\" "
              "of %s %s; the frame's counts", f->sink.name, name,
              f->plan->scene.path, apart);
}

/* Finds the frame's camera, and turns the scene to its world. */
static gp_status find_camera(struct glarepp_frame *f)
{
    struct gp_api_scene *const own = f->work->scene;
    struct gp_scene *const s = &own->scene;
    const struct gp_rect display = f->image.display;
    struct gp_suns *const suns = &f->work->lights->suns;
    struct gp_camera theirs;
    char names[512];
    gp_status st;
    GP_TRY(gp_suns_camera(&f->log, suns, &f->p, &f->image, &own->frame_camera,
                          &own->has_camera));
    if (!own->settled && own->has_camera && !suns->wide.kind)
        gp_scene_turn(s, gp_scene_find_up(s, &own->frame_camera));
    own->settled = own->settled || own->has_camera;
    if (own->camera < 0 && !own->has_camera && s->cameras) {
        camera_names(s, names, sizeof names);
        return gp_api_refuse(
            f, "scene.camera",
            "the frame has no camera (worldToNDC), %s has %d: %s",
            f->plan->scene.path, s->cameras, names);
    }
    if (own->camera < 0)
        return GP_OK;
    const struct gp_scene_camera *const c = &s->camera[own->camera];
    const double aspect = (double) gp_rect_w(display) *
                          (double) f->image.pixel_aspect /
                          (double) gp_max(gp_rect_h(display), 1);
    GP_TRY(gp_scene_camera_make(&f->log, s, c, aspect, &theirs));
    if (suns->wide.kind && !f->p.has_camera) {
        f->facts.scene.camera = c->name;
        return gp_camera_wide(&f->log, f->plan->scene.path, theirs.to_camera,
                              &suns->wide, &own->frame_camera);
    }
    if (suns->wide.kind)
        return GP_OK;
    if (own->has_camera) {
        compare_cameras(f, c->name, &theirs);
    } else {
        own->frame_camera = theirs;
        own->has_camera = true;
        f->facts.scene.camera = c->name;
    }
out:
    return st;
}

/* Checks what relighting needs but planes, which are read only then. */
static gp_status check_relight(const struct glarepp_frame *f)
{
    const struct glarepp_scene_params *const p = &f->plan->scene;
    const struct gp_api_scene *const own = f->work->scene;
    const gp_status st = gp_relit_find(&f->log, &own->scene, p->relight,
                                       p->relights, NULL);
    if (st || !p->relights)
        return st;
    if (!own->has_camera)
        return gp_api_refuse(f, "frame.has_ndc",
                             "relighting needs a camera, and neither the frame "
                             "nor the scene has one");
    if (own->frame_camera.wide.kind)
        return gp_api_refuse(f, "plan.projection.relight",
                             "relighting needs a perspective frame");
    if (f->plan->sun.depth != GLAREPP_Z)
        return gp_fail_at(&f->log, GP_ERR_USAGE, "lights.depth", "relighting "
                          "needs distances along the view axis");
    return GP_OK;
}

gp_status gp_api_pose(struct glarepp_frame *f)
{
    struct gp_api_scene *const own = f->work->scene;
    const double rate = f->p.fps > 0.0 ? f->p.fps : USUAL_RATE;
    const double seconds = // a frame alone is the scene's first
        f->p.numbered ? ((double) f->p.number - f->plan->scene.start) / rate
                      : own->scene.start;
    warn_of_time(f, seconds);
    gp_scene_pose(&own->scene, seconds);
    f->facts.scene.path = f->plan->scene.path;
    f->facts.scene.seconds = seconds;
    gp_status st = find_camera(f);
    if (!st)
        st = check_relight(f);
    if (st)
        return st;
    const struct gp_camera *const c =
        own->has_camera ? &own->frame_camera : NULL;
    for (int i = 0; i < own->scene.lights; i++) {
        const struct gp_scene_light *const l = &own->scene.light[i];
        own->light[i] = spec_of(f->plan, l, c, f->image.display);
    }
    f->work->lights->suns.more = own->light;
    f->work->lights->suns.mores = own->scene.lights;
    f->work->lights->suns.camera = c;
    return GP_OK;
}

// -- relighting ---------------------------------------------------------------

gp_status gp_api_relight(struct glarepp_frame *f)
{
    const struct glarepp_scene_params *const p = &f->plan->scene;
    struct gp_api_scene *const own = f->work->scene;
    const struct {
        const struct gp_plane *plane;
        const char *parameter, *name;
    } needed[] = {{&f->depth, "frame.depth", "depth"},
                  {f->normal, "frame.normal", "normals"},
                  {f->albedo, "frame.albedo", "albedo"}};
    for (int i = 0; i < 3; i++) {
        if (!needed[i].plane->v)
            return gp_api_refuse(f, needed[i].parameter, "relighting needs %s",
                                 needed[i].name);
    }
    const struct gp_relit_frame frame = {
        .path = f->sink.name, .up_unknown = !own->settled,
        .light_scale = p->light_scale,
        .surfaces = {
            .rgb = &f->image.rgb, .data = f->image.data,
            .camera = own->frame_camera, .display = f->image.display,
            .z = &f->depth, .normal = f->normal, .albedo = f->albedo,
            .normal_of_camera = p->camera_normals,
        },
    };
    const gp_status st =
        gp_relit_add(&f->log, &own->scene, &own->meshes, &frame, p->relight,
                     p->relights, &f->relit, &f->facts.relits);
    f->facts.relit = f->relit;
    return st;
}
