// SPDX-License-Identifier: Apache-2.0
/* Ghosts of a real lens in a frame: of the lights that have flux, or of the
 * brightest sources; and a lens's prescription and its first-order optics. */
#include "api/plan.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Focuses the lens by the plan, else by the frame where it can do so. */
static gp_status focus(const struct glarepp_frame *f, const struct gp_log *log,
                       struct gp_lens *lens)
{
    const struct glarepp_lens_params *const p = &f->plan->lens_params;
    double distance = INFINITY, f_number = p->f_number;
    *lens = f->plan->lens;
    if (p->distance > 0.0)
        distance = 1e3 * p->distance;
    else if (f->p.focus > 0.0)
        distance = 1e3 * f->p.focus;
    if (!(f_number > 0.0) && f->p.aperture > 0.0)
        f_number = f->p.aperture;
    if (gp_lens_focus(NULL, lens, distance, f_number) == GP_OK)
        return GP_OK;
    *lens = f->plan->lens;
    if (!(p->f_number > 0.0)) // an f-number that is not of this lens
        f_number = 0.0;
    if (!(p->distance > 0.0)) // nor a distance
        distance = INFINITY;
    return gp_lens_focus(log, lens, distance, f_number);
}

/* Returns the width of the display window on the sensor in mm. */
static double sensor_width(struct glarepp_frame *f, const struct gp_lens *lens)
{
    const double w = gp_rect_w(f->image.display) *
                     (double) f->image.pixel_aspect;
    const double h = gp_rect_h(f->image.display);
    const char **const from = &f->facts.lens.sensor_from;
    const double fov = gp_api_camera_fov(f);
    struct glarepp_lens figures;
    *from = "option";
    if (f->plan->lens_params.sensor > 0.0)
        return f->plan->lens_params.sensor;
    gp_lens_measure(lens, &figures);
    if (fov > 0.0) {
        *from = "angle";
        return 2.0 * figures.focal * gp_tan(fov * M_PI / 360.0) * w / h;
    }
    if (f->p.sensor > 0.0 && f->p.sensor <= 1e4) {
        *from = "attribute";
        return f->p.sensor;
    }
    *from = lens->says.claims_height > 0.0 ? "lens" : "default";
    return lens->says.claims_height > 0.0
               ? 2.0 * lens->says.claims_height * w / gp_hypot(w, h)
               : 36.0; // of 35 mm film
}

bool gp_api_lens_stop(struct glarepp_frame *f, struct gp_api_stop *out)
{
    const struct gp_image *const image = &f->image;
    struct glarepp_lens figures;
    struct gp_lens lens;
    if (focus(f, NULL, &lens))
        return false;
    gp_lens_measure(&lens, &figures);
    const double height = sensor_width(f, &lens) * gp_rect_h(image->display) /
                          (gp_rect_w(image->display) *
                           (double) image->pixel_aspect);
    // in digits that a report can do with
    *out = (struct gp_api_stop) {
        .focal = round(1e3 * figures.focal) / 1e3,
        .f_number = round(1e3 * figures.f_number) / 1e3,
        .fov = 360.0 / M_PI * gp_atan(0.5 * height / figures.focal),
        .blades = lens.says.blades,
        .turn = lens.turn,
    };
    return true;
}

/* Adds ghosts of the lens to image.layer, which is made; those that `gain` leaves
 * dark are left out. */
static gp_status draw(struct glarepp_frame *f, enum gp_lens_detail detail,
                      double gain)
{
    struct gp_image *const image = &f->image;
    struct glarepp_lens_facts *const facts = &f->facts.lens;
    const struct gp_suns *const suns = &f->work->lights->suns;
    struct gp_lens_light *light = NULL;
    struct glarepp_lens_facts found = {0};
    struct gp_lens lens;
    double dark[3] = {0}, rest;
    gp_status st;
    int n = 0;
    GP_TRY(gp_lens_lights(&f->log, suns->light, suns->n, &f->sources, &light,
                          &n, &rest, dark));
    GP_TRY(focus(f, &f->log, &lens));
    const double width = sensor_width(f, &lens);
    const double mm = width / gp_rect_w(image->display);
    const struct gp_lens_view view = {
        .frame = image->data,
        .display = image->display,
        .mm = {mm, mm / (double) image->pixel_aspect},
        .chromaticities = image->chromaticities,
        .luminance = image->luminance,
        // (what is left out is seen by its gain)
        .mean = gp_log_average(image, &image->rgb) / fmax(gain, 1.0),
        .tolerance = detail == GP_LENS_REFERENCE
                         ? 0.0
                         : (double) f->plan->glare.tolerance,
        .rest = {dark[0], dark[1], dark[2]},
        .detail = detail,
    };
    if (n)
        GP_TRY(gp_lens_draw(&f->log, &lens, &view, light, n, &image->layer,
                            &found));
    found.name = f->plan->lens.says.name;
    found.sensor = width;
    found.sensor_from = facts->sensor_from;
    found.rest = rest;
    found.gain = 1.0;
    *facts = found;
out:
    gp_free(light);
    return st;
}

