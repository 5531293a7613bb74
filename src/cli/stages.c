// SPDX-License-Identifier: Apache-2.0
#include "cli/stages.h"

#include "cli/keys.h"
#include "cli/listener.h"
#include "cli/words.h"
#include "core/memory.h"
#include "io/grow.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

// -- the state of a frame ----------------------------------------------------

/* Makes the plan of a frame's own numbers. */
static gp_status make_own_plan(const struct gp_log *log, const struct gp_run *r,
                               struct gp_frame_state *fs)
{
    const struct glarepp_kernel_params *const k = &r->s->kernel.p;
    struct gp_own_plan *own;
    struct glarepp *const gp = r->gp;
    int frame;
    gp_status st = gp_alloc_zero(log, "plan", 1, sizeof *own, &own);
    if (st)
        return st;
    fs->own = own;
    (void) gp_job_number(fs->job, &frame); // (begin_run() has checked)
    gp_settings_at(r->s, frame, &own->s);
    fs->facts.job.settings = &own->s;
    struct glarepp_plan_params plan = own->s.plan;
    plan.kernel = r->kernel;
    plan.more = (const struct glarepp_kernel *const *) r->more;
    plan.mores = r->s->input.group_kernels.n;
    plan.names = r->plan;
    struct gp_place place; // (it knows no frame)
    const struct gp_log there = gp_place_log(&place, log, fs->job->input, 0);
    gp_hear_about(&there);
    const struct glarepp_kernel_params *const mine = &own->s.kernel.p;
    if (memcmp(mine->centre, k->centre, sizeof k->centre) != 0 ||
        mine->percent != k->percent || mine->degrees != k->degrees) {
        GP_TRY((gp_status) glarepp_kernel(gp, mine, &own->kernel));
        plan.kernel = own->kernel;
    }
    GP_TRY((gp_status) glarepp_plan(gp, &plan, &own->plan));
    fs->plan = own->plan;
out:
    gp_hear_about(NULL);
    return st;
}

void gp_own_plans_end(struct gp_own_plan **list)
{
    while (*list) {
        struct gp_own_plan *own = *list;
        *list = own->next;
        glarepp_plan_end(&own->plan);
        glarepp_kernel_end(&own->kernel);
        gp_free(own);
    }
}

gp_status gp_frame_state_begin(const struct gp_log *log,
    const struct gp_run *r, int index, struct gp_frame_state *out)
{
    const struct gp_job *const job = &r->jobs->job[index];
    const size_t names = (size_t) r->jobs->targets + 1;
    const char *const input = job->input;
    *out = (struct gp_frame_state) {
        .log = log,
        .job = job,
        .view = index % r->jobs->views,
        .plan = r->plan,
        .facts.job =
            {
                .of = *job,
                .style = r->s->light.style,
                .settings = r->s,
                .views = r->jobs->views_line,
            },
    };
    struct gp_write_facts *const w = &out->facts.write;
    struct gp_cost_facts *const cost = &out->facts.cost;
    for (int i = 0; i < GP_TIMES; i++)
        cost->ms[i] = cost->cpu_ms[i] = -1.0;
    gp_status st =
        gp_alloc_zero(log, "output list", names, sizeof *w->file, &w->file);
    st = st ? st
            : gp_command_text(log, r->s, &input, 1, GP_COMMAND_NAMES,
                              &out->facts.job.command);
    return st || !r->s->keyeds ? st : make_own_plan(log, r, out);
}

void gp_frame_state_release(struct gp_frame_state *fs, unsigned dead)
{
    const unsigned planes = GP_HAS_RGB | GP_HAS_SOURCES | GP_HAS_LAYER |
                            GP_HAS_LIT | GP_HAS_SHOWN | 1u << GLAREPP_TRUTH;
    if (fs->frame)
        glarepp_frame_drop(fs->frame, dead & planes);
    if (dead & GP_HAS_RGB)
        gp_planes_free(&fs->file.rgb);
}

