// SPDX-License-Identifier: Apache-2.0
#include "scene/relight_priv.h"

#include "core/depth.h"
#include "core/maths.h"
#include "core/memory.h"
#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>

/* A surface that a pixel shows, and the ray to it. */
struct surface {
    struct gp_v3 normal; // unit, to the eye's side
    struct gp_v3 place;
    double z;
    double albedo[3]; // in units of the colours
};

/* A light's pass. */
struct lamp {
    const struct relit *of;
    const struct gp_relight_pass *pass;
    struct gp_rect cut;      // in the data
    struct gp_rays rays;     // casters
    struct glarepp_relit *row; // of cut
    unsigned char *mark;     // of its pixels
};

/* The picture, and the lamps that light it. */
struct relit {
    const struct gp_surfaces *f;
    struct gp_rays shown;    // what the eye may see
    struct gp_colours colours;
    struct gp_shade *shade;  // every `step` pixels of the data
    int step, across;        // shades of a row
    double place[GP_PLACES][2]; // of a pixel, from its middle
    struct gp_v3 eye;
    struct gp_v3 axis;       // of the view, unit
    struct gp_v3 way[3];     // to (0, 0), and a pixel further right and down
    struct gp_v3 camera[3];  // x, y and z of the camera in the world
    struct lamp lamp[GP_RELIGHT_PASSES];
    int lamps;
};

double gp_surface_sample(const struct gp_plane *p, int x, int y)
{
    const struct gp_rect w = p->window;
    if (!p->v || x < w.x0 || x >= w.x1 || y < w.y0 || y >= w.y1)
        return 0.0;
    return (double) p->v[(size_t) (y - w.y0) * (size_t) gp_rect_w(w) +
                         (size_t) (x - w.x0)];
}

double gp_surface_depth(const struct gp_surfaces *f, int x, int y)
{
    const double z = gp_surface_sample(f->z, x, y);
    return z > 0.0 && z < (double) GP_DEPTH_HUGE ? z : 0.0;
}

/* Returns the way from the eye to a place of the picture, 1 long along the view
 * axis. */
static struct gp_v3 way_to(const struct relit *w, double x, double y)
{
    return gp_v3_add(w->way[0], gp_v3_add(gp_v3_scale(w->way[1], x),
                                          gp_v3_scale(w->way[2], y)));
}

/* Reads normal and albedo of a pixel, as they are in the frame; false where the
 * normal has no direction or nothing takes light. Returns the normal's length
 * in *length. */
static bool read_pixel(const struct relit *w, int x, int y, struct surface *s,
                       double *length)
{
    const struct gp_surfaces *const f = w->f;
    double n[3], most = 0.0;
    for (int c = 0; c < 3; c++) {
        const double a = gp_surface_sample(&f->albedo[c], x, y);
        s->albedo[c] = a > 0.0 && isfinite(a) ? a / w->colours.unit : 0.0;
        most = fmax(most, s->albedo[c]);
        n[c] = gp_surface_sample(&f->normal[c], x, y);
    }
    s->normal = (struct gp_v3) {n[0], n[1], n[2]};
    if (f->normal_of_camera)
        s->normal = gp_v3_add(gp_v3_scale(w->camera[0], n[0]),
                              gp_v3_add(gp_v3_scale(w->camera[1], n[1]),
                                        gp_v3_scale(w->camera[2], n[2])));
    *length = gp_v3_length(s->normal);
    s->z = gp_surface_depth(f, x, y);
    if (!(most > 0.0) || !(*length > 1e-6) || !isfinite(*length))
        return false;
    s->normal = gp_v3_scale(s->normal, 1.0 / *length);
    const struct gp_v3 way = way_to(w, x + 0.5, y + 0.5);
    s->place = gp_v3_add(w->eye, gp_v3_scale(way, s->z));
    return true;
}

/* Returns the distance along the view axis at which a surface's plane is seen
 * at a place of the picture; 0: never. */
