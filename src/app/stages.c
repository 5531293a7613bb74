#include "app/stages.h"

#include "app/options.h"
#include "core/clock.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "glare/engine.h"
#include "glare/sources.h"
#include "glare/splat/polygons.h"
#include "io/grow.h"
#include "io/plane.h"
#include "io/read.h"

#include <stdlib.h>
#include <string.h>

// -- the state of a frame ----------------------------------------------------

gp_status gp_frame_state_begin(const struct gp_log *log,
    const struct gp_run *r, int index, struct gp_frame_state *out)
{
    const struct gp_job *const job = &r->jobs->job[index];
    const size_t names = (size_t) r->jobs->targets + 1;
    const char *const input = job->input;
    *out = (struct gp_frame_state) {
        .log = log, .job = job, .view = index % r->jobs->views,
        .facts.job = {
            .numbered = job->numbered, .frame = job->frame, .view = job->view,
            .input = input, .style = r->s->light.style, .settings = r->s,
            .views = r->jobs->views_line,
        },
    };
    struct gp_write_facts *const w = &out->facts.write;
    struct gp_cost_facts *const cost = &out->facts.cost;
    for (int i = 0; i < GP_TIMES; i++)
        cost->ms[i] = cost->cpu_ms[i] = -1.0;
    gp_status st = gp_alloc_zero(log, "output list", names, sizeof *w->name,
                                 &w->name);
    if (!st)
        st = gp_alloc_zero(log, "output list", names, sizeof *w->kind,
                           &w->kind);
    return st ? st : gp_command_text(log, r->s, &input, 1,
                                     &out->facts.job.command);
}

void gp_frame_state_release(struct gp_frame_state *fs, unsigned dead)
{
    if (dead & GP_HAS_RGB)
        gp_planes_free(&fs->frame.rgb);
    if (dead & GP_HAS_SOURCES) {
        gp_sources_free(&fs->sources);
        gp_sources_free(&fs->joined);
    }
    if (dead & GP_HAS_LAYER)
        gp_planes_free(&fs->frame.layer);
    if (dead & GP_HAS_LIT)
        gp_planes_free(&fs->frame.lit);
    if (dead & GP_HAS_SHOWN)
        gp_planes_free(&fs->frame.shown);
}

void gp_frame_state_end(struct gp_frame_state *fs)
{
    gp_frame_state_release(fs, ~0u);
    for (int i = 0; i < fs->groups; i++) { // they borrow from the frame
        gp_sources_free(&fs->group[i].sources);
        gp_frame_free(&fs->group[i].frame);
    }
    gp_free(fs->group);
    gp_frame_free(&fs->frame);
    gp_run_kernel_free(&fs->kernel);
    gp_planes_free(&fs->sunmap.planes);
    gp_planes_free(&fs->intensity.planes);
    struct gp_facts *const f = &fs->facts;
    for (int i = 0; f->write.name && f->write.name[i]; i++)
        free(f->write.name[i]);
    gp_free(f->write.name);
    gp_free(f->write.kind);
    free(f->job.command);
    gp_free(f->scene.relit);
    gp_free(f->sun.light);
    gp_free(f->sun.depth);
    gp_free(f->sun.mask);
    *fs = (struct gp_frame_state) {0};
}

// -- reading -----------------------------------------------------------------

static bool suns_asked(const struct gp_settings *s)
{
    return gp_suns_wanted(&s->sun) || s->scene.path;
}

static bool scene_asked(const struct gp_settings *s)
{
    return s->scene.path != NULL;
}

static bool lens_asked(const struct gp_settings *s)
{
    return s->lens.name != NULL;
}

/* Grows the frame and the layers of its light groups to the window of the
 * outputs. */
