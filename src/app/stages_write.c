/* The last stage: what the targets of a frame get. */
#include "app/stages.h"

#include "core/memory.h"
#include "glare/splat/outline.h"

#include <string.h>

/* True when -o gets the light itself. */
static bool untoned(const struct gp_settings *s)
{
    return strcmp(s->tone.curve, "none") == 0;
}

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
        return GP_HAS_SHARES;
    }
    return 0;
}

// -- one target each ----------------------------------------------------------

static gp_status write_layer(struct gp_run *r, struct gp_work *w,
                             const char *name,
                             struct gp_write_stats *stats)
{
    gp_status st = w->frame.layer.c[0] ? GP_OK : gp_work_dark_layer(w);
    if (st)
        return st;
    return gp_write_picture(w->log, &r->s->write, name, &w->frame,
                            &w->frame.layer, GP_PICTURE_SCENE, stats);
}

static gp_status write_sensors(struct gp_run *r, struct gp_work *w,
                               const char *name,
                               struct gp_write_stats *stats)
{
    struct gp_planes p = {0};
    gp_status st = gp_sources_planes(w->log, &w->sources, &p);
    if (!st)
        st = gp_write_picture(w->log, &r->s->write, name, &w->frame, &p,
                              GP_PICTURE_SCENE, stats);
    gp_planes_free(&p);
    return st;
}

/* What -o shows. */
static gp_status write_shown(struct gp_run *r, struct gp_work *w,
                             const char *name, const struct gp_planes *planes,
                             struct gp_write_stats *stats)
{
    const enum gp_picture_kind kind = r->ocio        ? GP_PICTURE_ENCODED
                                      : untoned(r->s) ? GP_PICTURE_SCENE
                                                      : GP_PICTURE_SHOWN;
    return gp_write_picture(w->log, &r->s->write, name, &w->frame, planes,
                            kind, stats);
}

static gp_status write_polygons(struct gp_run *r, struct gp_work *w,
                                const char *name,
                                struct gp_write_stats *stats)
{
    const struct gp_planes *const shown =
        untoned(r->s) ? &w->frame.lit : &w->frame.shown;
    const size_t n = gp_frame_pixels(&w->frame);
    struct gp_planes p = {0};
    gp_status st = gp_planes_make(w->log, "polygons", n, &p);
    for (int c = 0; c < 3 && !st; c++)
        memcpy(p.c[c], shown->c[c], n * sizeof(float));
    if (!st && w->sources.n > 0)
        st = gp_outline(w->log, &w->sources, &r->kernel, &r->glare.splat, &p);
    if (!st)
        st = write_shown(r, w, name, &p, stats);
    gp_planes_free(&p);
    return st;
}

/* Sun maps and intensity map are pictures of their own size. */
static gp_status write_map(struct gp_run *r, struct gp_work *w,
                           const struct gp_map_picture *map, const char *name,
                           struct gp_write_stats *stats)
{
    struct gp_frame f = w->frame;
    f.data = f.display = (struct gp_rect) {0, 0, map->w, map->h};
    return gp_write_picture(w->log, &r->s->write, name, &f, &map->planes,
                            GP_PICTURE_SHOWN, stats);
}

/* Colours of a --hdr file: frames, then their light groups, and planes that
 * were made of theirs. */
struct colours {
    struct gp_hdr_colour *set;   // owned, with room for all
    struct gp_planes *converted; // the same
    int n;
};

static gp_status add_colour(struct gp_run *r, const struct gp_log *log,
                            const struct gp_frame *f, struct colours *c)
{
    struct gp_planes *const made = &c->converted[c->n];
    gp_status st = r->s->ocio.output ? gp_ocio_convert(log, r->ocio, f, made)
                                     : GP_OK;
    c->set[c->n++] = (struct gp_hdr_colour) {
        f, made->c[0] ? made : &f->lit,
    };
    return st;
}

static gp_status add_colours(struct gp_run *r, const struct gp_work *w,
                             int works, struct colours *c)
{
    gp_status st = GP_OK;
    for (int i = 0; i < works && !st; i++)
        st = add_colour(r, w->log, &w[i].frame, c);
    for (int i = 0; i < works; i++) {
        for (int g = 0; g < w[i].groups.n && !st; g++)
            st = add_colour(r, w->log, &w[i].groups.at[g].frame, c);
    }
    return st;
}

/* `works` views of one input, and the light groups of each, in one file. */
static gp_status write_hdr(struct gp_run *r, const struct gp_work *w,
                           int works, const char *name,
                           struct gp_write_stats *stats)
{
    gp_status st;
    struct colours c = {0};
    const size_t most = (size_t) works * (1 + (size_t) r->s->light_groups.n);
    void *set, *converted = NULL;
    GP_TRY(gp_alloc_zero(w->log, "colours", most, sizeof *c.set, &set));
    c.set = set;
    GP_TRY(gp_alloc_zero(w->log, "colours", most, sizeof *c.converted,
                         &converted));
    c.converted = converted;
    GP_TRY(add_colours(r, w, works, &c));
    GP_TRY(gp_write_hdr(w->log, &r->s->write, name, c.set, c.n, stats));
out:
    for (int i = 0; i < c.n; i++)
        gp_planes_free(&c.converted[i]);
    gp_free(c.converted);
    gp_free(c.set);
    return st;
}

static gp_status write_target(struct gp_run *r, struct gp_work *w,
                              const struct gp_output *t, const char *name,
                              struct gp_write_stats *stats)
{
    const struct gp_frame *f = &w->frame;
    switch (t->kind) {
    case GP_TARGET_HDR:
        return write_hdr(r, w, t->whole ? r->jobs->views : 1, name, stats);
    case GP_TARGET_LAYER:
        return write_layer(r, w, name, stats);
    case GP_TARGET_PICTURE:
        return write_shown(r, w, name, untoned(r->s) ? &f->lit : &f->shown,
                           stats);
    case GP_TARGET_SENSORS:
        return write_sensors(r, w, name, stats);
    case GP_TARGET_POLYGONS:
        return write_polygons(r, w, name, stats);
    case GP_TARGET_SUNMAP:
        return write_map(r, w, &w->sunmap, name, stats);
    case GP_TARGET_INTENSITY:
        return write_map(r, w, &w->intensity, name, stats);
    }
    return GP_ERR_BUG;
}

gp_status gp_stage_write(struct gp_run *r, struct gp_work *w)
{
    struct gp_write_stats stats = {0};
    if (r->ordered) // else no two frames share a stream
        stats.raw = r->raw;
    for (int i = 0; i < r->jobs->targets; i++) {
        const struct gp_output *const t = &r->jobs->target[i];
        if (t->whole && w->view > 0)
            continue; // stands in the first view's file
        char *const name = gp_job_name(w->job, t);
        if (!name)
            return gp_fail(w->log, GP_ERR_BUG, "%s: out of memory",
                           t->name.path);
        w->names[w->facts.n_outputs] = name;
        gp_status st = write_target(r, w, t, name, &stats);
        if (st)
            return st;
        w->facts.n_outputs++;
    }
    w->facts.clamped_out = stats.clamped;
    if (r->ordered)
        r->raw = stats.raw;
    return GP_OK;
}
