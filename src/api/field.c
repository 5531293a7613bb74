// SPDX-License-Identifier: Apache-2.0
/* The step KERNEL, and the field that a frame's kernel is made for: angle of view and
 * projection, and how far the kernel has to reach. */
#include "api/plan.h"

#include "core/clock.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/minmax.h"
#include "glare/far_field/far_field.h"
#include "glare/sky/sky.h"
#include "glare/veil.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Returns the projection of a frame: the plan's, else its file's, else a camera's. */
static int projection_of(const struct glarepp_frame *f)
{
    const int asked = f->plan->projection;
    // one shape everywhere is all that splat can draw
    const bool flat = strcmp(f->plan->glare.engine, "splat") == 0;
    return asked != GLAREPP_OF_FRAME ? asked
           : flat                    ? GLAREPP_PLANE
           : f->p.projection && f->p.projection != GLAREPP_OF_FRAME
               ? f->p.projection
               : GLAREPP_PERSPECTIVE;
}

_Static_assert((int) GP_PLANE == GLAREPP_PLANE &&
                   (int) GP_EQUISOLID == GLAREPP_EQUISOLID,
               "one order");

/* Tests whether an option gives the angle of a picture that is not a camera's. */
static bool is_given(const struct glarepp_frame *f)
{
    return projection_of(f) != GLAREPP_LATLONG && f->plan->fov > 0.0;
}

struct gp_projection gp_api_wide(const struct glarepp_frame *f)
{
    const int kind = projection_of(f);
    const struct gp_field field = gp_field_of(&f->image, 180.0);
    return kind > GLAREPP_PERSPECTIVE
               ? gp_projection_of((enum gp_projecting) kind, f->image.display,
                                  field.aspect,
                                  is_given(f) ? f->plan->fov : 180.0)
               : (struct gp_projection) {0};
}

enum glarepp_edges gp_api_edges(const struct glarepp_frame *f)
{
    const struct gp_projection p = gp_api_wide(f);
    const struct gp_rect d = f->image.data;
    const double more =
        gp_mirror_reach(gp_image_w(&f->image), gp_image_h(&f->image));
    double u = fmax(fabs(d.x0 - p.x0), fabs(d.x1 - p.x0)) * p.dx;
    double v = fmax(fabs(d.y0 - p.y0), fabs(d.y1 - p.y0)) * p.dy;
    if (p.kind == GP_LATLONG || (p.rim > 0.0 && gp_hypot(u, v) > p.rim))
        return GLAREPP_BLACK;
    u += more * p.dx;
    v += more * p.dy;
    return f->plan->edges == GLAREPP_MIRROR && p.rim > 0.0 &&
                   gp_hypot(u, v) > p.rim
               ? GLAREPP_EXTEND
               : f->plan->edges;
}

gp_status gp_api_has_axis(const struct glarepp_frame *f)
{
    if (projection_of(f) != GLAREPP_LATLONG)
        return GP_OK;
    return gp_api_refuse(f, "plan.projection.axis",
                         "a lat-long frame has no axis of a lens, around which "
                         "its flare and ghosts lie");
}

/* The fault of the frame's matrices, where they give the angle of view; NULL:
 * nothing. */
static const char *camera_fault(const struct glarepp_frame *f)
{
    struct gp_camera c;
    if (!f->p.has_ndc || f->plan->fov > 0.0 || f->plan->sun.cameras)
        return NULL;
    if (!gp_api_find_camera(f, &c))
        return "is of no perspective camera: its angles are not taken";
    return c.has_camera && gp_v3_dot(gp_column(c.to_ndc, 1),
                                     gp_column(c.to_camera, 1)) > 0.0
               ? "has y up, as of -1 to 1, and is taken as 0 to 1 with y down"
               : NULL;
}

/* Returns struct gp_field's: overscan of an eighth, as is usual, makes no difference. */
static double tangent_of(const struct gp_projection *p,
                         const struct gp_image *f)
{
    const struct gp_rect of[] = {f->display, f->data};
    double most[2] = {0.0};
    for (int i = 0; i < 2; i++) {
        const double more = i ? 0.0 : 0.125;
        const double x = more * gp_rect_w(of[i]), y = more * gp_rect_h(of[i]);
        most[0] = fmax(most[0], fmax(p->x0 - of[i].x0, of[i].x1 - p->x0) + x);
        most[1] = fmax(most[1], fmax(p->y0 - of[i].y0, of[i].y1 - p->y0) + y);
    }
    return gp_hypot(most[0] * p->dx, most[1] * p->dy);
}

