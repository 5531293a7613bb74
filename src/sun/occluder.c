/* Depth and coverage: finds the samples that are surfaces, the visible share of
 * a light behind them, and the kinds of samples that a plane holds. */
#include "sun/sun_priv.h"

#include "core/cpu.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

// -- surfaces and their places ------------------------------------------------

double gp_depth_place(const struct gp_occluders *o, float v)
{
    const bool reversed = o->facts.reversed;
    const struct gp_depth_range s = gp_depth_range_of(o->type, reversed);
    if (!gp_is_surface(s, v))
        return INFINITY;
    return gp_surface_place(o->type, reversed, v);
}

/* Returns true when a surface at `place` hides the light. */
static bool hides(const struct gp_light *l, double place)
{
    return isinf(l->depth) ? l->depth > 0.0
                           : place < l->depth * (1.0 - l->bias);
}

// -- samples of planes -------------------------------------------------------

static bool has(const struct gp_plane *p)
{
    return p && p->v;
}

static bool within(struct gp_rect r, int x, int y)
{
    return x >= r.x0 && x < r.x1 && y >= r.y0 && y < r.y1;
}

static const float *sample_at(const struct gp_plane *p, int x, int y)
{
    const size_t w = (size_t) gp_rect_w(p->window);
    return p->v + (size_t) ((int64_t) y - p->window.y0) * w +
           (size_t) ((int64_t) x - p->window.x0);
}

static float clamped(float m)
{
    return m > 0.0f ? (m < 1.0f ? m : 1.0f) : 0.0f; // NaN: 0
}

double gp_occluders_show(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y)
{
    double hidden = 1.0;
    if (has(o->mask))
        hidden = within(o->mask->window, x, y)
                     ? (double) clamped(*sample_at(o->mask, x, y))
                     : 0.0;
    if (!has(o->depth))
        return has(o->mask) ? 1.0 - hidden : 1.0;
    const double place = within(o->depth->window, x, y)
                             ? gp_depth_place(o, *sample_at(o->depth, x, y))
                             : (double) INFINITY;
    const bool empty = isinf(place);
    const bool hit = !empty && hides(l, place);
    return hit || (empty && has(o->mask)) ? 1.0 - hidden : 1.0;
}

bool gp_occluders_beyond(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y)
{
    if (!has(o->depth) || !within(o->depth->window, x, y))
        return false;
    const double place = gp_depth_place(o, *sample_at(o->depth, x, y));
    return !isinf(place) && !hides(l, place);
}

// -- many pixels at a time ---------------------------------------------------
//
// Places grow or fall with the samples, so a light's depth becomes two
// comparisons of floats: the surfaces that hide the light are one interval, and
// those behind it another.

struct rule {
    float near_lo, near_hi; // hide the light; none: lo > hi
    float far_lo, far_hi;   // surfaces that do not
    float hole;             // empty all the same
};

static struct rule rule_for(const struct gp_occluders *o,
                            const struct gp_light *l)
{
    const bool reversed = o->facts.reversed;
    const struct gp_depth_range s = gp_depth_range_of(o->type, reversed);
    // steps from the nearest surface; `hit` of them hide
    const int64_t nearest = gp_float_order(s.near_high ? s.hi : s.lo);
    const int64_t toward = s.near_high ? -1 : 1;
    const int64_t all =
        (int64_t) gp_float_order(s.hi) - gp_float_order(s.lo) + 1;
    int64_t hit = 0, clear = all;
    while (hit < clear) {
        const int64_t mid = hit + (clear - hit) / 2;
        const float v = gp_float_of((int32_t) (nearest + toward * mid));
        if (hides(l, gp_surface_place(o->type, reversed, v)))
            hit = mid + 1;
        else
            clear = mid;
    }
    struct rule r = {1.0f, 0.0f, 1.0f, 0.0f, s.hole};
    const float last = gp_float_of((int32_t) (nearest + toward * (hit - 1)));
    if (hit > 0) {
        r.near_lo = s.near_high ? last : s.lo;
        r.near_hi = s.near_high ? s.hi : last;
    }
    if (hit < all) {
        const float next = gp_float_of((int32_t) (nearest + toward * hit));
        r.far_lo = s.near_high ? s.lo : next;
        r.far_hi = s.near_high ? next : s.hi;
    }
    return r;
}

enum { RUN = 512, LANES = 8 };

/* The hidden share of n pixels into `hidden`, from depth d and mask m; NULL:
 * without. */
GP_CLONES static void find_hidden(
    const struct rule *rule, const float *restrict d, const float *restrict m,
    int n, float *restrict hidden)
{
    const struct rule r = *rule;
    if (d && m) {
        for (int i = 0; i < n; i++) {
            const bool behind = (d[i] >= r.far_lo) & (d[i] <= r.far_hi) &
                                (d[i] != r.hole);
            hidden[i] = behind ? 0.0f : clamped(m[i]);
        }
    } else if (d) {
        for (int i = 0; i < n; i++) {
            const bool before = (d[i] >= r.near_lo) & (d[i] <= r.near_hi) &
                                (d[i] != r.hole);
            hidden[i] = before ? 1.0f : 0.0f;
        }
    } else {
        for (int i = 0; i < n; i++)
            hidden[i] = clamped(m[i]);
    }
}

/* Sum of n floats, a multiple of LANES; lanes keep the order, and so the bits,
 * the same for vectors of any width. */
