/* Depth and coverage: finds the samples that are surfaces, the visible share of
 * a light behind them, and the kinds of samples that a plane holds. */
#include "sun/occluder.h"

#include "core/cpu.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

// -- pixels ------------------------------------------------------------------

/* Returns true when a surface at `place` hides the light. */
static bool hides(const struct gp_light *l, double place)
{
    return isinf(l->depth) ? l->depth > 0.0
                           : place < l->depth * (1.0 - l->bias);
}

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

static float clamped(float m)
{
    return m > 0.0f ? (m < 1.0f ? m : 1.0f) : 0.0f; // NaN: 0
}

static struct gp_sun_pixel pixel_at(const struct gp_occluders *o,
                                    struct gp_depth_range s, int x, int y)
{
    struct gp_sun_pixel p = {INFINITY, 0.0f};
    const float *const z = has(o->depth) ? sample_at(o->depth, x, y) : NULL;
    if (z && gp_is_surface(s, *z)) {
        p.place = gp_surface_place(o->type, o->facts.reversed, *z);
        p.cover = 1.0f;
    }
    if (has(o->mask)) {
        const float *const m = sample_at(o->mask, x, y);
        p.cover = m ? clamped(*m) : 0.0f;
    }
    return p;
}

struct gp_sun_pixel gp_occluders_at(const struct gp_occluders *o, int x, int y)
{
    return pixel_at(o, gp_depth_range_of(o->type, o->facts.reversed), x, y);
}

static float hidden(const struct gp_light *l, struct gp_sun_pixel p)
{
    return isinf(p.place) || hides(l, p.place) ? p.cover : 0.0f;
}

double gp_occluders_show(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y, bool *beyond)
{
    const struct gp_sun_pixel p = gp_occluders_at(o, x, y);
    if (beyond)
        *beyond = !isinf(p.place) && !hides(l, p.place);
    return 1.0 - (double) hidden(l, p);
}

double gp_occluders_sum(const struct gp_occluders *o, const struct gp_light *l,
                        int x0, int x1, int y)
{
    enum { RUN = 512, LANES = 8 }; // an order of sums that shares depend on
    const struct gp_depth_range s = gp_depth_range_of(o->type,
                                                      o->facts.reversed);
    double sum = 0.0;
    if (x1 <= x0)
        return 0.0;
    for (int64_t from = x0; from < x1; from += RUN) {
        double lane[LANES] = {0.0}, run = 0.0;
        for (int64_t x = from; x < x1 && x < from + RUN; x++)
            lane[(x - from) % LANES] +=
                (double) hidden(l, pixel_at(o, s, (int) x, y));
        for (int k = 0; k < LANES; k++)
            run += lane[k];
        sum += run;
    }
    return (double) x1 - (double) x0 - sum;
}

// -- the kinds of samples ----------------------------------------------------

/* Floats in order as whole numbers, and back; -0 and 0 are one. */
static int32_t float_order(float v)
{
    int32_t bits;
    memcpy(&bits, &v, sizeof bits);
    return bits < 0 ? INT32_MIN - bits : bits;
}

