// SPDX-License-Identifier: Apache-2.0
/* Discs before the eye, the objects that their cones meet, and the share of a
 * disc that these leave clear, by rays. */
#include "scene/eye.h"

#include "core/maths.h"
#include "core/memory.h"
#include "core/parallel.h"

#include <math.h>

enum { FIRST = 64, LAST = 256, LEVELS = 3 }; // rays a side
static const double GOOD = 5e-4; // standard deviation that is small enough

/* Added to angles and, as a share, to distances: rounding loses no object. */
static const double SLACK = 1e-9;

struct gp_eye_disc gp_eye_sun(struct gp_v3 eye, struct gp_v3 to, double half)
{
    return (struct gp_eye_disc) {
        .eye = eye, .to = gp_v3_unit(to),
        .half = half > 0.0 ? fmin(half, M_PI / 2.0) : 0.0, .distance = INFINITY,
    };
}

struct gp_eye_disc gp_eye_lamp(struct gp_v3 eye, struct gp_v3 at, double ball)
{
    const struct gp_v3 way = gp_v3_sub(at, eye);
    const double distance = gp_v3_length(way);
    struct gp_eye_disc d = {
        .eye = eye, .to = gp_v3_unit(way), .distance = distance,
        .ball = fmax(ball, 0.0),
    };
    if (!(distance > 0.0))
        d.to = (struct gp_v3) {0.0, 0.0, 1.0};
    d.half = d.ball < distance ? gp_asin(d.ball / distance) : M_PI / 2.0;
    return d;
}

/* Returns the largest distance from the eye to the disc's surface. */
static double reach(const struct gp_eye_disc *d)
{
    const double square = (d->distance - d->ball) * (d->distance + d->ball);
    return !isfinite(d->distance) ? INFINITY
           : square > 0.0         ? sqrt(square) * (1.0 + SLACK)
                                  : 0.0;
}

/* Returns true for objects of the set E: those whose sphere may meet the cone
 * from the eye over the disc, before a lamp. None that hides a part of the disc
 * is left out; one that is kept may hide nothing. */
static bool meets_sphere(const struct gp_eye_disc *d, const struct gp_object *o)
{
    const struct gp_v3 c = gp_v3_sub(gp_box_middle(&o->box), d->eye);
    const double distance = gp_v3_length(c);
    const double r = o->radius + SLACK * (distance + o->radius);
    if (distance - r > reach(d))
        return false;
    const double angle =
        gp_atan2(gp_v3_length(gp_v3_cross(c, d->to)), gp_v3_dot(c, d->to));
    return distance <= r || angle <= d->half + gp_asin(r / distance) + SLACK;
}

// -- directions ---------------------------------------------------------------

/* A sample's bits. */
enum { SHOWN = 1, INSIDE = 2 };

struct row_sums {
    double outside, clear, all; // weights
};

/* A disc, the axes across it, how its directions are weighed, and rays to it. */
struct samples {
    const struct gp_eye_disc *disc;
    const struct gp_eye_window *window; // NULL: none
    struct gp_v3 across, up;            // unit, upright to disc->to
    bool cut;                           // the window has a part of the disc
                                        // and lacks one
    bool plane;                         // weigh by area in the picture
    struct gp_rays rays;                // through E
    int side;
    uint8_t bits[LAST * LAST];
    struct row_sums row[LAST];
};

/* Returns true when the window shows a unit direction, or is turned and does not. */
static bool inside(const struct samples *m, struct gp_v3 along)
{
    const struct gp_eye_window *const w = m->window;
    const double world[3] = {along.x, along.y, along.z};
    if (!w || gp_rect_empty(w->known))
        return false;
    const struct gp_projected p =
        gp_camera_project(w->camera, w->display, world, 0.0);
    return (!p.behind && p.x >= w->known.x0 && p.x < w->known.x1 &&
            p.y >= w->known.y0 && p.y < w->known.y1) != w->turned;
}

