// SPDX-License-Identifier: Apache-2.0
#include "api/plan.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "glare/splat/polygons.h"

#include <string.h>

// -- beginning and end --------------------------------------------------------

static gp_status import_groups(struct glarepp_frame *f,
                               const struct glarepp_frame_params *p)
{
    gp_status st;
    GP_TRY(gp_alloc_zero(&f->log, "light groups", (size_t) p->groups + 1,
                         sizeof *f->group, &f->group));
    for (; f->groups < p->groups; f->groups++) {
        const struct glarepp_image *const from = &p->group[f->groups];
        struct gp_api_group *const g = &f->group[f->groups];
        if (memcmp(&from->data, &p->image.data, sizeof from->data) != 0)
            return gp_api_refuse(f, "frame.group",
                                 "the window of group %d is another",
                                 f->groups + 1);
        g->how = p->how ? p->how[f->groups] : (struct glarepp_group) {0, 1.0f};
        GP_TRY(gp_api_check(&f->log, "group", &g->how));
        if (g->how.kernel > f->plan->kernels - 1)
            return gp_api_refuse(f, "group.kernel",
                                 "the plan has no such kernel (found %d)",
                                 g->how.kernel);
        GP_TRY(gp_api_import(&f->log, from, p->in_place, &g->image));
        g->borrowed = g->image.rgb.c[0] == from->plane[0];
    }
out:
    return st;
}

int glarepp_frame(struct glarepp_plan *plan,
                  const struct glarepp_frame_params *from,
                  struct glarepp_frame **out)
{
    struct glarepp *const outer = gp_api_begin(plan->gp);
    struct glarepp_frame_params p = GLAREPP_FRAME_PARAMS;
    struct glarepp_frame *f = NULL;
    gp_status st;
    *out = NULL;
    GP_TRY(gp_api_params(&plan->log, "frame", &p, sizeof p, from));
    GP_TRY(gp_alloc_zero(&plan->log, "frame", 1,
                         sizeof *f + (size_t) plan->kernels * sizeof *f->run,
                         &f));
    f->plan = plan;
    f->p = p;
    f->sink = (struct gp_api_sink) {
        plan->gp, p.user, p.image.name ? p.image.name : "image"};
    f->log = gp_api_log(&f->sink);
    GP_TRY(gp_api_import(&f->log, &p.image, p.in_place, &f->image));
    f->borrowed = f->image.rgb.c[0] == p.image.plane[0];
    f->image.read = p.file;
    f->sink.name = f->image.path;
    GP_TRY(import_groups(f, &p));
    *out = f;
    f = NULL;
out:
    glarepp_frame_end(&f);
    return gp_api_end(outer, st);
}

/* Planes of a view that the frame makes; NULL: others. */
static struct gp_planes *planes_of(struct glarepp_frame *f,
                                   struct gp_image *image,
                                   enum glarepp_view view)
{
    return view == GLAREPP_CLEAN      ? &image->rgb
           : view == GLAREPP_GLARE    ? &image->layer
           : view == GLAREPP_LIT      ? &image->lit
           : view == GLAREPP_SHOWN    ? &image->shown
           : view == GLAREPP_SOURCES  ? &f->sources_shown
           : view == GLAREPP_POLYGONS ? &f->polygons
           : view == GLAREPP_TRUTH    ? &f->truth
           : view >= GLAREPP_PART_VEIL && view <= GLAREPP_PART_GHOSTS
               ? &f->part[view - GLAREPP_PART_VEIL]
           : view == GLAREPP_SUNMAP    ? &f->sunmap.planes
           : view == GLAREPP_INTENSITY ? &f->intensity.planes
                                       : NULL;
}

