// SPDX-License-Identifier: Apache-2.0
/* Depth and coverage: finds the samples that are surfaces, the kinds of samples
 * that a plane holds, and the visible share of a light by the area of each pixel
 * under it, with its bounds. */
#include "sun/occluder.h"

#include "core/cpu.h"
#include "core/maths.h"
#include "core/minmax.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// -- pixels ------------------------------------------------------------------

/* The sample of a pixel; NULL outside of the plane's window. */
static const float *sample_at(const struct gp_plane *p, int x, int y)
{
    const struct gp_rect w = p->window;
    if (x < w.x0 || x >= w.x1 || y < w.y0 || y >= w.y1)
        return NULL;
    return p->v + (size_t) ((int64_t) y - w.y0) * (size_t) gp_rect_w(w) +
           (size_t) ((int64_t) x - w.x0);
}

static bool has(const struct gp_plane *p)
{
    return p && p->v;
}

struct gp_sun_pixel gp_occluders_at(const struct gp_occluders *o, int x, int y)
{
    struct gp_sun_pixel p = {INFINITY, 0.0f};
    const float *const z = has(o->depth) ? sample_at(o->depth, x, y) : NULL;
    if (z && gp_is_surface(o->surfaces, *z)) {
        p.place = gp_surface_place(o->type, o->reversed, *z);
        p.cover = 1.0f;
    }
    if (has(o->mask)) {
        const float *const m = sample_at(o->mask, x, y);
        p.cover = m ? gp_clamp01(*m) : 0.0f; // of NaN 0
    }
    return p;
}

double gp_occluders_show(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y, bool *beyond)
{
    // surfaces at a place under it hide the light
    const double limit =
        isinf(l->depth) ? l->depth : l->depth * (1.0 - l->bias);
    if (beyond)
        *beyond = false;
    if (o->deep)
        return gp_deep_clear(o->deep, x, y, limit);
    const struct gp_sun_pixel p = gp_occluders_at(o, x, y);
    const bool past = !isinf(p.place) && !(p.place < limit);
    if (beyond)
        *beyond = past;
    return past ? 1.0 : 1.0 - (double) p.cover;
}

// -- the kinds of samples ----------------------------------------------------

/* Kinds that a sample may be of, as bits. */
enum {
    ZERO = 1, NOT_A_NUMBER = 2, INFINITE = 4, HUGE_ONE = 8, HALF_MAX = 16,
    NEGATIVE = 32, ONE = 64,
    FORE = 128, BACK = 256, // surfaces as they are, and reversed
    OVER = 512,             // more than 1, +Inf too
    TINY = 1024,            // over 0, and too little for a surface
};

GP_CLONES static int kinds_of(const float *v, size_t n, struct gp_depth_range f,
                              struct gp_depth_range b)
{
    int are = 0;
    for (size_t i = 0; i < n; i++) {
        // no bool and no branch: the compiler makes vectors of it
        const float x = v[i], size = fabsf(x);
        are |= (x == 0.0f ? ZERO : 0) | (x != x ? NOT_A_NUMBER : 0) |
               (size == INFINITY ? INFINITE : 0) |
               (((size >= GP_DEPTH_HUGE) & (size < INFINITY)) ? HUGE_ONE : 0) |
               (size == GP_DEPTH_HALF ? HALF_MAX : 0) |
               (((x < 0.0f) & (size < GP_DEPTH_HUGE) & (size != GP_DEPTH_HALF))
                    ? NEGATIVE : 0) |
               (x == 1.0f ? ONE : 0) | (x > 1.0f ? OVER : 0) |
               (((x > 0.0f) & (x < f.lo)) ? TINY : 0) |
               (((x >= f.lo) & (x <= f.hi) & (x != f.hole)) ? FORE : 0) |
               (((x >= b.lo) & (x <= b.hi) & (x != b.hole)) ? BACK : 0);
    }
    return are;
}

/* From the least to the most of the huge samples. */
GP_CLONES static void span_huge(const float *v, size_t n, float *lo, float *hi)
{
    float low = INFINITY, high = -INFINITY;
    for (size_t i = 0; i < n; i++) {
        const bool is = fabsf(v[i]) >= GP_DEPTH_HUGE && fabsf(v[i]) < INFINITY;
        low = gp_minf(is ? v[i] : INFINITY, low);
        high = gp_maxf(is ? v[i] : -INFINITY, high);
    }
    *lo = low;
    *hi = high;
}

