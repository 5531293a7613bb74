/* Ghosts of a real lens: of the lights that have flux, or of the brightest
 * sources. */
#include "api/plan.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "sun/lens_lights.h"

#include <math.h>
#include <string.h>

/* Focuses the lens by the plan, else by the frame's focus and aperture, where the
 * lens can do as they say. */
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

/* Returns the width of the display window on the sensor in mm: the plan's, by
 * the angle of view, the frame's, or of the format that the lens is for. */
static double sensor_width(struct glarepp_frame *f, const struct gp_lens *lens)
{
    const double w = gp_rect_w(f->image.display) *
                     (double) f->image.pixel_aspect;
    const double h = gp_rect_h(f->image.display);
    const char **const from = &f->facts.lens.sensor_from;
    const double fov = gp_api_camera_fov(f);
    struct gp_lens_figures figures;
    *from = "option";
    if (f->plan->lens_params.sensor > 0.0)
        return f->plan->lens_params.sensor;
    gp_lens_measure(lens, &figures);
    if (fov > 0.0) {
        *from = "angle";
        return 2.0 * figures.focal * tan(fov * acos(-1.0) / 360.0) * w / h;
    }
    if (f->p.sensor > 0.0 && f->p.sensor <= 1e4) {
        *from = "attribute";
        return f->p.sensor;
    }
    *from = lens->claims_height > 0.0 ? "lens" : "default";
    return lens->claims_height > 0.0
               ? 2.0 * lens->claims_height * w / hypot(w, h)
               : 36.0; // of 35 mm film
}

bool gp_api_lens_stop(struct glarepp_frame *f, struct gp_api_stop *out)
{
    const struct gp_image *const image = &f->image;
    struct gp_lens_figures figures;
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
        .fov = 360.0 / acos(-1.0) * atan(0.5 * height / figures.focal),
        .blades = lens.blades, .turn = lens.turn,
    };
    return true;
}

static void note_lens(struct glarepp_lens_facts *facts,
                      const struct gp_lens_stats *s)
{
    facts->lights = s->lights;
    facts->ghosts = s->ghosts;
    facts->drawn = s->drawn;
    facts->left_out = s->left_out;
    facts->lost = s->lost;
    facts->dark = s->dark;
    facts->missing = s->missing;
    memcpy(facts->light, s->light, sizeof facts->light);
    memcpy(facts->steps, s->steps, sizeof facts->steps);
}

/* Adds ghosts of the lens to image.layer, which is made. */
static gp_status draw(struct glarepp_frame *f, enum gp_lens_detail detail)
{
    struct gp_image *const image = &f->image;
    struct glarepp_lens_facts *const facts = &f->facts.lens;
    const struct gp_suns none = {0};
    const struct gp_suns *const suns =
        f->work->lights ? &f->work->lights->suns : &none;
    struct gp_lens_light *light = NULL;
    struct gp_lens_stats stats = {0};
    struct gp_lens lens;
    double dark[3] = {0}, sum[3], squares;
    gp_status st;
    int n = 0;
    GP_TRY(gp_lens_lights(&f->log, suns->light, suns->n, &f->sources, &light,
                          &n, &facts->rest, dark));
    GP_TRY(focus(f, &f->log, &lens));
    const double width = sensor_width(f, &lens);
    const double mm = width / gp_rect_w(image->display);
    const struct gp_lens_view view = {
        .frame = image->data, .display = image->display,
        .mm = {mm, mm / (double) image->pixel_aspect},
        .chromaticities = image->chromaticities,
        .luminance = image->luminance,
        .mean = gp_log_average(image, &image->rgb),
        .tolerance = detail == GP_LENS_REFERENCE
                         ? 0.0 : (double) f->plan->glare.tolerance,
        .rest = {dark[0], dark[1], dark[2]},
        .detail = detail,
    };
    facts->name = f->plan->lens.name;
    facts->sensor = width;
    stats.lights = n;
    if (n) {
        GP_TRY(gp_lens_draw(&f->log, &lens, &view, light, n, &image->layer,
                            &stats));
        // all ghosts are light: the exact layer is no less than one without some
        gp_planes_sum(&image->layer, gp_image_pixels(image), sum, &squares);
        facts->bound =
            stats.missing > 0.0 ? stats.missing / sqrt(squares) : 0.0;
    }
    note_lens(facts, &stats);
out:
    gp_free(light);
    return st;
}

gp_status gp_api_lens(struct glarepp_frame *f)
{
    enum { FEW = 8 }; // hidden lights count: nothing changes as they appear
    const int n = f->work->lights ? f->work->lights->suns.n : 0;
    const int asked = f->plan->lens_params.detail;
    const gp_status st = f->image.layer.c[0] ? GP_OK : gp_api_dark_layer(f);
    return st ? st
              : draw(f, asked ? (enum gp_lens_detail) (asked - 1)
                        : n > 0 && n <= FEW ? GP_LENS_FINE : GP_LENS_COARSE);
}
