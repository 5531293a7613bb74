/* Discs: the area inside a rectangle, the visible share of a light by the area
 * of each pixel under it, and the bounds of that share. */
#include "sun/occluder.h"

#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>

/* -- area of a disc in a rectangle ----------------------------------------
 *
 * The area is that of the polygon whose corners are where disc and rectangle
 * meet, plus a circle's segment over each of its sides that is a chord. All is
 * done relative to the rectangle's corner, and what is squared is split into
 * whole numbers and fractions of at most 1/2: 1e5 squared has an ulp of 2e-6,
 * but the whole part is exact below 2^53. */

/* Whole part and fraction, |fraction| <= 1/2; exact. */
struct split {
    double whole, rest;
};

static struct split split_number(double v)
{
    const double whole = rint(v);
    return (struct split) {whole, v - whole};
}

struct circle {
    struct split x, y, r;
    double radius;
};

/* A point relative to the rectangle's first corner. */
struct point {
    double x, y;
};

/* The part of an edge that the disc covers: from `a` to `b`, when `some`. */
struct piece {
    struct point a, b;
    bool some;
};

/* |(px, py) - centre|^2 - r^2 for whole px, py. */
static double power(const struct circle *c, double px, double py)
{
    const double m = px - c->x.whole, n = py - c->y.whole;
    const double whole = m * m + n * n - c->r.whole * c->r.whole;
    const double mixed = m * c->x.rest + n * c->y.rest + c->r.whole * c->r.rest;
    const double rest = c->x.rest * c->x.rest + c->y.rest * c->y.rest -
                        c->r.rest * c->r.rest;
    return whole - 2.0 * mixed + rest;
}

/* r - |line - centre|, for a whole line. */
static double depth_of_line(const struct circle *c, struct split centre,
                            double line)
{
    const double m = line - centre.whole;
    return m - centre.rest >= 0.0
               ? (c->r.whole - m) + (c->r.rest + centre.rest)
               : (c->r.whole + m) + (c->r.rest - centre.rest);
}

/* Finds the part [*s, *t] of [0, length] within the disc, on the line that
 * starts at a point of power `g`, `u` along from the centre's foot, and is
 * `depth` inside the circle; false when it is empty. */
static bool clip(const struct circle *c, double g, double u, double depth,
                 double length, double *s, double *t)
{
    *s = *t = 0.0;
    const double square = depth * (2.0 * c->radius - depth);
    if (!(square > 0.0))
        return false;
    // s^2 + 2 u s + g = 0: the root without cancellation, then the other
    const double half = sqrt(square);
    double first, last;
    if (u < 0.0) {
        last = half - u;
        first = g / last;
    } else {
        first = -u - half;
        last = g / first;
    }
    *s = first > 0.0 ? first : 0.0;
    *t = last < length ? last : length;
    return *s < *t;
}

/* t - sin(t): a series (the first nine terms reach 1e-17) where the difference
 * would cancel. */
static double minus_sine(double t)
{
    if (fabs(t) > 1.0)
        return t - sin(t);
    double rest = 1.0;
    for (int k = 18; k >= 4; k -= 2)
        rest = 1.0 - t * t / (double) (k * (k + 1)) * rest;
    return t * t * t / 6.0 * rest;
}

/* Twice the area of a triangle. */
static double cross(struct point o, struct point p, struct point q)
{
    return (p.x - o.x) * (q.y - o.y) - (p.y - o.y) * (q.x - o.x);
}