static double plane_at(const struct relit *w, const struct surface *s,
                       struct gp_v3 way)
{
    const double slope = gp_v3_dot(s->normal, way);
    const double z = slope != 0.0 ? gp_v3_dot(s->normal, gp_v3_sub(s->place,
                                                       w->eye)) / slope : 0.0;
    return z > 0.0 ? z : 0.0;
}

/* True where a surface's plane goes on in another's. */
static bool goes_on(const struct relit *w, const struct surface *a,
                    const struct surface *b)
{
    const struct gp_v3 way = gp_v3_scale(gp_v3_sub(b->place, w->eye),
                                         1.0 / b->z);
    return gp_v3_dot(a->normal, b->normal) > 0.9 &&
           fabs(plane_at(w, a, way) - b->z) < 0.02 * b->z;
}

/* Reads a pixel that shows one surface only: its normal was not shortened. */
static bool read_pure(const struct relit *w, int x, int y, struct surface *s)
{
    double length;
    return read_pixel(w, x, y, s, &length) && s->z > 0.0 && length > 0.995;
}

/* True where a pixel may show more than its own surface. */
static bool is_mixed(const struct relit *w, const struct surface *own,
                     double length, int x, int y)
{
    if (length < 0.995)
        return true;
    for (int dy = -1; dy <= 1; dy++) {
        for (int dx = -1; dx <= 1; dx++) {
            const double z = gp_surface_depth(w->f, x + dx, y + dy);
            const struct gp_v3 way = way_to(w, x + dx + 0.5, y + dy + 0.5);
            if (fabs(plane_at(w, own, way) - z) > 0.02 * own->z)
                return true;
        }
    }
    return false;
}

// -- pixels that show two surfaces --------------------------------------------
//
// Colour, normal and albedo are means over a pixel; depth is one sample of it.
// The light of a mean normal at that one place would be wrong along each edge.
// So a pixel there is taken apart: its mean is a mix of two surfaces beside it,
// each with the light that it has itself.

enum { BESIDE = 2, SIDE = 2 * BESIDE + 1 }; // pixels that are searched

/* Returns albedo and normal of a place in `out`, 0 where it has no surface. */
static void means_of(const struct surface *s, double out[GP_MEANS])
{
    const bool any = s->z > 0.0;
    for (int c = 0; c < 3; c++)
        out[c] = any ? s->albedo[c] : 0.0;
    out[3] = any ? s->normal.x : 0.0;
    out[4] = any ? s->normal.y : 0.0;
    out[5] = any ? s->normal.z : 0.0;
}

/* The surfaces of a pixel: found once for all lights. */
struct pixel {
    int x, y, n;           // n: of[], 0 to 2
    struct surface own;    // as it is in the frame
    double mean[GP_MEANS]; // of the pixel: its normal may be shortened
    struct surface of[2];
    double share[2];
    bool edge;             // it may show others than its own
    bool looked, placed;   // find_places() was called; its result
    struct surface at[GP_PLACES];
    double weight[GP_PLACES];
};

/* Returns the share t of `a` in the mean of a pixel, a t + b (1 - t), nearest
 * by albedo and normal, and the square of what is left. b NULL: no surface. */
static double share_of(const double mean[GP_MEANS], const struct surface *a,
                       const struct surface *b, double *left)
{
    double u[GP_MEANS], v[GP_MEANS] = {0}, up = 0.0, down = 0.0;
    means_of(a, u);
    if (b)
        means_of(b, v);
    for (int i = 0; i < GP_MEANS; i++) {
        up += (mean[i] - v[i]) * (u[i] - v[i]);
        down += (u[i] - v[i]) * (u[i] - v[i]);
    }
    // alike: three quarters of such pixels are of the surface at their middle
    const double t = down > 1e-3 ? fmin(fmax(up / down, 0.0), 1.0) : 0.75;
    *left = 0.0;
    for (int i = 0; i < GP_MEANS; i++) {
        const double d = mean[i] - v[i] - t * (u[i] - v[i]);
        *left += d * d;
    }
    return t;
}