static double along_view(const struct samples *m, struct gp_v3 along)
{
    const double *const c = m->window->camera->to_ndc;
    return gp_v3_dot(along, (struct gp_v3) {c[3], c[7], c[11]});
}

static void set_disc(struct samples *m, const struct gp_eye_disc *d,
                     const struct gp_eye_window *window)
{
    enum { AROUND = 256 }; // directions on the edge that are looked at
    const struct gp_v3 other = fabs(d->to.z) < 0.9
                                   ? (struct gp_v3) {0.0, 0.0, 1.0}
                                   : (struct gp_v3) {1.0, 0.0, 0.0};
    m->disc = d;
    m->window = window;
    m->across = gp_v3_unit(gp_v3_cross(d->to, other));
    m->up = gp_v3_cross(m->across, d->to);
    const bool middle = inside(m, d->to);
    for (int i = 0; window && i < AROUND; i++) {
        const double turn = 2.0 * M_PI * i / AROUND;
        const struct gp_v3 side =
            gp_v3_add(gp_v3_scale(m->across, gp_cos(turn)),
                      gp_v3_scale(m->up, gp_sin(turn)));
        const struct gp_v3 edge = gp_v3_add(gp_v3_scale(d->to, gp_cos(d->half)),
                                            gp_v3_scale(side, gp_sin(d->half)));
        m->cut = m->cut || inside(m, edge) != middle;
    }
    // all of the disc is before the camera
    m->plane =
        m->cut && along_view(m, d->to) > 0.0 &&
        gp_acos(fmin(along_view(m, d->to), 1.0)) + d->half < 0.999 * M_PI / 2;
}

// -- rays ---------------------------------------------------------------------

/* In [0, 1), the same for the same i (Wang's hash of whole numbers). */
static double jitter(uint32_t i)
{
    i = (i ^ 61u) ^ (i >> 16);
    i *= 9u;
    i ^= i >> 4;
    i *= 0x27d4eb2du;
    i ^= i >> 15;
    return (double) i * 0x1p-32;
}

/* Returns the direction of (a, b) in [-1, 1]^2, unit: the concentric map
 * (Shirley and Chiu 1997) to a disc, whose area is that on the sphere when the
 * square of its radius is 1 - cos(angle). */
static struct gp_v3 direction(const struct samples *f, double a, double b)
{
    const double half = gp_sin(0.5 * f->disc->half);
    double radius = a, turn = 0.0;
    if (fabs(a) > fabs(b)) {
        turn = M_PI / 4.0 * (b / a);
    } else if (b != 0.0) {
        radius = b;
        turn = M_PI / 2.0 - M_PI / 4.0 * (a / b);
    }
    const double m = radius * radius * 2.0 * half * half;
    // the sign of the radius is that of the side of the square
    const double s = copysign(sqrt(m * (2.0 - m)), radius);
    return gp_v3_add(gp_v3_scale(f->disc->to, 1.0 - m),
                     gp_v3_add(gp_v3_scale(f->across, s * gp_cos(turn)),
                               gp_v3_scale(f->up, s * gp_sin(turn))));
}

/* Returns the way to the disc along a unit direction. */
static double way_to(const struct gp_eye_disc *d, struct gp_v3 along)
{
    if (!isfinite(d->distance))
        return INFINITY;
    if (d->ball >= d->distance)
        return 0.0; // the eye is in the ball
    const double middle = d->distance * gp_v3_dot(along, d->to);
    const double miss = gp_v3_length(
        gp_v3_cross(along, gp_v3_scale(d->to, d->distance)));
    return middle - sqrt(fmax((d->ball - miss) * (d->ball + miss), 0.0));
}

// -- samples -----------------------------------------------------------------

