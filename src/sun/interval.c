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

/* Area of the disc in a pixel; 1 where all four corners are inside. */
static double area_of(const struct interval *v, int x, int y)
{
    const double dx = fmax(fabs(x - v->light->x), fabs(x + 1.0 - v->light->x));
    const double dy = fmax(fabs(y - v->light->y), fabs(y + 1.0 - v->light->y));
    return dx * dx + dy * dy < v->radius * v->radius
               ? 1.0
               : gp_disc_pixel_area(v->light->x, v->light->y, v->radius, x, y);
}

/* Finds the least and the largest that pixel (x, y) may show. */
static void bounds_of(const struct interval *v, int x, int y, double *lo,
                      double *hi)
{
    const struct gp_occluders *const o = v->o;
    const struct gp_rect f = o->frame;
    const int around = o->mask && !o->depth ? 0 : 1; // coverage has no others
    bool beyond, any = false;
    const double own = gp_occluders_show(o, v->light, x, y, &beyond);
    *lo = *hi = own;
    for (int j = gp_max(y - around, f.y0); j <= gp_min(y + around, f.y1 - 1);
         j++) {
        for (int i = gp_max(x - around, f.x0);
             i <= gp_min(x + around, f.x1 - 1); i++) {
            bool past;
            const double s = gp_occluders_show(o, v->light, i, j, &past);
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

static void add_row(const struct interval *v, int y, struct bounds_sums *sum)
{
    for (int x = v->rect.x0; x < v->rect.x1; x++) {
        const double area = area_of(v, x, y);
        double lo, hi;
        bounds_of(v, x, y, &lo, &hi);
        // where there is no edge all of them show all, or nothing
        sum->area += area;
        sum->lo += lo >= 1.0 ? area : 0.0;
        sum->hi += hi > 0.0 ? area : 0.0;
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