/* Sets the pixel's first surface, that of its sample of depth: a pure one that
 * goes on to there, else its own. */
static void find_first(const struct relit *w, struct pixel *p)
{
    const struct gp_v3 way = way_to(w, p->x + 0.5, p->y + 0.5);
    double nearest = INFINITY;
    struct surface near;
    p->of[0] = p->own;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int dx = i % SIDE - BESIDE, dy = i / SIDE - BESIDE;
        if (dx * dx + dy * dy >= nearest ||
            !read_pure(w, p->x + dx, p->y + dy, &near) ||
            fabs(plane_at(w, &near, way) - p->own.z) > 0.01 * p->own.z)
            continue;
        nearest = dx * dx + dy * dy;
        p->of[0] = near;
        p->of[0].z = p->own.z;
        p->of[0].place = p->own.place;
    }
}

/* Sets the pixel's other surface, the one beside it that leaves least of its
 * mean, and the shares of both. A pixel without a sample of depth has no
 * first one. */
static void find_second(const struct relit *w, struct pixel *p)
{
    const struct gp_v3 way = way_to(w, p->x + 0.5, p->y + 0.5);
    const bool has_own = p->own.z > 0.0;
    struct surface near, *const best = &p->of[1];
    double least = INFINITY;
    p->n = has_own;
    for (int i = 0; i < SIDE * SIDE; i++) {
        const int dx = i % SIDE - BESIDE, dy = i / SIDE - BESIDE;
        const bool empty = gp_surface_depth(w->f, p->x + dx, p->y + dy) == 0.0;
        double left, t; // t: share of the surface that the pixel has for sure
        if (empty ? !has_own
                  : !read_pure(w, p->x + dx, p->y + dy, &near) ||
                        (has_own && goes_on(w, &p->of[0], &near)))
            continue;
        t = share_of(p->mean, has_own ? &p->of[0] : &near,
                     has_own && !empty ? &near : NULL, &left);
        left += 1e-6 * (dx * dx + dy * dy); // of like ones the nearest
        if (left >= least)
            continue;
        least = left;
        p->n = empty ? 1 : 2;
        p->share[0] = has_own ? t : 0.0;
        p->share[1] = has_own ? 1.0 - t : t;
        *best = near;
    }
    // where its plane is seen here
    const double z = p->n == 2 ? plane_at(w, best, way) : 0.0;
    if (z > 0.8 * best->z && z < 1.25 * best->z) {
        best->z = z;
        best->place = gp_v3_add(w->eye, gp_v3_scale(way, z));
    }
}

static void find_surfaces(const struct relit *w, struct pixel *p)
{
    double length;
    p->n = 0;
    p->looked = p->edge = false;
    if (!read_pixel(w, p->x, p->y, &p->own, &length))
        return;
    p->n = 1;
    p->of[0] = p->own;
    p->share[0] = 1.0;
    p->edge = !(p->own.z > 0.0) || is_mixed(w, &p->own, length, p->x, p->y);
    if (!p->edge)
        return;
    struct surface mean = p->own;
    mean.normal = gp_v3_scale(mean.normal, length);
    mean.z = 1.0;
    means_of(&mean, p->mean);
    if (p->own.z > 0.0)
        find_first(w, p);
    find_second(w, p);
}

/* Returns the light that falls on a surface by the formula, without shadows. */
static double light_at(const struct gp_scene_light *l, const struct surface *s)
{
    if (l->kind == GP_LIGHT_DIRECTIONAL)
        return l->intensity * fmax(-gp_v3_dot(l->along, s->normal), 0.0);
    const struct gp_v3 to = gp_v3_sub(l->at, s->place);
    const double d2 = gp_v3_dot(to, to), d = sqrt(d2);
    const double cosine = gp_v3_dot(to, s->normal) / d;
    if (!(cosine > 0.0) || !(d2 > 0.0))
        return 0.0;
    const double far = d2 / (l->range * l->range);
    double light = l->intensity * cosine / d2;
    light *= fmax(1.0 - far * far, 0.0);
    return light * gp_spot_share(l, gp_v3_scale(to, -1.0 / d));
}