void gp_occluders_count(struct gp_occluders *o)
{
    o->reversed = false;
    strcpy(o->empty, "none");
    if (!has(o->depth) || gp_rect_empty(o->depth->window))
        return;
    const size_t n = (size_t) gp_rect_w(o->depth->window) *
                     (size_t) gp_rect_h(o->depth->window);
    const struct gp_depth_range fore = gp_depth_range_of(o->type, false);
    const struct gp_depth_range back = gp_depth_range_of(o->type, true);
    const int are = kinds_of(o->depth->v, n, fore, back);
    const bool normalized = o->type == GLAREPP_NORMALIZED;
    const bool axis = o->type == GLAREPP_Z || o->type == GLAREPP_RAY;
    if (normalized)
        o->reversed = !(are & (ONE | OVER)) && are & ZERO;
    else if (axis)
        o->reversed = !(are & FORE) && are & BACK;
    o->surfaces = o->reversed ? back : fore;

    // the kinds of empty samples that occur
    char huge[32]; // one, or from the least to the most
    float lo = 0.0f, hi = 0.0f;
    if (are & HUGE_ONE)
        span_huge(o->depth->v, n, &lo, &hi);
    snprintf(huge, sizeof huge, lo == hi ? "%g" : "%g to %g", (double) lo,
             (double) hi);
    const bool first = !normalized || o->reversed; // 0 and less is empty
    const struct {
        int is;
        const char *text;
    } kind[] = {
        {first ? ZERO : 0, "0"},
        {TINY, "under 1e-09"},
        {first && !(axis && o->reversed) ? NEGATIVE : 0, "negative"},
        {normalized ? ONE : 0, "1"},
        {normalized ? OVER : 0, "over 1"},
        {axis ? HALF_MAX : 0, o->reversed ? "-65504" : "65504"},
        {axis ? HUGE_ONE : 0, huge},
        {axis ? INFINITE : 0, "inf"},
        {NOT_A_NUMBER, "nan"},
    };
    size_t used = 0;
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        if (are & kind[i].is && used < sizeof o->empty)
            used += (size_t) snprintf(o->empty + used, sizeof o->empty - used,
                                      "%s%s", used ? ", " : "", kind[i].text);
    }
}

// -- area of a disc in a rectangle --------------------------------------------

struct point {
    double x, y; // from the disc's centre
};

static double dot(struct point p, struct point q)
{
    return p.x * q.x + p.y * q.y;
}

/* Adds twice the disc's signed area in the triangle of its centre and an edge:
 * a sector up to the circle, a triangle within, and a sector from the circle.
 * Returns true when a part of the edge is within. */
static bool add_edge(double r, struct point a, struct point b, double *twice)
{
    const double length = fabs(b.x - a.x) + fabs(b.y - a.y); // along an axis
    const struct point d = {(b.x - a.x) / length, (b.y - a.y) / length};
    const double away = a.x * d.y - a.y * d.x, along = dot(a, d);
    const double half =
        fabs(away) < r ? sqrt((r - fabs(away)) * (r + fabs(away))) : 0.0;
    const double s = fmax(-along - half, 0.0), t = fmin(half - along, length);
    const bool some = s < t;
    const struct point p = some ? (struct point) {a.x + s * d.x, a.y + s * d.y}
                                : b;
    const struct point q = {a.x + t * d.x, a.y + t * d.y};
    // products of large numbers would cancel: angles go by the way on the edge
    *twice += r * r * gp_atan2((some ? s : length) * away, dot(a, p));
    if (some)
        *twice +=
            away * (t - s) + r * r * gp_atan2((length - t) * away, dot(q, b));
    return some;
}

/* Area of the disc of radius r around (cx, cy) within [x0, x1) x [y0, y1),
 * integers, in closed form; 0 for r <= 0, NaN, and empty rectangles. It is
 * right to 1e-15 r in square pixels. */
static double area_in(double cx, double cy, double r, double x0, double y0,
                      double x1, double y1)
{
    const double left = x0 - cx, right = x1 - cx, top = y0 - cy, end = y1 - cy;
    const double w = x1 - x0, h = y1 - y0;
    const double far_x = gp_maxd(-left, right), far_y = gp_maxd(-top, end);
    // how far the rectangle is from the centre; 0 where it holds it
    const double near_x = gp_maxd(gp_maxd(left, -right), 0.0);
    const double near_y = gp_maxd(gp_maxd(top, -end), 0.0);
    const struct point corner[4] = {
        {left, top}, {right, top}, {right, end}, {left, end}};
    double twice = 0.0;
    bool cut = false;
    if (!(r > 0.0 && w > 0.0 && h > 0.0) ||
        !(near_x * near_x + near_y * near_y < r * r) || isnan(cx + cy))
        return 0.0;
    if (far_x * far_x + far_y * far_y <= r * r)
        return w * h;
    for (int i = 0; i < 4; i++)
        cut |= add_edge(r, corner[i], corner[(i + 1) % 4], &twice);
    if (!cut) // the disc is within, or beside
        return near_x + near_y > 0.0 ? 0.0 : M_PI * r * r;
    return gp_mind(gp_maxd(0.5 * twice, 0.0), w * h);
}