static gp_status grow_frames(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    struct gp_grow_params p = {
        .left = s->output.grow_pixels, .top = s->output.grow_pixels,
        .right = s->output.grow_pixels, .bottom = s->output.grow_pixels,
        .depth = s->input.depth,
        .type = s->sun.depth_type,
    };
    struct gp_rect window, before;
    gp_status st;
    if (s->output.grow_how == GP_GROW_NONE)
        return GP_OK;
    if (s->output.grow_how == GP_GROW_KERNEL) {
        const struct gp_rect reach = gp_run_kernel_reach(r, fs);
        p.left = reach.x0;
        p.top = reach.y0;
        p.right = reach.x1;
        p.bottom = reach.y1;
    }
    window = gp_grow_window(&p, &fs->frame);
    do { // until the window is on the subsampling grids of all frames
        before = window;
        window = gp_grow_align(&fs->frame, window);
        for (int i = 0; i < fs->groups; i++)
            window = gp_grow_align(&fs->group[i].frame, window);
    } while (memcmp(&window, &before, sizeof window) != 0);
    GP_TRY(
        gp_grow_check(fs->log, &fs->frame, window, s->input.read.max_pixels));
    GP_TRY(gp_grow(fs->log, &p, window, &fs->frame));
    for (int i = 0; i < fs->groups; i++)
        GP_TRY(gp_grow(fs->log, &p, window, &fs->group[i].frame));
out:
    return st;
}

static gp_status run_read(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_members *const m = &r->jobs->members;
    const struct gp_texts *const groups = &r->s->input.light_groups;
    static const char *const types[] = {
        [GP_UINT] = "uint", [GP_HALF] = "half", [GP_FLOAT] = "float",
    };
    const char *const asked = r->s->input.depth;
    struct gp_read_facts *const facts = &fs->facts.read;
    struct gp_read_params p = r->s->input.read;
    enum gp_pixel_type type;
    gp_status st;
    if (r->jobs->views_inside)
        p.view = fs->job->view;
    const int i = (int) (fs->job - r->jobs->job) / r->jobs->views;
    GP_TRY(m->n ? gp_members_frame(fs->log, &p, fs->job->input, m, i,
                                   &fs->frame)
                : gp_read_frame(fs->log, &p, fs->job->input, &fs->frame));
    if (r->jobs->views_found && fs->view == 0)
        GP_TRY(gp_jobs_check_views(fs->log, &r->s->input.read, r->jobs,
                                   &fs->frame));
    if (groups->n) {
        GP_TRY(gp_alloc_zero(fs->log, "light groups", (size_t) groups->n,
                             sizeof *fs->group, &fs->group));
        facts->group = groups->at;
        facts->groups = groups->n;
    }
    for (; fs->groups < groups->n; fs->groups++)
        GP_TRY(gp_read_layer(fs->log, &p, &fs->frame, groups->at[fs->groups],
                             &fs->group[fs->groups].frame));
    GP_TRY(grow_frames(r, fs));
    facts->window = fs->frame.data;
    facts->file = gp_frame_read(&fs->frame);
    facts->grown = memcmp(&facts->file, &facts->window, sizeof facts->file);
    facts->width = gp_frame_w(&fs->frame);
    facts->height = gp_frame_h(&fs->frame);
    gp_read_taken(&fs->frame, &facts->taken);
    fs->facts.ocio = r->ocio ? gp_ocio_names(r->ocio) : NULL;
    if (suns_asked(r->s))
        return GP_OK;
    // without lights nothing reads depth, but the report names the channel;
    // only one that --depth asked for may not be missing
    st = gp_name_depth(asked ? fs->log : NULL, &fs->frame, asked,
                       &fs->facts.sun.depth, &type);
    if (!st && fs->facts.sun.depth)
        fs->facts.sun.depth_type = types[type];
    if (st == GP_ERR_BUG && !asked)
        return gp_no_memory(fs->log, fs->job->input);
    return asked ? st : GP_OK;
out:
    return st;
}

static bool relight_asked(const struct gp_settings *s)
{
    return s->scene.path && s->scene.relight.n;
}

// -- light -------------------------------------------------------------------

/* Finds the sources of each light group, and replaces the frame's own by their
 * union. */
