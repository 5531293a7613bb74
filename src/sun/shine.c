// SPDX-License-Identifier: Apache-2.0
/* The light of suns and lamps: their discs' pixels as sources for the engines, and what
 * lights beyond the frame add to it, by true angles or by sprites of the kernel. */
#include "sun/stage.h"

#include "core/colour.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"

#include <math.h>
#include <stdlib.h>

double gp_suns_around(const struct gp_suns *suns)
{
    return suns->wide.kind == GP_LATLONG ? round(2.0 * M_PI / suns->wide.dx)
                                         : 0.0;
}

// -- a light's disc in pixels ------------------------------------------------

/* Weights of the (2m+1) x (2m+1) pixels around a disc's centre pixel, whose
 * sum is 1; one pixel for a radius up to 1/2. */
struct disc {
    int m;
    float *weight; // owned
};

static int disc_reach(double radius)
{
    return radius > 0.5 ? (int) ceil(radius - 0.5) : 0;
}

static gp_status make_disc(const struct gp_log *log, double radius,
                           struct disc *out)
{
    const int m = disc_reach(radius), side = 2 * m + 1;
    const struct gp_light middle = {.x = 0.5, .y = 0.5};
    const double all = M_PI * radius * radius;
    float *weight;
    gp_status st =
        gp_alloc(log, "disc of a light", (size_t) side * (size_t) side,
                 sizeof *weight, &weight);
    if (st)
        return st;
    for (int i = 0; i < side * side; i++)
        weight[i] =
            m == 0 ? 1.0f
                   : (float) (gp_light_pixel_area(&middle, radius, i % side - m,
                                                  i / side - m) /
                              all);
    *out = (struct disc) {m, weight};
    return GP_OK;
}

/* Weight of pixel (x, y) from the centre pixel; 0 outside. */
static double weight_at(const struct disc *d, int x, int y)
{
    const size_t side = 2 * (size_t) d->m + 1;
    if (abs(x) > d->m || abs(y) > d->m)
        return 0.0;
    return (double) d->weight[(size_t) (y + d->m) * side + (size_t) (x + d->m)];
}

/* The share of a light in pixel (left + x, top + y), bilinear; *left and *top are set. */
static double share_at(const struct disc *d, const struct gp_light *l, int x,
                       int y, int *left, int *top)
{
    const double u = floor(l->x - 0.5), v = floor(l->y - 0.5);
    const double fx = l->x - 0.5 - u, fy = l->y - 0.5 - v;
    *left = (int) u;
    *top = (int) v;
    return (1.0 - fy) *
               ((1.0 - fx) * weight_at(d, x, y) + fx * weight_at(d, x - 1, y)) +
           fy * ((1.0 - fx) * weight_at(d, x, y - 1) +
                 fx * weight_at(d, x - 1, y - 1));
}

