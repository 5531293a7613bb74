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
    gp_status st = gp_read_frame(r->log, &r->s->read, r->job->input,
                                 &r->frame);
    if (st)
        return st;
    r->facts.width = gp_frame_w(&r->frame);
    r->facts.height = gp_frame_h(&r->frame);
    return find_depth(r);
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
    if (r->has_kernel || r->sources.n == 0)
        return GP_OK;
    gp_status st = gp_kernel_builtin(r->log, &r->s->kernel, &r->kernel);
    r->has_kernel = !st;
    return st;
}

static gp_status run_glare(struct gp_run *r)
{
    if (r->sources.n > 0)
        return gp_glare_run(r->log, &r->glare, &r->engines, &r->sources,
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
    if (r->sources.n == 0)
        return GP_OK;
    gp_status st = gp_alloc(r->log, "exact layer",
                            3 * gp_frame_pixels(&r->frame), sizeof(double),
                            &exact);
    if (st)
        return st;
    st = gp_glare_reference(r->log, &r->sources, &r->kernel, exact);
    if (!st) {
        gp_glare_measure(&r->frame, &r->frame.layer, exact,
                         r->s->compose.gain, &r->facts.error);
        r->facts.verified = true;
    }
    gp_free(exact);
    return st;
}

static gp_status run_compose(struct gp_run *r)
{
    return gp_compose(r->log, &r->s->compose, &r->sources, &r->frame);
}

static gp_status run_tonemap(struct gp_run *r)
{
    return gp_tone_map(r->log, &r->s->tone, &r->frame, NULL);
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
    return gp_write_picture(r->log, &r->s->write, name, &r->frame, planes,
                            untoned(r->s) ? GP_PICTURE_SCENE
                                          : GP_PICTURE_SHOWN, stats);
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

static gp_status write_target(struct gp_run *r, enum gp_target_kind kind,
                              const char *name, struct gp_write_stats *stats)
{
    const struct gp_write_params *p = &r->s->write;
    const struct gp_frame *f = &r->frame;
    switch (kind) {
    case GP_TARGET_HDR:
        return gp_write_hdr(r->log, p, name, f, &f->lit, stats);
    case GP_TARGET_LAYER:
        return write_layer(r, name, stats);
    case GP_TARGET_PICTURE:
        return write_shown(r, name, untoned(r->s) ? &f->lit : &f->shown,
                           stats);
    case GP_TARGET_SENSORS:
        return write_sensors(r, name, stats);
    case GP_TARGET_POLYGONS:
        return write_polygons(r, name, stats);
    }
    return GP_ERR_BUG;
}

static gp_status run_write(struct gp_run *r)
{
    struct gp_write_stats stats = {0};
    for (int i = 0; i < r->jobs->targets; i++) {
        const struct gp_target *t = &r->jobs->target[i];
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
    return GP_OK;
}

// -- all of them -------------------------------------------------------------

enum {
    RGB = GP_HAS_RGB, SOURCES = GP_HAS_SOURCES, KERNEL = GP_HAS_KERNEL,
    LAYER = GP_HAS_LAYER, LIT = GP_HAS_LIT,
};
const struct gp_stage gp_stages[GP_STAGES] = {
    {"read", GP_TIME_READ, 0, RGB, run_read},
    {"sensors", GP_TIME_SENSORS, RGB, SOURCES, run_sensors},
    {"kernel", -1, SOURCES, KERNEL, run_kernel},
    {"glare", GP_TIME_GLARE, SOURCES | KERNEL, LAYER, run_glare},
    {"flux", -1, LAYER, GP_HAS_FLUX, run_flux},
    {"verify", -1, RGB | SOURCES | KERNEL | LAYER, GP_HAS_MEASURED,
     run_verify},
    {"compose", GP_TIME_COMPOSE, RGB | SOURCES | LAYER, LIT, run_compose},
    {"tonemap", GP_TIME_TONEMAP, LIT, GP_HAS_SHOWN, run_tonemap},
    {"write", GP_TIME_WRITE, 0, GP_HAS_FILES, run_write},
};

unsigned gp_target_needs(const struct gp_settings *s,
                         enum gp_target_kind kind)
{
    switch (kind) {
    case GP_TARGET_HDR:
        return GP_HAS_LIT;
    case GP_TARGET_LAYER:
        return GP_HAS_LAYER;
    case GP_TARGET_PICTURE:
        return untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN;
    case GP_TARGET_SENSORS:
        return GP_HAS_SOURCES;
    case GP_TARGET_POLYGONS:
        return GP_HAS_SOURCES | GP_HAS_KERNEL |
               (untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN);
    }
    return 0;
}

void gp_run_release(struct gp_run *r, unsigned dead)
{
    if (dead & GP_HAS_RGB)
        gp_planes_free(&r->frame.rgb);
    if (dead & GP_HAS_SOURCES)
        gp_sources_free(&r->sources);
    if (dead & GP_HAS_LAYER)
        gp_planes_free(&r->frame.layer);
    if (dead & GP_HAS_LIT)
        gp_planes_free(&r->frame.lit);
    if (dead & GP_HAS_SHOWN)
        gp_planes_free(&r->frame.shown);
}
