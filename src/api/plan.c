// SPDX-License-Identifier: Apache-2.0
#include "api/plan.h"

#include "core/memory.h"
#include "glare/far_field/far_field.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// -- parameters ---------------------------------------------------------------

/* Has the plan own a block; NULL: memory is full. */
static gp_status own(struct glarepp_plan *plan, void *block)
{
    if (!block)
        return gp_no_memory_bare(&plan->log, "plan");
    plan->text[plan->texts++] = block;
    return GP_OK;
}

/* Replaces a string by a copy that the plan owns. */
static gp_status keep(struct glarepp_plan *plan, const char **text)
{
    if (!*text)
        return GP_OK;
    char *const copy = gp_strdup(*text);
    *text = copy;
    return own(plan, copy);
}

/* Replaces a list of strings by a copy, one block with its strings. */
static gp_status keep_list(struct glarepp_plan *plan,
                           const char *const **list, int n)
{
    size_t bytes = (size_t) n * sizeof **list;
    if (n < 1)
        return GP_OK;
    for (int i = 0; i < n; i++)
        bytes += strlen((*list)[i]) + 1;
    const char **const copy = malloc(bytes);
    const gp_status st = own(plan, copy);
    if (st)
        return st;
    char *at = (char *) &copy[n];
    for (int i = 0; i < n; i++) {
        copy[i] = strcpy(at, (*list)[i]);
        at += strlen(at) + 1;
    }
    *list = copy;
    return GP_OK;
}

static gp_status take_sense(struct glarepp_plan *plan,
                            const struct glarepp_sense_params *from)
{
    struct glarepp_sense_params *const p = &plan->sense;
    *p = (struct glarepp_sense_params) GLAREPP_SENSE_PARAMS;
    const gp_status st = gp_api_params(&plan->log, "sense", p, sizeof *p, from);
    return st || p->unit == GLAREPP_EV ||
                   (p->threshold >= 0.0f &&
                    (p->unit == GLAREPP_LUMINANCE || p->threshold <= 100.0f))
               ? st
               : gp_fail_at(&plan->log, GP_ERR_USAGE, "sense.threshold",
                            "sense: "
                            "a threshold that its unit has not (found %g)",
                            (double) p->threshold);
}

static gp_status take_layer(struct glarepp_plan *plan,
                            const struct glarepp_layer_params *from)
{
    struct glarepp_layer_params p = GLAREPP_LAYER_PARAMS;
    const gp_status st = gp_api_params(&plan->log, "layer", &p, sizeof p, from);
    if (st)
        return st;
    bool known = strcmp(p.engine, "auto") == 0;
    for (int i = 0; gp_engines[i]; i++)
        known |= strcmp(p.engine, gp_engines[i]->name) == 0;
    if (!known)
        return gp_fail_at(&plan->log, GP_ERR_USAGE, "layer.engine", "engine: "
                          "none has this name (found %s)", p.engine);
    const bool odd = p.group & (p.group - 1);
    if (odd || p.cluster & (p.cluster - 1))
        return gp_fail_at(
            &plan->log, GP_ERR_USAGE, odd ? "layer.group" : "layer.cluster",
            "layer: no power of two (found %d)", odd ? p.group : p.cluster);
    plan->glare = (struct gp_glare_params) GP_GLARE_DEFAULTS;
    plan->glare.engine = p.engine;
    plan->glare.gain = p.gain;
    plan->glare.tolerance = p.tolerance;
    plan->glare.tolerance_pixel = p.tolerance_pixel;
    plan->glare.in_double = p.in_double;
    plan->glare.gl = (enum gp_gl_api) p.gl;
    plan->glare.splat.group = p.group;
    plan->glare.splat.cluster = p.cluster;
    plan->glare.splat.cluster_fill = p.cluster_fill;
    plan->glare.splat.shrink = p.shrink;
    plan->compose = (struct gp_compose_params) {.gain = p.gain, .mix = p.mix};
    memcpy(plan->tint.tint, p.tint, sizeof p.tint);
    plan->tint.saturation = p.saturation;
    plan->tints = p.tint[0] != 1.0f || p.tint[1] != 1.0f || p.tint[2] != 1.0f ||
                  p.saturation != 1.0f;
    plan->edges = p.edges;
    return keep(plan, &plan->glare.engine);
}

