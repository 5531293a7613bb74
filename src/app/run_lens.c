/* Ghosts of a real lens (--lens): of the lights that have flux, or of the
 * brightest sources. */
#include "app/stages.h"

#include "core/colour.h"
#include "core/luminance.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "io/plane.h"

#include <math.h>
#include <stdlib.h>

gp_status gp_run_lens_begin(const struct gp_log *log, struct gp_run *r)
{
    struct gp_lens lens;
    if (!r->s->lens.name)
        return GP_OK;
    const gp_status st = gp_lens_read(log, r->s->lens.name, &r->lens);
    if (st)
        return st;
    // settings that no frame could meet; attributes are each frame's own
    lens = r->lens;
    const double distance = (double) r->s->lens.distance;
    return gp_lens_focus(log, &lens, distance > 0.0 ? 1e3 * distance : INFINITY,
                         (double) r->s->lens.f_number);
}

/* Focuses the lens by the options, else by the frame's attributes `focus` (m)
 * and `aperture` (ImfStandardAttributes.h), where the lens can do as they
 * say. */
static gp_status focus(const struct gp_run *r, const struct gp_frame_state *fs,
                       const struct gp_log *log, struct gp_lens *lens)
{
    const struct gp_lens_settings *const p = &r->s->lens;
    double distance = INFINITY, f_number = (double) p->f_number, v;
    *lens = r->lens;
    if (p->distance > 0.0f)
        distance = 1e3 * (double) p->distance;
    else if (gp_frame_real(&fs->frame, "focus", &v) && v > 0.0)
        distance = 1e3 * v;
    if (!(f_number > 0.0) && gp_frame_real(&fs->frame, "aperture", &v) &&
        v > 0.0)
        f_number = v;
    if (gp_lens_focus(NULL, lens, distance, f_number) == GP_OK)
        return GP_OK;
    *lens = r->lens;
    if (p->f_number <= 0.0f) // an f-number that is not of this lens
        f_number = 0.0;
    if (p->distance <= 0.0f) // nor a distance
        distance = INFINITY;
    return gp_lens_focus(log, lens, distance, f_number);
}

/* Width of the display window on the sensor in mm: --sensor-size, the angle of
 * view, the attribute `sensorOverallDimensions` (mm, OpenEXR 3.2), or the
 * format that the lens is for. */
static double sensor_width(const struct gp_run *r, struct gp_frame_state *fs,
                           const struct gp_lens *lens)
{
    const struct gp_frame *const f = &fs->frame;
    const double w = gp_rect_w(f->display) * (double) f->pixel_aspect;
    const double h = gp_rect_h(f->display);
    struct gp_lens_figures figures;
    const double fov = gp_run_fov(r, fs);
    double size[2];
    fs->facts.lens.sensor_from = "option";
    if (r->s->lens.sensor > 0.0f)
        return (double) r->s->lens.sensor;
    gp_lens_measure(lens, &figures);
    if (fov > 0.0) {
        fs->facts.lens.sensor_from = "angle";
        return 2.0 * figures.focal * tan(fov * acos(-1.0) / 360.0) * w / h;
    }
    if (gp_frame_pair(f, "sensorOverallDimensions", size) && size[0] > 0.0 &&
        size[0] <= 1e4) {
        fs->facts.lens.sensor_from = "attribute";
        return size[0];
    }
    fs->facts.lens.sensor_from = lens->claims_height > 0.0 ? "lens" : "default";
    return lens->claims_height > 0.0
               ? 2.0 * lens->claims_height * w / hypot(w, h)
               : 36.0; // of 35 mm film
}

bool gp_run_lens_stop(const struct gp_run *r, struct gp_frame_state *fs,
                      struct gp_lens_stop *out)
{
    const struct gp_frame *const f = &fs->frame;
    struct gp_lens_figures figures;
    struct gp_lens lens;
    if (!r->s->lens.name || focus(r, fs, NULL, &lens))
        return false;
    gp_lens_measure(&lens, &figures);
    const double height = sensor_width(r, fs, &lens) * gp_rect_h(f->display) /
                          (gp_rect_w(f->display) * (double) f->pixel_aspect);
    // in digits that a report can do with
    *out = (struct gp_lens_stop) {
        .focal = round(1e3 * figures.focal) / 1e3,
        .f_number = round(1e3 * figures.f_number) / 1e3,
        .fov = 360.0 / acos(-1.0) * atan(0.5 * height / figures.focal),
        .blades = lens.blades, .turn = lens.turn,
    };
    return true;
}

// -- lights -------------------------------------------------------------------

/* Groups of sources: blocks of the frame, of which the brightest are lights. */
enum { BLOCK = 16, GROUPS = 100 };

struct group {
    struct gp_lens_light light; // place: sum of places by luminance
    double luminance;
    int index;
};