double gp_disc_rect_area(double cx, double cy, double r, double x0, double y0,
                         double x1, double y1)
{
    if (!(r > 0.0 && x1 > x0 && y1 > y0) || !(cx + r > x0 && cx - r < x1) ||
        !(cy + r > y0 && cy - r < y1))
        return 0.0;
    const struct circle c = {split_number(cx), split_number(cy),
                             split_number(r), r};

    // the pieces of the edges, which run through the corners (x0, y0),
    // (x1, y0), (x1, y1), (x0, y1)
    struct piece edge[4];
    const double w = x1 - x0, h = y1 - y0;
    const double left = x0 - c.x.whole - c.x.rest;
    const double top = y0 - c.y.whole - c.y.rest;
    double s, t;
    edge[0].some = clip(&c, power(&c, x0, y0), left,
                        depth_of_line(&c, c.y, y0), w, &s, &t);
    edge[0].a = (struct point) {s, 0.0};
    edge[0].b = (struct point) {t, 0.0};
    edge[1].some = clip(&c, power(&c, x1, y0), top,
                        depth_of_line(&c, c.x, x1), h, &s, &t);
    edge[1].a = (struct point) {w, s};
    edge[1].b = (struct point) {w, t};
    edge[2].some = clip(&c, power(&c, x1, y1), -(left + w),
                        depth_of_line(&c, c.y, y1), w, &s, &t);
    edge[2].a = (struct point) {w - s, h};
    edge[2].b = (struct point) {w - t, h};
    edge[3].some = clip(&c, power(&c, x0, y1), -(top + h),
                        depth_of_line(&c, c.x, x0), h, &s, &t);
    edge[3].a = (struct point) {0.0, h - s};
    edge[3].b = (struct point) {0.0, h - t};
    int n = 0;
    for (int i = 0; i < 4; i++) {
        if (edge[i].some)
            edge[n++] = edge[i];
    }
    const bool within = cx > x0 && cx < x1 && cy > y0 && cy < y1;
    if (n == 0)
        return within ? M_PI * r * r : 0.0;
    const struct point centre = {(c.x.whole - x0) + c.x.rest,
                                 (c.y.whole - y0) + c.y.rest};

    // polygon and segments of the pieces
    double twice = 0.0, segments = 0.0;
    const struct point first = edge[0].a; // a small disc may be far from 0, 0
    for (int i = 0; i < n; i++) {
        const struct point p = edge[i].b, q = edge[(i + 1) % n].a;
        const double px = p.x - centre.x, py = p.y - centre.y;
        const double dx = q.x - p.x, dy = q.y - p.y;
        // the angle from p to q: from one edge to another it is at most 3/4 of
        // a circle, and a little under 0 is rounding at a corner that lies on
        // the circle
        const double turn = atan2(px * dy - py * dx,
                                  px * (px + dx) + py * (py + dy));
        const double least = n == 1 ? 0.0 : -M_PI_4;
        twice += cross(first, edge[i].a, p) + cross(first, p, q);
        segments += minus_sine(turn < least ? turn + 2.0 * M_PI : turn);
    }
    const double area = 0.5 * (twice + r * r * segments);
    return area > 0.0 ? fmin(area, w * h) : 0.0;
}

double gp_disc_pixel_area(double cx, double cy, double r, int x, int y)
{
    return gp_disc_rect_area(cx, cy, r, x, y, (double) x + 1.0,
                             (double) y + 1.0);
}

/* A disc of no area has no share; one of 1e9 is larger than any frame, and has
 * a finite square. */
static double radius_of(const struct gp_light *l)
{
    return fmin(fmax(l->radius, 1e-3), 1e9);
}

static double area_in(const struct gp_light *l, struct gp_rect rect)
{
    return gp_disc_rect_area(l->x, l->y, radius_of(l), rect.x0, rect.y0,
                             rect.x1, rect.y1);
}

// -- the pixels of a rectangle -----------------------------------------------

/* Areas in square pixels: of the disc; of what is visible of it, at least and
 * at most, which are one for the share itself. */
struct sums {
    double area, low, high;
};

/* Rows go in bands, and the sums of the bands in order: the same bits for any
 * number of threads, and no memory that grows with the frame. */
enum { BANDS = 256, ALONE = 1 << 14 };

struct bands {
    const struct gp_occluders *o;
    const struct gp_light *light;
    double radius;
    void (*add)(const struct bands *b, int y, struct sums *s); // a row
    int most;             // bands
    struct gp_rect rect;  // pixels that the disc may reach
    int n;
    struct sums sum[BANDS];
};

static void add_band(void *ctx, int i, int thread)
{
    (void) thread;
    struct bands *const b = ctx;
    const int64_t h = gp_rect_h(b->rect);
    b->sum[i] = (struct sums) {0};
    for (int64_t k = h * i / b->n; k < h * (i + 1) / b->n; k++)
        b->add(b, (int) (b->rect.y0 + k), &b->sum[i]);
}

/* Adds the pixels of `rect` that the disc touches. */
static void add_rect(struct bands *b, struct gp_rect rect, struct sums *s)
{
    const double x = b->light->x, y = b->light->y, r = b->radius;
    const int x0 = gp_clamp_whole(floor(x - r), rect.x0, rect.x1);
    const int y0 = gp_clamp_whole(floor(y - r), rect.y0, rect.y1);
    struct sums own = {0};
    b->rect = (struct gp_rect) {x0, y0,
                                gp_clamp_whole(ceil(x + r), x0, rect.x1),
                                gp_clamp_whole(ceil(y + r), y0, rect.y1)};
    if (gp_rect_empty(b->rect))
        return;
    const int h = gp_rect_h(b->rect);
    b->n = gp_min(h, b->most);
    if ((int64_t) h * gp_rect_w(b->rect) > ALONE) {
        gp_parallel_do(b->n, add_band, b);
    } else { // waking threads would take longer
        for (int i = 0; i < b->n; i++)
            add_band(b, i, 0);
    }
    for (int i = 0; i < b->n; i++) {
        own.area += b->sum[i].area;
        own.low += b->sum[i].low;
        own.high += b->sum[i].high;
    }
    s->area += own.area;
    s->low += own.low;
    s->high += own.high;
}

