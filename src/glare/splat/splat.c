/* Splat, the glare stage on GL: Ando et al., "Real-time rendering of high
 * quality glare images using vertex texture fetch on GPU" (2007).
 *
 * Each pixel of the sources' box is a sensor. Bright ones are grouped and
 * clustered into polygons that carry the kernel (group.h), blurred by as much
 * as the group is wide (blur.h), cut to where it counts.
 *   splat_plan   what is drawn, and the bound of its error; on the CPU
 *   splat_group  sensors, groups and clusters on GL
 *   splat_draw   polygons as blended quads or point sprites
 *   splat_tile   polygons gathered per tile, which a CPU rasterizer does
 *                several times faster than it blends
 *
 * One polygon a source, on whole pixels and not cut, is the exact sum up to
 * float rounding. */
#include "glare/costs.h"
#include "glare/direct/direct.h"
#include "glare/splat/draw.h"
#include "glare/splat/state.h"

#include <math.h>
#include <string.h>

/* -- predicting ------------------------------------------------------------ */

/* Pixels of a kernel's width from low to high around a centre that may be
 * anywhere in [from, to), those in [0, limit): the mean. */
static double mean_overlap(int from, int to, int low, int high, int limit)
{
    double sum = 0.0;
    for (int at = from; at < to; at++) {
        const double first = fmax((double) at + low, 0.0);
        const double end = fmin((double) at + high, (double) limit);
        sum += fmax(end - first, 0.0);
    }
    return to > from ? sum / (to - from) : 0.0;
}

/* Of the polygons alone, one for each full group. */
static double polygon_ms(const struct gp_glare_job *job, double polygons,
                         struct gp_rect crop)
{
    const struct gp_sources *const s = job->src;
    const struct gp_kernel *const k = job->kernel;
    const bool blended =
        job->params->splat.primitive == GP_PRIMITIVE_QUAD ||
        job->params->splat.primitive == GP_PRIMITIVE_POINT;
    const double area = mean_overlap(s->box.x0, s->box.x1, crop.x0 - k->cx,
                                     crop.x1 - k->cx, s->w) *
                        mean_overlap(s->box.y0, s->box.y1, crop.y0 - k->cy,
                                     crop.y1 - k->cy, s->h);
    const double sensors = (double) gp_rect_w(s->box) * gp_rect_h(s->box);
    if (blended)
        return GP_COST_GL_SENSOR * sensors +
               polygons * (GP_COST_GL_POLYGON + GP_COST_GL_BLEND * area);
    return polygons * GP_COST_GL_TILE * area;
}

static struct gp_prediction predict(const struct gp_glare_job *job,
                                    const void *state)
{
    const struct gp_splat *const kept = state;
    const struct gp_sources *const s = job->src;
    const struct gp_splat_params *const p = &job->params->splat;
    const struct gp_rect crop = gp_splat_crop(job->kernel, s->w, s->h, 1);
    if (s->n == 0 || gp_rect_empty(crop))
        return (struct gp_prediction) {.ms = 0.0};
    const double n = (double) s->n, area = (double) p->group * p->group;
    const double start = kept && kept->gl ? 0.0 : GP_COST_GL_START;
    if (job->enough > 0.0 && start > job->enough)
        return (struct gp_prediction) {.ms = start, .more = true};
    double ms = polygon_ms(job, ceil(n / area), crop) + GP_COST_GL_SOURCE * n +
          GP_COST_GL_TRANSFER * s->w * s->h;
    if (p->method == GP_GROUP_CORE && (p->group > 1 || p->cluster))
        ms += n * GP_COST_DIRECT_TAP *
              (2 * GP_CORE_RADIUS + 1) * (2 * GP_CORE_RADIUS + 1);
    return (struct gp_prediction) {.ms = start + ms, .later_ms = ms};
}

/* -- drawing --------------------------------------------------------------- */

static void clear_layer(const struct gp_glare_job *job)
{
    for (int c = 0; c < 3; c++)
        memset(job->layer->c[c], 0,
               (size_t) job->src->w * (size_t) job->src->h * sizeof(float));
}