void gp_frame_state_end(struct gp_frame_state *fs)
{
    glarepp_frame_end(&fs->frame);
    for (int i = 0; i < fs->groups; i++) // they borrow from the file
        gp_frame_free(&fs->group[i]);
    gp_free(fs->group);
    gp_frame_free(&fs->file);
    gp_plane_free(&fs->depth);
    gp_plane_free(&fs->mask);
    gp_plane_free(&fs->source_mask);
    gp_stored_image_free(&fs->deep);
    gp_free(fs->deep_name);
    for (int c = 0; c < 3; c++) {
        gp_plane_free(&fs->normal[c]);
        gp_plane_free(&fs->albedo[c]);
    }
    struct gp_frame_report *const f = &fs->facts;
    for (int i = 0; f->write.file && f->write.file[i].name; i++)
        free(f->write.file[i].name);
    gp_free(f->write.file);
    free(f->job.command);
    *fs = (struct gp_frame_state) {0};
}

// -- reading -----------------------------------------------------------------

/* True when -o gets linear light. */
static bool untoned(const struct gp_settings *s)
{
    return strcmp(s->tone.map.curve, "none") == 0;
}

/* Tests whether scene-linear light goes out in float, which hides less noise than
 * half. */
static bool writes_floats(const struct gp_run *r,
                          const struct gp_frame_state *fs)
{
    bool some = false;
    for (int i = 0; i < r->jobs->targets; i++) {
        const struct gp_output *const t = &r->jobs->target[i];
        const bool linear = t->kind <= GP_TARGET_PARTS ||
                            (t->kind == GP_TARGET_PICTURE && untoned(r->s));
        some |= linear && gp_write_has_floats(&r->s->output.write, t->name.path,
                                              fs->file.colour_type);
    }
    return some;
}

/* Begins the library's frame with the planes that were read. */
static gp_status begin_frame(const struct gp_run *r, struct gp_frame_state *fs)
{
    struct glarepp_frame_params p = gp_frame_params_of(fs->job, &fs->file);
    const bool other = r->s->light.source;
    const size_t room = (size_t) fs->groups + 1;
    struct glarepp_image *group = NULL;
    struct glarepp_group *how = NULL;
    double map = 0.0;
    gp_status st;
    if (gp_frame_numbers(&fs->file, "envmap", 1, &map) && map != 0.0)
        GP_TRY(gp_fail(fs->log, GP_ERR_DATA,
                       "%s: its envmap is a cube map; make a lat-long of it: "
                       "exrenvmap -l IN.exr OUT.exr",
                       fs->file.path));
    GP_TRY(gp_alloc(fs->log, "light groups", room, sizeof *group, &group));
    GP_TRY(gp_alloc(fs->log, "light groups", room, sizeof *how, &how));
    for (int i = 0; i < fs->groups; i++) {
        group[i] = gp_frame_view(&fs->group[i], &fs->group[i].rgb);
        how[i] = other ? (struct glarepp_group) {0, 1.0f}
                       : (struct glarepp_group) {r->s->input.group[i].more,
                                                 r->s->input.group[i].gain};
    }
    p.in_place = true;
    p.group = group;
    p.groups = fs->groups;
    p.how = how;
    p.groups_glare = other || !r->s->output.hdr.n;
    p.last = fs->own || fs->job - r->jobs->job == r->jobs->n - 1;
    p.layer_ends = r->layer_ends;
    p.details = r->details;
    p.parts = r->s->output.parts.n > 0;
    p.parts_of_groups = r->s->input.light_groups.n > 0;
    const struct gp_run_settings *const run =
        fs->own ? &fs->own->s.run : &r->s->run;
    if (run->luminance_scale > 0.0)
        p.white = run->luminance_scale;
    p.veil = run->report || run->level >= GP_LEVEL_INFO;
    p.fixated = run->fixation.n > 0;
    memcpy(p.fixation, run->fixation.v, sizeof p.fixation);
    fs->sphere = (r->s->plan.projection == GLAREPP_OF_FRAME
                      ? p.projection
                      : r->s->plan.projection) == GLAREPP_LATLONG;
    p.noise = writes_floats(r, fs) ? 2e-5f : p.noise;
    p.user = (void *) (uintptr_t) fs->log;
    st = (gp_status) glarepp_frame(fs->plan, &p, &fs->frame);
out:
    gp_free(group);
    gp_free(how);
    return st;
}