/* The field of a frame: its angle of view is the plan's, else its camera's or
 * scene's, else its lens's, else the usual one. */
struct gp_field gp_api_field(struct glarepp_frame *f,
                             struct glarepp_kernel_facts *facts)
{
    const struct gp_kernel_request *const r = f->plan->kernel->request;
    static const char *const NAME[] = {"plane", "perspective", "latlong",
                                       "fisheye", "equisolid"};
    const int kind = projection_of(f);
    double fov = gp_api_camera_fov(f);
    struct gp_camera camera;
    facts->fov_from = f->plan->fov > 0.0 ? "option" : "camera";
    if (kind > GLAREPP_PERSPECTIVE) {
        fov = is_given(f) ? f->plan->fov : 180.0;
        facts->fov_from = is_given(f) ? "option" : "projection";
    } else if (!(fov > 0.0)) {
        struct gp_api_stop stop = {.fov = GP_USUAL_FOV};
        const bool known =
            f->plan->lens_params.lens && gp_api_lens_stop(f, &stop);
        facts->fov_from = known ? "lens" : "default";
        fov = stop.fov;
    }
    struct gp_field field = gp_field_of(&f->image, fov);
    field.rotate = f->plan->rotate;
    field.tolerance = (double) f->plan->glare.tolerance;
    field.fps = f->p.fps > 0.0 ? f->p.fps : field.fps;
    facts->projection = NAME[kind];
    if (kind != GLAREPP_PLANE) {
        const struct gp_rect *const data = &f->image.data;
        struct gp_projection p = gp_api_wide(f);
        if (kind == GLAREPP_PERSPECTIVE)
            p = !(f->plan->fov > 0.0) && gp_api_find_camera(f, &camera)
                    ? gp_camera_projection(&camera, f->image.display)
                    : gp_projection_of(GP_PERSPECTIVE, f->image.display,
                                       field.aspect, fov);
        field.tangent = tangent_of(&p, &f->image);
        field.degrees = fmin(p.dy * (180.0 / M_PI), 180.0); // in its middle
        field.aspect = p.dx / p.dy;
        // the first pixel's middle
        p.x0 -= data->x0 + 0.5;
        p.y0 -= data->y0 + 0.5;
        field.projection = p;
        field.seen_w = field.w;
        field.seen_h = field.h;
    }
    field.frame = f->p.numbered ? f->p.number : 0;
    const bool angled = r->recipes || r->degrees > 0.0;
    facts->deg_per_pixel = angled ? field.degrees : 0.0;
    facts->fov = fov;
    return field;
}

/* Says, once a run, what is drawn as in a plane of a frame that is none. Its layer has no
 * bound, but for shapes that a camera's frame has the same everywhere. */
static void note_plane(struct glarepp_frame *f, const struct gp_field *field,
                       const struct gp_kernel_request *r)
{
    static const char FISHEYES[] =
        "a fisheye has up to 230 degrees from corner to corner, and a pixel 8";
    static const char *const LIMITS[] = {
        [GP_PERSPECTIVE] =
            "a pixel may show 8 degrees, be 16 times as long as wide, "
            "and not be small beside the kernel's core",
        [GP_LATLONG] =
            "a lat-long is the sphere, or part of it, its width even, from "
            "96 on, without prime factors over 127",
        [GP_FISHEYE] = FISHEYES,
        [GP_EQUISOLID] = FISHEYES,
    };
    const bool splat = field->projection.kind == GP_PLANE;
    const bool wide = splat ? f->p.projection == GLAREPP_LATLONG
                            : field->projection.kind != GP_PERSPECTIVE;
    const struct gp_sky *const sky = f->run->kernel->k.sky;
    bool angular = false, shapes = wide && !r->recipes;
    struct gp_angular as;
    for (int i = 0; i < r->recipes; i++) {
        const struct gp_recipe *const one = &f->run->kernel->recipe[i];
        const struct gp_model *const m = one->model;
        const bool opening = field->projection.kind == GP_PERSPECTIVE &&
                             strcmp(m->name, "aperture") == 0;
        const bool by = m->angular ? m->angular(one, field, &as) : opening;
        if (sky && m->angular && by && as.lacks &&
            gp_api_says(&f->plan->names->said, GP_SAID_LACKS))
            gp_say(&f->log, GP_LEVEL_WARN,
                   "%s: its glare has no %s, which are for a camera's frame",
                   f->sink.name, as.lacks);
        if ((sky && by && (!opening || gp_sky_facts(sky)->cosines)) ||
            !(gp_recipe_key(one, "share", 0.0) > 0.0))
            continue;
        angular |= by;
        shapes |= !by && (wide || m->angular);
    }
    if (!sky)
        f->facts.kernel.projection = "plane";
    f->flat = angular || shapes;
    if (f->flat && gp_api_says(&f->plan->names->said, GP_SAID_PLANE))
        gp_say_at(&f->log, GP_LEVEL_WARN, splat ? "plan.projection" : "",
                  "%s: %s is that of a plane of %g degrees: %s", f->sink.name,
                  sky ? "part of its glare" : "its glare", f->facts.kernel.fov,
                  splat     ? "splat has one shape everywhere"
                  : angular ? LIMITS[field->projection.kind]
                            : "true angles are for models of the angle");
}

