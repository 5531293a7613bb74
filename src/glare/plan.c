/* Chooses an engine. */
#include "core/minmax.h"
#include "glare/costs.h"
#include "glare/direct/direct.h"
#include "glare/glare_priv.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

const struct gp_engine *const gp_engines[] = {
    &gp_engine_direct, &gp_engine_fft, &gp_engine_splat, NULL,
};

/* A technique that takes less than this share of the old one's time is worth a
 * change. */
static const double GAIN = 0.8;

/* Counting an engine's work stops at this many times another's time. */
static const double ENOUGH = 2.0;

// -- the choice ---------------------------------------------------------------

enum { LONGEST_WAIT = 32 }; // frames

struct asking {
    struct gp_candidate *c;
    struct gp_plan_past *past;
    double tolerance, exact_ms; // the fewest of an exact candidate
    gp_plan_ask ask;
    void *ctx;
    int order[GP_CANDIDATES]; // by ms, only those of finite ms
    int count;
};

static gp_status ask_bound(struct asking *a, int i)
{
    struct gp_candidate *const c = &a->c[i];
    struct gp_plan_refusal *const r = &a->past->refused[i];
    if (!isnan(c->bound))
        return GP_OK;
    gp_status st = a->ask(a->ctx, i, &c->bound);
    if (isnan(c->bound))
        c->bound = INFINITY;
    if (st || c->bound <= a->tolerance) {
        *r = (struct gp_plan_refusal) {0};
    } else if (!c->exact) {
        r->wait = r->wait ? gp_min(2 * r->wait, LONGEST_WAIT) : 2;
        r->left = r->wait;
        r->share = c->later_ms / a->exact_ms;
    }
    return st;
}

/* Tests whether candidate i was refused not long ago, and would be again: its
 * bound is that of frames much like this one. */
static bool waits(const struct asking *a, int i)
{
    const struct gp_plan_refusal *const r = &a->past->refused[i];
    return r->left > 0 && a->c[i].later_ms / a->exact_ms > GAIN * r->share;
}

/* Finds the first in order, exact or not, of less than `ms` that keeps the
 * tolerance; -1: none. */
static gp_status first_within(struct asking *a, bool exact, double ms,
                              int *found)
{
    *found = -1;
    for (int k = 0; k < a->count; k++) {
        const int i = a->order[k];
        if (a->c[i].exact != exact || !(a->c[i].ms < ms) || waits(a, i))
            continue;
        ms = fmin(ms, *found < 0 ? INFINITY : a->c[*found].ms);
        gp_status st = a->c[i].ms < ms ? ask_bound(a, i) : GP_OK;
        if (st)
            return st;
        // asking may have made it slower: fft in double
        if (a->c[i].bound <= a->tolerance &&
            (*found < 0 || a->c[i].ms < a->c[*found].ms))
            *found = i;
    }
    return GP_OK;
}

/* Finds the first choice: an approximation only where it is worth its bound,
 * which takes time and may be over the tolerance; -1: none. */
static gp_status find_fastest(struct asking *a, int *found)
{
    int other;
    // approximations round too: where no exact engine keeps the tolerance, none
    // of them does
    gp_status st = first_within(a, true, INFINITY, found);
    if (st || *found < 0)
        return st;
    st = first_within(a, false, GAIN * a->c[*found].ms, &other);
    *found = other < 0 ? *found : other;
    return st;
}

/* Sets *may when a change from `last` to candidate i stays within the
 * tolerance. */
static gp_status may_follow(struct asking *a, int last, int i, bool *may)
{
    gp_status st = ask_bound(a, i);
    *may = !st && a->c[last].bound + a->c[i].bound <= a->tolerance;
    return st;
}

/* Chooses between `last` and `fastest`, which both keep the tolerance, and the
 * rival that would have saved enough time by now. */