static gp_status take_lights(struct glarepp_plan *plan,
                             const struct glarepp_light_params *from)
{
    struct glarepp_light_params p = GLAREPP_LIGHT_PARAMS;
    struct glarepp_light *light;
    gp_status st = gp_api_params(&plan->log, "lights", &p, sizeof p, from);
    if (st)
        return st;
    if (p.side % 2)
        return gp_fail_at(&plan->log, GP_ERR_USAGE, "lights.side", "lights: a "
                          "mask of an odd side (found %d)", p.side);
    light = calloc((size_t) p.lights + 1, sizeof *light);
    GP_TRY(own(plan, light));
    for (int i = 0; i < p.lights; i++) {
        light[i] = p.light[i];
        light[i].name[sizeof light[i].name - 1] = '\0';
        GP_TRY(gp_api_check(&plan->log, "light", &light[i]));
    }
    p.light = light;
    p.sun.name[sizeof p.sun.name - 1] = '\0';
    GP_TRY(gp_api_check(&plan->log, "light", &p.sun));
    plan->lights = p.lights || p.file || p.cameras;
    GP_TRY(keep(plan, &p.file));
    GP_TRY(keep(plan, &p.cameras));
    GP_TRY(keep(plan, &p.flare));
    plan->sun = p;
out:
    return st;
}

static gp_status take_scene(struct glarepp_plan *plan,
                            const struct glarepp_scene_params *from)
{
    struct glarepp_scene_params p = GLAREPP_SCENE_PARAMS;
    gp_status st;
    GP_TRY(gp_api_params(&plan->log, "scene", &p, sizeof p, from));
    GP_TRY(keep(plan, &p.path));
    GP_TRY(keep(plan, &p.camera));
    GP_TRY(keep_list(plan, &p.relight, p.relights));
    plan->scene = p;
    plan->lights |= p.path != NULL;
    plan->sun.faded |= p.path && p.light_scale > 0.0;
out:
    return st;
}

static gp_status take_lens(struct glarepp_plan *plan,
                           const struct glarepp_lens_params *from)
{
    struct glarepp_lens_params *const p = &plan->lens_params;
    struct gp_lens lens;
    gp_status st;
    *p = (struct glarepp_lens_params) GLAREPP_LENS_PARAMS;
    GP_TRY(gp_api_params(&plan->log, "lens", p, sizeof *p, from));
    GP_TRY(keep(plan, &p->lens));
    if (!p->lens)
        return GP_OK;
    GP_TRY(gp_lens_read(&plan->log, p->lens, &plan->lens));
    lens = plan->lens; // (is what they ask of it possible?)
    st = gp_lens_focus(&plan->log, &lens,
                       p->distance > 0.0 ? 1e3 * p->distance : INFINITY,
                       p->f_number);
out:
    return st;
}

static gp_status take_tone(struct glarepp_plan *plan,
                           const struct glarepp_tone_params *from)
{
    struct glarepp_tone_params p = GLAREPP_TONE_PARAMS;
    gp_status st;
    GP_TRY(gp_api_params(&plan->log, "tone", &p, sizeof p, from));
    GP_TRY(keep(plan, &p.curve));
    plan->tone = p;
    plan->converts = p.config && p.output;
    if (!p.config && !gp_tone_find(p.curve))
        st = gp_fail_at(&plan->log, GP_ERR_USAGE, "tone.curve", "tone: no curve "
                        "has this name (found %s)", p.curve);
    else if (p.config)
        st = gp_ocio_open(&plan->log, &p, &plan->ocio);
out:
    return st;
}

// -- what frames share --------------------------------------------------------

/* Pixels that kernels of models, which have no end, grow a frame by: farther out
 * only their smooth part is left. */
enum { MODEL_REACH = 2 * GP_FAR_CORE + 1 };

/* Takes a kernel; of an image makes the first one, as a bad one is an error
 * whatever the frames hold. */