/* Warns, once a run, of attributes that are not taken for what they say. */
static void warn_of_attributes(const struct glarepp_frame *f)
{
    const int w = gp_rect_w(f->image.display), h = gp_rect_h(f->image.display);
    const int kind = projection_of(f);
    const char *const fault =
        kind <= GLAREPP_PERSPECTIVE ? camera_fault(f) : NULL;
    if (kind == GLAREPP_LATLONG && abs(w - 2 * h) > 2 &&
        gp_api_says(&f->plan->names->said, GP_SAID_SPHERE))
        gp_say(&f->log, GP_LEVEL_WARN,
               "%s: taken as the whole sphere, which is twice as wide as high "
               "(found %dx%d)",
               f->sink.name, w, h);
    if (fault && gp_api_says(&f->plan->names->said, GP_SAID_MATRIX))
        gp_say_at(&f->log, GP_LEVEL_WARN, "frame.to_ndc",
                  "%s: its worldToNDC %s", f->sink.name, fault);
}

/* Widens the field so that lights outside of the frame light all of it, up to three
 * frames, in steps, as a light that moves must not remake the kernel for each frame; and
 * by its mirror image. */
static void field_reach(const struct glarepp_frame *f, struct gp_field *field)
{
    enum { STEP = 128, MOST = 8192 }; // twice that is what all GL drivers draw
    int offset[2] = {0}, *const size[2] = {&field->w, &field->h};
    if (f->work->lights)
        gp_suns_offsets(&f->work->lights->suns, f->image.data, offset);
    for (int i = 0; i < 2; i++) {
        const int most = gp_min(3 * *size[i], MOST);
        if (offset[i] >= *size[i])
            *size[i] =
                gp_max(*size[i], gp_min(most, (offset[i] / STEP + 1) * STEP));
    }
    if (field->projection.kind == GP_LATLONG) // half a turn to each side
        field->w += gp_rect_w(f->image.display);
    if (gp_api_edges(f) == GLAREPP_MIRROR) {
        const int more =
            2 * gp_mirror_reach(gp_image_w(&f->image), gp_image_h(&f->image));
        field->w += more;
        field->h += more;
        field->seen_w += more;
        field->seen_h += more;
        field->projection.x0 += 0.5 * more;
        field->projection.y0 += 0.5 * more;
    }
}

/* The share of the light of a frame's sources that falls outside of it, by a kernel of
 * true angles. */
static double left_out_of(const struct glarepp_frame *f,
                          const struct gp_kernel *k)
{
    const struct gp_sources *const src = gp_api_bright(f, 0);
    const float *const weight = f->image.luminance;
    // in the middle of the frame, and of what surrounds it by its mirror image
    const double x0 = 0.5 * (f->run->kernel->field.seen_w - src->w);
    const double y0 = 0.5 * (f->run->kernel->field.seen_h - src->h);
    double all = 0.0, sum = 0.0, group = 0.0, pick = 0.5;
    double x = 0.0, y = 0.0;
    for (int c = 0; c < 3; c++)
        all += (double) weight[c] * src->flux[c];
    // of neighbours that are a thousandth together, by the place of one of them: where
    // a part of their light is before it, parts that are spread evenly
    const double part = 1e-3 * all;
    for (int row = 0; row < src->h; row++) {
        for (uint32_t i = src->row[row]; i < src->row[row + 1]; i++) {
            const double light = (double) (weight[0] * src->rgb[0][i] +
                                           weight[1] * src->rgb[1][i] +
                                           weight[2] * src->rgb[2][i]);
            if (group <= pick * part || light > 0.5 * part) {
                x = x0 + src->x[i];
                y = y0 + row;
            }
            group += light;
            if (group < part && i + 1 < src->n)
                continue;
            sum += group * gp_sky_left_out(k->sky, x, y);
            group = 0.0;
            pick = fmod(pick + 0.618034, 1.0); // the golden ratio
        }
    }
    return all > 0.0 ? sum / all : k->left_out;
}