static gp_status sense_light_groups(const struct gp_run *r,
                                    struct gp_frame_state *fs)
{
    struct gp_sources *const src = &fs->sources;
    struct gp_sources none = {0}, all = {0};
    struct gp_source *list;
    size_t n = 0;
    struct gp_sensor_params sensor = r->s->light.sensor;
    sensor.threshold = src->threshold; // the frame's, for all of them
    sensor.unit = GP_THRESHOLD_LUMINANCE;
    memset(src->faint, 0, sizeof src->faint);
    for (int i = 0; i < fs->groups; i++) {
        struct gp_sources *const own = &fs->group[i].sources;
        gp_status st = gp_sense(fs->log, &sensor, &fs->group[i].frame, own);
        if (st)
            return st;
        src->nonfinite += own->nonfinite;
        src->clamped += own->clamped;
        for (int c = 0; c < 3; c++) {
            src->faint[c] += own->faint[c];
            src->flux_clamped[c] += own->flux_clamped[c];
        }
        n += own->n;
    }
    gp_status st = gp_alloc(fs->log, "light of the groups", n,
                            sizeof *list, &list);
    if (st)
        return st;
    n = 0;
    for (int g = 0; g < fs->groups; g++) {
        const struct gp_sources *const s = &fs->group[g].sources;
        for (int y = 0; y < s->h; y++) {
            for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++)
                list[n++] = (struct gp_source) {
                    s->x[i], y, {s->rgb[0][i], s->rgb[1][i], s->rgb[2][i]},
                };
        }
    }
    // keep the frame's geometry and counts, replace its light
    st = gp_sources_make(fs->log, src, 0, &none);
    if (!st) {
        gp_sources_finish(&none);
        st = gp_sources_join(fs->log, &none, list, n, &all);
    }
    gp_sources_free(&none);
    gp_free(list);
    if (st)
        return st;
    gp_sources_free(src);
    *src = all;
    return GP_OK;
}

/* Returns the luminance of a sum over pixels of the frame. */
static double luminance_of(const struct gp_frame *f, const double sum[3])
{
    double y = 0.0;
    for (int c = 0; c < 3; c++)
        y += (double) f->luminance[c] * sum[c];
    return y;
}

/* Measures the light of the frame and of its bright pixels. */
static void measure_spread(const struct gp_run *r, struct gp_frame_state *fs)
{
    double sum[3], squares;
    struct gp_spread *const spread = &fs->facts.sensor.spread;
    gp_planes_sum(&fs->frame.rgb, gp_frame_pixels(&fs->frame), sum, &squares);
    spread->light = luminance_of(&fs->frame, sum);
    spread->bright = gp_wanted_share(&r->kernel.wanted) *
                     luminance_of(&fs->frame, fs->sources.flux);
}

static void note_light(struct gp_frame_state *fs, const struct gp_sources *s)
{
    struct gp_sensor_facts *const facts = &fs->facts.sensor;
    facts->sources = (long long) s->n;
    memcpy(facts->flux, s->flux, sizeof facts->flux);
    memcpy(facts->faint, s->faint, sizeof facts->faint);
}

static gp_status run_sensors(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_sensor_facts *const facts = &fs->facts.sensor;
    struct gp_clamp_facts *const clamp = &fs->facts.clamp;
    gp_status st = gp_sense(fs->log, &r->s->light.sensor, &fs->frame, &fs->sources);
    if (!st && fs->groups)
        st = sense_light_groups(r, fs);
    if (st)
        return st;
    gp_run_kernel_adapt(r, fs);
    note_light(fs, &fs->sources);
    facts->nonfinite = fs->sources.nonfinite;
    clamp->n.pixels = fs->sources.clamped;
    memcpy(clamp->flux, fs->sources.flux_clamped, sizeof clamp->flux);
    facts->threshold = fs->sources.threshold;
    facts->dark = fs->sources.n == 0 && !suns_asked(r->s) &&
                  r->s->light.compose.gain > 0.0f;
    for (int i = fs->groups ? 0 : -1; i < fs->groups && facts->dark; i++) {
        int at[2];
        const float peak = gp_luminance_peak(
            i < 0 ? &fs->frame : &fs->group[i].frame, at);
        if (i <= 0 || peak > facts->peak) {
            facts->peak = peak;
            memcpy(facts->peak_at, at, sizeof at);
        }
    }
    if (r->says)
        measure_spread(r, fs);
    return GP_OK;
}

// -- glare -------------------------------------------------------------------

/* Returns the sources of the engines: bright pixels, and lights whose share is
 * known. */
