// SPDX-License-Identifier: Apache-2.0
#include "glare/veil.h"

#include "core/luminance.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "glare/model/model.h"

#include <glarepp.h>
#include <math.h>
#include <string.h>

static const double FIXATED = 0.5; // degrees from the middle of the fixated one
static const double OVER_MEAN = 5.0; // a glare source is this times the mean
static const double JOINED = 0.1;    // chord at which two of them are one
static const double CELL = 0.05;     // ... by cells of this side
enum { SIDE = 41, CELLS = SIDE * SIDE * SIDE };

/* Sums over pixels, by solid angle; of the picture, or of a cell of its sources. */
struct sums {
    double solid, seen; // and times cos t
    double light, eye;  // L W and L W cos t
    double veil;
    double near, near_light; // of the fixated degree
    struct gp_v3 to;         // W times direction
};

struct pass {
    const struct gp_veil_params *p;
    const struct gp_image *f;
    struct gp_rect window; // whose pixels show each direction once
    struct gp_v3 axis;
    double wide;      // degrees of a pixel
    struct sums *row; // of each of the window's
};

static void add(struct sums *to, const struct sums *s)
{
    to->solid += s->solid;
    to->seen += s->seen;
    to->light += s->light;
    to->eye += s->eye;
    to->veil += s->veil;
    to->near += s->near;
    to->near_light += s->near_light;
    to->to = gp_v3_add(to->to, s->to);
}

/* Finds the pixels [span[0], span[1]) of a row that show anything. */
static void find_span(const struct pass *s, int y, int span[2])
{
    gp_projection_span(&s->p->projection, s->window.x0 + 0.5, y + 0.5,
                       gp_rect_w(s->window), span);
    span[0] += s->window.x0;
    span[1] += s->window.x0;
}

static double luminance_at(const struct pass *s, int x, int y)
{
    const struct gp_image *const f = s->f;
    const size_t i = (size_t) (y - f->data.y0) * (size_t) gp_image_w(f) +
                     (size_t) (x - f->data.x0);
    return s->p->white * (double) gp_lit_luminance(f->luminance, f->rgb.c[0][i],
                                                   f->rgb.c[1][i],
                                                   f->rgb.c[2][i]);
}

/* Returns the sums of pixels at one place: none where it is behind the eye. */
static struct sums look_at(const struct pass *s, double x, double y,
                           double luminance, double pixels)
{
    const struct gp_projection *const to = &s->p->projection;
    const struct gp_v3 d = gp_projection_direction(to, x, y);
    const double cosine = fmin(gp_v3_dot(d, s->axis), 1.0);
    if (!(cosine > 0.0))
        return (struct sums) {0};
    const double solid = pixels * gp_projection_solid(to, x, y);
    const double light = luminance * solid;
    const double t = gp_acos(cosine) * (180.0 / M_PI);
    struct sums one = {.solid = solid,
                       .seen = solid * cosine,
                       .light = light,
                       .eye = light * cosine,
                       .to = gp_v3_scale(d, solid)};
    if (t < FIXATED) {
        one.near = solid;
        one.near_light = light;
    } else {
        one.veil = one.eye * gp_cie_general(s->p->age, s->p->pigment, t);
    }
    return one;
}

/* Returns how many parts a side what is `wide` degrees, and seen whole in `one`, has: one
 * where it is far from the place that the eye looks at, over its size. */
static int parts_of(const struct sums *one, double wide)
{
    const double MOST = 256.0, FINE = 0.05; // of the angle
    if (!(one->solid > 0.0))                // behind the eye
        return 1;
    const double t =
        gp_acos(fmin(one->seen / one->solid, 1.0)) * (180.0 / M_PI);
    return t >= fmax(4.0 * wide, FIXATED + wide)
               ? 1
               : (int) fmin(ceil(wide / (FINE * fmax(t - wide, FIXATED))),
                            MOST);
}

/* Returns the sums of a box of pixels, or a disc, around a place, by parts where it is near
 * to the place that the eye looks at: of a disc by the golden angle. */