/* The core of each single source, on the CPU: a software context has no
 * faster place, and blending squares of 17 pixels is what it does worst. */
static gp_status add_core(const struct gp_glare_job *job)
{
    struct gp_taps taps = {0};
    gp_status st = gp_taps_make(job->log, job->kernel, GP_CORE_RADIUS, &taps);
    if (!st)
        st = gp_direct_sum(job->log, job->src, &taps, true, job->layer);
    gp_taps_free(&taps);
    return st;
}

static gp_status draw_gathered(const struct gp_glare_job *job,
                               struct gp_splat *s)
{
    const struct gp_splat_plan *const p = &s->plan;
    double roundings;
    gp_status st = GP_OK;
    if (p->tail)
        st = gp_tiles_draw(job->log, s->gl, job->kernel, p->crop, p->core,
                           &p->polygons, &p->shrink, job->src->w, job->src->h,
                           job->layer, &s->tiles, &roundings);
    else
        clear_layer(job);
    return st || !p->core ? st : add_core(job);
}

/* -- the engine ------------------------------------------------------------ */

static bool reaches_nothing(const struct gp_glare_job *job)
{
    const struct gp_sources *const s = job->src;
    return s->n == 0 ||
           gp_rect_empty(gp_splat_crop(job->kernel, s->w, s->h, 1));
}

static gp_status bound(const struct gp_glare_job *job, void **state,
                       double *out)
{
    *out = 0.0;
    if (reaches_nothing(job))
        return GP_OK;
    gp_status st = gp_splat_make(job->log, state);
    if (st)
        return st;
    struct gp_splat *const s = *state;
    st = gp_splat_plan_make(job, &s->bounds, &s->plan);
    if (!st)
        *out = s->plan.bound;
    return st;
}

static enum gp_primitive form_of(const struct gp_splat *s)
{
    const enum gp_primitive asked = s->plan.params.primitive;
    if (asked != GP_PRIMITIVE_AUTO)
        return asked;
    return gp_gl_info(s->gl)->software ? GP_PRIMITIVE_TILE : GP_PRIMITIVE_QUAD;
}

static void publish(const struct gp_glare_job *job, const struct gp_splat *s)
{
    static const char *const forms[] = {
        [GP_PRIMITIVE_QUAD] = "blended quads",
        [GP_PRIMITIVE_POINT] = "blended points",
        [GP_PRIMITIVE_TILE] = "tiles, groups from the CPU",
    };
    const struct gp_splat_plan *const p = &s->plan;
    struct gp_glare_stats *const stats = job->stats;
    if (p->tail) {
        stats->groups = p->polygons.groups;
        stats->clusters = p->polygons.clusters;
        stats->polygons = p->polygons.n;
    }
    stats->cores = p->core ? job->src->n : 0;
    stats->polygon_pixels = p->polygon_pixels;
    stats->form = forms[form_of(s)];
    stats->bound = p->bound;
    stats->gl = gp_gl_info(s->gl)->name;
}

static gp_status run(const struct gp_glare_job *job, void **state)
{
    if (reaches_nothing(job)) {
        clear_layer(job);
        return GP_OK;
    }
    gp_status st;
    GP_TRY(gp_splat_make(job->log, state));
    struct gp_splat *const s = *state;
    GP_TRY(gp_splat_open(job->log, s, job->params->gl));
    GP_TRY(gp_splat_plan_make(job, &s->bounds, &s->plan));
    const enum gp_primitive form = form_of(s);
    if (form == GP_PRIMITIVE_TILE)
        GP_TRY(draw_gathered(job, s));
    else
        GP_TRY(gp_splat_draw(job, s, form == GP_PRIMITIVE_POINT));
    publish(job, s);
out:
    return st;
}

const struct gp_engine gp_engine_splat = {
    .name = "splat",
    .text = "glare polygons for bright pixels and groups of them, on GL",
    .predict = predict,
    .bound = bound,
    .run = run,
    .close = gp_splat_close,
};