static bool is_in(struct gp_rect r, int x, int y)
{
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

/* Appends the pixels that a light's disc falls on: those in the frame, or those `beyond`
 * it. */
static void add_disc(const struct disc *d, const struct gp_light *l,
                     struct gp_rect frame, bool beyond, struct gp_source *list,
                     size_t *n)
{
    for (int y = -d->m; y <= d->m + 1; y++) {
        for (int x = -d->m; x <= d->m + 1; x++) {
            int left, top;
            const double w = share_at(d, l, x, y, &left, &top);
            const int px = left + x - frame.x0, py = top + y - frame.y0;
            if (!(w > 0.0) ||
                is_in(frame, px + frame.x0, py + frame.y0) == beyond)
                continue;
            struct gp_source *const e = &list[(*n)++];
            *e = (struct gp_source) {.x = px, .y = py};
            for (int c = 0; c < 3; c++)
                e->rgb[c] = (float) (w * l->visibility * (double) l->flux[c]);
        }
    }
}

/* Half of the angle of a light's cone in a sphere; at least half a row. */
static double cone_of(const struct gp_projection *p, const struct gp_light *l)
{
    const double half = l->sight.known ? l->sight.half : l->radius * p->dy;
    return fmin(fmax(half, 0.5 * p->dy), M_PI);
}

/* Pixels of a wide picture's middle with the solid angle of one at a light's place. */
static double even_of(const struct gp_suns *suns, const struct gp_light *l)
{
    const struct gp_projection *const p = &suns->wide;
    return p->kind ? fmax(gp_projection_solid(p, l->x, l->y) / (p->dx * p->dy),
                          0.01)
                   : 1.0;
}

double gp_suns_pixels(const struct gp_suns *suns, const struct gp_light *l,
                      double *there)
{
    const struct gp_projection *const p = &suns->wide;
    const double even = even_of(suns, l);
    *there = M_PI * fmax(l->radius * l->radius, 0.25);
    if (p->kind == GP_LATLONG) {
        // the cap's solid angle is 4 pi sin^2(half / 2)
        const double chord = 2.0 * gp_sin(0.5 * cone_of(p, l));
        *there = M_PI * chord * chord / (p->dx * p->dy * even);
    }
    return *there * even;
}

/* The rows of a sphere that a light's cone may meet. */
static void cone_rows(const struct gp_projection *p, const struct gp_light *l,
                      int rows[2])
{
    const int reach = (int) ceil(cone_of(p, l) / p->dy) + 1;
    const int row = (int) floor(l->y);
    const double pole = 0.5 * M_PI / p->dy - 1e-6; // from the equator
    rows[0] = gp_max(row - reach, (int) floor(p->y0 - pole));
    rows[1] = gp_min(row + reach + 1, (int) ceil(p->y0 + pole));
}

/* Appends the pixels of a light's cone in a sphere that are in the frame: rows are cut
 * into parts, each of which has it from one longitude to another. */
static void add_cone(const struct gp_projection *p, const struct gp_light *l,
                     struct gp_rect frame, int around, struct gp_source *list,
                     size_t *n)
{
    enum { PARTS = 16 };
    const double cosine = gp_cos(cone_of(p, l)), v = (l->y - p->y0) * p->dy;
    const size_t first = *n;
    double all = 0.0;
    int rows[2];
    cone_rows(p, l, rows);
    for (int y = rows[0]; y < rows[1]; y++) {
        const double even = gp_cos((y + 0.5 - p->y0) * p->dy);
        double wide[PARTS]; // of half of it, pixels; < 0: none
        for (int k = 0; k < PARTS; k++) {
            const double at = (y + (k + 0.5) / PARTS - p->y0) * p->dy;
            const double turn = (cosine - gp_sin(v) * gp_sin(at)) /
                                fmax(gp_cos(v) * gp_cos(at), 1e-12);
            wide[k] = turn < 1.0 ? gp_acos(fmax(turn, -1.0)) / p->dx : -1.0;
        }
        for (int x = frame.x0; x < frame.x0 + around; x++) {
            // the nearest image of the pixel
            const double off = x - l->x;
            const double from = off - around * round((off + 0.5) / around);
            double area = 0.0;
            for (int k = 0; k < PARTS; k++)
                area += fmax(fmin(from + 1.0, wide[k]) - fmax(from, -wide[k]),
                             0.0) /
                        PARTS;
            all += area * even;
            if (!(area > 0.0) || !is_in(frame, x, y))
                continue;
            struct gp_source *const e = &list[(*n)++];
            *e = (struct gp_source) {.x = x - frame.x0, .y = y - frame.y0};
            e->rgb[0] = (float) area;
        }
    }
    for (size_t i = first; i < *n; i++) {
        const double share = (double) list[i].rgb[0] / all * l->visibility;
        for (int c = 0; c < 3; c++)
            list[i].rgb[c] = (float) (share * (double) l->flux[c]);
    }
}

// -- lights for the engines, and for sprites ----------------------------------

bool gp_suns_have_light(const struct gp_suns *suns, bool seen)
{
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (gp_light_has_flux(l) && (!seen || l->visibility > 0.0))
            return true;
    }
    return false;
}

/* A light whose flux is the sum over its disc's pixels in their place. */
static struct gp_light local_light(const struct gp_suns *suns,
                                   const struct gp_light *l)
{
    struct gp_light own = *l;
    for (int c = 0; c < 3; c++)
        own.flux[c] = (float) ((double) l->flux[c] / even_of(suns, l));
    return own;
}

/* Returns true when light l has glare of its own to add. */
static bool glares(const struct gp_suns *suns, const struct gp_light *l)
{
    return gp_light_has_flux(l) && !suns->p->in_frame && !l->found &&
           l->visibility > 0.0;
}

enum { SPRITE_RADIUS = 1024 }; // its picture is 1024 + the kernel's size wide

/* Returns true when all of light l goes through the engines, which have no sources
 * outside the frame: what is outside, of one that has a place, is drawn. */