/* The area of a light's disc of radius r in a rectangle. */
static double light_area(const struct gp_light *l, double r, double x0,
                         double y0, double x1, double y1)
{
    const double q = gp_light_stretch(l);
    return area_in(l->x / q, l->y * q, r, x0 / q, y0 * q, x1 / q, y1 * q);
}

double gp_light_pixel_area(const struct gp_light *l, double r, int x, int y)
{
    return light_area(l, r, x, y, (double) x + 1.0, (double) y + 1.0);
}

/* A disc of no area has no share; one of 1e9 is larger than any frame, and has
 * a finite square. */
static double radius_of(const struct gp_light *l)
{
    return fmin(fmax(l->radius, 1e-3), 1e9);
}

/* Areas found in two ways differ by less: rounding lets no light in. */
static double rounding_of(double radius)
{
    return 1e-9 * M_PI * radius * radius;
}

// -- the pixels of a rectangle -----------------------------------------------

/* Areas in square pixels: of the disc; of what is visible of it, at least and
 * at most, which are one for the share itself. */
struct sums {
    double area, low, high;
};

/* Finds the least and the largest that pixel (x, y) may show: where there is no
 * edge all of them show all, or nothing. */
static void bounds_of(const struct gp_occluders *o, const struct gp_light *l,
                      int x, int y, double *lo, double *hi)
{
    const struct gp_rect f = o->frame;
    // coverage has no others
    const int around = o->deep || (o->mask && !o->depth) ? 0 : 1;
    bool beyond, any = false;
    const double own = gp_occluders_show(o, l, x, y, &beyond);
    *lo = *hi = own;
    for (int j = gp_max(y - around, f.y0); j <= gp_min(y + around, f.y1 - 1);
         j++) {
        for (int i = gp_max(x - around, f.x0);
             i <= gp_min(x + around, f.x1 - 1); i++) {
            bool past;
            const double s = gp_occluders_show(o, l, i, j, &past);
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
    *lo = *lo >= 1.0 ? 1.0 : 0.0;
    *hi = *hi > 0.0 ? 1.0 : 0.0;
}

/* Returns what shows of a deep pixel's part in the disc, per area: its quarters show more
 * towards neighbours that do, in the mean what it shows itself. */
static double part_shown(const struct gp_occluders *o, const struct gp_light *l,
                         double r, int x, int y)
{
    static const double STEEP =
        2.0; // an edge is steeper than its neighbours say
    const double own = gp_occluders_show(o, l, x, y, NULL);
    const double across = gp_occluders_show(o, l, x + 1, y, NULL) -
                          gp_occluders_show(o, l, x - 1, y, NULL);
    const double down = gp_occluders_show(o, l, x, y + 1, NULL) -
                        gp_occluders_show(o, l, x, y - 1, NULL);
    const double slope = 0.125 * (fabs(across) + fabs(down)); // to a quarter
    const double most = fmin(own, 1.0 - own);
    const double k = slope * STEEP > most ? most / slope : STEEP;
    double area = 0.0, shown = 0.0;
    for (int q = 0; q < 4; q++) {
        const double left = x + 0.5 * (q % 2), top = y + 0.5 * (q / 2);
        const double a = light_area(l, r, left, top, left + 0.5, top + 0.5);
        const double more =
            0.125 * k * ((q % 2 ? across : -across) + (q / 2 ? down : -down));
        area += a;
        shown += a * (own + more);
    }
    return area > 0.0 ? fmin(fmax(shown / area, 0.0), 1.0) : own;
}

/* Adds the pixels of `rect` that the disc touches, but those of `done`.
 *   bounds  of what they may show; else what they show */
static void add_rect(const struct gp_occluders *o, const struct gp_light *l,
    bool bounds, struct gp_rect rect, struct gp_rect done, struct sums *s)
{
    const double r = radius_of(l), q = gp_light_stretch(l);
    const int x0 = gp_clamp_whole(floor(l->x - r * q), rect.x0, rect.x1);
    const int y0 = gp_clamp_whole(floor(l->y - r / q), rect.y0, rect.y1);
    const int x1 = gp_clamp_whole(ceil(l->x + r * q), x0, rect.x1);
    const int y1 = gp_clamp_whole(ceil(l->y + r / q), y0, rect.y1);
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) {
            const double area = gp_light_pixel_area(l, r, x, y);
            double lo, hi;
            if (!(area > 0.0) || (x >= done.x0 && x < done.x1 && y >= done.y0 &&
                                  y < done.y1))
                continue;
            if (bounds && !(o->deep && area > 1.0 - 1e-9))
                bounds_of(o, l, x, y, &lo, &hi);
            else
                lo = hi = o->deep && area < 1.0 - 1e-9
                              ? part_shown(o, l, r, x, y)
                              : gp_occluders_show(o, l, x, y, NULL);
            s->area += area;
            s->low += area * lo;
            s->high += area * hi;
        }
    }
}

