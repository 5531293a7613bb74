#include "app/stages.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "io/plane.h"

#include <string.h>

// -- read to glare -----------------------------------------------------------

/* What the report says of a depth that nothing reads. */
static gp_status name_depth(struct gp_run *r, struct gp_work *w)
{
    // only a channel that was asked for can be missing
    gp_status st = gp_name_depth(r->s->depth ? w->log : NULL, &w->frame,
                                 r->s->depth, &w->depth,
                                 &w->facts.depth_type);
    w->facts.depth = w->depth;
    if (st == GP_ERR_BUG && !r->s->depth)
        return gp_fail(w->log, st, "%s: out of memory", w->job->input);
    return r->s->depth ? st : GP_OK;
}

/* How the frame of a job is read: a view inside the file is asked for. */
static struct gp_read_params read_params(const struct gp_run *r,
                                         const struct gp_work *w)
{
    struct gp_read_params p = r->s->read;
    if (r->jobs->views_inside)
        p.view = w->job->view;
    return p;
}

static gp_status read_groups(struct gp_run *r, struct gp_work *w)
{
    const struct gp_read_params p = read_params(r, w);
    const struct gp_texts *const names = &r->s->light_groups;
    w->facts.light_group = names->at;
    w->facts.light_groups = names->n;
    return gp_light_groups_read(w->log, &p, &w->frame, names->at, names->n,
                                &w->groups);
}

static gp_status run_read(struct gp_run *r, struct gp_work *w)
{
    const struct gp_members *const m = &r->jobs->members;
    const int i = (int) (w->job - r->jobs->job) / r->jobs->views;
    const struct gp_read_params p = read_params(r, w);
    gp_status st = m->n ? gp_members_frame(w->log, &p, w->job->input, m, i,
                                           &w->frame)
                        : gp_read_frame(w->log, &p, w->job->input, &w->frame);
    if (!st && r->s->light_groups.n)
        st = read_groups(r, w);
    if (st)
        return st;
    w->facts.width = gp_frame_w(&w->frame);
    w->facts.height = gp_frame_h(&w->frame);
    w->facts.ocio = r->ocio ? gp_ocio_names(r->ocio) : NULL;
    return gp_suns_wanted(&r->s->sun) ? GP_OK : name_depth(r, w);
}

/* Where the lights are, and how much of each shows. */
static gp_status run_suns(struct gp_run *r, struct gp_work *w)
{
    gp_status st = gp_suns_place(w->log, r->s, w->job, &w->frame, &r->suns);
    if (!st)
        st = gp_suns_see(w->log, r->s, &r->suns);
    if (st)
        return st;
    w->facts.sun_way = gp_suns_way(r->s, &r->suns);
    if (r->suns.gl)
        w->facts.sun_gl = gp_gl_name(r->suns.gl);
    return GP_OK;
}

static bool suns_asked(const struct gp_settings *s)
{
    return gp_suns_wanted(&s->sun);
}

static gp_status run_sensors(struct gp_run *r, struct gp_work *w)
{
    gp_status st = gp_sense(w->log, &r->s->sensor, &w->frame, &w->sources);
    if (!st && w->groups.n)
        st = gp_light_groups_sense(w->log, &r->s->sensor, &w->groups,
                                   &w->sources);
    if (st)
        return st;
    w->facts.sources = (long long) w->sources.n;
    w->facts.nonfinite = w->sources.nonfinite;
    w->facts.clamped = w->sources.clamped;
    memcpy(w->facts.flux_in, w->sources.flux, sizeof w->facts.flux_in);
    return GP_OK;
}

gp_status gp_run_read_kernel(const struct gp_log *log, struct gp_run *r)
{
    struct gp_frame image = {0};
    if (strncmp(r->s->kernel.source, "builtin:", 8) == 0)
        return GP_OK;
    const struct gp_read_params limits = gp_read_limits(&r->s->read);
    gp_status st = gp_read_frame(log, &limits, r->s->kernel.source, &image);
    if (!st)
        st = gp_kernel_from_frame(log, &r->s->kernel, &image, &r->kernel);
    gp_frame_free(&image);
    r->has_kernel = !st;
    return st;
}