/* Planes of a view that the caller sets, *n of them; NULL and 0: others. */
static struct gp_plane *plane_of(struct glarepp_frame *f,
                                 enum glarepp_view view, int *n)
{
    struct gp_plane *const of = view == GLAREPP_DEPTH         ? &f->depth
                                : view == GLAREPP_COVERAGE    ? &f->mask
                                : view == GLAREPP_NORMAL      ? f->normal
                                : view == GLAREPP_ALBEDO      ? f->albedo
                                : view == GLAREPP_SOURCE_MASK ? &f->source_mask
                                                              : NULL;
    *n = view == GLAREPP_NORMAL || view == GLAREPP_ALBEDO ? 3 : of != NULL;
    return of;
}

void glarepp_frame_drop(struct glarepp_frame *f, unsigned views)
{
    for (int v = 0; v < GLAREPP_VIEWS; v++) {
        int n;
        struct gp_plane *const plane = plane_of(f, (enum glarepp_view) v, &n);
        for (int c = 0; c < n && views & 1u << v; c++)
            gp_plane_free(&plane[c]);
    }
    if (views & 1u << GLAREPP_CLEAN && f->borrowed)
        f->image.rgb = (struct gp_planes) {0};
    if (views & 1u << GLAREPP_SOURCES) {
        gp_sources_free(&f->sources);
        gp_sources_free(&f->taken);
        gp_sources_free(&f->joined);
        gp_sources_free(&f->whole);
        for (int i = 0; i < f->plan->kernels; i++)
            gp_sources_free(&f->run[i].sources);
    }
    if (views & 1u << GLAREPP_TRUTH)
        GP_FREE(f->exact);
    for (int v = GLAREPP_CLEAN; v < GLAREPP_SOURCE_MASK; v++) {
        if (views & 1u << v && v != GLAREPP_OUTPUT)
            gp_planes_free(planes_of(f, &f->image, (enum glarepp_view) v));
    }
    if (views & 1u << GLAREPP_OUTPUT)
        gp_planes_free(&f->converted);
    for (int i = 0; i < f->groups && views & 1u << GLAREPP_OUTPUT; i++)
        gp_planes_free(&f->group[i].converted);
}

void glarepp_frame_end(struct glarepp_frame **frame)
{
    struct glarepp_frame *const f = *frame;
    if (!f)
        return;
    gp_api_give_back(f->plan, &f->work);
    glarepp_frame_drop(f, ~0u);
    for (int i = 0; i < f->groups; i++) {
        struct gp_api_group *const g = &f->group[i];
        if (g->borrowed)
            g->image.rgb = (struct gp_planes) {0};
        gp_sources_free(&g->sources);
        gp_planes_free(&g->part);
        gp_image_free(&g->image);
    }
    gp_free(f->group);
    for (int i = 0; i < f->plan->kernels; i++)
        gp_made_kernel_free(&f->run[i].kernel);
    gp_free(f->share);
    gp_free(f->relit);
    gp_image_free(&f->image);
    GP_FREE(*frame);
}

const struct glarepp_facts *glarepp_frame_facts(const struct glarepp_frame *f)
{
    return &f->facts;
}

// -- what steps look at -----------------------------------------------------

bool gp_api_find_camera(const struct glarepp_frame *f, struct gp_camera *out)
{
    const struct gp_suns *const suns =
        f->work->lights ? &f->work->lights->suns : NULL;
    struct glarepp_frame_params about = f->p;
    bool found = false;
    if (f->plan->sun.ndc)
        about.ndc = f->plan->sun.ndc;
    // worldToCamera may tell the range, and be wrong
    for (int i = 0; i < 2 && !found; i++, about.has_camera = false) {
        if (!suns)
            found = about.has_ndc &&
                    !gp_camera_make(NULL, NULL,
                                    about.has_camera ? about.to_camera : NULL,
                                    about.to_ndc, about.ndc, out);
        else if (suns->wide.kind ||
                 gp_suns_camera(NULL, suns, &about, &f->image, out, &found))
            found = false;
    }
    return found;
}

double gp_api_camera_fov(const struct glarepp_frame *f)
{
    struct gp_camera c;
    return f->plan->fov > 0.0          ? f->plan->fov
           : gp_api_find_camera(f, &c) ? gp_camera_fov(&c)
           : f->work->lights           ? f->work->lights->suns.more_fov
                                       : 0.0;
}