/* The part of the frame in which a plane has samples; empty for NULL. */
static struct gp_rect known_rect(const struct gp_plane *p, struct gp_rect frame,
                                 int margin)
{
    if (!p || !p->v)
        return (struct gp_rect) {0};
    struct gp_rect r = gp_rect_meet(p->window, frame);
    if (gp_rect_empty(r))
        return (struct gp_rect) {0};
    r.x0 -= r.x0 > frame.x0 ? margin : 0;
    r.y0 -= r.y0 > frame.y0 ? margin : 0;
    r.x1 += r.x1 < frame.x1 ? margin : 0;
    r.y1 += r.y1 < frame.y1 ? margin : 0;
    return r;
}

/* Divides the pixels of the frame in which a plane has samples, and `margin` (0
 * or 1) more on each side, into rectangles that do not overlap; some may be
 * empty. Returns how many. Only these are visited: a display window may be
 * larger than any plane by any factor. */
enum { RECTS = 5 };
static int known_rects(const struct gp_occluders *o, int margin,
                       struct gp_rect rect[RECTS])
{
    const struct gp_rect depth = known_rect(o->depth, o->frame, margin);
    const struct gp_rect mask = known_rect(o->mask, o->frame, margin);
    const struct gp_rect both = gp_rect_meet(mask, depth);
    const bool apart = gp_rect_empty(both);
    // the mask's window without that of the depth: parts may be empty
    rect[0] = depth;
    rect[1] = apart ? mask
                    : (struct gp_rect) {mask.x0, mask.y0, mask.x1, both.y0};
    rect[2] = (struct gp_rect) {mask.x0, both.y0, both.x0, both.y1};
    rect[3] = (struct gp_rect) {both.x1, both.y0, mask.x1, both.y1};
    rect[4] = (struct gp_rect) {mask.x0, both.y1, mask.x1, mask.y1};
    return apart ? 2 : RECTS;
}

// -- the share ---------------------------------------------------------------

/* Returns half the chord at a distance from the centre; under 0: none. */
static double half_chord(double r, double distance)
{
    return distance < r ? sqrt((r - distance) * (r + distance)) : -1.0;
}

static void add_edge(const struct bands *b, int x0, int x1, int y,
                     struct sums *s)
{
    const struct gp_light *const l = b->light;
    for (int x = x0; x < x1; x++) {
        const double area = gp_disc_pixel_area(l->x, l->y, b->radius, x, y);
        if (area > 0.0) {
            s->area += area;
            s->low += area * gp_occluders_show(b->o, l, x, y, NULL);
        }
    }
}

/* Adds a row: pixels at the disc's edge by their area, those between whole. */
static void add_shown(const struct bands *b, int y, struct sums *s)
{
    const struct gp_light *const l = b->light;
    const struct gp_rect rect = b->rect;
    const double above = l->y - (double) y;
    const double below = (double) y + 1.0 - l->y;
    const double nearest = fmax(fmax(-above, -below), 0.0);
    const double outer = half_chord(b->radius, nearest);
    const double inner = half_chord(b->radius, fmax(above, below));
    if (outer < 0.0)
        return;
    // a pixel more on each side: the chords are rounded
    const int x0 = gp_clamp_whole(floor(l->x - outer) - 1.0, rect.x0, rect.x1);
    const int x1 = gp_clamp_whole(ceil(l->x + outer) + 1.0, x0, rect.x1);
    // (a whole one that add_edge() takes counts the same)
    int in0 = x1, in1 = x1;
    if (inner > 0.0) {
        in0 = gp_clamp_whole(ceil(l->x - inner) + 1.0, x0, x1);
        in1 = gp_clamp_whole(floor(l->x + inner) - 1.0, in0, x1);
    }
    add_edge(b, x0, in0, y, s);
    s->area += (double) in1 - (double) in0;
    s->low += gp_occluders_sum(b->o, l, in0, in1, y);
    add_edge(b, in1, x1, y, s);
}