static const struct gp_sources *all_light(const struct gp_frame_state *fs)
{
    return fs->joined.n ? &fs->joined : &fs->sources;
}

/* How the picture goes on for `own`, a part of its sources. */
static struct gp_surround edges_of(const struct gp_run *r,
    const struct gp_frame_state *fs, const struct gp_sources *own)
{
    return (struct gp_surround) {r->s->light.edges, &fs->sources, own};
}

static gp_status run_glare(struct gp_run *r, struct gp_frame_state *fs)
{
    bool joined;
    gp_status st = gp_suns_join(fs->log, &r->suns, &fs->frame, &fs->sources,
                                &fs->joined, &joined);
    if (st)
        return st;
    const struct gp_sources *const light = all_light(fs);
    note_light(fs, light);
    struct gp_spread *const spread = &fs->facts.sensor.spread;
    if (r->says)
        spread->lamps = gp_wanted_share(&r->kernel.wanted) *
                            luminance_of(&fs->frame, light->flux) -
                        spread->bright;
    struct gp_glare_params p = r->s->glare;
    p.taken = r->s->light.compose.mix == GP_MIX_SCATTER ? &fs->sources : NULL;
    p.edges = edges_of(r, fs, &fs->sources);
    p.last = fs->job - r->jobs->job == r->jobs->n - 1;
    struct gp_glare_stats *const stats = &fs->facts.glare;
    if (light->n > 0) {
        const gp_status st = gp_glare_run(fs->log, &p, &r->glare.engines, light,
                                          gp_run_kernel_of(fs), &fs->frame,
                                          stats);
        if (!st && !stats->why[0])
            snprintf(stats->why, sizeof stats->why, "named by --engine");
        return st;
    }
    *stats = (struct gp_glare_stats) {
        .engine = "none", .why = "no pixel is over the threshold",
    };
    return GP_OK;
}

static gp_status run_verify(struct gp_run *r, struct gp_frame_state *fs)
{
    double *exact;
    if (all_light(fs)->n == 0)
        return GP_OK;
    gp_status st = gp_alloc(fs->log, "exact layer",
        3 * gp_frame_pixels(&fs->frame), sizeof *exact, &exact);
    if (st)
        return st;
    const struct gp_surround edges = edges_of(r, fs, &fs->sources);
    st = gp_glare_reference(fs->log, &edges, all_light(fs),
                            gp_run_kernel_of(fs), exact);
    if (!st) {
        gp_glare_measure(
            &fs->frame, &fs->frame.layer, exact, r->s->light.compose.gain,
            r->s->light.compose.mix == GP_MIX_SCATTER ? &fs->sources : NULL,
            &fs->facts.layer.error);
        fs->facts.layer.verified = true;
    }
    gp_free(exact);
    return st;
}

static bool flare_asked(const struct gp_settings *s)
{
    return suns_asked(s) || s->sun.flare;
}

/* Adds ghosts of a real lens. */
static gp_status run_lens(struct gp_run *r, struct gp_frame_state *fs)
{
    enum { FEW = 8 }; // hidden lights count: nothing changes as they appear
    const enum gp_lens_detail detail = r->suns.n > 0 && r->suns.n <= FEW
                                           ? GP_LENS_FINE : GP_LENS_COARSE;
    const gp_status st = fs->frame.layer.c[0] ? GP_OK : gp_run_dark_layer(fs);
    return st ? st : gp_run_lens(r, fs, detail);
}

static gp_status run_flux(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_layer_facts *const facts = &fs->facts.layer;
    const struct gp_lens_facts *const lens = &fs->facts.lens;
    double squares;
    (void) r;
    if (fs->frame.layer.c[0])
        gp_planes_sum(&fs->frame.layer, gp_frame_pixels(&fs->frame),
                      facts->flux, &squares);
    // of the layer with ghosts too, which is no darker than without them
    facts->bounded = fs->facts.sensor.sources || lens->name;
    facts->bound = fs->facts.glare.bound + lens->bound;
    return GP_OK;
}

/* Adds glare to the frame and, for --hdr, each light group's own to the group,
 * so that groups which add up to the frame still do. */
