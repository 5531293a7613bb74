// SPDX-License-Identifier: Apache-2.0
/* The steps of a frame that are not its lights', its lens's and its scene's; and
 * the order of all. */
#include "api/plan.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "tone/tone.h"

#include <math.h>
#include <string.h>

// -- sources ------------------------------------------------------------------

/* Multiplies a list of sources by the mask. */
static gp_status mask_list(struct glarepp_frame *f, struct gp_sources *s)
{
    struct gp_sources own = *s;
    *s = (struct gp_sources) {0};
    const gp_status st =
        own.row ? gp_sources_scale(&f->log, &own, 1.0, &f->source_mask, s)
                : GP_OK;
    gp_sources_free(&own);
    return st;
}

/* Multiplies the sources by the mask, those of groups too. What they were is
 * kept: the edges are those of the whole picture, so that a mask and its inverse
 * add up to no mask. */
static gp_status mask_sources(struct glarepp_frame *f)
{
    gp_status st;
    f->whole = f->sources;
    f->sources = (struct gp_sources) {0};
    GP_TRY(gp_sources_scale(&f->log, &f->whole, 1.0, &f->source_mask,
                            &f->sources));
    GP_TRY(mask_list(f, &f->taken));
    for (int i = 0; i < f->plan->kernels; i++)
        GP_TRY(mask_list(f, &f->run[i].sources));
    for (int i = 0; i < f->groups; i++)
        GP_TRY(mask_list(f, &f->group[i].sources));
out:
    return st;
}

/* Returns the luminance of a sum over pixels of the frame. */
static double luminance_of(const struct gp_image *image, const double sum[3])
{
    double y = 0.0;
    for (int c = 0; c < 3; c++)
        y += (double) image->luminance[c] * sum[c];
    return y;
}

/* Returns the luminance that a kernel of the plan spreads of sources. */
static double spread_of(const struct glarepp_frame *f, int kernel,
                        const struct gp_sources *src)
{
    return gp_kernel_request_share(f->plan->kernel[kernel].request) *
           luminance_of(&f->image, src->flux);
}

/* Finds the largest luminance of a frame without sources. */
static void find_peak(struct glarepp_frame *f)
{
    struct glarepp_sense_facts *const facts = &f->facts.sense;
    for (int i = f->groups ? 0 : -1; i < f->groups; i++) {
        int at[2];
        const float peak = gp_luminance_peak(
            i < 0 ? &f->image : &f->group[i].image, at);
        if (i <= 0 || peak > facts->peak) {
            facts->peak = peak;
            memcpy(facts->peak_at, at, sizeof at);
        }
    }
}

static gp_status sense(struct glarepp_frame *f)
{
    struct glarepp_sense_facts *const facts = &f->facts.sense;
    const struct gp_sources *const src = &f->sources;
    double sum[3], squares;
    glarepp_frame_drop(f, 1u << GLAREPP_SOURCES | 1u << GLAREPP_TRUTH);
    const bool sphere = gp_api_wide(f).kind == GP_LATLONG;
    gp_status st =
        gp_sense(&f->log, &f->plan->sense, sphere, &f->image, &f->sources);
    if (!st && f->groups)
        st = gp_api_sense_groups(f);
    if (!st && f->source_mask.v)
        st = mask_sources(f);
    if (st)
        return st;
    *facts = (struct glarepp_sense_facts) {
        .sources = (long long) src->n, .nonfinite = src->nonfinite,
        .clamped = src->clamped, .threshold = src->threshold,
        .brightest = src->brightest,
    };
    memcpy(facts->flux, src->flux, sizeof facts->flux);
    memcpy(facts->faint, src->faint, sizeof facts->faint);
    memcpy(facts->flux_clamped, src->flux_clamped, sizeof facts->flux_clamped);
    if (!src->n)
        find_peak(f);
    bool adapts = false;
    for (int k = 0; k < f->plan->kernels; k++) {
        const struct gp_kernel_request *const r = f->plan->kernel[k].request;
        for (int i = 0; i < r->recipes; i++)
            adapts = adapts || gp_recipe_adapts(&r->recipe[i]);
    }
    if (adapts) {
        f->white = f->p.white > 0.0 ? f->p.white : GP_USUAL_WHITE;
        f->mean = gp_mean_luminance(&f->image, &f->image.rgb);
    }
    if (f->p.veil)
        st = gp_api_veil(f);
    if (st)
        return st;
    if (f->p.details) {
        gp_planes_sum(&f->image.rgb, gp_image_pixels(&f->image), sum, &squares);
        facts->light = luminance_of(&f->image, sum);
        for (int k = 0; k < f->plan->kernels; k++)
            facts->bright += spread_of(f, k, gp_api_bright(f, k));
    }
    const struct gp_api_lights *const lights = f->work ? f->work->lights : NULL;
    if (lights && f->ran & 1u << GLAREPP_SHARES)
        gp_api_warn_of_lights(f);
    return lights && gp_api_spots(f->plan, &lights->suns) ? gp_api_spot(f)
                                                          : GP_OK;
}