static struct sums look_at_all(const struct pass *s, const double at[2],
                               const double half[2], double light, bool disc)
{
    const double pixels = (disc ? M_PI : 4.0) * half[0] * half[1];
    const struct sums whole = look_at(s, at[0], at[1], light, pixels);
    const int n = parts_of(&whole, 2.0 * fmax(half[0], half[1]) * s->wide);
    struct sums sum = {0};
    for (int k = 0; k < n * n && n > 1; k++) {
        const double r = sqrt((k + 0.5) / (n * n)), turn = k * 2.399963;
        const double u = disc ? r * gp_cos(turn) : (2 * (k % n) + 1.0) / n - 1;
        const double v = disc ? r * gp_sin(turn) : (2 * (k / n) + 1.0) / n - 1;
        const struct sums part =
            look_at(s, at[0] + u * half[0], at[1] + v * half[1], light,
                    pixels / (n * n));
        add(&sum, &part);
    }
    return n > 1 ? sum : whole;
}

static struct sums look_at_pixel(const struct pass *s, int x, int y)
{
    return look_at_all(s, (const double[]) {x + 0.5, y + 0.5},
                       (const double[]) {0.5, 0.5}, luminance_at(s, x, y),
                       false);
}

static struct sums look_at_lamp(const struct pass *s, int i)
{
    const struct gp_veil_lamp *const l = &s->p->lamp[i];
    return look_at_all(s, l->at, l->half, s->p->white * l->luminance, true);
}

static void sum_row(void *ctx, int i, GP_UNUSED int thread)
{
    const struct pass *const s = ctx;
    int span[2];
    find_span(s, s->window.y0 + i, span);
    for (int x = span[0]; x < span[1]; x++) {
        const struct sums one = look_at_pixel(s, x, s->window.y0 + i);
        add(&s->row[i], &one);
    }
}

// -- glare sources ------------------------------------------------------------

/* Returns Guth's position index of a direction, below the line of sight Iwata's. */
static double position_index(struct gp_v3 axis, struct gp_v3 d)
{
    const struct gp_v3 top = {0.0, -1.0, 0.0};
    const struct gp_v3 up =
        gp_v3_unit(gp_v3_sub(top, gp_v3_scale(axis, gp_v3_dot(top, axis))));
    const double ahead = gp_v3_dot(d, axis), above = gp_v3_dot(d, up);
    const double beside = gp_v3_dot(d, gp_v3_cross(axis, up));
    const double off = gp_hypot(above, beside);
    if (above < 0.0) {
        const double r = fmin(off / ahead, 3.0);
        return 1.0 + (r > 0.6 ? 1.2 : 0.8) * r;
    }
    const double sigma = gp_atan2(off, ahead) * (180.0 / M_PI);
    const double tau = gp_atan2(fabs(beside), above) * (180.0 / M_PI);
    const double a = 35.2 - 0.31889 * tau - 1.22 * gp_exp(-2.0 * tau / 9.0);
    const double b = 21.0 + 0.26667 * tau - 0.002963 * tau * tau;
    return fmin(gp_exp(a * 1e-3 * sigma + b * 1e-5 * sigma * sigma), 16.0);
}

static int cell_of(struct gp_v3 d)
{
    const double v[3] = {d.x, d.y, d.z};
    int at = 0;
    for (int k = 0; k < 3; k++)
        at = SIDE * at + (int) fmin(fmax((v[k] + 1.0) / CELL, 0.0), SIDE - 1);
    return at;
}

static void add_to_cell(const struct sums *one, struct sums *cell)
{
    if (one->solid > 0.0)
        add(&cell[cell_of(gp_v3_scale(one->to, 1.0 / one->solid))], one);
}

/* Adds pixels and lamps over a luminance to cells, one after another. */
static void fill_cells(const struct pass *s, double over, struct sums *cell)
{
    for (int y = s->window.y0; y < s->window.y1; y++) {
        int span[2];
        find_span(s, y, span);
        for (int x = span[0]; x < span[1]; x++) {
            if (!(luminance_at(s, x, y) > over))
                continue;
            const struct sums one = look_at_pixel(s, x, y);
            add_to_cell(&one, cell);
        }
    }
    for (int i = 0; i < s->p->lamps; i++) {
        const struct sums one = look_at_lamp(s, i);
        if (one.light > over * one.solid)
            add_to_cell(&one, cell);
    }
}

static bool is_joined(const struct sums *a, const struct sums *b)
{
    return gp_v3_length(gp_v3_sub(gp_v3_unit(a->to), gp_v3_unit(b->to))) <=
           JOINED;
}