/* True where a light's range and cone hold a place. */
static bool reaches(const struct gp_scene_light *l, struct gp_v3 place)
{
    if (l->kind == GP_LIGHT_DIRECTIONAL)
        return true;
    const struct gp_v3 from = gp_v3_sub(place, l->at);
    const double d = gp_v3_length(from);
    return d < l->range && (l->kind != GP_LIGHT_SPOT ||
                            gp_v3_dot(from, l->along) > d * gp_cos(l->outer));
}

// -- a light's pass -----------------------------------------------------------

static struct gp_v3 way_to_place(const struct relit *w, int x, int y, int i)
{
    return way_to(w, x + 0.5 + w->place[i][0], y + 0.5 + w->place[i][1]);
}

/* True where nothing is between a surface and the light. */
static bool is_free(const struct lamp *lamp, const struct surface *s)
{
    const struct gp_scene_light *const l = lamp->pass->light;
    const bool sun = l->kind == GP_LIGHT_DIRECTIONAL;
    // a float of depth is right to 1e-7; normals of curved meshes are not those
    // of their triangles
    const struct gp_v3 p =
        gp_v3_add(s->place, gp_v3_scale(s->normal, 2e-4 * s->z));
    const struct gp_v3 to = sun ? gp_v3_scale(l->along, -1.0)
                                : gp_v3_sub(l->at, p);
    return !gp_rays_stopped(&lamp->rays, p, to, sun ? INFINITY : 1.0);
}

/* Returns the part of a pixel's surface that the light reaches. */
static double clear_share(const struct lamp *lamp, const struct surface *s,
                          int x, int y, struct glarepp_relit *facts)
{
    const struct relit *const w = lamp->of;
    struct surface at = *s;
    double clear = 0.0;
    facts->rays += GP_PLACES;
    for (int i = 0; i < GP_PLACES; i++) {
        const struct gp_v3 way = way_to_place(w, x, y, i);
        at.z = plane_at(w, s, way);
        // a surface that is seen along its plane is not followed there
        if (!(at.z > 0.8 * s->z && at.z < 1.25 * s->z))
            at.z = s->z;
        at.place = gp_v3_add(w->eye, gp_v3_scale(way, at.z));
        clear += is_free(lamp, &at) ? 1.0 / GP_PLACES : 0.0;
    }
    return clear;
}

/* Scales the albedo of places so that their mix is the pixel's, as far as it
 * may be that of these surfaces. */
static void scale_places(const double own[3], const double weight[GP_PLACES],
                         struct surface of[GP_PLACES])
{
    static const double MOST = 4.0;
    for (int c = 0; c < 3; c++) {
        double mix = 0.0;
        for (int i = 0; i < GP_PLACES; i++)
            mix += of[i].z > 0.0 ? weight[i] * of[i].albedo[c] : 0.0;
        if (!(mix > 0.0))
            continue;
        const double scale = fmin(fmax(own[c] / mix, 1.0 / MOST), MOST);
        for (int i = 0; i < GP_PLACES; i++)
            of[i].albedo[c] *= scale;
    }
}

/* Finds the scene's surfaces at the places of a pixel, and their weights. False
 * where these are not those of the frame: their means differ. */