/* Lists lights that add glare of their own, in the frame or beside it. */
static int veil_lamps(const struct glarepp_frame *f,
                      struct gp_veil_lamp lamp[GP_LIGHTS_MAX])
{
    const struct gp_api_lights *const lights = f->work ? f->work->lights : NULL;
    int n = 0;
    if (!lights || !(f->ran & 1u << GLAREPP_SHARES) || f->plan->sun.in_frame)
        return 0;
    for (int i = 0; i < lights->suns.n; i++) {
        const struct gp_light *const l = &lights->suns.light[i];
        double there;
        const double pixels = gp_suns_pixels(&lights->suns, l, &there);
        const double radius = sqrt(there / M_PI), wide = gp_light_stretch(l);
        if (!gp_light_has_flux(l) || l->found)
            continue;
        const double flux = (double) gp_lit_luminance(
            f->image.luminance, l->flux[0], l->flux[1], l->flux[2]);
        lamp[n++] = (struct gp_veil_lamp) {{l->x, l->y},
                                           {radius * wide, radius / wide},
                                           l->visibility * flux / pixels};
    }
    return n;
}

gp_status gp_api_veil(struct glarepp_frame *f)
{
    struct gp_veil_lamp lamp[GP_LIGHTS_MAX];
    const struct gp_kernel_request *const r = f->plan->kernel->request;
    const struct gp_rect *const data = &f->image.data;
    struct glarepp_kernel_facts unused; // a frame without light has no kernel
    const struct gp_field field = gp_api_field(f, &unused);
    struct gp_veil_params p = {
        .projection = field.projection,
        .at = {f->p.fixation[0], f->p.fixation[1]},
        .white = f->p.white,
        .age = 35.0,
        .pigment = 0.5,
        .lamp = lamp,
        .lamps = veil_lamps(f, lamp),
    };
    memset(&f->facts.veil, 0, sizeof f->facts.veil);
    if (!(p.white > 0.0) || p.projection.kind == GP_PLANE) {
        f->facts.veil.missing =
            p.white > 0.0 ? "pixels of a plane have no directions"
                          : "cd/m2 of 1 not known: no whiteLuminance, and no "
                            "luminance scale is given";
        return GP_OK;
    }
    p.projection.x0 += data->x0 + 0.5;
    p.projection.y0 += data->y0 + 0.5;
    for (int k = 0; k < 2 && !f->p.fixated; k++)
        p.at[k] = gp_rect_middle(f->image.display, k);
    for (int i = r->recipes - 1; i >= 0; i--) {
        p.age = gp_recipe_key(&r->recipe[i], "age", p.age);
        p.pigment = gp_recipe_key(&r->recipe[i], "pigment", p.pigment);
    }
    f->facts.veil.white = p.white;
    f->facts.veil.age = p.age;
    f->facts.veil.pigment = p.pigment;
    memcpy(f->facts.veil.at, p.at, sizeof p.at);
    return gp_veil_measure(&f->log, &p, &f->image, &f->facts);
}

// -- kernel -------------------------------------------------------------------

/* Gives openings the stop of the lens, but for keys that are written. */
static void fit_lens(const struct gp_api_stop *stop, int recipes,
                     struct gp_recipe recipe[GP_RECIPES])
{
    for (int i = 0; i < recipes; i++) {
        struct gp_recipe *const k = &recipe[i];
        if (strcmp(k->model->name, "aperture") != 0)
            continue;
        gp_recipe_preset(k, "blades", stop->blades);
        gp_recipe_preset(k, "roundness", 0.0);
        gp_recipe_preset(k, "rotation", stop->turn);
        gp_recipe_preset(k, "fnumber", stop->f_number);
        gp_recipe_preset(k, "focal", stop->focal);
    }
}