/* Grows the frame and its light groups to the window of the outputs. */
static gp_status grow_frames(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_log *const log = fs->log;
    const struct gp_settings *const s = r->s;
    struct gp_grow_params p = {
        .left = s->output.grow_pixels,
        .top = s->output.grow_pixels,
        .right = s->output.grow_pixels,
        .bottom = s->output.grow_pixels,
        .depth = gp_no_depth(s) ? NULL : s->input.depth,
        .type = s->sun.p.depth,
    };
    struct gp_rect window, before;
    gp_status st;
    if (s->output.grow_pixels == GP_GROW_NONE)
        return GP_OK;
    if (s->output.grow_pixels == GP_GROW_KERNEL) {
        GP_TRY(begin_frame(r, fs));
        const struct gp_rect reach = glarepp_frame_reach(fs->frame);
        glarepp_frame_end(&fs->frame);
        p.left = reach.x0;
        p.top = reach.y0;
        p.right = reach.x1;
        p.bottom = reach.y1;
    }
    window = gp_grow_window(&p, &fs->file);
    do { // until the window is on the subsampling grids of all frames
        before = window;
        window = gp_grow_align(&fs->file, window);
        for (int i = 0; i < fs->groups; i++)
            window = gp_grow_align(&fs->group[i], window);
    } while (memcmp(&window, &before, sizeof window) != 0);
    GP_TRY(gp_grow_check(log, &fs->file, window, s->input.read.max_pixels));
    GP_TRY(gp_grow(log, &p, window, &fs->file));
    for (int i = 0; i < fs->groups; i++)
        GP_TRY(gp_grow(log, &p, window, &fs->group[i]));
out:
    return st;
}

static gp_status run_read(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_log *const log = fs->log;
    const struct gp_members *const m = &r->jobs->members;
    const int groups = r->s->input.light_groups.n;
    const struct glarepp_plan_facts *const plan = glarepp_plan_facts(r->plan);
    struct gp_read_facts *const facts = &fs->facts.read;
    struct gp_read_params p = r->s->input.read;
    gp_status st;
    if (r->jobs->views_inside)
        p.view = fs->job->view;
    const int i = (int) (fs->job - r->jobs->job) / r->jobs->views;
    GP_TRY(m->n ? gp_members_frame(log, &p, fs->job->input, m, i, &fs->file)
                : gp_read_frame(log, &p, fs->job->input, &fs->file));
    if (r->jobs->views_found && fs->view == 0)
        GP_TRY(gp_jobs_check_views(log, &r->s->input.read, r->jobs, &fs->file));
    GP_TRY(gp_alloc_zero(log, "light groups", (size_t) groups + 1,
                         sizeof *fs->group, &fs->group));
    facts->group = r->s->input.group;
    facts->groups = groups;
    for (; fs->groups < groups; fs->groups++) {
        const struct gp_light_group *const g = &facts->group[fs->groups];
        facts->grouped = facts->grouped || g->kernel || g->gain != 1.0f;
        GP_TRY(
            gp_read_layer(log, &p, &fs->file, g->name, &fs->group[fs->groups]));
    }
    GP_TRY(gp_read_source(r, fs));
    GP_TRY(grow_frames(r, fs));
    facts->window = fs->file.data;
    facts->file = gp_frame_read(&fs->file);
    facts->grown = memcmp(&facts->file, &facts->window, sizeof facts->file);
    facts->width = gp_frame_w(&fs->file);
    facts->height = gp_frame_h(&fs->file);
    gp_read_taken(&fs->file, &facts->taken);
    fs->facts.ocio = plan->config ? plan : NULL;
    GP_TRY(begin_frame(r, fs));
    GP_TRY(gp_read_source_mask(r, fs));
    if (!gp_lights_wanted(r->s) && !gp_no_depth(r->s))
        st = gp_name_own_depth(r, fs);
out:
    return st;
}