static gp_status run_compose(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_compose_params p = r->s->light.compose;
    p.dim = r->s->sun.adapt * (float) gp_suns_mean(&r->suns);
    p.last = r->layer_ends;
    if (r->ocio)
        gp_ocio_note(fs->log, r->ocio, &fs->frame);
    gp_status st = gp_compose(fs->log, &p, &fs->sources, &fs->frame);
    p.last = true;
    for (int i = 0; i < fs->groups && r->s->output.hdr.n && !st; i++) {
        struct gp_light_group *const g = &fs->group[i];
        struct gp_glare_stats stats = {0};
        struct gp_flare_facts flare = {0};
        const double start = gp_now_ms(), cpu = gp_cpu_ms();
        struct gp_glare_params glare = r->s->glare;
        glare.edges = edges_of(r, fs, &g->sources);
        if (g->sources.n > 0)
            st = gp_glare_run(fs->log, &glare, &r->groups.engines, &g->sources,
                              gp_run_kernel_of(fs), &g->frame, &stats);
        if (!st)
            st = gp_run_ghosts_add(fs->log, r, &g->sources, &r->groups.ghosts,
                                   &g->frame, &flare);
        fs->engine_ms += g->sources.n > 0 ? gp_now_ms() - start : 0.0;
        fs->engine_cpu_ms += g->sources.n > 0 ? gp_cpu_ms() - cpu : 0.0;
        if (!st)
            st = gp_compose(fs->log, &p, &g->sources, &g->frame);
        gp_planes_free(&g->frame.layer);
    }
    return st;
}

static gp_status run_tonemap(struct gp_run *r, struct gp_frame_state *fs)
{
    bool shows = fs->view == 0;
    for (int i = 0; i < r->jobs->targets; i++)
        shows = shows || !(r->jobs->target[i].hero || r->jobs->target[i].whole);
    if (!shows)
        return GP_OK;
    return r->ocio ? gp_ocio_show(fs->log, r->ocio, &r->s->tone.map, &fs->frame)
                   : gp_tone_map(fs->log, &r->s->tone.map, &fs->frame, NULL);
}

// -- writing -----------------------------------------------------------------

/* True when -o gets linear light. */
static bool untoned(const struct gp_settings *s)
{
    return strcmp(s->tone.map.curve, "none") == 0;
}

unsigned gp_target_needs(const struct gp_settings *s, enum gp_target_kind kind)
{
    const unsigned shown = untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN;
    switch (kind) {
    case GP_TARGET_HDR:
        return GP_HAS_LIT;
    case GP_TARGET_LAYER:
        // (bound_pixel is of the composite, which needs the frame)
        return GP_HAS_LAYER | GP_HAS_FLARE | GP_HAS_LENS |
               (s->glare.tolerance_pixel > 0.0f ? GP_HAS_RGB : 0);
    case GP_TARGET_PICTURE:
        return shown;
    case GP_TARGET_SENSORS:
        return GP_HAS_SOURCES;
    case GP_TARGET_POLYGONS:
        return GP_HAS_SOURCES | GP_HAS_KERNEL | shown;
    case GP_TARGET_SUNMAP:
    case GP_TARGET_INTENSITY:
        return GP_HAS_SHARES;
    }
    return 0;
}

static gp_status convert_layer(const struct gp_log *log, void *user,
    const struct gp_frame *f, size_t n, const struct gp_planes *in,
    struct gp_planes *out)
{
    return gp_ocio_convert(log, user, f, n, in, out);
}

/* Writes `views` views of one input, then the light groups of each, into one
 * --hdr file. */