static void cast_row(void *ctx, int y, int thread)
{
    (void) thread;
    struct samples *const s = ctx;
    struct row_sums sums = {0};
    for (int x = 0; x < s->side; x++) {
        const uint32_t i = (uint32_t) (y * LAST + x) * 2u;
        const double a = ((double) x + jitter(i)) / s->side;
        const double b = ((double) y + jitter(i + 1u)) / s->side;
        const struct gp_v3 along = direction(s, 2.0 * a - 1.0, 2.0 * b - 1.0);
        // area in the picture of a solid angle there, but for a factor
        const double view = s->plane ? along_view(s, along) : 1.0;
        const double weight = 1.0 / (view * view * view);
        uint8_t *const bits = &s->bits[y * s->side + x];
        *bits = inside(s, along) ? INSIDE : SHOWN;
        const struct gp_eye_disc *const d = s->disc;
        if ((*bits & SHOWN) &&
            gp_rays_stopped(&s->rays, d->eye, along, way_to(d, along)))
            *bits = 0;
        sums.all += weight;
        sums.outside += *bits & INSIDE ? 0.0 : weight;
        sums.clear += *bits & SHOWN ? weight : 0.0;
    }
    s->row[y] = sums;
}

/* Returns the cells outside the window whose ray differs from that of a
 * neighbour: the others hold no edge, as far as the samples say. */
static int edge_cells(const struct samples *s, int *outside)
{
    int edges = 0;
    *outside = 0;
    for (int y = 0; y < s->side; y++) {
        for (int x = 0; x < s->side; x++) {
            const uint8_t *const p = &s->bits[y * s->side + x];
            *outside += !(*p & INSIDE);
            edges += (x > 0 && p[-1] != p[0]) ||
                     (x + 1 < s->side && p[1] != p[0]) ||
                     (y > 0 && p[-s->side] != p[0]) ||
                     (y + 1 < s->side && p[s->side] != p[0]);
        }
    }
    return edges;
}

static void cast(struct samples *s, struct gp_eye_share *out)
{
    struct row_sums sum = {0};
    int n;
    gp_parallel_do(s->side, cast_row, s);
    for (int y = 0; y < s->side; y++) {
        sum.all += s->row[y].all;
        sum.outside += s->row[y].outside;
        sum.clear += s->row[y].clear;
    }
    out->part = sum.outside / sum.all;
    out->clear = sum.outside > 0.0 ? fmin(sum.clear / sum.outside, 1.0) : 1.0;
    // a cell's ray is one draw of its share p: p (1 - p) is at most 1/4; where all agree,
    // what is smaller than a cell may be missed: a third of the rule of three
    const double edges = fmax(edge_cells(s, &n), 4.0);
    out->error = n > 0 && s->side > 1 ? 0.5 * sqrt(edges) / n : 0.0;
}

gp_status gp_eye_rays(const struct gp_log *log, const struct gp_scene *s,
                      struct gp_meshes *meshes, const struct gp_eye_disc *d,
                      const struct gp_eye_window *window,
                      struct gp_eye_share *out)
{
    const int levels = d->half > 0.0 ? LEVELS : 1;
    struct samples *level = NULL;
    struct gp_eye_share share = {.clear = 1.0, .part = 1.0};
    int *object = NULL, objects = 0;
    gp_status st;
    GP_TRY(gp_alloc_zero(log, "rays to a light", 1, sizeof *level, &level));
    GP_TRY(gp_alloc(log, "objects before a light", (size_t) s->objects + 1,
                    sizeof *object, &object));
    set_disc(level, d, window);
    const bool whole = !level->cut && inside(level, d->to);
    share.part = whole ? 0.0 : 1.0;
    for (int i = 0; i < s->objects && !whole; i++) {
        object[objects] = i;
        objects += meets_sphere(d, &s->object[i]);
    }
    GP_TRY(gp_rays_make(log, s, meshes, object, objects, &level->rays));
    // without a triangle nothing is before it
    const bool any = level->cut || level->rays.tree.n > 0;
    for (int n = 0; any && n < levels && (n == 0 || share.error > GOOD); n++) {
        level->side = levels > 1 ? FIRST << n : 1;
        cast(level, &share);
    }
    *out = share;
out:
    if (level)
        gp_rays_free(&level->rays);
    gp_free(object);
    gp_free(level);
    return st;
}