// -- planes beside the colour: depth, coverage, normals, albedo ---------------

/* Reads a plane from a file, maybe of a pattern, or from the frame's (NULL). */
static gp_status read_beside(const struct gp_settings *s,
    const struct gp_frame_state *fs, const char *path, const char *channel,
    bool depth, struct gp_plane *out)
{
    char *name;
    if (!path)
        return gp_read_plane(fs->log, &s->input.read, &fs->file, channel, depth,
                             out);
    gp_status st = gp_job_beside(fs->log, fs->job, path, &name);
    if (st)
        return st;
    st = gp_read_plane_file(fs->log, &s->input.read, name, channel, depth, out);
    free(name);
    return st;
}

/* Reads depth, unless it was. */
static gp_status read_depth(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    return fs->depth.v || gp_no_depth(s)
               ? GP_OK
               : read_beside(s, fs, s->sun.depth_file, s->input.depth, true,
                             &fs->depth);
}

/* Gives `n` planes to the library, if they are there; `file` is theirs. */
static gp_status give(struct gp_frame_state *fs, enum glarepp_view view,
                      const struct gp_plane *plane, int n, const char *file)
{
    struct glarepp_image v = GLAREPP_IMAGE;
    for (int c = 0; c < n; c++)
        v.plane[c] = plane[c].v;
    v.data = plane->window;
    v.name = file;
    return plane->v ? (gp_status) glarepp_frame_set(fs->frame, view, &v)
                    : GP_OK;
}

gp_status gp_run_occluders(const struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_settings *const s = r->s;
    gp_status st;
    GP_TRY(gp_read_samples(r, fs));
    if (fs->deep.first)
        return GP_OK;
    GP_TRY(read_depth(r, fs));
    if (s->sun.mask_file || s->sun.mask)
        GP_TRY(read_beside(s, fs, s->sun.mask_file, s->sun.mask, false,
                           &fs->mask));
    fs->facts.hidden.depth = fs->depth.name;
    fs->facts.hidden.mask = fs->mask.name;
    GP_TRY(give(fs, GLAREPP_DEPTH, &fs->depth, 1, s->sun.depth_file));
    GP_TRY(give(fs, GLAREPP_COVERAGE, &fs->mask, 1, s->sun.mask_file));
out:
    return st;
}

/* Reads depth, normals and albedo for --relight. */
static gp_status read_surfaces(const struct gp_run *r,
                               struct gp_frame_state *fs)
{
    static const struct gp_layer_names normals = {
        "normals", {"N", "Normal", "normal", "Normals", "normals", NULL},
        {{"X", "Y", "Z"}, {"x", "y", "z"}, {"R", "G", "B"}},
    };
    static const struct gp_layer_names albedo = {
        "albedo", {"albedo", "Albedo", "DiffCol", "diffuse_albedo",
                   "diffuse_color", NULL},
        {{"R", "G", "B"}, {"r", "g", "b"}, {"red", "green", "blue"}},
    };
    const struct gp_log *const log = fs->log;
    gp_status st;
    GP_TRY(read_depth(r, fs));
    if (!fs->depth.v)
        GP_TRY(gp_fail(log, GP_ERR_USAGE, "%s: --relight needs depth, and no "
                       "channel is; name one with --depth", fs->job->input));
    GP_TRY(gp_read_vectors(log, &r->s->input.read, &fs->file, &normals,
                           fs->normal));
    GP_TRY(gp_read_vectors(log, &r->s->input.read, &fs->file, &albedo,
                           fs->albedo));
    GP_TRY(give(fs, GLAREPP_DEPTH, &fs->depth, 1, r->s->sun.depth_file));
    GP_TRY(give(fs, GLAREPP_NORMAL, fs->normal, 3, NULL));
    GP_TRY(give(fs, GLAREPP_ALBEDO, fs->albedo, 3, NULL));
out:
    return st;
}