void gp_sun_exact(const struct gp_occluders *o, enum gp_sun_outside outside,
                  struct gp_light *light, int n)
{
    struct gp_rect rect[RECTS];
    const int rects = known_rects(o, 0, rect);
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        if (l->behind) {
            l->visibility = outside == GP_OUTSIDE_SCENE ? l->outside : 0.0;
            continue;
        }
        struct bands b = {.o = o, .light = l, .radius = radius_of(l),
                          .add = add_shown, .most = BANDS};
        const double disc = M_PI * b.radius * b.radius;
        const double frame = area_in(l, o->frame);
        struct sums s = {0};
        double known_area = 0.0;
        for (int k = 0; k < rects; k++) {
            add_rect(&b, rect[k], &s);
            known_area += area_in(l, rect[k]);
        }
        // two closed forms of one area differ only by rounding: no light
        // shines through that
        const double clear = frame - known_area;
        if (clear > 1e-12 * frame) {
            s.area += clear;
            s.low += clear;
        }
        const double beyond = disc - frame;
        if (outside != GP_OUTSIDE_IGNORE && beyond > 1e-12 * disc) {
            s.area += beyond;
            s.low += outside == GP_OUTSIDE_VISIBLE ? beyond
                     : outside == GP_OUTSIDE_SCENE ? beyond * l->outside : 0.0;
        }
        l->visibility = s.area > 0.0 ? fmin(s.low / s.area, 1.0) : 0.0;
    }
}

// -- bounds of the share -----------------------------------------------------

/* Finds the least and the largest that pixel (x, y) may show. */
static void bounds_of(const struct bands *b, int x, int y, double *lo,
                      double *hi)
{
    const struct gp_occluders *const o = b->o;
    const struct gp_rect f = o->frame;
    const int around = o->mask && !o->depth ? 0 : 1; // coverage has no others
    bool beyond, any = false;
    const double own = gp_occluders_show(o, b->light, x, y, &beyond);
    *lo = *hi = own;
    for (int j = gp_max(y - around, f.y0); j <= gp_min(y + around, f.y1 - 1);
         j++) {
        for (int i = gp_max(x - around, f.x0);
             i <= gp_min(x + around, f.x1 - 1); i++) {
            bool past;
            const double s = gp_occluders_show(o, b->light, i, j, &past);
            *lo = fmin(*lo, s);
            *hi = fmax(*hi, s);
            any = any || past;
        }
    }
    // coverage has its edges in itself, but for those of surfaces beyond the
    // light, which show all of it
    if (o->mask && !beyond) {
        *lo = own;
        *hi = any ? 1.0 : own;
    }
}

static void add_bounds(const struct bands *b, int y, struct sums *s)
{
    const struct gp_light *const l = b->light;
    for (int x = b->rect.x0; x < b->rect.x1; x++) {
        const double dx = fmax(fabs(x - l->x), fabs(x + 1.0 - l->x));
        const double dy = fmax(fabs(y - l->y), fabs(y + 1.0 - l->y));
        const double area =
            dx * dx + dy * dy < b->radius * b->radius
                ? 1.0 : gp_disc_pixel_area(l->x, l->y, b->radius, x, y);
        double lo, hi;
        bounds_of(b, x, y, &lo, &hi);
        // where there is no edge all of them show all, or nothing
        s->area += area;
        s->low += lo >= 1.0 ? area : 0.0;
        s->high += hi > 0.0 ? area : 0.0;
    }
}

void gp_sun_interval(const struct gp_occluders *o, enum gp_sun_outside outside,
                     struct gp_light *light, int n)
{
    // pixels beside the planes' windows and their edges are clear
    struct gp_rect rect[RECTS];
    const int rects = known_rects(o, 1, rect);
    const bool scene = outside == GP_OUTSIDE_SCENE;
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        const double lo = scene ? fmax(l->outside - l->outside_error, 0.0)
                                : 0.0;
        const double hi = scene ? fmin(l->outside + l->outside_error, 1.0)
                                : 1.0;
        struct bands b = {.o = o, .light = l, .radius = radius_of(l),
                          .add = add_bounds, .most = BANDS / 4};
        struct sums s = {0};
        const double disc = M_PI * b.radius * b.radius;
        if (!l->behind) {
            for (int k = 0; k < rects; k++)
                add_rect(&b, rect[k], &s);
            // (rounding lets no light in)
            const double left = area_in(l, o->frame) - s.area;
            const double clear = left > 1e-9 * disc ? left : 0.0;
            s.area += clear;
            s.low += clear;
            s.high += clear;
        }
        l->in_frame = s.area > 0.0;
        const double rest = disc - s.area > 1e-9 * disc ? disc - s.area : 0.0;
        const double all = s.area + rest;
        l->low = fmin((s.low + rest * lo) / all, l->visibility);
        l->high = fmax(fmin((s.high + rest * hi) / all, 1.0), l->visibility);
    }
}