/* Builtin kernels wait for light. */
static gp_status run_kernel(struct gp_run *r, struct gp_work *w)
{
    if (r->has_kernel || (w->sources.n == 0 && !gp_suns_glare(&r->suns)))
        return GP_OK;
    gp_status st = gp_kernel_builtin(w->log, &r->s->kernel, &r->kernel);
    r->has_kernel = !st;
    return st;
}

/* What the engines get: bright pixels, and lights whose share is known. */
static const struct gp_sources *all_light(const struct gp_work *w)
{
    return w->joined.n ? &w->joined : &w->sources;
}

static gp_status run_glare(struct gp_run *r, struct gp_work *w)
{
    bool joined;
    gp_status st = gp_suns_join(w->log, r->s, &r->suns, &w->frame,
                                &w->sources, &w->joined, &joined);
    if (st)
        return st;
    w->facts.sources = (long long) all_light(w)->n;
    memcpy(w->facts.flux_in, all_light(w)->flux, sizeof w->facts.flux_in);
    if (all_light(w)->n > 0)
        return gp_glare_run(w->log, &r->glare, &r->engines, all_light(w),
                            &r->kernel, &w->frame, &w->facts.glare);
    w->facts.glare = (struct gp_glare_stats) {
        .engine = "none", .why = "no pixel is over the threshold",
    };
    return GP_OK;
}

/* Sums by rows, so that threads cannot change the last bit. */
struct row_sums {
    const float *plane;
    int w;
    double *sum;  // one a row
};

static void sum_row(void *ctx, int y, int thread)
{
    const struct row_sums *s = ctx;
    const float *row = s->plane + (size_t) y * (size_t) s->w;
    double sum = 0.0;
    (void) thread;
    for (int x = 0; x < s->w; x++)
        sum += (double) row[x];
    s->sum[y] = sum;
}

static gp_status run_flux(struct gp_run *r, struct gp_work *w)
{
    (void) r;
    int h = gp_frame_h(&w->frame);
    void *sums;
    w->facts.has_flux_out = true;
    if (!w->frame.layer.c[0])
        return GP_OK;
    gp_status st = gp_alloc(w->log, "flux", (size_t) h, sizeof(double), &sums);
    if (st)
        return st;
    for (int c = 0; c < 3; c++) {
        struct row_sums s = {w->frame.layer.c[c], gp_frame_w(&w->frame), sums};
        gp_parallel_do(h, sum_row, &s);
        for (int y = 0; y < h; y++)
            w->facts.flux_out[c] += s.sum[y];
    }
    gp_free(sums);
    return GP_OK;
}

static gp_status run_verify(struct gp_run *r, struct gp_work *w)
{
    void *exact;
    if (all_light(w)->n == 0)
        return GP_OK;
    gp_status st = gp_alloc(w->log, "exact layer",
                            3 * gp_frame_pixels(&w->frame), sizeof(double),
                            &exact);
    if (st)
        return st;
    st = gp_glare_reference(w->log, all_light(w), &r->kernel, exact);
    if (!st) {
        gp_glare_measure(&w->frame, &w->frame.layer, exact,
                         r->s->compose.gain, &w->facts.error);
        w->facts.verified = true;
    }
    gp_free(exact);
    return st;
}

/* Lens flare, and the glare of lights that the engines were not given. */
static gp_status run_flare(struct gp_run *r, struct gp_work *w)
{
    if (!gp_suns_add_light(r->s, &r->suns)) // shares alone
        return gp_suns_draw(w->log, r->s, &r->suns, &r->kernel, &w->frame);
    gp_status st = w->frame.layer.c[0] ? GP_OK : gp_work_dark_layer(w);
    return st ? st : gp_suns_draw(w->log, r->s, &r->suns, &r->kernel,
                                  &w->frame);
}

/* Copies what is known of the lights, which are the next frame's soon. */
static gp_status keep_lights(const struct gp_suns *suns, struct gp_work *w)
{
    const struct gp_occluders *const o = &suns->occluders;
    void *list;
    gp_status st = gp_alloc(w->log, "lights", (size_t) suns->n,
                            sizeof *w->light, &list);
    if (st)
        return st;
    w->light = list;
    if (suns->n)
        memcpy(w->light, suns->light, (size_t) suns->n * sizeof *w->light);
    w->depth = o->depth ? gp_strdup(o->depth->name) : NULL;
    w->mask = o->mask ? gp_strdup(o->mask->name) : NULL;
    if ((o->depth && !w->depth) || (o->mask && !w->mask))
        return gp_fail_bare(w->log, GP_ERR_BUG, "lights: out of memory");
    w->facts.light = w->light;
    w->facts.lights = suns->n;
    w->facts.depth = w->depth;
    w->facts.mask = w->mask;
    if (o->depth) {
        memcpy(w->facts.depth_empty, o->facts.empty, sizeof o->facts.empty);
        w->facts.depth_reversed = o->facts.reversed;
    }
    return GP_OK;
}