// -- computing ----------------------------------------------------------------

static gp_status run_relight(struct gp_run *r, struct gp_frame_state *fs)
{
    gp_status st = read_surfaces(r, fs);
    if (!st)
        st = (gp_status) glarepp_frame_run(fs->frame, GLAREPP_RELIGHT);
    glarepp_frame_drop(fs->frame, 1u << GLAREPP_NORMAL | 1u << GLAREPP_ALBEDO);
    for (int c = 0; c < 3; c++) {
        gp_plane_free(&fs->normal[c]);
        gp_plane_free(&fs->albedo[c]);
    }
    return st;
}

static gp_status run_suns(struct gp_run *r, struct gp_frame_state *fs)
{
    gp_status st = (gp_status) glarepp_frame_run(fs->frame, GLAREPP_PLACE);
    if (!st && glarepp_frame_facts(fs->frame)->lights > 0)
        st = gp_run_occluders(r, fs);
    return st ? st : (gp_status) glarepp_frame_run(fs->frame, GLAREPP_SHARES);
}

/* Makes pictures of shares from the lights, and says how near they are. */
static gp_status run_shares(struct gp_run *r, struct gp_frame_state *fs)
{
    static const char *const edges[2][2] = {
        // with coverage, with depth
        {NULL, "depth alone: within 0.1 of the truth for a sun of 2.5 pixels; "
               "coverage (--mask) is nearer"},
        {"coverage without depth: surfaces beyond a light hide it too, and the "
         "error is not known; add depth (--depth)",
         "coverage: within 0.02 of the truth for a sun of 2.5 pixels"},
    };
    const struct glarepp_facts *const lib = glarepp_frame_facts(fs->frame);
    struct gp_occluder_facts *const facts = &fs->facts.hidden;
    gp_status st = GP_OK;
    for (int i = 0; i < lib->lights && !facts->edges; i++) {
        if (lib->light[i].in_frame && strcmp(lib->shares_by, "scene") != 0)
            facts->edges =
                fs->deep.first
                    ? "deep: within 0.01 of the truth for a sun of 6 pixels "
                      "among leaves or hair"
                    : edges[facts->mask != NULL][facts->depth != NULL];
    }
    for (int i = 0; i < r->jobs->targets && !st; i++) {
        const enum gp_target_kind kind = r->jobs->target[i].kind;
        struct glarepp_image v;
        if (kind == GP_TARGET_SUNMAP || kind == GP_TARGET_INTENSITY)
            st = (gp_status) glarepp_frame_view(fs->frame,
                                                gp_targets[kind].view, 0, &v);
    }
    return st;
}

/* Ends the library's part, and takes its facts. */
static gp_status run_end(struct gp_run *r, struct gp_frame_state *fs)
{
    const gp_status st =
        (gp_status) glarepp_frame_run(fs->frame, GLAREPP_DONE);
    struct gp_frame_report *const f = &fs->facts;
    f->lib = *glarepp_frame_facts(fs->frame);
    f->dark = f->lib.sense.sources == 0 && !gp_lights_wanted(r->s) &&
              f->job.settings->light.layer.gain > 0.0f &&
              f->cost.ms[GP_TIME_SENSORS] >= 0.0;
    // of the layer with ghosts too, which is no darker than without them
    f->bounded = f->lib.sense.sources || f->lib.lens.name;
    f->bound = f->lib.layer.bound + f->lib.lens.bound;
    memcpy(f->flux_clamped, f->lib.sense.flux_clamped, sizeof f->flux_clamped);
    return st;
}

static gp_status run_tonemap(struct gp_run *r, struct gp_frame_state *fs)
{
    bool shows = fs->view == 0;
    for (int i = 0; i < r->jobs->targets; i++)
        shows = shows || !(r->jobs->target[i].hero || r->jobs->target[i].whole);
    return shows ? (gp_status) glarepp_frame_run(fs->frame, GLAREPP_TONE)
                 : GP_OK;
}

