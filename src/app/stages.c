#include "app/stages.h"

#include "core/memory.h"
#include "core/parallel.h"
#include "glare/outline.h"
#include "io/channels.h"

#include <stdlib.h>
#include <string.h>

// -- read to glare -----------------------------------------------------------

static gp_status find_depth(struct gp_run *r)
{
    const struct gp_frame *f = &r->frame;
    int i = -1;
    // only a channel that was asked for can be missing
    gp_status st = gp_find_depth(r->s->depth ? r->log : NULL, f, r->s->depth,
                                 &i);
    if (st && r->s->depth)
        return st;
    if (!st && i >= 0) {
        r->facts.depth = f->channel[i].name;
        r->facts.depth_type = f->channel[i].type;
    }
    return GP_OK;
}

static gp_status run_read(struct gp_run *r)
{
    const struct gp_members *const m = &r->jobs->members;
    const int i = (int) (r->job - r->jobs->job);
    gp_status st = m->n ? gp_members_frame(r->log, &r->s->read, r->job->input,
                                           m, i, &r->frame)
                        : gp_read_frame(r->log, &r->s->read, r->job->input,
                                        &r->frame);
    if (st)
        return st;
    r->facts.width = gp_frame_w(&r->frame);
    r->facts.height = gp_frame_h(&r->frame);
    r->facts.ocio = r->ocio ? gp_ocio_names(r->ocio) : NULL;
    return gp_suns_wanted(&r->s->sun) ? GP_OK : find_depth(r);
}

/* Where the lights are, and how much of each shows. */
static gp_status run_suns(struct gp_run *r)
{
    gp_status st = gp_suns_place(r->log, r->s, r->job, &r->frame, &r->suns);
    if (!st)
        st = gp_suns_see(r->log, r->s, &r->suns);
    if (st)
        return st;
    r->facts.light = r->suns.light;
    r->facts.lights = r->suns.n;
    r->facts.occluders = &r->suns.occluders;
    r->facts.sun_way = gp_suns_way(r->s, &r->suns);
    if (r->suns.gl)
        r->facts.sun_gl = gp_gl_name(r->suns.gl);
    return GP_OK;
}

static bool suns_asked(const struct gp_settings *s)
{
    return gp_suns_wanted(&s->sun);
}

static gp_status run_sensors(struct gp_run *r)
{
    gp_status st = gp_sense(r->log, &r->s->sensor, &r->frame, &r->sources);
    if (st)
        return st;
    r->facts.sources = (long long) r->sources.n;
    r->facts.nonfinite = r->sources.nonfinite;
    r->facts.clamped = r->sources.clamped;
    memcpy(r->facts.flux_in, r->sources.flux, sizeof r->facts.flux_in);
    return GP_OK;
}

gp_status gp_run_read_kernel(struct gp_run *r)
{
    struct gp_frame image = {0};
    if (strncmp(r->s->kernel.source, "builtin:", 8) == 0)
        return GP_OK;
    gp_status st = gp_read_frame(r->log, &r->s->read, r->s->kernel.source,
                                 &image);
    if (!st)
        st = gp_kernel_from_frame(r->log, &r->s->kernel, &image, &r->kernel);
    gp_frame_free(&image);
    r->has_kernel = !st;
    return st;
}

/* Builtin kernels wait for light. */
static gp_status run_kernel(struct gp_run *r)
{
    if (r->has_kernel || (r->sources.n == 0 && !gp_suns_glare(&r->suns)))
        return GP_OK;
    gp_status st = gp_kernel_builtin(r->log, &r->s->kernel, &r->kernel);
    r->has_kernel = !st;
    return st;
}

/* What the engines get: bright pixels, and lights whose share is known. */
static const struct gp_sources *all_light(const struct gp_run *r)
{
    return r->joined.n ? &r->joined : &r->sources;
}