// -- reach --------------------------------------------------------------------

/* Pixels of the image that a kernel reaches in a frame of a field. */
static struct glarepp_rect reach_of(const struct gp_api_plan_kernel *k,
                                    const struct gp_field *field)
{
    const struct gp_rect reach = k->reach;
    // in degrees, the first kernel is of the image's own size
    const double down = !k->request->recipes && k->request->degrees > 0.0
                            ? gp_kernel_request_scale(k->request, field)
                            : 1.0;
    const double across = down / field->aspect;
    const double high = down == 1.0 ? 0.0 : 1.0;   // resampling reaches into
    const double wide = across == 1.0 ? 0.0 : 1.0; // one pixel more
    return (struct glarepp_rect) {
        gp_max((int) (reach.x0 * across + wide), 0),
        gp_max((int) (reach.y0 * down + high), 0),
        gp_max((int) (reach.x1 * across + wide), 0),
        gp_max((int) (reach.y1 * down + high), 0),
    };
}

/* Lends work to a frame that has none, and tells it what frame that is. */
static gp_status lend(struct glarepp_frame *f)
{
    const gp_status st = f->work ? GP_OK : gp_api_lend(f->plan, &f->work);
    if (!st && f->work->lights)
        f->work->lights->suns.wide = gp_api_wide(f);
    return st;
}

struct glarepp_rect glarepp_frame_reach(struct glarepp_frame *f)
{
    struct glarepp *const outer = gp_api_begin(f->plan->gp);
    struct gp_field field = {.aspect = 1.0}; // where memory is full
    struct glarepp_kernel_facts unused;
    struct glarepp_rect all = {0};
    if (lend(f) == GP_OK)
        field = gp_api_field(f, &unused);
    for (int i = 0; i < f->plan->kernels; i++) {
        const struct glarepp_rect one = reach_of(&f->plan->kernel[i], &field);
        all = (struct glarepp_rect) {
            gp_max(all.x0, one.x0),
            gp_max(all.y0, one.y0),
            gp_max(all.x1, one.x1),
            gp_max(all.y1, one.y1),
        };
    }
    gp_api_give_back(f->plan, &f->work);
    (void) gp_api_end(outer, GP_OK);
    return all;
}

// -- layer --------------------------------------------------------------------

static gp_status add_layer(struct glarepp_frame *f)
{
    struct glarepp_sense_facts *const facts = &f->facts.sense;
    struct gp_api_lights *const lights = f->work->lights;
    gp_status st = GP_OK;
    if (lights)
        st = gp_suns_join(&f->log, &lights->suns, &f->image,
                          gp_api_bright(f, 0), &f->joined);
    if (st)
        return st;
    const struct gp_sources *const light = gp_api_light(f, 0);
    facts->sources = (long long) light->n;
    memcpy(facts->flux, light->flux, sizeof light->flux);
    memcpy(facts->faint, light->faint, sizeof light->faint);
    for (int i = 1; i < f->plan->kernels; i++) {
        facts->sources += (long long) f->run[i].sources.n;
        for (int c = 0; c < 3; c++)
            facts->flux[c] += f->run[i].sources.flux[c];
    }
    if (f->p.details)
        facts->lamps =
            spread_of(f, 0, light) - spread_of(f, 0, gp_api_bright(f, 0));
    f->tinted = false;
    for (int i = 0; i < GP_PARTS; i++) // were of the layer before
        gp_planes_free(&f->part[i]);
    for (int i = 0; i < f->groups; i++)
        gp_planes_free(&f->group[i].part);
    st = gp_api_layers(f);
    if (f->flat && facts->sources) // of true angles
        f->facts.layer.bound = f->facts.layer.bound_pixel = INFINITY;
    return st;
}

static gp_status verify(struct glarepp_frame *f)
{
    gp_status st = GP_OK;
    if (!f->exact)
        st = gp_api_exact(f, &f->exact);
    if (!f->exact)
        return st;
    gp_glare_measure(&f->image, &f->image.layer, f->exact, &f->sample,
                     f->plan->compose.gain, gp_api_taken(f), &f->facts.errors);
    f->facts.verified = true;
    if (!f->p.details)
        GP_FREE(f->exact);
    return GP_OK;
}