// -- writing -----------------------------------------------------------------

unsigned gp_target_needs(const struct gp_settings *s, enum gp_target_kind kind)
{
    const unsigned shown = untoned(s) ? GP_HAS_LIT : GP_HAS_SHOWN;
    const unsigned needs[] = {
        [GP_TARGET_HDR] = GP_HAS_LIT,
        // (bound_pixel is of the composite, which needs the frame)
        [GP_TARGET_LAYER] = GP_HAS_LAYER | GP_HAS_FLARE | GP_HAS_LENS |
                            (s->light.layer.tolerance_pixel > 0.0f ||
                                     !(s->sun.p.flare_gain > 0.0f)
                                 ? GP_HAS_RGB
                                 : 0u),
        [GP_TARGET_PARTS] = GP_HAS_RGB | GP_HAS_SOURCES | GP_HAS_KERNEL |
                            GP_HAS_LAYER | GP_HAS_FLARE | GP_HAS_LENS,
        [GP_TARGET_PICTURE] = shown,
        [GP_TARGET_SENSORS] = GP_HAS_SOURCES,
        [GP_TARGET_POLYGONS] = GP_HAS_SOURCES | GP_HAS_KERNEL | shown,
        [GP_TARGET_SUNMAP] = GP_HAS_RGB | GP_HAS_SHARES,
        [GP_TARGET_INTENSITY] = GP_HAS_RGB | GP_HAS_SHARES,
    };
    return needs[kind];
}

/* Looks at planes of the library's frame, and at their window. */
static gp_status look_at(struct gp_frame_state *fs, enum glarepp_view view,
                         int group, struct gp_planes *out, struct gp_rect *data)
{
    struct glarepp_image v;
    const int st = glarepp_frame_view(fs->frame, view, group, &v);
    for (int c = 0; c < 3 && !st; c++)
        out->c[c] = v.plane[c];
    if (!st && data)
        *data = v.data;
    return (gp_status) st;
}

/* Converts light that a frame carries to --output-space. */
static gp_status convert_layer(const struct gp_log *log, void *user,
    const struct gp_frame *f, size_t n, const struct gp_planes *in,
    struct gp_planes *out)
{
    const struct gp_run *const r = user;
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_frame *frame = NULL;
    struct glarepp_image v;
    gp_status st;
    p.image = gp_frame_view(f, in);
    p.in_place = true;
    GP_TRY((gp_status) glarepp_frame(r->plan, &p, &frame));
    GP_TRY((gp_status) glarepp_frame_view(frame, GLAREPP_OUTPUT, 0, &v));
    if (!out->c[0])
        GP_TRY(gp_planes_make(log, "layer", n, out));
    for (int c = 0; c < 3; c++)
        memcpy(out->c[c], v.plane[c], n * sizeof *out->c[c]);
out:
    glarepp_frame_end(&frame);
    return st;
}

/* Writes `views` views of one input, then the light groups of each, into one
 * --hdr file. */
static gp_status write_hdr(const struct gp_run *r, struct gp_frame_state *fs,
                           const struct gp_write_params *p, int views,
                           const char *name, struct gp_write_stats *stats)
{
    const struct gp_log *const log = fs->log;
    const int groups = r->s->input.light_groups.n;
    const size_t most = (size_t) views * (1 + (size_t) groups);
    struct gp_hdr_colour *set = NULL;
    gp_status st;
    int n = 0;
    GP_TRY(gp_alloc_zero(log, "colours", most, sizeof *set, &set));
    for (int i = 0; i < views; i++) {
        if (r->s->tone.map.output && !fs[i].converted)
            GP_TRY(gp_convert_layers(log, convert_layer, (void *) (uintptr_t) r,
                                     &fs[i].file, stats));
        fs[i].converted = true;
        set[n].f = &fs[i].file;
        GP_TRY(look_at(&fs[i], GLAREPP_OUTPUT, 0, &set[n++].planes, NULL));
    }
    for (int i = 0; i < views; i++) {
        for (int g = 0; g < groups; g++) {
            set[n].f = &fs[i].group[g];
            GP_TRY(
                look_at(&fs[i], GLAREPP_OUTPUT, g + 1, &set[n++].planes, NULL));
        }
    }
    st = gp_write_hdr(log, p, name, set, n, stats);
out:
    gp_free(set);
    return st;
}