/* Finds the sources: their number, their sums together, and sum L^2 W / P^2. */
static int find_sources(const struct pass *s, struct sums *cell,
                        struct sums *all, double *glare)
{
    int n = 0, count = 0;
    for (int i = 0; i < CELLS; i++) {
        if (cell[i].solid > 0.0)
            cell[n++] = cell[i];
    }
    *glare = 0.0;
    for (int first = 0, end; first < n; first = end, count++) {
        struct sums one = {0};
        end = first + 1;
        for (int i = first; i < end;
             i++) { // takes those next to it from the rest
            for (int j = end; j < n; j++) {
                const struct sums own = cell[j];
                if (!is_joined(&cell[i], &own))
                    continue;
                cell[j] = cell[end];
                cell[end++] = own;
            }
            add(&one, &cell[i]);
        }
        const double p = position_index(s->axis, gp_v3_unit(one.to));
        *glare += one.light * one.light / (one.solid * p * p);
        add(all, &one);
    }
    return count;
}

// -- all of it ------------------------------------------------------------------

/* Tests whether the direction of a place is shown there, and is not another's. */
static bool has_direction(const struct gp_projection *p, const double at[2])
{
    double back[2];
    return gp_projection_place(p, gp_projection_direction(p, at[0], at[1]),
                               back) &&
           gp_hypot(back[0] - at[0], back[1] - at[1]) < 1e-3;
}

static double log10_of(double x)
{
    return gp_log(x) / M_LN10;
}

/* Writes UGR and DGP, of which there are none without a source and without light. */
static void rate(double eye, double sources, double glare,
                 struct glarepp_facts *out)
{
    const double background = (eye - sources) / M_PI;
    out->veil.rated = true;
    out->veil.ugr = glare > 0.0 && background > 0.0
                        ? 8.0 * log10_of(0.25 * glare / background)
                        : -INFINITY;
    out->veil.dgp =
        eye > 0.0 ? fmin(5.87e-5 * eye + 0.16 +
                             0.0918 * log10_of(1.0 + glare / gp_pow(eye, 1.87)),
                         1.0)
                  : NAN;
}

gp_status gp_veil_measure(const struct gp_log *log,
                          const struct gp_veil_params *p,
                          const struct gp_image *f, struct glarepp_facts *out)
{
    static const double ENOUGH = 0.95; // of the half space, for UGR and DGP
    const bool sphere = p->projection.kind == GP_LATLONG;
    struct pass s = {
        .p = p,
        .f = f,
        .window = sphere ? gp_rect_meet(f->data, f->display) : f->data,
        .axis = gp_projection_direction(&p->projection, p->at[0], p->at[1]),
        .wide = fmax(p->projection.dx, p->projection.dy) * (180.0 / M_PI),
    };
    const int rows = gp_rect_h(s.window);
    struct sums all = {0}, source = {0}, *cell = NULL;
    double glare = 0.0;
    gp_status st;
    if (!has_direction(&p->projection, p->at)) {
        memset(&out->veil, 0, sizeof out->veil);
        out->veil.missing = "the place that the eye looks at has no direction";
        return GP_OK;
    }
    GP_TRY(
        gp_alloc_zero(log, "veil", (size_t) rows + 1, sizeof *s.row, &s.row));
    GP_TRY(gp_alloc_zero(log, "veil", CELLS, sizeof *cell, &cell));
    gp_parallel_do(rows, sum_row, &s);
    for (int i = 0; i < rows; i++)
        add(&all, &s.row[i]);
    for (int i = 0; i < p->lamps; i++) { // the pixels have the solid angle
        const struct sums one = look_at_lamp(&s, i);
        all.light += one.light;
        all.eye += one.eye;
        all.veil += one.veil;
        all.near_light += one.near_light;
    }
    out->veil.seen = all.seen / M_PI;
    out->veil.illuminance = all.eye;
    out->veil.luminance = all.veil;
    out->veil.fixated = all.near_light / all.near;
    out->veil.source_threshold =
        all.solid > 0.0 ? OVER_MEAN * all.light / all.solid : 0.0;
    fill_cells(&s, out->veil.source_threshold, cell);
    out->veil.sources = find_sources(&s, cell, &source, &glare);
    out->veil.luminance_of_sources = source.veil;
    const double b = out->veil.fixated;
    out->veil.threshold_increment =
        b > 5.0   ? 95.0 * source.veil / gp_pow(b, 1.05)
        : b > 0.0 ? 65.0 * source.veil / gp_pow(b, 0.8)
                  : NAN;
    if (p->projection.kind != GP_PERSPECTIVE && out->veil.seen > ENOUGH)
        rate(all.eye, source.eye, glare, out);
out:
    gp_free(cell);
    gp_free(s.row);
    return st;
}