static gp_status choose_next(struct asking *a, int last, int fastest,
                            int *taken)
{
    struct gp_plan_past *const past = a->past;
    bool may = false, refused[GP_CANDIDATES] = {false};
    *taken = last;
    if (a->c[fastest].ms < GAIN * a->c[last].ms) {
        gp_status st = may_follow(a, last, fastest, &may);
        if (st || may) {
            *taken = fastest;
            return st;
        }
    }
    // the rival: least later_ms, under `last`'s ms, of those that may follow it
    int rival = last;
    while (!may) {
        rival = -1;
        for (int k = 0; k < a->count; k++) {
            const int i = a->order[k];
            const double most = // ms that are worth asking for its bound
                a->c[i].exact ? a->c[last].ms : GAIN * a->c[last].ms;
            if (i != last && !refused[i] && !waits(a, i) &&
                a->c[i].later_ms < most &&
                (rival < 0 || a->c[i].later_ms < a->c[rival].later_ms))
                rival = i;
        }
        gp_status st = rival < 0 ? GP_OK : may_follow(a, last, rival, &may);
        if (st || rival < 0) {
            past->rival = 0;
            return st;
        }
        refused[rival] = true;
    }
    const struct gp_candidate *const old = &a->c[last], *const c = &a->c[rival];
    if (past->rival != rival + 1)
        past->lost = 0.0;
    past->rival = rival + 1;
    past->lost += old->ms - c->later_ms;
    if (past->lost > c->ms - c->later_ms + old->ms)
        *taken = rival;
    return GP_OK;
}

gp_status gp_plan_choose(struct gp_candidate *c, int n, double tolerance,
                         struct gp_plan_past *past, gp_plan_ask ask, void *ctx,
                         struct gp_choice *out)
{
    struct asking a = {
        .c = c, .past = past, .tolerance = tolerance, .exact_ms = INFINITY,
        .ask = ask, .ctx = ctx,
    };
    int fastest, taken;
    // fewest ms first; of equals, the first in the list
    for (int i = 0; i < n; i++) {
        if (!(c[i].ms < INFINITY)) // NAN too
            continue;
        int at = a.count++;
        for (; at > 0 && c[a.order[at - 1]].ms > c[i].ms; at--)
            a.order[at] = a.order[at - 1];
        a.order[at] = i;
        if (c[i].exact)
            a.exact_ms = fmin(a.exact_ms, c[i].ms);
        past->refused[i].left -= past->refused[i].left > 0;
    }
    gp_status st = find_fastest(&a, &fastest);
    const bool within = fastest >= 0;
    if (st)
        return st;
    taken = fastest;
    for (int k = 0; k < a.count && !within; k++) { // the least exact bound
        const int i = a.order[k];
        if (c[i].exact && (taken < 0 || c[i].bound < c[taken].bound))
            taken = i;
    }
    const int last = past->last - 1;
    if (within && last >= 0 && last < n && c[last].ms < INFINITY) {
        st = ask_bound(&a, last);
        if (!st && c[last].bound <= tolerance)
            st = choose_next(&a, last, fastest, &taken);
    }
    if (st)
        return st;
    if (taken != last) {
        past->rival = 0;
        past->lost = 0.0;
    }
    past->last = taken + 1;
    *out = (struct gp_choice) {
        .taken = taken, .within = within,
        .kept = taken == last && taken != fastest && within,
    };
    return GP_OK;
}

// -- the candidates -----------------------------------------------------------

static struct gp_prediction
predict(const struct gp_glare_request *req, const struct gp_glare *g,
        int engine, const struct gp_splat_params *splat, double enough)
{
    struct gp_glare_params params = *req->params;
    struct gp_glare_request asked = *req;
    params.splat = *splat;
    asked.params = &params;
    asked.enough = enough;
    return gp_engines[engine]->predict(&asked, g->state[engine]);
}

static bool is_splat(int engine)
{
    return gp_engines[engine] == &gp_engine_splat;
}

