#include "core/cpu.h"
#include "core/parallel.h"
#include "sun/surfaces.h"

#include <float.h>
#include <math.h>
#include <stdio.h>

/* Parts are the same for any number of threads. */
enum { PARTS = 64 };

/* Counts of a share of the rows. */
struct tally {
    long long zero, nan, inf, huge, half_max, negative, one;
    long long fore, back; // surfaces as they are, and turned
    long long over;       // 1 and more, +Inf too
    long long tiny;       // over 0, and too little for a surface
    int32_t lo, hi;       // of the huge, in gp_float_order()
};

struct survey {
    const struct gp_plane *plane;
    struct gp_surfaces fore, back;
    struct tally part[PARTS];
};

/* From the least to the most of a row's huge values. */
GP_CLONES static void span_huge(const float *v, int n, struct tally *t)
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

static struct span span_of(struct gp_surfaces s)
{
    // NaN, for no hole, is beyond hi
    return (struct span) {gp_float_order(s.lo), gp_float_order(s.hi),
                          gp_float_order(s.hole)};
}

/* One row's kinds. Whole numbers throughout, as wide as a float: then the
 * compiler makes vectors of it, which is 8 times as fast. */
GP_CLONES static void count_row(const struct survey *s, const float *v, int n,
                                struct tally *t)
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
    t->zero += zero;
    t->nan += nan;
    t->inf += inf;
    t->huge += beyond - nan - inf;
    t->half_max += halves;
    t->negative += negative;
    t->one += one;
    t->over += over;
    t->tiny += tiny;
    t->fore += fore;
    t->back += back;
    if (beyond > nan + inf)
        span_huge(v, n, t);
}

static void survey_part(void *ctx, int i, int thread)
{
    (void) thread;
    struct survey *const s = ctx;
    const int64_t h = gp_rect_h(s->plane->window);
    const int w = gp_rect_w(s->plane->window);
    s->part[i] = (struct tally) {.lo = INT32_MAX, .hi = INT32_MIN};
    for (int64_t y = h * i / PARTS; y < h * (i + 1) / PARTS; y++)
        count_row(s, s->plane->v + (size_t) y * (size_t) w, w, &s->part[i]);
}

static struct tally total_of(const struct survey *s)
{
    struct tally t = {.lo = INT32_MAX, .hi = INT32_MIN};
    for (int i = 0; i < PARTS; i++) {
        const struct tally *const p = &s->part[i];
        t.zero += p->zero;
        t.nan += p->nan;
        t.inf += p->inf;
        t.huge += p->huge;
        t.half_max += p->half_max;
        t.negative += p->negative;
        t.one += p->one;
        t.over += p->over;
        t.tiny += p->tiny;
        t.fore += p->fore;
        t.back += p->back;
        t.lo = p->lo < t.lo ? p->lo : t.lo;
        t.hi = p->hi > t.hi ? p->hi : t.hi;
    }
    return t;
}

/* The text of the huge values: one, or from the least to the most. */
static void name_huge(const struct tally *t, char text[32])
{
    const double lo = (double) gp_float_of(t->lo);
    const double hi = (double) gp_float_of(t->hi);
    if (t->huge == 0)
        text[0] = '\0';
    else if (t->lo == t->hi)
        snprintf(text, 32, "%g", lo);
    else
        snprintf(text, 32, "%g to %g", lo, hi);
}

/* Lists the kinds of empty samples that occur. */
static void name_empty(enum gp_depth_type type, const struct tally *t,
                       struct gp_depth_facts *f)
{
    char huge[32];
    name_huge(t, huge);
    const bool axis = type == GP_DEPTH_Z || type == GP_DEPTH_RAY;
    const bool share = type == GP_DEPTH_NORMALIZED;
    const bool first = !share || f->reversed; // 0 and less is empty
    const struct {
        bool is;
        const char *text;
    } kind[] = {
        {first && t->zero > 0, "0"},
        {t->tiny > 0, "under 1e-09"},
        {first && t->negative > 0 && !(axis && f->reversed), "negative"},
        {share && t->one > 0, "1"},
        {share && t->over > t->one, "over 1"},
        {axis && t->half_max > 0, f->reversed ? "-65504" : "65504"},
        {axis && t->huge > 0, huge},
        {axis && t->inf > 0, "inf"},
        {t->nan > 0, "nan"},
    };
    size_t used = 0;
    snprintf(f->empty, sizeof f->empty, "none");
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        if (kind[i].is && used < sizeof f->empty)
            used += (size_t) snprintf(f->empty + used, sizeof f->empty - used,
                                      "%s%s", used ? ", " : "", kind[i].text);
    }
}

gp_status gp_occluders_survey(const struct gp_log *log, struct gp_occluders *o)
{
    (void) log;
    o->facts = (struct gp_depth_facts) {.empty = "none"};
    if (!o->depth || !o->depth->v || gp_rect_empty(o->depth->window))
        return GP_OK;
    struct survey s = {.plane = o->depth,
                       .fore = gp_surfaces_of(o->type, false),
                       .back = gp_surfaces_of(o->type, true)};
    gp_parallel_do(PARTS, survey_part, &s);
    const struct tally t = total_of(&s);
    struct gp_depth_facts *const f = &o->facts;
    if (o->type == GP_DEPTH_NORMALIZED)
        f->reversed = t.over == 0 && t.zero > 0;
    else if (o->type != GP_DEPTH_INVERSE)
        f->reversed = t.fore == 0 && t.back > 0;
    f->zero = t.zero;
    f->nan = t.nan;
    f->inf = t.inf;
    f->huge = t.huge;
    f->half_max = t.half_max;
    f->negative = t.negative;
    f->one = t.one;
    f->surface = f->reversed ? t.back : t.fore;
    name_empty(o->type, &t, f);
    return GP_OK;
}
