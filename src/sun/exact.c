#include "sun/exact.h"

#include "core/parallel.h"
#include "sun/disc.h"

#include <math.h>
#include <stdint.h>

/* A disc of no area has no share. */
static const double least_radius = 1e-3;

/* Larger than any frame, and small enough for its square to be a number. */
static const double most_radius = 1e9;

double gp_disc_pixel_area(double cx, double cy, double r, int x, int y)
{
    return gp_disc_rect_area(cx, cy, r, x, y, (double) x + 1.0,
                             (double) y + 1.0);
}

/* Areas in square pixels: of the disc, and of it that shows. */
struct sums {
    double area, shown;
};

/* -- the pixels of a rectangle --------------------------------------------- */

/* Rows go in bands, and the sums of the bands in order: the same bits for any
 * number of threads, and no memory that grows with the frame. */
enum { BANDS = 256, ALONE = 1 << 14 };

struct bands {
    const struct gp_occluders *o;
    const struct gp_light *light;
    double radius;
    struct gp_rect rect;  // pixels that the disc may reach
    int n;
    struct sums sum[BANDS];
};

/* v as a whole number within [lo, hi]; NaN gives lo. */
static int within(double v, int lo, int hi)
{
    return !(v > (double) lo) ? lo : v < (double) hi ? (int) v : hi;
}

/* Half of the chord at a distance from the centre; under 0: none. */
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
            s->shown += area * gp_occluders_show(b->o, l, x, y);
        }
    }
}

static void add_row(const struct bands *b, int y, struct sums *s)
{
    const struct gp_light *const l = b->light;
    const struct gp_rect rect = b->rect;
    const double above = l->y - (double) y, below = (double) y + 1.0 - l->y;
    const double nearest = fmax(fmax(-above, -below), 0.0);
    const double outer = half_chord(b->radius, nearest);
    const double inner = half_chord(b->radius, fmax(above, below));
    if (outer < 0.0)
        return;
    // a pixel more on each side: the chords are rounded
    const int x0 = within(floor(l->x - outer) - 1.0, rect.x0, rect.x1);
    const int x1 = within(ceil(l->x + outer) + 1.0, x0, rect.x1);
    int in0 = x1, in1 = x1;
    if (inner > 0.0) {
        in0 = within(ceil(l->x - inner) + 1.0, x0, x1);
        in1 = within(floor(l->x + inner) - 1.0, in0, x1);
    }
    add_edge(b, x0, in0, y, s);
    s->area += (double) in1 - (double) in0;
    s->shown += gp_occluders_sum(b->o, l, in0, in1, y);
    add_edge(b, in1, x1, y, s);
}

static void add_band(void *ctx, int i, int thread)
{
    (void) thread;
    struct bands *const b = ctx;
    const int64_t h = gp_rect_h(b->rect);
    for (int64_t y = h * i / b->n; y < h * (i + 1) / b->n; y++)
        add_row(b, (int) (b->rect.y0 + y), &b->sum[i]);
}

/* Sums over the pixels of `rect` that the disc touches. */
static struct sums sum_rect(const struct gp_occluders *o,
                            const struct gp_light *l, double r,
                            struct gp_rect rect)
{
    struct bands b = {.o = o, .light = l, .radius = r};
    b.rect.x0 = within(floor(l->x - r), rect.x0, rect.x1);
    b.rect.y0 = within(floor(l->y - r), rect.y0, rect.y1);
    b.rect.x1 = within(ceil(l->x + r), b.rect.x0, rect.x1);
    b.rect.y1 = within(ceil(l->y + r), b.rect.y0, rect.y1);
    struct sums s = {0};
    if (gp_rect_empty(b.rect))
        return s;
    const int h = gp_rect_h(b.rect);
    b.n = h < BANDS ? h : BANDS;
    if ((int64_t) h * gp_rect_w(b.rect) > ALONE) {
        gp_parallel_do(b.n, add_band, &b);
    } else { // waking threads takes longer
        for (int i = 0; i < b.n; i++)
            add_band(&b, i, 0);
    }
    for (int i = 0; i < b.n; i++) {
        s.area += b.sum[i].area;
        s.shown += b.sum[i].shown;
    }
    return s;
}

/* -- the frame ------------------------------------------------------------- */

/* Where a plane has samples within the frame; empty for NULL. */
static struct gp_rect known(const struct gp_plane *p, struct gp_rect frame)
{
    if (!p || !p->v)
        return (struct gp_rect) {0};
    const struct gp_rect r = gp_rect_meet(p->window, frame);
    return gp_rect_empty(r) ? (struct gp_rect) {0} : r;
}

/* What of `a` is outside of `b`, in up to four rectangles (some may be
 * empty). */
static int rect_without(struct gp_rect a, struct gp_rect b,
                        struct gp_rect out[4])
{
    const struct gp_rect both = gp_rect_meet(a, b);
    if (gp_rect_empty(both)) {
        out[0] = a;
        return 1;
    }
    out[0] = (struct gp_rect) {a.x0, a.y0, a.x1, both.y0};
    out[1] = (struct gp_rect) {a.x0, both.y0, both.x0, both.y1};
    out[2] = (struct gp_rect) {both.x1, both.y0, a.x1, both.y1};
    out[3] = (struct gp_rect) {a.x0, both.y1, a.x1, a.y1};
    return 4;
}

static double area_in(const struct gp_light *l, double r, struct gp_rect rect)
{
    return gp_disc_rect_area(l->x, l->y, r, rect.x0, rect.y0, rect.x1, rect.y1);
}

/* Sums over the frame. Only pixels of which a plane tells are visited: a
 * display window may be larger than any plane by any factor. */
static struct sums sum_frame(const struct gp_occluders *o,
                             const struct gp_light *l, double r)
{
    const struct gp_rect depth = known(o->depth, o->frame);
    const struct gp_rect mask = known(o->mask, o->frame);
    struct gp_rect part[5] = {depth};
    const int parts = 1 + rect_without(mask, depth, part + 1);
    struct sums all = {0};
    double told = 0.0;
    for (int i = 0; i < parts; i++) {
        const struct sums s = sum_rect(o, l, r, part[i]);
        all.area += s.area;
        all.shown += s.shown;
        told += area_in(l, r, part[i]);
    }
    // two closed forms of one area differ by rounding alone: no light shines
    // through that
    const double frame = area_in(l, r, o->frame);
    const double clear = frame - told;
    if (clear > 1e-12 * frame) {
        all.area += clear;
        all.shown += clear;
    }
    return all;
}

static double visibility_of(const struct gp_occluders *o,
                            enum gp_sun_outside outside,
                            const struct gp_light *l)
{
    const double r = fmin(fmax(l->radius, least_radius), most_radius);
    const double disc = M_PI * r * r;
    struct sums s = sum_frame(o, l, r);
    const double beyond = disc - area_in(l, r, o->frame);
    if (outside != GP_OUTSIDE_IGNORE && beyond > 1e-12 * disc) {
        s.area += beyond;
        s.shown += outside == GP_OUTSIDE_VISIBLE ? beyond : 0.0;
    }
    return s.area > 0.0 ? fmin(s.shown / s.area, 1.0) : 0.0;
}

gp_status gp_sun_exact(const struct gp_log *log, const struct gp_occluders *o,
                       enum gp_sun_outside outside, struct gp_light *light,
                       int n)
{
    (void) log;
    for (int i = 0; i < n; i++) {
        struct gp_light *const l = &light[i];
        l->visibility = l->behind ? 0.0 : visibility_of(o, outside, l);
    }
    return GP_OK;
}