/* The frame's use of kernel k; *worst is the recipe that misses most. */
static struct gp_kernel_use use_of(const struct glarepp_frame *f, int k,
                                   int *worst)
{
    const struct gp_kernel_request *const r = f->plan->kernel[k].request;
    const struct gp_made_kernel *const made = f->run[k].kernel;
    const double scale =
        r->recipes ? 1.0 : gp_kernel_request_scale(r, &made->field);
    struct gp_kernel_use use = {0};
    double shares = 0.0, missed = 0.0, most = 0.0;
    *worst = 0;
    for (int i = 0; i < gp_max(r->recipes, 1); i++) {
        const double share = r->recipes ? r->recipe[i].value[0] : 1.0;
        gp_kernel_label_use(&r->label[i], scale, &made->k,
                            gp_image_w(&f->image), gp_image_h(&f->image), &use);
        missed += share * use.missed;
        *worst = share * use.missed > most ? i : *worst;
        most = fmax(most, share * use.missed);
        shares += share;
    }
    use.missed = missed / fmax(shares, 1.0);
    use.share = gp_kernel_request_share(r);
    use.ends = use.ends && !r->recipes;
    if (!r->recipes) {
        use.as_it_is = use.as_it_is && r->params.normalize == GP_NORMALIZE_NONE;
        use.centred = r->params.centered;
        use.resampled = made->k.resampled;
    }
    use.add = f->plan->compose.mix == GLAREPP_ADD;
    use.brightest =
        (double) f->sources.brightest * (double) f->plan->compose.gain;
    return use;
}

/* The use of an image that a recipe names, by its keys. */
static struct gp_kernel_use use_of_image(const struct gp_recipe *recipe)
{
    const struct gp_model_key *const keys = recipe->model->keys;
    struct gp_kernel_use use = {.as_it_is = recipe->as_it_is};
    for (int i = 0; keys[i].name; i++) {
        if (recipe->value[i] == keys[i].preset)
            continue;
        use.centred |=
            strcmp(keys[i].name, "x") == 0 || strcmp(keys[i].name, "y") == 0;
        use.resampled |= strcmp(keys[i].name, "size") == 0 ||
                         strcmp(keys[i].name, "percent") == 0;
    }
    return use;
}

/* A warning about the words [first, last) of kernel k, 0 the plan's own. */
static void warn_of(const struct glarepp_frame *f, int k, int first, int last,
                    const struct gp_fault *fault)
{
    char parameter[64];
    if (k)
        snprintf(parameter, sizeof parameter, "plan.more %d %s", k - 1,
                 fault->parameter);
    else
        snprintf(parameter, sizeof parameter, "kernel.word %d %d %s", first,
                 last, fault->parameter);
    gp_say_at(&f->log, GP_LEVEL_WARN, parameter, "%s", fault->line);
}

/* Warns, once a plan, of each fault of kernel k that a frame shows. */
static void warn_of_kernel(const struct glarepp_frame *f, int k,
                           const struct gp_field *field,
                           const struct gp_kernel_use *use, int worst)
{
    struct gp_api_plan_kernel *const of = &f->plan->kernel[k];
    const struct gp_kernel_request *const r = of->request;
    const struct glarepp_label *const l = &r->label[0];
    struct gp_fault fault;
    for (int i = 0; i < GP_KERNEL_RULES; i++) {
        const bool one = i == GP_RULE_LEFT_OUT;
        if (gp_kernel_fault(&f->run[k].kernel->figures, use,
                            (enum gp_kernel_rule) i, &fault) &&
            gp_api_says(&of->said, i))
            warn_of(f, k, one ? worst : 0, one ? worst + 1 : GP_RECIPES,
                    &fault);
    }
    if (r->recipes || !l->present ||
        strcmp(f->facts.kernel.fov_from, "default") == 0)
        return;
    // (an image may be kept from another angle)
    const double made = gp_middle_degrees(l->fov, l->h);
    const double used = field->degrees * gp_kernel_request_scale(r, field);
    fault.parameter = "kernel.percent.angle";
    snprintf(fault.line, sizeof fault.line,
             "made for %.4g degrees a pixel, used at %.4g (%.4g%% of it would "
             "fit); make it again for this angle and size",
             made, used, 100.0 * made / field->degrees);
    if (fabs(used / made - 1.0) > 0.01 && gp_api_says(&of->said, GP_SAID_ANGLE))
        warn_of(f, k, 0, 1, &fault);
}

