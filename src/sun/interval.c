/* Bounds of a light's share: the pixels of edges all hidden, and all clear. */
#include "sun/sun_priv.h"

#include "core/minmax.h"
#include "core/parallel.h"

#include <math.h>
#include <string.h>

enum { STRIPS = 64 };         // of a disc, summed in order

struct bounds_sums {
    double area, lo, hi;
};

struct interval {
    const struct gp_occluders *o;
    const struct gp_light *light;
    double radius;
    struct gp_rect rect; // pixels under the disc
    int n;               // strips
    struct bounds_sums sum[STRIPS];
};

/* Least and largest of what is shown by pixels of a column, what its middle
 * pixel shows, and where a surface beyond the light is. */
struct shown {
    double lo, hi, own;
    bool own_beyond, beyond; // in the middle; in any row
};

/* Returns those of column x in rows y - 1, y and y + 1, as far as they are in
 * the frame; in row y where there is coverage alone. */
static struct shown column(const struct interval *v, int x, int y)
{
    const struct gp_rect f = v->o->frame;
    struct shown s = {.lo = INFINITY, .hi = -INFINITY};
    const bool apart = v->o->mask && !v->o->depth;
    const int y0 = apart || y == f.y0 ? y : y - 1;
    const int y1 = apart || y + 1 == f.y1 ? y : y + 1;
    for (int k = y0; k <= y1; k++) {
        const double one = gp_occluders_show(v->o, v->light, x, k);
        const bool beyond = gp_occluders_beyond(v->o, v->light, x, k);
        s.lo = fmin(s.lo, one);
        s.hi = fmax(s.hi, one);
        s.own = k == y ? one : s.own;
        s.own_beyond = k == y ? beyond : s.own_beyond;
        s.beyond = s.beyond || beyond;
    }
    return s;
}

/* Area of the disc in a pixel; 1 where all four corners are inside. */
static double area_of(const struct interval *v, int x, int y)
{
    const double dx = fmax(fabs(x - v->light->x), fabs(x + 1.0 - v->light->x));
    const double dy = fmax(fabs(y - v->light->y), fabs(y + 1.0 - v->light->y));
    return dx * dx + dy * dy < v->radius * v->radius
               ? 1.0
               : gp_disc_pixel_area(v->light->x, v->light->y, v->radius, x, y);
}

static void add_row(const struct interval *v, int y, struct bounds_sums *sum)
{
    const struct gp_rect f = v->o->frame;
    const struct shown none = {.lo = INFINITY, .hi = -INFINITY};
    const int x0 = v->rect.x0;
    const bool apart = v->o->mask && !v->o->depth;
    struct shown left = x0 > f.x0 && !apart ? column(v, x0 - 1, y) : none;
    struct shown middle = column(v, x0, y);
    for (int x = x0; x < v->rect.x1; x++) {
        const struct shown right = x + 1 < f.x1 && !apart ? column(v, x + 1, y)
                                                   : none;
        double lo = fmin(middle.lo, fmin(left.lo, right.lo));
        double hi = fmax(middle.hi, fmax(left.hi, right.hi));
        // coverage has its edges in itself, but for those of surfaces beyond
        // the light, which show all of it
        if (v->o->mask && !middle.own_beyond) {
            lo = middle.own;
            hi = left.beyond || middle.beyond || right.beyond ? 1.0 : lo;
        }
        const double area = area_of(v, x, y);
        // where there is no edge all of them show all, or nothing
        sum->area += area;
        sum->lo += lo >= 1.0 ? area : 0.0;
        sum->hi += hi > 0.0 ? area : 0.0;
        left = apart ? none : middle;
        middle = apart && x + 1 < f.x1 ? column(v, x + 1, y) : right;
    }
}

static void add_strip(void *ctx, int i, int thread)
{
    (void) thread;
    struct interval *const v = ctx;
    const int64_t h = gp_rect_h(v->rect);
    for (int64_t k = h * i / v->n; k < h * (i + 1) / v->n; k++)
        add_row(v, (int) (v->rect.y0 + k), &v->sum[i]);
}

/* Adds the pixels of a rectangle that the disc may touch. */
static void add_rect(struct interval *v, struct gp_rect r,
                     struct bounds_sums *sum)
{
    v->rect = gp_disc_box(v->light->x, v->light->y, v->radius, r);
    if (gp_rect_empty(v->rect))
        return;
    const int h = gp_rect_h(v->rect);
    v->n = h < STRIPS ? h : STRIPS;
    memset(v->sum, 0, sizeof v->sum);
    gp_parallel_do(v->n, add_strip, v);
    for (int k = 0; k < v->n; k++) {
        sum->area += v->sum[k].area;
        sum->lo += v->sum[k].lo;
        sum->hi += v->sum[k].hi;
    }
}

void gp_sun_interval(const struct gp_occluders *o, enum gp_sun_outside outside,
                     struct gp_light *light, int n)
{
    // pixels beside the planes' windows and their edges are clear
    struct gp_rect rect[GP_SUN_RECTS];
    const int rects = gp_sun_rects(o, 1, rect);
    const struct gp_rect f = o->frame;
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        const bool scene = outside == GP_OUTSIDE_SCENE;
        const double lo = scene ? fmax(l->outside - l->outside_error, 0.0)
                                : 0.0;
        const double hi = scene ? fmin(l->outside + l->outside_error, 1.0)
                                : 1.0;
        struct interval v = {.o = o, .light = l};
        struct bounds_sums s = {0};
        v.radius = fmin(fmax(l->radius, 1e-3), 1e9); // as gp_sun_exact()
        const double disc = M_PI * v.radius * v.radius;
        if (!l->behind) {
            for (int k = 0; k < rects; k++)
                add_rect(&v, rect[k], &s);
            const double clear =
                gp_disc_rect_area(l->x, l->y, v.radius, f.x0, f.y0, f.x1,
                                  f.y1) - s.area;
            // (rounding lets no light in)
            s.area += clear > 1e-9 * disc ? clear : 0.0;
            s.lo += clear > 1e-9 * disc ? clear : 0.0;
            s.hi += clear > 1e-9 * disc ? clear : 0.0;
        }
        l->in_frame = s.area > 0.0;
        const double rest = disc - s.area > 1e-9 * disc ? disc - s.area : 0.0;
        const double all = s.area + rest;
        l->low = fmin((s.lo + rest * lo) / all, l->visibility);
        l->high = fmax(fmin((s.hi + rest * hi) / all, 1.0), l->visibility);
    }
}