int gp_plan_candidates(const struct gp_glare_request *req,
                       const struct gp_glare *g,
                       struct gp_candidate c[GP_CANDIDATES])
{
    static const struct { int group, cluster; bool shrink; } setting[] = {
        {8, 16, true}, {8, 16, false}, {4, 8, true}, {4, 8, false},
        {2, 4, true},  {2, 4, false},  {1, 0, true}, {1, 0, false},
    };
    enum { SETTINGS = sizeof setting / sizeof *setting };
    const struct gp_glare_params *const asked = req->params;
    const struct gp_tail *const tail = req->kernel->tail;
    const double later = tail ? gp_tail_ms(tail, req->src) : 0.0;
    const double first = tail ? later + gp_tail_open_ms(tail, g->tail) : 0.0;
    int n = 0;
    double least = INFINITY;
    for (int i = 0; gp_engines[i] && !is_splat(i); i++) {
        const double enough = n ? ENOUGH * least : 0.0;
        const struct gp_prediction p =
            predict(req, g, i, &asked->splat, enough);
        c[n++] = (struct gp_candidate) {
            .engine = i, .splat = asked->splat, .exact = true,
            .bound = NAN, .ms = p.ms, .later_ms = p.later_ms, .more = p.more,
        };
        least = fmin(least, p.ms);
    }
    // splat, last of the engines: as given, then from the coarsest setting to
    // the exact one. Finer groups are more polygons: where the coarsest takes
    // longer than another engine, so do the rest, which are then not counted.
    // Opening a context counts in full: frames to come may not repay it
    const int splat = n;
    for (int i = 0; i <= SETTINGS; i++) {
        struct gp_splat_params s = asked->splat;
        struct gp_prediction p = {.ms = INFINITY};
        if (i > 0) {
            s.group = setting[i - 1].group;
            s.cluster = setting[i - 1].cluster;
            s.shrink = setting[i - 1].shrink ? asked->tolerance / 2.0f : 0.0f;
        }
        const bool counted = i < 2 || c[splat + 1].ms < least;
        if (counted)
            p = predict(req, g, splat, &s, ENOUGH * least);
        c[n++] = (struct gp_candidate) {
            .engine = splat, .splat = s, .bound = NAN,
            .exact = counted && s.group == 1 && s.cluster == 0 &&
                     !(s.shrink > 0.0f),
            .ms = p.ms, .later_ms = p.ms, .more = p.more,
        };
    }
    // the tail is the same for all. A kernel that was another in the frame
    // before will be another in the next: its set-up comes back
    const bool moves = g->past.kernel && g->past.kernel != req->kernel->serial;
    for (int i = 0; i < n; i++) {
        c[i].ms += first;
        c[i].later_ms = moves ? c[i].ms : c[i].later_ms + later;
    }
    return n;
}

// -- in words -----------------------------------------------------------------

struct words {
    char *at;
    size_t room;
};

__attribute__((format(printf, 2, 3))) static void
add_words(struct words *w, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    const int n = vsnprintf(w->at, w->room, format, args);
    va_end(args);
    const size_t used =
        n < 0 ? 0 : (size_t) n < w->room ? (size_t) n : w->room - 1;
    w->at += used;
    w->room -= used;
}

/* "fft", "fft in double", "splat 4/8", "direct of the whole kernel". */
static void add_name(struct words *w, const struct gp_candidate *c)
{
    const struct gp_splat_params *const s = &c->splat;
    if (is_splat(c->engine))
        add_words(w, "%s %d/%d%s", gp_engines[c->engine]->name, s->group,
            s->cluster, s->shrink > 0.0f ? " shrunk" : "");
    else
        add_words(w, "%s%s", gp_engines[c->engine]->name,
                  c->whole        ? " of the whole kernel"
                  : c->fft_double ? " in double" : "");
}

// -- the plan -----------------------------------------------------------------

struct planning {
    const struct gp_glare_request *req;
    struct gp_glare *g;
    const struct gp_pixel_floor *floor;
    double rel_l2[GP_CANDIDATES]; // bounds that were asked
    struct gp_candidate c[GP_CANDIDATES];
};

gp_status gp_plan_pixel(const struct gp_glare_request *req, struct gp_glare *g,
    int engine, const struct gp_pixel_floor *floor, double *bound)
{
    const struct gp_engine *const e = gp_engines[engine];
    struct gp_pixel_error error = {.share = INFINITY};
    gp_status st = e->pixel ? e->pixel(req, &g->state[engine], &error) : GP_OK;
    *bound = st ? INFINITY
                : gp_pixel_bound(floor, &error, (double) req->params->gain);
    return st;
}

/* Takes fft in double where what it would choose is over tolerance_pixel, and
 * double is not or is far less so; `params` are those of `req`. */
static gp_status ask_double(struct planning *p, struct gp_glare_params *params,
                            const struct gp_glare_request *req, int i)
{
    static const double FAR_LESS = 0.1;
    struct gp_candidate *const c = &p->c[i];
    double bound, pixel;
    params->fft_double = true;
    gp_status st = gp_plan_pixel(req, p->g, c->engine, p->floor, &pixel);
    if (st || !(pixel <= (double) params->tolerance_pixel ||
                pixel < FAR_LESS * c->pixel))
        return st;
    st = gp_engine_fft.bound(req, &p->g->state[c->engine], &bound);
    const struct gp_prediction ms =
        predict(req, p->g, c->engine, &c->splat, 0.0);
    c->fft_double = true;
    c->pixel = pixel;
    c->ms = ms.ms;
    c->later_ms = ms.later_ms;
    p->rel_l2[i] = bound + req->floor;
    return st;
}