/* Warns, once a plan, of faults of images among several that make up kernel k. */
static gp_status warn_of_images(const struct glarepp_frame *f, int k)
{
    struct gp_api_plan_kernel *const of = &f->plan->kernel[k];
    const struct gp_kernel_request *const r = of->request;
    if (!r->recipes || !gp_api_says(&of->said, GP_SAID_IMAGES))
        return GP_OK;
    for (int i = 0; i < r->recipes; i++) {
        const struct gp_recipe *const recipe = &r->recipe[i];
        const struct gp_kernel_params p = {
            .normalize = GP_NORMALIZE_NONE,
            .left_out = r->label[i].left_out,
        };
        const struct gp_kernel_use use = use_of_image(recipe);
        struct gp_kernel_figures figures;
        struct gp_kernel image;
        struct gp_fault fault;
        if (strcmp(recipe->model->name, "image") != 0)
            continue;
        const gp_status st =
            gp_kernel_from_frame(&f->log, &p, recipe->image, &image);
        if (st)
            return st;
        gp_kernel_measure(&image, recipe->image->luminance, &figures);
        gp_kernel_free(&image);
        for (int rule = GP_RULE_SIZE; rule <= GP_RULE_SYMMETRY; rule++) {
            if (gp_kernel_fault(&figures, &use, (enum gp_kernel_rule) rule,
                                &fault))
                warn_of(f, k, i, i + 1, &fault);
        }
    }
    return GP_OK;
}

/* Takes kernel i of the plan, made for the field unless it is kept, and warns of
 * it; returns its use and the time of making it. */
static gp_status take_kernel(struct glarepp_frame *f, int i,
                             const struct gp_field *field,
                             struct gp_kernel_use *use)
{
    struct gp_made_kernel **const out = &f->run[i].kernel;
    const struct gp_api_plan_kernel *const of = &f->plan->kernel[i];
    struct glarepp_kernel_facts *const facts = &f->facts.kernel;
    const double from = gp_now_ms(), cpu = gp_cpu_ms();
    const struct gp_kernel_request *const r = of->request;
    struct gp_recipe recipe[GP_RECIPES];
    struct gp_api_stop stop;
    bool made;
    int worst;
    gp_status st;
    memcpy(recipe, r->recipe, sizeof recipe);
    if (f->plan->lens_params.lens && gp_api_lens_stop(f, &stop))
        fit_lens(&stop, r->recipes, recipe);
    for (int k = 0; k < r->recipes; k++)
        gp_recipe_adapt(&recipe[k], f->mean, f->white);
    gp_made_kernel_free(out);
    GP_TRY(gp_kernels_take(&f->log, of->kept, recipe, field, &made, out));
    GP_TRY(warn_of_images(f, i));
    if (made) {
        facts->ms += gp_now_ms() - from;
        facts->cpu_ms += gp_cpu_ms() - cpu;
    }
    *use = use_of(f, i, &worst);
    warn_of_kernel(f, i, field, use, worst);
out:
    return st;
}

gp_status gp_api_make_kernel(struct glarepp_frame *f)
{
    struct glarepp_kernel_facts *const facts = &f->facts.kernel;
    const struct gp_kernel_request *const r = f->plan->kernel->request;
    const struct gp_api_lights *const lights = f->work->lights;
    struct gp_kernel_use use, other;
    gp_status st;
    if (!f->sources.n && !(lights && gp_suns_have_light(&lights->suns, true)))
        return GP_OK;
    struct gp_field field = gp_api_field(f, facts);
    field_reach(f, &field);
    facts->ms = facts->cpu_ms = 0.0;
    for (int i = 0; i < f->plan->kernels; i++) {
        if (i == 0 || f->run[i].sources.n)
            GP_TRY(take_kernel(f, i, &field, i ? &other : &use));
    }
    const struct gp_kernel *const k = gp_api_kernel(f, 0);
    facts->recipes = r->recipes;
    facts->modelled = r->recipes || r->label[0].present;
    facts->w = k->w;
    facts->h = k->h;
    facts->grid = k->far ? k->far->split.step : 0;
    facts->left_out = fmax(k->sky ? left_out_of(f, k) : k->left_out, 0.0);
    f->flat = false;
    if (field.projection.kind != GP_PLANE ||
        f->plan->projection == GLAREPP_OF_FRAME)
        note_plane(f, &field, r);
    warn_of_attributes(f);
    facts->missed = use.missed;
    memcpy(facts->faint, k->faint, sizeof facts->faint);
    for (int i = 0; i < r->recipes; i++) {
        facts->pupil[i] =
            gp_recipe_pupil(&f->run->kernel->recipe[i], &f->run->kernel->field);
        facts->recipe[i] = f->run->kernel->text[i];
    }
out:
    return st;
}