static gp_status take_kernel(struct glarepp_plan *plan,
                             const struct gp_kernel_request *request,
                             struct gp_api_plan_kernel *out)
{
    const struct gp_image square =
        gp_image_blank((struct gp_rect) {0, 0, 1, 1});
    struct gp_made_kernel *first;
    gp_status st;
    bool made;
    out->request = request;
    GP_TRY(gp_kernels_make(&plan->log, request, &out->kept));
    out->reach =
        (struct gp_rect) {MODEL_REACH, MODEL_REACH, MODEL_REACH, MODEL_REACH};
    if (request->recipes)
        return GP_OK;
    struct gp_field field = gp_field_of(&square, 0.0);
    field.rotate = plan->rotate;
    GP_TRY(gp_kernels_take(&plan->log, out->kept, NULL, &field, &made, &first));
    const struct gp_kernel *const k = &first->k;
    out->reach =
        (struct gp_rect) {k->cx, k->cy, k->w - 1 - k->cx, k->h - 1 - k->cy};
    gp_made_kernel_free(&first);
out:
    return st;
}

static gp_status take_kernels(struct glarepp_plan *plan,
                              const struct glarepp_plan_params *p)
{
    gp_status st;
    gp_api_about("kernel");
    plan->names = p->names ? p->names : plan;
    if (!p->kernel)
        GP_TRY((gp_status) glarepp_kernel(plan->gp, NULL, &plan->own));
    GP_TRY(take_kernel(plan, &(p->kernel ? p->kernel : plan->own)->request,
                       plan->kernel));
    for (int i = 0; i < p->mores; i++)
        GP_TRY(take_kernel(plan, &p->more[i]->request, &plan->kernel[1 + i]));
out:
    return st;
}

static void free_work(const struct glarepp_plan *plan,
                      struct gp_api_work **work)
{
    struct gp_api_work *const w = *work;
    for (int i = 0; i < plan->kernels; i++)
        gp_glare_close(&w->engines[i]);
    gp_glare_close(&w->group_engines);
    if (w->lights)
        gp_api_lights_end(&w->lights);
    if (w->scene)
        gp_api_scene_end(&w->scene);
    GP_FREE(*work);
}

gp_status gp_api_lend(struct glarepp_plan *plan, struct gp_api_work **out)
{
    struct gp_api_work *w;
    gp_status st;
    pthread_mutex_lock(&plan->lock);
    w = plan->work;
    if (w)
        plan->work = w->next;
    pthread_mutex_unlock(&plan->lock);
    *out = w;
    if (w)
        return GP_OK;
    GP_TRY(gp_alloc_zero(
        &plan->log, "plan", 1,
        sizeof *w + (size_t) plan->kernels * sizeof *w->engines, &w));
    if (plan->lights || plan->sun.flare || plan->sun.found ||
        plan->lens_params.lens)
        GP_TRY(gp_api_lights_begin(plan, w));
    if (plan->scene.path)
        GP_TRY(gp_api_scene_begin(plan, w));
    *out = w;
    w = NULL;
out:
    if (w)
        free_work(plan, &w);
    return st;
}

void gp_api_give_back(struct glarepp_plan *plan, struct gp_api_work **work)
{
    if (!*work)
        return;
    if ((*work)->lights)
        gp_suns_end_frame(&(*work)->lights->suns);
    pthread_mutex_lock(&plan->lock);
    (*work)->next = plan->work;
    plan->work = *work;
    pthread_mutex_unlock(&plan->lock);
    *work = NULL;
}

/* Lists the files that a plan was read from, and the names of OpenColorIO. */
static gp_status fill_facts(struct glarepp_plan *plan,
                            const struct gp_api_work *w)
{
    struct glarepp_plan_facts *const f = &plan->facts;
    const struct gp_flare none = {0};
    const struct gp_flare *const flare =
        w->lights ? &w->lights->suns.flare : &none;
    const char *const own[] = {plan->sun.file, plan->sun.cameras, flare->path,
                               plan->lens_params.lens, plan->scene.path};
    if (plan->ocio)
        *f = *gp_ocio_facts(plan->ocio);
    const char *const *const more = f->file;
    const int n = f->files;
    const gp_status st =
        gp_alloc(&plan->log, "file names", 5 + (size_t) flare->n + (size_t) n,
                 sizeof *plan->file, &plan->file);
    if (st)
        return st;
    f->file = plan->file;
    f->files = 0;
    for (int i = 0; i < 5; i++) {
        if (own[i])
            plan->file[f->files++] = own[i];
    }
    for (int i = 0; i < flare->n; i++) {
        if (flare->element[i].path)
            plan->file[f->files++] = flare->element[i].path;
    }
    for (int i = 0; i < n; i++)
        plan->file[f->files++] = more[i];
    f->lights = plan->lights;
    return GP_OK;
}