static gp_status write_hdr(const struct gp_run *r, struct gp_frame_state *fs,
                           const struct gp_write_params *p, int views,
                           const char *name, struct gp_write_stats *stats)
{
    gp_status st;
    int n = 0;
    const size_t most =
        (size_t) views * (1 + (size_t) r->s->input.light_groups.n);
    struct gp_hdr_colour *set;
    struct gp_planes *converted = NULL;
    GP_TRY(gp_alloc_zero(fs->log, "colours", most, sizeof *set, &set));
    for (int i = 0; i < views; i++) {
        set[n++].f = &fs[i].frame;
        if (r->s->tone.ocio.output && !fs[i].converted)
            GP_TRY(gp_convert_layers(fs->log, convert_layer, r->ocio,
                                     &fs[i].frame, stats));
        fs[i].converted = true;
    }
    for (int i = 0; i < views; i++) {
        for (int g = 0; g < fs[i].groups; g++)
            set[n++].f = &fs[i].group[g].frame;
    }
    GP_TRY(gp_alloc_zero(fs->log, "colours", most, sizeof *converted,
                         &converted));
    for (int i = 0; i < n; i++) {
        set[i].planes = &set[i].f->lit;
        if (!r->s->tone.ocio.output)
            continue;
        GP_TRY(gp_ocio_convert(fs->log, r->ocio, set[i].f,
                               gp_frame_pixels(set[i].f), &set[i].f->lit,
                               &converted[i]));
        set[i].planes = &converted[i];
    }
    st = gp_write_hdr(fs->log, p, name, set, n, stats);
out:
    for (int i = 0; i < n && converted; i++)
        gp_planes_free(&converted[i]);
    gp_free(converted);
    gp_free(set);
    return st;
}

static gp_status write_target(const struct gp_run *r, struct gp_frame_state *fs,
    const struct gp_write_params *p, const struct gp_output *t,
    const char *name, struct gp_write_stats *stats)
{
    const bool scene = untoned(r->s);
    const struct gp_planes *shown = scene ? &fs->frame.lit : &fs->frame.shown;
    const struct gp_map_picture *const map =
        t->kind == GP_TARGET_SUNMAP ? &fs->sunmap : &fs->intensity;
    enum gp_picture_kind kind = GP_PICTURE_SCENE;
    struct gp_write_params pictures = *p;
    struct gp_frame f = fs->frame;
    struct gp_planes own = {0};
    gp_status st = GP_OK;
    if (t->kind != GP_TARGET_PICTURE)
        pictures.alpha = GP_ALPHA_BLACK; // light to be added has no alpha
    switch (t->kind) {
    case GP_TARGET_HDR:
        return write_hdr(r, fs, p, t->whole ? r->jobs->views : 1, name, stats);
    case GP_TARGET_LAYER:
        st = f.layer.c[0] ? GP_OK : gp_run_dark_layer(fs);
        shown = &fs->frame.layer;
        break;
    case GP_TARGET_SENSORS:
        st = gp_sources_planes(fs->log, &fs->sources, &own);
        shown = &own;
        break;
    case GP_TARGET_POLYGONS:
        // outlines over the picture of -o
        st = gp_planes_make(fs->log, "polygons", gp_frame_pixels(&f), &own);
        for (int c = 0; c < 3 && !st; c++)
            memcpy(own.c[c], shown->c[c], gp_frame_pixels(&f) * sizeof(float));
        if (!st && fs->sources.n > 0)
            st = gp_polygons_outline(fs->log, &fs->sources,
                                     gp_run_kernel_of(fs), &r->s->glare.splat,
                                     &own);
        shown = &own;
        // fall through
    case GP_TARGET_PICTURE:
        kind = r->ocio ? GP_PICTURE_ENCODED
               : scene ? GP_PICTURE_SCENE : GP_PICTURE_SHOWN;
        break;
    case GP_TARGET_SUNMAP:
    case GP_TARGET_INTENSITY: // have sizes of their own
        f.data = f.display = (struct gp_rect) {0, 0, map->w, map->h};
        shown = &map->planes;
        pictures.dither = GP_DITHER_NEVER; // each pixel is a share
        kind = GP_PICTURE_SHOWN;
        break;
    }
    if (!st)
        st = gp_write_picture(fs->log, &pictures, name, &f, shown, kind, stats);
    gp_planes_free(&own);
    return st;
}

