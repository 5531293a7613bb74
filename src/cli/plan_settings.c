#include "cli/plan_settings.h"

#include "cli/options.h"

#include <string.h>

/* The sun of --sun or --sun-dir, and of --camera all but its place. */
static struct glarepp_light sun_of(const struct gp_sun_settings *p)
{
    struct glarepp_light sun = GLAREPP_LIGHT;
    strcpy(sun.name, "sun");
    sun.place = p->at.n ? GLAREPP_PIXEL : GLAREPP_DIRECTION;
    memcpy(sun.at, p->at.n ? p->at.v : p->dir.v, sizeof sun.at);
    if (p->at.n == 3)
        sun.radius = fabs(p->at.v[2]);
    sun.degrees = (double) p->p.degrees;
    for (int c = 0; c < 3 && p->color.n; c++)
        sun.flux[c] = (float) p->color.v[p->color.n == 3 ? c : 0];
    return sun;
}

void gp_plan_params(const struct gp_settings *s,
                    const struct glarepp_kernel *kernel,
                    struct gp_plan_settings *out)
{
    *out = (struct gp_plan_settings) {
        .plan = GLAREPP_PLAN_PARAMS, .light = sun_of(&s->sun),
        .lights = s->sun.p, .lens = GLAREPP_LENS_PARAMS,
        .scene = GLAREPP_SCENE_PARAMS, .tone = s->tone.map,
    };
    struct glarepp_plan_params *const p = &out->plan;
    p->kernel = kernel;
    p->fov = (double) s->kernel.fov;
    p->rotate = (double) s->kernel.rotate;
    p->sense = &s->light.sense;
    p->layer = &s->light.layer;
    p->lights = &out->lights;
    p->lens = &out->lens;
    p->scene = &out->scene;
    p->tone = &out->tone;

    out->lights.light = &out->light;
    out->lights.lights = s->sun.at.n || s->sun.dir.n;
    out->lights.sun = out->light;
    out->lights.faded = s->sun.color.n > 0;

    out->lens.lens = s->lens.name;
    out->lens.sensor = (double) s->lens.sensor;
    out->lens.distance = (double) s->lens.distance;
    out->lens.f_number = (double) s->lens.f_number;

    out->scene.path = s->scene.path;
    out->scene.camera = s->scene.camera;
    out->scene.up = s->scene.up;
    out->scene.start = (double) s->scene.start;
    out->scene.light_scale = (double) s->scene.light_scale;
    out->scene.lamp_size = (double) s->scene.lamp_size;
    out->scene.relight = s->scene.relight.at;
    out->scene.relights = s->scene.relight.n;
    out->scene.camera_normals = s->scene.normal_space == GP_NORMALS_CAMERA;

    out->tone.context = s->tone.context.at;
    out->tone.contexts = s->tone.context.n;
}

struct glarepp_kernel_params gp_kernel_params(const struct gp_settings *s)
{
    const bool given = gp_option_given(s, "kernel-normalize");
    struct glarepp_kernel_params p = s->kernel.image;
    p.word = s->kernel.words.at;
    p.words = s->kernel.words.n;
    p.as_it_is = given && s->kernel.normalize == GP_NORMALIZE_NONE;
    p.normalized = given && s->kernel.normalize == GP_NORMALIZE_LUMINANCE;
    return p;
}