/* Writes the parts of the layer, and then what each light group has of it. */
static gp_status write_parts(const struct gp_run *r, struct gp_frame_state *fs,
                             const struct gp_write_params *p, const char *name,
                             struct gp_write_stats *stats)
{
    const char **names = NULL;
    struct gp_planes *part = NULL;
    const int n = GP_PART_NAMES + r->s->input.light_groups.n;
    struct gp_write_params own = *p;
    own.type = p->type ? p->type : GP_OUT_FLOAT; // halfs would not add up
    gp_status st;
    GP_TRY(gp_alloc(fs->log, "parts", (size_t) n, sizeof *part, &part));
    GP_TRY(gp_alloc(fs->log, "parts", (size_t) n, sizeof *names, &names));
    for (int i = 0; i < n; i++) {
        const int group = i < GP_PART_NAMES ? 0 : i - GP_PART_NAMES + 1;
        names[i] = group ? r->s->input.group[group - 1].name : gp_part_names[i];
        const int view = group ? (int) GLAREPP_GLARE : GLAREPP_PART_VEIL + i;
        GP_TRY(look_at(fs, (enum glarepp_view) view, group, &part[i], NULL));
    }
    st = gp_write_parts(fs->log, &own, name, &fs->file, names, part, n, stats);
out:
    gp_free(names);
    gp_free(part);
    return st;
}

static gp_status write_target(const struct gp_run *r, struct gp_frame_state *fs,
    const struct gp_write_params *p, const struct gp_output *t,
    const char *name, struct gp_write_stats *stats)
{
    const bool picture = t->kind == GP_TARGET_PICTURE;
    const bool map = t->kind == GP_TARGET_SUNMAP ||
                     t->kind == GP_TARGET_INTENSITY;
    enum gp_picture_kind kind = GP_PICTURE_SCENE;
    struct gp_write_params pictures = *p;
    struct gp_frame f = fs->file;
    struct gp_planes planes;
    if (!strchr(gp_targets[t->kind].option, ' ')) // --debug KIND is no option
        pictures.output = gp_targets[t->kind].option;
    if (t->kind == GP_TARGET_HDR)
        return write_hdr(r, fs, &pictures, t->whole ? r->jobs->views : 1, name,
                         stats);
    if (t->kind == GP_TARGET_PARTS)
        return write_parts(r, fs, &pictures, name, stats);
    if (!picture)
        pictures.alpha = GP_ALPHA_BLACK; // light to be added has no alpha
    if (picture || t->kind == GP_TARGET_POLYGONS)
        kind = r->s->tone.map.config ? GP_PICTURE_ENCODED
               : untoned(r->s) ? GP_PICTURE_SCENE : GP_PICTURE_SHOWN;
    const enum glarepp_view view = picture && untoned(r->s)
                                       ? GLAREPP_LIT : gp_targets[t->kind].view;
    gp_status st = look_at(fs, view, 0, &planes, &f.data);
    if (map) { // of a size of its own, and each pixel is a share
        f.display = f.data;
        pictures.dither = GP_DITHER_NEVER;
        kind = GP_PICTURE_SHOWN;
    }
    return st ? st
              : gp_write_picture(fs->log, &pictures, name, &f, &planes,
                                 kind, stats);
}