static bool is_inside(const struct gp_suns *suns, const struct gp_light *l,
                      struct gp_rect data)
{
    const double r = fmax(l->radius, 0.5) + 0.5; // with its bilinear shares
    return suns->wide.kind == GP_LATLONG ||
           (l->x - r >= data.x0 && l->y - r >= data.y0 && l->x + r <= data.x1 &&
            l->y + r <= data.y1);
}

/* Returns true when a part of it does. */
static bool is_partly(const struct gp_suns *suns, const struct gp_light *l,
                      struct gp_rect data)
{
    const double r = l->radius + 1.0;
    return is_inside(suns, l, data) ||
           (l->x + r > data.x0 && l->y + r > data.y0 && l->x - r < data.x1 &&
            l->y - r < data.y1 && l->radius <= SPRITE_RADIUS);
}

/* Pixels of a list that its disc needs. */
static size_t disc_room(const struct gp_suns *suns, const struct gp_light *l)
{
    const size_t around = (size_t) gp_suns_around(suns);
    const size_t side = 2 * (size_t) disc_reach(l->radius) + 2;
    int rows[2];
    if (!around)
        return side * side;
    cone_rows(&suns->wide, l, rows);
    return around * (size_t) gp_max(rows[1] - rows[0], 0);
}

void gp_suns_offsets(const struct gp_suns *suns, struct gp_rect data,
                     int offset[2])
{
    offset[0] = offset[1] = 0;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        const double r = fmax(l->radius, 0.5) + 1.5; // with bilinear shares
        const double x = fmax(fabs(l->x - data.x0), fabs(l->x - data.x1)) + r;
        const double y = fmax(fabs(l->y - data.y0), fabs(l->y - data.y1)) + r;
        if (!glares(suns, l) || is_inside(suns, l, data) ||
            !(x < 1e8 && y < 1e8))
            continue;
        offset[0] = gp_max(offset[0], (int) ceil(x));
        offset[1] = gp_max(offset[1], (int) ceil(y));
    }
}

gp_status gp_suns_join(const struct gp_log *log, const struct gp_suns *suns,
                       const struct gp_image *f, const struct gp_sources *src,
                       struct gp_sources *out)
{
    gp_status st;
    struct gp_source *list = NULL;
    const int around = (int) gp_suns_around(suns);
    size_t n = 0, room = 0;
    for (int i = 0; i < suns->n; i++) {
        if (glares(suns, &suns->light[i]) &&
            is_partly(suns, &suns->light[i], f->data))
            room += disc_room(suns, &suns->light[i]);
    }
    if (!room)
        return GP_OK;
    GP_TRY(gp_alloc(log, "lights", room, sizeof *list, &list));
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        struct disc d;
        if (!glares(suns, l) || !is_partly(suns, l, f->data))
            continue;
        if (around) {
            add_cone(&suns->wide, l, f->data, around, list, &n);
            continue;
        }
        const struct gp_light own = local_light(suns, l);
        GP_TRY(make_disc(log, l->radius, &d));
        add_disc(&d, &own, f->data, false, list, &n);
        gp_free(d.weight);
    }
    GP_TRY(gp_sources_join(log, src, list, n, out));
out:
    gp_free(list);
    return st;
}

// -- sprites: the kernel spread over a light's disc ---------------------------

static void drop_sprite(struct gp_flare *sprite)
{
    for (int k = 0; k < sprite->n; k++)
        gp_planes_free(&sprite->element[k].image.rgb);
    sprite->n = 0;
}

/* A spread kernel as an element; takes its planes. That of a far field is drawn
 * as many times larger as its samples are pixels apart, and its colour gives it
 * back the light that the sum of 1 takes. */
static struct gp_flare_element element_of(const struct gp_spread_kernel *k,
                                          int height)
{
    struct gp_flare_element e = {
        .shape = GP_FLARE_IMAGE,
        .plain = k->step == 1,
        .scale = {1.0f, 1.0f, 1.0f},
        .size = (double) gp_max(k->w, k->h) * k->step / height,
        .image = {.w = k->w, .h = k->h, .cx = k->cx, .cy = k->cy, .rgb = k->k},
    };
    double sum = 0.0;
    for (int c = 0; c < 3; c++) {
        double channel = 0.0;
        for (size_t i = 0; i < (size_t) k->w * (size_t) k->h; i++)
            channel += (double) k->k.c[c][i];
        sum += channel * (double) gp_rec709_luminance[c];
    }
    for (int c = 0; c < 3; c++)
        e.colour[c] = (float) (sum * k->step * k->step);
    return e;
}