// -- views --------------------------------------------------------------------

/* Makes floats of the sum in double, to look at. */
static gp_status show_truth(struct glarepp_frame *f)
{
    const size_t n = gp_image_pixels(&f->image);
    if (!f->exact || f->truth.c[0])
        return GP_OK;
    const gp_status st = gp_planes_make(&f->log, "exact layer", n, &f->truth);
    for (size_t i = 0; i < 3 * n && !st; i++)
        f->truth.c[i / n][i % n] = (float) f->exact[i];
    return st;
}

static gp_status replace_layer(struct glarepp_frame *f,
                               const struct glarepp_image *plane)
{
    struct gp_image other;
    gp_status st = gp_api_import(&f->log, plane, false, &other);
    if (st)
        return st;
    if (memcmp(&other.data, &f->image.data, sizeof other.data) != 0) {
        st = gp_fail_at(&f->log, GP_ERR_USAGE, "image.data", "%s: its window is "
                        "not the frame's", other.path);
    } else {
        gp_planes_free(&f->image.layer);
        f->image.layer = other.rgb;
        f->tinted = true; // as one that is looked at is
        other.rgb = (struct gp_planes) {0};
    }
    gp_image_free(&other);
    return st;
}

/* Takes the samples that hide lights. */
static gp_status take_deep(struct glarepp_frame *f,
                           const struct glarepp_image *image)
{
    const struct glarepp_stored *const s = image->plane[0];
    struct gp_deep d = {.window = s ? s->data : (struct gp_rect) {0},
                        .first = s ? s->first : NULL,
                        .name = s ? s->name : NULL};
    const float **const to[] = {&d.z, &d.alpha, &d.back};
    static const char *const name[] = {"Z", "A", "ZBack"};
    for (int i = 0; s && i < s->channels; i++) {
        const struct glarepp_channel *const c = &s->channel[i];
        for (int k = 0; k < 3; k++) {
            if (strcmp(c->name, name[k]) == 0 && !c->is_uint)
                *to[k] = c->v;
        }
    }
    if (!d.first || !d.z || !d.alpha || gp_rect_empty(d.window))
        return gp_fail_at(&f->log, GP_ERR_USAGE, "frame.deep",
                          "%s: deep pixels need channels Z and A of floats",
                          s && s->name ? s->name : f->sink.name);
    f->deep = d;
    return GP_OK;
}

int glarepp_frame_set(struct glarepp_frame *f, enum glarepp_view view,
                      const struct glarepp_image *plane)
{
    struct glarepp *const outer = gp_api_begin(f->plan->gp);
    int planes;
    struct gp_plane *const to = plane_of(f, view, &planes);
    gp_status st = GP_OK;
    if (view == GLAREPP_GLARE)
        GP_TRY(replace_layer(f, plane));
    else if (view == GLAREPP_DEEP)
        GP_TRY(take_deep(f, plane));
    else if (!to)
        GP_TRY(gp_api_refuse(f, "view", "this plane cannot be set (found %d)",
                             (int) view));
    f->hidden = f->hidden && view == GLAREPP_GLARE;
    for (int c = 0; c < planes; c++) {
        gp_plane_free(&to[c]);
        GP_TRY(gp_api_plane(&f->log, plane, c, &to[c]));
    }
    if (to && plane->name) {
        to->name = gp_strdup(plane->name);
        if (!to->name)
            GP_TRY(gp_no_memory_bare(&f->log, "plane"));
    }
out:
    return gp_api_end(outer, st);
}

/* Finds the lit frame, or a group's, or else its pixels, in the output space. */
static gp_status find_output(struct glarepp_frame *f, int group,
                             const struct gp_planes **out)
{
    struct gp_api_group *const g = group ? &f->group[group - 1] : NULL;
    const struct gp_image *const image = g ? &g->image : &f->image;
    struct gp_planes *const to = g ? &g->converted : &f->converted;
    const struct gp_planes *const from =
        f->composed ? &image->lit : &image->rgb;
    *out = f->plan->converts ? to : from;
    return *out == from || to->c[0] || !from->c[0]
               ? GP_OK
               : gp_ocio_convert(&f->log, f->plan->ocio, image,
                                 gp_image_pixels(image), from, to);
}