static gp_status ask_engine(void *ctx, int i, double *bound)
{
    struct planning *const p = ctx;
    struct gp_candidate *const c = &p->c[i];
    struct gp_glare_params params = *p->req->params;
    struct gp_glare_request req = *p->req;
    params.splat = c->splat;
    req.params = &params;
    const double most = (double) params.tolerance_pixel;
    *bound = INFINITY;
    if (!gp_engines[c->engine]->bound ||
        (most > 0.0 && !gp_engines[c->engine]->pixel))
        return GP_OK;
    gp_status st = gp_engines[c->engine]->bound(
        &req, &p->g->state[c->engine], bound);
    *bound += req.floor;
    p->rel_l2[i] = *bound;
    if (st || !(most > 0.0))
        return st;
    st = gp_plan_pixel(&req, p->g, c->engine, p->floor, &c->pixel);
    if (!st && c->pixel > most && gp_engines[c->engine] == &gp_engine_fft)
        st = ask_double(p, &params, &req, i);
    *bound = p->rel_l2[i];
    if (c->pixel > most) // over the tolerance by the same factor
        *bound = fmax(*bound, (double) params.tolerance * c->pixel / most);
    return st;
}

/* Predicts and bounds `direct` with the kernel's tail at full rate. ms is
 * INFINITY where such a kernel takes too much memory. */
static gp_status ask_whole(const struct gp_glare_request *req,
    struct gp_glare *g, const struct gp_pixel_floor *floor,
    struct gp_candidate *out)
{
    static const double MOST = 1 << 28; // samples: 3 GiB
    const struct gp_sources *const src = req->src;
    struct gp_glare_request whole = *req;
    struct gp_kernel k = *req->kernel;
    struct gp_pixel_floor own = *floor;
    struct gp_candidate c = {
        .splat = req->params->splat, .exact = true, .whole = true,
        .ms = INFINITY, .later_ms = INFINITY, .bound = INFINITY,
    };
    double lost;
    while (gp_engines[c.engine] != &gp_engine_direct)
        c.engine++;
    k.w = 2 * src->w - 1;
    k.h = 2 * src->h - 1;
    k.cx = src->w - 1;
    k.cy = src->h - 1;
    k.lit = NULL;
    k.serial = g->whole_of == k.serial ? g->whole.serial : 0;
    *out = c;
    if ((k.w + 2.0 * GP_TAPS_PAD) * k.h > MOST)
        return GP_OK;
    // the layer of the core is no more than that of the whole
    whole.tail = NULL;
    gp_status st = gp_floor_find(&whole, &g->floor, &lost);
    whole.kernel = &k;
    memset(own.tail, 0, sizeof own.tail);
    const struct gp_prediction p = predict(&whole, g, c.engine, &c.splat, 0.0);
    c.ms = p.ms;
    c.later_ms = p.later_ms;
    if (!k.serial)
        c.ms += (GP_COST_WHOLE_SAMPLE +
                 GP_COST_FRESH_BYTE * 3.0 * sizeof(float)) * k.w * k.h;
    if (!st)
        st = gp_engines[c.engine]->bound(&whole, &g->state[c.engine], &c.bound);
    c.bound += lost;
    if (!st && req->params->tolerance_pixel > 0.0f)
        st = gp_plan_pixel(&whole, g, c.engine, &own, &c.pixel);
    *out = c;
    return st;
}

/* Takes `direct` of the whole kernel where only that keeps the tolerances. */
static gp_status try_whole(const struct gp_glare_request *req,
    struct gp_glare *g, const char *path, const struct gp_pixel_floor *floor,
    struct gp_choice *choice, struct gp_candidate *out)
{
    static const double LONG_MS = 20e3;
    const struct gp_glare_params *const asked = req->params;
    struct gp_candidate c;
    gp_status st = ask_whole(req, g, floor, &c);
    if (st || !(c.ms < INFINITY) || !(c.bound <= (double) asked->tolerance) ||
        (asked->tolerance_pixel > 0.0f &&
         !(c.pixel <= (double) asked->tolerance_pixel)))
        return st;
    *out = c;
    *choice = (struct gp_choice) {.taken = -1, .within = true};
    g->past.last = 0; // no other is held against it in the next frame
    if (c.ms > LONG_MS && !g->past.warned) {
        g->past.warned = true;
        gp_say(req->log, GP_LEVEL_WARN, "%s: only --engine direct guarantees "
               "--tolerance %.3g, in about %.0f s for %zu sources; a larger "
               "tolerance is faster", path, (double) asked->tolerance,
               c.ms * 1e-3, req->src->n);
    }
    return GP_OK;
}

