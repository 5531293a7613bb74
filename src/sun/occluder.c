/* Depth and coverage: finds the samples that are surfaces, the visible share of
 * a light behind them, and the kinds of samples that a plane holds. */
#include "sun/occluder.h"

#include "core/cpu.h"
#include "core/parallel.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>

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

struct gp_sun_pixel gp_occluders_at(const struct gp_occluders *o, int x, int y)
{
    struct gp_sun_pixel p = {INFINITY, 0.0f};
    const float *const z = has(o->depth) ? sample_at(o->depth, x, y) : NULL;
    if (z && gp_is_surface(o->surfaces, *z)) {
        p.place = gp_surface_place(o->type, o->facts.reversed, *z);
        p.cover = 1.0f;
    }
    if (has(o->mask)) {
        const float *const m = sample_at(o->mask, x, y);
        p.cover = m ? clamped(*m) : 0.0f;
    }
    return p;
}

double gp_occluders_show(const struct gp_occluders *o,
                         const struct gp_light *l, int x, int y, bool *beyond)
{
    const struct gp_sun_pixel p = gp_occluders_at(o, x, y);
    const bool past = !isinf(p.place) && !hides(l, p.place);
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

/* Parts are the same for any number of threads. */
enum { BANDS = 64 };

/* The kinds in a share of the rows, and the least and most of the huge ones. */
struct kinds {
    int are;
    float lo, hi;
};

struct looking {
    const struct gp_plane *plane;
    struct gp_depth_range fore, back;
    struct kinds band[BANDS];
};

GP_CLONES static int kinds_of(const struct looking *s, const float *v, int n)
{
    const struct gp_depth_range f = s->fore, b = s->back;
    int are = 0;
    for (int i = 0; i < n; i++) {
        const float x = v[i], size = fabsf(x);
        const bool huge = size >= GP_DEPTH_HUGE && size < INFINITY;
        const bool under = (x < 0.0f) & (size < GP_DEPTH_HUGE) &
                           (size != GP_DEPTH_HALF);
        are |= (x == 0.0f ? ZERO : 0) | (x != x ? NOT_A_NUMBER : 0) |
               (size == INFINITY ? INFINITE : 0) | (huge ? HUGE_ONE : 0) |
               (size == GP_DEPTH_HALF ? HALF_MAX : 0) |
               (under ? NEGATIVE : 0) | (x == 1.0f ? ONE : 0) |
               (x > 1.0f ? OVER : 0) |
               ((x > 0.0f) & (x < f.lo) ? TINY : 0) |
               (gp_is_surface(f, x) ? FORE : 0) |
               (gp_is_surface(b, x) ? BACK : 0);
    }
    return are;
}

static void look_at_band(void *ctx, int i, int thread)
{
    (void) thread;
    struct looking *const s = ctx;
    struct kinds *const t = &s->band[i];
    const int64_t h = gp_rect_h(s->plane->window);
    const int w = gp_rect_w(s->plane->window);
    *t = (struct kinds) {0, INFINITY, -INFINITY};
    for (int64_t y = h * i / BANDS; y < h * (i + 1) / BANDS; y++) {
        const float *const v = s->plane->v + (size_t) y * (size_t) w;
        const int are = kinds_of(s, v, w);
        t->are |= are;
        for (int x = 0; x < w && are & HUGE_ONE; x++) {
            const float size = fabsf(v[x]);
            if (size >= GP_DEPTH_HUGE && size < INFINITY) {
                t->lo = fminf(t->lo, v[x]);
                t->hi = fmaxf(t->hi, v[x]);
            }
        }
    }
}

void gp_occluders_count(struct gp_occluders *o)
{
    o->facts = (struct gp_depth_facts) {.empty = "none"};
    if (!has(o->depth) || gp_rect_empty(o->depth->window))
        return;
    struct looking s = {.plane = o->depth,
                        .fore = gp_depth_range_of(o->type, false),
                        .back = gp_depth_range_of(o->type, true)};
    struct kinds t = {0, INFINITY, -INFINITY};
    gp_parallel_do(BANDS, look_at_band, &s);
    for (int i = 0; i < BANDS; i++) {
        t.are |= s.band[i].are;
        t.lo = fminf(t.lo, s.band[i].lo);
        t.hi = fmaxf(t.hi, s.band[i].hi);
    }
    struct gp_depth_facts *const f = &o->facts;
    const int are = t.are;
    const bool share = o->type == GP_DEPTH_NORMALIZED;
    const bool axis = o->type == GP_DEPTH_Z || o->type == GP_DEPTH_RAY;
    if (share)
        f->reversed = !(are & (ONE | OVER)) && are & ZERO;
    else if (axis)
        f->reversed = !(are & FORE) && are & BACK;
    o->surfaces = f->reversed ? s.back : s.fore;

    // the kinds of empty samples that occur
    char huge[32]; // one, or from the least to the most
    if (t.lo == t.hi)
        snprintf(huge, sizeof huge, "%g", (double) t.lo);
    else
        snprintf(huge, sizeof huge, "%g to %g", (double) t.lo, (double) t.hi);
    const bool first = !share || f->reversed; // 0 and less is empty
    const struct {
        int is;
        const char *text;
    } kind[] = {
        {first ? ZERO : 0, "0"},
        {TINY, "under 1e-09"},
        {first && !(axis && f->reversed) ? NEGATIVE : 0, "negative"},
        {share ? ONE : 0, "1"},
        {share ? OVER : 0, "over 1"},
        {axis ? HALF_MAX : 0, f->reversed ? "-65504" : "65504"},
        {axis ? HUGE_ONE : 0, huge},
        {axis ? INFINITE : 0, "inf"},
        {NOT_A_NUMBER, "nan"},
    };
    size_t used = 0;
    for (size_t i = 0; i < sizeof kind / sizeof *kind; i++) {
        if (are & kind[i].is && used < sizeof f->empty)
            used += (size_t) snprintf(f->empty + used, sizeof f->empty - used,
                                      "%s%s", used ? ", " : "", kind[i].text);
    }
}