// -- composing ----------------------------------------------------------------

#define BIT(step) (1u << GLAREPP_##step)

/* Ends the layer once all of it is there: parts it by groups, tints it. Nothing more
 * may be added to it. */
static gp_status end_layer(struct glarepp_frame *f)
{
    const size_t n = gp_image_pixels(&f->image);
    gp_status st = GP_OK;
    if (f->p.parts_of_groups && f->p.parts && f->groups && f->work &&
        !f->group[0].part.c[0] && f->ran & BIT(SENSE))
        GP_TRY(gp_api_part_groups(f));
    if (!f->plan->tints || f->tinted)
        return st;
    if (f->p.parts)
        GP_TRY(gp_api_dark_layer(&f->log, &f->image));
    gp_layer_tint(&f->plan->tint, false, &f->image);
    for (int i = 0; i < GP_PARTS + f->groups && f->p.parts; i++) {
        struct gp_image part = f->image; // (its other planes are borrowed)
        if (i < GP_PARTS)
            GP_TRY(gp_api_part_find(
                f, (enum glarepp_view)(GLAREPP_PART_VEIL + i)));
        part.layer = i < GP_PARTS ? f->part[i] : f->group[i - GP_PARTS].part;
        if (!part.layer.c[0])
            continue;
        gp_layer_tint(&f->plan->tint, true, &part);
        // where the sum was less than 0, all of it is black
        for (int c = 0; c < 3; c++) {
            for (size_t k = 0; k < n; k++)
                if (f->image.layer.c[c][k] == 0.0f)
                    part.layer.c[c][k] = 0.0f;
        }
    }
    f->tinted = true;
    f->ran |= BIT(FLARE) | BIT(LENS);
out:
    return st;
}

/* Adds up the layer, before composing takes it or, without that, at the end. */
static void note_flux(struct glarepp_frame *f)
{
    double squares;
    if (f->p.details && f->image.layer.c[0])
        gp_planes_sum(&f->image.layer, gp_image_pixels(&f->image),
                      f->facts.layer.flux, &squares);
}

static gp_status compose(struct glarepp_frame *f)
{
    struct glarepp_plan *const plan = f->plan;
    struct gp_compose_params p = plan->compose;
    if (f->work->lights)
        p.dim = plan->sun.adapt * (float) gp_suns_mean(&f->work->lights->suns);
    p.last = f->p.layer_ends;
    gp_status st = end_layer(f);
    if (st)
        return st;
    note_flux(f);
    if (plan->ocio) {
        pthread_mutex_lock(&plan->lock);
        gp_ocio_note(&f->log, plan->ocio, &f->image);
        pthread_mutex_unlock(&plan->lock);
    }
    const struct gp_sources *const taken = gp_api_taken(f);
    st = gp_compose(&f->log, &p, taken ? taken : &f->sources, &f->image);
    p.last = true;
    for (int i = 0; i < f->groups && !f->p.groups_glare && !st; i++)
        st = gp_api_compose_group(f, &f->group[i], &p);
    f->composed = true;
    return st;
}

static gp_status show(struct glarepp_frame *f)
{
    return f->plan->ocio ? gp_ocio_show(&f->log, f->plan->ocio,
                                        &f->plan->tone, &f->image)
                         : gp_tone_map(&f->log, &f->plan->tone, &f->image);
}

static gp_status finish(struct glarepp_frame *f)
{
    const gp_status st = end_layer(f);
    if (f->work && !f->composed)
        note_flux(f);
    gp_api_give_back(f->plan, &f->work);
    f->ran &= ~(BIT(POSE) | BIT(PLACE) | BIT(SHARES)); // were in its work
    return st;
}

// -- steps --------------------------------------------------------------------

static const struct {
    const char *name;
    gp_status (*run)(struct glarepp_frame *f);
    unsigned after; // bits of steps that it needs
    bool adds;      // what it adds would be there twice
} steps[GLAREPP_STEPS] = {
    [GLAREPP_POSE] = {"scene", gp_api_pose, 0, false},
    [GLAREPP_RELIGHT] = {"relight", gp_api_relight, BIT(POSE), true},
    [GLAREPP_PLACE] = {"lights", gp_api_place, 0, false},
    [GLAREPP_SHARES] = {"shares", gp_api_shares, BIT(PLACE), false},
    [GLAREPP_SENSE] = {"sensors", sense, 0, false},
    [GLAREPP_KERNEL] = {"kernel", gp_api_make_kernel, BIT(SENSE), false},
    [GLAREPP_LAYER] = {"glare", add_layer, BIT(SENSE) | BIT(KERNEL), false},
    [GLAREPP_VERIFY] = {"verify", verify, BIT(LAYER), false},
    [GLAREPP_FLARE] = {"flare", gp_api_flare, BIT(SENSE), true},
    [GLAREPP_LENS] = {"lens", gp_api_lens, BIT(SENSE), true},
    [GLAREPP_COMPOSE] = {"compose", compose, 0, false},
    [GLAREPP_TONE] = {"tonemap", show, BIT(COMPOSE), false},
    [GLAREPP_DONE] = {"done", finish, 0, false},
};