static gp_status run_write(struct gp_run *r, struct gp_frame_state *fs)
{
    struct gp_write_stats stats = {.raw = r->raw}; // changes when ordered only
    struct gp_write_params p = r->s->output.write;
    struct gp_write_facts *const facts = &fs->facts.write;
    struct gp_clamp_facts *const clamp = &fs->facts.clamp;
    const struct gp_taker *const taker = r->jobs->taker;
    gp_status st = GP_OK;
    if (taker)
        return taker->take(taker->user, fs->log, &fs->frame,
                           untoned(r->s) ? &fs->frame.lit : &fs->frame.shown);
    p.command = r->s->output.no_provenance ? NULL : fs->facts.job.command;
    if (r->ocio) {
        p.primaries = gp_ocio_output_primaries(r->ocio);
        memcpy(p.cicp, gp_ocio_code_points(r->ocio), sizeof p.cicp);
    }
    for (int i = 0; i < r->jobs->targets && !st; i++) {
        const struct gp_output *const t = &r->jobs->target[i];
        if ((t->whole || t->hero) && fs->view > 0)
            continue; // the first view writes it
        char *const name = gp_job_name(fs->job, t);
        if (!name) {
            st = gp_no_memory(fs->log, t->name.path);
            break;
        }
        facts->name[facts->n] = name;
        facts->kind[facts->n] = t->kind;
        st = write_target(r, fs, &p, t, name, &stats);
        facts->n += !st;
    }
    if (st)
        return st;
    clamp->n.values = stats.clamped;
    for (int c = 0; c < 3; c++)
        clamp->flux[c] += stats.flux_clamped[c];
    if (r->ordered)
        r->raw = stats.raw;
    return GP_OK;
}

// -- all of them -------------------------------------------------------------

enum {
    RGB = GP_HAS_RGB, SOURCES = GP_HAS_SOURCES, KERNEL = GP_HAS_KERNEL,
    LAYER = GP_HAS_LAYER, LIT = GP_HAS_LIT, SUNS = GP_HAS_SUNS,
    FLARE = GP_HAS_FLARE, SHARES = GP_HAS_SHARES, LENS = GP_HAS_LENS,
    SCENE = GP_HAS_SCENE,
};
const struct gp_stage gp_stages[GP_STAGES] = {
    {"read", GP_PHASE_READ, GP_TIME_READ, 0, RGB, run_read, NULL},
    {"scene", GP_PHASE_COMPUTE, GP_TIME_SCENE, RGB, SCENE, gp_run_scene,
     scene_asked},
    {"relight", GP_PHASE_COMPUTE, GP_TIME_RELIGHT, RGB | SCENE, GP_HAS_RELIT,
     gp_run_relight, relight_asked},
    {"sun", GP_PHASE_COMPUTE, GP_TIME_SUN, RGB | SCENE, SUNS, gp_run_suns,
     suns_asked},
    {"sensors", GP_PHASE_COMPUTE, GP_TIME_SENSORS, RGB | GP_HAS_RELIT, SOURCES,
     run_sensors, NULL},
    {"kernel", GP_PHASE_COMPUTE, -1, SOURCES | SUNS, KERNEL,
     gp_run_kernel_hold, NULL},
    {"glare", GP_PHASE_COMPUTE, GP_TIME_GLARE, SOURCES | KERNEL | SUNS, LAYER,
     run_glare, NULL},
    {"verify", GP_PHASE_COMPUTE, -1, RGB | SOURCES | KERNEL | LAYER,
     GP_HAS_MEASURED, run_verify, NULL},
    {"flare", GP_PHASE_COMPUTE, GP_TIME_SUN,
     SOURCES | LAYER | KERNEL | SUNS, FLARE, gp_run_flare, flare_asked},
    {"lens", GP_PHASE_COMPUTE, GP_TIME_LENS, RGB | SOURCES | LAYER | FLARE,
     LENS, run_lens, lens_asked},
    {"flux", GP_PHASE_COMPUTE, -1, LAYER | FLARE | LENS, GP_HAS_FLUX, run_flux,
     NULL},
    {"compose", GP_PHASE_COMPUTE, GP_TIME_COMPOSE,
     RGB | SOURCES | KERNEL | LAYER | FLARE | LENS, LIT, run_compose, NULL},
    {"tonemap", GP_PHASE_COMPUTE, GP_TIME_TONEMAP, LIT, GP_HAS_SHOWN,
     run_tonemap, NULL},
    {"shares", GP_PHASE_COMPUTE, -1, FLARE, SHARES, gp_run_shares, suns_asked},
    {"write", GP_PHASE_WRITE, GP_TIME_WRITE, SHARES, GP_HAS_FILES, run_write,
     NULL},
};