static bool find_places(const struct relit *w, struct pixel *p)
{
    const struct gp_colours *const k = &w->colours;
    struct surface *const of = p->at;
    double one[GP_PLACES][GP_MEANS], left = 0.0;
    for (int i = 0; i < GP_PLACES; i++) {
        const struct gp_v3 way = way_to_place(w, p->x, p->y, i);
        struct gp_rays_hit hit;
        of[i].z = 0.0;
        if (gp_rays_first(&w->shown, w->eye, way, INFINITY, &hit)) {
            const double turn = gp_v3_dot(hit.normal, way) > 0.0 ? -1.0 : 1.0;
            of[i].z = hit.at;
            of[i].place = gp_v3_add(w->eye, gp_v3_scale(way, hit.at));
            of[i].normal = gp_v3_scale(hit.normal, turn);
            for (int c = 0; c < 3; c++)
                of[i].albedo[c] = k->many[hit.material]
                                      ? p->own.albedo[c]
                                      : k->of[hit.material][c] / k->unit;
        }
        means_of(&of[i], one[i]);
    }
    for (int j = 0; j < GP_MEANS; j++) {
        double mean = 0.0;
        for (int i = 0; i < GP_PLACES; i++)
            mean += 1.0 / GP_PLACES * one[i][j];
        left += (mean - p->mean[j]) * (mean - p->mean[j]);
    }
    if (left > 0.1)
        return false;
    gp_places_weigh((const double(*)[GP_MEANS]) one, p->mean, p->weight);
    scale_places(p->own.albedo, p->weight, of);
    return true;
}

/* Sets the shades of a row: pixels inside a surface, and its material. */
static void shade_row(void *ctx, int i, int thread)
{
    const struct relit *const w = ctx;
    const int y = w->f->data.y0 + i * w->step;
    (void) thread;
    for (int k = 0; k < w->across; k++) {
        struct gp_shade *const shade =
            &w->shade[(size_t) i * (size_t) w->across + (size_t) k];
        const int x = w->f->data.x0 + k * w->step;
        struct surface s;
        struct gp_rays_hit hit;
        *shade = (struct gp_shade) {.material = -1};
        if (!read_pure(w, x, y, &s) || is_mixed(w, &s, 1.0, x, y))
            continue;
        for (int c = 0; c < 3; c++)
            shade->albedo[c] = (float) s.albedo[c];
        if (gp_rays_first(&w->shown, w->eye, way_to(w, x + 0.5, y + 0.5),
                          INFINITY, &hit) &&
            fabs(hit.at - s.z) < 0.01 * s.z &&
            fabs(gp_v3_dot(hit.normal, s.normal)) > 0.9)
            shade->material = hit.material;
    }
}

static gp_status find_colours(const struct gp_log *log, struct relit *w)
{
    enum { SIDE = 256 }; // shades, of the longer side
    gp_status st = GP_OK;
    w->colours.unit = 1.0;
    if (gp_rect_empty(w->f->data))
        return GP_OK;
    const int wide = gp_rect_w(w->f->data), high = gp_rect_h(w->f->data);
    w->step = gp_max(2, gp_max(wide, high) / SIDE);
    w->across = (wide - 1) / w->step + 1;
    const int rows = (high - 1) / w->step + 1;
    const size_t n = (size_t) rows * (size_t) w->across;
    GP_TRY(gp_alloc(log, "shades", n, sizeof *w->shade, &w->shade));
    gp_parallel_do(rows, shade_row, w);
    GP_TRY(gp_colours_make(log, w->shown.scene, w->shade, n, &w->colours));
out:
    return st;
}

static void light_places(const struct lamp *lamp,
                         const struct surface of[GP_PLACES],
                         const double weight[GP_PLACES], double add[3],
                         struct glarepp_relit *facts)
{
    const struct gp_relight_pass *const pass = lamp->pass;
    for (int i = 0; i < GP_PLACES; i++) {
        double light = of[i].z > 0.0 ? light_at(pass->light, &of[i]) : 0.0;
        if (!(light > 0.0) || !(weight[i] > 0.0))
            continue;
        facts->rays++;
        if (!is_free(lamp, &of[i]))
            continue;
        light *= weight[i] * pass->light_scale / M_PI;
        for (int c = 0; c < 3; c++)
            add[c] += light * pass->light->color[c] * of[i].albedo[c];
    }
}

