// SPDX-License-Identifier: Apache-2.0
/* The field that a frame's kernel is made for: angle of view and projection, and how
 * far the kernel has to reach. */
#include "api/plan.h"

#include "core/maths.h"
#include "core/minmax.h"
#include "glare/sky/sky.h"
#include "glare/veil.h"

#include <math.h>
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

static const enum gp_projecting KIND[] = {GP_PLANE, GP_PERSPECTIVE, GP_LATLONG,
                                          GP_FISHEYE, GP_EQUISOLID};

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
               ? gp_projection_of(KIND[kind], f->image.display, field.aspect,
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
    return gp_fail_at(&f->log, GP_ERR_USAGE, "plan.projection.axis",
                      "%s: a lat-long frame has no axis of a lens, around "
                      "which its flare and ghosts lie",
                      f->sink.name);
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
        if (kind == GLAREPP_PERSPECTIVE && !gp_api_camera(f, &p))
            p = gp_projection_of(KIND[kind], f->image.display, field.aspect,
                                 fov);
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

void gp_api_note_plane(struct glarepp_frame *f, const struct gp_field *field,
                       const struct gp_kernel_request *r)
{
    static const char FISHEYES[] =
        "a fisheye has up to 230 degrees from corner to corner";
    static const char *const LIMITS[] = {
        [GP_PERSPECTIVE] =
            "a pixel may show 8 degrees, be 16 times as long as wide, "
            "and not be small beside the kernel's core",
        [GP_LATLONG] =
            "a lat-long is the whole sphere, its width a multiple of "
            "8 without factors but 2, 3, 5 and 7, from 96 on",
        [GP_FISHEYE] = FISHEYES,
        [GP_EQUISOLID] = FISHEYES,
    };
    const struct gp_recipe *const recipe = f->kernel->recipe;
    struct gp_angular as;
    bool angular = false;
    for (int i = 0; i < r->recipes; i++)
        angular |= recipe[i].model->angular &&
                   recipe[i].model->angular(&recipe[i], field, &as);
    f->facts.kernel.projection = "plane";
    f->flat = angular;
    if (angular || field->projection.kind != GP_PERSPECTIVE)
        gp_say(&f->log, GP_LEVEL_WARN,
               "%s: its glare is that of a plane of %g degrees: %s",
               f->sink.name, f->facts.kernel.fov,
               angular ? LIMITS[field->projection.kind]
                       : "true angles are for models of the angle alone");
}

/* Widens the field so that lights outside of the frame light all of it, up to
 * three frames: in steps, as a light that moves must not remake the kernel for
 * each frame. */
static void reach_lights(const struct glarepp_frame *f, struct gp_field *field)
{
    enum { STEP = 128, MOST = 8192 }; // twice that is what all GL drivers draw
    int offset[2], *const size[2] = {&field->w, &field->h};
    gp_suns_offsets(&f->work->lights->suns, f->image.data, offset);
    for (int i = 0; i < 2; i++) {
        const int most = gp_min(3 * *size[i], MOST);
        if (offset[i] >= *size[i])
            *size[i] =
                gp_max(*size[i], gp_min(most, (offset[i] / STEP + 1) * STEP));
    }
}

void gp_api_field_reach(const struct glarepp_frame *f, struct gp_field *field)
{
    if (f->work->lights)
        reach_lights(f, field);
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

/* The share of the light of a frame's sources that falls outside of it. */
double gp_api_left_out(const struct glarepp_frame *f, const struct gp_kernel *k)
{
    const struct gp_sources *const src = gp_api_bright(f);
    const float *const weight = f->image.luminance;
    // in the middle of the frame, and of what surrounds it by its mirror image
    const double x0 = 0.5 * (f->kernel->field.seen_w - src->w);
    const double y0 = 0.5 * (f->kernel->field.seen_h - src->h);
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
            sum += group * gp_sky_outside(k->sky, x, y);
            group = 0.0;
            pick = fmod(pick + 0.618034, 1.0); // the golden ratio
        }
    }
    return all > 0.0 ? sum / all : k->left_out;
}

gp_status gp_api_veil(struct glarepp_frame *f)
{
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