/* Draws outlines of polygons over the picture. */
static gp_status draw_polygons(struct glarepp_frame *f)
{
    const size_t n = gp_image_pixels(&f->image);
    const struct gp_planes *const under =
        f->image.shown.c[0] ? &f->image.shown : &f->image.lit;
    gp_status st = GP_OK;
    if (!under->c[0]) // COMPOSE was not run
        return GP_OK;
    if (!f->polygons.c[0])
        st = gp_planes_make(&f->log, "polygons", n, &f->polygons);
    for (int c = 0; c < 3 && !st; c++)
        memcpy(f->polygons.c[c], under->c[c], n * sizeof(float));
    return st || !gp_api_bright(f, 0)->n
               ? st
               : gp_polygons_outline(&f->log, gp_api_bright(f, 0),
                                     gp_api_kernel(f, 0), &f->plan->glare.splat,
                                     &f->polygons);
}

/* Makes a picture of the lights' maps. */
static gp_status draw_map(struct glarepp_frame *f, bool intensity,
                          struct gp_api_picture *p)
{
    if (p->planes.c[0])
        return GP_OK;
    if (!f->work || !f->work->lights || !(f->ran & 1u << GLAREPP_SHARES))
        return gp_api_refuse(
            f, "view",
            "maps of lights are there between the steps SHARES and DONE");
    const struct gp_suns *const suns = &f->work->lights->suns;
    return gp_sun_map_picture(&f->log, &suns->occluders,
                              intensity ? NULL : suns->p, &f->image,
                              suns->light, suns->n, p->size, &p->planes);
}

int glarepp_frame_view(struct glarepp_frame *f, enum glarepp_view view,
                       int group, struct glarepp_image *out)
{
    struct glarepp *const outer = gp_api_begin(f->plan->gp);
    const bool grouped = group > 0 && group <= f->groups;
    struct gp_image *const image =
        grouped ? &f->group[group - 1].image : &f->image;
    struct gp_rect data = image->data;
    const bool layer = view == GLAREPP_GLARE;
    const struct gp_planes *planes = layer && grouped
                                         ? &f->group[group - 1].part
                                         : planes_of(f, image, view);
    struct gp_api_picture *const picture =
        view == GLAREPP_SUNMAP      ? &f->sunmap
        : view == GLAREPP_INTENSITY ? &f->intensity : NULL;
    gp_status st = GP_OK;
    if (group && !grouped)
        GP_TRY(gp_api_refuse(f, "group", "no such group (found %d)", group));
    if (layer && !group)
        GP_TRY(gp_api_dark_layer(&f->log, &f->image));
    if (view == GLAREPP_OUTPUT)
        GP_TRY(find_output(f, group, &planes));
    if (view == GLAREPP_SOURCES && !planes->c[0] &&
        f->ran & 1u << GLAREPP_SENSE)
        GP_TRY(gp_sources_planes(&f->log, &f->sources, &f->sources_shown));
    if (view == GLAREPP_POLYGONS)
        GP_TRY(draw_polygons(f));
    if (view >= GLAREPP_PART_VEIL && view <= GLAREPP_PART_GHOSTS)
        GP_TRY(gp_api_part_find(f, view));
    if (view == GLAREPP_TRUTH)
        GP_TRY(show_truth(f));
    if (picture) {
        GP_TRY(draw_map(f, view == GLAREPP_INTENSITY, picture));
        data = (struct gp_rect) {0, 0, picture->size[0], picture->size[1]};
    }
    if (!planes || !planes->c[0])
        GP_TRY(gp_api_refuse(
            f, "view", "the step that makes this plane was not run (found %d)",
            (int) view));
    *out = gp_api_view(planes, data, picture ? NULL : image);
out:
    return gp_api_end(outer, st);
}