/* Draws ghosts into a layer of their own and adds them times their gain. */
static gp_status draw_part(struct glarepp_frame *f, enum gp_lens_detail detail)
{
    struct glarepp_lens_facts *const facts = &f->facts.lens;
    const float gain = f->plan->lens_params.gain;
    struct gp_image *const image = &f->image;
    struct gp_planes before = {0};
    double level;
    gp_status st;
    GP_TRY(gp_api_part_open(f, image, &before));
    GP_TRY(draw(f, detail, (double) gain));
    level = gp_api_part_level(f, image, gain);
    if (!(gain > 0.0f) && level > 1.0) { // those left out would be seen
        gp_planes_clear(&image->layer, 0, gp_image_pixels(image));
        GP_TRY(draw(f, detail, level));
        level = gp_api_part_level(f, image, gain);
    }
    facts->gain = level;
    facts->missing *= level;
    for (int c = 0; c < 3; c++)
        facts->light[c] *= level;
out:
    if (before.c[0])
        gp_api_part_close(f, image, facts->gain, &before,
                          &f->part[GLAREPP_PART_GHOSTS - GLAREPP_PART_VEIL]);
    return st;
}

gp_status gp_api_lens(struct glarepp_frame *f)
{
    enum { FEW = 8 }; // hidden ones count: nothing changes as they appear
    const struct gp_suns *const suns = &f->work->lights->suns;
    struct glarepp_lens_facts *const facts = &f->facts.lens;
    const int n = suns->placed + gp_max(f->plan->sun.found, suns->knowns);
    const int asked = f->plan->lens_params.detail;
    const enum gp_lens_detail detail = asked ? (enum gp_lens_detail)(asked - 1)
                                       : n > 0 && n <= FEW ? GP_LENS_FINE
                                                           : GP_LENS_COARSE;
    const bool apart = f->p.parts || f->plan->lens_params.gain != 1.0f;
    double sum[3], squares;
    gp_status st = gp_api_dark_layer(&f->log, &f->image);
    if (!st)
        st = apart ? draw_part(f, detail) : draw(f, detail, 1.0);
    if (st || !(facts->missing > 0.0))
        return st;
    // all ghosts are light: the exact layer is no less than one without some
    gp_planes_sum(&f->image.layer, gp_image_pixels(&f->image), sum, &squares);
    facts->bound = facts->missing / sqrt(squares);
    return st;
}

// -- a prescription -----------------------------------------------------------

struct own {
    struct glarepp *gp;
    struct gp_lens lens;
    char *svg;
};

int glarepp_lens(struct glarepp *gp, const char *lens, struct glarepp_lens *out)
{
    struct glarepp *const outer = gp_api_begin(gp);
    struct own *own = NULL;
    gp_status st;
    gp_api_about("lens");
    memset(out, 0, sizeof *out);
    GP_TRY(gp_alloc_zero(&gp->log, "lens", 1, sizeof *own, &own));
    out->own = own;
    own->gp = gp;
    GP_TRY(gp_lens_read(&gp->log, lens, &own->lens));
    GP_TRY(gp_lens_focus(&gp->log, &own->lens, INFINITY, 0.0));
    gp_lens_measure(&own->lens, out);
    out->own = own;
    GP_TRY(gp_alloc(&gp->log, "ghosts", GP_LENS_GHOSTS, sizeof *out->ghost,
                    &out->ghost));
    out->ghosts = gp_lens_ghosts(&own->lens, GP_D_LINE, out->ghost, NULL);
out:
    if (st)
        glarepp_lens_end(out);
    return gp_api_end(outer, st);
}

void glarepp_lens_end(struct glarepp_lens *lens)
{
    struct own *const own = lens->own;
    if (own)
        free(own->svg);
    gp_free(own);
    gp_free(lens->ghost);
    memset(lens, 0, sizeof *lens);
}

const char *glarepp_lens_draw(struct glarepp_lens *lens,
                              const struct glarepp_ghost *ghost)
{
    struct own *const own = lens->own;
    struct glarepp *const outer = gp_api_begin(own->gp);
    const bool there = !ghost || (ghost->second >= 0 &&
                                  ghost->first > ghost->second &&
                                  ghost->first < own->lens.n);
    size_t size = 0;
    free(own->svg);
    own->svg = NULL;
    FILE *const f = there ? open_memstream(&own->svg, &size) : NULL;
    const bool whole =
        f && !gp_lens_svg(NULL, f, &own->lens, ghost) && !ferror(f);
    if (f && (fclose(f) != 0 || !whole)) {
        free(own->svg);
        own->svg = NULL;
    }
    (void) gp_api_end(outer, GP_OK);
    return own->svg;
}