static int by_light(const void *a, const void *b)
{
    const struct group *const x = a, *const y = b;
    return x->luminance != y->luminance ? (x->luminance > y->luminance ? -1 : 1)
                                        : x->index - y->index;
}

/* Makes lights of the brightest blocks of sources; *rest is the share of the
 * light that has none, and dark[] its flux. */
static gp_status group_sources(const struct gp_log *log,
    const struct gp_sources *s, struct gp_lens_light *out, int *n, double *rest,
    double dark[3])
{
    const int across = (s->w + BLOCK - 1) / BLOCK;
    const int down = (s->h + BLOCK - 1) / BLOCK;
    struct group *group;
    double all = 0.0, taken = 0.0;
    const gp_status st = gp_alloc_zero(log, "groups of sources",
        (size_t) across * (size_t) down, sizeof *group, &group);
    if (st)
        return st;
    for (int y = 0; y < s->h; y++) {
        for (uint32_t i = s->row[y]; i < s->row[y + 1]; i++) {
            const int at = y / BLOCK * across + s->x[i] / BLOCK;
            struct group *const g = &group[at];
            const double rgb[3] = {(double) s->rgb[0][i],
                                   (double) s->rgb[1][i],
                                   (double) s->rgb[2][i]};
            const double light = gp_luminance_of(s->luminance, rgb);
            for (int c = 0; c < 3; c++)
                g->light.flux[c] += rgb[c];
            g->light.x += light * (s->x0 + s->x[i] + 0.5);
            g->light.y += light * (s->y0 + y + 0.5);
            g->luminance += light;
            g->index = at;
            all += light;
        }
    }
    qsort(group, (size_t) across * (size_t) down, sizeof *group, by_light);
    *n = 0;
    for (int i = 0; i < across * down; i++) {
        if (!(group[i].luminance > 0.0))
            break;
        if (*n == GROUPS) {
            for (int c = 0; c < 3; c++)
                dark[c] += group[i].light.flux[c];
            continue;
        }
        out[*n] = group[i].light;
        out[*n].x /= group[i].luminance;
        out[*n].y /= group[i].luminance;
        taken += group[i].luminance;
        ++*n;
    }
    *rest = all > 0.0 ? fmax(1.0 - taken / all, 0.0) : 0.0;
    gp_free(group);
    return GP_OK;
}

// -- the layer ----------------------------------------------------------------

gp_status gp_run_lens(struct gp_run *r, struct gp_frame_state *fs,
                      enum gp_lens_detail detail)
{
    struct gp_frame *const f = &fs->frame;
    struct gp_lens_facts *const facts = &fs->facts.lens;
    struct gp_lens_light *light = NULL;
    struct gp_lens lens;
    double dark[3] = {0}, sum[3], squares;
    gp_status st;
    int n = 0;
    GP_TRY(gp_alloc_zero(fs->log, "lights",
                         (size_t) gp_max(r->suns.n, GROUPS), sizeof *light,
                         &light));
    for (int i = 0; i < r->suns.n; i++) {
        const struct gp_light *const l = &r->suns.light[i];
        if (!gp_light_has_flux(l) || !(l->visibility > 0.0))
            continue;
        light[n] = (struct gp_lens_light) {.x = l->x, .y = l->y};
        for (int c = 0; c < 3; c++)
            light[n].flux[c] = l->visibility * (double) l->flux[c];
        n++;
    }
    if (r->suns.n == 0 && fs->sources.n)
        GP_TRY(group_sources(fs->log, &fs->sources, light, &n, &facts->rest,
                             dark));
    GP_TRY(focus(r, fs, fs->log, &lens));
    const double width = sensor_width(r, fs, &lens);
    const double mm = width / gp_rect_w(f->display);
    const struct gp_lens_view view = {
        .frame = f->data, .display = f->display,
        .mm = {mm, mm / (double) f->pixel_aspect},
        .chromaticities = f->chromaticities, .luminance = f->luminance,
        .mean = gp_log_average(f, &f->rgb),
        .tolerance = detail == GP_LENS_REFERENCE
                         ? 0.0 : (double) r->s->glare.tolerance,
        .rest = {dark[0], dark[1], dark[2]},
        .detail = detail,
    };
    facts->name = r->lens.name;
    facts->sensor = width;
    facts->stats.lights = n;
    if (!n)
        goto out;
    GP_TRY(gp_lens_draw(fs->log, &lens, &view, light, n, &f->layer,
                        &facts->stats));
    // all ghosts are light: the exact layer is no less than one without some
    gp_planes_sum(&f->layer, gp_frame_pixels(f), sum, &squares);
    facts->bound = facts->stats.missing > 0.0
                       ? facts->stats.missing / sqrt(squares) : 0.0;
out:
    gp_free(light);
    return st;
}