GP_CLONES static double sum_of(const float *v, int n)
{
    double lane[LANES] = {0.0};
    for (int i = 0; i < n; i += LANES) {
        for (int k = 0; k < LANES; k++)
            lane[k] += (double) v[i + k];
    }
    double sum = 0.0;
    for (int k = 0; k < LANES; k++)
        sum += lane[k];
    return sum;
}

/* n samples from (x, y) on: in place, or in `copy` with `missing` for those
 * outside of the plane's window. */
static const float *samples(const struct gp_plane *p, int x, int y, int n,
                            float missing, float *copy)
{
    const struct gp_rect w = p->window;
    if (within(w, x, y) && w.x1 - x >= n)
        return sample_at(p, x, y);
    for (int i = 0; i < n; i++)
        copy[i] = within(w, x + i, y) ? *sample_at(p, x + i, y) : missing;
    return copy;
}

double gp_occluders_sum(const struct gp_occluders *o, const struct gp_light *l,
                        int x0, int x1, int y)
{
    if (x1 <= x0)
        return 0.0;
    const double count = (double) x1 - (double) x0;
    if (!has(o->depth) && !has(o->mask))
        return count;
    const struct rule rule = has(o->depth) ? rule_for(o, l) : (struct rule) {0};
    float hidden[RUN + LANES], depth[RUN], mask[RUN];
    double sum = 0.0;
    for (int64_t x = x0; x < x1; x += RUN) {
        const int n = (int) (x1 - x < RUN ? x1 - x : RUN);
        const float *const d =
            has(o->depth) ? samples(o->depth, (int) x, y, n, NAN, depth) : NULL;
        const float *const m =
            has(o->mask) ? samples(o->mask, (int) x, y, n, 0.0f, mask) : NULL;
        find_hidden(&rule, d, m, n, hidden);
        memset(hidden + n, 0, LANES * sizeof *hidden);
        sum += sum_of(hidden, (n + LANES - 1) / LANES * LANES);
    }
    return count - sum;
}

// -- the kinds of samples ----------------------------------------------------

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
    int32_t lo, hi; // of the huge, in gp_float_order()
};

struct counting {
    const struct gp_plane *plane;
    struct gp_depth_range fore, back;
    struct counts band[BANDS];
};

/* From the least to the most of a row's huge values. */
GP_CLONES static void span_huge(const float *v, int n, struct counts *t)
{
    const int32_t far = gp_float_order(GP_DEPTH_HUGE);
    const int32_t endless = gp_float_order(INFINITY);
    int32_t lo = t->lo, hi = t->hi;
    for (int i = 0; i < n; i++) {
        const int32_t k = gp_float_order(v[i]), size = k < 0 ? -k : k;
        const int32_t is = -((size >= far) & (size < endless)); // all bits
        const int32_t low = (k & is) | (INT32_MAX & ~is);
        const int32_t high = (k & is) | (INT32_MIN & ~is);
        lo = low < lo ? low : lo;
        hi = high > hi ? high : hi;
    }
    t->lo = lo;
    t->hi = hi;
}

/* Surfaces as an interval of gp_float_order(). */
struct span {
    int32_t lo, hi, hole;
};

static struct span span_of(struct gp_depth_range s)
{
    // NaN, for no hole, is beyond hi
    return (struct span) {gp_float_order(s.lo), gp_float_order(s.hi),
                          gp_float_order(s.hole)};
}

/* One row's kinds. Whole numbers throughout, as wide as a float: then the
 * compiler makes vectors of it, which is 8 times as fast. */
GP_CLONES static void count_row(const struct counting *s, const float *v, int n,
                                struct counts *t)
{
    const struct span f = span_of(s->fore), b = span_of(s->back);
    const int32_t half = gp_float_order(GP_DEPTH_HALF);
    const int32_t far = gp_float_order(GP_DEPTH_HUGE);
    const int32_t endless = gp_float_order(INFINITY);
    const int32_t unit = gp_float_order(1.0f);
    int zero = 0, nan = 0, inf = 0, beyond = 0, halves = 0, negative = 0;
    int one = 0, over = 0, fore = 0, back = 0, tiny = 0;
    for (int i = 0; i < n; i++) {
        const int32_t k = gp_float_order(v[i]), size = k < 0 ? -k : k;
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
    f->zero = t.of[ZERO];
    f->nan = t.of[NOT_A_NUMBER];
    f->inf = t.of[INFINITE];
    f->huge = t.of[HUGE_ONE];
    f->half_max = t.of[HALF_MAX];
    f->negative = t.of[NEGATIVE];
    f->one = t.of[ONE];
    f->surface = f->reversed ? t.of[BACK] : t.of[FORE];

    // the kinds of empty samples that occur
    const double lo = (double) gp_float_of(t.lo);
    const double hi = (double) gp_float_of(t.hi);
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
        {first && f->zero > 0, "0"},
        {t.of[TINY] > 0, "under 1e-09"},
        {first && f->negative > 0 && !(axis && f->reversed), "negative"},
        {share && f->one > 0, "1"},
        {share && t.of[OVER] > f->one, "over 1"},
        {axis && f->half_max > 0, f->reversed ? "-65504" : "65504"},
        {axis && f->huge > 0, huge},
        {axis && f->inf > 0, "inf"},
        {f->nan > 0, "nan"},
    };
    size_t used = 0;
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        if (kind[i].is && used < sizeof f->empty)
            used += (size_t) snprintf(f->empty + used, sizeof f->empty - used,
                                      "%s%s", used ? ", " : "", kind[i].text);
    }
}