/* True where a plan asks for what a step does. */
static bool is_asked(const struct glarepp_plan *plan, enum glarepp_step step)
{
    return step == GLAREPP_POSE      ? plan->scene.path != NULL
           : step == GLAREPP_RELIGHT ? plan->scene.relights > 0
           : step == GLAREPP_LENS    ? plan->lens_params.lens != NULL
           : step == GLAREPP_PLACE || step == GLAREPP_SHARES ? plan->lights
           : step == GLAREPP_FLARE ? plan->lights || plan->sun.flare
                                   : true;
}

int glarepp_frame_run(struct glarepp_frame *f, enum glarepp_step step)
{
    const unsigned reads = BIT(RELIGHT) | BIT(SENSE) | BIT(VERIFY) | BIT(LENS) |
                           BIT(COMPOSE) |
                           (f->plan->sun.flare_gain > 0.0f ? 0u : BIT(FLARE));
    struct glarepp *const outer = gp_api_begin(f->plan->gp);
    const struct glarepp_params *const to = &f->plan->gp->params;
    gp_status st = GP_OK;
    if (step >= GLAREPP_STEPS)
        GP_TRY(gp_fail_at(&f->log, GP_ERR_USAGE, "step", "frame: no such step "
                          "(found %d)", (int) step));
    f->facts.engines_ms = f->facts.engines_cpu_ms = 0.0;
    if (!is_asked(f->plan, step))
        goto out;
    if (1u << step & reads && !f->image.rgb.c[0])
        GP_TRY(gp_api_refuse(f, "step", "its pixels were dropped before %s",
                             steps[step].name));
    if (steps[step].after & ~f->ran)
        GP_TRY(gp_api_refuse(f, "step", "a step that %s needs was not run",
                             steps[step].name));
    if (steps[step].adds && f->ran & 1u << step)
        GP_TRY(
            gp_api_refuse(f, "step", "%s is there already", steps[step].name));
    if (to->progress &&
        to->progress(to->user, steps[step].name, (double) step / GLAREPP_STEPS))
        GP_TRY(gp_fail(&f->plan->log, GP_ERR_CANCELLED, "%s: cancelled",
                       steps[step].name));
    if (!(1u << step & (BIT(TONE) | BIT(DONE) | BIT(VERIFY))))
        GP_TRY(lend(f));
    if (step == GLAREPP_LENS ||
        (step == GLAREPP_FLARE && f->work->lights->suns.flare.n > 0))
        GP_TRY(gp_api_has_axis(f));
    GP_TRY(steps[step].run(f));
    // (a layer made anew has none of what was added to it)
    f->ran &= ((1u << step) - 1) |
              (step == GLAREPP_LAYER ? 0u : BIT(FLARE) | BIT(LENS));
    f->ran |= 1u << step;
out:
    return gp_api_end(outer, st);
}

int glarepp_execute(struct glarepp_plan *plan, const struct glarepp_image *in,
                    const struct glarepp_image *out,
                    struct glarepp_facts *facts)
{
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_frame *f = NULL;
    int st;
    p.image = *in;
    st = glarepp_frame(plan, &p, &f);
    for (int i = 0; i < GLAREPP_STEPS && !st; i++) {
        if (i != GLAREPP_RELIGHT && i != GLAREPP_VERIFY && i != GLAREPP_TONE)
            st = glarepp_frame_run(f, (enum glarepp_step) i);
    }
    if (!st) {
        struct glarepp *const outer = gp_api_begin(plan->gp);
        st = gp_api_end(outer, gp_api_export(&f->log, &f->image.lit,
                                             f->image.data, out));
    }
    if (!st && facts) {
        *facts = f->facts;
        facts->light = NULL; // these end with the frame
        facts->relit = NULL;
        facts->lights = facts->relits = facts->kernel.recipes = 0;
        memset(facts->kernel.recipe, 0, sizeof facts->kernel.recipe);
    }
    glarepp_frame_end(&f);
    return st;
}