static gp_status keep_map(struct gp_run *r, struct gp_work *w, bool intensity,
                          struct gp_map_picture *out)
{
    return gp_suns_picture(w->log, r->s, &r->suns, intensity, &out->w, &out->h,
                           &out->planes);
}

/* The end of what the lights do. */
static gp_status run_keep(struct gp_run *r, struct gp_work *w)
{
    gp_status st = keep_lights(&r->suns, w);
    if (!st && r->s->debug[GP_DEBUG_SUNMAP])
        st = keep_map(r, w, false, &w->sunmap);
    if (!st && r->s->debug[GP_DEBUG_INTENSITY])
        st = keep_map(r, w, true, &w->intensity);
    return st;
}

static gp_status run_compose(struct gp_run *r, struct gp_work *w)
{
    struct gp_compose_params p = r->s->compose;
    p.dim = r->s->sun.adapt * (float) gp_suns_mean(&r->suns);
    gp_status st = gp_compose(w->log, &p, &w->sources, &w->frame);
    if (!st && r->s->hdr && w->groups.n) // which alone shows them
        st = gp_light_groups_light(w->log, &r->glare, &p, &r->kernel,
                                   &r->group_engines, &w->groups);
    return st;
}

static gp_status run_tonemap(struct gp_run *r, struct gp_work *w)
{
    return r->ocio ? gp_ocio_show(w->log, r->ocio, &r->s->tone, &w->frame)
                   : gp_tone_map(w->log, &r->s->tone, &w->frame, NULL);
}

// -- all of them -------------------------------------------------------------

enum {
    RGB = GP_HAS_RGB, SOURCES = GP_HAS_SOURCES, KERNEL = GP_HAS_KERNEL,
    LAYER = GP_HAS_LAYER, LIT = GP_HAS_LIT, SUNS = GP_HAS_SUNS,
    FLARE = GP_HAS_FLARE, SHARES = GP_HAS_SHARES,
};
const struct gp_stage gp_stages[GP_STAGES] = {
    {"read", GP_PHASE_READ, GP_TIME_READ, 0, RGB, run_read, NULL},
    {"sun", GP_PHASE_COMPUTE, GP_TIME_SUN, RGB, SUNS, run_suns, suns_asked},
    {"sensors", GP_PHASE_COMPUTE, GP_TIME_SENSORS, RGB, SOURCES, run_sensors,
     NULL},
    {"kernel", GP_PHASE_COMPUTE, -1, SOURCES | SUNS, KERNEL, run_kernel, NULL},
    {"glare", GP_PHASE_COMPUTE, GP_TIME_GLARE, SOURCES | KERNEL | SUNS, LAYER,
     run_glare, NULL},
    {"verify", GP_PHASE_COMPUTE, -1, RGB | SOURCES | KERNEL | LAYER,
     GP_HAS_MEASURED, run_verify, NULL},
    {"flare", GP_PHASE_COMPUTE, GP_TIME_SUN, LAYER | KERNEL | SUNS, FLARE,
     run_flare, suns_asked},
    {"flux", GP_PHASE_COMPUTE, -1, LAYER | FLARE, GP_HAS_FLUX, run_flux, NULL},
    {"compose", GP_PHASE_COMPUTE, GP_TIME_COMPOSE,
     RGB | SOURCES | KERNEL | LAYER | FLARE, LIT, run_compose, NULL},
    {"tonemap", GP_PHASE_COMPUTE, GP_TIME_TONEMAP, LIT, GP_HAS_SHOWN,
     run_tonemap, NULL},
    {"shares", GP_PHASE_COMPUTE, -1, FLARE, SHARES, run_keep, suns_asked},
    {"write", GP_PHASE_WRITE, GP_TIME_WRITE, SHARES, GP_HAS_FILES,
     gp_stage_write, NULL},
};