/* Makes a light's disc that of what it has beyond the frame, around its whole pixel, to
 * which the light moves. */
static gp_status cut_disc(const struct gp_log *log, struct gp_rect frame,
                          struct gp_light *l, struct disc *d)
{
    const struct disc own = *d;
    const int m = own.m + 1, side = 2 * m + 1;
    int left = 0, top = 0;
    *d = (struct disc) {.m = m};
    gp_status st =
        gp_alloc(log, "disc of a light", (size_t) side * (size_t) side,
                 sizeof *d->weight, &d->weight);
    for (int i = 0; i < side * side && !st; i++) {
        const int x = i % side - m, y = i / side - m;
        const double w = share_at(&own, l, x, y, &left, &top);
        d->weight[i] = is_in(frame, left + x, top + y) ? 0.0f : (float) w;
    }
    gp_free(own.weight);
    l->x = left + 0.5;
    l->y = top + 0.5;
    return st;
}

// -- drawing -----------------------------------------------------------------

/* A kernel's sprite, and the radius of lights that it is for; 0: of none. */
struct sprite {
    struct gp_flare_element element[2];
    struct gp_flare flare;
    double radius;
};

/* Draws what a light has beyond the frame: by a sprite of the kernel's core and one of
 * its far field, which another light of its size takes, too. */
static gp_status draw_sprite(const struct gp_log *log,
                             const struct gp_suns *suns,
                             const struct gp_kernel *kernel,
                             const struct gp_light *light, struct sprite *s,
                             struct gp_image *f)
{
    const bool partly = is_partly(suns, light, f->data);
    struct gp_light l = *light;
    struct disc d = {0};
    gp_status st;
    if (partly || s->radius != l.radius) {
        l.radius = partly ? l.radius : fmax(l.radius, 0.5);
        GP_TRY(make_disc(log, l.radius, &d));
        if (partly)
            GP_TRY(cut_disc(log, f->data, &l, &d));
        s->radius = partly ? 0.0 : light->radius;
        drop_sprite(&s->flare);
        for (int k = 0; k < (kernel->far ? 2 : 1); k++) {
            struct gp_spread_kernel spread = {0};
            GP_TRY((k ? gp_kernel_spread_far
                      : gp_kernel_spread)(log, kernel, d.m, d.weight, &spread));
            s->element[s->flare.n++] =
                element_of(&spread, gp_rect_h(f->display));
        }
    }
    GP_TRY(gp_flare_add(log, &s->flare, &l, 1, f->data, f->display, &f->layer));
out:
    gp_free(d.weight);
    return st;
}

/* The same of light by true angles. */
static gp_status draw_sky(const struct gp_log *log, const struct gp_suns *suns,
                          const struct gp_kernel *kernel,
                          const struct gp_light *l, struct gp_image *f)
{
    struct disc d = {0};
    struct gp_source *list = NULL;
    size_t n = 0;
    gp_status st;
    GP_TRY(gp_alloc(log, "lights", disc_room(suns, l), sizeof *list, &list));
    GP_TRY(make_disc(log, l->radius, &d));
    add_disc(&d, l, f->data, true, list, &n);
    st = gp_kernel_add_beyond(log, kernel, list, n, gp_image_w(f),
                              gp_image_h(f), &f->layer);
out:
    gp_free(list);
    gp_free(d.weight);
    return st;
}

gp_status gp_suns_draw(const struct gp_log *log, struct gp_suns *suns,
                       const struct gp_kernel *kernel, struct gp_image *f)
{
    struct sprite s = {0};
    gp_status st = GP_OK;
    s.flare.element = s.element;
    for (int i = 0; i < suns->n; i++) {
        const struct gp_light *const l = &suns->light[i];
        if (!glares(suns, l) || is_inside(suns, l, f->data))
            continue;
        if (l->radius > SPRITE_RADIUS)
            GP_TRY(gp_fail_bare_at(
                log, GP_ERR_DATA, "lights.in_frame",
                "a light of radius %g pixels is too large for glare of its own "
                "at the frame's edge (the limit is %d); leave its flux out",
                l->radius, SPRITE_RADIUS));
        const struct gp_light own = local_light(suns, l);
        if (kernel->sky)
            GP_TRY(draw_sky(log, suns, kernel, &own, f));
        if (!kernel->sky || kernel->w > 1 || kernel->h > 1) // else in its pixel
            GP_TRY(draw_sprite(log, suns, kernel, &own, &s, f));
    }
out:
    drop_sprite(&s.flare);
    return st;
}