/* The part of the frame in which a plane has samples, and `margin` pixels more
 * on each side; empty for none. Only these are visited: a display window may be
 * larger than any plane by any factor. */
static struct gp_rect known_rect(const struct gp_plane *p, struct gp_rect frame,
                                 int margin)
{
    if (!p || !p->v)
        return (struct gp_rect) {0};
    const struct gp_rect w = p->window;
    return gp_rect_meet((struct gp_rect) {w.x0 - margin, w.y0 - margin,
                                          w.x1 + margin, w.y1 + margin}, frame);
}

/* Adds up over the frame, whose pixels without samples are clear. */
static void add_frame(const struct gp_occluders *o, const struct gp_light *l,
                      bool bounds, struct sums *sum)
{
    const struct gp_rect f = o->frame;
    struct sums s = {0};
    // pixels beside the planes' windows may be at their edges
    const struct gp_rect depth = o->deep ? gp_rect_meet(o->deep->window, f)
                                         : known_rect(o->depth, f, bounds);
    add_rect(o, l, bounds, depth, (struct gp_rect) {0}, &s);
    add_rect(o, l, bounds, known_rect(o->deep ? NULL : o->mask, f, bounds),
             depth, &s);
    const double r = radius_of(l);
    double clear = light_area(l, r, f.x0, f.y0, f.x1, f.y1) - s.area;
    clear = clear > rounding_of(r) ? clear : 0.0;
    sum->area += s.area + clear;
    sum->low += s.low + clear;
    sum->high += s.high + clear;
}

/* The same of a disc that goes on beyond the seam of a sphere, too. */
static struct sums sums_of(const struct gp_occluders *o,
                           const struct gp_light *l, bool bounds)
{
    const int around = o->around > 0.0 ? 1 : 0;
    struct sums s = {0};
    for (int turn = -around; turn <= around; turn++) {
        struct gp_light at = *l;
        at.x += turn * o->around;
        add_frame(o, &at, bounds, &s);
    }
    return s;
}

// -- the share, and its bounds ------------------------------------------------

/* Returns the area of a light's disc outside of the frame. */
static double area_beyond(const struct gp_light *l, const struct sums *s)
{
    const double r = radius_of(l), beyond = M_PI * r * r - s->area;
    return beyond > rounding_of(r) ? beyond : 0.0;
}

void gp_sun_exact(const struct gp_occluders *o, enum glarepp_outside outside,
                  struct gp_light *light, int n)
{
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        if (l->behind || l->traced) {
            l->visibility =
                l->traced || outside == GLAREPP_BY_SCENE ? l->outside : 0.0;
            continue;
        }
        struct sums s = sums_of(o, l, false);
        const double beyond = area_beyond(l, &s);
        if (outside != GLAREPP_IGNORE) {
            s.area += beyond;
            s.low += outside == GLAREPP_VISIBLE ? beyond
                     : outside == GLAREPP_BY_SCENE ? beyond * l->outside : 0.0;
        }
        l->visibility = s.area > 0.0 ? fmin(s.low / s.area, 1.0) : 0.0;
    }
}

void gp_sun_interval(const struct gp_occluders *o, enum glarepp_outside outside,
                     struct gp_light *light, int n)
{
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        const bool scene = l->traced || outside == GLAREPP_BY_SCENE;
        const double lo = scene ? fmax(l->outside - l->outside_error, 0.0)
                                : 0.0;
        const double hi = scene ? fmin(l->outside + l->outside_error, 1.0)
                                : 1.0;
        struct sums s = l->behind ? (struct sums) {0} : sums_of(o, l, true);
        if (o->deep && s.area > 0.0) { // samples may be around the light itself
            struct gp_light exact = *l;
            exact.bias = 0.0;
            s.low = sums_of(o, &exact, true).low;
        }
        l->in_frame = s.area > 0.0;
        if (l->traced)
            s = (struct sums) {0};
        const double rest = area_beyond(l, &s), all = s.area + rest;
        l->low = fmin((s.low + rest * lo) / all, l->visibility);
        l->high = fmax(fmin((s.high + rest * hi) / all, 1.0), l->visibility);
    }
}
