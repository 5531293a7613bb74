// SPDX-License-Identifier: Apache-2.0
/* Chooses an engine. */
#include "core/parallel.h"
#include "glare/direct/direct.h"
#include "glare/glare_priv.h"
#include "glare/sky/sky.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { DIRECT, FFT }; // in gp_engines
const struct gp_engine *const gp_engines[] = {
    &gp_engine_direct, &gp_engine_fft, &gp_engine_splat, NULL,
};

/* Tests whether the sum as it is written takes no longer than a transform, of as many
 * points along each axis as the sources' box and the kernel have: as many products as 60
 * for each point, and 1e7 for the set-up, take as long (at 2.5 GHz with AVX2, one core:
 * 0.24 ns a product). */
static bool is_handful(const struct gp_sources *s, const struct gp_kernel *k)
{
    const double across = gp_rect_w(s->box) + fmin(k->w, s->w);
    const double down = gp_rect_h(s->box) + fmin(k->h, s->h);
    const double most = 60.0 * across * down + 1e7;
    return (double) s->n * k->w * k->h <= most ||
           gp_direct_work(s, k->w, k->h, k->cx, k->cy, most) <= most;
}

double gp_sum_seconds(const struct gp_glare_request *req)
{
    // CPU seconds of a product, and of a pair by true angles, at 2.5 GHz with AVX2:
    // 1.1e-10 where a sky's sources are side by side, 2.1e-10 where 4622 are spread
    static const double PRODUCT_S = 1.5e-10, PAIR_S = 1.0e-7;
    const struct gp_sources *const s = req->src;
    const struct gp_kernel *const k = req->kernel;
    const double pairs = k->sky ? (double) s->n * s->w * s->h : 0.0;
    return (PRODUCT_S * gp_direct_work(s, k->w, k->h, k->cx, k->cy, INFINITY) +
            PAIR_S * pairs) /
           gp_threads();
}

// -- bounds -------------------------------------------------------------------

gp_status gp_plan_pixel(const struct gp_glare_request *req, struct gp_glare *g,
    int engine, const struct gp_pixel_floor *floor, double *bound)
{
    const struct gp_engine *const e = gp_engines[engine];
    struct gp_pixel_error error = {.relative = INFINITY};
    // levels guarantee nothing of one pixel
    gp_status st = e->pixel && (!req->kernel->sky || req->exact)
                       ? e->pixel(req, &g->state[engine], &error)
                       : GP_OK;
    *bound = st ? INFINITY
                : gp_pixel_bound(floor, &error, (double) req->params->gain);
    return st;
}

static gp_status find_bounds(const struct gp_glare_request *req,
    struct gp_glare *g, const struct gp_pixel_floor *floor, struct gp_choice *c)
{
    struct gp_glare_request asked = *req;
    asked.in_double = c->in_double;
    gp_status st = gp_engines[c->engine]->bound(&asked, &g->state[c->engine],
                                                &c->bound);
    c->bound += req->floor;
    if (!st && req->params->tolerance_pixel > 0.0f)
        st = gp_plan_pixel(&asked, g, c->engine, floor, &c->pixel);
    return st;
}

static bool pixel_is_over(const struct gp_glare_params *p,
                          const struct gp_choice *c)
{
    return c->pixel > (double) p->tolerance_pixel;
}

static bool is_within(const struct gp_glare_params *p,
                      const struct gp_choice *c)
{
    return c->bound <= (double) p->tolerance && !pixel_is_over(p, c);
}

/* The bound of rel_l2, or what is over the tolerance by the same factor as a
 * pixel's bound is over its own. */
static double worse_bound(const struct gp_glare_params *p,
                          const struct gp_choice *c)
{
    return pixel_is_over(p, c)
               ? fmax(c->bound, (double) p->tolerance * c->pixel /
                                    (double) p->tolerance_pixel)
               : c->bound;
}

/* Fills the bounds of an engine; of fft in double where float is over
 * tolerance_pixel, and double is not or is far less so. */
static gp_status find_choice(const struct gp_glare_request *req,
    struct gp_glare *g, const struct gp_pixel_floor *floor, int engine,
    struct gp_choice *out)
{
    static const double FAR_LESS = 0.1;
    struct gp_choice c = {.engine = engine, .in_double = true};
    *out = (struct gp_choice) {.engine = engine,
                               .in_double = req->params->in_double};
    gp_status st = find_bounds(req, g, floor, out);
    if (st || engine != FFT || !pixel_is_over(req->params, out))
        return st;
    st = find_bounds(req, g, floor, &c);
    if (!pixel_is_over(req->params, &c) || c.pixel < FAR_LESS * out->pixel)
        *out = c;
    return st;
}

/* Takes `direct` of the kernel with its far field, sample by sample, where that
 * keeps the tolerances, or leaves less than half of what is over them. */