static gp_status run_write(struct gp_run *r, struct gp_frame_state *fs)
{
    const struct gp_log *const log = fs->log;
    const struct glarepp_plan_facts *const plan = glarepp_plan_facts(r->plan);
    struct gp_write_stats stats = {.raw = r->raw}; // changes when ordered only
    struct gp_write_params p = r->s->output.write;
    struct gp_write_facts *const facts = &fs->facts.write;
    const struct gp_taker *const taker = r->jobs->taker;
    gp_status st = GP_OK;
    if (taker) { // in place of files
        struct gp_planes planes;
        st = look_at(fs, untoned(r->s) ? GLAREPP_LIT : GLAREPP_SHOWN, 0,
                     &planes, NULL);
        return st ? st : taker->take(taker->user, log, &fs->file, &planes);
    }
    p.command = r->s->output.no_provenance ? NULL : fs->facts.job.command;
    if (plan->config) {
        p.primaries = plan->output_primaries;
        memcpy(p.cicp, plan->cicp, sizeof p.cicp);
    }
    for (int i = 0; i < r->jobs->targets && !st; i++) {
        const struct gp_output *const t = &r->jobs->target[i];
        if ((t->whole || t->hero) && fs->view > 0)
            continue; // the first view writes it
        char *const name = gp_job_name(fs->job, t);
        if (!name)
            return gp_no_memory(log, t->name.path);
        facts->file[facts->n] = (struct gp_written) {name, t->kind};
        st = write_target(r, fs, &p, t, name, &stats);
        facts->n += !st;
    }
    if (st)
        return st;
    fs->facts.clamped_out = stats.clamped;
    for (int c = 0; c < 3; c++)
        fs->facts.flux_clamped[c] += stats.flux_clamped[c];
    if (r->ordered)
        r->raw = stats.raw;
    return GP_OK;
}

// -- all of them -------------------------------------------------------------

enum {
    RGB = GP_HAS_RGB, SOURCES = GP_HAS_SOURCES, KERNEL = GP_HAS_KERNEL,
    LAYER = GP_HAS_LAYER, LIT = GP_HAS_LIT, SUNS = GP_HAS_SUNS,
    FLARE = GP_HAS_FLARE, SHARES = GP_HAS_SHARES, LENS = GP_HAS_LENS,
    SCENE = GP_HAS_SCENE, RELIT = GP_HAS_RELIT, END = GP_HAS_END,
};
#define STEP(name) GLAREPP_##name, NULL
#define RUN(function) 0, function
const struct gp_stage gp_stages[GP_STAGES] = {
    {"read", GP_TIME_READ, 0, RGB, RUN(run_read)},
    {"scene", GP_TIME_SCENE, RGB, SCENE, STEP(POSE)},
    {"relight", GP_TIME_RELIGHT, RGB | SCENE, RELIT, RUN(run_relight)},
    {"sun", GP_TIME_SUN, RGB | SCENE, SUNS, RUN(run_suns)},
    {"sensors", GP_TIME_SENSORS, RGB | RELIT, SOURCES, STEP(SENSE)},
    {"kernel", -1, SOURCES | SUNS, KERNEL, STEP(KERNEL)},
    {"glare", GP_TIME_GLARE, SOURCES | KERNEL | SUNS, LAYER, STEP(LAYER)},
    {"verify", -1, RGB | SOURCES | KERNEL | LAYER, GP_HAS_MEASURED,
     STEP(VERIFY)},
    {"flare", GP_TIME_SUN, SOURCES | LAYER | KERNEL | SUNS, FLARE, STEP(FLARE)},
    {"lens", GP_TIME_LENS, RGB | SOURCES | LAYER | FLARE, LENS, STEP(LENS)},
    {"compose", GP_TIME_COMPOSE,
     RGB | SOURCES | KERNEL | LAYER | FLARE | LENS, LIT, STEP(COMPOSE)},
    {"shares", -1, FLARE, SHARES, RUN(run_shares)},
    {"end", -1, LAYER | FLARE | LENS, END, RUN(run_end)},
    {"tonemap", GP_TIME_TONEMAP, LIT, GP_HAS_SHOWN, RUN(run_tonemap)},
    {"write", GP_TIME_WRITE, SHARES | END, GP_HAS_FILES, RUN(run_write)},
};