// -- the handle ---------------------------------------------------------------

int glarepp_plan(struct glarepp *gp, const struct glarepp_plan_params *from,
                 struct glarepp_plan **out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    struct glarepp_plan_params p = GLAREPP_PLAN_PARAMS;
    struct glarepp_plan *plan = NULL;
    struct gp_api_work *work = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_api_params(&gp->log, "plan", &p, sizeof p, from));
    const int kernels = 1 + p.mores;
    GP_TRY(gp_alloc_zero(&gp->log, "plan", 1,
                         sizeof *plan + (size_t) kernels * sizeof *plan->kernel,
                         &plan));
    pthread_mutex_init(&plan->lock, NULL);
    plan->kernels = kernels;
    plan->gp = gp;
    plan->log = gp->log;
    plan->fov = p.fov;
    plan->rotate = p.rotate;
    plan->projection = p.projection;
    if (p.fov >= 180.0 && p.projection != GLAREPP_FISHEYE &&
        p.projection != GLAREPP_EQUISOLID)
        GP_TRY(gp_fail_at(&gp->log, GP_ERR_USAGE, "plan.fov.wide",
                          "fov: %g degrees are more than a plane can show",
                          p.fov));
    GP_TRY(take_sense(plan, p.sense));
    GP_TRY(take_layer(plan, p.layer));
    GP_TRY(take_lights(plan, p.lights));
    GP_TRY(take_lens(plan, p.lens));
    GP_TRY(take_scene(plan, p.scene));
    if (plan->sun.outside == GLAREPP_BY_SCENE && !plan->scene.path)
        GP_TRY(gp_fail_at(&gp->log, GP_ERR_USAGE, "lights.outside", "lights: "
                          "shares by a scene, and there is none"));
    if (plan->sun.share_by == GLAREPP_SHARES_SCENE &&
        (!plan->scene.path || plan->sun.method != GLAREPP_EXACT))
        GP_TRY(gp_fail_at(&gp->log, GP_ERR_USAGE, "lights.share_by",
                          "lights: shares by a scene's rays, and no scene, or "
                          "by GL"));
    GP_TRY(take_kernels(plan, &p));
    GP_TRY(take_tone(plan, p.tone));
    GP_TRY(gp_api_lend(plan, &work)); // so that errors of it come first
    GP_TRY(fill_facts(plan, work));
    *out = plan;
out:
    if (work)
        gp_api_give_back(plan, &work);
    if (st)
        glarepp_plan_end(&plan);
    return gp_api_end(outer, st);
}

void glarepp_plan_end(struct glarepp_plan **handle)
{
    struct glarepp_plan *const plan = *handle;
    if (!plan)
        return;
    struct glarepp *const outer = gp_api_begin(plan->gp);
    while (plan->work) {
        struct gp_api_work *w = plan->work;
        plan->work = w->next;
        free_work(plan, &w);
    }
    for (int i = 0; i < plan->kernels; i++)
        gp_kernels_free(&plan->kernel[i].kept);
    glarepp_kernel_end(&plan->own);
    if (plan->ocio)
        gp_ocio_close(&plan->ocio);
    for (int i = 0; i < plan->texts; i++)
        free(plan->text[i]);
    gp_free(plan->file);
    pthread_mutex_destroy(&plan->lock);
    GP_FREE(*handle);
    (void) gp_api_end(outer, GP_OK);
}

const struct glarepp_plan_facts *
glarepp_plan_facts(const struct glarepp_plan *plan)
{
    return &plan->facts;
}