static gp_status try_whole(const struct gp_glare_request *req,
    struct gp_glare *g, const struct gp_pixel_floor *floor,
    struct gp_choice *out)
{
    static const double MOST = 1 << 28; // samples: 3 GiB
    const struct gp_sources *const src = req->src;
    struct gp_glare_request whole = *req;
    struct gp_pixel_floor own = *floor;
    struct gp_choice c = {.engine = DIRECT, .whole = true};
    if ((2.0 * src->w - 1.0 + 2.0 * GP_TAPS_PAD) * (2.0 * src->h - 1.0) > MOST)
        return GP_OK;
    // the layer of the core is no more than that of the whole
    whole.exact = true;
    whole.far = NULL;
    memset(own.far, 0, sizeof own.far);
    gp_status st = gp_error_floor_find(&whole, &whole.floor);
    if (!st)
        st = find_bounds(&whole, g, &own, &c);
    if (!st && (is_within(req->params, &c) ||
                2.0 * worse_bound(req->params, &c) <
                    worse_bound(req->params, out)))
        *out = c;
    return st;
}

// -- in words -----------------------------------------------------------------

static const char *drawn_by(const struct gp_glare_request *req,
                            const struct gp_choice *c)
{
    return req->kernel->sky && !c->whole ? gp_sky_facts(req->kernel->sky)->way
                                         : gp_engines[c->engine]->name;
}

/* "fft for 21874 sources, bound 2e-05". */
static void explain(const struct gp_glare_request *req,
                    const struct gp_choice *c)
{
    static const char *const OVER = ", the lowest there is, over %.2g";
    const struct gp_glare_params *const p = req->params;
    const char *const name = drawn_by(req, c);
    char over[64] = "", pixel[64] = "", pixel_over[64] = "";
    if (!(c->bound <= (double) p->tolerance))
        snprintf(over, sizeof over,
                 strcmp(name, "levels") == 0 // sums of all pairs have less
                     ? ", over %.2g"
                     : OVER,
                 (double) p->tolerance);
    if (c->pixel > 0.0)
        snprintf(pixel, sizeof pixel, ", %.2g in a pixel", c->pixel);
    if (pixel_is_over(p, c))
        snprintf(pixel_over, sizeof pixel_over, OVER,
                 (double) p->tolerance_pixel);
    snprintf(req->stats->why, sizeof req->stats->why,
             "%s%s for %zu source%s, bound %.2g%s%s%s", name,
             c->whole && req->kernel->sky ? " by true angles"
             : c->whole                   ? " of the whole kernel"
             : c->in_double               ? " in double"
                                          : "",
             req->src->n, req->src->n == 1 ? "" : "s", c->bound, over, pixel,
             pixel_over);
}

static void warn(const struct gp_glare_request *req, const char *path,
                 const struct gp_choice *c)
{
    const struct gp_glare_params *const p = req->params;
    const char *const name = drawn_by(req, c);
    if (c->bound <= (double) p->tolerance)
        gp_say_at(req->log, GP_LEVEL_WARN, "layer.tolerance_pixel",
                  "%s: no engine guarantees a tolerance of %.3g in a pixel (the "
                  "lowest bound is %.2g, of %s, which runs)", path,
                  (double) p->tolerance_pixel, c->pixel, name);
    else if (strcmp(name, "levels") == 0)
        gp_say_at(req->log, GP_LEVEL_WARN, "layer.levels",
                  "%s: levels guarantee no tolerance of %.3g (their bound is "
                  "%.2g), and direct sums take some %.2g s",
                  path, (double) p->tolerance, c->bound, gp_sum_seconds(req));
    else
        gp_say_at(req->log, GP_LEVEL_WARN, "layer.tolerance",
                  "%s: no engine guarantees a tolerance of %.3g (the lowest "
                  "bound is %.2g, of %s, which runs)", path,
                  (double) p->tolerance, c->bound, name);
}

gp_status gp_plan(const struct gp_glare_request *req, struct gp_glare *g,
    const char *path, const struct gp_pixel_floor *floor, struct gp_choice *out)
{
    const struct gp_glare_params *const p = req->params;
    const int first = is_handful(req->src, req->kernel) ? DIRECT : FFT;
    struct gp_choice other;
    gp_status st = find_choice(req, g, floor, first, out);
    if (!st && !is_within(p, out)) {
        st = find_choice(req, g, floor, DIRECT + FFT - first, &other);
        if (!st && (is_within(p, &other) ||
                    worse_bound(p, &other) < worse_bound(p, out)))
            *out = other;
    }
    // pairs by true angles: of a lone lamp, which has no other's light to hide what
    // levels leave of its veil; and those that take some seconds
    static const double AT_ONCE = 2e5, SECONDS = 2e7, NEAR = 3e4;
    const double pixels = (double) req->src->w * req->src->h + NEAR;
    const double pairs =
        req->kernel->sky ? (double) req->src->n * pixels : (double) INFINITY;
    if (!st && (pairs <= AT_ONCE ||
                (!is_within(p, out) && (req->far || pairs <= SECONDS))))
        st = try_whole(req, g, floor, out);
    if (st)
        return st;
    explain(req, out);
    if (!is_within(p, out) && !g->warned)
        warn(req, path, out);
    g->warned |= !is_within(p, out);
    return GP_OK;
}