static float float_of(int32_t k)
{
    const int32_t bits = k < 0 ? INT32_MIN - k : k;
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

/* Parts are the same for any number of threads. */
enum { BANDS = 64 };

enum kind {
    ZERO, NOT_A_NUMBER, INFINITE, HUGE_ONE, HALF_MAX, NEGATIVE, ONE,
    FORE, BACK, // surfaces as they are, and reversed
    OVER,       // 1 and more, +Inf too
    TINY,       // over 0, and too little for a surface
    KINDS,
};

/* Counts of a share of the rows. */
struct counts {
    long long of[KINDS];
    int32_t lo, hi; // of the huge, in float_order()
};

struct counting {
    const struct gp_plane *plane;
    struct gp_depth_range fore, back;
    struct counts band[BANDS];
};

/* From the least to the most of a row's huge values. */
GP_CLONES static void span_huge(const float *v, int n, struct counts *t)
{
    const int32_t far = float_order(GP_DEPTH_HUGE);
    const int32_t endless = float_order(INFINITY);
    int32_t lo = t->lo, hi = t->hi;
    for (int i = 0; i < n; i++) {
        const int32_t k = float_order(v[i]), size = k < 0 ? -k : k;
        const int32_t is = -((size >= far) & (size < endless)); // all bits
        const int32_t low = (k & is) | (INT32_MAX & ~is);
        const int32_t high = (k & is) | (INT32_MIN & ~is);
        lo = low < lo ? low : lo;
        hi = high > hi ? high : hi;
    }
    t->lo = lo;
    t->hi = hi;
}

/* Surfaces as an interval of float_order(). */
struct span {
    int32_t lo, hi, hole;
};

static struct span span_of(struct gp_depth_range s)
{
    // NaN, for no hole, is beyond hi
    return (struct span) {float_order(s.lo), float_order(s.hi),
                          float_order(s.hole)};
}

/* One row's kinds. Whole numbers throughout, as wide as a float: then the
 * compiler makes vectors of it, which is 8 times as fast. */
GP_CLONES static void count_row(const struct counting *s, const float *v, int n,
                                struct counts *t)
{
    const struct span f = span_of(s->fore), b = span_of(s->back);
    const int32_t half = float_order(GP_DEPTH_HALF);
    const int32_t far = float_order(GP_DEPTH_HUGE);
    const int32_t endless = float_order(INFINITY);
    const int32_t unit = float_order(1.0f);
    int zero = 0, nan = 0, inf = 0, beyond = 0, halves = 0, negative = 0;
    int one = 0, over = 0, fore = 0, back = 0, tiny = 0;
    for (int i = 0; i < n; i++) {
        const int32_t k = float_order(v[i]), size = k < 0 ? -k : k;
        zero += k == 0;
        nan += size > endless;
        inf += size == endless;
        beyond += size >= far; // NaN too
        halves += size == half;
        negative += (k < 0) & (size < far) & (size != half);
        one += k == unit;
        over += (k >= unit) & (k <= endless);
        tiny += (k > 0) & (k < f.lo);
        fore += (k >= f.lo) & (k <= f.hi) & (k != f.hole);
        back += (k >= b.lo) & (k <= b.hi) & (k != b.hole);
    }
    const int row[KINDS] = {zero, nan, inf, beyond - nan - inf, halves,
                            negative, one, fore, back, over, tiny};
    for (int i = 0; i < KINDS; i++)
        t->of[i] += row[i];
    if (row[HUGE_ONE] > 0)
        span_huge(v, n, t);
}

static void count_band(void *ctx, int i, int thread)
{
    (void) thread;
    struct counting *const s = ctx;
    const int64_t h = gp_rect_h(s->plane->window);
    const int w = gp_rect_w(s->plane->window);
    s->band[i] = (struct counts) {.lo = INT32_MAX, .hi = INT32_MIN};
    for (int64_t y = h * i / BANDS; y < h * (i + 1) / BANDS; y++)
        count_row(s, s->plane->v + (size_t) y * (size_t) w, w, &s->band[i]);
}

void gp_occluders_count(struct gp_occluders *o)
{
    o->facts = (struct gp_depth_facts) {.empty = "none"};
    if (!has(o->depth) || gp_rect_empty(o->depth->window))
        return;
    struct counting s = {.plane = o->depth,
                       .fore = gp_depth_range_of(o->type, false),
                       .back = gp_depth_range_of(o->type, true)};
    gp_parallel_do(BANDS, count_band, &s);
    struct counts t = {.lo = INT32_MAX, .hi = INT32_MIN};
    for (int i = 0; i < BANDS; i++) {
        const struct counts *const p = &s.band[i];
        for (int k = 0; k < KINDS; k++)
            t.of[k] += p->of[k];
        t.lo = p->lo < t.lo ? p->lo : t.lo;
        t.hi = p->hi > t.hi ? p->hi : t.hi;
    }
    struct gp_depth_facts *const f = &o->facts;
    const bool share = o->type == GP_DEPTH_NORMALIZED;
    const bool axis = o->type == GP_DEPTH_Z || o->type == GP_DEPTH_RAY;
    if (share)
        f->reversed = t.of[OVER] == 0 && t.of[ZERO] > 0;
    else if (axis)
        f->reversed = t.of[FORE] == 0 && t.of[BACK] > 0;

    // the kinds of empty samples that occur
    const double lo = (double) float_of(t.lo);
    const double hi = (double) float_of(t.hi);
    char huge[32]; // one, or from the least to the most
    if (t.lo == t.hi)
        snprintf(huge, sizeof huge, "%g", lo);
    else
        snprintf(huge, sizeof huge, "%g to %g", lo, hi);
    const bool first = !share || f->reversed; // 0 and less is empty
    const struct {
        bool is;
        const char *text;
    } kind[] = {
        {first && t.of[ZERO] > 0, "0"},
        {t.of[TINY] > 0, "under 1e-09"},
        {first && t.of[NEGATIVE] > 0 && !(axis && f->reversed), "negative"},
        {share && t.of[ONE] > 0, "1"},
        {share && t.of[OVER] > t.of[ONE], "over 1"},
        {axis && t.of[HALF_MAX] > 0, f->reversed ? "-65504" : "65504"},
        {axis && t.of[HUGE_ONE] > 0, huge},
        {axis && t.of[INFINITE] > 0, "inf"},
        {t.of[NOT_A_NUMBER] > 0, "nan"},
    };
    size_t used = 0;
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        if (kind[i].is && used < sizeof f->empty)
            used += (size_t) snprintf(f->empty + used, sizeof f->empty - used,
                                      "%s%s", used ? ", " : "", kind[i].text);
    }
}