static gp_status run_glare(struct gp_run *r)
{
    bool joined;
    gp_status st = gp_suns_join(r->log, r->s, &r->suns, &r->frame,
                                &r->sources, &r->joined, &joined);
    if (st)
        return st;
    r->facts.sources = (long long) all_light(r)->n;
    memcpy(r->facts.flux_in, all_light(r)->flux, sizeof r->facts.flux_in);
    if (all_light(r)->n > 0)
        return gp_glare_run(r->log, &r->glare, &r->engines, all_light(r),
                            &r->kernel, &r->frame, &r->facts.glare);
    r->facts.glare = (struct gp_glare_stats) {
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

static gp_status run_flux(struct gp_run *r)
{
    int h = gp_frame_h(&r->frame);
    void *sums;
    r->facts.has_flux_out = true;
    if (!r->frame.layer.c[0])
        return GP_OK;
    gp_status st = gp_alloc(r->log, "flux", (size_t) h, sizeof(double), &sums);
    if (st)
        return st;
    for (int c = 0; c < 3; c++) {
        struct row_sums s = {r->frame.layer.c[c], gp_frame_w(&r->frame), sums};
        gp_parallel_do(h, sum_row, &s);
        for (int y = 0; y < h; y++)
            r->facts.flux_out[c] += s.sum[y];
    }
    gp_free(sums);
    return GP_OK;
}

static gp_status run_verify(struct gp_run *r)
{
    void *exact;
    if (all_light(r)->n == 0)
        return GP_OK;
    gp_status st = gp_alloc(r->log, "exact layer",
                            3 * gp_frame_pixels(&r->frame), sizeof(double),
                            &exact);
    if (st)
        return st;
    st = gp_glare_reference(r->log, all_light(r), &r->kernel, exact);
    if (!st) {
        gp_glare_measure(&r->frame, &r->frame.layer, exact,
                         r->s->compose.gain, &r->facts.error);
        r->facts.verified = true;
    }
    gp_free(exact);
    return st;
}

static gp_status make_dark_layer(struct gp_run *r);

/* Lens flare, and the glare of lights that the engines were not given. */
static gp_status run_flare(struct gp_run *r)
{
    if (!gp_suns_add_light(r->s, &r->suns)) // shares alone
        return gp_suns_draw(r->log, r->s, &r->suns, &r->kernel, &r->frame);
    gp_status st = r->frame.layer.c[0] ? GP_OK : make_dark_layer(r);
    return st ? st : gp_suns_draw(r->log, r->s, &r->suns, &r->kernel,
                                  &r->frame);
}

static gp_status run_compose(struct gp_run *r)
{
    struct gp_compose_params p = r->s->compose;
    p.dim = r->s->sun.adapt * (float) gp_suns_mean(&r->suns);
    return gp_compose(r->log, &p, &r->sources, &r->frame);
}

static gp_status run_tonemap(struct gp_run *r)
{
    return r->ocio ? gp_ocio_show(r->log, r->ocio, &r->s->tone, &r->frame)
                   : gp_tone_map(r->log, &r->s->tone, &r->frame, NULL);
}

// -- write -------------------------------------------------------------------

/* True when -o gets the light itself. */
static bool untoned(const struct gp_settings *s)
{
    return strcmp(s->tone.curve, "none") == 0;
}

/* A dark frame's layer, for those who want it written. */
static gp_status make_dark_layer(struct gp_run *r)
{
    struct gp_planes *p = &r->frame.layer;
    size_t n = gp_frame_pixels(&r->frame);
    gp_status st = gp_planes_make(r->log, "layer", n, p);
    for (int c = 0; c < 3 && !st; c++)
        memset(p->c[c], 0, n * sizeof(float));
    return st;
}

static gp_status write_layer(struct gp_run *r, const char *name,
                             struct gp_write_stats *stats)
{
    gp_status st = r->frame.layer.c[0] ? GP_OK : make_dark_layer(r);
    if (st)
        return st;
    return gp_write_picture(r->log, &r->s->write, name, &r->frame,
                            &r->frame.layer, GP_PICTURE_SCENE, stats);
}

static gp_status write_sensors(struct gp_run *r, const char *name,
                               struct gp_write_stats *stats)
{
    struct gp_planes p = {0};
    gp_status st = gp_sources_planes(r->log, &r->sources, &p);
    if (!st)
        st = gp_write_picture(r->log, &r->s->write, name, &r->frame, &p,
                              GP_PICTURE_SCENE, stats);
    gp_planes_free(&p);
    return st;
}

/* What -o shows. */
static gp_status write_shown(struct gp_run *r, const char *name,
                             const struct gp_planes *planes,
                             struct gp_write_stats *stats)
{
    const enum gp_picture_kind kind = r->ocio        ? GP_PICTURE_ENCODED
                                      : untoned(r->s) ? GP_PICTURE_SCENE
                                                      : GP_PICTURE_SHOWN;
    return gp_write_picture(r->log, &r->s->write, name, &r->frame, planes,
                            kind, stats);
}

static gp_status write_polygons(struct gp_run *r, const char *name,
                                struct gp_write_stats *stats)
{
    const struct gp_planes *const shown =
        untoned(r->s) ? &r->frame.lit : &r->frame.shown;
    const size_t n = gp_frame_pixels(&r->frame);
    struct gp_planes p = {0};
    gp_status st = gp_planes_make(r->log, "polygons", n, &p);
    for (int c = 0; c < 3 && !st; c++)
        memcpy(p.c[c], shown->c[c], n * sizeof(float));
    if (!st && r->sources.n > 0)
        st = gp_outline(r->log, &r->sources, &r->kernel, &r->glare.splat, &p);
    if (!st)
        st = write_shown(r, name, &p, stats);
    gp_planes_free(&p);
    return st;
}

/* Sun maps and intensity map are pictures of their own size. */
static gp_status write_map(struct gp_run *r, bool intensity, const char *name,
                           struct gp_write_stats *stats)
{
    struct gp_frame f = r->frame;
    struct gp_planes p = {0};
    int w, h;
    gp_status st = gp_suns_picture(r->log, r->s, &r->suns, intensity, &w, &h,
                                   &p);
    if (!st) {
        f.data = f.display = (struct gp_rect) {0, 0, w, h};
        st = gp_write_picture(r->log, &r->s->write, name, &f, &p,
                              GP_PICTURE_SHOWN, stats);
    }
    gp_planes_free(&p);
    return st;
}

static gp_status write_hdr(struct gp_run *r, const char *name,
                           struct gp_write_stats *stats)
{
    struct gp_planes p = {0};
    gp_status st = GP_OK;
    if (r->s->ocio.output)
        st = gp_ocio_convert(r->log, r->ocio, &r->frame, &p);
    const struct gp_hdr_colour colour = {
        &r->frame, p.c[0] ? &p : &r->frame.lit,
    };
    if (!st)
        st = gp_write_hdr(r->log, &r->s->write, name, &colour, 1, stats);
    gp_planes_free(&p);
    return st;
}

static gp_status write_target(struct gp_run *r, enum gp_target_kind kind,
                              const char *name, struct gp_write_stats *stats)
{
    const struct gp_frame *f = &r->frame;
    switch (kind) {
    case GP_TARGET_HDR:
        return write_hdr(r, name, stats);
    case GP_TARGET_LAYER:
        return write_layer(r, name, stats);
    case GP_TARGET_PICTURE:
        return write_shown(r, name, untoned(r->s) ? &f->lit : &f->shown,
                           stats);
    case GP_TARGET_SENSORS:
        return write_sensors(r, name, stats);
    case GP_TARGET_POLYGONS:
        return write_polygons(r, name, stats);
    case GP_TARGET_SUNMAP:
    case GP_TARGET_INTENSITY:
        return write_map(r, kind == GP_TARGET_INTENSITY, name, stats);
    }
    return GP_ERR_BUG;
}

static gp_status run_write(struct gp_run *r)
{
    struct gp_write_stats stats = {.raw = r->raw};
    for (int i = 0; i < r->jobs->targets; i++) {
        const struct gp_output *t = &r->jobs->target[i];
        r->names[i] = gp_job_name(r->job, t);
        if (!r->names[i])
            return gp_fail(r->log, GP_ERR_BUG, "%s: out of memory",
                           t->name.path);
        gp_status st = write_target(r, t->kind, r->names[i], &stats);
        if (st)
            return st;
        r->facts.n_outputs++;
    }
    r->facts.clamped_out = stats.clamped;
    r->raw = stats.raw;
    return GP_OK;
}

// -- all of them -------------------------------------------------------------

enum {
    RGB = GP_HAS_RGB, SOURCES = GP_HAS_SOURCES, KERNEL = GP_HAS_KERNEL,
    LAYER = GP_HAS_LAYER, LIT = GP_HAS_LIT, SUNS = GP_HAS_SUNS,
    FLARE = GP_HAS_FLARE,
};
const struct gp_stage gp_stages[GP_STAGES] = {
    {"read", GP_TIME_READ, 0, RGB, run_read, NULL},
    {"sun", GP_TIME_SUN, RGB, SUNS, run_suns, suns_asked},
    {"sensors", GP_TIME_SENSORS, RGB, SOURCES, run_sensors, NULL},
    {"kernel", -1, SOURCES | SUNS, KERNEL, run_kernel, NULL},
    {"glare", GP_TIME_GLARE, SOURCES | KERNEL | SUNS, LAYER, run_glare, NULL},
    {"verify", -1, RGB | SOURCES | KERNEL | LAYER, GP_HAS_MEASURED,
     run_verify, NULL},
    {"flare", GP_TIME_SUN, LAYER | KERNEL | SUNS, FLARE, run_flare,
     suns_asked},
    {"flux", -1, LAYER | FLARE, GP_HAS_FLUX, run_flux, NULL},
    {"compose", GP_TIME_COMPOSE, RGB | SOURCES | LAYER | FLARE, LIT,
     run_compose, NULL},
    {"tonemap", GP_TIME_TONEMAP, LIT, GP_HAS_SHOWN, run_tonemap, NULL},
    {"write", GP_TIME_WRITE, 0, GP_HAS_FILES, run_write, NULL},
};

unsigned gp_target_needs(const struct gp_settings *s,
                         enum gp_target_kind kind)
{
    switch (kind) {
    case GP_TARGET_HDR:
        return GP_HAS_LIT;
    case GP_TARGET_LAYER:
        return GP_HAS_LAYER | GP_HAS_FLARE;
    case GP_TARGET_PICTURE:
        return untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN;
    case GP_TARGET_SENSORS:
        return GP_HAS_SOURCES;
    case GP_TARGET_POLYGONS:
        return GP_HAS_SOURCES | GP_HAS_KERNEL |
               (untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN);
    case GP_TARGET_SUNMAP:
    case GP_TARGET_INTENSITY:
        return GP_HAS_FLARE;
    }
    return 0;
}

void gp_run_release(struct gp_run *r, unsigned dead)
{
    if (dead & GP_HAS_RGB)
        gp_planes_free(&r->frame.rgb);
    if (dead & GP_HAS_SOURCES) {
        gp_sources_free(&r->sources);
        gp_sources_free(&r->joined);
    }
    if (dead & GP_HAS_LAYER)
        gp_planes_free(&r->frame.layer);
    if (dead & GP_HAS_LIT)
        gp_planes_free(&r->frame.lit);
    if (dead & GP_HAS_SHOWN)
        gp_planes_free(&r->frame.shown);
}