enum { DARK = 1, LIT = 2 }; // of a pixel's middle; 0: nothing to light

/* Marks pixels of a row whose middle is in light and those in shadow. */
static void mark_row(void *ctx, int i, int thread)
{
    const struct lamp *const lamp = ctx;
    const struct gp_rect cut = lamp->cut;
    const int y = cut.y0 + i, n = gp_rect_w(cut);
    unsigned char *const mark = lamp->mark + (size_t) i * (size_t) n;
    (void) thread;
    for (int x = 0; x < n; x++) {
        struct surface s;
        double length;
        mark[x] = 0;
        if (!read_pixel(lamp->of, cut.x0 + x, y, &s, &length) ||
            !(s.z > 0.0) || !(light_at(lamp->pass->light, &s) > 0.0))
            continue;
        lamp->row[i].rays++;
        mark[x] = is_free(lamp, &s) ? LIT : DARK;
    }
}

static void light_surfaces(const struct lamp *lamp, const struct pixel *p,
                           int next, double add[3], struct glarepp_relit *facts)
{
    const struct gp_relight_pass *const pass = lamp->pass;
    for (int k = 0; k < p->n; k++) {
        const struct surface *const s = &p->of[k];
        double light = p->share[k] * light_at(pass->light, s);
        if (!(light > 0.0) || s->z < pass->near || s->z > pass->far)
            continue;
        if (p->edge || next != 1 << LIT)
            light *= clear_share(lamp, s, p->x, p->y, facts);
        for (int c = 0; c < 3; c++)
            add[c] += pass->light_scale * light / M_PI * pass->light->color[c] *
                      s->albedo[c];
    }
}

static void light_pixel(const struct lamp *lamp, struct pixel *p)
{
    const struct relit *const w = lamp->of;
    struct glarepp_relit *const facts = &lamp->row[p->y - lamp->cut.y0];
    const struct gp_rect cut = lamp->cut;
    const struct gp_rect around = {p->x - 1, p->y - 1, p->x + 2, p->y + 2};
    const struct gp_rect r = gp_rect_meet(cut, around);
    int next = 0; // marks of the pixel and of those around it, as bits
    for (int y = r.y0; y < r.y1; y++) {
        for (int x = r.x0; x < r.x1; x++)
            next |=
                1
                << lamp->mark[(size_t) (y - cut.y0) * (size_t) gp_rect_w(cut) +
                              (size_t) (x - cut.x0)];
    }
    double add[3] = {0};
    bool reached = false;
    for (int k = 0; k < p->n; k++)
        reached = reached || reaches(lamp->pass->light, p->of[k].place);
    if (!reached || (!p->edge && !(next & 1 << LIT)))
        return;
    if (p->edge && !p->looked) {
        p->placed = find_places(w, p);
        p->looked = true;
    }
    if (p->edge && p->placed)
        light_places(lamp, p->at, p->weight, add, facts);
    else
        light_surfaces(lamp, p, next, add, facts);
    if (!(fmax(add[0], fmax(add[1], add[2])) > 0.0))
        return;
    const size_t at = (size_t) (p->y - w->f->data.y0) *
                          (size_t) gp_rect_w(w->f->data) +
                      (size_t) (p->x - w->f->data.x0);
    facts->pixels++;
    for (int c = 0; c < 3; c++)
        w->f->rgb->c[c][at] += (float) (add[c] * w->colours.unit);
}

static void light_row(void *ctx, int i, int thread)
{
    const struct relit *const w = ctx;
    struct pixel p = {.y = w->f->data.y0 + i};
    (void) thread;
    for (p.x = w->f->data.x0; p.x < w->f->data.x1; p.x++) {
        bool found = false;
        for (int k = 0; k < w->lamps; k++) {
            const struct gp_rect cut = w->lamp[k].cut;
            if (p.x < cut.x0 || p.x >= cut.x1 || p.y < cut.y0 || p.y >= cut.y1)
                continue;
            if (!found)
                find_surfaces(w, &p);
            found = true;
            if (p.n > 0)
                light_pixel(&w->lamp[k], &p);
        }
    }
}