gp_status gp_plan(const struct gp_glare_request *req, struct gp_glare *g,
                  const char *path, const struct gp_pixel_floor *floor,
                  struct gp_candidate *out)
{
    struct planning p = {.req = req, .g = g, .floor = floor};
    struct gp_choice choice;
    const double tolerance = (double) req->params->tolerance;
    struct gp_plan_past *const past = &g->past;
    const int n = gp_plan_candidates(req, g, p.c);
    if (past->kernel != req->kernel->serial || past->w != req->src->w ||
        past->h != req->src->h || past->tolerance != tolerance)
        memset(past->refused, 0, sizeof past->refused);
    gp_status st = gp_plan_choose(p.c, n, tolerance, past, ask_engine, &p,
                                  &choice);
    if (st)
        return st;
    past->kernel = req->kernel->serial;
    past->w = req->src->w;
    past->h = req->src->h;
    past->tolerance = tolerance;
    *out = p.c[choice.taken];
    const bool pixel = out->bound > p.rel_l2[choice.taken];
    out->bound = p.rel_l2[choice.taken];
    if (!choice.within && req->tail)
        st = try_whole(req, g, path, floor, &choice, out);
    if (st)
        return st;

    // names every candidate whose bound was asked, the exact engines, and the
    // fastest splat: "fft 9.8 ms of bound 2e-05; direct 31, splat 8/16 5.2e+03"
    struct words w = {req->stats->why, sizeof req->stats->why};
    int splat = -1;
    for (int i = 0; i < n; i++) {
        if (is_splat(p.c[i].engine) && p.c[i].ms < INFINITY &&
            (splat < 0 || p.c[i].ms < p.c[splat].ms))
            splat = i;
    }
    add_name(&w, out);
    add_words(&w, " %.3g ms of bound %.2g", out->ms, out->bound);
    if (!choice.within && !pixel)
        add_words(&w, ", the lowest there is, over %.2g", tolerance);
    if (out->pixel > 0.0)
        add_words(&w, ", %.2g in a pixel", out->pixel);
    if (!choice.within && pixel)
        add_words(&w, ", the lowest there is, over %.2g",
                  (double) req->params->tolerance_pixel);
    if (choice.kept)
        add_words(&w, ", as before");
    const char *between = "; ";
    for (int i = 0; i < n; i++) {
        const struct gp_candidate *const c = &p.c[i];
        if (i == choice.taken || !(c->ms < INFINITY) ||
            (is_splat(c->engine) && isnan(c->bound) && i != splat))
            continue;
        add_words(&w, "%s", between);
        add_name(&w, c);
        add_words(&w, c->more ? " over %.3g" : " %.3g", c->ms);
        if (!isnan(c->bound) && !(p.rel_l2[i] <= tolerance))
            add_words(&w, " of bound %.2g", p.rel_l2[i]);
        if (c->pixel > (double) req->params->tolerance_pixel)
            add_words(&w, " of bound %.2g in a pixel", c->pixel);
        between = ", ";
    }
    if (!choice.within && !g->past.warned) {
        g->past.warned = true;
        if (pixel)
            gp_say(req->log, GP_LEVEL_WARN,
                   "%s: no engine guarantees --tolerance-pixel %.3g (the "
                   "lowest bound is %.2g, of %s, which runs); raise it", path,
                   (double) req->params->tolerance_pixel, out->pixel,
                   gp_engines[out->engine]->name);
        else
            gp_say(req->log, GP_LEVEL_WARN,
                   "%s: no engine guarantees --tolerance %.3g (the lowest "
                   "bound is %.2g, of %s, which runs); %sa larger tolerance "
                   "may be faster", path, tolerance, out->bound,
                   gp_engines[out->engine]->name,
                   req->kernel->tail ? "--engine direct sums the kernel "
                                       "without its coarse far part; " : "");
    }
    return GP_OK;
}