/* Sets the axes of the picture in the world, as programs differ in to_camera, and
 * the ways to its places: at unit distance along the axis they are even. */
static void set_view(struct relit *w)
{
    const double *const ndc = w->f->camera.to_ndc;
    const struct gp_rect d = w->f->display;
    const double at[3][2] = {{d.x0, d.y0}, {d.x1, d.y0}, {d.x0, d.y1}};
    struct gp_v3 way[3];
    w->axis = gp_column(ndc, 3);
    for (int c = 0; c < 2; c++) { // a lens shift is along the view
        const struct gp_v3 side = gp_column(ndc, c);
        const double along = gp_v3_dot(side, w->axis);
        w->camera[c] = gp_v3_scale(gp_v3_unit(gp_v3_sub(side,
            gp_v3_scale(w->axis, along))), c ? -1.0 : 1.0);
    }
    w->camera[2] = gp_v3_scale(w->axis, -1.0);
    for (int i = 0; i < 3; i++) {
        const struct gp_v3 ray = gp_camera_ray(&w->f->camera, d, at[i][0],
                                               at[i][1]);
        way[i] = gp_v3_scale(ray, 1.0 / gp_v3_dot(ray, w->axis));
    }
    w->way[1] = gp_v3_scale(gp_v3_sub(way[1], way[0]), 1.0 / gp_rect_w(d));
    w->way[2] = gp_v3_scale(gp_v3_sub(way[2], way[0]), 1.0 / gp_rect_h(d));
    w->way[0] = gp_v3_sub(way[0],
                          gp_v3_add(gp_v3_scale(w->way[1], d.x0),
                                    gp_v3_scale(w->way[2], d.y0)));
}

gp_status gp_relight(const struct gp_log *log, const struct gp_scene *s,
    struct gp_meshes *meshes, const struct gp_surfaces *f,
    const struct gp_relight_pass *pass, int passes,
    struct glarepp_relit *out)
{
    struct relit w = {
        .f = f, .eye = gp_camera_eye(&f->camera), .lamps = passes,
    };
    gp_status st;
    set_view(&w);
    gp_places_set(w.place);
    GP_TRY(gp_rays_make(log, s, meshes, f->object, f->objects, &w.shown));
    GP_TRY(find_colours(log, &w));
    for (int k = 0; k < passes; k++) {
        struct lamp *const lamp = &w.lamp[k];
        lamp->of = &w;
        lamp->pass = &pass[k];
        lamp->cut = gp_rect_meet(pass[k].cut, f->data);
        const int rows = gp_rect_h(lamp->cut);
        GP_TRY(gp_alloc_zero(log, "lit rows", (size_t) rows + 1,
                             sizeof *lamp->row, &lamp->row));
        GP_TRY(gp_alloc(log, "lit pixels", gp_rect_pixels(lamp->cut) + 1, 1,
                        &lamp->mark));
        GP_TRY(gp_rays_make(log, s, meshes, pass[k].caster, pass[k].casters,
                            &lamp->rays));
        gp_parallel_do(rows, mark_row, lamp);
    }
    gp_parallel_do(gp_rect_h(f->data), light_row, &w);
    for (int k = 0; k < passes; k++) {
        out[k].pixels = out[k].rays = 0;
        for (int i = 0; i < gp_rect_h(w.lamp[k].cut); i++) {
            out[k].pixels += w.lamp[k].row[i].pixels;
            out[k].rays += w.lamp[k].row[i].rays;
        }
    }
out:
    for (int k = 0; k < passes; k++) {
        gp_rays_free(&w.lamp[k].rays);
        gp_free(w.lamp[k].mark);
        gp_free(w.lamp[k].row);
    }
    gp_colours_free(&w.colours);
    gp_free(w.shade);
    gp_rays_free(&w.shown);
    return st;
}
